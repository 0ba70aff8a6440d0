"""A study in, its result out: which method for which quantity, the ensemble in batches, the stop rule, the summary."""

import dataclasses
import time
from collections.abc import Callable

import numpy as np

from bearing_twin.errors import BearingTwinError, StatisticError, StudyError
from bearing_twin.run.simulation import simulate
from bearing_twin.uq.change_of_variable import Derived
from bearing_twin.uq.chaos import Chaos
from bearing_twin.uq.drawing import Drawn, Progress
from bearing_twin.uq.ensemble import Ensemble
from bearing_twin.uq.evaluation import (
    Cancelled,
    Evaluator,
    expansions,
    interpolations,
    sources_of_variance,
    summary_of_chaos,
    summary_of_interpolated,
)
from bearing_twin.uq.histories import COLUMNS, Histories
from bearing_twin.uq.interpolation import Interpolated
from bearing_twin.uq.narrowing import RESAMPLES, narrowing
from bearing_twin.uq.propagation import exact_distributions, mean_inputs, missing_moments, task_of
from bearing_twin.uq.realise import empty
from bearing_twin.uq.result import StudyResult, summary_of_derived, summary_of_sample
from bearing_twin.uq.sampling import SAMPLERS
from bearing_twin.uq.statistics import half_width
from bearing_twin.uq.study import Study

CORRELATED = 41  # instants of the autocorrelation in a summary
WORKING_COPIES = 8  # of one column, while its statistics are made
SENSITIVITY_COPIES = 5  # of one quantity at the points of Sobol indices, while these are made
POOR = 0.01  # error of an interpolant that is told
# What must be the same where samples are taken over from an earlier result.
SAME = (
    "scene", "inputs", "correlation", "quantities", "histories", "history_points", "history_duration",
    "sampler", "seed",
)  # fmt: skip


def run_study(
    study: Study,
    progress: Callable[[Progress], None] | None = None,
    cancelled=None,
    start: StudyResult | None = None,
    keep: Callable | None = None,
) -> StudyResult:
    """Runs a study; the same study and seed give the same numbers whatever the number of workers.

    `progress` is called after every batch and every few realisations, from this thread. `cancelled` is a
    threading.Event or a function: once true the study ends within half a second with what is done, besides the time
    the statistics of it take (a second for two million samples). `start` is an earlier result of the same study with
    fewer samples, which are kept; the result equals that of one run. `keep(values, quantities, histories, status,
    doubtful, reasons, doubts)` is handed every realisation as soon as it is there, in order. Raises StudyError for a
    study too large for its memory, a method that does not fit it, or a `start` of another study.
    """
    began = time.monotonic()
    asked = getattr(cancelled, "is_set", cancelled) or (lambda: False)
    tell = progress or (lambda _: None)
    parts = 1 if study.sweep is None else 1 + len(study.sweep[1])
    refuse_too_large(study)
    if start is not None:
        _refuse_another_study(study, start)
    task = task_of(study)
    exact = exact_distributions(study, task, study.settings.method)
    drawn = Drawn(study, task, _part(tell, 0, parts), asked, began, keep)
    with Ensemble(task, study.settings.workers, study.executor, asked) as ensemble:
        expanded, sources = _propagate(study, ensemble, drawn, start, sampled=len(exact) < len(study.quantities))
        at_mean = empty(task, 0) if asked() or drawn.broken else ensemble.evaluate(mean_inputs(study))
    values, quantities, histories, status, doubtful = drawn.arrays()
    result = StudyResult(
        study, values, quantities, histories,
        status, tuple(drawn.reasons.sentences), doubtful, tuple(drawn.doubts.sentences), {},
    )  # fmt: skip
    summary = _summary(result, task, exact | expanded, drawn, at_mean)
    for name, found in sources.items():
        summary["quantities"][name]["sobol"] = found
    if study.sweep is not None:
        summary["sweep"] = _sweep(study, tell, asked)
    summary["seconds"] = time.monotonic() - began
    return dataclasses.replace(result, summary=summary)


def memory_needed(study: Study) -> float:
    """Bytes of the arrays a study fills, at its greatest number of samples."""
    settings, histories = study.settings, len(study.histories) * study.settings.history_points
    inputs, quantities = len(study.inputs), len(study.quantities)
    row = 2.0 * (inputs + quantities + histories + 2) + WORKING_COPIES  # twice: pieces of a batch are joined
    rows = study.sensitivity_rows
    # Their points are kept three times: in the unit cube, as values, and as the key by which they are found again.
    further = rows * (inputs + 2) * (3.0 * inputs + quantities + SENSITIVITY_COPIES)
    sums = len(study.histories) * settings.history_points**2
    columns = settings.samples * (2 * COLUMNS + RESAMPLES / 8) if study.histories else 0.0
    return 8.0 * (settings.samples * row + further + sums + columns)


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


def _part(tell, place, parts):
    """Progress of one of `parts` studies of the same size, told as that of all of them."""
    return lambda one: tell(one._replace(done=one.done + place * one.total, total=parts * one.total))


def _sweep(study, tell, asked) -> dict:
    """The summaries at each value of a sweep, one study each, by the same method and seed."""
    key, values = study.sweep
    found = []
    for place, value in enumerate(values, start=1):
        if asked():
            break
        summary = run_study(study.at(value), _part(tell, place, 1 + len(values)), asked).summary
        found.append({"value": value, "samples": summary["samples"], "quantities": summary["quantities"]})
    return {"key": key, "studies": found}


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
    except Cancelled:
        drawn.because = "cancelled"
    return expanded, sources


