"""Where histories come together: the instant of least deviation after the peak of their mean (paper 3, figure 17)."""

from typing import NamedTuple

import numpy as np

from bearing_twin.errors import StatisticError
from bearing_twin.uq.histories import ROWS, complete
from bearing_twin.uq.modality import modality

OVER = 0.25  # of the peak of the mean: below it only those that last longest are left, and deviation falls to zero
RESAMPLES = 200
FEWEST = 50  # histories


class Narrowing(NamedTuple):
    """The instant [s] of least deviation with its 95 % interval, and mean, deviation and modes of the values there."""

    time: float
    low: float
    high: float
    mean: float
    std: float
    modes: int
    p_value: float


def narrowing(times: np.ndarray, histories: np.ndarray, seed: int = 0) -> Narrowing:
    """The narrowing of histories (n, t), rows with a NaN left out; the interval by bootstrap over the rows.

    The modes are those at the nearest of `times`, their p-value that of one mode at most (see `modality`). Raises
    StatisticError for fewer than FEWEST histories, or where no instant after the peak has the least deviation.
    """
    kept = complete(histories)
    if len(kept) < FEWEST:
        raise StatisticError(f"a narrowing needs {FEWEST} histories at least, there are {len(kept)}")
    found, low, high = least_instant(times, kept, seed)
    place = int(np.argmin(np.abs(times - found)))
    there = kept[:, place]
    modes = modality(there, seed)
    return Narrowing(found, low, high, float(there.mean()), float(there.std(ddof=1)), modes.modes, modes.p_value)


def least_instant(times: np.ndarray, kept: np.ndarray, seed: int = 0) -> tuple[float, float, float]:
    """The instant [s] of least deviation of histories (n, t) without NaN, and its 95 % interval by bootstrap.

    Memory: RESAMPLES n bytes beside the histories.
    Raises StatisticError where there is none.
    """
    found = _least(times, kept.mean(axis=0), kept.std(axis=0, ddof=1))
    random, count = np.random.default_rng(seed), len(kept)
    # Moments of a resample are sums over rows, each as often as it was drawn.
    drawn = np.empty((RESAMPLES, count), np.uint8)
    for row in drawn:
        row[:] = np.bincount(random.integers(count, size=count), minlength=count)
    means, squares = np.zeros((2, RESAMPLES, len(times)))
    for first in range(0, count, ROWS):
        weights, block = drawn[:, first : first + ROWS] / count, kept[first : first + ROWS]
        means += weights @ block
        squares += weights @ block**2
    spreads = np.sqrt(np.maximum(squares - means**2, 0.0))
    again = [_least(times, mean, spread) for mean, spread in zip(means, spreads, strict=True)]
    if np.isnan(found) or np.mean(np.isnan(again)) > 0.05:
        raise StatisticError("no instant after the peak of the mean has a least deviation")
    low, high = np.nanquantile(again, [0.025, 0.975])
    return float(found), float(low), float(high)


def _least(times, mean, spread) -> float:
    """The lowest inner minimum of the spread, by a parabola through three points; NaN where there is none."""
    first = int(np.argmax(mean))
    last = int(np.flatnonzero(mean >= OVER * mean[first])[-1])
    inner = spread[first : last + 1]
    if len(inner) < 3:
        return np.nan
    lowest = int(np.argmin(inner))
    if lowest in (0, len(inner) - 1):
        return np.nan
    before, here, after = inner[lowest - 1 : lowest + 2]
    bend = before - 2.0 * here + after
    shift = 0.5 * (before - after) / bend if bend > 0.0 else 0.0
    return float(np.interp(first + lowest + shift, np.arange(len(times)), times))
