"""Numbers derived from the parameters of an ellipsoid on a plane, checks of the parameters, automatic values."""

import dataclasses
import math
from collections.abc import Iterator

import numpy as np

from bearing_twin.contact import hertz_impact as impact
from bearing_twin.contact.elasticity import coefficient_of
from bearing_twin.contact.ellipse import axis_ratio as ratio_of
from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.laws import LAWS, numbers_missing
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.kinds.ellipsoid.parameters import EllipsoidBody, EllipsoidOnPlaneScene, Start
from bearing_twin.kinds.impact.collision import FEW_STEPS, FEWEST_STEPS
from bearing_twin.kinds.sections import check_damping, check_run, resolved_run
from bearing_twin.numerics.rotation import quaternion_from_vector, rotation_matrix
from bearing_twin.shapes.closed_forms import ellipsoid_on_plane

GRID = 13  # directions over a quarter turn, where a law is weighed over the surface
REAL_AXIS = 2.785  # rk4 damps what dies out at rates up to this over its step
GREATEST_ASPECT = 30.0  # longest over shortest semi-axis: beyond it b/a falls below where the laws are known
DEEPEST = 0.1  # of the shortest semi-axis: a start pressed in deeper is no small deformation


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
    """The lowest point at the start, a `LowestPoint`."""
    return ellipsoid_on_plane(parameters.body.semi_axes, -rotation_matrix(start_orientation(parameters.start))[2])


def law_error_over(parameters: EllipsoidOnPlaneScene, law: str) -> float:
    """Greatest relative load error of a law against exact Hertz over the body's surface, on a grid of directions."""
    if LAWS[law].measured or LAWS[law].carries:
        return 0.0
    start, worst = start_gap(parameters), 0.0
    frozen = hertz_coefficient(start.curvature_small, start.curvature_large, 1.0)
    for pair in curvatures_over(parameters):
        exact = hertz_coefficient(*pair, 1.0)
        worst = max(worst, abs(coefficient_of(law, *pair, 1.0, frozen) / exact - 1.0))
    return worst


def curvatures_over(parameters: EllipsoidOnPlaneScene) -> Iterator[tuple[float, float]]:
    """Curvatures (small, large) of the gap [1/m] where the body may touch, on a grid of directions over its surface."""
    polar, around = np.meshgrid(*(np.linspace(0.0, 0.5 * math.pi, GRID),) * 2, indexing="ij")
    flat = np.sin(polar)
    directions = np.stack([flat * np.cos(around), flat * np.sin(around), np.cos(polar)], axis=-1)
    low = ellipsoid_on_plane(parameters.body.semi_axes, directions)
    yield from zip(low.curvature_small.ravel().tolist(), low.curvature_large.ravel().tolist(), strict=True)


def greatest_speed(parameters: EllipsoidOnPlaneScene) -> float:
    """No point of the body strikes faster [m/s]: fall, velocity and spin together, from the energy at the start."""
    start, body = parameters.start, parameters.body
    spin = math.hypot(*start.angular_velocity)
    fall = max(start.height, 0.0) + max(body.semi_axes) - min(body.semi_axes)
    return math.sqrt(start.velocity[2] ** 2 + 2.0 * -parameters.gravity[2] * fall) + spin * max(body.semi_axes)


def shortest_contact(parameters: EllipsoidOnPlaneScene) -> float:
    """Contact time [s] at the greatest speed on the flattest pole, by Hertz or a given stiffness.

    No bounce is much shorter.
    """
    axes, contact = sorted(parameters.body.semi_axes), parameters.contact
    small, large = 0.5 * axes[0] / axes[2] ** 2, 0.5 * axes[0] / axes[1] ** 2
    law = LAWS["hertz" if contact.normal == "auto" else contact.normal]
    coefficient = law.number(contact, hertz_coefficient(small, large, modulus_of(parameters)))
    speed = max(greatest_speed(parameters), 1e-6)
    light = 1.0 / (
        1.0 + 5.0 * (1.0 - axes[0] / axes[2])
    )  # of the mass, where an impact beside the centre turns the body
    return float(impact.contact_time(coefficient, light * ellipsoid_mass(parameters.body), speed, law.power))


def longest_creep_step(parameters: EllipsoidOnPlaneScene) -> float:
    """The longest step [s] of rk4 at which the slip of the body under its own weight dies out; inf without friction.

    Slip dies at mu m g / v_s times what a push beside the centre moves, at most (1/m + r^2/I): 3.5 mu g / v_s of a
    ball. In a bounce the load is greater, but slip that goes to and fro there ends with the contact.
    """
    contact, weight = parameters.contact, -parameters.gravity[2] * ellipsoid_mass(parameters.body)
    grip = contact.friction_coefficient * weight / contact.friction_regularisation
    if not grip > 0.0:
        return math.inf
    lever = max(parameters.body.semi_axes) ** 2 / min(principal_inertia(parameters.body))
    return float(REAL_AXIS / (grip * (1.0 / ellipsoid_mass(parameters.body) + lever)))


def check_ellipsoid(parameters: EllipsoidOnPlaneScene) -> list[str]:
    """Errors of parameters each of which alone is legal."""
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
    if parameters.gravity[0] or parameters.gravity[1] or parameters.gravity[2] > 0.0:
        problems.append(f"gravity = {list(parameters.gravity)} m/s^2 must point along -z, for the plane is horizontal")
    problems += numbers_missing(contact)
    problems += check_damping(contact, False)
    if not (parameters.run.duration and parameters.run.output_rate):
        problems.append("run.duration and run.output_rate must be above 0; give seconds and Hz")
    step = parameters.solver.step
    if not problems and parameters.solver.stepper == "rk4" and step > shortest_contact(parameters) / FEWEST_STEPS:
        problems.append(
            f"solver.step = {step:g} s is too long: a contact can be as short as {shortest_contact(parameters):.3g} s "
            f"and needs at least {FEWEST_STEPS} steps; use {shortest_contact(parameters) / FEW_STEPS:.3g} s or less, "
            "or solver.stepper: dop853"
        )
    if not problems and parameters.solver.stepper == "rk4" and step > longest_creep_step(parameters):
        problems.append(
            f"solver.step = {step:g} s is too long for friction: under the body's weight slip would not die out; use "
            f"{0.5 * longest_creep_step(parameters):.3g} s or less, raise contact.friction_regularisation, or take "
            "solver.stepper: dop853"
        )
    return problems + check_run(parameters.run)


def resolve(parameters: EllipsoidOnPlaneScene) -> EllipsoidOnPlaneScene:
    """The parameters of a checked scene with the zeros of its run replaced."""
    return dataclasses.replace(parameters, run=resolved_run(parameters.run))


def axis_ratio(parameters) -> float:
    """b/a of the narrowest ellipse over the body's surface."""
    return min(ratio_of(*pair) for pair in curvatures_over(parameters))


def coefficient_change(parameters) -> float:
    """The greatest change of Hertz's coefficient over the body's surface, relative to that of the start."""
    return law_error_over(parameters, "constant")
