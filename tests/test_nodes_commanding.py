"""Commands to a running bearing without ROS: obeyed or refused, counted, stale; and its operating point."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from loops import obeying, twist, wrench

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.kinds.bearing.equilibrium import solver_of, support_of
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation

ALL_FREE = "rings.inner.free=all"


STILL = "model.dimension=quasi_static"


def recorded(scene="bearing_6203_rig_400N", overrides=(STILL, "rings.inner.mass=0"), **options):
    return obeying(scene, overrides, **options)


def test_a_load_acts_from_the_next_output_on_and_is_held_until_the_next():
    it = recorded()
    it.run(0.015)
    it.tell("command/load", wrench((0.0, -700.0, 50.0)))
    it.run(0.1)
    it.tell("command/load", wrench((0.0, -250.0, 0.0), frame=""))
    it.run(0.05)
    force, down = it.channel("inner_ring_force"), it.channel("inner_ring_offset")[:, 1]
    assert force[:16] == pytest.approx(np.tile([0.0, 400.0, 0.0], (16, 1)), abs=1e-6)
    assert force[16:116] == pytest.approx(np.tile([0.0, 700.0, -50.0], (100, 1)), abs=1e-6)
    assert force[116:] == pytest.approx(np.tile([0.0, 250.0, 0.0], (50, 1)), abs=1e-6)
    assert down[20] < down[10] < down[120] < 0.0
    assert (it.loop.commands.counts["taken"], it.loop.commands.counts["refused"]) == (2, 0)
    assert it.loop.status()[2]["load_from"] == "command/load"


def test_moments_tilt_a_ring_that_is_free_to():
    it = recorded("bearing_6203", [ALL_FREE, "rings.inner.load=[0,-100,100]"])
    it.tell("command/load", wrench((0.0, -100.0, 100.0), (0.3, -0.2, 0.0)))
    it.run(0.01)
    assert it.channel("inner_ring_torque")[-1] == pytest.approx([-0.3, 0.2, 0.0], abs=1e-8)
    assert np.abs(it.channel("inner_ring_tilt")[-1]).min() > 1e-5


def test_what_cannot_be_obeyed_is_refused_counted_said_and_changes_nothing():
    """The name of a frame is anybody's; it stands on /diagnostics and in files of ROS, cut and without escapes."""
    reported, untouched = recorded(), recorded()
    for it in (reported, untouched):
        it.run(0.013)
        it.tell("command/load", wrench((0.0, -500.0, 0.0)))
        it.run(0.02)
    refused = (
        (wrench((0.0, math.nan, 0.0)), "must be finite"),
        (wrench((0.0, 0.0, 0.0), (math.inf, 0.0, 0.0)), "must be finite"),
        (wrench((0.0, -10.0, 0.0), frame="map"), "its frame is 'map', and must be bearing_link"),
        (wrench(frame="x\x1b[2J" * 10_000), "its frame is"),
        (wrench((0.0, -10.0, 0.0), (0.5, 0.0, 0.0)), r"torque\[0\] = 0.5 N m acts on a coordinate"),
        (wrench((0.0, -10.0, 0.0), (0.0, 0.0, 1.0)), "about z is the drive's"),
        (wrench((0.0, -1e5, 0.0)), "through the balls: .* the greatest in this direction is a load of"),
        (wrench((1e30, 0.0, 0.0)), r"through the balls: .* is a load of \([0-9.e+]+, 0, 0\) N"),
    )
    for message, sentence in refused:
        with pytest.raises(BearingTwinError, match="command/load refused: .*" + sentence) as error:
            reported.tell("command/load", message)
        assert "\x1b" not in str(error.value)
        assert len(str(error.value)) < 400
    for it in (reported, untouched):
        it.run(0.05)
    for name in ("inner_ring_force", "position", "normal_load"):
        assert np.array_equal(reported.channel(name), untouched.channel(name)), name
    commands, numbers = reported.loop.commands, reported.loop.status()[2]
    assert (commands.counts["taken"], commands.counts["refused"]) == (1, len(refused))
    assert commands.warning().startswith(f"{len(refused)} refused, the last: command/load refused")
    assert commands.warning() == ""  # said once
    assert numbers["commands_refused"] == len(refused)
    assert numbers["last_refusal"].startswith("command/load refused")


def test_a_scene_that_takes_no_such_command_says_so():
    free = recorded("bearing_6203", [ALL_FREE, "rings.inner.load=[0,-100,100]"])
    with pytest.raises(BearingTwinError, match=r"greatest in this direction is .*a moment of"):
        free.tell("command/load", wrench((0.0, -100.0, 100.0), (4000.0, 0.0, 0.0)))
    with pytest.raises(BearingTwinError, match=r"model\.dimension: quasi_static or free, and"):
        recorded("bearing_6203", ()).tell("command/load", wrench((0.0, -10.0, 0.0)))
    simulation = Simulation(load_scene("two_spheres"))
    with pytest.raises(BearingTwinError, match="two_spheres has no load; a bearing has"):
        simulation.set_load((0.0, 0.0, 1.0), (0.0, 0.0))
    with pytest.raises(BearingTwinError, match="two_spheres has no stiffness; a bearing has"):
        simulation.operating_point()


