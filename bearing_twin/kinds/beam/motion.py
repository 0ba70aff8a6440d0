"""A sphere strikes a simply supported beam: paper 2.

    alpha = s - w(x_c),  f = c alpha^1.5                                                     (1), (5)
    s(t) = v t + g t^2 / 2 - (1/m) * integral of f(u) (t - u) du                               (6)
    w(x, t) = sum_n (1/M) sin(n pi x / l) sin(n pi x_c / l) * integral of f(u) sin(omega_n (t - u)) / omega_n du   (8)

s is the sphere's travel, w the deflection, M half the beam's mass; the modes are Euler's, as in the paper, or
Timoshenko's. The compiled core moves sphere and modes (`core/beam/impact.cpp`): `modes` solves the modal equations with
the Hertz spring by collocation, `volterra` eq. (9) itself by product integration; both go through any number of
contacts, with exact free flight between them. `sinusoidal` assumes the force of the paper's abstract; its
energy balance fails and the run says so.

Gravity acts on the sphere after the first touch when `blow.gravity` is set; the beam is measured from its rest under
its own weight. Bending stress is that of the fibre away from the sphere, tension positive.
"""

import dataclasses
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import IntegrationError, SceneError, Stopped
from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Channel
from bearing_twin.base.stopping import SIGNALLED
from bearing_twin.contact.elasticity import approaches_of_loads, energies_at, sphere_coefficient
from bearing_twin.contact.hertz_impact import contact_time
from bearing_twin.contact.laws import HERTZIAN
from bearing_twin.core import FLAG, INTEGER, INTEGERS_OUT, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.beam.parameters import BEAM, BODY, EULER, TIMOSHENKO, Blow, SphereOnBeamScene
from bearing_twin.kinds.bodies.derived import homogeneous_mass, mass_of
from bearing_twin.kinds.bodies.figures import contact_rows
from bearing_twin.kinds.bodies.impact import ContactPeriod, Impact, ImpactMotion, peak_of
from bearing_twin.kinds.bodies.parameters import FEW_STEPS, FEWEST_STEPS
from bearing_twin.kinds.rules import BEAM as KIND
from bearing_twin.kinds.rules import answers, odd_mass, sentences
from bearing_twin.kinds.sections import LOOSEST, STANDARD_GRAVITY, check_run, resolved_run
from bearing_twin.methods import FULL, NO_END, NOT_FINITE, REASONS, STALLED, TIME_UP

NEGLIGIBLE = 1e-12  # a mode with a smaller shape at the force is never moved


class Beam(NamedTuple):
    """The beam as numbers (SI): `rigidity` = E I, `half_height` from the neutral fibre to the stressed one.

    `shear_rigidity` [N] = K G A and `rotary_inertia` [kg m] = rho I; infinite and 0 are Euler's beam.
    """

    span: float
    mass: float
    rigidity: float
    half_height: float
    area_moment: float
    damping_ratio: float
    shear_rigidity: float = math.inf
    rotary_inertia: float = 0.0


class BeamModes(NamedTuple):
    """The modes a force at one `point` [m] moves: index, lambda [1/s], frequency omega [rad/s] and shape at the point.

    `weight` is w_n, `turn` [1/m] the section's angle psi where the beam sinks by sin(k x). `tail` [m/N] is the static
    compliance at the point of all higher modes, `modal_mass` [kg].
    """

    point: float
    index: np.ndarray
    rate: np.ndarray
    omega: np.ndarray
    shape: np.ndarray
    weight: np.ndarray
    turn: np.ndarray
    modal_mass: float
    tail: float


def rectangular_beam(span, width, height, young_modulus, density, damping_ratio=0.0, poisson_ratio=None) -> Beam:
    """A beam of rectangular section; `height` is measured along the force.

    A Poisson ratio nu makes it Timoshenko's, with K = 10 (1 + nu) / (12 + 11 nu) (Cowper, J. Appl. Mech. 33, 1966).
    """
    area, moment = width * height, width * height**3 / 12.0
    beam = Beam(span, density * area * span, young_modulus * moment, 0.5 * height, moment, damping_ratio)
    if poisson_ratio is None:
        return beam
    share = 10.0 * (1.0 + poisson_ratio) / (12.0 + 11.0 * poisson_ratio)
    shear = share * young_modulus / (2.0 * (1.0 + poisson_ratio)) * area
    return beam._replace(shear_rigidity=shear, rotary_inertia=density * moment)


