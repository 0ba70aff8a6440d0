"""From a bearing scene to the numbers of its equations, and to the state it starts from."""

import math

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.elasticity import elasticity
from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.friction import FRICTIONS, friction_number
from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.kinds.bearing.clearance import operating_geometry
from bearing_twin.kinds.bearing.forces.along_groove import axes_along
from bearing_twin.kinds.bearing.forces.cage import Pockets
from bearing_twin.kinds.bearing.forces.equations import Bearing, raceway_of, single_contact, static_force
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, HEIGHT, ORBIT_ANGLE, SPIN, TANGENTIAL_VELOCITY
from bearing_twin.kinds.bearing.forces.moving_cage import MovingPockets
from bearing_twin.kinds.bearing.forces.ring_seat import LevelMotion, RingMotion
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
from bearing_twin.numerics.lanes import COLUMNS
from bearing_twin.numerics.least_squares import least_squares
from bearing_twin.numerics.rotation import about_z

REACH = 0.02  # of the ball radius: rest is looked for so far around the middle between the raceways
NUDGE = 1e-10  # m: over which the force's gradient is taken
EXACT = 1e-16  # m, of a rest
MOST_STEPS = 60
SAME = 1e-9  # of a ball's surface speed: spin that changes slip by less than this is rounding
DRILLS = 0.03  # and by less than this drilling
PLACED = 100  # balls placed in one go, within 50 ms: between them Python hears of a signal


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
    spot = ()
    if friction.over_spot:
        axes = [
            axes_along(radius, one.locus_radius, one.groove_radius, side) for one, side in ((inner, -1.0), (outer, 1.0))
        ]
        spot = contact.friction_coefficient, friction_number(contact.friction), tuple(friction.rule), *axes
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
        raceway_friction=0.0 if friction.over_spot else contact.friction_coefficient,
        spot=spot,
        ring=_ring_motion(parameters),
        pockets=_pockets(parameters),
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


@kernel
def _force_and_gradient(bearing, orbit_rate, orbit_angle, r, z):
    """`static_force` there, and its differences (2, 2) by distance and height [N/m]."""
    radial, axial = static_force(bearing, orbit_rate, r, orbit_angle, z)
    by_r = static_force(bearing, orbit_rate, r + NUDGE, orbit_angle, z)
    by_z = static_force(bearing, orbit_rate, r, orbit_angle, z + NUDGE)
    return (
        radial,
        axial,
        (
            ((by_r[0] - radial) / NUDGE, (by_z[0] - radial) / NUDGE),
            ((by_r[1] - axial) / NUDGE, (by_z[1] - axial) / NUDGE),
        ),
    )


@inlined
def _next_guess(force, slope, at, low, high):
    """Newton's step, or the middle where it leaves the bracket; with the bracket that is left."""
    low, high = (at, high) if force > 0.0 else (low, at)
    wanted = at - force / slope if slope < 0.0 else high
    return wanted if low < wanted < high else 0.5 * (low + high), low, high


@kernel
def _radial_rest(bearing, orbit_rate, orbit_angle, nominal, height):
    """Axis distance [m] without radial force at that height, within REACH of the nominal one; NaN if there is none."""
    reach, distance = REACH * bearing.ball_radius, nominal
    low, high = nominal - reach, nominal + reach
    lowest = static_force(bearing, orbit_rate, low, orbit_angle, height)[0]
    if not lowest >= 0.0 >= static_force(bearing, orbit_rate, high, orbit_angle, height)[0]:
        return math.nan
    for _ in range(MOST_STEPS):
        radial, _, gradient = _force_and_gradient(bearing, orbit_rate, orbit_angle, distance, height)
        before = distance
        if radial != 0.0:
            distance, low, high = _next_guess(radial, gradient[0][0], distance, low, high)
        if abs(distance - before) <= EXACT:
            break
    return distance


@kernel
def _rest(bearing, orbit_rate, orbit_angle):
    """Axis distance and height [m] where a ball rests between the raceways at that orbit rate, friction left out.

    With clearance a ball rests on the one raceway its own orbit presses it to, and in the middle where nothing does.
    NaN when there is no rest between the raceways. Its height is between those of the rings' centres.
    """
    inner, outer = bearing.inner, bearing.outer
    share = (inner.groove_radius - bearing.ball_radius) / (
        inner.groove_radius + outer.groove_radius - 2.0 * bearing.ball_radius
    )
    nominal = inner.locus_radius + (outer.locus_radius - inner.locus_radius) * share
    nominal += 0.5 * (math.cos(orbit_angle) * bearing.offset[0] + math.sin(orbit_angle) * bearing.offset[1])
    low, high = min(0.0, bearing.offset[2]), max(0.0, bearing.offset[2])
    height = 0.5 * bearing.offset[2]
    distance = _radial_rest(bearing, orbit_rate, orbit_angle, nominal, height)
    for _ in range(MOST_STEPS):
        if low == high or not distance < math.inf:
            break
        _, axial, g = _force_and_gradient(bearing, orbit_rate, orbit_angle, distance, height)
        before = height
        if axial != 0.0:
            # The axial force along the heights at which nothing pushes radially.
            slope = g[1][1] - g[1][0] * g[0][1] / g[0][0]
            height, low, high = _next_guess(axial, slope, height, low, high)
        if abs(height - before) <= EXACT:
            break
        distance = _radial_rest(bearing, orbit_rate, orbit_angle, nominal, height)
    return distance, height


