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
from bearing_twin.uq.inputs import numeric_keys, quantity_of, value_at
from bearing_twin.uq.propagation import Chaos, Derived
from bearing_twin.uq.realisations import without_numbers
from bearing_twin.uq.sampling import UnitPoints
from bearing_twin.uq.statistics import MOMENTS, Estimate, estimate, history_statistics, modality
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
        0, or 1 + the index in `reasons` of why the realisation failed.
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
            f"{name} [{units[name]}]": [float(quantile) for quantile in np.quantile(column, (0.05, 0.5, 0.95))]
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
        inputs, quantities = [source.key for source in self.study.inputs], self.study.quantities
        ambiguous = {*inputs} & {*quantities}
        columns = [
            Column(f"input.{key}" if key in ambiguous else key, keys[key].unit, keys[key].help, column)
            for key, column in zip(inputs, self.values.T, strict=True)
        ]
        for name, column in zip(quantities, self.quantities.T, strict=True):
            row = quantity_of(kind, name)
            columns.append(Column(f"quantity.{name}" if name in ambiguous else name, row.unit, row.meaning, column))
        reasons = ["" if code == 0 else self.reasons[code - 1] for code in self.status.tolist()]
        return [*columns, Column(FAILED, "", WHY_FAILED, reasons)]

    def columns(self) -> dict[str, Any]:
        """The table by column: arrays (n,) of inputs and quantities [SI], and `failed`, a list of text."""
        return {column.name: column.values for column in self.table()}

    def to_csv(self, path: str | PathLike) -> Path:
        """Writes the table of realisations to a new CSV file: a line of names with units, then a line each.

        Numbers are written in full. Raises StudyError where the file exists or cannot be written.
        """
        table, path = self.table(), Path(path)
        try:
            with path.open("x", newline="", encoding="utf-8") as stream:
                lines = csv.writer(stream)
                lines.writerow(f"{column.name} [{column.unit}]" if column.unit else column.name for column in table)
                lines.writerows(zip(*(np.asarray(column.values).tolist() for column in table), strict=True))
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
        frame.attrs["units"] = {column.name: column.unit for column in table if column.unit}
        frame.attrs["meanings"] = {column.name: column.meaning for column in table}
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
        return next(channel_row.unit for channel_row in scene.channels if channel_row.name == channel)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Warnings about the result, one sentence each."""
        return tuple(warnings_of(self.summary))


def warnings_of(summary: Mapping[str, Any]) -> list[str]:
    """Warnings in the summary of a study, one sentence each; it may have come as JSON."""
    count, failed = summary["samples"], sum(summary["failed"].values())
    sentences = [f"{number} of {count} realisations: {sentence}" for sentence, number in summary["doubts"].items()]
    if failed and failed == count:
        reason = max(summary["failed"], key=summary["failed"].get)
        sentences.append(f"all {count} realisations failed, so that there are no statistics: {reason}")
    elif failed:
        sentences.append(f"{failed} of {count} realisations failed; the statistics are those of the others")
    if summary["stopped_because"].startswith("failed"):
        sentences.append(summary["stopped_because"])
    return [*sentences, *map(str, summary["notes"])]


def size_of(quantity: Mapping[str, Any]) -> float:
    """The size of a quantity of a summary, which selects its unit: of mean and deviation, or else of quantiles."""
    moments = [quantity[key] for key in ("mean", "std") if quantity[key] is not None]
    return max(map(abs, moments or [quantile["value"] for quantile in quantity["quantiles"].values()]), default=0.0)


def shares_of(quantity: Mapping[str, Any]) -> dict[str, Mapping]:
    """Sobol indices of a quantity of a summary by input; empty where there are none."""
    return {key: share for key, share in quantity.get("sobol", {}).items() if key != "refused"}


def refusals(quantity: Mapping[str, Any]) -> list[str]:
    """Sentences about the refused statistics of a quantity of a summary, one for each reason."""
    by_reason = names_by_sentence({statistic: [reason] for statistic, reason in quantity["refused"].items()})
    return [f"no {in_words(statistics, 'or')}, because {reason}" for reason, statistics in by_reason.items()]


def names_by_sentence(sentences: Mapping[str, Iterable[str]]) -> dict[str, list[str]]:
    """Each sentence once, with the names that share it, from the sentences about each name."""
    names: dict[str, list[str]] = {}
    for name, sentences_of_name in sentences.items():
        for sentence in sentences_of_name:
            names.setdefault(sentence, []).append(name)
    return names


def in_words(names: Iterable[str], last: str = "and") -> str:
    """Names as a list in words: `mean, std and skewness`."""
    *first, end = names
    return f"{', '.join(first)} {last} {end}" if first else end


def finite(value: float) -> float | None:
    """The end of an interval as plain data: None where it is open."""
    return value if math.isfinite(value) else None


class Tally:
    """Kinds of sentences about realisations: those that differ in numbers alone are of one kind, shown by the first."""

    def __init__(self, sentences: Iterable[str] = ()):
        self.sentences = list(sentences)
        self._indices = {without_numbers(sentence): index for index, sentence in enumerate(self.sentences)}

    def index(self, sentence: str) -> int:
        """The number of the sentence's kind, a new one if need be; beyond MOST_KINDS all share the last."""
        kind = without_numbers(sentence)
        if kind not in self._indices:
            if len(self.sentences) == MOST_KINDS:
                return MOST_KINDS - 1
            self._indices[kind] = len(self.sentences)
            self.sentences.append(sentence)
        return self._indices[kind]

    def codes(self, count: int, failures: dict[int, str]) -> np.ndarray:
        """(count,) int32: 0, or 1 + the kind of a row's sentence."""
        codes = np.zeros(count, np.int32)
        for row in sorted(failures):
            codes[row] = 1 + self.index(failures[row])
        return codes

    def bits(self, count: int, warnings: dict[int, tuple[str, ...]]) -> np.ndarray:
        """(count,) int64: one bit for each kind among a row's sentences."""
        bits = np.zeros(count, np.int64)
        for row in sorted(warnings):
            for sentence in warnings[row]:
                bits[row] |= 1 << self.index(sentence)
        return bits


