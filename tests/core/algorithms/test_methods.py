"""Methods of integration: orders on known solutions and on the bearing, derivatives against differences, refusals."""

import math
import subprocess
import sys

import numpy as np
import pytest
from bearings import TURNED_REST, motion, run, stored_energy
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from bearing_twin.base.errors import IntegrationError, SceneError
from bearing_twin.coefficients import EXPLICIT, ROSENBROCK
from bearing_twin.kinds.bearing.integrate import stability_limits
from bearing_twin.kinds.bearing.system import MOTION, VELOCITY
from bearing_twin.methods import COUPLED, STEPPER_FACTS
from bearing_twin.shapes import (
    quaternion_from_vector,
    quaternion_product,
    rotation_matrix,
)


def errors_against(reference, out):
    """Relative error of normal load and of friction torque, greatest over balls and instants."""
    load = np.abs(out.normal_load - reference.normal_load).max() / reference.normal_load.max()
    torque = np.abs(out.raceway_torque - reference.raceway_torque).max() / np.abs(reference.raceway_torque).max()
    return np.array([load, torque])


@pytest.mark.parametrize("name", ROSENBROCK)
def test_within_a_step_a_rosenbrock_method_has_its_order(name):
    """Its interpolant over one step of y' = -5 (y - cos t) - sin t from the solution, which is cos t."""
    method, t, fractions = ROSENBROCK[name], 0.4, np.linspace(0.1, 0.9, 9)
    stages = len(method.alpha)

    def error(h):
        k = np.zeros(stages)
        for i in range(stages):
            y, now = math.cos(t) + method.a[i, :i] @ k[:i], t + method.alpha[i] * h
            right = -5.0 * (y - math.cos(now)) - math.sin(now) + method.c[i, :i] @ k[:i] / h
            k[i] = (right - h * method.d[i] * (5.0 * math.sin(t) + math.cos(t))) / (1.0 / (h * method.gamma) + 5.0)
        columns = min(stages, method.dense.shape[1])
        third, fourth = method.dense[:, :columns] @ k[:columns]
        inside = y + k[-1] + (1.0 - fractions) * (third + fractions * fourth)
        return np.abs((1.0 - fractions) * math.cos(t) + fractions * inside - np.cos(t + fractions * h)).max()

    assert math.log2(error(0.02) / error(0.01)) > method.order - 0.15


@pytest.fixture(scope="module")
def reference():
    """The start from rest by SciPy's Radau, far tighter than any contestant."""
    return run(*TURNED_REST, stepper="radau")[1]


@pytest.mark.parametrize("stepper", [name for name in STEPPER_FACTS if name not in ("rodas4_landing", "radau")])
def test_steppers_agree_with_radau_inside_the_transient(reference, stepper):
    """Load and friction torque within the wanted 1e-3, from rest through sliding and ringing."""
    tight = ("wanted.tolerance=1e-5",) if stepper in EXPLICIT else ()
    out = run(*TURNED_REST, *tight, stepper=stepper)[1]
    assert np.all(errors_against(reference, out) < 1e-3)
    assert out.orientation == pytest.approx(reference.orientation, abs=1e-6)


def test_dense_output_is_as_good_as_the_steps():
    """Asking for ten times as many instants changes neither the steps nor the values at the common instants."""
    few_motion, few = run(*TURNED_REST, count=10, period=1e-4)
    many_motion, many = run(*TURNED_REST, count=100, period=1e-5)
    assert few_motion.costs() == many_motion.costs()
    assert many.normal_load[9::10] == pytest.approx(few.normal_load, rel=1e-9, abs=1e-9)


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


@pytest.mark.parametrize(
    ("stepper", "value"),
    [("rodas4", 1e200), ("imex", np.inf), ("rk4", np.nan)],
)
def test_a_state_that_is_no_number_or_too_great_names_its_ball(stepper, value):
    moving = motion(stepper=stepper)
    moving.state[3, 4] = value
    with pytest.raises(IntegrationError, match="ball 3 is not finite") as caught:
        moving.advance(np.array([1e-3]), 1e-3)
    assert (caught.value.reason, caught.value.body) == ("not finite", "ball 3")


def test_every_rosenbrock_method_that_does_not_land_moves_a_ring_and_a_cage():
    assert set(COUPLED) == {name for name, method in ROSENBROCK.items() if not method.lands}


@pytest.mark.parametrize("stepper", ["dopri5", "dop853"])
def test_explicit_error_control_gets_the_load_right_and_the_friction_torque_wrong_in_silence(stepper):
    """Settled rolling: its steps ride on the stability limit, so slip rattles; not so rodas4 at the same tolerance."""
    reference = run("wanted.tolerance=1e-6", count=2, period=1e-3)[1]
    load, torque = errors_against(reference, run("wanted.tolerance=1e-1", stepper=stepper, count=2, period=1e-3)[1])
    assert load < 1e-3
    assert torque > 1e-2
    load, torque = errors_against(reference, run("wanted.tolerance=1e-1", count=2, period=1e-3)[1])
    assert max(load, torque) < 5e-3


