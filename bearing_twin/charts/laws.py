"""The elastic laws against each other: error of the load over the ellipse's shape, and nanoseconds an evaluation.

Error is against exact Hertz; one line a law, a cross along the upper edge where a law fails (more than 10 % off, or no
number). Laws with states carry them over swings of the shape, each 16 Runge-Kutta steps long. The reference is checked
by SciPy: Carlson's integrals, and Brent's method on the equation of the ellipse. `setting` is b/a.
"""

import functools
import math
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import brentq
from scipy.special import elliprd, elliprf

from bearing_twin.charts.chart import Chart
from bearing_twin.charts.contest import limited
from bearing_twin.charts.contest_picture import ring
from bearing_twin.charts.table import DONE, FAILED, STOPPED, Row
from bearing_twin.charts.timing import Timing, timed
from bearing_twin.compiled import kernel
from bearing_twin.contact.calculator import COMPARED
from bearing_twin.contact.differential import Shape, differential_coefficient, follow
from bearing_twin.contact.elasticity import NO_SHAPE, coefficient_at, coefficient_of, elasticity
from bearing_twin.contact.ellipse import curvature_ratio, hertz_coefficient
from bearing_twin.contact.laws import LAWS
from bearing_twin.pictures.style import STYLE, ball_line, frame, heading, save_chart

LEAST = 1e-12  # smaller errors are drawn here
WORST = 0.1  # an error beyond this is a cross
FROZEN_AT = 0.1  # b/a at which laws that do not follow the curvatures are exact: a ball in a raceway
RAILS = np.geomspace(1e-3, 1.0, 49)  # b/a
BEARING = (0.08, 0.18)  # b/a of steel balls in raceways
SWING, STEPS = 40, 16  # turns and steps a turn of the differential forms
EVALUATIONS, FEW = 20_000, 100  # FEW: of those in Python


SCIPY = "SciPy"  # the second reference
CONTESTANTS = (*COMPARED, SCIPY)
PROBLEM = "ellipse"


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


def seconds_each(work, count) -> Timing:
    """CPU time of one of the `count` evaluations in `work`, compiled before."""
    cost = timed(work)[1]
    return cost._replace(seconds=cost.seconds / count)


def by_scipy(small: float, large: float, modulus: float) -> float:
    """Exact Hertz's coefficient [N/m^1.5] of a gap P x^2 + Q y^2 [1/m] and a modulus [Pa], by SciPy alone."""

    def off(logarithm):
        square = math.exp(2.0 * logarithm)
        return math.log(elliprd(0.0, 1.0, square) / elliprd(0.0, square, 1.0) * small / large)

    square = math.exp(2.0 * brentq(off, -16.0, 1e-9, xtol=1e-15, rtol=1e-14))
    whole, across = elliprf(0.0, square, 1.0), elliprd(0.0, square, 1.0) / 3.0
    return 2.0 * math.pi / 3.0 * modulus * math.sqrt(across / (small * whole)) / whole


@functools.cache
def _place():
    """The coefficient frozen at FROZEN_AT, and the curvatures at which costs are measured."""
    frozen = hertz_coefficient(1.0, curvature_ratio(FROZEN_AT), 1.0) * curvature_ratio(FROZEN_AT) ** 0.25
    return frozen, np.array([curvature_ratio(ratio) for ratio in np.geomspace(*BEARING, EVALUATIONS)])


