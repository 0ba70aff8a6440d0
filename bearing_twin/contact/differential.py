"""The law `hertz_differential`: elliptic integrals and eccentricity carried along as states (paper 1, section 3).

While the curvatures of a contact change smoothly, K(c), E(c) and the root c of equation (8) can be integrated
instead of computed afresh. The integration is only neutrally stable: nothing pulls its errors back, so they grow with
time. `projected` removes them with one Newton step on (8) after each step; `follow` runs both forms.

The states are lost where the circle is crossed (C = P/Q turns back at 1 with a kink) and at a new contact: start
afresh there. A row of `laws.LAWS` names them by a `Carrier`; a motion that offers the law carries `Shape` along.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.ellipse import axis_ratio, elliptic_b_d

SERIES_BELOW = 0.05  # parameter: the differential equations of K and E are 0/0 at the circle
SERIES_TERMS = 16
GREATEST_PARAMETER = 1.0 - 1e-15


ROUND = 1e-3  # tuned: shape excess below which d ln(c)/d(shape) is that of the circle, 1/6
FRESH = 0.98  # tuned: C = P/Q above which the projected states are solved afresh: C turns back at 1 with a kink


class Shape(NamedTuple):
    """Shape of a contact ellipse: parameter m = 1 - (b/a)^2 (paper 1: c), and K(m), E(m) as carried along."""

    parameter: float
    first_kind: float
    second_kind: float


@kernel
def shape_of(curvature_small, curvature_large):
    """The shape solved afresh for 0 < P <= Q [1/m]; what the states start from."""
    ratio = axis_ratio(curvature_small, curvature_large)
    b, d = elliptic_b_d(ratio)
    return Shape((1.0 - ratio) * (1.0 + ratio), b + d, b + ratio * ratio * d)


@kernel
def _first_kind_series(parameter):
    """K and its first two derivatives by the power series, for a parameter near zero (also just below it)."""
    k, first, second = 0.0, 0.0, 0.0
    factor, power, one_less, two_less = 0.5 * math.pi, 1.0, 0.0, 0.0
    for n in range(SERIES_TERMS):
        k += factor * power
        first += n * factor * one_less
        second += n * (n - 1) * factor * two_less
        two_less, one_less, power = one_less, power, power * parameter
        factor *= ((2 * n + 1) / (2 * n + 2)) ** 2
    return k, first, second


@kernel
def first_kind_slopes(shape):
    """dK/dc and d2K/dc2 from the states: dK/dc = (E - (1-c) K)/(2 c (1-c)), the second from Legendre's equation."""
    c = shape.parameter
    if c < SERIES_BELOW:
        _, first, second = _first_kind_series(c)
        return first, second
    rest = c * (1.0 - c)
    first = (shape.second_kind - (1.0 - c) * shape.first_kind) / (2.0 * rest)
    return first, (0.25 * shape.first_kind - (1.0 - 2.0 * c) * first) / rest


@kernel
def shape_rates(shape, ratio_rate):
    """Rates of the states when C = P/Q changes at `ratio_rate` [1/s] (paper 1, section 3, after Theorem 1).

    (3/2 K'^2 - 1/2 K K'') dc/dt = K'^2 dC/dt, dK/dt = K' dc/dt, dE/dt = (E - K)/(2c) dc/dt.
    """
    first, second = first_kind_slopes(shape)
    rate = first * first * ratio_rate / (1.5 * first * first - 0.5 * shape.first_kind * second)
    if shape.parameter < SERIES_BELOW:  # (E - K)/(2c) = (1-c) K' - K/2
        slope = (1.0 - shape.parameter) * first - 0.5 * shape.first_kind
    else:
        slope = (shape.second_kind - shape.first_kind) / (2.0 * shape.parameter)
    return Shape(rate, first * rate, slope * rate)


@kernel
def projected(shape, ratio):
    """One Newton step on equation (8), K/(2K') - (1-c) = C, from the parameter carried; K and E anew at its end.

    The error left is the square of the one found; costs two evaluations of the integrals, against five for a solution.
    """
    c = min(max(shape.parameter, 0.0), GREATEST_PARAMETER)
    b, d = elliptic_b_d(math.sqrt(1.0 - c))
    here = Shape(c, b + d, b + (1.0 - c) * d)
    first, second = first_kind_slopes(here)
    slope = 1.5 - 0.5 * here.first_kind * second / (first * first)
    c = min(max(c - ((1.0 - c) * d / b - ratio) / slope, 0.0), GREATEST_PARAMETER)
    b, d = elliptic_b_d(math.sqrt(1.0 - c))
    return Shape(c, b + d, b + (1.0 - c) * d)


