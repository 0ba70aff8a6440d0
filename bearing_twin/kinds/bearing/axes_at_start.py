"""Balls that start with their axes of spin as friction at a point leaves them, so that a run begins settled."""

import numpy as np

from bearing_twin.errors import SceneError
from bearing_twin.kinds.bearing.controls import SETTLED
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    CAGE,
    CAGE_X,
    HEIGHT,
    ORBIT_ANGLE,
    SPIN,
    VELOCITY,
)
from bearing_twin.kinds.bearing.loading import Loading
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.partners import CAGE_SPEED, Partners
from bearing_twin.kinds.bearing.quasi_static.in_motion import in_motion, turn_of_scene
from bearing_twin.kinds.bearing.quasi_static.marched import March
from bearing_twin.kinds.bearing.quasi_static.settled import settled_turn
from bearing_twin.kinds.bearing.quasi_static.shares import control_of
from bearing_twin.kinds.bearing.quasi_static.statics import setting_of, weighed_solver, weighed_support
from bearing_twin.kinds.bearing.rings import FREE_RING, dimension_of, moving_centre


def settle_axes(parameters: BearingScene, law: str, partners: Partners, state: np.ndarray, border: np.ndarray) -> None:
    """Puts into `state` (N, COLUMNS) and `border` (BORDER,) the motion of balls whose axes have settled, if so asked.

    They roll there already, evenly spaced, which stays where none is found; a ring that is free moves with them.
    """
    speed, drive, free = float(parameters.drive.speed), parameters.drive, dimension_of(parameters) == FREE_RING
    if parameters.initial.motion != "rolling" or not speed or control_of(parameters) != SETTLED:
        return
    if free and np.any(partners.stiffness[:CAGE]):  # springs hold it, which no equilibrium has
        return
    setting, azimuths = setting_of(parameters, law, speed), state[:, ORBIT_ANGLE]
    near = turn_of_scene(parameters, law)
    if near is not None and near.why:
        return
    coordinates = np.array([*drive.offset, *drive.tilt])
    if free:
        support = weighed_support(parameters, Loading(parameters.rings.inner).at(0.0)[0])
        try:
            found, _, near = in_motion(parameters, weighed_solver(parameters, setting, azimuths), support, near)
        except SceneError:
            return
        if near.why:
            return
        coordinates = found.coordinates
    turn = near
    if not isinstance(near, March):
        turn = settled_turn(parameters, setting, coordinates, near, parameters.gravity)
    if turn.why:
        return
    if free:
        moved = CAGE_X if moving_centre(parameters) else CAGE
        border[:moved] = coordinates[:moved]
    motion, orbit = turn.whole(azimuths)
    state[:, AXIS_DISTANCE] = setting.outer.locus_radius + motion[:, 0]
    state[:, HEIGHT] = motion[:, 1]
    state[:, VELOCITY], state[:, VELOCITY + 2] = motion[:, 2:4].T
    state[:, VELOCITY + 1] = state[:, AXIS_DISTANCE] * orbit
    state[:, SPIN : SPIN + 3] = motion[:, 4:]
    if partners.free[CAGE]:
        border[CAGE_SPEED] = orbit.mean()
