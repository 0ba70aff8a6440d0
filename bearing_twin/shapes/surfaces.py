"""Closed forms of gap, normal and curvature: where bodies touch, not how hard."""

from typing import NamedTuple

from bearing_twin.compiled import inlined, plain
from bearing_twin.numerics.rotation import root_and_inverse


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
