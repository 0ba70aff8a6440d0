"""Damping of a bearing's contacts by the restitution wanted: rebounds measured, and what excludes what."""

import numpy as np
import pytest
from bearings import motion

from bearing_twin.contact.damping import damping_number, restitution_of
from bearing_twin.errors import SceneError
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, VELOCITY
from bearing_twin.run.scene import load_scene, open_scene, parse_scene

ALONE = (
    "geometry.balls=1",
    "cage.kind=none",
    "geometry.radial_clearance=4e-5",
    "gravity=[0.0, 0.0, 0.0]",
    "drive.offset=[0.0, 0.0, 0.0]",
    "drive.speed=0.0",
    "contact.friction_coefficient=0.0",
    "initial.motion=rest",
    "wanted.tolerance=1e-5",
)


def rebound(speed, *overrides, stepper="rodas4"):
    """Speed after over speed before of one ball thrown from the middle of the clearance at the outer raceway."""
    moving = motion(*ALONE, *overrides, stepper=stepper)
    moving.state[0, AXIS_DISTANCE], moving.state[0, VELOCITY] = 14.25e-3, speed
    span = 1e-5 / speed + 4e-5
    out = moving.advance(np.array([span]), span)
    assert np.all(out.normal_load == 0.0)
    return -moving.state[0, VELOCITY] / speed


@pytest.mark.parametrize("restitution", [0.9, 0.5])
@pytest.mark.parametrize("stepper", ["rodas4", "rk4"])
def test_a_ball_comes_back_from_a_raceway_with_the_restitution_asked_for(restitution, stepper):
    assert rebound(0.1, f"contact.restitution={restitution}", stepper=stepper) == pytest.approx(restitution, rel=2e-3)


def test_faster_balls_lose_more_and_the_speed_it_holds_at_can_be_moved():
    """e depends on chi v alone (exact relation of Hunt and Crossley's law)."""
    at_three = restitution_of(3.0 * damping_number(0.8))
    assert rebound(0.3, "contact.restitution=0.8") == pytest.approx(at_three, rel=2e-3)
    assert rebound(0.3, "contact.restitution=0.8", "contact.restitution_speed=0.3") == pytest.approx(0.8, rel=2e-3)


def test_without_a_restitution_the_relaxation_time_damps():
    assert 0.3 < rebound(0.1) < 0.97
    assert rebound(0.1, "contact.relaxation_time=0.0") == pytest.approx(1.0, abs=2e-3)


def test_one_damping_is_enough():
    for key, value in (("damping", "0.2"), ("relaxation_time", "2e-6"), ("relaxation_time", "1e-6")):
        with pytest.raises(SceneError, match=f"contact.{key} = .* all set the viscous term; keep one of them"):
            load_scene("bearing_6203", ["contact.restitution=0.8", f"contact.{key}={value}"])
    scene = load_scene("bearing_6203", ["contact.restitution=0.8"])
    assert scene.parameters.contact.relaxation_time == 0.0
    assert parse_scene(scene.resolved(), "again") == scene
    assert parse_scene(open_scene("bearing_6203", ["contact.restitution=0.8"])[0], "with all keys") == scene
    plain = load_scene("bearing_6203").resolved()  # where all keys stand, whoever gave them
    assert load_scene(plain, ["contact.restitution=0.8"]).parameters == scene.parameters
    assert load_scene("bearing_6203").parameters.contact.relaxation_time == 1e-6
    with pytest.raises(SceneError, match="above 0"):
        load_scene("bearing_6203", ["contact.restitution=0.0"])
