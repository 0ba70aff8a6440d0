"""Paper 3, figures 12 and 15 to 24: soft discs by finite elasticity, their modulus and Poisson's ratio uncertain."""

import numpy as np

from bearing_twin.charts.sheets import Axis, Line, Panel, Sheet
from bearing_twin.charts.study_discs import MODULUS
from bearing_twin.charts.study_forces import FORCE, TIME, autocorrelation_map, dashed, density_map, mean_and_deviation
from bearing_twin.charts.study_samples import CONTACT_TIME, bars, colour, density_line, known
from bearing_twin.charts.study_spheres import DENSITY
from bearing_twin.errors import StatisticError
from bearing_twin.kinds.soft_discs.mesh import half_disc
from bearing_twin.kinds.soft_discs.motion import duration_and_touches
from bearing_twin.kinds.soft_discs.solve import solve
from bearing_twin.pictures.style import STYLE
from bearing_twin.run.scene import load_scene
from bearing_twin.uq.histories import narrowing
from bearing_twin.uq.modality import modality
from bearing_twin.uq.realisations import mean_inputs, realise, task_of
from bearing_twin.uq.run import run_study
from bearing_twin.uq.statistics import natural_density
from bearing_twin.uq.study import load_study
from bearing_twin.uq.summary import history_statistics

WIDTH, HEIGHT = Axis("along the wall", "m"), Axis("above the wall", "m")
SHOWN = 10  # single runs
INSTANTS = 25  # at which modes are counted
REVERSED = {"1 m/s": (), "1 m/s, small strains": ("formulation=linear",), "0.01 m/s": ("motion.first_velocity=0.01",)}
SHARES = np.linspace(0.0, 1.0, 801)
SHARE, OF_PEAK = Axis("share of the contact time", "1"), Axis("force over its peak", "1")
FORMULATIONS = {"stvk": "St. Venant-Kirchhoff", "neo_hookean": "neo-Hookean", "linear": "linear"}


def soft_run(update) -> Sheet:
    """Figure 12: the disc on the wall, and the force by three formulations and both planes."""
    parameters = load_scene("soft_discs_mean").parameters
    found = solve(parameters)
    update(0.3)
    mesh = half_disc(parameters.mesh.divisions, parameters.mesh.order, parameters.mesh.integration)
    force = found.column("force")
    instants = found.step * np.array([0.0, np.argmax(force), np.flatnonzero(force)[-1]])
    outlines = []
    for place, (time, shape) in enumerate(zip(instants, found.shape_at(parameters.disc.radius, instants), strict=True)):
        rim = shape[mesh.outline]
        rim = np.concatenate([rim, rim[::-1] * (-1.0, 1.0)])
        outlines.append(Line(f"at {1e3 * time:.1f} ms", rim[:, 0], rim[:, 1], colour(place)))
    wall = {"color": STYLE["ink"], "linewidth": 3.0}
    edge = 1.3 * parameters.disc.radius
    outlines.append(Line("rigid wall", [-edge, edge], [0.0, 0.0], wall))
    curves = []
    for place, (word, text) in enumerate(FORMULATIONS.items()):
        for plane, look in (("strain", "-"), ("stress", "--")):
            other = solve(load_scene("soft_discs_mean", [f"formulation={word}", f"plane={plane}"]).parameters, 2)
            times = other.step * np.arange(len(other.history))
            curves.append(
                Line(f"{text}, plane {plane}", times, other.column("force"), {**colour(place), "linestyle": look})
            )
        update(0.3 + 0.5 * (place + 1) / len(FORMULATIONS))
    shares, turned = _reversed(update)
    rows = [
        [
            Panel("figure 12", "Figure 12: a soft disc meets a rigid wall", WIDTH, HEIGHT, outlines, "center", True),
            Panel("formulations", "Force at the mean inputs", TIME, FORCE, curves),
        ],
        [
            Panel("time reversal", "The force, and the same backwards", SHARE, OF_PEAK, turned),
        ],
    ]
    (here, linear, slow) = (100.0 * share for share in shares.values())
    reading = [
        f"The disc leaves with {found.column('velocity')[-1]:.4f} m/s of the 1 m/s it came with.",
        f"The force is not symmetrical under time reversal: backwards it differs by {here:.1f} % of the impulse. Waves "
        f"in the disc do that, not large strains: by small strains it is {linear:.1f} %, at 0.01 m/s {slow:.1f} %.",
    ]
    return Sheet("A soft disc on a rigid wall at 1 m/s", rows, "soft_discs_mean", reading)


