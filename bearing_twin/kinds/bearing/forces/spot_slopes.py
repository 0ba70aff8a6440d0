"""How the means over the spots change with the five numbers they depend on, balls side by side.

A quadrature is dear, what it is given is cheap: the means are differentiated exactly, in one pass over the points.
"""

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.spot_rules import (
    FEW,
    POINTS,
    ROUND,
    blend,
    rim_share,
    slip_share,
    spot_slopes,
)
from bearing_twin.kinds.bearing.forces.layout import (
    ACROSS,
    ALONG,
    AXIS_DISTANCE,
    GIVEN_OUTER,
    JACOBIAN,
    MOMENT,
    SEMI_MAJOR,
    SEMI_MINOR,
    SLIP_MAJOR,
    SLIP_MINOR,
    SPIN_RATE,
    SPOTS,
)
from bearing_twin.kinds.bearing.forces.spot import means_of
from bearing_twin.numerics.lanes import LANES, SPARE, clear_rows, copy_rows, from_cache_line, get, increase, put
from bearing_twin.numerics.lean import owning_kernel

GIVEN = 5  # numbers that the means over a spot depend on: both slips, spin, both semi-axes
SUMS = 12  # over a spot's points, from which the slopes of its means follow; then how these change with the rule
# Rows of a room of their own after a ball's motion and its spots: sums over the points of both spots of a lane, the
# part of the points in these, and the slopes of the three means.
SUM, JUMP, PART, BY_RULE, SLOPES, SLOPES_END = JACOBIAN + np.cumsum((0, 2 * SUMS, 6, 2, 2, 6 * GIVEN))
NUDGE = 1e-6  # relative: for the differences of a model without a rule of points
TINY = 1e-12  # m: no spot is smaller


@inlined
def _point(i):
    """Point i: both places in units of the semi-axes, and its weight."""
    return POINTS[i, 0], POINTS[i, 1], POINTS[i, 2]


@inlined
def _two_points(first, second, regularisation, room, k):
    """What two points give to the sums of spot k."""
    motion = get(room, SLIP_MAJOR, k), get(room, SLIP_MINOR, k), get(room, SPIN_RATE, k)
    major, minor, part = get(room, SEMI_MAJOR, k), get(room, SEMI_MINOR, k), get(room, PART, k)
    a = spot_slopes(major * first[0], minor * first[1], part * first[2], *motion, regularisation)
    b = spot_slopes(major * second[0], minor * second[1], part * second[2], *motion, regularisation)
    return (
        a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5],
        a[6] + b[6], a[7] + b[7], a[8] + b[8], a[9] + b[9], a[10] + b[10], a[11] + b[11],
    )  # fmt: skip


@kernel
def add_points(first, end, regularisation, room):
    """Adds to the sums from `SUM` on what the points from `first` to `end` give, to those of each spot its `PART`.

    Four points at once, as to reach the sums takes as long as a point; read before, as LLVM does not know them and
    `room` apart.
    """
    here = min(SPOTS, len(room))  # as in `spot.over_spots`
    for i in range(first, end, 4):
        a, b, c, d = _point(i), _point(i + 1), _point(i + 2), _point(i + 3)
        for k in range(here):
            one = _two_points(a, b, regularisation, room, k)
            two = _two_points(c, d, regularisation, room, k)
            increase(room, SUM, k, one[0] + two[0])
            increase(room, SUM + 2, k, one[1] + two[1])
            increase(room, SUM + 4, k, one[2] + two[2])
            increase(room, SUM + 6, k, one[3] + two[3])
            increase(room, SUM + 8, k, one[4] + two[4])
            increase(room, SUM + 10, k, one[5] + two[5])
            increase(room, SUM + 12, k, one[6] + two[6])
            increase(room, SUM + 14, k, one[7] + two[7])
            increase(room, SUM + 16, k, one[8] + two[8])
            increase(room, SUM + 18, k, one[9] + two[9])
            increase(room, SUM + 20, k, one[10] + two[10])
            increase(room, SUM + 22, k, one[11] + two[11])


@kernel
def _add_jumps(first, end, regularisation, room):
    """Adds to the sums from `JUMP` on how the means change with the part of these points, by `BY_RULE`."""
    for i in range(first, end):
        x, y, weight = _point(i)
        for k in range(SPOTS):
            major, minor = get(room, SEMI_MAJOR, k) * x, get(room, SEMI_MINOR, k) * y
            motion = get(room, SLIP_MAJOR, k), get(room, SLIP_MINOR, k), get(room, SPIN_RATE, k)
            one = slip_share(major, minor, weight * get(room, BY_RULE, k), *motion, regularisation)
            increase(room, JUMP, k, one[0])
            increase(room, JUMP + 2, k, one[1])
            increase(room, JUMP + 4, k, one[2])


