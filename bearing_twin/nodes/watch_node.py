"""watch_node: serves a page of a running node on this machine, read from its topics, with speed, load, pause and reset.

It subscribes to the node only while a viewer is connected: without one the node makes no samples for it.
"""

import textwrap
import threading
import time
from collections.abc import Mapping
from http import HTTPStatus
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from rcl_interfaces.srv import SetParameters
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.parameter import Parameter
from std_msgs.msg import Float64, String
from std_srvs.srv import SetBool, Trigger

from bearing_twin.base.errors import BearingTwinError, Stopped, echo, legal_hint
from bearing_twin.base.parameters import read_number
from bearing_twin.base.units import readable_unit
from bearing_twin.log import cdr
from bearing_twin.log.bag import Qos
from bearing_twin.log.stream import LATCHED
from bearing_twin.nodes.base_node import BaseNode, declare, guarded, interrupted
from bearing_twin.nodes.graph import full_name, quiet_time
from bearing_twin.nodes.messages import interface, qos_profile
from bearing_twin.nodes.node_parameters import NodeParameter
from bearing_twin.nodes.simulation_loop import check_speed
from bearing_twin.view.live_page import LiveRun, RunRestarted, live_page
from bearing_twin.view.page_server import Feed, PageServer, RequestRefused


def number_of(command: Mapping[str, Any], key: str, called: str = "") -> float:
    """A finite number in a command; raises BearingTwinError that calls it `called`, or else by its key."""
    value, problem = read_number(command.get(key))
    if problem:
        raise BearingTwinError(f"{called or key} {problem}")
    return float(value)


def vector_of(command: Mapping[str, Any], key: str) -> tuple[float, float, float]:
    """Three finite numbers in a command; raises BearingTwinError."""
    value = command.get(key)
    if not isinstance(value, list) or len(value) != 3:
        raise BearingTwinError(f"{key} must be three numbers")
    return tuple(number_of({key: component}, key) for component in value)


PARAMETERS = (
    NodeParameter("node", "", "full name of the node to show; empty = the only one that publishes samples"),
    NodeParameter("host", "localhost", "address to listen on; any but localhost lets other machines look and command"),
    NodeParameter("port", 8080, "port to listen on; 0 = any that is free", "", 0, 65535),
    NodeParameter("patience", 30.0, "longest wait for such a node", "s", 0.0, 3600.0),
)
LOOK_PERIOD = 0.05  # s between checks for viewers and for messages
REQUESTED_FOR = 20.0  # s after a request for the page, within which its viewer may come
ANSWER = 5.0  # s for a service to answer
COMING = 12.0  # s for the scene and a first sample: where time is slowed down they are rare
DEPTH = 5  # samples that may wait: later ones are better than all of them
LONGEST = 600  # characters of a status, and of a refusal with its reason
MOVING = ("running", "running as fast as possible", "playing")  # states with a pace
PACES = ("real_time_factor", "rate")  # parameter of sim_node, and of replay_node
SAMPLES = "/samples"
NAMELESS = "_NODE_NAME_UNKNOWN_"  # of a node in ROS whose publisher is discovered before its name


