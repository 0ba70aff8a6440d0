"""The base of all nodes of the package: parameters, guarded callbacks, status, start and end."""

import ctypes
import functools
import os
import shutil
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy._rclpy_pybind11 import RCLError
from rclpy.callback_groups import CallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.context import Context
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from rich.filesize import decimal

from bearing_twin.base.errors import BearingTwinError, Stopped
from bearing_twin.core import Function
from bearing_twin.nodes.messages import (
    ERROR,
    OK,
    WARN,
    rclpy,
)
from bearing_twin.nodes.node_parameters import (
    NodeParameter,
    ParameterError,
    check_arguments,
    checked_values,
    initialisation_hint,
)
from bearing_twin.nodes.outlet import MANY

CLOCK_PERIOD = 0.1  # s between messages of a paused clock
SETTLED = 10.0  # s of a log, after which its size in an hour is reported
LITTLE = 1e9  # B free on the disk of a log, below which a node warns
THREADS = 8  # in which callbacks run; up to five goals of uq_node wait in theirs
POLL = 0.1  # s: how soon the main thread sees that a node is done
ANSWER_PERIOD = 0.01  # s between answers of one service: a client keeps ten answers to all clients
LONGEST_GOODBYE = 5.0  # s a node that has put all away may take to leave ROS
LOG_PERIOD = 1.0  # s between log entries that peers cause: ROS keeps them in files, which must not fill the disk

_exit_at_alarm = Function("core_exit_at_alarm", None, (ctypes.c_int,))


def parameter_overrides(node: Node) -> dict[str, Any]:
    """Parameters given at start-up, including those with names that are not declared."""
    # rclpy has no public way to see these.
    return {name: parameter.value for name, parameter in node._parameter_overrides.items()}


def parameter_values(node: Node, table: Sequence[NodeParameter]) -> dict[str, Any]:
    """The values of the parameters of `table`; raises ParameterError for overrides that are illegal."""
    overrides = parameter_overrides(node)
    legal = [name for name in overrides if node.has_parameter(name) or name.startswith("qos_overrides.")]
    return checked_values(table, overrides, legal)


def declare(
    node: Node,
    table: Sequence[NodeParameter],
    values: dict[str, Any] | None = None,
    change: Callable[[str, Any], None] = lambda name, value: None,
) -> dict[str, Any]:
    """Declares the parameters of `table` and returns their values, by default `parameter_values` of the node.

    `change` carries out a new value while the node runs, or raises BearingTwinError, and the parameter is not changed.
    """
    values = parameter_values(node, table) if values is None else values
    for row in table:
        node.declare_parameter(row.name, values[row.name], _descriptor(row), ignore_override=True)
        if values[row.name] == [] and not row.read_only:
            node.set_parameters([_parameter(row.name, [])])
    changeable = {row.name: row for row in table if not row.read_only}

    def convert(changes: list[Parameter]) -> list[Parameter]:
        converted = []
        for parameter in changes:
            with suppress(KeyError, ParameterError):  # which `carry_out` reports
                parameter = _parameter(parameter.name, changeable[parameter.name].convert(parameter.value))
            converted.append(parameter)
        return converted

    def carry_out(changes: list[Parameter]) -> SetParametersResult:
        requested = {parameter.name: parameter.value for parameter in changes if parameter.name in changeable}
        try:
            values = {name: changeable[name].convert(value) for name, value in requested.items()}
            for name, value in values.items():
                change(name, value)
        except BearingTwinError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    node.add_pre_set_parameters_callback(convert)
    node.add_on_set_parameters_callback(carry_out)
    return values


def _parameter(name: str, value: Any) -> Parameter:
    """The parameter; an empty list, which ROS takes for one of bytes, is one of texts."""
    return Parameter(name, Parameter.Type.STRING_ARRAY if value == [] else None, value)


def _descriptor(row: NodeParameter) -> ParameterDescriptor:
    # `convert` refuses what is illegal, and names what is legal: ROS does neither for a text.
    options = {"dynamic_typing": True, "additional_constraints": row.legal, "read_only": row.read_only}
    if row.low is not None and not row.alternatives:
        if type(row.default) is float:
            options["floating_point_range"] = [FloatingPointRange(from_value=row.low, to_value=row.high)]
        else:
            options["integer_range"] = [IntegerRange(from_value=int(row.low), to_value=int(row.high), step=1)]
    return ParameterDescriptor(description=row.description, **options)


