"""Realisations of a study: quantities and histories at given inputs, by closed forms or by simulation."""

import contextlib
import dataclasses
import functools
import json
import re
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import BearingTwinError, CoreError, StatisticError, StudyError
from bearing_twin.base.parameters import describe
from bearing_twin.kinds import HOMES, KINDS, kind_of
from bearing_twin.kinds.contract import Quantity
from bearing_twin.kinds.error_estimates import NO_CHECK
from bearing_twin.kinds.sections import solved_whole
from bearing_twin.run.report import FAILED
from bearing_twin.run.scene import check_ranges, choose, parse_scene
from bearing_twin.run.simulation import Simulation, simulate
from bearing_twin.uq.distributions import require
from bearing_twin.uq.inputs import numeric_keys, put, quantities_of, with_inputs
from bearing_twin.uq.propagation import COARSE, SCORES, Derived, derive, is_heavy, refuse_missing_moment, tails_of
from bearing_twin.uq.statistics import MOMENTS
from bearing_twin.uq.study import Study


def has_closed_form(kind: str, parameters, names, histories=(), varied=()) -> bool:
    """True where closed forms give all these quantities and histories of a scene, the `varied` keys being uncertain."""
    form, known = parameters.closed_form(), quantities_of(kind)
    return (
        form is not None
        and not set(form.without) & set(varied)
        and all(known[name].closed for name in names)
        and all(channel in form.histories for channel in histories)
    )


def errors_of(quantity: Quantity, figures: Mapping[str, Any], by_source: Mapping[str, Mapping]) -> dict[str, float]:
    """Errors of a quantity by source, from those of its figures; empty where none of them has any.

    `by_source` maps figures to {source: error}. Of each source all figures are moved by their errors, away from zero
    and towards it: the greater change counts.
    """
    value, errors = quantity.figure(figures), {}
    for source in dict.fromkeys(source for key in quantity.keys for source in by_source.get(key, ())):
        moved = (
            {key: _moved(figure, by_source.get(key, {}).get(source), direction) for key, figure in figures.items()}
            for direction in (1.0, -1.0)
        )
        errors[source] = max(abs(quantity.figure(moved_figures) - value) for moved_figures in moved)
    return errors


def _moved(value, error, direction: float):
    """A figure, or a list of numbers, moved by its error: away from zero for a positive direction."""
    if error is None or value is None:
        return value
    if isinstance(value, (list, tuple)):
        errors = error if isinstance(error, (list, tuple)) else [error] * len(value)
        return [_moved(*value_and_error, direction) for value_and_error in zip(value, errors, strict=True)]
    return value + (direction if value >= 0.0 else -direction) * error


# Values of the inputs in, quantities and histories out: one row a realisation, the same numbers in any process.

NEVER_MEET = "the bodies never meet"
_NUMBER = re.compile(r"(?<![\w.^])[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")


class Task(NamedTuple):
    """The part of a study that a worker needs: small and plain, so that it can be sent to any process.

    `instants` of the histories run from 0 to `duration` [s], `points` of them. `home` is the module that registers the
    scene's kind, imported where the kind is not known. `checked`: a second run goes with each realisation, as the
    scene says.
    """

    scene: dict
    targets: tuple[tuple[str, ...], ...]
    quantities: tuple[str, ...]
    histories: tuple[str, ...]
    points: int
    duration: float
    closed: bool
    home: str = ""
    checked: bool = False

    @property
    def instants(self) -> np.ndarray:
        """Times [s] of the histories, whole nanoseconds apart."""
        return 1e-9 * self.step_ns * np.arange(self.points)

    @property
    def step_ns(self) -> int:
        """Nanoseconds between instants."""
        return max(1, round(1e9 * self.duration / max(self.points - 1, 1)))


class RealisationErrors(NamedTuple):
    """Errors of a checked realisation `by_quantity` and source, and the reasons of `unknown` errors by source."""

    by_quantity: dict[str, dict[str, float]]
    unknown: dict[str, str]


