"""Solver outputs as messages: every topic of a scene, its type, quality of service, and the bytes due at each output.

A kind lists its own topics; those of every scene (samples, records, the scene itself) and the table of topics, of one
scene or of every kind, are here. Nodes and logs take their bytes from `MessageStream`, so that messages are the same on
the wire and in the log. SampleBlocks and Waveforms are written, and read back with checks: a log or a peer may contain
anything.
"""

import functools
import json
import math
import re
import struct
from collections.abc import Container, Iterator
from typing import NamedTuple

import numpy as np

from bearing_twin import __version__
from bearing_twin.base.errors import LogError
from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block, Channel, Sample, Table, join_blocks
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.bearing.outputs import update_contact_angles
from bearing_twin.kinds.contract import MARKERS, ONCE, PUBLISH, SAMPLES, SECOND, Output, Topic
from bearing_twin.kinds.rules import OUTSIDE
from bearing_twin.kinds.topics import outside_topic
from bearing_twin.log import cdr
from bearing_twin.log.bag import DEEPEST, Qos
from bearing_twin.log.cdr import Encoder, encode
from bearing_twin.run.scene import Scene, choose, load_scene, parse_scene, scene_names

SLOW_RATE = 20.0  # Hz, of sample blocks and markers
WAVEFORM_RATE = 10.0  # Hz, of the messages of an evenly sampled signal, and then of sample blocks
LARGEST_BLOCK = 4 << 20  # bytes of values in one SampleBlock
KEPT_SECONDS = 4.0  # of messages, that a publisher keeps for a subscriber who is late
RELIABLE = Qos(depth=math.ceil(KEPT_SECONDS * SLOW_RATE))
LATCHED = Qos(depth=1, durability="transient_local")


def topics(scene) -> tuple[Topic, ...]:
    """The topic table of a scene, in the order of the messages of one instant."""
    kind = KINDS[scene.kind]
    rows = [
        Topic("scene", cdr.STRING, ONCE, None, "the resolved scene, the chosen model and versions, as JSON"),
        *((outside_topic(scene.outside),) if scene.marked else ()),
        *kind.topics(scene.parameters),
        *(
            Topic(f"records/{table.name}", ros_type, SAMPLES, None, table.meaning, kind.frame)
            for table in scene.tables
            for ros_type in (cdr.WAVEFORM if table.rate else cdr.SAMPLE_BLOCK,)
        ),
        Topic("samples", cdr.SAMPLE_BLOCK, SAMPLES, None, "every solver output, without loss", kind.frame),
    ]
    rate = 0.0 if kind.brief else scene.parameters.run.publish_rate  # a brief run is played slowly
    depth = min(max(RELIABLE.depth, math.ceil(KEPT_SECONDS * rate)), DEEPEST)
    qualities = {ONCE: LATCHED, PUBLISH: RELIABLE._replace(depth=depth)}
    return tuple(
        row._replace(
            full_name=row.name if row.name.startswith("/") else f"{kind.namespace}/{row.name}",
            qos=qualities.get(row.rate, RELIABLE),
        )
        for row in rows
    )


def scene_text(scene, choice: Choice) -> str:
    """Text of the topic `scene`: enough to report on a recording and to simulate it again."""
    return json.dumps({"scene": scene.text, **_choice_data(choice), "bearing_twin_version": __version__})


def choice_record(choice: Choice) -> dict[str, str]:
    """The chosen model as texts for a log's metadata: values that are no text as JSON."""
    return {key: value if isinstance(value, str) else json.dumps(value) for key, value in _choice_data(choice).items()}


def _choice_data(choice: Choice) -> dict[str, str | float | list | dict | None]:
    """The chosen model as plain data, without a setting that equals the scene's."""
    return {
        "law": choice.law,
        "stepper": choice.stepper,
        "reason": choice.reason,
        "warnings": list(choice.warnings),
        **({} if math.isnan(choice.setting) else {"setting": choice.setting}),
        **({"friction": choice.friction} if choice.friction else {}),
    }


