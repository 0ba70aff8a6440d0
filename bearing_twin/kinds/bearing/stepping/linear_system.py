"""The linear systems of a linearly implicit step: of balls alone, each its own, and of balls that are coupled.

Positions are eliminated first. Of coupled balls a tile of 6 x 6 is then left of each and of each of its neighbours; in
a ring of balls that is closed the last ball is the system's border (`numerics.chain_solve`).
"""

from typing import NamedTuple

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.forces import border_rows as at
from bearing_twin.kinds.bearing.forces.jacobian import integral_answers, lane_linear, put_integrals
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    FACTOR_BELOW,
    FACTOR_COUPLING,
    FACTOR_INVERSE,
    FACTOR_RADIUS,
    FACTOR_SCHUR,
    FACTOR_VELOCITY,
    LOWER,
    MEETS,
    PLACES,
    SPIN,
    SYSTEM,
    UPPER,
    VELOCITY,
)
from bearing_twin.kinds.bearing.forces.pairs import Pairs, add_answers, new_pairs
from bearing_twin.kinds.bearing.stepping.border import Border, new_border
from bearing_twin.kinds.bearing.stepping.border_apart import solve_apart
from bearing_twin.kinds.bearing.stepping.border_solve import border_tiles, factorise_border, put_border_tiles
from bearing_twin.kinds.bearing.stepping.border_system import border_follow, border_jacobian, border_known, still_balls
from bearing_twin.kinds.bearing.stepping.pair_system import add_known, add_losses, pair_tiles
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
from bearing_twin.numerics.lanes import (
    GAIN,
    LANES,
    RIGHT,
    SOLUTION,
    get,
    get_block,
    get_vector,
    put,
    put_block,
    put_tile_part,
    put_vector,
)
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rotation import add


class Coupling(NamedTuple):
    """What couples balls of one step: contacts with each other, ring and cage, and the linear system of all.

    In a ring of balls that is closed the last ball is the first block of the system's border; ring and cage, where they
    move, are the last.
    """

    pairs: Pairs
    chain: chain_solve.Chain
    border: Border


@kernel
def new_coupling(near, balls, partners, state):
    """The coupling of the balls numbered in `balls`, one after the other; `near` as for `new_pairs`.

    `state` (BORDER,) is that of the `partners`, ring and cage.
    """
    closed = 1 if near[balls[-1]] and len(balls) == len(near) else 0
    pairs, blocks = new_pairs(near, balls, 1.0), closed + (1 if partners.active else 0)
    chain = chain_solve.new_chain(len(balls) - closed if pairs.touching else 0, blocks)
    return Coupling(pairs, chain, new_border(partners, len(balls), state))


@lean_kernel
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


@lean_kernel
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
        put_integrals(g, lanes, k, *integral_answers(lanes, k, position, velocity, spin))


@lean_kernel
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
def couple_jacobians(pockets, bearing, drive, time, coupling, blocks):
    """Adds to the Jacobians of balls alone what balls, ring and cage are to each other.

    `pockets` are the bearing's; after the rates at the same motion.
    """
    if coupling.pairs.touching:
        add_answers(bearing, coupling.pairs, blocks)
    if coupling.border.active:
        border_jacobian(pockets, bearing, drive, coupling.border, time, blocks)


@inlined
def factorise_together(coupling, blocks):
    """Factors of the linear system of all balls, ring and cage."""
    if coupling.pairs.touching:
        _factorise_chain(coupling, blocks)
    else:
        for block in range(len(blocks)):
            factorise_alone(blocks[block])
        factorise_border(get(blocks[0], GAIN, 0), coupling.border, blocks)


