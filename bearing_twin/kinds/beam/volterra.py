"""Paper 2, eq. (9): the contact force of a sphere on a beam as a Volterra integral equation, by product integration.

    (f / c)^(2/3) = s_0(t) - w_0(t) - integral of f(u) [(t - u) / m + G(t - u)] du - tail f(t),
    G(t) = sum phi_n^2 / (M omega_n) exp(-zeta omega_n t) sin(omega_n t),

s_0 and w_0 being sphere and beam without the force. The force is piecewise linear on even steps and the kernel is
integrated exactly against it, so the error falls as step^2. Each step is one scalar equation, solved by Newton's
method; Picard's iteration diverges in steps longer than a fifth to a half of the contact.
"""

import math

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.elastic import HERTZIAN, approach_of_load
from bearing_twin.kinds.beam.modes import TERMS, moments
from bearing_twin.numerics.events import halved
from bearing_twin.numerics.statuses import FULL, NOT_FINITE, SEPARATED, STOPPED, TIME_UP


@kernel
def hat_answers(rate, shape, modal_mass, length):
    """What a unit hat (zero, one, zero at three neighbouring steps) leaves in z: at its top, and one step later."""
    top, after = np.empty_like(rate), np.empty_like(rate)
    moment = np.empty(TERMS, np.complex128)
    for n in range(len(rate)):
        moments(rate[n] * length, moment)
        scale = shape[n] / modal_mass * length
        top[n] = scale * moment[1]
        after[n] = np.exp(rate[n] * length) * top[n] + scale * (moment[0] - moment[1])
    return top, after


@kernel
def kernel_weights(rate, shape, modal_mass, mass, length, count, stop):
    """Weights [m/N]: approach lost at step k for a unit hat of force centred j <= k steps is weights[k - j].

    As everything here that takes long, it ends early once `stop` (1,) is not 0.
    """
    top, after = hat_answers(rate, shape, modal_mass, length)
    weights = np.empty(count)
    weights[0] = length * length / (6.0 * mass)
    turn = np.exp(rate * length)
    for n in range(len(rate)):
        weights[0] += shape[n] / rate[n].imag * top[n].imag
    z = after.copy()
    for k in range(1, count):
        if stop[0] != 0:
            break
        weights[k] = length * (k * length) / mass
        for n in range(len(rate)):
            weights[k] += shape[n] / rate[n].imag * z[n].imag
            z[n] *= turn[n]
    return weights


@kernel
def contact_force(coefficient, given, stiffness):
    """Force [N] with (f / c)^(2/3) + stiffness f = given, by Newton's method on y = f^(1/3); zero for a gap."""
    if given <= 0.0:
        return 0.0
    scale = approach_of_load(coefficient, HERTZIAN, 1.0)
    y = math.sqrt(given / scale)
    for _ in range(100):
        change = (scale * y * y + stiffness * y * y * y - given) / (2.0 * scale * y + 3.0 * stiffness * y * y)
        y -= change
        if abs(change) <= 1e-15 * y:
            break
    return y * y * y


@kernel
def march_forces(coefficient, tail, weights, free, force, stop):
    """Forces [N] at the steps 1 .. from the approach [m] `free` of the force; returns the first step with a gap."""
    force[0] = 0.0
    for k in range(1, len(free)):
        given = free[k]
        for j in range(1, k):
            given -= weights[k - j] * force[j]
        force[k] = contact_force(coefficient, given, weights[0] + tail)
        if stop[0] != 0:
            return k
        if not math.isfinite(force[k]):
            return -k
        if force[k] <= 0.0:
            return k
    return len(free)


@kernel
def free_approach(rate, shape, sphere, length, state, position, velocity, count, stop):
    """Approach [m] at steps 0 .. count - 1 if no force acted."""
    free = np.empty(count)
    turn = np.exp(rate * length)
    z = state.copy()
    for k in range(count):
        if stop[0] != 0:
            break
        time = k * length
        free[k] = position + time * (velocity + 0.5 * sphere.gravity * time)
        for n in range(len(rate)):
            free[k] -= shape[n] / rate[n].imag * z[n].imag
            z[n] *= turn[n]
    return free


