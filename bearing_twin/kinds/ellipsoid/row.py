"""The row of an ellipsoid on a plane in the table of kinds."""

from bearing_twin.kinds.contract import Kind
from bearing_twin.kinds.ellipsoid.parameters import MOVED, EllipsoidOnPlaneScene, upgraded
from bearing_twin.kinds.ranges import facts_at
from bearing_twin.kinds.rows import parts_in

HERE = "bearing_twin.kinds.ellipsoid"

ELLIPSOID_ON_PLANE = Kind(
    name="ellipsoid_on_plane",
    help="an ellipsoid falls on a plane, bounces, slides and rocks under gravity",
    home=HERE,
    parameters=EllipsoidOnPlaneScene,
    brief=True,
    moved=MOVED,
    upgraded=upgraded,
    frame="ellipsoid_on_plane_link",
    facts=facts_at(
        f"{HERE}.derived:axis_ratio",
        f"{HERE}.derived:coefficient_change",
    ),
    **parts_in(
        HERE,
        check="derived:check_ellipsoid",
        motion="motion:EllipsoidMotion",
        refined="motion:refined",
        comparison="doubt:ContactComparison",
        figures="figures:EllipsoidFigures",
        doubt="doubt:EllipsoidDoubt",
        picture="picture:EllipsoidPicture",
    ),
)
