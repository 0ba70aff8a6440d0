"""uq_node: studies on request, by the action `run_study`; one at a time, a few wait.

Goals are read in one thread and run in another, which starts worker processes where a study needs them. The callbacks
only pass goals on; the one that executes a goal waits for its answer.
"""

import sys
import threading
import time
from collections.abc import Callable
from functools import partial

from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_msgs.msg import String

from bearing_twin.log.bag import Qos
from bearing_twin.log.study_log import NAMESPACE
from bearing_twin.nodes.base_node import TALK, Heartbeat, declare, guarded, run
from bearing_twin.nodes.messages import DIAGNOSTICS_PERIOD, ERROR, OK, SERVICE, WARN, RunStudy, qos_profile
from bearing_twin.nodes.node_parameters import ALLOW_INVALID, NodeParameter
from bearing_twin.nodes.pacing import Worker
from bearing_twin.nodes.studies import CANCELLED, SUCCEEDED, Goal, GoalAnswer, Request, Studies, StudyLimits
from bearing_twin.uq.run import Progress

PARAMETERS = (
    NodeParameter("log_folder", "studies", "where every study is logged with all its samples (MCAP); empty = nowhere"),
    NodeParameter("memory", 2e9, "a study that needs more is refused, whatever it says itself", "B", 1e6, 1e12),
    NodeParameter("workers", 0, "processes a study may start, at most; 0 = one a processor", "", 0, 512),
    NodeParameter("time_limit", 3600.0, "a study that runs longer is ended, with a log of its samples", "s", 1.0, 1e6),
    NodeParameter("samples", 0, "a study that asks for more is refused; 0 = as many as memory allows", "", 0, 2**30),
    NodeParameter("log_quota", 1e10, "of all logs in log_folder; then a study gets none; 0 = no limit", "B", 0.0, 1e15),
    NodeParameter("study_folders", [""], "folders of study and scene files that a goal may name; empty = names alone"),
    NodeParameter(
        "executors",
        ["processes"],
        "where a study may run; a Dask scheduler (dask://host:port) that is named here can run any code in this node",
    ),
    NodeParameter(
        ALLOW_INVALID, False, "whether a study may let models that it asks for run outside their ranges, marked"
    ),
)
LOOK_PERIOD = 0.1  # s between looks for progress, and for waiting goals that have been cancelled
RESULT_TIMEOUT = 30  # s for which a result can be asked for again
LATCHED = Qos(depth=1, durability="transient_local")
SWITCH = 0.0005  # s for which a study may keep Python to itself while a callback waits; 5 ms add up in answering one
CLOSE_TIMEOUT = 30.0  # s, for the statistics and the log of a study that is ended


