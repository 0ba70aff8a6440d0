"""A shaft on two bearings as a run: its channels, and its motion, integrated by the compiled core (`core/shaft/`)."""

import functools
import math

import numpy as np

from bearing_twin.base.errors import BearingTwinError, IntegrationError, SceneError, Stopped
from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Channel, Columns, layout_of
from bearing_twin.base.stopping import SIGNALLED
from bearing_twin.base.units import two_digits
from bearing_twin.core import INTEGER, INTEGERS, INTEGERS_OUT, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.bearing import (
    COORDINATES,
    SPEED,
    STOP,
    Loading,
    Support,
    check_goal,
    command_warning,
    equilibrium_error,
    method_numbers,
    nominal_law_error,
)
from bearing_twin.kinds.contract import OperatingPoint
from bearing_twin.kinds.rules import SHAFT, answers, sentences
from bearing_twin.kinds.shaft.equilibrium import (
    ShaftCourse,
    ShaftSolver,
    balance_of,
    check_load,
    explained,
    lever_of,
    longest_of,
    matrices_of,
    modes_of,
    rotor_of,
    speeds_of,
    stiffest_mode,
    unbalance_response,
)
from bearing_twin.kinds.shaft.parameters import SETTLED, SIDES, ShaftScene, bearing_scene
from bearing_twin.methods import NOT_FINITE, OK, REASONS, STALLED, STOPPED, TOO_DEEP

SETTING = 0.01  # tolerance of a step over that of a ball's load
FINEST = 1e-11  # least tolerance of a step
FIRST, LEAST = 0.1, 1e-9  # of the stiffest mode's period over 2 pi: first step, least one
FAILURES = {
    NOT_FINITE: "the motion is not finite any more; lower speed and loads",
    STALLED: "ever shorter steps are needed; loosen wanted.tolerance, or lower speed and loads",
    TOO_DEEP: "a ball is squeezed too hard, or leaves the grooves; lower the loads, or keep away from a critical speed",
}
TURN, WHIRLING = 12, 4
"""Steps a turn at least: with 8 works have errors of 1e-3 of all that an unbalance does either way; and where only
what is left beside the whirl is stepped."""
POWER = 1.5  # of a contact's load over its approach, nearly, whatever its law
SNAPPED = ("clock", "kept")  # arrays that a motion goes on from

RATE, LOAD_WORK, BEARING_WORK, STATE = COORDINATES, 2 * COORDINATES, 2 * COORDINATES + 1, 2 * COORDINATES + 4
"""Where a state has rates, works of loads and of the bearings, and its length: `StateIndex` of core/shaft/shaft.cpp."""
BEGAN, TIME, STEP, CLOCK = 0, 1, 2, 5  # of the clock: begin and end [s] of the step kept, next step [s]; its length
START, END, KEPT = 0, 1, 4  # of the step kept: states at its ends; rows
_advance = Function(
    "core_shaft_advance",
    INTEGER,
    (
        *(REALS, REALS, INTEGERS, REALS, INTEGER, REALS, REALS, REALS, INTEGER, REALS, REAL, STOP),
        *(REALS_OUT, REALS_OUT, INTEGERS_OUT, REALS_OUT, INTEGER),
    ),
)
_restart = Function("core_shaft_restart", None, (REALS_OUT, REALS_OUT, REAL))

BEARING, ABOUT, RACE = "bearing", "about", "race"  # axes: left, right; x, y; inner, outer


def channels(parameters: ShaftScene) -> tuple[Channel, ...]:
    """The channels of a scene; everything is in `shaft_link`, rows of bearings are left, right."""
    return _channels(*(getattr(parameters, side).geometry.balls for side in SIDES))


