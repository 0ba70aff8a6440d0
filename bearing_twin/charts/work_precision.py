"""Accuracy against speed of the steppers: the same problems by every method, judged by load and friction.

Error across, CPU seconds per simulated second up, both logarithmic; one line a method, a cross along the right edge for
each failure. The reference is `rodas4` at a tolerance a hundred times tighter than its ladder's. A ladder on which all
settings miss goes on, finer and finer, until one is good or too slow.
"""

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
from bearing_twin.charts.contest_picture import found_again
from bearing_twin.charts.table import write_rows
from bearing_twin.errors import BearingTwinError
from bearing_twin.kinds.bearing.error_scales import STEP_SHARE
from bearing_twin.kinds.bearing.integrate import REFERENCE_SHARE
from bearing_twin.kinds.bearing.motion import FIXED_STEP, BearingMotion
from bearing_twin.numerics.steppers import ROSENBROCK, STEPPER_FACTS
from bearing_twin.pictures.style import STYLE, ball_line, frame, heading
from bearing_twin.report import Choice
from bearing_twin.run.scene import load_scene

FINEST = 1e-7
DEFAULT = "rodas4"  # whose share of the tolerance for one step is judged
WANTED = 1e-3  # the error in load and in friction at which costs are compared
LEAST_LOAD = 0.01  # of the greatest load: a contact that carries less has no friction limit worth a relative error
LEAST, EDGE = 1e-9, 10.0  # of the error axis: smaller errors are drawn at its start, failures at its end
REPEATS, LONG_ENOUGH = (3, 30), 0.3  # least and most runs of a setting; CPU seconds that are enough of them


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
FINER_BY, LAST = {True: 0.1, False: 0.5}, {True: 1e-12, False: 1e-9}  # adaptive or not: how a ladder goes on, to where
SLOWEST = 1e3  # CPU seconds per simulated second beyond which a ladder ends


@dataclass(frozen=True)
class StepperPoint:
    """One run: relative errors of normal load and of friction (`errors`), CPU cost, or why it failed."""

    problem: str
    stepper: str
    setting: float
    load_error: float
    friction_error: float
    seconds_per_second: float
    failure: str = ""


POINT = StepperPoint


def _motion(problem: BearingProblem, stepper: str, setting: float) -> BearingMotion:
    key = "solver.step" if stepper in FIXED_STEP else "wanted.tolerance"
    scene = load_scene(problem.scene, (*problem.overrides, f"{key}={setting}"))
    motion = BearingMotion(scene.parameters, Choice("hertz", stepper, 0.0, "", ()))
    if stepper in ("dop853", "radau"):
        # As contestants they get the tolerance asked for, not the one that makes them references.
        motion.scales = motion.scales / REFERENCE_SHARE
    return motion


def _run(motion: BearingMotion, problem: BearingProblem):
    times = problem.period * np.arange(1, problem.count + 1)
    return motion.advance(times, float(times[-1]))


def errors(motion: BearingMotion, found, exact) -> tuple[float, float]:
    """Greatest errors of `found` outputs: of load, and of friction; infinite where something is not finite.

    That of a load is over the greatest load. That of friction is over what friction could be there and then: of a
    contact's force over mu N, of the raceways' torque on a ball over mu N R, N the load of the contact or of both.
    """
    coefficient, radius = motion.parameters.contact.friction_coefficient, motion.bearing.ball_radius
    greatest = exact.normal_load.max()
    load = np.abs(found.normal_load - exact.normal_load).max() / greatest
    force = np.linalg.norm(found.friction_force - exact.friction_force, axis=-1)
    torque = np.linalg.norm(found.raceway_torque - exact.raceway_torque, axis=-1) / radius
    friction = max(
        (force / np.maximum(exact.normal_load, LEAST_LOAD * greatest)).max(),
        (torque / np.maximum(exact.normal_load.sum(axis=-1), LEAST_LOAD * greatest)).max(),
    )
    pair = float(load), float(friction) / coefficient
    return pair if all(map(np.isfinite, pair)) else (np.inf, np.inf)


def _measure(name: str, problem: BearingProblem, stepper: str, setting: float, exact) -> StepperPoint:
    """One point of the chart; a refusal or a breakdown is a point, too."""
    try:
        motion = _motion(problem, stepper, setting)
        motion.advance(np.array([1e-8]), 1e-8)  # what compiles is not timed
        seconds = []
        # The slow ones are run once: their cost is not in doubt.
        while len(seconds) < REPEATS[sum(seconds) < LONG_ENOUGH] and sum(seconds) < 1.0:
            motion.reset()
            start = time.process_time()
            out = _run(motion, problem)
            seconds.append(time.process_time() - start)
    except BearingTwinError as error:
        return StepperPoint(name, stepper, setting, np.inf, np.inf, np.nan, str(error))
    cost = float(np.median(seconds)) / (problem.period * problem.count)
    return StepperPoint(name, stepper, setting, *errors(motion, out, exact), cost)


def _settings(method: Method) -> Iterator[float]:
    """The ladder, and ever finer settings below it."""
    yield from method.ladder
    adaptive = STEPPER_FACTS[method.stepper].adaptive
    setting = FINER_BY[adaptive] * method.ladder[-1]
    while setting > LAST[adaptive]:
        yield setting
        setting *= FINER_BY[adaptive]


