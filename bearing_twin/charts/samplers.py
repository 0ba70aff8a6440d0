"""Samplers and quadrature against each other: error of mean and deviation over realisations, and over seconds.

The contact time of paper 3's spheres is a product of powers of its inputs, so its mean and deviation are products of
moments of one input each, known to rounding. Random methods run with several seeds: the line is the median error, the
band the middle half of the seeds. `setting` is the number of realisations, `load_error` that of the mean.
"""

import functools
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bearing_twin.charts.chart import Chart
from bearing_twin.charts.contest import limited
from bearing_twin.charts.contest_picture import found_again
from bearing_twin.charts.sheets import Axis, Band, Line, Panel, Sheet
from bearing_twin.charts.sheets import draw as draw_sheet
from bearing_twin.charts.study_samples import colour
from bearing_twin.charts.table import DONE, Row
from bearing_twin.pictures.style import STYLE
from bearing_twin.uq.propagation import GREATEST_DEGREE, VALIDATION, derive, expand
from bearing_twin.uq.realisations import exact_distributions, mean_inputs, realise, task_of
from bearing_twin.uq.sampling import REPLICATES, SAMPLERS, UnitPoints
from bearing_twin.uq.study import parse_study


class StudyProblem(NamedTuple):
    """A study of two spheres, and the powers of its inputs whose product their contact time is proportional to."""

    title: str
    study: dict
    powers: tuple[float, ...]


PROBLEMS = {
    "one": StudyProblem(
        "alpha uncertain",
        {"inputs": {"contact.measured_alpha": {"distribution": "gamma", "mean": 1.138e-4, "std": 2e-5}}},
        (1.0,),
    ),
    "four": StudyProblem(
        "modulus, radius, mass, speed uncertain",
        {
            "inputs": {
                "first.material.young_modulus": {
                    "distribution": "gamma", "mean": 2.1e11, "std": 4.2e10, "also": ["second.material.young_modulus"]
                },
                "first.radius": {"distribution": "uniform", "low": 0.015, "high": 0.023, "also": ["second.radius"]},
                "first.mass": {"distribution": "lognormal", "mean": 0.2258, "std": 0.05, "also": ["second.mass"]},
                "motion.first_velocity": {"distribution": "uniform", "low": 10.0, "high": 30.0},
            }
        },
        (-0.4, -0.2, 0.4, -0.2),
    ),
}  # fmt: skip
SEEDS, MANY, CHEAP = 9, 36, 2**15  # seeds of a size; MANY up to CHEAP realisations
LADDER = tuple(32 * 4**step for step in range(9))  # realisations; sizes that balance a Sobol design
MOST = {"random": LADDER[-1]}  # the others are not run beyond MOST_EVEN: they are long there
MOST_EVEN = 2**17
CHAOS, EXACT = "polynomial_chaos", "change_of_variable"
WANTED = 1e-4
LEAST, ROUNDING = 1e-16, 1e-12  # smaller errors are drawn at LEAST
WANTED_LOOK = {"color": STYLE["soft"], "linewidth": 1.2, "linestyle": ":"}
MOST_NODES = 4096  # of polynomial chaos
BESIDE = (0.36, 0.2)  # where the legend stands then, in the panel


@dataclass(frozen=True)
class SamplerRow(Row):
    """A method at one size: medians over the seeds, quartiles of the error of the mean, the same of the deviation."""

    mean_low: float = math.nan
    mean_high: float = math.nan
    std_error: float = math.nan
    std_low: float = math.nan
    std_high: float = math.nan

    @property
    def mean_error(self) -> float:
        """The error of the mean."""
        return self.load_error


def entries(name: str) -> Iterator[tuple[str, float]]:
    """Every sampler at every size of the ladder, polynomial chaos by degrees, the change of variable for one input."""
    for sampler in SAMPLERS:
        yield from ((sampler, float(size)) for size in LADDER if size <= MOST.get(sampler, MOST_EVEN))
    inputs = len(PROBLEMS[name].powers)
    for degree in range(1, GREATEST_DEGREE + 1):
        if (degree + 1) ** inputs <= MOST_NODES:
            yield CHAOS, float((degree + 1) ** inputs)
    if inputs == 1:
        yield EXACT, 0.0


