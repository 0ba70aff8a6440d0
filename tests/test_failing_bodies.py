"""A run that cannot go on names the reason, the time and the body, whatever the kind and the method."""

import math

import numpy as np
import pytest

from bearing_twin.errors import IntegrationError
from bearing_twin.kinds.bearing.forces.layout import VELOCITY
from bearing_twin.kinds.impact import collision
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation


def failed(name, *overrides) -> IntegrationError:
    with pytest.raises(IntegrationError) as caught:
        for _ in simulate(load_scene(name, overrides)).blocks():
            pass
    return caught.value


def motion_of(stepper):
    return Simulation(load_scene("bearing_6203", (f"solver.stepper={stepper}", "solver.companion=off")))._motion


@pytest.mark.parametrize("number", [math.nan, 1e200])
def test_a_state_that_is_no_number_or_too_great_names_its_ball(number):
    motion = motion_of("rodas4")
    motion.state[5, VELOCITY] = number
    with pytest.raises(IntegrationError, match="ball 5 is not finite") as caught:
        motion.advance(np.array([1e-3]), 1e-3)
    assert (caught.value.reason, caught.value.body) == ("not finite", "ball 5")


@pytest.mark.parametrize(
    ("name", "overrides", "reason", "body", "contact"),
    [
        ("ellipsoid_on_plane", ("start.velocity=[0, 0, -2000]",), "too deep", "body", "plane"),
        ("two_bodies_groove", ("first.velocity=[0, 0, -2000]",), "", "first", "second"),
    ],
)
def test_bodies_that_bounce_are_named(name, overrides, reason, body, contact):
    error = failed(name, *overrides)
    assert error.reason in ((reason,) if reason else ("too deep", "untracked"))
    assert (error.body, error.contact) == (body, contact)
    assert math.isfinite(error.seconds)


@pytest.mark.parametrize(("stepper", "limit"), [("dop853", "LONGEST"), ("rk4", "MOST_NODES"), ("dop853", "LEAST_STEP")])
def test_bodies_that_do_not_part_are_named(stepper, limit, monkeypatch):
    """Where a contact may take a tenth of its time, or ten steps, or where no step is long enough."""
    monkeypatch.setattr(collision, limit, {"LONGEST": 0.1, "MOST_NODES": 10, "LEAST_STEP": 1e9}[limit])
    error = failed("two_spheres", "contact.restitution=0.8", f"solver.stepper={stepper}", "motion.gap=1e-3")
    reason = "not finite" if limit == "LEAST_STEP" else "no end"
    assert (error.reason, error.body, error.contact) == (reason, "first", "second")
    assert error.seconds > 0.0


def test_a_sphere_that_bounces_on_a_beam_for_ever_is_named(monkeypatch):
    monkeypatch.setattr("bearing_twin.kinds.beam.impact.GREATEST_CONTACTS", 1)
    error = failed("sphere_on_beam_drop_50mm")
    assert (error.reason, error.body, error.contact) == ("no end", "sphere", "beam")
    assert error.seconds > 0.0
