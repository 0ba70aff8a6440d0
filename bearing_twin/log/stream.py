"""Solver outputs as messages: every topic of a scene, its type, quality of service, and the bytes due at each output.

What a kind publishes stands in its `topics`; here stand the topics of every scene: its samples, its records and the
scene itself. Nodes and logs take their bytes from `MessageStream`, so what is on the wire is what is in the log.
"""

import json
from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from bearing_twin import __version__
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import MARKERS, ONCE, PUBLISH, SAMPLES, Output, Topic
from bearing_twin.log import cdr
from bearing_twin.log.bag import Qos
from bearing_twin.log.filling import message
from bearing_twin.report import Choice
from bearing_twin.run.fidelity import choose
from bearing_twin.sample import Block, Channel, Table

SLOW_RATE = 20.0  # Hz, of sample blocks and markers
LARGEST_BLOCK = 4 << 20  # bytes of values in one SampleBlock
RELIABLE = Qos(depth=10)
LATCHED = Qos(depth=1, durability="transient_local")


class Channelled(NamedTuple):
    """A topic of a scene as nodes and logs need it: its full name and quality of service beside its row."""

    row: Topic
    full_name: str
    qos: Qos

    @property
    def name(self) -> str:
        """The name relative to the scene's namespace."""
        return self.row.name

    @property
    def rate(self) -> str:
        """How often it is given out."""
        return self.row.rate

    @property
    def ros_type(self) -> str:
        """The type, as `package/msg/Name`."""
        return self.row.ros_type


def topics(scene) -> tuple[Channelled, ...]:
    """The topic table of a scene, in the order in which one instant's messages are given out."""
    kind = KINDS[scene.kind]
    rows = [
        Topic("scene", cdr.STRING, ONCE, None, "the resolved scene, the chosen model and versions, as JSON"),
        *kind.topics(scene.parameters),
        *(
            Topic(f"records/{table.name}", cdr.SAMPLE_BLOCK, SAMPLES, None, table.meaning, kind.frame)
            for table in kind.records(scene.parameters)
        ),
        Topic("samples", cdr.SAMPLE_BLOCK, SAMPLES, None, "every solver output, without loss", kind.frame),
    ]
    return tuple(
        Channelled(
            row,
            row.name if row.name.startswith("/") else f"{kind.namespace}/{row.name}",
            LATCHED if row.rate == ONCE else RELIABLE,
        )
        for row in rows
    )


def scene_text(scene, choice: Choice) -> str:
    """What the topic `scene` says: enough to report on a recording and to simulate it again."""
    chosen = {"law": choice.law, "stepper": choice.stepper, "reason": choice.reason, "warnings": list(choice.warnings)}
    text = scene.text
    return json.dumps({"scene": text, **chosen, "bearing_twin_version": __version__})


def samples_message(
    channels: tuple[Channel, ...],
    first_sequence: int,
    time_ns: np.ndarray,
    values: np.ndarray,
    start_time_ns: int = 0,
    frame: str = "",
):
    """bearing_twin_msgs/SampleBlock of outputs at `time_ns` (count,) with `values` (count, total width)."""
    names, units, widths = _columns(channels)
    fields = {
        "first_sequence": first_sequence,
        "count": len(time_ns),
        "channel_name": names,
        "channel_unit": units,
        "channel_width": widths,
        "time_ns": time_ns,
        "values": values,
    }
    return message(cdr.SAMPLE_BLOCK, fields, start_time_ns + int(time_ns[0]), frame)


