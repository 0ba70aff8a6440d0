"""Rosenbrock methods for bodies side by side in lanes: the stages of a step, and the loop of steps.

A body is a block of the linear system. Bodies that nothing couples have a system each: every lane holds one body with
its own time and step size, all lanes take one step together, each accepts or repeats its own, and a lane whose body has
reached the end takes the next one. Bodies that a band of neighbours or a border couples take all their steps together.

As in `runge_kutta` a kind hands over functions, which are compiled into its own kernel. They take its `scene` and, as
an argument of its own, for only then Numba leaves out what no empty one has, its `coupling`: empty for bodies alone.
"""

import math

from bearing_twin.compiled import inlined, template
from bearing_twin.numerics import lanes as at
from bearing_twin.numerics.lanes import (
    COLUMNS,
    LANES,
    STATE_SPAN,
    begins_again,
    get,
    get_vector,
    increase,
    put,
    put_from,
    put_vector,
)
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rosenbrock_inside import mixed_stages
from bearing_twin.numerics.statuses import EVALUATIONS, JACOBIANS, OK, REJECTIONS, STALLED, STEPS, STOPPED
from bearing_twin.numerics.steppers import LEAST_STEP, NOTHING, five, next_step, rates_of_a_step, stays

IDLE = -1  # the body in a lane without one
LANDED = 0.95  # tuned: share of a step: an event later in it is as good as at its end
# Share of the step over which the rates' explicit change with time is taken: at 1e-3 the order fell from 4 to 2.
SLOPE_STEP = 1e-6


@lean_kernel
def _keep_rates(lanes):
    """Keeps the rates for `_take_slope`."""
    for i in range(STATE_SPAN):
        put(lanes, at.SLOPE, i, get(lanes, at.LANE_RATES, i))


@lean_kernel
def _take_slope(lanes):
    for i in range(STATE_SPAN):
        put(lanes, at.SLOPE, i, (get(lanes, at.SLOPE, i) - get(lanes, at.LANE_RATES, i)) / SLOPE_STEP)


@inlined
def _put_right(before, d, lanes, i):
    known = get(lanes, at.LANE_RATES, i) + d * get(lanes, at.SLOPE, i)
    put(lanes, at.RIGHT, i, known + before * get(lanes, at.INVERSE_STEP, i))


@lean_kernel
def _stage_right(stage, c, d, lanes):
    """The right-hand side of a stage from its rates and the stages before it: what is read takes the time."""
    weights = five(c)
    if stage == 0:
        for i in range(STATE_SPAN):
            _put_right(0.0, d, lanes, i)
    elif stage <= 2:
        for i in range(STATE_SPAN):
            before = weights[0] * get(lanes, at.FIRST_STAGE, i) + weights[1] * get(lanes, at.SECOND_STAGE, i)
            _put_right(before, d, lanes, i)
    else:
        for i in range(STATE_SPAN):
            _put_right(mixed_stages(weights, lanes, 0, i), d, lanes, i)


@lean_kernel
def _keep_stage(stage, lanes):
    """Stores the solution as a stage's; one that is not finite as zero, so that it cannot haunt the next attempt."""
    row = at.FIRST_STAGE + stage * COLUMNS
    for i in range(STATE_SPAN):
        value = get(lanes, at.SOLUTION, i)
        put_from(lanes, row, i, value if abs(value) < math.inf else 0.0)


@lean_kernel
def _take_end(lanes):
    """The state at the end of the steps: that of the last stage and its solution."""
    for i in range(STATE_SPAN):
        increase(lanes, at.END, i, get(lanes, at.SOLUTION, i))


