"""Logs of runs: MCAP files that ROS tools open and play, and that give back every sample bit for bit."""

import functools
import hashlib
import json
import math
import platform
import sys
import time
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from os import PathLike
from pathlib import Path
from typing import NamedTuple

from mcap.records import Metadata

import bearing_twin
from bearing_twin.errors import LogError
from bearing_twin.log import cdr
from bearing_twin.log.bag import log_files, raw_messages, reader_of
from bearing_twin.log.consecutive import Consecutive
from bearing_twin.log.parts import Told
from bearing_twin.log.raw_log import (
    OUTPUTS_KEY,
    RUN_RECORD,
    SCENE_RECORD,
    RawLogWriter,
    Safety,
    refuse_existing,
)
from bearing_twin.log.recover import Recovered, recover
from bearing_twin.log.run_log import LogStream, read_log
from bearing_twin.log.stream import Channelled, MessageStream, choice_record, topics
from bearing_twin.run.passes import Run
from bearing_twin.run.scene import Scene
from bearing_twin.spelling import echo

__all__ = [
    "LogStream", "LogSummary", "LogWriter", "RawLogWriter", "Recovered",
    "choice_record", "content_digest", "raw_messages", "read_log", "recover", "refuse_existing", "write_log",
]  # fmt: skip

ENCODED_TOGETHER = 2000  # outputs: what is done once for a block weighs little then ...
ENCODED_BYTES = 10 << 20  # ... at most so many bytes of them, so that memory stays small ...
ENCODED_SECONDS = 0.5  # ... and none waits longer than this for the next
_PACKAGES = ("numpy", "scipy", "numba")


class LogSummary(NamedTuple):
    """What was written: path, messages, solver outputs, bytes on disk."""

    path: Path
    messages: int
    samples: int
    bytes: int


class LogWriter(Told):
    """A new log of a scene's topics; use as a context manager, from any thread.

    `metadata` (chosen law, stepper, reason, seed, ...) is stored as texts beside the resolved scene and the versions.
    Raises LogError if `path` exists. `run_record` False leaves out what differs from run to run (date, host, costs).
    """

    def __init__(
        self,
        path,
        scene: Scene,
        metadata: Mapping[str, object] | None = None,
        run_record: bool = True,
        safety: Safety = Safety(),  # noqa: B008 - it cannot change
    ):
        table, outside = topics(scene), "; ".join(scene.outside) if scene.marked else ""
        self._log = RawLogWriter(path, run_record, safety)
        self._numbers = {}
        try:
            self._log.add_metadata(SCENE_RECORD, {"scene": scene.text, **_versions(), **(metadata or {})})
            for topic in table:
                text, type_hash = cdr.schema_text(topic.ros_type), cdr.type_hash(topic.ros_type)
                self._numbers[topic.name] = self._log.add_topic(
                    topic.full_name, topic.ros_type, text, type_hash, (topic.qos,), outside=outside
                )
        except BaseException:  # Ctrl-C before the first message
            self.__exit__(*sys.exc_info())
            raise

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self._log.__exit__(*exception)

    def write(self, topic: Channelled, stamp_ns: int, cdr_bytes: bytes) -> None:
        """Adds one message as `MessageStream` made it, its stamp as log and publish time.

        Raises LogError, saying what was kept, when the disk is full.
        """
        self._log.write(self._numbers[topic.name], stamp_ns, stamp_ns, cdr_bytes)

    def write_stream(self, stream: MessageStream, block: Consecutive | None) -> None:
        """Adds all messages of a block of outputs, or at the end, for None, those of the outputs that wait."""
        self._log.write_bundles(stream.bundles(block, self._numbers))

    def note_report(self, report: Mapping[str, object]) -> None:
        """Keeps the run's report (plain numbers and texts) beside date and host."""
        self._log.note_run(report=json.dumps(report))

    def close(self) -> None:
        """Completes the log."""
        self._log.close()

    @property
    def messages(self) -> int:
        """Messages on disk for good; all of them once closed."""
        return self._log.messages


def write_log(run: Run, path: str | PathLike, run_record: bool = True, max_loss: float = 0.0) -> LogSummary:
    """Simulates `run` to its end into a new log at `path`, as far as it comes.

    What was written more than `max_loss` [s] ago is on disk whatever happens; 0 = as chunks become full, which gives
    the same bytes for the same run. Raises LogError if `path` exists, before anything is computed; whatever the run
    raises passes through after the log is completed with the outputs so far, and with the report on them.
    """
    if not hasattr(run, "blocks"):
        raise LogError(f"a log is written of a run, and {echo(run)} is none; hand over simulate(scene)")
    if isinstance(max_loss, bool) or not isinstance(max_loss, (int, float)) or not 0.0 <= max_loss < math.inf:
        raise LogError(f"max_loss = {echo(max_loss)} must be a number in s, at least 0")
    together = max(
        1, min(ENCODED_TOGETHER, ENCODED_BYTES // (8 * sum(channel.width for channel in run.scene.channels)))
    )
    samples, waiting, since = 0, [], time.monotonic()
    described = {**choice_record(run.choice), OUTPUTS_KEY: run.scene.outputs}
    with LogWriter(path, run.scene, described, run_record, Safety(max_loss)) as log:
        stream = MessageStream(run.scene, choice=run.choice)

        def write() -> None:
            piece = Consecutive(waiting.copy())
            waiting.clear()
            log.write_stream(stream, piece)

        try:
            for block in run.blocks():
                samples += len(block)
                if waiting and block.first_sequence != waiting[-1].first_sequence + len(waiting[-1]):
                    write()  # a gap stays where it is
                waiting.append(block)
                late = max_loss or time.monotonic() > since + ENCODED_SECONDS
                if late or sum(map(len, waiting)) >= together:
                    write()
                    since = time.monotonic()
        finally:
            if not log.problem:
                if waiting:
                    write()
                log.write_stream(stream, None)
                if samples:
                    log.note_report(run.report.record())
    return LogSummary(Path(path), log.messages, samples, log.bytes)


def content_digest(path) -> str:
    """SHA-256 of everything in a log except date, host and costs: equal for two runs of one scene on one machine.

    How messages are put together in chunks makes no difference: it depends on when a node flushed them. Nor does it
    that a node may end its log at any time, where a whole run says how long it is.
    """
    digest, topics_told = hashlib.sha256(), {}
    for file in log_files(path):
        with reader_of(file) as reader:
            reader.require_end()
            for item in reader.content():
                if isinstance(item, Metadata):
                    if item.name != RUN_RECORD:
                        said = [one for one in sorted(item.metadata.items()) if one[0] != OUTPUTS_KEY]
                        digest.update(repr((item.name, said)).encode())
                    continue
                if item.topic.name not in topics_told:
                    topics_told[item.topic.name] = len(topics_told)
                    digest.update(repr(item.topic.identity).encode())
                head = topics_told[item.topic.name], item.log_time, item.publish_time, len(item.data)
                digest.update(repr(head).encode())
                digest.update(item.data)
    return digest.hexdigest()


@functools.cache
def _versions() -> dict[str, str]:
    found = {"bearing_twin_version": bearing_twin.__version__, "python_version": platform.python_version()}
    for package in _PACKAGES:
        found[f"{package}_version"] = getattr(sys.modules.get(package), "__version__", "") or _installed(package)
    return found


def _installed(package: str) -> str:
    """The version of a package that is not imported: to ask for it parses a file."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"
