"""The bearing to look at: visualization_msgs/MarkerArray for RViz and Foxglove.

Balls carry pins, so that their rolling is seen. Contact ellipses are drawn ELLIPSE_SCALE times as large; load arrows
are relative, the longest as long as a ball is thick, and a line of text says how many newtons that is. Few markers
with many points each: one point costs a thirtieth of one marker.
"""

import math

import numpy as np

ELLIPSE_SCALE = 10.0
OUTLINE_SIDES = 8
LONGEST_ARROW = 1.0  # ball diameters

_CYLINDER, _LINE_LIST, _SPHERE_LIST, _TEXT = 3, 5, 7, 9
_ORIGIN = (0.0, 0.0, 0.0)
_UPRIGHT = (0.0, 0.0, 0.0, 1.0)
_SPOKES = ((-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0))
_ANGLES = np.repeat(np.linspace(0.0, 2.0 * np.pi, OUTLINE_SIDES + 1), 2)[1:-1, None]  # both ends of each side
_COSINES, _SINES = np.cos(_ANGLES), np.sin(_ANGLES)

_STEEL = (0.75, 0.77, 0.80, 1.0)
_PIN = (0.15, 0.25, 0.45, 1.0)
_INNER = (0.90, 0.55, 0.15, 1.0)
_OUTER = (0.35, 0.35, 0.40, 0.2)
_ELLIPSE = (0.85, 0.15, 0.15, 0.9)
_LOAD = (0.10, 0.60, 0.25, 1.0)


def markers(parameters, sample, details):
    """Fields of each marker of one output: balls, pins, rings, ellipses, load arrows and their scale."""
    yield from _balls(parameters, sample)
    yield from _rings(parameters, sample)
    yield from _ellipses(parameters, sample, details)
    yield from _loads(parameters, sample, details)


def _balls(parameters, sample):
    """Balls, each with two pins through its centre, along its own x and y axes."""
    diameter = parameters.geometry.ball_diameter
    position, orientation = sample["position"], sample["orientation"]
    size = (diameter, diameter, diameter)
    yield _marker("balls", 0, _SPHERE_LIST, size, _STEEL, points=(position))
    x, y, z, w = orientation.T
    own_x = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)], axis=-1)
    own_y = np.stack([2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)], axis=-1)
    reach = 0.53 * diameter
    ends = [position - reach * own_x, position + reach * own_x, position - reach * own_y, position + reach * own_y]
    width = (0.1 * diameter, 0.0, 0.0)
    yield _marker("ball_pins", 0, _LINE_LIST, width, _PIN, points=(np.stack(ends, axis=1)))


def _rings(parameters, sample):
    """A solid inner ring with spokes, so that its turning is seen, in a translucent outer one."""
    geometry = parameters.geometry
    diameter = geometry.ball_diameter
    reach = 0.5 * diameter + 0.25 * geometry.radial_clearance
    inner, outer = geometry.pitch_diameter - 2.0 * reach, geometry.pitch_diameter + 2.0 * reach
    half = 0.5 * float(sample["inner_ring_angle"])
    turn = (0.0, 0.0, math.sin(half), math.cos(half))
    centre = sample["inner_ring_offset"].tolist()
    spokes = [(0.5 * inner * x, 0.5 * inner * y, 0.61 * diameter) for x, y in _SPOKES]
    width = (0.05 * diameter, 0.0, 0.0)
    yield _marker("rings", 0, _CYLINDER, (inner, inner, 1.2 * diameter), _INNER, centre)
    yield _marker("rings", 1, _CYLINDER, (outer, outer, 1.2 * diameter), _OUTER)
    yield _marker("spokes", 0, _LINE_LIST, width, _PIN, centre, turn, points=spokes)


def _ellipses(parameters, sample, details):
    """Outlines of all contact ellipses, as polygons of OUTLINE_SIDES sides."""
    rows = details["semi_minor"] > 0.0
    along = details["major_axis"][rows]
    across = np.cross(sample["normal"][rows], along)
    major = ELLIPSE_SCALE * details["semi_major"][rows][:, None] * along
    minor = ELLIPSE_SCALE * details["semi_minor"][rows][:, None] * across
    ends = sample["point"][rows][:, None] + _COSINES * major[:, None] + _SINES * minor[:, None]
    width = (0.03 * parameters.geometry.ball_diameter, 0.0, 0.0)
    yield _marker("contact_ellipses", 0, _LINE_LIST, width, _ELLIPSE, points=(ends))


def _loads(parameters, sample, details):
    """Arrows of a shaft and two barbs, their tips at the contacts; and a line of text with their scale."""
    diameter = parameters.geometry.ball_diameter
    load = sample["normal_load"]
    greatest = max(float(load.max()), 1e-30)
    rows = load > 1e-3 * greatest
    tip = sample["point"][rows]
    along = sample["normal"][rows] * (LONGEST_ARROW * diameter / greatest * load[rows])[:, None]
    barb = 0.12 * np.cross(details["major_axis"][rows], along)
    left, right = tip - 0.25 * along + barb, tip - 0.25 * along - barb
    ends = np.stack([tip - along, tip, left, tip, right, tip], axis=1)
    width = (0.06 * diameter, 0.0, 0.0)
    yield _marker("loads", 0, _LINE_LIST, width, _LOAD, points=(ends))
    text = f"longest arrow = {greatest:.4g} N, ellipses x {ELLIPSE_SCALE:g}"
    height = (0.0, 0.0, 0.5 * diameter)
    yield _marker("scale", 0, _TEXT, height, _LOAD, (0.0, 0.0, diameter), text=text)


def _marker(namespace, number, kind, scale, color, position=_ORIGIN, orientation=_UPRIGHT, *, points=None, text=""):
    pose = {"position": position, "orientation": orientation}
    points = np.empty((0, 3)) if points is None else np.reshape(points, (-1, 3))
    return {
        "ns": namespace, "id": number, "type": kind, "pose": pose, "scale": scale, "color": color, "points": points,
        "text": text,
    }  # fmt: skip
