"""recorder_node: logs topics byte for byte as on the wire, and counts lost messages."""

import os
import threading
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from fnmatch import fnmatchcase
from pathlib import Path
from typing import NamedTuple

from rclpy._rclpy_pybind11 import InvalidHandle
from rclpy.callback_groups import CallbackGroup
from rclpy.exceptions import InvalidTopicNameException
from rclpy.qos import QoSCompatibility, qos_check_compatible
from rclpy.subscription import Subscription
from rclpy.validate_full_topic_name import validate_full_topic_name
from rich.filesize import decimal

from bearing_twin.base.errors import BearingTwinError, LogError, peer_name
from bearing_twin.kinds import KINDS
from bearing_twin.log import cdr
from bearing_twin.log.bag import Qos
from bearing_twin.log.mcap_read import LARGEST_MESSAGE, MOST_TOPICS
from bearing_twin.log.raw_log import LOSSES, RECORDING_RECORD, RawLogWriter, Safety
from bearing_twin.log.stream import NUMBERED, readable_range
from bearing_twin.nodes.base_node import (
    LOG_PERIOD,
    BaseNode,
    declare,
    guarded,
)
from bearing_twin.nodes.messages import DIAGNOSTICS_PERIOD, ERROR, WARN, compatible_profile, interface, qos_of
from bearing_twin.nodes.node_parameters import LOG_SAFETY, NodeParameter, safety_of

PARAMETERS = (
    NodeParameter("log", "", "MCAP file (or bag folder, without .mcap) to write; empty = recording_<date>_<time>.mcap"),
    NodeParameter(
        "topics",
        [],
        "topics to log, as full names or patterns with *; empty = its namespace (in none: every kind's), and /tf",
    ),
    *LOG_SAFETY,
)
DISCOVERY_PERIOD = 0.1  # s
TAKE_PERIOD = 0.025  # s between polls, each of which takes as long as several messages
SIM_TIME_PERIOD = 0.005  # s, where messages have the simulation time at which they are taken
OFFERED_DEPTH = 10  # discovery does not know the depth of a publisher
DEPTH = 4000  # messages a subscription may hold back, 1000 a second: other nodes send one that was lost after up to 3 s
FRAMES = ("/tf", "/tf_static")
REMEDY = "give the nodes more processors, or publish and record less (run.publish_rate, topics)"
MIXED = 2  # steps back while there are several publishers: one is a node started again, whose end is not known yet


class Received(NamedTuple):
    """A message as it came; `number` counts those of its publisher from 1 on, None where nobody numbers them."""

    received_ns: int
    sent_ns: int
    number: int | None
    data: bytes


class RecordedTopic:
    """A topic by its `number` in the log, with counts of messages that were not received.

    `before`: messages sent before the first that was received. `lost`: those between, while they can be `counted`: by
    the numbers of one publisher that has not started again. `mixed`: steps back of outputs while `several` published.
    """

    def __init__(self, name: str, number: int, ros_type: str):
        self.name, self.number, self.ros_type = name, number, ros_type
        self.lost = self.before = self.mixed = self._next_output = 0
        self.counted, self.several = True, False
        self._next: int | None = None

    def note_numbers(self, numbers: Iterable[int | None]) -> None:
        """Notes the numbers of received messages, from 1 on; None where the middleware does not number them."""
        for number in numbers:
            if number is None or (self._next is not None and number < self._next):
                self.counted = False
            if not self.counted:
                return
            if self._next is None:
                self.before = number - 1
            else:
                self.lost += number - self._next
            self._next = number + 1

    def note_outputs(self, first: int, count: int) -> None:
        """Notes outputs or records from number `first` on."""
        self.mixed += self.several and first < self._next_output
        self._next_output = first + count


