"""How the load of one contact and friction over its spot change with the motion of its ball and with the ring's speed.

In the spot's axes: a motion changes the slip along them, the spin, the semi-axes, the load N, with it the greatest
friction mu N, and the lever, and turns the axes. The means over the spot follow by their slopes. The load goes through
the ball's centre and the ring's axis: it turns neither.
"""

import math
from typing import NamedTuple

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces.along_groove import slope_along
from bearing_twin.kinds.bearing.forces.equations import raceway_contact
from bearing_twin.kinds.bearing.forces.gradient import (
    SHALLOWEST,
    ContactMotion,
    raceway_slopes,
    shifted,
)
from bearing_twin.kinds.bearing.forces.spot import along_axes
from bearing_twin.numerics.rotation import add, cross, dot, minus, scaled


class SpotMeans(NamedTuple):
    """The means over a spot, and how each changes with both slips, spin and both semi-axes."""

    along: float
    across: float
    moment: float
    by_along: tuple
    by_across: tuple
    by_moment: tuple


class _Response(NamedTuple):
    """How force along a spot's axes and against its normal, drilling torque and loss change."""

    major: float
    minor: float
    load: float
    drilling: float
    loss: float


class SpotChange(NamedTuple):
    """How what a contact does changes: force and torque on the ball, moment about the ring's axis, loss."""

    force: tuple
    torque: tuple
    turning: float
    loss: float


_STILL = (0.0, 0.0, 0.0)
UNCHANGED = SpotChange(_STILL, _STILL, 0.0, 0.0)


@inlined
def _by(slopes, slip_major, slip_minor, spin, semi_major, semi_minor):
    return (
        slopes[0] * slip_major
        + slopes[1] * slip_minor
        + slopes[2] * spin
        + slopes[3] * semi_major
        + slopes[4] * semi_minor
    )


@inlined
def _response(friction, spot, means, load, slip_major, slip_minor, spin, semi_major, semi_minor):
    """What changes of the load, of both slips, of the spin and of both semi-axes do; all loss is that of friction."""
    limit = friction * load
    motion = slip_major, slip_minor, spin, semi_major, semi_minor
    along, across, moment = _by(means.by_along, *motion), _by(means.by_across, *motion), _by(means.by_moment, *motion)
    lost = means.along * spot.slip_major + means.across * spot.slip_minor + means.moment * spot.spin_rate
    more = along * spot.slip_major + across * spot.slip_minor + moment * spot.spin_rate
    more += means.along * slip_major + means.across * slip_minor + means.moment * spin
    return _Response(
        major=-(limit * means.along + spot.limit * along),
        minor=-(limit * means.across + spot.limit * across),
        load=load,
        drilling=-(limit * means.moment + spot.limit * moment),
        loss=limit * lost + spot.limit * more,
    )


@inlined
def _reach(spot):
    """Distance [m] of the contact from the ring's axis."""
    return spot.axis_distance + spot.lever * spot.normal_radial


@inlined
def _with_axes(spot, by):
    """A response while the spot's axes and its place stay."""
    return SpotChange(
        force=along_axes(spot, by.major, by.minor, -by.load),
        torque=along_axes(spot, -spot.lever * by.minor, spot.lever * by.major, by.drilling),
        turning=_reach(spot) * by.minor + spot.normal_axial * by.drilling,
        loss=by.loss,
    )


@inlined
def _moved(bearing, raceway, friction, contact, spot, means, slopes, place, axes_by_radial, direction):
    """The change when the ball's centre moves in `direction` against the ring's.

    The meridian plane turns about the ring's axis, and the axes in it by `tilt`; vectors turn with them.
    """
    by = shifted(bearing, raceway, contact, place, direction)
    x, y = spot.minor
    radial, axial = spot.normal_radial, spot.normal_axial
    tilt, around = by.radial * axial - by.axial * radial, by.around
    lever = -0.5 * by.approach
    change = minus(cross(place.spin, by.arm), by.turn)
    rate = dot(change, contact.normal) + dot(place.relative, by.normal)
    coefficient = slopes.coefficient_by_radial * by.radial
    elastic = slopes.elastic_by_approach * by.approach + slopes.elastic_by_coefficient * coefficient
    load = slopes.load_by_approach * by.approach + slopes.load_by_rate * rate + slopes.load_by_coefficient * coefficient
    outwards = y * change[0] - x * change[1]
    closing, deep = contact.approach_rate, 0.5 * by.approach / max(contact.approach, SHALLOWEST)
    found = _response(
        friction,
        spot,
        means,
        load,
        axial * outwards - radial * change[2] - closing * tilt + around * axial * spot.slip_minor,
        x * change[0] + y * change[1] - around * (closing * radial + axial * spot.slip_major),
        dot(place.spin, by.normal) - place.ring_speed * by.axial,
        spot.semi_major * deep + axes_by_radial[0] * by.radial,
        spot.semi_minor * deep + axes_by_radial[1] * by.radial,
    )
    major, minor, drilling = -spot.limit * means.along, -spot.limit * means.across, -spot.limit * means.moment
    force, torque = (
        along_axes(spot, major, minor, -contact.normal_load),
        along_axes(spot, -spot.lever * minor, spot.lever * major, drilling),
    )
    still = _with_axes(spot, found)
    turned = along_axes(spot, -tilt * contact.normal_load, 0.0, -tilt * major)
    leaned = along_axes(spot, tilt * drilling - lever * minor, lever * major, tilt * spot.lever * minor)
    reach = by.outwards + lever * radial + spot.lever * by.radial
    return SpotChange(
        force=add(still.force, add(turned, (-around * force[1], around * force[0], 0.0))),
        torque=add(still.torque, add(leaned, (-around * torque[1], around * torque[0], 0.0))),
        turning=still.turning + reach * minor + by.axial * drilling,
        loss=still.loss + (load - elastic) * closing + slopes.excess * rate,
    )


