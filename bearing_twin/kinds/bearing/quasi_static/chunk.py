"""Equilibria one after another, while the inner ring turns and the balls go round in one cage."""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.quasi_static.contacts import Contacts, empty_contacts, shared, write_contacts
from bearing_twin.kinds.bearing.quasi_static.forces import Setting
from bearing_twin.kinds.bearing.quasi_static.newton import FOUND
from bearing_twin.kinds.bearing.quasi_static.ring_balance import first_ring, ring_in_balance
from bearing_twin.kinds.bearing.quasi_static.turn_table import (
    INERTIA,
    SIZE,
    SIZES,
    add_ring_friction,
    friction_at,
    pass_speed,
    put_settled,
)
from bearing_twin.numerics.rotation import quaternion_product, turned
from bearing_twin.numerics.statuses import STOPPED


class Course(NamedTuple):
    """What is prescribed at the instants (T,): seconds since the one before, the ring's turn [rad] and speed [rad/s].

    `held` (T, 5) [m, rad] are the coordinates of the ring, of which `free` (5,) follow `wanted` (5,) [N, N m].
    """

    step: np.ndarray
    turn: np.ndarray
    speed: np.ndarray
    held: np.ndarray
    free: np.ndarray
    wanted: np.ndarray


class State(NamedTuple):
    """What goes on from instant to instant: azimuth of ball 0, orbit over ring speed (2,); ring, balls, attitudes."""

    cage: np.ndarray
    q: np.ndarray
    place: np.ndarray
    attitude: np.ndarray


class Instants(NamedTuple):
    """What was found (T, ...): azimuth of ball 0, orbit speed, ring, load on it, balls' places, attitudes, contacts."""

    azimuth: np.ndarray
    orbit: np.ndarray
    q: np.ndarray
    load: np.ndarray
    place: np.ndarray
    attitude: np.ndarray
    contacts: Contacts


def new_instants(count: int, balls: int) -> Instants:
    """Room for so many instants."""
    shapes = ((), (), (5,), (5,), (balls, 2), (balls, 4))
    return Instants(*(np.zeros((count, *shape)) for shape in shapes), empty_contacts(count, balls))


@inlined
def at_speed(setting, speed):
    """The numbers of the balance with the ring turning at `speed` [rad/s]."""
    return Setting(
        setting.inner,
        setting.outer,
        setting.ball_radius,
        setting.ball_mass,
        setting.pitch_diameter,
        setting.arm,
        setting.lever,
        speed,
        setting.share_inner,
        setting.share_outer,
        setting.unseen,
    )


@inlined
def _row(contacts, t):
    return Contacts(
        contacts.approach[t],
        contacts.load[t],
        contacts.angle[t],
        contacts.friction[t],
        contacts.curvature_small[t],
        contacts.curvature_large[t],
        contacts.orbit[t],
        contacts.roll[t],
        contacts.pitch[t],
        contacts.centrifugal[t],
        contacts.along[t],
    )


@kernel
def place_balls(setting, gravity, azimuth, directions, weight):
    """Cosines and sines of evenly spaced balls, and the weights on them (radial, axial)."""
    balls = len(directions)
    for k in range(balls):
        angle = azimuth + 2.0 * math.pi * k / balls
        directions[k, 0], directions[k, 1] = math.cos(angle), math.sin(angle)
        weight[k, 0] = setting.ball_mass * (gravity[0] * directions[k, 0] + gravity[1] * directions[k, 1])
        weight[k, 1] = setting.ball_mass * gravity[2]


@kernel
def _solve(setting, directions, course, t, wanted, state, weight, longest, load, stiffness):
    """The equilibrium of instant t, from the one before, and if that leads nowhere from nothing."""
    for i in range(5):
        if not course.free[i]:
            state.q[i] = course.held[t, i]
    status, _, _ = ring_in_balance(
        setting, directions, state.q, course.free, wanted, state.place, weight, longest, load, stiffness
    )
    if status == FOUND:
        return status
    for i in range(5):
        state.q[i] = 0.0 if course.free[i] else course.held[t, i]
    state.place[:] = np.nan
    scales = np.array([1.0, 1.0, 1.0, setting.arm, setting.arm])
    first_ring(setting, directions, course.free, wanted, scales, longest, state.q)
    status, _, _ = ring_in_balance(
        setting, directions, state.q, course.free, wanted, state.place, weight, longest, load, stiffness
    )
    return status


