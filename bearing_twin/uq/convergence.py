"""How mean and deviation close in on the truth as samples are added (paper 3, figures 9 and 14).

One path tells little: it crosses the truth many times before it stays near. The band says what paths do together.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.special import ndtri

from bearing_twin.errors import StatisticError
from bearing_twin.uq.change_of_variable import Derived


class Paths(NamedTuple):
    """After `counts` (m,) samples the `mean` and the deviation `std` (.., m) of the samples so far."""

    counts: np.ndarray
    mean: np.ndarray
    std: np.ndarray


class HalfWidths(NamedTuple):
    """Half widths (m,) of the bands about the true mean and the true deviation, in the unit of the quantity."""

    mean: np.ndarray
    std: np.ndarray


def paths(samples) -> Paths:
    """Mean and deviation (n - 1 in its denominator) of the first 2, 3, .. n of samples (.., n), along the last axis.

    Raises StatisticError below two samples, or where one is not finite: then a path has no order.
    """
    samples = np.asarray(samples, float)
    count = samples.shape[-1] if samples.ndim else 0
    if count < 2 or not np.isfinite(samples).all():
        raise StatisticError(f"a path needs 2 finite samples at least, there are {count}; leave failed ones out")
    counts = np.arange(1, count + 1)
    middle = samples.mean(axis=-1, keepdims=True)  # sums of differences from it lose no digits
    sums = np.cumsum(samples - middle, axis=-1)
    squares = np.cumsum((samples - middle) ** 2, axis=-1)
    variance = np.maximum(squares - sums**2 / counts, 0.0)[..., 1:] / (counts[1:] - 1)
    return Paths(counts[1:], (middle + sums / counts)[..., 1:], np.sqrt(variance))


def half_widths(exact: Derived, counts, confidence=0.95) -> HalfWidths:
    """Half the width in which the share `confidence` of all estimates from that many independent samples lies.

    It is sigma/sqrt(n) for the mean, sigma sqrt((kurtosis - 1)/(4 n)) for the deviation, times the normal quantile. For
    large n: below some hundred samples of a skewed quantity the deviation is low more often than high. Raises
    StatisticError where a moment that is needed does not exist.
    """
    score = float(ndtri(0.5 + 0.5 * confidence))
    root = np.sqrt(np.asarray(counts, float))
    return HalfWidths(score * exact.std / root, score * exact.std * 0.5 * math.sqrt(exact.kurtosis - 1.0) / root)
