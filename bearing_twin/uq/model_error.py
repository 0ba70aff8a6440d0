"""What the quantities of a study are worth: errors of the model, at a few realisations that a companion goes with.

They are kept apart from what sampling leaves open. The realisations are those in which the quantities are least,
greatest and in the middle, the watched quantity first; without a sample those at the medians of the inputs and at
their ends. The greatest error found by each source stands for all realisations, and the sum of the sources for the
model. A companion that also makes a run more exact is looked for in SPREAD more, since without it each realisation
errs as its steps happen to: the greatest of so many is above 95 % of all with a confidence of 95 % (1 - 0.95^59; S. S.
Wilks, Annals of Mathematical Statistics 12 (1941) 91).
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.kinds import KINDS
from bearing_twin.kinds.doubt import METHOD
from bearing_twin.run.doubt import LARGE, exceeds
from bearing_twin.stopping import look
from bearing_twin.units import two_digits, unit_for_people, with_unit
from bearing_twin.uq.ensemble import Ensemble
from bearing_twin.uq.quantities import quantity_of
from bearing_twin.uq.realise import Realised, Task, without_numbers
from bearing_twin.uq.result import Tally, size_of
from bearing_twin.uq.study import Study

OF_INPUTS = 0.5, 0.05, 0.95  # where realisations lie without a sample: this quantile of all inputs at once
SPREAD = 59
SAMPLED = "where quantities are in the middle, least and greatest"
GIVEN = "at the medians of the inputs, and at 5 and 95 % of all of them"


class ModelErrors(NamedTuple):
    """`of` maps quantities to `error` and `errors_by_source`; `companions` says how they were found."""

    of: dict[str, dict[str, Any]]
    companions: dict[str, Any]
    notes: list[str]

    def for_quantity(self, name: str) -> dict[str, Any]:
        """The keys of one quantity; None where no error is known."""
        return self.of.get(name, {"error": None, "errors_by_source": {}})


def no_model_errors(because: str) -> ModelErrors:
    """Nothing is known, which is said."""
    return ModelErrors({}, {"realisations": 0, "failed": 0, "where": "", "errors_unknown": {METHOD: because}}, [])


def chosen(quantities: np.ndarray, first: int, count: int) -> list[int]:
    """Rows of a sample (n, q), at most `count`: in the middle of a quantity, its greatest and its least in turn.

    Quantity number `first` leads; rows that failed (NaN) are never chosen.
    """
    rows: list[int] = []
    columns = [first, *(place for place in range(quantities.shape[1]) if place != first)]
    for column in columns:
        look()
        good = np.flatnonzero(np.isfinite(quantities[:, column]))
        if len(good):
            found = quantities[good, column]
            middle = np.partition(found, len(found) // 2)[len(found) // 2]
            rows += [int(good[place]) for place in (np.argmax(found == middle), np.argmax(found), np.argmin(found))]
    return list(dict.fromkeys(rows))[:count]


def spread(quantities: np.ndarray) -> list[int]:
    """Rows of a sample (n, q), SPREAD at most, evenly among those that did not fail (NaN)."""
    good = np.flatnonzero(np.isfinite(quantities).all(axis=1))
    return good[np.linspace(0, len(good) - 1, min(SPREAD, len(good))).round().astype(int)].tolist()


def model_errors(
    study: Study, task: Task, ensemble: Ensemble, values: np.ndarray, quantities: np.ndarray, doubts: Iterable[str] = ()
) -> ModelErrors:
    """Errors of the study's quantities, beside its sample `values` (n, d) and `quantities` (n, q), or without one.

    `doubts` of the sample are known; what a companion doubts beside them is in the notes.
    """
    count = study.settings.companions
    if not count:
        return no_model_errors("companions: 0, so nothing is known of the error of the model")
    rows = chosen(quantities, study.quantities.index(study.stop_quantity), count)
    if rows:
        where = SAMPLED
        if KINDS[study.kind].steered:
            rows = list(dict.fromkeys(rows + spread(quantities)))
            where = f"{SAMPLED}, and evenly among all"
        at, own = values[rows], quantities[rows]
    else:
        at = study.joint.values(np.repeat(np.array(OF_INPUTS)[:, None], study.joint.dimension, axis=1)[:count])
        own, where = ensemble.evaluate(at).quantities, GIVEN
    found = ensemble.evaluate(at, task=task._replace(closed=False, watched=True))
    if len(found.quantities) < len(at) or len(own) < len(at):
        return no_model_errors("the study ended before a companion had gone with a realisation")
    of, told = _gathered(study, found, own, where)
    return ModelErrors(of, told, [*_large(study, of, own), *_doubted(found, doubts)])


def _gathered(study: Study, found: Realised, own: np.ndarray, where: str) -> tuple[dict, dict]:
    """The greatest error by source; realisations that differ from those with a companion err by that as well."""
    of, unknown = {}, {}
    for one in found.worth.values():
        unknown.update(one.unknown)
    for column, name in enumerate(study.quantities):
        parts: dict[str, float] = {}
        for row, one in found.worth.items():
            aside = abs(float(own[row, column] - found.quantities[row, column]))
            for source, error in one.errors[name].items():
                error += aside if source == METHOD and math.isfinite(aside) else 0.0
                parts[source] = max(parts.get(source, 0.0), error)
        known = {source: error for source, error in parts.items() if math.isfinite(error)}
        of[name] = {"error": math.fsum(known.values()) if known else None, "errors_by_source": known}
        if len(known) < len(parts):
            unknown[name] = "a figure that it is read off may be off by anything"
    told = {
        "realisations": len(found.worth),
        "failed": len(found.failures),
        "where": where,
        "errors_unknown": unknown,
    }
    return of, told


def _doubted(found: Realised, doubts: Iterable[str]) -> Iterator[str]:
    """A sentence for each kind of doubt that companions alone have, with how many realisations it is of."""
    known, tally = set(map(without_numbers, doubts)), Tally()
    bits = tally.bits(len(found.quantities), found.doubts)
    for place, sentence in enumerate(tally.sentences):
        if without_numbers(sentence) not in known:
            many = int(np.sum(bits >> place & 1))
            yield f"{many} of {len(found.worth)} realisations with a companion: {sentence}"


def _large(study: Study, of: Mapping[str, dict], own: np.ndarray):
    """A sentence for each quantity whose error is over a tenth of it."""
    for column, name in enumerate(study.quantities):
        error, known = of[name]["error"], own[np.isfinite(own[:, column]), column]  # none of those that failed
        if error is not None and len(known) and exceeds(known.tolist(), error):
            parts, unit = of[name]["errors_by_source"], with_unit(quantity_of(study.kind, name).unit)
            yield (
                f"{name}: the error of the model is {error:.2g}{unit}, over {100.0 * LARGE:g} % of it, mostly "
                f"{max(parts, key=parts.get).replace('_', ' ')}: no sampling makes it smaller"
            )


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
