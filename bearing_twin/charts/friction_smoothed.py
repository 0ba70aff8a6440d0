"""The greatest error of friction over a spot where slip is smoothed, by how fast the spot's end spins against it.

Searched over all motions: slip of any size and direction. What smoothing leaves of a spinning spot depends on b/a and
on the spin times the major semi-axis over the regularising speed alone; the exact means are sums over far more points.
"""

import functools
import math

import numpy as np
from scipy.optimize import minimize

from bearing_twin.contact.spot_rules import over_spot, points
from bearing_twin.kinds.bearing.spot_errors import smoothed_name

SHAPES = (1.0, 0.3, 0.1, 0.03)  # b/a
SHARES = (*map(float, np.geomspace(0.1, 100.0, 31)), math.inf)  # spin times major semi-axis over the regularisation
NEAR, FAR = np.linspace(0.03, 1.15, 34), 3.0
"""Where motions have their poles, the spot scaled to a unit circle: distances on the spot, and the slip over the
regularisation up to which they are looked at beyond it."""
ANGLES = np.linspace(0.0, 0.5 * math.pi, 7)
RINGS, MORE_RINGS, MORE_FROM = 96, 192, 20.0  # of the sums that errors are told against, and from which share on more
ROUNDS = 30
KEPT, TOLD = (1e-2, 1e-3, 1e-4), 0.1  # errors up to which spins are told, and of which b/a


@functools.cache
def _points(rings: int) -> np.ndarray:
    return points(rings, 4 * rings)


@functools.lru_cache(maxsize=1 << 15)
def _exact(shape: float, share: float, along: float, across: float) -> np.ndarray:
    """The means at unit spin and unit major semi-axis, kept: every form is measured at the same motions."""
    rings = MORE_RINGS if share > MORE_FROM else RINGS
    return np.array(over_spot(_points(rings), 1.0, shape, along, across, 1.0, 1.0 / share))


def _slip(shape: float, distance: float, angle: float) -> tuple[float, float]:
    return shape * distance * math.sin(angle), -distance * math.cos(angle)


def errors(form, shape: float, share: float, pure: float, distance: float, angle: float) -> tuple[float, float]:
    """Errors of force, of mu N, and torque, of `pure` spin's over mu N a, of a form at the motion with this pole."""
    slip = _slip(shape, distance, angle)
    off = np.array(form(1.0, 1.0, shape, *slip, 1.0, 1.0, 1.0 / share)) + _exact(shape, share, *slip)
    return math.hypot(off[0], off[1]), abs(off[2]) / pure


def greatest(form, shape: float, share: float, pure: float, near=NEAR) -> tuple[float, float]:
    """The greatest errors of force and of torque of a form at b/a = `shape` and a finite `share`: see `errors`.

    From the two worst of a grid of poles downhill.
    """
    grid = [(d, a) for d in (*near, *np.geomspace(near[-1], near[-1] + FAR / share, 9)[1:]) for a in ANGLES]
    known = np.array([errors(form, shape, share, pure, *pole) for pole in grid])
    found = []
    for part in (0, 1):
        ends = [
            minimize(
                lambda pole, part=part: -errors(form, shape, share, pure, *pole)[part],
                grid[place],
                method="Nelder-Mead",
                options={"maxfev": ROUNDS, "initial_simplex": np.add(grid[place], [(0, 0), (0.02, 0), (0, 0.04)])},
            )
            for place in np.argsort(known[:, part])[-2:]
        ]
        found.append(max(-float(end.fun) for end in ends))
    return found[0], found[1]


def told_smoothed(rows, form: str) -> str:
    """Up to which spin a form keeps each of KEPT whatever the motion, of a chart's rows; "" where nothing was found."""
    mine = [row for row in rows if (row.method, row.problem) == (form, smoothed_name(TOLD))]
    held = [max((row.setting for row in mine if row.friction_error <= one), default=0.0) for one in KEPT]
    if not any(held):
        return ""
    words = (
        f"{one:g} " + (f"up to {most:.2g}" if most < math.inf else "always")
        for one, most in zip(KEPT, held, strict=True)
        if most
    )
    return (
        f"{form}, smoothed, b/a = {TOLD:g}, whatever the motion: within {', '.join(words)} times the regularising "
        "speed at the spot's ends."
    )
