"""Small linear least squares whose matrix may lack rank."""

import math

import numpy as np

from bearing_twin.compiled import inlined, kernel

MOST_SWEEPS = 30  # of rotations; they converge quadratically, and 4 columns take about 6


@inlined
def _turn(table, p, q, cosine, sine):
    """Turns columns p and q of a table into each other."""
    for i in range(len(table)):
        first, second = table[i, p], table[i, q]
        table[i, p] = cosine * first - sine * second
        table[i, q] = sine * first + cosine * second


@kernel
def least_squares(matrix, right, share, out):
    """Fills `out` (n,) with the shortest x that makes |matrix x - right| least; `matrix` (m, n) is overwritten.

    Singular values below `share` of the greatest count as zero. One-sided Jacobi (Golub and Van Loan, Matrix
    Computations, 4th ed., section 8.6.3): columns are turned until they are orthogonal, which keeps small ones exact.
    """
    m, n = matrix.shape
    turned, squares = np.zeros((n, n)), np.zeros(n)
    for p in range(n):
        turned[p, p] = 1.0
    for _ in range(MOST_SWEEPS):
        settled = True
        for p in range(n - 1):
            for q in range(p + 1, n):
                alpha = beta = gamma = 0.0
                for i in range(m):
                    alpha += matrix[i, p] * matrix[i, p]
                    beta += matrix[i, q] * matrix[i, q]
                    gamma += matrix[i, p] * matrix[i, q]
                if gamma * gamma <= 1e-32 * alpha * beta:
                    continue
                settled = False
                zeta = (beta - alpha) / (2.0 * gamma)
                tangent = math.copysign(1.0, zeta) / (abs(zeta) + math.sqrt(1.0 + zeta * zeta))
                cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
                sine = cosine * tangent
                _turn(matrix, p, q, cosine, sine)
                _turn(turned, p, q, cosine, sine)
        if settled:
            break
    greatest = 0.0  # written out: what NumPy offers for it takes a second to compile
    for p in range(n):
        out[p] = 0.0
        for i in range(m):
            squares[p] += matrix[i, p] * matrix[i, p]
        greatest = max(greatest, squares[p])
    for p in range(n):
        if squares[p] > share * share * greatest:
            along = 0.0
            for i in range(m):
                along += matrix[i, p] * right[i]
            for i in range(n):
                out[i] += turned[i, p] * along / squares[p]
