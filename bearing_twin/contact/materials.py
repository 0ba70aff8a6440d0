"""Materials by name: steel is hardened bearing steel 100Cr6, aluminium 6061-T6; what a pair of them amounts to.

Aluminium has the typical values of the Aluminum Association, rounded. Steel and silicon nitride have no single source:
they lie within what makers print, whose moduli differ by some per cent.
"""

from dataclasses import dataclass

from bearing_twin.base.parameters import quantity

SHEETS = "no source: steel's is within what makers print, rubber's is paper 3's"


@dataclass(frozen=True)
class Material:
    """A homogeneous isotropic linear-elastic material."""

    young_modulus: float = quantity(2.075e11, "Pa", f"Young's modulus; {SHEETS}", above=0.0)
    poisson_ratio: float = quantity(0.3, "1", f"Poisson's ratio; {SHEETS}", above=-1.0, below=0.5)
    density: float = quantity(7850.0, "kg/m^3", f"mass density; {SHEETS}", above=0.0)
    yield_strength: float = quantity(
        2.0e9,
        "Pa",
        f"uniaxial yield strength; a contact yields from 1.6 times it on; 0 = not known; {SHEETS}",
        at_least=0.0,
    )
    thermal_expansion: float = quantity(1.15e-5, "1/K", f"linear thermal expansion; {SHEETS}", at_least=0.0)


YIELD_ONSET = 1.6
"""Peak pressure over yield strength at which a Hertz contact begins to yield (Johnson, Contact Mechanics, 6.1)."""

MATERIALS = {
    "steel": Material(2.075e11, 0.3, 7850.0, 2.0e9, 1.15e-5),
    "silicon_nitride": Material(3.1e11, 0.27, 3250.0, 0.0, 3.2e-6),
    "aluminium": Material(7.0e10, 0.33, 2700.0, 2.8e8, 2.36e-5),
}


def yield_pressure(*materials: Material) -> float | None:
    """Peak pressure [Pa] of first yield between these bodies, that of the weaker one; None where none is known."""
    known = [material.yield_strength for material in materials if material.yield_strength > 0.0]
    return YIELD_ONSET * min(known) if known else None


def compliance(material: Material) -> float:
    """Compliance of a body in contact, (1 - nu^2)/E [1/Pa]."""
    return (1.0 - material.poisson_ratio**2) / material.young_modulus


def effective_modulus(first: Material, second: Material) -> float:
    """E* [Pa] of two bodies in contact: 1/E* = sum of (1 - nu^2)/E (paper 1's theta is (1 - nu^2)/(pi E))."""
    return 1.0 / (compliance(first) + compliance(second))
