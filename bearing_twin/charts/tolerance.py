"""The error found against the tolerance requested, in every shipped scene, as it is shipped but for a shorter run.

The reference is the same scene far more exact; where no tolerance makes it so, on a far finer mesh. Scenes of laws and
beam theories that a tolerance chooses by are judged with what was chosen.
"""

import functools
import math
from collections.abc import Iterator

import numpy as np

from bearing_twin.charts.contest import Contest, in_rows, of_methods, of_problem, timed
from bearing_twin.charts.panels import Axis, Line, Panel, curve, dashed
from bearing_twin.charts.rows import DONE
from bearing_twin.charts.scenes import contacts, greatest, load_and_friction, root_mean_square, run
from bearing_twin.kinds import KINDS, SHIPPED
from bearing_twin.run.scene import load_scene, scene_names
from bearing_twin.run.simulation import simulate

TOLERANCES, MESHES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5), (1e-1, 3e-2, 1e-2)  # of soft discs, whose reference is a mesh
FLOOR = 1e-9  # smaller errors are drawn here
LONGEST = {"bearing": 0.1, "shaft": 0.1, "ellipsoid_on_plane": 0.5, "two_bodies": 0.1}  # s of a run
NORMS = {  # by kind: the norm that a tolerance means there, and the channels it needs
    "bearing": (load_and_friction, ("normal_load", "friction_force")),
    "shaft": (greatest("left_normal_load", "right_normal_load"), ("left_normal_load", "right_normal_load")),
    "ellipsoid_on_plane": (contacts, ()),
    "two_bodies": (contacts, ()),
    "soft_discs": (root_mean_square("normal_load"), ("normal_load",)),
}
EXACT = {"soft_discs": "mesh.divisions=96", "bearing": "wanted.tolerance=1e-8", "shaft": "wanted.tolerance=1e-8"}


@functools.cache
def scenes() -> dict[str, str]:
    """Every shipped scene that is integrated, with its kind."""
    found = {name: load_scene(name) for name in scene_names()}
    return {
        name: scene.kind
        for name, scene in found.items()
        if getattr(getattr(scene.parameters, "model", None), "dimension", "") != "quasi_static"
    }


def shortened(name: str, longest: float | None = None) -> tuple[str, ...]:
    """Overrides of a scene: a run that is not longer than `longest`, by default that of its kind."""
    longest = LONGEST.get(scenes()[name], math.inf) if longest is None else longest
    return (f"run.duration={longest:g}",) if load_scene(name).parameters.run.duration > longest else ()


def norm_of(kind: str):
    """The norm of a kind of scene, and the channels it needs."""
    return NORMS.get(kind, (greatest("normal_load"), ("normal_load",)))


@functools.lru_cache(maxsize=2)
def _reference(name: str, chosen: tuple[str, ...]):
    kind = scenes()[name]
    return run(name, (*shortened(name), EXACT.get(kind, "wanted.tolerance=1e-10"), *chosen), norm_of(kind)[1])


def judge(problem: str, name: str, tolerance: float, _: float) -> dict:
    """One scene at one tolerance."""
    kind = scenes()[name]
    (norm, channels), keys = norm_of(kind), (*shortened(name), f"wanted.tolerance={tolerance:g}")
    choice = simulate(load_scene(name, keys)).choice
    law = (f"contact.normal={choice.law}",) if choice.law and kind in ("bearing", "shaft", "two_bodies") else ()
    exact = _reference(name, law)
    found, cost = timed(lambda: run(name, keys, channels))
    return {**norm(found, exact), **cost, "evaluations": found.evaluations}


def entries(kind: str, quick: bool) -> Iterator[tuple[str, float, float]]:
    """Every scene of a kind at every tolerance; `quick`: its last scene at two."""
    names = [name for name, one in scenes().items() if one == kind]
    ladder = MESHES if kind == "soft_discs" else TOLERANCES
    for name in names[-1:] if quick else names:
        yield from ((name, one, math.nan) for one in (ladder[1:3] if quick else ladder))


def panels(contest, rows) -> list[list[Panel]]:
    """A panel a kind: tolerance across, error up, a line a scene; on the dashed line they are equal."""
    found, ends, scenes = [], [min(TOLERANCES), max(TOLERANCES)], [*of_methods(rows)]
    for kind in contest.problems:
        parts = [Line("error = tolerance", ends, ends, dashed(), False)]
        for name, mine in of_methods(of_problem(rows, kind)).items():
            good = [(row.setting, max(row.error, FLOOR)) for row in mine if row.status == DONE]
            lost = [(row.setting, 1.0) for row in mine if row.status != DONE]
            parts += curve(name, good, scenes.index(name), lost)
        up = Axis("error found", log=True, limits=(FLOOR, 10.0))
        if len(parts) > 1:
            found.append(Panel(kind.replace("_", " "), Axis("tolerance requested", log=True), up, parts))
    return in_rows(found, 2)


def read(contest, rows) -> Iterator[str]:
    """Numbers of runs that meet their tolerance, by kind, and those that do not."""
    for kind in contest.problems:
        if not (good := of_problem(rows, kind, DONE)):
            continue
        missed = dict.fromkeys(f"{row.method} at {row.setting:g}" for row in good if row.error > row.setting)
        met, ratio = sum(row.error <= row.setting for row in good), np.median([row.error / row.setting for row in good])
        words = f"; not met: {', '.join(missed)}" if missed else ""
        yield (
            f"{kind.replace('_', ' ')}: {met} of {len(good)} runs meet the tolerance requested; the median error is "
            f"{ratio:.2g} of it{words}."
        )


def command(kind: str, name: str, tolerance: float, _: float) -> str:
    """The command that repeats a run."""
    words = (f"--set {word}" for word in (*shortened(name), f"wanted.tolerance={tolerance:g}"))
    return " ".join(["bearing_twin simulate", name, *words])


CHARTS = {
    "tolerance": Contest(
        title="Error found against tolerance requested, in every shipped scene",
        problems={name: KINDS[name].help for name in SHIPPED},
        entries=entries,
        judge=judge,
        command=command,
        panels=panels,
        read=read,
    )
}
