"""What the steppers of the bearing share: failures, checks of a state, dense steps.

They (`rosenbrock`, `explicit`, `imex`) take `times` [s], increasing,
counted from the start of the chunk, all within `duration`; they advance `state` (N, COLUMNS) and `orientation` (N, 4)
to the end of the chunk and fill `states` (len(times), N, COLUMNS) and `orientations` (len(times), N, 4). `counts`
gathers the cost; the returned status is one of OK, STOPPED, NOT_FINITE, TOO_DEEP, STALLED, with the failing time and
ball in `failure`.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.forces.equations import approaches
from bearing_twin.kinds.bearing.forces.layout import (
    AXIAL_SPIN,
    AXIS_DISTANCE,
    RADIAL_SPIN,
    SPIN,
    TANGENTIAL_SPIN,
    TANGENTIAL_VELOCITY,
)
from bearing_twin.numerics.events import halved
from bearing_twin.numerics.lanes import COLUMNS, get, get_vector
from bearing_twin.numerics.rosenbrock_inside import interpolate
from bearing_twin.numerics.statuses import NOT_FINITE, OK, STALLED, TOO_DEEP

TOUCHING = 1e-11  # m: approaches below are neither contact nor gap
DEEPEST = 0.1  # approach / ball radius beyond which bodies have run through each other

FAILURES = {
    NOT_FINITE: "is not finite any more; shorten solver.step or use solver.stepper: rodas4",
    TOO_DEEP: "has run through a raceway; check the loads, or shorten solver.step",
    STALLED: "needs ever shorter steps; loosen wanted.tolerance or raise contact.friction_regularisation",
}


class Results(NamedTuple):
    """What a chunk fills in; `stop` (1,) is looked at before every step, and ends the chunk when it is not 0.

    `carried` (N, CARRIED_COLUMNS) is what the law carries at each ball's contacts, at the chunk's start and its end.
    `border` (len(times), BORDER) and `last_border` (BORDER,) are those of ring and cage, where a method moves them.
    """

    states: np.ndarray
    orientations: np.ndarray
    counts: np.ndarray
    failure: np.ndarray
    stop: np.ndarray
    carried: np.ndarray
    border: np.ndarray
    last_border: np.ndarray


class DenseStep(NamedTuple):
    """One ball's Rosenbrock step: its start, its end, and the two terms of `rosenbrock_dense`, each (COLUMNS,).

    `between` (COLUMNS,) is room for a state inside the step.
    """

    start: np.ndarray
    end: np.ndarray
    third: np.ndarray
    fourth: np.ndarray
    between: np.ndarray


@inlined
def spin_in_frame(axis_distance, tangential_velocity, spin):
    """Angular velocity of a ball against the frame that turns with it around the axis [rad/s]."""
    return (spin[0], spin[1], spin[2] - tangential_velocity / axis_distance)


@inlined
def lane_spin(lanes, state, k):
    """`spin_in_frame` of a lane's ball whose state stands in the rows from `state` on."""
    tangential_velocity = get(lanes, state + TANGENTIAL_VELOCITY, k)
    spin = get_vector(lanes, state + SPIN, k)
    return spin_in_frame(get(lanes, state + AXIS_DISTANCE, k), tangential_velocity, spin)


@kernel
def relative_spin(row):
    """`spin_in_frame` from one row of the state."""
    spin = (row[RADIAL_SPIN], row[TANGENTIAL_SPIN], row[AXIAL_SPIN])
    return spin_in_frame(row[AXIS_DISTANCE], row[TANGENTIAL_VELOCITY], spin)


@kernel
def changes_contact(bearing, start, end):
    """Whether a ball begins or ends a contact with a raceway between two states, other than by a hair."""
    for before, after in zip(approaches(bearing, start), approaches(bearing, end)):  # noqa: B905
        if before * after < 0.0 and min(abs(before), abs(after)) > TOUCHING:
            return True
    return False


@kernel
def new_dense_step():
    """Room for a `DenseStep`."""
    return DenseStep(
        start=np.zeros(COLUMNS),
        end=np.zeros(COLUMNS),
        third=np.zeros(COLUMNS),
        fourth=np.zeros(COLUMNS),
        between=np.zeros(COLUMNS),
    )


@inlined
def _same_contacts(what, share):
    bearing, dense = what
    interpolate(dense, share, dense.between)
    return not changes_contact(bearing, dense.start, dense.between)


@kernel
def landing(bearing, dense):
    """Share of a dense step, in which a contact with a raceway begins or ends, after which it just has."""
    return halved(_same_contacts, (bearing, dense), 1.0, 1e-6)[1]


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
def _check_balls(bearing, time, state, failure):
    for k in range(bearing.balls):
        status = check_ball(bearing, state, k)
        if status != OK:
            failure[0], failure[1] = time, k
            return status
    return OK


@inlined
def check_all(run, time, state, failure):
    """`check_ball` for every ball of the `run`'s bearing; a failure is noted with its time and ball."""
    return _check_balls(run.bearing, time, state, failure)
