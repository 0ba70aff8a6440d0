"""The elastic laws against each other: error of the load over the ellipse's shape, and nanoseconds an evaluation.

Error is against exact Hertz; one line a law, a cross along the upper edge where a law fails (more than 10 % off, or no
number). Laws with states carry them over swings of the shape, each 16 Runge-Kutta steps long.
"""

import math
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from bearing_twin.charts.table import write_rows
from bearing_twin.compiled import kernel
from bearing_twin.contact.calculator import COMPARED as CONTESTANTS
from bearing_twin.contact.differential import Shape, differential_coefficient, follow
from bearing_twin.contact.elasticity import NO_SHAPE, coefficient_at, coefficient_of, elasticity
from bearing_twin.contact.ellipse import curvature_ratio, hertz_coefficient
from bearing_twin.contact.laws import LAWS
from bearing_twin.pictures.style import STYLE, ball_line, frame, heading, stamp

LEAST = 1e-12  # smaller errors are drawn here
FAILED = 0.1  # an error beyond this is a cross
FROZEN_AT = 0.1  # b/a at which laws that do not follow the curvatures are exact: a ball in a raceway
RAILS = np.geomspace(1e-3, 1.0, 49)  # b/a
BEARING = (0.08, 0.18)  # b/a of steel balls in raceways
SWING, STEPS = 40, 16  # turns and steps a turn of the differential forms
EVALUATIONS, REPEATS = 20_000, 5


@dataclass(frozen=True)
class LawPoint:
    """One law at one shape: relative error of the load (NaN where it gives none) and ns an evaluation."""

    law: str
    axis_ratio: float
    error: float
    nanoseconds: float

    @property
    def failed(self) -> bool:
        """Whether this point is a cross."""
        return not abs(self.error) < FAILED


POINT = LawPoint


@kernel
def _evaluate(law, large):
    total = 0.0
    for k in range(len(large)):
        total += coefficient_at(law, 1.0, large[k], NO_SHAPE)
    return total


def _history(ratio, turns):
    """C = P/Q swinging by a factor e^(1/2) either way about that of b/a = `ratio`, with its rate and step."""
    count = turns * STEPS
    middle = -math.log(curvature_ratio(ratio))
    phase = 2.0 * math.pi * 0.5 / STEPS * np.arange(2 * count + 1)
    swing = min(0.5, -0.5 * middle)
    course = np.exp(middle + swing * np.sin(phase))
    return course, course * swing * 2.0 * math.pi * np.cos(phase), 1.0 / STEPS


def _differential_error(ratio, project):
    """The greatest error in the last of 40 turns."""
    course, rates, step = _history(ratio, SWING)
    worst = 0.0
    for state, c in zip(follow(course, rates, step, project)[-STEPS:], course[::2][-STEPS:], strict=True):
        error = differential_coefficient(Shape(*state), c, 1.0) / hertz_coefficient(c, 1.0, 1.0) - 1.0
        worst = error if not abs(error) < abs(worst) else worst
    return worst


def seconds_each(work, count) -> float:
    """Median time of one of the `count` evaluations in `work`, compiled before."""
    work()
    spans = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        work()
        spans.append(time.perf_counter() - start)
    return float(np.median(spans)) / count


def measure(ratios=RAILS) -> list[LawPoint]:
    """Every contestant at every b/a in `ratios`, law by law."""
    frozen = hertz_coefficient(1.0, curvature_ratio(FROZEN_AT), 1.0) * curvature_ratio(FROZEN_AT) ** 0.25
    large = np.array([curvature_ratio(ratio) for ratio in np.geomspace(*BEARING, EVALUATIONS)])
    points = []
    for name in CONTESTANTS:
        state = LAWS[name].state
        if state is None:
            law = elasticity(name, 1.0, 1.0)
            cost = seconds_each(lambda law=law: _evaluate(law, large), EVALUATIONS)
            errors = []
            for ratio in ratios:
                q = curvature_ratio(ratio)
                # bodies of equal sqrt(PQ), an approach of 1 m: what such a law does not see is the shape
                found = coefficient_of(name, 1.0, q, 1.0, frozen / q**0.25)
                errors.append(found / hertz_coefficient(1.0, q, 1.0) - 1.0)
        else:
            history = _history(0.1, 200)
            cost = seconds_each(lambda history=history, state=state: follow(*history, state.projects), 200 * STEPS)
            errors = [_differential_error(ratio, state.projects) if ratio < 1.0 else math.nan for ratio in ratios]
        points += [LawPoint(name, float(r), float(e), 1e9 * cost) for r, e in zip(ratios, errors, strict=True)]
    return points


