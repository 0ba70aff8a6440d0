"""A study in, its result out: which method for which quantity, the ensemble in batches, the stop rule, the summary."""

import contextlib
import dataclasses
import time
from collections.abc import Callable, Mapping
from os import PathLike
from typing import Any

import numpy as np

from bearing_twin.errors import Stopped, StudyError
from bearing_twin.spelling import no_progress
from bearing_twin.stopping import heeding
from bearing_twin.uq.drawing import CANCELLED, OUT_OF_TIME, Drawn, Progress
from bearing_twin.uq.ensemble import Ensemble
from bearing_twin.uq.evaluation import Evaluator, expansions, interpolations, sources_of_variance
from bearing_twin.uq.histories import COLUMNS, ROWS
from bearing_twin.uq.model_error import model_errors, no_model_errors
from bearing_twin.uq.narrowing import RESAMPLES
from bearing_twin.uq.propagation import exact_distributions, mean_inputs, missing_moments, task_of
from bearing_twin.uq.realise import empty
from bearing_twin.uq.result import StudyResult
from bearing_twin.uq.sampling import SAMPLERS
from bearing_twin.uq.study import Study
from bearing_twin.uq.study_file import load_study
from bearing_twin.uq.summary import summary_of
from bearing_twin.uq.swept import sweep_head
from bearing_twin.uq.tabulated import numbers_kept

WORKING_COPIES = 8  # of one column, while its statistics are made
FINITE = 1.125  # histories, and a byte a number that says whether it is one
BLOCKS = 4  # of ROWS histories, while products of them are summed
SENSITIVITY_COPIES = 5  # of one quantity at the points of Sobol indices, while these are made
# What must be the same where samples are taken over from an earlier result.
SAME = (
    "scene", "inputs", "correlation", "quantities", "histories", "history_points", "history_duration",
    "sampler", "seed",
)  # fmt: skip


def run_study(
    study: Study | str | PathLike | Mapping,
    progress: Callable[[Progress], None] | None = None,
    cancelled: Any = None,
    start: StudyResult | None = None,
    keep: Callable | None = None,
) -> StudyResult:
    """Runs a study, or that of a name, path or plain data; its numbers follow from study and seed alone.

    `progress` is called after every batch and every few realisations, from this thread. `cancelled` is a
    threading.Event or a function: once true the study ends within half a second with what is done; statistics not made
    yet are then those of the first samples, as many as that time allows, and a note says so. `start` is an earlier
    result of the same study with fewer samples, which are kept; the result equals that of one run. `keep(values,
    quantities, histories, status, doubtful, reasons, doubts)` is handed every realisation as it comes, in order. Raises
    StudyError for a study too large for its memory, a method that does not fit it, a `start` of another study, or a
    time limit that no realisation keeps.
    """
    began = time.monotonic()
    if progress is not None and not callable(progress):
        raise StudyError(no_progress(progress, "load_study"))
    study = study if isinstance(study, Study) else load_study(study)
    asked = getattr(cancelled, "is_set", cancelled) or (lambda: False)
    limit = study.settings.time_limit or np.inf
    tell = progress or (lambda _: None)
    parts = 1 if study.sweep is None else 1 + len(study.sweep[1])
    refuse_too_large(study)
    if start is not None:
        _refuse_another_study(study, start)
    task = task_of(study)
    exact = exact_distributions(study, task, study.settings.method)
    missing = {name: missing_moments(study, task, name) for name in study.quantities if name not in exact}

    def ends() -> bool:
        return asked() or time.monotonic() - began > limit

    drawn = Drawn(study, task, _part(tell, 0, parts, began), ends, began, keep)
    with heeding(ends), Ensemble(task, study.settings.workers, study.executor, ends) as ensemble:
        expanded, sources = _propagate(study, ensemble, drawn, start, sampled=len(exact) < len(study.quantities))
        over = ends() or drawn.broken
        at_mean = empty(task, 0) if over else ensemble.evaluate(mean_inputs(study))
        worth = no_model_errors("the study ended before a companion had gone with a realisation")
        if not over:
            with contextlib.suppress(Stopped):
                worth = model_errors(study, task, ensemble, *drawn.arrays()[:2], drawn.doubts.sentences)
    if drawn.because == CANCELLED and not asked():
        _tell_limit(study, drawn, bool(exact or expanded))
    values, quantities, histories, status, doubtful = drawn.arrays()
    result = StudyResult(
        study, values, quantities, histories,
        status, tuple(drawn.reasons.sentences), doubtful, tuple(drawn.doubts.sentences), {},
    )  # fmt: skip
    summary = summary_of(result, missing, task, exact | expanded, drawn, (at_mean, worth), asked)
    for name, found in sources.items():
        summary["quantities"][name]["sobol"] = found
    if study.sweep is not None:
        summary["sweep"] = _sweep(study, tell, ends, began)
    summary["seconds"] = time.monotonic() - began
    return dataclasses.replace(result, summary=summary)