def sweep_head(study: Study) -> dict[str, Any]:
    """Key, unit and values [SI] of a sweep, and the value `at` that the key has in the scene of the study."""
    key, values = study.sweep
    in_scene = value_at(study.scene, key)
    in_scene = float(in_scene) if isinstance(in_scene, (int, float)) else None
    return {"key": key, "unit": numeric_keys(study.kind)[key].unit, "at": in_scene, "values": list(values)}


def sweep_of(result: StudyResult) -> dict[str, Any] | None:
    """The sweep of a result, also of one whose log an earlier version wrote; None without one."""
    summary = result.summary
    return {**sweep_head(result.study), **summary["sweep"]} if "sweep" in summary else None


class SweepDescription:
    """A sweep for people: `key`, `label` of an axis, and the `values` that have a study.

    `shown(unit, size)` gives (unit, factor) in which values of that size are shown. `in_scene` is the key with its
    value in the scene, empty where a log does not have it; `incomplete` is empty where every value has its study.
    """

    def __init__(self, sweep: Mapping[str, Any], shown: Callable = readable_unit):
        values, in_scene = [study["value"] for study in sweep["studies"]], sweep.get("at")
        unit, factor = shown(sweep.get("unit", "1"), max(map(abs, [*values, in_scene or 0.0])))
        self.key, self.label = sweep["key"], axis_label(sweep["key"], unit)
        self.values = [factor * value for value in values]
        self.in_scene = "" if in_scene is None else f"{self.key} = {factor * in_scene:.6g}{with_unit(unit)}"
        requested = len(sweep.get("values", values))
        missing = f"{requested - len(values)} of the {requested} values of its sweep" if values else "its sweep"
        self.incomplete = f"the study ended before {missing}" if requested > len(values) else ""


# The summary of a study as plain data: statistics of quantities and histories, failures, warnings and notes.

PROBABILITIES = (0.05, 0.25, 0.5, 0.75, 0.95)
SURROGATE_POINTS = 2**14  # of a polynomial chaos
BANDS = ("0.05", "0.50", "0.95", "mean", "at_mean_inputs")  # columns of a history that are drawn


def _statistics(estimator: Callable, count_modes: Callable | None, missing: Mapping[str, str]) -> dict[str, Any]:
    """Statistics of a quantity as plain data.

    `estimator(statistic)` is the Estimate of a moment by name or of a quantile by its probability, `count_modes()`
    plain data; both may raise StatisticError. `missing` names moments that do not exist, with the reason.
    """
    refused, result = dict(missing), {"unsafe": []}

    def attempt(name: str, compute: Callable, *arguments):
        try:
            return None if name in refused else compute(*arguments)
        except StatisticError as error:
            refused[name] = str(error)
            return None

    for name in MOMENTS:
        estimated = attempt(name, estimator, name)
        result[name], result[f"{name}_interval"] = (
            estimated and estimated.value,
            estimated and [*map(finite, estimated[1:3])],
        )
        result["unsafe"] += [name] if estimated and not estimated.safe else []
    quantiles = {p: attempt(f"quantile {p:g}", estimator, p) for p in PROBABILITIES}
    result["quantiles"] = {
        f"{p:.2f}": _estimate_data(*estimated[:3]) for p, estimated in quantiles.items() if estimated
    }
    result["modality"] = attempt("modality", count_modes) if count_modes else None
    return {**result, "refused": refused}


