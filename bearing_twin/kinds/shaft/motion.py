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
from bearing_twin.kinds.bearing.equilibrium import COORDINATES, STOP, Support, check_goal, equilibrium_error
from bearing_twin.kinds.bearing.models import nominal_law_error
from bearing_twin.kinds.bearing.ratings import command_warning
from bearing_twin.kinds.bearing.rings import SPEED
from bearing_twin.kinds.bearing.system import Loading, method_numbers
from bearing_twin.kinds.contract import OperatingPoint
from bearing_twin.kinds.rules import SHAFT, answers, sentences
from bearing_twin.kinds.shaft.equilibrium import (
    ShaftCourse,
    ShaftSolver,
    balance_of,
    check_load,
    coordinate_bound,
    lever_of,
    matrices_of,
    modes_of,
    rotor_of,
    speeds_of,
    stiffest_mode,
    unbalance_response,
    with_load_limit,
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
SAVED_AS = {"clock": "clock", "step_states": "kept"}  # arrays that a motion resumes from, and their names in snapshots

RATE, LOAD_WORK, BEARING_WORK, STATE = COORDINATES, 2 * COORDINATES, 2 * COORDINATES + 1, 2 * COORDINATES + 4
"""Where a state has rates, works of loads and of the bearings, and its length: `StateIndex` of core/shaft/shaft.cpp."""
# Of the clock: begin and end [s] of the present step, next step [s]; its length.
STEP_BEGIN, STEP_END, NEXT_STEP, CLOCK = 0, 1, 2, 5
START, END, STEP_ROWS = 0, 1, 4  # of the present step: states at its ends; rows
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


# A table by the numbers of balls: by a scene, all of it would be hashed.
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
        Channel("tilt_rate", "rad/s", (2,), "of the shaft about x and y, without its spin", (ABOUT,)),
        Channel("shaft_angle", "rad", (), "about +z, not wrapped"),
        Channel("shaft_speed", "rad/s", (), "about +z"),
        Channel("ring_offset", "m", (2, 3), "of each inner ring's centre from where it is as made", (BEARING, "axis")),
        Channel("bearing_force", "N", (2, 3), "of each bearing on the shaft", (BEARING, "axis")),
        Channel("bearing_moment", "N m", (2, 2), "of each on the shaft, about its ring's centre", (BEARING, ABOUT)),
        Channel("orbit_angle", "rad", (2,), "azimuth of ball 0 of each bearing, not wrapped", (BEARING,)),
        Channel("load", "N", (3,), "on the shaft from outside, with its unbalances, without its weight"),
        Channel("load_moment", "N m", (2,), "of that load, about the centre of mass", (ABOUT,)),
        *of_balls,
        Channel("kinetic_energy", "J", (), "of the shaft, without its spin"),
        Channel("potential_energy", "J", (), "of the shaft's weight"),
        Channel("elastic_energy", "J", (), "stored in all contacts"),
        Channel("load_work", "J", (), "of loads and unbalances on the shaft since the start, without its weight"),
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

    longest_chunk = 0.1  # s: a second run is compared once a chunk

    def __init__(self, parameters: ShaftScene, choice: Choice):
        self.parameters, self._law, self.stop = parameters, choice.law, SIGNALLED
        balance = balance_of(parameters, choice.law, float(parameters.drive.speed))
        self.rotor = rotor_of(parameters, choice.law, balance.ratios)
        self._begin = np.zeros(STATE)
        self._begin[:RATE] = balance.coordinates
        matrices = matrices_of(self.rotor, balance.stiffness)
        if parameters.shaft.start == SETTLED:
            response = unbalance_response(self.rotor, matrices, parameters.drive.speed)
            self.rotor = self.rotor._replace(whirl=response)
        position, steady = self._begin[:RATE] + self.rotor.whirl.real, self.rotor.steady
        self._begin[LOAD_WORK], self._begin[BEARING_WORK] = -steady @ position, -(steady + self.rotor.weight) @ position
        self._fastest = stiffest_mode(matrices)
        self._finer = choice.finer
        squeeze = max(float(contacts.approach.sum(axis=1).max()) for contacts in balance.contacts)
        setting = max(SETTING * parameters.wanted.tolerance, FINEST)
        scale = setting * squeeze / POWER  # [m], changes the greatest load by this share of it
        lever = lever_of(self.rotor)
        levers = np.array([1.0, 1.0, 1.0, lever, lever])
        self.scales = np.outer([1.0, self._fastest], scale / levers).ravel()
        self._furthest = coordinate_bound(self.rotor) / levers
        self._layout = layout_of(channels(parameters))
        self.reset()

    def reset(self) -> None:
        """Back to the start."""
        balls = np.array([seat.balls for seat in self.rotor.seats])
        self._numbers = self.rotor.numbers(), self.rotor.seat_numbers(), balls
        self._follow(ShaftCourse(self.parameters, Loading(self.parameters.shaft)))
        self.clock, self.step_states = np.zeros(CLOCK), np.zeros((STEP_ROWS, STATE))
        self.clock[NEXT_STEP] = FIRST / self._fastest
        self.step_states[START] = self.step_states[END] = self._begin
        self.counts, self._now_ns = np.zeros(3, np.int64), 0
        self.keep()

    def _arrays(self) -> list[np.ndarray]:
        """All that the core changes and that the next step depends on."""
        return [self.clock, self.step_states, self.counts]

    def snapshot(self) -> dict:
        """The state as plain data; see `resume`."""
        arrays = {key: getattr(self, name).tolist() for name, key in SAVED_AS.items()}
        course, loading = self.course, self.course.loading
        speeds = {"commanded_at": course.now, "turned": course.turned(course.now)[:2], "goal": course.goal}
        commanded = loading.steady.tolist() if loading.commanded else []
        return arrays | speeds | {"commanded": commanded, "now": self.seconds}

    def resume(self, snapshot: dict) -> None:
        """Resume from a `snapshot`; raises KeyError, TypeError or ValueError for that of another shaft."""
        self.reset()
        for name, key in SAVED_AS.items():
            array, values = getattr(self, name), np.array(snapshot[key], float)
            if values.shape != array.shape or not np.isfinite(values).all():
                raise ValueError(key)
            array[...] = values
        commanded_at = snapshot.get("commanded_at", snapshot.get("told"))  # the name in earlier versions
        now, commanded_at, goal = map(float, (snapshot["now"], commanded_at, snapshot["goal"]))
        angle, speed = map(float, snapshot["turned"])
        step_begin, step_end, step = self.clock[[STEP_BEGIN, STEP_END, NEXT_STEP]]
        ordered = 0.0 <= commanded_at <= now and step_begin <= now <= step_end
        if not (np.isfinite([angle, speed, goal]).all() and ordered and step > 0.0):
            raise ValueError("clock")
        loading = Loading(self.parameters.shaft)
        if commanded := list(map(float, snapshot["commanded"])):
            if len(commanded) != len(loading.steady) or not all(map(math.isfinite, commanded)):
                raise ValueError(commanded)
            loading.set(commanded[:3], commanded[3:])
        self._now_ns = round(1e9 * now)
        self._follow(ShaftCourse(self.parameters, loading, commanded_at, angle, speed, goal))
        self.keep()

    def keep(self) -> None:
        """Keep the state for `take_back`."""
        self._before = [values.copy() for values in self._arrays()], self._now_ns, self.course

    def take_back(self) -> None:
        """Back to the last `keep`, as before the last `advance`."""
        arrays, self._now_ns, course = self._before
        self._follow(course)
        for values, before in zip(self._arrays(), arrays, strict=True):
            values[...] = before

    def _follow(self, course: ShaftCourse) -> None:
        """Follow the speed and loads of `course` from now on."""
        fastest = max(map(abs, course.speeds))
        is_steady = self.rotor.whirl.any() and all(speed == self.parameters.drive.speed for speed in course.speeds)
        steps_a_turn = self._finer * (WHIRLING if is_steady else TURN)
        longest = 2.0 * math.pi / (steps_a_turn * fastest) if fastest else math.inf
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
        """As `equilibrium.check_load`, at the goal of the speed."""
        check_load(self.parameters, self._law, self.goal_speed, force, moment)

    def set_load(self, force, moment) -> None:
        """Set the loads at `shaft.load_place` [N], [N m], checked by `check_load`; None for both: those of the scene.

        Constant loads and unbalances stay.
        """
        self._follow_anew(self.course.loaded(self.seconds, force, moment))

    def operating_point(self, sample) -> OperatingPoint:
        """The shaft of an output about its centre of mass, the balls in balance at their azimuths.

        Its loads are those that both bearings carry there. Raises BearingTwinError.
        """
        coordinates, speed = (*sample["position"], *sample["tilt"]), float(sample["shaft_speed"])
        azimuths = zip(self.rotor.seats, sample["orbit_angle"].tolist(), strict=True)
        seats = tuple(seat._replace(first=azimuth) for seat, azimuth in azimuths)
        solver = ShaftSolver(self.rotor._replace(seats=seats), speed)
        try:
            equilibrium = solver.checked_balance(Support((False,) * COORDINATES, (0.0,) * COORDINATES, coordinates))
        except SceneError as error:
            raise BearingTwinError(f"there is no stiffness where the shaft stands now: {error}") from error
        return OperatingPoint(equilibrium.coordinates, equilibrium.loads, equilibrium.stiffness, speed)

    def _follow_anew(self, course: ShaftCourse) -> None:
        """Follow another course from now on; the rest of the present step is dropped."""
        _restart(self.clock, self.step_states, self.seconds)
        self._follow(course)

    @property
    def seconds(self) -> float:
        """Simulated time so far [s]."""
        return 1e-9 * self._now_ns

    def first_outputs(self) -> Columns:
        """The outputs at the present instant, at the start of a run."""
        return self._integrated(np.array([self.seconds]), self.seconds)[1]

    def advance(self, times: np.ndarray, duration: float) -> Columns:
        """Integrate `duration` [s] and return the outputs at `times` [s] from now; raises IntegrationError."""
        self.keep()
        # Whole nanoseconds: sums of seconds would depend on the chunks.
        due = 1e-9 * (self._now_ns + np.rint(1e9 * np.asarray(times, float)))
        until = self._now_ns + round(1e9 * duration)
        status, outputs = self._integrated(due, 1e-9 * until)
        seconds = float(self.clock[STEP_END])
        if status == STOPPED:
            raise Stopped(f"the computation was stopped at {seconds:.9g} s")
        if status != OK:
            raise self._failed(status, seconds)
        self._now_ns = until
        return outputs

    def _integrated(self, due: np.ndarray, until: float) -> tuple[int, Columns]:
        """Status, and the outputs at the times `due` [s], of steps until one reaches `until` [s]."""
        rows = np.empty((len(due), self._layout.width))
        course = self.course.rows(float(self.clock[STEP_BEGIN]), until)
        status = _advance(
            *(*self._numbers, course, len(course), method_numbers("rodas4"), self.scales),
            *(self._bounds, len(due), due, until, self.stop, *self._arrays(), rows, self._layout.width),
        )
        return status, Columns(self._layout, rows)

    def _failed(self, status: int, seconds: float) -> IntegrationError:
        """The error of a run that failed at `seconds`."""
        error = IntegrationError(f"at {seconds:.9g} s {FAILURES[status]}", REASONS[status], seconds, "shaft")
        angle, speed, acceleration = self.course.turned(seconds)
        unbalance = (speed**2 - 1j * acceleration) * np.exp(1j * angle) * self.rotor.unbalance
        loads = self.course.load_at(seconds)[0] + unbalance.real
        return with_load_limit(error, self.parameters, self._law, speed, loads)

    def take_records(self) -> dict[str, np.ndarray]:
        """Empty: a shaft has no records beside its outputs."""
        return {}

    def costs(self) -> dict[str, int]:
        """Steps, rejected steps and evaluations of the rates."""
        return dict(zip(("steps", "rejections", "evaluations"), self.counts.tolist(), strict=True))


SAME = 1e-9  # relative: nearer speeds are equal
FAST = 1000.0  # Hz: balls in balance at every instant have no lag


def law_error(parameters: ShaftScene, law: str) -> float:
    """Greatest relative load error of a law against exact Hertz at the nominal contacts of both bearings."""
    return max(nominal_law_error(law, bearing_scene(parameters, side)) for side in SIDES)


def balance_errors(parameters: ShaftScene, law: str, commanded: float = 0.0) -> dict[str, float]:
    """Errors of loads in equilibrium, over the greatest load, by bearing, at the greatest speed [rad/s].

    That is the scene's, or a greater `commanded` one. The greater error under the loads at the run's start and end
    counts. Raises SceneError where nothing carries them.
    """
    speed, errors = max(speeds_of(parameters), key=abs), dict.fromkeys(SIDES, 0.0)
    speed = commanded if commanded > abs(speed) * (1.0 + SAME) else speed
    for time in (0.0, float(parameters.run.duration)):
        for side, contacts in zip(SIDES, balance_of(parameters, law, float(speed), time).contacts, strict=True):
            errors[side] = max(errors[side], equilibrium_error(contacts))
    return errors


def choose(parameters: ShaftScene) -> Choice:
    """Law and method; raises SceneError where the shaft is not in balance as its run begins, or as it ends."""
    choices, warnings = answers(SHAFT, parameters), []
    law = choices["contact.normal"].value
    balance_of(parameters, law, float(parameters.drive.speed))
    end = float(parameters.run.duration)
    try:
        balance_of(parameters, law, float(speeds_of(parameters)[-1]), end)
    except SceneError as problem:
        raise SceneError(f"at {end:g} s, where the run ends, {problem}") from problem
    error = law_error(parameters, law)
    difference = max(balance_errors(parameters, law).values())
    percent = two_digits(100.0 * difference)
    if difference > parameters.wanted.tolerance:
        warnings.append(
            f"loads of balls in equilibrium differ from those of moving balls by up to {percent} % of "
            "the greatest load, until the axes of their spin have settled"
        )
    slow = [f"{frequency:.4g}" for frequency in modes_of(parameters, law)[0].frequencies if frequency > FAST]
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
        f"{sentences(choices)}; balls are in balance at every instant, their gyroscopic moment carried by both "
        "raceways, in cages that orbit as loaded balls roll; "
        f"loads of moving balls differ by up to {percent} % of the greatest"
    )
    return Choice(law, choices["solver.stepper"].value, error, reason, tuple(warnings))
