"""Plays a log: ros2 launch bearing_twin replay.launch.py log:=run.mcap rate:=0.5"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    arguments = {
        "log": (None, str, "MCAP file or bag folder to play"),
        "rate": ("1.0", float, "pace, a multiple of that of the log"),
        "start": ("0.0", float, "where to start, from the first message [s]"),
        "loop": ("false", bool, "start again at the end"),
        "publish_clock": ("false", bool, "time of the log on /clock"),
    }
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=meaning)
        for name, (default, _, meaning) in arguments.items()
    ]
    given = {
        name: ParameterValue(LaunchConfiguration(name), value_type=kind) for name, (_, kind, _) in arguments.items()
    }
    defaults = PathJoinSubstitution([FindPackageShare("bearing_twin"), "config", "replay_node.yaml"])
    node = Node(package="bearing_twin", executable="replay_node", output="screen", parameters=[defaults, given])
    return LaunchDescription([*declared, node])
