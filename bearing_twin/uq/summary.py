"""The summary of a study as plain data: statistics of quantities and histories, failures, warnings and notes.

A summary that comes from a log is checked by `check_summary`, whole, before it is used.
"""

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import BearingTwinError, StatisticError, Stopped
from bearing_twin.base.stopping import heeding, look
from bearing_twin.base.units import two_digits, unit_for_people, with_unit
from bearing_twin.run.simulation import simulate
from bearing_twin.uq.histories import Histories, narrowing
from bearing_twin.uq.modality import modality, mode_numbers
from bearing_twin.uq.propagation import Chaos, Derived, Interpolated
from bearing_twin.uq.realisations import mean_inputs
from bearing_twin.uq.result import OUT_OF_TIME, StudyResult, finite, size_of
from bearing_twin.uq.sampling import UnitPoints
from bearing_twin.uq.statistics import MOMENTS, MORE, Estimate, densities_at, estimate, half_width
from bearing_twin.uq.study import Study

PROBABILITIES = (0.05, 0.25, 0.5, 0.75, 0.95)
GRID = 2001  # points of a density whose modes are counted
SURROGATE_POINTS = 2**14  # of a polynomial chaos
CORRELATED = 41  # instants of the autocorrelation in a summary
POOR = 0.01  # error of an interpolant that is reported
AT_CANCEL = 8192  # numbers of a quantity and its histories whose statistics a cancelled study makes: 0.1 s
INSTANT = 0.125  # cost of an instant of a history, over that of a sample, in these


def summary_of_sample(
    sample: np.ndarray,
    missing: dict[str, str],
    replicates: int,
    seed: int,
    modes: bool,
    densities: Sequence[float] = (),
) -> dict:
    """Mean, deviation, skewness and quantiles of a quantity with 95 % intervals, its modes, and its density at values.

    `missing` names moments that do not exist, with the reason; they are None and their reason is in `refused`.
    `unsafe` names those whose interval is too narrow: a few points far out decide, and more of them may be missing.
    """
    result: dict[str, Any] = {"unsafe": []}
    refused, sample = dict(missing), np.ascontiguousarray(sample)

    def tried(name: str, of: Callable, *arguments, **named):
        try:
            return None if name in refused else of(*arguments, **named)
        except StatisticError as error:
            refused[name] = str(error)
            return None

    for name in MOMENTS:
        found = tried(name, estimate, sample, name, replicates=replicates)
        result[name], result[f"{name}_interval"] = found and found.value, found and [*map(finite, found[1:3])]
        result["unsafe"] += [name] if found and not found.safe else []
    result["quantiles"], ordered = {}, np.sort(sample)  # once, where it does not matter whose replicate a point is
    for p in PROBABILITIES:
        found = tried(f"quantile {p:g}", estimate, ordered if replicates == 1 else sample, p, replicates=replicates)
        if found:
            result["quantiles"][f"{p:.2f}"] = _interval(*found[:3])
    found = tried("modality", modality, ordered, seed) if modes else None
    result["modality"] = found and {
        "modes": found.modes, "p_value": found.p_value, "positions": list(found.positions)
    }  # fmt: skip
    found = tried("densities", densities_at, sample, densities) if densities else None
    result["densities"] = [_density(at, one) for at, one in zip(densities, found or (), strict=False)]
    return {**result, "refused": refused}


def summary_of_derived(derived: Derived, densities: Sequence[float] = ()) -> dict:
    """The same of an exact distribution: intervals have no width, and modes are those of the density."""
    refused, result = {}, {"unsafe": []}
    for name in MOMENTS:
        try:
            value = float(getattr(derived, name))
            result[name], result[f"{name}_interval"] = value, [value, value]
        except StatisticError as error:
            result[name], result[f"{name}_interval"] = None, None
            refused[name] = str(error)
    values = {f"{p:.2f}": float(derived.quantile(p)) for p in PROBABILITIES}
    result["quantiles"] = {name: _interval(value, value, value) for name, value in values.items()}
    low, high = derived.quantile(0.0005), derived.quantile(0.9995)
    result["modality"] = {"modes": int(mode_numbers(derived.pdf(np.linspace(low, high, GRID)))), "p_value": None}
    heights = derived.pdf(np.array(densities, float)).tolist()
    result["densities"] = [_density(at, Estimate(*[one] * 3, "")) for at, one in zip(densities, heights, strict=True)]
    return {**result, "refused": refused}


