"""A part of a chunk in which balls have steps of their own but where they may soon meet.

Balls that share a step go at the pace of the one with the shortest, and have all their steps made again where one
lands: 20 ms of balls that hop cost 15 times as much. So only those share it that are close, and only for a while.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bearing_twin.core import FLAGS_OUT, INTEGER, REAL, REALS, Function
from bearing_twin.kinds.bearing.integrate import instants_in
from bearing_twin.numerics.steppers import NOTHING

NEAR = 0.05  # gap / ball radius below which two balls may meet
MET = 0.5 * NEAR  # the same of balls that came together
SOON = 1e-3  # s for which balls that may meet are integrated together before the next look
LONGER, SHORTER = 2.0, 0.25  # of stretches in which none may meet: after one in which none did, and after another
EVERYWHERE = 1e9  # m: a gap that no two balls that can meet exceed

_mark_near = Function("core_mark_near", None, (REAL, REALS, INTEGER, REAL, REAL, FLAGS_OUT))
_mark_met = Function("core_mark_met", INTEGER, (REAL, REALS, INTEGER, REALS, INTEGER, REAL, FLAGS_OUT))
_time_apart = Function("core_time_apart", REAL, (REAL, REALS, INTEGER, REAL))


def time_apart(ball_radius: float, state: np.ndarray, reach: float) -> float:
    """Seconds for which no two balls can come closer than `reach` [m], by their present speeds."""
    return _time_apart(ball_radius, state, len(state), reach)


class PartBalls(NamedTuple):
    """The balls of a part, of one `radius` [m].

    `near` (N,) says who is integrated together with the next ahead, as those must be who may touch it; `moving` are the
    arrays that an integration moves on in place, the state (N, ...) first.
    """

    radius: float
    near: np.ndarray
    moving: list[np.ndarray]

    def mark_near(self, reach: float, ahead: float, near: np.ndarray) -> None:
        """Sets `near` (N,) where two may come closer than `reach` [m] within `ahead` [s]."""
        state = self.moving[0]
        _mark_near(self.radius, state, len(state), reach, ahead, near)

    def mark_met(self, states: np.ndarray, near: np.ndarray) -> bool:
        """Sets `near` (N,) for those who have met, now or in `states` (instants, N, ...); whether any was not set."""
        state = self.moving[0]
        return bool(_mark_met(self.radius, state, len(state), states, len(states), MET * self.radius, near))

    def put_back(self, before: list[np.ndarray]) -> None:
        """Back to where they were."""
        for one, kept in zip(self.moving, before, strict=True):
            one[:] = kept


def integrate_in_common(
    integrate: Callable, balls: PartBalls, times: np.ndarray, duration: float, filled: tuple, apart: bool, even: bool
) -> None:
    """Integrates a part of balls that share steps with a ring or a cage, or that are kept `apart`; sets `near`.

    Where two met that were not near, which no `even` cage lets them, once more with all near. `integrate` is as for
    `integrate_alone`.
    """
    before = [one.copy() for one in balls.moving]
    if not apart:
        balls.mark_near(NEAR * balls.radius, duration, balls.near)
    integrate(balls.near, 0.0, times, duration, filled)
    if even or not balls.mark_met(filled[0], balls.near):
        return
    balls.put_back(before)
    balls.mark_near(EVERYWHERE, 0.0, balls.near)
    integrate(balls.near, 0.0, times, duration, filled)


def integrate_alone(integrate: Callable, balls: PartBalls, times: np.ndarray, duration: float, filled: tuple) -> None:
    """Integrates a part of balls that act on each other only where they touch; sets `near` for all that were so.

    `integrate(near, begin, times, duration, filled)` moves the balls on over `duration` [s] from `begin` [s] of the
    part and fills the arrays of `filled` at `times` [s] from there. A stretch in which two met that were not near is
    done again, shorter or with them near. Raises what `integrate` raises.
    """
    first, begin, ahead = 0, 0.0, duration
    met = np.zeros_like(balls.near)
    while begin < duration:
        left, near = duration - begin, met.copy()
        balls.mark_near(NEAR * balls.radius, min(SOON, left), near)
        near |= met
        length = min(SOON if near.any() else ahead, left)
        ends = length >= left - NOTHING * duration
        long, length = length > SOON, left if ends else length  # the last one may be longer than SOON by rounding
        last = len(times) if ends else int(np.searchsorted(times, begin + length, side="right"))
        before, into = [one.copy() for one in balls.moving], tuple(one[first:last] for one in filled)
        integrate(near, begin, instants_in(times[first:last], begin, begin + length), length, into)
        found = near.copy()
        if balls.mark_met(into[0], found):
            balls.put_back(before)
            # Found late in a long stretch: up to there they are alone.
            met, ahead = (met, max(SHORTER * length, SOON)) if long else (found, ahead)
            continue
        balls.near[near] = True
        met, ahead = np.zeros_like(met), max(LONGER * length, SOON)
        first, begin = last, duration if ends else begin + length
