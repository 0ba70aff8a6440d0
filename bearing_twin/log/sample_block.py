"""Solver outputs as SampleBlock messages and back, checked: a log or a peer may have written anything."""

import math
import struct
from functools import lru_cache

import numpy as np

from bearing_twin.base.errors import LogError
from bearing_twin.base.sample import Block, Channel
from bearing_twin.kinds.bearing import renewed
from bearing_twin.log import cdr
from bearing_twin.log.cdr import Encoder, encoded
from bearing_twin.run.scene import Scene, parse_scene

MOST_SAMPLES = 1 << 20  # of a Waveform
NUMBERED = (cdr.SAMPLE_BLOCK, cdr.WAVEFORM)  # types of messages whose outputs or records have numbers


def samples_message(
    channels: tuple[Channel, ...],
    first_sequence: int,
    time_ns: np.ndarray,
    values: np.ndarray,
    frame: str = "",
    start_time_ns: int = 0,
) -> bytes:
    """bearing_twin_msgs/SampleBlock of outputs at `time_ns` (count,) with `values` (count, total width)."""
    encoder, described = _block_encoder(channels, frame)
    fields = {
        "first_sequence": np.array([first_sequence]),
        "count": np.array([len(time_ns)]),
        **described,
        "time_ns": time_ns[None],
        "values": values[None],
    }
    return encoder.encoded(fields, np.array([start_time_ns + int(time_ns[0])]))[0]


@lru_cache(maxsize=8)
def _block_encoder(channels: tuple[Channel, ...], frame: str) -> tuple[Encoder, dict]:
    """Encoder of the SampleBlocks of these channels, and the fields that are the same in all of them."""
    names, units = [channel.name for channel in channels], [channel.unit for channel in channels]
    widths = [channel.width for channel in channels]
    return Encoder(cdr.SAMPLE_BLOCK, frame), {"channel_name": names, "channel_unit": units, "channel_width": widths}


def sample_range(data: bytes) -> tuple[int, int]:
    """`first_sequence` and `count` of a SampleBlock in CDR, without decoding the rest; raises LogError."""
    try:
        order = "<" if data[1] & 1 else ">"
        frame_bytes = struct.unpack_from(order + "I", data, 12)[0]
        position = -(-(12 + frame_bytes) // 8) * 8  # counted behind the four-byte CDR header
        return struct.unpack_from(order + "QI", data, 4 + position)
    except (struct.error, IndexError) as error:
        raise LogError(
            f"a SampleBlock of {len(data)} bytes cannot be read: update publisher and recorder alike"
        ) from error


def readable_range(ros_type: str, data: bytes) -> tuple[int, int]:
    """First number and count of the outputs or records in a message, decoded and checked; raises LogError."""
    if ros_type == cdr.SAMPLE_BLOCK:
        message = cdr.deserialise(cdr.SAMPLE_BLOCK, data)
        check_block("what was sent", message)
        return int(message.first_sequence), int(message.count)
    message = checked_waveform("what was sent", data)
    return int(message.first_sequence), len(message.samples)


def waveform_message(unit: str, rate: float, rows: np.ndarray, frame: str, start_time_ns: int = 0) -> bytes:
    """bearing_twin_msgs/Waveform of the records (n, 2), time [s] and value, of a signal sampled at `rate` [Hz]."""
    first = int(np.rint(rate * rows[0, 0]))
    fields = {"first_sequence": first, "rate": rate, "unit": unit, "samples": rows[:, 1].astype(np.float32)}
    return encoded(cdr.WAVEFORM, fields, start_time_ns + round(1e9 * first / rate), frame)


def checked_waveform(place, data: bytes):
    """The Waveform in these bytes; raises LogError, naming `place`, where it says no times of its samples."""
    message = cdr.deserialise(cdr.WAVEFORM, data)
    end = message.first_sequence + len(message.samples)
    if not (0.0 < message.rate < math.inf and message.first_sequence < end < 1 << 53):
        raise LogError(f"{place}: the Waveform at sample {message.first_sequence} contradicts itself; record again")
    if (count := len(message.samples)) > MOST_SAMPLES:
        raise LogError(f"{place}: a Waveform of {count} samples is longer than is read, {MOST_SAMPLES} samples")
    return message


def records_of(place, ros_type: str, data: bytes) -> np.ndarray:
    """The records (n, columns) in a message of a topic of records; raises LogError, naming `place`."""
    if ros_type == cdr.SAMPLE_BLOCK:
        message = cdr.deserialise(cdr.SAMPLE_BLOCK, data)
        check_block(place, message)
        return message.values.reshape(message.count, -1)
    message = checked_waveform(place, data)
    numbers = message.first_sequence + np.arange(len(message.samples))
    return np.stack([numbers / message.rate, message.samples], axis=1)


def check_block(place, message) -> None:
    """Raises LogError, naming `place`, for a SampleBlock whose arrays do not belong together."""
    row = int(message.channel_width.sum(dtype=np.int64))
    fits = (
        message.count == len(message.time_ns) > 0
        and len(message.channel_name) == len(message.channel_unit) == len(message.channel_width)
        and len(message.channel_name) == len(set(message.channel_name))
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


def refuse_misfits(place, scene: Scene | None, channels: tuple[Channel, ...]) -> None:
    """Raises LogError, naming `place`, where a channel has another count of numbers than in the scene beside it."""
    known = {} if scene is None else {channel.name: channel.width for channel in scene.channels}
    for name, _, shape, *_ in channels:
        if (width := known.get(name, math.prod(shape))) != math.prod(shape):
            raise LogError(
                f"{place}: an output has {math.prod(shape)} numbers of {name}, but {width} by the scene beside it; "
                "they are of different runs, so record one of them"
            )


def block_of(channels: tuple[Channel, ...], message) -> Block:
    """The outputs of a SampleBlock of these channels, as they are written today."""
    # A copy: what a message holds can only be read.
    matrix = np.array(message.values).reshape(message.count, -1)
    block = Block(channels, int(message.first_sequence), np.array(message.time_ns), matrix)
    renewed(block)
    return block
