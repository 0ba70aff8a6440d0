"""The picture of a run whose kind has none of its own: every channel of one number over time."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bearing_twin import __version__
from bearing_twin.pictures.style import BALL_COLOURS, frame, heading, scaled
from bearing_twin.pictures.values import ChannelValues, footer, scaled_time
from bearing_twin.pictures.worth import finish
from bearing_twin.sample import Block
from bearing_twin.units import with_unit

WIDTH, ROW, MARGINS, COLUMNS = 16.0, 2.6, 2.2, 2
MOST_PANELS = 16


class ChannelPicture:
    """One panel a channel, in the channels' order, the first 16 of them."""

    def __init__(self, facts):
        self._facts, self._values = facts, ChannelValues()
        self._channels = ()

    def add(self, block: Block) -> None:
        self._channels = block.channels
        self._values.add(block)

    def write(self, path, worth=()) -> Path:
        """Draws what was taken in; raises BearingTwinError where there is nothing or no place for it."""
        values = self._values.arrays()
        time, _, unit = scaled_time(values["time"])
        shown = [channel for channel in self._channels if channel.shape == ()][:MOST_PANELS]
        rows = max(1, -(-len(shown) // COLUMNS))
        tall = ROW * rows + MARGINS
        figure = Figure(figsize=(WIDTH, tall), dpi=100, facecolor="white")
        edges = {"left": 0.07, "right": 0.98, "top": 1.0 - 1.4 / tall, "bottom": 1.0 / tall}
        axes = figure.subplots(rows, COLUMNS, squeeze=False, sharex=True, gridspec_kw={**edges, "hspace": 0.4})
        for place, axis in enumerate(axes.ravel()):
            if place >= len(shown):
                axis.set_axis_off()
                continue
            channel = shown[place]
            factor, prefixed = scaled(values[channel.name], channel.unit)
            frame(axis)
            line = np.multiply(values[channel.name], factor)
            axis.plot(time, line, color=BALL_COLOURS[place % len(BALL_COLOURS)], linewidth=1.6)
            axis.margins(x=0.0)
            heading(axis, f"{channel.name.replace('_', ' ')}: {channel.meaning}"[:90], up=with_unit(prefixed).lstrip())
        for axis in axes[-1]:
            axis.set_xlabel(f"time [{unit}]")
        scene = self._facts.scene
        title = scene.description or scene.name if scene is not None else "Recorded run"
        return finish(figure, title, footer(self._facts, self._values, __version__), path, size=17, worth=worth)