def first_frequency(beam: Beam) -> float:
    """omega_1 [rad/s] = (pi / l)^2 sqrt(E I / (mass per length)) of Euler's beam."""
    return (math.pi / beam.span) ** 2 * math.sqrt(beam.rigidity * beam.span / beam.mass)


def count_below(beam: Beam, omega: float) -> float:
    """Number of (slow) modes up to `omega` [rad/s], not rounded."""
    inertia, shear = beam.mass / beam.span, beam.shear_rigidity
    if math.isinf(shear):
        return math.sqrt(omega / first_frequency(beam))
    middle = omega**2 * (inertia / shear + beam.rotary_inertia / beam.rigidity)
    rest = inertia * omega**2 * (beam.rotary_inertia * omega**2 / shear - 1.0) / beam.rigidity
    return beam.span / math.pi * math.sqrt(0.5 * (middle + math.sqrt(middle**2 - 4.0 * rest)))


def branches(beam: Beam, index):
    """(index, omega [rad/s], weight, turn [1/m]) of the modes of these n: Euler's, or slow and fast ones in turn."""
    k = np.asarray(index) * math.pi / beam.span
    if math.isinf(beam.shear_rigidity):
        return index, index**2 * first_frequency(beam), np.ones(len(k)), k
    inertia, shear, bending = beam.mass / beam.span, beam.shear_rigidity, beam.rigidity * k**2
    middle = inertia * (bending + shear) + beam.rotary_inertia * shear * k**2
    product = inertia * beam.rotary_inertia
    upper = middle + np.sqrt(middle**2 - 4.0 * product * shear * bending * k**2)
    slow, fast = 2.0 * shear * bending * k**2 / upper, upper / (2.0 * product)  # omega^2 without cancellation
    turn = np.concatenate(
        [shear * k / (bending + shear - beam.rotary_inertia * slow), k - inertia * fast / (shear * k)]
    )
    weight = np.sqrt(inertia / (inertia + beam.rotary_inertia * turn**2))
    return np.tile(index, 2), np.sqrt(np.concatenate([slow, fast])), weight, turn


def modes_of(beam: Beam, point: float, count: int) -> BeamModes:
    """The modes of n = 1 .. `count` that a force at `point` [m] from a support excites; the others are omitted."""
    index = np.arange(1, count + 1)
    index, omega, weight, turn = branches(beam, index[np.abs(shapes(index, beam, point)) > NEGLIGIBLE])
    shape, zeta = weight * shapes(index, beam, point), beam.damping_ratio
    rate = omega * complex(-zeta, math.sqrt(1.0 - zeta**2))
    tail = static_deflection(beam, point, point) - np.sum(shape**2 / omega**2) / (0.5 * beam.mass)
    return BeamModes(point, index, rate, omega, shape, weight, turn, 0.5 * beam.mass, max(float(tail), 0.0))


def shapes(index, beam: Beam, points) -> np.ndarray:
    """sin(n pi x / l), shape (*points, modes); the argument is reduced first so that nodes are zeros."""
    waves = np.asarray(points, float)[..., None] * index / beam.span
    return np.sin(math.pi * np.remainder(waves, 2.0)) * (np.abs(waves - np.round(waves)) > 1e-13)


def static_deflection(beam: Beam, point, load_point):
    """Deflection [m/N] at `point` under a steady unit force at `load_point`."""
    left, right = np.minimum(point, load_point), beam.span - np.maximum(point, load_point)
    bending = (beam.span**2 - left**2 - right**2) / (6.0 * beam.rigidity)
    return left * right / beam.span * (bending + 1.0 / beam.shear_rigidity)


def static_stress(beam: Beam, point, load_point):
    """Bending stress [Pa/N] of the fibre away from the force at `point` under a steady unit force at `load_point`."""
    left, right = np.minimum(point, load_point), beam.span - np.maximum(point, load_point)
    return left * right / beam.span * beam.half_height / beam.area_moment


def deflection_shapes(beam: Beam, modes: BeamModes, points):
    """Deflection [m] at points = first result @ q + second result * force: modal shapes, and the static tail."""
    shape = modes.weight * shapes(modes.index, beam, points)
    flexibility = modes.shape / (modes.omega**2 * modes.modal_mass)
    return shape, static_deflection(beam, np.asarray(points, float), modes.point) - shape @ flexibility


