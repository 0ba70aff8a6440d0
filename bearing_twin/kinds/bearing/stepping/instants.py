"""What balls give out inside their steps: the instants that are next, of all balls in lanes side by side.

A step that is accepted leaves rows that nothing reads before the next one fills them again: the terms of interpolants
stand there, and states and orientations at instants.
"""

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    DRIVE_WORK,
    ORIENTATION,
    SPIN,
    TANGENTIAL_VELOCITY,
    VELOCITY,
)
from bearing_twin.kinds.bearing.stepping.steps import lane_spin, spin_in_frame
from bearing_twin.numerics.lanes import (
    COLUMNS,
    LANE_RATES,
    LANES,
    START,
    STEP,
    TIME,
    UNTIL,
    get,
    get_quaternion,
    put,
    put_quaternion,
    put_vector,
    rows,
)
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rosenbrock_inside import inside, take_terms
from bearing_twin.numerics.rotation import turned

# Of an instant: the state in the rows of the state, the orientation, the share of the step; NONE where none is wanted.
TURNED_THERE, SHARE_THERE, _END = rows(LANE_RATES, 4, 1)
NONE = -1.0


@inlined
def _three_inside(share, lanes, column, k):
    """Three columns of a lane's state at a share of its step."""
    return inside(share, lanes, column, k), inside(share, lanes, column + 1, k), inside(share, lanes, column + 2, k)


@inlined
def _spin_inside(share, lanes, k):
    """`lane_spin` at a share of the step."""
    speed, spin = inside(share, lanes, TANGENTIAL_VELOCITY, k), _three_inside(share, lanes, SPIN, k)
    return spin_in_frame(inside(share, lanes, AXIS_DISTANCE, k), speed, spin)


@lean_kernel
def _fill(lanes):
    """States and orientations at the lanes' shares of their steps."""
    for k in range(LANES):
        share = get(lanes, SHARE_THERE, k)
        # Written out: a loop over the columns would be left in the loop over the lanes, which would then gather.
        put_vector(lanes, AXIS_DISTANCE, k, _three_inside(share, lanes, AXIS_DISTANCE, k))
        put_vector(lanes, VELOCITY, k, _three_inside(share, lanes, VELOCITY, k))
        put_vector(lanes, SPIN, k, _three_inside(share, lanes, SPIN, k))
        put_vector(lanes, DRIVE_WORK, k, _three_inside(share, lanes, DRIVE_WORK, k))
        result = turned(
            get_quaternion(lanes, ORIENTATION, k),
            lane_spin(lanes, START, k),
            _spin_inside(0.5 * share, lanes, k),
            lane_spin(lanes, AXIS_DISTANCE, k),
            share * get(lanes, STEP, k),
        )
        put_quaternion(lanes, TURNED_THERE, k, result)


@inlined
def _find(times, after, held, cursor, first, lanes, k):
    """Finds a lane's share of its step to its next instant; returns whether it has one."""
    at, until = cursor[first + k], get(lanes, UNTIL, k)
    if until > 0.0 and at < after[held[first + k]] and times[at] <= until:
        put(lanes, SHARE_THERE, k, (times[at] - get(lanes, TIME, k)) / get(lanes, STEP, k))
        return True
    put(lanes, SHARE_THERE, k, NONE)
    return False


@lean_kernel
def _find_next(times, after, held, cursor, first, lanes):
    """Finds each lane's share of its step to its next instant; returns whether any lane has one.

    The block's first place is number `first`; instants of a ball end before number `after` its last.
    """
    wanted = False
    for k in range(LANES):
        wanted = _find(times, after, held, cursor, first, lanes, k) or wanted
    return wanted


@lean_kernel
def give_out(times, after, weights, held, cursor, first, lanes, states, orientations):
    """Writes the instants up to UNTIL inside the steps of a block's lanes, and moves `cursor` on to the next ones.

    A state stands where its instant does; balls whose instants follow one another have one column there together.
    """
    found, last = _find_next(times, after, held, cursor, first, lanes), states.shape[1] - 1
    if found:
        take_terms(weights, lanes)
    while found:
        _fill(lanes)
        found = False
        for k in range(LANES):
            if get(lanes, SHARE_THERE, k) == NONE:
                continue
            at, ball = cursor[first + k], min(held[first + k], last)
            for column in range(COLUMNS):
                states[at, ball, column] = get(lanes, column, k)
            for part in range(4):
                orientations[at, ball, part] = get(lanes, TURNED_THERE + part, k)
            cursor[first + k] = at + 1
            found = _find(times, after, held, cursor, first, lanes, k) or found