def test_a_ring_with_mass_obeys_and_refuses_as_well():
    """The balls carry the load and the ring's weight once it has settled; then the scene's own load again."""
    it = recorded(overrides=("run.duration=1.0",))
    weight = 9.80665 * it.loop.simulation.scene.parameters.rings.inner.mass
    assert weight > 1.0
    it.run(0.02)
    it.tell("command/load", wrench((0.0, -900.0, 0.0)))
    with pytest.raises(BearingTwinError, match="the greatest in this direction"):
        it.tell("command/load", wrench((0.0, -1e5, 0.0)))
    it.run(0.2)
    assert it.channel("inner_ring_force")[-100:, 1].mean() == pytest.approx(900.0 + weight, rel=2e-3)
    it.loop.reset(0)
    it.run(0.1)
    assert it.channel("inner_ring_force")[-80:, 1].mean() == pytest.approx(400.0 + weight, rel=5e-3)


def test_a_load_that_no_other_follows_is_stale_on_time_and_the_scenes_own_acts():
    it = recorded(load_timeout_ns=30_000_000)
    it.run(0.015)
    it.tell("command/load", wrench((0.0, -700.0, 0.0)))
    it.run(0.02)
    assert it.loop.commands.warning() == ""
    it.tell("command/load", wrench((0.0, -600.0, 0.0)))  # in time: held on
    it.run(0.06)
    force = it.channel("inner_ring_force")[:, 1]
    assert force[16:36] == pytest.approx(700.0)
    assert force[36:66] == pytest.approx(600.0)
    assert force[66:] == pytest.approx(400.0)
    for _ in range(2):
        assert it.loop.commands.warning() == "command/load is stale, 0.03 s without another: the scene's load acts"
    assert it.loop.status()[2]["load_from"] == "the scene"
    it.tell("command/load", wrench((0.0, -450.0, 0.0)))
    assert it.loop.commands.warning() == ""
    it.loop.reset(0)
    it.run(0.08)
    assert it.channel("inner_ring_force")[-80:, 1] == pytest.approx(400.0)
    assert it.loop.commands.warning() == ""
    assert it.loop.status()[2]["load_from"] == "the scene"


@pytest.mark.parametrize(("timeout_ns", "outputs"), [(4_500_000, 6), (10_000_000, 11)])
def test_a_load_given_before_the_start_acts_from_the_start_and_holds_for_its_whole_time(timeout_ns, outputs):
    """Also where that ends between outputs."""
    it = recorded(load_timeout_ns=timeout_ns)
    it.tell("command/load", wrench((0.0, -700.0, 0.0)))
    it.run(0.02)
    assert it.channel("inner_ring_force")[:, 1] == pytest.approx(outputs * [700.0] + (21 - outputs) * [400.0])


def test_speeds_come_with_a_stamp_or_without_one():
    it = recorded(frame_prefix="left/")
    it.tell("command/speed", SimpleNamespace(data=160.0))
    it.run(0.03)
    assert it.channel("inner_ring_speed")[-1] == 160.0
    it.tell("command/speed_stamped", twist(angular=(0.0, 0.0, 150.0), frame="left/bearing_link"))
    it.run(0.03)
    assert it.channel("inner_ring_speed")[-1] == 150.0
    for message, sentence in (
        (twist(angular=(0.0, 0.0, 150.0)), "must be left/bearing_link"),
        *(
            (twist(linear, (*across, 150.0), "left/bearing_link"), "leave all but twist.angular.z at 0")
            for linear, across in zip(np.eye(5)[:, :3].tolist(), np.eye(5)[:, 3:].tolist(), strict=True)
        ),
        (twist(angular=(0.0, 0.0, math.nan), frame=""), "must be finite"),
    ):
        with pytest.raises(BearingTwinError, match="command/speed_stamped refused: .*" + sentence):
            it.tell("command/speed_stamped", message)
    assert it.loop.commands.counts["refused"] == 7
    it.run(0.01)
    assert it.channel("inner_ring_speed")[-1] == 150.0


def test_a_ring_that_hardly_turns_goes_on():
    """Slip of the cage is a share of the speed of rolling, which is 0 there."""
    it = recorded(overrides=())
    for speed in (5e-324, -1e-300, 0.0):
        it.tell("command/speed", SimpleNamespace(data=speed))
        it.run(0.15)
        assert it.channel("inner_ring_speed")[-1] == speed
        assert it.channel("cage_slip")[-1] == 0.0


