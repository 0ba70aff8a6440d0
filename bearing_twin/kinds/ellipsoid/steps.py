"""Steps of an ellipsoid on a plane: flight to the next touch, contact to the next separation, nothing stepped over.

In flight the approach bends at most by  B = g + w^2 (spread + 2 lean)  (w: greatest angular velocity at this angular
momentum), so from a gap it stays one until h + h' t + B t^2/2 = 0, and so on from there: quadratic convergence to the
touch, which is known to a few roundings of the height. In contact a step is at most a sixth of 1/sqrt(k/m) at the
greatest stiffness ahead, some 24 a bounce, and longer in a contact that lasts; separation is the zero of the approach
as a function of the last step's length.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.contact.elastic import elastic, greatest_approach, longest_contact_step
from bearing_twin.kinds.ellipsoid.equations import (
    COLUMNS,
    MOMENTUM,
    POSITION,
    QUATERNION,
    SHAPE,
    VELOCITY,
    VISCOUS,
    ellipsoid_rates,
    gap_of,
    pose_of,
    touch_of,
)
from bearing_twin.numerics.runge_kutta import runge_kutta_step
from bearing_twin.numerics.steppers import RungeKutta

TOUCHES, COUNTS = 3, 4
"""Of what is counted: touches, after the first three of `numerics.statuses`; all."""

ROUNDING = 1e-15  # of the body's size: gaps below are none


class EllipsoidPlan(NamedTuple):
    """How to step: a `RungeKutta` method, its tolerance, its fixed step in contact [s] (0 = adaptive).

    `spread` and `lean` [m] bound how fast the body's extent downwards bends when it turns, `floor` [s] is the shortest
    step: lift-offs and touches shorter than that are passed.
    """

    method: RungeKutta
    tolerance: float
    fixed: float
    spread: float
    lean: float
    floor: float


class EllipsoidWork(NamedTuple):
    """Arrays to work in.

    Stages (stages, COLUMNS), states of a trial, after a step and before the last, error scales, a state to look at.
    """

    stages: np.ndarray
    trial: np.ndarray
    after: np.ndarray
    before: np.ndarray
    scales: np.ndarray
    spare: np.ndarray


@kernel
def one_step(body, method, state, step, loaded, work, out):
    """Writes the state `step` [s] later, in contact (`loaded`) or flight; returns the error in units of `work.scales`.

    Zero for a method of fixed steps.
    """
    return runge_kutta_step(method, ellipsoid_rates, body, state, step, loaded, COLUMNS, work, out)


@kernel
def fill(array, first, count, value):
    """Sets `count` entries from `first`."""
    for i in range(first, first + count):
        array[i] = value


@kernel
def expected_approach(body, touch):
    """Greatest approach [m] from here on by an elastic impact, about: what the scales of a step follow."""
    spent = greatest_approach(touch.coefficient, body.law.power, touch.effective_mass, touch.approach_rate)
    return max(touch.approach, 0.0) + spent


@kernel
def contact_scales(body, plan, state, lasted, work):
    """Sets the error scales from the contact ahead; returns the longest step [s] for one that has `lasted` [s]."""
    touch = touch_of(body, state, pose_of(body, state))
    ahead = expected_approach(body, touch)
    size = max(body.semi_axes[0], max(body.semi_axes[1], body.semi_axes[2]))
    rate = math.sqrt(elastic(touch.coefficient, body.law.power, ahead).stiffness / touch.effective_mass)
    speed = ahead * rate
    fill(work.scales, POSITION, 3, max(plan.tolerance * ahead, ROUNDING * (abs(state[2]) + size)))
    fill(work.scales, QUATERNION, 4, max(plan.tolerance * ahead / size, ROUNDING))
    fill(work.scales, VELOCITY, 3, max(plan.tolerance * speed, ROUNDING * size * rate))
    fill(work.scales, MOMENTUM, 3, max(plan.tolerance * speed, ROUNDING * size * rate) * body.mass * size)
    fill(work.scales, VISCOUS, 2, max(plan.tolerance * speed, ROUNDING * size * rate) * body.mass * speed)
    fill(work.scales, SHAPE, 3, 10.0 * max(plan.tolerance, ROUNDING))
    return longest_contact_step(lasted, rate)


@kernel
def flight_scales(plan, work):
    """Sets the error scales of flight, where only the orientation has an error."""
    fill(work.scales, 0, COLUMNS, math.inf)
    fill(work.scales, QUATERNION, 4, plan.tolerance)


@kernel
def greatest_spin(body, state):
    """No angular velocity [rad/s] is greater at this angular momentum."""
    momentum = math.sqrt(state[10] ** 2 + state[11] ** 2 + state[12] ** 2)
    return momentum / min(body.inertia[0], min(body.inertia[1], body.inertia[2]))


@kernel
def safe_flight(body, plan, state):
    """Time [s] in which no touch is possible from a state in flight; inf where there is none for ever."""
    approach, rate = gap_of(body, state)
    gap = max(-approach, 0.0)
    bend = body.gravity + greatest_spin(body, state) ** 2 * (plan.spread + 2.0 * plan.lean)
    if bend == 0.0:
        return gap / rate if rate > 0.0 else math.inf
    root = math.sqrt(rate * rate + 2.0 * bend * gap)
    return 2.0 * gap / (root + rate) if rate > 0.0 else max((root - rate) / bend, plan.floor)


@kernel
def landed(body, state):
    """True if the gap is closed, or so nearly that no number can tell, and not opening."""
    approach, rate = gap_of(body, state)
    size = max(body.semi_axes[0], max(body.semi_axes[1], body.semi_axes[2]))
    return approach > 0.0 or (rate > 0.0 and approach >= -ROUNDING * (abs(state[2]) + size))
