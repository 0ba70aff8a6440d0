"""Where an ellipsoid is farthest in a direction, and its gap to a plane there (`core/shapes/ellipsoid.hpp`)."""

from typing import NamedTuple

import numpy as np

from bearing_twin.core import INTEGER, REALS, REALS_OUT, Function

_gaps = Function("core_ellipsoid_gaps", None, (REALS, INTEGER, REALS, REALS_OUT))
_PARTS = (1, 4, 5, 6, 9, 10, 13)  # where the fields begin, but the first


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
