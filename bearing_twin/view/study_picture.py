"""The picture of a study: distributions with quantiles, convergence, histories, the sweep, shares of a variance."""

import contextlib
import math
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from bearing_twin.base.errors import StatisticError, StudyError
from bearing_twin.base.units import readable_unit, with_unit
from bearing_twin.pictures import (
    BALL_COLOURS,
    STYLE,
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
    save,
)
from bearing_twin.uq.propagation import Derived
from bearing_twin.uq.realisations import exact_distributions, task_of
from bearing_twin.uq.result import BANDS, StudyResult, SweepDescription, shares_of, size_of, sweep_of
from bearing_twin.uq.statistics import histogram, kernel_density

POINTS = 480  # of a curve
TAIL = 0.001  # probability left out on either side of a distribution
ORDERS = {"first": "alone", "total": "with others"}  # of Sobol's indices, in words
STATISTIC_NAMES = {"std": "standard deviation"}
SHOWN_QUANTILES = ("0.05", "0.50", "0.95")
MOST_DRAWN = 4
MARGIN = 0.25  # of the intervals that are known, for those that are open
WIDE = 20.0  # the greatest of what is drawn along an axis over the least, from which on it is logarithmic
OPEN_END = "open to the edge: too few samples"
ACRONYMS = ("bpfo", "bpfi", "bsf", "rms")
BLUE, RED = line_style(0), line_style(5)
BAR_STYLE = {"step": "post", "color": "#b9c6d2"}
HATCH_STYLE = {"facecolor": "none", "edgecolor": BALL_COLOURS[5], "alpha": 0.45, "hatch": "///"}
END_STYLE = {"color": STYLE["ink"], "linewidth": 2.0, "marker": "|", "markersize": 10, "markeredgewidth": 2.0}
POINT_STYLE = {"marker": "o", "markersize": 3.5}


def plot_study(result: StudyResult, png_path) -> Path:
    """Write the picture of a result; returns the path. Raises BearingTwinError where that is impossible."""
    study = result.study
    sheet = study_sheet(result, study.quantities[:MOST_DRAWN], study.histories[:1])
    sheet.title = study.description[:1].upper() + study.description[1:] or study.name
    sheet.footer = _footer(result)
    return save(figure_of(sheet), png_path)


def study_sheet(result: StudyResult, names: Iterable[str], channels: Iterable[str]) -> Sheet:
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
        known = [name for name in names if any(study["quantities"][name]["quantiles"] for study in sweep["studies"])]
        yield from (_sweep(summary["quantities"][name], name, sweep) for name in known)
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


def label_of(name: str) -> str:
    """The name of a quantity or a channel in words."""
    return " ".join(part.upper() if part in ACRONYMS else part for part in name.split("_"))


def title_of(name: str) -> str:
    """The name of a quantity or a channel as a title."""
    label = label_of(name)
    return label[:1].upper() + label[1:]


def _axis_of(quantity, name: str, **options) -> Axis:
    """The axis of a quantity, in the unit of the table."""
    return Axis(label_of(name), quantity["unit"], shown=unit_of(quantity), **options)


def _distribution(result, name, exact) -> Panel:
    """Histogram, smoothed and exact density of a quantity, its quantiles with intervals, the error of the model."""
    quantity, sample = result.summary["quantities"][name], result.sample(name)
    finite, quantiles, parts = sample[np.isfinite(sample)], quantity["quantiles"], []
    if len(finite) > 1 and finite.min() < finite.max():
        edges, heights = histogram(finite)
        parts.append(Band(f"{len(finite)} samples", edges, np.zeros(len(edges)), np.append(heights, 0.0), BAR_STYLE))
        parts.append(Line("smoothed", *kernel_density(finite), BLUE))
        low, high = np.quantile(finite, [TAIL, 1.0 - TAIL])
    elif exact is None and (len(finite) or not quantiles):
        unit, factor = unit_of(quantity)
        value = f"{factor * finite[0]:.6g}{with_unit(unit)} in every realisation" if len(finite) else ""
        return Panel(f"{title_of(name)}: {value or 'no realisation succeeded'}", _axis_of(quantity, name), Axis(""), [])
    else:
        values = [quantile["value"] for quantile in quantiles.values()]
        low, high = min(values), max(values)
    if exact is not None:
        low, high = exact.quantile(TAIL), exact.quantile(1.0 - TAIL)
        x = np.linspace(low, high, POINTS)
        parts.append(Line("change of variable", x, np.nan_to_num(exact.pdf(x)), reference_style()))
    margin = 0.08 * (high - low) or 1.0
    ends = low - margin, high + margin
    top = 1.05 * max((float(np.max(part.y if isinstance(part, Line) else part.high)) for part in parts), default=1.0)
    up = Axis("density", f"1/{quantity['unit']}", limits=(0.0, top)) if parts else Axis("", limits=(0.0, top))
    parts += _quantiles([quantiles[key] for key in SHOWN_QUANTILES if key in quantiles], ends, top)
    if quantity.get("error") is not None and "0.50" in quantiles:  # a log of an earlier version has none
        around = quantiles["0.50"]["value"] + quantity["error"] * np.array([-1.0, 1.0])
        parts.append(Line("error of the model", around, [0.06 * top] * 2, END_STYLE))
    return Panel(title_of(name), _axis_of(quantity, name, limits=ends), up, parts)


