"""Runs a scene, and logs it where `record` names a file.

ros2 launch bearing_twin simulate.launch.py record:=x.mcap
"""

from launch import LaunchDescription

from bearing_twin.nodes import launching


def generate_launch_description() -> LaunchDescription:
    return launching.simulate()
