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

from bearing_twin.contact.materials import effective_modulus
from bearing_twin.contact.validity import gathered, pressure_doubt, wave_doubt, wave_transit, width_doubt
from bearing_twin.kinds.beam.impact import BeamImpact, hertz_contact_time, throw
from bearing_twin.kinds.beam.modes import beam_energy, deflection_shapes, first_frequency, modes_of, stress_shapes
from bearing_twin.kinds.beam.parameters import (
    SphereOnBeamScene,
    beam_of,
    resolve,
    thrown_sphere,
    touch_speed,
)
from bearing_twin.kinds.impact.collision import peak_of
from bearing_twin.kinds.impact.impact import Impact, ImpactMotion
from bearing_twin.sample import Channel

FEWEST_MODES, MOST_MODES = 15, 4000
SLENDER = 10.0  # span / height below which shear and rotary inertia matter
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
        wanted = 40.0 * solver.tolerance ** (-1.0 / 3.5)
    else:
        wanted = (150.0 / solver.tolerance) ** (2.0 / 3.0)
    highest = math.ceil(math.sqrt(wanted / (first_frequency(beam_of(parameters)) * tau)))
    return min(max(highest, FEWEST_MODES), MOST_MODES) | 1


def steps_for(parameters: SphereOnBeamScene, stepper: str) -> int:
    """Steps a Hertz contact time: asked for, or from the tolerance; cubics converge as steps^-6, hats as steps^-2."""
    solver = parameters.solver
    if solver.steps:
        return solver.steps
    if stepper == "volterra":
        return max(500, math.ceil(math.sqrt(7.0 / solver.tolerance)))
    return max(40, math.ceil(12.0 * solver.tolerance ** (-1.0 / 6.0)))


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
    figures = {
        "impact_speed_m_s": speed,
        "sphere_velocity_after_m_s": leaving,
        "contact_count": len(found.contacts),
        "peak_deflection_m": deflection,
        "peak_stress_pa": stress,
        "highest_mode": int(found.modes.index[-1]),
        "gravity_m_s2": parameters.blow.gravity,
    }
    return Impact(
        tuple(channel.name for channel in channels(parameters)),
        watch,
        parameters.run,
        found.contacts,
        -leaving / speed,
        peak,
        (peak / found.sphere.coefficient) ** (2.0 / 3.0),
        _closure(found, brought),
        tuple(_flags(parameters, found, peak, deflection, stress)),
        figures,
        {"steps": len(found.lengths), "modes": len(found.modes.index)},
    )


def motion(parameters: SphereOnBeamScene, law: str, stepper: str) -> ImpactMotion:
    """The impact as a run."""
    return ImpactMotion(solve, parameters, law, stepper)


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
    contact = (force / found.sphere.coefficient) ** (2.0 / 3.0)
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
        0.4 * force * contact,
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
    contact = 0.4 * force[0] * (force[0] / found.sphere.coefficient) ** (2.0 / 3.0)
    fallen = found.sphere.mass * found.sphere.gravity * position[0]
    return float(kinetic + stored + dissipated + contact - fallen - brought) / brought


def _flags(parameters, found, peak, deflection, stress):
    sphere, beam = parameters.sphere, parameters.beam
    modulus = effective_modulus(sphere.material, beam.material)
    half_width = (0.75 * peak * sphere.radius / modulus) ** (1.0 / 3.0)
    pressure = 1.5 * peak / (math.pi * half_width**2) if peak > 0.0 else 0.0
    body, size = min((("radius", sphere.radius), ("height", beam.height)), key=lambda pair: pair[1])
    transit = max(
        wave_transit(2.0 * sphere.radius, sphere.material.young_modulus, sphere.material.density),
        wave_transit(beam.height, beam.material.young_modulus, beam.material.density),
    )
    shortest = min((contact.duration for contact in found.contacts), default=math.inf)
    flags = gathered(
        pressure_doubt(pressure, parameters.contact.yield_pressure),
        width_doubt(half_width, size, body=body),
        wave_doubt(shortest, transit),
    )
    if stress > parameters.contact.yield_stress:
        flags.append(f"bending stress {stress:.3g} Pa is beyond the beam's strength: the elastic result is formal")
    if beam.span < SLENDER * beam.height:
        flags.append(f"the span is only {beam.span / beam.height:.3g} heights: shear and rotary inertia are left out")
    if deflection > 0.02 * beam.span:
        flags.append(f"a deflection of {deflection:.3g} m is large for a span of {beam.span:g} m")
    total = sum(contact.impulse for contact in found.contacts)
    most = 2.0 * found.sphere.mass * touch_speed(parameters.blow)
    if found.sphere.gravity == 0.0 and total > most * (1.0 + 1e-9):
        flags.append(f"the impulse of {total:.4g} N s exceeds 2 m v = {most:.4g} N s: the numbers are wrong")
    if not found.gone:
        flags.append(
            f"the sphere was not surely gone at {found.end:.4g} s: further contacts are possible; lengthen run.duration"
        )
    return flags
