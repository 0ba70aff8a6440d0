"""The row of an ellipsoid on a plane in the table of kinds."""

from bearing_twin.kinds.contract import Kind, parts_in
from bearing_twin.kinds.ellipsoid.parameters import EllipsoidOnPlaneScene

HERE = "bearing_twin.kinds.ellipsoid"

ELLIPSOID_ON_PLANE = Kind(
    name="ellipsoid_on_plane",
    help="an ellipsoid falls on a plane, bounces, slides and rocks under gravity",
    parameters=EllipsoidOnPlaneScene,
    brief=True,
    **parts_in(
        HERE,
        motion="motion:EllipsoidMotion",
        channels="outputs:channels",
        quantities="quantities:quantities",
        comparison="doubt:ContactComparison",
        figures="figures:EllipsoidFigures",
        model_errors="doubt:EllipsoidDoubt",
        picture="picture:EllipsoidPicture",
    ),
)
