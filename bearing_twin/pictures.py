"""Style of all pictures, PNG files, panels of lines, bands and maps as data, loads around a bearing, errors of figures.

Colours are those that colour-blind eyes distinguish (Okabe and Ito). Panels are in SI units; labels have prefixes.
"""

import io
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.colors import LogNorm, PowerNorm, to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator

from bearing_twin import __version__
from bearing_twin.base.paths import write_atomic
from bearing_twin.base.units import axis_label, inverse_unit, prefixed_unit

STYLE = {"ink": "#22303c", "soft": "#71808c", "panel": "#eef1f4", "ring": "#cfd6dc", "edge": "#8a97a3"}

BALL_COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#000000", "#B8A800")
DASHES = ("-", "--", ":", "-.")
FEW_OUTPUTS = 40  # outputs that are marked one by one
GREATEST_LINES = 12  # more lines than this cannot be distinguished: a map of ball against time takes their place

SIZE = (16.0, 10.0)  # inches at 100 dots each

RACEWAYS = ("inner", "outer")
RACEWAY_COLOURS = ("#0072B2", "#D55E00")
LOAD_MAP = "cividis"
LEGEND_SIZE, TITLE_SIZE = 10.5, 13.5  # points, of the words of a legend and of the title of a panel
VERSION = f"bearing_twin {__version__}"
LETTER = {"normal": 0.0072, "bold": 0.0085}  # inches: width of a letter for each point of its size, by weight


def ball_style(ball: int) -> dict:
    """Colour and dashes of the line of a ball, or of a row of any table: after eight the colours come again, dashed."""
    rounds, number = divmod(ball, len(BALL_COLOURS))
    return {"color": BALL_COLOURS[number], "linestyle": DASHES[rounds % len(DASHES)]}


def marker_of(outputs: int) -> str:
    """The marker of a line through so many outputs: few are marked one by one, as a line through one shows nothing."""
    return "o" if outputs <= FEW_OUTPUTS else ""


def readable_scale(values, unit) -> tuple[float, str]:
    """(factor, unit with prefix) that makes the values readable."""
    return prefixed_unit(float(np.nanmax(np.abs(values))) if np.size(values) else 0.0, unit)


def heading(axis, text: str, across: str | None = None, up: str | None = None, pad: float = 6.0) -> None:
    """The words of a panel: its title above its left edge, and, where given, what its axes are."""
    axis.set_title(text, loc="left", fontsize=TITLE_SIZE, color=STYLE["ink"], pad=pad)
    if across is not None:
        axis.set_xlabel(across)
    if up is not None:
        axis.set_ylabel(up)


