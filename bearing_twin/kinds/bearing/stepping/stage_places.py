"""Where the balls in lanes, ring and cage are at a step's start and in its stages: what their rates are taken at."""

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces import border_rows as at
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    BORDER_MOTION,
    CAGE,
    CENTRE,
    DRIVE_WORK,
    PLACES,
    POCKET,
    RING_SPEED,
    SPIN,
    VELOCITY,
)
from bearing_twin.kinds.bearing.stepping.border_solve import of_cage
from bearing_twin.numerics.chain_solve import six
from bearing_twin.numerics.lanes import (
    COLUMNS,
    END,
    GAIN,
    INVERSE_STEP,
    LANES,
    START,
    STEP,
    TIME,
    get,
    get_vector,
    put,
    put_six,
    put_vector,
)
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rosenbrock_inside import mixed_stages
from bearing_twin.numerics.rotation import add
from bearing_twin.numerics.steppers import five


@inlined
def border_state(border, first):
    """Places and velocities of a border whose state begins at `first`, whether its cage is even, its land, its ring."""
    if len(border) > 0:
        return six(border.numbers, first), six(border.numbers, first + PLACES), border.even, border.land, border.ring
    return ()


@inlined
def _put_centre(lanes, k, places, speeds):
    """Writes place and velocity of a cage's centre; returns those of the border with no tilt in their place."""
    put(lanes, CENTRE, k, places[3])
    put(lanes, CENTRE + 1, k, places[4])
    put(lanes, CENTRE + 2, k, speeds[3])
    put(lanes, CENTRE + 3, k, speeds[4])
    return _flat(places), _flat(speeds)


@inlined
def _flat(numbers):
    return (numbers[0], numbers[1], numbers[2], 0.0, 0.0, numbers[5])


@inlined
def _put_motion(ring, lanes, row, k, numbers):
    """Writes places or velocities of ring and cage; of a ring that does not tilt nothing of that."""
    if len(ring) == 1:
        put_vector(lanes, row, k, (numbers[0], numbers[1], numbers[2]))
        put(lanes, row + CAGE, k, of_cage(numbers))
    else:
        put_six(lanes, row, k, numbers)


@inlined
def _place(border, drive, alpha, source, lanes, k):
    """Takes a ball's motion from the rows from `source` on, and what the rates need besides, `alpha` steps ahead.

    With ring and cage where the border is `NOW`.
    """
    position, velocity = get_vector(lanes, source + AXIS_DISTANCE, k), get_vector(lanes, source + VELOCITY, k)
    angle, speed = position[1], velocity[1]
    if len(border) > 0:
        places, speeds, even, land, ring = border
        angle = of_cage(places) + get(lanes, POCKET, k) if even else angle
        speed = of_cage(speeds) * position[0] if even else speed
        if len(land) > 0:
            places, speeds = _put_centre(lanes, k, places, speeds)
        _put_motion(ring, lanes, BORDER_MOTION, k, places)
        _put_motion(ring, lanes, BORDER_MOTION + PLACES, k, speeds)
    put_vector(lanes, AXIS_DISTANCE, k, (position[0], angle, position[2]))
    put_vector(lanes, VELOCITY, k, (velocity[0], speed, velocity[2]))
    put_vector(lanes, SPIN, k, get_vector(lanes, source + SPIN, k))
    moment = get(lanes, TIME, k) + alpha * get(lanes, STEP, k)
    put(lanes, RING_SPEED, k, drive.speed + drive.acceleration * moment)


@lean_kernel
def place_start(gamma, border, drive, alpha, lanes):
    """Where the steps start, `alpha` steps later, and what follows from their sizes.

    All in one loop, as in `place_stage`: loops of few statements are unrolled into scalar code.
    """
    now = border_state(border, at.NOW)
    for k in range(LANES):
        step = get(lanes, STEP, k)
        put(lanes, GAIN, k, gamma * step)
        for column in range(COLUMNS):
            put(lanes, INVERSE_STEP + column, k, 1.0 / step)
        _place(now, drive, alpha, START, lanes, k)


@inlined
def _mix_three(weights, lanes, column, k):
    """Writes the state of a stage in three columns."""
    mixed = (
        mixed_stages(weights, lanes, column, k),
        mixed_stages(weights, lanes, column + 1, k),
        mixed_stages(weights, lanes, column + 2, k),
    )
    put_vector(lanes, END + column, k, add(get_vector(lanes, START + column, k), mixed))


@lean_kernel
def place_stage(border, drive, alpha, a, lanes):
    """The state at which a stage takes its rates, `alpha` steps ahead."""
    weights, now = five(a), border_state(border, at.NOW)
    for k in range(LANES):
        # Written out: a loop over the columns would be left in the loop over the lanes, which would then gather.
        _mix_three(weights, lanes, AXIS_DISTANCE, k)
        _mix_three(weights, lanes, VELOCITY, k)
        _mix_three(weights, lanes, SPIN, k)
        _mix_three(weights, lanes, DRIVE_WORK, k)
        _place(now, drive, alpha, END, lanes, k)
