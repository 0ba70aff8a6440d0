"""Linear systems whose matrix has no entry further than `band` from its diagonal, by LU factors with partial pivoting.

Entry (i, j) stands at [i, j - i + band] of a (size, 3 band + 1) array, whose last `band` columns receive fill-in.
"""

import math

import numpy as np

from bearing_twin.compiled import inlined, kernel


@kernel
def new_banded(size, band):
    """An array of zeros for a (size, size) matrix."""
    return np.zeros((size, 3 * band + 1))


@inlined
def get_banded(matrix, band, i, j):
    """Entry (i, j)."""
    return matrix[i, j - i + band]


@inlined
def put_banded(matrix, band, i, j, value):
    """Writes entry (i, j)."""
    matrix[i, j - i + band] = value


@kernel
def factorise(matrix, pivots, size, band):
    """LU factors in place; `pivots` (size,) receives the rows exchanged.

    The room for fill-in must be zero. False when the matrix is singular or not finite.
    """
    for column in range(size):
        below, right = min(size, column + band + 1), min(size, column + 2 * band + 1)
        pivot = column
        greatest = abs(get_banded(matrix, band, column, column))
        for row in range(column + 1, below):
            value = abs(get_banded(matrix, band, row, column))
            if value > greatest:
                pivot, greatest = row, value
        pivots[column] = pivot
        if not 0.0 < greatest < math.inf:
            return False
        if pivot != column:
            for j in range(column, right):
                kept = get_banded(matrix, band, column, j)
                put_banded(matrix, band, column, j, get_banded(matrix, band, pivot, j))
                put_banded(matrix, band, pivot, j, kept)
        inverse = 1.0 / get_banded(matrix, band, column, column)
        for row in range(column + 1, below):
            factor = get_banded(matrix, band, row, column) * inverse
            if factor != 0.0:
                put_banded(matrix, band, row, column, factor)
                for j in range(column + 1, right):
                    rest = get_banded(matrix, band, row, j) - factor * get_banded(matrix, band, column, j)
                    put_banded(matrix, band, row, j, rest)
    return True


@kernel
def substitute(matrix, pivots, size, band, vector):
    """Solves in place with the factors of `factorise`."""
    for column in range(size):
        pivot = pivots[column]
        vector[column], vector[pivot] = vector[pivot], vector[column]
        for row in range(column + 1, min(size, column + band + 1)):
            vector[row] -= get_banded(matrix, band, row, column) * vector[column]
    for column in range(size - 1, -1, -1):
        value = vector[column] / get_banded(matrix, band, column, column)
        vector[column] = value
        for row in range(max(0, column - 2 * band), column):
            vector[row] -= get_banded(matrix, band, row, column) * value
