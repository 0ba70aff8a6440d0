"""The elastic laws of one contact: curvatures and approach in, normal load out.

Every law here has the form  load = coefficient * approach^1.5;  `LAWS` names them, `load_coefficient` is the one
place that chooses. To add a law, write its coefficient as a function and give it a row in `LAWS` and a branch in
`load_coefficient`; scenes, tests and the command line then know it.
"""

import math

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.ellipse import elliptic_b_d, hertz_coefficient

HERTZ, HERTZ_EXACT, VOLUMETRIC, CONSTANT = range(4)
LAWS = {"hertz": HERTZ, "hertz_exact": HERTZ_EXACT, "volumetric": VOLUMETRIC, "constant": CONSTANT}

# Fitted by `python -m bearing_twin.reference.fit_hertz`; relative error below 1e-10 for b/a in [0.01, 1].
HERTZ_NUMERATOR = (
    0.9428090415108946,
    -2.2748176815803363,
    0.9378562259855627,
    1.6040560661961734,
    -1.5922300284502826,
    0.33038099553435757,
    0.07054558921003161,
    -0.018492343366157776,
)
HERTZ_DENOMINATOR = (
    1.0,
    -2.7461418617107927,
    1.7064242073744869,
    1.5252752099605271,
    -2.226158010720357,
    0.7560290750065166,
    0.01298585635130083,
    -0.028403177407893734,
)
HERTZ_U_MAX = 0.9144848400609057


@inlined
def shape_variable(curvature_small, curvature_large):
    """u = (P+Q-2g)/(P+Q+2g), g = sqrt(PQ): 0 for a circle, towards 1 for a line; even in ln(P/Q)."""
    g = math.sqrt(curvature_small * curvature_large)
    total = curvature_small + curvature_large
    return (total - 2.0 * g) / (total + 2.0 * g)


@inlined
def hertz_rational(curvature_small, curvature_large, effective_modulus):
    """Hertz coefficient [N/m^1.5] by a rational function, within 1e-10 of `hertz_coefficient` for b/a in [0.01, 1].

    The exact coefficient is even in ln(P/Q), hence a smooth function of `shape_variable`. The quotient has poles just
    outside the fitted range, so u stops at its end: narrower ellipses need `load_coefficient`, which looks first.
    """
    n, d = HERTZ_NUMERATOR, HERTZ_DENOMINATOR
    u = min(shape_variable(curvature_small, curvature_large), HERTZ_U_MAX)
    p = n[0] + u * (n[1] + u * (n[2] + u * (n[3] + u * (n[4] + u * (n[5] + u * (n[6] + u * n[7]))))))
    q = d[0] + u * (d[1] + u * (d[2] + u * (d[3] + u * (d[4] + u * (d[5] + u * (d[6] + u * d[7]))))))
    return effective_modulus * p / (q * math.sqrt(math.sqrt(curvature_small * curvature_large)))


@kernel
def volumetric_coefficient(curvature_small, curvature_large, effective_modulus):
    """Coefficient [N/m^1.5] of the volumetric law, paper 1, eq. (9) with the square root over E(c1) restored.

    c = 0.357469 (2/3) sqrt(E(c1)) / ((thetaA + thetaB) P^(3/8) Q^(1/8)), c1 = 1 - P/Q, thetaA + thetaB = 1/(pi E*).
    Against exact Hertz: -0.48 % for a circle, +0.46 % at b/a = 0.14, -0.8 % at 0.055, -6.7 % at 0.015 and falling;
    no limit is enforced here, `fidelity` weighs the error.
    """
    kc = math.sqrt(curvature_small / curvature_large)
    b, d = elliptic_b_d(kc)
    second_kind = b + kc * kc * d
    return (
        0.357469
        * (2.0 / 3.0)
        * math.pi
        * effective_modulus
        * math.sqrt(second_kind)
        / (curvature_small**0.375 * curvature_large**0.125)
    )


@kernel
def load_coefficient(law, curvature_small, curvature_large, effective_modulus, constant):
    """c [N/m^1.5] of `load = c * approach^1.5` by the law's number in `LAWS`; `constant` is what the law constant uses.

    The law constant freezes c at one geometry (paper 1, section 5, after Lee et al. 2007): right only while the
    curvatures stay what they were there.
    """
    if law == HERTZ and shape_variable(curvature_small, curvature_large) <= HERTZ_U_MAX:
        return hertz_rational(curvature_small, curvature_large, effective_modulus)
    if law == VOLUMETRIC:
        return volumetric_coefficient(curvature_small, curvature_large, effective_modulus)
    if law in (HERTZ, HERTZ_EXACT):
        return hertz_coefficient(curvature_small, curvature_large, effective_modulus)
    return constant


@inlined
def elastic_load(coefficient, approach):
    """Elastic normal load [N]; zero for a gap."""
    depth = max(approach, 0.0)
    return coefficient * depth * math.sqrt(depth)


@inlined
def elastic_stiffness(coefficient, approach):
    """d(load)/d(approach) [N/m]; zero for a gap."""
    return 1.5 * coefficient * math.sqrt(max(approach, 0.0))


@inlined
def elastic_energy(coefficient, approach):
    """Energy [J] stored in a contact, the integral of `elastic_load` at constant coefficient (paper 1, section 4)."""
    depth = max(approach, 0.0)
    return 0.4 * coefficient * depth * depth * math.sqrt(depth)
