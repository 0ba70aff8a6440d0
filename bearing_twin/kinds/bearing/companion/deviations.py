"""How far a stretch of a bearing run is from what a companion found for it."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from bearing_twin.kinds.bearing.companion.windows import Window
from bearing_twin.kinds.bearing.forces.equations import Bearing, RingDrive
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    DISSIPATED,
    DRIVE_WORK,
    MOTION,
    ORBIT_ANGLE,
    TANGENTIAL_VELOCITY,
)
from bearing_twin.kinds.bearing.stepping.border import Partners

LEAST_LOAD = 0.01  # of the greatest load: a contact that carries less has no friction limit worth a relative error


def drive_later(drive: RingDrive, start: float) -> RingDrive:
    """The drive `start` [s] later, while it accelerates evenly."""
    angle, speed, acceleration = drive
    return RingDrive(angle + start * (speed + 0.5 * acceleration * start), speed + acceleration * start, acceleration)


class Part(NamedTuple):
    """A stretch of a run that was integrated in one go, with what it began from and what it gave out.

    `begun` are the arrays that moved on, as they were: state, orientation, steps, carried, border. `filled` are states,
    orientations and borders at `times` [s] from `elapsed` [s] on, `out` the channels there. `taken` are the steps
    of all balls since the run began.
    """

    bearing: Bearing
    drive: RingDrive
    partners: Partners
    near: np.ndarray
    times: np.ndarray
    duration: float
    begun: list
    filled: tuple
    out: Mapping[str, np.ndarray]
    pointer: np.ndarray
    elapsed: float
    taken: int

    def start(self, output: int) -> float:
        """Time [s] of an output from the beginning of the part, which is output -1."""
        return 0.0 if output < 0 else float(self.times[output])

    def drive_from(self, start: float) -> RingDrive:
        """The drive `start` [s] later."""
        return drive_later(self.drive, start)


class Found(NamedTuple):
    """What a companion found: channels and states (instants, balls, ...), and the steps it took in all.

    `last` are state, orientation, step sizes and what laws carry at the end, one row a ball, then ring and cage.
    """

    out: Mapping[str, np.ndarray]
    states: np.ndarray
    last: tuple[np.ndarray, ...]
    steps: int


def deviations(part: Part, window: Window, found: Found, place: int | None, greatest_load: float) -> list[float]:
    """The greatest errors of the run in a window: what stands behind `tolerance` in a row of WINDOW.

    `place` is that of the ball among those the companion took, None for all balls at once.
    """
    exact = found.out
    rows = slice(window.begin + 1, window.begin + 1 + window.length)
    balls, own = (slice(None), slice(None)) if place is None else (slice(window.ball, window.ball + 1), place)
    own = slice(own, own + 1) if isinstance(own, int) else own

    def off(name: str) -> np.ndarray:
        return part.out[name][rows, balls] - exact[name][:, own]

    bearing, least = part.bearing, LEAST_LOAD * greatest_load
    coefficient = bearing.friction_coefficient
    load = exact["normal_load"][:, own]
    torque = np.linalg.norm(off("raceway_torque"), axis=-1)
    friction = 0.0
    if coefficient > 0.0 and least > 0.0:
        force = np.linalg.norm(off("friction_force"), axis=-1) / np.maximum(load, least)
        turned = torque / bearing.ball_radius / np.maximum(load.sum(axis=-1), least)
        friction = float(max(force.max(), turned.max())) / coefficient
    turns = [
        np.linalg.norm(one, axis=-1)
        for one in (part.out["raceway_torque"][rows, balls], exact["raceway_torque"][:, own])
    ]
    mean = (turns[0] - turns[1]).mean(axis=0)
    mine, theirs = part.filled[0][rows, balls], found.states[:, own]
    orbit = [one[..., TANGENTIAL_VELOCITY] / one[..., AXIS_DISTANCE] for one in (mine, theirs)]
    before = 0.0 if window.begin < 0 else part.times[window.begin]
    seconds = float(part.times[rows][-1] - before)
    integrals = np.abs((mine - theirs)[-1].mean(axis=0))  # what one ball gets too much another may get too little
    speed = abs(part.drive.speed) + abs(part.drive.acceleration) * part.duration
    if part.partners.shaft:
        speed = float(np.abs(part.out["inner_ring_speed"][rows]).max())
    ring = [0.0, 0.0]
    if place is None:
        names = "inner_ring_offset", "inner_ring_force"
        ring = [float(np.abs(part.out[one][rows] - exact[one]).max()) for one in names]
    return [
        float(np.abs(off("normal_load")).max()),
        friction,
        float(torque.max()),
        float((np.abs(off("contact_angle")) * (load > 0.0)).max()),
        float(np.abs((mine - theirs)[-1, :, ORBIT_ANGLE]).max()),
        float(np.abs(orbit[0] - orbit[1]).max()),
        float(np.abs(off("roll_rate")).max()),
        float(integrals[DRIVE_WORK]) / (speed * seconds) if speed > 0.0 else 0.0,
        float(integrals[DISSIPATED]) / seconds,
        *ring,
        float(mean[np.abs(mean).argmax()]),
    ]


def left_over(part: Part, window: Window, found: Found, place: int, allowed: np.ndarray) -> float:
    """The error of the motion at the end of a window, over what is `allowed` (MOTION,); the orbit angle does not count.

    How far a ball has gone round changes its loads little; all else may come back as an error of force.
    """
    those, own = (slice(None), slice(None)) if window.ball < 0 else (window.ball, place)
    mine = part.filled[0][window.begin + window.length, those, :MOTION]
    error = np.abs(mine - found.states[-1, own, :MOTION]) / allowed
    error[..., ORBIT_ANGLE] = 0.0
    return float(error.max())


def off_in_flight(part: Part, window: Window, found: Found, place: int | None) -> float:
    """How far [m] the ball of a window was off along the radius at outputs where it touched neither raceway.

    0 of all balls at once.
    """
    if place is None:
        return 0.0
    rows = slice(window.begin + 1, window.begin + 1 + window.length)
    free = part.out["normal_load"][rows, window.ball].max(axis=-1) == 0.0
    off = part.filled[0][rows, window.ball, AXIS_DISTANCE] - found.states[:, place, AXIS_DISTANCE]
    return float(np.abs(off[free]).max(initial=0.0))
