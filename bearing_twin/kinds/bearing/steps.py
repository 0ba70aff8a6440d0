"""What the integration loops of the bearing share: costs, failures, checks of a state, and turning the balls.

The loops (`bearing_rosenbrock`, `bearing_groups`, `bearing_explicit`, `bearing_imex`) take `times` [s], increasing,
counted from the start of the chunk, all within `duration`; they advance `state` (N, COLUMNS) and `orientation` (N, 4)
to the end of the chunk and fill `states` (len(times), N, COLUMNS) and `orientations` (len(times), N, 4). `counts`
gathers the cost; the returned status is one of OK, NOT_FINITE, TOO_DEEP, STALLED, with the failing time and ball in
`failure`.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.kinds.bearing.equations import (
    AXIS_DISTANCE,
    COLUMNS,
    SPIN,
    VELOCITY,
    approaches,
)
from bearing_twin.numerics.rotation import turned

OK, NOT_FINITE, TOO_DEEP, STALLED = range(4)
STEPS, REJECTIONS, RATES, JACOBIANS = range(4)
LEAST_STEP = 1e-12  # seconds; a shorter step means that the equations cannot be followed
TOUCHING = 1e-11  # m: approaches below are neither contact nor gap
LANDED = 0.95  # share of a step: a contact that changes later in it is as good as at its end
DEEPEST = 0.1  # approach / ball radius beyond which bodies have run through each other


class Results(NamedTuple):
    """What a chunk fills in."""

    states: np.ndarray
    orientations: np.ndarray
    counts: np.ndarray
    failure: np.ndarray


@kernel
def relative_spin(row):
    """Angular velocity of a ball against the frame that turns with it around the axis, from one row of the state."""
    return (row[SPIN], row[SPIN + 1], row[SPIN + 2] - row[VELOCITY + 1] / row[AXIS_DISTANCE])


@kernel
def turn(orientation, start, middle, end, step, out):
    """Writes into `out` the orientation after `step` [s], from the motion at its start, middle and end."""
    quaternion = (orientation[0], orientation[1], orientation[2], orientation[3])
    result = turned(quaternion, relative_spin(start), relative_spin(middle), relative_spin(end), step)
    for part in range(4):
        out[part] = result[part]


@kernel
def changes_contact(bearing, start, end):
    """Whether a ball begins or ends a contact with a raceway between two states, other than by a hair."""
    for before, after in zip(approaches(bearing, start), approaches(bearing, end)):  # noqa: B905
        if before * after < 0.0 and min(abs(before), abs(after)) > TOUCHING:
            return True
    return False


@kernel
def check_ball(bearing, state, k):
    """OK, or why the state of ball k cannot be right."""
    total = 0.0
    for column in range(COLUMNS):
        total += abs(state[k, column])
    if not total < math.inf:
        return NOT_FINITE
    inner, outer = approaches(bearing, state[k])
    deepest = DEEPEST * bearing.ball_radius
    if inner > deepest or outer > deepest:
        return TOO_DEEP
    return OK


@kernel
def check_all(bearing, time, state, failure):
    """`check_ball` for every ball; a failure is noted with its time and ball."""
    for k in range(bearing.balls):
        status = check_ball(bearing, state, k)
        if status != OK:
            failure[0], failure[1] = time, k
            return status
    return OK
