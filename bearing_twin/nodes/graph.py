"""The graph of nodes for the command line, as one node has discovered it; there is no daemon."""

import contextlib
import os
import re
import time
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

from action_msgs.msg import GoalStatus
from rcl_interfaces.msg import Log
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.signals import SignalHandlerOptions

from bearing_twin.base.errors import BearingTwinError, echo, escape_controls, legal_hint, peer_name
from bearing_twin.log.bag import Qos
from bearing_twin.nodes.base_node import leave_ros
from bearing_twin.nodes.messages import (
    RunStudy,
    compatible_profile,
    interface,
    message_from,
    plain_data,
    qos_profile,
    rclpy,
)

QUIET, LONGEST = 1.5, 3.0  # s without a change after which a list is complete on a free machine; most times that
TURN, DEPTH = 0.05, 100  # s of one turn of the executor; messages that may wait
WARNED = 0.5  # s after the last message in which its subscribers may warn of it
GONE = 5.0  # s without a server after which the goal of an action is lost; a killed server is seen for 20 s more
GOALS = "/_action/send_goal"  # the service of an action that takes its goals
OWN = "/bearing_twin_command"
NAME = re.compile(r"/[\w/]*", flags=re.ASCII)  # anybody on the network can send names with control characters

T = TypeVar("T")


class GraphError(BearingTwinError):
    """A node, topic, parameter, service or action is missing, refuses, or did not answer in time."""


def full_name(end) -> str:
    """Full name of the node of a publisher or subscription."""
    return f"{end.node_namespace.rstrip('/')}/{end.node_name}"


def refuse_other_type(name: str, kind: type, group: str, types: list[str]) -> None:
    """Raises GraphError where `kind` is not among the types of a topic or service, if it has any."""
    full = f"{kind.__module__.partition('.')[0]}/{group}/{kind.__name__}"
    if types and full not in types:
        raise GraphError(f"{name} takes {' or '.join(map(peer_name, types))}, not {full}")


def quiet_time() -> float:
    """Seconds without a change after which a list is taken as complete, longer where processes wait for processors.

    With six processes per processor the second of two nodes was discovered up to 3 s after the first.
    """
    waiting = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    return QUIET * min(max(1.0, waiting / (os.cpu_count() or 1)), LONGEST)


