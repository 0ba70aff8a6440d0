"""What a picture needs of a run of any length: the loads over time, no peak lost, and the last sample."""

from collections import deque

import numpy as np

from bearing_twin.base.sample import Block, Sample

GREATEST_COUNT = 4096  # bins of an envelope: more than a picture has columns
RECENT_VALUES = 2_000_000  # numbers kept of the latest outputs, 16 MB


class LoadHistory:
    """Takes a run output by output and keeps a bounded part: an envelope of all loads, and the latest outputs whole.

    Loads are the channel `normal_load` [N], shape (balls, 2), raceway 0 inner, 1 outer; or another `channel`.
    """

    def __init__(self, channel: str = "normal_load"):
        self.channel = channel
        self.first: Sample | None = None
        self.last: Sample | None = None
        self.outputs = 0
        self._stride = 1
        self._bins = []  # (time, low, high), each of `_stride` outputs
        self._rest = []  # (time, load) of outputs that do not fill a bin yet
        self._recent = deque()  # (time, load)

    def add_block(self, block: Block) -> None:
        """Take all outputs of a block."""
        if len(block):
            self._add(block.time_ns, block.values[self.channel], block[0], block[-1])

    @property
    def turns(self) -> float:
        """How often ball 0 has gone round since the first sample."""
        return abs(float(self.last["orbit_angle"][0] - self.first["orbit_angle"][0])) / (2.0 * np.pi)

    def envelope(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Time [s] (bins,), lowest and highest load (bins, balls, 2) in each of at most 4096 slices of the run."""
        parts = list(self._bins)
        time, load = self._rest[0]
        if len(time):
            parts.append((time[:1], load.min(axis=0, keepdims=True), load.max(axis=0, keepdims=True)))
        return _joined(parts)

    def latest(self, duration: float) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """As `envelope`, of the last `duration` seconds only; None if they are no longer all there."""
        time, load = _joined(self._recent)
        start = np.searchsorted(time, time[-1] - duration)
        if start == 0:
            return None
        time, load = time[start:], load[start:]
        starts = np.arange(0, len(time), -(-len(time) // GREATEST_COUNT))
        return time[starts], np.minimum.reduceat(load, starts), np.maximum.reduceat(load, starts)

    def _add(self, time_ns, load, first, last):
        self.first = self.first or first
        self.last = last
        self.outputs += len(time_ns)
        time, load = np.asarray(time_ns) * 1e-9, np.array(load)
        self._recent.append((time, load))
        while sum(part.size for _, part in self._recent) - self._recent[0][1].size > RECENT_VALUES:
            self._recent.popleft()
        time, load = _joined([*self._rest, (time, load)])
        whole = len(time) // self._stride * self._stride
        self._rest = [(time[whole:], load[whole:])]
        if whole:
            load = load[:whole].reshape(-1, self._stride, *load.shape[1:])
            self._bins.append((time[: whole : self._stride], load.min(axis=1), load.max(axis=1)))
        while sum(len(bins) for bins, _, _ in self._bins) > GREATEST_COUNT:
            self._halve()

    def _halve(self) -> None:
        time, low, high = _joined(self._bins)
        starts = np.arange(0, len(time), 2)
        self._bins = [(time[starts], np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts))]
        self._stride *= 2


def _joined(parts) -> tuple[np.ndarray, ...]:
    return tuple(np.concatenate(column) for column in zip(*parts, strict=True))
