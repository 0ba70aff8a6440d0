"""Contests of scenes: a problem is a scene with overrides, a method is overrides and the key its settings go to.

Every run is what a user runs: `simulate` with these overrides, without a check beside it. Errors are of public channels
and figures, against the same scene with the overrides of the reference. Costs are of the motion with its outputs: start
and report of a run, some milliseconds, are the same for all methods.
"""

import functools
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.charts.contest import Contest, timed
from bearing_twin.kinds.sections import solved_whole
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Run, simulate

WITHOUT_CHECK = "solver.check=none"
LEAST_LOAD = 0.01  # of the greatest load: lighter contacts count as that where friction is judged


class Found(NamedTuple):
    """A run: time [s], channels over time, figures, evaluations of the right-hand side or steps, and its scene."""

    time: np.ndarray
    values: dict[str, np.ndarray]
    figures: dict[str, Any]
    evaluations: float
    scene: Any


@dataclass(frozen=True)
class Method:
    """Overrides that choose a method, the key its settings go to ("" where there is none), and the settings.

    A method that is none of the product has `solved(exact, setting)`, which gives the work to be timed, and what turns
    its result into a run.
    """

    keys: tuple[str, ...] = ()
    key: str = ""
    ladder: tuple[float, ...] = (math.nan,)
    solved: Callable[[Found, float], tuple[Callable[[], Any], Callable[[Any], Found]]] | None = None


@dataclass(frozen=True, kw_only=True)
class Problem:
    """A scene with overrides, those of the reference, methods by name, and the norm of errors.

    `across(value)` are overrides by a second number that the reference shares, at `values`. Costs are of a simulated
    second where `a_second`. `channels` are kept of a run; an empty one keeps none. `more` are further columns of rows.
    """

    title: str
    scene: str
    keys: tuple[str, ...] = ()
    reference: tuple[str, ...] = ()
    methods: Mapping[str, Method]
    norm: Callable[[Found, Found], dict[str, float]]
    channels: tuple[str, ...] = ("normal_load",)
    across: Callable[[float], tuple[str, ...]] = lambda value: ()
    values: tuple[float, ...] = (math.nan,)
    a_second: bool = False
    more: Mapping[str, Any] = field(default_factory=dict)


def greatest(*channels: str) -> Callable[[Found, Found], dict[str, float]]:
    """Norm: the greatest difference of each channel over its greatest value, and the greatest of them."""

    def norm(found, exact):
        errors = {}
        for name in channels:
            one, other = found.values[name], exact.values[name]
            errors[f"{name}_error"] = float(np.abs(one - other).max() / np.abs(other).max())
        return {"error": max(errors.values()), **(errors if len(errors) > 1 else {})}

    return norm


def root_mean_square(channel: str) -> Callable[[Found, Found], dict[str, float]]:
    """Norm: the root mean square of a channel's difference over that of the channel."""

    def norm(found, exact):
        off = found.values[channel] - exact.values[channel]
        return {"error": float(np.sqrt(np.mean(off**2) / np.mean(exact.values[channel] ** 2)))}

    return norm


def load_and_friction(found: Found, exact: Found) -> dict[str, float]:
    """Norm of a bearing: errors of loads over the greatest load, and of friction forces over mu N of each contact."""
    load, force = (found.values[name] - exact.values[name] for name in ("normal_load", "friction_force"))
    true, mu = exact.values["normal_load"], exact.scene.parameters.contact.friction_coefficient
    limit = mu * np.maximum(true, LEAST_LOAD * true.max())
    errors = np.abs(load).max() / true.max(), (np.linalg.norm(force, axis=-1) / limit).max() if mu else 0.0
    return {"error": float(max(errors)), "load_error": float(errors[0]), "friction_error": float(errors[1])}


def contacts(found: Found, exact: Found) -> dict[str, float]:
    """Norm of impacts: the greatest relative error of peak loads; 1 where contacts are missing or spurious."""
    one, other = (np.array([each["peak_force_n"] for each in run.figures["contacts"]]) for run in (found, exact))
    if len(one) != len(other) or not len(one):
        return {"error": float(len(one) != len(other))}
    return {"error": float(np.abs(one - other).max() / other.max())}


def last_values(keys: tuple[str, ...]) -> tuple[str, ...]:
    """The overrides of a scene, of those of one key the last."""
    return tuple({one.partition("=")[0]: one for one in keys}.values())


