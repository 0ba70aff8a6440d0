"""Style of all pictures and charts, PNG files, and panels of several: loads around a bearing, errors of figures.

Colours are those that colour-blind eyes distinguish (Okabe and Ito).
"""

import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from bearing_twin import __version__
from bearing_twin.base.paths import write_atomic
from bearing_twin.base.units import prefixed_unit

STYLE = {"ink": "#22303c", "soft": "#71808c", "panel": "#eef1f4", "ring": "#cfd6dc", "edge": "#8a97a3"}

BALL_COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#000000", "#B8A800")
DASHES = ("-", "--", ":", "-.")
FEW_OUTPUTS = 40  # outputs that are marked one by one
GREATEST_LINES = 12  # more lines than this cannot be distinguished: a map of ball against time takes their place

SIZE = (16.0, 10.0)  # inches at 100 dots each

RACEWAYS = ("inner", "outer")
RACEWAY_COLOURS = ("#0072B2", "#D55E00")
LOAD_MAP = "cividis"
LEGEND_SIZE = 10.5  # points, of the words of a legend


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
    axis.set_title(text, loc="left", fontsize=13.5, color=STYLE["ink"], pad=pad)
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
    axis.tick_params(length=0, labelsize=11, labelcolor=STYLE["ink"])
    axis.xaxis.label.set(size=12, color=STYLE["ink"])
    axis.yaxis.label.set(size=12, color=STYLE["ink"])


def save(figure, path, **options) -> Path:
    """Write a figure as a PNG, whole or not at all; raises BearingTwinError where that is impossible."""
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", **options)
    return write_atomic(path, drawn.getvalue())


LABEL_ANGLE = 0.25 * np.pi  # azimuth [rad] near which the numbers of the circles stand, where nothing pushes


def draw_load_distribution(axis, azimuth, loads, push) -> None:
    """Bars of `loads` (N, 2) [N] on both raceways at `azimuth` (N,) [rad], an arrow along `push` (2,) [N] on the ring.

    `axis` is polar, 0 is +x. A push below a thousandth of the greatest load has no arrow.
    """
    from matplotlib.ticker import MaxNLocator

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
    from matplotlib.colors import to_rgb

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
    figure.text(0.06, 0.955, title, fontsize=size, weight="bold", color=STYLE["ink"], va="center")
    figure.text(0.06, 0.22 / figure.get_size_inches()[1], footer, fontsize=10.5, color=STYLE["soft"], va="center")
    return save(figure, png_path, metadata={"Software": f"bearing_twin {__version__}"})
