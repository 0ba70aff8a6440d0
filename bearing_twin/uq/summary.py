"""The summary of a study as plain data: statistics of quantities and histories, failures, warnings and notes.

A summary that comes from a log is checked by `check_summary`, whole, before it is used.
"""

import contextlib
import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import StatisticError, Stopped
from bearing_twin.base.stopping import stop_condition, stop_if_requested
from bearing_twin.base.units import two_digits, unit_for_people, with_unit
from bearing_twin.run.report import WORDS
from bearing_twin.uq.histories import history_statistics, narrowing
from bearing_twin.uq.propagation import Chaos, Derived, Interpolated
from bearing_twin.uq.result import OUT_OF_TIME, StudyResult, finite, size_of
from bearing_twin.uq.sampling import UnitPoints
from bearing_twin.uq.statistics import MOMENTS, MORE, Estimate, densities_at, estimate, modality, mode_numbers
from bearing_twin.uq.study import Study

PROBABILITIES = (0.05, 0.25, 0.5, 0.75, 0.95)
GRID = 2001  # points of a density whose modes are counted
SURROGATE_POINTS = 2**14  # of a polynomial chaos
POOR = 0.01  # error of an interpolant that is reported
BEYOND = 0.0005  # probability left out on either side where modes of an exact density are counted


class _Statistics(NamedTuple):
    """The sources of a quantity's statistics: functions that raise StatisticError where there are none.

    `of(statistic)` is an Estimate of a moment by name or of a quantile by its probability, `modes()` plain data,
    `densities(values)` estimates.
    """

    of: Callable[[str | float], Estimate]
    modes: Callable[[], dict[str, Any]]
    densities: Callable[[np.ndarray], list[Estimate]]

    def summary(self, missing: Mapping[str, str], at, modes: bool) -> dict[str, Any]:
        """Plain data; `missing` names moments that do not exist, with the reason, `at` the values of densities."""
        refused, result = dict(missing), {"unsafe": []}

        def tried(name: str, of: Callable, *given):
            try:
                return None if name in refused else of(*given)
            except StatisticError as error:
                refused[name] = str(error)
                return None

        for name in MOMENTS:
            found = tried(name, self.of, name)
            result[name], result[f"{name}_interval"] = found and found.value, found and [*map(finite, found[1:3])]
            result["unsafe"] += [name] if found and not found.safe else []
        quantiles = {p: tried(f"quantile {p:g}", self.of, p) for p in PROBABILITIES}
        result["quantiles"] = {f"{p:.2f}": _interval(*found[:3]) for p, found in quantiles.items() if found}
        result["modality"] = tried("modality", self.modes) if modes else None
        found = tried("densities", self.densities, np.array(at, float)) if at else None
        result["densities"] = [
            {"value": float(value), "density": one.value, "low": one.low, "high": one.high}
            for value, one in zip(at, found or (), strict=False)
        ]
        return {**result, "refused": refused}


def _of_sample(sample: np.ndarray, replicates: int, seed: int) -> _Statistics:
    sample = np.ascontiguousarray(sample)
    ordered = np.sort(sample)  # once, where it does not matter whose replicate a point is

    def of(statistic):
        unordered = statistic in MOMENTS or replicates > 1
        return estimate(sample if unordered else ordered, statistic, replicates)

    def modes():
        found = modality(ordered, seed)
        return {"modes": found.modes, "p_value": found.p_value, "positions": list(found.positions)}

    return _Statistics(of, modes, lambda at: densities_at(sample, at))


