"""The 218 of Harris' examples under thrust, against his equations written anew as a scalar program with SciPy's fsolve.

Rolling Bearing Analysis: ball and race positions, loads and angles under high speed (after Jones 1960), with the
coefficients of Hertz by complete elliptic integrals at the contact angle. Nothing here is taken from the package.
"""

import json
import math

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve
from scipy.special import ellipe, ellipk

from bearing_twin.kinds.bearing import CONTROLS, solver_of, support_of
from bearing_twin.run.scene import load_scene

BALLS, BALL, PITCH, CONFORMITY, FREE_ANGLE = 16, 22.23e-3, 125.26e-3, 0.5232, math.radians(40.0)
YOUNG, POISSON, DENSITY = 207.5e9, 0.3, 7850.0
THRUST = 17800.0


def hertz(side, angle):
    """Load over approach^1.5 of the ball on a raceway, side -1 inner, +1 outer."""
    gamma = BALL * math.cos(angle) / PITCH
    total = (4.0 - 1.0 / CONFORMITY - side * 2.0 * gamma / (1.0 + side * gamma)) / BALL
    difference = (1.0 / CONFORMITY - side * 2.0 * gamma / (1.0 + side * gamma)) / (BALL * total)

    def off(k):
        m = 1.0 - 1.0 / (k * k)
        return ((k * k + 1.0) * ellipe(m) - 2.0 * ellipk(m)) / ((k * k - 1.0) * ellipe(m)) - difference

    k = brentq(off, 1.01, 100.0, xtol=1e-13)
    m = 1.0 - 1.0 / (k * k)
    return math.pi * k * YOUNG / (1.0 - POISSON**2) * math.sqrt(ellipe(m) / (4.5 * total * ellipk(m) ** 3))


def thrust_solved(speed, thrust, control):
    """Axial opening A_1 [m], loads and angles (inner, outer) and centrifugal load of a ball under pure thrust."""
    shares = CONTROLS[control]
    mass, gamma, reach = DENSITY * math.pi / 6.0 * BALL**3, BALL / PITCH, (CONFORMITY - 0.5) * BALL
    radial = 2.0 * reach * math.cos(FREE_ANGLE)

    def state(x):
        axial, place_z, place_r = 1e-3 * x
        outer, inner = math.hypot(place_z, place_r), math.hypot(axial - place_z, radial - place_r)
        a_o, a_i = math.atan2(place_z, place_r), math.atan2(axial - place_z, radial - place_r)
        q_i, q_o = (hertz(s, a) * max(d - reach, 0.0) ** 1.5 for s, a, d in ((-1, a_i, inner), (1, a_o, outer)))
        beta = math.atan2(math.sin(a_o), math.cos(a_o) + gamma)
        if control == "inner":
            beta = math.atan2(math.sin(a_i), math.cos(a_i) - gamma)
        p_o = (math.cos(a_o) + math.tan(beta) * math.sin(a_o)) / (1.0 + gamma * math.cos(a_o))
        p_i = (math.cos(a_i) + math.tan(beta) * math.sin(a_i)) / (1.0 - gamma * math.cos(a_i))
        orbit, roll = speed * p_o / (p_o + p_i), speed / ((p_o + p_i) * gamma * math.cos(beta))
        centrifugal = 0.5 * mass * PITCH * orbit**2
        gyroscopic = 0.1 * mass * BALL * roll * orbit * math.sin(beta)  # M_g / D
        return a_i, a_o, q_i, q_o, centrifugal, gyroscopic

    def left(x):
        a_i, a_o, q_i, q_o, centrifugal, gyroscopic = state(x)
        f_i, f_o = (share * gyroscopic for share in shares)
        across = q_o * math.cos(a_o) - f_o * math.sin(a_o) - q_i * math.cos(a_i) + f_i * math.sin(a_i) - centrifugal
        along = q_o * math.sin(a_o) + f_o * math.cos(a_o) - q_i * math.sin(a_i) - f_i * math.cos(a_i)
        return [across, along, BALLS * (q_i * math.sin(a_i) + f_i * math.cos(a_i)) - thrust]

    start = 1e3 * reach * np.array([2.02 * math.sin(FREE_ANGLE), 1.01 * math.sin(FREE_ANGLE), math.cos(FREE_ANGLE)])
    found, _, done, why = fsolve(left, start, xtol=1e-13, full_output=True)
    assert done == 1 or np.abs(left(found)).max() < 1e-5 * thrust, why
    return 1e-3 * found[0], *state(found)


@pytest.mark.parametrize("control", ["outer", "inner", "shared"])
@pytest.mark.parametrize("rpm", [0.0, 5000.0, 10000.0])
def test_loads_and_angles_are_those_of_harris_equations(rpm, control):
    speed = rpm * math.pi / 30.0
    given = load_scene("bearing_218_thrust", [f"drive.speed={speed}", f"model.control={control}"]).parameters
    found = solver_of(given, "hertz").solve(support_of(given))
    axial, a_i, a_o, q_i, q_o, centrifugal, _ = thrust_solved(speed, THRUST, control)
    contacts = found.contacts
    assert contacts.angle[0] == pytest.approx([a_i, a_o], rel=1e-6)
    assert contacts.load[0] == pytest.approx([q_i, q_o], rel=1e-6)
    assert contacts.centrifugal[0] == pytest.approx(centrifugal, rel=1e-6)
    assert found.coordinates[2] == pytest.approx(axial, rel=1e-6)
    more, less = (thrust_solved(speed, THRUST * part, control)[0] for part in (1.001, 0.999))
    assert found.stiffness[2, 2] == pytest.approx(0.002 * THRUST / (more - less), rel=1e-4)


def integral(ratio):
    """E of the contact ellipse with this ratio of its axes."""
    return ellipe(1.0 - ratio**2)


@pytest.mark.parametrize("rpm", [0.0, 1000.0, 5000.0, 10000.0])
def test_the_raceway_that_resists_spin_more_controls_the_balls(rpm, typed):
    """Harris' criterion from the loads, angles and ellipses of the shared equilibrium."""
    words = "bearing", "bearing_218_thrust", "--set", f"drive.speed={rpm * math.pi / 30.0}", "--json"
    both = json.loads(typed(*words, "--control", "shared").out)
    inner, outer = (
        both[f"normal_load_{ring}_n"][0]
        * both[f"semi_major_{ring}_m"][0]
        * integral(both[f"semi_minor_{ring}_m"][0] / both[f"semi_major_{ring}_m"][0])
        for ring in ("inner", "outer")
    )
    parted = both["contact_angle_inner_rad"][0] - both["contact_angle_outer_rad"][0]
    wanted = "outer" if rpm and outer * math.cos(parted) > inner else "shared"
    assert json.loads(typed(*words).out)["control"] == wanted


def test_a_word_of_earlier_versions_is_read_as_its_alias():
    assert load_scene("bearing_6203", ["model.control=settled"]).parameters.model.control == "shared"


def test_a_contact_angle_beyond_the_model_is_named_as_the_cause(refused):
    said = refused("bearing", "bearing_218_thrust", "--set", "drive.speed=2300")
    assert "beyond the 60 degrees that are modelled" in said
    assert "at rest" in said
