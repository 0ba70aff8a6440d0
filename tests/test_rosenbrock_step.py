"""One step of a Rosenbrock method with a dense Jacobian, by a toy whose answer is known: y' = cos t - (y - sin t)^2."""

import math

import numpy as np
import pytest

from bearing_twin.compiled import inlined, kernel
from bearing_twin.numerics.rosenbrock_step import dense_terms, rosenbrock_step, rosenbrock_work
from bearing_twin.numerics.steppers import RODAS4, rosenbrock_dense

START = 0.3  # s


@inlined
def rates(system, time, state, slopes):
    for n in range(len(state) - 1):
        slopes[n] = math.cos(time) - (state[n] - math.sin(time)) ** 2
    slopes[-1] = state[0]


@inlined
def jacobian(system, state, matrix):
    matrix[:] = 0.0
    for n in range(len(state) - 1):
        matrix[n, n] = -2.0 * (state[n] - math.sin(system[0]))
    matrix[-1, 0] = 1.0


@kernel
def one_step(system, state, step, work, third, fourth):
    error = rosenbrock_step(RODAS4, rates, jacobian, system, system[0], state, step, work)
    dense_terms(RODAS4, work, third, fourth)
    return error


def exact(time):
    """The answer at `time` [s], and its integral since 0."""
    return np.array([math.sin(time) + 1.0 / (1.0 + time), 1.0 - math.cos(time) + math.log1p(time)])


def stepped(step, copies=1):
    """(error, end, middle of the interpolant) of a step by so many copies of the toy and the integral of the first."""
    begin = exact(START)
    state = np.array([begin[0]] * copies + [begin[1]])
    work = rosenbrock_work(copies + 1, copies, len(RODAS4.alpha), np.full(copies, 1e-6))
    third, fourth = np.zeros((2, copies + 1))
    error = one_step(np.array([START]), state, step, work, third, fourth)
    return error, work.after.copy(), rosenbrock_dense(0.5, state, work.after, third, fourth)


def test_a_step_errs_by_the_fifth_power_of_its_length_and_its_middle_by_the_fourth():
    """Rates that change with time by themselves, and a sum over time, are as exact as the rest."""
    off = []
    for step in (0.1, 0.05, 0.025):
        _, end, middle = stepped(step)
        off.append([np.abs(end - exact(START + step)), np.abs(middle - exact(START + 0.5 * step))])
    orders = np.log2(np.array(off[:-1]) / np.array(off[1:]))[-1]
    assert orders[0].min() > 4.5
    assert orders[1].min() > 3.5


def test_the_error_of_a_step_is_a_mean_which_copies_do_not_change():
    error, end, _ = stepped(0.1)
    assert 1.0 < error * 1e-6 / abs(end[0] - exact(START + 0.1)[0]) < 100.0
    more, same, _ = stepped(0.1, copies=4)
    assert more == pytest.approx(error, rel=1e-9)
    assert same[:4] == pytest.approx(end[0], rel=1e-14)
