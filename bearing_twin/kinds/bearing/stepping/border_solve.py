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
from bearing_twin.numerics.block_solve import combined, inverse, times
from bearing_twin.numerics.lanes import LANES, add_sum, get, get_block, get_vector, put, put_vector
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rotation import add, dot, scaled


@inlined
def _answer(g, lanes, r, c, k):
    ball = BALL_BY_BORDER + r * 2 * PLACES + c
    return -(get(lanes, ball + PLACES, k) + g * get(lanes, ball, k))


@inlined
def _ball_column(g, lanes, c, k):
    """Column c of a ball's answers to the border, without positions: those of its velocity and of its spin."""
    velocity = _answer(g, lanes, 0, c, k), _answer(g, lanes, 1, c, k), _answer(g, lanes, 2, c, k)
    return velocity, (_answer(g, lanes, 3, c, k), _answer(g, lanes, 4, c, k), _answer(g, lanes, 5, c, k))


@inlined
def _put_column(lanes, c, k, column):
    """Writes column c of a ball's answers to the border."""
    put_vector(lanes, BALL_TILE + 6 * c, k, column[0])
    put_vector(lanes, BALL_TILE + 6 * c + 3, k, column[1])


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


@inlined
def _border_rows(ring, g, lanes):
    """Tiles of the linear system that say how the border answers to the balls in `lanes`, after the balls' own."""
    for k in range(LANES):
        for r in range(at.ring_places(ring)):
            _border_row(g, lanes, r, k)
        _border_row(g, lanes, CAGE, k)


@lean_kernel
def border_tiles(g, border, lanes):
    """Tiles of the linear system between the balls in `lanes` and the border, after the balls' own."""
    _border_rows(border.ring, g, lanes)
    for k in range(LANES):
        for c in range(at.ring_places(border.ring)):
            _put_column(lanes, c, k, _ball_column(g, lanes, c, k))
        _put_column(lanes, CAGE, k, _ball_column(g, lanes, CAGE, k))


@inlined
def _corner_entry(g, numbers, r, c):
    """How the velocity of place r of the border answers to that of place c, in the linear system without balls."""
    own = at.OWN + r * 2 * PLACES + c
    return (1.0 / g if r == c else 0.0) - numbers[own + PLACES] - g * numbers[own]


@lean_kernel
def _border_corner(g, numbers, tile):
    """Fills the tile of the border by itself."""
    for c in range(PLACES):
        for r in range(PLACES):
            tile[6 * c + r] = _corner_entry(g, numbers, r, c)


@inlined
def _fill_corner(ring, g, numbers):
    """Fills of the border's CORNER what is met."""
    for c in range(at.ring_places(ring)):
        for r in range(at.ring_places(ring)):
            numbers[at.CORNER + 6 * c + r] = _corner_entry(g, numbers, r, c)
        numbers[at.CORNER + 6 * c + CAGE] = _corner_entry(g, numbers, CAGE, c)
        numbers[at.CORNER + 6 * CAGE + c] = _corner_entry(g, numbers, c, CAGE)
    numbers[at.CORNER + 7 * CAGE] = _corner_entry(g, numbers, CAGE, CAGE)


