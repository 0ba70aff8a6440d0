"""A study: the ensemble in batches, the stop rule, propagation by the method of each quantity, and the summary."""

import contextlib
import dataclasses
import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import StatisticError, Stopped, StudyError
from bearing_twin.base.messages import no_progress
from bearing_twin.base.stopping import heeding, look
from bearing_twin.base.units import with_unit
from bearing_twin.kinds.doubt import METHOD
from bearing_twin.run.report import LARGE, exceeds
from bearing_twin.uq.distributions import numbers_kept
from bearing_twin.uq.histories import COLUMNS, RESAMPLES, ROWS
from bearing_twin.uq.inputs import quantity_of
from bearing_twin.uq.propagation import LADDER, MOST_RUNS, Chaos, Interpolated, expand, interpolate
from bearing_twin.uq.realisations import (
    Realised,
    Task,
    along,
    empty,
    exact_distributions,
    mean_inputs,
    missing_moments,
    task_of,
    uncertain_inputs,
    without_numbers,
)
from bearing_twin.uq.result import OUT_OF_TIME, StudyResult, Tally, sweep_head
from bearing_twin.uq.sampling import SAMPLERS, UnitPoints
from bearing_twin.uq.statistics import Estimate, estimate, sensitivity_points, sobol_indices
from bearing_twin.uq.study import IN_A_ROW, Study, load_study, looks, rule_of
from bearing_twin.uq.summary import sobol_summary, summary_of
from bearing_twin.uq.workers import Ensemble

CANCELLED = "cancelled"  # why an ensemble ended
PIECE = 16384  # points drawn at once, so that a cancel need not wait for a whole batch


class Progress(NamedTuple):
    """How far a study is: realisations `done` of `total` at most; the watched statistic as last looked at.

    `estimate` and `half_width` are NaN before the first look, `seconds_left` if all of `total` are needed. `at` names
    the value of a sweep that the estimate is at, empty without one.
    """

    done: int
    total: int
    estimate: float
    half_width: float
    seconds_left: float
    at: str = ""


