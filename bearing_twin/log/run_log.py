"""Logs of runs, written and read: MCAP files that ROS tools play, and that give back every sample bit for bit."""

import dataclasses
import functools
import itertools
import json
import math
import platform
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from importlib.metadata import version
from numbers import Real
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import bearing_twin
from bearing_twin.base.errors import LogError, SceneError, echo
from bearing_twin.base.report import Choice, CutShort, json_text, parse_json
from bearing_twin.base.sample import Block, Channel, Sample, Table, records_between
from bearing_twin.contact.laws import LAWS
from bearing_twin.kinds.contract import Topic
from bearing_twin.log import cdr
from bearing_twin.log.bag import LogReader, path_of
from bearing_twin.log.mcap_read import LoggedMessage
from bearing_twin.log.raw_log import (
    BEGINS_KEY,
    KEPT_KEY,
    LOSSES,
    OUTPUTS_KEY,
    RECORDING_RECORD,
    RUN_RECORD,
    SCENE_RECORD,
    STATE_RECORD,
    RawLogWriter,
    Safety,
)
from bearing_twin.log.stream import (
    NUMBERED,
    MessageStream,
    block_of,
    channels_of,
    checked_block,
    choice_record,
    records_of,
    refuse_misfits,
    sample_range,
    topics,
)
from bearing_twin.run.dataset import dataset_of
from bearing_twin.run.failure import logged_failure
from bearing_twin.run.scene import Scene, choose, read_logged_scene
from bearing_twin.run.simulation import Run

MOST_RUNS = 10_000
MOST_HELD = 1 << 24  # numbers of records that are held together, 128 MB


def value_in(record: Mapping[str, str], key: str, types: type | tuple[type, ...], default=None):
    """The value that a metadata record has as JSON under a key; the default without one of these types."""
    try:
        value = parse_json(record[key])
    except (KeyError, ValueError):
        return default
    return value if isinstance(value, types) else default


def scene_record(text: str) -> dict[str, str]:
    """The content of a message of the topic `scene` as texts; raises ValueError or AttributeError for other text."""
    content = parse_json(text)
    return {key: value if isinstance(value, str) else json.dumps(value) for key, value in content.items()}


def choice_in(record: Mapping[str, str]) -> Choice:
    """The model named in a log's metadata; empty texts without one."""
    law, stepper, reason, friction = (record.get(key, "") for key in ("law", "stepper", "reason", "friction"))
    warnings = tuple(map(str, value_in(record, "warnings", list, ())))
    setting = float(value_in(record, "setting", (int, float), math.nan))
    return Choice(law, stepper, math.nan, reason, warnings, setting, friction=friction)


def known_choice(choice: Choice, scene: Scene | None) -> Choice:
    """The model named in a log; without a known law there, the model of its scene today, with a warning."""
    if scene is None or choice.law in LAWS:
        return choice
    current = choose(scene)
    if choice.law == current.law:  # of a kind that has laws of its own
        return choice
    problem = f"names the law {echo(choice.law)}, which there is not" if choice.law else "does not name its law"
    warning = f"the log {problem}: it is judged by {current.law}, which its scene gets now"
    return current._replace(stepper=choice.stepper or current.stepper, warnings=(*choice.warnings, warning))


def read_log(
    path: Any, allow_gaps: bool = False, topic: str | None = None, last_run: bool = False, run: int | None = None
) -> "LogStream":
    """The samples of a log, as the run computed them.

    Parameters
    ----------
    path : str or path
        An .mcap file or a bag folder.
    allow_gaps : bool
        False: outputs that are missing or begin again raise LogError while iterating. True: they are passed over and
        counted, and an unfinished log is read as far as it goes.
    topic : str, optional
        The topic of the samples, where there are several.
    last_run : bool
        True takes the last run alone of the recording of a node that was reset or started again.
    run : int, optional
        Takes one run alone, the first being 1. Without `run` and `last_run` all are read.

    Returns
    -------
    LogStream
        Iterated it gives one `Sample` an output, `blocks()` many outputs at once; `scene`, `channels` with units and
        meanings, `report`, `to_xarray()`.

    Raises
    ------
    LogError
        If it is no log, is damaged (then also how much `recover` saves) or holds no samples.
    """
    return LogStream(path, allow_gaps, topic, -1 if last_run and run is None else run)


