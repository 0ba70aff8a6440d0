"""The row of a shaft on two bearings in the table of kinds, and the quantities of its studies; all else is private."""

import math

from bearing_twin.kinds.contract import Kind, Quantity, figure_quantities, parts_in
from bearing_twin.kinds.shaft.parameters import SIDES, ShaftScene

PACKAGE = "bearing_twin.kinds.shaft"
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


HALF = "over the second half of the run"
LATE = f"mean {HALF}"
WHIRL = "in balance at the scene's last speed and loads, balls where they start"
MEANINGS = {
    "shaft_speed_at_end_rad_s": "of the shaft about its axis, at the end",
    "displacement_m": f"of the shaft's centre of mass, {LATE}",
    "displacement_range_m": f"greatest minus least, {HALF}",
    "tilt_rad": f"of the shaft about x and y, {LATE}",
    "tilt_range_rad": f"greatest minus least, {HALF}",
    **{
        f"{side}_{key}": meaning
        for side in SIDES
        for key, meaning in (
            ("force_n", f"of the {side} bearing on the shaft, {LATE}"),
            ("force_range_n", f"greatest minus least of that, {HALF}"),
            ("greatest_ball_load_n", f"of any contact of the {side} bearing, greatest over the run"),
            ("peak_pressure_pa", f"in the {side} bearing, at the greatest load on each raceway"),
            ("basic_life_mrev", f"of the {side} bearing in 1e6 turns, ISO 281, under its mean sizes of force {HALF}"),
            ("basic_life_h", "the same in hours at the shaft's speed at the end, where it turns then"),
            ("reference_life_mrev", f"of the {side} bearing by ISO/TS 16281, from the loads of all balls {HALF}"),
            ("reference_life_h", "the same in hours, as above"),
        )
    },
    "natural_frequencies_hz": f"of the shaft on its bearings, rising, {WHIRL}",
    "forward_shares": "of each of these motions: 1 whirls as the shaft turns, 0 against it, 1/2 in a line or axial",
    "critical_speeds_rad_s": f"at which a forward whirl goes round with the shaft, as stiff as {WHIRL}",
    "energy_closure": "energy of the shaft gained (+) or lost (-) by the method over the run, as a share of the work "
    "that loads and bearings did either way, or of wanted.tolerance times what is stored where that is more",
    "load_work_j": "of loads and unbalances on the shaft since the start, at the end",
    "bearing_work_j": "of the shaft on its bearings since the start, at the end, without what is dissipated",
    "cage_work_j": "of both cages on the balls that they lead round since the start, at the end",
    "dissipated_j": "in viscous contacts since the start, at the end",
}

SHAFT = Kind(
    name="shaft",
    help="a rigid shaft with mass and unbalance on two ball bearings whose balls are in balance at every instant",
    parameters=ShaftScene,
    meanings=lambda: MEANINGS,
    quantities=quantities,
    **parts_in(
        PACKAGE,
        topics="display:topics",
        view="display:view",
        choose="motion:choose",
        motion="motion:ShaftMotion",
        channels="motion:channels",
        comparison="figures:ShaftComparison",
        place_of="motion:place_of",
        figures="figures:ShaftFigures",
        model_errors="figures:ShaftModelErrors",
        commands="display:commands",
        picture="picture:ShaftPicture",
    ),
)
