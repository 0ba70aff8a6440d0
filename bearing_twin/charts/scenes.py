"""Problems of scenes: a problem is a scene with overrides, a method is overrides and the key its settings go to.

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
from bearing_twin.charts.contest import timed
from bearing_twin.kinds.sections import solved_whole
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Run, simulate

WITHOUT_CHECK = "solver.check=none"
LEAST_LOAD = 0.01  # of the greatest load: lighter contacts count as that where friction is judged


class RunData(NamedTuple):
    """A run: time [s], channels over time, figures, evaluations of the right-hand side or steps, and its scene."""

    time: np.ndarray
    values: dict[str, np.ndarray]
    figures: dict[str, Any]
    evaluations: float
    scene: Any


@dataclass(frozen=True)
class Method:
    """Overrides that choose a method, the key its settings go to ("" where there is none), and the settings.

    A method that is none of the product has `solve(exact, setting)`, which gives the work to be timed, and what turns
    its result into a run.
    """

    overrides: tuple[str, ...] = ()
    tuned_key: str = ""
    settings: tuple[float, ...] = (math.nan,)
    solve: Callable[[RunData, float], tuple[Callable[[], Any], Callable[[Any], RunData]]] | None = None


@dataclass(frozen=True, kw_only=True)
class SceneProblem:
    """A scene with overrides, those of the reference, methods by name, and the norm of errors.

    Every method runs at each of its settings and each second number. `across(value)` are overrides by a second number
    that the reference shares, at `values`. Costs are of a simulated second where `per_second`, and none without
    `is_timed`. `channels` are kept of a run, `extra` are further columns of rows.
    """

    title: str
    scene: str
    overrides: tuple[str, ...] = ()
    reference: tuple[str, ...] = ()
    methods: Mapping[str, Method]
    norm: Callable[[RunData, RunData], dict[str, float]]
    channels: tuple[str, ...] = ("normal_load",)
    across: Callable[[float], tuple[str, ...]] = lambda value: ()
    values: tuple[float, ...] = (math.nan,)
    per_second: bool = False
    is_timed: bool = True
    extra: Mapping[str, Any] = field(default_factory=dict)

    def entries(self, quick: bool) -> Iterator[tuple[str, float, float]]:
        """Methods with setting and second number; `quick`: the loosest two settings, the ends of the second numbers."""
        values = (self.values[0], self.values[-1]) if quick and len(self.values) > 1 else self.values
        for name, method in self.methods.items():
            settings = method.settings[:2] if quick else method.settings
            yield from ((name, setting, value) for value in values for setting in settings)

    def overrides_of(self, method: str, setting: float, across: float) -> tuple[str, ...]:
        """The overrides of one run."""
        row = self.methods[method]
        setting_override = (f"{row.tuned_key}={setting:.9g}",) if row.tuned_key else ()
        return last_overrides((*self.overrides, *self.across(across), *row.overrides, *setting_override))

    def command(self, *entry) -> str:
        """The command that repeats a run; empty for a method that is none of the product."""
        if self.methods[entry[0]].solve:
            return ""
        options = (f"--set {override}" for override in self.overrides_of(*entry))
        return " ".join(["bearing_twin simulate", self.scene, *options])

    def judge(self, method: str, setting: float, across: float) -> dict[str, Any]:
        """Error and cost of one run; raises what `run_scene` raises."""
        overrides = self.overrides_of(method, setting, across)
        load_scene(self.scene, overrides)  # a refusal comes before the reference is computed
        exact = _reference(self.scene, (*self.overrides, *self.across(across), *self.reference), self.channels)
        if solve := self.methods[method].solve:
            work, data_of_work = solve(exact, setting)
        else:
            work, data_of_work = simulation_work(self.scene, overrides, self.channels)
        times = exact.scene.parameters.run.duration if self.per_second else 1.0
        ended, cost = timed(work, times) if self.is_timed else (work(), {})
        result = data_of_work(ended)
        return {**self.norm(result, exact), **cost, "evaluations": result.evaluations, **self.extra}


def greatest_difference(*channels: str) -> Callable[[RunData, RunData], dict[str, float]]:
    """Norm: the greatest difference of each channel over its greatest value, and the greatest of them."""

    def norm(result, exact):
        errors = {}
        for name in channels:
            channel, reference = result.values[name], exact.values[name]
            errors[f"{name}_error"] = float(np.abs(channel - reference).max() / np.abs(reference).max())
        return {"error": max(errors.values()), **(errors if len(errors) > 1 else {})}

    return norm


def root_mean_square(channel: str) -> Callable[[RunData, RunData], dict[str, float]]:
    """Norm: the root mean square of a channel's difference over that of the channel."""

    def norm(result, exact):
        difference = result.values[channel] - exact.values[channel]
        return {"error": float(np.sqrt(np.mean(difference**2) / np.mean(exact.values[channel] ** 2)))}

    return norm


