"""Parameters of nodes, and nodes as processes: their ends, and what is said of those that fail. No ROS."""

import math
import signal
import sys
import time
from array import array

import pytest

from bearing_twin.nodes.entry import ProcessError, started
from bearing_twin.nodes.node_parameters import (
    LOG_SAFETY,
    NodeParameter,
    ParameterError,
    checked_values,
    safety_of,
)

TABLE = (
    NodeParameter("scene", "bearing_6203", "scene to run"),
    NodeParameter("overrides", [], "changes"),
    NodeParameter("rate", 1.0, "pace", "1", 1e-9, 10.0, alternatives=("fastest",)),
    NodeParameter("depth", 5, "messages", "", 1, 100),
    NodeParameter("loop", False, "again"),
    NodeParameter("pause", 0.0, "wait", "s", 0.0, 60.0),
    NodeParameter("designation", "x", "of a bearing"),
)


def test_defaults_and_given_values():
    assert checked_values(TABLE, {}) == {parameter.name: parameter.default for parameter in TABLE}
    overrides = {"rate": 5, "overrides": ["a=1"], "pause": "20 ms", "loop": True, "designation": 6308}
    overrides["use_sim_time"] = True
    values = checked_values(TABLE, overrides, ["use_sim_time"])
    assert type(values["rate"]) is float
    assert [values[name] for name in overrides if name in values] == [5.0, ["a=1"], 0.02, True, "6308"]
    defaults = checked_values(TABLE, {})
    assert checked_values(TABLE, {"rate": "fastest", "overrides": None}) == defaults | {"rate": "fastest"}
    for given, expected in (("a=1", ["a=1"]), (["", "a=1"], ["a=1"]), ([""], []), ("", [])):
        assert checked_values(TABLE, {"overrides": given})["overrides"] == expected
    assert checked_values(TABLE, {"pause": "1e-5"})["pause"] == 1e-5  # a text to YAML


MISTAKES = (
    ({"scen": "x"}, "there is no parameter 'scen'; did you mean scene?"),
    ({"rate": math.nan}, "rate = nan must be a number, 1e-09 to 10, or fastest"),
    ({"rate": 0}, "rate = 0 must be a number, 1e-09 to 10, or fastest"),
    ({"rate": array("q", [1, 2])}, "must be a number"),  # as ROS hands it over
    ({"rate": "fast"}, "rate = 'fast' must be a number"),
    ({"depth": 0}, "depth = 0 must be a whole number, 1 to 100"),
    ({"depth": 2.5}, "depth = 2.5 must be a whole number"),
    ({"depth": True}, "depth = True must be a whole number"),
    ({"loop": "yes"}, "loop = 'yes' must be true or false"),
    ({"scene": 3.0}, "scene = 3.0 must be text"),
    ({"overrides": 5}, "overrides = 5 must be a list of texts"),
    ({"overrides": [1]}, "overrides = [1] must be a list of texts"),
    ({"rate": "nan"}, "rate = 'nan' must be a number"),
    ({"pause": "2 N"}, "pause = '2 N' must be a number in s"),
)


def test_mistakes_are_named_all_at_once():
    for overrides, sentence in MISTAKES:
        with pytest.raises(ParameterError) as refused:
            checked_values(TABLE, overrides)
        assert sentence in str(refused.value)
    with pytest.raises(ParameterError) as refused:
        checked_values(TABLE, {"rate": -1.0, "loop": 1, "sceen": ""})
    assert all(name in str(refused.value) for name in ("rate", "loop", "sceen"))


def test_to_keep_some_files_they_must_be_several():
    values = {parameter.name: parameter.default for parameter in LOG_SAFETY}
    with pytest.raises(ParameterError, match="needs split_size or split_duration"):
        safety_of(values | {"keep_files": 3})
    assert safety_of(values | {"keep_files": 3, "split_size": 1e6}).split_bytes == 1_000_000
    assert safety_of(values).patient


LIMIT = 300.0  # s, generous: these programs end at once


def python(code):
    """The command of a program."""
    return [sys.executable, "-c", code]


@pytest.mark.parametrize(
    ("code", "may_end", "words"),
    [
        ("print('a'); sys.exit('the disk is full')", True, ("sim_node ended early with code 1", "the disk is full")),
        ("os.kill(os.getpid(), 9)", True, ("ended by signal SIGKILL",)),
        ("", False, ("ended early with code 0",)),
    ],
)
def test_a_node_that_fails_or_ends_too_early_names_its_output_and_the_next_step(code, may_end, words, tmp_path):
    with started("sim_node", python(f"import os, sys; {code}"), tmp_path) as node:
        node.wait(LIMIT)
        with pytest.raises(ProcessError) as error:
            node.check(may_end)
        if not may_end:
            node.check(may_end=True)
    output = str(error.value)
    assert all(line in output for line in (*words, str(tmp_path / "sim_node.txt"), "try again"))


def test_the_body_ends_the_process_also_one_that_ignores_signals(tmp_path, monkeypatch):
    monkeypatch.setattr("bearing_twin.nodes.entry.GRACE", 0.2)
    deaf = "import signal, time; signal.signal(2, signal.SIG_IGN); print('deaf', flush=True); time.sleep(600)"
    with started("sim_node", python(deaf), tmp_path) as node:
        end = time.monotonic() + LIMIT
        while "deaf" not in node.output.read_text() and time.monotonic() < end:
            time.sleep(0.01)
        assert node.poll() is None
    assert node.returncode == -signal.SIGKILL
