"""A shaft that a torque turns, in time: closed forms, balances, an integration by SciPy, commands, refusals."""

import numpy as np
import pytest
from bearings import advanced, motion, stored_energy

from bearing_twin.base.errors import BearingTwinError, IntegrationError, SceneError
from bearing_twin.kinds.bearing.geometry import cage_speed, roll_rate
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation, simulate

TORQUE = ("drive.kind=torque", "drive.inertia=1.0e-5")
FROM_REST = (*TORQUE, "drive.torque=0.01", "drive.speed=0", "initial.motion=rest")
NO_GRAVITY = ("gravity=[0,0,0]",)
RIG = "bearing_6203_rig_400N"
CAGES = (("cage.kind=none",), ("cage.kind=even",), ("cage.kind=pockets",))


def outputs(moving, period, count):
    """The first outputs, and the later ones."""
    return moving.first_outputs(), advanced(moving, period, count)


def joined(name, first, out):
    return np.concatenate([getattr(first, name), getattr(out, name)])


def closure(first, out):
    """Energy made by the numbers over the work moved."""
    numerical = stored_energy(out)[-1] - stored_energy(first)[0] + out.dissipated[-1] - out.drive_work[-1]
    return numerical / out.gross_work[-1]


@pytest.mark.parametrize("damping", [0.0, 1e-3])
def test_without_friction_the_torque_and_its_drag_alone_make_the_speed(damping):
    """w = T t / J, and w = T / c (1 - exp(-c t / J)); the drag is lost, and none of it is the balls'."""
    moving = motion(*FROM_REST, *NO_GRAVITY, "contact.friction_coefficient=0", f"drive.damping={damping}")
    first, out = outputs(moving, 1e-4, 200)
    time = 1e-4 * np.arange(1, 201)
    expected = 1e3 * time if damping == 0.0 else 0.01 / damping * -np.expm1(-damping * time / 1e-5)
    assert out.inner_ring_speed == pytest.approx(expected, rel=1e-5)
    assert out.kinetic_energy == pytest.approx(0.5 * 1e-5 * expected**2, rel=3e-5, abs=1e-9)
    assert out.drive_work[-1] == pytest.approx(0.01 * out.inner_ring_angle[-1], rel=1e-9)
    assert abs(closure(first, out)) < 1e-6


def test_balls_that_roll_add_their_share_of_inertia():
    """Z (m (w_c d_m / 2)^2 + I (w_c - w_r)^2) / w^2, by rolling at contact angle 0; a cage adds J_c (w_c / w)^2."""
    for cage in CAGES[:2]:
        moving = motion(*FROM_REST, *NO_GRAVITY, *cage, "contact.friction_regularisation=1e-3")
        geometry, bearing = moving.parameters.geometry, moving.bearing
        size = geometry.ball_diameter, geometry.pitch_diameter
        orbit, roll = cage_speed(1.0, *size), roll_rate(1.0, *size)
        share = bearing.ball_mass * (0.5 * size[1] * orbit) ** 2 + bearing.ball_inertia * (orbit - roll) ** 2
        inertia = 1e-5 + 8.0 * share + (5e-3 * (0.5 * size[1] * orbit) ** 2 if cage == CAGES[1] else 0.0)
        _, out = outputs(moving, 1e-3, 20)
        assert 8.0 * share > 0.02 * inertia
        assert np.ptp(out.inner_ring_speed[[9, -1]]) / 0.01 == pytest.approx(0.01 / inertia, rel=1e-3)


def test_angular_momentum_of_all_that_turns_is_what_torque_and_outer_ring_give():
    """J w + sum (m r v_t + I s_z) about the axis, with friction over the spots, drag and a torque that changes."""
    moving = motion(
        *TORQUE, *NO_GRAVITY, "drive.speed=50", "initial.motion=rest", "contact.friction=spot", "drive.damping=1e-5",
        "drive.torque_table=[[0,0.02],[0.001,-0.01],[0.0015,0.03]]",
    )  # fmt: skip
    moving.advance(np.array([]), 4e-4)  # slip begins within nanoseconds
    first, out = outputs(moving, 2e-6, 1000)
    position, velocity = joined("position", first, out), joined("velocity", first, out)
    orbital = moving.bearing.ball_mass * (position[..., 0] * velocity[..., 1] - position[..., 1] * velocity[..., 0])
    spin = moving.bearing.ball_inertia * joined("angular_velocity", first, out)[..., 2]
    speed = joined("inner_ring_speed", first, out)
    momentum = (orbital + spin).sum(axis=1) + 1e-5 * speed
    moment = joined("drive_torque", first, out) - 1e-5 * speed - joined("outer_ring_torque", first, out)[:, 2]
    impulse = np.concatenate([[0.0], np.cumsum(0.5 * (moment[1:] + moment[:-1])) * 2e-6])
    assert np.ptp(momentum) > 1e-5
    assert momentum - momentum[0] == pytest.approx(impulse, abs=2e-4 * np.ptp(momentum))
    balls = joined("inner_ring_torque", first, out)[:, 2]
    slope = np.gradient(1e-5 * speed, 2e-6)
    part = slice(50, 250)
    assert slope[part] == pytest.approx(
        (moment + joined("outer_ring_torque", first, out)[:, 2] + balls)[part], abs=1e-4
    )