def stress_shapes(beam: Beam, modes: BeamModes, points):
    """Bending stress [Pa], as `deflection_shapes`; positive in the fibre away from the force (tension)."""
    curvature = modes.weight * modes.turn * modes.index * math.pi / beam.span
    stress = shapes(modes.index, beam, points) * curvature * beam.rigidity * beam.half_height / beam.area_moment
    flexibility = modes.shape / (modes.omega**2 * modes.modal_mass)
    return stress, static_stress(beam, np.asarray(points, float), modes.point) - stress @ flexibility


def beam_energy(modes: BeamModes, state, force=0.0) -> np.ndarray:
    """Kinetic and elastic energy [J] of modes and tail; `state` is z, modes along its last axis, `force` in N."""
    q = np.imag(state) / np.imag(modes.rate)
    rate = np.real(state) + np.real(modes.rate) * q
    moving = modes.modal_mass * np.sum(rate**2 + (modes.omega * q) ** 2, axis=-1)
    return 0.5 * (moving + modes.tail * np.square(force))


FIRST_STEP = 1e-4  # of the regular contact: the force's start as time^1.5 is resolved from there
FEWEST_MODES, MAX_MODES = 5, 4000
MAX_BYTES = 1e9  # of the modes' states that are held at once
MAX_CONTACTS = 1000
TERMS = 4  # coefficients of a cubic force
PEAK_INSTANTS = 17  # around the greatest force of a contact

_IMPACT = (INTEGER, REALS, REALS, REALS, FLAG, INTEGER, *[REALS_OUT] * 6)
_contact = Function("core_beam_contact", INTEGER, (*_IMPACT, INTEGER, REAL, REAL, INTEGERS_OUT))
_move = Function("core_beam_move", None, (*_IMPACT, INTEGER, INTEGER))
_next_touch = Function("core_beam_next_touch", REAL, (*_IMPACT, INTEGER, REAL, REAL))
_response = Function("core_beam_response", None, (*_IMPACT, INTEGER, REALS, REALS_OUT, REALS_OUT))


class ImpactingSphere(NamedTuple):
    """The sphere and its Hertz spring: `mass` [kg], `coefficient` [N/m^1.5], `gravity` [m/s^2] along its motion."""

    mass: float
    coefficient: float
    gravity: float


class Pieces(NamedTuple):
    """A motion in pieces of time, within each of which the force is a cubic.

    `starts` [s], `lengths` [s], `forces` (pieces, 4) [N] in powers of the share of the piece, `states` (pieces, modes)
    the modes' z and `motions` (pieces, 2) the sphere's position [m] and velocity [m/s] at the starts, `works` [J] done
    on the beam.
    """

    starts: np.ndarray
    lengths: np.ndarray
    forces: np.ndarray
    states: np.ndarray
    motions: np.ndarray
    works: np.ndarray

    @classmethod
    def of(cls, count: int, modes: int) -> "Pieces":
        """Room for that many pieces, the first of which starts at rest at time 0."""
        return cls(
            np.zeros(count), np.zeros(count), np.zeros((count, TERMS)), np.zeros((count, modes), np.complex128),
            np.zeros((count, 2)), np.zeros(count),
        )  # fmt: skip

    def whole(self, pieces: int) -> "Pieces":
        """So many pieces; starts, states and motions have one row more, that of the end."""
        ends = {"starts": 1, "states": 1, "motions": 1}
        return Pieces(*(array[: pieces + ends.get(name, 0)] for name, array in self._asdict().items()))


class _Bodies(NamedTuple):
    """Modes of a beam, a sphere, and the flag (1,) that is not 0 once the computation is to stop."""

    modes: BeamModes
    sphere: ImpactingSphere
    stop: np.ndarray

    def call(self, function: Function, pieces: Pieces, *arguments, until: float = math.inf):
        """The result of a function of the core on pieces, whose arrays it writes."""
        modes, sphere = self.modes, self.sphere
        numbers = np.array([modes.modal_mass, modes.tail, *sphere, until])
        starts, lengths, forces, states, motions, works = pieces
        result = function(
            len(modes.rate), modes.rate.view(float), modes.shape, numbers, self.stop, len(lengths),
            starts, lengths, forces, states.view(float), motions, works, *arguments,
        )  # fmt: skip
        if self.stop[0] != 0:
            raise Stopped("the computation of the impact was stopped")
        return result


