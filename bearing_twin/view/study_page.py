"""The page of a study, and its picture: distributions with quantiles, convergence, histories, shares of a variance."""

import base64
import contextlib
import io
import math
from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from bearing_twin.base.errors import StatisticError, StudyError
from bearing_twin.base.units import (
    inverse,
    known_digits,
    labelled,
    prefixed,
    sentence_for_people,
    two_digits,
    unit_for_people,
    with_unit,
)
from bearing_twin.pictures import BALL_COLOURS, STYLE, finish, frame, heading, key_above
from bearing_twin.uq.propagation import Derived, derive, through
from bearing_twin.uq.realisations import exact_distributions, task_of, uncertain_inputs
from bearing_twin.uq.result import BANDS, StudyResult, SweepInWords, model_error_sentences, refusals, size_of, sweep_of
from bearing_twin.uq.statistics import histogram, kernel_density
from bearing_twin.view.tables import DIGITS, error_notes

BLUE, ORANGE, GREEN, RED, INK = 0, 1, 2, 5, 6  # numbers of colours
POINTS = 480  # of a curve
FAR = 0.001  # probability left out on either side of a distribution
ORDERS = {"first": "alone", "total": "with others"}  # of Sobol's indices, in words
MOST_QUANTITIES = 12
SHOWN_QUANTILES = ("0.05", "0.50", "0.95")
STATISTICS = ("mean", "std", "skewness")
IN_WORDS = {"std": "standard deviation"}


def document_of_study(result: StudyResult) -> dict[str, Any]:
    """The page of a study that has run."""
    study, summary = result.study, result.as_dict()
    names = study.quantities[:MOST_QUANTITIES]
    failed, sweep = sum(summary["failed"].values()), sweep_of(result)
    words = SweepInWords(sweep) if sweep else None
    inputs = ((key, text.removeprefix(f"{key}: ")) for key, text in summary["inputs"].items())  # which begin with it
    badges = [
        *([{"sort": "", "name": "at", "text": words.at}] if words and words.at else []),
        {"sort": "", "name": "samples", "text": str(summary["samples"])},
        {"sort": "", "name": "sampler", "text": summary["sampler"].replace("_", " ")},
        *([{"sort": "bad", "name": "", "text": f"{failed} failed"}] if failed else []),
        *(
            [{"sort": "doubt", "name": "", "text": f"{len(result.doubts)} warning{'s' * (len(result.doubts) > 1)}"}]
            if result.doubts
            else []
        ),
    ]
    ended = [words.ended] if words and words.ended else []
    drawn = io.BytesIO()
    figure = _figure(result, names, study.histories)
    figure.savefig(drawn, format="svg", bbox_inches="tight", metadata={"Date": None})
    return {
        "kind": "study",
        "title": study.name,
        "subtitle": study.description or f"study of {summary['scene']}",
        "badges": badges,
        "picture": f"data:image/svg+xml;base64,{base64.b64encode(drawn.getvalue()).decode('ascii')}",
        "statistics": [{"title": _words(name), "rows": _statistics(summary["quantities"][name])} for name in names],
        "flags": [sentence_for_people(one) for one in (*result.doubts, *_refused(names, summary), *ended)],
        "warnings": [],
        "reason": f"Sampling ended because {summary['stopped_because']}.",
        "facts": [("scene", summary["scene"]), ("seed", str(summary["seed"])), *inputs],
        "errors": [*model_error_sentences(summary), *error_notes(summary.get("companions", {}))],
        "notes": [],
    }


def study_charts(result: StudyResult, names: Iterable[str], channels: Iterable[str]) -> Iterator[dict[str, Any]]:
    """Charts of the distribution of each quantity, the convergence, histories, and quantities over the sweep."""
    summary, exact, sweep = result.summary, exact_of(result), sweep_of(result)
    for name in names:
        yield from _distribution(result, name, exact.get(name))
    yield from _convergence(summary, exact)
    yield from (_history(result, name) for name in channels if summary["histories"][name].keys() & {*BANDS})
    if sweep and len(sweep["studies"]) > 1:
        yield from (_swept(result, name, sweep, SweepInWords(sweep)) for name in names)


def exact_of(result: StudyResult) -> dict[str, Derived]:
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
    if "low" not in path:  # a log of an earlier version has the half width alone
        return samples, value, value - half, value + half
    return samples, value, *(np.array(path[key], float) for key in ("low", "high"))


def _words(name: str) -> str:
    return name.replace("_", " ").capitalize()


def _chart(title, y_label, unit, x, lines, x_label, x_unit, **more) -> dict[str, Any]:
    """A chart: `lines` are (label, y, colour) or the same with a mapping of how it looks.

    `bands` are (high line, low line, colour, label), `spans` marks along x, `error` is a value and its error of the
    model; an axis that is `wide` is logarithmic where values span much.
    """
    return {
        "title": title,
        "yLabel": labelled(y_label, unit),
        "x": np.array(x, float),
        "xLabel": labelled(x_label, x_unit),
        "ys": [np.array(line[1], float) for line in lines],
        "lines": [{"label": line[0], "colour": line[2], **(line[3] if len(line) > 3 else {})} for line in lines],
        "spans": [],
        "bands": [],
        "from_zero": False,
        **more,
    }


