"""Ring with mass and cage in the linear system: every entry of the Jacobian against differences, and frequencies."""

import numpy as np
import pytest
from bearings import motion
from ring_systems import AXIAL_PRELOAD, BALL, CASES, FREE, System, disturbed

from bearing_twin.kinds.bearing.forces.equations import RingDrive
from bearing_twin.kinds.bearing.forces.layout import (
    BORDER,
    MOTION,
    ORBIT_ANGLE,
    PLACES,
    TANGENTIAL_VELOCITY,
    VELOCITY,
)
from bearing_twin.numerics.lanes import COLUMNS


@pytest.mark.parametrize("name", CASES)
def test_every_entry_is_the_derivative(name):
    """Against central differences; of an even cage along what it leaves free."""
    system = disturbed(name)
    state, border, even = system.state, system.border, system.partners.even
    by_ball, by_border, reacting, corner = system.jacobian()
    slaves = (ORBIT_ANGLE, TANGENTIAL_VELOCITY)
    kept = [i for i in range(COLUMNS) if not (even and i in slaves)]
    wanted = [i for i in range(VELOCITY, COLUMNS) if not (even and i in slaves)]
    size_of_ball = np.maximum(
        np.abs(by_ball * BALL).max(axis=(0, 2)), np.r_[np.zeros(3), np.abs(by_border * system.ring).max(axis=(0, 2))]
    )
    size_of_border = (
        np.maximum(np.abs(reacting * BALL).max(axis=(0, 2)), np.abs(corner * system.ring).max(axis=1)) + 1e-300
    )
    step = 1e-4

    def slope(ball, column, unit):
        found = []
        for sign in (1.0, -1.0):
            moved, shifted = state.copy(), border.copy()
            if ball is None:
                shifted[column] += sign * step * unit
            else:
                moved[ball, column] += sign * step * unit
            found.append(system.rates(moved, shifted))
        return [(one - other) / (2.0 * step) for one, other in zip(*found, strict=True)]

    for ball in (0, 3, 6):
        for column in range(MOTION):
            if even and column in slaves:
                continue
            balls, own = slope(ball, column, BALL[column])
            off = np.abs(balls[ball] - by_ball[ball, :, column] * BALL[column])
            assert np.all(off[kept] <= 1e-5 * size_of_ball[kept]), (ball, column)
            off = np.abs(own[PLACES : 2 * PLACES] - reacting[ball, :, column] * BALL[column])
            assert np.all(off <= 1e-5 * size_of_border), (ball, column)
    for column in np.flatnonzero(np.tile(system.partners.free, 2)):
        balls, own = slope(None, column, system.ring[column])
        off = np.abs(balls[:, wanted] - by_border[:, np.array(wanted) - VELOCITY, column] * system.ring[column])
        assert np.all(off <= 1e-5 * size_of_ball[wanted]), column
        off = np.abs(own[PLACES : 2 * PLACES] - corner[:, column] * system.ring[column])
        assert np.all(off <= 1e-5 * size_of_border), column


def whole(system):
    """The Jacobian of all motions in one matrix, balls first, then places and velocities of the border."""
    by_ball, by_border, reacting, corner = system.jacobian()
    count = len(system.state)
    size = count * MOTION
    matrix = np.zeros((size + 2 * PLACES, size + 2 * PLACES))
    for k in range(count):
        at = slice(k * MOTION, (k + 1) * MOTION)
        matrix[at, at] = by_ball[k, :MOTION]
        matrix[k * MOTION + VELOCITY : (k + 1) * MOTION, size:] = by_border[k, : MOTION - VELOCITY]
        matrix[size + PLACES :, at] = reacting[k]
    matrix[size : size + PLACES, size + PLACES :] = np.eye(PLACES)
    matrix[size + PLACES :, size:] = corner
    return matrix


@pytest.mark.parametrize(
    ("polar", "speed", "wanted"),
    [
        (0.0, 0.0, (192.83, 192.83, 289.77, 2150.4, 2150.4)),
        (1e-4, 183.26, (178.85, 207.90, 289.77)),
    ],
)
def test_a_shaft_on_a_preloaded_bearing_rings_where_it_should(polar, speed, wanted):
    """Frequencies [Hz] of a shaft of 0.5 kg and 1e-4 kg m^2, balls without friction; 10 um of axial preload."""
    moving = motion(
        *FREE, f"rings.inner.inertia=[1.0e-4,{polar}]", "gravity=[0,0,0]", "contact.friction_coefficient=0.0",
        "drive.speed=0", f"rings.inner.load=[0,0,{AXIAL_PRELOAD}]",
    )  # fmt: skip
    assert moving.border[2] == pytest.approx(1e-5, rel=1e-5)
    system = System(moving, moving.state, np.zeros(BORDER) + moving.border)
    system.drive = RingDrive(0.0, speed, 0.0)
    found = np.linalg.eigvals(whole(system))
    lines = np.sort(found.imag[(found.imag > 2.0 * np.pi * 100.0) & (found.imag < 2.0 * np.pi * 3000.0)]) / (2 * np.pi)
    for line in wanted:
        assert np.abs(lines / line - 1.0).min() < 5e-3, (line, lines)


def test_a_ball_rings_across_the_grooves_and_along_the_load():
    """3778 Hz and 42.9 kHz of a ball between rings that are held, 10 um of axial preload, without friction."""
    moving = motion(
        *FREE, "rings.inner.inertia=[1.0e-4,0]", "gravity=[0,0,0]", "contact.friction_coefficient=0.0",
        "drive.speed=0", f"rings.inner.load=[0,0,{AXIAL_PRELOAD}]",
    )  # fmt: skip
    system = System(moving, moving.state, np.zeros(BORDER) + moving.border)
    system.drive = RingDrive(0.0, 0.0, 0.0)
    found = np.linalg.eigvals(whole(system)[:MOTION, :MOTION])
    frequencies = np.sort(np.abs(found[found.imag > 1e3])) / (2.0 * np.pi)
    assert frequencies == pytest.approx([3778.0, 42.9e3], rel=2e-3)
