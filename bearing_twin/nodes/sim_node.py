"""sim_node: runs a scene and publishes it; `bearing_twin topics SCENE` lists what.

Compilation, integration, pacing, log and publishing happen in a worker thread; the callbacks only hand commands to it.
"""

import threading
import time
from concurrent.futures import TimeoutError as StillBusy
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from bearing_twin.errors import BearingTwinError, IntegrationError, SceneError, Stopped
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import Kind
from bearing_twin.log.bag import Qos
from bearing_twin.log.raw_log import refuse_existing
from bearing_twin.log.run_log import LogWriter, choice_record
from bearing_twin.log.stream import MessageStream, topics
from bearing_twin.nodes.base_node import (
    CLOCK_PERIOD,
    Heartbeat,
    LogWatch,
    Outlet,
    acknowledged,
    declare,
    given_parameters,
    guarded,
    run,
    values_of,
    wait_for_subscribers,
)
from bearing_twin.nodes.messages import (
    DIAGNOSTICS_PERIOD,
    ERROR,
    OK,
    SERVICE,
    WARN,
    Step,
    Stiffness,
    fill_stiffness,
    interface,
    qos_profile,
)
from bearing_twin.nodes.node_parameters import ALLOW_INVALID, LOG_SAFETY, NOT_ALLOWED, THINNED, NodeParameter, safety_of
from bearing_twin.nodes.pacing import FASTEST, SLOWEST, Worker
from bearing_twin.nodes.simulation_loop import Commands, RunLogs, SimulationLoop
from bearing_twin.run.failure import write_failure
from bearing_twin.run.fidelity import refuse_outside
from bearing_twin.run.late import late_keys
from bearing_twin.run.scene import Scene, load_scene
from bearing_twin.run.simulation import Simulation
from bearing_twin.stopping import Halt

NAME = "sim_node"
PARAMETERS = (
    NodeParameter(
        "scene",
        "bearing_6203",
        "scene to run: a name, a designation such as 6308, or the path of a YAML file",
        digits=True,
    ),
    NodeParameter("overrides", [], "changes to the scene, such as contact.normal=volumetric"),
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
        "wall time from one begin of a run to the next; 0 = run once and end, -1 = begin again on ~/reset alone",
        "s",
        -1.0,
        86400.0,
    ),
    NodeParameter(
        "real_time_factor",
        1.0,
        f"wanted pace, for an impact 1e-5 or less; {FASTEST} = as fast as possible, which only the log gets without "
        "loss",
        "1",
        SLOWEST,
        1000.0,
        read_only=False,
        words=(FASTEST,),
    ),
    NodeParameter(
        ALLOW_INVALID,
        False,
        "run a model that is asked for outside its range too, every output marked; false refuses scenes that allow it",
    ),
    NodeParameter("start_paused", False, "wait at time 0 until ~/pause is called with false"),
    NodeParameter("discovery", 0.0, "wait at most this long until every topic has a subscriber", "s", 0.0, 600.0),
    NodeParameter("publish_clock", False, "publish simulation time on /clock"),
    NodeParameter(
        "load_timeout",
        0.0,
        "simulated time after which a load on command/load that no other followed is stale: the scene's own load acts "
        "again, and /diagnostics warns; 0 = it holds until replaced",
        "s",
        0.0,
        86400.0,
    ),
    NodeParameter("frame_prefix", "", "stands before the name of every frame, such as left/"),
    NodeParameter("log", "", "MCAP log written by this node, without loss; empty = none"),
    *LOG_SAFETY,
)


