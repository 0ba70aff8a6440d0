"""Opposing points of two bodies in closed form: a plane with any convex body, a sphere with what has a nearest point.

What `tracking` finds by Newton's method or follows by differential equations (paper 1, eqs. 1-3), for pairs that need
neither. `nearest_pair` chooses by the surfaces' kinds; `closed_form_known` says whether a pair has one.
"""

import math

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.shapes.implicit import ELLIPSOID, PLANE, SPHERE, SUPERQUADRIC, TORUS
from bearing_twin.shapes.tracking import LAMBDA, MU, level_at

CONVEX = (SPHERE, ELLIPSOID, SUPERQUADRIC)


def closed_form_known(kind_a: int, kind_b: int) -> bool:
    """True if `nearest_pair` knows the opposing points of these kinds of `implicit.Surface`."""
    kinds = {kind_a, kind_b}
    return (PLANE in kinds and bool(kinds & set(CONVEX))) or (SPHERE in kinds and kinds <= {SPHERE, TORUS})


@kernel
def support(surface, direction):
    """The farthest point (3,) [m] of a sphere, ellipsoid or superquadric along a direction, in the body's axes.

    Of (|x/a|^n + |y/b|^n)^(m/n) + |z/c|^m = 1 by the dual norm, whose exponents are n/(n - 1) and m/(m - 1): its
    gradient is the point.
    """
    sizes, n, m = surface.sizes, 2.0, 2.0
    x, y, z = sizes[0], sizes[1], sizes[2]
    if surface.kind == SPHERE:
        y = z = x
    elif surface.kind == SUPERQUADRIC:
        n, m = sizes[3], sizes[4]
    n, m = n / (n - 1.0), m / (m - 1.0)
    own = (x * direction[0], y * direction[1], z * direction[2])
    flat = (abs(own[0]) ** n + abs(own[1]) ** n) ** (1.0 / n)
    length = (flat**m + abs(own[2]) ** m) ** (1.0 / m)
    point = np.zeros(3)
    if flat > 0.0:
        around = (flat / length) ** (m - 1.0)
        point[0] = x * math.copysign((abs(own[0]) / flat) ** (n - 1.0), own[0]) * around
        point[1] = y * math.copysign((abs(own[1]) / flat) ** (n - 1.0), own[1]) * around
    point[2] = z * math.copysign((abs(own[2]) / length) ** (m - 1.0), own[2])
    return point


@kernel
def _foot(other, centre):
    """The point of a plane, a sphere or a torus nearest to `centre` (3,), in fixed axes."""
    own = other.rotation.T @ (centre - other.position)
    if other.surface.kind == PLANE:
        own[2] = 0.0
    elif other.surface.kind == SPHERE:
        own *= other.surface.sizes[0] / math.sqrt(own @ own)
    else:
        rho = math.hypot(own[0], own[1])
        off = rho - other.surface.sizes[0]
        share = other.surface.sizes[1] / math.hypot(off, own[2])
        stretch = (other.surface.sizes[0] + share * off) / rho
        own[0], own[1], own[2] = stretch * own[0], stretch * own[1], share * own[2]
    return other.position + other.rotation @ own


@kernel
def nearest_pair(a, b, unknowns):
    """Writes the unknowns (8,) of `tracking.equations` of a pair that has a closed form."""
    if a.surface.kind == PLANE or a.surface.kind == TORUS:
        point_b, point_a = _points(b, a)
    else:
        point_a, point_b = _points(a, b)
    gradient_a, gradient_b, hesse = np.empty(3), np.empty(3), np.empty((3, 3))
    level_at(a, point_a, gradient_a, hesse)
    level_at(b, point_b, gradient_b, hesse)
    square = gradient_b @ gradient_b
    unknowns[:3], unknowns[3:6] = point_a, point_b
    unknowns[LAMBDA] = -math.sqrt(gradient_a @ gradient_a / square)
    unknowns[MU] = (point_a - point_b) @ gradient_b / square


@kernel
def _points(one, other):
    """Opposing points of a convex body `one` and a plane, or of a sphere and what has a nearest point."""
    gradient, hesse = np.empty(3), np.empty((3, 3))
    if other.surface.kind == PLANE:
        down = -other.rotation[:, 2].copy()
        point = one.position + one.rotation @ support(one.surface, one.rotation.T @ down)
        return point, _foot(other, point)
    foot = _foot(other, one.position)
    level_at(other, foot, gradient, hesse)
    return one.position - one.surface.sizes[0] / math.sqrt(gradient @ gradient) * gradient, foot
