"""A cage whose balls stand in pockets: contact of each ball with its pocket, in lanes.

The cage has one angle psi_c. Ball j leaves the middle of its pocket by s = R (psi_j - psi_c - 2 pi j / Z) along the
pitch circle of radius R; beyond half the pocket clearance c_p the pocket pushes back with N = k (p + T a dp/dt) >= 0,
p = |s| - c_p / 2 (Kelvin and Voigt). With a = p / (p + ONSET) the viscous part sets in over the roughness of the wall;
all at once, it would be a jump that no step can pass over. Friction acts on the ball's surface where it meets the
pocket, a ball radius ahead or behind, smoothed as on the raceways. What the ball loses of angular momentum about the
axis the cage gains. The cage stays centred (`moving_cage` lets its centre move): forces along the radius and the axis
are taken by what guides it.
"""

import math
from typing import NamedTuple

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.forces.layout import (
    AXIAL_SPIN,
    AXIAL_VELOCITY,
    AXIS_DISTANCE,
    BALL_BY_BORDER,
    BORDER_BY_BALL,
    BORDER_BY_BORDER,
    BORDER_MOTION,
    BORDER_PUSH,
    CAGE,
    DISSIPATED,
    MOTION,
    ORBIT_ANGLE,
    PLACES,
    POCKET,
    RADIAL_SPIN,
    RADIAL_VELOCITY,
    SPIN,
    TANGENTIAL_VELOCITY,
    VELOCITY,
    entry,
)
from bearing_twin.numerics.lanes import LANE_RATES, LANES, get, get_vector, increase, put

ONSET = 1e-6  # m: the approach over which the viscous part of a pocket sets in, about the roughness of its wall


class Pockets(NamedTuple):
    """Pockets on a circle of `radius` [m]: half their clearance [m], stiffness [N/m], relaxation time [s], friction."""

    radius: float
    half_clearance: float
    stiffness: float
    relaxation_time: float
    friction: float


class Bump(NamedTuple):
    """A ball in its pocket: approach [m] and its rate, side (+1: the wall ahead), load [N], slip along radius and axis.

    `friction` (2,) [N] on the ball along radius and axis, `along` [N] the force on it along the orbit, `torque` [N m]
    on the cage, `energy` [J] and loss [W].
    """

    approach: float
    rate: float
    side: float
    load: float
    slip: tuple[float, float]
    friction: tuple[float, float]
    along: float
    torque: float
    energy: float
    dissipation: float


@inlined
def wall_load(wall, approach, rate):
    """Load [N] of the spring of a wall, and of spring and damper together, which do not pull."""
    depth = max(approach, 0.0)
    elastic = wall.stiffness * depth
    return elastic, max(elastic + wall.stiffness * wall.relaxation_time * rate * depth / (depth + ONSET), 0.0)


@inlined
def wall_change(wall, smoothing, found, approach, rate, slip_radial, slip_axial):
    """Change of load, friction (2,) and loss of a `found` contact with a wall by changes of approach, rate and slip."""
    slip, touching = found.slip, 1.0 if found.approach > 0.0 and found.load > 0.0 else 0.0
    stiff = wall.stiffness if found.approach > 0.0 else 0.0
    depth = max(found.approach, 0.0)
    share = 1.0 / (depth + ONSET)
    viscous = wall.relaxation_time * share * (rate * depth + found.rate * approach * ONSET * share)
    load = touching * wall.stiffness * (approach + viscous)
    square = slip[0] * slip[0] + slip[1] * slip[1]
    inverse = 1.0 / math.sqrt(square + smoothing * smoothing)
    along = slip[0] * slip_radial + slip[1] * slip_axial
    grows = wall.friction * inverse * (load - found.load * along * inverse * inverse)
    resists = wall.friction * inverse * found.load
    friction = (-(grows * slip[0] + resists * slip_radial), -(grows * slip[1] + resists * slip_axial))
    elastic = stiff * found.approach
    loss = grows * square + 2.0 * resists * along + (load - stiff * approach) * found.rate
    return load, friction, loss + (found.load - elastic) * rate


