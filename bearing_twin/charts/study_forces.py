"""Paper 3, figure 8, and what its figures 17 to 24 show of discs for the spheres: the force as a random process."""

import numpy as np

from bearing_twin.charts.sheets import Axis, Band, Line, Map, Panel, Sheet
from bearing_twin.charts.study_samples import colour, known
from bearing_twin.pictures.style import BALL_COLOURS, STYLE
from bearing_twin.uq.realisations import mean_inputs, realise, task_of
from bearing_twin.uq.run import run_study
from bearing_twin.uq.study import load_study
from bearing_twin.uq.summary import history_statistics

STUDY = "spheres_alpha_4e-5"
TIME = Axis("time since first touch", "s")
FORCE = Axis("contact force", "N")
BOUNDS = (0.05, 0.5, 0.95)
SHOWN = 12  # single runs
LEVELS = 800  # of the force, from 0 to the greatest


def forces(update) -> Sheet:
    """Figure 8, bands over time, density over time, autocorrelation, correlation with alpha."""
    study = load_study(STUDY, ["sweep=", "modality=no"])
    task = task_of(study)
    result = run_study(study, lambda one: update(one.done / one.total))
    instants = task.instants
    found = history_statistics(result, "normal_load", instants)
    at_mean = realise(task, mean_inputs(study))
    at_bounds = realise(task, study.inputs[0].ppf(np.array(BOUNDS))[:, None])
    rows = [
        [
            _bounds(instants, at_bounds, at_mean),
            mean_and_deviation(found, at_mean, "Mean of the runs, run at the mean"),
            _quantiles(found, result),
        ],
        [
            density_map(found, "Density of the force, as figure 19"),
            autocorrelation_map(found, "Autocorrelation R(t, t'), as figure 20"),
            _correlation(found),
        ],
    ]
    bounds = ", ".join(f"{peak:.5g}" for peak in at_bounds.quantities[:, study.quantities.index("peak_force")])
    highest, single = float(found.mean.max()), float(at_mean.histories.max())
    reading = [
        f"Peak force of the runs at the 5, 50 and 95 % bounds of the contact time: {bounds} N; the 5 % bound of the "
        "contact time is the upper curve of the force.",
        f"The mean of the runs peaks at {highest:.4g} N, the run at the mean alpha at {single:.4g} N: they are not the "
        "same, and mean - deviation would pull, which no contact does.",
        _change_of_sign(found),
    ]
    text = f"{len(result.status)} random samples, seed {study.settings.seed}"
    return Sheet("Two steel spheres at 20 m/s, deviation of alpha 4e-5: the force over time", rows, text, reading)


def _bounds(instants, at_bounds, at_mean):
    parts = [
        Line(f"{100 * p:g} % of contact time", instants, curve, colour(place))
        for place, (p, curve) in enumerate(zip(BOUNDS, at_bounds.histories[:, 0], strict=True))
    ]
    parts.append(Line("mean alpha", instants, at_mean.histories[0, 0], dashed()))
    return Panel("figure 8", "Figure 8: runs at bounds of contact time", TIME, FORCE, parts)


def mean_and_deviation(found, at_mean, title: str) -> Panel:
    """The mean of histories with its deviation, and the run at the mean of the inputs."""
    t = found.times
    parts = [
        Band("mean ± deviation", t, found.mean - found.std, found.mean + found.std, _shade()),
        Line("mean of the runs", t, found.mean, colour(5)),
        Line("run at the mean inputs", t, at_mean.histories[0, 0], dashed()),
    ]
    return Panel("mean and deviation", title, TIME, FORCE, parts)


def _quantiles(found, result):
    t = found.times
    low, middle, high = found.quantiles(BOUNDS)
    look = {"color": STYLE["edge"], "linewidth": 0.8, "alpha": 0.9}
    runs = [
        Line(f"run {place}", t, run, look, False) for place, run in enumerate(result.history("normal_load")[:SHOWN])
    ]
    parts = [Band("5 to 95 % at each instant", t, low, high, _shade()), *runs, Line("median", t, middle, colour(0))]
    return Panel("quantiles", f"Quantiles at each instant, {SHOWN} runs", TIME, FORCE, parts)


def density_map(found, title: str) -> Panel:
    """The density of a force over time, as colours."""
    levels, heights = found.density(levels=LEVELS, low=0.0)
    highest = float(np.max(found.quantiles((0.99,))))
    # towards no force the density is that of runs out of contact, a spike that would drown the rest
    top = float(np.quantile(heights[:, (levels > 0.05 * highest) & (levels < highest)], 0.99))
    chart = Map("density", "1/N", found.times, levels, heights.T, "cividis", (0.0, top), power=0.5)
    force = FORCE._replace(limits=(0.0, highest))
    return Panel("density", title, TIME, force, [chart])


def autocorrelation_map(found, title: str) -> Panel:
    """The correlation of a force between any two instants, as colours."""
    t = found.times
    chart = Map("correlation of F(t) and F(t')", "1", t, t, found.autocorrelation(), "RdBu_r", (-1.0, 1.0))
    other = Axis("time t'", "s")
    return Panel("autocorrelation", title, Axis("time t", "s"), other, [chart])


def _correlation(found):
    parts = [
        Line("correlation with alpha", found.times, found.input_correlation()[0], colour(0)),
        Line("deviation / its greatest", found.times, found.std / found.std.max(), {**colour(5), "linestyle": "--"}),
        Line("zero", found.times, np.zeros_like(found.times), {"color": STYLE["soft"], "linewidth": 1.0}, False),
    ]
    return Panel("correlation", "Correlation of the force with alpha", TIME, Axis("correlation", "1"), parts)


def _change_of_sign(found):
    along, t = found.input_correlation()[0], found.times
    place = int(np.argmax((along[1:] > 0.0) & (along[:-1] <= 0.0)))
    mean = known(STUDY).exact.mean
    when = float(np.interp(0.0, along[place : place + 2], t[place : place + 2]))
    return (
        f"A greater alpha means less force before {when:.3e} s ({when / mean:.2f} of the mean contact time) and more "
        "after; instants on either side are anticorrelated."
    )


def _shade():
    return {"color": BALL_COLOURS[0], "alpha": 0.22}


def dashed() -> dict:
    """The look of what is compared with."""
    return {"color": STYLE["ink"], "linewidth": 2.0, "linestyle": "--"}
