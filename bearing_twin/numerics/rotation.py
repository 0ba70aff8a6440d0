"""Unit quaternions (..., 4) of x, y, z, w."""

import numpy as np


def quaternion_product(p, q) -> np.ndarray:
    """p q (..., 4): first the rotation q, then p."""
    p, q = np.asarray(p, float), np.asarray(q, float)
    a, b, w, v = p[..., :3], q[..., :3], p[..., 3:], q[..., 3:]
    vector = w * b + v * a + np.cross(a, b)
    return np.concatenate([vector, w * v - (a * b).sum(axis=-1, keepdims=True)], axis=-1)


def quaternion_from_vector(vector) -> np.ndarray:
    """Quaternions (..., 4) of the rotations by |vector| [rad] about `vector` (..., 3)."""
    vector = np.asarray(vector, float)
    # The tiny number spares a branch for no rotation at all, where the quotient is 1/2.
    angle = np.sqrt((vector * vector).sum(axis=-1, keepdims=True) + 1e-200)
    return np.concatenate([np.sin(0.5 * angle) / angle * vector, np.cos(0.5 * angle)], axis=-1)


def turned(quaternion, omega_start, omega_middle, omega_end, step) -> np.ndarray:
    """Orientations (..., 4) after `step` [s] at angular velocities (..., 3) [rad/s] at start, middle and end.

    In fixed axes. Fourth-order Magnus step; the result has unit norm, so nothing drifts.
    """
    start, middle, end = (np.asarray(one, float) for one in (omega_start, omega_middle, omega_end))
    vector = step / 6.0 * (start + 4.0 * middle + end) + step * step / 12.0 * np.cross(end, start)
    product = quaternion_product(quaternion_from_vector(vector), quaternion)
    return product / np.linalg.norm(product, axis=-1, keepdims=True)


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
