"""Balls that may touch each other, by an adaptive Rosenbrock method: own steps for each group."""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.equations import add_pair, give_coefficients
from bearing_twin.kinds.bearing.jacobian import lane_jacobian
from bearing_twin.kinds.bearing.lanes import SLOPE_STEP
from bearing_twin.kinds.bearing.layout import COLUMNS, JACOBIAN_END, LANES, MOTION, entry, get, new_lanes
from bearing_twin.kinds.bearing.rates import bearing_rates, fill_lanes
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
    error_norm,
    give_out,
    interpolate,
    landing,
    new_dense_step,
    turn,
)
from bearing_twin.numerics.banded import factorise, get_banded, new_banded, put_banded, substitute
from bearing_twin.numerics.steppers import next_step


class GroupRoom(NamedTuple):
    """Arrays to work in; state-like ones have one row a ball of the bearing, the others one a ball of the group.

    Block (i, i + offset) of the Jacobian is jacobian[i, offset + reach], (COLUMNS, MOTION): neighbours stand at most
    `reach` places apart in a group. `place` (balls,) is where a ball stands in it.
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
    pair: np.ndarray
    lanes: np.ndarray


@inlined
def _band(reach):
    """How far from the diagonal of the matrix its entries stand."""
    return (reach + 1) * MOTION - 1


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
    return GroupRoom(
        start=state.copy(),
        trial=state.copy(),
        base=np.zeros_like(state),
        slope=np.zeros_like(state),
        rates=np.zeros_like(state),
        place=place,
        reach=reach,
        jacobian=np.zeros((size, 2 * reach + 1, COLUMNS, MOTION)),
        matrix=new_banded(size * MOTION, _band(reach)),
        pivots=np.zeros(size * MOTION, np.int64),
        k=np.zeros((stages, size, COLUMNS)),
        right=np.zeros((size, COLUMNS)),
        motion=np.zeros(size * MOTION),
        pair=np.zeros((4, COLUMNS)),
        lanes=new_lanes(JACOBIAN_END),
    )


@kernel
def _jacobian(bearing, drive, near, time, state, group, nudges, room):
    """d(rates)/d(motion) of a group of balls: each on itself and on the neighbours it touches.

    What raceways answer is exact (with friction at a point), what balls do to each other by forward differences.
    """
    size, reach, jacobian, lanes = len(group), room.reach, room.jacobian, room.lanes
    jacobian[:] = 0.0
    for first in range(0, size, LANES):
        count = fill_lanes(drive, time, state, group, first, lanes)
        give_coefficients(bearing, lanes)
        lane_jacobian(bearing.spot, bearing, lanes)
        for k in range(count):
            for rate in range(COLUMNS):
                for column in range(MOTION):
                    jacobian[first + k, reach, rate, column] = get(lanes, entry(rate, column), k)
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
                offset = room.place[moved] - i
                for rate in range(COLUMNS):
                    change = pair[2 + which, rate] - pair[which, rate]
                    room.jacobian[i, offset + room.reach, rate, column] += change / nudge


@kernel
def _fill_matrix(inverse, size, room):
    """W = inverse I - J in band form."""
    reach, matrix, band = room.reach, room.matrix, _band(room.reach)
    matrix[:] = 0.0
    for i in range(size):
        for rate in range(MOTION):
            row = i * MOTION + rate
            for j in range(max(0, i - reach), min(size, i + reach + 1)):
                for column in range(MOTION):
                    put_banded(matrix, band, row, j * MOTION + column, -room.jacobian[i, j - i + reach, rate, column])
            put_banded(matrix, band, row, row, inverse + get_banded(matrix, band, row, row))


@kernel
def _stage_solution(inverse, size, room, stage):
    """Solves W k = right for one stage: motion by the factors, then the integrals that only listen."""
    motion, right, reach = room.motion, room.right, room.reach
    for i in range(size):
        for column in range(MOTION):
            motion[i * MOTION + column] = right[i, column]
    substitute(room.matrix, room.pivots, size * MOTION, _band(reach), motion)
    for i in range(size):
        for column in range(MOTION):
            stage[i, column] = motion[i * MOTION + column]
        for integral in range(MOTION, COLUMNS):
            value = right[i, integral]
            for j in range(max(0, i - reach), min(size, i + reach + 1)):
                for column in range(MOTION):
                    value += room.jacobian[i, j - i + reach, integral, column] * motion[j * MOTION + column]
            stage[i, integral] = value / inverse


@kernel
def _rosenbrock_step(method, bearing, drive, near, time, h, group, room):
    """One step of a group from `room.start`: its end into `room.trial`, stages into `room.k`; False if singular."""
    size = len(group)
    inverse = 1.0 / (h * method.gamma)
    k, trial, right = room.k, room.trial, room.right
    _fill_matrix(inverse, size, room)
    if not factorise(room.matrix, room.pivots, size * MOTION, _band(room.reach)):
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
def _fill_dense(weights, room, i, ball, orientation, dense):
    """The dense step of ball i of its group by the method's dense weights."""
    k = room.k
    for column in range(COLUMNS):
        third, fourth = 0.0, 0.0
        for stage in range(min(weights.shape[1], len(k))):
            third += weights[0, stage] * k[stage, i, column]
            fourth += weights[1, stage] * k[stage, i, column]
        dense.start[column], dense.end[column] = room.start[ball, column], room.trial[ball, column]
        dense.third[column], dense.fourth[column] = third, fourth
    dense.orientation[:] = orientation[ball]