def _quantiles(quantiles, ends, top: float) -> Iterator[Line | Band]:
    """Quantiles with their intervals; one with an open end is hatched and reaches the edge of the panel."""
    for index, quantile in enumerate(quantiles):
        low, high = (
            edge if quantile[key] is None else quantile[key] for key, edge in zip(("low", "high"), ends, strict=True)
        )
        style = RED | {"linewidth": 1.3}
        yield Line("5, 50, 95 % with intervals", [quantile["value"]] * 2, [0.0, top], style, index == 0)
        yield Band("interval", [low, high], [0.0] * 2, [top] * 2, band_style(5), False)
        if None in (quantile["low"], quantile["high"]):
            yield Band(OPEN_END, [low, high], [0.0] * 2, [top] * 2, HATCH_STYLE)


def convergence_path(summary) -> tuple[np.ndarray, ...]:
    """Samples, estimate, low and high end (n,) of the statistic that was watched; NaN where the interval is open."""
    path = summary["convergence"]
    samples, value, half = (np.array(path[key], float) for key in ("samples", "estimate", "half_width"))
    half[~np.isfinite(half)] = np.nan
    if "low" not in path:  # a log of an earlier version has the half width alone
        return samples, value, value - half, value + half
    return samples, value, *(np.array(path[key], float) for key in ("low", "high"))


def _convergence(summary, exact) -> Panel:
    """The watched statistic over the number of samples, with its interval; open ends lie beyond the panel."""
    path, (samples, value, low, high) = summary["convergence"], convergence_path(summary)
    name, statistic = path["quantity"], path["statistic"]
    watched = STATISTIC_NAMES.get(statistic, statistic)
    watched = f"{path['probability']:g} quantile" if statistic == "quantile" else watched
    parts, limits, label = [Line(watched, samples, value, BLUE | POINT_STYLE)], None, "95 % interval"
    with contextlib.suppress(StatisticError):
        if name in exact and statistic != "quantile":
            level = np.full(len(samples), getattr(exact[name], statistic))
            parts.append(Line("change of variable", samples, level, reference_style()))
    if np.isnan([low, high]).any():
        known = np.concatenate([low, high, *(part.y for part in parts)])
        least, greatest = np.nanmin(known), np.nanmax(known)
        room = MARGIN * (greatest - least or abs(greatest) or 1.0)
        limits, label = (least - room, greatest + room), f"{label}, {OPEN_END}"
        low = np.where(np.isnan(low), least - 2.0 * room, low)
        high = np.where(np.isnan(high), greatest + 2.0 * room, high)
    quantity = summary["quantities"][name]
    up = Axis(watched, quantity["unit"], limits=limits, shown=unit_of(quantity))
    title = f"Convergence of {name.replace('_', ' ')}"
    return Panel(title, Axis("samples", is_integer=True), up, [_band(label, samples, low, high), *parts])


def _band(label: str, x, low, high) -> Line | Band:
    """Intervals from `low` to `high`; of one place a band has no width and is a bar."""
    if len(x) > 1:
        return Band(label, x, low, high, band_style())
    return Line(label, [x[0]] * 2, [low[0], high[0]], BLUE | {"marker": "_", "markersize": 10})


