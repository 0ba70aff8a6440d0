"""An impact as tests look at it: its channels at the outputs of a run, and figures by the one writer of its kind."""

from functools import cached_property

import numpy as np

from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.beam.figures import EXTREMES
from bearing_twin.kinds.bodies.figures import DURATION, IMPULSE, PEAK_FORCE, START
from bearing_twin.kinds.bodies.impact import ContactPeriod


class SolvedImpact:
    """What `solve(parameters, law, stepper)` of a kind gives for a scene, read off at the outputs of its run."""

    def __init__(self, solve, scene, law: str, stepper: str):
        kind, impact = KINDS[scene.kind], solve(scene.parameters, law, stepper)
        parameters = scene.parameters.resolve()
        self._channels = kind.channels(parameters)
        self.run, self.time, self.records, self.costs, self.at = (
            getattr(impact, name) for name in ("run", "time", "records", "costs", "at")
        )
        figures, ends = kind.figures_of(parameters, Choice(law, stepper, 0.0, "", ())), self.time[[0, -1]]
        time_ns = np.rint(1e9 * ends).astype(np.int64)
        figures.add(Block(self._channels, 0, time_ns, self._named(ends), self.records))
        self.contacts = tuple(
            ContactPeriod(*map(float, row[[START, DURATION, PEAK_FORCE, IMPULSE]])) for row in figures.contacts
        )
        names = "peak_force_n", "greatest_approach_m", "restitution", "energy_closure"
        self.peak_force, self.greatest_approach, self.restitution, self.energy_closure = map(
            figures.figures().get, names
        )
        names = (column.name for column in EXTREMES.columns)
        self.extremes = dict(zip(names, map(float, self.records.get("extremes", [()])[0]), strict=False))

    def _named(self, times) -> dict[str, np.ndarray]:
        return dict(zip((channel.name for channel in self._channels), self.at(times), strict=True))

    @cached_property
    def values(self) -> dict[str, np.ndarray]:
        return self._named(self.time)

    @property
    def force(self) -> np.ndarray:
        return self.values["normal_load"]

    @property
    def approach(self) -> np.ndarray:
        return self.values["approach"]
