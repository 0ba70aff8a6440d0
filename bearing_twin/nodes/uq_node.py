"""uq_node: runs studies on request, by the action `run_study`: one at a time, while a few goals wait."""

import sys
import threading
from concurrent.futures import ThreadPoolExecutor, wait

from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from std_msgs.msg import String

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.log.bag import Qos
from bearing_twin.log.study_log import NAMESPACE
from bearing_twin.nodes.base_node import LOG_PERIOD, BaseNode, declare, guarded
from bearing_twin.nodes.messages import DIAGNOSTICS_PERIOD, OK, SERVICE, WARN, RunStudy, qos_profile
from bearing_twin.nodes.node_parameters import ALLOW_INVALID, NodeParameter
from bearing_twin.nodes.studies import CANCELLED, SUCCEEDED, Goal, GoalAnswer, Studies, StudyLimits, aborted

PARAMETERS = (
    NodeParameter("log_folder", "studies", "folder of a log (MCAP) of every study with all its samples; empty = none"),
    NodeParameter("memory", 2e9, "a study that needs more is refused", "B", 1e6, 1e12),
    NodeParameter("workers", 0, "most processes of a study; 0 = one for each processor", "", 0, 512),
    NodeParameter("time_limit", 3600.0, "a study that runs longer is ended, with a log of its samples", "s", 1.0, 1e6),
    NodeParameter("samples", 0, "a study with more is refused; 0 = as many as memory allows", "", 0, 2**30),
    NodeParameter("log_quota", 1e10, "of logs in log_folder; beyond it none is added; 0 = no limit", "B", 0.0, 1e15),
    NodeParameter("study_folders", [], "folders of the files that a goal may name; empty = only those shipped"),
    NodeParameter(
        "executors",
        ["processes"],
        "where a study may run; a Dask scheduler (dask://host:port) that is named here can run any code in this node",
    ),
    NodeParameter(ALLOW_INVALID, False, "let studies run models outside their ranges, marked"),
)
QUEUE = 4  # goals that may wait while a study runs
RESULT_TIMEOUT = 30  # s for which a result can be requested again
LATCHED = Qos(depth=1, durability="transient_local")
SWITCH = 0.0005  # s for which a study may hold the interpreter while a callback waits; the default of 5 ms adds up
CANCELLED_EARLY = GoalAnswer(CANCELLED, "cancelled while it waited", stopped_because=CANCELLED)
CANCELLED_LATE = GoalAnswer(CANCELLED, "cancelled; the study still computes its statistics", stopped_because=CANCELLED)
CANCEL_PERIOD, CANCEL_TIMEOUT = 0.02, 0.25  # s between checks for a cancel; until it is answered, ended or not
CLOSE_TIMEOUT = 30.0  # s for the statistics and the log of a study that is ended


class UqNode(BaseNode):
    """Serves the action run_study; see PARAMETERS. Raises BearingTwinError for parameters it cannot use.

    A goal is read when it is accepted. Studies run one after the other in the one thread of a pool, while each goal
    waits for its own in a thread of the executor.
    """

    def __init__(self, **options):
        sys.setswitchinterval(SWITCH)
        super().__init__("uq_node", "studies", **{"namespace": NAMESPACE} | options)
        values = declare(self, PARAMETERS)
        limits = StudyLimits(**{name: values[name] for name in StudyLimits._fields})
        self.studies = Studies(values["log_folder"], limits, values["study_folders"])
        self._lock, self._accepted = threading.Lock(), 0  # goals that are not answered yet
        self._pool, self._runs = ThreadPoolExecutor(1), set()  # futures of studies that wait or run
        self._result = self.create_publisher(String, "study_result", qos_profile(LATCHED))
        group = ReentrantCallbackGroup()
        self._server = ActionServer(
            self,
            RunStudy,
            "run_study",
            self._on_execute,
            callback_group=group,
            goal_callback=self._on_goal,
            cancel_callback=lambda goal_handle: CancelResponse.ACCEPT,
            goal_service_qos_profile=SERVICE,
            result_service_qos_profile=SERVICE,
            cancel_service_qos_profile=SERVICE,
            result_timeout=RESULT_TIMEOUT,
        )
        self.every(DIAGNOSTICS_PERIOD, self._on_diagnostics, group)
        self.get_logger().info("ready for goals of the action run_study")

    def close(self) -> None:
        """Ends the running study, with a log of its samples so far; may be called twice."""
        self.studies.closing = True
        self._pool.shutdown(wait=False, cancel_futures=True)
        wait(self._runs, CLOSE_TIMEOUT)

    def destroy_node(self) -> None:
        self._server.destroy()
        super().destroy_node()

    def _on_goal(self, goal) -> GoalResponse:
        with self._lock:
            if self._accepted <= QUEUE:
                self._accepted += 1
                return GoalResponse.ACCEPT
        reason = f"a study runs and {QUEUE} wait, so the queue is full: try again when one has ended"
        self.studies.note_refusal(reason)
        self.get_logger().warning(f"goal refused: {reason}", throttle_duration_sec=LOG_PERIOD)
        return GoalResponse.REJECT

    def _on_execute(self, goal_handle) -> RunStudy.Result:
        try:
            answer = self._answer(goal_handle)
        except Exception as error:
            answer = aborted(error)
        with self._lock:
            self._accepted -= 1
        self.studies.note(answer)
        text = f"{answer.state}: {answer.message}" + (f"; log: {answer.log}" if answer.log else "")
        if answer.problem:
            self.get_logger().warning(text, throttle_duration_sec=LOG_PERIOD)  # any peer can send goals that fail
        else:
            self.get_logger().info(text)
        if answer.state == SUCCEEDED:
            goal_handle.succeed()
            self._result.publish(String(data=answer.summary))
        elif answer.state == CANCELLED:
            goal_handle.canceled()
        else:
            goal_handle.abort()
        return RunStudy.Result(
            success=answer.state == SUCCEEDED,
            message=answer.message,
            summary=answer.summary,
            log=answer.log,
            stopped_because=answer.stopped_because,
        )

    def _answer(self, goal_handle) -> GoalAnswer:
        """The answer to a goal, once its study has run or it was cancelled; raises for one that makes no study."""
        request, cancelled = goal_handle.request, threading.Event()
        goal = Goal(request.study, tuple(request.overrides), request.samples, request.seed)
        study = self.studies.read(goal)
        tell = lambda feedback: goal_handle.publish_feedback(RunStudy.Feedback(**feedback))  # noqa: E731
        run = self._pool.submit(self.studies.run, goal, study, cancelled.is_set, tell)
        self._runs.add(run)
        run.add_done_callback(self._runs.discard)
        while not (run.done() or goal_handle.is_cancel_requested):
            wait([run], CANCEL_PERIOD)
        if run.cancel():  # it had not begun
            return aborted(BearingTwinError("the node was ended")) if self.studies.closing else CANCELLED_EARLY
        cancelled.set()
        return run.result() if wait([run], CANCEL_TIMEOUT).done else CANCELLED_LATE

    @guarded
    def _on_diagnostics(self):
        doing, problem, values = self.studies.status()
        waiting = sum(not run.running() for run in list(self._runs))
        values |= {"doing": doing, "waiting": waiting, "queue": QUEUE}
        self.report(WARN if problem else OK, problem or doing, values)
