"""The bearing's equations of motion: balances, symmetries, closed forms, statics, landings, meetings, laws, starts."""

import math

import numpy as np
import pytest
from bearings import advanced, law_keys, motion, run, stored_energy
from contact_reference import about_z, single_contact
from reference.rolling import rolling_rates
from runs import reported
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from bearing_twin.base.errors import SceneError
from bearing_twin.contact.laws import LAWS, damping_number, law_names, restitution_of
from bearing_twin.kinds.bearing.geometry import cage_speed, roll_rate
from bearing_twin.kinds.bearing.motion import start_state
from bearing_twin.kinds.bearing.parameters import LAW_NEEDS
from bearing_twin.kinds.bearing.system import (
    AXIS_DISTANCE,
    HEIGHT,
    ORBIT_ANGLE,
    SPIN,
    TANGENTIAL_VELOCITY,
    VELOCITY,
    bearing_of,
)
from bearing_twin.run.scene import choose, load_scene, open_scene, parse_scene
from bearing_twin.run.simulation import Simulation

NO_GRAVITY = "gravity=[0.0, 0.0, 0.0]"
AT_REST = (NO_GRAVITY, "cage.kind=none", "geometry.radial_clearance=2e-5", "drive.speed=0",
           "contact.friction_coefficient=0")  # fmt: skip


@pytest.mark.parametrize("angle", [0.0, 0.26, -0.7])
def test_rolling_speeds_are_those_of_a_body_that_slips_nowhere(angle):
    """Against the two equations of no slip, solved as they stand."""
    assert (cage_speed(183.0, 6.7e-3, 28.5e-3, angle), roll_rate(183.0, 6.7e-3, 28.5e-3, angle)) == pytest.approx(
        rolling_rates(183.0, 6.7e-3, 28.5e-3, angle), rel=1e-12
    )


def test_frequencies_measured_from_the_motion_are_those_of_rolling():
    """Cage speed and roll rate within 1 % of pure rolling under load."""
    simulation = Simulation(load_scene("bearing_6203", ["run.output_rate=2000", "drive.offset=[0.0, 0.0, 0.0]"]))
    values, half = simulation.advance(401).values, 200
    geometry, speed = simulation.scene.parameters.geometry, simulation.scene.parameters.drive.speed
    rolling, turning = rolling_rates(speed, geometry.ball_diameter, geometry.pitch_diameter)
    orbit = (values["orbit_angle"][-1] - values["orbit_angle"][half]) / (half / 2000.0)
    assert orbit == pytest.approx(rolling, rel=0.01)
    assert values["roll_rate"][half:].mean(axis=0) == pytest.approx(turning, rel=0.01)


@pytest.mark.parametrize("offset", [2e-6, 6e-6])
def test_a_ring_offset_loads_the_balls_as_statics_says(offset):
    """Slow turning, no gravity: each ball is two springs in series over the local interference."""
    overrides = (NO_GRAVITY, "drive.speed=1.0", f"drive.offset=[{offset}, 0.0, 0.0]", "geometry.balls=7")
    moving, out = run(*overrides, count=4, period=5e-3)
    inner, outer = moving.bearing.inner.law.given, moving.bearing.outer.law.given
    for ball, angle in enumerate(out.orbit_angle[-1]):
        squeeze = 3e-6 + offset * math.cos(angle)  # minus a quarter of the clearance at either race, plus the offset
        expected = 0.0
        if squeeze > 0.0:
            share = brentq(lambda h, s=squeeze: inner * h**1.5 - outer * (s - h) ** 1.5, 0.0, squeeze, xtol=1e-18)
            expected = inner * share**1.5
        assert out.normal_load[-1, ball, 0] == pytest.approx(expected, rel=2e-3, abs=2e-3)
    assert out.normal_load[-1, :, 0].max() > 2.0 * out.normal_load[-1, :, 0].min()


def test_turning_everything_turns_the_answer():
    """Offset and gravity turned by a seventh of a ball's pitch of 2 pi/8 times 3: balls 0..7 behave as 3.. did."""
    turn = 2.0 * math.pi * 3 / 8
    rotation = Rotation.from_rotvec([0.0, 0.0, turn])
    offset, gravity = np.array([2e-6, -1e-6, 4e-6]), np.array([3.0, -9.0, 1.0])

    def outputs(vectors):
        names = ("drive.offset", "gravity")
        values = (f"{name}={list(map(float, vector))}" for name, vector in zip(names, vectors, strict=True))
        return run("initial.motion=rest", "wanted.tolerance=1e-5", *values, count=10, period=2e-5)[1]

    first = outputs((offset, gravity))
    second = outputs((rotation.apply(offset), rotation.apply(gravity)))
    shifted = np.roll(second.normal_load, -3, axis=1)
    assert shifted == pytest.approx(first.normal_load, rel=1e-5)
    turned_force = np.roll(second.raceway_force, -3, axis=1)
    assert rotation.apply(first.raceway_force.reshape(-1, 3)) == pytest.approx(turned_force.reshape(-1, 3), abs=1e-4)


