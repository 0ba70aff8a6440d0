"""A sphere thrown on a beam: contacts by either method, exact free flight between them, any number of contacts."""

import math
from dataclasses import dataclass

import numpy as np

from bearing_twin.base.errors import IntegrationError, Stopped
from bearing_twin.base.stopping import SIGNALLED
from bearing_twin.contact.hertz_impact import contact_time
from bearing_twin.kinds.beam import contact as beam_contact
from bearing_twin.kinds.beam import volterra
from bearing_twin.kinds.beam.contact import ThrownSphere
from bearing_twin.kinds.beam.free_flight import next_touch
from bearing_twin.kinds.beam.modes import TERMS, Beam, BeamModes, beam_energy, count_below, response_at
from bearing_twin.kinds.beam.parameters import BEAM, BODY
from bearing_twin.kinds.impact.collision import ContactPeriod
from bearing_twin.numerics.statuses import FULL, NO_END, NOT_FINITE, STALLED, TIME_UP, WORDS

FIRST_STEP = 1e-4  # of the regular contact: the force's start as time^1.5 is resolved from there
FEWEST_MODES, MOST_MODES = 5, 4000
ONSET = 1e-5  # tolerance below which the onset of the force, as time^1.5, rules errors
MOST_BYTES = 1e9  # of the modes' states that are held at once
GREATEST_CONTACTS = 1000
LONGEST_CONTACT = 200  # in Hertz contact times: a sphere 20 times as heavy as the beam stays for some 60
LONGEST_VOLTERRA = 20  # the same for the integral equation, whose cost grows as the square


@dataclass(frozen=True, eq=False)
class BeamImpact:
    """The whole motion in pieces within each of which the force is a cubic in time.

    `starts` (pieces + 1), `lengths`, `forces` (pieces, 4) in powers of the share of the piece, `states` (pieces + 1,
    modes) the modes' z and `motions` (pieces + 1, 2) the sphere's position and velocity at the starts, `works` [J]
    done on the beam. `gone` tells that no further contact can follow.
    """

    beam: Beam
    modes: BeamModes
    sphere: ThrownSphere
    starts: np.ndarray
    lengths: np.ndarray
    forces: np.ndarray
    states: np.ndarray
    motions: np.ndarray
    works: np.ndarray
    contacts: tuple[ContactPeriod, ...]
    gone: bool
    stop: np.ndarray

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
        return float(self.starts[-1])

    def at(self, times):
        """(states z (times, modes), force [N], sphere position [m], velocity [m/s]) at increasing times [s]."""
        times = np.asarray(times, float)
        states = np.empty((len(times), len(self.modes.rate)), np.complex128)
        force = np.empty(len(times))
        response_at(
            self.modes.rate, self.modes.shape, self.modes.modal_mass,
            self.starts[:-1], self.lengths, self.forces, self.states, times, states, force,
            self.stop,
        )  # fmt: skip
        _heed(self.stop)
        piece = np.clip(np.searchsorted(self.starts[:-1], times, side="right") - 1, 0, len(self.lengths) - 1)
        span, share = times - self.starts[piece], (times - self.starts[piece]) / self.lengths[piece]
        k = np.arange(TERMS)
        powers = self.forces[piece] * share[:, None] ** k
        position, velocity = self.motions[piece].T
        mass, gravity = self.sphere.mass, self.sphere.gravity
        moved = span**2 * (powers / ((k + 1) * (k + 2))).sum(axis=1) / mass
        slowed = span * (powers / (k + 1)).sum(axis=1) / mass
        return (
            states,
            np.maximum(force, 0.0),
            position + span * (velocity + 0.5 * gravity * span) - moved,
            velocity + gravity * span - slowed,
        )

    def coordinates(self, states) -> np.ndarray:
        """Modal coordinates q [m] of states z."""
        return np.imag(states) / np.imag(self.modes.rate)

    def energies(self) -> tuple[float, float, float]:
        """(sphere's kinetic, beam's, dissipated) energy [J] at the end; the beam's from its state, not the work."""
        kinetic = 0.5 * self.sphere.mass * float(self.motions[-1, 1]) ** 2
        stored = float(beam_energy(self.modes, self.states[-1], self.at([self.end])[1][0]))
        return kinetic, stored, float(self.works.sum()) - stored if self.beam.damping_ratio > 0.0 else 0.0


def hertz_contact_time(sphere: ThrownSphere, speed: float) -> float:
    """Contact time [s] on a beam that does not give: the scale of steps."""
    return contact_time(sphere.coefficient, sphere.mass, speed)


