"""What figures are worth, below the picture of a run: the errors of each, over the figure, by source."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from bearing_twin import __version__
from bearing_twin.pictures.style import BALL_COLOURS, STYLE, frame, heading, save

LEAST, MOST, DOUBTFUL = 1e-14, 10.0, 0.1  # errors over their figure: the edges, and where a figure is doubtful
ROW, FOOT, MARGIN = 0.26, 0.95, 1.45  # inches: of a row, below the panel, of all but the rows
LEFT, EDGE, GAP = 0.34, 0.96, 0.3  # where the panel begins and ends, of the width; inches beside the longest label
MARKS = "osD^v"


class JudgedFigure(NamedTuple):
    """One figure: its name, value with error for people, and `parts`, errors over the figure by source."""

    words: str
    text: str
    parts: Mapping[str, float]


def draw_worth(figure, rows: Sequence[JudgedFigure]) -> None:
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
    heading(axis, "What the figures are worth", words)
    axis.legend(frameon=False, fontsize=11, ncol=len(looks), loc="lower right", bbox_to_anchor=(1.0, 1.0))


def _drawn(error: float) -> float:
    return min(max(error, LEAST), MOST)


def finish(figure, title: str, footer: str, png_path, size: int = 20, worth: Sequence[JudgedFigure] = ()) -> Path:
    """Writes title, footer and what figures are `worth` on a picture of a run, and saves it; raises as `style.save`."""
    figure.text(0.06, 0.955, title, fontsize=size, weight="bold", color=STYLE["ink"], va="center")
    if worth:
        draw_worth(figure, worth)
    figure.text(0.06, 0.22 / figure.get_size_inches()[1], footer, fontsize=10.5, color=STYLE["soft"], va="center")
    return save(figure, png_path, metadata={"Software": f"bearing_twin {__version__}"})
