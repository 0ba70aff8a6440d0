"""Vectors as tuples of three floats, and unit quaternions (x, y, z, w); compiled, no arrays made."""

import math

import numpy as np

from bearing_twin.compiled import inlined


@inlined
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def cross(a, b):
    """Vector product a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@inlined
def add(a, b):
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@inlined
def scaled(factor, a):
    """factor * a."""
    return (factor * a[0], factor * a[1], factor * a[2])


@inlined
def root_and_inverse(square):
    """The root of a number above zero, and its inverse within 3e-16, which does not wait for the root."""
    root = math.sqrt(square)
    return root, root * (1.0 / square)


@inlined
def _pair(first, second, y):
    return 1.0 / first - y * (1.0 / second)


@inlined
def cosine_sine(angle):
    """Cosine and sine of an angle [rad] below a million, within 2e-16, without a branch: loops stay vector code.

    Reduced by the nearest quarter turn in three parts (Cody and Waite), then Taylor's series to the 17th power, term
    beside term (Estrin): each would wait for the one before.
    """
    quarters = math.floor(angle * 0.6366197723675814 + 0.5)
    x = angle - quarters * 1.5707963267341256
    x = (x - quarters * 6.077100506303966e-11) - quarters * 2.0222662487959506e-21
    y = x * x
    square = y * y
    fourth = square * square
    s = _pair(6.0, 120.0, y) + square * _pair(5040.0, 362880.0, y)
    s += fourth * (_pair(39916800.0, 6227020800.0, y) + square * _pair(1307674368000.0, 355687428096000.0, y))
    s = x - (x * y) * s
    c = _pair(2.0, 24.0, y) + square * _pair(720.0, 40320.0, y)
    c += fourth * (_pair(3628800.0, 479001600.0, y) + square * _pair(87178291200.0, 20922789888000.0, y))
    c = 1.0 - y * c
    half = math.floor(0.5 * quarters)
    odd = quarters - 2.0 * half
    sign = 1.0 - 2.0 * (half - 2.0 * math.floor(0.5 * half))
    cosine = sign * ((1.0 - odd) * c - odd * s)
    sine = sign * ((1.0 - odd) * s + odd * c)
    return cosine, sine


@inlined
def quaternion_product(p, q):
    """p q: first the rotation q, then p."""
    return (
        p[3] * q[0] + p[0] * q[3] + p[1] * q[2] - p[2] * q[1],
        p[3] * q[1] - p[0] * q[2] + p[1] * q[3] + p[2] * q[0],
        p[3] * q[2] + p[0] * q[1] - p[1] * q[0] + p[2] * q[3],
        p[3] * q[3] - p[0] * q[0] - p[1] * q[1] - p[2] * q[2],
    )


@inlined
def quaternion_from_vector(vector):
    """Quaternion of the rotation by |vector| [rad] about `vector`."""
    # The tiny number spares a branch for no rotation at all, where the quotient is 1/2.
    angle = math.sqrt(dot(vector, vector) + 1e-200)
    cosine, sine = cosine_sine(0.5 * angle)
    factor = sine / angle
    return (factor * vector[0], factor * vector[1], factor * vector[2], cosine)


@inlined
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


_rows = inlined(rotation_rows)


@inlined
def rows_of_state(state, first):
    """`rotation_rows` of the quaternion in a state's columns from `first` on, taken at unit length."""
    x, y, z, w = state[first], state[first + 1], state[first + 2], state[first + 3]
    norm = 1.0 / math.sqrt(x * x + y * y + z * z + w * w)
    return _rows((norm * x, norm * y, norm * z, norm * w))


def rotation_matrix(quaternion) -> np.ndarray:
    """3 x 3 matrix of a unit quaternion (x, y, z, w): columns are the body's axes in the fixed frame."""
    return np.array(rotation_rows(quaternion))
