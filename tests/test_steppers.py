"""Every stepper on the bearing: observed order in load and friction torque, references, refusals."""

import numpy as np
import pytest
from bearings import TURNED_REST, motion, run
from scipy.integrate import solve_ivp
from scipy.linalg import lu_factor, lu_solve

from bearing_twin.errors import IntegrationError, SceneError
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.stepping.step_limits import stability_limits
from bearing_twin.numerics.steppers import (
    EXPLICIT,
    ROSENBROCK,
    STEPPER_FACTS,
    rosenbrock_dense,
)
from bearing_twin.parameters import describe


def errors_against(reference, out):
    """Relative error of normal load and of friction torque, greatest over balls and instants."""
    load = np.abs(out.normal_load - reference.normal_load).max() / reference.normal_load.max()
    torque = np.abs(out.raceway_torque - reference.raceway_torque).max() / np.abs(reference.raceway_torque).max()
    return np.array([load, torque])


@pytest.mark.parametrize(("stepper", "coarsest"), [("rk4", 1.2e-6), ("imex", 6e-7)])
def test_load_and_friction_torque_converge_with_the_order_of_fixed_steps(stepper, coarsest):
    """Judged inside the transient, where both are far from settled; the reference has a far finer step."""
    smooth = (*TURNED_REST, "contact.friction_regularisation=0.3")

    def outputs(step):
        return run(*smooth, f"solver.step={step}", stepper=stepper, count=8, period=1.2e-5)[1]

    reference = run(*smooth, "solver.step=2e-8", stepper="rk4", count=8, period=1.2e-5)[1]
    errors = np.array([errors_against(reference, outputs(step)) for step in (coarsest, 0.5 * coarsest)])
    orders = np.log2(errors[:-1] / errors[1:])
    assert orders == pytest.approx(STEPPER_FACTS[stepper].order, abs=0.15)


@pytest.mark.parametrize("name", ROSENBROCK)
def test_rosenbrock_methods_have_their_order_on_a_stiff_problem_with_a_known_solution(name):
    """y1' = -5 (y1 - cos t) - sin t and y2' = y1 - y2 in the method's own transformed form, constant steps."""
    from math import cos, exp, sin

    method = ROSENBROCK[name]
    stages = len(method.alpha)

    def rates(t, y):
        return np.array([-5.0 * (y[0] - cos(t)) - sin(t), y[0] - y[1]])

    jacobian = np.array([[-5.0, 0.0], [1.0, -1.0]])

    def slope(t):
        return np.array([-5.0 * sin(t) - cos(t), 0.0])

    def exact(t):
        return np.array([cos(t), 0.5 * (cos(t) + sin(t)) + 0.5 * exp(-t)])

    def step(t, y, h):
        k = np.zeros((stages, 2))
        factors = lu_factor(np.eye(2) / (h * method.gamma) - jacobian)
        for stage in range(stages):
            trial = y + method.a[stage, :stage] @ k[:stage]
            right = rates(t + method.alpha[stage] * h, trial) + method.c[stage, :stage] @ k[:stage] / h
            k[stage] = lu_solve(factors, right + h * method.d[stage] * slope(t))
        return trial + k[-1], k

    def end(steps):
        y, h = np.array([1.0, 1.0]), 2.0 / steps
        for i in range(steps):
            y, _ = step(i * h, y, h)
        return y

    def inside(h):
        """Greatest error of the interpolant over one step from the exact solution."""
        y = exact(0.4)
        new, k = step(0.4, y, h)
        columns = min(stages, method.dense.shape[1])
        third, fourth = method.dense[:, :columns] @ k[:columns]
        fractions = np.linspace(0.1, 0.9, 9)
        return max(np.abs(rosenbrock_dense(f, y, new, third, fourth) - exact(0.4 + f * h)).max() for f in fractions)

    errors = np.array([np.abs(end(steps) - exact(2.0)).max() for steps in (80, 160, 320)])
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx(method.order, abs=0.15)
    # An interpolant of order p errs by h^(p + 1) over one step.
    assert np.log2(inside(0.02) / inside(0.01)) > method.order - 0.15