def _of_derived(derived: Derived, before: Derived) -> _Statistics:
    """Of an exact distribution; an interval is the change from the one `before`, to either side."""

    def around(value: float, other: float) -> Estimate:
        return Estimate(float(value), float(value - abs(value - other)), float(value + abs(value - other)))

    def of(statistic):
        if statistic not in MOMENTS:
            return around(*(one.quantile(statistic) for one in (derived, before)))
        value = getattr(derived, statistic)
        try:
            return around(value, getattr(before, statistic))
        except StatisticError:
            return Estimate(value, -math.inf, math.inf)

    def modes():
        places = np.linspace(derived.quantile(BEYOND), derived.quantile(1.0 - BEYOND), GRID)
        return {"modes": int(mode_numbers(derived.pdf(places))), "p_value": None}

    return _Statistics(of, modes, lambda at: list(map(around, derived.pdf(at), before.pdf(at))))


def _of_chaos(study: Study, chaos: Chaos) -> _Statistics:
    """Mean and deviation of an expansion exactly, the rest from SURROGATE_POINTS of it.

    The intervals of mean and deviation are the root mean square error of the expansion at fresh points; those of the
    rest have the sampling of the expansion alone.
    """
    points = UnitPoints("sobol", study.joint.dimension, study.settings.seed, SURROGATE_POINTS)
    sampled = _of_sample(chaos.predict(points.chunk(0, points.samples)), points.replicates, study.settings.seed)
    miss = chaos.error * chaos.std
    exact = {name: Estimate(value := getattr(chaos, name), value - miss, value + miss) for name in ("mean", "std")}
    return sampled._replace(of=lambda statistic: exact.get(statistic) or sampled.of(statistic))


def _interval(value, low=math.inf, high=math.inf) -> dict[str, Any]:
    return {"value": float(value), "low": finite(float(low)), "high": finite(float(high))}


def _of_quantity(result: StudyResult, name: str, found, missing, drawn, modes: bool) -> dict[str, Any]:
    """One quantity: by its distribution, interpolant or expansion `found`, or by the sample where that is None."""
    study, rule, at = result.study, drawn.rule, result.study.densities.get(name, ())
    if isinstance(found, Derived):
        one = _of_derived(found, found).summary({}, at, True)
        return {"method": "change_of_variable", **one, "half_width": 0.0}
    if isinstance(found, Interpolated):
        one = _of_derived(found.derived, found.before).summary(missing, at, True)
        low, high = one["mean_interval"] or (None, None)
        runs = [{"input": x, "value": y} for x, y in zip(found.at.tolist(), found.values.tolist(), strict=True)]
        half_width = None if None in (low, high) else 0.5 * (high - low)
        more = {"interpolation_error": found.error, "beyond_the_runs": found.left_out, "runs": runs}
        return {"method": "change_of_variable", **one, "half_width": half_width, **more}
    if isinstance(found, Chaos):
        one = _of_chaos(study, found).summary(missing, at, modes)
        one |= {"half_width": found.error * found.std, "degree": found.degree, "validation_error": found.error}
        if study.joint.independent:
            pairs = zip(study.joint.keys, found.first, found.total, strict=True)
            one["sobol"] = {key: {"first": _interval(first), "total": _interval(total)} for key, first, total in pairs}
        return {"method": "chaos", **one}
    statistics = _of_sample(result.sample(name), drawn.points.replicates, study.settings.seed)
    one = statistics.summary(missing, at, modes)
    if drawn.because.startswith(OUT_OF_TIME):  # more were requested
        one["refused"] = {key: why.replace(MORE, "raise time_limit") for key, why in one["refused"].items()}
    statistic, half_width = rule.of if name == rule.quantity else "mean", None
    if statistic not in one["refused"]:
        try:
            half_width = finite(statistics.of(statistic).half_width)
        except StatisticError:
            half_width = None
    return {"method": "ensemble", **one, "half_width": half_width}


def sobol_summary(indices: Mapping[str, Mapping[str, Estimate]]) -> dict[str, Any]:
    """First and total Sobol indices of a quantity by input as plain data."""
    return {
        key: {order: _interval(*one[:3]) | {"unsafe": not one.safe} for order, one in orders.items()}
        for key, orders in indices.items()
    }


