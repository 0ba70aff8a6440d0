"""Messages of one instant side by side, as they stand in a chunk of an MCAP file: made and written in one go.

To make, hand over and note message by message took as long as all else that a log does.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.log.encoder import Encoder

MESSAGE = 0x05  # the opcode of a message record
FIELDS = 22  # bytes of a message record besides its data, behind opcode and length
HEAD = np.dtype(
    [
        ("opcode", "u1"), ("length", "<u8"), ("channel", "<u2"), ("sequence", "<u4"), ("log_time", "<u8"),
        ("publish_time", "<u8"),
    ]
)  # fmt: skip


class Bundle(NamedTuple):
    """Whole message records of one stamp [ns]: `places` are (channel, where its record begins) in the joined `parts`.

    `size` is that of all parts in bytes; log and publish time are the stamp.
    """

    stamp_ns: int
    places: tuple[tuple[int, int], ...]
    parts: Sequence[Any]
    size: int

    def messages(self) -> Iterator[tuple[int, int, int, bytes]]:
        """(channel, log time, publish time, data) of each."""
        whole = b"".join(self.parts)
        ends = [begin for _, begin in self.places[1:]] + [self.size]
        for (channel, begin), end in zip(self.places, ends, strict=True):
            yield channel, self.stamp_ns, self.stamp_ns, whole[begin + HEAD.itemsize : end]


def alone(channel: int, stamp_ns: int, pieces: Sequence[Any]) -> Bundle:
    """A bundle of the one message that these pieces make."""
    size = sum(map(len, pieces))
    head = _heads(channel, np.array([stamp_ns]), size).tobytes()
    return Bundle(stamp_ns, ((channel, 0),), (head, *pieces), HEAD.itemsize + size)


class Bundler:
    """Gives messages a form in which a log takes them: bundles. `numbers` are the channels of topics by name."""

    def __init__(self, numbers: Mapping[str, int]):
        self._numbers = numbers

    def one(self, topic, stamp_ns: int, pieces: Sequence[Any]) -> Bundle:
        """One message."""
        return alone(self._numbers[topic.name], stamp_ns, pieces)

    def many(self, ready: Sequence[tuple[Any, Encoder, Any]], stamps_ns: np.ndarray, stamps: np.ndarray) -> list[list]:
        """Of (topic, its encoder, fields) each, the bundles of each instant, in order."""
        found: list[list] = [[] for _ in stamps_ns]
        alike: list[tuple[int, np.ndarray]] = []
        for topic, encoder, fields in ready:
            made = None if isinstance(fields, list) else encoder.together(fields, stamps_ns, stamps)
            if isinstance(made, np.ndarray):
                alike.append((self._numbers[topic.name], made))
                continue
            self._give(alike, stamps_ns, found)
            each = [[one] for one in encoder.encoded(fields, stamps_ns, stamps)] if made is None else made
            for bundles, stamp_ns, pieces in zip(found, stamps_ns.tolist(), each, strict=True):
                bundles.append(self.one(topic, stamp_ns, pieces))
        self._give(alike, stamps_ns, found)
        return found

    @staticmethod
    def _give(alike: list[tuple[int, np.ndarray]], stamps_ns: np.ndarray, found: list[list]) -> None:
        """Puts messages that are of one size at every instant side by side, a bundle an instant; empties `alike`."""
        if not alike:
            return
        size = sum(HEAD.itemsize + made.shape[1] for _, made in alike)
        rows, places, begin = np.empty((len(stamps_ns), size), np.uint8), [], 0
        for channel, made in alike:
            middle, end = begin + HEAD.itemsize, begin + HEAD.itemsize + made.shape[1]
            rows[:, begin:middle] = _heads(channel, stamps_ns, made.shape[1]).view((np.uint8, HEAD.itemsize))
            rows[:, middle:end] = made
            places.append((channel, begin))
            begin = end
        whole, places = rows.reshape(-1).data, tuple(places)
        for row, (bundles, stamp_ns) in enumerate(zip(found, stamps_ns.tolist(), strict=True)):
            bundles.append(Bundle(stamp_ns, places, (whole[row * size : (row + 1) * size],), size))
        alike.clear()


class Separate:
    """Gives messages the form in which nodes take them: (topic, stamp [ns], CDR) each."""

    def one(self, topic, stamp_ns: int, pieces: Sequence[Any]) -> tuple[Any, int, bytes]:
        """One message."""
        return topic, stamp_ns, b"".join(pieces)

    def many(self, ready: Sequence[tuple[Any, Encoder, Any]], stamps_ns: np.ndarray, stamps: np.ndarray) -> list[list]:
        """Of (topic, its encoder, fields) each, the messages of each instant, in order."""
        columns = [encoder.encoded(fields, stamps_ns, stamps) for _, encoder, fields in ready]
        topics = [topic for topic, _, _ in ready]
        return [
            [(topic, stamp_ns, data) for topic, data in zip(topics, row, strict=True)]
            for stamp_ns, row in zip(stamps_ns.tolist(), zip(*columns, strict=True), strict=True)
        ]


def _heads(channel: int, stamps_ns: np.ndarray, size: int) -> np.ndarray:
    """The heads of message records with `size` bytes of data each."""
    heads = np.zeros(len(stamps_ns), HEAD)
    heads["opcode"], heads["length"], heads["channel"] = MESSAGE, FIELDS + size, channel
    heads["log_time"] = heads["publish_time"] = stamps_ns
    return heads