@dataclass
class Drawn:
    """The ensemble as it grows: how many are `done`, the `path` of (samples, estimate of them), why it ended."""

    study: Study
    task: Task
    progress: Callable[[Progress], None]
    asked: Callable[[], bool]
    began: float
    keep: Callable | None = None
    path: list[tuple[int, Estimate]] = field(default_factory=list)
    because: str = "every quantity follows without sampling"
    notes: tuple[str, ...] = ()
    done: int = 0
    broken: bool = False

    def __post_init__(self):
        study, settings = self.study, self.study.settings
        self.points = UnitPoints(settings.sampler, study.joint.dimension, settings.seed, settings.samples)
        self.rule = rule_of(settings.stop, study.stop_quantity)
        self.reasons, self.doubts = Tally(), Tally()
        nothing = empty(self.task, 0)
        # As long as it may become: pages that nothing was written to take no memory, and nothing is joined at the end.
        columns = (np.empty((0, len(study.inputs))), nothing.quantities, nothing.histories)
        columns += np.empty(0, np.int32), np.empty(0, np.int64)
        self._columns = [np.empty((self.points.samples, *one.shape[1:]), one.dtype) for one in columns]

    def draw(self, ensemble: Ensemble, start: StudyResult | None) -> None:
        """Samples up to the stop rule, the greatest number of samples, or a cancel."""
        settings, self._watched = self.study.settings, np.empty(self.points.samples)
        self.notes = (self.points.note,) if self.points.note else ()
        self.because = f"all {self.points.samples} samples are done"
        narrow = 0
        for size in looks(self.points.samples, settings.batch, settings.stop.minimum, settings.sampler):
            known = 0 if start is None else min(size, len(start.status)) - self.done
            if known > 0:
                self._take_over(start, self.done + known)
            try:
                if self.done < size:
                    self._realise(ensemble, size)
            except StudyError as error:
                if not self.done:
                    raise
                self.because, self.broken = f"failed: {error}", True
                break
            if self.done < size:
                self.because = CANCELLED
                break
            narrow = narrow + 1 if self._look(self._watched[: self.done]) else 0
            self._tell(self.done)
            if narrow == IN_A_ROW:
                self.because = f"{self.rule.text()}, at {IN_A_ROW} looks in a row"
                break

    def _realise(self, ensemble, size) -> None:
        """Realisations up to number `size`, fewer when cancelled."""
        while self.done < size:
            first, wanted = self.done, min(size - self.done, PIECE)
            values = self.study.joint.values(self.points.chunk(first, wanted))
            for found in ensemble.parts(values, lambda more, first=first: self._tell(first + more)):
                count = len(found.quantities)
                self._add(
                    values[self.done - first :][:count],
                    found.quantities,
                    found.histories,
                    self.reasons.codes(count, found.failures),
                    self.doubts.bits(count, found.doubts),
                )
            if self.done < first + wanted:
                return

    def _take_over(self, start, size) -> None:
        """Realisations of an earlier result, up to number `size`."""
        rows = slice(self.done, size)
        codes, bits = start.status[rows], start.doubtful[rows]
        failures = {int(row): start.reasons[codes[row] - 1] for row in np.flatnonzero(codes)}
        doubts = {
            int(row): tuple(text for place, text in enumerate(start.doubts_met) if int(bits[row]) >> place & 1)
            for row in np.flatnonzero(bits)
        }
        self._add(
            start.values[rows],
            start.quantities[rows],
            start.histories[rows],
            self.reasons.codes(len(codes), failures),
            self.doubts.bits(len(codes), doubts),
        )

    def _add(self, *columns) -> None:
        first, self.done = self.done, self.done + len(columns[0])
        for whole, column in zip(self._columns, columns, strict=True):
            whole[first : self.done] = column
        self._watched[first : self.done] = columns[1][:, self.study.quantities.index(self.rule.quantity)]
        if self.keep and len(columns[0]):
            self.keep(*columns, tuple(self.reasons.sentences), tuple(self.doubts.sentences))

    def arrays(self) -> tuple[np.ndarray, ...]:
        """Values (n, d), quantities (n, q), histories (n, h, points), status (n,) and doubts (n,) of all so far."""
        return tuple(whole[: self.done] for whole in self._columns)

    def _look(self, sample) -> bool:
        """Adds to the convergence path; whether the interval is narrow enough."""
        try:
            found = estimate(sample, self.rule.asked, replicates=self.points.replicates)
        except StatisticError:
            return False
        self.path.append((len(sample), found))
        return self.rule.bounds and self.rule.satisfied(found.value, found.half_width)

    def tell_more(self, done: int) -> None:
        """Progress of further realisations, for a purpose of their own: `done` of them."""
        self._tell(self.done + done)

    @property
    def _total(self) -> int:
        """The greatest number of realisations of the study; of an expansion and an interpolant, what they may take."""
        settings = self.study.settings
        further = self.study.sensitivity_rows * (self.study.joint.dimension + 2)
        if settings.method == "chaos":
            return further + MOST_RUNS
        interpolated = settings.method == "change_of_variable" and not self.study.histories
        return further + (LADDER[-1] if interpolated else self.points.samples)

    def _tell(self, done) -> None:
        total, spent = self._total, time.monotonic() - self.began
        found = self.path[-1][1] if self.path else None
        value, half_width = (found.value, found.half_width) if found else (np.nan, np.nan)
        self.progress(Progress(done, total, value, half_width, spent * (total - done) / max(done, 1)))


class Evaluator:
    """Values (n, d) of the inputs in, quantities (n, q) out, NaN where one fails; raises Stopped for a cancel."""

    def __init__(self, ensemble: Ensemble, study: Study, tell: Callable[[int], None]):
        self._ensemble, self._study, self._tell = ensemble, study, tell
        self._known: dict[bytes, np.ndarray] = {}
        self.runs = 0

    def __call__(self, values: np.ndarray) -> np.ndarray:
        key = np.ascontiguousarray(values).tobytes()
        if key not in self._known:
            found = self._ensemble.evaluate(values, lambda more: self._tell(self.runs + more)).quantities
            if len(found) < len(values):
                raise Stopped("the study was cancelled before all points had run")
            self.runs += len(found)
            self._known[key] = found
        return self._known[key]

    def of(self, name: str) -> Callable[[np.ndarray], np.ndarray]:
        """One quantity as a function of the inputs (n, d) -> (n,)."""
        column = self._study.quantities.index(name)
        return lambda values: self(values)[:, column]


