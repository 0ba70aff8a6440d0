"""Friction over an elliptic spot that slides and spins: closed limits, symmetry, dissipation, errors as stated."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import dblquad
from scipy.special import ellipe

from bearing_twin.contact.ellipse import elliptic_b_d
from bearing_twin.contact.friction import (
    COARSE_ERROR,
    FINE_ERROR,
    MEDIUM_ERROR,
    friction_factor,
    spot_friction,
    spot_friction_fine,
    spot_friction_medium,
)
from bearing_twin.contact.spot_rules import (
    over_spot,
    points,
)

LOAD, MAJOR, MU = 200.0, 1e-3, 0.1
FORMS = [
    (spot_friction_fine, FINE_ERROR),
    (spot_friction_medium, MEDIUM_ERROR),
    (spot_friction, COARSE_ERROR),
]


@pytest.mark.parametrize(("form", "error"), FORMS)
@pytest.mark.parametrize("ratio", [1.0, 0.3, 0.1])
def test_pure_sliding_and_pure_spinning_in_closed_form(form, error, ratio):
    """mu N against the slip; mu N <|r|> = 3/8 mu N a E(m) against the spin."""
    sliding = form(LOAD, MAJOR, ratio * MAJOR, 0.3, -0.4, 0.0, MU, 0.0)
    assert sliding == pytest.approx((-0.6 * MU * LOAD, 0.8 * MU * LOAD, 0.0), rel=1e-12, abs=1e-14)
    spinning = form(LOAD, MAJOR, ratio * MAJOR, 0.0, 0.0, -50.0, MU, 0.0)
    torque = 0.375 * MU * LOAD * MAJOR * ellipe(1.0 - ratio**2)
    assert spinning == pytest.approx((0.0, 0.0, torque), abs=1e-10 + error * torque)
    assert form(LOAD, MAJOR, ratio * MAJOR, 0.0, 0.0, 0.0, MU, 0.0) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("ratio", [1.0, 0.2])
def test_a_little_spin_and_a_little_slip_act_linearly(ratio):
    """Drilling torque mu N omega <(r e)^2>/v, <x^2> = a^2/5; force mu N v g/omega, g = 3D/(2a) and 3B/(2a)."""
    minor = ratio * MAJOR
    along = spot_friction_fine(LOAD, MAJOR, minor, 1.0, 0.0, 1.0, MU, 0.0)
    across = spot_friction_fine(LOAD, MAJOR, minor, 0.0, 1.0, 1.0, MU, 0.0)
    assert along.torque == pytest.approx(-MU * LOAD * MAJOR**2 / 5.0, rel=1e-5)
    assert across.torque == pytest.approx(-MU * LOAD * minor**2 / 5.0, rel=1e-4)
    b, d = elliptic_b_d(ratio)
    slow, smooth = 1e-5 * minor, 1e-3 * minor  # smoothing keeps the quadrature from seeing the pole itself
    weak = [spot_friction_fine(LOAD, MAJOR, minor, *slip, 1.0, MU, smooth) for slip in ((slow, 0.0), (0.0, slow))]
    found = [-weak[0].force_major, -weak[1].force_minor]
    assert found == pytest.approx([MU * LOAD * slow * 1.5 * one / MAJOR for one in (d, b)], rel=0.03)


def test_quadrature_agrees_with_scipy_where_smooth():
    ratio, slip, spin, smooth = 0.4, (0.02, 0.05), 70.0, 0.01

    def share(part):
        def inside(angle, rho):
            x, y = MAJOR * rho * math.cos(angle), ratio * MAJOR * rho * math.sin(angle)
            u, v = slip[0] - spin * y, slip[1] + spin * x
            return (u, v, x * v - y * u)[part] / math.sqrt(u * u + v * v + smooth**2) * rho * math.sqrt(1.0 - rho**2)

        return -MU * LOAD * 1.5 / math.pi * dblquad(inside, 0.0, 1.0, 0.0, 2.0 * math.pi, epsrel=1e-9, epsabs=1e-13)[0]

    found = spot_friction_fine(LOAD, MAJOR, ratio * MAJOR, *slip, spin, MU, smooth)
    assert list(found) == pytest.approx([share(part) for part in range(3)], rel=1e-7)


@pytest.mark.parametrize("ratio", [1.0, 0.3, 0.1])
def test_errors_are_as_stated_and_needed(ratio):
    """Against rings and spokes five times finer, with the pole of the motion inside, on and outside the spot."""
    worst, finer = np.zeros(3), points(120, 480)
    for angle in np.linspace(0.0, 0.5 * math.pi, 4):
        for speed in np.geomspace(0.02, 5.0, 12):
            slip = speed * math.cos(angle), speed * math.sin(angle)
            exact = np.array(over_spot(finer, 1.0, ratio, *slip, 1.0, 0.0))
            for k, (form, _) in enumerate(FORMS):
                off = np.abs(np.array(form(1.0, 1.0, ratio, *slip, 1.0, 1.0, 0.0)) + exact) / [1.0, 1.0, 0.375]
                worst[k] = max(worst[k], off.max())
    assert worst[0] < FINE_ERROR
    assert 0.07 * MEDIUM_ERROR < worst[1] < MEDIUM_ERROR
    assert 0.07 * COARSE_ERROR < worst[2] < COARSE_ERROR


@settings(max_examples=60, deadline=None)
@given(st.floats(0.05, 1.0), st.tuples(*[st.floats(-1.0, 1.0)] * 2), st.floats(-1e3, 1e3), st.floats(1e-6, 0.1))
def test_friction_takes_energy_within_its_limits_and_turns_with_the_motion(ratio, slip, spin, smooth):
    for form, _ in FORMS:
        arguments = LOAD, MAJOR, ratio * MAJOR
        found = form(*arguments, *slip, spin, MU, smooth)
        assert found.force_major * slip[0] + found.force_minor * slip[1] + found.torque * spin <= 1e-15
        assert math.hypot(found.force_major, found.force_minor) <= MU * LOAD * (1.0 + 1e-12)
        assert abs(found.torque) <= MU * LOAD * MAJOR
        back = form(*arguments, -slip[0], -slip[1], -spin, MU, smooth)
        assert [-one for one in back] == pytest.approx(list(found), rel=1e-9, abs=1e-12)


def test_without_spin_it_is_friction_at_a_point():
    factor = friction_factor(LOAD, 3e-3, -4e-3, 0.0, MU, 0.01)
    for form, _ in FORMS:
        found = form(LOAD, MAJOR, 0.2 * MAJOR, 3e-3, -4e-3, 0.0, MU, 0.01)
        assert found[:2] == pytest.approx((-3e-3 * factor, 4e-3 * factor), rel=1e-12)


def test_spin_weakens_the_force():
    forces = [
        -spot_friction_fine(LOAD, MAJOR, 0.1 * MAJOR, 0.01, 0.0, spin, MU, 0.0).force_major
        for spin in (0, 30, 100, 300)
    ]
    assert np.all(np.diff(forces) < 0.0)
