"""One run of any scene against a far tighter one: error of the force over time, CPU seconds of the whole run."""

import functools

import numpy as np

from bearing_twin.charts.contest import judged
from bearing_twin.charts.table import Row
from bearing_twin.charts.timing import timed
from bearing_twin.run.passes import Run
from bearing_twin.run.scene import load_scene

FORCE = "normal_load"


def _run(scene: str, overrides: tuple[str, ...]):
    """(values of FORCE at every output, the run's report)."""
    run = Run(load_scene(scene, overrides))
    return np.concatenate([block.values[FORCE] for block in run.blocks()]), run.report


@functools.lru_cache(maxsize=16)
def true_force(scene: str, overrides: tuple[str, ...]) -> np.ndarray:
    """The force at every output as it is taken to be true."""
    return _run(scene, overrides)[0]


def command_of(scene: str, overrides: tuple[str, ...]) -> str:
    """The command that runs a scene so."""
    return " ".join([f"bearing_twin simulate {scene}", *(f"--set {word}" for word in overrides)])


def scene_row(row: Row, scene: str, overrides: tuple[str, ...], true: tuple[str, ...], limit: float) -> Row:
    """The row with the greatest error of the force, over the greatest force, against the overrides `true`."""
    exact = true_force(scene, true)

    def outcome():
        (force, report), cost = timed(lambda: _run(scene, overrides))
        evaluations = next((report.costs[key] for key in ("evaluations", "steps") if report.costs.get(key)), 0)
        error = float(np.abs(force - exact).max() / exact.max())
        return {"load_error": error, "evaluations": evaluations, **cost._asdict()}

    return judged(row.but(command=command_of(scene, overrides)), outcome, limit)
