"""A second, more exact computation beside a run: by how much the figures of the first are off, and what is promised.

What is solved at once is solved twice (`row_of` makes the record); what moves on has a finer motion beside it
(`WithSecondRun`), from the same start, so that inherited errors are seen as well. Both give rows of the table
`companion`, the last of which holds for the run so far; a log has them too.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.errors import IntegrationError
from bearing_twin.kinds.doubt import CHAOTIC, FRICTION_MODEL, LATER, LAW, LEFT_OUT, METHOD, Errors, Promise, horizon
from bearing_twin.sample import Block, Channel, Table
from bearing_twin.units import symbol_of

COMPANION = "companion"
HEAD = (
    Channel("time", "s", (), "to where this row holds"),
    Channel("followed", "s", (), "to where the second computation went"),
    Channel("kept", "s", (), "to where every output wanted was within the tolerance"),
    Channel("grown", "1", (), "error of the outputs wanted, over what it was when the first contact had ended"),
    Channel("steps", "1", (), "that the second computation took"),
)
TIME, FOLLOWED, KEPT, GROWN = range(4)
OFTEN = 1.02  # times the time of the last row, when the next is made: long runs do not compare for ever
SHORT, SHARE = 5000, 0.3  # steps that a second motion may take, and share of the run's beyond them
ROUNDING = 1e-12  # of a figure: no error is said to be smaller


class Watch(NamedTuple):
    """What a second computation of a kind looks at: `figures` by key, and `outputs` wanted, name to norm.

    Errors of outputs do not grow while the figures `steady` stay as they are.
    """

    figures: tuple[str, ...]
    outputs: Mapping[str, str]
    steady: tuple[str, ...] = ()

    def table(self, meanings: Mapping[str, str]) -> Table:
        """The table of its rows."""
        wanted = [Channel(f"of_{name}", "1", (), f"error of {name}, {norm}") for name, norm in self.outputs.items()]
        rest = [Channel(f"of_{key}", symbol_of(key), (), f"error of: {meanings[key]}") for key in self.figures]
        meaning = "by how much the run so far differs from a second, more exact computation of it"
        return Table(COMPANION, (*HEAD, *wanted, *rest), meaning, needed=False)

    def no_row(self) -> np.ndarray:
        """The rows (0, columns) of a run that was not compared."""
        return np.empty((0, len(HEAD) + len(self.outputs) + len(self.figures)))

    def row(self, head: tuple[float, ...], wanted: Mapping[str, float], errors: Mapping[str, float]) -> np.ndarray:
        """A row of the table."""
        return np.array([*head, *(wanted[name] for name in self.outputs), *(errors[key] for key in self.figures)])


def is_watched(parameters) -> bool:
    """Whether a scene asks for a second computation."""
    return parameters.solver.check == "second_run"


def tables_with(watch: Watch, meanings: Mapping[str, str], parameters, *own: Table) -> tuple[Table, ...]:
    """A kind's own tables, and that of the second computation where there is one."""
    return (*own, watch.table(meanings)) if is_watched(parameters) else own


def difference(value, finer) -> float:
    """By how much a figure is off, a list at most: NaN where neither has one, infinite where one of them alone has."""
    if value is None or finer is None:
        return math.nan if value is finer else math.inf
    if isinstance(value, list):
        return max((difference(*pair) for pair in zip(value, finer, strict=True)), default=0.0)
    if isinstance(value, int) and isinstance(finer, int):
        return float(abs(value - finer))
    return max(abs(value - finer), ROUNDING * abs(finer))


def row_of(watch: Watch, seconds: float, kept: bool, steps: int, wanted, errors) -> np.ndarray:
    """The one row (1, columns) of what is solved at once."""
    return watch.row((seconds, seconds, seconds if kept else 0.0, 1.0, float(steps)), wanted, errors)[None]


