"""Sobol indices by sampling: which input the variance of a quantity comes from.

A. Saltelli et al., Variance based sensitivity analysis of model output, Comput. Phys. Commun. 181 (2010). Two
independent points A and B a row, and for every input i the point A with its coordinate i from B; first-order indices by
Saltelli's estimator mean(f_B (f_ABi - f_A))/V, total ones by Jansen's mean((f_A - f_ABi)^2)/(2 V), both SciPy's.
"""

from typing import NamedTuple

import numpy as np
from scipy import stats

from bearing_twin.errors import StatisticError, StudyError
from bearing_twin.uq.inputs import Joint

RESAMPLES = 500
FEWEST_ROWS = 16
TOGETHER = 2**16  # values that resamples of the bootstrap may hold together, or one resample where that is more
COPIES = 6  # of them, while indices are made


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


def values_held(rows: int, inputs: int) -> int:
    """How many numbers `sobol_indices` holds at once, at most, besides what it is given."""
    return COPIES * max(TOGETHER, _power_of_two(rows) * (inputs + 2)) + rows * (inputs + 2)


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
    count, width = kept.shape
    found = stats.bootstrap(
        (np.arange(count),),
        lambda rows, axis: _indices(kept, rows),
        n_resamples=resamples,
        batch=max(1, TOGETHER // (_power_of_two(count) * width)),
        vectorized=True,
        confidence_level=confidence,
        method="percentile",  # the default, BCa, takes count^2 rows
        random_state=np.random.default_rng(seed),
    ).confidence_interval
    first, total = _indices(kept, np.arange(count))
    intervals = np.stack([found.low, found.high], axis=-1)
    return SobolIndices(first, intervals[0], total, intervals[1], count)


def _indices(values, rows):
    """First-order and total indices (2, d, ...) of the complete rows chosen by `rows` (..., n).

    SciPy wants a power of two of them: the first are counted twice to reach it. That is right on average, and the error
    is at worst that of a ninth fewer rows. The page that is there twice keeps it from failing with a single input.
    """
    inputs, shape = values.shape[1] - 2, rows.shape[:-1]
    size = _power_of_two(rows.shape[-1])
    rows = np.take(rows, np.arange(size), axis=-1, mode="wrap").reshape(-1, size)
    columns = np.moveaxis(values[rows], -1, 0)
    pages = columns[[*range(2, 2 + inputs), 2]]
    found = stats.sobol_indices(func={"f_A": columns[0], "f_B": columns[1], "f_AB": pages}, n=size)
    both = np.array([found.first_order, found.total_order]).reshape(2, -1, inputs + 1)[..., :inputs]
    return np.moveaxis(both, 1, -1).reshape(2, inputs, *shape)


def _power_of_two(count):
    """The least power of two that is not below `count`."""
    return 1 << (count - 1).bit_length()
