"""Friction over a spot that slides and spins: error of force and drilling torque, and nanoseconds an evaluation.

Coulomb friction without smoothing, the hardest case, against `reference.spot`. Each error is the worst of seven
directions of slip, and where a form is furthest off is looked for; of the force as a share of mu N, of the torque as a
share of that of pure spin. A cross along the upper edge where a form fails (more than 10 % off).
"""

import functools
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scipy.optimize import minimize

from bearing_twin.charts.laws import seconds_each
from bearing_twin.charts.table import write_rows
from bearing_twin.compiled import kernel
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.pictures.style import STYLE, ball_line, frame, heading, stamp
from bearing_twin.reference.spot import spot_friction_exact

FAILED = 0.1
LEAST = 1e-6  # smaller errors are drawn here
SHAPES = (1.0, 0.3, 0.1)  # b/a: a circle, and two ellipses of which the last is a ball in a raceway
SPINS = np.geomspace(0.01, 100.0, 41)  # spin times major semi-axis over slip
DIRECTIONS = np.linspace(0.0, 0.5 * math.pi, 7)
POLES = (np.linspace(0.03, 1.1, 36), np.linspace(0.0, 0.5 * math.pi, 13))
"""Where motions have their poles among which the greatest error is looked for: distance and angle, the spot scaled to
a unit circle."""
RAYS = 250  # of the exact solution, good to 1e-12 with them for b/a >= 0.1
EVALUATIONS = 2000


def _loop(form):
    """A loop over many evaluations of one form, for timing."""

    @kernel
    def evaluate(spins):
        total = 0.0
        for k in range(len(spins)):
            total += form(1.0, 1.0, 0.1, 0.6, 0.8, spins[k], 1.0, 1e-9).torque
        return total

    return evaluate


CONTESTANTS = {row.name: row.rubbing for row in FRICTIONS.values() if row.over_spot}


@dataclass(frozen=True)
class FrictionPoint:
    """One form at one shape and one ratio of spin to slip: errors of force and torque, and ns an evaluation."""

    form: str
    axis_ratio: float
    spin_over_slip: float
    force_error: float
    torque_error: float
    nanoseconds: float

    @property
    def failed(self) -> bool:
        """Whether this point is a cross."""
        return not max(self.force_error, self.torque_error) < FAILED


POINT = FrictionPoint


@functools.lru_cache(maxsize=4096)
def _exact(shape: float, along: float, across: float, spin: float):
    """The exact friction at one motion, kept: every form is measured at the same ones."""
    return spot_friction_exact(1.0, 1.0, shape, along, across, spin, 1.0, rays=RAYS)


def errors(form, shape: float, motions) -> np.ndarray:
    """Errors (n, 2) of force, of mu N, and torque, of pure spin's, at motions (slip along both axes, spin), b/a."""
    pure = abs(_exact(shape, 0.0, 0.0, 1.0).torque)
    exact = [_exact(shape, *motion) for motion in motions]
    off = np.array([form(1.0, 1.0, shape, *motion, 1.0, 1e-12) for motion in motions]) - exact
    return np.stack([np.hypot(off[:, 0], off[:, 1]), np.abs(off[:, 2]) / pure], axis=1)


def _of_pole(shape: float, distance: float, angle: float) -> tuple[float, float, float]:
    """The motion of unit slip about a pole: slip along both axes, spin."""
    slip = shape * distance * math.sin(angle), -distance * math.cos(angle)
    size = math.hypot(*slip)
    return slip[0] / size, slip[1] / size, 1.0 / size


def hardest(form, shape: float, poles=POLES) -> list[tuple[tuple[float, float, float], float]]:
    """Where a form is furthest off in force, and in torque, at b/a = `shape`: the motion and its error.

    A search over all motions: from the two worst of a grid of `poles` downhill. A quadrature is worst where the pole
    lies on one of its rings.
    """
    grid = [(distance, angle) for distance in poles[0] for angle in poles[1]]
    known = errors(form, shape, [_of_pole(shape, *pole) for pole in grid])
    found = []
    for part in (0, 1):
        starts = [grid[place] for place in np.argsort(known[:, part])[-2:]]
        ends = [
            minimize(
                lambda pole, part=part: -errors(form, shape, [_of_pole(shape, *pole)])[0, part],
                start,
                method="Nelder-Mead",
                options={"maxfev": 30, "initial_simplex": np.add(start, [(0.0, 0.0), (0.02, 0.0), (0.0, 0.04)])},
            )
            for start in starts
        ]
        best = min(ends, key=lambda end: end.fun)
        found.append((_of_pole(shape, *best.x), -float(best.fun)))
    return found


