"""A paper's figures on sheets: a picture and a table of its curves for each, with the sentences that read it."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.charts.contest import Asked, Made, sources, wanted_of
from bearing_twin.charts.panels import Sheet, draw, write_curves


class Figures(NamedTuple):
    """A sheet: the figures of the paper on it, and what makes it; `make(quick)` is coarse where it is quick."""

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
        """Draws the sheets asked for; those that an interrupted run has finished are not repeated."""
        named = {self.problems[one] for one in wanted_of(asked.problems, self.problems)}
        wanted = [sheet for sheet in self.sheets if sheet in named]
        kept, made = folder / f"{name}.unfinished", Made([], [], [], [])
        before = kept.read_text(encoding="utf-8").splitlines() if kept.is_file() else []
        finished = before[1:] if before[:1] == [sources()] else []
        for place, sheet in enumerate(wanted):
            picture, table = (folder / f"{name}_{sheet}.{ending}" for ending in ("png", "csv"))
            reading = folder / f"{name}_{sheet}.txt"
            if sheet not in finished or not (picture.is_file() and table.is_file() and reading.is_file()):
                found = self.sheets[sheet].make(asked.quick)
                try:
                    write_curves(found, table)
                    reading.write_text("\n".join(found.reading) + "\n", encoding="utf-8")
                    kept.write_text("\n".join([sources(), *finished, sheet]) + "\n", encoding="utf-8")
                except OSError as error:
                    raise BearingTwinError(f"{error.filename} cannot be written ({error.strerror})") from error
                draw(found, picture)
                finished.append(sheet)
            made.reading.extend(reading.read_text(encoding="utf-8").splitlines())
            made.pictures.append(str(picture))
            made.tables.append(str(table))
            asked.update((place + 1) / len(wanted))
        kept.unlink(missing_ok=True)
        return made

    def read_again(self, folder: Path, name: str) -> list[str]:
        """The sentences of the sheets that were made in a folder; raises OSError where there are none."""
        found = [folder / f"{name}_{sheet}.txt" for sheet in self.sheets]
        found = [one for one in found if one.is_file()] or found[:1]
        return [line for one in found for line in one.read_text(encoding="utf-8").splitlines()]
