"""Sobol indices by sampling: which input the variance of a quantity comes from.

A. Saltelli et al., Variance based sensitivity analysis of model output, Comput. Phys. Commun. 181 (2010). Two
independent points A and B a row, and for every input i the point A with its coordinate i from B; first-order indices by
Saltelli's estimator mean(f_B (f_ABi - f_A))/V, total ones by Jansen's mean((f_A - f_ABi)^2)/(2 V).
"""

from typing import NamedTuple

import numpy as np

from bearing_twin.errors import StatisticError, StudyError
from bearing_twin.uq.inputs import Joint

RESAMPLES = 500
FEWEST_ROWS = 16


class SobolIndices(NamedTuple):
    """First-order and total indices (d,) with their intervals (d, 2), and the number of complete rows used.

    Values a little below 0 or above 1 are noise of the sample; they are not cut off.
    """

    first: np.ndarray
    first_interval: np.ndarray
    total: np.ndarray
    total_interval: np.ndarray
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


def sobol_indices(values, confidence=0.95, seed=0, resamples=RESAMPLES) -> SobolIndices:
    """Indices from the quantity (n, d + 2) at `sensitivity_points`; rows with a NaN are left out.

    Intervals are percentiles of the bootstrap over rows: honest for random rows, too wide for sobol ones. Raises
    StatisticError for too few rows or a quantity that does not vary.
    """
    values = np.asarray(values, float)
    kept = values[np.isfinite(values).all(axis=1)]
    if len(kept) < FEWEST_ROWS:
        raise StatisticError(
            f"Sobol indices need {FEWEST_ROWS} complete rows of {values.shape[1]} runs at least, there are {len(kept)}"
        )
    if np.ptp(kept) <= 1e-14 * np.abs(kept).max():
        raise StatisticError("the quantity does not vary: there are no Sobol indices")
    rng = np.random.default_rng(seed)
    found = np.array([_indices(kept[rng.integers(0, len(kept), len(kept))]) for _ in range(resamples)])
    low, high = np.quantile(found, [0.5 - 0.5 * confidence, 0.5 + 0.5 * confidence], axis=0)
    first, total = _indices(kept)
    intervals = np.stack([low, high], axis=-1)
    return SobolIndices(first, intervals[0], total, intervals[1], len(kept))


def _indices(values):
    """(2, d): first-order and total indices of complete rows."""
    values = values - np.mean(values[:, :2])  # less noise: only differences count
    first, second, mixed = values[:, 0], values[:, 1], values[:, 2:]
    variance = np.var(values[:, :2])
    alone = np.mean(second[:, None] * (mixed - first[:, None]), axis=0) / variance
    total = 0.5 * np.mean((first[:, None] - mixed) ** 2, axis=0) / variance
    return np.array([alone, total])
