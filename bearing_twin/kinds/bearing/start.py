"""The states from which balls, ring and cage start: between the raceways, or in equilibrium with the loads."""

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.kinds.bearing.compiled import place_balls
from bearing_twin.kinds.bearing.equilibrium import (
    EquilibriumSolver,
    Support,
    azimuths_of,
    setting_of,
    shared,
    weighed_solver,
    weighed_support,
)
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.system import (
    AXIS_DISTANCE,
    BORDER,
    CAGE,
    CAGE_SPEED,
    CAGE_X,
    COLUMNS,
    HEIGHT,
    NO_LAND,
    ORBIT_ANGLE,
    SHAFT_SPEED,
    SPIN,
    TANGENTIAL_VELOCITY,
    Bearing,
    CoupledBodies,
    Loading,
)


def start_state(bearing: Bearing, inner_speed: float, motion: str) -> np.ndarray:
    """State (N, COLUMNS) at the start: balls evenly spaced, resting between the raceways, rolling or not moving.

    Raises SceneError when a ball has no rest between the raceways.
    """
    state = np.zeros((bearing.balls, COLUMNS))
    if not place_balls(bearing, float(inner_speed), motion == "rolling", state):
        raise SceneError(
            "the balls find no rest between the raceways; check radial_clearance, drive.offset and the speed"
        )
    return state


def start_orientation(state: np.ndarray) -> np.ndarray:
    """Orientations (N, 4), x, y, z, w, of balls in a state (N, COLUMNS): turned back about z by their orbit angle."""
    half, nothing = -0.5 * state[:, ORBIT_ANGLE], np.zeros(len(state))
    return np.stack((nothing, nothing, np.sin(half), np.cos(half)), axis=1)


def _settled(solver: EquilibriumSolver, support: Support, bodies: CoupledBodies):
    """The equilibrium with the springs of the support, whose force is found by Newton's method."""
    found = solver.solve(support)
    stiffness, free = bodies.stiffness[:CAGE], np.array(support.free, np.bool_)
    if not np.any(stiffness * free):
        return found
    loads, pull = np.array(support.loads), np.zeros(5)
    for _ in range(30):
        off = stiffness * (found.coordinates - bodies.rest[:CAGE]) - pull
        if np.abs(off[free]).max() <= 1e-9 * np.abs(loads).max():
            return found
        answer = np.linalg.solve(found.stiffness[np.ix_(free, free)], np.eye(int(free.sum())))
        matrix = np.eye(len(answer)) + stiffness[free, None] * answer
        pull[free] += np.linalg.solve(matrix, off[free])
        found = solver.solve(support._replace(loads=tuple(loads - pull)))
    return found


def settled_start(parameters: BearingScene, law: str, bodies: CoupledBodies) -> tuple[np.ndarray, np.ndarray]:
    """State of the balls (N, COLUMNS) and of ring and cage (BORDER,) in balance, the balls rolling unless at rest.

    Balls of a cage share one orbit speed, the mean of what the loaded ones roll with. Raises SceneError where there is
    no equilibrium.
    """
    balls, speed = parameters.geometry.balls, parameters.drive.speed
    setting, azimuths = setting_of(parameters, law, speed), azimuths_of(balls, 0.0)
    support = weighed_support(parameters, Loading(parameters.rings.inner).at(0.0)[0])
    found = _settled(weighed_solver(parameters, setting, azimuths), support, bodies)
    state, border = np.zeros((balls, COLUMNS)), np.zeros(BORDER)
    border[:CAGE] = found.coordinates
    border[SHAFT_SPEED] = speed if bodies.shaft else 0.0
    if bodies.land:
        border[CAGE_X:CAGE] = _resting(parameters, bodies, border)
    state[:, AXIS_DISTANCE] = setting.outer.locus_radius + found.places[:, 0]
    state[:, ORBIT_ANGLE], state[:, HEIGHT] = azimuths, found.places[:, 1]
    if parameters.initial.motion == "rolling":
        contacts = found.contacts
        together = shared(contacts, contacts.orbit)
        orbit = np.full(balls, together) if bodies.free[CAGE] else contacts.orbit
        state[:, TANGENTIAL_VELOCITY] = state[:, AXIS_DISTANCE] * orbit
        state[:, SPIN], state[:, SPIN + 2] = contacts.pitch, orbit - contacts.roll
        border[CAGE_SPEED] = together if bodies.free[CAGE] else 0.0
    return state, border


def _resting(parameters: BearingScene, bodies: CoupledBodies, border: np.ndarray) -> np.ndarray:
    """Place of a cage at rest in its land under its weight [m] (2,); the land's centre without weight or land."""
    land, weight = bodies.land, bodies.weight[CAGE_X:CAGE]
    middle = border[:2] if land.side < 0.0 else np.zeros(2)
    size = float(np.hypot(*weight))
    if size == 0.0 or land.clearance == NO_LAND:
        return middle
    return middle + (land.clearance + size / land.stiffness) * weight / size


def caged_start(state: np.ndarray, bodies: CoupledBodies, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """A start of balls round a ring that is held, at `speed` [rad/s], in a cage that goes round with their mean."""
    border = np.zeros(BORDER)
    border[SHAFT_SPEED] = speed if bodies.shaft else 0.0
    if bodies.free[CAGE]:
        border[CAGE_SPEED] = np.mean(state[:, TANGENTIAL_VELOCITY] / state[:, AXIS_DISTANCE])
        state[:, TANGENTIAL_VELOCITY] = state[:, AXIS_DISTANCE] * border[CAGE_SPEED]
    return state, border
