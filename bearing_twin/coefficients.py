"""Coefficients of the integration methods of bearings, which the core is handed.

A Rosenbrock method is the set of coefficients of its transformed form
(Hairer and Wanner, Solving ODE II, section IV.7): with W = I/(h gamma) - J the stages solve

    W k_i = f(t + alpha_i h, y + sum_j a_ij k_j) + sum_j (c_ij / h) k_j + h d_i df/dt

and each step costs one Jacobian and one factorisation. All shipped ones are stiffly accurate: the last stage is the
error estimate, and added to the last stage's state it gives the new one.
"""

from typing import NamedTuple

import numpy as np

MOST_STAGES = 6  # of a method whose coefficients the core reads; a and c have one column fewer


class Rosenbrock(NamedTuple):
    """A Rosenbrock method in transformed form; the last stage is the error estimate, `dense` the interpolant.

    One that `lands` ends a step where a contact begins or ends.
    """

    gamma: float
    a: np.ndarray
    c: np.ndarray
    alpha: np.ndarray
    d: np.ndarray
    dense: np.ndarray
    order: int
    lands: bool = False


class RungeKutta(NamedTuple):
    """An explicit Runge-Kutta method; `error` weighs all slopes and that at the new state, zero: no estimate."""

    a: np.ndarray
    nodes: np.ndarray
    weights: np.ndarray
    error: np.ndarray
    order: int


def _lower(*rows) -> np.ndarray:
    """A matrix from the rows of its lower triangle, padded with zeros to what the core expects."""
    matrix = np.zeros((len(rows), MOST_STAGES - 1))
    for i, row in enumerate(rows):
        matrix[i, : len(row)] = row
    return matrix


def dense_weights(gamma, a, c, alpha) -> np.ndarray:
    """An interpolant of order 2 for a Rosenbrock method of order 3; two terms (2, MOST_STAGES - 1).

    The weights t + theta f between the linear terms, smallest that meet the conditions of order 2 and the one of order
    3 on the nodes, one power of theta at a time (Hairer and Wanner, section IV.7), taken to the transformed form.
    """
    stages = len(alpha)
    inverse = np.eye(stages) / gamma - c[:, :stages]
    full = np.linalg.inv(inverse)
    rows = (a[:, :stages] @ full + full).sum(axis=1)
    conditions = np.array([np.ones(stages), rows, alpha**2])
    required = np.array([[0.0, 0.0], [-1.0 / 2.0, 0.0], [-1.0 / 3.0, -1.0 / 3.0]])
    weights = np.linalg.lstsq(conditions, required, rcond=None)[0]
    dense = np.zeros((2, MOST_STAGES - 1))
    dense[:, :stages] = weights.T @ inverse
    return dense


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

_RODAS3 = {
    "gamma": 0.5,
    "a": _lower((), (), (2.0,), (2.0, 0.0, 1.0)),
    "c": _lower((), (4.0,), (1.0, -1.0), (1.0, -1.0, -8.0 / 3.0)),
    "alpha": np.array([0.0, 0.0, 1.0, 1.0]),
}
RODAS3 = Rosenbrock(**_RODAS3, d=np.array([0.5, 1.5, 0.0, 0.0]), dense=dense_weights(**_RODAS3), order=3)

RK4 = RungeKutta(
    a=_lower((), (1 / 2,), (0, 1 / 2), (0, 0, 1)),
    nodes=np.array([0.0, 0.5, 0.5, 1.0]),
    weights=np.array([1.0, 2.0, 2.0, 1.0]) / 6.0,
    error=np.zeros(5),
    order=4,
)
DOPRI5 = RungeKutta(
    a=_lower(
        (),
        (1 / 5,),
        (3 / 40, 9 / 40),
        (44 / 45, -56 / 15, 32 / 9),
        (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
        (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    ),
    nodes=np.array([0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0]),
    weights=np.array([35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84]),
    error=np.array([71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40]),
    order=5,
)
ROSENBROCK = {"rodas4": RODAS4, "rodas4_landing": RODAS4._replace(lands=True), "rodas3": RODAS3}
EXPLICIT = {"rk4": RK4, "dopri5": DOPRI5}
