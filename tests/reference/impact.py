"""Central impacts by the equation of motion, and the load of two discs by Brent's method: truths without closed forms.

Nothing of `contact/` or `kinds/` is used: m x'' = -F(x, x') is followed by SciPy to the end of the contact.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq


class Strike(NamedTuple):
    """An impact followed: duration [s], greatest load [N] and approach [m], restitution, and approach [m] at times [s].

    The duration ends where the bodies part, or earlier where the load would begin to pull.
    """

    duration: float
    peak_force: float
    greatest_approach: float
    restitution: float
    approach: Callable[[np.ndarray], np.ndarray]


def power_load(coefficient: float, damping: float = 0.0) -> Callable[[float, float], float]:
    """The load [N] c x^1.5 (1 + chi dx/dt) of an approach [m] and its rate [m/s]: Hertz, Hunt and Crossley."""
    return lambda x, rate: coefficient * max(x, 0.0) ** 1.5 * (1.0 + damping * rate)


def equation_14(radius: float, thickness: float, young_modulus: float, poisson_ratio: float):
    """The load [N] of two equal discs at an approach [m], paper 3, eq. (14), by Brent's method, up to its greatest.

    x = (F V/a) [1 + ln(8 a^3/(r F V))], V = (1 - nu^2)/(pi E), 2 a = `thickness`.
    """
    a, v = 0.5 * thickness, (1.0 - poisson_ratio**2) / (math.pi * young_modulus)

    def approach(product):  # F V
        return product / a * (1.0 + math.log(8.0 * a**3 / (radius * product)))

    def load(x, _):
        if x <= 0.0:
            return 0.0
        top = 8.0 * a**3 / radius
        low = 1e-30 * top
        if approach(low) >= x:
            return 0.0
        return brentq(lambda product: approach(product) - x, low, top, xtol=1e-300, rtol=1e-15, maxiter=400) / v

    return load


def strike(load: Callable[[float, float], float], reduced_mass: float, speed: float, scale: float) -> Strike:
    """Follows an impact at `speed` [m/s] > 0; `scale` [m] is about the greatest approach. Nine digits."""

    def rates(_, state):
        return state[1], -load(scale * state[0], speed * state[1]) * scale / (reduced_mass * speed**2)

    def deepest(_, state):
        return state[1]

    def parted(_, state):
        return state[0]

    def pulling(_, state):
        return load(scale * state[0], speed * state[1]) if state[1] < 0.0 else 1.0

    def hardest(_, state):
        """The load's rate of change, by a difference along the motion."""
        x, rate = scale * state[0], speed * state[1]
        later = 1e-7 * scale / speed
        there = load(x + later * rate, rate - later * load(x, rate) / reduced_mass)
        back = load(x - later * rate, rate + later * load(x, rate) / reduced_mass)
        return there - back

    parted.terminal = pulling.terminal = True
    parted.direction = pulling.direction = -1.0
    deepest.direction = hardest.direction = -1.0
    found = solve_ivp(
        rates, (0.0, 1e3), (0.0, 1.0), "DOP853", rtol=1e-12, atol=1e-14, max_step=0.05, dense_output=True,
        events=(parted, pulling, deepest, hardest),
    )  # fmt: skip
    top, peak = found.y_events[2][0], found.y_events[3][0]
    unit = scale / speed

    def approach(times):
        share = np.clip(np.asarray(times, float) / unit, 0.0, found.t[-1])
        return scale * found.sol(share)[0]

    return Strike(
        float(found.t[-1]) * unit,
        float(load(scale * peak[0], speed * peak[1])),
        float(scale * top[0]),
        float(-found.y[1, -1]),
        approach,
    )
