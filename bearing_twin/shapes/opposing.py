"""The opposing points of two implicit surfaces and the overlap of bodies, by the core (`core/shapes/opposing.hpp`).

Paper 1, section 2. The eight unknowns are the point P_A on body A, P_B on body B (fixed axes), and the multipliers
lambda and mu of

    grad g_A(P_A) = lambda grad g_B(P_B),   P_A - P_B = mu grad g_B(P_B),   g_A(P_A) = 0,   g_B(P_B) = 0       (1)

with gradients outward, so lambda < 0 where the surfaces face each other; mu > 0 is a gap, mu < 0 contact. The system
has many more roots (far sides, saddles of the distance); `contact_of` recognises and refuses them.
"""

from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.core import INTEGER, REAL, REALS, REALS_OUT, Function
from bearing_twin.shapes.implicit import Surface

LAMBDA, MU = 6, 7
CIRCULAR = 1e-9  # (Q - P)/(Q + P) below which the direction of the ellipse is noise
FOUND, FAR_SIDE, SADDLE, NO_ELLIPSE = range(4)  # RootKind of the core
REFUSALS = {
    FAR_SIDE: "lies on a far side: the surfaces do not face each other there",
    SADDLE: "is a saddle of the distance, not its least value",
    NO_ELLIPSE: "is no contact in an ellipse: the surfaces conform, cross or are flat there",
}

_closed_form_known = Function("core_closed_form_known", INTEGER, (INTEGER, INTEGER))
_nearest_pair = Function("core_nearest_pair", None, (REALS, REALS, REALS_OUT))
_residual = Function("core_opposing_residual", None, (REALS, REALS, REALS, REALS_OUT))
_settle = Function("core_settle", INTEGER, (REALS, REALS, REALS_OUT))
_project = Function("core_project", INTEGER, (REALS, REALS, REALS_OUT))
_find = Function("core_find_opposing", INTEGER, (REALS, REALS, REALS, INTEGER, REALS_OUT))
_rates = Function("core_opposing_rates", INTEGER, (REALS, REALS, REALS, REALS_OUT, REALS_OUT))
_opposition = Function("core_opposition", INTEGER, (REALS, REALS, REALS, REALS_OUT))
_overlap = Function("core_overlap", None, (*(REALS,) * 5, REAL, REAL, REAL, REALS_OUT))


class Body(NamedTuple):
    """A surface in motion: position [m] (3,), rotation (3, 3) from body to fixed axes, velocity, angular velocity."""

    surface: Surface
    position: np.ndarray
    rotation: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray

    def numbers(self) -> np.ndarray:
        """The same (25,) as the core reads it."""
        return np.concatenate([self.surface.numbers(), *(np.ravel(one) for one in self[1:])])


class Opposition(NamedTuple):
    """Where two bodies face each other: points [m], normal outward of A, approach [m] > 0 in contact, the gap's form.

    The gap is z = P x^2 + Q y^2 (paper 1, eq. 6), P = `curvature_small` <= Q [1/m], x along `major_axis` (3,);
    `circular` is true where P = Q and the axis is arbitrary. `kind` is FOUND, or a key of REFUSALS.
    """

    point_a: np.ndarray
    point_b: np.ndarray
    normal: np.ndarray
    approach: float
    curvature_small: float
    curvature_large: float
    major_axis: np.ndarray
    circular: bool
    kind: int


class Overlap(NamedTuple):
    """An overlap: energy [J], load [N], volume [m^3], area [m^2], perimeter [m], half-widths [m], centre (2,) [m].

    `centre_x`, `centre_y` are the centre of the volume in the tangent axes; `found` is False where there is none.
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


def body(surface: Surface, position=(0, 0, 0), rotation=None, velocity=(0, 0, 0), spin=(0, 0, 0)) -> Body:
    """A `Body` from plain sequences; without a rotation its axes are the fixed ones."""
    turn = np.eye(3) if rotation is None else rotation
    return Body(surface, *(np.array(one, dtype=float) for one in (position, turn, velocity, spin)))


def closed_form_known(kind_a: int, kind_b: int) -> bool:
    """True if `nearest_pair` knows the opposing points of these kinds of `implicit.Surface`."""
    return bool(_closed_form_known(kind_a, kind_b))


def nearest_pair(a: Body, b: Body) -> np.ndarray:
    """The unknowns (8,) of a plane and a convex body, or of a sphere and what has a nearest point, in closed form."""
    unknowns = np.empty(8)
    _nearest_pair(a.numbers(), b.numbers(), unknowns)
    return unknowns


def opposing_error(a: Body, b: Body, unknowns) -> float:
    """Distance [m] by which the unknowns miss the equations (1)."""
    residual = np.empty(8)
    _residual(a.numbers(), b.numbers(), np.array(unknowns, float), residual)
    return float(np.linalg.norm(residual[3:]))


def settled(a: Body, b: Body, unknowns) -> np.ndarray | None:
    """The unknowns after Newton's method on (1) from opposing points nearby; None where it comes to no end."""
    found = np.array(unknowns, float)
    return found if _settle(a.numbers(), b.numbers(), found) else None


def projected(a: Body, b: Body, unknowns) -> np.ndarray | None:
    """The unknowns after one Newton step on (1), which follows a step of the differential form; None if singular."""
    found = np.array(unknowns, float)
    return found if _project(a.numbers(), b.numbers(), found) else None


def find_opposing(a: Body, b: Body, near, iterations: int = 60) -> np.ndarray:
    """The unknowns (8,) of equations (1) by damped Newton steps from a point [m] (3,) `near` the expected contact.

    Which root it is `contact_of` says. Raises SceneError where the steps come to no end.
    """
    unknowns = np.empty(8)
    if not _find(a.numbers(), b.numbers(), np.array(near, float), iterations, unknowns):
        raise SceneError("no pair of opposing points was found from there; start nearer to the contact")
    return unknowns


def opposing_rates(a: Body, b: Body, unknowns) -> tuple[np.ndarray, np.ndarray] | None:
    """Rates (8,) of the unknowns by paper 1, eqs. (2)-(3), and the angular velocity (3,) of the contact frame [rad/s].

    The frame's third axis is A's normal gamma, Omega = gamma x d(gamma)/dt. None where the equations are singular.
    """
    rates, spin = np.empty(8), np.empty(3)
    known = _rates(a.numbers(), b.numbers(), np.array(unknowns, float), rates, spin)
    return (rates, spin) if known and np.isfinite(rates).all() else None


def opposition_of(a: Body, b: Body, unknowns) -> Opposition:
    """What a root of (1) is: points, normal, approach, gap curvatures (eqs. 4-6), and its kind."""
    found, unknowns = np.empty(12), np.array(unknowns, float)
    kind = _opposition(a.numbers(), b.numbers(), unknowns, found)
    approach, small, large = map(float, found[3:6])
    circular = bool(large - small <= CIRCULAR * (large + small))
    return Opposition(unknowns[:3], unknowns[3:6], found[:3], approach, small, large, found[6:9], circular, kind)


def contact_of(a: Body, b: Body, unknowns) -> Opposition:
    """The same of a contact in an ellipse; raises SceneError at a wrong root."""
    found = opposition_of(a, b, unknowns)
    if found.kind != FOUND:
        raise SceneError(f"the pair of points found {REFUSALS[found.kind]}; start nearer to the contact")
    return found


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
