"""Friction over the spots of a bearing: limits in closed form, balances with drilling, every stepper, and its cost."""

import math
import platform

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
from machine_code import machine_code
from numba import typeof
from reference.fit_hertz import fit
from scipy.special import ellipe

from bearing_twin.code_linking import needs_of
from bearing_twin.contact.ellipse import (
    AREA_DENOMINATOR,
    AREA_NUMERATOR,
    SHAPE_DENOMINATOR,
    SHAPE_NUMERATOR,
    curvature_ratio,
    ellipse,
    hertz_coefficient,
    semi_axes,
)
from bearing_twin.contact.spot_rules import FEW, RULES
from bearing_twin.kinds.bearing.forces.equations import ball_position, single_contact
from bearing_twin.kinds.bearing.forces.layout import JACOBIAN_END, LANE_ROWS, MOTION, ORBIT_ANGLE, SPIN, VELOCITY
from bearing_twin.kinds.bearing.forces.rates import lane_rates
from bearing_twin.kinds.bearing.forces.spot import add_answers, over_few_of_all, over_spots
from bearing_twin.kinds.bearing.forces.spot_jacobian import ROOM_ROWS, put_spot_slopes
from bearing_twin.kinds.bearing.forces.spot_slopes import add_points
from bearing_twin.kinds.bearing.outputs import contact_details
from bearing_twin.numerics.lanes import LANES
from bearing_twin.numerics.steppers import STEPPER_FACTS
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation

SPOT = "contact.friction=spot"
MIDDLE = (0.0, 0.0, 0.0)
AXIAL = ("gravity=[0.0, 0.0, 0.0]", "drive.offset=[0.0, 0.0, 2.0e-5]")


def test_the_fits_of_the_semi_axes_can_be_made_again():
    for form, committed in (
        ("AREA", (AREA_NUMERATOR, AREA_DENOMINATOR)),
        ("SHAPE", (SHAPE_NUMERATOR, SHAPE_DENOMINATOR)),
    ):
        *refit, error = fit(form)
        assert error < 2e-7
        for u in np.linspace(0.0, 0.9, 7):
            first, second = (np.polyval(n[::-1], u) / np.polyval(d[::-1], u) for n, d in (refit, committed))
            assert first == pytest.approx(second, rel=1e-6)


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


def test_forces_and_torques_on_the_rings_answer_those_on_the_balls():
    _, out = run(SPOT, *TURNED_REST, "drive.offset=[0.0, -1.0e-6, 2.0e-5]")
    forces = out.raceway_force.sum(axis=1) + out.inner_ring_force + out.outer_ring_force
    assert np.abs(forces).max() < 1e-11 * np.abs(out.raceway_force).max()
    torques = (
        (out.raceway_torque + np.cross(out.position, out.raceway_force)).sum(axis=1)
        + out.inner_ring_torque
        + np.cross(out.inner_ring_offset, out.inner_ring_force)
        + out.outer_ring_torque
    )
    drilling = (out.drilling_torque[..., None] * -out.normal).sum(axis=(1, 2))
    assert np.abs(drilling).max() > 1e-6
    assert np.abs(torques).max() < 1e-9 * np.abs(drilling).max()


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


def test_the_report_names_drilling_that_smoothing_hides_and_what_helps():
    """The torque of the drive more than doubles with the smoothing that the flag asks for, and then hardly changes."""
    torques, flags = [], []
    for smoothing in (1e-2, 1e-3, 1e-4):
        scene = load_scene("bearing_6203", [SPOT, *AXIAL, f"contact.friction_regularisation={smoothing}"])
        simulation = Simulation(scene)
        simulation.advance(51)
        report = simulation.report()
        assert "friction over the spot" in report.choice_reason
        torques.append(report.figures["drive_torque_nm"])
        flags.append([flag for flag in report.flags if "smooths" in flag])
    assert len(flags[0]) == 1
    assert "or less" in flags[0][0]
    assert flags[2] == []
    assert torques[1] > 2.0 * torques[0]
    assert torques[2] == pytest.approx(torques[1], rel=0.25)


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


def test_friction_at_a_point_neither_runs_nor_compiles_the_spots():
    lanes = np.ones(LANE_ROWS * LANES)
    called = {}
    for overrides in ((), (SPOT,)):
        bearing = motion(*overrides).bearing
        lane_rates(bearing, lanes)
        form = lane_rates.overloads[tuple(map(typeof, (bearing, lanes)))]
        called[overrides] = {one.function for one in needs_of(form.library)}
    of_spots = {"over_spots", "add_answers"}
    assert of_spots <= called[(SPOT,)]
    assert not of_spots & called[()]


@pytest.mark.environment
def test_the_spots_are_vector_instructions():
    """Packed operations in every loop over lanes.

    Of `add_points` there is a scalar loop beside with eight lanes, for what vectors leave over of a length that LLVM
    does not know: nothing.
    """
    if platform.machine() != "x86_64":
        pytest.skip("looks for x86-64 instructions")
    bearing, lanes, room = motion(SPOT).bearing, np.ones(JACOBIAN_END * LANES), np.ones(ROOM_ROWS * LANES)
    for kernel, operation, arguments in (
        (over_few_of_all, "mul", (*RULES["coarse"][2:], 0.01, lanes)),
        (over_spots, "mul", (*RULES["coarse"], 0.01, lanes)),
        (lane_rates, "sqrt", (bearing, lanes)),
        (add_answers, "mul", (1.0, 1.0, lanes)),
        (add_points, "mul", (0, FEW, 0.01, room)),
        (put_spot_slopes, "sqrt", (bearing, lanes)),
    ):
        code = machine_code(kernel.py_func, *arguments)
        packed, alone = code.count(f"{operation}pd"), code.count(f"{operation}sd")
        assert packed > (alone - packed if kernel is add_points else alone), kernel.py_func.__name__
