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

from bearing_twin.contact.elastic import HERTZIAN, approaches_of_loads, energies_at
from bearing_twin.kinds.beam.derived import beam_of, resolve, thrown_sphere, touch_speed
from bearing_twin.kinds.beam.doubt import FINER, companion_row, wanted_errors
from bearing_twin.kinds.beam.fineness import modes_for, states_held, steps_for
from bearing_twin.kinds.beam.impact import MOST_BYTES, MOST_MODES, BeamImpact, throw
from bearing_twin.kinds.beam.modes import modes_of
from bearing_twin.kinds.beam.parameters import SphereOnBeamScene
from bearing_twin.kinds.beam.theory import theory_of
from bearing_twin.kinds.beam.watched import WatchedPoints
from bearing_twin.kinds.impact.figures import contact_rows
from bearing_twin.kinds.impact.impact import Impact, ImpactMotion
from bearing_twin.kinds.second_run import COMPANION, is_watched
from bearing_twin.report import Choice
from bearing_twin.sample import Channel
from bearing_twin.stopping import SIGNALLED

REDONE = 3  # times at most that a motion is done again


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


def throw_scene(
    parameters: SphereOnBeamScene, stepper: str = "modes", stop=SIGNALLED, finer: float = 1.0
) -> BeamImpact:
    """The motion behind a scene, in pieces; `solve` reads channels and figures off it.

    With so many times the modes and steps where it is to be `finer`.
    """
    parameters = resolve(parameters)
    beam = beam_of(parameters, theory_of(parameters))
    modes = modes_of(beam, parameters.blow.point * beam.span, _highest(parameters, finer))
    with_tail = parameters.solver.static_tail == "contact"
    return throw(
        beam, modes, thrown_sphere(parameters), touch_speed(parameters.blow), parameters.run.duration,
        math.ceil(finer * steps_for(parameters, stepper)), stepper, with_tail, stop,
    )  # fmt: skip


def _highest(parameters: SphereOnBeamScene, finer: float) -> int:
    """The highest mode of a motion that is so many times finer."""
    return min(math.ceil(finer * modes_for(parameters)), MOST_MODES)


def solve(parameters: SphereOnBeamScene, law: str = "hertz", stepper: str = "modes", stop=SIGNALLED) -> Impact:
    """The impact by `modes`, `volterra` or `sinusoidal`.

    Raises IntegrationError where it fails, and Stopped, also when outputs are read off, soon after `stop` is not 0.
    """
    parameters = resolve(parameters)
    found, second, finer, before = _watched(parameters, stepper, stop)
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
    if is_watched(parameters):
        records[COMPANION] = companion_row(parameters, found, second, tops)
    known = [last, deflection, stress, closure * brought, found.end, found.gone, _highest(parameters, finer)]
    costs = {"steps": before + len(found.lengths), "modes": len(found.modes.index)}
    return Impact(watch, parameters.run, records | {"extremes": np.array([known], float)}, costs)


def _watched(parameters: SphereOnBeamScene, stepper: str, stop):
    """The motion, its companion (None where none goes), how much finer it is than at first, and steps done in vain.

    Where modes and steps are not given, a motion that its companion finds off by more than is wanted gives way to that
    companion, which gets one of its own.
    """
    found, steps, finer = throw_scene(parameters, stepper, stop), 0, 1.0
    if not is_watched(parameters):
        return found, None, finer, steps
    second, highest = _second(parameters, stop, FINER), modes_for(parameters)
    given = parameters.solver.modes or parameters.solver.steps or stepper != "modes"
    for _ in range(0 if given else REDONE):
        if second is None or _kept(parameters, found, second):
            break
        # With no more modes than that, a companion would find nothing of what is left out.
        following = _second(parameters, stop, finer * FINER**2) if finer * FINER**2 * highest <= MOST_MODES else None
        if following is None:
            break
        steps += len(found.lengths)
        found, second, finer = second, following, finer * FINER
    return found, second, finer, steps


def _kept(parameters: SphereOnBeamScene, found: BeamImpact, second: BeamImpact) -> bool:
    """Whether a motion is as exact as is wanted."""
    errors = wanted_errors(parameters, found, second)
    wanted = errors["peaks"] if parameters.wanted.outputs == "peaks" else max(errors.values())
    return wanted <= parameters.wanted.tolerance


def _second(parameters: SphereOnBeamScene, stop, finer: float) -> BeamImpact | None:
    """A motion that is so many times `finer`; None where no memory would hold it, or modes are as many as may be."""
    held = finer**2 * states_held(steps_for(parameters, "modes"), modes_for(parameters))
    return None if held > MOST_BYTES else throw_scene(parameters, "modes", stop, finer)


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
