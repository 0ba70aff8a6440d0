"""Paper 3 (Buezas, Rosales, Sampaio 2012), figures 1 to 24: impacts of spheres and discs with uncertain inputs.

Spheres: alpha is gamma, the contact time alpha v^-0.2, so its density is known; histograms are studies. Discs by line
contact: the density of the contact time follows from that of the modulus by a change of variable. Soft discs: studies
of finite elasticity.
"""

import functools

import numpy as np
from scipy import stats
from scipy.interpolate import CubicSpline

from bearing_twin.charts.contest import Figures, Paper
from bearing_twin.charts.scenes import run_scene
from bearing_twin.pictures import (
    OUTSIDE,
    STYLE,
    Axis,
    Band,
    Line,
    Map,
    Panel,
    Sheet,
    band_style,
    line_style,
    reference_style,
)
from bearing_twin.uq.distributions import DISTRIBUTIONS, greatest_entropy
from bearing_twin.uq.propagation import Derived
from bearing_twin.uq.realisations import exact_distributions, task_of
from bearing_twin.uq.run import run_study
from bearing_twin.uq.statistics import histogram, kernel_density, modality
from bearing_twin.uq.study import load_study

MEAN_ALPHA, DEVIATIONS = 1.138e-4, (2e-5, 4e-5, 6e-5)
ALPHA = Axis("alpha", "s (m/s)^0.2")
CONTACT_TIME, MODULUS = Axis("contact time", "s"), Axis("Young's modulus", "Pa")
TIME, FORCE = Axis("time since first touch", "s"), Axis("contact force", "N")
BOUNDS = (0.05, 0.5, 0.95)
THIN = {"color": STYLE["edge"], "linewidth": 0.8, "alpha": 0.9}
SOLID, FILLED = {**reference_style(), "linestyle": "-"}, {"step": "post", "color": "#b9c6d2"}
QUICK, FEW = 200, 60  # samples of a quick study, of one by finite elasticity


def gamma(mean: float, deviation: float):
    """The gamma distribution of this mean and deviation."""
    shape = (mean / deviation) ** 2
    return stats.gamma(shape, scale=mean / shape)


def entropy(distribution) -> float:
    """The entropy of a distribution [nat], the mean of -ln of its density, over evenly spaced quantiles."""
    return -float(np.mean(np.log(distribution.pdf(distribution.ppf((np.arange(20_000) + 0.5) / 20_000)))))


def contact_time(deviation: float, speed: float = 20.0):
    """The distribution of the contact time [s] of two spheres, by the deviation of alpha and the speed [m/s]."""
    return gamma(MEAN_ALPHA * speed**-0.2, deviation * speed**-0.2)


@functools.lru_cache(maxsize=4)
def study(name: str, samples: int, *overrides: str):
    """The result of a shipped study, without its sweep; `samples` 0: as many as shipped."""
    few = (f"samples={samples}",) if samples else ()
    return run_study(load_study(name, ["modality=no", "sweep=", "method=ensemble", *few, *overrides]))


@functools.cache
def discs_in_line_contact(speed: float, law: str) -> Derived:
    """The distribution of the contact time [s] of the discs of paper 3, by a law, at a relative speed [m/s]."""
    overrides = f"motion.first_velocity={speed:g}", f"contact.normal={law}", "quantities=[contact_duration]"
    discs = load_study("discs_small_10", overrides)
    return exact_distributions(discs, task_of(discs), "change_of_variable")["contact_duration"]


def bars(sample: np.ndarray, style: dict | None = None) -> Band | Line:
    """The histogram of a sample, by the rule of Freedman and Diaconis: filled, or its outline in a style."""
    edges, heights = histogram(sample)
    name, up = f"{np.isfinite(sample).sum()} samples", np.append(heights, 0.0)
    return Line(name, edges, up, style, False) if style else Band(name, edges, np.zeros_like(up), up, FILLED)


def density(name: str, distribution, style: dict) -> Line:
    """The density of a distribution over all but a negligible part of it."""
    quantile = distribution.quantile if isinstance(distribution, Derived) else distribution.ppf
    x = np.linspace(quantile(1e-6), quantile(1.0 - 5e-4), 301)
    return Line(name, x, distribution.pdf(x), style)


