"""The row of two bodies in the table of kinds."""

from bearing_twin.kinds.contract import Kind, parts_in
from bearing_twin.kinds.two_bodies.parameters import TwoBodiesScene

HERE = "bearing_twin.kinds.two_bodies"

TWO_BODIES = Kind(
    name="two_bodies",
    help="two bodies of any smooth shape bounce, roll and spin on each other",
    parameters=TwoBodiesScene,
    brief=True,
    **parts_in(
        HERE,
        motion="motion:TwoBodiesMotion",
        channels="outputs:channels",
        quantities="quantities:quantities",
        comparison="doubt:TwoBodiesComparison",
        figures="figures:TwoBodiesFigures",
        model_errors="doubt:TwoBodiesDoubt",
        picture="picture:TwoBodiesPicture",
    ),
)
