"""The data contract: what a simulation, a log, a node and a chart hand to each other.

A kind of scene declares its `Channel`s once. A `Block` holds consecutive solver outputs of all channels, and the
`records` of what happened between them, such as a contact that ended; a `Sample` is one row of it. Nothing here knows
where the numbers came from, so a stream read from a log and a stream from the integrator cannot be told apart.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
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


class Table(NamedTuple):
    """Something that happens between outputs: `columns` of one record of it, the first of them its time [s].

    A record belongs to the first output at or after its time.
    """

    name: str
    columns: tuple[Channel, ...]
    meaning: str


class Wrench(NamedTuple):
    """Force [N] and torque [N m] on `body`, exerted by `by`, about `point`, expressed in the axes of `frame`."""

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
    """Consecutive solver outputs: `values[name]` has shape (count, *channel.shape); `time_ns` is int64 (count,).

    `records[name]` (n, columns) holds what was recorded after the last output before this block and up to its last.
    """

    channels: tuple[Channel, ...]
    first_sequence: int
    time_ns: np.ndarray
    values: Mapping[str, np.ndarray]
    records: Mapping[str, np.ndarray] = field(default_factory=dict)

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

    def part(self, low: int, high: int) -> "Block":
        """Rows `low` to `high` - 1, with the records that belong to them."""
        if low == 0 and high == len(self):
            return self
        after = -math.inf if low == 0 else self.time_ns[low - 1]
        until = math.inf if high == len(self) else self.time_ns[high - 1]
        records = {name: between(rows, after, until) for name, rows in self.records.items()}
        values = {name: array[low:high] for name, array in self.values.items()}
        return Block(self.channels, self.first_sequence + low, self.time_ns[low:high], values, records)

    def matrix(self) -> np.ndarray:
        """All values as one float64 matrix (count, total width), channels side by side in declared order."""
        count = len(self)
        return np.concatenate([self.values[c.name].reshape(count, c.width) for c in self.channels], axis=1)

    @staticmethod
    def from_matrix(
        channels: tuple[Channel, ...], first_sequence: int, time_ns: np.ndarray, matrix: np.ndarray
    ) -> "Block":
        """The inverse of `matrix()`; without records."""
        edges = np.cumsum([0] + [c.width for c in channels])
        parts = {
            c.name: matrix[:, low:high].reshape((len(time_ns), *c.shape))
            for c, low, high in zip(channels, edges[:-1], edges[1:], strict=True)
        }
        return Block(tuple(channels), first_sequence, time_ns, parts)


def between(rows: np.ndarray, after: float, until: float) -> np.ndarray:
    """The records (n, columns) whose time, in whole nanoseconds, lies above `after` and not above `until` [ns]."""
    time_ns = np.rint(1e9 * rows[:, 0])
    return rows[(time_ns > after) & (time_ns <= until)]


def joined(blocks: list[Block]) -> Block:
    """Consecutive blocks of the same channels as one."""
    if len(blocks) == 1:
        return blocks[0]
    values = {name: np.concatenate([block.values[name] for block in blocks]) for name in blocks[0].values}
    names = dict.fromkeys(name for block in blocks for name in block.records)
    records = {
        name: np.concatenate([block.records[name] for block in blocks if name in block.records]) for name in names
    }
    time_ns = np.concatenate([block.time_ns for block in blocks])
    return Block(blocks[0].channels, blocks[0].first_sequence, time_ns, values, records)


class Aligned:
    """Cuts a stream at the same outputs however it arrives: pieces end before sequence numbers divisible by `length`.

    Sums over the pieces are then the same to the bit in a run, in its log and in a node.
    """

    def __init__(self, length: int):
        self._length = length
        self._waiting: list[Block] = []

    def add(self, block: Block) -> Iterator[Block]:
        """Takes a block in and gives the pieces that are complete; a gap ends a piece."""
        if self._waiting and block.first_sequence != self._waiting[-1].first_sequence + len(self._waiting[-1]):
            yield from self.rest()
            self._waiting = []
        low = 0
        while low < len(block):
            sequence = block.first_sequence + low
            high = min(len(block), low + self._length - sequence % self._length)
            self._waiting.append(block.part(low, high))
            if (block.first_sequence + high) % self._length == 0:
                piece, self._waiting = joined(self._waiting), []
                yield piece
            low = high

    def rest(self) -> Iterator[Block]:
        """The piece in progress, if any; it stays in progress."""
        if self._waiting:
            yield joined(self._waiting)
