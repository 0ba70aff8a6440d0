"""Accuracy against speed of the steppers: the same problems by every method, judged by load and friction.

Each run is made twice: by the compiled motion with its outputs alone, and by the public call, `simulate(...).blocks()`,
with its companion. Error across, CPU seconds per simulated second up, both logarithmic; one line a method, a cross
along the right edge for each failure. The reference is `rodas4` a thousand times tighter than its ladder. A ladder on
which all settings miss goes on, finer and finer, until one is good or too slow; on others the loosest good setting of
an adaptive method is looked for between rungs.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.charts.bearing_cells import Case, bearing_row, command_of, errors, overrides_of, truth
from bearing_twin.charts.chart import Chart, unsure
from bearing_twin.charts.contest import judged
from bearing_twin.charts.contest_picture import RINGED, cheapest, found_again, ring
from bearing_twin.charts.table import DONE, FAILED, STOPPED, Row
from bearing_twin.charts.timing import timed
from bearing_twin.kinds.bearing.error_scales import STEP_SHARE
from bearing_twin.kinds.bearing.outputs import Rows
from bearing_twin.kinds.bearing.stepping.integrate import SCIPY
from bearing_twin.numerics.steppers import ROSENBROCK, STEPPER_FACTS
from bearing_twin.pictures.style import STYLE, ball_line, frame, heading, save_chart
from bearing_twin.run.passes import Run
from bearing_twin.run.scene import load_scene
from bearing_twin.sample import joined

DEFAULT = "rodas4"  # whose share of the tolerance for one step is judged
WANTED = 1e-3  # the error in load and in friction at which costs are compared
LEAST, EDGE = 1e-9, 10.0  # of the error axis: smaller errors are drawn at its start, failures at its end
FROM_REST = ("initial.motion=rest", "drive.offset=[0.0,-1e-6,5e-6]")
CASES = {
    "settled": Case("bearing_6203", (), 1e-3, 100),
    "sliding": Case("bearing_6203", FROM_REST, 5e-5, 20),
    "lift-off": Case("bearing_6203_loose", (), 1e-3, 20),
    "sticking": Case("bearing_6203", ("contact.friction_regularisation=1e-4",), 1e-3, 5),
    "fast": Case("bearing_6203_fast", (), 1e-3, 20),
    "sudden": Case("bearing_6203_sudden", ("drive.change.time=2e-4", "drive.acceleration=1e6"), 5e-5, 20),
}
PROBLEMS = {
    "settled": "settled, outputs every 1 ms",
    "sliding": "from rest: sliding, ringing",
    "lift-off": "clearance, lift-off",
    "sticking": "friction regularised at 0.1 mm/s",
    "fast": "20 000 rpm, outputs every 1 ms",
    "sudden": "sudden speed and load",
}
TOLERANCES, STEPS = (1e-1, 1e-3, 1e-5), (4e-6, 2e-6, 1e-6, 5e-7, 2.5e-7)
FINER = {  # ladders of methods that are worth more points
    "rodas4": (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5),
    "rodas4_landing": (1e-1, 1e-2, 1e-3, 1e-4, 3e-5, 1e-5),
    "rodas3": (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 1e-4, 1e-5),
}
LADDERS = {name: FINER.get(name, TOLERANCES if facts.adaptive else STEPS) for name, facts in STEPPER_FACTS.items()}
"""Of every stepper: tolerances of an adaptive one, steps [s] of a fixed one."""
FINER_BY, LAST = {True: 0.1, False: 0.5}, {True: 1e-12, False: 1e-9}  # adaptive or not: how a ladder goes on, to where
CLOSE = 2.0  # times another: no setting is looked for between these
SLOWEST = 1e3  # CPU seconds per simulated second beyond which a ladder ends


@dataclass(frozen=True)
class StepperRow(Row):
    """A run by its motion alone, and the same by the public call: errors, CPU seconds a simulated second, their spread.

    Those of the call are NaN where there is none: SciPy's methods are references there, asked for more. `simulated` [s]
    is how long the run is.
    """

    api_load_error: float = math.nan
    api_friction_error: float = math.nan
    api_seconds: float = math.nan
    api_spread: float = math.nan
    simulated: float = math.nan


CALLED = "api_load_error", "api_friction_error", "api_seconds", "api_spread"


def by_the_call(rows: Iterable[StepperRow]) -> list[Row]:
    """Those rows that have a run by the public call, as rows of that run."""
    found = []
    for row in rows:
        known = not math.isnan(row.api_seconds)
        if row.method in SCIPY or not (known or row.reason):
            continue
        status = row.status if known or row.status != DONE else FAILED
        measured = row.api_load_error, row.api_friction_error, row.api_seconds, math.nan
        found.append(
            Row(row.problem, row.method, row.setting, *measured, status, row.reason, row.command, row.api_spread)
        )
    return found


def judge(name: str, stepper: str, setting: float, limit: float) -> StepperRow:
    """One run by its motion and by the public call; a step that is refused is a row, too."""
    row = judge_motion(name, stepper, setting, limit)
    return row if row.status != DONE or stepper in SCIPY else _called(row, limit)


def judge_motion(name: str, stepper: str, setting: float, limit: float) -> StepperRow:
    """One run by its motion alone."""
    row = StepperRow(name, stepper, setting, command=_command(name, stepper, setting), simulated=CASES[name].seconds)
    return bearing_row(row, CASES[name], limit, refuses=True)


def _called(row: StepperRow, limit: float) -> StepperRow:
    """The row with what its run errs by and takes by the public call."""
    case = CASES[row.problem]
    overrides = *overrides_of(case, row.method, row.setting), f"run.duration={case.seconds:g}"
    run = Run(load_scene(case.scene, overrides))

    def outcome():
        blocks, cost = timed(lambda: list(run.blocks()))
        whole = joined(blocks)
        given = Rows(whole.values.layout, whole.matrix()[1:])  # the first is that at the start
        load, friction = errors(run.simulation._motion, given, truth(case))
        seconds = cost.seconds / case.seconds
        return dict(zip(CALLED, (load, friction, seconds, cost.spread), strict=True))

    found = judged(row, outcome, limit)
    return found if found.status == DONE else row.but(reason=f"by the public call: {found.reason}")


def _command(name, stepper, setting):
    return command_of(CASES[name], stepper, setting)


def further(rows: list[Row]) -> list[tuple[str, str, float]]:
    """Settings to go on with: finer ones of ladders that have none that is good and are not too slow yet.

    Of others with an adaptive method one between the loosest good one and the next, which is not, until both are CLOSE.
    """
    found = []
    for name, stepper in dict.fromkeys((row.problem, row.method) for row in rows):
        mine = [row for row in rows if (row.problem, row.method) == (name, stepper)]
        adaptive = STEPPER_FACTS[stepper].adaptive
        setting = FINER_BY[adaptive] * min(row.setting for row in mine)
        slow = any(row.seconds > SLOWEST or row.status == STOPPED for row in mine)
        loosest = max((row.setting for row in mine if row.error <= WANTED), default=math.inf)
        looser = min((row.setting for row in mine if row.setting > loosest), default=0.0)
        if not slow and setting > LAST[adaptive] and loosest == math.inf:
            found.append((name, stepper, setting))
        elif adaptive and looser > CLOSE * loosest:
            found.append((name, stepper, float(f"{math.sqrt(loosest * looser):.2g}")))
    return found


def _panel(axis, rows: list[Row], error_of: Callable[[Row], float], says: bool) -> None:
    """One panel; only one of a line says what the crosses are."""
    for number, stepper in enumerate(LADDERS):
        look = ball_line(number)
        colour = look["color"]
        mine = sorted((row for row in rows if row.method == stepper), key=lambda row: -row.setting)

        def place_of(row):
            return max(error_of(row), LEAST), row.seconds

        good = [place_of(row) for row in mine if row.status == DONE]
        failed = sum(row.status != DONE for row in mine)
        axis.plot(*np.transpose(good or [(np.nan, np.nan)]), "o", **look, label=stepper, markersize=5)
        ring(axis, mine, place_of, colour)
        if failed:
            # Failures stand on the right edge, where errors of load are rare, whatever the scale of the panel.
            place = axis.get_xaxis_transform()
            height = 0.3 + 0.08 * number
            axis.plot([EDGE] * failed, [height] * failed, "x", color=colour, markeredgewidth=2, transform=place)
            text = f"{stepper}: {failed} without a result  " if says else ""
            axis.text(EDGE, height, text, ha="right", va="center", fontsize=9, color=colour, transform=place)
    axis.axhline(1.0, color=STYLE["soft"], linewidth=1, linestyle=":")
    axis.axvline(WANTED, color=STYLE["soft"], linewidth=1, linestyle=":")
    axis.set(xscale="log", yscale="log", xlim=(0.5 * LEAST, 2.0 * EDGE))


def draw(rows: list[Row], path: Path) -> None:
    """The chart: a line a problem; error in load, in friction, and the greater of both by the public call."""
    names = list(dict.fromkeys(row.problem for row in rows))
    figure = Figure(figsize=(18, 3.6 * len(names) + 1.4), layout="constrained")
    axes = figure.subplots(len(names), 3, sharex=True, sharey="row", squeeze=False)
    for line, name in zip(axes, names, strict=True):
        mine = [row for row in rows if row.problem == name]
        _panel(line[0], mine, lambda row: row.load_error, True)
        _panel(line[1], mine, lambda row: row.friction_error, False)
        _panel(line[2], by_the_call(mine), lambda row: row.error, False)
        heading(line[0], f"{PROBLEMS[name]}: the motion alone")
        heading(line[2], "by the public call")
        line[0].set_ylabel("CPU s per simulated s")
        for axis in line:
            frame(axis)
    axes[0][0].legend(loc="center", ncols=2, fontsize=11, frameon=False, bbox_to_anchor=(0.36, 0.36))
    axes[-1][0].set_xlabel("greatest error of a normal load, over the greatest load")
    axes[-1][1].set_xlabel("greatest error of friction, over mu N of its contact or ball")
    axes[-1][2].set_xlabel("the greater of both errors, by the public call")
    save_chart(figure, f"Steppers: accuracy against cost, one core (dotted: real time, {WANTED:g}; {RINGED})", path)


def shares_of_steps(rows: list[Row], stepper: str) -> dict[str, tuple[float, float]]:
    """By problem: the greatest error over its setting, and the share of it a step may err by if that is to be 1.

    A step may err by STEP_SHARE of the tolerance, so that a ladder of tolerances is a ladder of shares as well.
    """
    found = {}
    for name in dict.fromkeys(row.problem for row in rows):
        mine = [row for row in rows if (row.problem, row.method, row.status) == (name, stepper, DONE)]
        worst = max((row.error / row.setting for row in mine), default=0.0)
        if worst > 0.0:
            found[name] = worst, STEP_SHARE / worst
    return found


def confirmed(rows: list[Row]) -> list[str]:
    """How near methods that are no Rosenbrock methods come to the reference, which is by one."""
    return found_again(rows, ROSENBROCK)


def _speeds(rows: list[Row], name: str) -> Iterator[str]:
    for stepper in dict.fromkeys(row.method for row in rows if row.problem == name):
        best = cheapest(rows, name, stepper, WANTED)
        yield f"{stepper} {1.0 / best.seconds:.3g}" if best else f"{stepper} at no setting"


def reading(rows: list[Row]) -> list[str]:
    """What the chart says, a sentence a problem, and one on the share of the tolerance that a step may err by."""
    sentences = []
    called = by_the_call(rows)
    for name in dict.fromkeys(row.problem for row in rows):
        motion, call = (", ".join(_speeds(which, name)) for which in (rows, called))
        sentence = f"{PROBLEMS[name]}: load and friction within {WANTED:g} at so many times real time: {motion}"
        sentences.append(f"{sentence}; by the public call: {call}." if call else f"{sentence}.")
    sentences += confirmed(rows)
    shares = shares_of_steps(rows, DEFAULT)
    if shares:
        told = ", ".join(f"{PROBLEMS[name]} {share:.2g}" for name, (_, share) in shares.items())
        sentences.append(f"A step of {DEFAULT} may err by {STEP_SHARE:g} of the tolerance; what just keeps it: {told}.")
    return [*sentences, *(f"By the public call: {one[0].lower()}{one[1:]}" for one in unsure(called))]


CONTESTS = {
    "steppers": Chart(
        judge=judge,
        problems=PROBLEMS,
        entries=lambda name: ((stepper, setting) for stepper, ladder in LADDERS.items() for setting in ladder),
        kind=StepperRow,
        command=_command,
        further=further,
        drawn=draw,
        told=reading,
    )
}
