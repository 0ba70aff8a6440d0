"""The row of a sphere on a beam in the table of kinds, and the quantities of its studies."""

from bearing_twin.kinds.beam.parameters import MOVED, SphereOnBeamScene, upgraded
from bearing_twin.kinds.contract import Kind, Quantity, read_off
from bearing_twin.kinds.impact.quantities import impact_quantities
from bearing_twin.kinds.ranges import facts_at
from bearing_twin.kinds.rows import parts_in

HERE = "bearing_twin.kinds.beam"


def quantities() -> dict[str, Quantity]:
    """What a study may ask of a sphere on a beam."""
    return {
        **impact_quantities(),
        "contacts": Quantity("1", "number of contacts", read_off("contact_count")),
        "peak_deflection": Quantity("m", "greatest deflection of the beam", read_off("peak_deflection_m"), whole=True),
        "peak_stress": Quantity("Pa", "greatest bending stress", read_off("peak_stress_pa"), whole=True),
        "velocity_after": Quantity(
            "m/s", "of the sphere at the end, positive along its motion before", read_off("sphere_velocity_after_m_s")
        ),
    }


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
        quantities="row:quantities",
        motion="motion:BeamMotion",
        channels="motion:channels",
        refined="doubt:refined",
        comparison="doubt:BeamComparison",
        figures="figures:BeamFigures",
        doubt="doubt:BeamDoubt",
        picture="picture:BeamPicture",
    ),
)
