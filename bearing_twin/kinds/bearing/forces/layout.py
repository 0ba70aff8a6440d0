"""Balls side by side in lanes: the rows of the flat array they live in, by name, and how to reach them.

Number `row * LANES + k` of the array is what `row` holds for lane k, so that a row's LANES numbers become vector
instructions. All rows stand in one array, because LLVM proves the rows of one array apart, while of several, of named
tuples of arrays and of views it gives up and leaves scalar code.

A lane's state begins at AXIS_DISTANCE; other states begin elsewhere (START, END, LANE_RATES, ...), and their columns
are reached as START + VELOCITY. The accessors take k in range(LANES) for one number of one lane, or let it run on
through the rows that follow, over STATE_SPAN or MOTION_SPAN numbers: a stretch of rows of all lanes at once.
"""

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.numerics.steppers import MOST_STAGES

LANES = 8


def _rows(first, *heights):
    """Where stretches of so many rows begin, then the row after the last of them.

    NumPy's integers: numba compiles a function anew for every plain integer that it is handed as a constant.
    """
    return np.cumsum((first, *heights))


# Columns of a ball's state, and rows of the state in lanes. Velocity and angular velocity: radial, tangential, axial.
AXIS_DISTANCE, ORBIT_ANGLE, HEIGHT, RADIAL_VELOCITY, TANGENTIAL_VELOCITY, AXIAL_VELOCITY = np.arange(6)
RADIAL_SPIN, TANGENTIAL_SPIN, AXIAL_SPIN, DRIVE_WORK, DISSIPATED, GROSS_WORK = np.arange(6, 12)
VELOCITY, SPIN = RADIAL_VELOCITY, RADIAL_SPIN
MOTION = 9  # the columns before this one are the motion; the rest only listen
COLUMNS = 12
MOTION_SPAN, STATE_SPAN = MOTION * LANES, COLUMNS * LANES  # numbers in a stretch of rows

# Bodies that meet all balls, the inner ring and the cage: places (the ring's centre, its tilt about x and y, the cage's
# angle), the velocities of these, and integrals that only listen: work of what acts on the ring, what is lost, and the
# work of the drive through the land that guides a cage.
PLACES = 6
RING_X, RING_Y, RING_Z, TILT_X, TILT_Y, CAGE = np.arange(PLACES)
CAGE_X, CAGE_Y = TILT_X, TILT_Y  # a cage whose centre moves has its places there, and the ring does not tilt
WORK_DONE, LOST, LAND_WORK = 12, 13, 14
SHAFT_ANGLE, SHAFT_SPEED, SHAFT_WORK = 15, 16, 17  # of a shaft that a torque turns: angle, speed, work of the torque
BORDER = 18

# What the rates need besides the motion: speed of the ring, load coefficients, what a law carries (see `carried`),
# motion of ring and cage, the cage's angle to the ball's pocket, place and velocity of its centre; what a ball does to
# ring and cage, and to the ring about its axis; the rates; and what friction over the spots works with.
RING_SPEED, GIVEN_INNER, GIVEN_OUTER, CARRIED_INNER, CARRIED_OUTER, BORDER_MOTION, POCKET = _rows(
    COLUMNS, 1, 1, 1, 4, 4, 2 * PLACES
)
CENTRE, BORDER_PUSH, AXIAL_PUSH, _RATES = _rows(POCKET + 1, 4, PLACES, 1)
LANE_RATES, _SPOT_ROWS, LANE_ROWS = _rows(_RATES, COLUMNS, 16)
CARRIED_COLUMNS = 8
# The motion in a spot's frame, its semi-axes, and three means over it, each in two rows, inner contacts and outer ones:
# 16 numbers side by side become vector instructions there, 8 do not.
SPOTS = 2 * LANES
SLIP_MAJOR, SLIP_MINOR, SPIN_RATE, SEMI_MAJOR, SEMI_MINOR, ALONG, ACROSS, MOMENT = _SPOT_ROWS + 2 * np.arange(8)

# The slopes of the given coefficients; the Jacobian, see `entry`; the orientation at a step's start and at its end.
GIVEN_SLOPE_INNER, GIVEN_SLOPE_OUTER, JACOBIAN, ORIENTATION, TURNED, _SHARED = _rows(
    LANE_ROWS, 1, 1, COLUMNS * MOTION, 4, 4
)
JACOBIAN_END = ORIENTATION

# The implicit-explicit method: angular velocity in the ball's frame where the balls were turned last, and the sum of it
# after each step since.
FIRST_SPIN, SPIN_SUM, IMEX_ROWS = _rows(_SHARED, 3, 3)