# The table knows the numbers of balls alone: to look one up by a scene would hash all of it.
@functools.cache
def _channels(*balls: int) -> tuple[Channel, ...]:
    of_balls = (
        row
        for side, n in zip(SIDES, balls, strict=True)
        for row in (
            Channel(
                f"{side}_normal_load", "N", (n, 2), f"of the {side} bearing's balls on its raceways", ("ball", RACE)
            ),
            Channel(
                f"{side}_contact_angle",
                "rad",
                (n, 2),
                f"of the {side} bearing's balls, > 0 where the shaft pushes the way the bearing faces",
                ("ball", RACE),
            ),
        )
    )
    return (
        Channel("position", "m", (3,), "of the shaft's centre of mass"),
        Channel("tilt", "rad", (2,), "of the shaft about x and y", (ABOUT,)),
        Channel("velocity", "m/s", (3,), "of the shaft's centre of mass"),
        Channel("tilt_rate", "rad/s", (2,), "of the shaft about x and y, its spin left out", (ABOUT,)),
        Channel("shaft_angle", "rad", (), "about +z, not wrapped"),
        Channel("shaft_speed", "rad/s", (), "about +z"),
        Channel("ring_offset", "m", (2, 3), "of each inner ring's centre from where it is as made", (BEARING, "axis")),
        Channel("bearing_force", "N", (2, 3), "of each bearing on the shaft", (BEARING, "axis")),
        Channel("bearing_moment", "N m", (2, 2), "of each on the shaft, about its ring's centre", (BEARING, ABOUT)),
        Channel("orbit_angle", "rad", (2,), "azimuth of ball 0 of each bearing, not wrapped", (BEARING,)),
        Channel("load", "N", (3,), "on the shaft from outside, with its unbalances, its weight left out"),
        Channel("load_moment", "N m", (2,), "of that load, about the centre of mass", (ABOUT,)),
        *of_balls,
        Channel("kinetic_energy", "J", (), "of the shaft, its spin left out"),
        Channel("potential_energy", "J", (), "of the shaft's weight"),
        Channel("elastic_energy", "J", (), "stored in all contacts"),
        Channel("load_work", "J", (), "of loads and unbalances on the shaft since the start, its weight left out"),
        Channel("bearing_work", "J", (), "of the shaft on both bearings since the start, without what is dissipated"),
        Channel("cage_work", "J", (), "of both cages on the balls that they lead round, since the start"),
        Channel("dissipated", "J", (), "in viscous contacts since the start"),
        Channel("gross_work", "J", (), "of loads and bearings, that of each step counted by its size"),
    )


