"""Outputs on their way to a page: thinned while they come, so that a run of any length fits into a browser."""

from collections.abc import Iterable, Iterator

import numpy as np

from bearing_twin.base.errors import LogError
from bearing_twin.base.sample import Block
from bearing_twin.kinds.views import View

GREATEST_NUMBERS = 2_600_000  # of all series together: 5.2 MB as whole numbers of two bytes, 7 MB as text
LEAST_FRAMES = 100


class Frames:
    """What a page shows of a run: every `stride`-th output, as many as fit; `time` [s] (count,), `values` by series."""

    def __init__(self, view: View):
        self._view = view
        self._width = max(1, sum(channel.width for channel in view.series))
        self.greatest = max(LEAST_FRAMES, GREATEST_NUMBERS // self._width)
        self.stride = 1
        self.outputs = 0
        self._next, self._count = 0, 0
        self._times: list[np.ndarray] = []
        self._parts: dict[str, list[np.ndarray]] = {channel.name: [] for channel in view.series}

    def add(self, block: Block) -> None:
        """Takes a block in; where too much has come, every second output is let go."""
        size = len(block)
        rows = range(self._next - self.outputs, size, self.stride)
        if len(rows):
            self._take(block, rows)
        self.outputs += size
        self._next += self.stride * len(rows)
        while self._count > self.greatest:
            self._halve()

    def _take(self, block: Block, rows: range) -> None:
        found = self._view.rows(block.sampled(rows))
        for channel in self._view.series:
            part = np.asarray(found[channel.name], np.float32).reshape(len(rows), -1)
            self._parts[channel.name].append(part)
        self._times.append(1e-9 * block.time_ns[rows.start : rows.stop : rows.step])
        self._count += len(rows)

    def _halve(self) -> None:
        """The first output always stays, and with it every second of those kept."""
        self._times = [np.concatenate(self._times)[::2]]
        self._parts = {name: [np.concatenate(parts)[::2]] for name, parts in self._parts.items()}
        self._count = len(self._times[0])
        self.stride *= 2
        self._next = self.stride * self._count

    @property
    def time(self) -> np.ndarray:
        """Times [s] (count,) of the outputs that are kept; raises LogError where there is none."""
        if not self._times:
            raise LogError("there is no sample to show; give a run or a log that holds at least one")
        return np.concatenate(self._times)

    @property
    def values(self) -> dict[str, np.ndarray]:
        """Float32 (count, width) of each series."""
        return {name: np.concatenate(parts) for name, parts in self._parts.items()}

    def note(self) -> str:
        """What a page that holds not all of them says of it; empty where it holds all."""
        if self.stride == 1:
            return ""
        return (
            f"The run has {self.outputs} outputs, too many for a browser: every {self.stride}th is shown. Figures are "
            "those of all of them; peaks between the outputs shown are missing from the curves."
        )


def passed_on(blocks: Iterable[Block], frames: Frames) -> Iterator[Block]:
    """The same blocks, each shown to `frames` on its way."""
    for block in blocks:
        frames.add(block)
        yield block
