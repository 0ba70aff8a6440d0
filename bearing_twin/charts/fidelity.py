"""What the chooser takes for bearings against all that could be taken: error kept or not, and cost over the least.

Scenes as they ship, some with a free ring or a cage, and variants to which nothing was fitted, by what is wanted and
how exactly. All laws, dimensions, cages, steppers and settings are tried (`fidelity_trials`); the cheapest combination
that keeps the tolerance is what a perfect chooser would take. Costs are CPU seconds, medians of several timings, of the
motion alone and with the companion of a user's run. `reason` is the choice's, `setting` the tolerance that was chosen.
"""

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.charts.bearing_variants import VARIANTS
from bearing_twin.charts.chart import Chart
from bearing_twin.charts.contest import limited
from bearing_twin.charts.contest_picture import ring
from bearing_twin.charts.fidelity_trials import LOST, SPAN, Combination, Trials, of_wanted
from bearing_twin.charts.scene_rows import command_of
from bearing_twin.charts.table import DONE, FAILED, Row
from bearing_twin.kinds.bearing.measured import method_of
from bearing_twin.kinds.bearing.parameters import LOADS
from bearing_twin.kinds.bearing.rings import EVEN, FREE_RING, QUASI_STATIC, dimension_of
from bearing_twin.pictures.style import STYLE, ball_line, frame, heading, key_above, save, stamp
from bearing_twin.report import Choice
from bearing_twin.run.fidelity import choose
from bearing_twin.units import two_digits

WANTED = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
OUTPUTS_WANTED = ("history", LOADS)
LEAST, MOST = 1e-9, 1e2  # of the error axis
SOON = {"sudden": ("drive.change.time=5e-3",), "step_load": ("rings.inner.change.time=5e-3",)}  # within SPAN
SHIPPED = {
    name: (f"bearing_{'6203_' * (name != '6203' and name != '6205')}{name}", SOON.get(name, ()))
    for name in ("6203", "fast", "loose", "start", "sudden", "sticking", "6205")
}
RINGS = {
    name: (f"bearing_6203_{name}", SOON.get(name, ()))
    for name in ("tilted", "rig_1000N", "rig_400N", "step_load", "unbalance", "run_up")
}
CASES = SHIPPED | RINGS | VARIANTS
HOPS = ("loose from rest",)  # where balls hop: compared up to the earliest horizon that its runs name
GROUPS = {
    "scenes as they ship, without a cage": SHIPPED,
    "scenes as they ship, with a cage, most with a free ring": RINGS,
    "variants that nothing was fitted to": VARIANTS,
}
LABELS = "shipped", "with a cage", "variants"


@dataclass(frozen=True)
class FidelityRow(Row):
    """One choice: which outputs were wanted how exactly, and what error was predicted (NaN = none).

    `best*`: the cheapest combination that keeps the tolerance, by trying all; empty where none. `watched_*`: with the
    companion, as a user has the run, and `told` the first word of its status; `best_watched_seconds`: the least of that
    among what is good enough.
    """

    outputs: str = ""
    wanted: float = math.nan
    predicted: float = math.nan
    law: str = ""
    dimension: str = ""
    watched_seconds: float = math.nan
    watched_load_error: float = math.nan
    watched_friction_error: float = math.nan
    told: str = ""
    best: str = ""
    best_setting: float = math.nan
    best_law: str = ""
    best_dimension: str = ""
    best_seconds: float = math.nan
    best_watched_seconds: float = math.nan

    @property
    def kept(self) -> bool:
        """Whether the error is within what was wanted."""
        return self.error <= self.wanted

    @property
    def off(self) -> float:
        """The error of the run as a user has it, over what was wanted."""
        return of_wanted(self.outputs, self.watched_load_error, self.watched_friction_error) / self.wanted


def judge(name: str, _: str, __: float, limit: float) -> list[FidelityRow]:
    """All choices for one scene; the limit is that of one of OUTPUTS_WANTED and WANTED, all that is tried included."""
    scene, overrides = CASES[name]
    with limited(limit * len(WANTED) * len(OUTPUTS_WANTED)):
        cells = [(outputs, wanted) for outputs in OUTPUTS_WANTED for wanted in WANTED]
        trials = Trials(scene, overrides, tuple(cells) if name in HOPS else ())
        return [
            _row(name, trials, outputs, wanted).but(command=command_of(scene, trials.keys(wanted, outputs)))
            for outputs, wanted in cells
        ]


