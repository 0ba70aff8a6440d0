"""Charts: methods compared on accuracy and cost, maps of where they fail, the figures of three papers.

`CHARTS` has a row a chart, and `chart_of(name)` has `make(folder, name, options)`, `files(folder, name, options)` that
it writes, and `problems`.

* `contest`: tables of methods, one row an error and a cost: measured, written, read and drawn.
* `scenes`: overrides of which the last counts (`last_overrides`), and those of a run alone (`WITHOUT_CHECK`).
* `laws`: the motions with the greatest errors of a friction model, `hardest`.
"""

import importlib
from typing import Any, NamedTuple


class Listed(NamedTuple):
    """A chart: its module in this room, what it shows, and about how many CPU seconds it takes."""

    module: str
    shows: str
    seconds: float


CHARTS = {
    "laws": Listed("laws", "elastic laws: error of the load over the shape of the contact ellipse, and cost", 15),
    "friction": Listed(
        "laws", "friction over a contact patch that slides and spins: error of each model, and cost", 40
    ),
    "steppers": Listed("bearings", "integration methods on a 6203: error of load and friction against cost", 500),
    "newcomers": Listed("bearings", "what one tries first (SciPy's defaults, Euler, 0.1 ms) against the product", 60),
    "dimensions": Listed("bearings", "equilibria against moving balls, over speed: loads, contact angles, cost", 200),
    "tolerance": Listed("shipped", "error found against tolerance requested, in every shipped scene", 90),
    "choice": Listed("shipped", "what the rules choose in every shipped scene, against all other models", 220),
    "beams": Listed("bodies", "a sphere on a beam: modes, Volterra's equation, a sinusoidal force", 60),
    "discs": Listed("bodies", "a soft disc on a wall: meshes, formulations, steps, locking", 200),
    "bodies": Listed(
        "bodies", "spheres, discs, ellipsoids, tracked surfaces: closed forms, adaptive and fixed steps", 90
    ),
    "stability": Listed("bearings", "maps of where methods fail or are refused: step, stiffness, friction, mesh", 40),
    "samplers": Listed("uncertainty", "samplers: error of mean and deviation against realisations and cost", 60),
    "coverage": Listed("uncertainty", "share of 95 % intervals of studies that contain the true value", 300),
    "cost": Listed("shipped", "where the CPU time of a run goes, from the motion to a log", 60),
    "paper1": Listed("paper1", "Kosenko and Aleksandrov: contact frame, laws in a bearing, bounces", 8),
    "paper2": Listed("paper2", "Opritescu, Tirdea, Toader: a sphere falls on a beam, by two beam theories", 6),
    "paper3": Listed("paper3", "Buezas, Rosales, Sampaio: impacts with uncertain inputs, figures 1 to 24", 300),
}
RENAMED = {
    "studies": "paper3",
    "bounces": "paper1",
    "pairs": "bodies",
    "two_bodies": "bodies",
    "bearing_laws": "laws",
    "bearing_friction": "friction",
    "fidelity": "choice",
    "drawn": "tolerance",
    "motions": "steppers",
    "quantiles": "samplers",
    "output_rate": "tolerance",
}
"""Charts of earlier versions, and the one that answers their question today."""


def chart_of(name: str) -> Any:
    """The chart of this name."""
    return importlib.import_module(f"bearing_twin.charts.{CHARTS[name].module}").CHARTS[name]
