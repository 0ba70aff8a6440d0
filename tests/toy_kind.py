"""A kind of scene in one file: a mass on a spring with a damper. `import toy_kind` puts it into the table of kinds.

    m x'' + d x' + k x = 0,   0 < d^2 < 4 m k

What it leaves out of its row (figures, quantities, picture, topics) is drawn from its channels.
"""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

import math
from dataclasses import dataclass

import numpy as np

from bearing_twin.base.parameters import quantity, section
from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Channel
from bearing_twin.kinds import register
from bearing_twin.kinds.contract import Kind, SceneParameters


@dataclass(frozen=True)
class Body:
    """The body that swings."""

    mass: float = quantity(2.0, "kg", "mass", above=0.0)
    stiffness: float = quantity(800.0, "N/m", "of the spring", above=0.0)
    damping: float = quantity(4.0, "N s/m", "of the damper", above=0.0)


@dataclass(frozen=True)
class RunSettings:
    """Duration and rates of output."""

    duration: float = quantity(1.0, "s", "simulated time", above=0.0, at_most=1e4)
    output_rate: float = quantity(1000.0, "Hz", "solver outputs", above=0.0, at_most=1e6)
    publish_rate: float = quantity(100.0, "Hz", "published outputs", above=0.0, at_most=1e6)


@dataclass(frozen=True)
class ToyScene(SceneParameters):
    """All keys of the scene."""

    body: Body = section(Body)
    start: float = quantity(0.01, "m", "position at the start, at rest")
    run: RunSettings = section(RunSettings)

    def check(self) -> list[str]:
        """A body that creeps back instead of swinging is refused."""
        critical = 2.0 * math.sqrt(self.body.mass * self.body.stiffness)
        if self.body.damping < critical:
            return []
        given = f"body.damping = {self.body.damping:g} N s/m"
        return [f"{given} does not let it swing; stay below {critical:g} N s/m"]


CHANNELS = (
    Channel("position", "m", (), "of the body from where the spring is slack"),
    Channel("velocity", "m/s", (), "of the body"),
    Channel("energies", "J", (2,), "kinetic, elastic"),
)


class ToyMotion:
    """The swinging body, by its closed form."""

    def __init__(self, parameters: ToyScene, choice: Choice):
        self._parameters = parameters
        self.reset()

    def reset(self) -> None:
        """Back to the start."""
        self._now, self._evaluations = 0.0, 0

    def first_outputs(self):
        """The outputs now."""
        return self._at(np.array([self._now]))

    def advance(self, times: np.ndarray, duration: float):
        """The outputs at `times` [s] from now; then `duration` [s] have passed."""
        values = self._at(self._now + times)
        self._now += duration
        return values

    def _at(self, times):
        body, start = self._parameters.body, self._parameters.start
        self._evaluations += len(times)
        decay = 0.5 * body.damping / body.mass
        rate = math.sqrt(body.stiffness / body.mass - decay**2)
        fade = start * np.exp(-decay * times)
        position = fade * (np.cos(rate * times) + decay / rate * np.sin(rate * times))
        velocity = -fade * (rate + decay**2 / rate) * np.sin(rate * times)
        energies = 0.5 * np.stack([body.mass * velocity**2, body.stiffness * position**2], axis=1)
        return position, velocity, energies

    def take_records(self):
        """None: the outputs say all."""
        return {}

    def costs(self):
        """Evaluations of the closed form."""
        return {"evaluations": self._evaluations}


KIND = Kind(
    name="toy",
    help="a mass on a spring with a damper",
    parameters=ToyScene,
    motion=ToyMotion,
    channels=lambda parameters: CHANNELS,
)

register(KIND, __name__)