@kernel
def _give_out(task, cursor, time, step, until, group, room, orientation, dense, results):
    """Writes the instants inside the step just accepted; returns the next instant to serve."""
    served = cursor
    if cursor < len(task.times) and task.times[cursor] <= until:
        for i in range(len(group)):
            _fill_dense(task.method.dense, room, i, group[i], orientation, dense)
            served = give_out(task.times, cursor, until, time, step, group[i], dense, results)
    return served


@kernel
def _accept(method, bearing, time, h, group, room, orientation, dense, failure):
    """Moves a group to the end of its step; OK, or why the new state cannot be right."""
    for i in range(len(group)):
        ball = group[i]
        _fill_dense(method.dense, room, i, ball, orientation, dense)
        interpolate(dense, 0.5, dense.between)
        turn(dense.orientation, dense.start, dense.between, dense.end, h, orientation[ball])
        room.start[ball] = room.trial[ball]
        status = check_ball(bearing, room.start, ball)
        if status != OK:
            failure[0], failure[1] = time + h, ball
            return status
    return OK


@kernel
def _greatest_error(errors, scales):
    """Greatest `error_norm` of a ball in the group."""
    greatest = 0.0
    for i in range(len(errors)):
        greatest = max(greatest, error_norm(errors[i], scales))
    return greatest


@kernel
def _linearise(bearing, drive, near, time, step, group, nudges, room):
    """Rates, Jacobian and explicit time dependence at the start of a step, about as long as `step` [s]."""
    start, base, slope = room.start, room.base, room.slope
    bearing_rates(bearing, drive, near, time, start, group, base, room.lanes)
    _jacobian(bearing, drive, near, time, start, group, nudges, room)
    if drive.acceleration != 0.0:
        later = SLOPE_STEP * step
        bearing_rates(bearing, drive, near, time + later, start, group, slope, room.lanes)
        for ball in group:
            for column in range(COLUMNS):
                slope[ball, column] = (slope[ball, column] - base[ball, column]) / later


@kernel
def _first_landing(method, bearing, group, room, orientation, dense):
    """Share of a group's step after which a first contact with a raceway has just begun or ended; 1 where none does."""
    first = 1.0
    for i in range(len(group)):
        if changes_contact(bearing, room.start[group[i]], room.trial[group[i]]):
            _fill_dense(method.dense, room, i, group[i], orientation, dense)
            first = min(first, landing(bearing, dense))
    return first


@kernel
def _advance_group(task, group, room, orientation, steps, results):
    """Integrates one group of balls over the chunk with its own adaptive steps."""
    method, bearing, drive, near = task.method, task.bearing, task.drive, task.near
    size, counts, dense = len(group), results.counts, new_dense_step()
    time, cursor, fresh, h = 0.0, 0, True, task.duration
    for i in range(size):
        h = min(h, steps[group[i]])
    while time < task.duration:
        last = time + h >= task.duration * (1.0 - 1e-12)
        step = task.duration - time if last else h
        if fresh:
            _linearise(bearing, drive, near, time, step, group, task.nudges, room)
            counts[JACOBIANS] += size
            counts[RATES] += size
        solved = _rosenbrock_step(method, bearing, drive, near, time, step, group, room)
        counts[RATES] += size * (len(method.alpha) - 1)
        error = _greatest_error(room.k[len(method.alpha) - 1], task.scales) if solved else math.inf
        proposed = next_step(step, error, method.order)
        if error > 1.0:
            counts[REJECTIONS] += size
            fresh, h = False, proposed
            if h < LEAST_STEP:
                results.failure[0], results.failure[1] = time, group[0]
                return STALLED
            continue
        share = _first_landing(method, bearing, group, room, orientation, dense) if method.lands else 1.0
        if share < LANDED:
            counts[REJECTIONS] += size
            fresh, h = False, share * step
            continue
        until = math.inf if last else time + step  # at the end of the chunk no instant is lost to rounding
        cursor = _give_out(task, cursor, time, step, until, group, room, orientation, dense, results)
        status = _accept(method, bearing, time, step, group, room, orientation, dense, results.failure)
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
