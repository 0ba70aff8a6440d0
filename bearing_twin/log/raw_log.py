"""Logs of any ROS topics while they are written, without decoding the messages.

A log is one `.mcap` file, or a rosbag2 folder when its path has no suffix `.mcap`: `<name>/<name>_0.mcap` beside a
`metadata.yaml`, which is there from the start, so that a crash leaves a bag that other tools accept after recovery.
"""

import datetime
import platform
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import nullcontext, suppress
from pathlib import Path

from mcap.records import Attachment, Metadata

from bearing_twin.errors import LogError
from bearing_twin.kinds.ranges import OUTSIDE
from bearing_twin.log.bag import SUFFIX, LoggedTopic, Qos, offered_qos, path_of, qos_text
from bearing_twin.log.bundles import Bundle
from bearing_twin.log.mcap_read import StoredTopic
from bearing_twin.log.mcap_write import refused
from bearing_twin.log.parts import Parts, Safety, Told, part_names
from bearing_twin.log.thinning import KEPT_KEY, Thinning
from bearing_twin.paths import put_whole
from bearing_twin.signals import Unbroken

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
