"""A sphere strikes a simply supported beam: paper 2.

    alpha = s - w(x_c),  f = c alpha^1.5                                                     (1), (5)
    s(t) = v t + g t^2 / 2 - (1/m) * integral of f(u) (t - u) du                               (6)
    w(x, t) = sum_n (1/M) sin(n pi x / l) sin(n pi x_c / l) * integral of f(u) sin(omega_n (t - u)) / omega_n du   (8)

s is the sphere's travel, w the deflection, M half the beam's mass. `modes` solves the modal equations with the Hertz
spring, `volterra` eq. (9) itself; both go through any number of contacts, with exact free flight between them.
`sinusoidal` assumes the force of the paper's abstract; its energy balance fails and the run says so.

Gravity acts on the sphere after the first touch when `blow.gravity` is set; the beam is measured from its rest under
its own weight. Bending stress is that of the fibre away from the blow, tension positive.
"""

import functools
import math

import numpy as np

from bearing_twin.contact.elastic import HERTZIAN, approaches_of_loads, energies_at
from bearing_twin.kinds.beam.derived import beam_of, resolve, thrown_sphere, touch_speed
from bearing_twin.kinds.beam.impact import BeamImpact, hertz_contact_time, throw
from bearing_twin.kinds.beam.modes import beam_energy, deflection_shapes, first_frequency, modes_of, stress_shapes
from bearing_twin.kinds.beam.parameters import SphereOnBeamScene
from bearing_twin.kinds.impact.collision import peak_of
from bearing_twin.kinds.impact.figures import contact_rows
from bearing_twin.kinds.impact.impact import Impact, ImpactMotion
from bearing_twin.report import Choice
from bearing_twin.sample import Channel

FEWEST_MODES, MOST_MODES = 15, 4000
PEAK_SAMPLES = 4000


def channels(parameters: SphereOnBeamScene) -> tuple[Channel, ...]:
    """What one sample of this scene holds; the first of the watched points is the point of impact."""
    watched, stations = 1 + len(parameters.outputs.points), parameters.outputs.stations
    return (
        Channel("approach", "m", (), "mutual approach of sphere and beam; negative = gap"),
        Channel("normal_load", "N", (), "contact force, down on the beam and up on the sphere"),
        Channel("sphere_position", "m", (), "travel of the sphere's centre along the blow since the first touch"),
        Channel("sphere_velocity", "m/s", (), "of the sphere's centre along the blow"),
        Channel("deflection", "m", (watched,), "of the beam along the blow at the impact point and outputs.points"),
        Channel("bending_stress", "Pa", (watched,), "there, of the fibre away from the blow, tension positive"),
        Channel("shape", "m", (stations,), "deflection at evenly spaced points from support to support"),
        Channel("kinetic_energy", "J", (), "of the sphere"),
        Channel("beam_energy", "J", (), "kinetic and elastic, of the beam's modes"),
        Channel("elastic_energy", "J", (), "stored in the contact"),
    )


def modes_for(parameters: SphereOnBeamScene, stepper: str) -> int:
    """Highest mode: asked for, or from the tolerance.

    With the static tail in the contact the error is below (omega_N tau / 40)^-3.5 for a Hertz contact time tau, without
    it below 150 (omega_N tau)^-1.5, that is, modes^-3; measured on short, long, off-centre and repeated impacts.
    """
    solver = parameters.solver
    if solver.modes:
        return solver.modes
    tau = hertz_contact_time(thrown_sphere(parameters), touch_speed(parameters.blow))
    if solver.static_tail == "contact":
        wanted = 40.0 * parameters.wanted.tolerance ** (-1.0 / 3.5)
    else:
        wanted = (150.0 / parameters.wanted.tolerance) ** (2.0 / 3.0)
    highest = math.ceil(math.sqrt(wanted / (first_frequency(beam_of(parameters)) * tau)))
    return min(max(highest, FEWEST_MODES), MOST_MODES) | 1


def steps_for(parameters: SphereOnBeamScene, stepper: str) -> int:
    """Steps a Hertz contact time: asked for, or from the tolerance; cubics converge as steps^-6, hats as steps^-2."""
    solver = parameters.solver
    if solver.steps:
        return solver.steps
    if stepper == "volterra":
        return max(500, math.ceil(math.sqrt(7.0 / parameters.wanted.tolerance)))
    return max(40, math.ceil(12.0 * parameters.wanted.tolerance ** (-1.0 / 6.0)))


