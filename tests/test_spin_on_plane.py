"""A ball that spins upright on a plane: drilling friction in closed form, and what a run says of its own figures."""

import math

import pytest

from bearing_twin import load_scene, simulate
from bearing_twin.contact.friction import FRICTIONS

RADIUS, DENSITY, MODULUS, POISSON, FRICTION, SECONDS = 0.02, 7850.0, 207.5e9, 0.3, 0.1, 0.1
WEIGHT = 4.0 / 3.0 * math.pi * RADIUS**3 * DENSITY * 9.80665
SPOT = (1.5 * WEIGHT * RADIUS * (1.0 - POISSON**2) / MODULUS) ** (1.0 / 3.0)  # of a ball on a plane as hard


def spinning(friction):
    """A ball in balance on the plane under its weight, spinning too fast to stop within the run."""
    start = {"height": -(SPOT**2) / RADIUS, "angular_velocity": [0.0, 0.0, 50.0]}
    contact = {"friction": friction, "friction_coefficient": FRICTION, "friction_regularisation": 1e-6}
    scene = {
        "kind": "ellipsoid_on_plane",
        "body": {"semi_axes": [RADIUS] * 3, "material": "steel"},
        "start": start,
        "contact": contact | {"restitution": 0.5},
        "run": {"duration": SECONDS, "output_rate": 1e3},
    }
    run = simulate(load_scene(scene))
    list(run.blocks())
    return run.report.as_dict()


@pytest.mark.parametrize("friction", [name for name, one in FRICTIONS.items() if one.over_patch])
def test_what_drilling_takes_is_within_the_error_told(friction):
    """3/16 pi mu N a of a round spot that turns about its middle (Johnson, Contact Mechanics, section 3.9)."""
    exact = -3.0 / 16.0 * math.pi * FRICTION * WEIGHT * SPOT * SECONDS
    key, found = "angular_momentum_change_vertical_nms", spinning(friction)
    assert found[key] == pytest.approx(exact, rel=1e-3)
    share, errors = FRICTIONS[friction].error, found["model_errors"]["friction_model"]
    assert abs(found[key] - exact) <= errors[key] + found[f"{key}_error"] <= share * abs(found[key]) * (1.0 + 1e-9)
    assert errors["energy_end_j"] >= share * abs(found["dissipated_friction_j"])


def test_speeds_that_are_rounding_are_no_doubt():
    """Nothing pushes the ball aside: its velocity changes by rounding, whatever share of that is an error."""
    found = spinning("spot")
    assert abs(found["velocity_change_x_m_s"]) < 1e-15
    assert found["velocity_change_x_m_s_error"] == 0.0
    assert not found["flags"]
