"""Bodies side by side in lanes: the flat array they live in, how to reach its rows, and the rows that methods know.

Number `row * LANES + k` of the array is what `row` holds for lane k, so that a row's LANES numbers become vector
instructions. All rows stand in one array, because LLVM proves the rows of one array apart, while of several, of named
tuples of arrays and of views it gives up and leaves scalar code.

The accessors take k in range(LANES) for one number of one lane, or let it run on through the rows that follow, over
STATE_SPAN numbers: a stretch of rows of all lanes at once. A body's state is COLUMNS numbers. The state at which rates
are taken stands at 0, the rates at LANE_RATES, what methods need besides from METHOD_ROWS up to AFTER_METHOD; all other
rows are the scene's. All are constants: rows known only when a kernel runs cost it its vectors.
"""

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.numerics.steppers import MOST_STAGES
from bearing_twin.vectors import BITS

# As many as fill a vector instruction. Eight where there are 256 bits take 1.3 to 1.6 times as long where balls differ,
# four where there are 512 take 1.2 where they do not (`python bench/lanes.py`).
LANES = BITS // 64
CACHE_LINE = 64  # bytes that a processor moves at once
SPARE = CACHE_LINE // 8 - 1  # numbers by which an array is longer that is to begin with one


def rows(first, *heights):
    """Where stretches of so many rows begin, then the row after the last of them.

    NumPy's integers: numba compiles a function anew for every plain integer that it is handed as a constant.
    """
    return np.cumsum((first, *heights))


COLUMNS = 12
STATE_SPAN = COLUMNS * LANES  # numbers in a stretch of rows
# Where these stand counts: with the rates at row 12 steps of a bearing took 2 to 3 % longer. 64 rows are 4096 bytes.
LANE_RATES, METHOD_ROWS = np.array([47, 247])

# Rosenbrock methods. A stage's right-hand side and what it solves to; a step's start and end; h times the explicit
# change of the rates with time; 1 / h in every row; the stages; and of each lane: time, step, h gamma, the error
# estimated, the share of the step to its first event, the step before its cut, the instant up to which it gives out,
# the one at which it ends.
RIGHT, SOLUTION, START, END, SLOPE, INVERSE_STEP, _STAGES, TIME = rows(
    METHOD_ROWS, *(COLUMNS,) * 6, MOST_STAGES * COLUMNS
)
FIRST_STAGE, SECOND_STAGE, THIRD_STAGE, FOURTH_STAGE, FIFTH_STAGE, _ = _STAGES + COLUMNS * np.arange(MOST_STAGES)
STEP, GAIN, ERROR, SHARE, WANTED, UNTIL, DURATION, AFTER_METHOD = rows(TIME + 1, 1, 1, 1, 1, 1, 1, 1)
THIRD, FOURTH = RIGHT, SOLUTION  # two terms of what lies inside a step, once it is made and nothing is to be solved


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
def with_sum(total, factor, lanes, row):
    """The total plus a factor times the LANES numbers in a row, four at a time: the same bits whatever LANES."""
    for at in range(row * LANES, (row + 1) * LANES, 4):
        total += factor * ((lanes[at] + lanes[at + 1]) + (lanes[at + 2] + lanes[at + 3]))
    return total


@inlined
def add_sum(numbers, place, factor, lanes, row):
    """Adds a factor times the numbers in a row to the number at `place`, as `with_sum`."""
    numbers[place] = with_sum(numbers[place], factor, lanes, row)


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
def copy_rows(lanes, first, after, other):
    """Copies the rows from `first` on, those from `after` on not, to the same rows of another array."""
    for i in range(first * LANES, after * LANES):
        other[np.uint64(i)] = lanes[np.uint64(i)]


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
def begins_again(coupling, blocks):
    """Whether a step begins where one of coupled bodies began that was not accepted; never where bodies are alone."""
    return len(coupling) > 0 and get(blocks[0], UNTIL, 0) < 0.0


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


@inlined
def from_cache_line(room):
    """The part of `room` (n + SPARE,) that begins with a line of the cache; (n,).

    A row of eight numbers fills one. Numba's arrays begin at any multiple of 32 bytes, and steps of a ring and balls
    took 1.15 times as long where each row stood in two.
    """
    begin = (-room.ctypes.data % CACHE_LINE) // 8
    return room[begin : begin + len(room) - SPARE]


@kernel
def new_lanes(rows):
    """An array of so many rows of zeros."""
    return from_cache_line(np.zeros(rows * LANES + SPARE))


@kernel
def new_blocks(balls, rows):
    """Arrays of so many rows of zeros, as many as so many balls need; (blocks, rows * LANES)."""
    blocks = (balls + LANES - 1) // LANES
    return new_lanes(blocks * rows).reshape((blocks, rows * LANES))
