"""Friction: its table in one loop, over a contact ellipse by itself, and in a bearing."""

import functools
import math

import numpy as np
import pytest
from bearings import (
    TURNED_REST,
    run,
)
from contact_reference import friction_by
from hypothesis import given, settings
from hypothesis import strategies as st
from runs import reported
from scipy.integrate import dblquad
from scipy.special import ellipe

from bearing_twin.charts.laws import hardest
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.kinds.bearing.outputs import contact_details
from bearing_twin.run.scene import load_scene


@pytest.mark.parametrize("name", [name for name, row in FRICTIONS.items() if row.over_patch])
def test_the_error_a_row_tells_is_the_greatest_there_is(name):
    """Looked for among all motions, without smoothing, at b/a = 0.1: not too low, and not much too high."""
    row = FRICTIONS[name]
    worst = max(error for _, error in hardest(name, 0.1, 8))
    assert 0.85 * row.error < worst <= row.error


LOAD, MAJOR, MU = 200.0, 1e-3, 0.1
FINE = functools.partial(friction_by, "spot_fine")
QUADRATURES = ("spot_fine", "spot_medium", "spot")


@pytest.mark.parametrize("name", QUADRATURES)
@pytest.mark.parametrize("ratio", [1.0, 0.3, 0.1])
def test_pure_sliding_and_pure_spinning_in_closed_form(name, ratio):
    """mu N against the slip; mu N <|r|> = 3/8 mu N a E(m) against the spin."""
    form = functools.partial(friction_by, name)
    sliding = form(LOAD, MAJOR, ratio * MAJOR, 0.3, -0.4, 0.0, MU, 0.0)
    assert sliding == pytest.approx((-0.6 * MU * LOAD, 0.8 * MU * LOAD, 0.0), rel=1e-12, abs=1e-14)
    spinning = form(LOAD, MAJOR, ratio * MAJOR, 0.0, 0.0, -50.0, MU, 0.0)
    torque = 0.375 * MU * LOAD * MAJOR * ellipe(1.0 - ratio**2)
    assert spinning == pytest.approx((0.0, 0.0, torque), abs=1e-10 + FRICTIONS[name].error * torque)
    assert form(LOAD, MAJOR, ratio * MAJOR, 0.0, 0.0, 0.0, MU, 0.0) == (0.0, 0.0, 0.0)


def test_quadrature_agrees_with_scipy_where_smooth():
    ratio, slip, spin, smooth = 0.4, (0.02, 0.05), 70.0, 0.01

    def share(part):
        def inside(angle, rho):
            x, y = MAJOR * rho * math.cos(angle), ratio * MAJOR * rho * math.sin(angle)
            u, v = slip[0] - spin * y, slip[1] + spin * x
            return (u, v, x * v - y * u)[part] / math.sqrt(u * u + v * v + smooth**2) * rho * math.sqrt(1.0 - rho**2)

        return -MU * LOAD * 1.5 / math.pi * dblquad(inside, 0.0, 1.0, 0.0, 2.0 * math.pi, epsrel=1e-9, epsabs=1e-13)[0]

    loads = FINE(LOAD, MAJOR, ratio * MAJOR, *slip, spin, MU, smooth)
    assert list(loads) == pytest.approx([share(part) for part in range(3)], rel=1e-7)


@settings(max_examples=60, deadline=None)
@given(st.floats(0.05, 1.0), st.tuples(*[st.floats(-1.0, 1.0)] * 2), st.floats(-1e3, 1e3), st.floats(1e-6, 0.1))
def test_friction_takes_energy_within_its_limits_and_turns_with_the_motion(ratio, slip, spin, smooth):
    for form in (functools.partial(friction_by, name) for name in ("point", *QUADRATURES)):
        arguments = LOAD, MAJOR, ratio * MAJOR
        loads = form(*arguments, *slip, spin, MU, smooth)
        assert loads.force_major * slip[0] + loads.force_minor * slip[1] + loads.torque * spin <= 1e-15
        assert math.hypot(loads.force_major, loads.force_minor) <= MU * LOAD * (1.0 + 1e-12)
        assert abs(loads.torque) <= MU * LOAD * MAJOR
        reversed_loads = form(*arguments, -slip[0], -slip[1], -spin, MU, smooth)
        assert [-component for component in reversed_loads] == pytest.approx(list(loads), rel=1e-9, abs=1e-12)


