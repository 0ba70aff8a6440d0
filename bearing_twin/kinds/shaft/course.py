"""How a shaft turns over time and what acts on it from outside: the scene's, or what is commanded in its place."""

import math

import numpy as np

from bearing_twin.kinds.bearing.system import SAME, Loading, RingDrive, apart
from bearing_twin.kinds.shaft.parameters import ShaftDrive, ShaftScene


def course_of(drive: ShaftDrive, now=0.0, angle=0.0, speed=None, goal=None) -> list[tuple[float, RingDrive]]:
    """From when on [s] the shaft turns how: `RingDrive`, whose angle is that at this time; in the order of time.

    At `now` it has turned by `angle` [rad], has `speed` [rad/s] and is told to go to `goal`, all by default as at the
    start. A change of the drive that comes later is added to the goal.
    """
    speed = float(drive.speed if speed is None else speed)
    goals = [(now, speed if goal is None else float(goal))]
    if drive.change.time > now and drive.change.speed:
        goals.append((drive.change.time, goals[0][1] + drive.change.speed))
    course, ends = [(now, RingDrive(angle, speed, 0.0))], [when for when, _ in goals[1:]]
    for (begin, wanted), end in zip(goals, [*ends, math.inf], strict=True):
        since, last = course[-1]
        passed = begin - since
        angle = last.angle + (last.speed + 0.5 * last.acceleration * passed) * passed
        speed = last.speed + last.acceleration * passed
        missing = wanted - speed
        lasts = abs(missing) / drive.acceleration
        if passed == 0.0:
            course.pop()
        course.append((begin, RingDrive(angle, speed, math.copysign(drive.acceleration, missing) if missing else 0.0)))
        if missing and begin + lasts < end:
            course.append((begin + lasts, RingDrive(angle + (speed + 0.5 * missing) * lasts, wanted, 0.0)))
    return course


def speeds_of(parameters: ShaftScene) -> tuple[float, ...]:
    """The speeds [rad/s] between which the shaft turns in its run: the scene's, and that at the end after a change."""
    end, found = parameters.run.duration, [parameters.drive.speed]
    for begin, drive in course_of(parameters.drive)[1:]:
        if begin < end:
            lasts = min(end - begin, abs(parameters.drive.change.speed) / parameters.drive.acceleration)
            found[1:] = [drive.speed + drive.acceleration * lasts]
    return tuple(found)


def about_centre(place: float, load) -> np.ndarray:
    """A load (5,) at `place` [m] on the axis as one about the centre of mass."""
    x, y, z, about_x, about_y = load
    return np.array([x, y, z, about_x - place * y, about_y + place * x])


def constant_loads(parameters: ShaftScene) -> np.ndarray:
    """The loads (5,) of `shaft.loads` about the centre of mass, which no command replaces."""
    return sum((about_centre(place, load) for place, *load in parameters.shaft.loads), start=np.zeros(5))


def loads_of(parameters: ShaftScene, time: float) -> np.ndarray:
    """The scene's loads (5,) about the centre of mass at `time` [s], without weight and unbalances."""
    shaft = parameters.shaft
    return constant_loads(parameters) + about_centre(shaft.load_place, Loading(shaft).at(time)[0])


def unbalance_of(parameters: ShaftScene) -> np.ndarray:
    """The unbalances as one complex vector U (5,) [kg m, kg m^2]: their loads are Re((w^2 - i w') U exp(i angle))."""
    rows = [
        size * np.exp(1j * azimuth) * np.array([1.0, -1j, 0.0, 1j * place, place])
        for place, size, azimuth in parameters.shaft.unbalances
    ]
    return sum(rows, start=np.zeros(5, complex))


class ShaftCourse:
    """Speed and loads over time, in parts with even acceleration and evenly growing loads, from `now` [s] on.

    The shaft then has turned by `angle` [rad], turns at `speed` [rad/s] and is told to go to `goal`; `loading` acts at
    `shaft.load_place`. A command makes another course, so that a motion can go back to the one it had.
    """

    def __init__(self, parameters: ShaftScene, loading: Loading, now=0.0, angle=0.0, speed=None, goal=None):
        self._parameters, self.loading, self.now = parameters, loading, now
        self._steady, self.goal = constant_loads(parameters), float(parameters.drive.speed if goal is None else goal)
        self._turning = course_of(parameters.drive, now, angle, speed, goal)
        self.speeds = [drive.speed for _, drive in self._turning]
        self._turns = np.array([since for since, _ in self._turning])
        self._times = apart(self._turns, loading.times[loading.times > now])

    def goal_at(self, time: float) -> float:
        """The speed [rad/s] that the shaft is told to go to at `time` [s]."""
        change = self._parameters.drive.change
        return float(self.goal + (change.speed if self.now < change.time <= time else 0.0))

    def turned(self, time: float) -> tuple[float, float, float]:
        """Angle [rad], speed [rad/s] and acceleration at `time` [s] and, where a part begins there, after it."""
        since, drive = self._turning[int(np.searchsorted(self._turns, time * (1.0 + SAME), side="right")) - 1]
        passed = time - since
        angle = drive.angle + (drive.speed + 0.5 * drive.acceleration * passed) * passed
        return angle, drive.speed + drive.acceleration * passed, drive.acceleration

    def load_at(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Load (5,) about the centre of mass at `time` [s], and its rate, without weight and unbalances."""
        place = self._parameters.shaft.load_place
        load, rate = (about_centre(place, one) for one in self.loading.at(time))
        return self._steady + load, rate

    def rows(self, since: float, until: float) -> np.ndarray:
        """The parts (n, 14) from the one at `since` [s] to the first that begins after `until`.

        Each is begin [s], angle [rad], speed and acceleration of the shaft there, load (5,) and its rate (5,).
        """
        first = max(int(np.searchsorted(self._times, since, side="right")) - 1, 0)
        last = int(np.searchsorted(self._times, until, side="right"))
        return np.array(
            [np.concatenate([[time], self.turned(time), *self.load_at(time)]) for time in self._times[first : last + 1]]
        )

    def changes(self, since: float, until: float) -> bool:
        """True if a part begins after `since` [s] and not after `until`."""
        first, last = np.searchsorted(self._times, (since, until), side="right")
        return bool(last > first)

    def told(self, now: float, goal: float) -> "ShaftCourse":
        """That of a shaft that is told at `now` [s] to go to `goal` [rad/s]."""
        angle, speed, _ = self.turned(now)
        return ShaftCourse(self._parameters, self.loading, now, angle, speed, goal)

    def loaded(self, now: float, force, moment) -> "ShaftCourse":
        """That of a shaft with other loads from `now` [s] on, or the scene's own where both are None."""
        loading = Loading(self._parameters.shaft)
        if force is not None:
            loading.set(force, moment)
        angle, speed, _ = self.turned(now)
        return ShaftCourse(self._parameters, loading, now, angle, speed, self.goal_at(now))
