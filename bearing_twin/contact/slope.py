"""How the coefficient of a law follows the gap's larger curvature: what exact derivatives of a load need."""

import math

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.elasticity import follows, fresh_coefficient, in_lanes
from bearing_twin.contact.ellipse import HERTZ_DENOMINATOR, HERTZ_NUMERATOR, HERTZ_U_MAX

STEP = 1e-5  # relative, of the difference for laws that are looked up: off by its square


@inlined
def _polynomial(coefficients, x):
    """A polynomial of degree 7 and its derivative."""
    a = coefficients
    value = a[0] + x * (a[1] + x * (a[2] + x * (a[3] + x * (a[4] + x * (a[5] + x * (a[6] + x * a[7]))))))
    slope = a[1] + x * (
        2.0 * a[2] + x * (3.0 * a[3] + x * (4.0 * a[4] + x * (5.0 * a[5] + x * (6.0 * a[6] + x * 7.0 * a[7]))))
    )
    return value, slope


@inlined
def hertz_and_slope(curvature_small, curvature_large, effective_modulus):
    """`ellipse.hertz_rational` c [N/m^1.5] and its exact derivative dc/dQ by the larger curvature Q."""
    small, large = curvature_small, curvature_large
    g = math.sqrt(small * large)
    total = small + large + 2.0 * g
    shape = (small + large - 2.0 * g) / total
    bend = g / large
    by_large = ((1.0 - bend) - shape * (1.0 + bend)) / total
    if shape > HERTZ_U_MAX:
        shape, by_large = HERTZ_U_MAX, 0.0
    p, p_slope = _polynomial(HERTZ_NUMERATOR, shape)
    q, q_slope = _polynomial(HERTZ_DENOMINATOR, shape)
    coefficient = effective_modulus * p / (q * math.sqrt(g))
    return coefficient, coefficient * ((p_slope / p - q_slope / q) * by_large - 0.25 / large)


@kernel
def _looked_up(law, curvature_small, curvature_large):
    """As `coefficient_and_slope`, for laws that are not evaluated in lanes."""
    coefficient = fresh_coefficient(law, curvature_small, curvature_large)
    if not follows(law):
        return coefficient, 0.0
    step = STEP * curvature_large
    above = fresh_coefficient(law, curvature_small, curvature_large + step)
    below = fresh_coefficient(law, curvature_small, curvature_large - step)
    return coefficient, 0.5 * (above - below) / step


@inlined
def coefficient_and_slope(law, curvature_small, curvature_large):
    """c [N/m^power] of a law (`elasticity.Elasticity`) and dc/dQ; by central differences where it is looked up."""
    if in_lanes(law):
        return hertz_and_slope(curvature_small, curvature_large, law.modulus)
    return _looked_up(law, curvature_small, curvature_large)
