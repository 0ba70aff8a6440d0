"""The row of a shaft on two bearings in the table of kinds."""

from bearing_twin.kinds.contract import Kind
from bearing_twin.kinds.rows import parts_in
from bearing_twin.kinds.shaft.parameters import ShaftScene

HERE = "bearing_twin.kinds.shaft"

SHAFT = Kind(
    name="shaft",
    help="a rigid shaft with mass and unbalance on two ball bearings whose balls are in balance at every instant",
    home=HERE,
    parameters=ShaftScene,
    frame="shaft_link",
    **parts_in(
        HERE,
        motion="motion:ShaftMotion",
        records="",
        refined="doubt:refined",
        comparison="doubt:ShaftComparison",
        completed="derived:completed",
        place_of="outputs:place_of",
        figures="figures:ShaftFigures",
        doubt="doubt:ShaftDoubt",
        commands="topics:commands",
        check_drive="operating:check_drive",
        check_load="operating:check_load",
        picture="picture:ShaftPicture",
    ),
)
