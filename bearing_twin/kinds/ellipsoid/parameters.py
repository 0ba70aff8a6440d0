"""An ellipsoid on a plane: YAML keys, units, defaults and limits; what is impossible together."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from bearing_twin.contact import hertz_impact as impact
from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.materials import MATERIALS, Material, effective_modulus
from bearing_twin.contact.normal import LAWS, load_coefficient
from bearing_twin.kinds.impact.collision import FEW_STEPS, FEWEST_STEPS
from bearing_twin.kinds.impact.impact_parameters import check_run
from bearing_twin.numerics.rotation import quaternion_from_vector, rotation_matrix
from bearing_twin.parameters import choice, quantity, section
from bearing_twin.shapes.surfaces import ellipsoid_on_plane

DIFFERENTIAL, UNPROJECTED = len(LAWS), len(LAWS) + 1
ELLIPSOID_LAWS = LAWS | {"hertz_differential": DIFFERENTIAL, "hertz_unprojected": UNPROJECTED}
"""The laws of one contact, and the two that carry the elliptic integrals as states (paper 1, section 3)."""

ELLIPSOID_STEPPERS = ("dop853", "rk4")
GRID = 13  # directions over a quarter turn, where a law is weighed over the surface
GREATEST_ASPECT = 30.0  # longest over shortest semi-axis: beyond it b/a falls below where the laws are known
DEEPEST = 0.1  # of the shortest semi-axis: a start pressed in deeper is no small deformation
SECOND_OUTPUTS = 2000.0  # Hz, where output_rate is left to be chosen


@dataclass(frozen=True)
class EllipsoidBody:
    """A homogeneous ellipsoid."""

    semi_axes: tuple[float, float, float] = quantity((0.1, 0.1, 0.1), "m", "along its own x, y and z", above=0.0)
    mass: float = quantity(0.0, "kg", "mass; 0 = from semi-axes and density", at_least=0.0)
    material: Material = section(Material, "steel", MATERIALS)


@dataclass(frozen=True)
class PlaneBody:
    """The half-space z < 0, at rest."""

    material: Material = section(Material, "steel", MATERIALS)


@dataclass(frozen=True)
class Start:
    """How the ellipsoid starts, in fixed axes with z up."""

    height: float = quantity(1.0, "m", "of the lowest point above the plane; negative = pressed in")
    turn: tuple[float, float, float] = quantity(
        (0.0, 0.0, 0.0), "rad", "from its own axes on the fixed ones: angle times axis of one rotation"
    )
    velocity: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "m/s", "of the centre")
    angular_velocity: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "rad/s", "in fixed axes")


@dataclass(frozen=True)
class EllipsoidContact:
    """The laws of the contact; at most one of damping, relaxation_time, viscosity and a restitution below 1."""

    normal: str = choice("auto", ("auto", *ELLIPSOID_LAWS), "elastic law; auto = the cheapest adequate one")
    restitution: float = quantity(1.0, "1", "coefficient of restitution where it touches", above=0.0, at_most=1.0)
    restitution_speed: float = quantity(
        0.0, "m/s", "speed at which the restitution holds (Hunt and Crossley); 0 = at every speed", at_least=0.0
    )
    damping: float = quantity(0.0, "s/m", "viscous term damping * elastic load * approach rate", at_least=0.0)
    relaxation_time: float = quantity(
        0.0, "s", "viscous term relaxation_time * stiffness * approach rate", at_least=0.0
    )
    viscosity: float = quantity(
        0.0, "N s/m^1.25", "viscous term viscosity * approach^(1/4) * approach rate", at_least=0.0
    )
    yield_pressure: float = quantity(
        1.6 * 2.0e9, "Pa", "peak pressure of first yield, about 1.6 times the strength", above=0.0
    )


@dataclass(frozen=True)
class EllipsoidFriction:
    """Friction in the contact."""

    coefficient: float = quantity(0.0, "1", "Coulomb friction coefficient", at_least=0.0, at_most=10.0)
    regularisation: float = quantity(1e-3, "m/s", "slip speed at which friction reaches 71 % of its limit", above=0.0)
    form: str = choice("point", ("point", "spot"), "point = slip alone; spot = sliding and spin over the ellipse")


@dataclass(frozen=True)
class EllipsoidSolver:
    """How the motion is computed."""

    stepper: str = choice("auto", ("auto", *ELLIPSOID_STEPPERS), "method; auto = dop853")
    tolerance: float = quantity(1e-9, "1", "wanted relative error of a contact", at_least=1e-12, at_most=1e-2)
    step: float = quantity(0.0, "s", "step of rk4 in contact; 0 = a 64th of the shortest contact", at_least=0.0)


@dataclass(frozen=True)
class EllipsoidRun:
    """What is given out."""

    duration: float = quantity(2.0, "s", "simulated time", above=0.0, at_most=1e5)
    output_rate: float = quantity(SECOND_OUTPUTS, "Hz", "solver outputs", above=0.0, at_most=1e9)
    publish_rate: float = quantity(0.0, "Hz", "published outputs; 0 = all", at_least=0.0, at_most=1e9)


@dataclass(frozen=True)
class EllipsoidOnPlaneScene:
    """A homogeneous ellipsoid over an elastic half-space, under gravity (paper 1, section 5, first example)."""

    body: EllipsoidBody = section(EllipsoidBody)
    plane: PlaneBody = section(PlaneBody)
    start: Start = section(Start)
    gravity: float = quantity(9.80665, "m/s^2", "acceleration downward", at_least=0.0)
    contact: EllipsoidContact = section(EllipsoidContact)
    friction: EllipsoidFriction = section(EllipsoidFriction)
    solver: EllipsoidSolver = section(EllipsoidSolver)
    run: EllipsoidRun = section(EllipsoidRun)


def ellipsoid_mass(body: EllipsoidBody) -> float:
    """Mass [kg]: given, or that of the homogeneous ellipsoid."""
    return body.mass or body.material.density * 4.0 / 3.0 * math.pi * math.prod(body.semi_axes)


def principal_inertia(body: EllipsoidBody) -> tuple[float, float, float]:
    """Moments of inertia [kg m^2] about its own axes through the centre: m (b^2 + c^2)/5 and so on."""
    x, y, z = (axis * axis for axis in body.semi_axes)
    fifth = 0.2 * ellipsoid_mass(body)
    return fifth * (y + z), fifth * (z + x), fifth * (x + y)


def modulus_of(parameters: EllipsoidOnPlaneScene) -> float:
    """Effective modulus [Pa] of the pair."""
    return effective_modulus(parameters.body.material, parameters.plane.material)


def start_orientation(start: Start) -> tuple[float, float, float, float]:
    """The unit quaternion (x, y, z, w) of the start."""
    return quaternion_from_vector(start.turn)


def start_gap(parameters: EllipsoidOnPlaneScene):
    """The lowest point at the start, a `surfaces.LowestPoint`."""
    down = -rotation_matrix(start_orientation(parameters.start))[2]
    return ellipsoid_on_plane(parameters.body.semi_axes, tuple(float(x) for x in down))


def law_error_over(parameters: EllipsoidOnPlaneScene, law: str) -> float:
    """Greatest relative load error of a law against exact Hertz over the body's surface, on a grid of directions."""
    if ELLIPSOID_LAWS[law] >= DIFFERENTIAL:
        return 0.0
    axes, start, worst = tuple(parameters.body.semi_axes), start_gap(parameters), 0.0
    frozen = hertz_coefficient(start.curvature_small, start.curvature_large, 1.0)
    for polar in np.linspace(0.0, 0.5 * math.pi, GRID):
        for round_about in np.linspace(0.0, 0.5 * math.pi, GRID):
            flat = math.sin(polar)
            direction = (flat * math.cos(round_about), flat * math.sin(round_about), math.cos(polar))
            low = ellipsoid_on_plane(axes, direction)
            curvatures = low.curvature_small, low.curvature_large, 1.0
            exact = hertz_coefficient(*curvatures)
            worst = max(worst, abs(load_coefficient(ELLIPSOID_LAWS[law], *curvatures, frozen) / exact - 1.0))
    return worst