def _left(trials: Trials, outputs: str) -> tuple[str, ...]:
    """Overrides that leave the dimension of a free ring to the chooser, where loads alone are wanted."""
    return ("model.dimension=auto",) if outputs == LOADS and trials.own[0] == FREE_RING else ()


def _chosen(trials: Trials, outputs: str, wanted: float) -> tuple[Combination, Choice]:
    """What is chosen for a scene where this is wanted; of loads alone also the dimension of a free ring."""
    scene = trials.scene(wanted, outputs, *_left(trials, outputs))
    choice = choose(scene)
    if choice.stepper == QUASI_STATIC:
        return Combination(choice.law, QUASI_STATIC, EVEN, QUASI_STATIC, math.nan), choice
    given = scene.parameters
    return Combination(choice.law, dimension_of(given), given.cage.kind, choice.stepper, choice.setting), choice


def _named(model: Combination) -> str:
    """Its dimension, and its cage."""
    return method_of(model.dimension, model.cage)


def _row(name: str, trials: Trials, outputs: str, wanted: float) -> FidelityRow:
    """What is chosen for a scene where this is wanted, and what would have been best."""
    model, choice = _chosen(trials, outputs, wanted)
    found = trials.trial(model)
    good, done = trials.enough(outputs, wanted), math.isfinite(found.error(outputs))
    own = [model] if found.error(outputs) <= wanted else []
    good += [one for one in own if one not in good]
    alone, spread = trials.cost(model) if done else (math.nan, math.nan)
    seen = trials.watched(model, wanted, outputs) if done else LOST
    row = FidelityRow(
        name,
        model.stepper,
        model.setting,
        load_error=float(found.load_error),
        friction_error=math.nan if outputs == LOADS else float(found.friction_error),
        seconds=alone,
        spread=spread,
        status=DONE if done else FAILED,
        reason=choice.reason,
        outputs=outputs,
        wanted=wanted,
        predicted=_predicted(choice, outputs),
        law=model.law,
        dimension=_named(model),
        watched_seconds=seen.seconds,
        watched_load_error=seen.load_error,
        watched_friction_error=seen.friction_error,
        told=trials.told(wanted, outputs, *_left(trials, outputs)) if done else FAILED,
    )
    if not good:
        return row
    best = min(good, key=lambda one: trials.cost(one)[0])
    return row.but(
        best=best.stepper,
        best_setting=best.setting,
        best_law=best.law,
        best_dimension=_named(best),
        best_seconds=trials.cost(best)[0],
        best_watched_seconds=min(trials.watched(one, wanted, outputs).seconds for one in {best, *good[:2], *own}),
    )


def _predicted(choice: Choice, outputs: str) -> float:
    """The error that the tables promise, NaN for none."""
    told = choice.predicted or {}
    friction = 0.0 if outputs == LOADS else told.get("friction_error", math.nan)
    return max(told.get("load_error", math.nan), friction)


def _quantiles(ratios: Iterable[float]) -> str:
    """Of ratios of costs, in words."""
    known = [one for one in ratios if math.isfinite(one)]
    return f"{np.median(known):.2f} times as a median, {np.quantile(known, 0.95):.2f} times at 95 %"


def _costs(rows: list[FidelityRow]) -> list[str]:
    """What choices cost over the cheapest that was good enough, where both are."""
    good = [p for p in rows if p.kept and p.best]
    if not good:
        return []
    with_it = _quantiles(p.watched_seconds / p.best_watched_seconds for p in good)
    theirs = _quantiles(p.watched_seconds / p.best_seconds for p in good)
    said = [
        f"they cost, over the cheapest that was good enough: {_quantiles(p.seconds / p.best_seconds for p in good)}"
    ]
    for outputs in OUTPUTS_WANTED:
        if mine := [p.seconds / p.best_seconds for p in good if p.outputs == outputs]:
            said.append(f"for {outputs} {_quantiles(mine)}")
    said.append(f"as a user has them, each with its companion: {with_it}; with a companion of theirs alone: {theirs}")
    return ["; ".join(said)]


