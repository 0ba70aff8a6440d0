"""Logs as rosbag2 keeps them: quality of service, `metadata.yaml`, and reading of files and bag folders by time."""

import functools
import heapq
import re
from collections import Counter
from collections.abc import Container, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path, PurePath
from typing import NamedTuple

import yaml

from bearing_twin.base.errors import LogError, echo, shorten
from bearing_twin.log import cdr
from bearing_twin.log.mcap_read import (
    LARGEST_MESSAGE,
    NO_END,
    Contents,
    DamagedLog,
    LoggedMessage,
    McapReader,
)
from bearing_twin.log.mcap_write import StoredTopic

SUFFIX, SQLITE = ".mcap", ".db3"
STORAGES = "mcap", "sqlite3"
DESCRIBED = "storage_identifier", "compression_mode", "compression_format"
LAST_SQL_NS = 2**63 - 1  # of sqlite3
MOST_NAMED = 3  # channels that a sentence names
LARGEST_BAG_FILE = 2_000_000  # bytes of metadata.yaml, a second to read

_INFINITE = {"sec": 9223372036, "nsec": 854775807}
NOTHING_YET = 2**63 - 1  # rosbag2's starting time of a log without messages
DEEPEST = 10_000  # messages of a topic that a publisher keeps
LONGEST_PROFILE = 5000  # characters; those of bags have 300
NUMBERED = {
    "reliability": {1: "reliable", 2: "best_effort"},
    "durability": {1: "transient_local", 2: "volatile"},
}  # how older bags write the policies
_NEXT_PROFILE = re.compile(r"\n(?=-)")


class Qos(NamedTuple):
    """A publisher's quality of service in the terms of rosbag2."""

    depth: int = 10
    reliability: str = "reliable"
    durability: str = "volatile"


class Span(NamedTuple):
    """One file of a log: its name, times of its first and last message [ns] (None without any), messages, bytes."""

    path: str
    first_ns: int | None
    last_ns: int
    messages: int
    bytes: int


def qos_profiles(profiles: tuple[Qos, ...]) -> list[dict]:
    """Quality of service as in version 9 of rosbag2: policies by name, unlimited durations as 2^63 - 1 ns."""
    return [
        {
            "history": "keep_last",
            "depth": qos.depth,
            "reliability": qos.reliability,
            "durability": qos.durability,
            "deadline": dict(_INFINITE),
            "lifespan": dict(_INFINITE),
            "liveliness": "automatic",
            "liveliness_lease_duration": dict(_INFINITE),
            "avoid_ros_namespace_conventions": False,
        }
        for qos in profiles
    ]


@functools.cache
def qos_text(profiles: tuple[Qos, ...]) -> str:
    """`qos_profiles` as YAML: topics of a log share a few."""
    return as_yaml(qos_profiles(profiles))


@functools.lru_cache(maxsize=256)
def offered_qos(text: str) -> Qos:
    """The first of the profiles that a bag lists as YAML; reliable and volatile if they are malformed."""
    first = _NEXT_PROFILE.split(text, maxsplit=1)[0]
    try:
        profile = yaml.safe_load(first)[0] if len(first) <= LONGEST_PROFILE else {}
        policies = {key: NUMBERED[key].get(profile[key], profile[key]) for key in NUMBERED}
        depth = int(profile["depth"])
    except (yaml.YAMLError, ArithmeticError, LookupError, TypeError, ValueError, RecursionError):
        return Qos()
    return Qos(
        depth if 1 <= depth <= DEEPEST else Qos().depth,
        "best_effort" if policies["reliability"] == "best_effort" else "reliable",
        "transient_local" if policies["durability"] == "transient_local" else "volatile",
    )


def topic_qos(topic: StoredTopic) -> Qos:
    """The quality of service with which a topic was recorded."""
    return offered_qos(topic.metadata.get("offered_qos_profiles", ""))


def as_yaml(value) -> str:
    """YAML in the order given, in block style."""
    return yaml.dump(value, Dumper=_PlainDumper, sort_keys=False, default_flow_style=False)


