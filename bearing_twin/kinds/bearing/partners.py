"""Ring and cage of a scene: what acts on them over time, and the equilibrium from which they and the balls start."""

import numpy as np

from bearing_twin.kinds.bearing.columns import (
    AXIS_DISTANCE,
    BORDER,
    CAGE,
    CAGE_SPEED,
    CAGE_X,
    COLUMNS,
    HEIGHT,
    ORBIT_ANGLE,
    PLACES,
    SHAFT_SPEED,
    SPIN,
    TANGENTIAL_VELOCITY,
)
from bearing_twin.kinds.bearing.coupled_bodies import NO_LAND, Land, Partners, Shaft
from bearing_twin.kinds.bearing.drive import TORQUE, cage_inertia, shaft_inertia
from bearing_twin.kinds.bearing.loading import Loading, between, next_after
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.quasi_static.ball_equilibrium import shared
from bearing_twin.kinds.bearing.quasi_static.equilibrium import (
    EquilibriumSolver,
    Support,
    azimuths_of,
    setting_of,
    weighed_solver,
    weighed_support,
)
from bearing_twin.kinds.bearing.rings import (
    BALLS,
    EVEN,
    FREE_RING,
    INNER_LAND,
    POCKETS,
    dimension_of,
    free_coordinates,
    land_radius,
    moving_centre,
    tilts,
)

RING_SHARE = 0.3  # of a ball's errors: a ring that rings bears no more (`tests/test_error_scales.py`)


class RingLoading(Loading):
    """What acts on the inner ring from outside: loads, and the torque on the shaft, the scene's or commanded ones."""

    def __init__(self, parameters: BearingScene):
        super().__init__(parameters.rings.inner)
        drive = parameters.drive
        self.torque, self.torque_knots = drive.torque, np.array(drive.torque_table).reshape(-1, 2)
        self.torque_commanded = False
        self._steady = None

    def set(self, force, moment) -> None:
        """From now on force [N] (3,) and moment [N m] (2 or 3,) act in place of the scene's."""
        super().set(force, moment)
        self._steady = None

    def loaded(self, parameters: BearingScene, force, moment) -> "RingLoading":
        """The same with other loads, or the scene's own where both are None; a commanded torque stays."""
        found = RingLoading(parameters)
        if force is not None:
            found.set(force, moment)
        if self.torque_commanded:
            found.set_torque(self.torque)
        return found

    def set_torque(self, torque: float) -> None:
        """From now on `torque` [N m] turns the shaft in place of the scene's."""
        self.torque, self.torque_knots, self.torque_commanded = float(torque), np.empty((0, 2)), True
        self._steady = None

    def until_next(self, elapsed: float) -> float:
        """Seconds until the load or the torque jumps, or grows otherwise."""
        return min(super().until_next(elapsed), next_after(self.torque_knots[:, 0], elapsed) - elapsed)

    def with_torque(self, elapsed: float) -> tuple[np.ndarray, np.ndarray]:
        """Loads [N], [N m], with the torque on a shaft (6,), at `elapsed` [s], and their rates, until the next jump.

        The same arrays each time where they never jump.
        """
        if self._steady is not None:
            return self._steady
        more, torque_rate = between(self.torque_knots, elapsed)
        torque = self.torque if more is None else self.torque + float(more[0])
        load, rate = self.at(elapsed)
        found = np.append(load, torque), np.append(rate, torque_rate)
        if not len(self.times) and not len(self.torque_knots):
            self._steady = found
        return found


def border_scales(parameters: BearingScene, scales: np.ndarray) -> np.ndarray:
    """Errors (2 PLACES + 1,) that a step of ring, cage and shaft may make, from those of a ball (MOTION,)."""
    pitch = 0.5 * parameters.geometry.pitch_diameter
    # Little stops a shaft that rings, so that errors of its motion add up for longer than those of balls and cage.
    place, speed = RING_SHARE * scales[AXIS_DISTANCE], RING_SHARE * scales[TANGENTIAL_VELOCITY]
    about = 1.0 if moving_centre(parameters) else pitch
    found = np.array(
        [
            *(place,) * 3,
            *(place / about,) * 2,
            place / pitch,
            *(speed,) * 3,
            *(speed / about,) * 2,
            *(speed / pitch,) * 2,
        ]
    )
    if parameters.cage.kind == POCKETS:
        found[[CAGE, CAGE_SPEED]] /= RING_SHARE
    return found


def land_of(parameters: BearingScene) -> Land | tuple:
    """What guides the cage, empty where it stays centred."""
    cage = parameters.cage
    if not moving_centre(parameters):
        return ()
    side, radius = -1.0 if cage.guidance == INNER_LAND else 1.0, land_radius(parameters)
    clearance = NO_LAND if cage.guidance == BALLS else cage.land_clearance
    law = cage.stiffness, cage.relaxation_time, cage.friction, parameters.contact.friction_regularisation
    return Land(side, radius, clearance, *law)


