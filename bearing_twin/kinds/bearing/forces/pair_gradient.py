"""The derivatives of a contact of two balls, by what `gradient` says of any contact."""

import math
from typing import NamedTuple

from bearing_twin.compiled import inlined
from bearing_twin.contact.elastic import HERTZIAN
from bearing_twin.kinds.bearing.forces.equations import ball_on_ball
from bearing_twin.kinds.bearing.forces.gradient import (
    SHALLOWEST,
    ContactMotion,
    Slopes,
    displaced,
    driven,
    matrix_of,
    slopes_of,
)
from bearing_twin.numerics.block_solve import times
from bearing_twin.numerics.rotation import add, cross, dot, scaled


class PairGradient(NamedTuple):
    """Derivatives of a contact of balls by the distance (p), velocity (v) and spin (s) that `ball_on_ball` is given.

    `force_turn`, ... are those by the angle from the ball to the other, in the ball's frame.
    """

    force_p: tuple
    force_v: tuple
    force_s: tuple
    force_turn: tuple
    torque_p: tuple
    torque_v: tuple
    torque_s: tuple
    torque_turn: tuple
    loss_p: tuple
    loss_v: tuple
    loss_s: tuple
    loss_turn: float


@inlined
def _apart(contact, slopes, place, direction):
    """The change of a contact of balls when the other moves in `direction`."""
    approach = -dot(contact.normal, direction)
    distance = 2.0 * math.sqrt(dot(contact.arm, contact.arm) + 1e-300)
    normal = scaled(1.0 / distance, add(direction, scaled(approach, contact.normal)))
    return displaced(contact, slopes, place, (0.0, 0.0, 0.0), approach, normal, scaled(0.5, direction), 0.0)


@inlined
def pair_gradient(bearing, may_touch, between, velocity, spin, turn):
    """`ball_on_ball` and its derivatives; `turn` says how its three arguments change with the angle.

    The loss is that with what the contact stores.
    """
    contact = ball_on_ball(bearing, may_touch, between, velocity, spin)
    root = math.sqrt(max(contact.approach, SHALLOWEST))
    slopes = slopes_of(
        bearing, bearing.friction_coefficient, bearing.pair_coefficient, HERTZIAN, root, 0.0, 0.0, contact
    )
    slopes = Slopes(*slopes[:3], 0.0, *slopes[4:10], contact.normal_load)
    relative = add(velocity, cross(spin, contact.arm))
    still = (0.0, 0.0, 0.0)  # no axis, nothing that turns about it
    place = ContactMotion(
        offset=between,
        axis_distance=0.0,
        inverse_distance=0.0,
        ring_speed=0.0,
        raceway_velocity=still,
        spin=spin,
        relative=relative,
    )
    by = driven(contact, slopes, place.raceway_velocity)
    one = _apart(contact, slopes, place, (1.0, 0.0, 0.0))
    two = _apart(contact, slopes, place, (0.0, 1.0, 0.0))
    three = _apart(contact, slopes, place, (0.0, 0.0, 1.0))
    force_p = matrix_of(one.force, two.force, three.force)
    torque_p = matrix_of(one.torque, two.torque, three.torque)
    loss_p = (one.loss, two.loss, three.loss)
    push = add(turn[1], cross(turn[2], contact.arm))
    return contact, PairGradient(
        force_p=force_p,
        force_v=by.force_v,
        force_s=by.force_s,
        force_turn=add(times(force_p, turn[0]), times(by.force_v, push)),
        torque_p=torque_p,
        torque_v=by.torque_v,
        torque_s=by.torque_s,
        torque_turn=add(times(torque_p, turn[0]), times(by.torque_v, push)),
        loss_p=loss_p,
        loss_v=by.loss_v,
        loss_s=by.loss_s,
        loss_turn=dot(loss_p, turn[0]) + dot(by.loss_v, push),
    )
