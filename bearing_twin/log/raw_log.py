"""Logs of any ROS topics while they are written, without decoding the messages.

A log is one `.mcap` file, or a rosbag2 folder when its path has no suffix `.mcap`: `<name>/<name>_0.mcap` beside a
`metadata.yaml`, which is there from the start, so that a crash leaves a bag that other tools accept after recovery.
"""

import datetime
import math
import platform
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import nullcontext, suppress
from pathlib import Path
from textwrap import indent
from typing import NamedTuple

import numpy as np
from mcap.records import Attachment, Metadata

import bearing_twin
from bearing_twin.base.errors import LogError
from bearing_twin.base.paths import put_whole
from bearing_twin.base.signals import Unbroken
from bearing_twin.kinds.ranges import OUTSIDE
from bearing_twin.log import cdr
from bearing_twin.log.bag import SUFFIX, LoggedTopic, Qos, Span, bag_information, offered_qos, path_of, qos_text
from bearing_twin.log.encoding import encoded
from bearing_twin.log.mcap_read import StoredTopic
from bearing_twin.log.mcap_write import Bundle, McapWriter, refused
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


SCENE_RECORD = "bearing_twin"
RECORDING_RECORD = "bearing_twin_recording"  # what a recorder received and what was lost; the last one counts
ENDED_KEY = "samples_end"  # in it, once the recorder has ended: the number behind the last output
OUTPUTS_KEY = "outputs"  # in SCENE_RECORD, where a whole run is written: how many it has; others may end at any time
RUN_RECORD = "bearing_twin_run"  # the one record that differs between two runs of one scene
RETRY = 1.0  # s between tries while the disk is full


