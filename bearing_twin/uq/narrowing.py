"""Where histories come together: the instant of least deviation after the peak of their mean (paper 3, figure 17)."""

from typing import NamedTuple

import numpy as np

from bearing_twin.errors import StatisticError
from bearing_twin.stopping import look
from bearing_twin.uq.histories import ROWS, complete, moments
from bearing_twin.uq.modality import modality

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

    `signs` has a SignChange for each input, None where the correlation keeps its sign.
    """

    time: float
    low: float
    high: float
    mean: float
    std: float
    modes: int
    p_value: float
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
    modes = modality(there, seed)
    mean, std = float(there.mean()), float(there.std(ddof=1))
    return Narrowing(float(found), float(low), float(high), mean, std, modes.modes, modes.p_value, signs)


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
