"""The compiled integration loops of the bearing: a chunk of time in, the states at the wanted instants out.

Both loops take `times` [s], increasing, counted from the chunk's start, all within `duration`; they advance `state`
(N, COLUMNS) and `orientation` (N, 4) to the end of the chunk and fill `states` (len(times), N, COLUMNS) and
`orientations` (len(times), N, 4). `counts` gathers the cost; the returned status is one of OK, NOT_FINITE, TOO_DEEP,
STALLED, with the failing time and ball in `failure`.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.motion.steppers import factorise, next_step, rosenbrock_dense, substitute
from bearing_twin.rotation import turned
from bearing_twin.scenes.bearing import (
    AXIS_DISTANCE,
    COLUMNS,
    LANE_ROWS,
    LANES,
    MOTION,
    SPIN,
    VELOCITY,
    add_pair_rates,
    aim_lane,
    ball_rates,
    give_coefficients,
    in_ball_frame,
    inner_contact,
    outer_contact,
    raceway_rates,
)

OK, NOT_FINITE, TOO_DEEP, STALLED = range(4)
STEPS, REJECTIONS, RATES, JACOBIANS = range(4)
LEAST_STEP = 1e-12  # seconds; a shorter step means that the equations cannot be followed
DEEPEST = 0.1  # approach / ball radius beyond which bodies have run through each other


@kernel
def relative_spin(row):
    """Angular velocity of a ball against the frame that turns with it around the axis, from one row of the state."""
    return (row[SPIN], row[SPIN + 1], row[SPIN + 2] - row[VELOCITY + 1] / row[AXIS_DISTANCE])


@kernel
def _turn(orientation, start, middle, end, step, out):
    quaternion = (orientation[0], orientation[1], orientation[2], orientation[3])
    result = turned(quaternion, relative_spin(start), relative_spin(middle), relative_spin(end), step)
    for part in range(4):
        out[part] = result[part]


@kernel
def check_ball(bearing, drive, time, state, k):
    """OK, or why the state of ball k cannot be right."""
    total = 0.0
    for column in range(COLUMNS):
        total += abs(state[k, column])
    if not total < math.inf:
        return NOT_FINITE
    centre = in_ball_frame(state, k, bearing.offset)
    inner = inner_contact(bearing, centre, drive.speed, state, k)
    outer = outer_contact(bearing, state, k)
    deepest = DEEPEST * bearing.ball_radius
    if inner.approach > deepest or outer.approach > deepest:
        return TOO_DEEP
    return OK


@kernel
def _check_all(bearing, drive, time, state, failure):
    for k in range(bearing.balls):
        status = check_ball(bearing, drive, time, state, k)
        if status != OK:
            failure[0], failure[1] = time, k
            return status
    return OK


@kernel
def _to_lanes(state, first, count, lanes):
    for lane in range(count):
        for column in range(COLUMNS):
            lanes[column * LANES + lane] = state[first + lane, column]


@kernel
def _from_lanes(lanes, first, count, state):
    for lane in range(count):
        for column in range(COLUMNS):
            state[first + lane, column] = lanes[column * LANES + lane]


@kernel
def _all_rates(bearing, drive, near, touching, time, values, aims, room, rates, rows, row_rates):
    """Rates of all balls from `values` (blocks, COLUMNS * LANES), their angles measured from the directions `aims`."""
    speed = drive.speed + drive.acceleration * time
    for block in range(len(values)):
        count = min(LANES, bearing.balls - block * LANES)
        room[: MOTION * LANES] = values[block, : MOTION * LANES]
        room[MOTION * LANES :] = aims[block]
        give_coefficients(bearing, count, room)
        raceway_rates(bearing, speed, count, room, rates[block])
    if touching:
        for block in range(len(values)):
            count = min(LANES, bearing.balls - block * LANES)
            _from_lanes(values[block], block * LANES, count, rows)
            _from_lanes(rates[block], block * LANES, count, row_rates)
        for k in range(bearing.balls):
            add_pair_rates(bearing, near, rows, k, row_rates)
        for block in range(len(values)):
            _to_lanes(row_rates, block * LANES, min(LANES, bearing.balls - block * LANES), rates[block])


@kernel
def _aim(values, balls, room, aims):
    """Takes the directions of the present orbit angles as those the next step's are measured from."""
    for block in range(len(values)):
        room[: MOTION * LANES] = values[block, : MOTION * LANES]
        for lane in range(min(LANES, balls - block * LANES)):
            aim_lane(room, lane)
        aims[block] = room[MOTION * LANES :]