# Rosenbrock methods. What `factorise_body` leaves; a stage's right-hand side and what it solves to; a step's start
# and end; h times the explicit change of the rates with time; 1 / h in every row; the stages; and of each lane:
# time, step, h gamma, the error estimated, the share of the step to its first landing, the step before its cut, what
# the error does to acceleration and angular acceleration, squared, and these two in the last stage of the step before.
FACTOR_RADIUS, FACTOR_VELOCITY, FACTOR_INVERSE, FACTOR_COUPLING, FACTOR_BELOW, FACTOR_SCHUR, RIGHT = _rows(
    _SHARED, 1, 1, 9, 9, 9, 9
)
SOLUTION, START, END, SLOPE, INVERSE_STEP, _STAGES, TIME = _rows(
    RIGHT + COLUMNS, *(COLUMNS,) * 5, MOST_STAGES * COLUMNS
)
FIRST_STAGE, SECOND_STAGE, THIRD_STAGE, FOURTH_STAGE, FIFTH_STAGE, _ = _STAGES + COLUMNS * np.arange(MOST_STAGES)
STEP, GAIN, ERROR, SHARE, WANTED, FORCE_ERROR, TORQUE_ERROR, LAST_RATES, ROSENBROCK_ROWS = _rows(
    TIME + 1, 1, 1, 1, 1, 1, 1, 1, 6
)
SYSTEM = FACTOR_INVERSE  # coupled balls: what is left of 1/g - J without positions, column after column

# Balls that may touch, in an array of their own: nine numbers of a ball and of the next ahead, whether they may touch,
# what to add to the angle between them; what they do to the rates of either (velocity, spin, the integrals) and how
# that answers to either's motion; and two tiles of the linear system without positions, column after column.
OWN, AHEAD, MAY_TOUCH, ROUND, OWN_PUSH, AHEAD_PUSH, _ANSWERS = _rows(0, MOTION, MOTION, 1, 1, 8, 6)
OWN_BY_OWN, OWN_BY_AHEAD, AHEAD_BY_OWN, AHEAD_BY_AHEAD, UPPER, LOWER, PAIR_ROWS = _rows(
    _ANSWERS, *(8 * MOTION,) * 2, *(6 * MOTION,) * 2, 36, 36
)

# How ball and border (ring and cage) answer to each other, after the rows of Rosenbrock methods: rates of a ball from
# VELOCITY on by the border's places and velocities, the border's accelerations by a ball's motion and by its own, all
# row after row; two tiles of the linear system without positions, column after column; what goes into sums; and how
# fast a ball comes to go forward in its pocket.
ANSWERING = COLUMNS - VELOCITY
BALL_BY_BORDER, BORDER_BY_BALL, BORDER_BY_BORDER, BALL_TILE, BORDER_TILE, SHARES, CLOSING, BORDERED_ROWS = _rows(
    ROSENBROCK_ROWS, ANSWERING * 2 * PLACES, PLACES * MOTION, 2 * PLACES * PLACES, 36, 36, PLACES, 1
)
# A shaft that a torque turns: rates of a ball from VELOCITY on by its speed; its acceleration by a ball's motion, by
# places and velocities of the border and by its speed; and what a ball's state comes to for its speed in a stage.
BALL_BY_SHAFT, SHAFT_BY_BALL, SHAFT_BY_BORDER, SHAFT_OWN, SHAFT_ANSWER, SHAFT_ROWS = _rows(
    BORDERED_ROWS, ANSWERING, MOTION, 2 * PLACES, 1, COLUMNS
)


@inlined
def get(lanes, row, k):
    """The number in `row` of lane k."""
    return lanes[row * LANES + k]


@inlined
def put(lanes, row, k, value):
    """Writes the number in `row` of lane k."""
    lanes[row * LANES + k] = value


@inlined
def put_from(lanes, row, i, value):
    """`put` into a row known only when the kernel runs: an unsigned index is not looked at for its sign."""
    lanes[np.uint64(row * LANES + i)] = value


@inlined
def increase(lanes, row, k, value):
    """Adds to the number in `row` of lane k."""
    lanes[row * LANES + k] += value


@inlined
def sum_of(lanes, row):
    """The sum of the LANES numbers in a row, two and two."""
    at = row * LANES
    low = (lanes[at] + lanes[at + 1]) + (lanes[at + 2] + lanes[at + 3])
    return low + ((lanes[at + 4] + lanes[at + 5]) + (lanes[at + 6] + lanes[at + 7]))


@inlined
def multiply_rows(lanes, first, after, factor):
    """Multiplies the numbers in the rows from `first` on, those from `after` on not."""
    for i in range(first * LANES, after * LANES):
        lanes[np.uint64(i)] *= factor


@inlined
def clear_rows(lanes, first, after):
    """Puts zeros into the rows from `first` on, those from `after` on not."""
    for i in range(first * LANES, after * LANES):
        lanes[np.uint64(i)] = 0.0


@inlined
def get_vector(lanes, row, k):
    """Three rows of lane k from `row` on as a vector."""
    return (lanes[row * LANES + k], lanes[(row + 1) * LANES + k], lanes[(row + 2) * LANES + k])