class Realised(NamedTuple):
    """Of n realisations: `quantities` (n, q), `histories` (n, h, points), both NaN where it failed.

    `failures` maps the row of a failed realisation to the reason, `warnings` others to their warnings,
    `errors` those of a checked task to their errors.
    """

    quantities: np.ndarray
    histories: np.ndarray
    failures: dict[int, str]
    warnings: dict[int, tuple[str, ...]]
    errors: dict[int, RealisationErrors]


def realise(task: Task, values: np.ndarray) -> Realised:
    """The realisations at `values` (n, d) of the inputs [SI]; one that cannot be simulated fails with its reason."""
    kind_of(task.scene["kind"], task.home)
    return _by_closed_forms(task, values) if task.closed else _by_simulation(task, values)


def without_numbers(sentence: str) -> str:
    """A sentence with dots in place of its numbers, so that equal reasons are counted together."""
    return _NUMBER.sub("…", sentence)


def joined(parts: list[Realised], task: Task) -> Realised:
    """Consecutive realisations as one."""
    failures, warnings, errors, first = {}, {}, {}, 0
    for part in parts:
        failures |= {first + row: reason for row, reason in part.failures.items()}
        warnings |= {first + row: sentences for row, sentences in part.warnings.items()}
        errors |= {first + row: realisation_errors for row, realisation_errors in part.errors.items()}
        first += len(part.quantities)
    if not parts:
        return empty(task, 0)
    return Realised(
        np.concatenate([part.quantities for part in parts]),
        np.concatenate([part.histories for part in parts]),
        failures,
        warnings,
        errors,
    )


def empty(task: Task, count: int) -> Realised:
    """`count` realisations whose quantities and histories are NaN."""
    return Realised(
        np.full((count, len(task.quantities)), np.nan),
        np.full((count, len(task.histories), task.points if task.histories else 0), np.nan),
        {},
        {},
        {},
    )


def _by_closed_forms(task, values):
    known, realised = quantities_of(task.scene["kind"]), empty(task, len(values))
    parameters: Any = _parameters_of(json.dumps(task.scene))
    form = parameters.closed_form()
    for column, keys in enumerate(task.targets):
        for key in keys:
            parameters = put(parameters, key, values[:, column])
    bodies = form.bodies(parameters)
    with np.errstate(all="ignore"):
        for column, name in enumerate(task.quantities):
            realised.quantities[:, column] = known[name].closed(*bodies)
        upright = [_upright(body) for body in bodies]
        for row, channel in enumerate(task.histories):
            realised.histories[:, row] = form.histories[channel](task.instants, *upright)
    wrong = ~np.isfinite(realised.quantities).all(axis=1)
    realised.quantities[wrong] = np.nan
    realised.histories[wrong] = np.nan
    meets = np.broadcast_to(np.isfinite(bodies[-1]), len(values))
    realised.failures.update(
        (int(row), form.no_solution if meets[row] else NEVER_MEET) for row in np.flatnonzero(wrong)
    )
    return realised


@functools.lru_cache(maxsize=8)
def _parameters_of(scene: str):
    """Parameters of a scene as JSON; cached, because closed forms are evaluated in many short calls."""
    return parse_scene(json.loads(scene), "a realisation").parameters


def _upright(body):
    """A number or array that broadcasts against times on the last axis."""
    if isinstance(body, tuple):
        return type(body)(*map(_upright, body))
    return np.asarray(body)[..., None]


