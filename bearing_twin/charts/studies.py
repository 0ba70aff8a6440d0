"""The figures of paper 3, 1 to 24, on nine sheets, with the numbers drawn."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

from bearing_twin.charts import sheets
from bearing_twin.charts.study_convergence import convergence
from bearing_twin.charts.study_discs import discs
from bearing_twin.charts.study_forces import forces
from bearing_twin.charts.study_soft import soft_case1, soft_case2, soft_fast, soft_run
from bearing_twin.charts.study_spheres import densities, speeds
from bearing_twin.errors import BearingTwinError
from bearing_twin.parameters import echo, unknown


class Row(NamedTuple):
    """A sheet: the figures of paper 3 on it, and what makes it; `make` is told a function to call with its progress."""

    figures: tuple[int, ...]
    make: Callable[[Callable[[float], None]], sheets.Sheet]


SHEETS = {
    "densities": Row((1, 2, 10, 11), densities),
    "speeds": Row((3, 4, 5, 6, 7), speeds),
    "forces": Row((8,), forces),
    "convergence": Row((9,), convergence),
    "discs": Row((13, 14), discs),
    "soft_run": Row((12,), soft_run),
    "soft_fast": Row((15, 16), soft_fast),
    "soft_case1": Row((17, 18, 19, 20), soft_case1),
    "soft_case2": Row((21, 22, 23, 24), soft_case2),
}


class Written(NamedTuple):
    """One sheet as files, and the sentences that read it."""

    name: str
    picture: str
    table: str
    reading: list[str]


def wanted_sheets(words: Iterable[str]) -> list[str]:
    """Names of the sheets asked for by name or by number of a figure, in their order; all for no words.

    Raises BearingTwinError for what is neither.
    """
    words = list(words)
    by_figure = {str(figure): name for name, row in SHEETS.items() for figure in row.figures}
    for word in words:
        if word not in SHEETS and word not in by_figure:
            legal = (*SHEETS, *sorted(by_figure, key=int))
            raise BearingTwinError(f"{echo(word)} is neither a sheet nor a figure on one; {unknown(word, legal)}")
    asked = {by_figure.get(word, word) for word in words}
    return [name for name in SHEETS if not asked or name in asked]


def write(name: str, folder: Path, update: Callable[[float], None] = lambda share: None) -> Written:
    """Makes one sheet: its picture and its table in `folder`."""
    sheet = SHEETS[name].make(update)
    picture = sheets.draw(sheet, folder / f"study_{name}.png")
    table = sheets.write_table(sheet, folder / f"study_{name}.csv")
    return Written(name, str(picture), str(table), sheet.reading)
