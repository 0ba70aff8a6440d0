"""Where balls rest and how they roll at the start, and the least squares behind it."""

import numpy as np
import pytest

from bearing_twin.errors import SceneError
from bearing_twin.kinds.bearing.forces.equations import single_contact, static_force
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, HEIGHT, ORBIT_ANGLE, SPIN, TANGENTIAL_VELOCITY
from bearing_twin.kinds.bearing.start import bearing_of, start_state
from bearing_twin.numerics.rotation import about_z
from bearing_twin.run.fidelity import choose
from bearing_twin.run.scene import load_scene


def start_of(name, *overrides):
    scene = load_scene(name, overrides)
    bearing = bearing_of(scene.parameters, choose(scene).law)
    return bearing, scene.parameters.drive.speed, start_state(bearing, scene.parameters.drive.speed, "rolling")


@pytest.mark.parametrize("name", ["bearing_6203", "bearing_6203_loose", "bearing_6203_fast"])
@pytest.mark.parametrize("offset", ["[0,0,0]", "[0,0,6e-5]", "[1e-6,-2e-6,-5e-6]", "[0,-1e-5,4e-5]"])
def test_nothing_pushes_a_ball_at_the_start_and_it_rolls(name, offset):
    """Also on one raceway alone, and held by its orbit alone; slip against what the ring's surface runs at."""
    bearing, speed, state = start_of(name, f"drive.offset={offset}")
    for ball in state:
        distance, angle, height = ball[AXIS_DISTANCE], ball[ORBIT_ANGLE], ball[HEIGHT]
        rate = ball[TANGENTIAL_VELOCITY] / distance
        centrifugal = bearing.ball_mass * distance * rate**2
        force = np.hypot(*static_force(bearing, rate, distance, angle, height))
        # Iterating orbit and rest three times leaves this much of the change of the orbit.
        assert force < 1e-3 * centrifugal
        centre, position = about_z(np.cos(angle), -np.sin(angle), bearing.offset), (distance, 0.0, height)
        velocity, spin = (0.0, ball[TANGENTIAL_VELOCITY], 0.0), tuple(ball[SPIN : SPIN + 3])
        inner = single_contact(bearing, bearing.inner, centre, speed, position, velocity, spin)
        outer = single_contact(bearing, bearing.outer, (0.0, 0.0, 0.0), 0.0, position, velocity, spin)
        assert max(np.abs(inner.slip).max(), np.abs(outer.slip).max()) < 1e-3 * speed * distance


def test_a_ball_that_nothing_presses_is_in_the_middle():
    bearing, _, state = start_of("bearing_6203_loose", "drive.speed=0", "drive.offset=[0,0,0]")
    middle = 0.5 * (bearing.inner.locus_radius + bearing.outer.locus_radius)
    assert state[:, AXIS_DISTANCE] == pytest.approx(middle, abs=1e-12)
    assert np.all(static_force(bearing, 0.0, state[3, AXIS_DISTANCE], 0.0, 0.0) == np.zeros(2))


def test_balls_that_their_orbit_throws_through_the_raceway_are_refused():
    bearing, _, _ = start_of("bearing_6203")
    with pytest.raises(SceneError, match="find no rest"):
        start_state(bearing, 1e6, "rolling")
