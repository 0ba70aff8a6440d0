"""Values of the inputs in, quantities and histories out: one row a realisation, the same numbers in any process."""

import contextlib
import dataclasses
import functools
import json
import re
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.errors import BearingTwinError
from bearing_twin.kinds import KINDS, kind_of
from bearing_twin.run.doubt import FAILED
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import parse_scene
from bearing_twin.run.simulation import Simulation
from bearing_twin.uq.quantities import errors_of, quantities_of
from bearing_twin.uq.scene_keys import Reader, replaced

NEVER_MEET = "the bodies never meet"
_NUMBER = re.compile(r"(?<![\w.^])[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")


class Task(NamedTuple):
    """What a worker must know of a study: small and plain, so that it can be sent to any process.

    `instants` of the histories run from 0 to `duration` [s], `points` of them. `home` is the module that registers the
    scene's kind, imported where the kind is not known. `watched`: a companion goes with each realisation, as the scene
    says.
    """

    scene: dict
    targets: tuple[tuple[str, ...], ...]
    quantities: tuple[str, ...]
    histories: tuple[str, ...]
    points: int
    duration: float
    closed: bool
    home: str = ""
    watched: bool = False

    @property
    def instants(self) -> np.ndarray:
        """Times [s] of the histories, whole nanoseconds apart."""
        return 1e-9 * self.step_ns * np.arange(self.points)

    @property
    def step_ns(self) -> int:
        """Nanoseconds between instants."""
        return max(1, round(1e9 * self.duration / max(self.points - 1, 1)))


class RealisationWorth(NamedTuple):
    """What a companion says of a realisation: errors by quantity and source, what is `unknown` by source."""

    errors: dict[str, dict[str, float]]
    unknown: dict[str, str]


class Realised(NamedTuple):
    """Of n realisations: `quantities` (n, q), `histories` (n, h, points), both NaN where it failed.

    `failures` maps the row of a failed realisation to the reason, `doubts` others to what is doubtful about them,
    `worth` those of a watched task to what they are worth.
    """

    quantities: np.ndarray
    histories: np.ndarray
    failures: dict[int, str]
    doubts: dict[int, tuple[str, ...]]
    worth: dict[int, RealisationWorth]


def realise(task: Task, values: np.ndarray) -> Realised:
    """The realisations at `values` (n, d) of the inputs [SI]; what cannot be simulated fails with its reason."""
    kind_of(task.scene["kind"], task.home)
    return _by_closed_forms(task, values) if task.closed else _by_simulation(task, values)


def without_numbers(sentence: str) -> str:
    """A sentence with dots for its numbers, by which equal reasons are counted."""
    return _NUMBER.sub("…", sentence)


def joined(parts: list[Realised], task: Task) -> Realised:
    """Consecutive realisations as one."""
    failures, doubts, worth, first = {}, {}, {}, 0
    for part in parts:
        failures |= {first + row: reason for row, reason in part.failures.items()}
        doubts |= {first + row: sentences for row, sentences in part.doubts.items()}
        worth |= {first + row: one for row, one in part.worth.items()}
        first += len(part.quantities)
    if not parts:
        return empty(task, 0)
    return Realised(
        np.concatenate([part.quantities for part in parts]),
        np.concatenate([part.histories for part in parts]),
        failures,
        doubts,
        worth,
    )


def empty(task: Task, count: int) -> Realised:
    """`count` realisations of which nothing is known."""
    return Realised(
        np.full((count, len(task.quantities)), np.nan),
        np.full((count, len(task.histories), task.points if task.histories else 0), np.nan),
        {},
        {},
        {},
    )


def _by_closed_forms(task, values):
    kind = task.scene["kind"]
    form, known, found = KINDS[kind].closed_form(), quantities_of(kind), empty(task, len(values))
    parameters: Any = _parameters_of(json.dumps(task.scene))
    for column, keys in enumerate(task.targets):
        for key in keys:
            parameters = replaced(parameters, key, values[:, column])
    bodies = form.bodies(parameters)
    with np.errstate(all="ignore"):
        for column, name in enumerate(task.quantities):
            found.quantities[:, column] = known[name].closed(*bodies)
        upright = [_upright(body) for body in bodies]
        for row, channel in enumerate(task.histories):
            found.histories[:, row] = form.histories[channel](task.instants, *upright)
    wrong = ~np.isfinite(found.quantities).all(axis=1)
    found.quantities[wrong] = np.nan
    found.histories[wrong] = np.nan
    meets = np.broadcast_to(np.isfinite(bodies[-1]), len(values))
    found.failures.update((int(row), form.no_solution if meets[row] else NEVER_MEET) for row in np.flatnonzero(wrong))
    return found


