"""Elastic point contacts: coefficients, loads and energies of the laws of `laws.LAWS`; the contact ellipse.

The gap of the undeformed bodies is z = P x^2 + Q y^2 with P = `curvature_small` <= Q = `curvature_large` [1/m] (paper
1, eq. 6). All functions take numbers or arrays that broadcast. With m = 1 - (b/a)^2 the integrals

    B(m) = int cos^2 / sqrt(1 - m sin^2),   D(m) = int sin^2 / sqrt(1 - m sin^2)   over (0, pi/2)

hold the usual ones without subtraction: K = B + D, E = B + (1-m) D, (K - E)/m = D.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.laws import FORMULAS, LAWS
from bearing_twin.core import INTEGER, REAL, REALS, REALS_OUT, Function, elementwise

_coefficients = Function("core_law_coefficients", None, (INTEGER, REAL, INTEGER, REALS, REALS, REALS, REALS_OUT))
_elastic = Function("core_elastic", None, (REAL, INTEGER, REALS, REALS, *(REALS_OUT,) * 3))
_course = Function("core_carried_course", None, (INTEGER, INTEGER, REALS, REALS_OUT, REALS_OUT))


class Elasticity(NamedTuple):
    """A law of a point contact in use, as the core reads it.

    `number` is its formula's in FORMULAS, `modulus` E* [Pa], `given` the number that laws take which follow no
    curvatures.
    """

    number: int
    power: float
    modulus: float
    given: float

    @property
    def follows(self) -> bool:
        """True if the coefficient follows the curvatures."""
        return FORMULAS[self.number] != "given"

    @property
    def carried(self) -> int:
        """Number of the law in CarriedLaw of the core, 0 of a law without states."""
        return {"carried": 1, "carried_left": 2}.get(FORMULAS[self.number], 0)


def elasticity(name: str, modulus: float, given: float) -> Elasticity:
    """The law of that name for a point contact; `given` as in `Elasticity`."""
    row = LAWS[name]
    return Elasticity(FORMULAS.index(row.formula), row.power, float(modulus), float(given))


def fresh_coefficient(law: Elasticity, curvature_small, curvature_large, modulus=None):
    """c [N/m^power] of a law, whose states, if any, are solved for; curvatures [1/m] and moduli [Pa] broadcast."""
    arguments = curvature_small, curvature_large, law.modulus if modulus is None else modulus
    return elementwise(_coefficients, 1, (law.number, law.given), *arguments)[0]


def coefficient_of(name: str, curvature_small, curvature_large, modulus, given=0.0):
    """c [N/m^power] of the law of that name, whose states, if any, are solved for; arrays broadcast."""
    return fresh_coefficient(elasticity(name, 1.0, given), curvature_small, curvature_large, modulus)


def sphere_coefficient(name: str, modulus, radius, given=0.0):
    """c [N/m^power] of a law between spheres of radius [m] R1 R2/(R1 + R2); arrays broadcast."""
    row = LAWS[name]
    if not row.follows:
        return given
    circle = coefficient_of(name, 0.5, 0.5, 1.0) if row.circle is None else row.circle
    return circle * modulus * np.sqrt(radius)


class Elastic(NamedTuple):
    """A contact's coefficient [N/m^p], load [N], stiffness d(load)/dh [N/m] and stored energy [J]."""

    coefficient: float
    load: float
    stiffness: float
    energy: float


def elastic(coefficient, power: float, approach) -> Elastic:
    """The answer of c h^p to approaches [m]; load, stiffness and energy are zero for a gap; arrays broadcast.

    The energy is the integral of the load at constant coefficient (paper 1, section 4).
    """
    return Elastic(coefficient, *elementwise(_elastic, 3, (float(power),), coefficient, approach))


def loads_at(coefficient, power, depth):
    """Loads [N] at depths [m] >= 0; arrays broadcast."""
    return elastic(coefficient, power, depth).load


def energies_at(coefficient, power, depth):
    """Energies [J] stored at depths [m] >= 0; arrays broadcast."""
    return elastic(coefficient, power, depth).energy


def approaches_of_loads(coefficient, power, load):
    """Approaches [m] at loads [N] >= 0, the inverse of `loads_at`; arrays broadcast."""
    return (load / coefficient) ** (1.0 / power)


def greatest_approaches(coefficient, power, mass, speed):
    """Approaches [m] at which the energy of masses [kg] that meet at speeds [m/s] is stored; arrays broadcast."""
    return (0.5 * (power + 1.0) * mass * speed**2 / coefficient) ** (1.0 / (power + 1.0))


def carried_course(name: str, ratios) -> tuple[np.ndarray, np.ndarray]:
    """States m = 1 - (b/a)^2, K(m), E(m) (n, 3) of a law that carries them from step to step along P/Q (n,).

    They are solved for at the start. With them c (n,) [N/m^1.5] for Q = 1/m and E* = 1 Pa.
    """
    states, coefficients = np.empty((len(ratios), 3)), np.empty(len(ratios))
    _course(elasticity(name, 1.0, 0.0).number, len(ratios), ratios, states, coefficients)
    return states, coefficients


def coefficient_from_circle(name: str, curvature_small: float, curvature_large: float, modulus: float):
    """c [N/m^1.5] of a law whose states are carried from a circle to P and Q [1/m], ln(P/Q) by 74 equal steps.

    Relative error with projection below 1e-9 for b/a above 1e-4, 2e-6 at 1e-6.
    """
    _, coefficients = carried_course(name, np.geomspace(1.0, curvature_small / curvature_large, 75))
    return float(coefficients[-1]) * modulus / math.sqrt(curvature_large)


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
    return tuple(elementwise(_elliptic, 2, (), complementary))


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

    NaN when the curvatures are not 0 < P <= Q; below b/a = 1e-6 the answer is still returned and `AXIS_RATIO_MIN` says
    whether to trust it.
    """
    return elementwise(_axis_ratios, 1, (), curvature_small, curvature_large)[0]


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
    return Ellipse(*elementwise(_ellipses, 3, (), curvature_small, curvature_large, effective_modulus, normal_load))
