"""Samplers and quadrature against each other: error of mean and deviation over realisations, and over seconds.

The contact time of paper 3's spheres is proportional to alpha, so its mean and deviation are known exactly. Random
methods run with several seeds: the line is the median error, the band the middle half of the seeds.
"""

import csv
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bearing_twin import __version__
from bearing_twin.charts.sheets import Axis, Band, Line, Panel, Sheet
from bearing_twin.charts.sheets import draw as draw_sheet
from bearing_twin.charts.study_samples import Known, colour, known, known_of
from bearing_twin.charts.style import BALL_COLOURS, STYLE
from bearing_twin.uq.chaos import GREATEST_DEGREE, VALIDATION, expand
from bearing_twin.uq.propagation import mean_inputs
from bearing_twin.uq.realise import realise
from bearing_twin.uq.sampling import SAMPLERS, UnitPoints

STUDY = "spheres_alpha_2e-5"
SEEDS, MANY, CHEAP = 9, 36, 2**15  # seeds of a size; MANY up to CHEAP realisations
LADDER = tuple(32 * 4**step for step in range(9))  # realisations; sizes that balance a Sobol design
MOST = {"random": LADDER[-1]}  # the others are not run beyond MOST_EVEN: they are long there
MOST_EVEN = 2**17
CHAOS, EXACT = "polynomial_chaos", "change_of_variable"
WANTED = 1e-4
LEAST = 1e-16  # smaller errors are drawn here
WANTED_LOOK = {"color": STYLE["soft"], "linewidth": 1.2, "linestyle": ":"}
STATISTICS = ("mean", "std")


class Point(NamedTuple):
    """A method at one size: median and quartiles over the seeds of the relative errors, median seconds of one core."""

    method: str
    realisations: int
    seconds: float
    mean_error: float
    mean_low: float
    mean_high: float
    std_error: float
    std_low: float
    std_high: float


def measure(
    update: Callable[[float], None] = lambda share: None, ladder: tuple[int, ...] = LADDER, seeds: int | None = None
) -> list[Point]:
    """Every sampler at every size of the ladder, polynomial chaos by degrees, and the change of variable.

    `seeds` is the number of seeds at every size, by default SEEDS, or MANY where it is cheap.
    """
    one = known(STUDY)
    source = one.study.inputs[0]
    mean = float(realise(one.task, mean_inputs(one.study)).quantities[0, 0])
    truth = np.array([mean, mean * source.std / source.mean])
    wanted = [(name, size) for name in SAMPLERS for size in ladder if size <= MOST.get(name, MOST_EVEN)]
    whole, done, points = sum(size for _, size in wanted), 0, []
    for name, size in wanted:
        count = seeds or (MANY if size <= CHEAP else SEEDS)
        points.append(_point(name, size, [_sampled(one, name, size, seed, truth) for seed in range(1, count + 1)]))
        done += size
        update(done / whole)
    for degree in range(1, GREATEST_DEGREE + 1):
        points.append(_point(CHAOS, degree + 1, [_expanded(one, degree, truth) for _ in range(seeds or SEEDS)]))
    runs = [_exactly(one, truth) for _ in range(seeds or SEEDS)]
    return [*points, _point(EXACT, len(one.exact.found.scores), runs)]


def _point(method, size, runs) -> Point:
    """Of runs (seconds, error of the mean, error of the deviation)."""
    seconds, *errors = np.transpose(runs)
    found = (np.quantile(error, (0.5, 0.25, 0.75)) for error in errors)
    return Point(method, size, float(np.median(seconds)), *(float(value) for three in found for value in three))


def _sampled(one: Known, name, size, seed, truth):
    start = time.perf_counter()
    unit = UnitPoints(name, one.study.joint.dimension, seed, size).chunk(0, size)
    sample = realise(one.task, one.study.joint.values(unit)).quantities[:, 0]
    return _judged(start, (np.mean(sample), np.std(sample, ddof=1)), truth)


def _expanded(one: Known, degree, truth):
    start = time.perf_counter()
    found = expand(one.study.joint, lambda values: realise(one.task, values).quantities[:, 0], degree)
    return _judged(start, (found.mean, found.std), truth)


def _exactly(one: Known, truth):
    """A fresh change of variable; its realisations are the places at which it looks at the closed form."""
    start = time.perf_counter()
    exact = known_of(one.study).exact
    return _judged(start, (exact.mean, exact.std), truth)


def _judged(start, found, truth):
    seconds = time.perf_counter() - start
    return (seconds, *np.abs(np.array(found) / truth - 1.0))