def throw_scene(parameters: SphereOnBeamScene, stepper: str = "modes") -> BeamImpact:
    """The motion behind a scene, in pieces; `solve` reads channels and figures off it."""
    parameters = resolve(parameters)
    beam = beam_of(parameters)
    modes = modes_of(beam, parameters.blow.point * beam.span, modes_for(parameters, stepper))
    with_tail = parameters.solver.static_tail == "contact"
    return throw(
        beam, modes, thrown_sphere(parameters), touch_speed(parameters.blow), parameters.run.duration,
        steps_for(parameters, stepper), stepper, with_tail,
    )  # fmt: skip


def solve(parameters: SphereOnBeamScene, law: str = "hertz", stepper: str = "modes") -> Impact:
    """The impact by `modes`, `volterra` or `sinusoidal`; raises IntegrationError where it fails."""
    parameters = resolve(parameters)
    found = throw_scene(parameters, stepper)
    speed = touch_speed(parameters.blow)
    brought = 0.5 * found.sphere.mass * speed**2
    watch = functools.partial(_watch, parameters, found)
    leaving = float(found.motions[-1, 1])
    peak = max((contact.peak_force for contact in found.contacts), default=0.0)
    deflection, stress = _greatest(found, watch)
    closure = _closure(found, brought)
    coefficient = found.sphere.coefficient
    deepest = [approaches_of_loads(coefficient, HERTZIAN, contact.peak_force) for contact in found.contacts]
    last = found.contacts[-1].start + found.contacts[-1].duration if found.contacts else 0.0
    known = [last, deflection, stress, closure * brought, found.end, float(found.gone)]
    return Impact(
        names=tuple(channel.name for channel in channels(parameters)),
        at=watch,
        run=parameters.run,
        contacts=found.contacts,
        restitution=-leaving / speed,
        peak_force=peak,
        greatest_approach=approaches_of_loads(coefficient, HERTZIAN, peak),
        energy_closure=closure,
        costs={"steps": len(found.lengths), "modes": len(found.modes.index)},
        records={"contact": contact_rows(found.contacts, deepest, 0.0, 0.0), "extremes": np.array([known])},
        extremes={"peak_deflection": deflection, "peak_stress": stress},
    )


def motion(parameters: SphereOnBeamScene, choice: Choice) -> ImpactMotion:
    """The impact as a run."""
    return ImpactMotion(solve, parameters, choice.law, choice.stepper)


def _watch(parameters, found, times):
    """All channels at increasing times [s]; beyond the end of the known motion the last instant stands."""
    times = np.minimum(np.asarray(times, float), found.end)
    states, force, position, velocity = found.at(times)
    q = found.coordinates(states)
    beam, modes = found.beam, found.modes
    points = np.array([parameters.blow.point, *parameters.outputs.points]) * beam.span
    stations = np.linspace(0.0, beam.span, parameters.outputs.stations)

    def sum_of(shapes):
        return q @ shapes[0].T + force[:, None] * shapes[1]

    deflection = sum_of(deflection_shapes(beam, modes, points))
    contact = approaches_of_loads(found.sphere.coefficient, HERTZIAN, force)
    return (
        np.where(force > 0.0, contact, position - deflection[:, 0]),
        force,
        position,
        velocity,
        deflection,
        sum_of(stress_shapes(beam, modes, points)),
        sum_of(deflection_shapes(beam, modes, stations)),
        0.5 * found.sphere.mass * velocity**2,
        beam_energy(modes, states),
        energies_at(found.sphere.coefficient, HERTZIAN, contact),
    )


def _greatest(found, watch):
    """Greatest deflection [m] and bending stress [Pa], by magnitude, over all watched points and the whole motion."""
    times = np.linspace(0.0, found.end, PEAK_SAMPLES)
    values = watch(times)
    results = []
    for column in (4, 5):
        size = np.abs(values[column])
        top, point = np.unravel_index(int(np.argmax(size)), size.shape)
        low, high = times[max(top - 1, 0)], times[min(top + 1, len(times) - 1)]
        fine = np.linspace(low, high, 101)
        results.append(peak_of(fine, np.abs(watch(fine)[column][:, point])))
    return results


def _closure(found, brought):
    """Energy gained by the numbers as a share of what the sphere brought; gravity's work is not a gain."""
    kinetic, stored, dissipated = found.energies()
    _, force, position, _ = found.at(np.array([found.end]))
    coefficient = found.sphere.coefficient
    contact = energies_at(coefficient, HERTZIAN, approaches_of_loads(coefficient, HERTZIAN, force[0]))
    fallen = found.sphere.mass * found.sphere.gravity * position[0]
    return float(kinetic + stored + dissipated + contact - fallen - brought) / brought