def highest_mode(beam: Beam, contact_time: float, tolerance: float, with_tail: bool = True, peaks: bool = False) -> int:
    """The highest mode that a relative error of the force wants, for a Hertz contact time tau [s].

    With the static tail in the contact the error of the force is below 14 (omega_N tau)^-2.5 and below
    (omega_N tau / 20)^-3.5, omega_N being the highest slow mode's; that of its peak and of the contact's time (`peaks`)
    is less than that. Without the tail it is below 150 (omega_N tau)^-1.5 by Euler, that is, modes^-3, and
    10 / (omega_N tau) by Timoshenko. Measured on short, long, off-centre and repeated impacts, with a margin of 3.
    """
    if with_tail and tolerance >= ONSET:
        wanted = min(((10.0 if peaks else 14.0) / tolerance) ** 0.4, 20.0 * tolerance ** (-1.0 / 3.5))
    elif with_tail:
        wanted = 20.0 * tolerance ** (-1.0 / 3.5)
    else:
        wanted = (150.0 / tolerance) ** (2.0 / 3.0) if math.isinf(beam.shear_rigidity) else 10.0 / tolerance
    return max(math.ceil(count_below(beam, wanted / contact_time)), FEWEST_MODES) | 1


def throw(beam, modes, sphere, speed, until, steps, method="modes", with_tail=True, stop=SIGNALLED) -> BeamImpact:
    """The impact of a sphere that touches the beam at rest at time 0 with `speed` [m/s], until `until` [s].

    `steps` a Hertz contact time; `method` of BEAM_METHODS ("sinusoidal" assumes the force and shows what that breaks).
    Raises IntegrationError when a state is not finite, Newton's method stalls or contacts do not end, Stopped soon
    after `stop` (1,) is not 0.
    """
    if method == "sinusoidal":
        return assume_half_sine(beam, modes, sphere, speed, until, steps, stop)
    modes = modes if with_tail else modes._replace(tail=0.0)
    regular = hertz_contact_time(sphere, speed)
    room = int(steps * min(until / regular, LONGEST_CONTACT)) + 1000
    room = min(room, int(MOST_BYTES / (16 * len(modes.rate))))
    march = _marcher(method, modes, sphere, regular, steps, until, room, stop)
    parts, contacts, gone = [], [], False
    pieces, first = _room(room, len(modes.rate)), 0
    pieces[4][0] = 0.0, speed
    while True:
        last, status = march(pieces, first)
        time = float(pieces[0][last])
        _heed(stop)
        _refuse(status, time)
        contact = _contact(pieces, first, last)
        if contact.impulse > 0.0:
            contacts.append(contact)
        if status == TIME_UP or time >= until:
            parts.append(_part(pieces, last))
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
        flight = next_touch(
            modes.rate, modes.shape, pieces[3][last], sphere, *pieces[4][last], until - time, 1e-9 * regular, stop
        )
        _heed(stop)
        gone = math.isinf(flight)
        last = _fly(modes, sphere, pieces, last, min(flight, until - time))
        parts.append(_part(pieces, last))
        if gone or time + flight >= until:
            break
        _begin_again(pieces, last)
    ends = (pieces[0], *(array[:0] for array in pieces[1:3]), *pieces[3:5], pieces[5][:0])
    parts.append(tuple(array[last : last + 1] for array in ends))
    return BeamImpact(beam, modes, sphere, *map(np.concatenate, zip(*parts, strict=True)), tuple(contacts), gone, stop)


def _marcher(method, modes, sphere, regular, steps, until, room, stop):
    """The function (pieces, first) -> (last, status) that marches one contact by the method."""
    common, length = (modes.rate, modes.shape, modes.modal_mass, modes.tail, sphere), regular / steps
    if method == "volterra":
        count = min(int(LONGEST_VOLTERRA * steps), room)
        weights = volterra.kernel_weights(modes.rate, modes.shape, modes.modal_mass, sphere.mass, length, count, stop)
        return lambda pieces, first: volterra.march_volterra(*common, length, weights, until, pieces, first, stop)
    shortest, step = min(FIRST_STEP * regular, length), beam_contact.new_step(len(modes.rate))
    return lambda pieces, first: beam_contact.march(*common, shortest, length, until, step, pieces, first, stop)


