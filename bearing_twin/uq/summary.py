"""What a study found as plain data: statistics of every quantity and history, failures, doubts and notes."""

import dataclasses
from collections.abc import Callable

import numpy as np

from bearing_twin.errors import BearingTwinError, StatisticError, Stopped
from bearing_twin.run.passes import simulate
from bearing_twin.stopping import heeding, look
from bearing_twin.uq.change_of_variable import Derived
from bearing_twin.uq.chaos import Chaos
from bearing_twin.uq.drawing import OUT_OF_TIME, Drawn
from bearing_twin.uq.evaluation import summary_of_chaos, summary_of_interpolated
from bearing_twin.uq.histories import Histories
from bearing_twin.uq.interpolation import Interpolated
from bearing_twin.uq.model_error import ModelErrors
from bearing_twin.uq.narrowing import narrowing
from bearing_twin.uq.propagation import mean_inputs
from bearing_twin.uq.realise import Realised, Task
from bearing_twin.uq.result import StudyResult, finite, summary_of_derived, summary_of_sample
from bearing_twin.uq.statistics import MORE, half_width

CORRELATED = 41  # instants of the autocorrelation in a summary
POOR = 0.01  # error of an interpolant that is told
AT_CANCEL = 8192  # numbers of a quantity and its histories whose statistics a cancelled study makes: 0.1 s
INSTANT = 0.125  # of what a sample takes is what an instant of a history takes in these


def summary_of(
    result: StudyResult,
    missing: dict,
    task: Task,
    without_sampling: dict,
    drawn: Drawn,
    beside: tuple[Realised, ModelErrors],
    asked: Callable[[], bool],
) -> dict:
    """The plain data of a result, without seconds.

    `missing` names the moments that do not exist, by quantity, `without_sampling` what is known of quantities without
    a sample; `beside` the sample are the realisation at the mean inputs, or none, and the errors of the model. Once
    `asked()` is true, what is not made yet is made of the first samples, and a note says so.
    """
    study, settings = result.study, result.study.settings
    (at_mean, worth), quantities = beside, {}
    pressed = _Pressed(result, asked)
    for column, (name, unit) in enumerate(result.quantity_units.items()):
        found = pressed.made(name, _of_quantity, missing.get(name, {}), name, drawn, without_sampling.get(name))
        one = {"unit": unit, **found}
        value = at_mean.quantities[0, column] if len(at_mean.quantities) else np.nan
        one["at_mean_inputs"] = float(value) if np.isfinite(value) else None
        quantities[name] = one | worth.for_quantity(name)
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
        "companions": worth.companions,
        "stopped_because": drawn.because,
        "convergence": _convergence(drawn.rule, drawn.path),
        "histories": {
            channel: pressed.made(channel, _of_history, channel, task, at_mean.histories[:, place])
            for place, channel in enumerate(study.histories)
        },
        "doubts": {text: int(np.sum(result.doubtful >> place & 1)) for place, text in enumerate(result.doubts_met)},
        "notes": [
            *drawn.notes,
            *_poor_interpolants(without_sampling),
            *worth.notes,
            *_flags_at_mean(study, task, asked),
            *pressed.notes(),
        ],
    }


def _first(result: StudyResult) -> StudyResult:
    """The result with its first samples only, a power of two of them, whose statistics take no time to speak of."""
    room = AT_CANCEL / (1.0 + INSTANT * len(result.study.histories) * result.study.settings.history_points)
    if len(result.status) <= room:
        return result
    first = slice(1 << max(4, int(np.log2(room))))
    columns = ("values", "quantities", "histories", "status", "doubtful")
    return dataclasses.replace(result, **{name: getattr(result, name)[first] for name in columns})


