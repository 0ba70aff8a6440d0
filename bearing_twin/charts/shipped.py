"""Charts of every shipped scene that is integrated: the error at a requested tolerance, and the choices of the rules.

Scenes are as shipped but for shorter runs. `tolerance`: the error found against the tolerance requested. `choice`: a
scene at its own tolerance and at 5 %, against all other models of what it leaves open: settings of steps, steppers,
elastic laws, contact points, beam theories, modes, steps and meshes. A model that gives other outputs is none of them:
equilibria have no friction. The reference is the same scene far more exact, on a far finer mesh where no tolerance
makes it so, with exact Hertz and the beam theory that was chosen.
"""

import functools
import math
from collections.abc import Iterator

import numpy as np

from bearing_twin.base.yaml_files import SCENES
from bearing_twin.charts.contest import Contest, curves, in_rows, of_methods, of_problem
from bearing_twin.charts.panels import CROSS, Axis, Line, Panel, dashed
from bearing_twin.charts.rows import DONE, Row
from bearing_twin.charts.scenes import (
    Lazily,
    Method,
    Problem,
    Scenes,
    contacts,
    greatest,
    load_and_friction,
    root_mean_square,
    tolerances,
)
from bearing_twin.kinds import SHIPPED, rules
from bearing_twin.kinds.rules import SETTING, answers
from bearing_twin.pictures import BALL_COLOURS, STYLE
from bearing_twin.run.scene import load_scene, scene_names

