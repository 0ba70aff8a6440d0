"""Where a node's timed messages leave it: one publisher a topic, and the time they belong to on /clock if wanted."""

from collections.abc import Iterable

from rclpy.event_handler import PublisherEventCallbacks
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMessage

from bearing_twin.errors import BearingTwinError
from bearing_twin.log.bag import Qos
from bearing_twin.nodes.messages import burst_profile, interface, qos_profile, stamp
from bearing_twin.nodes.pacing import Timed
from bearing_twin.spelling import echo, harmless

CLOCK_PERIOD = 0.1  # s, of the clock that stands still while paused
MANY = 500  # topics: what DDS and ROS do for each of so many delays the end of a node and its turns


class Outlet:
    """Publishes serialised messages as they are, and counts them; publishes /clock where that is wanted.

    A topic whose type is not installed, or whose name ROS does not know, is left out with a warning; raises
    BearingTwinError where that is all.
    Of more than MANY topics ROS does not warn of subscribers with another quality of service.
    """

    def __init__(self, node: Node, topics: Iterable[tuple[str, str, Qos]], publish_clock: bool):
        self._context, self._count = node.context, node.count_publishers
        self._publishers, problems, topics = {}, [], list(topics)
        # Each handler of events is one more thing to wait for: thousands take half a second of every turn of a node.
        events = PublisherEventCallbacks(use_default_callbacks=len(topics) <= MANY)
        for name, ros_type, qos in topics:
            try:
                form = interface(ros_type, "msg"), name, burst_profile(qos)
                self._publishers[name] = node.create_publisher(*form, event_callbacks=events)
            except BearingTwinError as error:
                problems.append(f"{harmless(name)} is not published: {error}")
            except InvalidTopicNameException:
                problems.append(f"{echo(name)} is not published: it is no name of a topic in ROS")
        if problems and not self._publishers:
            raise BearingTwinError(problems[0])
        if problems:
            node.get_logger().warning("; ".join(problems))
        self._clock = None
        if publish_clock:
            self._clock = node.create_publisher(ClockMessage, "/clock", qos_profile(Qos(1, "best_effort")))
        self.published = 0

    @property
    def publishers(self):
        """The publishers of the topics."""
        return self._publishers.values()

    def listened_to(self) -> set[str]:
        """The names of the topics that have a subscriber."""
        return {name for name, publisher in self._publishers.items() if publisher.get_subscription_count()}

    @property
    def mixed(self) -> str:
        """That another node publishes samples or time where this one does, "" where none does."""
        full = [one.topic_name for one in (*self.publishers, self._clock) if one is not None]
        shared = [name for name in full if name.endswith(("/samples", "/clock")) and self._count(name) > 1]
        return (
            f"other nodes publish {', '.join(shared)}, too, and what is heard is a mixture: end them" if shared else ""
        )

    @property
    def has_clock(self) -> bool:
        """Whether time is published."""
        return self._clock is not None

    def tick(self, time_ns: int) -> None:
        """Publishes the time, where that is wanted."""
        if self._clock:
            self._publish(self._clock, ClockMessage(clock=stamp(time_ns)))

    def deliver(self, message: Timed) -> None:
        """Publishes a message, if it has been made."""
        publisher = self._publishers.get(message.topic)
        if publisher is not None and message.cdr and self._publish(publisher, message.cdr):
            self.published += 1

    def _publish(self, publisher, message) -> bool:
        """Whether it went out: once a signal has ended ROS under way there is nobody to publish to, and no error."""
        try:
            publisher.publish(message)
        except Exception:
            if self._context.ok():
                raise
            return False
        return True
