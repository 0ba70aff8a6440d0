"""Shapes as RViz and Foxglove draw them: markers, few of them with many points each, and the bodies of a scene as URDF.

Markers are fields of visualization_msgs/Marker. Links of the URDF are named as the frames in tf.
"""

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

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
_UPRIGHT = (0.0, 0.0, 0.0, 1.0)
OUTLINE_SIDES = 8
_ANGLES = np.repeat(np.linspace(0.0, 2.0 * np.pi, OUTLINE_SIDES + 1), 2)[1:-1, None]  # both ends of each side
_COSINES, _SINES = np.cos(_ANGLES), np.sin(_ANGLES)


def marker(namespace, number, kind, scale, color, position=_ORIGIN, orientation=_UPRIGHT, *, points=None, text=""):
    """One marker: `kind` as CUBE ... TEXT, `scale` and `points` [m], `color` red, green, blue, opacity."""
    pose = {"position": position, "orientation": orientation}
    points = () if points is None else np.reshape(points, (-1, 3))
    return {
        "ns": namespace, "id": number, "type": kind, "pose": pose, "scale": scale, "color": color, "points": points,
        "text": text,
    }  # fmt: skip


def crossed(a, b) -> np.ndarray:
    """The vector products of (..., 3) and (..., 3): as `numpy.cross`, which takes five times as long for a few rows."""
    found = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for axis in range(3):
        one, other = (axis + 1) % 3, (axis + 2) % 3
        found[..., axis] = a[..., one] * b[..., other] - a[..., other] * b[..., one]
    return found


def outlines(centres, major, minor) -> np.ndarray:
    """Both ends of every side of polygons around the ellipses with these centres and semi-axes (..., 3) [m]."""
    return centres[..., None, :] + _COSINES * major[..., None, :] + _SINES * minor[..., None, :]


Color = tuple[float, float, float, float]


class LinkShape(NamedTuple):
    """One shape of a body, in the frame of the body: URDF's name of the shape, its sizes [m], colour.

    `center` [m] is that of the shape; a cylinder's axis is z.
    """

    shape: str
    sizes: Mapping[str, float | tuple[float, float, float]]
    color: Color
    center: tuple[float, float, float] = (0.0, 0.0, 0.0)


def sphere(radius: float, color: Color) -> LinkShape:
    """A sphere of `radius` [m]."""
    return LinkShape("sphere", {"radius": radius}, color)


def cylinder(radius: float, length: float, color: Color) -> LinkShape:
    """A cylinder about z, of `radius` and `length` [m]."""
    return LinkShape("cylinder", {"radius": radius, "length": length}, color)


def box(
    size: tuple[float, float, float], color: Color, center: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> LinkShape:
    """A box with these edges [m]."""
    return LinkShape("box", {"size": size}, color, center)


def urdf(link: str, bodies: Iterable[str], solids: Mapping[str, Iterable[LinkShape]], prefix: str = "") -> str:
    """URDF text: `link` with one floating link for each body, which `/tf` places; `prefix` stands before every name.

    Floating joints are published by no robot_state_publisher, so that nothing contradicts `/tf`.
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


def _add_link(robot: ElementTree.Element, name: str, solids: Iterable[LinkShape]) -> None:
    link = ElementTree.SubElement(robot, "link", name=name)
    for number, solid in enumerate(solids):
        visual = ElementTree.SubElement(link, "visual")
        ElementTree.SubElement(visual, "origin", xyz=_text(solid.center))
        geometry = ElementTree.SubElement(visual, "geometry")
        ElementTree.SubElement(geometry, solid.shape, {key: _text(size) for key, size in solid.sizes.items()})
        material = ElementTree.SubElement(visual, "material", name=f"{name}_{number}")
        ElementTree.SubElement(material, "color", rgba=_text(solid.color))


def _text(value) -> str:
    numbers = value if isinstance(value, tuple) else (value,)
    return " ".join(f"{float(number):.9g}" for number in numbers)
