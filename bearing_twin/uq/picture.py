"""Panels in the picture of a study: shares of the variance of a quantity, and the quantity over a sweep."""

import contextlib
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.base.errors import StatisticError, StudyError
from bearing_twin.base.units import inverse, labelled, unit_for_people, with_unit
from bearing_twin.pictures.panels import finish
from bearing_twin.pictures.style import BALL_COLOURS, STYLE, frame, heading, key_above, scaled
from bearing_twin.uq.propagation import derive, through
from bearing_twin.uq.realisations import exact_distributions, task_of, uncertain_inputs
from bearing_twin.uq.result import StudyResult, SweepInWords, size_of, sweep_of
from bearing_twin.uq.statistics import histogram, kernel_density
from bearing_twin.uq.summary import BANDS

ORDERS = {"first": "alone", "total": "with others"}  # of Sobol's indices, in words
WIDE = 20.0  # the greatest of what is drawn over a sweep, over the least, from which on its axis is logarithmic


def shares_of(quantity) -> dict[str, dict]:
    """Sobol's indices of a quantity by key: `first` and `total` with value, low and high; empty without any."""
    return {key: one for key, one in quantity.get("sobol", {}).items() if key != "refused"}


def draw_shares(axis, name, shares):
    """Sobol's indices as bars with their intervals, the greatest on top."""
    keys = sorted(shares, key=lambda key: shares[key]["total"]["value"])
    frame(axis)
    for place, (order, words) in enumerate(ORDERS.items()):
        values = np.array([shares[key][order]["value"] for key in keys])
        height, at = 0.28, np.arange(len(keys)) + (0.14 if place == 0 else -0.16)
        axis.barh(at, 100.0 * values, height, color=BALL_COLOURS[place], label=words)
        ends = [[shares[key][order][end] for key in keys] for end in ("low", "high")]
        lengths = [
            [100.0 * abs(end - value) if end is not None else 0.0 for end, value in zip(row, values, strict=True)]
            for row in ends
        ]
        axis.errorbar(100.0 * values, at, xerr=lengths, fmt="none", ecolor=STYLE["ink"], elinewidth=1.3, capsize=2.5)
    for at, key in enumerate(keys):
        axis.text(0.6, at + 0.3, key, fontsize=10.5, color=STYLE["ink"], va="bottom")
    axis.set_yticks([])
    axis.set_ylim(-0.5, len(keys) - 0.3)
    axis.set_xlim(0.0, max(100.0, axis.get_xlim()[1]))
    heading(axis, f"{name.replace('_', ' ').capitalize()}: shares of its variance", "share of the variance [%]")


def draw_sweep(axis, sweep, name, shown):
    """Mean, median and the 5 and 95 % quantiles over what is swept, and where the other panels are."""
    words, (unit, factor) = SweepInWords(sweep), shown
    found = [one["quantities"][name] for one in sweep["studies"]]
    curves = {p: [one["quantiles"].get(p, {}).get("value", np.nan) for one in found] for p in ("0.05", "0.50", "0.95")}
    curves["mean"] = [np.nan if one["mean"] is None else one["mean"] for one in found]
    curves = {key: factor * np.array(curve, float) for key, curve in curves.items()}
    frame(axis)
    _spread(axis, "x", np.array(words.values))
    _spread(axis, "y", np.array([*curves.values()]))
    axis.fill_between(
        words.values, curves["0.05"], curves["0.95"], color=BALL_COLOURS[0], alpha=0.2, linewidth=0, label="5 to 95 %"
    )
    look = {"linewidth": 2, "marker": "o", "markersize": 3.5}
    axis.plot(words.values, curves["0.50"], color=BALL_COLOURS[0], label="median", **look)
    axis.plot(words.values, curves["mean"], color=BALL_COLOURS[5], label="mean", **look)
    if words.place is not None:
        axis.axvline(words.place, color=STYLE["ink"], linewidth=1.2, linestyle=":", label="the other panels")
    plain = name.replace("_", " ")
    heading(axis, f"{plain.capitalize()} over the sweep", words.label, labelled(plain, unit))


