"""Outputs as SampleBlock messages: every channel side by side."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from bearing_twin.log import cdr
from bearing_twin.log.encoder import Encoder, stamps_of
from bearing_twin.sample import Channel


def samples_message(
    channels: tuple[Channel, ...],
    first_sequence: int,
    time_ns: np.ndarray,
    values: np.ndarray,
    frame: str = "",
) -> bytes:
    """bearing_twin_msgs/SampleBlock of outputs at `time_ns` (count,) with `values` (count, total width)."""
    return b"".join(samples_pieces(channels, first_sequence, time_ns, values, 0, frame))


def samples_pieces(channels, first_sequence, time_ns, values, start_time_ns, frame) -> Sequence:
    """The pieces of a `samples_message`: large arrays are not copied."""
    encoder, described = _block_encoder(channels, frame)
    fields = {
        "first_sequence": np.array([first_sequence]),
        "count": np.array([len(time_ns)]),
        **described,
        "time_ns": time_ns[None],
        "values": values[None],
    }
    stamps_ns = np.array([start_time_ns + int(time_ns[0])])
    [pieces] = encoder.together(fields, stamps_ns, stamps_of(stamps_ns))
    return pieces if isinstance(pieces, list) else [pieces.data]


@lru_cache(maxsize=8)
def _block_encoder(channels: tuple[Channel, ...], frame: str) -> tuple[Encoder, dict]:
    """What encodes the SampleBlocks of these channels, and the fields that are the same in all of them."""
    names, units = [channel.name for channel in channels], [channel.unit for channel in channels]
    widths = [channel.width for channel in channels]
    return Encoder(cdr.SAMPLE_BLOCK, frame), {"channel_name": names, "channel_unit": units, "channel_width": widths}
