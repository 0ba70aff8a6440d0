"""Blocks in, a report out: the same figures for a run, its log, a study and a node."""

import copy
from collections.abc import Mapping

from bearing_twin.errors import LogError
from bearing_twin.kinds.contract import Figures
from bearing_twin.report import Choice, Report
from bearing_twin.sample import Aligned, Block, cut

BLOCK_OUTPUTS = 50  # outputs in the blocks that figures are made of


class Gathering:
    """A kind's figures writer, empty at the start, fed in pieces that do not depend on how the stream is cut.

    A writer whose attribute `in_stretches` is False gives the same to the bit for many pieces at once, and gets them.
    """

    def __init__(self, figures: Figures, choice: Choice):
        self.choice, self.outputs, self.missing = choice, 0, 0
        self._figures = figures
        self._aligned = Aligned(BLOCK_OUTPUTS)
        self._last_ns, self._following = 0, None

    def add(self, block: Block) -> None:
        """Takes a block in; outputs missing before it are counted."""
        if self._following is not None:
            self.missing += max(block.first_sequence - self._following, 0)
        self._following = block.first_sequence + len(block)
        self.outputs += len(block)
        self._last_ns = int(block.time_ns[-1])
        for piece in self._aligned.add(block):
            self._take(piece)

    def _take(self, piece: Block) -> None:
        """Hands whole pieces on, one by one to a writer that wants them so."""
        if getattr(self._figures, "in_stretches", True):
            for one in cut(piece, BLOCK_OUTPUTS):
                self._figures.add(one)
        else:
            self._figures.add(piece)

    def report(self, scene: str, compute_seconds: float = 0.0, costs: Mapping[str, int] | None = None) -> Report:
        """The report so far; raises LogError without an output."""
        if not self.outputs:
            raise LogError("there is no sample in it; recover the log from the original, or simulate again")
        # Parameters never change, and copying them took longer than all figures: the copy shares them.
        shared = getattr(self._figures, "parameters", None)
        figures = copy.deepcopy(self._figures, {id(shared): shared})
        for piece in self._aligned.rest():
            figures.add(piece)
        return Report(
            scene=scene,
            law=self.choice.law,
            stepper=self.choice.stepper,
            choice_reason=self.choice.reason,
            warnings=self.choice.warnings,
            flags=tuple(figures.flags()),
            status=figures.status(),
            simulated_seconds=1e-9 * self._last_ns,
            compute_seconds=compute_seconds,
            samples=self.outputs,
            costs=dict(costs or {}),
            figures=figures.figures(),
        )
