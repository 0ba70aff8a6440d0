"""Accuracy against speed of the steppers: the same problems by every method, judged by load and friction torque.

Error across, seconds of one core per simulated second up, both logarithmic; one line a method, a cross along the right
edge for each failure. The reference is `rodas4` at a tolerance a thousand times tighter than any contestant's.
"""

import csv
import platform
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from bearing_twin import __version__
from bearing_twin.errors import BearingTwinError
from bearing_twin.kinds.bearing.motion import FIXED_STEP, REFERENCE_SHARE, BearingMotion
from bearing_twin.numerics.steppers import STEPPER_FACTS
from bearing_twin.pictures.style import STYLE, ball_line, frame, heading
from bearing_twin.run.fidelity import choose
from bearing_twin.run.scene import load_scene

FINEST = 1e-7
LEAST, EDGE = 1e-9, 10.0  # of the error axis: smaller errors are drawn at its start, failures at its end
REPEATS = 3


class BearingProblem(NamedTuple):
    """A bearing over `count` instants `period` [s] apart; what it tests is in `title`."""

    title: str
    scene: str
    overrides: tuple[str, ...]
    period: float
    count: int


class Method(NamedTuple):
    """A stepper with its ladder: tolerances of an adaptive one, steps [s] of a fixed one."""

    stepper: str
    ladder: tuple[float, ...]


PROBLEMS = {
    "settled": BearingProblem("settled, outputs every 1 ms", "bearing_6203", (), 1e-3, 100),
    "sliding": BearingProblem(
        "from rest: sliding, ringing",
        "bearing_6203",
        ("initial.motion=rest", "drive.offset=[0.0, -1e-6, 5e-6]"),
        5e-5,
        20,
    ),
    "lift-off": BearingProblem("clearance, lift-off", "bearing_6203_loose", (), 1e-3, 20),
    "sticking": BearingProblem(
        "friction regularised at 0.1 mm/s", "bearing_6203", ("contact.friction_regularisation=1e-4",), 1e-3, 5
    ),
    "fast": BearingProblem("20 000 rpm, outputs every 1 ms", "bearing_6203_fast", (), 1e-3, 20),
    "sudden": BearingProblem(
        "sudden speed and load", "bearing_6203_sudden", ("drive.change.time=2e-4", "drive.acceleration=1e6"), 5e-5, 20
    ),
}
TOLERANCES, STEPS = (1e-1, 1e-3, 1e-5), (4e-6, 2e-6, 1e-6, 5e-7, 2.5e-7)
FINER = {  # ladders of methods that are worth more points
    "rodas4": (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5),
    "rodas4_landing": (1e-1, 1e-2, 1e-3, 1e-4, 3e-5, 1e-5),
    "rodas3": (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 1e-4, 1e-5),
}
LADDERS = tuple(
    Method(name, FINER.get(name, TOLERANCES if facts.adaptive else STEPS)) for name, facts in STEPPER_FACTS.items()
)
SLOWEST = 1e3  # seconds per simulated second beyond which the rest of a ladder is not run


@dataclass(frozen=True)
class StepperPoint:
    """One run: relative errors of normal load and friction torque, cost, or why it failed."""

    problem: str
    stepper: str
    setting: float
    load_error: float
    torque_error: float
    seconds_per_second: float
    failure: str = ""


def _motion(problem: BearingProblem, stepper: str, setting: float) -> BearingMotion:
    key = "solver.step" if stepper in FIXED_STEP else "wanted.tolerance"
    scene = load_scene(problem.scene, (*problem.overrides, f"{key}={setting}"))
    motion = BearingMotion(scene.parameters, choose(scene)._replace(law="hertz", stepper=stepper))
    if stepper in ("dop853", "radau"):
        # As contestants they get the tolerance asked for, not the one that makes them references.
        motion.scales = motion.scales / REFERENCE_SHARE
    return motion


def _run(motion: BearingMotion, problem: BearingProblem):
    times = problem.period * np.arange(1, problem.count + 1)
    return motion.advance(times, float(times[-1]))


def _relative(found, exact) -> float:
    error = float(np.abs(found - exact).max() / np.abs(exact).max())
    return error if np.isfinite(error) else np.inf


def _measure(name: str, problem: BearingProblem, stepper: str, setting: float, exact) -> StepperPoint:
    """One point of the chart; a refusal or a breakdown is a point, too."""
    try:
        motion = _motion(problem, stepper, setting)
        motion.advance(np.array([1e-8]), 1e-8)  # what compiles is not timed
        seconds = []
        # The slow ones are run once: their cost is not in doubt.
        while len(seconds) < REPEATS and sum(seconds) < 1.0:
            motion.reset()
            start = time.perf_counter()
            out = _run(motion, problem)
            seconds.append(time.perf_counter() - start)
    except BearingTwinError as error:
        return StepperPoint(name, stepper, setting, np.inf, np.inf, np.nan, str(error))
    cost = float(np.median(seconds)) / (problem.period * problem.count)
    load = _relative(out.normal_load, exact.normal_load)
    return StepperPoint(name, stepper, setting, load, _relative(out.raceway_torque, exact.raceway_torque), cost)