class RawLogWriter(Told):
    """A new log of arbitrary topics; use as a context manager, from any thread.

    Raises LogError if `path` exists, before anything is written; and, once the disk is full, an error that says what
    was kept. `run_record` False leaves out date and host.
    """

    def __init__(self, path, run_record: bool = True, safety: Safety = Safety()):  # noqa: B008 - it cannot change
        refuse_existing(path)
        path = Path(path)
        names = part_names(path, safety)
        self._folder = None if path.suffix == SUFFIX else path
        if self._folder is not None:
            try:
                self._folder.mkdir()
            except OSError as error:
                said = f"{path} cannot be made ({error.strerror}); give another place for the log"
                raise refused(said, error) from error
        self.path = path
        self._lock, self._unbroken = threading.Lock(), Unbroken()
        self._closed = False
        self._run = {"date": _now(), "host": platform.node()} if run_record else None
        self._safety = safety
        try:
            self._log = Parts(names, safety)
        except BaseException:
            if self._folder is not None:
                with suppress(OSError):
                    self._folder.rmdir()
            raise
        self._thinned: dict[int, Thinning] = {}
        self._whole: set[int] = set()  # topics that are not thinned for the time being
        self._ended = threading.Event()
        try:
            self._write_bag_file()
            self._unbroken.watch()
        except BaseException:  # Ctrl-C
            self._discard()
            raise
        if safety.max_loss:
            threading.Thread(target=self._flush_often, name="log flush", daemon=True).start()

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        if kind is None or self._log.begun:
            self.close()
        else:
            self._discard()

    def add_topic(
        self,
        name: str,
        ros_type: str,
        definition: str,
        type_hash: str,
        qos: tuple[Qos, ...],
        kept: float | None = None,
        outside: str = "",
    ) -> int:
        """Describes a topic (full name, type, `ros2msg` text with dependencies, RIHS01 hash) and returns its number.

        `kept` is how many of its messages a second are logged, 0 = all; None = as the log does. `outside` stands beside
        all of them: which models were outside their range.
        """
        seldom = "/records/" in name or any(one.durability == "transient_local" for one in qos)
        rate = (0.0 if seldom else self._safety.kept_rate) if kept is None else kept
        metadata = {"offered_qos_profiles": qos_text(tuple(qos)), "topic_type_hash": type_hash}
        metadata |= ({KEPT_KEY: f"{rate:g}"} if rate else {}) | ({OUTSIDE: outside} if outside else {})
        thinned = Thinning(ros_type, rate) if rate and kept is None else None
        return self._add(LoggedTopic(name, ros_type, type_hash, tuple(qos), metadata), definition, thinned)

    def copy_topic(self, topic: StoredTopic) -> int:
        """Describes a topic as it is stored in another log, of any encoding, and returns its number."""
        said = topic.metadata
        qos = (offered_qos(said.get("offered_qos_profiles", "")),)
        encodings = topic.message_encoding, topic.schema_encoding
        row = LoggedTopic(topic.name, topic.ros_type, said.get("topic_type_hash", ""), qos, said, encodings)
        return self._add(row, topic.definition)

    def _add(self, row: LoggedTopic, definition: str, thinned: Thinning | None = None) -> int:
        with self._unbroken, self._lock:
            number = self._log.register(row, definition)
            if thinned:
                self._thinned[number] = thinned
            self._stale = True
        return number

    def keep_all(self, topic: int, on: bool) -> None:
        """Whether from here on every message of the topic with that number is logged, also where the log is thinned."""
        with self._lock:
            (self._whole.add if on else self._whole.discard)(topic)

    def write(self, topic: int, log_time_ns: int, publish_time_ns: int, cdr: bytes) -> None:
        """Adds one message of the topic with that number."""
        self.write_all(((topic, log_time_ns, publish_time_ns, cdr),))

    def write_all(self, messages: Iterable[tuple[int, int, int, bytes]]) -> None:
        """`write` for many: (topic, log time, publish time, CDR) each."""
        with self._unbroken, self._lock:
            kept: list = []
            try:
                if self._thinned:
                    for message in messages:
                        kept += self._kept(message)
            finally:  # a message that cannot be thinned takes none before it along
                self._put(kept if self._thinned else messages)

    def write_bundles(self, bundles: Iterable[Bundle]) -> None:
        """`write` for bundles of messages, which go into the file whole unless it is thinned or split."""
        if self._thinned or self._log.splits:
            self.write_all(message for bundle in bundles for message in bundle.messages())
            return
        with self._unbroken, self._lock:
            self._put_whole(bundles, self._log.write_bundles)

    def _kept(self, message) -> list:
        """The message as it is logged, if it is."""
        topic, log_time_ns, publish_time_ns, data = message
        if topic not in self._thinned or topic in self._whole:
            return [message]
        found = self._thinned[topic].kept(log_time_ns, data)
        return [] if found is None else [(topic, log_time_ns, publish_time_ns, found)]

    def _put(self, messages: Iterable[tuple[int, int, int, bytes]]) -> None:
        patience, rest = self._patience(), iter(messages)
        if self._log.splits:
            for message in rest:
                with patience:
                    if self._log.write(*message) or self._stale:
                        self._write_bag_file()
            return
        self._put_whole(rest, self._log.write_all)

    def _put_whole(self, items: Iterable, write: Callable[[Iterator], None]) -> None:
        """Writes messages or bundles of them, by `write`, to a log that is not split."""
        patience, rest, done = self._patience(), iter(items), False
        if self._stale:
            with patience:
                self._write_bag_file()
        while not done:  # where the disk is full, the writer stops at each of them, which it has taken or dropped
            with patience:
                write(rest)
                done = True

    def flush(self) -> None:
        """Puts everything so far on disk."""
        with self._unbroken, self._lock, self._patience():
            if not self._closed:
                self._log.flush()

    def add_metadata(self, name: str, values: Mapping[str, object]) -> None:
        """Adds a metadata record of texts."""
        with self._unbroken, self._lock, self._patience():
            self._log.add(Metadata(name, {key: str(value) for key, value in values.items()}))

    def add_attachment(self, attachment: Attachment) -> None:
        """Adds an attachment, as it stands in another log."""
        with self._unbroken, self._lock, self._patience():
            self._log.add(attachment)

    def note_run(self, **values) -> None:
        """Adds texts to the record that holds date and host, which is written at the end."""
        if self._run is not None:
            self._run.update({key: str(value) for key, value in values.items()})

    def close(self) -> None:
        """Completes the log; raises LogError if its index cannot be written."""
        try:
            with self._unbroken, self._lock:
                if not self._closed:
                    self._complete()
        finally:
            self._unbroken.release()

    def _complete(self) -> None:
        self._closed = True
        self._ended.set()
        try:
            with suppress(LogError):  # what cannot be written now is tried once more with the index
                self._log.finish()
                if self._run is not None:
                    self._log.add(Metadata(RUN_RECORD, self._run))
        finally:
            try:
                self._log.close()
            except LogError:  # which says more than that of the bag's description
                with suppress(LogError):
                    self._write_bag_file()
                raise
            self._write_bag_file()

    @property
    def messages(self) -> int:
        """Messages on disk for good."""
        return self._log.messages

    def _patience(self):
        return suppress(LogError) if self._safety.patient and not self._closed else nullcontext()

    def _flush_often(self) -> None:
        """In a thread of its own: messages may be seldom, and whoever writes them busy."""
        while not self._ended.wait(max(RETRY if self.problem else 0.0, self._safety.max_loss)):
            with suppress(LogError):  # whoever writes next is told
                self.flush()

    def _write_bag_file(self) -> None:
        self._stale = False
        if self._folder is None:
            return
        target = self._folder / "metadata.yaml"
        try:
            put_whole(target, self._log.information().encode())
        except OSError as error:
            said = f"{target} cannot be written ({error.strerror}); the messages are in {self._log.path}"
            raise refused(said, error) from error

    def _discard(self) -> None:
        """Removes a log that never got a message."""
        self._closed = True
        self._unbroken.release()
        self._log.discard()
        if self._folder is not None:
            with suppress(OSError):
                (self._folder / "metadata.yaml").unlink(missing_ok=True)
                self._folder.rmdir()


def refuse_existing(path) -> None:
    """Raises LogError if a log cannot be made at `path` because something is there, or its folder is missing."""
    path = path_of(path)
    if path.exists() or path.is_symlink():
        raise LogError(f"{path} exists and is not overwritten; give another name or remove it first")
    if not path.parent.is_dir():
        raise LogError(f"the folder {path.parent} for the log does not exist; make it or give another place")


def _now() -> str:
    return datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")
