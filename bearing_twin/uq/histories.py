"""Statistics of an ensemble of histories, force over time, on one time grid (paper 3, figures 8 and 17 to 24).

All of them, quantiles and densities too, are those of every history. They are computed ROWS histories or COLUMNS
instants at a time, so that little memory is taken beside the histories themselves.
"""

from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import StatisticError
from bearing_twin.base.stopping import look
from bearing_twin.uq.modality import modality
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


# Where histories come together: the instant of least deviation after the peak of their mean (paper 3, figure 17).

OVER = 0.25  # of the peak of the mean: below it only those that last longest are left, and deviation falls to zero
RESAMPLES = 200
FEWEST = 50  # histories
TINY = 1e-300  # of an input that does not vary


class SignChange(NamedTuple):
    """Where the correlation with an input changes its sign, nearest to a least deviation, and how much later [s].

    `low` and `high` are the 95 % interval of `later`, by resampling both instants together. With b^2 what of the
    variance is linear in the input and r the rest, the least lies where 2 b b' + r' = 0: r' / (2 b'^2) before b
    changes its sign, to first order, which is `by_slopes`.
    """

    time: float
    later: float
    low: float
    high: float
    by_slopes: float


class Narrowing(NamedTuple):
    """The instant [s] of least deviation with its 95 % interval, and mean, deviation and modes of the values there.

    `modes` and `p_value` are None where many of the values are exactly 0.

    `signs` has a SignChange for each input, None where the correlation keeps its sign.
    """

    time: float
    low: float
    high: float
    mean: float
    std: float
    modes: int | None
    p_value: float | None
    signs: tuple[SignChange | None, ...]


def narrowing(times: np.ndarray, histories: np.ndarray, seed: int = 0, inputs: np.ndarray | None = None) -> Narrowing:
    """The narrowing of histories (n, t), rows with a NaN left out; the interval by bootstrap over the rows.

    `inputs` (n, d) are those whose correlation with the histories is looked at. The modes are those at the nearest of
    `times`, their p-value that of one mode at most (see `modality`). Raises StatisticError for fewer than FEWEST
    histories, or where no instant after the peak has the least deviation.
    """
    kept = complete(histories)
    inputs = np.empty((len(histories), 0)) if inputs is None else np.asarray(inputs, float)
    if len(kept) < FEWEST:
        raise StatisticError(f"a narrowing needs {FEWEST} histories at least, there are {len(kept)}")
    of_kept = inputs[np.isfinite(histories).all(axis=1)]
    mean, variance = moments(kept)
    found = _least(times, mean, np.sqrt(variance))
    again, covariances, resampled = _resampled(times, kept, of_kept, seed)
    if np.isnan(found) or np.mean(np.isnan(again)) > 0.05:
        raise StatisticError("no instant after the peak of the mean has a least deviation")
    low, high = np.nanquantile(again, [0.025, 0.975])
    signs = tuple(
        _sign_change(times, found, again, one, many, _by_slopes(times, variance, one / max(spread, TINY)))
        for one, many, spread in zip(covariances, resampled, of_kept.std(axis=0), strict=True)
    )
    place = int(np.argmin(np.abs(times - found)))
    there = kept[:, place]
    try:
        modes: tuple = modality(there, seed)[:2]
    except StatisticError:  # some bodies are apart
        modes = None, None
    mean, std = float(there.mean()), float(there.std(ddof=1))
    return Narrowing(float(found), float(low), float(high), mean, std, *modes, signs)


def _resampled(times, kept, inputs, seed):
    """The least instants (r,) of resamples, and covariances with each input: (d, t) of all and (d, r, t).

    Memory: RESAMPLES n bytes and 8 RESAMPLES t (2 + d) beside the histories.
    """
    random, (count, inputs) = np.random.default_rng(seed), (len(kept), inputs - inputs.mean(axis=0))
    # Moments of a resample are sums over rows, each as often as it was drawn.
    drawn = np.empty((RESAMPLES, count), np.uint8)
    for row in drawn:
        look()
        row[:] = np.bincount(random.integers(count, size=count), minlength=count)
    means, squares = np.zeros((2, RESAMPLES, len(times)))
    whole, products = np.zeros((inputs.shape[1], len(times))), np.zeros((inputs.shape[1], RESAMPLES, len(times)))
    shifts = np.zeros((RESAMPLES, inputs.shape[1]))
    for first in range(0, count, ROWS):
        look()
        part = slice(first, first + ROWS)
        weights, block = drawn[:, part] / count, kept[part]
        means += weights @ block
        squares += weights @ block**2
        shifts += weights @ inputs[part]
        whole += inputs[part].T @ block / count
        for place, column in enumerate(inputs[part].T):
            products[place] += (weights * column) @ block
    spreads = np.sqrt(np.maximum(squares - means**2, 0.0))
    again = np.array([_least(times, mean, spread) for mean, spread in zip(means, spreads, strict=True)])
    return again, whole, products - shifts.T[:, :, None] * means


def _by_slopes(times, variance, linear):
    """`SignChange.by_slopes` at every instant (t,), of the variance and what is linear in the input, as a deviation."""
    slope, rest = np.gradient(linear, times), np.gradient(variance - linear**2, times)
    return 0.5 * rest / np.maximum(slope**2, TINY)


def _sign_change(times, found, again, covariance, resampled, by_slopes) -> SignChange | None:
    """Of one input, with its covariances (t,) and (r, t)."""
    look()
    when = _zero(times, covariance, found)
    later = np.array([_zero(times, one, near) - near for one, near in zip(resampled, again, strict=True)])
    if np.isnan(when) or np.mean(np.isnan(later)) > 0.05:
        return None
    low, high = np.nanquantile(later, [0.025, 0.975])
    return SignChange(
        float(when), float(when - found), float(low), float(high), float(np.interp(when, times, by_slopes))
    )


def _zero(times, values, near) -> float:
    """Where values (t,) change their sign, nearest to `near`, by a straight line; NaN where they do not."""
    places = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    if not len(places) or np.isnan(near):
        return np.nan
    before, after = values[places], values[places + 1]
    crossings = times[places] + (times[places + 1] - times[places]) * before / (before - after)
    return float(crossings[np.argmin(np.abs(crossings - near))])


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
