"""Nodes as processes: their ends, and what is said of those that fail. No ROS."""

import signal
import sys
import time
from pathlib import Path

import pytest

from bearing_twin.nodes.entry import ProcessError, node_command, started

LIMIT = 300.0  # s, generous: these programs end at once


def python(code):
    """The command of a program."""
    return [sys.executable, "-c", code]


def sentence(node, may_end=False):
    """What is said about a process that has ended."""
    node.process.wait(LIMIT)
    with pytest.raises(ProcessError) as error:
        node.look(may_end)
    return str(error.value)


def test_a_node_that_fails_names_its_output_and_the_next_step(tmp_path):
    code = "import sys; print('a'); print('b'); print('the disk is full', file=sys.stderr); sys.exit(2)"
    with started("sim_node", python(code), tmp_path) as node:
        said = sentence(node, may_end=True)
    assert "sim_node ended early with code 2" in said
    assert "the disk is full" in said
    assert str(tmp_path / "sim_node.txt") in said
    assert "try again" in said


def test_an_end_is_an_error_only_where_it_comes_too_early(tmp_path):
    with started("replay_node", python("pass"), tmp_path) as node:
        assert "ended early with code 0" in sentence(node)
        node.look(may_end=True)
        assert node.ended


def test_a_node_killed_from_outside_is_said_to_be(tmp_path):
    with started("sim_node", python("import time; time.sleep(600)"), tmp_path) as node:
        node.process.send_signal(signal.SIGKILL)
        assert "ended by signal SIGKILL" in sentence(node)


def test_the_body_ends_the_process_also_one_that_ignores_signals(tmp_path, monkeypatch):
    monkeypatch.setattr("bearing_twin.nodes.entry.GRACE", 0.2)
    deaf = "import signal, time; signal.signal(2, signal.SIG_IGN); print('deaf', flush=True); time.sleep(600)"
    with started("sim_node", python(deaf), tmp_path) as node:
        end = time.monotonic() + LIMIT
        while "deaf" not in node.said.read_text() and time.monotonic() < end:
            time.sleep(0.01)
        assert not node.ended
    assert node.process.returncode == -signal.SIGKILL


def test_a_node_is_started_as_its_executable():
    command = node_command("sim_node", {"scene": "no", "start_paused": True, "log": Path("a b"), "overrides": ["c=1"]})
    wanted = ['scene:="no"', "start_paused:=true", 'log:="a b"', 'overrides:=["c=1"]']
    assert command[-8:] == [word for one in wanted for word in ("-p", one)]
