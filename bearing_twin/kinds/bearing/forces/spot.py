"""Friction of the ball-raceway contacts over their elliptic spots, by any row of `friction.FRICTIONS` that needs one.

Each point of a spot slides with slip + spin x r (Contensou, Erismann), so that spinning weakens the friction force, and
a drilling torque acts about the contact normal. The spot is flat and its pressure Hertz's: the differential slip of a
curved spot (Heathcote) is left out. Friction at a point is part of `raceway_contact`; bearings with it have an empty
`spot`: the branches below are then dropped while compiling, and cost neither time to run nor to compile.

A spot's axes are the meridian across the groove (major) and the ring's circumference (minor).
"""

import math
from typing import NamedTuple

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.friction import friction_of
from bearing_twin.contact.spot_rules import POINTS, blend, over_few, rim_share, slip_share
from bearing_twin.kinds.bearing.forces.along_groove import coefficient_along
from bearing_twin.kinds.bearing.forces.equations import ON_AXIS, lane_position, placed, put_rates, raceway_contact
from bearing_twin.kinds.bearing.forces.layout import (
    ACROSS,
    ALONG,
    AXIAL_PUSH,
    AXIS_GAP,
    DISSIPATED,
    DRIVE_WORK,
    GIVEN_INNER,
    GIVEN_OUTER,
    GROSS_WORK,
    LEVER,
    LIMIT,
    MANY,
    MINOR_X,
    MINOR_Y,
    MOMENT,
    NORMAL_AXIAL,
    NORMAL_RADIAL,
    ORBIT_ANGLE,
    RING_SPEED,
    SEMI_MAJOR,
    SEMI_MINOR,
    SLIP_MAJOR,
    SLIP_MINOR,
    SPIN,
    SPIN_RATE,
    SPOTS,
    VELOCITY,
)
from bearing_twin.numerics.lanes import LANE_RATES, LANES, get, get_vector, increase, increase_vector, put
from bearing_twin.numerics.rotation import about_z, add, cosine_sine, dot, scaled

INNER_SPOTS, OUTER_SPOTS = 0, LANES  # where the spots of a ring begin among the SPOTS of all lanes


class Spot(NamedTuple):
    """A spot in the ball's frame; its minor axis (x, y, 0) and the outward direction (y, -x, 0) tell all its axes.

    `limit` mu N [N], `axis_distance` of the ball's centre from the ring's axis [m], the normal's parts outwards and
    along the axis, `lever` from the ball's centre to the contact [m], semi-axes [m], slip along them [m/s], and spin
    about the normal [rad/s].
    """

    limit: float
    axis_distance: float
    minor: tuple[float, float]
    normal_radial: float
    normal_axial: float
    lever: float
    semi_major: float
    semi_minor: float
    slip_major: float
    slip_minor: float
    spin_rate: float


class SpotAnswer(NamedTuple):
    """What friction over a spot does: force and torque on the ball, power of the ring on it and power lost [W].

    `drilling` [N m] is the torque's part about the contact normal, the rest is the force's about the ball's centre;
    `turning` [N m] is the moment on the ball about the ring's axis.
    """

    friction: tuple[float, float, float]
    drilling: float
    torque: tuple[float, float, float]
    drive_power: float
    turning: float
    dissipation: float


@inlined
def along_axes(spot, major, minor, normal):
    """The vector with these parts along a spot's axes and its normal, which are right-handed, in the ball's frame."""
    x, y = spot.minor
    outwards = major * spot.normal_axial + normal * spot.normal_radial
    return (outwards * y + minor * x, minor * y - outwards * x, normal * spot.normal_axial - major * spot.normal_radial)


@inlined
def spot_of(coefficient, axes, contact, centre, position):
    """The spot of a contact with the ring centred at `centre`, by the coefficient of friction.

    `axes` are `along_groove.axes_along`; the spot's size follows the approach, also where a viscous part adds to the
    load.
    """
    normal, slip = contact.normal, contact.slip
    offset, axis_distance, inverse = placed(position, centre)
    x, y = -inverse * offset[1], inverse * offset[0]
    radial, axial = y * normal[0] - x * normal[1], normal[2]
    root = math.sqrt(max(contact.approach, 0.0))
    return Spot(
        limit=coefficient * contact.normal_load,
        axis_distance=axis_distance,
        minor=(x, y),
        normal_radial=radial,
        normal_axial=axial,
        lever=dot(contact.arm, normal),
        semi_major=root * coefficient_along(axes[0], radial),
        semi_minor=root * coefficient_along(axes[1], radial),
        slip_major=axial * (y * slip[0] - x * slip[1]) - radial * slip[2],
        slip_minor=x * slip[0] + y * slip[1],
        spin_rate=contact.spin_rate,
    )