def smoothed(name: str, sample: np.ndarray, style: dict) -> Line:
    """The kernel density of a sample."""
    return Line(name, *kernel_density(sample), style)


def density_panel(title: str, axis: Axis, *parts) -> Panel:
    """A panel of densities and histograms."""
    return Panel(title, axis, Axis("density", f"1/{axis.unit}", limits=(0.0, None)), [*parts])


def densities(quick: bool) -> Sheet:
    """Figures 1, 2, 10 and 11."""
    rows: list = [[], []]
    names = [f"spheres_alpha_{1e5 * deviation:.0f}e-5" for deviation in DEVIATIONS]
    overrides = "histories=[]", "quantities=[contact_duration]"
    results = [study(name, QUICK if quick else 0, *overrides) for name in names]
    exact = [contact_time(deviation) for deviation in DEVIATIONS]
    alphas = [result.values[:, 0] for result in results], [gamma(MEAN_ALPHA, deviation) for deviation in DEVIATIONS]
    times = [result.sample("contact_duration") for result in results], exact
    for title, axis, (samples, truths) in (
        ("Figure 1: alpha", ALPHA, alphas),
        ("Figure 2: contact time at 20 m/s", CONTACT_TIME, times),
    ):
        lines = (
            density(f"deviation of alpha {deviation:g}", truth, style)
            for deviation, truth, style in zip(DEVIATIONS, truths, COLOURS, strict=True)
        )
        rows[0].append(density_panel(title, axis, *map(bars, samples, PALE), *lines))
        again = smoothed("reconstructed from the samples", samples[-1], {**line_style(5), "linestyle": "--"})
        compared = bars(samples[-1]), density("closed form", truths[-1], SOLID)
        rows[1].append(density_panel(f"Figures 10 and 11: {axis.name}, deviation 6e-5", axis, *compared, again))
    known = {"positive": True, "mean": MEAN_ALPHA, "std": DEVIATIONS[-1]}
    name, numbers = greatest_entropy(known)
    widest, drawn = DISTRIBUTIONS[name].build(**numbers), gamma(MEAN_ALPHA, DEVIATIONS[-1])
    words = name.replace("_", " ")
    rows[1][0].parts.append(density(f"maximum entropy: {words}", widest, {**line_style(1), "linestyle": ":"}))
    spreads = ", ".join(f"{distribution.std():.3e}" for distribution in exact)
    reading = [
        f"All three keep the mean contact time of {exact[0].mean():.4e} s; its deviation is {spreads} s.",
        f"With mean and deviation of alpha known, the distribution of maximum entropy is the {words}, with "
        f"{entropy(widest) - entropy(drawn):.3f} nat more than gamma at a deviation of {DEVIATIONS[-1]:g}.",
    ]
    return Sheet("Two steel spheres: alpha and contact time", rows, f"{len(results[0].values)} samples each", reading)


COLOURS = [line_style(index) for index in range(len(DEVIATIONS))]
PALE = [style | {"linewidth": 1.0, "alpha": 0.75, "drawstyle": "steps-post"} for style in COLOURS]


def speeds(quick: bool) -> Sheet:
    """Figures 3 to 7."""
    speed, axis = np.geomspace(1.0, 100.0, 81), Axis("speed", "m/s", log=True)
    times = np.linspace(0.0, contact_time(DEVIATIONS[0], 1.0).ppf(0.999), 240)
    heights = contact_time(DEVIATIONS[0], speed).pdf(times[:, None])
    cloud = Map("density", "1/s", speed, times, heights, "cividis", (0.0, float(np.quantile(heights, 0.995))))
    cuts = (
        density(f"{cut} m/s", contact_time(DEVIATIONS[0], cut), line_style(index))
        for index, cut in enumerate((2, 5, 20, 100))
    )
    rows = [
        [
            Panel("Figure 3: density over speed and contact time", axis, CONTACT_TIME, [cloud]),
            density_panel("Figure 4: the same, cut at four speeds", CONTACT_TIME, *cuts),
        ],
        [],
    ]
    for figure, deviation in enumerate(DEVIATIONS, start=5):
        distribution = contact_time(deviation, speed)
        low, middle, high = map(distribution.ppf, BOUNDS)
        parts = [
            Band("5 to 95 %", speed, low, high, band_style()),
            Line("median", speed, middle, line_style(0)),
            Line("mean", speed, distribution.mean(), {**line_style(5), "linestyle": "--"}),
        ]
        up = CONTACT_TIME._replace(limits=(0.0, 2.4e-4))
        rows[1].append(Panel(f"Figure {figure}: deviation of alpha {deviation:g}", axis, up, parts, "upper right"))
    reading = [
        f"With a deviation of alpha of {DEVIATIONS[-1]:g} 5 to 95 % of contact times are {1e6 * low[0]:.4g} to "
        f"{1e6 * high[0]:.4g} µs at 1 m/s, {1e6 * low[-1]:.4g} to {1e6 * high[-1]:.4g} µs at 100 m/s."
    ]
    return Sheet("Two steel spheres: contact time from 1 to 100 m/s", rows, "closed forms", reading)


