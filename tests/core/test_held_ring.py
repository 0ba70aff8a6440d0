"""A ball between rings that are held, by the compiled core: its derivatives, and what its rates conserve."""

import numpy as np
import pytest
from bearings import law_keys, motion
from ring_systems import system_jacobian, system_rates

from bearing_twin.kinds.bearing.system import COLUMNS, HELD, MOTION, TILTED, RingDrive

FRICTIONS = ("point", "spot", "spot_medium", "spot_fine", "pade1", "pade2")
LAWS = ("hertz", "volumetric", "constant", "linear", "hertz_differential")
# Changes of a ball's motion that matter, of its orbit rate in place of the velocity along the orbit.
SIZES = np.array([1e-6, 1e-2, 1e-6, 1e-2, 0.7, 1e-2, 1.0, 1.0, 1.0])


def moving_ball(law, friction, tilt=(0.0, 0.0)):
    """A ball that slides and spins in both contacts, its state (COLUMNS,) with the orbit rate; and its system."""
    keys = "drive.speed=300", f"contact.friction={friction}", *law_keys(law)
    moving = motion(*keys, scene="bearing_6203_fast", law=law)
    state = moving.state[1].copy()
    state[4] /= state[0]
    state[:MOTION] += 0.3 * SIZES * np.array([0.2, 3.0, 1.0, 1.0, -2.0, 1.5, 20.0, -30.0, 5.0])
    bearing = moving.bearing._replace(ring=TILTED if any(tilt) else HELD, tilt=tilt)
    return state, (bearing, RingDrive(0.0, 300.0, 0.0), moving.bodies, np.zeros(1, bool), moving.body_state)


def arguments(state, system):
    """The arguments of `system_rates` for a ball in this state."""
    *before, body_state = system
    ball = state.copy()
    ball[4] *= ball[0]
    return *before, ball[None], body_state


@pytest.mark.parametrize("friction", FRICTIONS)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("tilt", [(0.0, 0.0), (2e-3, -1e-3)])
def test_derivatives_are_those_of_differences(law, friction, tilt):
    state, system = moving_ball(law, friction, tilt)
    jacobian = system_jacobian(*arguments(state, system))[:MOTION, :MOTION]
    for column, size in enumerate(SIZES):
        slopes = []
        for step in (1e-3 * size, 5e-4 * size):  # Richardson's of central differences
            change = step * np.eye(COLUMNS)[column]
            ahead, behind = (
                system_rates(*arguments(changed, system))[:MOTION] for changed in (state + change, state - change)
            )
            slopes.append((ahead - behind) / (2.0 * step))
        expected = (4.0 * slopes[1] - slopes[0]) / 3.0
        greatest = np.abs(jacobian[:, column]).max()
        assert np.abs(jacobian[:, column] - expected).max() < 1e-6 * greatest, column
