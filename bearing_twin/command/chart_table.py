"""Every chart there is: what makes it, what it shows, how long it takes."""

from typing import NamedTuple


class Listed(NamedTuple):
    """A row: module in charts/, what it shows, about how many seconds it takes on one free core, how it is made.

    `made`: a "contest" compares methods: its table has the one row of `charts.table`, it has a limit of cost, and can
    be resumed; "sheets" are several pictures. The others are no contests, and their tables have columns of their own:
    "points" are measured, drawn and read, and "told" tells what it measures.
    """

    module: str
    shows: str
    seconds: float
    made: str = "points"


CHARTS = {
    "steppers": Listed("work_precision", "error in load and friction against cost", 400, "contest"),
    "motions": Listed(
        "motions",
        "steppers in every motion of a bearing, cages and rings with mass too: error, cost, evaluations",
        150,
        "contest",
    ),
    "fidelity": Listed(
        "fidelity",
        "what is chosen for bearings: error against what was wanted, cost against the least",
        1100,
        "contest",
    ),
    "stability": Listed(
        "stability_picture", "maps of where methods fail: limits predicted, found, and what is refused", 90, "contest"
    ),
    "newcomers": Listed(
        "newcomers", "SciPy with its defaults, Euler, a step of 0.1 ms: their error and cost", 25, "contest"
    ),
    "bearing_laws": Listed("bearing_laws", "elastic laws inside a bearing's run: error and cost", 15, "contest"),
    "bearing_friction": Listed("bearing_laws", "friction models inside a bearing's run: error and cost", 10, "contest"),
    "output_rate": Listed("bearing_outputs", "figures of a bearing over the output rate", 8, "contest"),
    "quantiles": Listed("bearing_outputs", "what a quantile of a bearing's load costs, by sampler", 45, "contest"),
    "pairs": Listed(
        "scene_contests", "spheres, discs, an ellipsoid meet: closed form, adaptive and fixed steps", 20, "contest"
    ),
    "beams": Listed("scene_contests", "a sphere on a beam: modes, Volterra's equation, steps", 15, "contest"),
    "two_bodies": Listed("scene_contests", "opposing points in closed form, by Newton, as a DAE", 15, "contest"),
    "cost": Listed("cost", "where the time of a run goes, from the contacts to a log", 40, "told"),
    "laws": Listed("laws", "error and cost of the elastic laws", 4, "contest"),
    "friction": Listed("friction", "error and cost of friction over a spot that slides and spins", 12, "contest"),
    "bounces": Listed("bounces", "a ball by the Hertz and by the volumetric law, and which comes late", 12),
    "dimensions": Listed(
        "dimensions",
        "equilibria, a held ring, a ring with mass, with and without a cage: error and cost over speed and load",
        160,
        "contest",
    ),
    "samplers": Listed(
        "samplers", "error of mean and deviation of a contact time against realisations and cost", 70, "contest"
    ),
    "coverage": Listed(
        "coverage", "how often 95 % intervals hold the truth, by sampler, statistic and samples", 90, "told"
    ),
    "discs": Listed(
        "soft_discs", "error of a soft disc's force against seconds, over meshes, formulations and steps", 60, "contest"
    ),
    "paper1": Listed(
        "paper1", "paper 1's bearing in space, contact point and normal of a ball by several laws, their cost", 15
    ),
    "studies": Listed("studies", "densities, forces and convergence of impacts with uncertain inputs", 150, "sheets"),
    "paper2": Listed(
        "paper2",
        "a sphere falls on a beam: both drops by both beam theories, and what a paper says of them",
        5,
        "sheets",
    ),
}
ALL = "all"
"""The word for every chart."""


def made_by(*ways: str) -> tuple[str, ...]:
    """Names of the charts that are made in one of these ways."""
    return tuple(name for name, chart in CHARTS.items() if chart.made in ways)
