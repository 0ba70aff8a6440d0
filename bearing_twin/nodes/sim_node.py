"""sim_node: runs a scene and publishes it; `bearing_twin topics SCENE` lists what.

Integration, pacing, log and publishing happen in a worker thread; the callbacks only hand commands to it.
"""

import dataclasses
import math
import time
from collections.abc import Callable
from concurrent.futures import wait
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from rclpy._rclpy_pybind11 import InvalidHandle
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from bearing_twin.base.errors import BearingTwinError, IntegrationError, LogError, SceneError, Stopped
from bearing_twin.base.stopping import Halt
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import Kind
from bearing_twin.kinds.error_estimates import unchecked
from bearing_twin.log.bag import Qos
from bearing_twin.log.raw_log import refuse_existing
from bearing_twin.log.run_log import LogWriter
from bearing_twin.log.stream import choice_record, topics
from bearing_twin.nodes.base_node import (
    CLOCK_PERIOD,
    LOG_PERIOD,
    BaseNode,
    declare,
    guarded,
    parameter_overrides,
    parameter_values,
)
from bearing_twin.nodes.messages import (
    DIAGNOSTICS_PERIOD,
    ERROR,
    OK,
    SERVICE,
    WARN,
    Step,
    Stiffness,
    interface,
    qos_profile,
    stamp,
)
from bearing_twin.nodes.node_parameters import ALLOW_INVALID, LOG_SAFETY, NOT_ALLOWED, NodeParameter, safety_of
from bearing_twin.nodes.outlet import Outlet
from bearing_twin.nodes.pacing import FASTEST, SLOWEST, Worker
from bearing_twin.nodes.simulation_loop import Commands, SimulationLoop, log_path
from bearing_twin.run.failure import failure_sentence
from bearing_twin.run.scene import Scene, check_ranges, has_override, load_scene, unreached_keys
from bearing_twin.run.simulation import Simulation

NAME = "sim_node"
PARAMETERS = (
    NodeParameter(
        "scene",
        "bearing_6203",
        "scene to run: a name, a designation such as 6308, or the path of a YAML file",
    ),
    NodeParameter(
        "overrides",
        [],
        "changes to the scene, such as contact.normal=volumetric; set while it runs, they start the run again",
        read_only=False,
    ),
    NodeParameter(
        "duration",
        0.0,
        "simulated time of a run; 0 = the scene's own where its motion ends by itself, as an impact, else endless",
        "s",
        0.0,
        86400.0,
    ),
    NodeParameter(
        "repeat",
        0.0,
        "wall time from the start of a run to the next; 0 = run once and end, -1 = start again on ~/reset only",
        "s",
        -1.0,
        86400.0,
    ),
    NodeParameter(
        "real_time_factor",
        1.0,
        f"requested pace, for an impact 1e-5 or less; {FASTEST} = as fast as possible, complete only in the log",
        "1",
        SLOWEST,
        1000.0,
        read_only=False,
        alternatives=(FASTEST,),
    ),
    NodeParameter(
        ALLOW_INVALID,
        False,
        "run specified models outside their ranges too, every output marked; false refuses scenes that allow it",
    ),
    NodeParameter("start_paused", False, "wait at time 0 until ~/pause is called with false"),
    NodeParameter("discovery", 0.0, "longest wait until every topic has a subscriber", "s", 0.0, 600.0),
    NodeParameter("publish_clock", False, "publish the simulation time on /clock"),
    NodeParameter(
        "load_timeout",
        0.0,
        "simulated time after which a load on command/load is stale unless another followed: the scene's load acts "
        "again, with a warning on /diagnostics; 0 = it holds until replaced",
        "s",
        0.0,
        86400.0,
    ),
    NodeParameter("frame_prefix", "", "prefix of every frame name, such as left/"),
    NodeParameter("log", "", "complete MCAP log written by this node; empty = none"),
    *LOG_SAFETY,
)


def start_values(options: dict[str, Any]) -> tuple[dict[str, Any], Scene]:
    """The parameters with which a sim_node of these options will start, and their scene; raises BearingTwinError.

    Parameters are handed to a node by its full name, so temporary nodes read them in the namespace of each kind
    until one has its scene. A namespace of the user's is the same for all of them.
    """
    start: dict[str, Any] | None = None
    for namespace in dict.fromkeys(kind.namespace for kind in KINDS.values()):
        quiet = {"start_parameter_services": False, "enable_rosout": False}
        temporary = Node(NAME, **{"namespace": namespace} | options | quiet)
        try:
            has_scene = "scene" in parameter_overrides(temporary)
            values, actual_namespace = parameter_values(temporary, PARAMETERS), temporary.get_namespace()
        finally:
            temporary.destroy_node()
        if start is None or has_scene:
            start = values
        if has_scene or actual_namespace != namespace:
            break
    return start, scene_of(start)


