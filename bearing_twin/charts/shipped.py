"""Charts of every shipped scene that is integrated: the error at a requested tolerance, and the choices of the rules.

Scenes are as shipped but for shorter runs. `tolerance`: the error found against the tolerance requested. `choice`: a
scene at its own tolerance and at 5 %, against all other models of what it leaves open: settings of steps, steppers,
elastic laws, contact points, beam theories, modes, steps and meshes. A model that gives other outputs is none of them:
equilibria have no friction. The reference is the same scene far more exact, on a far finer mesh where no tolerance
makes it so, with exact Hertz and the beam theory that was chosen. `cost`: CPU time of a run by the way it is taken.
"""

import collections
import dataclasses
import functools
import math
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bearing_twin.charts.contest import (
    CROSS,
    DONE,
    Contest,
    PanelRows,
    Problem,
    Row,
    Styles,
    by_method,
    curves,
    rows_of,
    timed,
)
from bearing_twin.charts.scenes import (
    WITHOUT_CHECK,
    Method,
    SceneProblem,
    greatest_difference,
    load_and_friction,
    peak_loads,
    root_mean_square,
    tolerances,
)
from bearing_twin.kinds import SHIPPED, rules
from bearing_twin.kinds.rules import SETTING, answers
from bearing_twin.log.run_log import write_log
from bearing_twin.pictures import BALL_COLOURS, STYLE, Axis, Line, Panel, in_rows, line_style, reference_style
from bearing_twin.run.scene import load_scene, scene_names
from bearing_twin.run.simulation import simulate

TOLERANCES, MESHES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5), (1e-1, 3e-2, 1e-2)  # of soft discs, whose reference is a mesh
LONGEST = {"bearing": 0.1, "shaft": 0.05, "ellipsoid_on_plane": 0.5, "two_bodies": 0.05}  # s of a run
CHAOTIC = {"bearing_6203_guided_cage": 0.005}  # s: later no two settings agree
FLOOR = 1e-9  # smaller errors are drawn here
IMPACT_NORM = (peak_loads, ())
NORMS = {  # by kind: the norm that a tolerance means there, and the channels it needs
    "bearing": (load_and_friction, ("normal_load", "friction_force")),
    "shaft": (greatest_difference("left_normal_load", "right_normal_load"), ("left_normal_load", "right_normal_load")),
    "ellipsoid_on_plane": IMPACT_NORM,
    "two_bodies": IMPACT_NORM,
    "soft_discs": (root_mean_square("normal_load"), ("normal_load",)),
}
EXACT = {"soft_discs": "mesh.divisions=96", "bearing": "wanted.tolerance=1e-8", "shaft": "wanted.tolerance=1e-8"}


@functools.cache
def scenes() -> dict[str, str]:
    """Every shipped scene that is integrated to a tolerance, with its kind."""
    scenes_by_name = {name: load_scene(name) for name in scene_names()}
    return {
        name: scene.kind
        for name, scene in scenes_by_name.items()
        if hasattr(scene.parameters, "wanted")
        and getattr(getattr(scene.parameters, "model", None), "dimension", "") != "quasi_static"
    }


def _problem(name: str, methods: dict[str, Method], tolerance: float | None = None) -> SceneProblem:
    """A scene with these methods, at one tolerance if it is given."""
    kind, run = scenes()[name], load_scene(name).parameters.run
    longest = CHAOTIC.get(name, LONGEST.get(kind, math.inf))
    overrides = (f"run.duration={longest:g}",) if run.duration > longest else ()
    overrides += () if tolerance is None else (f"wanted.tolerance={tolerance:g}",)
    parameters, exact = load_scene(name, overrides).parameters, [EXACT.get(kind, "wanted.tolerance=1e-10")]
    if kind == rules.BEAM:
        exact.append(f"beam.theory={rules.pick(kind, 'beam.theory', parameters, parameters.beam.theory).value}")
    if kind in (rules.BEARING, rules.SHAFT) and parameters.contact.normal == "auto":
        exact.append("contact.normal=hertz_exact")
    norm, channels = NORMS.get(kind, (greatest_difference("normal_load"), ("normal_load",)))
    return SceneProblem(
        title=name,
        scene=name,
        overrides=overrides,
        reference=tuple(exact),
        methods=methods,
        norm=norm,
        channels=channels,
        extra={} if tolerance is None else {"tolerance": tolerance},
    )


