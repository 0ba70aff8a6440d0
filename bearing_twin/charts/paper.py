"""A paper's figures on sheets: a picture and a table of its curves for each, with the sentences that read it."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from bearing_twin.charts.contest import Asked, Kept, Made, wanted_of
from bearing_twin.charts.panels import Sheet, draw, write_curves
from bearing_twin.charts.rows import Row


class Figures(NamedTuple):
    """A sheet: the figures of the paper on it, and the function that makes it; `make(quick)` is coarse if quick."""

    figures: tuple[int, ...]
    make: Callable[[bool], Sheet]


@dataclass(frozen=True)
class Paper:
    """The sheets of a paper by name; a sheet is also found by the number of a figure on it."""

    sheets: dict[str, Figures]

    @property
    def problems(self) -> dict[str, str]:
        """Names of sheets and numbers of figures, with the sheet they stand on."""
        numbers = {str(figure): name for name, row in self.sheets.items() for figure in row.figures}
        return {name: name for name in self.sheets} | numbers

    def make(self, folder: Path, name: str, asked: Asked) -> Made:
        """Draws the requested sheets; those that an interrupted run has finished are not repeated."""
        wanted = dict.fromkeys(self.problems[one] for one in wanted_of(asked.problems, self.problems))
        kept, made = Kept(folder / f"{name}.unfinished"), Made([], [], [], [])
        for place, sheet in enumerate(wanted, start=1):
            picture, table, reading = (folder / f"{name}_{sheet}.{ending}" for ending in ("png", "csv", "txt"))
            if sheet not in kept.rows or not (picture.is_file() and table.is_file() and reading.is_file()):
                found = self.sheets[sheet].make(asked.quick)
                write_curves(found, table)
                reading.write_text("\n".join(found.reading) + "\n", encoding="utf-8")
                draw(found, picture)
                kept.put(sheet, Row(name, sheet))
            made.reading.extend(reading.read_text(encoding="utf-8").splitlines())
            made.pictures.append(str(picture))
            made.tables.append(str(table))
            asked.update(place / len(wanted))
        kept.drop()
        return made

    def read_again(self, folder: Path, name: str) -> list[str]:
        """The sentences of the sheets that were made in a folder; raises OSError where there are none."""
        found = [folder / f"{name}_{sheet}.txt" for sheet in self.sheets]
        found = [one for one in found if one.is_file()] or found[:1]
        return [line for one in found for line in one.read_text(encoding="utf-8").splitlines()]