class UqNode(Node):
    """Serves the action run_study; see PARAMETERS. Raises BearingTwinError for parameters it cannot use."""

    def __init__(self, **options):
        super().__init__("uq_node", namespace=NAMESPACE, **options)
        self.done, self.failure = threading.Event(), None
        values = declare(self, PARAMETERS)
        limits = StudyLimits(**{name: values[name] for name in StudyLimits._fields})
        folders = [one for one in values["study_folders"] if one]
        self.studies = Studies(values["log_folder"], limits, self._answered, folders)
        self._requests: dict[bytes, Request] = {}
        self._result = self.create_publisher(String, "study_result", qos_profile(LATCHED))
        self._heartbeat = Heartbeat(self, "studies")
        # Reentrant: one callback waits for the study that runs while others take goals and cancels.
        group, steady = ReentrantCallbackGroup(), Clock(clock_type=ClockType.STEADY_TIME)
        self._server = ActionServer(
            self,
            RunStudy,
            "run_study",
            self._on_execute,
            callback_group=group,
            goal_callback=self._on_goal,
            handle_accepted_callback=self._on_accepted,
            cancel_callback=lambda goal_handle: CancelResponse.ACCEPT,
            goal_service_qos_profile=SERVICE,
            result_service_qos_profile=SERVICE,
            cancel_service_qos_profile=SERVICE,
            result_timeout=RESULT_TIMEOUT,
        )
        self.create_timer(LOOK_PERIOD, self._on_look, callback_group=group, clock=steady)
        self.create_timer(DIAGNOSTICS_PERIOD, self._on_diagnostics, callback_group=group, clock=steady)
        self._reader = Worker(lambda now: None, ended=self._ended)
        self.worker = Worker(self.studies.turn, ended=self._ended)
        self._reader.start()
        self.worker.start()
        self.get_logger().info("ready for goals of the action run_study")

    def close(self) -> None:
        """Ends the study that runs, with a log of its samples so far, and all that wait; may be called twice."""
        self.studies.close()
        self.worker.stop(timeout=CLOSE_TIMEOUT)
        self._reader.stop(timeout=1.0)
        self.studies.abandon()

    def destroy_node(self) -> None:
        self._server.destroy()
        super().destroy_node()

    # In the threads that read and run

    def _read(self, now: int, request: Request) -> None:
        self.studies.read(now, request)
        self.worker.wake()

    def _tell(self, goal_handle, progress: Progress, statistic: str) -> None:
        feedback = RunStudy.Feedback(
            done=int(progress.done),
            total=int(progress.total),
            quantity=statistic,
            estimate=float(progress.estimate),
            half_width=float(progress.half_width),
            seconds_left=float(progress.seconds_left),
        )
        self._to_ros(goal_handle.publish_feedback, feedback)

    def _answered(self, answer: GoalAnswer) -> None:
        text = f"{answer.state}: {answer.message}" + (f"; log: {answer.log}" if answer.log else "")
        if answer.problem:
            self.get_logger().warning(text, throttle_duration_sec=TALK)  # anybody can send goals that fail
        else:
            self.get_logger().info(text)
        if answer.state == SUCCEEDED:
            self._to_ros(self._result.publish, String(data=answer.summary))

    def _to_ros(self, call: Callable, *arguments) -> None:
        """Calls into ROS, whose errors must not end a study."""
        try:
            call(*arguments)
        except Exception as error:
            self.get_logger().error(f"{type(error).__name__}: {error}")

    def _ended(self, error: Exception | None) -> None:
        if error is not None:
            self.failure = error
            self.done.set()

    # Callbacks

    def _on_goal(self, goal) -> GoalResponse:
        reason = self.studies.refusal()
        if reason:
            self.get_logger().warning(f"goal refused: {reason}", throttle_duration_sec=TALK)
        return GoalResponse.REJECT if reason else GoalResponse.ACCEPT

    def _on_accepted(self, goal_handle) -> None:
        asked = goal_handle.request
        request = Request(
            Goal(asked.study, tuple(asked.overrides), asked.samples, asked.seed),
            called_off=lambda: goal_handle.is_cancel_requested,
            begin=partial(self._to_ros, goal_handle.execute),
            tell=partial(self._tell, goal_handle),
        )
        self._requests[bytes(goal_handle.goal_id.uuid)] = request
        self.studies.add(request)
        self._reader.post(self._read, request)

    def _on_execute(self, goal_handle) -> RunStudy.Result:
        request = self._requests.pop(bytes(goal_handle.goal_id.uuid))
        request.finished.wait()
        answer = request.answer
        ends = {SUCCEEDED: goal_handle.succeed, CANCELLED: goal_handle.canceled}
        self._to_ros(ends.get(answer.state, goal_handle.abort))
        return RunStudy.Result(
            success=answer.state == SUCCEEDED,
            message=answer.message,
            summary=answer.summary,
            log=answer.log,
            stopped_because=answer.stopped_because,
        )

    @guarded
    def _on_look(self):
        self.studies.look(time.monotonic_ns())

    @guarded
    def _on_diagnostics(self):
        doing, problem, values = self.studies.status()
        level, message = (WARN, problem) if problem else (OK, doing)
        if self.failure is not None:
            level, message = ERROR, str(self.failure)
        self._heartbeat.say(level, message, {"doing": doing} | values)


def main(args: list[str] | None = None) -> int:
    """The executable: exit code 0 when a signal ended it, 2 with one sentence for parameters it cannot use."""
    sys.setswitchinterval(SWITCH)
    return run("uq_node", UqNode, args)
