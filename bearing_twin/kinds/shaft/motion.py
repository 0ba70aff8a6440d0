"""A shaft on two bearings as a run: made from the scene, moved on, and what was found."""

import math

import numpy as np

from bearing_twin.base.errors import IntegrationError, Stopped
from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Columns, layout_of
from bearing_twin.base.stopping import SIGNALLED
from bearing_twin.kinds.bearing.loading import Loading
from bearing_twin.kinds.shaft import march
from bearing_twin.kinds.shaft.course import ShaftCourse, add_unbalances
from bearing_twin.kinds.shaft.modes import matrices_of, stiffest_mode, unbalance_response
from bearing_twin.kinds.shaft.operating import explained
from bearing_twin.kinds.shaft.outputs import channels
from bearing_twin.kinds.shaft.parameters import SETTLED, ShaftScene
from bearing_twin.kinds.shaft.rotor import BEARING_WORK, LOAD_WORK, MOVING, RATE, STATE, new_balls, new_moment
from bearing_twin.kinds.shaft.statics import balance_of, lever_of, longest_of, rotor_of
from bearing_twin.numerics.rosenbrock_step import rosenbrock_work
from bearing_twin.numerics.statuses import NOT_FINITE, OK, STALLED, STOPPED, TOO_DEEP, WORDS
from bearing_twin.numerics.steppers import RODAS4

SETTING = 0.01  # tolerance of a step over that of a ball's load
FINEST = 1e-11  # least tolerance of a step
FIRST, LEAST = 0.1, 1e-9  # of the stiffest mode's period over 2 pi: first step, least one
FAILURES = {
    NOT_FINITE: "the motion is not finite any more; lower speed and loads",
    STALLED: "ever shorter steps are needed; loosen wanted.tolerance, or lower speed and loads",
    TOO_DEEP: "a ball is squeezed too hard, or leaves the grooves; lower the loads, or keep away from a critical speed",
}
TURN, WHIRLING = 12, 4
"""Steps a turn at least: with 8 works are off by 1e-3 of all that an unbalance does either way; and where only what is
left beside the whirl is stepped."""
POWER = 1.5  # of a contact's load over its approach, nearly, whatever its law
SNAPPED = ("clock", "kept")  # arrays that a motion goes on from


