"""Gaps in closed form: a ball in a toroidal groove (paper 1, section 5), an ellipsoid on a plane; not how hard."""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.core import INTEGER, REAL, REALS, REALS_OUT, Function, by_elements

_curvatures = Function("core_groove_curvatures", None, (REAL, REAL, REAL, INTEGER, REALS, REALS_OUT, REALS_OUT))
_gaps = Function("core_ellipsoid_gaps", None, (REALS, INTEGER, REALS, REALS_OUT))
_PARTS = (1, 4, 5, 6, 9, 10, 13)  # where the fields of a LowestPoint begin, but the first


class GrooveContact(NamedTuple):
    """A ball against a toroidal groove, in the meridian plane of the ball (radial, axial)."""

    approach: float
    normal_radial: float
    normal_axial: float
    curvature_small: float
    curvature_large: float


def groove_curvatures(ball_radius, locus_radius, groove_radius, normal_radial):
    """Curvatures (small, large) of the gap [1/m] where the normal has these radial parts, numbers or an array.

    Halves of the relative principal curvatures: the small one along the meridian, the large one along the rolling
    direction.
    """
    return tuple(by_elements(_curvatures, 2, (ball_radius, locus_radius, groove_radius), normal_radial))


def ball_in_groove(axis_distance, axial, ball_radius, locus_radius, groove_radius) -> GrooveContact:
    """Approach [m], outward normal and gap curvatures [1/m] of a ball in a toroidal groove (paper 1, section 5).

    `axis_distance` [m] is the ball centre's distance from the ring's axis, `axial` [m] its height above the ring's
    plane; the groove's centre circle has radius `locus_radius`, its meridian `groove_radius` > ball radius. The
    normal points from the ball's centre to the raceway: outwards on an outer ring (the ball is outside the centre
    circle), inwards on an inner ring; one formula serves both. On the centre circle itself, where the approach is far
    below zero, the normal is returned as zero.
    """
    radial = axis_distance - locus_radius
    distance = math.hypot(radial, axial)
    normal = (radial / distance, axial / distance) if distance else (0.0, 0.0)
    curvatures = groove_curvatures(ball_radius, locus_radius, groove_radius, normal[0])
    return GrooveContact(distance + ball_radius - groove_radius, *normal, *curvatures)


class LowestPoint(NamedTuple):
    """The farthest points of an ellipsoid along directions, in its own axes, and their gaps to a plane.

    `reach` [m] is the extent along the direction; `point` [m] and `major_axis` (unit, along `curvature_small`) are
    vectors (..., 3); the gap is z = P x^2 + Q y^2 with P = `curvature_small` <= Q = `curvature_large` [1/m]. `excess` =
    sqrt(shape^2 - 1), shape = (P + Q)/(2 sqrt(PQ)), is 0 where the gap is round. `size_slope` and `shape_slope` are the
    gradients of -ln(PQ)/4 and of the shape by the direction, per radian.
    """

    reach: np.ndarray
    point: np.ndarray
    curvature_small: np.ndarray
    curvature_large: np.ndarray
    major_axis: np.ndarray
    excess: np.ndarray
    size_slope: np.ndarray
    shape_slope: np.ndarray


def ellipsoid_on_plane(semi_axes, directions) -> LowestPoint:
    """The farthest points along unit directions (..., 3) in the ellipsoid's axes; semi-axes (3,) in m."""
    directions = np.ascontiguousarray(directions, float)
    found = np.empty((*directions.shape[:-1], 16))
    _gaps(np.array(semi_axes, float), directions.size // 3, directions, found)
    parts = np.split(found, _PARTS, axis=-1)
    return LowestPoint(*(part[..., 0] if part.shape[-1] == 1 else part for part in parts))