@functools.lru_cache(maxsize=8)
def _parameters_of(scene: str):
    """Of a scene as JSON; read once, because distributions are followed through closed forms in many short calls."""
    return parse_scene(json.loads(scene), "a realisation").parameters


def _upright(body):
    """A number or array that broadcasts against times on the last axis."""
    if isinstance(body, tuple):
        return type(body)(*map(_upright, body))
    return np.asarray(body)[..., None]


def _by_simulation(task, values):
    kind, found = task.scene["kind"], empty(task, len(values))
    reader, known = _reader_of(task), quantities_of(kind)
    for row, these in enumerate(values):
        try:
            realised = reader.at(these, "a realisation")
            if not task.histories and KINDS[kind].known_when_solved:
                realised = _with_few_outputs(realised)
            run = simulate(realised)
            histories = _outputs(run, task)
            report = run.simulation.report(last=True)
        except BearingTwinError as error:
            found.failures[row] = str(error).removeprefix("a realisation: ").replace("\n", ";")
            continue
        except (ArithmeticError, ValueError) as error:  # of numbers nobody tried before; one must not end all others
            found.failures[row] = f"{type(error).__name__}: {error}".replace("\n", ";")
            continue
        numbers = [known[name].figure(report.figures) for name in task.quantities]
        if report.status.startswith(FAILED):
            found.failures[row] = report.status
        elif not (np.isfinite(numbers).all() and np.isfinite(histories).all()):
            lacking = [name for name, one in zip(task.quantities, numbers, strict=True) if not np.isfinite(one)]
            found.failures[row] = f"not finite, or nothing this model knows: {', '.join(lacking) or 'a history'}"
        else:
            found.quantities[row], found.histories[row] = numbers, histories
            if report.flags:
                found.doubts[row] = tuple(report.flags)
            if task.watched:
                by_source = report.errors["errors_by_source"]
                errors = {name: errors_of(known[name], report.figures, by_source) for name in task.quantities}
                found.worth[row] = RealisationWorth(errors, report.errors["errors_unknown"])
    return found


def load(task: Task, values: np.ndarray) -> None:
    """Loads, or compiles, what a realisation at `values` (d,) needs; what cannot be simulated is told by `realise`."""
    kind_of(task.scene["kind"], task.home)
    with contextlib.suppress(BearingTwinError, ArithmeticError, ValueError):
        Simulation(_reader_of(task).at(values, "a realisation")).warm_up()


_LATEST: list[tuple[Task, Reader]] = []  # a worker gets one task in many messages


def _reader_of(task: Task) -> Reader:
    """What reads the scenes of a task, kept for the next call."""
    for known, reader in _LATEST:
        if known == task:
            return reader
    reader = Reader(only_what_is_wanted(task), task.targets)
    _LATEST[:] = [(task, reader)]
    return reader


def only_what_is_wanted(task: Task) -> dict:
    """The scene with outputs at the histories' instants, or without any where figures alone are wanted.

    A companion that no one asks is left out: what it finds in a few realisations stands for all (`model_error`).
    """
    run, solver = dict(task.scene["run"]), task.scene.get("solver", {})
    if "companion" in solver and not task.watched:
        task = task._replace(scene={**task.scene, "solver": {**solver, "companion": "off"}})
    if task.histories:
        rate = 1e9 / task.step_ns
        # A little longer, so that rounding does not lose the last instant.
        run |= {"duration": task.instants[-1] + 0.5e-9 * task.step_ns, "output_rate": rate, "publish_rate": rate}
    elif KINDS[task.scene["kind"]].known_when_solved:
        known = KINDS[task.scene["kind"]].quantities_of()
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
