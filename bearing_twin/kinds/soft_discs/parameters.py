"""Soft discs: YAML keys, units, defaults and limits."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

from dataclasses import dataclass

from bearing_twin.base.parameters import choice, quantity, section
from bearing_twin.contact.materials import Material
from bearing_twin.kinds.contract import SceneParameters, lazy_import
from bearing_twin.kinds.rules import facts_at
from bearing_twin.kinds.sections import LOOSEST, Checked, RunSettings, WantedImpact

DERIVED = "bearing_twin.kinds.soft_discs.derived"
RUBBER = Material(1.0e5, 0.25, 960.0, 0.0)
GREATEST_DIVISIONS = 512


@dataclass(frozen=True)
class SoftDisc:
    """The disc; of two equal ones, both."""

    radius: float = quantity(0.1, "m", "radius", above=0.0)
    thickness: float = quantity(0.01, "m", "along the disc's axis", above=0.0)
    material: Material = section(Material, default=RUBBER)


@dataclass(frozen=True)
class OtherDisc:
    """The other disc, with against: other_disc; as thick as the disc."""

    radius: float = quantity(0.1, "m", "radius", above=0.0)
    material: Material = section(Material, default=RUBBER)


@dataclass(frozen=True)
class Penalty:
    """The pressure between disc and wall: stiffness_ratio * young_modulus * (depth / radius)^exponent.

    Between two discs it is one at which the depths of both, each by its own modulus and radius, sum up to the overlap.
    """

    stiffness_ratio: float = quantity(
        10.0,
        "1",
        "k r / E: pressure over Young's modulus at a depth of one radius; paper 3 has k = 100 E",
        above=0.0,
        at_most=1e4,
    )
    exponent: float = quantity(1.0, "1", "power m of the depth", at_least=1.0, at_most=4.0)


@dataclass(frozen=True)
class Approaching:
    """Motion of the disc at the start: it just touches and moves as a whole."""

    first_velocity: float = quantity(
        1.0, "m/s", "velocity of the disc towards the wall, or towards the other disc, which is at rest", above=0.0
    )


@dataclass(frozen=True)
class DiscMesh:
    """Mesh of quadrilaterals of half the disc."""

    divisions: int = quantity(
        0,
        "1",
        "N: about 1.5 N^2 intervals between nodes on half the disc; 0 = from the tolerance",
        at_least=0,
        at_most=GREATEST_DIVISIONS,
    )
    order: int = quantity(3, "1", "of the elements; 1 = bilinear, above = spectral", at_least=1, at_most=4)
    integration: str = choice(
        "selective",
        ("selective", "full"),
        "of the part with Lame's first parameter; full locks where Poisson's ratio comes near 0.5",
    )


@dataclass(frozen=True)
class CentralDifferences(Checked):
    """Integration of the disc in time."""

    step_share: float = quantity(
        0.5, "1", "step as a share of the bound on the stable one, penalty included", above=0.0, at_most=1.0
    )


@dataclass(frozen=True)
class WantedOfDisc(WantedImpact):
    """Requested outputs and tolerance of a soft disc."""

    tolerance: float = quantity(
        2e-3,
        "1",
        "requested relative error of the force, root mean square over the contact",
        at_least=1e-4,
        at_most=LOOSEST,
        less="less than meshes that can be solved give",
    )


@dataclass(frozen=True)
class SoftDiscsScene(SceneParameters):
    """A soft disc on a rigid wall, or two soft discs, by finite elasticity (paper 3, section 5.2), without gravity."""

    disc: SoftDisc = section(SoftDisc)
    against: str = choice(
        "wall",
        ("wall", "disc", "other_disc"),
        "what the disc meets: a rigid wall without friction, an equal disc at rest, or the disc `other` at rest",
    )
    other: OtherDisc = section(OtherDisc)
    plane: str = choice("strain", ("strain", "stress"), "plane strain, or plane stress for a thin disc")
    formulation: str = choice(
        "stvk",
        ("stvk", "neo_hookean", "linear"),
        "stvk = St. Venant-Kirchhoff, which paper 3 takes; linear = small strains",
    )
    contact: Penalty = section(Penalty)
    motion: Approaching = section(Approaching)
    mesh: DiscMesh = section(DiscMesh)
    solver: CentralDifferences = section(CentralDifferences)
    wanted: WantedOfDisc = section(WantedOfDisc)
    run: RunSettings = section(RunSettings)

    facts = facts_at(f"{DERIVED}:speed_share", f"{DERIVED}:thickness_over_radius", f"{DERIVED}:poisson_ratio_in_strain")
    check = lazy_import(f"{DERIVED}:check")
    resolve = lazy_import(f"{DERIVED}:resolve")
