"""Mean, deviation and skewness of a sample with their influence functions, summed piece by piece.

A piece stays in the processor's cache with what is reckoned of it; arrays as long as a sample of a million, made and
let go for each product, take two to four times as long.
"""

import math
from collections.abc import Callable

import numpy as np

from bearing_twin.errors import StatisticError
from bearing_twin.stopping import look

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