@pytest.mark.parametrize(("scene", "limit"), [("bearing_6203", 6e5 / 28.5), ("shaft_two_6203", 6e5 / 28.5)])
def test_a_speed_that_may_be_meant_in_rpm_is_obeyed_and_said_once(scene, limit):
    """The limiting speed with oil, n·d_m of 6e5 mm/min; below it nothing is said."""
    it = obeying(scene)
    it.tell("command/speed", SimpleNamespace(data=0.99 * limit * math.pi / 30.0))
    assert it.loop.commands.speed_warning == ""
    for speed in (3000.0, 2500.0):
        it.tell("command/speed", SimpleNamespace(data=speed))
    warning = it.loop.commands.speed_warning
    assert "3000 rad/s is 28648 rpm, above" in warning
    assert warning.endswith("314.16 rad/s is 3000 rpm")
    assert it.loop.commands.counts["refused"] == 0


def test_a_speed_is_judged_by_the_load_that_acts():
    """4000 rad/s are too fast for the scene's thrust, not for a greater one; a reset brings the scene's own back."""
    it, fast = recorded("bearing_218_thrust"), SimpleNamespace(data=4000.0)
    for _ in range(2):
        it.run(0.002)
        with pytest.raises(BearingTwinError, match="is carried at rest; a speed of 4000 rad/s"):
            it.tell("command/speed", fast)
        it.tell("command/load", wrench((0.0, 0.0, 1.5e5)))
        it.tell("command/speed", fast)
        with pytest.raises(BearingTwinError, match=r"load refused: .* speed of 4000 rad/s"):
            it.tell("command/load", wrench((0.0, 0.0, 17800.0)))
        it.loop.reset(0)


def test_the_operating_point_is_the_equilibrium_of_the_last_output():
    it = recorded(overrides=[STILL, "gravity=[0,0,0]"])
    for seconds in (0.0, 0.037):
        if seconds:
            it.run(seconds)
        sample, point = it.loop.operating_point(0)
        assert sample.time_ns == round(1e9 * seconds)
        parameters = it.loop.simulation.scene.parameters
        solver = solver_of(parameters, "hertz", float(sample["orbit_angle"][0]))
        equilibrium = solver.solve(support_of(parameters))
        assert point.loads == pytest.approx([0.0, -400.0, 0.0, 0.0, 0.0], abs=1e-5)
        assert point.coordinates == pytest.approx(equilibrium.coordinates, rel=1e-6, abs=1e-13)
        scale = np.sqrt(np.outer(np.diag(equilibrium.stiffness), np.diag(equilibrium.stiffness)))
        assert np.abs((point.stiffness - equilibrium.stiffness) / scale).max() < 1e-6


def test_balls_that_move_by_themselves_have_an_operating_point_too():
    """The preloaded 6203 at low speed: the condensed stiffness of the literature, wherever its balls are."""
    simulation = Simulation(load_scene("bearing_6203", ["gravity=[0,0,0]", "drive.speed=10.0"]))
    simulation.advance(31)
    sample, point = simulation.operating_point()
    assert sample.sequence == 30
    expected = [9.137e7, 9.137e7, 1.6659e6, 172.4, 172.4]
    assert np.diag(point.stiffness) == pytest.approx(expected, rel=1e-3)
    assert point.loads[2] == pytest.approx(-sample["inner_ring_force"][2], rel=1e-4)


@pytest.mark.parametrize("control", ["shared", "auto"])
def test_the_operating_point_of_a_tilted_ring_is_tilted(control):
    """Stiffness is asked for where the run has the ring, balls under the same raceway control."""
    overrides = "gravity=[0,0,0]", "model.dimension=quasi_static", f"model.control={control}"
    simulation = Simulation(load_scene("bearing_6203_tilted", overrides))
    simulation.advance(3)
    sample, point = simulation.operating_point()
    assert point.coordinates[3:] == pytest.approx([1e-3, 0.0])
    assert abs(point.loads[3]) > 0.01
    assert point.loads[:3] == pytest.approx(-sample["inner_ring_force"], rel=1e-9, abs=1e-6)
    assert point.loads[3:] == pytest.approx(-sample["inner_ring_torque"][:2], rel=1e-9, abs=1e-9)


def test_the_weight_of_balls_and_ring_is_in_the_operating_point():
    simulation = Simulation(load_scene("bearing_6203_rig_400N", [STILL, "gravity=[0,-9806.65,0]"]))
    simulation.advance(5)
    _, point = simulation.operating_point()
    assert point.loads[1] == pytest.approx(-400.0 - 0.5 * 9806.65, rel=1e-9)
