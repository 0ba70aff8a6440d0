"""The files of a log, one after the other: a new one when the last has become large or long, the oldest removed.

Each file can be read alone: topics, metadata and the last latched messages are repeated in it.
"""

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from textwrap import indent
from typing import NamedTuple

from mcap.records import Attachment, Metadata

import bearing_twin
from bearing_twin.errors import LogError
from bearing_twin.log.bag import SUFFIX, LoggedTopic, Span, bag_information
from bearing_twin.log.bundles import Bundle
from bearing_twin.log.mcap_write import McapWriter

BAG_RECORD = "rosbag2"


class Safety(NamedTuple):
    """What a log does against loss, and how much room it takes.

    Every `max_loss` seconds what there is goes to disk, with `fsync` past its caches; 0 = as chunks become full, so
    that the same messages give the same bytes. A `patient` log raises no error while the disk is full: it keeps what
    fits into memory, counts the rest, says `problem`, and goes on when there is room. A new file begins after
    `split_bytes` or `split_seconds` of messages, and the `keep` newest stay; 0 = not, all. Of each topic `kept_rate`
    messages a second are in the log, and as many outputs (see `thinning`); 0 = all.
    """

    max_loss: float = 0.0
    fsync: bool = False
    patient: bool = False
    split_bytes: int = 0
    split_seconds: float = 0.0
    keep: int = 0
    kept_rate: float = 0.0


class Told:
    """What a log tells of itself, as `_log`, by which it is written, knows it."""

    _log: "Told | Parts"

    @property
    def problem(self) -> str:
        """Why the log cannot grow at present and what was kept, empty while it can."""
        return self._log.problem

    @property
    def dropped(self) -> int:
        """Messages for which there was no room, neither on disk nor in memory."""
        return self._log.dropped

    @property
    def bytes(self) -> int:
        """Size of the log on disk so far."""
        return self._log.bytes


class _Described(NamedTuple):
    row: LoggedTopic
    definition: str


