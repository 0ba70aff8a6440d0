"""Statistics of an ensemble of histories, force over time, on one time grid (paper 3, figures 8 and 17 to 24).

All of them, quantiles too, are those of every history. They are computed ROWS histories or COLUMNS instants at a time,
so that little memory is needed besides the histories themselves.
"""

from collections.abc import Sequence

import numpy as np

from bearing_twin.base.errors import StatisticError
from bearing_twin.base.stopping import stop_if_requested
from bearing_twin.uq.statistics import modality

ROWS, COLUMNS = 1024, 8  # histories and instants taken together
PROBABILITIES = (0.05, 0.5, 0.95)
CORRELATED = 41  # instants of the autocorrelation
OVER = 0.25  # of the peak of the mean: below it only the longest contacts are left, and the deviation falls to zero
RESAMPLES = 200  # of the bootstrap
FEWEST = 50  # histories of a narrowing
MOST_FAILED = 0.05  # share of resamples without a result, beyond which there is none


def _blocks(count: int):
    for first in range(0, count, ROWS):
        stop_if_requested()
        yield slice(first, first + ROWS)


def history_statistics(histories: np.ndarray, inputs: np.ndarray, keys: Sequence[str]) -> dict[str, np.ndarray]:
    """Statistics at each instant of histories (n, t) without NaN, at least 2, and of their inputs (n, d) named `keys`.

    Returns
    -------
    dict
        `mean`, `std`, `skewness` and the quantiles by their PROBABILITIES, each (t,); `correlation with KEY` (t,) of
        each input; `rows` (r,), some of the instants, and `autocorrelation` (r, r) at these, R(t, t') = E[(F(t) - m(t))
        (F(t') - m(t'))] / (s(t) s(t')) (paper 3, section 5.2.1). Skewness and correlations are 0 where samples do not
        differ, as before the contact.
    """
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
        stop_if_requested()
        columns = np.ascontiguousarray(histories[:, first : first + COLUMNS].T)
        quantiles.append(np.quantile(columns, PROBABILITIES, axis=1, method="median_unbiased"))

    def correlation(products, one, other):
        return np.nan_to_num(np.clip(products / count / np.outer(one, other), -1.0, 1.0))

    with_inputs = correlation(with_inputs, of_inputs, spread)
    return {
        "mean": mean,
        "std": np.sqrt(squares / (count - 1)),
        "skewness": np.nan_to_num(cubes / count / spread**3),
        **{f"{p:.2f}": row for p, row in zip(PROBABILITIES, np.concatenate(quantiles, axis=1), strict=True)},
        **{f"correlation with {key}": row for key, row in zip(keys, with_inputs, strict=True)},
        "rows": rows,
        "autocorrelation": correlation(with_rows, spread[rows], spread[rows]),
    }


# Where histories come together: the instant of least deviation after the peak of their mean (paper 3, figure 17).


def narrowing(times: np.ndarray, histories: np.ndarray, inputs: np.ndarray, keys: Sequence[str], seed: int = 0) -> dict:
    """The narrowing of histories (n, t) without NaN, which belong to inputs (n, d) named `keys`, as plain data.

    Returns
    -------
    dict
        `time_s`, its 95 % `interval_s` by bootstrap, `mean`, `std`, `modes` and `p_value` (see `modality`) of the
        values there; `modes` is None where many of them are exactly 0. `sign_changes` holds for each input whose
        correlation changes its sign the nearest instant `time_s`, and how much `later_s` that is, with its interval.

    Raises
    ------
    StatisticError
        For fewer than FEWEST histories, or where no instant after the peak has the least deviation.
    """
    if len(histories) < FEWEST:
        raise StatisticError(f"a narrowing needs {FEWEST} histories at least, there are {len(histories)}")
    means, spreads, covariances = _resampled(histories, inputs, seed)
    least = np.array([_least(times, mean, spread) for mean, spread in zip(means, spreads, strict=True)])
    if (interval := _interval(least)) is None:
        raise StatisticError("no instant after the peak of the mean has a least deviation")
    signs = {}
    for key, of_input in zip(keys, covariances, strict=True):
        stop_if_requested()
        later = np.array([_zero(times, one, near) - near for one, near in zip(of_input, least, strict=True)])
        if (of_later := _interval(later)) is not None:
            time, later = float(least[0] + later[0]), float(later[0])
            signs[key] = {"time_s": time, "later_s": later, "interval_s": of_later}
    there = histories[:, int(np.argmin(np.abs(times - least[0])))]
    try:
        modes, p_value = modality(there, seed)[:2]
    except StatisticError:  # bodies are apart in some histories
        modes = p_value = None
    return {
        "time_s": float(least[0]),
        "interval_s": interval,
        "mean": float(there.mean()),
        "std": float(there.std(ddof=1)),
        "modes": modes,
        "p_value": p_value,
        "sign_changes": signs,
    }


def _interval(found: np.ndarray) -> list[float] | None:
    """The 95 % interval of the first of `found` by the resamples behind it; None where it or too many are NaN."""
    if np.isnan(found[0]) or np.mean(np.isnan(found[1:])) > MOST_FAILED:
        return None
    return np.nanquantile(found[1:], [0.025, 0.975]).tolist()


def _resampled(histories, inputs, seed):
    """Means and deviations (1 + r, t), and covariances with each input (d, 1 + r, t), of the sample and r resamples.

    Memory: RESAMPLES n bytes and 8 RESAMPLES t (2 + d) besides the histories.
    """
    random, (count, size) = np.random.default_rng(seed), histories.shape
    inputs = inputs - inputs.mean(axis=0)
    drawn = np.ones((1 + RESAMPLES, count), np.uint8)  # how often each row was drawn
    for row in drawn[1:]:
        stop_if_requested()
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
