"""The result of a study: every realisation as arrays and as a table, and the summary of each quantity."""

import contextlib
import csv
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import StatisticError, Stopped, StudyError, import_optional
from bearing_twin.base.report import summary_text
from bearing_twin.base.stopping import stop_condition, stop_if_requested
from bearing_twin.base.units import axis_label, readable_unit, two_digits, with_unit
from bearing_twin.run.report import SOURCE_LABELS
from bearing_twin.uq.histories import history_statistics
from bearing_twin.uq.inputs import numeric_keys, quantity_of, value_at
from bearing_twin.uq.propagation import Chaos, Derived
from bearing_twin.uq.realisations import without_numbers
from bearing_twin.uq.sampling import UnitPoints
from bearing_twin.uq.statistics import MOMENTS, Estimate, estimate, modality
from bearing_twin.uq.study import Study

MOST_KINDS = 48  # of reasons or warnings; their bits fit into the digits of a float
FAILED = "failed"
WHY_FAILED = "why the realisation failed; empty where it did not"


class Column(NamedTuple):
    """A column of the table of realisations: its unit is empty where it has none."""

    name: str
    unit: str
    meaning: str
    values: Any


@dataclass(frozen=True, eq=False, repr=False)
class StudyResult:
    """A study that has run.

    Attributes
    ----------
    study : Study
    values : ndarray (n, d)
        Inputs of each realisation in SI, in the order of `study.inputs`.
    quantities : ndarray (n, q)
        Quantities in SI, in the order of `study.quantities`; NaN where the realisation failed. A quantity that needs no
        sampling (method change_of_variable) may have no realisations: n = 0.
    histories : ndarray (n, h, points)
    status : ndarray (n,) of int32
        0, or 1 + the place in `reasons` of why the realisation failed.
    doubtful : ndarray (n,) of int64
        A bit for each sentence of `doubts_met` that holds.
    summary : dict
        Plain data, as `as_dict` gives them.
    """

    study: Study
    values: np.ndarray
    quantities: np.ndarray
    histories: np.ndarray
    status: np.ndarray
    reasons: tuple[str, ...]
    doubtful: np.ndarray
    doubts_met: tuple[str, ...]
    summary: dict

    def __repr__(self) -> str:
        failed = int(np.count_nonzero(self.status))
        title = f"{self.study.name}: {len(self.quantities)} realisations, {failed} of them failed"
        units = self.study.quantity_units
        medians = {
            f"{name} [{units[name]}]": [float(one) for one in np.quantile(column, (0.05, 0.5, 0.95))]
            for name, column in zip(self.study.quantities, self.quantities[self.status == 0].T, strict=True)
            if len(column)
        }
        return summary_text(f"{title}; quantiles 5, 50, 95 %", medians)

    def as_dict(self) -> dict:
        """The summary as plain data, as `--json` gives it; statistics that do not exist are null, with the reason."""
        return dict(self.summary)

    def table(self) -> list[Column]:
        """The table of realisations: inputs and quantities [SI], and `failed`, the reasons.

        An input and a quantity of the same name get `input.` and `quantity.` in front.
        """
        kind, keys = self.study.kind, numeric_keys(self.study.kind)
        inputs, quantities = [one.key for one in self.study.inputs], self.study.quantities
        both = {*inputs} & {*quantities}
        found = [
            Column(f"input.{key}" if key in both else key, keys[key].unit, keys[key].help, column)
            for key, column in zip(inputs, self.values.T, strict=True)
        ]
        for name, column in zip(quantities, self.quantities.T, strict=True):
            row = quantity_of(kind, name)
            found.append(Column(f"quantity.{name}" if name in both else name, row.unit, row.meaning, column))
        reasons = ["" if code == 0 else self.reasons[code - 1] for code in self.status.tolist()]
        return [*found, Column(FAILED, "", WHY_FAILED, reasons)]

    def columns(self) -> dict[str, Any]:
        """The table by column: arrays (n,) of inputs and quantities [SI], and `failed`, a list of text."""
        return {one.name: one.values for one in self.table()}

    def to_csv(self, path: str | PathLike) -> Path:
        """Writes the table of realisations to a new CSV file: a line of names with units, then a line each.

        Numbers are written in full. Raises StudyError where the file exists or cannot be written.
        """
        table, path = self.table(), Path(path)
        try:
            with path.open("x", newline="", encoding="utf-8") as stream:
                lines = csv.writer(stream)
                lines.writerow(f"{one.name} [{one.unit}]" if one.unit else one.name for one in table)
                rows = (getattr(one.values, "tolist", lambda one=one: one.values)() for one in table)
                lines.writerows(zip(*rows, strict=True))
        except FileExistsError:
            raise StudyError(f"{path} exists and is not overwritten; give another path") from None
        except (OSError, ValueError) as error:
            why = getattr(error, "strerror", None) or error
            raise StudyError(f"{path} cannot be written ({why}); give another path") from error
        return path

    def to_dataframe(self) -> Any:
        """The table of realisations as a pandas DataFrame; `attrs` has `units` and `meanings` by column.

        Raises BearingTwinError without pandas (extra `export`).
        """
        table, frame = self.table(), import_optional("pandas", "export").DataFrame(self.columns())
        frame.index.name = "realisation"
        frame.attrs["units"] = {one.name: one.unit for one in table if one.unit}
        frame.attrs["meanings"] = {one.name: one.meaning for one in table}
        return frame

    def sample(self, quantity: str) -> np.ndarray:
        """The quantity (n,) of every realisation, NaN where it failed."""
        return self.quantities[:, self.study.quantities.index(quantity)]

    def history(self, channel: str) -> np.ndarray:
        """The histories (n, points) of a channel, at `summary["histories"][channel]["time_s"]`."""
        return self.histories[:, self.study.histories.index(channel)]

    def history_unit(self, channel: str) -> str:
        """Unit of the histories of a channel."""
        scene = self.study.scene_at(self.study.medians)
        return next(one.unit for one in scene.channels if one.name == channel)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Warnings about the result, one sentence each."""
        return tuple(warnings_of(self.summary))


def warnings_of(summary: Mapping[str, Any]) -> list[str]:
    """Warnings in the summary of a study, one sentence each; it may have come as JSON."""
    count, failed = summary["samples"], sum(summary["failed"].values())
    sentences = [f"{many} of {count} realisations: {what}" for what, many in summary["doubts"].items()]
    if failed and failed == count:
        reason = max(summary["failed"], key=summary["failed"].get)
        sentences.append(f"all {count} realisations failed, so that there are no statistics: {reason}")
    elif failed:
        sentences.append(f"{failed} of {count} realisations failed; the statistics are those of the others")
    if summary["stopped_because"].startswith("failed"):
        sentences.append(summary["stopped_because"])
    return [*sentences, *map(str, summary["notes"])]


def size_of(found: Mapping[str, Any]) -> float:
    """The size of a quantity of a summary, which selects its unit: of mean and deviation, or else of quantiles."""
    moments = [found[key] for key in ("mean", "std") if found[key] is not None]
    return max(map(abs, moments or [one["value"] for one in found["quantiles"].values()]), default=0.0)


def shares_of(found: Mapping[str, Any]) -> dict[str, Mapping]:
    """Sobol indices of a quantity of a summary by input; empty where there are none."""
    return {key: one for key, one in found.get("sobol", {}).items() if key != "refused"}


def refusals(quantities: Mapping[str, Mapping]) -> Iterator[tuple[list[str], str]]:
    """(quantities, sentence) of statistics that are refused, once for all of a summary that share the reason."""
    sentences = {}
    for name, one in quantities.items():
        by_reason: dict[str, list[str]] = {}
        for statistic, reason in one["refused"].items():
            by_reason.setdefault(reason, []).append(statistic)
        sentences[name] = [f"no {in_words(which, 'or')}, because {reason}" for reason, which in by_reason.items()]
    return shared(sentences)


def shared(sentences: Mapping[str, Iterable[str]]) -> Iterator[tuple[list[str], str]]:
    """(names, sentence) from the sentences about each name: once for all names that share a sentence."""
    found: dict[str, list[str]] = {}
    for name, about in sentences.items():
        for sentence in about:
            found.setdefault(sentence, []).append(name)
    yield from ((names, sentence) for sentence, names in found.items())


def in_words(names: Iterable[str], last: str = "and") -> str:
    """Names as a list in words: `mean, std and skewness`."""
    *first, end = names
    return f"{', '.join(first)} {last} {end}" if first else end


def finite(value: float) -> float | None:
    """The end of an interval as plain data: None where it is open."""
    return value if math.isfinite(value) else None


class Tally:
    """Sentences about realisations by kind: those that differ in numbers alone are one, shown as it first came."""

    def __init__(self, sentences: Iterable[str] = ()):
        self.sentences = list(sentences)
        self._places = {without_numbers(one): place for place, one in enumerate(self.sentences)}

    def place(self, sentence: str) -> int:
        """The number of the sentence's kind, a new one if need be; beyond MOST_KINDS all share the last."""
        kind = without_numbers(sentence)
        if kind not in self._places:
            if len(self.sentences) == MOST_KINDS:
                return MOST_KINDS - 1
            self._places[kind] = len(self.sentences)
            self.sentences.append(sentence)
        return self._places[kind]

    def codes(self, count: int, failures: dict[int, str]) -> np.ndarray:
        """(count,) int32: 0, or 1 + the kind of a row's sentence."""
        codes = np.zeros(count, np.int32)
        for row in sorted(failures):
            codes[row] = 1 + self.place(failures[row])
        return codes

    def bits(self, count: int, doubts: dict[int, tuple[str, ...]]) -> np.ndarray:
        """(count,) int64: one bit for each kind among a row's sentences."""
        bits = np.zeros(count, np.int64)
        for row in sorted(doubts):
            for sentence in doubts[row]:
                bits[row] |= 1 << self.place(sentence)
        return bits


