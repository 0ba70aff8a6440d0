"""The bearing by the classical Runge-Kutta method, all balls side by side in vector lanes."""

import math

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.scenes.bearing import (
    COLUMNS,
    LANE_ROWS,
    LANES,
    MOTION,
    add_pair_rates,
    aim_lane,
    give_coefficients,
    raceway_rates,
)
from bearing_twin.scenes.bearing_steps import OK, RATES, STEPS, check_all, turn

# Directions are refreshed long before a ball has gone the 0.1 rad up to which they are exact; orientations need fewer
# steps than the contacts do; a state that cannot be right is looked for now and then and at every instant given out.
AIM_EVERY, TURN_EVERY, CHECK_EVERY = 16, 8, 64


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
def _rows_of(values, balls, rows):
    """Lane form to one row a ball."""
    for block in range(len(values)):
        _from_lanes(values[block], block * LANES, min(LANES, balls - block * LANES), rows)


@kernel
def _all_rates(bearing, drive, near, touching, time, values, rates, rows, row_rates):
    """Rates of all balls (blocks, COLUMNS * LANES) from `values` (blocks, LANE_ROWS * LANES)."""
    speed = drive.speed + drive.acceleration * time
    for block in range(len(values)):
        count = min(LANES, bearing.balls - block * LANES)
        give_coefficients(bearing, count, values[block])
        raceway_rates(bearing, speed, count, values[block], rates[block])
    if touching:
        _rows_of(values, bearing.balls, rows)
        _rows_of(rates, bearing.balls, row_rates)
        for k in range(bearing.balls):
            add_pair_rates(bearing, near, rows, k, row_rates)
        for block in range(len(values)):
            _to_lanes(row_rates, block * LANES, min(LANES, bearing.balls - block * LANES), rates[block])


@kernel
def _aim(values, balls, others):
    """Takes the present orbit angles as those from which directions are measured, for `values` and for `others`."""
    for block in range(len(values)):
        for lane in range(min(LANES, balls - block * LANES)):
            aim_lane(values[block], lane)
        others[block, COLUMNS * LANES :] = values[block, COLUMNS * LANES :]


@kernel
def _combine(start, factor, slope, out):
    """out = start + factor * slope."""
    for block in range(start.shape[0]):
        for i in range(COLUMNS * LANES):
            out[block, i] = start[block, i] + factor * slope[block, i]


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
    shape, rates_shape = (blocks, LANE_ROWS * LANES), (blocks, COLUMNS * LANES)
    y, trial, turned_from = np.ones(shape), np.ones(shape), np.ones(shape)
    k1, k, total, turned_rates = (
        np.zeros(rates_shape),
        np.zeros(rates_shape),
        np.zeros(rates_shape),
        np.zeros(rates_shape),
    )
    rows, row_rates = state.copy(), np.zeros_like(state)
    touching = np.any(near)
    for block in range(blocks):
        _to_lanes(state, block * LANES, min(LANES, balls - block * LANES), y[block])
    _aim(y, balls, trial)
    time = 0.0
    _all_rates(bearing, drive, near, touching, time, y, k1, rows, row_rates)
    for instant in range(len(times) + 1):
        goal = times[instant] if instant < len(times) else duration
        span = goal - time
        steps = math.ceil(span / greatest_step - 1e-9) if span > 0.0 else 0
        begin, unturned = time, 0
        turned_from[:] = y
        turned_rates[:] = k1
        for step in range(steps):
            h = span / steps
            if step % AIM_EVERY == 0:
                _aim(y, balls, trial)
            total[:] = k1
            for stage in range(1, 4):
                half = 0.5 if stage < 3 else 1.0
                _combine(y, half * h, k1 if stage == 1 else k, trial)
                _all_rates(bearing, drive, near, touching, time + half * h, trial, k, rows, row_rates)
                _combine(total, 2.0 if stage < 3 else 1.0, k, total)
            _combine(y, h / 6.0, total, y)
            time = begin + (step + 1) * h
            _all_rates(bearing, drive, near, touching, time, y, k1, rows, row_rates)
            unturned += 1
            if unturned == TURN_EVERY or step == steps - 1:
                _turn_balls(unturned * h, turned_from, turned_rates, y, k1, orientation)
                turned_from[:] = y
                turned_rates[:] = k1
                unturned = 0
            counts[STEPS] += balls
            counts[RATES] += 4 * balls
            if step % CHECK_EVERY == CHECK_EVERY - 1 or step == steps - 1:
                _rows_of(y, balls, state)
                status = check_all(bearing, drive, time, state, failure)
                if status != OK:
                    return status
        if instant < len(times):
            states[instant] = state
            orientations[instant] = orientation
    return OK
