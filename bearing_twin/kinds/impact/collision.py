"""Two bodies meeting on a line: the differential equation of their approach, by adaptive and by fixed-step methods.

mu x'' = -load(x, x'), x = 0 and x' = v at the first touch, until x comes back to zero. `dop853` (Hairer, order 8,
error controlled) gives the numbers; `rk4` and `symplectic_euler` are there to show what a fixed step against contact
stiffness does, and are refused above an eighth of the contact. An explicit Euler method is not offered: it still
gains 40 % of speed with 16 steps a contact.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact import line
from bearing_twin.contact.damping import damped_load, steady_damped_load
from bearing_twin.contact.elastic import HERTZIAN, elastic
from bearing_twin.contact.elasticity import line_elastic
from bearing_twin.errors import IntegrationError
from bearing_twin.numerics.runge_kutta import runge_kutta_step
from bearing_twin.numerics.steppers import RK4

FIXED_STEP = ("rk4", "symplectic_euler")
FEWEST_STEPS, FEW_STEPS = 8, 16  # of a fixed-step method in the shortest contact: refused below, warned below
MOST_STEPS = 100_000  # of it in a contact: refused above, as rounding is all that more of them add
MOST_NODES = 20 * MOST_STEPS  # until a contact is given up: half a second


class ContactPeriod(NamedTuple):
    """One interval of contact: start and duration [s], peak force [N], impulse [N s]."""

    start: float
    duration: float
    peak_force: float
    impulse: float


class Spring(NamedTuple):
    """The load between two bodies: `line_law.scale` > 0 selects line contact, else coefficient * approach^power.

    `damping` [s/m] multiplies the load by (1 + damping * approach rate); `steady` [N s/m^(5/4)] is the damping of
    `steady_damped_load`, which takes its place where it is above zero.
    """

    coefficient: float
    line_law: line.LineLaw
    damping: float
    steady: float = 0.0
    power: float = HERTZIAN


NO_LINE = line.LineLaw(0.0, 0.0, 0.0)


@kernel
def spring_elastic(spring, approach):
    """The elastic answer to an approach [m]."""
    if spring.line_law.scale > 0.0:
        return line_elastic(spring.line_law, approach)
    return elastic(spring.coefficient, spring.power, approach)


@kernel
def spring_load(spring, approach, approach_rate):
    """Load [N] with its viscous part."""
    answer = spring_elastic(spring, approach)
    if spring.steady > 0.0:
        return steady_damped_load(answer.load, approach, approach_rate, spring.steady, spring.power)
    return damped_load(answer.load, 0.0, approach_rate, spring.damping, 0.0)


@kernel
def spring_loads(spring, approaches, rates_of_approach):
    """Loads [N] at many approaches [m] and their rates [m/s]."""
    loads = np.empty(len(approaches))
    for i in range(len(approaches)):
        loads[i] = spring_load(spring, approaches[i], rates_of_approach[i])
    return loads


@kernel
def spring_energies(spring, approaches):
    """Energies [J] stored at many approaches [m]."""
    energies = np.empty(len(approaches))
    for i in range(len(approaches)):
        energies[i] = spring_elastic(spring, approaches[i]).energy
    return energies


@kernel
def rates(spring, reduced_mass, state, out):
    """Time derivative of (approach [m], approach rate [m/s], dissipated energy [J])."""
    load = spring_load(spring, state[0], state[1])
    out[0] = state[1]
    out[1] = -load / reduced_mass
    out[2] = (load - spring_elastic(spring, state[0]).load) * state[1]


class Work(NamedTuple):
    """Arrays to work in, as `runge_kutta_step` wants them."""

    stages: np.ndarray
    trial: np.ndarray
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
    work = Work(np.zeros((len(RK4.weights), 3)), np.zeros(3), np.ones(3))
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


def collide(spring: Spring, reduced_mass: float, speed: float, method: str, tolerance: float, step: float, expected):
    """The contact of two bodies that touch at time 0 with the relative `speed` [m/s], by `method`.

    `expected` [s] is about its duration; `tolerance` holds for dop853, `step` [s] for the others. Raises
    IntegrationError where the load is not finite (a line law beyond its range) or separation never comes.
    """
    if method in FIXED_STEP:
        return _fixed(spring, reduced_mass, speed, method, step, expected)
    out = np.empty(3)

    def right_hand_side(_, state):
        rates(spring, reduced_mass, state, out)
        if not np.isfinite(out).all():
            raise IntegrationError(
                f"the contact load is not finite at an approach of {state[0]:.6g} m; the law does not reach so far"
            )
        return out.copy()

    def separated(_, state):
        if spring.steady == 0.0:
            return state[0]
        # Apart where elastic and viscous part cancel, which is before the approach is back at zero.
        depth = max(state[0], 0.0)
        viscous = spring.steady * depth ** (0.5 * (spring.power - 1.0)) * state[1]
        return spring_elastic(spring, depth).load + viscous

    separated.terminal, separated.direction = True, -1.0
    scale = speed * expected
    absolute = tolerance * np.array([scale, speed, reduced_mass * speed**2])
    found = solve_ivp(
        right_hand_side, (0.0, 100.0 * expected), [0.0, speed, 0.0], "DOP853",
        events=separated, dense_output=True, rtol=max(tolerance, 3e-14), atol=absolute, first_step=1e-3 * expected,
    )  # fmt: skip
    if not len(found.t_events[0]):
        raise IntegrationError(f"the bodies do not part within {100.0 * expected:.6g} s; lower the damping")
    end, last = float(found.t_events[0][0]), found.y_events[0][0]

    def history(times):
        return found.sol(np.clip(times, 0.0, end))[:2]

    return _collision(spring, reduced_mass, speed, history, 0.0, end, last, len(found.t) - 1, found.nfev)


def _fixed(spring, reduced_mass, speed, method, step, expected):
    nodes = np.empty((min(int(50 * max(expected / step, 1.0)) + 100, MOST_NODES), 4))
    count = march_fixed(FIXED_STEP.index(method), spring, reduced_mass, speed, step, 0.5, nodes)
    if count < 0:
        raise IntegrationError(
            f"the bodies do not part, or the load is not finite, by {nodes[-count - 1, 0]:.6g} s with steps of "
            f"{step:.6g} s; shorten solver.step"
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
