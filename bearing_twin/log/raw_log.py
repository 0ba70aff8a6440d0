"""Logs of any ROS topics while they are written, without decoding the messages; and copies of damaged ones.

A log is one `.mcap` file, or a rosbag2 folder when its path has no suffix `.mcap`: `<name>/<name>_0.mcap` beside a
`metadata.yaml`, which is there from the start, so that a crash leaves a bag that other tools accept after recovery.
"""

import datetime
import platform
import struct
import threading
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import nullcontext, suppress
from os import PathLike
from pathlib import Path
from textwrap import indent
from typing import NamedTuple

import numpy as np
from mcap.records import Attachment, Metadata

import bearing_twin
from bearing_twin.base.errors import LogError, escape_controls
from bearing_twin.base.paths import replace_file
from bearing_twin.base.process import DeferredSignals
from bearing_twin.kinds.rules import OUTSIDE
from bearing_twin.log import cdr
from bearing_twin.log.bag import SUFFIX, Qos, Span, bag_information, list_some, log_files, path_of, qos_text, reader_of
from bearing_twin.log.mcap_read import LoggedMessage
from bearing_twin.log.mcap_write import McapWriter, StoredTopic, log_error
from bearing_twin.log.stream import SLOW_RATE, checked_block

KEPT_RATE = 5.0  # 1/s: an hour of a bearing with eight balls takes 0.3 GB then, and 15 GB in full
WHOLE_SPAN = 0.5e9 / SLOW_RATE  # ns: a SampleBlock that covers less is an impact or the end of a run, and stays
KEPT_KEY = "kept_rate_hz"  # in the metadata of a topic
BAG_RECORD = "rosbag2"
SCENE_RECORD = "bearing_twin"
RECORDING_RECORD = "bearing_twin_recording"  # messages that a recorder received and lost; the last one counts
LOSSES = {  # counts of lost messages in that record, and sentences about them
    "messages_lost": "were lost on the way to the recorder",
    "messages_dropped": "were dropped on a full disk",
    "messages_unreadable": "are not logged: too large, or not of the type as which they were sent",
}
OUTPUTS_KEY = "outputs"  # in SCENE_RECORD of a complete run: its number of outputs
RUN_RECORD = "bearing_twin_run"  # the one record that differs between two runs of one scene
BEGINS_KEY = "begins"  # in SCENE_RECORD: the number of the first output of a run that continues another
STATE_RECORD = "bearing_twin_state"  # of a complete run: the state at its end, to continue from
RETRY = 1.0  # s between tries while the disk is full


class Thinning:
    """Selects the first message of a topic in each period or, of a SampleBlock, the first output.

    Messages count by the time at which they are logged, outputs by that of the simulation.
    """

    def __init__(self, ros_type: str, rate: float):
        self._period, self._count_outputs, self._last = round(1e9 / rate), ros_type == cdr.SAMPLE_BLOCK, -1

    def thin(self, log_time_ns: int, data: bytes) -> bytes | None:
        """The bytes to log of a message, None for nothing; a malformed SampleBlock is logged unchanged, for readers."""
        if self._count_outputs:
            try:
                return self._first_output(data)
            except (LogError, struct.error):  # struct.error: a number of the output does not fit
                return data
        before, self._last = self._last, log_time_ns // self._period
        return None if before == self._last else data

    def _first_output(self, data: bytes) -> bytes | None:
        block = checked_block("", data)
        times, periods = block.time_ns, block.time_ns // self._period
        if times[-1] - times[0] < WHOLE_SPAN:
            return data
        rows = np.flatnonzero(periods != self._last)  # a SampleBlock is shorter than a period
        self._last = int(periods[-1])
        if not len(rows):
            return None
        row, stamp = int(rows[0]), block.header.stamp
        stamp.sec, stamp.nanosec = divmod(stamp.sec * 10**9 + stamp.nanosec + int(times[row] - times[0]), 10**9)
        block.values, block.time_ns = block.values.reshape(block.count, -1)[row], times[row : row + 1]
        block.first_sequence, block.count = block.first_sequence + row, 1
        return cdr.serialise(cdr.SAMPLE_BLOCK, block)