def _tell_limit(study: Study, drawn: Drawn, otherwise: bool) -> None:
    """Says that the time limit ended a study; raises StudyError where nothing is done, nor known `otherwise`."""
    limit = f"{study.settings.time_limit:g} s was reached"
    if not (drawn.done or otherwise):
        raise StudyError(f"study {study.name}: its time_limit of {limit} before a realisation was done; raise it")
    drawn.because = f"{OUT_OF_TIME}{limit}"


def memory_needed(study: Study) -> float:
    """Bytes of the arrays a study fills, at its greatest number of samples."""
    settings, histories = study.settings, len(study.histories) * study.settings.history_points
    inputs, quantities = len(study.inputs), len(study.quantities)
    row = inputs + quantities + FINITE * histories + 2.0 + WORKING_COPIES
    rows = study.sensitivity_rows
    # Their points are kept three times: in the unit cube, as values, and as the key by which they are found again.
    further = rows * (inputs + 2) * (3.0 * inputs + quantities + SENSITIVITY_COPIES)
    sums = len(study.histories) * settings.history_points**2
    columns = settings.samples * (2 * COLUMNS + RESAMPLES / 8) if study.histories else 0.0
    columns += BLOCKS * ROWS * settings.history_points if study.histories else 0.0
    tables = numbers_kept([one.distribution_name for one in study.inputs])
    return 8.0 * (settings.samples * row + further + sums + columns + tables)


def refuse_too_large(study: Study) -> None:
    """Raises StudyError, with the estimate, where a study would need more memory than it allows itself."""
    needed, allowed = memory_needed(study), study.settings.memory
    if needed > allowed:
        raise StudyError(
            f"study {study.name} would need {needed:.3g} B for {study.settings.samples} samples, more than its "
            f"memory = {allowed:.3g} B; ask for fewer samples, histories, history_points or sensitivity, or raise it"
        )


def _refuse_another_study(study, start):
    old, new = start.study.resolved(), study.resolved()
    differing = [key for key in SAME if old[key] != new[key]]
    if differing:
        raise StudyError(
            f"the samples to go on from belong to a study with another {differing[0]}; run this one from the beginning"
        )
    if not SAMPLERS[study.settings.sampler].grows and study.settings.samples != start.study.settings.samples:
        raise StudyError("a latin hypercube has its size for good and cannot be continued; use sobol or random")


def _part(tell, place, parts, began, at=""):
    """Progress of one of `parts` studies of the same size, told as that of all of them, `began` at a monotonic time."""

    def of_all(one: Progress) -> None:
        done, total = one.done + place * one.total, parts * one.total
        left = (time.monotonic() - began) * (total - done) / max(done, 1)
        tell(one._replace(done=done, total=total, seconds_left=left, at=at))

    return tell if parts == 1 else of_all


def _sweep(study, tell, asked, began) -> dict:
    """The summaries at each value of a sweep, one study each, by the same method and seed."""
    key, values = study.sweep
    found = []
    for place, value in enumerate(values, start=1):
        if asked():
            break
        part = _part(tell, place, 1 + len(values), began, f"{key} = {value:g}")
        summary = run_study(study.at(value), part, asked).summary
        found.append({"value": value, "samples": summary["samples"], "quantities": summary["quantities"]})
    return {**sweep_head(study), "studies": found}


def _propagate(study, ensemble, drawn, start, sampled):
    """(expansions or interpolants, Sobol indices) by quantity; the ensemble goes into `drawn`. A cancel ends all."""
    evaluate = Evaluator(ensemble, study, drawn.tell_more)
    expanded, sources, method = {}, {}, study.settings.method
    try:
        if method == "chaos":
            expanded = expansions(study, evaluate)
            drawn.because = f"{evaluate.runs} runs for polynomial chaos are done"
        elif method == "change_of_variable" and sampled:
            expanded, sampled = interpolations(study, evaluate), False
            drawn.because = f"{evaluate.runs} runs for an interpolant are done"
        if study.histories or (sampled and method != "chaos"):
            drawn.draw(ensemble, start)
        if study.settings.sensitivity and not (drawn.asked() or drawn.broken):
            sources = sources_of_variance(study, evaluate)
    except Stopped:
        drawn.because = CANCELLED
    return expanded, sources
