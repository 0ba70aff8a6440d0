"""Fields of messages that several kinds publish: wrenches, transforms, contacts; markers, and bodies as URDF.

Fields are those of many outputs at once: what differs from one to the next is an array with one row an output in front.

Frames of bodies have their origin at the point a wrench on the body is taken about, and axes parallel to the scene's
own frame, however the body turns: a wrench stamped in one keeps its fixed axes. Markers are shapes as RViz and Foxglove
draw them, few of them with many points each, as fields of visualization_msgs/Marker; as many points at every output.
Links of the URDF are named as the frames in tf. `ContactPair` holds two bodies in one contact, as all kinds but
bearings have them.
"""

import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.base.sample import Sample, Wrench
from bearing_twin.kinds.contract import ONCE, PUBLISH, Command, Output, Topic
from bearing_twin.kinds.rules import OUTSIDE
from bearing_twin.shapes import rotation_rows

CUBE, SPHERE, CYLINDER, LINE_STRIP, LINE_LIST, SPHERE_LIST, TEXT = 1, 2, 3, 4, 5, 7, 9

STEEL = (0.75, 0.77, 0.80, 1.0)
BRASS = (0.72, 0.55, 0.20, 1.0)
BLUE = (0.15, 0.25, 0.45, 1.0)
ORANGE = (0.90, 0.55, 0.15, 1.0)
GLASS = (0.35, 0.35, 0.40, 0.2)
RED = (0.85, 0.15, 0.15, 0.9)
GREEN = (0.10, 0.60, 0.25, 1.0)

ELLIPSE_SCALE = 10.0  # contact ellipses are drawn this many times as large
_ORIGIN = (0.0, 0.0, 0.0)
UNTURNED = (0.0, 0.0, 0.0, 1.0)
OUTLINE_SIDES = 8
_ANGLES = np.repeat(np.linspace(0.0, 2.0 * np.pi, OUTLINE_SIDES + 1), 2)[1:-1, None]  # both ends of each side
_COSINES, _SINES = np.cos(_ANGLES), np.sin(_ANGLES)


def marker(namespace, number, kind, scale, color, position=_ORIGIN, orientation=UNTURNED, *, points=(), text=""):
    """One marker: `kind` as CUBE ... TEXT, `scale` and `points` (..., n, 3) [m], `color` red, green, blue, opacity."""
    pose = {"position": position, "orientation": orientation}
    return {
        "ns": namespace, "id": number, "type": kind, "pose": pose, "scale": scale, "color": color, "points": points,
        "text": text,
    }  # fmt: skip


def placed(shape: dict, position, orientation=UNTURNED) -> dict:
    """A marker at another place."""
    return shape | {"pose": {"position": position, "orientation": orientation}}


def text_marker(name: str, texts: Iterable[str], height: float, position) -> dict:
    """A text at a place, one an output."""
    encoded = np.array([text.encode() for text in texts])
    return marker(name, 0, TEXT, (0.0, 0.0, height), GREEN, position, text=encoded)


def own_axes(orientation: np.ndarray) -> list[np.ndarray]:
    """Axes x, y and z (..., 3) of bodies with these quaternions (..., 4)."""
    return [np.stack(column, axis=-1) for column in zip(*rotation_rows(np.moveaxis(orientation, -1, 0)), strict=True)]


def crossed(a, b) -> np.ndarray:
    """The vector products of (..., 3) and (..., 3): as `numpy.cross`, which takes five times as long for a few rows."""
    product = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        product[..., axis] = a[..., i] * b[..., j] - a[..., j] * b[..., i]
    return product


def outlines(centres, major, minor) -> np.ndarray:
    """Both ends of every side of polygons around the ellipses with these centres and semi-axes (..., 3) [m]."""
    return centres[..., None, :] + _COSINES * major[..., None, :] + _SINES * minor[..., None, :]


def urdf(link: str, bodies: Iterable[str], solids: Mapping[str, Iterable[dict]], prefix: str = "") -> str:
    """URDF text: `link` with one floating link for each body, which `/tf` places; `prefix` stands before every name.

    `solids` are the markers of a body in its frame, of which URDF has cubes, cylinders and spheres alone. Floating
    joints are published by no robot_state_publisher, so that nothing contradicts `/tf`.
    """
    robot = ElementTree.Element("robot", name=f"{prefix}{link}")
    ElementTree.SubElement(robot, "link", name=f"{prefix}{link}")
    for body in bodies:
        _add_link(robot, f"{prefix}{body}", solids.get(body, ()))
        joint = ElementTree.SubElement(robot, "joint", name=f"{prefix}{body}_floating", type="floating")
        ElementTree.SubElement(joint, "parent", link=f"{prefix}{link}")
        ElementTree.SubElement(joint, "child", link=f"{prefix}{body}")
    ElementTree.indent(robot)
    return ElementTree.tostring(robot, encoding="unicode", xml_declaration=True)


