"""Statistics of a sample with 95 % intervals, kernel densities within their bounds, and Sobol indices.

A sample is an array (n,) in the unit of the quantity; NaN marks a failed realisation and is left out. Intervals come

* of mean and standard deviation from the scatter of their influence functions (for the standard deviation this is the
  standard error sigma sqrt((kurtosis - 1)/(4 n))): over independent points, or between the means over `replicates`
  interleaved randomisations (`sampling`). Student's t is corrected for skewness by Hall's cubic;
* of quantiles from order statistics, between which is interpolated, and the binomial distribution, which needs no
  density; from replicates that hold FAR_OUT points beyond the quantile, from the scatter between these.

The skewness has no interval: its influence function grows as z^3, and 95 % intervals of it held the true value in 14 to
95 % of studies. `bearing_twin chart coverage` measures the others; where a few points far out decide, coverage is less
than 95 %, and `safe` is False.
"""

import functools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import fft, stats
from scipy.optimize import brentq
from scipy.special import betainc

from bearing_twin.base.errors import StatisticError, StudyError
from bearing_twin.base.stopping import stop_if_requested
from bearing_twin.uq.inputs import Joint

MOMENTS = ("mean", "std", "skewness")
FEWEST = {"mean": 2, "std": 4, "skewness": 8, "quantile": 1}  # samples
FEWEST_EFFECTIVE = {"mean": 8.0, "std": 12.0}  # samples over kurtosis of the influence, below which it is unsafe
HEAVIEST = 50.0  # kurtosis of the influence, above which intervals from replicates are unsafe
FAR_OUT = 3.0  # points of a replicate beyond a quantile
WIDER = 1.15  # of intervals from replicates, whose skewness is that of a few numbers
CONFIDENCE = 0.95
TAIL = 0.5 * (1.0 - CONFIDENCE)
TOO_FEW, MORE = "samples are too few", "take 64 or more"  # which give every statistic, by any sampler
LEAST_BINS, GREATEST_BINS = 512, 2**16
BINS_PER_BANDWIDTH = 8
GREATEST_HISTOGRAM = 400
REFLECTIONS = {"even": (fft.dct, fft.idct, 0), "odd": (fft.dst, fft.idst, 1)}  # transform, inverse, first wave
NONE_SEEN = 3.7  # upper 97.5 % bound of the expected number of samples where none is seen


class Estimate(NamedTuple):
    """A statistic and its interval [low, high], infinite where there is none or the sample is too small to bound it.

    `safe` is False where the sample is too small for its tails, so that the interval holds the true value less often
    than it says.
    """

    value: float
    low: float
    high: float
    safe: bool = True

    @property
    def half_width(self) -> float:
        return 0.5 * (self.high - self.low)


def estimate(sample, statistic, replicates: int = 1) -> Estimate:
    """A statistic of a sample with its 95 % interval.

    Parameters
    ----------
    sample : array_like (n,)
        NaN are left out.
    statistic : str or float
        mean, std or skewness, or the probability of a quantile (median-unbiased between order statistics).
    replicates : int
        Point i belongs to replicate i % replicates. Replicates spread their points evenly: n in the denominator of
        their std, n - 1 of independent points.

    Raises
    ------
    StatisticError
        For too few samples, or the skewness of equal values.
    """
    stop_if_requested()
    every = np.ascontiguousarray(sample, float)
    good = np.isfinite(every)
    kept = every if good.all() else every[good]
    name = statistic if statistic in MOMENTS else "quantile"
    fewest = min(np.count_nonzero(good[first::replicates]) for first in range(replicates))
    if len(kept) < FEWEST[name] * replicates or (replicates > 1 and fewest < 2):
        raise StatisticError(f"{len(kept)} {TOO_FEW}; {MORE}")
    if name == "quantile":
        if replicates == 1 or fewest * min(statistic, 1.0 - statistic) < FAR_OUT:
            return _quantile(kept, statistic)
        # Hazen's rule suits evenly spread points; of all points at once it would lose the even spread.
        parts = (every[first::replicates][good[first::replicates]] for first in range(replicates))
        found = np.array([np.quantile(part, statistic, method="hazen") for part in parts])
        return interval(float(found.mean()), found - found.mean(), replicates)
    mean, std = float(np.mean(kept)), float(np.std(kept))
    if name == "mean":
        value, influence = mean, kept - mean
    elif name == "std":
        value = std if replicates > 1 else std * math.sqrt(len(kept) / (len(kept) - 1.0))
        flat = std <= 1e-14 * abs(mean)
        influence = np.zeros_like(kept) if flat else 0.5 * value * (((kept - mean) / std) ** 2 - 1.0)
    elif std <= 1e-14 * abs(mean):
        raise StatisticError("all samples are equal")
    else:
        z = (kept - mean) / std
        return Estimate(float(np.mean(z * z * z)), -math.inf, math.inf)
    if replicates > 1:
        influence, found = np.full(len(every), np.nan), influence
        influence[good] = found
    return interval(value, influence, replicates, FEWEST_EFFECTIVE[name])


