"""The laws of contact, elastic and viscous; their formulas are `core/contact/laws.hpp`.

A law of a point contact says where the coefficient c of the load c h^p comes from, p = 1.5 being Hertz's power and
p = 1 a linear spring; a law of a line contact (paper 3, section 5.1) says the scale of `line.LineLaw`. To add a law,
write its formula in the core and give it a row in `LAWS`: scenes, help, the calculator, charts and tests then know it.
`elasticity` and `line` compute with them.

The viscous part d(h) dh/dt follows from the restitution. Two laws, both with d(h) -> 0 as h -> 0 (paper 1, section 5),
for the elastic load c h^1.5 and a reduced mass m:

* Hunt and Crossley: d(h) = chi c h^1.5. Its restitution falls with speed: e depends on chi v alone.
* Steady, after Tsuji, Tanaka and Ishida (Powder Technology 71, 1992): d(h) = d h^(1/4). With s = (2/sqrt 5) h^(5/4) it
  is a linear oscillator in s, so its restitution is the same at every speed.
"""

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import NamedTuple

from bearing_twin.base.errors import SceneError

HERTZIAN = 1.5
"""Power of a point contact between smooth curved bodies."""

FORMULAS = ("hertz", "hertz_exact", "volumetric", "given", "carried", "carried_left")
LINE_FORMULAS = ("puttock", "johnson")
"""Formulas of the rows of point and of line contacts: PointLaw and LineLaw of the core."""

MEASURED = {"stiffness": ("stiffness", "N/m"), "alpha": ("measured_alpha", "s (m/s)^0.2")}
"""Numbers of a law that only the user knows: their keys in `contact` and units."""


@dataclass(frozen=True)
class Law:
    """One elastic law.

    `fits`: "point", whose `formula` is one of FORMULAS, or "line", one of LINE_FORMULAS. `needs` names what must be
    known: curvatures; frozen (a contact whose coefficient is kept); stiffness, alpha (measured by the user); state (the
    elliptic integrals carried from step to step, paper 1, section 3). `power` is that of the approach. `circle` is
    c/(E* sqrt R) in closed form between spheres, R = R1 R2/(R1 + R2), if known.
    """

    name: str
    help: str
    fits: str
    needs: tuple[str, ...]
    formula: str
    power: float = HERTZIAN
    circle: float | None = None

    @property
    def follows(self) -> bool:
        """True if the coefficient follows the curvatures."""
        return "curvatures" in self.needs

    @property
    def carries(self) -> bool:
        """True if the law carries states."""
        return "state" in self.needs

    @property
    def keeps(self) -> bool:
        """True if the coefficient follows the curvatures and errors do not grow: an error warrants a warning."""
        return self.follows and self.formula != "carried_left"

    @property
    def measured(self) -> bool:
        """True if a number of the user's takes the place of Hertz's theory, so that no error is known."""
        return bool(MEASURED.keys() & set(self.needs))

    def number(self, contact, frozen: float) -> float:
        """The number that the law is given: of the scene's section `contact` what the user measured, else `frozen`."""
        return contact.stiffness if "stiffness" in self.needs else frozen


_ROWS = (
    Law(
        name="hertz",
        help="Hertz's theory by a rational function, exact to 1e-10; solved exactly for ellipses below b/a = 0.01",
        fits="point",
        needs=("curvatures",),
        formula="hertz",
        circle=4.0 / 3.0,
    ),
    Law(
        name="hertz_exact",
        help="Hertz's theory solved for the ellipse at every evaluation",
        fits="point",
        needs=("curvatures",),
        formula="hertz_exact",
        circle=4.0 / 3.0,
    ),
    Law(
        name="volumetric",
        help="the volumetric law of paper 1: within 0.5 % of Hertz for b/a above 0.063",
        fits="point",
        needs=("curvatures",),
        formula="volumetric",
    ),
    Law(
        name="constant",
        help="Hertz's coefficient frozen at the contact the scene starts from",
        fits="point",
        needs=("frozen",),
        formula="given",
    ),
    Law(
        name="hertz_differential",
        help="Hertz's theory, its elliptic integrals carried as states and projected after each step (paper 1)",
        fits="point",
        needs=("curvatures", "state"),
        formula="carried",
    ),
    Law(
        name="hertz_unprojected",
        help="the same without the projection: its errors accumulate",
        fits="point",
        needs=("curvatures", "state"),
        formula="carried_left",
    ),
    Law(
        name="linear",
        help="a linear spring of the stiffness specified",
        fits="point",
        needs=("stiffness",),
        formula="given",
        power=1.0,
    ),
    Law(
        name="measured",
        help="the coefficient that gives the contact time measured on two spheres",
        fits="point",
        needs=("alpha",),
        formula="given",
    ),
    Law(
        name="line",
        help="eq. (14) of paper 3, after Puttock and Thwaite",
        fits="line",
        needs=(),
        formula="puttock",
    ),
    Law(
        name="johnson",
        help="plane strain, for discs as thick as their radius and more (Johnson, Contact Mechanics, section 5.6)",
        fits="line",
        needs=(),
        formula="johnson",
    ),
)
LAWS = {row.name: row for row in _ROWS}
"""Every law by name, in order."""


def law_names(fits: str, known: Collection[str]) -> tuple[str, ...]:
    """Names of the laws of a contact that `fits` "point" or "line", which need no more than the `known` numbers."""
    return tuple(row.name for row in _ROWS if row.fits == fits and set(row.needs) <= set(known))


def numbers_missing(contact) -> list[str]:
    """Problems of measured numbers in a scene's section `contact`: one that the law needs, or one that no law takes."""
    problems, needs = [], LAWS[contact.normal].needs if contact.normal in LAWS else ()
    for need, (key, unit) in MEASURED.items():
        value = getattr(contact, key, 0.0)
        laws = " or ".join(row.name for row in _ROWS if need in row.needs)
        if need in needs and not value > 0.0:
            problems.append(f"contact.normal = {contact.normal} needs contact.{key} in {unit}; give one above zero")
        if need not in needs and value > 0.0:
            problems.append(f"contact.{key} = {value:g} {unit} needs contact.normal: {laws}; else leave it out")
    return problems


SERIES_BELOW = 0.05  # chi v: the logarithms cancel to its square, so their series is summed instead


class Shortcut(NamedTuple):
    """Result of an approximate formula: `damping` [s/m] for a restitution, and the restitution that it yields."""

    damping: float
    restitution: float


def _root(function, low, high, **tolerances) -> float:
    """A root by Brent's method; SciPy's, whose import takes as long as a short run, at the first call."""
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
