"""How contacts with friction over their spots change with the motion of balls and the ring's speed, side by side."""

import math

import numpy as np

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces.equations import lane_position
from bearing_twin.kinds.bearing.forces.layout import (
    ACROSS,
    ALONG,
    BALL_BY_SHAFT,
    DRIVE_WORK,
    GIVEN_INNER,
    GIVEN_OUTER,
    GIVEN_SLOPE_INNER,
    GIVEN_SLOPE_OUTER,
    GROSS_WORK,
    MOMENT,
    MOTION,
    MOTION_SPAN,
    ORBIT_ANGLE,
    POWER_SIGN,
    RING_SPEED,
    SHAFT_BY_BALL,
    SHAFT_OWN,
    SPIN,
    VELOCITY,
    entry,
)
from bearing_twin.kinds.bearing.forces.spot import INNER_SPOTS, OUTER_SPOTS, kept_spot
from bearing_twin.kinds.bearing.forces.spot_gradient import SpotMeans, spot_gradient
from bearing_twin.kinds.bearing.forces.spot_slopes import SLOPES_END, room_of_slopes, slopes_of_mean
from bearing_twin.numerics.lanes import (
    LANE_RATES,
    LANES,
    get,
    get_vector,
    increase,
    put,
    put_vector,
)
from bearing_twin.numerics.lean import owning_kernel
from bearing_twin.numerics.rotation import about_z, cosine_sine, scaled

ANSWERED = 8  # rates that spots add to: those of velocity and spin, drive work, dissipated work
# Rows after the slopes: how the rates answered, and the moment about the ring's axis, change with the motion, a row an
# entry, and with the ring's speed.
ANSWERS, TURNING, BY_SPEED, ROOM_ROWS = SLOPES_END + np.cumsum((0, ANSWERED * MOTION, MOTION, ANSWERED + 1))


@inlined
def _means(room, k):
    return SpotMeans(
        get(room, ALONG, k),
        get(room, ACROSS, k),
        get(room, MOMENT, k),
        slopes_of_mean(0, room, k),
        slopes_of_mean(1, room, k),
        slopes_of_mean(2, room, k),
    )


@inlined
def _put_entry(fresh, rate, column, value, room, k):
    """Writes how a rate changes with one number of the motion, or adds to what stands there."""
    row = ANSWERS + rate * MOTION + column
    put(room, row, k, value if fresh else get(room, row, k) + value)


@inlined
def _put_column(bearing, fresh, change, column, room, k):
    """Writes how the rates change with one number of the motion, but for the drive's power, or adds it."""
    force, torque = scaled(1.0 / bearing.ball_mass, change.force), scaled(1.0 / bearing.ball_inertia, change.torque)
    _put_entry(fresh, 0, column, force[0], room, k)
    _put_entry(fresh, 1, column, force[1], room, k)
    _put_entry(fresh, 2, column, force[2], room, k)
    _put_entry(fresh, 3, column, torque[0], room, k)
    _put_entry(fresh, 4, column, torque[1], room, k)
    _put_entry(fresh, 5, column, torque[2], room, k)
    _put_entry(fresh, 7, column, change.loss, room, k)


@inlined
def _put_columns(bearing, fresh, changes, room, k):
    """The same with all numbers of the motion; constants, as `layout` wants rows that are."""
    _put_column(bearing, fresh, changes[0], 0, room, k)
    _put_column(bearing, fresh, changes[1], 1, room, k)
    _put_column(bearing, fresh, changes[2], 2, room, k)
    _put_column(bearing, fresh, changes[3], 3, room, k)
    _put_column(bearing, fresh, changes[4], 4, room, k)
    _put_column(bearing, fresh, changes[5], 5, room, k)
    _put_column(bearing, fresh, changes[6], 6, room, k)
    _put_column(bearing, fresh, changes[7], 7, room, k)
    _put_column(bearing, fresh, changes[8], 8, room, k)


@inlined
def _put_turning(changes, first, factor, room, k):
    """Writes how the moment about the ring's axis changes with the motion, times a factor."""
    put_vector(room, first, k, scaled(factor, (changes[0].turning, changes[1].turning, changes[2].turning)))
    put_vector(room, first + 3, k, scaled(factor, (changes[3].turning, changes[4].turning, changes[5].turning)))
    put_vector(room, first + 6, k, scaled(factor, (changes[6].turning, changes[7].turning, changes[8].turning)))