def test_a_ball_that_touches_nothing_flies_straight_and_keeps_its_spin():
    """In the frame that turns with it: centrifugal, Coriolis and gyroscopic terms cancel what its turning makes."""
    moving = motion(NO_GRAVITY, "drive.offset=[0, 0, 0]", "cage.kind=none", scene="bearing_6203_loose")
    state, times = moving.state, 1e-5 * np.arange(1, 11)
    state[:, AXIS_DISTANCE] = 0.5 * moving.parameters.geometry.pitch_diameter
    state[:, VELOCITY : VELOCITY + 3], state[:, SPIN : SPIN + 3] = (1e-3, 0.5, 2e-3), (100.0, 200.0, 300.0)
    first = moving.first_outputs()
    out = moving.advance(times, times[-1])
    assert not np.any(out.normal_load)
    straight = first.position + times[:, None, None] * first.velocity
    assert out.position == pytest.approx(straight, abs=1e-12)
    assert out.angular_velocity == pytest.approx(np.broadcast_to(first.angular_velocity, out.position.shape), rel=1e-9)


def least_gap(moving):
    return -moving.first_outputs().neighbour_approach.max()


def test_balls_that_meet_within_a_chunk_are_found_and_integrated_together():
    """A ball thrown at its neighbour from beyond reach is not run through: speeds are exchanged, energy closes."""
    moving = motion(*AT_REST)
    moving.state[0, VELOCITY + 1] = 0.5
    start = stored_energy(moving.first_outputs())[0]
    assert least_gap(moving) > 4e-3
    out = moving.advance(np.arange(1, 21) * 1e-3, 2e-2)
    assert least_gap(moving) > -1e-6
    speeds = moving.state[:, VELOCITY + 1]
    assert speeds[0] < 0.2
    assert speeds[1] + speeds[2] > 0.3
    assert stored_energy(out)[-1] + out.dissipated[-1] == pytest.approx(start, rel=1e-3)
    assert np.abs(out.orientation[..., 3]) == pytest.approx(1.0, abs=1e-9)  # without friction nothing turns a ball


def test_balls_that_meet_move_alike_whichever_chunks_they_are_integrated_in():
    """From rest; two meet first at 6.65 ms."""
    free = "cage.kind=none", "initial.motion=rest", "wanted.tolerance=1e-8"
    at_once, in_pieces = (motion(*free, scene="bearing_6203_loose") for _ in range(2))
    out = advanced(at_once, 5e-5, 140)
    for _ in range(140):
        last = advanced(in_pieces, 5e-5, 1)
    assert out.neighbour_load.max() > 5.0
    assert out.position[-1] == pytest.approx(last.position[-1], abs=1e-8)


@pytest.mark.parametrize("delivered", [1, 12, 100])
def test_a_speed_command_takes_effect_after_the_last_output_given_out(delivered):
    """Whatever was computed ahead; what was given out is as without it, and so are loads of the balls for a while."""
    unchanged, commanded = (Simulation(load_scene("bearing_6203")) for _ in range(2))
    assert np.array_equal(unchanged.advance(delivered).matrix(), commanded.advance(delivered).matrix())
    commanded.set_speed(200.0)
    before, after = unchanged.advance(130), commanded.advance(130)
    increase = after.values["inner_ring_speed"] - before.values["inner_ring_speed"]
    assert increase[:8] == pytest.approx(2.0 * np.arange(1, 9))
    assert increase[-1] == pytest.approx(200.0 - 183.26)
    speed, angle = after.values["inner_ring_speed"], after.values["inner_ring_angle"]
    assert np.gradient(angle, 1e-3)[1:-1] == pytest.approx(speed[1:-1], rel=0.01)
    assert after.first_sequence == delivered
    load = before.values["normal_load"][0]
    assert after.values["normal_load"][0] == pytest.approx(load, abs=1e-3 * load.max())
    commanded.reset()
    unchanged.reset()
    assert np.array_equal(unchanged.advance(150).matrix(), commanded.advance(150).matrix())