class WithSecondRun:
    """A motion, with a finer one of the same scene beside it; its outputs and records are the first one's.

    `figures()` makes an empty writer of figures; `wanted(figures, finer)` compares two of them and gives the error of
    every output of the `watch`. After `short` steps and SHARE of the run's the finer motion is left behind.
    """

    def __init__(self, motions, channels, figures, watch: Watch, wanted: Callable, parameters, short=SHORT):
        self._motion, self._finer = motions
        self._channels, self._new_figures = channels, figures
        self._watch, self._wanted, self._parameters, self._short = watch, wanted, parameters, short
        if hasattr(self._motion, "snapshot"):
            self.snapshot = self._motion.snapshot
        self._begin()

    @property
    def stop(self) -> np.ndarray:
        """What stops both, see `Motion`."""
        return self._motion.stop

    @stop.setter
    def stop(self, stop: np.ndarray) -> None:
        self._motion.stop = self._finer.stop = stop

    def _begin(self) -> None:
        self._figures = self._new_figures(), self._new_figures()
        self._now = self._followed = self._kept = self._told = 0.0
        self._following, self._records = True, {}
        self._first, self._row, self._left_with = 0.0, None, {}

    def reset(self) -> None:
        self._motion.reset()
        self._finer.reset()
        self._begin()

    def resume(self, kept: dict) -> None:
        """To a state that `snapshot` gave; what had happened until then is not compared."""
        self.reset()
        self._motion.resume(kept)
        self._finer.resume(kept)
        self._now = self._followed = self._kept = float(kept["now"])

    def first_outputs(self):
        """The outputs at the present instant."""
        values = self._motion.first_outputs()
        records = self._motion.take_records()
        self._add(0, np.zeros(1), values, records)
        self._add(1, np.zeros(1), self._finer.first_outputs(), self._finer.take_records())
        self._records = records
        return values

    def advance(self, times: np.ndarray, duration: float):
        """Moves both on; the outputs are the first one's."""
        self._motion.keep()
        self._finer.keep()
        values, records = self._motion.advance(times, duration), self._motion.take_records()
        if self._following:
            try:
                finer = self._finer.advance(times, duration)
            except IntegrationError:
                self._following = False
            else:
                self._add(1, times, finer, self._finer.take_records())
        self._add(0, times, values, records)
        until = self._now + float(times[-1])
        if until >= min(OFTEN * self._told, self._parameters.run.duration - duration / len(times)):
            if self._following:
                self._compare(until)
            if self._row is not None:
                records[COMPANION] = self._row_at(until)[None]
            self._told = until
        self._now += duration
        self._records = records
        return values

    def take_back(self) -> None:
        """Back to before the last `advance`, which was broken off: nothing of it is in the figures."""
        self._motion.take_back()
        self._finer.take_back()

    def _row_at(self, until: float) -> np.ndarray:
        """The last row; after the second motion was left, with errors that grow as time goes by.

        Figures that have not changed since then keep theirs.
        """
        row = self._row.copy()
        row[TIME] = until
        if until > self._followed > 0.0:
            own, beyond = self._figures[0].figures(), until / self._followed
            if any(own[key] != self._left_with[key] for key in self._watch.steady):
                row[len(HEAD) :][: len(self._watch.outputs)] *= beyond
            still = [own[key] == self._left_with[key] for key in self._watch.figures]
            row[len(HEAD) + len(self._watch.outputs) :] *= np.where(still, 1.0, beyond)
        return row

    def _add(self, which: int, times, values, records) -> None:
        time_ns = np.rint(1e9 * (self._now + np.asarray(times, float))).astype(np.int64)
        if not isinstance(values, Mapping):
            values = dict(zip((channel.name for channel in self._channels), values, strict=True))
        self._figures[which].add(Block(self._channels, 0, time_ns, values, records))

    def _compare(self, until: float) -> None:
        own, finer = self._figures
        wanted = self._wanted(own, finer)
        worst = max(wanted.values(), default=0.0)
        if worst <= self._parameters.wanted.tolerance:
            self._kept = until
        self._first = self._first or worst
        self._followed = until
        grown = worst / self._first if self._first > 0.0 else 1.0
        steps = self._finer.costs()["steps"]
        self._left_with = own.figures()
        exact = finer.figures()
        errors = {key: difference(self._left_with[key], exact[key]) for key in self._watch.figures}
        self._row = self._watch.row((until, until, self._kept, grown, float(steps)), wanted, errors)
        self._following = steps <= max(self._short, SHARE * self._motion.costs()["steps"])

    def take_records(self) -> dict[str, np.ndarray]:
        """The records since the last call, and a row of the comparison."""
        records, self._records = self._records, {}
        return records

    def costs(self) -> dict[str, int]:
        """Of the first motion, and the steps of the second."""
        return self._motion.costs() | {"companion_steps": self._finer.costs()["steps"]}


