"""From the keys of a sphere on a beam to numbers: beam, sphere, theory, modes and steps; what is impossible among them.

Euler's beam responds at once everywhere across its height; a shear wave needs height / sqrt(G / rho) for that.
The shorter the contact against this time, and the heavier the sphere against the beam, the further Euler's first peak
is off; whatever follows a second contact depends on waves that are too fast in Euler's beam. Which theory holds for an
impact is found by solving it with both.
"""

import dataclasses
import functools
import math
from typing import NamedTuple

from bearing_twin.base.errors import SceneError
from bearing_twin.base.report import Choice
from bearing_twin.base.stopping import heeding_signals
from bearing_twin.contact.elasticity import sphere_coefficient
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.contact.validity import wave_transit
from bearing_twin.kinds.beam.impact import (
    MOST_BYTES,
    MOST_MODES,
    ONSET,
    BeamImpact,
    ImpactingSphere,
    hertz_contact_time,
    highest_mode,
    solve_impact,
)  # fmt: skip
from bearing_twin.kinds.beam.modes import Beam, first_frequency, modes_of, rectangular_beam, static_deflection
from bearing_twin.kinds.beam.parameters import BEAM_THEORIES, EULER, TIMOSHENKO, Blow, SphereOnBeamScene
from bearing_twin.kinds.impact.collision import FEW_STEPS, FEWEST_STEPS
from bearing_twin.kinds.impact.derived import homogeneous_mass, sphere_mass
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
    modulus = effective_modulus(sphere.material, parameters.beam.material)
    coefficient = float(sphere_coefficient("hertz", modulus, sphere.radius))
    return ImpactingSphere(sphere_mass(sphere), coefficient, parameters.blow.gravity)


def impact_speed(blow: Blow) -> float:
    """Speed [m/s] at the first touch."""
    return blow.speed or math.sqrt(2.0 * STANDARD_GRAVITY * blow.drop_height)


def check_beam(parameters: SphereOnBeamScene) -> list[str]:
    """As `check_spheres`, for a sphere on a beam."""
    problems, blow, beam = [], parameters.blow, beam_of(parameters)
    if blow.speed and blow.drop_height:
        problems.append(
            f"blow.speed = {blow.speed:g} m/s and blow.drop_height = {blow.drop_height:g} m give the speed; keep one"
        )
    if impact_speed(blow) == 0.0:
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


class BothTheories(NamedTuple):
    """The impact by both theories.

    First contact [s], how often a shear wave crosses the height in it, how far off Euler's first peak is (relative,
    signed), the greater number of contacts, and how far off Euler's greatest force and time in contact are (relative).
    """

    duration: float
    crossings: float
    error: float
    contacts: int
    of_peak: float
    of_time: float

    def warnings(self, tolerance: float) -> list[str]:
        """Reasons against Euler's beam."""
        found = []
        if abs(self.error) > tolerance:
            found.append(
                f"the first contact of {self.duration:.3g} s is so short, {self.across}, that Euler's first peak is "
                f"{100.0 * abs(self.error):.2g} % too {'high' if self.error > 0.0 else 'low'}"
            )
        elif self.of_time > tolerance:
            found.append(f"Euler's beam has the sphere in contact for a time {100.0 * self.of_time:.2g} % off")
        if self.contacts > 1:
            found.append(f"the sphere touches {self.contacts} times, and what follows a second touch needs shear")
        return found

    @property
    def across(self) -> str:
        """The crossings in words."""
        return f"{self.crossings:.3g} crossings of the height by a shear wave"


@functools.lru_cache(maxsize=1)  # a motion may take megabytes
def impact_by_both_theories(parameters: SphereOnBeamScene) -> tuple[BeamImpact, ...]:
    """The impact of a checked scene on Euler's beam and on Timoshenko's, with few modes and steps."""
    sphere, speed, until = sphere_of(parameters), impact_speed(parameters.blow), resolve(parameters).run.duration
    tolerance, found = max(SHARE * parameters.wanted.tolerance, FINEST_TRIAL), []
    for theory in BEAM_THEORIES:
        line = beam_of(parameters, theory)
        count = min(highest_mode(line, hertz_contact_time(sphere, speed), tolerance), MOST_MODES)
        modes = modes_of(line, parameters.blow.point * line.span, count)
        with heeding_signals():
            found.append(solve_impact(line, modes, sphere, speed, until, TRIAL_STEPS))
    return tuple(found)


