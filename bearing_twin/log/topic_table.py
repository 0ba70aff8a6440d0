"""The table of topics in words, for people: of one scene, or of every kind of scene."""

import functools
import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import MARKERS, ONCE, PUBLISH, SAMPLES, SECOND
from bearing_twin.log.bag import Qos
from bearing_twin.log.stream import SLOW_RATE, Channelled, topics
from bearing_twin.run.scene import Scene, load_scene, scene_names

RATES = {
    PUBLISH: "run.publish_rate",
    MARKERS: f"{SLOW_RATE:g} Hz",
    SAMPLES: f"in blocks, up to {SLOW_RATE:g} a second",
    ONCE: "once, latched",
    SECOND: "1 Hz",
}


class TopicRow(NamedTuple):
    """One row of the table, as texts."""

    topic: str
    type: str
    rate: str
    qos: str
    frame: str
    meaning: str


def scene_rows(scene: Scene) -> list[TopicRow]:
    """The topics of a scene by their full names, with their rates in Hz."""
    rates = RATES | {PUBLISH: f"{scene.parameters.run.publish_rate:g} Hz"}
    return [_row(topic, topic.full_name, rates) for topic in topics(scene)]


def kind_rows(kind: str) -> list[TopicRow]:
    """The topics of a kind by default and those that other shipped scenes of it have.

    Those that differ in a number alone, as of several balls, are one row.
    """
    default = Scene(kind, kind, "", KINDS[kind].parameters())
    tables = [_numberless_rows(scene) for scene in (default, *_shipped().get(kind, ()))]
    found = dict(max(tables, key=len))
    for table in tables[::-1]:
        found |= table  # the text is that of the first
    return list(found.values())


@functools.cache
def _shipped() -> dict[str, list[Scene]]:
    """The shipped scenes of each kind."""
    found: dict[str, list[Scene]] = {}
    for name in scene_names():
        scene = load_scene(name)
        found.setdefault(scene.kind, []).append(scene)
    return found


def _numberless_rows(scene: Scene) -> dict[str, TopicRow]:
    rows = (TopicRow(*map(_numberless, _row(topic, topic.name, RATES))) for topic in topics(scene))
    return {row.topic: row for row in rows}


class CommandRow(NamedTuple):
    """One row of the table of topics that a node subscribes to, as texts."""

    command: str
    type: str
    frame: str
    meaning: str


def command_rows(kind: str) -> list[CommandRow]:
    """The topics that `sim_node` subscribes to with a scene of this kind."""
    return [
        CommandRow(one.name, one.ros_type.replace("/msg/", "/"), one.frame or "-", one.meaning)
        for one in KINDS[kind].commands()
    ]


def markdown(kinds: Iterable[str] | None = None) -> str:
    """The table of every kind, or of these, as it stands in docs/topics.md."""
    parts = []
    for name in KINDS if kinds is None else kinds:
        kind = KINDS[name]
        parts.append(f"## {name}: {kind.help}\n\nNamespace `{kind.namespace}`, frame `{kind.frame}`.\n\n")
        parts.append(_table(kind_rows(name)))
        if kind.commands():
            parts.append("\nSubscribed by `sim_node`:\n\n" + _table(command_rows(name)))
        parts.append("\n")
    return "".join(parts).rstrip("\n") + "\n"


def _row(topic: Channelled, name: str, rates: dict[str, str]) -> TopicRow:
    frame = topic.row.frame or "-"
    return TopicRow(
        name, topic.ros_type.replace("/msg/", "/"), rates[topic.rate], _words(topic.qos), frame, topic.row.meaning
    )


def _numberless(text: str) -> str:
    return re.sub(r"\bball \d+", "ball k", re.sub(r"\bball_\d+", "ball_<k>", text))


def _words(qos: Qos) -> str:
    return f"{qos.reliability.replace('_', ' ')}, {qos.durability.replace('_', ' ')}, depth {qos.depth}"


def _table(rows: Sequence[NamedTuple]) -> str:
    code, names = ("topic", "command", "type", "frame"), rows[0]._fields
    lines = [f"| {' | '.join(names)} |", f"|{'---|' * len(names)}"]
    for row in rows:
        cells = (f"`{text}`" if name in code and text != "-" else text for name, text in row._asdict().items())
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"
