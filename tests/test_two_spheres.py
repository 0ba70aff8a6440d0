"""Two spheres: closed forms, differential equation, restitution, and what fixed steps and blind integrators do."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference.impact import power_load, strike
from scipy.integrate import solve_ivp
from solved_impact import SolvedImpact

from bearing_twin.contact import hertz_impact as impact
from bearing_twin.contact.damping import damping_for_restitution
from bearing_twin.errors import IntegrationError, SceneError
from bearing_twin.kinds.impact.collision import collide
from bearing_twin.kinds.impact.spheres import solve
from bearing_twin.kinds.impact.spring import NO_LINE, Spring
from bearing_twin.run.scene import load_scene

MASS = 0.1129  # reduced, of the two spheres of paper 3
STEEL = 4.0 / 3.0 * 2.1e11 / (2.0 * 0.91) * math.sqrt(0.01905 / 2.0)
SPEEDS = st.floats(1e-3, 50.0)


def solved(*overrides, stepper="closed_form"):
    return SolvedImpact(solve, load_scene("two_spheres", overrides), "hertz", stepper)


def test_contact_constant_and_invariant():
    """The 2.94 of paper 3, eq. (2), and F_peak tau / (mu v)."""
    assert pytest.approx(2.943275184324705, rel=1e-14) == impact.CONTACT_CONSTANT
    assert pytest.approx(3.67909398, rel=1e-8) == impact.FORCE_TIME_INVARIANT


def test_the_spheres_of_paper_3():
    """Eqs. (1) and (2) with the printed steel data."""
    assert impact.alpha(STEEL, MASS) == pytest.approx(1.143048864e-4, rel=1e-9)
    found = solved()
    assert found.contacts[0].duration == pytest.approx(6.278541908e-5, rel=1e-9)
    assert found.peak_force == pytest.approx(132314.068, rel=1e-8)
    assert found.greatest_approach == pytest.approx(4.26636418e-4, rel=1e-8)
    assert solved("motion.first_velocity=0.1").peak_force == pytest.approx(229.28, rel=1e-4)


def test_a_measured_alpha_takes_the_place_of_the_materials():
    found = solved("contact.measured_alpha=1.138e-4")
    assert found.contacts[0].duration == pytest.approx(6.250809491e-5, rel=1e-9)
    assert found.peak_force == pytest.approx(132901.094, rel=1e-8)
    assert impact.alpha(impact.coefficient_of_alpha(1.138e-4, MASS), MASS) == pytest.approx(1.138e-4, rel=1e-14)


@settings(deadline=None)
@given(SPEEDS, st.floats(1e-4, 10.0), st.floats(1e6, 1e12))
def test_invariants_hold_for_any_bodies(speed, mass, coefficient):
    """F_peak tau = 3.679 mu v; tau v^(1/5) = alpha."""
    bodies = coefficient, mass, speed
    product = impact.peak_force(*bodies) * impact.contact_time(*bodies)
    assert product == pytest.approx(impact.FORCE_TIME_INVARIANT * mass * speed, rel=1e-12)
    assert impact.contact_time(*bodies) * speed**0.2 == pytest.approx(impact.alpha(coefficient, mass), rel=1e-12)


def strikes(found, truth, rel=1e-8):
    """Whether a solved impact is one that was followed by another program: figures and history."""
    assert found.contacts[0].duration == pytest.approx(truth.duration, rel=rel)
    assert found.peak_force == pytest.approx(truth.peak_force, rel=rel)
    assert found.greatest_approach == pytest.approx(truth.greatest_approach, rel=rel)
    assert found.restitution == pytest.approx(truth.restitution, rel=rel)
    inside = found.time < truth.duration
    exact = truth.approach(found.time[inside])
    assert inside.sum() > 100
    assert found.approach[inside] == pytest.approx(exact, abs=3e-7 * truth.greatest_approach)
    assert np.all(found.force[~inside] == 0.0)


@pytest.mark.parametrize("speed", [0.01, 1.0, 20.0])
def test_closed_form_and_histories_against_the_motion_followed(speed):
    scale = 4.3e-4 * (speed / 20.0) ** 0.8
    strikes(solved(f"motion.first_velocity={speed}"), strike(power_load(STEEL), MASS, speed, scale))


@pytest.mark.parametrize(("restitution", "number"), [(0.9, 0.16648), (0.5, 1.43275)])
def test_damped_impacts_against_the_motion_followed(restitution, number):
    """Published chi v; the quadrature over the rates, its peak and both halves of its history."""
    found = solved(f"contact.restitution={restitution}", "motion.first_velocity=3.0")
    damping = damping_for_restitution(restitution, 3.0)
    assert damping * 3.0 == pytest.approx(number, abs=6e-6)
    strikes(found, strike(power_load(STEEL, damping), MASS, 3.0, 9e-5))


def test_the_history_carries_the_impulse_and_obeys_newton():
    """Paper 3, eq. (13): mu x'' = -c x^1.5, by central differences; the integral of the force is 2 mu v."""
    tau = impact.contact_time(STEEL, MASS, 20.0)
    times = np.linspace(0.0, tau, 4001)
    force = impact.force_history(times, STEEL, MASS, 20.0)
    assert np.trapezoid(force, times) == pytest.approx(2.0 * MASS * 20.0, rel=1e-6)
    assert force.max() == pytest.approx(132314.068, rel=1e-8)
    x = impact.approach_history(times, STEEL, MASS, 20.0)
    second = np.diff(x, 2) / (times[1] - times[0]) ** 2
    assert second[100:-100] == pytest.approx(-force[101:-101] / MASS, rel=1e-4)


def test_a_million_impacts_at_once():
    speeds = np.linspace(0.1, 50.0, 1_000_000)
    times = impact.contact_time(STEEL, MASS, speeds)
    assert times.shape == impact.peak_force(STEEL, MASS, speeds).shape == speeds.shape
    assert times[[0, -1]] == pytest.approx([1.143048864e-4 * v**-0.2 for v in (0.1, 50.0)], rel=1e-9)


def test_the_differential_equation_gives_the_closed_form():
    exact, found = solved(), solved("wanted.tolerance=1e-12", stepper="dop853")
    assert found.contacts[0].duration == pytest.approx(exact.contacts[0].duration, rel=1e-9)
    for name in ("peak_force", "greatest_approach", "restitution"):
        assert getattr(found, name) == pytest.approx(getattr(exact, name), rel=1e-10)
    assert found.force == pytest.approx(exact.force, abs=1e-9 * exact.peak_force)
    assert found.values["velocity"] == pytest.approx(exact.values["velocity"], abs=1e-8)


@pytest.mark.parametrize(("restitution", "product"), [(0.9, 0.16648), (0.7, 0.63483), (0.5, 1.43275)])
def test_damping_gives_exactly_the_restitution_asked_for(restitution, product):
    """chi v (1 + e) = ln[(1 + chi v) / (1 - e chi v)]; usual shortcuts give 0.47 to 0.73 for 0.5."""
    assert damping_for_restitution(restitution, 20.0) * 20.0 == pytest.approx(product, abs=6e-6)
    by_quadrature = solved(f"contact.restitution={restitution}")
    by_equation = solved(f"contact.restitution={restitution}", "wanted.tolerance=1e-12", stepper="dop853")
    for found in (by_quadrature, by_equation):
        assert found.restitution == pytest.approx(restitution, rel=1e-9)
        assert abs(found.energy_closure) < 1e-9
    assert by_quadrature.contacts[0].duration == pytest.approx(by_equation.contacts[0].duration, rel=1e-9)
    assert by_quadrature.peak_force == pytest.approx(by_equation.peak_force, rel=1e-8)
    assert by_quadrature.force == pytest.approx(by_equation.force, abs=1e-6 * by_equation.peak_force)


@pytest.mark.parametrize("restitution", [0.9, 0.5])
def test_steady_damping_keeps_its_restitution_at_every_speed(restitution):
    """Which the other law does only at one; energy closes with what is left in the contact when the bodies part."""
    steady = f"contact.restitution={restitution}", "contact.damping_law=steady"
    for speed in (0.02, 20.0):
        found = solved(*steady, f"motion.first_velocity={speed}", stepper="dop853")
        assert found.restitution == pytest.approx(restitution, rel=1e-6)
        assert abs(found.energy_closure) < 1e-6
    values = found.values
    assert values["velocity"][-1, 1] - values["velocity"][-1, 0] == pytest.approx(restitution * 20.0, rel=1e-6)
    after = found.time > found.contacts[0].duration
    assert np.all(values["normal_load"][after] == 0.0)
    assert np.abs(np.diff(values["approach"])).max() < 1.1 * 20.0 * (found.time[1] - found.time[0])  # no jump
    assert found.force.min() >= 0.0
    impulse = np.trapezoid(found.force, found.time)
    assert impulse == pytest.approx(found.contacts[0].impulse, rel=1e-3)


@settings(max_examples=30, deadline=None)
@given(st.floats(0.1, 5.0), st.floats(-3.0, 3.0), st.floats(0.1, 10.0), st.sampled_from([1.0, 0.8]))
def test_momentum_is_kept_and_velocities_part_as_restitution_says(heavier, second, speed, restitution):
    overrides = (
        f"second.mass={heavier}", f"motion.first_velocity={second + speed}", f"motion.second_velocity={second}",
        f"contact.restitution={restitution}",
    )  # fmt: skip
    found = solved(*overrides)
    velocity, masses = found.values["velocity"], np.array([0.2258, heavier])
    momentum = velocity @ masses
    assert momentum == pytest.approx(momentum[0], abs=1e-9 * np.abs(masses * velocity[0]).sum())
    assert velocity[-1, 1] - velocity[-1, 0] == pytest.approx(restitution * speed, rel=1e-8)


def test_energy_is_kept_through_the_contact():
    found = solved("wanted.tolerance=1e-11", stepper="dop853")
    total = found.values["kinetic_energy"] + found.values["elastic_energy"]
    assert total == pytest.approx(0.5 * MASS * 400.0, rel=1e-8)


def test_spheres_a_metre_apart_do_not_pass_through_each_other():
    """Adaptive integrators step over the contact and report success; free flight here is exact."""
    diameter = 0.0381

    def right_hand_side(_, y):
        """Distance of the centres and its rate; the spheres repel where they overlap."""
        return [y[1], math.copysign(STEEL * max(diameter - abs(y[0]), 0.0) ** 1.5 / MASS, y[0])]

    passed = 0
    for method in ("RK45", "DOP853", "Radau", "BDF", "LSODA"):
        for tolerance in (1e-3, 1e-6, 1e-9):
            blind = solve_ivp(right_hand_side, (0.0, 0.1), [1.0 + diameter, -20.0], method, rtol=tolerance)
            assert blind.success
            passed += blind.y[0, -1] < -diameter
    assert passed >= 12
    found = solved("motion.gap=1.0")
    assert found.contacts[0].start == pytest.approx(0.05, rel=1e-12)
    assert found.contacts[0].duration == pytest.approx(6.278541908e-5, rel=1e-9)


def test_a_step_beyond_an_eighth_of_the_contact_is_refused_and_a_coarse_one_is_warned_of():
    from bearing_twin.run.fidelity import choose

    with pytest.raises(SceneError, match="at least 8 steps; use"):
        load_scene("two_spheres", ["solver.stepper=rk4", "solver.step=1.0e-5"])
    with pytest.raises(SceneError, match="at most 100000 steps; use"):  # which would be terabytes
        load_scene("two_discs", ["solver.stepper=rk4", "solver.step=1.0e-13"])
    coarse = load_scene("two_spheres", ["solver.stepper=symplectic_euler", "solver.step=6.0e-6"])
    assert "16 steps a contact" in choose(coarse).warnings[0]
    assert choose(load_scene("two_spheres", ["solver.stepper=rk4"])).warnings == ()


@pytest.mark.parametrize(("stepper", "order"), [("rk4", 2.0), ("symplectic_euler", 1.0)])
def test_fixed_steps_converge(stepper, order):
    exact, errors = solved().contacts[0].duration, []
    for count in (50, 800):
        step = exact / count
        errors.append(abs(solved(f"solver.step={step!r}", stepper=stepper).contacts[0].duration / exact - 1.0))
    assert math.log(errors[0] / errors[1]) / math.log(16.0) > order - 0.1


def test_numbers_that_are_not_finite_stop_the_run():
    """LSODA returns success with NaN; here one sentence says what happened."""
    blind = solve_ivp(lambda t, y: [y[1], math.nan if t > 5e-5 else 0.0], (0.0, 1e-4), [0.0, 20.0], "LSODA")
    assert blind.success
    assert np.isnan(blind.y).any()
    for method in ("dop853", "rk4"):
        with pytest.raises(IntegrationError, match="not finite"):
            collide(Spring(math.nan, NO_LINE, 0.0), MASS, 20.0, method, 1e-9, 1e-6, 6e-5)


@pytest.mark.parametrize(
    ("override", "sentence"),
    [
        ("motion.first_velocity=0", "never meet"),
        ("motion.first_velocity=-3.0", "never meet"),
        ("motion.second_velocity=20.0", "never meet"),
        ("first.radius=0", "first.radius = 0 is out of range"),
        ("first.material.poisson_ratio=0.5", "below 0.5"),
        ("contact.restitution=0", "above 0"),
        ("contact.restitution=1.2", "at most 1"),
        ("motion.gap=-1e-3", "at least 0"),
        ("solver.stepper=euler", "did you mean symplectic_euler|legal"),
        ("motion.velocity=3", "is not a key"),
    ],
)
def test_bad_input_gets_a_sentence(override, sentence):
    with pytest.raises(SceneError, match=sentence):
        load_scene("two_spheres", [override])