def write_table(points: list[Point], path: Path) -> None:
    """The points as comma-separated values."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream)
        table.writerow(Point._fields)
        table.writerows(points)


def draw(points: list[Point], path: Path) -> None:
    """The chart: the mean above, the deviation below; over realisations on the left, over seconds on the right."""
    rows = []
    for statistic, words in zip(STATISTICS, ("mean", "deviation"), strict=True):
        up = Axis(f"relative error of the {words} (dotted: {WANTED:g})", "1", log=True, limits=(0.3 * LEAST, 1.0))
        sizes = Panel(words, f"{words.capitalize()} over realisations", Axis("realisations", "1", log=True), up)
        costs = Panel(
            words, f"{words.capitalize()} over seconds", Axis("time on one core", "s", log=True), up, legend=None
        )
        for place, method in enumerate(dict.fromkeys(p.method for p in points)):
            sizes.parts += _parts(points, method, place, statistic, "realisations")
            costs.parts += _parts(points, method, place, statistic, "seconds")
        for panel, along in ((sizes, "realisations"), (costs, "seconds")):
            across = [getattr(p, along) for p in points]
            ends = [min(across), max(across)]
            panel.parts.append(Line(f"{WANTED:g}", ends, [WANTED, WANTED], WANTED_LOOK, False))
        rows.append([sizes, costs])
    seeds = f"median and middle half of {MANY} seeds, {SEEDS} beyond {CHEAP} realisations; chaos: degrees 1 to 12"
    text = f"{seeds}; bearing_twin {__version__}, numpy {np.__version__}, {time.strftime('%Y-%m-%d')}"
    draw_sheet(Sheet("How fast mean and deviation of the contact time are known", rows, text, []), path)


def _parts(points, method, place, statistic, along):
    mine = [p for p in points if p.method == method]
    x = [getattr(p, along) for p in mine]
    middle, low, high = (
        [max(getattr(p, f"{statistic}_{one}"), LEAST) for p in mine] for one in ("error", "low", "high")
    )
    look = {**colour(place), "marker": "o", "markersize": 5}
    name = method.replace("_", " ")
    if method in SAMPLERS:
        shade = {"color": BALL_COLOURS[place], "alpha": 0.18}
        steep = f"{name}, slope {slope(points, method, statistic):.2f}"
        return [Band(f"{name}, middle half", x, low, high, shade, False), Line(steep, x, middle, look)]
    if method == EXACT:
        look = {"color": STYLE["ink"], "marker": "*", "markersize": 14, "linestyle": ""}
    return [Line(name, x, middle, look)]


def slope(points: list[Point], method: str, statistic: str = "mean") -> float:
    """Exponent of the median error in the number of realisations, fitted over the ladder."""
    mine = [p for p in points if p.method == method]
    sizes = np.log([p.realisations for p in mine])
    errors = np.log([max(getattr(p, f"{statistic}_error"), LEAST) for p in mine])
    return float(np.polyfit(sizes, errors, 1)[0])


def needed(points: list[Point], method: str, wanted: float = WANTED, statistic: str = "mean") -> Point | None:
    """The smallest size from which on the median error stays within `wanted`; None if there is none."""
    mine = [p for p in points if p.method == method]
    wide = [place for place, p in enumerate(mine) if getattr(p, f"{statistic}_error") > wanted]
    first = wide[-1] + 1 if wide else 0
    return mine[first] if first < len(mine) else None


def reading(points: list[Point]) -> list[str]:
    """What the chart says: realisations for a mean within WANTED, slopes, and where the differences end."""
    parts = []
    for method in dict.fromkeys(p.method for p in points):
        found = needed(points, method)
        most = max(p.realisations for p in points if p.method == method)
        cost = f"{found.realisations} ({found.seconds:.2g} s)" if found else f"more than {most}"
        parts.append(f"{method.replace('_', ' ')} {cost}")
    sentences = [f"Realisations for the mean within {WANTED:g}: {', '.join(parts)}."]
    even, plain = needed(points, "sobol"), needed(points, "random")
    if even:
        most = plain.realisations if plain else max(p.realisations for p in points if p.method == "random")
        many = f"{'' if plain else 'more than '}{most / even.realisations:.0f}"
        sentences.append(f"Scrambled Sobol needs {many} times fewer realisations than random sampling.")
    slopes = ", ".join(f"{name.replace('_', ' ')} {slope(points, name):.2f}" for name in SAMPLERS)
    sentences.append(f"The error of the mean falls with the number of realisations to the power: {slopes}.")
    sentences.append(
        "With one uncertain input a latin hypercube is as even as Sobol points, with several only where their effects "
        "add up; it gives no interval of its own, Sobol points do by their eight replicates. Polynomial chaos takes "
        f"{VALIDATION} further realisations, not counted here, to measure its error."
    )
    return sentences