@kernel
def _rub(setting, table, azimuth, speed, directions, rows, weight, wanted, left):
    """Adds friction (`rows`) to the forces on the balls, and leaves of the wanted loads (5,) what it does not carry.

    It acts along the contacts as they were looked at, which lie within 1e-4 rad of those found.
    """
    balls = len(rows)
    for k in range(balls):
        friction_at(table, azimuth + 2.0 * math.pi * k / balls, k, rows)
    pass_speed(rows, speed)
    for k in range(balls):
        weight[k, 0] += rows[k, 0] + rows[k, 2] + rows[k, INERTIA]
        weight[k, 1] += rows[k, 1] + rows[k, 3] + rows[k, INERTIA + 1]
    left[:] = 0.0
    add_ring_friction(setting, directions, rows, left)
    for i in range(5):
        left[i] = wanted[i] - left[i]


@kernel
def equilibria(setting, gravity, table, course, state, longest, out, stop):
    """Fills `out` (`Instants`); returns (status, instant) of the first that has no equilibrium, else (FOUND, T).

    `table` (LOOKS, SIZES) is what the motion of balls whose axes have settled does to them (`turn_table`), empty where
    axes are those of rolling.

    Looks at `stop` (1,) before every instant, and ends with STOPPED there where it is not 0.

    Between two instants the balls go round by the cage's share of the ring's turn at the first, and turn about
    themselves as they do at the second.
    """
    balls = len(state.place)
    directions, weight = np.empty((balls, 2)), np.empty((balls, 2))
    load, stiffness = np.zeros(5), np.zeros((5, 5))
    rows, wanted = np.zeros((balls, SIZES)), course.wanted.copy()
    gamma = 2.0 * setting.ball_radius / setting.pitch_diameter
    for t in range(len(course.turn)):
        if stop[0] != 0:
            return STOPPED, t
        here = at_speed(setting, 0.0 if len(table) > 0 else course.speed[t])
        state.cage[0] += state.cage[1] * course.turn[t]
        place_balls(here, gravity, state.cage[0], directions, weight)
        if len(table) > 0:
            _rub(here, table, state.cage[0], course.speed[t], directions, rows, weight, course.wanted, wanted)
        status = _solve(here, directions, course, t, wanted, state, weight, longest, load, stiffness)
        if status != FOUND:
            return status, t
        contacts = _row(out.contacts, t)
        write_contacts(here, directions, state.q, state.place, contacts)
        if len(table) > 0:
            add_ring_friction(here, directions, rows, load)
            for k in range(balls):
                contacts.friction[k, 0], contacts.friction[k, 1] = rows[k, SIZE], rows[k, SIZE + 1]
            put_settled(contacts, rows)
        ratio = 0.5 * (1.0 - gamma)
        if course.speed[t] != 0.0:
            ratio = shared(contacts, contacts.orbit) / course.speed[t]
        state.cage[1] = ratio
        out.azimuth[t], out.orbit[t] = state.cage[0], ratio * course.speed[t]
        out.q[t], out.load[t], out.place[t] = state.q, load, state.place[:, :2]
        for k in range(balls):
            spin = (contacts.pitch[k], 0.0, -contacts.roll[k])
            own = (state.attitude[k, 0], state.attitude[k, 1], state.attitude[k, 2], state.attitude[k, 3])
            own = turned(own, spin, spin, spin, course.step[t])
            angle = 0.5 * (state.cage[0] + 2.0 * math.pi * k / balls)
            fixed = quaternion_product((0.0, 0.0, math.sin(angle), math.cos(angle)), own)
            for i in range(4):
                state.attitude[k, i] = own[i]
                out.attitude[t, k, i] = fixed[i]
    return FOUND, len(course.turn)
