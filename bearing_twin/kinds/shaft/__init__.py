"""The row of a shaft on two bearings in the table of kinds, and the quantities of its studies."""

import math

from bearing_twin.kinds.contract import Kind, Quantity, parts_in, read_off
from bearing_twin.kinds.shaft.parameters import SIDES, ShaftScene

HERE = "bearing_twin.kinds.shaft"
OF_BEARING = (
    ("greatest_ball_load", "N", "greatest load of any contact", "greatest_ball_load_n"),
    ("peak_pressure", "Pa", "greatest Hertz pressure", "peak_pressure_pa"),
    ("basic_life", "Mrev", "ISO 281", "basic_life_mrev"),
    ("reference_life", "Mrev", "ISO/TS 16281", "reference_life_mrev"),
)


def _length(vector) -> float:
    return math.hypot(*vector)


def _least(values) -> float:
    return min(values, default=math.nan)


def quantities() -> dict[str, Quantity]:
    """Quantities of a shaft that a study may have."""
    found = {
        "displacement": Quantity(
            "m", "of the centre of mass, mean of the second half", read_off("displacement_m", _length)
        ),
        "tilt": Quantity("rad", "of the shaft, mean of the second half", read_off("tilt_rad", _length)),
        "vibration": Quantity(
            "m", "ranges of the centre of mass, second half, as a length", read_off("displacement_range_m", _length)
        ),
        "first_natural_frequency": Quantity(
            "Hz", "least of the natural frequencies", read_off("natural_frequencies_hz", _least)
        ),
        "first_critical_speed": Quantity(
            "rad/s", "least of the critical speeds", read_off("critical_speeds_rad_s", _least)
        ),
    }
    for side in SIDES:
        found[f"{side}_force"] = Quantity(
            "N", f"of the {side} bearing on the shaft, mean of the second half", read_off(f"{side}_force_n", _length)
        )
        for name, unit, words, key in OF_BEARING:
            found[f"{side}_{name}"] = Quantity(unit, f"{words}, of the {side} bearing", read_off(f"{side}_{key}"))
    return found


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
