"""From the curvatures of the gap to the Hertz contact ellipse, without cancellation near the circle.

The gap of the undeformed bodies is z = P x^2 + Q y^2 with P = `curvature_small` <= Q = `curvature_large` [1/m]
(paper 1, eq. 6). The ellipse is longer along x. Its shape is carried as `axis_ratio` b/a in (0, 1]; the
parameter of the elliptic integrals is m = 1 - (b/a)^2 (paper 1 calls it c).

The usual formulas contain K - E and E - (1-m) K, which vanish with m; the integrals

    B(m) = int cos^2 / sqrt(1 - m sin^2),   D(m) = int sin^2 / sqrt(1 - m sin^2)   over (0, pi/2)

hold the same information without subtraction: K = B + D, E = B + (1-m) D, (K - E)/m = D.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel, plain
from bearing_twin.core import INTEGER, REALS, REALS_OUT, Function

AXIS_RATIO_MIN = 1e-6
"""Below this b/a the contact is a line for every practical purpose and is not treated as an ellipse."""

# The gap ratio Q/P at which b/a reaches AXIS_RATIO_MIN: B/((b/a)^2 D) with B = 1, D = ln(4 a/b) - 1.
CURVATURE_RATIO_MAX = 1.0 / (AXIS_RATIO_MIN**2 * (math.log(4.0 / AXIS_RATIO_MIN) - 1.0))


# Fitted by `python tests/reference/fit_hertz.py`; relative error below 1e-10 for b/a in [0.01, 1].
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

# Fitted by `python tests/reference/fit_hertz.py`: relative errors 2e-7 and 2e-8 for b/a in [0.01, 1].
AREA_NUMERATOR = (0.49999991209, -0.95732120387, 0.44434771413, 0.062350828905, -0.047733553948)
AREA_DENOMINATOR = (1.0, -1.6924362264, 0.48816393097, 0.31997884793, -0.11043047507)
SHAPE_NUMERATOR = (1.3333333116, -1.6914791831, 0.15902547538, 0.2661054997, -0.016034665480)
SHAPE_DENOMINATOR = (1.0, -0.93527794187, -0.32825535038, 0.28958575163, 0.024886995406)
W_MAX = 0.9562870071588894
SURE_STEP = 1e-8  # of ln(b/a): after a step of Newton's method that is no longer, less than rounding is left


class Ellipse(NamedTuple):
    """Contact ellipse of one loaded contact: semi-axes [m], a >= b, and the pressure [Pa] at its centre."""

    semi_major: float
    semi_minor: float
    peak_pressure: float


@plain
@kernel
def elliptic_b_d(complementary):
    """The complete elliptic integrals B(m) and D(m) as functions of kc = sqrt(1 - m) in (0, 1].

    Bulirsch's iteration for cel(kc, 1, a, b) (Numer. Math. 7, 1965), run for (a, b) = (1, 0) and (0, 1) together;
    converges quadratically, full precision for kc >= 1e-9.
    """
    kc = complementary
    product, mean, p = kc, 1.0, 1.0
    a_b, b_b = 1.0, 0.0
    a_d, b_d = 0.0, 1.0
    for _ in range(60):
        g = product / p
        a_b, b_b = a_b + b_b / p, 2.0 * (b_b + a_b * g)
        a_d, b_d = a_d + b_d / p, 2.0 * (b_d + a_d * g)
        p += g
        last = mean
        mean += kc
        if abs(last - kc) <= 1e-8 * last:
            break
        kc = 2.0 * math.sqrt(product)
        product = kc * mean
    scale = 0.5 * math.pi / (mean * (mean + p))
    return scale * (b_b + a_b * mean), scale * (b_d + a_d * mean)


@plain
@kernel
def curvature_ratio(axis_ratio):
    """Q/P of the gap whose contact ellipse has semi-axis ratio b/a in (0, 1] (paper 1, eq. 8, solved for P/Q)."""
    b, d = elliptic_b_d(axis_ratio)
    return b / (axis_ratio * axis_ratio * d)


@inlined
def _rational_shape(w):
    """(a - b)/(a + b) of the ellipse by a rational function of `_narrowness`, see `semi_axes`."""
    m, e, u = SHAPE_NUMERATOR, SHAPE_DENOMINATOR, w * w
    return w * (
        (m[0] + u * (m[1] + u * (m[2] + u * (m[3] + u * m[4]))))
        / (e[0] + u * (e[1] + u * (e[2] + u * (e[3] + u * e[4]))))
    )


@inlined
def _narrowness(curvature_small, curvature_large):
    """w = (sqrt Q - sqrt P)/(sqrt Q + sqrt P): 0 for a circle, towards 1 for a line."""
    p, q = math.sqrt(curvature_small), math.sqrt(curvature_large)
    return (q - p) / (q + p)


@plain
@kernel
def axis_ratio(curvature_small, curvature_large):
    """Semi-axis ratio b/a in (0, 1] of the contact ellipse, the unique root of paper 1, eq. (8) (Theorem 1).

    ln(Q/P) is a smooth, monotone, nearly straight function of x = ln(b/a) that passes through the origin with slope
    -3/2, so Newton's method in these variables converges in two steps from the rational function of `semi_axes`, and in
    a few from b/a = (P/Q)^0.64 where the ellipse is narrower; a bracket guards it. With k = b/a and
    t = (k^2 D - B)/(1 - k^2) the slope is -3 - t (1/B + 1/D). NaN when the curvatures are not 0 < P <= Q; below
    b/a = 1e-6 the answer is still returned and `AXIS_RATIO_MIN` tells whether to trust it.
    """
    if not 0.0 < curvature_small <= curvature_large:
        return math.nan
    target = math.log(curvature_large / curvature_small)
    if target < 1e-13:
        return 1.0
    low, high = -target, 0.0  # slope lies between -2 and -1.5, so the root does too: -target/1.5 .. -target/2
    w = _narrowness(curvature_small, curvature_large)
    shape = _rational_shape(w)
    x = math.log((1.0 - shape) / (1.0 + shape)) if w < W_MAX else -0.64 * target
    for _ in range(60):
        k = math.exp(x)
        b, d = elliptic_b_d(k)
        off, m = math.log(b / (k * k * d)) - target, (1.0 - k) * (1.0 + k)
        # Near a circle the difference has no digits left; there it is what it tends to, within m.
        t = (k * k * d - b) / m if m > 1e-6 else -3.0 * math.pi / 16.0
        if off > 0.0:
            low = x
        else:
            high = x
        step = off / (3.0 + t * (1.0 / b + 1.0 / d))
        if low <= x + step <= high:
            x += step
        else:
            step = 0.5 * (low + high) - x
            x += step
        if abs(step) <= SURE_STEP:
            break
    return math.exp(x)


@plain
@kernel
def hertz_coefficient(curvature_small, curvature_large, effective_modulus):
    """c [N/m^1.5] of the exact Hertz load c h^1.5 for approach h [m] (Hertz 1882; paper 1, eqs. 7-8).

    c = (2 pi/3) E* K^(-3/2) sqrt(D/P), for a circle 4/3 E* sqrt(R). NaN as `axis_ratio`.
    """
    b, d = elliptic_b_d(axis_ratio(curvature_small, curvature_large))
    k = b + d
    return (2.0 * math.pi / 3.0) * effective_modulus * math.sqrt(d / (curvature_small * k * k * k))


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
    outside the fitted range, so u stops at its end: narrower ellipses are for `hertz_coefficient`.
    """
    n, d = HERTZ_NUMERATOR, HERTZ_DENOMINATOR
    u = min(shape_variable(curvature_small, curvature_large), HERTZ_U_MAX)
    p = n[0] + u * (n[1] + u * (n[2] + u * (n[3] + u * (n[4] + u * (n[5] + u * (n[6] + u * n[7]))))))
    q = d[0] + u * (d[1] + u * (d[2] + u * (d[3] + u * (d[4] + u * (d[5] + u * (d[6] + u * d[7]))))))
    return effective_modulus * p / (q * math.sqrt(math.sqrt(curvature_small * curvature_large)))


