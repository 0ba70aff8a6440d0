"""Ring, cage and balls as one system, for tests: its rates as functions of the motion, and its Jacobian."""

import numpy as np
from bearings import FREE, motion

from bearing_twin.core import FLAG, INTEGER, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.bearing.system import (
    AXIS_DISTANCE,
    BODY_COLUMNS,
    CAGE_X,
    COLUMNS,
    COORDINATES,
    HOUSING_POSITION,
    HOUSING_SPEED,
    MOTION,
    POSITIONS,
    RADIAL_VELOCITY,
    SHAFT_ANGLE,
    SHAFT_SPEED,
    TANGENTIAL_VELOCITY,
    RingDrive,
    numbers_of,
    numbers_of_bodies,
)

BODY_NUMBERS = 2 * COORDINATES + 4  # with their integrals
_linear_answers = Function(
    "core_linear_solutions",
    None,
    (*(REALS,) * 6, INTEGER, FLAG, REALS_OUT, REALS, REAL, INTEGER, REALS, REALS_OUT, REALS_OUT),
)


def linear_answers(bearing, drive, bodies, near, state, body_state, right):
    """Rates of balls in a state (N, COLUMNS) with ring, cage and shaft (BODY_COLUMNS,), and solutions x (sides, rates).

    Rates are those of N COLUMNS numbers of balls, orbit rates in place of velocities along the orbit, and BODY_NUMBERS
    of the bodies; x/GAIN - J x = right is what a step solves.
    """
    rates, answers = np.empty(state.size + BODY_NUMBERS), np.empty_like(right)
    _linear_answers(
        *(*numbers_of(bearing), numbers_of_bodies(bearing, bodies), bodies.load, bodies.load_rate),
        *(np.array(drive, float), len(state), near.view(np.uint8), state.copy(), body_state, GAIN),
        *(len(right), right, rates, answers),
    )
    return rates, answers


def system_rates(*system):
    """Rates of balls and bodies, as `linear_answers`."""
    return linear_answers(*system, np.empty((0, 0)))[0]


def system_jacobian(*system):
    """The Jacobian (rates, N 9 + 2 COORDINATES) that steps work with, by their solutions of unit right-hand sides.

    By the balls' motion and by places and velocities of the bodies; what has no motion of its own has zeros.
    """
    balls = len(system[4])
    sizes = np.array([*(*OF_BALL, *(1e-6,) * 3) * balls, *OF_BODIES, *(1e-6,) * 4])
    solutions = linear_answers(*system, np.diag(sizes))[1].T / sizes[:, None]
    moves = np.flatnonzero(np.abs(solutions).max(axis=0))
    moving = np.ix_(moves, moves)
    jacobian = np.zeros_like(solutions)
    jacobian[moving] = np.eye(len(moves)) / GAIN - np.linalg.inv(solutions[moving])
    jacobian[np.abs(jacobian) < 1e-9 * np.abs(jacobian).max(axis=1, keepdims=True)] = 0.0  # rounding
    jacobian *= sizes[:, None] / sizes
    of_balls = (np.arange(balls)[:, None] * COLUMNS + np.arange(MOTION)).ravel()
    return jacobian[:, np.append(of_balls, balls * COLUMNS + np.arange(2 * COORDINATES))]


GAIN = 1e-6  # s
# Changes that are small beside what contacts and friction follow from: of a ball's motion, and of the bodies'.
OF_BALL = (1e-10, 1e-9, 1e-10, 1e-5, 1e-3, 1e-5, 3e-3, 3e-3, 3e-3)
OF_BODIES = (
    *(*(1e-10,) * 3, *(1e-9,) * 2, *(1e-10,) * 2, 1e-9, 1e-10, 1e-7),
    *(*(1e-6,) * 3, *(1e-4,) * 2, *(1e-6,) * 2, 1e-4, 1e-6, 1e-3),
)
SHAFT = (*FREE, "rings.inner.inertia=[1.0e-4,1.0e-4]")
BALL = np.array([1e-6, 1e-4, 1e-6, *(1e-2,) * 3, *(3.0,) * 3])
RING = np.array([*(1e-6,) * 3, *(1e-4,) * 3, *(1e-2,) * 3, *(1.0,) * 3])
POCKETS = ("cage.kind=pockets", "cage.pocket_clearance=1.0e-6")


def indices_in_state(guided):
    """Where the bodies' places and velocities (2 COORDINATES,) stand in a body_state, -1 where they do not."""
    positions = [0, 1, 2, *((-1, -1, CAGE_X, CAGE_X + 1) if guided else (3, 4, -1, -1)), 5]
    speeds = (-1 if index < 0 else POSITIONS + index for index in positions)
    return [*positions, HOUSING_POSITION, SHAFT_ANGLE, *speeds, HOUSING_SPEED, SHAFT_SPEED]


class System:
    """Rates of balls and their body_state as functions of their motion, and the Jacobian, by the compiled core."""

    def __init__(self, moving, state, body_state):
        self.bearing, self.bodies = moving.bearing, moving._bodies()
        self.drive = RingDrive(0.3, 150.0, 0.0)
        self.state, self.body_state, self.near = state, body_state, np.zeros(len(state), bool)

    def system(self, state, body_state):
        """The arguments of `linear_answers`."""
        bodies = self.bodies._replace(mass=self.bodies.mass.copy())  # another one: the core keeps what it knows
        return self.bearing, self.drive, bodies, self.near, state, body_state

    def rates(self, state, body_state):
        """Rates of balls (N, COLUMNS) and of the body_state (BODY_COLUMNS,)."""
        rates = system_rates(*self.system(state, body_state))
        balls, body_rates = rates[: state.size].reshape(-1, COLUMNS).copy(), np.zeros(BODY_COLUMNS)
        orbit = state[:, TANGENTIAL_VELOCITY] / state[:, AXIS_DISTANCE]
        balls[:, TANGENTIAL_VELOCITY] *= state[:, AXIS_DISTANCE]  # from that of the orbit rate
        balls[:, TANGENTIAL_VELOCITY] += state[:, RADIAL_VELOCITY] * orbit
        for number, index in enumerate(indices_in_state(bool(self.bodies.land))):
            if index >= 0:
                body_rates[index] = rates[state.size + number]
        return balls, body_rates

    def jacobian(self):
        """The Jacobian of all motions in one matrix, balls first (9 each), then the bodies' places and velocities."""
        jacobian = system_jacobian(*self.system(self.state, self.body_state))
        balls = len(self.state)
        body_rates = (np.arange(balls)[:, None] * COLUMNS + np.arange(MOTION)).ravel()
        return jacobian[np.append(body_rates, balls * COLUMNS + np.arange(2 * COORDINATES))]


def disturbed():
    """A system in which every ball slides, spins and is pressed differently, in and out of pockets, the ring tilted."""
    moving, rng = (
        motion(*SHAFT, *POCKETS, "gravity=[3.0,-9.8,1.0]", "contact.damping=0.3"),
        np.random.default_rng(3),
    )
    state, body_state = moving.state.copy(), moving.body_state.copy()
    state[:, :MOTION] += BALL * rng.uniform(-1.0, 1.0, (len(state), MOTION))
    system = System(moving, state, body_state)
    body_state[: 2 * POSITIONS] += (
        np.where(np.tile(moving.bodies.free, 2) > 0, 1.0, 0.0) * RING * rng.uniform(-1, 1, 12)
    )
    return system
