"""What the frame that turns with a ball does to its Jacobian, and how places change."""

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces.layout import (
    AXIAL_VELOCITY,
    AXIS_DISTANCE,
    HEIGHT,
    ORBIT_ANGLE,
    RADIAL_SPIN,
    RADIAL_VELOCITY,
    TANGENTIAL_SPIN,
    TANGENTIAL_VELOCITY,
    VELOCITY,
    entry,
)
from bearing_twin.numerics.lanes import increase, put


@inlined
def clear_places(lanes, k):
    """Writes zeros into the rows of places in a lane's Jacobian."""
    for row in range(entry(AXIS_DISTANCE, AXIS_DISTANCE), entry(VELOCITY, AXIS_DISTANCE)):
        put(lanes, row, k, 0.0)


@inlined
def add_orbit(lanes, k, inverse, rate, velocity, spin):
    """Adds what answers to velocity and spin in the frame that turns with the ball at `rate` [rad/s]."""
    increase(lanes, entry(RADIAL_VELOCITY, TANGENTIAL_VELOCITY), k, 2.0 * rate)
    increase(lanes, entry(TANGENTIAL_VELOCITY, RADIAL_VELOCITY), k, -rate)
    increase(lanes, entry(TANGENTIAL_VELOCITY, TANGENTIAL_VELOCITY), k, -velocity[0] * inverse)
    increase(lanes, entry(RADIAL_SPIN, TANGENTIAL_VELOCITY), k, spin[1] * inverse)
    increase(lanes, entry(RADIAL_SPIN, TANGENTIAL_SPIN), k, rate)
    increase(lanes, entry(TANGENTIAL_SPIN, TANGENTIAL_VELOCITY), k, -spin[0] * inverse)
    increase(lanes, entry(TANGENTIAL_SPIN, RADIAL_SPIN), k, -rate)


@inlined
def add_frame(lanes, k, position, velocity, spin, gravity):
    """Adds what answers to places in the frame that turns with the ball, gravity in it, and how places change."""
    inverse = 1.0 / position[0]
    rate = velocity[1] * inverse
    increase(lanes, entry(AXIS_DISTANCE, RADIAL_VELOCITY), k, 1.0)
    increase(lanes, entry(ORBIT_ANGLE, AXIS_DISTANCE), k, -rate * inverse)
    increase(lanes, entry(ORBIT_ANGLE, TANGENTIAL_VELOCITY), k, inverse)
    increase(lanes, entry(HEIGHT, AXIAL_VELOCITY), k, 1.0)
    increase(lanes, entry(RADIAL_VELOCITY, AXIS_DISTANCE), k, -rate * rate)
    increase(lanes, entry(RADIAL_VELOCITY, ORBIT_ANGLE), k, gravity[1])
    increase(lanes, entry(TANGENTIAL_VELOCITY, AXIS_DISTANCE), k, rate * velocity[0] * inverse)
    increase(lanes, entry(TANGENTIAL_VELOCITY, ORBIT_ANGLE), k, -gravity[0])
    increase(lanes, entry(RADIAL_SPIN, AXIS_DISTANCE), k, -rate * spin[1] * inverse)
    increase(lanes, entry(TANGENTIAL_SPIN, AXIS_DISTANCE), k, rate * spin[0] * inverse)
