"""The linear systems of a linearly implicit step: of balls alone, each its own, and of balls that are coupled.

Positions are eliminated first. Of coupled balls a tile of 6 x 6 is then left of each and of each of its neighbours; in
a ring of balls that is closed the last ball is the system's border (`numerics.chain_solve`).
"""

from typing import NamedTuple

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.jacobian import lane_answer, lane_linear
from bearing_twin.kinds.bearing.layout import (
    AHEAD,
    AHEAD_BY_OWN,
    AHEAD_PUSH,
    AXIS_DISTANCE,
    COLUMNS,
    DISSIPATED,
    FACTOR_BELOW,
    FACTOR_COUPLING,
    FACTOR_INVERSE,
    FACTOR_RADIUS,
    FACTOR_SCHUR,
    FACTOR_VELOCITY,
    GAIN,
    LANES,
    LOWER,
    MOTION,
    OWN,
    OWN_BY_AHEAD,
    OWN_PUSH,
    RIGHT,
    SOLUTION,
    SPIN,
    SYSTEM,
    TANGENTIAL_VELOCITY,
    UPPER,
    VELOCITY,
    get,
    get_block,
    get_part,
    get_vector,
    increase,
    put,
    put_block,
    put_tile_part,
    put_vector,
)
from bearing_twin.kinds.bearing.pairs import LOSS, SECOND_HALF, Pairs, add_pushes, look_ahead, new_pairs
from bearing_twin.numerics import chain_solve
from bearing_twin.numerics.block_solve import (
    Factors,
    behind,
    factorise_body,
    minus_block,
    negative,
    plus,
    solve_body,
    times,
)
from bearing_twin.numerics.rotation import add, dot


class Coupling(NamedTuple):
    """What couples balls of one step: contacts with each other, and the linear system of all.

    In a ring of balls that is closed the last ball is the system's border.
    """

    pairs: Pairs
    chain: chain_solve.Chain


@kernel
def new_coupling(near, balls):
    """The coupling of the balls numbered in `balls`, one after the other; `near` as for `new_pairs`."""
    closed = 1 if near[balls[-1]] and len(balls) == len(near) else 0
    return Coupling(new_pairs(near, balls), chain_solve.new_chain(len(balls) - closed, closed))


@kernel
def factorise_alone(lanes):
    """Factors of every lane's Jacobian, each with its own step."""
    for k in range(LANES):
        found = factorise_body(lane_linear(lanes, k), get(lanes, GAIN, k))
        put(lanes, FACTOR_RADIUS, k, found.turning[0])
        put(lanes, FACTOR_VELOCITY, k, found.turning[1])
        put_block(lanes, FACTOR_INVERSE, k, found.inverse)
        put_block(lanes, FACTOR_COUPLING, k, found.coupling)
        put_block(lanes, FACTOR_BELOW, k, found.below)
        put_block(lanes, FACTOR_SCHUR, k, found.schur)


@kernel
def solve_alone(lanes):
    """Solves W k = right for one stage of all lanes: the motion, then the integrals that only listen."""
    for k in range(LANES):
        g = get(lanes, GAIN, k)
        factors = Factors(
            turning=(get(lanes, FACTOR_RADIUS, k), get(lanes, FACTOR_VELOCITY, k)),
            inverse=get_block(lanes, FACTOR_INVERSE, k),
            coupling=get_block(lanes, FACTOR_COUPLING, k),
            below=get_block(lanes, FACTOR_BELOW, k),
            schur=get_block(lanes, FACTOR_SCHUR, k),
        )
        position, velocity, spin = solve_body(
            lane_linear(lanes, k),
            factors,
            g,
            get_vector(lanes, RIGHT + AXIS_DISTANCE, k),
            get_vector(lanes, RIGHT + VELOCITY, k),
            get_vector(lanes, RIGHT + SPIN, k),
        )
        put_vector(lanes, SOLUTION + AXIS_DISTANCE, k, position)
        put_vector(lanes, SOLUTION + VELOCITY, k, velocity)
        put_vector(lanes, SOLUTION + SPIN, k, spin)
        for integral in range(MOTION, COLUMNS):
            answer = lane_answer(lanes, integral, k, position, velocity, spin)
            put(lanes, SOLUTION + integral, k, g * (get(lanes, RIGHT + integral, k) + answer))


