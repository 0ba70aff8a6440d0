"""Blocks of outputs that wait to be logged together, as one."""

from collections.abc import Iterator

import numpy as np

from bearing_twin.sample import Block, Columns, Sample


class Consecutive:
    """Consecutive blocks of the same channels seen as one, whose numbers are not copied."""

    def __init__(self, blocks: list[Block]):
        self._blocks = blocks
        self._starts = np.cumsum([0, *map(len, blocks)])
        self.first_sequence = blocks[0].first_sequence
        self.time_ns = np.concatenate([block.time_ns for block in blocks])

    def __len__(self) -> int:
        return len(self.time_ns)

    def __getitem__(self, row: int) -> Sample:
        place = int(np.searchsorted(self._starts, row, side="right")) - 1
        return self._blocks[place][row - int(self._starts[place])]

    def sampled(self, rows: range) -> Sample:
        """These rows as one sample, see `Block.sampled`."""
        picked, found = np.arange(rows.start, rows.stop, rows.step), []
        edges = np.searchsorted(picked, self._starts).tolist()
        for block, start, low, high in zip(self._blocks, self._starts, edges, edges[1:], strict=False):
            found.append(block.matrix()[picked[low:high] - start])
        values = Columns(self._blocks[0].values.layout, np.concatenate(found))
        return Sample((self.first_sequence + picked).astype(np.uint64), self.time_ns[picked], values)

    def parts(self, low: int, high: int) -> Iterator[Block]:
        """Rows `low` to `high` - 1 as parts of the blocks they lie in."""
        for block, start in zip(self._blocks, self._starts.tolist(), strict=False):
            first, last = max(0, low - start), min(len(block), high - start)
            if first < last:
                yield block.part(first, last)