def _reversed(update):
    """What of the impulse the force and the same backwards differ by, for three impacts, and both as curves."""
    shares, parts = {}, []
    for place, (text, changes) in enumerate(REVERSED.items()):
        found = solve(load_scene("soft_discs_mean", changes).parameters, 2)
        duration, _ = duration_and_touches(found)
        force = found.at("force", duration * SHARES)
        shares[text] = np.abs(force - force[::-1]).sum() / (2.0 * force.sum())
        parts.append(Line(text, SHARES, force / force.max(), colour(place)))
        parts.append(
            Line(f"{text}, backwards", SHARES, force[::-1] / force.max(), {**colour(place), "linestyle": "--"}, False)
        )
        update(0.8 + 0.2 * (place + 1) / len(REVERSED))
    return shares, parts


def soft_case1(update, samples: int = 0) -> Sheet:
    """Figures 17 to 20; `samples` in place of the study's."""
    return _case("soft_discs_case1", 17, "Soft discs, case 1: deviation of the modulus a fifth", update, samples)


def soft_case2(update, samples: int = 0) -> Sheet:
    """Figures 21 to 24; `samples` in place of the study's."""
    return _case("soft_discs_case2", 21, "Soft discs, case 2: deviation of the modulus two fifths", update, samples)


def _case(name, figure, title, update, samples):
    study = load_study(name, ["modality=no", *([f"samples={samples}"] if samples else [])])
    task = task_of(study)
    result = run_study(study, lambda one: update(one.done / one.total))
    found = history_statistics(result, "normal_load", task.instants)
    at_mean = realise(task, mean_inputs(study))
    histories = result.history("normal_load")
    kept = histories[np.isfinite(histories).all(axis=1)]
    narrow = narrowing(task.instants, histories, study.settings.seed, result.values)
    duration = float(np.nanmean(result.sample("contact_duration")))
    failed = int(np.sum(result.status > 0))
    rows = [
        [
            _forces(figure, found, at_mean, kept),
            _at_narrowing(figure + 1, kept, task.instants, narrow),
            _correlations(found, narrow),
        ],
        [
            density_map(found, f"Figure {figure + 2}: density of the force"),
            autocorrelation_map(found, f"Figure {figure + 3}: autocorrelation R(t, t')"),
            _modes(kept, task.instants, study.settings.seed),
        ],
    ]
    reading = [
        f"The force scatters least at {1e3 * narrow.time:.2f} ms (95 % interval {1e3 * narrow.low:.2f} to "
        f"{1e3 * narrow.high:.2f} ms), {narrow.time / duration:.3f} of the mean contact time of "
        f"{1e3 * duration:.2f} ms; it is {narrow.mean:.4g} N there, with a deviation of {narrow.std:.3g} N.",
        _change_of_sign(narrow.signs[0]),
        "At that instant some forces are exactly 0, so that modes are not counted."
        if narrow.modes is None
        else f"At that instant the sample shows {narrow.modes} mode{'s' if narrow.modes > 1 else ''}; the p-value of "
        f"one mode at most is {narrow.p_value:.2g}.",
        f"{failed} of {len(result.status)} realisations collapsed and are left out of all statistics.",
    ]
    text = f"{len(result.status)} random samples, seed {study.settings.seed}"
    return Sheet(title, rows, text, reading)


def _forces(figure, found, at_mean, kept):
    panel = mean_and_deviation(found, at_mean, f"Figure {figure}: {SHOWN} runs, mean, mean ± deviation")
    thin = {"color": STYLE["edge"], "linewidth": 0.8}
    runs = [Line(f"run {place}", found.times, run, thin, False) for place, run in enumerate(kept[:SHOWN])]
    panel.parts[1:1] = runs
    return panel


def _at_narrowing(figure, kept, instants, narrow):
    values = kept[:, int(np.argmin(np.abs(instants - narrow.time)))]
    smooth = natural_density(values)
    parts = [bars(values), Line("smoothed", smooth.x, smooth.density, colour(0))]
    title = f"Figure {figure}: force at {1e3 * narrow.time:.1f} ms"
    return Panel(f"figure {figure}", title, FORCE, Axis("density", "1/N", limits=(0.0, None)), parts)


