"""Functions of the core that tests alone call: surfaces, tracking of opposing points, overlaps."""

from typing import NamedTuple

import numpy as np

from bearing_twin.core import INTEGER, REAL, REALS, REALS_OUT, Function
from bearing_twin.shapes import ELLIPSOID, PLANE, SPHERE, SUPERQUADRIC, TORUS, Body, Surface

SURFACES = {"plane": PLANE, "sphere": SPHERE, "ellipsoid": ELLIPSOID, "torus": TORUS, "superquadric": SUPERQUADRIC}

_level = Function("core_level", REAL, (REALS, REALS, REALS_OUT, REALS_OUT))
_residual = Function("core_opposing_residual", None, (REALS, REALS, REALS, REALS_OUT))
_project = Function("core_project", INTEGER, (REALS, REALS, REALS_OUT))
_rates = Function("core_opposing_rates", INTEGER, (REALS, REALS, REALS, REALS_OUT))
_overlap = Function("core_overlap", None, (*(REALS,) * 5, REAL, REAL, REAL, REALS_OUT))


class Level(NamedTuple):
    """f [m] of a surface at a point, its gradient (3,) and its Hesse matrix (3, 3) [1/m]."""

    value: float
    gradient: np.ndarray
    hesse: np.ndarray


class Overlap(NamedTuple):
    """An overlap: energy [J], load [N], volume [m^3], area [m^2], perimeter [m], half-widths [m], centre (2,) [m].

    `centre_x`, `centre_y` are where the load acts in the tangent axes; `found` is False where there is none.
    """

    found: bool
    energy: float
    load: float
    volume: float
    area: float
    perimeter: float
    half_width_x: float
    half_width_y: float
    centre_x: float
    centre_y: float


def level(surface: Surface, point) -> Level:
    """The surface's function at a point [m] (3,) of its own axes; undefined on a torus' axis."""
    gradient, hesse = np.empty(3), np.empty((3, 3))
    return Level(_level(surface.numbers(), np.array(point, float), gradient, hesse), gradient, hesse)


def opposing_error(a: Body, b: Body, unknowns) -> float:
    """Distance [m] by which the unknowns miss the equations (1)."""
    residual = np.empty(8)
    _residual(a.numbers(), b.numbers(), np.array(unknowns, float), residual)
    return float(np.linalg.norm(residual[3:]))


def projected(a: Body, b: Body, unknowns) -> np.ndarray | None:
    """The unknowns after one Newton step on (1), which follows a step of the differential form; None if singular."""
    found = np.array(unknowns, float)
    return found if _project(a.numbers(), b.numbers(), found) else None


def opposing_rates(a: Body, b: Body, unknowns) -> np.ndarray:
    """Rates (8,) of the unknowns by paper 1, eqs. (2)-(3)."""
    rates = np.empty(8)
    assert _rates(a.numbers(), b.numbers(), np.array(unknowns, float), rates)
    return rates


def tangent_axes(normal) -> np.ndarray:
    """Two unit vectors as rows (2, 3) that complete the unit vector `normal` to a right-handed frame."""
    normal = np.asarray(normal, float)
    first = np.eye(3)[np.argmin(np.abs(normal))]
    first = first - (first @ normal) * normal
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal, first)])


def overlap_of(a: Body, b: Body, origin, axes, normal, approach: float, size: float, modulus: float) -> Overlap:
    """The overlap of two bodies that press into each other by `approach` > 0 [m] (`core/shapes/overlap.hpp`).

    `origin` (3,) lies between the opposing points, `normal` (3,) is outward of A there, `axes` (2, 3) complete it;
    `size` [m] is about the bodies' least radius, `modulus` E* [Pa].
    """
    found = np.empty(10)
    places = (np.array(one, float) for one in (origin, axes, normal))
    _overlap(a.numbers(), b.numbers(), *places, approach, size, modulus, found)
    return Overlap(bool(found[0]), *found[1:].tolist())