def looked_up(options: dict[str, Any]) -> tuple[dict[str, Any], Scene]:
    """The parameters with which a sim_node of these options will start, and their scene; raises BearingTwinError.

    Parameters are handed to a node by its full name, so nodes that live only here ask in the namespace of each kind
    until one is told its scene. A namespace of the user's is the same for all of them.
    """
    found = None
    for namespace in dict.fromkeys(kind.namespace for kind in KINDS.values()):
        asking = Node(
            NAME, namespace=namespace, **(options | {"start_parameter_services": False, "enable_rosout": False})
        )
        try:
            given = given_parameters(asking)
            values, own = values_of(asking, PARAMETERS), asking.get_namespace()
        finally:
            asking.destroy_node()
        if found is None or "scene" in given:
            found = values
        if "scene" in given or own != namespace:
            break
    allowed = [f"solver.{ALLOW_INVALID}=on"] if found[ALLOW_INVALID] else []
    scene = load_scene(found["scene"], [*filter(None, found["overrides"]), *allowed])
    if scene.allows_invalid and not allowed:
        raise SceneError(f"scene {scene.name} has solver.{ALLOW_INVALID}: on, {NOT_ALLOWED}")
    refuse_outside(scene)
    return found, scene


COMMAND_TIMEOUT = 30.0  # s after which a service answers that its command is taken, though not yet carried out
REFUSALS_APART = 1.0  # s between lines about refused commands; /diagnostics counts all
SAY_EVERY = 10  # diagnostics while kernels are compiled, for each line about it