class LogStream:
    """The samples of a log, of its `topic`: iterate it, or its `blocks()`, any number of times. Made by `read_log`.

    `scene` is that of the metadata or, of a recording, of its topic `scene`; None where there is neither. `choice` is
    the model in use, `report` what the run said of itself (None for recordings). `metadata` maps each record's name to
    its texts. With `allow_gaps`, `missing` counts outputs that were found missing so far.
    `kept_rate` [1/s] is how many outputs a second of simulated time were logged, 0 = all; what then lies between is not
    missing. `frame` is what the samples are stamped with. `runs` is the number of runs in the log, `run` that of the
    one that is read (None: all), `begins_s` the time [s] of its first output and `end` the number behind its last.
    """

    def __init__(self, path, allow_gaps: bool, topic: str | None, run: int | None = None):
        self.path: Path = path_of(path)
        self.missing, self._reached = 0, 0
        self._allow_gaps = allow_gaps
        self._reader = LogReader(path, unfinished=allow_gaps)
        self.metadata: dict[str, dict[str, str]] = self._reader.metadata
        stored = [channel for channel in self._reader.topics if channel.ros_type in NUMBERED and not channel.foreign]
        sampled = {channel.name for channel in stored if channel.ros_type == cdr.SAMPLE_BLOCK}
        if not sampled:
            self._refuse_unfinished()
        self.topic = _selected_topic(path, {name for name in sampled if "/records/" not in name}, topic)
        rates = (value_in(row.metadata, KEPT_KEY, (int, float), 0.0) for row in stored if row.name == self.topic)
        self.kept_rate: float = max(0.0, *rates)
        self.namespace = self._namespace()
        records = f"{self.namespace}/records/"
        self._tables = dict.fromkeys(channel.name for channel in stored if channel.name.startswith(records))
        self.report: dict | None = value_in(self.metadata.get(RUN_RECORD, {}), "report", dict)
        self._by_time = True  # else in the order of the file
        self._runs = self._find_runs()
        self.runs = len(self._runs)
        if run is not None and run != -1 and run not in range(1, self.runs + 1):
            several = f"{self.runs} runs: give one from 1 to {self.runs}" if self.runs > 1 else "one run"
            raise LogError(f"run {echo(run)} is not in {path}, which holds {several}")
        self._run_selected = run not in (None, -1)
        self.run: int | None = self.runs if run == -1 else run
        self._read = self._runs if self.run is None else self._runs[self.run - 1 : self.run]
        self.end = self._read[-1].end
        described = self.metadata.get(SCENE_RECORD, {})
        described = described if described.get("scene") else self._topic_scene() or described
        text = described.get("scene")
        try:
            self.scene: Scene | None = read_logged_scene(text, f"the scene in {self.path.name}") if text else None
        except SceneError as error:
            raise LogError(f"{error}; the log is damaged, or was written by another version") from error
        self.choice = known_choice(choice_in(described), self.scene)
        if self.scene is not None:
            self.choice = self.choice._replace(outside=self.scene.outside)
        first = next(self._decode(self._messages_read(self.topic)), None)
        if first is None:
            self._refuse_unfinished()
        self.channels: tuple[Channel, ...] = () if first is None else channels_of(self.scene, first)
        refuse_misfits(self.path, self.scene, self.channels)
        self.frame: str = "" if first is None else first.header.frame_id
        self.begins_s: float = 1e-9 * int(first.time_ns[0]) if first is not None and first.first_sequence else 0.0

    def _namespace(self) -> str:
        """Namespace of the run: that of the samples, or where these were remapped that of the only scene."""
        own = self.topic.rpartition("/")[0]
        names = {channel.name for channel in self._reader.topics if channel.ros_type == cdr.STRING}
        scenes = {name for name in names if name.endswith("/scene")}
        return own if f"{own}/scene" in scenes or len(scenes) != 1 else scenes.pop().removesuffix("/scene")

    def _refuse_unfinished(self) -> None:
        """Raises LogError where the log, which has no outputs, has no end either."""
        if self._reader.ends:
            raise LogError(f"{'; '.join(self._reader.ends)}; no outputs are in it so far")

    def __repr__(self) -> str:
        scene = "a recording without its scene" if self.scene is None else self.scene.name
        return f"Log of {scene} in {self.path}: {self.end} outputs of {len(self.channels)} channels on {self.topic}"

    @property
    def tables(self) -> tuple[Table, ...]:
        """Tables of the records between outputs; none if the log lacks its scene."""
        return self.scene.tables if self.scene else ()

    @property
    def seconds(self) -> float:
        """Duration of the run [s]: to its last output where that is known, else its scene's; else infinite."""
        if self.scene is None:
            return math.inf
        return 1e-9 * self.end * self.scene.output_period_ns or self.scene.parameters.run.duration

    @property
    def losses(self) -> dict[str, int | str]:
        """Messages that a recorder counted and that are not in its log, by key; empty for any other log.

        `uncounted` names topics of several publishers, whose losses are not known.
        """
        recording = self.metadata.get(RECORDING_RECORD, {})
        counts = {key: count for key in LOSSES if (count := value_in(recording, key, int)) is not None}
        return counts | ({"uncounted": recording["uncounted"]} if recording.get("uncounted") else {})

    @property
    def foreign(self) -> dict[str, int]:
        """Messages that are passed over because no ROS 2 program can read them, by channel: see `LogReader`."""
        return self._reader.foreign

    @property
    def notes(self) -> list[str]:
        """Parts of the run that are not read, a sentence each: files without an end, foreign messages, a late begin."""
        sentence = f"the log begins at {self.begins_s:.6g} s: its figures are those from then on"
        return self._reader.notes + ([sentence] if self.begins_s and not self.begins else [])

    @property
    def cut_short(self) -> CutShort | None:
        """The end of a log before its scene's, once it was read; None at the scene's end, or where the run failed.

        It is None for the log of a node or a recorder, which the user ends.
        """
        outputs = value_in(self.metadata.get(SCENE_RECORD, {}), OUTPUTS_KEY, int, 0)
        if self.scene is None or not 0 < self._reached < outputs or logged_failure(self.report or {}):
            return None
        period = 1e-9 * self.scene.output_period_ns
        return CutShort((self._reached - 1) * period, (outputs - 1) * period)

    @property
    def begins(self) -> int:
        """Number of the first output of a run that continues another, else 0."""
        return max(0, value_in(self.metadata.get(SCENE_RECORD, {}), BEGINS_KEY, int, 0))

    @property
    def state(self) -> tuple[int, dict] | None:
        """Number of the last output and the state of the motion there, to continue the run from; None without one."""
        record = self.metadata.get(STATE_RECORD, {})
        sequence, state = value_in(record, "sequence", int), value_in(record, "state", dict)
        return None if sequence is None or state is None else (sequence, state)

    @property
    def run_note(self) -> str:
        """A warning for figures of one run of a recording with several; "" if there is one or the caller chose it."""
        if self.runs == 1:
            return ""
        if self.topic in self.metadata.get(RECORDING_RECORD, {}).get("mixed", "").split():
            return (
                "several nodes sent samples at a time, and their outputs are mixed: the figures hold for none of them; "
                "record each node in its own namespace"
            )
        if self._run_selected:
            return ""
        effect = f"figures are those of run {self.run} of {self.runs}; --run N for another"
        if self.run is None:
            effect = "time and sequence begin again"
        return f"the log holds {self.runs} runs, as the node was reset or started again: {effect}"

    @property
    def warnings(self) -> list[str]:
        """Parts of the run that are missing in the log or were not read, a sentence each; complete once it was read."""
        sentences = [*self.notes, self.run_note]
        if self.missing:
            sentences.append(f"{self.missing} outputs are missing from the log")
        if self.kept_rate:
            extent = "greatest and mean values are of those, and `verify` compares no others"
            sentences.append(f"the log holds {self.kept_rate:g} outputs a second, not all (full: false): {extent}")
        if self.cut_short:
            sentences.append(self.cut_short.sentence())
        sentences += [f"{self.losses[key]} messages {loss}" for key, loss in LOSSES.items() if self.losses.get(key)]
        return list(filter(None, sentences))

    @property
    def has_records(self) -> bool:
        """True where the log has topics of records, events between outputs."""
        return bool(self._tables)

    def __iter__(self) -> Iterator[Sample]:
        for block in self.blocks():
            yield from block

    def to_xarray(self) -> Any:
        """The log as an `xarray.Dataset` (extra `export`); see `run.dataset.dataset_of`."""
        return dataset_of(self)

    def blocks(self) -> Iterator[Block]:
        """The blocks as recorded; raises LogError where the log is damaged or outputs are missing."""
        self.missing, self._reached = 0, 0
        expected = None
        names = [channel.name for channel in self.channels]
        widths = [channel.width for channel in self.channels]
        stored = {name: self._messages_read(name) for name in (self.topic, *self._tables)}
        for run in self._read:
            counts = run.stop - run.start
            parts = {name: itertools.islice(messages, counts[name]) for name, messages in stored.items()}
            pending, records = None, self._records(run, parts)
            for message in self._decode(parts[self.topic]):
                if message.channel_name != names or message.channel_width.tolist() != widths:
                    raise LogError(
                        f"{self.path} changes its channels at output {message.first_sequence}; record it again"
                    )
                if expected is not None and message.first_sequence != expected:
                    self._check_sequence(expected, message.first_sequence)
                expected = self._reached = message.first_sequence + message.count
                if pending is not None:
                    yield _add_records(pending, records, int(pending.time_ns[-1]))
                pending = block_of(self.channels, message)
            if pending is not None:
                yield _add_records(pending, records, np.inf)

    def _records(self, run: "_Run", parts: Mapping[str, Iterator[LoggedMessage]]) -> dict[str, "_Records"]:
        """The records of a run by the name of their table, from its messages by topic."""
        rates = {table.name: table.rate for table in self.tables}
        return {
            (table := name.rpartition("/")[2]): _Records(self.path, name, parts[name], bool(rates.get(table)))
            for name in self._tables
            if run.stop[name] > run.start[name]
        }

    def _topic_scene(self) -> dict[str, str]:
        """The content of the topic `scene` of a recording, as texts; empty without a message.

        It is that of the last run that is read: a node that was started again may have another scene.
        """
        topic = f"{self.namespace}/scene"
        count = self._read[-1].stop[topic]
        if not count:
            return {}
        (last,) = itertools.islice(self._messages_of({topic}), count - 1, count)
        try:
            return scene_record(cdr.deserialise(cdr.STRING, last.data).data)
        except (ValueError, AttributeError) as error:
            raise LogError(f"the scene in {self.path.name} cannot be read ({error}); record it again") from error

    def _check_sequence(self, expected: int, first: int) -> None:
        if self.kept_rate and first > expected:
            return
        lost = max(first - expected, 0)
        self.missing += lost
        if self._allow_gaps:
            return
        if first < expected:
            raise LogError(
                f"{self.path} holds {self.runs} runs, as the node was reset or started again: output {first} follows "
                f"{expected - 1}; read one with run=1 to {self.runs}, the last with last_run=True, or all with "
                "allow_gaps=True"
            )
        raise LogError(
            f"{lost} outputs are missing in {self.path}, from sequence {expected} to {first - 1}: they were lost while "
            "recording; read the rest with allow_gaps=True"
        )

    def _find_runs(self) -> list["_Run"]:
        """The runs in the log, at least one; records after the last samples of a run belong to the next one.

        Messages are in the order of time, except for a recording by the clock of a simulation that began again: its
        runs overlap in time, and follow each other in the file.
        """
        names = {self.topic, f"{self.namespace}/scene", *self._tables}
        runs, breaks = self._runs_among(self._messages_of(names))
        if breaks:
            self._by_time = False
            runs_in_file, breaks_in_file = self._runs_among(self._messages_of(names))
            if breaks_in_file <= breaks:
                runs, breaks = runs_in_file, breaks_in_file
            else:
                self._by_time = True
        if breaks == math.inf:
            reason = f"begin again more than {MOST_RUNS} times: several nodes sent them, or each was logged twice"
            raise LogError(f"the outputs on {self.topic} in {self.path} {reason}; record one node alone, once")
        return runs

    def _runs_among(self, messages: Iterable[LoggedMessage]) -> tuple[list["_Run"], float]:
        """The runs in messages in this order, and how many SampleBlocks do not follow the one before them.

        This number is infinite where there are more than MOST_RUNS: runs that overlap in time alternate in that order.
        """
        runs, seen, breaks, expected = [_Run()], Counter[str](), 0, None
        for message in messages:
            seen[message.topic.name] += 1
            if message.topic.name != self.topic:
                continue
            first, count = sample_range(message.data)
            breaks += expected not in (None, first)
            expected = first + count
            if count and first < runs[-1].end:
                runs.append(_Run(runs[-1].stop))
            if len(runs) > MOST_RUNS:
                return runs, math.inf
            runs[-1].stop, runs[-1].end = seen.copy(), expected
        runs[-1].stop = seen
        return runs, breaks

    def _messages_of(self, topics: set[str]) -> Iterator[LoggedMessage]:
        """The messages of topics as the runs count them."""
        messages = (self._reader.messages if self._by_time else self._reader.in_file_order)(topics)
        return (
            message
            for message in messages
            if message.topic.name != self.topic or message.topic.ros_type == cdr.SAMPLE_BLOCK
        )

    def _messages_read(self, topic: str) -> Iterator[LoggedMessage]:
        """The messages of a topic in the runs that are read."""
        return itertools.islice(self._messages_of({topic}), self._read[0].start[topic], self._read[-1].stop[topic])

    def _decode(self, messages: Iterable[LoggedMessage]) -> Iterator[Any]:
        """The SampleBlocks in messages, checked."""
        return (checked_block(self.path, message.data) for message in messages)


