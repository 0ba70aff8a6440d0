"""The row of a sphere on a beam in the table of kinds."""

from bearing_twin.kinds.beam.parameters import MOVED, SphereOnBeamScene, upgraded
from bearing_twin.kinds.contract import Kind, late

HERE = "bearing_twin.kinds.beam"

SPHERE_ON_BEAM = Kind(
    name="sphere_on_beam",
    help="a sphere strikes a simply supported beam",
    home=HERE,
    parameters=SphereOnBeamScene,
    check=late(f"{HERE}.derived:check_beam"),
    resolve=late(f"{HERE}.derived:resolve"),
    choose=late(f"{HERE}.models:choose"),
    motion=late(f"{HERE}.motion:BeamMotion"),
    channels=late(f"{HERE}.motion:channels"),
    records=late(f"{HERE}.figures:tables"),
    figures=late(f"{HERE}.figures:BeamFigures"),
    meanings=late(f"{HERE}.figures:meanings"),
    doubt=late(f"{HERE}.doubt:BeamDoubt"),
    quantities=late(f"{HERE}.quantities:quantities"),
    known_when_solved=True,
    brief=True,
    moved=MOVED,
    upgraded=upgraded,
    frame="sphere_on_beam_link",
    topics=late(f"{HERE}.topics:topics"),
    picture=late(f"{HERE}.picture:BeamPicture"),
    view=late(f"{HERE}.view:view"),
)
