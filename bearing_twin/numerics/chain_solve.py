"""The linear system of bodies in a row, each coupled to the next, and of a border coupled to all of them.

The matrix consists of tiles of SIDE x SIDE: `own_tile(i)` on the diagonal, `ahead_tile(i)` right of it,
`behind_tile(i)` below it, and for each block of the border `column_tile`, `row_tile` and `corner_tile`. A closed ring
of bodies is a row of all but one, with that one as border; whatever meets all bodies (a ring, a cage) is another block.

Elimination from the first body to the last, then the border's Schur complement C - sum V_j B_j^-1 U_j. No pivoting
between tiles, as in `block_solve`: 1/g and what resists motion make the diagonal ones regular.
"""

from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.numerics.block_solve import inverse, minus_block, negative, plus, product
from bearing_twin.numerics.lanes import get
from bearing_twin.numerics.lean import lean_kernel

SIDE = 6  # of a tile, which holds its columns one after the other


class Chain(NamedTuple):
    """Room for so many bodies and blocks of the border: `tiles` (n, SIDE * SIDE), `right` (bodies + border, SIDE).

    `meets` (bodies, 1 + border) says which bodies answer to the next, and which to each block of the border: tiles of
    others do not count, as those of open contacts.
    """

    bodies: int
    border: int
    tiles: np.ndarray
    right: np.ndarray
    meets: np.ndarray


@kernel
def new_chain(bodies, border):
    """A `Chain` of zeros, in which nobody meets."""
    count = 3 * bodies + 2 * bodies * border + border * border
    tiles, right = np.zeros((count, SIDE * SIDE)), np.zeros((bodies + border, SIDE))
    return Chain(bodies, border, tiles, right, np.zeros((bodies, 1 + border), np.bool_))


@inlined
def own_tile(i):
    """The tile of body i on the diagonal."""
    return 3 * i


@inlined
def ahead_tile(i):
    """How body i answers to the next."""
    return 3 * i + 1


@inlined
def behind_tile(i):
    """How the next body answers to body i."""
    return 3 * i + 2


@inlined
def column_tile(chain, i, b):
    """How body i answers to block b of the border."""
    return 3 * chain.bodies + 2 * (i * chain.border + b)


@inlined
def row_tile(chain, b, i):
    """How block b of the border answers to body i."""
    return column_tile(chain, i, b) + 1


@inlined
def corner_tile(chain, a, b):
    """How block a of the border answers to block b."""
    return (3 + 2 * chain.border) * chain.bodies + a * chain.border + b


@lean_kernel
def begin_anew(chain):
    """Before tiles are put in: nobody meets, and the tiles of the border are zeros."""
    for i in range(chain.bodies):
        for b in range(1 + chain.border):
            chain.meets[i, b] = False
    for tile in range(column_tile(chain, 0, 0), len(chain.tiles)):
        for i in range(SIDE * SIDE):
            chain.tiles[tile, i] = 0.0


@inlined
def _corner(numbers, first, row, column):
    """The 3 x 3 block at (row, column) of the tile that begins at `first`."""
    one = first + column * SIDE + row
    two, three = one + SIDE, one + 2 * SIDE
    return (
        (numbers[one], numbers[two], numbers[three]),
        (numbers[one + 1], numbers[two + 1], numbers[three + 1]),
        (numbers[one + 2], numbers[two + 2], numbers[three + 2]),
    )


@inlined
def _put_corner(numbers, first, row, column, block):
    for c in range(3):
        for r in range(3):
            numbers[first + (column + c) * SIDE + row + r] = block[r][c]


@inlined
def copy_tile(lanes, row, k, tile):
    """Copies a tile that stands in rows of lane k from `row` on."""
    for i in range(SIDE * SIDE):
        tile[i] = get(lanes, row + i, k)


@lean_kernel
def invert_tile(numbers, first):
    """Replaces the tile that begins at `first` by its inverse."""
    upper = inverse(_corner(numbers, first, 0, 0))
    left = product(_corner(numbers, first, 3, 0), upper)
    right = product(upper, _corner(numbers, first, 0, 3))
    schur = inverse(minus_block(_corner(numbers, first, 3, 3), product(left, _corner(numbers, first, 0, 3))))
    across = product(right, schur)
    _put_corner(numbers, first, 0, 0, plus(upper, product(across, left)))
    _put_corner(numbers, first, 0, 3, negative(across))
    _put_corner(numbers, first, 3, 0, negative(product(schur, left)))
    _put_corner(numbers, first, 3, 3, schur)


@inlined
def three(numbers, first):
    """Three numbers from `first` on."""
    return (numbers[first], numbers[first + 1], numbers[first + 2])


