"""A sphere on a beam: its row in the table of kinds, and the quantities of its studies.

* `motion`: the beam of a scene (`beam_of`), the modes and steps that a tolerance needs (`modes_for`, `steps_of`).
"""

from bearing_twin.kinds.beam.parameters import SphereOnBeamScene
from bearing_twin.kinds.contract import Kind, Quantity, parts_in

HERE = "bearing_twin.kinds.beam"


def quantities() -> dict[str, Quantity]:
    """Quantities of a sphere on a beam that a study may have."""
    from bearing_twin.kinds.bodies import impact_quantities

    return {
        **impact_quantities(),
        "contacts": Quantity(("contact_count",)),
        "peak_deflection": Quantity(("peak_deflection_m",), whole=True),
        "peak_stress": Quantity(("peak_stress_pa",), whole=True),
        "velocity_after": Quantity(("sphere_velocity_after_m_s",)),
    }


def meanings() -> dict[str, str]:
    """Meanings of the figures."""
    from bearing_twin.kinds.bodies import MEANINGS as IMPACT_MEANINGS

    return IMPACT_MEANINGS | {
        "restitution": "speed of the sphere away from the beam over its speed before, at the end",
        "sphere_velocity_after_m_s": "of the sphere along its motion before the impact, at the end",
        "contact_count": "contacts that have ended",
        "peak_deflection_m": "of the beam, greatest by magnitude of all points, whole motion; none for peaks alone",
        "peak_stress_pa": "bending stress, greatest by magnitude of all points, whole motion; none for peaks alone",
        "highest_mode": "of the beam in the sum, the same for the whole motion",
        "gravity_m_s2": "on the sphere after the first touch, as the scene gives it",
    }


SPHERE_ON_BEAM = Kind(
    name="sphere_on_beam",
    help="a sphere strikes a simply supported beam",
    parameters=SphereOnBeamScene,
    brief=True,
    meanings=meanings,
    quantities=quantities,
    **parts_in(
        HERE,
        topics="display:topics",
        view="display:view",
        choose="motion:choose",
        motion="motion:BeamMotion",
        channels="motion:channels",
        records="figures:TABLES",
        comparison="figures:BeamComparison",
        figures="figures:BeamFigures",
        model_errors="figures:BeamModelErrors",
        picture="picture:BeamPicture",
    ),
)
