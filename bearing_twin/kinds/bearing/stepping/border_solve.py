"""The linear system of balls that meet only in ring and cage: each ball by itself, in lanes, then the border.

The border's Schur complement C - sum V_j B_j^-1 U_j is summed over the balls and solved as one small tile. Balls that
touch each other, too, are solved by `chain_solve`, to which the same tiles are handed.
"""

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces import border_rows as at
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    BALL_BY_BORDER,
    BALL_TILE,
    BORDER_BY_BALL,
    BORDER_TILE,
    CAGE,
    FACTOR_BELOW,
    FACTOR_COUPLING,
    FACTOR_INVERSE,
    FACTOR_RADIUS,
    FACTOR_SCHUR,
    FACTOR_VELOCITY,
    MOTION,
    ORBIT_ANGLE,
    PLACES,
    RING_X,
    RING_Y,
    RING_Z,
    SHARES,
    SPIN,
    TILT_X,
    TILT_Y,
    VELOCITY,
)
from bearing_twin.numerics import chain_solve
from bearing_twin.numerics.block_solve import times
from bearing_twin.numerics.lanes import LANES, get, get_block, get_vector, put, put_vector, sum_of
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rotation import add


@inlined
def _ball_column(g, lanes, c, k):
    """Column c of a ball's answers to the border, without positions."""
    for r in range(6):
        ball = BALL_BY_BORDER + r * 2 * PLACES + c
        put(lanes, BALL_TILE + 6 * c + r, k, -(get(lanes, ball + PLACES, k) + g * get(lanes, ball, k)))


@inlined
def _border_row(g, lanes, r, k):
    """Row r of the border's answers to a ball, without positions."""
    row, tile = BORDER_BY_BALL + r * MOTION, BORDER_TILE + r
    turn_radius, turn_velocity = get(lanes, FACTOR_RADIUS, k), get(lanes, FACTOR_VELOCITY, k)
    angle = get(lanes, row + ORBIT_ANGLE, k)
    radial = get(lanes, row + VELOCITY, k) + g * get(lanes, row + AXIS_DISTANCE, k) + turn_radius * angle
    put(lanes, tile, k, -radial)
    put(lanes, tile + 6, k, -(get(lanes, row + VELOCITY + 1, k) + turn_velocity * angle))
    put(lanes, tile + 12, k, -(get(lanes, row + VELOCITY + 2, k) + g * get(lanes, row + 2, k)))
    put(lanes, tile + 18, k, -get(lanes, row + SPIN, k))
    put(lanes, tile + 24, k, -get(lanes, row + SPIN + 1, k))
    put(lanes, tile + 30, k, -get(lanes, row + SPIN + 2, k))


@lean_kernel
def border_tiles(g, border, lanes):
    """Tiles of the linear system between the balls in `lanes` and the border, after the balls' own."""
    if len(border.ring) > 0:
        for k in range(LANES):
            _ball_column(g, lanes, RING_X, k)
            _ball_column(g, lanes, RING_Y, k)
            _ball_column(g, lanes, RING_Z, k)
        for k in range(LANES):
            _border_row(g, lanes, RING_X, k)
            _border_row(g, lanes, RING_Y, k)
            _border_row(g, lanes, RING_Z, k)
    if len(border.ring) > 1:
        for k in range(LANES):
            _ball_column(g, lanes, TILT_X, k)
            _ball_column(g, lanes, TILT_Y, k)
        for k in range(LANES):
            _border_row(g, lanes, TILT_X, k)
            _border_row(g, lanes, TILT_Y, k)
    for k in range(LANES):
        _ball_column(g, lanes, CAGE, k)
        _border_row(g, lanes, CAGE, k)


@lean_kernel
def border_corner(g, numbers, tile, first):
    """Fills the tile of the border by itself, which stands in `tile` from `first` on."""
    for c in range(PLACES):
        for r in range(PLACES):
            own = at.OWN + r * 2 * PLACES + c
            tile[first + 6 * c + r] = (1.0 / g if r == c else 0.0) - numbers[own + PLACES] - g * numbers[own]


