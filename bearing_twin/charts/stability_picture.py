"""The pictures, tables and sentences of the maps of where methods fail."""

import csv
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from bearing_twin.charts.contest import Asked, Made
from bearing_twin.charts.left_alone import TOLD_FROM
from bearing_twin.charts.limits import FAILS, Limit
from bearing_twin.charts.map_picture import PREDICTED, Curves, add_bar, add_legend, draw_map
from bearing_twin.charts.model_limits import LIMITED
from bearing_twin.charts.model_maps import MODELS, chosen_by_tolerance, law_limits, sentences_of
from bearing_twin.charts.stability import ADAPTIVE, AXES, FIXED, MAPS, TOLERANCE, measure, one_cell
from bearing_twin.charts.table import DONE, MapRow, read_table, write_rows, write_table
from bearing_twin.pictures.style import STYLE, ball_line, frame, save_chart

WITHIN = 0.2  # of the limit found: how near a prediction has to be
KEPT = 1.0  # times the tolerance: errors up to here count as kept
COLUMNS, APART = 3, 10.0  # panels in a row; ratio of the made-up settings that laws stand at
LETTERS, MICRO = 15, 1e6  # size of the letters of limits; their unit is the microsecond
COLOUR_TEXT = "error of load or friction"
problems = MAPS
__all__ = ("make", "one_cell", "problems", "read")


def make(folder: Path, name: str, wanted: Asked) -> Made:
    """The maps that are wanted: pictures, the limits and the cells as tables, and what they say."""
    rows, limits = measure(wanted)
    pictures, tables = [], [folder / f"{name}_cells.csv"]
    if limits:
        tables.append(folder / f"{name}.csv")
        write_limits(limits, tables[-1])
    if any(one.map in AXES for one in limits):
        pictures.append(folder / f"{name}.png")
        of_steps(rows, limits, pictures[-1])
    if any(one.map in LIMITED for one in limits):
        pictures.append(folder / f"{name}_limits.png")
        of_limits(limits, pictures[-1])
    if TOLERANCE in wanted.problems:
        pictures.append(folder / f"{name}_{TOLERANCE}.png")
        of_tolerances(rows, pictures[-1])
    if any(row.problem in MODELS for row in rows):
        pictures.append(folder / f"{name}_models.png")
        of_models(rows, pictures[-1])
    write_table(rows, tables[0], MapRow)
    return Made(reading(rows, limits), list(map(str, pictures)), list(map(str, tables)), rows)


def of_steps(rows: list[MapRow], limits: list[Limit], path: Path) -> None:
    """Step against stiffness, regularisation and damping, a row a method."""
    figure = Figure(figsize=(17, 5.2 * len(FIXED) + 1.6), layout="constrained")
    shown = [name for name in AXES if any(row.problem == name for row in rows)]
    axes = figure.subplots(len(FIXED), len(shown), sharey=True, sharex="col", squeeze=False)
    for line, method in zip(axes, FIXED, strict=True):
        for axis, name in zip(line, shown, strict=True):
            facts = AXES[name]
            mine = [row for row in rows if (row.method, row.problem) == (method, name)]
            found = [one for one in limits if (one.method, one.map) == (method, name)]
            columns = np.transpose([(one.across, one.predicted, one.found, one.refused) for one in found])
            drawn = draw_map(axis, mine, Curves(*columns) if found else Curves())
            axis.set_title(f"{method}: {name}", fontsize=18, color=STYLE["ink"], loc="left")
            if method == FIXED[-1]:
                axis.set_xlabel(f"{facts.title} [{facts.unit}]", fontsize=17, color=STYLE["ink"])
        line[0].set_ylabel("step [s]", fontsize=17, color=STYLE["ink"])
    add_bar(figure, drawn, axes, COLOUR_TEXT)
    add_legend(figure, True)
    title = "Where fixed steps fail: one ball of a 6203 that rolls, or slides from rest (sliding)"
    save_chart(figure, title, path, 20)