@functools.lru_cache(maxsize=64)
def trial(parameters: SphereOnBeamScene) -> BothTheories:
    """Comparison of both theories for a checked scene."""
    beam, material = parameters.beam, parameters.beam.material
    by_euler, by_timoshenko = impact_by_both_theories(parameters)
    shear_modulus = material.young_modulus / (2.0 * (1.0 + material.poisson_ratio))
    first = by_timoshenko.contacts[0]
    return BothTheories(
        first.duration,
        first.duration / wave_transit(beam.height, shear_modulus, material.density),
        by_euler.contacts[0].peak_force / first.peak_force - 1.0,
        max(len(by_euler.contacts), len(by_timoshenko.contacts)),
        abs(by_euler.peak_force / by_timoshenko.peak_force - 1.0),
        abs(by_euler.contact_time / by_timoshenko.contact_time - 1.0),
    )


def needs_shear(parameters: SphereOnBeamScene) -> bool:
    """True if anything speaks against Euler's beam in a checked scene."""
    return bool(trial(parameters).warnings(parameters.wanted.tolerance))


def theory_of(parameters: SphereOnBeamScene) -> str:
    """The beam theory of a checked scene: the one it specifies, or Euler's where nothing speaks against it."""
    if parameters.beam.theory != "auto":
        return parameters.beam.theory
    return TIMOSHENKO if needs_shear(parameters) else EULER


def euler_warning(parameters: SphereOnBeamScene, contacts: int) -> str | None:
    """What speaks against Euler's beam in a run that took it and had that many contacts."""
    if not contacts or theory_of(parameters) != EULER:
        return None
    found = trial(parameters)
    reasons = found._replace(contacts=max(contacts, found.contacts)).warnings(parameters.wanted.tolerance)
    return f"{'; '.join(reasons)}: give beam.theory: timoshenko" if reasons else None


LEAST_CHOSEN = 10  # steps a contact that are chosen


def steps_required(tolerance: float, stepper: str, peaks: bool = False) -> int:
    """Steps a Hertz contact time that a relative error of the force, or of its `peaks`, wants.

    The error falls as steps^-4 until the onset of the force, as time^1.5, is what is left; then steps^-6 is that of
    times and peaks. Hats converge as steps^-2.
    """
    if stepper == "volterra":
        return max(500, math.ceil(math.sqrt(7.0 / tolerance)))
    if tolerance < ONSET:
        return math.ceil(15.0 * tolerance ** (-1.0 / 6.0))
    return max(LEAST_CHOSEN, math.ceil(((16.0 if peaks else 40.0) / tolerance) ** 0.25))


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


def states_held(steps: int, modes: int) -> float:
    """Bytes of the states of all modes at every step of a contact up to twice Hertz's."""
    return 2 * steps * modes * 16.0


def shear_share(parameters) -> float:
    """Deflection by shear over that by bending, of a load in the middle: 2.4 (1 + nu) (height / span)^2.

    12 E I / (k G A L^2) with k = 5/6 of a rectangle and I / A = height^2 / 12 (Timoshenko, Strength of Materials).
    """
    beam = parameters.beam
    return 2.4 * (1.0 + beam.material.poisson_ratio) * (beam.height / beam.span) ** 2


def first_peak_error(parameters) -> float:
    """Relative error of the first peak of force by Euler's beam against Timoshenko's."""
    return abs(trial(parameters).error)


VOLTERRA_STEPS = 500
"""Steps a contact below which the linear pieces of the Volterra equation are coarse."""
SECONDS = {"step": 8e-8, "instant": 6e-8}
"""Of one mode, on one core of a 2.x GHz x86-64 machine: a step of the contact, and an instant that is read off."""
PEAK_SAMPLES = 4000  # instants at which deflection and stress are looked through for the greatest
COPIES = 3  # of the states of a contact: room, part, whole
LONG = 5.0  # seconds of computing that are announced


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
    moved = 0.5 if parameters.blow.point == 0.5 else 1.0
    warnings += _cost(parameters, round(modes * moved * (2 if theory == TIMOSHENKO else 1)), steps)
    return Choice("hertz", stepper, 0.0, f"hertz, the law of a sphere on a plane; {sentences(found)}", tuple(warnings))


def _cost(parameters, modes, steps) -> list[str]:
    """The cost of a long run, announced before it; `modes` are all that move."""
    held = states_held(steps, modes)
    if held > MOST_BYTES:
        raise SceneError(
            f"{steps} steps a contact with {modes} modes would hold {1e-9 * held:.3g} GB; at most "
            f"{1e-9 * MOST_BYTES:g} GB: lower solver.steps or solver.modes, or loosen wanted.tolerance"
        )
    run, history = parameters.run, parameters.wanted.outputs == "history"
    instants = run.duration * run.output_rate + PEAK_SAMPLES * history
    seconds = modes * (SECONDS["step"] * steps + SECONDS["instant"] * instants)
    if seconds <= LONG:
        return []
    return [
        f"{modes} modes, {steps} steps a contact and {instants:.3g} instants take about {seconds:.2g} s and "
        f"up to {1e-6 * COPIES * held:.2g} MB: loosen wanted.tolerance, "
        "shorten beam.span or run.duration, or give wanted.outputs: peaks"
    ]
