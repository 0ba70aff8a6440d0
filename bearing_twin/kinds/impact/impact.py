"""An impact that is solved as a whole, and its outputs as a run.

Common to two spheres and two discs: two bodies on a line, one contact, by closed form or differential equation.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from bearing_twin.base.sample import Channel, between
from bearing_twin.kinds.impact.collision import ContactPeriod, Spring, collide
from bearing_twin.kinds.impact.derived import resolve
from bearing_twin.kinds.impact.figures import contact_rows

SETTING = 0.03  # tolerance of a step over that of forces and times (`tests/test_impact_doubt.py`)
CHANNELS = (
    Channel("approach", "m", (), "mutual approach of the two bodies; negative = gap"),
    Channel("normal_load", "N", (), "contact force, pushing the bodies apart"),
    Channel("displacement", "m", (2,), "of the two centres from the start, positive forward", ("body",)),
    Channel("velocity", "m/s", (2,), "of the two centres, positive forward", ("body",)),
    Channel("kinetic_energy", "J", (), "of the motion relative to the common centre of mass"),
    Channel("elastic_energy", "J", (), "stored in the contact"),
)


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
    """An impact as a motion: solved when the first output after the start is requested, then evaluated.

    A record whose time lies beyond the last output of the scene's run is given with that output.
    """

    def __init__(self, solve, parameters, choice):
        self._solve = lambda: solve(parameters, choice.law, choice.stepper)
        self._start = None
        self.reset()

    def reset(self) -> None:
        """Back to the start; the solution is kept."""
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
        """Costs of the solution."""
        return dict(self.impact.costs)


def channels(parameters) -> tuple[Channel, ...]:
    """Channels of a sample of two bodies."""
    return CHANNELS


def pair_impact(parameters, spring: Spring, masses, stepper, expected, closed) -> Impact:
    """The impact of two bodies; `closed` = (ContactPeriod, greatest approach, restitution, closure, history) or None.

    `history(times)` from the first touch gives approach [m] and its rate [m/s].
    """
    parameters = resolve(parameters)
    motion = parameters.motion
    total = sum(masses)
    reduced = masses[0] * masses[1] / total
    drift = (masses[0] * motion.first_velocity + masses[1] * motion.second_velocity) / total
    touch = motion.gap / motion.speed
    setting = SETTING * parameters.wanted.tolerance
    costs = {"steps": 0, "evaluations": 1}
    if closed is None:
        closed, costs = _followed(parameters, spring, reduced, stepper, setting, expected, touch)
    contact, deepest, restitution, closure, history = closed
    leaving, duration = restitution * motion.speed, contact.duration
    last_approach = float(np.ravel(history(np.array([duration]))[0])[0])

    def at(times):
        since = np.asarray(times, float) - touch
        approach, rate = (np.array(part) for part in history(np.clip(since, 0.0, duration)))
        before, after = since < 0.0, since > duration
        separated = last_approach - leaving * (since - duration)
        approach = np.where(before, motion.speed * since, np.where(after, separated, approach))
        rate = np.where(before, motion.speed, np.where(after, -leaving, rate))
        inside = ~(before | after)
        load, stored = np.where(inside, spring.loads(approach, rate), 0.0)
        moved, shares = approach + motion.gap, np.array([masses[1], -masses[0]]) / total
        return (
            approach,
            load,
            drift * np.asarray(times, float)[:, None] + shares * moved[:, None],
            drift + shares * rate[:, None],
            0.5 * reduced * rate**2,
            stored,
        )

    placed = ContactPeriod(touch, *contact[1:])
    gained = closure * 0.5 * reduced * motion.speed**2
    records = {"contact": contact_rows((placed,), (deepest,), leaving, gained)}
    return Impact(at, parameters.run, records, costs)


def _followed(parameters, spring, reduced, stepper, setting, expected, touch):
    """As `closed` of `pair_impact`, by the equation of motion, and its costs."""
    speed, step = parameters.motion.speed, parameters.solver.step or expected / 500.0
    found = collide(spring, reduced, speed, stepper, setting, step, expected, touch)
    figures = found.contact, found.greatest_approach, found.leaving_speed / speed, found.energy_closure
    return (*figures, found.history), {"steps": found.steps, "evaluations": found.evaluations}