def interval(value: float, influence: np.ndarray, replicates: int = 1, least: float = 0.0) -> Estimate:
    """The interval of a statistic from its influence function (n,), NaN where a point failed, with mean 0.

    P. Hall, On the removal of skewness by transformation, J. R. Stat. Soc. B 54 (1992): with g the skewness,
    T + g T^2/3 + g^2 T^3/27 + g/(6 n) is nearly Student's t. Unsafe below `least` effective points n / kurtosis and,
    for replicates, above a kurtosis of HEAVIEST. Raises StatisticError where all points of one replicate failed.
    """
    stop_if_requested()
    good = np.isfinite(influence)
    kept = influence if good.all() else influence[good]
    square = kept * kept
    variance = float(np.mean(square))
    heavy = float(np.mean(square * square)) / variance**2 if variance > 0.0 else 0.0
    safe = heavy * least <= len(kept) and (replicates == 1 or heavy <= HEAVIEST)
    if replicates > 1:
        parts = [influence[first::replicates][good[first::replicates]] for first in range(replicates)]
        if not all(map(len, parts)):
            raise StatisticError(f"each of the {replicates} replicates needs a sample at least; {MORE}")
        kept = np.array([part.mean() for part in parts])
        kept -= kept.mean()
        square = kept * kept
        variance = float(np.mean(square))
    if variance == 0.0:
        return Estimate(value, value, value, safe)
    count, spread = len(kept), math.sqrt(variance)
    skewness = float(np.mean(square * kept)) / spread**3 * math.sqrt(count * (count - 1.0)) / max(count - 2.0, 1.0)
    score = _student(count - 1) / math.sqrt(count) * (WIDER if replicates > 1 else 1.0)
    error, a = spread * math.sqrt(count / (count - 1.0)), skewness / 3.0
    ends = [one - 0.5 * a / count for one in (score, -score)]
    if abs(a) > 1e-8:  # the inverse of T + a T^2 + a^2 T^3/3
        ends = [(math.cbrt(1.0 + 3.0 * a * one) - 1.0) / a for one in ends]
    return Estimate(value, *(value - error * one for one in ends), safe)


@functools.lru_cache(maxsize=256)  # SciPy's ppf takes longer than all the rest of an interval
def _student(freedom: int) -> float:
    return float(stats.t.ppf(1.0 - TAIL, freedom))


@functools.lru_cache(maxsize=256)
def _ranks(count: int, probability: float) -> tuple[float, float]:
    """Ranks of the order statistics that bound a quantile with CONFIDENCE, split evenly; below 1 or above n: open.

    A. D. Hutson, Calculating nonparametric confidence intervals for quantiles using fractional order statistics,
    J. Appl. Stat. 26 (1999): P(X_(r) < quantile) = I_p(r, n + 1 - r), solved for real r. Whole ranks cover up to 99 %.
    """

    def root(share: float) -> float:
        def excess(rank):
            return betainc(rank, count + 1.0 - rank, probability) - share

        if excess(1.0) <= 0.0 or excess(float(count)) >= 0.0:
            return 0.0 if excess(1.0) < 0.0 else count + 1.0
        return brentq(excess, 1.0, float(count))

    return min(root(1.0 - TAIL), float(count)), max(root(TAIL), 1.0)


