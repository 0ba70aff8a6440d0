"""The compiled integration loops of the bearing: a chunk of time in, the states at the wanted instants out.

Both loops take `times` [s], increasing, counted from the chunk's start, all within `duration`; they advance `state`
(N, COLUMNS) and `orientation` (N, 4) to the end of the chunk and fill `states` (len(times), N, COLUMNS) and
`orientations` (len(times), N, 4). `counts` gathers the cost; the returned status is one of OK, NOT_FINITE, TOO_DEEP,
STALLED, with the failing time and ball in `failure`.
"""

import math

import numpy as np
from numba import njit

from bearing_twin.motion.steppers import factorise, next_step, rosenbrock_dense, substitute
from bearing_twin.rotation import turned
from bearing_twin.scenes.bearing import (
    AXIS_DISTANCE,
    COLUMNS,
    MOTION,
    SPIN,
    VELOCITY,
    ball_rates,
    bearing_rates,
    in_ball_frame,
    inner_contact,
    outer_contact,
    touchable,
)

OK, NOT_FINITE, TOO_DEEP, STALLED = range(4)
STEPS, REJECTIONS, RATES, JACOBIANS = range(4)
LEAST_STEP = 1e-12  # seconds; a shorter step means that the equations cannot be followed
DEEPEST = 0.1  # approach / ball radius beyond which bodies have run through each other


@njit(cache=True, error_model="numpy")
def relative_spin(row):
    """Angular velocity of a ball against the frame that turns with it around the axis, from one row of the state."""
    return (row[SPIN], row[SPIN + 1], row[SPIN + 2] - row[VELOCITY + 1] / row[AXIS_DISTANCE])


@njit(cache=True, error_model="numpy")
def _turn(orientation, start, middle, end, step, out):
    quaternion = (orientation[0], orientation[1], orientation[2], orientation[3])
    result = turned(quaternion, relative_spin(start), relative_spin(middle), relative_spin(end), step)
    for part in range(4):
        out[part] = result[part]


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
def _check_all(bearing, drive, time, state, failure):
    for k in range(bearing.balls):
        status = check_ball(bearing, drive, time, state, k)
        if status != OK:
            failure[0], failure[1] = time, k
            return status
    return OK


@njit(cache=True, error_model="numpy", nogil=True)
def rk4_chunk(
    bearing, drive, near, times, duration, greatest_step, state, orientation, states, orientations, counts, failure
):
    """The classical Runge-Kutta method with equal steps between instants, none longer than `greatest_step` [s].

    Unstable above 2.8 / (fastest rate): contact frequency [rad/s] or friction rate mu N / (m v_regularisation).
    """
    balls = bearing.balls
    k1, k2, k3, k4 = np.zeros_like(state), np.zeros_like(state), np.zeros_like(state), np.zeros_like(state)
    trial, middle = np.zeros_like(state), np.zeros(COLUMNS)
    time = 0.0
    bearing_rates(bearing, drive, near, time, state, k1)
    for instant in range(len(times) + 1):
        goal = times[instant] if instant < len(times) else duration
        span = goal - time
        steps = math.ceil(span / greatest_step - 1e-9) if span > 0.0 else 0
        begin = time
        for step in range(steps):
            h = span / steps
            trial[:] = state + 0.5 * h * k1
            bearing_rates(bearing, drive, near, time + 0.5 * h, trial, k2)
            trial[:] = state + 0.5 * h * k2
            bearing_rates(bearing, drive, near, time + 0.5 * h, trial, k3)
            trial[:] = state + h * k3
            bearing_rates(bearing, drive, near, time + h, trial, k4)
            trial[:] = state + (h / 6.0) * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
            time = begin + (step + 1) * h
            bearing_rates(bearing, drive, near, time, trial, k4)
            for k in range(balls):
                # Cubic Hermite value at the middle of the step.
                for column in range(MOTION):
                    middle[column] = 0.5 * (state[k, column] + trial[k, column]) + 0.125 * h * (
                        k1[k, column] - k4[k, column]
                    )
                _turn(orientation[k], state[k], middle, trial[k], h, orientation[k])
            state[:] = trial
            k1, k4 = k4, k1
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


