"""Geometry of a bearing: the clearance it runs with, curvatures of its contacts, and speeds of pure rolling."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

import dataclasses
import math
from dataclasses import dataclass
from typing import NamedTuple

from bearing_twin.base.parameters import quantity, section
from bearing_twin.contact.materials import MATERIALS, Material, effective_modulus

ROOM_TEMPERATURE = 293.15  # K


@dataclass(frozen=True)
class Seat:
    """Seat of a ring: the shaft below the inner ring, or the housing around the outer one."""

    interference: float = quantity(
        0.0, "m", "of the diameters of ring and seat before they are joined; 0 = a loose fit", at_least=0.0
    )
    diameter: float = quantity(
        0.0, "m", "of the seat: bore of the inner ring, outside of the outer ring; wanted with an interference",
        at_least=0.0,
    )  # fmt: skip
    other_diameter: float = quantity(
        0.0, "m", "bore of a hollow shaft, 0 = solid; outside of the housing, 0 = without end", at_least=0.0
    )
    material: Material = section(Material, "steel", MATERIALS)


@dataclass(frozen=True)
class Fits:
    """The seats of both rings."""

    shaft: Seat = section(Seat)
    housing: Seat = section(Seat)


@dataclass(frozen=True)
class Temperatures:
    """Temperatures of the parts, each taken as even; expansion by `materials.*.thermal_expansion`."""

    reference: float = quantity(ROOM_TEMPERATURE, "K", "at which the clearance was measured", above=0.0)
    inner_ring: float = quantity(ROOM_TEMPERATURE, "K", "of the inner ring", above=0.0)
    outer_ring: float = quantity(ROOM_TEMPERATURE, "K", "of the outer ring", above=0.0)
    balls: float = quantity(0.0, "K", "of the balls; 0 = the mean of the rings", at_least=0.0)


class Clearance(NamedTuple):
    """Radial internal clearance [m]: as made, its changes by each cause, and their sum."""

    initial: float
    shaft_fit: float
    housing_fit: float
    temperature: float
    operating: float


def clearance_at_angle(geometry) -> float:
    """The radial clearance [m] that gives `geometry.contact_angle` without load: 2 A (1 - cos), A = (f_i + f_o - 1) D.

    Harris, Rolling Bearing Analysis, the free contact angle.
    """
    between = (geometry.inner_conformity + geometry.outer_conformity - 1.0) * geometry.ball_diameter
    return 2.0 * between * (1.0 - math.cos(geometry.contact_angle))


def _fit(seat: Seat, ring: Material, raceway: float, side: float) -> float:
    """Change [m] of a raceway's diameter by its fit, from the shaft (side 1) or the housing (-1).

    Two thick-walled rings (Lame) pressed on each other; a solid shaft, and a housing without end, are such rings, too.
    """
    if seat.interference == 0.0:
        return 0.0
    d2, other2 = seat.diameter**2, seat.other_diameter**2
    of_ring = side * (raceway**2 + d2) / (raceway**2 - d2) + side * ring.poisson_ratio
    wall = side * (d2 + other2) / (d2 - other2) if side > 0.0 or other2 > 0.0 else 1.0
    of_seat = wall - side * seat.material.poisson_ratio
    compliance = of_ring / ring.young_modulus + of_seat / seat.material.young_modulus
    pressure = seat.interference / seat.diameter / compliance
    return 2.0 * pressure * d2 * raceway / (ring.young_modulus * (raceway**2 - d2))


def clearance_parts(parameters) -> Clearance:
    """The clearance of a bearing scene and its parts; raceways are taken as rings d_m -+ D in diameter.

    Fits: interference times the ratio of the ring's diameters for a solid shaft of the ring's material (Harris). Heat:
    a_i (d_m - D) dT_i + 2 a_b D dT_b - a_o (d_m + D) dT_o is lost.
    """
    geometry, materials, heat = parameters.geometry, parameters.materials, parameters.temperatures
    inner, outer = (geometry.pitch_diameter + side * geometry.ball_diameter for side in (-1.0, 1.0))
    initial = clearance_at_angle(geometry) if geometry.contact_angle > 0.0 else geometry.radial_clearance
    shaft = 0.0 - _fit(parameters.fits.shaft, materials.inner_ring, inner, 1.0)
    housing = 0.0 + _fit(parameters.fits.housing, materials.outer_ring, outer, -1.0)
    balls = heat.balls or 0.5 * (heat.inner_ring + heat.outer_ring)
    thermal = (
        materials.outer_ring.thermal_expansion * outer * (heat.outer_ring - heat.reference)
        - materials.inner_ring.thermal_expansion * inner * (heat.inner_ring - heat.reference)
        - 2.0 * materials.ball.thermal_expansion * geometry.ball_diameter * (balls - heat.reference)
    )
    return Clearance(initial, shaft, housing, thermal, initial + shaft + housing + thermal)


def operating_geometry(parameters):
    """The scene's geometry with the clearance it runs with."""
    return dataclasses.replace(parameters.geometry, radial_clearance=clearance_parts(parameters).operating)


