"""Closed forms of pure rolling in a ball bearing, outer ring at rest (Harris, Rolling Bearing Analysis, ch. 8)."""

import math
from typing import NamedTuple


class Frequencies(NamedTuple):
    """Events per turn of the inner ring."""

    cage: float
    outer_passes: float
    inner_passes: float
    ball_spin: float


def cage_speed(inner_speed: float, ball_diameter: float, pitch_diameter: float, contact_angle: float = 0.0) -> float:
    """Orbital speed of the balls [rad/s] without slip: half the inner ring's, times 1 - (D/d_m) cos(angle)."""
    return 0.5 * inner_speed * (1.0 - ball_diameter / pitch_diameter * math.cos(contact_angle))


def roll_rate(inner_speed: float, ball_diameter: float, pitch_diameter: float, contact_angle: float = 0.0) -> float:
    """Angular speed [rad/s] of a ball about its own centre against its orbit, without slip."""
    ratio = ball_diameter / pitch_diameter * math.cos(contact_angle)
    return 0.5 * inner_speed * pitch_diameter / ball_diameter * (1.0 - ratio**2)


def frequencies(balls: int, ball_diameter: float, pitch_diameter: float, contact_angle: float = 0.0) -> Frequencies:
    """Characteristic frequencies as multiples of the shaft's; `ball_spin` counts the ball's own turns."""
    cage = cage_speed(1.0, ball_diameter, pitch_diameter, contact_angle)
    return Frequencies(
        cage, balls * cage, balls * (1.0 - cage), roll_rate(1.0, ball_diameter, pitch_diameter, contact_angle)
    )


def cage_speed_with_slip(
    inner_speed: float, axis_distance: float, inner_arm: float, outer_arm: float, inner_slip: float, outer_slip: float
) -> float:
    """Orbital speed [rad/s] that goes with given tangential slips [m/s] (ball minus raceway) at contact angle zero.

    `axis_distance` [m] is the ball centre's, the arms [m] reach from it to the two contact points. The centre's
    velocity is the mean of those of the ball's surface at the two points, weighted by the opposite arms.
    """
    inner_surface = (axis_distance - inner_arm) * inner_speed + inner_slip
    return (outer_arm * inner_surface + inner_arm * outer_slip) / ((inner_arm + outer_arm) * axis_distance)