def force_panels(result, figures: tuple[str, str, str]) -> list[list[Panel]]:
    """The force as a random process: runs and bands, correlations with inputs, density, autocorrelation.

    All but the density are statistics of the study.
    """
    statistics, histories = result.summary["histories"]["normal_load"], result.history("normal_load")
    complete, t = histories[np.isfinite(histories).all(axis=1)], np.array(statistics["time_s"])
    mean, std = np.array(statistics["mean"]), np.array(statistics["std"])
    band = [
        Band("mean ± deviation", t, mean - std, mean + std, band_style()),
        *(Line(f"run {index}", t, history, THIN, False) for index, history in enumerate(complete[:10])),
        Line("mean of the runs", t, mean, line_style(5)),
        Line("run at the mean inputs", t, statistics["at_mean_inputs"], reference_style()),
    ]
    edges = np.linspace(0.0, float(np.quantile(complete, 0.99, axis=0).max()), 121)
    counts = np.array([np.histogram(column, edges)[0] for column in complete.T]).T
    heights = counts / len(complete) / np.diff(edges)[:, None]
    limit = float(np.quantile(heights[6:], 0.99))  # towards no force the density is that of runs out of contact
    cloud = Map("density", "1/N", t, 0.5 * (edges[1:] + edges[:-1]), heights, "cividis", (0.0, limit), 0.5)
    instants, matrix = statistics["autocorrelation_time_s"], np.array(statistics["autocorrelation"])
    square = Map("correlation of F(t) and F(t')", "1", instants, instants, matrix, "RdBu_r", (-1.0, 1.0))
    lines = [
        Line(
            f"with {source.key.rpartition('.')[2].replace('_', ' ')}",
            t,
            statistics[f"correlation with {source.key}"],
            line_style(n),
        )
        for n, source in enumerate(result.study.inputs)
    ]
    lines.append(Line("deviation / its greatest", t, std / std.max(), {**line_style(5), "linestyle": "--"}))
    correlation = Axis("correlation of the force", limits=(-1.0, 1.0))
    return [
        [
            Panel(f"{figures[0]}10 runs, mean ± deviation", TIME, FORCE, band),
            Panel("Correlation of the force with the inputs", TIME, correlation, lines, OUTSIDE),
        ],
        [
            Panel(f"{figures[1]}density of the force", TIME, FORCE, [cloud]),
            Panel(f"{figures[2]}autocorrelation", Axis("time t", "s"), Axis("time t'", "s"), [square]),
        ],
    ]


def force_of(scene: str, *keys: str) -> tuple[np.ndarray, np.ndarray]:
    """Time [s] and force [N] of a run."""
    data = run_scene(scene, keys, ("normal_load",))
    return data.time, data.values["normal_load"]


