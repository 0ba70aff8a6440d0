"""Balls in a row or all around the circle that may touch, side by side in lanes: each with the next ahead.

`Pairs` stands beside the blocks of lanes that hold the balls, ball after ball; the rows of its array are in `layout`.
A ball and the next ahead have frames of their own: what acts on the ball ahead is turned into its frame. The next
behind gets the whole loss of a contact.

Where damping would pull, the load is zero, and what elastic energy is left is lost: a loss that no error of the motion
tells of. So within a chunk the integral of losses takes in what contacts of balls store as well, which makes it the
work of their loads; `add_stored` puts that energy in before, and takes it out of what a chunk gives.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.forces.equations import ball_on_ball
from bearing_twin.kinds.bearing.forces.layout import (
    AHEAD,
    AHEAD_BY_AHEAD,
    AHEAD_BY_OWN,
    AHEAD_PUSH,
    AXIS_DISTANCE,
    DISSIPATED,
    HEIGHT,
    MAY_TOUCH,
    MEETS,
    MOTION,
    MOTION_SPAN,
    ORBIT_ANGLE,
    OWN,
    OWN_BY_AHEAD,
    OWN_BY_OWN,
    OWN_PUSH,
    PAIR_ROWS,
    ROUND,
    SPIN,
    VELOCITY,
    entry,
    put_part,
)
from bearing_twin.kinds.bearing.forces.pair_gradient import pair_gradient
from bearing_twin.numerics.block_solve import negative
from bearing_twin.numerics.lanes import LANES, get, get_vector, increase, new_blocks, put, put_vector
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rotation import about_z, add, cosine_sine, minus, scaled

PUSHES = 8  # rows of OWN_PUSH: of velocity, spin, and the integrals up to DISSIPATED
LOSS = DISSIPATED - VELOCITY
SECOND_HALF = 3 * MOTION  # from the rows of velocity to those of spin in a matrix of answers


class Pairs(NamedTuple):
    """So many balls (`count`), each beside the next, any of which may touch: `blocks` (blocks, PAIR_ROWS * LANES).

    `storing` is 1 where the integral of losses takes in what contacts store, 0 where it does not.
    """

    count: int
    touching: bool
    storing: float
    blocks: np.ndarray


@kernel
def new_pairs(near, balls, storing):
    """The balls numbered in `balls`, one after the other; `near[k]` (N,) says whether ball k may touch the next."""
    count, touching = len(balls), np.any(near)
    blocks = new_blocks(count if touching else 0, PAIR_ROWS)  # zeros in so much memory take as long as two steps
    for place in range(count if touching else 0):
        lanes, k = blocks[place // LANES], place % LANES
        next_one = balls[(place + 1) % count]
        if near[balls[place]] and next_one == (balls[place] + 1) % len(near):
            put(lanes, MAY_TOUCH, k, 1.0)
        if next_one < balls[place]:
            put(lanes, ROUND, k, 2.0 * math.pi)
    return Pairs(count, touching, storing, blocks)


@lean_kernel
def look_ahead(pairs, blocks, row):
    """Copies nine rows from `row` on of each ball to OWN, and of the next ball to AHEAD."""
    for block in range(len(blocks)):
        there, here, following = pairs.blocks[block], blocks[block], blocks[(block + 1) % len(blocks)]
        for i in range(MOTION_SPAN):
            put(there, OWN, i, get(here, row, i))
        for column in range(MOTION):
            for k in range(LANES - 1):
                put(there, AHEAD + column, k, get(here, row + column, k + 1))
            put(there, AHEAD + column, LANES - 1, get(following, row + column, 0))
    last, k = pairs.blocks[(pairs.count - 1) // LANES], (pairs.count - 1) % LANES
    for column in range(MOTION):
        put(last, AHEAD + column, k, get(blocks[0], row + column, 0))


@inlined
def _hand_on(pairs, source, rows, blocks, row):
    """Adds rows from `source` on of each ball to the rows from `row` on of the next ball."""
    end, k = pairs.blocks[(pairs.count - 1) // LANES], (pairs.count - 1) % LANES
    for column in range(rows):
        increase(blocks[0], row + column, 0, get(end, source + column, k))
        put(end, source + column, k, 0.0)
    for block in range(len(blocks)):
        here, there = pairs.blocks[block], blocks[block]
        for column in range(rows):
            for k in range(LANES - 1):
                increase(there, row + column, k + 1, get(here, source + column, k))
            if block + 1 < len(blocks):
                increase(blocks[block + 1], row + column, 0, get(here, source + column, LANES - 1))


@lean_kernel
def _add_pushes(pairs, blocks, row):
    """Adds OWN_PUSH and AHEAD_PUSH to the rows from `row` on, those of velocity and what follows."""
    for block in range(len(blocks)):
        here, there = pairs.blocks[block], blocks[block]
        for i in range(PUSHES * LANES):
            increase(there, row, i, get(here, OWN_PUSH, i))
    _hand_on(pairs, AHEAD_PUSH, 6, blocks, row)


@inlined
def _meeting(lanes, k):
    """Cosine and sine of the angle to the ball ahead, and its position, velocity and spin in the ball's frame."""
    angle = get(lanes, AHEAD + ORBIT_ANGLE, k) + get(lanes, ROUND, k) - get(lanes, OWN + ORBIT_ANGLE, k)
    cosine, sine = cosine_sine(angle)
    position = about_z(cosine, sine, (get(lanes, AHEAD + AXIS_DISTANCE, k), 0.0, get(lanes, AHEAD + HEIGHT, k)))
    velocity = about_z(cosine, sine, get_vector(lanes, AHEAD + VELOCITY, k))
    return cosine, sine, position, velocity, about_z(cosine, sine, get_vector(lanes, AHEAD + SPIN, k))


