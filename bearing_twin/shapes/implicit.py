"""Surfaces as the zero set of a function f, negative inside the body (`core/shapes/implicit.hpp`).

Functions are scaled to be metres and to have gradients near 1 at the surface. `SURFACES` names the kinds; a `Surface`
is made by the functions of those names.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.core import INTEGER, REAL, REALS, REALS_OUT, Function

PLANE, SPHERE, ELLIPSOID, TORUS, SUPERQUADRIC = range(5)  # SurfaceKind of the core
SURFACES = {"plane": PLANE, "sphere": SPHERE, "ellipsoid": ELLIPSOID, "torus": TORUS, "superquadric": SUPERQUADRIC}
CONVEX = (SPHERE, ELLIPSOID, SUPERQUADRIC)

_level = Function("core_level", REAL, (REALS, REALS, REALS_OUT, REALS_OUT))
_support = Function("core_support", None, (REALS, INTEGER, REALS, REALS_OUT))


class Surface(NamedTuple):
    """A surface in its body's axes: kind, five sizes [m] or exponents, and side +1, or -1 where the body is outside."""

    kind: int
    sizes: tuple[float, float, float, float, float]
    side: float

    def numbers(self) -> np.ndarray:
        """The same (7,) as the core reads it."""
        return np.array([self.kind, *self.sizes, self.side], float)


class Level(NamedTuple):
    """f [m] of a surface at a point, its gradient (3,) and its Hesse matrix (3, 3) [1/m]."""

    value: float
    gradient: np.ndarray
    hesse: np.ndarray


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
    return Surface(kind, tuple(float(size) for size in (*sizes, 0.0, 0.0, 0.0, 0.0)[:5]), side)


def _positive(**sizes):
    for name, size in sizes.items():
        if not (math.isfinite(size) and size > 0.0):
            raise SceneError(f"{name} = {size:g} must be a finite number of metres above zero")


def level(surface: Surface, point) -> Level:
    """The surface's function at a point [m] (3,) of its own axes; undefined on a torus' axis."""
    gradient, hesse = np.empty(3), np.empty((3, 3))
    return Level(_level(surface.numbers(), np.array(point, float), gradient, hesse), gradient, hesse)


def support(surface: Surface, directions) -> np.ndarray:
    """The farthest points (..., 3) [m] of a sphere, ellipsoid or superquadric along directions, in the body's axes."""
    directions = np.array(directions, float)
    points = np.empty_like(directions)
    _support(surface.numbers(), directions.size // 3, directions, points)
    return points
