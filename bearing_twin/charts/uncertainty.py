"""Charts of studies: how fast samplers converge, and how often 95 % intervals hold the true value.

The contact time of two spheres is a product of powers of modulus, radius, mass and speed. With one gamma input, the
measured alpha, it is a gamma variable; with lognormal inputs it is a lognormal one: mean, deviation and quantiles are
closed forms. Every run is a public study.
"""

import dataclasses
import functools
import math

import numpy as np
from scipy import stats

from bearing_twin.charts.contest import LEAST, Contest, of_methods, of_problem, timed
from bearing_twin.charts.panels import CROSS, Axis, Band, Line, Panel, colour, curve, shade
from bearing_twin.charts.rows import DONE
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


@functools.cache
def truth_of(problem: str):
    """The exact distribution of the contact time [s] of a problem, as a frozen one of SciPy."""
    name, deviation = ONE_INPUT.get(problem, ("", 0.0))
    if name == "gamma":
        shape = (ALPHA / deviation) ** 2
        return stats.gamma(shape, scale=ALPHA / shape * SPEED**-0.2)
    if name == "lognormal":
        spread = math.sqrt(math.log1p((deviation / ALPHA) ** 2))
        return stats.lognorm(spread, scale=ALPHA * math.exp(-0.5 * spread**2) * SPEED**-0.2)
    variances = {key: math.log1p(share**2) for key, (_, share, _, _) in POWERS.items()}
    spread = math.sqrt(sum(row[0] ** 2 * variances[key] for key, row in POWERS.items()))
    at_means = found(study_of("four", "random", 2.0), 1)["at_mean_inputs"]
    medians = math.exp(sum(-0.5 * row[0] * variances[key] for key, row in POWERS.items()))
    return stats.lognorm(spread, scale=at_means * medians)


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
    by = {"method": method}
    if method in SAMPLERS:
        by = {"method": "ensemble", "sampler": method, "samples": int(samples)}
    words = {"quantities": ["contact_duration"], "modality": "no", "checks": 0, "workers": 1}
    return parse_study({"scene": "two_spheres", "inputs": inputs, **words, **by}, "chart")


def found(study: Study, seed: int) -> dict:
    """The summary of the contact time of a study with this seed."""
    seeded = dataclasses.replace(study, settings=dataclasses.replace(study.settings, seed=seed))
    return run_study(seeded).summary["quantities"]["contact_duration"]


SIZES = tuple(float(32 * 4**power) for power in range(7))
SEEDS = 15


def judge_sampler(problem: str, method: str, setting: float, _: float) -> dict:
    """A method at one size, by several seeds: medians and quartiles of the errors of mean and deviation."""
    truth, seeds = truth_of(problem), range(1, SEEDS + 1) if method in SAMPLERS else (1,)
    study = study_of(problem, method, setting)
    runs, cost = [found(study, seed) for seed in seeds], timed(lambda: found(study, 1))
    row = dict(cost[1])
    for name, key, true in (("mean", "mean", truth.mean()), ("deviation", "std", truth.std())):
        low, middle, high = np.quantile([abs(one[key] / true - 1.0) for one in runs], (0.25, 0.5, 0.75)).tolist()
        row |= {f"{name}_error": middle, f"{name}_low": low, f"{name}_high": high}
    return {"error": row["mean_error"], **row}


def sampler_entries(problem, quick):
    """Every sampler over sizes, and the change of variable where there is one input."""
    for sampler in SAMPLERS:
        yield from ((sampler, size, math.nan) for size in (SIZES[:2] if quick else SIZES))
    if problem in ONE_INPUT:
        yield EXACT, math.nan, math.nan


def sampler_panels(contest, rows):
    """Errors of mean and deviation over realisations, and of the mean over CPU time; a row a problem."""
    lines = []
    for problem, title in contest.problems.items():
        mine, line = of_methods(of_problem(rows, problem, DONE)), []
        for statistic, along in (("mean", "realisations"), ("deviation", "realisations"), ("mean", "CPU time")):
            parts, timed_too = [], along == "CPU time"
            for number, (method, ours) in enumerate(mine.items()):
                if method == EXACT and not timed_too:
                    continue
                x = [row.seconds if timed_too else row.setting for row in ours]
                low, middle, high = (
                    [max(row.more[f"{statistic}_{one}"], LEAST) for row in ours] for one in ("low", "error", "high")
                )
                if method in SAMPLERS:
                    parts.append(Band(f"{method}, middle half", x, low, high, shade(number), False))
                parts += curve(method.replace("_", " "), [*zip(x, middle, strict=True)], number)
            across, up = Axis(along, "s" if timed_too else "1", log=True), f"relative error of the {statistic}"
            line.append(Panel(f"{title}: {statistic}", across, Axis(up, log=True), parts))
        lines += [line] if mine else []
    return lines


def slope(rows) -> float:
    """The exponent of the median error of the mean in the number of realisations."""
    errors = np.log([max(row.error, LEAST) for row in rows])
    return float(np.polyfit(np.log([row.setting for row in rows]), errors, 1)[0]) if len(rows) > 1 else math.nan


def sampler_reading(contest, rows):
    """The realisations that an error needs, and the rate of convergence."""
    for problem, title in contest.problems.items():
        words, methods = [], of_methods(of_problem(rows, problem, DONE))
        for method in (one for one in SAMPLERS if one in methods):
            sizes = [row.setting for row in methods[method] if row.error <= contest.wanted]
            many = f"{min(sizes):.0f}" if sizes else f"more than {methods[method][-1].setting:.0f}"
            words.append(f"{method.replace('_', ' ')} {many} (error falls as n^{slope(methods[method]):.2f})")
        if words:
            yield f"{title}: realisations for an error of the mean of {contest.wanted:g}: {', '.join(words)}."
        for row in methods.get(EXACT, ()):
            yield f"{title}: the change of variable needs no sample; error of the mean {row.error:.1g}."


