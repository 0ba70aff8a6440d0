"""What a spot that drills would resist with: the part of friction that a point contact does not hold."""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.contact.ellipse import axis_ratio, elliptic_b_d

SIDES = ("inner", "outer")


class Drilled(NamedTuple):
    """What contacts met, each (N, 2): greatest `load` [N], `curvatures` (2, N, 2) [1/m] there, and how they spun.

    `spin` [rad/s] is the greatest under load, `rubbed` the mean over the outputs of load^(4/3) times spin.
    """

    load: np.ndarray
    curvatures: np.ndarray
    spin: np.ndarray
    rubbed: np.ndarray


def drilling_of(
    contact, met: Drilled, figures: Mapping[str, Any], off: Callable[[float, float], float] | None = None
) -> tuple[np.ndarray, float]:
    """Greatest drilling torque of each ball (N,) [N m], and the power of all, mean over the run [W].

    A spot under pure spin resists with 3/8 mu N a E at most, E the complete elliptic integral of its eccentricity;
    with less where its rim is no faster than friction is smoothed over. `contact` is that of the scene. With `off`,
    what these are off by: a share of that by b/a and the rim's speed [m/s].
    """
    most, power = np.zeros(len(met.load)), 0.0
    for side, name in enumerate(SIDES):
        for ball in np.flatnonzero(met.load[:, side] > 0.0):
            load, major = met.load[ball, side], figures[f"semi_major_{name}_m"][ball]
            ratio = axis_ratio(*(float(one[ball, side]) for one in met.curvatures))
            b, d = elliptic_b_d(ratio)
            greatest = 0.375 * contact.friction_coefficient * load * major * (b + ratio * ratio * d)
            rim = met.spin[ball, side] * major
            share = off(ratio, rim) if off else rim / math.hypot(rim, contact.friction_regularisation)
            most[ball] += greatest * share
            power += greatest * met.rubbed[ball, side] / load ** (4.0 / 3.0) * (share if off else 1.0)
    return most, power
