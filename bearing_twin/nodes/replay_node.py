"""replay_node: publishes the messages of a log again, byte for byte, at a multiple of the pace they were logged at."""

import time
from concurrent.futures import TimeoutError as StillBusy
from functools import partial

from std_srvs.srv import SetBool

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.nodes.base_node import (
    CLOCK_PERIOD,
    BaseNode,
    Outlet,
    declare,
    guarded,
    run,
    wait_for_acknowledgement,
    wait_for_subscribers,
)
from bearing_twin.nodes.messages import DIAGNOSTICS_PERIOD, ERROR, OK, SERVICE, WARN
from bearing_twin.nodes.node_parameters import NodeParameter
from bearing_twin.nodes.pacing import StreamPace, Worker
from bearing_twin.nodes.replay_loop import ReplayLoop

PARAMETERS = (
    NodeParameter("log", "", "MCAP file or bag folder to play"),
    NodeParameter("rate", 1.0, "pace, a multiple of that of the log", "1", 0.001, 1000.0, read_only=False),
    NodeParameter("start", 0.0, "where to start, from the first message", "s", 0.0, 1e9),
    NodeParameter("loop", False, "start again at the end"),
    NodeParameter("start_paused", False, "wait until ~/pause is called with false"),
    NodeParameter("discovery", 3.0, "wait at most this long until every topic has a subscriber", "s", 0.0, 600.0),
    NodeParameter("publish_clock", False, "publish the time of the log on /clock"),
    NodeParameter("frame_prefix", "", "stands before the name of every frame, such as left/; costs time"),
)
COMMAND_TIMEOUT = 5.0  # s


class ReplayNode(BaseNode):
    """Publishes a log on the topics it was logged from, or in its own namespace where it has one.

    Raises BearingTwinError for a log it cannot play.
    """

    def __init__(self, **options):
        super().__init__("replay_node", "replay", **options)
        values = declare(self, PARAMETERS)
        if not values["log"]:
            raise BearingTwinError("parameter log is empty: give the path of an .mcap file or of a bag folder")
        self.loop = ReplayLoop(
            values["log"],
            lambda message: self._outlet.deliver(message),
            values["rate"],
            round(values["start"] * 1e9),
            values["loop"],
            self.get_namespace().strip("/"),
            values["frame_prefix"],
        )
        self.loop.paced.paused = values["start_paused"]
        for sentence in self.loop.notes:
            self.get_logger().warning(sentence)
        topics = ((name, topic.ros_type, topic.qos) for name, topic in self.loop.topics.items())
        self._outlet = Outlet(self, topics, values["publish_clock"])
        self.loop.paced.tick = self._outlet.tick
        self._earlier = StreamPace(0, 0, 0, 0)
        self._warned = False
        self.create_service(SetBool, "~/pause", self._on_pause, qos_profile=SERVICE)
        self.add_post_set_parameters_callback(self._on_parameters)
        self.every(DIAGNOSTICS_PERIOD, self._on_diagnostics)
        if self._outlet.has_clock:
            self.every(CLOCK_PERIOD, self._on_clock)
        self.get_logger().info(f"{values['log']}: {len(self._outlet.publishers)} topics")
        waited_for = self._outlet.publishers, values["discovery"], self.get_logger().info
        wait = partial(wait_for_subscribers, *waited_for)
        by_ros_time = self.get_parameter("use_sim_time").value
        if by_ros_time and values["publish_clock"]:
            raise BearingTwinError("with use_sim_time the replay follows /clock, so it cannot publish_clock: set one")
        clock = (lambda: self.get_clock().now().nanoseconds) if by_ros_time else time.monotonic_ns
        self.worker = Worker(self._turn, wait, self._ended, clock)
        self.worker.start()

    def close(self) -> None:
        """Ends the replay; may be called twice."""
        self.worker.stop(timeout=COMMAND_TIMEOUT)

    # In the worker's thread

    def _turn(self, now: int) -> int | None:
        wake_at = self.loop.turn(now)
        if self.loop.paced.finished and not self.done.is_set():
            wait_for_acknowledgement(self._outlet.publishers)
            self.get_logger().info(f"done, {self._outlet.published} messages")
            self.done.set()
        return wake_at

    def _ended(self, error: Exception | None) -> None:
        if error is not None:
            self.report(ERROR, str(error), {})
            self.fail(error)

    # Callbacks

    @guarded
    def _on_pause(self, request, response):
        future = self.worker.post(self.loop.pause, request.data)
        try:
            response.message = future.result(timeout=COMMAND_TIMEOUT)
        except StillBusy:
            response.message = "taken: it is carried out when every topic has a subscriber, or the time for it is over"
        response.success = True
        return response

    @guarded
    def _on_clock(self):
        if self.loop.paced.paused and self.loop.paced.position_ns:  # where it stands still, for whoever comes late
            self._outlet.tick(self.loop.paced.position_ns)

    @guarded
    def _on_parameters(self, parameters):
        for parameter in parameters:
            if parameter.name == "rate":
                self.worker.post(self.loop.paced.set_factor, parameter.value)

    @guarded
    def _on_diagnostics(self):
        pace, requested = self.loop.paced.pacer.pace(), float(self.loop.paced.pacer.factor)
        values = {
            "real_time_factor": pace.real_time_factor(self._earlier),
            "wanted_real_time_factor": requested,
            "lag_s": pace.lag_ns * 1e-9,
            "given_up_s": pace.slipped_ns * 1e-9,
            "messages": self._outlet.published,
            "rounds": self.loop.rounds,
        }
        self._earlier = pace
        level, message = OK, "paused" if self.loop.paced.paused else "playing"
        if pace.behind:
            level, message = WARN, f"cannot keep up: {pace.lag_ns * 1e-9:.3g} s behind"
            if not self._warned:
                self._warned = True
                self.get_logger().warning(f"{message}; lower `rate`")
        self.report(level, message, values)


def main(args: list[str] | None = None) -> int:
    """The executable: exit code 0 at the end of the log or after a signal, 2 with one sentence when it cannot play."""
    return run("replay_node", ReplayNode, args)
