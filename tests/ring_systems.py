"""Ring, cage and balls as one system, for tests: its rates as functions of the motion, and its Jacobian."""

import numpy as np
from bearings import motion

from bearing_twin.kinds.bearing.forces import border_rows as at
from bearing_twin.kinds.bearing.forces.equations import RingDrive
from bearing_twin.kinds.bearing.forces.jacobian import rates_and_ring_jacobian
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    BALL_BY_BORDER,
    BORDER,
    BORDER_BY_BALL,
    BORDER_MOTION,
    CAGE_X,
    CAGE_Y,
    CENTRE,
    COUPLED_ROWS,
    DRIVE_WORK,
    JACOBIAN,
    LINEARISED,
    MOTION,
    PLACES,
    POWER_SIGN,
    RING_SPEED,
    VELOCITY,
)
from bearing_twin.kinds.bearing.forces.pairs import add_pairs
from bearing_twin.kinds.bearing.forces.rates import lane_rates
from bearing_twin.kinds.bearing.stepping.border import border_rates, follow_cage, put_pockets
from bearing_twin.kinds.bearing.stepping.linear_system import couple_jacobians, new_coupling
from bearing_twin.kinds.bearing.stepping.shaft import turning
from bearing_twin.numerics.lanes import COLUMNS, LANE_RATES, LANES, from_blocks, into_blocks, new_blocks, put

AXIAL_PRELOAD = 14.2229392  # N that press the inner ring 10 um along the axis
FREE = ("model.dimension=free", "rings.inner.mass=0.5", "rings.inner.free=all", "rings.inner.load=[0,0,17.07]")
SHAFT = (*FREE, "rings.inner.inertia=[1.0e-4,1.0e-4]")
SUPPORT = "rings.inner.support={stiffness: [1e5,2e5,3e5], damping: [1,2,3], tilt_stiffness: 4, tilt_damping: 0.1}"
BALL = np.array([1e-6, 1e-4, 1e-6, *(1e-2,) * 3, *(3.0,) * 3])
RING = np.array([*(1e-6,) * 3, *(1e-4,) * 3, *(1e-2,) * 3, *(1.0,) * 3])
CENTRE_SCALE = 1e-6, 1e-2  # of place [m] and velocity [m/s] of a cage's centre
POCKETS = ("cage.kind=pockets", "cage.pocket_clearance=1.0e-6")
LEVEL = (*FREE[:2], "rings.inner.free=displacement", FREE[3])  # a ring that does not tilt
MOVING = (*LEVEL, *POCKETS, "cage.land_clearance=2.0e-7")
CASES = {
    "ring": (*SHAFT, SUPPORT),
    "ring and pockets": (*SHAFT, *POCKETS),
    "ring without tilt": (*LEVEL, SUPPORT),
    "ring without tilt and pockets": (*LEVEL, *POCKETS),
    "ring without tilt and even cage of 9 balls": (*LEVEL, "cage.kind=even", "geometry.balls=9"),
    "ring without tilt of balls that may touch": LEVEL,
    "ring and cage guided by its land": (*MOVING, SUPPORT, "cage.guidance=inner"),
    "ring and cage guided by the outer land": (*MOVING, "cage.guidance=outer", "geometry.balls=9"),
    "ring of balls that may touch, cage guided by its land": (*MOVING, "cage.guidance=outer"),
    "ring and cage guided by balls": (*MOVING, "cage.guidance=balls"),
    "ring and even cage": (*SHAFT, "cage.kind=even"),
    "even cage": ("cage.kind=even",),
    "ring and even cage of 9 balls": (*SHAFT, "cage.kind=even", "geometry.balls=9"),
    "ring of balls that may touch": SHAFT,
    "tilted ring and even cage": ("model.dimension=prescribed", "drive.tilt=[1e-3,-5e-4]", "cage.kind=even"),
}


