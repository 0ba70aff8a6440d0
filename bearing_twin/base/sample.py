"""The data contract between simulation, log, nodes and charts.

A kind of scene declares its `Channel`s once. A `Block` holds consecutive solver outputs of all channels, and the
`records` of events between them, such as a contact that ended; a `Sample` is one row of it. The source of the numbers
is not part of the data, so that a stream from a log and a stream from the integrator are alike.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import ChannelError, LogError, echo, legal_hint

CHUNK_BYTES = 32 << 20  # bytes of outputs


class Channel(NamedTuple):
    """One named quantity of a scene: `shape` of one sample, SI `unit`, and what it means (frame, sign, point).

    `axes` names the axes of `shape`, where they are not the kind's bodies and contacts, x, y, z, or a quaternion.
    """

    name: str
    unit: str
    shape: tuple[int, ...]
    meaning: str
    axes: tuple[str, ...] = ()

    @property
    def width(self) -> int:
        """Number of float64 values one sample of this channel holds."""
        return math.prod(self.shape)


class Table(NamedTuple):
    """A kind of event between outputs: `columns` of one record, of which the first is its time [s].

    A record belongs to the first output at or after its time. `needed`: figures cannot do without. `rate` [Hz] is the
    sampling rate of an evenly sampled signal, whose records are time and value: record k is taken at k / rate, and
    values have the precision of float32.
    """

    name: str
    columns: tuple[Channel, ...]
    meaning: str
    needed: bool = True
    rate: float = 0.0


class Wrench(NamedTuple):
    """Force [N] and torque [N m] on `body`, exerted by `by`, about `point`, expressed in the axes of `frame`."""

    body: str
    by: str
    point: str
    frame: str
    force: np.ndarray
    torque: np.ndarray


class Fields(dict):
    """Channels by name; an unknown name raises ChannelError with the legal ones."""

    def __missing__(self, name):
        raise ChannelError(f"there is no channel {echo(name)}; {legal_hint(name, self)}")


class Layout:
    """Columns of channels in a row of all channels side by side: `fields` maps names to (slice, shape)."""

    def __init__(self, channels: tuple[Channel, ...]):
        self.channels = channels
        self.fields, low = Fields(), 0
        for channel in channels:
            self.fields[channel.name] = slice(low, low + channel.width), channel.shape
            low += channel.width
        self.width = low

    def __deepcopy__(self, memo) -> "Layout":
        return self  # it never changes


@lru_cache(maxsize=64)
def layout_of(channels: tuple[Channel, ...]) -> Layout:
    """The layout of these channels, made once."""
    return Layout(channels)


class Columns(Mapping):
    """Numbers of all channels by name, (*outer, *channel.shape), as views of `numbers` (*outer, total width).

    Views are made at their first use: most readers look at few channels.
    """

    __slots__ = ("layout", "numbers")

    def __init__(self, layout: Layout, numbers: np.ndarray):
        self.layout = layout
        self.numbers = numbers

    def rows(self, rows) -> "Columns":
        """One row, or those of a slice."""
        return Columns(self.layout, self.numbers[rows])

    def __getitem__(self, name: str) -> np.ndarray:
        columns, shape = self.layout.fields[name]
        numbers = self.numbers
        if not shape:
            return numbers[columns.start] if numbers.ndim == 1 else numbers[..., columns.start]
        part = numbers[..., columns]
        return part if len(shape) == 1 else part.reshape(numbers.shape[:-1] + shape)

    def get(self, name: str, default=None):
        """The channel of that name, or `default`, without a search for similar names."""
        return self[name] if name in self.layout.fields else default

    def __iter__(self) -> Iterator[str]:
        return iter(self.layout.fields)

    def __len__(self) -> int:
        return len(self.layout.fields)

    def __contains__(self, name) -> bool:
        return name in self.layout.fields


@dataclass(eq=False, slots=True, repr=False)
class Sample:
    """One solver output: `sample["normal_load"]` is that channel's array; `time_ns` counts from the start."""

    sequence: int
    time_ns: int
    values: Mapping[str, np.ndarray]

    def __getitem__(self, channel: str) -> np.ndarray:
        return self.values[channel]

    def __contains__(self, channel: str) -> bool:
        return channel in self.values

    def __repr__(self) -> str:
        return f"Sample {self.sequence} at {1e-9 * self.time_ns:.9g} s: {', '.join(self.values)}"