def summary_of(result: StudyResult, without_sampling: Mapping, missing: Mapping, drawn, at_mean, model, ends) -> dict:
    """The plain data of a result, without seconds.

    Parameters
    ----------
    without_sampling : dict
        The distribution, interpolant or expansion of quantities that need no sample.
    missing : dict
        Moments that do not exist, by quantity, each with the reason.
    drawn : run.Drawn
        The ensemble.
    at_mean : Realised
        The realisation at the mean inputs, or none.
    model : model_errors.ModelErrors
    ends : function
        Once it is true modes and statistics of histories are left out, which a note says.
    """

    def found(whole: bool) -> dict:
        return _summary(result, without_sampling, missing, drawn, at_mean, model, whole)

    try:
        with stop_condition(ends):
            stop_if_requested()
            return found(whole=True)
    except Stopped:
        with stop_condition(lambda: False):
            return found(whole=False)


def _summary(result, without_sampling, missing, drawn, at_mean, model, whole: bool) -> dict:
    study, settings, quantities = result.study, result.study.settings, {}
    modes = settings.modality == "yes" and whole
    for column, (name, unit) in enumerate(result.quantity_units.items()):
        found = without_sampling.get(name)
        one = _of_quantity(result, name, found, missing.get(name, {}), drawn, modes)
        one["at_mean_inputs"] = finite(at_mean.quantities[0, column]) if len(at_mean.quantities) else None
        quantities[name] = {"unit": unit, **one} | model.for_quantity(name)
    poor = [
        f"{name}: the polynomial misses runs by {one.error:.2g} of the deviation; the method ensemble needs none"
        for name, one in without_sampling.items()
        if isinstance(one, Interpolated) and one.error > POOR
    ]
    cut = "cancelled: modes and statistics of histories are not computed; go on from the log for them"
    count, failed = len(result.status), result.status > 0
    return {
        "study": study.name,
        "scene": study.scene["name"],
        "inputs": {one.key: one.describe() for one in study.inputs},
        "quantities": quantities,
        "seed": settings.seed,
        "sampler": settings.sampler,
        "companions": model.checks,
        "stopped_because": drawn.because,
        "convergence": _convergence(drawn.rule, drawn.path),
        "histories": {
            channel: _of_history(result, channel, drawn.task.instants, at_mean.histories[:, place], whole)
            for place, channel in enumerate(study.histories)
        },
        "samples": count,
        "failed": {text: int(np.sum(result.status == 1 + place)) for place, text in enumerate(result.reasons)},
        "failed_share": float(np.mean(failed)) if count else 0.0,
        "doubts": {text: int(np.sum(result.doubtful >> k & 1)) for k, text in enumerate(result.doubts_met)},
        "notes": [*drawn.notes, *poor, *model.notes, *([] if whole else [cut])],
    }


def _convergence(rule, path) -> dict:
    """The path of the watched statistic over the samples, as in figures 9 and 14 of paper 3; an open end is null."""
    return {
        "quantity": rule.quantity,
        "statistic": rule.statistic,
        **({"probability": rule.probability} if rule.statistic == "quantile" else {}),
        "tolerance": rule.tolerance or None,
        "relative_tolerance": rule.relative_tolerance or None,
        "samples": [count for count, _ in path],
        "estimate": [one.value for _, one in path],
        "half_width": [one.half_width for _, one in path],
        "low": [finite(one.low) for _, one in path],
        "high": [finite(one.high) for _, one in path],
    }


