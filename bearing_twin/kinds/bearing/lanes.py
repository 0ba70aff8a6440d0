"""One Rosenbrock step of many balls side by side, alone or coupled, and its dense output.

Balls stand in blocks of lanes. Balls alone have a step size each and are solved one by one; coupled ones, which
`linear_system` says more about, have one step size for all and are solved together. All else is the same.
"""

import math

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing import border_rows as at
from bearing_twin.kinds.bearing.border import border_rates, follow_cage
from bearing_twin.kinds.bearing.border_solve import six
from bearing_twin.kinds.bearing.border_step import (
    border_finish,
    border_keep,
    border_right,
    border_slope,
    border_stage_state,
    copy_state,
)
from bearing_twin.kinds.bearing.jacobian import lane_jacobian
from bearing_twin.kinds.bearing.layout import (
    AXIS_DISTANCE,
    BORDER_MOTION,
    CAGE,
    COLUMNS,
    END,
    ERROR,
    FIFTH_STAGE,
    FIRST_STAGE,
    FOURTH_STAGE,
    GAIN,
    INVERSE_STEP,
    LANE_RATES,
    LANES,
    MIDDLE,
    MOTION,
    ORIENTATION,
    PLACES,
    POCKET,
    RIGHT,
    RING_SPEED,
    SECOND_STAGE,
    SLOPE,
    SOLUTION,
    SPIN,
    START,
    STATE_SPAN,
    STEP,
    TANGENTIAL_VELOCITY,
    THIRD_STAGE,
    TIME,
    TURNED,
    VELOCITY,
    from_lane,
    get,
    get_quaternion,
    get_vector,
    increase,
    put,
    put_from,
    put_quaternion,
    put_six,
    put_vector,
)
from bearing_twin.kinds.bearing.linear_system import (
    couple_jacobians,
    factorise_alone,
    factorise_together,
    solve_alone,
    solve_together,
)
from bearing_twin.kinds.bearing.pairs import add_pairs
from bearing_twin.kinds.bearing.rates import lane_rates
from bearing_twin.kinds.bearing.steps import spin_in_frame
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rotation import turned
from bearing_twin.numerics.steppers import five, rosenbrock_dense

# Share of the step over which the rates' explicit change with time is taken: at 1e-3 the order fell from 4 to 2.
SLOPE_STEP = 1e-6


@inlined
def _mixed(weights, lanes, i):
    """The weighted sum of the earlier stages; `i` counts through the rows of one."""
    return (
        weights[0] * get(lanes, FIRST_STAGE, i)
        + weights[1] * get(lanes, SECOND_STAGE, i)
        + weights[2] * get(lanes, THIRD_STAGE, i)
        + weights[3] * get(lanes, FOURTH_STAGE, i)
        + weights[4] * get(lanes, FIFTH_STAGE, i)
    )


@inlined
def _place(border, drive, alpha, source, lanes):
    """Takes the motion from the rows from `source` on, and what the rates need besides, `alpha` steps ahead.

    With ring and cage where the border is `NOW`. One loop for all of it: one of few statements would be unrolled into
    scalar code.
    """
    places, speeds, even = _border_now(border)
    for k in range(LANES):
        position, velocity = get_vector(lanes, source + AXIS_DISTANCE, k), get_vector(lanes, source + VELOCITY, k)
        angle, speed = position[1], velocity[1]
        if len(border) > 0:
            angle = places[CAGE] + get(lanes, POCKET, k) if even else angle
            speed = speeds[CAGE] * position[0] if even else speed
            put_six(lanes, BORDER_MOTION, k, places)
            put_six(lanes, BORDER_MOTION + PLACES, k, speeds)
        put_vector(lanes, AXIS_DISTANCE, k, (position[0], angle, position[2]))
        put_vector(lanes, VELOCITY, k, (velocity[0], speed, velocity[2]))
        put_vector(lanes, SPIN, k, get_vector(lanes, source + SPIN, k))
        moment = get(lanes, TIME, k) + alpha * get(lanes, STEP, k)
        put(lanes, RING_SPEED, k, drive.speed + drive.acceleration * moment)


@lean_kernel
def _place_start(border, drive, alpha, lanes):
    """Where the steps start, `alpha` steps later."""
    _place(border, drive, alpha, START, lanes)


@lean_kernel
def _place_stage(border, drive, alpha, a, lanes):
    """The state at which a stage takes its rates, `alpha` steps ahead."""
    weights = five(a)
    for i in range(STATE_SPAN):
        put(lanes, END, i, get(lanes, START, i) + _mixed(weights, lanes, i))
    _place(border, drive, alpha, END, lanes)


