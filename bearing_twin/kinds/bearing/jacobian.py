"""The Jacobian of `lane_rates`: how the raceways' answer changes with a ball's motion, balls side by side.

Exact for friction at a point; by forward differences where friction is summed over the spot.
"""

import math

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.normal import CONSTANT, HERTZ, load_coefficient
from bearing_twin.kinds.bearing.equations import (
    AXIS_DISTANCE,
    COLUMNS,
    GIVEN,
    HEIGHT,
    LANE_RATES,
    LANE_ROWS,
    LANE_SPOTS,
    LANES,
    MOTION,
    ORBIT_ANGLE,
    RING_SPEED,
    SPIN,
    VELOCITY,
    lane_vector,
)
from bearing_twin.kinds.bearing.gradient import CURVATURE_STEP, contact_gradient, plus
from bearing_twin.kinds.bearing.rates import lane_rates
from bearing_twin.numerics.rotation import about_z, add, cosine_sine, scaled
from bearing_twin.shapes.surfaces import ball_in_groove

# Rows of the lanes after the rates: two slopes of given coefficients, then entry (row, column) of the Jacobian.
GIVEN_SLOPE = LANE_ROWS
JACOBIAN = LANE_ROWS + 2
JACOBIAN_END = JACOBIAN + COLUMNS * MOTION


# `at` is where entry (0, 0) of a lane's Jacobian stands. Sums, not literal rows and columns, are handed to functions:
# numba compiles a function anew for every literal.
ROW = MOTION * LANES


@inlined
def _store_row(lanes, at, values):
    lanes[at], lanes[at + LANES], lanes[at + 2 * LANES] = values[0], values[1], values[2]


@inlined
def _store(lanes, at, block, factor):
    _store_row(lanes, at, scaled(factor, block[0]))
    _store_row(lanes, at + ROW, scaled(factor, block[1]))
    _store_row(lanes, at + 2 * ROW, scaled(factor, block[2]))


@inlined
def _add_frame(lanes, at, position, velocity, spin, gravity):
    """Adds what the frame that turns with the ball does, and gravity in it."""
    inverse = 1.0 / position[0]
    rate = velocity[1] * inverse
    lanes[at + 0 * ROW + 3 * LANES] += 1.0
    lanes[at + 1 * ROW + 0 * LANES] += -rate * inverse
    lanes[at + 1 * ROW + 4 * LANES] += inverse
    lanes[at + 2 * ROW + 5 * LANES] += 1.0
    lanes[at + 3 * ROW + 0 * LANES] += -rate * rate
    lanes[at + 3 * ROW + 1 * LANES] += gravity[1]
    lanes[at + 3 * ROW + 4 * LANES] += 2.0 * rate
    lanes[at + 4 * ROW + 0 * LANES] += rate * velocity[0] * inverse
    lanes[at + 4 * ROW + 1 * LANES] += -gravity[0]
    lanes[at + 4 * ROW + 3 * LANES] += -rate
    lanes[at + 4 * ROW + 4 * LANES] += -velocity[0] * inverse
    lanes[at + 6 * ROW + 0 * LANES] += -rate * spin[1] * inverse
    lanes[at + 6 * ROW + 4 * LANES] += spin[1] * inverse
    lanes[at + 6 * ROW + 7 * LANES] += rate
    lanes[at + 7 * ROW + 0 * LANES] += rate * spin[0] * inverse
    lanes[at + 7 * ROW + 4 * LANES] += -spin[0] * inverse
    lanes[at + 7 * ROW + 6 * LANES] += -rate


@kernel
def _give_slopes(bearing, lanes):
    """dC/dQ of the load coefficients that are looked up, by central differences."""
    for k in range(LANES):
        cosine, sine = cosine_sine(lanes[ORBIT_ANGLE * LANES + k])
        centre = about_z(cosine, -sine, bearing.offset)
        offset = (lanes[AXIS_DISTANCE * LANES + k] - centre[0], -centre[1], lanes[HEIGHT * LANES + k] - centre[2])
        lanes[GIVEN_SLOPE * LANES + k] = _given_slope(bearing, bearing.inner, offset)
        offset = (lanes[AXIS_DISTANCE * LANES + k], 0.0, lanes[HEIGHT * LANES + k])
        lanes[(GIVEN_SLOPE + 1) * LANES + k] = _given_slope(bearing, bearing.outer, offset)


@kernel
def _given_slope(bearing, raceway, offset):
    axis_distance = math.sqrt(offset[0] * offset[0] + offset[1] * offset[1])
    at = ball_in_groove(axis_distance, offset[2], bearing.ball_radius, raceway.locus_radius, raceway.groove_radius)
    law, modulus, constant = raceway.law, raceway.effective_modulus, raceway.constant
    step = CURVATURE_STEP * at.curvature_large
    more = load_coefficient(law, at.curvature_small, at.curvature_large + step, modulus, constant)
    less = load_coefficient(law, at.curvature_small, at.curvature_large - step, modulus, constant)
    return (more - less) / (2.0 * step)


