"""Solver outputs as messages: every topic of a scene, its type, quality of service, and the bytes due at each output.

What a kind publishes stands in its `topics`; here stand the topics of every scene: its samples, its records and the
scene itself. Nodes and logs take their bytes from `MessageStream`, so what is on the wire is what is in the log.
"""

import json
import math
from collections.abc import Container, Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np

from bearing_twin import __version__
from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block, Columns, Sample, Table
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import MARKERS, ONCE, PUBLISH, SAMPLES, Output, Topic
from bearing_twin.kinds.ranges import OUTSIDE
from bearing_twin.kinds.topics import outside_topic
from bearing_twin.log import cdr
from bearing_twin.log.bag import DEEPEST, Qos
from bearing_twin.log.encoding import Encoder, encoded, stamps_of
from bearing_twin.log.mcap_write import HEAD, Bundle, alone, heads_of
from bearing_twin.log.sample_block import samples_pieces
from bearing_twin.run.scene import choose
from bearing_twin.run.second_run import tables_of


class Consecutive:
    """Consecutive blocks of the same channels seen as one, whose numbers are not copied."""

    def __init__(self, blocks: list[Block]):
        self._blocks = blocks
        self._starts = np.cumsum([0, *map(len, blocks)])
        self.first_sequence = blocks[0].first_sequence
        self.time_ns = np.concatenate([block.time_ns for block in blocks])

    def __len__(self) -> int:
        return len(self.time_ns)

    def __getitem__(self, row: int) -> Sample:
        place = int(np.searchsorted(self._starts, row, side="right")) - 1
        return self._blocks[place][row - int(self._starts[place])]

    def sampled(self, rows: range) -> Sample:
        """These rows as one sample, see `Block.sampled`."""
        picked, found = np.arange(rows.start, rows.stop, rows.step), []
        edges = np.searchsorted(picked, self._starts).tolist()
        for block, start, low, high in zip(self._blocks, self._starts, edges, edges[1:], strict=False):
            found.append(block.matrix()[picked[low:high] - start])
        values = Columns(self._blocks[0].values.layout, np.concatenate(found))
        return Sample((self.first_sequence + picked).astype(np.uint64), self.time_ns[picked], values)

    def parts(self, low: int, high: int) -> Iterator[Block]:
        """Rows `low` to `high` - 1 as parts of the blocks they lie in."""
        for block, start in zip(self._blocks, self._starts.tolist(), strict=False):
            first, last = max(0, low - start), min(len(block), high - start)
            if first < last:
                yield block.part(first, last)


class Bundler:
    """Gives messages a form in which a log takes them: bundles. `numbers` are the channels of topics by name."""

    def __init__(self, numbers: Mapping[str, int]):
        self._numbers = numbers

    def one(self, topic, stamp_ns: int, pieces: Sequence[Any]) -> Bundle:
        """One message."""
        return alone(self._numbers[topic.name], stamp_ns, pieces)

    def many(self, ready: Sequence[tuple[Any, Encoder, Any]], stamps_ns: np.ndarray, stamps: np.ndarray) -> list[list]:
        """Of (topic, its encoder, fields) each, the bundles of each instant, in order."""
        found: list[list] = [[] for _ in stamps_ns]
        alike: list[tuple[int, np.ndarray]] = []
        for topic, encoder, fields in ready:
            made = None if isinstance(fields, list) else encoder.together(fields, stamps_ns, stamps)
            if isinstance(made, np.ndarray):
                alike.append((self._numbers[topic.name], made))
                continue
            self._give(alike, stamps_ns, found)
            each = [[one] for one in encoder.encoded(fields, stamps_ns, stamps)] if made is None else made
            for bundles, stamp_ns, pieces in zip(found, stamps_ns.tolist(), each, strict=True):
                bundles.append(self.one(topic, stamp_ns, pieces))
        self._give(alike, stamps_ns, found)
        return found

    @staticmethod
    def _give(alike: list[tuple[int, np.ndarray]], stamps_ns: np.ndarray, found: list[list]) -> None:
        """Puts messages that are of one size at every instant side by side, a bundle an instant; empties `alike`."""
        if not alike:
            return
        size = sum(HEAD.itemsize + made.shape[1] for _, made in alike)
        rows, places, begin = np.empty((len(stamps_ns), size), np.uint8), [], 0
        for channel, made in alike:
            middle, end = begin + HEAD.itemsize, begin + HEAD.itemsize + made.shape[1]
            rows[:, begin:middle] = heads_of(channel, stamps_ns, made.shape[1]).view((np.uint8, HEAD.itemsize))
            rows[:, middle:end] = made
            places.append((channel, begin))
            begin = end
        whole, places = rows.reshape(-1).data, tuple(places)
        for row, (bundles, stamp_ns) in enumerate(zip(found, stamps_ns.tolist(), strict=True)):
            bundles.append(Bundle(stamp_ns, places, (whole[row * size : (row + 1) * size],), size))
        alike.clear()


