"""The row of soft discs in the table of kinds, and the quantities of its studies."""

from bearing_twin.kinds.contract import Kind, figure_quantities, parts_in
from bearing_twin.kinds.soft_discs.parameters import SoftDiscsScene

HERE = "bearing_twin.kinds.soft_discs"
QUANTITIES = figure_quantities(
    *("contact_duration_s", "peak_force_n", "peak_time_s", "impulse_ns", "restitution", "greatest_penetration_m"),
    "least_stretch",
)


SOFT_DISCS = Kind(
    name="soft_discs",
    help="a soft disc on a rigid wall, or two soft discs, by finite elasticity",
    parameters=SoftDiscsScene,
    brief=True,
    quantities=lambda: QUANTITIES,
    **parts_in(
        HERE,
        topics="display:topics",
        view="display:view",
        choose="derived:choose",
        motion="motion:motion",
        channels="motion:channels",
        records="figures:TABLES",
        meanings="figures:MEANINGS",
        comparison="figures:SoftDiscComparison",
        figures="figures:SoftDiscFigures",
        model_errors="figures:SoftDiscModelErrors",
        picture="picture:SoftDiscPicture",
    ),
)
