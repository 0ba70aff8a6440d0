"""The contract of a kind of scene: what it gives to the rest of the house in one row, `Kind`; protocols of its parts.

`parameters`, `motion` and `channels` are needed; what else a kind leaves out is drawn from its channels. Parts that
compute or plot are given as `lazy_import`, so that reading the table imports nothing heavy, not even arrays.
"""

from __future__ import annotations

import importlib
import itertools
import math
from collections.abc import Callable, Container, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

from bearing_twin.base.report import Choice
from bearing_twin.base.units import key_suffix, key_unit
from bearing_twin.kinds.error_estimates import Comparison, ModelErrors, UnknownErrors

if TYPE_CHECKING:
    import numpy as np

    from bearing_twin.base.sample import Block, Channel, Sample, Table

STORED = ("kinetic_energy", "elastic_energy", "potential_energy")  # channels of the energy that a scene stores
ENERGY_GAIN = 0.01  # of the energy brought or the work moved; where less exactness is wanted, as much as that


def adds_up(closure: float, parameters) -> bool:
    """True if the relative energy gained or lost by the method is at most ENERGY_GAIN or the requested tolerance."""
    return abs(closure) <= max(ENERGY_GAIN, parameters.wanted.tolerance)


class ChannelFigure(NamedTuple):
    """A figure drawn from a channel of one number: its name, its key with the unit, and its meaning."""

    channel: Channel
    name: str
    key: str
    meaning: str


def channel_figures(channels: tuple[Channel, ...]) -> Iterator[tuple[ChannelFigure, ChannelFigure]]:
    """Two figures of each channel of one number: its value at the end, and its greatest magnitude."""
    for channel in channels:
        if channel.shape == ():
            names = {f"{channel.name}_at_end": "at the end", f"greatest_{channel.name}": "greatest magnitude"}
            yield tuple(
                ChannelFigure(channel, name, name + key_suffix(channel.unit), f"{channel.meaning}, {words}")
                for name, words in names.items()
            )


class ChannelFigures:
    """The figures of a kind that has no better ones: `channel_figures` without the keys that others have `taken`."""

    def __init__(self, parameters, choice: Choice, channels: tuple[Channel, ...], taken: Container[str] = ()):
        self._drawn, self._taken = tuple(channel_figures(channels)), taken
        self._last: dict[str, float] = {}
        self._greatest: dict[str, float] = {}

    def add(self, block: Block) -> None:
        for at_end, greatest in self._drawn:
            values = block.values[at_end.channel.name]
            self._last[at_end.key] = float(values[-1])
            self._greatest[greatest.key] = max(self._greatest.get(greatest.key, 0.0), float(abs(values).max()))

    def figures(self) -> dict[str, Any]:
        """`<channel>_at_end_<unit>` and `greatest_<channel>_<unit>`."""
        known = self._last | self._greatest
        return {
            figure.key: known.get(figure.key, math.nan)
            for pair in self._drawn
            for figure in pair
            if figure.key not in self._taken
        }

    def flags(self) -> list[str]:
        """None: nothing is known of this theory."""
        return []

    def status(self) -> str:
        """Gives "done" while all numbers are finite."""
        return "done" if all(map(math.isfinite, self._last.values())) else "failed: not finite"


PUBLISH, SAMPLES, MARKERS, ONCE, SECOND = "publish", "samples", "markers", "once", "second"
"""Rate of a topic: the scene's publish rate, every output in blocks, at 20 Hz, at the start, 1 Hz."""


def lazy_import(target: str) -> Callable:
    """The function or class at "module:name", imported at the first call; of a table there, what gives it."""

    def call(*arguments, **named):
        module, _, name = target.partition(":")
        attribute = getattr(importlib.import_module(module), name)
        return attribute(*arguments, **named) if callable(attribute) else attribute

    call.__name__ = target
    return call