class _Pressed:
    """Makes statistics of all samples, or, once `asked()`, in a tenth of a second of the first alone and no modes."""

    def __init__(self, result: StudyResult, asked: Callable[[], bool]):
        self._result, self._first, self._asked = result, _first(result), asked
        self._names: list[str] = []  # of what was made of the first

    def made(self, name: str, of: Callable[..., dict], *arguments) -> dict:
        """What `of(result, *arguments, hurried)` gives."""
        try:
            with heeding(self._asked):
                look()
                return of(self._result, *arguments, False)
        except Stopped:
            self._names.append(name)
            with heeding(lambda: False):
                return of(self._first, *arguments, True)

    def notes(self) -> list[str]:
        """A sentence where that had to be."""
        if not self._names:
            return []
        every, some = len(self._result.status), len(self._first.status)
        return [
            f"cancelled: of {', '.join(self._names)} there are no modes"
            + (f", and statistics are those of the first {some} of {every} samples" if some < every else "")
            + "; go on from the log for all"
        ]


def _of_quantity(result, missing, name, drawn, found, hurried) -> dict:
    """What is known of a quantity by its distribution, its expansion, or its sample."""
    wanted = result.study.densities.get(name, ())
    if isinstance(found, Derived):
        return {"method": "change_of_variable", **summary_of_derived(found, wanted), "half_width": 0.0}
    if isinstance(found, Interpolated):
        return {"method": "change_of_variable", **summary_of_interpolated(found, wanted)}
    if isinstance(found, Chaos):
        return {"method": "chaos", **summary_of_chaos(result.study, found, missing, _modes(result, hurried), wanted)}
    return {"method": "ensemble", **_of_sample(result, missing, name, drawn, hurried)}


def _modes(result, hurried) -> bool:
    return result.study.settings.modality == "yes" and not hurried


def _poor_interpolants(found) -> list[str]:
    return [
        f"{name}: the polynomial misses runs by {one.error:.2g} of the deviation; the method ensemble needs none"
        for name, one in found.items()
        if isinstance(one, Interpolated) and one.error > POOR
    ]


def _of_sample(result, missing, name, drawn, hurried) -> dict:
    settings, rule, replicates = result.study.settings, drawn.rule, drawn.points.replicates
    sample = result.sample(name)
    modes, wanted = _modes(result, hurried), result.study.densities.get(name, ())
    found = summary_of_sample(sample, missing, replicates, settings.seed, modes, wanted)
    if drawn.because.startswith(OUT_OF_TIME):  # more were asked for
        found["refused"] = {key: why.replace(MORE, "raise time_limit") for key, why in found["refused"].items()}
    statistic = rule.asked if name == rule.quantity else "mean"
    width = np.inf if statistic in missing else half_width(sample, statistic, replicates=replicates)
    return {**found, "half_width": width if np.isfinite(width) else None}


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


def _of_history(result, channel, task, at_mean, hurried) -> dict:
    """Bands of a history over the realisations that did not fail, and the run `at_mean` inputs (1 or 0, t) beside."""
    found, bands = history_statistics(result, channel, task.instants), {}
    if found.count > 1:
        bands = {"mean": found.mean, "std": found.std, "skewness": found.skewness}
        bands |= dict(zip(("0.05", "0.50", "0.95"), found.quantiles(), strict=True))
        for key, row in zip(result.study.joint.keys, found.input_correlation(), strict=True):
            bands[f"correlation with {key}"] = np.where(np.isfinite(row), row, 0.0)
    if len(at_mean):
        bands["at_mean_inputs"] = at_mean[0]
    told = {"realisations": found.count, "time_s": task.instants.tolist()}
    told |= {name: one.tolist() for name, one in bands.items()}
    if found.count > 1:
        told |= _between_instants(found) | ({} if hurried else _narrowing(found, result.study))
    return told


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
        key: {
            "time_s": one.time,
            "later_s": one.later,
            "interval_s": [one.low, one.high],
            "by_slopes_s": one.by_slopes,
        }
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


def _flags_at_mean(study, task, asked) -> list[str]:
    """What is doubtful about the scene at its mean inputs, where closed forms say nothing of it, unless `asked()`."""
    if not task.closed or asked():
        return []
    try:
        run = simulate(study.scene_at(mean_inputs(study)[0]))
        for _ in run.blocks():
            if asked():
                return []
    except BearingTwinError as error:
        return [f"at the mean inputs there is no run: {error}"]
    return [f"at the mean inputs {flag}" for flag in run.report.flags]
