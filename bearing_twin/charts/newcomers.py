"""First attempts against the product: SciPy with its defaults, a fixed step of 0.1 ms, explicit Euler.

The equations are the product's, their right-hand side is compiled: what differs is the method and its setting. `rodas4`
and `rk4` are runs of the product, which refuses steps that are too long.
"""

import dataclasses
import functools
import itertools
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from bearing_twin.base.errors import IntegrationError
from bearing_twin.base.report import Choice
from bearing_twin.charts.bearings import MOVING
from bearing_twin.charts.contest import best_of
from bearing_twin.charts.rows import DONE
from bearing_twin.charts.scenes import Found, Method, Scenes, steps, tolerances
from bearing_twin.kinds.bearing import BearingMotion, rates

COARSE, SCIPYS = 1e-4, 1e-3  # s, the step that is often tried first; SciPy's default tolerance
CHANNELS = ("normal_load", "friction_force")


def naive(motion: BearingMotion, times: np.ndarray, method: str, setting: float) -> tuple[np.ndarray, int]:
    """A run as a user writes it: a right-hand side of time and a flat state; Euler's steps or `solve_ivp`.

    States at `times` [s], and evaluations of a ball.
    """
    shape, near = motion.state.shape, np.zeros(motion.bearing.balls, np.bool_)
    count = 0

    def right_hand_side(time, flat):
        nonlocal count
        count += motion.bearing.balls
        speed = motion.drive.speed + motion.drive.acceleration * time
        return rates(motion.bearing, speed, near, flat.reshape(shape)).ravel()

    state = motion.state.ravel().copy()
    if method == "Euler":
        states = [state]
        for begin, end in itertools.pairwise(times):
            for time in np.linspace(begin, end, max(1, round((end - begin) / setting)), endpoint=False):
                state = state + min(setting, end - begin) * right_hand_side(time, state)
                if not np.isfinite(state).all():
                    raise IntegrationError("not finite", "not finite", float(time), "")
            states.append(state)
        return np.array(states), count
    found = solve_ivp(right_hand_side, (0.0, times[-1]), state, method, times, rtol=setting, atol=1e-3 * setting)
    if not found.success:
        raise IntegrationError(found.message, "failed", float(found.t[-1]), "")
    return found.y.T, count


def solved(method: str, exact: Found, setting: float) -> tuple[Callable, Callable]:
    """A run by `naive` as work, and what turns its states into outputs."""
    motion = BearingMotion(exact.scene.parameters, Choice("hertz", "rodas4", 0.0, "", ()))
    first = motion.state.copy()

    def work():
        motion.state[:] = first
        return naive(motion, exact.time, method, setting)

    def found_of(ended) -> Found:
        rows = []
        for state in ended[0]:
            motion.state[:] = state.reshape(first.shape)
            rows.append(motion.first_outputs())
        values = {channel: np.concatenate([row[channel] for row in rows]) for channel in CHANNELS}
        return Found(exact.time, values, {}, float(ended[1]), exact.scene)

    return work, found_of


METHODS = {
    "rodas4": tolerances(SCIPYS, 1e-1, 1e-2, 1e-4, 1e-5, 1e-6, keys=("solver.stepper=rodas4",)),
    "rk4": steps(COARSE, 1e-6, 1e-5, 3e-7, keys=("solver.stepper=rk4",)),
    "explicit Euler": Method(ladder=(COARSE, 1e-6, 1e-5, 1e-7), solved=functools.partial(solved, "Euler")),
    "solve_ivp RK45": Method(ladder=(SCIPYS, 1e-6, 1e-9), solved=functools.partial(solved, "RK45")),
    "solve_ivp LSODA": Method(ladder=(SCIPYS, 1e-6, 1e-9), solved=functools.partial(solved, "LSODA")),
}  # each setting that is tried first at the head
TABLE = {name: dataclasses.replace(MOVING[name], methods=METHODS) for name in ("settled", "sliding", "lift-off")}


def read(contest, rows):
    """Error of each method as it is first tried, and the cost of the requested error."""
    first = {name: method.ladder[0] for name, method in METHODS.items()}
    for method, setting in first.items():
        mine = [row for row in rows if (row.method, row.setting) == (method, setting)]
        words = (f"{row.problem} {f'{row.error:.1g}' if row.status == DONE else row.status}" for row in mine)
        if mine:
            yield f"{method} as first tried, at {setting:g}: error {', '.join(words)}."
    yield from best_of(contest, rows)


CHARTS = {
    "newcomers": Scenes(table=TABLE).contest(
        title="What one tries first, against the product's rodas4",
        read=read,
        error="greatest error of load or friction",
        cost="CPU time of a simulated second",
        own=("rodas4",),
    )
}