def sweep_head(study: Study) -> dict[str, Any]:
    """Key, unit and values [SI] of a sweep, and the value `at` that the key has in the scene of the study."""
    key, values = study.sweep
    at = value_at(study.scene, key)
    at = float(at) if isinstance(at, (int, float)) else None
    return {"key": key, "unit": numeric_keys(study.kind)[key].unit, "at": at, "values": list(values)}


def sweep_of(result: StudyResult) -> dict[str, Any] | None:
    """The sweep of a result, also of one whose log an earlier version wrote; None without one."""
    summary = result.summary
    return {**sweep_head(result.study), **summary["sweep"]} if "sweep" in summary else None


class SweepInWords:
    """A sweep for people: `key`, `label` of an axis, and the `values` that have a study.

    `shown(unit, size)` gives (unit, factor) in which values of that size are shown. `at` is the key with its value in
    the scene, empty where a log does not have it; `ended` is empty where every value has its study.
    """

    def __init__(self, sweep: Mapping[str, Any], shown: Callable = readable_unit):
        values, at = [one["value"] for one in sweep["studies"]], sweep.get("at")
        unit, factor = shown(sweep.get("unit", "1"), max(map(abs, [*values, at or 0.0])))
        self.key, self.label = sweep["key"], axis_label(sweep["key"], unit)
        self.values = [factor * one for one in values]
        self.at = "" if at is None else f"{self.key} = {factor * at:.6g}{with_unit(unit)}"
        requested = len(sweep.get("values", values))
        left = f"{requested - len(values)} of the {requested} values of its sweep" if values else "its sweep"
        self.ended = f"the study ended before {left}" if requested > len(values) else ""


