"""Stresses below a Hertz contact, on the axis through its centre, where its greatest shear lies."""

import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import elliprd


class Shear(NamedTuple):
    """Greatest shear stress on the axis [Pa] and its depth below the surface [m]."""

    stress: float
    depth: float


def axis_stresses(semi_major, semi_minor, peak_pressure, poisson_ratio, depth):
    """Principal stresses [Pa] at `depth` [m] >= 0 below the centre: along the major axis, the minor axis, and normal.

    Boussinesq's potentials of the pressure p0 sqrt(1 - x^2/a^2 - y^2/b^2) on a half-space without friction, reduced
    to Carlson's integrals R_D: no term cancels at the circle (Johnson, Contact Mechanics, section 3.7, prints forms
    that do). Tension is positive; `depth` may be an array.
    """
    a, b, nu = semi_major, semi_minor, poisson_ratio
    z = np.asarray(depth, dtype=float)
    a2, b2, z2 = a * a + z * z, b * b + z * z, z * z
    root = np.sqrt(a2 * b2)
    shape = np.sqrt(b2 / a2)
    below = np.maximum(z2, np.finfo(float).tiny)
    # The integrals over w from z^2 to infinity of 1/((a^2 + w) W), 1/((b^2 + w) W), 1/(w W), W^2 = (a^2+w)(b^2+w) w.
    along, across = z * elliprd(below, b2, a2) / 1.5, z * elliprd(below, a2, b2) / 1.5
    inward = np.where(z > 1e-9 * b, z * elliprd(a2, b2, below) / 1.5, 2.0 / root)
    j_along, j_across = 2.0 / (a2 * (1.0 + shape)), 2.0 / (b2 * (1.0 + 1.0 / shape))
    half = 0.5 * a * b * peak_pressure
    stress_x = half * (-2.0 * nu * inward + along - (1.0 - 2.0 * nu) * (j_along - along))
    stress_y = half * (-2.0 * nu * inward + across - (1.0 - 2.0 * nu) * (j_across - across))
    return stress_x, stress_y, -2.0 * half / root


def greatest_shear(semi_major, semi_minor, peak_pressure, poisson_ratio) -> Shear:
    """The greatest shear stress on the axis, half the difference of the extreme principal stresses, and its depth.

    0.310 p0 at 0.481 a below a circle, 0.300 p0 at 0.786 b below a line (nu = 0.3); at the surface itself as
    Poisson's ratio nears -1.
    """

    def shear(depth):
        stresses = np.array(axis_stresses(semi_major, semi_minor, peak_pressure, poisson_ratio, depth))
        return 0.5 * (stresses.max(axis=0) - stresses.min(axis=0))

    depths = semi_minor * np.linspace(0.0, 2.0, 81)
    values = shear(depths)
    best = int(values.argmax())
    if best == 0:
        return Shear(float(values[0]), 0.0)
    bounds = depths[best - 1], depths[min(best + 1, len(depths) - 1)]
    found = minimize_scalar(lambda z: -shear(z), bounds=bounds, method="bounded", options={"xatol": 1e-9 * semi_minor})
    if not math.isfinite(found.fun) or -found.fun < values[best]:
        return Shear(float(values[best]), float(depths[best]))
    return Shear(float(-found.fun), float(found.x))
