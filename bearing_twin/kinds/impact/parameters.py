"""Two spheres and two discs: YAML keys, units, defaults and limits; what is impossible together."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from bearing_twin.contact import hertz_impact as impact
from bearing_twin.contact.line import LINE_LAWS, greatest_energy, line_law
from bearing_twin.contact.materials import Material, effective_modulus
from bearing_twin.kinds.impact import disc_closed_form as disc_closed_form
from bearing_twin.kinds.impact.collision import FEW_STEPS, FEWEST_STEPS, FIXED_STEP
from bearing_twin.kinds.impact.impact_parameters import Run, Sphere, check_run, resolved_run, sphere_mass
from bearing_twin.parameters import choice, quantity, section

DAMPING_LAWS = ("hunt_crossley", "steady")
PAIR_STEPPERS = ("closed_form", "dop853", *FIXED_STEP)
OUTPUTS = 400  # of a run whose output_rate is left to be chosen


@dataclass(frozen=True)
class Meeting:
    """How two bodies come together on their common line, the first behind the second; positive = forward."""

    first_velocity: float = quantity(20.0, "m/s", "velocity of the first body")
    second_velocity: float = quantity(0.0, "m/s", "velocity of the second body")
    gap: float = quantity(0.0, "m", "distance of the surfaces at the start", at_least=0.0)

    @property
    def speed(self) -> float:
        """Relative speed [m/s] at which the bodies close in."""
        return self.first_velocity - self.second_velocity


@dataclass(frozen=True)
class SphereContact:
    """The law of the contact of two spheres."""

    measured_alpha: float = quantity(
        0.0, "s (m/s)^0.2", "contact time * speed^0.2, measured; 0 = Hertz from the materials", at_least=0.0
    )
    restitution: float = quantity(1.0, "1", "coefficient of restitution at this speed", above=0.0, at_most=1.0)
    damping_law: str = choice(
        "hunt_crossley", DAMPING_LAWS, "of a restitution below 1; hunt_crossley loses more when faster, steady does not"
    )
    yield_pressure: float = quantity(
        1.6e9, "Pa", "peak pressure of first yield, about 1.6 times the strength", above=0.0
    )


@dataclass(frozen=True)
class PairSolver:
    """How the contact of two bodies is computed."""

    stepper: str = choice("auto", ("auto", *PAIR_STEPPERS), "method; auto = the cheapest adequate one")
    tolerance: float = quantity(1e-9, "1", "wanted relative error of force and time", at_least=1e-13, at_most=0.1)
    step: float = quantity(0.0, "s", "step of rk4 and symplectic_euler; 0 = a 500th of the contact", at_least=0.0)


@dataclass(frozen=True)
class TwoSpheresScene:
    """Central impact of two elastic spheres (paper 3, sections 2 and 3), without gravity."""

    first: Sphere = section(Sphere)
    second: Sphere = section(Sphere)
    contact: SphereContact = section(SphereContact)
    motion: Meeting = section(Meeting)
    solver: PairSolver = section(PairSolver)
    run: Run = section(Run)


@dataclass(frozen=True)
class Disc:
    """Both of two equal discs."""

    radius: float = quantity(1.0, "m", "radius", above=0.0)
    thickness: float = quantity(2.0, "m", "length of the line of contact, 2a of paper 3", above=0.0)
    material: Material = section(Material)


@dataclass(frozen=True)
class DiscContact:
    """The law of the line contact."""

    normal: str = choice("auto", ("auto", *LINE_LAWS), "law; line = eq. (14) of paper 3, auto = johnson")
    yield_pressure: float = quantity(1.6e9, "Pa", "peak pressure of first yield or lasting damage", above=0.0)


@dataclass(frozen=True)
class TwoDiscsScene:
    """Central impact of two equal elastic discs by a law of line contact (paper 3, section 5.1), without gravity."""

    disc: Disc = section(Disc)
    contact: DiscContact = section(DiscContact)
    motion: Meeting = section(Meeting)
    solver: PairSolver = section(PairSolver)
    run: Run = section(Run)


def sphere_pair(parameters: TwoSpheresScene) -> tuple[float, float, float]:
    """(load coefficient [N/m^1.5], first mass, second mass [kg]); a measured alpha replaces the Hertz coefficient.

    Numbers or arrays that broadcast: studies evaluate many spheres at once.
    """
    first, second, measured = parameters.first, parameters.second, parameters.contact.measured_alpha
    masses = sphere_mass(first), sphere_mass(second)
    given = np.greater(measured, 0.0)
    asked = impact.coefficient_of_alpha(np.where(given, measured, 1.0), masses[0] * masses[1] / sum(masses))
    radius = first.radius * second.radius / (first.radius + second.radius)
    hertz = 4.0 / 3.0 * effective_modulus(first.material, second.material) * np.sqrt(radius)
    return np.where(given, asked, hertz)[()], *masses


def disc_mass(disc: Disc) -> float:
    """Mass of one disc [kg]."""
    return disc.material.density * math.pi * disc.radius**2 * disc.thickness


def disc_law(disc: Disc, name: str):
    """The line law of that name for these discs."""
    material = disc.material
    return line_law(name, disc.radius, disc.thickness, material.young_modulus, material.poisson_ratio)


def meeting_speed(parameters):
    """Relative speed [m/s], NaN where the bodies never meet; numbers or arrays."""
    speed = np.asarray(parameters.motion.speed, float)
    return np.where(speed > 0.0, speed, np.nan)


def pair_contact_time(parameters) -> float:
    """About the contact time [s] of a checked pair: the closed form without damping."""
    speed = parameters.motion.speed
    if isinstance(parameters, TwoSpheresScene):
        coefficient, first, second = sphere_pair(parameters)
        return float(impact.contact_time(coefficient, first * second / (first + second), speed))
    return contact_time_by(parameters, "johnson" if parameters.contact.normal == "auto" else parameters.contact.normal)


def contact_time_by(parameters: TwoDiscsScene, law: str) -> float:
    """Contact time [s] of the discs by one law of line contact; NaN where it has no solution."""
    reduced = 0.5 * disc_mass(parameters.disc)
    return float(disc_closed_form.contact_time(disc_law(parameters.disc, law), reduced, parameters.motion.speed))


def check_spheres(parameters: TwoSpheresScene) -> list[str]:
    """What is impossible although each number alone is legal."""
    problems = _check_meeting(parameters.motion)
    if not problems:
        problems = _check_step(parameters.solver, pair_contact_time(parameters))
    if parameters.contact.damping_law == "steady" and parameters.solver.stepper not in ("auto", "dop853"):
        problems.append(
            f"solver.stepper = {parameters.solver.stepper} does not know contact.damping_law: steady, whose contact "
            "ends before the approach is back at zero; use dop853 or auto"
        )
    return problems + check_run(parameters.run)


def check_discs(parameters: TwoDiscsScene) -> list[str]:
    """As `check_spheres`; also where the law of line contact has no solution, and which model has one."""
    problems = _check_meeting(parameters.motion)
    if problems:
        return problems + check_run(parameters.run)
    disc, speed = parameters.disc, parameters.motion.speed
    energy = 0.25 * disc_mass(disc) * speed**2
    name = "johnson" if parameters.contact.normal == "auto" else parameters.contact.normal
    most = greatest_energy(disc_law(disc, name))
    if energy >= most:
        others = [one for one in LINE_LAWS if energy < greatest_energy(disc_law(disc, one))]
        way_out = f"use contact.normal: {others[0]}, or " if others else ""
        equation = "eq. (14)" if name == "line" else "Johnson's law"
        return [
            f"contact.normal = {name} has no solution: {equation} cannot store the {energy:.4g} J of this impact, only "
            f"{most:.4g} J; {way_out}let the discs meet below {2.0 * math.sqrt(most / disc_mass(disc)):.4g} m/s "
            "(motion.first_velocity)"
        ]
    return _check_step(parameters.solver, pair_contact_time(parameters)) + check_run(parameters.run)


def resolve(parameters):
    """The parameters of a checked pair with the zeros of its run replaced."""
    stretch = 1.0 if isinstance(parameters, TwoDiscsScene) else parameters.contact.restitution**-0.5
    whole = parameters.motion.gap / parameters.motion.speed + 1.25 * stretch * pair_contact_time(parameters)
    return dataclasses.replace(parameters, run=resolved_run(parameters.run, whole, OUTPUTS))


def _check_meeting(motion: Meeting) -> list[str]:
    if motion.speed > 0.0:
        return []
    return [
        f"motion.first_velocity = {motion.first_velocity:g} m/s does not exceed motion.second_velocity = "
        f"{motion.second_velocity:g} m/s, so the bodies never meet; the first, behind, must be the faster"
    ]


def _check_step(solver: PairSolver, contact_time: float) -> list[str]:
    if solver.stepper not in FIXED_STEP or solver.step <= contact_time / FEWEST_STEPS:
        return []
    return [
        f"solver.step = {solver.step:g} s is too long: the contact lasts {contact_time:.4g} s and needs at least "
        f"{FEWEST_STEPS} steps; use {contact_time / FEW_STEPS:.4g} s or less, or solver.stepper: dop853"
    ]