def test_a_sudden_change_of_speed_and_offset_comes_at_its_time_and_its_work_is_counted():
    """The ring jumps between two outputs: loads before are untouched, the energy it pushes in is the drive's."""
    simulation = Simulation(load_scene("bearing_6203_sudden", ["run.duration=0.04"]))
    block = simulation.advance(401)
    offset, speed = block.values["inner_ring_offset"][:, 1], block.values["inner_ring_speed"]
    change = round(0.02 * 1e4)
    assert np.all(offset[: change + 1] == 0.0)
    assert np.all(offset[change + 1 :] == -3e-6)
    assert speed[change] == pytest.approx(183.26)
    assert speed[change + 5] == pytest.approx(183.26 + 50.0)
    assert speed[change + 10 :] == pytest.approx(274.89)
    load = block.values["normal_load"].max(axis=(1, 2))
    assert load[change + 1 :].max() > 2.0 * load[: change + 1].max()
    assert abs(simulation.report().figures["energy_closure"]) < 1e-3
    work, gross = (np.diff(block.values[name])[change] for name in ("drive_work", "gross_work"))
    assert gross == pytest.approx(work, rel=1e-3)


def test_no_instant_is_lost_where_a_chunk_is_cut_into_parts():
    """Ramps and changes end parts at odd times; whatever they are, every output asked for is there."""
    for acceleration in np.random.default_rng(8).uniform(2e4, 2e6, 40):
        moving = motion(f"drive.acceleration={acceleration}", "drive.change.time=3.3e-4", "drive.change.speed=77.7")
        times = 5e-5 * np.arange(1, 21)
        out = moving.advance(times, float(times[-1]))
        assert np.all(np.isfinite(out.normal_load))
        assert np.all(np.diff(out.orbit_angle, axis=0) > 0.0)


@pytest.mark.parametrize("name", ["bearing_6203_start", "bearing_6203_fast", "bearing_6203_sticking"])
def test_extreme_scenes_close_their_energy_and_roll_as_kinematics_says(name):
    simulation = Simulation(load_scene(name, ["run.duration=0.05"]))
    simulation.advance(1 + round(0.05 * simulation.scene.parameters.run.output_rate))
    report = simulation.report()
    assert report.status == "done"
    assert abs(report.figures["energy_closure"]) < 1e-3
    assert report.figures["cage_speed_rad_s"] == pytest.approx(report.figures["cage_speed_theory_rad_s"], rel=6e-3)


def test_a_change_comes_on_top_of_the_scenes_offset_and_a_reset_takes_it_back():
    """The second run is the first, bit for bit, and has cost the same."""
    change = "drive.change={time: 2.0e-3, speed: 20.0, offset: [0.0, -3.0e-6, 2.0e-6]}"
    simulation = Simulation(load_scene("bearing_6203", ["drive.offset=[1.0e-6, 0.0, 5.0e-6]", change]))
    first, costs = simulation.advance(6), simulation.report().costs
    offset = first.values["inner_ring_offset"]
    assert offset[2] == pytest.approx([1e-6, 0.0, 5e-6], rel=1e-12)
    assert offset[3] == pytest.approx([1e-6, -3e-6, 7e-6], rel=1e-12)
    simulation.reset()
    assert np.array_equal(simulation.advance(6).matrix(), first.matrix())
    assert simulation.report().costs == costs


ALONE = ("geometry.balls=1", "geometry.radial_clearance=4e-5", "drive.offset=[0,0,0]", "initial.motion=rest",
         "wanted.tolerance=1e-5")  # fmt: skip


def rebound(speed, *overrides, stepper="rodas4"):
    """Speed after over speed before of one ball thrown from the middle of the clearance at the outer raceway."""
    moving = motion(*AT_REST, *ALONE, *overrides, stepper=stepper)
    moving.state[0, AXIS_DISTANCE], moving.state[0, VELOCITY] = 14.25e-3, speed
    span = 1e-5 / speed + 4e-5
    out = moving.advance(np.array([span]), span)
    assert np.all(out.normal_load == 0.0)
    return -moving.state[0, VELOCITY] / speed


@pytest.mark.parametrize("restitution", [0.9, 0.5])
@pytest.mark.parametrize("stepper", ["rodas4", "rk4"])
def test_a_ball_comes_back_from_a_raceway_with_the_restitution_asked_for(restitution, stepper):
    assert rebound(0.1, f"contact.restitution={restitution}", stepper=stepper) == pytest.approx(restitution, rel=2e-3)