class MessageStream:
    """Turns blocks of solver outputs into messages, which do not depend on how the outputs are split into blocks.

    Messages that are sent once come first, that of the scene before all. An output whose number is a multiple of
    output_rate / publish_rate gives the "publish" topics, one at a multiple of round(output_rate / 20) the markers, one
    at a multiple of round(output_rate) those at 1 Hz.
    A SampleBlock ends after round(output_rate / 20) outputs, of a scene with a sensor round(output_rate / 10) (fewer
    where that would exceed 4 MiB), counted from sequence 0; records come before the SampleBlock that holds their
    output, those of an evenly sampled signal as a Waveform. `start_time_ns` is added to the simulation time in all
    stamps; `choice` is the model in use (None: that of the scene); `frame_prefix` precedes the name of every frame.
    """

    def __init__(self, scene, start_time_ns: int = 0, choice: Choice | None = None, frame_prefix: str = ""):
        run = scene.parameters.run
        self.topics = topics(scene)
        self.start_time_ns = start_time_ns
        self._gathered = {topic: topic.fields(scene.parameters) for topic in self.topics if topic.rate == SECOND}
        rates = {PUBLISH: run.publish_rate, MARKERS: SLOW_RATE} | ({SECOND: 1.0} if self._gathered else {})
        self._every = {name: max(1, round(run.output_rate / rate)) for name, rate in rates.items()}  # outputs
        row_bytes = 8 * sum(channel.width for channel in scene.channels)
        self._tables: dict[str, Table] = {table.name: table for table in scene.tables}
        block_rate = WAVEFORM_RATE if any(table.rate for table in self._tables.values()) else SLOW_RATE
        self.block_outputs = max(1, min(round(run.output_rate / block_rate), LARGEST_BLOCK // row_bytes))
        self._scene, self._choice = scene, choice or choose(scene)
        self._frame_prefix = frame_prefix
        self._frame = f"{frame_prefix}{KINDS[scene.kind].frame}"
        self._by_name = {topic.name: topic for topic in self.topics}
        self._encoders = {topic.name: Encoder(topic.ros_type, f"{frame_prefix}{topic.frame}") for topic in self.topics}
        self._pending: list[Block] = []  # outputs of the SampleBlock in progress
        self._recorded = dict.fromkeys(self._tables, 0)
        self._first = self._next = 0
        self._started = False

    def messages(self, block: Block, names: Container[str] | None = None) -> list[tuple[Topic, int, bytes]]:
        """(topic, stamp [ns], CDR) of every message due in `block`, in order of time.

        With `names`, only these topics are encoded; where none is due, one message without bytes marks the time that
        the stream has reached. A block that does not follow the one before (after a reset) first closes the SampleBlock
        in progress.
        """
        messages: list = []
        if not self._started:
            self._started = True
            messages += self._latched_messages(block)
        if block.first_sequence != self._next:
            messages += self._pending_outputs(names)
            self._first = block.first_sequence
            self._gathered = {topic: topic.fields(self._scene.parameters) for topic in self._gathered}
        self._next = block.first_sequence + len(block)
        due, done = self._due_messages(block, names), 0
        for row in self._rows_due(block.first_sequence, len(block)):
            if row in due or names is None:
                messages += due.get(row, ())
            else:
                messages.append((self._by_name["samples"], self.start_time_ns + int(block.time_ns[row]), b""))
            if (block.first_sequence + row + 1) % self.block_outputs == 0:
                self._pending.append(block.part(done, row + 1))
                done = row + 1
                messages += self._pending_outputs(names)
        if done < len(block):
            self._pending.append(block.part(done, len(block)))
        return messages

    def flush(self) -> list[tuple[Topic, int, bytes]]:
        """The records and the SampleBlock of the outputs collected so far, if any: call it when the run ends."""
        return list(self._pending_outputs(None))

    def _latched_messages(self, block: Block) -> Iterator[tuple[Topic, int, bytes]]:
        """The messages that are sent once: the scene, and the kind's own."""
        output, stamp_ns = self._output(block[0]), self.start_time_ns + int(block.time_ns[0])
        scene = {"data": scene_text(self._scene, self._choice)}
        for topic in self.topics:
            if topic.rate == ONCE:
                fields = scene if topic.fields is None else topic.fields(output)
                yield topic, stamp_ns, encode(topic.ros_type, fields, stamp_ns, "")

    def _pending_outputs(self, names: Container[str] | None) -> Iterator[tuple[Topic, int, bytes]]:
        """The records and the SampleBlock of the pending outputs."""
        if not self._pending:
            return
        block, self._pending = join_blocks(self._pending), []
        stamp_ns = self.start_time_ns + int(block.time_ns[-1])
        for name, table in self._tables.items():
            topic, rows = self._by_name[f"records/{name}"], block.records.get(name, ())
            if not len(rows):
                continue
            if names is not None and topic.name not in names:
                pass
            elif table.rate:
                unit = table.columns[1].unit
                for part in (rows[begin : begin + MOST_SAMPLES] for begin in range(0, len(rows), MOST_SAMPLES)):
                    yield topic, stamp_ns, waveform_message(unit, table.rate, part, self._frame, self.start_time_ns)
            else:  # records are numbered from the start of the run
                times_ns = np.rint(1e9 * rows[:, 0]).astype(np.int64)
                yield topic, stamp_ns, self._sample_block(table.columns, self._recorded[name], times_ns, rows)
            self._recorded[name] += len(rows)
        samples = b""
        if names is None or "samples" in names:
            samples = self._sample_block(self._scene.channels, self._first, block.time_ns, block.matrix())
        self._first += len(block)
        yield self._by_name["samples"], stamp_ns, samples

    def _sample_block(self, columns, first: int, times_ns: np.ndarray, values: np.ndarray) -> bytes:
        return samples_message(columns, first, times_ns, values, self._frame, self.start_time_ns)

    def _rows_due(self, first: int, count: int) -> list[int]:
        due = {row for every in self._every.values() for row in range(-first % every, count, every)}
        due.update(range((-first - 1) % self.block_outputs, count, self.block_outputs))
        return sorted(due)

    def _due_messages(self, block: Block, names: Container[str] | None) -> dict[int, list]:
        """The messages due at each row of `block` that has any; topics of one rate are encoded for all rows at once."""
        messages: dict[int, list] = {}
        rows = {rate: range(-block.first_sequence % every, len(block), every) for rate, every in self._every.items()}
        outputs: dict[str, tuple] = {}
        for topic in self.topics:
            if topic.rate == SECOND or not rows.get(topic.rate) or (names is not None and topic.name not in names):
                continue
            if topic.rate not in outputs:
                sample = block.sample_rows(rows[topic.rate])
                outputs[topic.rate] = self._output(sample), self.start_time_ns + sample.time_ns
            output, stamps_ns = outputs[topic.rate]
            data = self._encoders[topic.name].encode(topic.fields(output), stamps_ns)
            for row, stamp_ns, message in zip(rows[topic.rate], stamps_ns.tolist(), data, strict=True):
                messages.setdefault(row, []).append((topic, stamp_ns, message))
        for topic, gathered in self._gathered.items():
            done = 0
            for row in rows[SECOND]:
                gathered.add(block.part(done, row + 1))
                done = row + 1
                if names is None or topic.name in names:
                    stamp_ns = self.start_time_ns + int(block.time_ns[row])
                    message = encode(topic.ros_type, gathered.fields(), stamp_ns, "")
                    messages.setdefault(row, []).append((topic, stamp_ns, message))
            gathered.add(block.part(done, len(block)))
        return messages

    def _output(self, sample: Sample) -> Output:
        law = f"{self._choice.law} ({OUTSIDE})" if self._scene.marked else self._choice.law
        return Output(self._scene.parameters, law, sample, self._frame_prefix)


RATES = {
    PUBLISH: "run.publish_rate",
    MARKERS: f"{SLOW_RATE:g} Hz",
    SAMPLES: f"in blocks, up to {SLOW_RATE:g} a second",
    ONCE: "once, latched",
    SECOND: "1 Hz",
}


class TopicRow(NamedTuple):
    """One row of the table, as texts."""

    topic: str
    type: str
    rate: str
    qos: str
    frame: str
    meaning: str


def scene_rows(scene: Scene) -> list[TopicRow]:
    """The topics of a scene by their full names, with their rates in Hz."""
    rates = RATES | {PUBLISH: f"{scene.parameters.run.publish_rate:g} Hz"}
    return [_row(topic, topic.full_name, rates) for topic in topics(scene)]


def kind_rows(kind: str) -> list[TopicRow]:
    """The topics of a kind by default and those that other shipped scenes of it have.

    Topics that differ only in a number, as of several balls, are one row.
    """
    table: dict[str, TopicRow] = {}
    shipped = [scene for scene in _shipped_scenes() if scene.kind == kind]
    for scene in (Scene(kind, kind, "", KINDS[kind].parameters()), *shipped):
        for topic in topics(scene):
            row = TopicRow(*map(_without_numbers, _row(topic, topic.name, RATES)))
            table.setdefault(row.topic, row)
    return list(table.values())


@functools.cache
def _shipped_scenes() -> list[Scene]:
    return list(map(load_scene, scene_names()))


def _row(topic: Topic, name: str, rates: dict[str, str]) -> TopicRow:
    frame = topic.frame or "-"
    return TopicRow(
        name, topic.ros_type.replace("/msg/", "/"), rates[topic.rate], _qos_text(topic.qos), frame, topic.meaning
    )


def _without_numbers(text: str) -> str:
    return re.sub(r"\bball \d+", "ball k", re.sub(r"\bball_\d+", "ball_<k>", text))


def _qos_text(qos: Qos) -> str:
    return f"{qos.reliability.replace('_', ' ')}, {qos.durability.replace('_', ' ')}, depth {qos.depth}"


MOST_SAMPLES = 1 << 20  # of a Waveform
NUMBERED = (cdr.SAMPLE_BLOCK, cdr.WAVEFORM)  # types of messages whose outputs or records have numbers


def samples_message(
    channels: tuple[Channel, ...],
    first_sequence: int,
    time_ns: np.ndarray,
    values: np.ndarray,
    frame: str = "",
    start_time_ns: int = 0,
) -> bytes:
    """bearing_twin_msgs/SampleBlock of outputs at `time_ns` (count,) with `values` (count, total width)."""
    fields = {
        "first_sequence": first_sequence,
        "count": len(time_ns),
        "channel_name": [channel.name for channel in channels],
        "channel_unit": [channel.unit for channel in channels],
        "channel_width": [channel.width for channel in channels],
        "time_ns": time_ns,
        "values": values,
    }
    return encode(cdr.SAMPLE_BLOCK, fields, start_time_ns + int(time_ns[0]), frame)


def sample_range(data: bytes) -> tuple[int, int]:
    """`first_sequence` and `count` of a SampleBlock in CDR, without decoding the rest; raises LogError."""
    try:
        order = "<" if data[1] & 1 else ">"
        frame_bytes = struct.unpack_from(order + "I", data, 12)[0]
        position = -(-(12 + frame_bytes) // 8) * 8  # counted after the four-byte CDR header
        return struct.unpack_from(order + "QI", data, 4 + position)
    except (struct.error, IndexError) as error:
        raise LogError(
            f"a SampleBlock of {len(data)} bytes cannot be read: update publisher and recorder alike"
        ) from error


def readable_range(ros_type: str, data: bytes) -> tuple[int, int]:
    """First number and count of the outputs or records in a message, decoded and checked; raises LogError."""
    if ros_type == cdr.SAMPLE_BLOCK:
        block = checked_block("what was sent", data)
        return int(block.first_sequence), int(block.count)
    waveform = checked_waveform("what was sent", data)
    return int(waveform.first_sequence), len(waveform.samples)


def waveform_message(unit: str, rate: float, rows: np.ndarray, frame: str, start_time_ns: int = 0) -> bytes:
    """bearing_twin_msgs/Waveform of the records (n, 2), time [s] and value, of a signal sampled at `rate` [Hz]."""
    first = int(np.rint(rate * rows[0, 0]))
    fields = {"first_sequence": first, "rate": rate, "unit": unit, "samples": rows[:, 1].astype(np.float32)}
    return encode(cdr.WAVEFORM, fields, start_time_ns + round(1e9 * first / rate), frame)


def checked_waveform(source, data: bytes):
    """The Waveform in these bytes; raises LogError, naming `source`, where it says no times of its samples."""
    message = cdr.deserialise(cdr.WAVEFORM, data)
    end = message.first_sequence + len(message.samples)
    if not (0.0 < message.rate < math.inf and message.first_sequence < end < 1 << 53):
        raise LogError(f"{source}: the Waveform at sample {message.first_sequence} contradicts itself; record again")
    if (count := len(message.samples)) > MOST_SAMPLES:
        raise LogError(f"{source}: a Waveform of {count} samples is longer than is read, {MOST_SAMPLES} samples")
    return message


def records_of(source, ros_type: str, data: bytes) -> np.ndarray:
    """The records (n, columns) in a message of a topic of records; raises LogError, naming `source`."""
    if ros_type == cdr.SAMPLE_BLOCK:
        block = checked_block(source, data)
        return block.values.reshape(block.count, -1)
    waveform = checked_waveform(source, data)
    numbers = waveform.first_sequence + np.arange(len(waveform.samples))
    return np.stack([numbers / waveform.rate, waveform.samples], axis=1)


def checked_block(source, data: bytes):
    """The SampleBlock in these bytes; raises LogError, naming `source`, where its arrays do not belong together."""
    message = cdr.deserialise(cdr.SAMPLE_BLOCK, data)
    row = int(message.channel_width.sum(dtype=np.int64))
    fits = (
        message.count == len(message.time_ns) > 0
        and len(message.channel_name) == len(message.channel_unit) == len(message.channel_width)
        and len(message.channel_name) == len(set(message.channel_name))
        and np.all(message.channel_width > 0)
        and row > 0
        and len(message.values) == message.count * row
    )
    if not fits:
        raise LogError(f"{source}: the SampleBlock at output {message.first_sequence} contradicts itself; record again")
    return message


def channels_of(scene: Scene | None, message) -> tuple[Channel, ...]:
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


def refuse_misfits(source, scene: Scene | None, channels: tuple[Channel, ...]) -> None:
    """Raises LogError, naming `source`, where a channel has another count of numbers than in the scene of the log."""
    known = {} if scene is None else {channel.name: channel.width for channel in scene.channels}
    for name, _, shape, *_ in channels:
        if (width := known.get(name, math.prod(shape))) != math.prod(shape):
            raise LogError(
                f"{source}: an output has {math.prod(shape)} numbers of {name}, but {width} by the scene beside it; "
                "they are of different runs, so record one of them"
            )


def block_of(channels: tuple[Channel, ...], message) -> Block:
    """The outputs of a SampleBlock of these channels, as they are written today."""
    # Copies: the arrays of a message are read-only.
    matrix = np.array(message.values).reshape(message.count, -1)
    block = Block(channels, int(message.first_sequence), np.array(message.time_ns), matrix)
    update_contact_angles(block)
    return block
