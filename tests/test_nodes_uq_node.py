"""uq_node on the wire: goals, feedback, cancels, refusals, the latched result, diagnostics, and its end by signals."""

import json
import math
import os
import signal
import time
from pathlib import Path

import pytest
from ros import (
    PATIENCE,
    ActionClient,
    DiagnosticStatus,
    GoalStatus,
    RunStudy,
    String,
    executable,
    plain_node,
    qos_profile,
    ros_executor,
    spin_until,
    started,
    statuses,
    values_of,
)

from bearing_twin.log.study_log import read_study
from bearing_twin.nodes.uq_node import LATCHED, QUEUE, UqNode

pytestmark = pytest.mark.usefixtures("quick_diagnostics")

ACTION = "/bearing/run_study"
RESEND = 20.0  # s
QUICK = {"study": "spheres_alpha_4e-5", "overrides": ["sweep=", "histories=[]", "modality=no"], "samples": 500}
# One realisation of it goes on for minutes in a worker process, unless it is ended.
LONG = {"study": "bearing_6203_tolerances", "overrides": ["run.duration=20000.0", "workers=1"]}
# It goes on in the node itself, for longer than any test takes.
ENDLESS = QUICK | {"samples": 12_000_000, "overrides": [*QUICK["overrides"], "batch=1000000"]}
STATES = {
    GoalStatus.STATUS_SUCCEEDED: "succeeded",
    GoalStatus.STATUS_ABORTED: "aborted",
    GoalStatus.STATUS_CANCELED: "cancelled",
}


def client_of(executor):
    """A client of the action, in a node of its own."""
    client = ActionClient(plain_node(executor, "asker"), RunStudy, ACTION)
    spin_until(executor, client.server_is_ready, "discovery of the action")
    return client


def sent(executor, client, feedback=None, **goal):
    """The handle of a goal that has been accepted or refused.

    A server may answer before its writer has discovered the reader of a new client, and DDS drops that answer: what is
    not answered for RESEND seconds is sent again.
    """
    heard = None if feedback is None else lambda message: feedback.append((time.monotonic(), message.feedback))
    futures, resend_at = [], 0.0

    def answered():
        nonlocal resend_at
        if time.monotonic() > resend_at:
            futures.append(client.send_goal_async(RunStudy.Goal(**goal), feedback_callback=heard))
            resend_at = time.monotonic() + RESEND
        return any(future.done() for future in futures)

    spin_until(executor, answered, "answer to the goal")
    return next(future.result() for future in futures if future.done())


def outcome(executor, handle):
    """(state, result) of an accepted goal."""
    future = handle.get_result_async()
    spin_until(executor, future.done, "result")
    return STATES[future.result().status], future.result().result


def ran(executor, client, **goal):
    return outcome(executor, sent(executor, client, **goal))


def with_mark(mark):
    """Processes whose environment holds this mark: a node and all it has started."""
    processes = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            running = "Z" not in (folder / "stat").read_text().rpartition(")")[2].split()[0]
            if running and mark.encode() in (folder / "environ").read_bytes():
                processes.append(int(folder.name))
        except OSError:
            continue
    return processes


def words(process):
    """The command line of a process, empty where it has ended."""
    try:
        return Path(f"/proc/{process}/cmdline").read_text().replace("\0", " ")
    except OSError:
        return ""


def wait_until_gone(mark):
    """Waits until no process has the mark; the tracker of multiprocessing ends a moment after its parent."""
    end = time.monotonic() + PATIENCE
    while with_mark(mark):
        assert time.monotonic() < end, "a process was left behind"
        time.sleep(0.05)


def test_a_study_by_goal_is_logged_and_reaches_whoever_comes_late(tmp_path):
    feedback = []
    with ros_executor(threads=8) as executor:
        started(executor, UqNode, log_folder=str(tmp_path / "logs"))
        client = client_of(executor)
        state, result = outcome(executor, sent(executor, client, feedback, **QUICK, seed=7))
        assert (state, result.success) == ("succeeded", True)
        late, seen = plain_node(executor, "late"), []
        late.create_subscription(String, "/bearing/study_result", seen.append, qos_profile(LATCHED))
        spin_until(executor, lambda: seen, "the latched result")
    assert seen[0].data == result.summary
    assert (json.loads(result.summary)["log"], result.stopped_because) == (result.log, "all 500 samples are done")
    assert len(read_study(result.log).values) == 500
    first = feedback[0][1]
    assert 0 < first.done <= first.total == 500
    assert first.quantity in ("", "std of contact_duration")
    assert math.isfinite(first.estimate)
    assert first.seconds_left >= 0.0


