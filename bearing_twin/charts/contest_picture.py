"""The picture, table and sentences of a plain contest: a panel a problem, error across, seconds up, a line a method."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, NullLocator

from bearing_twin.charts.chart import Chart, stopped, unsure
from bearing_twin.charts.table import DONE, UNSURE, Row
from bearing_twin.pictures.style import STYLE, ball_line, frame, save

LEAST, GREATEST = 1e-10, 10.0  # of the axis of errors: smaller ones stand at its start, failures at its end
EDGE = 3.0  # where failures are drawn
RINGED = f"ringed: cost known to no better than {UNSURE:.0%}"
COLUMNS, FEW = 3, 30.0  # panels in a row; ratio of costs below which 2 and 5 are labelled, too


@dataclass(frozen=True, kw_only=True)
class Contest(Chart):
    """A plain contest, of rows without further columns.

    `error` and `cost` say what is on the axes, `wanted` is the error at which costs are compared, `more` reads the rows
    further; `own` are the methods that the reference is made by, where another one can confirm it. With a name for the
    `setting`, errors and costs are drawn over it, a panel each: of figures that one run has, none costs more than
    another.
    """

    title: str
    error: str
    cost: str
    wanted: float
    more: Callable[[list[Row]], list[str]] = lambda rows: []
    setting: str = ""
    own: tuple[str, ...] = ()

    def draw(self, rows: list[Row], path: Path) -> None:
        """Writes the picture."""
        (draw_over if self.setting else draw)(self, rows, path)

    def reading(self, rows: list[Row]) -> list[str]:
        """What the chart says, from its rows."""
        again = found_again(rows, self.own) if self.own else []
        read = enough_from if self.setting else best_of
        return [*read(self, rows), *again, *self.more(rows), *unsure(rows), *stopped(rows)]


def draw(chart, rows: list[Row], path: Path) -> None:
    """One panel a problem; a cross at the right edge for what failed, was refused or was stopped, at its cost."""
    names = [name for name in chart.problems if any(row.problem == name for row in rows)]
    methods = list(dict.fromkeys(row.method for row in rows))
    alone = len(names) % COLUMNS == 1 and len(names) % 2 == 0  # a panel in a line, which two in a line would not leave
    columns = min(2 if alone else COLUMNS, len(names))
    lines = math.ceil(len(names) / columns)
    figure = Figure(figsize=(16, 5.0 * lines + 2.2), layout="constrained")
    least = max(LEAST, min((0.1 * row.error for row in rows if row.status == DONE), default=LEAST))
    axes = figure.subplots(lines, columns, sharex=True, sharey=True, squeeze=False)
    for axis, name in zip(axes.flat, names, strict=False):
        for number, method in enumerate(methods):
            _line(axis, [row for row in rows if (row.problem, row.method) == (name, method)], method, number)
        frame(axis)
        axis.set(xscale="log", yscale="log", xlim=(0.5 * least, GREATEST))
        axis.xaxis.set_major_locator(LogLocator(subs=(1.0,), numticks=7))
        axis.xaxis.set_minor_locator(NullLocator())
        axis.axvline(chart.wanted, color=STYLE["soft"], linewidth=1.2, linestyle=":")
        axis.tick_params(labelsize=15)
        axis.set_title(chart.problems[name], loc="left", fontsize=17, color=STYLE["ink"])
    for axis in axes.flat[len(names) :]:
        axis.set_visible(False)
    low, high = axes.flat[0].get_ylim()
    if high < FEW * low:
        axes.flat[0].set_ylim(low / 3.0, 3.0 * high)
        axes.flat[0].yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.flat[0].yaxis.set_major_formatter("{x:g}")
    for axis in axes.flat:
        axis.yaxis.set_minor_formatter(NullFormatter())
    for axis in axes[:, 0]:
        axis.set_ylabel(chart.cost, fontsize=16)
    for axis in axes.flat[max(0, len(names) - columns) : len(names)]:
        axis.set_xlabel(chart.error, fontsize=15 if len(chart.error) * columns < 130 else 12)
        axis.tick_params(labelbottom=True)  # a panel below the others is not below all of them
    handles, labels = axes.flat[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 6), fontsize=15, frameon=False)
    figure.suptitle(
        f"{chart.title} (dotted: {chart.wanted:g}, x: no result; {RINGED})", fontsize=17, color=STYLE["ink"]
    )
    save(figure, path, dpi=100)


def draw_over(chart, rows: list[Row], path: Path) -> None:
    """Errors over the setting on the left, a line a method, and the median cost of a run over it on the right."""
    figure = Figure(figsize=(16, 7.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    for number, method in enumerate(dict.fromkeys(row.method for row in rows)):
        mine = sorted((row.setting, max(row.error, LEAST)) for row in rows if row.method == method)
        good, look = [one for one in mine if one[1] < math.inf] or [(math.nan, math.nan)], ball_line(number)
        left.plot(*np.transpose(good), "o", **look, label=method, markersize=8, linewidth=2)
        lost = [setting for setting, error in mine if error == math.inf]
        left.plot(lost, [1.0] * len(lost), "x", color=look["color"], markeredgewidth=3, markersize=10)
    left.axhline(chart.wanted, color=STYLE["soft"], linewidth=1.2, linestyle=":")
    left.legend(frameon=False, fontsize=15, loc="center left")
    settings = sorted({row.setting for row in rows})
    costs = [(one, np.median([row.seconds for row in rows if row.setting == one])) for one in settings]
    right.plot(*np.transpose(costs), "o", color=STYLE["ink"], markersize=8, linewidth=2, linestyle="-")
    for axis, text in ((left, chart.error), (right, chart.cost)):
        frame(axis)
        axis.set(xscale="log", yscale="log")
        axis.set_xlabel(chart.setting, fontsize=16)
        axis.set_ylabel(text, fontsize=16)
        axis.tick_params(labelsize=15, which="both")
    low, high = right.get_ylim()
    right.set_ylim(low / 1.5, 1.5 * high)
    right.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    right.yaxis.set_major_formatter("{x:g}")
    right.yaxis.set_minor_formatter(NullFormatter())
    figure.suptitle(f"{chart.title} (dotted: {chart.wanted:g})", fontsize=19, color=STYLE["ink"])
    save(figure, path, dpi=100)


def ring(axis, rows: Iterable[Row], place: Callable[[Row], tuple[float, float]], colour: str) -> None:
    """A ring around each result whose cost is unsure; `place` is where it stands."""
    wide = [place(row) for row in rows if row.unsure and row.status == DONE]
    if wide:
        axis.plot(*np.transpose(wide), "o", markerfacecolor="none", color=colour, markersize=14, markeredgewidth=1.5)


def without_result(axis, rows: Iterable[Row]) -> None:
    """Crosses at an error of 1, at what the rows cost that have no result."""
    lost = [row.seconds for row in rows if row.status != DONE]
    look = {"color": STYLE["ink"], "markersize": 10, "label": "no result" if lost else None}
    axis.plot(lost, [1.0] * len(lost), "x", **look)


def enough_from(chart, rows: list[Row]) -> list[str]:
    """A sentence a method: from which setting on its errors stay within the one wanted."""
    sentences, words = [], chart.setting.split(" [")[0]
    for method in dict.fromkeys(row.method for row in rows):
        mine = {row.setting: row.error for row in rows if row.method == method}
        bad = [one for one, error in mine.items() if not error <= chart.wanted]
        good = [one for one in mine if one > max(bad, default=0.0)]
        worst = f"{max(mine.values()):.2g} at worst, {mine[max(mine)]:.2g} at {max(mine):g}"
        held = f"from {min(good):g} {words} on" if good else "at none tried"
        sentences.append(f"{method}: error within {chart.wanted:g} {held}; {worst}.")
    return sentences


def _place(row: Row) -> tuple[float, float]:
    return max(row.error, LEAST), row.seconds


def _line(axis, rows, method, number) -> None:
    """The runs of one method on one problem."""
    look = ball_line(number)
    rows = sorted(rows, key=lambda row: row.setting)
    good = [_place(row) for row in rows if row.status == DONE]
    axis.plot(*np.transpose(good or [(np.nan, np.nan)]), "o", **look, label=method, markersize=7, linewidth=2)
    ring(axis, rows, _place, look["color"])
    lost = [row for row in rows if row.status != DONE]
    heights = [row.seconds if math.isfinite(row.seconds) else math.nan for row in lost]
    known = [one for one in heights if not math.isnan(one)]
    axis.plot([EDGE] * len(known), known, "x", color=look["color"], markeredgewidth=3, markersize=10)
    unknown = len(heights) - len(known)
    if unknown:
        place = axis.get_xaxis_transform()
        height = [0.04 + 0.06 * number] * unknown
        axis.plot([EDGE] * unknown, height, "x", color=look["color"], transform=place, mew=3, ms=10)


def cheapest(rows: list[Row], problem: str, method: str, wanted: float) -> Row | None:
    """The cheapest run of a method within the error wanted; None if there is none."""
    good = [row for row in rows if (row.problem, row.method) == (problem, method) and row.error <= wanted]
    return min(good, key=lambda row: row.seconds, default=None)


def found_again(rows: Iterable[Row], own: Iterable[str]) -> list[str]:
    """A sentence on how near methods other than the reference's `own` come to it; none where there are no others.

    A reference that two methods find is off by no more than what they differ by.
    """
    own, nearest = set(own), {}
    for row in rows:
        if row.method not in own and row.error < nearest.get(row.problem, (math.inf, ""))[0]:
            nearest[row.problem] = row.error, row.method
    told = ", ".join(f"{problem} to {error:.1g} ({method})" for problem, (error, method) in nearest.items())
    return [f"References that other methods find: {told}."] if told else []


def best_of(chart, rows: list[Row]) -> list[str]:
    """A sentence a problem: what each method takes to hold the error wanted, the cheapest first."""
    sentences = []
    for name, title in chart.problems.items():
        mine = list(dict.fromkeys(row.method for row in rows if row.problem == name))
        found = {method: cheapest(rows, name, method, chart.wanted) for method in mine}
        good = sorted((method for method in mine if found[method]), key=lambda method: found[method].seconds)
        if not mine:
            continue
        words = ", ".join(f"{method} {found[method].seconds:.2g}" for method in good) or "none"
        never = [method for method in mine if not found[method]]
        text = f"{title}, {chart.cost} at which {chart.wanted:g} is held: {words}"
        sentences.append(text + (f"; at no setting tried: {', '.join(never)}." if never else "."))
    return sentences
