"""Paper 3, figures 1 to 7, 10 and 11: densities of alpha and of the contact time of two steel spheres, all speeds."""

import numpy as np

from bearing_twin.charts.sheets import Axis, Band, Dots, Line, Map, Panel, Sheet
from bearing_twin.charts.study_samples import (
    CONTACT_TIME,
    EXACT_LOOK,
    bars,
    colour,
    density_line,
    draws,
    footer,
    known,
    known_of,
    short,
)  # fmt: skip
from bearing_twin.contact import hertz_impact as impact
from bearing_twin.kinds.impact.derived import sphere_pair
from bearing_twin.pictures.style import BALL_COLOURS, STYLE
from bearing_twin.run.scene import load_scene
from bearing_twin.uq.run import run_study
from bearing_twin.uq.statistics import natural_density

STUDIES = ("spheres_alpha_2e-5", "spheres_alpha_4e-5", "spheres_alpha_6e-5")
ALPHA = Axis("alpha", "s (m/s)^0.2", shown=(1e5, "1e-5 s (m/s)^0.2"))
DENSITY_OF_ALPHA = Axis("density", "1/s (m/s)^0.2")
DENSITY = Axis("density", "1/s", limits=(0.0, None))
SMOOTHED = {"color": BALL_COLOURS[5], "linewidth": 2.0, "linestyle": "--"}
SPEEDS = np.geomspace(1.0, 100.0, 81)  # m/s
EVERY = 4  # of them, for the bands
CUTS = (2.0, 5.0, 20.0, 100.0)  # m/s
LEVELS = 240  # of the contact time in the map


def densities(update) -> Sheet:
    """Figures 1, 2, 10 and 11."""
    ones = [known(name) for name in STUDIES]
    both = [draws(one) for one in ones]
    words = [f"deviation of alpha {short(one.study.inputs[0].std)}" for one in ones]
    panels, columns = [], ((ALPHA, DENSITY_OF_ALPHA), (CONTACT_TIME, DENSITY))
    for column, (axis, up) in enumerate(columns):
        parts = []
        for place, (one, found, word) in enumerate(zip(ones, both, words, strict=True)):
            parts.append(bars(found[column], {**colour(place), "linewidth": 1.0, "alpha": 0.75}, f"{word}, samples"))
            parts.append(density_line(word, (one.study.inputs[0], one.exact)[column], colour(place)))
        title = ("Figure 1: alpha", "Figure 2: contact time at 20 m/s")[column]
        panels.append(Panel(f"figure {1 + column}", f"{title}; steps are samples", axis, up, parts))
    widest, found = ones[-1], both[-1]
    for column, (axis, up) in enumerate(columns):
        smooth = natural_density(found[column])
        parts = [
            bars(found[column]),
            density_line("closed form", (widest.study.inputs[0], widest.exact)[column], EXACT_LOOK),
            Line("reconstructed from the samples", smooth.x, smooth.density, SMOOTHED),
        ]
        what = ("alpha", "contact time")[column]
        panels.append(Panel(f"figures 10, 11, {what}", f"Figures 10 and 11: {what}, {words[-1]}", axis, up, parts))
    skewness = ", ".join(f"{one.exact.skewness:+.3f}" for one in ones)
    coefficient, first, second = sphere_pair(load_scene("two_spheres").parameters)
    by_hertz = impact.alpha(coefficient, first * second / (first + second))
    reading = [
        f"The mean alpha of {ones[0].study.inputs[0].mean:.4e} is measured; the printed steel has {by_hertz:.5e}.",
        f"All three keep the mean contact time of {ones[0].exact.mean:.4e} s; its deviation is "
        + ", ".join(f"{one.exact.std:.3e}" for one in ones)
        + " s.",
        f"The skewness is {skewness}: positive, the long tail lies to the right, though the text has it to the left.",
        "Gamma is what maximum entropy gives for a known mean and mean logarithm, not for a bounded second moment.",
    ]
    return Sheet("Two steel spheres: alpha and contact time", [panels[:2], panels[2:]], footer(ones[0]), reading)


def speeds(update) -> Sheet:
    """Figures 3 to 7."""
    ones = [known(name) for name in STUDIES]
    narrow = [known_of(ones[0].study.at(float(speed))).exact for speed in SPEEDS]
    update(0.3)
    times = np.linspace(0.0, float(narrow[0].quantile(0.999)), LEVELS)
    heights = np.array([one.pdf(times) for one in narrow]).T
    speed = Axis("speed", "m/s", log=True)
    top = float(np.quantile(heights, 0.995))
    chart = Map("density", "1/s", SPEEDS, times, heights, "cividis", (0.0, top), tuple(np.linspace(0.1, 0.9, 5) * top))
    surface = Panel("figure 3", "Figure 3: density over speed and contact time", speed, CONTACT_TIME, [chart])
    cuts = [
        density_line(f"{cut:g} m/s", known_of(ones[0].study.at(cut)).exact, colour(place))
        for place, cut in enumerate(CUTS)
    ]
    rows = [[surface, Panel("figure 4", "Figure 4: the same, cut at four speeds", CONTACT_TIME, DENSITY, cuts)], []]
    few = SPEEDS[::EVERY]
    for place, one in enumerate(ones):
        along = [known_of(one.study.at(float(speed))).exact for speed in few]
        low, middle, high = (np.array([float(each.quantile(p)) for each in along]) for p in (0.05, 0.5, 0.95))
        parts = [
            Band("5 to 95 %", few, low, high, {"color": BALL_COLOURS[0], "alpha": 0.25}),
            Line("median", few, middle, colour(0)),
            Line("mean", few, [each.mean for each in along], {**colour(5), "linestyle": "--"}),
            *_sampled(one),
        ]
        title = f"Figure {5 + place}: deviation of alpha {short(one.study.inputs[0].std)}"
        up = CONTACT_TIME._replace(limits=(0.0, 2.4e-4))
        rows[1].append(Panel(f"figure {5 + place}", title, speed, up, parts, "upper right"))
        update(0.3 + 0.7 * (place + 1) / 3)
    at_20 = [known_of(one.study.at(20.0)).exact for one in ones]
    bounds = "; ".join(", ".join(f"{float(each.quantile(p)):.4e}" for p in (0.05, 0.5, 0.95)) for each in at_20)
    ratio = float(narrow[0].quantile(0.95) / narrow[-1].quantile(0.95))
    reading = [
        f"5, 50 and 95 % of the contact time at 20 m/s for deviations 2, 4, 6e-5 of alpha: {bounds} s.",
        f"Every quantile falls as speed^-0.2: from 1 to 100 m/s by a factor {ratio:.4f}, whatever the probability.",
        "The median lies below the mean, the more so the greater the deviation.",
    ]
    return Sheet("Two steel spheres: contact time from 1 to 100 m/s", rows, footer(ones[0]), reading)


def _sampled(one):
    """Quantiles of the samples at the speeds of the study, with their 95 % intervals."""
    studies = run_study(one.study).summary["sweep"]["studies"]
    for place, probability in enumerate(("0.05", "0.50", "0.95")):
        found = [each["quantities"]["contact_duration"]["quantiles"][probability] for each in studies]
        columns = ([each[key] for each in found] for key in ("value", "low", "high"))
        look = {"color": STYLE["ink"], "markersize": 4, "linewidth": 1.4}
        yield Dots("samples with 95 % intervals", [each["value"] for each in studies], *columns, look, place == 0)
