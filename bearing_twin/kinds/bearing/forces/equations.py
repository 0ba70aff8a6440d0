"""The ball bearing of paper 1, section 5: balls between two toroidal raceways, one turning and one at rest.

Frames. `bearing_link` has its origin at the outer ring's centre and z along the axis. The motion of each ball is
written in the frame that turns with that ball around the axis, with unit vectors (radial, tangential, axial): there
steady rolling is an equilibrium, and only the orbit angle grows.

Per ball: position (axis distance, orbit angle, height), velocity, and angular velocity, nine numbers, followed by
three integrals kept for the energy balance. The orientation of a homogeneous ball does not act back on its motion;
it is carried along by the steppers (`rotation.turned`).

Lanes. `raceway_rates` evaluates LANES balls side by side, laid out as `layout` says. The functions it is made of are
the readable ones below.

Signs. A contact's `normal` points from the ball's centre to the raceway, so the load on the ball is
`-normal_load * normal`. `slip` is the velocity of the ball's surface relative to the raceway.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from bearing_twin.compiled import inlined, kernel, plain
from bearing_twin.contact.damping import damped_load
from bearing_twin.contact.elastic import HERTZIAN, elastic
from bearing_twin.contact.elasticity import Elasticity, carries, lane_elastic, lane_given, looked_up
from bearing_twin.contact.friction import friction_factor
from bearing_twin.kinds.bearing.forces.along_groove import raceway_coefficient, terms_along
from bearing_twin.kinds.bearing.forces.carried import carried_coefficient, gap_at
from bearing_twin.kinds.bearing.forces.layout import (
    AXIAL_PUSH,
    AXIS_DISTANCE,
    BORDER_PUSH,
    CARRIED_INNER,
    CARRIED_OUTER,
    DISSIPATED,
    DRIVE_WORK,
    GIVEN_INNER,
    GIVEN_OUTER,
    GROSS_WORK,
    HEIGHT,
    ORBIT_ANGLE,
    RING_SPEED,
    SPIN,
    VELOCITY,
)
from bearing_twin.kinds.bearing.forces.ring_seat import from_ring, ring_in_lane, seat_of, seen_from
from bearing_twin.numerics.block_solve import combined
from bearing_twin.numerics.lanes import LANE_RATES, LANES, get, get_vector, put, put_vector
from bearing_twin.numerics.rotation import about_z, add, cosine_sine, cross, dot, minus, root_and_inverse, scaled
from bearing_twin.shapes.surfaces import ball_in_groove


class Raceway(NamedTuple):
    """A toroidal groove and the elastic law of its contacts with the balls, with its `terms` (`along_groove`)."""

    locus_radius: float
    groove_radius: float
    law: Elasticity
    terms: tuple[float, ...]


class Bearing(NamedTuple):
    """Everything the equations of motion need, as numbers (SI).

    `friction_coefficient` is that of balls among themselves, `raceway_friction` that of a raceway at the contact
    point; it is 0 where `spot`, empty else, says how friction acts over the spot: its coefficient, its model's
    number, whether that model is evaluated in lanes (see `spot`), and inner and outer semi-axes
    (`along_groove.axes_along`). `offset` is the place of the inner ring's centre; `ring` is empty where its axis
    stays z and it only spins, else its motion (`ring_seat.RingMotion`, or `LevelMotion` where it does not tilt).
    `pockets`, empty else, are those of a cage that balls bump into (`cage.Pockets`).
    """

    balls: int
    ball_radius: float
    ball_mass: float
    ball_inertia: float
    inner: Raceway
    outer: Raceway
    offset: tuple[float, float, float]
    gravity: tuple[float, float, float]
    damping: float
    relaxation_time: float
    friction_coefficient: float
    friction_regularisation: float
    pair_coefficient: float
    raceway_friction: float
    spot: tuple
    ring: tuple
    pockets: tuple


class RingDrive(NamedTuple):
    """Prescribed turning of the inner ring: at time t [s] it has speed + acceleration t."""

    angle: float
    speed: float
    acceleration: float


class RacewayContact(NamedTuple):
    """One ball-raceway contact in the ball's frame; `force` is on the ball, `arm` from its centre to the contact.

    `drilling` [N m] is the friction torque on the ball about `normal`: zero for friction at a point. `axial_moment`
    [N m] is that of `force` about the ring's axis: times the ring's speed it is `drive_power`.
    """

    approach: float
    approach_rate: float
    normal_load: float
    energy: float
    curvature_small: float
    curvature_large: float
    normal: tuple[float, float, float]
    arm: tuple[float, float, float]
    slip: tuple[float, float, float]
    spin_rate: float
    friction: tuple[float, float, float]
    drilling: float
    force: tuple[float, float, float]
    torque: tuple[float, float, float]
    drive_power: float
    axial_moment: float
    dissipation: float


class NeighbourContact(NamedTuple):
    """Contact of a ball with the next ahead, loads on the ball in its own frame; balls that are apart have none.

    `normal` points from the ball's centre to the other's, `arm` from its centre to the contact; on the other ball the
    force is the opposite, the torque the same. Friction acts at a point, so there is no drilling. `energy` is the
    ball's half, `dissipation` and `storing`, the power that goes into elastic energy [W], are those of both.
    """

    approach: float
    approach_rate: float
    normal_load: float
    energy: float
    normal: tuple[float, float, float]
    arm: tuple[float, float, float]
    slip: tuple[float, float, float]
    friction: tuple[float, float, float]
    force: tuple[float, float, float]
    torque: tuple[float, float, float]
    dissipation: float
    storing: float


ON_AXIS = ()  # the centre of a ring that stays in the bearing's


@inlined
def placed(position, centre):
    """The ball's centre against the ring's [m], its distance from the ring's axis, and the inverse of that.

    Of a ring whose centre is ON_AXIS no root is taken: in the ball's own frame the ball has no place across.
    """
    if len(centre) == 0:
        return position, position[0], 1.0 / position[0]
    offset = minus(position, centre)
    distance, inverse = root_and_inverse(offset[0] * offset[0] + offset[1] * offset[1])
    return offset, distance, inverse


@inlined
def raceway_contact(bearing, raceway, given, centre, ring_speed, position, velocity, spin):
    """Contact of a ball with a raceway whose ring has its centre at `centre` and turns at `ring_speed` about z.

    All vectors in the ball's frame, positions from the bearing's centre. `given` is the load coefficient
    of a law that is looked up (`given_coefficient`). The forces act at one point, half the approach
    inside the ball's surface, so that what one body loses the other gains. A gap gives zero loads.
    """
    # Where: the meridian plane of the ring through the ball's centre.
    offset, axis_distance, inverse = placed(position, centre)
    geometry = ball_in_groove(
        axis_distance, offset[2], bearing.ball_radius, raceway.locus_radius, raceway.groove_radius
    )
    approach = geometry.approach
    in_plane = geometry.normal_radial * inverse
    normal = (in_plane * offset[0], in_plane * offset[1], geometry.normal_axial)
    arm = scaled(bearing.ball_radius - 0.5 * approach, normal)

    # How fast: the ball's surface against the raceway.
    point = add(offset, arm)
    raceway_velocity = (-ring_speed * point[1], ring_speed * point[0], 0.0)
    relative = minus(add(velocity, cross(spin, arm)), raceway_velocity)
    approach_rate = dot(relative, normal)
    slip = minus(relative, scaled(approach_rate, normal))
    spin_rate = dot(spin, normal) - ring_speed * normal[2]

    # How hard: elastic law, viscous term, friction.
    spring = lane_elastic(raceway.law, raceway_coefficient(raceway, given, geometry.normal_radial), approach)
    normal_load = damped_load(spring.load, spring.stiffness, approach_rate, bearing.damping, bearing.relaxation_time)
    push = scaled(-normal_load, normal)
    if len(bearing.spot) > 0:  # all friction is over the spot, and found there
        friction = torque = (0.0, 0.0, 0.0)
        force, rubbed = push, 0.0
    else:
        resistance = friction_factor(
            normal_load, slip[0], slip[1], slip[2], bearing.raceway_friction, bearing.friction_regularisation
        )
        friction = scaled(-resistance, slip)
        torque = cross(arm, friction)
        force, rubbed = add(push, friction), resistance * dot(slip, slip)
    return RacewayContact(
        approach=approach,
        approach_rate=approach_rate,
        normal_load=normal_load,
        energy=spring.energy,
        curvature_small=geometry.curvature_small,
        curvature_large=geometry.curvature_large,
        normal=normal,
        arm=arm,
        slip=slip,
        spin_rate=spin_rate,
        friction=friction,
        drilling=0.0,
        force=force,
        torque=torque,
        drive_power=dot(force, raceway_velocity),
        axial_moment=point[0] * force[1] - point[1] * force[0],
        dissipation=rubbed + (normal_load - spring.load) * approach_rate,
    )


@inlined
def brought_back(seat, contact):
    """A contact in the axes of a ring at this `ring_seat.RingSeat`, in those of the ball's frame."""
    if len(seat) == 2:
        return contact
    axes = seat.axes
    return RacewayContact(
        approach=contact.approach,
        approach_rate=contact.approach_rate,
        normal_load=contact.normal_load,
        energy=contact.energy,
        curvature_small=contact.curvature_small,
        curvature_large=contact.curvature_large,
        normal=combined(contact.normal, axes),
        arm=combined(contact.arm, axes),
        slip=combined(contact.slip, axes),
        spin_rate=contact.spin_rate,
        friction=combined(contact.friction, axes),
        drilling=contact.drilling,
        force=combined(contact.force, axes),
        torque=combined(contact.torque, axes),
        drive_power=contact.drive_power,
        axial_moment=contact.axial_moment,
        dissipation=contact.dissipation,
    )


