"""A shaft that a torque turns, in the linear system of a step: its answers against differences, and the whole solve."""

import numpy as np
import pytest
from ring_systems import BALL, CASES, SHAFT, disturbed

from bearing_twin.kinds.bearing.forces import border_rows as at
from bearing_twin.kinds.bearing.forces.layout import (
    BORDER,
    LOST,
    MOTION,
    ORBIT_ANGLE,
    PLACES,
    SHAFT_ANGLE,
    SHAFT_SPEED,
    SHAFT_WORK,
    TANGENTIAL_VELOCITY,
    WORK_DONE,
)
from bearing_twin.kinds.bearing.stepping.linear_system import couple_jacobians, factorise_together
from bearing_twin.kinds.bearing.stepping.shaft import factorise_shaft, shaft_answers, solve_with_shaft
from bearing_twin.numerics.lanes import COLUMNS, GAIN, LANES, RIGHT, SOLUTION, START, from_blocks, into_blocks

TORQUE = ("drive.kind=torque", "drive.torque=0.02", "drive.inertia=1.0e-6", "drive.damping=1.0e-4")
SPOT = ("contact.friction=spot", "contact.friction_regularisation=1.0e-3")
MORE = {
    "held": (),
    "held, 9 balls": ("geometry.balls=9",),
    "held, balls that may touch": (),
    "held and tilted": ("model.dimension=prescribed", "drive.tilt=[1e-3,-5e-4]"),
    "held, friction over the spots": SPOT,
    "held, spots and even cage": (*SPOT, "cage.kind=even"),
    "held and pockets": ("cage.kind=pockets", "cage.pocket_clearance=1.0e-6"),
    "ring and unbalance": (*SHAFT, "rings.inner.unbalance=1.0e-2"),
}
CASES |= MORE
G = 2e-6  # s


@pytest.mark.parametrize("name", CASES)
def test_the_system_with_a_shaft_is_solved(name):
    """x / g - J x = right, with J x from central differences of the rates along x; in units of what a ball feels."""
    system, rng = disturbed(name, more=TORQUE), np.random.default_rng(7)
    assert system.partners.shaft
    state, border, even = system.state, system.border, system.partners.even
    border[[SHAFT_ANGLE, SHAFT_SPEED]] = 0.7, 150.0
    count, free = len(state), np.tile(system.partners.free, 2)
    right = rng.uniform(-1.0, 1.0, (count, COLUMNS)) * np.array([*BALL, 1.0, 1.0, 1.0])
    own = np.zeros(at.WIDTH)
    own[: 2 * PLACES] = rng.uniform(-1.0, 1.0, 2 * PLACES) * system.ring * free
    own[[SHAFT_ANGLE, SHAFT_SPEED, SHAFT_WORK, WORK_DONE, LOST]] = 1e-4, 5.0, 0.1, 0.2, 0.3
    if even:
        right[:, [ORBIT_ANGLE, TANGENTIAL_VELOCITY]] = 0.0
    coupling, blocks = system.linear()
    bearing, drive = system.bearing, system.drive._replace(angle=0.7, speed=150.0)
    numbers = coupling.border.numbers
    for lanes in blocks:
        lanes[GAIN * LANES : (GAIN + 1) * LANES] = G
    into_blocks(state, blocks, START)
    numbers[at.SOLUTION : at.SOLUTION + at.WIDTH] = np.nan  # as a step leaves it that is made again
    into_blocks(np.full((count, COLUMNS), np.nan), blocks, SOLUTION)
    couple_jacobians(bearing.pockets, bearing, drive, 0.0, coupling, blocks)
    shaft_answers(coupling.border.shaft, drive, bearing, 0.0, coupling, blocks)
    factorise_together(coupling, blocks)
    factorise_shaft(coupling.border.shaft, drive, 0.0, coupling, blocks)
    numbers[at.RIGHT : at.RIGHT + at.WIDTH] = own
    into_blocks(right, blocks, RIGHT)
    solve_with_shaft(coupling.border.shaft, drive, 0.0, coupling, blocks)
    solved, moved = np.zeros((count, COLUMNS)), numbers[at.SOLUTION : at.SOLUTION + BORDER].copy()
    from_blocks(blocks, SOLUTION, solved)
    assert np.isfinite(moved).all()

    step = 1e-4 / max(
        np.abs(solved[:, :MOTION] / BALL).max(),
        np.abs(moved[: 2 * PLACES] / system.ring).max(),
        abs(moved[SHAFT_SPEED]),
    )
    (balls, ring), (less, lower) = (
        system.rates(state + sign * step * solved, border + sign * step * moved) for sign in (1.0, -1.0)
    )
    kept = [i for i in range(COLUMNS) if not (even and i in (ORBIT_ANGLE, TANGENTIAL_VELOCITY))]
    answer = (balls - less) / (2.0 * step)
    off = np.abs(solved / G - answer - right)[:, kept].max(axis=0)
    size = np.maximum(np.abs(solved / G), np.abs(answer))[:, kept].max(axis=0)
    assert np.all(off <= 1e-5 * size), off / size
    answer = (ring - lower) / (2.0 * step)
    off, size = np.abs(moved / G - answer - own[:BORDER]), np.maximum(np.abs(moved / G), np.abs(answer))
    used = np.flatnonzero(np.r_[free, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0])
    share = off[used] / (np.maximum(size, np.abs(own[:BORDER]))[used] + 1e-300)
    limit = 2e-4 if "guided" in name else 2e-5  # what a cage's centre answers is a small difference
    assert share.max() <= limit, dict(zip(used.tolist(), share.tolist(), strict=True))
