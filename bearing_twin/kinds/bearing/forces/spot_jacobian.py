"""How friction over the spots changes with the motion of balls and with the ring's speed, balls side by side."""

import math

import numpy as np

from bearing_twin.compiled import inlined, kernel
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
    clear_rows,
    get,
    get_vector,
    increase,
    increase_vector,
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
def _add_column(bearing, change, column, room, k):
    """Adds how the rates change with one number of the motion, but for the drive's power."""
    force, torque = scaled(1.0 / bearing.ball_mass, change.force), scaled(1.0 / bearing.ball_inertia, change.torque)
    increase(room, ANSWERS + column, k, force[0])
    increase(room, ANSWERS + MOTION + column, k, force[1])
    increase(room, ANSWERS + 2 * MOTION + column, k, force[2])
    increase(room, ANSWERS + 3 * MOTION + column, k, torque[0])
    increase(room, ANSWERS + 4 * MOTION + column, k, torque[1])
    increase(room, ANSWERS + 5 * MOTION + column, k, torque[2])
    increase(room, ANSWERS + 7 * MOTION + column, k, change.loss)


@inlined
def _add_columns(bearing, changes, room, k):
    """Adds how the rates change with all numbers of the motion; constants, as `layout` wants rows that are."""
    _add_column(bearing, changes[0], 0, room, k)
    _add_column(bearing, changes[1], 1, room, k)
    _add_column(bearing, changes[2], 2, room, k)
    _add_column(bearing, changes[3], 3, room, k)
    _add_column(bearing, changes[4], 4, room, k)
    _add_column(bearing, changes[5], 5, room, k)
    _add_column(bearing, changes[6], 6, room, k)
    _add_column(bearing, changes[7], 7, room, k)
    _add_column(bearing, changes[8], 8, room, k)


@inlined
def _put_turning(changes, first, factor, room, k):
    """Writes how the moment about the ring's axis changes with the motion, times a factor."""
    put_vector(room, first, k, scaled(factor, (changes[0].turning, changes[1].turning, changes[2].turning)))
    put_vector(room, first + 3, k, scaled(factor, (changes[3].turning, changes[4].turning, changes[5].turning)))
    put_vector(room, first + 6, k, scaled(factor, (changes[6].turning, changes[7].turning, changes[8].turning)))


@kernel
def add_inner(friction, axes, bearing, room):
    """Adds what the inner spot of each lane answers, to the motion and to the ring's speed."""
    for k in range(LANES):
        cosine, sine = cosine_sine(get(room, ORBIT_ANGLE, k))
        centre, speed = about_z(cosine, -sine, bearing.offset), get(room, RING_SPEED, k)
        found = spot_gradient(
            bearing, bearing.inner, friction, axes, get(room, GIVEN_INNER, k), get(room, GIVEN_SLOPE_INNER, k), centre,
            (-centre[1], centre[0], 0.0), speed, lane_position(room, k), get_vector(room, VELOCITY, k),
            get_vector(room, SPIN, k), kept_spot(room, INNER_SPOTS + k), _means(room, INNER_SPOTS + k),
        )  # fmt: skip
        _add_columns(bearing, found.changes, room, k)
        _put_turning(found.changes, ANSWERS + 6 * MOTION, speed, room, k)
        _put_turning(found.changes, TURNING, 1.0, room, k)
        by = found.by_speed
        increase_vector(room, BY_SPEED, k, scaled(1.0 / bearing.ball_mass, by.force))
        increase_vector(room, BY_SPEED + 3, k, scaled(1.0 / bearing.ball_inertia, by.torque))
        put(room, BY_SPEED + 6, k, found.turning + speed * by.turning)
        put(room, BY_SPEED + 7, k, by.loss)
        put(room, BY_SPEED + 8, k, by.turning)


@kernel
def add_outer(friction, axes, bearing, room):
    """Adds what the outer spot of each lane answers to the motion."""
    still = (0.0, 0.0, 0.0)
    for k in range(LANES):
        found = spot_gradient(
            bearing, bearing.outer, friction, axes, get(room, GIVEN_OUTER, k), get(room, GIVEN_SLOPE_OUTER, k), still,
            (), 0.0, lane_position(room, k), get_vector(room, VELOCITY, k), get_vector(room, SPIN, k),
            kept_spot(room, OUTER_SPOTS + k), _means(room, OUTER_SPOTS + k),
        )  # fmt: skip
        _add_columns(bearing, found.changes, room, k)


@owning_kernel
def _answered(spot, bearing, lanes):
    """A room with what the spots of all lanes answer."""
    room = room_of_slopes(spot, bearing.friction_regularisation, lanes, ROOM_ROWS)
    clear_rows(room, ANSWERS, ROOM_ROWS)
    add_inner(spot[0], spot[3], bearing, room)
    add_outer(spot[0], spot[4], bearing, room)
    return room


@owning_kernel
def add_spot_slopes(spot, bearing, lanes):
    """Adds to each lane's Jacobian of a bearing without friction what that over its spots does, where there is any.

    The rates of the same motion come first: the means over the spots, and the drive's power, are taken from there.
    """
    if len(spot) > 0:
        room = _answered(spot, bearing, lanes)
        for rate in range(ANSWERED):
            for i in range(MOTION_SPAN):
                increase(lanes, entry(VELOCITY + rate, 0), i, get(room, ANSWERS + rate * MOTION, i))
        for k in range(LANES):
            put(lanes, POWER_SIGN, k, math.copysign(1.0, get(lanes, LANE_RATES + DRIVE_WORK, k)))


@owning_kernel
def add_spot_turning(spot, bearing, lanes):
    """Adds what friction over the spots does to how balls answer to the inner ring's speed, and its moment to them.

    After `shaft_gradient.put_shaft_answers`; nothing where the bearing's `spot` is empty.
    """
    if len(spot) > 0:
        room, shift = _answered(spot, bearing, lanes), BALL_BY_SHAFT - VELOCITY
        for i in range(MOTION_SPAN):
            increase(lanes, SHAFT_BY_BALL, i, -get(room, TURNING, i))
        for rate in range(ANSWERED):
            for k in range(LANES):
                increase(lanes, BALL_BY_SHAFT + rate, k, get(room, BY_SPEED + rate, k))
        for k in range(LANES):
            increase(lanes, SHAFT_OWN, k, -get(room, BY_SPEED + ANSWERED, k))
            sign = math.copysign(1.0, get(lanes, LANE_RATES + DRIVE_WORK, k))
            put(lanes, shift + GROSS_WORK, k, sign * get(lanes, shift + DRIVE_WORK, k))
