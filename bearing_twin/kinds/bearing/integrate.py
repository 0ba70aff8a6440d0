"""Integration of a part of a chunk by any stepper: balls alone, balls that may touch, all with ring, cage and shaft.

Methods of SciPy, for reference, integrate the same equations.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import IntegrationError, Stopped
from bearing_twin.coefficients import EXPLICIT
from bearing_twin.core import (
    FLAG,
    FLAGS,
    FLAGS_OUT,
    INTEGER,
    INTEGERS,
    INTEGERS_OUT,
    REAL,
    REALS,
    REALS_OUT,
    Function,
)
from bearing_twin.kinds.bearing.system import (
    AXIAL_SPIN,
    AXIS_DISTANCE,
    COLUMNS,
    MOTION,
    RADIAL_SPIN,
    TANGENTIAL_SPIN,
    TANGENTIAL_VELOCITY,
    Bearing,
    CoupledBodies,
    RingDrive,
    method_numbers,
    numbers_of,
    numbers_of_bodies,
    runge_kutta_numbers,
)
from bearing_twin.methods import (
    EVALUATIONS,
    JACOBIANS,
    NOT_FINITE,
    NOTHING,
    OK,
    STALLED,
    STEPS,
    STOPPED,
    TOO_DEEP,
    WORDS,
)
from bearing_twin.shapes import turned

REFERENCE_SHARE = 1e-4  # of the scales, for SciPy's methods, whose only use here is to be right
SCIPY = {"dop853": "DOP853", "radau": "Radau"}
FAILURES = {
    NOT_FINITE: "is not finite any more; shorten solver.step or use solver.stepper: rodas4",
    TOO_DEEP: "has run through a raceway; check the loads, or shorten solver.step",
    STALLED: "needs ever shorter steps; loosen wanted.tolerance or raise contact.friction_regularisation",
}

_free_balls = Function(
    "core_free_balls",
    INTEGER,
    (*(REALS,) * 5, REAL, INTEGER, REALS, FLAG, INTEGER, INTEGERS, INTEGER, *(REALS_OUT,) * 6, INTEGERS_OUT, REALS_OUT),
)
_common_balls = Function(
    "core_common_balls",
    INTEGER,
    (
        *(*(REALS,) * 5, REAL, REAL, INTEGER, REALS, FLAG, INTEGER, FLAGS),
        *(*(REALS_OUT,) * 5, INTEGERS_OUT, REALS_OUT, REALS_OUT),
    ),
)
_coupled_balls = Function(
    "core_coupled_balls",
    INTEGER,
    (
        *(*(REALS,) * 8, REAL, INTEGER, REALS, FLAG, INTEGER, INTEGERS, FLAG, INTEGER),
        *(*(REALS_OUT,) * 8, INTEGERS_OUT, REALS_OUT),
    ),
)
_all_rates = Function("core_all_rates", None, (REALS, REALS, REAL, REAL, INTEGER, FLAGS, REALS, REALS_OUT))
_add_stored = Function("core_add_stored", None, (REALS, REALS, INTEGER, FLAGS, REAL, INTEGER, REALS_OUT))


class Chunk(NamedTuple):
    """A part of a chunk that is integrated by one call.

    `near` (N,) says which balls may touch the next ahead; `step` [s] is that of methods with fixed steps, `scales`
    (MOTION + 1,) are the errors of a step of the others; a `stop` (1,) that is not 0 ends it before the next step.
    Moved on in place are `state` (N, COLUMNS), `orientation` (N, 4), the balls' `steps` (N,) [s], the states of laws
    `carried` (N, CARRIED_COLUMNS), and `body_state` (BODY_COLUMNS,), that of ring, cage and shaft; outputs are filled
    in at `times` (n,) [s] within `duration`. `counts` (4,) are added to; `failure` (2,) is time and ball.
    """

    bearing: Bearing
    drive: RingDrive
    bodies: CoupledBodies
    near: np.ndarray
    times: np.ndarray
    duration: float
    step: float
    scales: np.ndarray
    stop: np.ndarray
    state: np.ndarray
    orientation: np.ndarray
    steps: np.ndarray
    carried: np.ndarray
    body_state: np.ndarray
    states: np.ndarray
    orientations: np.ndarray
    body_states: np.ndarray
    counts: np.ndarray
    failure: np.ndarray


def _drive_numbers(drive: RingDrive) -> np.ndarray:
    return np.array([drive.speed, drive.acceleration, drive.angle], float)


def _free(method: str, chunk: Chunk, balls) -> int:
    """Moves the numbered `balls` that touch no other through a chunk, each with steps of its own."""
    return _free_balls(
        *(*numbers_of(chunk.bearing), method_numbers(method), _drive_numbers(chunk.drive), chunk.scales),
        *(chunk.duration, len(chunk.times), chunk.times, chunk.stop, len(balls), np.array(balls, np.int64)),
        *(len(chunk.state), chunk.state, chunk.orientation, chunk.steps, chunk.carried),
        *(chunk.states, chunk.orientations, chunk.counts, chunk.failure),
    )


def _common(method: str, chunk: Chunk) -> int:
    """Moves all balls by an explicit method, or by `imex`, in common steps: given ones without an error estimate."""
    numbers, adaptive, following = np.zeros(1), False, np.empty(1)
    if method in EXPLICIT:
        numbers, adaptive = runge_kutta_numbers(method), bool(EXPLICIT[method].error.any())
    status = _common_balls(
        *(*numbers_of(chunk.bearing), numbers, _drive_numbers(chunk.drive), chunk.scales),
        *(float(chunk.steps[0]) if adaptive else chunk.step, chunk.duration, len(chunk.times), chunk.times),
        *(chunk.stop, len(chunk.state), chunk.near, chunk.state, chunk.orientation, chunk.carried),
        *(chunk.states, chunk.orientations, chunk.counts, chunk.failure, following),
    )
    if status == OK:
        chunk.steps[:] = following
    return status


def _coupled(method: str, chunk: Chunk, balls) -> int:
    """Moves the numbered `balls`, neighbours one after the other, with ring, cage and shaft."""
    bodies = chunk.bodies
    return _coupled_balls(
        *(*numbers_of(chunk.bearing), method_numbers(method), numbers_of_bodies(chunk.bearing, bodies)),
        *(bodies.load, bodies.load_rate, np.array(chunk.drive, float), chunk.scales, chunk.duration),
        *(len(chunk.times), chunk.times, chunk.stop, len(balls), np.array(balls, np.int64), chunk.near.view(np.uint8)),
        *(len(chunk.state), chunk.state, chunk.orientation, chunk.steps, chunk.carried, chunk.body_state),
        *(chunk.states, chunk.orientations, chunk.body_states, chunk.counts, chunk.failure),
    )


def rates(bearing, ring_speed: float, near: np.ndarray, state: np.ndarray, ring_angle: float = 0.0) -> np.ndarray:
    """Rates (N, COLUMNS) of all balls in a state (N, COLUMNS); near[k] says whether ball k may touch the next ahead.

    Losses take in what contacts of balls store.
    """
    found = np.empty_like(state)
    _all_rates(*numbers_of(bearing), float(ring_speed), float(ring_angle), len(state), near, state, found)
    return found


def integrated(stepper: str, chunk: Chunk) -> int:
    """Integrates a chunk; returns its status."""
    if stepper == "imex":  # its losses are of first order, those of damping, which are less than the work of loads
        return _common(stepper, chunk)
    _stored(1.0, chunk, chunk.state)
    status = _with_losses(stepper, chunk)
    _stored(-1.0, chunk, chunk.state)
    _stored(-1.0, chunk, chunk.states)
    return status


def _stored(share: float, chunk: Chunk, states: np.ndarray) -> None:
    """Adds a share of what contacts of neighbours store [J] to losses in states (..., N, COLUMNS), in place."""
    if np.count_nonzero(chunk.near):  # in a fifth of the time of `any`
        count = states.size // chunk.state.size
        _add_stored(*numbers_of(chunk.bearing), len(chunk.near), chunk.near, share, count, states)


def _with_losses(stepper: str, chunk: Chunk) -> int:
    """`integrated` where the integral of losses takes in what contacts of balls store."""
    if stepper in EXPLICIT:
        return _common(stepper, chunk)
    if stepper in SCIPY:
        return _by_scipy(SCIPY[stepper], chunk)
    # Where the rings' motion is prescribed and there is no cage, a ball acts on another only where they touch.
    every = range(len(chunk.near))
    if chunk.bodies.active:
        return _coupled(stepper, chunk, every)
    if not np.count_nonzero(chunk.near):
        return _free(stepper, chunk, every)
    groups = groups_of(chunk.near)
    alone = [group[0] for group in groups if len(group) == 1]
    status = _free(stepper, chunk, alone) if alone else OK
    for group in groups:
        if status == OK and len(group) > 1:
            status = _coupled(stepper, chunk, group)
    return status


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


def check(status: int, elapsed: float, failure: np.ndarray) -> None:
    """Raises Stopped or IntegrationError for a status that is not OK of what began at `elapsed` [s]."""
    if status == STOPPED:
        raise Stopped(f"the computation was stopped at {elapsed:.9g} s")
    if status != OK:
        seconds, body = elapsed + failure[0], f"ball {int(failure[1])}"
        raise IntegrationError(f"at {seconds:.9g} s {body} {FAILURES[status]}", WORDS[status], seconds, body)


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


def time_apart(ball_radius: float, state: np.ndarray) -> float:
    """Seconds for which no two balls come nearer than NEAR, by their present speeds."""
    return _time_apart(ball_radius, state, len(state), NEAR * ball_radius)


def mark_near(ball_radius: float, state: np.ndarray, ahead: float, near: np.ndarray, reach: float = 0.0) -> None:
    """Sets `near` (N,) where two may come closer than `reach` [m], else NEAR, within `ahead` [s]."""
    _mark_near(ball_radius, state, len(state), reach or NEAR * ball_radius, ahead, near)


def mark_met(ball_radius: float, state: np.ndarray, states: np.ndarray, near: np.ndarray) -> bool:
    """Sets `near` (N,) for those who have met, now or in `states` (instants, N, ...); whether any was not set."""
    return bool(_mark_met(ball_radius, state, len(state), states, len(states), MET * ball_radius, near))


def instants_in(times: np.ndarray, begin: float, end: float) -> np.ndarray:
    """Those `times` [s] of a chunk, within rounding of its part from `begin` to `end`, as counted from its begin."""
    return np.minimum(times - begin, end - begin)


def integrate_in_common(
    integrate: Callable, radius: float, moving, times: np.ndarray, duration: float, filled, apart: bool, even: bool
) -> None:
    """Integrates a part of balls that share steps with a ring or a cage, or that are kept `apart`.

    Where two met that were not near, which no `even` cage lets them, once more with all near. See `integrate_alone`.
    """
    before, near = [one.copy() for one in moving], np.zeros(len(moving[0]), np.bool_)
    if not apart:
        mark_near(radius, moving[0], duration, near)
    integrate(near, 0.0, times, duration, filled)
    if even or not mark_met(radius, moving[0], filled[0], near):
        return
    _put_back(moving, before)
    mark_near(radius, moving[0], 0.0, near, EVERYWHERE)
    integrate(near, 0.0, times, duration, filled)


def _put_back(moving, before) -> None:
    for one, kept in zip(moving, before, strict=True):
        one[:] = kept


def integrate_alone(integrate: Callable, radius: float, moving, times: np.ndarray, duration: float, filled) -> None:
    """Integrates a part of balls that act on each other only where they touch.

    `integrate(near, begin, times, duration, filled)` moves the arrays `moving`, the state (N, ...) first, on over
    `duration` [s] from `begin` [s] of the part and fills the arrays of `filled` at `times` [s] from there. A stretch in
    which two met that were not near is done again, shorter or with them near. Raises what `integrate` raises.
    """
    first, begin, ahead = 0, 0.0, duration
    met = np.zeros(len(moving[0]), np.bool_)
    while begin < duration:
        left, near = duration - begin, met.copy()
        mark_near(radius, moving[0], min(SOON, left), near)
        near |= met
        length = min(SOON if near.any() else ahead, left)
        ends = length >= left - NOTHING * duration
        long, length = length > SOON, left if ends else length  # the last one may be longer than SOON by rounding
        last = len(times) if ends else int(np.searchsorted(times, begin + length, side="right"))
        before, into = [one.copy() for one in moving], tuple(one[first:last] for one in filled)
        integrate(near, begin, instants_in(times[first:last], begin, begin + length), length, into)
        found = near.copy()
        if mark_met(radius, moving[0], into[0], found):
            _put_back(moving, before)
            # Found late in a long stretch: up to there they are alone.
            met, ahead = (met, max(SHORTER * length, SOON)) if long else (found, ahead)
            continue
        met, ahead = np.zeros_like(met), max(LONGER * length, SOON)
        first, begin = last, duration if ends else begin + length


def _by_scipy(name: str, chunk: Chunk) -> int:
    """Integrates a chunk of all balls together, by a SciPy solver's class; raises Stopped where it is to stop."""
    from scipy import integrate  # late: these methods are for charts and tests

    drive, times, shape = chunk.drive, chunk.times, chunk.state.shape
    scales = REFERENCE_SHARE * chunk.scales[:MOTION]

    def right_hand_side(time, flat):
        if chunk.stop[0] != 0:
            raise Stopped("the computation was stopped within a chunk")
        now, state = drive.later(time), np.ascontiguousarray(flat.reshape(shape))
        return rates(chunk.bearing, now.speed, chunk.near, state, now.angle).ravel()

    method = getattr(integrate, name)(
        right_hand_side,
        0.0,
        chunk.state.ravel().copy(),
        chunk.duration,
        rtol=2.3e-14,
        atol=np.tile(np.concatenate([scales, [1e-12] * (COLUMNS - MOTION)]), len(chunk.state)),
        first_step=min(1e-7, chunk.duration),
    )
    cursor = 0
    while method.status == "running":
        # SciPy probes the integrals, on which nothing depends, with ever greater increments.
        with np.errstate(over="ignore"):
            method.step()
        finite = np.isfinite(method.y.reshape(shape)).all(axis=1)
        if method.status == "failed" or not finite.all():
            fastest = np.abs(right_hand_side(method.t, method.y).reshape(shape)[:, :MOTION] / scales).max(axis=1)
            chunk.failure[:] = method.t, fastest.argmax() if finite.all() else finite.argmin()
            return NOT_FINITE if not finite.all() else STALLED
        dense = method.dense_output()
        start = dense(method.t_old).reshape(shape)
        while cursor < len(times) and times[cursor] <= method.t:
            _turn_all(dense, method.t_old, times[cursor], start, chunk.orientation, chunk.orientations[cursor])
            chunk.states[cursor] = dense(times[cursor]).reshape(shape)
            cursor += 1
        _turn_all(dense, method.t_old, method.t, start, chunk.orientation, chunk.orientation)
    chunk.state[:] = method.y.reshape(shape)
    for number, cost in ((STEPS, method.nfev // 12), (EVALUATIONS, method.nfev), (JACOBIANS, method.njev)):
        chunk.counts[number] += cost * len(chunk.state)
    return OK


def _turn_all(dense, begin, end, start, orientation, out):
    middle, last = (dense(t).reshape(start.shape) for t in (0.5 * (begin + end), end))
    out[:] = turned(orientation, *map(_spin_in_frame, (start, middle, last)), end - begin)


def _spin_in_frame(state):
    """Angular velocities (N, 3) [rad/s] of balls (N, COLUMNS) against the frame that turns with each about the axis."""
    axial = state[:, AXIAL_SPIN] - state[:, TANGENTIAL_VELOCITY] / state[:, AXIS_DISTANCE]
    return np.stack([state[:, RADIAL_SPIN], state[:, TANGENTIAL_SPIN], axial], axis=1)
