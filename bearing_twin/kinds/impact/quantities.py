"""Quantities of studies of impacts; closed forms are imported when they are called."""

from bearing_twin.kinds.contract import Quantity, lazy_import, read_off


def impact_quantities(**closed) -> dict[str, Quantity]:
    """Quantities of any impact; closed forms by the quantity's name."""
    rows = {
        "contact_duration": Quantity("s", "total time in contact", read_off("contact_duration_s")),
        "peak_force": Quantity("N", "greatest contact force", read_off("peak_force_n")),
        "greatest_approach": Quantity("m", "greatest mutual approach", read_off("greatest_approach_m")),
        "impulse": Quantity("N s", "of the contact force, over all contacts", read_off("impulse_ns")),
        "restitution": Quantity("1", "relative speed away over relative speed before", read_off("restitution")),
    }
    return {name: row._replace(closed=closed.get(name)) for name, row in rows.items()}


def spheres() -> dict[str, Quantity]:
    """Quantities of two spheres."""
    return _pair("bearing_twin.contact.hertz_impact")


def discs() -> dict[str, Quantity]:
    """Quantities of two discs."""
    return _pair("bearing_twin.kinds.impact.disc_closed_form")


def _pair(forms: str) -> dict[str, Quantity]:
    """With closed forms from that module, handed (law or coefficient, reduced mass, speed)."""
    return impact_quantities(
        contact_duration=lazy_import(f"{forms}:contact_time"),
        peak_force=lazy_import(f"{forms}:peak_force"),
        greatest_approach=lazy_import(f"{forms}:greatest_approach"),
        impulse=lambda _, reduced_mass, speed: 2.0 * reduced_mass * speed,
    )
