"""Surfaces as the zero set of a function f, negative inside the body: value, gradient and Hesse matrix in closed form.

Functions are scaled to be metres and to have gradients near 1 at the surface, so that Newton's method on them needs no
further scaling. `SURFACES` names the kinds; a `Surface` is made by the functions of those names.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.compiled import kernel

PLANE, SPHERE, ELLIPSOID, TORUS, SUPERQUADRIC = range(5)
SURFACES = {"plane": PLANE, "sphere": SPHERE, "ellipsoid": ELLIPSOID, "torus": TORUS, "superquadric": SUPERQUADRIC}


class Surface(NamedTuple):
    """A surface in its body's axes: kind, five sizes [m] or exponents, and side +1, or -1 where the body is outside."""

    kind: int
    sizes: tuple[float, float, float, float, float]
    side: float


def plane() -> Surface:
    """The half-space z < 0."""
    return _surface(PLANE, (1.0,), 1.0)


def sphere(radius: float, hollow: bool = False) -> Surface:
    """A ball about the origin, or all space but it."""
    _positive(radius=radius)
    return _surface(SPHERE, (radius,), -1.0 if hollow else 1.0)


def ellipsoid(x: float, y: float, z: float, hollow: bool = False) -> Surface:
    """An ellipsoid with these semi-axes [m] about the origin, or all space but it."""
    _positive(x=x, y=y, z=z)
    return _surface(ELLIPSOID, (x, y, z), -1.0 if hollow else 1.0)


def torus(locus_radius: float, tube_radius: float, hollow: bool = False) -> Surface:
    """A ring about z with this radius of the tube's centre circle; hollow: the tube is the groove of a raceway."""
    _positive(locus_radius=locus_radius, tube_radius=tube_radius)
    if tube_radius >= locus_radius:
        raise SceneError(f"tube_radius = {tube_radius:g} m must be below locus_radius = {locus_radius:g} m")
    return _surface(TORUS, (locus_radius, tube_radius), -1.0 if hollow else 1.0)


def superquadric(x: float, y: float, z: float, across: float, along: float) -> Surface:
    """(|x/a|^n + |y/b|^n)^(m/n) + |z/c|^m = 1 with exponents n = `across`, m = `along`, both >= 2.

    Exponents below 2 have corners; above 2 the surface is flat where a coordinate vanishes, and a contact there is no
    ellipse.
    """
    _positive(x=x, y=y, z=z)
    for name, exponent in (("across", across), ("along", along)):
        if not 2.0 <= exponent <= 50.0:
            raise SceneError(
                f"{name} = {exponent:g} must be between 2 (an ellipsoid) and 50; below 2 there are corners"
            )
    return _surface(SUPERQUADRIC, (x, y, z, across, along), 1.0)


def _surface(kind, sizes, side):
    """Floats throughout, so that all surfaces are one compiled type."""
    return Surface(kind, tuple(float(size) for size in (*sizes, 0.0, 0.0, 0.0, 0.0)[:5]), side)


def _positive(**sizes):
    for name, size in sizes.items():
        if not (math.isfinite(size) and size > 0.0):
            raise SceneError(f"{name} = {size:g} must be a finite number of metres above zero")


@kernel
def level(surface, point, gradient, hesse):
    """f [m] at `point` (3,); writes its gradient (3,) and Hesse matrix (3, 3) [1/m]. Undefined on a torus' own axis."""
    hesse[:] = 0.0
    if surface.kind == PLANE:
        value = point[2]
        gradient[0], gradient[1], gradient[2] = 0.0, 0.0, 1.0
    elif surface.kind == SPHERE:
        value = _quadric(point, surface.sizes[0], surface.sizes[0], surface.sizes[0], gradient, hesse)
    elif surface.kind == ELLIPSOID:
        value = _quadric(point, surface.sizes[0], surface.sizes[1], surface.sizes[2], gradient, hesse)
    elif surface.kind == TORUS:
        value = _torus(point, surface.sizes[0], surface.sizes[1], gradient, hesse)
    else:
        value = _superquadric(point, surface.sizes, gradient, hesse)
    if surface.side < 0.0:
        for i in range(3):
            gradient[i] = -gradient[i]
            for j in range(3):
                hesse[i, j] = -hesse[i, j]
        return -value
    return value


@kernel
def _quadric(point, x, y, z, gradient, hesse):
    """(s/2) (sum (r_i/a_i)^2 - 1), s the smallest semi-axis."""
    axes = (x, y, z)
    scale = min(x, min(y, z))
    value = -0.5 * scale
    for i in range(3):
        hesse[i, i] = scale / (axes[i] * axes[i])
        gradient[i] = hesse[i, i] * point[i]
        value += 0.5 * gradient[i] * point[i]
    return value


@kernel
def _torus(point, locus, tube, gradient, hesse):
    """((rho - R)^2 + z^2 - r^2)/(2 r), rho the distance from the axis: a factor of paper 1's polynomial f_A."""
    rho = math.sqrt(point[0] * point[0] + point[1] * point[1])
    unit = (point[0] / rho, point[1] / rho)
    off = rho - locus
    for i in range(2):
        gradient[i] = off * unit[i] / tube
        for j in range(2):
            turned = (1.0 if i == j else 0.0) - unit[i] * unit[j]
            hesse[i, j] = (unit[i] * unit[j] + off / rho * turned) / tube
    gradient[2] = point[2] / tube
    hesse[2, 2] = 1.0 / tube
    return 0.5 * (off * off + point[2] * point[2] - tube * tube) / tube


@kernel
def _superquadric(point, sizes, gradient, hesse):
    """(s/m) (F - 1) with s the smallest semi-axis, m the exponent along z."""
    n, m = sizes[3], sizes[4]
    scale = min(sizes[0], min(sizes[1], sizes[2])) / m
    power = m / n
    first, second = np.zeros(2), np.zeros(2)
    inner = 0.0
    for i in range(2):
        share = abs(point[i]) / sizes[i]
        sign = 1.0 if point[i] >= 0.0 else -1.0
        inner += share**n
        first[i] = sign * n * share ** (n - 1.0) / sizes[i]
        second[i] = n * (n - 1.0) * share ** (n - 2.0) / (sizes[i] * sizes[i])
    safe = max(inner, 1e-100)  # on the z axis all terms below vanish, whatever the powers
    slope, bend = power * safe ** (power - 1.0), power * (power - 1.0) * safe ** (power - 2.0)
    for i in range(2):
        gradient[i] = scale * slope * first[i]
        for j in range(2):
            hesse[i, j] = scale * bend * first[i] * first[j]
        hesse[i, i] += scale * slope * second[i]
    share = abs(point[2]) / sizes[2]
    sign = 1.0 if point[2] >= 0.0 else -1.0
    gradient[2] = scale * sign * m * share ** (m - 1.0) / sizes[2]
    hesse[2, 2] = scale * m * (m - 1.0) * share ** (m - 2.0) / (sizes[2] * sizes[2])
    return scale * (inner**power + share**m - 1.0)
