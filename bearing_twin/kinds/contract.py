"""What a kind of scene gives to the rest of the house: one row, `Kind`, and the protocols of its parts.

`parameters`, `motion` and `channels` are needed; what else a kind leaves out is drawn from its channels. Parts that
compute or plot are named by `late`, so that reading the table imports nothing heavy, not even arrays.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from bearing_twin.base.report import Choice
from bearing_twin.base.units import suffix_of
from bearing_twin.kinds.doubt import Doubt, NothingKnown
from bearing_twin.kinds.plain_figures import PlainFigures
from bearing_twin.kinds.refinement import Comparison

if TYPE_CHECKING:
    import numpy as np

    from bearing_twin.base.sample import Block, Channel, Sample, Table

PUBLISH, SAMPLES, MARKERS, ONCE = "publish", "samples", "markers", "once"
"""How often a topic is given out: at the scene's publish rate, every output in blocks, at 20 Hz, or at the start."""


class Motion(Protocol):
    """What moves a scene, made from its parameters and the choice of a model.

    1. `advance` does not depend on how a run is cut into chunks: twice 10 ms give what 20 ms give.
    2. `take_records` gives each record once, in order of time, those up to the end of the last chunk.
    3. Whatever cannot go on raises IntegrationError with reason, seconds and body.
    4. A motion with an attribute `stop` (1,) raises Stopped soon after it is not 0; one without is quick.
    5. A motion that has `snapshot()` gives its state as plain data, from which `resume(snapshot)` of a motion with
       other tolerances goes on; one without begins again.
    6. Outputs may be `Columns` of all channels, never copied; `longest_chunk` [s] is what a quick one does in one go.
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


class Figures(Protocol):
    """The one writer of a run's figures: blocks in, numbers out, the same for a run, its log, a study and a node."""

    def add(self, block: Block) -> None:
        """Takes a block in; every block but the last ends before a sequence number divisible by 50."""

    def figures(self) -> dict[str, Any]:
        """Numbers by SI-suffixed keys; the kind's `meanings` say what each is."""

    def flags(self) -> list[str]:
        """What lies outside the theory's validity, one sentence each."""

    def status(self) -> str:
        """Gives "done", or what failed."""


class Facts(NamedTuple):
    """What a picture says about where its numbers come from; `scene` is None for a log that does not hold one."""

    scene: Any
    law: str
    stepper: str


class Picture(Protocol):
    """The picture of one run, made from `Facts`."""

    def add(self, block: Block) -> None:
        """Takes a block in."""

    def write(self, path, errors=()) -> Any:
        """Draws what was taken in, and the `errors` of figures; returns the path. Raises BearingTwinError."""


class Topic(NamedTuple):
    """One topic: name below the kind's namespace, ROS type, rate class, builder of its fields, meaning.

    `fields(output)` gives the message's fields by name, nested messages as mappings, arrays as arrays; every header,
    with `frame`, is filled in by who sends it. None: the stream itself builds the topic (samples, records, scene).
    `together`: `fields` takes many outputs at once, as one `Output` whose sample has one row an output in front of all
    its arrays; so have the arrays it gives. What is no array is then the same in every message of the topic.
    """

    name: str
    ros_type: str
    rate: str
    fields: Callable[[Output], Mapping[str, Any]] | None
    meaning: str
    frame: str = ""
    together: bool = False


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
    """A bearing's inner ring at one output: `coordinates` and `loads` from outside (5,), `stiffness` (5, 5), SI.

    In the order x, y, z, theta_x, theta_y; `stiffness` is d(loads)/d(coordinates), balls in balance at their places.
    """

    coordinates: np.ndarray
    loads: np.ndarray
    stiffness: np.ndarray


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


class Quantity(NamedTuple):
    """What a study may ask: `unit`, `meaning`, `figure` of a run's figures, vectorised `closed` form or None.

    `whole`: not of `wanted.outputs: peaks`, which moves contacts alone. `missing`: why a scene has none, or nothing.
    """

    unit: str
    meaning: str
    figure: Callable[[Mapping], float]
    closed: Callable[..., np.ndarray] | None = None
    whole: bool = False
    missing: Callable[[Any], str] = lambda parameters: ""


class ClosedForm(NamedTuple):
    """When a kind has closed forms, and what they share: `bodies(parameters)` is handed to each of them.

    Parameters may hold arrays in place of numbers. `histories` maps channels to functions (times, *bodies) -> array.
    """

    describes: Callable[[Any], bool]
    bodies: Callable[[Any], tuple]
    histories: dict[str, Callable]
    no_solution: str
    without: tuple[str, ...] = ()


def late(place: str) -> Callable:
    """The function or class at "module:name", imported at the first call; of a table there, what gives it."""

    def call(*arguments, **named):
        module, _, name = place.partition(":")
        found = getattr(importlib.import_module(module), name)
        return found(*arguments, **named) if callable(found) else found

    call.__name__ = place
    return call


def no_problems(parameters) -> list[str]:
    """The check of a kind whose keys cannot contradict each other."""
    return []


def as_given(parameters):
    """The resolution of a kind that leaves nothing to be chosen."""
    return parameters


def one_model(parameters) -> Choice:
    """The choice of a kind with one law and one method."""
    return Choice("-", "-", 0.0, "this kind has one model", ())


