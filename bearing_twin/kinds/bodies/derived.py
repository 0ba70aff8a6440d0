"""Numbers derived from the parameters of bodies that collide; checks of the parameters; automatic values and models."""

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.base.report import Choice
from bearing_twin.contact import hertz_impact
from bearing_twin.contact import line as line_contact
from bearing_twin.contact.elasticity import axis_ratio as ratio_of
from bearing_twin.contact.elasticity import coefficient_of, ellipse, hertz_coefficient, sphere_coefficient
from bearing_twin.contact.friction import FRICTIONS, roughness
from bearing_twin.contact.laws import LAWS, damping_for_restitution, law_names, numbers_missing, restitution_of
from bearing_twin.contact.line import greatest_energy, line_law
from bearing_twin.contact.validity import wave_transit
from bearing_twin.kinds.bodies.parameters import (
    BODY,
    FEW_STEPS,
    FEWEST_STEPS,
    FIRST,
    FIXED_STEP,
    FREE,
    HELD,
    MOST_STEPS,
    OVERLAP,
    SECOND,
    TRACKINGS,
    Body,
    Disc,
    EllipsoidOnPlaneScene,
    Meeting,
    Shaped,
    SphereContact,
    TwoBodiesScene,
    TwoDiscsScene,
    TwoSpheresScene,
)
from bearing_twin.kinds.rules import BODIES, DISCS, ELLIPSOID, SPHERES, answers, drift, idle_step, odd_mass, sentences
from bearing_twin.kinds.sections import check_damping, check_run, resolved_run
from bearing_twin.shapes import (
    CONVEX,
    FOUND,
    LAMBDA,
    NO_ELLIPSE,
    REFUSALS,
    Surface,
    closed_form_known,
    contact_of,
    ellipsoid,
    ellipsoid_on_plane,
    find_opposing,
    nearest_pair,
    opposition_of,
    plane,
    quaternion_from_vector,
    rotation_matrix,
    sphere,
    superquadric,
    torus,
)
from bearing_twin.shapes import Body as MovingBody
from bearing_twin.shapes import (
    body as moving_body,
)

LEAST_RESTITUTION = 1e-300  # lower bound, where rounding gives 0
OUTPUTS = 400  # of an impact whose output_rate is automatic
GRID = 13  # directions over a quarter turn, where a law is weighed over the surface of an ellipsoid
REAL_AXIS = 2.785  # rk4 is stable for decay rates up to this over its step
GREATEST_ASPECT = 30.0  # longest over shortest semi-axis: beyond it contacts are nearly lines
MAX_APPROACH = 0.1  # of the least size, at the start: beyond it deformations are not small
SUPERELLIPSOID = "superellipsoid"  # the only shape that may have flat places
EQUAL_DISTANCE = 1e-9  # of the size: difference of approaches that count as equal
RATIONAL = 1e-9  # error of the rational form of hertz: no warning of a law within it
JOHNSON_ERROR = 0.04
"""Of force and contact time of slow discs by Johnson in plane strain.

Study: `tests/core/algorithms/test_impact_physics.py`."""
SPEED_ERROR = 3.0
"""Error of force or contact time by Johnson's law over the disc's speed as a share of that of waves in it.

Against `soft_discs` (against: disc, contact.stiffness_ratio: 300, 24 divisions of order 3, Poisson's ratio 0.3, force
averaged over 2 % of the contact), at shares of 0.01, 0.03, 0.06, 0.1 and 0.14 the force is 3, 10, 18, 30 and 42 % too
great and the contact time 3, 0, -5, -9 and -14 % off; the force is 2 to 5 % less off with a ratio of 0, more with
0.45 (`tests/core/algorithms/test_impact_physics.py`).
"""


class ShapeRow(NamedTuple):
    """A shape: its keys, its `Surface`, its volume and mean squares of x, y, z [m^2] or None where it must be held.

    `sizes` are about its radii [m].
    """

    keys: tuple[str, ...]
    surface: Callable[[Shaped], Surface] | None
    solid: Callable[[Shaped], tuple[float, tuple[float, float, float]]] | None
    sizes: Callable[[Shaped], tuple[float, ...]]


def _solid_ellipsoid(axes) -> tuple[float, tuple[float, float, float]]:
    return 4.0 / 3.0 * math.pi * math.prod(axes), tuple(0.2 * axis**2 for axis in axes)


