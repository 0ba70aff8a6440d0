"""One Rosenbrock step of many balls side by side, each with its own step size, and its dense output.

Everything is rows of one flat array, a number a lane: see `bearing`. Named tuples of many arrays, and views, would cost
more than the arithmetic.
"""

import math

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.equations import (
    AXIS_DISTANCE,
    COLUMNS,
    LANE_RATES,
    LANES,
    MOTION,
    RING_SPEED,
    SPIN,
    VELOCITY,
    lane_vector,
    set_lane_vector,
)
from bearing_twin.kinds.bearing.jacobian import JACOBIAN, JACOBIAN_END, lane_jacobian
from bearing_twin.kinds.bearing.rates import lane_rates
from bearing_twin.numerics.block_solve import Factors, Linear, factorise_body, solve_body
from bearing_twin.numerics.rotation import dot, turned
from bearing_twin.numerics.steppers import MOST_STAGES, rosenbrock_dense

# Rows of the lanes after the Jacobian.
FACTORS = JACOBIAN_END  # what `factorise_body` leaves
RIGHT = FACTORS + 38  # right-hand side of a stage, and what it solves to
SOLUTION = RIGHT + COLUMNS
START = SOLUTION + COLUMNS  # a step's start, middle and end, and h times the explicit change of rates with time
MIDDLE = START + COLUMNS
END = MIDDLE + COLUMNS
SLOPE = END + COLUMNS
INVERSE = SLOPE + COLUMNS  # 1 / h, in every row
STAGES = INVERSE + COLUMNS  # COLUMNS rows for each stage
ORIENTATION = STAGES + MOST_STAGES * COLUMNS  # at the start, and at the end
TURNED = ORIENTATION + 4
TIME = TURNED + 4  # of each lane: time, step, h gamma, the error estimated, and the step before its cut
STEP, GAIN, ERROR, WANTED = TIME + 1, TIME + 2, TIME + 3, TIME + 4
ALL_ROWS = TIME + 5

SLOPE_STEP = 1e-3  # share of the step over which the rates' explicit change with time is taken


@inlined
def _block(lanes, row, column, k):
    first = JACOBIAN + row * MOTION + column
    return (
        lane_vector(lanes, first, k),
        lane_vector(lanes, first + MOTION, k),
        lane_vector(lanes, first + 2 * MOTION, k),
    )


@inlined
def _linear(lanes, k):
    return Linear(
        lanes[(JACOBIAN + MOTION) * LANES + k],
        lanes[(JACOBIAN + MOTION + 4) * LANES + k],
        _block(lanes, 3, 0, k),
        _block(lanes, 3, 3, k),
        _block(lanes, 3, 6, k),
        _block(lanes, 6, 0, k),
        _block(lanes, 6, 3, k),
        _block(lanes, 6, 6, k),
    )


@inlined
def _keep(block, lanes, row, k):
    set_lane_vector(lanes, row, k, block[0])
    set_lane_vector(lanes, row + 3, k, block[1])
    set_lane_vector(lanes, row + 6, k, block[2])


@inlined
def _kept(lanes, row, k):
    return (lane_vector(lanes, row, k), lane_vector(lanes, row + 3, k), lane_vector(lanes, row + 6, k))


@kernel
def _factorise(lanes):
    """Factors of every lane's Jacobian, each with its own step."""
    for k in range(LANES):
        found = factorise_body(_linear(lanes, k), lanes[GAIN * LANES + k])
        lanes[FACTORS * LANES + k] = found.turning[0]
        lanes[(FACTORS + 1) * LANES + k] = found.turning[1]
        _keep(found.inverse, lanes, FACTORS + 2, k)
        _keep(found.coupling, lanes, FACTORS + 11, k)
        _keep(found.below, lanes, FACTORS + 20, k)
        _keep(found.schur, lanes, FACTORS + 29, k)


@inlined
def _answer(lanes, row, position, velocity, spin, k):
    """One row of the Jacobian times an increment of the motion."""
    first = JACOBIAN + row * MOTION
    return (
        dot(lane_vector(lanes, first, k), position)
        + dot(lane_vector(lanes, first + 3, k), velocity)
        + dot(lane_vector(lanes, first + 6, k), spin)
    )


