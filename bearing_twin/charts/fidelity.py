"""What the chooser takes for bearings against all that could be taken: error kept or not, and cost over the least.

Scenes as they ship and variants of them to which nothing was fitted, by what is wanted and how exactly. Truth is
`rodas4` ten times tighter than the tightest setting. All steppers are tried at all settings; the cheapest that
keeps the tolerance is what a perfect chooser would take. Costs are CPU seconds, medians of several timings. `reason` is
the choice's, `setting` the tolerance that was chosen.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.charts.bearing_cells import errors
from bearing_twin.charts.bearing_variants import VARIANTS
from bearing_twin.charts.chart import Chart
from bearing_twin.charts.contest import limited
from bearing_twin.charts.contest_picture import ring
from bearing_twin.charts.scene_rows import command_of
from bearing_twin.charts.table import DONE, FAILED, Row
from bearing_twin.charts.timing import timed
from bearing_twin.errors import IntegrationError
from bearing_twin.kinds.bearing.motion import BearingMotion, bearing_motion
from bearing_twin.kinds.bearing.parameters import LOADS
from bearing_twin.kinds.bearing.rings import QUASI_STATIC
from bearing_twin.numerics.steppers import ROSENBROCK
from bearing_twin.pictures.style import STYLE, ball_line, frame, heading, key_above, save, stamp
from bearing_twin.report import Choice
from bearing_twin.run.fidelity import choose
from bearing_twin.run.scene import load_scene
from bearing_twin.units import two_digits

SPAN, OUTPUTS = 0.02, 40  # s and outputs of a run
SETTINGS = (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7)
FINEST = 3e-8
WANTED = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
OUTPUTS_WANTED = ("history", LOADS)
ENOUGH = 0.04  # CPU seconds of a timing
LEAST, MOST = 1e-9, 1e2  # of the error axis
SHIPPED = {
    name: (f"bearing_{name}", ())
    for name in ("6203", "6203_fast", "6203_loose", "6203_start", "6203_sudden", "6203_sticking", "6205")
}
CASES = SHIPPED | VARIANTS


@dataclass(frozen=True)
class FidelityRow(Row):
    """One choice: which outputs were wanted how exactly, and what error was predicted (NaN = none).

    `best`, `best_setting`, `best_seconds`: the cheapest that keeps the tolerance, by trying all; empty where none.
    """

    outputs: str = ""
    wanted: float = math.nan
    predicted: float = math.nan
    best: str = ""
    best_setting: float = math.nan
    best_seconds: float = math.nan

    @property
    def kept(self) -> bool:
        """Whether the error is within what was wanted."""
        return self.error <= self.wanted


class StepperTrial(NamedTuple):
    """Errors of load and friction of a stepper at a setting, CPU seconds and their spread; infinite where it broke."""

    load_error: float
    friction_error: float
    seconds: float
    spread: float = math.nan

    def error(self, outputs: str) -> float:
        """What counts for the outputs that are wanted."""
        return self.load_error if outputs == LOADS else max(self.load_error, self.friction_error)


def _timed_run(motion):
    """The outputs of a motion over SPAN, and the timing of it."""
    times = SPAN / OUTPUTS * np.arange(1, OUTPUTS + 1)

    def work():
        motion.reset()
        return motion.advance(times, SPAN)

    return timed(work, ENOUGH)


class _Trials:
    """All that can be tried on one scene, each once."""

    def __init__(self, scene: str, overrides):
        self._scene, self._overrides, self._found = scene, overrides, {}
        self.exact = self._run("rodas4", FINEST)[1]

    def keys(self, wanted: float, outputs: str = "history") -> tuple[str, ...]:
        """What differs from the scene, with what is wanted of it."""
        words = f"wanted.tolerance={wanted}", f"wanted.outputs={outputs}"
        rate = f"run.output_rate={OUTPUTS / SPAN}", "run.publish_rate=100", f"run.duration={SPAN}"
        return *self._overrides, *words, *rate

    def scene(self, wanted: float, outputs: str = "history"):
        """The scene with that."""
        return load_scene(self._scene, self.keys(wanted, outputs))

    def _run(self, stepper, setting):
        motion = BearingMotion(self.scene(setting).parameters, Choice("hertz", stepper, 0.0, "", ()))
        return motion, *_timed_run(motion)

    def trial(self, stepper: str, setting: float) -> StepperTrial:
        """How a stepper does at a setting."""
        if (stepper, setting) not in self._found:
            try:
                motion, out, cost = self._run(stepper, setting)
                self._found[stepper, setting] = StepperTrial(*errors(motion, out, self.exact), *cost)
            except (IntegrationError, ArithmeticError):
                self._found[stepper, setting] = StepperTrial(math.inf, math.inf, math.inf)
        return self._found[stepper, setting]

    def at_rest(self, choice: Choice, wanted: float) -> StepperTrial:
        """How equilibria do."""
        out, cost = _timed_run(bearing_motion(self.scene(wanted, LOADS).parameters, choice))
        loads = np.abs(out.normal_load - self.exact.normal_load).max() / self.exact.normal_load.max()
        return StepperTrial(float(loads), math.nan, *cost)


def judge(name: str, _: str, __: float, limit: float) -> list[FidelityRow]:
    """All choices for one scene; the limit is that of one of OUTPUTS_WANTED and WANTED, all that is tried included."""
    scene, overrides = CASES[name]
    rows = []
    with limited(limit * len(WANTED) * len(OUTPUTS_WANTED)):
        trials = _Trials(scene, overrides)
        for outputs in OUTPUTS_WANTED:
            for wanted in WANTED:
                command = command_of(scene, trials.keys(wanted, outputs))
                rows.append(_row(name, trials, outputs, wanted).but(command=command))
    return rows


def _row(name: str, trials: _Trials, outputs: str, wanted: float) -> FidelityRow:
    """What is chosen for a scene where this is wanted, and what would have been best."""
    choice = choose(trials.scene(wanted, outputs))
    still = choice.stepper == QUASI_STATIC
    setting = math.nan if still else choice.setting
    found = trials.at_rest(choice, wanted) if still else trials.trial(choice.stepper, setting)
    enough = [
        (one.seconds, stepper, at)
        for stepper in ROSENBROCK
        for at in SETTINGS
        if (one := trials.trial(stepper, at)).error(outputs) <= wanted
    ]
    seconds, best, at = min(enough, default=(math.nan, "", math.nan))
    told = choice.predicted or {}
    friction = 0.0 if outputs == LOADS else told.get("friction_error", math.nan)
    return FidelityRow(
        name,
        choice.stepper,
        setting,
        load_error=float(found.load_error),
        friction_error=math.nan if outputs == LOADS else float(found.friction_error),
        seconds=found.seconds,
        spread=found.spread,
        status=DONE if math.isfinite(found.error(outputs)) else FAILED,
        reason=choice.reason,
        outputs=outputs,
        wanted=wanted,
        predicted=max(told.get("load_error", math.nan), friction),
        best=best,
        best_setting=at,
        best_seconds=seconds,
    )


def reading(points: list[FidelityRow]) -> list[str]:
    """What the chart says."""
    sentences = []
    for shipped, who in ((True, "scenes as they ship"), (False, "variants that nothing was fitted to")):
        mine = [p for p in points if (p.problem in SHIPPED) == shipped and p.outputs]
        if not mine:
            continue
        worst = max(mine, key=lambda p: p.error / p.wanted)
        ratios = [p.seconds / p.best_seconds for p in mine if p.kept and p.best]
        sentences.append(
            f"{who}: {sum(p.kept for p in mine)} of {len(mine)} choices kept what was wanted; the worst, "
            f"{worst.problem} at {worst.wanted:g} for {worst.outputs}, erred {two_digits(worst.error / worst.wanted)} "
            "times that"
        )
        sentences.append(
            f"they cost {np.median(ratios):.2f} times the cheapest that was good enough as a median, "
            f"{np.quantile(ratios, 0.95):.2f} times at 95 %"
        )
    told = [p for p in points if math.inf > p.error > 1e-8 and p.predicted > 0.0]
    near = sum(1.0 / 3.0 <= p.error / p.predicted <= 3.0 for p in told)
    low = sum(p.error > 10.0 * p.predicted for p in told)
    sentences.append(
        f"of {len(told)} errors predicted from the table {near} were right within a factor of three, "
        f"{low} were more than ten times too small: a prediction is no estimate of what a run did"
    )
    return sentences


def draw(points: list[FidelityRow], path: Path) -> None:
    """Left: error over what was wanted. Right: cost over the cheapest that is good enough."""
    figure = Figure(figsize=(13.0, 6.5), dpi=100, facecolor="white")
    grid = figure.add_gridspec(1, 2, left=0.07, right=0.98, top=0.83, bottom=0.13, wspace=0.2)
    error, cost = figure.add_subplot(grid[0]), figure.add_subplot(grid[1])
    for number, (shipped, label) in enumerate(((True, "scenes as they ship"), (False, "variants"))):
        mine = [p for p in points if (p.problem in SHIPPED) == shipped and p.outputs]
        look = {**ball_line(number), "linestyle": "", "marker": "os"[number], "markersize": 5 + 2 * (not number)}
        aside = (0.88, 1.12)[number]
        error.plot(
            [aside * p.wanted for p in mine], [min(max(p.error, LEAST), MOST) for p in mine], label=label, **look
        )
        good = [p for p in mine if p.best and p.kept]
        cost.plot([aside * p.wanted for p in good], [p.seconds / p.best_seconds for p in good], label=label, **look)
        ring(cost, good, lambda p, aside=aside: (aside * p.wanted, p.seconds / p.best_seconds), look["color"])
    error.plot([WANTED[-1], WANTED[0]], [WANTED[-1], WANTED[0]], color=STYLE["ink"], linewidth=1.2)
    error.annotate("as wanted", (4e-3, 5e-3), color=STYLE["ink"], ha="left", va="bottom", fontsize=11)
    error.set(xscale="log", yscale="log", xlabel="tolerance that was wanted", ylabel="error of the run")
    cost.set(xscale="log", xlabel="tolerance that was wanted", ylabel="CPU time over that of the cheapest good enough")
    cost.axhline(1.0, color=STYLE["ink"], linewidth=1.2)
    for axis, title in ((error, "What was wanted is kept below the line"), (cost, "What the choice costs too much")):
        frame(axis)
        axis.invert_xaxis()
        heading(axis, title)
        key_above(axis)
    title = f"The chooser against all that could be chosen, {len(CASES)} bearings over {1e3 * SPAN:g} ms"
    figure.text(0.07, 0.945, title, fontsize=17, weight="bold", color=STYLE["ink"], va="center")
    stamp(figure)
    save(figure, path)


CONTESTS = {
    "fidelity": Chart(
        judge=judge,
        problems={name: name for name in CASES},
        entries=lambda name: (("as chosen", math.nan),),
        kind=FidelityRow,
        drawn=draw,
        told=reading,
    )
}
