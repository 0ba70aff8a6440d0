"""The view of a bearing: rings in section, balls that roll, ellipses, loads, the cage; curves of loads and motion.

Deviations from the bearing without clearance or load are enlarged alike: those of the balls from their circle, those of
the ring from its seat, and the clearance of the raceways. What touches without enlargement touches with it, and what is
apart is apart.
"""

import math

import numpy as np

from bearing_twin.base.sample import Channel
from bearing_twin.kinds.bearing.geometry import operating_geometry
from bearing_twin.kinds.bearing.outputs import contact_details
from bearing_twin.kinds.bearing.rings import EVEN, FREE_RING, POCKETS, PRESCRIBED, dimension_of, moving_centre
from bearing_twin.kinds.views import (
    BLUE,
    BRASS,
    ORANGE,
    PALETTE,
    RED,
    Arrows,
    Details,
    Enlarged,
    Look,
    Solid,
    Spots,
    View,
    along_axes,
    ball_curves,
    curves,
    picked,
)

REACH = 0.12  # ball radii: how far the greatest deviation is drawn
ARROW, RING_ARROW = 0.8, 0.55  # longest arrow of a ball's load in ball diameters, of the ring's in radii of its bore
WIDTH, SHOULDER, WALL = 0.75, 0.2, 0.42  # ball diameters: half width of a ring, depth of a groove, ring behind it
CYCLE = 6.0  # s of looking in which the balls come round once

TAKEN = (
    *("orientation", "normal", "normal_load", "contact_angle", "slip_speed", "inner_ring_offset", "inner_ring_tilt"),
    *("inner_ring_speed", "kinetic_energy", "elastic_energy", "potential_energy", "drive_work", "dissipated"),
)


def view(facts, channels) -> View:
    """The view of a bearing scene; everything stands in `bearing_link`."""
    parameters = facts.scene.parameters
    geometry, n = operating_geometry(parameters), parameters.geometry.balls
    ball, free = geometry.ball_diameter, dimension_of(parameters) == FREE_RING
    series = (
        *picked(channels, TAKEN),
        Channel("seat", "m", (n, 3), "ball centres on the pitch circle"),
        Channel("deviation", "m", (n, 3), "of the ball centres from there"),
        Channel("semi_major", "m", (n, 2), "of the contact ellipse"),
        Channel("semi_minor", "m", (n, 2), "of the contact ellipse"),
        Channel("peak_pressure", "Pa", (n, 2), "at the middle of the contact ellipse"),
        Channel("slip_speed", "m/s", (n, 2), "of the ball's surface on the raceway at the contact's middle"),
        Channel("ring_turn", "1", (2,), "cosine and sine of the inner ring's angle"),
        Channel("cage_turn", "1", (2,), "cosine and sine of the cage's angle"),
        Channel("cage_place", "m", (3,), "of the cage's centre off the axis"),
        Channel("ring_load", "N", (3,), "on the inner ring, borne by the balls"),
        Channel("friction_torque", "N m", (), "of the balls on the inner ring about the axis"),
        Channel("orbit_speed", "rad/s", (), "of the balls around the axis, mean"),
    )
    return View(
        series=series,
        rows=lambda sample: _rows(parameters, sample, free),
        panels=_panels(n, dimension_of(parameters) != PRESCRIBED),
        solids=tuple(_solids(parameters, geometry)),
        marks=_marks(geometry),
        look=Look(0.5 * geometry.pitch_diameter + (0.5 + WALL) * ball, (-0.1, -0.52, 0.85)),
        enlarged=Enlarged(
            "displacements and clearance",
            ("deviation", "inner_ring_offset", *(("cage_place",) if moving_centre(parameters) else ())),
            REACH * 0.5 * ball, 0.25 * abs(geometry.radial_clearance),
        ),
        details=Details(
            "balls", "ball", ("inner raceway", "outer raceway"), "semi_major", "semi_minor", "peak_pressure",
            (("load", "normal_load"), ("contact angle", "contact_angle"), ("slip", "slip_speed")),
        ),
        period=_period(parameters, ball / geometry.pitch_diameter),
        words="Rings are cut through the middle of the balls; the outer ring is at rest.",
        axes=True,
    )  # fmt: skip


def _period(parameters, slenderness: float) -> float:
    """Simulated seconds that pass in one second of looking, so that balls come round in CYCLE seconds."""
    speed = max(abs(parameters.drive.speed), abs(parameters.drive.speed + parameters.drive.change.speed))
    return 2.0 * math.pi / (0.5 * (1.0 - slenderness) * speed) / CYCLE if speed else 0.0


def _rows(parameters, sample, free) -> dict[str, np.ndarray]:
    position, velocity = sample["position"], sample["velocity"]
    axis_distance = np.hypot(position[..., 0], position[..., 1])
    seat = np.zeros_like(position)
    radius = 0.5 * parameters.geometry.pitch_diameter
    seat[..., :2] = position[..., :2] * (radius / axis_distance)[..., None]
    details = contact_details(parameters, sample)
    turned = position[..., 0] * velocity[..., 1] - position[..., 1] * velocity[..., 0]
    return {name: sample[name] for name in TAKEN if name != "slip_speed"} | {
        "seat": seat,
        "deviation": position - seat,
        **{name: details[name] for name in ("semi_major", "semi_minor", "peak_pressure")},
        "slip_speed": np.where(sample["normal_load"] > 0.0, np.linalg.norm(sample["slip"], axis=-1), 0.0),
        "ring_turn": _turn(sample["inner_ring_angle"]),
        "cage_turn": _turn(sample["cage_angle"]),
        "cage_place": np.pad(sample["cage_offset"], [*((0, 0),) * (sample["cage_offset"].ndim - 1), (0, 1)]),
        "ring_load": sample["inner_ring_load"] if free else -sample["inner_ring_force"],
        "friction_torque": sample["inner_ring_torque"][..., 2],
        "orbit_speed": (turned / axis_distance**2).mean(axis=-1),
    }


