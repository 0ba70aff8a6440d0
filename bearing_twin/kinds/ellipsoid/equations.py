"""The equations of an ellipsoid on an elastic plane: paper 1, section 5, first example, for any three semi-axes.

    m dv/dt = F - m g e_z,   dL/dt = r x F + T e_z,   dq/dt = omega q / 2,   omega = R I^-1 R^T L

Fixed axes, z up, the plane is z = 0. L is the angular momentum about the centre, q the orientation. The lowest point of
the ellipsoid, its approach h and the curvatures P <= Q of the gap there are closed forms (`surfaces`).

The elastic contact is a spring with the energy U = (2/5) c(P, Q) h^(5/2) of paper 1, section 4. When the body turns,
the curvatures change and with them c: the load c h^(3/2) alone, applied at the lowest point, would make or lose energy
(a ten-thousandth a bounce for a spinning ellipsoid). The derivative of U by the orientation is a moment; it puts the
load's point of application beside the lowest point, by 0.4 h grad(ln c), a small part of the contact's size. All forces
act there, for both bodies at the height of the interface that their compliances give.

Breaks: where the half-space does (validity flags), at the b/a where the law does, and in true rolling resistance and
sticking, which this friction does not know (it creeps).
"""

import math
from typing import NamedTuple

from bearing_twin.compiled import kernel
from bearing_twin.contact.damping import held_load, steady_held_load
from bearing_twin.contact.differential import Shape
from bearing_twin.contact.elastic import elastic
from bearing_twin.contact.elasticity import (
    Elasticity,
    carries,
    coefficient_at,
    follows,
    log_slope,
    state_begun,
    state_finished,
    state_rates,
)
from bearing_twin.contact.ellipse import ellipse
from bearing_twin.contact.friction import friction_of
from bearing_twin.numerics.rotation import cross, dot, quaternion_product, rows_of_state, scaled
from bearing_twin.shapes.surfaces import ellipsoid_on_plane, ellipsoid_reach, ellipsoid_slopes

POSITION, QUATERNION, VELOCITY, MOMENTUM, VISCOUS, RUBBED, SHAPE = 0, 3, 7, 10, 13, 14, 15
COLUMNS = 18
"""Of the state: where its parts begin; VISCOUS and RUBBED are dissipated energies [J], SHAPE carries c, K and E."""


class Ellipsoid(NamedTuple):
    """The numbers of the equations; SI. `sink` is the body's share of the compliance, `rubbing` the friction's number.

    Of the viscous terms (see contact/damping.py) at most one is above zero; `damping_ratio` belongs to a restitution
    that holds at every speed.
    """

    semi_axes: tuple[float, float, float]
    mass: float
    inertia: tuple[float, float, float]
    gravity: float
    sink: float
    law: Elasticity
    damping: float
    relaxation_time: float
    damping_ratio: float
    viscosity: float
    friction: float
    regularisation: float
    rubbing: int
    over_spot: bool


class Pose(NamedTuple):
    """Rows of the rotation to fixed axes, downward direction in the body's axes, angular velocity in both."""

    x: tuple[float, float, float]
    y: tuple[float, float, float]
    down: tuple[float, float, float]
    spin: tuple[float, float, float]
    spin_body: tuple[float, float, float]


class PlaneTouch(NamedTuple):
    """The contact of one state: forces on the body in fixed axes, about its centre with the arm `arm`.

    `approach_rate` [m/s] is that of the point of application, `slip` its velocity along the plane, `effective_mass`
    [kg] what a blow there moves.
    """

    approach: float
    approach_rate: float
    normal_load: float
    elastic_load: float
    elastic_energy: float
    friction_x: float
    friction_y: float
    drilling_torque: float
    slip_x: float
    slip_y: float
    arm: tuple[float, float, float]
    coefficient: float
    effective_mass: float
    curvature_small: float
    curvature_large: float
    major_axis: tuple[float, float, float]
    ratio_rate: float


@kernel
def pose_of(body, state):
    """Orientation and angular velocity of a state; the quaternion is taken at unit length."""
    first, second, up = rows_of_state(state, QUATERNION)
    down = scaled(-1.0, up)
    spin_body = (
        (first[0] * state[10] + second[0] * state[11] - down[0] * state[12]) / body.inertia[0],
        (first[1] * state[10] + second[1] * state[11] - down[1] * state[12]) / body.inertia[1],
        (first[2] * state[10] + second[2] * state[11] - down[2] * state[12]) / body.inertia[2],
    )
    spin = (dot(first, spin_body), dot(second, spin_body), -dot(down, spin_body))
    return Pose(first, second, down, spin, spin_body)


@kernel
def to_fixed(pose, vector):
    """A vector of the body's axes in fixed axes."""
    return (dot(pose.x, vector), dot(pose.y, vector), -dot(pose.down, vector))


@kernel
def carried_shape(state):
    """The states of the contact's shape; zeros where the law carries none."""
    return Shape(state[15], state[16], state[17])


@kernel
def pulling_load(body, spring, effective_mass, approach, approach_rate):
    """Normal load [N] with the viscous term that the body has, below zero where it would pull; of a pressed contact."""
    viscosity, power = body.viscosity, body.law.power
    if body.damping_ratio > 0.0:
        viscosity = body.damping_ratio * math.sqrt(2.0 * (power + 1.0) * effective_mass * spring.coefficient)
    if viscosity > 0.0:
        return steady_held_load(spring.load, approach, approach_rate, viscosity, power)
    return held_load(spring.load, spring.stiffness, approach_rate, body.damping, body.relaxation_time)


@kernel
def viscous_load(body, spring, effective_mass, approach, approach_rate):
    """The same, zero where it would pull; `spring` is the elastic answer."""
    return max(pulling_load(body, spring, effective_mass, approach, approach_rate), 0.0) if approach > 0.0 else 0.0