@kernel
def _combine(start, factor, slope, out):
    """out = start + factor * slope, flat."""
    for i in range(start.size):
        out.flat[i] = start.flat[i] + factor * slope.flat[i]


@kernel
def _turn_rk4(h, start, end, first_rates, last_rates, orientation):
    """Orientation over one step; the motion at the middle by cubic Hermite interpolation."""
    middle = np.empty(COLUMNS)
    for column in range(MOTION):
        middle[column] = 0.5 * (start[column] + end[column]) + 0.125 * h * (first_rates[column] - last_rates[column])
    _turn(orientation, start, middle, end, h, orientation)


@kernel
def rk4_chunk(
    bearing, drive, near, times, duration, greatest_step, state, orientation, states, orientations, counts, failure
):
    """The classical Runge-Kutta method with equal steps between instants, none longer than `greatest_step` [s].

    Works on lanes: all balls side by side in vector registers. Unstable above 2.8 / (fastest rate): contact frequency
    [rad/s] or friction rate mu N / (m v_regularisation).
    """
    balls = bearing.balls
    blocks = (balls + LANES - 1) // LANES
    shape = (blocks, COLUMNS * LANES)
    y, trial, total = np.ones(shape), np.ones(shape), np.zeros(shape)
    k1, k, last = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    aims, room = np.zeros((blocks, (LANE_ROWS - MOTION) * LANES)), np.ones(LANE_ROWS * LANES)
    rows, row_rates, end, end_rates = state.copy(), np.zeros_like(state), state.copy(), np.zeros_like(state)
    touching = np.any(near)
    for block in range(blocks):
        _to_lanes(state, block * LANES, min(LANES, balls - block * LANES), y[block])
    _aim(y, balls, room, aims)
    time = 0.0
    _all_rates(bearing, drive, near, touching, time, y, aims, room, k1, rows, row_rates)
    _rows_of(k1, balls, row_rates)
    for instant in range(len(times) + 1):
        goal = times[instant] if instant < len(times) else duration
        span = goal - time
        steps = math.ceil(span / greatest_step - 1e-9) if span > 0.0 else 0
        begin = time
        for step in range(steps):
            h = span / steps
            _aim(y, balls, room, aims)
            total[:] = k1
            for stage in range(1, 4):
                half = 0.5 if stage < 3 else 1.0
                _combine(y, half * h, k1 if stage == 1 else k, trial)
                _all_rates(bearing, drive, near, touching, time + half * h, trial, aims, room, k, rows, end_rates)
                _combine(total, 2.0 if stage < 3 else 1.0, k, total)
            _combine(y, h / 6.0, total, trial)
            time = begin + (step + 1) * h
            _all_rates(bearing, drive, near, touching, time, trial, aims, room, last, rows, end_rates)
            _rows_of(trial, balls, end)
            _rows_of(last, balls, end_rates)
            for ball in range(balls):
                _turn_rk4(h, state[ball], end[ball], row_rates[ball], end_rates[ball], orientation[ball])
            state[:] = end
            row_rates[:] = end_rates
            y, trial = trial, y
            k1, last = last, k1
            counts[STEPS] += balls
            counts[RATES] += 4 * balls
            if step % 64 == 63 or step == steps - 1:
                status = _check_all(bearing, drive, time, state, failure)
                if status != OK:
                    return status
        if instant < len(times):
            states[instant] = state
            orientations[instant] = orientation
    return OK


@kernel
def _rows_of(values, balls, rows):
    """Lane form to one row a ball."""
    for block in range(len(values)):
        _from_lanes(values[block], block * LANES, min(LANES, balls - block * LANES), rows)