class Separate:
    """Gives messages the form in which nodes take them: (topic, stamp [ns], CDR) each."""

    def one(self, topic, stamp_ns: int, pieces: Sequence[Any]) -> tuple[Any, int, bytes]:
        """One message."""
        return topic, stamp_ns, b"".join(pieces)

    def many(self, ready: Sequence[tuple[Any, Encoder, Any]], stamps_ns: np.ndarray, stamps: np.ndarray) -> list[list]:
        """Of (topic, its encoder, fields) each, the messages of each instant, in order."""
        columns = [encoder.encoded(fields, stamps_ns, stamps) for _, encoder, fields in ready]
        topics = [topic for topic, _, _ in ready]
        return [
            [(topic, stamp_ns, data) for topic, data in zip(topics, row, strict=True)]
            for stamp_ns, row in zip(stamps_ns.tolist(), zip(*columns, strict=True), strict=True)
        ]


SLOW_RATE = 20.0  # Hz, of sample blocks and markers
LARGEST_BLOCK = 4 << 20  # bytes of values in one SampleBlock
KEPT_SECONDS = 4.0  # of messages, that a publisher keeps for a subscriber who is late
RELIABLE = Qos(depth=math.ceil(KEPT_SECONDS * SLOW_RATE))
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
        *((outside_topic(scene.outside),) if scene.marked else ()),
        *kind.topics(scene.parameters),
        *(
            Topic(f"records/{table.name}", cdr.SAMPLE_BLOCK, SAMPLES, None, table.meaning, kind.frame)
            for table in tables_of(kind, scene.parameters)
        ),
        Topic("samples", cdr.SAMPLE_BLOCK, SAMPLES, None, "every solver output, without loss", kind.frame),
    ]
    rate = 0.0 if kind.brief else scene.parameters.run.publish_rate  # what is brief is played slowly
    depth = min(max(RELIABLE.depth, math.ceil(KEPT_SECONDS * rate)), DEEPEST)
    kept = {ONCE: LATCHED, PUBLISH: RELIABLE._replace(depth=depth)}
    return tuple(
        Channelled(
            row,
            row.name if row.name.startswith("/") else f"{kind.namespace}/{row.name}",
            kept.get(row.rate, RELIABLE),
        )
        for row in rows
    )


def scene_text(scene, choice: Choice) -> str:
    """What the topic `scene` says: enough to report on a recording and to simulate it again."""
    return json.dumps({"scene": scene.text, **_chosen(choice), "bearing_twin_version": __version__})


def choice_record(choice: Choice) -> dict[str, str]:
    """The chosen model as texts for a log's metadata: what is no text, as JSON."""
    return {key: one if isinstance(one, str) else json.dumps(one) for key, one in _chosen(choice).items()}


def _chosen(choice: Choice) -> dict[str, str | float | list | dict | None]:
    """The chosen model as plain data; a setting that is that of the scene is left out."""
    return {
        "law": choice.law,
        "stepper": choice.stepper,
        "reason": choice.reason,
        "warnings": list(choice.warnings),
        **({} if math.isnan(choice.setting) else {"setting": choice.setting}),
        **({"friction": choice.friction} if choice.friction else {}),
    }