def write_table(points: list[LawPoint], path: Path) -> None:
    """The points as comma-separated values."""
    header = ["law", "axis_ratio", "relative_error", "nanoseconds", "failed"]
    write_rows(path, header, ([p.law, p.axis_ratio, p.error, p.nanoseconds, p.failed] for p in points))


def worst(points: list[LawPoint], law: str, low: float, high: float = 1.0) -> float:
    """The greatest error of a law for b/a in [low, high]; infinite where it gives no number."""
    errors = [abs(p.error) for p in points if p.law == law and low <= p.axis_ratio <= high]
    return max((error if error < math.inf else math.inf for error in errors), default=math.nan)


def reading(points: list[LawPoint]) -> list[str]:
    """What the chart says, a sentence a law."""
    sentences = []
    for law in dict.fromkeys(p.law for p in points):
        mine = [p for p in points if p.law == law]
        crosses = [p.axis_ratio for p in mine if p.failed]
        near = worst(points, law, *BEARING)
        fails = ""
        if crosses:
            fails = f"; fails at {len(crosses)} of {len(mine)} shapes, b/a {min(crosses):.2g} to {max(crosses):.2g}"
        sentences.append(
            f"{law}: {mine[0].nanoseconds:.3g} ns an evaluation, at most {near:.2g} off on a ball in a raceway "
            f"(b/a {BEARING[0]:g} to {BEARING[1]:g}), {worst(points, law, 0.1, 0.99):.2g} from 0.1 to 0.99"
            f"{fails}."
        )
    return sentences


def draw(points: list[LawPoint], path: Path) -> None:
    """The chart: error over b/a on the left, error on a raceway against cost on the right."""
    figure = Figure(figsize=(15, 7.5), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, width_ratios=(1.5, 1.0), sharey=True)
    named: dict[tuple, int] = {}  # how many names stand at a place, by decades in error and quarters of one in cost
    for number, law in enumerate(dict.fromkeys(p.law for p in points)):
        look = ball_line(number)
        mine = [p for p in points if p.law == law]
        shape = [p.axis_ratio for p in mine]
        error = [math.nan if p.failed else max(abs(p.error), LEAST) for p in mine]
        left.plot(shape, error, **look, linewidth=2.0, label=law)
        crosses = [p.axis_ratio for p in mine if p.failed]
        left.plot(crosses, [2.0 * 1.8**number] * len(crosses), "x", color=look["color"], markersize=6)
        near = max(worst(points, law, *BEARING), LEAST)
        right.plot(
            mine[0].nanoseconds, min(near, 1.0), "x" if near > FAILED else "o", color=look["color"], markersize=10
        )
        spot = round(4.0 * math.log10(mine[0].nanoseconds)), round(math.log10(min(near, 1.0)))
        below = named[spot] = named.get(spot, -1) + 1
        place = 9, -4 - 16 * below
        right.annotate(law, (mine[0].nanoseconds, min(near, 1.0)), xytext=place, textcoords="offset points")
    left.axvspan(*BEARING, color=STYLE["ring"], alpha=0.7, zorder=0.5)
    left.axhline(1.0, color=STYLE["soft"], linewidth=1.0)
    left.set(xscale="log", yscale="log", ylim=(0.4 * LEAST, 100.0), xlabel="b/a of the contact ellipse")
    left.set_ylabel("|error| of the load against exact Hertz (above 1: crosses, failed)")
    right.set(xscale="log", xlabel="nanoseconds an evaluation, one core")
    right.margins(x=0.35)
    heading(left, f"Over the shape (shaded: ball in a raceway; constant, linear: frozen at {FROZEN_AT:g})")
    heading(right, "On a ball in a raceway, against cost")
    for axis in (left, right):
        frame(axis)
    left.legend(loc="lower left", frameon=False, bbox_to_anchor=(0.0, 0.12))
    figure.suptitle("Elastic laws: accuracy against cost", fontsize=16, color=STYLE["ink"])
    stamp(figure)
    figure.savefig(path, dpi=100)
