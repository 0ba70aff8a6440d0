"""A run that cannot go on names the reason, the time and the body, whatever the kind and the method."""

import math
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from bearing_twin.errors import IntegrationError, SceneError
from bearing_twin.kinds.bearing.forces.layout import TANGENTIAL_VELOCITY, VELOCITY
from bearing_twin.kinds.impact import collision
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation

JUMP = ("drive.change.time=1e-4", "drive.change.offset=[0, -4e-5, 0]", "run.duration=0.001")


def failed(name, *overrides) -> IntegrationError:
    with pytest.raises(IntegrationError) as caught:
        for _ in simulate(load_scene(name, overrides)).blocks():
            pass
    return caught.value


def motion_of(stepper):
    return Simulation(load_scene("bearing_6203", (f"solver.stepper={stepper}", "solver.companion=off")))._motion


@pytest.mark.parametrize(
    ("stepper", "step", "words"),
    [("imex", "1e-4", "rings between its contacts at"), ("rk4", "4e-6", "friction answers at")],
)
def test_a_fixed_step_that_is_refused_before_the_run_names_the_ball(stepper, step, words):
    """Of a ring shifted towards the third ball, the one above: ball 2 of 8."""
    scene = load_scene(
        "bearing_6203", (f"solver.stepper={stepper}", f"solver.step={step}", "drive.offset=[0, 5e-6, 0]")
    )
    with pytest.raises(SceneError, match="ball 2") as caught:
        simulate(scene)
    assert words in str(caught.value)


@pytest.mark.parametrize("stepper", ["imex", "rk4"])
def test_a_fixed_step_that_a_jump_of_the_ring_makes_too_long_names_the_ball_below(stepper):
    """The ring jumps down: the lowest of 8 balls that begin at azimuth 0 is number 6."""
    error = failed("bearing_6203", f"solver.stepper={stepper}", "solver.step=5e-7", *JUMP)
    assert (error.reason, error.seconds, error.body) == ("step too long", pytest.approx(1e-4), "ball 6")
    assert error.contact in ("inner race", "outer race")
    assert "ball 6" in str(error)


def test_a_step_of_all_balls_that_cannot_be_short_enough_names_the_ball_that_errs_most():
    motion = motion_of("dopri5")
    motion.state[5, VELOCITY] = 1e100
    with pytest.raises(IntegrationError) as caught:
        motion.advance(np.array([1e-3]), 1e-3)
    assert (caught.value.reason, caught.value.body) == ("stalled", "ball 5")


@pytest.mark.parametrize("number", [math.nan, 1e200])
def test_a_state_that_is_no_number_or_too_great_names_its_ball(number):
    motion = motion_of("rodas4")
    motion.state[5, VELOCITY] = number
    with pytest.raises(IntegrationError, match="ball 5 is not finite") as caught:
        motion.advance(np.array([1e-3]), 1e-3)
    assert (caught.value.reason, caught.value.body) == ("not finite", "ball 5")


def ends_badly(status, last, right_hand_side, begin, state, end, **kept):
    """In the place of a solver of SciPy: one step, with this status, and this as the last number of its end."""
    made = SimpleNamespace(status="running", t=begin, y=state)
    made.step = lambda: vars(made).update(status=status, t=1e-4, y=np.append(state[:-1], last))
    return made


@pytest.mark.parametrize(
    ("status", "last", "reason"), [("failed", 0.0, "stalled"), ("running", math.nan, "not finite")]
)
def test_methods_of_scipy_name_time_and_ball(status, last, reason, monkeypatch):
    """The time counts from the start of the run, not of the chunk; the ball that changes fastest makes steps short."""
    monkeypatch.setattr("scipy.integrate.DOP853", partial(ends_badly, status, last))
    motion = motion_of("dop853")
    motion.elapsed = 0.5
    motion.state[7, TANGENTIAL_VELOCITY] += 1.0  # it slides, the others roll
    with pytest.raises(IntegrationError, match=r"^at 0\.5001 s ball 7 ") as caught:
        motion.advance(np.array([1e-3]), 1e-3)
    assert (caught.value.reason, caught.value.body) == (reason, "ball 7")
    assert caught.value.seconds == pytest.approx(0.5001)


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
