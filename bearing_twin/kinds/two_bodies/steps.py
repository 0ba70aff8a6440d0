"""One step of two bodies in contact or flight: how far it may go, what its error is measured by, how it is put right.

In flight no point comes nearer than the bodies' greatest speeds against each other allow, so a step ends at the touch
or before it. In contact a step is at most a sixth of 1/sqrt(k/m) at the greatest stiffness ahead, some 24 a bounce, and
longer where the contact lasts; the error control finds begin and end.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.contact.elastic import elastic, greatest_approach, longest_contact_step
from bearing_twin.kinds.two_bodies.equations import pair_rates, touch_of
from bearing_twin.kinds.two_bodies.pair import (
    ALGEBRAIC,
    BODY,
    CARRIED,
    COLUMNS,
    DIFFERENTIAL,
    LOAD_IMPULSE,
    MOMENTUM,
    MOVING,
    POSITION,
    QUATERNION,
    SECOND,
    UNKNOWNS,
    VELOCITY,
    VISCOUS,
    approach_of,
    body_at,
    residual_of,
    track,
)
from bearing_twin.numerics.dop853 import DOP853
from bearing_twin.numerics.runge_kutta import runge_kutta_step
from bearing_twin.shapes.tracking import LAMBDA, MU, projected

METHOD = DOP853

LONGEST_FLIGHT, TURN = 0.05, 0.1  # s and rad a step in flight
ROUNDING = 1e-15


class PairPlan(NamedTuple):
    """How to step: tolerance of a contact, and the shortest step [s] of flight, which may end in a touch."""

    tolerance: float
    floor: float


class PairWork(NamedTuple):
    """Arrays to work in.

    Stages (stages, COLUMNS), states of a trial, after a step, before it and the one before, and of a look at a peak,
    and error scales.
    """

    stages: np.ndarray
    trial: np.ndarray
    after: np.ndarray
    scales: np.ndarray
    now: np.ndarray
    before: np.ndarray
    spare: np.ndarray


@kernel
def one_step(pair, method, state, step, loaded, work, out):
    """Writes the state `step` [s] later; returns the error in units of `work.scales`."""
    return runge_kutta_step(method, pair_rates, pair, state, step, loaded, MOVING, work, out)


@kernel
def finish(pair, state):
    """Puts right at the end of a step what it leaves open: quaternions, opposing points.

    Returns (the norms' drift, how far [m] the points were off).
    """
    drift = 0.0
    for first in (QUATERNION, SECOND + QUATERNION):
        norm = 0.0
        for i in range(first, first + 4):
            norm += state[i] * state[i]
        norm = math.sqrt(norm)
        drift = max(drift, abs(norm - 1.0))
        for i in range(first, first + 4):
            state[i] /= norm
    a, b = body_at(pair.a, state, 0), body_at(pair.b, state, SECOND)
    unknowns = state[UNKNOWNS : UNKNOWNS + 8].copy()
    off = residual_of(a, b, unknowns) if pair.tracking == DIFFERENTIAL else 0.0
    if pair.tracking == DIFFERENTIAL:
        unknowns = projected(a, b, unknowns)
    else:
        track(pair, a, b, unknowns)
    if pair.tracking == ALGEBRAIC:
        off = residual_of(a, b, unknowns)
    state[UNKNOWNS : UNKNOWNS + 8] = unknowns
    return drift, off


@kernel
def touch_now(pair, state):
    """The contact of a finished state."""
    a, b = body_at(pair.a, state, 0), body_at(pair.b, state, SECOND)
    return touch_of(pair, a, b, state[UNKNOWNS : UNKNOWNS + 8].copy(), state[CARRIED:COLUMNS])


@kernel
def gap_rates(pair, state):
    """Approach [m] of a finished state, a bound [m/s] of the speed at which a gap closes, and the fall's [m/s^2].

    No point of a body is faster than its centre and its turning together, seen as far out as the other one reaches.
    """
    a, b = body_at(pair.a, state, 0), body_at(pair.b, state, SECOND)
    between = a.position - b.position
    distance = math.sqrt(between @ between)
    reach_a, reach_b = min(pair.a.reach, distance + pair.b.reach), min(pair.b.reach, distance + pair.a.reach)
    relative = a.velocity - b.velocity
    speed = math.sqrt(relative @ relative) + math.sqrt(a.spin @ a.spin) * reach_a + math.sqrt(b.spin @ b.spin) * reach_b
    fall = 0.0
    if (pair.a.inverse_mass > 0.0) != (pair.b.inverse_mass > 0.0):
        fall = math.sqrt(pair.gravity[0] ** 2 + pair.gravity[1] ** 2 + pair.gravity[2] ** 2)
    spin = max(math.sqrt(a.spin @ a.spin), math.sqrt(b.spin @ b.spin))
    return approach_of(b, state[UNKNOWNS : UNKNOWNS + 8].copy()), speed, fall, spin


@kernel
def flight_step(pair, plan, state):
    """Time [s] to step in flight: nothing touches before, but for the shortest step."""
    approach, speed, fall, spin = gap_rates(pair, state)
    gap = max(-approach, 0.0)
    root = math.sqrt(speed * speed + 2.0 * fall * gap)
    safe = 2.0 * gap / (root + speed) if root + speed > 0.0 else math.inf
    return min(max(safe, plan.floor), min(LONGEST_FLIGHT, TURN / max(spin, 1e-9)))


@kernel
def contact_scales(pair, plan, touch, lasted, scales):
    """Sets the error scales from the contact ahead; returns the longest step [s] for one that has `lasted` [s]."""
    power = 1.5 if pair.over_lens else pair.law.power
    spent = greatest_approach(touch.coefficient, power, touch.effective_mass, touch.approach_rate)
    weight = math.sqrt(pair.gravity[0] ** 2 + pair.gravity[1] ** 2 + pair.gravity[2] ** 2) * touch.effective_mass
    ahead = max(max(touch.approach, 0.0) + spent, (weight / touch.coefficient) ** (1.0 / power))
    ahead = max(ahead, ROUNDING * pair.size)
    rate = math.sqrt(elastic(touch.coefficient, power, ahead).stiffness / touch.effective_mass)
    speed, size = ahead * rate, pair.size
    place, swift = max(plan.tolerance * ahead, ROUNDING * size), max(plan.tolerance * speed, ROUNDING * size * rate)
    scales[:] = 1e300
    for side in range(2):
        rigid = pair.a if side == 0 else pair.b
        if rigid.inverse_mass > 0.0:
            first = side * SECOND
            scales[first + POSITION : first + POSITION + 3] = place
            scales[first + QUATERNION : first + QUATERNION + 4] = place / size
            scales[first + VELOCITY : first + VELOCITY + 3] = swift
            scales[first + MOMENTUM : first + BODY] = swift * rigid.mass * size
    scales[VISCOUS : VISCOUS + 4] = swift * touch.effective_mass * speed
    scales[LOAD_IMPULSE : LOAD_IMPULSE + 4] = swift * touch.effective_mass
    if pair.tracking == DIFFERENTIAL:
        scales[UNKNOWNS : UNKNOWNS + 6] = place
        scales[UNKNOWNS + LAMBDA], scales[UNKNOWNS + MU] = place / size, place
    return longest_contact_step(lasted, rate)


@kernel
def flight_scales(pair, plan, scales):
    """Sets the error scales of flight, where only orientations and points followed have an error."""
    scales[:] = 1e300
    scales[QUATERNION : QUATERNION + 4] = plan.tolerance
    scales[SECOND + QUATERNION : SECOND + QUATERNION + 4] = plan.tolerance
    if pair.tracking == DIFFERENTIAL:
        scales[UNKNOWNS : UNKNOWNS + 8] = plan.tolerance * pair.size
        scales[UNKNOWNS + LAMBDA] = plan.tolerance