class BaseNode(Node):
    """A node of this package; `task` follows its name on /diagnostics.

    `done` is set when it has nothing more to do or has failed, for the reason `failure`. A subclass has `close()`,
    which loses nothing and may be called twice.
    """

    def __init__(self, name: str, task: str, **options):
        super().__init__(name, **options)
        self.done, self.failure = threading.Event(), None
        self._task, self._steady = task, Clock(clock_type=ClockType.STEADY_TIME)
        self._statuses = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._log_problem = ""
        self._log_began: tuple[float, int] | None = None  # s of the steady clock, B

    def every(self, seconds: float, callback: Callable, group: CallbackGroup | None = None) -> None:
        """Calls `callback` every so many seconds of a steady clock: time of a simulation must not drive its node."""
        self.create_timer(seconds, callback, callback_group=group, clock=self._steady)

    def fail(self, error: Exception) -> None:
        """Ends the node with its first error."""
        self.failure = self.failure or error
        self.done.set()

    def report(self, level: bytes, message: str, values: dict) -> None:
        """Publishes a status on /diagnostics; a namesake and faults of callbacks are added, and turn OK into WARN."""
        identity = self.get_name(), self.get_namespace()
        if self.get_node_names_and_namespaces().count(identity) > 1:
            # Two nodes with other names in one namespace would still publish on the same topics.
            apart = "-r __node:=NAME" if self.get_namespace() == "/" else "-r __ns:=/NAMESPACE"
            problem = f"another node has this name in this namespace: start one of them with {apart}"
            level, values = max(level, WARN), values | {"problem": problem}
            self.get_logger().warning(problem, once=True)
        if faults := getattr(self.executor, "faults", 0):
            level, values = max(level, WARN), values | {"faults": faults}
        name = f"{self.get_fully_qualified_name().lstrip('/')}: {self._task}"
        texts = {key: f"{value:.6g}" if isinstance(value, float) else str(value) for key, value in values.items()}
        pairs = [KeyValue(key=key, value=text) for key, text in texts.items()]
        status = DiagnosticStatus(level=level, name=name, message=message, hardware_id="bearing_twin", values=pairs)
        array = DiagnosticArray(status=[status])
        array.header.stamp = self.get_clock().now().to_msg()
        self._statuses.publish(array)

    def log_status(self, log, folder: Path) -> tuple[bytes, str, dict[str, float]]:
        """Level, sentence ("" if none) and numbers of a log in `folder` with `problem`, `dropped` and `bytes`."""
        if log.problem and not self._log_problem:
            self.get_logger().error(f"{log.problem}; messages are kept in memory, as many as fit")
        elif self._log_problem and not log.problem:
            self.get_logger().info(f"there is space again: the log continues, {log.dropped} messages were dropped")
        self._log_problem = log.problem
        existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
        free = shutil.disk_usage(existing).free
        shortage = f"the disk of the log has {decimal(free)} left: make room" if free < LITTLE else ""
        now, size = time.monotonic(), log.bytes
        began, at_first = self._log_began = self._log_began or (now, size)
        if now - began >= SETTLED and size > at_first and not log.problem:
            hourly = 3600.0 * (size - at_first) / (now - began)
            sentence = (
                f"the log takes {decimal(round(hourly))} an hour; the disk has room for {free / hourly:.3g} hours"
            )
            self.get_logger().info(sentence, once=True)
        level = ERROR if log.problem else WARN if shortage else OK
        numbers = {"bytes": size, "messages_dropped": log.dropped, "disk_free_bytes": float(free)}
        return level, log.problem or shortage, numbers


class Executor(MultiThreadedExecutor):
    """THREADS; an exception in a callback, as of a request that rclpy cannot read, is counted and ends no node."""

    def __init__(self, context=None):
        super().__init__(num_threads=THREADS, context=context)
        self.faults = 0

    def turn(self, node: Node) -> None:
        """Executes ready callbacks, for POLL seconds at most."""
        try:
            self.spin_once(timeout_sec=POLL)
        except Exception as error:
            self.faults += 1
            sentence = f"a request or message was discarded: {type(error).__name__}: {error}"
            node.get_logger().error(sentence, throttle_duration_sec=LOG_PERIOD)


