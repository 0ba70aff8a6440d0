"""Pictures of runs, of bearings' loads and of one Hertz contact: arrays in, PNG files out.

First the style of all charts, with colours that colour-blind eyes distinguish (Okabe and Ito), and files of pictures;
then panels of several pictures (loads around a bearing, errors of figures); last the picture of the calculator:
ellipse, pressure, stresses below, and errors of the laws.
"""

import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bearing_twin import __version__
from bearing_twin.base.paths import write_whole
from bearing_twin.base.units import prefixed
from bearing_twin.contact.calculator import COMPARED, Gap, axis_stresses, laws_at
from bearing_twin.contact.elasticity import curvature_ratio
from bearing_twin.contact.laws import LAWS

STYLE = {"ink": "#22303c", "soft": "#71808c", "panel": "#eef1f4", "ring": "#cfd6dc", "edge": "#8a97a3"}

BALL_COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#000000", "#B8A800")
DASHES = ("-", "--", ":", "-.")
FEW = 40  # outputs that are marked one by one
GREATEST_LINES = 12  # more lines than this cannot be distinguished: a map of ball against time takes their place

SIZE = (16.0, 10.0)  # inches at 100 dots each

RACEWAYS = ("inner", "outer")
RACEWAY_COLOURS = ("#0072B2", "#D55E00")
LOAD_MAP = "cividis"
KEY_SIZE = 10.5  # points, of the words of a legend


def ball_line(ball: int) -> dict:
    """Colour and dashes of the line of a ball, or of a row of any table: after eight the colours come again, dashed."""
    rounds, number = divmod(ball, len(BALL_COLOURS))
    return {"color": BALL_COLOURS[number], "linestyle": DASHES[rounds % len(DASHES)]}


def marker_of(outputs: int) -> str:
    """The marker of a line through so many outputs: few are marked one by one, as a line through one shows nothing."""
    return "o" if outputs <= FEW else ""


def scaled(values, unit) -> tuple[float, str]:
    """(factor, unit with prefix) that makes the values readable."""
    return prefixed(float(np.nanmax(np.abs(values))) if np.size(values) else 0.0, unit)


def heading(axis, text: str, across: str | None = None, up: str | None = None, pad: float = 6.0) -> None:
    """The words of a panel: its title above its left edge, and, where given, what its axes are."""
    axis.set_title(text, loc="left", fontsize=13.5, color=STYLE["ink"], pad=pad)
    if across is not None:
        axis.set_xlabel(across)
    if up is not None:
        axis.set_ylabel(up)


