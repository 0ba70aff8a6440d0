"""The rows of two spheres and of two discs in the table of kinds."""

from bearing_twin.kinds.contract import Kind, late
from bearing_twin.kinds.impact.parameters import MOVED, MOVED_OF_DISCS, TwoDiscsScene, TwoSpheresScene, upgraded

HERE = "bearing_twin.kinds.impact"


def _pair(name: str, help: str, parameters: type, module: str, **parts) -> Kind:
    return Kind(
        name=name,
        help=help,
        home=HERE,
        parameters=parameters,
        resolve=late(f"{HERE}.derived:resolve"),
        motion=late(f"{HERE}.{module}:motion"),
        channels=late(f"{HERE}.pair:channels"),
        records=late(f"{HERE}.figures:tables"),
        figures=late(f"{HERE}.{module}:figures"),
        meanings=late(f"{HERE}.figures:meanings"),
        closed_form=late(f"{HERE}.{module}:closed_form"),
        known_when_solved=True,
        brief=True,
        upgraded=upgraded,
        frame=f"{name}_link",
        topics=late(f"{HERE}.topics:{module}_topics"),
        picture=late(f"{HERE}.picture:PairPicture"),
        view=late(f"{HERE}.view:view"),
        **parts,
    )


TWO_SPHERES = _pair(
    "two_spheres",
    "two elastic spheres meet head-on, without gravity",
    TwoSpheresScene,
    "spheres",
    check=late(f"{HERE}.derived:check_spheres"),
    choose=late(f"{HERE}.models:choose_spheres"),
    doubt=late(f"{HERE}.doubt:SphereDoubt"),
    quantities=late(f"{HERE}.quantities:spheres"),
    moved=MOVED,
)
TWO_DISCS = _pair(
    "two_discs",
    "two equal discs meet in line contact, without gravity",
    TwoDiscsScene,
    "discs",
    check=late(f"{HERE}.derived:check_discs"),
    choose=late(f"{HERE}.models:choose_discs"),
    doubt=late(f"{HERE}.doubt:DiscDoubt"),
    quantities=late(f"{HERE}.quantities:discs"),
    moved=MOVED_OF_DISCS,
)
