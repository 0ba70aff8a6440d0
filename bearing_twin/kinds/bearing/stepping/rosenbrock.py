"""The bearing by an adaptive Rosenbrock method: balls side by side in lanes, alone or coupled.

Where the rings' motion is prescribed, balls that touch no other do not act on each other: every lane holds one ball
with its own time and step size, all lanes take one step together, each accepts or repeats its own, and a lane whose
ball has reached the end of the chunk takes the next ball. Balls that may touch, or that meet a ring with mass or a
cage, take all their steps together.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.forces import border_rows as at
from bearing_twin.kinds.bearing.forces.carried import carry_ball
from bearing_twin.kinds.bearing.forces.equations import Bearing, RingDrive
from bearing_twin.kinds.bearing.forces.layout import (
    CARRIED_INNER,
    COLUMNS,
    END,
    ERROR,
    LANES,
    ORIENTATION,
    ROSENBROCK_ROWS,
    SHAFT_ROWS,
    SHARE,
    START,
    STEP,
    TIME,
    TURNED,
    WANTED,
    from_lane,
    get,
    get_quaternion,
    into_lane,
    new_blocks,
    put,
    put_quaternion,
)
from bearing_twin.kinds.bearing.forces.ring_seat import put_still_ring
from bearing_twin.kinds.bearing.stepping.border import bearing_at, follow_cage, put_pockets
from bearing_twin.kinds.bearing.stepping.border_step import border_at, border_inside, copy_state
from bearing_twin.kinds.bearing.stepping.flight import NOTHING, cut_steps
from bearing_twin.kinds.bearing.stepping.lanes import rosenbrock_step
from bearing_twin.kinds.bearing.stepping.pointing import note_error, point_out
from bearing_twin.kinds.bearing.stepping.step_ends import dense_ends, dense_terms
from bearing_twin.kinds.bearing.stepping.steps import (
    LANDED,
    changes_contact,
    check_ball,
    give_out,
    landing,
    new_dense_step,
)
from bearing_twin.kinds.bearing.stepping.walls import meet_walls, note_closing
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.statuses import EVALUATIONS, JACOBIANS, OK, REJECTIONS, STALLED, STEPS, STOPPED
from bearing_twin.numerics.steppers import LEAST_STEP, Rosenbrock, next_step

RUNNING = IDLE = -1  # status of a ball that has not reached the chunk's end; number of the ball in a lane without one


class ChunkTask(NamedTuple):
    """A chunk to integrate: `scales` (MOTION,) are the errors a step may make."""

    method: Rosenbrock
    bearing: Bearing
    drive: RingDrive
    times: np.ndarray
    duration: float
    scales: np.ndarray


@lean_kernel
def _next_ball(number, state, orientation, carried, steps, duration, lanes, k):
    """Puts a ball at the start of the chunk into a lane."""
    into_lane(state[number], lanes, START, k)
    into_lane(carried[number], lanes, CARRIED_INNER, k)
    into_lane(orientation[number], lanes, ORIENTATION, k)
    put(lanes, TIME, k, 0.0)
    put(lanes, STEP, k, min(steps[number], duration))


@inlined
def _accept(task, number, cursor, proposed, state, orientation, steps, results, lanes, k, dense):
    """Moves a lane to the end of its step, giving out the instants in it; returns its status and its next instant.

    `proposed` is its next step [s].
    """
    times, time, step = task.times, get(lanes, TIME, k), get(lanes, STEP, k)
    note_error(results.pointer, number, cursor, lanes, k)
    moment = time + step
    finished = moment >= task.duration * (1.0 - NOTHING)
    until = math.inf if finished else moment  # at the end of the chunk no instant is lost to rounding
    if cursor < len(times) and times[cursor] <= until:
        dense_ends(lanes, k, dense)
        dense_terms(task.method.dense, lanes, k, dense)
        cursor = give_out(times, cursor, until, time, step, number, dense, results)
    for column in range(COLUMNS):
        put(lanes, START + column, k, get(lanes, END + column, k))
    put_quaternion(lanes, ORIENTATION, k, get_quaternion(lanes, TURNED, k))
    put(lanes, TIME, k, moment)
    put(lanes, STEP, k, proposed)
    carry_ball(task.bearing, lanes, START, lanes, k)
    if not finished:
        return RUNNING, cursor
    # A step cut short by the end of the chunk: what it proposes counts only if it is longer.
    steps[number] = max(get(lanes, WANTED, k), proposed)
    from_lane(lanes, START, k, state[number])
    from_lane(lanes, ORIENTATION, k, orientation[number])
    from_lane(lanes, CARRIED_INNER, k, results.carried[number])
    return OK, 0


@lean_kernel
def _checked(bearing, number, state, task, results):
    """Whether the state of a ball at the end of a chunk can be right; `bearing` has its ring where it is then."""
    status = check_ball(bearing, state, number)
    if status != OK:
        results.failure[0], results.failure[1] = task.duration, number
    return status


@lean_kernel
def _accept_border(times, duration, cursor, numbers, lanes, borders):
    """Moves ring and cage to the end of the step, giving out the instants in it, as `_accept` does for a ball."""
    time, step = get(lanes, TIME, 0), get(lanes, STEP, 0)
    until = math.inf if time + step >= duration * (1.0 - NOTHING) else time + step
    while cursor < len(times) and times[cursor] <= until:
        border_inside(numbers, (times[cursor] - time) / step, borders[cursor])
        cursor += 1
    copy_state(numbers, at.FINISH, at.BEGIN)


@inlined
def _accept_coupled(task, coupling, cursor, blocks, results):
    """Moves ring and cage on where all balls will accept the step just made."""
    if len(coupling) > 0:  # noqa: SIM102 - as in `lanes`
        if get(blocks[0], ERROR, 0) <= 1.0 and get(blocks[0], SHARE, 0) >= LANDED:
            _accept_border(task.times, task.duration, cursor, coupling.border.numbers, blocks[0], results.border)
            note_closing(task.bearing.pockets, coupling, blocks)


@lean_kernel
def _begin_border(coupling, task, balls, blocks):
    """Gives the lanes what they need of ring and cage before the first step."""
    for block in range(len(blocks)):
        put_still_ring(task.bearing.ring, task.bearing, blocks[block])
    if len(coupling) > 0:
        put_pockets(task.bearing, balls, blocks)
        follow_cage(coupling.border, at.BEGIN, blocks, START)


@lean_kernel
def _bearing_now(ring, coupling, bearing):
    """The bearing with its ring where the last accepted step left it; `ring` is the bearing's."""
    if len(coupling) > 0:  # noqa: SIM102 - as in `lanes`
        if coupling.border.active:
            return bearing_at(ring, bearing, coupling.border, at.BEGIN)
    return bearing