@dataclass(frozen=True, eq=False, repr=False)
class Block:
    """Consecutive solver outputs: `values[name]` has shape (count, *channel.shape); `time_ns` is int64 (count,).

    `values` are given as arrays by name or as one matrix (count, total width), channels side by side in declared order;
    they are kept as that matrix, by name as views of it. `records[name]` (n, columns) holds what was recorded after
    the last output before this block and up to its last.
    """

    channels: tuple[Channel, ...]
    first_sequence: int
    time_ns: np.ndarray
    values: Mapping[str, np.ndarray]
    records: Mapping[str, np.ndarray] = field(default_factory=dict)

    def __post_init__(self):
        values = self.values
        if not isinstance(values, Columns):
            layout = layout_of(tuple(self.channels))
            if not isinstance(values, np.ndarray):
                values = stack_channels(layout, [values[name] for name in layout.fields], len(self.time_ns))
            object.__setattr__(self, "values", Columns(layout, values))

    def __len__(self) -> int:
        return len(self.time_ns)

    def __repr__(self) -> str:
        ends = " to ".join(f"{1e-9 * time:.9g}" for time in self.time_ns[[0, -1]]) if len(self) else "0 to 0"
        return f"Block of {len(self)} outputs from {self.first_sequence}, {ends} s: {', '.join(self.values)}"

    def __getitem__(self, row: int | str):
        """The `Sample` of a row, counted from the first or, below 0, behind the last; by name a channel of all rows."""
        if isinstance(row, str):
            return self.values[row]
        if isinstance(row, slice):
            raise TypeError("a block has no slices: take block.part(low, high), or a slice of block['channel']")
        row = range(len(self))[row]
        values = self.values.rows(row)
        return Sample(self.first_sequence + row, int(self.time_ns[row]), values)

    def __iter__(self) -> Iterator[Sample]:
        layout, sequence = self.values.layout, self.first_sequence
        for time_ns, numbers in zip(self.time_ns.tolist(), self.values.numbers, strict=True):
            yield Sample(sequence, time_ns, Columns(layout, numbers))
            sequence += 1

    def sample_rows(self, rows: range) -> Sample:
        """These rows as one sample: its arrays, number and time have one row an output in front."""
        part = slice(rows.start, rows.stop, rows.step)
        sequence = self.first_sequence + np.arange(rows.start, rows.stop, rows.step, dtype=np.uint64)
        return Sample(sequence, self.time_ns[part], self.values.rows(part))

    def part(self, low: int, high: int) -> "Block":
        """Rows `low` to `high` - 1, with the records that belong to them; views, nothing is copied."""
        if low == 0 and high == len(self):
            return self
        after = -math.inf if low == 0 else self.time_ns[low - 1]
        until = math.inf if high == len(self) else self.time_ns[high - 1] if high else -math.inf
        records = {name: records_between(rows, after, until) for name, rows in self.records.items()}
        values = self.values.rows(slice(low, high))
        return Block(self.channels, self.first_sequence + low, self.time_ns[low:high], values, records)

    def matrix(self) -> np.ndarray:
        """All values in float64, shape (count, total width), channels side by side in declared order."""
        return self.values.numbers


def stack_channels(layout: Layout, arrays: Sequence[np.ndarray], count: int) -> np.ndarray:
    """One matrix (count, total width) of one array (count, *shape) a channel, in order.

    Arrays that are the channels of one such matrix already, as views of it, give that matrix without a copy.
    """
    matrix = arrays[0].base
    fits = isinstance(matrix, np.ndarray) and matrix.shape == (count, layout.width) and matrix.dtype == float
    if fits and matrix.flags.c_contiguous and all(array.base is matrix for array in arrays):
        return matrix
    matrix = np.empty((count, layout.width))
    for array, (columns, _) in zip(arrays, layout.fields.values(), strict=True):
        matrix[:, columns] = np.reshape(array, (count, columns.stop - columns.start))
    return matrix


