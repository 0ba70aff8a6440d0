"""The Jacobian of `lane_rates`: how the raceways' answer changes with a ball's motion, balls side by side.

The same contacts give the rates, which a step wants at the same motion: a sixth of its evaluations. Where friction acts
over spots, `spot_jacobian` says what the raceways answer, after the rates.
"""

import math

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.elasticity import carries, lane_given, looked_up
from bearing_twin.kinds.bearing.forces.carried import carried_coefficient, gap_at
from bearing_twin.kinds.bearing.forces.equations import ON_AXIS, give_coefficients, lane_position, put_ball_rates
from bearing_twin.kinds.bearing.forces.gradient import CURVATURE_STEP, contact_gradient
from bearing_twin.kinds.bearing.forces.layout import (
    ANSWERING,
    AXIS_DISTANCE,
    BALL_BY_BORDER,
    BALL_TILE,
    BORDER_BY_BALL,
    BORDER_BY_BORDER,
    CAGE,
    CARRIED_INNER,
    CARRIED_OUTER,
    DISSIPATED,
    DRIVE_WORK,
    GIVEN_INNER,
    GIVEN_OUTER,
    GIVEN_SLOPE_INNER,
    GIVEN_SLOPE_OUTER,
    MOTION,
    ORBIT_ANGLE,
    PLACES,
    POWER_SIGN,
    RING_SPEED,
    SPIN,
    TANGENTIAL_VELOCITY,
    VELOCITY,
    entry,
    get_jacobian_block,
    put_jacobian_block,
)
from bearing_twin.kinds.bearing.forces.rates import add_others
from bearing_twin.kinds.bearing.forces.ring_gradient import inner_gradient, of_ball, put_answers, seated_gradient
from bearing_twin.kinds.bearing.forces.ring_seat import from_ring, ring_in_lane
from bearing_twin.kinds.bearing.forces.spot_jacobian import put_spot_slopes
from bearing_twin.kinds.bearing.forces.turning_frame import add_frame, add_orbit, clear_places
from bearing_twin.numerics.block_solve import Linear, plus, scaled_block
from bearing_twin.numerics.lanes import (
    LANES,
    RIGHT,
    SOLUTION,
    clear_rows,
    get,
    get_vector,
    put,
    put_vector,
)
from bearing_twin.numerics.rotation import about_z, add, cosine_sine, dot, scaled


@inlined
def _put_row(lanes, rate, k, by_velocity, by_spin):
    """Writes one row of a lane's Jacobian, its columns of velocity and spin."""
    put_vector(lanes, entry(rate, VELOCITY), k, by_velocity)
    put_vector(lanes, entry(rate, SPIN), k, by_spin)


@inlined
def put_resistance(bearing, position, velocity, spin, power, inner, outer, lanes, k):
    """Writes the columns of velocity and spin of a ball's Jacobian; `power` is that of the drive [W]."""
    inverse_mass, inverse_inertia = 1.0 / bearing.ball_mass, 1.0 / bearing.ball_inertia
    inverse = 1.0 / position[0]
    rate = velocity[1] * inverse
    put_jacobian_block(lanes, VELOCITY, VELOCITY, k, scaled_block(inverse_mass, plus(inner.force_v, outer.force_v)))
    put_jacobian_block(lanes, VELOCITY, SPIN, k, scaled_block(inverse_mass, plus(inner.force_s, outer.force_s)))
    put_jacobian_block(lanes, SPIN, VELOCITY, k, scaled_block(inverse_inertia, plus(inner.torque_v, outer.torque_v)))
    put_jacobian_block(lanes, SPIN, SPIN, k, scaled_block(inverse_inertia, plus(inner.torque_s, outer.torque_s)))
    add_orbit(lanes, k, inverse, rate, velocity, spin)
    _put_row(lanes, DRIVE_WORK, k, inner.power_v, inner.power_s)
    _put_row(lanes, DISSIPATED, k, add(inner.loss_v, outer.loss_v), add(inner.loss_s, outer.loss_s))
    put(lanes, POWER_SIGN, k, math.copysign(1.0, power))


@kernel
def _give_slopes(bearing, lanes):
    """dC/dQ of the load coefficients that are looked up: from the states carried, else by central differences."""
    for k in range(LANES):
        cosine, sine = cosine_sine(get(lanes, ORBIT_ANGLE, k))
        position = lane_position(lanes, k)
        place, ring = ring_in_lane(bearing.ring, bearing.offset, lanes, k)
        offset = from_ring(ring, place, cosine, sine, position)
        if carries(bearing.inner.law):
            _, inner = carried_coefficient(bearing, bearing.inner, offset, lanes, CARRIED_INNER, k)
            _, outer = carried_coefficient(bearing, bearing.outer, position, lanes, CARRIED_OUTER, k)
        else:
            inner, outer = _given_slope(bearing, bearing.inner, offset), _given_slope(bearing, bearing.outer, position)
        put(lanes, GIVEN_SLOPE_INNER, k, inner)
        put(lanes, GIVEN_SLOPE_OUTER, k, outer)


