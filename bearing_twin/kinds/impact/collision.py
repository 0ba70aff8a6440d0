"""Two bodies meeting on a line: the differential equation of their approach, by adaptive and by fixed-step methods.

mu x'' = -load(x, x'), x = 0 and x' = v at the first touch, until x comes back to zero. `dop853` (Hairer, order 8,
error controlled, by `numerics.adaptive`) gives the numbers; `rk4` and `symplectic_euler` are there to show what a fixed
step against contact stiffness does, so that nothing controls their steps or lands them on the parting, and are refused
above an eighth of the contact. An explicit Euler method is not offered: it still gains 40 % of speed with 16 steps a
contact.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from bearing_twin.base.errors import IntegrationError, Stopped
from bearing_twin.base.stopping import SIGNALLED
from bearing_twin.compiled import inlined, kernel, template
from bearing_twin.contact.damping import steady_held_load
from bearing_twin.kinds.impact.methods import FIXED_STEP
from bearing_twin.kinds.impact.parameters import FIRST, SECOND
from bearing_twin.kinds.impact.spring import Spring, rates, spring_elastic, spring_loads
from bearing_twin.numerics.adaptive import CURSOR, STEP, TIME, advance_adaptively
from bearing_twin.numerics.dop853 import DOP853
from bearing_twin.numerics.events import landing_step
from bearing_twin.numerics.runge_kutta import copy_numbers, runge_kutta_step
from bearing_twin.numerics.statuses import (
    EVALUATIONS,
    NO_END,
    NOT_FINITE,
    OK,
    SEPARATED,
    STALLED,
    STEPS,
    STOPPED,
    WORDS,
)
from bearing_twin.numerics.steppers import RK4

FEWEST_STEPS, FEW_STEPS = 8, 16  # of a fixed-step method in the shortest contact: refused below, warned below
MOST_STEPS = 100_000  # of it in a contact: refused above, as rounding is all that more of them add
MOST_NODES = 20 * MOST_STEPS  # until a contact is given up: half a second
MOST_ENDS = 10_000  # of steps of dop853
FIRST_STEP, LEAST_STEP, LONGEST = 1e-3, 1e-14, 100.0  # of the contact expected: first step, least, the whole


class ContactPeriod(NamedTuple):
    """One interval of contact: start and duration [s], peak force [N], impulse [N s]."""

    start: float
    duration: float
    peak_force: float
    impulse: float


class CollisionWork(NamedTuple):
    """Arrays to work in, as `advance_adaptively` wants them."""

    stages: np.ndarray
    trial: np.ndarray
    after: np.ndarray
    scales: np.ndarray


@inlined
def _rates(bodies, state, loaded, out):
    spring, reduced_mass = bodies
    rates(spring, reduced_mass, state, out)


@kernel
def march_fixed(method, spring, reduced_mass, speed, step, phase, nodes):
    """Marches one contact from `phase` of a step before the first touch; returns the nodes written, negative if full.

    `method` 0 = rk4, 1 = symplectic Euler; `nodes` (n, 4) receives time, approach, rate and dissipated energy. The
    first node is before the touch, the last after separation.
    """
    state, after, slopes = np.zeros(3), np.zeros(3), np.zeros(3)
    work = CollisionWork(np.zeros((len(RK4.weights), 3)), np.zeros(3), np.zeros(3), np.ones(3))
    state[0], state[1] = -phase * step * speed, speed
    nodes[0, 0], nodes[0, 1:] = -phase * step, state
    for n in range(1, len(nodes)):
        if method == 1:
            rates(spring, reduced_mass, state, slopes)
            state[1] += step * slopes[1]
            state[2] += step * slopes[2]
            state[0] += step * state[1]
        else:
            runge_kutta_step(RK4, _rates, (spring, reduced_mass), state, step, True, 3, work, after)
            state[:] = after
        nodes[n, 0], nodes[n, 1:] = (n - phase) * step, state
        if not math.isfinite(state[0] + state[1]):
            return -n
        if state[0] <= 0.0 and state[1] < 0.0:
            return n + 1
    return -len(nodes)


@kernel
def one_step(bodies, method, state, step, loaded, work, out):
    """Writes the state `step` [s] later; returns the error in units of `work.scales`."""
    return runge_kutta_step(method, _rates, bodies, state, step, loaded, 3, work, out)


@inlined
def _held(bodies, state):
    """Above zero in contact; of steady damping the load, whose parts cancel before the approach is zero again."""
    spring, held = bodies[0], state[0]
    if spring.steady > 0.0:
        depth = max(state[0], 0.0)
        held = steady_held_load(spring_elastic(spring, depth).load, depth, state[1], spring.steady, spring.power)
    return held


@template
def _look(bodies, state):
    return 0.0


@template
def _begin(bodies, least, state, clock, record, seen, counts, work):
    return OK, clock[STEP], least, True


@template
def _end(bodies, least, method, state, clock, seen, step, loaded, counts, work):
    parted = not _held(bodies, work.after) > 0.0 and math.isfinite(work.after[0])
    if parted:
        step = landing_step(_held, one_step, bodies, method, state, step, 0.0, work, counts)
    return OK, step, parted


@template
def _put_right(bodies, state):
    """Nothing is left open."""


@template
def _accept(bodies, least, method, state, clock, record, seen, step, following, loaded, parted, counts, work):
    copy_numbers(work.after, state)
    clock[STEP], record[0] = following, clock[TIME]
    copy_numbers(state, record[1:])
    return SEPARATED if parted else OK, seen, True


@kernel
def follow(bodies, least, state, clock, until, nodes, counts, work, stop):
    """Follows one contact from the touch to the parting; returns (status, nodes written).

    `nodes` (n, 4) receives time, approach, rate and dissipated energy at the ends of steps.
    """
    record, none = np.empty(4), np.empty(0)
    return advance_adaptively(
        _look, _begin, one_step, _end, _put_right, _accept,
        bodies, least, DOP853, state, clock, record, none, until, nodes, nodes, counts, work, stop,
    )  # fmt: skip


@kernel
def states_at(bodies, nodes, rows, times, states, work):
    """States (n, 3) at `times` [s], each by a step of its own from the node of that row before it."""
    for k in range(len(times)):
        node = nodes[rows[k]]
        one_step(bodies, DOP853, node[1:], times[k] - node[0], True, work, states[k])


@dataclass(frozen=True, eq=False)
class Collision:
    """One contact: its figures, and `history(times)` -> (approach [m], approach rate [m/s]) from the first touch on."""

    contact: ContactPeriod
    greatest_approach: float
    leaving_speed: float
    energy_closure: float
    history: Any
    steps: int
    evaluations: int


def collide(
    spring: Spring, reduced_mass: float, speed: float, method: str, tolerance: float, step: float, expected, touch=0.0
):
    """The contact of two bodies that touch at time 0, `touch` [s] after a run begins, with `speed` [m/s], by `method`.

    `expected` [s] is about its duration; `tolerance` holds for dop853, `step` [s] for the others. Raises
    IntegrationError where the load is not finite (a line law beyond its range) or separation never comes.
    """
    if method in FIXED_STEP:
        return _fixed(spring, reduced_mass, speed, method, step, expected, touch)
    bodies = spring, reduced_mass
    unit = np.array([speed * expected, speed, reduced_mass * speed**2])
    work = CollisionWork(np.zeros((len(DOP853.weights), 3)), np.zeros(3), np.zeros(3), tolerance * unit)
    nodes, state, clock = np.zeros((MOST_ENDS + 1, 4)), np.array([0.0, speed, 0.0]), np.zeros(CURSOR + 1)
    nodes[0, 1:], clock[STEP] = state, FIRST_STEP * expected
    counts, longest = np.zeros(3, np.int64), LONGEST * expected
    status, count = follow(bodies, LEAST_STEP * expected, state, clock, longest, nodes[1:], counts, work, SIGNALLED)
    if status == STOPPED:
        raise Stopped("the computation was stopped")
    if status == STALLED:
        seconds = touch + float(clock[TIME])
        raise IntegrationError(
            f"at {seconds:.9g} s the contact load is not finite beyond an approach of {state[0]:.6g} m; the law does "
            "not reach so far",
            WORDS[NOT_FINITE],
            seconds,
            FIRST,
            SECOND,
        )
    if status != SEPARATED:
        sentence = f"the bodies do not part within {longest:.6g} s; lower the damping"
        raise IntegrationError(sentence, NO_END, touch + longest, FIRST, SECOND)
    nodes = nodes[: count + 1].copy()
    end = float(nodes[-1, 0])

    def history(times):
        times = np.clip(np.asarray(times, float), 0.0, end)
        rows = np.clip(np.searchsorted(nodes[:, 0], times, side="right") - 1, 0, count - 1)
        found = np.empty((times.size, 3))
        states_at(bodies, nodes, rows.ravel(), times.ravel(), found, work)
        return found[:, :2].T.reshape(2, *times.shape)

    steps, evaluations = int(counts[STEPS]), int(counts[EVALUATIONS])
    return _collision(spring, reduced_mass, speed, history, 0.0, end, nodes[-1, 1:], steps, evaluations)


def _fixed(spring, reduced_mass, speed, method, step, expected, touch):
    nodes = np.empty((min(int(50 * max(expected / step, 1.0)) + 100, MOST_NODES), 4))
    count = march_fixed(FIXED_STEP.index(method), spring, reduced_mass, speed, step, 0.5, nodes)
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

    last = np.array([0.0, v[-1], lost[-1]])
    evaluations = (count - 1) * (4 if method == "rk4" else 1)
    return _collision(spring, reduced_mass, speed, history, start, end, last, count - 1, evaluations)


def _collision(spring, reduced_mass, speed, history, start, end, last, steps, evaluations):
    duration = end - start
    times = np.linspace(0.0, duration, 2001)
    approach, rate = history(times)
    load = spring_loads(spring, approach, rate)
    leaving = -float(last[1])
    energy = 0.5 * reduced_mass * speed**2
    # What is left is lost where bodies part before they are round again.
    left = float(spring_elastic(spring, max(float(last[0]), 0.0)).energy)
    closure = (0.5 * reduced_mass * leaving**2 + float(last[2]) + left - energy) / energy
    impulse = reduced_mass * (speed + leaving)
    contact = ContactPeriod(0.0, duration, peak_of(load), impulse)
    return Collision(contact, peak_of(approach), leaving, closure, history, steps, evaluations)


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
