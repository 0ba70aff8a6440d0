"""The executables: exit codes, one sentence for what the user can mend, and signals."""

import importlib
import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from ros import executable, heard, plain_node, ros_executor, spin_for, spin_until, statuses

from bearing_twin.base.paths import share_path
from bearing_twin.command.node_command import NODES
from bearing_twin.log import cdr
from bearing_twin.log.bag import raw_messages
from bearing_twin.log.run_log import read_log
from bearing_twin.log.stream import sample_range
from bearing_twin.nodes import demo
from bearing_twin.nodes.node_parameters import checked_values

ENTRY = (sys.executable, "-m", "bearing_twin.nodes.entry")


def run(name, *arguments, python=(), **environment):
    return subprocess.run(
        [sys.executable, *(python or ENTRY[1:]), name, *arguments],
        env={key: value for key, value in (os.environ | environment).items() if value is not None},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )


def without(module, *names):
    """Arguments for Python that call executables, one after another, where `module` cannot be imported."""
    hidden = f"import sys; sys.modules[{module!r}] = None"
    codes = ", ".join(f"entry.{name}()" for name in names)
    return ("-c", f"{hidden}; from bearing_twin.nodes import entry; sys.exit(*{{{codes}}})")


def one_sentence(result, *parts):
    """The only line on standard error, when the exit code is 2."""
    assert result.returncode == 2, result.stderr
    assert result.stderr.count("\n") == 1, result.stderr
    assert "Traceback" not in result.stderr
    assert all(part in result.stderr for part in parts), result.stderr


MISTAKES = (
    # words behind --ros-args, with a folder of pipes, and parts of what is said
    ("sim_node", "-p scen:=bearing_6203", "sim_node: there is no parameter 'scen'; did you mean scene?"),
    ("sim_node", "-p scene:=bearing_6204", "there is no scene 'bearing_6204'", "did you mean 6204, by"),
    ("sim_node", "-p use_sim_time:=5", "use_sim_time"),
    ("replay_node", "-p log:=/proc/self/mem", "cannot be"),
    ("replay_node", "-p log:=/nowhere/run.mcap", "replay_node: there is no log /nowhere/run.mcap"),
    ("uq_node", "-p memory:=-1.0", "uq_node: parameter memory = -1.0 must be a number in B, 1e+06 to 1e+12"),
    ("uq_node", "-p log_folder:=/proc/none", "log_folder /proc/none cannot be made"),
    ("replay_node", "-p log:={}/pipe.mcap", "pipe"),
    ("sim_node", "-p scene:={}/pipe.yaml", "pipe"),
    ("sim_node", "--params-file {}/pipe", "pipe"),
    ("sim_node", "-p log:={}/pipe.mcap", "exists and is not overwritten"),
    ("sim_node", "-p duration=2", "'-p duration=2'", "write -p NAME:=VALUE"),
    ("sim_node", "-p log", "'-p log'", "write -p NAME:=VALUE"),
    ("sim_node", "-p log:=", "'-p log:='", "write -p NAME:=VALUE"),
    ("sim_node", "--log-level loud", "the levels are debug, info"),
    ("sim_node", "scene:=bearing_6203 x:=", "x:=", "write -p NAME:=VALUE"),
    ("recorder_node", "-p log:=run.mcap:=2 -p :=x", "write -p NAME:=VALUE"),
    ("sim_node", "-r __ns:=a", "-r __ns:=/NAMESPACE"),
    ("sim_node", "-r __ns:=/a/", "namespace", "see whether -r gives a legal name"),
    ("sim_node", "-r command/speed:=command/load", "one name to two topics"),
    ("sim_node", "-r ~/pause:=~/reset", "one name to two topics or services"),
    ("sim_node", "--params-file {}/no.yaml", "YAML"),
)


@pytest.mark.parametrize(
    ("name", "arguments", "parts"), [(name, arguments, parts) for name, arguments, *parts in MISTAKES]
)
def test_a_mistake_ends_with_code_2_and_one_sentence(name, arguments, parts, here, tmp_path):
    """A pipe as a path is not waited for."""
    for suffix in ("", ".mcap", ".yaml"):
        os.mkfifo(tmp_path / f"pipe{suffix}")
    result = here(name, "--ros-args", *arguments.format(tmp_path).split())
    last = result.stderr.splitlines()[-1]  # the lines before are those of ROS itself
    assert (result.returncode, "Traceback" in result.stderr) == (2, False), result.stderr
    assert all(part in last for part in parts), result.stderr