@kernel
def _fill(bearing, lanes):
    inverse_mass, inverse_inertia = 1.0 / bearing.ball_mass, 1.0 / bearing.ball_inertia
    for k in range(LANES):
        cosine, sine = cosine_sine(lanes[ORBIT_ANGLE * LANES + k])
        speed = lanes[RING_SPEED * LANES + k]
        position = (lanes[AXIS_DISTANCE * LANES + k], 0.0, lanes[HEIGHT * LANES + k])
        velocity, spin = lane_vector(lanes, VELOCITY, k), lane_vector(lanes, SPIN, k)
        centre = about_z(cosine, -sine, bearing.offset)
        gravity = about_z(cosine, -sine, bearing.gravity)
        contact, inner = contact_gradient(
            bearing,
            bearing.inner,
            lanes[GIVEN * LANES + k],
            lanes[GIVEN_SLOPE * LANES + k],
            centre,
            (-centre[1], centre[0], 0.0),
            speed,
            position,
            velocity,
            spin,
        )
        still = (0.0, 0.0, 0.0)
        _, outer = contact_gradient(
            bearing,
            bearing.outer,
            lanes[(GIVEN + 1) * LANES + k],
            lanes[(GIVEN_SLOPE + 1) * LANES + k],
            still,
            still,
            0.0,
            position,
            velocity,
            spin,
        )
        at = JACOBIAN * LANES + k
        for i in range(3 * MOTION):
            lanes[at + i * LANES] = 0.0
        _store(lanes, at + VELOCITY * ROW + 0 * LANES, plus(inner.force_p, outer.force_p), inverse_mass)
        _store(lanes, at + VELOCITY * ROW + VELOCITY * LANES, plus(inner.force_v, outer.force_v), inverse_mass)
        _store(lanes, at + VELOCITY * ROW + SPIN * LANES, plus(inner.force_s, outer.force_s), inverse_mass)
        _store(lanes, at + SPIN * ROW + 0 * LANES, plus(inner.torque_p, outer.torque_p), inverse_inertia)
        _store(lanes, at + SPIN * ROW + VELOCITY * LANES, plus(inner.torque_v, outer.torque_v), inverse_inertia)
        _store(lanes, at + SPIN * ROW + SPIN * LANES, plus(inner.torque_s, outer.torque_s), inverse_inertia)
        _store_row(lanes, at + MOTION * ROW + 0 * LANES, inner.power_p)
        _store_row(lanes, at + MOTION * ROW + VELOCITY * LANES, inner.power_v)
        _store_row(lanes, at + MOTION * ROW + SPIN * LANES, inner.power_s)
        _store_row(lanes, at + (MOTION + 1) * ROW + 0 * LANES, add(inner.loss_p, outer.loss_p))
        _store_row(lanes, at + (MOTION + 1) * ROW + VELOCITY * LANES, add(inner.loss_v, outer.loss_v))
        _store_row(lanes, at + (MOTION + 1) * ROW + SPIN * LANES, add(inner.loss_s, outer.loss_s))
        sign = math.copysign(1.0, contact.drive_power)
        _store_row(lanes, at + (MOTION + 2) * ROW + 0 * LANES, scaled(sign, inner.power_p))
        _store_row(lanes, at + (MOTION + 2) * ROW + VELOCITY * LANES, scaled(sign, inner.power_v))
        _store_row(lanes, at + (MOTION + 2) * ROW + SPIN * LANES, scaled(sign, inner.power_s))

        _add_frame(lanes, at, position, velocity, spin, gravity)


@kernel
def raceway_jacobian(bearing, lanes):
    """Fills the Jacobian's rows with d(rates)/d(motion) of each lane, from the motion and the given coefficients."""
    if bearing.inner.law not in (HERTZ, CONSTANT):
        _give_slopes(bearing, lanes)
    _fill(bearing, lanes)


@inlined
def nudges(bearing):
    """Increments (MOTION,) for forward differences: small against an elastic approach and the friction's smoothing."""
    speed = 1e-6 * bearing.friction_regularisation
    turn = speed / bearing.ball_radius
    return (3e-12, 3e-12 / bearing.outer.locus_radius, 3e-12, speed, speed, speed, turn, turn, turn)


@kernel
def _differences(bearing, lanes):
    """The same by forward differences of `lane_rates`; the rates' rows are left with the rates at this motion."""
    steps = nudges(bearing)
    lane_rates(bearing, lanes)
    base = lanes[LANE_RATES * LANES : LANE_SPOTS * LANES].copy()
    kept = np.empty(LANES)
    for column in range(MOTION):
        for k in range(LANES):
            kept[k] = lanes[column * LANES + k]
            lanes[column * LANES + k] = kept[k] + steps[column]
        lane_rates(bearing, lanes)
        for k in range(LANES):
            inverse = 1.0 / (lanes[column * LANES + k] - kept[k])
            lanes[column * LANES + k] = kept[k]
            for row in range(COLUMNS):
                change = lanes[(LANE_RATES + row) * LANES + k] - base[row * LANES + k]
                lanes[(JACOBIAN + row * MOTION + column) * LANES + k] = change * inverse
    lanes[LANE_RATES * LANES : LANE_SPOTS * LANES] = base


@kernel
def lane_jacobian(spot, bearing, lanes):
    """d(rates)/d(motion) of each lane by whatever law and friction; `spot` is the bearing's, see `bearing_spot`."""
    if len(spot) > 0:
        _differences(bearing, lanes)
    else:
        raceway_jacobian(bearing, lanes)
