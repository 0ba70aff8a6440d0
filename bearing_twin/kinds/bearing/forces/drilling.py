"""What a spot that drills would resist with: the part of friction that a point contact does not hold."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.special import ellipe

from bearing_twin.contact.ellipse import axis_ratio

SIDES = ("inner", "outer")


def drilling_of(coefficient: float, load, curvatures, rubbed, figures: Mapping[str, Any]) -> tuple[np.ndarray, float]:
    """Drilling torque of each ball (N,) [N m] at its greatest load, and the power of all, mean over the run [W].

    A spot under pure spin resists with 3/8 mu N a E, E the complete elliptic integral of its eccentricity. `load`
    (N, 2) [N] and `curvatures` (2, N, 2) [1/m] are those at the greatest load of each contact; `rubbed` (N, 2) is the
    mean over the outputs of load^(4/3) times spin.
    """
    most, power = np.zeros(len(load)), 0.0
    for side, name in enumerate(SIDES):
        for ball in np.flatnonzero(load[:, side] > 0.0):
            ratio = axis_ratio(*(float(one[ball, side]) for one in curvatures))
            arm = figures[f"semi_major_{name}_m"][ball] * float(ellipe(1.0 - ratio * ratio))
            greatest = 0.375 * coefficient * load[ball, side] * arm
            most[ball] += greatest
            power += greatest * rubbed[ball, side] / load[ball, side] ** (4.0 / 3.0)
    return most, power
