"""Paper 3 (Buezas, Rosales, Sampaio 2012), figures 1 to 24: impacts of spheres and discs with uncertain inputs.

Spheres: alpha is gamma, the contact time alpha v^-0.2, so its density is known; histograms are studies. Discs by line
contact: the density of the contact time follows from that of the modulus by a change of variable. Soft discs: studies
of finite elasticity.
"""

import functools
import math

import numpy as np
from scipy import stats
from scipy.interpolate import PchipInterpolator

from bearing_twin.base.errors import StatisticError
from bearing_twin.charts.panels import Axis, Band, Bars, Line, Map, Panel, Sheet, colour, dashed, shade
from bearing_twin.charts.paper import Figures, Paper
from bearing_twin.pictures.style import STYLE
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate
from bearing_twin.uq.modality import modality
from bearing_twin.uq.run import run_study
from bearing_twin.uq.study import load_study

MEAN_ALPHA, DEVIATIONS = 1.138e-4, (2e-5, 4e-5, 6e-5)
SPHERES = {deviation: f"spheres_alpha_{number}e-5" for deviation, number in zip(DEVIATIONS, (2, 4, 6), strict=True)}
ALPHA = Axis("alpha", "s (m/s)^0.2", shown=(1e5, "1e-5 s (m/s)^0.2"))
CONTACT_TIME, DENSITY = Axis("contact time", "s"), Axis("density", "1/s", limits=(0.0, None))
TIME, FORCE, MODULUS = Axis("time since first touch", "s"), Axis("contact force", "N"), Axis("Young's modulus", "Pa")
BOUNDS = (0.05, 0.5, 0.95)
THIN = {"color": STYLE["edge"], "linewidth": 0.8, "alpha": 0.9}
QUICK, FEW = 200, 40  # samples of a quick study, of one by finite elasticity


def alpha(deviation: float):
    """The gamma distribution of alpha [s (m/s)^0.2]."""
    shape = (MEAN_ALPHA / deviation) ** 2
    return stats.gamma(shape, scale=MEAN_ALPHA / shape)


def contact_time(deviation: float, speed: float = 20.0):
    """The distribution of the contact time [s] of two spheres at a speed [m/s]."""
    shape = (MEAN_ALPHA / deviation) ** 2
    return stats.gamma(shape, scale=MEAN_ALPHA / shape * speed**-0.2)


@functools.lru_cache(maxsize=4)
def study(name: str, samples: int, *overrides: str):
    """The result of a shipped study, without its sweep; `samples` 0: as many as shipped."""
    few = (f"samples={samples}",) if samples else ()
    return run_study(load_study(name, ["modality=no", "sweep=", "method=ensemble", *few, *overrides]))


def bars(sample: np.ndarray, look: dict | None = None, name: str = "") -> Bars:
    """The histogram of a sample, by the rule of Freedman and Diaconis."""
    sample = sample[np.isfinite(sample)]
    heights, edges = np.histogram(sample, "fd", density=True)
    shaded = {"fill": True, "color": "#b9c6d2"}
    return Bars(name or f"{len(sample)} samples", edges, heights, shaded if look is None else look, look is None)


def density(name: str, one, look: dict) -> Line:
    """The density of a distribution over all but a negligible part of it."""
    x = np.linspace(one.ppf(1e-6), one.ppf(1.0 - 5e-4), 301)
    return Line(name, x, one.pdf(x), look)


def smoothed(name: str, sample: np.ndarray, look: dict) -> Line:
    """The kernel density of a sample."""
    sample = sample[np.isfinite(sample)]
    x = np.linspace(sample.min(), sample.max(), 301)
    return Line(name, x, stats.gaussian_kde(sample)(x), look)


