"""The bearing by an implicit-explicit step: leapfrog for what contacts push, linearly implicit for what resists motion.

Positions take half a step, then the velocities a whole one at the positions in between, then the positions the other
half. Friction and contact damping grow with velocity and are stiff; the velocities therefore take the linearly implicit
midpoint rule, (I - h/2 dF/dv) dv = h F. Second order; elastic contacts limit the step as in leapfrog, friction does
not, but slip that ought to die within a step rings instead (its factor tends to -1).
"""

import math

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.equations import (
    AXIS_DISTANCE,
    COLUMNS,
    HEIGHT,
    LANE_RATES,
    LANES,
    MOTION,
    ORBIT_ANGLE,
    RING_SPEED,
    SPIN,
    VELOCITY,
    add_pair_rates,
    from_lane,
    into_lane,
    lane_vector,
)
from bearing_twin.kinds.bearing.jacobian import JACOBIAN, JACOBIAN_END, lane_jacobian
from bearing_twin.kinds.bearing.rates import lane_rates
from bearing_twin.kinds.bearing.steps import JACOBIANS, OK, RATES, STEPS, check_all
from bearing_twin.numerics.block_solve import Linear, factorise_body, solve_body
from bearing_twin.numerics.rotation import dot, turned

# Rows of the lanes after the Jacobian: integrals, orientation, and the velocities before the step.
KEPT = JACOBIAN_END
ORIENTATION = KEPT + COLUMNS - MOTION
BEFORE = ORIENTATION + 4
ALL_ROWS = BEFORE + 6
CHECK_EVERY = 64


@inlined
def _block(lanes, row, column, k):
    first = JACOBIAN + row * MOTION + column
    return (
        lane_vector(lanes, first, k),
        lane_vector(lanes, first + MOTION, k),
        lane_vector(lanes, first + 2 * MOTION, k),
    )


@kernel
def _drift(h, before, lanes):
    """Moves the positions by h; the orbit angle turns at the radius in the middle of the step, before or after."""
    for k in range(LANES):
        radius, velocity = lanes[AXIS_DISTANCE * LANES + k], lane_vector(lanes, VELOCITY, k)
        moved = radius + h * velocity[0]
        lanes[AXIS_DISTANCE * LANES + k] = moved
        lanes[ORBIT_ANGLE * LANES + k] += h * velocity[1] / (moved if before else radius)
        lanes[HEIGHT * LANES + k] += h * velocity[2]


@kernel
def _kick(h, lanes):
    """The linearly implicit midpoint rule for velocities and angular velocities at fixed positions."""
    g = 0.5 * h
    for k in range(LANES):
        nothing = (0.0, 0.0, 0.0)
        none = (nothing, nothing, nothing)
        linear = Linear(
            0.0,
            0.0,
            none,
            _block(lanes, VELOCITY, VELOCITY, k),
            _block(lanes, VELOCITY, SPIN, k),
            none,
            _block(lanes, SPIN, VELOCITY, k),
            _block(lanes, SPIN, SPIN, k),
        )
        force, torque = lane_vector(lanes, LANE_RATES + VELOCITY, k), lane_vector(lanes, LANE_RATES + SPIN, k)
        doubled = (2.0 * force[0], 2.0 * force[1], 2.0 * force[2])
        turning = (2.0 * torque[0], 2.0 * torque[1], 2.0 * torque[2])
        _, velocity, spin = solve_body(linear, factorise_body(linear, g), g, nothing, doubled, turning)
        for i in range(3):
            lanes[(BEFORE + i) * LANES + k] = lanes[(VELOCITY + i) * LANES + k]
            lanes[(BEFORE + 3 + i) * LANES + k] = lanes[(SPIN + i) * LANES + k]
            row = JACOBIAN + (MOTION + i) * MOTION
            answer = dot(lane_vector(lanes, row + VELOCITY, k), velocity) + dot(lane_vector(lanes, row + SPIN, k), spin)
            rate = lanes[(LANE_RATES + MOTION + i) * LANES + k] + 0.5 * answer
            lanes[(KEPT + i) * LANES + k] += h * rate
        for i in range(3):
            lanes[(VELOCITY + i) * LANES + k] += velocity[i]
            lanes[(SPIN + i) * LANES + k] += spin[i]


