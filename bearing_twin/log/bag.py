"""What rosbag2 wants to know about a log: quality of service in words, and the contents of `metadata.yaml`."""

import functools
import re
from textwrap import indent
from typing import NamedTuple

import yaml

_INFINITE = {"sec": 9223372036, "nsec": 854775807}
NOTHING_YET = 2**63 - 1  # rosbag2's starting time of a log without messages
DEEPEST = 10_000  # messages of a topic that a publisher keeps
LONGEST_PROFILE = 5000  # characters; those of bags have 300
NUMBERED = {
    "reliability": {1: "reliable", 2: "best_effort"},
    "durability": {1: "transient_local", 2: "volatile"},
}  # how older bags write the policies
_NEXT_PROFILE = re.compile(r"\n(?=-)")


class Qos(NamedTuple):
    """A publisher's quality of service in rosbag2's words: reliable or best_effort, volatile or transient_local."""

    depth: int = 10
    reliability: str = "reliable"
    durability: str = "volatile"


class LoggedTopic(NamedTuple):
    """One topic of a log: full name, type, hash of the type, publishers' quality of service, messages so far.

    `kept` is how many of its messages a second are in the log; 0 = all. `outside` says which models were outside their
    range.
    """

    name: str
    ros_type: str
    type_hash: str
    qos: tuple[Qos, ...]
    messages: int
    kept: float = 0.0
    outside: str = ""


class Span(NamedTuple):
    """One file of a log: its name, times of its first and last message [ns] (None without any), messages, bytes."""

    path: str
    first_ns: int | None
    last_ns: int
    messages: int
    bytes: int


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


@functools.cache
def qos_text(profiles: tuple[Qos, ...]) -> str:
    """`qos_profiles` as YAML: topics of a log share a few."""
    return as_yaml(qos_profiles(profiles))


def offered_qos(text: str) -> Qos:
    """The first of the profiles that a bag lists as YAML; reliable and volatile where it says nothing usable."""
    try:
        first = _NEXT_PROFILE.split(text, maxsplit=1)[0]
        if len(first) > LONGEST_PROFILE:
            return Qos()
        profile = yaml.safe_load(first)[0]
        reliability = NUMBERED["reliability"].get(profile["reliability"], profile["reliability"])
        durability = NUMBERED["durability"].get(profile["durability"], profile["durability"])
        depth = int(profile["depth"])
    except (yaml.YAMLError, LookupError, TypeError, ValueError, RecursionError):
        return Qos()
    return Qos(
        depth if 1 <= depth <= DEEPEST else Qos().depth,
        "best_effort" if reliability == "best_effort" else "reliable",
        "transient_local" if durability == "transient_local" else "volatile",
    )


def as_yaml(value) -> str:
    """YAML in the order given, in block style."""
    return yaml.dump(value, Dumper=_PlainDumper, sort_keys=False, default_flow_style=False)


def bag_information(topics: list[LoggedTopic], spans: list[Span]) -> str:
    """The `rosbag2_bagfile_information` of a log with these files, as YAML.

    A file without a name is left out, for the copy inside the file itself (rosbag2 fills in the name on reading).
    """
    told = [span for span in spans if span.first_ns is not None]
    whole = Span(
        "",
        min((span.first_ns for span in told), default=None),
        max((span.last_ns for span in told), default=0),
        sum(topic.messages for topic in topics),
        0,
    )
    named = [span for span in spans if span.path]
    before = {"version": 9, "storage_identifier": "mcap", **_when(whole)}
    after = {
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [span.path for span in named],
        "files": [{"path": span.path, **_when(span)} for span in named],
        "custom_data": None,
        "ros_distro": "jazzy",
    }
    rows = "\n" + "".join(map(_row, topics)) if topics else " []\n"
    return f"{as_yaml(before)}topics_with_message_count:{rows}{as_yaml(after)}"


def _row(topic: LoggedTopic) -> str:
    """A topic in the list of a log's topics; put together, for thousands of them would take a second by the library."""
    name, rest = indent(as_yaml({"name": topic.name}), "    "), _rest(topic.ros_type, topic.qos, topic.type_hash)
    return f"- topic_metadata:\n{name}{rest}  message_count: {topic.messages}\n"


@functools.cache
def _rest(ros_type: str, qos: tuple[Qos, ...], type_hash: str) -> str:
    """What else is told of a topic, alike for many."""
    told = {"type": ros_type, "serialization_format": "cdr", "offered_qos_profiles": qos_profiles(qos)}
    return indent(as_yaml(told | {"type_description_hash": type_hash}), "    ")


def _when(span: Span) -> dict:
    empty = span.first_ns is None
    return {
        "duration": {"nanoseconds": 0 if empty else span.last_ns - span.first_ns},
        "starting_time": {"nanoseconds_since_epoch": NOTHING_YET if empty else span.first_ns},
        "message_count": span.messages,
    }


class _PlainDumper(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):
    """No anchors and aliases: other YAML readers of ROS do not all follow them."""

    def ignore_aliases(self, data):
        return True
