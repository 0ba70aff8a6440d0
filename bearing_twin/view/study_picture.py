"""The picture of a study: distributions with quantiles, convergence, histories, the sweep, shares of a variance."""

import contextlib
import math
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from bearing_twin.base.errors import StatisticError, StudyError
from bearing_twin.base.units import inverse, labelled, prefixed, unit_for_people, with_unit
from bearing_twin.pictures import BALL_COLOURS, STYLE, finish, frame, heading, key_above
from bearing_twin.uq.propagation import Derived
from bearing_twin.uq.realisations import exact_distributions, task_of
from bearing_twin.uq.result import BANDS, StudyResult, SweepInWords, size_of, sweep_of
from bearing_twin.uq.statistics import histogram, kernel_density

BLUE, RED, INK = (BALL_COLOURS[number] for number in (0, 5, 6))
POINTS = 480  # of a curve
FAR = 0.001  # probability left out on either side of a distribution
ORDERS = {"first": "alone", "total": "with others"}  # of Sobol's indices, in words
IN_WORDS = {"std": "standard deviation"}
SHOWN_QUANTILES = ("0.05", "0.50", "0.95")
MOST_DRAWN = 4
TICK = 0.7  # inches of a panel for each number below it, so that those of five digits stand apart
ROOM = 0.25  # of the intervals that are known, for those that are open
WIDE = 20.0  # the greatest of what is drawn along an axis over the least, from which on it is logarithmic
OPEN_END = "open to the edge: too few samples"
BAR, FILL = "#b9c6d2", {"alpha": 0.2, "linewidth": 0}
POINTED = {"marker": "o", "markersize": 3.5}


def plot_study(result: StudyResult, png_path) -> Path:
    """Writes the picture of a result; returns the path. Raises BearingTwinError where that is impossible."""
    study = result.study
    figure = figure_of(result, study.quantities[:MOST_DRAWN], study.histories[:1])
    title = study.description[:1].upper() + study.description[1:] or study.name
    return finish(figure, title, _footer(result), png_path, size=16)


