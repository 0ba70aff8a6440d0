"""The driver of Rosenbrock methods by a toy: one number a body, drawn to a cosine, or, coupled, heat in a rod."""

import math
from collections import namedtuple

import numpy as np
import pytest
from scipy.linalg import expm

from bearing_twin.compiled import inlined, kernel
from bearing_twin.numerics.lanes import (
    AFTER_METHOD,
    COLUMNS,
    END,
    ERROR,
    GAIN,
    INVERSE_STEP,
    LANE_RATES,
    LANES,
    RIGHT,
    SOLUTION,
    START,
    STEP,
    TIME,
    UNTIL,
    get,
    new_blocks,
    put,
)
from bearing_twin.numerics.rosenbrock import (
    IDLE,
    _agree,
    advance_lanes,
    cut_to_end,
    fill_lanes,
    rosenbrock_stages,
)
from bearing_twin.numerics.rosenbrock_inside import inside, mixed_stages, take_terms
from bearing_twin.numerics.statuses import JACOBIANS, NOT_FINITE, OK, REJECTIONS, STALLED, STEPS, STOPPED
from bearing_twin.numerics.steppers import RODAS4, ROSENBROCK, five
from bearing_twin.numerics.stretches import Stretches, alike

DURATION, TIMES = 2.0, np.linspace(0.1, 2.0, 20)
STIFFNESS = COLUMNS  # the row of a body's own, the first after its state
Toy = namedtuple("Toy", ["method", "stiffness", "begin", "tolerance", "event", "out", "last", "ends", "wrong", "after"])
Results = namedtuple("Results", ["counts", "failure", "stop"])
Rod = namedtuple("Rod", ["bodies", "room", "accepted"])


@inlined
def rates(toy, coupling, stage, alpha, blocks):
    for block in range(len(blocks)):
        lanes = blocks[block]
        for k in range(LANES):
            value, step = get(lanes, START, k), get(lanes, STEP, k)
            if stage > 0:
                value += mixed_stages(five(toy.method.a[stage]), lanes, 0, k)
                put(lanes, END, k, value)
            else:
                put(lanes, GAIN, k, toy.method.gamma * step)
                for column in range(COLUMNS):
                    put(lanes, INVERSE_STEP + column, k, 1.0 / step)
            put(lanes, 0, k, value)
            time = get(lanes, TIME, k) + alpha * step
            put(lanes, LANE_RATES, k, get(lanes, STIFFNESS, k) * (math.cos(time) - value) - math.sin(time))
    add_neighbours(coupling, blocks)


