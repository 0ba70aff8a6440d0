"""One step of a Rosenbrock method for a system of few numbers, its Jacobian dense.

A kind hands over its functions; they and this are compiled into the kind's own kernels. The balls of a bearing, in
lanes and with a sparse Jacobian, have the loop of `numerics/rosenbrock.py` instead: the same methods, the same
`next_step`.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import kernel, template

APART = 1e-3  # tuned: of the step: how far on either side the rates' explicit change with time is taken


class RosenbrockWork(NamedTuple):
    """Room for a step of `numbers`, of which the first `moving` decide how all change; made by `rosenbrock_work`."""

    after: np.ndarray
    stages: np.ndarray
    trial: np.ndarray
    slopes: np.ndarray
    before: np.ndarray
    change: np.ndarray
    jacobian: np.ndarray
    factors: np.ndarray
    rows: np.ndarray
    scales: np.ndarray


def rosenbrock_work(numbers: int, moving: int, stages: int, scales: np.ndarray) -> RosenbrockWork:
    """Room for steps; `scales` (moving,) are what counts as an error of 1."""
    vectors = (np.zeros(numbers) for _ in range(4))
    matrices = np.zeros((numbers, moving)), np.zeros((moving, moving)), np.zeros(moving, np.int64)
    return RosenbrockWork(np.zeros(numbers), np.zeros((stages, numbers)), *vectors, *matrices, scales)


@kernel
def factorise(matrix, rows):
    """Factors of a square matrix in its place, by the greatest pivot of each column; `rows` (n,) are the exchanges."""
    n = len(rows)
    for i in range(n):
        best = i
        for r in range(i + 1, n):
            if abs(matrix[r, i]) > abs(matrix[best, i]):
                best = r
        rows[i] = best
        if best != i:
            for j in range(n):
                matrix[i, j], matrix[best, j] = matrix[best, j], matrix[i, j]
        inverse = 1.0 / matrix[i, i]
        for r in range(i + 1, n):
            matrix[r, i] *= inverse
            factor = matrix[r, i]
            if factor != 0.0:
                for j in range(i + 1, n):
                    matrix[r, j] -= factor * matrix[i, j]


@kernel
def solve_factorised(factors, rows, right):
    """Solves for `right`, whose first numbers are the right-hand side and then the solution."""
    n = len(rows)
    for i in range(n):
        right[i], right[rows[i]] = right[rows[i]], right[i]
    for i in range(1, n):
        for j in range(i):
            right[i] -= factors[i, j] * right[j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            right[i] -= factors[i, j] * right[j]
        right[i] /= factors[i, i]


@template
def rosenbrock_step(method, rates, jacobian, system, time, state, step, work):
    """Writes the state `step` [s] later to `work.after`; returns the error as a root mean square in `work.scales`.

    `rates(system, time, state, slopes)` fills the slopes; `jacobian(system, state, matrix)`, called after the rates of
    the same state, their derivatives (numbers, moving) by the first, moving numbers: the others are sums over time.
    `dense_terms` are those of the step made last.
    """
    moving, numbers = work.jacobian.shape[1], len(state)
    inverse = 1.0 / (method.gamma * step)
    apart = APART * step
    rates(system, time - apart, state, work.before)
    rates(system, time + apart, state, work.change)
    for n in range(numbers):
        work.change[n] = (work.change[n] - work.before[n]) / (2.0 * APART)  # times the step
    for i in range(len(method.alpha)):
        work.trial[:] = state
        for j in range(i):
            for n in range(numbers):
                work.trial[n] += method.a[i, j] * work.stages[j, n]
        rates(system, time + method.alpha[i] * step, work.trial, work.slopes)
        if i == 0:
            jacobian(system, state, work.jacobian)
            for r in range(moving):
                for n in range(moving):
                    work.factors[r, n] = -work.jacobian[r, n]
                work.factors[r, r] += inverse
            factorise(work.factors, work.rows)
        stage = work.stages[i]
        for n in range(numbers):
            stage[n] = work.slopes[n] + method.d[i] * work.change[n]
            for j in range(i):
                stage[n] += method.c[i, j] / step * work.stages[j, n]
        solve_factorised(work.factors, work.rows, stage)
        for r in range(moving, numbers):
            for n in range(moving):
                stage[r] += work.jacobian[r, n] * stage[n]
            stage[r] /= inverse
    last, error = work.stages[len(method.alpha) - 1], 0.0
    for n in range(numbers):
        work.after[n] = work.trial[n] + last[n]
    for n in range(moving):
        error += (last[n] / work.scales[n]) ** 2
    return math.sqrt(error / moving)


@kernel
def dense_terms(method, work, third, fourth):
    """Fills the two terms (numbers,) of the last step's interpolant, `rosenbrock_dense`."""
    third[:] = 0.0
    fourth[:] = 0.0
    for j in range(len(method.alpha) - 1):
        for n in range(len(third)):
            third[n] += method.dense[0, j] * work.stages[j, n]
            fourth[n] += method.dense[1, j] * work.stages[j, n]