@inlined
def _put_tile(lanes, first, source, k, g, turning):
    """Writes minus the answers from row `source` on as a tile by velocity and spin alone."""
    for row in range(0, 6, 3):
        at = source + row * MOTION
        by_velocity = plus(get_part(lanes, at + VELOCITY, k), behind(get_part(lanes, at, k), g, turning))
        put_tile_part(lanes, first, row, 0, k, negative(by_velocity))
        put_tile_part(lanes, first, row, 3, k, negative(get_part(lanes, at + SPIN, k)))


@inlined
def _turning(g, lanes, ball, k):
    """How the orbit angle of the ball from row `ball` on follows its velocities (`block_solve.Factors`)."""
    inverse = 1.0 / (get(lanes, ball + AXIS_DISTANCE, k) + 1e-300)
    return (-g * g * get(lanes, ball + TANGENTIAL_VELOCITY, k) * inverse * inverse, g * inverse)


@kernel
def _pair_tiles(g, lanes):
    """Fills UPPER and LOWER, how a ball's velocity and spin answer to the next one's, and the other way round."""
    for k in range(LANES):
        _put_tile(lanes, UPPER, OWN_BY_AHEAD, k, g, _turning(g, lanes, AHEAD, k))
        _put_tile(lanes, LOWER, AHEAD_BY_OWN, k, g, _turning(g, lanes, OWN, k))


@inlined
def _by_place(lanes, first, k, ball):
    """What three rows of answers from `first` on make of the positions of the ball from row `ball` on."""
    return times(get_part(lanes, first, k), get_vector(lanes, ball + AXIS_DISTANCE, k))


@kernel
def _add_known(pairs, blocks, row):
    """Adds what known changes of position, in the first rows from `row` on, do to the neighbours' right-hand sides."""
    look_ahead(pairs, blocks, row)
    for block in range(len(blocks)):
        lanes = pairs.blocks[block]
        for k in range(LANES):
            put_vector(lanes, OWN_PUSH, k, _by_place(lanes, OWN_BY_AHEAD, k, AHEAD))
            put_vector(lanes, OWN_PUSH + 3, k, _by_place(lanes, OWN_BY_AHEAD + SECOND_HALF, k, AHEAD))
            put(lanes, OWN_PUSH + LOSS, k, 0.0)
            put_vector(lanes, AHEAD_PUSH, k, _by_place(lanes, AHEAD_BY_OWN, k, OWN))
            put_vector(lanes, AHEAD_PUSH + 3, k, _by_place(lanes, AHEAD_BY_OWN + SECOND_HALF, k, OWN))
    add_pushes(pairs, blocks, row + VELOCITY)


@kernel
def _add_losses(g, pairs, blocks, row):
    """Adds g times the loss by the motion of the ball ahead to the row of losses of the motions from `row` on."""
    look_ahead(pairs, blocks, row)
    for block in range(len(blocks)):
        here, there = pairs.blocks[block], blocks[block]
        for k in range(LANES):
            first = OWN_BY_AHEAD + LOSS * MOTION
            loss = (
                dot(get_vector(here, first, k), get_vector(here, AHEAD + AXIS_DISTANCE, k))
                + dot(get_vector(here, first + VELOCITY, k), get_vector(here, AHEAD + VELOCITY, k))
                + dot(get_vector(here, first + SPIN, k), get_vector(here, AHEAD + SPIN, k))
            )
            put(here, OWN_PUSH + LOSS, k, g * loss)
        for k in range(LANES):
            increase(there, row + DISSIPATED, k, get(here, OWN_PUSH + LOSS, k))


@kernel
def _system(lanes):
    """The tile of every lane's own 1/g - J, without positions, and how its orbit angle follows its velocities."""
    for k in range(LANES):
        linear, g = lane_linear(lanes, k), get(lanes, GAIN, k)
        one = 1.0 / g
        turning = (g * g * linear.angle_by_radius, g * linear.angle_by_velocity)
        put(lanes, FACTOR_RADIUS, k, turning[0])
        put(lanes, FACTOR_VELOCITY, k, turning[1])
        diagonal = ((one, 0.0, 0.0), (0.0, one, 0.0), (0.0, 0.0, one))
        velocity = plus(linear.vv, behind(linear.vp, g, turning))
        put_tile_part(lanes, SYSTEM, 0, 0, k, minus_block(diagonal, velocity))
        put_tile_part(lanes, SYSTEM, 0, 3, k, negative(linear.vs))
        put_tile_part(lanes, SYSTEM, 3, 0, k, negative(plus(linear.sv, behind(linear.sp, g, turning))))
        put_tile_part(lanes, SYSTEM, 3, 3, k, minus_block(diagonal, linear.ss))


