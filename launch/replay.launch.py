"""Plays a log.

ros2 launch bearing_twin replay.launch.py log:=run.mcap rate:=0.5
"""

from launch import LaunchDescription

from bearing_twin.nodes import launching


def generate_launch_description() -> LaunchDescription:
    return launching.replay()