def densities(quick: bool) -> Sheet:
    """Figures 1, 2, 10 and 11."""
    found = [
        study(name, QUICK if quick else 0, "histories=[]", "quantities=[contact_duration]") for name in SPHERES.values()
    ]
    samples = [(one.values[:, 0], one.sample("contact_duration")) for one in found]
    exact = [(alpha(one), contact_time(one)) for one in DEVIATIONS]
    rows: list = [[], []]
    for column, (axis, up) in enumerate(((ALPHA, Axis("density", "1/s (m/s)^0.2")), (CONTACT_TIME, DENSITY))):
        parts = []
        for place, deviation in enumerate(DEVIATIONS):
            parts.append(bars(samples[place][column], {**colour(place), "linewidth": 1.0, "alpha": 0.75}))
            parts.append(density(f"deviation of alpha {deviation:g}", exact[place][column], colour(place)))
        title = ("Figure 1: alpha", "Figure 2: contact time at 20 m/s")[column]
        rows[0].append(Panel(f"figure {1 + column}", f"{title}; steps are samples", axis, up, parts))
        widest = samples[-1][column]
        parts = [
            bars(widest),
            density("closed form", exact[-1][column], {**dashed(), "linestyle": "-"}),
            smoothed("reconstructed from the samples", widest, {**colour(5), "linestyle": "--"}),
        ]
        what = ("alpha", "contact time")[column]
        rows[1].append(Panel(f"figures 10, 11, {what}", f"Figures 10 and 11: {what}, deviation 6e-5", axis, up, parts))
    reading = [
        f"All three keep the mean contact time of {exact[0][1].mean():.4e} s; its deviation is "
        + ", ".join(f"{one.std():.3e}" for _, one in exact)
        + " s.",
        "The skewness is "
        + ", ".join(f"{float(one.stats('s')):+.3f}" for _, one in exact)
        + ": positive, the long tail lies to the right, though the text has it to the left.",
        "Gamma is what maximum entropy gives for a known mean and mean logarithm, not for a bounded second moment.",
    ]
    return Sheet("Two steel spheres: alpha and contact time", rows, f"{len(samples[0][0])} samples each", reading)


def speeds(quick: bool) -> Sheet:
    """Figures 3 to 7."""
    speed, axis = np.geomspace(1.0, 100.0, 81), Axis("speed", "m/s", log=True)
    times = np.linspace(0.0, contact_time(DEVIATIONS[0], 1.0).ppf(0.999), 240)
    heights = np.array([contact_time(DEVIATIONS[0], one).pdf(times) for one in speed]).T
    chart = Map("density", "1/s", speed, times, heights, "cividis", (0.0, float(np.quantile(heights, 0.995))))
    cuts = [
        density(f"{cut:g} m/s", contact_time(DEVIATIONS[0], cut), colour(place))
        for place, cut in enumerate((2, 5, 20, 100))
    ]
    rows = [
        [
            Panel("figure 3", "Figure 3: density over speed and contact time", axis, CONTACT_TIME, [chart]),
            Panel("figure 4", "Figure 4: the same, cut at four speeds", CONTACT_TIME, DENSITY, cuts),
        ],
        [],
    ]
    for place, deviation in enumerate(DEVIATIONS):
        ones = [contact_time(deviation, each) for each in speed]
        low, middle, high = (np.array([one.ppf(p) for one in ones]) for p in BOUNDS)
        parts = [
            Band("5 to 95 %", speed, low, high, shade()),
            Line("median", speed, middle, colour(0)),
            Line("mean", speed, [one.mean() for one in ones], {**colour(5), "linestyle": "--"}),
        ]
        title, up = f"Figure {5 + place}: deviation of alpha {deviation:g}", CONTACT_TIME._replace(limits=(0.0, 2.4e-4))
        rows[1].append(Panel(f"figure {5 + place}", title, axis, up, parts, "upper right"))
    bounds = "; ".join(", ".join(f"{contact_time(one).ppf(p):.4e}" for p in BOUNDS) for one in DEVIATIONS)
    reading = [
        f"5, 50 and 95 % of the contact time at 20 m/s for deviations 2, 4, 6e-5 of alpha: {bounds} s.",
        f"Every quantile falls as speed^-0.2: from 1 to 100 m/s by a factor {100.0**0.2:.4f}, at every probability.",
    ]
    return Sheet("Two steel spheres: contact time from 1 to 100 m/s", rows, "closed forms", reading)


def _histories(result):
    """Instants [s] and forces (n, instants) of the realisations that are whole."""
    runs = result.history("normal_load")
    kept = runs[np.isfinite(runs).all(axis=1)]
    settings = result.study.settings
    duration = settings.history_duration or load_scene(result.study.scene).parameters.run.duration
    return np.linspace(0.0, duration, runs.shape[1]), kept


