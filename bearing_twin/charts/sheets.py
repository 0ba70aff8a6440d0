"""Sheets of curves: what is drawn is what is in the table beside it. Values are SI; prefixes come with the drawing."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.colors import PowerNorm
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from bearing_twin import __version__
from bearing_twin.charts.table import write_rows
from bearing_twin.errors import BearingTwinError
from bearing_twin.parameters import echo, unknown
from bearing_twin.pictures.style import STYLE, frame, heading, scaled
from bearing_twin.pictures.worth import finish
from bearing_twin.units import inverse, labelled

WIDTH, ROW, MARGINS = 16.0, 4.6, 1.75  # inches: of a sheet, of a row of panels, of title and footer together
FEW_DECADES = 300.0  # of an axis that spans less, 2 and 5 are labelled too


class Axis(NamedTuple):
    """What an axis shows: name and SI unit; `shown` (factor, unit) where a prefix alone does not make it readable."""

    name: str
    unit: str
    log: bool = False
    limits: tuple | None = None  # in SI
    shown: tuple[float, str] | None = None


class Line(NamedTuple):
    """A curve (n,) over x (n,); `look` as matplotlib's plot takes it. An empty `label` keeps it out of the legend."""

    name: str
    x: Any
    y: Any
    look: dict
    label: bool = True


class Band(NamedTuple):
    """What lies between two curves."""

    name: str
    x: Any
    low: Any
    high: Any
    look: dict
    label: bool = True


class Bars(NamedTuple):
    """A histogram: edges (n + 1,) and heights (n,)."""

    name: str
    edges: Any
    heights: Any
    look: dict
    label: bool = True


class Dots(NamedTuple):
    """Estimates at x (n,) with their intervals."""

    name: str
    x: Any
    y: Any
    low: Any
    high: Any
    look: dict
    label: bool = True


class Map(NamedTuple):
    """Values z (y, x) in `unit` over a grid as colours between `limits`, lines at `levels`; it is in no table."""

    name: str
    unit: str
    x: Any
    y: Any
    z: Any
    colours: str
    limits: tuple[float, float]
    levels: tuple = ()
    power: float = 1.0  # of the scale of colours


@dataclass
class Panel:
    """One pair of axes: `key` names it in the table, `title` stands above it."""

    key: str
    title: str
    x: Axis
    y: Axis
    parts: list = field(default_factory=list)
    legend: str | tuple | None = "best"
    to_scale: bool = False  # of a drawing: a length is as long on both axes


@dataclass
class Sheet:
    """One picture: rows of panels, the footer, which the version ends, and the sentences that read it."""

    title: str
    rows: list[list[Panel]]
    footer: str
    reading: list[str]

    @property
    def panels(self) -> list[Panel]:
        """All panels, row by row."""
        return [panel for row in self.rows for panel in row]


class SheetRow(NamedTuple):
    """A sheet: the figures of a paper on it, and what makes it; `make` is told a function to call with its progress."""

    figures: tuple[int, ...]
    make: Callable[[Callable[[float], None]], Sheet]


class Written(NamedTuple):
    """One sheet as files, and the sentences that read it."""

    name: str
    picture: str
    table: str
    reading: list[str]


class Sheets(NamedTuple):
    """The sheets of one paper by name; their files begin with `prefix`."""

    prefix: str
    rows: dict[str, SheetRow]

    def wanted(self, words: Iterable[str]) -> list[str]:
        """Names of the sheets asked for by name or by number of a figure, in their order; all for no words.

        Raises BearingTwinError for what is neither.
        """
        words = list(words)
        by_figure = {str(figure): name for name, row in self.rows.items() for figure in row.figures}
        for word in words:
            if word not in self.rows and word not in by_figure:
                legal = (*self.rows, *sorted(by_figure, key=int))
                raise BearingTwinError(f"{echo(word)} is neither a sheet nor a figure on one; {unknown(word, legal)}")
        asked = {by_figure.get(word, word) for word in words}
        return [name for name in self.rows if not asked or name in asked]

    def write(self, name: str, folder: Path, update: Callable[[float], None] = lambda share: None) -> Written:
        """Makes one sheet: its picture and its table in `folder`."""
        sheet = self.rows[name].make(update)
        picture = draw(sheet, folder / f"{self.prefix}_{name}.png")
        table = write_table(sheet, folder / f"{self.prefix}_{name}.csv")
        return Written(name, str(picture), str(table), sheet.reading)


def draw(sheet: Sheet, path: Path) -> Path:
    """Writes the picture; raises BearingTwinError where that is impossible."""
    tall = ROW * len(sheet.rows) + MARGINS
    figure = Figure(figsize=(WIDTH, tall), dpi=100, facecolor="white")
    top, bottom = 1.0 - 1.15 / tall, 0.95 / tall
    outer = figure.add_gridspec(len(sheet.rows), 1, left=0.06, right=0.98, top=top, bottom=bottom, hspace=0.36)
    for place, row in enumerate(sheet.rows):
        inner = outer[place].subgridspec(1, len(row), wspace=0.12 + 0.06 * len(row))
        for column, panel in enumerate(row):
            _draw_panel(figure, figure.add_subplot(inner[column]), panel)
    return finish(figure, sheet.title, f"{sheet.footer}; bearing_twin {__version__}", path, size=17)