class MessageStream:
    """Turns blocks of solver outputs into messages, the same ones however the blocks are cut.

    The scene comes first. An output whose sequence number is a multiple of output_rate / publish_rate gives the
    "publish" topics, one at a multiple of round(output_rate / 20) the markers. A SampleBlock ends after
    round(output_rate / 20) outputs (fewer where that would exceed 4 MiB), counted from sequence 0; records come before
    the SampleBlock that holds their output. `start_time_ns` is added to the simulation time in all stamps; `choice`
    is the model in use (None: the one the scene gets); `frame_prefix` stands before the name of every frame.
    """

    def __init__(self, scene, start_time_ns: int = 0, choice: Choice | None = None, frame_prefix: str = ""):
        run = scene.parameters.run
        self.topics = topics(scene)
        self.start_time_ns = start_time_ns
        self.publish_every = max(1, round(run.output_rate / run.publish_rate))
        self.markers_every = max(1, round(run.output_rate / SLOW_RATE))
        channels = scene.channels
        row_bytes = 8 * sum(channel.width for channel in channels)
        self.block_outputs = max(1, min(self.markers_every, LARGEST_BLOCK // row_bytes))
        self._scene, self._choice = scene, choice or choose(scene)
        self._frame_prefix = frame_prefix
        self._frame = f"{frame_prefix}{KINDS[scene.kind].frame}"
        self._channels = channels
        self._by_name = {topic.name: topic for topic in self.topics}
        self._tables: dict[str, Table] = {table.name: table for table in KINDS[scene.kind].records(scene.parameters)}
        self._times: list[np.ndarray] = []
        self._values: list[np.ndarray] = []
        self._rows: dict[str, list[np.ndarray]] = {name: [] for name in self._tables}
        self._recorded = dict.fromkeys(self._tables, 0)
        self._first = self._next = 0
        self._begun = False

    def messages(self, block: Block) -> Iterator[tuple[Channelled, int, bytes]]:
        """(topic, stamp [ns], CDR) of every message due in `block`, in order of time.

        A block that does not follow the one before (after a reset) first closes the SampleBlock in progress.
        """
        if not self._begun:
            self._begun = True
            yield self.scene_message(int(block.time_ns[0]))
        if block.first_sequence != self._next:
            yield from self.flush()
            self._first = block.first_sequence
        self._next = block.first_sequence + len(block)
        values = block.matrix()
        done = 0
        for row in self._rows_due(block.first_sequence, len(block)):
            yield from self._instant(block, row)
            if (block.first_sequence + row + 1) % self.block_outputs == 0:
                self._collect(block.part(done, row + 1), values[done : row + 1])
                done = row + 1
                yield from self.flush()
        if done < len(block):
            self._collect(block.part(done, len(block)), values[done:])

    def scene_message(self, time_ns: int = 0) -> tuple[Channelled, int, bytes]:
        """The message of the topic `scene`."""
        stamp_ns = self.start_time_ns + time_ns
        text = message(cdr.STRING, {"data": scene_text(self._scene, self._choice)}, stamp_ns, "")
        return self._by_name["scene"], stamp_ns, cdr.serialise(cdr.STRING, text)

    def flush(self) -> Iterator[tuple[Channelled, int, bytes]]:
        """The records and the SampleBlock of the outputs collected so far, if any: call it when the run ends."""
        count = sum(len(times) for times in self._times)
        if not count:
            return
        times, values = np.concatenate(self._times), np.concatenate(self._values)
        block = samples_message(self._channels, self._first, times, values, self.start_time_ns, self._frame)
        self._first += count
        self._times, self._values = [], []
        stamp_ns = self.start_time_ns + int(times[-1])
        for name, parts in self._rows.items():
            if parts:
                yield self._by_name[f"records/{name}"], stamp_ns, self._records(name, np.concatenate(parts))
        self._rows = {name: [] for name in self._tables}
        yield self._by_name["samples"], stamp_ns, cdr.serialise(cdr.SAMPLE_BLOCK, block)

    def _records(self, name: str, rows: np.ndarray) -> bytes:
        """A SampleBlock of records, which are counted from the start."""
        time_ns = np.rint(1e9 * rows[:, 0]).astype(np.int64)
        first, self._recorded[name] = self._recorded[name], self._recorded[name] + len(rows)
        columns = self._tables[name].columns
        found = samples_message(columns, first, time_ns, rows, self.start_time_ns, self._frame)
        return cdr.serialise(cdr.SAMPLE_BLOCK, found)

    def _collect(self, block: Block, values: np.ndarray) -> None:
        self._times.append(np.array(block.time_ns))
        self._values.append(values)
        for name, rows in block.records.items():
            if len(rows):
                self._rows[name].append(rows)

    def _rows_due(self, first: int, count: int) -> list[int]:
        due = set(range(-first % self.publish_every, count, self.publish_every))
        due.update(range(-first % self.markers_every, count, self.markers_every))
        due.update(range((-first - 1) % self.block_outputs, count, self.block_outputs))
        return sorted(due)

    def _instant(self, block: Block, row: int) -> Iterator[tuple[Channelled, int, bytes]]:
        sequence = block.first_sequence + row
        due = {PUBLISH: sequence % self.publish_every == 0, MARKERS: sequence % self.markers_every == 0}
        if not any(due.values()):
            return
        stamp_ns = self.start_time_ns + int(block.time_ns[row])
        output = Output(self._scene.parameters, self._choice.law, block[row], self._frame_prefix)
        for topic in self.topics:
            if due.get(topic.rate):
                found = message(topic.ros_type, topic.row.fields(output), stamp_ns, output.frame(topic.row.frame))
                yield topic, stamp_ns, cdr.serialise(topic.ros_type, found)


@lru_cache(maxsize=8)
def _columns(channels: tuple[Channel, ...]) -> tuple[list[str], list[str], np.ndarray]:
    widths = np.array([channel.width for channel in channels], dtype=np.uint32)
    return [channel.name for channel in channels], [channel.unit for channel in channels], widths
