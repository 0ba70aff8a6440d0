"""How balls answer to the speed of a shaft that a torque turns, and its moment to their motion, balls side by side.

With u = z x (d + arm), what a turn of the ring adds to the velocity of its surface at the contact, forces answer to the
speed as to a velocity -u of the ball. The moment on the ball about the ring's axis is m = z . (d x F + T).
"""

import math
from typing import NamedTuple

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces.equations import lane_position
from bearing_twin.kinds.bearing.forces.gradient import contact_gradient
from bearing_twin.kinds.bearing.forces.layout import (
    BALL_BY_SHAFT,
    DISSIPATED,
    DRIVE_WORK,
    GIVEN_INNER,
    GIVEN_SLOPE_INNER,
    GROSS_WORK,
    ORBIT_ANGLE,
    PLACES,
    RING_SPEED,
    SHAFT_BY_BALL,
    SHAFT_BY_BORDER,
    SHAFT_OWN,
    SHARES,
    SPIN,
    VELOCITY,
)
from bearing_twin.kinds.bearing.forces.ring_gradient import number_answer, put_number
from bearing_twin.kinds.bearing.forces.ring_seat import ring_in_lane, seat_of, seen_from
from bearing_twin.numerics.block_solve import combined, times
from bearing_twin.numerics.lanes import LANES, get, get_vector, put, put_vector
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rotation import about_z, add, cosine_sine, cross, dot, minus, scaled


class _BySpeed(NamedTuple):
    """What a contact answers to the ring's speed: force and torque on the ball, their moment m, power and loss."""

    force: tuple
    torque: tuple
    moment: float
    power: float
    loss: float


@inlined
def _by_speed(contact, by, d, speed):
    """The answers to the ring's `speed`, with the ball at `d` from the ring's centre."""
    point = add(d, contact.arm)
    back = (point[1], -point[0], 0.0)
    force, torque = times(by.force_v, back), times(by.torque_v, back)
    moment = d[0] * force[1] - d[1] * force[0] + torque[2]
    return _BySpeed(force, torque, moment, contact.axial_moment + speed * moment, dot(by.loss_v, back))


@inlined
def _moment_rows(contact, by, d, across):
    """m by the ball's place, its second column along `across`, velocity and spin."""
    lever, force = (-d[1], d[0], 0.0), contact.force
    moved = (force[1], across[0] * force[1] - across[1] * force[0], 0.0)
    place = add(add(combined(lever, by.force_p), by.torque_p[2]), moved)
    velocity = add(combined(lever, by.force_v), by.torque_v[2])
    return place, velocity, add(combined(lever, by.force_s), by.torque_s[2])


@inlined
def _put_column(bearing, lanes, k, found, force, torque, power):
    """Writes how a ball's rates answer to the shaft's speed; force and torque in the ball's frame."""
    put_vector(lanes, BALL_BY_SHAFT, k, scaled(1.0 / bearing.ball_mass, force))
    put_vector(lanes, BALL_BY_SHAFT + SPIN - VELOCITY, k, scaled(1.0 / bearing.ball_inertia, torque))
    put(lanes, BALL_BY_SHAFT + DRIVE_WORK - VELOCITY, k, found.power)
    put(lanes, BALL_BY_SHAFT + DISSIPATED - VELOCITY, k, found.loss)
    put(lanes, BALL_BY_SHAFT + GROSS_WORK - VELOCITY, k, math.copysign(1.0, power) * found.power)
    put(lanes, SHAFT_OWN, k, -found.moment)


@inlined
def _put_row(lanes, k, place, velocity, spin):
    """Writes how the moment on the shaft answers to a ball's motion."""
    put_vector(lanes, SHAFT_BY_BALL, k, scaled(-1.0, place))
    put_vector(lanes, SHAFT_BY_BALL + VELOCITY, k, scaled(-1.0, velocity))
    put_vector(lanes, SHAFT_BY_BALL + SPIN, k, scaled(-1.0, spin))


@lean_kernel
def _put_held(bearing, lanes):
    """Of a ring that is held and not tilted."""
    for k in range(LANES):
        cosine, sine = cosine_sine(get(lanes, ORBIT_ANGLE, k))
        centre, position = about_z(cosine, -sine, bearing.offset), lane_position(lanes, k)
        across, speed = (-centre[1], centre[0], 0.0), get(lanes, RING_SPEED, k)
        contact, by = contact_gradient(
            bearing, bearing.inner, get(lanes, GIVEN_INNER, k), get(lanes, GIVEN_SLOPE_INNER, k), centre, across, speed,
            position, get_vector(lanes, VELOCITY, k), get_vector(lanes, SPIN, k),
        )  # fmt: skip
        d = minus(position, centre)
        found = _by_speed(contact, by, d, speed)
        _put_column(bearing, lanes, k, found, found.force, found.torque, contact.drive_power)
        place, velocity, spin = _moment_rows(contact, by, d, across)
        _put_row(lanes, k, place, velocity, spin)
        for i in range(2 * PLACES):
            put(lanes, SHAFT_BY_BORDER + i, k, 0.0)


@inlined
def _brought_back(seat, vector):
    """A vector in the axes of a ring at this seat, in those of the ball's frame."""
    if len(seat) == 2:
        return vector
    return combined(vector, seat.axes)


@lean_kernel
def _put_seated(ring, bearing, lanes):
    """Of a ring that is tilted or moves; what balls do to it by the shaft's speed goes into SHARES."""
    for k in range(LANES):
        cosine, sine = cosine_sine(get(lanes, ORBIT_ANGLE, k))
        place, moving = ring_in_lane(ring, bearing.offset, lanes, k)
        seat, speed = seat_of(moving, place, cosine, sine), get(lanes, RING_SPEED, k)
        d, u, w = seen_from(seat, lane_position(lanes, k), get_vector(lanes, VELOCITY, k), get_vector(lanes, SPIN, k))
        middle, across = (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)
        contact, by = contact_gradient(
            bearing, bearing.inner, get(lanes, GIVEN_INNER, k), get(lanes, GIVEN_SLOPE_INNER, k), middle, across, speed,
            d, u, w,
        )  # fmt: skip
        found = _by_speed(contact, by, d, speed)
        force, torque = _brought_back(seat, found.force), _brought_back(seat, found.torque)
        _put_column(bearing, lanes, k, found, force, torque, contact.drive_power)
        by_place, by_velocity, by_spin = _moment_rows(contact, by, d, across)
        answer = number_answer(seat, d, u, w, by_place, by_velocity, by_spin)
        _put_row(lanes, k, (answer.place[0], answer.angle, answer.place[2]), answer.velocity, answer.spin)
        put(lanes, SHAFT_BY_BORDER + PLACES - 1, k, 0.0)
        put(lanes, SHAFT_BY_BORDER + 2 * PLACES - 1, k, 0.0)
        put_number(lanes, SHAFT_BY_BORDER, k, cosine, sine, -1.0, answer)
        put_vector(lanes, SHARES, k, about_z(cosine, sine, scaled(-1.0, force)))
        if len(ring) > 1:
            turned = about_z(cosine, sine, add(cross(d, force), torque))
            put(lanes, SHARES + 3, k, -turned[0])
            put(lanes, SHARES + 4, k, -turned[1])


@inlined
def put_shaft_answers(ring, bearing, lanes):
    """Writes how each ball answers to the shaft's speed and the moment on the shaft to its motion and to the ring's.

    Moments are not yet divided by inertia. Friction over the spots is left out; `ring` is the bearing's.
    """
    if len(ring) > 0:
        _put_seated(ring, bearing, lanes)
    else:
        _put_held(bearing, lanes)
