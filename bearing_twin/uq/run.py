"""A study: the ensemble in batches, the stop rule, propagation by the method of each quantity, and the summary.

Errors of the model come from a few realisations that are checked by a second run, and are reported apart from those of
sampling. The realisations in which the quantities are least, greatest and in the middle are checked, the watched
quantity first; without a sample, those at the medians of the inputs and at their ends. The greatest error of each
source stands for all, and the sum of the sources for the model.
"""

import contextlib
import dataclasses
import math
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import StatisticError, Stopped, StudyError, echo, progress_error
from bearing_twin.base.stopping import stop_condition, stop_if_requested
from bearing_twin.base.units import with_unit
from bearing_twin.kinds.error_estimates import LARGE, METHOD
from bearing_twin.run.report import SOURCE_LABELS, is_large_error
from bearing_twin.uq.inputs import quantity_of
from bearing_twin.uq.propagation import MOST_RUNS, expand
from bearing_twin.uq.realisations import (
    Realised,
    Task,
    empty,
    exact_distributions,
    mean_inputs,
    missing_moments,
    task_of,
    without_numbers,
)
from bearing_twin.uq.result import StudyResult, Tally, sobol_summary, summary_of, sweep_head
from bearing_twin.uq.sampling import SAMPLERS, UnitPoints
from bearing_twin.uq.statistics import (
    HISTORIES_AT_ONCE,
    INSTANTS_AT_ONCE,
    Estimate,
    estimate,
    sensitivity_points,
    sobol_indices,
)
from bearing_twin.uq.study import IN_A_ROW, Study, checkpoints, load_study
from bearing_twin.uq.workers import Ensemble

CHECKED_PROBABILITIES = 0.5, 0.05, 0.95  # probabilities of all inputs at once, where there is no sample
SAMPLED = "with the median, least and greatest value of each quantity"
NOT_CHECKED = "the study ended before a realisation was checked by a second run"
WITHOUT_SAMPLE = "at the medians of the inputs, and at 5 and 95 % of all of them"


class ModelErrors(NamedTuple):
    """`by_quantity` holds `error` and `errors_by_source`; `checks` says how they were found."""

    by_quantity: dict[str, dict[str, Any]]
    checks: dict[str, Any]
    notes: list[str]

    def for_quantity(self, name: str) -> dict[str, Any]:
        """The keys of one quantity; None where no error is known."""
        return self.by_quantity.get(name, {"error": None, "errors_by_source": {}})


def no_model_errors(reason: str) -> ModelErrors:
    """Errors that are not known, with the reason."""
    return ModelErrors({}, {"realisations": 0, "failed": 0, "where": "", "errors_unknown": {METHOD: reason}}, [])


def checked_rows(quantities: np.ndarray, watched: int, count: int) -> list[int]:
    """Rows of a sample (n, q), at most `count`: in the middle of a quantity, its greatest and its least in turn.

    Quantity number `watched` comes first; rows that failed (NaN) are left out.
    """
    rows: list[int] = []
    for column in [watched, *(index for index in range(quantities.shape[1]) if index != watched)]:
        stop_if_requested()
        good = np.flatnonzero(np.isfinite(quantities[:, column]))
        if len(good):
            middle, last = len(good) // 2, len(good) - 1
            rows += good[np.argpartition(quantities[good, column], (0, middle, last))[[middle, last, 0]]].tolist()
    return list(dict.fromkeys(rows))[:count]


def model_errors(study: Study, task: Task, ensemble: Ensemble, values, quantities, known=()) -> ModelErrors:
    """Errors of the study's quantities, by its sample `values` (n, d) and `quantities` (n, q), or without one.

    `known` are the warnings of the sample; those of checked realisations alone are in the notes.
    """
    count = study.settings.checks
    if not count:
        return no_model_errors("checks: 0, so the error of the model is not known")
    rows = checked_rows(quantities, study.quantities.index(study.settings.stop.quantity), count)
    ends = np.repeat(np.array(CHECKED_PROBABILITIES)[:, None], study.joint.dimension, axis=1)[:count]
    points, selection = (values[rows], SAMPLED) if rows else (study.joint.values(ends), WITHOUT_SAMPLE)
    checked = ensemble.evaluate(points, task=task._replace(closed=False, checked=True))
    if len(checked.quantities) < len(points):
        return no_model_errors(NOT_CHECKED)
    return model_errors_of_checked(study, checked, known, selection)