@kernel
def _raceway_jacobian(bearing, drive, time, state, ball, column_of, row_of, nudges, jacobian, lanes, lane_rates):
    """The block of one ball against the raceways: forward differences, all columns side by side in lanes.

    Lane 0 is the state itself, lane c + 1 has column c nudged; the lanes left over repeat lane 0.
    """
    for lane in range(LANES):
        for column in range(MOTION):
            lanes[column * LANES + lane] = state[ball, column]
    for column in range(MOTION):
        lanes[column * LANES + column + 1] += nudges[column]
    aim_lane(lanes, 0)
    for lane in range(1, LANES):
        for row in range(MOTION, MOTION + 3):
            lanes[row * LANES + lane] = lanes[row * LANES]
    give_coefficients(bearing, LANES, lanes)
    raceway_rates(bearing, drive.speed + drive.acceleration * time, LANES, lanes, lane_rates)
    for column in range(MOTION):
        inverse = 1.0 / (lanes[column * LANES + column + 1] - state[ball, column])
        for row in range(COLUMNS):
            change = lane_rates[row * LANES + column + 1] - lane_rates[row * LANES]
            jacobian[row_of + row, column_of + column] = change * inverse


@kernel
def _jacobian(bearing, drive, near, time, state, group, nudges, jacobian, lanes, lane_rates):
    """d(rates)/d(motion) of a group of balls: rows are all columns of each ball, columns the motion of each.

    A ball's motion acts on itself and on the neighbours it may touch; everything else stays zero.
    """
    size = len(group)
    jacobian[:] = 0.0
    for i in range(size):
        _raceway_jacobian(
            bearing, drive, time, state, group[i], i * MOTION, i * COLUMNS, nudges, jacobian, lanes, lane_rates
        )
    if size == 1:
        return
    before, after = np.zeros_like(state), np.zeros_like(state)
    for j in range(size):
        ball = group[j]
        for column in range(MOTION):
            kept = state[ball, column]
            for side in range(-1, min(2, size - 1)):
                i = (j + side) % size
                before[group[i]] = 0.0
                add_pair_rates(bearing, near, state, group[i], before)
            state[ball, column] = kept + nudges[column]
            nudge = state[ball, column] - kept
            for side in range(-1, min(2, size - 1)):
                i = (j + side) % size
                after[group[i]] = 0.0
                add_pair_rates(bearing, near, state, group[i], after)
                for row in range(COLUMNS):
                    change = after[group[i], row] - before[group[i], row]
                    jacobian[i * COLUMNS + row, j * MOTION + column] += change / nudge
            state[ball, column] = kept


@kernel
def _stage_solution(jacobian, matrix, pivots, inverse, size, motion, right, stage):
    """Solves W k = right for one stage: motion by the factors, then the integrals that only listen."""
    for i in range(size):
        for column in range(MOTION):
            motion[i * MOTION + column] = right[i, column]
    substitute(matrix, pivots, size * MOTION, motion)
    for i in range(size):
        for column in range(MOTION):
            stage[i, column] = motion[i * MOTION + column]
        for column in range(MOTION, COLUMNS):
            value = right[i, column]
            for j in range(size * MOTION):
                value += jacobian[i * COLUMNS + column, j] * motion[j]
            stage[i, column] = value / inverse


@kernel
def _rosenbrock_step(method, bearing, drive, near, time, h, group, room):
    """One step of a group from `room.start`: its end into `room.trial`, stages into `room.k`; False if singular."""
    size = len(group)
    inverse = 1.0 / (h * method.gamma)
    matrix, k, trial, right = room.matrix, room.k, room.trial, room.right
    for i in range(size):
        for row in range(MOTION):
            for j in range(size * MOTION):
                matrix[i * MOTION + row, j] = -room.jacobian[i * COLUMNS + row, j]
            matrix[i * MOTION + row, i * MOTION + row] += inverse
    if not factorise(matrix, room.pivots, size * MOTION):
        return False
    stages = len(method.alpha)
    for stage in range(stages):
        for i in range(size):
            for column in range(COLUMNS):
                trial[group[i], column] = room.start[group[i], column]
                right[i, column] = h * method.d[stage] * room.slope[group[i], column]
            for other in range(stage):
                a, c = method.a[stage, other], method.c[stage, other] / h
                for column in range(COLUMNS):
                    trial[group[i], column] += a * k[other, i, column]
                    right[i, column] += c * k[other, i, column]
        for i in range(size):
            if stage > 0:
                moment = time + method.alpha[stage] * h
                ball_rates(bearing, drive, near, moment, trial, group[i], room.rates, room.lanes, room.lane_rates)
            for column in range(COLUMNS):
                right[i, column] += room.base[group[i], column] if stage == 0 else room.rates[group[i], column]
        _stage_solution(room.jacobian, matrix, room.pivots, inverse, size, room.motion, right, k[stage])
    for i in range(size):
        for column in range(COLUMNS):
            trial[group[i], column] += k[stages - 1, i, column]
    return True