@inlined
def ring_contact(ring, bearing, given, place, cosine, sine, ring_speed, position, velocity, spin):
    """`raceway_contact` of a ball, at the orbit angle of that cosine and sine, with the inner ring at `place`.

    `ring` is the bearing's; the force is on the ball, and `drive_power` that of the ring's spin alone.
    """
    if len(ring) == 0:
        centre = about_z(cosine, -sine, place)
        return raceway_contact(bearing, bearing.inner, given, centre, ring_speed, position, velocity, spin)
    seat = seat_of(ring, place, cosine, sine)
    offset, relative, against = seen_from(seat, position, velocity, spin)
    return brought_back(
        seat,
        raceway_contact(bearing, bearing.inner, given, (0.0, 0.0, 0.0), ring_speed, offset, relative, against),
    )


@inlined
def given_coefficient(bearing, raceway, offset):
    """What `raceway_contact` is given for a ball at `offset` from the ring's centre, in its axes: 0 if nothing."""
    given = 0.0
    if looked_up(raceway.law):
        geometry = gap_at(bearing, raceway, offset)
        given = lane_given(raceway.law, geometry.curvature_small, geometry.curvature_large, geometry.approach)
    return given


@inlined
def ball_position(state, k):
    """Centre of ball k in its own frame [m]."""
    return (state[k, AXIS_DISTANCE], 0.0, state[k, HEIGHT])


