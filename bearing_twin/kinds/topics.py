"""What the topics of several kinds have in common: wrenches, transforms and contacts as fields of messages.

Frames of bodies have their origin at the point a wrench on the body is taken about, and axes parallel to the scene's
own frame, however the body turns: a wrench stamped in one keeps its fixed axes.
"""

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.base.sample import Sample, Wrench
from bearing_twin.kinds.contract import ONCE, PUBLISH, Command, Output, Topic
from bearing_twin.kinds.markers import LinkShape, urdf
from bearing_twin.kinds.ranges import OUTSIDE

CONTACTS = "bearing_twin_msgs/msg/Contacts"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
FLOAT = "std_msgs/msg/Float64"
MARKER_ARRAY = "visualization_msgs/msg/MarkerArray"
POSE = "geometry_msgs/msg/PoseStamped"
STRING = "std_msgs/msg/String"
TWIST = "geometry_msgs/msg/TwistStamped"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
WRENCH = "geometry_msgs/msg/WrenchStamped"

UNTURNED = (0.0, 0.0, 0.0, 1.0)
VECTORS = ("point", "normal", "major_axis", "friction_force", "slip")
NUMBERS = (
    "approach", "normal_load", "semi_major", "semi_minor", "peak_pressure", "contact_angle", "spin_rate",
    "drilling_torque",
)  # fmt: skip

WrenchesOf = Callable[[Any, Sample], list[Wrench]]
OriginsOf = Callable[[Any, Sample], Mapping[str, Iterable[float]]]
SolidsOf = Callable[[Any], Mapping[str, Iterable[LinkShape]]]


def body_topics(
    link: str,
    wrenches: WrenchesOf,
    origins: OriginsOf,
    texts: Mapping[str, str],
    solids: SolidsOf,
    together: bool = False,
) -> tuple[Topic, ...]:
    """What every body has: `robot_description`, one `<body>/wrench` for each key of `texts`, its frame on `/tf`.

    `texts` say what acts. `wrenches(parameters, sample)` are in their order; `origins(parameters, sample)` are in the
    frame `link`; `solids(parameters)` are the shapes of the bodies where URDF has them. `together`: wrenches and
    origins take many outputs at once.
    """
    described = Topic(
        "robot_description", STRING, ONCE, partial(_described, link, tuple(texts), solids),
        "the bodies as URDF, their links named as the frames on /tf",
    )  # fmt: skip
    rows = [
        Topic(f"{body}/wrench", WRENCH, PUBLISH, partial(_wrench, wrenches, row), text, body, together)
        for row, (body, text) in enumerate(texts.items())
    ]
    text = f"frames of the bodies: origins where their wrenches are taken, axes parallel to {link}"
    return (described, *rows, Topic("/tf", TRANSFORMS, PUBLISH, partial(_transforms, origins), text, link, together))


def _described(link: str, bodies: tuple[str, ...], solids: SolidsOf, output: Output) -> dict:
    return {"data": urdf(link, bodies, solids(output.parameters), output.frame_prefix)}


def _wrench(wrenches: WrenchesOf, row: int, output: Output) -> dict:
    found = output.once(wrenches)[row]
    return {"wrench": {"force": found.force, "torque": found.torque}}


def _transforms(origins: OriginsOf, output: Output) -> dict:
    placed = output.once(origins)
    return {
        "transforms": [
            {"child_frame_id": output.frame(body), "transform": {"translation": origin, "rotation": UNTURNED}}
            for body, origin in placed.items()
        ]
    }


def contacts_topic(link: str, contacts: Callable[[Any, Sample], dict], text: str, together: bool = False) -> Topic:
    """`contacts`, made from the rows that `contacts(parameters, sample)` gives in the frame `link`."""
    return Topic("contacts", CONTACTS, PUBLISH, partial(_contacts, contacts), text, link, together)


def _contacts(contacts: Callable[[Any, Sample], dict], output: Output) -> dict:
    return {"sequence": output.sample.sequence, "law": output.law, **output.once(contacts)}


def pose_topic(name: str, link: str, text: str, prefix: str = "") -> Topic:
    """A body's own axes, from the channels `position` and `orientation`, whose names begin with `prefix`."""
    return Topic(name, POSE, PUBLISH, partial(_pose, prefix), text, link)


def _pose(prefix: str, output: Output) -> dict:
    sample = output.sample
    return {"pose": {"position": sample[f"{prefix}position"], "orientation": sample[f"{prefix}orientation"]}}


def turning_commands(body: str, link: str) -> tuple[Command, Command]:
    """The topics that command the speed of a `body` about z, with a header in the frame `link` or without one."""
    return (
        Command("command/speed", FLOAT, lambda message: ("set_speed", message.data), f"speed of {body} [rad/s]"),
        Command(
            "command/speed_stamped",
            TWIST,
            partial(_turning, body),
            "the same with a header: twist.angular.z alone",
            link,
        ),
    )  # fmt: skip


def _turning(body: str, message) -> tuple:
    linear, angular = message.twist.linear, message.twist.angular
    if any((linear.x, linear.y, linear.z, angular.x, angular.y)):
        raise BearingTwinError(f"{body} turns about z alone: leave all but twist.angular.z at 0")
    return "set_speed", angular.z


def load_command(where: str, link: str) -> Command:
    """The topic of a load from outside, in the frame `link`; `where` says on what and about which point."""
    return Command("command/load", WRENCH, _load, f"load {where}, held until the next", link)


def _load(message) -> tuple:
    force, torque = message.wrench.force, message.wrench.torque
    return "set_load", (force.x, force.y, force.z), (torque.x, torque.y, torque.z)


def outside_topic(sentences: tuple[str, ...]) -> Topic:
    """`outside_range`: these sentences about models outside their range as warnings, with the stamp of each wrench.

    Types such as WrenchStamped have no room for a mark; fields are the same at every output.
    """
    said = [{"level": 1, "name": OUTSIDE, "message": one, "hardware_id": "bearing_twin"} for one in sentences]
    text = "only where a model runs outside its range: which, as warnings, at each stamp of the topics at this rate"
    return Topic(OUTSIDE, DIAGNOSTICS, PUBLISH, lambda output: {"status": said}, text, together=True)
