"""Logs of runs: MCAP files that ROS tools open and play, and that give back every sample bit for bit."""

import hashlib
import json
import platform
from collections.abc import Iterator, Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml
from mcap.opcode import Opcode

import bearing_twin
from bearing_twin.errors import LogError, SceneError
from bearing_twin.log import cdr
from bearing_twin.log.channels import MessageStream, Topic, topics
from bearing_twin.log.mcap_read import DamagedLog, LoggedMessage, McapReader
from bearing_twin.log.raw_log import RUN_RECORD, RawLogWriter, log_files, raw_messages, refuse_existing
from bearing_twin.log.recover import Recovered, advice, recover
from bearing_twin.run.scene import Scene, parse_scene
from bearing_twin.run.simulation import Run
from bearing_twin.sample import Block, Channel, Sample

__all__ = [
    "LogStream", "LogSummary", "LogWriter", "RawLogWriter", "Recovered",
    "content_digest", "raw_messages", "read_log", "recover", "refuse_existing", "write_log",
]  # fmt: skip

SCENE_RECORD = "bearing_twin"
_PACKAGES = ("numpy", "scipy", "numba")


class LogSummary(NamedTuple):
    """What was written: path, messages, solver outputs, bytes on disk."""

    path: Path
    messages: int
    samples: int
    bytes: int


class LogWriter:
    """A new log of a scene's topics; use as a context manager, from any thread.

    `metadata` (chosen law, stepper, reason, seed, ...) is stored as texts beside the resolved scene and the versions.
    Raises LogError if `path` exists. `run_record` False leaves out what differs from run to run (date, host, costs).
    """

    def __init__(self, path, scene: Scene, metadata: Mapping[str, object] | None = None, run_record: bool = True):
        table = topics(scene)
        self._log = RawLogWriter(path, run_record)
        record = {"scene": yaml.safe_dump(scene.resolved(), sort_keys=False), **_versions(), **(metadata or {})}
        self._log.add_metadata(SCENE_RECORD, record)
        self._numbers = {}
        for topic in table:
            text, type_hash = cdr.schema_text(topic.ros_type), cdr.type_hash(topic.ros_type)
            self._numbers[topic.name] = self._log.add_topic(
                topic.full_name, topic.ros_type, text, type_hash, (topic.qos,)
            )

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self._log.__exit__(*exception)

    def write(self, topic: Topic, log_time_ns: int, publish_time_ns: int, cdr_bytes: bytes) -> None:
        """Adds one message as `MessageStream` made it; raises LogError, saying what was kept, when the disk is full."""
        self._log.write(self._numbers[topic.name], log_time_ns, publish_time_ns, cdr_bytes)

    def flush(self) -> None:
        """Puts everything so far on disk."""
        self._log.flush()

    def note_report(self, report: Mapping[str, object]) -> None:
        """Keeps the run's report (plain numbers and texts) beside date and host."""
        self._log.note_run(report=json.dumps(report))

    def close(self) -> None:
        """Completes the log."""
        self._log.close()

    @property
    def failed(self) -> bool:
        """Whether the disk was full: only `close` is possible then."""
        return self._log.failed

    @property
    def messages(self) -> int:
        """Messages on disk for good; all of them once closed."""
        return self._log.messages

    @property
    def bytes(self) -> int:
        """Size of the log on disk so far."""
        return self._log.bytes


def write_log(run: Run, path, run_record: bool = True) -> LogSummary:
    """Simulates `run` to its end into a new log at `path`, as far as it comes.

    Raises LogError if `path` exists, before anything is computed; whatever the run raises passes through after the
    log is completed with the outputs so far.
    """
    simulation = run.simulation
    choice = {"law": simulation.law, "stepper": simulation.stepper, "reason": simulation.choice_reason}
    samples = 0
    with LogWriter(path, run.scene, choice, run_record) as log:
        stream = MessageStream(run.scene, law=simulation.law)
        try:
            for block in run.blocks():
                for topic, stamp_ns, cdr_bytes in stream.messages(block):
                    log.write(topic, stamp_ns, stamp_ns, cdr_bytes)
                samples += len(block)
        finally:
            if not log.failed:
                for topic, stamp_ns, cdr_bytes in stream.flush():
                    log.write(topic, stamp_ns, stamp_ns, cdr_bytes)
        log.note_report(run.report.as_dict())
    return LogSummary(Path(path), log.messages, samples, log.bytes)


def read_log(path, allow_gaps: bool = False, topic: str | None = None) -> "LogStream":
    """The samples of a log (.mcap file or bag folder), as the run gave them out.

    Raises LogError if it is no log, is damaged (then also how much `recover` saves) or holds no `samples`; with several
    such topics `topic` chooses one. While iterating, outputs that are missing raise LogError unless `allow_gaps`.
    """
    return LogStream(path, allow_gaps, topic)


