"""The bearing by an implicit-explicit step: leapfrog for what contacts push, linearly implicit for what resists motion.

Positions take half a step, then the velocities a whole one at the positions in between, then the positions the other
half. Friction and contact damping grow with velocity and are stiff; the velocities therefore take the linearly implicit
midpoint rule, (I - h/2 dF/dv) dv = h F. Second order; elastic contacts limit the step as in leapfrog, friction does
not, but slip that ought to die within a step rings instead (its factor tends to -1).
"""

import math

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.kinds.bearing.carried import carry_on
from bearing_twin.kinds.bearing.jacobian import lane_answer, lane_jacobian, lane_resistance
from bearing_twin.kinds.bearing.layout import (
    AXIS_DISTANCE,
    CARRIED_INNER,
    COLUMNS,
    HEIGHT,
    IMEX_ROWS,
    LANE_RATES,
    LANES,
    MOTION,
    ORBIT_ANGLE,
    ORIENTATION,
    SPIN,
    SPIN_BEFORE,
    TANGENTIAL_VELOCITY,
    TANGENTIAL_VELOCITY_BEFORE,
    VELOCITY,
    VELOCITY_BEFORE,
    from_blocks,
    get,
    get_quaternion,
    get_vector,
    increase,
    increase_vector,
    into_blocks,
    new_blocks,
    put,
    put_quaternion,
    put_vector,
)
from bearing_twin.kinds.bearing.pairs import add_pairs, new_pairs
from bearing_twin.kinds.bearing.rates import lane_rates, put_ring_speed
from bearing_twin.kinds.bearing.ring_seat import put_still_ring
from bearing_twin.kinds.bearing.steps import JACOBIANS, RATES, STEPS, check_all, spin_in_frame
from bearing_twin.numerics.block_solve import factorise_body, solve_body
from bearing_twin.numerics.rotation import add, scaled, turned
from bearing_twin.numerics.statuses import OK, STOPPED

CHECK_EVERY = 64


@kernel
def _drift(h, before, lanes):
    """Moves the positions by h; the orbit angle turns at the radius in the middle of the step, before or after."""
    for k in range(LANES):
        radius, velocity = get(lanes, AXIS_DISTANCE, k), get_vector(lanes, VELOCITY, k)
        moved = radius + h * velocity[0]
        put(lanes, AXIS_DISTANCE, k, moved)
        increase(lanes, ORBIT_ANGLE, k, h * velocity[1] / (moved if before else radius))
        increase(lanes, HEIGHT, k, h * velocity[2])


@kernel
def _kick(h, lanes):
    """The linearly implicit midpoint rule for velocities and angular velocities at fixed positions."""
    g = 0.5 * h
    for k in range(LANES):
        linear, nothing = lane_resistance(lanes, k), (0.0, 0.0, 0.0)
        force = scaled(2.0, get_vector(lanes, LANE_RATES + VELOCITY, k))
        torque = scaled(2.0, get_vector(lanes, LANE_RATES + SPIN, k))
        _, velocity, spin = solve_body(linear, factorise_body(linear, g), g, nothing, force, torque)
        for integral in range(MOTION, COLUMNS):
            answer = lane_answer(lanes, integral, k, nothing, velocity, spin)
            increase(lanes, integral, k, h * (get(lanes, LANE_RATES + integral, k) + 0.5 * answer))
        put_vector(lanes, VELOCITY_BEFORE, k, get_vector(lanes, VELOCITY, k))
        put_vector(lanes, SPIN_BEFORE, k, get_vector(lanes, SPIN, k))
        increase_vector(lanes, VELOCITY, k, velocity)
        increase_vector(lanes, SPIN, k, spin)


@kernel
def _turn_lanes(h, lanes):
    """Orientations over a step whose angular velocity changes linearly."""
    for k in range(LANES):
        radius = get(lanes, AXIS_DISTANCE, k)
        first = spin_in_frame(radius, get(lanes, TANGENTIAL_VELOCITY_BEFORE, k), get_vector(lanes, SPIN_BEFORE, k))
        last = spin_in_frame(radius, get(lanes, TANGENTIAL_VELOCITY, k), get_vector(lanes, SPIN, k))
        middle = scaled(0.5, add(first, last))
        put_quaternion(lanes, ORIENTATION, k, turned(get_quaternion(lanes, ORIENTATION, k), first, middle, last, h))


@kernel
def _step(bearing, drive, pairs, time, h, blocks):
    """One step; what balls do to each other is taken explicitly."""
    for block in range(len(blocks)):
        lanes = blocks[block]
        _drift(0.5 * h, True, lanes)
        put_ring_speed(drive, time + 0.5 * h, lanes)
        put_still_ring(bearing.ring, bearing, lanes)
        lane_rates(bearing, lanes)
        lane_jacobian(bearing.spot, bearing, lanes)
    if pairs.touching:
        add_pairs(bearing, pairs, blocks, blocks, LANE_RATES)
    for block in range(len(blocks)):
        lanes = blocks[block]
        _kick(h, lanes)
        _turn_lanes(h, lanes)
        _drift(0.5 * h, False, lanes)
        carry_on(bearing, lanes, AXIS_DISTANCE, lanes)


@kernel
def imex_chunk(bearing, drive, near, times, duration, greatest_step, state, orientation, results):
    """Equal steps between two instants, none longer than `greatest_step` [s]; see the module."""
    balls, counts = bearing.balls, results.counts
    blocks, pairs = new_blocks(balls, IMEX_ROWS), new_pairs(near, np.arange(balls), 0.0)
    into_blocks(state, blocks, AXIS_DISTANCE)
    into_blocks(orientation, blocks, ORIENTATION)
    into_blocks(results.carried, blocks, CARRIED_INNER)
    time = 0.0
    for instant in range(len(times) + 1):
        goal = times[instant] if instant < len(times) else duration
        begin, span = time, goal - time
        steps = math.ceil(span / greatest_step - 1e-9) if span > 0.0 else 0
        for step in range(steps):
            if results.stop[0] != 0:
                return STOPPED
            _step(bearing, drive, pairs, time, span / steps, blocks)
            time = begin + (step + 1) * (span / steps)
            counts[STEPS] += balls
            counts[RATES] += balls
            counts[JACOBIANS] += balls
            if step % CHECK_EVERY == CHECK_EVERY - 1 or step == steps - 1:
                from_blocks(blocks, AXIS_DISTANCE, state)
                from_blocks(blocks, ORIENTATION, orientation)
                status = check_all(bearing, time, state, results.failure)
                if status != OK:
                    return status
        if instant < len(times):
            results.states[instant] = state
            results.orientations[instant] = orientation
    from_blocks(blocks, CARRIED_INNER, results.carried)
    return OK