def summary_of_interpolated(found: Interpolated, missing: dict[str, str], densities: Sequence[float] = ()) -> dict:
    """As `summary_of_derived`; each interval is the change by the last doubling of the runs, to either side."""
    result, before = (summary_of_derived(one, densities) for one in (found.derived, found.before))
    for name in MOMENTS:
        result[f"{name}_interval"] = None
        if name in missing:
            result[name] = None
        elif None not in (result[name], before[name]):
            result[f"{name}_interval"] = _around(result[name], before[name])
    result["refused"] |= missing
    for key, quantile in result["quantiles"].items():
        quantile["low"], quantile["high"] = _around(quantile["value"], before["quantiles"][key]["value"])
    for one, other in zip(result["densities"], before["densities"], strict=True):
        one["low"], one["high"] = _around(one["density"], other["density"])
    low, high = result["mean_interval"] or (0.0, None)
    return {
        **result,
        "half_width": None if high is None else 0.5 * (high - low),
        "interpolation_error": found.error,
        "beyond_the_runs": found.left_out,
        "runs": [{"input": x, "value": y} for x, y in zip(found.at.tolist(), found.values.tolist(), strict=True)],
    }


def summary_of_chaos(study: Study, chaos: Chaos, missing: dict[str, str], modes: bool, densities=()) -> dict:
    """As `summary_of_sample`, from an expansion: mean and deviation exactly, the rest from SURROGATE_POINTS of it.

    The intervals of mean and deviation, and `half_width`, are the root mean square error of the expansion at fresh
    points; those of the rest have the sampling of the expansion alone.
    """
    settings = study.settings
    points = UnitPoints("sobol", study.joint.dimension, settings.seed, SURROGATE_POINTS)
    sample = chaos.predict(points.chunk(0, points.samples))
    found = summary_of_sample(sample, missing, points.replicates, settings.seed, modes, densities)
    miss = chaos.error * chaos.std
    for name in {"mean", "std"} - {*missing}:
        value = getattr(chaos, name)
        found |= {name: value, f"{name}_interval": [value - miss, value + miss]}
    found |= {"half_width": miss, "degree": chaos.degree, "validation_error": chaos.error}
    if study.joint.independent:
        pairs = zip(study.joint.keys, chaos.first, chaos.total, strict=True)
        found["sobol"] = {key: {"first": _interval(first), "total": _interval(total)} for key, first, total in pairs}
    return found


def _around(value, before):
    return [value - abs(value - before), value + abs(value - before)]


def _density(at, one: Estimate) -> dict:
    return {"value": float(at), "density": one.value, "low": one.low, "high": one.high}


def _interval(value, low=math.inf, high=math.inf) -> dict:
    return {"value": float(value), "low": finite(float(low)), "high": finite(float(high))}


def sobol_summary(keys: Sequence[str], indices) -> dict:
    """First and total Sobol indices of a quantity by input, with intervals, from `statistics.SobolIndices`."""
    return {
        key: {
            order: _interval(value[place], *ends[place]) | {"unsafe": not bool(safe[place])}
            for order, (value, ends, safe) in {"first": indices[:3], "total": indices[3:6]}.items()
        }
        for place, key in enumerate(keys)
    }


def summary_of(result: StudyResult, missing: dict, task, without_sampling: dict, drawn, beside, asked) -> dict:
    """The plain data of a result, without seconds.

    Parameters
    ----------
    missing : dict
        Moments that do not exist, by quantity, each with the reason.
    without_sampling : dict
        The distribution or expansion of quantities that need no sample.
    drawn : run.Drawn
        The ensemble.
    beside : (Realised, ModelErrors)
        The realisation at the mean inputs, or none, and the errors of the model.
    asked : function
        Once it is true the rest is made of the first samples without counting modes, which a note says.
    """
    try:
        with heeding(asked):
            look()
            found, cut = _summary(result, missing, task, without_sampling, drawn, beside, False), []
    except Stopped:
        with heeding(lambda: False):
            found = _summary(_first(result), missing, task, without_sampling, drawn, beside, True)
        cut = [
            f"cancelled: statistics are those of the first {len(_first(result).status)} of {len(result.status)} "
            "samples, and modes are not counted; go on from the log for all"
        ]
    found["samples"] = len(result.status)
    found["failed"] = {text: int(np.sum(result.status == 1 + place)) for place, text in enumerate(result.reasons)}
    found["failed_share"] = float(np.mean(result.status > 0)) if len(result.status) else 0.0
    found["doubts"] = {text: int(np.sum(result.doubtful >> k & 1)) for k, text in enumerate(result.doubts_met)}
    found["notes"] = [*found["notes"], *_flags_at_mean(result.study, task, asked), *cut]
    return found