@njit(cache=True, error_model="numpy")
def _jacobian(bearing, drive, near, time, state, group, base, nudges, jacobian, scratch):
    """Forward differences of the rates of a group of balls; rows are all columns of each ball, columns the motion.

    A ball's motion acts on itself and on the neighbours it may touch; everything else stays zero.
    """
    size = len(group)
    jacobian[:] = 0.0
    for j in range(size):
        ball = group[j]
        for column in range(MOTION):
            kept = state[ball, column]
            state[ball, column] = kept + nudges[column]
            nudge = state[ball, column] - kept
            for i in range(size):
                other = group[i]
                if i != j:
                    ahead = other == (ball + 1) % bearing.balls and touchable(bearing, near, ball, 1)
                    behind = other == (ball - 1) % bearing.balls and touchable(bearing, near, ball, -1)
                    if not (ahead or behind):
                        continue
                ball_rates(bearing, drive, near, time, state, other, scratch)
                for row in range(COLUMNS):
                    jacobian[i * COLUMNS + row, j * MOTION + column] = (scratch[other, row] - base[other, row]) / nudge
            state[ball, column] = kept


@njit(cache=True, error_model="numpy")
def _stage_solution(jacobian, matrix, pivots, inverse, size, right, stage):
    """Solves W k = right for one stage: motion by the factors, then the integrals that only listen."""
    motion = np.empty(size * MOTION)
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


@njit(cache=True, error_model="numpy")
def _rosenbrock_step(
    method, bearing, drive, near, time, h, start, group, base, slope, jacobian, matrix, pivots, trial, rates, k
):
    """One Rosenbrock step of a group from `start`: the end into `trial`, the stages into `k`; False if singular."""
    size = len(group)
    inverse = 1.0 / (h * method.gamma)
    for i in range(size):
        for row in range(MOTION):
            for j in range(size * MOTION):
                matrix[i * MOTION + row, j] = -jacobian[i * COLUMNS + row, j]
            matrix[i * MOTION + row, i * MOTION + row] += inverse
    if not factorise(matrix, pivots, size * MOTION):
        return False
    stages = len(method.alpha)
    right = np.empty((size, COLUMNS))
    for stage in range(stages):
        for i in range(size):
            ball = group[i]
            for column in range(COLUMNS):
                value = start[ball, column]
                for other in range(stage):
                    value += method.a[stage, other] * k[other, i, column]
                trial[ball, column] = value
        if stage > 0:
            for i in range(size):
                ball_rates(bearing, drive, near, time + method.alpha[stage] * h, trial, group[i], rates)
        for i in range(size):
            ball = group[i]
            for column in range(COLUMNS):
                value = base[ball, column] if stage == 0 else rates[ball, column]
                value += h * method.d[stage] * slope[ball, column]
                for other in range(stage):
                    value += method.c[stage, other] / h * k[other, i, column]
                right[i, column] = value
        _stage_solution(jacobian, matrix, pivots, inverse, size, right, k[stage])
    for i in range(size):
        for column in range(COLUMNS):
            trial[group[i], column] += k[stages - 1, i, column]
    return True


@njit(cache=True, error_model="numpy")
def _give_out(method, times, cursor, time, h, group, start, end, k, orientation, states, orientations):
    """Writes the instants inside the step just accepted, from its interpolant; returns the next instant to serve."""
    middle = np.empty(COLUMNS)
    while cursor < len(times) and times[cursor] <= time + h:
        fraction = (times[cursor] - time) / h
        for i in range(len(group)):
            ball = group[i]
            for column in range(COLUMNS):
                third, fourth = 0.0, 0.0
                for stage in range(method.dense.shape[1]):
                    third += method.dense[0, stage] * k[stage, i, column]
                    fourth += method.dense[1, stage] * k[stage, i, column]
                first, last = start[ball, column], end[ball, column]
                states[cursor, ball, column] = rosenbrock_dense(fraction, first, last, third, fourth)
                middle[column] = rosenbrock_dense(0.5 * fraction, first, last, third, fourth)
            _turn(
                orientation[ball],
                start[ball],
                middle,
                states[cursor, ball],
                fraction * h,
                orientations[cursor, ball],
            )
        cursor += 1
    return cursor


