"""What one sample of a shaft on two bearings holds, computed from its state."""

import functools

from bearing_twin.base.sample import Channel
from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.parameters import GREATEST_ANGLE, GREATEST_SQUEEZE
from bearing_twin.kinds.bearing.quasi_static.ball_equilibrium import COORDINATES, IDLE
from bearing_twin.kinds.shaft.course import outer_loads, turned_to
from bearing_twin.kinds.shaft.parameters import SIDES, ShaftScene
from bearing_twin.kinds.shaft.rotor import (
    BEARING_WORK,
    CAGE_WORK,
    DISSIPATED,
    LOAD_WORK,
    RATE,
    ring_at,
    shaft_loads,
)

BEARING, ABOUT, RACE = "bearing", "about", "race"  # axes: left, right; x, y; inner, outer
LOADS, ANGLES = 2, 4  # where a ball's contacts have them, inner and outer
LOAD, HEAD, REST = 30, 35, 8  # where the load stands; numbers before and after those of the balls


def channels(parameters: ShaftScene) -> tuple[Channel, ...]:
    """The channels of a scene; everything is in `shaft_link`, rows of bearings are left, right."""
    return _channels(*(getattr(parameters, side).geometry.balls for side in SIDES))


# The table knows the numbers of balls alone: to look one up by a scene would hash all of it.
@functools.cache
def _channels(*balls: int) -> tuple[Channel, ...]:
    of_balls = (
        row
        for side, n in zip(SIDES, balls, strict=True)
        for row in (
            Channel(
                f"{side}_normal_load", "N", (n, 2), f"of the {side} bearing's balls on its raceways", ("ball", RACE)
            ),
            Channel(
                f"{side}_contact_angle",
                "rad",
                (n, 2),
                f"of the {side} bearing's balls, > 0 where the shaft pushes the way the bearing faces",
                ("ball", RACE),
            ),
        )
    )
    return (
        Channel("position", "m", (3,), "of the shaft's centre of mass"),
        Channel("tilt", "rad", (2,), "of the shaft about x and y", (ABOUT,)),
        Channel("velocity", "m/s", (3,), "of the shaft's centre of mass"),
        Channel("tilt_rate", "rad/s", (2,), "of the shaft about x and y, its spin left out", (ABOUT,)),
        Channel("shaft_angle", "rad", (), "about +z, not wrapped"),
        Channel("shaft_speed", "rad/s", (), "about +z"),
        Channel("ring_offset", "m", (2, 3), "of each inner ring's centre from where it is as made", (BEARING, "axis")),
        Channel("bearing_force", "N", (2, 3), "of each bearing on the shaft", (BEARING, "axis")),
        Channel("bearing_moment", "N m", (2, 2), "of each on the shaft, about its ring's centre", (BEARING, ABOUT)),
        Channel("orbit_angle", "rad", (2,), "azimuth of ball 0 of each bearing, not wrapped", (BEARING,)),
        Channel("load", "N", (3,), "on the shaft from outside, with its unbalances, its weight left out"),
        Channel("load_moment", "N m", (2,), "of that load, about the centre of mass", (ABOUT,)),
        *of_balls,
        Channel("kinetic_energy", "J", (), "of the shaft, its spin left out"),
        Channel("potential_energy", "J", (), "of the shaft's weight"),
        Channel("elastic_energy", "J", (), "stored in all contacts"),
        Channel("load_work", "J", (), "of loads and unbalances on the shaft since the start, its weight left out"),
        Channel("bearing_work", "J", (), "of the shaft on both bearings since the start, without what is dissipated"),
        Channel("cage_work", "J", (), "of both cages on the balls that they lead round, since the start"),
        Channel("dissipated", "J", (), "in viscous contacts since the start"),
        Channel("gross_work", "J", (), "of loads and bearings, that of each step counted by its size"),
    )