def _requested(name: str) -> SceneProblem:
    """A scene at every tolerance."""
    return _problem(name, {name: tolerances(*(MESHES if scenes()[name] == "soft_discs" else TOLERANCES))})


def _by_kind(rows: list[Row]) -> Iterator[tuple[str, list[Row]]]:
    """Rows of each kind of scenes that has some."""
    for kind in SHIPPED:
        if runs := [row for row in rows if scenes().get(row.problem) == kind]:
            yield kind.replace("_", " "), runs


def _tolerance_panels(contest: Contest, rows: list[Row], styles: Styles) -> PanelRows:
    """A panel a kind: tolerance across, error up, a line a scene; on the dashed line they are equal."""
    panels, ends = [], [min(TOLERANCES), max(TOLERANCES)]
    across, up = Axis("tolerance requested", log=True), Axis("error found", log=True, limits=(0.3 * FLOOR, 2.0))
    for kind, runs in _by_kind(rows):
        lines = curves(
            runs, styles, lambda row: row.setting, lambda row: max(row.error, FLOOR), lambda row: (row.setting, 1.0)
        )
        panels.append(Panel(kind, across, up, [Line("error = tolerance", ends, ends, reference_style()), *lines]))
    return in_rows(panels, 2)


def _tolerance_reading(contest: Contest, rows: list[Row]) -> Iterator[str]:
    """Number of runs that meet their tolerance, those that do not, and median errors by kind."""
    ended = [row for row in rows if row.status == DONE]
    missed = [f"{row.method} at {row.setting:g}" for row in ended if row.error > row.setting]
    missed_text = f"; not met: {', '.join(missed)}" if missed else ""
    yield f"{len(ended) - len(missed)} of {len(ended)} runs meet the tolerance requested{missed_text}."
    medians = (f"{kind} {np.median([row.error / row.setting for row in runs]):.1g}" for kind, runs in _by_kind(ended))
    if ended:
        yield f"Median error over the tolerance: {', '.join(medians)}."


CHOICE, LOOSE, CHEAPER_SHARE = "choice", 0.05, 0.5
SHARES = (100.0, 30.0, 10.0, 3.0, 1.0 / 3.0, 0.1)  # of the chosen setting
LAWS = {"contact.normal": ("hertz_exact", "volumetric", "constant")}
CLOSED = {"solver.stepper": ("closed_form", "dop853")}
ALTERNATIVES = {  # by kind: keys that rules answer, and what else they may be
    **dict.fromkeys((rules.BEARING, rules.SHAFT, rules.ELLIPSOID), LAWS),
    **dict.fromkeys((rules.SPHERES, rules.DISCS), CLOSED),
    rules.BODIES: {"contact.tracking": ("closed", "algebraic", "differential")},
    rules.BEAM: {"beam.theory": ("euler", "timoshenko")},
}
DIVISIONS = ((1, 8), (1, 12), (1, 16), (1, 24), (2, 8), (2, 12), (3, 6), (3, 12), (3, 18), (3, 24), (3, 36))
GROUP_STYLES = {
    "choice": {"color": BALL_COLOURS[0], "marker": "o", "markersize": 9, "linestyle": ""},
    "others that meet the tolerance": {"color": BALL_COLOURS[2], "marker": "d", "markersize": 5, "linestyle": ""},
    "others that miss the tolerance": {**CROSS, "color": STYLE["soft"], "markersize": 5, "markeredgewidth": 1.2},
}


@functools.cache
def at_tolerances() -> dict[str, tuple[str, float]]:
    """Scene and tolerance by the name of a problem."""
    tolerances = {name: float(load_scene(name).parameters.wanted.tolerance) for name in scenes()}
    pairs = dict.fromkeys((name, tolerance) for name in scenes() for tolerance in (tolerances[name], LOOSE))
    return {f"{name} at {100.0 * tolerance:g} %": (name, tolerance) for name, tolerance in pairs}