def test_faster_balls_lose_more_and_the_speed_it_holds_at_can_be_moved():
    """e depends on chi v alone (exact relation of Hunt and Crossley's law)."""
    at_three = restitution_of(3.0 * damping_number(0.8))
    assert rebound(0.3, "contact.restitution=0.8") == pytest.approx(at_three, rel=2e-3)
    assert rebound(0.3, "contact.restitution=0.8", "contact.restitution_speed=0.3") == pytest.approx(0.8, rel=2e-3)


def test_without_a_restitution_the_relaxation_time_damps():
    assert 0.3 < rebound(0.1) < 0.97
    assert rebound(0.1, "contact.relaxation_time=0.0") == pytest.approx(1.0, abs=2e-3)


def test_one_damping_is_enough():
    for key, value in (("damping", "0.2"), ("relaxation_time", "2e-6"), ("relaxation_time", "1e-6")):
        with pytest.raises(SceneError, match=f"contact.{key} = .* all set the viscous term; keep one of them"):
            load_scene("bearing_6203", ["contact.restitution=0.8", f"contact.{key}={value}"])
    scene = load_scene("bearing_6203", ["contact.restitution=0.8"])
    assert scene.parameters.contact.relaxation_time == 0.0
    assert parse_scene(open_scene("bearing_6203", ["contact.restitution=0.8"])[0], "with all keys") == scene
    plain = load_scene("bearing_6203").resolved()  # where all keys stand, whoever gave them
    assert load_scene(plain, ["contact.restitution=0.8"]).parameters == scene.parameters


THROWN, FLIGHT = 0.01, 4e-4  # m/s; s after the touch, when the ball is in flight again
BOUNCES = 48  # of eight balls each


def _speed_after(tolerance, first_steps):
    """Balls' radial speeds [m/s] after a bounce on the outer raceway, and what one step may err by in it."""
    moving = motion(*AT_REST, "drive.offset=[0,0,0]", f"wanted.tolerance={tolerance}")
    moving.state[:, VELOCITY], moving.steps[:] = THROWN, first_steps
    duration = -moving.first_outputs().approach[0, 0, 1] / THROWN + FLIGHT
    moving.advance(np.array([duration]), duration)
    assert (moving.first_outputs().approach[0] < 0.0).all()
    return moving.state[:, VELOCITY].copy(), float(moving.scales[VELOCITY])


@pytest.mark.parametrize("tolerance", [1e-5, 1e-7])
def test_no_landing_is_missed_by_chance(tolerance):
    """Without error control of landings one of 384 misses by some hundred times the tolerance of a step."""
    exact = _speed_after(1e-9, np.full(8, 1e-6))[0][0]
    assert -THROWN < exact < -0.5 * THROWN
    first_steps = 1e-6 * 10.0 ** np.random.default_rng(1).uniform(-1.0, 1.0, (BOUNCES, 8))
    bounces = [_speed_after(tolerance, steps) for steps in first_steps]
    errors = np.abs([speeds - exact for speeds, _ in bounces]) / bounces[0][1]
    assert errors.max() < 8.0
    assert np.median(errors) < 2.0


NARROW = (  # b/a below 0.01
    "geometry.inner_conformity=0.5003",
    "geometry.outer_conformity=0.5003",
    "geometry.radial_clearance=-1e-7",
    "drive.offset=[0.0, 0.0, 0.0]",
)


@pytest.mark.parametrize(
    ("scene", "law", "overrides", "tolerance"),
    [
        # What the curvatures do to the coefficient is left out of the energy: 1e-4 of it.
        *(("bearing_6203", law, law_keys(law), 2e-4) for law in law_names("point", LAW_NEEDS)),
        *((scene, "hertz", ["contact.friction=spot"], 1e-4) for scene in ("bearing_6203", "bearing_6203_loose")),
    ],
)
def test_energy_closes_by_every_law_and_with_drilling(scene, law, overrides, tolerance):
    moving = motion("initial.motion=rest", "drive.offset=[0.0, -9.0e-6, 1.0e-5]", *overrides, scene=scene, law=law)
    before = stored_energy(moving.first_outputs())[0]
    out = moving.advance(np.arange(1, 31) * 2e-4, 6e-3)
    residual = out.drive_work[-1] - (stored_energy(out)[-1] - before) - out.dissipated[-1]
    assert out.drive_work[-1] > 1e-4
    assert abs(residual) < tolerance * out.drive_work[-1]
    assert np.all(np.diff(out.dissipated) >= -1e-15)


