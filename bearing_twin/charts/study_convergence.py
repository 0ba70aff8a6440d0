"""Paper 3, figure 9: how deviation and mean of the contact time settle as realisations are added, for many seeds."""

import numpy as np

from bearing_twin.charts.sheets import Axis, Band, Line, Panel, Sheet
from bearing_twin.charts.study_samples import Known, colour, draws, footer, known
from bearing_twin.pictures.style import BALL_COLOURS, STYLE
from bearing_twin.uq.statistics import half_widths, paths

STUDY = "spheres_alpha_6e-5"
SEEDS, SHOWN = 200, 25
FIRST, STRIDE = 20, 20  # samples before a path is drawn, and between its points
CALLED_CONVERGED = 700  # the paper's number of realisations
CLOSE = 0.01
SAMPLES = Axis("realisations", "1")
REACH = 0.3  # of the axis of relative errors
GREY = {"color": STYLE["edge"], "linewidth": 0.7, "alpha": 0.8}


def errors(one: Known, seeds: int, update):
    """(counts (m,), relative errors of the deviation and of the mean (seeds, m)) of as many independent studies."""
    samples = []
    for seed in range(1, seeds + 1):
        samples.append(draws(one, seed)[1])
        update(seed / seeds)
    found = paths(np.array(samples))
    return found.counts, found.std / one.exact.std - 1.0, found.mean / one.exact.mean - 1.0


def convergence(update) -> Sheet:
    """Figure 9, the same of the mean, and the band against the number of realisations."""
    one = known(STUDY)
    counts, of_std, of_mean = errors(one, SEEDS, update)
    at = int(np.searchsorted(counts, CALLED_CONVERGED))
    lucky = int(np.argmin(np.max(np.abs(of_std[:, at - STRIDE : at + STRIDE]), axis=1)))
    bands = half_widths(one.exact, counts)
    of_std_band, of_mean_band = bands.std / one.exact.std, bands.mean / one.exact.mean
    rows = [
        [
            path_panel("figure 9", "Figure 9: the deviation", counts, of_std, of_std_band, lucky, marked=True),
            path_panel("mean", "The mean of the same studies", counts, of_mean, of_mean_band, lucky),
            _widths(counts, (("deviation", of_std, of_std_band), ("mean", of_mean, of_mean_band))),
        ]
    ]
    near = np.abs(of_std) < CLOSE
    stays = near[:, at:].all(axis=1)
    reading = [
        f"The 95 % band of the deviation is ± {100.0 * of_std_band[at]:.1f} % at {CALLED_CONVERGED} "
        f"realisations and ± {100.0 * of_std_band[-1]:.1f} % at {counts[-1]}.",
        f"{np.sum(near[:, at])} of {SEEDS} seeds are within 1 % at {CALLED_CONVERGED}, {np.sum(stays)} of them stay "
        f"there up to {counts[-1]}: a path that matches from about {CALLED_CONVERGED} on, like the paper's, is luck.",
    ]
    title = "Two steel spheres, deviation of alpha 6e-5: what Monte Carlo settles, and when"
    return Sheet(title, rows, footer(one, SEEDS), reading)


def path_panel(key, title, counts, of, band, bold=0, marked=False) -> Panel:
    """Relative errors over realisations: many paths, one of them bold, and the band 95 % of them lie in."""
    rows = slice(FIRST, None, STRIDE)
    x = counts[rows]
    parts = [
        Band("95 % band", x, -band[rows], band[rows], {"color": BALL_COLOURS[0], "alpha": 0.18}),
        *(
            Line(f"seed {place + 1}", x, path[rows], GREY, False)
            for place, path in enumerate(of[:SHOWN])
            if place != bold
        ),
        Line(f"seed {bold + 1}", x, of[bold, rows], {**colour(5), "linewidth": 1.8}),
    ]
    if marked:
        dotted = {"color": STYLE["ink"], "linewidth": 1.2, "linestyle": ":"}
        parts.append(Line(f"{CALLED_CONVERGED} realisations", [CALLED_CONVERGED] * 2, [-REACH, REACH], dotted))
    return Panel(key, title, SAMPLES, Axis("relative error", "1", limits=(-REACH, REACH)), parts, "upper right")


def _widths(counts, kinds):
    """Half the width that holds 95 % of the seeds, beside the band that theory gives."""
    rows = np.unique(np.geomspace(FIRST, len(counts) - 1, 25).astype(int))
    parts = []
    for place, (name, of, band) in enumerate(kinds):
        found = np.quantile(np.abs(of[:, rows]), 0.95, axis=0)
        parts.append(Line(f"{name}: band", counts[rows], band[rows], colour(place)))
        dots = {"color": BALL_COLOURS[place], "linestyle": "", "marker": "o", "markersize": 5}
        parts.append(Line(f"{name}: 95 % of the seeds", counts[rows], found, dots))
    up = Axis("relative half width", "1", log=True)
    return Panel("half width", "Half width against realisations", SAMPLES._replace(log=True), up, parts)