@kernel
def _solve(lanes):
    """Solves W k = right for one stage of all lanes: the motion, then the integrals that only listen."""
    for k in range(LANES):
        g = lanes[GAIN * LANES + k]
        factors = Factors(
            (lanes[FACTORS * LANES + k], lanes[(FACTORS + 1) * LANES + k]),
            _kept(lanes, FACTORS + 2, k),
            _kept(lanes, FACTORS + 11, k),
            _kept(lanes, FACTORS + 20, k),
            _kept(lanes, FACTORS + 29, k),
        )
        position, velocity, spin = solve_body(
            _linear(lanes, k),
            factors,
            g,
            lane_vector(lanes, RIGHT, k),
            lane_vector(lanes, RIGHT + 3, k),
            lane_vector(lanes, RIGHT + 6, k),
        )
        set_lane_vector(lanes, SOLUTION, k, position)
        set_lane_vector(lanes, SOLUTION + 3, k, velocity)
        set_lane_vector(lanes, SOLUTION + 6, k, spin)
        for i in range(3):
            listened = lanes[(RIGHT + MOTION + i) * LANES + k] + _answer(lanes, MOTION + i, position, velocity, spin, k)
            lanes[(SOLUTION + MOTION + i) * LANES + k] = g * listened


@kernel
def _rates_at(bearing, drive, source, alpha, lanes):
    """Rates of the motion in the rows from `source` on, at times `alpha` steps ahead."""
    for i in range(MOTION * LANES):
        lanes[i] = lanes[source * LANES + i]
    for k in range(LANES):
        moment = lanes[TIME * LANES + k] + alpha * lanes[STEP * LANES + k]
        lanes[RING_SPEED * LANES + k] = drive.speed + drive.acceleration * moment
    lane_rates(bearing, lanes)


@inlined
def _linearise(bearing, drive, gamma, lanes):
    """Rates, Jacobian and explicit time dependence at the start of the steps, and the factors for their sizes."""
    for k in range(LANES):
        lanes[GAIN * LANES + k] = gamma * lanes[STEP * LANES + k]
        lanes[INVERSE * LANES + k] = 1.0 / lanes[STEP * LANES + k]
    for i in range(LANES, COLUMNS * LANES):
        lanes[INVERSE * LANES + i] = lanes[INVERSE * LANES + i - LANES]
    if drive.acceleration != 0.0:
        # Times h, as the method wants it; at constant speed these rows stay zero.
        _rates_at(bearing, drive, START, SLOPE_STEP, lanes)
        for i in range(COLUMNS * LANES):
            lanes[SLOPE * LANES + i] = lanes[LANE_RATES * LANES + i]
        _rates_at(bearing, drive, START, 0.0, lanes)
        for i in range(COLUMNS * LANES):
            lanes[SLOPE * LANES + i] = (lanes[SLOPE * LANES + i] - lanes[LANE_RATES * LANES + i]) / SLOPE_STEP
    else:
        _rates_at(bearing, drive, START, 0.0, lanes)
    lane_jacobian(bearing.spot, bearing, lanes)
    _factorise(lanes)


@inlined
def _mixed(weights, i, lanes):
    """The weighted sum of the earlier stages; `i` counts through the rows of one."""
    return (
        weights[0] * lanes[STAGES * LANES + i]
        + weights[1] * lanes[(STAGES + COLUMNS) * LANES + i]
        + weights[2] * lanes[(STAGES + 2 * COLUMNS) * LANES + i]
        + weights[3] * lanes[(STAGES + 3 * COLUMNS) * LANES + i]
        + weights[4] * lanes[(STAGES + 4 * COLUMNS) * LANES + i]
    )


@kernel
def _stage_state(a, lanes):
    """The state at which a stage takes its rates."""
    weights = (a[0], a[1], a[2], a[3], a[4])
    for i in range(COLUMNS * LANES):
        lanes[END * LANES + i] = lanes[START * LANES + i] + _mixed(weights, i, lanes)


