"""Balls that nothing keeps apart step in common only while they are close, and meet as if they always did."""

import numpy as np
from bearings import motion


def _moved(common, duration, tolerance, rate):
    """A start from rest, in which two balls meet first at 6.65 ms: by parts, or with steps in common from the start."""
    moving = motion("initial.motion=rest", f"wanted.tolerance={tolerance}", scene="bearing_6203_loose")
    times = np.arange(1, round(duration * rate) + 1) / rate
    if not common:
        return moving, moving.advance(times, duration).neighbour_load
    filled = moving._instants.empty(len(times), moving.bearing.balls)
    near = np.ones(moving.bearing.balls, bool)
    moving._integrate(moving._partners(), moving.drive, near, 0.0, times, duration, filled)
    return moving, None


def test_meetings_are_those_of_balls_that_always_step_in_common():
    (parts, pushes), (common, _) = (_moved(one, 7e-3, 1e-8, 2e4) for one in (False, True))
    assert pushes.max() > 5.0  # N
    assert np.abs(parts.state - common.state)[:, :3].max() < 1e-8
