"""Charts of studies: how fast samplers converge, and how often 95 % intervals hold the truth.

The contact time of two spheres is a product of powers of modulus, radius, mass and speed. With one gamma input, the
measured alpha, it is a gamma variable; with lognormal inputs it is a lognormal one: mean, deviation, skewness and
quantiles are closed forms. Every run is a public study.
"""

import functools
import math

import numpy as np
from scipy import stats

from bearing_twin.charts.contest import LEAST, Contest, timed
from bearing_twin.charts.panels import Axis, Band, Line, Panel, colour, curve, shade
from bearing_twin.charts.rows import DONE
from bearing_twin.uq.run import run_study
from bearing_twin.uq.study import parse_study

SPEED, ALPHA = 20.0, 1.138e-4
POWERS = {  # of the contact time in each input, with its coefficient of variation
    "first.material.young_modulus": (-0.4, 0.2, 2.1e11, ["second.material.young_modulus"]),
    "first.radius": (-0.2, 0.1, 0.01905, ["second.radius"]),
    "first.mass": (0.4, 0.2, 0.2258, ["second.mass"]),
    "motion.first_velocity": (-0.2, 0.3, 20.0, []),
}
SAMPLERS = ("random", "latin_hypercube", "sobol")
EXACT = "change_of_variable"


def _gamma(deviation: float) -> dict:
    return {"contact.measured_alpha": {"distribution": "gamma", "mean": ALPHA, "std": deviation}}


def _four() -> dict:
    return {
        key: {"distribution": "lognormal", "mean": mean, "std": share * mean, "also": also}
        for key, (_, share, mean, also) in POWERS.items()
    }


def _lognormal(deviation: float) -> dict:
    return {"contact.measured_alpha": {"distribution": "lognormal", "mean": ALPHA, "std": deviation}}


@functools.cache
def _truth(problem: str):
    """The exact distribution of the contact time [s] of a problem, as a frozen one of SciPy."""
    scale = SPEED**-0.2
    if problem in ("one", "gamma"):
        deviation = DEVIATIONS[problem]
        shape = (ALPHA / deviation) ** 2
        return stats.gamma(shape, scale=ALPHA / shape * scale)
    if problem == "heavy":
        spread = math.sqrt(math.log1p((DEVIATIONS[problem] / ALPHA) ** 2))
        return stats.lognorm(spread, scale=ALPHA * math.exp(-0.5 * spread**2) * scale)
    spreads = {key: math.sqrt(math.log1p(row[1] ** 2)) for key, row in POWERS.items()}
    spread = math.sqrt(sum((POWERS[key][0] * one) ** 2 for key, one in spreads.items()))
    medians = {key: POWERS[key][2] * math.exp(-0.5 * one**2) for key, one in spreads.items()}
    nominal = run_study(_study("four", "random", 2, 1)).summary["quantities"]["contact_duration"]["at_mean_inputs"]
    ratios = ((medians[key] / POWERS[key][2]) ** POWERS[key][0] for key in POWERS)
    return stats.lognorm(spread, scale=nominal * math.prod(ratios))


DEVIATIONS = {"one": 2e-5, "gamma": 6e-5, "heavy": 1.5e-4}
INPUTS = {"one": _gamma, "gamma": _gamma, "heavy": _lognormal}


def _study(problem: str, method: str, samples: int, seed: int):
    inputs = INPUTS[problem](DEVIATIONS[problem]) if problem in INPUTS else _four()
    by = {"method": "ensemble", "sampler": method} if method in SAMPLERS else {"method": method}
    tuned = {"samples": samples} if method in SAMPLERS else {}
    words = {"quantities": ["contact_duration"], "modality": "no", "seed": seed, "workers": 1}
    return parse_study({"scene": "two_spheres", "inputs": inputs, **words, **by, **tuned}, "chart")


def _found(problem, method, samples, seed) -> dict:
    return run_study(_study(problem, method, samples, seed)).summary["quantities"]["contact_duration"]


SIZES = tuple(float(32 * 4**power) for power in range(7))
SEEDS = 15