def _summary(result, task, without_sampling, drawn, at_mean) -> dict:
    """The plain data of the result, without seconds."""
    study, settings = result.study, result.study.settings
    quantities = {}
    for column, (name, unit) in enumerate(result.quantity_units.items()):
        one = {"unit": unit, **_of_quantity(result, task, name, drawn, without_sampling.get(name))}
        value = at_mean.quantities[0, column] if len(at_mean.quantities) else np.nan
        quantities[name] = {**one, "at_mean_inputs": float(value) if np.isfinite(value) else None}
    return {
        "study": study.name,
        "scene": study.scene["name"],
        "inputs": {one.key: one.describe() for one in study.inputs},
        "quantities": quantities,
        "samples": len(result.status),
        "failed": {text: int(np.sum(result.status == 1 + place)) for place, text in enumerate(result.reasons)},
        "failed_share": float(np.mean(result.status > 0)) if len(result.status) else 0.0,
        "seed": settings.seed,
        "sampler": settings.sampler,
        "stopped_because": drawn.because,
        "convergence": _convergence(drawn.rule, drawn.path),
        "histories": _histories(result, task, at_mean),
        "doubts": {text: int(np.sum(result.doubtful >> place & 1)) for place, text in enumerate(result.doubts_met)},
        "notes": [*drawn.notes, *_poor_interpolants(without_sampling), *_flags_at_mean(study, task)],
    }


def _of_quantity(result, task, name, drawn, found) -> dict:
    """What is known of a quantity by its distribution, its expansion, or its sample."""
    wanted = result.study.densities.get(name, ())
    if isinstance(found, Derived):
        return {"method": "change_of_variable", **summary_of_derived(found, wanted), "half_width": 0.0}
    if isinstance(found, Interpolated):
        return {"method": "change_of_variable", **summary_of_interpolated(found, wanted)}
    missing = missing_moments(result.study, task, name)
    if isinstance(found, Chaos):
        return {"method": "chaos", **summary_of_chaos(result.study, found, missing, wanted)}
    return {"method": "ensemble", **_of_sample(result, missing, name, drawn)}


def _poor_interpolants(found) -> list[str]:
    return [
        f"{name}: the polynomial misses runs by {one.error:.2g} of the deviation; the method ensemble needs none"
        for name, one in found.items()
        if isinstance(one, Interpolated) and one.error > POOR
    ]


def _of_sample(result, missing, name, drawn) -> dict:
    settings, rule, replicates = result.study.settings, drawn.rule, drawn.points.replicates
    sample = result.sample(name)
    modes = settings.modality == "yes" and not drawn.asked()
    found = summary_of_sample(sample, missing, replicates, settings.seed, modes, result.study.densities.get(name, ()))
    statistic = rule.asked if name == rule.quantity else "mean"
    width = np.inf if statistic in missing else half_width(sample, statistic, replicates=replicates)
    return {**found, "half_width": width if np.isfinite(width) else None}


def _convergence(rule, path) -> dict:
    """The path of the watched statistic over the samples, as in figures 9 and 14 of paper 3."""
    columns = list(zip(*path, strict=True)) or [(), (), ()]
    return {
        "quantity": rule.quantity,
        "statistic": rule.statistic,
        **({"probability": rule.probability} if rule.statistic == "quantile" else {}),
        "tolerance": rule.tolerance or None,
        "relative_tolerance": rule.relative_tolerance or None,
        **{name: list(column) for name, column in zip(("samples", "estimate", "half_width"), columns, strict=True)},
    }


def _histories(result, task, at_mean) -> dict:
    """Bands of each history over the realisations that did not fail, and the run at the mean inputs beside them."""
    bands_of = {}
    for place, channel in enumerate(result.study.histories):
        found, bands = history_statistics(result, channel, task.instants), {}
        if found.count > 1:
            bands = {"mean": found.mean, "std": found.std, "skewness": found.skewness}
            bands |= dict(zip(("0.05", "0.50", "0.95"), found.quantiles(), strict=True))
            for key, row in zip(result.study.joint.keys, found.input_correlation(), strict=True):
                bands[f"correlation with {key}"] = np.where(np.isfinite(row), row, 0.0)
        if len(at_mean.histories):
            bands["at_mean_inputs"] = at_mean.histories[0, place]
        bands_of[channel] = {"time_s": task.instants.tolist()} | {name: one.tolist() for name, one in bands.items()}
        if found.count > 1:
            bands_of[channel] |= _between_instants(found) | _narrowing(found, result.study)
    return bands_of


def _between_instants(found) -> dict:
    """The autocorrelation at up to CORRELATED instants, evenly chosen; 0 where histories do not differ."""
    rows = np.arange(0, len(found.times), max(1, -(-len(found.times) // CORRELATED)))
    table = found.autocorrelation()[np.ix_(rows, rows)]
    return {
        "autocorrelation_time_s": found.times[rows].tolist(),
        "autocorrelation": np.where(np.isfinite(table), table, 0.0).tolist(),
    }


def _narrowing(histories, study) -> dict:
    """Where the histories come together after their peak; nothing where they do not."""
    try:
        found = narrowing(histories.times, histories.whole, study.settings.seed, histories.inputs)
    except StatisticError:
        return {}
    signs = {
        key: {"time_s": one.time, "later_s": one.later, "interval_s": [one.low, one.high]}
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
    """Everything `histories` knows of one channel: also its autocorrelation and its density over time."""
    return Histories(instants, result.history(channel), result.values)


def _flags_at_mean(study, task) -> list[str]:
    """What is doubtful about the scene at its mean inputs, where closed forms say nothing of it."""
    if not task.closed:
        return []
    try:
        run = simulate(study.scene_at(mean_inputs(study)[0]))
        for _ in run.blocks():
            pass
    except BearingTwinError as error:
        return [f"at the mean inputs there is no run: {error}"]
    return [f"at the mean inputs {flag}" for flag in run.report.flags]