def _summary(result: StudyResult, missing, task, without_sampling, drawn, beside, hurried: bool) -> dict:
    study, settings = result.study, result.study.settings
    (at_mean, model), quantities = beside, {}
    modes = settings.modality == "yes" and not hurried
    for column, (name, unit) in enumerate(result.quantity_units.items()):
        densities, found, refused = study.densities.get(name, ()), without_sampling.get(name), missing.get(name, {})
        if isinstance(found, Derived):
            one = {"method": "change_of_variable", **summary_of_derived(found, densities), "half_width": 0.0}
        elif isinstance(found, Interpolated):
            one = {"method": "change_of_variable", **summary_of_interpolated(found, refused, densities)}
        elif isinstance(found, Chaos):
            one = {"method": "chaos", **summary_of_chaos(study, found, refused, modes, densities)}
        else:
            one = {"method": "ensemble", **_of_sample(result, refused, name, drawn, modes)}
        value = at_mean.quantities[0, column] if len(at_mean.quantities) else np.nan
        one["at_mean_inputs"] = float(value) if np.isfinite(value) else None
        quantities[name] = {"unit": unit, **one} | model.for_quantity(name)
    poor = [
        f"{name}: the polynomial misses runs by {one.error:.2g} of the deviation; the method ensemble needs none"
        for name, one in without_sampling.items()
        if isinstance(one, Interpolated) and one.error > POOR
    ]
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
            channel: _of_history(result, channel, task, at_mean.histories[:, place], hurried)
            for place, channel in enumerate(study.histories)
        },
        "notes": [*drawn.notes, *poor, *model.notes],
    }


def _first(result: StudyResult) -> StudyResult:
    """The result with its first samples only, a power of two of them, whose statistics take a tenth of a second."""
    room = AT_CANCEL / (1.0 + INSTANT * len(result.study.histories) * result.study.settings.history_points)
    if len(result.status) <= room:
        return result
    first = slice(1 << max(4, int(np.log2(room))))
    columns = ("values", "quantities", "histories", "status", "doubtful")
    return dataclasses.replace(result, **{name: getattr(result, name)[first] for name in columns})


def _of_sample(result, missing, name, drawn, modes) -> dict:
    settings, rule, replicates = result.study.settings, drawn.rule, drawn.points.replicates
    sample = result.sample(name)
    found = summary_of_sample(
        sample, missing, replicates, settings.seed, modes, result.study.densities.get(name, ())
    )  # fmt: skip
    if drawn.because.startswith(OUT_OF_TIME):  # more were requested
        found["refused"] = {key: why.replace(MORE, "raise time_limit") for key, why in found["refused"].items()}
    statistic = rule.asked if name == rule.quantity else "mean"
    width = np.inf if statistic in missing else half_width(sample, statistic, replicates=replicates)
    return {**found, "half_width": finite(width)}


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