def _solid_superellipsoid(body: Shaped) -> tuple[float, tuple[float, float, float]]:
    """Volume and mean squares by Beta functions, from the slices z = constant, each (1 - z^m)^(1/m) as wide."""
    (a, b, c), (n, m) = body.semi_axes, body.exponents
    g = math.gamma
    area = 4.0 * g(1.0 + 1.0 / n) ** 2 / g(1.0 + 2.0 / n)
    square = 4.0 / n * g(3.0 / n) * g(1.0 + 1.0 / n) / g(1.0 + 4.0 / n)  # integral of x^2 over the slice

    def heights(power, moment):
        """Integral over -1 < z < 1 of (1 - |z|^m)^(power/m) |z|^moment."""
        return 2.0 / m * g((moment + 1.0) / m) * g(1.0 + power / m) / g(1.0 + (power + moment + 1.0) / m)

    volume = area * heights(2.0, 0.0)
    across = square * heights(4.0, 0.0) / volume
    return a * b * c * volume, (a * a * across, b * b * across, c * c * area * heights(2.0, 2.0) / volume)


ROWS = {
    "plane": ShapeRow((), lambda body: plane(), None, lambda body: (math.inf,)),
    "sphere": ShapeRow(
        ("radius",), lambda body: sphere(body.radius), lambda body: _solid_ellipsoid((body.radius,) * 3),
        lambda body: (body.radius,),
    ),
    "ellipsoid": ShapeRow(
        ("semi_axes",), lambda body: ellipsoid(*body.semi_axes), lambda body: _solid_ellipsoid(body.semi_axes),
        lambda body: body.semi_axes,
    ),
    SUPERELLIPSOID: ShapeRow(
        ("semi_axes", "exponents"), lambda body: superquadric(*body.semi_axes, *body.exponents), _solid_superellipsoid,
        lambda body: body.semi_axes,
    ),
    "beam": ShapeRow(
        (), None, lambda body: (body.span * body.width * body.height, None), lambda body: (0.5 * body.height,)
    ),
    "disc": ShapeRow(
        (), None, lambda body: (math.pi * body.radius**2 * body.thickness, None), lambda body: (body.radius,)
    ),
    "groove": ShapeRow(
        ("radius", "ring_radius"), lambda body: torus(body.ring_radius, body.radius, hollow=True), None,
        lambda body: (body.radius, body.ring_radius + body.radius),
    ),
}  # fmt: skip
"""THE table of shapes: another body is a surface in `shapes` and a row here."""


# Bodies of all kinds


def homogeneous_mass(body: Body | Shaped) -> float:
    """Mass [kg] by size and density, whatever mass is given; numbers or arrays that broadcast."""
    return ROWS[body.shape].solid(body)[0] * body.material.density


def mass_of(body: Body | Shaped) -> float:
    """Mass [kg]: given, or that of the homogeneous body; numbers or arrays that broadcast."""
    return np.where(np.greater(body.mass, 0.0), body.mass, homogeneous_mass(body))[()]


def inertia_of(body: Body | Shaped) -> tuple[float, float, float]:
    """Principal moments of inertia [kg m^2], m (<y^2> + <z^2>) and so on."""
    mass, (x, y, z) = mass_of(body), ROWS[body.shape].solid(body)[1]
    return mass * (y + z), mass * (z + x), mass * (x + y)


def surface_of(body: Body | Shaped) -> Surface:
    """The surface of a body in its own axes."""
    return ROWS[body.shape].surface(body)


def reach_of(body: Body | Shaped) -> float:
    """The greatest distance [m] of points of the surface from the centre; inf for a plane."""
    sizes = ROWS[body.shape].sizes(body)
    return math.hypot(*sizes) if body.shape == SUPERELLIPSOID else max(sizes)


def bend_of(body: Shaped) -> float:
    """Bound [m] of the second derivative of the extent along a direction by the angle of rotation of the body.

    Infinite for a turning plane and for shapes whose bound is not known.
    """
    if body.shape == "plane":
        return math.inf if any(body.angular_velocity) else 0.0
    if body.shape not in ("sphere", "ellipsoid"):
        return math.inf
    low, high = min(ROWS[body.shape].sizes(body)), max(ROWS[body.shape].sizes(body))
    return high * high / low - low * low / high + (high * high - low * low) / low


def transit_of(body: Body | Shaped) -> float:
    """Time [s] of a wave through a body; 0 for a shape without mass."""
    solid = ROWS[body.shape].solid
    if solid is None:
        return 0.0
    return wave_transit(2.0 * reach_of(body), body.material.young_modulus, mass_of(body) / solid(body)[0])


# Two spheres and two discs


def sphere_law(parameters: TwoSpheresScene) -> str:
    """Name of the elastic law of two spheres."""
    contact = parameters.contact
    if contact.normal != "auto":
        return contact.normal
    return "measured" if np.any(np.greater(contact.measured_alpha, 0.0)) else "hertz"


