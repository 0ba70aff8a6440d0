"""The bearing by explicit Runge-Kutta methods, all balls side by side in vector lanes, one step size for all."""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.forces.carried import carry_on
from bearing_twin.kinds.bearing.forces.equations import Bearing, RingDrive
from bearing_twin.kinds.bearing.forces.layout import (
    AXIAL_SPIN,
    AXIS_DISTANCE,
    CARRIED_INNER,
    LANE_ROWS,
    MOTION,
    MOTION_SPAN,
    RADIAL_SPIN,
    TANGENTIAL_SPIN,
    TANGENTIAL_VELOCITY,
)
from bearing_twin.kinds.bearing.forces.pairs import Pairs, new_pairs
from bearing_twin.kinds.bearing.forces.rates import block_rates
from bearing_twin.kinds.bearing.stepping.steps import check_all, lane_spin, spin_in_frame
from bearing_twin.numerics.lanes import (
    COLUMNS,
    LANE_RATES,
    LANES,
    STATE_SPAN,
    from_blocks,
    get,
    get_quaternion,
    increase,
    into_blocks,
    new_blocks,
    new_lanes,
    put,
    put_quaternion,
)
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.lockstep import Pace, advance_together
from bearing_twin.numerics.rotation import turned
from bearing_twin.numerics.runge_kutta import combine_blocks, hermite
from bearing_twin.numerics.statuses import EVALUATIONS, OK
from bearing_twin.numerics.steppers import RungeKutta

# Rows of what turns the balls: state and rates where they were turned last, and now; their orientation.
BEFORE, BEFORE_RATES, NOW, NOW_RATES, TURNED_TO, TURNING_ROWS = np.cumsum((0, *(COLUMNS,) * 4, 4))


class LaneRoom(NamedTuple):
    """Arrays to work in: `y`, `errors` and each slope of `k` are (blocks, STATE_SPAN), `lanes` those of `layout`.

    The lanes begin with the state tried; `turning` holds the rows from BEFORE on.
    """

    y: np.ndarray
    errors: np.ndarray
    k: np.ndarray
    turning: np.ndarray
    lanes: np.ndarray
    pairs: Pairs


@kernel
def _lane_room(state, orientation, near, slopes):
    """Room for a method with so many slopes, holding `state` and `orientation`."""
    y, lanes = new_blocks(len(state), COLUMNS), new_blocks(len(state), LANE_ROWS)
    turning = new_blocks(len(state), TURNING_ROWS)
    into_blocks(state, y, AXIS_DISTANCE)
    into_blocks(state, lanes, AXIS_DISTANCE)
    into_blocks(orientation, turning, TURNED_TO)
    k = new_lanes(slopes * len(y) * COLUMNS).reshape((slopes, *y.shape))
    return LaneRoom(y, new_blocks(len(state), COLUMNS), k, turning, lanes, new_pairs(near, np.arange(len(state)), 1.0))