class SimNode(Node):
    """Publishes a running scene; see PARAMETERS. Raises BearingTwinError for parameters or scenes it cannot use."""

    def __init__(self, **options):
        values, scene = looked_up(options)
        kind = KINDS[scene.kind]
        super().__init__(NAME, namespace=kind.namespace, **options)
        self.done = threading.Event()
        self.failure: Exception | None = None
        declare(self, PARAMETERS, values)
        if values["log"]:
            refuse_existing(values["log"])
        outgoing = ((topic.name, topic.ros_type, topic.qos) for topic in topics(scene))
        self._outlet = Outlet(self, outgoing, values["publish_clock"])
        self._log_path, self._logs = values["log"], RunLogs(values["log"], self._open_log)
        safety = safety_of(values)
        self._safety = safety._replace(kept_rate=0.0) if kind.brief else safety
        self._discovery, self._paused_at_start = values["discovery"], values["start_paused"]
        self._halt, self._description = Halt(), {"scene": scene.name}
        # Both are made in the worker's thread: on a new machine it compiles kernels for a minute or more first.
        self.simulation: Simulation | None = None
        self.loop: SimulationLoop | None = None
        self.ready, self._doing = threading.Event(), "compiling"
        self._started, self._looks = time.monotonic(), 0
        self._warned, self._switch, self._watch = False, "-", LogWatch(self, Path(self._log_path).parent)
        self._frame = f"{values['frame_prefix']}{kind.frame}"
        self._serve(kind)
        own_end_ns = (scene.outputs - 1) * scene.output_period_ns if kind.brief else 0
        duration_ns = round(values["duration"] * 1e9) or own_end_ns
        for late in late_keys(scene, 1e-9 * duration_ns or float("inf")):
            self.get_logger().warning(late)
        prepare = partial(self._prepare, scene, values, duration_ns)
        self.worker = Worker(self._turn, prepare, self._ended)
        self.worker.start()

    def close(self) -> None:
        """Ends the simulation and completes the log; may be called twice."""
        self._halt.end()
        # While kernels are still being compiled nothing has been computed, so there is nothing to wait for.
        if self.worker.stop(timeout=COMMAND_TIMEOUT if self.ready.is_set() else 0.0) and self.loop is not None:
            self.loop.close()

    def _serve(self, kind: Kind) -> None:
        services, steps, others = (MutuallyExclusiveCallbackGroup() for _ in range(3))
        steady = Clock(clock_type=ClockType.STEADY_TIME)  # time of the simulation must not drive its own timers
        self.create_service(SetBool, "~/pause", self._on_pause, qos_profile=SERVICE, callback_group=services)
        self.create_service(Trigger, "~/reset", self._on_reset, qos_profile=SERVICE, callback_group=services)
        self.create_service(Step, "~/step", self._on_step, qos_profile=SERVICE, callback_group=steps)
        if kind.operating_point is not None:
            answer = self._on_stiffness
            self.create_service(Stiffness, "~/stiffness", answer, qos_profile=SERVICE, callback_group=services)
        profile = qos_profile(Qos())
        for command in kind.commands():
            obey, ros_type = partial(self._on_command, command), interface(command.ros_type, "msg")
            self.create_subscription(ros_type, command.name, obey, profile, callback_group=others)
        self._heartbeat = Heartbeat(self, "simulation", self._outlet)
        self.create_timer(DIAGNOSTICS_PERIOD, self._on_diagnostics, callback_group=others, clock=steady)
        if self._outlet.has_clock:
            self.create_timer(CLOCK_PERIOD, self._on_clock, callback_group=others, clock=steady)
        self.add_post_set_parameters_callback(self._on_parameters)

    # In the worker's thread

    def _open_log(self, path: Path) -> LogWriter:
        self.get_logger().info(f"log: {path}{THINNED if self._safety.kept_rate else ''}")
        # The choice of the start: a log is opened before the run that it is for begins again.
        return LogWriter(path, self.simulation.scene, choice_record(self.simulation.choice), safety=self._safety)

    def _prepare(self, scene: Scene, values: dict, duration_ns: int) -> None:
        self.get_logger().info("loading the kernels of this scene; they are compiled once on a machine")
        self.simulation = run = Simulation(scene, self._halt)
        run.warm_up()
        self._doing = "waiting for subscribers"
        wait_for_subscribers(self._outlet.publishers, self._discovery, self.get_logger().info)
        if self.worker.stopping:
            return
        make_stream = partial(MessageStream, scene, choice=run.choice, frame_prefix=values["frame_prefix"])
        commands = Commands(round(values["load_timeout"] * 1e9), values["frame_prefix"])
        timing = values["real_time_factor"], duration_ns, self._logs.begin, round(values["repeat"] * 1e9)
        loop = SimulationLoop(run, make_stream, self._outlet.deliver, *timing, self._outlet.listened_to, commands)
        loop.paced.tick, loop.paced.paused = self._outlet.tick, self._paused_at_start
        loop.tells_time = self._outlet.has_clock
        self.loop, self._doing = loop, "computing"
        self.ready.set()
        said = f"{scene.name} by {run.choice.law} and {run.choice.stepper}, ready after {self._seconds():.1f} s"
        self.get_logger().info(said)
        for warned in run.choice.warnings:
            self.get_logger().warning(warned)

    def _turn(self, now: int) -> int | None:
        wake_at = self.loop.turn(now)
        if self.loop.over and not self.done.is_set():
            acknowledged(self._outlet.publishers)
            self._report()
            self.get_logger().info(f"done at {self.loop.time_ns * 1e-9:.6f} s, {self._outlet.published} messages")
            self.done.set()
        return wake_at

    def _ended(self, error: Exception | None) -> None:
        if error is not None and not isinstance(error, Stopped) and self.context.ok():
            if left := isinstance(error, IntegrationError) and write_failure(error, Path(self._log_path).parent):
                error = BearingTwinError(f"{error}; look into it: bearing_twin explain {left}")
            self.failure = error
            self._publish_status(ERROR, str(error), {})
            self.done.set()

    # Callbacks

    def _post(self, command: str, *arguments):
        """Has the worker call this method of the loop, which may not be there yet, soon; returns the future."""
        future = self.worker.post(lambda now: getattr(self.loop, command)(now, *arguments))
        self._halt.interrupt()
        return future

    def _taken(self) -> str:
        """Why a command is not yet carried out; it will be."""
        if self.ready.is_set():
            return "taken: it is carried out when the computation under way is done"
        return f"taken: it is carried out when the kernels are compiled ({self._seconds():.0f} s so far)"

    def _command(self, command: str, *arguments) -> str:
        future = self._post(command, *arguments)
        try:
            if self.ready.is_set():
                return future.result(timeout=COMMAND_TIMEOUT)
        except StillBusy:
            pass
        future.add_done_callback(self._say_failure)
        return self._taken()

    def _say_failure(self, future) -> None:
        error = future.exception()
        if error is not None and self.context.ok():
            self.get_logger().error(f"a command that was taken could not be carried out: {error}")

    @guarded
    def _on_pause(self, request, response):
        response.message = self._command("pause", request.data)
        response.success = True
        return response

    @guarded
    def _on_reset(self, request, response):
        response.message = "; ".join(filter(None, (self._command("reset"), self._logs.doubt)))
        response.success = True
        return response

    @guarded
    def _on_step(self, request, response):
        response.time_ns = self._time_ns
        future = self._post("step", request.duration)
        try:
            response.message = future.result(timeout=COMMAND_TIMEOUT)
        except StillBusy:
            # A step answers with the time it ended at, so it is not left for later unless it is under way.
            if future.cancel():
                raise BearingTwinError(
                    f"the node is still {self._doing} ({self._seconds():.0f} s so far) and has not stepped; ask "
                    "again when /diagnostics says paused"
                ) from None
            response.message = self._taken()
        response.time_ns = self._time_ns
        response.success = True
        return response

    @guarded
    def _on_stiffness(self, request, response):
        future = self._post("operating_point")
        try:
            sample, point = future.result(timeout=COMMAND_TIMEOUT if self.ready.is_set() else 0.0)
        except StillBusy:
            future.cancel()
            raise BearingTwinError(f"the node is still {self._doing} ({self._seconds():.0f} s so far)") from None
        return fill_stiffness(response, sample, point, self._frame)

    @guarded
    def _on_command(self, command, message):
        self._post("obey", command, message).add_done_callback(self._say_refusal)

    def _say_refusal(self, future) -> None:
        error = future.exception()
        if isinstance(error, BearingTwinError) and self.context.ok():
            self.get_logger().warning(str(error), throttle_duration_sec=REFUSALS_APART)
        elif error is not None:
            self._say_failure(future)

    @guarded
    def _on_parameters(self, parameters):
        for parameter in parameters:
            if parameter.name == "real_time_factor":
                self._post("set_factor", parameter.value)

    @guarded
    def _on_clock(self):
        if self.loop is None or self.loop.paced.paused:
            self._outlet.tick(self._time_ns)

    @guarded
    def _on_diagnostics(self):
        if not self.done.is_set():
            self._report()

    @property
    def _time_ns(self) -> int:
        return 0 if self.loop is None else self.loop.time_ns

    def _seconds(self) -> float:
        """Since the node was made [s]."""
        return time.monotonic() - self._started

    def _report(self) -> None:
        if self.loop is None:
            self._report_start()
            return
        slow, message, numbers = self.loop.look(time.monotonic_ns())
        if slow and not self._warned:
            self._warned = True
            self.get_logger().warning(f"{message}; see /diagnostics, or lower real_time_factor or run.output_rate")
        if numbers["choice_switch"] != self._switch:
            self._switch = numbers["choice_switch"]
            self.get_logger().info(f"model: {self._switch if self._switch != '-' else 'that of the start again'}")
        listeners = min(publisher.get_subscription_count() for publisher in self._outlet.publishers)
        counts = {"messages": self._outlet.published, "least_subscribers": listeners, "logs": self._logs.count}
        doubt = "; ".join(filter(None, (self.loop.doubt(), self._logs.doubt)))
        message = f"{message}; {doubt}" if doubt else message
        level, (log_level, log_says, room) = (
            WARN if slow or doubt else OK,
            self._watch.look(self._logs if self._logs.count else None),
        )
        if log_says:
            level, message = log_level, log_says
        self._publish_status(level, message, numbers | counts | room)

    def _report_start(self) -> None:
        """Diagnostics, and now and then a line, while there is no simulation yet."""
        self._publish_status(OK, self._doing, {"elapsed_s": self._seconds()})
        self._looks += 1
        if self._looks % SAY_EVERY == 0:
            self.get_logger().info(f"{self._doing}: {self._seconds():.0f} s so far")

    def _publish_status(self, level: bytes, message: str, values: dict) -> None:
        self._heartbeat.say(level, message, values | self._description)


def main(args: list[str] | None = None) -> int:
    """The executable: exit code 0 when done, 2 with one sentence for anything it cannot use."""
    return run("sim_node", SimNode, args)
