"""Commands to a running shaft on two bearings, without ROS: obeyed, refused, stale; and what its figures then say."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from loops import obeying, twist, wrench
from shafts import motion_of

from bearing_twin.base.errors import BearingTwinError, IntegrationError
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import Output
from bearing_twin.run.failure import read_failure, write_failure
from bearing_twin.run.scene import choose, load_scene
from bearing_twin.run.simulation import Simulation

DAMPED = "contact.relaxation_time=2e-5"  # what rings dies out within some milliseconds
QUICK = (DAMPED, "run.output_rate=1000", "run.publish_rate=100", "solver.check=none")


def shaft(overrides=QUICK, **options):
    return obeying("shaft_two_6203", overrides, **options)


def loaded(force=(), torque=()):
    return wrench(force, torque, frame="shaft_link")


def turning(speed, **options):
    return twist(angular=(0.0, 0.0, speed), frame="shaft_link", **options)


def test_a_load_acts_from_the_next_output_on_as_a_change_in_the_scene_does():
    """At its place, with constant loads and the scene's unbalance; it is held until the next."""
    keys = (*QUICK, "shaft.load_place=0.02", "shaft.loads=[[0, 10, 0, 0, 0, 0]]", "wanted.tolerance=1e-5")
    running = shaft(keys)
    running.run(0.015)
    running.tell("command/load", loaded((0.0, -300.0, 50.0), (0.5, 0.0, 0.0)))
    running.run(0.03)
    running.tell("command/load", loaded((0.0, -100.0, 0.0)))
    running.run(0.01)
    unbalance = 2.0e-5 * 314.159**2
    load = running.channel("load") - [10.0, 0.0, 0.0]
    assert np.hypot(*load[:16, :2].T) == pytest.approx(unbalance, rel=1e-9)
    assert load[16:46, 1] == pytest.approx(-300.0, abs=1.001 * unbalance)
    assert load[16:46, 2] == pytest.approx(50.0)
    assert load[46:, 1] == pytest.approx(-100.0, abs=1.001 * unbalance)
    assert running.channel("load_moment")[20, 0] == pytest.approx(0.5 + 0.02 * 300.0, abs=0.01 * unbalance * 1.001)
    change = "shaft.change={time: 0.015, load: [0, -300, 50], moment: [0.5, 0]}"
    scene = motion_of(*keys, change)
    times = 1e-3 * np.arange(1, 46)
    out = scene.advance(times, times[-1])
    assert np.array_equal(out["load"][15:, 2], load[16:46, 2])
    for name in ("position", "tilt", "left_normal_load", "left_contact_angle", "load_work"):
        error = np.abs(running.channel(name)[1:46] - out[name]).max()
        assert error < 1e-4 * np.abs(out[name]).max(), name


REFUSED = {
    "too much": (
        "load",
        loaded((0.0, -1e5, 0.0)),
        "the shaft through the balls: .* the greatest in this direction is",
    ),
    "too fast": ("speed", SimpleNamespace(data=2e4), r"must be finite and within \+-10000"),
    "across": ("speed_stamped", turning(200.0, linear=(1.0,)), "the shaft turns about z alone"),
}


@pytest.fixture(scope="module")
def undisturbed():
    it = shaft()
    it.run(0.03)
    return it


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_obeyed_is_refused_counted_said_and_changes_nothing(case, undisturbed):
    name, message, sentence = REFUSED[case]
    running = shaft()
    running.run(0.013)
    with pytest.raises(BearingTwinError, match=f"command/{name} refused: .*" + sentence) as caught:
        running.tell(f"command/{name}", message)
    assert "\n" not in str(caught.value)
    running.run(0.017)
    for channel in ("position", "shaft_speed", "left_normal_load"):
        assert np.array_equal(running.channel(channel), undisturbed.channel(channel)), channel
    assert (running.loop.commands.counts["taken"], running.loop.commands.counts["refused"]) == (0, 1)
    assert running.loop.commands.warning().startswith(f"1 refused, the last: command/{name} refused")


def test_a_shaft_refuses_a_torque_and_a_speed_at_which_nothing_carries_its_load():
    simulation = Simulation(load_scene("shaft_two_6203", QUICK))
    with pytest.raises(BearingTwinError, match="the torque follows from the speed; command the speed instead"):
        simulation.set_torque(0.1)
    with pytest.raises(BearingTwinError, match="at 60000 rad/s the balls are thrown outwards so far that nothing"):
        simulation.set_speed(6e4)


def test_the_operating_point_bears_the_loads_and_its_stiffness_is_their_change_with_place():
    """At the start all is in balance under loads and weight; a small load moves the shaft by the inverse stiffness."""
    steady = (*QUICK, "shaft.unbalances=[]")
    simulation = Simulation(load_scene("shaft_two_6203", steady))
    scene = simulation.scene.parameters
    sample, point = simulation.operating_point()
    weight = scene.shaft.mass * np.array([*scene.gravity, 0.0, 0.0])
    acting = np.array([*sample["load"], *sample["load_moment"]]) + weight
    assert point.speed == scene.drive.speed
    assert np.abs(point.loads - acting).max() < 1e-5 * np.abs(acting).max()
    small = np.array([0.3, 0.2, 0.1, 0.002, -0.001])
    coordinates = []
    for sign in (1.0, -1.0):
        force = np.array(scene.shaft.load) + sign * small[:3]
        moment = np.array(scene.shaft.moment) + sign * small[3:]
        keys = (f"shaft.load={force.tolist()}", f"shaft.moment={moment.tolist()}", "shaft.load_place=0")
        _, shifted = Simulation(load_scene("shaft_two_6203", (*steady, *keys))).operating_point()
        coordinates.append(shifted.coordinates)
    assert np.linalg.solve(point.stiffness, small) == pytest.approx(
        0.5 * (coordinates[0] - coordinates[1]), rel=2e-3, abs=1e-12
    )


