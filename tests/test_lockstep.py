"""The loop of methods that step all bodies together, by a toy: a body whose place grows with the square of time."""

import math
from collections import namedtuple

import numpy as np
import pytest

from bearing_twin.compiled import inlined, kernel
from bearing_twin.numerics.lockstep import CHECK_EVERY, TURN_EVERY, Pace, advance_together
from bearing_twin.numerics.statuses import NOT_FINITE, OK, REJECTIONS, STALLED, STEPS, STOPPED

Toy = namedtuple("Toy", ["place", "ahead", "seen", "errors_per_second", "goes_wrong_at"])
Results = namedtuple("Results", ["states", "orientations", "counts", "failure", "stop"])
MOVED, TURNED, SECONDS, TURNS, CHECKS, STARTS = range(6)  # of what was `seen`


@inlined
def one_step(toy, time, step, begun):
    toy.ahead[0] = toy.place[0] + step * (2.0 * time + step)
    toy.seen[STARTS] += 0.0 if begun else 1.0
    return step * toy.errors_per_second


@inlined
def move_on(toy, fresh):
    toy.place[0] = toy.ahead[0]
    toy.seen[MOVED] += 1.0


@inlined
def whose(toy):
    return 3


@inlined
def turn(toy, seconds, step, steps):
    toy.seen[TURNED] += steps
    toy.seen[SECONDS] += seconds
    toy.seen[TURNS] += 1.0


@inlined
def keep(toy, state, orientation):
    state[0, 0], orientation[0, 0] = toy.place[0], toy.seen[SECONDS]


@inlined
def check(toy, time, state, failure):
    toy.seen[CHECKS] += 1.0
    if time < toy.goes_wrong_at:
        return OK
    failure[0], failure[1] = time, 0
    return NOT_FINITE


@kernel
def advanced(toy, pace, times, duration, bodies, state, orientation, results):
    return advance_together(
        one_step, whose, move_on, turn, keep, check, toy, pace, times, duration, bodies, state, orientation, results
    )


def run_of(pace, times=(0.25, 1.0), duration=1.5, errors_per_second=0.0, goes_wrong_at=math.inf, stop=0, bodies=1):
    toy = Toy(np.zeros(1), np.zeros(1), np.zeros(6), errors_per_second, goes_wrong_at)
    shape, counts, failure = (len(times), 1, 1), np.zeros(4, np.int64), np.zeros(2)
    results = Results(np.zeros(shape), np.zeros(shape), counts, failure, np.array([stop]))
    state, orientation = np.zeros((1, 1)), np.zeros((1, 1))
    found = advanced(toy, pace, np.array(times), duration, bodies, state, orientation, results)
    return found, toy.seen, results, state, orientation


@pytest.mark.parametrize("counted", [False, True])
def test_instants_are_ends_of_equal_steps(counted):
    (status, wanted), seen, results, state, orientation = run_of(Pace(0.01, 0, counted))
    assert (status, wanted) == (OK, 0.01)
    assert results.states[:, 0, 0] == pytest.approx([0.25**2, 1.0], rel=1e-12)
    assert results.orientations[:, 0, 0] == pytest.approx([0.25, 1.0], rel=1e-12)
    assert (state[0, 0], orientation[0, 0]) == pytest.approx((2.25, 1.5), rel=1e-12)
    assert results.counts[STEPS] == seen[MOVED] == seen[TURNED] == 25 + 75 + 50
    assert seen[TURNS] == sum(math.ceil(steps / TURN_EVERY) for steps in (25, 75, 50))
    assert seen[CHECKS] == sum(math.ceil(steps / CHECK_EVERY) for steps in (25, 75, 50))
    assert seen[STARTS] == 1


def test_an_estimate_adapts_the_steps():
    (status, wanted), _, results, state, _ = run_of(Pace(1.0, 1, False), errors_per_second=20.0)
    assert status == OK
    assert state[0, 0] == pytest.approx(2.25, rel=1e-12)
    assert results.counts[REJECTIONS] > 0
    assert 1.5 / 0.05 <= results.counts[STEPS] < 1.5 / 0.03  # an error of 1 comes with a step of 0.05
    assert wanted < 0.06
    more = run_of(Pace(1.0, 1, False), errors_per_second=20.0, bodies=3)[2]
    assert (more.counts == 3 * results.counts).all()  # steps of bodies


def test_a_run_ends_where_it_is_stopped_stalls_or_cannot_be_right():
    assert run_of(Pace(0.01, 0, False), stop=1)[0][0] == STOPPED
    (status, _), _, results, _, _ = run_of(Pace(0.01, 1, False), errors_per_second=math.inf)
    assert status == STALLED
    assert results.failure.tolist() == [0.0, 3.0]
    (status, _), seen, results, _, _ = run_of(Pace(0.01, 0, True), goes_wrong_at=0.5)
    assert status == NOT_FINITE
    assert results.failure[0] == pytest.approx(0.25 + CHECK_EVERY * 0.01)
    assert seen[CHECKS] == 2
