"""Impact of a sphere on a beam: contacts by either method, exact free flight between them, any number of contacts.

The compiled core (`core/beam`) moves sphere and modes: `modes` solves the modal equations with the Hertz spring by
collocation, `volterra` eq. (9) of paper 2 by product integration (`core/beam/impact.cpp`).
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import IntegrationError, Stopped
from bearing_twin.base.stopping import SIGNALLED
from bearing_twin.contact.hertz_impact import contact_time
from bearing_twin.core import FLAG, INTEGER, INTEGERS_OUT, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.beam.parameters import BEAM, BODY
from bearing_twin.kinds.bodies.impact import ContactPeriod, peak_of
from bearing_twin.methods import FULL, NO_END, NOT_FINITE, STALLED, TIME_UP, WORDS

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
    """The modes of n = 1 .. `count` that a force at `point` [m] from a support moves; the others are left out."""
    index = np.arange(1, count + 1)
    index, omega, weight, turn = branches(beam, index[np.abs(shapes(index, beam, point)) > NEGLIGIBLE])
    shape, zeta = weight * shapes(index, beam, point), beam.damping_ratio
    rate = omega * complex(-zeta, math.sqrt(1.0 - zeta**2))
    tail = static_deflection(beam, point, point) - np.sum(shape**2 / omega**2) / (0.5 * beam.mass)
    return BeamModes(point, index, rate, omega, shape, weight, turn, 0.5 * beam.mass, max(float(tail), 0.0))


def shapes(index, beam: Beam, points) -> np.ndarray:
    """sin(n pi x / l), shape (*points, modes); the argument is reduced first so that nodes are zeros."""
    share = np.asarray(points, float)[..., None] * index / beam.span
    return np.sin(math.pi * np.remainder(share, 2.0)) * (np.abs(share - np.round(share)) > 1e-13)


def static_deflection(beam: Beam, point, load_point):
    """Deflection [m/N] at `point` under a steady unit force at `load_point`."""
    near, far = np.minimum(point, load_point), beam.span - np.maximum(point, load_point)
    bent = (beam.span**2 - near**2 - far**2) / (6.0 * beam.rigidity)
    return near * far / beam.span * (bent + 1.0 / beam.shear_rigidity)


def static_stress(beam: Beam, point, load_point):
    """Bending stress [Pa/N] of the fibre away from the force at `point` under a steady unit force at `load_point`."""
    near, far = np.minimum(point, load_point), beam.span - np.maximum(point, load_point)
    return near * far / beam.span * beam.half_height / beam.area_moment


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
FEWEST_MODES, MOST_MODES = 5, 4000
MOST_BYTES = 1e9  # of the modes' states that are held at once
GREATEST_CONTACTS = 1000
LONGEST_CONTACT = 200  # in Hertz contact times: a sphere 20 times as heavy as the beam stays for some 60
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
        return Pieces(*(one[: pieces + ends.get(name, 0)] for name, one in self._asdict().items()))


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
    def peak_force(self) -> float:
        """Greatest force [N] of all contacts, 0 without one."""
        return max((contact.peak_force for contact in self.contacts), default=0.0)

    @property
    def contact_time(self) -> float:
        """Time [s] in contact."""
        return math.fsum(contact.duration for contact in self.contacts)

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


def highest_mode(beam: Beam, contact_time: float, tolerance: float, with_tail: bool = True, peaks: bool = False) -> int:
    """The highest mode that a relative error of the force wants, for a Hertz contact time tau [s].

    With the static tail in the contact the error of the force is below 300 (omega_N tau)^-3, omega_N being the highest
    slow mode's, as of a force that begins as time^1.5; that of its peak and of the contact's time (`peaks`) is below a
    third of that. Without the tail it is below 150 (omega_N tau)^-1.5 by Euler, that is, modes^-3, and
    10 / (omega_N tau) by Timoshenko. Measured on short, long, off-centre and repeated impacts.
    """
    if with_tail:
        wanted = ((100.0 if peaks else 300.0) / tolerance) ** (1.0 / 3.0)
    else:
        wanted = (150.0 / tolerance) ** (2.0 / 3.0) if math.isinf(beam.shear_rigidity) else 10.0 / tolerance
    return max(math.ceil(count_below(beam, wanted / contact_time)), FEWEST_MODES) | 1


def solve_impact(
    beam, modes, sphere, speed, until, steps, method="modes", with_tail=True, stop=SIGNALLED
) -> BeamImpact:
    """The impact of a sphere that touches the beam at rest at time 0 with `speed` [m/s], until `until` [s].

    `steps` a Hertz contact time; `method` of BEAM_METHODS ("sinusoidal" assumes the force and shows what that breaks).
    Raises IntegrationError when a state is not finite, Newton's method stalls or contacts do not end, Stopped soon
    after `stop` (1,) is not 0.
    """
    if method == "sinusoidal":
        return assume_half_sine(beam, modes, sphere, speed, until, steps, stop)
    modes = modes if with_tail else modes._replace(tail=0.0)
    bodies, regular = _Bodies(modes, sphere, stop), hertz_contact_time(sphere, speed)
    room = int(steps * min(until / regular, LONGEST_CONTACT)) + 1000
    room = min(room, int(MOST_BYTES / (16 * len(modes.rate))))
    pieces, longest = Pieces.of(room, len(modes.rate)), regular / steps
    pieces.motions[0] = 0.0, speed
    how = int(method == "volterra"), min(FIRST_STEP * regular, longest), longest
    contacts, gone, piece, time, reached = [], False, 0, 0.0, np.zeros(1, np.int64)
    while time < until and not gone:
        if len(pieces.lengths) - piece < room:
            known, pieces = pieces, Pieces.of(2 * piece + room, len(modes.rate))
            for array, before in zip(pieces, known, strict=True):
                array[: piece + 1] = before[: piece + 1]
        reached[0] = piece
        status = bodies.call(_contact, pieces, *how, reached, until=until)
        first, piece = piece, int(reached[0])
        time = float(pieces.starts[piece])
        _refuse(status, time)
        if _impulse(pieces, first, piece) > 0.0:
            contacts.append((first, piece))
        if status == TIME_UP or time >= until:
            break
        if len(contacts) >= GREATEST_CONTACTS:
            raise IntegrationError(
                f"the sphere has touched the beam {GREATEST_CONTACTS} times by {time:.6g} s and still bounces; "
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
    found = BeamImpact(beam, modes, sphere, pieces.whole(piece), (), gone, stop)
    return replace(found, contacts=tuple(_contact_period(found, *one) for one in contacts))


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


def _contact_period(found: BeamImpact, first: int, end: int) -> ContactPeriod:
    starts = found.pieces.starts
    top = first + int(np.argmax(found.pieces.forces[first:end, 0]))
    near = np.linspace(starts[max(top - 1, first)], starts[top + 1], PEAK_INSTANTS)
    peak = peak_of(found.at(near)[1])
    return ContactPeriod(
        float(starts[first]), float(starts[end] - starts[first]), peak, _impulse(found.pieces, first, end)
    )


def _refuse(status, time):
    reasons = {
        FULL: "the contact does not end; the sphere is too heavy for this beam, or use solver.stepper: modes",
        NOT_FINITE: "the contact force is not finite; check the scene's numbers",
        STALLED: "Newton's method for the contact force stalls; raise solver.steps",
    }
    if status in reasons:
        sentence, reason = f"after {time:.6g} s {reasons[status]}", WORDS.get(status, NO_END)
        raise IntegrationError(sentence, reason, time, BODY, BEAM)