def _distribution(result, name, exact) -> Iterator[dict[str, Any]]:
    """Histogram, smoothed and exact density over the quantity, with quantiles and their intervals."""
    found, sample = result.summary["quantities"][name], result.sample(name)
    kept = sample[np.isfinite(sample)]
    drawn = len(kept) > 1 and kept.min() < kept.max()
    marks = [found["quantiles"][key] for key in SHOWN_QUANTILES if key in found["quantiles"]]
    if exact is not None:
        low, high = exact.quantile(FAR), exact.quantile(1.0 - FAR)
    elif drawn:
        low, high = np.quantile(kept, [FAR, 1.0 - FAR])
    elif len(marks) > 1 and found["method"] == "chaos":
        low, high = marks[0]["value"], marks[-1]["value"]
    else:
        return
    margin = 0.08 * (high - low) or 1.0
    x = np.linspace(low - margin, high + margin, POINTS)
    unit, factor = unit_of(found)
    lines = []
    if drawn:
        edges, heights = histogram(kept)
        place = np.searchsorted(edges, x, side="right") - 1
        inside = (place >= 0) & (place < len(heights))
        bars = np.where(inside, heights[np.clip(place, 0, len(heights) - 1)], 0.0)
        smooth = kernel_density(kept)
        lines.append((f"{len(kept)} samples", bars / factor, BLUE, {"filled": True, "width": 0.8}))
        lines.append(("smoothed", np.interp(x, *smooth, 0.0, 0.0) / factor, BLUE, {"width": 2.2}))
    if exact is not None:
        lines.append(("change of variable", np.nan_to_num(exact.pdf(x)) / factor, INK, {"dashed": True}))
    title = f"{_words(name)}: 5, 50 and 95 % quantiles with intervals"
    error, middle = found.get("error"), found["quantiles"].get("0.50")
    bar = None if error is None or middle is None else [factor * middle["value"], factor * error]
    more = {"spans": [_span(one, kept, factor) for one in marks], "from_zero": True, "error": bar}
    yield _chart(title, "density", inverse(unit), x * factor, lines, _words(name).lower(), unit, **more)


def _span(quantile, kept: np.ndarray, factor: float) -> dict[str, Any]:
    """A quantile with its interval; an end that is `open`, by too few samples, is drawn at the last of them.

    None for an end where there are no samples at all.
    """
    ends = {"low": kept.min(), "high": kept.max()} if len(kept) else {"low": None, "high": None}
    found = {key: end if quantile[key] is None else quantile[key] for key, end in ends.items()}
    found["value"] = quantile["value"]
    span = {key: None if one is None else float(one) * factor for key, one in found.items()}
    return span | {"colour": RED, "open": [key for key in ends if quantile[key] is None]}


def _convergence(summary, exact) -> Iterator[dict[str, Any]]:
    path = summary["convergence"]
    if not path["samples"]:
        return
    name = path["quantity"].replace("_", " ")
    unit, factor = unit_of(summary["quantities"][path["quantity"]])
    samples, *columns = path_of(summary)
    value, low, high = (factor * one for one in columns)
    statistic = IN_WORDS.get(path["statistic"], path["statistic"])
    what = f"{path['probability']:g} quantile" if statistic == "quantile" else statistic
    edge = {"width": 0.6}
    lines = [("95 % interval, high", high, BLUE, edge), ("low", low, BLUE, edge)]
    lines.append((what, value, BLUE, {"points": True, "width": 2.2}))
    with contextlib.suppress(StatisticError):
        if path["quantity"] in exact and path["statistic"] != "quantile":
            level = factor * getattr(exact[path["quantity"]], path["statistic"])
            lines.append(("change of variable", np.full(len(samples), level), INK, {"dashed": True}))
    bands = [[0, 1, BLUE, "95 % interval"]]
    yield _chart(f"Convergence of {name}", what, unit, samples, lines, "samples", "", bands=bands)


def _history(result, channel) -> dict[str, Any]:
    found = result.summary["histories"][channel]
    names = [name for name in BANDS if name in found]
    size = max((abs(one) for name in names for one in found[name]), default=0.0)
    unit, scale = unit_for_people(result.history_unit(channel), size)
    time = np.array(found["time_s"])
    factor, time_unit = prefixed(float(np.abs(time).max()), "s")
    rows = (
        ("0.95", "95 %", BLUE, {"width": 0.6}),
        ("0.05", "5 %", BLUE, {"width": 0.6}),
        ("0.50", "median", BLUE, {"width": 2.2}),
        ("mean", "mean of the runs", RED, {}),
        ("at_mean_inputs", "run at the mean inputs", INK, {"dashed": True}),
    )
    lines = [(words, scale * np.array(found[key]), colour, look) for key, words, colour, look in rows if key in found]
    bands = [[0, 1, BLUE, "5 to 95 % at each instant"]] if "0.95" in found and "0.05" in found else []
    words = _words(channel)
    return _chart(f"{words} over time", words.lower(), unit, time * factor, lines, "time", time_unit, bands=bands)


