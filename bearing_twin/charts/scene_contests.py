"""Contests of the kinds beside the bearing: two bodies that meet, a sphere on a beam, bodies that are tracked.

The force over time is compared at the same instants, over the greatest; truth is `true` of each problem, a far tighter
setting. Seconds are CPU seconds of a whole run, reading the scene and all outputs included.
"""

from typing import NamedTuple

from bearing_twin.charts.contest_picture import Contest
from bearing_twin.charts.scene_rows import command_of, scene_row
from bearing_twin.charts.table import DONE, STOPPED, Row


class Field(NamedTuple):
    """A method: the overrides that choose it, the key that its settings go to, and those settings."""

    fixed: tuple[str, ...]
    key: str
    ladder: tuple[float, ...]


class SceneProblem(NamedTuple):
    """A scene of a contest: overrides of all runs, those of the truth, and what takes part."""

    scene: str
    always: tuple[str, ...]
    true: tuple[str, ...]
    fields: dict[str, Field]


TIGHT, LADDER = ("wanted.tolerance=1e-12",), (1e-2, 1e-4, 1e-6, 1e-8, 1e-10)
CONTACT, DISCS, ELLIPSOID = 7.13e-5, 6.49e-3, 5.1e-5  # s, of two spheres, of two discs, the shortest of an ellipsoid
CLOSED, FIXED = "closed_form", ("rk4", "symplectic_euler")


def _pair(scene: str, contact: float, *always: str, steppers: tuple[str, ...] = (CLOSED, *FIXED)) -> SceneProblem:
    """A contact of about that many seconds, by these steppers and by `dop853`; outputs are 440 in 1.23 of it."""
    steps = tuple(contact / count for count in (4, 8, 16, 32, 64, 128, 512))
    fields = {"dop853": Field(("solver.stepper=dop853",), "wanted.tolerance", LADDER)}
    for one in steppers:
        ladder = Field((), "wanted.tolerance", (1e-6,)) if one == CLOSED else Field((), "solver.step", steps)
        fields[one] = ladder._replace(fixed=(f"solver.stepper={one}",))
    same = (*always, f"run.duration={1.23 * contact:.3g}", f"run.output_rate={360.0 / contact:.3g}")
    return SceneProblem(scene, same, ("solver.stepper=dop853", *TIGHT), fields)


def _beam(scene: str, *always: str) -> SceneProblem:
    steps = (12, 24, 48, 96, 192, 384)
    fields = {
        "tolerance": Field((), "wanted.tolerance", (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8)),
        "modes, 9": Field(("solver.stepper=modes", "solver.modes=9"), "solver.steps", steps),
        "modes, 41": Field(("solver.stepper=modes", "solver.modes=41"), "solver.steps", steps),
        "volterra": Field(
            ("solver.stepper=volterra", "solver.modes=301"), "solver.steps", (8, 16, 30, 60, 120, 250, 500, 1000)
        ),
        "sinusoidal": Field(("solver.stepper=sinusoidal",), "wanted.tolerance", (1e-6,)),
    }
    same = ("beam.theory=euler", "run.output_rate=1e6", "run.publish_rate=1e6", *always)
    return SceneProblem(scene, same, ("wanted.tolerance=1e-9",), fields)


PAIRS = {
    "elastic spheres": _pair("two_spheres", CONTACT),
    "spheres, restitution 0.8": _pair("two_spheres", CONTACT, "contact.restitution=0.8", steppers=FIXED),
    "discs, line contact": _pair("two_discs", DISCS),
    "ellipsoid on a plane": _pair(
        "ellipsoid_tumbling", ELLIPSOID, "start.height=1e-6", "start.velocity=[0,0,-1]", steppers=("rk4",)
    ),
}
BEAMS = {
    "1 cm/s, one contact": _beam("sphere_on_beam", "run.duration=6e-4"),
    "drop of 600 mm": _beam("sphere_on_beam_drop_600mm", "run.duration=3e-4"),
}
BODIES = {
    "ball in a groove": SceneProblem(
        "two_bodies_groove",
        ("run.duration=0.02",),
        ("contact.tracking=closed", "wanted.tolerance=1e-11"),
        {
            one: Field((f"contact.tracking={one}",), "wanted.tolerance", LADDER)
            for one in ("closed", "algebraic", "differential")
        },
    ),
}
EVERY = PAIRS | BEAMS | BODIES


def _overrides(name: str, method: str, setting: float) -> tuple[str, ...]:
    problem = EVERY[name]
    field = problem.fields[method]
    value = f"{setting:g}" if field.key != "solver.steps" else f"{round(setting)}"
    return (*problem.always, *field.fixed, f"{field.key}={value}")


def judge(name: str, method: str, setting: float, limit: float) -> Row:
    """One run."""
    problem = EVERY[name]
    true = (*problem.always, *problem.true)
    return scene_row(Row(name, method, setting), problem.scene, _overrides(name, method, setting), true, limit)


def _command(name, method, setting):
    return command_of(EVERY[name].scene, _overrides(name, method, setting))


def _lost(rows: list[Row]) -> list[str]:
    """What was refused, or failed."""
    lost = [row for row in rows if row.status not in (DONE, STOPPED)]
    words = (f"{row.method} at {row.setting:.3g} ({row.status})" for row in lost)
    return [f"Without a result: {', '.join(dict.fromkeys(words))}."] if lost else []


def _contest(problems, title, wanted, own):
    return Contest(
        judge=judge,
        title=title,
        error="greatest error of the force, over the greatest",
        cost="CPU s a run",
        wanted=wanted,
        problems={name: name for name in problems},
        entries=lambda name: ((method, one) for method, field in EVERY[name].fields.items() for one in field.ladder),
        command=_command,
        more=_lost,
        own=own,
    )


CONTESTS = {
    "pairs": _contest(PAIRS, "Two bodies meet: closed form, adaptive and fixed steps", 1e-3, ("dop853",)),
    "beams": _contest(
        BEAMS,
        "A sphere on a beam: modes, Volterra's equation, a sinusoidal force",
        1e-3,
        ("tolerance", "modes, 9", "modes, 41"),
    ),
    "two_bodies": _contest(
        BODIES, "Opposing points in closed form, by Newton, by their differential equation", 1e-3, ("closed",)
    ),
}
