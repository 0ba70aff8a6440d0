"""The bearing by the classical Runge-Kutta method, all balls side by side in vector lanes."""

import math

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.scenes.bearing import (
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
from bearing_twin.scenes.bearing_rates import lane_rates
from bearing_twin.scenes.bearing_steps import OK, RATES, STEPS, check_all, turn

# Orientations need fewer steps than the contacts do; a state that cannot be right is looked for now and then and at
# every instant given out.
TURN_EVERY, CHECK_EVERY = 8, 64


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


@kernel
def _all_rates(bearing, drive, near, touching, time, values, rates, lanes, rows, row_rates):
    """Rates of all balls from `values`, both (blocks, COLUMNS * LANES)."""
    speed = drive.speed + drive.acceleration * time
    for block in range(len(values)):
        for i in range(MOTION * LANES):
            lanes[i] = values[block, i]
        for k in range(LANES):
            lanes[RING_SPEED * LANES + k] = speed
        lane_rates(bearing, lanes)
        for i in range(COLUMNS * LANES):
            rates[block, i] = lanes[LANE_RATES * LANES + i]
    if touching:
        _from_lanes(values, rows)
        _from_lanes(rates, row_rates)
        for k in range(bearing.balls):
            add_pair_rates(bearing, near, rows, k, row_rates)
        _to_lanes(row_rates, rates)


@kernel
def _combine(start, factor, slope, out):
    """out = start + factor * slope."""
    for block in range(len(start)):
        for i in range(COLUMNS * LANES):
            out[block, i] = start[block, i] + factor * slope[block, i]


@kernel
def _sum(total, factor, slope):
    """total += factor * slope."""
    for block in range(len(total)):
        for i in range(COLUMNS * LANES):
            total[block, i] += factor * slope[block, i]


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
    y, trial, turned_from = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    k1, k, total, turned_rates = np.zeros(shape), np.zeros(shape), np.zeros(shape), np.zeros(shape)
    lanes, rows, row_rates = np.zeros(LANE_ROWS * LANES), state.copy(), np.zeros_like(state)
    touching = np.any(near)
    _to_lanes(state, y)
    time = 0.0
    _all_rates(bearing, drive, near, touching, time, y, k1, lanes, rows, row_rates)
    for instant in range(len(times) + 1):
        goal = times[instant] if instant < len(times) else duration
        span = goal - time
        steps = math.ceil(span / greatest_step - 1e-9) if span > 0.0 else 0
        begin, unturned = time, 0
        turned_from[:] = y
        turned_rates[:] = k1
        for step in range(steps):
            h = span / steps
            total[:] = k1
            for stage in range(1, 4):
                half = 0.5 if stage < 3 else 1.0
                _combine(y, half * h, k1 if stage == 1 else k, trial)
                _all_rates(bearing, drive, near, touching, time + half * h, trial, k, lanes, rows, row_rates)
                _sum(total, 2.0 if stage < 3 else 1.0, k)
            _combine(y, h / 6.0, total, y)
            time = begin + (step + 1) * h
            _all_rates(bearing, drive, near, touching, time, y, k1, lanes, rows, row_rates)
            unturned += 1
            if unturned == TURN_EVERY or step == steps - 1:
                _turn_balls(unturned * h, turned_from, turned_rates, y, k1, orientation)
                turned_from[:] = y
                turned_rates[:] = k1
                unturned = 0
            counts[STEPS] += balls
            counts[RATES] += 4 * balls
            if step % CHECK_EVERY == CHECK_EVERY - 1 or step == steps - 1:
                _from_lanes(y, state)
                status = check_all(bearing, drive, time, state, failure)
                if status != OK:
                    return status
        if instant < len(times):
            states[instant] = state
            orientations[instant] = orientation
    return OK