def _swept(result, name, sweep, words) -> dict[str, Any]:
    """Quantiles and mean of a quantity over the number that is swept."""
    unit, factor = unit_of(result.summary["quantities"][name])
    found = [one["quantities"][name] for one in sweep["studies"]]
    rows = (("0.95", "95 %", {"width": 0.8}), ("0.05", "5 %", {"width": 0.8}), ("0.50", "median", {"width": 2.2}))
    lines = [
        (text, [factor * one["quantiles"].get(key, {}).get("value", math.nan) for one in found], BLUE, look)
        for key, text, look in rows
    ]
    means = [math.nan if one["mean"] is None else factor * one["mean"] for one in found]
    lines.append(("mean", means, RED, {"width": 2.2}))
    lines = [(*line[:3], {"points": True, **line[3]}) for line in lines]
    place = {"low": None, "high": None, "value": words.place, "colour": INK, "open": []}
    more = {"bands": [[0, 1, BLUE, "5 to 95 %"]], "wide": True, "spans": [place] if words.place is not None else []}
    title, swept = f"{_words(name)} over the sweep", _words(words.key.rpartition(".")[2]).lower()
    return _chart(title, _words(name).lower(), unit, words.values, lines, swept, words.unit, **more)


def study_shares(names, summary) -> Iterator[dict[str, Any]]:
    """Sobol's indices with their intervals, for bars."""
    for name in names:
        sources = {key: one for key, one in summary["quantities"][name].get("sobol", {}).items() if key != "refused"}
        if sources:
            rows = [{"words": key, "shares": [one[order] for order in ORDERS]} for key, one in sources.items()]
            yield {"title": f"{_words(name)}: share of its variance", "orders": list(ORDERS.values()), "rows": rows}


def _statistics(found) -> list[dict[str, str]]:
    rows, own = [], unit_of(found)
    error = found.get("error")  # a log of an earlier version has none
    for key in STATISTICS:
        words = IN_WORDS.get(key, key)
        ends = tuple(found[f"{key}_interval"] or (None, None))
        unit = ("", 1.0) if key == "skewness" else own
        rows.append(_row(words, found[key], ends, unit, error if key == "mean" else None))
    for p, one in found["quantiles"].items():
        rows.append(_row(f"{100.0 * float(p):g} % quantile", one["value"], (one["low"], one["high"]), own, error))
    return rows


def _row(words, value, ends, shown, error=None) -> dict[str, str]:
    unit, factor = shown
    known = max((abs(one - value) * factor for one in ends if None not in (one, value)), default=0.0)
    text = ["–" if one is None else known_digits(one * factor, known, DIGITS) for one in (value, *ends)]
    return {
        "words": words,
        "value": text[0],
        "unit": unit,
        "error": "" if error is None else two_digits(error * factor),
        "interval": "" if ends == (None, None) else f"{text[1]} to {text[2]}",
        "meaning": "",
    }


def _refused(names, summary) -> list[str]:
    return [
        f"{', '.join(map(_words, which))}: {sentence}"
        for which, sentence in refusals({name: summary["quantities"][name] for name in names})
    ]


MOST_DRAWN = 4
TICK = 0.7  # inches of a panel for each number below it, so that those of five digits stand apart
ROOM = 0.25  # of the intervals that are known, for those that are open
WIDE = 20.0  # the greatest of what is drawn along a wide axis over the least, from which on it is logarithmic
OPEN_END = "open to the edge: too few samples"
BAR, FILL = "#b9c6d2", {"alpha": 0.2, "linewidth": 0}


def plot_study(result: StudyResult, png_path) -> Path:
    """Writes the picture of a result; returns the path. Raises BearingTwinError where that is impossible."""
    study = result.study
    figure = _figure(result, study.quantities[:MOST_DRAWN], study.histories[:1])
    title = study.description[:1].upper() + study.description[1:] or study.name
    return finish(figure, title, _footer(result), png_path, size=16)


def _figure(result, names, channels):
    """The charts of these quantities and histories, with room above for a title."""
    from matplotlib.figure import Figure

    drawn = [partial(_draw_chart, one=one) for one in study_charts(result, names, channels)]
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
    return figure


def _draw_chart(axis, one) -> None:
    """A chart of the page; lines that bound a band are drawn as the band alone."""
    x, ys, banded = one["x"], one["ys"], set()
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
    others = result.study.quantities[MOST_DRAWN:]
    parts += [f"not drawn: {', '.join(others)}"] if others else []
    text = "; ".join(parts)
    return text if len(text) < 190 else text[:187] + "..."