def interpolations(study: Study, evaluate: Evaluator) -> dict[str, Interpolated]:
    """The distribution of every quantity by an interpolant; raises StudyError where a quantity does not allow it."""
    (place,) = uncertain_inputs(study)
    found = {}
    for name in study.quantities:
        try:
            found[name] = interpolate(study.inputs[place], along(study, place, evaluate.of(name)))
        except StudyError as error:
            raise StudyError(f"{name}: {error}") from error
    return found


def sources_of_variance(study: Study, evaluate: Evaluator) -> dict[str, dict]:
    """Sobol indices of every quantity by `settings.sensitivity` rows of samples: plain data, or why there are none."""
    settings, inputs = study.settings, study.joint.dimension
    design = UnitPoints(settings.sampler, 2 * inputs, settings.seed, settings.sensitivity)
    points = sensitivity_points(study.joint, design.chunk(0, design.samples))
    found = evaluate(study.joint.values(points.reshape(-1, inputs)))
    result: dict[str, dict] = {}
    for column, name in enumerate(study.quantities):
        try:
            indices = sobol_indices(found[:, column].reshape(-1, inputs + 2), replicates=design.replicates)
            result[name] = sobol_summary(study.joint.keys, indices)
        except StatisticError as error:
            result[name] = {"refused": str(error)}
    return result


# Errors of the model are kept apart from those of sampling. They come from a few realisations that are checked by a
# second run: those in which the quantities are least, greatest and in the middle, the watched quantity first; without a
# sample those at the medians of the inputs and at their ends. The greatest error of each source stands for all, and the
# sum of the sources for the model.

OF_INPUTS = 0.5, 0.05, 0.95  # where realisations lie without a sample: this quantile of all inputs at once
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


def model_errors(
    study: Study, task: Task, ensemble: Ensemble, values: np.ndarray, quantities: np.ndarray, doubts: Iterable[str] = ()
) -> ModelErrors:
    """Errors of the study's quantities, by its sample `values` (n, d) and `quantities` (n, q), or without one.

    `doubts` are the warnings of the sample; those of checked realisations alone are in the notes.
    """
    count = study.settings.checks
    if not count:
        return no_model_errors("checks: 0, so the error of the model is not known")
    rows = chosen(quantities, study.quantities.index(study.stop_quantity), count)
    ends = np.repeat(np.array(OF_INPUTS)[:, None], study.joint.dimension, axis=1)[:count]
    at, where = (values[rows], SAMPLED) if rows else (study.joint.values(ends), GIVEN)
    found = ensemble.evaluate(at, task=task._replace(closed=False, checked=True))
    if len(found.quantities) < len(at):
        return no_model_errors(NOT_CHECKED)
    of, checks = _gathered(study, found)
    return ModelErrors(of, checks | {"where": where}, [*_large(study, of, found.quantities), *_doubted(found, doubts)])


def _gathered(study: Study, found: Realised) -> tuple[dict, dict]:
    """The greatest error by source of each quantity, and what is not known."""
    of, unknown = {}, {}
    for one in found.errors.values():
        unknown.update(one.unknown)
    for name in study.quantities:
        parts: dict[str, float] = {}
        for one in found.errors.values():
            for source, error in one.of[name].items():
                parts[source] = max(parts.get(source, 0.0), error)
        known = {source: error for source, error in parts.items() if math.isfinite(error)}
        of[name] = {"error": math.fsum(known.values()) if known else None, "errors_by_source": known}
        if len(known) < len(parts):
            unknown[name] = "a figure that it is read off has no bound of its error"
    return of, {"realisations": len(found.errors), "failed": len(found.failures), "errors_unknown": unknown}


def _doubted(found: Realised, doubts: Iterable[str]) -> Iterator[str]:
    """A sentence for each kind of warning of checked realisations alone, with their number."""
    known, tally = set(map(without_numbers, doubts)), Tally()
    bits = tally.bits(len(found.quantities), found.doubts)
    for place, sentence in enumerate(tally.sentences):
        if without_numbers(sentence) not in known:
            yield f"{int(np.sum(bits >> place & 1))} of {len(found.errors)} checked realisations: {sentence}"


