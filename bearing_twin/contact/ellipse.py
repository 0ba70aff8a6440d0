"""From the curvatures of the gap to the ellipse of a Hertz contact, by the core (`core/contact/ellipse.hpp`).

The gap of the undeformed bodies is z = P x^2 + Q y^2 with P = `curvature_small` <= Q = `curvature_large` [1/m] (paper
1, eq. 6). All functions take numbers or arrays that broadcast. With m = 1 - (b/a)^2 the integrals

    B(m) = int cos^2 / sqrt(1 - m sin^2),   D(m) = int sin^2 / sqrt(1 - m sin^2)   over (0, pi/2)

hold the usual ones without subtraction: K = B + D, E = B + (1-m) D, (K - E)/m = D.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.elasticity import coefficient_of
from bearing_twin.core import INTEGER, REALS, REALS_OUT, Function, by_elements

AXIS_RATIO_MIN = 1e-6
"""Below this b/a the contact is a line for every practical purpose and is not treated as an ellipse."""

# The gap ratio Q/P at which b/a reaches AXIS_RATIO_MIN: B/((b/a)^2 D) with B = 1, D = ln(4 a/b) - 1.
CURVATURE_RATIO_MAX = 1.0 / (AXIS_RATIO_MIN**2 * (math.log(4.0 / AXIS_RATIO_MIN) - 1.0))

_elliptic = Function("core_elliptic", None, (INTEGER, REALS, REALS_OUT, REALS_OUT))
_axis_ratios = Function("core_axis_ratios", None, (INTEGER, REALS, REALS, REALS_OUT))
_ellipses = Function("core_ellipses", None, (INTEGER, *(REALS,) * 4, *(REALS_OUT,) * 3))


class Ellipse(NamedTuple):
    """Contact ellipse of one loaded contact: semi-axes [m], a >= b, and the pressure [Pa] at its centre."""

    semi_major: float
    semi_minor: float
    peak_pressure: float


def elliptic_b_d(complementary):
    """The complete elliptic integrals B(m) and D(m) as functions of kc = sqrt(1 - m) in (0, 1], to full precision."""
    return tuple(by_elements(_elliptic, 2, (), complementary))


def elliptic_e(complementary):
    """The complete elliptic integral of the second kind as a function of sqrt(1 - m)."""
    b, d = elliptic_b_d(complementary)
    return b + complementary**2 * d


def curvature_ratio(axis_ratio):
    """Q/P of the gap whose contact ellipse has semi-axis ratio b/a in (0, 1] (paper 1, eq. 8, solved for P/Q)."""
    b, d = elliptic_b_d(axis_ratio)
    return b / (axis_ratio * axis_ratio * d)


def axis_ratio(curvature_small, curvature_large):
    """Semi-axis ratio b/a in (0, 1] of the contact ellipse, the unique root of paper 1, eq. (8) (Theorem 1).

    NaN when the curvatures are not 0 < P <= Q; below b/a = 1e-6 the answer is still returned and `AXIS_RATIO_MIN` tells
    whether to trust it.
    """
    return by_elements(_axis_ratios, 1, (), curvature_small, curvature_large)[0]


def hertz_coefficient(curvature_small, curvature_large, effective_modulus):
    """c [N/m^1.5] of the exact Hertz load c h^1.5 for approach h [m] (Hertz 1882; paper 1, eqs. 7-8).

    c = (2 pi/3) E* K^(-3/2) sqrt(D/P), for a circle 4/3 E* sqrt(R). NaN as `axis_ratio`.
    """
    return coefficient_of("hertz_exact", curvature_small, curvature_large, effective_modulus)


def semi_axes(curvature_small, curvature_large, approach):
    """Semi-axes [m] of the ellipse at this approach [m]: a = sqrt(h D/(K P)), b = a (b/a); zero for a gap."""
    ratio = axis_ratio(curvature_small, curvature_large)
    b, d = elliptic_b_d(ratio)
    semi_major = (np.maximum(approach, 0.0) * d / ((b + d) * curvature_small)) ** 0.5
    return semi_major, semi_major * ratio


def ellipse(curvature_small, curvature_large, effective_modulus, normal_load) -> Ellipse:
    """Semi-axes [m] and peak pressure [Pa] of an elliptic Hertz contact under `normal_load` [N].

    a^3 = 3 F D / (2 pi E* P (b/a)), peak pressure 3F/(2 pi a b); all zero without load.
    """
    return Ellipse(*by_elements(_ellipses, 3, (), curvature_small, curvature_large, effective_modulus, normal_load))
