"""Balls that touch no other ball, by an adaptive Rosenbrock method: side by side in lanes, each with its own steps.

The rings' motion is prescribed, so such balls do not act on each other. Every lane holds one ball with its own time and
step size; all lanes take one step together, each accepts or repeats its own, and a lane whose ball has reached the end
of the chunk takes the next ball.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.equations import Bearing, RingDrive
from bearing_twin.kinds.bearing.lanes import dense_ends, dense_terms, rosenbrock_step, turn_lanes
from bearing_twin.kinds.bearing.layout import (
    COLUMNS,
    END,
    ERROR,
    LANES,
    ORIENTATION,
    ROSENBROCK_ROWS,
    START,
    STEP,
    TIME,
    TURNED,
    WANTED,
    from_lane,
    get,
    get_quaternion,
    into_lane,
    new_lanes,
    put,
    put_quaternion,
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
    give_out,
    landing,
    new_dense_step,
)
from bearing_twin.numerics.steppers import Rosenbrock, next_step

RUNNING = -1  # status of a ball that has not reached the end of the chunk
IDLE = -1  # number of the ball in a lane without one
NOTHING = 1e-12  # share of a chunk that is too short for a step


class ChunkTask(NamedTuple):
    """A chunk to integrate: `scales` (MOTION,) are the errors a step may make, `nudges` the Jacobian's increments."""

    method: Rosenbrock
    bearing: Bearing
    drive: RingDrive
    near: np.ndarray
    times: np.ndarray
    duration: float
    scales: np.ndarray
    nudges: np.ndarray


@kernel
def _next_ball(number, state, orientation, steps, duration, lanes, k):
    """Puts a ball at the start of the chunk into a lane."""
    into_lane(state[number], lanes, START, k)
    into_lane(orientation[number], lanes, ORIENTATION, k)
    put(lanes, TIME, k, 0.0)
    put(lanes, STEP, k, min(steps[number], duration))


@kernel
def _cut_steps(duration, lanes):
    """Lets no lane step over the end of the chunk; what it would have stepped is kept as WANTED."""
    for k in range(LANES):
        wanted, left = get(lanes, STEP, k), duration - get(lanes, TIME, k)
        put(lanes, WANTED, k, wanted)
        put(lanes, STEP, k, left if wanted >= left - NOTHING * duration else wanted)


@inlined
def _accept(task, number, cursor, state, orientation, steps, results, lanes, k, dense):
    """Moves a lane to the end of its step, giving out the instants in it; returns its status and its next instant."""
    times, time, step = task.times, get(lanes, TIME, k), get(lanes, STEP, k)
    moment = time + step
    finished = moment >= task.duration * (1.0 - NOTHING)
    until = math.inf if finished else moment  # at the end of the chunk no instant is lost to rounding
    if cursor < len(times) and times[cursor] <= until:
        dense_ends(lanes, k, dense)
        dense_terms(task.method.dense, lanes, k, dense)
        cursor = give_out(times, cursor, until, time, step, number, dense, results)
    proposed = next_step(step, get(lanes, ERROR, k), task.method.order)
    for column in range(COLUMNS):
        put(lanes, START + column, k, get(lanes, END + column, k))
    put_quaternion(lanes, ORIENTATION, k, get_quaternion(lanes, TURNED, k))
    put(lanes, TIME, k, moment)
    put(lanes, STEP, k, proposed)
    if not finished:
        return RUNNING, cursor
    # A step cut short by the end of the chunk: what it proposes counts only if it is longer.
    steps[number] = max(get(lanes, WANTED, k), proposed)
    from_lane(lanes, START, k, state[number])
    from_lane(lanes, ORIENTATION, k, orientation[number])
    status = check_ball(task.bearing, state, number)
    if status != OK:
        results.failure[0], results.failure[1] = task.duration, number
    return status, 0


@kernel
def _lane_landing(bearing, weights, lanes, k, dense):
    """Share of a lane's step after which a contact has just begun or ended; 1 where none does."""
    dense_ends(lanes, k, dense)
    if not changes_contact(bearing, dense.start, dense.end):
        return 1.0
    dense_terms(weights, lanes, k, dense)
    return landing(bearing, dense)


@kernel
def lone_chunk(task, balls, state, orientation, steps, results):
    """Advances the balls numbered in `balls` over the chunk; `steps` (N,) [s] are the step sizes carried along."""
    method, counts = task.method, results.counts
    lanes, dense = new_lanes(ROSENBROCK_ROWS), new_dense_step()
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
            error, step = get(lanes, ERROR, k), get(lanes, STEP, k)
            if not error <= 1.0:
                counts[REJECTIONS] += 1
                shorter = next_step(step, error, method.order)
                put(lanes, STEP, k, shorter)
                if shorter < LEAST_STEP:
                    results.failure[0], results.failure[1] = get(lanes, TIME, k), number
                    return STALLED
                continue
            if method.lands:
                share = _lane_landing(task.bearing, method.dense, lanes, k, dense)
                if share < LANDED:
                    counts[REJECTIONS] += 1
                    put(lanes, STEP, k, step * share)
                    continue
            counts[STEPS] += 1
            status, cursor[k] = _accept(task, number, cursor[k], state, orientation, steps, results, lanes, k, dense)
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
