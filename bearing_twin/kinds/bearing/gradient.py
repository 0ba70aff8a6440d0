"""The derivatives of one ball-raceway contact by the ball's position, velocity and spin.

A contact's load is a function of the approach h, its rate, and the load coefficient C; its friction one of load and
slip. `contact_gradient` differentiates `raceway_contact` line by line: first what velocities do (u, the velocity of the
ball's surface against the raceway, is linear in velocity and spin), then what a displacement does.
"""

import math
from typing import NamedTuple

from bearing_twin.compiled import inlined
from bearing_twin.contact.elastic import HERTZIAN
from bearing_twin.contact.elasticity import in_lanes, lane_coefficient, lane_root
from bearing_twin.kinds.bearing.equations import ball_on_ball, raceway_contact
from bearing_twin.numerics.block_solve import combined, negative, plus, product, times
from bearing_twin.numerics.rotation import add, cross, dot, minus, scaled

SHALLOWEST = 1e-12  # m: the viscous part's slope, which grows as 1 / sqrt(h), is taken no closer to the onset
CURVATURE_STEP = 1e-5  # relative, of the difference that stands for dC/dQ


class Gradient(NamedTuple):
    """Derivatives of a contact by position (p), velocity (v) and spin (s): matrices for force and torque, else rows."""

    force_p: tuple
    force_v: tuple
    force_s: tuple
    torque_p: tuple
    torque_v: tuple
    torque_s: tuple
    power_p: tuple
    power_v: tuple
    power_s: tuple
    loss_p: tuple
    loss_v: tuple
    loss_s: tuple


class _Slopes(NamedTuple):
    """What the directions of `contact_gradient` share: partial derivatives of load, friction factor and loss."""

    load_by_approach: float
    load_by_rate: float
    load_by_coefficient: float
    elastic_by_approach: float
    elastic_by_coefficient: float
    curvature_by_radial: float
    coefficient_by_curvature: float
    resistance: float
    coefficient_over_speed: float
    inverse_square: float
    excess: float


class _Place(NamedTuple):
    """Where a contact is and how it moves: the ball's centre against the ring's, the ring's speed, u and its parts."""

    offset: tuple
    ring_speed: float
    raceway_velocity: tuple
    spin: tuple
    relative: tuple


class _Change(NamedTuple):
    """The derivative of a contact along one displacement."""

    force: tuple
    torque: tuple
    power: float
    loss: float


@inlined
def _outer(a, b):
    return (scaled(a[0], b), scaled(a[1], b), scaled(a[2], b))


@inlined
def _columns(a, b, c):
    """The matrix with these columns."""
    return ((a[0], b[0], c[0]), (a[1], b[1], c[1]), (a[2], b[2], c[2]))


@inlined
def _slopes(bearing, friction_coefficient, coefficient, power, root, by_curvature, by_radial, contact):
    """Partial derivatives of the laws at one contact, c h^p with `root` = h^(p - 1) no closer to the onset."""
    loaded = 1.0 if contact.normal_load > 0.0 else 0.0
    touching = 1.0 if contact.approach > 0.0 else 0.0
    depth, rate = max(contact.approach, SHALLOWEST), contact.approach_rate
    inner = root if power == HERTZIAN else depth  # root over this is h^(p - 2)
    viscous, relaxation = 1.0 + bearing.damping * rate, bearing.relaxation_time
    load = coefficient * (viscous * depth * root + power * relaxation * root * rate)
    bend = power * (power - 1.0) * relaxation * rate / inner
    slip = contact.slip
    square = dot(slip, slip) + bearing.friction_regularisation * bearing.friction_regularisation
    over_speed = friction_coefficient / math.sqrt(square)
    return _Slopes(
        load_by_approach=loaded * touching * coefficient * (power * viscous * root + bend),
        load_by_rate=loaded * touching * coefficient * (bearing.damping * depth * root + power * relaxation * root),
        load_by_coefficient=loaded * touching * load / coefficient,
        elastic_by_approach=touching * power * coefficient * root,
        elastic_by_coefficient=touching * depth * root,
        curvature_by_radial=by_radial,
        coefficient_by_curvature=by_curvature,
        resistance=over_speed * contact.normal_load,
        coefficient_over_speed=over_speed,
        inverse_square=1.0 / square,
        excess=contact.normal_load - touching * coefficient * depth * root,
    )


