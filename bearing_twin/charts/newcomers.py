"""First attempts against the product: SciPy with its defaults, a fixed step of 0.1 ms, explicit Euler.

The equations are the product's, their right-hand side is compiled: what differs is the method and its setting. `rodas4`
and `rk4` are runs of the product, which refuses steps that are too long.
"""

import dataclasses
import itertools
import math

import numpy as np
from scipy.integrate import solve_ivp

from bearing_twin.base.errors import IntegrationError
from bearing_twin.base.report import Choice
from bearing_twin.charts.bearings import MOVING
from bearing_twin.charts.contest import Contest, best_of, timed
from bearing_twin.charts.rows import DONE
from bearing_twin.charts.scenes import Found, Scenes, load_and_friction, run, steps, tolerances
from bearing_twin.kinds.bearing import BearingMotion, rates

COARSE, SCIPYS = 1e-4, 1e-3  # s, the step that is often tried first; SciPy's default tolerance
CHANNELS = ("normal_load", "friction_force")


TABLE = {
    name: dataclasses.replace(
        MOVING[name],
        methods={
            "rodas4": tolerances(1e-3, 1e-1, 1e-2, 1e-4, 1e-5, 1e-6, keys=("solver.stepper=rodas4",)),
            "rk4": steps(COARSE, 1e-6, 1e-5, 3e-7, keys=("solver.stepper=rk4",)),
        },
    )
    for name in ("settled", "sliding", "lift-off")
}
PRODUCT = Scenes(table=TABLE)
NAIVE = {
    "explicit Euler": (COARSE, 1e-6, 1e-5, 1e-7),
    "solve_ivp RK45": (SCIPYS, 1e-6, 1e-9),
    "solve_ivp LSODA": (SCIPYS, 1e-6, 1e-9),
}


def _naive(motion: BearingMotion, times: np.ndarray, method: str, setting: float) -> tuple[list[np.ndarray], int]:
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
    if method == "explicit Euler":
        states = [state]
        for begin, end in itertools.pairwise(times):
            for time in np.linspace(begin, end, max(1, round((end - begin) / setting)), endpoint=False):
                state = state + min(setting, end - begin) * right_hand_side(time, state)
                if not np.isfinite(state).all():
                    raise IntegrationError("not finite", "not finite", float(time), "")
            states.append(state)
    else:
        by = method.partition(" ")[2]
        found = solve_ivp(right_hand_side, (0.0, times[-1]), state, by, times, rtol=setting, atol=1e-3 * setting)
        if not found.success:
            raise IntegrationError(found.message, "failed", float(found.t[-1]), "")
        states = found.y.T
    return states, count


def judge(*entry) -> dict:
    """One run."""
    name, method, setting, _ = entry
    if method not in NAIVE:
        return PRODUCT.judge(*entry)
    problem = TABLE[name]
    exact = run(problem.scene, (*problem.keys, *problem.reference), CHANNELS)
    motion = BearingMotion(exact.scene.parameters, Choice("hertz", "rodas4", 0.0, "", ()))
    first, rows = motion.state.copy(), []

    def work():
        motion.state[:] = first
        return _naive(motion, exact.time, method, setting)

    (states, count), cost = timed(work, exact.scene.parameters.run.duration)
    for one in states:
        motion.state[:] = one.reshape(first.shape)
        rows.append(motion.first_outputs())
    values = {channel: np.concatenate([row[channel] for row in rows]) for channel in CHANNELS}
    found = Found(exact.time, values, {}, count, exact.scene)
    return {**load_and_friction(found, exact), **cost, "evaluations": float(count)}


def entries(name: str, quick: bool):
    """The product's methods and what one tries first, each setting that is tried first at the head."""
    yield from PRODUCT.entries(name, quick)
    for method, ladder in NAIVE.items():
        yield from ((method, one, math.nan) for one in (ladder[:1] if quick else ladder))


def read(contest, rows):
    """Error of each method as it is first tried, and the cost of the requested error."""
    first = {"rodas4": 1e-3, "rk4": COARSE, **{name: ladder[0] for name, ladder in NAIVE.items()}}
    for method, setting in first.items():
        mine = [row for row in rows if (row.method, row.setting) == (method, setting)]
        words = (f"{row.problem} {f'{row.error:.1g}' if row.status == DONE else row.status}" for row in mine)
        if mine:
            yield f"{method} as first tried, at {setting:g}: error {', '.join(words)}."
    yield from best_of(contest, rows)


CHARTS = {
    "newcomers": Contest(
        title="What one tries first, against the product's rodas4",
        problems={name: problem.title for name, problem in TABLE.items()},
        entries=entries,
        judge=judge,
        command=lambda *entry: "" if entry[1] in NAIVE else PRODUCT.command(*entry),
        read=read,
        error="greatest error of load or friction",
        cost="CPU time of a simulated second",
        own=("rodas4",),
    )
}