class System:
    """Rates of balls and their border as functions of their motion, and the Jacobian as the kernels fill it."""

    def __init__(self, moving, state, border, near=False):
        self.bearing, self.partners = moving.bearing, moving._partners()
        self.drive, self.balls = RingDrive(0.3, 150.0, 0.0), np.arange(len(state))
        self.state, self.border, self.near = state, border, np.full(len(state), near)
        self.ring = RING.copy()
        if self.partners.land:
            self.ring[[CAGE_X, CAGE_Y]], self.ring[[PLACES + CAGE_X, PLACES + CAGE_Y]] = CENTRE_SCALE

    def evaluated(self, state, border, linear=False):
        coupling = new_coupling(self.near, self.balls, self.partners, border)
        blocks, drive = new_blocks(len(state), COUPLED_ROWS), turning(coupling.border, self.drive, 0.0, at.NOW)
        into_blocks(state, blocks, AXIS_DISTANCE)
        put_pockets(self.bearing, self.balls, blocks)
        follow_cage(coupling.border, at.NOW, blocks, AXIS_DISTANCE)
        for lanes in blocks:
            moving = coupling.border.numbers[at.NOW : at.NOW + 2 * PLACES].copy()
            if self.partners.land:
                centre = [CAGE_X, CAGE_Y, PLACES + CAGE_X, PLACES + CAGE_Y]
                lanes[CENTRE * LANES : (CENTRE + 4) * LANES] = np.repeat(moving[centre], LANES)
                moving[centre] = 0.0
            lanes[BORDER_MOTION * LANES : (BORDER_MOTION + 2 * PLACES) * LANES] = np.repeat(moving, LANES)
            for k in range(LANES):
                put(lanes, RING_SPEED, k, drive.speed)
            if linear:
                rates_and_ring_jacobian(self.bearing.ring, coupling.border, self.bearing, lanes)
            else:
                lane_rates(self.bearing, lanes)
        if self.near.any():
            add_pairs(self.bearing, coupling.pairs, blocks, blocks, LANE_RATES)
        border_rates(self.bearing, drive, coupling.border, 0.0, blocks)
        return coupling, blocks

    def rates(self, state, border):
        coupling, blocks = self.evaluated(state, border)
        found = np.zeros((len(state), COLUMNS))
        from_blocks(blocks, LANE_RATES, found)
        return found, coupling.border.numbers[at.RATES : at.RATES + BORDER].copy()

    def linear(self):
        return self.evaluated(self.state, self.border, linear=True)

    def jacobian(self):
        """By balls: (balls, COLUMNS, MOTION); balls by border; accelerations of the border by balls and by itself."""
        coupling, blocks = self.linear()
        bearing = self.bearing
        couple_jacobians(bearing.pockets, bearing, self.drive, 0.0, coupling, blocks)

        def read(arrays, row, *shape):
            rows = int(np.prod(shape))
            parts = [array[row * LANES : (row + rows) * LANES].reshape(*shape, LANES) for array in arrays]
            return np.moveaxis(np.concatenate(parts, axis=-1), -1, 0)[: len(self.state)]

        by_ball, by_border = (
            read(blocks, JACOBIAN, LINEARISED, MOTION),
            read(blocks, BALL_BY_BORDER, LINEARISED - VELOCITY, 2 * PLACES),
        )
        sign = read(blocks, POWER_SIGN, 1, 1)
        return (
            with_gross_work(by_ball, sign, DRIVE_WORK),
            with_gross_work(by_border, sign, DRIVE_WORK - VELOCITY),
            read(blocks, BORDER_BY_BALL, PLACES, MOTION),
            coupling.border.numbers[at.OWN : at.CORNER].reshape(PLACES, 2 * PLACES),
        )


def with_gross_work(rows, sign, drive):
    """Rows (..., rates, columns) of a Jacobian with that of GROSS_WORK: row number `drive` times the power's sign."""
    return np.concatenate([rows, sign * rows[..., drive : drive + 1, :]], axis=-2)


def disturbed(name, seed=3, more=()):
    """A system in which every ball slides, spins and is pressed differently, in and out of pockets, the ring tilted."""
    moving, rng = (
        motion(*CASES[name], *more, "gravity=[3.0,-9.8,1.0]", "contact.damping=0.3"),
        np.random.default_rng(seed),
    )
    state, border = moving.state.copy(), moving.border.copy()
    state[:, :MOTION] += BALL * rng.uniform(-1.0, 1.0, (len(state), MOTION))
    system = System(moving, state, border, near="may touch" in name)
    border[: 2 * PLACES] += (
        np.where(np.tile(moving.partners.free, 2) > 0, 1.0, 0.0) * system.ring * rng.uniform(-1, 1, 12)
    )
    if moving.partners.even:
        _, blocks = system.evaluated(state, border)
        from_blocks(blocks, AXIS_DISTANCE, state)
    return system
