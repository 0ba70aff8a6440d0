"""Rates of balls side by side, and how the raceways answer to velocity and spin alone: what `imex` steps by."""

from bearing_twin.compiled import inlined
from bearing_twin.contact.elasticity import looked_up
from bearing_twin.kinds.bearing.forces.equations import (
    ON_AXIS,
    give_coefficients,
    lane_position,
    placed,
    put_rates,
    raceway_contact,
)
from bearing_twin.kinds.bearing.forces.gradient import driven, raceway_slopes
from bearing_twin.kinds.bearing.forces.jacobian import put_resistance, rates_and_jacobian
from bearing_twin.kinds.bearing.forces.layout import (
    GIVEN_INNER,
    GIVEN_OUTER,
    ORBIT_ANGLE,
    RING_SPEED,
    SPIN,
    VELOCITY,
    entry,
    get_jacobian_block,
)
from bearing_twin.numerics.lanes import LANES, get, get_vector
from bearing_twin.numerics.rotation import about_z, add, cosine_sine, dot


@inlined
def _resisting(bearing, raceway, given, centre, ring_speed, position, velocity, spin):
    """`raceway_contact` and its derivatives by velocity and spin."""
    contact = raceway_contact(bearing, raceway, given, centre, ring_speed, position, velocity, spin)
    slopes = raceway_slopes(bearing, raceway, given, 0.0, contact, 0.0)  # those by places are not looked at
    point = add(placed(position, centre)[0], contact.arm)
    return contact, driven(contact, slopes, (-ring_speed * point[1], ring_speed * point[0], 0.0))


@inlined
def rates_and_resistance(spot, ring, bearing, lanes):
    """The rates of each lane, and their derivatives by velocity and spin; `spot` and `ring` are the bearing's.

    Friction over the spots and a ring that tilts take the whole Jacobian.
    """
    if len(spot) > 0 or len(ring) > 0:
        rates_and_jacobian(spot, bearing, lanes)
    else:
        if looked_up(bearing.inner.law):
            give_coefficients(bearing, lanes)
        for k in range(LANES):
            cosine, sine = cosine_sine(get(lanes, ORBIT_ANGLE, k))
            speed, position = get(lanes, RING_SPEED, k), lane_position(lanes, k)
            velocity, spin = get_vector(lanes, VELOCITY, k), get_vector(lanes, SPIN, k)
            centre = about_z(cosine, -sine, bearing.offset)
            given = get(lanes, GIVEN_INNER, k)
            one, inner = _resisting(bearing, bearing.inner, given, centre, speed, position, velocity, spin)
            given = get(lanes, GIVEN_OUTER, k)
            two, outer = _resisting(bearing, bearing.outer, given, ON_AXIS, 0.0, position, velocity, spin)
            gravity = about_z(cosine, -sine, bearing.gravity)
            put_rates(bearing, gravity, position, velocity, spin, one, two, lanes, k)
            put_resistance(bearing, position, velocity, spin, one.drive_power, inner, outer, lanes, k)


@inlined
def lane_resistance(lanes, k):
    """How the velocity and spin rates of lane k answer to velocity and spin: four blocks, row after row."""
    return (
        get_jacobian_block(lanes, VELOCITY, VELOCITY, k),
        get_jacobian_block(lanes, VELOCITY, SPIN, k),
        get_jacobian_block(lanes, SPIN, VELOCITY, k),
        get_jacobian_block(lanes, SPIN, SPIN, k),
    )


@inlined
def lane_change(lanes, rate, k, velocity, spin):
    """One row of lane k's Jacobian times increments of velocity and spin."""
    return dot(get_vector(lanes, entry(rate, VELOCITY), k), velocity) + dot(
        get_vector(lanes, entry(rate, SPIN), k), spin
    )
