"""The picture of a study: distributions with quantiles, convergence, histories, the sweep, shares of a variance."""

import contextlib
import math
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from bearing_twin.base.errors import StatisticError, StudyError
from bearing_twin.base.units import readable_unit, with_unit
from bearing_twin.charts.panels import (
    Axis,
    Band,
    Line,
    Panel,
    Sheet,
    band_style,
    figure_of,
    in_rows,
    line_style,
    reference_style,
)
from bearing_twin.pictures import BALL_COLOURS, STYLE, save
from bearing_twin.uq.propagation import Derived
from bearing_twin.uq.realisations import exact_distributions, task_of
from bearing_twin.uq.result import BANDS, StudyResult, SweepDescription, shares_of, size_of, sweep_of
from bearing_twin.uq.statistics import histogram, kernel_density

POINTS = 480  # of a curve
FAR = 0.001  # probability left out on either side of a distribution
ORDERS = {"first": "alone", "total": "with others"}  # of Sobol's indices, in words
IN_WORDS = {"std": "standard deviation"}
SHOWN_QUANTILES = ("0.05", "0.50", "0.95")
MOST_DRAWN = 4
ROOM = 0.25  # of the intervals that are known, for those that are open
WIDE = 20.0  # the greatest of what is drawn along an axis over the least, from which on it is logarithmic
OPEN_END = "open to the edge: too few samples"
ACRONYMS = ("bpfo", "bpfi", "bsf", "rms")
BLUE, RED = line_style(0), line_style(5)
BARS = {"step": "post", "color": "#b9c6d2"}
HATCHED = {"facecolor": "none", "edgecolor": BALL_COLOURS[5], "alpha": 0.45, "hatch": "///"}
ENDS = {"color": STYLE["ink"], "linewidth": 2.0, "marker": "|", "markersize": 10, "markeredgewidth": 2.0}
POINTED = {"marker": "o", "markersize": 3.5}


def plot_study(result: StudyResult, png_path) -> Path:
    """Writes the picture of a result; returns the path. Raises BearingTwinError where that is impossible."""
    study = result.study
    sheet = sheet_of(result, study.quantities[:MOST_DRAWN], study.histories[:1])
    sheet.title = study.description[:1].upper() + study.description[1:] or study.name
    sheet.footer = _footer(result)
    return save(figure_of(sheet), png_path)


def sheet_of(result: StudyResult, names: Iterable[str], channels: Iterable[str]) -> Sheet:
    """The panels of these quantities and histories."""
    panels = list(_panels(result, names, channels))
    return Sheet("", in_rows(panels, 2 if len(panels) <= 4 else 3), "", [], shared_legend=True)


def _panels(result, names, channels) -> Iterator[Panel]:
    summary, exact, sweep = result.summary, _exact_of(result), sweep_of(result)
    yield from (_distribution(result, name, exact.get(name)) for name in names)
    if summary["convergence"]["samples"]:
        yield _convergence(summary, exact)
    yield from (_history(result, name) for name in channels if summary["histories"][name].keys() & {*BANDS})
    if sweep and len(sweep["studies"]) > 1:
        known = [name for name in names if any(one["quantities"][name]["quantiles"] for one in sweep["studies"])]
        yield from (_swept(summary["quantities"][name], name, sweep) for name in known)
    for name in names:
        if sources := shares_of(summary["quantities"][name]):
            yield _shares(name, sources)


def _exact_of(result: StudyResult) -> dict[str, Derived]:
    """The distributions to compare the sample with, where a change of variable gives them."""
    study = result.study
    try:
        return exact_distributions(study, task_of(study), "auto")
    except StudyError:
        return {}


def unit_of(found) -> tuple[str, float]:
    """(unit, factor into it) in which people read a quantity of a summary, as in the table of the command."""
    return readable_unit(found["unit"], size_of(found))


def words_of(name: str) -> str:
    """The name of a quantity or a channel in words."""
    return " ".join(word.upper() if word in ACRONYMS else word for word in name.split("_"))


def title_of(name: str) -> str:
    """The name of a quantity or a channel as a title."""
    words = words_of(name)
    return words[:1].upper() + words[1:]


def _axis_of(found, name: str, **more) -> Axis:
    """The axis of a quantity, in the unit of the table."""
    return Axis(words_of(name), found["unit"], shown=unit_of(found), **more)


