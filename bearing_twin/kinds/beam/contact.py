"""A sphere on a beam while they touch: modes and a Hertz spring, by collocation with exact modal propagation.

Within a step the force is the cubic through its values at the four Gauss-Lobatto points; every mode answers such a
force exactly (`beam.propagate`), so the step follows the duration of the contact, not the highest mode, which would set
that of an explicit method. The values
obey  f = c alpha^1.5,  alpha = s - w(x_c) - tail f  (paper 2, eqs. 1 and 5) and are found by Newton's method.

The force starts and ends as (time)^1.5, so steps double from a short first one and halve again towards separation,
where the last step is fitted to alpha = 0.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.elastic import HERTZIAN, approach_of_load, elastic
from bearing_twin.kinds.beam.modes import TERMS, moments
from bearing_twin.numerics.events import halved
from bearing_twin.numerics.statuses import FULL, NOT_FINITE, SEPARATED, STALLED, STOPPED, TIME_UP

POINTS = (0.0, 0.5 - 0.1 * math.sqrt(5.0), 0.5 + 0.1 * math.sqrt(5.0), 1.0)
WEIGHTS = (1.0 / 12.0, 5.0 / 12.0, 5.0 / 12.0, 1.0 / 12.0)
CUBIC = np.linalg.inv(np.vander(POINTS, TERMS, increasing=True))
"""Coefficients of the cubic through the values at POINTS."""


class ThrownSphere(NamedTuple):
    """The sphere and its Hertz spring: `mass` [kg], `coefficient` [N/m^1.5], `gravity` [m/s^2] along its motion."""

    mass: float
    coefficient: float
    gravity: float


class Step(NamedTuple):
    """Buffers of one step: answers of all modes at three points, and their sums for the contact point."""

    turn: np.ndarray  # (3, modes) exp(lambda * share * step)
    push: np.ndarray  # (3, modes, TERMS) z left by each power of the force
    sums: np.ndarray  # (3, TERMS) approach gained by each force value at POINTS
    values: np.ndarray  # (3,) approach at the points, in and out
    force: np.ndarray  # (TERMS,) force at POINTS, out


def new_step(modes: int) -> Step:
    """Empty buffers for that many modes."""
    return Step(
        np.empty((3, modes), np.complex128),
        np.empty((3, modes, TERMS), np.complex128),
        np.empty((3, TERMS)),
        np.empty(3),
        np.zeros(TERMS),
    )


@kernel
def prepare(rate, shape, modal_mass, sphere, length, step):
    """Fills the buffers with all that depends on the step's length [s] alone."""
    moment = np.empty(TERMS, np.complex128)
    powers = np.zeros((3, TERMS))
    for i in range(3):
        share = POINTS[i + 1]
        span = share * length
        for k in range(TERMS):
            powers[i, k] = -span * span * share**k / ((k + 1) * (k + 2) * sphere.mass)
        for n in range(len(rate)):
            z = rate[n] * span
            moments(z, moment)
            step.turn[i, n] = np.exp(z)
            for k in range(TERMS):
                step.push[i, n, k] = shape[n] / modal_mass * span * share**k * moment[k]
                powers[i, k] -= shape[n] / rate[n].imag * step.push[i, n, k].imag
        for j in range(TERMS):
            total = 0.0
            for k in range(TERMS):
                total += powers[i, k] * CUBIC[k, j]
            step.sums[i, j] = total


@kernel
def solve3(a, b):
    """Solution of three linear equations in place: `b` becomes it. No pivots: the diagonal leads."""
    for i in range(3):
        for row in range(i + 1, 3):
            factor = a[row, i] / a[i, i]
            for column in range(i, 3):
                a[row, column] -= factor * a[i, column]
            b[row] -= factor * b[i]
    for i in range(2, -1, -1):
        for column in range(i + 1, 3):
            b[i] -= a[i, column] * b[column]
        b[i] /= a[i, i]


@kernel
def solve_step(rate, shape, tail, sphere, length, step, state, position, velocity):
    """Newton's method for the approaches at the three points from `step.values`; True when it converged.

    `step.force[0]` is the force at the start; the others come out, zero where there is a gap.
    """
    free = np.empty(3)
    for i in range(3):
        span = POINTS[i + 1] * length
        free[i] = position + span * (velocity + 0.5 * sphere.gravity * span)
        for n in range(len(rate)):
            free[i] -= shape[n] / rate[n].imag * (step.turn[i, n] * state[n]).imag
        free[i] += step.sums[i, 0] * step.force[0]
    a, b, slope = np.empty((3, 3)), np.empty(3), np.empty(3)
    for _ in range(50):
        for i in range(3):
            spring = elastic(sphere.coefficient, HERTZIAN, step.values[i])
            step.force[i + 1], slope[i] = spring.load, spring.stiffness
        greatest = 0.0
        for i in range(3):
            b[i] = free[i] - step.values[i] - tail * step.force[i + 1]
            for j in range(3):
                b[i] += step.sums[i, j + 1] * step.force[j + 1]
                a[i, j] = -step.sums[i, j + 1] * slope[j]
            a[i, i] += 1.0 + tail * slope[i]
            greatest = max(greatest, abs(step.values[i]))
        solve3(a, b)
        change = 0.0
        for i in range(3):
            step.values[i] += b[i]
            change = max(change, abs(b[i]))
        if not math.isfinite(change):
            return False
        if change <= 1e-15 * greatest:
            return True
    return change <= 1e-11 * greatest


@kernel
def guess(step, length, alpha, alpha_rate):
    """A start for Newton's method: the approach goes on at its rate."""
    for i in range(3):
        step.values[i] = alpha + alpha_rate * POINTS[i + 1] * length