def model_errors_of_checked(
    study: Study, checked: Realised, known: Iterable[str] = (), selection: str = SAMPLED
) -> ModelErrors:
    """The greatest errors by source among checked realisations, and notes of large ones and of further warnings."""
    by_quantity, unknown, notes = {}, {}, []
    for realisation_errors in checked.errors.values():
        unknown.update(realisation_errors.unknown)
    for column, name in enumerate(study.quantities):
        parts: dict[str, float] = {}
        for realisation_errors in checked.errors.values():
            for source, error in realisation_errors.by_quantity[name].items():
                parts[source] = max(parts.get(source, 0.0), error)
        by_source = {source: error for source, error in parts.items() if math.isfinite(error)}
        error = math.fsum(by_source.values()) if by_source else None
        by_quantity[name] = {"error": error, "errors_by_source": by_source}
        if len(by_source) < len(parts):
            unknown[name] = "the error of a figure that it depends on is unknown"
        sizes = checked.quantities[np.isfinite(checked.quantities[:, column]), column].tolist()
        unit = quantity_of(study.kind, name).unit
        if error is not None and sizes and is_large_error(sizes, error, unit):
            source = max(by_source, key=by_source.get)
            notes.append(
                f"{name}: the error of the model is {error:.2g}{with_unit(unit)}, over {100.0 * LARGE:g} % of it, "
                f"mostly {SOURCE_LABELS.get(source, source)}: no sampling makes it smaller"
            )
    known, tally = set(map(without_numbers, known)), Tally()
    bits = tally.bits(len(checked.quantities), checked.warnings)
    for bit, sentence in enumerate(tally.sentences):
        if without_numbers(sentence) not in known:
            notes.append(f"{np.sum(bits >> bit & 1)} of {len(checked.errors)} checked realisations: {sentence}")
    checks = {"realisations": len(checked.errors), "failed": len(checked.failures), "errors_unknown": unknown}
    return ModelErrors(by_quantity, checks | {"where": selection}, notes)


CANCELLED = "cancelled"  # why an ensemble ended
DRAWN_TOGETHER = 16384  # points drawn at once, so that a cancel need not wait for a whole batch


class Progress(NamedTuple):
    """Progress of a study: realisations `done` of `total` at most; the last estimate of the watched statistic.

    `estimate` and `half_width` are NaN before the first check, `seconds_left` if all of `total` are needed. `at` names
    the value of a sweep that the estimate is at, empty without one.
    """

    done: int
    total: int
    estimate: float
    half_width: float
    seconds_left: float
    at: str = ""