@inlined
def lane_position(lanes, k):
    """Centre of lane k's ball in its own frame [m]."""
    return (get(lanes, AXIS_DISTANCE, k), 0.0, get(lanes, HEIGHT, k))


@inlined
def ball_vector(state, k, column):
    """Three consecutive columns of ball k as a vector: VELOCITY [m/s] or SPIN [rad/s]."""
    return (state[k, column], state[k, column + 1], state[k, column + 2])


@kernel
def single_contact(bearing, raceway, centre, ring_speed, position, velocity, spin):
    """One contact by itself, whatever the law: `raceway_contact` with its coefficient looked up."""
    given = given_coefficient(bearing, raceway, minus(position, centre))
    return raceway_contact(bearing, raceway, given, centre, ring_speed, position, velocity, spin)


@inlined
def ball_on_ball(bearing, may_touch, between, velocity, spin):
    """Contact of a ball with another, sphere on sphere with the raceways' damping and friction; see `NeighbourContact`.

    In the ball's frame: `between` from its centre to the other's, `velocity` [m/s] against the other's centre, `spin`
    [rad/s] the sum of both. Without a branch, for lanes.
    """
    distance = math.sqrt(dot(between, between) + 1e-300)
    approach = 2.0 * bearing.ball_radius - distance if may_touch else -bearing.ball_radius
    normal = scaled(1.0 / distance, between)
    arm = scaled(0.5, between)
    relative = add(velocity, cross(spin, arm))
    approach_rate = dot(relative, normal)
    slip = minus(relative, scaled(approach_rate, normal))
    spring = elastic(bearing.pair_coefficient, HERTZIAN, approach)
    normal_load = damped_load(spring.load, spring.stiffness, approach_rate, bearing.damping, bearing.relaxation_time)
    resistance = friction_factor(
        normal_load, slip[0], slip[1], slip[2], bearing.friction_coefficient, bearing.friction_regularisation
    )
    friction = scaled(-resistance, slip)
    return NeighbourContact(
        approach=approach,
        approach_rate=approach_rate,
        normal_load=normal_load,
        energy=0.5 * spring.energy,
        normal=normal,
        arm=arm,
        slip=slip,
        friction=friction,
        force=add(scaled(-normal_load, normal), friction),
        torque=cross(arm, friction),
        dissipation=resistance * dot(slip, slip) + (normal_load - spring.load) * approach_rate,
        storing=spring.load * approach_rate,
    )