def _statistics_panels(t, kept, mean_run, inputs, numbers, titles) -> list[list[Panel]]:
    """Six views of the force as a random process: runs and bands, quantiles, density, autocorrelation, correlations."""
    mean, std = kept.mean(axis=0), kept.std(axis=0, ddof=1)
    runs = [Line(f"run {place}", t, run, THIN, False) for place, run in enumerate(kept[:10])]
    band = [
        Band("mean ± deviation", t, mean - std, mean + std, shade()),
        *runs,
        Line("mean of the runs", t, mean, colour(5)),
        Line("run at the mean inputs", *mean_run, dashed()),
    ]
    low, middle, high = np.quantile(kept, BOUNDS, axis=0)
    quantiles = [Band("5 to 95 % at each instant", t, low, high, shade()), Line("median", t, middle, colour(0))]
    top = float(np.quantile(kept, 0.99, axis=0).max())
    edges = np.linspace(0.0, top, 121)
    heights = (
        np.array([np.histogram(column, edges, density=False)[0] for column in kept.T]).T
        / len(kept)
        / np.diff(edges)[:, None]
    )
    limit = float(np.quantile(heights[6:], 0.99))  # towards no force the density is that of runs out of contact
    cloud = Map("density", "1/N", t, 0.5 * (edges[1:] + edges[:-1]), heights, "cividis", (0.0, limit), 0.5)
    live = std > 1e-3 * std.max()
    with np.errstate(invalid="ignore", divide="ignore"):
        auto = np.clip(np.corrcoef(kept.T), -1.0, 1.0)
        along = [
            np.array([np.corrcoef(column, values)[0, 1] for column in kept[:, live].T]) for values in inputs.values()
        ]
    auto = np.where(np.outer(live, live), auto, np.nan)
    square = Map("correlation of F(t) and F(t')", "1", t, t, auto, "RdBu_r", (-1.0, 1.0))
    lines = [
        Line(f"with {name}", t[live], np.clip(one, -1.0, 1.0), colour(place))
        for place, (name, one) in enumerate(zip(inputs, along, strict=True))
    ]
    lines.append(Line("deviation / its greatest", t, std / std.max(), {**colour(5), "linestyle": "--"}))
    correlation = Axis("correlation of the force", limits=(-1.0, 1.0))
    return [
        [
            Panel(titles[0], titles[0], TIME, FORCE, band),
            Panel("quantiles", "Quantiles at each instant", TIME, FORCE, quantiles),
            Panel("correlation", "Correlation of the force with the inputs", TIME, correlation, lines),
        ],
        [
            Panel(titles[1], titles[1], TIME, FORCE, [cloud]),
            Panel(titles[2], titles[2], Axis("time t", "s"), Axis("time t'", "s"), [square]),
        ],
    ]


def _run_at(scene, keys=()) -> tuple[np.ndarray, np.ndarray]:
    """Time [s] and force [N] of a run."""
    blocks = list(simulate(load_scene(scene, keys)).blocks())
    time = 1e-9 * np.concatenate([block.time_ns for block in blocks])
    return time, np.concatenate([block.values["normal_load"] for block in blocks])


def _spheres_at(value: float) -> tuple[np.ndarray, np.ndarray]:
    keys = ("contact.normal=measured", f"contact.measured_alpha={value!r}", "run.duration=1e-4", "run.output_rate=2e7")
    return _run_at("two_spheres", keys)


def forces(quick: bool) -> Sheet:
    """Figure 8, and of the spheres what figures 17 to 24 show of discs."""
    result = study("spheres_alpha_4e-5", QUICK if quick else 0)
    t, kept = _histories(result)
    bounds = [_spheres_at(float(alpha(4e-5).ppf(p))) for p in BOUNDS]
    at_mean = _spheres_at(MEAN_ALPHA)
    parts = [
        Line(f"{100 * p:g} % of contact time", *one, colour(place))
        for place, (p, one) in enumerate(zip(BOUNDS, bounds, strict=True))
    ]
    parts.append(Line("mean alpha", *at_mean, dashed()))
    titles = "Mean and deviation, 10 runs", "Density of the force, as figure 19", "Autocorrelation, as figure 20"
    rows = _statistics_panels(t, kept, at_mean, {"alpha": result.values[: len(kept), 0]}, None, titles)
    rows[1].insert(0, Panel("figure 8", "Figure 8: runs at bounds of contact time", TIME, FORCE, parts))
    peaks = ", ".join(f"{one[1].max():.5g}" for one in bounds)
    reading = [
        f"Peak force of the runs at the 5, 50 and 95 % bounds of the contact time: {peaks} N; the 5 % bound of the "
        "contact time is the upper curve of the force.",
        f"The mean of the runs peaks at {kept.mean(axis=0).max():.4g} N, the run at the mean alpha at "
        f"{at_mean[1].max():.4g} N: they are not the same, and mean - deviation would pull, which no contact does.",
    ]
    return Sheet(
        "Two steel spheres at 20 m/s, deviation of alpha 4e-5: the force over time",
        rows,
        f"{len(kept)} samples",
        reading,
    )


