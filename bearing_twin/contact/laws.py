"""The elastic laws of point and line contacts: one table, one row a law; their formulas are `core/contact/laws.hpp`.

A law of a point contact says where the coefficient c of the load c h^p comes from, p = 1.5 being Hertz's power and
p = 1 a linear spring; a law of a line contact (paper 3, section 5.1) says the scale of `line.LineLaw`. To add a law,
write its formula in the core and give it a row in `LAWS`: scenes, help, the calculator, charts and tests then know it.
`elasticity` and `line` compute with them.
"""

from collections.abc import Collection
from dataclasses import dataclass

HERTZIAN = 1.5
"""Power of a point contact between smooth curved bodies."""

FORMULAS = ("hertz", "hertz_exact", "volumetric", "given", "carried", "carried_left")
LINE_FORMULAS = ("puttock", "johnson")
"""What rows of point and of line contacts name: PointLaw and LineLaw of the core."""

MEASURED = {"stiffness": ("stiffness", "N/m"), "alpha": ("measured_alpha", "s (m/s)^0.2")}
"""What a law may need that only the user knows: the key of `contact` that gives it, and its unit."""


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
        help="the same without the projection: its errors grow without end",
        fits="point",
        needs=("curvatures", "state"),
        formula="carried_left",
    ),
    Law(
        name="linear",
        help="a linear spring of the stiffness given",
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


def law_names(fits: str, given: Collection[str]) -> tuple[str, ...]:
    """Names of the laws of a contact that `fits` "point" or "line", none of which needs more than is `given`."""
    return tuple(row.name for row in _ROWS if row.fits == fits and set(row.needs) <= set(given))


def numbers_missing(contact) -> list[str]:
    """What is wrong with the measured numbers of a scene's section `contact`: one its law needs, or one for no law."""
    problems, needs = [], LAWS[contact.normal].needs if contact.normal in LAWS else ()
    for need, (key, unit) in MEASURED.items():
        value = getattr(contact, key, 0.0)
        laws = " or ".join(row.name for row in _ROWS if need in row.needs)
        if need in needs and not value > 0.0:
            problems.append(f"contact.normal = {contact.normal} needs contact.{key} in {unit}; give one above zero")
        if need not in needs and value > 0.0:
            problems.append(f"contact.{key} = {value:g} {unit} needs contact.normal: {laws}; else leave it out")
    return problems
