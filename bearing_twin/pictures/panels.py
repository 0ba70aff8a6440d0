"""Panels of several pictures: loads around a bearing, peaks of contacts, marks, and the errors of figures."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import matplotlib
import numpy as np
from matplotlib.ticker import MaxNLocator

from bearing_twin import __version__
from bearing_twin.pictures.style import BALL_COLOURS, RACEWAY_COLOURS, RACEWAYS, STYLE, frame, heading, save

NUMBERS = 0.25 * np.pi  # azimuth [rad] near which the numbers of the circles stand, where nothing pushes


def draw_loads_around(axis, azimuth, loads, push) -> None:
    """Bars of `loads` (N, 2) [N] on both raceways at `azimuth` (N,) [rad], an arrow along `push` (2,) [N] on the ring.

    `axis` is polar, 0 is +x. A push below a thousandth of the greatest load has no arrow.
    """
    width, greatest = 2.0 * np.pi / len(azimuth), float(loads.max()) or 1.0
    for race, (name, colour, shift) in enumerate(zip(RACEWAYS, RACEWAY_COLOURS, (-0.18, 0.18), strict=True)):
        axis.bar(azimuth + shift * width, loads[:, race], 0.34 * width, color=colour, label=f"{name} raceway")
    axis.set_ylim(0.0, 1.12 * greatest)
    aside, numbers = {"facecolor": STYLE["panel"], "edgecolor": "none", "alpha": 0.85, "pad": 0.6}, NUMBERS
    if np.linalg.norm(push) > 1e-3 * greatest:
        direction = np.arctan2(push[1], push[0])
        look = {"arrowstyle": "-|>", "lw": 2.5, "color": STYLE["ink"], "mutation_scale": 19}
        axis.annotate("", (direction, 0.7 * greatest), (direction, 0.0), arrowprops=look, zorder=5)
        words = {"ha": "center", "va": "center", "fontsize": 11, "color": STYLE["ink"], "bbox": aside, "zorder": 6}
        axis.text(direction, 0.78 * greatest, "load", **words)
        numbers = direction + np.pi
    axis.set_facecolor(STYLE["panel"])
    axis.grid(True, color="white", linewidth=1.2)
    axis.spines["polar"].set_color(STYLE["edge"])
    axis.tick_params(labelsize=10.5, labelcolor=STYLE["ink"])
    axis.yaxis.set_major_locator(MaxNLocator(4, prune="lower"))
    gaps = azimuth + 0.5 * width  # where no bar hides the numbers
    axis.set_rlabel_position(np.degrees(gaps[np.cos(gaps - numbers).argmax()]))
    for label in axis.get_yticklabels():
        label.set(ha="center", bbox=aside)


POINT = 0.01  # of what is shown of time: a shorter contact is a point
LABEL = "peak of a contact"


def draw_peaks(axis, span: float, begin: np.ndarray, end: np.ndarray, peak: np.ndarray) -> None:
    """A point for each contact, or a line as long as it: when in a contact its peak is, no record says.

    `span` is what is shown of time; it, `begin`, `end` and `peak` are in the units of the axis.
    """
    short = end - begin < POINT * span
    look = {"color": BALL_COLOURS[5]}
    if short.any():
        axis.plot(0.5 * (begin + end)[short], peak[short], "o", markersize=4, label=LABEL, **look)
    if not short.all():
        label = None if short.any() else LABEL  # one entry in the legend
        axis.hlines(peak[~short], begin[~short], end[~short], label=label, **look)


def readable_on(colour):
    """White or ink, whichever can be read on a colour."""
    red, green, blue = matplotlib.colors.to_rgb(colour)
    return "white" if 0.299 * red + 0.587 * green + 0.114 * blue < 0.6 else STYLE["ink"]


LEAST, MOST, DOUBTFUL = 1e-14, 10.0, 0.1  # errors over their figure: the edges, and where a figure is doubtful
ROW, FOOT, MARGIN = 0.26, 0.95, 1.45  # inches: of a row, below the panel, of all but the rows
LEFT, EDGE, GAP = 0.34, 0.96, 0.3  # where the panel begins and ends, of the width; inches beside the longest label
MARKS = "osD^v"


class FigureError(NamedTuple):
    """One figure: its name, value with error for people, and `parts`, errors over the figure by source."""

    words: str
    text: str
    parts: Mapping[str, float]


def draw_errors(figure, rows: Sequence[FigureError]) -> None:
    """Makes the figure taller and draws, at its foot, a bar up to the error of each row and a mark for each source."""
    wide, old = figure.get_size_inches()
    tall = old + ROW * len(rows) + MARGIN
    lifted = (tall - old) / tall
    places = [axis.get_position() for axis in figure.axes]  # all before any is set: a twin moves with its other axis
    for axis, place in zip(figure.axes, places, strict=True):
        axis.set_position((place.x0, lifted + place.y0 * old / tall, place.width, place.height * old / tall))
    for text in figure.texts:
        x, y = text.get_position()
        text.set_position((x, lifted + y * old / tall))
    figure.set_size_inches(wide, tall)
    axis = figure.add_axes((LEFT, FOOT / tall, EDGE - LEFT, ROW * len(rows) / tall))
    frame(axis)
    sources = list(dict.fromkeys(source for row in rows for source in row.parts))
    looks = {source: (MARKS[k % len(MARKS)], BALL_COLOURS[k % len(BALL_COLOURS)]) for k, source in enumerate(sources)}
    for place, row in enumerate(rows):
        total = math.fsum(row.parts.values())
        axis.plot([LEAST, _drawn(total)], [place, place], color=STYLE["edge"], linewidth=5, solid_capstyle="butt")
        for source, error in row.parts.items():
            mark, colour = looks[source]
            axis.plot(
                _drawn(error), place, mark, color=colour, markersize=7, markeredgecolor="white", zorder=3, clip_on=False
            )
    for source, (mark, colour) in looks.items():
        axis.plot([], [], mark, color=colour, markersize=7, label=source.replace("_", " "))
    axis.axvline(DOUBTFUL, color=STYLE["ink"], linewidth=1.0, linestyle=":")
    axis.set(xscale="log", xlim=(LEAST, MOST), ylim=(len(rows) - 0.5, -0.5), yticks=range(len(rows)))
    axis.set_yticklabels([f"{row.words}: {row.text}" for row in rows])
    longest = max(label.get_window_extent().width for label in axis.get_yticklabels()) / figure.dpi
    left = max(LEFT, (longest + GAP) / wide)
    axis.set_position((left, FOOT / tall, EDGE - left, ROW * len(rows) / tall))
    words = "error over the figure, of several values greatest over greatest (dotted: beyond it a figure is doubtful)"
    heading(axis, "Errors of the figures", words)
    axis.legend(frameon=False, fontsize=11, ncol=len(looks), loc="lower right", bbox_to_anchor=(1.0, 1.0))


def _drawn(error: float) -> float:
    return min(max(error, LEAST), MOST)


def finish(figure, title: str, footer: str, png_path, size: int = 20, errors: Sequence[FigureError] = ()) -> Path:
    """Writes title, footer and the `errors` of figures on a picture of a run, and saves it; raises as `style.save`."""
    figure.text(0.06, 0.955, title, fontsize=size, weight="bold", color=STYLE["ink"], va="center")
    if errors:
        draw_errors(figure, errors)
    figure.text(0.06, 0.22 / figure.get_size_inches()[1], footer, fontsize=10.5, color=STYLE["soft"], va="center")
    return save(figure, png_path, metadata={"Software": f"bearing_twin {__version__}"})