def test_imex_rings_where_slip_ought_to_die_within_a_step():
    """Friction of a tenth of a millimetre per second, from rest.

    The step that is chosen ends the slip, longer ones turn it to and fro for ever, in silence, and are refused.
    """
    tiny = (*TURNED_REST, "contact.friction_regularisation=1e-4")
    reference = run(*tiny, "wanted.tolerance=1e-5", count=4, period=1e-3)[1]
    moving = motion(*tiny, stepper="imex")
    assert max(errors_against(reference, moving.advance(1e-3 * np.arange(1, 5), 4e-3))) < 1e-2
    moving.reset()
    moving.step = 7e-7
    load, torque = errors_against(reference, moving.advance(1e-3 * np.arange(1, 5), 4e-3))
    assert load < 1e-2
    assert torque > 1e-2
    with pytest.raises(SceneError, match="friction answers at"):
        motion(*tiny, "solver.step=7e-7", stepper="imex")


@pytest.mark.parametrize("speed", [0.1, 3.0])
def test_a_raceway_cannot_be_stepped_over_from_free_flight(speed):
    """Balls thrown across a clearance of 0.1 mm: flight invites long steps, but behind a groove there is no way out."""
    moving = motion(
        "cage.kind=none",
        "geometry.radial_clearance=2e-4",
        "gravity=[0,0,0]",
        "drive.speed=0.0",
        "contact.relaxation_time=0.0",
    )
    moving.state[:, VELOCITY] = speed
    moving.steps[:] = 1e-3
    start = stored_energy(moving.first_outputs())[0]
    period = 0.1e-3 / speed / 20.0
    out = moving.advance(period * np.arange(1, 101), 100 * period)
    assert np.any(out.velocity[:, 0, 0] < -0.5 * speed)
    assert out.approach.max() < 0.05 * moving.bearing.ball_radius
    assert stored_energy(out)[-1] + out.dissipated[-1] == pytest.approx(start, rel=1e-3)


@pytest.mark.parametrize(
    ("stepper", "change", "reasons"),
    [("rk4", {"step": 2e-5}, ("too deep", "not finite")), ("rodas4", {"scales": np.full(MOTION, 1e-30)}, ("stalled",))],
)
def test_a_failure_says_why_when_and_which_ball(stepper, change, reasons):
    moving = motion("contact.friction_coefficient=0.0", stepper=stepper)
    moving.advance(np.array([1e-3]), 1e-3)
    for name, value in change.items():
        setattr(moving, name, value)
    with pytest.raises(IntegrationError, match=r"ball \d") as caught:
        moving.advance(np.array([0.2]), 0.2)
    assert caught.value.reason in reasons
    assert 1e-3 <= caught.value.seconds <= 0.2
    assert caught.value.body.startswith("ball ")


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
    result = after(start, overrides, stepper, step)
    return np.array([np.abs(result[name] - exact[name]).max() / np.abs(exact[name]).max() for name in exact])


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


STEPS = dict.fromkeys(ROSENBROCK, 2e-6) | dict.fromkeys((*EXPLICIT, "imex"), 1e-6)  # s


def orders(case, overrides, stepper, step):
    """Observed order of velocity, slip, friction torque and normal load between `step` [s] and half of it."""
    start, exact = case
    coarse, fine = (errors(start, overrides, stepper, h, exact) for h in (step, 0.5 * step))
    assert np.all(coarse < 1e-3)
    return np.log2(coarse / fine)


@pytest.mark.parametrize("stepper", STEPS)
def test_ringing_balls_have_the_order_of_their_method(rolling, stepper):
    assert orders(rolling[1], (), stepper, STEPS[stepper]) == pytest.approx(STEPPER_FACTS[stepper].order, abs=0.5)


@pytest.mark.parametrize("stepper", COUPLED)
def test_balls_at_ease_follow_the_ring_with_the_order_of_their_method(rolling, stepper):
    """What is left of the errors, down to 1e-9, comes from the ring's speed: from the explicit time term above all."""
    assert orders(rolling[0], (), stepper, STEPS[stepper]) == pytest.approx(STEPPER_FACTS[stepper].order, abs=0.5)


@pytest.mark.parametrize("stepper", [name for name in STEPS if name != "rodas4_landing"])
def test_touching_balls_have_the_order_of_their_method(pressed, stepper):
    assert orders(pressed[1], FULL, stepper, STEPS[stepper]) == pytest.approx(STEPPER_FACTS[stepper].order, abs=0.5)


VECTOR = st.tuples(*[st.floats(-5.0, 5.0)] * 3)


@given(VECTOR, VECTOR)
def test_products_agree_with_scipy(a, b):
    p, q = Rotation.from_rotvec(a), Rotation.from_rotvec(b)
    mine = quaternion_product(quaternion_from_vector(a), quaternion_from_vector(b))
    assert rotation_matrix(mine) == pytest.approx((p * q).as_matrix(), abs=1e-12)


HEUN = """
import numpy as np
from bearing_twin import coefficients, methods
slopes = coefficients._lower((), (1 / 3,), (0, 2 / 3))
heun = coefficients.RungeKutta(slopes, np.array([0, 1 / 3, 2 / 3]), np.array([0.25, 0, 0.75]), np.zeros(4), order=3)
coefficients.EXPLICIT["heun"] = heun
methods.STEPPER_FACTS["heun"] = methods.StepperFacts(3, False, "nothing implicitly", "Heun 1900")
from bearing_twin.command.cli import main
raise SystemExit(main("simulate bearing_6203 --duration 1e-3 --set solver.stepper=heun --json".split()))
"""


def test_a_further_method_of_fixed_step_runs():
    """It was taken for one that estimates its error, and made ever longer steps without end."""
    subprocess.run([sys.executable, "-c", HEUN], check=True, timeout=60, stdout=subprocess.DEVNULL)