@inlined
def spot_answer(spot, ring_speed, along, across, moment):
    """The answer of a spot with these means of the slip's direction and of its moment [m]."""
    limit, lever = spot.limit, spot.lever
    turning = -limit * ((spot.axis_distance + lever * spot.normal_radial) * across + moment * spot.normal_axial)
    loss = along * spot.slip_major + across * spot.slip_minor + moment * spot.spin_rate
    return SpotAnswer(
        friction=along_axes(spot, -limit * along, -limit * across, 0.0),
        drilling=-limit * moment,
        torque=along_axes(spot, limit * lever * across, -limit * lever * along, -limit * moment),
        drive_power=ring_speed * turning,
        turning=turning,
        dissipation=limit * loss,
    )


@inlined
def means_of(number, semi_major, semi_minor, slip_major, slip_minor, spin, regularisation):
    """The means over a spot that `spot_answer` takes, by the friction model of that number."""
    unit = friction_of(number, 1.0, semi_major, semi_minor, slip_major, slip_minor, spin, 1.0, regularisation)
    return -unit.force_major, -unit.force_minor, -unit.torque


@inlined
def _keep(spot, lanes, k):
    """Writes spot k into its rows."""
    put(lanes, LIMIT, k, spot.limit)
    put(lanes, AXIS_GAP, k, spot.axis_distance)
    put(lanes, MINOR_X, k, spot.minor[0])
    put(lanes, MINOR_Y, k, spot.minor[1])
    put(lanes, NORMAL_RADIAL, k, spot.normal_radial)
    put(lanes, NORMAL_AXIAL, k, spot.normal_axial)
    put(lanes, LEVER, k, spot.lever)
    put(lanes, SEMI_MAJOR, k, spot.semi_major)
    put(lanes, SEMI_MINOR, k, spot.semi_minor)
    put(lanes, SLIP_MAJOR, k, spot.slip_major)
    put(lanes, SLIP_MINOR, k, spot.slip_minor)
    put(lanes, SPIN_RATE, k, spot.spin_rate)


@inlined
def kept_spot(lanes, k):
    """Spot k from its rows."""
    return Spot(
        limit=get(lanes, LIMIT, k),
        axis_distance=get(lanes, AXIS_GAP, k),
        minor=(get(lanes, MINOR_X, k), get(lanes, MINOR_Y, k)),
        normal_radial=get(lanes, NORMAL_RADIAL, k),
        normal_axial=get(lanes, NORMAL_AXIAL, k),
        lever=get(lanes, LEVER, k),
        semi_major=get(lanes, SEMI_MAJOR, k),
        semi_minor=get(lanes, SEMI_MINOR, k),
        slip_major=get(lanes, SLIP_MAJOR, k),
        slip_minor=get(lanes, SLIP_MINOR, k),
        spin_rate=get(lanes, SPIN_RATE, k),
    )


@inlined
def keep_spots(spot, inner, outer, centre, position, lanes, k):
    """Keeps the spots of both contacts of lane k's ball, where the bearing's `spot` is not empty."""
    if len(spot) > 0:
        _keep(spot_of(spot[0], spot[3], inner, centre, position), lanes, INNER_SPOTS + k)
        _keep(spot_of(spot[0], spot[4], outer, ON_AXIS, position), lanes, OUTER_SPOTS + k)


@inlined
def contacts_of_spots(spot, bearing, lanes):
    """`equations.raceway_rates` by contacts without friction, whose spots are kept; put into its caller as that is."""
    for k in range(LANES):
        cosine, sine = cosine_sine(get(lanes, ORBIT_ANGLE, k))
        position = lane_position(lanes, k)
        velocity, spin = get_vector(lanes, VELOCITY, k), get_vector(lanes, SPIN, k)
        centre = about_z(cosine, -sine, bearing.offset)
        speed, given = get(lanes, RING_SPEED, k), get(lanes, GIVEN_INNER, k)
        inner = raceway_contact(bearing, bearing.inner, given, centre, speed, position, velocity, spin)
        given = get(lanes, GIVEN_OUTER, k)
        outer = raceway_contact(bearing, bearing.outer, given, ON_AXIS, 0.0, position, velocity, spin)
        gravity = about_z(cosine, -sine, bearing.gravity)
        put_rates(bearing, gravity, position, velocity, spin, inner, outer, lanes, k)
        put(lanes, AXIAL_PUSH, k, -inner.axial_moment)
        keep_spots(spot, inner, outer, centre, position, lanes, k)


