"""Sobol indices by sampling: which input the variance of a quantity comes from.

A. Saltelli et al., Variance based sensitivity analysis of model output, Comput. Phys. Commun. 181 (2010). Two
independent points A and B a row, and for every input i the point A with its coordinate i from B; first-order indices by
Saltelli's estimator mean(f_B (f_ABi - f_A))/V, total ones by Jansen's mean((f_A - f_ABi)^2)/(2 V).
`scipy.stats.sobol_indices` has the same estimators, but takes only a power of two of rows and no NaN, and knows of no
replicates of a design: where a realisation fails, or a study is cut off, there would be no indices. Tests compare both.
"""

from typing import NamedTuple

import numpy as np

from bearing_twin.errors import StatisticError, StudyError
from bearing_twin.uq.inputs import Joint
from bearing_twin.uq.statistics import interval

FEWEST_ROWS = 16
FEWEST_EFFECTIVE = {"independent": 40.0, "replicates": 20.0}  # rows over kurtosis of the influence


class SobolIndices(NamedTuple):
    """First-order and total indices (d,) with their intervals (d, 2), and the number of complete rows used.

    Values a little below 0 or above 1 are noise of the sample; they are not cut off. Where `first_safe` or `total_safe`
    (d,) is False a few rows far out decide, so that the interval holds the truth less often than it says.
    """

    first: np.ndarray
    first_interval: np.ndarray
    first_safe: np.ndarray
    total: np.ndarray
    total_interval: np.ndarray
    total_safe: np.ndarray
    rows: int


def sensitivity_points(joint: Joint, unit):
    """Points (n, d + 2, d) of the unit cube to run at, A, B, AB_1 .. AB_d a row, from points (n, 2 d) of a design.

    Reshaped to (n (d + 2), d) they can be cut into chunks anywhere. Raises StudyError for correlated inputs: their
    variance has no such parts.
    """
    if not joint.independent:
        raise StudyError("Sobol indices are for independent inputs; leave the correlation out")
    unit = np.asarray(unit, float)
    size = joint.dimension
    if unit.ndim != 2 or unit.shape[1] != 2 * size:
        raise ValueError(f"a design of shape (n, {2 * size}) is needed, not {unit.shape}")
    first, second = unit[:, :size], unit[:, size:]
    points = np.repeat(first[:, None, :], size + 2, axis=1)
    points[:, 1] = second
    for index in range(size):
        points[:, 2 + index, index] = second[:, index]
    return points


def sobol_indices(values, replicates=1) -> SobolIndices:
    """Indices from the quantity (n, d + 2) at `sensitivity_points`; rows with a NaN are left out.

    Row i belongs to replicate i % replicates of the design. Intervals by the influence of each row (`statistics`).
    Raises StatisticError for too few rows or a quantity that does not vary.
    """
    values = np.asarray(values, float)
    whole = np.isfinite(values).all(axis=1)
    kept = values[whole]
    if len(kept) < FEWEST_ROWS:
        raise StatisticError(
            f"Sobol indices need {FEWEST_ROWS} complete rows of {values.shape[1]} runs at least, there are {len(kept)}"
        )
    if np.ptp(kept) <= 1e-14 * np.abs(kept).max():
        raise StatisticError("the quantity does not vary: there are no Sobol indices")
    off, moved = kept[:, :2] - kept[:, :2].mean(), kept[:, 2:] - kept[:, [0]]
    squares = np.mean(off**2, axis=1, keepdims=True)
    variance, found = squares.mean(), []
    least = FEWEST_EFFECTIVE["independent" if replicates == 1 else "replicates"]
    for terms in (off[:, [1]] * moved, 0.5 * moved**2):
        index = terms.mean(axis=0) / variance
        influence = np.full((len(values), len(index)), np.nan)
        # The mean, too, is the sample's; what it errs by is of second order.
        influence[whole] = (terms - index * squares) / variance
        ends = [interval(*one, replicates, least) for one in zip(index, influence.T, strict=True)]
        found += [index, np.array([one[1:3] for one in ends]), np.array([one.safe for one in ends])]
    return SobolIndices(*found, len(kept))
