"""What the integration loops of the bearing share: costs, failures, checks of a state, dense steps, turning the balls.

The loops (`rosenbrock`, `explicit`, `imex`) take `times` [s], increasing,
counted from the start of the chunk, all within `duration`; they advance `state` (N, COLUMNS) and `orientation` (N, 4)
to the end of the chunk and fill `states` (len(times), N, COLUMNS) and `orientations` (len(times), N, 4). `counts`
gathers the cost; the returned status is one of OK, NOT_FINITE, TOO_DEEP, STALLED, with the failing time and ball in
`failure`.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.equations import approaches
from bearing_twin.kinds.bearing.layout import (
    AXIAL_SPIN,
    AXIS_DISTANCE,
    COLUMNS,
    MOTION,
    RADIAL_SPIN,
    TANGENTIAL_SPIN,
    TANGENTIAL_VELOCITY,
)
from bearing_twin.numerics.rotation import turned
from bearing_twin.numerics.statuses import NOT_FINITE, OK, STALLED, TOO_DEEP
from bearing_twin.numerics.steppers import rosenbrock_dense

STEPS, REJECTIONS, RATES, JACOBIANS = range(4)
LEAST_STEP = 1e-12  # seconds; a shorter step means that the equations cannot be followed
TOUCHING = 1e-11  # m: approaches below are neither contact nor gap
LANDED = 0.95  # share of a step: a contact that changes later in it is as good as at its end
DEEPEST = 0.1  # approach / ball radius beyond which bodies have run through each other

FAILURES = {
    NOT_FINITE: ("not finite", "is not finite any more; shorten solver.step or use solver.stepper: rodas4"),
    TOO_DEEP: ("too deep", "has run through a raceway; check the loads, or shorten solver.step"),
    STALLED: (
        "stalled",
        "needs ever shorter steps; loosen wanted.tolerance or raise contact.friction_regularisation",
    ),
}


class Results(NamedTuple):
    """What a chunk fills in; `stop` (1,) is looked at before every step, and ends the chunk when it is not 0.

    `carried` (N, CARRIED_COLUMNS) is what the law carries at each ball's contacts, at the chunk's start and its end.
    `border` (len(times), BORDER) and `last_border` (BORDER,) are those of ring and cage, where a method moves them.
    `pointer`, where it is not empty, takes what `pointing` notes.
    """

    states: np.ndarray
    orientations: np.ndarray
    counts: np.ndarray
    failure: np.ndarray
    stop: np.ndarray
    carried: np.ndarray
    border: np.ndarray
    last_border: np.ndarray
    pointer: np.ndarray


class DenseStep(NamedTuple):
    """One ball's Rosenbrock step: its start, its end, and the two terms of `rosenbrock_dense`, each (COLUMNS,).

    `orientation` (4,) is that at the start, `between` (COLUMNS,) room for a state inside the step.
    """

    start: np.ndarray
    end: np.ndarray
    third: np.ndarray
    fourth: np.ndarray
    orientation: np.ndarray
    between: np.ndarray


@inlined
def spin_in_frame(axis_distance, tangential_velocity, spin):
    """Angular velocity of a ball against the frame that turns with it around the axis [rad/s]."""
    return (spin[0], spin[1], spin[2] - tangential_velocity / axis_distance)


@kernel
def relative_spin(row):
    """`spin_in_frame` from one row of the state."""
    spin = (row[RADIAL_SPIN], row[TANGENTIAL_SPIN], row[AXIAL_SPIN])
    return spin_in_frame(row[AXIS_DISTANCE], row[TANGENTIAL_VELOCITY], spin)


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
def error_norm(errors, scales):
    """Root mean square of a motion's errors (MOTION,), in units of the scales; infinite where it is not finite."""
    total = 0.0
    for column in range(MOTION):
        ratio = errors[column] / scales[column]
        total += ratio * ratio
    total = math.sqrt(total / MOTION)
    return total if total < math.inf else math.inf


@kernel
def new_dense_step():
    """Room for a `DenseStep`."""
    return DenseStep(
        start=np.zeros(COLUMNS),
        end=np.zeros(COLUMNS),
        third=np.zeros(COLUMNS),
        fourth=np.zeros(COLUMNS),
        orientation=np.zeros(4),
        between=np.zeros(COLUMNS),
    )


@kernel
def interpolate(dense, fraction, out):
    """The state (COLUMNS,) at `fraction` of a dense step."""
    for column in range(COLUMNS):
        out[column] = rosenbrock_dense(
            fraction, dense.start[column], dense.end[column], dense.third[column], dense.fourth[column]
        )


@kernel
def landing(bearing, dense):
    """Share of a dense step, in which a contact with a raceway begins or ends, after which it just has."""
    low, high = 0.0, 1.0
    while high - low > 1e-6:
        share = 0.5 * (low + high)
        interpolate(dense, share, dense.between)
        if changes_contact(bearing, dense.start, dense.between):
            high = share
        else:
            low = share
    return high


@kernel
def give_out(times, cursor, until, time, step, ball, dense, results):
    """Writes a ball's instants up to `until` inside its step from `time` on; returns the next instant to serve."""
    states, orientations = results.states, results.orientations
    while cursor < len(times) and times[cursor] <= until:
        fraction = (times[cursor] - time) / step
        state = states[cursor, ball]
        interpolate(dense, fraction, state)
        interpolate(dense, 0.5 * fraction, dense.between)
        turn(dense.orientation, dense.start, dense.between, state, fraction * step, orientations[cursor, ball])
        cursor += 1
    return cursor


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