def test_a_parameter_that_ros_would_pass_over_is_refused(here):
    result = here("sim_node", "-p", "scene:=6308", "--ros-args", "-r", "__ns:=/a")
    one_sentence(result, "-p scene:=6308 stands before --ros-args", "write --ros-args -p scene:=6308")


@pytest.mark.parametrize("name", NODES)
def test_help_is_printed_and_nothing_starts(name, here, monkeypatch):
    """Its example sets what can be set."""
    monkeypatch.setenv("ROS_DOMAIN_ID", "400")  # a domain that no node could join
    result, node = here(name, "--help"), importlib.import_module(f"bearing_twin.nodes.{name}")
    assert (result.returncode, result.stderr) == (0, "")
    assert f"ros2 run bearing_twin {name} --ros-args" in result.stdout
    assert ("changeable while it runs: *" in result.stdout) is any(not row.read_only for row in node.PARAMETERS)
    program, *_, assigned = shlex.split(result.stdout.splitlines()[-1])
    parameter, _, value = assigned.partition(":=")
    assert (program, checked_values(node.PARAMETERS, {parameter: value})[parameter]) == ("bearing_twin", value)
    assert value.endswith(".mcap") is (parameter == "log")


@pytest.mark.parametrize("name", NODES)
def test_the_parameter_file_of_a_node_gives_every_parameter_its_default(name):
    node = importlib.import_module(f"bearing_twin.nodes.{name}")
    values = yaml.safe_load(share_path("config", f"{name}.yaml").read_text(encoding="utf-8"))
    values = values[f"/**/{name}"]["ros__parameters"]
    assert checked_values(node.PARAMETERS, values) == checked_values(node.PARAMETERS, {})
    assert {row.name for row in node.PARAMETERS if row.default != ""} <= {*values}


def test_a_place_where_ros_cannot_keep_what_nodes_say_is_named(here, monkeypatch):
    """It was reported as a parameter that is wrong."""
    monkeypatch.setenv("ROS_LOG_DIR", "/proc/none")
    one_sentence(here("sim_node", "--ros-args", "-p", "scene:=two_spheres"), "/proc/none", "give a ROS_LOG_DIR")


@pytest.mark.parametrize("text", ["", "recorder: {ros__parameters: {log: a.mcap}}"])
def test_a_parameter_file_for_other_nodes_is_warned_of(text, tmp_path):
    """As of one that names a node without its namespace: its defaults would run in silence."""
    file = tmp_path / "parameters.yaml"
    file.write_text(text)
    with ros_executor() as executor:
        seen = statuses(plain_node(executor))
        with executable(executor, "uq_node", "--params-file", str(file)) as node:
            spin_until(executor, lambda: seen, "diagnostics")
            node.send_signal(signal.SIGINT)
            stderr = node.communicate(timeout=300)[1]
    assert "holds none for /bearing/uq_node; begin them with /**/uq_node: and ros__parameters:" in stderr


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_node_interrupted_while_it_imports_ends_quietly(number):
    """A signal as soon as the executable's own code runs; numpy and ROS take half a second to import."""
    program = (
        "import sys, threading, os; sys.argv = ['sim_node']; from bearing_twin.nodes import entry; import importlib\n"
        "found = importlib.import_module\n"
        f"def slow(name): os.kill(os.getpid(), {int(number)}); return found(name)\n"
        "importlib.import_module = slow\n"
        "sys.exit(entry.sim_node())"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=300, check=False)
    assert (result.returncode, result.stderr) == (0, "")


@pytest.mark.parametrize(("failure", "code"), [("None", 0), ("BearingTwinError('no disk')", 2)])
def test_a_node_that_cannot_leave_ros_ends_with_its_own_code(failure, code):
    """Destroying it never returns and holds the interpreter, as Fast DDS does now and then."""
    program = f"""
import ctypes, sys
from bearing_twin.base.errors import BearingTwinError
from bearing_twin.nodes import base_node

class Stuck(base_node.BaseNode):
    def __init__(self):
        super().__init__("stuck", "test")
        self.failure = {failure}
        self.done.set()

    def close(self):
        pass

    def destroy_node(self):
        while True:
            ctypes.PyDLL(None).pause()

base_node.LONGEST_GOODBYE = 0.1
sys.exit(base_node.run("stuck", Stuck))
"""
    result = run("", python=("-c", program))
    assert (result.returncode, result.stderr) == (code, "stuck: no disk\n" if code else "")