@inlined
def add_neighbours(coupling, blocks):
    if len(coupling) > 0:
        for place in range(coupling.bodies):
            here, k = blocks[place // LANES], place % LANES
            rate = -2.0 * get(here, 0, k)
            if place > 0:
                rate += get(blocks[(place - 1) // LANES], 0, (place - 1) % LANES)
            if place + 1 < coupling.bodies:
                rate += get(blocks[(place + 1) // LANES], 0, (place + 1) % LANES)
            put(here, LANE_RATES, k, get(here, STIFFNESS, k) * rate)


@inlined
def linearise(toy, coupling, varies, blocks):
    """The Jacobian is known."""


@inlined
def solve(toy, coupling, stage, blocks):
    solve_rod(coupling, blocks)
    if len(coupling) == 0:
        for k in range(LANES):
            diagonal = 1.0 / get(blocks[0], GAIN, k) + get(blocks[0], STIFFNESS, k)
            put(blocks[0], SOLUTION, k, get(blocks[0], RIGHT, k) / diagonal)


@inlined
def solve_rod(coupling, blocks):
    """Along the rod and back, all of one stiffness."""
    if len(coupling) > 0:
        stiffness, room = get(blocks[0], STIFFNESS, 0), coupling.room
        diagonal, before = 1.0 / get(blocks[0], GAIN, 0) + 2.0 * stiffness, 0.0
        for place in range(coupling.bodies):
            pivot = diagonal - stiffness * before
            room[0, place] = before = stiffness / pivot
            push = stiffness * room[1, place - 1] if place > 0 else 0.0
            room[1, place] = (get(blocks[place // LANES], RIGHT, place % LANES) + push) / pivot
        ahead = 0.0
        for place in range(coupling.bodies - 1, -1, -1):
            ahead = room[1, place] + room[0, place] * ahead
            put(blocks[place // LANES], SOLUTION, place % LANES, ahead)


@inlined
def cut(toy, coupling, blocks):
    for block in range(len(blocks)):
        for k in range(LANES):
            cut_to_end(get(blocks[block], STEP, k), blocks[block], k)
    return 0.0


@inlined
def one_step(toy, coupling, blocks):
    rosenbrock_stages(rates, linearise, solve, toy, coupling, toy.method, len(coupling) == 0, blocks)
    for block in range(len(blocks)):
        for k in range(LANES):
            put(blocks[block], ERROR, k, abs(get(blocks[block], SOLUTION, k)) / toy.tolerance)


@inlined
def landing(toy, lanes, k):
    share = (toy.event - get(lanes, TIME, k)) / get(lanes, STEP, k)
    return share if 1e-9 < share < 1.0 else 1.0


@inlined
def accept_all(toy, coupling, instant, blocks):
    if len(coupling) > 0:
        coupling.accepted[0] += 1


@inlined
def give_out(toy, held, cursor, blocks):
    for block in range(len(blocks)):
        take_terms(toy.method.dense, blocks[block])
    for place in range(len(held)):
        lanes, k = blocks[place // LANES], place % LANES
        while cursor[place] < toy.after[held[place]] and TIMES[cursor[place]] <= get(lanes, UNTIL, k):
            share = (TIMES[cursor[place]] - get(lanes, TIME, k)) / get(lanes, STEP, k)
            toy.out[held[place], cursor[place]] = inside(share, lanes, 0, k)
            cursor[place] += 1


@inlined
def accept(toy, lanes):
    for k in range(LANES):
        if get(lanes, UNTIL, k) >= 0.0 and abs(get(lanes, TIME, k) - toy.event) < 1e-12:
            toy.ends[0] += 1


@inlined
def end(toy, coupling, number, lanes, k):
    toy.last[number] = get(lanes, START, k)
    return NOT_FINITE if number == toy.wrong else OK


@inlined
def begin(toy, number, lanes, k):
    put(lanes, START, k, toy.begin[number])
    put(lanes, STIFFNESS, k, toy.stiffness[number])


@kernel
def advanced(toy, coupling, stretches, bodies, steps, held, cursor, results, blocks):
    fill_lanes(begin, toy, coupling, stretches, bodies, steps, held, cursor, blocks)
    return advance_lanes(
        cut, one_step, landing, accept_all, give_out, accept, end, begin,
        toy, coupling, toy.method, stretches, bodies, steps, held, cursor, results, blocks,
    )  # fmt: skip


def run_of(
    stiffness, start, coupled=False, method=RODAS4, tolerance=1e-8, event=9.0, bodies=None, wrong=-1, stop=0, own=None
):
    count = len(stiffness)
    own = own or alike(count, DURATION, len(TIMES))
    out = np.full((count, len(TIMES)), np.nan)
    ends = np.zeros(1, np.int64)
    begun = np.array(stiffness), np.array(start)
    toy = Toy(method, *begun, tolerance, event, out, np.zeros(count), ends, wrong, own.after)
    coupling = Rod(count, np.zeros((2, count)), np.zeros(1, np.int64)) if coupled else ()
    blocks = new_blocks(count if coupled else 1, AFTER_METHOD)
    held = np.full(LANES * len(blocks), IDLE)
    results = Results(np.zeros(4, np.int64), np.zeros(2), np.array([stop]))
    numbers, steps = np.arange(count) if bodies is None else np.array(bodies), np.full(count, 1e-4)
    status = advanced(toy, coupling, own, numbers, steps, held, np.zeros_like(held), results, blocks)
    return status, toy, coupling, steps, results


STIFF = tuple(np.geomspace(1.0, 1e3, 11))
ONES = (1.0,) * len(STIFF)


def test_bodies_alone_take_turns_in_the_lanes_each_with_its_own_step():
    status, toy, _, steps, results = run_of(STIFF, ONES)
    assert status == OK
    assert np.abs(toy.last - math.cos(DURATION)).max() < 1e-5
    assert np.abs(toy.out - np.cos(TIMES)).max() < 1e-5
    assert len(set(steps)) == len(STIFF)
    assert results.counts[JACOBIANS] == results.counts[STEPS] + results.counts[REJECTIONS]
    turned = run_of(STIFF, ONES, bodies=range(len(STIFF) - 1, -1, -1))
    assert (turned[1].out == toy.out).all()
    assert (turned[4].counts == results.counts).all()


def test_bodies_alone_may_have_instants_and_ends_of_their_own():
    """Each the same, to the bit and by as many steps, as if all had its own: those of others do not matter."""
    ends = np.resize([0.25, 2.0, 0.7, 1.1], len(STIFF))
    first = np.resize([0, 3, 1], len(STIFF))
    after = np.minimum(np.searchsorted(TIMES, ends, side="right"), 18)
    given = Stretches(ends, first, after, np.zeros(len(STIFF), np.int64))
    status, toy, _, steps, results = run_of(STIFF, ONES, own=given)
    assert status == OK
    assert given.taken.sum() == results.counts[STEPS]
    assert np.abs(toy.last - np.cos(ends)).max() < 1e-5
    for body, stiffness in enumerate(STIFF):
        alone = alike(1, ends[body], after[body])
        _, single, _, step, _ = run_of((stiffness,), (1.0,), own=alone)
        assert (single.out[0, first[body] : after[body]] == toy.out[body, first[body] : after[body]]).all()
        assert np.isnan(toy.out[body, : first[body]]).all()
        assert np.isnan(toy.out[body, after[body] :]).all()
        assert (single.last[0], step[0], alone.taken[0]) == (toy.last[body], steps[body], given.taken[body])


def test_a_tighter_tolerance_errs_less():
    wide, tight = (run_of(STIFF, (2.0,) * 11, tolerance=one)[1] for one in (1e-4, 1e-8))
    true = np.cos(DURATION) + np.exp(-np.array(STIFF) * DURATION)
    assert 0.0 < np.abs(tight.last - true).max() < 0.01 * np.abs(wide.last - true).max()


def test_coupled_bodies_take_their_steps_together():
    count = 11
    start = np.sin(np.arange(1, count + 1))
    status, toy, rod, steps, results = run_of((50.0,) * count, start, coupled=True, tolerance=1e-8)
    matrix = 50.0 * (np.eye(count, k=1) + np.eye(count, k=-1) - 2.0 * np.eye(count))
    assert status == OK
    true = np.array([expm(time * matrix) @ start for time in TIMES]).T
    assert np.abs(toy.out - true).max() < 1e-6
    assert np.abs(true[:, 0]).max() > 1e-2
    assert len(set(steps)) == 1
    assert results.counts[STEPS] == count * rod.accepted[0]


@pytest.mark.parametrize("worst", [math.nan, math.inf, 7.0])
@pytest.mark.parametrize("place", [0, 4, 10])
def test_the_worst_error_of_coupled_bodies_is_that_of_all(worst, place):
    """One that is no number above all: a step with it is never accepted, wherever the body stands."""
    bodies = 11
    blocks = new_blocks(bodies, AFTER_METHOD)
    for i in range(bodies):
        put(blocks[i // LANES], ERROR, i % LANES, worst if i == place else 0.1 * i)
    _agree(ERROR, False, bodies, blocks)
    agreed = [get(blocks[i // LANES], ERROR, i % LANES) for i in range(bodies)]
    assert np.array_equal(agreed, [worst] * bodies, equal_nan=True)


def test_a_method_that_lands_ends_a_step_at_an_event():
    event = 1.2345
    assert run_of(STIFF, ONES, event=event)[1].ends[0] == 0
    status, toy, _, _, results = run_of(STIFF, ONES, method=ROSENBROCK["rodas4_landing"], event=event)
    assert status == OK
    assert len(STIFF) // 2 < toy.ends[0] <= results.counts[REJECTIONS]  # the others have it within LANDED of the end


@pytest.mark.parametrize(
    ("given", "found", "failure"),
    [
        ({"stop": 1}, STOPPED, [0.0, 0.0]),
        ({"wrong": 3}, NOT_FINITE, [0.0, 0.0]),
        ({"tolerance": 0.0}, STALLED, [0.0, 0.0]),
    ],
)
def test_a_run_ends_where_it_is_stopped_stalls_or_cannot_be_right(given, found, failure):
    status, _, _, _, results = run_of(STIFF, (2.0,) * 11, **given)
    assert status == found
    assert results.failure.tolist() == failure