class SceneParameters:
    """Base of the dataclass of a kind's YAML: what its keys mean together, and what earlier versions called them.

    Attributes
    ----------
    moved : mapping
        Keys of earlier versions, and the words that say which keys replace them.
    facts : mapping
        Numbers of the scene by name, functions of the parameters, for the ranges of `kinds.rules`; None: not known.
    """

    moved: ClassVar[Mapping[str, str]] = {}
    facts: ClassVar[Mapping[str, Callable[[Any], float | None]]] = {}

    def __deepcopy__(self, memo) -> SceneParameters:
        return self  # they never change, and writers of figures that hold them are copied for every report

    @staticmethod
    def completed(scene: dict) -> tuple[dict, list[str]]:
        """The plain data of a scene with what it refers to, such as a row of a catalogue, filled in; what is wrong."""
        return scene, []

    @staticmethod
    def upgraded(scene: dict) -> dict:
        """The plain data of a scene in today's words, from those of the log of an earlier version."""
        return scene

    def check(self) -> list[str]:
        """Contradictions between keys, one sentence each that names keys, values and limits."""
        return []

    def resolve(self):
        """The parameters of a checked scene with what it leaves open chosen."""
        return self

    def missing_figures(self) -> Mapping[str, str]:
        """Figures that a run of the scene does not have, by their keys, with the reason."""
        return {}

    def closed_form(self) -> ClosedForm | None:
        """The closed forms of the scene's quantities, many scenes at once; None where it has none."""
        return None


class Motion(Protocol):
    """Motion of a scene, made from its parameters and the choice of a model.

    1. `advance` does not depend on how a run is cut into chunks: twice 10 ms give what 20 ms give.
    2. `take_records` gives each record once, in order of time, those up to the end of the last chunk.
    3. Whatever cannot go on raises IntegrationError with reason, seconds and body.
    4. A motion with an attribute `stop` (1,) raises Stopped soon after it is not 0; one without is quick.
    5. A motion that has `snapshot()` gives its state as plain data, from which `resume(snapshot)` of a motion with
       other tolerances goes on; one without begins again.
    6. Outputs may be `Columns` of all channels, never copied; `longest_chunk` [s] is what a quick one does in one go.
    7. A motion whose kind has `commands` also has the methods of `CommandedMotion`.
    """

    def reset(self) -> None:
        """Back to the start."""

    def first_outputs(self) -> tuple[np.ndarray, ...]:
        """One array (1, *shape) a channel, in the channels' order, at the present instant."""

    def advance(self, times: np.ndarray, duration: float) -> tuple[np.ndarray, ...]:
        """Moves on by `duration` [s]; one array (len(times), *shape) a channel at `times` [s] from now, increasing."""

    def take_records(self) -> dict[str, np.ndarray]:
        """Rows of each of the kind's tables since the last call."""

    def costs(self) -> dict[str, int]:
        """Steps, evaluations and what else the motion cost so far."""


class CommandedMotion(Motion, Protocol):
    """A motion that obeys commands on its way. A load is a force (3,) [N] and a moment [N m]; None: the scene's own.

    One that a torque may drive has `set_torque(torque)` [N m].
    """

    goal_speed: float  # rad/s

    def take_back(self) -> None:
        """Back to before the last `advance`."""

    def check_drive(self, key: str, value: float, load: tuple) -> str:
        """A warning of a "speed" [rad/s] or "torque" [N m] that is commanded while the load acts, "" for none.

        Raises BearingTwinError for one that the drive does not take, or at which the load is not carried.
        """

    def check_load(self, force, moment) -> None:
        """Raises BearingTwinError for a load that is not carried at the goal speed."""

    def set_load(self, force, moment) -> None:
        """The load from now on, which `check_load` let pass."""

    def operating_point(self, sample: Sample) -> OperatingPoint:
        """Loads and stiffness where an output stands, the balls in balance at their places; raises BearingTwinError."""


class Figures(Protocol):
    """The one writer of a run's figures: blocks in, numbers out, the same for a run, its log, a study and a node."""

    def add(self, block: Block) -> None:
        """Add a block; every block but the last ends before a sequence number divisible by 50."""

    def figures(self) -> dict[str, Any]:
        """Numbers by SI-suffixed keys; the kind's `meanings` say what each is."""

    def flags(self) -> list[str]:
        """Warnings of a run outside the limits of the theory, one sentence each."""

    def status(self) -> str:
        """Gives "done", or what failed."""


class Picture(Protocol):
    """The picture of one run, made from its scene, which is None for a log that does not hold one, and the choice."""

    def add(self, block: Block) -> None:
        """Add a block."""

    def write(self, path, errors=()) -> Any:
        """Draw the blocks and the `errors` of figures; return the path. Raises BearingTwinError."""