@lean_kernel
def put_border_tiles(g, border, chain, blocks):
    """Puts the border's tiles into the system of balls that touch, as its last block."""
    tiles, block = chain.tiles, chain.border - 1
    _border_corner(g, border.numbers, tiles[chain_solve.corner_tile(chain, block, block)])
    for place in range(border.count):
        lanes, k = blocks[place // LANES], place % LANES
        if place == chain.bodies:
            chain_solve.copy_tile(lanes, BALL_TILE, k, tiles[chain_solve.corner_tile(chain, 0, block)])
            chain_solve.copy_tile(lanes, BORDER_TILE, k, tiles[chain_solve.corner_tile(chain, block, 0)])
        else:
            chain.meets[place, 1 + block] = True
            chain_solve.copy_tile(lanes, BALL_TILE, k, tiles[chain_solve.column_tile(chain, place, block)])
            chain_solve.copy_tile(lanes, BORDER_TILE, k, tiles[chain_solve.row_tile(chain, block, place)])


@inlined
def ball_solved(lanes, k, velocity, spin):
    """The velocity and spin that an own right-hand side gives a ball, its positions eliminated."""
    push = times(get_block(lanes, FACTOR_INVERSE, k), velocity)
    spins = times(get_block(lanes, FACTOR_SCHUR, k), add(spin, times(get_block(lanes, FACTOR_BELOW, k), push)))
    return add(push, times(get_block(lanes, FACTOR_COUPLING, k), spins)), spins


@inlined
def outer_two(lanes, row, k, two):
    """The product of `two` numbers with the first and the third of three rows from `row` on."""
    return get(lanes, row, k) * two[0] + get(lanes, row + 2, k) * two[1]


@inlined
def even_solved(lanes, k, velocity, spin):
    """`ball_solved` of a ball that goes round with an even cage: its radial and axial velocity, and its spin."""
    push = outer_two(lanes, FACTOR_INVERSE, k, velocity), outer_two(lanes, FACTOR_INVERSE + 6, k, velocity)
    below = (
        outer_two(lanes, FACTOR_BELOW, k, push),
        outer_two(lanes, FACTOR_BELOW + 3, k, push),
        outer_two(lanes, FACTOR_BELOW + 6, k, push),
    )
    spins = times(get_block(lanes, FACTOR_SCHUR, k), add(spin, below))
    radial = push[0] + dot(get_vector(lanes, FACTOR_COUPLING, k), spins)
    return (radial, push[1] + dot(get_vector(lanes, FACTOR_COUPLING + 6, k), spins)), spins


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
def _eliminate(ring, g, numbers, lanes, c):
    """Takes from column c of the border's system what the balls answer with."""
    for k in range(LANES):
        velocity, spin = _ball_column(g, lanes, c, k)
        velocity, spin = ball_solved(lanes, k, velocity, spin)
        _put_column(lanes, c, k, (velocity, spin))
        _put_shares(ring, lanes, k, velocity, spin)
    for r in range(at.ring_places(ring)):
        add_sum(numbers, at.CORNER + 6 * c + r, -1.0, lanes, SHARES + r)
    add_sum(numbers, at.CORNER + 6 * c + CAGE, -1.0, lanes, SHARES + CAGE)


@inlined
def _invert_corner(ring, g, numbers):
    """Replaces the border's CORNER by its inverse."""
    if len(ring) > 1:
        chain_solve.invert_tile(numbers, at.CORNER)
    elif len(ring) == 1:
        _invert_level(1.0 / g, numbers)
    else:
        numbers[at.CORNER + 7 * CAGE] = 1.0 / numbers[at.CORNER + 7 * CAGE]


@lean_kernel
def _invert_level(spare, numbers):
    """`_invert_corner` of a ring that does not tilt: three places, and the cage's angle.

    To the bits that `spare` on the diagonal for each place of a tilt gives: bumps enlarge what is rounded otherwise.
    """
    first, row, column = at.CORNER, at.CORNER + CAGE, at.CORNER + 6 * CAGE
    x, y = chain_solve.three(numbers, first), chain_solve.three(numbers, first + 6)
    z = chain_solve.three(numbers, first + 12)
    upper = inverse(((x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])))
    right = times(upper, chain_solve.three(numbers, column))
    left = combined((numbers[row], numbers[row + 6], numbers[row + 12]), upper)
    last = numbers[column + CAGE] - dot(left, chain_solve.three(numbers, column))
    last = 1.0 / (spare * (spare * last)) * (spare * spare)
    across = scaled(last, right)
    for c in range(3):
        for r in range(3):
            numbers[first + 6 * c + r] = upper[r][c] + across[r] * left[c]
        numbers[row + 6 * c], numbers[column + c] = -last * left[c], -across[c]
    numbers[column + CAGE] = last


@lean_kernel
def factorise_border(g, border, blocks):
    """Eliminates the balls, whose own factors stand in the lanes, from the border's system: C - sum V_j B_j^-1 U_j.

    BALL_TILE holds B_j^-1 U_j afterwards, the border's CORNER the inverse of what is left.
    """
    ring, numbers = border.ring, border.numbers
    _fill_corner(ring, g, numbers)
    for block in range(len(blocks)):
        lanes = blocks[block]
        _border_rows(ring, g, lanes)
        if len(ring) > 0:
            _eliminate(ring, g, numbers, lanes, RING_X)
            _eliminate(ring, g, numbers, lanes, RING_Y)
            _eliminate(ring, g, numbers, lanes, RING_Z)
        if len(ring) > 1:
            _eliminate(ring, g, numbers, lanes, TILT_X)
            _eliminate(ring, g, numbers, lanes, TILT_Y)
        _eliminate(ring, g, numbers, lanes, CAGE)
    _invert_corner(ring, g, numbers)


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
