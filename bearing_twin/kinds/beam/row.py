"""The row of a sphere on a beam in the table of kinds."""

from bearing_twin.kinds.beam.parameters import MOVED, SphereOnBeamScene, upgraded
from bearing_twin.kinds.contract import Kind
from bearing_twin.kinds.ranges import facts_at
from bearing_twin.kinds.rows import parts_in

HERE = "bearing_twin.kinds.beam"

SPHERE_ON_BEAM = Kind(
    name="sphere_on_beam",
    help="a sphere strikes a simply supported beam",
    home=HERE,
    parameters=SphereOnBeamScene,
    known_when_solved=True,
    brief=True,
    moved=MOVED,
    upgraded=upgraded,
    frame="sphere_on_beam_link",
    facts=facts_at(
        f"{HERE}.models:shear_share",
        f"{HERE}.models:first_peak_error",
    ),
    **parts_in(
        HERE,
        check="models:check_beam",
        resolve="models:resolve",
        quantities="figures:quantities",
        motion="motion:BeamMotion",
        channels="motion:channels",
        refined="doubt:refined",
        comparison="doubt:BeamComparison",
        figures="figures:BeamFigures",
        doubt="doubt:BeamDoubt",
        picture="picture:BeamPicture",
    ),
)
