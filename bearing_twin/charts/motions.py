"""What steppers err and how much they evaluate in each motion of a bearing: the table that tells cost before a run.

Each stepper runs each motion at a ladder of tolerances: errors and CPU time over the first 20 ms, and how often the
rates of balls are evaluated in these and in a second after them. Evaluations are the same on every machine. Besides the
motions of the chart of steppers there are those of balls that share a step: cages, rings with mass, a shaft that a
torque turns; friction over the spots; contacts with hardly any damping. Truth is `rodas4` at 1e-8. Behind them stand a
shaft on two bearings and an ellipsoid that bounces (`body_motions`).
"""

import math
from dataclasses import dataclass

import numpy as np

from bearing_twin.charts import body_motions
from bearing_twin.charts.bearing_cells import Case, bearing_row, command_of, ready, to_start
from bearing_twin.charts.contest import tried
from bearing_twin.charts.contest_picture import Contest
from bearing_twin.charts.table import DONE, Row
from bearing_twin.charts.work_precision import CASES as MOVED
from bearing_twin.kinds.bearing.measured import steppers_of
from bearing_twin.kinds.bearing.motions import motions_of
from bearing_twin.run.scene import load_scene

PERIOD, OUTPUTS = 5e-4, 40  # s between outputs, and how many: the first 20 ms
LATER, CHUNK = 0.18, 0.02  # s of the time after them, and of a stretch of it
ENOUGH = 0.04  # CPU seconds of a timing
TOLD = 1e-3, 1e-5  # of which the sentences say evaluations
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
SHARED = {
    "even cage": ("bearing_6203_tilted", ()),
    "pockets": ("bearing_6203_rig_1000N", ("cage.kind=pockets",)),
    "free ring": ("bearing_6203_rig_400N", ()),
    "ring knocked": ("bearing_6203_rig_400N", ("rings.inner.change={time: 0.005, load: [0, -800, 0]}",)),
    "unbalance": ("bearing_6203_unbalance", ()),
    "torque": ("bearing_6203_run_up", ()),
    "drilling": ("bearing_6203", ("contact.friction=spot",)),
    "hardly damped": ("bearing_6203", ("contact.relaxation_time=1e-8",)),
}
CASES = {name: Case(one.scene, one.overrides, PERIOD, OUTPUTS) for name, one in MOVED.items()}
CASES |= {name: Case(*one, PERIOD, OUTPUTS) for name, one in SHARED.items()}


@dataclass(frozen=True)
class MotionRow(Row):
    """One stepper in one motion: `evaluations` of a ball's rates in the first 20 ms, of all balls; and a second later.

    `balls` is their number. Of other bodies all their evaluations in the time `simulated` [s], and a second later, with
    `events_a_second` in that: turns of a shaft, touches of an ellipsoid.
    """

    balls: float = math.nan
    evaluations_a_second: float = math.nan
    events_a_second: float = math.nan
    simulated: float = math.nan


def judge(name: str, stepper: str, setting: float, limit: float) -> MotionRow:
    """One stepper at one tolerance."""
    if name in body_motions.CASES:
        seconds = body_motions.CASES[name].seconds
        return body_motions.judge(MotionRow(name, stepper, setting, simulated=seconds), limit, ENOUGH)
    case = CASES[name]
    row = MotionRow(name, stepper, setting, command=command_of(case, stepper, setting), simulated=case.seconds)
    found = bearing_row(row, case, limit, enough=ENOUGH)
    return found if found.status != DONE else tried(found, lambda: _counted(case, stepper, setting), limit)


def _steppers(name: str) -> tuple[str, ...]:
    """Those that may move a bearing so."""
    return steppers_of(motions_of(load_scene(CASES[name].scene, CASES[name].overrides).parameters))


def _counted(case: Case, stepper: str, setting: float) -> dict[str, float]:
    """Evaluations a second, after the first 20 ms."""
    motion, times = ready(case, stepper, setting), np.arange(1, round(CHUNK / PERIOD) + 1) * PERIOD
    to_start(motion, setting)
    motion.advance(case.times, case.seconds)
    first = motion.costs()["ball_rates"]
    for _ in range(round(LATER / CHUNK)):
        motion.advance(times, CHUNK)
    balls = load_scene(case.scene, case.overrides).parameters.geometry.balls
    return {"balls": float(balls), "evaluations_a_second": (motion.costs()["ball_rates"] - first) / LATER}


def _entries(name: str) -> list[tuple[str, float]]:
    """Steppers and tolerances of a motion."""
    if body := body_motions.CASES.get(name):
        return [(body.method, one) for one in body.tolerances]
    return [(stepper, one) for stepper in _steppers(name) for one in TOLERANCES]


def _command(name: str, stepper: str, setting: float) -> str:
    if name in body_motions.CASES:
        return body_motions.command_for(name, setting)
    return command_of(CASES[name], stepper, setting)


def _told(rows: list[MotionRow]) -> list[str]:
    """How much is evaluated in each motion."""
    mine = [row for row in rows if row.problem in CASES and row.method == "rodas4"]
    said, told = [], [row for row in mine if row.status == DONE and row.setting in TOLD]
    for name in dict.fromkeys(row.problem for row in rows):
        mine = [row for row in told if row.problem == name]
        if mine:
            counts = "; ".join(
                f"{row.setting:g}: {row.evaluations / row.balls:.3g}, then {row.evaluations_a_second / row.balls:.3g} "
                "a second"
                for row in mine
            )
            said.append(f"{name}, evaluations of a ball in its first 20 ms by rodas4 at {counts}.")
    return said


CONTESTS = {
    "motions": Contest(
        judge=judge,
        kind=MotionRow,
        title="Motions of bearings, shafts, an ellipsoid",
        error="greatest error of load or friction",
        cost="CPU s a simulated s",
        wanted=1e-3,
        problems={name: name for name in (*CASES, *body_motions.CASES)},
        entries=_entries,
        command=_command,
        more=_told,
        own=("rodas4", "rodas4_landing"),
    )
}
