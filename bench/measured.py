"""The table of what everything costs, which `table.py` measures: its rows, and what they are judged by."""

import csv
from collections.abc import Iterable
from dataclasses import astuple, dataclass, fields
from pathlib import Path

import numpy as np

TABLE = Path(__file__).resolve().parent.parent / "docs" / "speed.csv"
# ns that a contact takes where goals are of. They are of a machine that took 10.5, by a kernel that took 1.39 times as
# long as today's (pairs on an Intel Xeon, 2026-11-27).
YARDSTICK = 7.6
SPEED, TIMES = "times real time", ("s", "ms", "us", "% of a core")  # units that are scaled; others are of no machine


@dataclass(frozen=True)
class Measured:
    """A row: what, how it is measured, the goal, whether more or less is better, and what was found where and when.

    `contact` is what a contact took there [ns].
    """

    what: str
    how: str
    goal: float
    better: str
    unit: str
    found: float = np.nan
    machine: str = ""
    contact: float = np.nan
    day: str = ""

    @property
    def timed(self) -> bool:
        """Whether it depends on how fast the machine is."""
        return self.unit in (SPEED, *TIMES)

    @property
    def scaled(self) -> float:
        """What was found as it would be where a contact takes YARDSTICK; as it is where that says nothing of it."""
        slower = self.contact / YARDSTICK
        times = slower if self.unit == SPEED else 1.0 / slower
        return float(f"{(times if self.timed else 1.0) * self.found:.3g}")

    @property
    def met(self) -> bool:
        """Whether what was found is as good as the goal."""
        return self.scaled == self.goal or (self.scaled > self.goal) == (self.better == "more")


def kept() -> list[Measured]:
    """The rows of the table."""
    if not TABLE.exists():
        return []
    with TABLE.open(newline="", encoding="utf-8") as stream:
        return [
            Measured(**{field.name: field.type(line[field.name]) for field in fields(Measured)})
            for line in csv.DictReader(stream)
        ]


def keep(rows: list[Measured], order: Iterable[Measured]) -> None:
    """Puts rows into the table, those of the same name replaced, in this order."""
    known = {row.what: row for row in (*kept(), *rows)}
    with TABLE.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(field.name for field in fields(Measured))
        for row in order:
            if row.what in known:
                numbers = (f"{one:g}" if isinstance(one, (int, float)) else one for one in astuple(known[row.what]))
                table.writerow(numbers)
