"""A simply supported Euler-Bernoulli beam under a force at one point, mode by mode and exactly in time.

Deflection w(x, t) = sum_n sin(n pi x / l) q_n(t), positive in the direction of the force, with the modal mass
M = (mass) / 2 for every mode, omega_n = n^2 omega_1 and one damping ratio (paper 2, eq. 8; its kernel lacks the
sin^2(n pi x_c / l) that is 1 only at mid-span):

    q'' + 2 zeta omega q' + omega^2 q = f(t) sin(n pi x_c / l) / M.

Each mode is one complex number z = q' - conj(lambda) q with lambda = omega (-zeta + i sqrt(1 - zeta^2)); then
z' = lambda z + f phi / M and q = Im z / Im lambda. A force that is a polynomial in time is propagated without error.

Modes the sum leaves out still bend the beam statically: `static_tail` and `stress_tail` are what is missing of the
static influence functions. During a contact the stress, whose sum falls only as n^-2, needs it.

Breaks: shear and rotary inertia are left out, so modes with wavelengths of a few heights are too fast; deflections
must be small against the span.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import kernel

TERMS = 4  # coefficients of a cubic force
NEGLIGIBLE = 1e-12  # a mode with a smaller shape at the force is never moved


class Beam(NamedTuple):
    """The beam as numbers (SI): `rigidity` = E I, `half_height` from the neutral fibre to the stressed one."""

    span: float
    mass: float
    rigidity: float
    half_height: float
    area_moment: float
    damping_ratio: float


class Modes(NamedTuple):
    """The modes a force at one `point` [m] moves: index, lambda [1/s], frequency omega [rad/s] and shape at the point.

    `tail` [m/N] is the static compliance at the point of all higher modes, `modal_mass` [kg].
    """

    point: float
    index: np.ndarray
    rate: np.ndarray
    omega: np.ndarray
    shape: np.ndarray
    modal_mass: float
    tail: float


def rectangular_beam(span, width, height, young_modulus, density, damping_ratio=0.0) -> Beam:
    """A beam of rectangular section; `height` is measured along the force."""
    moment = width * height**3 / 12.0
    mass = density * width * height * span
    return Beam(span, mass, young_modulus * moment, 0.5 * height, moment, damping_ratio)


def first_frequency(beam: Beam) -> float:
    """omega_1 [rad/s] = (pi / l)^2 sqrt(E I / (mass per length))."""
    return (math.pi / beam.span) ** 2 * math.sqrt(beam.rigidity * beam.span / beam.mass)


def modes_of(beam: Beam, point: float, count: int) -> Modes:
    """The modes 1 .. `count` that a force at `point` [m] from a support moves; the others are left out."""
    index = np.arange(1, count + 1)
    shape = shapes(index, beam, point)
    index, shape = index[np.abs(shape) > NEGLIGIBLE], shape[np.abs(shape) > NEGLIGIBLE]
    omega = index**2 * first_frequency(beam)
    zeta = beam.damping_ratio
    rate = omega * complex(-zeta, math.sqrt(1.0 - zeta**2))
    tail = static_deflection(beam, point, point) - np.sum(shape**2 / omega**2) / (0.5 * beam.mass)
    return Modes(point, index, rate, omega, shape, 0.5 * beam.mass, max(float(tail), 0.0))


def shapes(index, beam: Beam, points) -> np.ndarray:
    """sin(n pi x / l), shape (*points, modes); the argument is reduced first so that nodes are zeros."""
    share = np.asarray(points, float)[..., None] * index / beam.span
    return np.sin(math.pi * np.remainder(share, 2.0)) * (np.abs(share - np.round(share)) > 1e-13)


def static_deflection(beam: Beam, point, load_point):
    """Deflection [m/N] at `point` under a steady unit force at `load_point`."""
    near, far = np.minimum(point, load_point), beam.span - np.maximum(point, load_point)
    return near * far * (beam.span**2 - near**2 - far**2) / (6.0 * beam.span * beam.rigidity)


def static_stress(beam: Beam, point, load_point):
    """Bending stress [Pa/N] of the fibre away from the force at `point` under a steady unit force at `load_point`."""
    near, far = np.minimum(point, load_point), beam.span - np.maximum(point, load_point)
    return near * far / beam.span * beam.half_height / beam.area_moment


def deflection_shapes(beam: Beam, modes: Modes, points):
    """Deflection [m] at points = first result @ q + second result * force: modal shapes, and the static tail."""
    shape = shapes(modes.index, beam, points)
    flexibility = modes.shape / (modes.omega**2 * modes.modal_mass)
    return shape, static_deflection(beam, np.asarray(points, float), modes.point) - shape @ flexibility


def stress_shapes(beam: Beam, modes: Modes, points):
    """As `deflection_shapes`, for the bending stress [Pa], positive in the fibre away from the force (tension)."""
    shape = shapes(modes.index, beam, points)
    curvature = (modes.index * math.pi / beam.span) ** 2 * beam.rigidity * beam.half_height / beam.area_moment
    stress = shape * curvature
    flexibility = modes.shape / (modes.omega**2 * modes.modal_mass)
    return stress, static_stress(beam, np.asarray(points, float), modes.point) - stress @ flexibility


def beam_energy(modes: Modes, state) -> np.ndarray:
    """Kinetic and elastic energy [J] of the modes; `state` is z with the modes along its last axis."""
    q = np.imag(state) / np.imag(modes.rate)
    rate = np.real(state) + np.real(modes.rate) * q
    return 0.5 * modes.modal_mass * np.sum(rate**2 + (modes.omega * q) ** 2, axis=-1)


@kernel
def moments(z, out):
    """out[k] = integral of exp(z (1 - u)) u^k over u = 0 .. 1, k < TERMS: what a force u^k leaves in a mode.

    The recurrence J_k = (k J_(k-1) - 1) / z loses digits for small z; the series k! z^m / (m + k + 1)! takes over.
    """
    if abs(z.real) + abs(z.imag) > 5.0:
        out[0] = (np.exp(z) - 1.0) / z
        for k in range(1, TERMS):
            out[k] = (k * out[k - 1] - 1.0) / z
        return
    for k in range(TERMS):
        term = 1.0 / (k + 1) + 0.0j
        total = term
        for m in range(1, 60):
            term = term * z / (m + k + 1)
            total += term
            if abs(term.real) + abs(term.imag) < 1e-18:
                break
        out[k] = total


@kernel
def propagate(rate, shape, modal_mass, step, share, force, start, out):
    """State z of all modes `share` of `step` [s] after `start`, under force[0] + force[1] u + ... , u = time / step."""
    moment = np.empty(TERMS, np.complex128)
    span = share * step
    for n in range(len(rate)):
        z = rate[n] * span
        moments(z, moment)
        pushed = 0.0j
        power = 1.0
        for k in range(TERMS):
            pushed += force[k] * power * moment[k]
            power *= share
        out[n] = np.exp(z) * start[n] + shape[n] / modal_mass * span * pushed


@kernel
def response_at(rate, shape, modal_mass, starts, steps, forces, states, times, out, force):
    """States z (times, modes) and force [N] at increasing `times`, from pieces with their start time, length and cubic.

    `states[k]` is z at the start of piece k; times before the first or after the last piece are not asked for.
    """
    piece = 0
    for i in range(len(times)):
        while piece + 1 < len(starts) and times[i] >= starts[piece + 1]:
            piece += 1
        share = (times[i] - starts[piece]) / steps[piece]
        propagate(rate, shape, modal_mass, steps[piece], share, forces[piece], states[piece], out[i])
        f = forces[piece]
        force[i] = f[0] + share * (f[1] + share * (f[2] + share * f[3]))
