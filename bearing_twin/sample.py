"""The data contract: what a simulation, a log, a node and a chart hand to each other.

A scene declares its `Channel`s once. A `Block` holds consecutive solver outputs of all channels; a `Sample`
is one row of it. Nothing here knows where the numbers came from, so a stream read from a log and a stream
from the integrator cannot be told apart.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np


class Channel(NamedTuple):
    """One named quantity of a scene: `shape` of one sample, SI `unit`, and what it means (frame, sign, point)."""

    name: str
    unit: str
    shape: tuple[int, ...]
    meaning: str

    @property
    def width(self) -> int:
        """Number of float64 values one sample of this channel holds."""
        return math.prod(self.shape)


class Wrench(NamedTuple):
    """Force [N] and torque [N m] on `body`, exerted by `by`, about `point`, expressed in `frame`."""

    body: str
    by: str
    point: str
    frame: str
    force: np.ndarray
    torque: np.ndarray


@dataclass(frozen=True, eq=False)
class Sample:
    """One solver output: `sample["normal_load"]` is that channel's array; `time_ns` counts from the start."""

    sequence: int
    time_ns: int
    values: Mapping[str, np.ndarray]

    def __getitem__(self, channel: str) -> np.ndarray:
        return self.values[channel]


@dataclass(frozen=True, eq=False)
class Block:
    """Consecutive solver outputs: `values[name]` has shape (count, *channel.shape); `time_ns` is int64 (count,)."""

    channels: tuple[Channel, ...]
    first_sequence: int
    time_ns: np.ndarray
    values: Mapping[str, np.ndarray]

    def __len__(self) -> int:
        return len(self.time_ns)

    def __getitem__(self, row: int) -> Sample:
        row = range(len(self))[row]
        return Sample(
            self.first_sequence + row,
            int(self.time_ns[row]),
            {channel.name: self.values[channel.name][row] for channel in self.channels},
        )

    def __iter__(self) -> Iterator[Sample]:
        return (self[row] for row in range(len(self)))

    def matrix(self) -> np.ndarray:
        """All values as one float64 matrix (count, total width), channels side by side in declared order."""
        count = len(self)
        return np.concatenate([self.values[c.name].reshape(count, c.width) for c in self.channels], axis=1)

    @staticmethod
    def from_matrix(
        channels: tuple[Channel, ...], first_sequence: int, time_ns: np.ndarray, matrix: np.ndarray
    ) -> "Block":
        """The inverse of `matrix()`."""
        edges = np.cumsum([0] + [c.width for c in channels])
        parts = {
            c.name: matrix[:, low:high].reshape((len(time_ns), *c.shape))
            for c, low, high in zip(channels, edges[:-1], edges[1:], strict=True)
        }
        return Block(tuple(channels), first_sequence, time_ns, parts)


class Found(NamedTuple):
    """Figures of a run with SI-suffixed keys, what to doubt in it, and "done" or what failed."""

    figures: dict
    flags: tuple[str, ...]
    status: str
