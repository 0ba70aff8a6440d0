"""The outlet of a node: publishers of serialised messages, and waiting for those who subscribe to them."""

import time
from collections import Counter
from collections.abc import Callable, Iterable

from rclpy._rclpy_pybind11 import RCLError
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMessage

from bearing_twin.base.errors import BearingTwinError, echo, escape_controls, peer_name
from bearing_twin.log.bag import Qos
from bearing_twin.nodes.messages import burst_profile, interface, qos_profile, stamp
from bearing_twin.nodes.pacing import Timed

MANY = 500  # topics, beyond which the work of DDS and ROS for each delays the turns and the end of a node
SHARE_SHOWN = 0.5  # of the time, beyond which a node that is late reports that it publishes
ACKNOWLEDGE_TIME = 3.5  # s; a subscriber may acknowledge no sooner than the next heartbeat of DDS, 3 s apart by default
DISCOVERY_POLL = 0.02  # s
DISCOVERY_PATIENCE = 1.0  # s of waiting for subscribers, after which a node logs what it waits for
DISCOVERY_GRACE = 0.5  # s in which subscribers discover the publishers that have discovered them
SOME = 3  # topics that are named of those without a subscriber
LISTED = 10  # topics that are named of those that cannot be published


class Outlet:
    """Publishes serialised messages as they are, and counts them; publishes /clock with `publish_clock`.

    A topic whose type is not installed, or whose name is not legal in ROS, is omitted with a warning; raises
    BearingTwinError where that is all.
    Of more than MANY topics ROS does not warn of subscribers with another quality of service.
    """

    def __init__(self, node: Node, topics: Iterable[tuple[str, str, Qos]], publish_clock: bool):
        self._publishers, problems, topics = {}, [], list(topics)
        # First, as it has precedence over a topic of this name: a node has one type of message under each name.
        clock = qos_profile(Qos(1, "best_effort"))
        self._clock = node.create_publisher(ClockMessage, "/clock", clock) if publish_clock else None
        # Each handler of events is one more thing to wait for: thousands take half a second of every turn of a node.
        events = PublisherEventCallbacks(use_default_callbacks=len(topics) <= MANY)
        for name, ros_type, qos in topics:
            try:
                form = interface(ros_type, "msg"), name, burst_profile(qos)
                self._publishers[name] = node.create_publisher(*form, event_callbacks=events)
            except BearingTwinError as error:
                problems.append(f"{escape_controls(name)} is not published: {error}")
            except InvalidTopicNameException:
                problems.append(f"{echo(name)} is not published: it is not a legal name of a topic in ROS")
            except RCLError:
                problems.append(f"{echo(name)} is not published: the node has a topic of this name with another type")
        if problems and not self._publishers:
            raise BearingTwinError(problems[0])
        if problems:
            more = [f"and {len(problems) - LISTED} more"] if len(problems) > LISTED else []
            node.get_logger().warning("; ".join(problems[:LISTED] + more))
        self.published = 0
        self._node, self._spent, self._spent_since = node, Counter(), time.monotonic()

    @property
    def publishers(self):
        """The publishers of the topics."""
        return self._publishers.values()

    def subscribed_topics(self) -> set[str]:
        """The names of the topics that have a subscriber."""
        return {name for name, publisher in self._publishers.items() if publisher.get_subscription_count()}

    @property
    def has_clock(self) -> bool:
        """True if time is published."""
        return self._clock is not None

    def tick(self, time_ns: int) -> None:
        """Publishes the time, if the outlet has a clock."""
        if self._clock:
            self._clock.publish(ClockMessage(clock=stamp(time_ns)))

    def deliver(self, message: Timed) -> None:
        """Publishes a message, unless it has no bytes."""
        publisher = self._publishers.get(message.topic)
        if publisher is not None and message.cdr:
            began = time.perf_counter()
            publisher.publish(message.cdr)
            self._spent[message.topic] += time.perf_counter() - began
            self.published += 1

    def slow_topic(self) -> str:
        """Names the topic that took longest to publish since the last call, and its subscribers; "" if all were quick.

        To a process of this machine that is suspended Fast DDS opens shared memory anew for every message.
        """
        spent, self._spent = self._spent, Counter()
        begin, self._spent_since = self._spent_since, time.monotonic()
        share = spent.total() / (self._spent_since - begin)
        if share < SHARE_SHOWN:
            return ""
        [(name, _)] = spent.most_common(1)
        topic = self._publishers[name].topic_name
        nodes = sorted({peer_name(info.node_name) for info in self._node.get_subscriptions_info_by_topic(topic)})
        advice = f"publish less, or see whether a subscriber is suspended ({', '.join(nodes)})"
        return f"; publishing takes {share:.0%} of the time, most on {topic}: {advice}"

    def wait_for_acknowledgement(self, seconds: float = ACKNOWLEDGE_TIME) -> None:
        """Waits until reliable subscribers have everything that was published, or take longer."""
        end = time.monotonic() + seconds
        for publisher in self.publishers:
            remaining = max(0.0, end - time.monotonic())
            if not publisher.wait_for_all_acked(Duration(nanoseconds=round(remaining * 1e9))):
                return

    def wait_for_subscribers(self, seconds: float, stopping: Callable[[], bool]) -> None:
        """Waits until each topic has a subscriber, at most `seconds`, or until `stopping()`; logs a long wait."""
        if not seconds:
            return
        started_at, log, total = time.monotonic(), self._node.get_logger(), len(self.publishers)
        while not stopping():
            unheard = [publisher.topic_name for publisher in self.publishers if not publisher.get_subscription_count()]
            if not unheard:
                break
            remainder = f" and {len(unheard) - SOME} more" if len(unheard) > SOME else ""
            state = f"{len(unheard)} of {total} topics have no subscriber: {', '.join(unheard[:SOME])}{remainder}"
            waited = time.monotonic() - started_at
            if waited > seconds:
                log.info(f"continues after {seconds:g} s, although {state}")
                return
            if waited > DISCOVERY_PATIENCE:
                log.info(f"waiting up to {seconds:g} s for subscribers (discovery); {state}", once=True)
            time.sleep(DISCOVERY_POLL)
        time.sleep(DISCOVERY_GRACE)