def _distribution(result, name, exact) -> Panel:
    """Histogram, smoothed and exact density of a quantity, its quantiles with intervals, the error of the model."""
    found, sample = result.summary["quantities"][name], result.sample(name)
    kept, quantiles, parts = sample[np.isfinite(sample)], found["quantiles"], []
    if len(kept) > 1 and kept.min() < kept.max():
        edges, heights = histogram(kept)
        parts.append(Band(f"{len(kept)} samples", edges, np.zeros(len(edges)), np.append(heights, 0.0), BARS))
        parts.append(Line("smoothed", *kernel_density(kept), BLUE))
        low, high = np.quantile(kept, [FAR, 1.0 - FAR])
    elif exact is None and (len(kept) or not quantiles):
        unit, factor = unit_of(found)
        value = f"{factor * kept[0]:.6g}{with_unit(unit)} in every realisation" if len(kept) else ""
        return Panel(f"{title_of(name)}: {value or 'no realisation succeeded'}", _axis_of(found, name), Axis(""), [])
    else:
        values = [one["value"] for one in quantiles.values()]
        low, high = min(values), max(values)
    if exact is not None:
        low, high = exact.quantile(FAR), exact.quantile(1.0 - FAR)
        x = np.linspace(low, high, POINTS)
        parts.append(Line("change of variable", x, np.nan_to_num(exact.pdf(x)), reference_style()))
    margin = 0.08 * (high - low) or 1.0
    ends = low - margin, high + margin
    top = 1.05 * max((float(np.max(part.y if isinstance(part, Line) else part.high)) for part in parts), default=1.0)
    up = Axis("density", f"1/{found['unit']}", limits=(0.0, top)) if parts else Axis("", limits=(0.0, top))
    parts += _quantiles([quantiles[key] for key in SHOWN_QUANTILES if key in quantiles], ends, top)
    if found.get("error") is not None and "0.50" in quantiles:  # a log of an earlier version has none
        around = quantiles["0.50"]["value"] + found["error"] * np.array([-1.0, 1.0])
        parts.append(Line("error of the model", around, [0.06 * top] * 2, ENDS))
    return Panel(title_of(name), _axis_of(found, name, limits=ends), up, parts)


def _quantiles(quantiles, ends, top: float) -> Iterator[Line | Band]:
    """Quantiles with their intervals; one with an open end is hatched and reaches the edge of the panel."""
    for place, one in enumerate(quantiles):
        known = [edge if one[key] is None else one[key] for key, edge in zip(("low", "high"), ends, strict=True)]
        yield Line("5, 50, 95 % with intervals", [one["value"]] * 2, [0.0, top], RED | {"linewidth": 1.3}, place == 0)
        yield Band("interval", known, [0.0] * 2, [top] * 2, band_style(5), False)
        if None in (one["low"], one["high"]):
            yield Band(OPEN_END, known, [0.0] * 2, [top] * 2, HATCHED)


def path_of(summary) -> tuple[np.ndarray, ...]:
    """Samples, estimate, low and high end (n,) of the statistic that was watched; NaN where the interval is open."""
    path = summary["convergence"]
    samples, value, half = (np.array(path[key], float) for key in ("samples", "estimate", "half_width"))
    half[~np.isfinite(half)] = np.nan
    if "low" not in path:  # a log of an earlier version has the half width alone
        return samples, value, value - half, value + half
    return samples, value, *(np.array(path[key], float) for key in ("low", "high"))


def _convergence(summary, exact) -> Panel:
    """The watched statistic over the number of samples, with its interval; open ends lie beyond the panel."""
    path, (samples, value, low, high) = summary["convergence"], path_of(summary)
    name, statistic = path["quantity"], path["statistic"]
    words = f"{path['probability']:g} quantile" if statistic == "quantile" else IN_WORDS.get(statistic, statistic)
    parts, limits, label = [Line(words, samples, value, BLUE | POINTED)], None, "95 % interval"
    with contextlib.suppress(StatisticError):
        if name in exact and statistic != "quantile":
            level = np.full(len(samples), getattr(exact[name], statistic))
            parts.append(Line("change of variable", samples, level, reference_style()))
    if np.isnan([low, high]).any():
        known = np.concatenate([low, high, *(part.y for part in parts)])
        least, greatest = np.nanmin(known), np.nanmax(known)
        room = ROOM * (greatest - least or abs(greatest) or 1.0)
        limits, label = (least - room, greatest + room), f"{label}, {OPEN_END}"
        low = np.where(np.isnan(low), least - 2.0 * room, low)
        high = np.where(np.isnan(high), greatest + 2.0 * room, high)
    up = Axis(words, summary["quantities"][name]["unit"], limits=limits, shown=unit_of(summary["quantities"][name]))
    title = f"Convergence of {name.replace('_', ' ')}"
    return Panel(title, Axis("samples", is_integer=True), up, [_band(label, samples, low, high), *parts])


