"""Closed forms of gap, normal and curvature: where bodies touch, not how hard."""

import math
from typing import NamedTuple

from bearing_twin.compiled import inlined, kernel, plain
from bearing_twin.numerics.rotation import cross, dot, root_and_inverse


class GrooveContact(NamedTuple):
    """A ball against a toroidal groove, in the meridian plane of the ball (radial, axial)."""

    approach: float
    normal_radial: float
    normal_axial: float
    curvature_small: float
    curvature_large: float


@plain
@inlined
def groove_curvatures(ball_radius, locus_radius, groove_radius, normal_radial):
    """Curvatures (small, large) of the gap [1/m] where the normal has this radial part; see `ball_in_groove`."""
    ball, rolling = 1.0 / ball_radius, normal_radial / (locus_radius + groove_radius * normal_radial)
    return 0.5 * (ball - 1.0 / groove_radius), 0.5 * (ball - rolling)


@plain
@inlined
def ball_in_groove(axis_distance, axial, ball_radius, locus_radius, groove_radius):
    """Approach [m], outward normal and gap curvatures [1/m] of a ball in a toroidal groove (paper 1, section 5).

    `axis_distance` [m] is the ball centre's distance from the ring's axis, `axial` [m] its height above the ring's
    plane; the groove's centre circle has radius `locus_radius`, its meridian `groove_radius` > ball radius. The
    normal points from the ball's centre to the raceway: outwards on an outer ring (the ball is outside the centre
    circle), inwards on an inner ring; one formula serves both. Curvatures are halves of the relative principal
    curvatures: `curvature_small` along the meridian, `curvature_large` along the rolling direction. On the
    centre circle itself, where the approach is far below zero, the normal is returned as zero.
    """
    radial = axis_distance - locus_radius
    # The tiny number keeps the centre circle defined without a branch, so that loops over balls become vector code.
    distance, inverse = root_and_inverse(radial * radial + axial * axial + 1e-300)
    normal_radial, normal_axial = radial * inverse, axial * inverse
    small, large = groove_curvatures(ball_radius, locus_radius, groove_radius, normal_radial)
    return GrooveContact(distance + ball_radius - groove_radius, normal_radial, normal_axial, small, large)


class LowestPoint(NamedTuple):
    """Where an ellipsoid reaches farthest in one direction, in its own axes, and the gap it has there to a plane.

    `reach` [m] is its extent along the direction, `point` [m] and `major_axis` (unit, along `curvature_small`) are
    vectors; `shape` >= 1 is (P + Q)/(2 sqrt(PQ)), `shape_excess` = sqrt(shape^2 - 1) = 0 where the gap is round.
    """

    reach: float
    point: tuple[float, float, float]
    curvature_small: float
    curvature_large: float
    major_axis: tuple[float, float, float]
    shape: float
    shape_excess: float


@kernel
def ellipsoid_reach(semi_axes, direction):
    """Extent [m] of an ellipsoid along a unit `direction` in its own axes, and the point there: |A d| and A^2 d/|A d|.

    The support function of the ellipsoid with semi-axes A = diag(a, b, c); the point is its gradient.
    """
    x, y, z = semi_axes[0] * direction[0], semi_axes[1] * direction[1], semi_axes[2] * direction[2]
    reach = math.sqrt(x * x + y * y + z * z)
    return reach, (semi_axes[0] * x / reach, semi_axes[1] * y / reach, semi_axes[2] * z / reach)


@kernel
def ellipsoid_on_plane(semi_axes, direction):
    """The ellipsoid's farthest point along a unit `direction`, and the curvatures [1/m] of its gap to a plane there.

    The principal radii are the eigenvalues of the support function's second derivative (A^2 - p p^T)/|A d| across the
    direction; their product is (a b c)^2/|A d|^4. The gap z = P x^2 + Q y^2 (paper 1, eq. 6) has P and Q = 1/(2 r).
    """
    reach, point = ellipsoid_reach(semi_axes, direction)
    axis = 0
    for i in range(3):
        if abs(direction[i]) < abs(direction[axis]):
            axis = i
    first = (
        (1.0 if axis == 0 else 0.0) - direction[axis] * direction[0],
        (1.0 if axis == 1 else 0.0) - direction[axis] * direction[1],
        (1.0 if axis == 2 else 0.0) - direction[axis] * direction[2],
    )
    length = math.sqrt(dot(first, first))
    first = (first[0] / length, first[1] / length, first[2] / length)
    second = cross(direction, first)
    square = (semi_axes[0] * semi_axes[0], semi_axes[1] * semi_axes[1], semi_axes[2] * semi_axes[2])
    xx = xy = yy = 0.0
    for i in range(3):
        xx += square[i] * first[i] * first[i]
        xy += square[i] * first[i] * second[i]
        yy += square[i] * second[i] * second[i]
    along, across = dot(first, point), dot(second, point)
    xx, xy, yy = (xx - along * along) / reach, (xy - along * across) / reach, (yy - across * across) / reach
    mean, half = 0.5 * (xx + yy), math.hypot(0.5 * (xx - yy), xy)
    root = semi_axes[0] * semi_axes[1] * semi_axes[2] / (reach * reach)
    great = mean + half
    angle = 0.5 * math.atan2(xy, 0.5 * (xx - yy)) if half > 0.0 else 0.0
    c, s = math.cos(angle), math.sin(angle)
    major = (c * first[0] + s * second[0], c * first[1] + s * second[1], c * first[2] + s * second[2])
    large = max(0.5 * great / (root * root), 0.5 / great)
    return LowestPoint(reach, point, 0.5 / great, large, major, max(mean / root, 1.0), half / root)


@kernel
def ellipsoid_slopes(semi_axes, direction, reach, point):
    """How the gap changes with the direction: gradients of -ln(PQ)/4 and of (P + Q)/(2 sqrt(PQ)), across the direction.

    With p = `point`, r = `reach`, T = a^2 + b^2 + c^2:  -ln(PQ)/4 + ln r is constant, and the shape is
    (T - p^2) r/(2 a b c). Vectors in the ellipsoid's axes, per radian.
    """
    rest = semi_axes[0] ** 2 + semi_axes[1] ** 2 + semi_axes[2] ** 2 - dot(point, point)
    scale = 0.5 / (semi_axes[0] * semi_axes[1] * semi_axes[2])
    square = dot(point, point)
    size = (-point[0] / reach + direction[0], -point[1] / reach + direction[1], -point[2] / reach + direction[2])
    shape = (
        scale * (rest * point[0] - 2.0 * (semi_axes[0] ** 2 - square) * point[0]),
        scale * (rest * point[1] - 2.0 * (semi_axes[1] ** 2 - square) * point[1]),
        scale * (rest * point[2] - 2.0 * (semi_axes[2] ** 2 - square) * point[2]),
    )
    along = dot(shape, direction)
    shape = (shape[0] - along * direction[0], shape[1] - along * direction[1], shape[2] - along * direction[2])
    return size, shape
