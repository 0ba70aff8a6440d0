"""What goes wrong with numbers that the product puts right, left as they are: a quaternion's norm, a round spot's axis.

The norm of a quaternion that is turned by the product's own steps of `rk4` falls by (turn/2)^6/144 a step; runs put it
right after each. The axis of a nearly round spot is the direction of the smaller curvature of the gap, which rounding
turns by about 1e-16 (Q + P)/(Q - P); `contact_of` gives none below CIRCULAR.
"""

import math

import numpy as np

from bearing_twin.charts.body_limits import motion_of
from bearing_twin.charts.contest import judged
from bearing_twin.charts.table import MapRow
from bearing_twin.kinds.ellipsoid.equations import QUATERNION
from bearing_twin.kinds.ellipsoid.figures import GREATEST_DRIFT
from bearing_twin.kinds.ellipsoid.steps import flight_scales, one_step
from bearing_twin.numerics.rotation import quaternion_from_vector, rotation_matrix
from bearing_twin.shapes.implicit import ellipsoid, plane
from bearing_twin.shapes.tracking import CIRCULAR, body, contact_of, find_opposing, second_form

RADIUS = 0.01  # m, of the body that lies on a plane
ROUND = "the spot is circular: no axis is given"
TOLD_FROM = {"quaternion": 2.0 * (144.0 * GREATEST_DRIFT) ** (1.0 / 6.0), "axis": CIRCULAR}
"""By map: the turn [rad] a step from which a run tells the drift, the (Q - P)/(Q + P) from which an axis is given."""


def quaternion(row: MapRow, limit: float) -> MapRow:
    """The norm after `setting` steps of a body in flight that turns by `across` [rad] a step."""
    motion = motion_of("rk4", "start.height=1", "start.angular_velocity=[1,0,0]", "gravity=[0,0,0]")
    state, work = motion.state, motion.work()

    def outcome():
        flight_scales(motion.plan, work)
        for _ in range(round(row.setting)):
            one_step(motion.body, motion.plan.method, state, row.across, False, work, work.after)
            state[:] = work.after
        return {"load_error": abs(float(np.linalg.norm(state[QUATERNION : QUATERNION + 4])) - 1.0)}

    return judged(row, outcome, limit)


def axis(row: MapRow, limit: float) -> MapRow:
    """The error [rad] of the axis where (Q - P)/(Q + P) is `across` and the body is turned by `setting` [rad]."""

    def outcome():
        # An ellipsoid has the curvatures z/x^2 and z/y^2 at its pole.
        long, short = (RADIUS * (1.0 + sign * row.across) ** -0.5 for sign in (-1.0, 1.0))
        turn = rotation_matrix(quaternion_from_vector((0.0, 0.0, row.setting)))
        rests, ground = body(ellipsoid(long, short, RADIUS), (0.0, 0.0, RADIUS), turn), body(plane())
        told = contact_of(rests, ground, find_opposing(rests, ground, np.zeros(3)))
        along = np.linalg.eigh(second_form(rests, np.zeros(3), np.eye(3)[:2]))[1][:, 0]
        off = math.remainder(math.atan2(along[1], along[0]) - row.setting, math.pi)
        return {"load_error": abs(off), "reason": ROUND if told.circular else ""}

    return judged(row, outcome, limit)


def sentences_of(rows: list[MapRow]) -> list[str]:
    """What the maps of this module say, from their numbers."""
    return [*_of_quaternion([row for row in rows if row.problem == "quaternion"]), *_of_axis(rows)]


def _of_quaternion(rows):
    if not rows:
        return []
    most, fewest = max(row.setting for row in rows), min(row.setting for row in rows)
    near = min((row for row in rows if row.setting == most), key=lambda row: abs(math.log(row.across)))
    drifts = [row.across for row in rows if row.setting == fewest and row.error > fewest * GREATEST_DRIFT]
    least = f"the least with more is {min(drifts):.2g} rad" if drifts else "none has more"
    return [
        f"Quaternion left alone: {near.across:g} rad a step takes {100.0 * near.error:.2g} % of the norm in {most:g} "
        f"steps. Runs put it right after each step and tell a drift above {GREATEST_DRIFT:g}, which is predicted from "
        f"{TOLD_FROM['quaternion']:.2g} rad a step on; of the turns tried {least}."
    ]


def _of_axis(rows):
    mine = [row for row in rows if row.problem == "axis"]
    below, above = ([row.error for row in mine if (row.across < CIRCULAR) == side] for side in (True, False))
    if not (below and above):
        return []
    return [
        f"Axis of a nearly round spot: rounding turns it by up to {max(below):.2g} rad below (Q - P)/(Q + P) = "
        f"{CIRCULAR:g}, where none is given, and by at most {max(above):.1g} rad above."
    ]
