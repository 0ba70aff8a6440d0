"""The row of two bodies in the table of kinds."""

from bearing_twin.kinds.contract import Kind, late
from bearing_twin.kinds.two_bodies.parameters import TwoBodiesScene

HERE = "bearing_twin.kinds.two_bodies"

TWO_BODIES = Kind(
    name="two_bodies",
    help="two bodies of any smooth shape bounce, roll and spin on each other",
    home=HERE,
    parameters=TwoBodiesScene,
    check=late(f"{HERE}.derived:check"),
    resolve=late(f"{HERE}.derived:resolve"),
    choose=late(f"{HERE}.models:choose"),
    motion=late(f"{HERE}.motion:motion"),
    channels=late(f"{HERE}.outputs:channels"),
    records=late(f"{HERE}.figures:tables"),
    figures=late(f"{HERE}.figures:PairFigures"),
    meanings=late(f"{HERE}.figures:meanings"),
    doubt=late(f"{HERE}.doubt:PairDoubt"),
    quantities=late(f"{HERE}.quantities:quantities"),
    brief=True,
    frame="two_bodies_link",
    topics=late(f"{HERE}.topics:topics"),
    picture=late(f"{HERE}.picture:PairPicture"),
    view=late(f"{HERE}.view:view"),
)