@template
def rosenbrock_stages(rates, linearise, solve, scene, coupling, method, varies, blocks):
    """The stages of one step of every lane, from START to END; the last is left in SOLUTION as the error estimate.

    `rates(scene, coupling, stage, alpha, blocks)` puts the states of a stage, `alpha` steps ahead, into END, of the
    first what follows from the steps' sizes too, and fills LANE_RATES; `linearise(scene, coupling, varies, blocks)`
    takes the Jacobian there and factorises; `solve(scene, coupling, stage, blocks)` solves RIGHT to SOLUTION. Where the
    rates vary with time by themselves, a stage -1 lies a little after the start. One that `stays` asks for no rates.
    """
    # One loop, so that the code of the rates is here once.
    for stage in range(-1 if varies else 0, len(method.alpha)):
        if stage < 0 or not stays(method, stage):
            rates(scene, coupling, stage, method.alpha[stage] if stage >= 0 else SLOPE_STEP, blocks)
        if stage < 0:
            for block in range(len(blocks)):
                _keep_rates(blocks[block])
            continue
        if stage == 0:
            if varies:  # times h, as the method wants it
                for block in range(len(blocks)):
                    _take_slope(blocks[block])
            linearise(scene, coupling, varies, blocks)
        for block in range(len(blocks)):
            _stage_right(stage, method.c[stage], method.d[stage], blocks[block])
        solve(scene, coupling, stage, blocks)
        for block in range(len(blocks)):
            _keep_stage(stage, blocks[block])
    for block in range(len(blocks)):
        _take_end(blocks[block])


@inlined
def cut_to_end(wanted, lanes, k):
    """Lets a lane step what it wants [s], or to the end of its stretch, if that comes first."""
    duration = get(lanes, at.DURATION, k)
    left = duration - get(lanes, at.TIME, k)
    put(lanes, at.WANTED, k, wanted)
    put(lanes, at.STEP, k, left if wanted >= left - NOTHING * duration else wanted)