class Topic(NamedTuple):
    """One topic: name below the kind's namespace, ROS type, rate class, builder of its fields, meaning.

    `fields(output)` gives the messages' fields by name, nested messages as mappings, arrays as arrays; every header,
    with `frame`, is filled in by who sends it. It takes many outputs at once, as one `Output` whose sample has one row
    an output in front of all its arrays; so have the arrays it gives. What is no array is the same in every message of
    the topic. None: the stream itself builds the topic (samples, records, scene). Of a topic that is published once the
    output is one; of one at 1 Hz `fields(parameters)` makes what takes blocks by `add(block)` and gives the fields of
    one message by `fields()`.
    `full_name`, with the namespace, and the quality of service `qos` are put in by `log.stream.topics`.
    """

    name: str
    ros_type: str
    rate: str
    fields: Callable[[Any], Any] | None
    meaning: str
    frame: str = ""
    full_name: str = ""
    qos: Any = None


class Command(NamedTuple):
    """A topic that a running simulation obeys: name below the kind's namespace, ROS type, what to do, meaning.

    `order(message)` gives the name of a method of the simulation, such as `set_load`, and its arguments; it raises
    BearingTwinError for what cannot be meant. A message with a header must be in `frame`, or name none.
    """

    name: str
    ros_type: str
    order: Callable[[Any], tuple]
    meaning: str
    frame: str = ""


class OperatingPoint(NamedTuple):
    """An inner ring or a shaft at one output: `coordinates` and `loads` from outside (5,), `stiffness` (5, 5), SI.

    In the order x, y, z, theta_x, theta_y; `stiffness` is d(loads)/d(coordinates), balls in balance at their places,
    turning at `speed` [rad/s].
    """

    coordinates: np.ndarray
    loads: np.ndarray
    stiffness: np.ndarray
    speed: float


@dataclass(frozen=True, eq=False)
class Output:
    """One solver output, or several together, on its way out: what several topics need of it is computed once."""

    parameters: Any
    law: str
    sample: Sample
    frame_prefix: str = ""
    _known: dict = field(default_factory=dict)

    def once(self, function: Callable[[Any, Sample], Any]) -> Any:
        """`function(parameters, sample)`, computed at the first call."""
        if function not in self._known:
            self._known[function] = function(self.parameters, self.sample)
        return self._known[function]

    def frame(self, name: str) -> str:
        """The name under which the frame `name` of the scene is known in tf."""
        return f"{self.frame_prefix}{name}"


def length(value) -> float:
    """A number itself, the length of a vector."""
    return math.hypot(*value) if hasattr(value, "__len__") else value


class Quantity(NamedTuple):
    """A quantity of studies: what `pick` makes of the figures at `keys`, a number in the unit of the first of them.

    Its `meaning` is that of this figure, or as given; `closed` is a vectorised closed form or None. `whole`: not of
    `wanted.outputs: peaks`, which moves contacts alone.
    """

    keys: tuple[str, ...]
    pick: Callable[..., float] = length
    meaning: str = ""
    closed: Callable[..., np.ndarray] | None = None
    whole: bool = False

    @property
    def unit(self) -> str:
        """The SI unit."""
        return key_unit(self.keys[0])

    def figure(self, figures: Mapping) -> float:
        """The quantity of a run with these figures; NaN where one is missing."""
        values = [figures.get(key) for key in self.keys]
        return math.nan if any(value is None for value in values) else float(self.pick(*values))


def figure_quantities(*keys: str) -> dict[str, Quantity]:
    """Quantities that are the figures at these keys, named as they are without the unit."""
    return {key.removesuffix(key_suffix(key_unit(key))): Quantity((key,)) for key in keys}


class ClosedForm(NamedTuple):
    """Shared part of closed forms of quantities: `bodies(parameters)` is passed to each of them.

    Parameters may hold arrays in place of numbers. `histories` maps channels to functions (times, *bodies) -> array.
    Scenes whose keys `without` are uncertain have none.
    """

    bodies: Callable[[Any], tuple]
    histories: dict[str, Callable]
    no_solution: str
    without: tuple[str, ...] = ()


def one_model(parameters) -> Choice:
    """The choice of a kind with one law and one method."""
    return Choice("-", "-", 0.0, "this kind has one model", ())