class Parts:
    """The files of a log at `name(0)`, `name(1)`, ..., written as one; see `Safety`. Errors are `McapWriter`'s."""

    def __init__(self, name: Callable[[int], Path], safety: Safety):
        self._name, self._safety = name, safety
        self._number = 0
        self._topics: dict[int, _Described] = {}
        self._metadata: dict[str, Metadata] = {}
        self._repeated: set[int] = set()  # latched topics, of which each file has the last message; none without split
        self._latched: dict[int, tuple[int, bytes]] = {}
        self._done: list[Span] = []  # files that are complete and still there
        self._totals: dict[int, int] = {}  # messages of complete files, by topic
        self._dropped = 0
        self._began: int | None = None  # time of the first message of the file [ns]
        self._splits = bool(safety.split_bytes or safety.split_seconds)
        self._writer = self._open(0)

    @property
    def path(self) -> Path:
        """The file that is written now."""
        return self._name(self._number)

    @property
    def begun(self) -> bool:
        """Whether a message has been written."""
        return self._number > 0 or self._writer.begun

    @property
    def messages(self) -> int:
        """Messages on disk for good."""
        return sum(self._totals.values()) + sum(self._writer.counts.values())

    @property
    def bytes(self) -> int:
        """Size of all files."""
        return sum(one.bytes for one in self._done) + self._writer.bytes

    @property
    def dropped(self) -> int:
        """Messages for which there was no room."""
        return self._dropped + self._writer.dropped

    @property
    def problem(self) -> str:
        """Why the log cannot grow at present, empty while it can."""
        return self._writer.problem

    def register(self, row: LoggedTopic, definition: str) -> int:
        """Describes a topic and returns its number, which is the same in all files."""
        described = _Described(row, definition)
        number = self._describe(described)
        self._topics[number] = described
        self._totals[number] = 0
        if self._splits and any(qos.durability == "transient_local" for qos in row.qos):
            self._repeated.add(number)
        return number

    def write(self, topic: int, log_time: int, publish_time: int, data: bytes) -> bool:
        """Adds one message; True if a new file was begun for it."""
        new = self._splits and self._due(log_time) and self._next(log_time)
        if self._began is None:
            self._began = log_time
        if topic in self._repeated:
            self._latched[topic] = (publish_time, bytes(data))
        self._writer.write(topic, log_time, publish_time, data)
        return new

    def write_all(self, messages: Iterable[tuple[int, int, int, bytes]]) -> None:
        """Adds messages to a log that is not split; see `McapWriter.write`."""
        self._writer.write_all(messages)

    def write_bundles(self, bundles: Iterable[Bundle]) -> None:
        """Adds bundles of messages to a log that is not split."""
        self._writer.write_bundles(bundles)

    @property
    def splits(self) -> bool:
        """Whether a message may begin a new file."""
        return self._splits

    def add(self, record: Metadata | Attachment) -> None:
        """Adds a metadata record, which the following files repeat as it was last, or an attachment."""
        if isinstance(record, Metadata):
            self._metadata[record.name] = record
        self._writer.add(record)

    def flush(self) -> None:
        """Puts everything so far on disk for good."""
        self._writer.flush()

    def finish(self) -> None:
        """Ends the data of the last file with what rosbag2 wants to know of it."""
        self._writer.flush()
        information = bag_information(self._rows(self._writer.counts), [self._span(None)])
        self._writer.add(Metadata(BAG_RECORD, {"serialized_metadata": information}))

    def close(self) -> None:
        """Writes the index of the last file and closes it."""
        self._writer.close()

    def discard(self) -> None:
        """Closes and removes a log that never got a message."""
        self._writer.discard()

    def information(self) -> str:
        """What stands in the `metadata.yaml` of all files."""
        counts = {number: self._totals[number] + self._writer.counts[number] for number in self._topics}
        information = bag_information(self._rows(counts), [*self._done, self._span(self.path.name)])
        return f"rosbag2_bagfile_information:\n{indent(information, '  ')}"

    def _open(self, number: int) -> McapWriter:
        library = f"bearing_twin {bearing_twin.__version__}"
        return McapWriter(self._name(number), library, self._safety.fsync, self._safety.patient)

    def _describe(self, described: _Described) -> int:
        row = described.row
        return self._writer.register(row.name, row.ros_type, described.definition, row.metadata, row.encodings)

    def _due(self, log_time: int) -> bool:
        limit, seconds = self._safety.split_bytes, self._safety.split_seconds
        if self._began is None or self._writer.problem:
            return False
        self._began = min(self._began, log_time)  # where the clock was put back
        return bool((limit and self._writer.bytes >= limit) or (seconds and log_time >= self._began + seconds * 1e9))

    def _next(self, log_time: int) -> bool:
        """Completes the file and begins the next, with everything that is needed to read it alone.

        False where the disk has no room for that: the file goes on.
        """
        try:
            self._writer.flush()
            following = self._open(self._number + 1)
        except LogError:
            return False
        with suppress(LogError):  # without its last record or its index a file is still read by `recover`
            self.finish()
        with suppress(LogError):
            self._writer.close()
        self._done.append(self._span(self.path.name))
        for number, count in self._writer.counts.items():
            self._totals[number] += count
        self._dropped += self._writer.dropped
        self._number, self._began, self._writer = self._number + 1, log_time, following
        for record in self._metadata.values():
            self._writer.add(record)
        for described in self._topics.values():
            self._describe(described)
        for topic, (publish_time, data) in self._latched.items():
            self._writer.write(topic, log_time, publish_time, data)
        while self._safety.keep and len(self._done) >= self._safety.keep:
            gone = self._done.pop(0)
            self._name(0).with_name(gone.path).unlink(missing_ok=True)
        return True

    def _rows(self, counts: Mapping[int, int]) -> list[LoggedTopic]:
        return [one.row._replace(messages=counts[number]) for number, one in self._topics.items()]

    def _span(self, name: str | None) -> Span:
        messages = sum(self._writer.counts.values())
        return Span(name or "", self._writer.first_ns, self._writer.last_ns, messages, self._writer.bytes)


def part_names(path: Path, safety: Safety) -> Callable[[int], Path]:
    """Where the files of a log at `path` lie; raises LogError for one file that is to be split."""
    if path.suffix != SUFFIX:
        return lambda number: path / f"{path.name}_{number}{SUFFIX}"
    if safety.split_bytes or safety.split_seconds:
        raise LogError(f"{path} is to be split into several files, so it must be a folder: leave out {SUFFIX}")
    return lambda number: path
