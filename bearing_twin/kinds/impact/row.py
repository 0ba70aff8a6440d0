"""The rows of two spheres and of two discs in the table of kinds."""

from bearing_twin.kinds.contract import Kind
from bearing_twin.kinds.impact.parameters import MOVED, MOVED_OF_DISCS, TwoDiscsScene, TwoSpheresScene, upgraded
from bearing_twin.kinds.ranges import facts_at
from bearing_twin.kinds.rows import parts_in

HERE = "bearing_twin.kinds.impact"


def _pair(name: str, help: str, parameters: type, moved: dict[str, str], *facts: str, **parts: str) -> Kind:
    return Kind(
        name=name,
        help=help,
        home=HERE,
        parameters=parameters,
        known_when_solved=True,
        brief=True,
        moved=moved,
        upgraded=upgraded,
        frame=f"{name}_link",
        facts=facts_at(*facts),
        **parts_in(
            HERE,
            channels="impact:channels",
            refined="doubt:refined",
            comparison="doubt:ImpactComparison",
            picture="picture:PairPicture",
            **parts,
        ),
    )


TWO_SPHERES = _pair(
    "two_spheres",
    "central impact of two elastic spheres, without gravity",
    TwoSpheresScene,
    MOVED,
    check="derived:check_spheres",
    choose="models:choose_spheres",
    motion="spheres:motion",
    figures="spheres:figures",
    doubt="doubt:SphereDoubt",
    quantities="quantities:spheres",
    closed_form="spheres:closed_form",
    topics="topics:spheres_topics",
)
TWO_DISCS = _pair(
    "two_discs",
    "central impact of two equal discs in line contact, without gravity",
    TwoDiscsScene,
    MOVED_OF_DISCS,
    f"{HERE}.derived:thickness_over_radius",
    f"{HERE}.derived:speed_share",
    check="derived:check_discs",
    choose="models:choose_discs",
    motion="discs:motion",
    figures="discs:figures",
    doubt="doubt:DiscDoubt",
    quantities="quantities:discs",
    closed_form="discs:closed_form",
    topics="topics:discs_topics",
)