@lean_kernel
def _agree(row, least, bodies, blocks):
    """Gives all coupled bodies the least or the greatest number in a row; one that is none is the greatest."""
    agreed = get(blocks[0], row, 0)
    for place in range(bodies):
        value = get(blocks[place // LANES], row, place % LANES)
        if (value < agreed) if least else value > agreed or value != value:
            agreed = value
    for place in range(len(blocks) * LANES):
        put(blocks[place // LANES], row, place % LANES, agreed)


@inlined
def _put_until(holds, lanes, k):
    """Notes up to where a lane's step may be given out: never where it is repeated, for ever at the stretch's end."""
    accepted = holds and get(lanes, at.ERROR, k) <= 1.0 and get(lanes, at.SHARE, k) >= LANDED
    moment = get(lanes, at.TIME, k) + get(lanes, at.STEP, k)
    # So that at the end no instant is lost to rounding.
    last = math.inf if moment >= get(lanes, at.DURATION, k) * (1.0 - NOTHING) else moment
    put(lanes, at.UNTIL, k, last if accepted else -math.inf)


@inlined
def _begin_time(step, duration, lanes, k):
    put(lanes, at.TIME, k, 0.0)
    put(lanes, at.STEP, k, min(step, duration))
    put(lanes, at.DURATION, k, duration)


@inlined
def _three_on(moved, column, lanes, k):
    """Three columns of a lane's next start: the end of its step, or where the step is repeated its start."""
    end, start = get_vector(lanes, at.END + column, k), get_vector(lanes, at.START + column, k)
    put_vector(lanes, at.START + column, k, end if moved else start)


@lean_kernel
def _move_on(lanes):
    """Takes the ends of accepted steps as the starts of the next, all lanes at once."""
    for k in range(LANES):
        moved = get(lanes, at.UNTIL, k) >= 0.0
        # Written out, as a loop over the columns would be left in the loop over the lanes, which would then gather.
        _three_on(moved, 0, lanes, k)
        _three_on(moved, 3, lanes, k)
        _three_on(moved, 6, lanes, k)
        _three_on(moved, 9, lanes, k)
        time = get(lanes, at.TIME, k)
        put(lanes, at.TIME, k, time + get(lanes, at.STEP, k) if moved else time)


@template
def fill_lanes(begin, scene, coupling, stretches, bodies, steps, held, cursor, blocks):
    """Puts the first of the numbered `bodies` into the lanes by `begin(scene, number, lanes, k)`, which fills START.

    `held` (lanes,) receives their numbers or IDLE, `cursor` the number of the first instant in their `stretches`.
    """
    for place in range(len(held)):
        # A lane without a body repeats the last one's start, as good as any.
        number, lanes, k = bodies[min(place, len(bodies) - 1)], blocks[place // LANES], place % LANES
        begin(scene, number, lanes, k)
        _begin_time(steps[number], stretches.ends[number], lanes, k)
        held[place] = number if place < len(bodies) else IDLE
        cursor[place] = stretches.first[number]
    if len(coupling) > 0:
        _agree(at.STEP, True, len(bodies), blocks)


@template
def _judge(one_step, landing, accept_all, scene, coupling, method, bodies, held, cursor, counts, blocks):
    """Makes a step of every lane and finds what it is worth: its error, its share to the first event, and UNTIL."""
    kept, asked = 1 if begins_again(coupling, blocks) else 0, rates_of_a_step(method)
    one_step(scene, coupling, blocks)
    if len(coupling) > 0:
        _agree(at.ERROR, False, bodies, blocks)
    for place in range(len(held)):
        lanes, k = blocks[place // LANES], place % LANES
        put(lanes, at.SHARE, k, 1.0)
        if held[place] == IDLE:
            continue
        counts[JACOBIANS] += 1 - kept
        counts[EVALUATIONS] += asked - kept
        if method.lands and get(lanes, at.ERROR, k) <= 1.0:
            put(lanes, at.SHARE, k, landing(scene, lanes, k))
    if len(coupling) > 0:
        if method.lands:
            _agree(at.SHARE, True, bodies, blocks)
        if get(blocks[0], at.ERROR, 0) <= 1.0 and get(blocks[0], at.SHARE, 0) >= LANDED:
            accept_all(scene, coupling, cursor[0], blocks)
    for place in range(len(held)):
        _put_until(held[place] != IDLE, blocks[place // LANES], place % LANES)


@template
def advance_lanes(
    cut, one_step, landing, accept_all, give_out, accept, end, begin,
    scene, coupling, method, stretches, bodies, steps, held, cursor, results, blocks,
):  # fmt: skip
    """Steps the `bodies` through `stretches` after `fill_lanes`; returns a status. `steps` (N,) [s] are carried along.

    `cut(scene, coupling, blocks)` cuts the coming steps, to the end at least, and returns the least [s] to go on with;
    `one_step(scene, coupling, blocks)` makes them, with kept rates and Jacobian where it `begins_again`, and fills
    at.ERROR, in tolerances; `landing(scene, lanes, k)` is the share of a step to its first event; `accept_all(scene,
    coupling, instant, blocks)` precedes the moving on of all; `give_out(scene, held, cursor, blocks)` writes what is
    wanted of each lane up to UNTIL [s] and sets its `cursor` to the next instant. `accept(scene, lanes)` follows once
    START moved on where UNTIL >= 0, `end(scene, coupling, number, lanes, k)`, which returns a status, at the end.
    """
    running = waiting = min(len(held), len(bodies))
    proposed, judged, stepped, counts = 0.0, 0.0, 0.0, results.counts
    while running > 0:
        if results.stop[0] != 0:
            return STOPPED
        resume = cut(scene, coupling, blocks)
        _judge(one_step, landing, accept_all, scene, coupling, method, len(bodies), held, cursor, counts, blocks)
        give_out(scene, held, cursor, blocks)
        for block in range(len(blocks)):
            _move_on(blocks[block])
            accept(scene, blocks[block])
        for place in range(len(held)):
            number, lanes, k = held[place], blocks[place // LANES], place % LANES
            if number == IDLE:
                continue
            error, step, share = get(lanes, at.ERROR, k), get(lanes, at.STEP, k), get(lanes, at.SHARE, k)
            if error != judged or step != stepped:  # as nearly never among coupled bodies, whose steps are one
                judged, stepped, proposed = error, step, next_step(step, error, method.order)
            if get(lanes, at.UNTIL, k) < 0.0:
                counts[REJECTIONS] += 1
                again = step * share if error <= 1.0 else proposed
                put(lanes, at.STEP, k, again)
                if again < LEAST_STEP and not error <= 1.0:
                    results.failure[0], results.failure[1] = get(lanes, at.TIME, k), number
                    return STALLED
                continue
            counts[STEPS] += 1
            stretches.taken[number] += 1
            following = max(proposed, resume)
            put(lanes, at.STEP, k, following)
            if get(lanes, at.UNTIL, k) < math.inf:
                continue
            # A step cut short by the end: what it proposes counts only if it is longer.
            steps[number] = max(get(lanes, at.WANTED, k), following)
            status = end(scene, coupling, number, lanes, k)
            if status != OK:
                return status
            number = held[place] = bodies[waiting] if waiting < len(bodies) else IDLE
            if number != IDLE:
                begin(scene, number, lanes, k)
                _begin_time(steps[number], stretches.ends[number], lanes, k)
                cursor[place] = stretches.first[number]
                waiting += 1
            else:
                running -= 1
    return OK
