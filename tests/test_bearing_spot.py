"""Friction over the spots of a bearing: limits in closed form, balances with drilling, every stepper, and its cost."""

import math

import numpy as np
import pytest
from bearings import (
    TURNED_REST,
    in_ball_frame,
    motion,
    run,
    stored_energy,
    with_spot,
)
from scipy.special import ellipe

from bearing_twin.contact.ellipse import (
    curvature_ratio,
    ellipse,
    hertz_coefficient,
    semi_axes,
)
from bearing_twin.kinds.bearing.forces.equations import ball_position, single_contact
from bearing_twin.kinds.bearing.forces.layout import MOTION, ORBIT_ANGLE, SPIN, VELOCITY
from bearing_twin.kinds.bearing.outputs import contact_details
from bearing_twin.numerics.steppers import STEPPER_FACTS

SPOT = "contact.friction=spot"
MIDDLE = (0.0, 0.0, 0.0)
AXIAL = ("gravity=[0.0, 0.0, 0.0]", "drive.offset=[0.0, 0.0, 2.0e-5]")


def test_rational_semi_axes_against_the_exact_ellipse():
    for ratio in np.geomspace(0.01, 1.0, 40):
        small, large = 7.0, 7.0 * curvature_ratio(ratio)
        exact = ellipse(small, large, 1e11, hertz_coefficient(small, large, 1e11) * 2e-6**1.5)
        assert semi_axes(small, large, 2e-6) == pytest.approx((exact.semi_major, exact.semi_minor), rel=1e-5)
    assert semi_axes(7.0, 90.0, -1e-6) == (0.0, 0.0)


def contact_of(overrides=(), k=2):
    """The inner contact of ball k of a bearing with spots, by itself."""
    moving = motion(SPOT, *TURNED_REST, *overrides)
    state, bearing = moving.state, moving.bearing
    centre, position = in_ball_frame(state, k, bearing.offset), ball_position(state, k)
    velocity, spin = tuple(state[k, VELOCITY:SPIN]), tuple(state[k, SPIN:MOTION])
    contact = single_contact(bearing, bearing.inner, centre, moving.drive.speed, position, velocity, spin)
    return moving, centre, position, contact


def test_pure_spinning_and_pure_sliding_in_closed_form():
    """3/8 mu N a E(m) against the spin, mu N against the slip; the slip's smoothing is far below both."""
    moving, centre, position, contact = contact_of(("contact.friction_regularisation=1e-6",))
    bearing = moving.bearing
    major, minor = semi_axes(contact.curvature_small, contact.curvature_large, contact.approach)
    limit = bearing.spot[0] * contact.normal_load
    spinning = contact._replace(slip=MIDDLE, spin_rate=-3e3)
    found = with_spot(bearing, 0, centre, 0.0, position, spinning)
    torque = 0.375 * limit * major * ellipe(1.0 - (minor / major) ** 2)
    assert found.drilling == pytest.approx(torque, rel=1e-2)
    assert np.linalg.norm(found.friction) < 1e-9 * limit
    assert found.dissipation == pytest.approx(3e3 * torque, rel=1e-2)
    sliding = contact._replace(spin_rate=0.0)
    found = with_spot(bearing, 0, centre, 0.0, position, sliding)
    along = np.array(contact.slip) / np.linalg.norm(contact.slip)
    assert np.array(found.friction) == pytest.approx(-limit * along, rel=1e-9, abs=1e-9 * limit)
    assert abs(found.drilling) < 1e-12 * limit


def test_far_below_the_smoothing_speed_friction_is_that_at_a_point_and_drilling_linear():
    """With v_s far above all slip, force = -mu N slip/v_s and drilling = -mu N spin (a^2 + b^2)/(5 v_s)."""
    smooth = ("contact.friction_regularisation=1e3",)
    _, spot = run(SPOT, *TURNED_REST, *smooth, count=3)
    moving, point = run(*TURNED_REST, *smooth, count=3)
    assert spot.friction_force == pytest.approx(point.friction_force, rel=1e-4, abs=1e-9)
    assert np.all(point.drilling_torque == 0.0)
    for row in range(3):
        sample = {name: array[row] for name, array in spot.items()}
        details = contact_details(moving.parameters, sample)
        squares = details["semi_major"] ** 2 + details["semi_minor"] ** 2
        expected = -0.08 * sample["normal_load"] * sample["spin_rate"] * squares / 5e3
        assert sample["drilling_torque"] == pytest.approx(expected, rel=0.1)  # the viscous part of the load, in a and b


