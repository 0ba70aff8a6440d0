"""Mean, deviation and skewness of a sample with their influence functions, summed piece by piece.

A piece stays in the processor's cache with what is reckoned of it; arrays as long as a sample of a million, made and
let go for each product, take two to four times as long.
"""

import functools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy import fft, stats

from bearing_twin.base.errors import StatisticError, StudyError
from bearing_twin.base.parameters import echo, unknown
from bearing_twin.base.stopping import look
from bearing_twin.uq.inputs import Joint

PIECE = 2**13  # numbers


def sums(sample: np.ndarray, of: Callable[[np.ndarray], tuple[np.ndarray, ...]]) -> list[float]:
    """Sums over a sample (n,) of each array that `of` makes of a piece of it."""
    rows = [list(map(np.add.reduce, of(sample[first : first + PIECE]))) for first in range(0, len(sample), PIECE)]
    return [math.fsum(column) for column in zip(*rows, strict=True)]


def powers(piece: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Squares, cubes and fourth powers; a general power takes ten times as long."""
    squares = piece * piece
    return squares, squares * piece, squares * squares


def moment(sample: np.ndarray, name: str, replicates: int = 1) -> tuple[float, Callable[[np.ndarray], np.ndarray]]:
    """Value and influence function of mean, std or skewness of a sample (n,); raises StatisticError for equal values.

    mean: x - m;  std: sigma (z^2 - 1)/2;  skewness g: z^3 - 3 z - g - (3/2) g (z^2 - 1), with z = (x - m)/sigma: a
    function of any part of the sample, whose mean over all of it is 0.
    Replicates spread their points evenly: n in the denominator of std is right for them, n - 1 for independent ones.
    """
    count, mean = len(sample), float(np.mean(sample))
    if name == "mean":
        return mean, lambda part: part - mean
    [square] = sums(sample, lambda part: ((part - mean) ** 2,))
    every, std = math.sqrt(square / count), math.sqrt(square / (count - int(replicates == 1)))
    if std <= 1e-14 * abs(mean):
        if name == "std":
            return std, np.zeros_like
        raise StatisticError("all samples are equal")
    if name == "std":
        return std, lambda part: 0.5 * std * (((part - mean) / every) ** 2 - 1.0)
    look()
    [cube] = sums(sample, lambda part: (_cubes((part - mean) / every),))
    skewness = cube / count

    def influence(part):
        z = (part - mean) / every
        return _cubes(z) - 3.0 * z - skewness - 1.5 * skewness * (z**2 - 1.0)

    return skewness, influence


def _cubes(z: np.ndarray) -> np.ndarray:
    return z * z * z


# Statistics of a sample, each with the interval it is known to; densities that keep inside their bounds.
#
# A sample is an array (n,) in the unit of the quantity; NaN marks a failed realisation and is left out. Intervals
# come
#
# * of moments and indices from the scatter of their influence functions (for the deviation this is the standard error
# sigma sqrt((kurtosis - 1)/(4 n))): over independent points, or between the means over `replicates` interleaved
# randomisations (`sampling`). Student's t is bent by Hall's cubic, for the influence has a skewness;
# * of quantiles from order statistics and the binomial distribution, which needs no density; from replicates that
# hold
# FAR_OUT points beyond the quantile, from the scatter between these.
#
# How often intervals hold the truth is measured by `bearing_twin chart coverage`. Where few points far out decide, it
# is
# less than 95 %: `safe` tells.

FEWEST = {"mean": 2, "std": 4, "skewness": 8, "quantile": 1}
MOMENTS = ("mean", "std", "skewness")
LEAST_BINS, GREATEST_BINS = 512, 2**16
BINS_PER_BANDWIDTH = 8
GREATEST_HISTOGRAM = 400
REFLECTIONS = {"even": (fft.dct, fft.idct, 0), "odd": (fft.dst, fft.idst, 1)}  # transform, back, first wave
FEWEST_EFFECTIVE = {"mean": 8.0, "std": 12.0, "skewness": 60.0}  # points over kurtosis of the influence
HEAVIEST = 50.0  # kurtosis of the influence
FAR_OUT = 4.0  # points of a replicate beyond a quantile
WIDER = 1.15
CONFIDENCE = 0.95  # of every interval
MORE = "ask for more samples"
NONE_SEEN = 3.7  # expected samples at most, with 97.5 %, where none is seen


class Estimate(NamedTuple):
    """A statistic and its interval [low, high], infinite where the sample is too small to bound it.

    `basis` says what the interval comes from: moments, order statistics, replicates or kernel. `safe` is False where
    the points are too few for the tails of the sample, so that the interval holds the truth less often than it says.
    """

    value: float
    low: float
    high: float
    basis: str
    safe: bool = True

    @property
    def half_width(self) -> float:
        return 0.5 * (self.high - self.low)


class Density(NamedTuple):
    """A density (m,) [1/unit of x] at the evenly spaced x (m,), and its bandwidth."""

    x: np.ndarray
    density: np.ndarray
    bandwidth: float


def estimate(sample, statistic, replicates=1) -> Estimate:
    """The statistic of a sample with its interval; `statistic` is mean, std, skewness or a probability in (0, 1).

    A probability asks for that quantile (median-unbiased between order statistics).
    Raises StatisticError for an unknown statistic, too few samples or a skewness of equal values.
    """
    look()
    statistic = _statistic(statistic)
    every = np.ascontiguousarray(sample, float)
    good = np.isfinite(every)
    kept = every if good.all() else every[good]
    name = statistic if statistic in MOMENTS else "quantile"
    if len(kept) < FEWEST[name] * replicates:
        raise StatisticError(f"the {name} needs {FEWEST[name] * replicates} samples at least, not {len(kept)}; {MORE}")
    fewest = min(np.count_nonzero(good[first::replicates]) for first in range(replicates))
    if fewest < 2 and replicates > 1:
        raise StatisticError(f"each of the {replicates} replicates needs 2 samples at least; {MORE}")
    if name == "quantile" and (replicates == 1 or fewest * min(statistic, 1.0 - statistic) < FAR_OUT):
        return _quantile(kept, statistic)
    if name == "quantile":
        # Hazen's rule is right for points spread evenly; taken from all at once it would throw the even spread away.
        parts = [every[first::replicates][good[first::replicates]] for first in range(replicates)]
        hazen = functools.partial(np.quantile, q=statistic, axis=-1, method="hazen")
        found = hazen(parts) if fewest * replicates == len(kept) else np.array([hazen(part) for part in parts])
        return interval(float(found.mean()), found - found.mean(), replicates)
    value, influence = moment(kept, statistic, replicates)
    if replicates == 1:
        found = sums(kept, lambda piece: powers(influence(piece)))
        return _interval(value, len(kept), found, FEWEST_EFFECTIVE[statistic])
    spread = np.full(len(every), np.nan)
    spread[good] = influence(kept)
    return interval(value, spread, replicates, FEWEST_EFFECTIVE[statistic])


def interval(value, influence, replicates=1, least=0.0) -> Estimate:
    """The interval of a statistic from its influence function (n,), NaN where a point failed, mean 0 over the others.

    Point i belongs to replicate i % replicates; raises StatisticError where all points of one failed. P. Hall, On the
    removal of skewness by transformation, J. R. Stat. Soc. B 54 (1992): with g the skewness, T + g T^2/3 + g^2 T^3/27
    + g/(6 n) is nearly Student's t. Of replicates, a few numbers whose skewness is hardly known, it is widened by
    WIDER. Unsafe below `least` effective points n / kurtosis and, for replicates, above a kurtosis of HEAVIEST: only
    tails are left to err there, whatever n.
    """
    look()
    good = np.isfinite(influence)
    kept = influence if good.all() else influence[good]
    if replicates == 1:
        return _interval(value, len(kept), sums(kept, powers), least)
    parts = [influence[first::replicates][good[first::replicates]] for first in range(replicates)]
    if not all(map(len, parts)):
        raise StatisticError(f"each of the {replicates} replicates needs a sample at least; {MORE}")
    return _interval(value, len(kept), sums(kept, powers), least, np.array([part.mean() for part in parts]))


def _interval(value, count, found, least, parts=None) -> Estimate:
    """`interval` by the sums of squares, cubes and fourth powers of the influence, and its means over replicates."""
    square = found[0] / count
    heavy = found[2] / count / square**2 if square > 0.0 else 0.0
    safe = bool(heavy * least <= count and (parts is None or heavy <= HEAVIEST))
    if parts is not None:
        count, found = len(parts), sums(parts - parts.mean(), powers)
    spread, basis = math.sqrt(found[0] / count), "moments" if parts is None else "replicates"
    if spread == 0.0:
        return Estimate(value, value, value, basis, safe)
    skewness = found[1] / count / spread**3 * math.sqrt(count * (count - 1.0)) / max(count - 2.0, 1.0)
    score = _student(count - 1) / math.sqrt(count)
    error = spread * math.sqrt(count / (count - 1.0))
    if parts is not None:
        score *= WIDER
    ends = (value - error * _unbent(one - skewness / (6.0 * count), skewness / 3.0) for one in (score, -score))
    return Estimate(value, *ends, basis, safe)


@functools.lru_cache(maxsize=256)  # a study asks for the same again and again, and SciPy takes longer than all the rest
def _student(freedom: int) -> float:
    """Half width of the interval of Student's t that holds the share CONFIDENCE."""
    return float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, freedom))


