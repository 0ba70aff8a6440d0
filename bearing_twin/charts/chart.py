"""One chart of rows: which problems, who takes part, what judges a run, draws the picture and reads the table."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from bearing_twin.charts.contest import Asked, Job, Made, answers_of, rows_of
from bearing_twin.charts.table import STOPPED, UNSURE, Row, read_table, write_table

FEW = 3  # of the widest costs are named


def _enough(rows: list[Row]) -> list[tuple[str, str, float]]:
    return []


def _told(update, done, part, share):
    update(done + share * part)


def stopped(rows: list[Row]) -> list[str]:
    """A sentence on who was stopped for its cost; none where nobody was."""
    told = dict.fromkeys(f"{row.method} of {row.problem} ({row.reason})" for row in rows if row.status == STOPPED)
    return [f"Without a result: {', '.join(told)}."] if told else []


def unsure(rows: list[Row]) -> list[str]:
    """A sentence on costs whose repeats lie far apart; none where none do."""
    wide = sorted((row for row in rows if row.unsure), key=lambda row: -row.spread)
    if not wide:
        return []
    worst = ", ".join(f"{one.method} of {one.problem} at {one.setting:g} ({one.spread:.0%})" for one in wide[:FEW])
    known = sum(not math.isnan(row.spread) for row in rows)
    return [f"Costs whose repeats lie over {UNSURE:.0%} apart, ringed: {len(wide)} of {known}, the widest {worst}."]


@dataclass(frozen=True, kw_only=True)
class Chart:
    """`problems` by name with their titles, and which (method, setting)s `entries` gives for each.

    `judge`, a function of a module, gives the row or the rows, all of the class `kind`, of (problem, method, setting,
    limit of CPU seconds for a run). `command` repeats a run. `further` gives, from the rows so far, the (problem,
    method, setting)s to go on with, until there are none. `drawn` draws the rows, `told` reads them.
    """

    judge: Callable[[str, str, float, float], Row | list[Row]]
    problems: dict[str, str]
    entries: Callable[[str], Iterable[tuple[str, float]]]
    kind: type[Row] = Row
    command: Callable[[str, str, float], str] = lambda name, method, setting: ""
    further: Callable[[list[Row]], list[tuple[str, str, float]]] = _enough
    drawn: Callable[[list[Row], Path], None] | None = None
    told: Callable[[list[Row]], Iterable[str]] | None = None

    def blank(self, task: Job) -> Row:
        """The row of a run before it has run."""
        name, method, setting, _ = task.arguments
        return self.kind(name, method, setting, command=self.command(name, method, setting))

    def measure(self, wanted: Asked) -> list[Row]:
        """All runs of the problems that are wanted, problem by problem and method by method."""
        waiting = [(name, *entry) for name in wanted.problems for entry in self.entries(name)]
        rows, order = [], list(dict.fromkeys(one[:2] for one in waiting))
        done, part = 0.0, 1.0 if self.further is _enough else 0.5  # nobody knows how many rounds there will be
        while waiting:
            tasks = [Job(f"{self.judge.__module__}:{self.judge.__name__}", (*one, wanted.limit)) for one in waiting]
            update = partial(_told, wanted.update, done, part)
            answers = answers_of(tasks, wanted.kept, update, wanted.workers)
            rows += rows_of(tasks, answers, self.blank, wanted.limit)
            done, part, waiting = done + part, 0.5 * part, self.further(rows)
        return rows if self.further is _enough else sorted(rows, key=lambda row: order.index((row.problem, row.method)))

    def draw(self, rows: list[Row], path: Path) -> None:
        """Writes the picture."""
        self.drawn(rows, path)

    def reading(self, rows: list[Row]) -> list[str]:
        """What the chart says, from its rows."""
        return [*self.told(rows), *unsure(rows), *stopped(rows)]

    def read(self, folder: Path, name: str) -> list[str]:
        """The same from the table that was written there before; raises as `read_table`."""
        return self.reading(read_table(folder / f"{name}.csv", self.kind))

    def make(self, folder: Path, name: str, wanted: Asked) -> Made:
        """Runs the contest, and writes picture and table."""
        rows = self.measure(wanted)
        picture, table = folder / f"{name}.png", folder / f"{name}.csv"
        self.draw(rows, picture)
        write_table(rows, table, self.kind)
        return Made(self.reading(rows), [str(picture)], [str(table)], rows)
