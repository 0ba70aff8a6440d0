"""Serves studies: ros2 launch bearing_twin study.launch.py log_folder:=studies workers:=4"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    arguments = {
        "log_folder": ("studies", str, "where every study is logged; empty = nowhere"),
        "memory": ("2.0e9", float, "a study that needs more is refused [B]"),
        "workers": ("0", int, "processes a study may start, at most; 0 = one a processor"),
    }
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=meaning)
        for name, (default, _, meaning) in arguments.items()
    ]
    given = {
        name: ParameterValue(LaunchConfiguration(name), value_type=kind) for name, (_, kind, _) in arguments.items()
    }
    defaults = PathJoinSubstitution([FindPackageShare("bearing_twin"), "config", "uq_node.yaml"])
    node = Node(package="bearing_twin", executable="uq_node", output="screen", parameters=[defaults, given])
    return LaunchDescription([*declared, node])