@pytest.mark.parametrize("name", EXPLICIT)
def test_explicit_methods_have_their_order_on_a_pendulum(name):
    """Against SciPy at its tightest; an embedded estimate must be of a lower order than the method."""
    method = EXPLICIT[name]
    stages = len(method.nodes)

    def rates(y):
        return np.array([y[1], -np.sin(y[0])])

    def step(y, h):
        k = np.zeros((stages + 1, 2))
        for stage in range(stages):
            k[stage] = rates(y + h * method.a[stage, :stage] @ k[:stage])
        new = y + h * method.weights @ k[:stages]
        k[stages] = rates(new)
        return new, h * method.error @ k

    def end(steps):
        y = np.array([1.0, 0.5])
        for _ in range(steps):
            y, _ = step(y, 4.0 / steps)
        return y

    exact = solve_ivp(lambda _, y: rates(y), (0.0, 4.0), [1.0, 0.5], method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    errors = np.array([np.abs(end(steps) - exact).max() for steps in (20, 40, 80)])
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx(method.order, abs=0.4)
    assert method.a.sum(axis=1) == pytest.approx(method.nodes, abs=1e-14)
    if np.any(method.error):
        estimates = [np.abs(step(np.array([1.0, 0.5]), h)[1]).max() for h in (0.2, 0.1)]
        assert np.log2(estimates[0] / estimates[1]) == pytest.approx(method.order, abs=0.3)


@pytest.fixture(scope="module")
def reference():
    """The start from rest by SciPy's Radau, far tighter than any contestant."""
    return run(*TURNED_REST, stepper="radau")[1]


@pytest.mark.parametrize("stepper", ["rodas4", "rodas3", "imex", "rk4", "dopri5", "dop853"])
def test_steppers_agree_with_radau_inside_the_transient(reference, stepper):
    """Load and friction torque within the wanted 1e-3, from rest through sliding and ringing."""
    tight = ("wanted.tolerance=1e-5",) if stepper == "dopri5" else ()
    out = run(*TURNED_REST, *tight, stepper=stepper)[1]
    assert np.all(errors_against(reference, out) < 1e-3)
    assert out.orientation == pytest.approx(reference.orientation, abs=1e-6)


def test_a_tighter_tolerance_is_more_accurate_and_dearer(reference):
    runs = [run(*TURNED_REST, f"wanted.tolerance={tolerance}") for tolerance in (1e-2, 1e-4, 1e-5)]
    errors = np.array([errors_against(reference, out).max() for _, out in runs])
    steps = [moving.costs()["ball_steps"] for moving, _ in runs]
    assert np.all(np.diff(errors) < 0.0)
    assert np.all(np.diff(steps) > 0)


def test_dense_output_is_as_good_as_the_steps():
    """Asking for ten times as many instants changes neither the steps nor the values at the common instants."""
    few_motion, few = run(*TURNED_REST, count=10, period=1e-4)
    many_motion, many = run(*TURNED_REST, count=100, period=1e-5)
    assert few_motion.costs() == many_motion.costs()
    assert many.normal_load[9::10] == pytest.approx(few.normal_load, rel=1e-9, abs=1e-9)


def test_no_fixed_step_serves_a_tiny_regularisation_but_rodas4_does():
    tiny = ("contact.friction_regularisation=1e-4",)
    with pytest.raises(SceneError, match="friction answers at"):
        motion(*tiny, "solver.step=2e-7", stepper="rk4")
    moving, out = run(*tiny, count=10, period=1e-3)
    assert moving.costs()["ball_steps"] < 8 * 400
    finer = run(*tiny, "wanted.tolerance=1e-5", count=10, period=1e-3)[1]
    assert np.all(errors_against(finer, out)[0] < 1e-3)


@pytest.mark.parametrize("stepper", ["rk4", "imex"])
def test_a_step_is_refused_where_balls_that_ring_between_their_contacts_would_grow(stepper):
    without = "contact.friction_coefficient=0.0"
    longest = min(stability_limits(motion(without, stepper=stepper).rates, stepper))
    assert motion(without, f"solver.step={0.99 * longest}", stepper=stepper).step == 0.99 * longest
    with pytest.raises(SceneError, match="rings between its contacts"):
        motion(without, f"solver.step={1.01 * longest}", stepper=stepper)


def test_a_fixed_step_follows_a_jump_of_the_ring():
    """Chosen: shorter from then on, and again as at the start after a reset. Given: refused at the time of the jump."""
    jump = ("drive.change.time=1e-4", "drive.change.offset=[0.0,-4e-5,0.0]")
    moving = motion(*jump, stepper="rk4")
    chosen = moving.step
    moving.advance(np.array([2e-4]), 2e-4)
    assert moving.step < 0.1 * chosen
    moving.reset()
    assert moving.step == chosen
    with pytest.raises(IntegrationError, match="friction answers at") as caught:
        motion(*jump, f"solver.step={chosen}", stepper="rk4").advance(np.array([2e-4]), 2e-4)
    assert caught.value.seconds == pytest.approx(1e-4)


def test_explicit_steps_past_stability_end_in_an_error_and_not_in_numbers():
    """Past the refusals a stepper must notice by itself: not a number, or a ball through a raceway."""
    moving = motion("contact.friction_coefficient=0.0", stepper="rk4")
    moving.step = 2e-5
    with pytest.raises(IntegrationError, match=r"ball \d"):
        moving.advance(np.array([0.2]), 0.2)


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("stepper", ["rodas4", "imex", "rk4", "dopri5"])
def test_a_state_that_is_not_finite_is_an_error_with_the_ball(stepper, value):
    moving = motion(stepper=stepper)
    moving.state[3, 4] = value
    with pytest.raises(IntegrationError, match="ball 3"):
        moving.advance(np.array([1e-3]), 1e-3)


def test_every_method_says_where_it_comes_from_and_can_be_asked_for():
    assert all(len(method.source) > 10 and method.order >= 2 for method in STEPPER_FACTS.values())
    options = next(row.options for row in describe(BearingScene) if row.key == "solver.stepper")
    assert options == ("auto", *STEPPER_FACTS)
