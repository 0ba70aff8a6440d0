"""What every impact scene hands back, and how it becomes a run like any other: an impact is a run, only short."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from bearing_twin.kinds.impact.collision import Contact
from bearing_twin.sample import Found

ENERGY_GAIN = 0.01  # of the energy brought; more is never a success


@dataclass(frozen=True, eq=False)
class Impact:
    """An impact, solved: figures, and `at(times)` -> one array a channel at increasing times [s] from the start.

    `run` is the resolved one: `time`, `values` and the histories read off them are its outputs, computed when asked.
    `contacts` in order, `restitution` = relative speed away over relative speed before (negative: the sphere follows
    the beam), `energy_closure` = energy gained by the numbers as a share of what was brought, `figures` the scene's
    own with SI-suffixed keys, `costs` of the solution.
    """

    names: tuple[str, ...]
    at: Callable[[np.ndarray], tuple[np.ndarray, ...]]
    run: Any
    contacts: tuple[Contact, ...]
    restitution: float
    peak_force: float
    greatest_approach: float
    energy_closure: float
    flags: tuple[str, ...]
    figures: dict[str, Any]
    costs: dict[str, int]

    @cached_property
    def time(self) -> np.ndarray:
        """The instants [s] of the run's outputs, whole nanoseconds."""
        period_ns = max(1, round(1e9 / self.run.output_rate))
        return 1e-9 * period_ns * np.arange(int(1e9 * self.run.duration // period_ns) + 1)

    @cached_property
    def values(self) -> dict[str, np.ndarray]:
        """All channels by name at `time`."""
        return dict(zip(self.names, self.at(self.time), strict=True))

    @property
    def force(self) -> np.ndarray:
        """Contact force [N] at `time`."""
        return self.values["normal_load"]

    @property
    def approach(self) -> np.ndarray:
        """Approach [m] at `time`, negative for a gap."""
        return self.values["approach"]

    @property
    def contact_duration(self) -> float:
        """Total time in contact [s]."""
        return sum(contact.duration for contact in self.contacts)

    @property
    def status(self) -> str:
        """ "done", or what failed."""
        gained = not abs(self.energy_closure) <= ENERGY_GAIN
        return "failed: energy" if gained else "done"

    def summary(self) -> dict[str, Any]:
        """The figures for `--json`."""
        return {
            "peak_force_n": self.peak_force,
            "contact_duration_s": self.contact_duration,
            "contacts": [
                {
                    "start_s": contact.start,
                    "duration_s": contact.duration,
                    "peak_force_n": contact.peak_force,
                    "impulse_ns": contact.impulse,
                }
                for contact in self.contacts
            ],
            "greatest_approach_m": self.greatest_approach,
            "restitution": self.restitution,
            "energy_closure": self.energy_closure,
            **self.figures,
        }


class Watched:
    """How far the outputs have been given out; an impact's figures are known beforehand."""

    def __init__(self):
        self.until = 0.0

    def add(self, block) -> None:
        """Takes a block in."""
        self.until = 1e-9 * float(block.time_ns[-1])


class ImpactMotion:
    """An impact as `simulate` wants it: solved when the first output after the start is asked for, then read off."""

    goal_speed = 0.0  # an impact takes no commands

    def __init__(self, solve, parameters, law: str, stepper: str):
        self._solve = lambda: solve(parameters, law, stepper)
        self._start = None
        self.reset()

    def reset(self) -> None:
        """Back to the start; the impact will be solved again."""
        self._impact, self._now = None, 0.0

    @property
    def impact(self) -> Impact:
        """The solved impact."""
        if self._impact is None:
            self._impact = self._solve()
            self._start = self._impact.at(np.zeros(1))
        return self._impact

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

    def statistics(self) -> Watched:
        """An empty record of what has been given out."""
        return Watched()

    def found(self, statistics: Watched) -> Found:
        """What the impact amounts to."""
        impact, flags = self.impact, self.impact.flags
        last = max((contact.start + contact.duration for contact in impact.contacts), default=0.0)
        if statistics.until < last:
            flags = (*flags, f"the outputs end at {statistics.until:.4g} s, before the contact does at {last:.4g} s")
        return Found(impact.summary(), flags, impact.status)

    def costs(self) -> dict[str, int]:
        """What the solution took."""
        return dict(self.impact.costs)
