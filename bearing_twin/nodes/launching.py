"""Launch descriptions; imported by the launch files alone, as they need ROS 2's `launch` and `launch_ros`.

Every launch file takes the arguments `SHARED` and, by name, every parameter of its node (`two_bearings`: `SIDES`).
"""

import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from ament_index_python.packages import PackageNotFoundError, get_package_prefix

try:
    from launch import LaunchDescription
    from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction, Shutdown
    from launch_ros.actions import Node
except ImportError as error:  # in a checkout a folder has the name of that package
    raise ModuleNotFoundError("launch files need ROS 2's packages launch and launch_ros; source ROS 2 first") from error
from launch_ros.parameter_descriptions import ParameterValue

from bearing_twin.base.errors import ROS_ARGS
from bearing_twin.base.paths import share_path
from bearing_twin.kinds import KINDS
from bearing_twin.log.layouts import Panels, foxglove, panels, panels_of_log, rviz
from bearing_twin.log.run_log import read_log
from bearing_twin.nodes.node_parameters import SHARED, SIDES, NodeParameter, typed, values_given
from bearing_twin.nodes.recorder_node import FRAMES
from bearing_twin.nodes.recorder_node import PARAMETERS as RECORDER
from bearing_twin.nodes.replay_node import PARAMETERS as REPLAY
from bearing_twin.nodes.sim_node import PARAMETERS as SIMULATION
from bearing_twin.nodes.uq_node import PARAMETERS as STUDIES
from bearing_twin.run.scene import load_scene

DISCOVERY = 5.0  # s that a simulation or a replay waits for its recorder
BRIDGE_PORT = 8765
TABLES = {"sim_node": SIMULATION, "replay_node": REPLAY, "uq_node": STUDIES, "recorder_node": RECORDER}


def simulate() -> LaunchDescription:
    """A scene, its recorder and what shows it."""

    def actions(words):
        node = _node("sim_node", words, _wait(words), on_exit=[Shutdown()])
        return [*_recorder(words), node, *_viewers(words, lambda: [_panels(words)])]

    return _launched(SIMULATION, actions)


def replay() -> LaunchDescription:
    """A replay of a log, and its recorder."""

    def actions(words):
        node = _node("replay_node", words, _wait(words), on_exit=[Shutdown()])
        return [*_recorder(words), node, *_viewers(words, lambda: [_panels_of_log(words)])]

    return _launched(REPLAY, actions)


def study() -> LaunchDescription:
    """Studies on request; what it shows beside are the default scene's topics."""

    def actions(words):
        return [*_recorder(words), _node("uq_node", words), *_viewers(words, lambda: [_panels({"namespace": ""})])]

    return _launched(STUDIES, actions)


def two_bearings() -> LaunchDescription:
    """Two bearings in one tree of frames: namespaces /left and /right, frames left/ and right/, both below `world`.

    With `namespace` and `frame_prefix` those stand in front.
    """

    def actions(words):
        both, place = [], words["namespace"].strip("/")
        for side, scene in (("left", words.get("scene")), ("right", words.get("scene_right") or words.get("scene"))):
            own = {"namespace": f"/{place}/{side}" if place else f"/{side}"}
            own |= {"frame_prefix": f"{words.get('frame_prefix', '')}{side}/"}
            both.append(words | own | ({"scene": scene} if scene else {}))
        found = _recorder(words, topics=[*(f"{one['namespace']}/*" for one in both), *FRAMES])
        for one, at in zip(both, (0.0, words.get("distance", SIDES[-1].default)), strict=True):
            found += [_node("sim_node", one, _wait(words)), _static_transform(_panels(one).frame, at)]
        return [*found, *_viewers(words, lambda: [_panels(one)._replace(frame="world") for one in both])]

    return _launched(SIDES, actions)


def stay_on_this_host() -> None:
    """Limits discovery of nodes started by this process to this machine, unless the environment sets a range."""
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")