@inlined
def _pressed(what, span):
    """True if the approach is above zero after a step [s] over which the force falls to zero."""
    (rate, shape, modal_mass, sphere), state, position, velocity, force, moment = what
    alpha = position + span * (velocity + 0.5 * sphere.gravity * span) - force * span * span / (3.0 * sphere.mass)
    for n in range(len(rate)):
        z = rate[n] * span
        moments(z, moment)
        end = np.exp(z) * state[n] + shape[n] / modal_mass * span * force * (moment[0] - moment[1])
        alpha -= shape[n] / rate[n].imag * end.imag
    return alpha > 0.0


@kernel
def end_of_contact(rate, shape, modal_mass, sphere, length, state, position, velocity, force):
    """Length [s] <= `length` of the last, shortened step, over which the force falls to zero and alpha with it."""
    beam, moment = (rate, shape, modal_mass, sphere), np.empty(TERMS, np.complex128)
    _, high, _ = halved(_pressed, (beam, state, position, velocity, force, moment), length, 1e-14 * length)
    return high


@kernel
def march_volterra(rate, shape, modal_mass, tail, sphere, length, weights, until, pieces, first, stop):
    """One contact as in `beam_contact.march`: pieces written from `first`; returns (next piece, status)."""
    starts, lengths, forces, states, motions, works = pieces
    room = len(starts) - first - 1
    count = min(len(weights), room, int((until - starts[first]) / length) + 2)
    position, velocity = motions[first]
    free = free_approach(rate, shape, sphere, length, states[first], position, velocity, count, stop)
    force = np.zeros(count)
    gap = march_forces(sphere.coefficient, tail, weights, free, force, stop)
    if stop[0] != 0:
        return first, STOPPED
    if gap < 0:
        return first, NOT_FINITE
    turn = np.exp(rate * length)
    moment = np.empty(TERMS, np.complex128)
    rise, fall = np.empty_like(rate), np.empty_like(rate)
    for n in range(len(rate)):
        moments(rate[n] * length, moment)
        rise[n] = shape[n] / modal_mass * length * moment[1]
        fall[n] = shape[n] / modal_mass * length * (moment[0] - moment[1])
    piece = first
    for k in range(1, gap + 1):
        low, high, span = force[k - 1], 0.0, length
        if k == gap:
            if gap == count:
                break
            span = end_of_contact(
                rate, shape, modal_mass, sphere, length, states[piece], motions[piece, 0], motions[piece, 1], low
            )
            for n in range(len(rate)):
                moments(rate[n] * span, moment)
                turn[n] = np.exp(rate[n] * span)
                fall[n] = shape[n] / modal_mass * span * (moment[0] - moment[1])
        else:
            high = force[k]
        for n in range(len(rate)):
            states[piece + 1, n] = turn[n] * states[piece, n] + fall[n] * low + rise[n] * high
        starts[piece + 1], lengths[piece] = starts[piece] + span, span
        forces[piece, 0], forces[piece, 1], forces[piece, 2], forces[piece, 3] = low, high - low, 0.0, 0.0
        s, u = motions[piece]
        motions[piece + 1, 0] = (
            s + span * (u + 0.5 * sphere.gravity * span) - span * span * (2.0 * low + high) / (6.0 * sphere.mass)
        )
        motions[piece + 1, 1] = u + span * (sphere.gravity - 0.5 * (low + high) / sphere.mass)
        works[piece] = linear_work(sphere, low, high, span, s, u, motions[piece + 1, 0])
        piece += 1
    if gap < count:
        return piece, SEPARATED
    return piece, TIME_UP if starts[piece] >= until else FULL


@kernel
def linear_work(sphere, low, high, span, position, velocity, after):
    """Work [J] on the beam over one step: [f w] - f' times the integral of w, by Simpson's rule; w = s - alpha."""
    middle = 0.5 * (low + high)
    half = 0.5 * span
    s = (
        position
        + half * (velocity + 0.5 * sphere.gravity * half)
        - half * half * (2.0 * low + middle) / (6.0 * sphere.mass)
    )
    w0 = position - approach_of_load(sphere.coefficient, HERTZIAN, low)
    w1 = s - approach_of_load(sphere.coefficient, HERTZIAN, middle)
    w2 = after - approach_of_load(sphere.coefficient, HERTZIAN, high)
    return high * w2 - low * w0 - (high - low) * (w0 + 4.0 * w1 + w2) / 6.0
