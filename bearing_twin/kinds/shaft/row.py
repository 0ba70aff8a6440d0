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
        channels="motion:channels",
        refined="model_error:refined",
        comparison="model_error:ShaftComparison",
        completed="derived:completed",
        place_of="motion:place_of",
        figures="figures:ShaftFigures",
        doubt="model_error:ShaftDoubt",
        commands="topics:commands",
        check_drive="equilibrium:check_drive",
        check_load="equilibrium:check_load",
        picture="picture:ShaftPicture",
    ),
)
