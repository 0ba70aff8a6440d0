"""The shaft's equations of motion: what its bearings and what else acts do to it, with the derivatives.

    m x'' = F,   I_t theta_x'' + I_p w theta_y' = M_x,   I_t theta_y'' - I_p w theta_x' = M_y

x (3,) is the centre of mass, theta_x and theta_y tilts to first order, w the speed about the axis; what changes w turns
the shaft about its own axis. The inner ring of a bearing at the place a, facing s, stands in its own frame at
(x + a theta_y, y - a theta_x, s z + middle, s theta_x, s theta_y); its loads come back through the transpose. A viscous
contact makes a bearing's load that of where the ring would be a relaxation time T later: K (q + T q').

A run that begins settled is counted from the whirl that it begins with, Re(u exp(i angle)), u the linear response to
the unbalances: a state has place and rate beside that, so that a step errs by a share of the rest alone. Where steps
are long against the periods of modes, rates would else be off by some per cent, and works by more than there is.

The balls go round as prescribed, so that their cage does work. A bearing with its balls turned with the ring looks as
before, so that its energy changes with the balls' azimuth by y F_x - x F_y + theta_y M_x - theta_x M_y.
"""

import ctypes
import math
from typing import NamedTuple

import llvmlite.binding as llvm
import numpy as np
from numba import types

from bearing_twin import core
from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.quasi_static.ball_equilibrium import COORDINATES, OF_CONTACTS, PLACES, SPEED, Setting
from bearing_twin.kinds.bearing.quasi_static.equilibrium import azimuths_of
from bearing_twin.kinds.shaft.course import outer_loads, turned_to, whirl_of

# What the core does is called by its address, which kernels know by this name.
llvm.add_symbol("core_ring_loads", ctypes.cast(core.library().core_ring_loads, ctypes.c_void_p).value)
_ring_loads = types.ExternalFunction("core_ring_loads", types.float64(*(types.intp,) * 12))

RATE = COORDINATES  # where the rates stand in a state, behind the coordinates
MOVING = 2 * COORDINATES
LOAD_WORK, BEARING_WORK, DISSIPATED, CAGE_WORK, STATE = range(MOVING, MOVING + 5)
"""Works since the start [J]: of loads and unbalances on the shaft, of the shaft on its bearings without what they
dissipate, that, and of both cages; of the first two without those of steady loads, which follow from the place."""


class ShaftSeat(NamedTuple):
    """One bearing on the shaft: its balance, place [m], side it faces, `middle` [m] along its own axis.

    `first` [rad] is the azimuth of ball 0 at the start, `ratio` the orbit's speed over the shaft's, `gravity` (3,) in
    the bearing's own frame.
    """

    setting: Setting
    balls: int
    place: float
    facing: float
    middle: float
    first: float
    ratio: float
    gravity: tuple


class Rotor(NamedTuple):
    """What the equations of motion need at any time (SI): `weight` (5,), `unbalances` (n, 3), `whirl` (2, 5).

    The last has real and imaginary parts of u, [m] and [rad]; `steady` (5,) are the loads when the run starts.
    """

    seats: tuple
    mass: float
    transverse: float
    polar: float
    relaxation_time: float
    weight: np.ndarray
    unbalances: np.ndarray
    whirl: np.ndarray
    steady: np.ndarray


class Balls(NamedTuple):
    """The balls of both bearings at work, one behind the other: azimuths (N,) [rad] and balances (N, PLACES).

    `seats` (2, SEAT) are what the core is told of each bearing, `counts` (2,) its balls; `rings` (2, 5), `loads` and
    `stiffness` are those of the rings in their own frames, `contacts` (N, OF_CONTACTS) of the balls. `row` is room.
    """

    seats: np.ndarray
    counts: np.ndarray
    azimuths: np.ndarray
    places: np.ndarray
    rings: np.ndarray
    loads: np.ndarray
    stiffness: np.ndarray
    contacts: np.ndarray
    row: np.ndarray


