"""Pictures of charts: panels of lines, bands, bars and maps as data. Values are SI; prefixes come with the drawing."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.colors import LogNorm, PowerNorm
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from bearing_twin.base.units import inverse, labelled
from bearing_twin.charts.rows import made, write_rows
from bearing_twin.pictures.style import BALL_COLOURS, STYLE, ball_line, frame, heading, save, scaled

WIDTH, ROW = 16.0, 4.4  # inches: of a picture, of a row of panels
FEW_DECADES = 300.0  # of an axis that spans less, 2 and 5 are labelled too
KEY_WIDTH = 170  # letters of a line of the legend below all panels
MANY = 8  # entries of a legend of one column
CROSS = {"marker": "x", "markersize": 9, "markeredgewidth": 2.5, "linestyle": ""}


class Axis(NamedTuple):
    """Quantity and SI unit of an axis; `shown` (factor, unit) where a prefix alone does not make it readable."""

    name: str
    unit: str = "1"
    log: bool = False
    limits: tuple | None = None  # in SI
    shown: tuple[float, str] | None = None


class Line(NamedTuple):
    """A curve (n,) over x (n,); `look` as matplotlib's plot takes it."""

    name: str
    x: Any
    y: Any
    look: dict
    label: bool = True


class Band(NamedTuple):
    """The area between two curves."""

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


@dataclass
class Panel:
    """One pair of axes with a title, which also names it in the table."""

    title: str
    x: Axis
    y: Axis
    parts: list
    legend: str | None = "best"
    to_scale: bool = False  # of a drawing: a length is as long on both axes
    names: tuple[str, ...] = ()  # of the values 0, 1, 2 ... up the axis, where these are no numbers


@dataclass
class Sheet:
    """One picture: rows of panels, the footer, and the sentences that read it; with a `key`, one legend for all."""

    title: str
    rows: list[list[Panel]]
    footer: str
    reading: list[str]
    key: bool = False


def colour(place: int) -> dict:
    """The look of the line number `place`."""
    return {**ball_line(place), "linewidth": 2.0}


def curve(name: str, points, number: int, lost=(), marker: str = "o") -> list[Line]:
    """A method in its colour: a line through points (x, y), crosses at those without a result."""
    look = colour(number)
    parts = [
        Line(name, [one[0] for one in points], [one[1] for one in points], look | {"marker": marker, "markersize": 5})
    ]
    if lost:
        cross = {**CROSS, "color": look["color"]}
        parts.append(Line(f"{name}, no result", [one[0] for one in lost], [one[1] for one in lost], cross, False))
    return parts


def bars_of(title: str, axis: Axis, values: dict[str, float]) -> Panel:
    """A bar a name, from 0."""
    look = {"color": colour(0)["color"], "linewidth": 14.0, "solid_capstyle": "butt"}
    parts = [Line(name, [0.0, one], [place] * 2, look, False) for place, (name, one) in enumerate(values.items())]
    up = Axis("", limits=(-0.6, len(values) - 0.4))
    return Panel(title, axis._replace(limits=(0.0, None)), up, parts, None, names=tuple(values))


def dashed() -> dict:
    """The look of what is compared with."""
    return {"color": STYLE["ink"], "linewidth": 2.0, "linestyle": "--"}


def shade(place: int = 0) -> dict:
    """The look of a band."""
    return {"color": BALL_COLOURS[place], "alpha": 0.22}


