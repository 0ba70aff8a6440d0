"""Pictures of charts: panels of lines, bands and maps as data, in SI units; the labels of axes have prefixes."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from matplotlib.colors import LogNorm, PowerNorm
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator

from bearing_twin.base.units import axis_label, inverse_unit
from bearing_twin.pictures import BALL_COLOURS, STYLE, ball_style, heading, readable_scale, style_axes

WIDTH, ROW = 16.0, 4.4  # inches: of a picture, of a row of panels
PLAIN_RANGE = 1e-2, 1e4  # numbers beside a wider axis that are no powers
WIDE_RANGE = 100.0  # of an axis that spans less, 2 and 5 are labelled too
LEGEND_WIDTH = 170  # letters of a line of the legend below all panels
MOST_TICKS = 6  # intervals of a linear axis, so that numbers of six digits stand apart
MOST_INSIDE = 6  # entries of a legend that stands inside its panel
OUTSIDE = "beside"  # the place of a legend for which no corner of its panel is free
WITHOUT_RESULT = ", no result"  # behind the name of a method
CROSS = {"marker": "x", "markersize": 9, "markeredgewidth": 2.5, "linestyle": ""}


class Axis(NamedTuple):
    """Quantity and SI unit of an axis.

    `shown` is the (unit, factor into it) that its numbers have, if not a prefix; ticks are whole numbers where it
    `is_integer`.
    """

    name: str
    unit: str = "1"
    log: bool = False
    limits: tuple | None = None  # in SI
    shown: tuple[str, float] | None = None
    is_integer: bool = False


class Line(NamedTuple):
    """A curve (n,) over x (n,); `style` as matplotlib's plot takes it."""

    name: str
    x: Any
    y: Any
    style: dict
    label: bool = True

    def draw(self, axis, **named) -> None:
        """Draws it."""
        axis.plot(self.x, self.y, **named, **self.style)


class Band(NamedTuple):
    """The area between two curves."""

    name: str
    x: Any
    low: Any
    high: Any
    style: dict
    label: bool = True

    def draw(self, axis, **named) -> None:
        """Draws it."""
        axis.fill_between(self.x, self.low, self.high, linewidth=0, **named, **self.style)


class Map(NamedTuple):
    """Values z (y, x) in `unit` over a grid as colours between `limits`; it is in no table of curves.

    `power` is that of the scale of colours, 0 a logarithmic one.
    """

    name: str
    unit: str
    x: Any
    y: Any
    z: Any
    colours: str
    limits: tuple[float, float]
    power: float = 1.0
    label = False

    def draw(self, axis) -> None:
        """Draws its cells."""
        x, y = _edges(self.x, axis.get_xscale() == "log"), _edges(self.y, axis.get_yscale() == "log")
        norm = PowerNorm(self.power, *self.limits) if self.power else LogNorm(*self.limits, clip=True)
        axis.pcolormesh(x, y, self.z, cmap=self.colours, norm=norm)
        axis.grid(False)


def curves_of(part: Line | Band | Map) -> list[tuple]:
    """Name, x and y of each curve of a part; a map has none."""
    if isinstance(part, Band):
        return [(f"{part.name}, low", part.x, part.low), (f"{part.name}, high", part.x, part.high)]
    return [(part.name, part.x, part.y)] if isinstance(part, Line) else []


def _edges(centres, log: bool) -> np.ndarray:
    """Edges of cells around centres, halfway between them on the axis."""
    positions = np.log(centres) if log else np.asarray(centres, float)
    middle = 0.5 * (positions[1:] + positions[:-1])
    edges = np.concatenate([[2.0 * positions[0] - middle[0]], middle, [2.0 * positions[-1] - middle[-1]]])
    return np.exp(edges) if log else edges


@dataclass
class Panel:
    """One pair of axes with a title, which also names it in the table."""

    title: str
    x: Axis
    y: Axis
    parts: list
    legend: str | None = "best"
    equal_aspect: bool = False  # of a drawing: a length is as long on both axes
    names: tuple[str, ...] = ()  # of the values 0, 1, 2 ... up the axis, where these are no numbers


@dataclass
class Sheet:
    """One picture: rows of panels, the footer, and the sentences that read it."""

    title: str
    rows: list[list[Panel]]
    footer: str
    reading: list[str]
    shared_legend: bool = False  # one for all panels


def line_style(index: int) -> dict:
    """The style of line number `index`."""
    return {**ball_style(index), "linewidth": 2.0}


def curve(name: str, index: int, points, failed_points=()) -> list[Line]:
    """A method in the colour of that number: a line through points (x, y), crosses at those without a result."""
    style = line_style(index)
    parts = [Line(name, *(np.reshape(points, (-1, 2)).T), style | {"marker": "o", "markersize": 5})]
    if failed_points:
        cross = {**CROSS, "color": style["color"]}
        parts.append(Line(name + WITHOUT_RESULT, *np.transpose(failed_points), cross, False))
    return parts


def reference_style() -> dict:
    """The style of a reference."""
    return {"color": STYLE["ink"], "linewidth": 2.0, "linestyle": "--"}


def band_style(index: int = 0) -> dict:
    """The style of a band."""
    return {"color": BALL_COLOURS[index], "alpha": 0.22}


def legend_entries(sheet: Sheet) -> set[str]:
    """The entries of the legends of a sheet."""
    return {part.name for row in sheet.rows for panel in row for part in panel.parts if part.label and part.name}