@inlined
def _driven(friction, contact, spot, means, slopes):
    """Responses to the ball's velocity and spin, each by its three parts: as vectors of the ball's frame."""
    one = _response(friction, spot, means, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
    two = _response(friction, spot, means, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    three = _response(friction, spot, means, slopes.load_by_rate, 0.0, 0.0, 0.0, 0.0, 0.0)
    four = _response(friction, spot, means, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0)
    lever, closing = spot.lever, slopes.load_by_rate * contact.approach_rate + slopes.excess
    velocity = _Response(
        along_axes(spot, one.major, two.major, three.major),
        along_axes(spot, one.minor, two.minor, three.minor),
        scaled(slopes.load_by_rate, contact.normal),
        along_axes(spot, one.drilling, two.drilling, three.drilling),
        along_axes(spot, one.loss, two.loss, three.loss + closing),
    )
    spin = _Response(
        along_axes(spot, -lever * two.major, lever * one.major, four.major),
        along_axes(spot, -lever * two.minor, lever * one.minor, four.minor),
        _STILL,
        along_axes(spot, -lever * two.drilling, lever * one.drilling, four.drilling),
        along_axes(spot, -lever * two.loss, lever * one.loss, four.loss),
    )
    return velocity, spin


@inlined
def _part(by, axis):
    return _Response(by.major[axis], by.minor[axis], by.load[axis], by.drilling[axis], by.loss[axis])


class SpotGradient(NamedTuple):
    """Changes by each of a ball's nine numbers: three places, velocity, spin; and by the ring's speed.

    `turning` [N m] is the moment about the ring's axis itself, which the drive's power is to the speed.
    """

    changes: tuple
    by_speed: SpotChange
    turning: float


@inlined
def spot_gradient(
    bearing, raceway, friction, axes, given, given_slope, centre, by_angle, speed, position, velocity, spin, spot, means
):
    """How what a contact does changes; arguments as of `gradient.contact_gradient`, then those of its spot.

    `axes` are `along_groove.axes_along`; `by_angle` is empty where the ring is centred.
    """
    contact = raceway_contact(bearing, raceway, given, centre, speed, position, velocity, spin)
    slopes = raceway_slopes(bearing, raceway, given, given_slope, contact, spot.normal_radial)
    offset = minus(position, centre)
    point = add(offset, contact.arm)
    turn = (-speed * point[1], speed * point[0], 0.0)
    relative = minus(add(velocity, cross(spin, contact.arm)), turn)
    place = ContactMotion(
        offset=offset,
        axis_distance=spot.axis_distance,
        inverse_distance=1.0 / spot.axis_distance,
        ring_speed=speed,
        raceway_velocity=turn,
        spin=spin,
        relative=relative,
    )

    root, radial = math.sqrt(max(contact.approach, 0.0)), spot.normal_radial
    axes_by_radial = root * slope_along(axes[0], radial), root * slope_along(axes[1], radial)
    shared = bearing, raceway, friction, contact, spot, means, slopes, place, axes_by_radial
    by_velocity, by_spin = _driven(friction, contact, spot, means, slopes)
    by_turning = _response(friction, spot, means, 0.0, 0.0, -_reach(spot), -spot.normal_axial, 0.0, 0.0)
    changes = (
        _moved(*shared, (1.0, 0.0, 0.0)),
        _moved(*shared, by_angle) if len(by_angle) > 0 else UNCHANGED,
        _moved(*shared, (0.0, 0.0, 1.0)),
        _with_axes(spot, _part(by_velocity, 0)),
        _with_axes(spot, _part(by_velocity, 1)),
        _with_axes(spot, _part(by_velocity, 2)),
        _with_axes(spot, _part(by_spin, 0)),
        _with_axes(spot, _part(by_spin, 1)),
        _with_axes(spot, _part(by_spin, 2)),
    )
    turning = -spot.limit * (_reach(spot) * means.across + spot.normal_axial * means.moment)
    return SpotGradient(changes, _with_axes(spot, by_turning), turning)
