"""The row of the chart of dimensions, of a preloaded bearing and of one with clearance."""

import math
from dataclasses import dataclass

from bearing_twin.charts.table import DONE, Row


@dataclass(frozen=True)
class DimensionRow(Row):
    """One dimension, with or without a cage, at one load and `speed` [rad/s]: further relative errors, CPU seconds.

    Errors of angles, and what is told of them; 20 ms after the start; of the orbit speed, and of the ring's place or
    force. `cost_at_100_hz` is of a simulated second with 100 outputs. NaN is what a problem does not compare.
    """

    speed: float = math.nan
    angle_error: float = math.nan
    told_angle_error: float = math.nan
    early_load_error: float = math.nan
    early_angle_error: float = math.nan
    cost_at_100_hz: float = math.nan
    orbit_error: float = math.nan
    ring_error: float = math.nan


def worst(rows: list[DimensionRow], method: str, error: str, share: float = math.inf) -> float:
    """The greatest error of a method up to this setting; NaN where it was not measured."""
    found = (
        getattr(row, error) for row in rows if row.method == method and row.status == DONE and row.setting <= share
    )
    return max((one for one in found if not math.isnan(one)), default=math.nan)
