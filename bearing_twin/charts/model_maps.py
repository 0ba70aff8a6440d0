"""Maps of where models fail: laws over the ellipse's shape, modes and steps of a beam, Euler's beam, elements.

Colour is the error of the load: of a law's coefficient against exact Hertz; of the force over time against a tolerance
of 1e-9; of Euler's first peak against Timoshenko's; of a soft disc's force against 32 divisions of order 4; of what
`left_alone` names.
"""

import functools
from typing import NamedTuple

import numpy as np

from bearing_twin.charts.contest import Job, judged
from bearing_twin.charts.left_alone import axis, quaternion
from bearing_twin.charts.left_alone import sentences_of as left_alone
from bearing_twin.charts.limits import command_of, spread
from bearing_twin.charts.scene_rows import scene_row
from bearing_twin.charts.soft_discs import disc_force
from bearing_twin.charts.table import DONE, MapRow
from bearing_twin.contact.elasticity import coefficient_of
from bearing_twin.contact.ellipse import HERTZ_U_MAX, curvature_ratio, hertz_coefficient, hertz_rational, shape_variable
from bearing_twin.kinds.beam.fineness import modes_wanted, steps_for
from bearing_twin.kinds.beam.theory import trial
from bearing_twin.kinds.impact.collision import FEWEST_STEPS
from bearing_twin.kinds.soft_discs.derived import fitting
from bearing_twin.run.scene import load_scene


class ModelMap(NamedTuple):
    """A map: title, words on both axes, methods, values of `across` and `setting`, the error that a dot stands for."""

    title: str
    across_title: str
    setting_title: str
    methods: tuple[str, ...]
    across: tuple[float, ...]
    settings: tuple[float, ...]
    dots: float


MODELS = {
    "law": ModelMap(
        "law over b/a",
        "b/a of the ellipse",
        "",
        ("hertz", "volumetric", "constant"),
        spread(1e-4, 1.0, 41),
        (1.0,),
        5e-3,
    ),
    "modes": ModelMap(
        "beam: modes and steps",
        "highest mode",
        "steps a contact",
        ("modes",),
        (5, 9, 17, 33, 65, 129, 257),
        (2, 4, 8, 12, 16, 24, 48, 96, 192, 384),
        1e-3,
    ),
    "height": ModelMap(
        "Euler's beam",
        "radius of the sphere [m]",
        "height of the beam [m]",
        ("euler",),
        spread(2e-3, 3e-2, 9),
        spread(4e-3, 4e-2, 8),
        1e-2,
    ),
    "poisson": ModelMap(
        "disc: {method} integration",
        "1 - 2 (Poisson's ratio)",
        "divisions",
        ("full", "selective"),
        (0.002, 0.01, 0.04, 0.1, 0.4),
        (8, 12, 16, 24),
        1e-2,
    ),
    "quaternion": ModelMap(
        "a quaternion's norm, left alone",
        "turn a step [rad]",
        "steps",
        ("rk4",),
        spread(0.0625, 4.0, 13),
        (2, 20, 200, 2000, 20000),
        1e-2,
    ),
    "axis": ModelMap(
        "axis of a round spot, left alone [rad]",
        "(Q - P)/(Q + P)",
        "turned by [rad]",
        ("gap",),
        spread(1e-16, 1e-2, 15),
        spread(0.1, 1.5, 6),
        1e-2,
    ),
}
FROZEN_AT = 0.1  # b/a at which `constant` is exact: a ball in a raceway
HERTZ_KEPT, VOLUMETRIC_KEPT, VOLUMETRIC_FROM = 1e-9, 5e-3, 0.06  # errors that laws promise; of the latter from this b/a
BEAM = ("sphere_on_beam_drop_600mm", ("beam.theory=euler", "run.duration=3e-4", "run.output_rate=1e6"))


def model_cell(name: str, method: str, setting: float, across: float, limit: float) -> MapRow:
    """One cell of a map of models."""
    command = command_of(name, method, setting, across)
    return _CELLS[name](MapRow(name, method, setting, across=across), limit).but(command=command)


def _law(row, limit):
    q = curvature_ratio(row.across)

    def outcome():
        frozen = hertz_coefficient(1.0, curvature_ratio(FROZEN_AT), 1.0) * (curvature_ratio(FROZEN_AT) / q) ** 0.25
        found = (
            coefficient_of(row.method, 1.0, q, 1.0, frozen) if row.method != "hertz" else hertz_rational(1.0, q, 1.0)
        )
        return {"load_error": abs(found / hertz_coefficient(1.0, q, 1.0) - 1.0)}

    return judged(row, outcome, limit)


