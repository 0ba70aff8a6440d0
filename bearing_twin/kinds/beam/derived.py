"""Numbers that follow from the keys of a sphere on a beam; what is impossible among them; what they leave open."""

import dataclasses
import math

from bearing_twin.contact.elasticity import sphere_coefficient
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.kinds.beam.contact import ThrownSphere
from bearing_twin.kinds.beam.impact import MOST_MODES, hertz_contact_time, highest_mode
from bearing_twin.kinds.beam.modes import Beam, first_frequency, rectangular_beam, static_deflection
from bearing_twin.kinds.beam.parameters import EULER, TIMOSHENKO, Blow, SphereOnBeamScene
from bearing_twin.kinds.impact.collision import FEW_STEPS, FEWEST_STEPS
from bearing_twin.kinds.impact.derived import sphere_mass
from bearing_twin.kinds.sections import LOOSEST, STANDARD_GRAVITY, check_run, resolved_run

OUTPUTS, FEW_OUTPUTS = 1500, 50  # of a run whose output_rate is left to be chosen; where peaks alone are wanted
PERIODS = 3.0  # of the beam's first mode: the duration of a run when it is left to be chosen
HEAVIEST = 20.0  # sphere mass / beam mass
FEWEST = dict.fromkeys(("auto", "modes"), 2)
"""Steps a contact, at least, of methods other than FEWEST_STEPS: with 2 modes err by up to 6 %, in three contacts."""
GREATEST_BEND = 0.1  # deflection / span: beyond it the beam's own length change carries load


def beam_of(parameters: SphereOnBeamScene, theory: str = EULER) -> Beam:
    """The beam as numbers, by that theory."""
    beam, material = parameters.beam, parameters.beam.material
    return rectangular_beam(
        beam.span, beam.width, beam.height, material.young_modulus, material.density, beam.damping_ratio,
        material.poisson_ratio if theory == TIMOSHENKO else None,
    )  # fmt: skip


def thrown_sphere(parameters: SphereOnBeamScene) -> ThrownSphere:
    """The sphere and its Hertz spring against the flat beam: f = (4/3) E* sqrt(R) alpha^1.5 (paper 2, eq. 1)."""
    sphere = parameters.sphere
    modulus = effective_modulus(sphere.material, parameters.beam.material)
    coefficient = float(sphere_coefficient("hertz", modulus, sphere.radius))
    return ThrownSphere(sphere_mass(sphere), coefficient, parameters.blow.gravity)


def touch_speed(blow: Blow) -> float:
    """Speed [m/s] at the first touch."""
    return blow.speed or math.sqrt(2.0 * STANDARD_GRAVITY * blow.drop_height)


def check_beam(parameters: SphereOnBeamScene) -> list[str]:
    """As `check_spheres`, for a sphere on a beam."""
    problems, blow, beam = [], parameters.blow, beam_of(parameters)
    if blow.speed and blow.drop_height:
        problems.append(
            f"blow.speed = {blow.speed:g} m/s and blow.drop_height = {blow.drop_height:g} m give the speed; keep one"
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
    problems += _too_many_modes(parameters)
    if parameters.beam.height > beam.span / 3.0:
        problems.append(
            f"beam.height = {parameters.beam.height:g} m makes a block of a span of {beam.span:g} m; "
            f"a beam needs a height of at most {beam.span / 3.0:.4g} m"
        )
    point = blow.point * beam.span
    bend = touch_speed(blow) * math.sqrt(mass * float(static_deflection(beam, point, point)))
    if not problems and bend > GREATEST_BEND * beam.span:
        problems.append(
            f"the blow could bend the beam by {bend:.4g} m, too much of its span of {beam.span:g} m for small "
            f"deflections; it must stay below {GREATEST_BEND * beam.span:.4g} m: lower the speed or stiffen the beam"
        )
    steps, fewest = parameters.solver.steps, FEWEST.get(parameters.solver.stepper, FEWEST_STEPS)
    if 0 < steps < fewest:
        problems.append(
            f"solver.steps = {steps} is too few: a contact needs at least {fewest} steps or it falls apart into "
            f"false ones; use {FEW_STEPS} or more, or 0"
        )
    return problems + check_run(parameters.run)


def _too_many_modes(parameters) -> list[str]:
    """A span so long against the blow that not even the loosest tolerance is met."""
    if parameters.solver.modes or not (speed := touch_speed(parameters.blow)):
        return []
    theory = EULER if parameters.beam.theory == EULER else TIMOSHENKO
    tau = hertz_contact_time(thrown_sphere(parameters), speed)
    wanted = highest_mode(beam_of(parameters, theory), tau, LOOSEST)
    if wanted <= MOST_MODES:
        return []
    span = parameters.beam.span * MOST_MODES / wanted
    return [
        f"a blow of {tau:.3g} s on a span of {parameters.beam.span:g} m wants modes up to {wanted} even for "
        f"{100.0 * LOOSEST:g} %; at most {MOST_MODES}: shorten beam.span to {span:.2g} m or less (no wave comes "
        "back in time from supports so far away), or give solver.modes"
    ]


def resolve(parameters: SphereOnBeamScene) -> SphereOnBeamScene:
    """The parameters of a checked scene with the zeros of its run replaced."""
    whole = PERIODS * 2.0 * math.pi / first_frequency(beam_of(parameters))
    outputs = FEW_OUTPUTS if parameters.wanted.outputs == "peaks" else OUTPUTS
    whole += 4.0 * hertz_contact_time(thrown_sphere(parameters), touch_speed(parameters.blow))
    return dataclasses.replace(parameters, run=resolved_run(parameters.run, whole, outputs))