@lean_kernel
def _rates(coupling, bearing, drive, alpha, blocks):
    """Rates of the motion, `alpha` steps ahead."""
    for block in range(len(blocks)):
        lane_rates(bearing, blocks[block])
    if len(coupling) > 0:
        _add_coupled(coupling, bearing, drive, alpha, blocks)


@lean_kernel
def _add_coupled(coupling, bearing, drive, alpha, blocks):
    """Adds what balls do to each other, and finds the rates of the border."""
    if coupling.pairs.touching:
        add_pairs(bearing, coupling.pairs, blocks, blocks, LANE_RATES)
    if coupling.border.active:
        border_rates(bearing, drive, coupling.border, _moment(alpha, blocks), blocks)


@inlined
def border_of(coupling):
    """The border, or nothing where balls are alone."""
    if len(coupling) > 0:
        return coupling.border
    return ()


@inlined
def _border_now(border):
    """Places and velocities of a border `NOW`, and whether its cage is even."""
    if len(border) > 0:
        return six(border.numbers, at.NOW), six(border.numbers, at.NOW + PLACES), border.even
    return (), (), False


@inlined
def _moment(alpha, blocks):
    """The time of coupled balls, `alpha` steps ahead."""
    return get(blocks[0], TIME, 0) + alpha * get(blocks[0], STEP, 0)


@lean_kernel
def _loads_vary(coupling):
    """Whether what acts on the ring changes with time."""
    if len(coupling) > 0:
        return coupling.border.varying
    return False


@lean_kernel
def _prepare(gamma, lanes):
    """What follows from the step sizes."""
    for k in range(LANES):
        put(lanes, GAIN, k, gamma * get(lanes, STEP, k))
        put(lanes, INVERSE_STEP, k, 1.0 / get(lanes, STEP, k))
    for i in range(LANES, STATE_SPAN):
        put(lanes, INVERSE_STEP, i, get(lanes, INVERSE_STEP, i - LANES))


@lean_kernel
def _keep_rates(lanes):
    for i in range(STATE_SPAN):
        put(lanes, SLOPE, i, get(lanes, LANE_RATES, i))


@lean_kernel
def _take_slope(lanes):
    for i in range(STATE_SPAN):
        put(lanes, SLOPE, i, (get(lanes, SLOPE, i) - get(lanes, LANE_RATES, i)) / SLOPE_STEP)


@lean_kernel
def _stage_right(c, d, lanes):
    """The right-hand side of a stage from its rates."""
    weights = five(c)
    for i in range(STATE_SPAN):
        known = get(lanes, LANE_RATES, i) + d * get(lanes, SLOPE, i)
        put(lanes, RIGHT, i, known + _mixed(weights, lanes, i) * get(lanes, INVERSE_STEP, i))


@lean_kernel
def _keep_stage(stage, lanes):
    """Stores the solution as a stage's; one that is not finite as zero, so that it cannot haunt the next attempt."""
    row = FIRST_STAGE + stage * COLUMNS
    for i in range(STATE_SPAN):
        value = get(lanes, SOLUTION, i)
        put_from(lanes, row, i, value if abs(value) < math.inf else 0.0)