def sphere_pair(parameters: TwoSpheresScene) -> tuple[float, float, float]:
    """(load coefficient [N/m^power], first mass, second mass [kg]) by the scene's law.

    Numbers or arrays that broadcast: studies evaluate many spheres at once.
    """
    first, second, contact = parameters.first, parameters.second, parameters.contact
    masses = mass_of(first), mass_of(second)
    law = sphere_law(parameters)
    radius = first.radius * second.radius / (first.radius + second.radius)
    bodies, stiffness = (parameters.modulus, radius), contact.stiffness
    if law == "measured":
        has_alpha = np.greater(contact.measured_alpha, 0.0)  # of many realisations some may not have one
        alpha = np.where(has_alpha, contact.measured_alpha, 1.0)
        measured = hertz_impact.coefficient_of_alpha(alpha, masses[0] * masses[1] / sum(masses))
        stiffness = np.where(has_alpha, measured, sphere_coefficient("hertz", *bodies))[()]
    return sphere_coefficient(law, *bodies, stiffness), *masses


def line_law_name(parameters: TwoDiscsScene) -> str:
    """Name of the law of line contact of two discs."""
    return "johnson" if parameters.contact.normal == "auto" else parameters.contact.normal


def disc_law(disc: Disc, name: str):
    """The line law of that name for these discs."""
    material = disc.material
    return line_law(name, disc.radius, disc.thickness, material.young_modulus, material.poisson_ratio)


def patch_of(parameters, load) -> tuple:
    """Semi-axes [m] and peak pressures [Pa] of the contact of two spheres or two discs under loads [N], by Hertz.

    Of discs they are half the length and half the width of the strip on which they touch.
    """
    first, second = parameters.bodies
    if not isinstance(first, Disc):
        curvature = 0.5 * (1.0 / first.radius + 1.0 / second.radius)
        return tuple(ellipse(curvature, curvature, parameters.modulus, load))
    per_length = load / first.thickness
    half_width = np.sqrt(2.0 * per_length * first.radius / (math.pi * parameters.modulus))
    return 0.5 * first.thickness * (load > 0.0), half_width, half_width * parameters.modulus / first.radius


def closed_form_numbers(parameters) -> tuple:
    """Coefficient of spheres or law of discs; reduced mass [kg]; relative speed [m/s], NaN without a collision."""
    speed = np.asarray(parameters.motion.speed, float)
    speed = np.where(speed > 0.0, speed, np.nan)
    if isinstance(parameters, TwoDiscsScene):
        return disc_law(parameters.disc, line_law_name(parameters)), 0.5 * mass_of(parameters.disc), speed
    coefficient, first, second = sphere_pair(parameters)
    return coefficient, first * second / (first + second), speed


def impact_time(parameters) -> float:
    """About the contact time [s] of a checked pair: the closed form without damping."""
    if isinstance(parameters, TwoDiscsScene):
        return disc_impact_time(parameters, line_law_name(parameters))
    return float(hertz_impact.contact_time(*closed_form_numbers(parameters), LAWS[sphere_law(parameters)].power))


def disc_impact_time(parameters: TwoDiscsScene, law: str) -> float:
    """Contact time [s] of the discs by one law of line contact; NaN where it has no solution."""
    line, reduced = disc_law(parameters.disc, law), 0.5 * mass_of(parameters.disc)
    return float(line_contact.contact_time(line, reduced, parameters.motion.speed))


def is_steady(contact: SphereContact) -> bool:
    """True if the viscous term is that of steady damping."""
    return contact.viscosity > 0.0 or (contact.restitution < 1.0 and contact.damping_law == "steady")


def is_elastic(contact: SphereContact) -> bool:
    """True if the contact is elastic."""
    return contact.restitution == 1.0 and contact.damping == 0.0 and contact.viscosity == 0.0


def hunt_crossley_damping(contact: SphereContact, speed: float) -> float:
    """`damping` [s/m] of Hunt and Crossley's term at this impact speed [m/s]; 0 without it."""
    if contact.restitution == 1.0 or is_steady(contact):
        return contact.damping
    return damping_for_restitution(contact.restitution, contact.restitution_speed or speed)


def is_measured(parameters: TwoSpheresScene) -> bool:
    """True if the coefficient of two spheres is given."""
    return sphere_law(parameters) == "measured"


def spheres_closed(parameters: TwoSpheresScene) -> bool:
    """True if closed forms give all that is requested of two spheres."""
    contact = parameters.contact
    return is_elastic(contact) or (parameters.wanted.outputs == "peaks" and not is_steady(contact))


def thickness_over_radius(parameters: TwoDiscsScene) -> float:
    """Of each disc."""
    return parameters.disc.thickness / parameters.disc.radius


def speed_share(parameters: TwoDiscsScene) -> float:
    """Speed of each disc in the frame of both over that of waves in it."""
    material = parameters.disc.material
    return 0.5 * parameters.motion.speed * wave_transit(1.0, material.young_modulus, material.density)


# Bodies that bounce


