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

import dataclasses
import functools
import math
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Channel
from bearing_twin.base.stopping import SIGNALLED, signal_flag
from bearing_twin.contact.elasticity import approaches_of_loads, energies_at, sphere_coefficient
from bearing_twin.contact.laws import HERTZIAN
from bearing_twin.contact.validity import wave_transit
from bearing_twin.kinds.beam.impact import (
    MOST_BYTES,
    MOST_MODES,
    Beam,
    BeamImpact,
    ImpactingSphere,
    beam_energy,
    deflection_shapes,
    first_frequency,
    hertz_contact_time,
    highest_mode,
    modes_of,
    rectangular_beam,
    solve_impact,
    static_deflection,
    stress_shapes,
)  # fmt: skip
from bearing_twin.kinds.beam.parameters import BEAM_THEORIES, EULER, TIMOSHENKO, Blow, SphereOnBeamScene
from bearing_twin.kinds.bodies.derived import homogeneous_mass, mass_of
from bearing_twin.kinds.bodies.figures import contact_rows
from bearing_twin.kinds.bodies.impact import Impact, ImpactMotion, peak_of
from bearing_twin.kinds.bodies.parameters import FEW_STEPS, FEWEST_STEPS
from bearing_twin.kinds.rules import BEAM, answers, odd_mass, sentences
from bearing_twin.kinds.sections import LOOSEST, STANDARD_GRAVITY, check_run, resolved_run

OUTPUTS, FEW_OUTPUTS = 1500, 50  # of a run whose output_rate is automatic; where peaks alone are requested
PERIODS = 3.0  # of the beam's first mode: the duration of a run when it is automatic
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


def sphere_of(parameters: SphereOnBeamScene) -> ImpactingSphere:
    """The sphere and its Hertz spring against the flat beam: f = (4/3) E* sqrt(R) alpha^1.5 (paper 2, eq. 1)."""
    sphere = parameters.sphere
    coefficient = float(sphere_coefficient("hertz", parameters.modulus, sphere.radius))
    return ImpactingSphere(mass_of(sphere), coefficient, parameters.blow.gravity)


def impact_speed(blow: Blow) -> float:
    """Speed [m/s] at the first touch."""
    return blow.speed or math.sqrt(2.0 * STANDARD_GRAVITY * blow.drop_height)


