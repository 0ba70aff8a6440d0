"""A soft disc on a wall: error of the force against seconds, over meshes, orders, integration, formulations and steps.

The problem is the mean one of paper 3, section 5.2; the error is the root mean square of the force on [0, 0.07 s],
relative, against 64 divisions of order 4 by the same formulation and Poisson's ratio; that of steps against a short
step on the same mesh. Seconds are those of one core.
"""

import time
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bearing_twin import __version__
from bearing_twin.charts.sheets import Axis, Line, Panel, Sheet
from bearing_twin.charts.sheets import draw as draw_sheet
from bearing_twin.charts.study_samples import colour
from bearing_twin.charts.table import write_rows
from bearing_twin.kinds.soft_discs.derived import fitting, nodes_of
from bearing_twin.kinds.soft_discs.elements import ORDERS
from bearing_twin.kinds.soft_discs.solve import solve
from bearing_twin.run.scene import load_scene

TIMES = np.linspace(0.0, 0.07, 1401)
REFERENCE = ("mesh.divisions=64", "mesh.order=4", "solver.step_share=0.9")
LADDER = (8, 12, 16, 24, 32)  # divisions
FURTHER = (64,)  # of bilinear elements, which there still err by more than the reference
SHARES = (1.0, 0.5, 0.25, 0.12, 0.06)
STEP_MESH = ("mesh.divisions=24", "mesh.order=3")
SHORTER = 3.0  # than the shortest step is the one that is taken as true
NEARLY = "disc.material.poisson_ratio=0.499"
LOCKING = {"selective": (), "full": ("mesh.integration=full",)}
FORMULATIONS = ("stvk", "neo_hookean", "linear")
REPEATS = 3  # of a timing, the least of which counts
ERROR, SECONDS = Axis("relative error of the force", "1", log=True), Axis("seconds of one core", "s", log=True)


class Point(NamedTuple):
    """One run: what is varied in which `panel`, the name of its `line`, and what came out."""

    panel: str
    line: str
    nodes: int
    steps: int
    seconds: float
    error: float


POINT = Point


def measure(
    ladder: tuple[int, ...] = LADDER,
    reference: tuple[str, ...] = REFERENCE,
    shares: tuple[float, ...] = SHARES,
    further: tuple[int, ...] = FURTHER,
) -> Iterator[Point]:
    """Meshes by order; steps; formulations; full against selective integration at a Poisson's ratio of 0.499."""
    truth = cache(lambda *changes: _run(*reference, *changes)[2])
    for order in ORDERS:
        wanted = (*ladder, *further) if order == 1 else ladder
        for divisions in sorted({fitting(one, order) for one in wanted}):
            mesh = (f"mesh.divisions={divisions}", f"mesh.order={order}")
            yield _point("mesh", f"order {order}", truth(), *mesh)
    same_mesh = _run(*STEP_MESH, f"solver.step_share={shares[-1] / SHORTER}")[2]
    for share in shares:
        yield _point("step", "order 3, 24 divisions", same_mesh, *STEP_MESH, f"solver.step_share={share}")
    for word in FORMULATIONS:
        change = f"formulation={word}"
        for divisions in ladder:
            mesh = (f"mesh.divisions={fitting(divisions, 2)}", "mesh.order=2")
            yield _point("formulation", word, truth(change), *mesh, change)
    for word, changes in LOCKING.items():
        for divisions in ladder:
            mesh = (f"mesh.divisions={fitting(divisions, 1)}", "mesh.order=1", *changes)
            yield _point("locking", f"{word} integration", truth(NEARLY), *mesh, NEARLY)


def disc_force(*changes: str) -> np.ndarray:
    """The force on the disc at TIMES [N/m] with these changes of the scene."""
    return _run(*changes)[2]


def _run(*changes: str) -> tuple[int, int, np.ndarray, Callable]:
    parameters = load_scene("soft_discs_mean", changes).parameters
    found = solve(parameters, frames=2)
    return len(found.mesh.x) - 1, len(found.history), found.at("force", TIMES), lambda: solve(parameters, frames=2)


def _point(panel, line, truth, *changes) -> Point:
    nodes, steps, force, again = _run(*changes)
    seconds = []
    for _ in range(REPEATS):
        start = time.thread_time()
        again()
        seconds.append(time.thread_time() - start)
    error = float(np.sqrt(np.mean((force - truth) ** 2) / np.mean(truth**2)))
    return Point(panel, line, nodes, steps, min(seconds), error)


def draw(points: list[Point], path: Path) -> None:
    """One panel for each of what is varied."""
    titles = {
        "mesh": "Meshes, by order of the elements",
        "formulation": "Formulations, order 2",
        "step": "Steps: 1 to 0.06 of the stable bound, same mesh",
        "locking": "Poisson's ratio 0.499, order 1",
    }
    panels = []
    for panel, title in titles.items():
        mine = [point for point in points if point.panel == panel]
        parts = []
        for place, line in enumerate(dict.fromkeys(point.line for point in mine)):
            rows = sorted((point.seconds, point.error) for point in mine if point.line == line)
            look = {**colour(place), "marker": "o", "markersize": 5}
            parts.append(Line(line, [row[0] for row in rows], [row[1] for row in rows], look))
        panels.append(Panel(panel, title, SECONDS, ERROR, parts))
    text = f"mean problem of paper 3, section 5.2, against {', '.join(REFERENCE)}; bearing_twin {__version__}"
    draw_sheet(Sheet("A soft disc on a wall: error against seconds", [panels[:2], panels[2:]], text, []), path)


def write_table(points: list[Point], path: Path) -> None:
    """Every point as comma-separated values."""
    write_rows(path, Point._fields, points)


def reading(points: list[Point]) -> Iterator[str]:
    """What bilinear meshes err by and cost, what all cost at an error of half a per cent, and what locks."""
    bilinear = {nodes_of(one): one for one in (*LADDER, *FURTHER)}
    rows = [point for point in points if (point.panel, point.line) == ("mesh", "order 1") and point.nodes in bilinear]
    parts = (f"{3 * bilinear[row.nodes] ** 2 // 2} by {row.error:.2g} in {row.seconds:.2g} s" for row in rows)
    yield f"Bilinear quadrilaterals on half the disc err: {', '.join(parts)}."
    for line in dict.fromkeys(point.line for point in points if point.panel == "mesh"):
        good = [point for point in points if point.panel == "mesh" and point.line == line and point.error <= 5e-3]
        if good:
            best = min(good, key=lambda point: point.seconds)
            yield f"{line}: {best.error:.2g} with {best.nodes} nodes in {best.seconds:.3g} s."
    finest = {word: [point for point in points if point.line == f"{word} integration"][-1] for word in LOCKING}
    yield (
        f"At a Poisson's ratio of 0.499 bilinear elements err by {finest['full'].error:.2g} with full and by "
        f"{finest['selective'].error:.2g} with selective integration, {finest['full'].nodes} nodes: full locks."
    )