def _chosen(problem: str) -> SceneProblem:
    """A scene at one tolerance: the choice, and all other models that it may have."""
    name, tolerance = at_tolerances()[problem]
    bare = _problem(name, {}, tolerance)
    scene = load_scene(name, bare.overrides)
    kind, answered = scene.kind, answers(scene.kind, scene.parameters)
    free = {key for key, answer in answered.items() if answer.rule is not None}
    models: dict[str, tuple[str, ...]] = {CHOICE: ()}  # overrides by name
    moves = kind == rules.BEARING and answered["model.dimension"].value != "quasi_static"
    if moves and {SETTING, "solver.stepper"} <= free:
        setting = answered[SETTING].value
        for share in SHARES:
            if 1e-9 <= share * setting <= 0.1:
                models[f"steps at {share:.2g} of the setting"] = _steps("rodas4", share * setting)
        for share in (1.0, 0.1):
            models[f"rodas3 at {share:g} of the setting"] = _steps("rodas3", share * setting)
        if scene.parameters.cage.kind == "none":
            models["rodas4_landing"] = _steps("rodas4_landing", setting)
    elif kind in (rules.SHAFT, rules.ELLIPSOID, rules.BODIES):
        for share in (100.0, 10.0, 0.1):
            models[f"tolerance {share:g} times"] = (f"wanted.tolerance={min(share * tolerance, 0.1):g}",)
    for key, values in ALTERNATIVES.get(kind, {}).items():
        models |= {value: (f"{key}={value}",) for value in values if key in free}
    if kind == rules.BEAM:
        for share in (0.5, 0.7, 1.5):
            models[f"{share:g} of modes and steps"] = tuple(
                f"{key}={max(2, round(share * answered[key].value))}" for key in ("solver.modes", "solver.steps")
            )
    if kind == rules.SOFT:
        for order, divisions in DIVISIONS:
            models[f"{divisions} divisions of order {order}"] = f"mesh.order={order}", f"mesh.divisions={divisions}"
    methods = {model: Method(overrides) for model, overrides in models.items()}
    return dataclasses.replace(_problem(name, methods, tolerance), title=problem)


def _steps(stepper: str, setting: float) -> tuple[str, ...]:
    return f"solver.stepper={stepper}", f"wanted.tolerance={setting:.3g}"


def met(row: Row) -> bool:
    """True for a run that meets the tolerance requested."""
    return row.status == DONE and row.error <= float(row.more["tolerance"])


def cheaper(rows: list[Row], choice: Row) -> list[Row]:
    """Models that meet the tolerance at less than half of the CPU time of the choice, cheapest first."""
    runs = (row for row in rows_of(rows, choice.problem, DONE) if met(row))
    return sorted((row for row in runs if row.seconds < CHEAPER_SHARE * choice.seconds), key=lambda row: row.seconds)


def _choice_reading(contest: Contest, rows: list[Row]) -> Iterator[str]:
    """Numbers of choices that meet the tolerance, and that have no model of half their cost; the exceptions."""
    choices = by_method(rows)[CHOICE]
    missed = [row for row in choices if not met(row)]
    dearer = [(row, models[0]) for row in choices if (models := cheaper(rows, row))]
    yield (
        f"{len(choices) - len(missed)} of {len(choices)} choices meet the tolerance; in {len(choices) - len(dearer)} "
        f"of {len(choices)} no model that meets it takes less than half of the CPU time of the choice."
    )
    for row in (row for row in missed if row.status == DONE):
        yield f"{row.problem}: the error of the choice is {row.error:.2g}."
    for row, best in dearer:
        share = best.seconds / row.seconds
        yield f"{row.problem}: {best.method} takes {share:.2g} of the time, with an error of {best.error:.2g}."