def key_above(axis) -> None:
    """The legend of a panel between its title and its curves, in as many rows as it needs; call it last."""
    handles, labels = axis.get_legend_handles_labels()
    if not labels:
        return
    box = axis.get_position()
    inches = box.width * axis.figure.get_figwidth()
    each = 0.55 + max(map(len, labels)) * KEY_SIZE * 0.0072  # inches that an entry takes: a sign and its words
    columns = max(1, min(len(labels), int(inches / each)))
    rows = -(-len(labels) // columns)
    columns = -(-len(labels) // rows)
    axis.legend(
        handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncol=columns, frameon=False, fontsize=KEY_SIZE,
        borderaxespad=0.25, borderpad=0.0, columnspacing=1.4, handlelength=1.8, labelspacing=0.3,
    )  # fmt: skip
    heading(axis, axis.get_title(loc="left"), pad=6 + rows * KEY_SIZE * 1.55)


def frame(axis) -> None:
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
    """Writes a figure as a PNG, whole or not at all; raises BearingTwinError where that is impossible."""
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", **options)
    return write_whole(path, drawn.getvalue())


NUMBERS = 0.25 * np.pi  # azimuth [rad] near which the numbers of the circles stand, where nothing pushes


def draw_loads_around(axis, azimuth, loads, push) -> None:
    """Bars of `loads` (N, 2) [N] on both raceways at `azimuth` (N,) [rad], an arrow along `push` (2,) [N] on the ring.

    `axis` is polar, 0 is +x. A push below a thousandth of the greatest load has no arrow.
    """
    from matplotlib.ticker import MaxNLocator

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


def readable_on(colour):
    """White or ink, whichever can be read on a colour."""
    from matplotlib.colors import to_rgb

    red, green, blue = to_rgb(colour)
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
        axis.plot([], [], mark, color=colour, markersize=7, label=source)
    axis.axvline(DOUBTFUL, color=STYLE["ink"], linewidth=1.0, linestyle=":")
    axis.set(xscale="log", xlim=(LEAST, MOST), ylim=(len(rows) - 0.5, -0.5), yticks=range(len(rows)))
    axis.set_yticklabels([f"{row.words}: {row.text}" for row in rows])
    longest = max(label.get_window_extent().width for label in axis.get_yticklabels()) / figure.dpi
    left = max(LEFT, (longest + GAP) / wide)
    axis.set_position((left, FOOT / tall, EDGE - left, ROW * len(rows) / tall))
    label = f"greatest error over greatest value (dotted: {100.0 * DOUBTFUL:g} %)"
    heading(axis, "Errors of the figures", label)
    axis.legend(frameon=False, fontsize=11, ncol=len(looks), loc="lower right", bbox_to_anchor=(1.0, 1.0))


def _drawn(error: float) -> float:
    return min(max(error, LEAST), MOST)


def finish(figure, title: str, footer: str, png_path, size: int = 20, errors: Sequence[FigureError] = ()) -> Path:
    """Writes title, footer and the `errors` of figures on a picture of a run, and saves it; raises as `save`."""
    figure.text(0.06, 0.955, title, fontsize=size, weight="bold", color=STYLE["ink"], va="center")
    if errors:
        draw_errors(figure, errors)
    figure.text(0.06, 0.22 / figure.get_size_inches()[1], footer, fontsize=10.5, color=STYLE["soft"], va="center")
    return save(figure, png_path, metadata={"Software": f"bearing_twin {__version__}"})


LEAST_SHOWN = 1e-12  # of the laws' errors


def plot_contact(result: dict, poisson_ratio: float, png_path) -> Path:
    """Write the picture of a `calculator.answer`; stresses are those in a body of that Poisson's ratio."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, dpi=100, facecolor="white")
    grid = figure.add_gridspec(2, 2, left=0.07, right=0.97, top=0.87, bottom=0.09, wspace=0.17, hspace=0.34)
    axes = [figure.add_subplot(grid[row, column]) for row in (0, 1) for column in (0, 1)]
    _draw_ellipse(figure, axes[0], result)
    _draw_pressure(axes[1], result)
    _draw_stress(axes[2], result, poisson_ratio)
    _draw_laws(axes[3], result)
    title = f"Hertz contact under {result['normal_load_n']:.4g} N, b/a = {result['axis_ratio']:.3g}"
    figure.text(0.07, 0.95, title, fontsize=20, weight="bold", color=STYLE["ink"], va="center")
    facts = (
        f"approach {1e6 * result['approach_m']:.4g} µm, stiffness {1e-6 * result['stiffness_n_per_m']:.4g} N/µm, "
        f"E* {1e-9 * result['effective_modulus_pa']:.4g} GPa"
    )
    figure.text(0.07, 0.915, facts, fontsize=12, color=STYLE["soft"], va="center")
    return save(figure, png_path)


def _draw_ellipse(figure, axis, result):
    frame(axis)
    a, b = 1e6 * result["semi_major_m"], 1e6 * result["semi_minor_m"]
    x, y = np.meshgrid(np.linspace(-a, a, 401), np.linspace(-b, b, 201))
    inside = 1.0 - (x / a) ** 2 - (y / b) ** 2
    pressure = 1e-9 * result["peak_pressure_pa"] * np.sqrt(np.maximum(inside, 0.0))
    image = axis.pcolormesh(x, y, np.where(inside >= 0.0, pressure, np.nan), cmap=LOAD_MAP, rasterized=True)
    figure.colorbar(image, ax=axis, pad=0.015, label="pressure [GPa]")
    turn = np.linspace(0.0, 2.0 * np.pi, 400)
    axis.plot(a * np.cos(turn), b * np.sin(turn), color=STYLE["ink"], linewidth=1.2)
    axis.set_aspect("equal")
    axis.set_xlim(-1.08 * a, 1.08 * a)
    axis.set_ylim(-max(1.15 * b, 0.45 * a), max(1.15 * b, 0.45 * a))
    axis.set_xlabel("along the major axis [µm]")
    axis.set_ylabel("[µm]")
    heading(axis, f"Contact ellipse, {2.0 * a:.4g} × {2.0 * b:.4g} µm, same scale both ways")


def _draw_pressure(axis, result):
    frame(axis)
    share = np.sin(np.linspace(-0.5, 0.5, 201) * np.pi)
    pressure = 1e-9 * result["peak_pressure_pa"] * np.sqrt(1.0 - share**2)
    for name, key, colour in (("major", "semi_major_m", 0), ("minor", "semi_minor_m", 5)):
        label = f"along the {name} axis, ±{1e6 * result[key]:.4g} µm"
        axis.plot(1e6 * result[key] * share, pressure, color=BALL_COLOURS[colour], linewidth=2.2, label=label)
    axis.set_ylim(0.0, 1.3 * pressure.max())
    axis.legend(frameon=False, loc="upper right")
    heading(axis, f"Pressure along the axes, peak {pressure.max():.4g} GPa", "from the centre [µm]", "pressure [GPa]")


def _draw_stress(axis, result, poisson_ratio):
    frame(axis)
    spot = result["semi_major_m"], result["semi_minor_m"], result["peak_pressure_pa"]
    depth = np.linspace(0.0, 3.0 * result["semi_minor_m"], 300)
    stresses = np.array(axis_stresses(*spot, poisson_ratio, depth))
    names = ("along the major axis", "along the minor axis", "normal to the surface")
    for stress, name, colour in zip(stresses, names, (0, 5, 2), strict=True):
        axis.plot(1e6 * depth, 1e-9 * stress, color=BALL_COLOURS[colour], linewidth=2.0, label=name)
    shear = 0.5 * (stresses.max(axis=0) - stresses.min(axis=0))
    axis.plot(1e6 * depth, 1e-9 * shear, color=STYLE["ink"], linewidth=2.2, linestyle="--", label="greatest shear")
    greatest = 1e6 * result["max_shear_depth_m"], 1e-9 * result["max_shear_pa"]
    axis.plot(*greatest, marker="o", color=STYLE["ink"])
    axis.set_xlabel("depth below the centre [µm]")
    axis.set_ylabel("stress [GPa]")
    axis.legend(frameon=False, loc="lower right")
    heading(axis, f"Stress below the centre: shear {greatest[1]:.3g} GPa at {greatest[0]:.3g} µm")


def _draw_laws(axis, result):
    frame(axis)
    ratios = np.geomspace(1e-3, 1.0, 241)
    # What the user measured has no error; hertz_exact is what the others are measured against.
    errors = {name: [] for name in COMPARED if not LAWS[name].measured and name != "hertz_exact"}
    frozen = result["constant_frozen_at_axis_ratio"]
    for ratio in ratios:
        gap = Gap(1.0, float(curvature_ratio(ratio)), 1.0)
        found = laws_at(gap, 1.0, 1e-6, frozen)
        for name in errors:
            errors[name].append(max(abs(found[name].error), LEAST_SHOWN))
    for number, (name, error) in enumerate(errors.items()):
        axis.loglog(ratios, error, **ball_line(number), linewidth=2.0, label=name)
    axis.axvline(result["axis_ratio"], color=STYLE["ink"], linewidth=1.2, linestyle=":")
    axis.annotate(
        "this contact", (result["axis_ratio"], 0.03), xycoords=("data", "axes fraction"), rotation=90, ha="right",
        color=STYLE["ink"], xytext=(-3, 0), textcoords="offset points",
    )  # fmt: skip
    axis.set_ylim(0.5 * LEAST_SHOWN, 2.0)
    axis.set_xlabel("b/a")
    axis.set_ylabel("|error| of the load")
    axis.legend(frameon=False, loc="center left")
    heading(axis, f"Error of each law against exact Hertz (constant: exact at b/a = {frozen:.3g})")
