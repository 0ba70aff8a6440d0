"""What stands in every contact of a bearing in balance: load, angle, approach, curvatures, and the balls' speeds."""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.parameters import GREATEST_ANGLE, GREATEST_SQUEEZE
from bearing_twin.kinds.bearing.quasi_static.forces import LEVEL, orbit_and_roll, push_of, speeds_of
from bearing_twin.kinds.bearing.quasi_static.opening import opening_of
from bearing_twin.shapes.surfaces import groove_curvatures

IDLE = 1e-3  # of the greatest load: below it the angle of a contact has no limit


class Contacts(NamedTuple):
    """Arrays (N, 2), inner and outer; `friction` [N] is along t, `along` [N] on the ball along its orbit.

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
    along: np.ndarray


def empty_contacts(*shape: int) -> Contacts:
    """Room for the contacts of balls in arrays of this shape, the last that of the balls."""
    sides = *shape, 2
    return Contacts(*(np.zeros(sides) for _ in range(6)), *(np.zeros(shape) for _ in range(4)), np.zeros(sides))


@inlined
def curvatures_at(setting, raceway, side, n_r):
    """Curvatures (small, large) of the gap [1/m] where the normal's radial part is `n_r`; `side` -1 inner, 1 outer."""
    return groove_curvatures(setting.ball_radius, raceway.locus_radius, raceway.groove_radius, side * n_r)


@kernel
def write_contacts(setting, azimuths, q, place, out):
    """Fills `out` (`Contacts`) with the balls at their places, the ring at `q`."""
    for k in range(len(azimuths)):
        opening = opening_of(setting, azimuths[k, 0], azimuths[k, 1], q)
        inner = push_of(setting, setting.inner, opening.radial - place[k, 0], opening.axial - place[k, 1])
        outer = push_of(setting, setting.outer, place[k, 0], place[k, 1])
        speeds = speeds_of(setting, inner, outer)
        gyroscopic = speeds.gyroscopic if inner.load > 0.0 else 0.0
        out.friction[k, 0] = setting.share_inner * gyroscopic
        out.friction[k, 1] = -setting.share_outer * gyroscopic
        out.along[k, 0] = out.along[k, 1] = 0.0
        out.centrifugal[k] = speeds.centrifugal
        for side in range(2):
            push = inner if side == 0 else outer
            raceway = setting.inner if side == 0 else setting.outer
            out.approach[k, side] = push.approach
            out.load[k, side] = push.load
            out.angle[k, side] = math.atan2(push.n_z, push.n_r)
            small, large = curvatures_at(setting, raceway, 2.0 * side - 1.0, push.n_r)
            out.curvature_small[k, side], out.curvature_large[k, side] = small, large
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


def contacts_at(setting, directions: np.ndarray, q: np.ndarray, place: np.ndarray) -> Contacts:
    """The contacts of balls at these places, the ring at `q` (5,)."""
    contacts = empty_contacts(len(directions))
    write_contacts(setting, directions, q, place, contacts)
    return contacts


def limits_used(setting, load, approach, angle) -> tuple[np.ndarray, np.ndarray]:
    """Squeeze and greatest contact angle of each ball, each over its limit, from arrays (..., N, 2) of both raceways.

    The angle of a contact that bears less than IDLE of the greatest load does not count: no edge of a groove feels it.
    """
    squeeze = np.where((load > 0.0).all(-1), approach.sum(-1), 0.0)
    greatest = np.where(load > IDLE * load.max(axis=(-2, -1), keepdims=True), np.abs(angle), 0.0).max(-1)
    return squeeze / (GREATEST_SQUEEZE * 2.0 * setting.ball_radius), greatest / GREATEST_ANGLE
