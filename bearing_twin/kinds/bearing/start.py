"""From a bearing scene to the numbers of its equations, and to the state it starts from."""

import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, root

from bearing_twin.contact.elastic import elastic
from bearing_twin.contact.elasticity import elasticity
from bearing_twin.contact.ellipse import HERTZ_U_MAX, hertz_coefficient, shape_variable
from bearing_twin.contact.friction import FRICTIONS, friction_number
from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.errors import SceneError
from bearing_twin.kinds.bearing.clearance import operating_geometry
from bearing_twin.kinds.bearing.equations import Bearing, raceway_of, single_contact, static_force
from bearing_twin.kinds.bearing.layout import AXIS_DISTANCE, COLUMNS, HEIGHT, ORBIT_ANGLE, SPIN, VELOCITY
from bearing_twin.kinds.bearing.parameters import BearingScene, Geometry, viscous_terms


class Rates(NamedTuple):
    """The fastest rates of a scene [1/s]: contact resonance, friction creep, and the shortest contact [s]."""

    contact: float
    friction: float
    shortest_contact: float


def bearing_of(parameters: BearingScene, law: str) -> Bearing:
    """The numbers of the equations of motion for a scene with the elastic law `law`.

    Raises SceneError where the law does not reach. Balls meet each other by Hertz's law, whatever the raceways do.
    """
    geometry, materials, contact = operating_geometry(parameters), parameters.materials, parameters.contact
    radius = 0.5 * geometry.ball_diameter
    mass = materials.ball.density * 4.0 / 3.0 * math.pi * radius**3
    pair = effective_modulus(materials.ball, materials.ball)
    if LAWS[law].in_lanes and too_narrow(geometry):
        raise SceneError(f"the law {law} ends at b/a = 0.01 and a groove here is closer; use hertz_exact")
    friction = FRICTIONS[contact.friction]
    spot = contact.friction_coefficient, friction_number(contact.friction), friction.in_lanes
    damping, relaxation_time = viscous_terms(contact)

    def law_of(ring):
        modulus = effective_modulus(materials.ball, ring)

        def at(small, large):
            return elasticity(law, modulus, LAWS[law].number(contact, hertz_coefficient(small, large, modulus)))

        return at

    return Bearing(
        balls=geometry.balls,
        ball_radius=radius,
        ball_mass=mass,
        ball_inertia=0.4 * mass * radius**2,
        inner=raceway_of(geometry, geometry.inner_conformity, -1.0, law_of(materials.inner_ring)),
        outer=raceway_of(geometry, geometry.outer_conformity, 1.0, law_of(materials.outer_ring)),
        offset=tuple(parameters.drive.offset),
        gravity=tuple(parameters.gravity),
        damping=damping,
        relaxation_time=relaxation_time,
        friction_coefficient=contact.friction_coefficient,
        friction_regularisation=contact.friction_regularisation,
        pair_coefficient=hertz_coefficient(1.0 / radius, 1.0 / radius, pair),
        raceway_friction=0.0 if friction.over_spot else contact.friction_coefficient,
        spot=spot if friction.over_spot else (),
    )


def too_narrow(geometry: Geometry) -> bool:
    """Whether an ellipse is narrower than b/a = 0.01, where the rational form of the law hertz ends."""
    return max(shape_variable(*pair) for pair in nominal_curvatures(geometry)) > HERTZ_U_MAX


def nominal_curvatures(geometry: Geometry) -> tuple[tuple[float, float], ...]:
    """Curvatures (small, large) of the gap [1/m] at the inner and the outer contact, at contact angle zero."""
    ball = 2.0 / geometry.ball_diameter
    pairs = []
    for side, conformity in ((-1.0, geometry.inner_conformity), (1.0, geometry.outer_conformity)):
        small = 0.5 * (ball - 1.0 / (conformity * geometry.ball_diameter))
        large = 0.5 * (ball - side / (0.5 * geometry.pitch_diameter + side / ball))
        pairs.append((small, max(small, large)))
    return tuple(pairs)