def run(scene: str, keys: tuple[str, ...] = (), channels: tuple[str, ...] = ()) -> Found:
    """A whole run, without a check; raises what `simulate` raises, also where the run broke off."""
    work, found_of_work = simulated(scene, keys, channels)
    return found_of_work(work())


def simulated(scene: str, keys: tuple[str, ...], channels: tuple[str, ...] = ()) -> tuple[Callable, Callable]:
    """The motion of a scene with its outputs as work that may be repeated, and what turns its result into a run."""
    made = simulate(load_scene(scene, last_values((*keys, WITHOUT_CHECK))))

    def work():
        # a motion that is solved whole is solved once a run: what repeats its blocks only reads them
        again = simulate(made.scene) if solved_whole(made.scene.parameters) else made
        return again, [(one.time_ns, {name: one.values[name] for name in channels}) for one in again.blocks()]

    return work, lambda ended: found_of(*ended)


def found_of(made: Run, blocks: list[tuple[np.ndarray, dict[str, np.ndarray]]]) -> Found:
    """A run that has ended; raises BearingTwinError where it broke off."""
    report = made.report
    if report.status.startswith("failed"):
        raise BearingTwinError(report.status)
    values = {name: np.concatenate([block[name] for _, block in blocks]) for name in blocks[0][1]}
    costs = (report.costs[key] for key in ("ball_rates", "evaluations", "steps") if report.costs.get(key))
    time = 1e-9 * np.concatenate([one for one, _ in blocks])
    return Found(time, values, report.figures, float(next(costs, 0)), made.scene)


@functools.lru_cache(maxsize=4)
def _reference(scene: str, keys: tuple[str, ...], channels: tuple[str, ...]) -> Found:
    return run(scene, keys, channels)


def contest_of(table: Mapping[str, Problem], timed_runs: bool = True, **words) -> Contest:
    """The contest of a table of problems: every method at every setting and second number, against the reference."""

    def entries(name: str, quick: bool) -> Iterator[tuple[str, float, float]]:
        """`quick`: the loosest two settings, the ends of the second numbers."""
        problem = table[name]
        values = (problem.values[0], problem.values[-1]) if quick and len(problem.values) > 1 else problem.values
        for method, row in problem.methods.items():
            ladder = row.ladder[:2] if quick else row.ladder
            yield from ((method, setting, value) for value in values for setting in ladder)

    def keys_of(name: str, method: str, setting: float, across: float) -> tuple[str, ...]:
        problem = table[name]
        row = problem.methods[method]
        tuned = (f"{row.key}={setting:.9g}",) if row.key else ()
        return last_values((*problem.keys, *problem.across(across), *row.keys, *tuned))

    def command(*entry) -> str:
        """Empty for a method that is none of the product."""
        problem = table[entry[0]]
        if problem.methods[entry[1]].solved:
            return ""
        return " ".join(["bearing_twin simulate", problem.scene, *(f"--set {word}" for word in keys_of(*entry))])

    def judge(*entry) -> dict[str, Any]:
        name, method, setting, across = entry
        problem, keys = table[name], keys_of(*entry)
        load_scene(problem.scene, keys)  # a refusal comes before the reference is computed
        exact = _reference(
            problem.scene, (*problem.keys, *problem.across(across), *problem.reference), problem.channels
        )
        times = exact.scene.parameters.run.duration if problem.a_second else 1.0
        if solved := problem.methods[method].solved:
            work, found_of_work = solved(exact, setting)
        else:
            work, found_of_work = simulated(problem.scene, keys, problem.channels)
        ended, cost = timed(work, times) if timed_runs else (work(), {})
        found = found_of_work(ended)
        return {**problem.norm(found, exact), **cost, "evaluations": found.evaluations, **problem.more}

    titles = {name: problem.title for name, problem in table.items()}
    return Contest(problems=titles, entries=entries, judge=judge, command=command, **words)


def spread(low: float, high: float, count: int) -> tuple[float, ...]:
    """So many numbers, evenly spaced by their logarithm, with four digits."""
    return tuple(float(f"{value:.4g}") for value in np.geomspace(low, high, count))


def tolerances(*ladder: float, keys: tuple[str, ...] = ()) -> Method:
    """A method whose settings are tolerances."""
    return Method(keys, "wanted.tolerance", ladder)


def steps(*ladder: float, keys: tuple[str, ...] = ()) -> Method:
    """A method whose settings are steps [s]."""
    return Method(keys, "solver.step", ladder)