def test_a_cancel_ends_worker_processes_at_once_and_the_next_study_is_served(tmp_path):
    mark = f"BEARING_TWIN_TEST={tmp_path}"
    with ros_executor(threads=8) as executor:
        started(executor, UqNode, log_folder=str(tmp_path), workers=1)
        client = client_of(executor)
        os.environ["BEARING_TWIN_TEST"] = str(tmp_path)
        try:
            handle = sent(executor, client, **LONG)
            spin_until(executor, lambda: any("spawn_main" in words(one) for one in with_mark(mark)), "a worker")
        finally:
            del os.environ["BEARING_TWIN_TEST"]
        spin_until(executor, handle.cancel_goal_async().done, "cancel")
        spin_until(executor, lambda: not any("spawn_main" in words(one) for one in with_mark(mark)), "end of workers")
        state, result = outcome(executor, handle)
        assert (state, result.stopped_because, result.success) == ("cancelled", "cancelled", False)
        assert ran(executor, client, **QUICK)[0] == "succeeded"


def test_one_runs_four_wait_in_order_the_next_is_refused_and_bad_ones_are_answered_meanwhile(capfd, monkeypatch):
    monkeypatch.setattr("bearing_twin.nodes.uq_node.LOG_PERIOD", PATIENCE)
    with ros_executor(threads=8) as executor:
        node = started(executor, UqNode, log_folder="")
        client, seen = client_of(executor), statuses(plain_node(executor))
        running = sent(executor, client, **ENDLESS)
        for goal, sentence in [
            ({"study": "spheres_alfa"}, "did you mean spheres_alpha"),
            ({"study": "scene: [\n  }"}, "is not the YAML of a study"),
            (QUICK | {"overrides": ["memory=1e5"], "samples": 100_000}, "more than its memory"),
        ]:
            state, result = ran(executor, client, **goal)
            assert (state, result.success, result.summary) == ("aborted", False, "")
            assert sentence in result.message
        assert node.studies.status()[0] == "running spheres_alpha_4e-5"
        waiting = [sent(executor, client, **QUICK, seed=seed) for seed in range(1, 1 + QUEUE)]
        assert running.accepted
        assert all(handle.accepted for handle in waiting)
        assert not sent(executor, client, **QUICK).accepted
        full = lambda: [s for s in seen if "the queue is full" in s.message]  # noqa: E731
        spin_until(executor, full, "a warning")
        assert full()[0].level == DiagnosticStatus.WARN
        values = values_of(full()[0])
        assert (values["waiting"], values["refused"], values["doing"]) == ("4", "1", "running spheres_alpha_4e-5")
        spin_until(executor, waiting[2].cancel_goal_async().done, "cancel of one that waits")
        state, result = outcome(executor, waiting.pop(2))
        assert (state, result.message) == ("cancelled", "cancelled while it waited")
        spin_until(executor, running.cancel_goal_async().done, "cancel of the one that runs")
        results = [outcome(executor, handle) for handle in waiting]
        assert [json.loads(result.summary)["seed"] for _, result in results] == [1, 2, 4]
        assert {state for state, _ in results} == {"succeeded"}
        spin_until(executor, lambda: seen[-1].level == DiagnosticStatus.OK, "all is well again")
        assert node.studies.status()[0] == "idle"
    stderr = capfd.readouterr().err  # ROS keeps every sentence in a file, and anybody can send these
    assert stderr.count("aborted: ") == 1


SIGNALS = signal.SIGINT, signal.SIGKILL, signal.SIGTERM


@pytest.mark.environment
@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_in_the_middle_of_a_study_leaves_its_log_and_no_process(tmp_path, number):
    with ros_executor() as executor:
        arguments = ("-p", f"log_folder:={tmp_path}", "-p", "workers:=1")
        with executable(executor, "uq_node", *arguments, BEARING_TWIN_TEST=str(tmp_path)) as node:
            client, feedback = client_of(executor), []
            short_runs = LONG | {"overrides": ["run.duration=0.01", "workers=1"], "samples": 10_000}
            assert sent(executor, client, feedback, **short_runs).accepted
            spin_until(executor, lambda: feedback, "the first realisations")
            assert sent(executor, client, **QUICK).accepted
            assert {*with_mark(f"BEARING_TWIN_TEST={tmp_path}")} - {node.pid}  # a fork has the environment of before
            node.send_signal(number)
            stderr = node.communicate(timeout=PATIENCE)[1]
    assert node.returncode == (0 if number != signal.SIGKILL else -signal.SIGKILL), stderr
    assert "Traceback" not in stderr
    wait_until_gone(f"BEARING_TWIN_TEST={tmp_path}")  # workers end with a node that is killed, too
    if number != signal.SIGKILL:
        [log] = tmp_path.glob("*.mcap")
        assert 0 < len(read_study(log).values) < 10_000