@dataclass(frozen=True, eq=False)
class BeamImpact:
    """The whole motion in `pieces`, whose starts, states and motions have one row more, that of the end.

    `gone` is true where no further contact can follow, `assumed` where the force is not that of the approach.
    """

    beam: Beam
    modes: BeamModes
    sphere: ImpactingSphere
    pieces: Pieces
    contacts: tuple[ContactPeriod, ...]
    gone: bool
    stop: np.ndarray
    assumed: bool = False

    @property
    def end(self) -> float:
        """Time [s] to which the motion is known."""
        return float(self.pieces.starts[-1])

    def at(self, times):
        """(states z (times, modes), force [N], sphere position [m], velocity [m/s]) at increasing times [s].

        The force is Hertz's at the approach of sphere and beam: where a contact begins or ends, as time^1.5, the cubic
        of a step is less accurate by far.
        """
        times = np.ascontiguousarray(times, float)
        states = np.empty((len(times), len(self.modes.rate)), np.complex128)
        sphere = np.empty((len(times), 3))
        _Bodies(self.modes, self.sphere, self.stop).call(
            _response, self.pieces, len(times), times, states.view(float), sphere
        )
        force, position, velocity = sphere.T
        if not self.assumed:
            beam = self.coordinates(states) @ self.modes.shape + self.modes.tail * force
            force = np.where(force > 0.0, self.sphere.coefficient * np.maximum(position - beam, 0.0) ** 1.5, 0.0)
        return states, np.maximum(force, 0.0), position, velocity

    def coordinates(self, states) -> np.ndarray:
        """Modal coordinates q [m] of states z."""
        return np.imag(states) / np.imag(self.modes.rate)

    def energies(self) -> tuple[float, float, float]:
        """(sphere's kinetic, beam's, dissipated) energy [J] at the end; the beam's from its state, not the work."""
        kinetic = 0.5 * self.sphere.mass * float(self.pieces.motions[-1, 1]) ** 2
        stored = float(beam_energy(self.modes, self.pieces.states[-1], self.at([self.end])[1][0]))
        work = float(self.pieces.works.sum())
        return kinetic, stored, work - stored if self.beam.damping_ratio > 0.0 else 0.0


def hertz_contact_time(sphere: ImpactingSphere, speed: float) -> float:
    """Contact time [s] on a beam that does not give: the scale of steps."""
    return contact_time(sphere.coefficient, sphere.mass, speed)


def highest_mode(beam: Beam, contact_time: float, tolerance: float, peaks: bool = False) -> int:
    """The highest mode for a relative error of the force, by the Hertz contact time tau [s].

    The error of the force is below 300 (omega_N tau)^-3, omega_N being the highest slow mode's, as of a force that
    begins as time^1.5; that of its peak and of the contact's time (`peaks`) is below a third of that. Measured on
    short, long, off-centre and repeated impacts.
    """
    phase = ((100.0 if peaks else 300.0) / tolerance) ** (1.0 / 3.0)
    return max(math.ceil(count_below(beam, phase / contact_time)), FEWEST_MODES) | 1


