"""Statistics of an ensemble of histories, force over time, on one time grid (paper 3, figures 8 and 17 to 24).

All of them, quantiles too, are those of every history. They are computed ROWS histories or COLUMNS instants at a time,
so that little memory is needed besides the histories themselves.
"""

from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import StatisticError
from bearing_twin.base.stopping import look
from bearing_twin.uq.modality import modality

ROWS, COLUMNS = 1024, 8  # histories and instants taken together
PROBABILITIES = (0.05, 0.5, 0.95)
CORRELATED = 41  # instants of the autocorrelation
OVER = 0.25  # of the peak of the mean: below it only the longest contacts are left, and the deviation falls to zero
RESAMPLES = 200  # of the bootstrap
FEWEST = 50  # histories of a narrowing
MOST_FAILED = 0.05  # share of resamples without a result, beyond which there is none


def _blocks(count: int):
    for first in range(0, count, ROWS):
        look()
        yield slice(first, first + ROWS)


class HistoryStatistics(NamedTuple):
    """Statistics at each instant: mean, std, skewness (t,), quantiles (3, t) at PROBABILITIES, correlations.

    `skewness` is 0 where samples do not differ. `correlation` (d, t) is that with each input, `autocorrelation` (r, r)
    R(t, t') = E[(F(t) - m(t)) (F(t') - m(t'))] / (s(t) s(t')) (paper 3, section 5.2.1) at `rows` of the instants; 0
    where one of the two does not vary, as before the contact.
    """

    mean: np.ndarray
    std: np.ndarray
    skewness: np.ndarray
    quantiles: np.ndarray
    correlation: np.ndarray
    autocorrelation: np.ndarray
    rows: np.ndarray


