"""An impact solved at once, and how it becomes a run like any other: an impact is a run, only short."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from bearing_twin.base.sample import between


@dataclass(frozen=True, eq=False)
class Impact:
    """An impact, solved: `at(times)` -> one array a channel at increasing times [s] from the start.

    `run` is the resolved one, `records` are the rows of the kind's tables, `costs` those of the solution.
    """

    at: Callable[[np.ndarray], tuple[np.ndarray, ...]]
    run: Any
    records: Mapping[str, np.ndarray]
    costs: dict[str, int]

    @cached_property
    def time(self) -> np.ndarray:
        """The instants [s] of the run's outputs, whole nanoseconds."""
        period_ns = max(1, round(1e9 / self.run.output_rate))
        return 1e-9 * period_ns * np.arange(int(1e9 * self.run.duration // period_ns) + 1)


class ImpactMotion:
    """An impact as `simulate` wants it: solved when the first output after the start is asked for, then read off.

    A record whose time lies beyond the last output of the scene's run is given with that output.
    """

    def __init__(self, solve, parameters, choice):
        self._solve = lambda: solve(parameters, choice.law, choice.stepper)
        self._start = None
        self.reset()

    def reset(self) -> None:
        """Back to the start; what is solved already stays solved."""
        self._now, self._given = 0.0, -np.inf

    @cached_property
    def impact(self) -> Impact:
        """The solved impact."""
        return self._solve()

    def first_outputs(self):
        """The outputs at the start."""
        if self._start is None:
            self._start = self.impact.at(np.zeros(1))
        return self._start

    def advance(self, times: np.ndarray, duration: float):
        """The outputs at `times` [s] from now; then `duration` [s] have passed."""
        values = self.impact.at(self._now + times)
        self._now += duration
        return values

    def take_records(self) -> dict[str, np.ndarray]:
        """The records since the last call."""
        last, found = float(self.impact.time[-1]), {}
        now = round(1e9 * self._now)
        for name, rows in self.impact.records.items():
            rows = rows.copy()
            rows[:, 0] = np.minimum(rows[:, 0], last)
            found[name] = between(rows, self._given, now)
        self._given = now
        return found

    def costs(self) -> dict[str, int]:
        """What the solution took."""
        return dict(self.impact.costs)
