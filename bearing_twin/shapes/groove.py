"""A ball in a toroidal groove: where they touch, not how hard (paper 1, section 5)."""

import math
from typing import NamedTuple

from bearing_twin.core import INTEGER, REAL, REALS, REALS_OUT, Function, by_elements

_curvatures = Function("core_groove_curvatures", None, (REAL, REAL, REAL, INTEGER, REALS, REALS_OUT, REALS_OUT))


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
