"""How far contact angles of equilibria are off those of balls that move.

Those with axes of spin as in rolling miss friction across the grooves, those whose axes have settled (`settled`)
nothing but what is told with them.

A ball whose contact angle a changes on its way round slips across both grooves, at d da/dt with the distance d from its
centre to a groove's. Friction, mu Q slip/s at slips far below the s that it is smoothed over, resists, and the ball
turns about the tangent so that both contacts resist alike: the angle lags that in balance a_0 as T da/dt = a_0 - a,

    T = (mu/s) 4 Q_i Q_o/(Q_i + Q_o) / (Q_i/d_i + Q_o/d_o),   about mu d/s.

So it does where a ball enters the loaded zone. Friction also carries the gyroscopic moment M_g, as both contacts slip
alike in shares of their loads, which leaves the force 2 (M_g/D)(Q_o - Q_i)/(Q_i + Q_o) across; under thrust that is
0.4 (x/(2 + x))^2 of the angle, x = F_c/Q_i. Both hold before a ball's axis has settled, whose slow turn takes
tau = 5 mu Q d_m/(2 F_c s) and then leaves M_g = 0; equal shares, which balance takes, are near that.
"""

import math

import numpy as np

from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.kinds.bearing.quasi_static.contacts import Contacts
from bearing_twin.kinds.bearing.quasi_static.statics import Equilibrium, EquilibriumSolver, azimuths_of
from bearing_twin.kinds.bearing.quasi_static.turn_table import balanced_on_the_way

LOOKS = 192  # azimuths at which a ball is looked at on its way round
TURNS = 3  # after which a lag repeats itself
BEARS = 1e-2  # of the greatest load: a ball that bears less on its way does not count
STUCK = 0.1  # of the lag's time: what is left of it where friction slips through


def angle_errors(parameters, solver: EquilibriumSolver, found: Equilibrium, lag_alone: bool = False) -> np.ndarray:
    """How far the contact angles (N, 2) [rad] of an equilibrium are off those of moving balls, at least 0.

    The greatest of what a ball meets under load within half a spacing to either side; 0 without friction and at rest.
    Friction over spots may leave all of the gyroscopic moment to the outer raceway, which is told then; `lag_alone` is
    without that moment.
    """
    if not math.isnan(found.settled):
        return np.full(found.contacts.angle.shape, found.settled * np.abs(found.contacts.angle).max())
    azimuths = azimuths_of(LOOKS, float(found.azimuths[0]))
    _, contacts = balanced_on_the_way(solver.setting, found.coordinates, azimuths)
    friction = parameters.contact
    distances, springs = _distances_and_springs(solver, contacts)
    loads = contacts.load.sum(axis=1)
    resisted = np.divide(4.0 * contacts.load.prod(axis=1), loads, out=np.zeros_like(loads), where=loads > 0.0)
    resisted *= friction.friction_coefficient / friction.friction_regularisation
    travel = np.abs(contacts.orbit)
    lags = travel * np.divide(resisted, springs, out=np.zeros_like(springs), where=springs > 0.0)
    paces = travel * distances[:, 1] / friction.friction_regularisation
    inner, outer = contacts.angle.T
    wanted = np.where(contacts.load[:, 0] > 0.0, inner, outer), outer
    order = slice(None) if solver.speed >= 0.0 else slice(None, None, -1)
    late = [np.abs(_late(one[order], lags[order], paces[order])[order]) for one in wanted]
    force = _gyroscopic(friction, contacts) * (not lag_alone)
    turned = np.divide(force, springs, out=np.zeros_like(force), where=springs > 0.0)[:, None] / distances
    bears = contacts.load.min(axis=1) >= BEARS * contacts.load.max()
    return _nearby(np.maximum(*late)[:, None] + turned, bears, azimuths, found.azimuths)


def _distances_and_springs(solver: EquilibriumSolver, contacts: Contacts) -> tuple[np.ndarray, np.ndarray]:
    """Distances of centres (M, 2) [m], and the force per displacement of a ball across its contacts (M,) [N/m]."""
    setting = solver.setting
    reach = np.array([raceway.groove_radius - setting.ball_radius for raceway in (setting.inner, setting.outer)])
    distances = reach + np.maximum(contacts.approach, 0.0)
    return distances, (contacts.load / distances).sum(axis=1)


def _late(wanted: np.ndarray, lags: np.ndarray, paces: np.ndarray) -> np.ndarray:
    """By how much an angle that follows `wanted` (M,) late is off it, at even azimuths in the order that balls take.

    `lags` [rad of the way] are its times; `paces` times what is missing, over the lag, is the slip over that at which
    friction reaches its limit, where the lag is less: r^2 = lag^2 - (pace missing)^2.
    """
    step, late, off = 2.0 * math.pi / LOOKS, float(wanted[-1] - wanted.mean()), np.zeros(LOOKS)
    rows = list(zip(np.diff(wanted, prepend=wanted[-1:]).tolist(), lags.tolist(), paces.tolist(), strict=True))
    for _ in range(TURNS):
        for row, (gained, lag, pace) in enumerate(rows):
            slipping = math.sqrt(max(lag * lag - (pace * (late + gained)) ** 2, (STUCK * lag) ** 2))
            kept = math.exp(-step / slipping) if slipping > 0.0 else 0.0
            late = late * kept + gained * slipping / step * (1.0 - kept)  # exact where `wanted` is straight
            off[row] = late
    return off


def _gyroscopic(friction, contacts: Contacts) -> np.ndarray:
    """The force across a ball (M,) [N] that balance does not have, before the axes of spin settle or after."""
    inner, outer = contacts.load.T
    moment = 0.5 * np.abs(contacts.friction).sum(axis=1)  # over the ball's diameter
    moment = np.minimum(moment, 0.5 * friction.friction_coefficient * (inner + outer))
    uneven = 1.0 if FRICTIONS[friction.friction].over_spot else (outer - inner) / np.maximum(inner + outer, 1e-300)
    in_balance = np.abs(contacts.friction.sum(axis=1))
    return np.maximum(np.abs(2.0 * moment * uneven - in_balance), in_balance) * (inner > 0.0)


def _nearby(errors: np.ndarray, bears: np.ndarray, azimuths: np.ndarray, balls: np.ndarray) -> np.ndarray:
    """The greatest errors (M, 2) within half a spacing of each ball, and where it is: there also if nothing `bears`."""
    away = np.abs(np.remainder(azimuths[None, :] - balls[:, None] + math.pi, 2.0 * math.pi) - math.pi)
    near = (away <= math.pi / len(balls)) & bears | (away <= math.pi / LOOKS * (1.0 + 1e-9))
    return np.where(near[:, :, None], errors[None, :, :], 0.0).max(axis=1)