def test_a_missing_interface_package_is_named():
    names = "sim_node", "recorder_node", "replay_node", "uq_node"
    result = run("", python=without("bearing_twin_msgs", *names))
    for name, line in zip(names, result.stderr.splitlines(), strict=True):
        part = subprocess.CompletedProcess(name, result.returncode, "", f"{line}\n")
        one_sentence(part, f"{name}: ", "the interface package bearing_twin_msgs cannot be imported", "make setup")


def test_a_missing_ros_is_named():
    one_sentence(run("", python=without("rclpy", "sim_node")), "ROS 2 cannot be imported", "source env.bash")


def test_a_missing_python_package_is_named(here, monkeypatch):
    """By the import of a node; tests/test_journeys.py tries it where there is really none."""
    original = importlib.import_module

    def import_module(name):
        if name.endswith("uq_node"):
            raise ModuleNotFoundError("No module named 'scipy'", name="scipy")
        return original(name)

    monkeypatch.setattr(importlib, "import_module", import_module)
    one_sentence(here("uq_node"), "uq_node: the Python package scipy is not installed", "rosdep")


@pytest.mark.parametrize(
    "number",
    [signal.SIGINT, *(pytest.param(one, marks=pytest.mark.environment) for one in (signal.SIGTERM, signal.SIGHUP))],
)
def test_a_signal_ends_the_simulation_with_a_whole_log(tmp_path, number):
    path = tmp_path / "run.mcap"
    with ros_executor() as executor:
        heard_here = heard(plain_node(executor), [("/bearing/samples", cdr.SAMPLE_BLOCK)])["/bearing/samples"]
        with executable(executor, "sim_node", "-p", f"log:={path}") as node:
            spin_until(executor, lambda: heard_here or node.poll() is not None, "outputs")
            node.send_signal(number)
            stderr = node.communicate(timeout=300)[1]
        spin_for(executor, 0.5)
    assert node.returncode == 0, stderr
    samples = [sample.sequence for sample in read_log(path)]
    assert samples == list(range(len(samples)))
    assert len(samples) > 20
    ranges = [sample_range(data)[:2] for data in heard_here]
    # All that is logged was published, from when the subscriber was found.
    assert [first for first, _ in ranges[1:]] == [first + count for first, count in ranges[:-1]]
    assert sum(ranges[-1]) == len(samples)


def messages_of(path):
    """The bytes of every message of a log, by topic."""
    messages = {}
    for message in raw_messages(path):
        messages.setdefault(message.topic.name, []).append(message.data)
    return messages


@pytest.mark.environment
def test_the_demo_ends_with_a_table_a_log_and_a_picture(tmp_path):
    result = subprocess.run(
        [sys.executable, "-m", "bearing_twin.nodes.entry", "demo", "--duration", "1", "--out", str(tmp_path)],
        env=os.environ | {"COLUMNS": "80"},
        capture_output=True,
        text=True,
        timeout=3600,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    assert "samples lost: 0 recorded, 0 replayed" in result.stdout
    rows = re.findall(r"^│\s*(\d)│.*│\s*(\d+)│\s*(\d+)│$", result.stdout, re.MULTILINE)
    assert [int(ball) for ball, *_ in rows] == list(range(8))
    assert {(int(wrenches), int(lost)) for _, wrenches, lost in rows} == {(101, 0)}
    log = Path(re.search(r"^log: +(.+)$", result.stdout, re.MULTILINE)[1])
    picture = Path(re.search(r"^picture: +(.+)$", result.stdout, re.MULTILINE)[1])
    page = Path(re.search(r"^browser: +(.+)$", result.stdout, re.MULTILINE)[1])
    assert "<title>bearing_6203_load_and_speed" in page.read_text(encoding="utf-8")
    assert len(result.stdout.partition("browser:")[2].splitlines()) == 4  # the path, and what to look at
    assert [sample.sequence for sample in read_log(log)] == list(range(1001))
    recorded, replayed = (messages_of(path) for path in (log, log.with_name("replayed.mcap")))
    assert recorded == replayed  # byte for byte
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert all(len(line) <= 80 for line in result.stdout.splitlines() if line.startswith(("│", "┃")))


def test_a_part_that_fails_names_its_output_and_what_to_do(tmp_path, here, monkeypatch):
    right = demo.node_command
    monkeypatch.setattr(demo, "node_command", lambda name, wanted: right(name, {**wanted, "no_such_parameter": 1}))
    done = here("demo", "--out", str(tmp_path))
    assert done.returncode == 2, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    named = re.search(r"Its output is in (\S+_node\.txt)\. Correct the cause named there, or try again", done.stderr)
    assert "_node: " in Path(named[1]).read_text()