def load_and_friction(result: RunData, exact: RunData) -> dict[str, float]:
    """Norm of a bearing: errors of loads over the greatest load, and of friction forces over mu N of each contact."""
    load, force = (result.values[name] - exact.values[name] for name in ("normal_load", "friction_force"))
    true, mu = exact.values["normal_load"], exact.scene.parameters.contact.friction_coefficient
    limit = mu * np.maximum(true, LEAST_LOAD * true.max())
    errors = np.abs(load).max() / true.max(), (np.linalg.norm(force, axis=-1) / limit).max() if mu else 0.0
    return {"error": float(max(errors)), "load_error": float(errors[0]), "friction_error": float(errors[1])}


bearing_problem = functools.partial(  # of a 6203, judged by loads and friction
    SceneProblem,
    scene="bearing_6203",
    norm=load_and_friction,
    channels=("normal_load", "friction_force"),
    per_second=True,
)


def peak_loads(run: RunData, exact: RunData) -> dict[str, float]:
    """Norm of impacts: the greatest relative error of peak loads; 1 where contacts are missing or spurious."""
    peaks, true_peaks = (
        np.array([contact["peak_force_n"] for contact in run.figures["contacts"]]) for run in (run, exact)
    )
    if len(peaks) != len(true_peaks) or not len(peaks):
        return {"error": float(len(peaks) != len(true_peaks))}
    return {"error": float(np.abs(peaks - true_peaks).max() / true_peaks.max())}


def last_overrides(overrides: tuple[str, ...]) -> tuple[str, ...]:
    """The overrides of a scene, the last of each key."""
    return tuple({override.partition("=")[0]: override for override in overrides}.values())


def run_scene(scene: str, overrides: tuple[str, ...] = (), channels: tuple[str, ...] = ()) -> RunData:
    """A whole run, without a check; raises what `simulate` raises, also where the run broke off."""
    work, data_of_work = simulation_work(scene, overrides, channels)
    return data_of_work(work())


def simulation_work(
    scene: str, overrides: tuple[str, ...], channels: tuple[str, ...] = ()
) -> tuple[Callable, Callable]:
    """The motion of a scene with its outputs as work that may be repeated, and what turns its result into a run."""
    first_run = simulate(load_scene(scene, last_overrides((*overrides, WITHOUT_CHECK))))

    def work():
        # a motion that is solved whole is solved once a run: what repeats its blocks only reads them
        run = simulate(first_run.scene) if solved_whole(first_run.scene.parameters) else first_run
        return run, [(block.time_ns, {name: block.values[name] for name in channels}) for block in run.blocks()]

    return work, lambda ended: run_data(*ended)


def run_data(run: Run, blocks: list[tuple[np.ndarray, dict[str, np.ndarray]]]) -> RunData:
    """A run that has ended; raises BearingTwinError where it broke off."""
    report = run.report
    if report.status.startswith("failed"):
        raise BearingTwinError(report.status)
    values = {name: np.concatenate([block[name] for _, block in blocks]) for name in blocks[0][1]}
    costs = (report.costs[key] for key in ("ball_rates", "evaluations", "steps") if report.costs.get(key))
    time = 1e-9 * np.concatenate([time_ns for time_ns, _ in blocks])
    return RunData(time, values, report.figures, float(next(costs, 0)), run.scene)


@functools.lru_cache(maxsize=4)
def _reference(scene: str, overrides: tuple[str, ...], channels: tuple[str, ...]) -> RunData:
    return run_scene(scene, overrides, channels)


def log_spaced(low: float, high: float, count: int) -> tuple[float, ...]:
    """So many numbers, evenly spaced by their logarithm, with four digits."""
    return tuple(float(f"{value:.4g}") for value in np.geomspace(low, high, count))


def tolerances(*settings: float, overrides: tuple[str, ...] = ()) -> Method:
    """A method whose settings are tolerances."""
    return Method(overrides, "wanted.tolerance", settings)


def steps(*settings: float, overrides: tuple[str, ...] = ()) -> Method:
    """A method whose settings are steps [s]."""
    return Method(overrides, "solver.step", settings)