@inlined
def _put_push(ring, place, cosine, sine, position, contact, lanes, k):
    """Writes what a ball does to a ring that may move: force, and moment about its centre where it may tilt.

    In `bearing_link`.
    """
    if len(ring) > 0:
        put_vector(lanes, BORDER_PUSH, k, about_z(cosine, sine, scaled(-1.0, contact.force)))
    if len(ring) > 1:
        offset = from_ring(ring, place, cosine, sine, position)
        moment = about_z(cosine, sine, add(cross(offset, contact.force), contact.torque))
        put(lanes, BORDER_PUSH + 3, k, -moment[0])
        put(lanes, BORDER_PUSH + 4, k, -moment[1])


@inlined
def put_rates(bearing, gravity, position, velocity, spin, inner, outer, lanes, k):
    """Writes a ball's rates from its two contacts with the raceways; `gravity` [m/s^2] in its frame."""
    inverse_mass, inverse_inertia = 1.0 / bearing.ball_mass, 1.0 / bearing.ball_inertia
    force = add(inner.force, outer.force)
    torque = add(inner.torque, outer.torque)
    orbit_rate = velocity[1] * (1.0 / position[0])
    acceleration = (
        force[0] * inverse_mass + gravity[0] + orbit_rate * velocity[1],
        force[1] * inverse_mass + gravity[1] - orbit_rate * velocity[0],
        force[2] * inverse_mass + gravity[2],
    )
    angular_acceleration = (
        torque[0] * inverse_inertia + orbit_rate * spin[1],
        torque[1] * inverse_inertia - orbit_rate * spin[0],
        torque[2] * inverse_inertia,
    )
    put(lanes, LANE_RATES + AXIS_DISTANCE, k, velocity[0])
    put(lanes, LANE_RATES + ORBIT_ANGLE, k, orbit_rate)
    put(lanes, LANE_RATES + HEIGHT, k, velocity[2])
    put_vector(lanes, LANE_RATES + VELOCITY, k, acceleration)
    put_vector(lanes, LANE_RATES + SPIN, k, angular_acceleration)
    put(lanes, LANE_RATES + DRIVE_WORK, k, inner.drive_power)
    put(lanes, LANE_RATES + DISSIPATED, k, inner.dissipation + outer.dissipation)
    put(lanes, LANE_RATES + GROSS_WORK, k, abs(inner.drive_power))


@inlined
def put_ball_rates(ring, bearing, place, cosine, sine, position, velocity, spin, inner, outer, lanes, k):
    """`put_rates`, and what the ball does to the ring at `place`, in motion `ring`."""
    put_rates(bearing, about_z(cosine, -sine, bearing.gravity), position, velocity, spin, inner, outer, lanes, k)
    put(lanes, AXIAL_PUSH, k, -inner.axial_moment)
    _put_push(ring, place, cosine, sine, position, inner, lanes, k)