@inlined
def bump(pockets, bearing, radius, ahead, velocity, spin, cage_speed):
    """The contact of a ball at axis distance `radius` with its pocket, whose middle it is `ahead` of [rad]."""
    side = 1.0 if ahead >= 0.0 else -1.0
    approach = pockets.radius * abs(ahead) - pockets.half_clearance
    rate = side * pockets.radius * (velocity[1] / radius - cage_speed)
    lever, (elastic, load) = side * bearing.ball_radius, wall_load(pockets, approach, rate)
    slip = (velocity[0] - lever * (spin[2] - cage_speed), velocity[2] + lever * spin[0])
    square = slip[0] * slip[0] + slip[1] * slip[1]
    smoothing = bearing.friction_regularisation
    resistance = pockets.friction * load / math.sqrt(square + smoothing * smoothing)
    friction = (-resistance * slip[0], -resistance * slip[1])
    push = side * pockets.radius * load
    return Bump(
        approach=approach,
        rate=rate,
        side=side,
        load=load,
        slip=slip,
        friction=friction,
        along=-push / radius,
        torque=push + lever * friction[0],
        energy=0.5 * elastic * max(approach, 0.0),
        dissipation=resistance * square + (load - elastic) * rate,
    )


@inlined
def _ahead(lanes, k):
    return get(lanes, ORBIT_ANGLE, k) - get(lanes, BORDER_MOTION + CAGE, k) - get(lanes, POCKET, k)


@inlined
def bump_in_lane(pockets, bearing, lanes, k):
    """The contact of lane k's ball with its pocket."""
    speed = get(lanes, BORDER_MOTION + PLACES + CAGE, k)
    velocity, spin = get_vector(lanes, VELOCITY, k), get_vector(lanes, SPIN, k)
    return bump(pockets, bearing, get(lanes, AXIS_DISTANCE, k), _ahead(lanes, k), velocity, spin, speed)


@kernel
def add_pockets(pockets, bearing, lanes):
    """Adds to the rates what pockets do, and says what they do to the cage; nothing without `Pockets`."""
    if len(pockets) > 1:
        inverse_mass, inverse_inertia = 1.0 / bearing.ball_mass, 1.0 / bearing.ball_inertia
        for k in range(LANES):
            found = bump_in_lane(pockets, bearing, lanes, k)
            lever = found.side * bearing.ball_radius
            increase(lanes, LANE_RATES + VELOCITY, k, inverse_mass * found.friction[0])
            increase(lanes, LANE_RATES + VELOCITY + 1, k, inverse_mass * found.along)
            increase(lanes, LANE_RATES + VELOCITY + 2, k, inverse_mass * found.friction[1])
            increase(lanes, LANE_RATES + RADIAL_SPIN, k, inverse_inertia * lever * found.friction[1])
            increase(lanes, LANE_RATES + AXIAL_SPIN, k, -inverse_inertia * lever * found.friction[0])
            increase(lanes, LANE_RATES + DISSIPATED, k, found.dissipation)
            put(lanes, BORDER_PUSH + CAGE, k, found.torque)


@inlined
def _change(pockets, bearing, found, radius, approach, rate, slip_radial, slip_axial, outwards):
    """How a bump changes when approach, rate, slip and axis distance change by these.

    Force on the ball (3,), the factor of its torque about radius and axis, torque on the cage, loss.
    """
    side, smoothing = found.side, bearing.friction_regularisation
    lever = side * bearing.ball_radius
    load, (radial, axial), loss = wall_change(pockets, smoothing, found, approach, rate, slip_radial, slip_axial)
    push = side * pockets.radius * load
    tangential = -push / radius - found.along * outwards / radius
    return (radial, tangential, axial), lever, push + lever * radial, loss


@inlined
def _put_answer(inverse_mass, inverse_inertia, lanes, first, stride, own, k, change):
    """Adds one column of answers: the ball's from row `first` on, `stride` rows apart, the cage's in row `own`."""
    force, arm, torque, loss = change
    increase(lanes, first, k, inverse_mass * force[0])
    increase(lanes, first + stride, k, inverse_mass * force[1])
    increase(lanes, first + 2 * stride, k, inverse_mass * force[2])
    increase(lanes, first + (RADIAL_SPIN - VELOCITY) * stride, k, inverse_inertia * arm * force[2])
    increase(lanes, first + (AXIAL_SPIN - VELOCITY) * stride, k, -inverse_inertia * arm * force[0])
    increase(lanes, first + (DISSIPATED - VELOCITY) * stride, k, loss)
    increase(lanes, own, k, torque)


