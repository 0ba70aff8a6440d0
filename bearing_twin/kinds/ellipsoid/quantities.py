"""Quantities of studies of an ellipsoid on a plane."""

from bearing_twin.kinds.contract import Quantity, read_off
from bearing_twin.kinds.impact.quantities import impact_quantities


def quantities() -> dict[str, Quantity]:
    """Quantities of an ellipsoid on a plane."""
    return {
        **{name: row for name, row in impact_quantities().items() if name != "impulse"},
        "contacts": Quantity("1", "number of contacts", read_off("contact_count")),
        "peak_pressure": Quantity("Pa", "greatest Hertz pressure", read_off("peak_pressure_pa")),
        "dissipated_viscous": Quantity("J", "lost to damping", read_off("dissipated_viscous_j")),
        "dissipated_friction": Quantity("J", "lost to friction", read_off("dissipated_friction_j")),
    }