@kernel
def over_few_of_all(easy, hard, regularisation, lanes):
    """The part of few points in the means over all spots, and how many of these want more points, of whichever lane."""
    wanting = 0
    for k in range(SPOTS):
        semi_major, semi_minor = get(lanes, SEMI_MAJOR, k), get(lanes, SEMI_MINOR, k)
        slip_major, slip_minor = get(lanes, SLIP_MAJOR, k), get(lanes, SLIP_MINOR, k)
        spin = get(lanes, SPIN_RATE, k)
        rim, square = rim_share(semi_major, semi_minor, slip_major, slip_minor, spin, regularisation)
        many, _ = blend(easy, hard, rim, square)
        few = over_few(semi_major, semi_minor, slip_major, slip_minor, spin, square)
        put(lanes, MANY, k, many)
        put(lanes, ALONG, k, (1.0 - many) * few[0])
        put(lanes, ACROSS, k, (1.0 - many) * few[1])
        put(lanes, MOMENT, k, (1.0 - many) * few[2])
        wanting += 1 if many > 0.0 else 0
    return wanting


@kernel
def over_spots(first, end, easy, hard, regularisation, lanes):
    """The means over both spots of all lanes, side by side: what `spot_rules.blended_over_spot` sums."""
    if over_few_of_all(easy, hard, regularisation, lanes) > 0:
        here = min(SPOTS, len(lanes))  # SPOTS, which LLVM must not know: it writes loops of eight out number by number
        for i in range(first, end):
            x, y, weight = POINTS[i, 0], POINTS[i, 1], POINTS[i, 2]
            for k in range(here):
                major, minor = get(lanes, SEMI_MAJOR, k) * x, get(lanes, SEMI_MINOR, k) * y
                slip_major, slip_minor = get(lanes, SLIP_MAJOR, k), get(lanes, SLIP_MINOR, k)
                share, spin = weight * get(lanes, MANY, k), get(lanes, SPIN_RATE, k)
                one = slip_share(major, minor, share, slip_major, slip_minor, spin, regularisation)
                increase(lanes, ALONG, k, one[0])
                increase(lanes, ACROSS, k, one[1])
                increase(lanes, MOMENT, k, one[2])


@kernel
def _one_by_one(number, regularisation, lanes):
    """The same for a model without a rule of points."""
    for k in range(SPOTS):
        axes = get(lanes, SEMI_MAJOR, k), get(lanes, SEMI_MINOR, k)
        slip = get(lanes, SLIP_MAJOR, k), get(lanes, SLIP_MINOR, k)
        means = means_of(number, axes[0], axes[1], slip[0], slip[1], get(lanes, SPIN_RATE, k), regularisation)
        put(lanes, ALONG, k, means[0])
        put(lanes, ACROSS, k, means[1])
        put(lanes, MOMENT, k, means[2])


@kernel
def find_means(spot, bearing, lanes):
    """The means over the spots that the lanes keep, by whatever model."""
    first, end, easy, hard = spot[2]
    if end > 0:
        over_spots(first, end, easy, hard, bearing.friction_regularisation, lanes)
    else:
        _one_by_one(spot[1], bearing.friction_regularisation, lanes)


@inlined
def kept_answer(ring_speed, lanes, k):
    """What friction over spot k does, by its rows."""
    along, across, moment = get(lanes, ALONG, k), get(lanes, ACROSS, k), get(lanes, MOMENT, k)
    return spot_answer(kept_spot(lanes, k), ring_speed, along, across, moment)


@kernel
def add_answers(ball_mass, ball_inertia, lanes):
    """Adds what friction over the spots does to the rates of all lanes."""
    inverse_mass, inverse_inertia = 1.0 / ball_mass, 1.0 / ball_inertia
    for k in range(LANES):
        one = kept_answer(get(lanes, RING_SPEED, k), lanes, INNER_SPOTS + k)
        two = kept_answer(0.0, lanes, OUTER_SPOTS + k)
        increase_vector(lanes, LANE_RATES + VELOCITY, k, scaled(inverse_mass, add(one.friction, two.friction)))
        increase_vector(lanes, LANE_RATES + SPIN, k, scaled(inverse_inertia, add(one.torque, two.torque)))
        power = get(lanes, LANE_RATES + DRIVE_WORK, k) + one.drive_power
        put(lanes, LANE_RATES + DRIVE_WORK, k, power)
        increase(lanes, LANE_RATES + DISSIPATED, k, one.dissipation + two.dissipation)
        put(lanes, LANE_RATES + GROSS_WORK, k, abs(power))
        increase(lanes, AXIAL_PUSH, k, -one.turning)


@inlined
def rates_with_spots(spot, bearing, lanes):
    """`equations.raceway_rates` with friction over the spots, where the bearing has it: its `spot` is not empty."""
    if len(spot) > 0:
        contacts_of_spots(spot, bearing, lanes)
        find_means(spot, bearing, lanes)
        add_answers(bearing.ball_mass, bearing.ball_inertia, lanes)
