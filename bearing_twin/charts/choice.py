"""The choices of the rules in every shipped scene, against every cheaper and dearer model that the scene may have.

A scene is run at its own tolerance and at 5 %, shortened. Others are models of what it leaves open: settings of steps,
steppers, elastic laws, contact points, beam theories, modes, steps and meshes. A model that gives other outputs is none
of them: equilibria have no friction. The reference is as in `tolerance`, with exact Hertz.
"""

import functools
import math
from collections.abc import Iterator

from bearing_twin.charts.contest import Contest, of_methods, of_problem, timed
from bearing_twin.charts.panels import CROSS, Axis, Line, Panel
from bearing_twin.charts.rows import DONE, Row
from bearing_twin.charts.scenes import run
from bearing_twin.charts.tolerance import EXACT, norm_of, scenes, shortened
from bearing_twin.kinds import rules
from bearing_twin.kinds.rules import SETTING, answers
from bearing_twin.pictures.style import BALL_COLOURS, STYLE
from bearing_twin.run.scene import choose, load_scene

CHOICE, LOOSE, LESS = "choice", 0.05, 0.5
DURATIONS = {"bearing": 0.1, "shaft": 0.05, "ellipsoid_on_plane": 0.6, "two_bodies": 0.05}  # s of a run at most
CHAOTIC = {"bearing_6203_guided_cage": 0.005}  # s: later no two settings agree
SHARES = (100.0, 30.0, 10.0, 3.0, 1.0 / 3.0, 0.1)  # of the chosen setting
LAWS = ("hertz_exact", "volumetric", "constant")
MESHES = ((1, 8), (1, 12), (1, 16), (1, 24), (2, 8), (2, 12), (3, 6), (3, 12), (3, 18), (3, 24), (3, 36))
EACH = 18  # scenes of a panel


@functools.cache
def problems() -> dict[str, tuple[str, float]]:
    """Scene and tolerance by the name of a problem."""
    own = {name: float(load_scene(name).parameters.wanted.tolerance) for name in scenes()}
    return {f"{name} at {100.0 * one:g} %": (name, one) for name in own for one in dict.fromkeys((own[name], LOOSE))}


def _given(name: str, tolerance: float) -> tuple[str, ...]:
    longest = CHAOTIC.get(name, DURATIONS.get(scenes()[name], math.inf))
    return (*shortened(name, longest), f"wanted.tolerance={tolerance:g}")


@functools.cache
def methods(problem: str) -> dict[str, tuple[str, ...]]:
    """Overrides of each model of a problem, by name: the choice, and all others that the scene may have."""
    name, tolerance = problems()[problem]
    scene = load_scene(name, _given(name, tolerance))
    kind, parameters, found = scene.kind, scene.parameters, {CHOICE: ()}
    answered = answers(kind, parameters)
    free = {key for key, one in answered.items() if one.rule is not None}
    still = kind == rules.BEARING and answered["model.dimension"].value == "quasi_static"
    if kind == rules.BEARING and {SETTING, "solver.stepper"} <= free and not still:
        setting = answered[SETTING].value
        for share in SHARES:
            if 1e-9 <= share * setting <= 0.1:
                found[f"steps at {share:.2g} of the setting"] = _steps("rodas4", share * setting)
        found |= {f"rodas3 at {share:g} of the setting": _steps("rodas3", share * setting) for share in (1.0, 0.1)}
        if parameters.cage.kind == "none":
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
        modes, steps = answered["solver.modes"].value, answered["solver.steps"].value
        for share in (0.5, 0.7, 1.5):
            few = max(2, round(share * modes)), max(2, round(share * steps))
            found[f"{share:g} of modes and steps"] = (f"solver.modes={few[0]}", f"solver.steps={few[1]}")
        if "beam.theory" in free:
            found |= {one: (f"beam.theory={one}",) for one in ("euler", "timoshenko")}
    if kind == rules.SOFT:
        for order, divisions in MESHES:
            found[f"{divisions} divisions of order {order}"] = (f"mesh.order={order}", f"mesh.divisions={divisions}")
    return found


def _steps(stepper: str, setting: float) -> tuple[str, ...]:
    return f"solver.stepper={stepper}", f"wanted.tolerance={setting:.3g}"


@functools.lru_cache(maxsize=2)
def _reference(name: str, tolerance: float):
    kind, parameters = scenes()[name], load_scene(name, _given(name, tolerance)).parameters
    chosen = [EXACT.get(kind, "wanted.tolerance=1e-10")]
    if kind == rules.BEAM:  # a scene whose theory a tolerance chooses is judged with what was chosen
        chosen.append(f"beam.theory={rules.pick(kind, 'beam.theory', parameters, parameters.beam.theory).value}")
    if kind in (rules.BEARING, rules.SHAFT) and parameters.contact.normal == "auto":
        chosen.append("contact.normal=hertz_exact")
    return run(name, (*_given(name, tolerance), *chosen), norm_of(kind)[1])


def _keys(problem: str, method: str) -> tuple[str, tuple[str, ...]]:
    """The scene of a run and its overrides."""
    name, tolerance = problems()[problem]
    return name, (*_given(name, tolerance), *methods(problem)[method])


