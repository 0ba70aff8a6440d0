"""The bearing to look at: visualization_msgs/MarkerArray for RViz and Foxglove.

Balls carry pins, so that their rolling is seen. Contact ellipses are drawn ELLIPSE_SCALE times as large; load arrows
are relative, the longest as long as a ball is thick, and a line of text says how many newtons that is. Few markers
with many points each: one point costs a thirtieth of one marker.
"""

from itertools import pairwise

import numpy as np

from bearing_twin.kinds.bearing.geometry import operating_geometry
from bearing_twin.kinds.bearing.outputs import ring_attitude
from bearing_twin.kinds.markers import (
    BLUE,
    BRASS,
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
from bearing_twin.kinds.urdf import LinkShape, cylinder, sphere
from bearing_twin.numerics.rotation import rotation_rows

LONGEST_ARROW = 1.0  # ball diameters
OUTER_WIDTH = 0.95  # of the inner ring's: faces in one plane flicker where they are drawn
LETTERS = 0.25  # height of a line of text in ball diameters: the line is no wider than the bearing

CORNERS = 6  # of the circle that stands for a cage, from ball to ball

_SPOKES = ((-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0))


def markers(parameters, sample, details) -> list[tuple[np.ndarray, list[dict]]]:
    """(outputs, fields of each marker) of many outputs: balls, pins, rings, ellipses, load arrows and their scale.

    Outputs in one entry show as many ellipses and arrows, and as many letters.
    """
    load = sample["normal_load"]
    greatest = np.maximum(load.max(axis=(1, 2)), 1e-30)
    ellipses, arrows = details["semi_minor"] > 0.0, load > 1e-3 * greatest[:, None, None]
    scales = (f"longest arrow = {one:.4g} N\nellipses x {ELLIPSE_SCALE:g}" for one in greatest.tolist())
    texts = np.array([one.encode() for one in scales])
    lengths = np.char.str_len(texts)
    sizes = np.stack([ellipses.sum(axis=(1, 2)), arrows.sum(axis=(1, 2)), lengths], axis=1)
    balls, rings = list(_balls(parameters, sample)), [*_rings(parameters, sample), *_cage(parameters, sample)]
    outlined, pushed = _outlines(sample, details), _arrows(parameters, sample, details, greatest)
    diameter, found = parameters.geometry.ball_diameter, []
    for size in np.unique(sizes, axis=0):
        rows = np.flatnonzero((sizes == size).all(axis=1))
        whole = len(rows) == len(sizes)
        shared = [one if whole else _part(one, rows) for one in (*balls, *rings)]
        ends = [
            one[rows][mask[rows]].reshape(len(rows), -1, 3) for one, mask in ((outlined, ellipses), (pushed, arrows))
        ]
        width, thick = (0.03 * diameter, 0.0, 0.0), (0.06 * diameter, 0.0, 0.0)
        text = texts[rows].astype(f"S{size[2]}")
        height, above = (0.0, 0.0, LETTERS * diameter), (0.0, 0.0, 1.5 * diameter)
        drawn = [
            marker("contact_ellipses", 0, LINE_LIST, width, RED) | {"points": ends[0]},
            marker("loads", 0, LINE_LIST, thick, GREEN) | {"points": ends[1]},
            marker("scale", 0, TEXT, height, GREEN, above) | {"text": text},
        ]
        found.append((rows, shared + drawn))
    return found


def _part(fields: dict, rows) -> dict:
    """The fields of these outputs alone."""
    kept = {name: value[rows] if isinstance(value, np.ndarray) else value for name, value in fields.items()}
    pose = {name: value[rows] if isinstance(value, np.ndarray) else value for name, value in fields["pose"].items()}
    return kept | {"pose": pose}


def ring_sizes(parameters) -> tuple[float, float, float]:
    """Diameters of the inner and of the outer raceway, and the width [m] that rings are drawn with."""
    geometry = operating_geometry(parameters)
    reach = geometry.ball_diameter + 0.5 * geometry.radial_clearance
    return geometry.pitch_diameter - reach, geometry.pitch_diameter + reach, 1.2 * geometry.ball_diameter


def solids(parameters) -> dict[str, list[LinkShape]]:
    """The bodies for `robot_description`: balls, a solid inner ring in a translucent outer one."""
    inner, outer, wide = ring_sizes(parameters)
    ball = sphere(0.5 * parameters.geometry.ball_diameter, STEEL)
    return {f"ball_{k}": [ball] for k in range(parameters.geometry.balls)} | {
        "inner_ring": [cylinder(0.5 * inner, wide, ORANGE)],
        "outer_ring": [cylinder(0.5 * outer, OUTER_WIDTH * wide, GLASS)],
    }


def _balls(parameters, sample):
    """Balls, each with two pins through its centre, along its own x and y axes."""
    diameter = parameters.geometry.ball_diameter
    position, orientation = sample["position"], sample["orientation"]
    size = (diameter, diameter, diameter)
    yield marker("balls", 0, SPHERE_LIST, size, STEEL) | {"points": position}
    rows = rotation_rows(np.moveaxis(orientation, -1, 0))
    own_x, own_y = (np.stack([row[axis] for row in rows], axis=-1) for axis in range(2))
    reach = 0.53 * diameter
    ends = [position - reach * own_x, position + reach * own_x, position - reach * own_y, position + reach * own_y]
    width = (0.1 * diameter, 0.0, 0.0)
    points = np.stack(ends, axis=-2).reshape(len(position), -1, 3)
    yield marker("ball_pins", 0, LINE_LIST, width, BLUE) | {"points": points}


def _rings(parameters, sample):
    """A solid inner ring with spokes, so that its turning is seen, in a translucent outer one."""
    diameter = parameters.geometry.ball_diameter
    inner, outer, wide = ring_sizes(parameters)
    tilt, angle = sample["inner_ring_tilt"], sample["inner_ring_angle"]
    leaning, turned = ring_attitude(tilt, np.zeros(angle.shape)), ring_attitude(tilt, angle)
    centre = sample["inner_ring_offset"]
    spokes = [(0.5 * inner * x, 0.5 * inner * y, 0.61 * diameter) for x, y in _SPOKES]
    width = (0.05 * diameter, 0.0, 0.0)
    yield marker("rings", 0, CYLINDER, (inner, inner, wide), ORANGE, centre, leaning)
    yield marker("rings", 1, CYLINDER, (outer, outer, OUTER_WIDTH * wide), GLASS)
    yield marker("spokes", 0, LINE_LIST, width, BLUE, centre, turned) | {"points": spokes}


def _cage(parameters, sample):
    """A circle through the middle of the pockets, and a web between each two of them, where the cage is."""
    if parameters.cage.kind == "none":
        return
    radius, half = 0.5 * parameters.geometry.pitch_diameter, 0.3 * parameters.geometry.ball_diameter
    balls, points = parameters.geometry.balls, []
    corners = np.linspace(0.0, 2.0 * np.pi, CORNERS * balls + 1)
    circle = np.stack([radius * np.cos(corners), radius * np.sin(corners), np.zeros_like(corners)], axis=-1).tolist()
    for one, other in pairwise(circle):
        points += [one, other]
    for k in range(balls):
        x, y, _ = circle[CORNERS * k + CORNERS // 2]
        points += [(x, y, -half), (x, y, half)]
    angle, offset = sample["cage_angle"], sample["cage_offset"]
    centre = np.concatenate([offset, np.zeros_like(offset[..., :1])], axis=-1)
    turned = ring_attitude(np.zeros_like(offset), angle)
    yield marker("cage", 0, LINE_LIST, (0.1 * half, 0.0, 0.0), BRASS, centre, turned) | {"points": points}


def _outlines(sample, details) -> np.ndarray:
    """Outlines of all contact ellipses, as polygons of OUTLINE_SIDES sides: both ends of every side."""
    along = details["major_axis"]
    across = crossed(sample["normal"], along)
    major = ELLIPSE_SCALE * details["semi_major"][..., None] * along
    minor = ELLIPSE_SCALE * details["semi_minor"][..., None] * across
    return outlines(sample["point"], major, minor)


def _arrows(parameters, sample, details, greatest) -> np.ndarray:
    """Both ends of a shaft and two barbs of an arrow at every contact, their tips there."""
    length = LONGEST_ARROW * parameters.geometry.ball_diameter / greatest
    tip = sample["point"]
    along = sample["normal"] * (length[:, None, None] * sample["normal_load"])[..., None]
    barb = 0.12 * crossed(details["major_axis"], along)
    left, right = tip - 0.25 * along + barb, tip - 0.25 * along - barb
    return np.stack([tip - along, tip, left, tip, right, tip], axis=-2)