def bodies_at_start(parameters) -> tuple[Shaped, Shaped]:
    """Both bodies of a scene of bodies that bounce, with their places at the start."""
    if not isinstance(parameters, EllipsoidOnPlaneScene):
        return parameters.bodies
    body, start = parameters.body, parameters.start
    down = rotation_matrix(quaternion_from_vector(start.turn))[2]
    position = 0.0, 0.0, start.height + math.hypot(*(np.array(body.semi_axes) * down))
    motion = {"turn": start.turn, "velocity": start.velocity, "angular_velocity": start.angular_velocity}
    inertial = {"mass": body.mass, "material": body.material}
    first = Shaped(body.shape, semi_axes=body.semi_axes, position=position, **inertial, **motion)
    return first, Shaped("plane", material=parameters.plane.material, motion=HELD)


def shortest_contact(parameters) -> float:
    """Contact time [s] at the greatest speed on the flattest poles, by Hertz or a given stiffness.

    No bounce is much shorter. The speed is about that at which the bodies meet: at the start, by their turning, and by
    the fall.
    """
    (first, second), law = bodies_at_start(parameters), parameters.contact.normal
    relative, size, inverse, flat = math.dist(first.velocity, second.velocity), size_of(parameters), 0.0, 0.0
    for turning, other in ((first, second), (second, first)):
        sizes, reach = sorted(ROWS[turning.shape].sizes(turning)), reach_of(turning)
        if turning.shape not in ("plane", "groove"):
            flat += sizes[0] / math.prod(sizes[1:]) if len(sizes) > 1 else 1.0 / sizes[0]
        if turning.motion == FREE:
            distance = math.dist(first.position, second.position) + reach_of(other)
            relative += math.hypot(*turning.angular_velocity) * min(reach, distance)
            # Of the mass, where an impact beside the centre turns the body.
            inverse += (1.0 + 5.0 * (1.0 - sizes[0] / sizes[-1])) / mass_of(turning)
    gap = max(-opposition_of(*start_points(parameters)).approach, 0.0)
    speed = math.sqrt(relative**2 + 2.0 * math.hypot(*parameters.gravity) * (gap + size))
    row = LAWS["hertz" if law in ("auto", OVERLAP) else law]
    coefficient = row.number(parameters.contact, 4.0 / 3.0 * parameters.modulus / math.sqrt(flat))
    return float(hertz_impact.contact_time(coefficient, 1.0 / inverse, max(speed, 1e-6), row.power))


def longest_creep_step(parameters: EllipsoidOnPlaneScene) -> float:
    """The longest step [s] of rk4 at which the slip of the body under its own weight dies out; inf without friction.

    Slip dies at mu m g / v_s times what a push beside the centre moves, at most (1/m + r^2/I): 3.5 mu g / v_s of a
    ball. In a bounce the load is greater, but slip that goes to and fro there ends with the contact.
    """
    contact, mass = parameters.contact, mass_of(parameters.body)
    weight = -parameters.gravity[2] * mass
    grip = contact.friction_coefficient * weight / contact.friction_regularisation
    if not grip > 0.0:
        return math.inf
    lever = max(parameters.body.semi_axes) ** 2 / min(inertia_of(parameters.body))
    return float(REAL_AXIS / (grip * (1.0 / mass + lever)))


def coefficient_change(parameters: EllipsoidOnPlaneScene) -> float:
    """The greatest change of Hertz's coefficient over the body's surface, relative to that of the start."""
    return law_error(parameters, "constant")


def size_of(parameters) -> float:
    """The least size [m] of the two bodies."""
    return min(min(ROWS[body.shape].sizes(body)) for body in bodies_at_start(parameters))


def rigid_numbers(body: Shaped) -> list[float]:
    """A body as the core reads it: mass [kg], moments of inertia [kg m^2], surface, reach [m], `bend_of`.

    A held body has no mass, and moments of 1: its angular velocity is its angular momentum.
    """
    mass, inertia = (0.0, (1.0, 1.0, 1.0)) if body.motion == HELD else (mass_of(body), inertia_of(body))
    return [mass, *inertia, *surface_of(body).numbers(), reach_of(body), bend_of(body)]


def has_closed_form(parameters) -> bool:
    """True if a closed form gives the opposing points of both shapes."""
    return closed_form_known(*(surface_of(body).kind for body in bodies_at_start(parameters)))


def tracking_of(parameters) -> int:
    """The number of the way to find opposing points: as specified, else in closed form where there is one."""
    specified = getattr(parameters.contact, "tracking", "auto")
    if specified == "auto":
        specified = "closed" if has_closed_form(parameters) else "algebraic"
    return TRACKINGS.index(specified)


def start_points(parameters) -> tuple[MovingBody, MovingBody, np.ndarray]:
    """Both bodies at the start and their opposing points, unknowns (8,) of `shapes`.

    Raises SceneError where there are none.
    """
    a, b = (
        moving_body(
            surface_of(body),
            body.position,
            rotation_matrix(quaternion_from_vector(body.turn)),
            body.velocity,
            body.angular_velocity,
        )
        for body in bodies_at_start(parameters)
    )
    return a, b, nearest_pair(a, b) if has_closed_form(parameters) else searched(a, b, size_of(parameters))


