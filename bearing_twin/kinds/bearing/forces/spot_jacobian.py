"""How friction over the spots changes with a ball's motion, balls side by side.

A quadrature is dear, what it is given is cheap: the means over a spot are differentiated exactly by the five numbers
they depend on, in one pass over the points, and those numbers by forward differences of the motion.
"""

import math

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.friction import COARSE_POINTS, spot_slopes
from bearing_twin.kinds.bearing.forces.layout import (
    ACROSS,
    ALONG,
    BALL_BY_SHAFT,
    DISSIPATED,
    DRIVE_WORK,
    GROSS_WORK,
    LANE_ROWS,
    MOMENT,
    MOTION,
    RING_SPEED,
    SEMI_MAJOR,
    SEMI_MINOR,
    SHAFT_BY_BALL,
    SHAFT_OWN,
    SLIP_MAJOR,
    SLIP_MINOR,
    SPIN,
    SPIN_RATE,
    SPOTS,
    VELOCITY,
    entry,
)
from bearing_twin.kinds.bearing.forces.spot import INNER_SPOTS, OUTER_SPOTS, means_of, spot_answer, spot_contacts
from bearing_twin.numerics.lanes import LANES, get, increase, put, put_vector
from bearing_twin.numerics.lean import owning_kernel
from bearing_twin.numerics.rotation import add, scaled

GIVEN = 5  # numbers that the means over a spot depend on: both slips, spin, both semi-axes
SUMS = 12  # over a spot's points, from which the slopes of its means follow
ANSWERED = (*range(VELOCITY, VELOCITY + 3), *range(SPIN, SPIN + 3), DRIVE_WORK, DISSIPATED)  # rates that spots add to
ANSWERS = len(ANSWERED) + 2
# Rows after those of the rates: sums and slopes of both spots of a lane, what the spots answer, and what they did.
SUM, SLOPES, ANSWER, BASE, ROOM_ROWS = LANE_ROWS + np.cumsum((0, 2 * SUMS, 6 * GIVEN, ANSWERS, ANSWERS))
NUDGE = 1e-6  # relative: for the differences of a model that is not in lanes
TINY = 1e-12  # m: no spot is smaller


@inlined
def nudges(bearing):
    """Increments (MOTION,) for forward differences: small against an elastic approach and the friction's smoothing."""
    speed = 1e-6 * bearing.friction_regularisation
    turn = speed / bearing.ball_radius
    return (3e-12, 3e-12 / bearing.outer.locus_radius, 3e-12, speed, speed, speed, turn, turn, turn)


@kernel
def sum_slopes(regularisation, room):
    """Sums over the points of both spots of all lanes, side by side, into the rows from `SUM` on."""
    for i in range(SUMS * SPOTS):
        put(room, SUM, i, 0.0)
    for i in range(len(COARSE_POINTS)):
        x, y, weight = COARSE_POINTS[i, 0], COARSE_POINTS[i, 1], COARSE_POINTS[i, 2]
        for k in range(SPOTS):
            major, minor = get(room, SEMI_MAJOR, k) * x, get(room, SEMI_MINOR, k) * y
            slip_major, slip_minor = get(room, SLIP_MAJOR, k), get(room, SLIP_MINOR, k)
            one = spot_slopes(major, minor, weight, slip_major, slip_minor, get(room, SPIN_RATE, k), regularisation)
            increase(room, SUM, k, one[0])
            increase(room, SUM + 2, k, one[1])
            increase(room, SUM + 4, k, one[2])
            increase(room, SUM + 6, k, one[3])
            increase(room, SUM + 8, k, one[4])
            increase(room, SUM + 10, k, one[5])
            increase(room, SUM + 12, k, one[6])
            increase(room, SUM + 14, k, one[7])
            increase(room, SUM + 16, k, one[8])
            increase(room, SUM + 18, k, one[9])
            increase(room, SUM + 20, k, one[10])
            increase(room, SUM + 22, k, one[11])


@inlined
def _put_slopes(mean, slopes, room, k):
    """Writes how a mean of spot k changes with each of the GIVEN numbers."""
    put(room, SLOPES + 10 * mean, k, slopes[0])
    put(room, SLOPES + 10 * mean + 2, k, slopes[1])
    put(room, SLOPES + 10 * mean + 4, k, slopes[2])
    put(room, SLOPES + 10 * mean + 6, k, slopes[3])
    put(room, SLOPES + 10 * mean + 8, k, slopes[4])