class Safety(NamedTuple):
    """Protection of a log against loss, and limits on its size.

    Every `max_loss` seconds the messages so far are written to disk, with `fsync` past its caches; 0 = as chunks become
    full, so that the same messages give the same bytes. A `patient` log raises no error while the disk is full: it
    keeps the messages that fit into memory, counts the others, reports a `problem`, and continues when there is room. A
    new file begins after `split_bytes` or `split_seconds` of messages, and the `keep` newest stay; 0 = not, all.
    Of each topic `kept_rate` messages a second are in the log, and as many outputs (see `Thinning`); 0 = all.
    """

    max_loss: float = 0.0
    fsync: bool = False
    patient: bool = False
    split_bytes: int = 0
    split_seconds: float = 0.0
    keep: int = 0
    kept_rate: float = 0.0


class RawLogWriter:
    """A new log of arbitrary topics; use as a context manager, from any thread.

    Parameters
    ----------
    path : path-like
        An .mcap file, else a bag folder; must not exist.
    run_record : bool
        False leaves out date and host.
    safety : Safety
        Protection against loss, splitting into several files.

    Raises
    ------
    LogError
        If `path` exists, before anything is written; and once the disk is full, with what was kept.
    """

    def __init__(self, path, run_record: bool = True, safety: Safety = Safety()):  # noqa: B008 - it cannot change
        refuse_existing(path)
        self.path = path = Path(path)
        self._safety, self._folder = safety, None if path.suffix == SUFFIX else path
        self._splits = bool(safety.split_bytes or safety.split_seconds)
        if self._splits and self._folder is None:
            raise LogError(f"{path} is to be split into several files, so it must be a folder: leave out {SUFFIX}")
        if self._folder is not None:
            try:
                self._folder.mkdir()
            except OSError as error:
                reason = f"{path} cannot be made ({error.strerror}); give another place for the log"
                raise log_error(reason, error) from error
        self._lock, self._unbroken, self._closed = threading.Lock(), DeferredSignals(), threading.Event()
        self._unlisted = False  # whether the description of the bag lacks topics
        self._run = {"date": _now(), "host": platform.node()} if run_record else None
        self._number, self._began = 0, None  # of the file; time of its first message [ns]
        self._topics: dict[int, StoredTopic] = {}
        self._thinned: dict[int, Thinning] = {}
        self._whole: set[int] = set()  # topics that are not thinned for the time being
        self._metadata: dict[str, Metadata] = {}
        self._latched: dict[int, tuple[int, bytes]] = {}  # last messages of latched topics, which each file repeats
        self._done: list[tuple[Span, dict[int, int]]] = []  # files that are complete and still there, messages by topic
        self._dropped = 0
        self._writer: McapWriter | None = None
        try:
            self._writer = self._open(0)
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
        if kind is None or self._number or self._writer.has_messages:
            self.close()
        else:
            self._discard()

    @property
    def messages(self) -> int:
        """Messages on disk for good."""
        return sum(span.messages for span in self._spans())

    @property
    def problem(self) -> str:
        """Why the log cannot grow and how much is in it; empty while it can."""
        return self._writer.problem

    @property
    def dropped(self) -> int:
        """Messages for which there was no room, neither on disk nor in memory."""
        return self._dropped + self._writer.dropped

    @property
    def bytes(self) -> int:
        """Size of the log on disk so far."""
        return sum(span.bytes for span in self._spans())

    def add_topic(
        self,
        name: str,
        ros_type: str,
        definition: str | None = None,
        type_hash: str | None = None,
        qos: tuple[Qos, ...] = (Qos(),),
        outside: str = "",
    ) -> int:
        """Describes a topic (full name, type, `ros2msg` text with dependencies, RIHS01 hash) and returns its number.

        A text or hash of None is that of the common message of this type. `outside` names models outside their range,
        in the metadata of the topic.
        """
        definition = cdr.schema_text(ros_type) if definition is None else definition
        type_hash = cdr.type_hash(ros_type) if type_hash is None else type_hash
        metadata = {"offered_qos_profiles": qos_text(tuple(qos)), "topic_type_hash": type_hash}
        metadata |= {OUTSIDE: outside} if outside else {}
        seldom = "/records/" in name or any(profile.durability == "transient_local" for profile in qos)
        rate = 0.0 if seldom else self._safety.kept_rate
        metadata |= {KEPT_KEY: f"{rate:g}"} if rate else {}
        number = self.copy_topic(StoredTopic(name, ros_type, definition, "cdr", metadata))
        if rate:
            self._thinned[number] = Thinning(ros_type, rate)
        return number

    def copy_topic(self, topic: StoredTopic) -> int:
        """Describes a topic as stored in another log, of any encoding, and returns its number."""
        with self._unbroken, self._lock:
            number = self._writer.register(topic)
            self._topics[number] = topic
            self._unlisted = True
        return number

    def keep_all(self, topic: int, enabled: bool) -> None:
        """Logs every message of the topic with that number from now on, or thins it again if not `enabled`."""
        with self._lock:
            (self._whole.add if enabled else self._whole.discard)(topic)

    def write(self, topic: int, log_time_ns: int, publish_time_ns: int, cdr: bytes) -> None:
        """Adds one message of the topic with that number."""
        self.write_all(((topic, log_time_ns, publish_time_ns, cdr),))

    def write_all(self, messages: Iterable[tuple[int, int, int, bytes]]) -> None:
        """`write` for many: (topic, log time, publish time, CDR) each."""
        with self._unbroken, self._lock:
            pending = self._thin(messages) if self._thinned else iter(messages)
            while True:  # while the disk is full the writer stops at each message, which it has taken or dropped
                with self._patience():
                    if not self._splits:
                        self._writer.write_all(pending)
                    for message in pending:
                        self._put_split(*message)
                    return

    def _thin(self, messages) -> Iterator[tuple[int, int, int, bytes]]:
        """The messages that a thinned log holds, as it holds them."""
        for topic, log_time, publish_time, data in messages:
            if topic in self._thinned and topic not in self._whole:
                data = self._thinned[topic].thin(log_time, data)
            if data is not None:
                yield topic, log_time, publish_time, data

    def _put_split(self, topic: int, log_time: int, publish_time: int, data: bytes) -> None:
        """Writes a message to the file in progress, or to a new one where that is due."""
        began = self._is_split_due(log_time) and self._begin_file(log_time)
        if self._began is None:
            self._began = log_time
        if "transient_local" in self._topics[topic].metadata.get("offered_qos_profiles", ""):
            self._latched[topic] = (publish_time, bytes(data))
        self._writer.write_all([(topic, log_time, publish_time, data)])
        if began:
            self._write_bag_file()

    def flush(self) -> None:
        """Puts everything so far on disk."""
        with self._unbroken, self._lock, self._patience():
            if not self._closed.is_set():
                self._writer.flush()
                if self._unlisted:
                    self._write_bag_file()

    def add_metadata(self, name: str, values: Mapping[str, object]) -> None:
        """Adds a metadata record of texts, which the following files of a split log repeat as it was last."""
        record = Metadata(name, {key: str(value) for key, value in values.items()})
        with self._unbroken, self._lock, self._patience():
            self._metadata[name] = record
            self._writer.add(record)

    def add_attachment(self, attachment: Attachment) -> None:
        """Adds an attachment of another log."""
        with self._unbroken, self._lock, self._patience():
            self._writer.add(attachment)

    def note_run(self, **values) -> None:
        """Adds texts to the record that holds date and host, which is written at the end."""
        if self._run is not None:
            self._run.update({key: str(value) for key, value in values.items()})

    def close(self) -> None:
        """Completes the log; raises LogError if its index cannot be written."""
        try:
            with self._unbroken, self._lock:
                if not self._closed.is_set():
                    self._complete()
        finally:
            self._unbroken.release()

    def _complete(self) -> None:
        self._closed.set()
        try:
            with suppress(LogError):  # messages that cannot be written are tried again with the index
                self._finish()
                if self._run is not None:
                    self._writer.add(Metadata(RUN_RECORD, self._run))
        finally:
            try:
                self._writer.close()
            except LogError:  # which says more than that of the bag's description
                with suppress(LogError):
                    self._write_bag_file()
                raise
            self._write_bag_file()

    def _finish(self) -> None:
        """Ends the data of a file with the description that rosbag2 reads."""
        self._writer.flush()
        information = self._bag_information(self._writer.counts, [self._span()._replace(path="")])
        self._writer.add(Metadata(BAG_RECORD, {"serialized_metadata": information}))

    def _open(self, number: int) -> McapWriter:
        path = self._folder / f"{self._folder.name}_{number}{SUFFIX}" if self._folder else self.path
        return McapWriter(path, f"bearing_twin {bearing_twin.__version__}", self._safety.fsync, self._safety.patient)

    def _is_split_due(self, log_time: int) -> bool:
        limit, seconds = self._safety.split_bytes, self._safety.split_seconds
        if self._began is None or self._writer.problem:
            return False
        self._began = min(self._began, log_time)  # where the clock was put back
        return bool((limit and self._writer.bytes >= limit) or (seconds and log_time >= self._began + seconds * 1e9))

    def _begin_file(self, log_time: int) -> bool:
        """Completes the file and begins the next, with all descriptions that are needed to read it alone.

        False where the disk has no room for that: the file goes on.
        """
        before = self._writer
        try:
            before.flush()
            following = self._open(self._number + 1)
        except LogError:
            return False
        with suppress(LogError):  # without its last record or its index a file is still read by `recover`
            self._finish()
        with suppress(LogError):
            before.close()
        self._done.append((self._span(), before.counts))
        self._dropped += before.dropped
        self._number, self._began, self._writer = self._number + 1, log_time, following
        for record in self._metadata.values():
            self._writer.add(record)
        for topic in self._topics.values():
            self._writer.register(topic)
        self._writer.write_all((number, log_time, *message) for number, message in self._latched.items())
        while self._safety.keep and len(self._done) >= self._safety.keep:
            oldest, _ = self._done.pop(0)
            self._folder.joinpath(oldest.path).unlink(missing_ok=True)
        return True

    def _bag_information(self, counts: Mapping[int, int], spans: list[Span]) -> str:
        return bag_information([(topic, counts[number]) for number, topic in self._topics.items()], spans)

    def _span(self) -> Span:
        writer = self._writer
        return Span(writer.path.name, writer.first_ns, writer.last_ns, sum(writer.counts.values()), writer.bytes)

    def _spans(self) -> list[Span]:
        return [*(span for span, _ in self._done), self._span()]

    def _patience(self):
        return suppress(LogError) if self._safety.patient and not self._closed.is_set() else nullcontext()

    def _flush_often(self) -> None:
        """Flushes in its own thread, as messages may be rare and their sender busy."""
        while not self._closed.wait(max(RETRY if self.problem else 0.0, self._safety.max_loss)):
            with suppress(LogError):  # the next to write gets it
                self.flush()

    def _write_bag_file(self) -> None:
        self._unlisted = False
        if self._folder is None:
            return
        counts = Counter(self._writer.counts)
        for _, complete in self._done:
            counts.update(complete)
        information = self._bag_information(counts, self._spans())
        target = self._folder / "metadata.yaml"
        try:
            replace_file(target, f"rosbag2_bagfile_information:\n{indent(information, '  ')}".encode())
        except OSError as error:
            reason = f"{target} cannot be written ({error.strerror}); the messages are in {self._writer.path}"
            raise log_error(reason, error) from error

    def _discard(self) -> None:
        """Removes a log that never got a message."""
        self._closed.set()
        self._unbroken.release()
        if self._writer is not None:
            self._writer.discard()
        if self._folder is not None:
            with suppress(OSError):
                (self._folder / "metadata.yaml").unlink(missing_ok=True)
                self._folder.rmdir()