@njit(cache=True, error_model="numpy")
def _error_norm(start, trial, group, error, scales):
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


@njit(cache=True, error_model="numpy")
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
    state,
    orientation,
    steps,
    states,
    orientations,
    counts,
    failure,
):
    """Integrates one group of balls over the chunk with its own adaptive steps."""
    size = len(group)
    jacobian = np.zeros((size * COLUMNS, size * MOTION))
    matrix, pivots = np.empty((size * MOTION, size * MOTION)), np.empty(size * MOTION, np.int64)
    base, slope, rates = np.zeros_like(state), np.zeros_like(state), np.zeros_like(state)
    trial, start = state.copy(), state.copy()
    k = np.zeros((len(method.alpha), size, COLUMNS))
    middle = np.empty(COLUMNS)
    time, cursor, fresh = 0.0, 0, True
    h = duration
    for i in range(size):
        h = min(h, steps[group[i]])
    while time < duration:
        last = time + h >= duration * (1.0 - 1e-12)
        step = duration - time if last else h
        if fresh:
            for i in range(size):
                ball_rates(bearing, drive, near, time, start, group[i], base)
            _jacobian(bearing, drive, near, time, start, group, base, nudges, jacobian, rates)
            if drive.acceleration != 0.0:
                later = 1e-7
                for i in range(size):
                    ball_rates(bearing, drive, near, time + later, start, group[i], rates)
                    for column in range(COLUMNS):
                        slope[group[i], column] = (rates[group[i], column] - base[group[i], column]) / later
            counts[JACOBIANS] += size
            counts[RATES] += size * (MOTION + 1)
        solved = _rosenbrock_step(
            method,
            bearing,
            drive,
            near,
            time,
            step,
            start,
            group,
            base,
            slope,
            jacobian,
            matrix,
            pivots,
            trial,
            rates,
            k,
        )
        counts[RATES] += size * (len(method.alpha) - 1)
        error = _error_norm(start, trial, group, k[len(method.alpha) - 1], scales) if solved else math.inf
        proposed = next_step(step, error, method.order)
        if error > 1.0:
            counts[REJECTIONS] += size
            fresh, h = False, proposed
            if h < LEAST_STEP:
                failure[0], failure[1] = time, group[0]
                return STALLED
            continue
        cursor = _give_out(method, times, cursor, time, step, group, start, trial, k, orientation, states, orientations)
        for i in range(size):
            ball = group[i]
            for column in range(COLUMNS):
                third, fourth = 0.0, 0.0
                for stage in range(method.dense.shape[1]):
                    third += method.dense[0, stage] * k[stage, i, column]
                    fourth += method.dense[1, stage] * k[stage, i, column]
                middle[column] = rosenbrock_dense(0.5, start[ball, column], trial[ball, column], third, fourth)
            _turn(orientation[ball], start[ball], middle, trial[ball], step, orientation[ball])
            start[ball] = trial[ball]
            status = check_ball(bearing, drive, time, start, ball)
            if status != OK:
                failure[0], failure[1] = time, ball
                return status
        counts[STEPS] += size
        time = duration if last else time + step
        fresh = True
        if not last or proposed < h:
            h = proposed
    for i in range(size):
        state[group[i]] = start[group[i]]
        steps[group[i]] = h
    return OK


@njit(cache=True, error_model="numpy", nogil=True)
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
    first = 0
    for k in range(balls):
        if not near[(k - 1) % balls]:
            first = k
            break
    done = 0
    while done < balls:
        length = 1
        while done + length < balls and near[(first + done + length - 1) % balls]:
            length += 1
        group = np.empty(length, np.int64)
        for i in range(length):
            group[i] = (first + done + i) % balls
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
            state,
            orientation,
            steps,
            states,
            orientations,
            counts,
            failure,
        )
        if status != OK:
            return status
        done += length
    return OK