def _unbent(bent: float, a: float) -> float:
    """T of which T + a T^2 + a^2 T^3/3 is `bent`."""
    return (math.cbrt(1.0 + 3.0 * a * bent) - 1.0) / a if abs(a) > 1e-8 else bent


def half_width(sample, statistic, replicates=1) -> float:
    """Half the width of the statistic's interval, what a stop rule watches; inf where there is no interval yet."""
    try:
        return estimate(sample, statistic, replicates).half_width
    except StatisticError:
        _statistic(statistic)  # a wrong name stays an error
        return math.inf


def _statistic(statistic):
    """The name of a moment, or a probability as a float."""
    if isinstance(statistic, str) and statistic in MOMENTS:
        return statistic
    try:
        probability = float(statistic)
    except (TypeError, ValueError):
        probability = math.nan
    if not 0.0 < probability < 1.0:
        raise StatisticError(
            f"{echo(statistic)} is no statistic; {unknown(statistic, MOMENTS)}, or a probability between 0 and 1"
        )
    return probability


@functools.lru_cache(maxsize=256)
def _ranks(count: int, probability: float) -> tuple[int, int]:
    """Order statistics r and s with P(r <= number below the quantile < s) >= CONFIDENCE, split evenly."""
    outside = 0.5 * (1.0 - CONFIDENCE)
    low, high = stats.binom.ppf([outside, 1.0 - outside], count, probability)
    return int(low), int(high) + 1


