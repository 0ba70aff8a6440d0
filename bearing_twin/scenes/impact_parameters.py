"""Every number and choice of the impact scenes: YAML keys, units, defaults and limits; what is impossible together."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

import dataclasses
import math
from dataclasses import dataclass

from bearing_twin.contact.line import LINE_LAWS, greatest_energy, line_law
from bearing_twin.materials import MATERIALS, Material, effective_modulus
from bearing_twin.motion.beam import Beam, first_frequency, rectangular_beam, static_deflection
from bearing_twin.motion.beam_contact import Sphere as ThrownSphere
from bearing_twin.motion.beam_impact import METHODS, hertz_contact_time
from bearing_twin.motion.collision import FEW_STEPS, FEWEST_STEPS, FIXED_STEP
from bearing_twin.parameters import choice, quantity, section
from bearing_twin.reference import disc_impact, impact

STANDARD_GRAVITY = 9.80665
PAIR_STEPPERS = ("closed_form", "dop853", *FIXED_STEP)
PAIR_OUTPUTS, BEAM_OUTPUTS = 400, 1500
"""Outputs of a run whose output_rate is left to be chosen."""

PERIODS = 3.0  # of the beam's first mode: the duration of a run when it is left to be chosen
HEAVIEST = 20.0  # sphere mass / beam mass
GREATEST_BEND = 0.1  # deflection / span: beyond it the beam's own length change carries load


@dataclass(frozen=True)
class Sphere:
    """A homogeneous elastic sphere."""

    radius: float = quantity(0.01905, "m", "radius", above=0.0)
    mass: float = quantity(0.0, "kg", "mass; 0 = from radius and density", at_least=0.0)
    material: Material = section(Material, "steel", MATERIALS)


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
class Run:
    """What is computed and how often it is given out; zeros are replaced by numbers that suit the contact."""

    wanted: str = choice(
        "history", ("history", "peaks"), "history = forces over time; peaks = contact time, peak force"
    )
    duration: float = quantity(
        0.0, "s", "simulated time; 0 = the whole contact and some more", at_least=0.0, at_most=60
    )
    output_rate: float = quantity(0.0, "Hz", "solver outputs; 0 = chosen", at_least=0.0, at_most=1e9)
    publish_rate: float = quantity(0.0, "Hz", "published outputs; 0 = all", at_least=0.0, at_most=1e9)


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


@dataclass(frozen=True)
class BeamParameters:
    """A simply supported beam of rectangular section at rest; its own weight bends it before, and is left out."""

    span: float = quantity(0.1535, "m", "distance of the supports", above=0.0)
    width: float = quantity(0.01, "m", "width across the blow", above=0.0)
    height: float = quantity(0.01, "m", "height along the blow", above=0.0)
    damping_ratio: float = quantity(0.0, "1", "of every mode, as a share of critical damping", at_least=0.0, below=1.0)
    material: Material = section(Material)


@dataclass(frozen=True)
class Blow:
    """How the sphere comes: by its speed or by the height it has fallen from."""

    speed: float = quantity(0.0, "m/s", "speed at the first touch; 0 = from drop_height", at_least=0.0)
    drop_height: float = quantity(0.0, "m", "free fall before the first touch", at_least=0.0)
    gravity: float = quantity(0.0, "m/s^2", "on the sphere, along the blow, after the first touch; 0 = left out")
    point: float = quantity(
        0.5, "1", "where on the beam, as a share of the span from one support", above=0.0, below=1.0
    )


@dataclass(frozen=True)
class BeamContact:
    """Where the elastic theory ends."""

    yield_pressure: float = quantity(
        1.6e9, "Pa", "peak pressure of first yield, about 1.6 times the strength", above=0.0
    )
    yield_stress: float = quantity(1.0e9, "Pa", "strength of the beam in bending", above=0.0)


@dataclass(frozen=True)
class BeamSolver:
    """How sphere and beam are computed."""

    stepper: str = choice("auto", ("auto", *METHODS), "method; auto = modes; sinusoidal breaks the energy balance")
    tolerance: float = quantity(1e-6, "1", "wanted relative error of forces and times", at_least=1e-10, at_most=0.01)
    modes: int = quantity(0, "1", "highest mode; 0 = from the tolerance", at_least=0, at_most=4000)
    steps: int = quantity(0, "1", "steps a Hertz contact time; 0 = from the tolerance", at_least=0, at_most=200000)
    static_tail: str = choice(
        "contact", ("contact", "outputs"), "where the modes left out still bend statically: also in the contact, or not"
    )


@dataclass(frozen=True)
class BeamOutputs:
    """Where the beam is watched, besides the point of impact."""

    points: tuple[float, float, float] = quantity(
        (0.25, 0.5, 0.75), "1", "of deflection and stress, as shares of the span", at_least=0.0, at_most=1.0
    )
    stations: int = quantity(41, "1", "evenly spaced points of the beam's shape", at_least=3, at_most=1001)


@dataclass(frozen=True)
class SphereOnBeamScene:
    """A sphere strikes a simply supported beam (paper 2)."""

    beam: BeamParameters = section(BeamParameters)
    sphere: Sphere = section(Sphere)
    contact: BeamContact = section(BeamContact)
    blow: Blow = section(Blow)
    outputs: BeamOutputs = section(BeamOutputs)
    solver: BeamSolver = section(BeamSolver)
    run: Run = section(Run)


def sphere_mass(sphere: Sphere) -> float:
    """Mass [kg]: given, or that of the homogeneous sphere."""
    return sphere.mass or sphere.material.density * 4.0 / 3.0 * math.pi * sphere.radius**3


def sphere_pair(parameters: TwoSpheresScene) -> tuple[float, float, float]:
    """(load coefficient [N/m^1.5], first mass, second mass [kg]); a measured alpha replaces the Hertz coefficient."""
    first, second = parameters.first, parameters.second
    masses = sphere_mass(first), sphere_mass(second)
    measured = parameters.contact.measured_alpha
    if measured:
        return float(impact.coefficient_of_alpha(measured, masses[0] * masses[1] / sum(masses))), *masses
    radius = first.radius * second.radius / (first.radius + second.radius)
    return 4.0 / 3.0 * effective_modulus(first.material, second.material) * math.sqrt(radius), *masses


def disc_mass(disc: Disc) -> float:
    """Mass of one disc [kg]."""
    return disc.material.density * math.pi * disc.radius**2 * disc.thickness


def disc_law(disc: Disc, name: str):
    """The line law of that name for these discs."""
    material = disc.material
    return line_law(name, disc.radius, disc.thickness, material.young_modulus, material.poisson_ratio)


def beam_of(parameters: SphereOnBeamScene) -> Beam:
    """The beam as numbers."""
    beam, material = parameters.beam, parameters.beam.material
    return rectangular_beam(
        beam.span, beam.width, beam.height, material.young_modulus, material.density, beam.damping_ratio
    )


def thrown_sphere(parameters: SphereOnBeamScene) -> ThrownSphere:
    """The sphere and its Hertz spring against the flat beam: f = (4/3) E* sqrt(R) alpha^1.5 (paper 2, eq. 1)."""
    sphere = parameters.sphere
    modulus = effective_modulus(sphere.material, parameters.beam.material)
    return ThrownSphere(sphere_mass(sphere), 4.0 / 3.0 * modulus * math.sqrt(sphere.radius), parameters.blow.gravity)


def touch_speed(blow: Blow) -> float:
    """Speed [m/s] at the first touch."""
    return blow.speed or math.sqrt(2.0 * STANDARD_GRAVITY * blow.drop_height)


def pair_contact_time(parameters) -> float:
    """About the contact time [s] of a checked pair: the closed form without damping."""
    speed = parameters.motion.speed
    if isinstance(parameters, TwoSpheresScene):
        coefficient, first, second = sphere_pair(parameters)
        return float(impact.contact_time(coefficient, first * second / (first + second), speed))
    law = disc_law(parameters.disc, "johnson" if parameters.contact.normal == "auto" else parameters.contact.normal)
    return float(disc_impact.contact_time(law, 0.5 * disc_mass(parameters.disc), speed))


def check_spheres(parameters: TwoSpheresScene) -> list[str]:
    """What is impossible although each number alone is legal."""
    problems = _check_meeting(parameters.motion)
    if not problems:
        problems = _check_step(parameters.solver, pair_contact_time(parameters))
    return problems + _check_run(parameters.run)


def check_discs(parameters: TwoDiscsScene) -> list[str]:
    """As `check_spheres`; also where the law of line contact has no solution, and which model has one."""
    problems = _check_meeting(parameters.motion)
    if problems:
        return problems + _check_run(parameters.run)
    disc, speed = parameters.disc, parameters.motion.speed
    energy = 0.25 * disc_mass(disc) * speed**2
    name = "johnson" if parameters.contact.normal == "auto" else parameters.contact.normal
    most = greatest_energy(disc_law(disc, name))
    if energy >= most:
        others = [one for one in LINE_LAWS if energy < greatest_energy(disc_law(disc, one))]
        way_out = f"contact.normal: {others[0]}, or " if others else ""
        equation = "eq. (14)" if name == "line" else "Johnson's law"
        return [
            f"contact.normal = {name} has no solution: {equation} cannot store the {energy:.4g} J of this impact, only "
            f"{most:.4g} J; use {way_out}finite elasticity (an elastic disc by finite "
            f"elements), or a speed below {2.0 * math.sqrt(most / disc_mass(disc)):.4g}"
            f" m/s"
        ]
    return _check_step(parameters.solver, pair_contact_time(parameters)) + _check_run(parameters.run)


def check_beam(parameters: SphereOnBeamScene) -> list[str]:
    """As `check_spheres`, for a sphere on a beam."""
    problems, blow, beam = [], parameters.blow, beam_of(parameters)
    if blow.speed and blow.drop_height:
        problems.append(
            f"blow.speed = {blow.speed:g} m/s and blow.drop_height = {blow.drop_height:g} m set the speed twice; keep one"
        )
    if touch_speed(blow) == 0.0:
        problems.append(
            "blow.speed and blow.drop_height are both 0, so the bodies never meet; give one of them above 0"
        )
    mass = sphere_mass(parameters.sphere)
    if mass > HEAVIEST * beam.mass:
        problems.append(
            f"the sphere of {mass:.4g} kg is heavier than the model allows on a beam of {beam.mass:.4g} kg; "
            f"its mass must be at most {HEAVIEST:g} times the beam's: lower sphere.radius or sphere.mass"
        )
    if parameters.beam.height > beam.span / 3.0:
        problems.append(
            f"beam.height = {parameters.beam.height:g} m makes a block of a span of {beam.span:g} m; Euler-Bernoulli "
            f"beams need a height of at most {beam.span / 3.0:.4g} m"
        )
    point = blow.point * beam.span
    bend = touch_speed(blow) * math.sqrt(mass * float(static_deflection(beam, point, point)))
    if not problems and bend > GREATEST_BEND * beam.span:
        problems.append(
            f"the blow could bend the beam by {bend:.4g} m, too much of its span of {beam.span:g} m for small "
            f"deflections; it must stay below {GREATEST_BEND * beam.span:.4g} m: lower the speed or stiffen the beam"
        )
    steps = parameters.solver.steps
    if 0 < steps < FEWEST_STEPS:
        problems.append(
            f"solver.steps = {steps} is too few: a contact needs at least {FEWEST_STEPS} steps or it falls apart into "
            f"false ones; use {FEW_STEPS} or more, or 0"
        )
    return problems + _check_run(parameters.run)


def resolve(parameters):
    """The parameters of a checked scene with the zeros of its run replaced: duration, output and publish rate."""
    run = parameters.run
    if isinstance(parameters, SphereOnBeamScene):
        speed, outputs = touch_speed(parameters.blow), BEAM_OUTPUTS
        whole = PERIODS * 2.0 * math.pi / first_frequency(beam_of(parameters))
        whole += 4.0 * hertz_contact_time(thrown_sphere(parameters), speed)
    else:
        outputs = PAIR_OUTPUTS
        stretch = 1.0 if isinstance(parameters, TwoDiscsScene) else 1.0 / parameters.contact.restitution**0.5
        whole = parameters.motion.gap / parameters.motion.speed + 1.25 * stretch * pair_contact_time(parameters)
    duration = run.duration or float(f"{whole:.4g}")
    period_ns = max(1, round(1e9 * duration / outputs))
    output_rate = run.output_rate or 1e9 / period_ns
    run = dataclasses.replace(
        run, duration=duration, output_rate=output_rate, publish_rate=run.publish_rate or output_rate
    )
    return dataclasses.replace(parameters, run=run)


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


def _check_run(run: Run) -> list[str]:
    problems = []
    if run.output_rate and run.publish_rate > run.output_rate:
        problems.append(
            f"run.publish_rate = {run.publish_rate:g} Hz cannot exceed run.output_rate = {run.output_rate:g} Hz; "
            "raise the latter or lower the former"
        )
    if run.duration * run.output_rate > 1e7:
        problems.append(f"run.duration * run.output_rate = {run.duration * run.output_rate:g} outputs is too many; 1e7")
    return problems
