"""Line contact of two equal cylinders lying side by side: approach in, load out, and back.

Two laws of one form, with V = (1 - nu^2)/(pi E), half the thickness a and the radius r:

    x = (F V / a) [ln(B / (F V)) + s]

* `line` is paper 3, eq. (14), after Puttock and Thwaite: B = 8 a^3 / r, s = 1.
* `johnson` is Johnson, Contact Mechanics, section 5.6: B = 8 a r, s = -1, the two-dimensional (plane-strain) solution
  for the centres of the discs. For the discs of paper 3 (a = r) `line` gives contact times 14 % longer at 10 m/s and
  21 % longer at 100 m/s; for a < r/3 they are shorter.

x is the approach [m] of the two centres, > 0 in contact, F the load [N] over the whole thickness. With
y = F V / (B e^s) both read  x a / (B e^s) = -y ln y,  whose small-load branch is y = exp(W(-x a / (B e^s))), W the
branch -1 of Lambert's function. Beyond y = 1/e the printed laws would soften and turn back: no load belongs to a
greater approach, `load` returns NaN there and `deepest` tells where it starts.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import kernel


class LineLaw(NamedTuple):
    """One law for one pair: `scale` = B e^s [m^2], `compliance` = V [1/Pa], `half_thickness` = a [m]."""

    scale: float
    compliance: float
    half_thickness: float


def puttock_scale(radius, half_thickness):
    """`scale` [m^2] of the law `line`; arrays broadcast."""
    return 8.0 * half_thickness**3 / radius * math.e


def johnson_scale(radius, half_thickness):
    """`scale` [m^2] of Johnson's law; arrays broadcast."""
    return 8.0 * half_thickness * radius / math.e


@kernel
def lambert_lower(x):
    """Branch -1 of Lambert's function, w exp(w) = x with w <= -1, for -1/e <= x < 0; NaN elsewhere, -inf at 0.

    The series in p = -sqrt(2 (1 + e x)) near the branch point, logarithms near zero, then Halley's steps.
    """
    if x == 0.0:
        return -math.inf
    below = 1.0 + math.e * x
    if not (below >= -4e-16 and x < 0.0):
        return math.nan
    if below <= 0.0:
        return -1.0
    if below < 0.3:
        p = -math.sqrt(2.0 * below)
        w = -1.0 + p * (1.0 + p * (-1.0 / 3.0 + p * (11.0 / 72.0 + p * (-43.0 / 540.0 + p * 769.0 / 17280.0))))
        if below < 1e-6:
            return w
    else:
        first = math.log(-x)
        second = math.log(-first)
        w = first - second + second / first
    for _ in range(8):
        # f = w + ln(w/x) keeps its digits where exp(w) is tiny; Newton's step on it converges from both sides.
        step = (w + math.log(w / x)) * w / (w + 1.0)
        w -= step
        if abs(step) < 4e-16 * abs(w):
            break
    return w


@kernel
def _lambert_lower_of_each(x):
    w = np.empty_like(x)
    for k in range(x.size):
        w[k] = lambert_lower(x[k])
    return w


@kernel
def load(law, approach):
    """Load [N] at an approach [m]: zero for a gap, NaN beyond `deepest`."""
    if approach <= 0.0:
        return 0.0
    ratio = approach * law.half_thickness / law.scale
    # y = exp(W(-ratio)) = -ratio / W(-ratio), which keeps its digits.
    return -ratio / lambert_lower(-ratio) * law.scale / law.compliance


@kernel
def energy(law, load):
    """Energy [J] stored at a load [N]: the integral of F dx, (F V)^2 [ln(B e^s / (F V)) - 1/2] / (2 a V)."""
    if load <= 0.0:
        return 0.0
    product = load * law.compliance
    return product * product * (math.log(law.scale / product) - 0.5) / (2.0 * law.half_thickness * law.compliance)


def approach_of(law, load):
    """Approach [m] at a load [N]: paper 3, eq. (14), or Johnson's form. Arrays broadcast."""
    product = np.asarray(load, float) * law.compliance
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(product > 0.0, product / law.half_thickness * np.log(law.scale / product), 0.0)[()]


def load_of_energy(law, energy):
    """Load [N] that stores an energy [J], the inverse of `energy`; NaN beyond `greatest_energy`. Arrays broadcast.

    Y = (F V)^2 obeys -Y ln(Y/C) = 4 a V U with C = (B e^s)^2 / e: Lambert's function once more.
    """
    top = law.scale**2 / math.e
    ratio = np.asarray(4.0 * law.half_thickness * law.compliance * np.asarray(energy, float) / top)
    with np.errstate(divide="ignore", invalid="ignore"):
        lower = _lambert_lower_of_each(-ratio.ravel()).reshape(ratio.shape)
        share = np.where(ratio > 0.0, -ratio / lower, 0.0)
        return (np.sqrt(share * top) / law.compliance)[()]


def deepest(law):
    """Greatest approach [m] to which a load belongs: 8 a^2 / r by `line`, 8 r / e^2 by `johnson`."""
    return law.scale / (math.e * law.half_thickness)


def greatest_energy(law):
    """Energy [J] at which the law ends (see `deepest`)."""
    return law.scale**2 / (4.0 * math.e**2 * law.half_thickness * law.compliance)