def _history(result, channel) -> Panel:
    """Quantiles of a channel at each instant, the mean of the runs, and the run at the mean inputs."""
    history, parts = result.summary["histories"][channel], []
    size = max((abs(number) for name in BANDS if name in history for number in history[name]), default=0.0)
    unit, time = result.history_unit(channel), history["time_s"]
    if "0.05" in history:
        parts.append(_band("5 to 95 %", time, history["0.05"], history["0.95"]))
    for name, label, style in (
        ("0.50", "median", BLUE),
        ("mean", "mean", RED),
        ("at_mean_inputs", "run at the mean inputs", reference_style()),
    ):
        if name in history:
            parts.append(Line(label, time, history[name], style))
    up = Axis(channel.replace("_", " "), unit, shown=readable_unit(unit, size))
    return Panel(f"{title_of(channel)} over time", Axis("time", "s"), up, parts)


def _sweep(quantity, name, sweep) -> Panel:
    """Quantiles and mean of a quantity over the number that is swept; a line where the other panels are."""
    values = [study["value"] for study in sweep["studies"]]
    rows = [study["quantities"][name] for study in sweep["studies"]]
    low, median, high = (
        np.array([row["quantiles"].get(key, {}).get("value", math.nan) for row in rows]) for key in SHOWN_QUANTILES
    )
    mean = np.array([math.nan if row["mean"] is None else row["mean"] for row in rows])
    parts = [
        _band("5 to 95 %", values, low, high),
        Line("median", values, median, BLUE | POINT_STYLE),
        Line("mean", values, mean, RED | POINT_STYLE),
    ]
    drawn = np.array([low, median, high, mean])
    if (at := sweep.get("at")) is not None:
        style = reference_style() | {"linewidth": 1.3, "linestyle": ":"}
        parts.append(Line("value of the other panels", [at] * 2, [np.nanmin(drawn), np.nanmax(drawn)], style))
    description, unit = SweepDescription(sweep), sweep.get("unit", "1")
    label = label_of(description.key.rpartition(".")[2])
    across = Axis(label, unit, _is_wide(values), shown=readable_unit(unit, max(map(abs, values))))
    return Panel(f"{title_of(name)} over the sweep", across, _axis_of(quantity, name, log=_is_wide(drawn)), parts)


def _is_wide(numbers) -> bool:
    """True where numbers span more than a factor WIDE, for a logarithmic axis."""
    known = np.asarray(numbers, float)
    known = known[np.isfinite(known)]
    return bool(len(known) and known.min() > 0.0 and known.max() >= WIDE * known.min())


def _shares(name, sources) -> Panel:
    """Sobol's indices of a quantity, by input, as bars with their intervals, the greatest on top."""
    rows = sorted(sources.items(), key=lambda row: row[1]["total"]["value"])
    bar, parts = {"linewidth": 9.0, "solid_capstyle": "butt"}, []
    for index, (order, label) in enumerate(ORDERS.items()):
        for row, (_, indices) in enumerate(rows):
            share, height = indices[order], [row + (0.14, -0.16)[index]] * 2
            ends = [100.0 * (share["value"] if share[end] is None else share[end]) for end in ("low", "high")]
            style = bar | {"color": BALL_COLOURS[index]}
            parts.append(Line(label, [0.0, 100.0 * share["value"]], height, style, row == 0))
            end_style = END_STYLE | {"linewidth": 1.3, "markersize": 6}
            parts.append(Line(f"{label}, interval", ends, height, end_style, False))
    names = tuple("\n".join(key.rsplit(".", 1)) for key, _ in rows)
    across, up = Axis("share of the variance", "%", limits=(0.0, None)), Axis("", limits=(-0.5, len(rows) - 0.5))
    return Panel(f"{title_of(name)}: share of its variance", across, up, parts, names=names)


def _footer(result) -> str:
    summary, sweep = result.summary, sweep_of(result)
    failed, description = sum(summary["failed"].values()), SweepDescription(sweep) if sweep else None
    parts = [f"at {description.in_scene}"] if description and description.in_scene else []
    parts += [f"{summary['samples']} samples, {summary['sampler'].replace('_', ' ')}, seed {summary['seed']}"]
    parts += [f"{failed} failed"] if failed else []
    parts += [summary["stopped_because"]]
    parts += [description.incomplete] if description and description.incomplete else []
    omitted = result.study.quantities[MOST_DRAWN:]
    parts += [f"not drawn: {', '.join(omitted)}"] if omitted else []
    return "; ".join(parts)