class ShaftMotion:
    """The shaft in motion: `advance` integrates to the end of a chunk and returns its outputs."""

    longest_chunk = 0.1  # s: what a second run finds is compared once a chunk

    def __init__(self, parameters: ShaftScene, choice: Choice):
        self.parameters, self._law, self.stop = parameters, choice.law, SIGNALLED
        begin = balance_of(parameters, choice.law, float(parameters.drive.speed))
        self.rotor = rotor_of(parameters, choice.law, begin.ratios)
        self._begin = np.zeros(STATE)
        self._begin[:RATE] = begin.coordinates
        matrices = matrices_of(self.rotor, begin.stiffness)
        if parameters.shaft.start == SETTLED:
            response = unbalance_response(self.rotor, matrices, parameters.drive.speed)
            self.rotor = self.rotor._replace(whirl=np.stack([response.real, response.imag]))
        place, steady = self._begin[:RATE] + self.rotor.whirl[0], self.rotor.steady
        self._begin[LOAD_WORK], self._begin[BEARING_WORK] = -steady @ place, -(steady + self.rotor.weight) @ place
        self._fastest = stiffest_mode(matrices)
        self._closer = choice.finer
        squeeze = max(float(one.approach.sum(axis=1).max()) for one in begin.contacts)
        setting = max(SETTING * parameters.wanted.tolerance, FINEST)
        place = setting * squeeze / POWER  # [m], changes the greatest load by this share of it
        lever = lever_of(self.rotor)
        self._scales = place * np.array([1.0, 1.0, 1.0, 1.0 / lever, 1.0 / lever])
        self._furthest = longest_of(self.rotor) / np.array([1.0, 1.0, 1.0, lever, lever])
        self._layout = layout_of(channels(parameters))
        self.reset()

    def reset(self) -> None:
        """Back to the start."""
        scales = np.concatenate([self._scales, self._fastest * self._scales])
        self._follow(ShaftCourse(self.parameters, Loading(self.parameters.shaft)))
        self._work = rosenbrock_work(STATE, MOVING, len(RODAS4.alpha), scales)
        self._moved = new_balls(self.rotor), new_moment()
        self._shown = new_balls(self.rotor), new_moment(), np.zeros(STATE)
        self.clock, self.kept = np.zeros(march.CLOCK), np.zeros((march.KEPT, STATE))
        self.clock[march.STEP] = FIRST / self._fastest
        self.kept[march.START] = self.kept[march.END] = self._begin
        self.counts, self._now_ns = np.zeros(march.COUNTS, np.int64), 0
        self.keep()

    def _arrays(self) -> list[np.ndarray]:
        """All that a kernel changes and that the next step depends on."""
        return [self.clock, self.kept, self.counts, *self.places]

    @property
    def places(self) -> list[np.ndarray]:
        """Where the balls of both bearings were found in balance last: in the motion, then in its outputs."""
        first = self.rotor.seats[0].balls
        return [part for balls in (self._moved[0], self._shown[0]) for part in np.split(balls.places, [first])]

    def snapshot(self) -> dict:
        """The state as plain data; see `resume`."""
        arrays = {name: getattr(self, name).tolist() for name in SNAPPED}
        balls = [one.tolist() if np.isfinite(one).all() else [] for one in self.places]
        course, loading = self.course, self.course.loading
        told = {"told": course.now, "turned": course.turned(course.now)[:2], "goal": course.goal}
        commanded = loading.load.tolist() if loading.commanded else []
        return arrays | told | {"balls": balls, "commanded": commanded, "now": self.seconds}

    def resume(self, kept: dict) -> None:
        """To a state that `snapshot` gave; raises KeyError, TypeError or ValueError for one of another shaft."""
        self.reset()
        balls = zip(self.places, kept["balls"], strict=True)
        pairs = [(getattr(self, name), kept[name]) for name in SNAPPED] + [pair for pair in balls if len(pair[1])]
        for array, numbers in pairs:
            given = np.array(numbers, float)
            if given.shape != array.shape or not np.isfinite(given).all():
                raise ValueError(numbers)
            array[...] = given
        now, told, goal, angle, speed = map(float, (kept["now"], kept["told"], kept["goal"], *kept["turned"]))
        began, time, step = self.clock[[march.BEGAN, march.TIME, march.STEP]]
        if not (np.isfinite([angle, speed, goal]).all() and told <= now and began <= now <= time and step > 0.0):
            raise ValueError("clock")
        loading = Loading(self.parameters.shaft)
        if commanded := list(map(float, kept["commanded"])):
            if len(commanded) != len(loading.load) or not all(map(math.isfinite, commanded)):
                raise ValueError(commanded)
            loading.set(commanded[:3], commanded[3:])
        self._now_ns = round(1e9 * now)
        self._follow(ShaftCourse(self.parameters, loading, told, angle, speed, goal))
        self.keep()

    def keep(self) -> None:
        """Keeps what `take_back` needs."""
        self._before = [values.copy() for values in self._arrays()], self._now_ns, self.course

    def take_back(self) -> None:
        """Back to the last `keep`, as before the last `advance`."""
        arrays, self._now_ns, course = self._before
        self._follow(course)
        for values, before in zip(self._arrays(), arrays, strict=True):
            values[...] = before

    def _follow(self, course: ShaftCourse) -> None:
        """Turns and is loaded by `course` from now on."""
        fastest = max(map(abs, course.speeds))
        as_begun = self.rotor.whirl.any() and all(speed == self.parameters.drive.speed for speed in course.speeds)
        turn = self._closer * (WHIRLING if as_begun else TURN)
        longest = 2.0 * math.pi / (turn * fastest) if fastest else math.inf
        self.course, self._bounds = course, np.array([LEAST / self._fastest, longest])

    def _parts(self, until: float) -> np.ndarray:
        """The parts of the course from that of the step kept to the first after `until` [s]."""
        self.clock[march.PHASE] = 0.0
        return self.course.rows(float(self.clock[march.BEGAN]), until)

    @property
    def goal_speed(self) -> float:
        """The speed [rad/s] that the shaft is told to go to, at the drive's acceleration."""
        return self.course.goal_at(self.seconds)

    @goal_speed.setter
    def goal_speed(self, speed: float) -> None:
        self._told(self.course.told(self.seconds, speed))

    def set_load(self, force, moment) -> None:
        """New loads at `shaft.load_place` [N], [N m] from now on, or the scene's own where both are None.

        They are taken as `operating.check_load` let them pass. Constant loads and unbalances stay.
        """
        self._told(self.course.loaded(self.seconds, force, moment))

    def _told(self, course: ShaftCourse) -> None:
        """Goes on by another course from now on: what of the step kept lies beyond is dropped."""
        march.begin_again(self.clock, self.kept, self.seconds, self._shown[-1])
        self._follow(course)

    @property
    def seconds(self) -> float:
        """Simulated time so far [s]."""
        return 1e-9 * self._now_ns

    def first_outputs(self) -> Columns:
        """The outputs at the present instant, at the start of a run."""
        rows = np.empty((1, self._layout.width))
        self.clock[march.CURSOR] = 0.0
        here = np.array([self.seconds])
        march.write_outputs(self.rotor, self._parts(here[0]), self._shown, self.clock, self.kept, here, rows)
        return Columns(self._layout, rows)

    def advance(self, times: np.ndarray, duration: float) -> Columns:
        """Integrates `duration` [s] and returns the outputs at `times` [s] from now; raises IntegrationError."""
        self.keep()
        # Whole nanoseconds: sums of seconds would depend on how the run is cut.
        due = 1e-9 * (self._now_ns + np.rint(1e9 * np.asarray(times, float)))
        until = self._now_ns + round(1e9 * duration)
        rows = np.empty((len(due), self._layout.width))
        self.clock[march.CURSOR] = 0.0
        status = march.advance(
            self.rotor, self._parts(1e-9 * until), RODAS4, self._work, self._moved, self._shown, self.clock, self.kept,
            self.counts, due, 1e-9 * until, self._bounds, self._furthest, rows, self.stop,
        )  # fmt: skip
        seconds = float(self.clock[march.TIME])
        if status == STOPPED:
            raise Stopped(f"the computation was stopped at {seconds:.9g} s")
        status = status if np.isfinite(self.kept).all() or status != OK else NOT_FINITE
        if status != OK:
            raise self._failed(status, seconds)
        self._now_ns = until
        return Columns(self._layout, rows)

    def _failed(self, status: int, seconds: float) -> IntegrationError:
        """The error of a run that failed at `seconds`."""
        error = IntegrationError(f"at {seconds:.9g} s {FAILURES[status]}", WORDS[status], seconds, "shaft")
        angle, speed, acceleration = self.course.turned(seconds)
        loads = self.course.load_at(seconds)[0]
        add_unbalances(self.rotor, angle, speed, acceleration, loads)
        return explained(error, self.parameters, self._law, speed, loads)

    def take_records(self) -> dict[str, np.ndarray]:
        """None: the outputs say all."""
        return {}

    def costs(self) -> dict[str, int]:
        """Steps, rejected steps and evaluations of the rates."""
        return dict(zip(("steps", "rejections", "evaluations"), self.counts.tolist(), strict=True))
