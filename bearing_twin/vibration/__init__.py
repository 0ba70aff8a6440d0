"""Vibration of a damaged bearing: frequencies at which damage of raceways, balls and cage is rolled over.

* `envelope`: the envelope spectrum of a record (`spectrum_of`, of `LEAST_SAMPLES` at least) and its picture
  (`draw_spectrum`), the words for `DAMAGE`, and the `SPEED_ERROR` within which the shaft's line is searched.
"""

import math


def fault_frequencies(cage: float, spin: float, balls: int, speed: float) -> dict[str, float]:
    """Fault frequencies [Hz] of a cage, a ball's spin about itself and an inner ring that turn so fast [rad/s].

    A spot on a ball strikes a raceway at twice `ball_spin`.
    """
    turn = 0.5 / math.pi
    return {
        "bpfo": abs(balls * cage * turn),
        "bpfi": abs(balls * (speed - cage) * turn),
        "ftf": abs(cage * turn),
        "ball_spin": abs(spin * turn),
    }


def rolling_frequencies(geometry, speed: float) -> dict[str, float]:
    """Fault frequencies [Hz] of balls without load that roll at the nominal contact angle, at a speed [rad/s].

    Cage w (1 - g)/2 and spin w d_m (1 - g^2)/(2 D), g = D cos a/d_m (Harris, Rolling Bearing Analysis, chapter 8);
    `geometry` is that of a bearing scene.
    """
    ratio = geometry.ball_diameter * math.cos(geometry.contact_angle) / geometry.pitch_diameter
    spin = 0.5 * speed * geometry.pitch_diameter / geometry.ball_diameter * (1.0 - ratio**2)
    return fault_frequencies(0.5 * speed * (1.0 - ratio), spin, geometry.balls, speed)
