"""Dimensions of a bearing over speed and load, error against cost: equilibria, a ring held, a ring with mass, cages.

Above a preloaded bearing (`preloaded`), in which equilibria are looked at ball by ball; below one with clearance under
a load down (`cages`), in which balls need a cage. `setting` is the centrifugal load over that on the inner raceway in
the former, the speed [rad/s] in the latter.
"""

from collections.abc import Iterable
from pathlib import Path

from matplotlib.figure import Figure

from bearing_twin.charts import cages, preloaded
from bearing_twin.charts.chart import Chart
from bearing_twin.charts.dimension_row import DimensionRow
from bearing_twin.pictures.style import save_chart

ALL = "all"  # who takes part in a run
PARTS = {preloaded: preloaded.LOADS, cages: cages.PROBLEMS}
HEIGHTS = {preloaded: 6.8, cages: 7.2}  # inches


def _part_of(name: str):
    """The module that compares this problem."""
    return next(part for part, problems in PARTS.items() if name in problems)


def judge(name: str, _: str, setting: float, limit: float) -> list[DimensionRow]:
    """All that is compared of one problem at one setting; the limit is of each run."""
    return _part_of(name).judge(name, setting, limit)


def settings(name: str) -> Iterable[tuple[str, float]]:
    """Who takes part, and at which settings."""
    return ((ALL, one) for one in (preloaded.SHARES if _part_of(name) is preloaded else cages.SPEEDS))


def _rows_of(rows: list[DimensionRow], part) -> list[DimensionRow]:
    return [row for row in rows if _part_of(row.problem) is part]


def reading(rows: list[DimensionRow]) -> list[str]:
    """What the chart says, of the preloaded bearing and of the one with clearance."""
    return [sentence for part in PARTS if (mine := _rows_of(rows, part)) for sentence in part.reading(mine)]


def draw(rows: list[DimensionRow], path: Path) -> None:
    """The chart, three panels for each part of which there are rows."""
    shown = [(part, mine, height) for part, height in HEIGHTS.items() if (mine := _rows_of(rows, part))]
    heights = [height for _, _, height in shown]
    figure = Figure(figsize=(17, sum(heights)), layout="constrained")
    boxes = figure.subfigures(len(shown), 1, height_ratios=heights, squeeze=False)[:, 0]
    for (part, mine, _), panels in zip(shown, boxes, strict=True):
        part.draw(mine, panels.subplots(1, 3, sharey=True))
    figure.get_layout_engine().set(rect=(0.0, 0.02, 1.0, 0.96), hspace=0.04)  # room for title and footer
    save_chart(
        figure, "Dimensions of a bearing: equilibria, a ring held, a ring with mass, with and without a cage", path
    )


CONTESTS = {
    "dimensions": Chart(
        judge=judge,
        problems={name: name for problems in PARTS.values() for name in problems},
        entries=settings,
        kind=DimensionRow,
        drawn=draw,
        told=reading,
    )
}
