"""THE topic table: every topic of a bearing, its type, rate, quality of service, and how a sample becomes its message.

Nodes and logs both take their bytes from `MessageStream`, so what is on the wire is what is in the log.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, partial
from typing import NamedTuple

import numpy as np

from bearing_twin.kinds.bearing.markers import marker_array
from bearing_twin.kinds.bearing.outputs import FRAME, contact_details, wrenches
from bearing_twin.log import cdr
from bearing_twin.log.bag import Qos
from bearing_twin.run.fidelity import choose
from bearing_twin.sample import Block, Channel, Sample

NAMESPACE = "/bearing"
SLOW_RATE = 20.0  # Hz, of sample blocks and markers
LARGEST_BLOCK = 4 << 20  # bytes of values in one SampleBlock
RELIABLE = Qos(depth=10)
PUBLISH, SAMPLES, MARKERS = "publish", "samples", "markers"

_TIME = cdr.message_class("builtin_interfaces/msg/Time")
_HEADER = cdr.message_class("std_msgs/msg/Header")
_VECTOR = cdr.message_class("geometry_msgs/msg/Vector3")
_WRENCH = cdr.message_class("geometry_msgs/msg/Wrench")
_WRENCH_STAMPED = cdr.message_class(cdr.WRENCH)
_CONTACTS = cdr.message_class(cdr.CONTACTS)
_STATE = cdr.message_class(cdr.STATE)
_JOINT_STATE = cdr.message_class(cdr.JOINT_STATE)
_SAMPLE_BLOCK = cdr.message_class(cdr.SAMPLE_BLOCK)
_CONTACT_CHANNELS = (
    "approach", "normal_load", "contact_angle", "spin_rate", "point", "normal", "friction_force", "slip",
)  # fmt: skip
_CONTACT_DETAILS = ("in_contact", "semi_major", "semi_minor", "peak_pressure", "major_axis")


class Topic(NamedTuple):
    """One topic: name relative to NAMESPACE, type, rate class, quality of service, builder of an Output, meaning."""

    name: str
    ros_type: str
    rate: str
    qos: Qos
    build: Callable | None
    meaning: str

    @property
    def full_name(self) -> str:
        """The name with the namespace, as it stands in a log."""
        return f"{NAMESPACE}/{self.name}"


@dataclass(frozen=True, eq=False)
class Output:
    """One solver output on its way out; `stamp_ns` is the time in its messages; details are computed once, if used."""

    parameters: object
    law: str
    sample: Sample
    stamp_ns: int
    frame: str = field(default=FRAME)

    @cached_property
    def header(self):
        """std_msgs/Header of every message of this output."""
        return header(self.stamp_ns, self.frame)

    @cached_property
    def wrenches(self):
        """The wrenches in the order of the table's first rows."""
        return wrenches(self.parameters, self.sample)

    @cached_property
    def details(self):
        """Contact ellipses, see `contact_details`."""
        return contact_details(self.parameters, self.sample)


def topics(scene) -> tuple[Topic, ...]:
    """The topic table of a scene, in the order in which one instant's messages are given out; an impact has samples."""
    samples = Topic("samples", cdr.SAMPLE_BLOCK, SAMPLES, RELIABLE, None, "every solver output, without loss")
    if scene.kind != "bearing":
        return (samples,)
    balls = scene.parameters.geometry.balls
    on_balls = (
        Topic(
            f"ball_{k}/wrench", cdr.WRENCH, PUBLISH, RELIABLE, partial(wrench_message, k),
            f"on ball {k}, by both raceways, about its centre",
        )
        for k in range(balls)
    )  # fmt: skip
    return (
        *on_balls,
        Topic(
            "inner_ring/wrench", cdr.WRENCH, PUBLISH, RELIABLE, partial(wrench_message, balls),
            "on the inner ring, by the balls, about its centre",
        ),
        Topic(
            "outer_ring/wrench", cdr.WRENCH, PUBLISH, RELIABLE, partial(wrench_message, balls + 1),
            "on the outer ring, by the balls, about its centre",
        ),
        Topic("contacts", cdr.CONTACTS, PUBLISH, RELIABLE, contacts_message, "all ball-raceway contacts as arrays"),
        Topic("state", cdr.STATE, PUBLISH, RELIABLE, state_message, "motion of balls and rings, energies"),
        Topic("joint_states", cdr.JOINT_STATE, PUBLISH, RELIABLE, joint_message, "angles of inner ring and orbits"),
        Topic("markers", cdr.MARKERS, MARKERS, RELIABLE, marker_array, "balls, rings, ellipses, loads to look at"),
        samples,
    )  # fmt: skip


