"""Balls that may touch each other, by an adaptive Rosenbrock method: own steps for each group."""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.kinds.bearing.equations import (
    COLUMNS,
    LANES,
    MOTION,
    RING_SPEED,
    add_pair,
    give_coefficients,
    into_lane,
)
from bearing_twin.kinds.bearing.jacobian import JACOBIAN, JACOBIAN_END, lane_jacobian
from bearing_twin.kinds.bearing.rates import bearing_rates
from bearing_twin.kinds.bearing.steps import (
    JACOBIANS,
    LANDED,
    LEAST_STEP,
    OK,
    RATES,
    REJECTIONS,
    STALLED,
    STEPS,
    changes_contact,
    check_ball,
    turn,
)
from bearing_twin.numerics.steppers import factorise, next_step, rosenbrock_dense, substitute


class Room(NamedTuple):
    """Arrays to work in; state-like ones have one row a ball of the bearing, the others one a ball of the group.

    Block (i, i + offset) of the Jacobian is jacobian[i, :, (offset + reach) * MOTION :][:, :MOTION]: neighbours stand
    at most `reach` places apart in a group. `place` (balls,) is where a ball stands in it.
    """

    start: np.ndarray
    trial: np.ndarray
    base: np.ndarray
    slope: np.ndarray
    rates: np.ndarray
    place: np.ndarray
    reach: int
    jacobian: np.ndarray
    matrix: np.ndarray
    pivots: np.ndarray
    k: np.ndarray
    right: np.ndarray
    motion: np.ndarray
    middle: np.ndarray
    pair: np.ndarray
    lanes: np.ndarray


@kernel
def _room(state, group, stages):
    size, balls = len(group), len(state)
    place = np.full(balls, -1)
    for i in range(size):
        place[group[i]] = i
    reach = 1
    for ball in group:
        ahead = place[(ball + 1) % balls]
        if ahead >= 0:
            reach = max(reach, abs(ahead - place[ball]))
    band = (reach + 1) * MOTION - 1
    return Room(
        state.copy(),
        state.copy(),
        np.zeros_like(state),
        np.zeros_like(state),
        np.zeros_like(state),
        place,
        reach,
        np.zeros((size, COLUMNS, (2 * reach + 1) * MOTION)),
        np.zeros((size * MOTION, 3 * band + 1)),
        np.zeros(size * MOTION, np.int64),
        np.zeros((stages, size, COLUMNS)),
        np.zeros((size, COLUMNS)),
        np.zeros(size * MOTION),
        np.zeros(COLUMNS),
        np.zeros((4, COLUMNS)),
        np.zeros(JACOBIAN_END * LANES),
    )


@kernel
def _jacobian(bearing, drive, near, time, state, group, nudges, room):
    """d(rates)/d(motion) of a group of balls: each on itself and on the neighbours it touches.

    What raceways answer is exact (with friction at a point), what balls do to each other by forward differences.
    """
    size, reach, jacobian, lanes = len(group), room.reach, room.jacobian, room.lanes
    jacobian[:] = 0.0
    for first in range(0, size, LANES):
        count = min(LANES, size - first)
        for k in range(LANES):
            into_lane(state[group[first + min(k, count - 1)], :MOTION], lanes, k)
            lanes[RING_SPEED * LANES + k] = drive.speed + drive.acceleration * time
        give_coefficients(bearing, lanes)
        lane_jacobian(bearing.spot, bearing, lanes)
        for k in range(count):
            for row in range(COLUMNS):
                for column in range(MOTION):
                    value = lanes[(JACOBIAN + row * MOTION + column) * LANES + k]
                    jacobian[first + k, row, reach * MOTION + column] = value
    for ball in group:
        if near[ball]:
            _pair_jacobian(bearing, state, ball, nudges, room)


@kernel
def _pair_jacobian(bearing, state, ball, nudges, room):
    """Adds what the contact of a ball with the next one ahead answers to the motion of either."""
    other, pair = (ball + 1) % bearing.balls, room.pair
    pair[:] = 0.0
    add_pair(bearing, state, ball, 1, pair[0])
    add_pair(bearing, state, other, -1, pair[1])
    if not np.any(pair[0]):
        return
    for moved in (ball, other):
        for column in range(MOTION):
            kept = state[moved, column]
            state[moved, column] = kept + nudges[column]
            nudge = state[moved, column] - kept
            pair[2:] = 0.0
            add_pair(bearing, state, ball, 1, pair[2])
            add_pair(bearing, state, other, -1, pair[3])
            state[moved, column] = kept
            for which in range(2):
                i = room.place[ball if which == 0 else other]
                block = (room.place[moved] - i + room.reach) * MOTION
                for row in range(COLUMNS):
                    change = pair[2 + which, row] - pair[which, row]
                    room.jacobian[i, row, block + column] += change / nudge


