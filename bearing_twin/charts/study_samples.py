"""What the sheets of paper 3 share: its studies with their exact distributions, and how a histogram is drawn."""

from typing import NamedTuple

import numpy as np

from bearing_twin.charts.sheets import Axis, Bars, Line
from bearing_twin.pictures.style import STYLE, ball_line
from bearing_twin.uq.propagation import Derived
from bearing_twin.uq.realisations import Task, exact_distributions, realise, task_of
from bearing_twin.uq.sampling import UnitPoints
from bearing_twin.uq.statistics import histogram
from bearing_twin.uq.study import Study, load_study

LEFT_OUT, RIGHT_OUT = 1e-6, 5e-4  # probability left out on either side of a density
POINTS = 301
ONLY_TIMES = ("histories=[]", "quantities=[contact_duration]", "modality=no")
SHADE = "#b9c6d2"

CONTACT_TIME = Axis("contact time", "s")
EXACT_LOOK = {"color": STYLE["ink"], "linewidth": 2.0}


class Known(NamedTuple):
    """A study of the contact time [s] of which everything is known: its exact distribution beside its samples."""

    study: Study
    task: Task
    exact: Derived


def known(name: str, *overrides: str) -> Known:
    """A shipped study, cut down to its contact time; its one uncertain input makes a change of variable possible."""
    study = load_study(name, [*ONLY_TIMES, *overrides])
    return known_of(study)


def known_of(study: Study) -> Known:
    """The same of a study that is at hand."""
    task = task_of(study)
    return Known(study, task, exact_distributions(study, task, "change_of_variable")["contact_duration"])


def draws(one: Known, seed: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """The first random samples (n,) of the input and the contact times [s] (n,) they give, as `run_study` has them."""
    settings = one.study.settings
    points = UnitPoints("random", 1, settings.seed if seed is None else seed, settings.samples)
    values = one.study.joint.values(points.chunk(0, points.samples))
    return values[:, 0], realise(one.task, values).quantities[:, 0]


def density_line(name: str, distribution, look: dict = EXACT_LOOK) -> Line:
    """The density of an input or of a quantity, over all but a negligible part of it."""
    quantile = getattr(distribution, "quantile", None) or distribution.ppf
    x = np.linspace(float(quantile(LEFT_OUT)), float(quantile(1.0 - RIGHT_OUT)), POINTS)
    return Line(name, x, distribution.pdf(x), look)


def bars(samples: np.ndarray, look: dict | None = None, name: str = "") -> Bars:
    """The histogram of samples."""
    edges, heights = histogram(samples)
    shaded = {"fill": True, "color": SHADE}
    return Bars(name or f"{len(samples)} samples", edges, heights, shaded if look is None else look, not look)


def colour(place: int) -> dict:
    """The look of the line number `place`."""
    return {**ball_line(place), "linewidth": 2.0}


def short(value: float) -> str:
    """A number as the paper writes it: 2e-5."""
    return f"{value:g}".replace("e-0", "e-").replace("e+0", "e")


def footer(one: Known, seeds: int = 1) -> str:
    """What a sheet was made with: one study, or the same with other seeds beside it."""
    settings = one.study.settings
    others = f", and seeds 1 to {seeds}" if seeds > 1 else ""
    return f"{settings.samples} random samples, seed {settings.seed}{others}"
