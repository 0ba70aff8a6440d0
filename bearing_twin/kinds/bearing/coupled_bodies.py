"""Ring, cage and shaft, which all balls of a bearing meet: their numbers, which the compiled core takes."""

import math
from typing import NamedTuple

import numpy as np

NO_LAND = math.inf  # the clearance of a cage that balls alone guide


class Pockets(NamedTuple):
    """Pockets on a circle of `radius` [m]: half their clearance [m], stiffness [N/m], relaxation time [s], friction."""

    radius: float
    half_clearance: float
    stiffness: float
    relaxation_time: float
    friction: float


class MovingPockets(NamedTuple):
    """Walls of a cage whose centre moves; their radius has no part in it."""

    walls: Pockets


class Land(NamedTuple):
    """The land of the outer ring (`side` 1) or the inner (-1): radius and radial clearance [m], stiffness [N/m], ...

    Relaxation time [s], friction, and the slip [m/s] below which friction is smoothed.
    """

    side: float
    radius: float
    clearance: float
    stiffness: float
    relaxation_time: float
    friction: float
    smoothing: float


class Shaft(NamedTuple):
    """Moment of inertia [kg m^2] of all that turns with the inner ring, and viscous damping [N m s] of its speed."""

    inertia: float
    damping: float


class Partners(NamedTuple):
    """What meets all balls in a part of a chunk: numbers (PLACES,) of ring and cage, in SI.

    `ring` is empty where the ring is held, has one number where the ring does not tilt and the cage's centre stays,
    else two. `land` is empty where the cage stays centred, else what guides it (a `Land`). `shaft` is empty where the
    ring's speed is prescribed, else what a torque turns (a `Shaft`). `free` is 1 where a place follows its loads, else
    0. `load` grows by `load_rate` a second, in the cage's place the torque on the shaft; `unbalance` [kg m] turns with
    the ring, `phase` [rad] ahead. `scales` (2 PLACES + 1,) are the errors a step may make, the last of the shaft's
    speed; `light` [m] is as `error_scales.light_approach` says.
    """

    ring: tuple
    active: bool
    even: bool
    varying: bool
    land: tuple
    shaft: tuple
    free: np.ndarray
    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    rest: np.ndarray
    weight: np.ndarray
    load: np.ndarray
    load_rate: np.ndarray
    polar_inertia: float
    unbalance: float
    phase: float
    scales: np.ndarray
    light: float


def unbalance_pulls(unbalance, phase, drive, time):
    """Force (2,) [N] of an unbalance along x and y at `time` [s] into the part."""
    if unbalance == 0.0:
        return 0.0, 0.0
    angle = drive.angle + time * (drive.speed + 0.5 * drive.acceleration * time) + phase
    speed = drive.speed + drive.acceleration * time
    force = unbalance * speed * speed
    return force * math.cos(angle), force * math.sin(angle)


def outside_load(partners, drive, time, i):
    """What acts on the ring from outside along coordinate i at `time` [s] into the part, weight left out [N, N m].

    It is 0 where coordinate i is held.
    """
    if partners.free[i] == 0.0:
        return 0.0
    load = partners.load[i] + time * partners.load_rate[i]
    return load + unbalance_pulls(partners.unbalance, partners.phase, drive, time)[i] if i < 2 else load
