"""Where a bearing's forces are least certain: what a step's own error estimate does to them, noted as it goes.

A Rosenbrock step knows its error in the motion. With the Jacobian at its start that becomes an error in the net force
and the net torque on the ball. That Jacobian does not know of a contact that begins within the step: of a ball alone,
the rates at the start of a step are therefore compared with those of the last stage before, which are off by the same
error. As values all these are poor; they point to where a tighter companion is worth its steps.
"""

import math

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces.layout import (
    FORCE_ERROR,
    LAST_RATES,
    MOTION,
    SPIN,
    TORQUE_ERROR,
    VELOCITY,
    entry,
)
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
    put,
)
from bearing_twin.numerics.lean import lean_kernel

POINTED = 3  # numbers of a ball and an interval between instants: error of force, of torque, and steps
OF_FORCE, OF_TORQUE, STEPS_IN = range(POINTED)


@inlined
def _jump(first, lanes, k):
    """The squared length of how far three rates at a step's start are from those of the last stage before."""
    gain = get(lanes, GAIN, k)
    per_gain, drift, jumped = 1.0 / gain, gain / get(lanes, STEP, k), 0.0
    for rate in range(3):
        # What the first stage solves says what the rates were: u / (h g) = rates + J u + g (h times their change).
        begun = get(lanes, FIRST_STAGE + first + rate, k) * per_gain
        begun -= drift * get(lanes, SLOPE + first + rate, k)
        begun -= get(lanes, LAST_RATES + first - VELOCITY + rate, k)
        for column in range(MOTION):
            begun -= get(lanes, entry(first + rate, column), k) * get(lanes, FIRST_STAGE + column, k)
        jumped += begun * begun
    return jumped


@lean_kernel
def _square(alone, first, lanes, row):
    """Writes the squared length of three rates' errors, from `first` on, into a row; of two such of balls `alone`.

    `alone` is empty for balls that are coupled.
    """
    for k in range(LANES):
        total = 0.0
        for rate in range(3):
            error = 0.0
            for column in range(MOTION):
                error += get(lanes, entry(first + rate, column), k) * get(lanes, SOLUTION + column, k)
            total += error * error
        put(lanes, row, k, total)
    if len(alone) > 0:
        for k in range(LANES):
            jumped = _jump(first, lanes, k) if get(lanes, TIME, k) > 0.0 else 0.0
            put(lanes, row, k, max(get(lanes, row, k), jumped))


@inlined
def point_out(coupling, pointer, blocks):
    """Finds what the errors of the steps just made do to force and torque, where a `pointer` wants them."""
    if len(pointer) > 0:
        balls_alone = alone(coupling)
        for block in range(len(blocks)):
            _square(balls_alone, VELOCITY, blocks[block], FORCE_ERROR)
            _square(balls_alone, SPIN, blocks[block], TORQUE_ERROR)


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
                pointer[number, at, kind] = max(pointer[number, at, kind], math.sqrt(get(lanes, row, k)))
            pointer[number, at, STEPS_IN] += 1.0
            for rate in range(SPIN + 3 - VELOCITY):
                put(lanes, LAST_RATES + rate, k, get(lanes, LANE_RATES + VELOCITY + rate, k))