@inlined
def put_vector(lanes, row, k, vector):
    """Writes a vector into three rows of lane k from `row` on."""
    lanes[row * LANES + k] = vector[0]
    lanes[(row + 1) * LANES + k] = vector[1]
    lanes[(row + 2) * LANES + k] = vector[2]


@inlined
def put_six(lanes, row, k, numbers):
    """Writes six numbers into six rows of lane k from `row` on."""
    put_vector(lanes, row, k, (numbers[0], numbers[1], numbers[2]))
    put_vector(lanes, row + 3, k, (numbers[3], numbers[4], numbers[5]))


@inlined
def increase_vector(lanes, row, k, vector):
    """Adds a vector to three rows of lane k from `row` on."""
    lanes[row * LANES + k] += vector[0]
    lanes[(row + 1) * LANES + k] += vector[1]
    lanes[(row + 2) * LANES + k] += vector[2]


@inlined
def get_quaternion(lanes, row, k):
    """Four rows of lane k from `row` on: x, y, z, w."""
    x, y, z = get_vector(lanes, row, k)
    return (x, y, z, lanes[(row + 3) * LANES + k])


@inlined
def put_quaternion(lanes, row, k, quaternion):
    """Writes x, y, z, w into four rows of lane k from `row` on."""
    put_vector(lanes, row, k, quaternion)
    lanes[(row + 3) * LANES + k] = quaternion[3]


@inlined
def get_block(lanes, row, k):
    """Nine rows of lane k from `row` on as a 3 x 3 matrix."""
    return (get_vector(lanes, row, k), get_vector(lanes, row + 3, k), get_vector(lanes, row + 6, k))


@inlined
def put_block(lanes, row, k, block):
    """Writes a 3 x 3 matrix into nine rows of lane k from `row` on."""
    put_vector(lanes, row, k, block[0])
    put_vector(lanes, row + 3, k, block[1])
    put_vector(lanes, row + 6, k, block[2])


@inlined
def entry(rate, column):
    """The row that holds the Jacobian's entry d(rate)/d(column), both columns of the state."""
    return JACOBIAN + rate * MOTION + column


@inlined
def get_part(lanes, first, k):
    """The 3 x 3 part of a matrix of MOTION columns of lane k whose first entry stands in row `first`."""
    return (
        get_vector(lanes, first, k),
        get_vector(lanes, first + MOTION, k),
        get_vector(lanes, first + 2 * MOTION, k),
    )


@inlined
def put_part(lanes, first, k, block):
    """Writes the 3 x 3 part of a matrix of MOTION columns of lane k whose first entry stands in row `first`."""
    put_vector(lanes, first, k, block[0])
    put_vector(lanes, first + MOTION, k, block[1])
    put_vector(lanes, first + 2 * MOTION, k, block[2])


@inlined
def get_jacobian_block(lanes, rate, column, k):
    """The 3 x 3 block of lane k's Jacobian whose first entry is (rate, column)."""
    return get_part(lanes, entry(rate, column), k)


@inlined
def put_jacobian_block(lanes, rate, column, k, block):
    """Writes the 3 x 3 block of lane k's Jacobian whose first entry is (rate, column)."""
    put_part(lanes, entry(rate, column), k, block)


@inlined
def put_tile_part(lanes, first, row, column, k, block):
    """Writes the 3 x 3 part that begins at (row, column) of a 6 x 6 tile of lane k, column after column."""
    for c in range(3):
        at = first + (column + c) * 6 + row
        put_vector(lanes, at, k, (block[0][c], block[1][c], block[2][c]))


@kernel
def into_lane(numbers, lanes, row, k):
    """Copies a ball's numbers (n,) to n rows of lane k from `row` on."""
    for i in range(len(numbers)):
        lanes[(row + i) * LANES + k] = numbers[i]


@kernel
def from_lane(lanes, row, k, numbers):
    """Copies n rows of lane k from `row` on to a ball's numbers (n,)."""
    for i in range(len(numbers)):
        numbers[i] = lanes[(row + i) * LANES + k]


@kernel
def into_blocks(balls, blocks, row):
    """Copies a table (N, n), one line a ball, to rows from `row` on of blocks of LANES balls each.

    Lanes left over repeat the last ball.
    """
    for i in range(len(blocks) * LANES):
        into_lane(balls[min(i, len(balls) - 1)], blocks[i // LANES], row, i % LANES)


@kernel
def from_blocks(blocks, row, balls):
    """The inverse of `into_blocks`."""
    for ball in range(len(balls)):
        from_lane(blocks[ball // LANES], row, ball % LANES, balls[ball])


@kernel
def new_lanes(rows):
    """An array of so many rows of zeros."""
    return np.zeros(rows * LANES)


@kernel
def new_blocks(balls, rows):
    """Arrays of so many rows of zeros, as many as so many balls need; (blocks, rows * LANES)."""
    return np.zeros(((balls + LANES - 1) // LANES, rows * LANES))