class Moment(NamedTuple):
    """What the bearings do at one moment: `load` (5,) from outside that holds the shaft against them, `stiffness`.

    `outer` (5,) are the loads on the shaft but its weight, `turning` (2,) its angle and speed, `rate` (5,) that of its
    coordinates. The rest is room.
    """

    load: np.ndarray
    stiffness: np.ndarray
    outer: np.ndarray
    turning: np.ndarray
    rate: np.ndarray
    ahead: np.ndarray
    work: np.ndarray


def seats_of(rotor: Rotor) -> np.ndarray:
    """What the core is told of both bearings (2, SEAT)."""
    return np.array([one.setting.numbers(one.gravity, one.place, one.facing, one.middle) for one in rotor.seats])


def new_balls(rotor: Rotor) -> Balls:
    """Room for the balls of both bearings, whose balances begin from nothing."""
    counts = np.array([seat.balls for seat in rotor.seats])
    count = int(counts.sum())
    shapes = (count,), (count, PLACES), (2, 5), (2, 5), (2, 5, 5), (count, OF_CONTACTS), (5,)
    balls = Balls(seats_of(rotor), counts, *(np.zeros(shape) for shape in shapes))
    balls.places[:] = np.nan
    return balls


def azimuths_at(rotor: Rotor, angle: float) -> np.ndarray:
    """Azimuths [rad] (N,) of the balls of both bearings, the shaft turned by `angle` [rad]."""
    return np.concatenate([azimuths_of(seat.balls, seat.first + seat.ratio * angle) for seat in rotor.seats])


def new_moment() -> Moment:
    """Room for one moment."""
    return Moment(*(np.zeros(shape) for shape in ((5,), (5, 5), (5,), (2,), (5,), (5,), (5,))))


@inlined
def ring_at(seat, q, ring):
    """The inner ring of a bearing in its own frame (5,), the shaft at `q` (5,)."""
    ring[0], ring[1] = q[0] + seat.place * q[4], q[1] - seat.place * q[3]
    ring[2] = seat.facing * q[2] + seat.middle
    ring[3], ring[4] = seat.facing * q[3], seat.facing * q[4]


@inlined
def _add_loads(seat, load, total):
    """Adds loads (5,) on a ring, in its own frame, to those on the shaft."""
    total[0] += load[0]
    total[1] += load[1]
    total[2] += seat.facing * load[2]
    total[3] += seat.facing * load[3] - seat.place * load[1]
    total[4] += seat.facing * load[4] + seat.place * load[0]


@kernel
def shaft_loads(rotor, angle, speed, q, balls, load, stiffness, contacts):
    """External load (5,) [N, N m] that holds the shaft at `q` against its bearings, and its derivative; its scale.

    The shaft has turned by `angle` [rad] and turns at `speed`; `balls` are left as they are there, with their contacts
    where these are wanted.
    """
    at = 0
    for b in range(2):
        seat = rotor.seats[b]
        balls.seats[b, SPEED] = speed
        for k in range(seat.balls):
            balls.azimuths[at] = seat.first + seat.ratio * angle + 2.0 * math.pi * k / seat.balls
            at += 1
    return _ring_loads(
        2,
        balls.counts.ctypes.data,
        balls.seats.ctypes.data,
        balls.azimuths.ctypes.data,
        q.ctypes.data,
        balls.places.ctypes.data,
        balls.rings.ctypes.data,
        balls.loads.ctypes.data,
        balls.stiffness.ctypes.data,
        load.ctypes.data,
        stiffness.ctypes.data,
        balls.contacts.ctypes.data if contacts else 0,
    )


@inlined
def _cage_load(ring, load):
    return ring[1] * load[0] - ring[0] * load[1] + ring[4] * load[3] - ring[3] * load[4]


