"""The bearing to look at: visualization_msgs/MarkerArray for RViz and Foxglove.

Balls carry pins, so that their rolling is seen. Contact ellipses are drawn ELLIPSE_SCALE times as large; load arrows
are relative, the longest as long as a ball is thick, and a line of text says how many newtons that is. Few markers
with many points each: one point costs a thirtieth of one marker.
"""

import math

import numpy as np

from bearing_twin.log import cdr

ELLIPSE_SCALE = 10.0
OUTLINE_SIDES = 8
LONGEST_ARROW = 1.0  # ball diameters

_CYLINDER, _LINE_LIST, _SPHERE_LIST, _TEXT = 3, 5, 7, 9
_ADD = 0

_ARRAY = cdr.message_class(cdr.MARKERS)
_MARKER = cdr.message_class("visualization_msgs/msg/Marker")
_POINT = cdr.message_class("geometry_msgs/msg/Point")
_QUATERNION = cdr.message_class("geometry_msgs/msg/Quaternion")
_POSE = cdr.message_class("geometry_msgs/msg/Pose")
_VECTOR = cdr.message_class("geometry_msgs/msg/Vector3")
_COLOR = cdr.message_class("std_msgs/msg/ColorRGBA")
_FOREVER = cdr.message_class("builtin_interfaces/msg/Duration")(0, 0)
_NO_BYTES = np.zeros(0, dtype=np.uint8)
_NO_STAMP = cdr.message_class("std_msgs/msg/Header")(cdr.message_class("builtin_interfaces/msg/Time")(0, 0), "")
_NO_TEXTURE = cdr.message_class("sensor_msgs/msg/CompressedImage")(_NO_STAMP, "", _NO_BYTES)
_NO_MESH = cdr.message_class("visualization_msgs/msg/MeshFile")("", _NO_BYTES)
_ORIGIN = (0.0, 0.0, 0.0)
_UPRIGHT = (0.0, 0.0, 0.0, 1.0)
_SPOKES = ((-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0))
_ANGLES = np.repeat(np.linspace(0.0, 2.0 * np.pi, OUTLINE_SIDES + 1), 2)[1:-1, None]  # both ends of each side
_COSINES, _SINES = np.cos(_ANGLES), np.sin(_ANGLES)

_STEEL = _COLOR(0.75, 0.77, 0.80, 1.0)
_PIN = _COLOR(0.15, 0.25, 0.45, 1.0)
_INNER = _COLOR(0.90, 0.55, 0.15, 1.0)
_OUTER = _COLOR(0.35, 0.35, 0.40, 0.2)
_ELLIPSE = _COLOR(0.85, 0.15, 0.15, 0.9)
_LOAD = _COLOR(0.10, 0.60, 0.25, 1.0)


def marker_array(output):
    """visualization_msgs/MarkerArray of one output: balls, bands, rings, ellipses, load arrows and their scale."""
    header = output.header
    return _ARRAY(
        [*_balls(header, output), *_rings(header, output), *_ellipses(header, output), *_loads(header, output)]
    )


def _balls(header, output):
    """Balls, each with two pins through its centre, along its own x and y axes."""
    diameter = output.parameters.geometry.ball_diameter
    position, orientation = output.sample["position"], output.sample["orientation"]
    size = _VECTOR(diameter, diameter, diameter)
    yield _marker(header, "balls", 0, _SPHERE_LIST, size, _STEEL, points=_points(position))
    x, y, z, w = orientation.T
    own_x = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)], axis=-1)
    own_y = np.stack([2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)], axis=-1)
    reach = 0.53 * diameter
    ends = [position - reach * own_x, position + reach * own_x, position - reach * own_y, position + reach * own_y]
    width = _VECTOR(0.1 * diameter, 0.0, 0.0)
    yield _marker(header, "ball_pins", 0, _LINE_LIST, width, _PIN, points=_points(np.stack(ends, axis=1)))


def _rings(header, output):
    """A solid inner ring with spokes, so that its turning is seen, in a translucent outer one."""
    geometry = output.parameters.geometry
    diameter = geometry.ball_diameter
    reach = 0.5 * diameter + 0.25 * geometry.radial_clearance
    inner, outer = geometry.pitch_diameter - 2.0 * reach, geometry.pitch_diameter + 2.0 * reach
    half = 0.5 * float(output.sample["inner_ring_angle"])
    turn = (0.0, 0.0, math.sin(half), math.cos(half))
    centre = output.sample["inner_ring_offset"].tolist()
    spokes = [_POINT(0.5 * inner * x, 0.5 * inner * y, 0.61 * diameter) for x, y in _SPOKES]
    width = _VECTOR(0.05 * diameter, 0.0, 0.0)
    yield _marker(header, "rings", 0, _CYLINDER, _VECTOR(inner, inner, 1.2 * diameter), _INNER, centre)
    yield _marker(header, "rings", 1, _CYLINDER, _VECTOR(outer, outer, 1.2 * diameter), _OUTER)
    yield _marker(header, "spokes", 0, _LINE_LIST, width, _PIN, centre, turn, points=spokes)


def _ellipses(header, output):
    """Outlines of all contact ellipses, as polygons of OUTLINE_SIDES sides."""
    details = output.details
    rows = details["semi_minor"] > 0.0
    along = details["major_axis"][rows]
    across = np.cross(output.sample["normal"][rows], along)
    major = ELLIPSE_SCALE * details["semi_major"][rows][:, None] * along
    minor = ELLIPSE_SCALE * details["semi_minor"][rows][:, None] * across
    ends = output.sample["point"][rows][:, None] + _COSINES * major[:, None] + _SINES * minor[:, None]
    width = _VECTOR(0.03 * output.parameters.geometry.ball_diameter, 0.0, 0.0)
    yield _marker(header, "contact_ellipses", 0, _LINE_LIST, width, _ELLIPSE, points=_points(ends))


def _loads(header, output):
    """Arrows of a shaft and two barbs, their tips at the contacts; and a line of text with their scale."""
    diameter = output.parameters.geometry.ball_diameter
    load = output.sample["normal_load"]
    greatest = max(float(load.max()), 1e-30)
    rows = load > 1e-3 * greatest
    tip = output.sample["point"][rows]
    along = output.sample["normal"][rows] * (LONGEST_ARROW * diameter / greatest * load[rows])[:, None]
    barb = 0.12 * np.cross(output.details["major_axis"][rows], along)
    left, right = tip - 0.25 * along + barb, tip - 0.25 * along - barb
    ends = np.stack([tip - along, tip, left, tip, right, tip], axis=1)
    width = _VECTOR(0.06 * diameter, 0.0, 0.0)
    yield _marker(header, "loads", 0, _LINE_LIST, width, _LOAD, points=_points(ends))
    text = f"longest arrow = {greatest:.4g} N, ellipses x {ELLIPSE_SCALE:g}"
    height = _VECTOR(0.0, 0.0, 0.5 * diameter)
    yield _marker(header, "scale", 0, _TEXT, height, _LOAD, (0.0, 0.0, diameter), text=text)


def _marker(
    header, namespace, number, kind, scale, color, position=_ORIGIN, orientation=_UPRIGHT,
    *, points=(), text="",
):  # fmt: skip
    return _MARKER(
        header, namespace, number, kind, _ADD, _POSE(_POINT(*position), _QUATERNION(*orientation)), scale, color,
        _FOREVER, False, points, [], "", _NO_TEXTURE, [], text, "", _NO_MESH, False,
    )  # fmt: skip


def _points(array):
    return [_POINT(*row) for row in array.reshape(-1, 3).tolist()]