def _sample_estimator(sample: np.ndarray, replicates: int, seed: int) -> tuple[Callable, Callable]:
    """The estimator of a sample and the count of its modes, as `_statistics` takes them."""
    sample = np.ascontiguousarray(sample)
    ordered = np.sort(sample)  # once, where it does not matter whose replicate a point is

    def estimator(statistic):
        unordered = statistic in MOMENTS or replicates > 1
        return estimate(sample if unordered else ordered, statistic, replicates)

    def count_modes():
        counted = modality(ordered, seed)
        return {"modes": counted.modes, "p_value": counted.p_value, "positions": list(counted.positions)}

    return estimator, count_modes


def _derived_estimator(derived: Derived) -> tuple[Callable, Callable]:
    """The same of an exact distribution, whose intervals have no width."""

    def estimator(statistic):
        value = float(getattr(derived, statistic) if statistic in MOMENTS else derived.quantile(statistic))
        return Estimate(value, value, value)

    return estimator, lambda: {"modes": derived.modes, "p_value": None}


def _chaos_estimator(study: Study, chaos: Chaos) -> tuple[Callable, Callable]:
    """The same of an expansion: mean and deviation exactly, the rest from SURROGATE_POINTS of it.

    Intervals are those of this sampling, wider by the root mean square error of the expansion.
    """
    points = UnitPoints("sobol", study.joint.dimension, study.settings.seed, SURROGATE_POINTS)
    sampled, count_modes = _sample_estimator(
        chaos.predict(points.chunk(0, points.samples)), points.replicates, study.settings.seed
    )
    miss, exact = chaos.error * chaos.std, {"mean": chaos.mean, "std": chaos.std}

    def estimator(statistic):
        estimated = Estimate(*[exact[statistic]] * 3) if statistic in exact else sampled(statistic)
        return estimated._replace(low=estimated.low - miss, high=estimated.high + miss)

    return estimator, count_modes


def _estimate_data(value, low=math.inf, high=math.inf) -> dict[str, Any]:
    return {"value": float(value), "low": finite(float(low)), "high": finite(float(high))}


def _quantity_summary(
    result: StudyResult, name: str, propagated, missing, sampling, with_modes: bool
) -> dict[str, Any]:
    """One quantity: by its exact distribution or its expansion, or by the sample where `propagated` is None."""
    study, rule, method, details = result.study, sampling.rule, "change_of_variable", {}
    if isinstance(propagated, Derived):
        estimator, count_modes = _derived_estimator(propagated)
    elif isinstance(propagated, Chaos):
        method, (estimator, count_modes) = "chaos", _chaos_estimator(study, propagated)
        details = {"degree": propagated.degree, "validation_error": propagated.error}
        if study.joint.independent:
            pairs = zip(study.joint.keys, propagated.first, propagated.total, strict=True)
            details["sobol"] = {
                key: {"first": _estimate_data(first), "total": _estimate_data(total)} for key, first, total in pairs
            }
    else:
        method = "ensemble"
        estimator, count_modes = _sample_estimator(result.sample(name), sampling.points.replicates, study.settings.seed)
    statistics = _statistics(estimator, count_modes if with_modes or method == "change_of_variable" else None, missing)
    statistic, half_width = rule.estimated if name == rule.quantity else "mean", None
    if statistic not in statistics["refused"]:
        with contextlib.suppress(StatisticError):
            half_width = finite(estimator(statistic).half_width)
    return {"method": method, **statistics, "half_width": half_width, **details}


def sobol_summary(indices: Mapping[str, Mapping[str, Estimate]]) -> dict[str, Any]:
    """First and total Sobol indices of a quantity by input as plain data."""
    return {
        key: {order: _estimate_data(*index[:3]) | {"unsafe": not index.safe} for order, index in orders.items()}
        for key, orders in indices.items()
    }


def summary_of(is_cancelled: Callable[[], bool], *arguments) -> dict:
    """The plain data of a result, without seconds, from the arguments of `_summary`.

    Once `is_cancelled()` is true modes and statistics of histories are left out, which a note says.
    """
    try:
        with stop_condition(is_cancelled):
            stop_if_requested()
            return _summary(*arguments, complete=True)
    except Stopped:
        with stop_condition(lambda: False):
            return _summary(*arguments, complete=False)