class WatchNode(BaseNode):
    """Serves the page of one node; see PARAMETERS. Raises BearingTwinError where there is none or several."""

    def __init__(self, **options):
        super().__init__("watch_node", "page", **options)
        self.feed = Feed()
        values = declare(self, PARAMETERS)
        self.server = PageServer(self, values["host"], values["port"])  # raises before the wait where the port is taken
        try:
            self._watched, samples = self._select_node(values["node"], values["patience"])
        except BearingTwinError:
            self.server.server_close()
            raise
        self._namespace = namespace = samples.removesuffix(SAMPLES)
        self._run: LiveRun | None = None
        self._described, self._refused = threading.Event(), ""
        self._shown, self._requested = threading.Event(), -REQUESTED_FOR
        self._listening = []
        self._commands = MutuallyExclusiveCallbackGroup()
        clients = {"callback_group": self._commands}
        self._pause = self.create_client(SetBool, f"{self._watched}/pause", **clients)
        self._reset = self.create_client(Trigger, f"{self._watched}/reset", **clients)
        self._set = self.create_client(SetParameters, f"{self._watched}/set_parameters", **clients)
        self._speed = self.create_publisher(Float64, f"{namespace}/command/speed", qos_profile(Qos()))
        self._load = self.create_publisher(WrenchStamped, f"{namespace}/command/load", qos_profile(Qos()))
        self.create_subscription(String, f"{namespace}/scene", self._on_scene, qos_profile(LATCHED))
        self.every(LOOK_PERIOD, self._on_look)
        self.server.start()
        print(f"{self._watched} is shown at {self.server.url}", flush=True)  # no log file gets the token

    def close(self) -> None:
        """Ends the server; may be called twice."""
        if not self.server.stopping.is_set():
            self.server.close()

    def _select_node(self, name: str, patience: float) -> tuple[str, str]:
        """The full name of the node to show, and its topic of samples: those of a replay are in another namespace."""
        now = changed = time.monotonic()
        end, nodes = now + patience, {}
        # That it is the only one is known when discovery adds no other any more.
        while name not in nodes and now <= end and not (nodes and not name and now > changed + quiet_time()):
            if interrupted.wait(LOOK_PERIOD):
                raise Stopped("interrupted while it looked for the node to show")
            now, before, nodes = time.monotonic(), nodes, {}
            for topic, types in self.get_topic_names_and_types():
                if cdr.SAMPLE_BLOCK in types and topic.endswith(SAMPLES):
                    for info in self.get_publishers_info_by_topic(topic):
                        if info.node_name != NAMELESS:
                            nodes.setdefault(full_name(info), []).append(topic)
            changed = changed if nodes == before else now
        if not nodes:
            problem = f"no node publishes {SAMPLES.lstrip('/')} (waited {patience:g} s)"
            raise BearingTwinError(f"{problem}: start a sim_node or a replay_node")
        if len(nodes) > 1 and not name:
            raise BearingTwinError(f"{', '.join(sorted(nodes))} publish samples: name the one to show")
        node = name or next(iter(nodes))
        if node not in nodes:
            raise BearingTwinError(f"no node {echo(name)} publishes samples; {legal_hint(name, sorted(nodes))}")
        if len(nodes[node]) > 1:
            raise BearingTwinError(f"{node} publishes {', '.join(sorted(nodes[node]))}: play a log of one bearing")
        return node, nodes[node][0]

    # Callbacks

    @guarded
    def _on_scene(self, message):
        before = self._run
        if before is None or message.data != before.scene_text:
            self._run = LiveRun(message.data)
            self._described.set()
            if before is not None:
                self._begin_again()

    @guarded
    def _on_look(self):
        watched = bool(self.feed.viewers) or time.monotonic() - self._requested < REQUESTED_FOR
        if watched and not self._listening:
            samples, quality = f"{self._namespace}{SAMPLES}", qos_profile(Qos(DEPTH))
            kind = interface(cdr.SAMPLE_BLOCK, "msg")
            # With events a subscription that is destroyed here ends the turn in which the executor collects them.
            quiet = {"event_callbacks": SubscriptionEventCallbacks(use_default_callbacks=False)}
            self._listening = [
                self.create_subscription(kind, samples, self._on_samples, quality, raw=True, **quiet),
                self.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, quality, **quiet),
            ]
        elif not watched and self._listening:
            for subscription in self._listening:
                self.destroy_subscription(subscription)
            self._listening, self._refused = [], ""
            self._shown.clear()

    @guarded
    def _on_samples(self, data):
        if self._run is None:
            return
        try:
            event = self._run.frames(data, time.monotonic())
        except RunRestarted:
            self._begin_again()
            return
        if event:
            self._shown.set()
            self.feed.send("frames", event)

    @guarded
    def _on_diagnostics(self, array):
        for status in array.status[:1]:  # which any peer can send
            if status.name.partition(":")[0] == self._watched.lstrip("/"):
                values = {pair.key: pair.value for pair in status.values}
                pace = values.get("real_time_factor", "")
                pace_text = f" at {pace[:5]} × real time" if pace and status.message in MOVING else ""
                self.feed.send("status", textwrap.shorten(f"{status.message}{pace_text}", LONGEST, placeholder=" …"))
                refused, before = values.get("commands_refused", ""), self._refused
                self._refused = refused
                if before not in ("", refused) and refused != "0":
                    reason = textwrap.shorten(values.get("last_refusal", ""), LONGEST, placeholder=" …")
                    self.feed.send("refused", reason)
                requested, problem = read_number(values.get("wanted_real_time_factor"))
                if not problem:
                    self.feed.send("pace", f"{requested:g}")

    def _begin_again(self) -> None:
        self._shown.clear()
        self.feed.send("again", "the run has begun again")

    # Called by the server's threads

    def page(self) -> bytes:
        """The page of the run as it is now."""
        self._requested = time.monotonic()
        reason = "has not published its scene yet; this page reloads until it has"
        if self._described.wait(COMING):
            if self._shown.wait(COMING):
                return live_page(self._run, self._watched)
            reason = "publishes no samples: it may be paused, preparing or at its end; this page reloads until it does"
        raise RequestRefused(HTTPStatus.SERVICE_UNAVAILABLE, f"{self._watched} {reason}")

    def execute(self, command: Mapping[str, Any]) -> str:
        """Carries out {"do": "speed" | "load" | "pace" | "pause" | "reset", ...}."""
        action, legal = command.get("do"), ("speed", "load", "pace", "pause", "reset")
        if action not in legal:
            raise BearingTwinError(f"{echo(action)} is no command; {legal_hint(str(action), legal)}")
        return getattr(self, f"_execute_{action}")(command)

    def _execute_speed(self, command) -> str:
        speed = number_of(command, "value", "speed")
        check_speed(speed)
        self._send(self._speed, Float64(data=speed))
        unit, factor = readable_unit("rad/s", abs(speed))
        return f"speed {factor * speed:.6g} {unit} sent"

    def _execute_load(self, command) -> str:
        message = WrenchStamped()
        force, torque = message.wrench.force, message.wrench.torque
        force.x, force.y, force.z = vector_of(command, "force")
        torque.x, torque.y, torque.z = vector_of(command, "torque") if "torque" in command else (0.0, 0.0, 0.0)
        self._send(self._load, message)
        return f"load {force.x:g}, {force.y:g}, {force.z:g} N sent"

    def _execute_pace(self, command) -> str:
        pace = number_of(command, "value", "pace")
        for name in PACES:
            request = SetParameters.Request(parameters=[Parameter(name, value=pace).to_parameter_msg()])
            [result] = self._call(self._set, request).results
            if result.successful or "undeclared" not in result.reason:  # else it is another kind of node
                break
        if not result.successful:
            raise BearingTwinError(result.reason or f"{self._watched} has no pace parameter")
        return f"{pace:g} times real time"

    def _execute_pause(self, command) -> str:
        paused = command.get("on")
        if not isinstance(paused, bool):
            raise BearingTwinError('pause needs "on", true or false')
        return self._outcome(self._call(self._pause, SetBool.Request(data=paused)))

    def _execute_reset(self, command) -> str:
        return self._outcome(self._call(self._reset, Trigger.Request()))

    def _send(self, publisher, message) -> None:
        if not publisher.get_subscription_count():
            raise BearingTwinError(f"{self._watched} does not subscribe to {publisher.topic_name} with this scene")
        publisher.publish(message)

    def _call(self, client, request):
        if not client.service_is_ready():
            raise BearingTwinError(f"there is no service {client.srv_name}: {self._watched} does not offer it")
        answered = threading.Event()
        future = client.call_async(request)
        future.add_done_callback(lambda _: answered.set())
        if not answered.wait(ANSWER):
            client.remove_pending_request(future)
            raise BearingTwinError(f"{client.srv_name} did not answer within {ANSWER:g} s")
        return future.result()

    @staticmethod
    def _outcome(response) -> str:
        if not response.success:
            raise BearingTwinError(response.message or "it was refused")
        return response.message or "done"
