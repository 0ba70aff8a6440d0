"""Quantities of studies of bodies that collide: read without arrays, so that they are listed quickly."""

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


def pair_quantities(forms: str) -> dict[str, Quantity]:
    """Quantities of two spheres or discs, with closed forms of a module of `contact`.

    They are handed (law or coefficient, reduced mass, speed).
    """
    closed = {"contact_duration": "contact_time", "peak_force": "peak_force", "greatest_approach": "greatest_approach"}
    return impact_quantities(
        **{name: lazy_import(f"bearing_twin.contact.{forms}:{function}") for name, function in closed.items()},
        impulse=lambda _, reduced_mass, speed: 2.0 * reduced_mass * speed,
    )


SPHERE_QUANTITIES, DISC_QUANTITIES = pair_quantities("hertz_impact"), pair_quantities("line")
ELLIPSOID_QUANTITIES = {
    **{name: row for name, row in impact_quantities().items() if name != "impulse"},
    "contacts": Quantity("1", "number of contacts", read_off("contact_count")),
    "peak_pressure": Quantity("Pa", "greatest Hertz pressure", read_off("peak_pressure_pa")),
    "dissipated_viscous": Quantity("J", "lost to damping", read_off("dissipated_viscous_j")),
    "dissipated_friction": Quantity("J", "lost to friction", read_off("dissipated_friction_j")),
}
PAIR_QUANTITIES = ELLIPSOID_QUANTITIES | {"held_work": Quantity("J", "done on held bodies", read_off("held_work_j"))}
