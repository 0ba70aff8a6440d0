"""The viscous part of the normal load, and its coefficient from the restitution wanted.

Two laws, both with d(h) -> 0 as h -> 0 (paper 1, section 5), for the elastic load c h^1.5 and a reduced mass m:

* Hunt and Crossley: d(h) = chi c h^1.5. Its restitution falls with speed: e depends on chi v alone.
* Steady, after Tsuji, Tanaka and Ishida (Powder Technology 71, 1992): d(h) = d h^(1/4). With s = (2/sqrt 5) h^(5/4) it
  is a linear oscillator in s, so its restitution is the same at every speed.

The loads themselves are the core's, `core/contact/laws.hpp`.
"""

import math
from typing import NamedTuple

from bearing_twin.base.errors import SceneError
from bearing_twin.contact.laws import HERTZIAN

SERIES_BELOW = 0.05  # chi v: the logarithms cancel to its square, so their series is summed instead


class Shortcut(NamedTuple):
    """What a usual formula gives: `damping` [s/m] for the wanted restitution, and the restitution it really yields."""

    damping: float
    restitution: float


def _root(function, low, high, **tolerances) -> float:
    """A root by Brent's method; SciPy's, whose import takes as long as a short run, when one is asked for."""
    from scipy.optimize import brentq

    return brentq(function, low, high, **tolerances)


def damping_number(restitution: float) -> float:
    """chi v of the Hunt-Crossley law for a restitution in (0, 1]: the exact root of x (1 + e) = ln[(1+x)/(1-ex)].

    The energy integral of m dv/dt = -c h^1.5 (1 + chi dh/dt), closed at separation; v is the speed at onset. Raises
    SceneError at e <= 0, which no finite coefficient reaches (e x -> 1).
    """
    _check(restitution)
    e = restitution
    if e == 1.0:
        return 0.0
    low = 0.5 * (1.0 - e * e)
    if e > 0.5:
        return _root(lambda x: _residual(e, x), low, (1.0 - 1e-12) / e, xtol=1e-300, rtol=1e-14)

    # x comes within exp(-1/e) of 1/e: solved for w = -ln(1 - e x) instead.
    def balance(w):
        x = -math.expm1(-w) / e
        return math.log1p(x) + w - x * (1.0 + e)

    w = _root(balance, -math.log1p(-e * low), (1.0 + e) / e, xtol=1e-300, rtol=1e-14)
    return -math.expm1(-w) / e


def restitution_of(number: float) -> float:
    """Restitution of the Hunt-Crossley law at chi v = `number` >= 0; the inverse of `damping_number`."""
    if not (math.isfinite(number) and number >= 0.0):
        raise SceneError(f"damping * speed = {number:g} must be a finite number, zero or above")
    if number == 0.0:
        return 1.0
    if number < SERIES_BELOW:
        return _root(lambda e: _residual(e, number), 0.0, 1.0, xtol=1e-16, rtol=1e-14)

    def balance(w):
        return math.log1p(number) + (w - number) + math.expm1(-w)  # w is lost beside a great number, log1p is not

    return -math.expm1(-_root(balance, 0.0, number + 1.0, xtol=1e-300, rtol=1e-14)) / number


def damping_for_restitution(restitution: float, speed: float) -> float:
    """Hunt-Crossley `damping` [s/m] that gives the restitution at this speed of onset [m/s]; faster ones lose more."""
    if not (math.isfinite(speed) and speed > 0.0):
        raise SceneError(f"speed = {speed:g} must be a finite number of m/s above zero")
    return damping_number(restitution) / speed


def steady_restitution(ratio: float) -> float:
    """Restitution of steady damping with damping ratio >= 0: exp(-2 z acos(z)/sqrt(1 - z^2)), at any speed.

    The half period of the oscillator in s, cut where the load would begin to pull; beyond 1 by continuation.
    """
    if ratio < 1.0 - 1e-6:
        angle = math.acos(ratio) / math.sqrt(1.0 - ratio * ratio)
    elif ratio > 1.0 + 1e-6:
        angle = math.acosh(ratio) / math.sqrt(ratio * ratio - 1.0)
    else:
        angle = 1.0 - (ratio - 1.0) / 3.0
    return math.exp(-2.0 * ratio * angle)


def steady_ratio(restitution: float) -> float:
    """Damping ratio of steady damping for a restitution in (0, 1]; the inverse of `steady_restitution`."""
    _check(restitution)
    if restitution == 1.0:
        return 0.0
    high = 1.0
    while steady_restitution(high) > restitution:
        high *= 2.0
        if high > 1e150:
            raise SceneError(f"restitution = {restitution:g} is too small for any damping; give a larger one")
    return _root(lambda z: math.log(steady_restitution(z) / restitution), 0.0, high, xtol=1e-300, rtol=1e-14)


def steady_damping(restitution: float, coefficient: float, mass: float, power: float = HERTZIAN) -> float:
    """`damping` [N s/m^(5/4)] of the steady law for a restitution in (0, 1], whatever the speed.

    `coefficient` [N/m^power] is that of the elastic law, `mass` [kg] m1 m2/(m1 + m2): damping = sqrt(2 (p + 1) m c) z.
    """
    for name, value in (("coefficient", coefficient), ("mass", mass)):
        if not (math.isfinite(value) and value > 0.0):
            raise SceneError(f"{name} = {value:g} must be a finite number above zero")
    return steady_ratio(restitution) * math.sqrt(2.0 * (power + 1.0) * mass * coefficient)


def shortcuts(restitution: float, speed: float) -> dict[str, Shortcut]:
    """The usual closed formulas for Hunt and Crossley's damping beside the exact one, and what each really gives.

    For the restitution wanted at this speed of onset [m/s]. Raises SceneError as `damping_for_restitution` does.
    """
    exact, e = damping_for_restitution(restitution, speed) * speed, restitution
    formulas = {
        "exact": exact,
        "hunt_crossley": 1.5 * (1.0 - e),
        "lankarani_nikravesh": 0.75 * (1.0 - e * e),
        "flores": 1.6 * (1.0 - e) / e,
    }
    return {name: Shortcut(number / speed, restitution_of(number)) for name, number in formulas.items()}


def _check(restitution):
    if not 0.0 < restitution <= 1.0:
        raise SceneError(f"restitution = {restitution:g} must be above 0 and at most 1; 1 = no damping")


def _residual(e, x):
    """(ln[(1+x)/(1-ex)] - x (1+e))/x^2, by its power series where x is small."""
    if x >= SERIES_BELOW:
        return (math.log1p(x) - math.log1p(-e * x) - x * (1.0 + e)) / (x * x)
    return sum(x ** (k - 2) * (e**k - (-1.0) ** k) / k for k in range(2, 16))