def _by_simulation(task, values):
    template, known, realised = simulated_scene(task), quantities_of(task.scene["kind"]), empty(task, len(values))
    for row, point in enumerate(values):
        try:
            scene = parse_scene(with_inputs(template, task.targets, point), "a realisation")
            if not task.histories and solved_whole(scene.parameters):
                scene = _with_few_outputs(scene)
            run = simulate(scene)
            histories = _outputs(run, task)
            report = run.simulation.report(last=True)
        except CoreError:  # nothing can run
            raise
        except BearingTwinError as error:
            realised.failures[row] = str(error).removeprefix("a realisation: ").replace("\n", ";")
            continue
        except (ArithmeticError, ValueError) as error:  # an unforeseen error of one realisation must not end all others
            realised.failures[row] = f"{type(error).__name__}: {error}".replace("\n", ";")
            continue
        numbers = [known[name].figure(report.figures) for name in task.quantities]
        if report.status.startswith(FAILED):
            realised.failures[row] = report.status
        elif not (np.isfinite(numbers).all() and np.isfinite(histories).all()):
            lacking = [name for name, number in zip(task.quantities, numbers, strict=True) if not np.isfinite(number)]
            realised.failures[row] = f"not finite, or not modelled: {', '.join(lacking) or 'a history'}"
        else:
            realised.quantities[row], realised.histories[row] = numbers, histories
            if report.flags:
                realised.warnings[row] = tuple(report.flags)
            if task.checked:
                by_source = report.errors["errors_by_source"]
                errors = {name: errors_of(known[name], report.figures, by_source) for name in task.quantities}
                realised.errors[row] = RealisationErrors(errors, report.errors["errors_unknown"])
    return realised


def load(task: Task, values: np.ndarray) -> None:
    """Loads what a realisation at `values` (d,) needs; `realise` reports what cannot be simulated."""
    kind_of(task.scene["kind"], task.home)
    with contextlib.suppress(BearingTwinError, ArithmeticError, ValueError):
        scene = with_inputs(simulated_scene(task), task.targets, values)
        Simulation(parse_scene(scene, "a realisation"))


def simulated_scene(task: Task) -> dict:
    """The scene with outputs at the histories' instants, or without any where figures alone are needed.

    There is no second run but in checked tasks, whose few realisations stand for all (`run.model_errors`).
    """
    run, solver = dict(task.scene["run"]), task.scene.get("solver", {})
    if "check" in solver and not task.checked:
        task = task._replace(scene={**task.scene, "solver": {**solver, "check": NO_CHECK}})
    if task.histories:
        rate = 1e9 / task.step_ns
        # A little longer, so that rounding does not lose the last instant.
        run |= {"duration": task.instants[-1] + 0.5e-9 * task.step_ns, "output_rate": rate, "publish_rate": rate}
    elif solved_whole(KINDS[task.scene["kind"]].parameters()):
        known = quantities_of(task.scene["kind"])
        outputs = "history" if any(known[name].whole for name in task.quantities) else "peaks"
        return {**task.scene, "wanted": {**task.scene["wanted"], "outputs": outputs}}
    return {**task.scene, "run": run}


def _with_few_outputs(scene):
    """The same impact with outputs at its start and its end only."""
    run = scene.parameters.run
    rate = 1e9 / max(1, int(1e9 * run.duration))
    few = dataclasses.replace(run, output_rate=rate, publish_rate=rate)
    return dataclasses.replace(scene, parameters=dataclasses.replace(scene.parameters, run=few))


def _outputs(run, task) -> np.ndarray:
    """The histories (h, points) of a run, which is iterated to its end."""
    parts = [[block.values[name] for name in task.histories] for block in run.blocks()]
    if not task.histories:
        return np.empty((0, 0))
    return np.array([np.concatenate(column)[: task.points] for column in zip(*parts, strict=True)])


# Quantities of a study as functions of its inputs.