SEEDS, MOST, CALLED = 200, 2000, 700  # studies, samples of each, the paper's number of realisations


def _paths(one, seeds: int = SEEDS):
    """Relative errors of deviation and mean (seeds, samples) as samples of a distribution are added."""
    sample = one.rvs(size=(seeds, MOST), random_state=np.random.default_rng(1))
    counts = np.arange(1, MOST + 1)
    mean = np.cumsum(sample, axis=1) / counts
    square = np.cumsum(sample**2, axis=1) / counts - mean**2
    with np.errstate(invalid="ignore", divide="ignore"):
        std = np.sqrt(np.maximum(square, 0.0) * counts / (counts - 1))
    return counts, std / one.std() - 1.0, mean / one.mean() - 1.0


def _bands(one, counts):
    """Half widths of the 95 % bands of deviation and mean, relative: sqrt((kurtosis - 1)/4n) and cv/sqrt(n)."""
    kurtosis = float(one.stats("k")) + 3.0
    return 1.96 * np.sqrt(0.25 * (kurtosis - 1.0) / counts), 1.96 * one.std() / one.mean() / np.sqrt(counts)


def _path_panel(key, title, counts, paths, band, bold=0) -> Panel:
    part = slice(20, None, 20)
    parts = [Band("95 % band", counts[part], -band[part], band[part], shade())]
    parts += [Line(f"seed {place}", counts[part], path[part], THIN, False) for place, path in enumerate(paths[:25])]
    parts.append(Line("one study", counts[part], paths[bold][part], colour(5)))
    parts.append(Line(f"{CALLED} realisations", [CALLED] * 2, [-0.3, 0.3], {**dashed(), "linewidth": 1.2}))
    return Panel(key, title, Axis("realisations"), Axis("relative error", limits=(-0.3, 0.3)), parts, "upper right")


def convergence(quick: bool) -> Sheet:
    """Figure 9, and the same of the mean: a path that settles early is luck."""
    one = contact_time(6e-5)
    counts, std, mean = _paths(one)
    of_std, of_mean = _bands(one, counts)
    lucky = int(np.argmin(np.abs(std[:, CALLED - 20 : CALLED + 20]).max(axis=1)))
    near = np.abs(std) < 0.01
    rows = [
        [
            _path_panel("figure 9", "Figure 9: the deviation", counts, std, of_std, lucky),
            _path_panel("mean", "The mean of the same studies", counts, mean, of_mean, lucky),
        ]
    ]
    reading = [
        f"The 95 % band of the deviation is ± {100.0 * of_std[CALLED - 1]:.1f} % at {CALLED} realisations and ± "
        f"{100.0 * of_std[-1]:.1f} % at {MOST}.",
        f"{near[:, CALLED - 1].sum()} of {SEEDS} studies are within 1 % at {CALLED}, "
        f"{near[:, CALLED - 1 :].all(axis=1).sum()} of them stay there up to {MOST}: a path that matches from about "
        f"{CALLED} on, like the paper's, is luck.",
    ]
    return Sheet(
        "Two steel spheres, deviation of alpha 6e-5: what Monte Carlo settles, and when",
        rows,
        f"{SEEDS} seeds",
        reading,
    )


