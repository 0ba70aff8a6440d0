"""The row of an ellipsoid on a plane in the table of kinds."""

from bearing_twin.kinds.contract import Kind, late
from bearing_twin.kinds.ellipsoid.parameters import MOVED, EllipsoidOnPlaneScene, upgraded

HERE = "bearing_twin.kinds.ellipsoid"

ELLIPSOID_ON_PLANE = Kind(
    name="ellipsoid_on_plane",
    help="an ellipsoid falls on a plane, bounces, slides and rocks under gravity",
    home=HERE,
    parameters=EllipsoidOnPlaneScene,
    check=late(f"{HERE}.derived:check_ellipsoid"),
    resolve=late(f"{HERE}.derived:resolve"),
    choose=late(f"{HERE}.models:choose"),
    motion=late(f"{HERE}.motion:motion"),
    channels=late(f"{HERE}.outputs:channels"),
    records=late(f"{HERE}.figures:tables"),
    figures=late(f"{HERE}.figures:EllipsoidFigures"),
    meanings=late(f"{HERE}.figures:meanings"),
    doubt=late(f"{HERE}.doubt:EllipsoidDoubt"),
    quantities=late(f"{HERE}.quantities:quantities"),
    brief=True,
    moved=MOVED,
    upgraded=upgraded,
    frame="ellipsoid_on_plane_link",
    topics=late(f"{HERE}.topics:topics"),
    picture=late(f"{HERE}.picture:EllipsoidPicture"),
    view=late(f"{HERE}.view:view"),
)