@pytest.mark.parametrize("scene", ["bearing_6203", "bearing_6203_loose"])
def test_energy_closes_with_drilling(scene):
    moving = motion(SPOT, "initial.motion=rest", "drive.offset=[0.0, -9.0e-6, 1.0e-5]", scene=scene)
    before = stored_energy(moving.first_outputs())[0]
    out = moving.advance(np.arange(1, 31) * 2e-4, 6e-3)
    assert out.drive_work[-1] > 1e-4
    residual = out.drive_work[-1] - (stored_energy(out)[-1] - before) - out.dissipated[-1]
    assert abs(residual) < 1e-4 * out.drive_work[-1]
    assert np.all(np.diff(out.dissipated) >= -1e-15)


def test_thrust_makes_the_balls_drill_and_the_ring_hard_to_turn():
    """At a contact angle no rolling is free of spin on both raceways; friction at a point does not notice."""
    (_, spot), (_, point) = (run(*AXIAL, *more, count=20, period=1e-3) for more in ((SPOT,), ()))
    last = {name: array[-1] for name, array in spot.items()}
    assert np.all(np.abs(last["contact_angle"]) > 0.05)
    assert np.all(last["drilling_torque"] * last["spin_rate"] < 0.0)
    resisting, at_a_point = -spot.inner_ring_torque[-1, 2], -point.inner_ring_torque[-1, 2]
    assert resisting > 20.0 * abs(at_a_point) > 0.0
    # Turning a ring steadily takes what its balls drill and slide away: the drive's power is the loss.
    speed = last["inner_ring_speed"]
    lost = (spot.dissipated[-1] - spot.dissipated[-6]) / 5e-3
    assert resisting * speed == pytest.approx(lost, rel=0.02)


def test_every_stepper_agrees_with_radau():
    """Load and friction torque within 1e-3 of SciPy's Radau from rest through sliding; drilling, small there, 3e-3."""
    reference = run(SPOT, *TURNED_REST, stepper="radau", count=3)[1]
    for stepper in sorted(set(STEPPER_FACTS) - {"radau"}):
        out = run(SPOT, *TURNED_REST, stepper=stepper, count=3)[1]
        for name, close in (("normal_load", 1e-3), ("raceway_torque", 1e-3), ("drilling_torque", 3e-3)):
            exact = getattr(reference, name)
            assert np.abs(getattr(out, name) - exact).max() < close * np.abs(exact).max(), (stepper, name)


@pytest.mark.parametrize("law", ["volumetric", "constant"])
def test_every_law_takes_spots(law):
    _, out = run(SPOT, *TURNED_REST, law=law, count=10)
    _, hertz = run(SPOT, *TURNED_REST, count=10)
    close = 0.02 * np.abs(hertz.drilling_torque).max()
    assert out.drilling_torque == pytest.approx(hertz.drilling_torque, abs=close)


def test_balls_that_touch_are_integrated_with_their_spots():
    """A row of touching balls by one dense matrix: energy closes, and the same as by rk4."""
    full = ("geometry.balls=12", "initial.motion=rest", "drive.offset=[0.0, -2.0e-6, 1.0e-5]", SPOT)
    outs = []
    for stepper in ("rodas4", "rk4"):
        moving = motion(*full, stepper=stepper)
        apart = 2.0 * math.asin((6.746e-3 - 1e-6) / (2.0 * moving.state[0, 0]))
        moving.state[0, ORBIT_ANGLE] = moving.state[1, ORBIT_ANGLE] - apart
        start = stored_energy(moving.first_outputs())[0]
        out = moving.advance(np.arange(1, 11) * 2e-5, 2e-4)
        residual = out.drive_work[-1] - (stored_energy(out)[-1] - start) - out.dissipated[-1]
        assert abs(residual) < 1e-3 * out.gross_work[-1]
        outs.append(out)
    for name in ("drilling_torque", "raceway_torque"):
        found, expected = (getattr(out, name) for out in outs)
        assert found == pytest.approx(expected, abs=1e-3 * np.abs(expected).max())