@kernel
def _interpolate(method, fraction, start, end, k, i, out):
    """The step's interpolant at `fraction` of it, for ball i of its group."""
    for column in range(COLUMNS):
        third, fourth = 0.0, 0.0
        for stage in range(method.dense.shape[1]):
            third += method.dense[0, stage] * k[stage, i, column]
            fourth += method.dense[1, stage] * k[stage, i, column]
        out[column] = rosenbrock_dense(fraction, start[column], end[column], third, fourth)


@kernel
def _give_out(method, times, cursor, time, h, group, room, orientation, states, orientations):
    """Writes the instants inside the step just accepted, from its interpolant; returns the next instant to serve."""
    middle = room.middle
    while cursor < len(times) and times[cursor] <= time + h:
        fraction = (times[cursor] - time) / h
        for i in range(len(group)):
            ball = group[i]
            start, end = room.start[ball], room.trial[ball]
            _interpolate(method, fraction, start, end, room.k, i, states[cursor, ball])
            _interpolate(method, 0.5 * fraction, start, end, room.k, i, middle)
            _turn(orientation[ball], start, middle, states[cursor, ball], fraction * h, orientations[cursor, ball])
        cursor += 1
    return cursor


@kernel
def _accept(method, bearing, drive, time, h, group, room, orientation, failure):
    """Moves a group to the end of its step; OK, or why the new state cannot be right."""
    for i in range(len(group)):
        ball = group[i]
        _interpolate(method, 0.5, room.start[ball], room.trial[ball], room.k, i, room.middle)
        _turn(orientation[ball], room.start[ball], room.middle, room.trial[ball], h, orientation[ball])
        room.start[ball] = room.trial[ball]
        status = check_ball(bearing, drive, time, room.start, ball)
        if status != OK:
            failure[0], failure[1] = time + h, ball
            return status
    return OK


@kernel
def _error_norm(group, error, scales):
    """Greatest root-mean-square error of a ball in the group, in units of the scales."""
    greatest = 0.0
    for i in range(len(group)):
        total = 0.0
        for column in range(MOTION):
            ratio = error[i, column] / scales[column]
            total += ratio * ratio
        total = math.sqrt(total / MOTION)
        if not total < math.inf:
            return math.inf
        greatest = max(greatest, total)
    return greatest


@kernel
def _linearise(bearing, drive, near, time, group, nudges, room):
    """Rates, Jacobian and explicit time dependence at the start of a step."""
    start, base, slope = room.start, room.base, room.slope
    for i in range(len(group)):
        ball_rates(bearing, drive, near, time, start, group[i], base, room.lanes, room.lane_rates)
    _jacobian(bearing, drive, near, time, start, group, nudges, room.jacobian, room.lanes, room.lane_rates)
    if drive.acceleration != 0.0:
        later = 1e-7
        for i in range(len(group)):
            ball = group[i]
            ball_rates(bearing, drive, near, time + later, start, ball, slope, room.lanes, room.lane_rates)
            for column in range(COLUMNS):
                slope[ball, column] = (slope[ball, column] - base[ball, column]) / later


