"""recorder_node: logs topics as they are on the wire, byte for byte, and counts the solver outputs that were lost."""

import threading
import time
from collections.abc import Iterable
from functools import partial

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import QoSCompatibility, qos_check_compatible
from rclpy.subscription import Subscription

from bearing_twin.base.errors import BearingTwinError, LogError
from bearing_twin.base.messages import name_of_peer
from bearing_twin.log import cdr
from bearing_twin.nodes.base_node import TALK, Heartbeat, LogWatch, TakenAside, declare, guarded, run, taken
from bearing_twin.nodes.graph import is_topic
from bearing_twin.nodes.messages import DIAGNOSTICS_PERIOD, ERROR, OK, WARN, interface, qos_words, suited
from bearing_twin.nodes.node_parameters import LOG_SAFETY, THINNED, NodeParameter, safety_of
from bearing_twin.nodes.recording import (
    DEPTH,
    MENDS,
    RECORDS,
    Recording,
    SteadyTime,
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
SOME = 3  # topics that a sentence names
OFFERED_DEPTH = 10  # discovery does not tell the depth of a publisher


class RecorderNode(Node):
    """Logs every topic that matches, from the moment it has a publisher; raises BearingTwinError where it cannot."""

    def __init__(self, **options):
        super().__init__("recorder_node", **options)
        self.done = threading.Event()
        self.failure: Exception | None = None
        values = declare(self, PARAMETERS)
        path = values["log"] or time.strftime("recording_%Y%m%d_%H%M%S.mcap")
        topics = [one for one in values["topics"] if one] or default_topics(self.get_namespace())
        self.recording = Recording(path, topics, definition_prefixes(), safety_of(values))
        self._topics = topics
        self.get_logger().info(f"log: {path}{'' if values['full'] else THINNED}")
        self._by_ros_time = self.get_parameter("use_sim_time").value
        self._refused: set[str] = set()
        self._elsewhere: set[str] = set()  # topics of samples that nobody asked for, where none were named
        self._default = not any(values["topics"])
        self._lost = 0  # messages that were told of
        self._taken: dict[str, Subscription] = {}
        self._taking = threading.Lock()
        period = SIM_TIME_PERIOD if self._by_ros_time else TAKE_PERIOD
        self._period = min(period, values["max_loss"])  # what waits is lost in a crash too
        self._aside, self._stopping, self._time = TakenAside(), threading.Event(), SteadyTime()
        self._taker = threading.Thread(target=self._take, name="take", daemon=True)
        self._taker.start()
        self._watch = LogWatch(self, self.recording.folder)
        self._heartbeat = Heartbeat(self, "recording")
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(DISCOVERY_PERIOD, self._on_discovery, clock=steady)
        self.create_timer(DIAGNOSTICS_PERIOD, self._on_diagnostics, clock=steady)

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

    @guarded
    def _on_discovery(self):
        for name, types in self.get_topic_names_and_types():
            if not is_topic(name):
                continue
            if self.recording.wants(name) and name not in self._refused:
                publishers = self.get_publishers_info_by_topic(name)
                if publishers:
                    self._subscribe(name, types, publishers)
            elif self._default and cdr.SAMPLE_BLOCK in types and RECORDS not in name:
                self._elsewhere.add(name)
        for name, subscription in list(self._taken.items()):
            if self.count_publishers(name) > subscription.get_publisher_count():  # one it may not hear
                self._suit(name, subscription)

    def _suit(self, name: str, subscription: Subscription) -> None:
        """Subscribes anew where a publisher that came later offers less than was asked for, and so would not be heard.

        Nobody tells: what is sent in between is lost, and counted as such by the numbers of its publisher.
        """
        profiles = [one.qos_profile for one in self.get_publishers_info_by_topic(name)]
        if all(qos_check_compatible(one, subscription.qos_profile)[0] != QoSCompatibility.ERROR for one in profiles):
            return
        with self._taking:
            self._on_messages(name, taken(subscription))
            self.destroy_subscription(subscription)
            self._listen(name, subscription.msg_type, profiles)
        self.get_logger().warning(f"{name}: a publisher offers less than those before; it is subscribed to anew")

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

    def _listen(self, name: str, message: type, profiles) -> None:
        wanted, take = suited(profiles, DEPTH), partial(self._on_message, name)
        self._taken[name] = self.create_subscription(message, name, take, wanted, raw=True, callback_group=self._aside)

    def _take(self) -> None:
        """In a thread of its own: takes what has come, topic by topic, until the node closes, and what came last."""
        stopping = False
        while not stopping:
            stopping = self._stopping.wait(self._period)
            self._look_at_clock()
            with self._taking:
                for name, subscription in list(self._taken.items()):
                    self._on_messages(name, taken(subscription))

    def _look_at_clock(self) -> None:
        if jump := self._time.look():
            self.recording.clock_jumped_ns = self._time.jumped_ns
            said = f"the clock was put {'forward' if jump > 0 else 'back'} by {1e-9 * abs(jump):.3f} s"
            self.get_logger().warning(f"{said}: the times in the log go on as if it had not been")

    def _on_message(self, topic: str, data: bytes, info: dict) -> None:
        self._on_messages(topic, ((data, info),))

    def _on_messages(self, topic: str, found: Iterable[tuple[bytes, dict]]) -> None:
        try:
            found = list(found)
            if not found:
                return
            self._look_at_clock()  # after they were taken: none of them can have come by a clock put since
            if topic in self.recording.sequences and topic in self._taken:  # their numbers tell nothing where they mix
                self.recording.publishers(topic, self._taken[topic].get_publisher_count())
            now = self.get_clock().now().nanoseconds  # simulation time, 0 before the first /clock
            received = [now if self._by_ros_time else self._time.at(info["received_timestamp"]) for _, info in found]
            sent = [info["source_timestamp"] or known for (_, info), known in zip(found, received, strict=True)]
            numbers = [info.get("publication_sequence_number") for _, info in found]
            unreadable = self.recording.unreadable
            lost = self.recording.receive_all(topic, received, sent, [data for data, _ in found], numbers)
            if self.recording.unreadable > unreadable:
                said = f"{topic}: no SampleBlock though sent as one, or too large: not logged; look at who sends it"
                self.get_logger().error(said, throttle_duration_sec=TALK)
            if lost:
                said = f"{topic}: {lost_in_words(lost, RECORDS in topic)}; /diagnostics counts all"
                self.get_logger().error(said, throttle_duration_sec=TALK)
        except Exception as error:  # a callback that raises would end the node without saying which message it was
            self._fail(error)

    def _fail(self, error: Exception) -> None:
        if self.failure is None:
            self.failure = error
            self.done.set()

    @guarded
    def _on_diagnostics(self):
        self.recording.note_losses()
        counts = {name: subscription.get_publisher_count() for name, subscription in list(self._taken.items())}
        for name, count in counts.items():
            self.recording.publishers(name, count)
        status = self.recording.status()
        level, message = OK, "recording"
        if not status["topics"]:
            level, message = WARN, "no topic matches so far: there is nothing to record"
        if self._elsewhere and all(RECORDS in topic for topic in self.recording.sequences):
            some = ", ".join(sorted(self._elsewhere)[:SOME])
            level, message = (
                WARN,
                f"no samples are recorded, but there are on {some}: name them in the parameter topics",
            )
            self.get_logger().warning(message, once=True)
        if lost := status["messages_lost"]:
            level, message = WARN, f"{lost} messages were lost on the way; {MENDS}"
            if lost > self._lost:
                self.get_logger().warning(f"{message}; lost_on of /diagnostics and of the log names their topics")
            self._lost = lost
        if status["messages_unreadable"]:
            level, message = WARN, f"{status['messages_unreadable']} messages are not logged: no reader takes them"
        for what in ("records", "samples"):  # the outputs have the last word
            if lost := status[f"{what}_lost"]:
                level, message = WARN, f"{lost_in_words(lost, what == 'records')}; {MENDS}"
        if mixed := status["mixed"]:
            level, message = WARN, f"several nodes publish {mixed}: their outputs are mixed, so give each a namespace"
            self.get_logger().warning(message, once=True)
        log_level, log_says, room = self._watch.look(self.recording)
        if log_says:
            level, message = log_level, log_says
        elif self.failure is not None:
            level, message = ERROR, str(self.failure)
        # A publisher counts a subscriber before that knows the publisher: only both counts say that nothing is lost.
        status["least_publishers"] = min(counts.values(), default=0)
        self._heartbeat.say(level, message, status | room)


def main(args: list[str] | None = None) -> int:
    """The executable: exit code 0 when a signal ended it, 2 with one sentence when it could not log."""
    return run("recorder_node", RecorderNode, args)
