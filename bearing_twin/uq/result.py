"""The result of a study: every realisation as arrays and as a table, and the summary of each quantity."""

import csv
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import StudyError, wanted
from bearing_twin.base.report import in_lines
from bearing_twin.base.units import labelled, unit_for_people, with_unit
from bearing_twin.uq.inputs import numeric_keys, quantity_of, value_at
from bearing_twin.uq.realisations import median_inputs, without_numbers
from bearing_twin.uq.study import Study

MOST_KINDS = 48  # of reasons or warnings; their bits fit into the digits of a float
OUT_OF_TIME = "its time_limit of "  # how the reason begins why an ensemble ended early
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
        units = self.quantity_units
        medians = {
            f"{name} [{units[name]}]": [float(one) for one in np.quantile(column, (0.05, 0.5, 0.95))]
            for name, column in zip(self.study.quantities, self.quantities[self.status == 0].T, strict=True)
            if len(column)
        }
        return in_lines(f"{title}; quantiles 5, 50, 95 %", medians)

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
        table, frame = self.table(), wanted("pandas", "export").DataFrame(self.columns())
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

    @property
    def quantity_units(self) -> dict[str, str]:
        """Unit of each quantity by its name."""
        return quantity_units(self.study)

    def history_unit(self, channel: str) -> str:
        """Unit of the histories of a channel."""
        scene = self.study.scene_at(median_inputs(self.study))
        return next(one.unit for one in scene.channels if one.name == channel)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Warnings about the result, one sentence each."""
        return tuple(warnings_of(self.summary))


def quantity_units(study: Study) -> dict[str, str]:
    """Unit of each quantity of a study by its name."""
    return {name: quantity_of(study.kind, name).unit for name in study.quantities}


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
    return [*sentences, *summary["notes"]]


def size_of(found: Mapping[str, Any]) -> float:
    """The size of a quantity of a summary, which selects its unit: of mean and deviation, or else of quantiles."""
    moments = [found[key] for key in ("mean", "std") if found[key] is not None]
    return max(map(abs, moments or [one["value"] for one in found["quantiles"].values()]), default=0.0)


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
    """A sweep for people: `key`, `unit`, `label` of an axis, the `values` that have a study, and the scene's `place`.

    `shown(unit, size)` gives (unit, factor) in which values of that size are shown. `at` names the place, empty where a
    log does not have it; `ended` is empty where every value has its study.
    """

    def __init__(self, sweep: Mapping[str, Any], shown: Callable = unit_for_people):
        values, at = [one["value"] for one in sweep["studies"]], sweep.get("at")
        unit, factor = shown(sweep.get("unit", "1"), max(map(abs, [*values, at or 0.0])))
        self.key, self.unit, self.label = sweep["key"], unit, labelled(sweep["key"], unit)
        self.values, self.place = [factor * one for one in values], None if at is None else factor * at
        self.at = "" if at is None else f"{self.key} = {self.place:.6g}{with_unit(unit)}"
        requested = len(sweep.get("values", values))
        left = f"{requested - len(values)} of the {requested} values of its sweep" if values else "its sweep"
        self.ended = f"the study ended before {left}" if requested > len(values) else ""
