"""The elastic laws: one table, one row a law, complete.

A law of a point contact says where the coefficient c of the load c h^p comes from; a law of a line contact (paper 3,
section 5.1) says the scale of `line.LineLaw`. To add a law, write its coefficient as a function and give it a row in
`LAWS`: scenes, help, the calculator, charts and tests then know it. `contact.elasticity` makes kernels from the table.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact import differential, line
from bearing_twin.contact.differential import Shape
from bearing_twin.contact.elastic import HERTZIAN
from bearing_twin.contact.ellipse import HERTZ_U_MAX, elliptic_b_d, hertz_coefficient, hertz_rational, shape_variable

# Numbers of the core, as PointLaw and LineLaw of core/contact/laws.hpp have them.
HERTZ, HERTZ_EXACT, VOLUMETRIC, GIVEN, CARRIED, CARRIED_LEFT = range(6)
PUTTOCK, JOHNSON = range(2)


class Place(NamedTuple):
    """What a law may ask for: the gap's curvatures P <= Q [1/m], E* [Pa], the number it was given, states carried."""

    curvature_small: float
    curvature_large: float
    modulus: float
    given: float
    shape: Shape


@inlined
def hertz(place):
    """c [N/m^1.5] of Hertz, by its rational form where that holds."""
    small, large, modulus = place.curvature_small, place.curvature_large, place.modulus
    if shape_variable(small, large) <= HERTZ_U_MAX:
        return hertz_rational(small, large, modulus)
    return hertz_coefficient(small, large, modulus)


@inlined
def hertz_exact(place):
    """c [N/m^1.5] of Hertz, solved for the ellipse."""
    return hertz_coefficient(place.curvature_small, place.curvature_large, place.modulus)


@kernel
def volumetric(place):
    """c [N/m^1.5] of the volumetric law, paper 1, eq. (9) with the square root over E(c1) restored.

    c = 0.357469 (2/3) sqrt(E(c1)) / ((thetaA + thetaB) P^(3/8) Q^(1/8)), c1 = 1 - P/Q, thetaA + thetaB = 1/(pi E*).
    Against exact Hertz: -0.48 % for a circle, +0.46 % at b/a = 0.14, -0.8 % at 0.055, -6.7 % at 0.015 and falling;
    no limit is enforced here, `fidelity` weighs the error.
    """
    kc = math.sqrt(place.curvature_small / place.curvature_large)
    b, d = elliptic_b_d(kc)
    second_kind = b + kc * kc * d
    return (
        0.357469
        * (2.0 / 3.0)
        * math.pi
        * place.modulus
        * math.sqrt(second_kind)
        / (place.curvature_small**0.375 * place.curvature_large**0.125)
    )


@inlined
def given_number(place):
    """The number the law was given: c [N/m^1.5], or a stiffness [N/m]."""
    return place.given


@inlined
def carried(place):
    """c [N/m^1.5] of Hertz from the elliptic integrals carried along as states."""
    return differential.differential_coefficient(place.shape, place.curvature_small, place.modulus)


@dataclass(frozen=True)
class Law:
    """One elastic law; `name`, `help`, `fits` and `needs` are written as literals, by keyword (`contact.names`).

    `fits`: "point", whose `coefficient(place)` is c [N/m^power]; or "line", whose `coefficient(radius, half_thickness)`
    is the scale [m^2] of `line.LineLaw`, numbers or arrays. `number_in_core`: of the
    core's `PointLaw` or `LineLaw`. `needs` names what must be known: curvatures; frozen (a
    contact whose coefficient is kept); stiffness, alpha (measured by the user); state. `circle` is c/(E* sqrt R)
    in closed form between spheres, R = R1 R2/(R1 + R2), if known. A law with a `state` carries three numbers from step
    to step.
    """

    name: str
    help: str
    fits: str
    needs: tuple[str, ...]
    number_in_core: int
    coefficient: Callable
    power: float = HERTZIAN
    circle: float | None = None
    state: differential.Carrier | None = None

    @property
    def follows(self) -> bool:
        """True if the coefficient follows the curvatures."""
        return "curvatures" in self.needs

    @property
    def keeps(self) -> bool:
        """True if the coefficient follows the curvatures and errors do not grow: an error warrants a warning."""
        return self.follows and (self.state is None or self.state.projects)

    @property
    def measured(self) -> bool:
        """True if a number of the user's takes the place of Hertz's theory, so that no error is known."""
        return bool({"stiffness", "alpha"} & set(self.needs))

    def number(self, contact, frozen: float) -> float:
        """The number that kernels are given: of the scene's section `contact` what the user measured, else `frozen`."""
        return contact.stiffness if "stiffness" in self.needs else frozen