def _of_history(result, channel, instants, at_mean, whole: bool) -> dict:
    """Bands of a history over the realisations that did not fail, and the run `at_mean` inputs (1 or 0, t)."""
    histories, inputs, bands, more = result.history(channel), result.values, {}, {}
    kept = np.isfinite(histories).all(axis=1)
    if not kept.all():
        histories, inputs = histories[kept], inputs[kept]
    if len(histories) > 1 and whole:
        keys = result.study.joint.keys
        bands = history_statistics(histories, inputs, keys)
        bands["autocorrelation_time_s"] = instants[bands.pop("rows")]
        with contextlib.suppress(StatisticError):  # where there is none
            more["least_spread"] = narrowing(instants, histories, inputs, keys, result.study.settings.seed)
    if len(at_mean):
        bands["at_mean_inputs"] = at_mean[0]
    head = {"realisations": len(histories), "time_s": instants.tolist()}
    return head | {name: one.tolist() for name, one in bands.items()} | more


def model_error_sentences(summary: Mapping[str, Any], shown: Callable = unit_for_people) -> Iterator[str]:
    """Sentences of a study's summary: each quantity's error of the model, how it was found, what is not known of it.

    `shown(unit, size)` gives (unit, factor) in which values of that size are shown.
    """
    checks = summary.get("companions")
    if checks is None:  # a log of an earlier version
        return
    for name, found in summary["quantities"].items():
        if found["error"] is not None:
            unit, factor = shown(found["unit"], size_of(found) or found["error"])
            known = ((source, error) for source, error in found["errors_by_source"].items() if error is not None)
            parts = sorted(known, key=lambda one: -one[1])
            sources = ", ".join(f"{_words_of(source)} {two_digits(factor * error)}" for source, error in parts)
            value = f"{two_digits(factor * found['error'])}{with_unit(unit)}"
            yield f"{name}: error of the model \u00b1 {value} ({sources})"
    if checks["realisations"]:
        failed = f", {checks['failed']} more failed" if checks["failed"] else ""
        where = f"the greatest in {checks['realisations']} realisations{failed}, {checks['where']}"
        yield f"errors of the model are apart from the intervals of sampling: {where}"
    if checks["errors_unknown"]:
        words = ", ".join(map(_words_of, checks["errors_unknown"]))
        yield f"errors that are not known and not included, with reasons in --json: {words}"


def _words_of(source: str) -> str:
    """A source of errors in words."""
    return WORDS.get(source, source.replace("_", " "))


# The check of a summary from a log, whose shape is written as its values are: `str` for a text, `float` for a finite
# number, `complex` for one that may be NaN or infinite, `int` for a count, None for null, a tuple for any of several, a
# list of the shape of all its items or of each, and a mapping of keys to shapes: `key?` may be absent, `str` and
# `_probability` stand for all other keys. Keys that nothing reads are left out.

PATH = ("samples", "estimate", "half_width", "low", "high")  # columns of the convergence; without ends in older logs
BANDS = ("0.05", "0.50", "0.95", "mean", "at_mean_inputs")  # columns of a history that are drawn


_SHAPES = {
    str: lambda value: isinstance(value, str),
    int: lambda value: isinstance(value, int) and value >= 0,
    float: lambda value: isinstance(value, (int, float)) and math.isfinite(value),
    complex: lambda value: isinstance(value, (int, float)),
    None: lambda value: value is None,
}


def _probability(key) -> bool:
    return key.replace(".", "", 1).isdecimal()