@inlined
def _own_position(lanes, k):
    return (get(lanes, OWN + AXIS_DISTANCE, k), 0.0, get(lanes, OWN + HEIGHT, k))


@lean_kernel
def _pushes(bearing, storing, lanes):
    """Fills OWN_PUSH and AHEAD_PUSH with what balls do to each other's rates."""
    inverse_mass, inverse_inertia = 1.0 / bearing.ball_mass, 1.0 / bearing.ball_inertia
    for k in range(LANES):
        cosine, sine, position, velocity, spin = _meeting(lanes, k)
        contact = ball_on_ball(
            bearing,
            get(lanes, MAY_TOUCH, k) > 0.0,
            minus(position, _own_position(lanes, k)),
            minus(get_vector(lanes, OWN + VELOCITY, k), velocity),
            add(get_vector(lanes, OWN + SPIN, k), spin),
        )
        acceleration, turning = scaled(inverse_mass, contact.force), scaled(inverse_inertia, contact.torque)
        put_vector(lanes, OWN_PUSH, k, acceleration)
        put_vector(lanes, OWN_PUSH + 3, k, turning)
        put(lanes, OWN_PUSH + LOSS, k, contact.dissipation + storing * contact.storing)
        put_vector(lanes, AHEAD_PUSH, k, about_z(cosine, -sine, scaled(-1.0, acceleration)))
        put_vector(lanes, AHEAD_PUSH + 3, k, about_z(cosine, -sine, turning))


@lean_kernel
def add_pairs(bearing, pairs, motions, rates, row):
    """Adds what balls do to each other to the rates that begin at `row` of the blocks `rates`.

    The balls' motion begins the blocks `motions`.
    """
    look_ahead(pairs, motions, AXIS_DISTANCE)
    for block in range(len(pairs.blocks)):
        _pushes(bearing, pairs.storing, pairs.blocks[block])
    _add_pushes(pairs, rates, row + VELOCITY)


@inlined
def _turned_rows(cosine, sine, block):
    """A 3 x 3 block whose answer is turned by the angle of that cosine and sine."""
    return (
        minus(scaled(cosine, block[0]), scaled(sine, block[1])),
        add(scaled(sine, block[0]), scaled(cosine, block[1])),
        block[2],
    )


@inlined
def _turned_columns(cosine, sine, block):
    """A 3 x 3 block that takes vectors of a frame turned ahead by that angle."""
    return (
        about_z(cosine, -sine, block[0]),
        about_z(cosine, -sine, block[1]),
        about_z(cosine, -sine, block[2]),
    )


@inlined
def _place_columns(block, turn):
    """A block by x, y, z with the column of y replaced by `turn`: by axis distance, orbit angle and height."""
    return (
        (block[0][0], turn[0], block[0][2]),
        (block[1][0], turn[1], block[1][2]),
        (block[2][0], turn[2], block[2][2]),
    )


@inlined
def _times(factor, block):
    return (scaled(factor, block[0]), scaled(factor, block[1]), scaled(factor, block[2]))


@inlined
def _put_three(lanes, first, k, by_place, by_velocity, by_spin):
    """Writes three rows of answers to a motion."""
    put_part(lanes, first, k, by_place)
    put_part(lanes, first + VELOCITY, k, by_velocity)
    put_part(lanes, first + SPIN, k, by_spin)