def rows_of(sheet: Sheet) -> Iterator[tuple]:
    """(panel, curve, what x is, what y is, x, y) of every point drawn, SI; a band is two curves."""
    for panel in sheet.panels:
        kinds = tuple(f"{axis.name} [{axis.unit}]" for axis in (panel.x, panel.y))
        for part in panel.parts:
            for name, x, y in _curves(part):
                for one, other in zip(x, y, strict=True):
                    yield panel.key, name, *kinds, float(one), float(other)


def write_table(sheet: Sheet, path: Path) -> Path:
    """Everything that is a curve as comma-separated values; raises BearingTwinError where that is impossible."""
    try:
        rows = ((*words, f"{x:.10g}", f"{y:.10g}") for *words, x, y in rows_of(sheet))
        write_rows(path, ["panel", "curve", "x_is", "y_is", "x", "y"], rows)
    except OSError as error:
        raise BearingTwinError(f"{path} cannot be written ({error.strerror}); give another folder") from error
    return path


def _curves(part) -> Iterable[tuple]:
    if isinstance(part, Map):
        return ()
    if isinstance(part, Bars):
        edges = np.asarray(part.edges)
        return ((part.name, 0.5 * (edges[1:] + edges[:-1]), part.heights),)
    if isinstance(part, Band):
        return ((f"{part.name}, low", part.x, part.low), (f"{part.name}, high", part.x, part.high))
    found = ((part.name, part.x, part.y),)
    if isinstance(part, Dots):
        found += ((f"{part.name}, low", part.x, part.low), (f"{part.name}, high", part.x, part.high))
    return found


def _draw_panel(figure, axis, panel):
    across, unit_x = panel.x.shown or scaled(_extent(panel, 0), panel.x.unit)
    up, unit_y = panel.y.shown or scaled(_extent(panel, 1), panel.y.unit)
    if panel.y.unit == f"1/{panel.x.unit}":  # a density
        up, unit_y = 1.0 / across, inverse(unit_x)
    frame(axis)
    for part in panel.parts:
        if isinstance(part, Map):
            per = (1.0 / up, f"1/{unit_y}") if part.unit == f"1/{panel.y.unit}" else (1.0, part.unit)
            _draw_map(figure, axis, part, across, up, *per)
        else:
            _draw_part(axis, part, across, up)
    for name, words, factor, unit in (("x", panel.x, across, unit_x), ("y", panel.y, up, unit_y)):
        getattr(axis, f"set_{name}scale")("log" if words.log else "linear")
        getattr(axis, f"set_{name}label")(labelled(words.name, unit))
        if words.limits is not None:
            low, high = (None if one is None else one * factor for one in words.limits)
            getattr(axis, f"set_{name}lim")(low, high)
    for along, words in ((axis.xaxis, panel.x), (axis.yaxis, panel.y)):
        if words.log:
            low, high = along.get_view_interval()
            along.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < FEW_DECADES * low else (1.0,)))
            along.set_major_formatter("{x:g}")
            along.set_minor_locator(NullLocator())
    if panel.to_scale:
        axis.set_aspect("equal", adjustable="datalim")
    heading(axis, panel.title)
    if panel.legend and axis.get_legend_handles_labels()[1]:
        axis.legend(frameon=False, fontsize=10.5, loc=panel.legend)


def _extent(panel, place):
    """What scales an axis: its limits where they are given, else the curves'."""
    limits = (panel.x, panel.y)[place].limits
    if limits is not None and limits[1] is not None:
        return [limits[1]]
    found = [(part.x, part.y)[place] for part in panel.parts if isinstance(part, Map)]
    found += [curve[1 + place] for part in panel.parts for curve in _curves(part)]
    return np.concatenate([np.asarray(one, float) for one in found])


def _draw_part(axis, part, across, up):
    named = {"label": part.name} if getattr(part, "label", True) else {}
    if isinstance(part, Bars):
        axis.stairs(np.multiply(part.heights, up), np.multiply(part.edges, across), **named, **part.look)
        return
    x = np.multiply(part.x, across)
    if isinstance(part, Band):
        axis.fill_between(x, np.multiply(part.low, up), np.multiply(part.high, up), linewidth=0, **named, **part.look)
    elif isinstance(part, Dots):
        spread = [np.subtract(part.y, part.low) * up, np.subtract(part.high, part.y) * up]
        axis.errorbar(x, np.multiply(part.y, up), yerr=spread, fmt="o", **named, **part.look)
    else:
        axis.plot(x, np.multiply(part.y, up), **named, **part.look)


def _draw_map(figure, axis, part, across, up, factor, unit):
    x, y, z = np.multiply(part.x, across), np.multiply(part.y, up), np.multiply(part.z, factor)
    low, high = (factor * limit for limit in part.limits)
    drawn = axis.pcolormesh(x, y, z, cmap=part.colours, norm=PowerNorm(part.power, low, high), shading="nearest")
    axis.grid(False)
    if part.levels:
        axis.contour(x, y, z, levels=factor * np.array(part.levels), colors="white", linewidths=0.8)
    bar = figure.colorbar(drawn, ax=axis, pad=0.02, extend="max" if np.nanmax(z) > high else "neither")
    bar.outline.set_visible(False)
    bar.set_label(labelled(part.name, unit), fontsize=11, color=STYLE["ink"])
    bar.ax.tick_params(length=0, labelsize=10, labelcolor=STYLE["ink"])