@kernel
def _given_slope(bearing, raceway, offset):
    at = gap_at(bearing, raceway, offset)
    step = CURVATURE_STEP * at.curvature_large
    more = lane_given(raceway.law, at.curvature_small, at.curvature_large + step, at.approach)
    less = lane_given(raceway.law, at.curvature_small, at.curvature_large - step, at.approach)
    return (more - less) / (2.0 * step)


@inlined
def _put_ball(ring, bearing, lanes, k, place, cosine, sine, contact, inner):
    """Writes a ball's rates and own Jacobian from its contact with the inner ring and the derivatives of that."""
    position, still = lane_position(lanes, k), (0.0, 0.0, 0.0)
    velocity, spin = get_vector(lanes, VELOCITY, k), get_vector(lanes, SPIN, k)
    given, slope = get(lanes, GIVEN_OUTER, k), get(lanes, GIVEN_SLOPE_OUTER, k)
    other, outer = contact_gradient(bearing, bearing.outer, given, slope, ON_AXIS, still, 0.0, position, velocity, spin)
    clear_places(lanes, k)
    force_p, torque_p = plus(inner.force_p, outer.force_p), plus(inner.torque_p, outer.torque_p)
    put_jacobian_block(lanes, VELOCITY, AXIS_DISTANCE, k, scaled_block(1.0 / bearing.ball_mass, force_p))
    put_jacobian_block(lanes, SPIN, AXIS_DISTANCE, k, scaled_block(1.0 / bearing.ball_inertia, torque_p))
    put_vector(lanes, entry(DRIVE_WORK, AXIS_DISTANCE), k, inner.power_p)
    put_vector(lanes, entry(DISSIPATED, AXIS_DISTANCE), k, add(inner.loss_p, outer.loss_p))
    put_resistance(bearing, position, velocity, spin, contact.drive_power, inner, outer, lanes, k)
    add_frame(lanes, k, position, velocity, spin, about_z(cosine, -sine, bearing.gravity))
    put_ball_rates(ring, bearing, place, cosine, sine, position, velocity, spin, contact, other, lanes, k)


@kernel
def _fill(bearing, lanes):
    """Rates and Jacobian of each lane from the motion and the given coefficients."""
    for k in range(LANES):
        cosine, sine = cosine_sine(get(lanes, ORBIT_ANGLE, k))
        speed = get(lanes, RING_SPEED, k)
        position = lane_position(lanes, k)
        velocity, spin = get_vector(lanes, VELOCITY, k), get_vector(lanes, SPIN, k)
        place, ring = ring_in_lane(bearing.ring, bearing.offset, lanes, k)
        given, slope = get(lanes, GIVEN_INNER, k), get(lanes, GIVEN_SLOPE_INNER, k)
        contact, inner = inner_gradient(
            ring, bearing, given, slope, place, cosine, sine, speed, position, velocity, spin
        )
        _put_ball(ring, bearing, lanes, k, place, cosine, sine, contact, inner)


@kernel
def _fill_with_ring(ring, bearing, lanes):
    """`_fill`, and how balls and a ring that moves answer to each other; `ring` is the bearing's, not empty."""
    for k in range(LANES):
        cosine, sine = cosine_sine(get(lanes, ORBIT_ANGLE, k))
        place, moving = ring_in_lane(ring, bearing.offset, lanes, k)
        found = seated_gradient(
            moving, bearing, get(lanes, GIVEN_INNER, k), get(lanes, GIVEN_SLOPE_INNER, k), place, cosine, sine,
            get(lanes, RING_SPEED, k), lane_position(lanes, k), get_vector(lanes, VELOCITY, k),
            get_vector(lanes, SPIN, k),
        )  # fmt: skip
        _put_ball(moving, bearing, lanes, k, place, cosine, sine, found.contact, of_ball(found))
        put_answers(bearing, found, lanes, k, cosine, sine)
        # Nothing of a cage yet: what stands there is of the last step.
        for rate in range(ANSWERING):
            put(lanes, BALL_BY_BORDER + rate * 2 * PLACES + CAGE, k, 0.0)
            put(lanes, BALL_BY_BORDER + rate * 2 * PLACES + PLACES + CAGE, k, 0.0)
        for i in range(CAGE):
            put(lanes, BORDER_BY_BORDER + i * 2 * PLACES + CAGE, k, 0.0)
            put(lanes, BORDER_BY_BORDER + i * 2 * PLACES + PLACES + CAGE, k, 0.0)
        for column in range(MOTION):
            put(lanes, BORDER_BY_BALL + CAGE * MOTION + column, k, 0.0)
        for column in range(2 * PLACES):
            put(lanes, BORDER_BY_BORDER + CAGE * 2 * PLACES + column, k, 0.0)


