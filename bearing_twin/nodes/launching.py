"""Launch descriptions; imported by the launch files alone, as they need ROS 2's `launch` and `launch_ros`.

Every launch file takes the arguments `SHARED` and, by name, every parameter of its node.
"""

import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

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
from bearing_twin.nodes.node_parameters import (
    LOG_SAFETY,
    SHARED,
    Argument,
    NodeParameter,
    arguments_of,
    stay_on_this_host,
    values_given,
)
from bearing_twin.nodes.recorder_node import FRAMES
from bearing_twin.nodes.recorder_node import PARAMETERS as RECORDER
from bearing_twin.nodes.replay_node import PARAMETERS as REPLAY
from bearing_twin.nodes.sim_node import PARAMETERS as SIMULATION
from bearing_twin.nodes.uq_node import PARAMETERS as STUDIES
from bearing_twin.run.scene import load_scene

DISCOVERY = 5.0  # s that a simulation or a replay waits for its recorder
BRIDGE_PORT = 8765
SIDES = ("left", "right")
DISTANCE = NodeParameter("distance", 0.1, "from the left bearing to the right one along z of `world`", "m", -1e3, 1e3)
SIDE_ARGUMENTS = (
    Argument("scene", "bearing_6203", "scene of the left bearing"),
    Argument("scene_right", "", "scene of the right bearing; empty = the same"),
    Argument("overrides", "", "changes to both scenes, such as ['contact.normal=volumetric']"),
    Argument("frame_prefix", "", "prefix of left/ and right/ in every frame name but world"),
    *arguments_of([DISTANCE]),
)


def simulate() -> LaunchDescription:
    """A scene, its recorder and what shows it."""

    def actions(words):
        node = _simulation(words, on_exit=[Shutdown()])
        return [*_recorder(words), node, *_viewers(words, lambda: [_panels(words)])]

    return _launched(arguments_of(SIMULATION), actions)


def replay() -> LaunchDescription:
    """A replay of a log, and its recorder."""

    def actions(words):
        given = values_given(REPLAY, words) | ({"discovery": DISCOVERY} if _waits(words) else {})
        node = _node("replay_node", words, given, on_exit=[Shutdown()])
        return [*_recorder(words), node, *_viewers(words, lambda: [_panels_of_log(words)])]

    return _launched(arguments_of(REPLAY), actions)


def study() -> LaunchDescription:
    """Studies on request; what it shows beside are the default scene's topics."""

    def actions(words):
        node = _node("uq_node", words, values_given(STUDIES, words))
        return [*_recorder(words), node, *_viewers(words, lambda: [_panels({"namespace": ""})])]

    return _launched(arguments_of(STUDIES), actions)


def two_bearings() -> LaunchDescription:
    """Two bearings in one tree of frames: namespaces /left and /right, frames left/ and right/, both below `world`.

    With `namespace` and `frame_prefix` those stand in front.
    """

    def actions(words):
        distance = values_given([DISTANCE], words).get("distance", DISTANCE.default)
        both = {side: _side_words(words, side) for side in SIDES}
        found = _recorder(words, topics=[*(f"{both[side]['namespace']}/*" for side in SIDES), *FRAMES])
        for side, place in zip(SIDES, (0.0, distance), strict=True):
            found.append(_simulation(both[side]))
            found.append(_static_transform(_panels(both[side]).frame, place))
        return [*found, *_viewers(words, lambda: [_panels(one)._replace(frame="world") for one in both.values()])]

    return _launched(SIDE_ARGUMENTS, actions)


def _side_words(words: Mapping[str, str], side: str) -> dict[str, str]:
    """Launch arguments of one of two bearings."""
    scene = words["scene_right"] if side == "right" and words["scene_right"] else words["scene"]
    place = words["namespace"].strip("/")
    prefix = f"{words['frame_prefix']}{side}/"
    return {**words, "scene": scene, "namespace": f"/{place}/{side}" if place else f"/{side}", "frame_prefix": prefix}


def _panels(words: Mapping[str, str]) -> Panels:
    given = values_given(SIMULATION, words)
    default = next(one.default for one in SIMULATION if one.name == "scene")
    scene = load_scene(given.get("scene", default), [one for one in given.get("overrides", ()) if one])
    return panels(scene, words["namespace"], given.get("frame_prefix", ""))


def _panels_of_log(words: Mapping[str, str]) -> Panels:
    """The panels of the run in a log, its topics and frames named as replay_node will name them."""
    log = read_log(words["log"])
    logged = panels_of_log(log)
    if not (words["namespace"] or words["frame_prefix"]):
        return logged
    prefix = f"{words['frame_prefix']}{log.frame.removesuffix(KINDS[log.scene.kind].frame)}"
    return panels(log.scene, words["namespace"] or log.namespace, prefix)


def _launched(arguments: Sequence[Argument], actions) -> LaunchDescription:
    """The shared arguments and a node's own; `actions` gets their texts."""
    stay_on_this_host()
    declared = [
        DeclareLaunchArgument(
            one.name, default_value=one.default, description=one.meaning, choices=list(one.choices) or None
        )
        for one in (*SHARED, *arguments)
    ]
    started = OpaqueFunction(function=lambda context: actions(context.launch_configurations))
    return LaunchDescription([*declared, started])


def _waits(words: Mapping[str, str]) -> bool:
    """True if a node waits for the recorder that starts with it; its own `discovery` has precedence."""
    return bool(words["record"]) and not words.get("discovery")


def _simulation(words: Mapping[str, str], **options) -> Node:
    given = values_given(SIMULATION, words) | ({"discovery": DISCOVERY} if _waits(words) else {})
    return _node("sim_node", words, given, **options)


def _recorder(words: Mapping[str, str], **parameters) -> list[Node]:
    if not words["record"]:
        return []
    shared = {one.name: words.get(one.name, "") for one in LOG_SAFETY}
    given = values_given(RECORDER, {**shared, "log": words["record"]})
    return [_node("recorder_node", words, given | parameters)]


def _node(name: str, words: Mapping[str, str], given: Mapping[str, object], **options) -> Node:
    files = [str(share_path("config", f"{name}.yaml")), *([words["params_file"]] if words["params_file"] else [])]
    # launch_ros would read texts as YAML again: "1e3" as a number.
    kinds = {str: str, list: list[str]}
    typed = {
        key: ParameterValue(value, value_type=kinds[type(value)]) if type(value) in kinds else value
        for key, value in given.items()
    }
    return Node(
        package="bearing_twin",
        executable=name,
        namespace=words["namespace"] or None,  # launch_ros would put "" into the root, not into that of the kind
        output="screen",
        parameters=[*files, *([typed] if typed else [])],
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


def _viewers(words: Mapping[str, str], scenes: Callable[[], list[Panels]]) -> list:
    """RViz and the bridge to Foxglove, if they are requested and installed; else one sentence."""
    found = []
    if words.get("rviz") == "true":
        layout = _layout_file("bearing_twin.rviz", rviz(*scenes()))
        found.append(_if_installed("rviz:=true", "rviz2", arguments=["-d", layout]))
    if words.get("foxglove") == "true":
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