@lean_kernel
def _factorise_chain(coupling, blocks):
    """Factors where balls touch."""
    pairs, chain, border = coupling.pairs, coupling.chain, coupling.border
    tiles, bodies, g = chain.tiles, chain.bodies, get(blocks[0], GAIN, 0)
    chain_solve.begin_anew(chain)
    for block in range(len(blocks)):
        _system(blocks[block])
        pair_tiles(g, pairs.blocks[block])
        if border.active:
            border_tiles(g, border, blocks[block])
    if border.active:
        put_border_tiles(g, border, chain, blocks)
    for place in range(pairs.count):
        lanes, pair, k = blocks[place // LANES], pairs.blocks[place // LANES], place % LANES
        own = chain_solve.corner_tile(chain, 0, 0) if place == bodies else chain_solve.own_tile(place)
        chain_solve.copy_tile(lanes, SYSTEM, k, tiles[own])
        if not get(pair, MEETS, k) > 0.0:
            continue
        if place == bodies:
            upper, lower = chain_solve.row_tile(chain, 0, 0), chain_solve.column_tile(chain, 0, 0)
            chain.meets[0, 1] = True
        elif place + 1 < bodies:
            upper, lower = chain_solve.ahead_tile(place), chain_solve.behind_tile(place)
            chain.meets[place, 0] = True
        else:
            upper, lower = chain_solve.column_tile(chain, place, 0), chain_solve.row_tile(chain, 0, place)
            chain.meets[place, 1] = True
        chain_solve.copy_tile(pair, UPPER, k, tiles[upper])
        chain_solve.copy_tile(pair, LOWER, k, tiles[lower])
    chain_solve.factorise_chain(chain)


@lean_kernel
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


@lean_kernel
def _follow(lanes):
    """The positions of a stage by its velocities, and the integrals by both."""
    for k in range(LANES):
        g, velocity = get(lanes, GAIN, k), get_vector(lanes, SOLUTION + VELOCITY, k)
        turn = get(lanes, FACTOR_RADIUS, k) * velocity[0] + get(lanes, FACTOR_VELOCITY, k) * velocity[1]
        position = add(get_vector(lanes, SOLUTION + AXIS_DISTANCE, k), (g * velocity[0], turn, g * velocity[2]))
        put_vector(lanes, SOLUTION + AXIS_DISTANCE, k, position)
        spin = get_vector(lanes, SOLUTION + SPIN, k)
        put_integrals(g, lanes, k, *integral_answers(lanes, k, position, velocity, spin))


@lean_kernel
def _solve_chain(coupling, blocks):
    """Velocities and spins of balls that touch, and velocities of the border, from what is known."""
    pairs, right, border = coupling.pairs, coupling.chain.right, coupling.border
    last = len(right) - 1
    if border.active:
        for i in range(chain_solve.SIDE):
            right[last, i] = border.numbers[at.SOLUTION + PLACES + i]
    for place in range(pairs.count):
        for i in range(chain_solve.SIDE):
            right[place, i] = get(blocks[place // LANES], SOLUTION + VELOCITY + i, place % LANES)
    chain_solve.solve_chain(coupling.chain)
    for place in range(len(blocks) * LANES):
        for i in range(chain_solve.SIDE):
            solved = right[place, i] if place < pairs.count else 0.0
            put(blocks[place // LANES], SOLUTION + VELOCITY + i, place % LANES, solved)
    if border.active:
        for i in range(chain_solve.SIDE):
            border.numbers[at.SOLUTION + PLACES + i] = right[last, i]


@lean_kernel
def _solve_touching(drive, time, coupling, blocks):
    """`solve_together` where balls touch."""
    pairs, border, g = coupling.pairs, coupling.border, get(blocks[0], GAIN, 0)
    still_balls(border, blocks)
    for block in range(len(blocks)):
        _known(blocks[block])
    add_known(pairs, blocks, SOLUTION)
    if border.active:
        border_known(g, border, blocks)
    _solve_chain(coupling, blocks)
    for block in range(len(blocks)):
        _follow(blocks[block])
    add_losses(g, pairs, blocks, SOLUTION)
    if border.active:
        border_follow(g, drive, time, border, blocks)


@inlined
def solve_together(drive, time, coupling, blocks):
    """Solves W k = right for one stage of balls, ring and cage: the motion, then the integrals that only listen."""
    if coupling.pairs.touching:
        _solve_touching(drive, time, coupling, blocks)
    else:
        solve_apart(get(blocks[0], GAIN, 0), drive, time, coupling.border, blocks)
