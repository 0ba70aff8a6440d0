"""Balls that land on a raceway and leave it again: none is off by more than steps may err, whenever its steps begin."""

import numpy as np
import pytest
from bearings import motion

from bearing_twin.kinds.bearing.forces.layout import VELOCITY

STILL = (
    "cage.kind=none",
    "geometry.radial_clearance=2e-5",
    "gravity=[0,0,0]",
    "drive.speed=0.0",
    "contact.friction_coefficient=0.0",
)
THROWN, BOUNCED = 0.01, 4e-4  # m/s; s after the touch, when the ball is in flight again
BOUNCES = 48  # of eight balls each


def _speed_after(tolerance, first_steps, common=False):
    """Balls' radial speeds [m/s] after a bounce on the outer raceway, and what one step may err by in it."""
    moving = motion(*STILL, "drive.offset=[0,0,0]", f"wanted.tolerance={tolerance}")
    moving.state[:, VELOCITY], moving.steps[:] = THROWN, first_steps
    until = -moving.first_outputs().approach[0, 0, 1] / THROWN + BOUNCED
    if common:
        where = np.ones(8, bool), 0.0, np.array([until]), until, moving._instants.empty(1, 8)
        moving._integrate(moving._partners(), moving.drive, *where)
    else:
        moving.advance(np.array([until]), until)
    assert (moving.first_outputs().approach[0] < 0.0).all()
    return moving.state[:, VELOCITY].copy(), float(moving.scales[VELOCITY])


@pytest.mark.parametrize("tolerance", [1e-5, 1e-7])
def test_no_landing_is_missed_by_chance(tolerance):
    """Without `stepping/landings` one of 384 is off by some hundred times what a step may err by."""
    exact = _speed_after(1e-9, np.full(8, 1e-6))[0][0]
    assert -THROWN < exact < -0.5 * THROWN
    first_steps = 1e-6 * 10.0 ** np.random.default_rng(1).uniform(-1.0, 1.0, (BOUNCES, 8))
    found = [_speed_after(tolerance, steps) for steps in first_steps]
    off = np.abs([speeds - exact for speeds, _ in found]) / found[0][1]
    assert off.max() < 8.0
    assert np.median(off) < 2.0