def measure(names=tuple(PROBLEMS), progress: Callable[[str], None] = lambda _: None) -> Iterator[StepperPoint]:
    """Every method on the named problems, coarse settings first; compiles before it measures."""
    for name in names:
        problem = PROBLEMS[name]
        exact = _run(_motion(problem, "rodas4", FINEST), problem)
        for method in LADDERS:
            if method.stepper == "rk4":
                _run(_motion(PROBLEMS["sliding"], "rk4", 5e-7), PROBLEMS["sliding"]._replace(count=1))
            for setting in method.ladder:
                progress(f"{name}: {method.stepper} {setting:g}")
                point = _measure(name, problem, method.stepper, setting, exact)
                yield point
                if point.seconds_per_second > SLOWEST:
                    break


def write_table(points: list[StepperPoint], path: Path) -> None:
    """The points as comma-separated values."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream)
        table.writerow(
            ["problem", "stepper", "setting", "load_error", "torque_error", "seconds_per_simulated_second", "failure"]
        )
        for p in points:
            table.writerow(
                [p.problem, p.stepper, p.setting, p.load_error, p.torque_error, p.seconds_per_second, p.failure]
            )


def _panel(axis, points: list[StepperPoint], error_of: Callable[[StepperPoint], float], says: bool) -> None:
    """One panel; only one of the two of a row says what the crosses are."""
    for number, method in enumerate(LADDERS):
        look = ball_line(number)
        colour = look["color"]
        mine = [p for p in points if p.stepper == method.stepper]
        good = [(max(error_of(p), LEAST), p.seconds_per_second) for p in mine if not p.failure]
        failed = sum(1 for p in mine if p.failure)
        axis.plot(*np.transpose(good or [(np.nan, np.nan)]), "o", **look, label=method.stepper, markersize=5)
        if failed:
            # Failures stand on the right edge, where errors of load are rare, whatever the scale of the panel.
            place = axis.get_xaxis_transform()
            height = 0.3 + 0.08 * number
            axis.plot([EDGE] * failed, [height] * failed, "x", color=colour, markeredgewidth=2, transform=place)
            text = f"{method.stepper}: {failed} refused or broken  " if says else ""
            axis.text(EDGE, height, text, ha="right", va="center", fontsize=9, color=colour, transform=place)
    axis.axhline(1.0, color=STYLE["soft"], linewidth=1, linestyle=":")
    axis.axvline(1e-3, color=STYLE["soft"], linewidth=1, linestyle=":")
    axis.set(xscale="log", yscale="log", xlim=(0.5 * LEAST, 2.0 * EDGE))


def draw(points: list[StepperPoint], path: Path) -> None:
    """The chart: one row a problem, error in load on the left, in friction torque on the right."""
    names = list(dict.fromkeys(p.problem for p in points))
    figure = Figure(figsize=(14, 3.6 * len(names) + 1.4), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(len(names), 2, sharex=True, sharey="row", squeeze=False)
    for row, name in zip(axes, names, strict=True):
        mine = [p for p in points if p.problem == name]
        _panel(row[0], mine, lambda p: p.load_error, True)
        _panel(row[1], mine, lambda p: p.torque_error, False)
        heading(row[0], PROBLEMS[name].title)
        row[0].set_ylabel("seconds per simulated second")
        for axis in row:
            frame(axis)
    axes[0][0].legend(loc="center", ncols=2, fontsize=11, frameon=False, bbox_to_anchor=(0.36, 0.36))
    axes[-1][0].set_xlabel("greatest error of a normal load, over the greatest load")
    axes[-1][1].set_xlabel("greatest error of a friction torque, over the greatest")
    figure.suptitle(
        "Steppers: accuracy against cost, one core (dotted: real time, 1e-3)", fontsize=16, color=STYLE["ink"]
    )
    figure.supxlabel(
        f"bearing_twin {__version__}, numpy {np.__version__}, Python {platform.python_version()}, "
        f"{platform.machine()}, {time.strftime('%Y-%m-%d')}",
        fontsize=9,
        color=STYLE["soft"],
    )
    figure.savefig(path, dpi=100)


def cheapest(points: list[StepperPoint], problem: str, stepper: str, wanted: float = 1e-3) -> StepperPoint | None:
    """The cheapest point of a method with both errors within `wanted`; None if there is none."""
    good = [
        p
        for p in points
        if (p.problem, p.stepper) == (problem, stepper) and max(p.load_error, p.torque_error) <= wanted
    ]
    return min(good, key=lambda p: p.seconds_per_second, default=None)


def reading(points: list[StepperPoint]) -> list[str]:
    """What the chart says, a sentence a problem."""
    sentences = []
    for name in dict.fromkeys(p.problem for p in points):
        parts = []
        for method in LADDERS:
            best = cheapest(points, name, method.stepper)
            parts.append(
                f"{method.stepper} {1.0 / best.seconds_per_second:.3g}" if best else f"{method.stepper} not at all"
            )
        sentences.append(
            f"{PROBLEMS[name].title}: load and torque within 1e-3 at so many times real time: {', '.join(parts)}."
        )
    return sentences
