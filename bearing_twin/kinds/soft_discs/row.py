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
        f"{HERE}.facts:speed_share",
        f"{HERE}.facts:thickness_over_radius",
        f"{HERE}.facts:poisson_ratio_in_strain",
    ),
    animated=True,
    **parts_in(
        HERE,
        channels="motion:channels",
        refined="doubt:refined",
        comparison="doubt:SoftDiscComparison",
        figures="figures:SoftDiscFigures",
        doubt="doubt:SoftDiscDoubt",
        picture="picture:SoftDiscPicture",
    ),
)