def _summary(
    result: StudyResult, without_sampling: Mapping, missing: Mapping, sampling, at_mean, model, *, complete: bool
):
    """The summary.

    Parameters
    ----------
    without_sampling : dict
        The distribution or expansion of quantities that need no sample.
    missing : dict
        Moments that do not exist, by quantity, each with the reason.
    sampling : run.Sampling
        The ensemble.
    at_mean : Realised
        The realisation at the mean inputs, or none.
    model : run.ModelErrors
    """
    study, settings, quantities = result.study, result.study.settings, {}
    with_modes = settings.modality == "yes" and complete
    for column, (name, unit) in enumerate(study.quantity_units.items()):
        propagated = without_sampling.get(name)
        quantity = _quantity_summary(result, name, propagated, missing.get(name, {}), sampling, with_modes)
        quantity["at_mean_inputs"] = finite(at_mean.quantities[0, column]) if len(at_mean.quantities) else None
        quantities[name] = {"unit": unit, **quantity} | model.for_quantity(name)
    cut = "cancelled: modes and statistics of histories are not computed; resume from the log to get them"
    count, failed = len(result.status), result.status > 0
    return {
        "study": study.name,
        "scene": study.scene["name"],
        "inputs": {source.key: source.describe() for source in study.inputs},
        "quantities": quantities,
        "seed": settings.seed,
        "sampler": settings.sampler,
        "companions": model.checks,
        "stopped_because": sampling.stopped_because,
        "convergence": _convergence(sampling.rule, sampling.path),
        "histories": {
            channel: _history_summary(result, channel, sampling.task.instants, at_mean.histories[:, row], complete)
            for row, channel in enumerate(study.histories)
        },
        "samples": count,
        "failed": {text: int(np.sum(result.status == 1 + index)) for index, text in enumerate(result.reasons)},
        "failed_share": float(np.mean(failed)) if count else 0.0,
        "doubts": {text: int(np.sum(result.doubtful >> k & 1)) for k, text in enumerate(result.doubts_met)},
        "notes": [*sampling.notes, *model.notes, *([] if complete else [cut])],
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
        "estimate": [estimated.value for _, estimated in path],
        "half_width": [estimated.half_width for _, estimated in path],
        "low": [finite(estimated.low) for _, estimated in path],
        "high": [finite(estimated.high) for _, estimated in path],
    }


def _history_summary(result, channel, instants, at_mean, complete: bool) -> dict:
    """Bands of a history over the realisations that did not fail, and the run `at_mean` inputs (1 or 0, t)."""
    histories, inputs, bands = result.history(channel), result.values, {}
    finite_rows = np.isfinite(histories).all(axis=1)
    if not finite_rows.all():
        histories, inputs = histories[finite_rows], inputs[finite_rows]
    if len(histories) > 1 and complete:
        bands = history_statistics(histories, inputs, result.study.joint.keys)
        bands["autocorrelation_time_s"] = instants[bands.pop("rows")]
    if len(at_mean):
        bands["at_mean_inputs"] = at_mean[0]
    head = {"realisations": len(histories), "time_s": instants.tolist()}
    return head | {name: values.tolist() for name, values in bands.items()}


def model_error_sentences(summary: Mapping[str, Any], shown: Callable = readable_unit) -> Iterator[str]:
    """Sentences of a study's summary: each quantity's error of the model, how it was found, what is not known of it.

    `shown(unit, size)` gives (unit, factor) in which values of that size are shown.
    """
    checks = summary.get("companions")
    if checks is None:  # a log of an earlier version
        return
    for name, quantity in summary["quantities"].items():
        if quantity["error"] is not None:
            unit, factor = shown(quantity["unit"], size_of(quantity) or quantity["error"])
            known = ((source, error) for source, error in quantity["errors_by_source"].items() if error is not None)
            parts = sorted(known, key=lambda source_and_error: -source_and_error[1])
            sources = ", ".join(f"{_source_name(source)} {two_digits(factor * error)}" for source, error in parts)
            value = f"{two_digits(factor * quantity['error'])}{with_unit(unit)}"
            yield f"{name}: error of the model \u00b1 {value} ({sources})"
    if checks["realisations"]:
        failed = f", {checks['failed']} more failed" if checks["failed"] else ""
        location = f"the greatest in {checks['realisations']} realisations{failed}, {checks['where']}"
        yield f"errors of the model are not part of the sampling intervals; they are {location}"
    if checks["errors_unknown"]:
        sources = ", ".join(map(_source_name, checks["errors_unknown"]))
        yield f"effects without an error estimate (reasons in --json): {sources}"


def _source_name(source: str) -> str:
    """A source of errors in words."""
    return SOURCE_LABELS.get(source, source.replace("_", " "))
