"""Restitution and damping: the exact relation, impacts integrated, and what the usual shortcuts give."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.special import beta

from bearing_twin.contact.damping import (
    damped_load,
    damping_for_restitution,
    damping_number,
    restitution_of,
    shortcuts,
    steady_damped_load,
    steady_damping,
    steady_restitution,
)
from bearing_twin.errors import SceneError

COEFFICIENT, MASS = 2.4e10, 1.25e-3


def rebound(load, speed):
    """Speed after over speed before of an impact on a wall, integrated to where the bodies part or cease to press."""
    scale = (1.25 * MASS * speed**2 / COEFFICIENT) ** 0.4

    def rates(_, state):
        return state[1], -load(state[0] * scale, state[1] * speed) * scale / (MASS * speed**2)

    def parted(time, state):
        pressing = load(max(state[0], 0.0) * scale, state[1] * speed) > 0.0
        return 1.0 if time < 0.3 or (pressing and state[0] > 0.0) else -1.0

    parted.terminal = True
    found = solve_ivp(rates, (0.0, 1e4), (0.0, 1.0), rtol=1e-10, atol=1e-13, events=parted, max_step=0.02)
    return -found.y[1, -1]


# Published: e, chi v of the exact relation.
@pytest.mark.parametrize(("e", "number"), [(0.9, 0.16648), (0.7, 0.63483), (0.5, 1.43275)])
def test_exact_relation_matches_published_numbers(e, number):
    assert damping_number(e) == pytest.approx(number, abs=6e-6)


@given(st.floats(1e-3, 1.0, exclude_max=True))
def test_exact_relation_and_its_inverse(e):
    number = damping_number(e)
    assert restitution_of(number) == pytest.approx(e, rel=1e-11)
    if 0.05 < e < 0.99:
        assert number * (1.0 + e) == pytest.approx(math.log((1.0 + number) / (1.0 - e * number)), rel=1e-9)


@pytest.mark.parametrize("number", [1e3, 1e16, 1e20, 1e300])
def test_a_contact_that_is_damped_without_bound_leaves_at_the_speed_where_no_load_is_left(number):
    """The load c h^1.5 (1 + chi dh/dt) is 0 at dh/dt = -1/chi: e = 1/(chi v)."""
    assert restitution_of(number) == pytest.approx(1.0 / number, rel=1e-12)


def test_near_elastic_the_number_follows_its_series():
    """x = (3/2)(1 - e) + O((1-e)^2), where the logarithms leave no digit standing."""
    for loss in (1e-3, 1e-6, 1e-9, 1e-12):
        e = 1.0 - loss
        assert damping_number(e) == pytest.approx(1.5 * (1.0 - e), rel=2.0 * loss + 1e-12)
    assert damping_number(1.0) == 0.0


@pytest.mark.parametrize("e", [0.9, 0.5, 0.2])
def test_hunt_crossley_impact_has_the_restitution_asked_for(e):
    damping = damping_for_restitution(e, 0.7)

    def load(approach, rate):
        return damped_load(COEFFICIENT * max(approach, 0.0) ** 1.5, 0.0, rate, damping, 0.0)

    assert rebound(load, 0.7) == pytest.approx(e, rel=1e-6)
    assert rebound(load, 2.1) == pytest.approx(restitution_of(3.0 * damping_number(e)), rel=1e-6)


@pytest.mark.parametrize("e", [0.9, 0.5, 0.1])
def test_steady_damping_has_its_restitution_at_every_speed(e):
    damping = steady_damping(e, COEFFICIENT, MASS)

    def load(approach, rate):
        return steady_damped_load(COEFFICIENT * max(approach, 0.0) ** 1.5, approach, rate, damping)

    assert [rebound(load, speed) for speed in (1e-3, 0.7, 50.0)] == pytest.approx([e] * 3, rel=1e-4)


@pytest.mark.parametrize("speed", [0.1, 3.0])
def test_a_relaxation_time_takes_what_its_power_adds_up_to(speed):
    """First order in the time: the loss 2 int tau k(h) v(h) dh along the elastic motion, by Euler's beta function."""
    relaxation = 1e-9
    deepest = (1.25 * MASS * speed**2 / COEFFICIENT) ** 0.4
    loss = 3.0 * COEFFICIENT * relaxation * speed * deepest**1.5 * 0.4 * beta(0.6, 1.5)

    def load(approach, rate):
        depth = max(approach, 0.0)
        stiffness = 1.5 * COEFFICIENT * math.sqrt(depth)
        return damped_load(COEFFICIENT * depth**1.5, stiffness, rate, 0.0, relaxation)

    assert 1.0 - rebound(load, speed) == pytest.approx(loss / (MASS * speed**2), rel=1e-2)
    assert loss / (MASS * speed**2) > 1e-5
    assert damped_load(10.0, 5e6, 0.2, 0.3, 1e-6) == pytest.approx(10.0 + (0.3 * 10.0 + 5.0) * 0.2, rel=1e-14)


def test_steady_restitution_is_smooth_through_the_critical_ratio():
    ratios = 1.0 + np.linspace(-3e-6, 3e-6, 13)
    assert [steady_restitution(z) for z in ratios] == pytest.approx(
        np.exp(-2.0 - 4.0 / 3.0 * (ratios - 1.0)), rel=1e-10
    )


def test_usual_shortcuts_miss_a_restitution_of_one_half():
    found = {name: shortcut.restitution for name, shortcut in shortcuts(0.5, 2.0).items()}
    expected = {"exact": 0.5, "hunt_crossley": 0.663, "lankarani_nikravesh": 0.725, "flores": 0.470}
    assert found == pytest.approx(expected, abs=6e-4)
    assert all(abs(shortcut.restitution - 0.99) < 0.004 for shortcut in shortcuts(0.99, 2.0).values())


def test_both_terms_vanish_at_onset_and_never_pull():
    """Paper 1, section 5: d(h) -> 0 with h."""
    for approach, bound in ((1e-6, 1.0), (1e-10, 1e-1), (1e-14, 1e-2)):
        assert 0.0 < steady_damped_load(0.0, approach, 1.0, 30.0) < bound
    assert steady_damped_load(1.0, 0.0, 1.0, 30.0) == 0.0
    assert steady_damped_load(1.0, 1e-6, -1e3, 30.0) == 0.0
    assert steady_damped_load.py_func(1.0, 1e-6, 0.1, 30.0) == steady_damped_load(1.0, 1e-6, 0.1, 30.0)


@pytest.mark.parametrize("e", [0.0, -0.1, 1.1, math.nan])
def test_impossible_restitutions_are_refused(e):
    for make in (damping_number, lambda one: shortcuts(one, 1.0), lambda one: steady_damping(one, 1.0, 1.0)):
        with pytest.raises(SceneError, match="above 0 and at most 1"):
            make(e)


def test_impossible_speeds_and_masses_are_refused():
    with pytest.raises(SceneError, match="speed"):
        damping_for_restitution(0.5, 0.0)
    with pytest.raises(SceneError, match="mass"):
        steady_damping(0.5, 1.0, -1.0)
    with pytest.raises(SceneError, match="zero or above"):
        restitution_of(-1.0)