def searched(a: MovingBody, b: MovingBody, size: float) -> np.ndarray:
    """The nearest opposing points among the solutions of Newton's method from points around both bodies.

    Raises SceneError where there is none, or several are equally near.
    """
    middle = 0.5 * (a.position + b.position)
    distance = max(float(np.linalg.norm(a.position - b.position)), size)
    directions = [np.array(direction, float) for direction in itertools.product((-1, 0, 1), repeat=3) if any(direction)]
    centres = a.position, b.position, middle
    starts = [middle, *(centre + size * direction for centre in centres for direction in directions)]
    starts += [b.position + distance * direction / np.linalg.norm(direction) for direction in directions]
    candidates = []
    for start in starts:
        try:
            unknowns = find_opposing(a, b, start)
        except SceneError:
            continue
        opposition = opposition_of(a, b, unknowns)
        if opposition.kind == FOUND or (opposition.kind == NO_ELLIPSE and unknowns[LAMBDA] < 0.0):
            candidates.append((opposition.approach, unknowns))
    if not candidates:
        raise SceneError(
            "no opposing points of the two bodies were found at the start; bring them nearer to each other"
        )
    nearest, best = max(candidates, key=lambda candidate: candidate[0])
    for approach, unknowns in candidates:
        if nearest - approach < EQUAL_DISTANCE * size and np.linalg.norm(unknowns[:3] - best[:3]) > 1e-6 * size:
            raise SceneError(
                "the bodies have several closest points at the start: one contact is all that this kind knows; move "
                "or turn one of them"
            )
    return best


def greatest_exponent(parameters: TwoBodiesScene) -> float | None:
    """Of both bodies; None where neither is a superellipsoid."""
    return max((max(body.exponents) for body in parameters.bodies if body.shape == SUPERELLIPSOID), default=None)


# Curvatures of bodies that bounce


def start_curvatures(parameters) -> tuple[float, float]:
    """Curvatures (small, large) of the gap [1/m] at the start; raises SceneError where the contact is no ellipse."""
    contact = contact_of(*start_points(parameters))
    return contact.curvature_small, contact.curvature_large


def curvatures_over(parameters) -> Iterator[tuple[float, float]]:
    """Curvatures (small, large) of the gap [1/m] where the bodies may touch.

    Of an ellipsoid on a plane on a grid of directions over its surface, of other bodies those of the start.
    """
    if not isinstance(parameters, EllipsoidOnPlaneScene):
        yield start_curvatures(parameters)
        return
    polar, azimuth = np.meshgrid(*(np.linspace(0.0, 0.5 * math.pi, GRID),) * 2, indexing="ij")
    flat = np.sin(polar)
    directions = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.cos(polar)], axis=-1)
    low = ellipsoid_on_plane(parameters.body.semi_axes, directions)
    yield from zip(low.curvature_small.ravel().tolist(), low.curvature_large.ravel().tolist(), strict=True)


def axis_ratio(parameters) -> float:
    """b/a of the narrowest contact ellipse; raises SceneError where a contact has no ellipse."""
    return min(ratio_of(*pair) for pair in curvatures_over(parameters))


def law_error(parameters, law: str) -> float:
    """Greatest relative load error of a law against exact Hertz where bodies may touch; 0 where none is known."""
    if law == OVERLAP:
        # The volumetric law on a circle: further off it is nowhere among ellipses that it is for.
        return abs(coefficient_of("volumetric", 1.0, 1.0, 1.0) / hertz_coefficient(1.0, 1.0, 1.0) - 1.0)
    if LAWS[law].measured or LAWS[law].carries:
        return 0.0
    try:
        frozen = hertz_coefficient(*start_curvatures(parameters), 1.0)
        pairs = [*curvatures_over(parameters)]
    except SceneError:
        return 0.0
    return max(abs(coefficient_of(law, *pair, 1.0, frozen) / hertz_coefficient(*pair, 1.0) - 1.0) for pair in pairs)


# Checks


def check_spheres(parameters: TwoSpheresScene) -> list[str]:
    """Errors of parameters each of which alone is legal."""
    contact, solver = parameters.contact, parameters.solver
    problems = _check_meeting(parameters.motion)
    chosen = contact.normal == "auto" and contact.measured_alpha > 0.0
    problems += numbers_missing(dataclasses.replace(contact, normal="measured") if chosen else contact)
    if not problems:
        problems = _check_step(parameters)
    problems += check_damping(contact, True)
    if is_steady(contact) and solver.stepper not in ("auto", "dop853"):
        problems.append(
            f"solver.stepper = {solver.stepper} does not know steady damping, whose contact "
            "ends before the approach is back at zero; use dop853 or auto"
        )
    return problems + check_run(parameters.run)


