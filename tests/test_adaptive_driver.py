"""The loop of explicit methods for one system by a toy with a closed form: an oscillator whose zeros are events."""

import math
from collections import namedtuple
from types import SimpleNamespace

import numpy as np
import pytest

from bearing_twin.compiled import kernel, template
from bearing_twin.numerics.adaptive import CURSOR, REPEAT, STEP, TIME, advance_adaptively
from bearing_twin.numerics.dop853 import DOP853
from bearing_twin.numerics.events import crossing, landing_step, look_at_top
from bearing_twin.numerics.runge_kutta import copy_numbers, runge_kutta_step
from bearing_twin.numerics.statuses import (
    FULL,
    NOT_FINITE,
    OK,
    REJECTIONS,
    STALLED,
    STEPS,
    STOPPED,
    TIME_UP,
)
from bearing_twin.numerics.steppers import RK4

CLOCK, DRIFT = 6, 2
Toy = namedtuple("Toy", ["rate", "blows_up", "refuses"])
Plan = namedtuple("Plan", ["longest", "least", "wanted"])
Work = namedtuple("Work", ["stages", "trial", "after", "scales"])


@kernel
def oscillator(toy, state, loaded, out):
    out[0], out[1] = state[1], -toy.rate * toy.rate * state[0]


@kernel
def one_step(toy, method, state, step, loaded, work, out):
    return runge_kutta_step(method, oscillator, toy, state, step, loaded, 2, work, out)


@template
def place(toy, state):
    return state[0]


@template
def begin(toy, plan, state, clock, record, seen, counts, work):
    return TIME_UP if clock[TIME] > toy.refuses else OK, min(clock[STEP], plan.longest), plan.least, True


@template
def end(toy, plan, method, state, clock, seen, step, loaded, counts, work):
    """A zero ends a step; one longer than wanted is made again."""
    status, crossed = OK, (work.after[0] > 0.0) != (state[0] > 0.0)
    if step > plan.wanted:
        clock[STEP] = plan.wanted
        status = REPEAT
    elif work.after[0] < toy.blows_up:
        work.after[2] = math.inf
    elif crossed:
        step = landing_step(place, one_step, toy, method, state, step, 1e-15, work, counts)
    return status, step, crossed


@template
def put_right(toy, state):
    state[2] = 1.0


@template
def accept(toy, plan, method, state, clock, record, seen, step, following, loaded, crossed, counts, work):
    copy_numbers(work.after, state)
    clock[STEP] = following
    clock[DRIFT] += seen
    record[0], record[1] = clock[TIME], state[1]
    return OK, state[0], crossed


@kernel
def advance(toy, plan, method, state, clock, record, times, until, states, records, counts, work, stop):
    return advance_adaptively(
        place, begin, one_step, end, put_right, accept,
        toy, plan, method, state, clock, record, times, until, states, records, counts, work, stop,
    )  # fmt: skip


def moving(method=DOP853, tolerance=1e-10, longest=1.0, least=1e-12, wanted=math.inf, rate=2.0, **limits):
    """The toy from x = 1, v = 0.5, by a method with steps up to `longest` [s]; `go` moves it on."""
    clock = np.zeros(CLOCK)
    clock[STEP] = math.inf
    return SimpleNamespace(
        toy=Toy(**{"rate": rate, "blows_up": -math.inf, "refuses": math.inf} | limits),
        plan=Plan(longest, least, wanted), method=method, state=np.array([1.0, 0.5, 0.0]), clock=clock,
        record=np.zeros(2), counts=np.zeros(3, np.int64), stop=np.zeros(1, np.int64),
        work=Work(np.zeros((len(method.weights), 3)), np.zeros(3), np.zeros(3), np.full(3, tolerance)),
        events=np.empty((0, 2)),
    )  # fmt: skip


def go(motion, times, until, room=50):
    """The status of a stretch and the states at `times`; the motion has its events."""
    states, records = np.zeros((len(times), 3)), np.zeros((room, 2))
    motion.clock[CURSOR] = 0.0
    status, completed = advance(
        motion.toy, motion.plan, motion.method, motion.state, motion.clock, motion.record, np.array(times, float),
        until, states, records, motion.counts, motion.work, motion.stop,
    )  # fmt: skip
    motion.events = np.concatenate([motion.events, records[:completed]])
    return status, states


def exact(times, rate=2.0):
    turn = rate * np.asarray(times)
    return np.column_stack([np.cos(turn) + 0.5 / rate * np.sin(turn), 0.5 * np.cos(turn) - rate * np.sin(turn)])


def zeros(count, rate=2.0):
    """Times at which the toy is at zero."""
    return (math.atan2(-1.0, 0.5 / rate) + math.pi * np.arange(1, count + 1)) / rate