STATISTICS = {"mean": "mean", "deviation": "std", **{f"quantile {p}": p for p in ("0.05", "0.50", "0.95")}}
CLOSE, WIDE = 0.93, 0.97  # coverage between which an interval is what it says
STUDIES = 1500.0  # of a cell: of a coverage of 95 % so many show less than CLOSE or more than WIDE once in 2800 cells
MARKED = 0.9  # share of studies
COUNTS = (128.0, 512.0, 2048.0)


def judge_coverage(problem: str, method: str, samples: float, studies: float) -> dict:
    """In how many of so many studies the interval of each statistic holds the true value, and is marked unsafe."""
    truth, study = truth_of(problem), study_of(problem, method, samples)
    exact = {"mean": truth.mean(), "std": truth.std(), **{p: truth.ppf(float(p)) for p in ("0.05", "0.50", "0.95")}}
    held, unsafe = dict.fromkeys(STATISTICS, 0.0), dict.fromkeys(STATISTICS, 0.0)
    for seed in range(int(studies)):
        one = found(study, seed)
        for name, key in STATISTICS.items():
            low, high = one.get(f"{key}_interval") or [one["quantiles"][key][end] for end in ("low", "high")]
            held[name] += (low is None or low <= exact[key]) and (high is None or exact[key] <= high)
            unsafe[name] += key in one["unsafe"]
    shares = {name: count / studies for name, count in held.items()}
    marked = {f"{name} marked unsafe": count / studies for name, count in unsafe.items() if count}
    return {"error": abs(min(shares.values()) - 0.95), **shares, **marked}


def is_marked(row, statistic: str) -> bool:
    """True where nearly all studies of a row mark the interval of the statistic as unsafe."""
    return float(row.more.get(f"{statistic} marked unsafe") or 0.0) >= MARKED


def coverage_panels(contest, rows):
    """A panel a statistic: coverage over the number of samples, a colour a sampler, dashes a problem."""
    good, panels = [row for row in rows if row.status == DONE], []
    ends = [min(row.setting for row in good), max(row.setting for row in good)]
    least = min([0.9, *(row.more[name] for row in good for name in STATISTICS)])
    across = Axis("samples", log=True, limits=(0.7 * ends[0], 1.4 * ends[1]))
    up = Axis("share that contains the true value", limits=(0.05 * int(20.0 * least), 1.0))
    for statistic in STATISTICS:
        parts = [Band("93 to 97 %", ends, [CLOSE] * 2, [WIDE] * 2, {"color": "#71808c", "alpha": 0.25})]
        for dashes, problem in zip(("-", "--", ":"), contest.problems, strict=True):
            for number, (method, mine) in enumerate(of_methods(of_problem(good, problem)).items()):
                look = {**colour(number), "linestyle": dashes, "marker": "o", "markersize": 5, "clip_on": False}
                name, shares = f"{method.replace('_', ' ')}, {problem}", [row.more[statistic] for row in mine]
                parts.append(Line(name, [row.setting for row in mine], shares, look))
                unsafe = [(row.setting, row.more[statistic]) for row in mine if is_marked(row, statistic)]
                if unsafe:
                    parts.append(Line(f"{name}, unsafe", *np.transpose(unsafe), {**look, **CROSS}, False))
        panels.append(Panel(statistic, across, up, parts))
    return [panels[:2], panels[2:]]


def coverage_reading(contest, rows):
    """Coverage by problem, and the cells that hold less or more than they say."""
    for problem, title in contest.problems.items():
        cells = [(row, name, row.more[name]) for row in of_problem(rows, problem, DONE) for name in STATISTICS]
        if not cells:
            continue
        shares, low = [one[2] for one in cells], [one for one in cells if one[2] < CLOSE]
        words = [
            f"{len(found)} {what} ({', '.join(f'{name} by {row.setting:.0f} {row.method}' for row, name, _ in found)})"
            for what, found in (
                (f"below {CLOSE:.0%}, marked unsafe", [one for one in low if is_marked(*one[:2])]),
                (f"below {CLOSE:.0%}, not marked", [one for one in low if not is_marked(*one[:2])]),
                (f"above {WIDE:.0%}", [one for one in cells if one[2] > WIDE]),
            )
            if found
        ]
        yield (
            f"{title}: intervals hold the true value in {min(shares):.1%} to {max(shares):.1%} of the studies; of "
            f"{len(cells)} cells {'; '.join(words) or 'none outside 93 to 97%'}."
        )


CHARTS = {
    "samplers": Contest(
        title="How fast mean and deviation of a contact time converge",
        problems={"one": "alpha uncertain", "four": "modulus, radius, mass, speed uncertain"},
        entries=sampler_entries,
        judge=judge_sampler,
        panels=sampler_panels,
        read=sampler_reading,
        wanted=1e-4,
    ),
    "coverage": Contest(
        title="Share of studies whose 95 % interval contains the true value",
        problems={
            "gamma": "gamma, deviation 0.53 of the mean",
            "four": "four inputs",
            "heavy": "lognormal, deviation 1.3",
        },
        entries=lambda problem, quick: (
            (sampler, size, 20.0 if quick else STUDIES)
            for sampler in SAMPLERS
            for size in (COUNTS[:1] if quick else COUNTS)
        ),
        judge=judge_coverage,
        panels=coverage_panels,
        read=coverage_reading,
    ),
}
