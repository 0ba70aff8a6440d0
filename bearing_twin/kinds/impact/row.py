"""The rows of two spheres and of two discs in the table of kinds."""

from bearing_twin.kinds.contract import Kind, parts_in
from bearing_twin.kinds.impact.parameters import TwoDiscsScene, TwoSpheresScene

HERE = "bearing_twin.kinds.impact"


def _pair(name: str, help: str, parameters: type, **parts: str) -> Kind:
    return Kind(
        name=name,
        help=help,
        parameters=parameters,
        brief=True,
        **parts_in(
            HERE,
            channels="impact:channels",
            comparison="doubt:ImpactComparison",
            picture="picture:PairPicture",
            **parts,
        ),
    )


TWO_SPHERES = _pair(
    "two_spheres",
    "central impact of two elastic spheres, without gravity",
    TwoSpheresScene,
    choose="models:choose_spheres",
    motion="spheres:motion",
    figures="spheres:figures",
    model_errors="doubt:SphereDoubt",
    quantities="quantities:spheres",
    topics="topics:spheres_topics",
)
TWO_DISCS = _pair(
    "two_discs",
    "central impact of two equal discs in line contact, without gravity",
    TwoDiscsScene,
    choose="models:choose_discs",
    motion="discs:motion",
    figures="discs:figures",
    model_errors="doubt:DiscDoubt",
    quantities="quantities:discs",
    topics="topics:discs_topics",
)
