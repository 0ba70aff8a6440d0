"""Bodies that collide: spheres and discs on a line, an ellipsoid on a plane, any two bodies with implicit surfaces.

The rows of their kinds in the table of kinds, and the quantities of their studies.
"""

from bearing_twin.kinds.bodies.parameters import (
    HERE,
    EllipsoidOnPlaneScene,
    TwoBodiesScene,
    TwoDiscsScene,
    TwoSpheresScene,
)
from bearing_twin.kinds.contract import Kind, Quantity, figure_quantities, lazy_import, parts_in


def impact_quantities(**closed) -> dict[str, Quantity]:
    """Quantities of any impact; closed forms by the quantity's name."""
    rows = figure_quantities("contact_duration_s", "peak_force_n", "greatest_approach_m", "impulse_ns", "restitution")
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
ELLIPSOID_QUANTITIES = figure_quantities(
    *("contact_duration_s", "peak_force_n", "greatest_approach_m", "restitution", "peak_pressure_pa"),
    *("dissipated_viscous_j", "dissipated_friction_j"),
) | {"contacts": Quantity(("contact_count",))}
PAIR_QUANTITIES = ELLIPSOID_QUANTITIES | figure_quantities("held_work_j")


def _row(name: str, help: str, parameters: type, quantities, **parts: str) -> Kind:
    row = {"name": name, "help": help, "parameters": parameters, "quantities": quantities}
    return Kind(brief=True, **row, **parts_in(HERE, **parts))


OF_IMPACT = {
    "channels": "impact:CHANNELS", "records": "figures:OF_IMPACT", "figures": "figures:PairFigures",
    "meanings": "figures:MEANINGS",
    "comparison": "model_errors:ImpactComparison", "picture": "picture:PairPicture", "view": "display:impact_view",
}  # fmt: skip
OF_BOUNCING = {
    "choose": "derived:choose_bouncing", "figures": "figures:BouncingFigures",
    "comparison": "model_errors:ContactComparison", "model_errors": "model_errors:BouncingErrors",
    "picture": "picture:BouncingPicture", "view": "display:bouncing_view",
}  # fmt: skip

TWO_SPHERES = _row(
    "two_spheres",
    "central impact of two elastic spheres, without gravity",
    TwoSpheresScene,
    choose="derived:choose_spheres",
    motion="impact:spheres",
    model_errors="model_errors:SphereErrors",
    quantities=lambda: SPHERE_QUANTITIES,
    topics="display:sphere_topics",
    **OF_IMPACT,
)
TWO_DISCS = _row(
    "two_discs",
    "central impact of two equal discs in line contact, without gravity",
    TwoDiscsScene,
    choose="derived:choose_discs",
    motion="impact:discs",
    model_errors="model_errors:DiscErrors",
    quantities=lambda: DISC_QUANTITIES,
    topics="display:disc_topics",
    **OF_IMPACT,
)
ELLIPSOID_ON_PLANE = _row(
    "ellipsoid_on_plane",
    "an ellipsoid falls on a plane, bounces, slides and rocks under gravity",
    EllipsoidOnPlaneScene,
    motion="motion:EllipsoidMotion",
    channels="motion:ELLIPSOID_CHANNELS",
    records="figures:OF_ELLIPSOID",
    meanings="figures:MEANINGS_OF_ELLIPSOID",
    quantities=lambda: ELLIPSOID_QUANTITIES,
    topics="display:ellipsoid_topics",
    **OF_BOUNCING,
)
TWO_BODIES = _row(
    "two_bodies",
    "two bodies of any smooth shape bounce, roll and spin on each other",
    TwoBodiesScene,
    motion="motion:PairMotion",
    channels="motion:PAIR_CHANNELS",
    records="figures:OF_PAIR",
    meanings="figures:MEANINGS_OF_PAIR",
    quantities=lambda: PAIR_QUANTITIES,
    topics="display:body_topics",
    **OF_BOUNCING,
)