@inlined
def _put_answers(lanes, half, k, cosine, sine, own, ahead, value, by_place, by_velocity, by_spin, turn):
    """Writes how a force or torque `value` answers, times `own` for the ball and times `ahead` for the one ahead."""
    away, nearer = _turned_columns(cosine, sine, by_place), negative(by_place)
    velocity, spin = negative(_turned_columns(cosine, sine, by_velocity)), _turned_columns(cosine, sine, by_spin)
    back = scaled(-1.0, turn)
    _put_three(
        lanes, OWN_BY_OWN + half, k,
        _times(own, _place_columns(nearer, back)), _times(own, by_velocity), _times(own, by_spin),
    )  # fmt: skip
    _put_three(
        lanes, OWN_BY_AHEAD + half, k,
        _times(own, _place_columns(away, turn)), _times(own, velocity), _times(own, spin),
    )  # fmt: skip
    # In the frame of the ball ahead, which turns with it: d(R^T X) = R^T (dX - z x X).
    turn = minus(turn, (-value[1], value[0], 0.0))
    back = scaled(-1.0, turn)
    _put_three(
        lanes, AHEAD_BY_OWN + half, k,
        _times(ahead, _turned_rows(cosine, -sine, _place_columns(nearer, back))),
        _times(ahead, _turned_rows(cosine, -sine, by_velocity)),
        _times(ahead, _turned_rows(cosine, -sine, by_spin)),
    )  # fmt: skip
    _put_three(
        lanes, AHEAD_BY_AHEAD + half, k,
        _times(ahead, _turned_rows(cosine, -sine, _place_columns(away, turn))),
        _times(ahead, _turned_rows(cosine, -sine, velocity)),
        _times(ahead, _turned_rows(cosine, -sine, spin)),
    )  # fmt: skip


@inlined
def _put_loss(lanes, first, k, by_place, turn, by_velocity, by_spin):
    put_vector(lanes, first + LOSS * MOTION, k, (by_place[0], turn, by_place[2]))
    put_vector(lanes, first + LOSS * MOTION + VELOCITY, k, by_velocity)
    put_vector(lanes, first + LOSS * MOTION + SPIN, k, by_spin)


@lean_kernel
def _answers(bearing, lanes):
    """Fills the rows of how what balls do to each other answers to either's motion, and of whether they touch."""
    inverse_mass, inverse_inertia = 1.0 / bearing.ball_mass, 1.0 / bearing.ball_inertia
    for k in range(LANES):
        cosine, sine, position, velocity, spin = _meeting(lanes, k)
        turn = ((-position[1], position[0], 0.0), (velocity[1], -velocity[0], 0.0), (-spin[1], spin[0], 0.0))
        contact, by = pair_gradient(
            bearing,
            get(lanes, MAY_TOUCH, k) > 0.0,
            minus(position, _own_position(lanes, k)),
            minus(get_vector(lanes, OWN + VELOCITY, k), velocity),
            add(get_vector(lanes, OWN + SPIN, k), spin),
            turn,
        )
        put(lanes, MEETS, k, 1.0 if contact.approach > 0.0 else 0.0)
        _put_answers(
            lanes, 0, k, cosine, sine, inverse_mass, -inverse_mass,
            contact.force, by.force_p, by.force_v, by.force_s, by.force_turn,
        )  # fmt: skip
        _put_answers(
            lanes, SECOND_HALF, k, cosine, sine, inverse_inertia, inverse_inertia,
            contact.torque, by.torque_p, by.torque_v, by.torque_s, by.torque_turn,
        )  # fmt: skip
        _put_loss(lanes, OWN_BY_OWN, k, scaled(-1.0, by.loss_p), -by.loss_turn, by.loss_v, by.loss_s)
        away, pulled = about_z(cosine, -sine, by.loss_p), about_z(cosine, -sine, scaled(-1.0, by.loss_v))
        _put_loss(lanes, OWN_BY_AHEAD, k, away, by.loss_turn, pulled, about_z(cosine, -sine, by.loss_s))


@lean_kernel
def add_answers(bearing, pairs, blocks):
    """Adds to the Jacobians of balls, after `add_pairs` at the same motion, how contacts of balls answer to theirs."""
    for block in range(len(blocks)):
        here, there = pairs.blocks[block], blocks[block]
        _answers(bearing, here)
        for i in range(PUSHES * MOTION_SPAN):
            increase(there, entry(VELOCITY, AXIS_DISTANCE), i, get(here, OWN_BY_OWN, i))
    _hand_on(pairs, AHEAD_BY_AHEAD, 6 * MOTION, blocks, entry(VELOCITY, AXIS_DISTANCE))