_ROWS = (
    Law(
        name="hertz",
        help="Hertz's theory by a rational function, exact to 1e-10; solved exactly for ellipses below b/a = 0.01",
        fits="point",
        needs=("curvatures",),
        number_in_core=HERTZ,
        coefficient=hertz,
        circle=4.0 / 3.0,
    ),
    Law(
        name="hertz_exact",
        help="Hertz's theory solved for the ellipse at every evaluation",
        fits="point",
        needs=("curvatures",),
        number_in_core=HERTZ_EXACT,
        coefficient=hertz_exact,
        circle=4.0 / 3.0,
    ),
    Law(
        name="volumetric",
        help="the volumetric law of paper 1: within 0.5 % of Hertz for b/a above 0.063",
        fits="point",
        needs=("curvatures",),
        number_in_core=VOLUMETRIC,
        coefficient=volumetric,
    ),
    Law(
        name="constant",
        help="Hertz's coefficient frozen at the contact the scene starts from",
        fits="point",
        needs=("frozen",),
        number_in_core=GIVEN,
        coefficient=given_number,
    ),
    Law(
        name="hertz_differential",
        help="Hertz's theory, its elliptic integrals carried as states and projected after each step (paper 1)",
        fits="point",
        needs=("curvatures", "state"),
        number_in_core=CARRIED,
        coefficient=carried,
        state=differential.PROJECTED,
    ),
    Law(
        name="hertz_unprojected",
        help="the same without the projection: its errors grow without end",
        fits="point",
        needs=("curvatures", "state"),
        number_in_core=CARRIED_LEFT,
        coefficient=carried,
        state=differential.UNPROJECTED,
    ),
    Law(
        name="linear",
        help="a linear spring of the stiffness given",
        fits="point",
        needs=("stiffness",),
        number_in_core=GIVEN,
        coefficient=given_number,
        power=1.0,
    ),
    Law(
        name="measured",
        help="the coefficient that gives the contact time measured on two spheres",
        fits="point",
        needs=("alpha",),
        number_in_core=GIVEN,
        coefficient=given_number,
    ),
    Law(
        name="line",
        help="eq. (14) of paper 3, after Puttock and Thwaite",
        fits="line",
        needs=(),
        number_in_core=PUTTOCK,
        coefficient=line.puttock_scale,
    ),
    Law(
        name="johnson",
        help="plane strain, for discs as thick as their radius and more (Johnson, Contact Mechanics, section 5.6)",
        fits="line",
        needs=(),
        number_in_core=JOHNSON,
        coefficient=line.johnson_scale,
    ),
)
LAWS = {row.name: row for row in _ROWS}
"""Every law by name, in order."""


def line_law(name: str, radius, thickness, young_modulus, poisson_ratio) -> line.LineLaw:
    """The law of that name for two equal discs, `radius` and `thickness` = 2a in m; arrays broadcast."""
    if name not in LAWS or LAWS[name].fits != "line":
        legal = ", ".join(row.name for row in _ROWS if row.fits == "line")
        raise ValueError(f"{name} is no law of line contact; legal: {legal}")
    half = 0.5 * thickness
    compliance = (1.0 - poisson_ratio**2) / (math.pi * young_modulus)
    return line.LineLaw(LAWS[name].coefficient(radius, half), compliance, half)