def place_of(channel: Channel, index: tuple[int, ...]) -> tuple[str, str]:
    """The body and the contact that a number of a channel belongs to, such as "left ball 3" and "outer race"."""
    side = channel.name.partition("_")[0]
    if side in SIDES:
        return f"{side} ball {index[0]}", ("inner race", "outer race")[index[1]]
    return (f"{SIDES[index[0]]} bearing" if channel.axes[:1] == (BEARING,) else "shaft"), ""


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
            self.rotor = self.rotor._replace(whirl=response)
        place, steady = self._begin[:RATE] + self.rotor.whirl.real, self.rotor.steady
        self._begin[LOAD_WORK], self._begin[BEARING_WORK] = -steady @ place, -(steady + self.rotor.weight) @ place
        self._fastest = stiffest_mode(matrices)
        self._closer = choice.finer
        squeeze = max(float(one.approach.sum(axis=1).max()) for one in begin.contacts)
        setting = max(SETTING * parameters.wanted.tolerance, FINEST)
        place = setting * squeeze / POWER  # [m], changes the greatest load by this share of it
        lever = lever_of(self.rotor)
        self.scales = np.outer([1.0, self._fastest], place / np.array([1.0, 1.0, 1.0, lever, lever])).ravel()
        self._furthest = longest_of(self.rotor) / np.array([1.0, 1.0, 1.0, lever, lever])
        self._layout = layout_of(channels(parameters))
        self.reset()

    def reset(self) -> None:
        """Back to the start."""
        balls = np.array([seat.balls for seat in self.rotor.seats])
        self._numbers = self.rotor.numbers(), self.rotor.seat_numbers(), balls
        self._follow(ShaftCourse(self.parameters, Loading(self.parameters.shaft)))
        self.clock, self.kept = np.zeros(CLOCK), np.zeros((KEPT, STATE))
        self.clock[STEP] = FIRST / self._fastest
        self.kept[START] = self.kept[END] = self._begin
        self.counts, self._now_ns = np.zeros(3, np.int64), 0
        self.keep()

    def _arrays(self) -> list[np.ndarray]:
        """All that the core changes and that the next step depends on."""
        return [self.clock, self.kept, self.counts]

    def snapshot(self) -> dict:
        """The state as plain data; see `resume`."""
        arrays = {name: getattr(self, name).tolist() for name in SNAPPED}
        course, loading = self.course, self.course.loading
        speeds = {"commanded_at": course.now, "turned": course.turned(course.now)[:2], "goal": course.goal}
        commanded = loading.steady.tolist() if loading.commanded else []
        return arrays | speeds | {"commanded": commanded, "now": self.seconds}

    def resume(self, kept: dict) -> None:
        """To a state that `snapshot` gave; raises KeyError, TypeError or ValueError for one of another shaft."""
        self.reset()
        for name in SNAPPED:
            array, given = getattr(self, name), np.array(kept[name], float)
            if given.shape != array.shape or not np.isfinite(given).all():
                raise ValueError(kept[name])
            array[...] = given
        since = kept.get("commanded_at", kept.get("told"))  # as snapshots of earlier versions call it
        now, since, goal, angle, speed = map(float, (kept["now"], since, kept["goal"], *kept["turned"]))
        began, time, step = self.clock[[BEGAN, TIME, STEP]]
        moments = 0.0 <= since <= now and began <= now <= time
        if not (np.isfinite([angle, speed, goal]).all() and moments and step > 0.0):
            raise ValueError("clock")
        loading = Loading(self.parameters.shaft)
        if commanded := list(map(float, kept["commanded"])):
            if len(commanded) != len(loading.steady) or not all(map(math.isfinite, commanded)):
                raise ValueError(commanded)
            loading.set(commanded[:3], commanded[3:])
        self._now_ns = round(1e9 * now)
        self._follow(ShaftCourse(self.parameters, loading, since, angle, speed, goal))
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
        self.course, self._bounds = course, np.array([LEAST / self._fastest, longest, *self._furthest])

    @property
    def goal_speed(self) -> float:
        """The speed [rad/s] that the shaft is commanded to go to, at the drive's acceleration."""
        return self.course.goal_at(self.seconds)

    @goal_speed.setter
    def goal_speed(self, speed: float) -> None:
        self._follow_anew(self.course.commanded(self.seconds, speed))

    def check_drive(self, key: str, value: float, load: tuple) -> str:
        """A warning of a speed [rad/s], or ""; a torque is refused, see `CommandedMotion`."""
        check_goal(SPEED, key, value)
        check_load(self.parameters, self._law, value, *load)
        return command_warning(self.parameters, value)

    def check_load(self, force, moment) -> None:
        """See `equilibrium.check_load`, at the goal of the speed."""
        check_load(self.parameters, self._law, self.goal_speed, force, moment)

    def set_load(self, force, moment) -> None:
        """New loads at `shaft.load_place` [N], [N m] from now on, or the scene's own where both are None.

        They are taken as `check_load` let them pass. Constant loads and unbalances stay.
        """
        self._follow_anew(self.course.loaded(self.seconds, force, moment))

    def operating_point(self, sample) -> OperatingPoint:
        """The shaft of an output about its centre of mass, the balls in balance where their cages have taken them.

        Its loads are those that both bearings carry there. Raises BearingTwinError.
        """
        coordinates, speed = (*sample["position"], *sample["tilt"]), float(sample["shaft_speed"])
        places = zip(self.rotor.seats, sample["orbit_angle"].tolist(), strict=True)
        solver = ShaftSolver(self.rotor._replace(seats=tuple(seat._replace(first=one) for seat, one in places)), speed)
        try:
            found = solver.checked_balance(Support((False,) * COORDINATES, (0.0,) * COORDINATES, coordinates))
        except SceneError as error:
            raise BearingTwinError(f"there is no stiffness where the shaft stands now: {error}") from error
        return OperatingPoint(found.coordinates, found.loads, found.stiffness, speed)

    def _follow_anew(self, course: ShaftCourse) -> None:
        """Goes on by another course from now on: what of the step kept lies beyond is dropped."""
        _restart(self.clock, self.kept, self.seconds)
        self._follow(course)

    @property
    def seconds(self) -> float:
        """Simulated time so far [s]."""
        return 1e-9 * self._now_ns

    def first_outputs(self) -> Columns:
        """The outputs at the present instant, at the start of a run."""
        return self._integrated(np.array([self.seconds]), self.seconds)[1]

    def advance(self, times: np.ndarray, duration: float) -> Columns:
        """Integrates `duration` [s] and returns the outputs at `times` [s] from now; raises IntegrationError."""
        self.keep()
        # Whole nanoseconds: sums of seconds would depend on how the run is cut.
        due = 1e-9 * (self._now_ns + np.rint(1e9 * np.asarray(times, float)))
        until = self._now_ns + round(1e9 * duration)
        status, outputs = self._integrated(due, 1e-9 * until)
        seconds = float(self.clock[TIME])
        if status == STOPPED:
            raise Stopped(f"the computation was stopped at {seconds:.9g} s")
        if status != OK:
            raise self._failed(status, seconds)
        self._now_ns = until
        return outputs

    def _integrated(self, due: np.ndarray, until: float) -> tuple[int, Columns]:
        """Status, and the outputs at the times `due` [s], of steps until one reaches `until` [s]."""
        rows = np.empty((len(due), self._layout.width))
        course = self.course.rows(float(self.clock[BEGAN]), until)
        status = _advance(
            *(*self._numbers, course, len(course), method_numbers("rodas4"), self.scales),
            *(self._bounds, len(due), due, until, self.stop, *self._arrays(), rows, self._layout.width),
        )
        return status, Columns(self._layout, rows)

    def _failed(self, status: int, seconds: float) -> IntegrationError:
        """The error of a run that failed at `seconds`."""
        error = IntegrationError(f"at {seconds:.9g} s {FAILURES[status]}", REASONS[status], seconds, "shaft")
        angle, speed, acceleration = self.course.turned(seconds)
        turning = (speed**2 - 1j * acceleration) * np.exp(1j * angle) * self.rotor.unbalance
        loads = self.course.load_at(seconds)[0] + turning.real
        return explained(error, self.parameters, self._law, speed, loads)

    def take_records(self) -> dict[str, np.ndarray]:
        """None: the outputs say all."""
        return {}

    def costs(self) -> dict[str, int]:
        """Steps, rejected steps and evaluations of the rates."""
        return dict(zip(("steps", "rejections", "evaluations"), self.counts.tolist(), strict=True))