def check_discs(parameters: TwoDiscsScene) -> list[str]:
    """Problems of two discs, as by `check_spheres`; also a law of line contact without a solution."""
    problems = _check_meeting(parameters.motion)
    if problems:
        return problems + check_run(parameters.run)
    disc, mass, name = parameters.disc, mass_of(parameters.disc), line_law_name(parameters)
    energy = 0.25 * mass * parameters.motion.speed**2
    limit = greatest_energy(disc_law(disc, name))
    if energy >= limit:
        alternatives = [law for law in law_names("line", ()) if energy < greatest_energy(disc_law(disc, law))]
        way_out = f"use contact.normal: {alternatives[0]}, or " if alternatives else ""
        equation = "eq. (14)" if name == "line" else "Johnson's law"
        return [
            f"contact.normal = {name} has no solution: {equation} cannot store the {energy:.4g} J of this impact, only "
            f"{limit:.4g} J; {way_out}let the discs collide below {2.0 * math.sqrt(limit / mass):.4g} m/s "
            "(motion.first_velocity)"
        ]
    return _check_step(parameters) + check_run(parameters.run)


def _check_meeting(motion: Meeting) -> list[str]:
    if motion.speed > 0.0:
        return []
    return [
        f"motion.first_velocity = {motion.first_velocity:g} m/s does not exceed motion.second_velocity = "
        f"{motion.second_velocity:g} m/s, so the bodies never meet; the first, behind, must be the faster"
    ]


def _check_step(parameters) -> list[str]:
    step, contact_time = parameters.solver.step, impact_time(parameters)
    if parameters.solver.stepper not in FIXED_STEP or not step:
        return []
    if contact_time / step > MOST_STEPS:
        return [
            f"solver.step = {step:g} s is too short: the contact lasts {contact_time:.4g} s and takes at most "
            f"{MOST_STEPS} steps; use {contact_time / MOST_STEPS:.4g} s or more, or solver.stepper: dop853"
        ]
    return _check_length(step, contact_time, "the contact lasts")


def _check_length(step: float, contact_time: float, lasts: str) -> list[str]:
    if contact_time / step >= FEWEST_STEPS:
        return []
    return [
        f"solver.step = {step:g} s is too long: {lasts} {contact_time:.4g} s and needs at least {FEWEST_STEPS} steps; "
        f"use {contact_time / FEW_STEPS:.4g} s or less, or solver.stepper: dop853"
    ]


def check_ellipsoid(parameters: EllipsoidOnPlaneScene) -> list[str]:
    """Problems of an ellipsoid on a plane, as by `check_spheres`."""
    axes, start, gravity, step = (
        parameters.body.semi_axes, parameters.start, parameters.gravity, parameters.solver.step
    )  # fmt: skip
    problems = _check_aspect(BODY, axes)
    if start.height < -MAX_APPROACH * min(axes):
        problems.append(
            f"start.height = {start.height:g} m presses the body in by more than {MAX_APPROACH:g} of its "
            f"shortest semi-axis; give {-MAX_APPROACH * min(axes):.3g} m or more"
        )
    if gravity[0] or gravity[1] or gravity[2] > 0.0:
        problems.append(f"gravity = {list(gravity)} m/s^2 must point along -z, for the plane is horizontal")
    problems += _check_bouncing(parameters)
    if not problems and parameters.solver.stepper == "rk4" and step:
        problems = _check_length(step, shortest_contact(parameters), "a contact can be as short as")
        if not problems and step > longest_creep_step(parameters):
            problems = [
                f"solver.step = {step:g} s is too long for friction: under the body's weight slip would not die out; "
                f"use {0.5 * longest_creep_step(parameters):.3g} s or less, raise contact.friction_regularisation, or "
                "take solver.stepper: dop853"
            ]
    return problems


def check_pair(parameters: TwoBodiesScene) -> list[str]:
    """Problems of two bodies, as by `check_spheres`."""
    (first, second), contact = parameters.bodies, parameters.contact
    problems = [*_check_shape(FIRST, first), *_check_shape(SECOND, second)]
    if first.motion == HELD and second.motion == HELD:
        problems.append("both bodies are held, so nothing moves; give one of them motion: free")
    if not problems:
        if not {surface_of(first).kind, surface_of(second).kind} & set(CONVEX):
            problems.append(
                f"first.shape = {first.shape} and second.shape = {second.shape} are both open or hollow and may touch "
                "at several points; one of them must be a sphere, an ellipsoid or a superellipsoid"
            )
        elif contact.tracking == "closed" and not has_closed_form(parameters):
            problems.append(
                f"contact.tracking = closed: a {first.shape} and a {second.shape} have no closed form; use algebraic "
                "or differential"
            )
    if contact.normal == OVERLAP and contact.stiffness:
        problems.append("contact.stiffness belongs to contact.normal: linear; leave it out")
    return problems + _check_bouncing(parameters) or _check_start(parameters)


