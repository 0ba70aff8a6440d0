"""One part of a chunk by whichever stepper: balls alone, balls that may touch, or all of them with ring and cage."""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import IntegrationError, Stopped
from bearing_twin.kinds.bearing import compiled_balls, compiled_coupled
from bearing_twin.kinds.bearing.scipy_chunk import scipy_chunk
from bearing_twin.kinds.bearing.system import BORDER, COLUMNS, Bearing, Partners, RingDrive
from bearing_twin.numerics.statuses import NOT_FINITE, OK, STALLED, STOPPED, TOO_DEEP, WORDS
from bearing_twin.numerics.steppers import EXPLICIT, ROSENBROCK

REFERENCE_SHARE = 1e-4  # of the scales, for SciPy's methods, whose only use here is to be right
SCIPY = {"dop853": "DOP853", "radau": "Radau"}


FAILURES = {
    NOT_FINITE: "is not finite any more; shorten solver.step or use solver.stepper: rodas4",
    TOO_DEEP: "has run through a raceway; check the loads, or shorten solver.step",
    STALLED: "needs ever shorter steps; loosen wanted.tolerance or raise contact.friction_regularisation",
}


class Results(NamedTuple):
    """What a chunk fills in; `stop` (1,) is looked at before every step, and ends the chunk when it is not 0.

    `carried` (N, CARRIED_COLUMNS) is what the law carries at each ball's contacts, at the chunk's start and its end.
    `border` (len(times), BORDER) and `last_border` (BORDER,) are those of ring and cage, where a method moves them.
    """

    states: np.ndarray
    orientations: np.ndarray
    counts: np.ndarray
    failure: np.ndarray
    stop: np.ndarray
    carried: np.ndarray
    border: np.ndarray
    last_border: np.ndarray


class Chunk(NamedTuple):
    """What is integrated: `near` (N,) says which balls may meet the next, `times` [s] are wanted within `duration`.

    `step` [s] is that of methods with fixed steps, `scales` (MOTION,) are the errors of a step of the others.
    """

    bearing: Bearing
    drive: RingDrive
    partners: Partners
    near: np.ndarray
    times: np.ndarray
    duration: float
    step: float
    scales: np.ndarray


class PartRoom:
    """Room for states (count, N, COLUMNS), orientations (count, N, 4) and borders (count, BORDER) of a part.

    Parts take turns: memory that is new to a process costs more than the numbers written into it.
    """

    def __init__(self):
        self._room: list[np.ndarray] = []

    def empty(self, count: int, balls: int) -> tuple[np.ndarray, ...]:
        """That of the next part, all NaN; the arrays handed out before are overwritten."""
        if not self._room or len(self._room[0]) < count:
            self._room = [np.empty((count, *shape)) for shape in ((balls, COLUMNS), (balls, 4), (BORDER,))]
        states, orientations, borders = self._room
        arrays = states[:count], orientations[:count], borders[:count]
        for one in arrays:
            one.fill(math.nan)
        return arrays


def instants_in(times: np.ndarray, begin: float, end: float) -> np.ndarray:
    """Those `times` [s] of a chunk, within rounding of its part from `begin` to `end`, as counted from its begin."""
    if begin == 0.0 and not (len(times) and times[-1] > end):  # as nearly always
        return np.array(times, float)
    return np.minimum(times - begin, end - begin)


def integrated(stepper: str, chunk: Chunk, moving, results) -> int:
    """Moves (state, orientation, steps) on in place and fills `results`; returns the status."""
    if stepper == "imex":  # its losses are of first order, those of damping, which are less than the work of loads
        return compiled_balls.advance_together(chunk.bearing, chunk.drive, None, chunk, moving, results)
    if not np.count_nonzero(chunk.near):  # in a fifth of the time of `any`
        return _with_losses(stepper, chunk, moving, results)
    compiled_balls.add_stored(chunk.bearing, chunk.near, 1.0, moving[0])
    status = _with_losses(stepper, chunk, moving, results)
    for states in (moving[0], results.states):
        compiled_balls.add_stored(chunk.bearing, chunk.near, -1.0, states)
    return status


def _with_losses(stepper: str, chunk: Chunk, moving, results) -> int:
    """`integrated` where the integral of losses takes in what contacts of balls store."""
    if stepper in ROSENBROCK:
        return _by_rosenbrock(ROSENBROCK[stepper], chunk, moving, results)
    if stepper in EXPLICIT:
        return compiled_balls.advance_together(chunk.bearing, chunk.drive, EXPLICIT[stepper], chunk, moving, results)
    from scipy import integrate  # late: these methods are for charts and tests

    what = chunk.bearing, chunk.drive, chunk.near, chunk.times, chunk.duration
    return scipy_chunk(getattr(integrate, SCIPY[stepper]), *what, REFERENCE_SHARE * chunk.scales, *moving[:2], results)


def check(status: int, elapsed: float, failure: np.ndarray) -> None:
    """Raises Stopped or IntegrationError for a status that is not OK of what began at `elapsed` [s]."""
    if status == STOPPED:
        raise Stopped(f"the computation was stopped at {elapsed:.9g} s")
    if status != OK:
        seconds, body = elapsed + failure[0], f"ball {int(failure[1])}"
        raise IntegrationError(f"at {seconds:.9g} s {body} {FAILURES[status]}", WORDS[status], seconds, body)


def groups_of(near) -> list[list[int]]:
    """Cuts the ring of balls into rows of neighbours that may meet; `near[k]` (N,) speaks of balls k and k + 1."""
    balls = len(near)
    first = next((k for k in range(balls) if not near[k - 1]), 0)
    groups = [[first]]
    for k in range(first + 1, first + balls):
        if near[(k - 1) % balls]:
            groups[-1].append(k % balls)
        else:
            groups.append([k % balls])
    return groups


def _by_rosenbrock(method, chunk: Chunk, moving, results) -> int:
    """Balls that touch no other side by side, then each group of balls that may touch.

    Where the rings' motion is prescribed and there is no cage, a ball acts on another only where they touch.
    """
    bearing, drive, partners, near = chunk.bearing, chunk.drive, chunk.partners, chunk.near
    if partners.active:
        alone, together = [], [range(len(near))]
    elif np.count_nonzero(near):
        groups = groups_of(near)
        alone, together = [group[0] for group in groups if len(group) == 1], [one for one in groups if len(one) > 1]
    else:
        alone, together = np.arange(len(near)), []
    status = compiled_balls.advance(bearing, drive, method, chunk, alone, moving, results) if len(alone) else OK
    for group in together:
        if status == OK:
            status = compiled_coupled.advance(bearing, drive, method, chunk, near, partners, group, moving, results)
    return status
