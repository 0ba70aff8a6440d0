"""The longest step of a fixed-step method at one place of a map: as predicted, as refused, and as found by trying."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

FAILS = 0.1  # error of a step that fails
NEAR = 1.04  # ratio of two steps that are tried one after the other
FROM, UP_TO = 3.0, 16.0  # a limit is looked for from its prediction over the one to that times the other


class Limit(NamedTuple):
    """The longest step [s] of a method: as predicted, where refusal begins, and as found by trying."""

    method: str
    map: str
    across: float
    predicted: float
    refused: float
    found: float

    @property
    def ratio(self) -> float:
        """Predicted over found: above 1 is unsafe."""
        return self.predicted / self.found


class MapPlace(NamedTuple):
    """One place: `error(method, step)`, `predicted(method)` [s], and where refusal begins [s]."""

    error: Callable[[str, float], float]
    predicted: Callable[[str], float]
    refused: float


def spread(low: float, high: float, count: int) -> tuple[float, ...]:
    """So many numbers, evenly spaced by their logarithm, with four digits."""
    return tuple(float(f"{value:.4g}") for value in np.geomspace(low, high, count))


def command_of(name: str, method: str, setting: float, across: float) -> str:
    """What repeats one cell of a map."""
    return f'bearing_twin chart stability --cell "{name} {method} {setting:g} {across:g}"'


def longest(predicted: float, error_of: Callable[[float], float]) -> float:
    """The longest step [s] up to which none that is tried errs by more than FAILS."""
    found = predicted / FROM
    while found < predicted * UP_TO:
        if not error_of(NEAR * found) <= FAILS:
            break
        found *= NEAR
    return found