def header(stamp_ns: int, frame: str = FRAME):
    """std_msgs/Header with a stamp given in integer nanoseconds."""
    seconds, nanoseconds = divmod(stamp_ns, 1_000_000_000)
    return _HEADER(_TIME(seconds, nanoseconds), frame)


def wrench_message(row: int, output: Output):
    """geometry_msgs/WrenchStamped of row `row` of the output's wrenches."""
    wrench = output.wrenches[row]
    return _WRENCH_STAMPED(output.header, _WRENCH(_VECTOR(*wrench.force.tolist()), _VECTOR(*wrench.torque.tolist())))


def contacts_message(output: Output):
    """bearing_twin_msgs/Contacts."""
    fields = {name: _flat(output.sample[name]) for name in _CONTACT_CHANNELS}
    fields |= {name: _flat(output.details[name]) for name in _CONTACT_DETAILS}
    return _CONTACTS(
        header=output.header,
        sequence=output.sample.sequence,
        law=output.law,
        balls=output.parameters.geometry.balls,
        **fields,
    )


def state_message(output: Output):
    """bearing_twin_msgs/BearingState."""
    sample = output.sample
    arrays = ("orbit_angle", "position", "velocity", "orientation", "angular_velocity", "roll_rate")
    numbers = (
        "inner_ring_angle", "inner_ring_speed", "kinetic_energy", "elastic_energy", "potential_energy", "drive_work",
        "dissipated",
    )  # fmt: skip
    return _STATE(
        header=output.header,
        sequence=sample.sequence,
        balls=output.parameters.geometry.balls,
        cage_speed=float(orbit_rates(sample).mean()),
        inner_ring_offset=_VECTOR(*sample["inner_ring_offset"].tolist()),
        drive_torque=-float(sample["inner_ring_torque"][2]),
        **{name: _flat(sample[name]) for name in arrays},
        **{name: float(sample[name]) for name in numbers},
    )


def joint_message(output: Output):
    """sensor_msgs/JointState: angle [rad] and speed [rad/s] of the inner ring and of each ball's orbit."""
    sample = output.sample
    names = ["inner_ring_joint", *(f"ball_{k}_orbit_joint" for k in range(output.parameters.geometry.balls))]
    position = np.concatenate([[float(sample["inner_ring_angle"])], sample["orbit_angle"]])
    velocity = np.concatenate([[float(sample["inner_ring_speed"])], orbit_rates(sample)])
    return _JOINT_STATE(output.header, names, position, velocity, np.zeros(0))


def orbit_rates(sample: Sample) -> np.ndarray:
    """Angular velocity [rad/s] of each ball's centre about the bearing's axis."""
    position, velocity = sample["position"], sample["velocity"]
    moment = position[:, 0] * velocity[:, 1] - position[:, 1] * velocity[:, 0]
    return moment / (position[:, 0] ** 2 + position[:, 1] ** 2)


def samples_message(
    channels: tuple[Channel, ...], first_sequence: int, time_ns: np.ndarray, values: np.ndarray, start_time_ns: int = 0
):
    """bearing_twin_msgs/SampleBlock of outputs at `time_ns` (count,) with `values` (count, total width)."""
    names, units, widths = _columns(channels)
    return _SAMPLE_BLOCK(
        header=header(start_time_ns + int(time_ns[0])),
        first_sequence=first_sequence,
        count=len(time_ns),
        channel_name=names,
        channel_unit=units,
        channel_width=widths,
        time_ns=np.ascontiguousarray(time_ns, dtype=np.int64),
        values=np.ascontiguousarray(values, dtype=np.float64).reshape(-1),
    )