def _cost(name: str) -> Timing:
    """Seconds an evaluation."""
    _, large = _place()
    if name == SCIPY:
        few = large[:: len(large) // FEW]
        return seconds_each(lambda: [by_scipy(1.0, one, 1.0) for one in few], len(few))
    state = LAWS[name].state
    if state is None:
        law = elasticity(name, 1.0, 1.0)
        return seconds_each(lambda: _evaluate(law, large), EVALUATIONS)
    history = _history(0.1, 200)
    return seconds_each(lambda: follow(*history, state.projects), 200 * STEPS)


def _error(name: str, ratio: float) -> float:
    """The relative error of a law's load at b/a = `ratio`; NaN where it gives none."""
    if name != SCIPY and LAWS[name].state is not None:
        return _differential_error(ratio, LAWS[name].state.projects) if ratio < 1.0 else math.nan
    q = curvature_ratio(ratio)
    # bodies of equal sqrt(PQ), an approach of 1 m: what such a law does not see is the shape
    found = by_scipy(1.0, q, 1.0) if name == SCIPY else coefficient_of(name, 1.0, q, 1.0, _place()[0] / q**0.25)
    return abs(found / hertz_coefficient(1.0, q, 1.0) - 1.0)


def judge(name: str, law: str, setting: float, limit: float) -> list[Row]:
    """A law at every b/a of RAILS; its cost is measured once. `setting` is not used."""
    rows = []
    with limited(limit):
        cost = _cost(law)
        for ratio in map(float, RAILS):
            error = abs(float(_error(law, ratio)))
            good = error < WORST
            reason = "" if good else "no number" if math.isnan(error) else f"more than {100.0 * WORST:g} % off"
            rows.append(
                Row(
                    name,
                    law,
                    ratio,
                    load_error=error,
                    **cost._asdict(),
                    evaluations=1,
                    status=DONE if good else FAILED,
                    reason=reason,
                    command=_command(law, ratio),
                )
            )
    return rows


def _command(law: str, ratio: float) -> str:
    """What puts the laws side by side at that shape; laws with states are carried elsewhere there."""
    if law == SCIPY or LAWS[law].state is not None:
        return ""
    large = f"--curvature-large {curvature_ratio(ratio):.9g}"
    return f"bearing_twin contact --curvature-small 1 {large} --approach 1e-6 --frozen-at {FROZEN_AT:g}"


def worst(rows: list[Row], law: str, low: float, high: float = 1.0) -> float:
    """The greatest error of a law for b/a in [low, high]; infinite where it gives no number."""
    errors = [row.load_error for row in rows if row.method == law and low <= row.setting <= high]
    return max((error if error < math.inf else math.inf for error in errors), default=math.nan)


def reading(rows: list[Row]) -> list[str]:
    """What the chart says, a sentence a law, and one on the reference."""
    sentences = []
    for law in dict.fromkeys(row.method for row in rows if row.method != SCIPY and row.status != STOPPED):
        mine = [row for row in rows if row.method == law]
        crosses = [row.setting for row in mine if row.status != DONE]
        near = worst(rows, law, *BEARING)
        fails = ""
        if crosses:
            fails = f"; fails at {len(crosses)} of {len(mine)} shapes, b/a {min(crosses):.2g} to {max(crosses):.2g}"
        sentences.append(
            f"{law}: {1e9 * mine[0].seconds:.3g} ns an evaluation, at most {near:.2g} off on a ball in a raceway "
            f"(b/a {BEARING[0]:g} to {BEARING[1]:g}), {worst(rows, law, 0.1, 0.99):.2g} from 0.1 to 0.99"
            f"{fails}."
        )
    again = [row for row in rows if row.method == SCIPY and row.status == DONE]
    if again:
        sentences.append(
            f"Exact Hertz is found again by SciPy (Carlson's integrals, Brent's method) to "
            f"{worst(rows, SCIPY, 0.0):.1g} at all {len(again)} shapes, in {1e9 * again[0].seconds:.2g} ns."
        )
    return sentences


def draw(rows: list[Row], path: Path) -> None:
    """The chart: error over b/a on the left, error on a raceway against cost on the right."""
    figure = Figure(figsize=(15, 7.5), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.5, 1.0), sharey=True)
    named: dict[tuple, int] = {}  # how many names stand at a place, by decades in error and quarters of one in cost
    for number, law in enumerate(dict.fromkeys(row.method for row in rows)):
        look = ball_line(number)
        mine = [row for row in rows if row.method == law]
        shape = [row.setting for row in mine]
        error = [max(row.load_error, LEAST) if row.status == DONE else math.nan for row in mine]
        left.plot(shape, error, **look, linewidth=2.0, label=law)
        crosses = [row.setting for row in mine if row.status != DONE]
        left.plot(crosses, [2.0 * 1.8**number] * len(crosses), "x", color=look["color"], markersize=6)
        near = worst(rows, law, *BEARING)
        near = 1.0 if math.isnan(near) else max(near, LEAST)
        cost = 1e9 * mine[0].seconds
        right.plot(cost, min(near, 1.0), "x" if near > WORST else "o", color=look["color"], markersize=10)
        ring(
            right,
            [row for row in mine if row.status == DONE][:1],
            lambda _, cost=cost, near=near: (cost, min(near, 1.0)),
            look["color"],
        )
        spot = round(4.0 * math.log10(cost)), round(math.log10(min(near, 1.0)))
        below = named[spot] = named.get(spot, -1) + 1
        place = 9, -4 - 16 * below
        right.annotate(law, (cost, min(near, 1.0)), xytext=place, textcoords="offset points")
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
    save_chart(figure, "Elastic laws: accuracy against cost", path)


CONTESTS = {
    "laws": Chart(
        judge=judge,
        problems={PROBLEM: "an ellipse of every shape"},
        entries=lambda name: ((law, math.nan) for law in CONTESTANTS),
        drawn=draw,
        told=reading,
    )
}
