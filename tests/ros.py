"""ROS for tests: a context and a domain of its own for each test, one executor, and waiting with a limit."""

import os
import subprocess
import sys
import time
from contextlib import contextmanager

import pytest
from processes import own_domain

if os.environ.get("BEARING_TWIN_REQUIRE_ROS"):  # a missing ROS is an error there, not a skipped test
    import bearing_twin_msgs  # noqa: F401
    import rclpy
else:
    rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not set up: make setup, source env.bash")
    pytest.importorskip("bearing_twin_msgs", reason="the interface package is not built: make setup, source env.bash")

from action_msgs.msg import GoalStatus
from bearing_twin_msgs.action import RunStudy
from bearing_twin_msgs.msg import BearingState, Contacts
from bearing_twin_msgs.srv import Step, Stiffness
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseStamped, TwistStamped, WrenchStamped
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.action import ActionClient, ActionServer
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.qos import QoSCompatibility, qos_check_compatible
from rclpy.serialization import deserialize_message, serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64, String
from std_srvs.srv import SetBool, Trigger

from bearing_twin.log.bag import Qos
from bearing_twin.nodes.messages import interface, qos_profile

# Tests import all of ROS from here, behind the check above.
__all__ = [
    "PATIENCE", "ActionClient", "ActionServer", "BearingState",
    "Clock", "Contacts", "DiagnosticArray", "DiagnosticStatus", "Float64", "GoalStatus",
    "KeyValue", "ParameterMessage", "ParameterValue", "PoseStamped", "QoSCompatibility", "Qos", "RunStudy", "SetBool",
    "SetParameters", "Step", "Stiffness", "String", "Trigger", "TwistStamped", "WrenchStamped", "call",
    "deserialize_message", "executable", "heard", "interface", "padded", "plain_node", "qos_check_compatible",
    "qos_profile", "rclpy", "ros_executor", "ros_executor_beside", "serialize_message", "spin_for", "spin_until",
    "spin_until_heard", "started", "statuses", "values_of",
]  # fmt: skip

PATIENCE = 300.0  # s: what does not come about at all ends a test, slowness does not
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
os.environ["ROS_PYTHON_CHECK_FIELDS"] = "1"


@contextmanager
def ros_executor(threads=1):
    """An executor in a context of its own; its nodes are closed and destroyed at the end."""
    context = rclpy.Context()
    with own_domain() as domain:
        rclpy.init(context=context, domain_id=domain)
        if threads == 1:
            executor = SingleThreadedExecutor(context=context)
        else:
            executor = MultiThreadedExecutor(threads, context=context)
        try:
            yield executor
        finally:
            for node in executor.get_nodes():
                if hasattr(node, "close"):
                    node.close()
                node.destroy_node()
            executor.shutdown()
            rclpy.try_shutdown(context=context)


@contextmanager
def ros_executor_beside(executor):
    """Another executor in a context of its own and the same domain, as of another process."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=executor.context.get_domain_id())
    executor_ = SingleThreadedExecutor(context=context)
    try:
        yield executor_
    finally:
        for node in executor_.get_nodes():
            node.destroy_node()
        executor_.shutdown()
        rclpy.try_shutdown(context=context)


@contextmanager
def executable(executor, name, *arguments, **environment):
    """An executable of the package as a process in the executor's domain, its `stderr` a pipe; killed at the end."""
    command = [sys.executable, "-m", "bearing_twin.nodes.entry", name, "--ros-args", *arguments]
    process_environment = os.environ | {"ROS_DOMAIN_ID": str(executor.context.get_domain_id())} | environment
    process = subprocess.Popen(command, env=process_environment, stderr=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()


def started(executor, node_class, **parameters):
    """A node of the package with these parameters, in the executor.

    A sim_node without a scene asks for it by a node in the namespace of every kind: here it is given its own.
    """
    if node_class.__name__ == "SimNode":
        parameters.setdefault("scene", "bearing_6203")
    overrides = [Parameter(name, value=value) for name, value in parameters.items()]
    node = node_class(context=executor.context, parameter_overrides=overrides)
    executor.add_node(node)
    return node


def plain_node(executor, name="test"):
    """A node of the test itself."""
    node = rclpy.create_node(name, context=executor.context)
    executor.add_node(node)
    return node


def spin_until(executor, done, event, patience=PATIENCE):
    """Spins until `done()`; fails the test, saying what was awaited, after `patience` seconds."""
    end = time.monotonic() + patience
    while not done():
        executor.spin_once(timeout_sec=0.05)
        assert time.monotonic() < end, f"{event} did not happen within {patience:.0f} s"


def spin_for(executor, seconds):
    """Spins for so long."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        executor.spin_once(timeout_sec=0.02)


def spin_until_heard(executor, lists, expected):
    """Spins until each list, by topic, is as long as that of `expected`, and then a little, for what is too much."""
    spin_until(
        executor, lambda: all(len(lists[name]) >= len(messages) for name, messages in expected.items()), "all messages"
    )
    spin_for(executor, 0.2)


def call(executor, node, service_type, name, request):
    """The answer of a service."""
    client = node.create_client(service_type, name)
    spin_until(executor, client.service_is_ready, f"service {name}")
    future = client.call_async(request)
    spin_until(executor, future.done, f"answer of {name}")
    return future.result()


def heard(node, names_and_types, depth=1000):
    """Lists, by topic, that fill with the bytes of every message from now on."""
    lists = {name: [] for name, _ in names_and_types}
    for name, ros_type in names_and_types:
        node.create_subscription(
            interface(ros_type, "msg"), name, lists[name].append, qos_profile(Qos(depth)), raw=True
        )
    return lists


def statuses(node):
    """A list that fills with every status on /diagnostics from now on."""
    seen = []
    node.create_subscription(DiagnosticArray, "/diagnostics", lambda array: seen.extend(array.status), 100)
    return seen


def values_of(status) -> dict[str, str]:
    """The values of a status by key."""
    return {pair.key: pair.value for pair in status.values}


def padded(data: bytes) -> bytes:
    """As the middleware hands it over: filled up to whole words of four bytes."""
    return bytes(data) + bytes(-len(data) % 4)