@lean_kernel
def rosenbrock_step(coupling, bearing, drive, method, scales, blocks):
    """One step of every lane from START to END with TURNED, and its error; `coupling` is empty for balls alone."""
    stages, varies, border = len(method.alpha), drive.acceleration != 0.0 or _loads_vary(coupling), border_of(coupling)
    # Rates, Jacobian and explicit time dependence at the start of the steps, and the factors for their sizes.
    for block in range(len(blocks)):
        _prepare(method.gamma, blocks[block])
    if len(coupling) > 0:
        copy_state(coupling.border.numbers, at.BEGIN, at.NOW)
    if varies:
        # Times h, as the method wants it; at constant speed and load these rows stay zero.
        for block in range(len(blocks)):
            _place_start(border, drive, SLOPE_STEP, blocks[block])
        _rates(coupling, bearing, drive, SLOPE_STEP, blocks)
        for block in range(len(blocks)):
            _keep_rates(blocks[block])
        if len(coupling) > 0:
            copy_state(coupling.border.numbers, at.RATES, at.SLOPE)
    for block in range(len(blocks)):
        _place_start(border, drive, 0.0, blocks[block])
    _rates(coupling, bearing, drive, 0.0, blocks)
    for block in range(len(blocks)):
        if varies:
            _take_slope(blocks[block])
        lane_jacobian(bearing.spot, bearing, blocks[block])
    if len(coupling) > 0:
        if varies:
            border_slope(SLOPE_STEP, coupling.border.numbers)
        couple_jacobians(bearing.ring, bearing.pockets, bearing, drive, _moment(0.0, blocks), coupling, blocks)
        factorise_together(coupling, blocks)
    else:
        for block in range(len(blocks)):
            factorise_alone(blocks[block])
    for stage in range(stages):
        if len(coupling) > 0:
            border_stage_state(method.a[stage], coupling.border.numbers)
        if stage > 0:
            for block in range(len(blocks)):
                _place_stage(border, drive, method.alpha[stage], method.a[stage], blocks[block])
            _rates(coupling, bearing, drive, method.alpha[stage], blocks)
        for block in range(len(blocks)):
            _stage_right(method.c[stage], method.d[stage], blocks[block])
        if len(coupling) > 0:
            border_right(method.c[stage], method.d[stage], get(blocks[0], STEP, 0), coupling.border.numbers)
            solve_together(drive, _moment(0.0, blocks), coupling, blocks)
            border_keep(stage, coupling.border.numbers)
        else:
            for block in range(len(blocks)):
                solve_alone(blocks[block])
        for block in range(len(blocks)):
            _keep_stage(stage, blocks[block])
    for block in range(len(blocks)):
        _finish(scales, blocks[block])
    if len(coupling) > 0:
        border_finish(method.dense, coupling.border.numbers)
        follow_cage(coupling.border, at.FINISH, blocks, END)
        put(blocks[0], ERROR, 0, max(get(blocks[0], ERROR, 0), coupling.border.numbers[at.ERROR]))
    for block in range(len(blocks)):
        _turn_lanes(method.dense, blocks[block])


@inlined
def _inverse(scales, first):
    return (1.0 / scales[first], 1.0 / scales[first + 1], 1.0 / scales[first + 2])


@inlined
def _squares(errors, inverse):
    """The sum of the squares of three errors in units of the scales."""
    one, two, three = errors[0] * inverse[0], errors[1] * inverse[1], errors[2] * inverse[2]
    return one * one + two * two + three * three


@lean_kernel
def _finish(scales, lanes):
    """The end of the steps, and their errors."""
    for i in range(STATE_SPAN):
        increase(lanes, END, i, get(lanes, SOLUTION, i))
    # Root mean square of the last stage, which is the error, in units of the scales.
    first, second, third = _inverse(scales, 0), _inverse(scales, 3), _inverse(scales, 6)
    for k in range(LANES):
        total = _squares(get_vector(lanes, SOLUTION, k), first) + _squares(get_vector(lanes, SOLUTION + 3, k), second)
        total += _squares(get_vector(lanes, SOLUTION + 6, k), third)
        put(lanes, ERROR, k, math.sqrt(total / MOTION))


@inlined
def _lane_spin(lanes, state, k):
    """`spin_in_frame` of a lane's ball whose state stands in the rows from `state` on."""
    tangential_velocity = get(lanes, state + TANGENTIAL_VELOCITY, k)
    spin = get_vector(lanes, state + SPIN, k)
    return spin_in_frame(get(lanes, state + AXIS_DISTANCE, k), tangential_velocity, spin)


@lean_kernel
def _turn_lanes(dense, lanes):
    """The middle of every lane's step by its interpolant, and the orientation at its end."""
    third, fourth = five(dense[0]), five(dense[1])
    for i in range(STATE_SPAN):
        start, end = get(lanes, START, i), get(lanes, END, i)
        middle = rosenbrock_dense(0.5, start, end, _mixed(third, lanes, i), _mixed(fourth, lanes, i))
        put(lanes, MIDDLE, i, middle)
    for k in range(LANES):
        result = turned(
            get_quaternion(lanes, ORIENTATION, k),
            _lane_spin(lanes, START, k),
            _lane_spin(lanes, MIDDLE, k),
            _lane_spin(lanes, END, k),
            get(lanes, STEP, k),
        )
        put_quaternion(lanes, TURNED, k, result)


@lean_kernel
def dense_ends(lanes, k, dense):
    """Fills the start, the end and the first orientation of one lane's dense step."""
    from_lane(lanes, START, k, dense.start)
    from_lane(lanes, END, k, dense.end)
    from_lane(lanes, ORIENTATION, k, dense.orientation)


@lean_kernel
def dense_terms(weights, lanes, k, dense):
    """Fills the two terms of one lane's interpolant by the method's dense weights."""
    third, fourth = five(weights[0]), five(weights[1])
    for column in range(COLUMNS):
        i = column * LANES + k
        dense.third[column] = _mixed(third, lanes, i)
        dense.fourth[column] = _mixed(fourth, lanes, i)