class SecondRunDoubt:
    """What figures are worth by the last row of a second computation; a kind adds law, friction, what is left out."""

    in_stretches, errorless = False, ("energy_closure", "impact_speed_m_s")
    watch: Watch
    mend = "set a tenth of wanted.tolerance"

    def __init__(self, parameters, choice):
        self.parameters, self.choice = parameters, choice
        self.row: np.ndarray | None = None

    def add(self, block: Block) -> None:
        for row in block.records.get(COMPANION, ()):
            self.row = np.array(row)

    def law(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Errors of the elastic law by figure."""
        return {}

    def law_of(self, output: str) -> tuple[float, str]:
        """Error of the elastic law in an output wanted, in its norm, and what would mend it."""
        return 0.0, ""

    def friction(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Errors of the friction model by figure."""
        return {}

    def left_out(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Errors of what the model leaves out by figure."""
        return {}

    def notes(self) -> dict[str, str]:
        """Sentences on what is not in the errors, by source and by what is left out."""
        return {}

    def promised(self) -> tuple[str, ...]:
        """The outputs that are wanted: all, or the peaks of an impact alone."""
        return ("peaks",) if self.parameters.wanted.outputs == "peaks" else tuple(self.watch.outputs)

    def errors(self, figures: Mapping[str, Any]) -> Errors:
        found: dict[str, dict[str, Any]] = {}
        by_source = {METHOD: self._method(), LAW: self.law(figures), FRICTION_MODEL: self.friction(figures)}
        by_source[LEFT_OUT] = self.left_out(figures)
        for source, errors in by_source.items():
            for key, error in errors.items():
                found.setdefault(key, {})[source] = error
        known = float(self.row[KEPT]) if self._chaotic else None
        return Errors(found, self._promises(), self._method_notes() | self.notes(), horizon=known)

    def _method(self) -> dict[str, float]:
        if self.row is None:
            return {}
        errors = self.row[len(HEAD) + len(self.watch.outputs) :]
        known = zip(self.watch.figures, map(float, errors), strict=False)  # an earlier version has the first alone
        return {key: error for key, error in known if not math.isnan(error)}

    def _promises(self) -> tuple[Promise, ...]:
        wanted, found = self.parameters.wanted.tolerance, []
        for name in self.promised():
            norm, method, where = self.watch.outputs[name], None, ""
            law, mend = self.law_of(name)
            if self.row is not None:
                method = float(self.row[len(HEAD) + list(self.watch.outputs).index(name)])
                if method > wanted and 0.0 < self.row[KEPT] < self.row[TIME]:
                    where = f"within it up to {self.row[KEPT]:.6g} s"
            whole = None if method is None else method + law
            cure = mend if method is None or law > method else LATER if self._chaotic else self.mend
            found.append(Promise(name, norm, whole, wanted, where, cure))
        return tuple(found)

    @property
    def _chaotic(self) -> bool:
        """Whether errors have grown so far that the motion, not the method, sets them."""
        return self.row is not None and self.row[GROWN] > CHAOTIC and self.row[KEPT] < self.row[TIME]

    def _method_notes(self) -> dict[str, str]:
        if not is_watched(self.parameters):
            return {METHOD: "solver.check: none, so nothing is known of the error of the method"}
        if self.row is None:
            return {METHOD: "nothing has been compared with a second computation yet"}
        notes = {}
        if self.row[FOLLOWED] < self.row[TIME]:
            notes[METHOD] = (
                f"the second computation went to {self.row[FOLLOWED]:.4g} s; errors are taken to grow with time from "
                "there on"
            )
        if self._chaotic:
            notes["horizon"] = horizon(self.row[GROWN], "the first contact", self.row[KEPT])
        return notes