def nothing(parameters) -> tuple:
    """The tables of a kind whose outputs say all, and the topics of one beside its samples, records and scene."""
    return ()


def read_off(key: str, pick: Callable = lambda value: value) -> Callable[[Mapping], float]:
    """A quantity's `figure`: that key of the figures, through `pick`; NaN where a run has none."""
    return lambda figures: math.nan if figures.get(key) is None else float(pick(figures[key]))


@dataclass(frozen=True)
class Kind:
    """One row of `KINDS`: all that is known of a kind of scene.

    `parameters` is the dataclass of its YAML, `home` the module whose import registers the kind. `brief`: a run ends by
    itself. `refined(parameters, choice)`: those of a second run, None where there is nothing to refine; `comparison`
    says what is compared. `doubt`: see `Doubt`. `animated`: to a .gif. `facts`: numbers that `ranges` are about.
    `commands`: topics obeyed under way. Its motion then has `take_back()`, to before the last `advance`, a `goal_speed`
    [rad/s] and, where `check_load(parameters, law, speed, force, moment)` raises nothing, `set_load(force, moment)`;
    None for both is the scene's own load. `check_drive(parameters, law, key, value, load)` refuses a "speed", or a
    "torque" for `set_torque`; `speed_doubt(parameters, speed)` is a sentence on a commanded speed above the limiting
    one. `operating_point(parameters, law, sample)` raises where none is. `view(facts, channels)`: a `views.View`.
    `moved` maps earlier keys to those; `upgraded` rewrites an old log's scene, `renewed` its blocks. `catalogue()` maps
    names to scenes; `completed(scene)` fills them in.
    """

    name: str
    help: str
    home: str
    parameters: type
    motion: Callable[[Any, Choice], Motion]
    channels: Callable[[Any], tuple[Channel, ...]]
    check: Callable[[Any], list[str]] = no_problems
    resolve: Callable[[Any], Any] = as_given
    choose: Callable[[Any], Choice] = one_model
    facts: Mapping[str, Callable[[Any], float | None]] = field(default_factory=dict)
    records: Callable[[Any], tuple[Table, ...]] = nothing
    figures: Callable[[Any, Choice], Figures] | None = None
    meanings: Callable[[], Mapping[str, str]] | None = None
    doubt: Callable[[Any, Choice], Doubt] = NothingKnown
    refined: Callable[[Any, Choice], tuple[Any, Choice] | None] | None = None
    comparison: Callable[[Any, Choice], Comparison] = Comparison
    quantities: Callable[[], dict[str, Quantity]] | None = None
    closed_form: Callable[[], ClosedForm | None] = lambda: None
    known_when_solved: bool = False
    brief: bool = False
    commands: Callable[[], tuple[Command, ...]] = tuple
    check_drive: Callable[..., None] | None = None
    speed_doubt: Callable[[Any, float], str] = lambda parameters, speed: ""
    check_load: Callable[..., None] | None = None
    operating_point: Callable[[Any, str, Sample], OperatingPoint] | None = None
    frame: str = "world"
    topics: Callable[[Any], tuple[Topic, ...]] = nothing
    picture: Callable[[Facts], Picture] = field(default=late("bearing_twin.pictures.run:ChannelPicture"))
    animated: bool = False
    view: Callable[..., Any] = field(default=late("bearing_twin.kinds.views:plain_view"))
    moved: Mapping[str, str] = field(default_factory=dict)
    upgraded: Callable[[dict], dict] = as_given
    renewed: Callable[[Block], Any] = as_given
    catalogue: Callable[[], Mapping[str, dict]] = dict
    completed: Callable[[dict], tuple[dict, list[str]]] = lambda scene: (scene, [])
    place_of: Callable[[Channel, tuple[int, ...]], tuple[str, str]] = lambda channel, index: ("", "")

    @property
    def namespace(self) -> str:
        """Where the topics of such a scene stand."""
        return f"/{self.name}"

    def figures_of(self, parameters, choice: Choice) -> Figures:
        """An empty figures writer of a scene of this kind."""
        if self.figures is None:
            return PlainFigures(parameters, choice, self.channels(parameters))
        return self.figures(parameters, choice)

    def meanings_of(self) -> Mapping[str, str]:
        """What each key of the figures is: at the end, the greatest, the mean over which part."""
        if self.meanings is not None:
            return self.meanings()
        return {key: f"{channel.meaning}, {words}" for channel, _, key, words in self._drawn()}

    def _drawn(self) -> Iterator[tuple[Channel, str, str, str]]:
        """(channel, name, key, when) of each of `PlainFigures`."""
        for channel in self.channels(self.parameters()):
            if channel.shape == ():
                suffix = suffix_of(channel.unit)
                yield channel, f"{channel.name}_at_end", f"{channel.name}_at_end{suffix}", "at the end"
                yield channel, f"greatest_{channel.name}", f"greatest_{channel.name}{suffix}", "greatest magnitude"

    def quantities_of(self) -> dict[str, Quantity]:
        """What a study may ask; by default every figure drawn from the channels."""
        if self.quantities is not None:
            return self.quantities()
        rows = ((name, channel, f"{channel.meaning}, {words}", key) for channel, name, key, words in self._drawn())
        return {name: Quantity(channel.unit, meaning, read_off(key)) for name, channel, meaning, key in rows}
