"""What explicit methods share: the step, its control, the cubic inside it; and events within a step."""

import math
from collections import namedtuple

import numpy as np
import pytest

from bearing_twin.compiled import inlined, kernel
from bearing_twin.numerics.dop853 import DOP853
from bearing_twin.numerics.events import halved, parabola_top
from bearing_twin.numerics.runge_kutta import hermite, longest_step, runge_kutta_step
from bearing_twin.numerics.statuses import EVALUATIONS, REJECTIONS
from bearing_twin.numerics.steppers import RK4

STILL = 7.0  # a number of the state that does not move
Work = namedtuple("Work", ["stages", "trial", "after", "scales"])


def work_of(method, tolerance=1.0):
    stages = np.zeros((len(method.weights), 3))
    return Work(stages, np.zeros(3), np.zeros(3), np.full(3, tolerance))


@kernel
def oscillator(rate, state, loaded, out):
    """Without its spring it flies on."""
    out[0], out[1] = state[1], -rate * rate * state[0] if loaded else 0.0


@kernel
def one_step(rate, method, state, step, loaded, work, out):
    return runge_kutta_step(method, oscillator, rate, state, step, loaded, 2, work, out)


@kernel
def longest(rate, method, state, wanted, least, work, counts):
    return longest_step(one_step, rate, method, state, wanted, least, True, work, counts)


def one_longest(rate, method, state, wanted, least, work):
    """Step, the next to try, and how many attempts failed, by the rejections and by the evaluations counted."""
    counts = np.zeros(3, np.int64)
    step, following = longest(rate, method, state, wanted, least, work, counts)
    assert counts[EVALUATIONS] == len(method.weights) * (counts[REJECTIONS] + (step > 0.0))
    return step, following, counts[REJECTIONS]


def after(method, step, rate=2.0, loaded=True):
    state, out, work = np.array([1.0, 0.5, STILL]), np.empty(3), work_of(method)
    error = one_step(rate, method, state, step, loaded, work, out)
    return out, error


def exact(step, rate=2.0):
    turn = rate * step
    return np.array([math.cos(turn) + 0.5 / rate * math.sin(turn), 0.5 * math.cos(turn) - rate * math.sin(turn)])


@pytest.mark.parametrize(("method", "step"), [(RK4, 0.05), (DOP853, 0.4)])
def test_a_step_has_the_order_of_its_method(method, step):
    wide, half = (np.abs(after(method, one)[0][:2] - exact(one)).max() for one in (step, 0.5 * step))
    assert math.log2(wide / half) == pytest.approx(method.order + 1, abs=0.4)


def test_what_does_not_move_stays_and_flight_has_no_error():
    out, error = after(DOP853, 0.4, loaded=False)
    assert out.tolist() == pytest.approx([1.2, 0.5, STILL], rel=1e-14)
    assert error < 1e-14
    assert after(RK4, 0.4)[1] == 0.0


def test_the_estimate_is_a_root_mean_square_in_units_of_the_scales():
    state, out = np.array([1.0, 0.5, STILL]), np.empty(3)
    unit = one_step(2.0, DOP853, state, 0.4, True, work_of(DOP853), out)
    tenth = one_step(2.0, DOP853, state, 0.4, True, work_of(DOP853, 0.1), out)
    assert tenth == pytest.approx(10.0 * unit, rel=1e-12)
    assert unit > 0.0


def test_the_longest_step_meets_the_tolerance_and_says_what_it_tried():
    state, work = np.array([1.0, 0.5, STILL]), work_of(DOP853, 1e-10)
    step, following, rejections = one_longest(2.0, DOP853, state, 3.0, 1e-6, work)
    assert rejections > 0
    assert 0.0 < step < 3.0
    assert following > 0.2 * step
    assert np.abs(work.after[:2] - exact(step)).max() < 1e-9
    short = one_longest(2.0, DOP853, state, 1e-3, 1e-6, work)
    assert short == (1e-3, pytest.approx(6e-3), 0)
    assert one_longest(2.0, DOP853, state, 3.0, 2.9, work)[0] == -1.0


@kernel
def inside(share, step, ends):
    return hermite(share, step, ends[0], ends[1], ends[2], ends[3])


def test_the_cubic_inside_a_step_is_exact_for_cubics():
    curve, step = np.polynomial.Polynomial([0.3, -1.0, 2.0, 5.0]), 0.7
    slope = curve.deriv()
    ends = curve(0.0), slope(0.0), curve(step), slope(step)
    for share in (0.0, 0.2, 0.5, 1.0):
        assert inside(share, step, ends) == pytest.approx(curve(share * step), rel=1e-14)


@inlined
def _below(root, place):
    return place < root


@kernel
def found(root, longest, width):
    return halved(_below, root, longest, width)


def test_an_event_is_halved_down_to_the_width():
    low, high, last = found(0.3, 2.0, 1e-9)
    assert low < 0.3 <= high
    assert high - low <= 1e-9
    assert last in (low, high)
    assert found(1.0, 2.0, 1.5)[1] == 1.0
    low, high, _ = found(0.3, 1.0, 0.0)
    assert high == pytest.approx(0.3, abs=1e-16)


@kernel
def top(places, values):
    return parabola_top(places[0], places[1], places[2], values[0], values[1], values[2])


@pytest.mark.parametrize("places", [(-0.4, 0.0, 0.3), (1.0, 1.1, 2.5)])
def test_the_top_of_a_parabola_is_found_and_lies_between(places):
    middle = places[1] + 0.02
    curve = [5.0 - 3.0 * (place - middle) ** 2 for place in places]
    assert top(places, tuple(curve)) == pytest.approx(middle, rel=1e-12)