@kernel
def _slopes_of_sums(room):
    """The slopes of the means along, across and of the moment from the sums."""
    for k in range(SPOTS):
        spin, semi_major, semi_minor = get(room, SPIN_RATE, k), get(room, SEMI_MAJOR, k), get(room, SEMI_MINOR, k)
        major, minor = 1.0 / max(semi_major, TINY), 1.0 / max(semi_minor, TINY)
        uu, uv, vv = get(room, SUM, k), get(room, SUM + 2, k), get(room, SUM + 4, k)
        x_uv, x_vv, y_uu = get(room, SUM + 6, k), get(room, SUM + 8, k), get(room, SUM + 10, k)
        y_uv, xx_vv, xy_uv = get(room, SUM + 12, k), get(room, SUM + 14, k), get(room, SUM + 16, k)
        yy_uu, x_v, y_u = get(room, SUM + 18, k), get(room, SUM + 20, k), get(room, SUM + 22, k)
        _put_slopes(0, (uu, uv, x_uv - y_uu, spin * x_uv * major, -spin * y_uu * minor), room, k)
        _put_slopes(1, (uv, vv, x_vv - y_uv, spin * x_vv * major, -spin * y_uv * minor), room, k)
        by_major, by_minor = (spin * (xx_vv - xy_uv) + x_v) * major, (spin * (yy_uu - xy_uv) - y_u) * minor
        turning = xx_vv - 2.0 * xy_uv + yy_uu
        _put_slopes(2, (x_uv - y_uu, x_vv - y_uv, turning, by_major, by_minor), room, k)


@kernel
def _slopes_one_by_one(number, regularisation, room):
    """The same for a model that is not in lanes, by differences."""
    rows = (SLIP_MAJOR, SLIP_MINOR, SPIN_RATE, SEMI_MAJOR, SEMI_MINOR)
    for k in range(SPOTS):
        major, minor = max(get(room, SEMI_MAJOR, k), TINY), max(get(room, SEMI_MINOR, k), TINY)
        steps = (regularisation, regularisation, regularisation / major, major, minor)
        base = get(room, ALONG, k), get(room, ACROSS, k), get(room, MOMENT, k)
        for given in range(GIVEN):
            kept = get(room, rows[given], k)
            put(room, rows[given], k, kept + NUDGE * steps[given])
            axes = get(room, SEMI_MAJOR, k), get(room, SEMI_MINOR, k)
            slip = get(room, SLIP_MAJOR, k), get(room, SLIP_MINOR, k)
            means = means_of(number, axes[0], axes[1], slip[0], slip[1], get(room, SPIN_RATE, k), regularisation)
            put(room, rows[given], k, kept)
            for mean in range(3):
                slope = (means[mean] - base[mean]) / (NUDGE * steps[given])
                put(room, SLOPES + 10 * mean + 2 * given, k, slope)


@inlined
def _mean(row, mean, by, room, k):
    """A mean of spot k, `by` (GIVEN,) beyond what it was found at."""
    first = SLOPES + 10 * mean
    return (
        get(room, row, k)
        + get(room, first, k) * by[0]
        + get(room, first + 2, k) * by[1]
        + get(room, first + 4, k) * by[2]
        + get(room, first + 6, k) * by[3]
        + get(room, first + 8, k) * by[4]
    )


@inlined
def _answer_near(coefficient, ring_speed, contact, spot, room, k):
    """What friction over spot k does for a motion near the one its means were found at."""
    by = (
        spot.slip_major - get(room, SLIP_MAJOR, k),
        spot.slip_minor - get(room, SLIP_MINOR, k),
        contact.spin_rate - get(room, SPIN_RATE, k),
        spot.semi_major - get(room, SEMI_MAJOR, k),
        spot.semi_minor - get(room, SEMI_MINOR, k),
    )
    means = _mean(ALONG, 0, by, room, k), _mean(ACROSS, 1, by, room, k), _mean(MOMENT, 2, by, room, k)
    return spot_answer(coefficient, ring_speed, contact, spot, means[0], means[1], means[2])