@kernel
def pocket_answers(pockets, bearing, lanes):
    """Adds to the Jacobians of balls and border how the pockets answer; nothing without `Pockets`."""
    if len(pockets) > 1:
        _add_answers(pockets, bearing, lanes)


@kernel
def _add_answers(pockets, bearing, lanes):
    inverse_mass, inverse_inertia = 1.0 / bearing.ball_mass, 1.0 / bearing.ball_inertia
    own, reacting, stride = entry(VELOCITY, 0), BORDER_BY_BALL + CAGE * MOTION, 2 * PLACES
    corner = BORDER_BY_BORDER + CAGE * stride
    # One kind of displacement at a time: a loop over all of them would not become vector instructions.
    for k in range(LANES):
        found, radius = bump_in_lane(pockets, bearing, lanes, k), get(lanes, AXIS_DISTANCE, k)
        arc = found.side * pockets.radius
        closing = -arc * get(lanes, VELOCITY + 1, k) / (radius * radius)
        change = _change(pockets, bearing, found, radius, 0.0, closing, 0.0, 0.0, 1.0)
        column = AXIS_DISTANCE
        _put_answer(inverse_mass, inverse_inertia, lanes, own + column, MOTION, reacting + column, k, change)
        change = _change(pockets, bearing, found, radius, arc, 0.0, 0.0, 0.0, 0.0)
        column = ORBIT_ANGLE
        _put_answer(inverse_mass, inverse_inertia, lanes, own + column, MOTION, reacting + column, k, change)
        change = _change(pockets, bearing, found, radius, -arc, 0.0, 0.0, 0.0, 0.0)
        column = CAGE
        _put_answer(inverse_mass, inverse_inertia, lanes, BALL_BY_BORDER + column, stride, corner + column, k, change)
    for k in range(LANES):
        found, radius = bump_in_lane(pockets, bearing, lanes, k), get(lanes, AXIS_DISTANCE, k)
        arc, lever = found.side * pockets.radius, found.side * bearing.ball_radius
        change = _change(pockets, bearing, found, radius, 0.0, 0.0, 1.0, 0.0, 0.0)
        column = RADIAL_VELOCITY
        _put_answer(inverse_mass, inverse_inertia, lanes, own + column, MOTION, reacting + column, k, change)
        change = _change(pockets, bearing, found, radius, 0.0, arc / radius, 0.0, 0.0, 0.0)
        column = TANGENTIAL_VELOCITY
        _put_answer(inverse_mass, inverse_inertia, lanes, own + column, MOTION, reacting + column, k, change)
        change = _change(pockets, bearing, found, radius, 0.0, 0.0, 0.0, 1.0, 0.0)
        column = AXIAL_VELOCITY
        _put_answer(inverse_mass, inverse_inertia, lanes, own + column, MOTION, reacting + column, k, change)
        change = _change(pockets, bearing, found, radius, 0.0, -arc, lever, 0.0, 0.0)
        column = PLACES + CAGE
        _put_answer(inverse_mass, inverse_inertia, lanes, BALL_BY_BORDER + column, stride, corner + column, k, change)
    for k in range(LANES):
        found, radius = bump_in_lane(pockets, bearing, lanes, k), get(lanes, AXIS_DISTANCE, k)
        lever = found.side * bearing.ball_radius
        change = _change(pockets, bearing, found, radius, 0.0, 0.0, 0.0, lever, 0.0)
        column = RADIAL_SPIN
        _put_answer(inverse_mass, inverse_inertia, lanes, own + column, MOTION, reacting + column, k, change)
        change = _change(pockets, bearing, found, radius, 0.0, 0.0, -lever, 0.0, 0.0)
        column = AXIAL_SPIN
        _put_answer(inverse_mass, inverse_inertia, lanes, own + column, MOTION, reacting + column, k, change)
