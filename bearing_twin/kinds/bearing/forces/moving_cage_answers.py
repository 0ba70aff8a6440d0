"""How the walls of a cage whose centre moves answer to the motion of balls and cage: columns of the Jacobian."""

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.forces.cage import wall_change
from bearing_twin.kinds.bearing.forces.layout import (
    ANSWERING,
    AXIAL_SPIN,
    AXIAL_VELOCITY,
    AXIS_DISTANCE,
    BALL_BY_BORDER,
    BORDER_BY_BALL,
    BORDER_BY_BORDER,
    BORDER_MOTION,
    CAGE,
    CAGE_X,
    CAGE_Y,
    CENTRE,
    DISSIPATED,
    MOTION,
    ORBIT_ANGLE,
    PLACES,
    RADIAL_SPIN,
    RADIAL_VELOCITY,
    RING_Z,
    SPIN,
    TANGENTIAL_SPIN,
    TANGENTIAL_VELOCITY,
    VELOCITY,
    entry,
)
from bearing_twin.kinds.bearing.forces.moving_cage import seen_in_lane, wall_in_lane
from bearing_twin.numerics.lanes import LANES, clear_rows, get, get_vector, increase, put
from bearing_twin.numerics.rotation import cosine_sine

STILL = (0.0, 0.0)
STRIDE = 2 * PLACES


@inlined
def _change(walls, bearing, found, spin, speed, angle, shift, push, lift, spins, faster):
    """How a wall's doing changes, axes of the ball's frame.

    With the angle that the ball is ahead by, a `shift` (2,) and a `push` (2,) of the ball's place and velocity against
    the cage's centre, its axial velocity, its spin (3,) and the cage's speed. Force (3,) and torque (3,) on the ball,
    torque on the cage, loss.
    """
    sine, cosine, side, relative = found.sine, found.cosine, found.side, found.relative
    lever, smoothing = side * bearing.ball_radius, bearing.friction_regularisation
    along = shift[0] * sine + shift[1] * cosine + found.out * angle
    out = shift[0] * cosine - shift[1] * sine - found.along * angle
    turned = relative[0] * cosine - relative[1] * sine
    rate = side * (push[0] * sine + push[1] * cosine + turned * angle - faster * found.out - speed * out)
    slip_radial = push[0] * cosine - push[1] * sine - (relative[0] * sine + relative[1] * cosine) * angle
    slip_radial += faster * (found.along + lever) + speed * along - lever * spins[2]
    slip_axial = lift + lever * (spins[0] * cosine - spins[1] * sine - (spin[0] * sine + spin[1] * cosine) * angle)
    approach = side * along
    load, (radial, axial), loss = wall_change(walls, smoothing, found, approach, rate, slip_radial, slip_axial)
    pushed, pushes, (rub, lifted) = -side * found.load, -side * load, found.friction
    force = (
        pushes * sine + radial * cosine + (pushed * cosine - rub * sine) * angle,
        pushes * cosine - radial * sine - (pushed * sine + rub * cosine) * angle,
        axial,
    )
    torque = (
        lever * (axial * cosine - lifted * sine * angle),
        -lever * (axial * sine + lifted * cosine * angle),
        -lever * radial,
    )
    on_cage = along * rub + (found.along + lever) * radial - out * pushed - found.out * pushes
    return force, torque, on_cage, loss


@inlined
def _put_column(bearing, lanes, first, stride, own, apart, k, cosine, sine, turned, change):
    """Adds one column of answers: the ball's from row `first` on, `stride` apart, the cage's from `own` on, `apart`.

    `turned` is the force on the ball where the column is the orbit angle, which turns the ball's frame, else none.
    """
    force, torque, on_cage, loss = change
    inverse_mass, inverse_inertia = 1.0 / bearing.ball_mass, 1.0 / bearing.ball_inertia
    for i in range(3):
        increase(lanes, first + i * stride, k, inverse_mass * force[i])
        increase(lanes, first + (3 + i) * stride, k, inverse_inertia * torque[i])
    increase(lanes, first + (DISSIPATED - VELOCITY) * stride, k, loss)
    x, y = force[0] - turned[1], force[1] + turned[0]
    increase(lanes, own + CAGE_X * apart, k, sine * y - cosine * x)
    increase(lanes, own + CAGE_Y * apart, k, -sine * x - cosine * y)
    increase(lanes, own + CAGE * apart, k, on_cage)


@inlined
def _make_room(lanes, k):
    """Takes the answers of a ring's tilt from the rows and columns that the cage's centre has in their place."""
    for rate in range(ANSWERING):
        for i in range(2):
            put(lanes, BALL_BY_BORDER + rate * STRIDE + CAGE_X + i, k, 0.0)
            put(lanes, BALL_BY_BORDER + rate * STRIDE + PLACES + CAGE_X + i, k, 0.0)
    for row in range(RING_Z + 1):
        for i in range(2):
            put(lanes, BORDER_BY_BORDER + row * STRIDE + CAGE_X + i, k, 0.0)
            put(lanes, BORDER_BY_BORDER + row * STRIDE + PLACES + CAGE_X + i, k, 0.0)