@inlined
def _raceway_slopes(bearing, raceway, given, given_slope, contact, radial):
    """Partial derivatives of the laws at a contact with a raceway."""
    small, large, law = contact.curvature_small, contact.curvature_large, raceway.law
    coefficient = lane_coefficient(law, small, large, given)
    further = lane_coefficient(law, small, large * (1.0 + CURVATURE_STEP), given)
    by_curvature = (further - coefficient) / (CURVATURE_STEP * large) if in_lanes(law) else given_slope
    root = lane_root(law, max(contact.approach, SHALLOWEST))
    groove = raceway.locus_radius + raceway.groove_radius * radial
    by_radial = -0.5 * raceway.locus_radius / (groove * groove)
    return _slopes(bearing, bearing.raceway_friction, coefficient, law.power, root, by_curvature, by_radial, contact)


@inlined
def _displaced(contact, slopes, place, turn, approach, normal, arm, radial):
    """Derivative of a contact when the raceway's velocity, approach, normal, arm and n_radial change by these."""
    change = minus(cross(place.spin, arm), turn)
    rate = dot(change, contact.normal) + dot(place.relative, normal)
    slip = minus(change, add(scaled(rate, contact.normal), scaled(contact.approach_rate, normal)))
    coefficient = slopes.coefficient_by_curvature * slopes.curvature_by_radial * radial
    load = slopes.load_by_approach * approach + slopes.load_by_rate * rate + slopes.load_by_coefficient * coefficient
    along = dot(contact.slip, slip)
    resistance = slopes.coefficient_over_speed * load - slopes.resistance * slopes.inverse_square * along
    rubbing = scaled(-1.0, add(scaled(resistance, contact.slip), scaled(slopes.resistance, slip)))
    force = minus(rubbing, add(scaled(load, contact.normal), scaled(contact.normal_load, normal)))
    torque = add(cross(arm, contact.friction), cross(contact.arm, rubbing))
    elastic = slopes.elastic_by_approach * approach + slopes.elastic_by_coefficient * coefficient
    loss = (
        resistance * dot(contact.slip, contact.slip)
        + 2.0 * slopes.resistance * along
        + (load - elastic) * contact.approach_rate
        + slopes.excess * rate
    )
    return _Change(force, torque, dot(force, place.raceway_velocity) + dot(contact.force, turn), loss)


@inlined
def _along(bearing, raceway, contact, slopes, place, direction):
    """The change of a contact when the ball's centre moves in `direction` against the ring's."""
    offset = place.offset
    axis_distance = math.sqrt(offset[0] * offset[0] + offset[1] * offset[1])
    x, y = offset[0] / axis_distance, offset[1] / axis_distance
    outwards = x * direction[0] + y * direction[1]
    sideways = x * direction[1] - y * direction[0]
    out = axis_distance - raceway.locus_radius
    distance = math.sqrt(out * out + offset[2] * offset[2] + 1e-300)
    radial, axial = out / distance, offset[2] / distance
    approach = radial * outwards + axial * direction[2]
    turned_radial = (outwards - radial * approach) / distance
    turned_axial = (direction[2] - axial * approach) / distance
    around = radial * sideways / axis_distance
    normal = (x * turned_radial - y * around, y * turned_radial + x * around, turned_axial)
    length = bearing.ball_radius - 0.5 * contact.approach
    arm = minus(scaled(length, normal), scaled(0.5 * approach, contact.normal))
    point = add(direction, arm)
    turn = (-place.ring_speed * point[1], place.ring_speed * point[0], 0.0)
    return _displaced(contact, slopes, place, turn, approach, normal, arm, turned_radial)


@inlined
def _driven(contact, slopes):
    """Derivatives of force, torque and loss by the velocity u, and what turns a spin into u.

    Slip answers to the part of u in the contact plane, the load to the part along the normal.
    """
    n, slip, f = contact.normal, contact.slip, slopes.resistance
    by_rate = minus(
        scaled(slopes.coefficient_over_speed * slopes.load_by_rate, n), scaled(f * slopes.inverse_square, slip)
    )
    plane = ((f, 0.0, 0.0), (0.0, f, 0.0), (0.0, 0.0, f))
    rubbing = plus(_outer(scaled(f, n), n), plus(_outer(scaled(-1.0, slip), by_rate), negative(plane)))
    force_v = plus(rubbing, _outer(scaled(-slopes.load_by_rate, n), n))
    arm = contact.arm
    lever = ((0.0, arm[2], -arm[1]), (-arm[2], 0.0, arm[0]), (arm[1], -arm[0], 0.0))
    torque_v = product(negative(lever), rubbing)
    loss_v = add(
        add(scaled(dot(slip, slip), by_rate), scaled(2.0 * f, slip)),
        scaled(slopes.load_by_rate * contact.approach_rate + slopes.excess, n),
    )
    return force_v, torque_v, loss_v, lever


