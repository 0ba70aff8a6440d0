"""Mean speeds of the balls of a run, and of balls that roll."""

import math

from bearing_twin.kinds.bearing.forces.kinematics import cage_speed, roll_rate
from bearing_twin.kinds.bearing.summing import turning


def speed_figures(parameters, late: dict, before: dict) -> dict[str, float]:
    """Mean speeds [rad/s] over the part `late` of a run, by `Sums.from_row`, which follows the instant `before`."""
    geometry, span, speed = parameters.geometry, late["time"] - before["time"], late["speed"] / late["count"]
    diameters, turned = (geometry.ball_diameter, geometry.pitch_diameter), late["orbit_angle"] - before["orbit_angle"]
    return {
        "cage_speed_rad_s": turning(parameters, turned.mean() / span) if span > 0.0 else 0.0,
        "cage_speed_theory_rad_s": float(cage_speed(speed, *diameters)),
        "roll_rate_rad_s": turning(parameters, late["roll_rate"] / late["count"]),
        "roll_rate_theory_rad_s": float(roll_rate(speed, *diameters)),
    }


def off_rolling(figures: dict[str, float]) -> float:
    """How much faster balls go round than if they rolled, as a share, by `speed_figures`; -1 where nothing turns."""
    return figures["cage_speed_rad_s"] / (figures["cage_speed_theory_rad_s"] or math.inf) - 1.0
