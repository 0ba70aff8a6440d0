"""The picture of a run of any length: its outputs thinned, its panels drawn by the kind, its title and foot."""

from abc import ABC, abstractmethod
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bearing_twin import __version__
from bearing_twin.base.sample import Block, Table, Thinned
from bearing_twin.base.units import prefixed, with_unit
from bearing_twin.pictures.panels import finish
from bearing_twin.pictures.style import BALL_COLOURS, SIZE, frame, heading, scaled

GREATEST_ROWS = 100_000  # outputs kept; of longer runs every second, fourth ... is


class ChannelValues(Thinned):
    """The channels of a run, thinned; `greatest` is what was seen of each that is one number."""

    def __init__(self):
        super().__init__(GREATEST_ROWS, lambda sample: {name: np.array(one) for name, one in sample.values.items()})
        self.greatest: dict[str, float] = {}

    def add(self, block: Block) -> None:
        super().add(block)
        for name, values in block.values.items():
            if values.ndim == 1:
                self.greatest[name] = max(self.greatest.get(name, -np.inf), float(values.max(initial=-np.inf)))

    def arrays(self) -> dict[str, np.ndarray]:
        """Time [s] as "time", and every channel by name, of the outputs kept; raises LogError without a sample."""
        return {"time": self.time, **self.values}


def footer(facts, values: ChannelValues) -> str:
    """Text below the picture of a run: scene, outputs, law and stepper, version."""
    thinned = f", one in {values.stride} drawn" if values.stride > 1 else ""
    words = [f"{values.outputs} output{'s' * (values.outputs != 1)}{thinned}"]
    words += [f"{name}: {text}" for name, text in (("law", facts.law), ("stepper", facts.stepper)) if text]
    if facts.scene is not None:
        words.insert(0, facts.scene.name)
    return f"{', '.join(words)}; bearing_twin {__version__}"


def scaled_time(time: np.ndarray) -> tuple[np.ndarray, float, str]:
    """Times in a readable unit, the factor from seconds, and the unit."""
    scale, unit = prefixed(float(time[-1]), "s")
    return scale * time, scale, unit


class RunPicture(ABC):
    """Base of all pictures of runs but the bearing's; each draws its panels.

    `kept` names the table of records that a picture draws from, if any.
    """

    kept = ""

    def __init__(self, facts):
        self._facts, self._values = facts, ChannelValues()
        self._records: list[np.ndarray] = []

    def add(self, block: Block) -> None:
        """Takes a block in."""
        self._values.add(block)
        if len(rows := block.records.get(self.kept, ())):
            self._records.append(rows)

    def recorded(self, table: Table, *columns: str) -> np.ndarray:
        """Columns (len(columns), n) of the records kept, which are those of `table`."""
        names = [column.name for column in table.columns]
        wanted = [names.index(name) for name in columns]
        return np.concatenate([np.empty((0, len(wanted))), *(rows[:, wanted] for rows in self._records)]).T

    @abstractmethod
    def draw(self, figure: Figure, values: dict[str, np.ndarray]) -> None:
        """Fills the figure with panels."""

    def write(self, path, errors=()) -> Path:
        """Draws what was taken in; raises BearingTwinError where there is nothing or no place for it."""
        values, scene = self._values.arrays(), self._facts.scene
        figure = Figure(figsize=SIZE, dpi=100, facecolor="white")
        self.draw(figure, values)
        title = scene.description or scene.name if scene is not None else "Recorded run"
        return finish(figure, title, footer(self._facts, self._values), path, size=17, errors=errors)


WIDTH, ROW, MARGINS, COLUMNS = 16.0, 2.6, 2.2, 2
MOST_PANELS = 16


class ChannelPicture(RunPicture):
    """One panel a channel, in the channels' order, the first 16 of them."""

    _channels = ()

    def add(self, block: Block) -> None:
        self._channels = block.channels
        super().add(block)

    def draw(self, figure, values) -> None:
        time, _, unit = scaled_time(values["time"])
        shown = [channel for channel in self._channels if channel.shape == ()][:MOST_PANELS]
        rows = max(1, -(-len(shown) // COLUMNS))
        tall = ROW * rows + MARGINS
        figure.set_size_inches(WIDTH, tall)
        edges = {"left": 0.07, "right": 0.98, "top": 1.0 - 1.4 / tall, "bottom": 1.0 / tall}
        axes = figure.subplots(rows, COLUMNS, squeeze=False, sharex=True, gridspec_kw={**edges, "hspace": 0.4})
        for place, axis in enumerate(axes.ravel()):
            if place >= len(shown):
                axis.set_axis_off()
                continue
            channel = shown[place]
            factor, prefixed = scaled(values[channel.name], channel.unit)
            frame(axis)
            line = factor * values[channel.name]
            axis.plot(time, line, color=BALL_COLOURS[place % len(BALL_COLOURS)], linewidth=1.6)
            axis.margins(x=0.0)
            heading(axis, f"{channel.name.replace('_', ' ')}: {channel.meaning}"[:90], up=with_unit(prefixed).lstrip())
        for axis in axes[-1]:
            axis.set_xlabel(f"time [{unit}]")
