"""Friction over a spot that slides and spins: error of force and drilling torque, and nanoseconds an evaluation.

Coulomb friction without smoothing, the hardest case, against `reference.spot`, checked by SciPy's adaptive quadrature.
Each error is the worst of seven directions of slip, and where a form is furthest off is looked for; of the force as a
share of mu N, of the torque as a share of that of pure spin. A cross along the upper edge where a form fails (more than
10 % off). `setting` is the spin times the major semi-axis over the slip. With smoothing, where it is over the
regularising speed, the worst of all motions: the table that `kinds.bearing.spot_errors` reads.
"""

import functools
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.integrate import dblquad
from scipy.optimize import minimize

from bearing_twin.charts.chart import Chart
from bearing_twin.charts.contest import limited
from bearing_twin.charts.friction_smoothed import SHAPES as SMOOTHED_SHAPES
from bearing_twin.charts.friction_smoothed import SHARES, greatest, told_smoothed
from bearing_twin.charts.laws import seconds_each
from bearing_twin.charts.table import DONE, FAILED, Row
from bearing_twin.charts.timing import Timing
from bearing_twin.compiled import kernel
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.kinds.bearing.spot_errors import SMOOTHED as SMOOTHED_WORD
from bearing_twin.kinds.bearing.spot_errors import smoothed_name
from bearing_twin.pictures.style import STYLE, ball_line, frame, heading, save_chart
from bearing_twin.reference.spot import spot_friction_exact

WORST = 0.1  # an error beyond this is a cross
LEAST = 1e-6  # smaller errors are drawn here
SHAPES = (1.0, 0.3, 0.1)  # b/a: a circle, and two ellipses of which the last is a ball in a raceway
PROBLEMS = {f"b/a = {shape:g}": shape for shape in SHAPES}
SMOOTHED = {smoothed_name(shape): shape for shape in SMOOTHED_SHAPES}
SPINS = np.geomspace(0.01, 100.0, 41)  # spin times major semi-axis over slip
DIRECTIONS = np.linspace(0.0, 0.5 * math.pi, 7)
POLES = (np.linspace(0.03, 1.1, 36), np.linspace(0.0, 0.5 * math.pi, 13))
"""Where motions have their poles among which the greatest error is looked for: distance and angle, the spot scaled to
a unit circle."""
RAYS, NARROW = 250, 25.0  # of the exact solution, good to 1e-12; for b/a < 0.1 NARROW over b/a
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


SCIPY, UNTIMED = "SciPy", Timing(math.nan, math.nan)  # the second reference
SECOND, EACH = 1e-7, 10  # accuracy that it is asked for, and every how many of SPINS it takes
CONTESTANTS = {row.name: row.rubbing for row in FRICTIONS.values() if row.over_spot}


@dataclass(frozen=True)
class FrictionRow(Row):
    """One form at one shape and one ratio of spin to slip: `friction_error` is the greater of these two."""

    force_error: float = math.nan
    torque_error: float = math.nan


@functools.lru_cache(maxsize=4096)
def _exact(shape: float, along: float, across: float, spin: float):
    """The exact friction at one motion, kept: every form is measured at the same ones."""
    return spot_friction_exact(1.0, 1.0, shape, along, across, spin, 1.0, rays=max(RAYS, round(NARROW / shape)))


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


def by_scipy(normal_load, major, minor, slip_major, slip_minor, spin, coefficient, _) -> tuple[float, float, float]:
    """Force along both axes [N] and torque [N m] of Coulomb friction over the spot, by `dblquad`, cut at the pole."""
    scale = -1.5 * coefficient * normal_load / math.pi
    pole = -slip_minor / (spin * major), slip_major / (spin * minor)

    def at(y, x, part):
        along, across = slip_major - spin * minor * y, slip_minor + spin * major * x
        speed = math.hypot(along, across)
        pressure = math.sqrt(max(1.0 - x * x - y * y, 0.0))
        if speed == 0.0:
            return 0.0
        return pressure * (along, across, major * x * across - minor * y * along)[part] / speed

    def over(low, high, part):
        below, above = (
            dblquad(at, low, high, start, end, (part,), epsabs=SECOND, epsrel=SECOND)[0]
            for start, end in ((_rim(-1.0), cut), (cut, _rim(1.0)))
        )
        return below + above

    def cut(x):
        edge = math.sqrt(max(1.0 - x * x, 0.0))
        return min(max(pole[1], -edge), edge)

    middle = min(max(pole[0], -1.0), 1.0)
    return tuple(scale * (over(-1.0, middle, part) + over(middle, 1.0, part)) for part in range(3))