@kernel
def answers_near(coefficient, bearing, room):
    """What friction over both spots gives each lane, into the rows of `ANSWER`.

    Then the drive's power without it, and its moment on the ball about the ring's axis.
    """
    inverse_mass, inverse_inertia = 1.0 / bearing.ball_mass, 1.0 / bearing.ball_inertia
    for k in range(LANES):
        speed = get(room, RING_SPEED, k)
        inner, inner_spot, outer, outer_spot = spot_contacts(bearing, room, k)
        one = _answer_near(coefficient, speed, inner, inner_spot, room, INNER_SPOTS + k)
        two = _answer_near(coefficient, 0.0, outer, outer_spot, room, OUTER_SPOTS + k)
        put_vector(room, ANSWER, k, scaled(inverse_mass, add(one.friction, two.friction)))
        put_vector(room, ANSWER + 3, k, scaled(inverse_inertia, add(one.torque, two.torque)))
        put(room, ANSWER + 6, k, one.drive_power)
        put(room, ANSWER + 7, k, one.dissipation + two.dissipation)
        put(room, ANSWER + 8, k, inner.drive_power)
        put(room, ANSWER + 9, k, one.turning)


@owning_kernel
def _room_near(spot, bearing, lanes):
    """The lanes with the slopes of the means over their spots, and what the spots did.

    All in one array: the compiler knows then that what is written is not what is read, and takes lanes at once.
    """
    room = np.empty(ROOM_ROWS * LANES)
    for i in range(LANE_ROWS * LANES):
        room[i] = lanes[i]
    if spot[2]:
        sum_slopes(bearing.friction_regularisation, room)
        _slopes_of_sums(room)
    else:
        _slopes_one_by_one(spot[1], bearing.friction_regularisation, room)
    answers_near(spot[0], bearing, room)
    for i in range(ANSWERS * LANES):
        put(room, BASE, i, get(room, ANSWER, i))
    return room


@kernel
def _put_changes(coefficient, bearing, lanes, row, step, room):
    """Writes over the answers of both spots how they change with the number in `row`, by a `step` of it."""
    for k in range(LANES):
        put(room, row, k, get(lanes, row, k) + step)
    answers_near(coefficient, bearing, room)
    for k in range(LANES):
        inverse = 1.0 / (get(room, row, k) - get(lanes, row, k))
        put(room, row, k, get(lanes, row, k))
        for answer in range(ANSWERS):
            put(room, ANSWER + answer, k, inverse * (get(room, ANSWER + answer, k) - get(room, BASE + answer, k)))


@owning_kernel
def add_spot_slopes(spot, bearing, lanes):
    """Adds to each lane's Jacobian of a bearing without friction what that over its spots does, where there is any.

    The rates of the same motion come first: the means over the spots are taken from there. The load coefficient of a
    law that is looked up counts as constant here.
    """
    if len(spot) > 0:
        room, steps = _room_near(spot, bearing, lanes), nudges(bearing)
        for column in range(MOTION):
            _put_changes(spot[0], bearing, lanes, column, steps[column], room)
            for k in range(LANES):
                for answer in range(len(ANSWERED)):
                    increase(lanes, entry(ANSWERED[answer], column), k, get(room, ANSWER + answer, k))
                sign = math.copysign(1.0, get(room, BASE + 6, k) + get(room, BASE + 8, k))
                put(lanes, entry(GROSS_WORK, column), k, sign * get(lanes, entry(DRIVE_WORK, column), k))


@owning_kernel
def add_spot_turning(spot, bearing, lanes):
    """Adds what friction over the spots does to how balls answer to the inner ring's speed, and its moment to them.

    After `shaft_gradient.put_shaft_answers`; nothing where the bearing's `spot` is empty.
    """
    if len(spot) > 0:
        room, steps, shift = _room_near(spot, bearing, lanes), nudges(bearing), BALL_BY_SHAFT - VELOCITY
        for column in range(MOTION):
            _put_changes(spot[0], bearing, lanes, column, steps[column], room)
            for k in range(LANES):
                increase(lanes, SHAFT_BY_BALL + column, k, -get(room, ANSWER + 9, k))
        _put_changes(spot[0], bearing, lanes, RING_SPEED, steps[MOTION - 1], room)
        for k in range(LANES):
            for answer in range(len(ANSWERED)):
                increase(lanes, shift + ANSWERED[answer], k, get(room, ANSWER + answer, k))
            increase(lanes, SHAFT_OWN, k, -get(room, ANSWER + 9, k))
            sign = math.copysign(1.0, get(room, BASE + 6, k) + get(room, BASE + 8, k))
            put(lanes, shift + GROSS_WORK, k, sign * get(lanes, shift + DRIVE_WORK, k))