def solve_impact(beam, modes, sphere, speed, until, steps, method="modes", stop=SIGNALLED) -> BeamImpact:
    """The impact of a sphere that touches the beam at rest at time 0 with `speed` [m/s], until `until` [s].

    `steps` a Hertz contact time; `method` of BEAM_METHODS ("sinusoidal" assumes the force and shows what that breaks).
    Raises IntegrationError when a state is not finite, Newton's method stalls or contacts do not end, Stopped soon
    after `stop` (1,) is not 0.
    """
    if method == "sinusoidal":
        return assume_half_sine(beam, modes, sphere, speed, until, steps, stop)
    bodies, regular = _Bodies(modes, sphere, stop), hertz_contact_time(sphere, speed)
    capacity = int(min(steps * until / regular + 1000, MAX_BYTES / (16 * len(modes.rate))))
    pieces, longest = Pieces.of(capacity, len(modes.rate)), regular / steps
    pieces.motions[0] = 0.0, speed
    steps_of_method = int(method == "volterra"), min(FIRST_STEP * regular, longest), longest
    contacts, gone, piece, time, reached = [], False, 0, 0.0, np.zeros(1, np.int64)
    while time < until and not gone:
        if len(pieces.lengths) - piece < capacity:
            full, pieces = pieces, Pieces.of(2 * piece + capacity, len(modes.rate))
            for array, filled in zip(pieces, full, strict=True):
                array[: piece + 1] = filled[: piece + 1]
        reached[0] = piece
        status = bodies.call(_contact, pieces, *steps_of_method, reached, until=until)
        first, piece = piece, int(reached[0])
        time = float(pieces.starts[piece])
        _refuse(status, time)
        if _impulse(pieces, first, piece) > 0.0:
            contacts.append((first, piece))
        if status == TIME_UP or time >= until:
            break
        if len(contacts) >= MAX_CONTACTS:
            raise IntegrationError(
                f"the sphere has touched the beam {MAX_CONTACTS} times by {time:.6g} s and still bounces; "
                "shorten run.duration or raise beam.damping_ratio",
                NO_END,
                time,
                BODY,
                BEAM,
            )
        flight = bodies.call(_next_touch, pieces, piece, until - time, 1e-9 * regular)
        gone = math.isinf(flight)
        pieces.lengths[piece], pieces.forces[piece] = min(flight, until - time), 0.0
        bodies.call(_move, pieces, piece, piece + 1)
        piece, time = piece + 1, time + flight
    impact = BeamImpact(beam, modes, sphere, pieces.whole(piece), (), gone, stop)
    return dataclasses.replace(
        impact, contacts=tuple(_contact_period(impact, *pieces_of_contact) for pieces_of_contact in contacts)
    )


def assume_half_sine(beam, modes, sphere, speed, until, steps, stop) -> BeamImpact:
    """Paper 2's abstract: the force is a half sine over the Hertz contact time, and reverses the sphere's motion.

    Nothing makes that force fit the beam's motion, so energy is not conserved: the beam receives several times what
    the sphere brought. Kept to be charted, not to be used.
    """
    duration, count = hertz_contact_time(sphere, speed), max(8, int(steps))
    peak = math.pi * sphere.mass * speed / duration
    points = np.array([0.0, 0.5 - 0.1 * math.sqrt(5.0), 0.5 + 0.1 * math.sqrt(5.0), 1.0])  # of Gauss and Lobatto
    values = peak * np.sin(math.pi * (np.arange(count)[:, None] + points) / count)
    pieces = Pieces.of(count + 2, len(modes.rate))
    pieces.motions[0] = 0.0, speed
    pieces.lengths[:count], pieces.lengths[count] = duration / count, max(until - duration, 1e-9 * duration)
    pieces.forces[:count] = np.linalg.solve(np.vander(points, increasing=True), values.T).T
    _Bodies(modes, sphere, stop).call(_move, pieces, 0, count + 1)
    pieces.works[:] = 0.0
    contact = ContactPeriod(0.0, duration, peak, _impulse(pieces, 0, count))
    return BeamImpact(beam, modes, sphere, pieces.whole(count + 1), (contact,), True, stop, assumed=True)


def _impulse(pieces: Pieces, first: int, end: int) -> float:
    """Impulse [N s] of the force over the pieces from `first` to before `end`."""
    return float((pieces.lengths[first:end, None] * pieces.forces[first:end] / np.arange(1, TERMS + 1)).sum())


def _contact_period(impact: BeamImpact, first: int, end: int) -> ContactPeriod:
    starts = impact.pieces.starts
    top = first + int(np.argmax(impact.pieces.forces[first:end, 0]))
    instants = np.linspace(starts[max(top - 1, first)], starts[top + 1], PEAK_INSTANTS)
    peak = peak_of(impact.at(instants)[1])
    return ContactPeriod(
        float(starts[first]), float(starts[end] - starts[first]), peak, _impulse(impact.pieces, first, end)
    )


def _refuse(status, time):
    reasons = {
        FULL: "the contact lasts longer than memory holds steps of; shorten run.duration or lower solver.steps",
        NOT_FINITE: "the contact force is not finite; check the scene's numbers",
        STALLED: "Newton's method for the contact force stalls; raise solver.steps",
    }
    if status in reasons:
        sentence, reason = f"after {time:.6g} s {reasons[status]}", REASONS.get(status, NO_END)
        raise IntegrationError(sentence, reason, time, BODY, BEAM)


# The scene

