"""The picture of a study: the charts of its page, drawn by matplotlib."""

from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.base.units import with_unit
from bearing_twin.pictures import BALL_COLOURS, STYLE, finish, frame, heading, key_above
from bearing_twin.uq.result import StudyResult, SweepInWords, sweep_of
from bearing_twin.view.study_page import study_charts, study_shares, unit_of

MOST_QUANTITIES = 4
TICK = 0.7  # inches of a panel for each number below it, so that those of five digits stand apart
ROOM = 0.25  # of the intervals that are known, for those that are open
WIDE = 20.0  # the greatest of what is drawn along a wide axis over the least, from which on it is logarithmic
OPEN_END = "open to the edge: too few samples"
BAR, FILL = "#b9c6d2", {"alpha": 0.2, "linewidth": 0}


def plot_study(result: StudyResult, png_path) -> Path:
    """Writes the picture of a result; returns the path. Raises BearingTwinError where that is impossible."""
    study, names = result.study, result.study.quantities[:MOST_QUANTITIES]
    drawn = [partial(_draw_chart, one=one) for one in study_charts(result, names, study.histories[:1])]
    titles = [one.keywords["one"]["title"].partition(":")[0] for one in drawn]
    for place, name in enumerate(names):
        if (title := name.replace("_", " ").capitalize()) not in titles:
            drawn.insert(place, partial(_draw_words, title=title, words=_without_chart(result, name)))
    drawn += [partial(_draw_shares, one=one) for one in study_shares(names, result.summary)]
    columns = 2 if len(drawn) <= 4 else 3
    rows = -(-len(drawn) // columns)
    head = 1.65 if columns == 2 else 2.4  # in narrow panels keys stand in more lines
    tall = head - 0.05 + 4.9 * rows
    figure = Figure(figsize=(16.0, tall), dpi=100, facecolor="white")
    space = {"top": 1.0 - head / tall, "bottom": 0.95 / tall, "hspace": 0.5 if columns == 2 else 0.62}
    grid = figure.add_gridspec(rows, columns, left=0.06, right=0.98, wspace=0.22, **space)
    for place, draw in enumerate(drawn):
        axis = figure.add_subplot(grid[place // columns, place % columns])
        frame(axis)
        draw(axis)
        key_above(axis)
    words = study.description
    title = words[:1].upper() + words[1:] or study.name
    return finish(figure, title, _footer(result), png_path, size=16)


def _draw_chart(axis, one) -> None:
    """A chart of the page; lines that bound a band are drawn as the band alone."""
    x, ys, banded = np.array(one["x"]), [np.array(y) for y in one["ys"]], set()
    for high, low, number, label in one["bands"]:
        banded |= {high, low}
        look = {"color": BALL_COLOURS[number], "label": label}
        if np.isnan([ys[low], ys[high]]).any() and not one.get("wide"):
            look["label"] = f"{label}, {OPEN_END}"
        low, high = _to_the_edges(axis, ys, low, high) if not one.get("wide") else (ys[low], ys[high])
        if len(x) > 1:
            axis.fill_between(x, low, high, **look, **FILL)
        else:  # of one instant a band has no width
            middle = ys[-1] if len(ys) < 3 else ys[2]
            look["ecolor"] = look.pop("color")
            ends = [(middle - low).tolist(), (high - middle).tolist()]
            axis.errorbar(x, middle, yerr=ends, fmt="none", elinewidth=1.6, capsize=5, **look)
    for place, (line, y) in enumerate(zip(one["lines"], ys, strict=True)):
        colour, width = BALL_COLOURS[line["colour"]], line.get("width", 1.8)
        if line.get("filled"):
            axis.fill_between(x, 0.0, y, color=BAR, linewidth=0, step="mid", label=line["label"])
        elif place not in banded:
            look = {"marker": "o", "markersize": 3.5} if line.get("points") else {}
            dashes = "--" if line.get("dashed") else "-"
            axis.plot(x, y, color=colour, linewidth=width, linestyle=dashes, label=line["label"], **look)
    heading(axis, one["title"].partition(":")[0], one["xLabel"], one["yLabel"])
    if one.get("wide"):
        _spread(axis, "x", x)
        _spread(axis, "y", np.array(ys))
    elif one["spans"]:
        axis.set_xlim(x[0], x[-1])
    _draw_spans(axis, one["spans"], "the other panels" if one.get("wide") else "5, 50, 95 % with intervals")
    if one.get("error"):
        middle, error = one["error"]
        axis.errorbar(
            middle, 0.06, xerr=error, transform=axis.get_xaxis_transform(), fmt="none", ecolor=STYLE["ink"],
            elinewidth=2.2, capsize=5, capthick=2.2, zorder=5, label="error of the model",
        )  # fmt: skip
    if one["from_zero"]:
        axis.set_ylim(bottom=0.0)
    axis.ticklabel_format(axis="y", useOffset=False) if axis.get_yscale() == "linear" else None
    if axis.get_xscale() == "linear":
        whole = {"integer": True, "min_n_ticks": 1} if one["xLabel"] == "samples" else {}
        axis.locator_params(axis="x", nbins=int(axis.get_position().width * axis.figure.get_figwidth() / TICK), **whole)


def _draw_spans(axis, spans, label: str) -> None:
    """Values along x with their intervals; one with an open end is hatched and reaches the edge of the panel."""
    edges = dict(zip(("low", "high"), axis.get_xlim(), strict=True))
    for place, one in enumerate(spans):
        colour, named = BALL_COLOURS[one["colour"]], {} if place else {"label": label}
        hatch = {"facecolor": "none", "edgecolor": colour, "alpha": 0.45, "linewidth": 0, "hatch": "///"}
        axis.axvline(one["value"], color=colour, linewidth=1.3, linestyle="-" if one["low"] else ":", **named)
        ends = [edges[key] if key in one["open"] else one[key] for key in edges]
        if None not in ends:
            axis.axvspan(*ends, color=colour, **FILL)
            if one["open"]:
                axis.axvspan(*ends, **hatch)
    if any(one["open"] for one in spans):
        axis.fill_between([], [], **hatch, label=OPEN_END)


def _to_the_edges(axis, ys, low, high):
    """The ends (n,) of intervals; open ones (NaN) lie beyond the edge of the panel, which is set here."""
    known, low, high = np.concatenate(ys), ys[low], ys[high]
    if not np.isnan([low, high]).any():
        return low, high
    least, greatest = np.nanmin(known), np.nanmax(known)
    room = ROOM * (greatest - least or abs(greatest) or 1.0)
    axis.set_ylim(least - room, greatest + room)
    return np.where(np.isnan(low), least - 2.0 * room, low), np.where(np.isnan(high), greatest + 2.0 * room, high)


def _spread(axis, along, numbers) -> None:
    """A logarithmic axis where what is drawn along it spans more than a factor WIDE, with its numbers written out."""
    known = numbers[np.isfinite(numbers)]
    if not len(known) or known.min() <= 0.0 or known.max() < WIDE * known.min():
        return
    axis.set(**{f"{along}scale": "log"})
    one = getattr(axis, f"{along}axis")
    one.set_major_formatter("{x:g}")
    one.set_tick_params(which="minor", length=0, labelbottom=False, labelleft=False)


def _draw_words(axis, title, words) -> None:
    heading(axis, title)
    axis.text(0.5, 0.5, words, ha="center", va="center", transform=axis.transAxes)


def _without_chart(result, name) -> str:
    sample = result.sample(name)
    kept, (unit, factor) = sample[np.isfinite(sample)], unit_of(result.summary["quantities"][name])
    return f"{factor * kept[0]:.6g}{with_unit(unit)} in every realisation" if len(kept) else "no realisation succeeded"


def _draw_shares(axis, one) -> None:
    """Sobol's indices as bars with their intervals, the greatest on top."""
    rows = sorted(one["rows"], key=lambda row: row["shares"][-1]["value"])
    for place, order in enumerate(one["orders"]):
        shares = [row["shares"][place] for row in rows]
        values = np.array([share["value"] for share in shares])
        at = np.arange(len(rows)) + (0.14 if place == 0 else -0.16)
        axis.barh(at, 100.0 * values, 0.28, color=BALL_COLOURS[place], label=order)
        ends = ([share["value"] if share[end] is None else share[end] for share in shares] for end in ("low", "high"))
        lengths = [100.0 * np.abs(np.array(end) - values) for end in ends]
        axis.errorbar(100.0 * values, at, xerr=lengths, fmt="none", ecolor=STYLE["ink"], elinewidth=1.3, capsize=2.5)
    for at, row in enumerate(rows):
        axis.text(0.6, at + 0.3, row["words"], fontsize=10.5, color=STYLE["ink"], va="bottom")
    axis.set_yticks([])
    axis.set_ylim(-0.5, len(rows) - 0.3)
    axis.set_xlim(0.0, max(100.0, axis.get_xlim()[1]))
    heading(axis, one["title"], "share of the variance [%]")


def _footer(result) -> str:
    summary, sweep = result.summary, sweep_of(result)
    failed, words = sum(summary["failed"].values()), SweepInWords(sweep) if sweep else None
    parts = [f"at {words.at}"] if words and words.at else []
    parts += [f"{summary['samples']} samples, {summary['sampler'].replace('_', ' ')}, seed {summary['seed']}"]
    parts += [f"{failed} failed"] if failed else []
    parts += [summary["stopped_because"]]
    parts += [words.ended] if words and words.ended else []
    others = result.study.quantities[MOST_QUANTITIES:]
    parts += [f"not drawn: {', '.join(others)}"] if others else []
    text = "; ".join(parts)
    return text if len(text) < 190 else text[:187] + "..."
