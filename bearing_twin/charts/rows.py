"""The table of a chart: a row a run, the same columns for every chart, and what the numbers were made with."""

import csv
import dataclasses
import datetime
import functools
import importlib.metadata
import math
import platform
import subprocess
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from bearing_twin import __version__
from bearing_twin.base.errors import BearingTwinError
from bearing_twin.base.paths import drafted

DONE, REFUSED, FAILED, STOPPED = "done", "refused", "failed", "stopped"
MADE = "made"  # the last column: software with its commit, libraries, processor, day
LIBRARIES = "numpy", "scipy"


@dataclasses.dataclass(frozen=True)
class Row:
    """One run of a chart.

    `setting` is the number a method is tuned by (a tolerance, a step, a size), `across` a number that the problem is
    varied by; NaN where there is none. `error` is relative, infinite without a result. `seconds` are CPU seconds,
    `spread` the range of the middle half of their repeats over the median. `command` repeats the run.
    `more` holds further columns of the chart, by name with unit.
    """

    problem: str
    method: str
    setting: float = math.nan
    across: float = math.nan
    error: float = math.inf
    seconds: float = math.nan
    spread: float = math.nan
    evaluations: float = math.nan
    status: str = FAILED
    reason: str = ""
    command: str = ""
    more: dict[str, Any] = dataclasses.field(default_factory=dict)


COLUMNS = tuple(field.name for field in dataclasses.fields(Row) if field.name != "more")
WORDS = ("problem", "method", "status", "reason", "command")


def write_table(rows: Sequence[Row], path: Path) -> None:
    """Writes rows as comma-separated values; raises BearingTwinError where that is impossible."""
    further = list(dict.fromkeys(name for row in rows for name in row.more))
    header = [*COLUMNS, *further]
    write_rows(
        path,
        header,
        ([_word(getattr(row, name)) for name in COLUMNS] + [_word(row.more.get(name, "")) for name in further]
         for row in rows),
    )  # fmt: skip


def read_table(path: Path) -> list[Row]:
    """The rows that `write_table` wrote; raises OSError without a table, ValueError where it is none of a chart."""
    with path.open(encoding="utf-8", newline="") as stream:
        header, *lines = list(csv.reader(stream)) or [[]]
    if tuple(header[: len(COLUMNS)]) != COLUMNS or header[-1] != MADE:
        raise ValueError(f"{path.name} is no table of a chart of this version")
    rows = []
    for line in lines:
        cells = dict(zip(header, line, strict=True))
        own = {name: cells[name] if name in WORDS else float(cells[name]) for name in COLUMNS}
        rows.append(Row(**own, more={name: _number(cells[name]) for name in header[len(COLUMNS) : -1] if cells[name]}))
    return rows


def write_rows(path: Path, header: Sequence[str], rows: Iterable[Iterable]) -> None:
    """Writes a header and rows with the column `made`, whole or not at all; raises BearingTwinError where it cannot."""
    try:
        with drafted(path) as draft, draft.open("w", newline="", encoding="utf-8") as stream:
            table = csv.writer(stream)
            table.writerow([*header, MADE])
            table.writerows([*row, made()] for row in rows)
    except OSError as error:
        raise BearingTwinError(f"{path} cannot be written ({error.strerror}); give another folder") from error


def _word(value: Any) -> Any:
    return f"{value:.9g}" if isinstance(value, float) else value


def _number(word: str) -> float | str:
    try:
        return float(word)
    except ValueError:
        return word


def processor() -> str:
    """The processor's name."""
    cpus = Path("/proc/cpuinfo")
    lines = cpus.read_text().splitlines() if cpus.exists() else ()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())


@functools.cache
def made() -> str:
    """Software with its commit (a + where files differ from it), libraries, processor, and day."""
    root, commit = Path(__file__).parents[2], ""
    if (root / ".git").exists():
        words = ["git", "-C", str(root), "describe", "--always", "--dirty=+", "--exclude=*"]
        try:
            commit = " " + subprocess.run(words, capture_output=True, text=True, timeout=10, check=True).stdout.strip()
        except (OSError, subprocess.SubprocessError):
            commit = ""
    libraries = (f"{name} {importlib.metadata.version(name)}" for name in LIBRARIES)
    ours = f"bearing_twin {__version__}{commit}"
    return "; ".join([ours, *libraries, processor(), str(datetime.date.today())])
