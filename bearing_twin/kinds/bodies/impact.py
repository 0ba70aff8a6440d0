"""Central impact of two spheres and of two discs, solved as a whole, and its outputs as a run.

Spheres (paper 3, sections 2 and 3):

    mu x'' = -c x^1.5,   tau = alpha v^(-1/5),   c = (5/4) mu (C_H / alpha)^(5/2)        (eqs. 1, 2, 12, 13)

with x the mutual approach and mu the reduced mass. The Hertz coefficient c = (4/3) E* sqrt(R), or that of another law;
a linear spring has the power 1. Contact time, peak force and, by the inverse incomplete beta function, the whole
history are closed forms. A coefficient of restitution below 1 adds a Hunt-Crossley term; then contact time and history
are quadratures. Or a term that loses the same share at every speed (`damping_law: steady`); then they come from the
equation of motion.

Equal discs in line contact (paper 3, section 5.1): (m / 2) x'' = -F(x), F from eq. (14) or from Johnson's law, both
inverted by Lambert's function. The closed form is the quadrature of `contact.line`, and histories are the same
quadrature run up to each instant. Thick discs answer nearly in plane strain, as Johnson's law assumes.

Breaks: where the peak pressure exceeds yield or waves cannot cross the bodies several times in a contact; for discs
where the kinetic energy exceeds what the law can store (soft discs: use finite elasticity), and where the half-width of
the contact is no longer small against the radius.

The equation of motion is followed by `dop853` (order 8, errors controlled; `core/bodies/impact.cpp`), the method for
results, or by `rk4` and `symplectic_euler`, which show the effect of a fixed step on a stiff contact. Their steps do
not end at the separation, and are refused above an eighth of the contact time. An explicit Euler method is not offered:
it gains 40 % of speed with 16 steps a contact.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from bearing_twin.base.errors import IntegrationError, Stopped
from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Channel, records_between
from bearing_twin.base.stopping import SIGNALLED
from bearing_twin.contact import hertz_impact
from bearing_twin.contact import line as line_contact
from bearing_twin.contact.elasticity import energies_at
from bearing_twin.contact.laws import HERTZIAN, LAWS, restitution_of, steady_damping
from bearing_twin.contact.line import LineLaw, approach_of, load_of_energy
from bearing_twin.contact.line import energy as energy_of
from bearing_twin.core import FLAG, INTEGER, INTEGERS_OUT, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.bodies.derived import (
    closed_form_numbers,
    disc_law,
    hunt_crossley_damping,
    impact_time,
    is_elastic,
    mass_of,
    resolve,
    sphere_law,
    sphere_pair,
)
from bearing_twin.kinds.bodies.figures import contact_rows
from bearing_twin.kinds.bodies.parameters import FIRST, FIXED_STEP, MOST_STEPS, SECOND, TwoDiscsScene, TwoSpheresScene
from bearing_twin.kinds.contract import ClosedForm
from bearing_twin.methods import EVALUATIONS, NO_END, NOT_FINITE, REASONS, SEPARATED, STALLED, STEPS, STOPPED

SETTING = 0.03  # tolerance of a step over that of forces and times (`tests/test_impact_error.py`)
PIECES = 400  # of the history of discs by quadrature
SAMPLES = 2001  # of a contact, for its greatest load
MAX_NODES = 20 * MOST_STEPS  # of fixed steps until a contact is given up: half a second
MAX_ENDS = 10_000  # of steps of dop853
FIRST_STEP, LEAST_STEP, LONGEST = 1e-3, 1e-14, 100.0  # of the contact expected: first step at most, least, the whole
START_ORDER = 2.5  # power of the first step with which its error goes: the load begins as time^1.5
NO_LINE = LineLaw(0.0, 0.0, 0.0)
CHANNELS = (
    Channel("approach", "m", (), "mutual approach of the two bodies; negative = gap"),
    Channel("normal_load", "N", (), "contact force, pushing the bodies apart"),
    Channel("displacement", "m", (2,), "of the two centres from the start, positive forward", ("body",)),
    Channel("velocity", "m/s", (2,), "of the two centres, positive forward", ("body",)),
    Channel("kinetic_energy", "J", (), "of the motion relative to the common centre of mass"),
    Channel("elastic_energy", "J", (), "stored in the contact"),
)

_follow = Function(
    "core_follow_impact",
    INTEGER,
    (REALS, REAL, REALS, REAL, REAL, REAL, INTEGER, FLAG, REALS_OUT, INTEGERS_OUT, INTEGERS_OUT),
)
_states = Function("core_impact_states", None, (REALS, INTEGER, REALS, INTEGER, REALS, REALS_OUT))
_step = Function("core_step_impact", INTEGER, (REALS, INTEGER, REAL, REAL, INTEGER, REALS_OUT))
_loads = Function("core_impact_loads", None, (REALS, INTEGER, REALS, REALS, REALS_OUT))


class Spring(NamedTuple):
    """The load between two bodies: `line_law.scale` > 0 selects line contact, else coefficient * approach^power.

    The viscous load is (damping * load + relaxation_time * stiffness) * approach rate, in s/m and s; where `steady`
    [N s/m^(5/4)] is above zero, steady * approach^((power - 1)/2) * approach rate, which loses the same share at every
    speed. It never pulls: the contact ends where both parts cancel (`core/contact/laws.hpp`).
    """

    coefficient: float
    line_law: LineLaw
    damping: float
    steady: float = 0.0
    power: float = HERTZIAN
    relaxation_time: float = 0.0

    def numbers(self, reduced_mass: float = 1.0) -> np.ndarray:
        """The numbers of an ImpactContact of the core."""
        steady = self.steady > 0.0
        damping = steady, self.steady if steady else self.damping, self.relaxation_time
        return np.array([self.coefficient, self.power, *self.line_law, *damping, reduced_mass], float)

    def loads(self, approach: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """Loads [N] and stored energies [J] (2, n) at approaches [m] and their rates [m/s]."""
        found = np.empty((2, len(approach)))
        arrays = (np.ascontiguousarray(one, float) for one in (approach, rate))
        _loads(self.numbers(), len(approach), *arrays, found)
        return found


class ContactPeriod(NamedTuple):
    """One interval of contact: start and duration [s], peak force [N], impulse [N s]."""

    start: float
    duration: float
    peak_force: float
    impulse: float


class Collision(NamedTuple):
    """One contact: its figures, and `history(times)` -> (approach [m], approach rate [m/s]) from its begin.

    `restitution` is the relative speed away over that before; `energy_closure` the energy gained by the method over
    the initial one.
    """

    contact: ContactPeriod
    greatest_approach: float
    restitution: float
    energy_closure: float
    history: Any
    steps: int = 0
    evaluations: int = 1


def collide(
    spring: Spring, reduced_mass: float, speed: float, method: str, tolerance: float, step: float, expected, touch=0.0
):
    """The contact of two bodies that begins at time 0, `touch` [s] after the run, with `speed` [m/s], by `method`.

    `expected` [s] is about its duration; `tolerance` holds for dop853, `step` [s] for the others. Raises
    IntegrationError where the load is not finite (a line law beyond its range) or separation never comes.
    """
    numbers = spring.numbers(reduced_mass)
    if method in FIXED_STEP:
        history, duration, last, cost = _by_fixed_steps(numbers, speed, method, step, expected, touch)
    else:
        scales = tolerance * np.array([speed * expected, speed, reduced_mass * speed**2])
        first = min(FIRST_STEP, tolerance ** (1.0 / START_ORDER)) * expected
        history, duration, last, cost = _by_controlled_steps(numbers, speed, scales, first, expected, touch)
    approach, rate = history(np.linspace(0.0, duration, SAMPLES))
    leaving, energy = -float(last[1]), 0.5 * reduced_mass * speed**2
    # Elastic energy that is left at the separation is lost.
    remaining = float(spring.loads(np.maximum(last[:1], 0.0), np.zeros(1))[1, 0])
    closure = (0.5 * reduced_mass * leaving**2 + float(last[2]) + remaining - energy) / energy
    peak = peak_of(spring.loads(approach, rate)[0])
    contact = ContactPeriod(0.0, duration, peak, reduced_mass * (speed + leaving))
    return Collision(contact, peak_of(approach), leaving / speed, closure, history, *cost)


def _refused(sentence: str, reason: str, seconds: float) -> IntegrationError:
    return IntegrationError(sentence, reason, seconds, FIRST, SECOND)


def _by_controlled_steps(numbers, speed, scales, first, expected, touch):
    """History, duration [s], last (approach, rate, energy dissipated) and cost."""
    nodes, written, counts = np.empty((MAX_ENDS + 1, 4)), np.zeros(1, np.int64), np.zeros(3, np.int64)
    least, longest = LEAST_STEP * expected, LONGEST * expected
    status = _follow(numbers, speed, scales, first, least, longest, len(nodes), SIGNALLED, nodes, written, counts)
    nodes = nodes[: written[0]].copy()
    end, approach = map(float, nodes[-1, :2])
    if status == STOPPED:
        raise Stopped("the computation was stopped")
    if status == STALLED:
        raise _refused(
            f"at {touch + end:.9g} s the contact load is not finite beyond an approach of {approach:.6g} m; the law "
            "does not reach so far",
            REASONS[NOT_FINITE],
            touch + end,
        )
    if status != SEPARATED:
        sentence = f"the bodies do not part within {longest:.6g} s; lower the damping"
        raise _refused(sentence, NO_END, touch + longest)

    def history(times):
        times = np.ascontiguousarray(np.clip(times, 0.0, end), float)
        states = np.empty((times.size, 2))
        _states(numbers, len(nodes), nodes, times.size, times, states)
        return states.T.reshape(2, *times.shape)

    return history, end, nodes[-1, 1:], (int(counts[STEPS]), int(counts[EVALUATIONS]))


def _by_fixed_steps(numbers, speed, method, step, expected, touch):
    nodes = np.empty((min(int(50 * max(expected / step, 1.0)) + 100, MAX_NODES), 4))
    count = _step(numbers, FIXED_STEP.index(method), speed, step, len(nodes), nodes)
    if count < 0:
        last, finite = float(nodes[-count - 1, 0]), np.isfinite(nodes[min(-count, len(nodes) - 1), 1:]).all()
        raise _refused(
            f"the bodies do not part, or the load is not finite, by {last:.6g} s with steps of {step:.6g} s; "
            "shorten solver.step",
            NO_END if finite else REASONS[NOT_FINITE],
            touch + last,
        )
    t, x, v, lost = nodes[:count].T
    curve = CubicHermiteSpline(t, x, v)
    # The touch lies between the first two nodes, the separation between the last two.
    start, *_, end = map(float, curve.roots(extrapolate=False))

    def history(times):
        inside = np.clip(np.asarray(times, float) + start, start, end)
        return curve(inside), curve(inside, 1)

    cost = count - 1, (count - 1) * (4 if method == "rk4" else 1)
    return history, end - start, np.array([0.0, v[-1], lost[-1]]), cost


def peak_of(values) -> float:
    """Greatest value of a smooth curve, by the parabola through the greatest sample and its neighbours.

    Samples are at equal distances.
    """
    top = int(np.argmax(values))
    if not 0 < top < len(values) - 1:
        return float(values[top])
    previous, middle, following = values[top - 1 : top + 2]
    curvature = previous - 2.0 * middle + following
    return float(middle if curvature == 0.0 else middle - 0.125 * (following - previous) ** 2 / curvature)


# Impacts as runs


@dataclass(frozen=True, eq=False)
class Impact:
    """An impact, solved: `at(times)` -> one array a channel at increasing times [s] from the start.

    `run` is the resolved one, `records` are the rows of the kind's tables, `costs` those of the solution.
    """

    outputs_at: Callable[[np.ndarray], tuple[np.ndarray, ...]]
    run: Any
    records: Mapping[str, np.ndarray]
    costs: dict[str, int]

    @cached_property
    def time(self) -> np.ndarray:
        """The instants [s] of the run's outputs, whole nanoseconds."""
        period_ns = max(1, round(1e9 / self.run.output_rate))
        return 1e-9 * period_ns * np.arange(int(1e9 * self.run.duration // period_ns) + 1)


class ImpactMotion:
    """An impact as a motion: solved when the first output after the start is requested, then evaluated.

    A record whose time lies beyond the last output of the scene's run is given with that output.
    """

    def __init__(self, solve, parameters, choice: Choice):
        self._solve = lambda: solve(parameters, choice.law, choice.stepper)
        self._start = None
        self.reset()

    def reset(self) -> None:
        """Back to the start; the solution is kept."""
        self._now, self._given = 0.0, -np.inf

    @cached_property
    def impact(self) -> Impact:
        """The solved impact."""
        return self._solve()

    def first_outputs(self):
        """The outputs at the start."""
        if self._start is None:
            self._start = self.impact.outputs_at(np.zeros(1))
        return self._start

    def advance(self, times: np.ndarray, duration: float):
        """The outputs at `times` [s] from now; then `duration` [s] have passed."""
        values = self.impact.outputs_at(self._now + times)
        self._now += duration
        return values

    def take_records(self) -> dict[str, np.ndarray]:
        """The records since the last call."""
        last, records = float(self.impact.time[-1]), {}
        now = round(1e9 * self._now)
        for name, rows in self.impact.records.items():
            rows = rows.copy()
            rows[:, 0] = np.minimum(rows[:, 0], last)
            records[name] = records_between(rows, self._given, now)
        self._given = now
        return records

    def costs(self) -> dict[str, int]:
        """Costs of the solution."""
        return dict(self.impact.costs)


def solve_spheres(parameters: TwoSpheresScene, law: str = "hertz", stepper: str = "closed_form") -> Impact:
    """The impact by `closed_form`, `dop853`, `rk4` or `symplectic_euler`; raises IntegrationError where one fails."""
    coefficient, first, second = sphere_pair(parameters)
    power, contact, speed = LAWS[law].power, parameters.contact, parameters.motion.speed
    reduced, steady, restitution = first * second / (first + second), contact.viscosity, contact.restitution
    damping = hunt_crossley_damping(contact, speed)
    if restitution < 1.0 and contact.damping_law == "steady":
        steady = steady_damping(restitution, coefficient, reduced, power)
    elif damping > 0.0:
        restitution = restitution_of(damping * speed)
    spring = Spring(coefficient, NO_LINE, damping, steady, power)
    closed = partial(_sphere_collision, (coefficient, reduced, speed), power, damping, restitution)
    return _solve(parameters, spring, (first, second), stepper, closed, impact_time(parameters))


def solve_discs(parameters: TwoDiscsScene, law: str = "johnson", stepper: str = "closed_form") -> Impact:
    """The impact with the law `line` or `johnson`, by a stepper as in `solve_spheres`; raises IntegrationError."""
    mass, line = mass_of(parameters.disc), disc_law(parameters.disc, law)
    bodies = line, 0.5 * mass, parameters.motion.speed
    duration = float(line_contact.contact_time(*bodies))
    closed = partial(_disc_collision, *bodies, duration)
    return _solve(parameters, Spring(0.0, line, 0.0), (mass, mass), stepper, closed, duration)


def _solve(parameters, spring: Spring, masses, stepper: str, closed: Callable[[], Collision], expected) -> Impact:
    """The impact of two bodies, of about the `expected` contact time [s]."""
    parameters = resolve(parameters)
    motion, total = parameters.motion, sum(masses)
    reduced = masses[0] * masses[1] / total
    drift = (masses[0] * motion.first_velocity + masses[1] * motion.second_velocity) / total
    touch = motion.gap / motion.speed
    if stepper == "closed_form":
        collision = closed()
    else:
        setting, step = SETTING * parameters.wanted.tolerance, parameters.solver.step or expected / 500.0
        collision = collide(spring, reduced, motion.speed, stepper, setting, step, expected, touch)
    leaving, duration = collision.restitution * motion.speed, collision.contact.duration
    last_approach = float(np.ravel(collision.history(np.array([duration]))[0])[0])

    def outputs_at(times):
        elapsed = np.asarray(times, float) - touch
        approach, rate = (np.array(part) for part in collision.history(np.clip(elapsed, 0.0, duration)))
        before, after = elapsed < 0.0, elapsed > duration
        separated = last_approach - leaving * (elapsed - duration)
        approach = np.where(before, motion.speed * elapsed, np.where(after, separated, approach))
        rate = np.where(before, motion.speed, np.where(after, -leaving, rate))
        inside = ~(before | after)
        load, stored = np.where(inside, spring.loads(approach, rate), 0.0)
        distance, mass_ratios = approach + motion.gap, np.array([masses[1], -masses[0]]) / total
        return (
            approach,
            load,
            drift * np.asarray(times, float)[:, None] + mass_ratios * distance[:, None],
            drift + mass_ratios * rate[:, None],
            0.5 * reduced * rate**2,
            stored,
        )

    gained = collision.energy_closure * 0.5 * reduced * motion.speed**2
    contact = collision.contact._replace(start=touch)
    rows = contact_rows((contact,), (collision.greatest_approach,), leaving, gained)
    return Impact(
        outputs_at, parameters.run, {"contact": rows}, {"steps": collision.steps, "evaluations": collision.evaluations}
    )


def _sphere_collision(bodies, power: float, damping: float, expected: float) -> Collision:
    """By closed forms, or with `damping` [s/m] by quadratures; `bodies`: coefficient, reduced mass, speed."""
    coefficient, reduced, speed = bodies
    duration, peak, deepest, restitution = hertz_impact.damped_impact(*bodies, damping, power)
    contact = ContactPeriod(0.0, float(duration), float(peak), reduced * speed * (1.0 + restitution))
    if damping == 0.0:
        closure = energies_at(coefficient, power, float(deepest)) / (0.5 * reduced * speed**2) - 1.0

        def history(times):
            approach = hertz_impact.approach_history(times, *bodies, power)
            slowed = np.sqrt(np.maximum(1.0 - (approach / deepest) ** (power + 1.0), 0.0))
            return approach, np.where(np.asarray(times) < 0.5 * duration, speed, -speed) * slowed
    else:
        closure = restitution**2 - expected**2
        curve = CubicHermiteSpline(*hertz_impact.damped_history(*bodies, damping, power))

        def history(times):
            return curve(times), curve(times, 1)

    return Collision(contact, float(deepest), restitution, closure, history)


def _disc_collision(line, reduced: float, speed: float, duration: float) -> Collision:
    peak = float(line_contact.peak_force(line, reduced, speed))
    times, approach, rates = _half_history(line, reduced, speed)
    times *= 0.5 * duration / times[-1]
    curve = CubicHermiteSpline(times, approach, rates)

    def history(elapsed):
        elapsed = np.asarray(elapsed, float)
        first = np.minimum(elapsed, duration - elapsed)
        return curve(first), np.where(elapsed < 0.5 * duration, 1.0, -1.0) * np.maximum(curve(first, 1), 0.0)

    contact = ContactPeriod(0.0, duration, peak, 2.0 * reduced * speed)
    closure = float(energy_of(line, peak)) / (0.5 * reduced * speed**2) - 1.0
    return Collision(contact, float(approach_of(line, peak)), 1.0, closure, history)


def _half_history(line, reduced: float, speed: float):
    """Times [s], approaches [m] and rates [m/s] from touch to standstill: dt = mu v sin(angle) / F d(angle)."""
    points, weights = np.polynomial.legendre.leggauss(6)
    edges = 0.5 * math.pi * np.linspace(0.0, 1.0, PIECES + 1) ** 1.5
    angles = edges[:-1, None] + 0.5 * (points + 1.0) * np.diff(edges)[:, None]
    initial_energy = 0.5 * reduced * speed**2
    slopes = reduced * speed * np.sin(angles) / load_of_energy(line, initial_energy * np.sin(angles) ** 2)
    spans = 0.5 * np.diff(edges) * np.sum(weights * slopes, axis=1)
    approach = approach_of(line, load_of_energy(line, initial_energy * np.sin(edges) ** 2))
    return np.concatenate([[0.0], np.cumsum(spans)]), approach, speed * np.cos(edges)


spheres, discs = partial(ImpactMotion, solve_spheres), partial(ImpactMotion, solve_discs)
"""Impacts as runs, of the parameters and the choice."""


def closed_spheres(parameters: TwoSpheresScene) -> ClosedForm | None:
    """Spheres without loss, many at once."""
    hertzian = LAWS[sphere_law(parameters)].power == HERTZIAN
    if not (hertzian and is_elastic(parameters.contact) and parameters.solver.stepper in ("auto", "closed_form")):
        return None
    return ClosedForm(
        bodies=closed_form_numbers,
        histories={"normal_load": hertz_impact.force_history, "approach": hertz_impact.approach_history},
        no_solution="the closed form is not finite at these values",
        without=("contact.restitution", "contact.damping", "contact.viscosity"),
    )


def closed_discs(parameters: TwoDiscsScene) -> ClosedForm | None:
    """Discs by quadrature, many at once."""
    if parameters.solver.stepper not in ("auto", "closed_form"):
        return None
    no_solution = "the law of line contact cannot store the energy of this impact"
    return ClosedForm(bodies=closed_form_numbers, histories={}, no_solution=no_solution)
