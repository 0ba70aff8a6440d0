"""The picture of limits that have no map: steps predicted, found and refused, over what they depend on."""

from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from bearing_twin.charts.limits import Limit
from bearing_twin.charts.model_limits import LIMITED
from bearing_twin.pictures.style import STYLE, ball_line, frame, save_chart

COLUMNS, SIZE = 3, 15  # panels in a row; of the letters
MICRO = 1e6


def of_limits(limits: list[Limit], path: Path) -> None:
    """A panel for each of LIMITED that was measured: lines predicted, rings found, dashes where refusal begins."""
    names = [name for name in LIMITED if any(one.map == name for one in limits)]
    lines = -(-len(names) // COLUMNS)
    figure = Figure(figsize=(17, 5.2 * lines + 1.6), layout="constrained")
    axes = figure.subplots(lines, min(COLUMNS, len(names)), squeeze=False)
    for axis, name in zip(axes.flat, names, strict=False):
        _panel(axis, name, [one for one in limits if one.map == name])
    for axis in list(axes.flat)[len(names) :]:
        axis.set_visible(False)
    save_chart(figure, "The longest fixed step: line predicted, rings found, dashes refused from there on", path, 20)


def _panel(axis, name: str, limits: list[Limit]) -> None:
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
    axis.tick_params(labelsize=SIZE, which="both")
    axis.legend(frameon=False, fontsize=SIZE, loc="best")
