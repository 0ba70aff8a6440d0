"""The bearing by an implicit-explicit step: leapfrog for what contacts push, linearly implicit for what resists motion.

Positions take half a step, then the velocities a whole one at the positions in between, then the positions the other
half. Friction and contact damping grow with velocity and are stiff; the velocities therefore take the linearly implicit
midpoint rule, (I - h/2 dF/dv) dv = h F. Second order; elastic contacts limit the step as in leapfrog, friction does
not, but slip that ought to die within a step rings instead (its factor tends to -1).
"""

from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.forces.carried import carry_on
from bearing_twin.kinds.bearing.forces.equations import Bearing, RingDrive
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    CARRIED_INNER,
    FIRST_SPIN,
    HEIGHT,
    IMEX_ROWS,
    MOTION,
    ORBIT_ANGLE,
    ORIENTATION,
    SPIN,
    SPIN_SUM,
    VELOCITY,
)
from bearing_twin.kinds.bearing.forces.pairs import Pairs, add_pairs, new_pairs
from bearing_twin.kinds.bearing.forces.rates import put_ring_speed
from bearing_twin.kinds.bearing.forces.resistance import lane_change, lane_resistance, rates_and_resistance
from bearing_twin.kinds.bearing.forces.ring_seat import put_still_ring
from bearing_twin.kinds.bearing.stepping.steps import check_all, lane_spin
from bearing_twin.numerics.block_solve import factorise_motion, solve_motion
from bearing_twin.numerics.lanes import (
    COLUMNS,
    LANE_RATES,
    LANES,
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
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.lockstep import Pace, advance_together
from bearing_twin.numerics.rotation import add, minus, scaled, turned
from bearing_twin.numerics.statuses import EVALUATIONS, JACOBIANS, OK


@inlined
def _drift(h, before, lanes):
    """Moves the positions by h; the orbit angle turns at the radius in the middle of the step, before or after."""
    for k in range(LANES):
        radius, velocity = get(lanes, AXIS_DISTANCE, k), get_vector(lanes, VELOCITY, k)
        moved = radius + h * velocity[0]
        put(lanes, AXIS_DISTANCE, k, moved)
        increase(lanes, ORBIT_ANGLE, k, h * velocity[1] / (moved if before else radius))
        increase(lanes, HEIGHT, k, h * velocity[2])


@inlined
def _kick(h, lanes):
    """The linearly implicit midpoint rule for velocities and angular velocities at fixed positions."""
    g = 0.5 * h
    for k in range(LANES):
        vv, vs, sv, ss = lane_resistance(lanes, k)
        velocities, coupling, schur = factorise_motion(g, vv, vs, sv, ss)
        force = scaled(2.0, get_vector(lanes, LANE_RATES + VELOCITY, k))
        torque = scaled(2.0, get_vector(lanes, LANE_RATES + SPIN, k))
        velocity, spin = solve_motion(velocities, coupling, sv, schur, force, torque)
        for integral in range(MOTION, COLUMNS):
            answer = lane_change(lanes, integral, k, velocity, spin)
            increase(lanes, integral, k, h * (get(lanes, LANE_RATES + integral, k) + 0.5 * answer))
        increase_vector(lanes, VELOCITY, k, velocity)
        increase_vector(lanes, SPIN, k, spin)


@inlined
def _gather_spin(lanes):
    """Adds the angular velocity at the end of a step to the sum of those since the balls were turned last."""
    for k in range(LANES):
        increase_vector(lanes, SPIN_SUM, k, lane_spin(lanes, AXIS_DISTANCE, k))


@lean_kernel
def _turn_since(h, steps, blocks):
    """Turns the balls over the equal steps since they were turned last, by the trapezoidal mean of their spin."""
    for block in range(len(blocks)):
        lanes = blocks[block]
        for k in range(LANES):
            first, last = get_vector(lanes, FIRST_SPIN, k), lane_spin(lanes, AXIS_DISTANCE, k)
            ends = scaled(0.5, minus(first, last))
            mean = scaled(1.0 / steps, add(get_vector(lanes, SPIN_SUM, k), ends))
            middle = scaled(0.25, minus(scaled(6.0, mean), add(first, last)))  # of which `turned` finds that mean
            quaternion = turned(get_quaternion(lanes, ORIENTATION, k), first, middle, last, steps * h)
            put_quaternion(lanes, ORIENTATION, k, quaternion)
        _begin_turning(lanes)


@inlined
def _begin_turning(lanes):
    """Notes the spin from which the balls turn next."""
    for k in range(LANES):
        put_vector(lanes, FIRST_SPIN, k, lane_spin(lanes, AXIS_DISTANCE, k))
        put_vector(lanes, SPIN_SUM, k, (0.0, 0.0, 0.0))


class ImexWork(NamedTuple):
    """What steps are made of: what moves, and the lanes it moves in."""

    bearing: Bearing
    drive: RingDrive
    pairs: Pairs
    counts: np.ndarray
    blocks: np.ndarray


@inlined
def _one_step(run, time, h, begun):
    """A step, which has no estimate of its error; what balls do to each other is taken explicitly."""
    bearing, pairs, blocks = run.bearing, run.pairs, run.blocks
    for block in range(len(blocks)):
        lanes = blocks[block]
        _drift(0.5 * h, True, lanes)
        put_ring_speed(run.drive, time + 0.5 * h, lanes)
        put_still_ring(bearing.ring, bearing, lanes)
        rates_and_resistance(bearing.spot, bearing.ring, bearing, lanes)
    if pairs.touching:
        add_pairs(bearing, pairs, blocks, blocks, LANE_RATES)
    for block in range(len(blocks)):
        lanes = blocks[block]
        _kick(h, lanes)
        _drift(0.5 * h, False, lanes)
        _gather_spin(lanes)
        carry_on(bearing, lanes, AXIS_DISTANCE, lanes)
    run.counts[EVALUATIONS] += bearing.balls
    run.counts[JACOBIANS] += bearing.balls
    return 0.0


@inlined
def _whose(run):
    """A ball: where steps have no error none is refused."""
    return 0


@inlined
def _move_on(run, fresh):
    """Nothing: a step leaves its end where the next one starts."""


@inlined
def _turn(run, seconds, step, steps):
    _turn_since(step, steps, run.blocks)


@inlined
def _keep(run, state, orientation):
    from_blocks(run.blocks, AXIS_DISTANCE, state)
    from_blocks(run.blocks, ORIENTATION, orientation)


@lean_kernel
def _advance(run, pace, times, duration, state, orientation, results):
    """`imex_chunk` in the room it has made."""
    for block in range(len(run.blocks)):
        _begin_turning(run.blocks[block])
    return advance_together(
        _one_step, _whose, _move_on, _turn, _keep, check_all,
        run, pace, times, duration, run.bearing.balls, state, orientation, results,
    )[0]  # fmt: skip


@kernel
def imex_chunk(bearing, drive, near, times, duration, greatest_step, state, orientation, results):
    """Equal steps between two instants, none longer than `greatest_step` [s]; see the module."""
    blocks, pairs = new_blocks(bearing.balls, IMEX_ROWS), new_pairs(near, np.arange(bearing.balls), 0.0)
    into_blocks(state, blocks, AXIS_DISTANCE)
    into_blocks(orientation, blocks, ORIENTATION)
    into_blocks(results.carried, blocks, CARRIED_INNER)
    run, pace = ImexWork(bearing, drive, pairs, results.counts, blocks), Pace(greatest_step, 0, True)
    status = _advance(run, pace, times, duration, state, orientation, results)
    if status == OK:
        from_blocks(blocks, CARRIED_INNER, results.carried)
    return status
