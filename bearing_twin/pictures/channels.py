"""The picture of a run whose kind has none of its own: every channel of one number over time."""

from bearing_twin.base.sample import Block
from bearing_twin.base.units import with_unit
from bearing_twin.pictures.run import RunPicture
from bearing_twin.pictures.style import BALL_COLOURS, frame, heading, scaled
from bearing_twin.pictures.values import scaled_time

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
