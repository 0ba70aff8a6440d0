"""Charts of studies: how fast samplers converge, and how often 95 % intervals hold the true value.

The contact time of two spheres is a product of powers of modulus, radius, mass and speed. With one gamma input, the
measured alpha, it is a gamma variable; with lognormal inputs it is a lognormal one: mean, deviation and quantiles are
closed forms. Every run is a public study.
"""

import dataclasses
import functools
import math

import numpy as np

from bearing_twin.charts.contest import (
    DONE,
    Contest,
    Problem,
    by_method,
    curve,
    error_against_cost,
    panels_over,
    timed,
)
from bearing_twin.pictures import STYLE, Axis, Band, Line, Panel
from bearing_twin.uq.distributions import DISTRIBUTIONS
from bearing_twin.uq.run import run_study
from bearing_twin.uq.study import Study, parse_study

SPEED, ALPHA = 20.0, 1.138e-4
POWERS = {  # of the contact time in each input, with its coefficient of variation, mean, and the keys that follow it
    "first.material.young_modulus": (-0.4, 0.2, 2.1e11, ["second.material.young_modulus"]),
    "first.radius": (-0.2, 0.1, 0.01905, ["second.radius"]),
    "first.mass": (0.4, 0.2, 0.2258, ["second.mass"]),
    "motion.first_velocity": (-0.2, 0.3, 20.0, []),
}
ONE_INPUT = {"one": ("gamma", 2e-5), "gamma": ("gamma", 6e-5), "heavy": ("lognormal", 1.5e-4)}  # deviations of alpha
SAMPLERS = ("random", "latin_hypercube", "sobol")
EXACT = "change_of_variable"
LABELS = {
    "random": "random samples",
    "latin_hypercube": "Latin hypercubes",
    "sobol": "Sobol sequences",
    EXACT: "change of variable",
}


@functools.cache
def truth_of(problem: str):
    """The exact distribution of the contact time [s] of a problem, as a frozen one of SciPy."""
    if problem in ONE_INPUT:
        name, deviation = ONE_INPUT[problem]
        return DISTRIBUTIONS[name].build(mean=ALPHA * SPEED**-0.2, std=deviation * SPEED**-0.2)
    variances = {key: math.log1p(share**2) for key, (_, share, _, _) in POWERS.items()}
    spread = math.sqrt(sum(row[0] ** 2 * variances[key] for key, row in POWERS.items()))
    at_means = contact_time_summary(study_of("four", "random", 2.0), 1)["at_mean_inputs"]
    logarithm = math.log(at_means) - sum(0.5 * row[0] * variances[key] for key, row in POWERS.items())
    return DISTRIBUTIONS["lognormal"].build(mean_log=logarithm, std_log=spread)


@functools.lru_cache(maxsize=1)
def study_of(problem: str, method: str, samples: float) -> Study:
    """The study of a problem by a method and so many samples."""
    if problem in ONE_INPUT:
        name, deviation = ONE_INPUT[problem]
        inputs = {"contact.measured_alpha": {"distribution": name, "mean": ALPHA, "std": deviation}}
    else:
        inputs = {
            key: {"distribution": "lognormal", "mean": mean, "std": share * mean, "also": also}
            for key, (_, share, mean, also) in POWERS.items()
        }
    sampling = {"method": method}
    if method in SAMPLERS:
        sampling = {"method": "ensemble", "sampler": method, "samples": int(samples)}
    common = {"quantities": ["contact_duration"], "modality": "no", "checks": 0, "workers": 1}
    return parse_study({"scene": "two_spheres", "inputs": inputs, **common, **sampling}, "chart")


def contact_time_summary(study: Study, seed: int) -> dict:
    """The summary of the contact time of a study with this seed."""
    seeded = dataclasses.replace(study, settings=dataclasses.replace(study.settings, seed=seed))
    return run_study(seeded).summary["quantities"]["contact_duration"]


SIZES = tuple(float(32 * 4**power) for power in range(7))
SEEDS = 15


def judge_sampler(problem: str, method: str, _: float, size: float) -> dict:
    """A method at one size, by several seeds: medians of the errors of mean and deviation."""
    truth, seeds = truth_of(problem), range(1, SEEDS + 1) if method in SAMPLERS else (1,)
    study = study_of(problem, method, size)
    runs, cost = [contact_time_summary(study, seed) for seed in seeds], timed(lambda: contact_time_summary(study, 1))[1]
    mean, deviation = (
        float(np.median([abs(summary[key] / true - 1.0) for summary in runs]))
        for key, true in (("mean", truth.mean()), ("std", truth.std()))
    )
    return {"error": mean, **cost, "deviation_error": deviation}


def sampler_entries(problem, quick):
    """Every sampler over sizes, and the change of variable where there is one input."""
    for sampler in SAMPLERS:
        yield from ((sampler, math.nan, size) for size in (SIZES[:2] if quick else SIZES))
    if problem in ONE_INPUT:
        yield EXACT, math.nan, math.nan


