"""Quadrilateral elements of order 1 to 4: Lagrange polynomials on Gauss-Lobatto nodes, and the points of quadrature.

Order 1 is the bilinear quadrilateral, higher orders are spectral elements. With mass lumped at the Gauss-Lobatto nodes
no further approximation is made in the mass of an undistorted element (Y. Maday, A. T. Patera, 1989).
"""

import numpy as np

ORDERS = (1, 2, 3, 4)


def lobatto(order: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Lobatto nodes (order + 1,) on [-1, 1] and their weights; exact to degree 2 order - 1."""
    legendre = np.polynomial.legendre.Legendre.basis(order)
    nodes = np.concatenate([[-1.0], np.sort(np.real(legendre.deriv().roots())), [1.0]])
    return nodes, 2.0 / (order * (order + 1) * legendre(nodes) ** 2)


def gauss(points: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points (points,) on [-1, 1] and their weights; exact to degree 2 points - 1."""
    return np.polynomial.legendre.leggauss(points)


def lagrange(nodes: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values and slopes (places, nodes) of the Lagrange polynomials on `nodes` at `places`."""
    powers = np.arange(len(nodes))
    # Few nodes on [-1, 1]: the Vandermonde matrix is well conditioned.
    coefficients = np.linalg.inv(nodes[:, None] ** powers)
    slopes = np.zeros((len(places), len(nodes)))
    slopes[:, 1:] = powers[1:] * places[:, None] ** powers[:-1]
    return places[:, None] ** powers @ coefficients, slopes @ coefficients


def on_square(order: int, points: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shape functions (q, n), their gradients (q, n, 2) and weights (q,) at `points`^2 Gauss points of the square.

    Nodes and points count along the first direction fastest.
    """
    places, weights = gauss(points)
    values, slopes = lagrange(lobatto(order)[0], places)
    both = np.einsum("jb,ia->jiba", values, values).reshape(points**2, -1)
    along = np.einsum("jb,ia->jiba", values, slopes).reshape(points**2, -1)
    across = np.einsum("jb,ia->jiba", slopes, values).reshape(points**2, -1)
    return both, np.stack([along, across], axis=2), np.outer(weights, weights).ravel()