def guarded(callback: Callable) -> Callable:
    """A method as a callback that cannot end the node: an exception is logged, a service answers success false.

    Every client of a service receives the answers to all clients and keeps ten: answers are ANSWER_PERIOD apart.
    """
    next_answer = 0.0

    @functools.wraps(callback)
    def safe(node: Node, *arguments):
        nonlocal next_answer
        response = arguments[-1] if arguments and hasattr(arguments[-1], "success") else None
        if response is not None:
            time.sleep(max(0.0, min(ANSWER_PERIOD, next_answer - time.monotonic())))
            next_answer = time.monotonic() + ANSWER_PERIOD
        try:
            return callback(node, *arguments)
        except BearingTwinError as error:
            reason = str(error)
            node.get_logger().warning(reason, throttle_duration_sec=LOG_PERIOD)
        except Exception as error:
            reason = f"{type(error).__name__}: {error}"
            node.get_logger().error(f"{callback.__name__}: {reason}", throttle_duration_sec=LOG_PERIOD)
        if response is not None:
            response.success, response.message = False, reason
        return response

    return safe


interrupted = threading.Event()
"""Set by a signal that ends this process; a constructor that waits checks it."""


def run(name: str, make_node: Callable[[], BaseNode]) -> int:
    """Runs a node until it is done, a signal ends it or it fails; returns the exit code: 0, or 2 with one sentence.

    A signal lets the node close while ROS still works, so that all it has logged is published.
    """
    node = failure = None
    interrupted.clear()

    def on_signal(*_) -> None:
        if interrupted.is_set() and node is None:  # its constructor takes long
            os._exit(2)
        interrupted.set()

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, on_signal)
    try:
        _initialise()
        node = make_node()
        if "--params-file" in sys.argv and not parameter_overrides(node):
            node_name = node.get_fully_qualified_name()
            sentence = f"the file of parameters holds none for {node_name}; begin them with /**/{node.get_name()}"
            node.get_logger().warning(f"{sentence}: and ros__parameters:")
        executor = Executor()
        executor.add_node(node)
        while not node.done.is_set() and not interrupted.is_set():
            executor.turn(node)
    except Stopped:
        pass
    except BearingTwinError as error:
        failure = error
    except OSError as error:
        failure = BearingTwinError(f"{error.filename or 'a file'} cannot be used ({error.strerror or error})")
    except RCLError as error:
        if node is not None:
            raise
        advice = "see whether -r gives a legal name, and not one name to two topics or services of different types"
        failure = BearingTwinError(f"ROS refuses the node ({_ros_sentence(error)}); {advice}")
    except Exception as error:
        if type(error).__module__ != "rclpy.exceptions":
            raise
        failure = BearingTwinError(_ros_sentence(error))
    finally:
        if node is not None:
            try:
                node.close()
            except Exception as error:
                node.fail(error)
            failure = failure or node.failure
        if failure is not None:
            print(f"{name}: {failure}", file=sys.stderr)
        code = 0 if failure is None else 2
        leave_ros(node, code)
    return code


def _initialise() -> None:
    """Initialises ROS, without its signal handlers; raises BearingTwinError for illegal arguments."""
    check_arguments(sys.argv)
    try:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # of unknown arguments the error is their list
        problem = f"ROS knows no {error}" if str(error).startswith("[") else _ros_sentence(error)
        raise BearingTwinError(f"{problem}; {initialisation_hint(str(error))}") from error


def _ros_sentence(error: Exception) -> str:
    """The text of an error of ROS in one line, without the places in its sources."""
    return str(error).partition(", at /")[0].replace("\n", " ")


def leave_ros(node: Node | None, code: int, context: Context | None = None) -> None:
    """Destroys a closed node and shuts ROS down, so that all peers are notified.

    Fast DDS 2 can block for ever there, holding the interpreter: after LONGEST_GOODBYE the process ends with its
    exit code.
    """
    sys.stderr.flush()
    with suppress(BearingTwinError):  # where its library is missing a node that needs none ends unbounded
        _exit_at_alarm(code)
        signal.setitimer(signal.ITIMER_REAL, LONGEST_GOODBYE)
    # The end of each publisher is announced to all peers: thousands end with the process instead.
    if node is not None and len(list(node.publishers)) <= MANY:
        with suppress(Exception):
            node.destroy_node()
    rclpy.try_shutdown(context=context)
    signal.setitimer(signal.ITIMER_REAL, 0.0)