def judge(name: str, method: str, setting: float, limit: float) -> SamplerRow:
    """A method at one size, by several seeds; the limit is of one seed. The change of variable finds its own size."""
    study, task, truth = _posed(name)
    size, seeds = round(setting), MANY if method in SAMPLERS and setting <= CHEAP else SEEDS
    runs = []
    for seed in range(1, seeds + 1):
        with limited(limit):
            if method == CHAOS:
                degree = round(size ** (1.0 / study.joint.dimension)) - 1
                runs.append(_expanded(study, task, degree, truth))
            elif method == EXACT:
                size, *found = _exactly(study, task, truth)
                runs.append(found)
            else:
                runs.append(_sampled(study, task, method, size, seed, truth))
    seconds, *errors = np.transpose(runs)
    mean, deviation = (np.quantile(error, (0.5, 0.25, 0.75)).tolist() for error in errors)
    return SamplerRow(
        name,
        method,
        float(size),
        load_error=mean[0],
        seconds=float(np.median(seconds)),
        evaluations=float(size),
        status=DONE,
        mean_low=mean[1],
        mean_high=mean[2],
        std_error=deviation[0],
        std_low=deviation[1],
        std_high=deviation[2],
    )


@functools.cache
def _posed(name):
    """The study, its task, and mean and deviation of the contact time by the moments of each input's power."""
    problem = PROBLEMS[name]
    only_times = {"scene": "two_spheres", "quantities": ["contact_duration"], "modality": "no"}
    study = parse_study({**only_times, **problem.study}, problem.title)
    means, task = mean_inputs(study), task_of(study)
    scale = float(realise(task, means).quantities[0, 0] / np.prod(means[0] ** problem.powers))
    mean, square = scale, scale**2
    for source, power in zip(study.inputs, problem.powers, strict=True):
        found = source if power == 1.0 else derive(source, lambda x, power=power: x**power)
        mean, square = mean * found.mean, square * (found.mean**2 + found.std**2)
    return study, task, np.array([mean, np.sqrt(square - mean**2)])


def _sampled(study, task, name, size, seed, truth):
    start = time.thread_time()
    unit = UnitPoints(name, study.joint.dimension, seed, size).chunk(0, size)
    sample = realise(task, study.joint.values(unit)).quantities[:, 0]
    return _judged(start, (np.mean(sample), np.std(sample, ddof=1)), truth)


def _expanded(study, task, degree, truth):
    start = time.thread_time()
    found = expand(study.joint, lambda values: realise(task, values).quantities[:, 0], degree)
    return _judged(start, (found.mean, found.std), truth)


def _exactly(study, task, truth):
    """Of a fresh change of variable: at how many places it looks at the closed form, then as the others."""
    start = time.thread_time()
    exact = exact_distributions(study, task, "change_of_variable")["contact_duration"]
    return (len(exact.found.scores), *_judged(start, (exact.mean, exact.std), truth))


def _judged(start, found, truth):
    seconds = time.thread_time() - start
    return (seconds, *np.abs(np.array(found) / truth - 1.0))


def draw(points: list[SamplerRow], path: Path) -> None:
    """The chart, one row a problem: error of the mean over realisations and over seconds, then of the deviation."""
    rows = []
    for name in dict.fromkeys(p.problem for p in points):
        mine = of_problem(points, name)
        title = PROBLEMS[name].title
        title = f"{title[:1].upper()}{title[1:]}"
        rows.append(
            [
                _panel(mine, "mean", "realisations", title),
                _panel(mine, "mean", "seconds", "The same over seconds of one core"),
                _panel(mine, "std", "realisations", "The deviation"),
            ]
        )
    text = f"median and middle half of {MANY} seeds, {SEEDS} beyond {CHEAP} realisations; dotted: {WANTED:g}; "
    text += f"numpy {np.__version__}, {time.strftime('%Y-%m-%d')}"
    draw_sheet(Sheet("How fast mean and deviation of a contact time are known", rows, text, []), path)


def of_problem(points: list[SamplerRow], problem: str) -> list[SamplerRow]:
    """The points of one problem."""
    return [p for p in points if p.problem == problem]


def _panel(points, statistic, along, title):
    words = {"mean": "mean", "std": "deviation"}[statistic]
    done = [p for p in points if p.status == DONE]
    least = max(min((getattr(p, f"{statistic}_error") for p in done), default=LEAST), LEAST)
    # room for the legend below curves that end high, beside those that end at rounding
    room, place = (1e-4, "lower left") if least > ROUNDING else (0.3, BESIDE)
    up = Axis(f"relative error of the {words}", "1", log=True, limits=(room * least, 1.0))
    across = Axis("realisations", "1", log=True) if along == "realisations" else Axis("time", "s", log=True)
    parts = []
    for number, method in enumerate(dict.fromkeys(p.method for p in points)):
        parts += _parts([p for p in points if p.method == method], number, statistic, along)
    reach = [_along(p, along) for p in points]
    parts.append(Line(f"{WANTED:g}", [min(reach), max(reach)], [WANTED, WANTED], WANTED_LOOK, False))
    key = f"{points[0].problem}, {words} over {along}"
    return Panel(key, title, across, up, parts, place if along == "realisations" else None)