OUTPUTS, FEW_OUTPUTS = 1500, 50  # of a run whose output_rate is automatic; where peaks alone are requested
PERIODS = 3.0  # of the beam's first mode: the duration of a run when it is automatic
MAX_MASS_RATIO = 20.0  # sphere mass / beam mass
FEWEST = dict.fromkeys(("auto", "modes"), 2)
"""Least steps a contact of methods other than FEWEST_STEPS: with 2 the error of modes is 6 %, in three contacts."""
MAX_DEFLECTION = 0.1  # deflection / span: beyond it the beam's own length change carries load


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
    if mass > MAX_MASS_RATIO * beam.mass:
        problems.append(
            f"the sphere of {mass:.4g} kg is heavier than the model allows on a beam of {beam.mass:.4g} kg; "
            f"its mass must be at most {MAX_MASS_RATIO:g} times the beam's: lower sphere.radius or sphere.mass"
        )
    problems += _too_many_modes(parameters)
    if parameters.beam.height > beam.span / 3.0:
        problems.append(
            f"beam.height = {parameters.beam.height:g} m makes a block of a span of {beam.span:g} m; "
            f"a beam needs a height of at most {beam.span / 3.0:.4g} m"
        )
    point = blow.point * beam.span
    deflection = impact_speed(blow) * math.sqrt(mass * float(static_deflection(beam, point, point)))
    if not problems and deflection > MAX_DEFLECTION * beam.span:
        problems.append(
            f"the impact could bend the beam by {deflection:.4g} m, too much of its span of {beam.span:g} m for small "
            f"deflections; it must stay below {MAX_DEFLECTION * beam.span:.4g} m: lower the speed or stiffen the beam"
        )
    steps, minimum = parameters.solver.steps, FEWEST.get(parameters.solver.stepper, FEWEST_STEPS)
    if 0 < steps < minimum:
        problems.append(
            f"solver.steps = {steps} is too few: a contact needs at least {minimum} steps or it falls apart into "
            f"false ones; use {FEW_STEPS} or more, or 0"
        )
    return problems + check_run(parameters.run)


def _too_many_modes(parameters) -> list[str]:
    """An error where the span is so long that not even the loosest tolerance is met."""
    if parameters.solver.modes or not (speed := impact_speed(parameters.blow)):
        return []
    tau = hertz_contact_time(sphere_of(parameters), speed)
    required = highest_mode(beam_of(parameters, theory_of(parameters)), tau, LOOSEST)
    if required <= MAX_MODES:
        return []
    span = parameters.beam.span * MAX_MODES / required
    return [
        f"an impact of {tau:.3g} s on a span of {parameters.beam.span:g} m needs modes up to {required} even for "
        f"{100.0 * LOOSEST:g} %; at most {MAX_MODES}: shorten beam.span to {span:.2g} m or less (no wave comes "
        "back in time from supports so far away), or give solver.modes"
    ]


def resolve(parameters: SphereOnBeamScene) -> SphereOnBeamScene:
    """The parameters of a checked scene with the zeros of its run replaced."""
    duration = PERIODS * 2.0 * math.pi / first_frequency(beam_of(parameters))
    outputs = FEW_OUTPUTS if parameters.wanted.outputs == "peaks" else OUTPUTS
    duration += 4.0 * hertz_contact_time(sphere_of(parameters), impact_speed(parameters.blow))
    return dataclasses.replace(parameters, run=resolved_run(parameters.run, duration, outputs))


def theory_of(parameters: SphereOnBeamScene) -> str:
    """The beam theory of a scene: Euler's where it is specified."""
    return EULER if parameters.beam.theory == EULER else TIMOSHENKO


MIN_STEPS = 10  # steps a contact that are chosen
STEP_ORDER = 4.0  # errors of forces fall with this power of the steps
MODE_ORDERS = {EULER: 6.0, TIMOSHENKO: 3.0}
"""By theory: the power of the highest mode with which errors of forces fall (`highest_mode`)."""


def steps_required(tolerance: float, stepper: str, peaks: bool = False) -> int:
    """Steps a Hertz contact time for a relative error of the force, or of its `peaks`.

    The error falls as steps^-4, that of hats as steps^-2.
    """
    if stepper == "volterra":
        return max(500, math.ceil(math.sqrt(7.0 / tolerance)))
    return max(MIN_STEPS, math.ceil(((16.0 if peaks else 40.0) / tolerance) ** (1.0 / STEP_ORDER)))


