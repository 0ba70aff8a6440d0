"""Where a bearing's forces are least certain: what a step's own error estimate does to them, noted as it goes.

A Rosenbrock step knows its error in the motion. With the Jacobian at its start that becomes an error in the net force
and the net torque on the ball. As values these are poor; they point to where a tighter companion is worth its steps.
"""

import math

from bearing_twin.compiled import kernel
from bearing_twin.kinds.bearing.layout import (
    FORCE_ERROR,
    LANES,
    MOTION,
    SOLUTION,
    SPIN,
    TORQUE_ERROR,
    VELOCITY,
    entry,
    get,
    put,
)

POINTED = 3  # numbers of a ball and an interval between instants: error of force, of torque, and steps
OF_FORCE, OF_TORQUE, STEPS_IN = range(POINTED)


@kernel
def _square(first, lanes, row):
    """Writes the squared length of three rates' errors, from `first` on, into a row."""
    for k in range(LANES):
        put(lanes, row, k, 0.0)
    for rate in range(3):
        for k in range(LANES):
            error = 0.0
            for column in range(MOTION):
                error += get(lanes, entry(first + rate, column), k) * get(lanes, SOLUTION + column, k)
            put(lanes, row, k, get(lanes, row, k) + error * error)


@kernel
def point_out(pointer, blocks):
    """Finds what the errors of the steps just made do to force and torque, where a `pointer` wants them."""
    if len(pointer) > 0:
        for block in range(len(blocks)):
            _square(VELOCITY, blocks[block], FORCE_ERROR)
            _square(SPIN, blocks[block], TORQUE_ERROR)


@kernel
def note_error(pointer, number, cell, lanes, k):
    """Notes an accepted step of ball `number` before instant `cell` in `pointer` (N, cells, POINTED), if there is one.

    Kept are the greatest errors of the ball's acceleration [m/s^2] and angular acceleration [rad/s^2] in the cell.
    """
    if len(pointer) > 0:
        at = pointer[number, min(cell, pointer.shape[1] - 1)]
        at[OF_FORCE] = max(at[OF_FORCE], math.sqrt(get(lanes, FORCE_ERROR, k)))
        at[OF_TORQUE] = max(at[OF_TORQUE], math.sqrt(get(lanes, TORQUE_ERROR, k)))
        at[STEPS_IN] += 1.0
