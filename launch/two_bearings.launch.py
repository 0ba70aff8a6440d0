"""Runs two bearings side by side.

ros2 launch bearing_twin two_bearings.launch.py scene_right:=bearing_6205
"""

from launch import LaunchDescription

from bearing_twin.nodes import launching


def generate_launch_description() -> LaunchDescription:
    return launching.two_bearings()