def check_beam(parameters: SphereOnBeamScene) -> list[str]:
    """Problems of the parameters of a sphere on a beam, as by `check_spheres`."""
    problems, blow, beam = [], parameters.blow, beam_of(parameters)
    if blow.speed and blow.drop_height:
        problems.append(
            f"blow.speed = {blow.speed:g} m/s and blow.drop_height = {blow.drop_height:g} m give the speed; keep one"
        )
    if impact_speed(blow) == 0.0:
        problems.append(
            "blow.speed and blow.drop_height are both 0, so the bodies never meet; give one of them above 0"
        )
    mass = mass_of(parameters.sphere)
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
    bend = impact_speed(blow) * math.sqrt(mass * float(static_deflection(beam, point, point)))
    if not problems and bend > GREATEST_BEND * beam.span:
        problems.append(
            f"the impact could bend the beam by {bend:.4g} m, too much of its span of {beam.span:g} m for small "
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
    """An error where the span is so long that not even the loosest tolerance is met."""
    if parameters.solver.modes or not (speed := impact_speed(parameters.blow)):
        return []
    theory = EULER if parameters.beam.theory == EULER else TIMOSHENKO
    tau = hertz_contact_time(sphere_of(parameters), speed)
    wanted = highest_mode(beam_of(parameters, theory), tau, LOOSEST)
    if wanted <= MOST_MODES:
        return []
    span = parameters.beam.span * MOST_MODES / wanted
    return [
        f"an impact of {tau:.3g} s on a span of {parameters.beam.span:g} m needs modes up to {wanted} even for "
        f"{100.0 * LOOSEST:g} %; at most {MOST_MODES}: shorten beam.span to {span:.2g} m or less (no wave comes "
        "back in time from supports so far away), or give solver.modes"
    ]


def resolve(parameters: SphereOnBeamScene) -> SphereOnBeamScene:
    """The parameters of a checked scene with the zeros of its run replaced."""
    whole = PERIODS * 2.0 * math.pi / first_frequency(beam_of(parameters))
    outputs = FEW_OUTPUTS if parameters.wanted.outputs == "peaks" else OUTPUTS
    whole += 4.0 * hertz_contact_time(sphere_of(parameters), impact_speed(parameters.blow))
    return dataclasses.replace(parameters, run=resolved_run(parameters.run, whole, outputs))


FINEST_TRIAL = 1e-4  # tolerance: what matters more is seen, and what matters less costs more than it tells
SHARE = 0.1  # of the tolerance, that a trial may be off
TRIAL_STEPS = 40  # a contact, good to 1e-5
INSTANTS = 400  # of a contact, at which forces are compared


class EulerErrors(NamedTuple):
    """Errors of Euler's beam against Timoshenko's for one scene.

    Duration [s] of the first contact, and how often a shear wave crosses the height in it; the relative errors of the
    first peak (signed), of the greatest force, of the time in contact and of the force over time (over the greatest);
    the greater number of contacts; the errors of figures in their units.
    """

    duration: float
    crossings: float
    first_peak: float
    peak: float
    time: float
    forces: float
    contacts: int
    figures: dict[str, float]

    def warnings(self, tolerance: float, contacts: int = 0) -> list[str]:
        """Reasons against Euler's beam; `contacts` are those of a run by it."""
        found, contacts = [], max(contacts, self.contacts)
        if abs(self.first_peak) > tolerance:
            found.append(
                f"the first contact of {self.duration:.3g} s is so short, {self.crossings:.3g} crossings of the height "
                f"by a shear wave, that Euler's first peak is {100.0 * abs(self.first_peak):.2g} % too "
                f"{'high' if self.first_peak > 0.0 else 'low'}"
            )
        elif self.time > tolerance:
            found.append(f"Euler's beam has the sphere in contact for a time {100.0 * self.time:.2g} % off")
        if contacts > 1:
            found.append(f"the sphere touches {contacts} times, and what follows a second touch needs shear")
        return found


@functools.lru_cache(maxsize=1)  # a motion may take megabytes
def impact_by_both_theories(parameters: SphereOnBeamScene) -> tuple[BeamImpact, ...]:
    """The impact of a checked scene on Euler's beam and on Timoshenko's, with few modes and steps."""
    sphere, speed, until = sphere_of(parameters), impact_speed(parameters.blow), resolve(parameters).run.duration
    tolerance, found = max(SHARE * parameters.wanted.tolerance, FINEST_TRIAL), []
    for theory in BEAM_THEORIES:
        line = beam_of(parameters, theory)
        count = min(highest_mode(line, hertz_contact_time(sphere, speed), tolerance), MOST_MODES)
        modes = modes_of(line, parameters.blow.point * line.span, count)
        with signal_flag():
            found.append(solve_impact(line, modes, sphere, speed, until, TRIAL_STEPS))
    return tuple(found)


@functools.lru_cache(maxsize=64)
def euler_errors(parameters: SphereOnBeamScene) -> EulerErrors:
    """Comparison of both theories for a checked scene; forces where Timoshenko's beam has contacts."""
    beam, material = parameters.beam, parameters.beam.material
    euler, shear = impact_by_both_theories(parameters)
    first, shear_modulus = shear.contacts[0], material.young_modulus / (2.0 * (1.0 + material.poisson_ratio))
    times = np.concatenate([np.linspace(one.start, one.start + one.duration, INSTANTS) for one in shear.contacts])
    figures = [_contact_figures(found, impact_speed(parameters.blow)) for found in (euler, shear)]
    return EulerErrors(
        first.duration,
        first.duration / wave_transit(beam.height, shear_modulus, material.density),
        euler.contacts[0].peak_force / first.peak_force - 1.0,
        abs(euler.peak_force / shear.peak_force - 1.0),
        abs(euler.contact_time / shear.contact_time - 1.0),
        float(np.abs(euler.at(times)[1] - shear.at(times)[1]).max()) / shear.peak_force,
        max(len(euler.contacts), len(shear.contacts)),
        {key: abs(figures[0][key] - figures[1][key]) for key in figures[0]},
    )


def _contact_figures(found: BeamImpact, speed: float) -> dict[str, float]:
    leaving = float(found.pieces.motions[-1, 1])
    return {
        "peak_force_n": found.peak_force,
        "contact_duration_s": found.contact_time,
        "greatest_approach_m": float(approaches_of_loads(found.sphere.coefficient, HERTZIAN, found.peak_force)),
        "contact_count": len(found.contacts),
        "restitution": -leaving / speed,
        "sphere_velocity_after_m_s": leaving,
        "impulse_ns": math.fsum(one.impulse for one in found.contacts),
    }


@functools.lru_cache(maxsize=64)
def euler_errors_of_beam(parameters: SphereOnBeamScene) -> tuple[float, ...]:
    """Errors of the greatest deflection [m] and stress [Pa] by Euler's beam: to find these costs more than contacts."""
    both = (WatchedPoints(parameters, found).greatest() for found in impact_by_both_theories(parameters))
    return tuple(abs(euler - shear) for euler, shear in zip(*both, strict=True))


def needs_shear(parameters: SphereOnBeamScene) -> bool:
    """True if anything speaks against Euler's beam in a checked scene."""
    return bool(euler_errors(parameters).warnings(parameters.wanted.tolerance))


def theory_of(parameters: SphereOnBeamScene) -> str:
    """The beam theory of a checked scene: the one it specifies, or Euler's where nothing speaks against it."""
    if parameters.beam.theory != "auto":
        return parameters.beam.theory
    return TIMOSHENKO if needs_shear(parameters) else EULER


LEAST_CHOSEN = 10  # steps a contact that are chosen
STEP_ORDER = 4.0  # errors of forces fall with this power of the steps
MODE_ORDERS = {
    (EULER, "contact"): 6.0,
    (TIMOSHENKO, "contact"): 3.0,
    (EULER, "outputs"): 3.0,
    (TIMOSHENKO, "outputs"): 1.0,
}
"""By theory and solver.static_tail: the power of the highest mode with which errors of forces fall (`highest_mode`)."""


def steps_required(tolerance: float, stepper: str, peaks: bool = False) -> int:
    """Steps a Hertz contact time that a relative error of the force, or of its `peaks`, wants.

    The error falls as steps^-4, that of hats as steps^-2.
    """
    if stepper == "volterra":
        return max(500, math.ceil(math.sqrt(7.0 / tolerance)))
    return max(LEAST_CHOSEN, math.ceil(((16.0 if peaks else 40.0) / tolerance) ** (1.0 / STEP_ORDER)))


def modes_required(parameters: SphereOnBeamScene) -> int:
    """Highest mode that the tolerance wants."""
    tau = hertz_contact_time(sphere_of(parameters), impact_speed(parameters.blow))
    beam, with_tail = beam_of(parameters, theory_of(parameters)), parameters.solver.static_tail == "contact"
    return highest_mode(beam, tau, parameters.wanted.tolerance, with_tail, parameters.wanted.outputs == "peaks")


def modes_for(parameters: SphereOnBeamScene) -> int:
    """Highest mode: specified, or from the tolerance, at most MOST_MODES."""
    return parameters.solver.modes or min(modes_required(parameters), MOST_MODES)


def steps_for(parameters: SphereOnBeamScene, stepper: str) -> int:
    """Steps a Hertz contact time: specified, or from the tolerance."""
    wanted = parameters.wanted
    return parameters.solver.steps or steps_required(wanted.tolerance, stepper, wanted.outputs == "peaks")


def steps_of(parameters: SphereOnBeamScene) -> int:
    """Steps a Hertz contact time of the scene's own method."""
    stepper = parameters.solver.stepper
    return steps_for(parameters, "modes" if stepper == "auto" else stepper)


def shear_share(parameters) -> float:
    """Deflection by shear over that by bending, of a load in the middle: 2.4 (1 + nu) (height / span)^2.

    12 E I / (k G A L^2) with k = 5/6 of a rectangle and I / A = height^2 / 12 (Timoshenko, Strength of Materials).
    """
    beam = parameters.beam
    return 2.4 * (1.0 + beam.material.poisson_ratio) * (beam.height / beam.span) ** 2


def first_peak_error(parameters) -> float:
    """Relative error of the first peak of force by Euler's beam against Timoshenko's."""
    return abs(euler_errors(parameters).first_peak)


VOLTERRA_STEPS = 500
"""Steps a contact below which the linear pieces of the Volterra equation are coarse."""
PEAK_SAMPLES = 4000  # instants at which deflection and stress are looked through for the greatest


def choose(parameters) -> Choice:
    """A sphere on a beam: its theory, method, modes and steps; raises SceneError for more than memory holds."""
    found, solver = answers(BEAM, parameters), parameters.solver
    warnings = odd_mass("sphere.mass", parameters.sphere.mass, homogeneous_mass(parameters.sphere))
    stepper, theory = found["solver.stepper"].value, found["beam.theory"].value
    modes, steps = found["solver.modes"].value, found["solver.steps"].value
    few = VOLTERRA_STEPS if stepper == "volterra" else FEW_STEPS
    if 0 < solver.steps < few:
        warnings.append(f"solver.steps = {steps} is coarse for {stepper}: contacts may come apart; use {few} or more")
    if stepper == "sinusoidal":
        warnings.append("the force is assumed, not solved for: the beam will receive more energy than the sphere has")
    if not solver.modes and (wanted := modes_required(parameters)) > modes:
        warnings.append(
            f"wanted.tolerance = {parameters.wanted.tolerance:g} needs modes up to {wanted}; {MOST_MODES} is the most, "
            "so the result is less exact"
        )
    held = 32.0 * steps * modes * (0.5 if parameters.blow.point == 0.5 else 1.0) * (2 if theory == TIMOSHENKO else 1)
    if held > MOST_BYTES:  # of the states of all modes at every step of a contact up to twice Hertz's
        raise SceneError(
            f"{steps} steps a contact with modes up to {modes} would hold {1e-9 * held:.3g} GB; at most "
            f"{1e-9 * MOST_BYTES:g} GB: lower solver.steps or solver.modes, or loosen wanted.tolerance"
        )
    return Choice("hertz", stepper, 0.0, f"hertz, the law of a sphere on a plane; {sentences(found)}", tuple(warnings))


TOGETHER = 500_000  # states of modes read off at once


def channels(parameters: SphereOnBeamScene) -> tuple[Channel, ...]:
    """Channels of a sample; the first of the observed points is the point of impact."""
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

    def greatest(self) -> list[float]:
        """Greatest deflection [m] and bending stress [Pa] by magnitude, of all observed points and the whole motion."""
        times, found = np.linspace(0.0, self._found.end, PEAK_SAMPLES), []
        for column, values in enumerate(self.at_points(times)):
            top, point = np.unravel_index(np.argmax(np.abs(values)), values.shape)
            near = np.linspace(times[max(top - 1, 0)], times[min(top + 1, len(times) - 1)], 101)
            found.append(peak_of(np.abs(self.at_points(near)[column][:, point])))
        return found

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
    deflection, stress = watch.greatest() if parameters.wanted.outputs == "history" else (math.nan, math.nan)
    deepest = [approaches_of_loads(found.sphere.coefficient, HERTZIAN, one.peak_force) for one in found.contacts]
    last = found.contacts[-1].start + found.contacts[-1].duration if found.contacts else 0.0
    records = {"contact": contact_rows(found.contacts, deepest, 0.0, 0.0)}
    known = [last, deflection, stress, _energy_gained(found, brought), found.end, found.gone, modes_for(parameters)]
    costs = {"steps": len(found.pieces.lengths), "modes": len(found.modes.index)}
    return Impact(watch, parameters.run, records | {"extremes": np.array([known], float)}, costs)


class BeamMotion(ImpactMotion):
    """The impact as a run that can be stopped: `stop` (1,)."""

    def __init__(self, parameters: SphereOnBeamScene, choice: Choice):
        self.stop = SIGNALLED
        super().__init__(lambda *scene: solve(*scene, self.stop), parameters, choice)


def _energy_gained(found, brought: float) -> float:
    """Energy [J] gained by the numbers over what the sphere brought; gravity's work is not a gain."""
    kinetic, stored, dissipated = found.energies()
    _, force, position, _ = found.at(np.array([found.end]))
    coefficient = found.sphere.coefficient
    contact = energies_at(coefficient, HERTZIAN, approaches_of_loads(coefficient, HERTZIAN, force[0]))
    fallen = found.sphere.mass * found.sphere.gravity * position[0]
    return float(kinetic + stored + dissipated + contact - fallen - brought)