class Recording:
    """A `log` of arriving messages; thread-safe. `prefixes`: folders searched for .msg files of other packages."""

    def __init__(
        self,
        path,
        patterns: Iterable[str],
        prefixes: Iterable[Path] = (),
        safety: Safety = Safety(),  # noqa: B008 - it cannot change
    ):
        self._patterns = tuple(patterns)
        self._folder_definition = cdr.definition_in_folders(prefixes)
        self.log = RawLogWriter(path, safety=safety)
        self._lock = threading.Lock()
        self.topics: dict[str, RecordedTopic] = {}
        self.closed = False
        self._noted = 0, ""  # losses and mixed topics written to the log
        self.messages = self.unreadable = 0

    def wants(self, topic: str) -> bool:
        """True if `topic` matches a pattern and is not recorded yet; hidden topics, as of actions, are not recorded."""
        new = topic not in self.topics and "/_" not in topic
        return new and any(fnmatchcase(topic, pattern) for pattern in self._patterns)

    def add(self, topic: str, ros_type: str, type_hash: str, qos: tuple[Qos, ...]) -> None:
        """Describes a topic in the log; raises LogError for one too many, and for a type without a definition."""
        if len(self.topics) >= MOST_TOPICS:
            raise LogError(f"there are {MOST_TOPICS} topics in the log, and readers accept no more")
        known = cdr.is_known(ros_type) and type_hash in (cdr.type_hash(ros_type), "INVALID")
        described = () if known else (cdr.full_definition(ros_type, self._folder_definition), type_hash)
        with self._lock:
            number = self.log.add_topic(topic, ros_type, *described, qos=qos)
            self.topics[topic] = RecordedTopic(topic, number, ros_type if known else "")

    def publishers(self, topic: str, count: int) -> None:
        """Notes how many publishers a topic has: of several, losses cannot be counted by number, nor is it thinned."""
        recorded = self.topics[topic]
        recorded.several = count > 1
        recorded.counted &= not recorded.several
        self.log.keep_all(recorded.number, recorded.several)

    def receive_all(self, topic: str, received: Sequence[Received]) -> None:
        """Logs messages of one topic as received, and counts those that were lost before them.

        A malformed SampleBlock, or a message larger than LARGEST_MESSAGE, for anybody may send, is counted as
        `unreadable` and not logged: no reader would get past it.
        """
        with self._lock:
            if self.closed:
                return
            recorded = self.topics[topic]
            messages = []
            for message in received:
                if (numbers := _readable_range(message.data, recorded.ros_type)) is not None:
                    recorded.note_outputs(*numbers)
                    messages.append((recorded.number, message.received_ns, message.sent_ns, message.data))
            self.log.write_all(messages)
            self.messages += len(messages)
            self.unreadable += len(received) - len(messages)
            recorded.note_numbers(message.number for message in received)

    def summary(self) -> str:
        """Messages, size and losses in one line."""
        lost = sum(self.status()[f"messages_{loss}"] for loss in ("lost", "dropped", "unreadable"))
        return f"{self.log.path}: {self.messages} messages, {decimal(self.log.bytes)}, {lost} lost"

    def note_losses(self) -> None:
        """Writes the losses so far into the log, so that the counts outlive a crash."""
        status = self.status()
        now = sum(status[key] for key in LOSSES), status["mixed"]
        with self._lock:
            if not self.closed and now != self._noted and not self.log.problem:  # otherwise once there is room
                self._noted = now
                self.log.add_metadata(RECORDING_RECORD, status)

    def status(self) -> dict[str, float | str]:
        """Counts so far: topics, messages, and messages that were lost.

        `lost_on` names the topics with lost messages, `uncounted` those whose lost messages nobody can count, or not
        any more: several publishers, or no numbers; `mixed` those on which outputs of several stand among each other.
        Messages are dropped while the disk is full; those that no reader takes are unreadable.
        """
        with self._lock:
            topics = sorted(self.topics.values(), key=lambda topic: topic.name)
        return {
            "topics": len(topics),
            "messages": self.messages,
            "messages_lost": sum(topic.lost for topic in topics),
            "messages_before": sum(topic.before for topic in topics if topic.counted),
            "messages_dropped": self.log.dropped,
            "messages_unreadable": self.unreadable,
            "lost_on": " ".join(topic.name for topic in topics if topic.lost),
            "uncounted": " ".join(topic.name for topic in topics if not topic.counted),
            "mixed": " ".join(topic.name for topic in topics if topic.mixed >= MIXED),
        }

    def close(self) -> None:
        """Writes the counts into the log and completes it; may be called twice."""
        with self._lock:
            if self.closed:
                return
            self.closed = True
        try:
            self.log.add_metadata(RECORDING_RECORD, self.status())
        finally:
            self.log.close()


