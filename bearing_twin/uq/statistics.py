"""Statistics of a sample, each with the interval it is known to; densities that keep inside their bounds.

A sample is an array (n,) in the unit of the quantity; NaN marks a failed realisation and is left out. Intervals come

* from the sample itself, for independent points: moments by the scatter of their influence functions (for the deviation
  this is the standard error sigma sqrt((kurtosis - 1)/(4 n))), quantiles by order statistics and the binomial
  distribution, which needs no density;
* from the scatter between `replicates` interleaved randomisations (`sampling`, sobol) by Student's t.

For a latin hypercube the first kind is used though its points are not independent: it is then too wide. The kurtosis is
the sample's; with heavy tails few samples underestimate it, and the interval of the deviation with it.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy import fft, stats

from bearing_twin.errors import StatisticError
from bearing_twin.parameters import echo, unknown

FEWEST = {"mean": 2, "std": 4, "skewness": 8, "quantile": 1}
MOMENTS = ("mean", "std", "skewness")
LEAST_BINS, GREATEST_BINS = 512, 2**16
BINS_PER_BANDWIDTH = 8
GREATEST_HISTOGRAM = 400
REFLECTIONS = {"even": (fft.dct, fft.idct, 0), "odd": (fft.dst, fft.idst, 1)}  # transform, back, first wave
NONE_SEEN = 3.7  # expected samples at most, with 97.5 %, where none is seen


class Estimate(NamedTuple):
    """A statistic and its interval [low, high], infinite where the sample is too small to bound it.

    `basis` says what the interval comes from: moments, order statistics or replicates.
    """

    value: float
    low: float
    high: float
    basis: str

    @property
    def half_width(self) -> float:
        return 0.5 * (self.high - self.low)


class Density(NamedTuple):
    """A density (m,) [1/unit of x] at the evenly spaced x (m,), and its bandwidth."""

    x: np.ndarray
    density: np.ndarray
    bandwidth: float


def estimate(sample, statistic, confidence=0.95, replicates=1) -> Estimate:
    """The statistic of a sample with its interval; `statistic` is mean, std, skewness or a probability in (0, 1).

    A probability asks for that quantile (median-unbiased between order statistics). std has n - 1 in its denominator.
    Raises StatisticError for an unknown statistic, too few samples or a skewness of equal values.
    """
    statistic = _statistic(statistic)
    every = np.asarray(sample, float)
    kept = every[np.isfinite(every)]
    name = statistic if statistic in MOMENTS else "quantile"
    if len(kept) < FEWEST[name] * replicates:
        raise StatisticError(
            f"the {name} needs {FEWEST[name] * replicates} samples at least, not {len(kept)}; ask for more samples"
        )
    if replicates > 1:
        return _from_replicates(every, kept, statistic, confidence, replicates)
    if name == "quantile":
        return _quantile(np.sort(kept), statistic, confidence)
    value, influence = _moment(kept, statistic)
    error = math.sqrt(np.mean(influence**2) / len(kept))
    half = error * float(stats.t.ppf(0.5 + 0.5 * confidence, len(kept) - 1))
    return Estimate(value, value - half, value + half, "moments")


def half_width(sample, statistic, confidence=0.95, replicates=1) -> float:
    """Half the width of the statistic's interval, what a stop rule watches; inf where there is no interval yet."""
    try:
        return estimate(sample, statistic, confidence, replicates).half_width
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


def _moment(sample, statistic):
    """Value and influence function (n,), mean 0, of a moment.

    mean: x - m;  std: sigma (z^2 - 1)/2;  skewness g: z^3 - 3 z - g - (3/2) g (z^2 - 1), with z = (x - m)/sigma.
    """
    mean = float(np.mean(sample))
    if statistic == "mean":
        return mean, sample - mean
    std = float(np.std(sample, ddof=1))
    if std <= 1e-14 * abs(mean):
        if statistic == "std":
            return std, np.zeros_like(sample)
        raise StatisticError("all samples are equal")
    z = (sample - mean) / float(np.std(sample))
    if statistic == "std":
        return std, 0.5 * std * (z**2 - 1.0)
    cube = z * z * z
    skewness = float(np.mean(cube))
    return skewness, cube - 3.0 * z - skewness - 1.5 * skewness * (z**2 - 1.0)


