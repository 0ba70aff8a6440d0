"""The row of bearings in the table of kinds."""

from bearing_twin.kinds.bearing.parameters import MOVED, BearingScene, upgraded
from bearing_twin.kinds.contract import Kind
from bearing_twin.kinds.ranges import facts_at
from bearing_twin.kinds.rows import parts_in

HERE = "bearing_twin.kinds.bearing"

BEARING = Kind(
    name="bearing",
    help="balls between two grooved raceways, the inner ring turning",
    home=HERE,
    parameters=BearingScene,
    moved=MOVED,
    upgraded=upgraded,
    frame="bearing_link",
    facts=facts_at(
        f"{HERE}.facts:axis_ratio",
        f"{HERE}.facts:slip_at_start",
        f"{HERE}.facts:ring_shift",
        f"{HERE}.facts:relative_acceleration",
        f"{HERE}.facts:centrifugal_share",
    ),
    **parts_in(
        HERE,
        check="parameters:check",
        resolve="parameters:resolve",
        motion="motion:bearing_motion",
        place_of="outputs:place_of",
        renewed="outputs:renewed",
        figures="figures:BearingFigures",
        records="accelerometer:tables",
        meanings="quantities:MEANINGS",
        doubt="doubt:BearingDoubt",
        commands="topics:commands",
        check_drive="equilibrium:check_drive",
        speed_doubt="ratings:command_doubt",
        check_load="equilibrium:check_load",
        refined="doubt:refined",
        comparison="doubt:BearingComparison",
        operating_point="equilibrium:operating_point",
        catalogue="catalogue:scenes",
        completed="catalogue:completed",
        picture="picture:BearingPicture",
    ),
)