def _launched(table: Sequence[NodeParameter], actions: Callable[[dict], list]) -> LaunchDescription:
    """The shared arguments and those of `table`, empty where it is left to the node and its parameter file.

    `actions` gets the values of the shared ones, and of others those that are given.
    """
    stay_on_this_host()
    table = (*SHARED, *table)
    declared = [
        DeclareLaunchArgument(
            one.name, default_value="", description=f"{one.description} [default: {typed(one.default)}]"
        )
        for one in table
    ]
    shared = {one.name: one.default for one in SHARED}
    started = OpaqueFunction(function=lambda at: actions(shared | values_given(table, at.launch_configurations)))
    return LaunchDescription([*declared, started])


def _panels(words: Mapping) -> Panels:
    scene = load_scene(words.get("scene", SIDES[0].default), [one for one in words.get("overrides", ()) if one])
    return panels(scene, words["namespace"], words.get("frame_prefix", ""))


def _panels_of_log(words: Mapping) -> Panels:
    """The panels of the run in a log, its topics named as replay_node will name them."""
    log = read_log(words["log"])
    if not words["namespace"]:
        return panels_of_log(log)
    return panels(log.scene, words["namespace"], log.frame.removesuffix(KINDS[log.scene.kind].frame))


def _wait(words: Mapping) -> dict:
    """A node waits for the recorder that starts with it; its own `discovery` has precedence."""
    return {"discovery": DISCOVERY} if words["record"] and "discovery" not in words else {}


def _recorder(words: Mapping, **parameters) -> list[Node]:
    return [_node("recorder_node", words, {"log": words["record"]} | parameters)] if words["record"] else []


def _node(name: str, words: Mapping, parameters: Mapping = MappingProxyType({}), **options) -> Node:
    """A node with the parameters of its table that are given, and these."""
    files = [str(share_path("config", f"{name}.yaml")), *([words["params_file"]] if words["params_file"] else [])]
    given = {one.name: words[one.name] for one in TABLES[name] if one.name in words} | dict(parameters)
    # launch_ros would read texts as YAML again: "1e3" as a number.
    kinds = {str: str, list: list[str]}
    given = {
        key: ParameterValue(value, value_type=kinds[type(value)]) if type(value) in kinds else value
        for key, value in given.items()
    }
    return Node(
        package="bearing_twin",
        executable=name,
        namespace=words["namespace"] or None,  # launch_ros would put "" into the root, not into that of the kind
        output="screen",
        parameters=[*files, *([given] if given else [])],
        arguments=[ROS_ARGS, "--log-level", words["log_level"]],
        **options,
    )


def _static_transform(frame: str, height: float):
    words = {"--z": height, "--frame-id": "world", "--child-frame-id": frame}
    return _if_installed(
        f"place of {frame} in world",
        "tf2_ros",
        executable="static_transform_publisher",
        name=f"place_of_{frame.replace('/', '_')}",
        arguments=[str(word) for pair in words.items() for word in pair],
    )


def _viewers(words: Mapping, scenes: Callable[[], list[Panels]]) -> list:
    """RViz and the bridge to Foxglove, if they are requested and installed; else one sentence."""
    found = []
    if words["rviz"]:
        layout = _layout_file("bearing_twin.rviz", rviz(*scenes()))
        found.append(_if_installed("rviz:=true", "rviz2", arguments=["-d", layout]))
    if words["foxglove"]:
        layout = _layout_file("bearing_twin.foxglove.json", foxglove(scenes()[0]))
        bridge = {"address": "127.0.0.1", "port": BRIDGE_PORT}
        found.append(_if_installed("foxglove:=true", "foxglove_bridge", parameters=[bridge]))
        if isinstance(found[-1], Node):
            found.append(LogInfo(msg=f"in Foxglove open ws://localhost:{BRIDGE_PORT} and import the layout {layout}"))
    return found


def _layout_file(name: str, content: bytes) -> str:
    path = Path(tempfile.mkdtemp(prefix="bearing_twin_")) / name
    path.write_bytes(content)
    return str(path)


def _if_installed(argument: str, package: str, executable: str = "", **options):
    """A program of a package, by default the one named as it; or a message that it is not installed."""
    try:
        get_package_prefix(package)
    except PackageNotFoundError:
        debian = f"ros-jazzy-{package.replace('_', '-')}"
        return LogInfo(msg=f"{argument}: {package} is not installed, so it is not started (Debian: {debian})")
    return Node(package=package, executable=executable or package, output="screen", **options)
