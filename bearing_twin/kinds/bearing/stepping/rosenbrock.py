"""The bearing by an adaptive Rosenbrock method: what begins, cuts, accepts and ends the steps of `numerics.rosenbrock`.

Where the rings' motion is prescribed, balls that touch no other do not act on each other, and each has its own steps.
Balls that may touch, or that meet a ring with mass or a cage, take all their steps together.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.elasticity import carries
from bearing_twin.kinds.bearing.forces import border_rows as at
from bearing_twin.kinds.bearing.forces.carried import carry_ball
from bearing_twin.kinds.bearing.forces.equations import Bearing, RingDrive
from bearing_twin.kinds.bearing.forces.handing import handed, taken
from bearing_twin.kinds.bearing.forces.layout import CARRIED_INNER, COUPLED_ROWS, ORIENTATION, ROSENBROCK_ROWS, TURNED
from bearing_twin.kinds.bearing.forces.ring_seat import put_still_ring
from bearing_twin.kinds.bearing.stepping.border import Partners, bearing_at, follow_cage, put_pockets
from bearing_twin.kinds.bearing.stepping.border_step import border_at, border_inside, copy_state
from bearing_twin.kinds.bearing.stepping.flight import cut_steps
from bearing_twin.kinds.bearing.stepping.instants import give_out
from bearing_twin.kinds.bearing.stepping.lanes import rosenbrock_step
from bearing_twin.kinds.bearing.stepping.linear_system import new_coupling
from bearing_twin.kinds.bearing.stepping.step_ends import dense_ends
from bearing_twin.kinds.bearing.stepping.steps import (
    DenseStep,
    Results,
    changes_contact,
    check_ball,
    landing,
    new_dense_step,
)
from bearing_twin.kinds.bearing.stepping.walls import meet_walls, note_closing
from bearing_twin.numerics.lanes import (
    DURATION,
    LANES,
    START,
    STEP,
    TIME,
    UNTIL,
    from_lane,
    get,
    get_quaternion,
    into_lane,
    new_blocks,
    put_quaternion,
)
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rosenbrock import IDLE, advance_lanes, fill_lanes
from bearing_twin.numerics.rosenbrock_inside import dense_terms
from bearing_twin.numerics.statuses import OK
from bearing_twin.numerics.steppers import NOTHING, Rosenbrock
from bearing_twin.numerics.stretches import Stretches, alike


class ChunkTask(NamedTuple):
    """A chunk to integrate: `scales` (MOTION,) are the errors a step may make."""

    method: Rosenbrock
    bearing: Bearing
    drive: RingDrive
    times: np.ndarray
    duration: float
    scales: np.ndarray


class ChunkWork(NamedTuple):
    """What a chunk is integrated with: the task, the balls' stretches, states and orientations, results, and room."""

    task: ChunkTask
    stretches: Stretches
    state: np.ndarray
    orientation: np.ndarray
    results: Results
    dense: DenseStep


@lean_kernel
def _next_ball(number, state, orientation, carried, lanes, k):
    """Puts a ball at the start of the chunk into a lane."""
    into_lane(state[number], lanes, START, k)
    into_lane(carried[number], lanes, CARRIED_INNER, k)
    into_lane(orientation[number], lanes, ORIENTATION, k)


@inlined
def _begin(run, number, lanes, k):
    _next_ball(number, run.state, run.orientation, run.results.carried, lanes, k)


@inlined
def _cut(run, coupling, blocks):
    """Cuts the coming steps; returns the least to go on with [s]."""
    task = run.task
    cut_steps(task.bearing, coupling, blocks)
    return meet_walls(task.bearing.pockets, task.bearing, coupling, task.scales, blocks)


@inlined
def _one_step(run, coupling, blocks):
    rosenbrock_step(run.task, coupling, blocks)


@lean_kernel
def _lane_landing(bearing, weights, lanes, k, dense):
    """Share of a lane's step after which a contact has just begun or ended; 1 where none does."""
    dense_ends(lanes, k, dense)
    if not changes_contact(bearing, dense.start, dense.end):
        return 1.0
    dense_terms(weights, lanes, k, dense)
    return landing(bearing, dense)


@inlined
def _landing(run, lanes, k):
    return _lane_landing(run.task.bearing, run.task.method.dense, lanes, k, run.dense)


@inlined
def _give_out(run, held, cursor, blocks):
    """Gives out the instants in accepted steps."""
    task, results, first = run.task, run.results, 0
    for block in range(len(blocks)):
        where = results.states, results.orientations
        give_out(task.times, run.stretches.after, task.method.dense, held, cursor, first, blocks[block], *where)
        first += LANES


@lean_kernel
def _turn_on(lanes):
    """Takes the orientations after accepted steps as those before the next."""
    for k in range(LANES):
        turned, before = get_quaternion(lanes, TURNED, k), get_quaternion(lanes, ORIENTATION, k)
        put_quaternion(lanes, ORIENTATION, k, turned if get(lanes, UNTIL, k) >= 0.0 else before)


