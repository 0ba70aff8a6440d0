"""The rows of two spheres and of two discs in the table of kinds."""

from bearing_twin.kinds.contract import Kind, late
from bearing_twin.kinds.impact.parameters import TwoDiscsScene, TwoSpheresScene, check_discs, check_spheres, resolve

HERE = "bearing_twin.kinds.impact"


def _pair(name: str, help: str, parameters: type, check, module: str) -> Kind:
    return Kind(
        name=name,
        help=help,
        home=HERE,
        parameters=parameters,
        check=check,
        resolve=resolve,
        choose=late(f"{HERE}.models:choose_{module}"),
        motion=late(f"{HERE}.{module}:motion"),
        channels=late(f"{HERE}.pair:channels"),
        records=late(f"{HERE}.figures:tables"),
        figures=late(f"{HERE}.{module}:figures"),
        quantities=late(f"{HERE}.{module}:quantities"),
        closed_form=late(f"{HERE}.{module}:closed_form"),
        known_when_solved=True,
        brief=True,
        picture=late(f"{HERE}.picture:PairPicture"),
    )


TWO_SPHERES = _pair(
    "two_spheres", "two elastic spheres meet head-on, without gravity", TwoSpheresScene, check_spheres, "spheres"
)
TWO_DISCS = _pair(
    "two_discs", "two equal discs meet in line contact, without gravity", TwoDiscsScene, check_discs, "discs"
)