def forces(quick: bool) -> Sheet:
    """Figure 8, and of the spheres what figures 17 to 24 show of discs."""
    result = study("spheres_alpha_4e-5", QUICK if quick else 0)
    rows, measured = force_panels(result, ("", "As figure 19: ", "As figure 20: ")), "contact.normal=measured"
    overrides = measured, "run.duration=1e-4", "run.output_rate=2e7"
    values = [float(gamma(MEAN_ALPHA, 4e-5).ppf(p)) for p in BOUNDS]
    parts = [
        Line(
            f"{100 * p:g} % of contact time",
            *force_of("two_spheres", *overrides, f"contact.measured_alpha={alpha!r}"),
            line_style(index),
        )
        for index, (p, alpha) in enumerate(zip(BOUNDS, values, strict=True))
    ]
    statistics = result.summary["histories"]["normal_load"]
    parts.append(Line("mean alpha", statistics["time_s"], statistics["at_mean_inputs"], reference_style()))
    rows[1].insert(0, Panel("Figure 8: runs at bounds of contact time", TIME, FORCE, parts))
    pulls = min(np.subtract(statistics["mean"], statistics["std"])) < 0.0
    reading = [
        f"The mean of the runs peaks at {max(statistics['mean']):.4g} N, the run at the mean alpha at "
        f"{max(statistics['at_mean_inputs']):.4g} N: they are not the same"
        + (", and mean - deviation would pull, which no contact does." if pulls else ".")
    ]
    title = "Two steel spheres at 20 m/s, deviation of alpha 4e-5: the force over time"
    return Sheet(title, rows, f"{statistics['realisations']} samples", reading)


SEEDS, SAMPLES, PAPER_SAMPLES = 200, 2000, 700  # studies, samples of each, samples of the paper
COUNTS = np.arange(1, SAMPLES + 1)


def paths(title: str, errors: np.ndarray, band: np.ndarray, marked: int = 0, *further: Line) -> Panel:
    """Relative errors (n, SAMPLES) of studies over their realisations in their 95 % band, one of them marked."""
    part = slice(20, None, 20)
    parts = [Band("95 % band", COUNTS[part], -band[part], band[part], band_style())]
    parts += [Line(f"seed {index}", COUNTS[part], path[part], THIN, False) for index, path in enumerate(errors[1:25])]
    parts += [Line("one study", COUNTS[part], errors[marked][part], line_style(5)), *further]
    return Panel(title, Axis("realisations"), Axis("relative error", limits=(-0.3, 0.3)), parts, "upper right")


def deviations(sample: np.ndarray) -> np.ndarray:
    """Standard deviations (n, SAMPLES) of the first samples of (n, SAMPLES), NaN for one."""
    mean = np.cumsum(sample, axis=1) / COUNTS
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.sqrt(np.maximum(np.cumsum(sample**2, axis=1) / COUNTS - mean**2, 0.0) * COUNTS / (COUNTS - 1))


def convergence(quick: bool) -> Sheet:
    """Figure 9: paths of the standard deviation over the realisations."""
    distribution = contact_time(6e-5)
    sample = distribution.rvs(size=(SEEDS, SAMPLES), random_state=np.random.default_rng(1))
    std = deviations(sample) / distribution.std() - 1.0
    of_std = 1.96 * np.sqrt(0.25 * (float(distribution.stats("k")) + 2.0) / COUNTS)
    lucky = int(np.argmin(np.abs(std[:, PAPER_SAMPLES - 20 : PAPER_SAMPLES + 20]).max(axis=1)))
    style = {**reference_style(), "linewidth": 1.2}
    marker = Line(f"{PAPER_SAMPLES} realisations", [PAPER_SAMPLES] * 2, [-0.3, 0.3], style)
    panels = [paths("Figure 9: the deviation", std, of_std, lucky, marker)]
    near = np.abs(std[:, PAPER_SAMPLES - 1 :]) < 0.01
    reading = [
        f"{near[:, 0].sum()} of {SEEDS} studies are within 1 % at {PAPER_SAMPLES}, {near.all(axis=1).sum()} of them "
        f"stay there up to {SAMPLES}: a path that matches from about {PAPER_SAMPLES} on, like the paper's, is luck.",
    ]
    title = "Two steel spheres, deviation of alpha 6e-5: convergence of Monte Carlo sampling"
    return Sheet(title, [panels], f"{SEEDS} seeds", reading)


PRINTED = {10.0: 1.52e-7, 100.0: 1.94e-7}  # s: the paper's deviations of the contact time, by speed [m/s]


