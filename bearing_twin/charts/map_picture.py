"""Maps of a contest: error as colour over two numbers, limits drawn over it, failures as crosses, refusals hatched."""

from typing import NamedTuple

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.ticker import LogLocator, NullLocator

from bearing_twin.charts.table import DONE, MapRow
from bearing_twin.pictures.style import STYLE

COLOURS, LEAST, GREATEST = "viridis_r", 1e-8, 1.0
FEW = 30.0  # of an axis that spans less, 2 and 5 are labelled too
PREDICTED, FOUND, BROKEN = "#D55E00", "#000000", "#c8ced4"


class Curves(NamedTuple):
    """What is drawn over a map: settings of the predicted limit and of the found one over `across`, each may be empty.

    Beyond `refused` the software refuses.
    """

    across: tuple = ()
    predicted: tuple = ()
    found: tuple = ()
    refused: tuple = ()


def edges_of(centres: np.ndarray) -> np.ndarray:
    """Edges of cells around centres that are evenly spaced on a logarithmic axis."""
    logs = np.log(centres)
    half = 0.5 * np.diff(logs) if len(logs) > 1 else np.array([0.5])
    inner = logs[:-1] + half if len(logs) > 1 else np.array([])
    return np.exp(np.concatenate([[logs[0] - half[0]], inner, [logs[-1] + half[-1]]]))


def draw_map(axis, rows: list[MapRow], curves: Curves, flags=None):
    """One map: `across` to the right, `setting` up; `flags(row)` puts a dot on a cell. Gives what is drawn."""
    across, settings = (np.array(sorted({getattr(row, key) for row in rows})) for key in ("across", "setting"))
    errors = np.full((len(settings), len(across)), np.nan)
    broken, flagged = [], []
    for row in rows:
        if row.status == DONE:
            errors[np.searchsorted(settings, row.setting), np.searchsorted(across, row.across)] = max(row.error, LEAST)
            if flags is not None and flags(row):
                flagged.append((row.across, row.setting))
        else:
            broken.append((row.across, row.setting))
    axis.set_facecolor(BROKEN)
    norm = LogNorm(LEAST, GREATEST, clip=True)
    drawn = axis.pcolormesh(edges_of(across), edges_of(settings), errors, cmap=COLOURS, norm=norm, rasterized=True)
    top = edges_of(settings)[-1]
    if len(curves.refused):
        axis.fill_between(
            curves.across, curves.refused, top, facecolor="none", edgecolor="white", hatch="//", linewidth=0.0
        )
    for places, marker, size in ((broken, "x", 30), (flagged, ".", 60)):
        if places:
            axis.scatter(*np.transpose(places), marker=marker, s=size, color="#7b1e1e" if marker == "x" else "white")
    if len(curves.predicted):
        axis.plot(curves.across, curves.predicted, color=PREDICTED, linewidth=3.0)
    if len(curves.found):
        axis.plot(curves.across, curves.found, "o", color=FOUND, markersize=7, mfc="white", mew=2)
    axis.set(xscale="log", yscale="log", xlim=edges_of(across)[[0, -1]], ylim=(edges_of(settings)[0], top))
    for along in (axis.xaxis, axis.yaxis):
        low, high = along.get_view_interval()
        along.set_major_locator(LogLocator(subs=(1.0,) if high > FEW * low else (1.0, 2.0, 5.0)))
        if high <= FEW * low:
            along.set_major_formatter("{x:g}")
        along.set_minor_locator(NullLocator())
    axis.tick_params(length=0, labelsize=15, labelcolor=STYLE["ink"])
    axis.tick_params(axis="x", labelsize=13)  # at both ends, greater ones reach into the panel beside
    for spine in axis.spines.values():
        spine.set_visible(False)
    return drawn


def add_bar(figure, drawn, axes, text: str) -> None:
    """The scale of colours beside the maps."""
    bar = figure.colorbar(drawn, ax=axes, pad=0.01, fraction=0.03, extend="both")
    bar.outline.set_visible(False)
    bar.set_label(text, fontsize=17, color=STYLE["ink"])
    bar.ax.tick_params(length=0, labelsize=14, labelcolor=STYLE["ink"])


def add_legend(figure, refuses: bool, dots: str = "", lines: bool = False) -> None:
    """What lines and marks mean, below the maps; `lines` that promises are drawn, where there are no limits."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    hollow = {"markersize": 9, "markerfacecolor": "white", "markeredgewidth": 2, "linestyle": "none"}
    handles = [
        Line2D([], [], color=PREDICTED, linewidth=3.0, label="limit predicted"),
        Line2D([], [], marker="o", color=FOUND, label="limit found", **hollow),
    ] * (not dots)
    if lines:
        handles.append(Line2D([], [], color=PREDICTED, linewidth=3.0, label="promised, chosen or told"))
    handles.append(Line2D([], [], marker="x", color="#7b1e1e", linestyle="none", markersize=8, label="broke down"))
    if refuses:
        handles.append(Patch(facecolor="#5f6f7a", edgecolor="white", hatch="//", label="refused"))
    if dots:
        look = {"markeredgecolor": "#22303c", "color": "white", "linestyle": "none", "markersize": 9}
        handles.append(Line2D([], [], marker="o", label=dots, **look))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), fontsize=16, frameon=False)
