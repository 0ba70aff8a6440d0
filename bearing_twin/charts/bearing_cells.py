"""One run of a small bearing against a far tighter one: what every contest of a bearing measures.

Truth is `rodas4` at a tolerance of TIGHT. The product's methods run as shipped, but their refusals are passed by, so
that a chart shows where a method fails and not where it is refused. Beside them run what a newcomer would take:
explicit Euler, and SciPy's `solve_ivp` with its default tolerances on the plain right-hand side.
"""

import functools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.integrate import LSODA, RK45

from bearing_twin.charts.contest import judged
from bearing_twin.charts.table import REFUSED, Row
from bearing_twin.charts.timing import LONG_ENOUGH, timed
from bearing_twin.errors import IntegrationError, SceneError
from bearing_twin.kinds.bearing.doubt import LEAST_LOAD
from bearing_twin.kinds.bearing.forces.layout import BORDER
from bearing_twin.kinds.bearing.forces.rates import bearing_rates
from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.kinds.bearing.outputs import empty_outputs, write_outputs
from bearing_twin.kinds.bearing.stepping.explicit import explicit_chunk
from bearing_twin.kinds.bearing.stepping.integrate import REFERENCE_SHARE, SCIPY
from bearing_twin.kinds.bearing.stepping.step_limits import FIXED_STEP
from bearing_twin.kinds.bearing.stepping.steps import Results
from bearing_twin.numerics.statuses import EVALUATIONS, OK
from bearing_twin.numerics.steppers import RungeKutta
from bearing_twin.report import Choice
from bearing_twin.run.scene import load_scene

TIGHT = 1e-8  # tolerance of what is taken as true
EULER = RungeKutta(np.zeros((1, 5)), np.zeros(1), np.ones(1), np.zeros(2), np.zeros(2), 1)


class Case(NamedTuple):
    """A bearing over `count` instants `period` [s] apart."""

    scene: str
    overrides: tuple[str, ...]
    period: float
    count: int

    @property
    def times(self) -> np.ndarray:
        """The instants [s]."""
        return self.period * np.arange(1, self.count + 1)

    @property
    def seconds(self) -> float:
        """How long it is simulated [s]."""
        return self.period * self.count


def overrides_of(case: Case, method: str, setting: float, *more: str) -> tuple[str, ...]:
    """What differs in the scene of a case that is run by that method at its step or tolerance, but for how long."""
    key = "solver.step" if method in FIXED_STEP else "wanted.tolerance"
    return (
        *case.overrides,
        f"solver.stepper={method}",
        f"{key}={setting:g}",
        *more,
        f"run.output_rate={1.0 / case.period:g}",
    )


def command_of(case: Case, method: str, setting: float, *more: str) -> str:
    """The command that runs a case by that method at its step or tolerance, and over the same time."""
    sets = " ".join(f"--set {word}" for word in overrides_of(case, method, setting, *more))
    return f"bearing_twin simulate {case.scene} {sets} --duration {case.seconds:g}"


def errors(motion: BearingMotion, found, exact, greatest: float | None = None) -> tuple[float, float]:
    """Greatest errors of `found` outputs: of load, and of friction; infinite where something is not finite.

    That of a load is over the `greatest` load [N], of the `exact` outputs unless it is given. That of friction is over
    what friction could be there and then: of a contact's force over mu N, of the raceways' torque on a ball over
    mu N R, N the load of the contact or of both.
    """
    coefficient, radius = motion.parameters.contact.friction_coefficient, motion.bearing.ball_radius
    greatest = exact.normal_load.max() if greatest is None else greatest
    load = np.abs(found.normal_load - exact.normal_load).max() / greatest
    force = np.linalg.norm(found.friction_force - exact.friction_force, axis=-1)
    torque = np.linalg.norm(found.raceway_torque - exact.raceway_torque, axis=-1) / radius
    friction = max(
        (force / np.maximum(exact.normal_load, LEAST_LOAD * greatest)).max(),
        (torque / np.maximum(exact.normal_load.sum(axis=-1), LEAST_LOAD * greatest)).max(),
    )
    pair = float(load), float(friction) / coefficient
    return pair if all(map(np.isfinite, pair)) else (np.inf, np.inf)


def motion_of(case: Case, stepper: str, law: str = "hertz", key: str = "wanted.tolerance=0.001") -> BearingMotion:
    """The bearing moved by that stepper and law; a fixed step is set in `step` afterwards, or given by `key`."""
    scene = load_scene(case.scene, (*case.overrides, key))
    return BearingMotion(scene.parameters, Choice(law, stepper, 0.0, "", ()))


@functools.lru_cache(maxsize=64)
def truth(case: Case, law: str = "hertz"):
    """The outputs of a case as they are taken to be true."""
    return motion_of(case, "rodas4", law, f"wanted.tolerance={TIGHT!r}").advance(case.times, float(case.times[-1]))


def ready(case: Case, stepper: str, setting: float, law: str = "hertz", refuses: bool = False) -> BearingMotion:
    """A motion at its start whose kernels are there; `setting` is a step [s] of a fixed-step method, else a tolerance.

    A step is set past the refusals, unless one that is refused shall raise what a run of the scene does.
    """
    if stepper not in FIXED_STEP:
        motion = motion_of(case, stepper, law, f"wanted.tolerance={setting!r}")
    else:
        motion = motion_of(case, stepper, law, *([f"solver.step={setting!r}"] if refuses else []))
    if stepper in SCIPY:
        # As contestants they get the tolerance asked for, not the one that makes them references.
        motion.scales = motion.scales / REFERENCE_SHARE
    motion.advance(np.array([1e-8]), 1e-8)
    to_start(motion, setting)
    return motion