def judge_sampler(problem: str, method: str, setting: float, _: float) -> dict:
    """A method at one size, by several seeds: medians and quartiles of the errors of mean and deviation."""
    truth, seeds = _truth(problem), range(1, SEEDS + 1) if method in SAMPLERS else (1,)
    runs = [_found(problem, method, int(setting) if setting == setting else 0, seed) for seed in seeds]
    means = [abs(one["mean"] / truth.mean() - 1.0) for one in runs]
    deviations = [abs(one["std"] / truth.std() - 1.0) for one in runs]
    cost = timed(lambda: _found(problem, method, int(setting) if setting == setting else 0, 1))[1]
    found = {"error": float(np.median(means)), **cost}
    for name, values in (("mean", means), ("deviation", deviations)):
        low, middle, high = np.quantile(values, (0.25, 0.5, 0.75)).tolist()
        found |= {f"{name}_error": middle, f"{name}_low": low, f"{name}_high": high}
    return found


def sampler_entries(problem, quick):
    """Every sampler over sizes, and the change of variable where there is one input."""
    for sampler in SAMPLERS:
        yield from ((sampler, size, math.nan) for size in (SIZES[:2] if quick else SIZES))
    if problem == "one":
        yield EXACT, math.nan, math.nan


def sampler_panels(contest, rows):
    """Errors of mean and deviation over realisations, and of the mean over CPU time; a row a problem."""
    lines = []
    for problem in dict.fromkeys(row.problem for row in rows):
        line = []
        for statistic, along in (("mean", "realisations"), ("deviation", "realisations"), ("mean", "CPU time")):
            parts = []
            for number, method in enumerate(dict.fromkeys(row.method for row in rows)):
                mine = [row for row in rows if (row.problem, row.method, row.status) == (problem, method, DONE)]
                x = [row.seconds if along == "CPU time" else row.setting for row in mine]
                if along != "CPU time" and method == EXACT:
                    continue
                low, middle, high = (
                    [max(row.more[f"{statistic}_{one}"], LEAST) for row in mine] for one in ("low", "error", "high")
                )
                if method in SAMPLERS:
                    parts.append(Band(f"{method}, middle half", x, low, high, shade(number), False))
                parts += curve(method.replace("_", " "), [*zip(x, middle, strict=True)], number)
            across = Axis(along, "s" if along == "CPU time" else "1", log=True)
            title = f"{contest.problems[problem]}: {statistic}"
            line.append(
                Panel(
                    f"{problem}, {statistic} over {along}",
                    title,
                    across,
                    Axis(f"relative error of the {statistic}", log=True),
                    parts,
                )
            )
        lines.append(line)
    return lines


def slope(rows, problem: str, method: str) -> float:
    """The exponent of the median error of the mean in the number of realisations."""
    mine = [row for row in rows if (row.problem, row.method, row.status) == (problem, method, DONE)]
    errors = np.log([max(row.error, LEAST) for row in mine])
    return float(np.polyfit(np.log([row.setting for row in mine]), errors, 1)[0]) if len(mine) > 1 else math.nan


def sampler_reading(contest, rows):
    """The realisations that keep the error wanted, and the rate of convergence."""
    for problem, title in contest.problems.items():
        mine = [row for row in rows if row.problem == problem]
        words = []
        for method in (one for one in SAMPLERS if any(row.method == one for row in mine)):
            good = [row.setting for row in mine if row.method == method and row.error <= contest.wanted]
            many = (
                f"{min(good):.0f}"
                if good
                else f"more than {max(row.setting for row in mine if row.method == method):.0f}"
            )
            words.append(f"{method.replace('_', ' ')} {many} (error falls as n^{slope(rows, problem, method):.2f})")
        if words:
            yield f"{title}: realisations for an error of the mean of {contest.wanted:g}: {', '.join(words)}."
        for row in (row for row in mine if row.method == EXACT):
            yield f"{title}: the change of variable needs no sample; error of the mean {row.error:.1g}."


STATISTICS = ("mean", "deviation", "skewness", "quantile 0.05", "quantile 0.50", "quantile 0.95")
STUDIES, CLOSE = 300.0, 0.93  # studies of a cell; coverage below which a cell is called too low
COUNTS = (128.0, 512.0, 2048.0)


