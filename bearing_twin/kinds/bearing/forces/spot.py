"""Friction of the ball-raceway contacts over their elliptic spots, by any row of `friction.FRICTIONS` that needs one.

Each point of a spot slides with slip + spin x r (Contensou, Erismann), so that spinning weakens the friction force, and
a drilling torque acts about the contact normal. The spot is flat and its pressure Hertz's: the differential slip of a
curved spot (Heathcote) is left out. Friction at a point is part of `raceway_contact`; bearings with it have an empty
`spot`: the branches below are then dropped while compiling, and cost neither time to run nor to compile.

A spot's axes are the meridian across the groove (major) and the ring's circumference (minor).
"""

import math
from typing import NamedTuple

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.ellipse import semi_axes
from bearing_twin.contact.friction import COARSE_POINTS, friction_of, slip_share
from bearing_twin.kinds.bearing.forces.equations import ON_AXIS, lane_position, raceway_contact
from bearing_twin.kinds.bearing.forces.layout import (
    ACROSS,
    ALONG,
    AXIAL_PUSH,
    DISSIPATED,
    DRIVE_WORK,
    GIVEN_INNER,
    GIVEN_OUTER,
    GROSS_WORK,
    LANE_RATES,
    LANES,
    MOMENT,
    ORBIT_ANGLE,
    RING_SPEED,
    SEMI_MAJOR,
    SEMI_MINOR,
    SLIP_MAJOR,
    SLIP_MINOR,
    SPIN,
    SPIN_RATE,
    SPOTS,
    VELOCITY,
    get,
    get_vector,
    increase,
    increase_vector,
    put,
)
from bearing_twin.numerics.rotation import about_z, add, cosine_sine, cross, dot, minus, scaled

INNER_SPOTS, OUTER_SPOTS = 0, LANES  # where the spots of a ring begin among the SPOTS of all lanes


class Spot(NamedTuple):
    """A spot: its axes, semi-axes [m], slip along the axes [m/s], and the contact point from the ring's centre."""

    major: tuple[float, float, float]
    minor: tuple[float, float, float]
    semi_major: float
    semi_minor: float
    slip_major: float
    slip_minor: float
    point: tuple[float, float, float]


class SpotAnswer(NamedTuple):
    """What friction over a spot does: force and torque on the ball, power of the ring on it and power lost [W].

    `drilling` [N m] is the torque's part about the contact normal, the rest is the force's about the ball's centre;
    `turning` [N m] is the moment on the ball about the ring's axis.
    """

    friction: tuple[float, float, float]
    drilling: float
    torque: tuple[float, float, float]
    drive_power: float
    turning: float
    dissipation: float


@inlined
def spot_of(contact, centre, position):
    """The spot of a contact with the ring centred at `centre`; major axis, minor axis and normal are right-handed."""
    offset = minus(position, centre)
    inverse = 1.0 / math.sqrt(offset[0] * offset[0] + offset[1] * offset[1])
    minor = (-inverse * offset[1], inverse * offset[0], 0.0)
    major = cross(minor, contact.normal)
    semi_major, semi_minor = semi_axes(contact.curvature_small, contact.curvature_large, contact.approach)
    slip = contact.slip
    return Spot(
        major=major,
        minor=minor,
        semi_major=semi_major,
        semi_minor=semi_minor,
        slip_major=dot(slip, major),
        slip_minor=dot(slip, minor),
        point=add(offset, contact.arm),
    )


@inlined
def spot_answer(coefficient, ring_speed, contact, spot, along, across, moment):
    """The answer of a spot with these means of the slip's direction and of its moment [m]."""
    limit = coefficient * contact.normal_load
    friction = add(scaled(-limit * along, spot.major), scaled(-limit * across, spot.minor))
    drilling = -limit * moment
    turning = spot.point[0] * friction[1] - spot.point[1] * friction[0] + drilling * contact.normal[2]
    loss = along * spot.slip_major + across * spot.slip_minor + moment * contact.spin_rate
    torque = add(cross(contact.arm, friction), scaled(drilling, contact.normal))
    return SpotAnswer(
        friction=friction,
        drilling=drilling,
        torque=torque,
        drive_power=ring_speed * turning,
        turning=turning,
        dissipation=limit * loss,
    )


@inlined
def means_of(number, semi_major, semi_minor, slip_major, slip_minor, spin, regularisation):
    """The means over a spot that `spot_answer` takes, by the friction model of that number."""
    unit = friction_of(number, 1.0, semi_major, semi_minor, slip_major, slip_minor, spin, 1.0, regularisation)
    return -unit.force_major, -unit.force_minor, -unit.torque


@inlined
def spot_contacts(bearing, lanes, k):
    """Both contacts of a lane, without friction, and the frames of their spots."""
    cosine, sine = cosine_sine(get(lanes, ORBIT_ANGLE, k))
    position = lane_position(lanes, k)
    velocity, spin = get_vector(lanes, VELOCITY, k), get_vector(lanes, SPIN, k)
    centre, middle = about_z(cosine, -sine, bearing.offset), (0.0, 0.0, 0.0)
    speed, given = get(lanes, RING_SPEED, k), get(lanes, GIVEN_INNER, k)
    inner = raceway_contact(bearing, bearing.inner, given, centre, speed, position, velocity, spin)
    given = get(lanes, GIVEN_OUTER, k)
    outer = raceway_contact(bearing, bearing.outer, given, ON_AXIS, 0.0, position, velocity, spin)
    return inner, spot_of(inner, centre, position), outer, spot_of(outer, middle, position)