@kernel
def _fill_matrix(inverse, size, room):
    """W = inverse I - J in band form."""
    reach, matrix = room.reach, room.matrix
    band = (reach + 1) * MOTION - 1
    matrix[:] = 0.0
    for i in range(size):
        for row in range(MOTION):
            for offset in range(max(-reach, -i), min(reach, size - 1 - i) + 1):
                for column in range(MOTION):
                    value = -room.jacobian[i, row, (offset + reach) * MOTION + column]
                    matrix[i * MOTION + row, offset * MOTION + column - row + band] = value
            matrix[i * MOTION + row, band] += inverse


@kernel
def _stage_solution(inverse, size, room, stage):
    """Solves W k = right for one stage: motion by the factors, then the integrals that only listen."""
    motion, right, reach = room.motion, room.right, room.reach
    for i in range(size):
        for column in range(MOTION):
            motion[i * MOTION + column] = right[i, column]
    substitute(room.matrix, room.pivots, size * MOTION, (reach + 1) * MOTION - 1, motion)
    for i in range(size):
        for column in range(MOTION):
            stage[i, column] = motion[i * MOTION + column]
        for column in range(MOTION, COLUMNS):
            value = right[i, column]
            for offset in range(max(-reach, -i), min(reach, size - 1 - i) + 1):
                for other in range(MOTION):
                    answer = room.jacobian[i, column, (offset + reach) * MOTION + other]
                    value += answer * motion[(i + offset) * MOTION + other]
            stage[i, column] = value / inverse


@kernel
def _rosenbrock_step(method, bearing, drive, near, time, h, group, room):
    """One step of a group from `room.start`: its end into `room.trial`, stages into `room.k`; False if singular."""
    size = len(group)
    inverse = 1.0 / (h * method.gamma)
    k, trial, right = room.k, room.trial, room.right
    _fill_matrix(inverse, size, room)
    if not factorise(room.matrix, room.pivots, size * MOTION, (room.reach + 1) * MOTION - 1):
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
        if stage > 0:
            moment = time + method.alpha[stage] * h
            bearing_rates(bearing, drive, near, moment, trial, group, room.rates, room.lanes)
        for i in range(size):
            for column in range(COLUMNS):
                right[i, column] += room.base[group[i], column] if stage == 0 else room.rates[group[i], column]
        _stage_solution(inverse, size, room, k[stage])
    for i in range(size):
        for column in range(COLUMNS):
            trial[group[i], column] += k[stages - 1, i, column]
    return True


@kernel
def _interpolate(method, fraction, start, end, k, i, out):
    """The step's interpolant at `fraction` of it, for ball i of its group."""
    for column in range(COLUMNS):
        third, fourth = 0.0, 0.0
        for stage in range(min(method.dense.shape[1], len(k))):
            third += method.dense[0, stage] * k[stage, i, column]
            fourth += method.dense[1, stage] * k[stage, i, column]
        out[column] = rosenbrock_dense(fraction, start[column], end[column], third, fourth)


@kernel
def _give_out(task, cursor, time, h, until, group, room, orientation, results):
    """Writes the instants inside the step just accepted, from its interpolant; returns the next instant to serve."""
    method, times, middle = task.method, task.times, room.middle
    states, orientations = results.states, results.orientations
    while cursor < len(times) and times[cursor] <= until:
        fraction = (times[cursor] - time) / h
        for i in range(len(group)):
            ball = group[i]
            start, end = room.start[ball], room.trial[ball]
            _interpolate(method, fraction, start, end, room.k, i, states[cursor, ball])
            _interpolate(method, 0.5 * fraction, start, end, room.k, i, middle)
            turn(orientation[ball], start, middle, states[cursor, ball], fraction * h, orientations[cursor, ball])
        cursor += 1
    return cursor