def _rim(side):
    return lambda x: side * math.sqrt(max(1.0 - x * x, 0.0))


def judge(name: str, form: str, setting: float, limit: float) -> list[FrictionRow]:
    """A form at one shape b/a: at every ratio a omega/v, and where it is furthest off. `setting` is not used."""
    shape = PROBLEMS.get(name) or SMOOTHED[name]
    with limited(limit):
        if name in SMOOTHED:
            return _smoothed(name, form, shape)
        if form == SCIPY:
            return [
                _row(name, form, spin, errors(by_scipy, shape, [_slip(0.7, spin)]), UNTIMED) for spin in SPINS[::EACH]
            ]
        many, loop = np.geomspace(0.1, 10.0, EVALUATIONS), _loop(CONTESTANTS[form])
        cost = seconds_each(lambda: loop(many), EVALUATIONS)
        worst_motions = [motion for motion, _ in hardest(CONTESTANTS[form], shape, POLES)]
        rows = []
        for spin in sorted({*map(float, SPINS), *(motion[2] for motion in worst_motions)}):
            motions = [_slip(angle, spin) for angle in DIRECTIONS]
            motions += [motion for motion in worst_motions if motion[2] == spin]
            rows.append(_row(name, form, spin, errors(CONTESTANTS[form], shape, motions), cost))
        return rows


def _smoothed(name: str, form: str, shape: float) -> list[FrictionRow]:
    """The greatest errors of a form at one shape b/a: at every ratio of a omega to the regularisation, and without."""
    pure, rubbing = abs(_exact(shape, 0.0, 0.0, 1.0).torque), CONTESTANTS[form]
    rows = []
    for share in SHARES:
        found = greatest(rubbing, shape, share, pure) if share < math.inf else [e for _, e in hardest(rubbing, shape)]
        rows.append(_row(name, form, share, np.array([found]), UNTIMED))
    return rows


def _slip(angle, spin):
    return math.cos(angle), math.sin(angle), spin


def _row(name, form, spin, off, cost) -> FrictionRow:
    """The worst of the errors (n, 2)."""
    force, torque = map(float, off.max(axis=0))
    good = max(force, torque) < WORST
    return FrictionRow(
        name,
        form,
        float(spin),
        friction_error=max(force, torque),
        **cost._asdict(),
        evaluations=1,
        status=DONE if good else FAILED,
        reason="" if good else f"more than {100.0 * WORST:g} % off",
        force_error=force,
        torque_error=torque,
    )


def worst(rows: list[FrictionRow], form: str, problem: str) -> tuple[float, float]:
    """The greatest errors of force and torque of a form at one b/a; infinite where nothing came out."""
    mine = [row for row in rows if (row.method, row.problem) == (form, problem) and not math.isnan(row.force_error)]
    columns = ([row.force_error for row in mine], [row.torque_error for row in mine])
    return tuple(max(column, default=math.inf) for column in columns)