class Changed:
    """The distribution of a contact time that a modulus decides, by a change of variable."""

    def __init__(self, scene: str, mean: float, deviation: float, *keys: str):
        shape = (mean / deviation) ** 2
        self.source = stats.gamma(shape, scale=mean / shape)
        self.moduli = self.source.ppf(np.concatenate([[1e-7], np.linspace(1e-3, 0.999, 31), [1.0 - 1e-7]]))
        times = []
        for value in self.moduli:
            modulus = f"disc.material.young_modulus={float(value)!r}"
            run = simulate(load_scene(scene, (*keys, modulus, "wanted.tolerance=1e-8")))
            for _ in run.blocks():
                pass
            times.append(run.report.figures["contact_duration_s"])
        self.time_of = PchipInterpolator(np.log(self.moduli), np.log(times))
        p = (np.arange(20000) + 0.5) / 20000
        values = self.times(self.source.ppf(p))
        self.average, self.deviation = float(values.mean()), float(values.std())

    def times(self, moduli):
        """Contact times [s] of moduli [Pa]."""
        return np.exp(self.time_of(np.log(moduli)))

    def line(self, name: str, look: dict) -> Line:
        """The density of the contact time."""
        moduli = np.geomspace(self.source.ppf(2e-4), self.source.ppf(1.0 - 1e-6), 400)[::-1]
        times = self.times(moduli)
        slope = np.abs(self.time_of(np.log(moduli), 1)) * times / moduli
        return Line(name, times, self.source.pdf(moduli) / slope, look)


@functools.cache
def line_discs(speed: float, law: str) -> Changed:
    """The discs of paper 3 in line contact, by a law, at a relative speed [m/s]."""
    return Changed("two_discs", 5e9, 1e9, f"motion.first_velocity={speed:g}", f"contact.normal={law}")


PRINTED = 1.52e-7  # what the paper calls the deviation of the contact time at 10 m/s [s]


def discs(quick: bool) -> Sheet:
    """Figures 13 and 14 at both speeds, and the same discs by the law for thick ones."""
    rows: list = [[], []]
    two, reading = [], []
    first = line_discs(10.0, "line")
    sample = first.source.rvs(size=MOST, random_state=np.random.default_rng(1))
    rows[0].append(
        Panel(
            "figure 13, modulus",
            "Figure 13: Young's modulus",
            MODULUS,
            Axis("density", "1/Pa"),
            [bars(sample), density("gamma", first.source, {**dashed(), "linestyle": "-"})],
        )
    )
    for place, speed in enumerate((10.0, 100.0)):
        one, johnson = line_discs(speed, "line"), line_discs(speed, "johnson")
        times = one.times(sample)
        parts = [bars(times), one.line("change of variable", {**dashed(), "linestyle": "-"})]
        rows[0].append(
            Panel(f"figure 13, {speed:g}", f"Figure 13: contact time at {speed:g} m/s", CONTACT_TIME, DENSITY, parts)
        )
        counts = np.arange(2, MOST + 1)
        std = np.array([times[:n].std(ddof=1) for n in counts[::20]]) / one.deviation - 1.0
        band = 1.96 * np.sqrt(0.5 / counts[::20])
        parts = [Band("95 % band", counts[::20], -band, band, shade()), Line("one study", counts[::20], std, colour(5))]
        rows[1].append(
            Panel(
                f"figure 14, {speed:g}",
                f"Figure 14: deviation at {speed:g} m/s",
                Axis("realisations"),
                Axis("relative error", limits=(-0.3, 0.3)),
                parts,
            )
        )
        two += [
            one.line(f"eq. (14), {speed:g} m/s", colour(place)),
            johnson.line(f"Johnson, {speed:g} m/s", {**colour(place), "linestyle": "--"}),
        ]
        reading.append(
            f"At {speed:g} m/s eq. (14) gives a mean contact time of {one.average:.5e} s with a deviation of "
            f"{one.deviation:.4e} s; Johnson's law of plane strain, fit for discs this thick, "
            f"{johnson.average / one.average:.3f} of its mean."
        )
    rows[1].append(Panel("two laws", "Contact time by two laws", CONTACT_TIME, DENSITY, two))
    printed = math.sqrt(PRINTED)
    reading.append(
        f"What the paper prints as a deviation of {PRINTED:g} s comes nearest as a variance, {printed:.2e} s as a "
        f"deviation: {100.0 * (1.0 - printed / first.deviation):.0f} % less than eq. (14) gives with the printed data."
    )
    return Sheet(
        "Two rubber discs by line contact: modulus gamma, mean 5e9 and deviation 1e9 Pa",
        rows,
        f"{MOST} samples",
        reading,
    )


def reversed_share(*keys: str) -> float:
    """The share of the impulse by which the force of the soft disc differs from the same backwards."""
    _, force = _run_at("soft_discs_mean", keys)
    force = force[: np.flatnonzero(force)[-1] + 2]  # from the touch to the first instant without force
    return float(np.abs(force - force[::-1]).sum() / (2.0 * force.sum()))