@dataclass
class Sampling:
    """The ensemble as it grows: how many are `done`, the `path` of (samples, estimate of them), why it ended."""

    study: Study
    task: Task
    progress: Callable[[Progress], None]
    began: float
    start: StudyResult | None = None
    keep: Callable | None = None
    path: list[tuple[int, Estimate]] = field(default_factory=list)
    stopped_because: str = "every quantity follows without sampling"
    notes: tuple[str, ...] = ()
    done: int = 0
    has_failed: bool = False

    def __post_init__(self):
        study, settings, start = self.study, self.study.settings, self.start
        self.points = UnitPoints(settings.sampler, study.joint.dimension, settings.seed, settings.samples)
        self.rule = settings.stop
        self.reasons = Tally(start.reasons if start else ())
        self.warnings = Tally(start.doubts_met if start else ())
        nothing = empty(self.task, 0)
        # Of the greatest length: pages that were not written to take no memory, and nothing is copied at the end.
        columns = (np.empty((0, len(study.inputs))), nothing.quantities, nothing.histories)
        columns += np.empty(0, np.int32), np.empty(0, np.int64)
        self._columns = [np.empty((self.points.samples, *column.shape[1:]), column.dtype) for column in columns]

    def draw(self, ensemble: Ensemble) -> None:
        """Samples up to the stop rule, the greatest number of samples, or a cancel."""
        settings, narrow, watched = self.study.settings, 0, self.study.quantities.index(self.rule.quantity)
        self.notes = (self.points.note,) if self.points.note else ()
        self.stopped_because = f"all {self.points.samples} samples are done"
        for size in checkpoints(self.points.samples, settings.batch, settings.stop.minimum, settings.sampler):
            if self.start is not None and self.done < (known := min(size, len(self.start.status))):
                start, rows = self.start, slice(self.done, known)
                columns = start.values, start.quantities, start.histories, start.status, start.doubtful
                self._add(*(column[rows] for column in columns))
            try:
                self._realise(ensemble, size)
            except StudyError as error:
                if not self.done:
                    raise
                self.stopped_because, self.has_failed = f"failed: {error}", True
                break
            if self.done < size:
                self.stopped_because = CANCELLED
                break
            sample = np.ascontiguousarray(self._columns[1][: self.done, watched])
            narrow = narrow + 1 if self._is_narrow(sample) else 0
            self.report(0)
            if narrow == IN_A_ROW:
                self.stopped_because = f"{self.rule.text()}, at {IN_A_ROW} checks in a row"
                break

    def _realise(self, ensemble, size) -> None:
        """Realisations up to number `size`, fewer when cancelled."""
        while self.done < size:
            first, count = self.done, min(size - self.done, DRAWN_TOGETHER)
            values = self.study.joint.values(self.points.chunk(first, count))
            for realised in ensemble.parts(
                values, lambda further, first=first: self.report(first + further - self.done)
            ):
                rows = len(realised.quantities)
                codes, bits = self.reasons.codes(rows, realised.failures), self.warnings.bits(rows, realised.warnings)
                self._add(values[self.done - first :][:rows], realised.quantities, realised.histories, codes, bits)
            if self.done < first + count:
                return

    def _add(self, *columns) -> None:
        first, self.done = self.done, self.done + len(columns[0])
        for values, column in zip(self._columns, columns, strict=True):
            values[first : self.done] = column
        if self.keep and len(columns[0]):
            self.keep(*columns, tuple(self.reasons.sentences), tuple(self.warnings.sentences))

    def arrays(self) -> tuple[np.ndarray, ...]:
        """Values (n, d), quantities (n, q), histories (n, h, points), status (n,) and warnings (n,) of all so far."""
        return tuple(values[: self.done] for values in self._columns)

    def _is_narrow(self, sample) -> bool:
        """Adds to the convergence path; True if the interval is narrow enough."""
        try:
            estimated = estimate(sample, self.rule.estimated, replicates=self.points.replicates)
        except StatisticError:
            return False
        self.path.append((len(sample), estimated))
        return self.rule.satisfied(estimated.value, estimated.half_width)

    @property
    def _total(self) -> int:
        """The greatest number of realisations of the study; of an expansion, what it may take."""
        settings, further = self.study.settings, self.study.sensitivity_rows * (self.study.joint.dimension + 2)
        return further + (MOST_RUNS if settings.method == "chaos" else self.points.samples)

    def report(self, further: int) -> None:
        """Reports progress: the samples that are done, and `further` realisations."""
        done, total, spent = self.done + further, self._total, time.monotonic() - self.began
        value, half_width = (self.path[-1][1].value, self.path[-1][1].half_width) if self.path else (np.nan, np.nan)
        self.progress(Progress(done, total, value, half_width, spent * (total - done) / max(done, 1)))


class Evaluator:
    """Values (n, d) of the inputs in, quantities (n, q) out, NaN where one fails; raises Stopped for a cancel."""

    def __init__(self, ensemble: Ensemble, study: Study, report: Callable[[int], None]):
        self._ensemble, self._study, self._report = ensemble, study, report
        self._known: dict[bytes, np.ndarray] = {}
        self.runs = 0

    def __call__(self, values: np.ndarray) -> np.ndarray:
        key = np.ascontiguousarray(values).tobytes()
        if key not in self._known:
            quantities = self._ensemble.evaluate(values, lambda further: self._report(self.runs + further)).quantities
            if len(quantities) < len(values):
                raise Stopped("the study was cancelled before all points had run")
            self.runs += len(quantities)
            self._known[key] = quantities
        return self._known[key]

    def function_of(self, name: str) -> Callable[[np.ndarray], np.ndarray]:
        """One quantity as a function of the inputs (n, d) -> (n,)."""
        column = self._study.quantities.index(name)
        return lambda values: self(values)[:, column]


