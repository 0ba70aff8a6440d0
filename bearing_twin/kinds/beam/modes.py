"""A simply supported beam under a force at one point, mode by mode and exactly in time: Euler's or Timoshenko's.

Deflection w(x, t) = sum_n w_n sin(n pi x / l) q_n(t), positive in the direction of the force, with the modal mass
M = (mass) / 2 for every mode and one damping ratio (paper 2, eq. 8; its kernel lacks the sin^2(n pi x_c / l) that is 1
only at mid-span):

    q'' + 2 zeta omega q' + omega^2 q = f(t) w_n sin(n pi x_c / l) / M.

Euler and Bernoulli: omega_n = n^2 omega_1, w_n = 1. Timoshenko (Philosophical Magazine 41, 1921) adds shear and rotary
inertia: the section turns by psi cos(k x) where the beam sinks by sin(k x), k = n pi / l, and each n has two modes,

    (K G A k^2 - rho A omega^2) (E I k^2 + K G A - rho I omega^2) = (K G A k)^2,

slow ones that bend and, for high n, shear, and fast ones that turn the section. w_n^2 = rho A / (rho A + rho I psi^2)
is the share of the translation in the inertia of a mode; the two of an n make up 1.

Each mode is one complex number z = q' - conj(lambda) q with lambda = omega (-zeta + i sqrt(1 - zeta^2)); then
z' = lambda z + f w_n sin(n pi x_c / l) / M and q = Im z / Im lambda. A force that is a polynomial in time is propagated
without error (`core/beam/modes.hpp`).

Modes the sum leaves out still bend the beam statically: the tails are what is missing of the static influence
functions. The stress, whose sum falls only as n^-2, needs it, and so does a deflection with shear.

Breaks: Euler's modes with wavelengths of a few heights are too fast, Timoshenko's hold down to a height or two;
deflections must be small against the span.
"""

import math
from typing import NamedTuple

import numpy as np

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
    """How many n have a (slow) mode up to `omega` [rad/s], not rounded."""
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
    """As `deflection_shapes`, for the bending stress [Pa], positive in the fibre away from the force (tension)."""
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