def assume_half_sine(beam, modes, sphere, speed, until, steps, stop) -> BeamImpact:
    """Paper 2's abstract: the force is a half sine over the Hertz contact time, and reverses the sphere's motion.

    Nothing makes that force fit the beam's motion, so energy is not conserved: the beam receives several times what
    the sphere brought. Kept to be charted, not to be used.
    """
    duration = hertz_contact_time(sphere, speed)
    peak = math.pi * sphere.mass * speed / duration
    count = max(8, int(steps))
    pieces = _room(count + 2, len(modes.rate))
    pieces[4][0] = 0.0, speed
    step = beam_contact.new_step(len(modes.rate))
    beam_contact.prepare(modes.rate, modes.shape, modes.modal_mass, sphere, duration / count, step)
    for piece in range(count):
        step.force[:] = peak * np.sin(math.pi * (piece + np.array(beam_contact.POINTS)) / count)
        beam_contact.finish_step(sphere, duration / count, step, pieces, piece)
    contact = _contact(pieces, 0, count)._replace(peak_force=peak)
    last = _fly(modes, sphere, pieces, count, max(until - duration, 1e-9 * duration))
    starts, lengths, forces, states, motions, works = pieces
    return BeamImpact(
        beam, modes, sphere, starts[: last + 1], lengths[:last], forces[:last], states[: last + 1],
        motions[: last + 1], np.zeros_like(works[:last]), (contact,), True, stop,
    )  # fmt: skip


def _heed(stop) -> None:
    if stop[0] != 0:
        raise Stopped("the computation of the impact was stopped")


def _room(count, modes):
    return (
        np.zeros(count),
        np.zeros(count),
        np.zeros((count, TERMS)),
        np.zeros((count, modes), np.complex128),
        np.zeros((count, 2)),
        np.zeros(count),
    )


def _part(pieces, last):
    return tuple(array[:last].copy() for array in pieces)


def _begin_again(pieces, last):
    """The same room, beginning where the piece `last` would."""
    for array in (pieces[0], pieces[3], pieces[4]):
        array[0] = array[last]


def _fly(modes, sphere, pieces, piece, span):
    """One piece without force; returns the next piece's number."""
    starts, lengths, forces, states, motions, works = pieces
    starts[piece + 1], lengths[piece] = starts[piece] + span, span
    forces[piece], works[piece] = 0.0, 0.0
    states[piece + 1] = np.exp(modes.rate * span) * states[piece]
    position, velocity = motions[piece]
    motions[piece + 1] = position + span * (velocity + 0.5 * sphere.gravity * span), velocity + sphere.gravity * span
    return piece + 1


def _contact(pieces, first, last) -> ContactPeriod:
    starts, lengths, forces = pieces[0], pieces[1][first:last], pieces[2][first:last]
    impulse = float((lengths[:, None] * forces / np.arange(1, TERMS + 1)).sum())
    return ContactPeriod(
        float(starts[first]), float(starts[last] - starts[first]), _peak(starts[first:], forces), impulse
    )


def _peak(starts, forces) -> float:
    """Greatest force: of the cubics, or of the parabola through three values where pieces are linear."""
    if not len(forces):
        return 0.0
    if not forces[:, 2:].any():
        top = int(np.argmax(forces[:, 0]))
        if not 0 < top < len(forces) - 1:
            return float(forces[top, 0])
        time, value = starts[top - 1 : top + 2] - starts[top], forces[top - 1 : top + 2, 0]
        bend, slope, level = np.polyfit(time / time[2], value, 2)
        return float(level - 0.25 * slope**2 / bend)
    u = np.linspace(0.0, 1.0, 9)
    values = forces @ np.vander(u, TERMS, increasing=True).T
    best = float(values.max())
    for cubic in forces[np.argsort(values.max(axis=1))[-3:]]:
        roots = np.roots([3.0 * cubic[3], 2.0 * cubic[2], cubic[1]])
        inside = [float(r.real) for r in roots if abs(r.imag) < 1e-12 and 0.0 < r.real < 1.0]
        best = max([best, *(float(np.polyval(cubic[::-1], r)) for r in inside)])
    return best


def _refuse(status, time):
    reasons = {
        FULL: "the contact does not end; the sphere is too heavy for this beam, or use solver.stepper: modes",
        NOT_FINITE: "the contact force is not finite; check the scene's numbers",
        STALLED: "Newton's method for the contact force stalls; raise solver.steps",
    }
    if status in reasons:
        sentence, reason = f"after {time:.6g} s {reasons[status]}", WORDS.get(status, NO_END)
        raise IntegrationError(sentence, reason, time, BODY, BEAM)
