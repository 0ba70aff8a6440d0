"""A sphere strikes a simply supported beam: paper 2.

    alpha = s - w(x_c),  f = c alpha^1.5                                                     (1), (5)
    s(t) = v t + g t^2 / 2 - (1/m) * integral of f(u) (t - u) du                               (6)
    w(x, t) = sum_n (1/M) sin(n pi x / l) sin(n pi x_c / l) * integral of f(u) sin(omega_n (t - u)) / omega_n du   (8)

s is the sphere's travel, w the deflection, M half the beam's mass; the modes are Euler's, as in the paper, or
Timoshenko's. `modes` solves the modal equations with the Hertz spring, `volterra` eq. (9) itself; both go through any
number of contacts, with exact free flight between them. `sinusoidal` assumes the force of the paper's abstract; its
energy balance fails and the run says so.

Gravity acts on the sphere after the first touch when `blow.gravity` is set; the beam is measured from its rest under
its own weight. Bending stress is that of the fibre away from the sphere, tension positive.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Channel
from bearing_twin.base.stopping import SIGNALLED
from bearing_twin.contact.elasticity import approaches_of_loads, energies_at
from bearing_twin.contact.laws import HERTZIAN
from bearing_twin.kinds.beam.impact import BeamImpact, solve_impact
from bearing_twin.kinds.beam.models import (
    PEAK_SAMPLES,
    beam_of,
    impact_speed,
    modes_for,
    resolve,
    sphere_of,
    steps_for,
    theory_of,
)
from bearing_twin.kinds.beam.modes import beam_energy, deflection_shapes, modes_of, stress_shapes
from bearing_twin.kinds.beam.parameters import SphereOnBeamScene
from bearing_twin.kinds.impact.collision import peak_of
from bearing_twin.kinds.impact.figures import contact_rows
from bearing_twin.kinds.impact.impact import Impact, ImpactMotion

TOGETHER = 500_000  # states of modes read off at once


def channels(parameters: SphereOnBeamScene) -> tuple[Channel, ...]:
    """What one sample of this scene holds; the first of the observed points is the point of impact."""
    watched, stations = 1 + len(parameters.outputs.points), parameters.outputs.stations
    return (
        Channel("approach", "m", (), "mutual approach of sphere and beam; negative = gap"),
        Channel("normal_load", "N", (), "contact force, down on the beam and up on the sphere"),
        Channel("sphere_position", "m", (), "travel of the sphere's centre along its motion since the first contact"),
        Channel("sphere_velocity", "m/s", (), "of the sphere's centre along its motion before the impact"),
        Channel(
            "deflection",
            "m",
            (watched,),
            "of the beam along the sphere's motion, at the impact point and outputs.points",
            ("watched",),
        ),
        Channel(
            "bending_stress",
            "Pa",
            (watched,),
            "there, of the fibre away from the sphere, tension positive",
            ("watched",),
        ),
        Channel("shape", "m", (stations,), "deflection at evenly spaced points from support to support", ("station",)),
        Channel("kinetic_energy", "J", (), "of the sphere"),
        Channel("beam_energy", "J", (), "kinetic and elastic, of the beam"),
        Channel("elastic_energy", "J", (), "stored in the contact"),
    )


class Top(NamedTuple):
    """The greatest `value` of an observed point by magnitude, and times [s] around its instant."""

    value: float
    point: int
    times: np.ndarray


class WatchedPoints:
    """The channels of a known motion at increasing times [s]; beyond its end the last instant stands."""

    def __init__(self, parameters: SphereOnBeamScene, found: BeamImpact):
        self._found, beam, modes = found, found.beam, found.modes
        points = np.array([parameters.blow.point, *parameters.outputs.points]) * beam.span
        stations = np.linspace(0.0, beam.span, parameters.outputs.stations)
        self._deflection, self._stress = deflection_shapes(beam, modes, points), stress_shapes(beam, modes, points)
        self._shape = deflection_shapes(beam, modes, stations)

    def __call__(self, times) -> tuple[np.ndarray, ...]:
        """One array (times, *shape) a channel."""
        return self._in_blocks(times, self._channels)

    def at_points(self, times) -> tuple[np.ndarray, np.ndarray]:
        """Deflection [m] and bending stress [Pa], (times, points): the point of impact, then `outputs.points`."""
        return self._in_blocks(times, self._bending)

    def greatest(self) -> list[Top]:
        """Greatest deflection [m] and bending stress [Pa] by magnitude, of all observed points and the whole motion."""
        times, results = np.linspace(0.0, self._found.end, PEAK_SAMPLES), []
        for column, values in enumerate(self.at_points(times)):
            size = np.abs(values)
            top, point = np.unravel_index(int(np.argmax(size)), size.shape)
            low, high = times[max(top - 1, 0)], times[min(top + 1, len(times) - 1)]
            fine = np.linspace(low, high, 101)
            results.append(Top(self.top_near(column, point, fine), point, fine))
        return results

    def top_near(self, column: int, point: int, times) -> float:
        """The greatest deflection (column 0) or stress (1) by magnitude, of one point at times close to each other."""
        return peak_of(np.abs(self.at_points(times)[column][:, point]))

    def _in_blocks(self, times, function):
        """`function` of (states, force, position, velocity), so many times at once that memory stays small."""
        times = np.minimum(np.asarray(times, float), self._found.end)
        rows = max(1, TOGETHER // len(self._found.modes.index))
        parts = [function(*self._found.at(times[row : row + rows])) for row in range(0, len(times), rows)]
        return tuple(np.concatenate(column) for column in zip(*parts, strict=True))

    def _bending(self, states, force, *_):
        q = self._found.coordinates(states)
        return tuple(q @ modal.T + force[:, None] * still for modal, still in (self._deflection, self._stress))

    def _channels(self, states, force, position, velocity):
        found, (deflection, stress) = self._found, self._bending(states, force)
        contact = approaches_of_loads(found.sphere.coefficient, HERTZIAN, force)
        return (
            np.where(force > 0.0, contact, position - deflection[:, 0]),
            force,
            position,
            velocity,
            deflection,
            stress,
            found.coordinates(states) @ self._shape[0].T + force[:, None] * self._shape[1],
            0.5 * found.sphere.mass * velocity**2,
            beam_energy(found.modes, states, force),
            energies_at(found.sphere.coefficient, HERTZIAN, contact),
        )


def impact_of_scene(parameters: SphereOnBeamScene, stepper: str = "modes", stop=SIGNALLED) -> BeamImpact:
    """The motion behind a scene, in pieces; `solve` reads channels and figures off it."""
    parameters = resolve(parameters)
    beam = beam_of(parameters, theory_of(parameters))
    modes = modes_of(beam, parameters.blow.point * beam.span, modes_for(parameters))
    with_tail = parameters.solver.static_tail == "contact"
    return solve_impact(
        beam, modes, sphere_of(parameters), impact_speed(parameters.blow), parameters.run.duration,
        steps_for(parameters, stepper), stepper, with_tail, stop,
    )  # fmt: skip


def solve(parameters: SphereOnBeamScene, law: str = "hertz", stepper: str = "modes", stop=SIGNALLED) -> Impact:
    """The impact by `modes`, `volterra` or `sinusoidal`.

    Raises IntegrationError where it fails, and Stopped, also when outputs are read off, soon after `stop` is not 0.
    """
    parameters = resolve(parameters)
    found = impact_of_scene(parameters, stepper, stop)
    brought = 0.5 * found.sphere.mass * impact_speed(parameters.blow) ** 2
    watch = WatchedPoints(parameters, found)
    # What is greatest in the beam costs more than all contacts: not computed where contacts alone are requested.
    wanted = parameters.wanted.outputs == "history"
    tops = watch.greatest() if wanted else ()
    deflection, stress = (top.value for top in tops) if wanted else (math.nan, math.nan)
    closure = _closure(found, brought)
    coefficient = found.sphere.coefficient
    deepest = [approaches_of_loads(coefficient, HERTZIAN, contact.peak_force) for contact in found.contacts]
    last = found.contacts[-1].start + found.contacts[-1].duration if found.contacts else 0.0
    records = {"contact": contact_rows(found.contacts, deepest, 0.0, 0.0)}
    known = [last, deflection, stress, closure * brought, found.end, found.gone, modes_for(parameters)]
    costs = {"steps": len(found.pieces.lengths), "modes": len(found.modes.index)}
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