def judge(problem: str, method: str, *_) -> dict:
    """Error and CPU time of a run as a user has it, and the tolerance requested."""
    name, keys = _keys(problem, method)
    (norm, channels), exact = norm_of(scenes()[name]), _reference(*problems()[problem])
    found, cost = timed(lambda: run(name, keys, channels))
    more = {"chosen": choose(load_scene(name, keys)).reason} if method == CHOICE else {}
    error, tolerance = norm(found, exact)["error"], problems()[problem][1]
    return {"error": error, **cost, "evaluations": found.evaluations, "tolerance": tolerance, **more}


def command(problem: str, method: str, *_) -> str:
    """The command that repeats a run."""
    name, keys = _keys(problem, method)
    return " ".join(["bearing_twin simulate", name, *(f"--set {word}" for word in keys)])


def entries(problem: str, quick: bool) -> Iterator[tuple[str, float, float]]:
    """The choice and the others; `quick`: three of them."""
    names = list(methods(problem))
    yield from ((name, math.nan, math.nan) for name in (names[:4] if quick else names))


def met(row: Row) -> bool:
    """True for a run that meets the tolerance requested."""
    return row.status == DONE and row.error <= float(row.more["tolerance"])


def cheaper(rows: list[Row], problem: str) -> list[Row]:
    """Models of a problem that meet the tolerance at less than half of the CPU time of the choice, cheapest first."""
    mine = {row.method: row for row in of_problem(rows, problem, DONE)}
    limit = LESS * mine[CHOICE].seconds if CHOICE in mine else 0.0
    return sorted((row for row in mine.values() if met(row) and row.seconds < limit), key=lambda row: row.seconds)


def read(contest: Contest, rows: list[Row]) -> Iterator[str]:
    """Numbers of choices that meet the tolerance, and that have no model of half their cost; the exceptions."""
    choices = of_methods(rows)[CHOICE]
    wrong = [row for row in choices if not met(row)]
    dear = [(row, found[0]) for row in choices if (found := cheaper(rows, row.problem))]
    yield (
        f"{len(choices) - len(wrong)} of {len(choices)} choices meet the tolerance; in {len(choices) - len(dear)} of "
        f"{len(choices)} no model that meets it takes less than half of the CPU time of the choice."
    )
    for row in wrong:
        yield f"{row.problem}: the error of the choice is {row.error:.2g}."
    for row, best in dear:
        share = best.seconds / row.seconds
        yield f"{row.problem}: {best.method} takes {share:.2g} of the time, with an error of {best.error:.2g}."


def panels(contest: Contest, rows: list[Row]) -> list[list[Panel]]:
    """Error over the tolerance, and CPU time over that of the choice: a line of points a scene."""
    sheet, seconds = [], {row.problem: row.seconds for row in of_methods(rows)[CHOICE] if row.status == DONE}
    for words, loose in (("at their own tolerance", False), ("at 5 %", True)):
        names = [one for one in seconds if one.endswith(" 5 %") == loose]
        for first in range(0, len(names), EACH):
            sheet.append(_scenes(rows, names[first : first + EACH][::-1], seconds, words))
    return sheet


LOOKS = {
    "choice": {"color": BALL_COLOURS[0], "marker": "o", "markersize": 9, "linestyle": ""},
    "others that meet the tolerance": {"color": BALL_COLOURS[2], "marker": "d", "markersize": 5, "linestyle": ""},
    "others that do not": {**CROSS, "color": STYLE["soft"], "markersize": 5, "markeredgewidth": 1.2},
}


def _scenes(rows: list[Row], names: list[str], seconds: dict[str, float], words: str) -> list[Panel]:
    short = tuple(name.partition(" at ")[0].removeprefix("bearing_").replace("_", " ") for name in names)
    points: dict[str, list] = {group: [] for group in reversed(LOOKS)}
    for row in (row for row in rows if row.problem in names and row.status == DONE):
        group = "choice" if row.method == CHOICE else [*LOOKS][1 if met(row) else 2]
        over = max(row.error / float(row.more["tolerance"]), 1e-6), row.seconds / seconds[row.problem]
        points[group].append((names.index(row.problem), *over))
    found, edge = [], {"color": STYLE["ink"], "linewidth": 1.2, "linestyle": ":"}
    for column, title, limit in (
        (1, "error over the tolerance", 1.0),
        (2, "CPU time over that of the choice", LESS),
    ):
        parts = [Line("", [limit] * 2, [-0.5, len(names) - 0.5], edge, False)]
        for group, each in points.items():
            parts.append(Line(group, [one[column] for one in each], [one[0] for one in each], LOOKS[group]))
        found.append(Panel(f"shipped scenes {words}", Axis(title, "1", log=True), Axis(""), parts, names=short))
    return found


class _Problems(dict):
    """Titles of problems; scenes are loaded when these are first read."""

    def __iter__(self):
        self.update((name, name) for name in problems())
        return super().__iter__()

    def __len__(self):
        return len(problems())


CHARTS = {
    "choice": Contest(
        title="What is chosen, against cheaper and dearer models",
        problems=_Problems(),
        entries=entries,
        judge=judge,
        command=command,
        panels=panels,
        read=read,
        error="error over the tolerance requested",
    )
}
