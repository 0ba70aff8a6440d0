"""The row of a shaft on two bearings in the table of kinds, and the quantities of its studies."""

import math

from bearing_twin.kinds.contract import Kind, Quantity, figure_quantities, parts_in
from bearing_twin.kinds.shaft.parameters import SIDES, ShaftScene

HERE = "bearing_twin.kinds.shaft"
OF_BEARING = "force_n", "greatest_ball_load_n", "peak_pressure_pa", "basic_life_mrev", "reference_life_mrev"


def _least(values) -> float:
    return min(values, default=math.nan)


def quantities() -> dict[str, Quantity]:
    """Quantities of a shaft that a study may have."""
    return {
        **figure_quantities("displacement_m", "tilt_rad"),
        "vibration": Quantity(
            ("displacement_range_m",), meaning="length of the ranges of displacement, second half of the run"
        ),
        "first_natural_frequency": Quantity(("natural_frequencies_hz",), _least, "least of the natural frequencies"),
        "first_critical_speed": Quantity(("critical_speeds_rad_s",), _least, "least of the critical speeds"),
        **figure_quantities(*(f"{side}_{key}" for side in SIDES for key in OF_BEARING)),
    }


SHAFT = Kind(
    name="shaft",
    help="a rigid shaft with mass and unbalance on two ball bearings whose balls are in balance at every instant",
    parameters=ShaftScene,
    quantities=quantities,
    **parts_in(
        HERE,
        topics="display:topics",
        view="display:view",
        choose="motion:choose",
        motion="motion:ShaftMotion",
        channels="motion:channels",
        meanings="figures:MEANINGS",
        comparison="figures:ShaftComparison",
        place_of="motion:place_of",
        figures="figures:ShaftFigures",
        model_errors="figures:ShaftModelErrors",
        commands="display:commands",
        picture="picture:ShaftPicture",
    ),
)
