"""What impacts lose to elastic waves: two estimates for slow impacts of spheres, which no law of contact holds."""

import math

RAYLEIGH = 0.02  # 1/50
HUNTER = 1.04  # Poisson's ratio 1/4


def bar_speed(young_modulus: float, density: float) -> float:
    """sqrt(E/rho) [m/s], the speed of waves in a thin bar."""
    return math.sqrt(young_modulus / density)


def restitution_lost_between_spheres(speed: float, wave_speed: float) -> float:
    """1 - e of two equal spheres that meet with a relative `speed` [m/s]: half of the share that goes into vibration.

    v / (50 c): Rayleigh, Philosophical Magazine 11 (1906) 283. Breaks for speeds near that of waves.
    """
    return 0.5 * min(1.0, RAYLEIGH * speed / wave_speed)


def restitution_lost_on_half_space(speed: float, wave_speed: float) -> float:
    """1 - e of a sphere on a half-space of its material: half of the share that waves carry away.

    1.04 (v / c)^(3/5): Hunter, J. Mech. Phys. Solids 5 (1957) 162. Breaks for speeds near that of waves.
    """
    return 0.5 * min(1.0, HUNTER * (speed / wave_speed) ** 0.6)