@kernel
def friction_along(body, low, pose, load, slip_x, slip_y):
    """Friction on the body along fixed x and y [N], and its drilling torque [N m] about z."""
    x, y, semi_major, semi_minor = 1.0, 0.0, 0.0, 0.0
    if body.over_spot:
        spot = ellipse(low.curvature_small, low.curvature_large, body.law.modulus, load)
        semi_major, semi_minor = spot.semi_major, spot.semi_minor
        x, y, _ = to_fixed(pose, low.major_axis)
    found = friction_of(
        body.rubbing, load, semi_major, semi_minor, x * slip_x + y * slip_y, x * slip_y - y * slip_x, pose.spin[2],
        body.friction, body.regularisation,
    )  # fmt: skip
    return x * found.force_major - y * found.force_minor, y * found.force_major + x * found.force_minor, found.torque


@kernel
def touch_of(body, state, pose):
    """The contact of a state, loaded or not."""
    low = ellipsoid_on_plane(body.semi_axes, pose.down)
    approach = low.reach - state[2]
    c = coefficient_at(body.law, low.curvature_small, low.curvature_large, carried_shape(state))
    slope = log_slope(body.law, low, carried_shape(state), c)
    size_slope, shape_slopes = ellipsoid_slopes(body.semi_axes, pose.down, low.reach, low.point)
    turning = cross(pose.down, pose.spin_body)  # rate of the downward direction in the body's axes
    depth = max(approach, 0.0)
    aside = 1.0 / (body.law.power + 1.0) * depth if follows(body.law) else 0.0  # energy over load
    point = (
        low.point[0] + aside * (size_slope[0] + slope * shape_slopes[0]),
        low.point[1] + aside * (size_slope[1] + slope * shape_slopes[1]),
        low.point[2] + aside * (size_slope[2] + slope * shape_slopes[2]),
    )
    across = to_fixed(pose, point)
    arm = (across[0], across[1], -low.reach + body.sink * depth)
    moving = cross(pose.spin, arm)
    lever = cross(point, (-pose.down[0], -pose.down[1], -pose.down[2]))
    mobility = 1.0 / body.mass
    for i in range(3):
        mobility += lever[i] * lever[i] / body.inertia[i]
    rate = -(state[9] + moving[2])
    spring = elastic(c, body.law.power, approach)
    load = 0.0
    if approach > 0.0:
        load = viscous_load(body, spring, 1.0 / mobility, approach, rate)
    slip_x, slip_y = state[7] + moving[0], state[8] + moving[1]
    friction_x, friction_y, torque = 0.0, 0.0, 0.0
    if load > 0.0 and body.friction > 0.0:
        friction_x, friction_y, torque = friction_along(body, low, pose, load, slip_x, slip_y)
    ratio_rate = 0.0
    if low.shape_excess > 1e-12:
        ratio_rate = -2.0 * low.curvature_small / low.curvature_large * dot(shape_slopes, turning) / low.shape_excess
    return PlaneTouch(
        approach, rate, load, spring.load, spring.energy, friction_x, friction_y, torque, slip_x, slip_y, arm,
        c, 1.0 / mobility, low.curvature_small, low.curvature_large, to_fixed(pose, low.major_axis), ratio_rate,
    )  # fmt: skip


@kernel
def gap_of(body, state):
    """Approach [m] and its rate [m/s] of the lowest point."""
    pose = pose_of(body, state)
    reach, point = ellipsoid_reach(body.semi_axes, pose.down)
    return reach - state[2], dot(point, cross(pose.down, pose.spin_body)) - state[9]


@kernel
def ellipsoid_rates(body, state, loaded, out):
    """Time derivative of the state; without `loaded` the plane is not there.

    In flight the stages of a long step would reach below the plane although the step does not.
    """
    pose = pose_of(body, state)
    out[0], out[1], out[2] = state[7], state[8], state[9]
    turn = quaternion_product((pose.spin[0], pose.spin[1], pose.spin[2], 0.0), (state[3], state[4], state[5], state[6]))
    for i in range(4):
        out[3 + i] = 0.5 * turn[i]
    for i in range(7, COLUMNS):
        out[i] = 0.0
    out[9] = -body.gravity
    reach, _ = ellipsoid_reach(body.semi_axes, pose.down)
    if not loaded or reach <= state[2]:
        return
    touch = touch_of(body, state, pose)
    force = (touch.friction_x, touch.friction_y, touch.normal_load)
    moment = cross(touch.arm, force)
    for i in range(3):
        out[7 + i] += force[i] / body.mass
        out[10 + i] = moment[i]
    out[12] += touch.drilling_torque
    out[13] = (touch.normal_load - touch.elastic_load) * touch.approach_rate
    out[14] = -(
        touch.friction_x * touch.slip_x + touch.friction_y * touch.slip_y + touch.drilling_torque * pose.spin[2]
    )
    shape = state_rates(body.law, carried_shape(state), touch.ratio_rate)
    out[15], out[16], out[17] = shape.parameter, shape.first_kind, shape.second_kind


@kernel
def begin_shape(body, state):
    """Solves the carried states afresh: at a new contact."""
    low = ellipsoid_on_plane(body.semi_axes, pose_of(body, state).down)
    state[15], state[16], state[17] = state_begun(body.law, low.curvature_small, low.curvature_large)


@kernel
def finish_shape(body, state):
    """What ends a step in contact: the carried states put right, if the law does so."""
    if carries(body.law):
        low = ellipsoid_on_plane(body.semi_axes, pose_of(body, state).down)
        ratio = low.curvature_small / low.curvature_large
        state[15], state[16], state[17] = state_finished(body.law, carried_shape(state), ratio)