def _quantile(sample, probability):
    count = len(sample)
    below, above = _ranks(count, probability)
    ordered = sample if np.all(sample[1:] >= sample[:-1]) else np.sort(sample)
    look()
    low = float(ordered[below - 1]) if below >= 1 else -math.inf
    high = float(ordered[above - 1]) if above <= count else math.inf
    place = min(max(count * probability + (probability - 2.0) / 3.0, 0.0), count - 1.0)
    near = ordered[int(place) : int(place) + 2]
    value = float(near[0] + (place - int(place)) * (near[-1] - near[0]))
    return Estimate(value, low, high, "order statistics")


def histogram(sample, bins="fd"):
    """Edges (m + 1,) and density (m,) of a histogram, of Freedman and Diaconis' width by default, at most 400 bins."""
    kept = _kept(sample, 1)
    edges = np.histogram_bin_edges(kept, bins=bins)
    if len(edges) - 1 > GREATEST_HISTOGRAM:
        edges = np.histogram_bin_edges(kept, bins=GREATEST_HISTOGRAM)
    density, edges = np.histogram(kept, bins=edges, density=True)
    return edges, density


def density(sample, low=-math.inf, kind="even") -> Density:
    """Kernel estimate of a density above `low`, with a mass of exactly 1 there.

    `even` puts back what a normal kernel would spread below it (slope 0 there), `odd` takes away as much (0 there). The
    bandwidth is Silverman's. Raises StatisticError for equal samples, or samples below `low`.
    """
    kept = _kept(sample, 2)
    if kept.min() < low:
        raise StatisticError(f"samples lie below the bound {low:g} of the density")
    if kind not in REFLECTIONS:
        raise StatisticError(f"{echo(kind)} is no kind of density; {unknown(kind, REFLECTIONS)}")
    bandwidth = silverman_bandwidth(kept)
    low, high = max(low, kept.min() - 6.0 * bandwidth), kept.max() + 6.0 * bandwidth
    bins = int(np.clip(BINS_PER_BANDWIDTH * (high - low) / bandwidth, LEAST_BINS, GREATEST_BINS))
    bins = fft.next_fast_len(bins, real=True)
    width = (high - low) / bins
    smooth = smoothed(binned(kept, low, high, bins), bandwidth / width, kind)
    x = low + (np.arange(bins) + 0.5) * width
    return Density(x, np.maximum(smooth, 0.0) / (np.sum(np.maximum(smooth, 0.0)) * width), bandwidth)