TOLERANCES, MESHES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5), (1e-1, 3e-2, 1e-2)  # of soft discs, whose reference is a mesh
LONGEST = {"bearing": 0.1, "shaft": 0.05, "ellipsoid_on_plane": 0.5, "two_bodies": 0.05}  # s of a run
CHAOTIC = {"bearing_6203_guided_cage": 0.005}  # s: later no two settings agree
FLOOR = 1e-9  # smaller errors are drawn here
ON_PLANES = (contacts, ())
NORMS = {  # by kind: the norm that a tolerance means there, and the channels it needs
    "bearing": (load_and_friction, ("normal_load", "friction_force")),
    "shaft": (greatest("left_normal_load", "right_normal_load"), ("left_normal_load", "right_normal_load")),
    "ellipsoid_on_plane": ON_PLANES,
    "two_bodies": ON_PLANES,
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


def _problem(name: str, methods: dict[str, Method], tolerance: float | None = None) -> Problem:
    """A scene with these methods, at one tolerance if it is given."""
    kind, run = scenes()[name], load_scene(name).parameters.run
    longest = CHAOTIC.get(name, LONGEST.get(kind, math.inf))
    keys = (f"run.duration={longest:g}",) if run.duration > longest else ()
    keys += () if tolerance is None else (f"wanted.tolerance={tolerance:g}",)
    parameters, exact = load_scene(name, keys).parameters, [EXACT.get(kind, "wanted.tolerance=1e-10")]
    if kind == rules.BEAM:
        exact.append(f"beam.theory={rules.pick(kind, 'beam.theory', parameters, parameters.beam.theory).value}")
    if kind in (rules.BEARING, rules.SHAFT) and parameters.contact.normal == "auto":
        exact.append("contact.normal=hertz_exact")
    norm, channels = NORMS.get(kind, (greatest("normal_load"), ("normal_load",)))
    return Problem(
        title=name,
        scene=name,
        keys=keys,
        reference=tuple(exact),
        methods=methods,
        norm=norm,
        channels=channels,
        more={} if tolerance is None else {"tolerance": tolerance},
    )


def _requested(name: str) -> Problem:
    """A scene at every tolerance."""
    return _problem(name, {name: tolerances(*(MESHES if scenes()[name] == "soft_discs" else TOLERANCES))})


def _by_kind(rows: list[Row]) -> Iterator[tuple[str, list[Row]]]:
    """Rows of each kind of scenes that has some."""
    kinds = {head["name"]: head["kind"] for head in SCENES.heads()}
    for kind in SHIPPED:
        if mine := [row for row in rows if kinds.get(row.problem) == kind]:
            yield kind.replace("_", " "), mine


def _tolerance_panels(contest: Contest, rows: list[Row]) -> list[list[Panel]]:
    """A panel a kind: tolerance across, error up, a line a scene; on the dashed line they are equal."""
    found, ends, order = [], [min(TOLERANCES), max(TOLERANCES)], [*of_methods(rows)]
    across, up = Axis("tolerance requested", log=True), Axis("error found", log=True, limits=(FLOOR, 10.0))
    for kind, mine in _by_kind(rows):
        lines = curves(
            mine, order, lambda row: row.setting, lambda row: max(row.error, FLOOR), lambda row: (row.setting, 1.0)
        )
        found.append(Panel(kind, across, up, [Line("error = tolerance", ends, ends, dashed(), False), *lines]))
    return in_rows(found, 2)


def _tolerance_reading(contest: Contest, rows: list[Row]) -> Iterator[str]:
    """Numbers of runs that meet their tolerance, by kind, and those that do not."""
    for kind, mine in _by_kind([row for row in rows if row.status == DONE]):
        missed = [f"{row.method} at {row.setting:g}" for row in mine if row.error > row.setting]
        words = f"; not met: {', '.join(missed)}" if missed else ""
        yield (
            f"{kind}: {len(mine) - len(missed)} of {len(mine)} runs meet the tolerance requested; the median error is "
            f"{np.median([row.error / row.setting for row in mine]):.2g} of it{words}."
        )


CHOICE, LOOSE, LESS = "choice", 0.05, 0.5
SHARES = (100.0, 30.0, 10.0, 3.0, 1.0 / 3.0, 0.1)  # of the chosen setting
LAWS = ("hertz_exact", "volumetric", "constant")
DIVISIONS = ((1, 8), (1, 12), (1, 16), (1, 24), (2, 8), (2, 12), (3, 6), (3, 12), (3, 18), (3, 24), (3, 36))
EACH = 18  # scenes of a panel
LOOKS = {
    "choice": {"color": BALL_COLOURS[0], "marker": "o", "markersize": 9, "linestyle": ""},
    "others that meet the tolerance": {"color": BALL_COLOURS[2], "marker": "d", "markersize": 5, "linestyle": ""},
    "others that miss the tolerance": {**CROSS, "color": STYLE["soft"], "markersize": 5, "markeredgewidth": 1.2},
}


@functools.cache
def at_tolerances() -> dict[str, tuple[str, float]]:
    """Scene and tolerance by the name of a problem."""
    own = {name: float(load_scene(name).parameters.wanted.tolerance) for name in scenes()}
    return {f"{name} at {100.0 * one:g} %": (name, one) for name in own for one in dict.fromkeys((own[name], LOOSE))}


def _chosen(problem: str) -> Problem:
    """A scene at one tolerance: the choice, and all other models that it may have."""
    name, tolerance = at_tolerances()[problem]
    bare = _problem(name, {}, tolerance)
    scene = load_scene(name, bare.keys)
    kind, answered = scene.kind, answers(scene.kind, scene.parameters)
    free = {key for key, one in answered.items() if one.rule is not None}
    found: dict[str, tuple[str, ...]] = {CHOICE: ()}
    moves = kind == rules.BEARING and answered["model.dimension"].value != "quasi_static"
    if moves and {SETTING, "solver.stepper"} <= free:
        setting = answered[SETTING].value
        for share in SHARES:
            if 1e-9 <= share * setting <= 0.1:
                found[f"steps at {share:.2g} of the setting"] = _steps("rodas4", share * setting)
        found |= {f"rodas3 at {share:g} of the setting": _steps("rodas3", share * setting) for share in (1.0, 0.1)}
        if scene.parameters.cage.kind == "none":
            found["rodas4_landing"] = _steps("rodas4_landing", setting)
    elif kind in (rules.SHAFT, rules.ELLIPSOID, rules.BODIES):
        for share in (100.0, 10.0, 0.1):
            found[f"tolerance {share:g} times"] = (f"wanted.tolerance={min(share * tolerance, 0.1):g}",)
    if "contact.normal" in free and kind in (rules.BEARING, rules.SHAFT, rules.ELLIPSOID):
        found |= {law: (f"contact.normal={law}",) for law in LAWS}
    if kind in (rules.SPHERES, rules.DISCS) and "solver.stepper" in free:
        found |= {one: (f"solver.stepper={one}",) for one in ("closed_form", "dop853")}
    if kind == rules.BODIES:
        found |= {one: (f"contact.tracking={one}",) for one in ("closed", "algebraic", "differential")}
    if kind == rules.BEAM:
        for share in (0.5, 0.7, 1.5):
            few = {key: max(2, round(share * answered[key].value)) for key in ("solver.modes", "solver.steps")}
            found[f"{share:g} of modes and steps"] = tuple(f"{key}={one}" for key, one in few.items())
        if "beam.theory" in free:
            found |= {one: (f"beam.theory={one}",) for one in ("euler", "timoshenko")}
    if kind == rules.SOFT:
        for order, divisions in DIVISIONS:
            found[f"{divisions} divisions of order {order}"] = (f"mesh.order={order}", f"mesh.divisions={divisions}")
    return _problem(name, {method: Method(keys) for method, keys in found.items()}, tolerance)


def _steps(stepper: str, setting: float) -> tuple[str, ...]:
    return f"solver.stepper={stepper}", f"wanted.tolerance={setting:.3g}"


def met(row: Row) -> bool:
    """True for a run that meets the tolerance requested."""
    return row.status == DONE and row.error <= float(row.more["tolerance"])


def cheaper(rows: list[Row], choice: Row) -> list[Row]:
    """Models that meet the tolerance at less than half of the CPU time of the choice, cheapest first."""
    mine = (row for row in of_problem(rows, choice.problem, DONE) if met(row))
    return sorted((row for row in mine if row.seconds < LESS * choice.seconds), key=lambda row: row.seconds)


def _choice_reading(contest: Contest, rows: list[Row]) -> Iterator[str]:
    """Numbers of choices that meet the tolerance, and that have no model of half their cost; the exceptions."""
    choices = of_methods(rows)[CHOICE]
    wrong = [row for row in choices if not met(row)]
    dear = [(row, found[0]) for row in choices if (found := cheaper(rows, row))]
    yield (
        f"{len(choices) - len(wrong)} of {len(choices)} choices meet the tolerance; in {len(choices) - len(dear)} of "
        f"{len(choices)} no model that meets it takes less than half of the CPU time of the choice."
    )
    for row in wrong:
        yield f"{row.problem}: the error of the choice is {row.error:.2g}."
    for row, best in dear:
        share = best.seconds / row.seconds
        yield f"{row.problem}: {best.method} takes {share:.2g} of the time, with an error of {best.error:.2g}."


def _choice_panels(contest: Contest, rows: list[Row]) -> list[list[Panel]]:
    """Error over the tolerance, and CPU time over that of the choice: a line of points a scene."""
    seconds = {row.problem: row.seconds for row in of_methods(rows)[CHOICE] if row.status == DONE}
    rows = [row for row in rows if row.status == DONE and row.problem in seconds]
    edge, sheet = {"color": STYLE["ink"], "linewidth": 1.2, "linestyle": ":"}, []

    def panel(title: str, what: str, limit: float, names: list[str], value) -> Panel:
        parts = [Line("", [limit] * 2, [-0.5, len(names) - 0.5], edge, False)]
        for place, (group, look) in reversed([*enumerate(LOOKS.items())]):
            here = [
                row for row in rows if row.problem in names and place == (0 if row.method == CHOICE else 2 - met(row))
            ]
            parts.append(Line(group, [*map(value, here)], [names.index(row.problem) for row in here], look))
        short = tuple(name.partition(" at ")[0].removeprefix("bearing_").replace("_", " ") for name in names)
        return Panel(f"shipped scenes {title}", Axis(what, "1", log=True), Axis(""), parts, names=short)

    def error(row: Row) -> float:
        return max(row.error / float(row.more["tolerance"]), 1e-6)

    def cost(row: Row) -> float:
        return row.seconds / seconds[row.problem]

    for title, loose in (("at their own tolerance", False), ("at 5 %", True)):
        names = [one for one in seconds if one.endswith(" 5 %") == loose]
        for first in range(0, len(names), EACH):
            part = names[first : first + EACH][::-1]
            errors = panel(title, "error over the tolerance", 1.0, part, error)
            sheet.append([errors, panel(title, "CPU time over that of the choice", LESS, part, cost)])
    return sheet


CHARTS = {
    "tolerance": Scenes(table=Lazily(scenes, _requested)).contest(
        title="Error found against tolerance requested, in every shipped scene",
        panels=_tolerance_panels,
        read=_tolerance_reading,
    ),
    "choice": Scenes(table=Lazily(at_tolerances, _chosen)).contest(
        title="Automatic choice against all other models: error and cost",
        panels=_choice_panels,
        read=_choice_reading,
        error="error over the tolerance requested",
    ),
}