def _choice_panels(contest: Contest, rows: list[Row], styles: Styles) -> PanelRows:
    """Error over the tolerance and CPU time over that of the choice: better models are left of and below both lines."""
    seconds = {row.problem: row.seconds for row in by_method(rows)[CHOICE] if row.status == DONE}
    rows = [row for row in rows if row.status == DONE and row.problem in seconds]
    across, up = Axis("error over the tolerance", log=True), Axis("CPU time over that of the choice", log=True)
    edge, panels = {"color": STYLE["ink"], "linewidth": 1.2, "linestyle": ":"}, []
    for title, loose in (("at their own tolerance", False), ("at 5 %", True)):
        if not (runs := [row for row in rows if row.problem.endswith(" 5 %") == loose]):
            continue
        groups = np.array([0 if row.method == CHOICE else 2 - met(row) for row in runs])
        points = np.array(
            [(max(row.error / float(row.more["tolerance"]), FLOOR), row.seconds / seconds[row.problem]) for row in runs]
        )
        x, y = ((coordinates.min(), coordinates.max()) for coordinates in points.T)
        limits = "the tolerance, and half of the time of the choice"
        parts = [Line(limits, [1.0, 1.0], y, edge), Line("", x, [CHEAPER_SHARE, CHEAPER_SHARE], edge, False)]
        for group_index, (group, style) in reversed([*enumerate(GROUP_STYLES.items())]):
            parts.append(Line(group, *points[groups == group_index].T, style))
        panels.append(Panel(f"shipped scenes {title}", across, up, parts))
    return [panels]


RATE = 1000  # outputs a second


def _exhaust(outputs) -> None:
    collections.deque(outputs, maxlen=0)


def _log(run) -> None:
    with tempfile.TemporaryDirectory() as folder:
        write_log(run, Path(folder) / "run.mcap")


STAGES = {
    "blocks of outputs": (lambda run: _exhaust(run.blocks()), (WITHOUT_CHECK,)),
    "blocks, with a second run": (lambda run: _exhaust(run.blocks()), ()),
    "single outputs": (_exhaust, (WITHOUT_CHECK,)),
    "written to a log": (_log, (WITHOUT_CHECK,)),
}


def _staged(title: str, scene: str, span: float) -> Problem:
    """A scene over `span` [s]: each way to take its run, in CPU seconds a simulated second."""

    def judge(stage: str, *_) -> dict:
        work, keys = STAGES[stage]
        run = simulate(load_scene(scene, (f"run.duration={span:g}", f"run.output_rate={RATE}", *keys)))
        return {"error": 0.0, **timed(lambda: work(run), span)[1]}

    return Problem(title, lambda quick: ((stage, math.nan, math.nan) for stage in STAGES), judge)


def _cost_panels(contest: Contest, rows: list[Row], styles: Styles) -> PanelRows:
    """A panel a run: a bar a stage, from 0."""
    axis, up = Axis(contest.cost, "s", limits=(0.0, None)), Axis("", limits=(-0.6, len(STAGES) - 0.4))
    bar, panels = {"color": line_style(0)["color"], "linewidth": 14.0, "solid_capstyle": "butt"}, []
    for title, runs in contest.by_title(rows):
        bars = [Line(row.method, [0.0, row.seconds], [index] * 2, bar, False) for index, row in enumerate(runs)]
        panels.append(Panel(title, axis, up, bars, None, names=tuple(row.method for row in runs)))
    return [panels]


CHARTS = {
    "tolerance": Contest(
        problems={name: _requested(name) for name in scenes()},
        title="Error found against tolerance requested, in every shipped scene",
        panels=_tolerance_panels,
        read=_tolerance_reading,
    ),
    "choice": Contest(
        problems={name: _chosen(name) for name in at_tolerances()},
        title="Automatic choice against all other models: error and cost",
        panels=_choice_panels,
        read=_choice_reading,
        error="error over the tolerance requested",
    ),
    "cost": Contest(
        title=f"Where the CPU time of a run goes ({RATE} outputs a simulated second, one core)",
        problems={
            "settled": _staged("6203, settled", "bearing_6203", 1.0),
            "loose": _staged("6203 with clearance, lift-off", "bearing_6203_loose", 0.3),
            "shaft": _staged("rotor between two 6203", "shaft_two_6203", 0.1),
        },
        panels=_cost_panels,
        cost="CPU time of a simulated second",
        requested_error=math.inf,
    ),
}