@inlined
def _fill_over_spots(bearing, lanes):
    """Jacobian of each lane from the rates of the same motion with friction over the spots."""
    put_spot_slopes(bearing, lanes)
    for k in range(LANES):
        cosine, sine = cosine_sine(get(lanes, ORBIT_ANGLE, k))
        position, velocity, spin = lane_position(lanes, k), get_vector(lanes, VELOCITY, k), get_vector(lanes, SPIN, k)
        inverse = 1.0 / position[0]
        clear_places(lanes, k)
        add_orbit(lanes, k, inverse, velocity[1] * inverse, velocity, spin)
        add_frame(lanes, k, position, velocity, spin, about_z(cosine, -sine, bearing.gravity))


@inlined
def _give_laws(bearing, lanes):
    """What a law that is looked up gives, and its slopes."""
    if looked_up(bearing.inner.law):
        give_coefficients(bearing, lanes)
        _give_slopes(bearing, lanes)


@kernel
def rates_and_jacobian(spot, bearing, lanes):
    """`lane_rates`, and d(rates)/d(motion), of each lane by whatever law and friction; `spot` is the bearing's."""
    _give_laws(bearing, lanes)
    if len(spot) > 0:
        add_others(bearing, lanes)
        _fill_over_spots(bearing, lanes)
    else:
        _fill(bearing, lanes)
        add_others(bearing, lanes)


@inlined
def rates_and_ring_jacobian(ring, border, bearing, lanes):
    """`rates_and_jacobian` of balls that may meet a `border`, and how they and the ring in it answer to each other.

    `ring` is the bearing's; `border` is empty where balls are alone.
    """
    if len(border) > 0:
        _with_border(ring, border, bearing, lanes)
    else:
        rates_and_jacobian(bearing.spot, bearing, lanes)


@inlined
def _with_border(ring, border, bearing, lanes):
    if len(ring) > 0 and len(border.ring) > 0:
        _give_laws(bearing, lanes)
        _fill_with_ring(ring, bearing, lanes)
        add_others(bearing, lanes)
    else:
        clear_rows(lanes, BALL_BY_BORDER, BALL_TILE)
        rates_and_jacobian(bearing.spot, bearing, lanes)


@inlined
def lane_linear(lanes, k):
    """The Jacobian of lane k as `block_solve` takes it."""
    return Linear(
        angle_by_radius=get(lanes, entry(ORBIT_ANGLE, AXIS_DISTANCE), k),
        angle_by_velocity=get(lanes, entry(ORBIT_ANGLE, TANGENTIAL_VELOCITY), k),
        vp=get_jacobian_block(lanes, VELOCITY, AXIS_DISTANCE, k),
        vv=get_jacobian_block(lanes, VELOCITY, VELOCITY, k),
        vs=get_jacobian_block(lanes, VELOCITY, SPIN, k),
        sp=get_jacobian_block(lanes, SPIN, AXIS_DISTANCE, k),
        sv=get_jacobian_block(lanes, SPIN, VELOCITY, k),
        ss=get_jacobian_block(lanes, SPIN, SPIN, k),
    )


@inlined
def lane_answer(lanes, rate, k, position, velocity, spin):
    """One row of lane k's Jacobian times an increment of the motion."""
    return (
        dot(get_vector(lanes, entry(rate, AXIS_DISTANCE), k), position)
        + dot(get_vector(lanes, entry(rate, VELOCITY), k), velocity)
        + dot(get_vector(lanes, entry(rate, SPIN), k), spin)
    )


@inlined
def integral_answers(lanes, k, position, velocity, spin):
    """What an increment of the motion does to the power of the drive and to what is dissipated [W], in lane k."""
    work = lane_answer(lanes, DRIVE_WORK, k, position, velocity, spin)
    return work, lane_answer(lanes, DISSIPATED, k, position, velocity, spin)


@inlined
def put_integrals(g, lanes, k, work, lost):
    """Writes what lane k's integrals come to in a stage, `work` and `lost` being what its changes do to their rates."""
    right = get_vector(lanes, RIGHT + DRIVE_WORK, k)
    answers = work, lost, get(lanes, POWER_SIGN, k) * work
    put_vector(lanes, SOLUTION + DRIVE_WORK, k, scaled(g, add(right, answers)))
