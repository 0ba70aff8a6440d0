"""Numbers derived from the parameters of two bodies, checks of the parameters, and values of automatic ones."""

import dataclasses
import math

import numpy as np

from bearing_twin.contact import hertz_impact as impact
from bearing_twin.contact.damping import damping_for_restitution, restitution_of
from bearing_twin.contact.elasticity import sphere_coefficient
from bearing_twin.contact.laws import LAWS, law_names, numbers_missing
from bearing_twin.contact.line import greatest_energy, line_law
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.contact.validity import wave_transit
from bearing_twin.kinds.impact import disc_closed_form
from bearing_twin.kinds.impact.collision import FEW_STEPS, FEWEST_STEPS, MOST_STEPS
from bearing_twin.kinds.impact.parameters import (
    FIXED_STEP,
    Disc,
    Meeting,
    PairSolver,
    Sphere,
    SphereContact,
    TwoDiscsScene,
    TwoSpheresScene,
)
from bearing_twin.kinds.sections import check_damping, check_run, resolved_run

LEAST = 1e-300  # a restitution that only rounding makes 0
OUTPUTS = 400  # of a run whose output_rate is automatic


def sphere_mass(sphere: Sphere) -> float:
    """Mass [kg]: given, or that of the homogeneous sphere; numbers or arrays that broadcast."""
    return np.where(np.greater(sphere.mass, 0.0), sphere.mass, homogeneous_mass(sphere))[()]


def homogeneous_mass(sphere: Sphere) -> float:
    """Mass [kg] by size and density, whatever mass is given."""
    return sphere.material.density * 4.0 / 3.0 * math.pi * sphere.radius**3


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
    masses = sphere_mass(first), sphere_mass(second)
    law = sphere_law(parameters)
    radius = first.radius * second.radius / (first.radius + second.radius)
    bodies, given = (effective_modulus(first.material, second.material), radius), contact.stiffness
    if law == "measured":
        known = np.greater(contact.measured_alpha, 0.0)  # of many realisations some may not have one
        alpha = np.where(known, contact.measured_alpha, 1.0)
        measured = impact.coefficient_of_alpha(alpha, masses[0] * masses[1] / sum(masses))
        given = np.where(known, measured, sphere_coefficient("hertz", *bodies))[()]
    return sphere_coefficient(law, *bodies, given), *masses


def disc_mass(disc: Disc) -> float:
    """Mass of one disc [kg]."""
    return disc.material.density * math.pi * disc.radius**2 * disc.thickness


def disc_law(disc: Disc, name: str):
    """The line law of that name for these discs."""
    material = disc.material
    return line_law(name, disc.radius, disc.thickness, material.young_modulus, material.poisson_ratio)


def strip_of(disc: Disc, load: float) -> tuple[float, float]:
    """Half-width [m] of the strip on which two of these discs touch under a load [N], and its peak pressure [Pa]."""
    per_length = load / disc.thickness
    modulus = effective_modulus(disc.material, disc.material)
    half_width = math.sqrt(2.0 * per_length * disc.radius / (math.pi * modulus))
    return half_width, 2.0 * per_length / (math.pi * half_width)


def meeting_speed(parameters):
    """Relative speed [m/s], NaN where the bodies never collide; numbers or arrays."""
    speed = np.asarray(parameters.motion.speed, float)
    return np.where(speed > 0.0, speed, np.nan)


def pair_contact_time(parameters) -> float:
    """About the contact time [s] of a checked pair: the closed form without damping."""
    speed = parameters.motion.speed
    if isinstance(parameters, TwoSpheresScene):
        coefficient, first, second = sphere_pair(parameters)
        power = LAWS[sphere_law(parameters)].power
        return float(impact.contact_time(coefficient, first * second / (first + second), speed, power))
    return contact_time_by(parameters, "johnson" if parameters.contact.normal == "auto" else parameters.contact.normal)


def contact_time_by(parameters: TwoDiscsScene, law: str) -> float:
    """Contact time [s] of the discs by one law of line contact; NaN where it has no solution."""
    reduced = 0.5 * disc_mass(parameters.disc)
    return float(disc_closed_form.contact_time(disc_law(parameters.disc, law), reduced, parameters.motion.speed))


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


def _stretch(parameters) -> float:
    """Upper bound of the contact time of a checked pair over that without loss.

    By Hunt and Crossley 1/sqrt(e), e the restitution at the impact speed, is enough: it is 7.2 at e = 0.01. Steady
    damping makes it shorter, for the contact ends where it would pull.
    """
    if isinstance(parameters, TwoDiscsScene) or is_steady(parameters.contact):
        return 1.0
    speed = parameters.motion.speed
    kept = restitution_of(hunt_crossley_damping(parameters.contact, speed) * speed)
    return max(kept, LEAST) ** -0.5