def sources_of_variance(study: Study, evaluate: Evaluator) -> dict[str, dict]:
    """Sobol indices of every quantity by `settings.sensitivity` rows of samples: plain data, or why there are none."""
    settings, inputs = study.settings, study.joint.dimension
    design = UnitPoints(settings.sampler, 2 * inputs, settings.seed, settings.sensitivity)
    points = sensitivity_points(study.joint, design.chunk(0, design.samples))
    quantities = evaluate(study.joint.values(points.reshape(-1, inputs)))
    result: dict[str, dict] = {}
    for column, name in enumerate(study.quantities):
        try:
            values = quantities[:, column].reshape(-1, inputs + 2)
            result[name] = sobol_summary(sobol_indices(values, study.joint.keys, design.replicates))
        except StatisticError as error:
            result[name] = {"refused": str(error)}
    return result


TABLES = 2**17  # numbers of tables of quantiles and of summaries
WORKING_COPIES = 8  # of one column, while its statistics are made
FINITE = 1.125  # histories, and a byte a number that says whether it is one
BLOCKS = 4  # of HISTORIES_AT_ONCE, while products of them are summed
SENSITIVITY_COPIES = 5  # of one quantity at the points of Sobol indices, while these are made
# Keys that must be the same where the samples of an earlier result are reused.
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
    """Runs a study; its numbers follow from study and seed alone.

    Parameters
    ----------
    study : Study, str, path or mapping
        A study, or the name, path or plain data of one.
    progress : function, optional
        Called with a `Progress` after every batch and every few realisations, from this thread.
    cancelled : threading.Event or function, optional
        Once true the study ends within half a second with what is done; statistics not made yet are then those of the
        first samples, which a note says.
    start : StudyResult, optional
        An earlier result of the same study with fewer samples, which are kept; the result equals that of one run.
    keep : function, optional
        Called with (values, quantities, histories, status, doubtful, reasons, doubts) of realisations as they come.

    Returns
    -------
    StudyResult
        `values` (n, d) and `quantities` (n, q) are arrays [SI], `as_dict()` the summary, `to_csv(path)` the table.

    Raises
    ------
    StudyError
        For a study too large for its memory, a method that does not fit it, or a `start` of another study.
    """
    began = time.monotonic()
    if progress is not None and not callable(progress):
        raise StudyError(progress_error(progress, "load_study"))
    if not (cancelled is None or callable(cancelled) or hasattr(cancelled, "is_set")):
        raise StudyError(f"cancelled = {echo(cancelled)} must be a function or a threading.Event")
    if not isinstance(start, StudyResult | None):
        raise StudyError(f"start = {echo(start)} must be the result of a study, as run_study or read_study gives it")
    study = study if isinstance(study, Study) else load_study(study)
    is_cancelled = getattr(cancelled, "is_set", cancelled) or (lambda: False)
    report = progress or (lambda _: None)
    parts = 1 if study.sweep is None else 1 + len(study.sweep[1])
    refuse_too_large(study)
    if start is not None:
        _refuse_another_study(study, start)
    task = task_of(study)
    exact = exact_distributions(study, task, study.settings.method)
    sampled = [name for name in study.quantities if name not in exact]

    sampling = Sampling(study, task, _progress_of_part(report, 0, parts, began), began, start, keep)
    model, at_mean, propagated, sobol = no_model_errors(NOT_CHECKED), empty(task, 0), exact, {}
    missing = {name: missing_moments(study, task, name) for name in sampled} if task.closed else {}
    with stop_condition(is_cancelled), Ensemble(task, study.settings.workers, study.executor, is_cancelled) as ensemble:
        evaluate = Evaluator(ensemble, study, sampling.report)
        try:
            propagated = exact | _propagate(study, ensemble, evaluate, sampling, len(sampled))
            if not sampling.has_failed:
                if not task.closed:
                    missing = {name: missing_moments(study, task, name, evaluate.function_of(name)) for name in sampled}
                sobol = sources_of_variance(study, evaluate) if study.settings.sensitivity else {}
        except Stopped:
            sampling.stopped_because = CANCELLED
        if not (is_cancelled() or sampling.has_failed):
            at_mean = ensemble.evaluate(mean_inputs(study))
            with contextlib.suppress(Stopped):
                model = model_errors(study, task, ensemble, *sampling.arrays()[:2], sampling.warnings.sentences)
    values, quantities, histories, status, doubtful = sampling.arrays()
    sentences = tuple(sampling.reasons.sentences), tuple(sampling.warnings.sentences)
    result = StudyResult(study, values, quantities, histories, status, sentences[0], doubtful, sentences[1], {})
    summary = summary_of(is_cancelled, result, propagated, missing, sampling, at_mean, model)
    for name, indices in sobol.items():
        summary["quantities"][name]["sobol"] = indices
    if study.sweep is not None:
        summary["sweep"] = _sweep_summary(study, report, is_cancelled, began)
    summary["seconds"] = time.monotonic() - began
    return dataclasses.replace(result, summary=summary)