def _of_history(result, channel, task, at_mean, hurried) -> dict:
    """Bands of a history over the realisations that did not fail, and the run `at_mean` inputs (1 or 0, t)."""
    found, bands, more = history_statistics(result, channel, task.instants), {}, {}
    if found.count > 1:
        bands = {"mean": found.mean, "std": found.std, "skewness": found.skewness}
        bands |= dict(zip(("0.05", "0.50", "0.95"), found.quantiles(), strict=True))
        for key, row in zip(result.study.joint.keys, found.input_correlation(), strict=True):
            bands[f"correlation with {key}"] = np.nan_to_num(row)
        rows = np.arange(0, len(found.times), max(1, -(-len(found.times) // CORRELATED)))
        bands["autocorrelation_time_s"] = found.times[rows]
        bands["autocorrelation"] = np.nan_to_num(found.autocorrelation()[np.ix_(rows, rows)])
        more = {} if hurried else _narrowing(found, result.study)
    if len(at_mean):
        bands["at_mean_inputs"] = at_mean[0]
    head = {"realisations": found.count, "time_s": task.instants.tolist()}
    return head | {name: one.tolist() for name, one in bands.items()} | more


def _narrowing(histories, study) -> dict:
    """Where the histories come together after their peak; nothing where they do not."""
    try:
        found = narrowing(histories.times, histories.whole, study.settings.seed, histories.inputs)
    except StatisticError:
        return {}
    signs = {
        key: {
            "time_s": one.time,
            "later_s": one.later,
            "interval_s": [one.low, one.high],
            "by_slopes_s": one.by_slopes,
        }
        for key, one in zip(study.joint.keys, found.signs, strict=True)
        if one is not None
    }
    return {
        "least_spread": {
            "time_s": found.time, "interval_s": [found.low, found.high], "mean": found.mean, "std": found.std,
            "modes": found.modes, "p_value": found.p_value, "sign_changes": signs,
        }
    }  # fmt: skip


def history_statistics(result: StudyResult, channel: str, instants: np.ndarray) -> Histories:
    """Statistics of one channel over time, among them its autocorrelation and its density."""
    return Histories(instants, result.history(channel), result.values)


def _flags_at_mean(study, task, asked) -> list[str]:
    """Warnings about the scene at its mean inputs, where closed forms give none, unless `asked()`."""
    if not task.closed or asked():
        return []
    try:
        run = simulate(study.scene_at(mean_inputs(study)[0]))
        for _ in run.blocks():
            if asked():
                return []
    except BearingTwinError as error:
        return [f"at the mean inputs there is no run: {error}"]
    return [f"at the mean inputs {flag}" for flag in run.report.flags]


def told_of_model(summary: Mapping[str, Any], shown: Callable = unit_for_people) -> Iterator[str]:
    """Sentences of a study's summary: each quantity's error of the model, how it was found, what is not in it.

    `shown(unit, size)` gives (unit, factor) in which values of that size are told.
    """
    told = summary.get("companions")
    if told is None:  # a log of an earlier version
        return
    for name, found in summary["quantities"].items():
        if found["error"] is not None:
            unit, factor = shown(found["unit"], size_of(found) or found["error"])
            parts = sorted(found["errors_by_source"].items(), key=lambda one: -one[1])
            sources = ", ".join(f"{source.replace('_', ' ')} {two_digits(factor * error)}" for source, error in parts)
            value = f"{two_digits(factor * found['error'])}{with_unit(unit)}"
            yield f"{name}: error of the model \u00b1 {value} ({sources}), apart from what sampling leaves open"
    if told["realisations"]:
        failed = f", {told['failed']} more failed" if told["failed"] else ""
        yield f"errors of the model: the greatest in {told['realisations']} realisations{failed}, {told['where']}"
    if told["errors_unknown"]:
        words = ", ".join(source.replace("_", " ") for source in told["errors_unknown"])
        yield f"not in the errors of the model, as --json says one by one: {words}"


class Maybe(NamedTuple):
    """The shape of what may be left out."""

    shape: Any


def _text(value) -> bool:
    return isinstance(value, str)


def _whole(value) -> bool:
    return isinstance(value, int) and value >= 0


def _number(value) -> bool:
    return isinstance(value, (int, float)) and math.isfinite(value)


def _known(value) -> bool:
    return value is None or _number(value)


def _measured(value) -> bool:
    """What is not known yet is NaN, a half-width without a bound infinite."""
    return isinstance(value, (int, float))


def _pair(value) -> bool:
    return value is None or (isinstance(value, list) and len(value) == 2 and all(map(_known, value)))


def _size(value) -> bool:
    return _number(value) and value >= 0


def _error(value) -> bool:
    return value is None or _size(value)


def _modality(value) -> bool:
    return value is None or not any(_misfits(value, {"modes": _whole, "p_value": _known}, "modality"))


def _probability(value) -> bool:
    return value.replace(".", "", 1).isdecimal()


PATH = ("samples", "estimate", "half_width", "low", "high")  # columns of the convergence; without ends in older logs
BANDS = ("0.05", "0.50", "0.95", "mean", "at_mean_inputs")  # columns of a history that are drawn
# A shape is a function that is true of a value, the [shape] of the items of a list, or a mapping of keys to shapes, in
# which a function stands for all other keys. Keys that nothing reads are left out.
_INTERVAL = {"value": _number, "low": _known, "high": _known}
_QUANTITY = {
    "unit": _text,
    "method": _text,
    **dict.fromkeys(MOMENTS, _known),
    **{f"{name}_interval": _pair for name in MOMENTS},
    "quantiles": {_probability: _INTERVAL},
    "unsafe": [_text],
    "refused": {_text: _text},
    "densities": [{**_INTERVAL, "density": _known}],
    "modality": _modality,
    "sobol": Maybe({"refused": Maybe(_text), _text: {"first": _INTERVAL, "total": _INTERVAL}}),
    "runs": Maybe([{"input": _number, "value": _number}]),
    "interpolation_error": Maybe(_number),
    "error": Maybe(_error),
    "errors_by_source": Maybe({_text: _size}),
}
_SUMMARY = {
    **dict.fromkeys(("study", "scene", "sampler", "stopped_because"), _text),
    "samples": _whole,
    "seed": _number,
    "inputs": {_text: _text},
    "quantities": {_text: _QUANTITY},
    "failed": {_text: _whole},
    "doubts": {_text: _whole},
    "notes": [_text],
    "convergence": {
        "quantity": _text,
        "statistic": _text,
        "probability": Maybe(_number),
        "samples": [_whole],
        "estimate": [_measured],
        "half_width": [_measured],
        "low": Maybe([_known]),
        "high": Maybe([_known]),
    },
    "histories": {_text: {"realisations": _whole, "time_s": [_number], **dict.fromkeys(BANDS, Maybe([_number]))}},
    "companions": Maybe({"realisations": _whole, "failed": _whole, "where": _text, "errors_unknown": {_text: _text}}),
    "sweep": Maybe(
        {
            "key": _text,
            "unit": Maybe(_text),
            "at": Maybe(_known),
            "values": Maybe([_number]),
            "studies": [{"value": _number, "quantities": {_text: _QUANTITY}}],
        }
    ),
}


def check_summary(summary, study: Study, samples: int) -> None:
    """Raises ValueError, naming what is wrong, where a summary is not that of the study with so many samples."""
    wrong = next(_misfits(summary, _SUMMARY, "summary"), None) or next(_contradictions(summary, study, samples), None)
    if wrong:
        raise ValueError(f"{wrong} is not as a study gives it")


def _misfits(value, shape, where: str) -> Iterator[str]:
    """The places in a value that have not the shape."""
    if callable(shape):
        if not shape(value):
            yield where
    elif not isinstance(value, type(shape)):
        yield where
    elif isinstance(shape, list):
        for one in value:
            yield from _misfits(one, shape[0], where)
    else:
        named = {key: one for key, one in shape.items() if _text(key)}
        others = next((one for key, one in shape.items() if not _text(key)), None)
        yield from (where for key, one in named.items() if key not in value and not isinstance(one, Maybe))
        for key, one in value.items():
            of = named.get(key, others)
            yield from _misfits(one, getattr(of, "shape", of), f"{where}.{key}") if of else ()


def _contradictions(summary, study: Study, samples: int) -> Iterator[str]:
    """The places in a summary of the right shape that do not fit each other, or the study."""
    path, quantities = summary["convergence"], summary["quantities"]
    sweep = summary.get("sweep", {"key": None, "studies": []})
    for where, fits in (
        ("summary.samples", summary["samples"] == samples),
        ("summary.quantities", quantities.keys() == {*study.quantities}),
        ("summary.histories", summary["histories"].keys() == {*study.histories}),
        ("summary.failed", not summary["failed"] or samples > 0),
        ("summary.convergence", {len(path["samples"])} == {len(path[key]) for key in PATH if key in path}),
        ("summary.convergence", ("low" in path) == ("high" in path)),
        ("summary.convergence", path["quantity"] in quantities),
        ("summary.convergence", path["statistic"] != "quantile" or "probability" in path),
        ("summary.sweep", sweep["key"] == (study.sweep[0] if study.sweep and "sweep" in summary else None)),
    ):
        if not fits:
            yield where
    yield from ("summary.sweep" for one in sweep["studies"] if one["quantities"].keys() != quantities.keys())
    told = {"error", "errors_by_source"} if "companions" in summary else set()
    yield from ("summary.companions" for one in quantities.values() if not told <= one.keys())
    for name, one in summary["histories"].items():
        yield from (
            f"summary.histories.{name}" for key in BANDS if len(one.get(key, one["time_s"])) != len(one["time_s"])
        )
