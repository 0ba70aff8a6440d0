"""The bearing to look at: visualization_msgs/MarkerArray for RViz and Foxglove.

Balls carry pins, so that their rolling is seen. Contact ellipses are drawn ELLIPSE_SCALE times as large; load arrows
are relative, the longest as long as a ball is thick, and a line of text says how many newtons that is. Few markers
with many points each: one point costs a thirtieth of one marker.
"""

import numpy as np

from bearing_twin.kinds.bearing.clearance import operating_geometry
from bearing_twin.kinds.bearing.loads import ring_attitude
from bearing_twin.kinds.markers import (
    BLUE,
    CYLINDER,
    ELLIPSE_SCALE,
    GLASS,
    GREEN,
    LINE_LIST,
    ORANGE,
    RED,
    SPHERE_LIST,
    STEEL,
    TEXT,
    crossed,
    marker,
    outlines,
)
from bearing_twin.kinds.urdf import Solid, cylinder, sphere

LONGEST_ARROW = 1.0  # ball diameters

_SPOKES = ((-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0))


def markers(parameters, sample, details):
    """Fields of each marker of one output: balls, pins, rings, ellipses, load arrows and their scale."""
    yield from _balls(parameters, sample)
    yield from _rings(parameters, sample)
    yield from _ellipses(parameters, sample, details)
    yield from _loads(parameters, sample, details)


def ring_sizes(parameters) -> tuple[float, float, float]:
    """Diameters of the inner and of the outer raceway, and the width [m] that rings are drawn with."""
    geometry = operating_geometry(parameters)
    reach = geometry.ball_diameter + 0.5 * geometry.radial_clearance
    return geometry.pitch_diameter - reach, geometry.pitch_diameter + reach, 1.2 * geometry.ball_diameter


def solids(parameters) -> dict[str, list[Solid]]:
    """The bodies for `robot_description`: balls, a solid inner ring in a translucent outer one."""
    inner, outer, wide = ring_sizes(parameters)
    ball = sphere(0.5 * parameters.geometry.ball_diameter, STEEL)
    return {f"ball_{k}": [ball] for k in range(parameters.geometry.balls)} | {
        "inner_ring": [cylinder(0.5 * inner, wide, ORANGE)],
        "outer_ring": [cylinder(0.5 * outer, wide, GLASS)],
    }


def _balls(parameters, sample):
    """Balls, each with two pins through its centre, along its own x and y axes."""
    diameter = parameters.geometry.ball_diameter
    position, orientation = sample["position"], sample["orientation"]
    size = (diameter, diameter, diameter)
    yield marker("balls", 0, SPHERE_LIST, size, STEEL, points=(position))
    x, y, z, w = orientation.T
    own_x = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)], axis=-1)
    own_y = np.stack([2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)], axis=-1)
    reach = 0.53 * diameter
    ends = [position - reach * own_x, position + reach * own_x, position - reach * own_y, position + reach * own_y]
    width = (0.1 * diameter, 0.0, 0.0)
    yield marker("ball_pins", 0, LINE_LIST, width, BLUE, points=(np.stack(ends, axis=1)))


def _rings(parameters, sample):
    """A solid inner ring with spokes, so that its turning is seen, in a translucent outer one."""
    diameter = parameters.geometry.ball_diameter
    inner, outer, wide = ring_sizes(parameters)
    tilt = sample["inner_ring_tilt"]
    leaning, turned = (ring_attitude(tilt, angle).tolist() for angle in (0.0, sample["inner_ring_angle"]))
    centre = sample["inner_ring_offset"].tolist()
    spokes = [(0.5 * inner * x, 0.5 * inner * y, 0.61 * diameter) for x, y in _SPOKES]
    width = (0.05 * diameter, 0.0, 0.0)
    yield marker("rings", 0, CYLINDER, (inner, inner, wide), ORANGE, centre, leaning)
    yield marker("rings", 1, CYLINDER, (outer, outer, wide), GLASS)
    yield marker("spokes", 0, LINE_LIST, width, BLUE, centre, turned, points=spokes)


def _ellipses(parameters, sample, details):
    """Outlines of all contact ellipses, as polygons of OUTLINE_SIDES sides."""
    rows = details["semi_minor"] > 0.0
    along = details["major_axis"][rows]
    across = crossed(sample["normal"][rows], along)
    major = ELLIPSE_SCALE * details["semi_major"][rows][:, None] * along
    minor = ELLIPSE_SCALE * details["semi_minor"][rows][:, None] * across
    ends = outlines(sample["point"][rows], major, minor)
    width = (0.03 * parameters.geometry.ball_diameter, 0.0, 0.0)
    yield marker("contact_ellipses", 0, LINE_LIST, width, RED, points=(ends))


def _loads(parameters, sample, details):
    """Arrows of a shaft and two barbs, their tips at the contacts; and a line of text with their scale."""
    diameter = parameters.geometry.ball_diameter
    load = sample["normal_load"]
    greatest = max(float(load.max()), 1e-30)
    rows = load > 1e-3 * greatest
    tip = sample["point"][rows]
    along = sample["normal"][rows] * (LONGEST_ARROW * diameter / greatest * load[rows])[:, None]
    barb = 0.12 * crossed(details["major_axis"][rows], along)
    left, right = tip - 0.25 * along + barb, tip - 0.25 * along - barb
    ends = np.stack([tip - along, tip, left, tip, right, tip], axis=1)
    width = (0.06 * diameter, 0.0, 0.0)
    yield marker("loads", 0, LINE_LIST, width, GREEN, points=(ends))
    text = f"longest arrow = {greatest:.4g} N, ellipses x {ELLIPSE_SCALE:g}"
    height = (0.0, 0.0, 0.5 * diameter)
    yield marker("scale", 0, TEXT, height, GREEN, (0.0, 0.0, diameter), text=text)