def _add_link(robot: ElementTree.Element, name: str, solids: Iterable[dict]) -> None:
    link = ElementTree.SubElement(robot, "link", name=name)
    for number, solid in enumerate(solids):
        kind, size = solid["type"], solid["scale"]
        if kind == CUBE:
            shape, sizes = "box", {"size": size}
        elif kind == CYLINDER:
            shape, sizes = "cylinder", {"radius": (0.5 * size[0],), "length": size[2:]}
        elif kind == SPHERE and min(size) == max(size):
            shape, sizes = "sphere", {"radius": (0.5 * size[0],)}
        else:
            continue
        visual = ElementTree.SubElement(link, "visual")
        ElementTree.SubElement(visual, "origin", xyz=_text(solid["pose"]["position"]))
        geometry = ElementTree.SubElement(visual, "geometry")
        ElementTree.SubElement(geometry, shape, {key: _text(numbers) for key, numbers in sizes.items()})
        material = ElementTree.SubElement(visual, "material", name=f"{name}_{number}")
        ElementTree.SubElement(material, "color", rgba=_text(solid["color"]))


def _text(numbers: Iterable[float]) -> str:
    return " ".join(f"{float(number):.9g}" for number in numbers)


CONTACTS = "bearing_twin_msgs/msg/Contacts"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
FLOAT = "std_msgs/msg/Float64"
MARKER_ARRAY = "visualization_msgs/msg/MarkerArray"
POSE = "geometry_msgs/msg/PoseStamped"
JOINT_STATES, BEARING_STATE = "sensor_msgs/msg/JointState", "bearing_twin_msgs/msg/BearingState"
STRING = "std_msgs/msg/String"
TWIST = "geometry_msgs/msg/TwistStamped"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
WRENCH = "geometry_msgs/msg/WrenchStamped"

VECTORS = ("point", "normal", "major_axis", "friction_force", "slip")
NUMBERS = (
    "approach", "normal_load", "semi_major", "semi_minor", "peak_pressure", "contact_angle", "spin_rate",
    "drilling_torque",
)  # fmt: skip

WrenchesOf = Callable[[Any, Sample], list[Wrench]]
OriginsOf = Callable[[Any, Sample], Mapping[str, Iterable[float]]]
SolidsOf = Callable[[Any], Mapping[str, Iterable[dict]]]


def body_topics(
    link: str,
    wrenches: WrenchesOf,
    origins: OriginsOf,
    texts: Mapping[str, str],
    solids: SolidsOf,
) -> tuple[Topic, ...]:
    """Topics of every body: `robot_description`, one `<body>/wrench` for each key of `texts`, its frame on `/tf`.

    `texts` say what acts. `wrenches(parameters, sample)` are in their order; `origins(parameters, sample)` are in the
    frame `link`; `solids(parameters)` are the bodies as markers in their frames.
    """
    described = Topic(
        "robot_description", STRING, ONCE, partial(_described, link, tuple(texts), solids),
        "the bodies as URDF, their links named as the frames on /tf",
    )  # fmt: skip
    rows = [
        Topic(f"{body}/wrench", WRENCH, PUBLISH, partial(_wrench, wrenches, row), text, body)
        for row, (body, text) in enumerate(texts.items())
    ]
    text = f"frames of the bodies: origins where their wrenches are taken, axes parallel to {link}"
    return (described, *rows, Topic("/tf", TRANSFORMS, PUBLISH, partial(_transforms, origins), text, link))


def _described(link: str, bodies: tuple[str, ...], solids: SolidsOf, output: Output) -> dict:
    return {"data": urdf(link, bodies, solids(output.parameters), output.frame_prefix)}


def _wrench(wrenches: WrenchesOf, row: int, output: Output) -> dict:
    wrench = output.once(wrenches)[row]
    return {"wrench": {"force": wrench.force, "torque": wrench.torque}}


def _transforms(origins: OriginsOf, output: Output) -> dict:
    origins_of_bodies = output.once(origins)
    return {
        "transforms": [
            {"child_frame_id": output.frame(body), "transform": {"translation": origin, "rotation": UNTURNED}}
            for body, origin in origins_of_bodies.items()
        ]
    }


def contacts_topic(link: str, contacts: Callable[[Any, Sample], dict], text: str) -> Topic:
    """`contacts`, made from the rows that `contacts(parameters, sample)` gives in the frame `link`."""
    return Topic("contacts", CONTACTS, PUBLISH, partial(_contacts, contacts), text, link)


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
    status = {"level": 1, "name": OUTSIDE, "hardware_id": "bearing_twin"}
    statuses = [status | {"message": sentence} for sentence in sentences]
    text = "only where a model runs outside its range: which, as warnings, at each stamp of the topics at this rate"
    return Topic(OUTSIDE, DIAGNOSTICS, PUBLISH, lambda output: {"status": statuses}, text)


