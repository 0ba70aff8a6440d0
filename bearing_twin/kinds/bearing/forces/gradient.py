"""The derivatives of one ball-raceway contact by the ball's position, velocity and spin.

A contact's load is a function of the approach h, its rate, and the load coefficient C; its friction one of load and
slip. `contact_gradient` differentiates `raceway_contact` line by line: first what velocities do (u, the velocity of the
ball's surface against the raceway, is linear in velocity and spin), then what a displacement does.
"""

from typing import NamedTuple

from bearing_twin.compiled import inlined
from bearing_twin.contact.elastic import HERTZIAN
from bearing_twin.contact.elasticity import lane_root, looked_up
from bearing_twin.kinds.bearing.forces.along_groove import raceway_coefficient, slope_along
from bearing_twin.kinds.bearing.forces.equations import placed, raceway_contact
from bearing_twin.numerics.block_solve import combined, negative, plus
from bearing_twin.numerics.rotation import add, cross, dot, minus, root_and_inverse, scaled

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


class Slopes(NamedTuple):
    """What the directions of `contact_gradient` share: partial derivatives of load, friction factor and loss."""

    load_by_approach: float
    load_by_rate: float
    load_by_coefficient: float
    elastic_by_approach: float
    elastic_by_coefficient: float
    coefficient_by_radial: float
    curvature_by_radial: float
    resistance: float
    coefficient_over_speed: float
    inverse_square: float
    excess: float


class Driven(NamedTuple):
    """Derivatives of a contact by velocity (v) and spin (s), as in `Gradient`."""

    force_v: tuple
    force_s: tuple
    torque_v: tuple
    torque_s: tuple
    power_v: tuple
    power_s: tuple
    loss_v: tuple
    loss_s: tuple


class ContactMotion(NamedTuple):
    """Where a contact is and how it moves.

    The ball's centre against the ring's, its distance from the ring's axis and the inverse of that, the ring's speed, u
    and its parts.
    """

    offset: tuple
    axis_distance: float
    inverse_distance: float
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
def matrix_of(a, b, c):
    """The matrix with these columns."""
    return ((a[0], b[0], c[0]), (a[1], b[1], c[1]), (a[2], b[2], c[2]))


@inlined
def slopes_of(bearing, friction_coefficient, coefficient, power, root, by_radial, curvature_by_radial, contact):
    """Partial derivatives of the laws at one contact, c h^p with `root` = h^(p - 1) no closer to the onset."""
    loaded = 1.0 if contact.normal_load > 0.0 else 0.0
    touching = 1.0 if contact.approach > 0.0 else 0.0
    depth, rate = max(contact.approach, SHALLOWEST), contact.approach_rate
    inner = root if power == HERTZIAN else depth  # root over this is h^(p - 2)
    viscous, relaxation = 1.0 + bearing.damping * rate, bearing.relaxation_time
    load = viscous * depth * root + power * relaxation * root * rate  # over the coefficient
    bend = power * (power - 1.0) * relaxation * rate / inner
    slip = contact.slip
    square = dot(slip, slip) + bearing.friction_regularisation * bearing.friction_regularisation
    inverse_speed = root_and_inverse(square)[1]
    over_speed = friction_coefficient * inverse_speed
    return Slopes(
        load_by_approach=loaded * touching * coefficient * (power * viscous * root + bend),
        load_by_rate=loaded * touching * coefficient * (bearing.damping * depth * root + power * relaxation * root),
        load_by_coefficient=loaded * touching * load,
        elastic_by_approach=touching * power * coefficient * root,
        elastic_by_coefficient=touching * depth * root,
        coefficient_by_radial=by_radial,
        curvature_by_radial=curvature_by_radial,
        resistance=over_speed * contact.normal_load,
        coefficient_over_speed=over_speed,
        inverse_square=inverse_speed * inverse_speed,
        excess=contact.normal_load - touching * coefficient * depth * root,
    )


@inlined
def raceway_slopes(bearing, raceway, given, given_slope, contact, radial):
    """Partial derivatives of the laws at a contact with a raceway."""
    law = raceway.law
    groove = raceway.locus_radius + raceway.groove_radius * radial
    curvature = -0.5 * raceway.locus_radius / (groove * groove)
    coefficient = raceway_coefficient(raceway, given, radial)
    by_radial = given_slope * curvature if looked_up(law) else slope_along(raceway.terms, radial)
    root = lane_root(law, max(contact.approach, SHALLOWEST))
    return slopes_of(bearing, bearing.raceway_friction, coefficient, law.power, root, by_radial, curvature, contact)


@inlined
def displaced(contact, slopes, place, turn, approach, normal, arm, radial):
    """Derivative of a contact when the raceway's velocity, approach, normal, arm and n_radial change by these."""
    change = minus(cross(place.spin, arm), turn)
    rate = dot(change, contact.normal) + dot(place.relative, normal)
    slip = minus(change, add(scaled(rate, contact.normal), scaled(contact.approach_rate, normal)))
    coefficient = slopes.coefficient_by_radial * radial
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


