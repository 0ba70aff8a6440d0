"""Balls that touch no other ball, by an adaptive Rosenbrock method: side by side in lanes, each with its own steps.

The rings' motion is prescribed, so such balls do not act on each other. Every lane holds one ball with its own time and
step size; all lanes take one step together, each accepts or repeats its own, and a lane whose ball has reached the end
of the chunk takes the next ball.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.equations import COLUMNS, LANES, Bearing, Drive, from_lane, into_lane
from bearing_twin.kinds.bearing.lanes import (
    ALL_ROWS,
    END,
    ERROR,
    ORIENTATION,
    START,
    STEP,
    TIME,
    TURNED,
    WANTED,
    interpolate_lane,
    rosenbrock_step,
    turn_lanes,
)
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
from bearing_twin.numerics.steppers import Rosenbrock, next_step

RUNNING = -1  # status of a ball that has not reached the end of the chunk
IDLE = -1  # number of the ball in a lane without one
NOTHING = 1e-12  # share of a chunk that is too short for a step


class Task(NamedTuple):
    """A chunk to integrate: `scales` (MOTION,) are the errors a step may make, `nudges` the Jacobian's increments."""

    method: Rosenbrock
    bearing: Bearing
    drive: Drive
    near: np.ndarray
    times: np.ndarray
    duration: float
    scales: np.ndarray
    nudges: np.ndarray


@kernel
def _give_out(dense, times, cursor, until, lanes, k, states, orientations, ball, rows):
    """Writes the instants inside the step just accepted, from its interpolant; returns the next instant to serve."""
    time, h = lanes[TIME * LANES + k], lanes[STEP * LANES + k]
    while cursor < len(times) and times[cursor] <= until:
        fraction = (times[cursor] - time) / h
        row = states[cursor, ball]
        from_lane(lanes[START * LANES :], k, rows[0])
        from_lane(lanes[ORIENTATION * LANES :], k, rows[2, :4])
        interpolate_lane(dense, fraction, lanes, k, row)
        interpolate_lane(dense, 0.5 * fraction, lanes, k, rows[1])
        turn(rows[2], rows[0], rows[1], row, fraction * h, orientations[cursor, ball])
        cursor += 1
    return cursor


@kernel
def _next_ball(number, state, orientation, steps, duration, lanes, k):
    """Puts a ball at the start of the chunk into a lane."""
    into_lane(state[number], lanes[START * LANES :], k)
    into_lane(orientation[number], lanes[ORIENTATION * LANES :], k)
    lanes[TIME * LANES + k] = 0.0
    lanes[STEP * LANES + k] = min(steps[number], duration)


@kernel
def _cut_steps(duration, lanes):
    """Lets no lane step over the end of the chunk; what it would have stepped is kept as WANTED."""
    for k in range(LANES):
        wanted, left = lanes[STEP * LANES + k], duration - lanes[TIME * LANES + k]
        lanes[WANTED * LANES + k] = wanted
        lanes[STEP * LANES + k] = left if wanted >= left - NOTHING * duration else wanted


@inlined
def _accept(task, number, cursor, state, orientation, steps, results, lanes, k, rows):
    """Moves a lane to the end of its step, giving out the instants in it; returns its status and its next instant."""
    times, step = task.times, lanes[STEP * LANES + k]
    moment = lanes[TIME * LANES + k] + step
    finished = moment >= task.duration * (1.0 - NOTHING)
    until = math.inf if finished else moment  # at the end of the chunk no instant is lost to rounding
    if cursor < len(times) and times[cursor] <= until:
        dense, states, orientations = task.method.dense, results.states, results.orientations
        cursor = _give_out(dense, times, cursor, until, lanes, k, states, orientations, number, rows)
    proposed = next_step(step, lanes[ERROR * LANES + k], task.method.order)
    for row in range(COLUMNS):
        lanes[(START + row) * LANES + k] = lanes[(END + row) * LANES + k]
    for part in range(4):
        lanes[(ORIENTATION + part) * LANES + k] = lanes[(TURNED + part) * LANES + k]
    lanes[TIME * LANES + k], lanes[STEP * LANES + k] = moment, proposed
    if not finished:
        return RUNNING, cursor
    # A step cut short by the end of the chunk: what it proposes counts only if it is longer.
    steps[number] = max(lanes[WANTED * LANES + k], proposed)
    from_lane(lanes[START * LANES :], k, state[number])
    from_lane(lanes[ORIENTATION * LANES :], k, orientation[number])
    status = check_ball(task.bearing, state, number)
    if status != OK:
        results.failure[0], results.failure[1] = task.duration, number
    return status, 0


@kernel
def _landing(bearing, dense, lanes, k, rows):
    """Share of a lane's step after which a contact has just begun or ended; 1 where none does."""
    from_lane(lanes[START * LANES :], k, rows[0])
    from_lane(lanes[END * LANES :], k, rows[1])
    if not changes_contact(bearing, rows[0], rows[1]):
        return 1.0
    low, high = 0.0, 1.0
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        interpolate_lane(dense, middle, lanes, k, rows[1])
        if changes_contact(bearing, rows[0], rows[1]):
            high = middle
        else:
            low = middle
    return high


@kernel
def lone_chunk(task, balls, state, orientation, steps, results):
    """Advances the balls numbered in `balls` over the chunk; `steps` (N,) [s] are the step sizes carried along."""
    method, counts = task.method, results.counts
    lanes, rows = np.zeros(ALL_ROWS * LANES), np.zeros((3, COLUMNS))
    ball, cursor = np.full(LANES, IDLE), np.zeros(LANES, np.int64)
    running = min(LANES, len(balls))
    waiting = running
    for k in range(LANES):
        # A lane without a ball repeats the last one's start, as good as any.
        number = balls[min(k, running - 1)]
        _next_ball(number, state, orientation, steps, task.duration, lanes, k)
        ball[k] = number if k < running else IDLE
    while running > 0:
        _cut_steps(task.duration, lanes)
        rosenbrock_step(task.bearing, task.drive, method, task.scales, lanes)
        turn_lanes(method.dense, lanes)
        for k in range(LANES):
            number = ball[k]
            if number == IDLE:
                continue
            counts[JACOBIANS] += 1
            counts[RATES] += len(method.alpha)
            if not lanes[ERROR * LANES + k] <= 1.0:
                counts[REJECTIONS] += 1
                shorter = next_step(lanes[STEP * LANES + k], lanes[ERROR * LANES + k], method.order)
                lanes[STEP * LANES + k] = shorter
                if shorter < LEAST_STEP:
                    results.failure[0], results.failure[1] = lanes[TIME * LANES + k], number
                    return STALLED
                continue
            if method.lands:
                share = _landing(task.bearing, method.dense, lanes, k, rows)
                if share < LANDED:
                    counts[REJECTIONS] += 1
                    lanes[STEP * LANES + k] *= share
                    continue
            counts[STEPS] += 1
            status, cursor[k] = _accept(task, number, cursor[k], state, orientation, steps, results, lanes, k, rows)
            if status == RUNNING:
                continue
            if status != OK:
                return status
            if waiting < len(balls):
                ball[k] = balls[waiting]
                waiting += 1
                _next_ball(ball[k], state, orientation, steps, task.duration, lanes, k)
            else:
                ball[k] = IDLE
                running -= 1
    return OK