def _add_records(block: Block, records: Mapping[str, "_Records"], time_ns: float) -> Block:
    """The block with the records up to a time."""
    return dataclasses.replace(block, records={name: rows.until(time_ns) for name, rows in records.items()})


class _Records:
    """The records of one table, read message by message and taken up to the time of each block of outputs."""

    def __init__(self, path, topic: str, messages: Iterable[LoggedMessage], sampled: bool):
        self._path, self._topic = path, topic
        self._parts = self._read(messages, sampled)
        self._remaining = next(self._parts, np.zeros((0, 1)))

    def _read(self, messages: Iterable[LoggedMessage], sampled: bool) -> Iterator[np.ndarray]:
        """The records of each message, those of a signal that is `sampled` in single precision."""
        columns, reached = None, -math.inf
        for message in messages:
            if message.topic.ros_type not in NUMBERED:
                continue
            rows = records_of(self._path, message.topic.ros_type, message.data)
            columns = columns or rows.shape[1]
            if rows.shape[1] != columns:
                raise LogError(
                    f"{self._path}: records on {self._topic} have {rows.shape[1]} columns, not {columns} as before; "
                    "record it again"
                )
            if message.topic.ros_type == cdr.WAVEFORM and rows[0, 0] < reached:
                reason = f"a Waveform at {rows[0, 0]:.6g} s on {self._topic} is behind a later one"
                raise LogError(f"{self._path}: {reason}; record it again")
            reached = rows[-1, 0]
            if sampled:  # earlier versions wrote samples in double precision
                rows = np.hstack((rows[:, :1], rows[:, 1:].astype(np.float32)))
            yield rows

    def until(self, time_ns: float) -> np.ndarray:
        """The records up to `time_ns` that were not taken before."""
        taken = [records_between(self._remaining, -np.inf, time_ns)]
        while len(taken[-1]) == len(self._remaining) and (following := next(self._parts, None)) is not None:
            self._remaining = following
            taken.append(records_between(following, -np.inf, time_ns))
            if sum(part.size for part in taken) > MOST_HELD:
                reason = f"more numbers on {self._topic} than are held at once, {MOST_HELD}"
                raise LogError(f"{self._path} has {reason}; its outputs are too far apart, or its records too many")
        self._remaining = self._remaining[len(taken[-1]) :]
        return np.concatenate(taken)