@kernel
def _d(shape):
    """D = (K - E)/c from the states."""
    if shape.parameter < SERIES_BELOW:
        first, _ = first_kind_slopes(shape)
        return shape.first_kind - 2.0 * (1.0 - shape.parameter) * first
    return (shape.first_kind - shape.second_kind) / shape.parameter


@kernel
def differential_coefficient(shape, curvature_small, effective_modulus):
    """c [N/m^1.5] of the load c h^1.5 from the states carried: (2 pi/3) E* K^(-3/2) sqrt(D/P), D = (K - E)/c."""
    k = shape.first_kind
    return (2.0 * math.pi / 3.0) * effective_modulus * math.sqrt(_d(shape) / (curvature_small * k * k * k))


@kernel
def log_slope(shape, curvature_small, shape_excess, effective_modulus, coefficient):
    """d ln(c)/d(shape) at constant sqrt(PQ), shape = (P + Q)/(2 sqrt(PQ)) = 1 + `shape_excess`, from the states.

    dU/dP = -F a^2/5 at constant h (work of the pressure on a change of the gap) and P a^2/h = D(m)/K(m).
    """
    if shape_excess < ROUND:
        return 1.0 / 6.0
    part = 1.5 * coefficient * shape.first_kind / (math.pi * effective_modulus)
    return (2.0 * part * part * curvature_small - 1.0) / (2.0 * shape_excess)


class Carrier(NamedTuple):
    """What a law does with states it carries: `begin(P, Q)`, `rates(shape, d(P/Q)/dt)`, `finish(shape, P/Q)` a step.

    `projects` says whether `finish` puts the states right.
    """

    begin: Callable
    rates: Callable
    finish: Callable
    projects: bool


@inlined
def _put_right(shape, ratio):
    return shape_of(ratio, 1.0) if ratio > FRESH else projected(shape, ratio)


@inlined
def _left(shape, ratio):
    return shape


@inlined
def _no_shape(curvature_small, curvature_large):
    return Shape(0.0, 0.0, 0.0)


@inlined
def _no_rates(shape, ratio_rate):
    return Shape(0.0, 0.0, 0.0)


PROJECTED = Carrier(shape_of, shape_rates, _put_right, True)
UNPROJECTED = Carrier(shape_of, shape_rates, _left, False)
NOTHING = Carrier(_no_shape, _no_rates, _left, False)
"""Of laws that carry no states."""


@inlined
def moved(shape, factor, rates):
    """The shape after `factor` [s] at these rates."""
    return Shape(
        shape.parameter + factor * rates.parameter,
        shape.first_kind + factor * rates.first_kind,
        shape.second_kind + factor * rates.second_kind,
    )


@kernel
def follow(ratios, ratio_rates, step, project):
    """States (n + 1, 3) carried by the classical Runge-Kutta method over n steps [s] along a history of C = P/Q.

    `ratios` and their time derivatives `ratio_rates` (2 n + 1,) are at the ends and middles of the steps. With
    `project` each step ends with `projected`, otherwise the errors are left to grow.
    """
    count = len(ratios) // 2
    states = np.empty((count + 1, 3))
    shape = shape_of(ratios[0], 1.0)
    for k in range(count + 1):
        states[k, 0], states[k, 1], states[k, 2] = shape
        if k == count:
            break
        start, middle, end = ratio_rates[2 * k], ratio_rates[2 * k + 1], ratio_rates[2 * k + 2]
        k1 = shape_rates(shape, start)
        k2 = shape_rates(moved(shape, 0.5 * step, k1), middle)
        k3 = shape_rates(moved(shape, 0.5 * step, k2), middle)
        k4 = shape_rates(moved(shape, step, k3), end)
        shape = moved(moved(shape, step / 6.0, k1), step / 3.0, k2)
        shape = moved(moved(shape, step / 3.0, k3), step / 6.0, k4)
        if project:
            shape = projected(shape, ratios[2 * k + 2])
    return states


def coefficient_from_circle(
    curvature_small: float, curvature_large: float, effective_modulus: float, steps: int = 64, project: bool = True
):
    """c [N/m^1.5] of the load c h^1.5 with the states carried from a circle to P and Q [1/m], ln(P/Q) at a steady rate.

    With `project` each step is projected; relative error below 1e-9 for b/a above 1e-4, 1e-6 at 1e-6.
    """
    target = math.log(curvature_small / curvature_large)
    ratios = np.exp(target * np.linspace(0.0, 1.0, 2 * steps + 1))
    states = follow(ratios, target * ratios, 1.0 / steps, project)
    return float(differential_coefficient(Shape(*states[-1]), curvature_small, effective_modulus))
