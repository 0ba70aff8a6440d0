"""The picture of the maps of models."""

from pathlib import Path

from matplotlib.figure import Figure

from bearing_twin.charts.left_alone import TOLD_FROM
from bearing_twin.charts.map_picture import PREDICTED, Curves, add_bar, add_legend, draw_map
from bearing_twin.charts.model_maps import MODELS, chosen_by_tolerance, law_limits
from bearing_twin.charts.table import MapRow
from bearing_twin.pictures.style import STYLE, save_chart

COLUMNS, APART = 3, 10.0  # panels in a row; ratio of the made-up settings that laws stand at


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
    lines = -(-len(panels) // COLUMNS)
    figure = Figure(figsize=(17, 5.6 * lines + 1.2), layout="constrained")
    axes = figure.subplots(lines, min(COLUMNS, len(panels)), squeeze=False)
    for axis, (name, method) in zip(axes.flat, panels, strict=False):
        drawn = _panel(axis, [row for row in rows if row.problem == name and method in ("", row.method)], name, method)
    for axis in list(axes.flat)[len(panels) :]:
        axis.set_visible(False)
    add_bar(figure, drawn, axes, "error of the load, of the norm, of the axis")
    add_legend(figure, False, f"error above {_levels(name for name, _ in panels)}", True)
    save_chart(figure, "Where models fail", path, 20)


def _levels(names) -> str:
    """The errors that dots stand for, that of most maps last."""
    dots = [(MODELS[name].dots, name) for name in dict.fromkeys(names)]
    most = max((level for level, _ in dots), key=[level for level, _ in dots].count)
    words = [f"{100.0 * level:g} % ({name})" for level, name in dots if level != most]
    return ", ".join([*words, f"{'else ' if words else ''}{100.0 * most:g} %"])


def _panel(axis, rows, name, method):
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