ZERO = np.zeros(3)


def times(number, vector) -> np.ndarray:
    """Vectors (..., 3) times numbers (...)."""
    return np.asarray(number)[..., None] * vector


class ContactPair(NamedTuple):
    """One contact at many outputs, in SI and the axes of the scene: numbers (...) and vectors (..., 3).

    Wrenches are taken about `position` of the first body and `second_position`; `normal` is outward of the first body.
    Friction force and spin friction moment (`drilling_torque`, about the normal) act on the first body; `slip` and
    `spin_rate` are those of the first body against the second. All but load and centres may be the same at all outputs.
    """

    position: np.ndarray
    second_position: np.ndarray
    contact_point: np.ndarray
    normal: np.ndarray
    approach: np.ndarray
    normal_load: np.ndarray
    semi_major: np.ndarray
    semi_minor: np.ndarray
    peak_pressure: np.ndarray
    major_axis: np.ndarray
    friction_force: np.ndarray = ZERO
    slip: np.ndarray = ZERO
    drilling_torque: np.ndarray | float = 0.0
    spin_rate: np.ndarray | float = 0.0

    def wrenches(self, first: str, second: str) -> list[Wrench]:
        """On each body by the other, of load, friction and spin friction."""
        force = self.friction_force - times(self.normal_load, self.normal)
        spin_moment = times(self.drilling_torque, self.normal)
        torque = crossed(self.contact_point - self.position, force) + spin_moment
        second_torque = crossed(self.contact_point - self.second_position, -force) - spin_moment
        return [
            Wrench(first, second, "centre", first, force, torque),
            Wrench(second, first, "centre", second, -force, second_torque),
        ]

    def contacts(self, first: str, second: str) -> dict:
        """The fields of Contacts: the second body acts on the first; normal and what turns about it point into it."""
        fields, outputs = self._asdict() | {"point": self.contact_point, "normal": 0.0 - self.normal}, self._outputs
        fields |= {name: 0.0 - fields[name] for name in ("drilling_torque", "spin_rate")}
        sizes = dict.fromkeys(NUMBERS, outputs) | dict.fromkeys(VECTORS, (*outputs, 3))
        rows = {
            name: np.expand_dims(np.broadcast_to(fields.get(name, 0.0), size), len(outputs))
            for name, size in sizes.items()
        }
        return {"bodies": [first, second], "body": [0], "by": [1], "in_contact": rows["approach"] > 0.0, **rows}

    @property
    def _outputs(self) -> tuple[int, ...]:
        return np.shape(self.normal_load)

    def origins(self, first: str, second: str) -> dict[str, np.ndarray]:
        """Where the wrenches on both bodies are taken."""
        size = (*self._outputs, 3)
        return {first: np.broadcast_to(self.position, size), second: np.broadcast_to(self.second_position, size)}

    def markers(self, size: float, position) -> list[dict]:
        """The contact ellipse, ELLIPSE_SCALE times as large, a point without a load; the load as text at `place`."""
        loaded = ELLIPSE_SCALE * (self.normal_load > 0.0)
        axes = self.semi_major, self.major_axis, self.semi_minor, np.cross(self.normal, self.major_axis)
        major, minor = times(loaded * axes[0], axes[1]), times(loaded * axes[2], axes[3])
        width, suffix = (0.02 * size, 0.0, 0.0), f", ellipse x {ELLIPSE_SCALE:g}"
        return [
            marker("contact_ellipses", 0, LINE_LIST, width, RED, points=outlines(self.contact_point, major, minor)),
            load_marker(self.normal_load, size, position, suffix),
        ]


def load_marker(loads: np.ndarray, size: float, position, suffix: str = "") -> dict:
    """Loads [N] as a text at a place, for a scene of about that size [m], with `more` behind it."""
    return text_marker("load", (f"{load:.4g} N{suffix}" for load in np.ravel(loads).tolist()), 0.3 * size, position)


def pair_topics(
    link: str, pair_of: Callable[[Any, Sample], ContactPair], texts: Mapping[str, str], solids: SolidsOf
) -> tuple[Topic, ...]:
    """Topics of two bodies and their contact; `texts` say by body what its wrench is, the first body first."""
    names = tuple(texts)
    return (
        *body_topics(
            link,
            lambda parameters, sample: pair_of(parameters, sample).wrenches(*names),
            lambda parameters, sample: pair_of(parameters, sample).origins(*names),
            texts,
            solids,
        ),
        contacts_topic(
            link,
            lambda parameters, sample: pair_of(parameters, sample).contacts(*names),
            "the contact, as arrays of one row",
        ),
    )