@plain
@inlined
def semi_axes(curvature_small, curvature_large, approach):
    """Semi-axes [m] of the ellipse at this approach [m] by rational functions, within 1e-5 for b/a in [0.01, 1].

    With g = sqrt(PQ) and w = (sqrt Q - sqrt P)/(sqrt Q + sqrt P): a b g/h is even in ln(P/Q), hence a smooth function
    of u = w^2, and (a - b)/(a + b) is odd, w times one. Narrower ellipses keep the shape of the narrowest; zero for a
    gap. The size follows the approach, as the geometry does, also where a viscous part adds to the load.
    """
    n, d = AREA_NUMERATOR, AREA_DENOMINATOR
    w = min(_narrowness(curvature_small, curvature_large), W_MAX)
    u, shape = w * w, _rational_shape(w)
    product = (n[0] + u * (n[1] + u * (n[2] + u * (n[3] + u * n[4])))) / (
        d[0] + u * (d[1] + u * (d[2] + u * (d[3] + u * d[4])))
    )
    product *= max(approach, 0.0) / (math.sqrt(curvature_small) * math.sqrt(curvature_large))
    ratio = (1.0 - shape) / (1.0 + shape)
    semi_minor = math.sqrt(product * ratio)
    return semi_minor / ratio, semi_minor


@plain
@kernel
def ellipse(curvature_small, curvature_large, effective_modulus, normal_load):
    """Semi-axes [m] and peak pressure [Pa] of an elliptic Hertz contact under `normal_load` [N].

    a^3 = 3 F D / (2 pi E* P (b/a)), peak pressure 3F/(2 pi a b); all zero without load.
    """
    if normal_load <= 0.0:
        return Ellipse(0.0, 0.0, 0.0)
    ratio = axis_ratio(curvature_small, curvature_large)
    _, d = elliptic_b_d(ratio)
    semi_major = (1.5 * normal_load * d / (math.pi * effective_modulus * curvature_small)) ** (1.0 / 3.0)
    semi_minor = semi_major * ratio
    return Ellipse(semi_major, semi_minor, 1.5 * normal_load / (math.pi * semi_major * semi_minor))


def elliptic_e(complementary) -> np.ndarray:
    """The complete elliptic integral of the second kind, of arrays of sqrt(1 - m): by arithmetic-geometric means."""
    mean, other, power = np.ones_like(complementary), complementary, 0.5
    share = 1.0 - 0.5 * (1.0 - complementary**2)
    for _ in range(6):  # exact for b/a above 1e-6
        half, power = 0.5 * (mean - other), 2.0 * power
        mean, other = 0.5 * (mean + other), np.sqrt(mean * other)
        share = share - power * half**2
    return 0.5 * math.pi / mean * share


_ellipses = Function("core_ellipses", None, (INTEGER, *(REALS,) * 4, *(REALS_OUT,) * 3))


def ellipses(curvature_small, curvature_large, effective_modulus, normal_load) -> Ellipse:
    """As `ellipse`, of arrays of contacts that broadcast."""
    arrays = np.broadcast_arrays(curvature_small, curvature_large, effective_modulus, normal_load)
    given = [np.ascontiguousarray(one, float) for one in arrays]
    found = Ellipse(*(np.empty(arrays[0].shape) for _ in range(3)))
    _ellipses(arrays[0].size, *given, *found)
    return found