@inlined
def contact_gradient(bearing, raceway, given, given_slope, centre, by_angle, ring_speed, position, velocity, spin):
    """The derivatives of `raceway_contact`; `by_angle` is how the ball's centre moves against the ring's per radian."""
    contact = raceway_contact(bearing, raceway, given, centre, ring_speed, position, velocity, spin)
    offset = minus(position, centre)
    radial = math.sqrt(contact.normal[0] * contact.normal[0] + contact.normal[1] * contact.normal[1])
    radial = math.copysign(radial, contact.normal[0])
    slopes = _raceway_slopes(bearing, raceway, given, given_slope, contact, radial)
    point = add(offset, contact.arm)
    raceway_velocity = (-ring_speed * point[1], ring_speed * point[0], 0.0)
    relative = minus(add(velocity, cross(spin, contact.arm)), raceway_velocity)

    force_v, torque_v, loss_v, lever = _driven(contact, slopes)
    power_v = combined(raceway_velocity, force_v)

    # What displacements do: along the radial and axial directions, and with the orbit angle.
    place = _Place(
        offset=offset, ring_speed=ring_speed, raceway_velocity=raceway_velocity, spin=spin, relative=relative
    )
    one = _along(bearing, raceway, contact, slopes, place, (1.0, 0.0, 0.0))
    two = _along(bearing, raceway, contact, slopes, place, by_angle)
    three = _along(bearing, raceway, contact, slopes, place, (0.0, 0.0, 1.0))
    return contact, Gradient(
        force_p=_columns(one.force, two.force, three.force),
        force_v=force_v,
        force_s=product(force_v, lever),
        torque_p=_columns(one.torque, two.torque, three.torque),
        torque_v=torque_v,
        torque_s=product(torque_v, lever),
        power_p=(one.power, two.power, three.power),
        power_v=power_v,
        power_s=combined(power_v, lever),
        loss_p=(one.loss, two.loss, three.loss),
        loss_v=loss_v,
        loss_s=combined(loss_v, lever),
    )


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
    return _displaced(contact, slopes, place, (0.0, 0.0, 0.0), approach, normal, scaled(0.5, direction), 0.0)


@inlined
def pair_gradient(bearing, may_touch, between, velocity, spin, turn):
    """`ball_on_ball` and its derivatives; `turn` says how its three arguments change with the angle.

    The loss is that with what the contact stores.
    """
    contact = ball_on_ball(bearing, may_touch, between, velocity, spin)
    root = math.sqrt(max(contact.approach, SHALLOWEST))
    slopes = _slopes(bearing, bearing.friction_coefficient, bearing.pair_coefficient, HERTZIAN, root, 0.0, 0.0, contact)
    slopes = _Slopes(*slopes[:3], 0.0, *slopes[4:10], contact.normal_load)
    relative = add(velocity, cross(spin, contact.arm))
    place = _Place(offset=between, ring_speed=0.0, raceway_velocity=(0.0, 0.0, 0.0), spin=spin, relative=relative)
    force_v, torque_v, loss_v, lever = _driven(contact, slopes)
    one = _apart(contact, slopes, place, (1.0, 0.0, 0.0))
    two = _apart(contact, slopes, place, (0.0, 1.0, 0.0))
    three = _apart(contact, slopes, place, (0.0, 0.0, 1.0))
    force_p = _columns(one.force, two.force, three.force)
    torque_p = _columns(one.torque, two.torque, three.torque)
    loss_p = (one.loss, two.loss, three.loss)
    push = add(turn[1], times(lever, turn[2]))
    return contact, PairGradient(
        force_p=force_p,
        force_v=force_v,
        force_s=product(force_v, lever),
        force_turn=add(times(force_p, turn[0]), times(force_v, push)),
        torque_p=torque_p,
        torque_v=torque_v,
        torque_s=product(torque_v, lever),
        torque_turn=add(times(torque_p, turn[0]), times(torque_v, push)),
        loss_p=loss_p,
        loss_v=loss_v,
        loss_s=combined(loss_v, lever),
        loss_turn=dot(loss_p, turn[0]) + dot(loss_v, push),
    )
