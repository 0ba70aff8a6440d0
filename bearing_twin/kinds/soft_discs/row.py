"""The row of soft discs in the table of kinds."""

from bearing_twin.kinds.contract import Kind, late
from bearing_twin.kinds.soft_discs.parameters import SoftDiscsScene

HERE = "bearing_twin.kinds.soft_discs"

SOFT_DISCS = Kind(
    name="soft_discs",
    help="a soft disc on a rigid wall, or two soft discs, by finite elasticity",
    home=HERE,
    parameters=SoftDiscsScene,
    check=late(f"{HERE}.derived:check"),
    resolve=late(f"{HERE}.derived:resolve"),
    choose=late(f"{HERE}.models:choose"),
    motion=late(f"{HERE}.motion:motion"),
    channels=late(f"{HERE}.motion:channels"),
    records=late(f"{HERE}.figures:tables"),
    figures=late(f"{HERE}.figures:SoftDiscFigures"),
    meanings=late(f"{HERE}.figures:meanings"),
    doubt=late(f"{HERE}.doubt:SoftDiscDoubt"),
    quantities=late(f"{HERE}.quantities:quantities"),
    known_when_solved=True,
    brief=True,
    frame="soft_discs_link",
    topics=late(f"{HERE}.topics:topics"),
    animated=True,
    picture=late(f"{HERE}.picture:SoftDiscPicture"),
    view=late(f"{HERE}.view:view"),
)
