"""Closed forms of pure rolling in a ball bearing, outer ring at rest (Harris, Rolling Bearing Analysis, ch. 8)."""

import math


def cage_speed(inner_speed: float, ball_diameter: float, pitch_diameter: float, contact_angle: float = 0.0) -> float:
    """Orbital speed of the balls [rad/s] without slip: half the inner ring's, times 1 - (D/d_m) cos(angle)."""
    return 0.5 * inner_speed * (1.0 - ball_diameter / pitch_diameter * math.cos(contact_angle))


def roll_rate(inner_speed: float, ball_diameter: float, pitch_diameter: float, contact_angle: float = 0.0) -> float:
    """Angular speed [rad/s] of a ball about its own centre against its orbit, without slip."""
    ratio = ball_diameter / pitch_diameter * math.cos(contact_angle)
    return 0.5 * inner_speed * pitch_diameter / ball_diameter * (1.0 - ratio**2)
