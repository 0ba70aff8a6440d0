"""What a node has found of the others so far: whether it is all of them, and what each end of a topic is."""

import os
import re
from collections.abc import Mapping
from typing import Any

from rclpy.action import get_action_names_and_types
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node, NodeNameNonExistentError
from rclpy.validate_full_topic_name import validate_full_topic_name

QUIET, LONGEST = 1.5, 3.0  # s without a change after which a list is complete on a free machine; how many times that

# anybody on the network can send names: others may hold control characters
NAME = re.compile(r"/[\w/]*", flags=re.ASCII)
GOALS = "/_action/send_goal"  # the service of an action that takes its goals
PLUMBING = re.compile(r"/_action/|_parameters?(_types|_atomically)?$|/get_type_description$")  # services of every node


def is_topic(name: str) -> bool:
    """Whether ROS takes this as the full name of a topic: not all that is found on the network is."""
    try:
        return validate_full_topic_name(name)
    except InvalidTopicNameException:
        return False


def quiet_time() -> float:
    """Seconds without a change after which a list is taken as complete, longer where processes wait for processors.

    With six processes to a processor the second of two nodes was found up to 3 s after the first.
    """
    waiting = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    return QUIET * min(max(1.0, waiting / (os.cpu_count() or 1)), LONGEST)


def others_are_whole(node: Node) -> bool:
    """Whether other nodes are seen, and of each something that it publishes: every node publishes parameter events."""
    own = node.get_name(), node.get_namespace()
    others = [one for one in node.get_node_names_and_namespaces() if one != own]
    try:
        return bool(others) and all(node.get_publisher_names_and_types_by_node(*one) for one in others)
    except NodeNameNonExistentError:  # it has gone since
        return False


def served_actions(node: Node) -> list[tuple[str, list[str]]]:
    """Names and types of the actions that nodes serve: ROS lists those that somebody asks for, too."""
    return [one for one in get_action_names_and_types(node) if node.count_services(f"{one[0]}{GOALS}")]


def rivals(node: Node, service: str) -> list[str]:
    """What to know where several nodes answer to a service, as two of one name do; empty where one does."""
    count = node.count_services(service)
    if count < 2:
        return []
    return [
        f"{count} nodes answer to {service}: each may have done what was asked, and one of them says this; give "
        "each a name of its own (one that was killed is seen for 20 s more)"
    ]


def end_of(info) -> Mapping[str, Any]:
    """Node, type and quality of service of a publisher or a subscription."""
    profile, namespace = info.qos_profile, info.node_namespace.rstrip("/")
    return {
        "node": f"{namespace}/{info.node_name}",
        "type": info.topic_type,
        "reliability": profile.reliability.name.lower(),
        "durability": profile.durability.name.lower(),
    }
