"""The view of a shaft on two bearings: both in section, forces of the bearings, curves of motion and loads."""

from itertools import pairwise

import numpy as np

from bearing_twin.base.sample import Channel
from bearing_twin.kinds.shaft.course import constant_loads
from bearing_twin.kinds.shaft.parameters import SIDES
from bearing_twin.kinds.shaft.topics import longest_arrow, ring_centres, ring_sizes, sizes
from bearing_twin.kinds.views import (
    DARK,
    ORANGE,
    STEEL,
    Arrows,
    CurvePanel,
    Enlarged,
    Look,
    Solid,
    View,
    along_axes,
    ball_curves,
    curves,
    picked,
)

REACH = 0.15  # of the shaft's radius: greatest drawn displacement
TAKEN = (
    *("position", "tilt", "bearing_force", "load", "shaft_speed", *(f"{side}_normal_load" for side in SIDES)),
    *("kinetic_energy", "elastic_energy", "load_work", "bearing_work", "dissipated"),
)


def view(facts, channels) -> View:
    """z along the shaft; everything stands in `shaft_link`."""
    parameters = facts.scene.parameters
    radius, low, high = sizes(parameters)
    series = (
        *picked(channels, TAKEN),
        Channel("turn", "1", (2,), "cosine and sine of the shaft's angle"),
        Channel("centres", "m", (2, 3), "of the inner rings"),
        Channel("varying_load", "N", (3,), "the load but shaft.loads, which no command replaces"),
    )
    return View(
        series=series,
        rows=lambda sample: _rows(parameters, sample),
        panels=_panels(parameters),
        solids=(
            Solid(
                "shaft", "shaft", {"turned": {"strokes": _rod(radius, low, high)}}, STEEL,
                deviation="position", turn="turn", tilt="tilt", marked=True,
            ),
            *(
                Solid(
                    f"{side}_bearing", f"{side} bearing", {"turned": {"strokes": _housing(getattr(parameters, side))}},
                    DARK, opacity=0.5,
                )
                for side in SIDES
            ),
        ),
        marks=(
            Arrows(
                "forces", "force on the shaft", "N", "bearing_force", longest_arrow(parameters), (ORANGE,),
                point="centres",
            ),
        ),
        look=Look(0.6 * (high - low), (-1.0, 0.35, 0.35), middle=(0.0, 0.0, 0.5 * (low + high))),
        enlarged=Enlarged("displacement of the shaft", ("position",), REACH * radius),
        words="The shaft is drawn as wide as its bearings' bores; its displacement is enlarged, and its tilt as much.",
        axes=True,
    )  # fmt: skip


def _panels(parameters) -> tuple[CurvePanel, ...]:
    return (
        curves("Centre of mass", "m", *along_axes("position")),
        curves("Tilt", "rad", ("tilt", "about x", 0), ("tilt", "about y", 1)),
        *(
            curves(f"Force of the {side} bearing on the shaft", "N", *along_axes("bearing_force", 3 * b))
            for b, side in enumerate(SIDES)
        ),
        curves("Load on the shaft but its weight", "N", *along_axes("load")),
        *(
            ball_curves(f"Load on each ball, {side} bearing, inner raceway", "N", f"{side}_normal_load", balls, 0)
            for side, balls in ((side, getattr(parameters, side).geometry.balls) for side in SIDES)
        ),
        curves("Speed of the shaft", "rad/s", ("shaft_speed", "about z")),
        curves("Energy", "J", ("kinetic_energy", "kinetic"), ("elastic_energy", "in the contacts")),
        curves(
            "Work since the start", "J", ("load_work", "of loads and unbalances"), ("bearing_work", "on the bearings"),
            ("dissipated", "lost to damping"),
        ),
    )  # fmt: skip


def _rows(parameters, sample) -> dict[str, np.ndarray]:
    angle = sample["shaft_angle"]
    turn = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    found = {name: sample[name] for name in TAKEN} | {"turn": turn, "centres": ring_centres(parameters, sample)}
    return found | {"varying_load": sample["load"] - constant_loads(parameters)[:3]}


def _rod(radius: float, low: float, high: float) -> list[list[tuple[float, float]]]:
    return [[(0.0, low), (radius, low)], [(radius, low), (radius, high)], [(radius, high), (0.0, high)]]


def _housing(mounted) -> list[list[tuple[float, float]]]:
    """The section (radius, z) of a ring around the shaft at its place."""
    inner, outer, wide = ring_sizes(mounted)
    low, high, inside = mounted.place - 0.5 * wide, mounted.place + 0.5 * wide, 0.5 * (inner + outer)
    corners = [(inside, low), (outer, low), (outer, high), (inside, high), (inside, low)]
    return [list(pair) for pair in pairwise(corners)]
