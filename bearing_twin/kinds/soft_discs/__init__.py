"""Soft discs: their row in the table of kinds, and the quantities of their studies.

* `derived`: the mesh that a tolerance needs, `divisions_of`.
"""

from bearing_twin.kinds.contract import Kind, figure_quantities, parts_in
from bearing_twin.kinds.soft_discs.parameters import SoftDiscsScene

HERE = "bearing_twin.kinds.soft_discs"
QUANTITIES = figure_quantities(
    *("contact_duration_s", "peak_force_n", "peak_time_s", "impulse_ns", "restitution", "greatest_penetration_m"),
    "least_stretch",
)


MEANINGS = {
    "peak_force_n": "contact force on the whole disc, greatest over all steps of the whole motion",
    "peak_time_s": "when the force is greatest, since the first touch",
    "contact_duration_s": "from first touch to last contact, gaps included",
    "impulse_ns": "of the contact force, sum over the whole motion",
    "restitution": "velocity of the centre of mass away from the wall over that before, after the last contact; of two "
    "discs in the frame of both",
    "greatest_penetration_m": "depth of the rim below the wall, or overlap of two unequal discs, which the penalty "
    "allows, greatest in the whole motion",
    "energy_closure": "energy gained (+) or lost (-) by the method as a share of what was brought, greatest ever",
    "least_stretch": "least principal stretch in the plane of the disc, anywhere in the whole motion",
    "force_balance": "greatest difference of the force as sum of pressures and as integral of density * acceleration, "
    "of either disc, over the peak force, whole motion",
    "touches": "how often the disc touched the wall in the whole motion",
    "wall_speed_m_s": "speed of the disc towards the wall at the first touch; of two discs in the frame of both",
}

SOFT_DISCS = Kind(
    name="soft_discs",
    help="a soft disc on a rigid wall, or two soft discs, by finite elasticity",
    parameters=SoftDiscsScene,
    brief=True,
    meanings=lambda: MEANINGS,
    quantities=lambda: QUANTITIES,
    **parts_in(
        HERE,
        topics="display:topics",
        view="display:view",
        choose="derived:choose",
        motion="motion:motion",
        channels="motion:channels",
        records="figures:TABLES",
        comparison="figures:SoftDiscComparison",
        figures="figures:SoftDiscFigures",
        model_errors="figures:SoftDiscModelErrors",
        picture="picture:SoftDiscPicture",
    ),
)
