"""The numbers of a ball bearing's equations (paper 1, section 5), which the compiled core takes.

Frames. `bearing_link` has its origin at the outer ring's centre and z along the axis. The motion of each ball is
written in the frame that turns with that ball about the axis, with unit vectors (radial, tangential, axial): there
steady rolling is an equilibrium, and only the orbit angle grows.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.elasticity import Elasticity
from bearing_twin.kinds.bearing.along_groove import terms_along
from bearing_twin.kinds.bearing.columns import AXIS_DISTANCE, HEIGHT, ORBIT_ANGLE
from bearing_twin.shapes.closed_forms import ball_in_groove


class Raceway(NamedTuple):
    """A toroidal groove and the elastic law of its contacts with the balls, with its `terms` (`along_groove`)."""

    locus_radius: float
    groove_radius: float
    law: Elasticity
    terms: tuple[float, ...]


class Bearing(NamedTuple):
    """Everything the equations of motion need, as numbers (SI).

    `friction_coefficient` is that of balls among themselves, `raceway_friction` that of a raceway at the contact
    point; it is 0 where `spot`, empty else, says how friction acts over the spot: its coefficient, its model's
    name and inner and outer semi-axes (`along_groove.axes_along`).
    `offset` is the place of the inner ring's centre; `ring` is empty where its axis
    stays z and it only spins, else its motion (`RingMotion`, or `LevelMotion` where it does not tilt).
    `pockets`, empty else, are those of a cage that balls bump into (`coupled_bodies.Pockets`). `film`, empty else, are
    the numbers of a lubricant and those of its films on both raceways (`lubricant.film_lubricant`, `films_along`);
    `defects` are the numbers of `surface_defects`, empty for smooth surfaces.
    """

    balls: int
    ball_radius: float
    ball_mass: float
    ball_inertia: float
    inner: Raceway
    outer: Raceway
    offset: tuple[float, float, float]
    gravity: tuple[float, float, float]
    damping: float
    relaxation_time: float
    friction_coefficient: float
    friction_regularisation: float
    pair_coefficient: float
    raceway_friction: float
    spot: tuple
    ring: tuple
    pockets: tuple
    defects: tuple[float, ...] = ()
    film: tuple = ()


class RingDrive(NamedTuple):
    """Prescribed turning of the inner ring: at time t [s] it has speed + acceleration t."""

    angle: float
    speed: float
    acceleration: float


class RingMotion(NamedTuple):
    """Tilt about x and y [rad], velocity of the centre [m/s] and rates of the tilt [rad/s], in `bearing_link`."""

    tilt: tuple[float, float]
    velocity: tuple[float, float, float]
    tilt_rate: tuple[float, float]


class LevelMotion(NamedTuple):
    """Velocity of the centre [m/s] of a ring that moves and whose axis stays z, in `bearing_link`."""

    velocity: tuple[float, float, float]


def approaches(bearing: Bearing, motion: np.ndarray) -> tuple[float, float]:
    """Approaches [m] of a ball at the inner and at the outer raceway; `motion` starts with its position."""
    radius, angle, height = (float(motion[column]) for column in (AXIS_DISTANCE, ORBIT_ANGLE, HEIGHT))
    cosine, sine = math.cos(angle), math.sin(angle)
    x, y, z = bearing.offset
    across = radius - (cosine * x + sine * y), sine * x - cosine * y, height - z
    if len(bearing.ring) > 1:  # in the axes of the tilted ring
        a, b = bearing.ring.tilt
        a, b = cosine * a + sine * b, cosine * b - sine * a
        axes = np.array([[1.0 + a * a, a * b, -b], [a * b, 1.0 + b * b, a], [b, -a, 1.0]]) / (1.0 + a * a + b * b)
        across = axes @ across
    places = (bearing.inner, math.hypot(across[0], across[1]), across[2]), (bearing.outer, radius, height)
    return tuple(
        ball_in_groove(distance, rise, bearing.ball_radius, race.locus_radius, race.groove_radius).approach
        for race, distance, rise in places
    )


def raceway_of(geometry, conformity, side, law: Callable) -> Raceway:
    """The groove of the inner (side = -1) or outer (side = +1) ring, its centre circle placed by the clearance.

    With the rings centred, each raceway is a quarter of the diametral clearance away from a ball on the pitch circle.
    `law(small, large)` gives the `Elasticity` from the curvatures [1/m] of the gap there.
    """
    ball_radius = 0.5 * geometry.ball_diameter
    groove_radius = conformity * geometry.ball_diameter
    bottom = 0.5 * geometry.pitch_diameter + side * (ball_radius + 0.25 * geometry.radial_clearance)
    locus_radius = bottom - side * groove_radius
    still = ball_in_groove(0.5 * geometry.pitch_diameter, 0.0, ball_radius, locus_radius, groove_radius)
    found = law(still.curvature_small, still.curvature_large)
    terms = terms_along(found, ball_radius, locus_radius, groove_radius, side)
    return Raceway(locus_radius, groove_radius, found, terms)
