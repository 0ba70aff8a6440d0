"""The bearing by explicit Runge-Kutta methods, all balls side by side in vector lanes, one step size for all."""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.equations import (
    COLUMNS,
    LANE_RATES,
    LANE_ROWS,
    LANES,
    MOTION,
    RING_SPEED,
    add_pair_rates,
    from_lane,
    into_lane,
)
from bearing_twin.kinds.bearing.rates import lane_rates
from bearing_twin.kinds.bearing.steps import (
    LEAST_STEP,
    OK,
    RATES,
    REJECTIONS,
    STALLED,
    STEPS,
    check_all,
    turn,
)
from bearing_twin.numerics.steppers import next_step

# Orientations need fewer steps than the contacts do; a state that cannot be right is looked for now and then and at
# every instant given out.
TURN_EVERY, CHECK_EVERY = 8, 64


class Room(NamedTuple):
    """Arrays to work in: `y`, `trial` and each slope of `k` are (blocks, COLUMNS * LANES); `rows` one row a ball."""

    y: np.ndarray
    trial: np.ndarray
    k: np.ndarray
    turned_from: np.ndarray
    turned_rates: np.ndarray
    lanes: np.ndarray
    rows: np.ndarray
    row_rates: np.ndarray


@kernel
def lane_room(state, slopes):
    """Room for a method with so many slopes, holding `state`."""
    blocks = (len(state) + LANES - 1) // LANES
    shape = (blocks, COLUMNS * LANES)
    room = Room(
        np.zeros(shape),
        np.zeros(shape),
        np.zeros((slopes, *shape)),
        np.zeros(shape),
        np.zeros(shape),
        np.zeros(LANE_ROWS * LANES),
        state.copy(),
        np.zeros_like(state),
    )
    _to_lanes(state, room.y)
    return room


