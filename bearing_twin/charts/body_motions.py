"""What a shaft on two bearings and an ellipsoid that bounces evaluate: problems of `chart motions` beside bearings.

A run is made over a time and over twice that: what it evaluates after the first is told a second, with how often the
shaft turns, or the ellipsoid touches, in that time. Errors are those of ball loads, or of peak forces of contacts, over
the greatest, up to the first time. Truth is a far tighter tolerance.
"""

import functools
from collections.abc import Callable
from itertools import zip_longest
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.charts.contest import judged
from bearing_twin.charts.scene_rows import command_of
from bearing_twin.charts.table import Row
from bearing_twin.charts.timing import timed
from bearing_twin.kinds.charted import EVEN_SHAFT, HURRIED_SHAFT, KNOCKED_SHAFT, TUMBLES, UNEVEN_SHAFT
from bearing_twin.kinds.shaft.parameters import SIDES
from bearing_twin.run.passes import Run
from bearing_twin.run.scene import load_scene

ALONE = "solver.companion=off"  # evaluations are those of the run's own motion


class BodyCase(NamedTuple):
    """A scene, overrides, its method, tolerances, that of the truth, and the time [s] after which counting begins."""

    scene: str
    overrides: tuple[str, ...]
    method: str
    tolerances: tuple[float, ...]
    exact: float
    seconds: float
    values: Callable[[list, Any], np.ndarray]


def _ball_loads(blocks: list, report) -> np.ndarray:
    """Of both bearings at every output."""
    loads = ([block.values[f"{side}_normal_load"].reshape(len(block), -1) for block in blocks] for side in SIDES)
    return np.concatenate([np.concatenate(one) for one in loads], axis=1)


def _peaks(blocks: list, report) -> np.ndarray:
    """Peak forces of contacts in their order."""
    return np.array([one["peak_force_n"] for one in report.figures["contacts"]])


SHAFT = "rodas4", (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6), 1e-8, 0.1, _ball_loads
CASES = {
    EVEN_SHAFT: BodyCase("shaft_two_6203", (), *SHAFT),
    UNEVEN_SHAFT: BodyCase("shaft_angular_pair", (), *SHAFT),
    KNOCKED_SHAFT: BodyCase("shaft_step_load", (), *SHAFT),
    HURRIED_SHAFT: BodyCase("shaft_two_6203", ("drive.change={time: 0.01, speed: 50}",), *SHAFT),
    TUMBLES: BodyCase("ellipsoid_tumbling", (), "dop853", (1e-2, 1e-3, 1e-4, 1e-5, 1e-6), 1e-11, 1.0, _peaks),
}


def overrides_of(name: str, setting: float, seconds: float) -> tuple[str, ...]:
    """What differs in the scene of a problem at that tolerance, over so many seconds."""
    return (*CASES[name].overrides, ALONE, f"wanted.tolerance={setting:g}", f"run.duration={seconds:g}")


def command_for(name: str, setting: float) -> str:
    """The command that repeats a run."""
    return command_of(CASES[name].scene, overrides_of(name, setting, CASES[name].seconds))


def _run(name: str, setting: float, seconds: float) -> Run:
    return Run(load_scene(CASES[name].scene, overrides_of(name, setting, seconds)))


def _found(name: str, setting: float, seconds: float) -> tuple[np.ndarray, Any]:
    """(what errors are of, the report) of a run."""
    run = _run(name, setting, seconds)
    blocks = list(run.blocks())
    return CASES[name].values(blocks, run.report), run.report


@functools.lru_cache(maxsize=8)
def _exact(name: str) -> np.ndarray:
    return _found(name, CASES[name].exact, CASES[name].seconds)[0]


def _events(first, longer, seconds: float) -> float:
    """Turns of a shaft, or touches of an ellipsoid, a second, in the time after the first of two runs."""
    if "touches" in first.costs:
        return (longer.costs["touches"] - first.costs["touches"]) / seconds
    return abs(longer.figures["shaft_speed_at_end_rad_s"]) / (2.0 * np.pi)  # changes are over by then


def judge(row: Row, limit: float, enough: float) -> Row:
    """One run of a problem at its tolerance; the row's kind has `evaluations_a_second` and `events_a_second`."""
    name, case = row.problem, CASES[row.problem]
    exact = _exact(name)

    def outcome():
        (found, report), cost = timed(lambda: _found(name, row.setting, case.seconds), enough)
        apart = [abs(one - true) for one, true in zip_longest(found.ravel(), exact.ravel(), fillvalue=0.0)]
        longer = _found(name, row.setting, 2.0 * case.seconds)[1]
        later = longer.costs["evaluations"] - report.costs["evaluations"]
        return {
            "load_error": float(max(apart) / exact.max()),
            "evaluations": report.costs["evaluations"],
            "evaluations_a_second": later / case.seconds,
            "events_a_second": _events(report, longer, case.seconds),
            "seconds": cost.seconds / case.seconds,
            "spread": cost.spread,
        }

    return judged(row.but(command=command_for(name, row.setting)), outcome, limit)