@inlined
def _pressed(what, length):
    """True if the bodies still press at the end of a step of this length; anything once it is to stop."""
    (rate, shape, modal_mass, tail, sphere), step, state, position, velocity, alpha, alpha_rate, stop = what
    if stop[0] == 0:
        prepare(rate, shape, modal_mass, sphere, length, step)
        guess(step, length, alpha, alpha_rate)
        solve_step(rate, shape, tail, sphere, length, step, state, position, velocity)
    return step.values[2] > 0.0


@kernel
def last_step(
    rate, shape, modal_mass, tail, sphere, longest, step, state, position, velocity, alpha, alpha_rate, stop
):  # fmt: skip
    """Length [s] of the step at whose end the approach is zero, at most `longest`; the buffers hold that step."""
    beam = rate, shape, modal_mass, tail, sphere
    _, _, length = halved(
        _pressed, (beam, step, state, position, velocity, alpha, alpha_rate, stop), longest, 1e-13 * longest
    )
    return length


@kernel
def march(rate, shape, modal_mass, tail, sphere, shortest, longest, until, step, pieces, first, stop):
    """Marches one contact from piece `first`, whose start, state and motion are set; returns (next piece, status).

    Writes starts, lengths, cubics and works of the pieces of contact, and start, state and motion of the next.
    Without separation before `until` [s] the status is TIME_UP, once `stop` (1,) is not 0 STOPPED.
    """
    starts, _, _, states, motions, works = pieces
    begun, piece = starts[first], first
    alpha, alpha_rate, prepared = 0.0, 1.0, 0.0
    alpha_rate = motions[first, 1]
    for n in range(len(rate)):
        q = states[first, n].imag / rate[n].imag
        alpha_rate -= shape[n] * (states[first, n].real + rate[n].real * q)
    step.force[:] = 0.0
    while piece + 1 < len(starts):
        if stop[0] != 0:
            return piece, STOPPED
        elapsed = starts[piece] - begun
        length = min(longest, max(shortest, elapsed))
        if alpha_rate < 0.0:
            length = min(length, max(shortest, -0.5 * alpha / alpha_rate))
        position, velocity, before = motions[piece, 0], motions[piece, 1], step.force[0]
        ended = False
        while True:
            if prepared != length:
                prepare(rate, shape, modal_mass, sphere, length, step)
                prepared = length
            guess(step, length, alpha, alpha_rate)
            solved = solve_step(rate, shape, tail, sphere, length, step, states[piece], position, velocity)
            if not math.isfinite(step.values[2] + step.values[0]):
                return piece, NOT_FINITE
            if solved and min(step.values[0], step.values[1], step.values[2]) > 0.0:
                break
            if length <= shortest:
                if not solved:
                    return piece, STALLED
                for i in range(2, -1, -1):
                    if step.values[i] <= 0.0:
                        span = POINTS[i + 1] * length
                length = last_step(
                    rate, shape, modal_mass, tail, sphere, span, step, states[piece], position, velocity,
                    alpha, alpha_rate, stop,
                )  # fmt: skip
                prepared, ended = length, True
                step.force[3] = 0.0
                break
            length = max(shortest, 0.5 * length)
        works[piece] = finish_step(sphere, length, step, pieces, piece)
        alpha_rate = (step.values[2] - step.values[1]) / ((1.0 - POINTS[2]) * length)
        alpha = step.values[2]
        step.force[0] = step.force[3]
        piece += 1
        if ended:
            return piece, SEPARATED
        if starts[piece] >= until or not math.isfinite(before):
            return piece, TIME_UP
    return piece, FULL


@kernel
def finish_step(sphere, length, step, pieces, piece):
    """Writes the piece and the start of the next; returns the work [J] done on the beam, tail included."""
    starts, lengths, forces, states, motions, _ = pieces
    starts[piece + 1], lengths[piece] = starts[piece] + length, length
    position, velocity = motions[piece]
    force = forces[piece]
    for k in range(TERMS):
        force[k] = 0.0
        for j in range(TERMS):
            force[k] += CUBIC[k, j] * step.force[j]
    for n in range(states.shape[1]):
        z = step.turn[2, n] * states[piece, n]
        for k in range(TERMS):
            z += step.push[2, n, k] * force[k]
        states[piece + 1, n] = z
    impulse, moved = 0.0, 0.0
    for k in range(TERMS):
        impulse += force[k] * length / (k + 1)
        moved += force[k] * length * length / ((k + 1) * (k + 2))
    motions[piece + 1, 0] = position + length * (velocity + 0.5 * sphere.gravity * length) - moved / sphere.mass
    motions[piece + 1, 1] = velocity + sphere.gravity * length - impulse / sphere.mass
    # Work = [f w] - integral of f' w, with w = s - alpha at the points.
    work = 0.0
    for i in range(TERMS):
        share = POINTS[i]
        span = share * length
        w = position + span * (velocity + 0.5 * sphere.gravity * span)
        slope = force[1] + share * (2.0 * force[2] + share * 3.0 * force[3])
        for k in range(TERMS):
            w -= span * span * share**k * force[k] / ((k + 1) * (k + 2) * sphere.mass)
        alpha = step.values[i - 1]
        if i == 0:
            alpha = approach_of_load(sphere.coefficient, HERTZIAN, max(step.force[0], 0.0))
        w -= alpha
        work -= WEIGHTS[i] * slope * w
        if i == 0:
            work -= force[0] * w
        if i == TERMS - 1:
            work += step.force[3] * w
    return work