def _spread(axis, along, numbers):
    """A logarithmic axis where what is drawn along it spans more than a factor WIDE, with its numbers written out."""
    known = numbers[np.isfinite(numbers)]
    if not len(known) or known.min() <= 0.0 or known.max() < WIDE * known.min():
        return
    axis.set(**{f"{along}scale": "log"})
    one = getattr(axis, f"{along}axis")
    one.set_major_formatter("{x:g}")
    one.set_tick_params(which="minor", length=0, labelbottom=False, labelleft=False)


# The picture of a study: what is known of each quantity, how the sampling converged, and bands of the histories.

MOST_QUANTITIES = 4
TICK = 0.7  # inches of a panel for each number below it, so that those of five digits stand apart
ROOM = 0.25  # of the intervals that are known, for those that are open
OPEN_END = "open to the edge: too few samples"
FAR = 0.001  # probability left out on either side of a distribution


def plot_study(result: StudyResult, png_path) -> Path:
    """Write the picture of a result; returns the path. Raises BearingTwinError where that is impossible."""
    study, names, summary = result.study, result.study.quantities[:MOST_QUANTITIES], result.summary
    exact = exact_of(result)
    drawn = [partial(_draw_quantity, result=result, name=name, exact=exact.get(name)) for name in names]
    if summary["convergence"]["samples"]:
        drawn.append(partial(_draw_convergence, result=result))
    if study.histories and summary["histories"][study.histories[0]].keys() & {*BANDS}:
        drawn.append(partial(_draw_history, result=result, channel=study.histories[0]))
    sweep = sweep_of(result)
    if sweep and len(sweep["studies"]) > 1:
        drawn += [
            partial(draw_sweep, sweep=sweep, name=name, shown=unit_of(summary["quantities"][name])) for name in names
        ]
    shares = {name: shares_of(summary["quantities"][name]) for name in names}
    drawn += [partial(draw_shares, name=name, shares=found) for name, found in shares.items() if found]
    columns = 2 if len(drawn) <= 4 else 3
    rows = -(-len(drawn) // columns)
    head = 1.65 if columns == 2 else 2.4  # in narrow panels keys stand in more lines
    tall = head - 0.05 + 4.9 * rows
    figure = Figure(figsize=(16.0, tall), dpi=100, facecolor="white")
    grid = figure.add_gridspec(
        rows,
        columns,
        left=0.06,
        right=0.98,
        top=1.0 - head / tall,
        bottom=0.95 / tall,
        hspace=0.5 if columns == 2 else 0.62,
        wspace=0.22,
    )
    for place, draw in enumerate(drawn):
        axis = figure.add_subplot(grid[place // columns, place % columns])
        draw(axis)
        key_above(axis)
    title = study.description or study.name
    return finish(figure, title[:1].upper() + title[1:], _footer(result), png_path, size=16)


def exact_of(result: StudyResult) -> dict:
    """The distributions to compare the sample with, where a change of variable gives them."""
    study = result.study
    runs = {name: one["runs"] for name, one in result.summary["quantities"].items() if "runs" in one}
    if runs:
        source = study.inputs[uncertain_inputs(study)[0]]
        columns = {name: np.array([(one["input"], one["value"]) for one in rows]).T for name, rows in runs.items()}
        return {name: derive(source, through(source, *both)) for name, both in columns.items()}
    try:
        return exact_distributions(study, task_of(study), "auto")
    except StudyError:
        return {}


def unit_of(found) -> tuple[str, float]:
    """(unit, factor into it) in which people read a quantity of a summary, as in the table of the command."""
    return unit_for_people(found["unit"], size_of(found))


def path_of(summary) -> tuple[np.ndarray, ...]:
    """Samples, estimate, low and high end (n,) of the statistic that was watched; NaN where the interval is open."""
    path = summary["convergence"]
    samples, value, half = (np.array(path[key], float) for key in ("samples", "estimate", "half_width"))
    half[~np.isfinite(half)] = np.nan
    # A log of an earlier version has the half width alone.
    low, high = (
        (np.array(path[key], float) for key in ("low", "high")) if "low" in path else (value - half, value + half)
    )
    return samples, value, low, high


def _draw_quantity(axis, result, name, exact):
    sample, found = result.sample(name), result.summary["quantities"][name]
    frame(axis)
    kept = sample[np.isfinite(sample)]
    heading(axis, name.replace("_", " ").capitalize())
    drawn = len(kept) > 1 and kept.min() < kept.max()
    unit, factor = unit_of(found)
    if not found["quantiles"] or (not drawn and exact is None and found["method"] != "chaos"):
        words = "no realisation succeeded"
        words = f"{factor * kept[0]:.6g}{with_unit(unit)} in every realisation" if len(kept) else words
        axis.text(0.5, 0.5, words, ha="center", va="center", transform=axis.transAxes)
        return
    marks = np.array([one["value"] for one in found["quantiles"].values()])
    low, high = marks[0], marks[-1]
    if drawn:
        edges, heights = histogram(kept)
        axis.stairs(heights / factor, edges * factor, fill=True, color="#b9c6d2", label=f"{len(kept)} samples")
        low, high = np.quantile(kept, [FAR, 1.0 - FAR])
        smooth = kernel_density(kept)
        axis.plot(smooth.x * factor, smooth.density / factor, color=BALL_COLOURS[0], linewidth=2, label="smoothed")
    if exact is not None:
        low, high = exact.quantile(FAR), exact.quantile(1.0 - FAR)
        x = np.linspace(low, high, 400)
        axis.plot(
            x * factor, exact.pdf(x) / factor, color=STYLE["ink"], linewidth=1.6, linestyle="--",
            label="change of variable",
        )  # fmt: skip
    intervals = []
    for probability in ("0.05", "0.50", "0.95"):
        if probability in found["quantiles"]:
            quantile = found["quantiles"][probability]
            axis.axvline(quantile["value"] * factor, color=BALL_COLOURS[5], linewidth=1.3)
            intervals.append([quantile[end] for end in ("low", "high")])
    words = {"ensemble": " with intervals", "chaos": " of the expansion"}.get(found["method"], "")
    label = f"5, 50, 95 %{words}"
    axis.plot([], [], color=BALL_COLOURS[5], linewidth=1.3, label=label)
    _draw_model_error(axis, found, factor)
    margin = 0.08 * (high - low)
    edges = low - margin, high + margin
    axis.set_xlim(*(factor * edge for edge in edges))
    _draw_intervals(axis, intervals, edges, factor)
    axis.set_ylim(bottom=0.0)
    axis.locator_params(axis="x", nbins=_ticks(axis))
    words = name.replace("_", " ")
    axis.set_xlabel(labelled(words, unit))
    if not drawn and exact is None:
        axis.set_yticks([])
        return
    axis.set_ylabel(labelled("density", inverse(unit)))


def _draw_intervals(axis, intervals, edges, factor):
    """Bands of intervals [low, high]; one with an open end (None) is hatched and reaches the edge of the panel."""
    for ends in intervals:
        low, high = (edge if end is None else end for end, edge in zip(ends, edges, strict=True))
        colour = {"color": BALL_COLOURS[5], "alpha": 0.18, "linewidth": 0}
        looks = {"facecolor": "none", "edgecolor": BALL_COLOURS[5], "alpha": 0.45, "linewidth": 0, "hatch": "///"}
        axis.axvspan(low * factor, high * factor, **colour)
        if None in ends:
            axis.axvspan(low * factor, high * factor, **looks)
    if any(None in ends for ends in intervals):
        axis.fill_between([], [], **looks, label=OPEN_END)


def _ticks(axis) -> int:
    """Into how many parts the numbers below a panel may cut it."""
    return int(axis.get_position().width * axis.figure.get_figwidth() / TICK)


def _draw_model_error(axis, found, factor):
    """A bar about the median as wide as the error of the model to either side, near the foot of the panel."""
    error, middle = found.get("error"), found["quantiles"].get("0.50")
    if error is None or middle is None:
        return
    axis.errorbar(
        middle["value"] * factor, 0.06, xerr=error * factor, transform=axis.get_xaxis_transform(), fmt="none",
        ecolor=STYLE["ink"], elinewidth=2.2, capsize=5, capthick=2.2, zorder=5, label="error of the model",
    )  # fmt: skip


def _draw_convergence(axis, result):
    path = result.summary["convergence"]
    samples, *columns = path_of(result.summary)
    found = result.summary["quantities"][path["quantity"]]
    unit, factor = unit_of(found)
    what = f"{path['probability']:g} quantile" if path["statistic"] == "quantile" else path["statistic"]
    frame(axis)
    value, low, high = (factor * column for column in columns)
    words, (low, high) = "95 % interval", _to_the_edges(axis, value, low, high)
    if np.isnan(columns[1:]).any():
        words = f"{words}, {OPEN_END}"
    if len(samples) > 1:
        axis.fill_between(samples, low, high, color=BALL_COLOURS[0], alpha=0.2, linewidth=0, label=words)
    else:  # of one look a band has no width
        axis.errorbar(
            samples, value, yerr=[value - low, high - value], fmt="none", ecolor=BALL_COLOURS[0],
            elinewidth=1.6, capsize=5, label=words,
        )  # fmt: skip
    axis.plot(samples, value, color=BALL_COLOURS[0], linewidth=2, marker="o", markersize=3.5, label=what)
    exact = exact_of(result).get(path["quantity"])
    if exact is not None and path["statistic"] in ("mean", "std"):
        with contextlib.suppress(StatisticError):
            level = getattr(exact, path["statistic"]) * factor
            axis.axhline(level, color=STYLE["ink"], linestyle="--", linewidth=1.4, label="change of variable")
    axis.ticklabel_format(axis="y", useOffset=False)  # an offset would stand in the heading
    axis.locator_params(axis="x", nbins=_ticks(axis), integer=True, min_n_ticks=1)
    heading(axis, f"Convergence of {path['quantity'].replace('_', ' ')}", "samples", labelled(what, unit))


def _to_the_edges(axis, value, low, high):
    """The ends (n,) of intervals about `value`; open ones (NaN) lie beyond the edge of the panel, which is set here."""
    if not np.isnan([low, high]).any():
        return low, high
    known = np.concatenate([value, low, high])
    least, greatest = np.nanmin(known), np.nanmax(known)
    room = ROOM * (greatest - least or abs(greatest) or 1.0)
    axis.set_ylim(least - room, greatest + room)
    return np.where(np.isnan(low), least - 2.0 * room, low), np.where(np.isnan(high), greatest + 2.0 * room, high)


def _draw_history(axis, result, channel):
    found = result.summary["histories"][channel]
    time = np.array(found["time_s"])
    scale_time, unit_time = scaled(time, "s")
    frame(axis)
    names = [name for name in BANDS if name in found]
    size = np.abs(np.concatenate([found[name] for name in names])).max()
    unit, scale = unit_for_people(result.history_unit(channel), float(size))
    curves = {name: np.array(found[name]) * scale for name in names}
    if "mean" in curves:
        axis.fill_between(
            time * scale_time, curves["0.05"], curves["0.95"], color=BALL_COLOURS[0], alpha=0.2, linewidth=0,
            label="5 to 95 % at each instant",
        )  # fmt: skip
        axis.plot(time * scale_time, curves["0.50"], color=BALL_COLOURS[0], linewidth=2, label="median")
        axis.plot(time * scale_time, curves["mean"], color=BALL_COLOURS[5], linewidth=2, label="mean of the runs")
    if "at_mean_inputs" in curves:
        axis.plot(
            time * scale_time, curves["at_mean_inputs"], color=STYLE["ink"], linestyle="--", linewidth=1.6,
            label="run at the mean inputs",
        )  # fmt: skip
    axis.set_xlabel(f"time [{unit_time}]")
    axis.set_ylabel(labelled(channel.replace("_", " "), unit))
    axis.margins(x=0.0)
    heading(axis, f"{channel.replace('_', ' ').capitalize()} over time")


def _footer(result) -> str:
    summary = result.summary
    failed, sweep = sum(summary["failed"].values()), sweep_of(result)
    words = SweepInWords(sweep) if sweep else None
    parts = [f"at {words.at}"] if words and words.at else []
    parts += [f"{summary['samples']} samples, {summary['sampler'].replace('_', ' ')}, seed {summary['seed']}"]
    parts += [f"{failed} failed"] if failed else []
    parts += [summary["stopped_because"]]
    parts += [words.ended] if words and words.ended else []
    others = result.study.quantities[MOST_QUANTITIES:]
    parts += [f"not drawn: {', '.join(others)}"] if others else []
    text = "; ".join(parts)
    return text if len(text) < 190 else text[:187] + "..."