def reading(rows: list[FrictionRow]) -> list[str]:
    """What the chart says, a sentence a form, and one on the reference."""
    sentences = []
    shapes = [name for name in PROBLEMS if any(row.problem == name for row in rows)]
    smoothed = [one for form in CONTESTANTS if (one := told_smoothed(rows, form))]
    rows = [row for row in rows if row.problem in PROBLEMS]
    for form in (form for form in CONTESTANTS if any(row.method == form for row in rows)):
        mine = [row for row in rows if row.method == form]
        if not any(worst(mine, form, s)[0] < math.inf for s in shapes):
            continue
        told = (f"{force:.2g} and {torque:.2g} at {s}" for s in shapes for force, torque in [worst(mine, form, s)])
        crosses = sum(row.status != DONE for row in mine)
        fails = f"; fails at {crosses} of {len(mine)} points" if crosses else ""
        sentences.append(
            f"{form}: {1e9 * mine[0].seconds:.3g} ns an evaluation; force and torque off by at most "
            f"{', '.join(told)}{fails}."
        )
    sentences += smoothed
    again = [row.friction_error for row in rows if row.method == SCIPY and row.status == DONE]
    if again:
        sentences.append(
            f"The exact solution is found again by SciPy's dblquad, asked for {SECOND:g}, to {max(again):.1g} at all "
            f"{len(again)} motions tried."
        )
    return sentences


def _panel(axis, rows, error, shape):
    for number, form in enumerate(CONTESTANTS):
        mine = [row for row in rows if (row.method, row.problem) == (form, shape)]
        spins, off = [row.setting for row in mine], np.array([getattr(row, error) for row in mine])
        drawn = np.where(off < WORST, np.maximum(off, LEAST), math.nan)
        axis.plot(spins, drawn, **ball_line(number), linewidth=2.0, label=form)
        crosses = [spin for spin, one in zip(spins, off, strict=True) if not one < WORST]
        axis.plot(crosses, [0.3 * 2.2**number] * len(crosses), "x", color=ball_line(number)["color"], markersize=6)
    axis.axhline(WORST, color=STYLE["soft"], linewidth=1.0)
    axis.set(xscale="log", yscale="log", xlim=(0.6 * SPINS[0], 1.6 * SPINS[-1]), ylim=(0.5 * LEAST, 10.0))
    frame(axis)


def draw(rows: list[FrictionRow], path: Path) -> None:
    """The chart: errors of force, of torque, and with smoothing, one column a shape; right, error against cost."""
    figure = Figure(figsize=(17, 13), layout="constrained")
    shapes = [name for name in PROBLEMS if any(row.problem == name for row in rows)]
    count = len(shapes)
    panels = figure.subplots(3, count + 1, sharey=True, squeeze=False)
    for line, (error, word) in enumerate(
        (("force_error", "force over mu N"), ("torque_error", "torque over pure spin's"))
    ):
        for column, shape in enumerate(shapes):
            _panel(panels[line, column], rows, error, shape)
            heading(panels[line, column], shape)
        panels[line, 0].set_ylabel(f"error of {word}; crosses: failed")
        last = panels[line, count]
        for number, form in enumerate(CONTESTANTS):
            cost = 1e9 * next((row.seconds for row in rows if row.method == form), math.nan)
            most = min(max(worst(rows, form, shape)[line] for shape in shapes), 1.0)
            last.plot(cost, most, "x" if most > WORST else "o", color=ball_line(number)["color"], markersize=10)
        last.axhline(WORST, color=STYLE["soft"], linewidth=1.0)
        last.set(xscale="log")
        last.margins(x=0.25)
        heading(last, "worst of all, against cost")
        frame(last)
    for column in range(count):
        panels[1, column].set_xlabel("spin x major semi-axis / slip")
        _panel(panels[2, column], rows, "friction_error", f"{shapes[column]}{SMOOTHED_WORD}")
        panels[2, column].set_xlabel("spin x major semi-axis / regularising speed")
    panels[2, 0].set_ylabel("the greater error, smoothed, of all motions")
    panels[2, count].set_axis_off()
    panels[1, count].set_xlabel("nanoseconds an evaluation, one core")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    panels[0, count].legend(handles, labels, loc="lower left", frameon=False, fontsize=11)
    save_chart(figure, "Friction over a spot that slides and spins", path)


CONTESTS = {
    "friction": Chart(
        judge=judge,
        problems={name: name for name in (*PROBLEMS, *SMOOTHED)},
        entries=lambda name: ((form, math.nan) for form in (*CONTESTANTS, *((SCIPY,) if name in PROBLEMS else ()))),
        kind=FrictionRow,
        drawn=draw,
        told=reading,
    )
}
