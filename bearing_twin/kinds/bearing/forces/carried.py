"""What a law carries at the contacts of each ball: moved along within a step, put right at its end.

Rows CARRIED_INNER and CARRIED_OUTER hold, of either contact, P/Q at the end of the last step and the law's states
there; P/Q = 0 says that nothing is carried yet. Within a step the states are moved on from there by their differential
equations (paper 1, section 3) along the change of P/Q; `carry_on` does so at its end and lets the law put them right.
The gap between ball and groove has its curvatures also where they do not touch, so nothing is lost in flight.
"""

import math

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.differential import Shape, large_slope
from bearing_twin.contact.elasticity import carries, coefficient_at, state_begun, state_finished, state_moved
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, CARRIED_INNER, CARRIED_OUTER, HEIGHT, ORBIT_ANGLE
from bearing_twin.numerics.lanes import LANES, get, get_vector, put, put_vector
from bearing_twin.numerics.rotation import about_z, cosine_sine, minus
from bearing_twin.shapes.surfaces import ball_in_groove


@inlined
def gap_at(bearing, raceway, offset):
    """`ball_in_groove` of a ball whose centre is at `offset` [m] from the ring's."""
    axis_distance = math.sqrt(offset[0] * offset[0] + offset[1] * offset[1])
    return ball_in_groove(axis_distance, offset[2], bearing.ball_radius, raceway.locus_radius, raceway.groove_radius)


@kernel
def _moved_to(law, lanes, row, k, ratio):
    """The states of lane k's contact where P/Q is `ratio`."""
    before = get(lanes, row, k)
    if before == 0.0:
        return state_begun(law, ratio, 1.0)
    x, y, z = get_vector(lanes, row + 1, k)
    return state_moved(law, Shape(x, y, z), ratio - before)


@kernel
def carried_coefficient(bearing, raceway, offset, lanes, row, k):
    """c [N/m^1.5] of lane k's contact from its states in `row`, and dc/dQ [N/m^0.5]."""
    at = gap_at(bearing, raceway, offset)
    shape = _moved_to(raceway.law, lanes, row, k, at.curvature_small / at.curvature_large)
    coefficient = coefficient_at(raceway.law, at.curvature_small, at.curvature_large, shape)
    return coefficient, coefficient * large_slope(shape, at.curvature_large)


@kernel
def carry_on(bearing, source, row, lanes):
    """Ends a step of all lanes: their balls are where the rows from `row` on of `source` say."""
    if not carries(bearing.inner.law):
        return
    for k in range(LANES):
        _carry_ball(bearing, source, row, lanes, k)


@inlined
def carry_ball(bearing, source, row, lanes, k):
    """As `carry_on` for lane k alone."""
    if carries(bearing.inner.law):
        _carry_ball(bearing, source, row, lanes, k)


@kernel
def _carry_ball(bearing, source, row, lanes, k):
    position = (get(source, row + AXIS_DISTANCE, k), 0.0, get(source, row + HEIGHT, k))
    cosine, sine = cosine_sine(get(source, row + ORBIT_ANGLE, k))
    _carry_contact(
        bearing, bearing.inner, minus(position, about_z(cosine, -sine, bearing.offset)), lanes, CARRIED_INNER, k
    )
    _carry_contact(bearing, bearing.outer, position, lanes, CARRIED_OUTER, k)


@kernel
def _carry_contact(bearing, raceway, offset, lanes, row, k):
    at = gap_at(bearing, raceway, offset)
    ratio = at.curvature_small / at.curvature_large
    shape = state_finished(raceway.law, _moved_to(raceway.law, lanes, row, k, ratio), ratio)
    put(lanes, row, k, ratio)
    put_vector(lanes, row + 1, k, (shape.parameter, shape.first_kind, shape.second_kind))
