"""The row of soft discs in the table of kinds."""

from bearing_twin.kinds.contract import Kind
from bearing_twin.kinds.ranges import facts_at
from bearing_twin.kinds.rows import parts_in
from bearing_twin.kinds.soft_discs.parameters import SoftDiscsScene

HERE = "bearing_twin.kinds.soft_discs"

SOFT_DISCS = Kind(
    name="soft_discs",
    help="a soft disc on a rigid wall, or two soft discs, by finite elasticity",
    home=HERE,
    parameters=SoftDiscsScene,
    known_when_solved=True,
    brief=True,
    frame="soft_discs_link",
    facts=facts_at(
        f"{HERE}.derived:speed_share",
        f"{HERE}.derived:thickness_over_radius",
        f"{HERE}.derived:poisson_ratio_in_strain",
    ),
    animated=True,
    **parts_in(
        HERE,
        choose="derived:choose",
        channels="motion:channels",
        quantities="figures:quantities",
        refined="model_error:refined",
        comparison="model_error:SoftDiscComparison",
        figures="figures:SoftDiscFigures",
        doubt="model_error:SoftDiscDoubt",
        picture="picture:SoftDiscPicture",
    ),
)