def soft_run(quick: bool) -> Sheet:
    """Figure 12: the disc on the wall, and its force by formulation."""
    made = simulate(load_scene("soft_discs_mean", ("run.output_rate=4000", "run.publish_rate=4000")))
    blocks, radius = list(made.blocks()), made.scene.parameters.disc.radius
    names = ("normal_load", "shape", "velocity")
    force, shape, velocity = (np.concatenate([block.values[name] for block in blocks]) for name in names)
    on_rim = np.hypot(shape[0][:, 0], shape[0][:, 1] - radius) > (1.0 - 1e-6) * radius  # at the touch
    outlines = []
    for place, row in enumerate((0, int(force.argmax()), int(np.flatnonzero(force)[-1]))):
        both = np.concatenate([shape[row][on_rim], shape[row][on_rim] * (-1.0, 1.0)])
        both = both[np.argsort(np.arctan2(both[:, 1] - both[:, 1].mean(), both[:, 0]))]
        outlines.append(Line(f"at {row / 4.0:.1f} ms", *np.concatenate([both, both[:1]]).T, colour(place)))
    outlines.append(Line("rigid wall", [-0.13, 0.13], [0.0, 0.0], {"color": STYLE["ink"], "linewidth": 3.0}))
    always, curves = ("run.output_rate=20000", "solver.allow_invalid=on"), []
    ways = {
        "St. Venant-Kirchhoff, plane strain": (),
        "the same, plane stress": ("plane=stress",),
        "neo-Hookean": ("formulation=neo_hookean",),
        "small strains": ("formulation=linear",),
    }
    for place, (name, more) in enumerate(ways.items()):
        curves.append(Line(name, *_run_at("soft_discs_mean", (*always, *more)), colour(place)))
    across, up = Axis("along the wall", "m"), Axis("above the wall", "m")
    title = "Figure 12: a soft disc meets a rigid wall"
    rows = [
        [
            Panel("figure 12", title, across, up, outlines, "center", True),
            Panel("formulations", "Force at the mean inputs", TIME, FORCE, curves),
        ]
    ]
    fine = ("run.output_rate=2e5", always[1])
    here, linear = reversed_share(*fine), reversed_share(*fine, "formulation=linear")
    slow = reversed_share(*fine, "motion.first_velocity=0.01")
    reading = [
        f"The disc leaves with {abs(velocity[-1]):.4f} m/s of the {abs(velocity[0]):.3g} m/s it came with.",
        f"The force is not symmetrical under time reversal: backwards it differs by {here:.1%} of the impulse. Waves "
        f"in the disc do that, not large strains: by small strains it is {linear:.1%}, at 0.01 m/s {slow:.1%}.",
    ]
    return Sheet("A soft disc on a rigid wall at 1 m/s", rows, "soft_discs_mean", reading)


def one_mode(values: np.ndarray) -> float:
    """The p-value that a sample has at most one mode; NaN where too many values are exactly 0 for a density."""
    try:
        return min(modality(values, 1).p_value, 1.0)
    except StatisticError:
        return math.nan