@kernel
def sum_slopes(first, end, easy, hard, regularisation, room):
    """Sums over the points of both spots of all lanes, side by side, into the rows from `SUM` on, which are zero."""
    wanting = blended = 0
    for k in range(SPOTS):
        semi_major, semi_minor = get(room, SEMI_MAJOR, k), get(room, SEMI_MINOR, k)
        motion = get(room, SLIP_MAJOR, k), get(room, SLIP_MINOR, k), get(room, SPIN_RATE, k)
        many, slope = blend(easy, hard, *rim_share(semi_major, semi_minor, *motion, regularisation))
        put(room, PART, k, 1.0 - many)
        put(room, BY_RULE, k, -slope)
        wanting += 1 if many > 0.0 else 0
        blended += 1 if slope > 0.0 else 0
    add_points(0, FEW, regularisation, room)
    if blended > 0:
        _add_jumps(0, FEW, regularisation, room)
    if wanting > 0:
        for k in range(SPOTS):
            put(room, PART, k, 1.0 - get(room, PART, k))
            put(room, BY_RULE, k, -get(room, BY_RULE, k))
        add_points(first, end, regularisation, room)
    if blended > 0:
        _add_jumps(first, end, regularisation, room)


@inlined
def _rule_slopes(semi_major, semi_minor, slip_major, slip_minor, spin, regularisation):
    """How `rim_share`'s quotient changes with each of the GIVEN numbers."""
    rim, square = rim_share(semi_major, semi_minor, slip_major, slip_minor, spin, regularisation)
    inverse = 2.0 / max(square, 1e-300)
    by_slip, by_size = -rim / max(square, 1e-300) * inverse, spin * spin * inverse
    size = semi_major * semi_major + ROUND * semi_minor * semi_minor
    return (
        slip_major * by_slip,
        slip_minor * by_slip,
        spin * size * inverse,
        semi_major * by_size,
        ROUND * semi_minor * by_size,
    )


@inlined
def _put_slopes(mean, slopes, rule, room, k):
    """Writes how a mean of spot k changes with each of the GIVEN numbers: by its points, and by the rule of these."""
    jump = get(room, JUMP + 2 * mean, k)
    put(room, SLOPES + 10 * mean, k, slopes[0] + jump * rule[0])
    put(room, SLOPES + 10 * mean + 2, k, slopes[1] + jump * rule[1])
    put(room, SLOPES + 10 * mean + 4, k, slopes[2] + jump * rule[2])
    put(room, SLOPES + 10 * mean + 6, k, slopes[3] + jump * rule[3])
    put(room, SLOPES + 10 * mean + 8, k, slopes[4] + jump * rule[4])


@kernel
def _slopes_of_sums(regularisation, room):
    """The slopes of the means along, across and of the moment from the sums."""
    for k in range(SPOTS):
        spin, semi_major, semi_minor = get(room, SPIN_RATE, k), get(room, SEMI_MAJOR, k), get(room, SEMI_MINOR, k)
        slip = get(room, SLIP_MAJOR, k), get(room, SLIP_MINOR, k)
        rule = _rule_slopes(semi_major, semi_minor, slip[0], slip[1], spin, regularisation)
        major, minor = 1.0 / max(semi_major, TINY), 1.0 / max(semi_minor, TINY)
        uu, uv, vv = get(room, SUM, k), get(room, SUM + 2, k), get(room, SUM + 4, k)
        x_uv, x_vv, y_uu = get(room, SUM + 6, k), get(room, SUM + 8, k), get(room, SUM + 10, k)
        y_uv, xx_vv, xy_uv = get(room, SUM + 12, k), get(room, SUM + 14, k), get(room, SUM + 16, k)
        yy_uu, x_v, y_u = get(room, SUM + 18, k), get(room, SUM + 20, k), get(room, SUM + 22, k)
        _put_slopes(0, (uu, uv, x_uv - y_uu, spin * x_uv * major, -spin * y_uu * minor), rule, room, k)
        _put_slopes(1, (uv, vv, x_vv - y_uv, spin * x_vv * major, -spin * y_uv * minor), rule, room, k)
        by_major, by_minor = (spin * (xx_vv - xy_uv) + x_v) * major, (spin * (yy_uu - xy_uv) - y_u) * minor
        turning = xx_vv - 2.0 * xy_uv + yy_uu
        _put_slopes(2, (x_uv - y_uu, x_vv - y_uv, turning, by_major, by_minor), rule, room, k)


@kernel
def _slopes_one_by_one(number, regularisation, room):
    """The same for a model without a rule of points, by differences."""
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
def slopes_of_mean(mean, room, k):
    """How mean 0, 1 or 2 (along, across, moment) of spot k changes with each of the GIVEN numbers."""
    first = SLOPES + 10 * mean
    return (
        get(room, first, k),
        get(room, first + 2, k),
        get(room, first + 4, k),
        get(room, first + 6, k),
        get(room, first + 8, k),
    )


@owning_kernel
def room_of_slopes(spot, regularisation, lanes, height):
    """A room of that many rows with the motion and the spots of the lanes, and the slopes of the means over these.

    All in one array: the compiler knows then that what is written is not what is read, and takes lanes at once.
    """
    room = from_cache_line(np.empty(height * LANES + SPARE))
    copy_rows(lanes, AXIS_DISTANCE, GIVEN_OUTER + 1, room)
    copy_rows(lanes, SLIP_MAJOR, JACOBIAN, room)
    clear_rows(room, SUM, PART)
    first, end, easy, hard = spot[2]
    if end > 0:
        sum_slopes(first, end, easy, hard, regularisation, room)
        _slopes_of_sums(regularisation, room)
    else:
        _slopes_one_by_one(spot[1], regularisation, room)
    return room
