"""Numbers that follow from the keys of two bodies; what is impossible; what is left open."""

import dataclasses
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.contact import ellipse
from bearing_twin.contact import hertz_impact as impact
from bearing_twin.contact.laws import numbers_missing
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.kinds.sections import check_damping, check_run, resolved_run
from bearing_twin.kinds.two_bodies.compiled import Rigid
from bearing_twin.kinds.two_bodies.parameters import FREE, HELD, OVERLAP, TRACKINGS, Shaped, TwoBodiesScene
from bearing_twin.numerics.rotation import quaternion_from_vector, rotation_matrix
from bearing_twin.shapes.implicit import (
    CONVEX,
    FOUND,
    LAMBDA,
    NO_ELLIPSE,
    REFUSALS,
    Body,
    Opposition,
    Surface,
    body,
    closed_form_known,
    contact_of,
    ellipsoid,
    find_opposing,
    nearest_pair,
    opposition_of,
    plane,
    sphere,
    superquadric,
    torus,
)

DEEPEST = 0.1  # of the least size: a start pressed in deeper is no small deformation
GREATEST_ASPECT = 30.0  # longest over shortest semi-axis
SUPERELLIPSOID = "superellipsoid"  # the only shape that may have flat places
SAME = 1e-9  # of the size: approaches nearer than this are one


class ShapeRow(NamedTuple):
    """A shape: its keys, its `Surface`, its volume and mean squares of x, y, z [m^2] or None where it must be held."""

    keys: tuple[str, ...]
    surface: Callable[[Shaped], Surface]
    solid: Callable[[Shaped], tuple[float, tuple[float, float, float]]] | None
    sizes: Callable[[Shaped], tuple[float, ...]]


def _solid_ellipsoid(axes) -> tuple[float, tuple[float, float, float]]:
    return 4.0 / 3.0 * math.pi * math.prod(axes), tuple(0.2 * axis**2 for axis in axes)


def _solid_superellipsoid(one: Shaped) -> tuple[float, tuple[float, float, float]]:
    """Volume and mean squares by Beta functions, from the slices z = constant, each (1 - z^m)^(1/m) as wide."""
    (a, b, c), (n, m) = one.semi_axes, one.exponents
    g = math.gamma
    area = 4.0 * g(1.0 + 1.0 / n) ** 2 / g(1.0 + 2.0 / n)
    square = 4.0 / n * g(3.0 / n) * g(1.0 + 1.0 / n) / g(1.0 + 4.0 / n)  # integral of x^2 over the slice

    def heights(power, moment):
        """Integral over -1 < z < 1 of (1 - |z|^m)^(power/m) |z|^moment."""
        return 2.0 / m * g((moment + 1.0) / m) * g(1.0 + power / m) / g(1.0 + (power + moment + 1.0) / m)

    whole = area * heights(2.0, 0.0)
    across = square * heights(4.0, 0.0) / whole
    return a * b * c * whole, (a * a * across, b * b * across, c * c * area * heights(2.0, 2.0) / whole)


ROWS = {
    "plane": ShapeRow((), lambda one: plane(), None, lambda one: (math.inf,)),
    "sphere": ShapeRow(
        ("radius",), lambda one: sphere(one.radius), lambda one: _solid_ellipsoid((one.radius,) * 3),
        lambda one: (one.radius,),
    ),
    "ellipsoid": ShapeRow(
        ("semi_axes",), lambda one: ellipsoid(*one.semi_axes), lambda one: _solid_ellipsoid(one.semi_axes),
        lambda one: one.semi_axes,
    ),
    "superellipsoid": ShapeRow(
        ("semi_axes", "exponents"), lambda one: superquadric(*one.semi_axes, *one.exponents), _solid_superellipsoid,
        lambda one: one.semi_axes,
    ),
    "groove": ShapeRow(
        ("radius", "ring_radius"), lambda one: torus(one.ring_radius, one.radius, hollow=True), None,
        lambda one: (one.radius, one.ring_radius + one.radius),
    ),
}  # fmt: skip
"""THE table of shapes: another body is a surface in `shapes.implicit` and a row here."""


def reach_of(one: Shaped) -> float:
    """No point of the surface is farther [m] from the centre; inf of a plane."""
    sizes = ROWS[one.shape].sizes(one)
    return math.hypot(*sizes) if one.shape == "superellipsoid" else max(sizes)


def size_of(parameters: TwoBodiesScene) -> float:
    """The least size [m] of the two bodies."""
    return min(min(ROWS[one.shape].sizes(one)) for one in (parameters.first, parameters.second))


def rigid_of(one: Shaped) -> Rigid:
    """Mass and principal moments of inertia m (<y^2> + <z^2>) and so on; a held body's spin is its momentum."""
    row = ROWS[one.shape]
    if one.motion == HELD:
        return Rigid(row.surface(one), 0.0, (1.0, 1.0, 1.0), reach_of(one))
    volume, (x, y, z) = row.solid(one)
    mass = one.mass or volume * one.material.density
    inertia = mass * (y + z), mass * (z + x), mass * (x + y)
    return Rigid(row.surface(one), mass, inertia, reach_of(one))