def modes_required(parameters: SphereOnBeamScene) -> int:
    """Highest mode for the requested tolerance."""
    tau = hertz_contact_time(sphere_of(parameters), impact_speed(parameters.blow))
    beam, peaks = beam_of(parameters, theory_of(parameters)), parameters.wanted.outputs == "peaks"
    return highest_mode(beam, tau, parameters.wanted.tolerance, peaks)


def modes_for(parameters: SphereOnBeamScene) -> int:
    """Highest mode: specified, or from the tolerance, at most MAX_MODES."""
    return parameters.solver.modes or min(modes_required(parameters), MAX_MODES)


def steps_for(parameters: SphereOnBeamScene, stepper: str) -> int:
    """Steps a Hertz contact time: specified, or from the tolerance."""
    request = parameters.wanted
    return parameters.solver.steps or steps_required(request.tolerance, stepper, request.outputs == "peaks")


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


VOLTERRA_STEPS = 500
"""Steps a contact below which the linear pieces of the Volterra equation are coarse."""
SCAN_RATE, MAX_SCAN = 20.0, 1e7
"""Instants a Hertz contact time at which deflection and stress are scanned for the greatest; times modes, at most."""


def choose(parameters) -> Choice:
    """A sphere on a beam: its theory, method, modes and steps; raises SceneError for more than memory holds."""
    choices, solver = answers(KIND, parameters), parameters.solver
    warnings = odd_mass("sphere.mass", parameters.sphere.mass, homogeneous_mass(parameters.sphere))
    stepper, theory = choices["solver.stepper"].value, choices["beam.theory"].value
    modes, steps = choices["solver.modes"].value, choices["solver.steps"].value
    coarse = VOLTERRA_STEPS if stepper == "volterra" else FEW_STEPS
    if 0 < solver.steps < coarse:
        warnings.append(
            f"solver.steps = {steps} is coarse for {stepper}: contacts may come apart; use {coarse} or more"
        )
    if stepper == "sinusoidal":
        warnings.append("the force is assumed, not solved for: the beam will receive more energy than the sphere has")
    if not solver.modes and (required := modes_required(parameters)) > modes:
        warnings.append(
            f"wanted.tolerance = {parameters.wanted.tolerance:g} needs modes up to {required}; {MAX_MODES} is the "
            "most, so the result is less exact"
        )
    memory = 32.0 * steps * modes * (0.5 if parameters.blow.point == 0.5 else 1.0) * (2 if theory == TIMOSHENKO else 1)
    if memory > MAX_BYTES:  # of the states of all modes at every step of a contact up to twice Hertz's
        raise SceneError(
            f"{steps} steps a contact with modes up to {modes} would hold {1e-9 * memory:.3g} GB; at most "
            f"{1e-9 * MAX_BYTES:g} GB: lower solver.steps or solver.modes, or loosen wanted.tolerance"
        )
    return Choice(
        "hertz", stepper, 0.0, f"hertz, the law of a sphere on a plane; {sentences(choices)}", tuple(warnings)
    )


ROWS_AT_ONCE = 10_000  # states of modes evaluated at once, which fit into the cache


