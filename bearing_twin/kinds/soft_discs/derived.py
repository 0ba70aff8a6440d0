"""Numbers that follow from the keys of soft discs; what is impossible among the keys; the mesh that is chosen."""

import dataclasses
import math

from scipy.special import beta

from bearing_twin.base.report import Choice
from bearing_twin.contact import hertz_impact
from bearing_twin.contact.line import contact_time as line_contact_time
from bearing_twin.contact.line import line_law
from bearing_twin.kinds.rules import SOFT, answers, sentences
from bearing_twin.kinds.sections import check_run, resolved_run
from bearing_twin.kinds.soft_discs.parameters import GREATEST_DIVISIONS, OtherDisc, SoftDiscsScene

GREATEST_RATIO = 0.4995  # Poisson's ratio in Lame's first parameter is capped at this
OUTPUTS = 400  # of a run whose output_rate is left to be chosen
LONGER = 1.35  # of a run against the estimate of its contact, which is 7 % short to 24 % long
LONG = 60.0  # s of a run that says how long it takes
BRIEFEST = 4.5  # contact time in r sqrt(rho/E) where Johnson's law cannot store the energy

ERRORS = {1: (6.7e-3, 1.55), 2: (4.9e-3, 2.6), 3: (4.2e-3, 2.3), 4: (3.4e-3, 2.2)}
"""By order: relative error of the force, root mean square on [0, 0.07 s], with 16 divisions, and its rate; measured on
the mean problem of paper 3, section 5.2, against 64 divisions of order 4 (`bearing_twin chart discs`)."""
STEPS = {1: 0.37, 2: 0.27, 3: 0.21, 4: 0.17}
"""By order: step at half the bound times divisions over r sqrt(rho/E), Poisson's ratio 0.25.

Study: `tests/core/algorithms/test_soft_discs.py`."""
FEWEST = 6  # divisions that are chosen
STIFF, STIFF_POWER, SLOWER_POWER = 10.0, 1.17, 0.083
"""Beyond this ratio of stiffness of the penalty the error with 16 divisions grows by this power of it, and its rate
falls by the other: with 30 and 100 the error is 4 to 5 and 13 to 27 times that of 10, with 12 to 24 divisions of order
3 in `soft_discs_mean` and `soft_discs_fast`, where it falls by the power 1.9 from 24 to 114 divisions."""
SECONDS = 5e-8  # a node and step; measured
UNEQUAL = 20.0  # ratio of radii of two discs, at most
GREATEST_SECONDS, GREATEST_MEMORY = 3600.0, 2e9  # of a run, at most


def capped_ratio(parameters: SoftDiscsScene) -> float:
    """Poisson's ratio as Lame's first parameter takes it."""
    return min(parameters.disc.material.poisson_ratio, GREATEST_RATIO)


def seen_from_other(parameters: SoftDiscsScene) -> SoftDiscsScene:
    """The parameters as the other of two discs sees them."""
    radius, material = parameters.other.radius, parameters.other.material
    return dataclasses.replace(
        parameters,
        disc=dataclasses.replace(parameters.disc, radius=radius, material=material),
        other=OtherDisc(parameters.disc.radius, parameters.disc.material),
    )


def mass_share(parameters: SoftDiscsScene) -> float:
    """Share of the relative speed that the disc has in the frame of the centre of mass; a wall does not move."""
    if parameters.against == "wall":
        return 1.0
    if parameters.against == "disc":
        return 0.5
    other_mass = disc_mass(seen_from_other(parameters))
    return other_mass / (other_mass + disc_mass(parameters))


def wave_speed(parameters: SoftDiscsScene) -> float:
    """sqrt(E/rho) [m/s], that of a thin bar."""
    material = parameters.disc.material
    return math.sqrt(material.young_modulus / material.density)


def wall_speed(parameters: SoftDiscsScene) -> float:
    """Speed [m/s] of the disc towards the wall; of two discs in the frame of their centre of mass."""
    return parameters.motion.first_velocity * mass_share(parameters)


def disc_mass(parameters: SoftDiscsScene) -> float:
    """Mass [kg] of one disc."""
    disc = parameters.disc
    return disc.material.density * math.pi * disc.radius**2 * disc.thickness