def scene_of(values: dict[str, Any]) -> Scene:
    """The scene of these values of parameters, without a second run unless an override requests one.

    Raises BearingTwinError.
    """
    allowed = [f"solver.{ALLOW_INVALID}=on"] if values[ALLOW_INVALID] else []
    scene = load_scene(values["scene"], [*values["overrides"], *allowed])
    if not any(has_override(values["overrides"], key) for key in ("solver.check", "solver.companion")):
        scene = dataclasses.replace(scene, parameters=unchecked(scene.parameters))
    if scene.allows_invalid and not allowed:
        raise SceneError(f"scene {scene.name} has solver.{ALLOW_INVALID}: on, {NOT_ALLOWED}")
    check_ranges(scene)
    return scene


COMMAND_TIMEOUT = 30.0  # s until a service reports that its command cannot be carried out yet
INTERRUPT_PERIOD = 0.05  # s between interruptions of a computation by an urgent command
CLOSE_TIME = 0.25  # s for subscribers to receive the last messages
MOST_LOGS = 1000  # of one node: any peer can request a reset, which begins another


class SimNode(BaseNode):
    """Publishes a running scene; see PARAMETERS. Raises BearingTwinError for parameters or scenes it cannot use."""

    def __init__(self, **options):
        # Fast DDS can block for ever where the last node of a process ends: this one is there until ours is. It has
        # another name: the end of a node takes the name from the graph for all nodes that are called so.
        bare = {"use_global_arguments": False, "start_parameter_services": False, "enable_rosout": False}
        placeholder = Node(f"{NAME}_starting", context=options.get("context"), **bare)
        try:
            values, scene = start_values(options)
            kind = KINDS[scene.kind]
            super().__init__(NAME, "simulation", **{"namespace": kind.namespace} | options)
        finally:
            placeholder.destroy_node()
        declare(self, PARAMETERS, values, self._on_change)
        if values["log"]:
            refuse_existing(values["log"])
        outgoing = ((topic.name, topic.ros_type, topic.qos) for topic in topics(scene))
        self._outlet = Outlet(self, outgoing, values["publish_clock"])
        self._values, self._scene = values, scene
        self._log, self._logs = None, 0
        self._logged_failure: IntegrationError | None = None
        self._safety = safety_of(values | {"full": True} if kind.brief else values)
        self._halt, self._started = Halt(), time.monotonic()
        self.loop: SimulationLoop | None = None  # made in the worker's thread: the start of a run may take seconds
        self._activity = "preparing"
        self._commands = Commands(round(values["load_timeout"] * 1e9), values["frame_prefix"])
        self._serve(kind)
        own_end_ns = (scene.outputs - 1) * scene.output_period_ns if kind.brief else 0
        self._duration_ns = math.ceil(values["duration"] * 1e9) or own_end_ns
        for sentence in unreached_keys(scene, 1e-9 * self._duration_ns or float("inf")):
            self.get_logger().warning(sentence)
        self.worker = Worker(self._turn, self._prepare, self._on_end)
        self.worker.start()

    def _serve(self, kind: Kind) -> None:
        """Creates services, subscriptions and timers."""
        quick, slow, background = (MutuallyExclusiveCallbackGroup() for _ in range(3))
        offered = [
            (SetBool, "~/pause", self._on_pause, quick),
            (Trigger, "~/reset", self._on_reset, slow),
            (Step, "~/step", self._on_step, slow),
        ]
        if kind.commands():
            offered.append((Stiffness, "~/stiffness", self._on_stiffness, slow))
        for ros_type, name, answer, group in offered:
            self.create_service(ros_type, name, answer, qos_profile=SERVICE, callback_group=group)
        for command in kind.commands():
            take, ros_type = partial(self._on_command, command), interface(command.ros_type, "msg")
            self.create_subscription(ros_type, command.name, take, qos_profile(Qos()), callback_group=background)
        self.every(DIAGNOSTICS_PERIOD, self._on_diagnostics, background)
        if self._outlet.has_clock:
            self.every(CLOCK_PERIOD, self._on_clock, background)

    def close(self) -> None:
        """Ends the simulation, publishes the messages it has logged, and completes the log; may be called twice."""
        self._halt.end()
        # Before its first output a run has nothing to lose, and an impact is solved as a whole, which takes long.
        computed = self.loop is not None and self.loop.simulation.sequence >= 0
        if (self.worker.stop(COMMAND_TIMEOUT if computed else 0.0) or not computed) and self.loop is not None:
            self.loop.close()
            self._outlet.wait_for_acknowledgement(CLOSE_TIME)

    # In the worker's thread

    def _prepare(self) -> None:
        values, scene = self._values, self._scene
        simulation = Simulation(scene, self._halt)
        self._activity = "waiting for subscribers"
        self._outlet.wait_for_subscribers(values["discovery"], lambda: self.worker.stopping)
        if self.worker.stopping:
            return
        loop = SimulationLoop(
            simulation,
            self._outlet.deliver,
            values["real_time_factor"],
            self._duration_ns,
            self._open_log,
            round(values["repeat"] * 1e9),
            self._outlet.subscribed_topics,
            self._commands,
            round(1e9 / scene.parameters.run.publish_rate),
        )
        loop.tick, loop.paused = self._outlet.tick, values["start_paused"]
        self.loop, self._activity = loop, "computing"
        choice = simulation.choice
        self.get_logger().info(
            f"{scene.name} by {choice.law} and {choice.stepper}, ready after {self._seconds():.1f} s"
        )
        for warned in choice.warnings:
            self.get_logger().warning(warned)

    def _open_log(self, number: int, simulation: Simulation) -> LogWriter | None:
        """The log of run 1, 2 ... if the node writes any; raises LogError."""
        if not self._values["log"]:
            return None
        if self._logs >= MOST_LOGS:
            raise LogError(f"the node has written {MOST_LOGS} logs; start it again for more")
        path = log_path(self._values["log"], number)
        self.get_logger().info(f"log: {path}")
        self._log = LogWriter(path, simulation.scene, choice_record(simulation.choice), safety=self._safety)
        self._logs += 1
        return self._log

    def _change(self, now: int, scene: Scene) -> None:
        """Begins the run again as `scene`; raises LogError, and changes nothing, where no log can be opened."""
        simulation = Simulation(scene, self._halt)
        done = self.loop.change(now, simulation)
        self.get_logger().info(f"{scene.name} by {simulation.choice.law}: {done}")

    def _turn(self, now: int) -> int | None:
        wake_at = self.loop.turn(now)
        while self._commands.refusals:
            self.get_logger().warning(self._commands.refusals.popleft(), throttle_duration_sec=LOG_PERIOD)
        if self._commands.speed_warning:  # apart from refusals, among which the throttle would drop it
            self.get_logger().warning(self._commands.speed_warning, once=True)
        if self.loop.failure is not None and self.loop.failure is not self._logged_failure:
            self._logged_failure = self.loop.failure
            self.get_logger().error(f"{self._failure_message(self.loop.failure)}; the node waits for ~/reset")
        if self.loop.over and not self.done.is_set():
            self._outlet.wait_for_acknowledgement()
            self._report()
            self.get_logger().info(f"done at {self._time_ns * 1e-9:.6f} s, {self._outlet.published} messages")
            self.done.set()
        return wake_at

    def _on_end(self, error: Exception | None) -> None:
        if error is None or isinstance(error, Stopped):
            return
        if isinstance(error, IntegrationError):
            error = BearingTwinError(self._failure_message(error))
        with suppress(InvalidHandle):  # of a node closed before its first output, which its worker outlives
            self._publish_status(ERROR, str(error), {})
        self.fail(error)

    def _failure_message(self, error: IntegrationError) -> str:
        """The sentence of a failed run; it leaves a file, but not after more runs than there may be logs."""
        few = self.loop is None or self.loop.run <= MOST_LOGS
        return failure_sentence(error, Path(self._values["log"]).parent) if few else str(error)

    # Commands

    @guarded
    def _on_command(self, command, message):
        self._commands.offer(command, message)
        self.worker.wake()
        if self.loop is not None and time.monotonic_ns() >= self.loop.commands_at:
            self._halt.interrupt()

    def _execute(self, work: Callable, *arguments, urgent: bool = False) -> Any:
        """What `work(now, *arguments)` returns, called by the worker; raises BearingTwinError if that takes long.

        What is `urgent` interrupts the computation under way, whatever that has cost.
        """
        future = self.worker.post(work, *arguments)
        end = time.monotonic() + (COMMAND_TIMEOUT if self.loop is not None else 0.0)
        while not future.done() and (remaining := end - time.monotonic()) > 0.0:
            if urgent:
                self._halt.interrupt(always=True)
            wait([future], timeout=min(remaining, INTERRUPT_PERIOD))
        if not future.done() and future.cancel():
            raise BearingTwinError(
                f"the node is still {self._activity} ({self._seconds():.0f} s so far); ask again when /diagnostics "
                "says that it runs or is paused"
            )
        return future.result()

    @guarded
    def _on_pause(self, request, response):
        """Of many callers none waits for the computation: it will succeed."""
        if request.data and self.loop is not None:
            self.loop.paused = True  # at once: a chunk that is being computed is not published
        self.worker.post(lambda now: self.loop.pause(now, request.data))
        state = f"{'paused' if request.data else 'running'} at {self._time_ns * 1e-9:.6f} s"
        response.message = state if self.loop is not None else "accepted: carried out when the run is prepared"
        response.success = True
        return response

    @guarded
    def _on_reset(self, request, response):
        response.message = self._execute(lambda now: self.loop.reset(now), urgent=True)
        response.success = True
        return response

    @guarded
    def _on_step(self, request, response):
        response.time_ns = self._time_ns
        response.message = self._execute(lambda now: self.loop.step(now, request.duration))
        response.time_ns, response.success = self._time_ns, True
        return response

    @guarded
    def _on_stiffness(self, request, response):
        sample, point = self._execute(lambda now: self.loop.operating_point(now), urgent=True)
        response.header.stamp = stamp(sample.time_ns)
        response.header.frame_id = f"{self._values['frame_prefix']}{KINDS[self._scene.kind].frame}"
        response.sequence, response.inner_ring_speed = sample.sequence, point.speed
        response.coordinates, response.load = point.coordinates, point.loads
        response.stiffness = point.stiffness.ravel()
        response.success, response.message = True, f"at {sample.time_ns * 1e-9:.6f} s"
        return response

    def _on_change(self, name: str, value: Any) -> None:
        """Another pace; or overrides, with which the run starts again; raises for an illegal scene or other topics."""
        if name == "real_time_factor":
            self.worker.post(lambda now: self.loop.set_factor(now, value))
            return
        scene = scene_of(self._values | {name: value})
        if [topic.full_name for topic in topics(scene)] != [topic.full_name for topic in topics(self._scene)]:
            raise BearingTwinError("that changes the topics: start a new node")
        self._execute(self._change, scene, urgent=True)

    # Diagnostics

    @guarded
    def _on_clock(self):
        if self.loop is None or self.loop.paused:
            self._outlet.tick(self._time_ns)

    @guarded
    def _on_diagnostics(self):
        if not self.done.is_set():
            self._report()

    @property
    def _time_ns(self) -> int:
        return 0 if self.loop is None else self.loop.position_ns

    def _seconds(self) -> float:
        """Time since the node was made [s]."""
        return time.monotonic() - self._started

    def _report(self) -> None:
        if self.loop is None:
            self._publish_status(OK, self._activity, {"elapsed_s": self._seconds()})
            return
        slow, message, numbers = self.loop.status(time.monotonic_ns())
        held_up_by = self._outlet.slow_topic()
        if slow:
            message += held_up_by
            sentence = f"{message}; see /diagnostics, or lower real_time_factor or run.output_rate"
            self.get_logger().warning(sentence, once=True)
        listeners = min(publisher.get_subscription_count() for publisher in self._outlet.publishers)
        numbers |= {"messages": self._outlet.published, "least_subscribers": listeners, "logs": self._logs}
        warning = self.loop.warning()
        level, message = WARN if slow or warning else OK, "; ".join(filter(None, (message, warning)))
        if self.loop.failure is not None:
            level = ERROR
        if self._log is not None:
            log_level, log_says, room = self.log_status(self._log, Path(self._values["log"]).parent)
            level, message = (log_level, log_says) if log_says else (level, message)
            numbers |= room
        self._publish_status(level, message, numbers)

    def _publish_status(self, level: bytes, message: str, values: dict) -> None:
        self.report(level, message, values | {"scene": self._scene.name})
