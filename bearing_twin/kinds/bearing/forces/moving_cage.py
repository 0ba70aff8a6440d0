"""A cage whose centre moves across the axis: contact of each ball with the walls of its pocket, in lanes.

Its middle line turned by psi_c + 2 pi j / Z, with r_p along it and t_p across it, the pocket of ball j has two flat
walls across t_p, and is open along r_p. With d from the cage's centre to the ball's, s = d . t_p takes the place of the
arc of a centred cage (`cage`): beyond half the clearance the wall pushes the ball back along t_p, with
N = k (p + T a dp/dt). Friction acts where they touch, a ball radius ahead or behind, along r_p and the axis. What the
ball loses of momentum in the plane, and of angular momentum about the axis, the cage gains; what it loses along the
axis goes to what keeps the cage in its plane.
"""

import math
from typing import NamedTuple

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.forces.cage import Pockets, wall_load
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    BORDER_MOTION,
    BORDER_PUSH,
    CAGE,
    CAGE_X,
    CAGE_Y,
    CENTRE,
    DISSIPATED,
    ORBIT_ANGLE,
    PLACES,
    POCKET,
    SPIN,
    VELOCITY,
)
from bearing_twin.numerics.lanes import LANE_RATES, LANES, get, get_vector, increase, increase_vector, put
from bearing_twin.numerics.rotation import cosine_sine


class MovingPockets(NamedTuple):
    """Walls of a cage whose centre moves; their radius has no part in it."""

    walls: Pockets


class Wall(NamedTuple):
    """A ball at a wall of its pocket, axes of the ball's frame.

    Sine and cosine of the angle that the ball is ahead of the pocket by; s and d . r_p [m]; its velocity against the
    cage's centre (2,); the wall ahead (1) or behind (-1); approach [m] and its rate, load [N], slip along r_p and the
    axis, and friction (2,) [N] on the ball there; force (3,) [N] and torque (3,) [N m] on the ball, torque on the cage
    about its centre, energy [J] and loss [W].
    """

    sine: float
    cosine: float
    along: float
    out: float
    relative: tuple[float, float]
    side: float
    approach: float
    rate: float
    load: float
    slip: tuple[float, float]
    friction: tuple[float, float]
    force: tuple[float, float, float]
    torque: tuple[float, float, float]
    cage_torque: float
    energy: float
    dissipation: float


@inlined
def wall(pockets, bearing, radius, ahead, centre, moving, velocity, spin, cage_speed):
    """The contact of a ball at axis distance `radius`, `ahead` [rad] of its pocket, with a wall of it.

    The cage's centre is at `centre` [m] and `moving` [m/s], (2,) in the ball's frame.
    """
    sine, cosine = math.sin(ahead), math.cos(ahead)
    x, y = radius - centre[0], -centre[1]
    along, out = x * sine + y * cosine, x * cosine - y * sine
    relative = (velocity[0] - moving[0], velocity[1] - moving[1])
    side = 1.0 if along >= 0.0 else -1.0
    lever = side * bearing.ball_radius
    approach = side * along - pockets.half_clearance
    rate = side * (relative[0] * sine + relative[1] * cosine - cage_speed * out)
    elastic, load = wall_load(pockets, approach, rate)
    slip = (
        relative[0] * cosine - relative[1] * sine - lever * spin[2] + cage_speed * (along + lever),
        velocity[2] + lever * (spin[0] * cosine - spin[1] * sine),
    )
    square, smoothing = slip[0] * slip[0] + slip[1] * slip[1], bearing.friction_regularisation
    resistance = pockets.friction * load / math.sqrt(square + smoothing * smoothing)
    radial, axial = -resistance * slip[0], -resistance * slip[1]
    push = -side * load
    return Wall(
        sine=sine,
        cosine=cosine,
        along=along,
        out=out,
        relative=relative,
        side=side,
        approach=approach,
        rate=rate,
        load=load,
        slip=slip,
        friction=(radial, axial),
        force=(push * sine + radial * cosine, push * cosine - radial * sine, axial),
        torque=(lever * axial * cosine, -lever * axial * sine, -lever * radial),
        cage_torque=(along + lever) * radial - out * push,
        energy=0.5 * elastic * max(approach, 0.0),
        dissipation=resistance * square + (load - elastic) * rate,
    )


@inlined
def wall_in_lane(walls, bearing, lanes, k, cosine, sine):
    """The contact of lane k's ball, whose orbit angle has that cosine and sine, with a wall of its pocket."""
    ahead = get(lanes, ORBIT_ANGLE, k) - get(lanes, BORDER_MOTION + CAGE, k) - get(lanes, POCKET, k)
    centre, moving = seen_in_lane(lanes, CENTRE, k, cosine, sine), seen_in_lane(lanes, CENTRE + 2, k, cosine, sine)
    velocity, spin = get_vector(lanes, VELOCITY, k), get_vector(lanes, SPIN, k)
    speed = get(lanes, BORDER_MOTION + PLACES + CAGE, k)
    return wall(walls, bearing, get(lanes, AXIS_DISTANCE, k), ahead, centre, moving, velocity, spin, speed)


@inlined
def seen(x, y, cosine, sine):
    """A vector in the plane, (2,) of fixed axes, in the frame of a ball whose orbit angle has that cosine and sine."""
    return (cosine * x + sine * y, cosine * y - sine * x)


@inlined
def seen_in_lane(lanes, row, k, cosine, sine):
    """Two rows of fixed axes in the frame of lane k's ball."""
    return seen(get(lanes, row, k), get(lanes, row + 1, k), cosine, sine)


@kernel
def add_moving_pockets(pockets, bearing, lanes):
    """Adds to the rates what these pockets do, and says what they do to the cage; nothing where they are others."""
    if len(pockets) == 1:
        inverse_mass, inverse_inertia = 1.0 / bearing.ball_mass, 1.0 / bearing.ball_inertia
        for k in range(LANES):
            cosine, sine = cosine_sine(get(lanes, ORBIT_ANGLE, k))
            found = wall_in_lane(pockets.walls, bearing, lanes, k, cosine, sine)
            force, torque = found.force, found.torque
            acceleration = (inverse_mass * force[0], inverse_mass * force[1], inverse_mass * force[2])
            turning = (inverse_inertia * torque[0], inverse_inertia * torque[1], inverse_inertia * torque[2])
            increase_vector(lanes, LANE_RATES + VELOCITY, k, acceleration)
            increase_vector(lanes, LANE_RATES + SPIN, k, turning)
            increase(lanes, LANE_RATES + DISSIPATED, k, found.dissipation)
            put(lanes, BORDER_PUSH + CAGE_X, k, sine * force[1] - cosine * force[0])
            put(lanes, BORDER_PUSH + CAGE_Y, k, -sine * force[0] - cosine * force[1])
            put(lanes, BORDER_PUSH + CAGE, k, found.cage_torque)