def _quantile(ordered, probability, confidence):
    """Order statistics r and s with P(r <= number below the quantile < s) >= confidence, split evenly."""
    count, outside = len(ordered), 0.5 * (1.0 - confidence)
    below = int(stats.binom.ppf(outside, count, probability))
    above = int(stats.binom.ppf(1.0 - outside, count, probability)) + 1
    low = float(ordered[below - 1]) if below >= 1 else -math.inf
    high = float(ordered[above - 1]) if above <= count else math.inf
    value = float(np.quantile(ordered, probability, method="median_unbiased"))
    return Estimate(value, low, high, "order statistics")


def _from_replicates(every, kept, statistic, confidence, replicates):
    """The statistic with the scatter of the replicates as its error; point i belongs to replicate i % replicates.

    Moments are those of all samples. Quantiles are means of the replicates' own (Hazen's rule, right for points spread
    evenly): to take them from all samples at once would throw the even spread away. Where a replicate holds no sample
    beyond the quantile, it falls back to the order statistics of all samples, which is conservative.
    """
    parts = [part[np.isfinite(part)] for part in (every[first::replicates] for first in range(replicates))]
    fewest = min(map(len, parts))
    if fewest < 2:
        raise StatisticError(f"each of the {replicates} replicates needs 2 samples at least; ask for more samples")
    if statistic in MOMENTS:
        found = [_moment(part, statistic)[0] for part in parts]
        value = _moment(kept, statistic)[0]
    elif fewest * min(statistic, 1.0 - statistic) < 1.0:
        return _quantile(np.sort(kept), statistic, confidence)
    else:
        found = [float(np.quantile(part, statistic, method="hazen")) for part in parts]
        value = float(np.mean(found))
    half = np.std(found, ddof=1) / math.sqrt(replicates) * float(stats.t.ppf(0.5 + 0.5 * confidence, replicates - 1))
    return Estimate(value, float(value - half), float(value + half), "replicates")


def histogram(sample, bins="fd"):
    """Edges (m + 1,) and density (m,) of a histogram, of Freedman and Diaconis' width by default, at most 400 bins."""
    kept = _kept(sample, 1)
    edges = np.histogram_bin_edges(kept, bins=bins)
    if len(edges) - 1 > GREATEST_HISTOGRAM:
        edges = np.histogram_bin_edges(kept, bins=GREATEST_HISTOGRAM)
    density, edges = np.histogram(kept, bins=edges, density=True)
    return edges, density


def density(sample, low=-math.inf, high=math.inf, bandwidth=None, kind="even") -> Density:
    """Kernel estimate of a density on [low, high], with a mass of exactly 1 between these bounds.

    `even` puts back what a normal kernel would spread beyond a bound (slope 0 there), `odd` takes away as much (0
    there). `bandwidth` [unit of x] defaults to Silverman's rule 0.9 min(std, IQR/1.34) n^(-1/5). Raises StatisticError
    for equal samples, or samples outside the bounds.
    """
    kept = _kept(sample, 2)
    if kept.min() < low or kept.max() > high:
        raise StatisticError(f"samples lie outside the bounds {low:g} and {high:g} of the density")
    if kind not in REFLECTIONS:
        raise StatisticError(f"{echo(kind)} is no kind of density; {unknown(kind, REFLECTIONS)}")
    bandwidth = silverman_bandwidth(kept) if bandwidth is None else bandwidth
    low = max(low, kept.min() - 6.0 * bandwidth)
    high = min(high, kept.max() + 6.0 * bandwidth)
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


def densities_at(sample, values, confidence=0.95) -> list[Estimate]:
    """`natural_density` at `values`, with what the scatter of the sample leaves open of it (not the kernel's bias).

    The variance is f / (2 sqrt(pi) n b), b being the bandwidth (B. W. Silverman, Density Estimation, 1986, 3.3).
    Where no sample is near, the upper end is that of NONE_SEEN samples.
    """
    found, kept, values = natural_density(sample), _kept(sample, 2), np.asarray(values, float)
    heights = np.interp(values, found.x, found.density, left=0.0, right=0.0)
    one = 1.0 / (2.0 * math.sqrt(math.pi) * len(kept) * found.bandwidth)  # of one sample
    half = float(stats.norm.ppf(0.5 + 0.5 * confidence)) * np.sqrt(heights * one)
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
    sample = np.asarray(sample, float)
    kept = sample[np.isfinite(sample)]
    if len(kept) < fewest:
        raise StatisticError(f"a density needs {fewest} samples at least, there are {len(kept)}; ask for more samples")
    return kept