def start_body(one: Shaped) -> Body:
    """The body (`tracking.Body`) at the start."""
    turn = rotation_matrix(quaternion_from_vector(one.turn))
    return body(ROWS[one.shape].surface(one), one.position, turn, one.velocity, one.angular_velocity)


def modulus_of(parameters: TwoBodiesScene) -> float:
    """Effective modulus [Pa] of the pair."""
    return effective_modulus(parameters.first.material, parameters.second.material)


def has_closed_form(parameters: TwoBodiesScene) -> bool:
    """True if a closed form gives the opposing points of both shapes."""
    return closed_form_known(*(ROWS[one.shape].surface(one).kind for one in (parameters.first, parameters.second)))


def tracking_of(parameters: TwoBodiesScene) -> int:
    """The number of the way to find opposing points: as specified, else in closed form where there is one."""
    specified = parameters.contact.tracking
    if specified == "auto":
        specified = "closed" if has_closed_form(parameters) else "algebraic"
    return TRACKINGS.index(specified)


def start_unknowns(parameters: TwoBodiesScene) -> np.ndarray:
    """Opposing points at the start, unknowns (8,) of `shapes.opposing`; raises SceneError where there are none."""
    a, b = start_body(parameters.first), start_body(parameters.second)
    return nearest_pair(a, b) if has_closed_form(parameters) else searched(a, b, size_of(parameters))


def searched(a: Body, b: Body, size: float) -> np.ndarray:
    """The nearest of all opposing points that Newton's method finds from places around both bodies.

    Raises SceneError where none is found, or several are equally near.
    """
    middle = 0.5 * (a.position + b.position)
    whole = max(float(np.linalg.norm(a.position - b.position)), size)
    directions = [np.array([x, y, z], float) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)]
    centres = [a.position, b.position, middle]
    nears = [middle, *(centre + size * way for centre in centres for way in directions if way.any())]
    nears += [b.position + whole * way / np.linalg.norm(way) for way in directions if way.any()]
    found = []
    for near in nears:
        try:
            unknowns = find_opposing(a, b, near)
        except SceneError:
            continue
        at = opposition_of(a, b, unknowns)
        if at.kind == FOUND or (at.kind == NO_ELLIPSE and unknowns[LAMBDA] < 0.0):
            found.append((at.approach, unknowns))
    if not found:
        raise SceneError(
            "no opposing points of the two bodies were found at the start; bring them nearer to each other"
        )
    nearest, best = max(found, key=lambda one: one[0])
    for approach, unknowns in found:
        if nearest - approach < SAME * size and np.linalg.norm(unknowns[:3] - best[:3]) > 1e-6 * size:
            raise SceneError(
                "the bodies have several closest points at the start: one contact is all that this kind knows; move "
                "or turn one of them"
            )
    return best


def start_opposition(parameters: TwoBodiesScene) -> Opposition:
    """The opposing points at the start; raises SceneError where there are none."""
    return opposition_of(start_body(parameters.first), start_body(parameters.second), start_unknowns(parameters))


def start_contact(parameters: TwoBodiesScene) -> Opposition:
    """The opposing points at the start as a contact; raises SceneError where they are none in an ellipse."""
    return contact_of(start_body(parameters.first), start_body(parameters.second), start_unknowns(parameters))


def greatest_speed(parameters: TwoBodiesScene) -> float:
    """About the greatest speed [m/s] at which the bodies meet: at the start, by their turning, and by the fall."""
    one, other = parameters.first, parameters.second
    relative = math.dist(one.velocity, other.velocity)
    for body_, against in ((one, other), (other, one)):
        reach = min(reach_of(body_), math.dist(one.position, other.position) + reach_of(against))
        relative += math.hypot(*body_.angular_velocity) * (reach if body_.motion == FREE else 0.0)
    gap = max(-start_opposition(parameters).approach, 0.0)
    return math.sqrt(relative**2 + 2.0 * math.hypot(*parameters.gravity) * (gap + size_of(parameters)))


def shortest_contact(parameters: TwoBodiesScene) -> float:
    """Contact time [s] at the greatest speed between spheres of the least size, by Hertz: no bounce is much shorter."""
    inverse = sum(rigid_of(one).inverse_mass for one in (parameters.first, parameters.second))
    coefficient = 4.0 / 3.0 * modulus_of(parameters) * math.sqrt(size_of(parameters))
    return float(impact.contact_time(coefficient, 0.3 / inverse, max(greatest_speed(parameters), 1e-6), 1.5))