def bag_information(counts: list[tuple[StoredTopic, int]], spans: list[Span]) -> str:
    """The `rosbag2_bagfile_information` of a log with these messages by topic and these files, as YAML.

    A file without a name is left out, for the copy inside the file itself (rosbag2 fills in the name on reading).
    """
    first = min((span.first_ns for span in spans if span.first_ns is not None), default=None)
    last = max((span.last_ns for span in spans if span.first_ns is not None), default=0)
    total = Span("", first, last, sum(count for _, count in counts), 0)
    named = [span for span in spans if span.path]
    information = {
        "version": 9,
        "storage_identifier": "mcap",
        **_times(total),
        "topics_with_message_count": [
            {"topic_metadata": _topic_entry(topic), "message_count": count} for topic, count in counts
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [span.path for span in named],
        "files": [{"path": span.path, **_times(span)} for span in named],
        "custom_data": None,
        "ros_distro": "jazzy",
    }
    return as_yaml(information)


def _topic_entry(topic: StoredTopic) -> dict:
    return {
        "name": topic.name,
        "type": topic.ros_type,
        "serialization_format": topic.message_encoding,
        "offered_qos_profiles": qos_profiles((topic_qos(topic),)),
        "type_description_hash": topic.metadata.get("topic_type_hash", ""),
    }


def _times(span: Span) -> dict:
    empty = span.first_ns is None
    return {
        "duration": {"nanoseconds": 0 if empty else span.last_ns - span.first_ns},
        "starting_time": {"nanoseconds_since_epoch": NOTHING_YET if empty else span.first_ns},
        "message_count": span.messages,
    }


class _PlainDumper(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):
    """No anchors and aliases: other YAML readers of ROS do not all follow them."""

    def ignore_aliases(self, data):
        return True


def list_some(names: Sequence[str]) -> str:
    """The first MOST_NAMED of these names, and the number of the others: a log may have thousands of channels."""
    remainder = f" and {len(names) - MOST_NAMED} others" if len(names) > MOST_NAMED else ""
    return ", ".join(names[:MOST_NAMED]) + remainder


class LogReader:
    """A log as its messages: an .mcap file, or a bag folder of files by MCAP or sqlite3. Raises LogError.

    `topics` are its channels, `counts` the numbers of their messages by `identity`, `metadata` the last record of each
    name. With `unfinished` a file that is being written, or was truncated, is read to its last complete chunk, and
    `ends` has a sentence about it; without, it raises DamagedLog.
    """

    def __init__(self, path, unfinished: bool = False):
        self._contents: dict[Path, Contents] = {}
        self.metadata: dict[str, dict[str, str]] = {}
        self.ends: list[str] = []
        topics: dict[tuple, StoredTopic] = {}
        self.counts: Counter[tuple] = Counter()
        for file in log_files(path):
            with reader_of(file) as reader:
                contents = self._contents[file] = reader.contents()
            if not contents.ended:
                if not unfinished:
                    raise DamagedLog(file, contents.end, NO_END)
                reason = "has no end, as it is being written or was cut: it is read to its last whole chunk, byte"
                self.ends.append(f"the file {file.name} {reason} {contents.end}")
            self.metadata |= {record.name: record.metadata for record in contents.metadata}
            for number, topic in contents.topics.items():
                key = topic.identity
                topics.setdefault(key, topic)
                self.counts[key] += contents.counts.get(number, 0)
        self.topics = list(topics.values())
        self.first_ns = min((contents.first_ns for contents in self._contents.values() if contents.last_ns), default=0)

    @property
    def foreign(self) -> dict[str, int]:
        """Numbers of messages that no ROS 2 program can read, by the name of their channel."""
        counts: Counter[str] = Counter()
        for topic in self.topics:
            if topic.foreign:
                counts[topic.name] += self.counts[topic.identity]
        return dict(+counts)

    @property
    def notes(self) -> list[str]:
        """Parts of the log that are not read, a sentence each: files without an end, foreign messages."""
        notes = list(self.ends)
        if foreign := self.foreign:
            reason = "messages are passed over, for they have no schema or are not in CDR"
            notes.append(f"{sum(foreign.values())} {reason}: on {list_some(sorted(foreign))}")
        return notes

    def messages(self, names: Container[str] | None = None, from_ns: int = 0) -> Iterator[LoggedMessage]:
        """Messages of the topics `names` (None: of all) by log time; raises DamagedLog and LogLimit, also part way.

        Files that overlap in time are open together.
        """
        overlapping: list[Iterator[LoggedMessage]] = []
        end = 0
        for file, contents in sorted(self._contents.items(), key=lambda entry: entry[1].first_ns):
            if contents.first_ns >= end:
                yield from heapq.merge(*overlapping, key=lambda message: message.log_time)
                overlapping = []
            overlapping.append(self._messages_in(file, names, from_ns))
            end = max(end, contents.last_ns)
        yield from heapq.merge(*overlapping, key=lambda message: message.log_time)

    def _messages_in(self, file: Path, *limits) -> Iterator[LoggedMessage]:
        """The messages of one file."""
        with reader_of(file, self._contents[file]) as reader:
            yield from reader.messages(*limits)

    def in_file_order(self, names: Container[str] | None = None) -> Iterator[LoggedMessage]:
        """`messages` in the order in which they were written."""
        for file in self._contents:
            yield from self._messages_in(file, names, 0, False)


class SqliteReader:
    """The content of one file of a bag by sqlite3, through `rosbags`, as McapReader gives that of an MCAP file."""

    def __init__(self, path: Path):
        from rosbags.rosbag2 import Reader

        self.path, self._bag = path, Reader(path)
        with self._log_errors():
            self._bag.open()
            self._bag.storage.dbconn.limit(0, LARGEST_MESSAGE)  # of a text or blob
        self._topics = {connection.id: self._topic(connection) for connection in self._bag.connections}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._bag.close()

    def contents(self) -> Contents:
        """Contents of the file, which has no metadata records."""
        counts = {connection.id: connection.msgcount for connection in self._bag.connections}
        times = (self._bag.start_time, self._bag.end_time - 1) if self._bag.message_count else (0, 0)
        return Contents(self._topics, counts, *times, [], 0, True, [])

    def messages(
        self, names: Container[str] | None = None, from_ns: int = 0, by_time: bool = True
    ) -> Iterator[LoggedMessage]:
        """Messages of the topics `names` (None: of all) from `from_ns` on, always by their time."""
        connections = [
            connection
            for connection in self._bag.connections
            if names is None or (connection.topic in names and not self._topics[connection.id].foreign)
        ]
        if not connections:  # of which rosbags would read all
            return
        with self._log_errors():
            for connection, time, data in self._bag.messages(connections, from_ns):
                if not 0 <= (time_ns := int(time)) <= LAST_SQL_NS:
                    raise ValueError(f"a message at {time_ns} ns")
                yield LoggedMessage(self._topics[connection.id], time_ns, time_ns, bytes(data))

    def content(self, damage=None) -> Iterator[LoggedMessage]:
        """All messages."""
        return self.messages()

    def _topic(self, connection) -> StoredTopic:
        ros_type = connection.msgtype
        text = connection.msgdef.data or (cdr.schema_text(ros_type) if cdr.is_known(ros_type) else "")
        offered = tuple(
            Qos(profile.depth, profile.reliability.name.lower(), profile.durability.name.lower())
            for profile in connection.ext.offered_qos_profiles
        )
        metadata = {"offered_qos_profiles": qos_text(offered), "topic_type_hash": connection.digest or ""}
        return StoredTopic(connection.topic, ros_type, text, connection.ext.serialization_format, metadata)

    @contextmanager
    def _log_errors(self) -> Iterator[None]:
        """Turns errors of the database into LogError."""
        try:
            yield
        except Exception as error:  # of rosbags, of apsw, and of values that are no numbers
            command = f"`sqlite3 {self.path} .recover | sqlite3 NEW.db3`"
            reason = f"cannot be read as a bag of sqlite3 ({shorten(str(error))}); {command} saves what is whole"
            raise LogError(f"{self.path} {reason}") from error


def reader_of(file: Path, contents: Contents | None = None) -> McapReader | SqliteReader:
    """The reader of a file of a log, whose `contents` may be known from before."""
    return SqliteReader(file) if file.suffix == SQLITE else McapReader(file, contents)


def log_files(path) -> list[Path]:
    """The files of a log, in order: the file itself, or those that a bag folder's metadata.yaml lists.

    Raises LogError for a bag that is compressed, or of another storage, with the command that converts it.
    """
    path = path_of(path)
    if not path.exists():
        raise LogError(f"there is no log {path}; give the path of an .mcap file or of a bag folder")
    if not path.is_dir():
        if not path.is_file():
            raise LogError(f"{path} is a pipe or a device, no log; give the path of an .mcap file or of a bag folder")
        if path.suffix == ".bag":
            raise _conversion_error(path, "a bag of ROS 1")
        if path.suffix == ".zstd":
            raise _conversion_error(path, "a file of a compressed bag", path.absolute().parent)
        return [path]
    information = _read_metadata(path / "metadata.yaml")
    storage = information.get("storage_identifier") or "mcap"
    mode = str(information.get("compression_mode") or "none").lower()
    if mode != "none":
        compression = f"compressed by {information.get('compression_format')} ({mode})"
        raise _conversion_error(path, f"a bag by {storage}, {compression}")
    if storage not in STORAGES:
        raise _conversion_error(path, f"a bag by {storage}")
    files = (
        [path / name for name in information.get("files", ())]
        or sorted(path.glob(f"*{SUFFIX}"))
        or sorted(path.glob(f"*{SQLITE}"))
    )
    missing = [file.name for file in files if not file.is_file()]
    if len(set(files)) < len(files):
        raise LogError(f"{path / 'metadata.yaml'} names a file twice; remove it to read the files beside it")
    if not files or missing:
        reason = "holds no .mcap file; give a log written by bearing_twin or `ros2 bag record`"
        reason = f"lacks its file {missing[0]}; remove its metadata.yaml to read the others" if missing else reason
        raise LogError(f"the bag folder {path} {reason}")
    return files


def path_of(path, content: str = "a log") -> Path:
    """The path as a Path; raises LogError for anything else, which should be that of `content`."""
    try:
        return Path(path)
    except TypeError:
        raise LogError(f"{echo(path)} is no path of {content}; give one as text or as a pathlib.Path") from None


def _conversion_error(path: Path, description: str, bag: Path | None = None) -> LogError:
    command = f"rosbags-convert --src {bag or path} --dst NEW_BAG --dst-storage mcap"
    return LogError(f"{path} is {description}, which is not read; convert it by `{command}` and give NEW_BAG")


def _read_metadata(path: Path) -> dict:
    """The description of a bag in `metadata.yaml`, empty without that file; raises LogError for another file."""
    try:
        if path.stat().st_size > LARGEST_BAG_FILE:
            raise LogError(
                f"{path} is larger than the {LARGEST_BAG_FILE // 10**6} MB that are read of a description; remove "
                "it to read the .mcap files beside it"
            )
        loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
        information = yaml.load(path.read_text(encoding="utf-8"), Loader=loader)["rosbag2_bagfile_information"]
        names = [PurePath(name).name for name in information["relative_file_paths"]]
        return {key: information.get(key) for key in DESCRIBED} | {"files": names}
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError, yaml.YAMLError) as error:
        raise LogError(f"{path} is not a bag's description; remove it to read the .mcap files beside it") from error


def raw_messages(path) -> Iterator[LoggedMessage]:
    """Every message by log time, not decoded; raises LogError, also part way.

    Yields (topic, log_time, publish_time, data) with topic (name, ros_type, ...).
    """
    yield from LogReader(path).messages()
