"""Statistics of an ensemble of histories, force over time, on one time grid (paper 3, figures 8 and 17 to 24).

Means, deviations and all correlations are running sums over every history, so the memory does not grow with their
number. Quantiles and densities need the histories themselves: the first KEPT of them are kept. Points of every sampler
come in an order that makes the first ones a fair sample, except for a latin hypercube; there only the whole is one.
"""

import numpy as np

from bearing_twin.errors import StatisticError
from bearing_twin.uq.statistics import binned, silverman_bandwidth, smoothed

KEPT = 4096
MOST_TIMES = 2000


class Histories:
    """Running statistics of histories (samples, times) of one quantity, added block by block.

    `times` (t,) in s; `inputs` = number d of uncertain inputs whose correlation with the history is wanted. The sums
    depend on the order of the blocks in their last digits only; add them in the order of the samples to have the same
    bytes. Memory: 8 (t^2 + t d + kept t) bytes. Raises StatisticError for more than MOST_TIMES times.
    """

    def __init__(self, times, inputs=0, kept=KEPT):
        self.times = np.asarray(times, float)
        size = len(self.times)
        if not 2 <= size <= MOST_TIMES:
            raise StatisticError(f"histories need 2 to {MOST_TIMES} times, not {size}; choose a coarser time grid")
        self.count = 0
        self._mean = np.zeros(size + inputs)
        self._products = np.zeros((size, size + inputs))
        self._squares = np.zeros(inputs)
        self._kept = np.empty((kept, size))
        self._kept_count = 0

    def add(self, histories, inputs=None):
        """Take in histories (n, t) and the inputs (n, d) they belong to; rows with a NaN are left out.

        Pairwise update of mean and centred products: T. F. Chan, G. H. Golub, R. J. LeVeque, Am. Stat. 37 (1983).
        """
        histories = np.asarray(histories, float)
        size = len(self.times)
        columns = np.empty((len(histories), 0)) if inputs is None else np.asarray(inputs, float)
        if histories.ndim != 2 or histories.shape[1] != size or columns.shape[1] + size != len(self._mean):
            raise ValueError(f"histories of {size} times with {len(self._mean) - size} inputs are needed")
        whole = np.isfinite(histories).all(axis=1)
        both = np.concatenate([histories, columns], axis=1)[whole]
        if not len(both):
            return
        room = min(len(both), len(self._kept) - self._kept_count)
        self._kept[self._kept_count : self._kept_count + room] = both[:room, :size]
        self._kept_count += room
        mean = both.mean(axis=0)
        centred, shift = both - mean, mean - self._mean
        total = self.count + len(both)
        weight = self.count * len(both) / total
        self._products += centred[:, :size].T @ centred + weight * np.outer(shift[:size], shift)
        self._squares += np.sum(centred[:, size:] ** 2, axis=0) + weight * shift[size:] ** 2
        self._mean += shift * (len(both) / total)
        self.count = total

    @property
    def mean(self):
        """Mean history (t,)."""
        self._need(1)
        return self._mean[: len(self.times)].copy()

    @property
    def std(self):
        """Deviation (t,) over the samples at each time, n - 1 in the denominator."""
        self._need(2)
        return np.sqrt(self._variances() / (self.count - 1))

    @property
    def kept(self):
        """The histories (m, t) that quantiles and densities are taken from."""
        return self._kept[: self._kept_count]

    def quantiles(self, probabilities=(0.05, 0.5, 0.95)):
        """Quantiles (probabilities, t) at each time, of the kept histories."""
        self._need(1)
        return np.quantile(self.kept, probabilities, axis=0, method="median_unbiased")

    def autocorrelation(self):
        """R(t, t') = E[(F(t) - m(t)) (F(t') - m(t'))] / (s(t) s(t')), (t, t), in -1 .. 1 (paper 3, section 5.2.1).

        NaN where all samples agree at one of the times, as before the contact.
        """
        self._need(2)
        spread = self._spread()
        return np.clip(self._products[:, : len(spread)] / np.outer(spread, spread), -1.0, 1.0)

    def input_correlation(self):
        """Correlation (d, t) of the history at each time with each input; NaN where either does not vary."""
        self._need(2)
        size = len(self.times)
        inputs = np.sqrt(np.where(self._squares > 0.0, self._squares, np.nan))
        return np.clip((self._products[:, size:] / np.outer(self._spread(), inputs)).T, -1.0, 1.0)

    def density(self, levels=200, low=-np.inf, high=np.inf):
        """Levels (m,), evenly spaced, and the density (t, m) [1/unit] of the kept histories over them at each time.

        Kernel estimates with Silverman's bandwidth, reflected at the bounds [low, high], the mass of each time 1. A
        spread below the distance of two levels shows as one level.
        """
        self._need(2)
        kept = self.kept
        margin = 0.05 * float(np.ptp(kept))
        bottom, top = max(low, float(kept.min()) - margin), min(high, float(kept.max()) + margin)
        if not top > bottom:
            raise StatisticError("all histories are equal: there is no density")
        width = (top - bottom) / levels
        result = np.empty((len(self.times), levels))
        for index, column in enumerate(kept.T):
            spread = float(np.ptp(column))
            # Runs whose bodies are apart all have the same force, none: the spread of the others is what counts.
            others = column[column > column.min()]
            measured = others if len(others) > 1 and np.ptp(others) > 0.0 else column
            bandwidth = silverman_bandwidth(measured) if spread > 1e-9 * (top - bottom) else 0.0
            result[index] = np.maximum(smoothed(binned(column, bottom, top, levels), bandwidth / width), 0.0)
        result /= result.sum(axis=1, keepdims=True) * width
        return bottom + (np.arange(levels) + 0.5) * width, result

    def _variances(self):
        return np.maximum(np.diag(self._products), 0.0)

    def _spread(self):
        """Root of the centred squares (t,), NaN where they are rounding alone."""
        variances = self._variances()
        level = (1e-14 * np.abs(self._mean[: len(self.times)])) ** 2 * self.count
        return np.sqrt(np.where(variances > level, variances, np.nan))

    def _need(self, fewest):
        if self.count < fewest:
            raise StatisticError(f"histories need {fewest} samples at least, there are {self.count}")
