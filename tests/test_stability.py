"""Where steppers of the bearing fail, shown by provoking it, and what the software does about it."""

import numpy as np
import pytest
from bearings import TURNED_REST, motion, run, stored_energy

from bearing_twin.base.errors import IntegrationError, SceneError
from bearing_twin.kinds.bearing import MOTION, VELOCITY


def errors_of(reference, out):
    """Relative error of normal load and of friction torque, greatest over balls and instants."""
    return tuple(
        np.abs(getattr(out, name) - getattr(reference, name)).max() / np.abs(getattr(reference, name)).max()
        for name in ("normal_load", "raceway_torque")
    )


@pytest.mark.parametrize("stepper", ["dopri5", "dop853"])
def test_explicit_error_control_gets_the_load_right_and_the_friction_torque_wrong_in_silence(stepper):
    """Settled rolling: its steps ride on the stability limit, so slip rattles; not so rodas4 at the same tolerance."""
    reference = run("wanted.tolerance=1e-6", count=2, period=1e-3)[1]
    load, torque = errors_of(reference, run("wanted.tolerance=1e-1", stepper=stepper, count=2, period=1e-3)[1])
    assert load < 1e-3
    assert torque > 1e-2
    load, torque = errors_of(reference, run("wanted.tolerance=1e-1", count=2, period=1e-3)[1])
    assert max(load, torque) < 5e-3


def test_imex_rings_where_slip_ought_to_die_within_a_step():
    """Friction of a tenth of a millimetre per second, from rest.

    The step that is chosen ends the slip, longer ones turn it to and fro for ever, in silence, and are refused.
    """
    tiny = (*TURNED_REST, "contact.friction_regularisation=1e-4")
    reference = run(*tiny, "wanted.tolerance=1e-5", count=4, period=1e-3)[1]
    moving = motion(*tiny, stepper="imex")
    assert max(errors_of(reference, moving.advance(1e-3 * np.arange(1, 5), 4e-3))) < 1e-2
    moving.reset()
    moving.step = 7e-7
    load, torque = errors_of(reference, moving.advance(1e-3 * np.arange(1, 5), 4e-3))
    assert load < 1e-2
    assert torque > 1e-2
    with pytest.raises(SceneError, match="friction answers at"):
        motion(*tiny, "solver.step=7e-7", stepper="imex")


def test_imex_at_eight_microseconds_is_refused_and_would_fail():
    with pytest.raises(SceneError, match=r"use .* s or less"):
        motion(*TURNED_REST, "solver.step=8e-6", stepper="imex")
    moving = motion(*TURNED_REST, stepper="imex")
    good = moving.advance(np.array([2e-3]), 2e-3)
    moving.reset()
    moving.step = 8e-6
    try:
        load = errors_of(good, moving.advance(np.array([2e-3]), 2e-3))[0]
    except IntegrationError:
        load = np.inf
    assert load > 1e-2


def test_landing_on_the_instants_where_contacts_change_gives_the_same_answer():
    """Steps end at gap = 0; error control had found those instants before, so errors and steps change little."""
    reference = run("wanted.tolerance=1e-7", scene="bearing_6203_loose", count=10, period=1e-3)[1]
    plain, _ = run("wanted.tolerance=1e-4", scene="bearing_6203_loose", count=10, period=1e-3)
    landing, out = run(
        "wanted.tolerance=1e-4", scene="bearing_6203_loose", stepper="rodas4_landing", count=10, period=1e-3
    )
    assert max(errors_of(reference, out)) < 1e-2
    assert landing.costs() != plain.costs()
    assert landing.costs()["ball_steps"] < 1.5 * plain.costs()["ball_steps"]


def test_a_landing_step_ends_at_the_touch():
    """Balls in flight at 1 cm/s towards the outer raceway: one step more for each, which ends where its gap does."""
    still = (
        "cage.kind=none",
        "geometry.radial_clearance=2e-4",
        "gravity=[0,0,0]",
        "drive.speed=0.0",
        "drive.offset=[0,0,0]",
    )
    rejections = {}
    for stepper in ("rodas4", "rodas4_landing"):
        moving = motion(*still, stepper=stepper)
        moving.state[:, VELOCITY] = 0.01
        moving.steps[:] = 1e-5
        touch = -moving.first_outputs().approach[0, 0, 1] / 0.01
        out = moving.advance(touch + 1e-9 * np.array([-2.0, 2.0]), touch + 1e-7)
        assert out.approach[0, 0, 1] < 0.0 < out.approach[1, 0, 1]
        rejections[stepper] = moving.costs()["ball_rejections"]
    assert rejections["rodas4_landing"] >= rejections["rodas4"]


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
