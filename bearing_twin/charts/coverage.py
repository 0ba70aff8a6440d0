"""How often the 95 % intervals of statistics hold the truth, by sampler, statistic and number of samples.

The quantity is a sum of one or four equal inputs whose distribution is known: a gamma variable, also as the sum of
four, and a lognormal one with heavy tails. Every cell is SEEDS studies; the coverage of right intervals then scatters
by 1.3 %, and some of 189 cells fall short by chance. A cell that does is measured again by CLOSER times as many
other seeds.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy import stats

from bearing_twin.charts.sheets import Axis, Line, Panel, Sheet
from bearing_twin.charts.sheets import draw as draw_sheet
from bearing_twin.charts.study_samples import colour
from bearing_twin.errors import StatisticError
from bearing_twin.pictures.style import STYLE
from bearing_twin.uq.sampling import SAMPLERS, UnitPoints
from bearing_twin.uq.statistics import estimate


class KnownQuantity(NamedTuple):
    """A quantity: the sum of `inputs` values of the frozen SciPy distribution `each`, distributed as `whole`."""

    title: str
    inputs: int
    each: stats.distributions.rv_frozen
    whole: stats.distributions.rv_frozen


SHAPE = (1.138 / 0.6) ** 2  # of alpha in paper 3's widest study
PROBLEMS = {
    "gamma": KnownQuantity("gamma, deviation 0.53", 1, stats.gamma(SHAPE), stats.gamma(SHAPE)),
    "sum": KnownQuantity("the same as a sum of four", 4, stats.gamma(SHAPE / 4.0), stats.gamma(SHAPE)),
    "lognormal": KnownQuantity("lognormal, deviation 1.3", 1, stats.lognorm(1.0), stats.lognorm(1.0)),
}
STATISTICS = ("mean", "std", "skewness", 0.05, 0.5, 0.95, 0.99)
SIZES = (128, 1024, 8192)
SEEDS = 300
CLOSER = 8  # a coverage then scatters by 0.4 %
LEAST = 0.93  # what intervals that are not marked should cover
MARKED = 0.95  # of the studies of a kind whose intervals cover less


@dataclass(frozen=True)
class Point:
    """Shares of the studies whose interval held the truth, whose interval was marked unsafe, and either; 0 to 1."""

    problem: str
    sampler: str
    statistic: str
    samples: int
    covered: float
    unsafe: float
    either: float
    basis: str
    seeds: int


POINT = Point


def measure(
    problems: tuple[str, ...] = tuple(PROBLEMS),
    samplers: tuple[str, ...] = tuple(SAMPLERS),
    sizes: tuple[int, ...] = SIZES,
    seeds: int = SEEDS,
    say: Callable[[str], None] = lambda text: None,
) -> Iterator[Point]:
    """Every cell of the table."""
    for name in problems:
        problem = PROBLEMS[name]
        moments = dict(zip(("mean", "var", "skewness"), map(float, problem.whole.stats("mvs")), strict=True))
        truth = {**moments, "std": moments["var"] ** 0.5, **{p: problem.whole.ppf(p) for p in STATISTICS[3:]}}
        for sampler in samplers:
            for size in sizes:
                say(f"{name}, {sampler}, {size} samples")
                points = list(_cells(name, sampler, size, range(1, seeds + 1), truth, STATISTICS))
                short = {p.statistic for p in too_narrow(points)}
                if short:
                    many = CLOSER * seeds
                    say(f"{name}, {sampler}, {size} samples: {', '.join(sorted(short))} by {many} seeds")
                    statistics = tuple(one for one in STATISTICS if str(one) in short)
                    others = range(seeds + 1, seeds + 1 + many)
                    again = {p.statistic: p for p in _cells(name, sampler, size, others, truth, statistics)}
                    points = [again.get(p.statistic, p) for p in points]
                yield from points


def _cells(name, sampler, size, seeds, truth, statistics):
    problem, found = PROBLEMS[name], {statistic: [] for statistic in statistics}
    for seed in seeds:
        points = UnitPoints(sampler, problem.inputs, seed, size)
        sample = problem.each.ppf(points.chunk(0, points.samples)).sum(axis=1)
        for statistic, rows in found.items():
            try:
                one = estimate(sample, statistic, replicates=points.replicates)
            except StatisticError:
                continue
            rows.append((one.low <= truth[statistic] <= one.high, not one.safe, one.basis))
    for statistic, rows in found.items():
        if rows:
            covered, unsafe, bases = zip(*rows, strict=True)
            either = np.logical_or(covered, unsafe)
            shares = (float(np.mean(one)) for one in (covered, unsafe, either))
            yield Point(name, sampler, str(statistic), size, *shares, bases[0], len(seeds))


def draw(points: list[Point], path: Path) -> None:
    """One panel for each sampler and problem; crosses where most intervals are marked unsafe."""
    rows = []
    for name in dict.fromkeys(p.problem for p in points):
        row = []
        for sampler in dict.fromkeys(p.sampler for p in points if p.problem == name):
            mine = [p for p in points if (p.problem, p.sampler) == (name, sampler)]
            title = f"{sampler.replace('_', ' ')}: {PROBLEMS[name].title}"
            parts = [part for place, one in enumerate(map(str, STATISTICS)) for part in _curve(mine, one, place)]
            reach = [min(p.samples for p in mine), max(p.samples for p in mine)]
            parts.append(Line("95 %", reach, [0.95, 0.95], {"color": STYLE["soft"], "linestyle": ":"}, False))
            up = Axis("share that holds the truth", "1", limits=(0.55, 1.02))
            row.append(
                Panel(
                    f"{name}, {sampler}",
                    title,
                    Axis("samples", "1", log=True),
                    up,
                    parts,
                    None if row or rows else "lower right",
                )
            )
        rows.append(row)
    text = f"{SEEDS} seeds a point, {CLOSER * SEEDS} where these fell short; "
    text += "crosses: marked unsafe by most of them"
    draw_sheet(Sheet("How often 95 % intervals hold the truth", rows, text, []), path)


def _curve(points, statistic, place):
    mine = [p for p in points if p.statistic == statistic]
    name = f"{statistic} quantile" if statistic[0].isdigit() else statistic
    yield Line(name, [p.samples for p in mine], [p.covered for p in mine], {**colour(place), "marker": "o"})
    marked = [p for p in mine if p.unsafe > 0.5]
    look = {**colour(place), "linestyle": "", "marker": "x", "markersize": 14}
    yield Line(f"{name}, unsafe", [p.samples for p in marked], [p.covered for p in marked], look, False)


def reading(points: list[Point]) -> Iterator[str]:
    """The least coverage of each sampler, of all intervals and of those that are not marked; what covers too little."""
    for sampler in dict.fromkeys(p.sampler for p in points):
        mine = [p for p in points if p.sampler == sampler]
        worst, either = min(mine, key=lambda p: p.covered), min(mine, key=lambda p: p.either)
        yield (
            f"{sampler.replace('_', ' ')}: the worst interval holds the truth in {100.0 * worst.covered:.0f} % "
            f"({worst.statistic} of {worst.problem}, {worst.samples} samples), and is marked unsafe in "
            f"{100.0 * worst.unsafe:.0f} %; held or marked are {100.0 * either.either:.0f} % at least "
            f"({either.statistic} of {either.problem}, {either.samples} samples)."
        )
    few, unmarked = [p for p in points if p.covered < LEAST], too_narrow(points)
    said = len(few) - len(unmarked)
    yield (
        f"{len(few)} of {len(points)} cells hold the truth in less than {100.0 * LEAST:.0f} %; {said} of them are "
        f"marked unsafe in {100.0 * MARKED:.0f} % of the studies or more, the others hold it in "
        f"{100.0 * min((p.covered for p in unmarked), default=1.0):.1f} % at least."
    )


def too_narrow(points: list[Point]) -> list[Point]:
    """Those whose intervals hold the truth in less than LEAST of the studies, and that not MARKED of these say."""
    return [p for p in points if p.covered < LEAST and p.unsafe < MARKED]
