"""The row of bearings in the table of kinds."""

from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.contract import Kind, parts_in

HERE = "bearing_twin.kinds.bearing"

BEARING = Kind(
    name="bearing",
    help="balls between two grooved raceways, the inner ring turning",
    parameters=BearingScene,
    **parts_in(
        HERE,
        choose="models:choose",
        motion="motion:bearing_motion",
        topics="topics:topics",
        view="view:view",
        place_of="outputs:place_of",
        channels="outputs:channels",
        figures="figures:BearingFigures",
        records="accelerometer:tables",
        meanings="quantities:MEANINGS",
        model_errors="model_error:BearingErrors",
        commands="topics:commands",
        quantities="quantities:quantities",
        comparison="model_error:BearingComparison",
        picture="picture:BearingPicture",
    ),
)