@inlined
def rates_of_raceways(bearing, lanes):
    """`raceway_rates`, put into its caller: to hand over a bearing, number by number, costs as much as a contact."""
    for k in range(LANES):
        cosine, sine = cosine_sine(get(lanes, ORBIT_ANGLE, k))
        inner_speed = get(lanes, RING_SPEED, k)
        position = lane_position(lanes, k)
        velocity, spin = get_vector(lanes, VELOCITY, k), get_vector(lanes, SPIN, k)
        place, ring = ring_in_lane(bearing.ring, bearing.offset, lanes, k)
        given = get(lanes, GIVEN_INNER, k)
        inner = ring_contact(ring, bearing, given, place, cosine, sine, inner_speed, position, velocity, spin)
        given = get(lanes, GIVEN_OUTER, k)
        outer = raceway_contact(bearing, bearing.outer, given, ON_AXIS, 0.0, position, velocity, spin)
        put_ball_rates(ring, bearing, place, cosine, sine, position, velocity, spin, inner, outer, lanes, k)


@kernel
def raceway_rates(bearing, lanes):
    """Newton's and Euler's equations of LANES balls side by side, neighbours apart: d(state)/dt into the rates' rows.

    In the frame turning with the ball at `orbit_rate` about z, velocity and angular velocity gain the terms
    -orbit_rate z x (.), which hold the centrifugal, Coriolis and gyroscopic effects.
    """
    rates_of_raceways(bearing, lanes)


@kernel
def give_coefficients(bearing, lanes):
    """Looks up the load coefficients of a law that wants it; both raceways have the same."""
    if not looked_up(bearing.inner.law):
        return
    for k in range(LANES):
        cosine, sine = cosine_sine(get(lanes, ORBIT_ANGLE, k))
        position = lane_position(lanes, k)
        place, ring = ring_in_lane(bearing.ring, bearing.offset, lanes, k)
        offset = from_ring(ring, place, cosine, sine, position)
        if carries(bearing.inner.law):
            inner, _ = carried_coefficient(bearing, bearing.inner, offset, lanes, CARRIED_INNER, k)
            outer, _ = carried_coefficient(bearing, bearing.outer, position, lanes, CARRIED_OUTER, k)
        else:
            inner = given_coefficient(bearing, bearing.inner, offset)
            outer = given_coefficient(bearing, bearing.outer, position)
        put(lanes, GIVEN_INNER, k, inner)
        put(lanes, GIVEN_OUTER, k, outer)


@plain
@kernel
def inner_approach(bearing, radius, angle, height):
    """Approach [m] at the inner raceway of a ball `radius` [m] from the axis, at that `angle` [rad], `height` [m]."""
    position = (radius, 0.0, height)
    offset = from_ring(bearing.ring, bearing.offset, math.cos(angle), math.sin(angle), position)
    across = math.sqrt(offset[0] ** 2 + offset[1] ** 2)
    inner = bearing.inner
    return ball_in_groove(across, offset[2], bearing.ball_radius, inner.locus_radius, inner.groove_radius).approach


@plain
@kernel
def outer_approach(bearing, radius, height):
    """Approach [m] at the outer raceway of a ball `radius` [m] from the axis, at a `height` [m]."""
    outer = bearing.outer
    return ball_in_groove(radius, height, bearing.ball_radius, outer.locus_radius, outer.groove_radius).approach


@plain
@kernel
def approaches(bearing, motion):
    """Approaches [m] of a ball at the inner and at the outer raceway; `motion` starts with its position."""
    radius, height = motion[AXIS_DISTANCE], motion[HEIGHT]
    return inner_approach(bearing, radius, motion[ORBIT_ANGLE], height), outer_approach(bearing, radius, height)


def raceway_of(geometry, conformity, side, law: Callable) -> Raceway:
    """The groove of the inner (side = -1) or outer (side = +1) ring, its centre circle placed by the clearance.

    With the rings centred, each raceway is a quarter of the diametral clearance away from a ball on the pitch circle.
    `law(small, large)` gives the `Elasticity` from the curvatures [1/m] of the gap there.
    """
    ball_radius = 0.5 * geometry.ball_diameter
    groove_radius = conformity * geometry.ball_diameter
    bottom = 0.5 * geometry.pitch_diameter + side * (ball_radius + 0.25 * geometry.radial_clearance)
    locus_radius = bottom - side * groove_radius
    still = ball_in_groove(0.5 * geometry.pitch_diameter, 0.0, ball_radius, locus_radius, groove_radius)
    found = law(still.curvature_small, still.curvature_large)
    terms = terms_along(found, ball_radius, locus_radius, groove_radius, side)
    return Raceway(locus_radius, groove_radius, found, terms)