_KNOWN = (float, None)
_INTERVAL = {"value": float, "low": _KNOWN, "high": _KNOWN}
_QUANTITY = {
    **dict.fromkeys(("unit", "method"), str),
    **dict.fromkeys(MOMENTS, _KNOWN),
    **dict.fromkeys((f"{name}_interval" for name in MOMENTS), ([_KNOWN, _KNOWN], None)),
    "quantiles": {_probability: _INTERVAL},
    "unsafe": [str],
    "refused": {str: str},
    "densities": [{**_INTERVAL, "density": _KNOWN}],
    "modality": ({"modes": int, "p_value": _KNOWN}, None),
    "sobol?": {"refused?": str, str: {"first": _INTERVAL, "total": _INTERVAL}},
    "runs?": [{"input": float, "value": float}],
    "interpolation_error?": float,
    "error?": _KNOWN,
    "errors_by_source?": {str: _KNOWN},
}
_SUMMARY = {
    **dict.fromkeys(("study", "scene", "sampler", "stopped_because"), str),
    "samples": int,
    "seed": float,
    "inputs": {str: str},
    "quantities": {str: _QUANTITY},
    "failed": {str: int},
    "doubts": {str: int},
    "notes": [str],
    "convergence": {
        **dict.fromkeys(("quantity", "statistic"), str),
        "probability?": float,
        "samples": [int],
        "estimate": [complex],
        "half_width": [complex],
        "low?": [_KNOWN],
        "high?": [_KNOWN],
    },
    "histories": {str: {"realisations": int, "time_s": [float], **{f"{name}?": [float] for name in BANDS}}},
    "companions?": {"realisations": int, "failed": int, "where": str, "errors_unknown": {str: str}},
    "sweep?": {
        "key": str,
        "unit?": str,
        "at?": _KNOWN,
        "values?": [float],
        "studies": [{"value": float, "quantities": {str: _QUANTITY}}],
    },
}


def check_summary(summary, study: Study, samples: int) -> None:
    """Raises ValueError, naming what is wrong, where a summary is not that of the study with so many samples."""
    wrong = next(_misfits(summary, _SUMMARY, "summary"), None) or next(_contradictions(summary, study, samples), None)
    if wrong:
        raise ValueError(f"{wrong} is not as a study gives it")


def _misfits(value, shape, where: str) -> Iterator[str]:
    """The places in a value that have not the shape."""
    if isinstance(shape, list) and isinstance(value, list):
        if len(shape) > 1 and len(value) != len(shape):
            yield where
        for one, of in zip(value, itertools.cycle(shape)):
            yield from _misfits(one, of, where)
    elif isinstance(shape, dict) and isinstance(value, dict):
        others = next((shape[key] for key in (str, _probability) if key in shape), None)
        for key in (key for key in shape if isinstance(key, str) and not key.endswith("?") and key not in value):
            yield f"{where}.{key}"
        for key, one in value.items():
            if (of := shape.get(key, shape.get(f"{key}?", others))) is not None:
                yield from _misfits(one, of, f"{where}.{key}")
    elif isinstance(shape, tuple):
        tried = [next(_misfits(value, one, where), "") for one in shape]
        yield from tried[:1] if all(tried) else ()
    elif isinstance(shape, (list, dict)) or not _SHAPES[shape](value):
        yield where


def _contradictions(summary, study: Study, samples: int) -> Iterator[str]:
    """The places in a summary of the right shape that do not fit each other, or the study."""
    path, quantities = summary["convergence"], summary["quantities"]
    sweep = summary.get("sweep", {"key": None, "studies": []})
    errors = {"error", "errors_by_source"} if "companions" in summary else set()
    for where, fits in (
        ("samples", summary["samples"] == samples),
        ("quantities", quantities.keys() == {*study.quantities}),
        ("histories", summary["histories"].keys() == {*study.histories}),
        ("failed", not summary["failed"] or samples > 0),
        ("convergence", {len(path["samples"])} == {len(path[key]) for key in PATH if key in path}),
        ("convergence", ("low" in path) == ("high" in path)),
        ("convergence", path["quantity"] in quantities),
        ("convergence", path["statistic"] != "quantile" or "probability" in path),
        ("sweep", sweep["key"] == (study.sweep[0] if study.sweep and "sweep" in summary else None)),
        ("sweep", all(one["quantities"].keys() == quantities.keys() for one in sweep["studies"])),
        ("companions", all(errors <= one.keys() for one in quantities.values())),
        *(
            (f"histories.{name}", {len(one[key]) for key in BANDS if key in one} <= {len(one["time_s"])})
            for name, one in summary["histories"].items()
        ),
    ):
        if not fits:
            yield f"summary.{where}"
