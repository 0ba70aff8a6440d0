"""The rows of two spheres and of two discs in the table of kinds."""

from bearing_twin.kinds.contract import Kind, late
from bearing_twin.kinds.impact.parameters import MOVED, MOVED_OF_DISCS, TwoDiscsScene, TwoSpheresScene, upgraded

HERE = "bearing_twin.kinds.impact"


def _pair(name: str, help: str, parameters: type, module: str, moved) -> Kind:
    return Kind(
        name=name,
        help=help,
        home=HERE,
        parameters=parameters,
        check=late(f"{HERE}.derived:check_{module}"),
        resolve=late(f"{HERE}.derived:resolve"),
        choose=late(f"{HERE}.models:choose_{module}"),
        motion=late(f"{HERE}.{module}:motion"),
        channels=late(f"{HERE}.pair:channels"),
        records=late(f"{HERE}.figures:tables"),
        figures=late(f"{HERE}.{module}:figures"),
        meanings=late(f"{HERE}.figures:meanings"),
        quantities=late(f"{HERE}.quantities:{module}"),
        closed_form=late(f"{HERE}.{module}:closed_form"),
        known_when_solved=True,
        brief=True,
        moved=moved,
        upgraded=upgraded,
        picture=late(f"{HERE}.picture:PairPicture"),
    )


TWO_SPHERES = _pair(
    "two_spheres", "two elastic spheres meet head-on, without gravity", TwoSpheresScene, "spheres", MOVED
)
TWO_DISCS = _pair(
    "two_discs", "two equal discs meet in line contact, without gravity", TwoDiscsScene, "discs", MOVED_OF_DISCS
)
