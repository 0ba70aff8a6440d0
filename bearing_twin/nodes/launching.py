"""Launch descriptions; imported by the launch files only, as they need ROS 2's `launch` and `launch_ros`.

Every launch file takes the arguments `SHARED` and, by name, every parameter of its node (`two_bearings`: `SIDES`).
"""

import json
import os
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
from bearing_twin.log.layouts import Panels, foxglove, panels, panels_of_log, rviz
from bearing_twin.log.run_log import read_log
from bearing_twin.nodes.node_parameters import SHARED, SIDES, NodeParameter, launch_values
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
    """A scene, its recorder and viewers."""
    return _launch_of_node("sim_node", _panels)


def replay() -> LaunchDescription:
    """A replay of a log, its recorder and viewers."""
    return _launch_of_node("replay_node", lambda values: panels_of_log(read_log(values["log"]), values["namespace"]))


def study() -> LaunchDescription:
    """Studies on request, and a recorder; viewers show the topics of the default scene."""
    return _launch_of_node("uq_node", lambda arguments: _panels({"namespace": ""}))


def two_bearings() -> LaunchDescription:
    """Two bearings in one tree of frames: namespaces /left and /right, frames left/ and right/, both below `world`.

    `namespace` and `frame_prefix` are put in front of them.
    """

    def actions(arguments):
        scene = arguments.get("scene")
        scenes = {"left": scene, "right": arguments.get("scene_right", scene)}
        bearings = []
        for side, scene in scenes.items():
            namespace = f"/{arguments['namespace'].strip('/')}/{side}".replace("//", "/")
            frames = {"frame_prefix": f"{arguments.get('frame_prefix', '')}{side}/"}
            bearings.append(arguments | frames | {"namespace": namespace} | ({"scene": scene} if scene else {}))
        started = _recorder(arguments, topics=[*(f"{bearing['namespace']}/*" for bearing in bearings), *FRAMES])
        for bearing, height in zip(bearings, (0.0, arguments.get("distance", SIDES[-1].default)), strict=True):
            started += [_node("sim_node", bearing), _static_transform(_panels(bearing).frame, height)]
        return started + _viewers(arguments, lambda: [_panels(bearing)._replace(frame="world") for bearing in bearings])

    return _launch_description(SIDES, actions)


def stay_on_this_host() -> None:
    """Limits discovery of nodes started by this process to this machine, unless the environment sets a range."""
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")


def _launch_of_node(name: str, panels_of: Callable[[dict], Panels]) -> LaunchDescription:
    """A node, its recorder and viewers; its end ends them too."""

    def actions(arguments):
        node = _node(name, arguments, on_exit=[Shutdown()])
        return [*_recorder(arguments), node, *_viewers(arguments, lambda: [panels_of(arguments)])]

    return _launch_description(TABLES[name], actions)


def _launch_description(table: Sequence[NodeParameter], actions: Callable[[dict], list]) -> LaunchDescription:
    """The shared arguments and those of `table`, empty where they are left to the node and its parameter file.

    `actions` takes the values of the shared ones, and of the others those that are given.
    """
    stay_on_this_host()
    table = (*SHARED, *table)
    declared = []
    for row in table:
        description = f"{row.description} [default: {json.dumps(row.default)}]"
        declared.append(DeclareLaunchArgument(row.name, default_value="", description=description))
    shared = {row.name: row.default for row in SHARED}

    def start(context) -> list:
        return actions(shared | launch_values(table, context.launch_configurations))

    return LaunchDescription([*declared, OpaqueFunction(function=start)])


def _panels(arguments: Mapping) -> Panels:
    scene = load_scene(arguments.get("scene", SIDES[0].default), arguments.get("overrides", []))
    return panels(scene, arguments["namespace"], arguments.get("frame_prefix", ""))


def _recorder(arguments: Mapping, **parameters) -> list[Node]:
    return [_node("recorder_node", arguments, log=arguments["record"], **parameters)] if arguments["record"] else []


def _node(name: str, arguments: Mapping, on_exit: Sequence | None = None, **parameters) -> Node:
    """A node with the parameters of its table that are given, and these; it waits for the recorder that starts too."""
    legal = [row.name for row in TABLES[name]]
    waits = {"discovery": DISCOVERY} if arguments["record"] and "discovery" in legal else {}
    values = waits | {key: arguments[key] for key in legal if key in arguments} | parameters
    # launch_ros would read texts as YAML again: "1e3" as a number.
    types = {str: str, list: list[str]}
    values = {
        key: ParameterValue(value, value_type=types[type(value)]) if type(value) in types else value
        for key, value in values.items()
    }
    files = filter(None, (str(share_path("config", f"{name}.yaml")), arguments["params_file"]))
    return Node(
        package="bearing_twin",
        executable=name,
        namespace=arguments["namespace"] or None,  # launch_ros would put "" into the root, not into that of the kind
        output="screen",
        parameters=[*files, *([values] if values else [])],
        arguments=[ROS_ARGS, "--log-level", arguments["log_level"]],
        on_exit=on_exit,
    )


def _static_transform(frame: str, height: float):
    options = {"--z": height, "--frame-id": "world", "--child-frame-id": frame}
    return _optional_program(
        f"place of {frame} in world",
        "tf2_ros",
        executable="static_transform_publisher",
        name=f"place_of_{frame.replace('/', '_')}",
        arguments=[str(part) for pair in options.items() for part in pair],
    )


def _viewers(arguments: Mapping, scenes: Callable[[], list[Panels]]) -> list:
    """RViz and the bridge to Foxglove, if they are requested and installed; else one sentence."""
    viewers = []
    if arguments["rviz"]:
        layout = _layout_file("bearing_twin.rviz", rviz(*scenes()))
        viewers.append(_optional_program("rviz:=true", "rviz2", arguments=["-d", layout]))
    if arguments["foxglove"]:
        layout = _layout_file("bearing_twin.foxglove.json", foxglove(scenes()[0]))
        bridge = {"address": "127.0.0.1", "port": BRIDGE_PORT}
        viewers.append(_optional_program("foxglove:=true", "foxglove_bridge", parameters=[bridge]))
        if isinstance(viewers[-1], Node):
            viewers.append(LogInfo(msg=f"in Foxglove open ws://localhost:{BRIDGE_PORT} and import the layout {layout}"))
    return viewers


def _layout_file(name: str, content: bytes) -> str:
    path = Path(tempfile.mkdtemp(prefix="bearing_twin_")) / name
    path.write_bytes(content)
    return str(path)


def _optional_program(argument: str, package: str, executable: str = "", **options):
    """A program of a package, by default the one named as it; or a message that it is not installed."""
    try:
        get_package_prefix(package)
    except PackageNotFoundError:
        debian = f"ros-jazzy-{package.replace('_', '-')}"
        return LogInfo(msg=f"{argument}: {package} is not installed, so it is not started (Debian: {debian})")
    return Node(package=package, executable=executable or package, output="screen", **options)
