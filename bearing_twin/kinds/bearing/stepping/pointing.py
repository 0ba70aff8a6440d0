"""Where a bearing's forces are least certain: what a step's own error estimate does to them, noted as it goes.

A Rosenbrock step knows its error in the motion. With the Jacobian at its start that becomes an error in the net force
and the net torque on the ball. That Jacobian does not know of a contact that begins within the step: of a ball alone,
the rates at the start of a step are therefore compared with those of the last stage before, which are off by the same
error. As values all these are poor; they point to where a tighter companion is worth its steps.
"""

import math

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces.jacobian import lane_answer
from bearing_twin.kinds.bearing.forces.layout import FORCE_ERROR, LAST_RATES, SPIN, TORQUE_ERROR, VELOCITY
from bearing_twin.kinds.bearing.stepping.landings import alone
from bearing_twin.numerics.lanes import (
    FIRST_STAGE,
    GAIN,
    LANE_RATES,
    LANES,
    SLOPE,
    SOLUTION,
    STEP,
    TIME,
    UNTIL,
    get,
    get_vector,
    put,
)
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rotation import add, dot, minus, scaled

POINTED = 3  # numbers of a ball and an interval between instants: error of force, of torque, and steps
OF_FORCE, OF_TORQUE, STEPS_IN = range(POINTED)


@inlined
def _motion(lanes, row, k):
    """Position, velocity and spin that stand in the rows from `row` on."""
    return get_vector(lanes, row, k), get_vector(lanes, row + VELOCITY, k), get_vector(lanes, row + SPIN, k)


@inlined
def _three_answers(lanes, first, k, motion):
    """What an increment of the motion does to three rates, from `first` on."""
    return (
        lane_answer(lanes, first, k, *motion),
        lane_answer(lanes, first + 1, k, *motion),
        lane_answer(lanes, first + 2, k, *motion),
    )


@inlined
def _jump(first, lanes, k):
    """How far three rates at a step's start are from those of the last stage before."""
    per_gain = 1.0 / get(lanes, GAIN, k)
    # What the first stage solves says what the rates were: u / (h g) = rates + J u + g (h times their change).
    begun = scaled(per_gain, get_vector(lanes, FIRST_STAGE + first, k))
    drift = scaled(get(lanes, GAIN, k) / get(lanes, STEP, k), get_vector(lanes, SLOPE + first, k))
    answers = _three_answers(lanes, first, k, _motion(lanes, FIRST_STAGE, k))
    return minus(minus(begun, drift), add(get_vector(lanes, LAST_RATES + first - VELOCITY, k), answers))


@inlined
def _effect(alone, first, lanes, k, error):
    """The length of what the `error` of a step does to three rates, from `first` on; of balls `alone` or of a jump."""
    change = _three_answers(lanes, first, k, error)
    square = dot(change, change)
    if len(alone) > 0:
        jump = _jump(first, lanes, k)
        square = max(square, dot(jump, jump) if get(lanes, TIME, k) > 0.0 else 0.0)
    return math.sqrt(square)


@lean_kernel
def _put_effects(alone, lanes):
    """Writes what the errors of steps do to force and torque; `alone` is empty for balls that are coupled."""
    for k in range(LANES):
        error = _motion(lanes, SOLUTION, k)
        put(lanes, FORCE_ERROR, k, _effect(alone, VELOCITY, lanes, k, error))
        put(lanes, TORQUE_ERROR, k, _effect(alone, SPIN, lanes, k, error))


@inlined
def point_out(coupling, pointer, blocks):
    """Finds what the errors of the steps just made do to force and torque, where a `pointer` wants them."""
    if len(pointer) > 0:
        balls_alone = alone(coupling)
        for block in range(len(blocks)):
            _put_effects(balls_alone, blocks[block])


@lean_kernel
def note_errors(pointer, held, cursor, first, lanes):
    """Notes the accepted steps of a block in `pointer` (N, cells, POINTED), if there is one.

    The block's first place is number `first`; its balls are `held`, their next instants in `cursor` are the cells. Kept
    are the greatest errors of a ball's acceleration [m/s^2] and angular acceleration [rad/s^2] in the cell.
    """
    if len(pointer) > 0:
        for k in range(LANES):
            if get(lanes, UNTIL, k) < 0.0:
                continue
            number, at = held[first + k], min(cursor[first + k], pointer.shape[1] - 1)
            for kind, row in ((OF_FORCE, FORCE_ERROR), (OF_TORQUE, TORQUE_ERROR)):
                pointer[number, at, kind] = max(pointer[number, at, kind], get(lanes, row, k))
            pointer[number, at, STEPS_IN] += 1.0
            for rate in range(SPIN + 3 - VELOCITY):
                put(lanes, LAST_RATES + rate, k, get(lanes, LANE_RATES + VELOCITY + rate, k))
