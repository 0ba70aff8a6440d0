"""Surfaces of bodies, where two of them touch, and rotations.

A surface is the zero set of a function f, negative inside the body, in metres and with a gradient near 1. A `Surface`
is made by the function with the name of its kind. The core computes them (`core/shapes/`).

Opposing points (paper 1, section 2): the eight unknowns are the point P_A on body A, P_B on body B (fixed axes), and
the multipliers lambda and mu of

    grad g_A(P_A) = lambda grad g_B(P_B),   P_A - P_B = mu grad g_B(P_B),   g_A(P_A) = 0,   g_B(P_B) = 0       (1)

with gradients outward, so lambda < 0 where the surfaces face each other; mu > 0 is a gap, mu < 0 contact. The system
has many more roots (far sides, saddles of the distance); `contact_of` recognises and refuses them. For a ball in a
toroidal groove (paper 1, section 5) and an ellipsoid on a plane the gap is known in closed form.

Rotations are unit quaternions (..., 4) of x, y, z, w.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.core import INTEGER, REAL, REALS, REALS_OUT, Function, elementwise

PLANE, SPHERE, ELLIPSOID, TORUS, SUPERQUADRIC = range(5)  # SurfaceKind of the core
CONVEX = (SPHERE, ELLIPSOID, SUPERQUADRIC)

_support = Function("core_support", None, (REALS, INTEGER, REALS, REALS_OUT))


class Surface(NamedTuple):
    """A surface in its body's axes: kind, five sizes [m] or exponents, and side +1, or -1 where the body is outside."""

    kind: int
    sizes: tuple[float, float, float, float, float]
    side: float

    def numbers(self) -> np.ndarray:
        """The surface as the numbers (7,) of the core."""
        return np.array([self.kind, *self.sizes, self.side], float)


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