def _check_bouncing(parameters) -> list[str]:
    contact, run = parameters.contact, parameters.run
    problems = numbers_missing(contact) + check_damping(contact, False)
    if not (run.duration and run.output_rate):
        problems.append("run.duration and run.output_rate must be above 0; give seconds and Hz")
    return problems + check_run(run)


def _check_aspect(name: str, axes) -> list[str]:
    if max(axes) <= GREATEST_ASPECT * min(axes):
        return []
    return [
        f"{name}.semi_axes = {list(axes)} m: the longest is more than {GREATEST_ASPECT:g} times the shortest, whose "
        "contacts are nearly lines; choose a rounder body"
    ]


def _check_shape(name: str, body: Shaped) -> list[str]:
    """Problems of the shape of one body."""
    problems, row, default = [], ROWS[body.shape], Shaped()
    for key in ("radius", "ring_radius", "semi_axes", "exponents"):
        value, is_required = getattr(body, key), key in row.keys
        if is_required and not min(value if isinstance(value, tuple) else (value,)) > 0.0:
            problems.append(f"{name}.shape = {body.shape} needs {name}.{key} above zero")
        if not is_required and value != getattr(default, key):
            problems.append(f"{name}.{key} is nothing a {body.shape} has; leave it out")
    if problems:
        return problems
    if body.shape == SUPERELLIPSOID and not all(2.0 <= exponent <= 50.0 for exponent in body.exponents):
        problems.append(
            f"{name}.exponents = {list(body.exponents)} must lie between 2 (an ellipsoid) and 50: below 2 a "
            "superellipsoid has edges, and far above it is a box"
        )
    if "semi_axes" in row.keys:
        problems += _check_aspect(name, body.semi_axes)
    if body.shape == "groove" and body.radius >= body.ring_radius:
        problems.append(f"{name}.radius = {body.radius:g} m of the tube must be below {name}.ring_radius")
    if row.solid is None and body.motion != HELD:
        problems.append(f"{name}.shape = {body.shape} has no mass of its own; give {name}.motion: held")
    return problems


def _check_start(parameters: TwoBodiesScene) -> list[str]:
    """Problems of the places of the bodies at the start."""
    try:
        a, b, unknowns = start_points(parameters)
    except SceneError as error:
        return [str(error)]
    opposition, size = opposition_of(a, b, unknowns), size_of(parameters)
    kind, approach = opposition.kind, opposition.approach
    if not np.all(np.isfinite(unknowns)):
        return ["the bodies' centres coincide, so they have no opposing points; move one of them"]
    if kind not in (FOUND, NO_ELLIPSE) or unknowns[LAMBDA] >= 0.0:
        return [f"at the start the nearest pair of points {REFUSALS[kind]}; move one of the bodies"]
    if kind == NO_ELLIPSE and parameters.contact.normal not in ("auto", OVERLAP):
        return [
            f"at the start the contact {REFUSALS[kind].removeprefix('is ')}: contact.normal = "
            f"{parameters.contact.normal} knows none such; use overlap, or turn one of the bodies"
        ]
    if approach > MAX_APPROACH * size:
        return [
            f"at the start the bodies press {approach:.3g} m into each other, more than {MAX_APPROACH:g} of the least "
            f"size {size:g} m; move one of them"
        ]
    if kind == FOUND and approach > opposition.curvature_small * size**2:
        return [
            f"at the start the bodies press {approach:.3g} m into each other, so that they would touch over more than "
            f"the least size {size:g} m, which no law here knows; move one of them, or let them fit less closely"
        ]
    return []


# Automatic values


def resolve(parameters):
    """The parameters of a checked pair on a line with the zeros of its run replaced."""
    contact = 1.25 * _stretch(parameters) * impact_time(parameters)
    duration = parameters.motion.gap / parameters.motion.speed + contact
    return dataclasses.replace(parameters, run=resolved_run(parameters.run, duration, OUTPUTS))


def _stretch(parameters) -> float:
    """Upper bound of the contact time of a checked pair over that without loss.

    By Hunt and Crossley 1/sqrt(e), e the restitution at the impact speed, is enough: it is 7.2 at e = 0.01. Steady
    damping makes it shorter, for the contact ends where it would pull.
    """
    if isinstance(parameters, TwoDiscsScene) or is_steady(parameters.contact):
        return 1.0
    speed = parameters.motion.speed
    restitution = restitution_of(hunt_crossley_damping(parameters.contact, speed) * speed)
    return max(restitution, LEAST_RESTITUTION) ** -0.5


def resolve_bouncing(parameters):
    """The parameters of a checked scene of bodies that bounce with the zeros of its run replaced."""
    return dataclasses.replace(parameters, run=resolved_run(parameters.run))


