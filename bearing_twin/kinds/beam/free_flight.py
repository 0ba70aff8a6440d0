"""Sphere and beam apart: both move in closed form, and the next touch is found without stepping over any."""

import math

import numpy as np

from bearing_twin.compiled import kernel


@kernel
def gap_and_rate(rate, shape, state, sphere, position, velocity, time, out):
    """(alpha, d alpha / dt) of free flight `time` [s] later; `out` [modes] receives the modes' state."""
    alpha = position + time * (velocity + 0.5 * sphere.gravity * time)
    alpha_rate = velocity + sphere.gravity * time
    for n in range(len(rate)):
        z = np.exp(rate[n] * time) * state[n]
        q = z.imag / rate[n].imag
        out[n] = z
        alpha -= shape[n] * q
        alpha_rate -= shape[n] * (z.real + rate[n].real * q)
    return alpha, alpha_rate


@kernel
def next_touch(rate, shape, state, sphere, position, velocity, limit, shortest, stop):
    """Time [s] until sphere and freely swinging beam touch again, `limit` if not before, inf if never.

    Once `stop` (1,) is not 0 the search ends at once, with `limit`.

    No touch is stepped over: the approach bends at most by  B = g + sum |phi lambda^2 z| / Im lambda, so from a gap it
    stays one until alpha + alpha' t + B t^2 / 2 = 0, and so on from there; gaps that close for less than `shortest`
    [s] are passed.
    """
    bend, reach = abs(sphere.gravity), 0.0
    for n in range(len(rate)):
        size = abs(shape[n]) * abs(state[n]) / rate[n].imag
        reach += size
        bend += size * abs(rate[n]) ** 2
    out = np.empty_like(state)
    time = 0.0
    for _ in range(10_000_000):
        alpha, alpha_rate = gap_and_rate(rate, shape, state, sphere, position, velocity, time, out)
        speed = velocity + sphere.gravity * time
        if (
            sphere.gravity <= 0.0
            and speed <= 0.0
            and position + time * (velocity + 0.5 * sphere.gravity * time) < -reach
        ):
            return math.inf
        if time >= limit or not math.isfinite(alpha) or stop[0] != 0:
            return limit
        if alpha >= 0.0 and alpha_rate > 0.0 and time > 0.0:
            return time
        depth = max(-alpha, 0.0)
        root = math.sqrt(alpha_rate * alpha_rate + 2.0 * bend * depth)
        # (root - alpha_rate) / bend without cancellation for a closing gap
        ahead = 2.0 * depth / (root + alpha_rate) if alpha_rate > 0.0 else (root - alpha_rate) / bend
        time += max(ahead, shortest)
    return limit
