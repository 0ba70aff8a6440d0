"""The table of topics in words, for people: of one scene, or of every kind of scene."""

import functools
import re
from collections.abc import Sequence
from typing import NamedTuple

from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import MARKERS, ONCE, PUBLISH, SAMPLES
from bearing_twin.log.bag import Qos
from bearing_twin.log.stream import SLOW_RATE, Channelled, topics
from bearing_twin.run.scene import Scene, load_scene, scene_names

RATES = {
    PUBLISH: "run.publish_rate",
    MARKERS: f"{SLOW_RATE:g} Hz",
    SAMPLES: f"in blocks, up to {SLOW_RATE:g} a second",
    ONCE: "once, latched",
}
TEXT = """\
# Topics

Written by `bearing_twin topics --markdown`; `bearing_twin topics bearing_6203` lists those of one scene. The same
topics, types and bytes are in the logs.

Names without a leading `/` stand in the namespace of the kind of scene, `/bearing` and so on, or in the one that
`__ns` gives to `sim_node`. Stamps are in simulation time. Units are SI and stand in the `.msg` files of
`bearing_twin_msgs`.

**Frames.** Each kind has its own frame, `<kind>_link`, and one for each body, which `/tf` places in it. Their origins
are the points about which the wrenches on the bodies are taken; their axes stay parallel to `<kind>_link` however the
bodies turn, so that a wrench stamped in `ball_3` keeps fixed axes. Wrenches are stamped in the frame of their body.
The parameter `frame_prefix` of `sim_node` stands before the name of every frame, so that two bearings can run side by
side. `robot_description` is the same tree as URDF, for programs that draw from it; its joints float, so that a
`robot_state_publisher` adds nothing to `/tf`. A ROS without `tf2_msgs` gets everything but `/tf`.

**Launch files.** `simulate`, `replay` and `study` take every parameter of their node as an argument of its name, and
`namespace`, `params_file`, `record` (the recorder follows the namespace), `log_level`, `rviz` and `foxglove`, which
open what is installed with a layout for that scene and say what is not. `scene`, `overrides` and `frame_prefix` are
among the parameters of `sim_node`; a log has its scene, and each goal of a study names its own. `replay` moves the
topics of a log to its `namespace` and puts its `frame_prefix` before the frames, for which it writes every message
anew. `two_bearings` runs two in one tree of frames, `left` and `right` below the `namespace` and `frame_prefix` given:

```bash
ros2 launch bearing_twin simulate.launch.py namespace:=/a frame_prefix:=a/ scene:=bearing_6205 record:=a.mcap
ros2 launch bearing_twin two_bearings.launch.py scene_right:=bearing_6205 distance:=0.2 rviz:=true record:=two.mcap
ros2 launch bearing_twin replay.launch.py log:=a.mcap rate:=0.5 foxglove:=true
ros2 launch bearing_twin replay.launch.py log:=a.mcap namespace:=/b frame_prefix:=b/    # beside a running /a
```

**Loads add up.** In `contacts`, the forces and torques on a body, taken about the origin of its frame, are its wrench;
the wrenches of all bodies together are zero. Gravity, supports and the drive are not in them. A cage is no body here:
what its pockets do to the balls is in no wrench, but in the channel `pocket_force` of `samples`; what it does to a ring
whose land guides it is in that ring's wrench, in no contact, and the force of the land in `cage/state` is against it.

**Outputs.** `samples` holds every solver output without loss, `records/...` what happened between outputs, and `scene`
the scene as JSON: a recording of the three can be reported on, and verified where it began with the run.

**Outside its range.** Of a run that `solver.allow_invalid` lets go on outside a model's range, everything is marked:
`samples` have the channel `outside_range`, and `law` in `contacts` ends with ` (outside_range)`. Where a type has no
room for a mark, as wrenches and poses, the topic `outside_range` (`diagnostic_msgs/DiagnosticArray`, warnings) says
with the same stamp which model it is; only such runs have it. In their logs the metadata of every topic have the key
`outside_range`, too.

**Commands.** A command acts at most 20 ms of simulated time ahead of what is published: what was computed further ahead
is computed again; stamps are not looked at. It interrupts the computation under way, which begins again from where it
had begun, so that it is carried out within some milliseconds. Commands are carried out once in a publish period at
most: of several on a topic the last legal one, the others are counted as superseded. Interruptions may cost a fifth of
the time of computing; beyond that a command waits for the end of the chunk, 20 ms at most. A frame other than
that of the table is refused; none at all is taken for it. A load holds until the next one. With `sim_node`'s parameter
`load_timeout` it is stale after so many seconds of simulated time without another: then the scene's own load acts
again, and `/diagnostics` warns. What cannot be obeyed, such as a NaN, a load that no ball carries or one on a
coordinate that is held, changes nothing: it is counted and said on `/diagnostics`, and the last good command stays in
force. `~/reset` brings the scene's own speed and load back.

**Another law or friction** in a running `sim_node`: set its parameter `overrides`, as `ros2 param set /bearing/sim_node
overrides "['contact.normal=volumetric']"`. The run begins again at 0 with it, and so does the log, as after `~/reset`;
what makes no scene, or one with other topics, is refused.

**Services** of `sim_node`, below its own name: `~/pause` (`std_srvs/SetBool`), `~/reset` (`std_srvs/Trigger`), `~/step`
(`bearing_twin_msgs/Step`), and with bearings `~/stiffness` (`bearing_twin_msgs/Stiffness`): where the inner ring stands
at the last output, what loads it, and its stiffness there, 5 × 5, with the balls in balance.
"""


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
    """One row of the table of what a node obeys, as texts."""

    command: str
    type: str
    frame: str
    meaning: str


def command_rows(kind: str) -> list[CommandRow]:
    """The topics that `sim_node` obeys with a scene of this kind."""
    return [
        CommandRow(one.name, one.ros_type.replace("/msg/", "/"), one.frame or "-", one.meaning)
        for one in KINDS[kind].commands()
    ]


def markdown() -> str:
    """The table of every kind with what there is to know beside it: the text of docs/topics.md."""
    parts = [TEXT]
    for name, kind in KINDS.items():
        parts.append(f"\n## {name}: {kind.help}\n\nNamespace `{kind.namespace}`, frame `{kind.frame}`.\n\n")
        parts.append(_table(kind_rows(name)))
        if kind.commands():
            parts.append("\nObeyed by `sim_node`:\n\n" + _table(command_rows(name)))
    return "".join(parts)


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
