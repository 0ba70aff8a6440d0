"""The row of bearings in the table of kinds."""

from bearing_twin.kinds.bearing.parameters import MOVED, BearingScene, check, resolve, upgraded
from bearing_twin.kinds.contract import Kind, late

HERE = "bearing_twin.kinds.bearing"

BEARING = Kind(
    name="bearing",
    help="balls between two grooved raceways, the inner ring turning",
    home=HERE,
    parameters=BearingScene,
    check=check,
    resolve=resolve,
    choose=late(f"{HERE}.models:choose"),
    motion=late(f"{HERE}.motion:bearing_motion"),
    channels=late(f"{HERE}.outputs:channels"),
    place_of=late(f"{HERE}.outputs:place_of"),
    records=late(f"{HERE}.figures:tables"),
    figures=late(f"{HERE}.figures:BearingFigures"),
    meanings=late(f"{HERE}.figures:meanings"),
    doubt=late(f"{HERE}.doubt:BearingDoubt"),
    quantities=late(f"{HERE}.quantities:quantities"),
    steered=True,
    commands=late(f"{HERE}.topics:commands"),
    check_drive=late(f"{HERE}.quasi_static.operating:check_drive"),
    check_load=late(f"{HERE}.quasi_static.operating:check_load"),
    rechosen=late(f"{HERE}.rechoice:rechosen"),
    operating_point=late(f"{HERE}.quasi_static.operating:operating_point"),
    frame="bearing_link",
    topics=late(f"{HERE}.topics:topics"),
    moved=MOVED,
    upgraded=upgraded,
    catalogue=late(f"{HERE}.catalogue:scenes"),
    completed=late(f"{HERE}.catalogue:completed"),
    picture=late(f"{HERE}.picture:BearingPicture"),
    view=late(f"{HERE}.view:view"),
)
