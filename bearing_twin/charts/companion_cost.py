"""What the companion takes of the steps of bearing runs: of short ones in the chart of tolerances, and of long ones.

Long are shipped scenes as they ship, and the chart's cases ten times as long as there. Nothing is compared with a truth
in these: steps are counted alone.
"""

import time
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from bearing_twin.charts.bearing_variants import ALL_CASES
from bearing_twin.charts.table import DONE
from bearing_twin.run.doubt import MUCH, SHORT_RUN
from bearing_twin.run.passes import Run, simulate
from bearing_twin.run.scene import load_scene
from bearing_twin.shelf import SCENES

LENGTHS = AT_LENGTH, ALONE_AT_LENGTH = "at length", "at length, loads alone"  # the contestants
LONGER = 10.0  # times as long as in the chart: 1 s of nearly all variants
SHIPPED = {head["name"]: (head["name"], ()) for head in SCENES.heads() if head["kind"] == "bearing"}


def at_length(problem: str) -> tuple[str, tuple[str, ...]]:
    """The scene of a problem, and the overrides in which it differs from it, at its full length."""
    if problem in SHIPPED:
        return SHIPPED[problem]
    scene, differs = ALL_CASES[problem]
    duration = LONGER * load_scene(scene, differs).parameters.run.duration
    return scene, (*(word for word in differs if not word.startswith("run.duration=")), f"run.duration={duration:g}")


def counted(problem: str, wanted: tuple[str, ...], tolerance: float) -> dict[str, Any]:
    """The columns of a row that tell steps and CPU seconds of a problem at its full length, with what is `wanted`."""
    scene, differs = at_length(problem)
    start = time.thread_time()
    run = simulate(load_scene(scene, (*differs, *wanted, f"wanted.tolerance={tolerance!r}")))
    for _ in run.blocks():
        pass
    return steps_of(run) | {"seconds": time.thread_time() - start}


def steps_of(run: Run) -> dict[str, Any]:
    """The columns of a row of the chart of tolerances that tell the steps of a run that is over, and what it says."""
    taken, beside = (run.report.costs.get(f"{name}ball_steps", 0) for name in ("", "companion_"))
    return {
        "evaluations": taken + beside,
        "told": run.report.status,
        "watched_steps": taken,
        "companion_steps": beside,
        "took": run.report.errors.get("companion_reason", ""),
    }


def long_runs(points: Iterable) -> Iterator[str]:
    """What the companion takes of the steps of runs at full length, rows of the chart of tolerances."""
    points = list(points)
    for who, mine in (
        ("Shipped scenes at their own length", [p for p in points if p.problem in SHIPPED]),
        (f"Others {LONGER:g} times as long", [p for p in points if p.problem not in SHIPPED]),
    ):
        if done := [p for p in mine if p.status == DONE and p.watched_steps]:
            yield f"{who}: the companion takes {taken(done)}, {much(done)}."


def companion_shares(points: list) -> tuple[np.ndarray, np.ndarray]:
    """Steps of runs, rows of the chart of tolerances, and the companion's share of them [%]; equilibria have none."""
    counted = [p for p in points if p.watched_steps]
    steps, beside = (np.array([getattr(p, f"{name}_steps") for p in counted]) for name in ("watched", "companion"))
    return steps, 100.0 * beside / steps


def taken(points: list) -> str:
    """The companion's share of the steps of runs, rows of the chart of tolerances: median and greatest."""
    _, shares = companion_shares(points)
    return f"{np.median(shares):.3g} % of a run's steps as a median and {max(shares):.3g} % at most"


def much(points: list) -> str:
    """In how many runs it takes so much that the run is to say what took it, and how many do."""
    known = [p for p in points if p.watched_steps]
    dear = [p for p in known if p.companion_steps > MUCH * p.watched_steps]
    says, short = sum(bool(p.took) for p in dear), sum(SHORT_RUN in p.took for p in dear)
    said = f"; {says} of these say what took it, {short} are short" if dear else ""
    return f"over {100.0 * MUCH:g} % in {len(dear)} of {len(known)} runs{said}"