def natural_density(sample) -> Density:
    """`density` of the kind that suits a sample: 0 at 0 where it is positive; else bounded by a 0 in it.

    A quantity that is positive and yet has a density at 0 is underestimated there.
    """
    least = _kept(sample, 2).min()
    return density(sample, 0.0 if least >= 0.0 else -math.inf, kind="odd" if least > 0.0 else "even")


def densities_at(sample, values) -> list[Estimate]:
    """`natural_density` at `values`, with what the scatter of the sample leaves open of it (not the kernel's bias).

    The variance is f / (2 sqrt(pi) n b), b being the bandwidth (B. W. Silverman, Density Estimation, 1986, 3.3).
    Where no sample is near, the upper end is that of NONE_SEEN samples.
    """
    found, kept, values = natural_density(sample), _kept(sample, 2), np.asarray(values, float)
    heights = np.interp(values, found.x, found.density, left=0.0, right=0.0)
    one = 1.0 / (2.0 * math.sqrt(math.pi) * len(kept) * found.bandwidth)  # of one sample
    half = float(stats.norm.ppf(0.5 + 0.5 * CONFIDENCE)) * np.sqrt(heights * one)
    possible = NONE_SEEN * one * ((values > 0.0) | (kept.min() < 0.0))
    low, high = np.maximum(heights - half, 0.0), np.maximum(heights + half, possible)
    return [Estimate(*row, "kernel") for row in zip(heights.tolist(), low.tolist(), high.tolist(), strict=True)]


def silverman_bandwidth(sample) -> float:
    """0.9 min(std, interquartile range/1.34) n^(-1/5), no NaN in the sample; StatisticError for equal values."""
    std = float(np.std(sample, ddof=1))
    if std <= 1e-14 * abs(float(np.mean(sample))):
        raise StatisticError("all samples are equal: there is no density")
    quarter, three = np.quantile(sample, [0.25, 0.75])
    spread = min(std, (three - quarter) / 1.34) or std
    return 0.9 * spread * len(sample) ** -0.2


def binned(sample, low, high, bins):
    """Number of samples (bins,) in each of the equal bins from low to high; those on `high` go to the last."""
    place = np.floor((np.asarray(sample) - low) * (bins / (high - low))).astype(int)
    return np.bincount(np.clip(place, 0, bins - 1), minlength=bins).astype(float)


def smoothed(counts, bandwidth, kind="even"):
    """Counts (.., m) spread by a normal kernel of `bandwidth` [bins], reflected at both ends; of `even` the sum stays.

    This is the heat equation, with insulated ends by cosines, with cold ones (odd) by sines, so the number of modes
    never grows with the bandwidth.
    """
    size = counts.shape[-1]
    there, back, first = REFLECTIONS[kind]
    damping = np.exp(-0.5 * (math.pi * bandwidth / size * np.arange(first, first + size)) ** 2)
    return back(there(counts, axis=-1) * damping, axis=-1)


def _kept(sample, fewest):
    look()
    sample = np.asarray(sample, float)
    kept = sample[np.isfinite(sample)]
    if len(kept) < fewest:
        raise StatisticError(f"a density needs {fewest} samples at least, there are {len(kept)}; {MORE}")
    return kept


# Sobol indices by sampling: which input the variance of a quantity comes from.
#
# A. Saltelli et al., Variance based sensitivity analysis of model output, Comput. Phys. Commun. 181 (2010). Two
# independent points A and B a row, and for every input i the point A with its coordinate i from B; first-order indices
# by Saltelli's estimator mean(f_B (f_ABi - f_A))/V, total ones by Jansen's mean((f_A - f_ABi)^2)/(2 V).
# `scipy.stats.sobol_indices` has the same estimators, but takes only a power of two of rows and no NaN, and knows of no
# replicates of a design: where a realisation fails, or a study is cut off, there would be no indices. Tests compare
# both.

FEWEST_ROWS = 16
EFFECTIVE_ROWS = {"independent": 40.0, "replicates": 20.0}  # rows over kurtosis of the influence


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
    least = EFFECTIVE_ROWS["independent" if replicates == 1 else "replicates"]
    for terms in (off[:, [1]] * moved, 0.5 * moved**2):
        index = terms.mean(axis=0) / variance
        influence = np.full((len(values), len(index)), np.nan)
        # The mean, too, is the sample's; what it errs by is of second order.
        influence[whole] = (terms - index * squares) / variance
        ends = [interval(*one, replicates, least) for one in zip(index, influence.T, strict=True)]
        found += [index, np.array([one[1:3] for one in ends]), np.array([one.safe for one in ends])]
    return SobolIndices(*found, len(kept))
