"""What a tolerance is worth: the error asked for against the error got, and what the run itself says its error is.

Shipped bearing scenes, shortened, and variants of them, run as `simulate` runs them, against the same scene at a
tolerance so tight that it counts as true; then others that nothing of the companion was fitted to, some chosen later
still, and some held out while what all these showed was mended. Errors are those of the chart of steppers: of load over
the greatest load, of friction over mu N of a contact or mu N R of a ball. `reason` tells what failed.
"""

import functools
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.charts.bearing_cells import errors
from bearing_twin.charts.bearing_variants import GROUPS, UNSEEN
from bearing_twin.charts.chart import Chart
from bearing_twin.charts.contest import judged
from bearing_twin.charts.scene_rows import command_of
from bearing_twin.charts.table import DONE, Row
from bearing_twin.errors import IntegrationError
from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.kinds.bearing.outputs import Rows
from bearing_twin.pictures.style import BALL_COLOURS, STYLE, frame, heading, save_chart
from bearing_twin.run.doubt import MUCH
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Run, simulate

EXACT = 1e-8
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
KNOWABLE = 1e-8  # true errors below this are not compared with estimates: the reference is no better ...
ROUGHER, CLEAR = 3.0, 3.0  # ... nor those up to so many times what the reference differs from a run so much rougher
NEAR, FAR = 3.0, 10.0  # factors between estimate and true error
OUTPUTS = ("loads", "friction")
ALONE = "solver.companion=off"
CASES = {  # name: scene, what differs; those after the seventh are variants
    "settled": ("bearing_6203", ("run.duration=0.2",)),
    "6205": ("bearing_6205", ("run.duration=0.2",)),
    "fast": ("bearing_6203_fast", ("run.duration=0.1",)),
    "sticking": ("bearing_6203_sticking", ("run.duration=0.05",)),
    "lift-off": ("bearing_6203_loose", ("run.duration=0.2",)),
    "from rest": ("bearing_6203_start", ()),
    "sudden": ("bearing_6203_sudden", ("run.duration=0.05",)),
    "slippery, off centre": (
        "bearing_6203",
        ("run.duration=0.1", "contact.friction_coefficient=0.02", "drive.offset=[0,-2e-6,2e-5]"),
    ),
    "sped up": ("bearing_6203", ("run.duration=0.1", "drive.change.time=0.03", "drive.change.speed=50")),
    "lift-off, faster": ("bearing_6203_loose", ("run.duration=0.1", "drive.speed=400")),
    "lift-off, wider": (
        "bearing_6203_loose",
        ("run.duration=0.1", "geometry.radial_clearance=20e-6", "drive.offset=[2e-6,-14e-6,0]"),
    ),
    "6205, lift-off": (
        "bearing_6205",
        ("run.duration=0.1", "geometry.radial_clearance=10e-6", "drive.offset=[0,-8e-6,0]"),
    ),
    "from rest, off centre": (
        "bearing_6203_start",
        ("run.duration=0.02", "drive.speed=90", "drive.offset=[3e-6,-2e-6,8e-6]"),
    ),
    "sudden, harder": ("bearing_6203_sudden", ("run.duration=0.04", "drive.change.offset=[2e-6,-5e-6,1e-6]")),
}
ALL_CASES = CASES | UNSEEN
METHOD = "as chosen"


@dataclass(frozen=True)
class ToleranceRow(Row):
    """One run: true and estimated errors of load and friction, what it says of itself (`told`), and its steps.

    `load_known` and `friction_known` are the least errors that can be told from those of the reference. `steps` are
    those of a run that nobody watches, `watched_steps` those with what was done again, `companion_steps` the
    companion's; `seconds` are CPU seconds of the whole run, `evaluations` steps of balls.
    """

    load_estimate: float = np.nan
    friction_estimate: float = np.nan
    told: str = ""
    steps: int = 0
    watched_steps: int = 0
    companion_steps: int = 0
    load_known: float = KNOWABLE
    friction_known: float = KNOWABLE

    @property
    def kept(self) -> bool:
        """Whether the error is what was asked for."""
        return self.error <= self.setting

    @property
    def doubtful(self) -> bool:
        """Whether the run says that its error is more."""
        return self.told.startswith("doubtful")

    @property
    def missed(self) -> bool:
        """Whether it is more, where the reference itself is off by no more than that: else nobody knows."""
        return not self.kept and max(self.load_known, self.friction_known) <= self.setting

    @property
    def ratios(self) -> list[float]:
        """Estimates over true errors, of those that can be known."""
        return [found / true for found, true in self.pairs]

    @property
    def pairs(self) -> list[tuple[float, float]]:
        """Estimates and true errors, of those that can be known."""
        found = (
            (self.load_estimate, self.load_error, self.load_known),
            (self.friction_estimate, self.friction_error, self.friction_known),
        )
        return [(estimate, true) for estimate, true, known in found if true > known]


