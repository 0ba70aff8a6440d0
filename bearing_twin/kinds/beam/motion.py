"""A sphere strikes a simply supported beam: paper 2.

    alpha = s - w(x_c),  f = c alpha^1.5                                                     (1), (5)
    s(t) = v t + g t^2 / 2 - (1/m) * integral of f(u) (t - u) du                               (6)
    w(x, t) = sum_n (1/M) sin(n pi x / l) sin(n pi x_c / l) * integral of f(u) sin(omega_n (t - u)) / omega_n du   (8)

s is the sphere's travel, w the deflection, M half the beam's mass; the modes are Euler's, as in the paper, or
Timoshenko's. `modes` solves the modal equations with the Hertz spring, `volterra` eq. (9) itself; both go through any
number of contacts, with exact free flight between them. `sinusoidal` assumes the force of the paper's abstract; its
energy balance fails and the run says so.

Gravity acts on the sphere after the first touch when `blow.gravity` is set; the beam is measured from its rest under
its own weight. Bending stress is that of the fibre away from the blow, tension positive.
"""

import math

import numpy as np

from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Channel
from bearing_twin.base.stopping import SIGNALLED
from bearing_twin.contact.elastic import HERTZIAN, approaches_of_loads, energies_at
from bearing_twin.kinds.beam.derived import beam_of, resolve, thrown_sphere, touch_speed
from bearing_twin.kinds.beam.fineness import modes_for, steps_for
from bearing_twin.kinds.beam.impact import BeamImpact, throw
from bearing_twin.kinds.beam.modes import modes_of
from bearing_twin.kinds.beam.parameters import SphereOnBeamScene
from bearing_twin.kinds.beam.theory import theory_of
from bearing_twin.kinds.beam.watched import WatchedPoints
from bearing_twin.kinds.impact.figures import contact_rows
from bearing_twin.kinds.impact.impact import Impact, ImpactMotion


def channels(parameters: SphereOnBeamScene) -> tuple[Channel, ...]:
    """What one sample of this scene holds; the first of the watched points is the point of impact."""
    watched, stations = 1 + len(parameters.outputs.points), parameters.outputs.stations
    return (
        Channel("approach", "m", (), "mutual approach of sphere and beam; negative = gap"),
        Channel("normal_load", "N", (), "contact force, down on the beam and up on the sphere"),
        Channel("sphere_position", "m", (), "travel of the sphere's centre along the blow since the first touch"),
        Channel("sphere_velocity", "m/s", (), "of the sphere's centre along the blow"),
        Channel(
            "deflection",
            "m",
            (watched,),
            "of the beam along the blow at the impact point and outputs.points",
            ("watched",),
        ),
        Channel(
            "bending_stress", "Pa", (watched,), "there, of the fibre away from the blow, tension positive", ("watched",)
        ),
        Channel("shape", "m", (stations,), "deflection at evenly spaced points from support to support", ("station",)),
        Channel("kinetic_energy", "J", (), "of the sphere"),
        Channel("beam_energy", "J", (), "kinetic and elastic, of the beam"),
        Channel("elastic_energy", "J", (), "stored in the contact"),
    )


def throw_scene(parameters: SphereOnBeamScene, stepper: str = "modes", stop=SIGNALLED) -> BeamImpact:
    """The motion behind a scene, in pieces; `solve` reads channels and figures off it."""
    parameters = resolve(parameters)
    beam = beam_of(parameters, theory_of(parameters))
    modes = modes_of(beam, parameters.blow.point * beam.span, modes_for(parameters))
    with_tail = parameters.solver.static_tail == "contact"
    return throw(
        beam, modes, thrown_sphere(parameters), touch_speed(parameters.blow), parameters.run.duration,
        steps_for(parameters, stepper), stepper, with_tail, stop,
    )  # fmt: skip


def solve(parameters: SphereOnBeamScene, law: str = "hertz", stepper: str = "modes", stop=SIGNALLED) -> Impact:
    """The impact by `modes`, `volterra` or `sinusoidal`.

    Raises IntegrationError where it fails, and Stopped, also when outputs are read off, soon after `stop` is not 0.
    """
    parameters = resolve(parameters)
    found = throw_scene(parameters, stepper, stop)
    brought = 0.5 * found.sphere.mass * touch_speed(parameters.blow) ** 2
    watch = WatchedPoints(parameters, found)
    # What is greatest in the beam costs more than all contacts: it is left out where contacts alone are wanted.
    wanted = parameters.wanted.outputs == "history"
    tops = watch.greatest() if wanted else ()
    deflection, stress = (top.value for top in tops) if wanted else (math.nan, math.nan)
    closure = _closure(found, brought)
    coefficient = found.sphere.coefficient
    deepest = [approaches_of_loads(coefficient, HERTZIAN, contact.peak_force) for contact in found.contacts]
    last = found.contacts[-1].start + found.contacts[-1].duration if found.contacts else 0.0
    records = {"contact": contact_rows(found.contacts, deepest, 0.0, 0.0)}
    known = [last, deflection, stress, closure * brought, found.end, found.gone, modes_for(parameters)]
    costs = {"steps": len(found.lengths), "modes": len(found.modes.index)}
    return Impact(watch, parameters.run, records | {"extremes": np.array([known], float)}, costs)


class BeamMotion(ImpactMotion):
    """The impact as a run that can be stopped: `stop` (1,)."""

    def __init__(self, parameters: SphereOnBeamScene, choice: Choice):
        self.stop = SIGNALLED
        super().__init__(lambda *scene: solve(*scene, self.stop), parameters, choice)


def _closure(found, brought):
    """Energy gained by the numbers as a share of what the sphere brought; gravity's work is not a gain."""
    kinetic, stored, dissipated = found.energies()
    _, force, position, _ = found.at(np.array([found.end]))
    coefficient = found.sphere.coefficient
    contact = energies_at(coefficient, HERTZIAN, approaches_of_loads(coefficient, HERTZIAN, force[0]))
    fallen = found.sphere.mass * found.sphere.gravity * position[0]
    return float(kinetic + stored + dissipated + contact - fallen - brought) / brought
