"""Statistics of an ensemble of histories, force over time, on one time grid (paper 3, figures 8 and 17 to 24).

All of them, quantiles too, are those of every history. They are computed ROWS histories or COLUMNS instants at a time,
so that little memory is needed besides the histories themselves.
"""

from collections.abc import Sequence

import numpy as np

from bearing_twin.base.stopping import stop_if_requested

ROWS, COLUMNS = 1024, 8  # histories and instants taken together
PROBABILITIES = (0.05, 0.5, 0.95)
CORRELATED = 41  # instants of the autocorrelation


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
    std_or_nan = np.sqrt(squares / count)
    std_or_nan[std_or_nan <= 1e-14 * np.abs(mean)] = np.nan  # rounding alone
    input_std = np.where(np.ptp(inputs, axis=0) > 0.0, inputs.std(axis=0), np.nan)
    quantiles = []
    for first in range(0, size, COLUMNS):
        stop_if_requested()
        columns = np.ascontiguousarray(histories[:, first : first + COLUMNS].T)
        quantiles.append(np.quantile(columns, PROBABILITIES, axis=1, method="median_unbiased"))

    def correlation(products, left_std, right_std):
        return np.nan_to_num(np.clip(products / count / np.outer(left_std, right_std), -1.0, 1.0))

    with_inputs = correlation(with_inputs, input_std, std_or_nan)
    return {
        "mean": mean,
        "std": np.sqrt(squares / (count - 1)),
        "skewness": np.nan_to_num(cubes / count / std_or_nan**3),
        **{f"{p:.2f}": row for p, row in zip(PROBABILITIES, np.concatenate(quantiles, axis=1), strict=True)},
        **{f"correlation with {key}": row for key, row in zip(keys, with_inputs, strict=True)},
        "rows": rows,
        "autocorrelation": correlation(with_rows, std_or_nan[rows], std_or_nan[rows]),
    }