def history_statistics(histories: np.ndarray, inputs: np.ndarray) -> HistoryStatistics:
    """Statistics of histories (n, t) without NaN, at least 2, and of the inputs (n, d) they belong to."""
    count, size = histories.shape
    mean, centred = histories.mean(axis=0), inputs - inputs.mean(axis=0)
    rows = np.arange(0, size, max(1, -(-size // CORRELATED)))
    squares, cubes, with_inputs, with_rows = 0.0, 0.0, 0.0, 0.0
    for part in _blocks(count):
        block = histories[part] - mean
        square = block * block
        squares, cubes = squares + square.sum(axis=0), cubes + (square * block).sum(axis=0)
        with_inputs = with_inputs + centred[part].T @ block
        with_rows = with_rows + block[:, rows].T @ block[:, rows]
    spread = np.sqrt(squares / count)
    spread[spread <= 1e-14 * np.abs(mean)] = np.nan  # rounding alone
    of_inputs = np.where(np.ptp(inputs, axis=0) > 0.0, inputs.std(axis=0), np.nan)
    quantiles = []
    for first in range(0, size, COLUMNS):
        look()
        columns = np.ascontiguousarray(histories[:, first : first + COLUMNS].T)
        quantiles.append(np.quantile(columns, PROBABILITIES, axis=1, method="median_unbiased"))

    def correlation(products, one, other):
        return np.nan_to_num(np.clip(products / count / np.outer(one, other), -1.0, 1.0))

    return HistoryStatistics(
        mean,
        np.sqrt(squares / (count - 1)),
        np.nan_to_num(cubes / count / spread**3),
        np.concatenate(quantiles, axis=1),
        correlation(with_inputs, of_inputs, spread),
        correlation(with_rows, spread[rows], spread[rows]),
        rows,
    )


# Where histories come together: the instant of least deviation after the peak of their mean (paper 3, figure 17).


class SignChange(NamedTuple):
    """The instant at which the correlation with an input changes its sign, and how much `later` that is [s].

    `low` and `high` are the 95 % interval of `later`, by resampling both instants together.
    """

    time: float
    later: float
    low: float
    high: float


class Narrowing(NamedTuple):
    """The instant [s] of least deviation with its 95 % interval, and mean, deviation and modes of the values there.

    `modes` and `p_value` are None where many of the values are exactly 0. `signs` has a SignChange for each input,
    None where the correlation keeps its sign.
    """

    time: float
    low: float
    high: float
    mean: float
    std: float
    modes: int | None
    p_value: float | None
    signs: tuple[SignChange | None, ...]


def narrowing(times: np.ndarray, histories: np.ndarray, inputs: np.ndarray, seed: int = 0) -> Narrowing:
    """The narrowing of histories (n, t) without NaN, which belong to inputs (n, d); intervals by bootstrap.

    The modes are those at the nearest of `times`, their p-value that of one mode at most (see `modality`). Raises
    StatisticError for fewer than FEWEST histories, or where no instant after the peak has the least deviation.
    """
    if len(histories) < FEWEST:
        raise StatisticError(f"a narrowing needs {FEWEST} histories at least, there are {len(histories)}")
    means, spreads, covariances = _resampled(histories, inputs, seed)
    least = np.array([_least(times, mean, spread) for mean, spread in zip(means, spreads, strict=True)])
    found, again = least[0], least[1:]
    if np.isnan(found) or np.mean(np.isnan(again)) > MOST_FAILED:
        raise StatisticError("no instant after the peak of the mean has a least deviation")
    signs = tuple(_sign_change(times, least, one) for one in covariances)
    there = histories[:, int(np.argmin(np.abs(times - found)))]
    try:
        modes: tuple = modality(there, seed)[:2]
    except StatisticError:  # bodies are apart in some histories
        modes = None, None
    low, high = np.nanquantile(again, [0.025, 0.975])
    mean, std = float(there.mean()), float(there.std(ddof=1))
    return Narrowing(float(found), float(low), float(high), mean, std, *modes, signs)


def _resampled(histories, inputs, seed):
    """Means and deviations (1 + r, t), and covariances with each input (d, 1 + r, t), of the sample and r resamples.

    Memory: RESAMPLES n bytes and 8 RESAMPLES t (2 + d) besides the histories.
    """
    random, (count, size) = np.random.default_rng(seed), histories.shape
    inputs = inputs - inputs.mean(axis=0)
    drawn = np.ones((1 + RESAMPLES, count), np.uint8)  # how often each row was drawn
    for row in drawn[1:]:
        look()
        row[:] = np.bincount(random.integers(count, size=count), minlength=count)
    means, squares = np.zeros((2, 1 + RESAMPLES, size))
    products, shifts = np.zeros((inputs.shape[1], 1 + RESAMPLES, size)), np.zeros((1 + RESAMPLES, inputs.shape[1]))
    for part in _blocks(count):
        weights, block = drawn[:, part] / count, histories[part]
        means += weights @ block
        squares += weights @ block**2
        shifts += weights @ inputs[part]
        for place, column in enumerate(inputs[part].T):
            products[place] += (weights * column) @ block
    return means, np.sqrt(np.maximum(squares - means**2, 0.0)), products - shifts.T[:, :, None] * means


def _sign_change(times, least, covariances) -> SignChange | None:
    """Of one input, from the least instants (1 + r,) and covariances (1 + r, t) of the sample and its resamples."""
    look()
    later = np.array([_zero(times, one, near) - near for one, near in zip(covariances, least, strict=True)])
    if np.isnan(later[0]) or np.mean(np.isnan(later[1:])) > MOST_FAILED:
        return None
    low, high = np.nanquantile(later[1:], [0.025, 0.975])
    return SignChange(float(least[0] + later[0]), float(later[0]), float(low), float(high))


def _zero(times, values, near) -> float:
    """The instant nearest to `near` at which values (t,) change their sign, by a straight line; NaN without one."""
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
    lowest = int(np.argmin(inner))
    if lowest in (0, len(inner) - 1):
        return np.nan
    before, here, after = inner[lowest - 1 : lowest + 2]
    bend = before - 2.0 * here + after
    shift = 0.5 * (before - after) / bend if bend > 0.0 else 0.0
    return float(np.interp(first + lowest + shift, np.arange(len(times)), times))
