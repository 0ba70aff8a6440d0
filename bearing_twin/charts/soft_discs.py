"""A soft disc on a wall: error of the force against seconds, over meshes, orders, integration, formulations and steps.

The problem is the mean one of paper 3, section 5.2; the error is the root mean square of the force on [0, 0.07 s],
relative, against 64 divisions of order 4 by the same formulation and Poisson's ratio; that of steps against a short
step on the same mesh. Each reference is checked by another mesh, or by a shorter step still. Seconds are those of one
core; `setting` is the number of divisions, of steps the share of the stable bound.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from bearing_twin.charts.chart import Chart
from bearing_twin.charts.contest import judged, limited
from bearing_twin.charts.contest_picture import found_again
from bearing_twin.charts.scene_rows import command_of
from bearing_twin.charts.sheets import Axis, Line, Panel, Sheet
from bearing_twin.charts.sheets import draw as draw_sheet
from bearing_twin.charts.study_samples import colour
from bearing_twin.charts.table import DONE, Row
from bearing_twin.charts.timing import timed
from bearing_twin.kinds.soft_discs.derived import fitting
from bearing_twin.kinds.soft_discs.elements import ORDERS
from bearing_twin.kinds.soft_discs.solve import solve
from bearing_twin.run.scene import load_scene

TIMES = np.linspace(0.0, 0.07, 1401)
REFERENCE = ("mesh.divisions=64", "mesh.order=4", "solver.step_share=0.9")
LADDER = (8, 12, 16, 24, 32)  # divisions
FURTHER = (64,)  # of bilinear elements, which there still err by more than the reference
SHARES = (1.0, 0.5, 0.25, 0.12, 0.06)
STEP_MESH = ("mesh.divisions=24", "mesh.order=3")
SHORTER, SHORTEST = 3.0, 6.0  # than the shortest step are the one that is taken as true, and the one that checks it
TRUTHS = 5.0
SECOND = (64, 3)  # divisions and order of the mesh that checks the reference
NEARLY = "disc.material.poisson_ratio=0.499"
OUTSIDE = "solver.allow_invalid=on"  # beyond the ranges of what is shown to fail there
LOCKING = {"selective": (), "full": ("mesh.integration=full", OUTSIDE)}
FORMULATIONS = {"stvk": (), "neo_hookean": (), "linear": (OUTSIDE,)}
ENOUGH = 0.1  # CPU seconds of a timing
ERROR, SECONDS = Axis("relative error of the force", "1", log=True), Axis("seconds of one core", "s", log=True)


@dataclass(frozen=True)
class DiscRow(Row):
    """One run: what is varied is its problem, `method` the line of it, `evaluations` are steps; nodes beside them."""

    nodes: int = 0


SCENE = "soft_discs_mean"
STEP_LINE, INTEGRATION, ANOTHER = "order 3, 24 divisions", "{} integration", "another {}"
PROBLEMS = {
    "mesh": "Meshes, by order of the elements",
    "formulation": "Formulations, order 2",
    "step": "Steps: 1 to 0.06 of the stable bound, same mesh",
    "locking": "Poisson's ratio 0.499, order 1",
}


def _lines(problem: str) -> dict[str, tuple[tuple[str, ...], int]]:
    """The lines of a problem: what is changed there, and the order of the elements."""
    if problem == "mesh":
        return {f"order {order}": ((), order) for order in ORDERS}
    if problem == "formulation":
        return {word: ((f"formulation={word}", *more), 2) for word, more in FORMULATIONS.items()}
    return {INTEGRATION.format(word): ((NEARLY, *changes), 1) for word, changes in LOCKING.items()}


def entries(problem: str) -> Iterator[tuple[str, float]]:
    """The lines of a problem with their divisions, or shares of the stable bound, and the check of its reference."""
    if problem == "step":
        yield from ((STEP_LINE, share) for share in SHARES)
        yield ANOTHER.format("step"), SHARES[-1] / SHORTEST
        return
    for line, (_, order) in _lines(problem).items():
        wanted = (*LADDER, *FURTHER) if (problem, order) == ("mesh", 1) else LADDER
        yield from ((line, float(one)) for one in sorted({fitting(one, order) for one in wanted}))
    yield ANOTHER.format("mesh"), float(SECOND[0])


def _changes(problem: str, line: str, setting: float) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """What a run changes of the scene, and what its reference does."""
    if problem == "step":
        share = f"solver.step_share={setting:g}"
        return (*STEP_MESH, share), (*STEP_MESH, f"solver.step_share={SHARES[-1] / SHORTER:g}")
    divisions, other = f"mesh.divisions={setting:g}", {"mesh": (), "formulation": (), "locking": (NEARLY,)}[problem]
    if line == ANOTHER.format("mesh"):
        return (divisions, f"mesh.order={SECOND[1]}", "solver.step_share=0.9", *other), (*REFERENCE, *other)
    changes, order = _lines(problem)[line]
    true = tuple(change for change in changes if "integration" not in change)
    return (divisions, f"mesh.order={order}", *changes), (*REFERENCE, *true)


_truth = cache(lambda *changes: _run(*changes)[2])


def _command(problem, line, setting):
    return command_of(SCENE, _changes(problem, line, setting)[0])


def judge(problem: str, line: str, setting: float, limit: float) -> DiscRow:
    """One run against its reference, which may take TRUTHS times as long as a run."""
    changes, true = _changes(problem, line, setting)
    with limited(TRUTHS * limit):
        truth = _truth(*true)
    row = DiscRow(problem, line, setting, command=_command(problem, line, setting))

    def outcome():
        nodes, steps, force, again = _run(*changes)
        cost = timed(again, ENOUGH)[1]
        error = float(np.sqrt(np.mean((force - truth) ** 2) / np.mean(truth**2)))
        return {"load_error": error, "evaluations": steps, "nodes": nodes, **cost._asdict()}

    return judged(row, outcome, limit)


def disc_force(*changes: str) -> np.ndarray:
    """The force on the disc at TIMES [N/m] with these changes of the scene."""
    return _run(*changes)[2]


def _run(*changes: str) -> tuple[int, int, np.ndarray, Callable]:
    parameters = load_scene(SCENE, changes).parameters
    found = solve(parameters, frames=2)
    return len(found.mesh.x) - 1, len(found.history), found.at("force", TIMES), lambda: solve(parameters, frames=2)


def draw(rows: list[DiscRow], path: Path) -> None:
    """One panel for each of what is varied; crosses above for what has no result."""
    panels = []
    for problem in (name for name in PROBLEMS if any(row.problem == name for row in rows)):
        mine = [row for row in rows if row.problem == problem]
        parts = []
        for place, line in enumerate(dict.fromkeys(row.method for row in mine)):
            good = sorted((row.seconds, row.error) for row in mine if row.method == line and row.status == DONE)
            look = {**colour(place), "marker": "o", "markersize": 5}
            parts.append(Line(line, [one[0] for one in good], [one[1] for one in good], look))
            wide = [
                (row.seconds, row.error) for row in mine if row.method == line and row.status == DONE and row.unsure
            ]
            around = {**colour(place), "marker": "o", "markersize": 12, "markerfacecolor": "none", "linestyle": ""}
            parts.append(Line(f"{line}, unsure", [one[0] for one in wide], [one[1] for one in wide], around, False))
            lost = [row.seconds for row in mine if row.method == line and row.status != DONE]
            cross = {**colour(place), "marker": "x", "markersize": 12, "linestyle": ""}
            parts.append(Line(f"{line}, no result", lost, [1.0] * len(lost), cross, False))
        panels.append(Panel(problem, PROBLEMS[problem], SECONDS, ERROR, parts))
    text = f"mean problem of paper 3, section 5.2, against {', '.join(REFERENCE)}"
    lines = [panels[first : first + 2] for first in range(0, len(panels), 2)]
    draw_sheet(Sheet("A soft disc on a wall: error against seconds", lines, text, []), path)


def reading(rows: list[DiscRow]) -> Iterator[str]:
    """What bilinear meshes err by and cost, what all cost at an error of half a per cent, what locks, the checks."""
    meshes = [row for row in rows if row.problem == "mesh" and row.status == DONE]
    told = [row for row in meshes if row.method == "order 1" and row.setting in (*LADDER, *FURTHER)]
    if told:
        parts = (f"{3 * row.setting**2 / 2:.0f} by {row.error:.2g} in {row.seconds:.2g} s" for row in told)
        yield f"Bilinear quadrilaterals on half the disc err: {', '.join(parts)}."
    for line in dict.fromkeys(row.method for row in meshes if row.method != ANOTHER.format("mesh")):
        good = [row for row in meshes if row.method == line and row.error <= 5e-3]
        if good:
            best = min(good, key=lambda row: row.seconds)
            yield f"{line}: {best.error:.2g} with {best.nodes} nodes in {best.seconds:.3g} s."
    finest = {word: [row for row in rows if row.method == INTEGRATION.format(word)] for word in LOCKING}
    if all(finest.values()):
        full, selective = finest["full"][-1], finest["selective"][-1]
        yield (
            f"At a Poisson's ratio of 0.499 bilinear elements err by {full.error:.2g} with full and by "
            f"{selective.error:.2g} with selective integration, {full.nodes} nodes: full locks."
        )
    yield from found_again(rows, {row.method for row in rows if not row.method.startswith(ANOTHER.format(""))})


CONTESTS = {
    "discs": Chart(
        judge=judge,
        problems=PROBLEMS,
        entries=entries,
        kind=DiscRow,
        command=_command,
        drawn=draw,
        told=reading,
    )
}