def _band(label: str, x, low, high) -> Line | Band:
    """Intervals from `low` to `high`; of one place a band has no width and is a bar."""
    if len(x) > 1:
        return Band(label, x, low, high, band_style())
    return Line(label, [x[0]] * 2, [low[0], high[0]], BLUE | {"marker": "_", "markersize": 10})


def _history(result, channel) -> Panel:
    """Quantiles of a channel at each instant, the mean of the runs, and the run at the mean inputs."""
    found, parts = result.summary["histories"][channel], []
    size = max((abs(one) for name in BANDS if name in found for one in found[name]), default=0.0)
    unit, time = result.history_unit(channel), found["time_s"]
    if "0.05" in found:
        parts.append(_band("5 to 95 %", time, found["0.05"], found["0.95"]))
    for name, label, look in (
        ("0.50", "median", BLUE),
        ("mean", "mean", RED),
        ("at_mean_inputs", "run at the mean inputs", reference_style()),
    ):
        if name in found:
            parts.append(Line(label, time, found[name], look))
    up = Axis(channel.replace("_", " "), unit, shown=readable_unit(unit, size))
    return Panel(f"{title_of(channel)} over time", Axis("time", "s"), up, parts)


def _swept(found, name, sweep) -> Panel:
    """Quantiles and mean of a quantity over the number that is swept; a line where the other panels are."""
    values = [one["value"] for one in sweep["studies"]]
    each = [one["quantities"][name] for one in sweep["studies"]]
    low, median, high = (
        np.array([one["quantiles"].get(key, {}).get("value", math.nan) for one in each]) for key in SHOWN_QUANTILES
    )
    mean = np.array([math.nan if one["mean"] is None else one["mean"] for one in each])
    parts = [
        _band("5 to 95 %", values, low, high),
        Line("median", values, median, BLUE | POINTED),
        Line("mean", values, mean, RED | POINTED),
    ]
    drawn = np.array([low, median, high, mean])
    if (place := sweep.get("at")) is not None:
        look = reference_style() | {"linewidth": 1.3, "linestyle": ":"}
        parts.append(Line("value of the other panels", [place] * 2, [np.nanmin(drawn), np.nanmax(drawn)], look))
    words, unit = SweepDescription(sweep), sweep.get("unit", "1")
    swept = words_of(words.key.rpartition(".")[2])
    across = Axis(swept, unit, _is_wide(values), shown=readable_unit(unit, max(map(abs, values))))
    return Panel(f"{title_of(name)} over the sweep", across, _axis_of(found, name, log=_is_wide(drawn)), parts)


def _is_wide(numbers) -> bool:
    """True where numbers span more than a factor WIDE, for a logarithmic axis."""
    known = np.asarray(numbers, float)
    known = known[np.isfinite(known)]
    return bool(len(known) and known.min() > 0.0 and known.max() >= WIDE * known.min())


def _shares(name, sources) -> Panel:
    """Sobol's indices of a quantity, by input, as bars with their intervals, the greatest on top."""
    rows = sorted(sources.items(), key=lambda row: row[1]["total"]["value"])
    bar, parts = {"linewidth": 9.0, "solid_capstyle": "butt"}, []
    for place, (order, label) in enumerate(ORDERS.items()):
        for row, (_, indices) in enumerate(rows):
            share, at = indices[order], [row + (0.14, -0.16)[place]] * 2
            ends = [100.0 * (share["value"] if share[end] is None else share[end]) for end in ("low", "high")]
            look = bar | {"color": BALL_COLOURS[place]}
            parts.append(Line(label, [0.0, 100.0 * share["value"]], at, look, row == 0))
            parts.append(Line(f"{label}, interval", ends, at, ENDS | {"linewidth": 1.3, "markersize": 6}, False))
    words = tuple("\n".join(key.rsplit(".", 1)) for key, _ in rows)
    across, up = Axis("share of the variance", "%", limits=(0.0, None)), Axis("", limits=(-0.5, len(rows) - 0.5))
    return Panel(f"{title_of(name)}: share of its variance", across, up, parts, names=words)


def _footer(result) -> str:
    summary, sweep = result.summary, sweep_of(result)
    failed, words = sum(summary["failed"].values()), SweepDescription(sweep) if sweep else None
    parts = [f"at {words.in_scene}"] if words and words.in_scene else []
    parts += [f"{summary['samples']} samples, {summary['sampler'].replace('_', ' ')}, seed {summary['seed']}"]
    parts += [f"{failed} failed"] if failed else []
    parts += [summary["stopped_because"]]
    parts += [words.incomplete] if words and words.incomplete else []
    others = result.study.quantities[MOST_DRAWN:]
    parts += [f"not drawn: {', '.join(others)}"] if others else []
    text = "; ".join(parts)
    return text if len(text) < 190 else text[:187] + "..."