def sampler_panels(contest, rows, styles):
    """Errors of mean and deviation over realisations, and of the mean against CPU time; a row a problem."""
    columns = {
        "error": Axis("relative error of the mean", log=True),
        "deviation_error": Axis("relative error of the deviation", log=True),
    }
    sampled = [row for row in rows if row.method in SAMPLERS]
    error_panels = panels_over(contest, sampled, styles, Axis("realisations", log=True), columns)
    (cost_panels,) = error_against_cost(contest, rows, styles)
    return [[*pair, cost] for pair, cost in zip(error_panels, cost_panels, strict=True)]


STATISTICS = {"mean": "mean", "deviation": "std", **{f"quantile {p}": p for p in ("0.05", "0.50", "0.95")}}
CLOSE, WIDE = 0.93, 0.97  # coverage between which an interval is what it says
STUDIES = 1500.0  # of a cell: of a coverage of 95 % so many show less than CLOSE or more than WIDE once in 2800 cells
MARKED = 0.9  # share of studies
COUNTS = (128.0, 512.0, 2048.0)
RING = {"linestyle": "", "marker": "o", "markersize": 13, "markerfacecolor": "none", "color": STYLE["ink"]}


def judge_coverage(problem: str, method: str, samples: float, studies: float) -> dict:
    """In how many of so many studies the interval of each statistic holds the true value, and is marked unsafe."""
    truth, study = truth_of(problem), study_of(problem, method, samples)
    exact = {"mean": truth.mean(), "std": truth.std(), **{p: truth.ppf(float(p)) for p in ("0.05", "0.50", "0.95")}}
    covered, unsafe = dict.fromkeys(STATISTICS, 0.0), dict.fromkeys(STATISTICS, 0.0)
    for seed in range(int(studies)):
        summary = contact_time_summary(study, seed)
        for name, key in STATISTICS.items():
            low, high = summary.get(f"{key}_interval") or [summary["quantiles"][key][end] for end in ("low", "high")]
            covered[name] += (low is None or low <= exact[key]) and (high is None or exact[key] <= high)
            unsafe[name] += key in summary["unsafe"]
    shares = {name: count / studies for name, count in covered.items()}
    marked = {f"{name} marked unsafe": count / studies for name, count in unsafe.items() if count}
    return {"error": abs(min(shares.values()) - 0.95), **shares, **marked}


def coverage_entries(quick: bool):
    """Every sampler at each number of samples, and how many studies of it."""
    counts, studies = (COUNTS[:1], 20.0) if quick else (COUNTS, STUDIES)
    return ((sampler, count, studies) for sampler in SAMPLERS for count in counts)


def coverage_panels(contest, rows, styles):
    """A row a problem, a panel a statistic: coverage over the number of samples, a line a sampler."""
    across = Axis("samples", log=True, limits=(0.7 * COUNTS[0], 1.4 * COUNTS[-1]))
    shares = [100.0 * row.more[statistic] for row in rows if row.status == DONE for statistic in STATISTICS]
    up = Axis("share of studies", "%", limits=(min(90.0, min(shares, default=100.0) - 1.0), 100.0))

    def panel(statistic: str, title: str, runs: list) -> Panel:
        parts = [Band("93 to 97 %", COUNTS, 100.0 * CLOSE, 100.0 * WIDE, {"color": STYLE["soft"], "alpha": 0.25})]
        for method, runs_of_method in by_method(row for row in runs if row.status == DONE).items():
            points = [(row.setting, 100.0 * row.more[statistic]) for row in runs_of_method]
            parts += curve(*styles[method], points)
            is_marked = [float(row.more.get(f"{statistic} marked unsafe") or 0.0) >= MARKED for row in runs_of_method]
            parts.append(Line("interval marked unsafe in nearly all studies", *np.array(points)[is_marked].T, RING))
        return Panel(f"{statistic}, {title}", across, up, parts)

    return [[panel(statistic, *pair) for statistic in STATISTICS] for pair in contest.by_title(rows)]


def coverage_reading(contest, rows):
    """Coverage by problem, and the cells that hold less or more than they say."""
    for title, runs in contest.by_title(rows, DONE):
        cells = {
            f"{name} of {run.setting:.0f} by {LABELS[run.method]}": 100.0 * run.more[name]
            for run in runs
            for name in STATISTICS
        }
        wide = (f"{cell} {share:.1f} %" for cell, share in cells.items() if not CLOSE <= 0.01 * share <= WIDE)
        extremes = f"{min(cells.values()):.1f} to {max(cells.values()):.1f} %"
        outside = ", ".join(wide) or "none"
        yield f"{title}: {extremes} of the intervals contain the true value; outside 93 to 97 %: {outside}."


CHARTS = {
    "samplers": Contest(
        title="How fast mean and deviation of a contact time converge",
        problems={
            name: Problem(title, functools.partial(sampler_entries, name), functools.partial(judge_sampler, name))
            for name, title in {"one": "alpha uncertain", "four": "modulus, radius, mass, speed uncertain"}.items()
        },
        panels=sampler_panels,
        labels=LABELS,
        error="relative error of the mean",
        cost="CPU time of a study",
        requested_error=1e-4,
    ),
    "coverage": Contest(
        title="Share of studies whose 95 % interval contains the true value",
        problems={
            name: Problem(title, coverage_entries, functools.partial(judge_coverage, name))
            for name, title in {"gamma": "gamma", "four": "four inputs", "heavy": "lognormal"}.items()
        },
        panels=coverage_panels,
        labels=LABELS,
        read=coverage_reading,
    ),
}