def _shape_problems(name: str, one: Shaped) -> list[str]:
    """What is wrong with one body by itself."""
    problems, row = [], ROWS[one.shape]
    default = Shaped()
    for key in ("radius", "ring_radius", "semi_axes", "exponents"):
        value, wanted = getattr(one, key), key in row.keys
        if wanted and not min(value if isinstance(value, tuple) else (value,)) > 0.0:
            problems.append(f"{name}.shape = {one.shape} needs {name}.{key} above zero")
        if not wanted and value != getattr(default, key):
            problems.append(f"{name}.{key} is nothing a {one.shape} has; leave it out")
    if problems:
        return problems
    if one.shape == "superellipsoid" and not all(2.0 <= exponent <= 50.0 for exponent in one.exponents):
        problems.append(
            f"{name}.exponents = {list(one.exponents)} must lie between 2 (an ellipsoid) and 50: below 2 a "
            "superellipsoid has edges, and far above it is a box"
        )
    if one.shape in ("ellipsoid", "superellipsoid") and max(one.semi_axes) > GREATEST_ASPECT * min(one.semi_axes):
        problems.append(
            f"{name}.semi_axes = {list(one.semi_axes)} m: the longest is more than {GREATEST_ASPECT:g} times the "
            "shortest, whose contacts are nearly lines; choose a rounder body"
        )
    if one.shape == "groove" and one.radius >= one.ring_radius:
        problems.append(f"{name}.radius = {one.radius:g} m of the tube must be below {name}.ring_radius")
    if row.solid is None and one.motion != HELD:
        problems.append(f"{name}.shape = {one.shape} has no mass of its own; give {name}.motion: held")
    return problems


def check(parameters: TwoBodiesScene) -> list[str]:
    """What is impossible although each number alone is legal."""
    one, other, contact = parameters.first, parameters.second, parameters.contact
    problems = [*_shape_problems("first", one), *_shape_problems("second", other)]
    if one.motion == HELD and other.motion == HELD:
        problems.append("both bodies are held, so nothing moves; give one of them motion: free")
    if not problems:
        kinds = [ROWS[body_.shape].surface(body_).kind for body_ in (one, other)]
        if not set(kinds) & set(CONVEX):
            problems.append(
                f"first.shape = {one.shape} and second.shape = {other.shape} are both open or hollow and may touch at "
                "several points; one of them must be a sphere, an ellipsoid or a superellipsoid"
            )
        elif contact.tracking == "closed" and not has_closed_form(parameters):
            problems.append(
                f"contact.tracking = closed: a {one.shape} and a {other.shape} have no closed form; use algebraic or "
                "differential"
            )
    problems += numbers_missing(contact)
    problems += check_damping(contact, False)
    if contact.normal == OVERLAP and contact.stiffness:
        problems.append("contact.stiffness belongs to contact.normal: linear; leave it out")
    if not (parameters.run.duration and parameters.run.output_rate):
        problems.append("run.duration and run.output_rate must be above 0; give seconds and Hz")
    problems += check_run(parameters.run)
    return problems or _start_problems(parameters)


def _start_problems(parameters: TwoBodiesScene) -> list[str]:
    """What is wrong with where the bodies are at the start."""
    try:
        unknowns = start_unknowns(parameters)
    except SceneError as error:
        return [str(error)]
    at, size = start_opposition(parameters), size_of(parameters)
    kind, approach = at.kind, at.approach
    if not np.all(np.isfinite(unknowns)):
        return ["the bodies' centres coincide, so they have no opposing points; move one of them"]
    if kind not in (FOUND, NO_ELLIPSE) or unknowns[LAMBDA] >= 0.0:
        return [f"at the start the nearest pair of points {REFUSALS[kind]}; move one of the bodies"]
    if kind == NO_ELLIPSE and parameters.contact.normal not in ("auto", OVERLAP):
        return [
            f"at the start the contact {REFUSALS[kind].removeprefix('is ')}: contact.normal = "
            f"{parameters.contact.normal} knows none such; use overlap, or turn one of the bodies"
        ]
    if approach > DEEPEST * size:
        return [
            f"at the start the bodies press {approach:.3g} m into each other, more than {DEEPEST:g} of the least size "
            f"{size:g} m; move one of them"
        ]
    if kind == FOUND and approach > at.curvature_small * size**2:
        return [
            f"at the start the bodies press {approach:.3g} m into each other, so that they would touch over more than "
            f"the least size {size:g} m, which no law here knows; move one of them, or let them fit less closely"
        ]
    return []


def resolve(parameters: TwoBodiesScene) -> TwoBodiesScene:
    """The parameters of a checked scene with the zeros of its run replaced."""
    return dataclasses.replace(parameters, run=resolved_run(parameters.run))


def axis_ratio(parameters) -> float:
    """b/a of the contact that the scene starts from; raises SceneError where that is no ellipse."""
    start = start_contact(parameters)
    return ellipse.axis_ratio(start.curvature_small, start.curvature_large)


def greatest_exponent(parameters) -> float | None:
    """Of both bodies; None where neither is a superellipsoid."""
    bodies = (parameters.first, parameters.second)
    return max((max(one.exponents) for one in bodies if one.shape == SUPERELLIPSOID), default=None)