def _turn(angle) -> np.ndarray:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _solids(parameters, geometry):
    ball, pitch = geometry.ball_diameter, geometry.pitch_diameter
    opening = 0.25 * geometry.radial_clearance
    for name, words, side, conformity in (
        ("inner_ring", "inner ring", -1.0, geometry.inner_conformity),
        ("outer_ring", "outer ring", 1.0, geometry.outer_conformity),
    ):
        inner = side < 0.0
        yield Solid(
            name,
            words,
            {"turned": {"strokes": _profile(pitch, ball, side, conformity), "grow": side * opening}},
            deviation="inner_ring_offset" if inner else "",
            turn="ring_turn" if inner else "",
            tilt="inner_ring_tilt" if inner else "",
            marked=inner,
        )
    yield Solid(
        "balls", "balls", {"ellipsoid": (0.5 * ball,) * 3}, PALETTE, parameters.geometry.balls,
        "seat", "deviation", "orientation", marked=True,
    )  # fmt: skip
    if parameters.cage.kind in (EVEN, POCKETS):
        outlines = _webs(parameters.geometry.balls, pitch, ball, parameters.cage.pocket_clearance)
        shape = {"extruded": {"outlines": outlines, "low": -0.42 * ball, "high": 0.06 * ball}}
        place = "cage_place" if moving_centre(parameters) else ""
        yield Solid("cage", "cage", shape, BRASS, deviation=place, turn="cage_turn")


def _profile(pitch: float, ball: float, side: float, conformity: float) -> list[list[tuple[float, float]]]:
    """The section (radius, z) of a ring below z = 0 as strokes; a stroke is smooth, between strokes are edges.

    The groove has the radius conformity x ball diameter and touches a ball on the pitch circle at its bottom.
    """
    bottom, groove = 0.5 * (pitch + side * ball), conformity * ball
    steepest = math.acos(1.0 - SHOULDER * ball / groove)
    arc = [
        (bottom - side * groove * (1.0 - math.cos(angle)), -groove * math.sin(angle))
        for angle in np.linspace(0.0, steepest, 9)
    ]
    back, face = bottom + side * WALL * ball, -WIDTH * ball
    shoulder = (arc[-1][0], face)
    return [arc, [arc[-1], shoulder], [shoulder, (back, face)], [(back, face), (back, 0.0)], [(back, 0.0), arc[0]]]


def _webs(balls: int, pitch: float, ball: float, clearance: float) -> list[list[tuple[float, float]]]:
    """Outlines (x, y) of the pieces of a cage between the balls, ball 0 at angle 0, joined by a ring behind them."""
    inner, outer, pocket = 0.5 * pitch - 0.16 * ball, 0.5 * pitch + 0.16 * ball, 0.5 * (ball + clearance)
    found = []
    for k in range(balls):
        middle, half = 2.0 * math.pi * (k + 0.5) / balls, math.pi / balls
        sides = []
        for sign in (-1.0, 1.0):
            # the rim of the pocket between the two circles of the cage; webs that would vanish keep a sliver
            for radius in np.linspace(inner, outer, 7)[:: 1 if sign < 0.0 else -1]:
                cosine = (radius**2 + 0.25 * pitch**2 - pocket**2) / (radius * pitch)
                away = min(math.acos(min(cosine, 1.0)), 0.97 * half)
                angle = middle + sign * (half - away)
                sides.append((radius * math.cos(angle), radius * math.sin(angle)))
        found.append(sides)
    return found


def _marks(geometry):
    ball = geometry.ball_diameter
    bore = 0.5 * geometry.pitch_diameter - (0.5 + WALL) * ball
    return (
        Arrows(
            "loads", "load on a ball by inner and outer raceway", "N", "normal", ARROW * ball, (BLUE, ORANGE),
            "normal_load", on="balls", radius=0.5 * ball,
        ),
        Arrows("ring_load", "load on the inner ring", "N", "ring_load", RING_ARROW * bore, (RED,), from_point=True),
        Spots(
            "ellipses", "contact ellipses", "normal", "semi_major", "semi_minor", "peak_pressure", 0.45 * ball,
            on="balls", radius=0.5 * ball,
        ),
    )  # fmt: skip


def _panels(balls: int, moves: bool):
    displaced = curves("Inner ring's displacement", "m", *along_axes("inner_ring_offset"))
    return (
        ball_curves("Load on each ball, inner raceway", "N", "normal_load", balls, 0),
        ball_curves("Load on each ball, outer raceway", "N", "normal_load", balls, 1),
        *((displaced,) if moves else ()),
        ball_curves("Peak pressure, inner raceway", "Pa", "peak_pressure", balls, 0),
        curves("Friction torque on the inner ring", "N m", ("friction_torque", "about the axis")),
        curves("Speeds about the axis", "rad/s", ("inner_ring_speed", "inner ring"), ("orbit_speed", "balls, mean")),
        curves(
            "Energy", "J",
            ("kinetic_energy", "kinetic"), ("elastic_energy", "elastic"), ("potential_energy", "of height"),
        ),
        curves(
            "Work since the start", "J",
            ("drive_work", "by drive and loads"), ("dissipated", "lost to friction, damping"),
        ),
    )  # fmt: skip