@inlined
def _ball_answers(at, column, angle, shift, push, lift, spins, turned):
    """Adds the column of answers to a ball's own motion."""
    walls, bearing, lanes, k, cosine, sine, found = at
    spin, speed = get_vector(lanes, SPIN, k), get(lanes, BORDER_MOTION + PLACES + CAGE, k)
    change = _change(walls, bearing, found, spin, speed, angle, shift, push, lift, spins, 0.0)
    first, own = entry(VELOCITY, 0) + column, BORDER_BY_BALL + column
    _put_column(bearing, lanes, first, MOTION, own, MOTION, k, cosine, sine, turned, change)


@inlined
def _cage_answers(at, column, angle, shift, push, faster):
    """Adds the column of answers to the cage's motion."""
    walls, bearing, lanes, k, cosine, sine, found = at
    spin, speed = get_vector(lanes, SPIN, k), get(lanes, BORDER_MOTION + PLACES + CAGE, k)
    change = _change(walls, bearing, found, spin, speed, angle, shift, push, 0.0, (0.0, 0.0, 0.0), faster)
    first, own = BALL_BY_BORDER + column, BORDER_BY_BORDER + column
    _put_column(bearing, lanes, first, STRIDE, own, STRIDE, k, cosine, sine, STILL, change)


@inlined
def _by_place(walls, bearing, lanes, k, cosine, sine):
    """Adds the answers to places."""
    found, none = wall_in_lane(walls, bearing, lanes, k, cosine, sine), (0.0, 0.0, 0.0)
    centre, moving = seen_in_lane(lanes, CENTRE, k, cosine, sine), seen_in_lane(lanes, CENTRE + 2, k, cosine, sine)
    at = walls, bearing, lanes, k, cosine, sine, found
    _ball_answers(at, AXIS_DISTANCE, 0.0, (1.0, 0.0), STILL, 0.0, none, STILL)
    # A turn of the ball's frame turns the cage's centre in it, the other way round.
    shift, push, turned = (-centre[1], centre[0]), (-moving[1], moving[0]), (found.force[0], found.force[1])
    _ball_answers(at, ORBIT_ANGLE, 1.0, shift, push, 0.0, none, turned)
    _cage_answers(at, CAGE_X, 0.0, (-cosine, sine), STILL, 0.0)
    _cage_answers(at, CAGE_Y, 0.0, (-sine, -cosine), STILL, 0.0)
    _cage_answers(at, CAGE, -1.0, STILL, STILL, 0.0)


@inlined
def _by_velocity(walls, bearing, lanes, k, cosine, sine):
    """Adds the answers to velocities and spins."""
    found, none = wall_in_lane(walls, bearing, lanes, k, cosine, sine), (0.0, 0.0, 0.0)
    at = walls, bearing, lanes, k, cosine, sine, found
    _ball_answers(at, RADIAL_VELOCITY, 0.0, STILL, (1.0, 0.0), 0.0, none, STILL)
    _ball_answers(at, TANGENTIAL_VELOCITY, 0.0, STILL, (0.0, 1.0), 0.0, none, STILL)
    _ball_answers(at, AXIAL_VELOCITY, 0.0, STILL, STILL, 1.0, none, STILL)
    _ball_answers(at, RADIAL_SPIN, 0.0, STILL, STILL, 0.0, (1.0, 0.0, 0.0), STILL)
    _ball_answers(at, TANGENTIAL_SPIN, 0.0, STILL, STILL, 0.0, (0.0, 1.0, 0.0), STILL)
    _ball_answers(at, AXIAL_SPIN, 0.0, STILL, STILL, 0.0, (0.0, 0.0, 1.0), STILL)
    _cage_answers(at, PLACES + CAGE_X, 0.0, STILL, (-cosine, sine), 0.0)
    _cage_answers(at, PLACES + CAGE_Y, 0.0, STILL, (-sine, -cosine), 0.0)
    _cage_answers(at, PLACES + CAGE, 0.0, STILL, STILL, 1.0)


@kernel
def moving_pocket_answers(pockets, bearing, lanes):
    """Adds to the Jacobians of balls and border how these pockets answer; nothing where they are others."""
    if len(pockets) == 1:
        clear_rows(lanes, BORDER_BY_BALL + CAGE_X * MOTION, BORDER_BY_BALL + CAGE * MOTION)
        clear_rows(lanes, BORDER_BY_BORDER + CAGE_X * STRIDE, BORDER_BY_BORDER + CAGE * STRIDE)
        for k in range(LANES):
            _make_room(lanes, k)
        for k in range(LANES):
            cosine, sine = cosine_sine(get(lanes, ORBIT_ANGLE, k))
            _by_place(pockets.walls, bearing, lanes, k, cosine, sine)
        for k in range(LANES):
            cosine, sine = cosine_sine(get(lanes, ORBIT_ANGLE, k))
            _by_velocity(pockets.walls, bearing, lanes, k, cosine, sine)