@inlined
def put_inner(friction, axes, bearing, room):
    """Writes what the inner contact of each lane answers, to the motion and to the ring's speed."""
    for k in range(LANES):
        cosine, sine = cosine_sine(get(room, ORBIT_ANGLE, k))
        centre, speed = about_z(cosine, -sine, bearing.offset), get(room, RING_SPEED, k)
        found = spot_gradient(
            bearing, bearing.inner, friction, axes, get(room, GIVEN_INNER, k), get(room, GIVEN_SLOPE_INNER, k), centre,
            (-centre[1], centre[0], 0.0), speed, lane_position(room, k), get_vector(room, VELOCITY, k),
            get_vector(room, SPIN, k), kept_spot(room, INNER_SPOTS + k), _means(room, INNER_SPOTS + k),
        )  # fmt: skip
        _put_columns(bearing, True, found.changes, room, k)
        _put_turning(found.changes, ANSWERS + 6 * MOTION, speed, room, k)
        _put_turning(found.changes, TURNING, 1.0, room, k)
        by = found.by_speed
        put_vector(room, BY_SPEED, k, scaled(1.0 / bearing.ball_mass, by.force))
        put_vector(room, BY_SPEED + 3, k, scaled(1.0 / bearing.ball_inertia, by.torque))
        put(room, BY_SPEED + 6, k, found.turning + speed * by.turning)
        put(room, BY_SPEED + 7, k, by.loss)
        put(room, BY_SPEED + 8, k, by.turning)


@inlined
def add_outer(friction, axes, bearing, room):
    """Adds what the outer contact of each lane answers to the motion."""
    still = (0.0, 0.0, 0.0)
    for k in range(LANES):
        found = spot_gradient(
            bearing, bearing.outer, friction, axes, get(room, GIVEN_OUTER, k), get(room, GIVEN_SLOPE_OUTER, k), still,
            (), 0.0, lane_position(room, k), get_vector(room, VELOCITY, k), get_vector(room, SPIN, k),
            kept_spot(room, OUTER_SPOTS + k), _means(room, OUTER_SPOTS + k),
        )  # fmt: skip
        _put_columns(bearing, False, found.changes, room, k)


@inlined
def _answered(bearing, lanes):
    """A room with what the contacts of all lanes answer; put into its callers, as a bearing handed over costs time."""
    spot = bearing.spot
    room = room_of_slopes(spot, bearing.friction_regularisation, lanes, ROOM_ROWS)
    put_inner(spot[0], spot[3], bearing, room)
    add_outer(spot[0], spot[4], bearing, room)
    return room


@owning_kernel
def put_spot_slopes(bearing, lanes):
    """Writes what the raceways answer into each lane's Jacobian, of rates from VELOCITY on, by friction over spots.

    The rates of the same motion come first: the means over the spots, and the drive's power, are taken from there.
    """
    room = _answered(bearing, lanes)
    for i in range(ANSWERED * MOTION_SPAN):
        put(lanes, entry(VELOCITY, 0), i, get(room, ANSWERS, i))
    for k in range(LANES):
        put(lanes, POWER_SIGN, k, math.copysign(1.0, get(lanes, LANE_RATES + DRIVE_WORK, k)))


@owning_kernel
def add_spot_turning(spot, bearing, lanes):
    """Adds what friction over the spots does to how balls answer to the inner ring's speed, and its moment to them.

    After `shaft_gradient.put_shaft_answers`; nothing where the bearing's `spot` is empty.
    """
    if len(spot) > 0:
        room, shift = _answered(bearing, lanes), BALL_BY_SHAFT - VELOCITY
        for i in range(MOTION_SPAN):
            increase(lanes, SHAFT_BY_BALL, i, -get(room, TURNING, i))
        for rate in range(ANSWERED):
            for k in range(LANES):
                increase(lanes, BALL_BY_SHAFT + rate, k, get(room, BY_SPEED + rate, k))
        for k in range(LANES):
            increase(lanes, SHAFT_OWN, k, -get(room, BY_SPEED + ANSWERED, k))
            sign = math.copysign(1.0, get(lanes, LANE_RATES + DRIVE_WORK, k))
            put(lanes, shift + GROSS_WORK, k, sign * get(lanes, shift + DRIVE_WORK, k))