class Graph:
    """A node among the others, in the main thread until `close`; `wait` [s] limits each wait for a peer."""

    def __init__(self, wait: float):
        self._wait, self._context = wait, rclpy.Context()
        self._clients: dict[str, AsyncParameterClient] = {}  # by node
        rclpy.init(context=self._context, signal_handler_options=SignalHandlerOptions.NO)
        options = {"context": self._context, "enable_rosout": False, "start_parameter_services": False}
        self._node = rclpy.create_node(OWN.lstrip("/"), **options)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)

    def close(self, code: int) -> None:
        """Ends the node, or after some seconds in which ROS does not let it go the process, with this exit code."""
        self._executor.shutdown()
        leave_ros(self._node, code, self._context)

    def nodes(self) -> list[str]:
        """Full names of the nodes."""
        names = self._settled(self._node.get_fully_qualified_node_names)
        return sorted(name for name in names if name != OWN and NAME.fullmatch(name))

    def topics(self) -> dict[str, str]:
        """Topics with their types."""
        names_and_types = sorted(self._settled(self._node.get_topic_names_and_types))
        return {name: ", ".join(map(peer_name, types)) for name, types in names_and_types if NAME.fullmatch(name)}

    def ends(self, topic: str) -> list[dict[str, str]]:
        """Publishers and subscriptions of a topic: node, type and quality of service of each."""
        self._type_of(topic)
        publishers, subscriptions = self._node.get_publishers_info_by_topic, self._node.get_subscriptions_info_by_topic
        ends = ("publisher", publishers), ("subscription", subscriptions)
        return [
            {"end": end, "node": full_name(info), "type": info.topic_type}
            | {key: getattr(info.qos_profile, key).name.lower() for key in ("reliability", "durability")}
            for end, info in self._settled(lambda: [(end, info) for end, poll in ends for info in poll(topic)])
        ]

    def messages(self, topic: str, silent: Callable[[], None], raw: bool = False) -> Iterator[Any]:
        """The messages of a topic from now on, bytes if `raw`; calls `silent()` if none is received within the wait."""
        kind, waiting = interface(self._type_of(topic), "msg"), []
        on_message = lambda message: waiting.append(message)  # noqa: E731  (rclpy needs a signature)
        # A subscription may be discovered before the publishers, of which some are reached by best effort alone.
        publishers = self._spin(self._wait, lambda: self._node.get_publishers_info_by_topic(topic))
        offered = [publisher.qos_profile for publisher in publishers]
        self._node.create_subscription(kind, topic, on_message, compatible_profile(offered, DEPTH), raw=raw)
        if not (publishers and self._spin(self._wait, lambda: waiting)):
            silent()
        while True:
            self._executor.spin_once(timeout_sec=TURN)
            while waiting:
                yield waiting.pop(0)

    def publish(
        self, topic: str, ros_type: str, data: Any, count: int, rate: float, warn: Callable[[str], None]
    ) -> int:
        """Publishes a message `count` times (0: until Ctrl-C) at `rate` [Hz]; returns how often it did.

        Waits for a subscriber first; raises GraphError where none comes, or one that takes another type. `warn` takes
        what the nodes that subscribe log meanwhile as a warning or an error, such as the refusal of a command.
        """
        kind = interface(ros_type, "msg")
        message = message_from(kind, data)
        publisher = self._node.create_publisher(kind, topic, qos_profile(Qos(10)))
        subscriptions, sent = lambda: self._node.get_subscriptions_info_by_topic(topic), 0

        def count_subscriptions() -> int:
            refuse_other_type(topic, kind, "msg", sorted({info.topic_type for info in subscriptions()}))
            return publisher.get_subscription_count()

        def on_log(entry: Log) -> None:
            name = f"/{entry.name.replace('.', '/')}"
            if sent and entry.level >= Log.WARN and name in map(full_name, subscriptions()):
                warn(escape_controls(f"{name} warns: {entry.msg}"))

        self._node.create_subscription(Log, "/rosout", on_log, DEPTH)
        subscribed = lambda: [name for name in self.topics() if self._node.count_subscribers(name)]  # noqa: E731
        self._await(count_subscriptions, "subscriber of", topic, subscribed)
        self._settled(publisher.get_subscription_count)  # each learns of the publisher a little later
        with contextlib.suppress(KeyboardInterrupt):
            while not count or sent < count:
                publisher.publish(message)
                sent += 1
                self._spin(1.0 / rate if sent != count else WARNED)
            publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=self._wait))
        return sent

    def parameters(self, node: str) -> dict[str, Any]:
        """All parameters of a node that have a value."""
        names = sorted(self._parameter_answer(node, "list_parameters").result.names)
        return {name: value for name in names if (value := self._parameter(node, name)) is not None}

    def parameter(self, node: str, name: str) -> Any:
        """The value of a parameter; raises GraphError for one that the node does not have."""
        if (value := self._parameter(node, name)) is None:
            raise GraphError(f"{node} has no parameter {echo(name)}; {legal_hint(name, list(self.parameters(node)))}")
        return value

    def set_parameter(self, node: str, name: str, value: Any) -> Any:
        """Sets a parameter and returns its value; raises GraphError if refused.

        A real number may be given as an integer, also to nodes that are not ours.
        """
        if isinstance(self.parameter(node, name), float) and type(value) is int:
            value = float(value)
        kind = Parameter.Type.STRING_ARRAY if value == [] else None  # an empty list has no type
        message = Parameter(name, kind, value).to_parameter_msg()
        (result,) = self._parameter_answer(node, "set_parameters", [message]).results
        if not result.successful:
            raise GraphError(f"{node} refuses {name} = {echo(value)}: {result.reason or 'it gives no reason'}")
        return self.parameter(node, name)

    def call(self, service: str, ros_type: str | None, data: Any) -> dict[str, Any]:
        """The answer of a service; its type is looked up where none is given."""
        known = lambda: dict(self._node.get_service_names_and_types())  # noqa: E731
        types = self._await(lambda: known().get(service), "service", service, known)
        kind = interface(ros_type or types[0], "srv")
        request = message_from(kind.Request, data)
        refuse_other_type(service, kind, "srv", types)
        client = self._node.create_client(kind, service)
        self._await(client.service_is_ready, "service", service, known)
        return plain_data(self._answer(client.call_async(request), service))

    def run_study(self, action: str, goal: dict[str, Any], on_progress: Callable[[dict], None]) -> tuple[str, dict]:
        """Final state (succeeded, canceled, aborted) and result of a goal; `on_progress` gets the feedback.

        Ctrl-C cancels the goal and waits for its end. Raises GraphError if the goal is refused or its node gone.
        """
        client = ActionClient(self._node, RunStudy, action)
        known, served = self._node.get_service_names_and_types, self._node.count_services

        def actions() -> list[str]:
            return [name.removesuffix(GOALS) for name, _ in known() if name.endswith(GOALS) and served(name)]

        def end(future) -> None:
            while not self._spin(GONE, future.done):
                if not self._spin(GONE, lambda: client.server_is_ready() or future.done()):
                    raise GraphError(f"the node of {action} is gone, and the goal with it; start it and ask again")

        try:
            self._await(client.server_is_ready, "action", action, actions)
            request = message_from(RunStudy.Goal, goal)
            on_feedback = lambda message: on_progress(plain_data(message.feedback))  # noqa: E731
            handle = self._answer(client.send_goal_async(request, feedback_callback=on_feedback), action)
            if not handle.accepted:
                raise GraphError(f"{action} refuses the goal: its queue is full; try again later")
            ended = handle.get_result_async()
            try:
                end(ended)
            except KeyboardInterrupt:
                handle.cancel_goal_async()
                end(ended)
            status = {value: name for name, value in vars(GoalStatus).items() if name.startswith("STATUS_")}
            return status[ended.result().status].removeprefix("STATUS_").lower(), plain_data(ended.result().result)
        finally:
            client.destroy()

    def _parameter(self, node: str, name: str) -> Any:
        # One by one: a node answers with nothing at all where it lacks one of several.
        values = self._parameter_answer(node, "get_parameters", [name]).values
        return plain_data(parameter_value_to_python(values[0])) if values else None

    def _parameter_answer(self, node: str, method: str, *arguments) -> Any:
        """The answer of one of a node's parameter services."""
        name = f"/{node.lstrip('/')}"
        if name not in self._clients:
            self._clients[name] = AsyncParameterClient(self._node, name)
        client = self._clients[name]
        self._await(client.services_are_ready, "node", name, self._node.get_fully_qualified_node_names)
        return self._answer(getattr(client, method)(*arguments), name)

    def _type_of(self, topic: str) -> str:
        known = lambda: dict(self._node.get_topic_names_and_types())  # noqa: E731
        first, *more_types = self._await(lambda: known().get(topic), "topic", topic, known)
        if more_types:
            several = ", ".join(map(peer_name, (first, *more_types)))
            raise GraphError(f"{topic} has several types: {several}; end all nodes but those of one")
        return first

    def _await(self, poll: Callable[[], T], role: str, name: str, names: Callable[[], Any]) -> T:
        """The first true value of `poll()`; raises GraphError with near `names` after the wait."""
        if answer := self._spin(self._wait, poll):
            return answer
        listed = [known for known in names() if NAME.fullmatch(known) and not known.startswith(OWN)]
        if name in listed:
            raise GraphError(f"{name} is there, but was not ready within {self._wait:g} s; wait longer: --wait")
        near = f"; {legal_hint(name, listed)}" if listed else ": there is no node in this ROS_DOMAIN_ID"
        raise GraphError(f"there is no {role} {echo(name)}{near}")

    def _answer(self, future, name: str) -> Any:
        if not self._spin(self._wait, future.done):
            raise GraphError(f"{name} did not answer within {self._wait:g} s; wait longer: --wait")
        return future.result()

    def _spin(self, seconds: float, poll: Callable[[], T] = lambda: False) -> T:
        """Executes callbacks for so long, or until `poll()` is true; returns its value."""
        end = time.monotonic() + seconds
        while not (answer := poll()) and (remaining := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=min(TURN, remaining))
        return answer

    def _settled(self, poll: Callable[[], T]) -> T:
        """The value of `poll()` once it no longer changes."""
        last, changed, quiet = poll(), time.monotonic(), quiet_time()
        while time.monotonic() < changed + quiet:
            self._spin(TURN)
            if (current := poll()) != last:
                last, changed = current, time.monotonic()
        return last