def _run(case: str, *overrides: str) -> tuple[Run, Rows]:
    """A run of a case to its end, and all its outputs but the first."""
    name, differs = ALL_CASES[case]
    run = simulate(load_scene(name, (*differs, *overrides)))
    blocks = list(run.blocks())
    return run, Rows(blocks[0].values.layout, np.concatenate([block.matrix() for block in blocks])[1:])


@functools.lru_cache(maxsize=1)
def _exact(case: str) -> tuple[Rows, tuple[float, ...]]:
    """The outputs that count as true, and the least errors of load and friction that they can show.

    A process is at one case at a time.
    """
    _, exact = _run(case, f"wanted.tolerance={EXACT!r}", ALONE)
    run, rougher = _run(case, f"wanted.tolerance={ROUGHER * EXACT!r}", ALONE)
    off = errors(BearingMotion(run.scene.parameters, run.choice), rougher, exact)
    return exact, tuple(max(KNOWABLE, CLEAR * one) for one in off)


def judge(case: str, _: str, tolerance: float, limit: float) -> ToleranceRow:
    """One run beside the truth."""
    exact, (load, friction) = _exact(case)
    row = ToleranceRow(case, METHOD, tolerance, command=_command(case, METHOD, tolerance))
    return judged(row.but(load_known=load, friction_known=friction), lambda: _outcome(case, tolerance, exact), limit)


def _outcome(case: str, tolerance: float, exact: Rows) -> dict:
    asked, start = f"wanted.tolerance={tolerance!r}", time.thread_time()
    run, found = _run(case, asked)
    seconds = time.thread_time() - start
    try:
        plain = _run(case, asked, ALONE)[0].report.costs["ball_steps"]
    except IntegrationError:  # too rough where nobody watches: there is nothing to compare with
        plain = 0
    wanted, costs = run.report.errors["wanted_errors"], run.report.costs
    load, friction = errors(BearingMotion(run.scene.parameters, run.choice), found, exact)
    load_estimate, friction_estimate = (wanted[name]["error"] for name in OUTPUTS)
    return {
        "load_error": load,
        "friction_error": friction,
        "seconds": seconds,
        "evaluations": costs["ball_steps"] + costs["companion_ball_steps"],
        "load_estimate": np.nan if load_estimate is None else load_estimate,
        "friction_estimate": np.nan if friction_estimate is None else friction_estimate,
        "told": run.report.status,
        "steps": plain,
        "watched_steps": costs["ball_steps"],
        "companion_steps": costs["companion_ball_steps"],
    }


def _command(case: str, _: str, tolerance: float) -> str:
    scene, differs = ALL_CASES[case]
    return command_of(scene, (*differs, f"wanted.tolerance={tolerance:g}"))