def measure(names=tuple(PROBLEMS), progress: Callable[[str], None] = lambda _: None) -> Iterator[StepperPoint]:
    """Every method on the named problems, coarse settings first; compiles before it measures."""
    for name in names:
        problem = PROBLEMS[name]
        exact = _run(_motion(problem, "rodas4", FINEST), problem)
        for method in LADDERS:
            if method.stepper == "rk4":
                _run(_motion(PROBLEMS["sliding"], "rk4", 5e-7), PROBLEMS["sliding"]._replace(count=1))
            good = False
            for setting in _settings(method):
                if good and setting < method.ladder[-1]:
                    break
                progress(f"{name}: {method.stepper} {setting:g}")
                point = _measure(name, problem, method.stepper, setting, exact)
                yield point
                good = good or _good(point, WANTED)
                if point.seconds_per_second > SLOWEST:
                    break


def write_table(points: list[StepperPoint], path: Path) -> None:
    """The points as comma-separated values."""
    header = ["problem", "stepper", "setting", "load_error", "friction_error", "cpu_per_simulated_second", "failure"]
    numbers = "problem", "stepper", "setting", "load_error", "friction_error", "seconds_per_second", "failure"
    write_rows(path, header, ([getattr(p, name) for name in numbers] for p in points))


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
    axis.axvline(WANTED, color=STYLE["soft"], linewidth=1, linestyle=":")
    axis.set(xscale="log", yscale="log", xlim=(0.5 * LEAST, 2.0 * EDGE))


def draw(points: list[StepperPoint], path: Path) -> None:
    """The chart: one row a problem, error in load on the left, in friction on the right."""
    names = list(dict.fromkeys(p.problem for p in points))
    figure = Figure(figsize=(14, 3.6 * len(names) + 1.4), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(len(names), 2, sharex=True, sharey="row", squeeze=False)
    for row, name in zip(axes, names, strict=True):
        mine = [p for p in points if p.problem == name]
        _panel(row[0], mine, lambda p: p.load_error, True)
        _panel(row[1], mine, lambda p: p.friction_error, False)
        heading(row[0], PROBLEMS[name].title)
        row[0].set_ylabel("CPU s per simulated s")
        for axis in row:
            frame(axis)
    axes[0][0].legend(loc="center", ncols=2, fontsize=11, frameon=False, bbox_to_anchor=(0.36, 0.36))
    axes[-1][0].set_xlabel("greatest error of a normal load, over the greatest load")
    axes[-1][1].set_xlabel("greatest error of friction, over mu N of its contact or ball")
    figure.suptitle(
        f"Steppers: accuracy against cost, one core (dotted: real time, {WANTED:g})", fontsize=16, color=STYLE["ink"]
    )
    figure.supxlabel(
        f"bearing_twin {__version__}, numpy {np.__version__}, Python {platform.python_version()}, "
        f"{platform.machine()}, {time.strftime('%Y-%m-%d')}",
        fontsize=9,
        color=STYLE["soft"],
    )
    figure.savefig(path, dpi=100)


def _good(point: StepperPoint, wanted: float) -> bool:
    return max(point.load_error, point.friction_error) <= wanted


def cheapest(points: list[StepperPoint], problem: str, stepper: str, wanted: float = WANTED) -> StepperPoint | None:
    """The cheapest point of a method with both errors within `wanted`; None if there is none."""
    good = [p for p in points if (p.problem, p.stepper) == (problem, stepper) and _good(p, wanted)]
    return min(good, key=lambda p: p.seconds_per_second, default=None)


def shares_of_steps(points: list[StepperPoint], stepper: str) -> dict[str, tuple[float, float]]:
    """By problem: the greatest error over its setting, and the share of it a step may err by if that is to be 1.

    A step may err by STEP_SHARE of the tolerance, so that a ladder of tolerances is a ladder of shares as well.
    """
    found = {}
    for name in dict.fromkeys(p.problem for p in points):
        mine = [p for p in points if (p.problem, p.stepper) == (name, stepper) and not p.failure]
        worst = max((max(p.load_error, p.friction_error) / p.setting for p in mine), default=0.0)
        if worst > 0.0:
            found[name] = worst, STEP_SHARE / worst
    return found


def confirmed(points: list[StepperPoint]) -> list[str]:
    """How near methods that are no Rosenbrock methods come to the reference, which is by one."""
    runs = ((p.problem, p.stepper, max(p.load_error, p.friction_error)) for p in points)
    return found_again(runs, ROSENBROCK)


def reading(points: list[StepperPoint]) -> list[str]:
    """What the chart says, a sentence a problem, and one on the share of the tolerance that a step may err by."""
    sentences = []
    for name in dict.fromkeys(p.problem for p in points):
        parts = []
        for method in LADDERS:
            best = cheapest(points, name, method.stepper)
            parts.append(
                f"{method.stepper} {1.0 / best.seconds_per_second:.3g}" if best else f"{method.stepper} at no setting"
            )
        sentences.append(
            f"{PROBLEMS[name].title}: load and friction within {WANTED:g} at so many times real time: "
            f"{', '.join(parts)}."
        )
    sentences += confirmed(points)
    shares = shares_of_steps(points, DEFAULT)
    if shares:
        told = ", ".join(f"{PROBLEMS[name].title} {share:.2g}" for name, (_, share) in shares.items())
        sentences.append(f"A step of {DEFAULT} may err by {STEP_SHARE:g} of the tolerance; what just keeps it: {told}.")
    return sentences
