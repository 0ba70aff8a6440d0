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
greater approach, which is NaN there; `deepest` is where it starts. Loads and energies at approaches are those of
`core/contact/laws.hpp`.

The impact of two equal discs by such a law: contact time by quadrature, vectorised over the discs.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.laws import LAWS, LINE_FORMULAS, law_names
from bearing_twin.core import INTEGER, REALS, REALS_OUT, Function, elementwise

_scales = Function("core_line_scales", None, (INTEGER, INTEGER, REALS, REALS, REALS_OUT))
_lambert_lower = Function("core_lambert_lower", None, (INTEGER, REALS, REALS_OUT))


class LineLaw(NamedTuple):
    """One law for one pair: `scale` = B e^s [m^2], `compliance` = V [1/Pa], `half_thickness` = a [m]."""

    scale: float
    compliance: float
    half_thickness: float


def line_law(name: str, radius, thickness, young_modulus, poisson_ratio) -> LineLaw:
    """The law of that name for two equal discs, `radius` and `thickness` = 2a in m; arrays broadcast."""
    if name not in LAWS or LAWS[name].fits != "line":
        raise ValueError(f"{name} is no law of line contact; legal: {', '.join(law_names('line', ()))}")
    half = 0.5 * thickness
    [scale] = elementwise(_scales, 1, (LINE_FORMULAS.index(LAWS[name].formula),), radius, half)
    compliance = (1.0 - poisson_ratio**2) / (math.pi * young_modulus)
    return LineLaw(scale, compliance, half)


def lambert_lower(x):
    """Branch -1 of Lambert's function, w exp(w) = x with w <= -1, for -1/e <= x < 0; NaN elsewhere, -inf at 0."""
    return elementwise(_lambert_lower, 1, (), x)[0]


def energy(law, load):
    """Energies [J] stored at loads [N]: the integral of F dx, (F V)^2 [ln(B e^s / (F V)) - 1/2] / (2 a V)."""
    product = np.asarray(load, float) * law.compliance
    with np.errstate(divide="ignore", invalid="ignore"):
        stored = product**2 * (np.log(law.scale / product) - 0.5) / (2.0 * law.half_thickness * law.compliance)
    return np.where(product > 0.0, stored, 0.0)[()]


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
    lower = lambert_lower(-ratio)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(ratio > 0.0, -ratio / lower, 0.0)
        return (np.sqrt(share * top) / law.compliance)[()]


def deepest(law):
    """Greatest approach [m] to which a load belongs: 8 a^2 / r by `line`, 8 r / e^2 by `johnson`."""
    return law.scale / (math.e * law.half_thickness)


def greatest_energy(law):
    """Energy [J] at which the law ends (see `deepest`)."""
    return law.scale**2 / (4.0 * math.e**2 * law.half_thickness * law.compliance)


NODES = 48  # of the quadrature; the relative error is below 1e-13


def peak_force(law: LineLaw, reduced_mass, speed):
    """Greatest load [N], at which all kinetic energy is stored; NaN where the law has no such load."""
    return load_of_energy(law, 0.5 * reduced_mass * np.square(speed))


def contact_time(law: LineLaw, reduced_mass, speed, nodes: int = NODES):
    """Duration [s] of the contact, NaN where the law has no solution; law's fields, mass and speed broadcast.

    With the stored energy U = (mu v^2 / 2) sin^2(angle) and dx = dU / F,
    tau = 2 mu v * integral of sin(angle) / F over 0 .. pi/2. The integrand goes as sqrt(ln) near 0, which a double
    exponential change of variable makes harmless.
    """
    scale, compliance, half, reduced_mass, speed = np.broadcast_arrays(*map(np.asarray, (*law, reduced_mass, speed)))
    column = LineLaw(scale[..., None], compliance[..., None], half[..., None])
    angle, weight = _nodes(nodes)
    energy = 0.5 * (reduced_mass * speed**2)[..., None] * np.sin(angle) ** 2
    with np.errstate(divide="ignore"):  # a speed so small that its energy underflows: no load, an endless contact
        integral = np.sum(weight * np.sin(angle) / load_of_energy(column, energy), axis=-1)
    return (2.0 * reduced_mass * speed * integral)[()]


def greatest_approach(law: LineLaw, reduced_mass, speed):
    """Greatest approach [m] of the two centres."""
    return approach_of(law, peak_force(law, reduced_mass, speed))


def _nodes(count):
    """Angles in (0, pi/2) and weights of the tanh-sinh rule."""
    reach = 3.2
    u = np.linspace(-reach, reach, count)
    inner = 0.5 * math.pi * np.sinh(u)
    share = 1.0 / (1.0 + np.exp(-2.0 * inner))
    weight = 0.25 * math.pi * np.cosh(u) / np.cosh(inner) ** 2 * (u[1] - u[0])
    return 0.5 * math.pi * share, 0.5 * math.pi * weight
