"""The bearing by explicit Runge-Kutta methods, all balls side by side in vector lanes, one step size for all."""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.carried import carry_on
from bearing_twin.kinds.bearing.layout import (
    AXIS_DISTANCE,
    CARRIED_INNER,
    COLUMNS,
    LANE_ROWS,
    LANES,
    MOTION,
    STATE_SPAN,
    from_blocks,
    get,
    into_blocks,
    new_blocks,
)
from bearing_twin.kinds.bearing.pairs import Pairs, new_pairs
from bearing_twin.kinds.bearing.rates import block_rates
from bearing_twin.kinds.bearing.steps import LEAST_STEP, RATES, REJECTIONS, STEPS, check_all, error_norm, turn
from bearing_twin.numerics.statuses import OK, STALLED, STOPPED
from bearing_twin.numerics.steppers import next_step

# Orientations need fewer steps than the contacts do; a state that cannot be right is looked for now and then and at
# every instant given out.
TURN_EVERY, CHECK_EVERY = 8, 64


class LaneRoom(NamedTuple):
    """Arrays to work in: `y`, `trial` and each slope of `k` are (blocks, STATE_SPAN), `lanes` those of `layout`."""

    y: np.ndarray
    trial: np.ndarray
    k: np.ndarray
    turned_from: np.ndarray
    turned_rates: np.ndarray
    lanes: np.ndarray
    pairs: Pairs


@kernel
def lane_room(state, near, slopes):
    """Room for a method with so many slopes, holding `state`."""
    y = new_blocks(len(state), COLUMNS)
    into_blocks(state, y, AXIS_DISTANCE)
    return LaneRoom(
        y=y,
        trial=np.zeros_like(y),
        k=np.zeros((slopes, *y.shape)),
        turned_from=np.zeros_like(y),
        turned_rates=np.zeros_like(y),
        lanes=new_blocks(len(state), LANE_ROWS),
        pairs=new_pairs(near, np.arange(len(state)), 1.0),
    )


@inlined
def _combine(start, h, weights, count, slopes, out):
    """out = start + h * (weighted sum of the first `count` slopes)."""
    for block in range(len(start)):
        for i in range(STATE_SPAN):
            out[block, i] = start[block, i]
        for j in range(count):
            factor = h * weights[j]
            if factor != 0.0:
                for i in range(STATE_SPAN):
                    out[block, i] += factor * slopes[j, block, i]


@kernel
def _greatest_error(method, h, balls, scales, k):
    """Greatest `error_norm` of a ball."""
    greatest, errors = 0.0, np.empty(MOTION)
    for ball in range(balls):
        block, lane = ball // LANES, ball % LANES
        for column in range(MOTION):
            error = 0.0
            for j in range(len(method.error)):
                error += method.error[j] * get(k[j, block], column, lane)
            errors[column] = h * error
        greatest = max(greatest, error_norm(errors, scales))
    return greatest


@kernel
def _lane_row(values, rates, ball, ahead, row):
    """The motion of a ball from lane form, moved `ahead` [s] along its rates."""
    block, lane = ball // LANES, ball % LANES
    for column in range(MOTION):
        row[column] = get(values[block], column, lane) + ahead * get(rates[block], column, lane)


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
def _explicit_step(method, adaptive, bearing, drive, time, h, scales, room):
    """One step from `room.y`, whose rates are the first slope, to `room.trial`, whose rates are the last; its error.

    Without an estimate the error is 0: `check_all` finds what is not finite.
    """
    stages = len(method.nodes)
    for stage in range(1, stages):
        _combine(room.y, h, method.a[stage], stage, room.k, room.trial)
        moment = time + method.nodes[stage] * h
        block_rates(bearing, drive, room.pairs, moment, room.trial, room.k[stage], room.lanes)
    _combine(room.y, h, method.weights, stages, room.k, room.trial)
    block_rates(bearing, drive, room.pairs, time + h, room.trial, room.k[stages], room.lanes)
    return _greatest_error(method, h, bearing.balls, scales, room.k) if adaptive else 0.0


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
    room, counts = lane_room(state, near, stages + 1), results.counts
    time, wanted = 0.0, steps[0] if adaptive else greatest_step
    into_blocks(results.carried, room.lanes, CARRIED_INNER)
    block_rates(bearing, drive, room.pairs, time, room.y, room.k[0], room.lanes)
    for instant in range(len(times) + 1):
        goal = times[instant] if instant < len(times) else duration
        room.turned_from[:] = room.y
        room.turned_rates[:] = room.k[0]
        turned_at, done = time, 0
        while goal - time > 1e-12 * duration:
            if results.stop[0] != 0:
                return STOPPED
            h = (goal - time) / max(1.0, math.ceil((goal - time) / wanted - 1e-9))
            error = _explicit_step(method, adaptive, bearing, drive, time, h, scales, room)
            counts[RATES] += stages * balls
            if not error <= 1.0:
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
            for block in range(len(room.y)):
                carry_on(bearing, room.y[block], AXIS_DISTANCE, room.lanes[block])
            if done % TURN_EVERY == 0 or time == goal:
                _turn_since(time - turned_at, room, room.k[0], orientation)
                turned_at = time
            if done % CHECK_EVERY == 0 or time == goal:
                from_blocks(room.y, AXIS_DISTANCE, state)
                status = check_all(bearing, time, state, results.failure)
                if status != OK:
                    return status
        if instant < len(times):
            results.states[instant] = state
            results.orientations[instant] = orientation
    steps[:] = wanted
    from_blocks(room.lanes, CARRIED_INNER, results.carried)
    return OK