def judge_coverage(problem: str, method: str, samples: float, studies: float) -> dict:
    """In how many of so many studies the interval of each statistic holds the truth, and is marked unsafe."""
    truth = _truth(problem)
    exact = {"mean": truth.mean(), "deviation": truth.std(), "skewness": float(truth.stats("s"))}
    exact |= {f"quantile {one}": truth.ppf(float(one)) for one in ("0.05", "0.50", "0.95")}
    held, unsafe = dict.fromkeys(STATISTICS, 0), dict.fromkeys(STATISTICS, 0)
    names = {"mean": "mean", "deviation": "std", "skewness": "skewness"}
    for seed in range(int(studies)):
        found = _found(problem, method, int(samples), seed)
        for statistic in STATISTICS:
            if statistic in names:
                low, high = found[f"{names[statistic]}_interval"] or (math.nan, math.nan)
                unsafe[statistic] += names[statistic] in found["unsafe"]
            else:
                one = found["quantiles"][statistic.partition(" ")[2]]
                low, high = one["low"], one["high"]
            held[statistic] += low <= exact[statistic] <= high
    shares = {name: count / studies for name, count in held.items()}
    marked = {f"{name} marked unsafe": count / studies for name, count in unsafe.items() if count}
    return {"error": abs(min(shares.values()) - 0.95), **shares, **marked}


def coverage_panels(contest, rows):
    """A panel a statistic: coverage over the number of samples, a colour a sampler, dashes a problem."""
    good, panels = [row for row in rows if row.status == DONE], []
    ends = [min(row.setting for row in good), max(row.setting for row in good)]
    least = min([0.7, *(row.more[name] for row in good for name in STATISTICS)])
    for statistic in STATISTICS:
        parts = [Band("93 to 97 %", ends, [0.93] * 2, [0.97] * 2, {"color": "#71808c", "alpha": 0.25})]
        for dashes, problem in zip(("-", "--", ":"), contest.problems, strict=True):
            for number, method in enumerate(dict.fromkeys(row.method for row in good)):
                mine = sorted(
                    (row.setting, row.more[statistic]) for row in good if (row.method, row.problem) == (method, problem)
                )
                look = {**colour(number), "linestyle": dashes, "marker": "o", "markersize": 5, "clip_on": False}
                words = f"{method.replace('_', ' ')}, {problem}"
                parts.append(Line(words, [one[0] for one in mine], [one[1] for one in mine], look))
        up = Axis("share of studies that hold the truth", limits=(0.1 * int(10.0 * least), 1.0))
        across = Axis("samples", log=True, limits=(0.7 * ends[0], 1.4 * ends[1]))
        panels.append(Panel(statistic, statistic, across, up, parts))
    return [panels[:3], panels[3:]]


def coverage_reading(contest, rows):
    """Coverage by problem, and which cells hold less, marked or not."""
    for problem, title in contest.problems.items():
        mine = [row for row in rows if (row.problem, row.status) == (problem, DONE)]
        if not mine:
            continue
        cells = [(row, name, row.more[name]) for row in mine for name in STATISTICS]
        low = [one for one in cells if one[2] < CLOSE]
        bare = [one for one in low if float(one[0].more.get(f"{one[1]} marked unsafe") or 0.0) < 0.9]
        words = ", ".join(
            f"{name} by {row.setting:.0f} {row.method} samples ({share:.0%})" for row, name, share in bare
        )
        yield (
            f"{title}: intervals hold the truth in {min(one[2] for one in cells):.0%} to "
            f"{max(one[2] for one in cells):.0%} of the studies; {len(low)} of {len(cells)} cells hold less than "
            f"{CLOSE:.0%}, {len(low) - len(bare)} of them marked unsafe{'; not marked: ' + words if words else ''}."
        )


CHARTS = {
    "samplers": Contest(
        title="How fast mean and deviation of a contact time are known",
        problems={"one": "alpha uncertain", "four": "modulus, radius, mass, speed uncertain"},
        entries=sampler_entries,
        judge=judge_sampler,
        command=lambda *entry: "",
        panels=sampler_panels,
        read=sampler_reading,
        wanted=1e-4,
    ),
    "coverage": Contest(
        title="How often 95 % intervals hold the truth",
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