SAME = 1e-9  # relative: speeds nearer than this are one
FAST = 1000.0  # Hz: balls that are in balance at every instant answer later motion at once


def law_error(parameters: ShaftScene, law: str) -> float:
    """Greatest relative load error of a law against exact Hertz at the nominal contacts of both bearings."""
    return max(nominal_law_error(law, bearing_scene(parameters, side)) for side in SIDES)


def balance_errors(parameters: ShaftScene, law: str, commanded: float = 0.0) -> dict[str, float]:
    """Errors of loads in equilibrium, over the greatest load, by bearing, at the greatest speed [rad/s].

    That is the scene's, or a greater `commanded` one. Of the loads at the run's start and end those count under which
    it is greater. Raises SceneError where nothing carries them.
    """
    speed, errors = max(speeds_of(parameters), key=abs), dict.fromkeys(SIDES, 0.0)
    speed = commanded if commanded > abs(speed) * (1.0 + SAME) else speed
    for time in (0.0, float(parameters.run.duration)):
        for side, contacts in zip(SIDES, balance_of(parameters, law, float(speed), time).contacts, strict=True):
            errors[side] = max(errors[side], equilibrium_error(contacts))
    return errors


def choose(parameters: ShaftScene) -> Choice:
    """Law and method; raises SceneError where the shaft is not in balance as its run begins, or as it ends."""
    found, warnings = answers(SHAFT, parameters), []
    law = found["contact.normal"].value
    balance_of(parameters, law, float(parameters.drive.speed))
    end = float(parameters.run.duration)
    try:
        balance_of(parameters, law, float(speeds_of(parameters)[-1]), end)
    except SceneError as problem:
        raise SceneError(f"at {end:g} s, where the run ends, {problem}") from problem
    error = law_error(parameters, law)
    off = max(balance_errors(parameters, law).values())
    if off > parameters.wanted.tolerance:
        warnings.append(
            f"loads of balls in equilibrium differ from those of moving balls by up to {two_digits(100.0 * off)} % of "
            "the greatest load, until the axes of their spin have settled"
        )
    slow = [f"{one:.4g}" for one in modes_of(parameters, law)[0].frequencies if one > FAST]
    if slow:
        warnings.append(
            f"natural frequencies of {', '.join(slow)} Hz are so high that real balls follow with a lag, while here "
            "they are in equilibrium at every instant; a scene of the kind bearing, whose ring has mass, integrates "
            "their motion"
        )
    if error > parameters.wanted.tolerance:
        share = two_digits(100.0 * error)
        warnings.append(f"the law {law} differs by {share} % from exact Hertz here; contact.normal: hertz is exact")
    reason = (
        f"{sentences(found)}; balls are in balance at every instant, their gyroscopic moment carried by both "
        "raceways, in cages that orbit as loaded balls roll; "
        f"loads of moving balls differ by up to {two_digits(100.0 * off)} % of the greatest"
    )
    return Choice(law, found["solver.stepper"].value, error, reason, tuple(warnings))
