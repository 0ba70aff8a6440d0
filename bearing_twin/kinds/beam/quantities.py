"""What a study may ask of a sphere on a beam; nothing here compiles."""

from bearing_twin.kinds.contract import Quantity, read_off
from bearing_twin.kinds.impact.quantities import impact_quantities


def quantities() -> dict[str, Quantity]:
    """What a study may ask of a sphere on a beam."""
    return {
        **impact_quantities(),
        "contacts": Quantity("1", "number of contacts", read_off("contact_count")),
        "peak_deflection": Quantity("m", "greatest deflection of the beam", read_off("peak_deflection_m"), whole=True),
        "peak_stress": Quantity("Pa", "greatest bending stress", read_off("peak_stress_pa"), whole=True),
        "velocity_after": Quantity(
            "m/s", "of the sphere at the end, positive along the blow", read_off("sphere_velocity_after_m_s")
        ),
    }