SPOT = "contact.friction=spot"
AXIAL = ("gravity=[0.0, 0.0, 0.0]", "drive.offset=[0.0, 0.0, 2.0e-5]")


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


def test_thrust_makes_the_balls_drill_and_the_ring_hard_to_turn():
    """At a contact angle no rolling is free of spin on both raceways; friction at a point does not notice."""
    (_, spot), (_, point) = (run(*AXIAL, *friction, count=20, period=1e-3) for friction in ((SPOT,), ()))
    last = {name: array[-1] for name, array in spot.items()}
    assert np.all(np.abs(last["contact_angle"]) > 0.05)
    assert np.all(last["drilling_torque"] * last["spin_rate"] < 0.0)
    resisting, at_a_point = -spot.inner_ring_torque[-1, 2], -point.inner_ring_torque[-1, 2]
    assert resisting > 20.0 * abs(at_a_point) > 0.0
    # Turning a ring steadily takes what its balls drill and slide away: the drive's power is the loss.
    speed = last["inner_ring_speed"]
    lost = (spot.dissipated[-1] - spot.dissipated[-6]) / 5e-3
    assert resisting * speed == pytest.approx(lost, rel=0.02)


def test_friction_over_the_patch_has_its_name_in_the_field():
    """`patch` of a scene is read as `spot`, in bearings and for bodies."""
    for scene in ("bearing_6203", "ellipsoid_rocking"):
        loads = load_scene(scene, ["contact.friction=patch_fine"]).parameters.contact.friction
        assert loads == load_scene(scene, ["contact.friction=spot_fine"]).parameters.contact.friction == "spot_fine"


RADIUS, DENSITY, MODULUS, POISSON, FRICTION, SECONDS = 0.02, 7850.0, 207.5e9, 0.3, 0.1, 0.1
WEIGHT = 4.0 / 3.0 * math.pi * RADIUS**3 * DENSITY * 9.80665
RADIUS_OF_PATCH = (1.5 * WEIGHT * RADIUS * (1.0 - POISSON**2) / MODULUS) ** (1.0 / 3.0)  # of a ball on a plane as hard


def spinning(friction):
    """A ball in balance on the plane under its weight, spinning too fast to stop within the run."""
    start = {"height": -(RADIUS_OF_PATCH**2) / RADIUS, "angular_velocity": [0.0, 0.0, 50.0]}
    contact = {"friction": friction, "friction_coefficient": FRICTION, "friction_regularisation": 1e-6}
    scene = {
        "kind": "ellipsoid_on_plane",
        "body": {"semi_axes": [RADIUS] * 3, "material": "steel"},
        "start": start,
        "contact": contact | {"restitution": 0.5},
        "run": {"duration": SECONDS, "output_rate": 1e3},
    }
    report = reported(scene)
    return report.as_dict()


@pytest.mark.parametrize("friction", [name for name, model in FRICTIONS.items() if model.over_patch])
def test_what_drilling_takes_is_within_the_error_told(friction):
    """3/16 pi mu N a of a round spot that turns about its middle (Johnson, Contact Mechanics, section 3.9)."""
    exact = -3.0 / 16.0 * math.pi * FRICTION * WEIGHT * RADIUS_OF_PATCH * SECONDS
    key, loads = "angular_momentum_change_vertical_nms", spinning(friction)
    assert loads[key] == pytest.approx(exact, rel=1e-3)
    share, errors = FRICTIONS[friction].error, loads["model_errors"]["friction_model"]
    assert abs(loads[key] - exact) <= errors[key] + loads[f"{key}_error"] <= share * abs(loads[key]) * (1.0 + 1e-9)
    assert errors["energy_end_j"] >= share * abs(loads["dissipated_friction_j"])


def test_speeds_that_are_rounding_are_no_doubt():
    """Nothing pushes the ball aside: its velocity changes by rounding, whatever share of that is an error."""
    loads = spinning("spot")
    assert abs(loads["velocity_change_x_m_s"]) < 1e-15
    assert loads["velocity_change_x_m_s_error"] < 1e-15
    assert not loads["flags"]