def legend_above(axis) -> None:
    """The legend of a panel between its title and its curves, in as many rows as it needs; call it last."""
    handles, labels = axis.get_legend_handles_labels()
    if not labels:
        return
    box = axis.get_position()
    inches = box.width * axis.figure.get_figwidth()
    entry_width = 0.55 + max(map(len, labels)) * LEGEND_SIZE * 0.0072  # inches of an entry: a sign and its label
    columns = max(1, min(len(labels), int(inches / entry_width)))
    rows = -(-len(labels) // columns)
    columns = -(-len(labels) // rows)
    axis.legend(
        handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncol=columns, frameon=False, fontsize=LEGEND_SIZE,
        borderaxespad=0.25, borderpad=0.0, columnspacing=1.4, handlelength=1.8, labelspacing=0.3,
    )  # fmt: skip
    heading(axis, axis.get_title(loc="left"), pad=6 + rows * LEGEND_SIZE * 1.55)


def style_axes(axis) -> None:
    """A quiet panel: light ground, white grid, no border."""
    axis.set_facecolor(STYLE["panel"])
    axis.grid(True, color="white", linewidth=1.2)
    axis.set_axisbelow(True)
    for spine in axis.spines.values():
        spine.set_visible(False)
    axis.tick_params(which="both", length=0, labelsize=11, labelcolor=STYLE["ink"])
    axis.xaxis.label.set(size=12, color=STYLE["ink"])
    axis.yaxis.label.set(size=12, color=STYLE["ink"])


def fitted(text: str, width: float, size: float, weight: str = "normal") -> str:
    """A text cut to what stands in a line of `width` [inches] at a font `size` [points]."""
    most = int(width / (LETTER[weight] * size))
    return text if len(text) <= most else f"{text[: most - 3]}..."


def save(figure, path) -> Path:
    """Write a figure as a PNG, whole or not at all; raises BearingTwinError where that is impossible."""
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", metadata={"Software": VERSION})
    return write_atomic(path, drawn.getvalue())


WIDTH, ROW = 16.0, 4.4  # inches: of a picture, of a row of panels
PLAIN_RANGE = 1e-2, 1e4  # numbers beside a wider axis that are no powers
WIDE_RANGE = 100.0  # of an axis that spans less, 2 and 5 are labelled too
LEGEND_WIDTH = 170  # letters of a line of the legend below all panels
MOST_TICKS = 6  # intervals of a linear axis, so that numbers of six digits stand apart
MOST_INSIDE = 6  # entries of a legend that stands inside its panel
OUTSIDE = "beside"  # the place of a legend for which no corner of its panel is free


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


def figure_of(sheet: Sheet, made: str = VERSION) -> Figure:
    """The picture of a sheet, with its provenance `made`."""
    names = legend_entries(sheet) if sheet.shared_legend else ()
    widest = 7 + max(map(len, names), default=0)
    lines = max(1, -(-len(names) * widest // LEGEND_WIDTH))  # of the legend
    tall = ROW * len(sheet.rows) + 0.9 + 0.3 * (lines if names else 0)
    figure = Figure(figsize=(WIDTH, tall), dpi=100, facecolor="white", layout="constrained")
    figure.get_layout_engine().set(w_pad=0.1, h_pad=0.1)
    figure.suptitle(
        fitted(sheet.title, 0.96 * WIDTH, 17, "bold"), x=0.02, ha="left", fontsize=17, weight="bold", color=STYLE["ink"]
    )
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
    footer = fitted("; ".join(filter(None, (sheet.footer, made))), 0.98 * WIDTH, 9)
    key = figure.legend(
        keys.values(), keys, loc="outside lower left", ncols=-(-len(keys) // lines) or 1, title=footer,
        alignment="left", frameon=False, fontsize=12, title_fontsize=9,
    )  # fmt: skip
    key.get_title().set_color(STYLE["soft"])
    return figure


def _draw_panel(figure, axis, panel: Panel) -> None:
    heading(axis, panel.title if panel.title[1:2] == "/" else panel.title[:1].upper() + panel.title[1:])
    style_axes(axis)
    axis.set(xscale="log" if panel.x.log else "linear", yscale="log" if panel.y.log else "linear")
    for part in panel.parts:
        part.draw(axis, **({"label": part.name} if part.label else {}))
    for set_limits, limits in ((axis.set_xlim, panel.x.limits), (axis.set_ylim, panel.y.limits)):
        if limits:  # None would fix those that are
            set_limits(limits, auto=panel.equal_aspect)  # an equal aspect widens them
    if panel.equal_aspect:
        axis.set_aspect("equal", adjustable="datalim")
    x_factor, unit = _label(axis.xaxis, panel.x)
    density = (1.0 / x_factor, inverse_unit(unit)) if panel.y.unit == f"1/{panel.x.unit}" else None
    y_factor, unit = _label(axis.yaxis, panel.y, density)
    if panel.names:
        axis.set_yticks(range(len(panel.names)), panel.names)
    for part, drawn in zip((part for part in panel.parts if isinstance(part, Map)), axis.collections, strict=False):
        colour_factor, colour_unit = (
            (1.0 / y_factor, inverse_unit(unit))
            if part.unit == f"1/{panel.y.unit}"
            else readable_scale(part.limits, part.unit)
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


LABEL_ANGLE = 0.25 * np.pi  # azimuth [rad] near which the numbers of the circles stand, where nothing pushes


def draw_load_distribution(axis, azimuth, loads, push) -> None:
    """Bars of `loads` (N, 2) [N] on both raceways at `azimuth` (N,) [rad], an arrow along `push` (2,) [N] on the ring.

    `axis` is polar, 0 is +x. A push below a thousandth of the greatest load has no arrow.
    """
    width, greatest = 2.0 * np.pi / len(azimuth), float(loads.max()) or 1.0
    for race, (name, colour, shift) in enumerate(zip(RACEWAYS, RACEWAY_COLOURS, (-0.18, 0.18), strict=True)):
        axis.bar(azimuth + shift * width, loads[:, race], 0.34 * width, color=colour, label=f"{name} raceway")
    axis.set_ylim(0.0, 1.12 * greatest)
    box, numbers = {"facecolor": STYLE["panel"], "edgecolor": "none", "alpha": 0.85, "pad": 0.6}, LABEL_ANGLE
    if np.linalg.norm(push) > 1e-3 * greatest:
        direction = np.arctan2(push[1], push[0])
        arrow = {"arrowstyle": "-|>", "lw": 2.5, "color": STYLE["ink"], "mutation_scale": 19}
        axis.annotate("", (direction, 0.7 * greatest), (direction, 0.0), arrowprops=arrow, zorder=5)
        text_style = {"ha": "center", "va": "center", "fontsize": 11, "color": STYLE["ink"], "bbox": box, "zorder": 6}
        axis.text(direction, 0.78 * greatest, "load", **text_style)
        numbers = direction + np.pi
    axis.set_facecolor(STYLE["panel"])
    axis.grid(True, color="white", linewidth=1.2)
    axis.spines["polar"].set_color(STYLE["edge"])
    axis.tick_params(labelsize=10.5, labelcolor=STYLE["ink"])
    axis.yaxis.set_major_locator(MaxNLocator(4, prune="lower"))
    gaps = azimuth + 0.5 * width  # where no bar hides the numbers
    axis.set_rlabel_position(np.degrees(gaps[np.cos(gaps - numbers).argmax()]))
    for label in axis.get_yticklabels():
        label.set(ha="center", bbox=box)


def contrast_colour(colour):
    """White or ink, whichever can be read on a colour."""
    red, green, blue = to_rgb(colour)
    return "white" if 0.299 * red + 0.587 * green + 0.114 * blue < 0.6 else STYLE["ink"]


LEAST, MOST, DOUBTFUL = 1e-14, 10.0, 0.1  # errors over their figure: the edges, and where a figure is doubtful
MARKS = "osD^v"


def draw_errors(axis, rows: Sequence[tuple[str, Mapping[str, float]]]) -> None:
    """A bar for the error of each figure, and a mark for that by each source: words and errors over the figure."""
    style_axes(axis)
    for row, (_, parts) in enumerate(rows):
        extent = [LEAST, np.clip(math.fsum(parts.values()), LEAST, MOST)]
        axis.plot(extent, [row, row], color=STYLE["edge"], linewidth=5, solid_capstyle="butt")
    sources = dict.fromkeys(source for _, parts in rows for source in parts)
    for mark, colour, source in zip(MARKS, BALL_COLOURS, sources, strict=False):
        rows_of_source = [row for row, (_, parts) in enumerate(rows) if source in parts]
        errors = np.clip([rows[row][1][source] for row in rows_of_source], LEAST, MOST)
        style = {"color": colour, "markersize": 7, "markeredgecolor": "white", "zorder": 3, "clip_on": False}
        axis.plot(errors, rows_of_source, mark, label=source, **style)
    axis.axvline(DOUBTFUL, color=STYLE["ink"], linewidth=1.0, linestyle=":")
    axis.set(xscale="log", xlim=(LEAST, MOST), ylim=(len(rows) - 0.5, -0.5))
    axis.set_yticks(range(len(rows)), [words for words, _ in rows])
    heading(axis, "Errors of the figures", f"greatest error over greatest value (dotted: {100.0 * DOUBTFUL:g} %)")
    axis.legend(frameon=False, fontsize=11, ncol=len(sources), loc="lower right", bbox_to_anchor=(1.0, 1.0))


def finish_picture(figure, title: str, footer: str, png_path, size: int = 20) -> Path:
    """Writes title and footer on a picture of a run, and saves it; raises as `save`."""
    width, height = figure.get_size_inches()
    title_style = {"fontsize": size, "weight": "bold", "color": STYLE["ink"], "va": "center"}
    figure.text(0.06, 1.0 - 0.32 / height, fitted(title, 0.92 * width, size, "bold"), **title_style)
    footer = fitted(f"{footer}; {VERSION}", 0.92 * width, 10.5)
    figure.text(0.06, 0.22 / height, footer, fontsize=10.5, color=STYLE["soft"], va="center")
    return save(figure, png_path)