def warning_of(status: dict) -> str:
    """The sentence about losses in the `status` of a recording; "" if there are none."""
    if status["mixed"]:
        return f"several nodes publish {status['mixed']}: their outputs are mixed; start each in its own namespace"
    for key, loss in LOSSES.items():
        if status[key]:
            remedy = f"; {REMEDY}" if key == "messages_lost" else ""
            return f"{status[key]} messages {loss}{remedy}"
    return ""


def _readable_range(data: bytes, ros_type: str) -> tuple[int, int] | None:
    """First number and count of outputs or records, None if malformed or too large; (0, 0) for other types."""
    if len(data) > LARGEST_MESSAGE:
        return None
    try:
        return readable_range(ros_type, data) if ros_type in NUMBERED else (0, 0)
    except LogError:
        return None


def default_topics(namespace: str = "/") -> list[str]:
    """Topics of a recorder without the parameter `topics`: all in its own namespace, and the frames.

    A recorder without a namespace logs those of all kinds of scenes.
    """
    namespaces = [namespace] if namespace.strip("/") else [kind.namespace for kind in KINDS.values()]
    return [*(f"{name}/*" for name in namespaces), *FRAMES]


class PolledGroup(CallbackGroup):
    """Subscriptions that no executor serves: `waiting_messages` is cheaper than a wake-up for every message."""

    def can_execute(self, entity) -> bool:
        """Never."""
        return False

    beginning_execution = can_execute

    def ending_execution(self, entity) -> None:
        """Nothing was executed."""


def waiting_messages(subscription: Subscription) -> Iterator[tuple[bytes, dict]]:
    """Every message that waits, as bytes, with its information from the middleware."""
    handle, message = subscription.handle, subscription.msg_type
    with suppress(InvalidHandle), handle:
        while (taken := handle.take_message(message, True)) is not None:
            yield taken


def is_topic(name: str) -> bool:
    """True if ROS accepts the full name of a topic: names found on the network need not be legal."""
    try:
        return validate_full_topic_name(name)
    except InvalidTopicNameException:
        return False