@dataclasses.dataclass
class _Run:
    """One run of a log: numbers of messages before it and up to its end by topic, and the number after its last output.

    Messages of a topic are counted in the order in which they are read.
    """

    start: Counter[str] = dataclasses.field(default_factory=Counter)
    stop: Counter[str] = dataclasses.field(default_factory=Counter)
    end: int = 0


def _selected_topic(path, names: set[str], topic: str | None) -> str:
    """The topic to read among `names`; raises LogError where it is missing or ambiguous."""
    if not names:
        raise LogError(f"{path} holds no topic of type {cdr.SAMPLE_BLOCK}; record /bearing/samples to read it back")
    if topic is None and len(names) == 1:
        return next(iter(names))
    if topic not in names:
        listed = ", ".join(sorted(names)) + (f", not {topic!r}" if topic else "")
        raise LogError(f"{path} holds samples on {listed}; read one with --topic, or read_log(path, topic=...)")
    return topic


class LogSummary(NamedTuple):
    """A log that was written: path, messages, solver outputs, bytes on disk."""

    path: Path
    messages: int
    samples: int
    bytes: int


class LogWriter(RawLogWriter):
    """A new log of a scene's topics; use as a context manager, from any thread.

    `metadata` (chosen law, stepper, reason, seed, ...) is stored as texts with the resolved scene and the versions.
    Raises LogError if `path` exists. `run_record` False omits what differs from run to run (date, host, costs).
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
        super().__init__(path, run_record, safety)
        try:
            self.add_metadata(SCENE_RECORD, {"scene": scene.text, **_versions(), **(metadata or {})})
            self._numbers = {
                topic.name: self.add_topic(topic.full_name, topic.ros_type, qos=(topic.qos,), outside=outside)
                for topic in table
            }
        except BaseException:  # Ctrl-C before the first message
            self.__exit__(*sys.exc_info())
            raise

    def write_messages(self, messages: Iterable[tuple[Topic, int, bytes]]) -> None:
        """Adds messages of a `MessageStream`, their stamps as log and publish times.

        Raises LogError, with the number of messages in the file, when the disk is full.
        """
        self.write_all((self._numbers[topic.name], stamp, stamp, data) for topic, stamp, data in messages)

    def note_report(self, report: Mapping[str, object]) -> None:
        """Stores the run's report (plain numbers and texts) with date and host."""
        self.note_run(report=json.dumps(report))

    def note_state(self, sequence: int, state: Mapping[str, object]) -> None:
        """Stores the state of the motion after output `sequence`, to continue the run from."""
        self.add_metadata(STATE_RECORD, {"sequence": sequence, "state": json_text(state)})