def reading(points: list[FidelityRow]) -> list[str]:
    """What the chart says."""
    sentences = []
    for who, cases in GROUPS.items():
        mine = [p for p in points if p.problem in cases and p.outputs]
        if not mine:
            continue
        worst = max(mine, key=lambda p: p.error / p.wanted)
        sentences.append(
            f"{who}: {sum(p.kept for p in mine)} of {len(mine)} choices kept what was wanted; the worst, "
            f"{worst.problem} at {worst.wanted:g} for {worst.outputs}, erred {two_digits(worst.error / worst.wanted)} "
            "times that"
        )
        sentences += [_as_users_have_them(mine), *_costs(mine)]
    sentences += [f"all: {one}" for one in _costs([p for p in points if p.outputs])]
    sentences += _best(points)
    told = [p for p in points if math.inf > p.error > 1e-8 and p.predicted > 0.0]
    near = sum(1.0 / 3.0 <= p.error / p.predicted <= 3.0 for p in told)
    low = sum(p.error > 10.0 * p.predicted for p in told)
    sentences.append(
        f"of {len(told)} errors predicted from the table {near} were right within a factor of three, "
        f"{low} were more than ten times too small: a prediction is no estimate of what a run did"
    )
    return sentences


def _as_users_have_them(rows: list[FidelityRow]) -> str:
    """How many runs with their companions kept what was wanted, and whether those that did not say so."""
    worst, missed = max(rows, key=lambda p: p.off), [p for p in rows if not p.off <= 1.0]
    unsaid, said = (sum(p.told == DONE for p in which) for which in (missed, rows))
    return (
        f"as a user has them, each with its companion, {len(rows) - len(missed)} of {len(rows)} kept it; the worst, "
        f"{worst.problem} at {worst.wanted:g} for {worst.outputs}, erred {two_digits(worst.off)} times that; of those "
        f"that did not {unsaid} call themselves {DONE}, of those that did {said - unsaid}"
    )


def _best(points: list[FidelityRow]) -> list[str]:
    """What was cheapest, by law and by dimension."""
    good = [p for p in points if p.best]
    if not good:
        return []
    parts = []
    for what in ("best_law", "best_dimension", "best"):
        counts = Counter(getattr(p, what) for p in good)
        parts.append(", ".join(f"{name} {count}" for name, count in counts.most_common()))
    return [f"cheapest of all that was good enough, in {len(good)} cells: {'; '.join(parts)}"]


def draw(points: list[FidelityRow], path: Path) -> None:
    """Left: error over what was wanted. Right: cost over the cheapest that is good enough."""
    figure = Figure(figsize=(13.0, 6.5), dpi=100, facecolor="white")
    grid = figure.add_gridspec(1, 2, left=0.07, right=0.98, top=0.83, bottom=0.13, wspace=0.2)
    error, cost = figure.add_subplot(grid[0]), figure.add_subplot(grid[1])
    for number, (label, cases) in enumerate(zip(LABELS, GROUPS.values(), strict=True)):
        mine = [p for p in points if p.problem in cases and p.outputs]
        look = {**ball_line(number), "linestyle": "", "marker": "oDs"[number], "markersize": (7, 6, 5)[number]}
        aside = (0.82, 1.0, 1.22)[number]
        error.plot(
            [aside * p.wanted for p in mine],
            [min(max(p.off * p.wanted, LEAST), MOST) for p in mine],
            label=label,
            **look,
        )
        good = [p for p in mine if p.best and p.kept]
        cost.plot([aside * p.wanted for p in good], [p.seconds / p.best_seconds for p in good], label=label, **look)
        ring(cost, good, lambda p, aside=aside: (aside * p.wanted, p.seconds / p.best_seconds), look["color"])
    error.plot([WANTED[-1], WANTED[0]], [WANTED[-1], WANTED[0]], color=STYLE["ink"], linewidth=1.2)
    error.annotate("as wanted", (4e-3, 5e-3), color=STYLE["ink"], ha="left", va="bottom", fontsize=11)
    error.set(
        xscale="log", yscale="log", xlabel="tolerance that was wanted", ylabel="error of the run as a user has it"
    )
    cost.set(
        xscale="log",
        yscale="log",
        xlabel="tolerance that was wanted",
        ylabel="CPU time over that of the cheapest good enough",
    )
    cost.axhline(1.0, color=STYLE["ink"], linewidth=1.2)
    for axis, title in ((error, "What was wanted is kept below the line"), (cost, "What the choice costs too much")):
        frame(axis)
        axis.invert_xaxis()
        heading(axis, title)
        key_above(axis)
    bearings = len({p.problem for p in points})
    title = f"The chooser against all that could be chosen, {bearings} bearings over {1e3 * SPAN:g} ms"
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