def _large(study: Study, of: Mapping[str, dict], quantities: np.ndarray) -> Iterator[str]:
    """A sentence for each quantity whose error is over a tenth of it."""
    for column, name in enumerate(study.quantities):
        error, known = of[name]["error"], quantities[np.isfinite(quantities[:, column]), column]
        if error is not None and len(known) and exceeds(known.tolist(), error):
            parts, unit = of[name]["errors_by_source"], with_unit(quantity_of(study.kind, name).unit)
            yield (
                f"{name}: the error of the model is {error:.2g}{unit}, over {100.0 * LARGE:g} % of it, mostly "
                f"{max(parts, key=parts.get).replace('_', ' ')}: no sampling makes it smaller"
            )


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
    """Runs a study; its numbers follow from study and seed alone.

    Parameters
    ----------
    study
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
        For a study too large for its memory, a method that does not fit it, a `start` of another study, or a time limit
        that no realisation meets.
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
    sampled = [name for name in study.quantities if name not in exact]

    def ends() -> bool:
        return asked() or time.monotonic() - began > limit

    drawn = Drawn(study, task, _part(tell, 0, parts, began), ends, began, keep)
    model = no_model_errors(NOT_CHECKED)
    at_mean, expanded, sources, missing = empty(task, 0), {}, {}, {}
    if task.closed:
        missing = {name: missing_moments(study, task, name) for name in sampled}
    with heeding(ends), Ensemble(task, study.settings.workers, study.executor, ends) as ensemble:
        evaluate = Evaluator(ensemble, study, drawn.tell_more)
        try:
            expanded = _propagate(study, ensemble, evaluate, drawn, start, exact)
            if not drawn.broken:
                if not task.closed:
                    missing = {name: missing_moments(study, task, name, evaluate.of(name)) for name in sampled}
                sources = sources_of_variance(study, evaluate) if study.settings.sensitivity else {}
        except Stopped:
            drawn.because = CANCELLED
        if not (ends() or drawn.broken):
            at_mean = ensemble.evaluate(mean_inputs(study))
            with contextlib.suppress(Stopped):
                model = model_errors(study, task, ensemble, *drawn.arrays()[:2], drawn.doubts.sentences)
    if drawn.because == CANCELLED and not asked():
        because = f"{study.settings.time_limit:g} s was reached"
        if not (drawn.done or exact or expanded):
            raise StudyError(f"study {study.name}: its time_limit of {because} before a realisation was done; raise it")
        drawn.because = f"{OUT_OF_TIME}{because}"
    values, quantities, histories, status, doubtful = drawn.arrays()
    result = StudyResult(
        study, values, quantities, histories,
        status, tuple(drawn.reasons.sentences), doubtful, tuple(drawn.doubts.sentences), {},
    )  # fmt: skip
    summary = summary_of(result, missing, task, exact | expanded, drawn, (at_mean, model), asked)
    for name, found in sources.items():
        summary["quantities"][name]["sobol"] = found
    if study.sweep is not None:
        summary["sweep"] = _sweep(study, tell, ends, began)
    summary["seconds"] = time.monotonic() - began
    return dataclasses.replace(result, summary=summary)


def _propagate(study, ensemble, evaluate, drawn, start, exact) -> dict:
    """Expansions or interpolants by quantity; the ensemble goes into `drawn`."""
    method, sampled = study.settings.method, len(exact) < len(study.quantities)
    found: dict[str, Chaos | Interpolated] = {}
    if method == "chaos":
        degree, seed = study.settings.degree or None, study.settings.seed
        found = {name: expand(study.joint, evaluate.of(name), degree, seed=seed) for name in study.quantities}
        drawn.because = f"{evaluate.runs} runs for polynomial chaos are done"
    elif method == "change_of_variable" and sampled:
        found = interpolations(study, evaluate)
        drawn.because = f"{evaluate.runs} runs for an interpolant are done"
    if study.histories or (sampled and not found):
        drawn.draw(ensemble, start)
        if drawn.because == CANCELLED:
            raise Stopped
    return found


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
        raise StudyError("a latin hypercube has a fixed size and cannot be continued; use sobol or random")


def _part(tell, place, parts, began, at=""):
    """Progress of one of `parts` studies of the same size as that of all of them, `began` at a monotonic time."""

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