def _parts(mine, place, statistic, along):
    method, good = mine[0].method, [p for p in mine if p.status == DONE]
    lost = [_along(p, along) for p in mine if p.status != DONE]
    crosses = [
        Line(f"{method}, no result", lost, [1.0] * len(lost), {**colour(place), "marker": "x", "linestyle": ""}, False)
    ]
    if not good:
        return crosses
    mine, x = good, [_along(p, along) for p in good]
    columns = ([getattr(p, f"{statistic}_{one}") for p in mine] for one in ("error", "low", "high"))
    middle, low, high = (np.maximum(column, LEAST) for column in columns)
    look = {**colour(place), "marker": "o", "markersize": 5}
    name = method.replace("_", " ")
    if method in SAMPLERS:
        shade = {"color": colour(place)["color"], "alpha": 0.18}
        steep = f"{name}, slope {slope(mine, method, statistic):.2f}"
        return [*crosses, Band(f"{name}, middle half", x, low, high, shade, False), Line(steep, x, middle, look)]
    if method == EXACT:
        look = {"color": STYLE["ink"], "marker": "*", "markersize": 14, "linestyle": ""}
    return [*crosses, Line(name, x, middle, look)]


def _along(row, along):
    return row.setting if along == "realisations" else row.seconds


def slope(points: list[SamplerRow], method: str, statistic: str = "mean") -> float:
    """Exponent of the median error in the number of realisations, fitted over the ladder; points of one problem."""
    mine = [p for p in points if p.method == method and p.status == DONE]
    errors = np.log([max(getattr(p, f"{statistic}_error"), LEAST) for p in mine])
    return float(np.polyfit(np.log([p.setting for p in mine]), errors, 1)[0]) if len(mine) > 1 else math.nan


def needed(points: list[SamplerRow], method: str, wanted: float = WANTED) -> SamplerRow | None:
    """The smallest size from which on the median error stays within `wanted`, None if none; points of one problem."""
    mine = [p for p in points if p.method == method]
    wide = [place for place, p in enumerate(mine) if not p.mean_error <= wanted]
    first = wide[-1] + 1 if wide else 0
    return mine[first] if first < len(mine) else None


def reading(points: list[SamplerRow]) -> list[str]:
    """What the chart says: for each problem realisations for a mean within WANTED, the factor to Sobol, slopes."""
    sentences = [
        sentence
        for name in dict.fromkeys(p.problem for p in points)
        for sentence in _reading(PROBLEMS[name].title, of_problem(points, name))
    ]
    sentences.append(
        f"Sobol points and latin hypercubes give intervals by their {REPLICATES} replicates. Polynomial chaos "
        f"takes {VALIDATION} further realisations, not counted here, to measure its error."
    )
    return sentences + found_again(points, ())


def _reading(title, points):
    parts = []
    for method in dict.fromkeys(p.method for p in points):
        found = needed(points, method)
        most = max(p.setting for p in points if p.method == method)
        cost = f"{found.setting:.0f} ({found.seconds:.2g} s)" if found else f"more than {most:.0f}"
        parts.append(f"{method.replace('_', ' ')} {cost}")
    yield f"Realisations for the mean within {WANTED:g}, {title}: {', '.join(parts)}."
    even, plain = needed(points, "sobol"), needed(points, "random")
    if even:
        most = plain.setting if plain else max(p.setting for p in points if p.method == "random")
        many = f"{'' if plain else 'more than '}{most / even.setting:.0f}"
        yield f"Scrambled Sobol needs {many} times fewer realisations than random sampling."
    slopes = ", ".join(f"{name.replace('_', ' ')} {slope(points, name):.2f}" for name in SAMPLERS)
    yield f"The error of the mean falls with the number of realisations to the power: {slopes}."


CONTESTS = {
    "samplers": Chart(
        judge=judge,
        problems={name: problem.title for name, problem in PROBLEMS.items()},
        entries=entries,
        kind=SamplerRow,
        drawn=draw,
        told=reading,
    )
}
