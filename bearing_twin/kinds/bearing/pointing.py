"""Where a bearing's forces are least certain: what a step's own error estimate does to them, noted as it goes.

A Rosenbrock step knows its error in the motion. With the Jacobian at its start that becomes an error in the net force
and the net torque on the ball. As values these are poor; they point to where a tighter companion is worth its steps.
"""

import math

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
from bearing_twin.numerics.lean import lean_kernel

POINTED = 3  # numbers of a ball and an interval between instants: error of force, of torque, and steps
OF_FORCE, OF_TORQUE, STEPS_IN = range(POINTED)


@lean_kernel
def _square(first, lanes, row):
    """Writes the squared length of three rates' errors, from `first` on, into a row."""
    for k in range(LANES):
        total = 0.0
        for rate in range(3):
            error = 0.0
            for column in range(MOTION):
                error += get(lanes, entry(first + rate, column), k) * get(lanes, SOLUTION + column, k)
            total += error * error
        put(lanes, row, k, total)


@lean_kernel
def point_out(pointer, blocks):
    """Finds what the errors of the steps just made do to force and torque, where a `pointer` wants them."""
    if len(pointer) > 0:
        for block in range(len(blocks)):
            _square(VELOCITY, blocks[block], FORCE_ERROR)
            _square(SPIN, blocks[block], TORQUE_ERROR)


@lean_kernel
def note_error(pointer, number, cell, lanes, k):
    """Notes an accepted step of ball `number` before instant `cell` in `pointer` (N, cells, POINTED), if there is one.

    Kept are the greatest errors of the ball's acceleration [m/s^2] and angular acceleration [rad/s^2] in the cell.
    """
    if len(pointer) > 0:
        at = min(cell, pointer.shape[1] - 1)
        for kind, row in ((OF_FORCE, FORCE_ERROR), (OF_TORQUE, TORQUE_ERROR)):
            pointer[number, at, kind] = max(pointer[number, at, kind], math.sqrt(get(lanes, row, k)))
        pointer[number, at, STEPS_IN] += 1.0
