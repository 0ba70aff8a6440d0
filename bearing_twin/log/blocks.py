"""SampleBlock messages back as blocks of solver outputs, checked: what a log or a peer says may be wrong."""

import numpy as np

from bearing_twin.errors import LogError
from bearing_twin.run.scene import Scene, parse_scene
from bearing_twin.sample import Block, Channel


def check_block(place, message) -> None:
    """Raises LogError, naming `place`, for a SampleBlock whose arrays do not belong together."""
    row = int(message.channel_width.sum(dtype=np.int64))
    fits = (
        message.count == len(message.time_ns) > 0
        and len(message.channel_name) == len(message.channel_unit) == len(message.channel_width)
        and len(message.values) == message.count * row
    )
    if not fits:
        raise LogError(f"{place}: the SampleBlock at output {message.first_sequence} contradicts itself; record again")


def channels_of(scene: Scene | None, message) -> tuple[Channel, ...]:
    """The channels of a SampleBlock; shapes and meanings where the names are those of a bearing, else flat."""
    widths = dict(zip(message.channel_name, message.channel_width.tolist(), strict=True))
    if scene is None and widths.get("orbit_angle"):
        scene = parse_scene({"kind": "bearing", "geometry": {"balls": widths["orbit_angle"]}}, "recorded")
    known = {channel.name: channel for channel in scene.channels} if scene is not None else {}
    rows = []
    for (name, width), unit in zip(widths.items(), message.channel_unit, strict=True):
        channel = known.get(name)
        fits = channel is not None and channel.width == width and channel.unit == unit
        rows.append(channel if fits else Channel(name, unit, (width,), ""))
    return tuple(rows)


def block_of(channels: tuple[Channel, ...], message) -> Block:
    """The outputs of a SampleBlock of these channels."""
    # A copy: what a message holds can only be read.
    matrix = np.array(message.values).reshape(message.count, -1)
    return Block(channels, int(message.first_sequence), np.array(message.time_ns), matrix)
