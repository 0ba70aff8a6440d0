"""The row of soft discs in the table of kinds, and the quantities of its studies."""

from bearing_twin.kinds.contract import Kind, Quantity, parts_in, read_off
from bearing_twin.kinds.soft_discs.parameters import SoftDiscsScene

HERE = "bearing_twin.kinds.soft_discs"


def quantities() -> dict[str, Quantity]:
    """Each read off a figure; there are no closed forms."""
    return {
        "contact_duration": Quantity("s", "from first touch to last contact", read_off("contact_duration_s")),
        "peak_force": Quantity("N", "greatest contact force", read_off("peak_force_n")),
        "peak_time": Quantity("s", "when the force is greatest", read_off("peak_time_s")),
        "impulse": Quantity("N s", "of the contact force", read_off("impulse_ns")),
        "restitution": Quantity("1", "velocity of the centre away over that before", read_off("restitution")),
        "greatest_penetration": Quantity("m", "depth of the rim below the wall", read_off("greatest_penetration_m")),
        "least_stretch": Quantity("1", "least principal stretch in the plane", read_off("least_stretch")),
    }


SOFT_DISCS = Kind(
    name="soft_discs",
    help="a soft disc on a rigid wall, or two soft discs, by finite elasticity",
    parameters=SoftDiscsScene,
    brief=True,
    quantities=quantities,
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
