"""The row of two bodies in the table of kinds."""

from bearing_twin.kinds.contract import Kind
from bearing_twin.kinds.ranges import facts_at
from bearing_twin.kinds.rows import parts_in
from bearing_twin.kinds.two_bodies.parameters import TwoBodiesScene

HERE = "bearing_twin.kinds.two_bodies"

TWO_BODIES = Kind(
    name="two_bodies",
    help="two bodies of any smooth shape bounce, roll and spin on each other",
    home=HERE,
    parameters=TwoBodiesScene,
    brief=True,
    frame="two_bodies_link",
    facts=facts_at(
        f"{HERE}.derived:axis_ratio",
        f"{HERE}.derived:greatest_exponent",
    ),
    **parts_in(
        HERE,
        motion="motion:TwoBodiesMotion",
        refined="motion:refined",
        comparison="doubt:TwoBodiesComparison",
        figures="figures:TwoBodiesFigures",
        doubt="doubt:TwoBodiesDoubt",
        picture="picture:TwoBodiesPicture",
    ),
)