def _modes(row, limit):
    scene, always = BEAM
    keys = (*always, "run.publish_rate=1e6")
    mine = (*keys, "solver.stepper=modes", f"solver.modes={row.across:.0f}", f"solver.steps={row.setting:.0f}")
    return scene_row(row, scene, mine, (*keys, "wanted.tolerance=1e-9"), limit)


def _height(row, limit):
    keys = ("beam.theory=auto", f"beam.height={row.setting}", f"sphere.radius={row.across}", "wanted.tolerance=1e-3")

    def outcome():
        found = trial(load_scene("sphere_on_beam", keys).parameters)
        return {"load_error": abs(found.error), "evaluations": found.crossings}

    return judged(row, outcome, limit)


@functools.lru_cache(maxsize=8)
def _true_disc(ratio):
    return disc_force("mesh.divisions=32", "mesh.order=4", f"disc.material.poisson_ratio={ratio}")


def _disc(row, limit):
    ratio = 0.5 * (1.0 - row.across)
    exact = _true_disc(ratio)

    def outcome():
        mesh = (f"mesh.divisions={fitting(int(row.setting), 1)}", "mesh.order=1", f"mesh.integration={row.method}")
        force = disc_force(*mesh, f"disc.material.poisson_ratio={ratio}")
        return {"load_error": float(np.sqrt(np.mean((force - exact) ** 2) / np.mean(exact**2)))}

    return judged(row, outcome, limit)


_CELLS = {"law": _law, "modes": _modes, "height": _height, "poisson": _disc, "quaternion": quaternion, "axis": axis}


def model_tasks(name: str, limit: float) -> list[Job]:
    """The cells of a map of models."""
    one = MODELS[name]
    return [
        Job("model_maps:model_cell", (name, method, setting, across, limit))
        for method in one.methods
        for across in one.across
        for setting in one.settings
    ]


def law_limits(rows: list[MapRow]) -> list[tuple[str, float, float]]:
    """(law, b/a down to which it promises its error, b/a down to which it keeps it)."""
    found = []
    hertz_from = 1.0
    for ratio in sorted({row.across for row in rows if row.problem == "law"}, reverse=True):
        if shape_variable(1.0, curvature_ratio(ratio)) <= HERTZ_U_MAX * (1.0 + 1e-6):
            hertz_from = ratio
    for law, promised, kept in (("hertz", hertz_from, HERTZ_KEPT), ("volumetric", VOLUMETRIC_FROM, VOLUMETRIC_KEPT)):
        mine = sorted((row for row in rows if (row.problem, row.method) == ("law", law)), key=lambda row: -row.across)
        last = 1.0
        for row in mine:
            if row.status != DONE or row.load_error > kept:
                break
            last = row.across
        if mine:
            found.append((law, promised, last))
    return found


def chosen_by_tolerance(tolerances=(1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8)) -> tuple[list[int], list[int]]:
    """Modes and steps that the tolerances choose on the map `modes`."""
    found = [load_scene(BEAM[0], (*BEAM[1], f"wanted.tolerance={one}")).parameters for one in tolerances]
    return [modes_wanted(one) for one in found], [steps_for(one, "modes") for one in found]


def sentences_of(rows: list[MapRow]) -> list[str]:
    """What the maps of models say, from their numbers."""
    sentences = [
        f"{law}: its error is promised down to b/a = {promised:.2g}, and kept down to {kept:.2g}."
        for law, promised, kept in law_limits(rows)
    ]
    few = [row for row in rows if row.problem == "modes" and row.setting < FEWEST_STEPS]
    if few:
        worst = max(few, key=lambda row: row.error)
        sentences.append(
            f"Beam: {worst.setting:g} steps a contact err by {worst.error:.1g} with {worst.across:g} modes."
        )
    heights = [row for row in rows if row.problem == "height" and row.status == DONE]
    bad = [row.evaluations for row in heights if row.error > MODELS["height"].dots]
    if bad:
        sentences.append(
            f"Euler's first peak is more than 1 % off at {len(bad)} of {len(heights)} places, in contacts of "
            f"{min(bad):.2g} to {max(bad):.2g} crossings of the height by a shear wave; there auto takes Timoshenko's."
        )
    elements = [row for row in rows if row.problem == "poisson"]
    discs = {one: [row for row in elements if row.method == one] for one in MODELS["poisson"].methods}
    if all(discs.values()):
        least = min(row.across for row in discs["full"])
        words = (
            f"{method} {max(row.error for row in mine if row.across == least):.2g} to "
            f"{min(row.error for row in mine if row.across == least):.2g}"
            for method, mine in discs.items()
        )
        sentences.append(f"Disc, Poisson's ratio {0.5 - 0.5 * least:g}, coarse to fine mesh: {', '.join(words)}.")
    return sentences + left_alone(rows)