# The summary of a study as plain data: statistics of quantities and histories, failures, warnings and notes.

PROBABILITIES = (0.05, 0.25, 0.5, 0.75, 0.95)
SURROGATE_POINTS = 2**14  # of a polynomial chaos
BANDS = ("0.05", "0.50", "0.95", "mean", "at_mean_inputs")  # columns of a history that are drawn


def _statistics(of: Callable, modes: Callable | None, missing: Mapping[str, str]) -> dict[str, Any]:
    """Statistics of a quantity as plain data.

    `of(statistic)` is the Estimate of a moment by name or of a quantile by its probability, `modes()` plain data; both
    may raise StatisticError. `missing` names moments that do not exist, with the reason.
    """
    refused, result = dict(missing), {"unsafe": []}

    def tried(name: str, work: Callable, *given):
        try:
            return None if name in refused else work(*given)
        except StatisticError as error:
            refused[name] = str(error)
            return None

    for name in MOMENTS:
        found = tried(name, of, name)
        result[name], result[f"{name}_interval"] = found and found.value, found and [*map(finite, found[1:3])]
        result["unsafe"] += [name] if found and not found.safe else []
    quantiles = {p: tried(f"quantile {p:g}", of, p) for p in PROBABILITIES}
    result["quantiles"] = {f"{p:.2f}": _interval(*found[:3]) for p, found in quantiles.items() if found}
    result["modality"] = tried("modality", modes) if modes else None
    return {**result, "refused": refused}


def _of_sample(sample: np.ndarray, replicates: int, seed: int) -> tuple[Callable, Callable]:
    """Estimates of a sample and its modes, as `_statistics` takes them."""
    sample = np.ascontiguousarray(sample)
    ordered = np.sort(sample)  # once, where it does not matter whose replicate a point is

    def of(statistic):
        unordered = statistic in MOMENTS or replicates > 1
        return estimate(sample if unordered else ordered, statistic, replicates)

    def modes():
        found = modality(ordered, seed)
        return {"modes": found.modes, "p_value": found.p_value, "positions": list(found.positions)}

    return of, modes


def _of_derived(derived: Derived) -> tuple[Callable, Callable]:
    """The same of an exact distribution, whose intervals have no width."""

    def of(statistic):
        value = float(getattr(derived, statistic) if statistic in MOMENTS else derived.quantile(statistic))
        return Estimate(value, value, value)

    return of, lambda: {"modes": derived.modes, "p_value": None}