def partners_of(parameters: BearingScene) -> Partners:
    """Ring and cage without loads, and without scales: those are `border_scales`."""
    ring, cage, support = parameters.rings.inner, parameters.cage, parameters.rings.inner.support
    moving, caged = dimension_of(parameters) == FREE_RING, cage.kind != "none"
    free = np.array([*(free_coordinates(parameters) if moving else (False,) * 5), caged], float)
    centred = not moving_centre(parameters)
    if not centred:
        free[CAGE_X:CAGE] = 1.0
    about = (ring.inertia[0] or 1.0) if centred else cage.mass
    weight = np.asarray(parameters.gravity, float)
    turned = parameters.drive.kind == TORQUE
    inertia = cage_inertia(parameters) if caged else 1.0
    return Partners(
        ring=(1.0,) * ((1 if centred and not tilts(parameters) else 2) if moving else 0),
        active=moving or caged or turned,
        even=cage.kind == EVEN,
        varying=moving and ring.unbalance != 0.0,
        land=land_of(parameters),
        shaft=Shaft(shaft_inertia(parameters), float(parameters.drive.damping)) if turned else (),
        free=free,
        mass=np.array([*(ring.mass or 1.0,) * 3, about, about, inertia]),
        stiffness=np.array([*support.stiffness, *(support.tilt_stiffness * centred,) * 2, 0.0]),
        damping=np.array([*support.damping, *(support.tilt_damping * centred,) * 2, 0.0]),
        rest=np.array([*parameters.drive.offset, *parameters.drive.tilt, 0.0]),
        weight=np.array([*(ring.mass * weight), *(cage.mass * weight[:2] * (not centred)), 0.0]),
        load=np.zeros(PLACES),
        load_rate=np.zeros(PLACES),
        polar_inertia=ring.inertia[1] * centred,
        unbalance=ring.unbalance if moving else 0.0,
        phase=0.0,
        scales=np.zeros(2 * PLACES + 1),
        light=0.0,
    )


def _settled(solver: EquilibriumSolver, support: Support, partners: Partners):
    """The equilibrium with the springs of the support, whose force is found by Newton's method."""
    found = solver.solve(support)
    stiffness, free = partners.stiffness[:CAGE], np.array(support.free, np.bool_)
    if not np.any(stiffness * free):
        return found
    loads, pull = np.array(support.loads), np.zeros(5)
    for _ in range(30):
        off = stiffness * (found.coordinates - partners.rest[:CAGE]) - pull
        if np.abs(off[free]).max() <= 1e-9 * np.abs(loads).max():
            return found
        answer = np.linalg.solve(found.stiffness[np.ix_(free, free)], np.eye(int(free.sum())))
        matrix = np.eye(len(answer)) + stiffness[free, None] * answer
        pull[free] += np.linalg.solve(matrix, off[free])
        found = solver.solve(support._replace(loads=tuple(loads - pull)))
    return found


def settled_start(parameters: BearingScene, law: str, partners: Partners) -> tuple[np.ndarray, np.ndarray]:
    """State of the balls (N, COLUMNS) and of ring and cage (BORDER,) in balance, the balls rolling unless at rest.

    Balls of a cage share one orbit speed, the mean of what the loaded ones roll with. Raises SceneError where there is
    no equilibrium.
    """
    balls, speed = parameters.geometry.balls, parameters.drive.speed
    setting, azimuths = setting_of(parameters, law, speed), azimuths_of(balls, 0.0)
    support = weighed_support(parameters, Loading(parameters.rings.inner).at(0.0)[0])
    found = _settled(weighed_solver(parameters, setting, azimuths), support, partners)
    state, border = np.zeros((balls, COLUMNS)), np.zeros(BORDER)
    border[:CAGE] = found.coordinates
    border[SHAFT_SPEED] = speed if partners.shaft else 0.0
    if partners.land:
        border[CAGE_X:CAGE] = _resting(parameters, partners, border)
    state[:, AXIS_DISTANCE] = setting.outer.locus_radius + found.places[:, 0]
    state[:, ORBIT_ANGLE], state[:, HEIGHT] = azimuths, found.places[:, 1]
    if parameters.initial.motion == "rolling":
        contacts = found.contacts
        together = shared(contacts, contacts.orbit)
        orbit = np.full(balls, together) if partners.free[CAGE] else contacts.orbit
        state[:, TANGENTIAL_VELOCITY] = state[:, AXIS_DISTANCE] * orbit
        state[:, SPIN], state[:, SPIN + 2] = contacts.pitch, orbit - contacts.roll
        border[CAGE_SPEED] = together if partners.free[CAGE] else 0.0
    return state, border


def _resting(parameters: BearingScene, partners: Partners, border: np.ndarray) -> np.ndarray:
    """Where a cage rests in its land under its weight [m] (2,); the land's centre without weight, or without a land."""
    land, weight = partners.land, partners.weight[CAGE_X:CAGE]
    middle = border[:2] if land.side < 0.0 else np.zeros(2)
    size = float(np.hypot(*weight))
    if size == 0.0 or land.clearance == NO_LAND:
        return middle
    return middle + (land.clearance + size / land.stiffness) * weight / size


def caged_start(state: np.ndarray, partners: Partners, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """A start of balls round a ring that is held, at `speed` [rad/s], in a cage that goes round with their mean."""
    border = np.zeros(BORDER)
    border[SHAFT_SPEED] = speed if partners.shaft else 0.0
    if partners.free[CAGE]:
        border[CAGE_SPEED] = np.mean(state[:, TANGENTIAL_VELOCITY] / state[:, AXIS_DISTANCE])
        state[:, TANGENTIAL_VELOCITY] = state[:, AXIS_DISTANCE] * border[CAGE_SPEED]
    return state, border
