"""The order of every shipped kernel on the bearing itself, in contact, while the inner ring speeds up.

One step a chunk: with errors that weigh nothing and a long step carried along, an adaptive stepper takes the chunk in
one step, so halving the chunk halves the step. The truth is rk4 at steps fifty times shorter; dopri5 confirms it.
"""

import math

import numpy as np
import pytest
from bearings import motion

from bearing_twin.kinds.bearing.forces.layout import VELOCITY
from bearing_twin.numerics.steppers import STEPPER_FACTS

SPAN = 4.8e-5
ACCELERATED = (
    "drive.acceleration=1e6", "contact.friction_regularisation=0.3", "drive.offset=[2.0e-6, -1.0e-6, 5.0e-6]",
)  # fmt: skip
# Thirteen balls that fill the circle, pressed so far outwards and inwards that each touches both neighbours for good.
FULL = (
    "geometry.balls=13", f"geometry.pitch_diameter={6.746e-3 / math.sin(math.pi / 13) * (1.0 + 1e-9)!r}",
    "geometry.radial_clearance=-40e-6",
)  # fmt: skip


def after(start, overrides, stepper, step):
    """Outputs after SPAN by equal steps [s] from a state and orientation, the ring speeding up all the while."""
    moving = motion(*ACCELERATED, *overrides, stepper=stepper)
    moving.state[:], moving.orientation[:] = start
    moving.goal_speed = 1e4
    moving.scales, moving.step = np.full_like(moving.scales, np.inf), step
    moving.advance(np.array([]), 1e-9)  # where the acceleration begins, steppers begin with a short step
    steps = round(SPAN / step)
    for _ in range(steps):
        moving.steps[:] = 1.0
        out = moving.advance(np.array([step]), step)
    assert moving.costs()["ball_steps"] == (steps + 1) * len(moving.state)
    assert moving.costs()["ball_rejections"] == 0
    return {name: getattr(out, name)[0] for name in ("velocity", "slip", "raceway_torque", "normal_load")}


def errors(start, overrides, stepper, step, exact):
    """Error of velocity, slip, friction torque and normal load, each over its greatest value."""
    found = after(start, overrides, stepper, step)
    return np.array([np.abs(found[name] - exact[name]).max() / np.abs(exact[name]).max() for name in exact])


def settled(overrides, seconds, kick=0.0):
    """A state in rolling contact, its contacts set ringing by a `kick` [m/s] or not, and the outputs SPAN later."""
    moving = motion(*ACCELERATED, *overrides)
    moving.advance(np.array([]), seconds)
    balls = np.arange(len(moving.state))
    moving.state[:, VELOCITY] += kick * np.cos(2.4 * balls)
    moving.state[:, VELOCITY + 2] += kick * np.cos(1.1 * balls)
    start = moving.state.copy(), moving.orientation.copy()
    return start, after(start, overrides, "rk4", 2e-8)


@pytest.fixture(scope="module")
def rolling():
    """Eight balls apart, at ease and ringing."""
    return settled((), 5e-3), settled((), 5e-3, 0.03)


@pytest.fixture(scope="module")
def pressed():
    """Thirteen balls, each touching both neighbours, at ease and ringing."""
    return settled(FULL, 3e-3), settled(FULL, 2e-3, 0.03)


def orders(case, overrides, stepper, step):
    """Observed order of velocity, slip, friction torque and normal load between `step` [s] and half of it."""
    start, exact = case
    coarse, fine = (errors(start, overrides, stepper, h, exact) for h in (step, 0.5 * step))
    assert np.all(coarse < 1e-3)
    return np.log2(coarse / fine)


@pytest.mark.parametrize(
    ("stepper", "step"),
    [("rodas4", 4e-6), ("rodas4_landing", 4e-6), ("rodas3", 2e-6), ("rk4", 1e-6), ("dopri5", 1e-6), ("imex", 1e-6)],
)
def test_ringing_balls_have_the_order_of_their_method(rolling, stepper, step):
    assert orders(rolling[1], (), stepper, step) == pytest.approx(STEPPER_FACTS[stepper].order, abs=0.5)


@pytest.mark.parametrize(("stepper", "step"), [("rodas4", 4e-6), ("rodas3", 2e-6)])
def test_balls_at_ease_follow_the_ring_with_the_order_of_their_method(rolling, stepper, step):
    """What is left of the errors, down to 1e-9, comes from the ring's speed: from the explicit time term above all."""
    assert orders(rolling[0], (), stepper, step) == pytest.approx(STEPPER_FACTS[stepper].order, abs=0.5)


@pytest.mark.parametrize(
    ("stepper", "step"), [("rodas4", 4e-6), ("rodas3", 2e-6), ("rk4", 1e-6), ("dopri5", 1e-6), ("imex", 1e-6)]
)
def test_touching_balls_have_the_order_of_their_method(pressed, stepper, step):
    assert orders(pressed[1], FULL, stepper, step) == pytest.approx(STEPPER_FACTS[stepper].order, abs=0.5)


@pytest.mark.parametrize(("stepper", "step", "halvings"), [("rodas4", 8e-6, 3), ("rodas3", 4e-6, 2)])
def test_touching_balls_at_ease_follow_the_ring_with_the_order_of_their_method(pressed, stepper, step, halvings):
    """Over so many halvings, as errors of slip and torque change sign on the way.

    No further: a start that differs by 1e-13 changes the torque's error, when rodas3 takes steps of 0.5 us, by half.
    """
    start, exact = pressed[0]
    coarse, fine = (errors(start, FULL, stepper, h, exact) for h in (step, step / 2**halvings))
    assert np.log2(coarse / fine) / halvings == pytest.approx(STEPPER_FACTS[stepper].order, abs=0.7)
