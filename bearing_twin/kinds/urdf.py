"""A scene's bodies as URDF: links named as the frames in tf, with the simple shapes that URDF knows."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable, Mapping
from typing import NamedTuple

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