def of_tolerances(rows: list[MapRow], path: Path) -> None:
    """Tolerance against regularisation, a map an adaptive method; a dot where the tolerance is not kept."""
    figure = Figure(figsize=(17, 6.6), layout="constrained")
    axes = figure.subplots(1, len(ADAPTIVE), sharey=True)
    for axis, method in zip(axes, ADAPTIVE, strict=True):
        mine = [row for row in rows if (row.method, row.problem) == (method, TOLERANCE)]
        drawn = draw_map(axis, mine, Curves(), lambda row: row.error > KEPT * row.setting)
        axis.set_title(method, fontsize=18, color=STYLE["ink"], loc="left")
        axis.set_xlabel("friction regularisation [m/s]", fontsize=16, color=STYLE["ink"])
    axes[0].set_ylabel("tolerance", fontsize=17, color=STYLE["ink"])
    add_bar(figure, drawn, axes, COLOUR_TEXT)
    add_legend(figure, False, "error above the tolerance")
    save_chart(figure, "What tolerances give: one ball of a 6203 from rest", path, 20)


def _panels(count: int, tall: float, margin: float):
    """A figure with rows of at most COLUMNS panels `tall` inches high and its axes, those beyond `count` hidden."""
    lines = -(-count // COLUMNS)
    figure = Figure(figsize=(17, tall * lines + margin), layout="constrained")
    axes = figure.subplots(lines, min(COLUMNS, count), squeeze=False)
    for axis in axes.flat[count:]:
        axis.set_visible(False)
    return figure, axes


def of_limits(limits: list[Limit], path: Path) -> None:
    """A panel for each of LIMITED that was measured: lines predicted, rings found, dashes where refusal begins."""
    names = [name for name in LIMITED if any(one.map == name for one in limits)]
    figure, axes = _panels(len(names), 5.2, 1.6)
    for axis, name in zip(axes.flat, names, strict=False):
        _draw_limits(axis, name, [one for one in limits if one.map == name])
    save_chart(figure, "The longest fixed step: line predicted, rings found, dashes refused from there on", path, 20)


def _draw_limits(axis, name: str, limits: list[Limit]) -> None:
    facts = LIMITED[name]
    frame(axis)
    for number, method in enumerate(facts.methods):
        look = ball_line(number)
        mine = [one for one in limits if one.method == method]
        across = [one.across for one in mine]
        axis.plot(across, [MICRO * one.predicted for one in mine], **look, linewidth=3.0, label=method)
        axis.plot(
            across, [MICRO * one.found for one in mine], "o", color=look["color"], markersize=9, mfc="white", mew=2.5
        )
        axis.plot(across, [MICRO * one.refused for one in mine], color=STYLE["ink"], linewidth=1.8, linestyle="--")
    axis.set(xscale="log", yscale="log")
    axis.yaxis.set_major_locator(LogLocator(subs=(1.0, 1.5, 2.0, 3.0, 5.0, 7.0)))
    axis.yaxis.set_major_formatter("{x:g}")
    axis.yaxis.set_minor_formatter(NullFormatter())
    axis.margins(y=0.25)
    axis.set_title(facts.bodies, fontsize=18, color=STYLE["ink"], loc="left")
    unit = "" if facts.unit == "1" else f" [{facts.unit}]"
    axis.set_xlabel(f"{facts.title}{unit}", fontsize=16, color=STYLE["ink"])
    axis.set_ylabel("step [µs]", fontsize=16, color=STYLE["ink"])
    axis.tick_params(labelsize=LETTERS, which="both")
    axis.legend(frameon=False, fontsize=LETTERS, loc="best")


def of_models(rows: list[MapRow], path: Path) -> None:
    """One panel a map and method, laws together; a dot where the error is above what is told below the picture.

    The orange line is what laws promise, what tolerances from 1e-2 to 1e-8 choose for a beam, and from where on
    a drift is told or an axis given.
    """
    panels = [
        (name, method)
        for name, facts in MODELS.items()
        if any(row.problem == name for row in rows)
        for method in (facts.methods if name != "law" else ("",))
    ]
    figure, axes = _panels(len(panels), 5.6, 1.2)
    for axis, (name, method) in zip(axes.flat, panels, strict=False):
        mine = [row for row in rows if row.problem == name and method in ("", row.method)]
        drawn = _draw_models(axis, mine, name, method)
    add_bar(figure, drawn, axes, "error of the load, of the norm, of the axis")
    add_legend(figure, False, f"error above {_levels(name for name, _ in panels)}", True)
    save_chart(figure, "Where models fail", path, 20)


def _levels(names) -> str:
    """The errors that dots stand for, that of most maps last."""
    dots = [(MODELS[name].dots, name) for name in dict.fromkeys(names)]
    most = max((level for level, _ in dots), key=[level for level, _ in dots].count)
    words = [f"{100.0 * level:g} % ({name})" for level, name in dots if level != most]
    return ", ".join([*words, f"{'else ' if words else ''}{100.0 * most:g} %"])


def _draw_models(axis, rows, name, method):
    facts, curves = MODELS[name], Curves()
    if name == "law":
        rows = [row.but(setting=APART ** facts.methods.index(row.method)) for row in rows]
    if name == "modes":
        curves = Curves(*chosen_by_tolerance())
    drawn = draw_map(axis, rows, curves, lambda row: row.error > facts.dots)
    if name == "law":
        axis.set_yticks([APART**place for place in range(len(facts.methods))], facts.methods)
        for law, promised, _ in law_limits(rows):
            place = APART ** facts.methods.index(law)
            axis.plot([promised] * 2, [place / APART**0.5, place * APART**0.5], color=PREDICTED, linewidth=3.0)
    if name in TOLD_FROM:
        axis.axvline(TOLD_FROM[name], color=PREDICTED, linewidth=3.0)
    axis.set_title(facts.title.format(method=method), fontsize=18, color=STYLE["ink"], loc="left")
    axis.set_xlabel(facts.across_title, fontsize=16, color=STYLE["ink"])
    axis.set_ylabel(facts.setting_title, fontsize=16, color=STYLE["ink"])
    return drawn


def write_limits(limits: list[Limit], path: Path) -> None:
    """Predicted, refused and found limits as comma-separated values."""
    header = ["method", "map", "across", "predicted_step", "refused_from_step", "found_step", "predicted_over_found"]
    write_rows(path, header, ((*one[:3], *(f"{x:.5g}" for x in (*one[3:], one.ratio))) for one in limits))


def read(folder: Path, name: str) -> list[str]:
    """What the maps say, from the tables that were written there before."""
    with (folder / f"{name}.csv").open(encoding="utf-8", newline="") as stream:
        limits = [Limit(line[0], line[1], *map(float, line[2:6])) for line in list(csv.reader(stream))[1:]]
    return reading(read_table(folder / f"{name}_cells.csv", MapRow), limits)


def _bodies(one: Limit) -> str:
    """What moves where this limit was looked for."""
    return LIMITED[one.map].bodies if one.map in LIMITED else "one ball"


def reading(rows: list[MapRow], limits: list[Limit]) -> list[str]:
    """What the maps say, from their numbers."""
    sentences = []
    for method, bodies in dict.fromkeys((one.method, _bodies(one)) for one in limits):
        mine = [one for one in limits if (one.method, _bodies(one)) == (method, bodies)]
        ratios = [one.ratio for one in mine]
        near = sum(abs(ratio - 1.0) <= WITHIN for ratio in ratios)
        unsafe = sum(one.refused > one.found * (1.0 + WITHIN) for one in mine)
        sentences.append(
            f"{method}, {bodies}: the predicted limit of the step is {min(ratios):.2f} to {max(ratios):.2f} times the "
            f"one found, within {100 * WITHIN:g} % at {near} of {len(mine)} places; those found reach from "
            f"{min(one.found for one in mine):.2g} to {max(one.found for one in mine):.2g} s; at {unsafe} places a "
            f"step is let pass that fails (error above {FAILS:g})."
        )
    for method in ADAPTIVE:
        mine = [row for row in rows if (row.method, row.problem) == (method, TOLERANCE)]
        done = [row for row in mine if row.status == DONE]
        if not done:
            continue
        kept = sum(row.error <= KEPT * row.setting for row in done)
        worst = max(done, key=lambda row: row.error / row.setting)
        sentences.append(
            f"{method}: {kept} of {len(mine)} cells keep their tolerance; the worst error is "
            f"{worst.error / worst.setting:.2g} times it, at {worst.setting:g} and {worst.across:g} m/s."
        )
    return sentences + sentences_of(rows)
