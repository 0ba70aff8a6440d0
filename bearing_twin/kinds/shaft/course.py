"""How a shaft turns over time and what acts on it from outside: the scene's, or what is commanded in its place."""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.loading import SAME, Loading, apart
from bearing_twin.kinds.bearing.quasi_static.ball_equilibrium import COORDINATES
from bearing_twin.kinds.shaft.derived import course_of
from bearing_twin.kinds.shaft.parameters import ShaftScene


class CoursePart(NamedTuple):
    """A part of the course, since `begin` [s]: the shaft had turned by `angle` and turns with even acceleration.

    From outside acts `load` (5,) [N, N m] about the centre of mass, which grows by `growth` (5,) a second.
    """

    begin: float
    angle: float
    speed: float
    acceleration: float
    load: np.ndarray
    growth: np.ndarray


@inlined
def turned_to(part, time):
    """(angle, speed) of the shaft at `time` [s] of a part of its course."""
    passed = time - part.begin
    angle = part.angle + (part.speed + 0.5 * part.acceleration * passed) * passed
    return angle, part.speed + part.acceleration * passed


@inlined
def whirl_of(rotor, part, time, i):
    """Place, rate and acceleration of coordinate i in the whirl that the motion is counted from."""
    angle, speed = turned_to(part, time)
    cosine, sine = math.cos(angle), math.sin(angle)
    along = rotor.whirl[0, i] * cosine - rotor.whirl[1, i] * sine
    across = rotor.whirl[0, i] * sine + rotor.whirl[1, i] * cosine
    return along, -speed * across, -speed * speed * along - part.acceleration * across


@kernel
def add_unbalances(rotor, angle, speed, acceleration, out):
    """Adds m e (w^2 + w' across) of each unbalance to the loads (5,) on the shaft."""
    for n in range(len(rotor.unbalances)):
        place, size, azimuth = rotor.unbalances[n, 0], rotor.unbalances[n, 1], rotor.unbalances[n, 2]
        cosine, sine = math.cos(angle + azimuth), math.sin(angle + azimuth)
        x = size * (speed * speed * cosine + acceleration * sine)
        y = size * (speed * speed * sine - acceleration * cosine)
        out[0] += x
        out[1] += y
        out[3] -= place * y
        out[4] += place * x


@kernel
def outer_loads(rotor, part, time, angle, speed, out):
    """Loads (5,) on the shaft at `time` [s] but its weight: those from outside, and of the unbalances."""
    for i in range(COORDINATES):
        out[i] = part.load[i] + (time - part.begin) * part.growth[i]
    add_unbalances(rotor, angle, speed, part.acceleration, out)


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
        """The parts (n, PART) from the one at `since` [s] to the first that begins after `until`, see `CoursePart`."""
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
