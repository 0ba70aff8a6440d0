"""What a study found: every sample, and a summary of each quantity with the interval it is known to."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bearing_twin.errors import StatisticError
from bearing_twin.uq.change_of_variable import Derived
from bearing_twin.uq.modality import modality, mode_numbers
from bearing_twin.uq.quantities import quantity_of
from bearing_twin.uq.realise import without_numbers
from bearing_twin.uq.scene_keys import numeric_keys
from bearing_twin.uq.statistics import MOMENTS, densities_at, estimate
from bearing_twin.uq.study import Study

PROBABILITIES = (0.05, 0.25, 0.5, 0.75, 0.95)
GRID = 2001  # points of a density whose modes are counted
MOST_KINDS = 48  # of reasons or doubts; their bits fit into the digits of a float


@dataclass(frozen=True, eq=False)
class StudyResult:
    """A study that has run.

    `values` (n, d) of the inputs and `quantities` (n, q) in SI, NaN where the realisation failed; `histories`
    (n, h, points); `status` (n,) int32: 0, or 1 + the place in `reasons`; `doubtful` (n,) int64: a bit for each
    sentence of `doubts_met` that holds. `summary` is the plain data of `as_dict`.
    Where a quantity came without sampling (method change_of_variable) there may be no samples: n = 0.
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

    def as_dict(self) -> dict:
        """The summary as plain data, as `--json` gives it; statistics that do not exist are null, with the reason."""
        return dict(self.summary)

    def to_dataframe(self) -> Any:
        """One row a realisation as a pandas DataFrame (extra `export`); see `uq.frame.frame_of`."""
        from bearing_twin.uq.frame import frame_of

        return frame_of(self)

    def sample(self, quantity: str) -> np.ndarray:
        """The quantity (n,) of every realisation, NaN where it failed."""
        return self.quantities[:, self.study.quantities.index(quantity)]

    def history(self, channel: str) -> np.ndarray:
        """The histories (n, points) of a channel, at `summary["histories"][channel]["time_s"]`."""
        return self.histories[:, self.study.histories.index(channel)]

    @property
    def input_units(self) -> dict[str, str]:
        """Unit of each input by its key."""
        known = numeric_keys(self.study.kind)
        return {one.key: known[one.key].unit for one in self.study.inputs}

    @property
    def quantity_units(self) -> dict[str, str]:
        """Unit of each quantity by its name."""
        return quantity_units(self.study)

    def history_unit(self, channel: str) -> str:
        """Unit of the histories of a channel."""
        medians = self.study.joint.values(np.full((1, self.study.joint.dimension), 0.5))[0]
        return next(one.unit for one in self.study.scene_at(medians).channels if one.name == channel)

    @property
    def doubts(self) -> tuple[str, ...]:
        """What is doubtful about the result, one sentence each."""
        return tuple(doubts_told(self.summary))


def doubts_told(summary: Mapping[str, Any]) -> list[str]:
    """What is doubtful by a summary of a study, one sentence each; it may have come as JSON."""
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
    """The size of a quantity of a summary, by which its unit is chosen: of mean and deviation, or else of quantiles."""
    moments = [found[key] for key in ("mean", "std") if found[key] is not None]
    return max(map(abs, moments or [one["value"] for one in found["quantiles"].values()]), default=0.0)


def refusals(quantities: Mapping[str, Mapping]) -> Iterator[tuple[list[str], str]]:
    """(quantities, sentence) for each statistic that is refused, once for all of a summary that share the reason."""
    found: dict[str, list[str]] = {}
    for name, one in quantities.items():
        for statistic, reason in one["refused"].items():
            found.setdefault(f"no {statistic}, because {reason}", []).append(name)
    yield from ((names, sentence) for sentence, names in found.items())


def quantity_units(study: Study) -> dict[str, str]:
    """Unit of each quantity of a study by its name."""
    return {name: quantity_of(study.kind, name).unit for name in study.quantities}


class Tally:
    """Sentences about realisations by kind: those that differ in numbers alone are one, shown as it first came."""

    def __init__(self):
        self.sentences: list[str] = []
        self._places: dict[str, int] = {}

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
    refused, result, sample = dict(missing), {"unsafe": []}, np.ascontiguousarray(sample)
    for name in MOMENTS:
        result[name], result[f"{name}_interval"] = None, None
        if name not in refused:
            try:
                found = estimate(sample, name, replicates=replicates)
            except StatisticError as error:
                refused[name] = str(error)
                continue
            result[name], result[f"{name}_interval"] = found.value, [finite(found.low), finite(found.high)]
            result["unsafe"] += [] if found.safe else [name]
    result["quantiles"], ordered = {}, np.sort(sample)  # once, for all that does not ask whose replicate a point is
    for probability in PROBABILITIES:
        try:
            found = estimate(ordered if replicates == 1 else sample, probability, replicates=replicates)
        except StatisticError as error:
            refused[f"quantile {probability:g}"] = str(error)
            continue
        result["quantiles"][f"{probability:.2f}"] = {
            "value": found.value, "low": finite(found.low), "high": finite(found.high)
        }  # fmt: skip
    result["modality"] = None
    if modes:
        try:
            found = modality(ordered, seed)
            told = {"modes": found.modes, "p_value": found.p_value, "positions": list(found.positions)}
            result["modality"] = told
        except StatisticError as error:
            refused["modality"] = str(error)
    result["densities"] = []
    if densities:
        try:
            found = densities_at(sample, densities)
            result["densities"] = [_density(*row[:4]) for row in zip(densities, *zip(*found, strict=True), strict=True)]
        except StatisticError as error:
            refused["densities"] = str(error)
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
    result["quantiles"] = {name: {"value": value, "low": value, "high": value} for name, value in values.items()}
    low, high = derived.quantile(0.0005), derived.quantile(0.9995)
    number = int(mode_numbers(derived.pdf(np.linspace(low, high, GRID))))
    result["modality"] = {"modes": number, "p_value": None}
    heights = derived.pdf(np.array(densities, float)).tolist()
    result["densities"] = [_density(at, *[height] * 3) for at, height in zip(densities, heights, strict=True)]
    return {**result, "refused": refused}


def _density(at, height, low, high) -> dict:
    return {"value": float(at), "density": height, "low": low, "high": high}


def finite(value: float) -> float | None:
    """The end of an interval as plain data: None where it is open."""
    return value if math.isfinite(value) else None
