"""Balls between two rings in equilibrium (Jones 1960; Harris, Rolling Bearing Analysis): the door to the compiled core.

The equations and the coordinates are those of `core/bearing/ball_equilibrium.hpp` and `equilibrium.hpp`, which solve
them; here are their numbers, and what is found of contacts.
"""

from typing import NamedTuple

import numpy as np
from numpy.ctypeslib import ndpointer

from bearing_twin.base.stopping import SIGNALLED
from bearing_twin.core import INTEGER, INTEGERS, INTEGERS_OUT, REALS, REALS_OUT, Function
from bearing_twin.kinds.bearing.model import Raceway
from bearing_twin.kinds.bearing.parameters import GREATEST_ANGLE, GREATEST_SQUEEZE

IDLE = 1e-3  # of the greatest load: below it the angle of a contact has no limit
FOUND, NOTHING_CARRIES, TOO_MUCH, STOPPED = range(4)  # what the core tells of an equilibrium
COORDINATES = 5  # of a ring: x, y, z, theta_x, theta_y
PLACES = 8  # numbers kept of a ball's equilibrium: place, opening, d(place)/d(opening); NaN to begin from nothing
OF_CONTACTS = 16  # numbers of the `Contacts` of a ball
SPEED = 32  # where the speed stands among a setting's numbers

STOP = ndpointer(np.uint8, shape=(1,))
_GIVEN = INTEGER, INTEGER, INTEGERS, REALS, INTEGER, REALS, INTEGER, REALS, INTEGER, INTEGERS, REALS, REALS, STOP
SMOOTH = np.zeros((0, 2))  # no heights
_equilibria = Function("core_equilibria", None, (*_GIVEN, *(REALS_OUT,) * 6, INTEGERS_OUT))
_ball_contacts = Function("core_ball_contacts", None, (INTEGER, INTEGERS, *(REALS,) * 4, REALS_OUT))
_ball_balances = Function("core_ball_balances", None, (INTEGERS, *(REALS,) * 4, REALS_OUT, REALS_OUT))


class Setting(NamedTuple):
    """The numbers of the balance (SI): grooves, ball, `arm` of a tilt, speed [rad/s], shares of the gyroscopic moment.

    `arm` [m] turns a tilt into axial displacement and an axial force into a moment; `lever` [m] is the arm of the
    friction that carries the gyroscopic moment, about the point at the end of `arm`. A ball's last step may leave
    `unseen` of the loads, for which stiffness is to the root of that; 0 where it is to be exact.
    """

    inner: Raceway
    outer: Raceway
    ball_radius: float
    ball_mass: float
    pitch_diameter: float
    arm: float
    lever: float
    speed: float
    share_inner: float
    share_outer: float
    unseen: float

    def numbers(self, gravity=(0.0, 0.0, 0.0), place=0.0, facing=1.0, middle=0.0) -> np.ndarray:
        """The core's `Seat`: with `gravity` [m/s^2], and `place` [m], side and `middle` [m] of a ring on a shaft."""
        grooves = [(one.locus_radius, one.groove_radius, *one.terms) for one in (self.inner, self.outer)]
        return np.array([*grooves[0], *grooves[1], self.inner.law.power, *self[2:], *gravity, place, facing, middle])


class Contacts(NamedTuple):
    """Arrays (..., N, 2), inner and outer; `friction` [N] is along t.

    A ball's row (..., N): `orbit` [rad/s], `roll` [rad/s] along the axis and `pitch` [rad/s] along the radius, both of
    the ball against its orbit; `centrifugal` [N]. Angles count where there is no load too.
    """

    approach: np.ndarray
    load: np.ndarray
    angle: np.ndarray
    friction: np.ndarray
    curvature_small: np.ndarray
    curvature_large: np.ndarray
    orbit: np.ndarray
    roll: np.ndarray
    pitch: np.ndarray
    centrifugal: np.ndarray