def test_a_commanded_speed_is_approached_evenly_and_a_change_of_the_scene_is_added_to_it():
    running = shaft((*QUICK, "drive.change={time: 0.04, speed: 10.0}"))
    running.run(0.0105)
    running.tell("command/speed_stamped", turning(330.0))
    running.run(0.05)
    speed, angle = running.channel("shaft_speed"), running.channel("shaft_angle")
    since = np.maximum(np.arange(len(speed)) - 11, 0.0)
    ramp = np.minimum(314.159 + 2.0 * since, 330.0) + np.clip(2.0 * (np.arange(len(speed)) - 40), 0.0, 10.0)
    assert speed == pytest.approx(ramp, rel=1e-12)
    assert np.diff(angle) == pytest.approx(1e-3 * 0.5 * (speed[1:] + speed[:-1]), rel=3e-4)
    assert running.loop.simulation.report().figures["shaft_speed_at_end_rad_s"] == 340.0


def test_pose_and_frames_follow_the_shaft():
    running = shaft()
    running.tell("command/load", loaded((0.0, -500.0, 0.0), (2.0, 0.0, 0.0)))
    simulation = running.loop.simulation
    sample = simulation.advance(60)[59]
    output = Output(simulation.scene.parameters, "hertz", sample)
    by_name = {topic.name: topic for topic in KINDS["shaft"].topics(simulation.scene.parameters)}
    pose = by_name["shaft/pose"].fields(output)["pose"]
    frames = {
        frame["child_frame_id"]: frame["transform"]["translation"]
        for frame in by_name["/tf"].fields(output)["transforms"]
    }
    assert pose["position"][1] == frames["shaft"][1] == sample["position"][1] < -1e-6
    tilt = sample["tilt"]
    assert abs(tilt[0]) > 1e-6
    along = frames["right_bearing"] - frames["left_bearing"]
    assert along == pytest.approx([0.09 * tilt[1], -0.09 * tilt[0], 0.09], rel=1e-9, abs=1e-15)
    x, y, z, w = pose["orientation"]
    axis = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x)]
    assert axis == pytest.approx([tilt[1], -tilt[0]], rel=1e-6, abs=1e-12)


def test_a_motion_goes_on_from_a_snapshot_to_the_bit():
    """With a commanded load and speed, and a change still to come; by way of JSON, as in the file of a failure."""
    change = "shaft.change={time: 0.001, load: [0, -30, 0]}", "drive.change={time: 0.02, speed: 5.0}"
    scene = load_scene("shaft_two_6203", change)
    first, second = (KINDS["shaft"].motion(scene.parameters, choose(scene)) for _ in range(2))
    times = 5e-4 * np.arange(1, 20)
    for it in (first, second):
        it.first_outputs()
    first.advance(times, times[-1])
    first.set_load((0.0, -100.0, 5.0), (0.1, 0.0))
    first.goal_speed = 340.0
    first.advance(times, times[-1])
    saved = json.loads(json.dumps(first.snapshot(), allow_nan=False))
    for of_nobody in ({"commanded_at": -1.0}, {"now": -1.0}, {"goal": math.inf}):
        with pytest.raises(ValueError, match="clock"):
            second.resume(saved | of_nobody)
    earlier = {"told" if name == "commanded_at" else name: value for name, value in saved.items()}  # of version 0
    expected = first.advance(times, times[-1])
    for snapshot in (saved, earlier):
        second.resume(snapshot)
        assert second.goal_speed == 340.0
        outputs = second.advance(times, times[-1])
        for name, values in expected.items():
            assert np.array_equal(values, outputs[name]), name


def failed(simulation):
    """The error that ends a run, after all outputs before it."""
    with pytest.raises(IntegrationError) as caught:
        for _ in iter(lambda: simulation.advance(2000), None):
            pass
    return caught.value


def test_a_failed_run_tells_of_the_shaft_and_its_load(tmp_path):
    """Its load is commanded, then its scene's unbalance shakes the shaft through the balls at its speed."""
    drive = "drive={speed: 10, acceleration: 2e4}"
    scene = load_scene("shaft_two_6203", ("shaft.unbalances=[[0, 0.005, 0]]", drive, DAMPED, "solver.check=none"))
    simulation = Simulation(scene)
    simulation.advance(20)
    simulation.set_load((0.0, -200.0, 0.0), (0.0, 0.0))
    simulation.advance(20)
    simulation.set_speed(3000.0)
    error = failed(simulation)
    reported = read_failure(write_failure(error, tmp_path))
    assert reported.body == "shaft"
    rows = {label: value for label, value, _ in reported.body_rows()}
    assert rows["load z"] == 0.0
    assert rows["shaft_speed"] > 10.0
    unbalance = 0.005 * math.hypot(rows["shaft_speed"] ** 2, 2e4)
    assert math.hypot(rows["load x"], rows["load y"] + 200.0) == pytest.approx(unbalance, rel=1e-9)
