"""What each of many bodies is integrated through where they are alone: its end, its instants, the steps it took."""

from typing import NamedTuple

import numpy as np


class Stretches(NamedTuple):
    """What each body has for itself, by its number: all begin at 0, and end at its `ends` [s].

    Its instants are those from number `first` on, the one `after` them not; `taken` counts its steps. Coupled bodies
    have all alike.
    """

    ends: np.ndarray
    first: np.ndarray
    after: np.ndarray
    taken: np.ndarray


def alike(bodies: int, duration: float, instants: int) -> Stretches:
    """Those of so many bodies that go through the same instants to the same end [s]."""
    ends, counts = np.empty(bodies), np.zeros((3, bodies), np.int64)
    ends.fill(duration)  # in half the time of `full`, as every chunk does it
    counts[1].fill(instants)
    return Stretches(ends, *counts)
