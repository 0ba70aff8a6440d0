"""recorder_node: logs topics as they are on the wire, byte for byte, and counts the solver outputs that were lost."""

import threading
import time

from rclpy.qos import QoSCompatibility, qos_check_compatible
from rclpy.subscription import Subscription

from bearing_twin.base.errors import BearingTwinError, LogError
from bearing_twin.base.messages import name_of_peer
from bearing_twin.nodes.base_node import TALK, BaseNode, PolledGroup, declare, guarded, run, taken
from bearing_twin.nodes.graph import is_topic
from bearing_twin.nodes.messages import DIAGNOSTICS_PERIOD, ERROR, WARN, compatible_profile, interface, qos_words
from bearing_twin.nodes.node_parameters import LOG_SAFETY, THINNED, NodeParameter, safety_of
from bearing_twin.nodes.recording import (
    DEPTH,
    RECORDS,
    Recording,
    default_topics,
    definition_prefixes,
    lost_in_words,
)

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
TAKE_PERIOD = 0.025  # s between looks for messages, each of which takes as long as several messages
SIM_TIME_PERIOD = 0.005  # s, where messages have the simulation time at which they are taken
OFFERED_DEPTH = 10  # discovery does not tell the depth of a publisher


class RecorderNode(BaseNode):
    """Logs every topic that matches, from the moment it has a publisher; raises BearingTwinError where it cannot."""

    def __init__(self, **options):
        super().__init__("recorder_node", "recording", **options)
        values = declare(self, PARAMETERS)
        path = values["log"] or time.strftime("recording_%Y%m%d_%H%M%S.mcap")
        self._topics = [one for one in values["topics"] if one] or default_topics(self.get_namespace())
        self.recording = Recording(path, self._topics, definition_prefixes(), safety_of(values))
        self.get_logger().info(f"log: {path}{'' if values['full'] else THINNED}")
        self._by_ros_time = self.get_parameter("use_sim_time").value
        self._refused: set[str] = set()
        self._warned = ""
        self._subscribed: dict[str, Subscription] = {}
        self._taking = threading.Lock()
        period = SIM_TIME_PERIOD if self._by_ros_time else TAKE_PERIOD
        self._period = min(period, values["max_loss"])  # what waits is lost in a crash too
        self._aside, self._stopping = PolledGroup(), threading.Event()
        self._taker = threading.Thread(target=self._take, name="take", daemon=True)
        self._taker.start()
        self.every(DISCOVERY_PERIOD, self._on_discovery)
        self.every(DIAGNOSTICS_PERIOD, self._on_diagnostics)

    def close(self) -> None:
        """Completes the log; may be called twice. To have recorded nothing is a failure."""
        self._stopping.set()
        self._taker.join()
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
            if not (name in self._refused or name in self._subscribed or not is_topic(name)):
                publishers = self.get_publishers_info_by_topic(name)
                if publishers and self.recording.wants(name):
                    self._subscribe(name, types, publishers)
        for name, subscription in list(self._subscribed.items()):
            if self.count_publishers(name) > subscription.get_publisher_count():  # one that may not be compatible
                self._subscribe_again(name, subscription)

    def _subscribe(self, name: str, types: list[str], publishers) -> None:
        profiles = [publisher.qos_profile for publisher in publishers]
        offered = tuple(qos_words(profile)._replace(depth=profile.depth or OFFERED_DEPTH) for profile in profiles)
        try:
            if len(types) > 1:
                raise BearingTwinError(f"publishers disagree on its type: {', '.join(map(name_of_peer, types))}")
            message = interface(types[0], "msg")
            self.recording.add(name, types[0], str(publishers[0].topic_type_hash), offered)
        except BearingTwinError as error:
            self._refused.add(name)
            self.get_logger().error(f"{name} is not logged: {error}", throttle_duration_sec=TALK)
            return
        self._listen(name, message, profiles)

    def _subscribe_again(self, name: str, subscription: Subscription) -> None:
        """Replaces a subscription with which a later publisher is not compatible, as it offers less than the first."""
        profiles = [one.qos_profile for one in self.get_publishers_info_by_topic(name)]
        if all(qos_check_compatible(one, subscription.qos_profile)[0] != QoSCompatibility.ERROR for one in profiles):
            return
        with self._taking:
            self._log(name, list(taken(subscription)))
            self.destroy_subscription(subscription)
            self._listen(name, subscription.msg_type, profiles)
        self.get_logger().warning(f"{name}: a publisher offers less than those before; it is subscribed to anew")

    def _listen(self, name: str, message: type, profiles) -> None:
        options = {"raw": True, "callback_group": self._aside}
        quality = compatible_profile(profiles, DEPTH)
        self._subscribed[name] = self.create_subscription(message, name, lambda message: None, quality, **options)

    # In the thread that takes messages

    def _take(self) -> None:
        """Takes what has come, topic by topic, until the node closes, and what came last."""
        stopping = False
        while not stopping:
            stopping = self._stopping.wait(self._period)
            with self._taking:
                for name, subscription in list(self._subscribed.items()):
                    self._log(name, list(taken(subscription)))

    def _log(self, topic: str, found: list[tuple[bytes, dict]]) -> None:
        if not found:
            return
        try:
            if topic in self.recording.sequences and topic in self._subscribed:  # numbers say nothing where they mix
                self.recording.publishers(topic, self._subscribed[topic].get_publisher_count())
            now = self.get_clock().now().nanoseconds  # with use_sim_time 0 before the first /clock
            received = [now if self._by_ros_time else info["received_timestamp"] or now for _, info in found]
            sent = [info["source_timestamp"] or known for (_, info), known in zip(found, received, strict=True)]
            numbers = [info.get("publication_sequence_number") for _, info in found]
            lost = self.recording.receive_all(topic, received, sent, [data for data, _ in found], numbers)
            if lost:
                said = f"{topic}: {lost_in_words(lost, RECORDS in topic)}; /diagnostics counts all"
                self.get_logger().error(said, throttle_duration_sec=TALK)
        except Exception as error:  # it would end the thread in silence
            self.fail(error)

    @guarded
    def _on_diagnostics(self):
        counts = {name: subscription.get_publisher_count() for name, subscription in list(self._subscribed.items())}
        for name, count in counts.items():
            self.recording.publishers(name, count)
        self.recording.note_losses()
        status = self.recording.status()
        level, message, room = self.watch_log(self.recording, self.recording.folder, time.monotonic())
        if not message and (message := self.recording.warning(status)):
            level = WARN
            if status["topics"] and message.strip("0123456789") != self._warned:
                self._warned = message.strip("0123456789")
                self.get_logger().warning(f"{message}; lost_on of /diagnostics and of the log names topics")
        if self.failure is not None:
            level, message = ERROR, str(self.failure)
        # A publisher counts a subscriber before that knows the publisher: only both counts say that nothing is lost.
        status["least_publishers"] = min(counts.values(), default=0)
        self.report(level, message or "recording", status | room)


def main(args: list[str] | None = None) -> int:
    """The executable: exit code 0 when a signal ended it, 2 with one sentence when it could not log."""
    return run("recorder_node", RecorderNode, args)
