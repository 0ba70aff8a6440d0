"""Statistics of an ensemble of histories, force over time, on one time grid (paper 3, figures 8 and 17 to 24).

All of them, quantiles and densities too, are those of every history. They are computed ROWS histories or COLUMNS
instants at a time, so that little memory is taken beside the histories themselves.
"""

import numpy as np

from bearing_twin.errors import StatisticError
from bearing_twin.stopping import look
from bearing_twin.uq.statistics import binned, silverman_bandwidth, smoothed

ROWS, COLUMNS = 1024, 8  # histories and instants taken together
MOST_TIMES = 2000


def complete(histories: np.ndarray) -> np.ndarray:
    """Histories (n, t) without those that hold a NaN, (m,) of which are left; the array itself where none does."""
    whole = np.isfinite(histories).all(axis=1)
    return histories if whole.all() else histories[whole]


def moments(whole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The mean (t,) and the variance (t,), n in its denominator, of histories (n, t)."""
    mean, squares = whole.mean(axis=0), np.zeros(whole.shape[1])
    for first in range(0, len(whole), ROWS):
        squares += np.sum((whole[first : first + ROWS] - mean) ** 2, axis=0)
    return mean, squares / len(whole)


class Histories:
    """Statistics of histories (n, t) of one quantity at `times` (t,) [s], rows with a NaN left out.

    `inputs` (n, d) are the uncertain inputs whose correlation with the history is wanted. Raises StatisticError for
    more than MOST_TIMES times. Memory: 8 (t^2 + t d + (n + m) COLUMNS) bytes, and a copy of the histories where some
    failed; m levels of a density.
    """

    def __init__(self, times, histories, inputs=None):
        self.times, histories = np.asarray(times, float), np.asarray(histories, float)
        size = len(self.times)
        if not 2 <= size <= MOST_TIMES:
            raise StatisticError(f"histories need 2 to {MOST_TIMES} times, not {size}; choose a coarser time grid")
        inputs = np.empty((len(histories), 0)) if inputs is None else np.asarray(inputs, float)
        if histories.ndim != 2 or histories.shape[1] != size or len(inputs) != len(histories):
            raise ValueError(f"histories of {size} times, and as many rows of inputs, are needed")
        self.whole = complete(histories)
        self.count = len(self.whole)
        if len(self.whole) < len(histories):
            inputs = inputs[np.isfinite(histories).all(axis=1)]
        self.inputs = inputs
        self._mean = np.mean(self.whole, axis=0) if self.count else np.zeros(size)
        centred = inputs - inputs.mean(axis=0) if self.count else inputs
        self._squares = np.sum(centred**2, axis=0)
        self._products, self._cubes = np.zeros((size, size + inputs.shape[1])), np.zeros(size)
        for first in range(0, self.count, ROWS):
            look()
            block = self.whole[first : first + ROWS] - self._mean
            self._products += block.T @ np.concatenate([block, centred[first : first + ROWS]], axis=1)
            self._cubes += np.sum(block**3, axis=0)

    @property
    def mean(self):
        """Mean history (t,)."""
        self._need(1)
        return self._mean.copy()

    @property
    def std(self):
        """Deviation (t,) over the samples at each time, n - 1 in the denominator."""
        self._need(2)
        return np.sqrt(self._variances() / (self.count - 1))

    @property
    def skewness(self):
        """Skewness (t,) over the samples at each time; 0 where they do not differ."""
        self._need(2)
        spread = self._spread() / np.sqrt(self.count)
        return np.nan_to_num(self._cubes / self.count / spread**3)

    def quantiles(self, probabilities=(0.05, 0.5, 0.95)):
        """Quantiles (probabilities, t) at each time."""
        self._need(1)
        found = [np.quantile(block, probabilities, axis=1, method="median_unbiased") for block in self._columns()]
        return np.concatenate(found, axis=1)

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

    def density(self, levels=200, low=-np.inf):
        """Evenly spaced levels (m,) and the density (t, m) [1/unit] of the histories over them at each time.

        Kernel estimates with Silverman's bandwidth, reflected at `low`, the mass of each time 1. A
        spread below the distance of two levels shows as one level.
        """
        self._need(2)
        least, most = float(self.whole.min()), float(self.whole.max())
        margin = 0.05 * (most - least)
        bottom, top = max(low, least - margin), most + margin
        if not top > bottom:
            raise StatisticError("all histories are equal: there is no density")
        width = (top - bottom) / levels
        result = np.empty((len(self.times), levels))
        for index, column in enumerate(row for block in self._columns() for row in block):
            spread = float(np.ptp(column))
            # Runs whose bodies are apart all have the same force, none: the spread of the others is what counts.
            others = column[column > column.min()]
            measured = others if len(others) > 1 and np.ptp(others) > 0.0 else column
            bandwidth = silverman_bandwidth(measured) if spread > 1e-9 * (top - bottom) else 0.0
            result[index] = np.maximum(smoothed(binned(column, bottom, top, levels), bandwidth / width), 0.0)
        result /= result.sum(axis=1, keepdims=True) * width
        return bottom + (np.arange(levels) + 0.5) * width, result

    def _columns(self):
        """The histories as (instants, n), COLUMNS instants at a time, each of them in one piece of memory."""
        for first in range(0, len(self.times), COLUMNS):
            look()
            yield np.ascontiguousarray(self.whole[:, first : first + COLUMNS].T)

    def _variances(self):
        return np.maximum(np.diag(self._products), 0.0)

    def _spread(self):
        """Root of the centred squares (t,), NaN where they are rounding alone."""
        variances = self._variances()
        level = (1e-14 * np.abs(self._mean)) ** 2 * self.count
        return np.sqrt(np.where(variances > level, variances, np.nan))

    def _need(self, fewest):
        if self.count < fewest:
            raise StatisticError(f"histories need {fewest} samples at least, there are {self.count}")
