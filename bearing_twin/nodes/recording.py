"""A recording without ROS: which topics it takes, how it describes them in the log, and what was lost on the way."""

import math
import os
import threading
from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase
from itertools import repeat
from pathlib import Path

from bearing_twin.base.errors import LogError
from bearing_twin.kinds import KINDS
from bearing_twin.log import cdr
from bearing_twin.log.bag import Qos
from bearing_twin.log.mcap_read import LARGEST_MESSAGE, MOST_TOPICS
from bearing_twin.log.raw_log import RECORDING_RECORD, RawLogWriter, Safety, Told
from bearing_twin.log.sample_block import readable_range

DEPTH = 4000  # messages a subscription may hold back, 1000 a second: other nodes send one that was lost after up to 3 s
FRAMES = ("/tf", "/tf_static")
MENDS = "give the nodes more processors, or send and record less (run.publish_rate, topics)"
RECORDS = "/records/"  # in the name of a topic whose rows are no outputs
MIXED = 2  # steps back while there are several publishers: one is a node started again, whose end is not known yet


class Sequences:
    """Counts what has numbers, messages of one publisher or solver outputs, and what of it never arrived.

    `before` is the number of the first: so many were sent before anything was received. While `several` publishers send
    with numbers of their own nothing is known to be lost; `mixed` counts how often they then step back.
    """

    def __init__(self):
        self.received = self.lost = self.restarts = self.before = self.mixed = 0
        self.several = self._doubted = False
        self._expected: int | None = None

    @property
    def end(self) -> int:
        """The number behind the last."""
        return self._expected or 0

    def saw(self, first: int, count: int) -> int:
        """Notes `count` of them from number `first` on; returns how many were lost just before."""
        lost, doubted = 0, self._doubted or self.several
        self._doubted = self.several  # the first behind them follows nobody knows what
        if self._expected is None:
            self.before = first
        elif first < self._expected:
            self.restarts += 1
            self.mixed += doubted
        elif not doubted:
            lost = first - self._expected
        self._expected = first + count
        self.received += count
        self.lost += lost
        return lost

    def saw_all(self, numbers: Sequence[int]) -> None:
        """`saw` for one of each of these numbers."""
        count = len(numbers)
        if count and list(numbers) == list(range(numbers[0], numbers[0] + count)):  # nearly always, and quick
            self.saw(numbers[0], count)
            return
        for one in numbers:
            self.saw(one, 1)