def write_log(run: Run, path: str | PathLike, run_record: bool = True, max_loss: float = 0.0) -> LogSummary:
    """Simulates a run to its end, or to its failure, into a new log.

    Parameters
    ----------
    run : Run
        A run of `simulate`; it starts again.
    path : str or path
        The log, an .mcap file that must not exist.
    run_record : bool
        False omits what differs from run to run: date, host, cost.
    max_loss : float
        Longest time [s] after which a message is on disk; 0 = as chunks become full, which gives the same bytes for the
        same run.

    Returns
    -------
    LogSummary
        Path, numbers of messages and samples, size [bytes].

    Raises
    ------
    LogError
        If `path` exists, before anything is computed, or the disk is full.
    IntegrationError
        Where the run breaks off, after the log is completed with the outputs so far and the report on them.
    """
    if not hasattr(run, "blocks"):
        raise LogError(f"a log is written of a run, and {echo(run)} is none; hand over simulate(scene)")
    if isinstance(max_loss, bool) or not isinstance(max_loss, Real) or not 0.0 <= max_loss < math.inf:
        raise LogError(f"max_loss = {echo(max_loss)} must be a number in s, at least 0")
    samples, described = 0, {**choice_record(run.choice), OUTPUTS_KEY: run.scene.outputs}
    if begins := getattr(run, "begins", 0):
        described[BEGINS_KEY] = begins
    with LogWriter(path, run.scene, described, run_record, Safety(max_loss)) as log:
        stream = MessageStream(run.scene, choice=run.choice)
        try:
            for block in run.blocks():
                samples += len(block)
                log.write_messages(stream.messages(block))
        finally:
            if not log.problem:
                log.write_messages(stream.flush())
                if samples:
                    log.note_report(run.report.record())
                    if state := getattr(run, "state", None):
                        log.note_state(*state)
    return LogSummary(Path(path), log.messages, samples, log.bytes)


@functools.cache
def _versions() -> dict[str, str]:
    packages = {f"{package}_version": version(package) for package in ("numpy", "scipy")}
    return {"bearing_twin_version": bearing_twin.__version__, "python_version": platform.python_version(), **packages}