def time_unit(parameters: SoftDiscsScene) -> float:
    """r sqrt(rho/E) [s]."""
    return parameters.disc.radius / wave_speed(parameters)


def contact_time(parameters: SoftDiscsScene) -> float:
    """About the contact time [s]: disc and penalty as two springs one behind the other.

    The disc by Johnson's line contact, the penalty as a bed of springs; the squares of their contact times are added.
    Of two unequal discs the compliances 1/E are added, and the mass is the reduced one.
    """
    speed = wall_speed(parameters) / wave_speed(parameters)
    ratio = capped_ratio(parameters) if parameters.plane == "strain" else 0.0
    disc = line_contact_time(line_law("johnson", 1.0, 1.0, 1.0, ratio), 0.5 * math.pi, 2.0 * speed)
    power = parameters.contact.exponent
    bed = parameters.contact.stiffness_ratio * math.sqrt(2.0) * beta(0.5, power + 1.0)
    penalty = hertz_impact.contact_time(bed, math.pi, speed, power + 0.5)
    duration = math.hypot(disc if math.isfinite(disc) else BRIEFEST, penalty) * time_unit(parameters)
    if parameters.against != "other_disc":
        return duration
    softer = parameters.disc.material.young_modulus / parameters.other.material.young_modulus
    return duration * math.sqrt(mass_share(parameters) * (1.0 + softer))


def bodies_of(parameters: SoftDiscsScene) -> dict[str, SoftDiscsScene]:
    """The discs that are meshed by the section that describes them, each as `disc` of parameters."""
    discs = {"disc": parameters, "other": seen_from_other(parameters)}
    return discs if parameters.against == "other_disc" else {"disc": parameters}


def _error_and_rate(order: int, stiffness_ratio: float) -> tuple[float, float]:
    """Relative error of the force with 16 divisions, and its rate, with a penalty of this ratio of stiffness."""
    error, rate = ERRORS[order]
    stiff = max(1.0, stiffness_ratio / STIFF)
    return error * stiff**STIFF_POWER, rate / stiff**SLOWER_POWER


def predicted_error(order: int, divisions: int, stiffness_ratio: float = STIFF) -> float:
    """Relative error of the force to be expected of a mesh, with a penalty of this ratio of stiffness."""
    error, rate = _error_and_rate(order, stiffness_ratio)
    return error * (16.0 / divisions) ** rate


def divisions_for(order: int, tolerance: float, stiffness_ratio: float = STIFF) -> int:
    """The fewest divisions that keep to the tolerance."""
    error, rate = _error_and_rate(order, stiffness_ratio)
    return fitting(max(FEWEST, math.ceil(16.0 * (error / tolerance) ** (1.0 / rate) - 1e-9)), order)


def divisions_of(parameters: SoftDiscsScene) -> int:
    """The divisions for a scene's tolerance, at most GREATEST_DIVISIONS."""
    order, ratio = parameters.mesh.order, parameters.contact.stiffness_ratio
    return fitting(min(divisions_for(order, parameters.wanted.tolerance, ratio), GREATEST_DIVISIONS), order)