@inlined
def six(numbers, first):
    """Six numbers from `first` on."""
    return (
        numbers[first],
        numbers[first + 1],
        numbers[first + 2],
        numbers[first + 3],
        numbers[first + 4],
        numbers[first + 5],
    )


@inlined
def _mixed(tile, r, x):
    """Entry r of a tile times the vector x."""
    return (
        x[0] * tile[r]
        + x[1] * tile[SIDE + r]
        + x[2] * tile[2 * SIDE + r]
        + x[3] * tile[3 * SIDE + r]
        + x[4] * tile[4 * SIDE + r]
        + x[5] * tile[5 * SIDE + r]
    )


@lean_kernel
def _multiply(left, right):
    """The tile `right` becomes left right."""
    for c in range(SIDE):
        x = six(right, c * SIDE)
        for r in range(SIDE):
            right[c * SIDE + r] = _mixed(left, r, x)


@lean_kernel
def _subtract(target, left, right):
    """target -= left right, for tiles."""
    for c in range(SIDE):
        x = six(right, c * SIDE)
        for r in range(SIDE):
            target[c * SIDE + r] -= _mixed(left, r, x)


@inlined
def _multiply_vector(tile, vector):
    """The vector becomes tile times it."""
    x = six(vector, 0)
    for r in range(SIDE):
        vector[r] = _mixed(tile, r, x)


@inlined
def _subtract_vector(target, tile, vector):
    """target -= tile times vector."""
    x = six(vector, 0)
    for r in range(SIDE):
        target[r] -= _mixed(tile, r, x)


@lean_kernel
def factorise_chain(chain):
    """Replaces the tiles by factors for `solve_chain`; not finite where the matrix is singular.

    A body comes to answer to a block of the border where the one before it does, and meets it.
    """
    tiles, meets = chain.tiles, chain.meets
    for i in range(chain.bodies):
        own, ahead, behind = tiles[own_tile(i)], tiles[ahead_tile(i)], tiles[behind_tile(i)]
        invert_tile(own, 0)
        if meets[i, 0]:
            _multiply(own, ahead)
            _subtract(tiles[own_tile(i + 1)], behind, ahead)
        for b in range(chain.border):
            if not meets[i, 1 + b]:
                continue
            column = tiles[column_tile(chain, i, b)]
            _multiply(own, column)
            for a in range(chain.border):
                if meets[i, 1 + a]:
                    _subtract(tiles[corner_tile(chain, a, b)], tiles[row_tile(chain, a, i)], column)
            if meets[i, 0]:
                meets[i + 1, 1 + b] = True
                _subtract(tiles[column_tile(chain, i + 1, b)], behind, column)
                _subtract(tiles[row_tile(chain, b, i + 1)], tiles[row_tile(chain, b, i)], ahead)
    for a in range(chain.border):
        invert_tile(tiles[corner_tile(chain, a, a)], 0)
        for b in range(a + 1, chain.border):
            right = tiles[corner_tile(chain, a, b)]
            _multiply(tiles[corner_tile(chain, a, a)], right)
            for c in range(a + 1, chain.border):
                _subtract(tiles[corner_tile(chain, c, b)], tiles[corner_tile(chain, c, a)], right)


@lean_kernel
def solve_chain(chain):
    """Solves for the right-hand side in `chain.right`, in place: bodies first, then the blocks of the border."""
    tiles, right, bodies, border, meets = chain.tiles, chain.right, chain.bodies, chain.border, chain.meets
    for i in range(bodies):
        _multiply_vector(tiles[own_tile(i)], right[i])
        if meets[i, 0]:
            _subtract_vector(right[i + 1], tiles[behind_tile(i)], right[i])
        for b in range(border):
            if meets[i, 1 + b]:
                _subtract_vector(right[bodies + b], tiles[row_tile(chain, b, i)], right[i])
    for a in range(border):
        _multiply_vector(tiles[corner_tile(chain, a, a)], right[bodies + a])
        for b in range(a + 1, border):
            _subtract_vector(right[bodies + b], tiles[corner_tile(chain, b, a)], right[bodies + a])
    for a in range(border - 1, -1, -1):
        for b in range(a + 1, border):
            _subtract_vector(right[bodies + a], tiles[corner_tile(chain, a, b)], right[bodies + b])
    for i in range(bodies - 1, -1, -1):
        if meets[i, 0]:
            _subtract_vector(right[i], tiles[ahead_tile(i)], right[i + 1])
        for b in range(border):
            if meets[i, 1 + b]:
                _subtract_vector(right[i], tiles[column_tile(chain, i, b)], right[bodies + b])