@kernel
def _stage_right(c, d, lanes):
    """The right-hand side of a stage from its rates."""
    weights = (c[0], c[1], c[2], c[3], c[4])
    for i in range(COLUMNS * LANES):
        known = lanes[LANE_RATES * LANES + i] + d * lanes[SLOPE * LANES + i]
        lanes[RIGHT * LANES + i] = known + _mixed(weights, i, lanes) * lanes[INVERSE * LANES + i]


@kernel
def _keep_stage(stage, lanes):
    """Stores the solution as a stage's; one that is not finite as zero, so that it cannot haunt the next attempt."""
    first = (STAGES + stage * COLUMNS) * LANES
    for i in range(COLUMNS * LANES):
        value = lanes[SOLUTION * LANES + i]
        lanes[first + i] = value if abs(value) < math.inf else 0.0


@inlined
def rosenbrock_step(bearing, drive, method, scales, lanes):
    """One step of every lane from START to END, with its error estimate."""
    a, c, alpha, d = method.a, method.c, method.alpha, method.d
    stages = len(alpha)
    _linearise(bearing, drive, method.gamma, lanes)
    for stage in range(stages):
        _stage_state(a[stage], lanes)
        if stage > 0:
            _rates_at(bearing, drive, END, alpha[stage], lanes)
        _stage_right(c[stage], d[stage], lanes)
        _solve(lanes)
        _keep_stage(stage, lanes)
    for i in range(COLUMNS * LANES):
        lanes[END * LANES + i] += lanes[SOLUTION * LANES + i]
    _estimate(scales, lanes)


@kernel
def _estimate(scales, lanes):
    """Root mean square of the last stage, which is the error, in units of the scales."""
    for k in range(LANES):
        lanes[ERROR * LANES + k] = 0.0
    for row in range(MOTION):
        inverse = 1.0 / scales[row]
        for k in range(LANES):
            ratio = lanes[(SOLUTION + row) * LANES + k] * inverse
            lanes[ERROR * LANES + k] += ratio * ratio
    for k in range(LANES):
        lanes[ERROR * LANES + k] = math.sqrt(lanes[ERROR * LANES + k] / MOTION)


@inlined
def _lane_spin(row, lanes, k):
    """Angular velocity of a lane's ball against the frame that turns with it, from the state in rows from `row` on."""
    around = lanes[(row + VELOCITY + 1) * LANES + k] / lanes[(row + AXIS_DISTANCE) * LANES + k]
    spin = lane_vector(lanes, row + SPIN, k)
    return (spin[0], spin[1], spin[2] - around)


@kernel
def turn_lanes(dense, lanes):
    """The middle of every lane's step by its interpolant, and the orientation at its end."""
    third = (dense[0, 0], dense[0, 1], dense[0, 2], dense[0, 3], dense[0, 4])
    fourth = (dense[1, 0], dense[1, 1], dense[1, 2], dense[1, 3], dense[1, 4])
    for i in range(COLUMNS * LANES):
        start, end = lanes[START * LANES + i], lanes[END * LANES + i]
        middle = rosenbrock_dense(0.5, start, end, _mixed(third, i, lanes), _mixed(fourth, i, lanes))
        lanes[MIDDLE * LANES + i] = middle
    for k in range(LANES):
        x, y, z = lane_vector(lanes, ORIENTATION, k)
        result = turned(
            (x, y, z, lanes[(ORIENTATION + 3) * LANES + k]),
            _lane_spin(START, lanes, k),
            _lane_spin(MIDDLE, lanes, k),
            _lane_spin(END, lanes, k),
            lanes[STEP * LANES + k],
        )
        for part in range(4):
            lanes[(TURNED + part) * LANES + k] = result[part]


@kernel
def interpolate_lane(dense, fraction, lanes, k, row):
    """A step's interpolant at `fraction` of it, for one lane."""
    third = (dense[0, 0], dense[0, 1], dense[0, 2], dense[0, 3], dense[0, 4])
    fourth = (dense[1, 0], dense[1, 1], dense[1, 2], dense[1, 3], dense[1, 4])
    for column in range(COLUMNS):
        i = column * LANES + k
        start, end = lanes[START * LANES + i], lanes[END * LANES + i]
        row[column] = rosenbrock_dense(fraction, start, end, _mixed(third, i, lanes), _mixed(fourth, i, lanes))
