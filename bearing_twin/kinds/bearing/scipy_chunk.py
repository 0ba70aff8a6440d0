"""One chunk of a bearing by a method of SciPy: the same equations, for reference."""

import numpy as np

from bearing_twin.base.errors import Stopped
from bearing_twin.kinds.bearing import compiled_balls
from bearing_twin.kinds.bearing.system import (
    AXIAL_SPIN,
    AXIS_DISTANCE,
    COLUMNS,
    MOTION,
    RADIAL_SPIN,
    TANGENTIAL_SPIN,
    TANGENTIAL_VELOCITY,
)
from bearing_twin.numerics.rotation import turned
from bearing_twin.numerics.statuses import EVALUATIONS, JACOBIANS, NOT_FINITE, OK, STALLED, STEPS


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
        return compiled_balls.rates(bearing, speed, near, np.ascontiguousarray(flat.reshape(shape)), angle).ravel()

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