def discs(quick: bool) -> Sheet:
    """Figures 13 and 14 at both speeds."""
    modulus = gamma(5e9, 1e9)
    sample = modulus.rvs(size=SAMPLES, random_state=np.random.default_rng(1))
    drawn = bars(sample), density("gamma", modulus, SOLID)
    rows = [[density_panel("Figure 13: Young's modulus", MODULUS, *drawn)], []]
    reading = []
    for speed, printed in PRINTED.items():
        distribution = discs_in_line_contact(speed, "line")
        times = distribution.function(sample)
        parts = bars(times), density("change of variable", distribution, SOLID)
        rows[0].append(density_panel(f"Figure 13: contact time at {speed:g} m/s", CONTACT_TIME, *parts))
        std = deviations(times[None]) / distribution.std - 1.0
        rows[1].append(paths(f"Figure 14: deviation at {speed:g} m/s", std, 1.96 * np.sqrt(0.5 / COUNTS)))
        reading.append(
            f"At {speed:g} m/s eq. (14) gives a mean contact time of {distribution.mean:.4e} s with a deviation of "
            f"{distribution.std:.3e} s; the printed {printed:g} s is {printed / distribution.std:.2g} of it, or "
            f"{printed**0.5 / distribution.std:.2g} if read as a variance."
        )
    title = "Two rubber discs by line contact: modulus gamma, mean 5e9 and deviation 1e9 Pa"
    return Sheet(title, rows, f"{SAMPLES} samples", reading)


def reversed_share(*keys: str) -> float:
    """The share of the impulse by which the force of the soft disc differs from the same backwards."""
    force = force_of("soft_discs_mean", *keys)[1]
    force = force[: np.flatnonzero(force)[-1] + 2]  # from the touch to the first instant without force
    return float(np.abs(force - force[::-1]).sum() / (2.0 * force.sum()))


def soft_run(quick: bool) -> Sheet:
    """Figure 12: the disc on the wall, and how far its force is from the same backwards."""
    data = run_scene("soft_discs_mean", ("run.output_rate=4000",), ("normal_load", "shape"))
    force, shape = data.values.values()
    radius, outlines = data.scene.parameters.disc.radius, []
    on_rim = np.hypot(shape[0][:, 0], shape[0][:, 1] - radius) > (1.0 - 1e-6) * radius  # at the touch
    for index, row in enumerate((0, int(force.argmax()), int(np.flatnonzero(force)[-1]))):
        rim = np.concatenate([shape[row][on_rim], shape[row][on_rim] * (-1.0, 1.0)])
        rim = rim[np.argsort(np.arctan2(rim[:, 1] - rim[:, 1].mean(), rim[:, 0]))]
        outlines.append(Line(f"at {row / 4.0:.1f} ms", *np.concatenate([rim, rim[:1]]).T, line_style(index)))
    outlines.append(Line("rigid wall", [-0.13, 0.13], [0.0, 0.0], {"color": STYLE["ink"], "linewidth": 3.0}))
    always = "solver.allow_invalid=on"
    across, up = Axis("along the wall", "m"), Axis("above the wall", "m")
    panel = Panel("Figure 12: a soft disc meets a rigid wall", across, up, outlines, "center", True)
    finite, linear, slow = (
        reversed_share("run.output_rate=2e5", always, *overrides)
        for overrides in ((), ("formulation=linear",), ("motion.first_velocity=0.01",))
    )
    reading = [
        f"The force is not symmetrical under time reversal: backwards it differs by {finite:.1%} of the impulse. Waves "
        f"in the disc do that, not large strains: by small strains it is {linear:.1%}, at 0.01 m/s {slow:.1%}.",
    ]
    return Sheet("A soft disc on a rigid wall at 1 m/s", [[panel]], "soft_discs_mean", reading)


def least_spread(t: np.ndarray, mean: np.ndarray, std: np.ndarray) -> tuple[float, slice] | None:
    """The instant of least deviation after the peak of the mean, and the instants it is searched among; None without.

    Below a quarter of the peak only the longest contacts are left, and the deviation falls to zero.
    """
    peak = int(np.argmax(mean))
    near = slice(peak, int(np.flatnonzero(mean >= 0.25 * mean[peak])[-1]) + 1)
    curve = CubicSpline(t[near], std[near])
    turns = curve.derivative().roots(extrapolate=False)
    least = turns[curve(turns, 2) > 0.0]
    return (float(least[np.argmin(curve(least))]), near) if len(least) else None