def measure(shapes=SHAPES, spins=SPINS, poles=POLES) -> list[FrictionPoint]:
    """Every contestant at every shape b/a: at every ratio a omega/v, and where it is furthest off."""
    many = np.geomspace(0.1, 10.0, EVALUATIONS)
    loops = {name: _loop(form) for name, form in CONTESTANTS.items()}
    cost = {name: seconds_each(lambda loop=loop: loop(many), EVALUATIONS) for name, loop in loops.items()}
    points = []
    for shape in shapes:
        for name, form in CONTESTANTS.items():
            worst_motions = [motion for motion, _ in hardest(form, shape, poles)]
            for spin in sorted({*spins, *(motion[2] for motion in worst_motions)}):
                motions = [(math.cos(angle), math.sin(angle), spin) for angle in DIRECTIONS]
                motions += [motion for motion in worst_motions if motion[2] == spin]
                force, torque = errors(form, shape, motions).max(axis=0)
                points.append(FrictionPoint(name, shape, float(spin), float(force), float(torque), 1e9 * cost[name]))
    return points


def write_table(points: list[FrictionPoint], path: Path) -> None:
    """The points as comma-separated values."""
    header = ["form", "axis_ratio", "spin_over_slip", "force_error", "torque_error", "nanoseconds", "failed"]
    write_rows(path, header, ([*vars(p).values(), p.failed] for p in points))


def worst(points: list[FrictionPoint], form: str, shape: float) -> tuple[float, float]:
    """The greatest errors of force and torque of a form at one b/a."""
    mine = [p for p in points if p.form == form and p.axis_ratio == shape]
    return max(p.force_error for p in mine), max(p.torque_error for p in mine)


def reading(points: list[FrictionPoint]) -> list[str]:
    """What the chart says, a sentence a form."""
    sentences = []
    for form in dict.fromkeys(p.form for p in points):
        mine = [p for p in points if p.form == form]
        shapes = sorted({p.axis_ratio for p in mine}, reverse=True)
        told = (
            f"{force:.2g} and {torque:.2g} at b/a {s:g}" for s in shapes for force, torque in [worst(mine, form, s)]
        )
        crosses = sum(p.failed for p in mine)
        fails = f"; fails at {crosses} of {len(mine)} points" if crosses else ""
        sentences.append(
            f"{form}: {mine[0].nanoseconds:.3g} ns an evaluation; force and torque off by at most "
            f"{', '.join(told)}{fails}."
        )
    return sentences


def _panel(axis, points, error, shape):
    for number, form in enumerate(CONTESTANTS):
        mine = [p for p in points if p.form == form and p.axis_ratio == shape]
        spins, errors = [p.spin_over_slip for p in mine], np.array([getattr(p, error) for p in mine])
        drawn = np.where(errors < FAILED, np.maximum(errors, LEAST), math.nan)
        axis.plot(spins, drawn, **ball_line(number), linewidth=2.0, label=form)
        crosses = [spin for spin, one in zip(spins, errors, strict=True) if not one < FAILED]
        axis.plot(crosses, [0.3 * 2.2**number] * len(crosses), "x", color=ball_line(number)["color"], markersize=6)
    axis.axhline(FAILED, color=STYLE["soft"], linewidth=1.0)
    axis.set(xscale="log", yscale="log", ylim=(0.5 * LEAST, 10.0))
    frame(axis)


def draw(points: list[FrictionPoint], path: Path) -> None:
    """The chart: force error above, torque error below, one column a shape, and on the right error against cost."""
    figure = Figure(figsize=(17, 9), layout="constrained")
    FigureCanvasAgg(figure)
    shapes = sorted({p.axis_ratio for p in points}, reverse=True)
    count = len(shapes)
    panels = figure.subplots(2, count + 1, sharey=True, squeeze=False)
    for row, (error, word) in enumerate(
        (("force_error", "force over mu N"), ("torque_error", "torque over pure spin's"))
    ):
        for column, shape in enumerate(shapes):
            _panel(panels[row, column], points, error, shape)
            heading(panels[row, column], f"b/a = {shape:g}")
        panels[row, 0].set_ylabel(f"error of {word}; crosses: failed")
        last = panels[row, count]
        for number, form in enumerate(CONTESTANTS):
            cost = next(p.nanoseconds for p in points if p.form == form)
            most = max(worst(points, form, shape)[row] for shape in shapes)
            last.plot(cost, most, "x" if most > FAILED else "o", color=ball_line(number)["color"], markersize=10)
        last.axhline(FAILED, color=STYLE["soft"], linewidth=1.0)
        last.set(xscale="log")
        last.margins(x=0.25)
        heading(last, "worst of all, against cost")
        frame(last)
    for column in range(count):
        panels[1, column].set_xlabel("spin x major semi-axis / slip")
    panels[1, count].set_xlabel("nanoseconds an evaluation, one core")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    panels[0, count].legend(handles, labels, loc="lower left", frameon=False, fontsize=11)
    figure.suptitle("Friction over a spot that slides and spins", fontsize=16, color=STYLE["ink"])
    stamp(figure)
    figure.savefig(path, dpi=100)
