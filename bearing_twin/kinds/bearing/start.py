"""From a bearing scene to the numbers of its equations, and to the state it starts from."""

import math

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.contact.elasticity import elasticity
from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.kinds.bearing import compiled_balls
from bearing_twin.kinds.bearing.along_groove import axes_along, films_along
from bearing_twin.kinds.bearing.clearance import operating_geometry
from bearing_twin.kinds.bearing.columns import COLUMNS, ORBIT_ANGLE
from bearing_twin.kinds.bearing.coupled_bodies import MovingPockets, Pockets
from bearing_twin.kinds.bearing.lubricant import film_lubricant, lubricated
from bearing_twin.kinds.bearing.model import Bearing, LevelMotion, RingMotion, raceway_of
from bearing_twin.kinds.bearing.parameters import BearingScene, Geometry, viscous_terms
from bearing_twin.kinds.bearing.rings import (
    FREE_RING,
    POCKETS,
    PRESCRIBED,
    QUASI_STATIC,
    dimension_of,
    moving_centre,
    tilts,
)


def bearing_of(parameters: BearingScene, law: str) -> Bearing:
    """The numbers of the equations of motion for a scene with the elastic law `law`.

    Balls meet each other by Hertz's law, whatever the raceways do.
    """
    geometry, materials, contact = operating_geometry(parameters), parameters.materials, parameters.contact
    radius = 0.5 * geometry.ball_diameter
    mass = materials.ball.density * 4.0 / 3.0 * math.pi * radius**3
    pair = effective_modulus(materials.ball, materials.ball)
    friction = FRICTIONS[contact.friction]
    damping, relaxation_time = viscous_terms(contact)

    def law_of(ring):
        modulus = effective_modulus(materials.ball, ring)

        def at(small, large):
            return elasticity(law, modulus, LAWS[law].number(contact, hertz_coefficient(small, large, modulus)))

        return at

    inner = raceway_of(geometry, geometry.inner_conformity, -1.0, law_of(materials.inner_ring))
    outer = raceway_of(geometry, geometry.outer_conformity, 1.0, law_of(materials.outer_ring))
    spot, coefficient, film = (), contact.friction_coefficient, ()
    if lubricated(parameters):
        oil, coefficient = film_lubricant(parameters), parameters.lubricant.boundary_friction
        film = oil, films_along(oil, inner, radius, -1.0), films_along(oil, outer, radius, 1.0)
    if friction.over_spot:
        axes = [
            axes_along(radius, one.locus_radius, one.groove_radius, side) for one, side in ((inner, -1.0), (outer, 1.0))
        ]
        spot = coefficient, contact.friction, *axes
    return Bearing(
        balls=geometry.balls,
        ball_radius=radius,
        ball_mass=mass,
        ball_inertia=0.4 * mass * radius**2,
        inner=inner,
        outer=outer,
        offset=tuple(parameters.drive.offset),
        gravity=tuple(parameters.gravity),
        damping=damping,
        relaxation_time=relaxation_time,
        friction_coefficient=contact.friction_coefficient,
        friction_regularisation=contact.friction_regularisation,
        pair_coefficient=hertz_coefficient(1.0 / radius, 1.0 / radius, pair),
        raceway_friction=0.0 if friction.over_spot else coefficient,
        spot=spot,
        ring=_ring_motion(parameters),
        pockets=_pockets(parameters),
        film=film,
    )


def _ring_motion(parameters: BearingScene) -> RingMotion | LevelMotion | tuple:
    """The ring's tilt and motion at the start, empty where it only spins about z."""
    tilt, dimension = tuple(map(float, parameters.drive.tilt)), dimension_of(parameters)
    if dimension == FREE_RING and not tilts(parameters):
        return LevelMotion((0.0, 0.0, 0.0))
    if dimension == FREE_RING or (dimension == PRESCRIBED and any(tilt)):
        return RingMotion(tilt, (0.0, 0.0, 0.0), (0.0, 0.0))
    return ()


def _pockets(parameters: BearingScene) -> Pockets | MovingPockets | tuple:
    cage = parameters.cage
    if cage.kind != POCKETS or dimension_of(parameters) == QUASI_STATIC:
        return ()
    radius = 0.5 * parameters.geometry.pitch_diameter
    walls = Pockets(radius, 0.5 * cage.pocket_clearance, cage.stiffness, cage.relaxation_time, cage.friction)
    return MovingPockets(walls) if moving_centre(parameters) else walls


def nominal_curvatures(geometry: Geometry) -> tuple[tuple[float, float], ...]:
    """Curvatures (small, large) of the gap [1/m] at the inner and the outer contact, at contact angle zero."""
    ball = 2.0 / geometry.ball_diameter
    pairs = []
    for side, conformity in ((-1.0, geometry.inner_conformity), (1.0, geometry.outer_conformity)):
        small = 0.5 * (ball - 1.0 / (conformity * geometry.ball_diameter))
        large = 0.5 * (ball - side / (0.5 * geometry.pitch_diameter + side / ball))
        pairs.append((small, max(small, large)))
    return tuple(pairs)


def start_state(bearing: Bearing, inner_speed: float, motion: str) -> np.ndarray:
    """State (N, COLUMNS) at the start: balls evenly spaced, resting between the raceways, rolling or not moving.

    Raises SceneError when a ball has no rest between the raceways.
    """
    state = np.zeros((bearing.balls, COLUMNS))
    if not compiled_balls.place(bearing, float(inner_speed), motion == "rolling", state):
        raise SceneError(
            "the balls find no rest between the raceways; check radial_clearance, drive.offset and the speed"
        )
    return state


def start_orientation(state: np.ndarray) -> np.ndarray:
    """Orientations (N, 4), x, y, z, w, of balls in a state (N, COLUMNS): turned back about z by their orbit angle."""
    half, nothing = -0.5 * state[:, ORBIT_ANGLE], np.zeros(len(state))
    return np.stack((nothing, nothing, np.sin(half), np.cos(half)), axis=1)
