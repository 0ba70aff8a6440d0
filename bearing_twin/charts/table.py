"""The table beside a picture: rows as comma-separated values, and the one row of all charts that compare methods."""

import csv
import dataclasses
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self, get_type_hints

from bearing_twin.charts.made import made
from bearing_twin.paths import drafted

DONE, REFUSED, FAILED, STOPPED = ("done", "refused", "failed", "stopped")
UNSURE = 0.1  # spread of a cost beyond which it is flagged; differences of that size are then none
MADE = "made"  # the last column, which no row holds: tables of earlier versions lack it
NEWER = ("spread", "api_load_error", "api_friction_error", "api_seconds", "api_spread", "simulated")
"""Columns that tables of earlier versions lack."""


@dataclass(frozen=True)
class Row:
    """One run of a contest: what ran, its relative errors of load and of friction, CPU seconds, evaluations, its end.

    `setting` is the number that a method is tuned by, or that is varied. An error is NaN where there is none of that
    sort. `command` repeats the run where the software does not refuse it, "" where nothing does. `spread` is that of
    the seconds over their repeats (`charts.timing`), NaN where they were measured once. A chart that has more to say
    has a class of its own, whose further columns stand behind these.
    """

    problem: str
    method: str
    setting: float
    load_error: float = math.nan
    friction_error: float = math.nan
    seconds: float = math.nan
    evaluations: float = math.nan
    status: str = FAILED
    reason: str = ""
    command: str = ""
    spread: float = math.nan

    @property
    def unsure(self) -> bool:
        """Whether repeats of the run differ so much in cost that it is known to no better than UNSURE."""
        return self.spread > UNSURE

    @property
    def error(self) -> float:
        """The greater of both errors; infinite where there is no result."""
        known = [one for one in (self.load_error, self.friction_error) if not math.isnan(one)]
        return max(known) if known and self.status == DONE else math.inf

    def but(self, **changes) -> Self:
        """The same with other values for some fields."""
        return dataclasses.replace(self, **changes)


@dataclass(frozen=True)
class MapRow(Row):
    """One cell of a map: `across` is its second number."""

    across: float = math.nan


def columns_of(kind: type) -> list[str]:
    """The columns of a dataclass of rows: its fields but those that are not to be printed."""
    return [field.name for field in dataclasses.fields(kind) if field.repr]


def write_table(rows: Sequence, path: Path, kind: type | None = None) -> None:
    """Writes rows, all of the dataclass `kind` (of the first), fractions with nine digits; raises as `write_rows`."""
    names = columns_of(kind or type(rows[0]))
    write_rows(path, names, ([_word(getattr(row, name)) for name in names] for row in rows))


def write_rows(path: Path, header: Iterable[str], rows: Iterable[Iterable]) -> None:
    """Writes a header and rows, and what they were made with, whole or not at all; raises OSError where it cannot."""
    with drafted(path) as draft, draft.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream)
        table.writerow([*header, MADE])
        table.writerows([*row, made()] for row in rows)


def read_table(path: Path, kind: type = Row) -> list:
    """The rows that `write_table` wrote, today or before there were the columns NEWER.

    Raises OSError where there is no table, and ValueError where it is another chart's or a cell is no value.
    """
    names = columns_of(kind)
    with path.open(encoding="utf-8", newline="") as stream:
        header, *lines = list(csv.reader(stream)) or [[]]
    if header[-1:] == [MADE]:
        header, *lines = (line[:-1] for line in (header, *lines))
    if header == [name for name in names if name in header or name not in NEWER]:
        names = header
    if header != names:
        odd = next((name for name in (*names, *header) if (name in names) != (name in header)), "the order")
        raise ValueError(f"{path.name} is no table of this chart: its columns differ in {odd}")
    hints = get_type_hints(kind)
    return [kind(**{name: _value(hints[name], word) for name, word in zip(names, line, strict=True)}) for line in lines]


def _word(value: Any) -> Any:
    if not isinstance(value, float):
        return value
    return f"{value:.15g}" if value.is_integer() else f"{value:.9g}"


def _value(kind: type, word: str) -> Any:
    return word == "True" if kind is bool else kind(word)