def test_the_law_reported_is_the_law_used():
    """Also where an ellipse is too narrow for the rational form of `hertz`, which is solved exactly there."""
    for requested in ("auto", "hertz", "hertz_exact"):
        scene = load_scene("bearing_6203", [*NARROW, "run.duration=1e-3", f"contact.normal={requested}"])
        simulation = Simulation(scene)
        simulation.advance(2)
        assert choose(scene).law == simulation.report().law == requested.replace("auto", "hertz")
        assert choose(scene).warnings == ()
    rational, exact = (run(*NARROW, law=law, count=3)[1].normal_load for law in ("hertz", "hertz_exact"))
    assert rational == pytest.approx(exact, rel=1e-7)


def test_a_number_for_no_law_and_a_law_without_its_number_are_refused():
    for overrides, sentence in (
        (["contact.normal=linear"], "needs contact.stiffness in N/m"),
        (["contact.stiffness=1e7"], "needs contact.normal: linear"),
        (["contact.stiffness=1e7", "contact.normal=hertz"], "needs contact.normal: linear"),
    ):
        with pytest.raises(SceneError, match=sentence):
            load_scene("bearing_6203", overrides)
    for law, row in LAWS.items():
        if row.fits == "line" or "alpha" in row.needs:
            with pytest.raises(SceneError):
                load_scene("bearing_6203", [f"contact.normal={law}"])


def start_of(name, *overrides):
    scene = load_scene(name, overrides)
    bearing = bearing_of(scene.parameters, choose(scene).law)
    return bearing, scene.parameters.drive.speed, start_state(bearing, scene.parameters.drive.speed, "rolling")


def static_force(bearing, rate, distance, angle, height):
    """Radial and axial force on a ball by elastic contacts and its orbit."""
    centre, zero = about_z(np.cos(angle), -np.sin(angle), bearing.offset), (0.0, 0.0, 0.0)
    inner = single_contact(bearing, bearing.inner, centre, 0.0, (distance, 0.0, height), zero, zero).force
    outer = single_contact(bearing, bearing.outer, zero, 0.0, (distance, 0.0, height), zero, zero).force
    return inner[0] + outer[0] + bearing.ball_mass * distance * rate**2, inner[2] + outer[2]


@pytest.mark.parametrize("name", ["bearing_6203", "bearing_6203_loose", "bearing_6203_fast"])
@pytest.mark.parametrize("offset", ["[0,0,0]", "[0,0,6e-5]", "[1e-6,-2e-6,-5e-6]", "[0,-1e-5,4e-5]"])
def test_nothing_pushes_a_ball_at_the_start_and_it_rolls(name, offset):
    """Also on one raceway alone, and held by its orbit alone; slip against what the ring's surface runs at."""
    bearing, speed, state = start_of(name, f"drive.offset={offset}")
    for ball in state:
        distance, angle, height = ball[AXIS_DISTANCE], ball[ORBIT_ANGLE], ball[HEIGHT]
        rate = ball[TANGENTIAL_VELOCITY] / distance
        centrifugal = bearing.ball_mass * distance * rate**2
        force = np.hypot(*static_force(bearing, rate, distance, angle, height))
        # Iterating orbit and rest three times leaves this much of the change of the orbit.
        assert force < 1e-3 * centrifugal
        centre, position = about_z(np.cos(angle), -np.sin(angle), bearing.offset), (distance, 0.0, height)
        velocity, spin = (0.0, ball[TANGENTIAL_VELOCITY], 0.0), tuple(ball[SPIN : SPIN + 3])
        inner = single_contact(bearing, bearing.inner, centre, speed, position, velocity, spin)
        outer = single_contact(bearing, bearing.outer, (0.0, 0.0, 0.0), 0.0, position, velocity, spin)
        assert max(np.abs(inner.slip).max(), np.abs(outer.slip).max()) < 1e-3 * speed * distance


def test_balls_that_their_orbit_throws_through_the_raceway_are_refused():
    bearing, _, _ = start_of("bearing_6203")
    with pytest.raises(SceneError, match="find no rest"):
        start_state(bearing, 1e6, "rolling")


def test_balls_that_centrifugal_loads_lift_off_the_inner_ring_are_warned_of():
    fast = "drive.speed=2500", "geometry.radial_clearance=-1e-7", "drive.offset=[0,0,0]", "cage.kind=none"
    report = reported("bearing_6203", "run.duration=0.004", *fast)
    assert not any(report.figures["greatest_normal_load_inner_n"])
    (flag,) = report.flags
    assert "at 2500 rad/s centrifugal loads lift the balls off the inner ring" in flag