def channels(parameters: SphereOnBeamScene) -> tuple[Channel, ...]:
    """Channels of a sample; the first of the observed points is the point of impact."""
    points, stations = 1 + len(parameters.outputs.points), parameters.outputs.stations
    return (
        Channel("approach", "m", (), "mutual approach of sphere and beam; negative = gap"),
        Channel("normal_load", "N", (), "contact force, down on the beam and up on the sphere"),
        Channel("sphere_position", "m", (), "travel of the sphere's centre along its motion since the first contact"),
        Channel("sphere_velocity", "m/s", (), "of the sphere's centre along its motion before the impact"),
        Channel(
            "deflection",
            "m",
            (points,),
            "of the beam along the sphere's motion, at the impact point and outputs.points",
            ("watched",),
        ),
        Channel(
            "bending_stress",
            "Pa",
            (points,),
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

    def __init__(self, parameters: SphereOnBeamScene, impact: BeamImpact):
        self._impact, beam, modes = impact, impact.beam, impact.modes
        scale = hertz_contact_time(impact.sphere, impact_speed(parameters.blow))
        self._scanned = math.ceil(min(SCAN_RATE * impact.end / scale, MAX_SCAN / len(modes.index))) + 1
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
        times, maxima = np.linspace(0.0, self._impact.end, self._scanned), []
        for column, values in enumerate(self.at_points(times)):
            row, point = np.unravel_index(np.argmax(np.abs(values)), values.shape)
            instants = np.linspace(times[max(row - 1, 0)], times[min(row + 1, len(times) - 1)], 201)
            maxima.append(peak_of(np.abs(self.at_points(instants)[column][:, point])))
        return maxima

    def _in_blocks(self, times, function):
        """`function` of (states, force, position, velocity), so many times at once that memory stays small."""
        times = np.minimum(np.asarray(times, float), self._impact.end)
        rows = max(1, ROWS_AT_ONCE // len(self._impact.modes.index))
        parts = [function(*self._impact.at(times[row : row + rows])) for row in range(0, len(times), rows)]
        return tuple(np.concatenate(column) for column in zip(*parts, strict=True))

    def _bending(self, states, force, *_):
        q = self._impact.coordinates(states)
        return tuple(q @ modal.T + force[:, None] * static for modal, static in (self._deflection, self._stress))

    def _channels(self, states, force, position, velocity):
        impact, (deflection, stress) = self._impact, self._bending(states, force)
        contact = approaches_of_loads(impact.sphere.coefficient, HERTZIAN, force)
        return (
            np.where(force > 0.0, contact, position - deflection[:, 0]),
            force,
            position,
            velocity,
            deflection,
            stress,
            impact.coordinates(states) @ self._shape[0].T + force[:, None] * self._shape[1],
            0.5 * impact.sphere.mass * velocity**2,
            beam_energy(impact.modes, states, force),
            energies_at(impact.sphere.coefficient, HERTZIAN, contact),
        )


def solve(parameters: SphereOnBeamScene, law: str = "hertz", stepper: str = "modes", stop=SIGNALLED) -> Impact:
    """The impact by `modes`, `volterra` or `sinusoidal`.

    Raises IntegrationError where it fails, and Stopped, also when outputs are evaluated, soon after `stop` is not 0.
    """
    parameters = resolve(parameters)
    beam, sphere = beam_of(parameters, theory_of(parameters)), sphere_of(parameters)
    speed, steps = impact_speed(parameters.blow), steps_for(parameters, stepper)
    modes = modes_of(beam, parameters.blow.point * beam.span, modes_for(parameters))
    impact = solve_impact(beam, modes, sphere, speed, parameters.run.duration, steps, stepper, stop)
    watch = WatchedPoints(parameters, impact)
    # What is greatest in the beam costs more than all contacts: not computed where contacts alone are requested.
    deflection, stress = watch.greatest() if parameters.wanted.outputs == "history" else (math.nan, math.nan)
    deepest = [approaches_of_loads(sphere.coefficient, HERTZIAN, contact.peak_force) for contact in impact.contacts]
    last = impact.contacts[-1].start + impact.contacts[-1].duration if impact.contacts else 0.0
    records = {"contact": contact_rows(impact.contacts, deepest, 0.0, 0.0)}
    gained = _energy_gained(impact, 0.5 * sphere.mass * speed**2)
    extremes = [last, deflection, stress, gained, impact.end, impact.gone, modes_for(parameters)]
    costs = {"steps": len(impact.pieces.lengths), "modes": len(modes.index)}
    return Impact(watch, parameters.run, records | {"extremes": np.array([extremes], float)}, costs)


class BeamMotion(ImpactMotion):
    """The impact as a run that can be stopped: `stop` (1,)."""

    def __init__(self, parameters: SphereOnBeamScene, choice: Choice):
        self.stop = SIGNALLED
        super().__init__(lambda *scene: solve(*scene, self.stop), parameters, choice)


def _energy_gained(impact, initial: float) -> float:
    """Energy [J] gained by the method over what the sphere brought; gravity's work is not a gain."""
    kinetic, stored, dissipated = impact.energies()
    _, force, position, _ = impact.at(np.array([impact.end]))
    coefficient = impact.sphere.coefficient
    contact = energies_at(coefficient, HERTZIAN, approaches_of_loads(coefficient, HERTZIAN, force[0]))
    fallen = impact.sphere.mass * impact.sphere.gravity * position[0]
    return float(kinetic + stored + dissipated + contact - fallen - initial)