NO_LOGS = (".csv", ".txt", ".json", ".parquet", ".nc", ".html", ".png", ".yaml", ".db3")


def refuse_existing(path) -> None:
    """Raises LogError if a log cannot be made at `path` because something is there, or its folder is missing."""
    path = path_of(path)
    if path.suffix.lower() in NO_LOGS:
        raise LogError(
            f"{path} would be a log, which is an .mcap file or a bag folder without a suffix; `bearing_twin export` "
            "makes tables of a log"
        )
    if path.exists() or path.is_symlink():
        raise LogError(f"{path} exists and is not overwritten; give another name or remove it first")
    if not path.parent.is_dir():
        raise LogError(f"the folder {path.parent} for the log does not exist; make it or give another place")


def _now() -> str:
    return datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")


RECOVERY_RECORD = "bearing_twin_recovered"


class Recovered(NamedTuple):
    """Recovered part of a log: messages, solver outputs among them, and the problems with the rest."""

    messages: int
    samples: int
    problems: tuple[str, ...]


def recover(path: str | PathLike, out: str | PathLike) -> Recovered:
    """Writes all that can be read of a log to a new log: messages of any encoding and metadata.

    Parameters
    ----------
    path : str or path
        A log that is damaged or was not completed.
    out : str or path
        The new log, which must not exist.

    Returns
    -------
    Recovered
        Numbers of messages and samples, and one sentence for each problem: a damaged chunk is left out whole.

    Raises
    ------
    LogError
        If `out` exists or nothing can be saved.
    """
    problems: list[str] = []
    messages = samples = 0
    numbers: dict[tuple, int] = {}
    copied: set[tuple] = set()
    unknown: Counter[str] = Counter()
    with RawLogWriter(out, run_record=False) as log:
        for item in _readable(log_files(path), problems):
            if isinstance(item, Attachment):
                log.add_attachment(item)
            elif isinstance(item, Metadata):
                record = (item.name, *sorted(item.metadata.items()))
                if item.name != BAG_RECORD and record not in copied:
                    copied.add(record)
                    log.add_metadata(item.name, item.metadata)
            elif not item.topic.message_encoding:
                unknown[item.topic.name] += 1
            else:
                messages += 1
                samples += _count_outputs(item)
                if (key := item.topic.identity) not in numbers:
                    numbers[key] = log.copy_topic(item.topic)
                log.write(numbers[key], item.log_time, item.publish_time, item.data)
        if unknown:
            names = list_some(sorted(unknown))
            problems.append(f"{unknown.total()} messages of {names} are left out: no record says how they are encoded")
        if not messages:
            raise LogError(f"nothing in {path} can be recovered ({list_some(problems or ['it holds no message'])})")
        sentences = escape_controls("; ".join(problems) or "none")
        log.add_metadata(RECOVERY_RECORD, {"from": escape_controls(Path(path).name), "problems": sentences})
    return Recovered(messages, samples, tuple(problems))


def _readable(files: list[Path], problems: list[str]) -> Iterator[LoggedMessage | Metadata | Attachment]:
    """All that can be read of the files; a sentence for each part that cannot is appended to `problems`."""
    for file in files:
        damage: list[tuple[int, str]] = []
        with reader_of(file) as reader:
            yield from reader.content(damage)
        problems += dict.fromkeys(f"{file.name} at byte {offset}: {reason}" for offset, reason in damage)


def _count_outputs(message: LoggedMessage) -> int:
    if message.topic.ros_type != cdr.SAMPLE_BLOCK or "/records/" in message.topic.name:
        return 0
    try:
        return cdr.deserialise(cdr.SAMPLE_BLOCK, message.data).count
    except LogError:
        return 0
