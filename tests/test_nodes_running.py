"""What every node does alike, on the wire: requests that ROS itself cannot read, and what the node says of them."""

import threading

import pytest
from ros import (
    DiagnosticArray,
    DiagnosticStatus,
    ParameterMessage,
    ParameterValue,
    SetParameters,
    plain_node,
    ros_executor,
    spin_until,
    started,
)

from bearing_twin.nodes import running
from bearing_twin.nodes.recorder_node import RecorderNode


def test_a_parameter_of_no_known_type_ends_no_node(tmp_path, monkeypatch):
    monkeypatch.setattr(running, "POLL", 0.02)
    with ros_executor() as others:
        executor = running.Executor(others.context)
        node = started(executor, RecorderNode, log=str(tmp_path / "run.mcap"))
        talker, seen = plain_node(others), []
        talker.create_subscription(DiagnosticArray, "/diagnostics", lambda array: seen.extend(array.status), 10)
        client = talker.create_client(SetParameters, "/recorder_node/set_parameters")

        def turned(done):
            def look():
                executor.turn(node)
                return done()

            return look

        spin_until(others, turned(client.service_is_ready), "the service")
        client.call_async(
            SetParameters.Request(parameters=[ParameterMessage(name="log", value=ParameterValue(type=250))])
        )
        spin_until(others, turned(lambda: executor.faults == 1), "the fault")

        def told():
            return any(one.key == "faults" and one.value == "1" for status in seen for one in status.values)

        spin_until(others, turned(told), "a warning")
        assert {status.level for status in seen if status.name == "recorder_node: recording"} >= {DiagnosticStatus.WARN}
        assert not node.done.is_set()
        node.close()
        node.destroy_node()
        executor.shutdown()


def test_a_clock_put_back_ends_the_wait_of_a_node(monkeypatch):
    """DDS waits until a time of the clock of the system: put back by an hour, a node heard no signal for an hour."""
    monkeypatch.setattr(running, "POLL", 0.01)
    jumps, ended, woken = [0, 0, int(3.6e12), 0, -int(3.6e12), 0], threading.Event(), []

    class Clock:
        def look(self):
            jump = jumps.pop(0)
            if not jumps:
                ended.set()
            return jump

    class Waiting:
        def wake(self):
            woken.append(len(jumps))

    running.wake_at_jumps(Waiting(), ended, Clock())
    assert woken == [1]


def test_two_nodes_of_one_name_are_told(tmp_path):
    with ros_executor() as executor:
        talker, seen = plain_node(executor), []
        talker.create_subscription(DiagnosticArray, "/diagnostics", lambda array: seen.extend(array.status), 10)
        alone = started(executor, RecorderNode, log=str(tmp_path / "one.mcap"))
        spin_until(executor, lambda: seen, "diagnostics")
        assert "problem" not in {one.key for one in seen[0].values}
        started(executor, RecorderNode, log=str(tmp_path / "two.mcap"))
        told = lambda: any(one.value == running.NAMESAKE for status in seen for one in status.values)  # noqa: E731
        spin_until(executor, told, "a warning")
        assert seen[-1].level >= DiagnosticStatus.WARN
        assert alone.failure is None


def test_a_node_that_can_do_nothing_but_fail_ends(monkeypatch):
    monkeypatch.setattr(running, "MOST_FAULTS", 3)
    with ros_executor() as others:
        executor, node = running.Executor(others.context), plain_node(others)

        def failing(timeout_sec):
            raise OSError("nothing works")

        monkeypatch.setattr(executor, "spin_once", failing)
        for _ in range(3):
            executor.turn(node)
        with pytest.raises(OSError, match="nothing works"):
            executor.turn(node)
        assert executor.faults == 4
        executor.shutdown()


def test_what_peers_send_in_floods_is_told_once_a_second(capfd):
    """Every sentence goes into a file of ROS, too: a peer could fill the disk."""
    with ros_executor() as others:

        @running.guarded
        def callback(node):
            raise ValueError("nobody can read this")

        node = plain_node(others)
        for _ in range(5):
            callback(node)
    assert capfd.readouterr().err.count("nobody can read this") == 1