@pytest.mark.parametrize("cage", CAGES, ids=lambda keys: keys[0])
@pytest.mark.parametrize("ring", [(), ("rings.inner.unbalance=1e-4",), ("rings.inner.free=all",)], ids=str)
def test_energy_closes_with_the_work_of_the_torque(cage, ring):
    """A ring with mass under a load, gravity and a torque: its gyroscopic moment and unbalance at the speed that is."""
    table = "drive.torque_table=[[0,0.1],[0.01,0.05],[0.02,-0.1]]"
    moving = motion("drive.kind=torque", "drive.damping=1e-4", table, *cage, *ring, scene=RIG)
    first, out = outputs(moving, 1e-4, 300)
    assert abs(closure(first, out)) < 1e-5
    speed, torque = joined("inner_ring_speed", first, out), joined("drive_torque", first, out)
    power = speed * torque
    work = np.sum(0.5 * (power[1:] + power[:-1])) * 1e-4
    assert out.drive_work[-1] - out.inner_ring_load_work[-1] == pytest.approx(work, rel=1e-3)
    assert torque[[100, 200]] == pytest.approx([0.05, -0.1], rel=1e-9)


def test_a_cage_on_the_land_of_the_inner_ring_turns_its_shaft():
    """Without a torque J w changes by the impulse of the moments of balls and land."""
    moving = motion("drive.kind=torque", scene="bearing_6203_guided_cage")
    first, out = outputs(moving, 2e-7, 20000)
    assert abs(closure(first, out)) < 1e-5
    moment, speed = joined("inner_ring_torque", first, out)[:, 2], joined("inner_ring_speed", first, out)
    impulse = np.sum(0.5 * (moment[1:] + moment[:-1])) * 2e-7
    assert abs(impulse) > 1e-8
    assert 1e-4 * (speed[-1] - speed[0]) == pytest.approx(impulse, abs=5e-9)


def test_a_torque_is_commanded_where_it_turns_the_shaft_and_a_speed_where_it_is_prescribed():
    turned = Simulation(load_scene("bearing_6203", (*FROM_REST, "solver.companion=off")))
    turned.advance(11)
    turned.set_torque(-0.02)
    block = turned.advance(10)
    speed, torque = block.values["inner_ring_speed"], block.values["drive_torque"]
    assert torque == pytest.approx(np.full(10, -0.02))
    assert np.diff(speed) == pytest.approx(np.full(9, -0.02 / 1.042e-5 * 1e-3), rel=1e-2)
    with pytest.raises(BearingTwinError, match=r"drive\.kind = torque: .*command the torque instead"):
        turned.set_speed(10.0)
    with pytest.raises(BearingTwinError, match="a torque of nan is not finite"):
        turned.set_torque(float("nan"))
    turned.reset()
    assert turned.advance(1).values["drive_torque"][0] == 0.01
    with pytest.raises(BearingTwinError, match=r"drive\.kind = speed: .*command the speed instead"):
        Simulation(load_scene("bearing_6203")).set_torque(0.01)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        (("drive.kind=torque",), "wants an inertia about the axis; give drive.inertia"),
        ((*TORQUE, "drive.torque_table=[[0,1],[0,2]]"), "time must grow from row to row"),
        ((*TORQUE, "drive.change={time: 0.01, speed: 5}"), "drive.change changes a prescribed speed"),
        (("drive.torque=0.1",), "drive.torque act where drive.kind is torque"),
        ((*TORQUE, "model.dimension=quasi_static"), "has the speed follow from friction"),
        ((*TORQUE, "rings.inner.load=[0,-100,0]"), "wants rings.inner.mass"),
        ((*TORQUE, "solver.stepper=rk4"), "does not move a shaft by a torque"),
        ((*TORQUE, "drive.speed=2e4"), "must be below drive.greatest_speed"),
        ((*TORQUE, "drive.torque=-9900"), "between two outputs"),
        ((*TORQUE, "drive.torque_table=[[0,0],[1,9900]]"), "between two outputs"),
    ],
)
def test_what_contradicts_itself_is_refused(keys, message):
    with pytest.raises(SceneError, match=message):
        load_scene("bearing_6203", keys)


def test_a_shaft_that_runs_away_ends_the_run_at_the_first_output_beyond_the_limit():
    moving = motion(*FROM_REST, "drive.greatest_speed=10")
    with pytest.raises(IntegrationError, match=r"beyond drive\.greatest_speed = 10 rad/s") as caught:
        outputs(moving, 1e-3, 40)
    assert (caught.value.reason, caught.value.body) == ("too fast", "inner ring")
    assert caught.value.seconds == pytest.approx(0.011)


def test_the_figures_tell_speed_torque_and_time_to_it():
    """With drag the change of speed is made to 99 % at ln(100) J / c; the torque is given."""
    keys = ("drive.damping=4.2e-3", "contact.friction_coefficient=0", "run.duration=0.03", "run.output_rate=5000")
    run = simulate(load_scene("bearing_6203", (*FROM_REST, *NO_GRAVITY, *keys)))
    assert sum(map(len, run.blocks())) == 151
    figures = run.report.figures
    assert figures["run_up_time_s"] == pytest.approx(np.log(100.0) * 1e-5 / 4.2e-3, rel=5e-3)
    assert figures["inner_ring_speed_at_end_rad_s"] == pytest.approx(0.01 / 4.2e-3, rel=1e-4)
    assert figures["drive_torque_nm"] == pytest.approx(0.01, rel=1e-9)
    prescribed = simulate(load_scene("bearing_6203", ("run.duration=0.001",)))
    assert len(list(prescribed)) == 2
    assert "run_up_time_s" not in prescribed.report.figures
