"""Errors of the model in a study, from a few realisations that are checked by a second run.

They are reported apart from those of sampling. Checked are the realisations in which the quantities are least,
greatest and in the middle, the watched quantity first; without a sample those at the medians of the inputs and at
their ends. The greatest error of each source stands for all, and the sum of the sources for the model.
"""

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.stopping import stop_if_requested
from bearing_twin.base.units import with_unit
from bearing_twin.kinds.error_estimates import METHOD
from bearing_twin.run.report import LARGE, exceeds
from bearing_twin.uq.inputs import quantity_of
from bearing_twin.uq.realisations import Realised, Task, without_numbers
from bearing_twin.uq.result import Tally
from bearing_twin.uq.study import Study
from bearing_twin.uq.workers import Ensemble

OF_INPUTS = 0.5, 0.05, 0.95  # probabilities of all inputs at once, where there is no sample
SAMPLED = "where quantities are in the middle, least and greatest"
NOT_CHECKED = "the study ended before a realisation was checked by a second run"
GIVEN = "at the medians of the inputs, and at 5 and 95 % of all of them"


class ModelErrors(NamedTuple):
    """`of` maps quantities to `error` and `errors_by_source`; `checks` says how they were found."""

    of: dict[str, dict[str, Any]]
    checks: dict[str, Any]
    notes: list[str]

    def for_quantity(self, name: str) -> dict[str, Any]:
        """The keys of one quantity; None where no error is known."""
        return self.of.get(name, {"error": None, "errors_by_source": {}})


def no_model_errors(because: str) -> ModelErrors:
    """Errors that are not known, with the reason."""
    return ModelErrors({}, {"realisations": 0, "failed": 0, "where": "", "errors_unknown": {METHOD: because}}, [])


def checked_rows(quantities: np.ndarray, first: int, count: int) -> list[int]:
    """Rows of a sample (n, q), at most `count`: in the middle of a quantity, its greatest and its least in turn.

    Quantity number `first` leads; never rows that failed (NaN).
    """
    rows: list[int] = []
    for column in [first, *(place for place in range(quantities.shape[1]) if place != first)]:
        stop_if_requested()
        good = np.flatnonzero(np.isfinite(quantities[:, column]))
        if last := len(good) - 1 if len(good) else 0:
            ranks = np.argpartition(quantities[good, column], (0, (last + 1) // 2, last))
            rows += good[ranks[[(last + 1) // 2, last, 0]]].tolist()
        else:
            rows += good.tolist()
    return list(dict.fromkeys(rows))[:count]


def model_errors(study: Study, task: Task, ensemble: Ensemble, values, quantities, known=()) -> ModelErrors:
    """Errors of the study's quantities, by its sample `values` (n, d) and `quantities` (n, q), or without one.

    `known` are the warnings of the sample; those of checked realisations alone are in the notes.
    """
    count = study.settings.checks
    if not count:
        return no_model_errors("checks: 0, so the error of the model is not known")
    rows = checked_rows(quantities, study.quantities.index(study.settings.stop.quantity), count)
    ends = np.repeat(np.array(OF_INPUTS)[:, None], study.joint.dimension, axis=1)[:count]
    at, where = (values[rows], SAMPLED) if rows else (study.joint.values(ends), GIVEN)
    found = ensemble.evaluate(at, task=task._replace(closed=False, checked=True))
    if len(found.quantities) < len(at):
        return no_model_errors(NOT_CHECKED)
    return gathered(study, found, known, where)


def gathered(study: Study, found: Realised, known: Iterable[str] = (), where: str = SAMPLED) -> ModelErrors:
    """The greatest errors by source among checked realisations, and notes of large ones and of further warnings."""
    of, unknown, notes = {}, {}, []
    for one in found.errors.values():
        unknown.update(one.unknown)
    for column, name in enumerate(study.quantities):
        parts: dict[str, float] = {}
        for one in found.errors.values():
            for source, error in one.of[name].items():
                parts[source] = max(parts.get(source, 0.0), error)
        by_source = {source: error for source, error in parts.items() if math.isfinite(error)}
        error = math.fsum(by_source.values()) if by_source else None
        of[name] = {"error": error, "errors_by_source": by_source}
        if len(by_source) < len(parts):
            unknown[name] = "a figure that it is read off has no bound of its error"
        sizes = found.quantities[np.isfinite(found.quantities[:, column]), column].tolist()
        if error is not None and sizes and exceeds(sizes, error):
            unit = with_unit(quantity_of(study.kind, name).unit)
            notes.append(
                f"{name}: the error of the model is {error:.2g}{unit}, over {100.0 * LARGE:g} % of it, mostly "
                f"{max(by_source, key=by_source.get).replace('_', ' ')}: no sampling makes it smaller"
            )
    known, tally = set(map(without_numbers, known)), Tally()
    bits = tally.bits(len(found.quantities), found.doubts)
    for place, sentence in enumerate(tally.sentences):
        if without_numbers(sentence) not in known:
            notes.append(f"{np.sum(bits >> place & 1)} of {len(found.errors)} checked realisations: {sentence}")
    checks = {"realisations": len(found.errors), "failed": len(found.failures), "errors_unknown": unknown}
    return ModelErrors(of, checks | {"where": where}, notes)
