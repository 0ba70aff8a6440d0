"""Speeds of the balls in a run, and of pure rolling, outer ring at rest (Harris, Rolling Bearing Analysis, ch. 8)."""

import math

from bearing_twin.kinds.bearing.summing import turning


def cage_speed(inner_speed: float, ball_diameter: float, pitch_diameter: float, contact_angle: float = 0.0) -> float:
    """Orbital speed of the balls [rad/s] without slip: half the inner ring's, times 1 - (D/d_m) cos(angle)."""
    return 0.5 * inner_speed * (1.0 - ball_diameter / pitch_diameter * math.cos(contact_angle))


def roll_rate(inner_speed: float, ball_diameter: float, pitch_diameter: float, contact_angle: float = 0.0) -> float:
    """Angular speed [rad/s] of a ball about its own centre against its orbit, without slip."""
    ratio = ball_diameter / pitch_diameter * math.cos(contact_angle)
    return 0.5 * inner_speed * pitch_diameter / ball_diameter * (1.0 - ratio**2)


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
