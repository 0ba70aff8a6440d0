"""Closed forms of the central impact of two elastic bodies whose load is c h^p: Hertz, or a linear spring.

Landau and Lifchitz, Theory of Elasticity, section 9; paper 3, eqs. (1), (2) and (13). Every function takes numbers or
arrays that broadcast; SI units; `coefficient` is c, `power` p (1.5 unless given),
`speed` > 0 is the relative speed at the first touch, `reduced_mass` is
m m'/(m + m'). Wave motion in the bodies is neglected: right while the contact lasts many wave transits.
"""

import math

import numpy as np
from scipy.special import betaincinv

from bearing_twin.contact.elasticity import greatest_approaches, loads_at
from bearing_twin.contact.laws import HERTZIAN, restitution_of


def contact_constant(power):
    """Contact time * speed / greatest approach: 2.9432751843 for Hertz, pi for a linear spring."""
    share = 1.0 / (power + 1.0)
    return 4.0 * math.sqrt(math.pi) * math.gamma(share) / (2.0 * (power + 1.0) * math.gamma(share + 0.5))


CONTACT_CONSTANT = contact_constant(HERTZIAN)
"""C_H, the 2.94 of paper 3, eq. (2)."""


def greatest_approach(coefficient, reduced_mass, speed, power=HERTZIAN):
    """Approach [m] at which the bodies stand still against each other; for Hertz (5 mu v^2 / (4 c))^(2/5)."""
    return greatest_approaches(coefficient, power, reduced_mass, speed)


def contact_time(coefficient, reduced_mass, speed, power=HERTZIAN):
    """Duration [s] of the contact, C h0 / v; for Hertz alpha v^(-1/5) (paper 3, eq. 1)."""
    return contact_constant(power) * greatest_approach(coefficient, reduced_mass, speed, power) / speed


def peak_force(coefficient, reduced_mass, speed, power=HERTZIAN):
    """Greatest load [N], c h0^p."""
    return loads_at(coefficient, power, greatest_approach(coefficient, reduced_mass, speed, power))


def alpha(coefficient, reduced_mass):
    """Paper 3's alpha [s (m/s)^(1/5)] of `contact time = alpha v^(-1/5)`, eq. (2) with 2.94 made exact."""
    return CONTACT_CONSTANT * (1.25 * reduced_mass / coefficient) ** 0.4


def coefficient_of_alpha(measured_alpha, reduced_mass):
    """Load coefficient [N/m^1.5] that gives a measured alpha; the inverse of `alpha` (C = 5k/4 of paper 3, eq. 12)."""
    return 1.25 * reduced_mass * (CONTACT_CONSTANT / measured_alpha) ** 2.5


def approach_history(times, coefficient, reduced_mass, speed, power=HERTZIAN):
    """Approach [m] at `times` [s] after the first touch, zero before and after the contact.

    t / tau = I_x(1/(p + 1), 1/2) / 2 with x = (h / h0)^(p + 1), the regularised incomplete beta function, up to the
    greatest approach; the way back mirrors the way there.
    """
    duration, root = contact_time(coefficient, reduced_mass, speed, power), 1.0 / (power + 1.0)
    share = np.clip(np.asarray(times, float) / duration, 0.0, 1.0)
    share = 2.0 * np.minimum(share, 1.0 - share)
    return greatest_approach(coefficient, reduced_mass, speed, power) * betaincinv(root, 0.5, share) ** root


def force_history(times, coefficient, reduced_mass, speed, power=HERTZIAN):
    """Load [N] at `times` [s] after the first touch."""
    return loads_at(coefficient, power, approach_history(times, coefficient, reduced_mass, speed, power))