def sign_change(t: np.ndarray, correlation: np.ndarray, instant: float) -> list[str]:
    """A sentence on the change of sign of the correlation with the modulus nearest to an instant [s]; none without."""
    curve = CubicSpline(t, correlation)
    roots = curve.roots(extrapolate=False)
    if not len(roots):
        return []
    root = roots[np.argmin(np.abs(roots - instant))]
    before, after = ("more", "less") if curve(root, 1) < 0.0 else ("less", "more")
    return [
        f"The correlation of the force with the modulus changes its sign {1e3 * abs(root - instant):.2f} ms "
        f"{'later' if root > instant else 'earlier'}: a stiffer disc pushes {before} before, and {after} after."
    ]


def soft_case(name: str, figure: int, title: str, quick: bool) -> Sheet:
    """Four figures of a case of soft discs."""
    result = study(name, FEW if quick else 0)
    runs, statistics = result.history("normal_load"), result.summary["histories"]["normal_load"]
    complete, t = runs[np.isfinite(runs).all(axis=1)], np.array(statistics["time_s"])
    rows = force_panels(result, tuple(f"Figure {figure + number}: " for number in (0, 2, 3)))
    failed = f"{len(runs) - len(complete)} of {len(runs)} realisations collapsed and are left out of all statistics."
    if (least := least_spread(t, np.array(statistics["mean"]), np.array(statistics["std"]))) is None:
        return Sheet(title, rows, f"{len(runs)} samples", ["The histories have no least deviation.", failed])
    instant, near = least
    values = complete[:, int(np.argmin(np.abs(t - instant)))]
    title_of_density = f"Figure {figure + 1}: force at {1e3 * instant:.1f} ms"
    rows[0].insert(1, density_panel(title_of_density, FORCE, bars(values), smoothed("smoothed", values, line_style(0))))
    duration = result.summary["quantities"]["contact_duration"]["mean"]
    reading = [
        f"The force scatters least at {1e3 * instant:.2f} ms, {instant / duration:.3f} of the mean contact time of "
        f"{1e3 * duration:.2f} ms; it is {values.mean():.4g} N there, with a deviation of {values.std(ddof=1):.3g} N.",
        f"That the force has one mode at most at that instant has a p-value of {modality(values, 1).p_value:.2g}.",
        failed,
        *sign_change(t[near], np.array(statistics["correlation with disc.material.young_modulus"])[near], instant),
    ]
    return Sheet(title, rows, f"{len(runs)} samples", reading)


def soft_fast(quick: bool) -> Sheet:
    """Figures 15 and 16: small and large deformation."""
    result = study("soft_discs_fast", FEW if quick else 0)
    times, moduli = result.sample("contact_duration"), result.values[:, 0]
    times = times[np.isfinite(times)]
    slow, small, johnson = (
        discs_in_line_contact(*speed_and_law) for speed_and_law in ((10.0, "line"), (100.0, "line"), (100.0, "johnson"))
    )
    compared = (
        density("eq. (14), small deformation", small, line_style(0)),
        density("Johnson, small deformation", johnson, line_style(1)),
        smoothed("finite elasticity", times, {**line_style(5), "linestyle": "--"}),
    )
    by_line, by_gamma = density("change of variable", slow, line_style(0)), density("gamma", gamma(5e9, 1e9), SOLID)
    rows = [
        [
            density_panel("Figure 15: Young's modulus", MODULUS, bars(moduli), by_gamma),
            density_panel("Figure 15: 10 m/s by eq. (14)", CONTACT_TIME, by_line),
        ],
        [
            density_panel("Figure 15: 100 m/s by finite elasticity", CONTACT_TIME, bars(times)),
            density_panel("Figure 16: contact time at 100 m/s", CONTACT_TIME, *compared),
        ],
    ]
    reading = [
        f"Finite elasticity gives a mean contact time of {times.mean():.4e} s at 100 m/s with a deviation of "
        f"{times.std(ddof=1):.3e} s; eq. (14) {small.mean:.4e} and {small.std:.3e} s, Johnson's law "
        f"{johnson.mean:.4e} and {johnson.std:.3e} s.",
    ]
    title = "Two rubber discs at 100 m/s: small against large deformation"
    return Sheet(title, rows, f"{len(moduli)} samples", reading)


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
                name: Figures(tuple(range(row[1], row[1] + 4)), functools.partial(soft_case, *row))
                for name, row in CASES.items()
            },
        }
    )
}