@kernel
def _to_lanes(rows, blocks):
    """One row a ball to lane form, a block for every LANES balls; lanes left over repeat the last ball."""
    for i in range(len(blocks) * LANES):
        into_lane(rows[min(i, len(rows) - 1)], blocks[i // LANES], i % LANES)


@kernel
def _from_lanes(blocks, rows):
    """The inverse of `_to_lanes`."""
    for ball in range(len(rows)):
        from_lane(blocks[ball // LANES], ball % LANES, rows[ball])


@inlined
def _all_rates(bearing, drive, near, time, values, rates, room):
    """Rates of all balls from `values`, both (blocks, COLUMNS * LANES)."""
    lanes, rows, row_rates = room.lanes, room.rows, room.row_rates
    speed = drive.speed + drive.acceleration * time
    for block in range(len(values)):
        for i in range(MOTION * LANES):
            lanes[i] = values[block, i]
        for k in range(LANES):
            lanes[RING_SPEED * LANES + k] = speed
        lane_rates(bearing, lanes)
        for i in range(COLUMNS * LANES):
            rates[block, i] = lanes[LANE_RATES * LANES + i]
    if np.any(near):
        _from_lanes(values, rows)
        _from_lanes(rates, row_rates)
        for k in range(bearing.balls):
            add_pair_rates(bearing, near, rows, k, row_rates)
        _to_lanes(row_rates, rates)


@inlined
def _combine(start, h, weights, count, slopes, out):
    """out = start + h * (weighted sum of the first `count` slopes)."""
    for block in range(len(start)):
        for i in range(COLUMNS * LANES):
            out[block, i] = start[block, i]
        for j in range(count):
            factor = h * weights[j]
            if factor != 0.0:
                for i in range(COLUMNS * LANES):
                    out[block, i] += factor * slopes[j, block, i]


@kernel
def _error(method, h, balls, scales, k):
    """Greatest root-mean-square error of a ball, in units of the scales; zero without an estimate."""
    greatest = 0.0
    for ball in range(balls):
        total = 0.0
        for column in range(MOTION):
            error = 0.0
            for j in range(len(method.error)):
                error += method.error[j] * k[j, ball // LANES, column * LANES + ball % LANES]
            ratio = h * error / scales[column]
            total += ratio * ratio
        total = math.sqrt(total / MOTION)
        if not total < math.inf:
            return math.inf
        greatest = max(greatest, total)
    return greatest


@kernel
def _lane_row(values, rates, ball, ahead, row):
    """The motion of a ball from lane form, moved `ahead` [s] along its rates."""
    block, lane = ball // LANES, ball % LANES
    for column in range(MOTION):
        number = column * LANES + lane
        row[column] = values[block, number] + ahead * rates[block, number]


@kernel
def _turn_balls(h, start, start_rates, end, end_rates, orientation):
    """Orientations over one step: the motion at its middle is the cubic Hermite mean of both ends'."""
    first, middle, last, other = np.empty(COLUMNS), np.empty(COLUMNS), np.empty(COLUMNS), np.empty(COLUMNS)
    for ball in range(len(orientation)):
        _lane_row(start, start_rates, ball, 0.25 * h, middle)
        _lane_row(end, end_rates, ball, -0.25 * h, other)
        for column in range(MOTION):
            middle[column] = 0.5 * (middle[column] + other[column])
        _lane_row(start, start_rates, ball, 0.0, first)
        _lane_row(end, end_rates, ball, 0.0, last)
        turn(orientation[ball], first, middle, last, h, orientation[ball])


@kernel
def _turn_since(span, room, rates, orientation):
    """Turns the balls over the `span` [s] since they were turned last."""
    _turn_balls(span, room.turned_from, room.turned_rates, room.y, rates, orientation)
    room.turned_from[:] = room.y
    room.turned_rates[:] = rates


@inlined
def _explicit_step(method, bearing, drive, near, time, h, scales, room):
    """One step from `room.y`, whose rates are the first slope, to `room.trial`, whose rates are the last; its error."""
    stages = len(method.nodes)
    for stage in range(1, stages):
        _combine(room.y, h, method.a[stage], stage, room.k, room.trial)
        _all_rates(bearing, drive, near, time + method.nodes[stage] * h, room.trial, room.k[stage], room)
    _combine(room.y, h, method.weights, stages, room.k, room.trial)
    _all_rates(bearing, drive, near, time + h, room.trial, room.k[stages], room)
    return _error(method, h, bearing.balls, scales, room.k)


@kernel
def explicit_chunk(
    method, bearing, drive, near, times, duration, greatest_step, scales, state, orientation, steps, results
):
    """An explicit Runge-Kutta method, its steps cut so that every instant is the end of one.

    Without an error estimate the steps between two instants are equal, none longer than `greatest_step` [s]; with one
    they adapt, and `steps` (N,) [s] carries their size. Unstable above about 3 / (fastest rate): contact frequency
    [rad/s] or friction rate mu N / (m v_regularisation).
    """
    adaptive, stages, balls = np.any(method.error != 0.0), len(method.nodes), bearing.balls
    room, counts = lane_room(state, stages + 1), results.counts
    time, wanted = 0.0, steps[0] if adaptive else greatest_step
    _all_rates(bearing, drive, near, time, room.y, room.k[0], room)
    for instant in range(len(times) + 1):
        goal = times[instant] if instant < len(times) else duration
        room.turned_from[:] = room.y
        room.turned_rates[:] = room.k[0]
        turned_at, done = time, 0
        while goal - time > 1e-12 * duration:
            h = (goal - time) / max(1.0, math.ceil((goal - time) / wanted - 1e-9))
            error = _explicit_step(method, bearing, drive, near, time, h, scales, room)
            counts[RATES] += stages * balls
            if not error <= 1.0:
                if not adaptive:
                    _from_lanes(room.trial, state)
                    return check_all(bearing, time + h, state, results.failure)
                counts[REJECTIONS] += balls
                wanted = next_step(h, error, method.order)
                if wanted < LEAST_STEP:
                    results.failure[0], results.failure[1] = time, 0
                    return STALLED
                continue
            counts[STEPS] += balls
            if adaptive:
                wanted = next_step(h, error, method.order)
            time = goal if goal - time - h < 1e-12 * duration else time + h
            done += 1
            room.y[:] = room.trial
            room.k[0] = room.k[stages]
            if done % TURN_EVERY == 0 or time == goal:
                _turn_since(time - turned_at, room, room.k[0], orientation)
                turned_at = time
            if done % CHECK_EVERY == 0 or time == goal:
                _from_lanes(room.y, state)
                status = check_all(bearing, time, state, results.failure)
                if status != OK:
                    return status
        if instant < len(times):
            results.states[instant] = state
            results.orientations[instant] = orientation
    steps[:] = wanted
    return OK