def draw(sheet: Sheet, path: Path) -> Path:
    """Writes the picture; raises BearingTwinError where that is impossible."""
    lines = len(sheet.rows)
    names = labels(sheet)
    columns = max(1, min(len(names), int(KEY_WIDTH / (7 + max(map(len, names), default=0)))))
    lines_of_key = -(-len(names) // columns) if sheet.key else 0
    tall = ROW * lines + 0.9 + 0.3 * lines_of_key
    figure = Figure(figsize=(WIDTH, tall), dpi=100, facecolor="white", layout="constrained")
    foot = (0.35 + 0.3 * lines_of_key) / tall
    figure.get_layout_engine().set(w_pad=0.1, h_pad=0.1, rect=(0.0, foot, 1.0, 1.0 - foot - 0.5 / tall))
    words = {"x": 0.02, "va": "center", "color": STYLE["ink"]}
    figure.text(y=1.0 - 0.28 / tall, s=sheet.title, fontsize=17, weight="bold", **words)
    footer = f"{sheet.footer}{'; ' if sheet.footer else ''}{made()}"
    figure.text(y=0.16 / tall, s=footer, fontsize=9, **words | {"color": STYLE["soft"]})
    boxes = figure.subfigures(lines, 1, squeeze=False)[:, 0]
    keys: dict[str, Any] = {}
    for box, row in zip(boxes, sheet.rows, strict=True):
        for column, panel in enumerate(row):
            axis = box.add_subplot(1, len(row), column + 1)
            _draw_panel(box, axis, panel)
            keys |= dict(zip(*reversed(axis.get_legend_handles_labels()), strict=True))
            entries = len(axis.get_legend_handles_labels()[1])
            if panel.legend and not sheet.key and entries:
                small = {"fontsize": 8, "ncols": 2} if entries > MANY else {"fontsize": 10.5}
                axis.legend(frameon=False, loc=panel.legend, **small)
    if sheet.key and keys:
        place = {"loc": "lower center", "bbox_to_anchor": (0.5, 0.22 / tall), "ncols": columns}
        figure.legend(keys.values(), keys, fontsize=12, frameon=False, **place)
    return save(figure, path)


def labels(sheet: Sheet) -> set[str]:
    """The entries of the legends of a sheet."""
    parts = (part for row in sheet.rows for panel in row for part in panel.parts)
    return {part.name for part in parts if getattr(part, "label", False)}


def write_curves(sheet: Sheet, path: Path) -> None:
    """Every curve as comma-separated values, SI; raises BearingTwinError where that is impossible."""
    rows = ((*words, f"{x:.10g}", f"{y:.10g}") for *words, x, y in _points(sheet))
    write_rows(path, ["panel", "curve", "x_is", "y_is", "x", "y"], rows)


def _points(sheet: Sheet) -> Iterator[tuple]:
    for panel in (panel for row in sheet.rows for panel in row):
        kinds = tuple(f"{axis.name} [{axis.unit}]" for axis in (panel.x, panel.y))
        for part in panel.parts:
            for name, x, y in _curves(part):
                for one, other in zip(x, y, strict=True):
                    yield panel.title, name, *kinds, float(one), float(other)


def _curves(part) -> Iterable[tuple]:
    if isinstance(part, Line):
        return ((part.name, part.x, part.y),)
    if isinstance(part, Bars):
        edges = np.asarray(part.edges)
        return ((part.name, 0.5 * (edges[1:] + edges[:-1]), part.heights),)
    if isinstance(part, Band):
        return ((f"{part.name}, low", part.x, part.low), (f"{part.name}, high", part.x, part.high))
    return ()


def _draw_panel(figure, axis, panel):
    heading(axis, panel.title[:1].upper() + panel.title[1:])
    across, unit_x = panel.x.shown or scaled(_extent(panel, 0), panel.x.unit)
    up, unit_y = panel.y.shown or scaled(_extent(panel, 1), panel.y.unit)
    if panel.y.unit == f"1/{panel.x.unit}":  # a density
        up, unit_y = 1.0 / across, inverse(unit_x)
    frame(axis)
    for part in panel.parts:
        if isinstance(part, Map):
            per = (1.0 / up, f"1/{unit_y}") if part.unit == f"1/{panel.y.unit}" else (1.0, part.unit)
            _draw_map(figure, axis, part, (across, panel.x.log), (up, panel.y.log), *per)
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
            if high < FEW_DECADES * low:
                along.set_major_formatter("{x:g}")
            along.set_minor_locator(NullLocator())
    if panel.names:
        axis.set_yticks(range(len(panel.names)), panel.names)
    if panel.to_scale:
        axis.set_aspect("equal", adjustable="datalim")


def _extent(panel, place):
    """The values that scale an axis: its limits where they are given, else the curves'."""
    limits = (panel.x, panel.y)[place].limits
    if limits is not None and limits[1] is not None:
        return [limits[1]]
    found = [(part.x, part.y)[place] for part in panel.parts if isinstance(part, Map)]
    found += [curve[1 + place] for part in panel.parts for curve in _curves(part)]
    return np.concatenate([np.asarray(one, float) for one in found]) if found else [1.0]


def _draw_part(axis, part, across, up):
    named = {"label": part.name} if part.label else {}
    if isinstance(part, Bars):
        axis.stairs(np.multiply(part.heights, up), np.multiply(part.edges, across), **named, **part.look)
        return
    x = np.multiply(part.x, across)
    if isinstance(part, Band):
        axis.fill_between(x, np.multiply(part.low, up), np.multiply(part.high, up), linewidth=0, **named, **part.look)
    else:
        axis.plot(x, np.multiply(part.y, up), **named, **part.look)


def _edges(centres, factor: float, log: bool) -> np.ndarray:
    """Edges of cells around centres, halfway between them on the axis."""
    places = np.log(centres) if log else np.asarray(centres, float)
    half = 0.5 * np.diff(places) if len(places) > 1 else np.array([0.5])
    edges = np.concatenate([[places[0] - half[0]], places[: len(half)] + half, [places[-1] + half[-1]]])
    return factor * (np.exp(edges) if log else edges)[: len(places) + 1]


def _draw_map(figure, axis, part, across, up, factor, unit):
    x, y, z = _edges(part.x, *across), _edges(part.y, *up), np.multiply(part.z, factor)
    low, high = (factor * limit for limit in part.limits)
    norm = PowerNorm(part.power, low, high) if part.power else LogNorm(low, high)
    z = z if part.power else np.clip(z, low, None)
    drawn = axis.pcolormesh(x, y, z, cmap=part.colours, norm=norm)
    axis.grid(False)
    beyond = np.nanmax(z, initial=low) > high
    bar = figure.colorbar(drawn, ax=axis, pad=0.02, extend="max" if beyond else "neither")
    bar.outline.set_visible(False)
    bar.set_label(labelled(part.name, unit), fontsize=11, color=STYLE["ink"])
    bar.ax.tick_params(length=0, labelsize=10, labelcolor=STYLE["ink"])
