"""Central impact of two bodies: the differential equation of their approach, by adaptive and fixed-step methods.

mu x'' = -load(x, x'), x = 0 and x' = v at the begin of the contact, until x returns to zero (`core/bodies/impact.hpp`).
`dop853` (Hairer, order 8, error controlled) is the method for results; `rk4` and `symplectic_euler` show the effect of
a fixed step on a stiff contact. Their steps are not controlled, do not end at the separation, and are refused above an
eighth of the contact time. An explicit Euler method is not offered: it gains 40 % of speed with 16 steps a contact.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from bearing_twin.base.errors import IntegrationError, Stopped
from bearing_twin.base.stopping import SIGNALLED
from bearing_twin.contact.laws import HERTZIAN
from bearing_twin.contact.line import LineLaw
from bearing_twin.core import FLAG, INTEGER, INTEGERS_OUT, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.bodies.parameters import FIRST, FIXED_STEP, SECOND
from bearing_twin.numerics.methods import (
    EVALUATIONS,
    NO_END,
    NOT_FINITE,
    SEPARATED,
    STALLED,
    STEPS,
    STOPPED,
    WORDS,
)

FEWEST_STEPS, FEW_STEPS = 8, 16  # of a fixed-step method in the shortest contact: refused below, warned below
MOST_STEPS = 100_000  # of it in a contact: refused above, as rounding is all that more of them add
MOST_NODES = 20 * MOST_STEPS  # until a contact is given up: half a second
MOST_ENDS = 10_000  # of steps of dop853
FIRST_STEP, LEAST_STEP, LONGEST = 1e-3, 1e-14, 100.0  # of the contact expected: first step, least, the whole
NO_LINE = LineLaw(0.0, 0.0, 0.0)

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

    `restitution` is the relative speed away over that before; `energy_closure` the energy gained by the numbers over
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
    if method in FIXED_STEP:
        return _fixed(spring, reduced_mass, speed, method, step, expected, touch)
    numbers, nodes = spring.numbers(reduced_mass), np.empty((MOST_ENDS + 1, 4))
    scales = tolerance * np.array([speed * expected, speed, reduced_mass * speed**2])
    first, least, longest = FIRST_STEP * expected, LEAST_STEP * expected, LONGEST * expected
    written, counts = np.zeros(1, np.int64), np.zeros(3, np.int64)
    status = _follow(
        *(numbers, speed, scales, first, least, longest, len(nodes), SIGNALLED),
        *(nodes, written, counts),
    )
    nodes = nodes[: written[0]].copy()
    if status == STOPPED:
        raise Stopped("the computation was stopped")
    if status == STALLED:
        seconds = touch + float(nodes[-1, 0])
        raise IntegrationError(
            f"at {seconds:.9g} s the contact load is not finite beyond an approach of {nodes[-1, 1]:.6g} m; the law "
            "does not reach so far",
            WORDS[NOT_FINITE],
            seconds,
            FIRST,
            SECOND,
        )
    if status != SEPARATED:
        sentence = f"the bodies do not part within {longest:.6g} s; lower the damping"
        raise IntegrationError(sentence, NO_END, touch + longest, FIRST, SECOND)
    end = float(nodes[-1, 0])

    def history(times):
        times = np.ascontiguousarray(np.clip(times, 0.0, end), float)
        found = np.empty((times.size, 2))
        _states(numbers, len(nodes), nodes, times.size, times, found)
        return found.T.reshape(2, *times.shape)

    cost = int(counts[STEPS]), int(counts[EVALUATIONS])
    return _collision(spring, reduced_mass, speed, history, end, nodes[-1, 1:], cost)


def _fixed(spring, reduced_mass, speed, method, step, expected, touch):
    nodes = np.empty((min(int(50 * max(expected / step, 1.0)) + 100, MOST_NODES), 4))
    count = _step(spring.numbers(reduced_mass), FIXED_STEP.index(method), speed, step, len(nodes), nodes)
    if count < 0:
        last, finite = nodes[-count - 1], np.isfinite(nodes[min(-count, len(nodes) - 1), 1:]).all()
        raise IntegrationError(
            f"the bodies do not part, or the load is not finite, by {last[0]:.6g} s with steps of {step:.6g} s; "
            "shorten solver.step",
            NO_END if finite else WORDS[NOT_FINITE],
            touch + float(last[0]),
            FIRST,
            SECOND,
        )
    t, x, v, lost = nodes[:count].T
    curve = CubicHermiteSpline(t, x, v)
    # The touch lies between the first two nodes, the separation between the last two.
    roots = curve.roots(extrapolate=False)
    start, end = float(roots[0]), float(roots[-1])

    def history(times):
        inside = np.clip(np.asarray(times, float) + start, start, end)
        return curve(inside), curve(inside, 1)

    cost = count - 1, (count - 1) * (4 if method == "rk4" else 1)
    return _collision(spring, reduced_mass, speed, history, end - start, np.array([0.0, v[-1], lost[-1]]), cost)


def _collision(spring, reduced_mass, speed, history, duration, last, cost):
    times = np.linspace(0.0, duration, 2001)
    approach, rate = history(times)
    load, _ = spring.loads(approach, rate)
    leaving = -float(last[1])
    energy = 0.5 * reduced_mass * speed**2
    # Elastic energy that is left at the separation is lost.
    left = float(spring.loads(np.maximum(last[:1], 0.0), np.zeros(1))[1, 0])
    closure = (0.5 * reduced_mass * leaving**2 + float(last[2]) + left - energy) / energy
    impulse = reduced_mass * (speed + leaving)
    contact = ContactPeriod(0.0, duration, peak_of(load), impulse)
    return Collision(contact, peak_of(approach), leaving / speed, closure, history, *cost)


def peak_of(values) -> float:
    """Greatest value of a smooth curve, by the parabola through the greatest sample and its neighbours.

    Samples are at equal distances.
    """
    top = int(np.argmax(values))
    if not 0 < top < len(values) - 1:
        return float(values[top])
    before, here, after = values[top - 1 : top + 2]
    bend = before - 2.0 * here + after
    return float(here if bend == 0.0 else here - 0.125 * (after - before) ** 2 / bend)