class Shift(NamedTuple):
    """How a raceway's contact changes as the ball's centre moves: velocity of the raceway there, approach, normal, arm.

    `radial` and `axial` are changes of the normal's parts in the ring's meridian plane, `outwards` that of the distance
    from the ring's axis, `around` the angle [rad] by which that plane turns.
    """

    turn: tuple
    approach: float
    normal: tuple
    arm: tuple
    radial: float
    axial: float
    outwards: float
    around: float


@inlined
def shifted(bearing, raceway, contact, place, direction):
    """The change of where a contact is when the ball's centre moves in `direction` against the ring's."""
    offset, axis_distance, inverse_axis = place.offset, place.axis_distance, place.inverse_distance
    x, y = offset[0] * inverse_axis, offset[1] * inverse_axis
    outwards = x * direction[0] + y * direction[1]
    sideways = x * direction[1] - y * direction[0]
    out = axis_distance - raceway.locus_radius
    inverse = root_and_inverse(out * out + offset[2] * offset[2] + 1e-300)[1]
    radial, axial = out * inverse, offset[2] * inverse
    approach = radial * outwards + axial * direction[2]
    turned_radial = (outwards - radial * approach) * inverse
    turned_axial = (direction[2] - axial * approach) * inverse
    around = sideways * inverse_axis
    normal = (x * turned_radial - y * radial * around, y * turned_radial + x * radial * around, turned_axial)
    length = bearing.ball_radius - 0.5 * contact.approach
    arm = minus(scaled(length, normal), scaled(0.5 * approach, contact.normal))
    point = add(direction, arm)
    turn = (-place.ring_speed * point[1], place.ring_speed * point[0], 0.0)
    return Shift(turn, approach, normal, arm, turned_radial, turned_axial, outwards, around)


@inlined
def _along(bearing, raceway, contact, slopes, place, direction):
    """The change of a contact when the ball's centre moves in `direction` against the ring's."""
    by = shifted(bearing, raceway, contact, place, direction)
    return displaced(contact, slopes, place, by.turn, by.approach, by.normal, by.arm, by.radial)


@inlined
def _levered(rows, arm):
    """Rows that answer to the velocity u of the ball's surface, as rows that answer to its spin."""
    return (cross(arm, rows[0]), cross(arm, rows[1]), cross(arm, rows[2]))


@inlined
def driven(contact, slopes, raceway_velocity):
    """Derivatives of a contact by velocity and spin.

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
    torque_v = (
        minus(scaled(arm[1], rubbing[2]), scaled(arm[2], rubbing[1])),
        minus(scaled(arm[2], rubbing[0]), scaled(arm[0], rubbing[2])),
        minus(scaled(arm[0], rubbing[1]), scaled(arm[1], rubbing[0])),
    )
    power_v = combined(raceway_velocity, force_v)
    loss_v = add(
        add(scaled(dot(slip, slip), by_rate), scaled(2.0 * f, slip)),
        scaled(slopes.load_by_rate * contact.approach_rate + slopes.excess, n),
    )
    return Driven(
        force_v=force_v,
        force_s=_levered(force_v, arm),
        torque_v=torque_v,
        torque_s=_levered(torque_v, arm),
        power_v=power_v,
        power_s=cross(arm, power_v),
        loss_v=loss_v,
        loss_s=cross(arm, loss_v),
    )


@inlined
def contact_gradient(bearing, raceway, given, given_slope, centre, by_angle, ring_speed, position, velocity, spin):
    """The derivatives of `raceway_contact`; `by_angle` is how the ball's centre moves against the ring's per radian."""
    contact = raceway_contact(bearing, raceway, given, centre, ring_speed, position, velocity, spin)
    offset, axis_distance, inverse = placed(position, centre)
    radial = inverse * (offset[0] * contact.normal[0] + offset[1] * contact.normal[1])
    slopes = raceway_slopes(bearing, raceway, given, given_slope, contact, radial)
    point = add(offset, contact.arm)
    raceway_velocity = (-ring_speed * point[1], ring_speed * point[0], 0.0)
    relative = minus(add(velocity, cross(spin, contact.arm)), raceway_velocity)

    by = driven(contact, slopes, raceway_velocity)

    # What displacements do: along the radial and axial directions, and with the orbit angle.
    place = ContactMotion(
        offset=offset,
        axis_distance=axis_distance,
        inverse_distance=inverse,
        ring_speed=ring_speed,
        raceway_velocity=raceway_velocity,
        spin=spin,
        relative=relative,
    )
    one = _along(bearing, raceway, contact, slopes, place, (1.0, 0.0, 0.0))
    two = _along(bearing, raceway, contact, slopes, place, by_angle)
    three = _along(bearing, raceway, contact, slopes, place, (0.0, 0.0, 1.0))
    return contact, Gradient(
        force_p=matrix_of(one.force, two.force, three.force),
        force_v=by.force_v,
        force_s=by.force_s,
        torque_p=matrix_of(one.torque, two.torque, three.torque),
        torque_v=by.torque_v,
        torque_s=by.torque_s,
        power_p=(one.power, two.power, three.power),
        power_v=by.power_v,
        power_s=by.power_s,
        loss_p=(one.loss, two.loss, three.loss),
        loss_v=by.loss_v,
        loss_s=by.loss_s,
    )