class MessageStream:
    """Turns blocks of solver outputs into messages, the same ones however the blocks are cut.

    An output whose sequence number is a multiple of round(output_rate / publish_rate) gives the "publish" topics, one
    at a multiple of round(output_rate / 20) the markers. A SampleBlock ends after round(output_rate / 20) outputs
    (fewer where that would exceed 4 MiB), counted from sequence 0. `start_time_ns` is added to the simulation time in
    all stamps; `law` is the elastic law named in `contacts` (None: the one the scene gets).
    """

    def __init__(self, scene, start_time_ns: int = 0, law: str | None = None):
        run = scene.parameters.run
        self.topics = topics(scene)
        self.start_time_ns = start_time_ns
        self.publish_every = max(1, round(run.output_rate / run.publish_rate))
        self.markers_every = max(1, round(run.output_rate / SLOW_RATE))
        channels = scene.channels
        row_bytes = 8 * sum(channel.width for channel in channels)
        self.block_outputs = max(1, min(self.markers_every, LARGEST_BLOCK // row_bytes))
        self._scene = scene
        self._law = law or choose(scene).law
        self._channels = channels
        self._samples_topic = next(topic for topic in self.topics if topic.rate == SAMPLES)
        self._times: list[np.ndarray] = []
        self._values: list[np.ndarray] = []
        self._first = self._next = 0

    def messages(self, block: Block) -> Iterator[tuple[Topic, int, bytes]]:
        """(topic, stamp [ns], CDR) of every message due in `block`, in order of time.

        A block that does not follow the one before (after a reset) first closes the SampleBlock in progress.
        """
        if block.first_sequence != self._next:
            yield from self.flush()
            self._first = block.first_sequence
        self._next = block.first_sequence + len(block)
        values = block.matrix()
        done = 0
        for row in self._rows_due(block.first_sequence, len(block)):
            yield from self._instant(block, row)
            if (block.first_sequence + row + 1) % self.block_outputs == 0:
                self._collect(block.time_ns[done : row + 1], values[done : row + 1])
                done = row + 1
                yield from self.flush()
        self._collect(block.time_ns[done:], values[done:])

    def flush(self) -> Iterator[tuple[Topic, int, bytes]]:
        """The SampleBlock of the outputs collected so far, if any: call it when the run ends."""
        count = sum(len(times) for times in self._times)
        if not count:
            return
        times, values = np.concatenate(self._times), np.concatenate(self._values)
        message = samples_message(self._channels, self._first, times, values, self.start_time_ns)
        self._first += count
        self._times, self._values = [], []
        cdr_bytes = cdr.serialise(cdr.SAMPLE_BLOCK, message)
        yield self._samples_topic, self.start_time_ns + int(times[-1]), cdr_bytes

    def _collect(self, times: np.ndarray, values: np.ndarray) -> None:
        if len(times):
            self._times.append(np.array(times))
            self._values.append(values)

    def _rows_due(self, first: int, count: int) -> list[int]:
        due = set(range(-first % self.publish_every, count, self.publish_every))
        due.update(range(-first % self.markers_every, count, self.markers_every))
        due.update(range((-first - 1) % self.block_outputs, count, self.block_outputs))
        return sorted(due)

    def _instant(self, block: Block, row: int) -> Iterator[tuple[Topic, int, bytes]]:
        sequence = block.first_sequence + row
        due = {PUBLISH: sequence % self.publish_every == 0, MARKERS: sequence % self.markers_every == 0, SAMPLES: False}
        if not any(due.values()):
            return
        stamp_ns = self.start_time_ns + int(block.time_ns[row])
        output = Output(self._scene.parameters, self._law, block[row], stamp_ns)
        for topic in self.topics:
            if due[topic.rate]:
                yield topic, stamp_ns, cdr.serialise(topic.ros_type, topic.build(output))


@lru_cache(maxsize=8)
def _columns(channels: tuple[Channel, ...]) -> tuple[list[str], list[str], np.ndarray]:
    widths = np.array([channel.width for channel in channels], dtype=np.uint32)
    return [channel.name for channel in channels], [channel.unit for channel in channels], widths


def _flat(array: np.ndarray) -> np.ndarray:
    return array.reshape(-1)