def equilibrium(bearing: Bearing, orbit_rate: float, orbit_angle: float) -> tuple[float, float]:
    """Axis distance and height [m] where a ball rests between the raceways at that orbit rate, friction left out.

    With clearance a ball rests on the one raceway its own orbit presses it to. Raises SceneError when there is no
    rest between the raceways.
    """
    nominal = bearing.inner.locus_radius + (bearing.outer.locus_radius - bearing.inner.locus_radius) * (
        bearing.inner.groove_radius - bearing.ball_radius
    ) / (bearing.inner.groove_radius + bearing.outer.groove_radius - 2.0 * bearing.ball_radius)
    cosine, sine = math.cos(orbit_angle), math.sin(orbit_angle)
    nominal += 0.5 * (cosine * bearing.offset[0] + sine * bearing.offset[1])
    height = 0.5 * bearing.offset[2]
    reach = 0.02 * bearing.ball_radius

    def radial(distance):
        return static_force(bearing, orbit_rate, distance, orbit_angle, height)[0]

    low, high = nominal - reach, nominal + reach
    if not radial(low) >= 0.0 >= radial(high):
        raise SceneError(
            "the balls find no rest between the raceways; check radial_clearance, drive.offset and the speed"
        )
    distance = brentq(radial, low, high, xtol=1e-16, rtol=1e-15)
    if bearing.offset[2] != 0.0:
        scale = max(abs(radial(nominal - 1e-6)), 1e-9)
        found = root(
            lambda x: np.array(static_force(bearing, orbit_rate, 1e-6 * x[0], orbit_angle, 1e-6 * x[1])) / scale,
            np.array([distance, height]) * 1e6,
            tol=1e-13,
        )
        if np.all(np.abs(found.fun) < 1e-6):
            distance, height = 1e-6 * found.x
    return distance, height


def rolling(
    bearing: Bearing, inner_speed: float, orbit_angle: float, axis_distance: float, height: float
) -> np.ndarray:
    """Tangential velocity and angular velocity (4,) of a ball that slips on neither raceway, by least squares.

    Slip is linear in the four unknowns, so one solve gives the rolling motion; among several the one with least spin.
    """
    cosine, sine = math.cos(orbit_angle), math.sin(orbit_angle)
    x, y, z = bearing.offset
    centre = (cosine * x + sine * y, -sine * x + cosine * y, z)
    position = (axis_distance, 0.0, height)

    def slips(unknown):
        velocity, spin = (0.0, float(unknown[0]), 0.0), tuple(float(v) for v in unknown[1:])
        inner = single_contact(bearing, bearing.inner, centre, inner_speed, position, velocity, spin)
        outer = single_contact(bearing, bearing.outer, (0.0, 0.0, 0.0), 0.0, position, velocity, spin)
        return np.array([*inner.slip, *outer.slip])

    none = slips(np.zeros(4))
    matrix = np.stack([slips(unit) - none for unit in np.eye(4)], axis=1)
    scale = np.array([1.0, *(1.0 / bearing.ball_radius,) * 3])
    return scale * np.linalg.lstsq(matrix * scale, -none, rcond=1e-9)[0]


def start_state(bearing: Bearing, inner_speed: float, motion: str) -> np.ndarray:
    """State (N, COLUMNS) at the start: balls evenly spaced, resting between the raceways, rolling or not moving."""
    state = np.zeros((bearing.balls, COLUMNS))
    for k in range(bearing.balls):
        angle = 2.0 * math.pi * k / bearing.balls
        distance, height = equilibrium(bearing, 0.0, angle)
        state[k, ORBIT_ANGLE] = angle
        if motion == "rolling":
            for _ in range(3):
                orbit_rate = rolling(bearing, inner_speed, angle, distance, height)[0] / distance
                distance, height = equilibrium(bearing, orbit_rate, angle)
            state[k, VELOCITY + 1], *state[k, SPIN : SPIN + 3] = rolling(bearing, inner_speed, angle, distance, height)
        state[k, AXIS_DISTANCE], state[k, HEIGHT] = distance, height
    return state


def fastest_rates(bearing: Bearing, state: np.ndarray, inner_speed: float) -> Rates:
    """Contact resonance [rad/s], friction creep rate [1/s] and shortest contact [s] to be expected from a state.

    Loads are those of the state, at least those of a 1 micrometre approach; a ball between two contacts has both
    stiffnesses. The shortest contact is half a period of the contact resonance.
    """
    approach = 1e-6
    still = (0.0, 0.0, 0.0)
    for k in range(bearing.balls):
        position = (state[k, AXIS_DISTANCE], 0.0, state[k, HEIGHT])
        outer = single_contact(bearing, bearing.outer, still, 0.0, position, still, still)
        approach = max(approach, outer.approach)
    inner, outer = bearing.inner.law, bearing.outer.law
    stiffness = elastic(inner.given + outer.given, inner.power, approach).stiffness
    load = elastic(max(inner.given, outer.given), inner.power, approach).load
    creep = bearing.friction_coefficient * load / bearing.friction_regularisation
    # A tangential force at the surface moves it as if the mass were 2/7 of the ball's; two contacts act together.
    friction = 2.0 * 3.5 * creep / bearing.ball_mass
    contact = math.sqrt(stiffness / bearing.ball_mass)
    return Rates(contact, friction, math.pi / contact)


def stable_step(rates: Rates, stepper: str) -> float:
    """A step [s] for a method with fixed steps: 16 a contact and, for rk4, inside its stability limit of 2.78/rate."""
    contact = rates.shortest_contact / 16.0
    return contact if stepper == "imex" else min(contact, 1.4 / max(rates.friction, 1.0))