def _of_chaos(study: Study, chaos: Chaos) -> tuple[Callable, Callable]:
    """The same of an expansion: mean and deviation exactly, the rest from SURROGATE_POINTS of it.

    Intervals are those of this sampling, wider by the root mean square error of the expansion.
    """
    points = UnitPoints("sobol", study.joint.dimension, study.settings.seed, SURROGATE_POINTS)
    sampled, modes = _of_sample(chaos.predict(points.chunk(0, points.samples)), points.replicates, study.settings.seed)
    miss, exact = chaos.error * chaos.std, {"mean": chaos.mean, "std": chaos.std}

    def of(statistic):
        found = Estimate(*[exact[statistic]] * 3) if statistic in exact else sampled(statistic)
        return found._replace(low=found.low - miss, high=found.high + miss)

    return of, modes


def _interval(value, low=math.inf, high=math.inf) -> dict[str, Any]:
    return {"value": float(value), "low": finite(float(low)), "high": finite(float(high))}


def _of_quantity(result: StudyResult, name: str, found, missing, drawn, modes: bool) -> dict[str, Any]:
    """One quantity: by its distribution or expansion `found`, or by the sample where that is None."""
    study, rule, method, more = result.study, drawn.rule, "change_of_variable", {}
    if isinstance(found, Derived):
        of, count_modes = _of_derived(found)
    elif isinstance(found, Chaos):
        method, (of, count_modes) = "chaos", _of_chaos(study, found)
        more = {"degree": found.degree, "validation_error": found.error}
        if study.joint.independent:
            pairs = zip(study.joint.keys, found.first, found.total, strict=True)
            more["sobol"] = {key: {"first": _interval(one), "total": _interval(total)} for key, one, total in pairs}
    else:
        method = "ensemble"
        of, count_modes = _of_sample(result.sample(name), drawn.points.replicates, study.settings.seed)
    one = _statistics(of, count_modes if modes or method == "change_of_variable" else None, missing)
    statistic, half_width = rule.of if name == rule.quantity else "mean", None
    if statistic not in one["refused"]:
        with contextlib.suppress(StatisticError):
            half_width = finite(of(statistic).half_width)
    return {"method": method, **one, "half_width": half_width, **more}


def sobol_summary(indices: Mapping[str, Mapping[str, Estimate]]) -> dict[str, Any]:
    """First and total Sobol indices of a quantity by input as plain data."""
    return {
        key: {order: _interval(*one[:3]) | {"unsafe": not one.safe} for order, one in orders.items()}
        for key, orders in indices.items()
    }


def summary_of(ends: Callable[[], bool], *given) -> dict:
    """The plain data of a result, without seconds; `given` is what `_summary` takes.

    Once `ends()` is true modes and statistics of histories are left out, which a note says.
    """
    try:
        with stop_condition(ends):
            stop_if_requested()
            return _summary(*given, whole=True)
    except Stopped:
        with stop_condition(lambda: False):
            return _summary(*given, whole=False)


def _summary(result: StudyResult, without_sampling: Mapping, missing: Mapping, drawn, at_mean, model, *, whole: bool):
    """The summary.

    Parameters
    ----------
    without_sampling : dict
        The distribution or expansion of quantities that need no sample.
    missing : dict
        Moments that do not exist, by quantity, each with the reason.
    drawn : run.Drawn
        The ensemble.
    at_mean : Realised
        The realisation at the mean inputs, or none.
    model : run.ModelErrors
    """
    study, settings, quantities = result.study, result.study.settings, {}
    modes = settings.modality == "yes" and whole
    for column, (name, unit) in enumerate(study.quantity_units.items()):
        found = without_sampling.get(name)
        one = _of_quantity(result, name, found, missing.get(name, {}), drawn, modes)
        one["at_mean_inputs"] = finite(at_mean.quantities[0, column]) if len(at_mean.quantities) else None
        quantities[name] = {"unit": unit, **one} | model.for_quantity(name)
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
        "notes": [*drawn.notes, *model.notes, *([] if whole else [cut])],
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
    histories, inputs, bands = result.history(channel), result.values, {}
    kept = np.isfinite(histories).all(axis=1)
    if not kept.all():
        histories, inputs = histories[kept], inputs[kept]
    if len(histories) > 1 and whole:
        bands = history_statistics(histories, inputs, result.study.joint.keys)
        bands["autocorrelation_time_s"] = instants[bands.pop("rows")]
    if len(at_mean):
        bands["at_mean_inputs"] = at_mean[0]
    head = {"realisations": len(histories), "time_s": instants.tolist()}
    return head | {name: one.tolist() for name, one in bands.items()}


def model_error_sentences(summary: Mapping[str, Any], shown: Callable = readable_unit) -> Iterator[str]:
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
    return SOURCE_LABELS.get(source, source.replace("_", " "))