class LogStream:
    """The samples of a log: iterate it, or its `blocks()`, as often as wanted. Made by `read_log`.

    `scene` and `report` are None for a log that was recorded from the wire. `metadata` maps each record's name to its
    texts. `missing` counts outputs that were found missing so far (with `allow_gaps`).
    """

    def __init__(self, path, allow_gaps: bool, topic: str | None):
        self.path = Path(path)
        self.missing = 0
        self.metadata: dict[str, dict[str, str]] = {}
        self._allow_gaps = allow_gaps
        self._files = log_files(path)
        found: set[str] = set()
        try:
            for file in self._files:
                with McapReader(file) as reader:
                    summary = reader.summary()
                    self.metadata.update((record.name, record.metadata) for record in reader.metadata(summary))
                    found.update(
                        channel.topic
                        for channel in summary.channels.values()
                        if channel.schema_id in summary.schemas
                        and summary.schemas[channel.schema_id].name == cdr.SAMPLE_BLOCK
                    )
        except DamagedLog as error:
            raise advice(path, error) from error
        self._topic = _chosen(path, found, topic)
        stored = self.metadata.get(SCENE_RECORD, {}).get("scene")
        try:
            self.scene: Scene | None = parse_scene(stored, f"the scene in {self.path.name}") if stored else None
        except SceneError as error:
            raise LogError(f"{error}; the log is damaged, or was written by another version") from error
        self.report: dict | None = _report(self.metadata.get(RUN_RECORD, {}))
        first = next(self._sample_blocks(), None)
        self.channels: tuple[Channel, ...] = () if first is None else _channels(self.scene, first)

    def __iter__(self) -> Iterator[Sample]:
        for block in self.blocks():
            yield from block

    def blocks(self) -> Iterator[Block]:
        """The blocks as recorded; raises LogError where the log is damaged or outputs are missing."""
        self.missing = 0
        expected = None
        names = [channel.name for channel in self.channels]
        widths = [channel.width for channel in self.channels]
        for message in self._sample_blocks():
            if message.channel_name != names or message.channel_width.tolist() != widths:
                raise LogError(f"{self.path} changes its channels at output {message.first_sequence}; record it again")
            if expected is not None and message.first_sequence != expected:
                self._gap(expected, message.first_sequence)
            expected = message.first_sequence + message.count
            yield _block(self.channels, message)

    def _gap(self, expected: int, found: int) -> None:
        lost = max(found - expected, 0)
        self.missing += lost
        if self._allow_gaps:
            return
        if found < expected:
            raise LogError(
                f"the run in {self.path} starts again: output {found} follows {expected - 1} (it was reset while "
                "recorded); read it with allow_gaps=True"
            )
        raise LogError(
            f"{lost} outputs are missing in {self.path}, from sequence {expected} to {found - 1}: they were lost while "
            "recording; read the rest with allow_gaps=True"
        )

    def _sample_blocks(self):
        """The SampleBlock messages, checked."""
        try:
            for file in self._files:
                with McapReader(file) as reader:
                    for item in reader.content():
                        if isinstance(item, LoggedMessage) and item.topic.name == self._topic:
                            message = cdr.deserialise(cdr.SAMPLE_BLOCK, item.data)
                            _check(self.path, message)
                            yield message
        except DamagedLog as error:
            raise advice(self.path, error) from error


def content_digest(path) -> str:
    """SHA-256 of everything in a log except date, host and costs: equal for two runs of one scene on one machine."""
    digest = hashlib.sha256()
    for file in log_files(path):
        with McapReader(file) as reader:
            for opcode, content in reader.digest_parts():
                if opcode != Opcode.METADATA or _metadata_name(content) != RUN_RECORD:
                    digest.update(opcode.to_bytes(1, "little") + len(content).to_bytes(8, "little"))
                    digest.update(content)
    return digest.hexdigest()


def _metadata_name(content: bytes) -> str:
    length = int.from_bytes(content[:4], "little")
    return content[4 : 4 + length].decode(errors="replace")


def _versions() -> dict[str, str]:
    found = {"bearing_twin_version": bearing_twin.__version__, "python_version": platform.python_version()}
    for package in _PACKAGES:
        try:
            found[f"{package}_version"] = version(package)
        except PackageNotFoundError:
            found[f"{package}_version"] = "unknown"
    return found


def _report(record: Mapping[str, str]) -> dict | None:
    try:
        return json.loads(record["report"])
    except (KeyError, ValueError):
        return None


def _chosen(path, found: set[str], topic: str | None) -> str:
    if not found:
        raise LogError(f"{path} holds no topic of type {cdr.SAMPLE_BLOCK}; record /bearing/samples to read it back")
    if topic is None and len(found) == 1:
        return next(iter(found))
    if topic not in found:
        asked = f"not {topic!r} " if topic else ""
        raise LogError(f"{path} holds samples on {', '.join(sorted(found))}, {asked}- name one of these as `topic`")
    return topic


def _check(path, message) -> None:
    row = int(message.channel_width.sum(dtype=np.int64))
    fits = (
        message.count == len(message.time_ns) > 0
        and len(message.channel_name) == len(message.channel_unit) == len(message.channel_width)
        and len(message.values) == message.count * row
    )
    if not fits:
        raise LogError(f"{path}: the SampleBlock at output {message.first_sequence} contradicts itself; record again")


def _channels(scene: Scene | None, message) -> tuple[Channel, ...]:
    """The channels of a SampleBlock; shapes and meanings where the names are those of a bearing, else flat."""
    widths = dict(zip(message.channel_name, message.channel_width.tolist(), strict=True))
    if scene is None and widths.get("orbit_angle"):
        scene = parse_scene({"kind": "bearing", "geometry": {"balls": widths["orbit_angle"]}}, "recorded")
    known = {channel.name: channel for channel in scene.channels} if scene is not None else {}
    rows = []
    for (name, width), unit in zip(widths.items(), message.channel_unit, strict=True):
        channel = known.get(name)
        fits = channel is not None and channel.width == width and channel.unit == unit
        rows.append(channel if fits else Channel(name, unit, (width,), ""))
    return tuple(rows)


def _block(channels: tuple[Channel, ...], message) -> Block:
    matrix = message.values.reshape(message.count, -1)
    views = Block.from_matrix(channels, int(message.first_sequence), np.array(message.time_ns), matrix)
    # Copies: compiled code is made for arrays that lie in one piece, as they come from a simulation.
    values = {name: np.array(view, order="C") for name, view in views.values.items()}
    return Block(channels, views.first_sequence, views.time_ns, values)