@inlined
def _accept(run, lanes):
    _turn_on(lanes)
    if carries(run.task.bearing.inner.law):
        for k in range(LANES):
            if get(lanes, UNTIL, k) >= 0.0:
                carry_ball(run.task.bearing, lanes, START, lanes, k)


@lean_kernel
def _checked(bearing, number, state, duration, failure):
    """Whether the state of a ball at its end [s] can be right; `bearing` has its ring where it is then."""
    status = check_ball(bearing, state, number)
    if status != OK:
        failure[0], failure[1] = duration, number
    return status


@inlined
def _end(run, coupling, number, lanes, k):
    """Takes a ball out of its lane at the end of the chunk; returns whether its state can be right."""
    bearing, results = run.task.bearing, run.results
    from_lane(lanes, START, k, run.state[number])
    from_lane(lanes, ORIENTATION, k, run.orientation[number])
    from_lane(lanes, CARRIED_INNER, k, results.carried[number])
    now = _bearing_now(bearing.ring, coupling, bearing)
    return _checked(now, number, run.state, get(lanes, DURATION, k), results.failure)


@lean_kernel
def _accept_border(times, duration, cursor, numbers, lanes, borders):
    """Moves ring and cage to the end of the step, giving out the instants in it."""
    time, step = get(lanes, TIME, 0), get(lanes, STEP, 0)
    until = math.inf if time + step >= duration * (1.0 - NOTHING) else time + step
    while cursor < len(times) and times[cursor] <= until:
        border_inside(numbers, (times[cursor] - time) / step, borders[cursor])
        cursor += 1
    copy_state(numbers, at.FINISH, at.BEGIN)


@inlined
def _accept_all(run, coupling, cursor, blocks):
    """Moves ring and cage on where all balls will accept the step just made."""
    task = run.task
    if len(coupling) > 0:
        _accept_border(task.times, task.duration, cursor, coupling.border.numbers, blocks[0], run.results.border)
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


@kernel
def _blocks_of(coupling, balls):
    """Lanes for balls alone, which take turns in one block, or for all that are coupled."""
    if len(coupling) > 0:
        return new_blocks(balls, COUPLED_ROWS)
    return new_blocks(1, ROSENBROCK_ROWS)


@lean_kernel
def _advance(task, stretches, coupling, balls, state, orientation, steps, results, held, cursor, dense, blocks):
    """`rosenbrock_chunk` in the room it has made."""
    run, method = ChunkWork(task, stretches, state, orientation, results, dense), task.method
    fill_lanes(_begin, run, coupling, stretches, balls, steps, held, cursor, blocks)
    _begin_border(coupling, task, balls, blocks)
    status = advance_lanes(
        _cut, _one_step, _landing, _accept_all, _give_out, _accept, _end, _begin,
        run, coupling, method, stretches, balls, steps, held, cursor, results, blocks,
    )  # fmt: skip
    if status == OK:
        _end_border(coupling, results)
    return status


@inlined
def _through(task, own, coupling, balls, state, orientation, steps, results):
    """`rosenbrock_chunk` of balls and what couples them, in room that is made here."""
    blocks, dense = _blocks_of(coupling, len(balls)), new_dense_step()
    held, filled, stretches = np.full(LANES * len(blocks), IDLE), Results(*results), Stretches(*own)
    cursor = np.zeros_like(held)
    return _advance(task, stretches, coupling, balls, state, orientation, steps, filled, held, cursor, dense, blocks)


@kernel
def _alone(bearing, drive, method, times, duration, scales, own, balls, state, orientation, steps, results):
    """`rosenbrock_chunk` of balls alone, of what is handed over without names."""
    task = ChunkTask(Rosenbrock(*method), taken(bearing), RingDrive(*drive), times, duration, scales)
    return _through(task, own, (), balls, state, orientation, steps, results)


@kernel
def _together(
    bearing, drive, method, times, duration, scales, own, near, partners, balls, state, orientation, steps, results
):
    """`rosenbrock_chunk` of balls that are coupled: what couples them is made here, and Python never sees it."""
    task = ChunkTask(Rosenbrock(*method), taken(bearing), RingDrive(*drive), times, duration, scales)
    coupling = new_coupling(near, balls, Partners(*partners), Results(*results).last_border)
    return _through(task, own, coupling, balls, state, orientation, steps, results)


def rosenbrock_chunk(
    task: ChunkTask, coupled: tuple, balls, state, orientation, steps, results: Results, own: Stretches | None = None
) -> int:
    """Advances the balls numbered in `balls` over the chunk; `steps` (N,) [s] are the step sizes carried along.

    `coupled` is empty for balls alone, else says which may meet the next (N,), and the partners. Balls alone may have
    stretches of their `own`, within the chunk's instants. Returns a status.
    """
    bearing, drive, method = handed(task.bearing), tuple(task.drive), tuple(task.method)
    own = own or alike(len(state), task.duration, len(task.times))
    what = bearing, drive, method, task.times, task.duration, task.scales, tuple(own)
    moving = balls, state, orientation, steps, tuple(results)
    if coupled:
        near, partners = coupled
        return _together(*what, near, tuple(partners), *moving)
    return _alone(*what, *moving)