@kernel
def _turn(h, lanes):
    """Orientations over a step whose angular velocity changes linearly."""
    for k in range(LANES):
        radius = lanes[AXIS_DISTANCE * LANES + k]
        x, y, z = lane_vector(lanes, ORIENTATION, k)
        first, last = lane_vector(lanes, BEFORE + 3, k), lane_vector(lanes, SPIN, k)
        first = (first[0], first[1], first[2] - lanes[(BEFORE + 1) * LANES + k] / radius)
        last = (last[0], last[1], last[2] - lanes[(VELOCITY + 1) * LANES + k] / radius)
        middle = (0.5 * (first[0] + last[0]), 0.5 * (first[1] + last[1]), 0.5 * (first[2] + last[2]))
        result = turned((x, y, z, lanes[(ORIENTATION + 3) * LANES + k]), first, middle, last, h)
        for part in range(4):
            lanes[(ORIENTATION + part) * LANES + k] = result[part]


@kernel
def _load(state, orientation, blocks):
    for i in range(len(blocks) * LANES):
        ball, lanes, k = min(i, len(state) - 1), blocks[i // LANES], i % LANES
        into_lane(state[ball, :MOTION], lanes, k)
        into_lane(state[ball, MOTION:], lanes[KEPT * LANES :], k)
        into_lane(orientation[ball], lanes[ORIENTATION * LANES :], k)


@kernel
def _unload(blocks, state, orientation):
    for ball in range(len(state)):
        lanes, k = blocks[ball // LANES], ball % LANES
        from_lane(lanes, k, state[ball, :MOTION])
        from_lane(lanes[KEPT * LANES :], k, state[ball, MOTION:])
        from_lane(lanes[ORIENTATION * LANES :], k, orientation[ball])


@kernel
def _push_pairs(bearing, near, blocks, state, rates, orientation):
    """Adds what touching neighbours do to the rates in the lanes, explicitly."""
    _unload(blocks, state, orientation)
    for ball in range(bearing.balls):
        lanes, k = blocks[ball // LANES], ball % LANES
        rates[ball] = 0.0
        add_pair_rates(bearing, near, state, ball, rates)
        for column in range(COLUMNS):
            lanes[(LANE_RATES + column) * LANES + k] += rates[ball, column]


@kernel
def _step(bearing, drive, near, time, h, blocks, state, rates, orientation):
    speed = drive.speed + drive.acceleration * (time + 0.5 * h)
    for block in range(len(blocks)):
        lanes = blocks[block]
        _drift(0.5 * h, True, lanes)
        for k in range(LANES):
            lanes[RING_SPEED * LANES + k] = speed
        lane_rates(bearing, lanes)
        lane_jacobian(bearing.spot, bearing, lanes)
    if np.any(near):
        _push_pairs(bearing, near, blocks, state, rates, orientation)
    for block in range(len(blocks)):
        lanes = blocks[block]
        _kick(h, lanes)
        _turn(h, lanes)
        _drift(0.5 * h, False, lanes)


@kernel
def imex_chunk(bearing, drive, near, times, duration, greatest_step, state, orientation, results):
    """Equal steps between two instants, none longer than `greatest_step` [s]; see the module."""
    balls, counts = bearing.balls, results.counts
    blocks = np.zeros(((balls + LANES - 1) // LANES, ALL_ROWS * LANES))
    rates = np.zeros_like(state)
    _load(state, orientation, blocks)
    time = 0.0
    for instant in range(len(times) + 1):
        goal = times[instant] if instant < len(times) else duration
        begin, span = time, goal - time
        steps = math.ceil(span / greatest_step - 1e-9) if span > 0.0 else 0
        for step in range(steps):
            _step(bearing, drive, near, time, span / steps, blocks, state, rates, orientation)
            time = begin + (step + 1) * (span / steps)
            counts[STEPS] += balls
            counts[RATES] += balls
            counts[JACOBIANS] += balls
            if step % CHECK_EVERY == CHECK_EVERY - 1 or step == steps - 1:
                _unload(blocks, state, orientation)
                status = check_all(bearing, time, state, results.failure)
                if status != OK:
                    return status
        if instant < len(times):
            results.states[instant] = state
            results.orientations[instant] = orientation
    return OK
