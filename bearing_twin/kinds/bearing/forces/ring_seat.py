"""The inner ring as a ball sees it: where its axes point and how it moves, in the frame that turns with the ball.

A ring that is tilted or moves is met in its own axes, where it is centred and at rest but for its spin: there the
contact is that of a ring that stays put. The place, velocity and spin of the ball are taken there (`seen_from`), and
what the contact does is taken back (`equations.ring_contact`), so the arm of a tilt is that of the true groove.

Tilt is taken to first order, as in the quasi-static equations and in ISO/TS 16281: a point at p of the ring goes to
p + theta x p, so that the circle of the groove's centres, of radius R_i, moves along the axis by
R_i (theta_x sin psi - theta_y cos psi) and keeps its radius. What is left out, R_i theta^2 / 2 of that radius, is 7 nm
at 1 mrad in a 6203; with it goes the moment of a radial preload through it, 2.8 of 172 N m/rad in the preloaded 6203.
Forces and moments are those of the virtual work of these displacements, so that no energy is made.
"""

from typing import NamedTuple

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.forces.layout import BORDER_MOTION, PLACES
from bearing_twin.numerics.block_solve import times
from bearing_twin.numerics.lanes import LANES, get, get_vector, put
from bearing_twin.numerics.rotation import about_z, cross, minus


class RingMotion(NamedTuple):
    """Tilt about x and y [rad], velocity of the centre [m/s] and rates of the tilt [rad/s], in `bearing_link`."""

    tilt: tuple[float, float]
    velocity: tuple[float, float, float]
    tilt_rate: tuple[float, float]


class LevelMotion(NamedTuple):
    """Velocity of the centre [m/s] of a ring that moves and whose axis stays z, in `bearing_link`."""

    velocity: tuple[float, float, float]


class LevelSeat(NamedTuple):
    """Centre [m] and velocity of a ring whose axis stays z, in the frame of a ball, whose axes it shares."""

    centre: tuple
    velocity: tuple


class RingSeat(NamedTuple):
    """Centre [m] and tilt [rad], velocity and angular velocity without spin, in the frame of a ball.

    `axes` takes vectors from there into the ring's axes: the inverse of 1 + theta x.
    """

    centre: tuple
    tilt: tuple
    axes: tuple
    velocity: tuple
    turning: tuple


@inlined
def seat_of(ring, place, cosine, sine):
    """The ring at `place` in the frame of a ball at the orbit angle of that cosine and sine."""
    centre, velocity = about_z(cosine, -sine, place), about_z(cosine, -sine, ring.velocity)
    if len(ring) == 1:  # a `LevelMotion`
        return LevelSeat(centre, velocity)
    tilt = about_z(cosine, -sine, (ring.tilt[0], ring.tilt[1], 0.0))
    x, y = tilt[0], tilt[1]
    share = 1.0 / (1.0 + x * x + y * y)
    return RingSeat(
        centre=centre,
        tilt=tilt,
        axes=(
            (share * (1.0 + x * x), share * x * y, -share * y),
            (share * x * y, share * (1.0 + y * y), share * x),
            (share * y, -share * x, share),
        ),
        velocity=velocity,
        turning=about_z(cosine, -sine, (ring.tilt_rate[0], ring.tilt_rate[1], 0.0)),
    )


@inlined
def seen_from(seat, position, velocity, spin):
    """Position, velocity and spin of a ball in the axes of the ring, against it."""
    if len(seat) == 2:  # a `LevelSeat`
        return minus(position, seat.centre), minus(velocity, seat.velocity), spin
    offset = times(seat.axes, minus(position, seat.centre))
    relative = minus(minus(velocity, seat.velocity), cross(seat.turning, offset))
    return offset, times(seat.axes, relative), times(seat.axes, minus(spin, seat.turning))


@inlined
def from_ring(ring, place, cosine, sine, position):
    """The centre of a ball at `position` in its own frame against the ring at `place`, in the ring's axes."""
    if len(ring) == 0:
        return minus(position, about_z(cosine, -sine, place))
    still = (0.0, 0.0, 0.0)
    return seen_from(seat_of(ring, place, cosine, sine), position, still, still)[0]


@inlined
def ring_in_lane(ring, place, lanes, k):
    """Place and motion of the ring for lane k: the `place` and `ring` of the bearing unless it moves or is tilted."""
    if len(ring) == 0:
        return place, ring
    tilt, velocity = BORDER_MOTION + 3, BORDER_MOTION + PLACES
    if len(ring) == 1:
        return get_vector(lanes, BORDER_MOTION, k), LevelMotion(get_vector(lanes, velocity, k))
    return get_vector(lanes, BORDER_MOTION, k), RingMotion(
        (get(lanes, tilt, k), get(lanes, tilt + 1, k)),
        get_vector(lanes, velocity, k),
        (get(lanes, velocity + 3, k), get(lanes, velocity + 4, k)),
    )


@kernel
def put_still_ring(ring, bearing, lanes):
    """Gives all lanes a ring that is tilted but stays where the bearing has it; nothing where `ring` is empty."""
    if len(ring) > 0:
        for k in range(LANES):
            for axis in range(3):
                put(lanes, BORDER_MOTION + axis, k, bearing.offset[axis])
    if len(ring) > 1:
        for k in range(LANES):
            for axis in range(2):
                put(lanes, BORDER_MOTION + 3 + axis, k, ring.tilt[axis])
