"""Quantities of a study at points chosen for a purpose: chaos, interpolation, Sobol indices. Each point runs once."""

from collections.abc import Callable, Sequence

import numpy as np

from bearing_twin.errors import StatisticError, Stopped, StudyError
from bearing_twin.uq.chaos import Chaos, expand
from bearing_twin.uq.ensemble import Ensemble
from bearing_twin.uq.interpolation import Interpolated, interpolate
from bearing_twin.uq.propagation import along, uncertain_inputs
from bearing_twin.uq.result import summary_of_derived, summary_of_sample
from bearing_twin.uq.sampling import UnitPoints
from bearing_twin.uq.sensitivity import sensitivity_points, sobol_indices
from bearing_twin.uq.statistics import MOMENTS
from bearing_twin.uq.study import Study

SURROGATE_POINTS = 2**14


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


def expansions(study: Study, evaluate: Evaluator) -> dict[str, Chaos]:
    """The polynomial chaos of every quantity; raises StudyError where the inputs or a quantity do not allow it."""
    settings = study.settings
    return {
        name: expand(study.joint, evaluate.of(name), settings.degree or None, seed=settings.seed)
        for name in study.quantities
    }


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


def summary_of_interpolated(found: Interpolated, densities: Sequence[float] = ()) -> dict:
    """As `summary_of_derived`; each interval is what the last doubling of the runs changed, to either side."""
    result, before = (summary_of_derived(one, densities) for one in (found.derived, found.before))
    for name in MOMENTS:
        if None not in (result[name], before[name]):
            result[f"{name}_interval"] = _around(result[name], before[name])
    for key, quantile in result["quantiles"].items():
        quantile["low"], quantile["high"] = _around(quantile["value"], before["quantiles"][key]["value"])
    for one, other in zip(result["densities"], before["densities"], strict=True):
        one["low"], one["high"] = _around(one["density"], other["density"])
    low, high = result["mean_interval"] or (0.0, None)
    return {
        **result,
        "half_width": None if high is None else 0.5 * (high - low),
        "interpolation_error": found.error,
        "beyond_the_runs": found.left_out,
        "runs": [{"input": x, "value": y} for x, y in zip(found.at.tolist(), found.values.tolist(), strict=True)],
    }


def _around(value, before):
    return [value - abs(value - before), value + abs(value - before)]


def sources_of_variance(study: Study, evaluate: Evaluator) -> dict[str, dict]:
    """Sobol indices of every quantity by `settings.sensitivity` rows of samples: plain data, or the reason why not."""
    settings, inputs = study.settings, study.joint.dimension
    design = UnitPoints(settings.sampler, 2 * inputs, settings.seed, settings.sensitivity)
    points = sensitivity_points(study.joint, design.chunk(0, design.samples))
    found = evaluate(study.joint.values(points.reshape(-1, inputs)))
    result = {}
    for column, name in enumerate(study.quantities):
        try:
            indices = sobol_indices(found[:, column].reshape(design.samples, inputs + 2), replicates=design.replicates)
        except StatisticError as error:
            result[name] = {"refused": str(error)}
            continue
        orders = {
            "first": (indices.first, indices.first_interval, indices.first_safe),
            "total": (indices.total, indices.total_interval, indices.total_safe),
        }
        result[name] = {
            key: {
                order: _interval(value[place], *interval[place]) | {"unsafe": not safe[place]}
                for order, (value, interval, safe) in orders.items()
            }
            for place, key in enumerate(study.joint.keys)
        }
    return result


def summary_of_chaos(study: Study, chaos: Chaos, missing: dict[str, str], modes: bool, densities=()) -> dict:
    """As `summary_of_sample`, from an expansion: mean and deviation exactly, the rest from SURROGATE_POINTS of it.

    The intervals of mean and deviation, and `half_width`, are the root mean square error of the expansion at fresh
    points; those of the rest tell only what sampling the expansion leaves open.
    """
    settings = study.settings
    points = UnitPoints("sobol", study.joint.dimension, settings.seed, SURROGATE_POINTS)
    sample = chaos.predict(points.chunk(0, points.samples))
    found = summary_of_sample(sample, missing, points.replicates, settings.seed, modes, densities)
    miss = chaos.error * chaos.std
    for name in ("mean", "std"):
        if name not in missing:
            value = getattr(chaos, name)
            found |= {name: value, f"{name}_interval": [value - miss, value + miss]}
    found |= {"half_width": miss, "degree": chaos.degree, "validation_error": chaos.error}
    if study.joint.independent:
        pairs = zip(study.joint.keys, chaos.first, chaos.total, strict=True)
        found["sobol"] = {key: {"first": _interval(first), "total": _interval(total)} for key, first, total in pairs}
    return found


def _interval(value, low=None, high=None) -> dict:
    return {
        "value": float(value),
        "low": None if low is None else float(low),
        "high": None if high is None else float(high),
    }
