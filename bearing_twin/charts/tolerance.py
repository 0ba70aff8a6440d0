"""The error found against the tolerance requested, in every shipped scene, as it is shipped but for a shorter run.

The reference is the same scene far more exact; where no tolerance makes it so, on a far finer mesh. Scenes of laws and
beam theories that a tolerance chooses by are judged with what was chosen.
"""

import functools
import math
from collections.abc import Iterator

import numpy as np

from bearing_twin.charts.contest import Contest, numbers, timed
from bearing_twin.charts.panels import Axis, Line, Panel, curve, dashed
from bearing_twin.charts.rows import DONE
from bearing_twin.charts.scenes import contacts, greatest, load_and_friction, root_mean_square, run
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


def _keys(name: str) -> tuple[str, ...]:
    """Overrides of a scene: a run that is not longer than LONGEST."""
    longest, given = LONGEST.get(scenes()[name], math.inf), load_scene(name).parameters.run.duration
    return (f"run.duration={longest:g}",) if given > longest else ()


def _norm(kind: str):
    return NORMS.get(kind, (greatest("normal_load"), ("normal_load",)))


@functools.lru_cache(maxsize=2)
def _reference(name: str, chosen: tuple[str, ...]):
    kind = scenes()[name]
    exact = (*_keys(name), EXACT.get(kind, "wanted.tolerance=1e-10"), *chosen)
    return run(name, exact, _norm(kind)[1])


def judge(problem: str, name: str, tolerance: float, _: float) -> dict:
    """One scene at one tolerance."""
    kind = scenes()[name]
    norm, channels = _norm(kind)
    keys = (*_keys(name), f"wanted.tolerance={tolerance:g}")
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
    found = []
    ends, places = [min(TOLERANCES), max(TOLERANCES)], numbers(rows)
    for kind in dict.fromkeys(row.problem for row in rows):
        parts = [Line("error = tolerance", ends, ends, dashed(), False)]
        mine = [row for row in rows if row.problem == kind]
        for name in dict.fromkeys(row.method for row in mine):
            good = [(row.setting, max(row.error, FLOOR)) for row in mine if (row.method, row.status) == (name, DONE)]
            lost = [(row.setting, 1.0) for row in mine if row.method == name and row.status != DONE]
            parts += curve(name, good, places[name], lost)
        up = Axis("error found", log=True, limits=(FLOOR, 10.0))
        found.append(Panel(kind, kind.replace("_", " "), Axis("tolerance requested", log=True), up, parts, "best"))
    return [found[first : first + 2] for first in range(0, len(found), 2)]


def read(contest, rows) -> Iterator[str]:
    """How many runs meet their tolerance, by kind, and which do not."""
    for kind in dict.fromkeys(row.problem for row in rows):
        good = [row for row in rows if (row.problem, row.status) == (kind, DONE)]
        if not good:
            continue
        met = sum(row.error <= row.setting for row in good)
        ratio = float(np.median([row.error / row.setting for row in good]))
        missed = dict.fromkeys(f"{row.method} at {row.setting:g}" for row in good if row.error > row.setting)
        words = f"; not met: {', '.join(missed)}" if missed else ""
        yield (
            f"{kind.replace('_', ' ')}: {met} of {len(good)} runs meet the tolerance requested; the median error is "
            f"{ratio:.2g} of it{words}."
        )


class _Kinds(dict):
    """Titles by kind of scene, read when they are asked for: scenes are loaded then."""

    def __init__(self):
        from bearing_twin.kinds import KINDS

        super().__init__((name, kind.help) for name, kind in KINDS.items() if kind.home.startswith("bearing_twin."))


CHARTS = {
    "tolerance": Contest(
        title="Error found against tolerance requested, in every shipped scene",
        problems=_Kinds(),
        entries=entries,
        judge=judge,
        command=lambda kind, name, one, _: " ".join(
            ["bearing_twin simulate", name, *(f"--set {word}" for word in (*_keys(name), f"wanted.tolerance={one:g}"))]
        ),
        panels=panels,
        read=read,
    )
}
