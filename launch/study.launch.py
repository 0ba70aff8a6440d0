"""Serves studies.

ros2 launch bearing_twin study.launch.py log_folder:=studies workers:=4
"""

from launch import LaunchDescription

from bearing_twin.nodes import launching


def generate_launch_description() -> LaunchDescription:
    return launching.study()