def place_of(channel: Channel, index: tuple[int, ...]) -> tuple[str, str]:
    """The body and the contact that a number of a channel belongs to, such as "left ball 3" and "outer race"."""
    side = channel.name.partition("_")[0]
    if side in SIDES:
        return f"{side} ball {index[0]}", ("inner race", "outer race")[index[1]]
    return (f"{SIDES[index[0]]} bearing" if channel.axes[:1] == (BEARING,) else "shaft"), ""


@inlined
def _write_bearing(seat, load, at, b, row):
    """Force and moment on the shaft by bearing b, in the shaft's axes."""
    s = seat.facing
    for i in range(3):
        turn = s if i == 2 else 1.0
        row[at + 6 + 3 * b + i] = -turn * load[i]
    row[at + 12 + 2 * b], row[at + 13 + 2 * b] = -s * load[3], -s * load[4]


@kernel
def write_row(system, time, state, gross, row):
    """Writes all channels of a state (STATE,) at `time` [s], side by side in their order.

    Returns the greatest squeeze or contact angle of a ball over its limit.
    """
    rotor, part, balls, moment = system
    angle, speed = turned_to(part, time)
    for i in range(COORDINATES):
        row[i], row[COORDINATES + i] = state[i], state[RATE + i]
        moment.ahead[i] = state[i] + rotor.relaxation_time * state[RATE + i]
    row[10], row[11] = angle, speed
    outer_loads(rotor, part, time, angle, speed, row[LOAD : LOAD + COORDINATES])
    kinetic = potential = elastic = steady = 0.0
    for i in range(COORDINATES):
        steady += rotor.steady[i] * state[i]
        kinetic += 0.5 * (rotor.mass if i < 3 else rotor.transverse) * state[RATE + i] ** 2
        potential -= rotor.weight[i] * state[i]
    shaft_loads(rotor, angle, speed, moment.ahead, balls, moment.load, moment.stiffness, True)
    late = rotor.relaxation_time
    for i in range(COORDINATES):
        # contacts hold what they do a relaxation time later, less the work until then
        elastic -= late * moment.load[i] * state[RATE + i]
        for j in range(COORDINATES):
            elastic += 0.5 * late * late * state[RATE + i] * moment.stiffness[i, j] * state[RATE + j]
    at, worst, first = HEAD, 0.0, 0
    for b in range(2):
        seat, n = rotor.seats[b], rotor.seats[b].balls
        found = balls.contacts[first : first + n]
        first += n
        _write_bearing(seat, balls.loads[b], 12, b, row)
        ring_at(seat, state, moment.work)
        row[12 + 3 * b], row[13 + 3 * b] = moment.work[0], moment.work[1]
        row[14 + 3 * b] = seat.facing * (moment.work[2] - seat.middle)
        row[28 + b] = seat.first + seat.ratio * angle
        power = seat.setting.inner.law.power + 1.0
        greatest = found[:, LOADS : LOADS + 2].max()
        for k in range(n):
            approach, load, lean = found[k, 0:2], found[k, LOADS : LOADS + 2], found[k, ANGLES : ANGLES + 2]
            if load[0] > 0.0 and load[1] > 0.0:
                worst = max(worst, (approach[0] + approach[1]) / (GREATEST_SQUEEZE * 2.0 * seat.setting.ball_radius))
            for side in range(2):
                row[at + 2 * k + side] = load[side]
                elastic += load[side] * max(approach[side], 0.0) / power
                row[at + 2 * (n + k) + side] = lean[side] if load[side] > 0.0 else 0.0
                if load[side] > IDLE * greatest:
                    worst = max(worst, abs(lean[side]) / GREATEST_ANGLE)
        at += 4 * n
    row[at], row[at + 1], row[at + 2] = kinetic, potential, elastic
    row[at + 3], row[at + 4] = state[LOAD_WORK] + steady, state[BEARING_WORK] + steady - potential
    row[at + 5], row[at + 6], row[at + 7] = state[CAGE_WORK], state[DISSIPATED], gross
    return worst