@lean_kernel
def _end_border(coupling, results):
    """Hands the state of ring and cage at the end of the chunk on."""
    if len(coupling) > 0:
        border_at(coupling.border.numbers, at.BEGIN, results.last_border)


@lean_kernel
def _lane_landing(bearing, weights, lanes, k, dense):
    """Share of a lane's step after which a contact has just begun or ended; 1 where none does."""
    dense_ends(lanes, k, dense)
    if not changes_contact(bearing, dense.start, dense.end):
        return 1.0
    dense_terms(weights, lanes, k, dense)
    return landing(bearing, dense)


@lean_kernel
def _agree(coupling, row, least, balls, blocks):
    """Gives all coupled balls the least or the greatest number in a row; one that is not finite is the greatest."""
    if len(coupling) > 0:
        agreed = get(blocks[0], row, 0)
        for place in range(balls):
            value = get(blocks[place // LANES], row, place % LANES)
            if (value < agreed) if least else not value <= agreed:
                agreed = value
        for place in range(len(blocks) * LANES):
            put(blocks[place // LANES], row, place % LANES, agreed)


@inlined
def _judge(task, coupling, ball, count, dense, results, blocks):
    """What each lane's step is worth: its error stands there, its share to the first landing is found."""
    point_out(coupling, results.pointer, blocks)
    _agree(coupling, ERROR, False, count, blocks)
    for place in range(len(ball)):
        lanes, k = blocks[place // LANES], place % LANES
        put(lanes, SHARE, k, 1.0)
        if ball[place] == IDLE:
            continue
        results.counts[JACOBIANS] += 1
        results.counts[EVALUATIONS] += len(task.method.alpha)
        if task.method.lands and get(lanes, ERROR, k) <= 1.0:
            put(lanes, SHARE, k, _lane_landing(task.bearing, task.method.dense, lanes, k, dense))
    _agree(coupling, SHARE, True, count, blocks)


@kernel
def _blocks_of(coupling, balls):
    """Lanes for balls alone, which take turns in one block, or for all that are coupled."""
    if len(coupling) > 0:
        return new_blocks(balls, SHAFT_ROWS)
    return new_blocks(1, ROSENBROCK_ROWS)


@lean_kernel
def _begin(task, coupling, balls, state, orientation, steps, results, ball, blocks):
    """Puts the first balls into the lanes; returns how many."""
    running = min(len(ball), len(balls))
    for place in range(len(ball)):
        # A lane without a ball repeats the last one's start, as good as any.
        number = balls[min(place, running - 1)]
        lanes, k = blocks[place // LANES], place % LANES
        _next_ball(number, state, orientation, results.carried, steps, task.duration, lanes, k)
        ball[place] = number if place < running else IDLE
    _agree(coupling, STEP, True, running, blocks)
    _begin_border(coupling, task, balls, blocks)
    return running


@lean_kernel
def _advance(task, coupling, balls, state, orientation, steps, results, ball, cursor, dense, blocks):
    """`rosenbrock_chunk` in the room it has made."""
    method, counts = task.method, results.counts
    running = waiting = _begin(task, coupling, balls, state, orientation, steps, results, ball, blocks)
    proposed = judged = stepped = 0.0
    while running > 0:
        if results.stop[0] != 0:
            return STOPPED
        cut_steps(task.bearing, task.duration, len(coupling) == 0, blocks)
        resume = meet_walls(task.bearing.pockets, task.bearing, coupling, task.scales, blocks)
        rosenbrock_step(coupling, task.bearing, task.drive, method, task.scales, blocks)
        _judge(task, coupling, ball, len(balls), dense, results, blocks)
        _accept_coupled(task, coupling, cursor[0], blocks, results)
        for place in range(len(ball)):
            number, lanes, k = ball[place], blocks[place // LANES], place % LANES
            if number == IDLE:
                continue
            error, step, share = get(lanes, ERROR, k), get(lanes, STEP, k), get(lanes, SHARE, k)
            if error != judged or step != stepped:  # as nearly never among coupled balls, whose steps are one
                judged, stepped, proposed = error, step, next_step(step, error, method.order)
            if not error <= 1.0:
                counts[REJECTIONS] += 1
                put(lanes, STEP, k, proposed)
                if proposed < LEAST_STEP:
                    results.failure[0], results.failure[1] = get(lanes, TIME, k), number
                    return STALLED
                continue
            if share < LANDED:
                counts[REJECTIONS] += 1
                put(lanes, STEP, k, step * share)
                continue
            counts[STEPS] += 1
            then = max(proposed, resume)
            given = _accept(task, number, cursor[place], then, state, orientation, steps, results, lanes, k, dense)
            status, cursor[place] = given
            if status == RUNNING:
                continue
            status = _checked(_bearing_now(task.bearing.ring, coupling, task.bearing), number, state, task, results)
            if status != OK:
                return status
            if waiting < len(balls):
                ball[place] = balls[waiting]
                waiting += 1
                _next_ball(ball[place], state, orientation, results.carried, steps, task.duration, lanes, k)
            else:
                ball[place] = IDLE
                running -= 1
    _end_border(coupling, results)
    return OK


@kernel
def rosenbrock_chunk(task, coupling, balls, state, orientation, steps, results):
    """Advances the balls numbered in `balls` over the chunk; `steps` (N,) [s] are the step sizes carried along.

    `coupling` is empty for balls alone, else a `linear_system.Coupling`.
    """
    blocks, dense = _blocks_of(coupling, len(balls)), new_dense_step()
    ball = np.full(LANES * len(blocks), IDLE)
    return _advance(task, coupling, balls, state, orientation, steps, results, ball, np.zeros_like(ball), dense, blocks)
