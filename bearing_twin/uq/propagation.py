"""How the uncertainty of a study's inputs gets to a quantity: as a function of them, exactly, or at chosen points."""

from contextlib import suppress

import numpy as np

from bearing_twin.errors import StatisticError, StudyError
from bearing_twin.kinds import KINDS
from bearing_twin.parameters import describe
from bearing_twin.run.fidelity import choose, refuse_outside
from bearing_twin.run.scene import parse_scene
from bearing_twin.uq.change_of_variable import Derived, derive
from bearing_twin.uq.quantities import has_closed_form
from bearing_twin.uq.realise import Task, only_what_is_wanted, realise
from bearing_twin.uq.scene_keys import numeric_keys, placed, put
from bearing_twin.uq.statistics import MOMENTS
from bearing_twin.uq.study import Study
from bearing_twin.uq.tails import refuse_missing_moment, tails_along


def task_of(study: Study) -> Task:
    """What a worker must know of a study."""
    settings, histories = study.settings, study.histories
    at_medians = study.scene_at(median_inputs(study))
    refuse_outside(at_medians)
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
        KINDS[study.kind].home,
    )
    return task if closed else _with_one_stepper(task, median_inputs(study))


def _with_one_stepper(task: Task, medians) -> Task:
    """The task with the stepper that suits its median inputs: one for all, so that no quantity jumps between two."""
    if task.scene.get("solver", {}).get("stepper") != "auto":  # chosen, or of a kind that leaves no choice
        return task
    scene = parse_scene(placed(only_what_is_wanted(task), task.targets, medians), "at the medians")
    choice = choose(scene)
    words = {row.key: row.options for row in describe(type(scene.parameters))}["solver.stepper"]
    if choice.stepper not in words:  # a model that integrates nothing, chosen by other keys
        return task
    return task._replace(scene=put(task.scene, "solver.stepper", choice.stepper))


def uncertain_inputs(study: Study) -> list[int]:
    """The places of the inputs that take more than one value."""
    return [index for index, one in enumerate(study.inputs) if one.low < one.high]


def exact_distributions(study: Study, task: Task, method: str) -> dict[str, Derived]:
    """The quantities that a change of variable of a closed form gives.

    Raises StudyError where it was asked for and does not fit; without a closed form see `interpolation`.
    """
    random = uncertain_inputs(study)
    if method not in ("auto", "change_of_variable"):
        return {}
    if method == "change_of_variable" and len(random) != 1:
        raise StudyError(
            f"study {study.name}: a change of variable needs one uncertain input, not {len(random)}; choose the method "
            "ensemble, or chaos for up to 4 of them"
        )
    if len(random) != 1 or not task.closed:
        return {}
    exact = {}
    for name in study.quantities:
        try:
            exact[name] = derive(study.inputs[random[0]], along(study, random[0], _function(task, name)))
        except StudyError:
            if method == "change_of_variable":
                raise
    return exact


def _function(task: Task, name: str):
    """A quantity by its closed form, as a function of the inputs (n, d) -> (n,)."""
    alone = task._replace(quantities=(name,), histories=())
    return lambda values: realise(alone, np.asarray(values, float)).quantities[:, 0]


def along(study: Study, index: int, function):
    """A function of all inputs (n, d) -> (n,) as one of input number `index` (n,), the others at their medians."""
    middle = np.array(median_inputs(study))

    def one(at):
        values = np.repeat(middle[None], len(at), axis=0)
        values[:, index] = at
        return function(values)

    return one


def missing_moments(study: Study, task: Task, name: str) -> dict[str, str]:
    """The moments of a quantity that do not exist, with the reason, as far as a closed form lets it be known."""
    if not task.closed:
        return {}
    missing, function = {}, _function(task, name)
    with suppress(StudyError):  # not finite nearby: failures are counted, tails cannot be followed
        for source, found in tails_along(study.joint, function):
            for statistic in [one for one in MOMENTS if one not in missing]:
                try:
                    refuse_missing_moment(source, found, statistic)
                except StatisticError as error:
                    missing[statistic] = str(error)
    return missing


def median_inputs(study: Study) -> list[float]:
    """The medians of the inputs."""
    return [float(one.ppf(0.5)) for one in study.inputs]


def mean_inputs(study: Study) -> np.ndarray:
    """The means of the inputs (1, d); medians where a mean is not finite or no whole number though it must be one."""
    values, known = median_inputs(study), numeric_keys(study.kind)
    for index, one in enumerate(study.inputs):
        if np.isfinite(one.mean) and known[one.key].type != "integer":
            values[index] = one.mean
    return np.array([values])