class RecorderNode(BaseNode):
    """Logs every topic that matches, from the moment it has a publisher; raises BearingTwinError where it cannot."""

    def __init__(self, **options):
        super().__init__("recorder_node", "recording", **options)
        values = declare(self, PARAMETERS)
        path = values["log"] or time.strftime("recording_%Y%m%d_%H%M%S.mcap")
        self._topics = values["topics"] or default_topics(self.get_namespace())
        prefixes = map(Path, filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)))
        self.recording = Recording(path, self._topics, prefixes, safety_of(values))
        self.get_logger().info(f"log: {path}")
        self._by_ros_time = self.get_parameter("use_sim_time").value
        self._refused, self._warned = set(), ""
        self._subscribed: dict[str, Subscription] = {}
        self._lock = threading.Lock()
        period = SIM_TIME_PERIOD if self._by_ros_time else TAKE_PERIOD
        self._period = min(period, values["max_loss"])  # waiting messages are lost in a crash too
        self._polled, self._stopping = PolledGroup(), threading.Event()
        self._poller = threading.Thread(target=self._poll_messages, name="take", daemon=True)
        self._poller.start()
        self.every(DISCOVERY_PERIOD, self._on_discovery)
        self.every(DIAGNOSTICS_PERIOD, self._on_diagnostics)

    def close(self) -> None:
        """Completes the log; may be called twice. To have recorded nothing is a failure."""
        self._stopping.set()
        self._poller.join()
        if not self.recording.closed:
            self.recording.close()
            self.get_logger().info(self.recording.summary())
        if not self.recording.messages and self.failure is None:
            sentence = f"nothing was recorded: no message of {', '.join(self._topics)} came; start what publishes it"
            self.failure = LogError(sentence)

    # Subscriptions

    @guarded
    def _on_discovery(self):
        for name, types in self.get_topic_names_and_types():
            is_new = name not in self._refused and is_topic(name) and self.recording.wants(name)
            if is_new and (publishers := self.get_publishers_info_by_topic(name)):
                self._subscribe(name, types, publishers)
        for name, subscription in list(self._subscribed.items()):
            if self.count_publishers(name) > subscription.get_publisher_count():  # one that may not be compatible
                self._subscribe_again(name, subscription)

    def _subscribe(self, name: str, types: list[str], publishers) -> None:
        profiles = [publisher.qos_profile for publisher in publishers]
        offered = tuple(qos_of(profile)._replace(depth=profile.depth or OFFERED_DEPTH) for profile in profiles)
        try:
            if len(types) > 1:
                raise BearingTwinError(f"publishers disagree on its type: {', '.join(map(peer_name, types))}")
            message = interface(types[0], "msg")
            self.recording.add(name, types[0], str(publishers[0].topic_type_hash), offered)
        except BearingTwinError as error:
            self._refused.add(name)
            self.get_logger().error(f"{name} is not logged: {error}", throttle_duration_sec=LOG_PERIOD)
            return
        self._listen(name, message, profiles)

    def _subscribe_again(self, name: str, subscription: Subscription) -> None:
        """Replaces a subscription with which a later publisher is not compatible, as it offers less than the first."""
        profiles = [publisher.qos_profile for publisher in self.get_publishers_info_by_topic(name)]
        if all(
            qos_check_compatible(profile, subscription.qos_profile)[0] != QoSCompatibility.ERROR for profile in profiles
        ):
            return
        with self._lock:
            self._log(name, subscription)
            self.destroy_subscription(subscription)
            self._listen(name, subscription.msg_type, profiles)
        self.get_logger().warning(f"{name}: a later publisher offers a lower quality of service; subscribed again")

    def _listen(self, name: str, message: type, profiles) -> None:
        options = {"raw": True, "callback_group": self._polled}
        quality = compatible_profile(profiles, DEPTH)
        self._subscribed[name] = self.create_subscription(message, name, lambda message: None, quality, **options)

    # In the thread that takes messages

    def _poll_messages(self) -> None:
        """Logs waiting messages, topic by topic, until the node closes, and once more then."""
        stopping = False
        while not stopping:
            stopping = self._stopping.wait(self._period)
            with self._lock:
                for name, subscription in list(self._subscribed.items()):
                    self._log(name, subscription)

    def _log(self, topic: str, subscription: Subscription) -> None:
        taken = list(waiting_messages(subscription))
        if not taken:
            return
        try:
            if self.recording.topics[topic].ros_type in NUMBERED:  # outputs of several publishers mix
                self.recording.publishers(topic, subscription.get_publisher_count())
            now = self.get_clock().now().nanoseconds  # with use_sim_time 0 before the first /clock
            received = []
            for data, info in taken:
                time_ns = now if self._by_ros_time else info["received_timestamp"] or now
                number = info.get("publication_sequence_number")
                received.append(Received(time_ns, info["source_timestamp"] or time_ns, number, data))
            self.recording.receive_all(topic, received)
        except Exception as error:  # it would end the thread in silence
            self.fail(error)

    @guarded
    def _on_diagnostics(self):
        counts = {name: subscription.get_publisher_count() for name, subscription in list(self._subscribed.items())}
        for name, count in counts.items():
            self.recording.publishers(name, count)
        self.recording.note_losses()
        status, log = self.recording.status(), self.recording.log
        level, message, room = self.log_status(log, log.path.parent)
        if not message and not {*self._subscribed} - {*FRAMES} and {*self._topics} - {*FRAMES}:
            matching = " and ".join(self._subscribed) or "none"
            level, message = WARN, f"of the topics {' '.join(self._topics)} there is {matching} so far"
            if self._subscribed:
                self.get_logger().warning(
                    f"{message}; name those of other namespaces in the parameter topics", once=True
                )
        elif not message and (message := warning_of(status)):
            level = WARN
            if message.strip("0123456789") != self._warned:
                self._warned = message.strip("0123456789")
                self.get_logger().warning(f"{message}; topics: lost_on of /diagnostics and of the log")
        if self.failure is not None:
            level, message = ERROR, str(self.failure)
        # A publisher counts a subscriber before that knows the publisher: only both counts say that nothing is lost.
        status["least_publishers"] = min(counts.values(), default=0)
        self.report(level, message or "recording", status | room)
