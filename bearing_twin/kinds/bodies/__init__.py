"""Bodies that collide: spheres and discs on a line, an ellipsoid on a plane, any two bodies with implicit surfaces.

The rows of their kinds in the table of kinds.
"""

from bearing_twin.kinds.bodies.parameters import (
    HERE,
    EllipsoidOnPlaneScene,
    TwoBodiesScene,
    TwoDiscsScene,
    TwoSpheresScene,
)
from bearing_twin.kinds.contract import Kind, parts_in


def _row(name: str, help: str, parameters: type, **parts: str) -> Kind:
    return Kind(name=name, help=help, parameters=parameters, brief=True, **parts_in(HERE, **parts))


OF_IMPACT = {
    "channels": "impact:CHANNELS", "records": "figures:OF_IMPACT", "figures": "figures:PairFigures",
    "meanings": "figures:MEANINGS",
    "comparison": "model_errors:ImpactComparison", "picture": "picture:PairPicture", "view": "display:impact_view",
}  # fmt: skip
OF_BOUNCING = {
    "choose": "models:choose_bouncing", "figures": "figures:BouncingFigures",
    "comparison": "model_errors:ContactComparison", "model_errors": "model_errors:BouncingErrors",
    "picture": "picture:BouncingPicture", "view": "display:bouncing_view",
}  # fmt: skip

TWO_SPHERES = _row(
    "two_spheres",
    "central impact of two elastic spheres, without gravity",
    TwoSpheresScene,
    choose="models:choose_spheres",
    motion="impact:spheres",
    model_errors="model_errors:SphereErrors",
    quantities="quantities:SPHERE_QUANTITIES",
    topics="display:sphere_topics",
    **OF_IMPACT,
)
TWO_DISCS = _row(
    "two_discs",
    "central impact of two equal discs in line contact, without gravity",
    TwoDiscsScene,
    choose="models:choose_discs",
    motion="impact:discs",
    model_errors="model_errors:DiscErrors",
    quantities="quantities:DISC_QUANTITIES",
    topics="display:disc_topics",
    **OF_IMPACT,
)
ELLIPSOID_ON_PLANE = _row(
    "ellipsoid_on_plane",
    "an ellipsoid falls on a plane, bounces, slides and rocks under gravity",
    EllipsoidOnPlaneScene,
    motion="motion:EllipsoidMotion",
    channels="motion:ELLIPSOID_CHANNELS",
    records="figures:OF_ELLIPSOID",
    meanings="figures:MEANINGS_OF_ELLIPSOID",
    quantities="quantities:ELLIPSOID_QUANTITIES",
    topics="display:ellipsoid_topics",
    **OF_BOUNCING,
)
TWO_BODIES = _row(
    "two_bodies",
    "two bodies of any smooth shape bounce, roll and spin on each other",
    TwoBodiesScene,
    motion="motion:PairMotion",
    channels="motion:PAIR_CHANNELS",
    records="figures:OF_PAIR",
    meanings="figures:MEANINGS_OF_PAIR",
    quantities="quantities:PAIR_QUANTITIES",
    topics="display:body_topics",
    **OF_BOUNCING,
)
