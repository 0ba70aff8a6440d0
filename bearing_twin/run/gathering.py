"""Blocks in, a report out: the same figures for a run, its log, a study and a node."""

import copy
from collections.abc import Mapping
from typing import Any

from bearing_twin.base.errors import LogError
from bearing_twin.base.report import Choice, Report
from bearing_twin.base.sample import Aligned, Block, cut, outputs_at_once
from bearing_twin.kinds.contract import Figures
from bearing_twin.kinds.doubt import Doubt
from bearing_twin.run.doubt import failed, judged
from bearing_twin.run.second_run import Estimate, NoEstimate

BLOCK_OUTPUTS = 50  # outputs at most in the blocks that figures are made of


class Gathering:
    """A run's writers of figures, model errors and error estimate, empty at first, fed in pieces of any length.

    A writer whose attribute `in_stretches` is False gives the same to the bit for many pieces at once, and gets them.
    """

    def __init__(self, figures: Figures, choice: Choice, doubt: Doubt, estimate: Estimate | NoEstimate | None = None):
        self.choice, self.outputs, self.missing = choice, 0, 0
        self._writers = figures, doubt, estimate or NoEstimate()
        self._length, self._aligned = 0, Aligned(0)
        self._last_ns, self._following = 0, None

    def add(self, block: Block) -> None:
        """Takes a block in; outputs missing before it are counted."""
        if self._following is not None:
            self.missing += max(block.first_sequence - self._following, 0)
        self._following = block.first_sequence + len(block)
        self.outputs += len(block)
        self._last_ns = int(block.time_ns[-1])
        if not self._length:
            self._length = min(BLOCK_OUTPUTS, outputs_at_once(block.channels))
            self._aligned = Aligned(self._length)
        for piece in self._aligned.add(block):
            for writer in self._writers:
                if getattr(writer, "in_stretches", True):
                    for one in cut(piece, self._length):
                        writer.add(one)
                else:
                    writer.add(piece)

    def report(
        self,
        scene: str,
        compute_seconds: float = 0.0,
        costs: Mapping[str, int] | None = None,
        last: bool = False,
        failure: dict[str, Any] | None = None,
    ) -> Report:
        """The report so far; raises LogError without an output. After the `last` one nothing more is taken in.

        `failure` says what broke the run off, which is then failed.
        """
        if not self.outputs:
            raise LogError("there is no sample in it; recover the log from the original, or simulate again")
        figures, doubt, estimate = self._writers
        if not last:
            # Parameters and a choice never change, and copying them took longer than all figures: the copy shares them.
            shared = [getattr(one, name, None) for one in self._writers for name in ("parameters", "choice")]
            figures, doubt, estimate = copy.deepcopy(self._writers, {id(one): one for one in shared})
        for piece in self._aligned.rest():
            for writer in (figures, doubt, estimate):
                writer.add(piece)
        choice, numbers = self.choice, figures.figures()
        errors = doubt.errors(numbers)
        status = failed(failure) if failure else figures.status()
        seconds = 1e-9 * self._last_ns
        judgement = judged(errors, estimate, numbers, status, choice)
        return Report(
            scene=scene,
            law=self.choice.law,
            stepper=choice.stepper,
            choice_reason=choice.reason,
            warnings=self.choice.warnings,
            flags=(*self.choice.outside, *figures.flags(), *judgement.flags),
            status=judgement.status,
            simulated_seconds=seconds,
            compute_seconds=compute_seconds,
            samples=self.outputs,
            costs=dict(costs or {}),
            figures=numbers,
            errors=judgement.keys,
            outside=self.choice.outside,
            failure=failure,
        )