def _case(name: str, figure: int, title: str, quick: bool) -> Sheet:
    """Four figures of a case of soft discs."""
    result = study(name, FEW if quick else 0)
    runs = result.history("normal_load")
    whole = np.isfinite(runs).all(axis=1)
    t, kept = _histories(result)
    mean, std = kept.mean(axis=0), kept.std(axis=0, ddof=1)
    duration = float(np.nanmean(result.sample("contact_duration")))
    after = np.flatnonzero((np.arange(len(t)) > mean.argmax()) & (t < 0.8 * duration))
    least = int(after[std[after].argmin()])
    inputs = {"Young's modulus": result.values[whole, 0], "Poisson's ratio": result.values[whole, 1]}
    at_mean = _run_at("soft_discs_mean", ("run.output_rate=20000",))
    titles = (
        f"Figure {figure}: 10 runs, mean, mean ± deviation",
        f"Figure {figure + 2}: density of the force",
        f"Figure {figure + 3}: autocorrelation",
    )
    rows = _statistics_panels(t, kept, at_mean, inputs, None, titles)
    values = kept[:, least]
    parts = [bars(values), smoothed("smoothed", values, colour(0))]
    rows[0][1] = Panel(
        f"figure {figure + 1}",
        f"Figure {figure + 1}: force at {1e3 * t[least]:.1f} ms",
        FORCE,
        Axis("density", "1/N", limits=(0.0, None)),
        parts,
    )
    inside = np.flatnonzero(mean > 0.2 * mean.max())
    places = np.unique(np.linspace(inside[0], inside[-1], 5 if quick else 25).astype(int))
    p = [one_mode(kept[:, place]) for place in places]
    parts = [
        Line("at most one mode", t[places], p, {**colour(0), "marker": "o"}),
        Line("5 %", t[places], [0.05] * len(places), dashed()),
    ]
    rows[1].append(
        Panel("modality", "Modality over time, by bootstrap", TIME, Axis("p-value", limits=(0.0, 1.0)), parts)
    )
    change = np.array([np.corrcoef(column, inputs["Young's modulus"])[0, 1] for column in kept[:, after].T])
    crossed = t[after][int(np.argmax(change < 0.0))] if (change < 0.0).any() else math.nan
    reading = [
        f"The force scatters least at {1e3 * t[least]:.2f} ms, {t[least] / duration:.3f} of the mean contact time of "
        f"{1e3 * duration:.2f} ms; it is {mean[least]:.4g} N there, with a deviation of {std[least]:.3g} N.",
        f"The correlation of the force with the modulus changes its sign at {1e3 * crossed:.2f} ms: a stiffer disc "
        "pushes more before, and less after.",
        f"That the force has one mode at most at that instant has a p-value of {one_mode(values):.2g}.",
        f"{int((~whole).sum())} of {len(whole)} realisations collapsed and are left out of all statistics.",
    ]
    return Sheet(title, rows, f"{len(whole)} samples", reading)


def soft_fast(quick: bool) -> Sheet:
    """Figures 15 and 16: small and large deformation."""
    result = study("soft_discs_fast", FEW if quick else 0)
    times, moduli = result.sample("contact_duration"), result.values[:, 0]
    times = times[np.isfinite(times)]
    slow, small, johnson = line_discs(10.0, "line"), line_discs(100.0, "line"), line_discs(100.0, "johnson")
    rows = [
        [
            Panel(
                "figure 15, modulus",
                "Figure 15: Young's modulus",
                MODULUS,
                Axis("density", "1/Pa"),
                [bars(moduli), density("gamma", small.source, {**dashed(), "linestyle": "-"})],
            ),
            Panel(
                "figure 15, small",
                "Figure 15: 10 m/s by eq. (14)",
                CONTACT_TIME,
                DENSITY,
                [slow.line("change of variable", colour(0))],
            ),
        ],
        [
            Panel("figure 15, large", "Figure 15: 100 m/s by finite elasticity", CONTACT_TIME, DENSITY, [bars(times)]),
            Panel(
                "figure 16",
                "Figure 16: contact time at 100 m/s",
                CONTACT_TIME,
                DENSITY,
                [
                    small.line("eq. (14), small deformation", colour(0)),
                    johnson.line("Johnson, small deformation", colour(1)),
                    smoothed("finite elasticity", times, {**colour(5), "linestyle": "--"}),
                ],
            ),
        ],
    ]
    reading = [
        f"Finite elasticity gives a mean contact time of {times.mean():.4e} s at 100 m/s with a deviation of "
        f"{times.std(ddof=1):.3e} s; eq. (14) {small.average:.4e} and {small.deviation:.3e} s, Johnson's law "
        f"{johnson.average:.4e} and {johnson.deviation:.3e} s.",
    ]
    return Sheet(
        "Two rubber discs at 100 m/s: small against large deformation", rows, f"{len(moduli)} samples", reading
    )


CASES = {
    "soft_case1": ("soft_discs_case1", 17, "Soft discs, case 1: deviation of the modulus a fifth"),
    "soft_case2": ("soft_discs_case2", 21, "Soft discs, case 2: deviation of the modulus two fifths"),
}
CHARTS = {
    "paper3": Paper(
        {
            "densities": Figures((1, 2, 10, 11), densities),
            "speeds": Figures((3, 4, 5, 6, 7), speeds),
            "forces": Figures((8,), forces),
            "convergence": Figures((9,), convergence),
            "discs": Figures((13, 14), discs),
            "soft_run": Figures((12,), soft_run),
            "soft_fast": Figures((15, 16), soft_fast),
            **{
                name: Figures(tuple(range(row[1], row[1] + 4)), functools.partial(_case, *row))
                for name, row in CASES.items()
            },
        }
    )
}