class MessageStream:
    """Turns blocks of solver outputs into messages, the same ones however the blocks are cut.

    What is said once comes first, the scene before all. An output whose sequence number is a multiple of
    output_rate / publish_rate gives the "publish" topics, one at a multiple of round(output_rate / 20) the markers.
    A SampleBlock ends after round(output_rate / 20) outputs (fewer where that would exceed 4 MiB), counted from
    sequence 0; records come before the SampleBlock that holds their output. `start_time_ns` is added to the
    simulation time in all stamps; `choice` is the model in use (None: the one the scene gets); `frame_prefix` stands
    before the name of every frame.
    """

    def __init__(self, scene, start_time_ns: int = 0, choice: Choice | None = None, frame_prefix: str = ""):
        run = scene.parameters.run
        self.topics = topics(scene)
        self.start_time_ns = start_time_ns
        self.publish_every = max(1, round(run.output_rate / run.publish_rate))
        self.markers_every = max(1, round(run.output_rate / SLOW_RATE))
        self._every = {PUBLISH: self.publish_every, MARKERS: self.markers_every}
        channels = scene.channels
        row_bytes = 8 * sum(channel.width for channel in channels)
        self.block_outputs = max(1, min(self.markers_every, LARGEST_BLOCK // row_bytes))
        self._scene, self._choice = scene, choice or choose(scene)
        self._frame_prefix = frame_prefix
        self._frame = f"{frame_prefix}{KINDS[scene.kind].frame}"
        self._channels = channels
        self._by_name = {topic.name: topic for topic in self.topics}
        self._encoders = {
            topic.name: Encoder(topic.ros_type, f"{frame_prefix}{topic.row.frame}") for topic in self.topics
        }
        self._tables: dict[str, Table] = {table.name: table for table in tables_of(KINDS[scene.kind], scene.parameters)}
        self._times: list[np.ndarray] = []
        self._values: list[np.ndarray] = []
        self._rows: dict[str, list[np.ndarray]] = {name: [] for name in self._tables}
        self._recorded = dict.fromkeys(self._tables, 0)
        self._first = self._next = 0
        self._begun = False

    def messages(self, block: Block, wanted: Container[str] | None = None) -> list[tuple[Channelled, int, bytes]]:
        """(topic, stamp [ns], CDR) of every message due in `block`, in order of time.

        With `wanted`, only the topics of these names are made; where none is due, one message without bytes tells that
        the stream has come so far.
        A block that does not follow the one before (after a reset) first closes the SampleBlock in progress.
        """
        return self._through(Consecutive([block]), wanted, Separate())

    def flush(self) -> list[tuple[Channelled, int, bytes]]:
        """The records and the SampleBlock of the outputs collected so far, if any: call it when the run ends."""
        return list(self._rest(None, Separate()))

    def bundles(self, block: Consecutive | None, numbers: Mapping[str, int]) -> list[Bundle]:
        """All `messages` of outputs, of `flush` for None, as a log takes them; `numbers` are its channels by topic."""
        form = Bundler(numbers)
        return list(self._rest(None, form)) if block is None else self._through(block, None, form)

    def _through(self, block: Consecutive, wanted: Container[str] | None, form: Bundler | Separate) -> list:
        found: list = []
        if not self._begun:
            self._begun = True
            found += [form.one(topic, stamp_ns, (data,)) for topic, stamp_ns, data in self._latched(block)]
        if block.first_sequence != self._next:
            found += self._rest(wanted, form)
            self._first = block.first_sequence
        self._next = block.first_sequence + len(block)
        due, done = self._instants(block, wanted, form), 0
        silent = self._by_name["samples"]
        for row in self._rows_due(block.first_sequence, len(block)):
            if row in due or wanted is None:
                found += due.get(row, ())
            else:
                found.append((silent, self.start_time_ns + int(block.time_ns[row]), b""))
            if (block.first_sequence + row + 1) % self.block_outputs == 0:
                self._collect(block, done, row + 1)
                done = row + 1
                found += self._rest(wanted, form)
        if done < len(block):
            self._collect(block, done, len(block))
        return found

    def scene_message(self, time_ns: int = 0) -> tuple[Channelled, int, bytes]:
        """The message of the topic `scene`."""
        stamp_ns = self.start_time_ns + time_ns
        text = {"data": scene_text(self._scene, self._choice)}
        return self._by_name["scene"], stamp_ns, encoded(cdr.STRING, text, stamp_ns, "")

    def _latched(self, block: Consecutive) -> Iterator[tuple[Channelled, int, bytes]]:
        """What is said once: the scene, and the kind's own."""
        time_ns = int(block.time_ns[0])
        yield self.scene_message(time_ns)
        output = self._output(block[0])
        for topic in self.topics:
            if topic.rate == ONCE and topic.row.fields is not None:
                stamp_ns = self.start_time_ns + time_ns
                yield topic, stamp_ns, encoded(topic.ros_type, topic.row.fields(output), stamp_ns, "")

    def _rest(self, wanted: Container[str] | None, form: Bundler | Separate) -> Iterator:
        count = sum(len(times) for times in self._times)
        if not count:
            return
        times, values = _whole(self._times), _whole(self._values)
        samples: Sequence = (b"",)
        if wanted is None or "samples" in wanted:
            samples = samples_pieces(self._channels, self._first, times, values, self.start_time_ns, self._frame)
        self._first += count
        self._times, self._values = [], []
        stamp_ns = self.start_time_ns + int(times[-1])
        for name, parts in self._rows.items():
            topic = self._by_name[f"records/{name}"]
            if not parts:
                continue
            rows = np.concatenate(parts)
            if wanted is None or topic.name in wanted:
                yield form.one(topic, stamp_ns, self._records(name, rows))
            self._recorded[name] += len(rows)
        self._rows = {name: [] for name in self._tables}
        yield form.one(self._by_name["samples"], stamp_ns, samples)

    def _records(self, name: str, rows: np.ndarray) -> Sequence:
        """The pieces of a SampleBlock of records, which are counted from the start."""
        time_ns = np.rint(1e9 * rows[:, 0]).astype(np.int64)
        columns = self._tables[name].columns
        return samples_pieces(columns, self._recorded[name], time_ns, rows, self.start_time_ns, self._frame)

    def _collect(self, block: Consecutive, low: int, high: int) -> None:
        for part in block.parts(low, high):
            self._times.append(part.time_ns)
            self._values.append(part.matrix())
            for name, rows in part.records.items():
                if len(rows):
                    self._rows[name].append(rows)

    def _rows_due(self, first: int, count: int) -> list[int]:
        due = {row for every in self._every.values() for row in range(-first % every, count, every)}
        due.update(range((-first - 1) % self.block_outputs, count, self.block_outputs))
        return sorted(due)

    def _instants(self, block: Consecutive, wanted: Container[str] | None, form: Bundler | Separate) -> dict[int, list]:
        """Row -> what is due there, of each row of `block` where anything is."""
        rows = {rate: range(-block.first_sequence % every, len(block), every) for rate, every in self._every.items()}
        due = [one for one in self.topics if rows.get(one.rate) and (wanted is None or one.name in wanted)]
        found: dict[int, list] = {}
        several: dict[str, tuple] = {}
        alone: dict[int, Output] = {}  # by row
        for (rate, together), topics in groupby(due, lambda one: (one.rate, one.row.together)):
            if together and rate not in several:
                sample = block.sampled(rows[rate])
                stamps_ns = self.start_time_ns + sample.time_ns
                several[rate] = self._output(sample), stamps_ns, stamps_of(stamps_ns)
            if together:
                output, stamps_ns, stamps = several[rate]
                ready = [(topic, self._encoders[topic.name], topic.row.fields(output)) for topic in topics]
                for row, messages in zip(rows[rate], form.many(ready, stamps_ns, stamps), strict=True):
                    found.setdefault(row, []).extend(messages)
                continue
            topics = list(topics)
            for row in rows[rate]:
                output = alone.get(row)
                if output is None:
                    output = alone[row] = self._output(block[row])
                stamp_ns = self.start_time_ns + output.sample.time_ns
                found.setdefault(row, []).extend(self._at_once(topic, output, stamp_ns, form) for topic in topics)
        return found

    @staticmethod
    def _at_once(topic: Channelled, output: Output, stamp_ns: int, form: Bundler | Separate):
        """The message of a topic at one output."""
        data = encoded(topic.ros_type, topic.row.fields(output), stamp_ns, output.frame(topic.row.frame))
        return form.one(topic, stamp_ns, (data,))

    def _output(self, sample: Sample) -> Output:
        law = f"{self._choice.law} ({OUTSIDE})" if self._scene.marked else self._choice.law
        return Output(self._scene.parameters, law, sample, self._frame_prefix)


def _whole(parts: list[np.ndarray]) -> np.ndarray:
    return parts[0] if len(parts) == 1 else np.concatenate(parts)