def check_spheres(parameters: TwoSpheresScene) -> list[str]:
    """Errors of parameters each of which alone is legal."""
    problems = _check_meeting(parameters.motion) + _check_numbers(parameters.contact)
    if not problems:
        problems = _check_step(parameters.solver, pair_contact_time(parameters))
    problems += check_damping(parameters.contact, True)
    if is_steady(parameters.contact) and parameters.solver.stepper not in ("auto", "dop853"):
        problems.append(
            f"solver.stepper = {parameters.solver.stepper} does not know steady damping, whose contact "
            "ends before the approach is back at zero; use dop853 or auto"
        )
    return problems + check_run(parameters.run)


def check_discs(parameters: TwoDiscsScene) -> list[str]:
    """As `check_spheres`; also a law of line contact without a solution, with the model that has one."""
    problems = _check_meeting(parameters.motion)
    if problems:
        return problems + check_run(parameters.run)
    disc, speed = parameters.disc, parameters.motion.speed
    energy = 0.25 * disc_mass(disc) * speed**2
    name = "johnson" if parameters.contact.normal == "auto" else parameters.contact.normal
    most = greatest_energy(disc_law(disc, name))
    if energy >= most:
        others = [one for one in law_names("line", ()) if energy < greatest_energy(disc_law(disc, one))]
        way_out = f"use contact.normal: {others[0]}, or " if others else ""
        equation = "eq. (14)" if name == "line" else "Johnson's law"
        return [
            f"contact.normal = {name} has no solution: {equation} cannot store the {energy:.4g} J of this impact, only "
            f"{most:.4g} J; {way_out}let the discs collide below {2.0 * math.sqrt(most / disc_mass(disc)):.4g} m/s "
            "(motion.first_velocity)"
        ]
    return _check_step(parameters.solver, pair_contact_time(parameters)) + check_run(parameters.run)


def resolve(parameters):
    """The parameters of a checked pair with the zeros of its run replaced."""
    contact = 1.25 * _stretch(parameters) * pair_contact_time(parameters)
    whole = parameters.motion.gap / parameters.motion.speed + contact
    return dataclasses.replace(parameters, run=resolved_run(parameters.run, whole, OUTPUTS))


def _check_numbers(contact: SphereContact) -> list[str]:
    """As `numbers_missing`; an automatic law is `measured` where alpha is given."""
    chosen = contact.normal == "auto" and contact.measured_alpha > 0.0
    return numbers_missing(dataclasses.replace(contact, normal="measured") if chosen else contact)


def _check_meeting(motion: Meeting) -> list[str]:
    if motion.speed > 0.0:
        return []
    return [
        f"motion.first_velocity = {motion.first_velocity:g} m/s does not exceed motion.second_velocity = "
        f"{motion.second_velocity:g} m/s, so the bodies never meet; the first, behind, must be the faster"
    ]


def _check_step(solver: PairSolver, contact_time: float) -> list[str]:
    if solver.stepper not in FIXED_STEP or not solver.step:
        return []
    steps, other = contact_time / solver.step, "or solver.stepper: dop853"
    if steps < FEWEST_STEPS:
        return [
            f"solver.step = {solver.step:g} s is too long: the contact lasts {contact_time:.4g} s and needs at least "
            f"{FEWEST_STEPS} steps; use {contact_time / FEW_STEPS:.4g} s or less, {other}"
        ]
    if steps > MOST_STEPS:
        return [
            f"solver.step = {solver.step:g} s is too short: the contact lasts {contact_time:.4g} s and takes at most "
            f"{MOST_STEPS} steps; use {contact_time / MOST_STEPS:.4g} s or more, {other}"
        ]
    return []


def is_measured(parameters) -> bool:
    """True if the coefficient of two spheres is given."""
    return sphere_law(parameters) == "measured"


def spheres_closed(parameters) -> bool:
    """True if closed forms give all that is requested of two spheres."""
    contact = parameters.contact
    return is_elastic(contact) or (parameters.wanted.outputs == "peaks" and not is_steady(contact))


def thickness_over_radius(parameters) -> float:
    """Of each disc."""
    return parameters.disc.thickness / parameters.disc.radius


def speed_share(parameters) -> float:
    """Speed of each disc in the frame of both over that of waves in it."""
    material = parameters.disc.material
    return 0.5 * parameters.motion.speed * wave_transit(1.0, material.young_modulus, material.density)