def in_rows(panels: list[Panel], columns: int) -> list[list[Panel]]:
    """Panels side by side, so many in a row."""
    return [panels[first : first + columns] for first in range(0, len(panels), columns)]


def figure_of(sheet: Sheet, made: str = "") -> Figure:
    """The picture of a sheet, with its provenance `made`."""
    names = legend_entries(sheet) if sheet.shared_legend else ()
    columns = max(1, min(len(names), int(LEGEND_WIDTH / (7 + max(map(len, names), default=0)))))
    tall = ROW * len(sheet.rows) + 0.9 + 0.3 * -(-len(names) // columns)
    figure = Figure(figsize=(WIDTH, tall), dpi=100, facecolor="white", layout="constrained")
    figure.get_layout_engine().set(w_pad=0.1, h_pad=0.1)
    figure.suptitle(sheet.title, x=0.02, ha="left", fontsize=17, weight="bold", color=STYLE["ink"])
    boxes = figure.subfigures(len(sheet.rows), 1, squeeze=False)[:, 0]
    keys: dict[str, Any] = {}
    for box, row in zip(boxes, sheet.rows, strict=True):
        for column, panel in enumerate(row, start=1):
            axis = box.add_subplot(1, len(row), column)
            _draw_panel(box, axis, panel)
            handles, drawn_names = axis.get_legend_handles_labels()
            keys |= dict(zip(drawn_names, handles, strict=True))
            if panel.legend and not sheet.shared_legend and drawn_names:
                is_outside = len(drawn_names) > MOST_INSIDE or panel.legend == OUTSIDE
                outside = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0), "fontsize": 9}
                axis.legend(frameon=False, **(outside if is_outside else {"loc": panel.legend, "fontsize": 10.5}))
    keys = keys if sheet.shared_legend else {}
    footer = "; ".join(filter(None, (sheet.footer, made)))
    key = figure.legend(
        keys.values(), keys, loc="outside lower left", ncols=columns, title=footer, alignment="left", frameon=False,
        fontsize=12, title_fontsize=9,
    )  # fmt: skip
    key.get_title().set_color(STYLE["soft"])
    return figure


def _draw_panel(figure, axis, panel: Panel) -> None:
    heading(axis, panel.title if panel.title[1:2] == "/" else panel.title[:1].upper() + panel.title[1:])
    style_axes(axis)
    axis.set(xscale="log" if panel.x.log else "linear", yscale="log" if panel.y.log else "linear")
    for part in panel.parts:
        part.draw(axis, **({"label": part.name} if part.label else {}))
    limits = {"xlim": panel.x.limits, "ylim": panel.y.limits}
    axis.set(**{name: limit for name, limit in limits.items() if limit})  # None would fix those that are
    if panel.equal_aspect:
        axis.set_aspect("equal", adjustable="datalim")
    x_factor, unit = _label(axis.xaxis, panel.x)
    density = (1.0 / x_factor, inverse_unit(unit)) if panel.y.unit == f"1/{panel.x.unit}" else None
    y_factor, unit = _label(axis.yaxis, panel.y, density)
    if panel.names:
        axis.set_yticks(range(len(panel.names)), panel.names)
    for part, drawn in zip((part for part in panel.parts if isinstance(part, Map)), axis.collections, strict=False):
        colour_factor, colour_unit = (
            (1.0 / y_factor, inverse_unit(unit)) if part.unit == f"1/{panel.y.unit}" else (1.0, part.unit)
        )
        beyond = np.nanmax(part.z, initial=part.limits[0]) > part.limits[1]
        bar = figure.colorbar(drawn, ax=axis, pad=0.02, extend="max" if beyond else "neither")
        bar.outline.set_visible(False)
        bar.set_label(axis_label(part.name, colour_unit), fontsize=11, color=STYLE["ink"])
        bar.ax.tick_params(length=0, labelsize=10, labelcolor=STYLE["ink"])
        if colour_factor != 1.0:
            bar.ax.yaxis.set_major_formatter(_plain(colour_factor))


def _label(along, axis: Axis, density: tuple[float, str] | None = None) -> tuple[float, str]:
    """Label and ticks of an axis in a readable unit, or in that of a `density`; the factor into that unit, and it."""
    low, high = along.get_view_interval()
    shown = axis.shown[::-1] if axis.shown else density
    factor, unit = shown or readable_scale([low, high], axis.unit)
    along.set_label_text(axis_label(axis.name, unit))
    wide = axis.log and high > WIDE_RANGE * low
    if axis.log:
        along.set_major_locator(LogLocator(subs=(1.0,) if wide else (1.0, 2.0, 5.0)))
        along.set_minor_locator(NullLocator())
    else:  # round in the unit that is shown
        locator = MaxNLocator(MOST_TICKS, steps=[1, 2, 2.5, 5, 10], integer=axis.is_integer, min_n_ticks=1)
        ticks = locator.tick_values(factor * low, factor * high) / factor
        along.set_ticks(ticks[(low <= ticks) & (ticks <= high)])
    written_out = not wide or (factor * low > PLAIN_RANGE[0] and factor * high < PLAIN_RANGE[1])
    along.set_major_formatter(_plain(factor) if written_out else _powers(factor))
    return factor, unit


def _plain(factor: float) -> Callable[[float, int], str]:
    return lambda value, _: f"{factor * value:.6g}"


def _powers(factor: float) -> Callable[[float, int], str]:
    return lambda value, _: f"$10^{{{round(math.log10(factor * value))}}}$"