def clearance_problems(parameters) -> list[str]:
    """Contradictions of contact angle and fits, one sentence each."""
    geometry, shaft, housing = parameters.geometry, parameters.fits.shaft, parameters.fits.housing
    inner, outer = (geometry.pitch_diameter + side * geometry.ball_diameter for side in (-1.0, 1.0))
    far = housing.other_diameter or math.inf
    has_clearance = geometry.radial_clearance != type(geometry).radial_clearance
    rows = (
        (
            geometry.contact_angle > 0.0 and has_clearance,
            f"geometry.contact_angle = {geometry.contact_angle:g} rad and geometry.radial_clearance = "
            f"{geometry.radial_clearance:g} m say the same thing; keep one of them",
        ),
        (
            shaft.interference > 0.0 and not shaft.other_diameter < shaft.diameter < inner,
            f"fits.shaft.diameter = {shaft.diameter:g} m must lie between fits.shaft.other_diameter = "
            f"{shaft.other_diameter:g} m and the inner raceway's {inner:g} m: give the ring's bore",
        ),
        (
            housing.interference > 0.0 and not outer < housing.diameter < far,
            f"fits.housing.diameter = {housing.diameter:g} m must lie between the outer raceway's {outer:g} m and "
            f"fits.housing.other_diameter = {far:g} m: give the ring's outside",
        ),
    )
    return [sentence for wrong, sentence in rows if wrong]


def squeezes(parameters) -> list[tuple[float, float]]:
    """Squeezes [m] of balls at the near and the far side of the ring's offset, before and after its change.

    At the far side of a radial offset r this is hypot(A_0 - r, z) - (f_i + f_o - 1) D.
    """
    geometry, drive = operating_geometry(parameters), parameters.drive
    free = (geometry.inner_conformity + geometry.outer_conformity - 1.0) * geometry.ball_diameter
    middle = free - 0.5 * geometry.radial_clearance
    offsets = [drive.offset]
    if drive.change.time:
        offsets.append(drive.changed_offset)
    return [
        (math.hypot(middle + radial, z) - free, math.hypot(middle - radial, z) - free)
        for radial, z in ((math.hypot(x, y), z) for x, y, z in offsets)
    ]


def leaves_raceway(parameters) -> bool:
    """True if a ball leaves the inner raceway somewhere along its orbit, with the ring held."""
    return any(far <= 0.0 for _, far in squeezes(parameters))


def nominal_curvatures(geometry) -> tuple[tuple[float, float], ...]:
    """Curvatures (small, large) of the gap [1/m] at the inner and the outer contact, at contact angle zero."""
    ball = 2.0 / geometry.ball_diameter
    pairs = []
    for side, conformity in ((-1.0, geometry.inner_conformity), (1.0, geometry.outer_conformity)):
        small = 0.5 * (ball - 1.0 / (conformity * geometry.ball_diameter))
        large = 0.5 * (ball - side / (0.5 * geometry.pitch_diameter + side / ball))
        pairs.append((small, max(small, large)))
    return tuple(pairs)


def moduli(materials) -> tuple[float, float]:
    """E* [Pa] of a ball on the inner and on the outer raceway."""
    ball = materials.ball
    return effective_modulus(ball, materials.inner_ring), effective_modulus(ball, materials.outer_ring)


def cage_speed(inner_speed: float, ball_diameter: float, pitch_diameter: float, contact_angle: float = 0.0) -> float:
    """Orbital speed of the balls [rad/s] without slip: half the inner ring's, times 1 - (D/d_m) cos(angle)."""
    return 0.5 * inner_speed * (1.0 - ball_diameter / pitch_diameter * math.cos(contact_angle))


def roll_rate(inner_speed: float, ball_diameter: float, pitch_diameter: float, contact_angle: float = 0.0) -> float:
    """Angular speed [rad/s] of a ball about its own centre against its orbit, without slip."""
    ratio = ball_diameter / pitch_diameter * math.cos(contact_angle)
    return 0.5 * inner_speed * pitch_diameter / ball_diameter * (1.0 - ratio**2)
