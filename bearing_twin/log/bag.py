"""What rosbag2 wants to know about a log: quality of service in words, and the contents of `metadata.yaml`."""

from typing import NamedTuple

import yaml

_INFINITE = {"sec": 9223372036, "nsec": 854775807}
NOTHING_YET = 2**63 - 1  # rosbag2's starting time of a log without messages


class Qos(NamedTuple):
    """A publisher's quality of service in rosbag2's words: reliable or best_effort, volatile or transient_local."""

    depth: int = 10
    reliability: str = "reliable"
    durability: str = "volatile"


class LoggedTopic(NamedTuple):
    """One topic of a log: full name, type, hash of the type, publishers' quality of service, messages so far."""

    name: str
    ros_type: str
    type_hash: str
    qos: tuple[Qos, ...]
    messages: int


def qos_profiles(profiles: tuple[Qos, ...]) -> list[dict]:
    """Quality of service as rosbag2 lists it (its version 9: policies in words, unlimited durations as 2^63 - 1 ns)."""
    return [
        {
            "history": "keep_last",
            "depth": qos.depth,
            "reliability": qos.reliability,
            "durability": qos.durability,
            "deadline": dict(_INFINITE),
            "lifespan": dict(_INFINITE),
            "liveliness": "automatic",
            "liveliness_lease_duration": dict(_INFINITE),
            "avoid_ros_namespace_conventions": False,
        }
        for qos in profiles
    ]


def as_yaml(value) -> str:
    """YAML in the order given, in block style."""
    return yaml.dump(value, Dumper=_PlainDumper, sort_keys=False, default_flow_style=False)


def bag_information(topics: list[LoggedTopic], first_ns: int | None, last_ns: int, file_name: str | None) -> dict:
    """The `rosbag2_bagfile_information` of a log with one file; `first_ns` is None without messages.

    `file_name` None leaves out the file, for the copy inside the file itself (rosbag2 fills in the name on reading).
    """
    messages = sum(topic.messages for topic in topics)
    start = {"nanoseconds_since_epoch": NOTHING_YET if first_ns is None else first_ns}
    duration = {"nanoseconds": 0 if first_ns is None else last_ns - first_ns}
    names = [] if file_name is None else [file_name]
    return {
        "version": 9,
        "storage_identifier": "mcap",
        "duration": duration,
        "starting_time": start,
        "message_count": messages,
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": topic.name,
                    "type": topic.ros_type,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": qos_profiles(topic.qos),
                    "type_description_hash": topic.type_hash,
                },
                "message_count": topic.messages,
            }
            for topic in topics
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": names,
        "files": [
            {"path": name, "starting_time": start, "duration": duration, "message_count": messages} for name in names
        ],
        "custom_data": None,
        "ros_distro": "jazzy",
    }


class _PlainDumper(yaml.SafeDumper):
    """No anchors and aliases: other YAML readers of ROS do not all follow them."""

    def ignore_aliases(self, data):
        return True