@lean_kernel
def _greatest_error(weights, h, balls, scales, slopes, errors):
    """Greatest root mean square of a ball's errors in units of the scales; infinite where one is not finite.

    `errors` is room to work in.
    """
    greatest = 0.0
    for block in range(len(errors)):
        for i in range(STATE_SPAN):
            errors[block, i] = 0.0
        for j in range(len(weights)):
            for i in range(MOTION_SPAN):
                errors[block, i] += weights[j] * slopes[j, block, i]
        for column in range(MOTION):
            for k in range(LANES):
                ratio = h * get(errors[block], column, k) / scales[column]
                increase(errors[block], MOTION, k, ratio * ratio)
    for ball in range(balls):
        total = get(errors[ball // LANES], MOTION, ball % LANES)
        greatest = max(greatest, total if total < math.inf else math.inf)
    return math.sqrt(greatest / MOTION)


@inlined
def _note(room, row):
    """Writes where the balls are at the start of a step, and their rates there, into the rows from `row` on."""
    for block in range(len(room.y)):
        for i in range(STATE_SPAN):
            put(room.turning[block], row, i, room.y[block, i])
            put(room.turning[block], row + COLUMNS, i, room.k[0, block, i])


@inlined
def _middle(h, lanes, column, k):
    """A column of a ball's motion in the middle of `h` [s]."""
    before, before_rate = get(lanes, BEFORE + column, k), get(lanes, BEFORE_RATES + column, k)
    return hermite(0.5, h, before, before_rate, get(lanes, NOW + column, k), get(lanes, NOW_RATES + column, k))


@lean_kernel
def _turn_since(h, room):
    """Turns the balls over the `h` [s] since they were turned last, to the start of a step."""
    _note(room, NOW)
    for block in range(len(room.y)):
        lanes = room.turning[block]
        for k in range(LANES):
            spin = (
                _middle(h, lanes, RADIAL_SPIN, k),
                _middle(h, lanes, TANGENTIAL_SPIN, k),
                _middle(h, lanes, AXIAL_SPIN, k),
            )
            middle = spin_in_frame(_middle(h, lanes, AXIS_DISTANCE, k), _middle(h, lanes, TANGENTIAL_VELOCITY, k), spin)
            first, last = lane_spin(lanes, BEFORE, k), lane_spin(lanes, NOW, k)
            put_quaternion(lanes, TURNED_TO, k, turned(get_quaternion(lanes, TURNED_TO, k), first, middle, last, h))
    _note(room, BEFORE)


class ExplicitWork(NamedTuple):
    """What steps are made of: the method, what moves by it, the errors a step may make, and room."""

    method: RungeKutta
    adaptive: bool
    bearing: Bearing
    drive: RingDrive
    scales: np.ndarray
    counts: np.ndarray
    room: LaneRoom


@inlined
def _one_step(run, time, h, begun):
    """A step of all balls from `room.y`; the last slope of the one before is its first where it has `begun`."""
    method, room = run.method, run.room
    stages = len(method.nodes)
    for stage in range(1 if begun else 0, stages + 1):
        moment = time + h
        if stage == stages:
            combine_blocks(room.y, h, method.weights, stages, room.k, room.lanes)
        else:
            moment = time + method.nodes[stage] * h
            if stage > 0:
                combine_blocks(room.y, h, method.a[stage], stage, room.k, room.lanes)
        block_rates(run.bearing, run.drive, room.pairs, moment, room.lanes)
        for block in range(len(room.lanes)):
            for i in range(STATE_SPAN):
                room.k[stage, block, i] = get(room.lanes[block], LANE_RATES, i)
    run.counts[EVALUATIONS] += stages * run.bearing.balls
    # Without an estimate the error is 0: `check_all` finds what is not finite.
    if run.adaptive:
        return _greatest_error(method.error, h, run.bearing.balls, run.scales, room.k, room.errors)
    return 0.0


@inlined
def _whose(run):
    """The ball whose error was the greatest in the last step, or is no number."""
    errors, worst, most = run.room.errors, 0, -1.0
    for ball in range(run.bearing.balls):
        total = get(errors[ball // LANES], MOTION, ball % LANES)
        error = total if total < math.inf else math.inf
        if error > most:
            worst, most = ball, error
    return worst


@inlined
def _move_on(run, fresh):
    room, stages = run.room, len(run.method.nodes)
    if fresh:
        _note(room, BEFORE)
    for block in range(len(room.y)):
        for i in range(STATE_SPAN):
            room.y[block, i] = room.lanes[block, i]
            room.k[0, block, i] = room.k[stages, block, i]
    for block in range(len(room.y)):
        carry_on(run.bearing, room.y[block], AXIS_DISTANCE, room.lanes[block])


@inlined
def _turn(run, seconds, step, steps):
    _turn_since(seconds, run.room)


@inlined
def _keep(run, state, orientation):
    from_blocks(run.room.y, AXIS_DISTANCE, state)
    from_blocks(run.room.turning, TURNED_TO, orientation)


@lean_kernel
def _advance(run, pace, times, duration, state, orientation, results):
    """`explicit_chunk` in the room it has made."""
    return advance_together(
        _one_step, _whose, _move_on, _turn, _keep, check_all,
        run, pace, times, duration, run.bearing.balls, state, orientation, results,
    )  # fmt: skip


@kernel
def explicit_chunk(
    method, bearing, drive, near, times, duration, greatest_step, scales, state, orientation, steps, results
):
    """An explicit Runge-Kutta method, its steps cut so that every instant is the end of one.

    Without an error estimate the steps between two instants are equal, none longer than `greatest_step` [s]; with one
    they adapt, and `steps` (N,) [s] carries their size. Unstable above about 3 / (fastest rate): contact frequency
    [rad/s] or friction rate mu N / (m v_regularisation).
    """
    adaptive, room = np.any(method.error != 0.0), _lane_room(state, orientation, near, len(method.nodes) + 1)
    into_blocks(results.carried, room.lanes, CARRIED_INNER)
    run = ExplicitWork(method, adaptive, bearing, drive, scales, results.counts, room)
    pace = Pace(steps[0] if adaptive else greatest_step, method.order if adaptive else 0, False)
    status, wanted = _advance(run, pace, times, duration, state, orientation, results)
    if status == OK:
        steps[:] = wanted
        from_blocks(room.lanes, CARRIED_INNER, results.carried)
    return status