def contacts_in(numbers: np.ndarray) -> Contacts:
    """The contacts that the core wrote into an array (..., N, OF_CONTACTS), as views of it."""
    return Contacts(*(numbers[..., i : i + 2] for i in range(0, 12, 2)), *np.moveaxis(numbers[..., 12:], -1, 0))


class Solved(NamedTuple):
    """Equilibria (C, ...): coordinates, loads, stiffness, balls' `places` (C, N, PLACES), what is `left` [N], status.

    `contacts` (C, N, OF_CONTACTS) are read by `contacts_in`.
    """

    coordinates: np.ndarray
    loads: np.ndarray
    stiffness: np.ndarray
    places: np.ndarray
    contacts: np.ndarray
    left: np.ndarray
    status: np.ndarray


def solved_from_nothing(seats, balls, azimuths, free, wanted, held, heights=SMOOTH) -> Solved:
    """Equilibria with the free coordinates loaded by `wanted` (C, 5) [N, N m], the others `held` (C, 5) [m, rad].

    `seats` ([C,] rings, SEAT) are `Setting.numbers`, `balls` (rings,) how many there are, at `azimuths` ([C,] N) [rad].
    `heights` (N, 2) [m] are those of the inner and the outer raceway under the balls.
    """
    cases, count = len(wanted), azimuths.shape[-1]
    shapes = (5,), (5,), (5, 5), (count, PLACES), (count, OF_CONTACTS), ()
    found = Solved(*(np.empty((cases, *shape)) for shape in shapes), np.empty(cases, np.int64))
    _equilibria(
        *(
            cases,
            len(balls),
            np.array(balls, np.int64),
            seats,
            seats.ndim == 3,
            azimuths,
            azimuths.ndim == 2,
            heights,
            len(heights) > 0,
        ),
        *(np.array(free, np.int64), wanted, held, SIGNALLED, *found),
    )
    return found


def contacts_at(seats, balls, azimuths, coordinates, places) -> Contacts:
    """The contacts of balls at their places (N, 2), on rings or a shaft at `coordinates` (5,)."""
    found = np.empty((len(azimuths), OF_CONTACTS))
    _ball_contacts(len(balls), np.array(balls, np.int64), seats, azimuths, coordinates, _kept(places), found)
    return contacts_in(found)


def ball_balances(seat, azimuths, coordinates, places) -> tuple[np.ndarray, np.ndarray]:
    """What changes of place and opening do to balls at their places (N, 2), and coordinates to their openings.

    Derivatives (N, 5, 2, 2) of what is left of a ball's balance (radial, axial), of its force on the ring (radial,
    axial) and of the moment of its friction, by place and by opening (radial, axial); and (N, 2, 5) of the openings.
    """
    count = len(azimuths)
    by_ball, by_ring = np.empty((count, 5, 2, 2)), np.empty((count, 2, 5))
    _ball_balances(np.array([count]), seat, azimuths, coordinates, _kept(places), by_ball, by_ring)
    return by_ball, by_ring


def _kept(places) -> np.ndarray:
    return np.pad(places, ((0, 0), (0, PLACES - 2)))


def shared(contacts: Contacts, values: np.ndarray) -> float:
    """What balls in one cage share of `values` (N,), such as orbit speeds: the mean by load on the inner ring."""
    load = contacts.load[:, 0]
    weight = load.sum()
    return float(load @ values / weight if weight > 0.0 else values.mean())


def limits_used(ball_radius, load, approach, angle) -> tuple[np.ndarray, np.ndarray]:
    """Squeeze and greatest contact angle of each ball, each over its limit, from arrays (..., N, 2) of both raceways.

    `ball_radius` [m] broadcasts against (..., N).
    The angle of a contact that bears less than IDLE of the greatest load does not count: no edge of a groove feels it.
    """
    squeeze = np.where((load > 0.0).all(-1), approach.sum(-1), 0.0)
    greatest = np.where(load > IDLE * load.max(axis=(-2, -1), keepdims=True), np.abs(angle), 0.0).max(-1)
    return squeeze / (GREATEST_SQUEEZE * 2.0 * ball_radius), greatest / GREATEST_ANGLE