def _quantile(sample: np.ndarray, probability: float) -> Estimate:
    count, (below, above) = len(sample), _ranks(len(sample), probability)
    ordered = sample if np.all(sample[1:] >= sample[:-1]) else np.sort(sample)

    def at(rank: float) -> float:
        near = ordered[int(rank) - 1 : int(rank) + 1]
        return float(near[0] + (rank - int(rank)) * (near[-1] - near[0]))

    value = at(min(max(count * probability + (probability + 1.0) / 3.0, 1.0), count))
    return Estimate(value, at(below) if below >= 1.0 else -math.inf, at(above) if above <= count else math.inf)


def histogram(sample) -> tuple[np.ndarray, np.ndarray]:
    """Edges (m + 1,) and density (m,) of a histogram, of Freedman and Diaconis' width, at most 400 bins."""
    kept = _kept(sample, 1)
    edges = np.histogram_bin_edges(kept, "fd")
    density, edges = np.histogram(kept, min(len(edges) - 1, GREATEST_HISTOGRAM), density=True)
    return edges, density


class Density(NamedTuple):
    """A density (m,) [1/unit of x] at the evenly spaced x (m,), and its bandwidth."""

    x: np.ndarray
    density: np.ndarray
    bandwidth: float


def kernel_density(sample) -> Density:
    """Kernel estimate of a density with Silverman's bandwidth, of mass 1 within its bounds.

    A positive sample has the density 0 at 0 (what a normal kernel would spread below is taken away), one that holds 0
    has no slope there (it is put back), one with negative values no bound. A quantity that is positive and yet has a
    density at 0 is underestimated there. Raises StatisticError for equal samples.
    """
    kept = _kept(sample, 2)
    bandwidth, least = silverman_bandwidth(kept), kept.min()
    low, high = least - 6.0 * bandwidth, kept.max() + 6.0 * bandwidth
    low = max(low, 0.0) if least >= 0.0 else low
    bins = int(np.clip(BINS_PER_BANDWIDTH * (high - low) / bandwidth, LEAST_BINS, GREATEST_BINS))
    bins = fft.next_fast_len(bins, real=True)
    width = (high - low) / bins
    smooth = smoothed(binned(kept, low, high, bins), bandwidth / width, "odd" if least > 0.0 else "even")
    smooth = np.maximum(smooth, 0.0)
    return Density(low + (np.arange(bins) + 0.5) * width, smooth / (smooth.sum() * width), bandwidth)


def densities_at(sample, values) -> list[Estimate]:
    """`kernel_density` at `values`, with intervals of the scatter of the sample (not of the kernel's bias).

    The variance is f / (2 sqrt(pi) n b), b being the bandwidth (B. W. Silverman, Density Estimation, 1986, 3.3).
    Where no sample is near, the upper end is that of NONE_SEEN samples.
    """
    found, kept, values = kernel_density(sample), _kept(sample, 2), np.asarray(values, float)
    heights = np.interp(values, found.x, found.density, left=0.0, right=0.0)
    one = 1.0 / (2.0 * math.sqrt(math.pi) * len(kept) * found.bandwidth)  # of one sample
    half = float(stats.norm.ppf(1.0 - TAIL)) * np.sqrt(heights * one)
    possible = NONE_SEEN * one * ((values > 0.0) | (kept.min() < 0.0))
    low, high = np.maximum(heights - half, 0.0), np.maximum(heights + half, possible)
    return [Estimate(*row) for row in zip(heights.tolist(), low.tolist(), high.tolist(), strict=True)]


def silverman_bandwidth(sample: np.ndarray) -> float:
    """0.9 min(std, interquartile range/1.34) n^(-1/5), no NaN in the sample; StatisticError for equal values."""
    std = float(np.std(sample, ddof=1))
    if std <= 1e-14 * abs(float(np.mean(sample))):
        raise StatisticError("all samples are equal: there is no density")
    quarter, three = np.quantile(sample, [0.25, 0.75])
    return 0.9 * (min(std, (three - quarter) / 1.34) or std) * len(sample) ** -0.2