def _look(number: int, case: str) -> dict:
    if case in UNSEEN:
        return {"color": STYLE["soft"], "marker": "."}
    return {"color": BALL_COLOURS[number % len(BALL_COLOURS)], "marker": "os^Dv"[number // len(BALL_COLOURS)]}


def draw(points: list[ToleranceRow], path: Path) -> None:
    """Error got over tolerance asked, and estimates over true errors; open marks are doubtful runs."""
    figure = Figure(figsize=(15, 8.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    good, names = [p for p in points if p.status == DONE], list(dict.fromkeys(p.problem for p in points))
    for number, case in enumerate(names):
        look = _look(number, case)
        for p in (p for p in good if p.problem == case):
            fill = "none" if p.doubtful else look["color"]
            shift = 1.0 + 0.03 * (min(number, len(CASES)) - 0.5 * len(CASES))  # side by side
            left.plot(p.setting * shift, p.error, look["marker"], mfc=fill, mec=look["color"], ms=9, mew=1.6)
            right.plot(
                [true for _, true in p.pairs],
                p.ratios,
                look["marker"],
                mfc=fill,
                mec=look["color"],
                ms=8,
                mew=1.4,
                linestyle="none",
            )
        lost = [p.setting for p in points if p.problem == case and p.status != DONE]
        left.plot(lost, [1.0] * len(lost), "x", color=look["color"], ms=11, mew=2.5)
        label = case if case not in UNSEEN else "variants unseen" if case == names[-1] else None
        left.plot([], [], look["marker"], mfc=look["color"], mec=look["color"], ms=9, linestyle="none", label=label)
    ends = np.array([min(p.setting for p in points), max(p.setting for p in points)])
    left.plot(ends, ends, color=STYLE["ink"], linewidth=1.5)
    middle = float(np.sqrt(ends.prod()))
    left.text(0.8 * middle, 1.5 * middle, "as asked", ha="right", fontsize=13, color=STYLE["ink"])
    for factor in (1.0 / FAR, 1.0 / NEAR, 1.0, NEAR, FAR):
        right.axhline(
            factor, color=STYLE["ink"], linewidth=1.5 if factor == 1.0 else 1.0, linestyle="-" if factor == 1.0 else ":"
        )
    left.set(
        xscale="log", yscale="log", xlabel="tolerance asked for", ylabel="true error of load or friction, the greater"
    )
    right.set(xscale="log", yscale="log", xlabel="true error", ylabel="what the run says of it / true error")
    titles = (
        "error got (open marks: the run calls itself doubtful)",
        f"estimates (dotted: factors {NEAR:g} and {FAR:g})",
    )
    for axis, title in zip((left, right), titles, strict=True):
        heading(axis, title)
        frame(axis)
    figure.legend(loc="outside right upper", fontsize=12, frameon=False)
    save_chart(figure, "A tolerance and what it is worth", path)


def _share(number: int, total: int) -> str:
    return f"{number} of {total}"


def reading(points: list[ToleranceRow]) -> Iterator[str]:
    """What the chart says, of the scenes it was made with and of those that nothing was fitted to."""
    for who, cases in ({"Scenes known": CASES} | GROUPS).items():
        mine = [p for p in points if p.problem in cases]
        if mine:
            yield from (f"{who}: {sentence}" for sentence in _read_group(mine))


def _read_group(points: list[ToleranceRow]) -> Iterator[str]:
    good = [p for p in points if p.status == DONE]
    missed, kept = [p for p in good if p.missed], [p for p in good if p.kept]
    yield f"the error is within the tolerance in {_share(len(kept), len(points))} runs."
    if lost := [p for p in good if not p.kept and not p.missed]:
        told = ", ".join(dict.fromkeys(p.problem for p in lost)), _share(sum(p.doubtful for p in lost), len(lost))
        yield "in {} runs nobody knows, as the reference is off by more ({}); doubtful are {}.".format(len(lost), *told)
    unsaid = [p for p in missed if not p.doubtful]
    if missed:
        worst = max(p.error / p.setting for p in missed)
        yield (
            f"where it is more, the run calls itself doubtful in {_share(len(missed) - len(unsaid), len(missed))}; the "
            f"greatest error is {worst:.2g} times the tolerance."
        )
    if unsaid:
        yield "unsaid are " + "; ".join(f"{p.problem} at {p.setting:g}, {p.error:.2g}" for p in unsaid) + "."
    yield from (f"{p.problem} at {p.setting:g}: {p.reason}" for p in points if p.status != DONE)
    if not good:
        return
    ratios = np.array([ratio for p in good for ratio in p.ratios])
    near = int(((ratios > 1.0 / NEAR) & (ratios < NEAR)).sum())
    yield (
        f"estimates are within a factor {NEAR:g} of the true error in {_share(near, len(ratios))}, less than a tenth "
        f"of it in {int((ratios < 1.0 / FAR).sum())}, more than {FAR:g} times it in {int((ratios > FAR).sum())}; their "
        f"median is {np.median(ratios):.2g} times it."
    )
    shares = {(p.problem, p.setting): p.companion_steps / p.watched_steps for p in good if p.watched_steps}
    taken, costs = list(shares.values()), [(p.companion_steps + p.watched_steps) / p.steps for p in good if p.steps]
    yield (
        f"the companion takes {100.0 * np.median(taken):.2g} % of a run's steps as a median and "
        f"{100.0 * max(taken):.3g} % at most; with what is done again a run takes {np.median(costs):.2g} times the "
        f"steps of one that nobody watches, {max(costs):.2g} at most."
    )
    if dear := [case for (case, _), share in shares.items() if share > MUCH]:
        named = ", ".join(f"{case} ({dear.count(case)})" for case in dict.fromkeys(dear))
        yield f"it takes over {100.0 * MUCH:g} % in {_share(len(dear), len(shares))} runs: {named}."


CONTESTS = {
    "tolerance": Chart(
        judge=judge,
        problems={name: name for name in ALL_CASES},
        entries=lambda name: ((METHOD, tolerance) for tolerance in TOLERANCES),
        kind=ToleranceRow,
        command=_command,
        drawn=draw,
        told=reading,
    )
}