def _correlations(found, narrow):
    modulus, ratio = found.input_correlation()
    top = found.std.max()
    parts = [
        Line("Young's modulus", found.times, modulus, colour(0)),
        Line("Poisson's ratio", found.times, ratio, colour(1)),
        Line("deviation, scaled", found.times, found.std / top, {**colour(5), "linestyle": "--"}),
        Line("least", [narrow.time] * 2, [-1.0, 1.0], {"color": STYLE["soft"], "linestyle": ":"}),
    ]
    parts = [part._replace(x=np.asarray(part.x)[keep], y=np.asarray(part.y)[keep])
             for part in parts for keep in [np.isfinite(part.y)]]  # fmt: skip
    title = "Correlation of the force with the inputs"
    return Panel("correlation", title, TIME, Axis("correlation", "1", limits=(-1.05, 1.75)), parts, "upper right")


def _modes(kept, instants, seed):
    mean = kept.mean(axis=0)
    inside = np.flatnonzero(mean > 0.2 * mean.max())
    places = np.unique(np.linspace(inside[0], inside[-1], INSTANTS).astype(int))
    values = []
    for place in places:
        try:
            values.append(modality(kept[:, place], seed).p_value)
        except StatisticError:  # many forces are exactly 0
            values.append(np.nan)
    parts = [
        Line("p-value of one mode at most", instants[places], values, {**colour(0), "marker": "o"}),
        Line("5 %", instants[places], np.full(len(places), 0.05), dashed()),
    ]
    return Panel("modality", "Modality over time, by bootstrap", TIME, Axis("p-value", "1", limits=(0.0, 1.4)), parts)


def _change_of_sign(change):
    if change is None:
        return "The correlation with the modulus does not change its sign."
    later, low, high = (1e3 * one for one in (change.later, change.low, change.high))
    return (
        f"The correlation of the force with the modulus changes its sign at {1e3 * change.time:.2f} ms, {later:.2f} ms "
        f"later (95 % interval {low:.2f} to {high:.2f} ms): a stiffer disc pushes more before, and less after."
    )


def soft_fast(update, samples: int = 0) -> Sheet:
    """Figures 15 and 16: small and large deformation; `samples` in place of the study's."""
    large = load_study("soft_discs_fast", ["modality=no", *([f"samples={samples}"] if samples else [])])
    result = run_study(large, lambda one: update(one.done / one.total))
    times = result.sample("contact_duration")
    times, moduli = times[np.isfinite(times)], result.values[:, 0]
    smooth = natural_density(times)
    small, johnson = known("discs_small_100"), known("discs_small_100", "contact.normal=johnson")
    slow = known("discs_small_10")
    rows = [
        [
            Panel("figure 15, modulus", "Figure 15: Young's modulus", MODULUS, Axis("density", "1/Pa"), [
                bars(moduli), density_line("gamma", large.inputs[0]),
            ]),
            Panel("figure 15, small", "Figure 15: 10 m/s by eq. (14)", CONTACT_TIME, DENSITY, [
                density_line("change of variable", slow.exact),
            ]),
            Panel("figure 15, large", "Figure 15: 100 m/s by finite elasticity", CONTACT_TIME, DENSITY, [bars(times)]),
        ],
        [
            Panel("figure 16", "Figure 16: contact time at 100 m/s", CONTACT_TIME, DENSITY, [
                density_line("eq. (14), small deformation", small.exact, colour(0)),
                density_line("Johnson, small deformation", johnson.exact, colour(1)),
                Line("finite elasticity", smooth.x, smooth.density, {**colour(5), "linestyle": "--"}),
            ]),
        ],
    ]  # fmt: skip
    reading = [
        f"Finite elasticity gives a mean contact time of {times.mean():.4e} s at 100 m/s with a deviation of "
        f"{times.std(ddof=1):.3e} s; eq. (14) {small.exact.mean:.4e} and {small.exact.std:.3e} s, Johnson's law "
        f"{johnson.exact.mean:.4e} and {johnson.exact.std:.3e} s.",
    ]
    text = f"{len(result.status)} random samples, seed {large.settings.seed}"
    return Sheet("Two rubber discs at 100 m/s: small against large deformation", rows, text, reading)