def nothing(parameters) -> tuple:
    """The tables of a kind whose outputs say all, and the topics of one beside its samples, records and scene."""
    return ()


@dataclass(frozen=True)
class Kind:
    """One row of `KINDS`: all that is known of a kind of scene.

    Attributes
    ----------
    name, help : str
        The word of `kind:` in a scene, and what it stands for.
    parameters : type
        The dataclass of its YAML, a `SceneParameters`.
    motion : callable
        The `Motion` of parameters and a choice.
    channels : callable
        What an output of these parameters holds.
    choose : callable
        The law and the method for parameters that are checked and resolved.
    records : callable
        Tables of what happens between outputs.
    figures, meanings : callable
        The `Figures` of parameters and a choice, and what each of their keys is; None: of the channels.
    quantities : callable
        What a study may ask, by name; None: every figure drawn from the channels.
    model_errors : callable
        The `ModelErrors` of parameters and a choice.
    comparison : callable
        The `Comparison` with a second run of parameters and a choice; None: there is none.
    brief : bool
        True if a run ends by itself, and is played slowly.
    commands : callable
        Topics that a run obeys; its motion is then a `CommandedMotion`.
    topics : callable
        Topics of parameters, beside samples, records and the scene.
    picture, view : callable
        The `Picture` of a scene and a choice; the `views.View` of parameters and channels for the browser.
    place_of : callable
        The body and the contact that a number of a channel belongs to, by its index; "" for none.
    """

    name: str
    help: str
    parameters: type[SceneParameters]
    motion: Callable[[Any, Choice], Motion | CommandedMotion]
    channels: Callable[[Any], tuple[Channel, ...]]
    choose: Callable[[Any], Choice] = one_model
    records: Callable[[Any], tuple[Table, ...]] = nothing
    figures: Callable[[Any, Choice], Figures] | None = None
    meanings: Callable[[], Mapping[str, str]] | None = None
    quantities: Callable[[], dict[str, Quantity]] | None = None
    model_errors: Callable[[Any, Choice], ModelErrors] = UnknownErrors
    comparison: Callable[[Any, Choice], Comparison] | None = None
    brief: bool = False
    commands: Callable[[], tuple[Command, ...]] = tuple
    topics: Callable[[Any], tuple[Topic, ...]] = nothing
    picture: Callable[[Any, Choice], Picture] = field(default=lazy_import("bearing_twin.kinds.picture:RunPicture"))
    view: Callable[..., Any] = field(default=lazy_import("bearing_twin.kinds.views:plain_view"))
    place_of: Callable[[Channel, tuple[int, ...]], tuple[str, str]] = lambda channel, index: ("", "")

    @property
    def namespace(self) -> str:
        """Namespace of the topics of a scene."""
        return f"/{self.name}"

    @property
    def frame(self) -> str:
        """The frame of the scene."""
        return f"{self.name}_link"

    def figures_of(self, parameters, choice: Choice) -> Figures:
        """An empty figures writer of a scene of this kind."""
        if self.figures is None:
            return ChannelFigures(parameters, choice, self.channels(parameters))
        return self.figures(parameters, choice)

    def meanings_of(self) -> Mapping[str, str]:
        """Meaning of each key of the figures: at the end, the greatest, the mean over which part."""
        if self.meanings is not None:
            return self.meanings()
        return {figure.key: figure.meaning for figure in self._drawn()}

    def _drawn(self) -> Iterator[ChannelFigure]:
        return itertools.chain.from_iterable(channel_figures(self.channels(self.parameters())))

    def quantities_of(self) -> dict[str, Quantity]:
        """Quantities of studies; by default every figure drawn from the channels."""
        meanings = self.meanings_of()
        if self.quantities:
            quantities = self.quantities()
        else:
            quantities = {figure.name: Quantity((figure.key,)) for figure in self._drawn()}
        return {
            name: quantity._replace(meaning=quantity.meaning or meanings[quantity.keys[0]])
            for name, quantity in quantities.items()
        }


def parts_in(home: str, **targets: str) -> dict[str, Callable]:
    """Parts of a `Kind` at "module:name" in the package `home`, imported at their first call."""
    return {part: lazy_import(f"{home}.{target}") for part, target in targets.items()}