def support(surface: Surface, directions) -> np.ndarray:
    """The farthest points (..., 3) [m] of a sphere, ellipsoid or superquadric along directions, in the body's axes."""
    directions = np.array(directions, float)
    points = np.empty_like(directions)
    _support(surface.numbers(), directions.size // 3, directions, points)
    return points


LAMBDA, MU = 6, 7
CIRCULAR = 1e-9  # (Q - P)/(Q + P) below which the direction of the ellipse is noise
FOUND, FAR_SIDE, SADDLE, NO_ELLIPSE = range(4)  # RootKind of the core
REFUSALS = {
    FAR_SIDE: "lies on a far side: the surfaces do not face each other there",
    SADDLE: "is a saddle of the distance, not its least value",
    NO_ELLIPSE: "is no contact in an ellipse: the surfaces conform, cross or are flat there",
}

_nearest_pair = Function("core_nearest_pair", None, (REALS, REALS, REALS_OUT))
_find = Function("core_find_opposing", INTEGER, (REALS, REALS, REALS, INTEGER, REALS_OUT))
_opposition = Function("core_opposition", INTEGER, (REALS, REALS, REALS, REALS_OUT))


class Body(NamedTuple):
    """A surface in motion: position [m] (3,), rotation (3, 3) from body to fixed axes, velocity, angular velocity."""

    surface: Surface
    position: np.ndarray
    rotation: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray

    def numbers(self) -> np.ndarray:
        """The body as the numbers (25,) of the core."""
        return np.concatenate([self.surface.numbers(), *(np.ravel(field) for field in self[1:])])


class Opposition(NamedTuple):
    """Opposing points of two bodies [m], normal outward of A, approach [m] > 0 in contact, the gap's form.

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


def body(surface: Surface, position=(0, 0, 0), rotation=None, velocity=(0, 0, 0), spin=(0, 0, 0)) -> Body:
    """A `Body` from plain sequences; without a rotation its axes are the fixed ones."""
    turn = np.eye(3) if rotation is None else rotation
    return Body(surface, *(np.array(vector, dtype=float) for vector in (position, turn, velocity, spin)))


def closed_form_known(kind_a: int, kind_b: int) -> bool:
    """True if `nearest_pair` knows the opposing points of these kinds of `Surface`."""
    kinds = {kind_a, kind_b}
    return (PLANE in kinds and bool(kinds & {*CONVEX})) or (SPHERE in kinds and kinds <= {SPHERE, TORUS})


def nearest_pair(a: Body, b: Body) -> np.ndarray:
    """The unknowns (8,) of a plane and a convex body, or of a sphere and what has a nearest point, in closed form."""
    unknowns = np.empty(8)
    _nearest_pair(a.numbers(), b.numbers(), unknowns)
    return unknowns


def find_opposing(a: Body, b: Body, near, iterations: int = 60) -> np.ndarray:
    """The unknowns (8,) of equations (1) by damped Newton steps from a point [m] (3,) `near` the expected contact.

    Which root it is `contact_of` says. Raises SceneError where the steps come to no end.
    """
    unknowns = np.empty(8)
    if not _find(a.numbers(), b.numbers(), np.array(near, float), iterations, unknowns):
        raise SceneError("no pair of opposing points was found from there; start nearer to the contact")
    return unknowns


def opposition_of(a: Body, b: Body, unknowns) -> Opposition:
    """Properties of a root of (1): points, normal, approach, gap curvatures (eqs. 4-6), and its kind."""
    numbers, unknowns = np.empty(12), np.array(unknowns, float)
    kind = _opposition(a.numbers(), b.numbers(), unknowns, numbers)
    approach, small, large = map(float, numbers[3:6])
    circular = bool(large - small <= CIRCULAR * (large + small))
    return Opposition(unknowns[:3], unknowns[3:6], numbers[:3], approach, small, large, numbers[6:9], circular, kind)


def contact_of(a: Body, b: Body, unknowns) -> Opposition:
    """Properties of a contact in an ellipse; raises SceneError at a wrong root."""
    opposition = opposition_of(a, b, unknowns)
    if opposition.kind != FOUND:
        raise SceneError(f"the pair of points found {REFUSALS[opposition.kind]}; start nearer to the contact")
    return opposition


_curvatures = Function("core_groove_curvatures", None, (REAL, REAL, REAL, INTEGER, REALS, REALS_OUT, REALS_OUT))
_gaps = Function("core_ellipsoid_gaps", None, (REALS, INTEGER, REALS, REALS_OUT))
_PARTS = (1, 4, 5, 6, 9)  # where the fields of a LowestPoint begin, but the first


class GrooveContact(NamedTuple):
    """A ball against a toroidal groove, in the meridian plane of the ball (radial, axial)."""

    approach: float
    normal_radial: float
    normal_axial: float
    curvature_small: float
    curvature_large: float


def groove_curvatures(ball_radius, locus_radius, groove_radius, normal_radial):
    """Curvatures (small, large) of the gap [1/m] where the normal has these radial parts, numbers or an array.

    Halves of the relative principal curvatures: the small one along the meridian, the large one along the rolling
    direction.
    """
    return tuple(elementwise(_curvatures, 2, (ball_radius, locus_radius, groove_radius), normal_radial))


def ball_in_groove(axis_distance, axial, ball_radius, locus_radius, groove_radius) -> GrooveContact:
    """Approach [m], outward normal and gap curvatures [1/m] of a ball in a toroidal groove (paper 1, section 5).

    `axis_distance` [m] is the ball centre's distance from the ring's axis, `axial` [m] its height above the ring's
    plane; the groove's centre circle has radius `locus_radius`, its meridian `groove_radius` > ball radius. The
    normal points from the ball's centre to the raceway: outwards on an outer ring (the ball is outside the centre
    circle), inwards on an inner ring; one formula serves both. On the centre circle itself, where the approach is far
    below zero, the normal is returned as zero.
    """
    radial = axis_distance - locus_radius
    distance = math.hypot(radial, axial)
    normal = (radial / distance, axial / distance) if distance else (0.0, 0.0)
    curvatures = groove_curvatures(ball_radius, locus_radius, groove_radius, normal[0])
    return GrooveContact(distance + ball_radius - groove_radius, *normal, *curvatures)


class LowestPoint(NamedTuple):
    """The farthest points of an ellipsoid along directions, in its own axes, and their gaps to a plane.

    `reach` [m] is the extent along the direction; `point` [m] and `major_axis` (unit, along `curvature_small`) are
    vectors (..., 3); the gap is z = P x^2 + Q y^2 with P = `curvature_small` <= Q = `curvature_large` [1/m]. `excess` =
    sqrt(shape^2 - 1), shape = (P + Q)/(2 sqrt(PQ)), is 0 where the gap is round.
    """

    reach: np.ndarray
    point: np.ndarray
    curvature_small: np.ndarray
    curvature_large: np.ndarray
    major_axis: np.ndarray
    excess: np.ndarray


def ellipsoid_on_plane(semi_axes, directions) -> LowestPoint:
    """The farthest points along unit directions (..., 3) in the ellipsoid's axes; semi-axes (3,) in m."""
    directions = np.ascontiguousarray(directions, float)
    numbers = np.empty((*directions.shape[:-1], 10))
    _gaps(np.array(semi_axes, float), directions.size // 3, directions, numbers)
    parts = np.split(numbers, _PARTS, axis=-1)
    return LowestPoint(*(part[..., 0] if part.shape[-1] == 1 else part for part in parts))


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


def rotate_by_step(quaternion, omega_start, omega_middle, omega_end, step) -> np.ndarray:
    """Orientations (..., 4) after `step` [s] at angular velocities (..., 3) [rad/s] at start, middle and end.

    In fixed axes. Fourth-order Magnus step; the result has unit norm, so nothing drifts.
    """
    start, middle, end = (np.asarray(omega, float) for omega in (omega_start, omega_middle, omega_end))
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