def to_start(motion: BearingMotion, setting: float) -> None:
    """Back to the start, with that step [s] where steps are fixed."""
    motion.reset()
    if motion.stepper in FIXED_STEP:
        motion.step = setting


def found_errors(motion: BearingMotion, case: Case, exact) -> tuple[float, float]:
    """Errors of load and of friction of a motion from its start; infinite where it fails."""
    try:
        return errors(motion, motion.advance(case.times, float(case.times[-1])), exact)
    except IntegrationError:
        return math.inf, math.inf


def bearing_row(
    row: Row,
    case: Case,
    limit: float,
    law: str = "hertz",
    true: tuple = (),
    enough: float = LONG_ENOUGH,
    refuses: bool = False,
) -> Row:
    """The row with what its method gives at its setting; `true` (case, law) is the truth's where it is another.

    Seconds are CPU seconds per simulated second, by timings of `enough` [s] each (`timed`). A step that the software
    refuses is run all the same, unless it `refuses`.
    """
    exact = truth(*(true or (case,)))
    naive = NAIVE.get(row.method)
    try:
        motion = ready(case, "rodas4" if naive else row.method, row.setting if not naive else TIGHT, law, refuses)
    except SceneError as error:
        return row.but(status=REFUSED, reason=str(error))

    def work():
        if naive:
            motion.reset()
            return naive(motion, case, row.setting)
        to_start(motion, row.setting)
        return motion.advance(case.times, float(case.times[-1])), motion.costs()["ball_rates"]

    return worked(row, work, motion, case, exact, limit, enough)


def worked(
    row: Row, work: Callable[[], tuple], motion: BearingMotion, case: Case, exact, limit: float, enough: float
) -> Row:
    """The row with what the outputs of a motion err by that `work` gives, with its evaluations, and what it costs."""

    def outcome():
        (out, evaluations), cost = timed(work, enough)
        load, friction = errors(motion, out, exact)
        found = {"load_error": load, "friction_error": friction, "evaluations": int(evaluations)}
        return {**found, "seconds": cost.seconds / float(case.times[-1]), "spread": cost.spread}

    return judged(row, outcome, limit)


def _plain(motion):
    """The right-hand side as a user's own function of time and a flat state, with the number of its evaluations."""
    shape, near, count = motion.state.shape, np.zeros(motion.bearing.balls, np.bool_), [0]
    rates = np.zeros(shape)

    def right_hand_side(time, flat):
        count[0] += motion.bearing.balls
        bearing_rates(motion.bearing, motion.drive, near, time, flat.reshape(shape), rates)
        return rates.ravel().copy()

    return right_hand_side, count


def _given_out(motion, case, states):
    """Outputs of states (outputs, N, COLUMNS), the balls unturned."""
    out, times = empty_outputs(motion.parameters, case.count), case.times
    orientations = np.tile(motion.orientation, (case.count, 1, 1))
    borders = np.tile(motion.border, (case.count, 1))
    filled = np.ascontiguousarray(states), orientations, borders
    partners = motion._partners()
    write_outputs(motion.parameters, motion.bearing, partners, motion.drive, times, *filled, out.numbers, 0)
    return out


def _by_solve_ivp(solver, motion, case, setting):
    """As SciPy's `solve_ivp` does it; `setting` is rtol, and atol a thousandth of it, as in the defaults."""
    right_hand_side, count = _plain(motion)
    state, end = motion.state.ravel().copy(), float(case.times[-1])
    method = solver(right_hand_side, 0.0, state, end, rtol=setting, atol=1e-3 * setting)
    states, cursor = np.full((case.count, state.size), np.nan), 0
    while method.status == "running" and np.isfinite(method.y).all():
        method.step()
        dense = method.dense_output()
        while cursor < case.count and case.times[cursor] <= method.t:
            states[cursor] = dense(case.times[cursor])
            cursor += 1
    return _given_out(motion, case, states.reshape(case.count, *motion.state.shape)), count[0]


def _by_euler(motion, case, setting):
    """Explicit Euler in equal steps of about `setting` [s], by the product's own loop."""
    state, balls, near = motion.state, motion.bearing.balls, np.zeros(motion.bearing.balls, np.bool_)
    states = np.full((case.count, *state.shape), np.nan)
    turned, borders = np.zeros((case.count, balls, 4)), np.zeros((case.count, BORDER))
    counts, failure = np.zeros(4, np.int64), np.zeros(2)
    results = Results(states, turned, counts, failure, motion.stop, motion.carried, borders, motion.border)
    what = motion.bearing, motion.drive, near, case.times, float(case.times[-1]), setting, motion.scales
    if explicit_chunk(EULER, *what, state, motion.orientation, motion.steps, results) != OK:
        raise IntegrationError(f"not finite, or through a raceway, at {failure[0]:.3g} s")
    return _given_out(motion, case, states), counts[EVALUATIONS]


NAIVE = {
    "explicit Euler": _by_euler,
    "solve_ivp RK45": functools.partial(_by_solve_ivp, RK45),
    "solve_ivp LSODA": functools.partial(_by_solve_ivp, LSODA),
}
"""What a newcomer takes: a step [s] of Euler, the relative tolerance of the others."""