# Choice of the law, the stepper and the contact points, by the rules


def choose_spheres(parameters) -> Choice:
    """Two spheres: closed forms wherever they give all that is requested."""
    choices = answers(SPHERES, parameters)
    law, stepper = choices["contact.normal"].value, choices["solver.stepper"].value
    exact = sphere_coefficient("hertz", 1.0, 1.0)
    error = 0.0 if LAWS[law].measured else abs(float(sphere_coefficient(law, 1.0, 1.0) / exact) - 1.0)
    warnings = _odd_masses(parameters) + _step_warnings(parameters.solver, stepper, FIXED_STEP, impact_time(parameters))
    return Choice(law, stepper, error, sentences(choices), tuple(warnings))


def choose_discs(parameters) -> Choice:
    """Two discs: Johnson's law unless another is specified, by quadrature when only peaks are requested."""
    choices = answers(DISCS, parameters)
    law, stepper = choices["contact.normal"].value, choices["solver.stepper"].value
    error, warnings = line_contact_error(parameters)
    difference = disc_impact_time(parameters, law) / disc_impact_time(parameters, "johnson") - 1.0
    if abs(difference) > JOHNSON_ERROR:
        warnings.append(
            f"the law {law} gives a contact time {100.0 * difference:.2g} % from Johnson's, "
            "which thick discs follow; contact.normal: johnson costs no more"
        )
    warnings += _step_warnings(parameters.solver, stepper, FIXED_STEP, impact_time(parameters))
    return Choice(law, stepper, error + abs(difference), sentences(choices), tuple(warnings))


def line_contact_error(parameters) -> tuple[float, list[str]]:
    """Approximate error of line contact against finite elasticity, and a warning with the better model if it is large.

    It grows with the speed as a share of that of waves, as the strain does; thin discs are not in plane strain, which
    makes the contact longer by 1 / sqrt(1 - nu^2). Both errors have opposite signs where they are small.
    """
    disc, speed_ratio = parameters.disc, speed_share(parameters)
    error, reasons, keys = max(JOHNSON_ERROR, SPEED_ERROR * speed_ratio), [], "against: disc"
    if error > JOHNSON_ERROR:
        reasons.append(f"the speed of each disc is {speed_ratio:.2g} of that of waves in it")
    if disc.thickness < disc.radius:
        error = max(error, (1.0 - disc.material.poisson_ratio**2) ** -0.5 - 1.0)
        reasons.append("discs thinner than their radius are not in plane strain")
        keys += " and plane: stress"
    if error <= max(2.0 * JOHNSON_ERROR, parameters.wanted.tolerance):
        return error, []
    return error, [
        f"line contact differs from finite elasticity by about {100.0 * error:.2g} % here: {', '.join(reasons)}; kind: "
        f"soft_discs with {keys} computes it"
    ]


def choose_bouncing(parameters) -> Choice:
    """Law, method and contact points of bodies that bounce; on a plane a law is judged over the whole surface."""
    on_plane = isinstance(parameters, EllipsoidOnPlaneScene)
    choices, tolerance = answers(ELLIPSOID if on_plane else BODIES, parameters), parameters.wanted.tolerance
    warnings = []
    law, stepper = choices["contact.normal"].value, choices["solver.stepper"].value
    error = law_error(parameters, law)
    if law != OVERLAP and error > max(tolerance, RATIONAL):
        warnings.append(
            f"the law {law} differs by {100.0 * error:.2g} % from exact Hertz here, more than wanted.tolerance = "
            f"{tolerance:g}; contact.normal: hertz costs no more"
        )
    warnings += [*_odd_masses(parameters), *drift(law), *roughness(FRICTIONS[parameters.contact.friction])]
    if on_plane:
        warnings += _step_warnings(parameters.solver, stepper, ("rk4",), shortest_contact(parameters))
    return Choice(law, stepper, error, sentences(choices), tuple(warnings))


def _odd_masses(parameters) -> list[str]:
    pairs = zip(parameters.names, parameters.bodies, strict=True)
    warnings = []
    for name, body in pairs:
        if body.mass and body.motion == FREE:
            warnings += odd_mass(f"{name}.mass", body.mass, homogeneous_mass(body))
    return warnings


def _step_warnings(solver, stepper: str, fixed: tuple[str, ...], contact_time: float) -> list[str]:
    """Of a step that is long for a contact, or that does nothing as only the steppers `fixed` take it."""
    if stepper not in fixed or solver.step <= contact_time / FEW_STEPS:
        return idle_step(solver.step, stepper, fixed)
    return [
        f"solver.step = {solver.step:g} s is less than {FEW_STEPS} steps a contact: restitution may be wrong by 2 %; "
        f"use {contact_time / FEW_STEPS:.3g} s or less"
    ]