def figure_of(result: StudyResult, names: Iterable[str], channels: Iterable[str]):
    """The panels of these quantities and histories, with room above for a title."""
    from matplotlib.figure import Figure

    panels = list(_panels(result, names, channels))
    columns = 2 if len(panels) <= 4 else 3
    rows = -(-len(panels) // columns)
    head = 1.65 if columns == 2 else 2.4  # in narrow panels keys stand in more lines
    tall = head - 0.05 + 4.9 * rows
    figure = Figure(figsize=(16.0, tall), dpi=100, facecolor="white")
    space = {"top": 1.0 - head / tall, "bottom": 0.95 / tall, "hspace": 0.5 if columns == 2 else 0.62}
    grid = figure.add_gridspec(rows, columns, left=0.06, right=0.98, wspace=0.22, **space)
    for place, draw in enumerate(panels):
        axis = figure.add_subplot(grid[place // columns, place % columns])
        frame(axis)
        draw(axis)
        key_above(axis)
    return figure


def _panels(result, names, channels) -> Iterator[Callable[[Any], None]]:
    """Functions that draw a panel each."""
    summary, exact, sweep = result.summary, _exact_of(result), sweep_of(result)
    yield from (partial(_draw_distribution, result=result, name=name, exact=exact.get(name)) for name in names)
    if summary["convergence"]["samples"]:
        yield partial(_draw_convergence, summary=summary, exact=exact)
    drawn = (name for name in channels if summary["histories"][name].keys() & {*BANDS})
    yield from (partial(_draw_history, result=result, channel=name) for name in drawn)
    if sweep and len(sweep["studies"]) > 1:
        yield from (partial(_draw_sweep, result=result, name=name, sweep=sweep) for name in names)
    for name in names:
        sources = {key: one for key, one in summary["quantities"][name].get("sobol", {}).items() if key != "refused"}
        if sources:
            yield partial(_draw_shares, name=name, sources=sources)


def _exact_of(result: StudyResult) -> dict[str, Derived]:
    """The distributions to compare the sample with, where a change of variable gives them."""
    study = result.study
    try:
        return exact_distributions(study, task_of(study), "auto")
    except StudyError:
        return {}


def unit_of(found) -> tuple[str, float]:
    """(unit, factor into it) in which people read a quantity of a summary, as in the table of the command."""
    return unit_for_people(found["unit"], size_of(found))


def title_of(name: str) -> str:
    """The name of a quantity or a channel as a title."""
    return name.replace("_", " ").capitalize()


def _draw_distribution(axis, result, name, exact) -> None:
    """Histogram, smoothed and exact density of a quantity, its quantiles with intervals, the error of the model."""
    found, sample, title = result.summary["quantities"][name], result.sample(name), title_of(name)
    kept, (unit, factor) = sample[np.isfinite(sample)], unit_of(found)
    sampled = len(kept) > 1 and kept.min() < kept.max()
    quantiles = [found["quantiles"][key] for key in SHOWN_QUANTILES if key in found["quantiles"]]
    if exact is not None:
        low, high = exact.quantile(FAR), exact.quantile(1.0 - FAR)
    elif sampled:
        low, high = np.quantile(kept, [FAR, 1.0 - FAR])
    elif len(quantiles) > 1 and found["method"] != "ensemble":
        low, high = quantiles[0]["value"], quantiles[-1]["value"]
    else:
        value = f"{factor * kept[0]:.6g}{with_unit(unit)} in every realisation" if len(kept) else ""
        axis.text(0.5, 0.5, value or "no realisation succeeded", ha="center", va="center", transform=axis.transAxes)
        heading(axis, title)
        return
    margin = 0.08 * (high - low) or 1.0
    values = np.linspace(low - margin, high + margin, POINTS)
    x = factor * values
    if sampled:
        edges, heights = histogram(kept)
        place = np.searchsorted(edges, values, side="right") - 1
        inside = (place >= 0) & (place < len(heights))
        bars = np.where(inside, heights[np.clip(place, 0, len(heights) - 1)], 0.0)
        smooth = np.interp(values, *kernel_density(kept), 0.0, 0.0)
        axis.fill_between(x, 0.0, bars / factor, color=BAR, linewidth=0, step="mid", label=f"{len(kept)} samples")
        axis.plot(x, smooth / factor, color=BLUE, linewidth=2.2, label="smoothed")
    if exact is not None:
        _draw_exact(axis, x, np.nan_to_num(exact.pdf(values)) / factor)
    heading(axis, title, labelled(title.lower(), unit), labelled("density", inverse(unit)))
    axis.set_xlim(x[0], x[-1])
    _draw_quantiles(axis, quantiles, kept, factor)
    if found.get("error") is not None and "0.50" in found["quantiles"]:  # a log of an earlier version has none
        axis.errorbar(
            factor * found["quantiles"]["0.50"]["value"], 0.06, xerr=factor * found["error"],
            transform=axis.get_xaxis_transform(), fmt="none", ecolor=STYLE["ink"], elinewidth=2.2, capsize=5,
            capthick=2.2, zorder=5, label="error of the model",
        )  # fmt: skip
    axis.set_ylim(bottom=0.0)
    _set_ticks(axis)


def _draw_exact(axis, x, y) -> None:
    axis.plot(x, y, color=INK, linewidth=1.8, linestyle="--", label="change of variable")


def _draw_quantiles(axis, quantiles, kept: np.ndarray, factor: float) -> None:
    """Quantiles with their intervals; one with an open end is hatched and reaches the edge of the panel."""
    edges, label = dict(zip(("low", "high"), axis.get_xlim(), strict=True)), "5, 50, 95 % with intervals"
    hatch = {"facecolor": "none", "edgecolor": RED, "alpha": 0.45, "linewidth": 0, "hatch": "///"}
    hatched = False
    for one in quantiles:
        known = len(kept) or one["low"] is not None
        axis.axvline(factor * one["value"], color=RED, linewidth=1.3, linestyle="-" if known else ":", label=label)
        ends = [edge if one[key] is None else factor * one[key] for key, edge in edges.items()]
        axis.axvspan(*ends, color=RED, **FILL)
        if None in (one["low"], one["high"]):
            axis.axvspan(*ends, **hatch)
            hatched = True
        label = None
    if hatched:
        axis.fill_between([], [], **hatch, label=OPEN_END)


def path_of(summary) -> tuple[np.ndarray, ...]:
    """Samples, estimate, low and high end (n,) of the statistic that was watched; NaN where the interval is open."""
    path = summary["convergence"]
    samples, value, half = (np.array(path[key], float) for key in ("samples", "estimate", "half_width"))
    half[~np.isfinite(half)] = np.nan
    if "low" not in path:  # a log of an earlier version has the half width alone
        return samples, value, value - half, value + half
    return samples, value, *(np.array(path[key], float) for key in ("low", "high"))


def _draw_convergence(axis, summary, exact) -> None:
    """The watched statistic over the number of samples, with its interval."""
    path = summary["convergence"]
    name, statistic = path["quantity"], path["statistic"]
    unit, factor = unit_of(summary["quantities"][name])
    samples, *columns = path_of(summary)
    value, low, high = (factor * one for one in columns)
    words = f"{path['probability']:g} quantile" if statistic == "quantile" else IN_WORDS.get(statistic, statistic)
    level = None
    with contextlib.suppress(StatisticError):
        if name in exact and statistic != "quantile":
            level = np.full(len(samples), factor * getattr(exact[name], statistic))
    ends = _to_the_edges(axis, low, high, value if level is None else np.append(value, level))
    label = f"95 % interval, {OPEN_END}" if np.isnan([low, high]).any() else "95 % interval"
    _draw_band(axis, samples, *ends, value, label)
    axis.plot(samples, value, color=BLUE, linewidth=2.2, label=words, **POINTED)
    if level is not None:
        _draw_exact(axis, samples, level)
    heading(axis, f"Convergence of {name.replace('_', ' ')}", "samples", labelled(words, unit))
    _set_ticks(axis, integer=True, min_n_ticks=1)


def _draw_band(axis, x, low, high, middle, label: str) -> None:
    """Intervals from `low` to `high`; of one instant a band has no width and is a bar about the `middle`."""
    if len(x) > 1:
        axis.fill_between(x, low, high, color=BLUE, label=label, **FILL)
        return
    ends = [(middle - low).tolist(), (high - middle).tolist()]
    axis.errorbar(x, middle, yerr=ends, fmt="none", elinewidth=1.6, capsize=5, ecolor=BLUE, label=label)


def _to_the_edges(axis, low, high, others):
    """The ends (n,) of intervals; open ones (NaN) lie beyond the edge of the panel, which all numbers set."""
    if not np.isnan([low, high]).any():
        return low, high
    known = np.concatenate([low, high, others])
    least, greatest = np.nanmin(known), np.nanmax(known)
    room = ROOM * (greatest - least or abs(greatest) or 1.0)
    axis.set_ylim(least - room, greatest + room)
    return np.where(np.isnan(low), least - 2.0 * room, low), np.where(np.isnan(high), greatest + 2.0 * room, high)


def _draw_history(axis, result, channel) -> None:
    """Quantiles of a channel at each instant, the mean of the runs, and the run at the mean inputs."""
    found, title = result.summary["histories"][channel], title_of(channel)
    size = max((abs(one) for name in BANDS if name in found for one in found[name]), default=0.0)
    unit, scale = unit_for_people(result.history_unit(channel), size)
    seconds = np.array(found["time_s"])
    factor, time_unit = prefixed(float(np.abs(seconds).max()), "s")
    time, curves = factor * seconds, {name: scale * np.array(found[name]) for name in BANDS if name in found}
    if "0.05" in curves and "0.95" in curves:
        middle = next(curves[name] for name in ("0.50", "mean", "at_mean_inputs") if name in curves)
        _draw_band(axis, time, curves["0.05"], curves["0.95"], middle, "5 to 95 % at each instant")
    for name, label, look in (
        ("0.50", "median", {"color": BLUE, "linewidth": 2.2}),
        ("mean", "mean of the runs", {"color": RED, "linewidth": 1.8}),
        ("at_mean_inputs", "run at the mean inputs", {"color": INK, "linewidth": 1.8, "linestyle": "--"}),
    ):
        if name in curves:
            axis.plot(time, curves[name], label=label, **look)
    heading(axis, f"{title} over time", labelled("time", time_unit), labelled(title.lower(), unit))
    _set_ticks(axis)


def _draw_sweep(axis, result, name, sweep) -> None:
    """Quantiles and mean of a quantity over the number that is swept; a line where the other panels are."""
    unit, factor = unit_of(result.summary["quantities"][name])
    found, words, title = [one["quantities"][name] for one in sweep["studies"]], SweepInWords(sweep), title_of(name)
    high, low, median = (
        np.array([factor * one["quantiles"].get(key, {}).get("value", math.nan) for one in found])
        for key in ("0.95", "0.05", "0.50")
    )
    mean = np.array([math.nan if one["mean"] is None else factor * one["mean"] for one in found])
    _draw_band(axis, words.values, low, high, median, "5 to 95 %")
    axis.plot(words.values, median, color=BLUE, linewidth=2.2, label="median", **POINTED)
    axis.plot(words.values, mean, color=RED, linewidth=2.2, label="mean", **POINTED)
    swept = labelled(title_of(words.key.rpartition(".")[2]).lower(), words.unit)
    heading(axis, f"{title} over the sweep", swept, labelled(title.lower(), unit))
    _spread(axis, "x", np.array(words.values, float))
    _spread(axis, "y", np.array([high, low, median, mean]))
    if words.place is not None:
        axis.axvline(words.place, color=INK, linewidth=1.3, linestyle=":", label="the other panels")
    _set_ticks(axis)


def _spread(axis, along, numbers) -> None:
    """A logarithmic axis where what is drawn along it spans more than a factor WIDE, with its numbers written out."""
    known = numbers[np.isfinite(numbers)]
    if not len(known) or known.min() <= 0.0 or known.max() < WIDE * known.min():
        return
    axis.set(**{f"{along}scale": "log"})
    one = getattr(axis, f"{along}axis")
    one.set_major_formatter("{x:g}")
    one.set_tick_params(which="minor", length=0, labelbottom=False, labelleft=False)


def _set_ticks(axis, **along) -> None:
    """Numbers beside linear axes: written out, and below the panel as many as have room."""
    if axis.get_yscale() == "linear":
        axis.ticklabel_format(axis="y", useOffset=False)
    if axis.get_xscale() == "linear":
        axis.locator_params(axis="x", nbins=int(axis.get_position().width * axis.figure.get_figwidth() / TICK), **along)


def _draw_shares(axis, name, sources) -> None:
    """Sobol's indices of a quantity, by input, as bars with their intervals, the greatest on top."""
    *_, last = ORDERS
    rows = sorted(sources.items(), key=lambda row: row[1][last]["value"])
    for place, (order, label) in enumerate(ORDERS.items()):
        shares = [indices[order] for _, indices in rows]
        values = np.array([share["value"] for share in shares])
        at = np.arange(len(rows)) + (0.14 if place == 0 else -0.16)
        axis.barh(at, 100.0 * values, 0.28, color=BALL_COLOURS[place], label=label)
        ends = ([share["value"] if share[end] is None else share[end] for share in shares] for end in ("low", "high"))
        lengths = [100.0 * np.abs(np.array(end) - values) for end in ends]
        axis.errorbar(100.0 * values, at, xerr=lengths, fmt="none", ecolor=STYLE["ink"], elinewidth=1.3, capsize=2.5)
    for at, (key, _) in enumerate(rows):
        axis.text(0.6, at + 0.3, key, fontsize=10.5, color=STYLE["ink"], va="bottom")
    axis.set_yticks([])
    axis.set_ylim(-0.5, len(rows) - 0.3)
    axis.set_xlim(0.0, max(100.0, axis.get_xlim()[1]))
    heading(axis, f"{title_of(name)}: share of its variance", "share of the variance [%]")


def _footer(result) -> str:
    summary, sweep = result.summary, sweep_of(result)
    failed, words = sum(summary["failed"].values()), SweepInWords(sweep) if sweep else None
    parts = [f"at {words.at}"] if words and words.at else []
    parts += [f"{summary['samples']} samples, {summary['sampler'].replace('_', ' ')}, seed {summary['seed']}"]
    parts += [f"{failed} failed"] if failed else []
    parts += [summary["stopped_because"]]
    parts += [words.ended] if words and words.ended else []
    others = result.study.quantities[MOST_DRAWN:]
    parts += [f"not drawn: {', '.join(others)}"] if others else []
    text = "; ".join(parts)
    return text if len(text) < 190 else text[:187] + "..."