@kernel
def _slips(bearing, inner_speed, centre, position, unknown, out):
    """Slip (6,) of a ball at both raceways for its tangential velocity and angular velocity (4,)."""
    velocity, spin = (0.0, unknown[0], 0.0), (unknown[1], unknown[2], unknown[3])
    inner = single_contact(bearing, bearing.inner, centre, inner_speed, position, velocity, spin)
    outer = single_contact(bearing, bearing.outer, (0.0, 0.0, 0.0), 0.0, position, velocity, spin)
    for i in range(3):
        out[i], out[3 + i] = inner.slip[i], outer.slip[i]


@kernel
def rolling(bearing, inner_speed, orbit_angle, axis_distance, height, share):
    """Tangential velocity and angular velocity (4,) of a ball that slips on neither raceway, by least squares.

    Slip is linear in the four unknowns, so one solve gives the rolling motion; among several the one with least spin.
    Spin that changes slip by less than `share` of a ball's surface speed is left out.
    """
    centre = about_z(math.cos(orbit_angle), -math.sin(orbit_angle), bearing.offset)
    position = (axis_distance, 0.0, height)
    none, one, unit = np.empty(6), np.empty(6), np.zeros(4)
    matrix, found = np.empty((6, 4)), np.empty(4)
    _slips(bearing, inner_speed, centre, position, unit, none)
    scale = np.empty(4)
    for j in range(4):
        scale[j] = 1.0 / bearing.ball_radius if j > 0 else 1.0
        unit[j] = 1.0
        _slips(bearing, inner_speed, centre, position, unit, one)
        unit[j] = 0.0
        for i in range(len(none)):  # written out: Numba's assignment of arrays takes 3 s to compile
            matrix[i, j] = (one[i] - none[i]) * scale[j]
    for i in range(len(none)):
        none[i] = -none[i]
    least_squares(matrix, none, share, found)
    for j in range(4):
        found[j] *= scale[j]
    return found


@kernel
def let_roll(bearing, inner_speed, share, ball):
    """Gives a ball (COLUMNS,) the motion with which it rolls where it is; `share` as of `rolling`."""
    motion = rolling(bearing, inner_speed, ball[ORBIT_ANGLE], ball[AXIS_DISTANCE], ball[HEIGHT], share)
    ball[TANGENTIAL_VELOCITY] = motion[0]
    for i in range(3):
        ball[SPIN + i] = motion[1 + i]


@kernel
def _place_balls(bearing, inner_speed, rolls, first, last, state):
    """Fills the state of balls `first` to `last`, that left out; whether each found its rest."""
    for k in range(first, last):
        angle = 2.0 * math.pi * k / bearing.balls
        distance, height = _rest(bearing, 0.0, angle)
        for _ in range(3 if rolls else 0):
            orbit_rate = rolling(bearing, inner_speed, angle, distance, height, SAME)[0] / distance
            distance, height = _rest(bearing, orbit_rate, angle)
        if not distance < math.inf:
            return False
        state[k, AXIS_DISTANCE], state[k, ORBIT_ANGLE], state[k, HEIGHT] = distance, angle, height
        if rolls:
            let_roll(bearing, inner_speed, SAME, state[k])
    return True


@kernel
def least_drilling(bearing, inner_speed, state):
    """Lets balls roll without spin about their contacts, if every one is pressed by both raceways.

    Such spin changes slip only by as much as an inner ring that stands off the axis puts the contacts off one line, but
    would have to turn a ball's axis all over to spare it, and takes seconds to settle. Balls that come out of a loaded
    zone have no axis to keep.
    """
    for k in range(len(state)):
        angle, position = state[k, ORBIT_ANGLE], (state[k, AXIS_DISTANCE], 0.0, state[k, HEIGHT])
        centre, rest = about_z(math.cos(angle), -math.sin(angle), bearing.offset), (0.0, 0.0, 0.0)
        inner = single_contact(bearing, bearing.inner, centre, inner_speed, position, rest, rest)
        outer = single_contact(bearing, bearing.outer, rest, 0.0, position, rest, rest)
        if not (inner.approach > 0.0 and outer.approach > 0.0):
            return
    for k in range(len(state)):
        let_roll(bearing, inner_speed, DRILLS, state[k])


def start_state(bearing: Bearing, inner_speed: float, motion: str) -> np.ndarray:
    """State (N, COLUMNS) at the start: balls evenly spaced, resting between the raceways, rolling or not moving.

    Raises SceneError when a ball has no rest between the raceways.
    """
    state = np.zeros((bearing.balls, COLUMNS))
    for first in range(0, bearing.balls, PLACED):
        some = first, min(bearing.balls, first + PLACED)
        if not _place_balls(bearing, float(inner_speed), motion == "rolling", *some, state):
            raise SceneError(
                "the balls find no rest between the raceways; check radial_clearance, drive.offset and the speed"
            )
    if motion == "rolling":
        least_drilling(bearing, float(inner_speed), state)
    return state


def start_orientation(state: np.ndarray) -> np.ndarray:
    """Orientations (N, 4), x, y, z, w, of balls in a state (N, COLUMNS): turned back about z by their orbit angle."""
    half, nothing = -0.5 * state[:, ORBIT_ANGLE], np.zeros(len(state))
    return np.stack((nothing, nothing, np.sin(half), np.cos(half)), axis=1)
