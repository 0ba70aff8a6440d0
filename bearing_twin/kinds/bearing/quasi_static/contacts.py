"""What stands in every contact of a bearing in balance: load, angle, approach, curvatures, and the balls' speeds."""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.kinds.bearing.quasi_static.forces import LEVEL, orbit_and_roll, push_of, speeds_of


class Contacts(NamedTuple):
    """Arrays (N, 2), inner and outer; `friction` [N] is along t and carries the gyroscopic moment.

    A ball's row (N,): `orbit` [rad/s], `roll` [rad/s] along the axis and `pitch` [rad/s] along the radius, both of the
    ball against its orbit; `centrifugal` [N]. Angles count where there is no load too.
    """

    approach: np.ndarray
    load: np.ndarray
    angle: np.ndarray
    friction: np.ndarray
    curvature_small: np.ndarray
    curvature_large: np.ndarray
    orbit: np.ndarray
    roll: np.ndarray
    pitch: np.ndarray
    centrifugal: np.ndarray


def empty_contacts(balls: int) -> Contacts:
    """Room for the contacts of so many balls."""
    return Contacts(*(np.zeros((balls, 2)) for _ in range(6)), *(np.zeros(balls) for _ in range(4)))


@kernel
def write_contacts(setting, azimuths, q, place, out):
    """Fills `out` (`Contacts`) with the balls at their places, the ring at `q`."""
    ball = 1.0 / setting.ball_radius
    for k in range(len(azimuths)):
        opening_r = setting.inner.locus_radius - setting.outer.locus_radius
        opening_r += q[0] * azimuths[k, 0] + q[1] * azimuths[k, 1]
        opening_z = q[2] + setting.arm * (q[3] * azimuths[k, 1] - q[4] * azimuths[k, 0])
        inner = push_of(setting, setting.inner, -1.0, opening_r - place[k, 0], opening_z - place[k, 1])
        outer = push_of(setting, setting.outer, 1.0, place[k, 0], place[k, 1])
        speeds = speeds_of(setting, inner, outer)
        gyroscopic = speeds.gyroscopic if inner.load > 0.0 else 0.0
        out.friction[k, 0] = setting.share_inner * gyroscopic
        out.friction[k, 1] = -setting.share_outer * gyroscopic
        out.centrifugal[k] = speeds.centrifugal
        for side in range(2):
            push = inner if side == 0 else outer
            raceway = setting.inner if side == 0 else setting.outer
            towards = -push.n_r if side == 0 else push.n_r
            out.approach[k, side] = push.approach
            out.load[k, side] = push.load
            out.angle[k, side] = math.atan2(push.n_z, push.n_r)
            bottom = raceway.locus_radius + raceway.groove_radius * towards
            out.curvature_small[k, side] = 0.5 * (ball - 1.0 / raceway.groove_radius)
            out.curvature_large[k, side] = 0.5 * (ball - towards / bottom)
        gamma = 2.0 * setting.ball_radius / setting.pitch_diameter
        if inner.load > 0.0 and inner.n_r >= LEVEL and outer.n_r >= LEVEL:
            out.orbit[k], out.pitch[k], out.roll[k] = orbit_and_roll(setting, inner, outer)
        else:
            out.orbit[k], out.pitch[k] = 0.5 * setting.speed * (1.0 - gamma), 0.0
            out.roll[k] = 0.5 * setting.speed * (1.0 - gamma * gamma) / gamma


@kernel
def shared(contacts, values):
    """What balls in one cage share of `values` (N,), such as orbit speeds: the mean by load on the inner ring."""
    weight, total = 0.0, 0.0
    for k in range(len(values)):
        weight += contacts.load[k, 0]
        total += contacts.load[k, 0] * values[k]
    return total / weight if weight > 0.0 else values.mean()