def greatest_speed(parameters: EllipsoidOnPlaneScene) -> float:
    """No point of the body strikes faster [m/s]: fall, velocity and spin together, from the energy at the start."""
    start, body = parameters.start, parameters.body
    spin = math.hypot(*start.angular_velocity)
    fall = max(start.height, 0.0) + max(body.semi_axes) - min(body.semi_axes)
    return math.sqrt(start.velocity[2] ** 2 + 2.0 * parameters.gravity * fall) + spin * max(body.semi_axes)


def shortest_contact(parameters: EllipsoidOnPlaneScene) -> float:
    """Hertz contact time [s] at the greatest speed on the flattest pole: no bounce is much shorter."""
    axes = sorted(parameters.body.semi_axes)
    small, large = 0.5 * axes[0] / axes[2] ** 2, 0.5 * axes[0] / axes[1] ** 2
    coefficient = hertz_coefficient(small, large, modulus_of(parameters))
    speed = max(greatest_speed(parameters), 1e-6)
    light = 1.0 / (1.0 + 5.0 * (1.0 - axes[0] / axes[2]))  # of the mass, where a blow beside the centre turns the body
    return float(impact.contact_time(coefficient, light * ellipsoid_mass(parameters.body), speed))


def check_ellipsoid(parameters: EllipsoidOnPlaneScene) -> list[str]:
    """What is impossible although each number alone is legal."""
    problems, axes, contact = [], parameters.body.semi_axes, parameters.contact
    if max(axes) > GREATEST_ASPECT * min(axes):
        problems.append(
            f"body.semi_axes = {list(axes)} m: the longest is more than {GREATEST_ASPECT:g} times the shortest, whose "
            "contacts are nearly lines; choose a rounder body"
        )
    if parameters.start.height < -DEEPEST * min(axes):
        problems.append(
            f"start.height = {parameters.start.height:g} m presses the body in by more than {DEEPEST:g} of its "
            f"shortest semi-axis; give {-DEEPEST * min(axes):.3g} m or more"
        )
    given = [name for name in ("damping", "relaxation_time", "viscosity") if getattr(contact, name) > 0.0]
    given += ["restitution"] if contact.restitution < 1.0 else []
    if len(given) > 1:
        problems.append(f"contact.{' and contact.'.join(given)} all set the viscous term; keep one of them")
    if contact.restitution_speed > 0.0 and contact.restitution == 1.0:
        problems.append("contact.restitution_speed needs a contact.restitution below 1; give one, or leave it out")
    step = parameters.solver.step
    if not problems and parameters.solver.stepper == "rk4" and step > shortest_contact(parameters) / FEWEST_STEPS:
        problems.append(
            f"solver.step = {step:g} s is too long: a contact can be as short as {shortest_contact(parameters):.3g} s "
            f"and needs at least {FEWEST_STEPS} steps; use {shortest_contact(parameters) / FEW_STEPS:.3g} s or less, "
            "or solver.stepper: dop853"
        )
    return problems + check_run(parameters.run)


def resolve(parameters: EllipsoidOnPlaneScene) -> EllipsoidOnPlaneScene:
    """The parameters of a checked scene with the zeros of its run replaced."""
    run = parameters.run
    return dataclasses.replace(
        parameters, run=dataclasses.replace(run, publish_rate=run.publish_rate or run.output_rate)
    )
