"""Runs a scene, and logs it where `record` names a file: ros2 launch bearing_twin simulate.launch.py record:=x.mcap"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, PythonExpression
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    config = PathJoinSubstitution([FindPackageShare("bearing_twin"), "config"])
    record = LaunchConfiguration("record")
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "scene", default_value="bearing_6203", description="scene name, or path of a YAML file"
            ),
            DeclareLaunchArgument(
                "duration", default_value="0.0", description="simulated time [s]; 0 = that of an impact, else endless"
            ),
            DeclareLaunchArgument("repeat", default_value="0.0", description="wall time from begin to begin [s]"),
            DeclareLaunchArgument("real_time_factor", default_value="1.0", description="pace; 0 = as fast as possible"),
            DeclareLaunchArgument("publish_clock", default_value="false", description="simulation time on /clock"),
            DeclareLaunchArgument("record", default_value="", description="MCAP file for recorder_node; empty = none"),
            Node(
                package="bearing_twin",
                executable="recorder_node",
                output="screen",
                condition=IfCondition(PythonExpression(["'", record, "' != ''"])),
                parameters=[
                    PathJoinSubstitution([config, "recorder_node.yaml"]),
                    {"log": ParameterValue(record, value_type=str)},
                ],
            ),
            Node(
                package="bearing_twin",
                executable="sim_node",
                output="screen",
                on_exit=Shutdown(),
                parameters=[
                    PathJoinSubstitution([config, "sim_node.yaml"]),
                    {
                        "scene": ParameterValue(LaunchConfiguration("scene"), value_type=str),
                        "duration": ParameterValue(LaunchConfiguration("duration"), value_type=float),
                        "repeat": ParameterValue(LaunchConfiguration("repeat"), value_type=float),
                        "real_time_factor": ParameterValue(LaunchConfiguration("real_time_factor"), value_type=float),
                        # Without a recorder there is nobody to wait for.
                        "discovery": ParameterValue(
                            PythonExpression(["5.0 if '", record, "' else 0.0"]), value_type=float
                        ),
                        "publish_clock": ParameterValue(LaunchConfiguration("publish_clock"), value_type=bool),
                    },
                ],
            ),
        ]
    )
