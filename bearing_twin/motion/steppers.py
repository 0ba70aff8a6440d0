"""Integration methods as data, and the small compiled pieces they share.

`METHODS` says what each stepper is. A Rosenbrock method is the set of coefficients of its transformed form (Hairer and
Wanner, Solving ODE II, section IV.7): with W = I/(h gamma) - J the stages solve

    W k_i = f(t + alpha_i h, y + sum_j a_ij k_j) + sum_j (c_ij / h) k_j + h d_i df/dt

and each step costs one Jacobian and one factorisation.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel

MOST_STAGES = 6  # of a Rosenbrock method; a has one column fewer


class Rosenbrock(NamedTuple):
    """A Rosenbrock method in transformed form; the last stage is the error estimate, `dense` the interpolant."""

    gamma: float
    a: np.ndarray
    c: np.ndarray
    alpha: np.ndarray
    d: np.ndarray
    dense: np.ndarray
    order: int


class Method(NamedTuple):
    """What a stepper is: its formal order, whether its step adapts, and where it comes from."""

    order: int
    adaptive: bool
    source: str


METHODS = {
    "rk4": Method(4, False, "Kutta 1901, the classical method, fixed step"),
    "rodas4": Method(
        4, True, "Hairer and Wanner, Solving ODE II, 2nd ed. 1996, section IV.7: RODAS, order 4(3), L-stable"
    ),
    "dop853": Method(8, True, "SciPy DOP853, explicit; a reference"),
    "radau": Method(5, True, "SciPy Radau IIA, implicit; a reference"),
}

_RODAS4_A5 = (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950)
RODAS4 = Rosenbrock(
    gamma=0.25,
    a=np.array(
        [
            [0.0, 0.0, 0.0, 0.0, 0.0],
            [1.544, 0.0, 0.0, 0.0, 0.0],
            [0.9466785280815826, 0.2557011698983284, 0.0, 0.0, 0.0],
            [3.314825187068521, 2.896124015972201, 0.9986419139977817, 0.0, 0.0],
            [*_RODAS4_A5, 0.0],
            [*_RODAS4_A5, 1.0],
        ]
    ),
    c=np.array(
        [
            [0.0, 0.0, 0.0, 0.0, 0.0],
            [-5.6688, 0.0, 0.0, 0.0, 0.0],
            [-2.430093356833875, -0.2063599157091915, 0.0, 0.0, 0.0],
            [-0.1073529058151375, -9.594562251023355, -20.47028614809616, 0.0, 0.0],
            [7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160, 0.0],
            [8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054],
        ]
    ),
    alpha=np.array([0.0, 0.386, 0.21, 0.63, 1.0, 1.0]),
    d=np.array([0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0]),
    dense=np.array(
        [
            [10.12623508344586, -7.487995877610167, -34.80091861555747, -7.992771707568823, 1.025137723295662],
            [-0.6762803392806898, 6.087714651680015, 16.43084320892478, 24.76722511418386, -6.594389125716872],
        ]
    ),
    order=4,
)


@kernel
def factorise(matrix, pivots, size):
    """LU factors of matrix[:size, :size] in place, with partial pivoting; False when it is singular or not finite."""
    for column in range(size):
        pivot = column
        greatest = abs(matrix[column, column])
        for row in range(column + 1, size):
            value = abs(matrix[row, column])
            if value > greatest:
                pivot, greatest = row, value
        pivots[column] = pivot
        if not 0.0 < greatest < math.inf:
            return False
        if pivot != column:
            for j in range(size):
                matrix[column, j], matrix[pivot, j] = matrix[pivot, j], matrix[column, j]
        inverse = 1.0 / matrix[column, column]
        for row in range(column + 1, size):
            factor = matrix[row, column] * inverse
            if factor != 0.0:
                matrix[row, column] = factor
                for j in range(column + 1, size):
                    matrix[row, j] -= factor * matrix[column, j]
    return True


@kernel
def substitute(matrix, pivots, size, vector):
    """Solves in place with the factors of `factorise`."""
    for column in range(size):
        pivot = pivots[column]
        vector[column], vector[pivot] = vector[pivot], vector[column]
    for column in range(size):
        value = vector[column]
        for row in range(column + 1, size):
            vector[row] -= matrix[row, column] * value
    for column in range(size - 1, -1, -1):
        value = vector[column] / matrix[column, column]
        vector[column] = value
        for row in range(column):
            vector[row] -= matrix[row, column] * value


@kernel
def next_step(step, error, order):
    """The step that should just meet an error of 1, given the error norm of this one; changes by 0.2 to 6 at most."""
    if not error < math.inf:
        return 0.2 * step
    return step * min(6.0, max(0.2, 0.9 * max(error, 1e-10) ** (-1.0 / order)))


@inlined
def rosenbrock_dense(fraction, start, end, third, fourth):
    """The interpolant of a Rosenbrock step at `fraction` of it, for one component."""
    rest = 1.0 - fraction
    return start * rest + fraction * (end + rest * (third + fraction * fourth))