def binned(sample: np.ndarray, low: float, high: float, bins: int) -> np.ndarray:
    """Number of samples (bins,) in each of the equal bins from low to high; those outside go to the ends."""
    place = np.floor((sample - low) * (bins / (high - low))).astype(int)
    return np.bincount(np.clip(place, 0, bins - 1), minlength=bins).astype(float)


def smoothed(counts: np.ndarray, bandwidth: float, kind: str = "even") -> np.ndarray:
    """Counts (.., m) spread by a normal kernel of `bandwidth` [bins], reflected at both ends; of `even` the sum stays.

    This is the heat equation, with insulated ends by cosines, with cold ones (odd) by sines, so the number of modes
    never grows with the bandwidth.
    """
    size = counts.shape[-1]
    there, back, first = REFLECTIONS[kind]
    damping = np.exp(-0.5 * (math.pi * bandwidth / size * np.arange(first, first + size)) ** 2)
    return back(there(counts, axis=-1) * damping, axis=-1)


def _kept(sample, fewest: int) -> np.ndarray:
    stop_if_requested()
    sample = np.asarray(sample, float)
    kept = sample[np.isfinite(sample)]
    if len(kept) < fewest:
        raise StatisticError(f"{len(kept)} {TOO_FEW}; {MORE}")
    return kept


# Sobol indices by sampling: A. Saltelli et al., Variance based sensitivity analysis of model output, Comput. Phys.
# Commun. 181 (2010). Two independent points A and B a row, and for every input i the point A with coordinate i from
# B; first-order indices by Saltelli's estimator mean(f_B (f_ABi - f_A))/V, total ones by Jansen's
# mean((f_A - f_ABi)^2)/(2 V). `scipy.stats.sobol_indices` has the same estimators, but takes only powers of two of rows
# and no NaN, and knows no replicates: where a realisation fails there would be no indices. Tests compare both.

FEWEST_ROWS = 16
EFFECTIVE_ROWS = {"independent": 40.0, "replicates": 20.0}  # rows over kurtosis of the influence


def sensitivity_points(joint: Joint, unit: np.ndarray) -> np.ndarray:
    """Points (n, d + 2, d) of the unit cube to run at, A, B, AB_1 .. AB_d a row, from points (n, 2 d) of a design.

    Raises StudyError for correlated inputs, whose variance has no such parts.
    """
    if not joint.independent:
        raise StudyError("Sobol indices are for independent inputs; leave the correlation out")
    size = joint.dimension
    first, second = unit[:, :size], unit[:, size:]
    points = np.repeat(first[:, None, :], size + 2, axis=1)
    points[:, 1] = second
    for index in range(size):
        points[:, 2 + index, index] = second[:, index]
    return points


def sobol_indices(values: np.ndarray, keys: Sequence[str], replicates: int = 1) -> dict[str, dict]:
    """Indices by input from the quantity (n, d + 2) at `sensitivity_points`; rows with a NaN are left out.

    Row i belongs to replicate i % replicates of the design.

    Returns
    -------
    dict
        For each of the `keys` (d,) its `first` and `total` Estimate. Values a little below 0 or above 1 are noise of
        the sample; they are not cut off.

    Raises
    ------
    StatisticError
        For too few rows, or a quantity that does not vary.
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
    squares = np.mean(off**2, axis=1)
    variance, least = squares.mean(), EFFECTIVE_ROWS["independent" if replicates == 1 else "replicates"]
    found: dict[str, dict] = {key: {} for key in keys}
    for order, terms in (("first", off[:, [1]] * moved), ("total", 0.5 * moved**2)):
        for key, one in zip(keys, terms.T, strict=True):
            index, influence = float(one.mean() / variance), np.full(len(values), np.nan)
            influence[whole] = (one - index * squares) / variance  # the error of the sample's mean is of second order
            found[key][order] = interval(index, influence, replicates, least)
    return found
