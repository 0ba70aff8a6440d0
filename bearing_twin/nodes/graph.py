"""Other nodes as the command line looks at them; there is no daemon: every call waits until discovery is at rest."""

import contextlib
import math
import time
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

from action_msgs.msg import GoalStatus
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterType
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.signals import SignalHandlerOptions

from bearing_twin.errors import BearingTwinError
from bearing_twin.log.bag import Qos
from bearing_twin.nodes import discovery
from bearing_twin.nodes.messages import interface, qos_profile, rclpy, suited
from bearing_twin.nodes.reflection import filled, plain
from bearing_twin.parameters import echo, unknown
from bearing_twin.spelling import name_of_peer

AT_MOST = 4.0  # s a list is waited for while no other node is seen whole: on a busy machine discovery is late
TURN, DEPTH = 0.05, 100  # s; messages that may wait
GONE = 5.0  # s without a server after which that of a goal is gone; one that was killed is seen for 20 s more
ENDS = {value: name.removeprefix("STATUS_").lower() for name, value in vars(GoalStatus).items() if "STATUS_" in name}

Found = TypeVar("Found")


class GraphError(BearingTwinError):
    """What was asked for is not there, or did not answer in time."""


class Graph:
    """A node of its own among the others; `wait` is how long it waits for what is asked for, in seconds of wall time.

    To be used in a `with` statement, and in the main thread: Ctrl-C interrupts a wait.
    """

    def __init__(self, wait: float):
        self._wait, self._context = wait, rclpy.Context()
        rclpy.init(context=self._context, signal_handler_options=SignalHandlerOptions.NO)
        self._node = rclpy.create_node(
            "bearing_twin_command", context=self._context, enable_rosout=False, start_parameter_services=False
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)

    def __enter__(self) -> "Graph":
        return self

    def __exit__(self, *_) -> None:
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.try_shutdown(context=self._context)

    # Lists

    def nodes(self) -> list[str]:
        """Full names of the nodes."""
        own = self._node.get_fully_qualified_name()
        names = self._at_rest(self._node.get_fully_qualified_node_names)
        return sorted(name for name in names if name != own and discovery.NAME.fullmatch(name))

    def topics(self) -> dict[str, str]:
        """Topics that others publish or listen to, with their types."""
        return self._typed(self._node.get_topic_names_and_types)

    def services(self) -> dict[str, str]:
        """Services with their types."""
        return self._typed(self._node.get_service_names_and_types)

    def actions(self) -> dict[str, str]:
        """Actions with their types."""
        return self._typed(lambda: discovery.served_actions(self._node))

    # Topics

    def ends(self, topic: str) -> dict[str, list[dict[str, Any]]]:
        """Who publishes a topic and who listens: node, type and quality of service of each."""
        self._known(topic, self._node.get_topic_names_and_types, "topic")
        self._at_rest(self._node.get_fully_qualified_node_names)
        found = {
            "publishers": self._node.get_publishers_info_by_topic,
            "subscriptions": self._node.get_subscriptions_info_by_topic,
        }
        return {key: list(map(discovery.end_of, self._at_rest(lambda of=of: of(topic)))) for key, of in found.items()}

    def messages(self, topic: str, silent: Callable[[], None], raw: bool = False) -> Iterator[Any]:
        """The messages of a topic from now on, without end; bytes where `raw`. Raises GraphError if nobody has it.

        `silent` is called once if none has come after the wait.
        """
        ros_type = self._known(topic, self._node.get_topic_names_and_types, "topic")
        waiting: deque = deque()
        take = lambda one: waiting.append(one)  # noqa: E731  (rclpy asks for its signature: a builtin has none)
        offered = [one.qos_profile for one in self._node.get_publishers_info_by_topic(topic)]
        self._node.create_subscription(interface(ros_type, "msg"), topic, take, suited(offered, DEPTH), raw=raw)
        patient_until = time.monotonic() + self._wait
        while True:
            self._executor.spin_once(timeout_sec=TURN)
            while waiting:
                patient_until = math.inf
                yield waiting.popleft()
            if time.monotonic() > patient_until:
                patient_until = math.inf
                silent()

    def publish(self, topic: str, ros_type: str, data: Any, count: int, rate: float) -> int:
        """Publishes a message `count` times (0: until Ctrl-C, the normal end) at `rate` [Hz]; returns how often it did.

        Waits for a subscriber first; raises GraphError where none comes, or one that takes another type.
        """
        kind = interface(ros_type, "msg")
        message = filled(kind, data)
        publisher = self._node.create_publisher(kind, topic, qos_profile(Qos(10)))
        full = f"{kind.__module__.partition('.')[0]}/msg/{kind.__name__}"

        def heard() -> int:
            types = sorted({one.topic_type for one in self._node.get_subscriptions_info_by_topic(topic)})
            if types and full not in types:
                raise GraphError(f"{topic} takes {' or '.join(map(name_of_peer, types))}, not {full}")
            return publisher.get_subscription_count()

        self._look(heard, f"nobody listens to {echo(topic)}", self._names("topic", self._node.count_subscribers))
        self._at_rest(publisher.get_subscription_count)  # all of them, and each learns of the publisher a little later
        sent = 0
        with contextlib.suppress(KeyboardInterrupt):
            while not count or sent < count:
                publisher.publish(message)
                sent += 1
                self._spin(1.0 / rate)
            publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=self._wait))
        return sent

    # Parameters

    def parameters(self, node: str) -> list[str]:
        """Names of the parameters of a node."""
        return sorted(self._asked(node, lambda client: client.list_parameters()).result.names)

    def parameter(self, node: str, names: list[str]) -> dict[str, Any]:
        """Values of parameters; raises GraphError for one that the node does not have."""
        found = {}
        for name in names:  # one by one: a node answers with nothing at all where it lacks one of several
            values = self._asked(node, lambda client, name=name: client.get_parameters([name])).values
            if not values or values[0].type == ParameterType.PARAMETER_NOT_SET:
                raise GraphError(f"{node} has no parameter {echo(name)}; {unknown(name, self.parameters(node))}")
            found[name] = plain(parameter_value_to_python(values[0]))
        return found

    def parameter_values(self, node: str) -> dict[str, Any]:
        """All parameters of a node that have a value."""
        found = {}
        for name in self.parameters(node):
            with contextlib.suppress(GraphError):
                found |= self.parameter(node, [name])
        return found

    def describe(self, node: str, name: str) -> dict[str, Any]:
        """What a node says of a parameter."""
        self.parameter(node, [name])
        return plain(self._asked(node, lambda client: client.describe_parameters([name])).descriptors[0])

    def set_parameter(self, node: str, name: str, value: Any) -> None:
        """Sets a parameter; a whole number does where the node wants a real one. Raises GraphError if it is refused."""
        held = self.parameter(node, [name])[name]
        if isinstance(value, int) and not isinstance(value, bool) and isinstance(held, float):
            value = float(value)
        message: ParameterMessage = Parameter(name, value=value).to_parameter_msg()
        (result,) = self._asked(node, lambda client: client.set_parameters([message])).results
        if not result.successful:
            raise GraphError(f"{node} refuses {name} = {echo(value)}: {result.reason or 'it gives no reason'}")

    # Services and actions

    def rivals(self, name: str, action: bool = False) -> list[str]:
        """What to know where several nodes answer to a service, or to goals of an action; see `discovery.rivals`."""
        return discovery.rivals(self._node, f"{name}{discovery.GOALS}" if action else name)

    def call(self, service: str, ros_type: str | None, data: Any) -> dict[str, Any]:
        """The answer of a service; its type is looked up where none is given."""
        found = ros_type or self._known(service, self._node.get_service_names_and_types, "service")
        kind = interface(found, "srv")
        client = self._node.create_client(kind, service)
        request = filled(kind.Request, data)
        self._look(client.service_is_ready, f"there is no service {echo(service)}", self._names("service"))
        return plain(self._answer(client.call_async(request), service))

    def send_goal(
        self, action: str, ros_type: str | None, data: Any, tell: Callable[[dict], None]
    ) -> tuple[str, dict[str, Any]]:
        """How a goal ended (succeeded, canceled, aborted) and its result; `tell` takes the feedback.

        Ctrl-C cancels the goal and waits for its end. Raises GraphError if the goal is refused or its node gone.
        """
        found = ros_type or self._known(action, lambda: discovery.served_actions(self._node), "action")
        kind = interface(found, "action")
        goal = filled(kind.Goal, data)
        client = ActionClient(self._node, kind, action)
        try:
            self._look(client.server_is_ready, f"there is no action {echo(action)}", self._names("action"))
            sent = client.send_goal_async(goal, feedback_callback=lambda one: tell(plain(one.feedback)))
            handle = self._answer(sent, action)
            if not handle.accepted:
                raise GraphError(f"{action} refuses the goal: it has enough to do; try again later")
            ended = handle.get_result_async()
            try:
                self._served(client, ended.done, action)
            except KeyboardInterrupt:
                handle.cancel_goal_async()
                self._served(client, ended.done, action)
            return ENDS.get(ended.result().status, "unknown"), plain(ended.result().result)
        finally:
            client.destroy()

    # Waiting

    def _asked(self, node: str, ask: Callable[[AsyncParameterClient], Any]) -> Any:
        """The answer of a node's parameter services."""
        name = node if node.startswith("/") else f"/{node}"
        client = AsyncParameterClient(self._node, name)
        self._look(
            client.services_are_ready, f"there is no node {echo(node)}", self._node.get_fully_qualified_node_names
        )
        return self._answer(ask(client), name)

    def _known(self, name: str, names: Callable[[], list], what: str) -> str:
        """The type of what has this name, as soon as it is discovered."""
        types = self._look(lambda: dict(names()).get(name), f"there is no {what} {echo(name)}", self._names(what))
        if len(types) > 1:
            told = ", ".join(map(name_of_peer, types))
            raise GraphError(f"{name} has several types: {told}; end all nodes but those of one")
        return types[0]

    def _names(self, what: str, chosen: Callable[[str], Any] = bool) -> Callable[[], list[str]]:
        ask = {"topic": self.topics, "service": self.services, "action": self.actions}[what]
        return lambda: [name for name in ask() if not discovery.PLUMBING.search(name) and chosen(name)]

    def _look(self, found: Callable[[], Found], missing: str, names: Callable[[], list[str]]) -> Found:
        """What `found()` gives as soon as it is true; raises GraphError with near `names` after the wait."""
        end = time.monotonic() + self._wait
        while not (result := found()):
            if time.monotonic() > end:
                own = self._node.get_fully_qualified_name()
                there = [one for one in names() if discovery.NAME.fullmatch(one) and not one.startswith(own)]
                name = missing.rpartition(" ")[2].strip("'")
                if result := found():  # it came while the names were listed
                    return result
                if name in there:
                    raise GraphError(f"{name} is there, but was not ready within {self._wait:g} s; wait longer: --wait")
                near = unknown(name, there) if there else "no node is to be seen: start one, in the same ROS_DOMAIN_ID"
                raise GraphError(f"{missing} within {self._wait:g} s; {near}")
            self._executor.spin_once(timeout_sec=TURN)
        return result

    def _answer(self, future, whose: str) -> Any:
        end = time.monotonic() + self._wait
        self._until(lambda: future.done() or time.monotonic() > end)
        if not future.done():
            raise GraphError(f"{whose} did not answer within {self._wait:g} s; wait longer with --wait, or look at it")
        return future.result()

    def _until(self, done: Callable[[], bool]) -> None:
        while not done():
            self._executor.spin_once(timeout_sec=TURN)

    def _served(self, client: ActionClient, done: Callable[[], bool], action: str) -> None:
        """Waits for the end of a goal; raises GraphError where nobody serves it any more."""
        seen = time.monotonic()
        while not done():
            self._executor.spin_once(timeout_sec=TURN)
            seen = time.monotonic() if client.server_is_ready() else seen
            if time.monotonic() > seen + GONE:
                raise GraphError(f"the node of {action} is gone, and the goal with it; start it and ask again")

    def _spin(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        self._until(lambda: time.monotonic() > end)

    def _at_rest(self, ask: Callable[[], Found]) -> Found:
        """What `ask()` gives once discovery adds nothing any more."""
        now = began = time.monotonic()
        last, changed, quiet = ask(), now, discovery.quiet_time()
        while now < changed + quiet or (now < began + AT_MOST and not discovery.others_are_whole(self._node)):
            self._executor.spin_once(timeout_sec=TURN)
            now, found = time.monotonic(), ask()
            if found != last:
                last, changed = found, now
        return last

    def _typed(self, ask: Callable[[], list]) -> dict[str, str]:
        own, known = self._node.get_fully_qualified_name(), discovery.NAME.fullmatch
        found = (one for one in sorted(self._at_rest(ask)) if known(one[0]) and not one[0].startswith(own))
        return {name: ", ".join(map(name_of_peer, types)) for name, types in found}
