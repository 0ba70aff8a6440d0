"""Integration of one part of a chunk by any stepper: balls alone, balls that may touch, all with ring, cage and shaft.

Methods of SciPy, for reference, integrate the same equations.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import IntegrationError, Stopped
from bearing_twin.core import FLAGS_OUT, INTEGER, REAL, REALS, Function
from bearing_twin.kinds.bearing.compiled import add_stored, advance_common, advance_coupled, advance_free, rates
from bearing_twin.kinds.bearing.system import (
    AXIAL_SPIN,
    AXIS_DISTANCE,
    BORDER,
    COLUMNS,
    MOTION,
    RADIAL_SPIN,
    TANGENTIAL_SPIN,
    TANGENTIAL_VELOCITY,
    Bearing,
    CoupledBodies,
    RingDrive,
)
from bearing_twin.numerics.methods import (
    EVALUATIONS,
    JACOBIANS,
    NOT_FINITE,
    OK,
    STALLED,
    STEPS,
    STOPPED,
    TOO_DEEP,
    WORDS,
)
from bearing_twin.numerics.rotation import turned
from bearing_twin.numerics.steppers import EXPLICIT, NOTHING, ROSENBROCK

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
    bodies: CoupledBodies
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
        return advance_common(chunk.bearing, chunk.drive, None, chunk, moving, results)
    if not np.count_nonzero(chunk.near):  # in a fifth of the time of `any`
        return _with_losses(stepper, chunk, moving, results)
    add_stored(chunk.bearing, chunk.near, 1.0, moving[0])
    status = _with_losses(stepper, chunk, moving, results)
    for states in (moving[0], results.states):
        add_stored(chunk.bearing, chunk.near, -1.0, states)
    return status


def _with_losses(stepper: str, chunk: Chunk, moving, results) -> int:
    """`integrated` where the integral of losses takes in what contacts of balls store."""
    if stepper in ROSENBROCK:
        return _by_rosenbrock(ROSENBROCK[stepper], chunk, moving, results)
    if stepper in EXPLICIT:
        return advance_common(chunk.bearing, chunk.drive, EXPLICIT[stepper], chunk, moving, results)
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
    bearing, drive, bodies, near = chunk.bearing, chunk.drive, chunk.bodies, chunk.near
    if bodies.active:
        alone, together = [], [range(len(near))]
    elif np.count_nonzero(near):
        groups = groups_of(near)
        alone, together = [group[0] for group in groups if len(group) == 1], [one for one in groups if len(one) > 1]
    else:
        alone, together = np.arange(len(near)), []
    status = advance_free(bearing, drive, method, chunk, alone, moving, results) if len(alone) else OK
    for group in together:
        if status == OK:
            status = advance_coupled(bearing, drive, method, chunk, near, bodies, group, moving, results)
    return status


# Where balls have steps of their own, only those that may soon meet share steps, and only for a while: balls that share
# a step go at the pace of the one with the shortest, and repeat their steps where one lands, so that 20 ms of balls
# that hop cost 15 times as much.
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


def scipy_chunk(solver, bearing, drive, near, times, duration, scales, state, orientation, results):
    """Advances all balls together, by a SciPy solver's class.

    `scales` (MOTION,) are the absolute errors allowed in a step. Raises Stopped soon after the flag in `results` is not
    0.
    """
    shape = state.shape

    def right_hand_side(time, flat):
        if results.stop[0] != 0:
            raise Stopped("the computation was stopped within a chunk")
        speed = drive.speed + drive.acceleration * time
        angle = drive.angle + time * (drive.speed + 0.5 * drive.acceleration * time)
        return rates(bearing, speed, near, np.ascontiguousarray(flat.reshape(shape)), angle).ravel()

    method = solver(
        right_hand_side,
        0.0,
        state.ravel().copy(),
        duration,
        rtol=2.3e-14,
        atol=np.tile(np.concatenate([scales, [1e-12] * (COLUMNS - MOTION)]), len(state)),
        first_step=min(1e-7, duration),
    )
    cursor = 0
    while method.status == "running":
        # SciPy probes the integrals, on which nothing depends, with ever greater increments.
        with np.errstate(over="ignore"):
            method.step()
        finite = np.isfinite(method.y.reshape(shape)).all(axis=1)
        if method.status == "failed" or not finite.all():
            fastest = np.abs(right_hand_side(method.t, method.y).reshape(shape)[:, :MOTION] / scales).max(axis=1)
            ball = fastest.argmax() if finite.all() else finite.argmin()
            results.failure[:2] = method.t, ball
            return NOT_FINITE if not finite.all() else STALLED
        dense = method.dense_output()
        start = dense(method.t_old).reshape(shape)
        while cursor < len(times) and times[cursor] <= method.t:
            _turn_all(dense, method.t_old, times[cursor], start, orientation, results.orientations[cursor])
            results.states[cursor] = dense(times[cursor]).reshape(shape)
            cursor += 1
        _turn_all(dense, method.t_old, method.t, start, orientation, orientation)
    state[:] = method.y.reshape(shape)
    results.counts[STEPS] += method.nfev // 12 * len(state)
    results.counts[EVALUATIONS] += method.nfev * len(state)
    results.counts[JACOBIANS] += method.njev * len(state)
    return OK


def _turn_all(dense, begin, end, start, orientation, out):
    middle, last = (dense(t).reshape(start.shape) for t in (0.5 * (begin + end), end))
    for k in range(len(start)):
        spins = _spin_in_frame(start[k]), _spin_in_frame(middle[k]), _spin_in_frame(last[k])
        out[k] = turned(tuple(orientation[k]), *spins, end - begin)


def _spin_in_frame(row):
    """Angular velocity [rad/s] of a ball (COLUMNS,) against the frame that turns with it about the axis."""
    return row[RADIAL_SPIN], row[TANGENTIAL_SPIN], row[AXIAL_SPIN] - row[TANGENTIAL_VELOCITY] / row[AXIS_DISTANCE]
