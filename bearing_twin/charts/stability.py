"""Maps of where methods fail: the error of what a user runs over two numbers, hatched where the software refuses.

Steps of fixed-step methods against stiffness, friction and damping; tolerances of adaptive ones against friction;
modes and steps of a beam, meshes of a soft disc. Every cell is a run of `simulate`.
"""

import math

import numpy as np

from bearing_twin.charts.contest import in_rows, of_methods, of_problem
from bearing_twin.charts.panels import Axis, Line, Map, Panel
from bearing_twin.charts.rows import DONE, REFUSED
from bearing_twin.charts.scenes import (
    Method,
    Problem,
    Scenes,
    greatest,
    load_and_friction,
    root_mean_square,
    spread,
    steps,
    tolerances,
)

FAILS, COLUMNS = 0.1, 3  # error of a run that fails; maps side by side
FROM_REST = ("initial.motion=rest", "drive.offset=[0.0,-1e-6,5e-6]")
ONE_BALL = ("geometry.balls=1", "run.duration=2e-3", "run.output_rate=10000", "run.publish_rate=1000")
BODIES = ("ball", "inner_ring", "outer_ring")
STEPS = spread(1e-7, 2e-5, 12)
FIXED = {name: steps(*STEPS, keys=(f"solver.stepper={name}",)) for name in ("rk4", "imex")}
ADAPTIVE = {
    name: tolerances(*spread(1e-1, 1e-6, 6), keys=(f"solver.stepper={name}",))
    for name in ("rodas4", "rodas3", "dopri5")
}


def _ball(title: str, across, values, *keys: str, methods=None) -> Problem:
    """One ball of a 6203."""
    return Problem(
        title=title,
        scene="bearing_6203",
        keys=(*ONE_BALL, *keys),
        reference=("solver.stepper=rodas4", "wanted.tolerance=1e-8"),
        methods=FIXED if methods is None else methods,
        norm=load_and_friction,
        channels=("normal_load", "friction_force"),
        across=across,
        values=values,
        a_second=True,
    )


def _moduli(value: float) -> tuple[str, ...]:
    return tuple(f"materials.{body}.young_modulus={value:g}" for body in BODIES)


def _slip(value: float) -> tuple[str, ...]:
    return (f"contact.friction_regularisation={value:g}",)


MODES = Method(("solver.stepper=modes", "wanted.tolerance=1e-3"), "solver.steps", (8.0, 12, 16, 24, 48, 96, 192))
MAPS = {
    "stiffness": _ball("one ball that rolls: Young's modulus [Pa]", _moduli, spread(2e10, 2e12, 9)),
    "friction": _ball("one ball that rolls: friction regularisation [m/s]", _slip, spread(1e-3, 1e-1, 9)),
    "sliding": _ball("one ball from rest: friction regularisation [m/s]", _slip, spread(1e-3, 1e-1, 9), *FROM_REST),
    "damping": _ball(
        "one ball that rolls: relaxation time [s]",
        lambda value: (f"contact.relaxation_time={value:g}",),
        spread(1e-7, 1e-5, 9),
        "contact.friction_coefficient=0.01",
    ),
    "tolerance": _ball(
        "one ball from rest: friction regularisation [m/s]", _slip, spread(1e-4, 1e-1, 7), *FROM_REST, methods=ADAPTIVE
    ),
    "modes": Problem(
        title="sphere on a beam: modes",
        scene="sphere_on_beam_drop_600mm",
        keys=("beam.theory=euler", "run.duration=3e-4", "run.output_rate=1e6", "run.publish_rate=1e6"),
        reference=("wanted.tolerance=1e-9",),
        methods={"modes": MODES},
        norm=greatest("normal_load"),
        across=lambda value: (f"solver.modes={value:g}",),
        values=(5.0, 9, 17, 33, 65, 129, 257),
    ),
    "disc": Problem(
        title="soft disc: 1 - 2 (Poisson's ratio)",
        scene="soft_discs_mean",
        keys=("run.output_rate=20000", "run.publish_rate=20000", "run.duration=0.07"),
        reference=("mesh.divisions=32", "mesh.order=4"),
        methods={
            f"{name} integration": Method(
                ("mesh.order=1", f"mesh.integration={name}", "solver.allow_invalid=on"),
                "mesh.divisions",
                (8.0, 12, 16, 24),
            )
            for name in ("full", "selective")
        },
        norm=root_mean_square("normal_load"),
        across=lambda value: (f"disc.material.poisson_ratio={0.5 - 0.5 * value:g}",),
        values=(0.002, 0.01, 0.04, 0.1, 0.4),
    ),
}
UP = {
    "wanted.tolerance": Axis("tolerance", log=True),
    "solver.step": Axis("step", "s", log=True),
    "solver.steps": Axis("steps a contact", log=True),
    "mesh.divisions": Axis("divisions", log=True),
}


MARK = {"linestyle": "", "markersize": 8, "markeredgewidth": 2}


def _bad(row) -> bool:
    return row.status not in (DONE, REFUSED) or FAILS < row.error < math.inf


def _panels(contest, rows) -> list[list[Panel]]:
    """A map a problem and method; crosses where a run fails, dots where the software refuses."""
    found = []
    for name, problem in MAPS.items():
        for method, mine in of_methods(of_problem(rows, name)).items():
            across, settings = sorted({row.across for row in mine}), sorted({row.setting for row in mine})
            z = np.full((len(settings), len(across)), math.nan)
            for row in mine:
                if row.status == DONE:
                    z[settings.index(row.setting), across.index(row.across)] = row.error
            title, _, unit = problem.title.partition(" [")
            body, _, number = title.partition(": ")
            parts: list = [Map("error", "1", across, settings, z, "viridis_r", (1e-8, 1.0), 0.0)]
            for label, look, marked in (
                (f"error above {FAILS:g}, or no result", {"marker": "x", "color": "#7b1e1e"}, filter(_bad, mine)),
                ("refused by the software", {"marker": "s", "color": "#5f6f7a"}, of_problem(mine, name, REFUSED)),
            ):
                places = [(row.across, row.setting) for row in marked]
                parts.append(Line(label, [one[0] for one in places], [one[1] for one in places], {**MARK, **look}))
            x, up = Axis(number, unit.rstrip("]") or "1", log=True), UP[problem.methods[method].key]
            found.append(Panel(f"{body}, {method}", x, up, parts, None))
    return in_rows(found, COLUMNS)


def _read(contest, rows):
    for name, problem in MAPS.items():
        for method, mine in of_methods(of_problem(rows, name)).items():
            refused, done = len(of_problem(mine, name, REFUSED)), of_problem(mine, name, DONE)
            bad, worst = sum(map(_bad, mine)), max((row.error for row in done), default=math.nan)
            words = f"{len(mine)} cells, {refused} refused, {bad} fail (error above {FAILS:g}, or none)"
            if name == "tolerance":
                words += f", {sum(row.error <= row.setting for row in done)} meet their tolerance"
            yield f"{problem.title.partition(' [')[0]}, {method}: {words}; greatest error {worst:.2g}."


CHARTS = {
    "stability": Scenes(table=MAPS, timed=False).contest(
        title="Where methods fail, and where the software refuses", panels=_panels, read=_read
    )
}