def test_outputs_and_events_meet_the_closed_form_in_both_directions():
    motion, times = moving(), np.linspace(0.0, 10.0, 101)
    status, states = go(motion, times, 10.0)
    assert status == OK
    assert states[:, :2] == pytest.approx(exact(times), abs=1e-8)
    assert (states[:, 2] == 1.0).all()  # outputs are put right, too
    assert len(motion.events) == 6
    assert motion.events[:, 0] == pytest.approx(zeros(6), abs=1e-9)
    assert np.sign(motion.events[:, 1]).tolist() == [-1.0, 1.0] * 3
    assert motion.counts[REJECTIONS] > 0  # with a second as the first step


@pytest.mark.parametrize(("method", "longest"), [(RK4, 0.1), (DOP853, 0.8)])
def test_outputs_and_events_within_steps_have_the_order_of_the_method(method, longest):
    off = []
    for step in (longest, 0.5 * longest):
        motion, times = moving(method, math.inf, step), np.linspace(0.3, 5.0, 60)
        _, states = go(motion, times, 5.0)
        places = np.abs(states[:, :2] - exact(times)).max()
        off.append((places, np.abs(motion.events[:, 0] - zeros(len(motion.events))).max()))
    for wide, half in zip(*off, strict=True):
        assert math.log2(wide / half) > method.order - 0.5


def test_no_bit_depends_on_how_a_motion_is_cut_nor_on_what_is_looked_at():
    times = np.linspace(0.0, 7.0, 29)
    whole, cut, blind = moving(), moving(), moving()
    _, states = go(whole, times, 7.0)
    pieces = [go(cut, part, part[-1])[1] for part in np.split(times, [3, 4, 20])]
    go(blind, [], 7.0)
    assert np.array_equal(states, np.concatenate(pieces))
    for other in (cut, blind):
        assert np.array_equal(whole.events, other.events)
        assert np.array_equal(whole.state, other.state)
        assert other.counts[STEPS] == whole.counts[STEPS]
        assert other.clock[DRIFT] == whole.clock[DRIFT]  # what is seen at each end is handed on across a cut


def test_what_ends_a_stretch_says_why():
    stopped = moving()
    stopped.stop[0] = 1
    assert go(stopped, [], 1.0)[0] == STOPPED
    assert stopped.clock[TIME] == 0.0
    assert go(moving(tolerance=1e-10, least=0.9), [], 5.0)[0] == STALLED
    assert go(moving(rate=math.nan), [], 5.0)[0] == STALLED
    late = moving(refuses=2.0)
    assert go(late, [], 5.0)[0] == TIME_UP
    assert late.clock[TIME] > 2.0
    spoilt = moving(RK4, longest=0.01, blows_up=0.5)
    assert go(spoilt, [], 5.0)[0] == NOT_FINITE
    assert np.isfinite(spoilt.state).all()  # the last good one
    full = moving()
    assert go(full, [1.0, 9.0], 10.0, room=2)[0] == FULL
    assert full.clock[TIME] == pytest.approx(zeros(2)[1])
    assert full.clock[CURSOR] == 1.0


def test_a_step_that_is_to_be_made_again_has_the_length_asked_for():
    motion = moving(RK4, longest=1.0, wanted=0.125)
    assert go(motion, [], 0.5)[0] == OK
    assert motion.clock[TIME] == 0.5
    assert motion.counts[STEPS] == 4


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_cubic_is_crossed_where_its_sign_changes_either_way(sign):
    curve = np.polynomial.Polynomial([-0.3, 1.0]) * np.polynomial.Polynomial([1.0, 0.2, 0.4]) * sign
    slope = curve.deriv()
    assert crossing(0.7, curve(0.0), slope(0.0), curve(0.7), slope(0.7)) == pytest.approx(0.3 / 0.7, abs=1e-13)


@template
def _seen(what, back, at):
    what[1] += 1.0
    what[2] = at
    return math.cos(at - what[0])


@kernel
def looked_at(what, trail, step, rounds):
    look_at_top(_seen, what, trail, step, math.cos(step - what[0]), 1.0, rounds)


@pytest.mark.parametrize(("rounds", "off"), [(1, 1e-2), (3, 1e-4)])
def test_a_top_between_three_ends_is_looked_at_more_closely_round_by_round(rounds, off):
    top, back, step = 0.1, 0.4, 0.5
    what, trail = np.array([top, 0.0, 0.0]), np.array([math.cos(-back - top), math.cos(top), back])
    looked_at(what, trail, step, rounds)
    assert 1 <= what[1] <= rounds
    assert what[2] == pytest.approx(top, abs=off)
    assert trail.tolist() == [math.cos(top), math.cos(step - top), step]
    before = what[1]
    looked_at(what, trail, step, rounds)  # falling already
    assert what[1] == before
