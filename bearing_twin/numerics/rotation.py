"""Vectors as tuples of three floats, and unit quaternions (x, y, z, w)."""

import math

import numpy as np


def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    """Vector product a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def add(a, b):
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def scaled(factor, a):
    """factor * a."""
    return (factor * a[0], factor * a[1], factor * a[2])


def quaternion_product(p, q):
    """p q: first the rotation q, then p."""
    return (
        p[3] * q[0] + p[0] * q[3] + p[1] * q[2] - p[2] * q[1],
        p[3] * q[1] - p[0] * q[2] + p[1] * q[3] + p[2] * q[0],
        p[3] * q[2] + p[0] * q[1] - p[1] * q[0] + p[2] * q[3],
        p[3] * q[3] - p[0] * q[0] - p[1] * q[1] - p[2] * q[2],
    )


def quaternion_from_vector(vector):
    """Quaternion of the rotation by |vector| [rad] about `vector`."""
    # The tiny number spares a branch for no rotation at all, where the quotient is 1/2.
    angle = math.sqrt(dot(vector, vector) + 1e-200)
    return (*scaled(math.sin(0.5 * angle) / angle, vector), math.cos(0.5 * angle))


def turned(quaternion, omega_start, omega_middle, omega_end, step):
    """The orientation after `step` [s] at an angular velocity [rad/s] known at start, middle and end, in fixed axes.

    Fourth-order Magnus step; the result has unit norm, so nothing drifts.
    """
    mean = scaled(step / 6.0, add(add(omega_start, omega_end), scaled(4.0, omega_middle)))
    vector = add(mean, scaled(step * step / 12.0, cross(omega_end, omega_start)))
    product = quaternion_product(quaternion_from_vector(vector), quaternion)
    norm = math.sqrt(
        product[0] * product[0] + product[1] * product[1] + product[2] * product[2] + product[3] * product[3]
    )
    return (product[0] / norm, product[1] / norm, product[2] / norm, product[3] / norm)


def rotation_rows(quaternion):
    """Rows of the matrix of a unit quaternion (x, y, z, w), of numbers or of arrays: columns are the body's axes."""
    x, y, z, w = quaternion
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)),
        (2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)),
        (2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)),
    )


def rotation_matrix(quaternion) -> np.ndarray:
    """3 x 3 matrix of a unit quaternion (x, y, z, w): columns are the body's axes in the fixed frame."""
    return np.array(rotation_rows(quaternion))