def task_of(study: Study) -> Task:
    """The task of a study."""
    settings, histories = study.settings, study.histories
    at_medians = study.scene_at(study.medians)
    check_ranges(at_medians)
    medians = at_medians.parameters
    duration = (settings.history_duration or medians.run.duration) if histories else 0.0
    varied = {key for keys in study.targets for key in keys}
    closed = has_closed_form(study.kind, medians, study.quantities, histories, varied)
    task = Task(
        study.scene,
        study.targets,
        study.quantities,
        histories,
        settings.history_points,
        duration,
        closed,
        HOMES.get(study.kind, ""),
    )
    return task if closed else _with_one_stepper(task, study.medians)


def _with_one_stepper(task: Task, medians) -> Task:
    """The task with the stepper that suits its median inputs: one for all, so that no quantity jumps between two."""
    if task.scene.get("solver", {}).get("stepper") != "auto":  # chosen, or of a kind that leaves no choice
        return task
    scene = parse_scene(with_inputs(simulated_scene(task), task.targets, medians), "at the medians")
    choice = choose(scene)
    steppers = {row.key: row.options for row in describe(type(scene.parameters))}["solver.stepper"]
    if choice.stepper not in steppers:  # a model that integrates nothing, chosen by other keys
        return task
    return task._replace(scene=put(task.scene, "solver.stepper", choice.stepper))


def exact_distributions(study: Study, task: Task, method: str) -> dict[str, Derived]:
    """The quantities that a change of variable of a closed form gives.

    Raises StudyError where that method is specified and does not fit.
    """
    uncertain, is_required = study.joint.uncertain, method == "change_of_variable"
    require(
        not is_required or len(uncertain) == 1,
        f"study {study.name}: a change of variable needs one uncertain input, not {len(uncertain)}; choose the method "
        "ensemble, or chaos for up to 4 of them",
    )
    require(
        not is_required or task.closed,
        f"study {study.name}: a change of variable needs a closed form, which this scene has not for all its "
        "quantities; choose the method chaos for smooth ones, or ensemble",
    )
    if not (is_required or method == "auto") or len(uncertain) != 1 or not task.closed:
        return {}
    exact, (index,) = {}, uncertain
    for name in study.quantities:
        try:
            exact[name] = derive(study.inputs[index], along(study, index, _function(task, name)))
        except StudyError:
            if is_required:
                raise
    return exact


def _function(task: Task, name: str):
    """A quantity by its closed form, as a function of the inputs (n, d) -> (n,)."""
    alone = task._replace(quantities=(name,), histories=())
    return lambda values: realise(alone, np.asarray(values, float)).quantities[:, 0]


def along(study: Study, index: int, function):
    """A function of all inputs (n, d) -> (n,) as one of input number `index` (n,), the others at their medians."""
    medians = np.array(study.medians)

    def function_of_input(x):
        values = np.repeat(medians[None], len(x), axis=0)
        values[:, index] = x
        return function(values)

    return function_of_input


def missing_moments(study: Study, task: Task, name: str, runs: Callable | None = None) -> dict[str, str]:
    """The moments of a quantity that do not exist, with the reason.

    The tails are followed along each input with the others at their medians: by the closed form, or, of inputs that
    may lack a moment, by a few of the `runs`, a function of the inputs (n, d) -> (n,). Inputs that only together reach
    an infinity are not found.
    """
    missing, function = {}, _function(task, name) if task.closed else runs
    for index, source in enumerate(study.inputs):
        if not (source.has_density if task.closed else is_heavy(source)):
            continue
        tails = tails_of(source, along(study, index, function), SCORES if task.closed else COARSE, strict=False)
        for statistic in MOMENTS:
            try:
                refuse_missing_moment(source, tails, statistic)
            except StatisticError as error:
                missing.setdefault(statistic, str(error))
    return missing


def mean_inputs(study: Study) -> np.ndarray:
    """The means of the inputs (1, d); medians where a mean is not finite, or where the input takes whole numbers."""
    values, known = study.medians, numeric_keys(study.kind)
    for index, source in enumerate(study.inputs):
        if np.isfinite(source.mean) and known[source.key].type != "integer":
            values[index] = source.mean
    return np.array([values])