def fitting(divisions: int, order: int) -> int:
    """The nearest number of divisions, not below, that elements of that order can have: twice the order, or more."""
    return -(-divisions // (2 * order)) * 2 * order


def predicted_seconds(parameters: SoftDiscsScene) -> float:
    """About the seconds a run takes on one processor, from its resolved keys."""
    discs, nodes = len(bodies_of(parameters)), nodes_of(parameters.mesh.divisions)
    return parameters.run.duration / predicted_step(parameters) * discs * nodes * SECONDS


def predicted_step(parameters: SoftDiscsScene) -> float:
    """About the step [s] of a run, from its resolved keys."""
    mesh, step = parameters.mesh, math.inf
    for disc in bodies_of(parameters).values():
        ratio = capped_ratio(disc)
        stiff = math.sqrt((1.0 - ratio) / ((1.0 + ratio) * (1.0 - 2.0 * ratio)) / 1.2)
        steps_share = STEPS[mesh.order] / mesh.divisions * 2.0 * parameters.solver.step_share / max(stiff, 1.0)
        step = min(step, steps_share * time_unit(disc))
    return step


def nodes_of(divisions: int) -> int:
    """Number of nodes of half the disc."""
    return 3 * divisions**2 // 2 + 2 * divisions + 1


def check(parameters: SoftDiscsScene) -> list[str]:
    """Problems of numbers that are legal one by one."""
    problems = check_run(parameters.run)
    for name, disc in bodies_of(parameters).items():
        waves, speed = wave_speed(disc), wall_speed(disc)
        if speed >= waves:
            problems.append(
                f"motion.first_velocity brings the disc to the wall at {speed:g} m/s, above the speed of waves in it, "
                f"sqrt(E/rho) = {waves:.4g} m/s; keep well below, or raise {name}.material.young_modulus"
            )
    radius, other_radius = parameters.disc.radius, parameters.other.radius
    if parameters.against == "other_disc" and not 1.0 / UNEQUAL <= other_radius / radius <= UNEQUAL:
        problems.append(
            f"other.radius = {other_radius:g} m and disc.radius = {radius:g} m differ by more than a factor of "
            f"{UNEQUAL:g}: take the greater one for a wall (against: wall)"
        )
    if problems:
        return problems
    resolved = resolve(parameters)
    seconds = predicted_seconds(resolved)
    memory = (
        16.0
        * len(bodies_of(resolved))
        * nodes_of(resolved.mesh.divisions)
        * resolved.run.duration
        * resolved.run.output_rate
    )
    if seconds > GREATEST_SECONDS:
        problems.append(
            f"mesh.divisions = {resolved.mesh.divisions} with solver.step_share = {resolved.solver.step_share:g} would "
            f"take about {seconds / 3600.0:.2g} hours; lower the divisions, or raise the share or wanted.tolerance"
        )
    if memory > GREATEST_MEMORY:
        problems.append(
            f"the shapes of mesh.divisions = {resolved.mesh.divisions} at run.output_rate = "
            f"{resolved.run.output_rate:g} Hz would take {memory:.2g} B; lower one of them"
        )
    return problems


def resolve(parameters: SoftDiscsScene) -> SoftDiscsScene:
    """The parameters of a checked scene with the zeros of mesh and run replaced."""
    mesh = parameters.mesh
    divisions = mesh.divisions or divisions_of(parameters)
    return dataclasses.replace(
        parameters,
        mesh=dataclasses.replace(mesh, divisions=fitting(divisions, mesh.order)),
        run=resolved_run(parameters.run, LONGER * contact_time(parameters), OUTPUTS),
    )


def choose(parameters: SoftDiscsScene) -> Choice:
    """The formulation as law; its error is that of the mesh, measured on the mean problem of paper 3, section 5.2."""
    ratio = parameters.contact.stiffness_ratio
    choices, mesh, tolerance = answers(SOFT, parameters), parameters.mesh, parameters.wanted.tolerance
    error, seconds = predicted_error(mesh.order, mesh.divisions, ratio), predicted_seconds(parameters)
    warnings = []
    if error > tolerance:
        warnings.append(
            f"mesh.divisions = {mesh.divisions} of order {mesh.order} has an error of about {error:.1g} in the force, "
            f"more than wanted.tolerance = {tolerance:g}; leave mesh.divisions out to have it chosen"
        )
    if seconds > LONG:
        warnings.append(f"this run takes about {seconds:.2g} s on one processor")
    stepper = choices["solver.stepper"].value
    return Choice(parameters.formulation, stepper, error, sentences(choices), tuple(warnings))


def speed_share(parameters) -> float:
    """Speed of the disc that comes fastest for its stiffness, in the frame of both, over that of waves in it."""
    return max(wall_speed(disc) / wave_speed(disc) for disc in bodies_of(parameters).values())


def thickness_over_radius(parameters) -> float:
    """Of the smaller disc."""
    return max(scene.disc.thickness / scene.disc.radius for scene in bodies_of(parameters).values())


def poisson_ratio_in_strain(parameters) -> float | None:
    """The greatest Poisson's ratio, as Lame's first parameter takes it; None in plane stress."""
    if parameters.plane != "strain":
        return None
    return max(capped_ratio(disc) for disc in bodies_of(parameters).values())