@inlined
def _set_out(contact, spot, lanes, k):
    """Writes what the quadrature of spot k reads, and its means as zero."""
    put(lanes, SLIP_MAJOR, k, spot.slip_major)
    put(lanes, SLIP_MINOR, k, spot.slip_minor)
    put(lanes, SPIN_RATE, k, contact.spin_rate)
    put(lanes, SEMI_MAJOR, k, spot.semi_major)
    put(lanes, SEMI_MINOR, k, spot.semi_minor)
    put(lanes, ALONG, k, 0.0)
    put(lanes, ACROSS, k, 0.0)
    put(lanes, MOMENT, k, 0.0)


@kernel
def over_spots(regularisation, lanes):
    """The means over both spots of all lanes, side by side: what `friction.spot_friction_fast` sums."""
    for i in range(len(COARSE_POINTS)):
        x, y, weight = COARSE_POINTS[i, 0], COARSE_POINTS[i, 1], COARSE_POINTS[i, 2]
        for k in range(SPOTS):
            major, minor = get(lanes, SEMI_MAJOR, k) * x, get(lanes, SEMI_MINOR, k) * y
            slip_major, slip_minor = get(lanes, SLIP_MAJOR, k), get(lanes, SLIP_MINOR, k)
            spin = get(lanes, SPIN_RATE, k)
            one = slip_share(major, minor, weight, slip_major, slip_minor, spin, regularisation)
            increase(lanes, ALONG, k, one[0])
            increase(lanes, ACROSS, k, one[1])
            increase(lanes, MOMENT, k, one[2])


@kernel
def _one_by_one(number, regularisation, lanes):
    """The same for a model that is not in lanes."""
    for k in range(SPOTS):
        axes = get(lanes, SEMI_MAJOR, k), get(lanes, SEMI_MINOR, k)
        slip = get(lanes, SLIP_MAJOR, k), get(lanes, SLIP_MINOR, k)
        means = means_of(number, axes[0], axes[1], slip[0], slip[1], get(lanes, SPIN_RATE, k), regularisation)
        put(lanes, ALONG, k, means[0])
        put(lanes, ACROSS, k, means[1])
        put(lanes, MOMENT, k, means[2])


@inlined
def _lane_answer(coefficient, ring_speed, contact, spot, lanes, k):
    along, across, moment = get(lanes, ALONG, k), get(lanes, ACROSS, k), get(lanes, MOMENT, k)
    return spot_answer(coefficient, ring_speed, contact, spot, along, across, moment)


@kernel
def _set_out_all(bearing, lanes):
    for k in range(LANES):
        inner, inner_spot, outer, outer_spot = spot_contacts(bearing, lanes, k)
        _set_out(inner, inner_spot, lanes, INNER_SPOTS + k)
        _set_out(outer, outer_spot, lanes, OUTER_SPOTS + k)


@kernel
def find_means(spot, bearing, lanes):
    """Fills what `lane_answers` reads: the motion in the spots of all lanes and the means over them."""
    _set_out_all(bearing, lanes)
    if spot[2]:
        over_spots(bearing.friction_regularisation, lanes)
    else:
        _one_by_one(spot[1], bearing.friction_regularisation, lanes)


@inlined
def lane_answers(coefficient, bearing, lanes, k):
    """What friction over a lane's inner and outer spot does, and the inner contact without it."""
    inner, inner_spot, outer, outer_spot = spot_contacts(bearing, lanes, k)
    one = _lane_answer(coefficient, get(lanes, RING_SPEED, k), inner, inner_spot, lanes, INNER_SPOTS + k)
    return one, _lane_answer(coefficient, 0.0, outer, outer_spot, lanes, OUTER_SPOTS + k), inner


@kernel
def _add_all(coefficient, bearing, lanes):
    inverse_mass, inverse_inertia = 1.0 / bearing.ball_mass, 1.0 / bearing.ball_inertia
    for k in range(LANES):
        one, two, inner = lane_answers(coefficient, bearing, lanes, k)
        increase_vector(lanes, LANE_RATES + VELOCITY, k, scaled(inverse_mass, add(one.friction, two.friction)))
        increase_vector(lanes, LANE_RATES + SPIN, k, scaled(inverse_inertia, add(one.torque, two.torque)))
        power = inner.drive_power + one.drive_power
        put(lanes, LANE_RATES + DRIVE_WORK, k, power)
        increase(lanes, LANE_RATES + DISSIPATED, k, one.dissipation + two.dissipation)
        put(lanes, LANE_RATES + GROSS_WORK, k, abs(power))
        put(lanes, AXIAL_PUSH, k, -(inner.axial_moment + one.turning))


@kernel
def add_spots(spot, bearing, lanes):
    """Adds what friction over the spots does to the rates of all lanes; nothing where the bearing's `spot` is empty."""
    if len(spot) > 0:
        find_means(spot, bearing, lanes)
        _add_all(spot[0], bearing, lanes)