def outputs_per_chunk(channels: Sequence[Channel]) -> int:
    """Number of outputs that are processed together: with thousands of balls a stop would else wait for seconds."""
    return max(1, CHUNK_BYTES // (8 * sum(channel.width for channel in channels)))


def records_between(rows: np.ndarray, after: float, until: float) -> np.ndarray:
    """The records (n, columns), in order of time, above `after` and not above `until` [whole ns]; a view."""
    low, high = (bisect_right(rows[:, 0], end, key=lambda seconds: np.rint(1e9 * seconds)) for end in (after, until))
    return rows[low:high]


def join_blocks(blocks: list[Block]) -> Block:
    """Consecutive blocks of the same channels as one."""
    if len(blocks) == 1:
        return blocks[0]
    names = dict.fromkeys(name for block in blocks for name in block.records)
    records = {
        name: np.concatenate([block.records[name] for block in blocks if name in block.records]) for name in names
    }
    time_ns = np.concatenate([block.time_ns for block in blocks])
    numbers = np.concatenate([block.matrix() for block in blocks])
    return Block(blocks[0].channels, blocks[0].first_sequence, time_ns, numbers, records)


def split_block(block: Block, length: int) -> Iterator[Block]:
    """The block in pieces that end before sequence numbers divisible by `length`."""
    low = 0
    while low < len(block):
        high = min(len(block), low + length - (block.first_sequence + low) % length)
        yield block.part(low, high)
        low = high


class BlockAligner:
    """Splits a stream at the same outputs for any blocks: pieces end before sequence numbers divisible by `length`.

    Pieces may be several times as long; `split_block` makes them shorter. Sums over the short ones are then the same
    to the bit in a run, in its log and in a node.
    """

    def __init__(self, length: int):
        self._length = length
        self._waiting: list[Block] = []

    def add(self, block: Block) -> Iterator[Block]:
        """Take a block and yield the complete pieces; a gap ends a piece."""
        if self._waiting and block.first_sequence != self._waiting[-1].first_sequence + len(self._waiting[-1]):
            yield from self.remainder()
            self._waiting = []
        complete = (block.first_sequence + len(block)) // self._length * self._length - block.first_sequence
        low = 0
        if self._waiting and complete > 0:
            # The waiting piece is completed first, so that no more than it is copied.
            low = min(complete, self._length - block.first_sequence % self._length)
            yield join_blocks([*self._waiting, block.part(0, low)])
            self._waiting = []
        if complete > low:
            yield block.part(low, complete)
            low = complete
        if low < len(block):
            self._waiting.append(block.part(low, len(block)))

    def remainder(self) -> Iterator[Block]:
        """The piece in progress, if any; it stays in progress."""
        if self._waiting:
            yield join_blocks(self._waiting)


class ThinnedOutputs:
    """Arrays of outputs of a run of any length, at most `limit` rows: the first output, and every `stride`-th after it.

    `select` returns the arrays of a sample of many outputs, by name, with one row an output. `outputs` is the number
    of outputs so far; `stride` is doubled where more than `limit` rows are selected.
    """

    def __init__(self, limit: int, select: Callable[[Sample], Mapping[str, np.ndarray]]):
        self.stride, self.outputs, self._limit, self._select = 1, 0, limit, select
        self._next = self._rows = 0
        self._times: list[np.ndarray] = []
        self._parts: dict[str, list[np.ndarray]] = {}

    def add(self, block: Block) -> None:
        """Take a block."""
        rows = range(self._next - self.outputs, len(block), self.stride)
        if len(rows):
            sample = block.sample_rows(rows)
            self._times.append(1e-9 * sample.time_ns)
            for name, values in self._select(sample).items():
                self._parts.setdefault(name, []).append(values)
        self.outputs += len(block)
        self._next += self.stride * len(rows)
        self._rows += len(rows)
        while self._rows > self._limit:
            self._times = [self.time[::2]]
            self._parts = {name: [values[::2]] for name, values in self.values.items()}
            self.stride, self._rows = 2 * self.stride, len(self._times[0])
            self._next = self.stride * self._rows

    @property
    def time(self) -> np.ndarray:
        """Times [s] (count,) of the outputs that are kept; raises LogError where there is none."""
        if not self._times:
            raise LogError("there is no sample to show; give a run or a log that holds at least one")
        return np.concatenate(self._times)

    @property
    def values(self) -> dict[str, np.ndarray]:
        """The arrays (count, ...) by name."""
        return {name: np.concatenate(parts) for name, parts in self._parts.items()}