class Recording(Told):
    """A log of whatever arrives; from any thread. `prefixes` are where .msg files of other packages are looked for."""

    def __init__(
        self,
        path,
        patterns: Iterable[str],
        prefixes: Iterable[Path] = (),
        safety: Safety = Safety(),  # noqa: B008 - it cannot change
    ):
        self._patterns = tuple(patterns)
        self._folder_definition = cdr.definition_in_folders(prefixes)
        self._log = RawLogWriter(path, safety=safety)
        self._lock = threading.Lock()
        self._numbers: dict[str, tuple[int, bool]] = {}
        self._closed = False
        self._noted = 0, ""  # losses and mixed topics that stand in the log
        self.messages = self.unreadable = 0
        self.sequences: dict[str, Sequences] = {}
        self._sent: dict[str, Sequences] = {}  # by the numbers that the middleware gives messages
        self._uncounted: set[str] = set()

    def wants(self, topic: str) -> bool:
        """True if `topic` matches a pattern and is not recorded yet; hidden topics, as of actions, are not recorded."""
        if topic in self._numbers or "/_" in topic:
            return False
        return any(fnmatchcase(topic, pattern) for pattern in self._patterns)

    def add(self, topic: str, ros_type: str, type_hash: str, qos: tuple[Qos, ...]) -> None:
        """Describes a topic in the log; raises LogError for one too many, and for a type without a definition."""
        if len(self._numbers) >= MOST_TOPICS:
            raise LogError(f"there are {MOST_TOPICS} topics in the log, and no reader takes more")
        known = cdr.is_known(ros_type) and type_hash in (cdr.type_hash(ros_type), "INVALID")
        text = cdr.schema_text(ros_type) if known else cdr.full_definition(ros_type, self._folder_definition)
        has_samples = known and ros_type == cdr.SAMPLE_BLOCK
        with self._lock:
            if has_samples:
                self.sequences[topic] = Sequences()
            known_hash = cdr.type_hash(ros_type) if known else type_hash
            number = self._log.add_topic(topic, ros_type, text, known_hash, qos)
            self._numbers[topic] = (number, has_samples)
            self._sent[topic] = Sequences()

    def publishers(self, topic: str, count: int) -> None:
        """Notes how many publishers a topic has: of several, losses cannot be counted by number, nor is it thinned."""
        if count > 1:
            self._uncounted.add(topic)
        if topic in self.sequences:
            self.sequences[topic].several = count > 1
        self._log.keep_all(self._numbers[topic][0], count > 1)

    def receive_all(
        self,
        topic: str,
        received_ns: Sequence[int],
        sent_ns: Sequence[int],
        data: Sequence[bytes],
        sent_numbers: Sequence[int | None],
    ) -> int:
        """Logs messages of one topic as they came; returns how many outputs, or rows of records, were lost before them.

        `sent_numbers` count the messages of its publisher from 1 on, None where the middleware does not tell. What is
        sent as a SampleBlock and is none, or is larger than LARGEST_MESSAGE, for anybody may send, is counted as
        `unreadable` and not logged: no reader would get past it.
        """
        with self._lock:
            if self._closed:
                return 0
            number, has_samples = self._numbers[topic]
            messages, ranges, count = zip(repeat(number), received_ns, sent_ns, data, strict=False), [], len(data)
            if has_samples or max(map(len, data), default=0) > LARGEST_MESSAGE:
                found = [_range_or_none(one, has_samples) for one in data]
                ranges = [one for one in found if one]
                messages = [message for message, one in zip(messages, found, strict=True) if one]
                count = len(ranges)
            self._log.write_all(messages)
            self.messages += count
            self.unreadable += len(data) - count
            if None in sent_numbers:
                self._uncounted.add(topic)
            sent = self._sent[topic]
            before = sent.lost
            sent.saw_all([one - 1 for one in sent_numbers if one is not None])
            if not has_samples:
                return 0
            lost = sum(self.sequences[topic].saw(*one) for one in ranges)
            # Where no message is missing, outputs were never sent: those of a thinned log that is played.
            return 0 if sent.lost == before and None not in sent_numbers else lost

    @property
    def closed(self) -> bool:
        """True once the log is complete."""
        return self._closed

    def summary(self) -> str:
        """Messages, size and losses in one line."""
        lost = sum(self.status()[f"messages_{what}"] for what in ("lost", "dropped", "unreadable"))
        return f"{self._log.path}: {self.messages} messages, {in_bytes(self._log.bytes)}, {lost} lost"

    @property
    def folder(self) -> Path:
        """The folder of the log."""
        return self._log.path.parent

    def note_losses(self) -> None:
        """Writes what was lost so far into the log, so that a crash does not take the count along."""
        status = self.status()
        losses = sum(status[f"{what}_lost"] for what in ("messages", "samples", "records"))
        losses += status["messages_dropped"] + status["messages_unreadable"]
        with self._lock:
            if self._closed:
                return
            now = losses, status["mixed"]
            if now != self._noted and not self._log.problem:  # else once there is room
                self._noted = now
                self._log.add_metadata(RECORDING_RECORD, self._counts_of(status))

    def status(self) -> dict[str, float | str]:
        """Counts so far: topics, messages, bytes, and what was lost, of messages, solver outputs and rows of records.

        `lost_on` names the topics with lost messages, `uncounted` those whose lost messages nobody can count: several
        publishers, or no numbers; `mixed` those on which outputs of several stand among each other. Messages are
        dropped while the disk is full; those that no reader takes are unreadable.
        """
        outputs = [stream for topic, stream in self.sequences.items() if RECORDS not in topic]
        records = [stream for topic, stream in self.sequences.items() if RECORDS in topic]
        with self._lock:
            uncounted = self._uncounted | {topic for topic, sent in self._sent.items() if sent.restarts}
            counts = {topic: sent for topic, sent in self._sent.items() if topic not in uncounted}
        counted = counts.values()
        return {
            "topics": len(self._numbers),
            "messages": self.messages,
            "messages_lost": sum(sent.lost for sent in counted),
            "messages_before": sum(sent.before for sent in counted),
            "messages_dropped": self._log.dropped,
            "messages_unreadable": self.unreadable,
            "lost_on": " ".join(sorted(topic for topic, sent in counts.items() if sent.lost)),
            "uncounted": " ".join(sorted(uncounted)),
            "mixed": " ".join(sorted(topic for topic, stream in self.sequences.items() if stream.mixed >= MIXED)),
            "bytes": self._log.bytes,
            "samples_received": sum(stream.received for stream in outputs),
            "samples_lost": sum(stream.lost for stream in outputs),
            "records_lost": sum(stream.lost for stream in records),
            "restarts": sum(stream.restarts for stream in outputs),
        }

    def warning(self, status: dict) -> str:
        """The sentence about what a `status` counts as lost or not to be recorded, "" where nothing is."""
        if status["mixed"]:
            return f"several nodes publish {status['mixed']}: their outputs are mixed, so give each a namespace"
        for what in ("samples", "records"):
            if lost := status[f"{what}_lost"]:
                return f"{lost_in_words(lost, what == 'records')}; {MENDS}"
        if count := status["messages_unreadable"]:
            return f"{count} messages are not logged: they are no SampleBlock though sent as one, or too large"
        if count := status["messages_lost"]:
            return f"{count} messages were lost on the way; {MENDS}"
        return "" if status["topics"] else "no topic matches so far: there is nothing to record"

    def close(self) -> None:
        """Writes the counts into the log and completes it; may be called twice."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        try:
            self._log.add_metadata(RECORDING_RECORD, self._counts_of(self.status()))
        finally:
            self._log.close()

    @staticmethod
    def _counts_of(status: dict) -> dict:
        return {key: value for key, value in status.items() if key != "bytes"}


def _range_or_none(data: bytes, has_samples: bool) -> tuple[int, int] | None:
    """First number and count of the outputs of a SampleBlock, None of what is none or too large; of others (0, 0)."""
    if len(data) > LARGEST_MESSAGE:
        return None
    try:
        return readable_range(data) if has_samples else (0, 0)
    except LogError:
        return None


def lost_in_words(count: int, records: bool) -> str:
    """Message about lost solver outputs, or rows of `records`."""
    what = ("row" if count == 1 else "rows") + " of records" if records else f"solver output{'s' * (count != 1)}"
    return f"{count} {what} {'was' if count == 1 else 'were'} lost on the way"


def in_bytes(size: float) -> str:
    """A size with its unit, such as 3.2 MB."""
    power = min(max(int(math.log10(size) // 3) if size >= 1.0 else 0, 0), 4)
    return f"{size / 1000.0**power:.3g} {('B', 'kB', 'MB', 'GB', 'TB')[power]}"


def default_topics(namespace: str = "/") -> list[str]:
    """Topics of a recorder without the parameter `topics`: all in its own namespace, and the frames.

    A recorder that stands in none logs the namespaces of all kinds of scenes.
    """
    own = [namespace] if namespace.strip("/") else [kind.namespace for kind in KINDS.values()]
    return [*(f"{one}/*" for one in own), *FRAMES]


def definition_prefixes() -> list[Path]:
    """The installation prefixes of the ROS that is sourced."""
    return [Path(prefix) for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if prefix]