@kernel
def _accept(method, bearing, drive, time, h, group, room, orientation, failure):
    """Moves a group to the end of its step; OK, or why the new state cannot be right."""
    for i in range(len(group)):
        ball = group[i]
        _interpolate(method, 0.5, room.start[ball], room.trial[ball], room.k, i, room.middle)
        turn(orientation[ball], room.start[ball], room.middle, room.trial[ball], h, orientation[ball])
        room.start[ball] = room.trial[ball]
        status = check_ball(bearing, room.start, ball)
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
    bearing_rates(bearing, drive, near, time, start, group, base, room.lanes)
    _jacobian(bearing, drive, near, time, start, group, nudges, room)
    if drive.acceleration != 0.0:
        later = 1e-7
        bearing_rates(bearing, drive, near, time + later, start, group, slope, room.lanes)
        for ball in group:
            for column in range(COLUMNS):
                slope[ball, column] = (slope[ball, column] - base[ball, column]) / later


@kernel
def _landing(method, bearing, group, room):
    """Share of a group's step after which a first contact with a raceway has just begun or ended; 1 where none does."""
    first = 1.0
    for i in range(len(group)):
        start, end, middle = room.start[group[i]], room.trial[group[i]], room.middle
        if not changes_contact(bearing, start, end):
            continue
        low, high = 0.0, 1.0
        while high - low > 1e-6:
            share = 0.5 * (low + high)
            _interpolate(method, share, start, end, room.k, i, middle)
            if changes_contact(bearing, start, middle):
                high = share
            else:
                low = share
        first = min(first, high)
    return first


@kernel
def _advance_group(task, group, room, orientation, steps, results):
    """Integrates one group of balls over the chunk with its own adaptive steps."""
    method, bearing, drive, near = task.method, task.bearing, task.drive, task.near
    size, counts = len(group), results.counts
    time, cursor, fresh, h = 0.0, 0, True, task.duration
    for i in range(size):
        h = min(h, steps[group[i]])
    while time < task.duration:
        last = time + h >= task.duration * (1.0 - 1e-12)
        step = task.duration - time if last else h
        if fresh:
            _linearise(bearing, drive, near, time, group, task.nudges, room)
            counts[JACOBIANS] += size
            counts[RATES] += size
        solved = _rosenbrock_step(method, bearing, drive, near, time, step, group, room)
        counts[RATES] += size * (len(method.alpha) - 1)
        error = _error_norm(group, room.k[len(method.alpha) - 1], task.scales) if solved else math.inf
        proposed = next_step(step, error, method.order)
        if error > 1.0:
            counts[REJECTIONS] += size
            fresh, h = False, proposed
            if h < LEAST_STEP:
                results.failure[0], results.failure[1] = time, group[0]
                return STALLED
            continue
        share = _landing(method, bearing, group, room) if method.lands else 1.0
        if share < LANDED:
            counts[REJECTIONS] += size
            fresh, h = False, share * step
            continue
        until = math.inf if last else time + step  # at the end of the chunk no instant is lost to rounding
        cursor = _give_out(task, cursor, time, step, until, group, room, orientation, results)
        status = _accept(method, bearing, drive, time, step, group, room, orientation, results.failure)
        if status != OK:
            return status
        counts[STEPS] += size
        time = task.duration if last else time + step
        fresh = True
        # The last step was cut short by the end of the chunk: what it proposes counts only if it is longer.
        h = max(h, proposed) if last else proposed
    for i in range(size):
        steps[group[i]] = h
    return OK


@kernel
def group_chunk(task, group, state, orientation, steps, results):
    """Advances one group of balls, numbered in `group`, over the chunk; a row of neighbours, or the whole ring."""
    room = _room(state, group, len(task.method.alpha))
    status = _advance_group(task, group, room, orientation, steps, results)
    if status == OK:
        for ball in group:
            state[ball] = room.start[ball]
    return status


def groups_of(near) -> list[list[int]]:
    """Cuts the ring of balls into rows of neighbours that may meet; `near[k]` (N,) speaks of balls k and k + 1.

    A whole ring is folded, 0, N - 1, 1, N - 2, ..., so that neighbours stand at most two places apart.
    """
    balls = len(near)
    if all(near):
        return [[k // 2 if k % 2 == 0 else balls - 1 - k // 2 for k in range(balls)]]
    first = next(k for k in range(balls) if not near[k - 1])
    groups = []
    for k in range(first, first + balls):
        if groups and near[(k - 1) % balls]:
            groups[-1].append(k % balls)
        else:
            groups.append([k % balls])
    return groups
