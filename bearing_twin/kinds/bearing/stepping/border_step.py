"""Ring and cage in the stages of a Rosenbrock step: what `lanes` does for balls, number by number for the border."""

import math

import numpy as np

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces import border_rows as at
from bearing_twin.kinds.bearing.forces.layout import BORDER, PLACES, SHAFT_SPEED
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.steppers import five, rosenbrock_dense


@inlined
def _mixed(weights, numbers, i):
    """The weighted sum of the earlier stages; `i` counts through the numbers of one."""
    first = weights[0] * numbers[at.STAGES + i] + weights[1] * numbers[at.STAGES + at.WIDTH + i]
    then = weights[2] * numbers[at.STAGES + 2 * at.WIDTH + i] + weights[3] * numbers[at.STAGES + 3 * at.WIDTH + i]
    return first + then + weights[4] * numbers[at.STAGES + 4 * at.WIDTH + i]


@inlined
def border_stage_state(a, numbers):
    """The state at which a stage takes its rates: `NOW`, and `FINISH` after the last."""
    weights = five(a)
    for i in range(at.WIDTH):
        total = numbers[at.BEGIN + i] + _mixed(weights, numbers, i)
        numbers[at.NOW + i] = total
        numbers[at.FINISH + i] = total


@inlined
def border_right(c, d, step, numbers):
    """The right-hand side of a stage."""
    weights, inverse = five(c), 1.0 / step
    for i in range(at.WIDTH):
        known = numbers[at.RATES + i] + d * numbers[at.SLOPE + i]
        numbers[at.RIGHT + i] = known + inverse * _mixed(weights, numbers, i)


@inlined
def border_keep(stage, numbers):
    """Stores the solution as a stage's, as `numerics.rosenbrock` does."""
    first = at.STAGES + stage * at.WIDTH
    for i in range(min(at.WIDTH, len(numbers))):  # WIDTH, which LLVM must not know, as in `spot.over_spots`
        value = numbers[at.SOLUTION + i]
        numbers[np.uint64(first + i)] = value if abs(value) < math.inf else 0.0


@inlined
def border_finish(dense, numbers):
    """The end of the step, its error in units of the scales, and the terms of its interpolant."""
    third, fourth, total, count = five(dense[0]), five(dense[1]), 0.0, 0.0
    for i in range(at.WIDTH):
        numbers[at.FINISH + i] += numbers[at.SOLUTION + i]
        numbers[at.THIRD + i] = _mixed(third, numbers, i)
        numbers[at.FOURTH + i] = _mixed(fourth, numbers, i)
    for i in range(2 * PLACES):
        ratio = numbers[at.SOLUTION + i] * numbers[at.INVERSE_SCALES + i]
        total += ratio * ratio
    for i in range(PLACES):
        count += 2.0 * numbers[at.FREE + i]
    ratio = numbers[at.SOLUTION + SHAFT_SPEED] * numbers[at.INVERSE_SCALES + SHAFT_SPEED]
    total, count = total + ratio * ratio, count + numbers[at.TURNS]
    numbers[at.ERROR] = math.sqrt(total / max(count, 1.0))


@inlined
def border_at(numbers, first, out):
    """The state (BORDER,) of ring and cage that begins at `first`."""
    for i in range(BORDER):
        out[i] = numbers[first + i]


@lean_kernel
def border_inside(numbers, fraction, out):
    """The state (BORDER,) of ring and cage at `fraction` of the step."""
    for i in range(BORDER):
        begin, finish = numbers[at.BEGIN + i], numbers[at.FINISH + i]
        out[i] = rosenbrock_dense(fraction, begin, finish, numbers[at.THIRD + i], numbers[at.FOURTH + i])


@inlined
def copy_state(numbers, source, target):
    """Copies a state, or its rates, to another place."""
    for i in range(at.WIDTH):
        numbers[target + i] = numbers[source + i]


@inlined
def border_slope(share, numbers):
    """Turns the rates kept in `SLOPE`, that share of a step later, into h times their explicit change with time."""
    for i in range(at.WIDTH):
        numbers[at.SLOPE + i] = (numbers[at.SLOPE + i] - numbers[at.RATES + i]) / share