@lean_kernel
def put_border_tiles(g, border, chain, blocks):
    """Puts the border's tiles into the system of balls that touch, as its last block."""
    tiles, block = chain.tiles, chain.border - 1
    border_corner(g, border.numbers, tiles[chain_solve.corner_tile(chain, block, block)], 0)
    for place in range(border.count):
        lanes, k = blocks[place // LANES], place % LANES
        if place == chain.bodies:
            chain_solve.copy_tile(lanes, BALL_TILE, k, tiles[chain_solve.corner_tile(chain, 0, block)])
            chain_solve.copy_tile(lanes, BORDER_TILE, k, tiles[chain_solve.corner_tile(chain, block, 0)])
        else:
            chain_solve.copy_tile(lanes, BALL_TILE, k, tiles[chain_solve.column_tile(chain, place, block)])
            chain_solve.copy_tile(lanes, BORDER_TILE, k, tiles[chain_solve.row_tile(chain, block, place)])


@inlined
def ball_solved(lanes, k, velocity, spin):
    """The velocity and spin that an own right-hand side gives a ball, its positions eliminated."""
    push = times(get_block(lanes, FACTOR_INVERSE, k), velocity)
    spins = times(get_block(lanes, FACTOR_SCHUR, k), add(spin, times(get_block(lanes, FACTOR_BELOW, k), push)))
    return add(push, times(get_block(lanes, FACTOR_COUPLING, k), spins)), spins


@inlined
def share(lanes, r, k, velocity, spin):
    """What a ball's motion does to coordinate r of the border."""
    tile = BORDER_TILE + r
    found = get(lanes, tile, k) * velocity[0] + get(lanes, tile + 6, k) * velocity[1]
    found += get(lanes, tile + 12, k) * velocity[2] + get(lanes, tile + 18, k) * spin[0]
    return found + get(lanes, tile + 24, k) * spin[1] + get(lanes, tile + 30, k) * spin[2]


@inlined
def _put_shares(ring, lanes, k, velocity, spin):
    """Writes what a ball's motion does to the border."""
    for r in range(at.ring_places(ring)):
        put(lanes, SHARES + r, k, share(lanes, r, k, velocity, spin))
    put(lanes, SHARES + CAGE, k, share(lanes, CAGE, k, velocity, spin))


@inlined
def _eliminate(border, lanes, c):
    """Takes from column c of the border's system what the balls answer with."""
    ring, tile = border.ring, BALL_TILE + 6 * c
    for k in range(LANES):
        velocity, spin = ball_solved(lanes, k, get_vector(lanes, tile, k), get_vector(lanes, tile + 3, k))
        put_vector(lanes, tile, k, velocity)
        put_vector(lanes, tile + 3, k, spin)
        _put_shares(ring, lanes, k, velocity, spin)
    for r in range(at.ring_places(ring)):
        border.numbers[at.CORNER + 6 * c + r] -= sum_of(lanes, SHARES + r)
    border.numbers[at.CORNER + 6 * c + CAGE] -= sum_of(lanes, SHARES + CAGE)


@lean_kernel
def factorise_border(g, border, blocks):
    """Eliminates the balls, whose own factors stand in the lanes, from the border's system: C - sum V_j B_j^-1 U_j.

    BALL_TILE holds B_j^-1 U_j afterwards, the border's CORNER the inverse of what is left.
    """
    numbers, last = border.numbers, at.CORNER + 7 * CAGE
    border_corner(g, numbers, numbers, at.CORNER)
    for block in range(len(blocks)):
        lanes = blocks[block]
        border_tiles(g, border, lanes)
        if len(border.ring) > 0:
            _eliminate(border, lanes, RING_X)
            _eliminate(border, lanes, RING_Y)
            _eliminate(border, lanes, RING_Z)
        if len(border.ring) > 1:
            _eliminate(border, lanes, TILT_X)
            _eliminate(border, lanes, TILT_Y)
        _eliminate(border, lanes, CAGE)
    if len(border.ring) > 0:
        chain_solve.invert_tile(numbers, at.CORNER)
    else:
        numbers[last] = 1.0 / numbers[last]


@inlined
def of_cage(numbers):
    """The cage's of six numbers."""
    return numbers[5]  # written out: CAGE is one of NumPy's integers, which Numba looks up among plain ones


@inlined
def mixed(ring, lanes, row, apart, k, weights):
    """The weighted sum of six rows so far apart, without those of places that are not met (`ring_places`)."""
    last = weights[5] * get(lanes, row + 5 * apart, k)
    if len(ring) == 0:
        return last
    first = weights[0] * get(lanes, row, k) + weights[1] * get(lanes, row + apart, k)
    if len(ring) == 1:
        return (first + weights[2] * get(lanes, row + 2 * apart, k)) + last
    second = weights[2] * get(lanes, row + 2 * apart, k) + weights[3] * get(lanes, row + 3 * apart, k)
    return (first + second) + (weights[4] * get(lanes, row + 4 * apart, k) + last)


@inlined
def solve_corner(border):
    """The border's velocities, once the balls have been eliminated from what they follow from."""
    numbers, speeds = border.numbers, at.SOLUTION + PLACES
    right = chain_solve.six(numbers, speeds)
    for i in range(at.ring_places(border.ring)):
        numbers[speeds + i] = _corner_row(border.ring, numbers, at.CORNER + i, right)
    numbers[speeds + CAGE] = _corner_row(border.ring, numbers, at.CORNER + CAGE, right)


@inlined
def _corner_row(ring, numbers, tile, right):
    """A row of the border's inverse, from number `tile` on, times its right-hand side."""
    last = numbers[tile + 30] * right[5]
    if len(ring) == 0:
        return last
    low = numbers[tile] * right[0] + numbers[tile + 6] * right[1] + numbers[tile + 12] * right[2]
    if len(ring) == 1:
        return low + last
    return low + (numbers[tile + 18] * right[3] + numbers[tile + 24] * right[4] + last)