@inlined
def _fill_tile(lanes, row, k, tile):
    for i in range(chain_solve.SIDE * chain_solve.SIDE):
        tile[i] = get(lanes, row + i, k)


@kernel
def factorise_together(coupling, blocks):
    """Factors of the linear system of all balls."""
    pairs, chain = coupling.pairs, coupling.chain
    tiles, bodies = chain.tiles, chain.bodies
    for block in range(len(blocks)):
        _system(blocks[block])
        _pair_tiles(get(blocks[0], GAIN, 0), pairs.blocks[block])
    tiles[:] = 0.0
    for place in range(pairs.count):
        lanes, pair, k = blocks[place // LANES], pairs.blocks[place // LANES], place % LANES
        if place == bodies:
            _fill_tile(lanes, SYSTEM, k, tiles[chain_solve.corner_tile(chain, 0, 0)])
            _fill_tile(pair, UPPER, k, tiles[chain_solve.row_tile(chain, 0, 0)])
            _fill_tile(pair, LOWER, k, tiles[chain_solve.column_tile(chain, 0, 0)])
            continue
        _fill_tile(lanes, SYSTEM, k, tiles[chain_solve.own_tile(place)])
        if place + 1 < bodies:
            _fill_tile(pair, UPPER, k, tiles[chain_solve.ahead_tile(place)])
            _fill_tile(pair, LOWER, k, tiles[chain_solve.behind_tile(place)])
        elif place + 1 < pairs.count:
            _fill_tile(pair, UPPER, k, tiles[chain_solve.column_tile(chain, place, 0)])
            _fill_tile(pair, LOWER, k, tiles[chain_solve.row_tile(chain, 0, place)])
    chain_solve.factorise_chain(chain)


@kernel
def _known(lanes):
    """What is known of a stage before it is solved: changes of position, and the right-hand side of the rest."""
    for k in range(LANES):
        linear, g = lane_linear(lanes, k), get(lanes, GAIN, k)
        right = get_vector(lanes, RIGHT + AXIS_DISTANCE, k)
        radius = g * right[0]
        known = (radius, g * (right[1] + linear.angle_by_radius * radius), g * right[2])
        put_vector(lanes, SOLUTION + AXIS_DISTANCE, k, known)
        velocity = add(get_vector(lanes, RIGHT + VELOCITY, k), times(linear.vp, known))
        put_vector(lanes, SOLUTION + VELOCITY, k, velocity)
        put_vector(lanes, SOLUTION + SPIN, k, add(get_vector(lanes, RIGHT + SPIN, k), times(linear.sp, known)))


@kernel
def _follow(lanes):
    """The positions of a stage by its velocities, and the integrals by both."""
    for k in range(LANES):
        g, velocity = get(lanes, GAIN, k), get_vector(lanes, SOLUTION + VELOCITY, k)
        turn = get(lanes, FACTOR_RADIUS, k) * velocity[0] + get(lanes, FACTOR_VELOCITY, k) * velocity[1]
        position = add(get_vector(lanes, SOLUTION + AXIS_DISTANCE, k), (g * velocity[0], turn, g * velocity[2]))
        put_vector(lanes, SOLUTION + AXIS_DISTANCE, k, position)
        spin = get_vector(lanes, SOLUTION + SPIN, k)
        for integral in range(MOTION, COLUMNS):
            answer = lane_answer(lanes, integral, k, position, velocity, spin)
            put(lanes, SOLUTION + integral, k, g * (get(lanes, RIGHT + integral, k) + answer))


@kernel
def solve_together(coupling, blocks):
    """Solves W k = right for one stage of all balls: the motion, then the integrals that only listen."""
    pairs, right = coupling.pairs, coupling.chain.right
    for block in range(len(blocks)):
        _known(blocks[block])
    _add_known(pairs, blocks, SOLUTION)
    for place in range(pairs.count):
        for i in range(chain_solve.SIDE):
            right[place, i] = get(blocks[place // LANES], SOLUTION + VELOCITY + i, place % LANES)
    chain_solve.solve_chain(coupling.chain)
    for place in range(len(blocks) * LANES):
        for i in range(chain_solve.SIDE):
            solved = right[place, i] if place < pairs.count else 0.0
            put(blocks[place // LANES], SOLUTION + VELOCITY + i, place % LANES, solved)
    for block in range(len(blocks)):
        _follow(blocks[block])
    _add_losses(get(blocks[0], GAIN, 0), pairs, blocks, SOLUTION)
