"""A log that fills no disk: of each topic some messages a second, and some solver outputs.

What comes seldom, or says what happened between outputs, is kept whole: what is latched, and records.
"""

import math
from collections.abc import Mapping

import numpy as np

from bearing_twin.log import cdr
from bearing_twin.log.encoding import encoded
from bearing_twin.log.stream import SLOW_RATE

KEPT_RATE = 5.0  # 1/s: an hour of a bearing of eight balls takes 0.3 GB then, and 15 GB whole
KEPT_KEY = "kept_rate_hz"  # of a topic in a log, beside what rosbag2 says of it
WHOLE_SPAN = 0.5e9 / SLOW_RATE  # ns: a SampleBlock that covers less is an impact or the end of a run


def kept_rate(metadata: Mapping[str, str]) -> float:
    """How many messages a second of a topic are in a log [1/s], by what stands beside it; 0 = all."""
    try:
        rate = float(metadata.get(KEPT_KEY, ""))
    except ValueError:
        return 0.0
    return rate if 0.0 < rate < math.inf else 0.0


class Thinning:
    """What of one topic is kept at `rate` [1/s]: the first message, or of a SampleBlock the first output, of a period.

    Messages go by the time at which they are logged, outputs by the simulation's.
    """

    def __init__(self, ros_type: str, rate: float):
        self._period = round(1e9 / rate)
        self._outputs = ros_type == cdr.SAMPLE_BLOCK
        self._last = -1

    def kept(self, log_time_ns: int, data: bytes) -> bytes | None:
        """What to log of a message, None = nothing of it; raises LogError for a SampleBlock that is none."""
        if self._outputs:
            return self._thinned(data)
        period, earlier = log_time_ns // self._period, self._last
        self._last = period
        return None if period == earlier else data

    def _thinned(self, data: bytes) -> bytes | None:
        block = cdr.deserialise(cdr.SAMPLE_BLOCK, data)
        if not len(block.time_ns) == block.count > 0 or len(block.values) % block.count:
            return data  # it contradicts itself: whoever reads it is told
        if block.time_ns[-1] - block.time_ns[0] < WHOLE_SPAN:
            return data
        periods = block.time_ns // self._period
        rows = np.flatnonzero(periods != np.concatenate(([self._last], periods[:-1])))
        self._last = int(periods[-1])
        if not len(rows):
            return None
        row = rows[0]  # no other: a SampleBlock is shorter than a period
        values = np.reshape(block.values, (block.count, -1))[row]
        stamp_ns = int(block.header.stamp.sec) * 10**9 + int(block.header.stamp.nanosec)
        fields = {
            "first_sequence": int(block.first_sequence) + int(row),
            "count": 1,
            "channel_name": block.channel_name,
            "channel_unit": block.channel_unit,
            "channel_width": block.channel_width,
            "time_ns": block.time_ns[row : row + 1],
            "values": values,
        }
        stamp_ns += int(block.time_ns[row] - block.time_ns[0])
        return encoded(cdr.SAMPLE_BLOCK, fields, stamp_ns, block.header.frame_id)
