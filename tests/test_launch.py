"""Launch files: what their arguments say to nodes; and, where ROS 2's own `launch` is there, what they start."""

import os
import re
import runpy

import pytest
from doc_tables import PAGES
from ros import rclpy

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.base.paths import share_path
from bearing_twin.nodes.node_parameters import SHARED, SIDES, checked_values, launch_values
from bearing_twin.nodes.recorder_node import PARAMETERS as RECORDER
from bearing_twin.nodes.replay_node import PARAMETERS as REPLAY
from bearing_twin.nodes.sim_node import PARAMETERS as SIMULATION
from bearing_twin.nodes.uq_node import PARAMETERS as STUDIES

assert rclpy
TABLES = {"simulate": SIMULATION, "replay": REPLAY, "study": STUDIES, "two_bearings": SIDES}


@pytest.mark.parametrize("table", [SHARED, RECORDER, *TABLES.values()])
def test_every_default_is_read_again_as_it_is_typed(table):
    texts = {row.name: str(row.default) for row in table if row.default not in ("", [])}
    assert checked_values(table, launch_values(table, texts)) == {row.name: row.default for row in table}
    shared = {row.name for row in SHARED} & {row.name for row in table}
    assert not shared or table is SHARED  # else an argument would have two meanings


def test_words_become_values_of_their_type_and_empty_ones_are_left_to_the_node():
    arguments = {
        "scene": "1e3",
        "overrides": "['run.duration=1', 'contact.normal=hertz']",
        "duration": "2",
        "fsync": "True",
    }
    arguments |= {"keep_files": "3", "log": "", "record": "x.mcap"}
    assert launch_values(SIMULATION, arguments) == {
        "scene": "1e3",
        "overrides": ["run.duration=1", "contact.normal=hertz"],
        "duration": 2.0,
        "fsync": True,
        "keep_files": 3,
    }
    assert launch_values(SIMULATION, {"overrides": "run.duration=1"}) == {"overrides": ["run.duration=1"]}
    for text, sentence in {
        "duration:soon": "parameter duration = 'soon' must be a number",
        "duration:nan": "must be a number",
        "duration:-1": "must be a number in s, 0 to 86400",
        "fsync:maybe": "must be true or false",
        "keep_files:1.5": "must be a whole number",
        "overrides:[1, 2]": "must be a list of texts",
    }.items():
        with pytest.raises(BearingTwinError, match=sentence):
            launch_values(SIMULATION, dict([text.split(":")]))


def test_the_launch_files_and_their_arguments_in_the_documentation_are_these():
    files = {path.name.removesuffix(".launch.py") for path in share_path("launch").glob("*.launch.py")}
    assert files == set(TABLES)
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    commands = re.findall(r"^ros2 launch bearing_twin (\w+)\.launch\.py(.*)$", text, flags=re.MULTILINE)
    assert {name for name, _ in commands} >= {"simulate", "two_bearings"}
    for name, arguments in commands:
        assert set(re.findall(r"(\w+):=", arguments)) <= {row.name for row in (*SHARED, *TABLES[name])}, arguments


# With ROS 2's launch


def started(name, **arguments):
    """(actions that a launch file starts, context) with these arguments."""
    pytest.importorskip("launch_ros", reason="launch and launch_ros are not on PyPI: tried where a ROS 2 is installed")
    from launch import LaunchContext

    description = runpy.run_path(str(share_path("launch", f"{name}.launch.py")))["generate_launch_description"]()
    context = LaunchContext()
    for argument in description.get_launch_arguments():
        context.launch_configurations[argument.name] = "".join(part.text for part in argument.default_value)
    assert set(arguments) <= set(context.launch_configurations)
    context.launch_configurations.update(arguments)
    return description.entities[-1].execute(context), context


def executables(actions):
    """The executables of nodes, in order."""
    return [action.node_executable for action in actions if hasattr(action, "node_executable")]


def is_installed(package):
    """True if this ROS has a package; what shows or places is left out with a word where not."""
    from ament_index_python.packages import get_packages_with_prefixes

    return package in get_packages_with_prefixes()


@pytest.mark.parametrize("name", TABLES)
def test_a_launch_file_takes_what_all_take_and_starts_its_nodes(name, tmp_path, monkeypatch):
    monkeypatch.delenv("ROS_AUTOMATIC_DISCOVERY_RANGE")
    arguments = {"record": str(tmp_path / "run.mcap"), "rviz": "true", "foxglove": "true"}
    if name == "replay":
        arguments |= {"rviz": "false", "foxglove": "false", "log": "run.mcap"}
    actions, context = started(name, **arguments)
    assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    assert set(context.launch_configurations) == {one.name for one in (*SHARED, *TABLES[name])}
    nodes = {"simulate": ["sim_node"], "replay": ["replay_node"], "study": ["uq_node"]}
    two = ["sim_node", *["static_transform_publisher"] * is_installed("tf2_ros")] * 2
    started_nodes = [program for program in executables(actions) if program not in ("rviz2", "foxglove_bridge")]
    assert started_nodes == ["recorder_node", *nodes.get(name, two)]
    sentences = [action for action in actions if type(action).__name__ == "LogInfo"]
    bridged = "foxglove_bridge" in executables(actions)  # then where to look is said too
    missing = 2 * (name == "two_bearings" and not is_installed("tf2_ros"))
    viewers = len(executables(actions)) - len(started_nodes)
    assert len(sentences) + viewers == (0 if name == "replay" else 2 + bridged + missing)


def parameters_of(node):
    """The parameters of a node that its launch file gives, without those of files."""
    [values] = [entry for entry in node._Node__parameters if isinstance(entry, dict)]
    return {"".join(part.text for part in key): value for key, value in values.items()}


def test_arguments_reach_the_node_and_its_recorder():
    arguments = {"scene": "1e3", "duration": "2", "fsync": "false", "record": "two.mcap", "log": "own.mcap"}
    recorder, node = started("simulate", **arguments)[0]
    assert set(parameters_of(node)) == {"scene", "duration", "fsync", "log", "discovery"}
    assert set(parameters_of(recorder)) == {"fsync", "log"}
    assert set(parameters_of(started("simulate", **arguments, discovery="0")[0][1])) == set(parameters_of(node))
    assert set(parameters_of(started("simulate", scene="6308")[0][0])) == {"scene"}


def test_two_bearings_stand_in_a_namespace_of_the_users():
    actions, context = started("two_bearings", namespace="/cell", frame_prefix="cell/", record="two.mcap")
    nodes = [action for action in actions if getattr(action, "node_executable", "") == "sim_node"]
    for node in nodes:
        node._perform_substitutions(context)
    assert [node.node_name.rpartition("/")[0] for node in nodes] == ["/cell/left", "/cell/right"]


@pytest.mark.parametrize("name", ["simulate", "replay", "study"])
@pytest.mark.parametrize("namespace", ["", "/cell"])
def test_nodes_and_recorder_stand_in_the_namespace_given_or_where_they_stand_by_themselves(name, namespace):
    actions, context = started(name, namespace=namespace, record="run.mcap")
    nodes = [action for action in actions if hasattr(action, "node_executable")]
    assert len(nodes) == 2
    for node in nodes:
        node._perform_substitutions(context)
        assert node.expanded_node_namespace == (namespace or node.UNSPECIFIED_NODE_NAMESPACE)


def test_a_bad_word_ends_the_launch_with_its_sentence():
    with pytest.raises(BearingTwinError, match="must be a number"):
        started("simulate", duration="soon")
