"""The ensemble as it grows: batch after batch, looked at each time, until the stop rule, the end or a cancel."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from bearing_twin.errors import StatisticError, StudyError
from bearing_twin.uq.chaos import MOST_RUNS
from bearing_twin.uq.ensemble import Ensemble
from bearing_twin.uq.interpolation import LADDER
from bearing_twin.uq.realise import Task, empty
from bearing_twin.uq.result import StudyResult, Tally
from bearing_twin.uq.sampling import UnitPoints
from bearing_twin.uq.statistics import Estimate, estimate
from bearing_twin.uq.stopping import IN_A_ROW, looks, rule_of
from bearing_twin.uq.study import Study

CANCELLED, OUT_OF_TIME = "cancelled", "its time_limit of "  # why an ensemble ended, the second as a beginning
PIECE = 16384  # points drawn at once, so that a cancel need not wait for a whole batch


class Progress(NamedTuple):
    """How far a study is: realisations `done` of `total` at most; the watched statistic as last looked at.

    `estimate` and `half_width` are NaN before the first look, `seconds_left` if all of `total` are needed. `at` names
    the value of a sweep that the estimate is at, empty without one.
    """

    done: int
    total: int
    estimate: float
    half_width: float
    seconds_left: float
    at: str = ""


@dataclass
class Drawn:
    """The ensemble as it grows: how many are `done`, the `path` of (samples, estimate of them), why it ended."""

    study: Study
    task: Task
    progress: Callable[[Progress], None]
    asked: Callable[[], bool]
    began: float
    keep: Callable | None = None
    path: list[tuple[int, Estimate]] = field(default_factory=list)
    because: str = "every quantity follows without sampling"
    notes: tuple[str, ...] = ()
    done: int = 0
    broken: bool = False

    def __post_init__(self):
        study, settings = self.study, self.study.settings
        self.points = UnitPoints(settings.sampler, study.joint.dimension, settings.seed, settings.samples)
        self.rule = rule_of(settings.stop, study.stop_quantity)
        self.reasons, self.doubts = Tally(), Tally()
        nothing = empty(self.task, 0)
        # As long as it may become: pages that nothing was written to take no memory, and nothing is joined at the end.
        columns = (np.empty((0, len(study.inputs))), nothing.quantities, nothing.histories)
        columns += np.empty(0, np.int32), np.empty(0, np.int64)
        self._columns = [np.empty((self.points.samples, *one.shape[1:]), one.dtype) for one in columns]

    def draw(self, ensemble: Ensemble, start: StudyResult | None) -> None:
        """Samples up to the stop rule, the greatest number of samples, or a cancel."""
        settings, self._watched = self.study.settings, np.empty(self.points.samples)
        self.notes = (self.points.note,) if self.points.note else ()
        self.because = f"all {self.points.samples} samples are done"
        narrow = 0
        for size in looks(self.points.samples, settings.batch, settings.stop.minimum, settings.sampler):
            known = 0 if start is None else min(size, len(start.status)) - self.done
            if known > 0:
                self._take_over(start, self.done + known)
            try:
                if self.done < size:
                    self._realise(ensemble, size)
            except StudyError as error:
                if not self.done:
                    raise
                self.because, self.broken = f"failed: {error}", True
                break
            if self.done < size:
                self.because = CANCELLED
                break
            narrow = narrow + 1 if self._look(self._watched[: self.done]) else 0
            self._tell(self.done)
            if narrow == IN_A_ROW:
                self.because = f"{self.rule.text()}, at {IN_A_ROW} looks in a row"
                break

    def _realise(self, ensemble, size) -> None:
        """Realisations up to number `size`, fewer when cancelled."""
        while self.done < size:
            first, wanted = self.done, min(size - self.done, PIECE)
            values = self.study.joint.values(self.points.chunk(first, wanted))
            for found in ensemble.parts(values, lambda more, first=first: self._tell(first + more)):
                count = len(found.quantities)
                self._add(
                    values[self.done - first :][:count],
                    found.quantities,
                    found.histories,
                    self.reasons.codes(count, found.failures),
                    self.doubts.bits(count, found.doubts),
                )
            if self.done < first + wanted:
                return

    def _take_over(self, start, size) -> None:
        """Realisations of an earlier result, up to number `size`."""
        rows = slice(self.done, size)
        codes, bits = start.status[rows], start.doubtful[rows]
        failures = {int(row): start.reasons[codes[row] - 1] for row in np.flatnonzero(codes)}
        doubts = {
            int(row): tuple(text for place, text in enumerate(start.doubts_met) if int(bits[row]) >> place & 1)
            for row in np.flatnonzero(bits)
        }
        self._add(
            start.values[rows],
            start.quantities[rows],
            start.histories[rows],
            self.reasons.codes(len(codes), failures),
            self.doubts.bits(len(codes), doubts),
        )

    def _add(self, *columns) -> None:
        first, self.done = self.done, self.done + len(columns[0])
        for whole, column in zip(self._columns, columns, strict=True):
            whole[first : self.done] = column
        self._watched[first : self.done] = columns[1][:, self.study.quantities.index(self.rule.quantity)]
        if self.keep and len(columns[0]):
            self.keep(*columns, tuple(self.reasons.sentences), tuple(self.doubts.sentences))

    def arrays(self) -> tuple[np.ndarray, ...]:
        """Values (n, d), quantities (n, q), histories (n, h, points), status (n,) and doubts (n,) of all so far."""
        return tuple(whole[: self.done] for whole in self._columns)

    def _look(self, sample) -> bool:
        """Adds to the convergence path; whether the interval is narrow enough."""
        try:
            found = estimate(sample, self.rule.asked, replicates=self.points.replicates)
        except StatisticError:
            return False
        self.path.append((len(sample), found))
        return self.rule.bounds and self.rule.satisfied(found.value, found.half_width)

    def tell_more(self, done: int) -> None:
        """Progress of further realisations, for a purpose of their own: `done` of them."""
        self._tell(self.done + done)

    @property
    def _total(self) -> int:
        """The greatest number of realisations of the study; of an expansion and an interpolant, what they may take."""
        settings = self.study.settings
        further = self.study.sensitivity_rows * (self.study.joint.dimension + 2)
        if settings.method == "chaos":
            return further + MOST_RUNS
        interpolated = settings.method == "change_of_variable" and not self.study.histories
        return further + (LADDER[-1] if interpolated else self.points.samples)

    def _tell(self, done) -> None:
        total, spent = self._total, time.monotonic() - self.began
        found = self.path[-1][1] if self.path else None
        value, half_width = (found.value, found.half_width) if found else (np.nan, np.nan)
        self.progress(Progress(done, total, value, half_width, spent * (total - done) / max(done, 1)))