@kernel
def _advance_group(
    method,
    bearing,
    drive,
    near,
    group,
    times,
    duration,
    scales,
    nudges,
    room,
    orientation,
    steps,
    states,
    orientations,
    counts,
    failure,
):
    """Integrates one group of balls over the chunk with its own adaptive steps."""
    size = len(group)
    time, cursor, fresh, h = 0.0, 0, True, duration
    for i in range(size):
        h = min(h, steps[group[i]])
    while time < duration:
        last = time + h >= duration * (1.0 - 1e-12)
        step = duration - time if last else h
        if fresh:
            _linearise(bearing, drive, near, time, group, nudges, room)
            counts[JACOBIANS] += size
            counts[RATES] += size * (MOTION + 1)
        solved = _rosenbrock_step(method, bearing, drive, near, time, step, group, room)
        counts[RATES] += size * (len(method.alpha) - 1)
        error = _error_norm(group, room.k[len(method.alpha) - 1], scales) if solved else math.inf
        proposed = next_step(step, error, method.order)
        if error > 1.0:
            counts[REJECTIONS] += size
            fresh, h = False, proposed
            if h < LEAST_STEP:
                failure[0], failure[1] = time, group[0]
                return STALLED
            continue
        cursor = _give_out(method, times, cursor, time, step, group, room, orientation, states, orientations)
        status = _accept(method, bearing, drive, time, step, group, room, orientation, failure)
        if status != OK:
            return status
        counts[STEPS] += size
        time = duration if last else time + step
        fresh = True
        # The last step was cut short by the end of the chunk: what it proposes counts only if it is longer.
        h = max(h, proposed) if last else proposed
    for i in range(size):
        steps[group[i]] = h
    return OK


class Room(NamedTuple):
    """Arrays to work in; state-like ones have one row a ball of the bearing, the others one a ball of the group."""

    start: np.ndarray
    trial: np.ndarray
    base: np.ndarray
    slope: np.ndarray
    rates: np.ndarray
    jacobian: np.ndarray
    matrix: np.ndarray
    pivots: np.ndarray
    k: np.ndarray
    right: np.ndarray
    motion: np.ndarray
    middle: np.ndarray
    lanes: np.ndarray
    lane_rates: np.ndarray


@kernel
def _room(state, size, stages):
    return Room(
        state.copy(),
        state.copy(),
        np.zeros_like(state),
        np.zeros_like(state),
        np.zeros_like(state),
        np.zeros((size * COLUMNS, size * MOTION)),
        np.zeros((size * MOTION, size * MOTION)),
        np.zeros(size * MOTION, np.int64),
        np.zeros((stages, size, COLUMNS)),
        np.zeros((size, COLUMNS)),
        np.zeros(size * MOTION),
        np.zeros(COLUMNS),
        np.ones(LANE_ROWS * LANES),
        np.zeros(COLUMNS * LANES),
    )


@kernel
def rosenbrock_chunk(
    method,
    bearing,
    drive,
    near,
    times,
    duration,
    scales,
    nudges,
    state,
    orientation,
    steps,
    states,
    orientations,
    counts,
    failure,
):
    """An adaptive Rosenbrock method; balls that cannot touch in this chunk are integrated apart, each at its own step.

    The rings' motion is prescribed, so a ball acts on another only where they touch: `near` cuts the ring of balls
    into groups. `scales` (MOTION,) are the errors a step may make in each column, `nudges` the increments of the
    Jacobian's differences, `steps` (N,) [s] the step sizes carried from chunk to chunk.
    """
    balls = bearing.balls
    stages = len(method.alpha)
    first = 0
    for k in range(balls):
        if not near[(k - 1) % balls]:
            first = k
            break
    alone = _room(state, 1, stages)
    done = 0
    while done < balls:
        length = 1
        while done + length < balls and near[(first + done + length - 1) % balls]:
            length += 1
        group = np.empty(length, np.int64)
        for i in range(length):
            group[i] = (first + done + i) % balls
        room = alone if length == 1 else _room(state, length, stages)
        status = _advance_group(
            method,
            bearing,
            drive,
            near,
            group,
            times,
            duration,
            scales,
            nudges,
            room,
            orientation,
            steps,
            states,
            orientations,
            counts,
            failure,
        )
        if status != OK:
            return status
        for i in range(length):
            state[group[i]] = room.start[group[i]]
        done += length
    return OK