def damped_impact(coefficient, reduced_mass, speed, damping, power=HERTZIAN):
    """Contact time [s], peak force [N], greatest approach [m] and restitution of an impact with the Hunt-Crossley load.

    The first integral  c h^(p + 1) / (p + 1) = mu * integral of u du / (1 + chi u) from w to v  gives the approach h as
    a function of the approach rate w, and the time is the quadrature of -mu dw / load (see `damped_history`). Numbers
    only; `damping` = 0 gives the closed forms.
    """
    if damping == 0.0:
        bodies = coefficient, reduced_mass, speed, power
        return float(contact_time(*bodies)), float(peak_force(*bodies)), float(greatest_approach(*bodies)), 1.0
    times, _, rates = damped_history(coefficient, reduced_mass, speed, damping, power)
    # The load is greatest where p w (1 + chi w) = chi h load / mu; bisected on the rates.
    low, high = 0.0, speed
    for _ in range(200):
        rate = 0.5 * (low + high)
        h = _approach_at(rate, coefficient, reduced_mass, speed, damping, power)
        load = loads_at(coefficient, power, h) * (1.0 + damping * rate)
        rising = power * rate * (1.0 + damping * rate) > damping * h * load / reduced_mass
        low, high = (low, rate) if rising else (rate, high)
    deepest = _approach_at(0.0, coefficient, reduced_mass, speed, damping, power)
    return float(times[-1]), float(load), float(deepest), float(-rates[-1] / speed)


def damped_history(coefficient, reduced_mass, speed, damping, power=HERTZIAN, pieces=200):
    """Times [s] from the first touch, approach [m] and its rate [m/s], by quadrature over the rates; damping > 0.

    Near either end the approach goes as (distance in rate)^(1/(p + 1)), so rates are spaced as share^(p + 1) from both
    ends: then the time goes evenly, and the Gauss rule in each piece has a smooth integrand.
    """
    leaving = restitution_of(damping * speed) * speed
    points, weights = np.polynomial.legendre.leggauss(8)
    edges = np.linspace(0.0, 1.0, pieces + 1)
    fraction, exponent = edges[:-1, None] + 0.5 * (points + 1.0) / pieces, power + 1.0
    halves = []
    for end in (speed, -leaving):
        rates = end - end * fraction**exponent
        approach = _approach_at(rates, coefficient, reduced_mass, speed, damping, power)
        load = loads_at(coefficient, power, approach) * (1.0 + damping * rates)
        span = 0.5 / pieces * np.sum(weights * reduced_mass * exponent * abs(end) * fraction**power / load, axis=1)
        halves.append((np.concatenate([[0.0], np.cumsum(span)]), end - end * edges**exponent))
    (approach_times, falling), (return_times, rising) = halves
    times = np.concatenate([approach_times, approach_times[-1] + return_times[-1] - return_times[-2::-1]])
    rates = np.concatenate([falling, rising[-2::-1]])
    approach = _approach_at(rates, coefficient, reduced_mass, speed, damping, power)
    approach[[0, -1]] = 0.0
    return times, approach, rates


def _approach_at(rate, coefficient, reduced_mass, speed, damping, power):
    return greatest_approaches(coefficient, power, reduced_mass, np.sqrt(2.0 * _lost(speed, rate, damping)))


def _lost(speed, rate, damping):
    """The integral of w dw / (1 + damping w) from `rate` to `speed`; a series where damping is too small for logs."""
    x, y = damping * speed, damping * np.asarray(rate, float)
    if x < 1e-3:
        # (x^2 - y^2)/2 - (x^3 - y^3)/3 + ..., six terms reach 1e-18
        powers = [(-1.0) ** k * (x**k - y**k) / k for k in range(2, 8)]
        return np.maximum(sum(powers), 0.0) / damping**2
    return np.maximum((x - y) - np.log1p((x - y) / (1.0 + y)), 0.0) / damping**2


RAYLEIGH = 0.02  # 1/50
HUNTER = 1.04  # Poisson's ratio 1/4
"""Of what slow impacts of spheres lose to elastic waves, by two estimates; no law of contact holds it."""


def bar_speed(young_modulus: float, density: float) -> float:
    """sqrt(E/rho) [m/s], the speed of waves in a thin bar."""
    return math.sqrt(young_modulus / density)


def restitution_lost_between_spheres(speed: float, wave_speed: float) -> float:
    """1 - e of two equal spheres that meet with a relative `speed` [m/s]: half of the share that goes into vibration.

    v / (50 c): Rayleigh, Philosophical Magazine 11 (1906) 283. Breaks for speeds near that of waves.
    """
    return 0.5 * min(1.0, RAYLEIGH * speed / wave_speed)


def restitution_lost_on_half_space(speed: float, wave_speed: float) -> float:
    """1 - e of a sphere on a half-space of its material: half of the share that waves carry away.

    1.04 (v / c)^(3/5): Hunter, J. Mech. Phys. Solids 5 (1957) 162. Breaks for speeds near that of waves.
    """
    return 0.5 * min(1.0, HUNTER * (speed / wave_speed) ** 0.6)
