"""A study: a scene, which of its numbers are uncertain and how, and what is asked about it."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass, field

from bearing_twin.parameters import choice, plain, quantity, section
from bearing_twin.run.scene import Scene, parse_scene
from bearing_twin.uq.inputs import Input, Joint
from bearing_twin.uq.sampling import GREATEST_SAMPLES, GREATEST_SEED, SAMPLERS, rounded
from bearing_twin.uq.scene_keys import placed, put

PROPAGATION_METHODS = ("auto", "change_of_variable", "ensemble", "chaos")
STATISTICS = ("mean", "std", "quantile")


@dataclass(frozen=True)
class Stop:
    """When the ensemble is large enough; without a tolerance it takes all its samples. See `stopping`."""

    statistic: str = choice("mean", STATISTICS, "whose 95 % interval must become narrow")
    probability: float = quantity(0.95, "1", "of the quantile, for statistic: quantile", above=0.0, below=1.0)
    tolerance: float = quantity(0.0, "its unit", "greatest half width of the interval; 0 = none", at_least=0.0)
    relative_tolerance: float = quantity(0.0, "1", "the same as a share of the statistic; 0 = none", at_least=0.0)
    minimum: int = quantity(200, "1", "samples before the first look", at_least=2)


@dataclass(frozen=True)
class Settings:
    """The keys of a study that are plain numbers and words."""

    method: str = choice("auto", PROPAGATION_METHODS, "auto = change of variable where it applies, else ensemble")
    sampler: str = choice("random", tuple(SAMPLERS), "where the unit cube is sampled")
    samples: int = quantity(2000, "1", "realisations, at most", at_least=1, at_most=GREATEST_SAMPLES)
    seed: int = quantity(1, "1", "of every random choice", at_least=0, at_most=GREATEST_SEED)
    batch: int = quantity(100, "1", "samples between looks at the convergence", at_least=1, at_most=1_000_000)
    workers: int = quantity(0, "1", "processes that simulate; 0 = one a processor", at_least=0, at_most=512)
    memory: float = quantity(2e9, "B", "refuse a study that needs more", above=0.0)
    time_limit: float = quantity(
        0.0, "s", "end after so long with what is done, so that numbers depend on the machine; 0 = none", at_least=0.0
    )
    history_points: int = quantity(200, "1", "instants of each history", at_least=2, at_most=100_000)
    history_duration: float = quantity(
        0.0, "s", "of histories, and then of every run; 0 = that of the scene at its median inputs", at_least=0.0
    )
    degree: int = quantity(0, "1", "of polynomial chaos; 0 = until its error is 1e-4", at_least=0, at_most=12)
    modality: str = choice("yes", ("yes", "no"), "whether modes are counted, with a bootstrap")
    sensitivity: int = quantity(
        0, "1", "rows of (inputs + 2) further samples for Sobol indices; 0 = none", at_least=0, at_most=50_000
    )
    companions: int = quantity(
        5,
        "1",
        "realisations that tell the error of the model; 0 = none, and then it is not known",
        at_least=0,
        at_most=1000,
    )
    stop: Stop = section(Stop)


@dataclass(frozen=True)
class Study:
    """A study, complete and checked.

    `scene` is the scene's plain data with what it leaves to be chosen still open; `given` maps each input's key to
    what the file says of it, `also` to further keys that take the same value; `joint` draws them. `densities` maps
    quantities to the values at which their density is asked for.
    """

    name: str
    description: str
    scene: dict
    given: dict
    also: dict[str, tuple[str, ...]]
    correlation: tuple[tuple[str, str, float], ...]
    quantities: tuple[str, ...]
    histories: tuple[str, ...]
    densities: dict[str, tuple[float, ...]]
    sweep: tuple[str, tuple[float, ...]] | None
    stop_quantity: str
    executor: str
    settings: Settings
    joint: Joint = field(compare=False, repr=False)

    @property
    def kind(self) -> str:
        """Kind of the scene."""
        return self.scene["kind"]

    @property
    def inputs(self) -> tuple[Input, ...]:
        """The uncertain inputs, in the order of the file."""
        return self.joint.inputs

    @property
    def sensitivity_rows(self) -> int:
        """Rows of (inputs + 2) further samples for Sobol indices, as many as the sampler makes of those asked for."""
        asked = self.settings.sensitivity
        return rounded(self.settings.sampler, asked) if asked else 0

    @property
    def targets(self) -> tuple[tuple[str, ...], ...]:
        """For each input the keys of the scene that take its value."""
        return tuple((one.key, *self.also.get(one.key, ())) for one in self.inputs)

    def scene_at(self, values: Iterable[float]) -> Scene:
        """The scene with these values of the inputs; raises SceneError where there is none."""
        return parse_scene(placed(self.scene, self.targets, values), "a realisation")

    def at(self, value: float) -> "Study":
        """The study at one value of its sweep, without what would be too much of: histories and the count of modes."""
        settings = dataclasses.replace(self.settings, modality="no")
        scene = put(self.scene, self.sweep[0], value)
        return dataclasses.replace(self, scene=scene, sweep=None, histories=(), settings=settings)

    def resolved(self) -> dict:
        """All keys as plain data, the scene in full; `parse_study` of it gives an equal study."""
        settings = plain(self.settings)
        settings["stop"] = {"quantity": self.stop_quantity, **settings["stop"]}
        inputs = {
            key: {**given, "also": list(self.also[key])} if key in self.also else given
            for key, given in self.given.items()
        }
        return {
            "name": self.name,
            "description": self.description,
            "scene": self.scene,
            "inputs": inputs,
            "correlation": [list(row) for row in self.correlation],
            "quantities": list(self.quantities),
            "histories": list(self.histories),
            "densities": {name: list(values) for name, values in self.densities.items()},
            **({"sweep": {self.sweep[0]: list(self.sweep[1])}} if self.sweep else {}),
            "executor": self.executor,
            **settings,
        }
