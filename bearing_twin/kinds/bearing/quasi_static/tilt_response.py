"""How a bearing in balance answers that a true ring keeps its shape as it tilts, which one of first order does not.

Seen by a ball whose point of the circle of groove centres a tilt lifts by R b, a true circle is nearer to the axis by
R b^2/2 (`tilt_error`). That presses contacts less, as if they bore less than their law gives, and takes a moment of
R b d(b)/d(tilt) times the load across the axis off what holds the tilt.
"""

import numpy as np

from bearing_twin.kinds.bearing.quasi_static.response import Response, followed, pushed_by, response_of
from bearing_twin.kinds.bearing.quasi_static.statics import Equilibrium, EquilibriumSolver, Support


def response_to_tilt(solver: EquilibriumSolver, support: Support, found: Equilibrium) -> Response | None:
    """What the true circle changes, in first order; None of a ring that is not tilted."""
    setting, contacts, tilt = solver.setting, found.contacts, found.coordinates[3:]
    if not tilt.any():
        return None
    lever = np.stack([solver.directions[:, 1], -solver.directions[:, 0]], axis=1)  # b by the tilts
    lifted = lever @ tilt
    cosine = np.cos(contacts.angle[:, 0])
    load, approach = contacts.load, contacts.approach
    power = np.array([setting.inner.law.power, setting.outer.law.power])
    yields = np.divide(approach, power * load, out=np.zeros_like(load), where=load > 0.0).sum(axis=1)  # m/N
    less = -0.5 * setting.arm * lifted**2 * cosine
    off = np.divide(less, yields, out=np.zeros_like(less), where=yields > 0.0)
    shares = np.divide(off[:, None], load, out=np.zeros_like(load), where=load > 0.0)
    pressed = response_of(solver, support, found, shares)
    loads = np.zeros(5)
    loads[3:] = -setting.arm * (load[:, 0] * cosine * lifted) @ lever
    moved, ring = followed(solver, support, found, loads)
    more, angles = pushed_by(solver, found, np.zeros_like(load)).contacts(moved)
    return Response(
        pressed.loads + more, pressed.angles + angles, pressed.coordinates + moved, pressed.ring_loads + ring
    )