@kernel
def rates(system, time, state, slopes):
    """The slopes (STATE,) of a state at `time` [s]; `system` is (rotor, part of the course, balls, moment)."""
    rotor, part, balls, moment = system
    angle, speed = turned_to(part, time)
    moment.turning[0], moment.turning[1] = angle, speed
    for i in range(COORDINATES):
        place, rate, _ = whirl_of(rotor, part, time, i)
        moment.rate[i] = rate + state[RATE + i]
        moment.ahead[i] = place + state[i] + rotor.relaxation_time * moment.rate[i]
    shaft_loads(rotor, angle, speed, moment.ahead, balls, moment.load, moment.stiffness, False)
    outer_loads(rotor, part, time, angle, speed, moment.outer)
    spin = rotor.polar * speed
    outer = given = viscous = 0.0
    for i in range(COORDINATES):
        rate = moment.rate[i]
        slopes[i] = state[RATE + i]
        inertia = rotor.mass if i < 3 else rotor.transverse
        force = moment.outer[i] + rotor.weight[i] - moment.load[i]
        if i == 3:
            force -= spin * moment.rate[4]
        elif i == 4:
            force += spin * moment.rate[3]
        slopes[RATE + i] = force / inertia - whirl_of(rotor, part, time, i)[2]
        outer += (moment.outer[i] - rotor.steady[i]) * rate
        given += (moment.load[i] - rotor.steady[i] - rotor.weight[i]) * rate
        for j in range(COORDINATES):
            viscous += rotor.relaxation_time * rate * moment.stiffness[i, j] * moment.rate[j]
    slopes[LOAD_WORK], slopes[BEARING_WORK], slopes[DISSIPATED] = outer, given - viscous, viscous
    slopes[CAGE_WORK] = 0.0
    for b in range(2):
        orbit = rotor.seats[b].ratio * speed
        slopes[CAGE_WORK] += orbit * _cage_load(balls.rings[b], balls.loads[b])


@kernel
def jacobian(system, _state, matrix):
    """Derivatives (STATE, MOVING) of the slopes that `rates` has just given, exact but for K's own in what is lost."""
    rotor, _, balls, moment = system
    matrix[:] = 0.0
    late, k = rotor.relaxation_time, moment.stiffness
    for i in range(COORDINATES):
        matrix[i, RATE + i] = 1.0
        inertia = rotor.mass if i < 3 else rotor.transverse
        for j in range(COORDINATES):
            matrix[RATE + i, j] = -k[i, j] / inertia
            matrix[RATE + i, RATE + j] = -late * k[i, j] / inertia
        matrix[LOAD_WORK, RATE + i] = moment.outer[i] - rotor.steady[i]
        by_place = lost = 0.0
        for j in range(COORDINATES):
            rate = moment.rate[j]
            by_place += k[j, i] * rate
            lost += late * (k[i, j] + k[j, i]) * rate
        matrix[BEARING_WORK, i] = by_place
        held = rotor.steady[i] + rotor.weight[i]
        matrix[BEARING_WORK, RATE + i] = moment.load[i] - held + late * by_place - lost
        matrix[DISSIPATED, RATE + i] = lost
    spin = rotor.polar * moment.turning[1] / rotor.transverse
    matrix[RATE + 3, RATE + 4] -= spin
    matrix[RATE + 4, RATE + 3] += spin
    for b in range(2):
        orbit = rotor.seats[b].ratio * moment.turning[1]
        _cage_row(rotor.seats[b], balls, b, moment.work)
        for i in range(COORDINATES):
            matrix[CAGE_WORK, i] += orbit * moment.work[i]
            matrix[CAGE_WORK, RATE + i] += late * orbit * moment.work[i]


@inlined
def _cage_row(seat, balls, b, out):
    """Derivatives (5,) of a cage's load, as of `_cage_load`, by the shaft's coordinates."""
    ring, load, stiffness, row = balls.rings[b], balls.loads[b], balls.stiffness[b], balls.row
    row[0], row[1], row[2], row[3], row[4] = -load[1], load[0], 0.0, -load[4], load[3]
    for i in range(COORDINATES):
        for j in range(COORDINATES):
            if i == 0 or i == 3:
                row[j] += stiffness[i, j] * ring[i + 1]
            elif i == 1 or i == 4:
                row[j] -= stiffness[i, j] * ring[i - 1]
    out[:] = 0.0
    _add_loads(seat, row, out)