def _propagate(study, ensemble, evaluate, sampling, sampled_quantities: int) -> dict:
    """Expansions by quantity; the ensemble goes into `sampling`."""
    propagated = {}
    if study.settings.method == "chaos":
        degree = study.settings.degree or None
        propagated = {name: expand(study.joint, evaluate.function_of(name), degree) for name in study.quantities}
        sampling.stopped_because = f"{evaluate.runs} runs for polynomial chaos are done"
    elif study.histories or sampled_quantities:
        sampling.draw(ensemble)
        if sampling.stopped_because == CANCELLED:
            raise Stopped
    return propagated


def memory_needed(study: Study) -> float:
    """Bytes of the arrays a study fills, at its greatest number of samples."""
    settings, histories = study.settings, len(study.histories) * study.settings.history_points
    inputs, quantities = len(study.inputs), len(study.quantities)
    row = inputs + quantities + FINITE * histories + 2.0 + WORKING_COPIES
    rows = study.sensitivity_rows
    # Their points are held three times: in the unit cube, as values, and as the key by which they are found again.
    further = rows * (inputs + 2) * (3.0 * inputs + quantities + SENSITIVITY_COPIES)
    columns = settings.samples * 2 * INSTANTS_AT_ONCE if study.histories else 0.0
    columns += BLOCKS * HISTORIES_AT_ONCE * settings.history_points if study.histories else 0.0
    return 8.0 * (settings.samples * row + further + columns + TABLES)


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
    for resolved in (old, new):  # a description may change without a change of the samples
        resolved["scene"] = resolved["scene"] | {"description": ""}
    differing = [key for key in SAME if old[key] != new[key]]
    if differing:
        raise StudyError(
            f"the samples to go on from belong to a study with another {differing[0]}; run this one from the beginning"
        )
    if not SAMPLERS[study.settings.sampler].grows and study.settings.samples != start.study.settings.samples:
        raise StudyError("a latin hypercube has a fixed size and cannot be continued; use sobol or random")


def _progress_of_part(report, index, parts, began, at=""):
    """Progress of one of `parts` studies of the same size as that of all of them, `began` at a monotonic time."""

    def report_part(progress: Progress) -> None:
        done, total = progress.done + index * progress.total, parts * progress.total
        seconds_left = (time.monotonic() - began) * (total - done) / max(done, 1)
        report(progress._replace(done=done, total=total, seconds_left=seconds_left, at=at))

    return report if parts == 1 else report_part


def _sweep_summary(study, report, is_cancelled, began) -> dict:
    """The summaries at each value of a sweep, one study each, by the same method and seed."""
    key, values = study.sweep
    studies = []
    for index, value in enumerate(values, start=1):
        if is_cancelled():
            break
        part = _progress_of_part(report, index, 1 + len(values), began, f"{key} = {value:g}")
        summary = run_study(study.at_sweep_value(value), part, is_cancelled).summary
        studies.append({"value": value, "samples": summary["samples"], "quantities": summary["quantities"]})
    return {**sweep_head(study), "studies": studies}
