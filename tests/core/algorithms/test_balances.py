"""Balances of a bearing read off its channels and messages: power, momentum, wrenches, action and reaction."""

import math

import numpy as np
import pytest
from bearings import TURNED_REST, motion
from runs import a_choice, reported, run_all
from scipy.integrate import simpson
from scipy.spatial.transform import Rotation

from bearing_twin.base.sample import Sample
from bearing_twin.contact.elasticity import hertz_coefficient
from bearing_twin.contact.materials import MATERIALS, effective_modulus
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.bearing.equilibrium import setting_of
from bearing_twin.kinds.bearing.outputs import contacts, origins, wrenches
from bearing_twin.kinds.bearing.system import AXIS_DISTANCE, HEIGHT, MOTION, ORBIT_ANGLE, VELOCITY
from bearing_twin.kinds.contract import Output
from bearing_twin.log import cdr
from bearing_twin.log.stream import MessageStream
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation
from bearing_twin.shapes import body as body_of
from bearing_twin.shapes import contact_of, find_opposing, sphere, torus

PERIOD, COUNT = 4e-7, 401
TIMES = PERIOD * np.arange(1, COUNT + 1)
STEEL = effective_modulus(MATERIALS["steel"], MATERIALS["steel"])
SPOT = "contact.friction=spot"
# Slip dies in microseconds, not in fractions of one, so that sums over the instants are integrals.
SMOOTH = ("drive.acceleration=1e5", "contact.friction_regularisation=0.3", "wanted.tolerance=1e-6")
# Thirteen balls that fill the circle, pressed outwards and inwards until each touches both neighbours.
FULL = (
    "geometry.balls=13", f"geometry.pitch_diameter={6.746e-3 / math.sin(math.pi / 13) * (1.0 + 1e-9)!r}",
    "geometry.radial_clearance=-40e-6", "initial.motion=rest",
)  # fmt: skip


def ringing(*overrides):
    """Dense outputs of a start under radial and axial offset, the ring speeding up, with the bearing's numbers."""
    moving = motion(*TURNED_REST, *SMOOTH, *overrides)
    moving.goal_speed = 300.0
    moving.state[:, VELOCITY] += 0.05 * np.cos(2.4 * np.arange(len(moving.state)))  # so that the contacts ring
    return moving.bearing, moving.advance(TIMES, float(TIMES[-1]))


@pytest.fixture(scope="module", params=["point", "spot"])
def started(request):
    """Eight balls: with friction at a point from rest, sliding; with spots rolling under thrust, drilling."""
    drilling = ("initial.motion=rolling", "drive.offset=[0.0, -1.0e-6, 4.0e-5]", SPOT)
    return ringing(*(drilling if request.param == "spot" else ()))


@pytest.fixture(scope="module")
def full():
    """Thirteen touching balls with friction over the spots, from rest."""
    return ringing(SPOT, *FULL)


def test_leapfrog_loses_no_energy_where_balls_touch():
    """What their contacts store was summed by the velocities before each step: 1 % of all work was missing."""
    loose = ("geometry.balls=13", "geometry.pitch_diameter=0.0283", "cage.kind=none", "initial.motion=rest")
    report = reported("bearing_6203_loose", *loose, "solver.stepper=imex", "run.duration=0.004")
    assert abs(report.figures["energy_closure"]) < 1e-3


def integral(power):
    """The integral over all instants of an array (instants, ...)."""
    return simpson(power, dx=PERIOD, axis=0)


def test_what_friction_and_damping_take_is_what_the_books_say(started):
    """Friction force on slip, drilling torque on spin, and the viscous part of the load on the rate of approach."""
    _, out = started
    sliding = -np.einsum("skrv,skrv->s", out.friction_force, out.slip)
    drilling = -np.einsum("skr,skr->s", out.drilling_torque, out.spin_rate)
    coefficient = np.vectorize(hertz_coefficient)(out.curvature_small, out.curvature_large, STEEL)
    elastic = coefficient * np.maximum(out.approach, 0.0) ** 1.5
    rate = np.gradient(out.approach, PERIOD, axis=0, edge_order=2)
    viscous = ((out.normal_load - elastic) * rate).sum(axis=(1, 2))
    assert np.all(sliding >= 0.0)
    parts = [integral(power) for power in (sliding, drilling, viscous)]
    booked = out.dissipated[-1] - out.dissipated[0]
    assert sum(parts) == pytest.approx(booked, rel=1e-3)
    spots = bool(np.any(out.drilling_torque))
    assert parts[0] > 0.02 * booked
    assert parts[1] > 0.02 * booked if spots else parts[1] == 0.0
    assert parts[2] > 5e-4 * booked


def test_the_drive_works_by_the_rings_torque_at_its_speed(started):
    _, out = started
    assert np.ptp(out.inner_ring_speed) > 10.0
    power = -out.inner_ring_torque[:, 2] * out.inner_ring_speed
    assert integral(power) == pytest.approx(out.drive_work[-1] - out.drive_work[0], rel=2e-5)


def test_a_ball_moves_and_turns_as_its_wrench_says(started):
    """Newton and Euler for every ball, integrated: the published wrench is all that acts besides the weight."""
    bearing, out = started
    force = out.raceway_force + bearing.ball_mass * np.array(bearing.gravity)
    change = bearing.ball_mass * (out.velocity[-1] - out.velocity[0])
    assert integral(force) == pytest.approx(change, abs=1e-4 * np.abs(change).max())
    turning = bearing.ball_inertia * (out.angular_velocity[-1] - out.angular_velocity[0])
    assert integral(out.raceway_torque) == pytest.approx(turning, abs=1e-4 * np.abs(turning).max())


def test_a_ball_between_others_moves_and_turns_as_all_its_contacts_say(full):
    """Newton and Euler for each of thirteen balls: raceways, the ball ahead, and the reaction to the one behind."""
    bearing, out = full
    ahead = out.neighbour_load[..., None] * out.neighbour_normal + out.neighbour_friction
    assert np.abs(integral(ahead)).max() > 1e-3 * bearing.ball_mass * np.abs(out.velocity).max()
    after = np.roll(out.position, -1, axis=1)
    turning = np.cross(out.neighbour_point - out.position, ahead)
    behind = np.cross(out.neighbour_point - after, -ahead)
    weight = bearing.ball_mass * np.array(bearing.gravity)
    force = out.raceway_force + weight + ahead - np.roll(ahead, 1, axis=1)
    change = bearing.ball_mass * (out.velocity[-1] - out.velocity[0])
    assert integral(force) == pytest.approx(change, abs=1e-3 * np.abs(change).max())
    torque = out.raceway_torque + turning + np.roll(behind, 1, axis=1)
    change = bearing.ball_inertia * (out.angular_velocity[-1] - out.angular_velocity[0])
    assert integral(torque) == pytest.approx(change, abs=1e-3 * np.abs(change).max())


@pytest.fixture(scope="module")
def thrust():
    """A scene whose contacts are inclined, and one block of its run."""
    scene = load_scene("bearing_6203", ["drive.offset=[3.0e-6, -2.0e-6, 4.0e-5]"])
    return scene, Simulation(scene).advance(3)


def long_axes(scene, sample):
    """What two implicit surfaces, a ball and a ring's groove, say of their contact: unit vectors (balls, 2, 3)."""
    geometry, axes = scene.parameters.geometry, np.zeros((scene.parameters.geometry.balls, 2, 3))
    radius = 0.5 * geometry.ball_diameter
    rings = (
        (-1.0, geometry.inner_conformity, sample["inner_ring_offset"]), (1.0, geometry.outer_conformity, np.zeros(3))
    )  # fmt: skip
    for side, conformity, centre in rings:
        groove = conformity * geometry.ball_diameter
        bottom = 0.5 * geometry.pitch_diameter + side * (radius + 0.25 * geometry.radial_clearance)
        ring = body_of(torus(bottom - side * groove, groove, hollow=True), centre)
        raceway = 0 if side < 0.0 else 1
        for k, position in enumerate(sample["position"]):
            ball = body_of(sphere(radius), position)
            contact = contact_of(ball, ring, find_opposing(ball, ring, sample["point"][k, raceway]))
            assert contact.approach == pytest.approx(sample["approach"][k, raceway], abs=1e-12)
            assert contact.curvature_small < 0.3 * contact.curvature_large
            axes[k, raceway] = contact.major_axis
    return axes


def first_message(scene, block, ros_type):
    """The first message of one type in a block."""
    pairs = MessageStream(scene, choice=a_choice()).messages(block)
    return next(cdr.deserialise(topic.ros_type, data) for topic, _, data in pairs if topic.ros_type == ros_type)


def test_the_long_axis_of_an_ellipse_lies_across_the_groove_in_message_and_marker(thrust):
    scene, block = thrust
    sample, first = block[0], long_axes(scene, block[0])
    assert np.all(np.abs(sample["contact_angle"]) > 0.03)
    assert np.abs(first[..., 2]).min() > 0.9  # nearly along the bearing's axis
    contacts = first_message(scene, block, cdr.CONTACTS)
    rows = first[..., 0].size  # ball after ball, inner before outer; behind them balls with their neighbours
    reported = contacts.major_axis.reshape(-1, 3)[:rows].reshape(first.shape)
    assert np.abs(np.einsum("krv,krv->kr", reported, first)) == pytest.approx(1.0, abs=1e-6)
    semi_major, semi_minor = (axis[:rows].reshape(-1, 2) for axis in (contacts.semi_major, contacts.semi_minor))
    assert np.all(semi_major > 5.0 * semi_minor)
    [outline] = [m for m in first_message(scene, block, cdr.MARKERS).markers if m.ns == "contact_ellipses"]
    corners = np.array([[p.x, p.y, p.z] for p in outline.points]).reshape(len(first), 2, -1, 3)
    from_centre = corners - sample["point"][:, :, None]
    length = np.linalg.norm(from_centre, axis=-1)
    tips = np.take_along_axis(from_centre, length.argmax(axis=2)[..., None, None], axis=2)[:, :, 0]
    longest = length.max(axis=2)
    assert np.abs(np.einsum("krv,krv->kr", tips, first)) == pytest.approx(longest, rel=1e-6)
    assert longest == pytest.approx(10.0 * semi_major, rel=1e-9)
    assert length.min(axis=2) == pytest.approx(10.0 * semi_minor, rel=1e-9)
    assert np.abs(np.einsum("krnv,krv->krn", from_centre, sample["normal"])).max() < 1e-9 * longest.max()


ROUNDING = 1e-12  # of the sum of magnitudes


def touching_balls(axial=0.0):
    """13 balls of a bearing with friction over the spots, each but the last pressed against the next, and spinning.

    They stand `axial` [m] off the middle, in turn to either side.
    """
    tight = ("geometry.radial_clearance=0.0", "drive.offset=[0.0, 4e-6, 2e-6]")
    moving = motion("geometry.balls=13", "contact.friction=spot", *tight, scene="bearing_6203_loose")
    state, bearing = moving.state, moving.bearing
    random = np.random.default_rng(5)
    state[:, AXIS_DISTANCE] = 0.5 * moving.parameters.geometry.pitch_diameter + 1e-6
    pitch_angle = 2.0 * np.arcsin((bearing.ball_radius - 1e-6) / state[0, AXIS_DISTANCE])
    state[:, HEIGHT] += axial * (-1.0) ** np.arange(13)
    state[:, ORBIT_ANGLE] = 0.3 + pitch_angle * np.arange(13)
    state[:, VELOCITY:MOTION] += random.normal(size=(13, 6)) * ([1e-3] * 3 + [50.0] * 3)
    return moving, Sample(0, 0, moving.first_outputs().rows(0))


def loads_of(rows, origin):
    """Forces and torques of bodies about their origins, summed from contacts; and sums (2, ..., bodies, 1) of sizes."""
    origins_of_bodies = np.stack([origin[body] for body in rows["bodies"]], axis=-2)
    push = rows["normal_load"][..., None] * rows["normal"] + rows["friction_force"]
    drill = rows["drilling_torque"][..., None] * rows["normal"]
    force, torque, sizes = (
        np.zeros(origins_of_bodies.shape),
        np.zeros(origins_of_bodies.shape),
        np.zeros((2, *origins_of_bodies.shape[:-1], 1)),
    )
    for row, pair in enumerate(zip(rows["body"], rows["by"], strict=True)):
        for body, sign in zip(pair, (1.0, -1.0), strict=True):
            arm = rows["point"][..., row, :] - origins_of_bodies[..., body, :]
            force[..., body, :] += sign * push[..., row, :]
            torque[..., body, :] += sign * (np.cross(arm, push[..., row, :]) + drill[..., row, :])
            size = np.linalg.norm(push[..., row, :], axis=-1, keepdims=True)
            sizes[0][..., body, :] += size
            sizes[1][..., body, :] += np.linalg.norm(arm, axis=-1, keepdims=True) * size
    return force, torque, sizes


def tilted_ring(scene, *overrides):
    """Parameters of a bearing whose inner ring is tilted, and its last output."""
    sample = run_all(scene, *overrides)[1][-1]
    assert np.abs(sample["inner_ring_tilt"]).max() > 1e-6
    return load_scene(scene, overrides).parameters, sample


def balls_that_touch():
    """Parameters of `touching_balls` and their output, in which all contacts bear and rub."""
    moving, sample = touching_balls()
    rows = contacts(moving.parameters, sample)
    assert np.count_nonzero(rows["normal_load"][26:]) == 12
    assert np.abs(rows["drilling_torque"][1:26:2]).min() > 0.0
    assert np.count_nonzero(rows["drilling_torque"][:26:2]) >= 5
    assert np.linalg.norm(rows["friction_force"][26:38], axis=1).min() > 0.0
    return moving.parameters, sample


@pytest.mark.parametrize(
    "make",
    [
        balls_that_touch,
        lambda: tilted_ring("bearing_6203_tilted", "run.duration=0.005"),
        lambda: tilted_ring("bearing_6203_step_load", "run.duration=0.015"),
        lambda: tilted_ring("bearing_6205_spall_outer", "run.duration=0.02", "rings.inner.moment=[0.3,0.1]"),
    ],
    ids=["balls that touch", "ring held at a tilt", "free ring", "both rings free"],
)
def test_contacts_of_each_body_add_up_to_its_wrench_and_all_wrenches_to_zero(make):
    parameters, sample = make()
    rows, origins_of_bodies = contacts(parameters, sample), origins(parameters, sample)
    force, torque, size = loads_of(rows, origins_of_bodies)
    by_body = wrenches(parameters, sample)
    assert [wrench.body for wrench in by_body] == rows["bodies"]
    assert max(np.linalg.norm(wrench.torque) for wrench in by_body) > 1e-5
    for body, wrench in enumerate(by_body):
        assert np.abs(wrench.force - force[body]).max() <= ROUNDING * size[0, body]
        assert np.abs(wrench.torque - torque[body]).max() <= ROUNDING * size[1, body]
    turning = sum(wrench.torque + np.cross(origins_of_bodies[wrench.body], wrench.force) for wrench in by_body)
    assert np.abs(sum(wrench.force for wrench in by_body)).max() < ROUNDING * size[0].sum()
    assert np.abs(turning).max() < ROUNDING * size[1].sum()


def outputs_of(name, *overrides, count=300):
    """The first `count` outputs of a scene, its topics, and where these place the frames of the bodies."""
    scene = load_scene(name, overrides)
    output = Output(scene.parameters, "hertz", Simulation(scene).advance(count).sample_rows(range(count)))
    table = {topic.name: topic for topic in KINDS[scene.kind].topics(scene.parameters)}
    frames = table["/tf"].fields(output)["transforms"]
    return output, table, {frame["child_frame_id"]: frame["transform"]["translation"] for frame in frames}


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("two_spheres", ("second.radius=0.03", "second.mass=0.0", "contact.restitution=0.8")),
        ("two_discs", ()),
        ("sphere_on_beam", ("blow.point=0.3",)),
        ("soft_discs_mean", ("mesh.divisions=8",)),
        ("soft_discs_fast", ("mesh.divisions=8",)),
        ("soft_discs_unequal", ("mesh.divisions=8",)),
        ("ellipsoid_rocking", ("contact.friction=spot", "run.output_rate=100000.0", "start.height=1e-5")),
        (
            "two_bodies_ellipsoid",
            ("contact.friction=spot", "run.output_rate=100000.0", "first.position=[0,0,0.01476]"),
        ),
    ],
)
def test_the_bodies_of_other_kinds_answer_each_other(name, overrides):
    """Contacts add up to wrenches and those to zero, at every output."""
    output, table, positions = outputs_of(name, *overrides)
    rows = table["contacts"].fields(output)
    force, torque, size = loads_of(rows, positions)
    assert np.count_nonzero(rows["normal_load"]) > 10
    for body, name in enumerate(rows["bodies"]):
        wrench = table[f"{name}/wrench"].fields(output)["wrench"]
        assert np.all(np.abs(wrench["force"] - force[:, body]) <= ROUNDING * size[0, :, body])
        assert np.all(np.abs(wrench["torque"] - torque[:, body]) <= ROUNDING * (size[0] + size[1])[:, body])


@pytest.mark.parametrize(
    ("name", "overrides", "radii"),
    [
        ("two_spheres", ("second.radius=0.03", "second.mass=0.0"), {"first": 0.01905, "second": 0.03}),
        ("sphere_on_beam", ("blow.point=0.3",), {"sphere": 0.01}),
    ],
)
def test_the_point_of_contact_lies_half_an_approach_inside_round_bodies(name, overrides, radii):
    output, table, positions = outputs_of(name, *overrides)
    rows = table["contacts"].fields(output)
    loaded = rows["approach"][:, 0] > 0.0
    assert loaded.any()
    for body, radius in radii.items():
        inside = radius - np.linalg.norm(rows["point"][:, 0] - positions[body], axis=-1)
        assert inside[loaded] == pytest.approx(0.5 * rows["approach"][loaded, 0], rel=1e-6, abs=1e-15)


def test_the_pressure_on_the_line_of_contact_of_two_discs_carries_their_load():
    """p0 sqrt(1 - x^2/b^2) over the length of the discs; its half-width as in Johnson, Contact Mechanics."""
    output, table, _ = outputs_of("two_discs")
    rows, disc = table["contacts"].fields(output), output.parameters.disc
    loaded = rows["normal_load"] > 0.0
    load, half_length, half_width, pressure = (
        rows[name][loaded] for name in ("normal_load", "semi_major", "semi_minor", "peak_pressure")
    )
    assert len(load) > 10
    assert 2.0 * half_length == pytest.approx(disc.thickness)
    assert 0.5 * math.pi * pressure * half_width * 2.0 * half_length == pytest.approx(load)
    compliance = 2.0 * (1.0 - disc.material.poisson_ratio**2) / disc.material.young_modulus  # 1/E*
    assert half_width == pytest.approx(np.sqrt(2.0 * load / disc.thickness * disc.radius * compliance / math.pi))


def test_the_pose_of_the_inner_ring_places_the_groove_that_its_balls_see():
    """A ring tilted by a moment: inner contacts lie a groove's radius from where the pose puts the groove's centre."""
    keys = "rings.inner.load=[20,-300,100]", "rings.inner.moment=[0.6,-0.3]"
    output, table, positions = outputs_of("bearing_6203", *keys, count=40)
    pose = {name: values[-1] for name, values in table["inner_ring/pose"].fields(output)["pose"].items()}
    sample = {name: values[-1] for name, values in output.sample.values.items()}
    setting = setting_of(output.parameters, "hertz", 0.0)
    assert np.linalg.norm(sample["inner_ring_tilt"]) > 1e-4
    assert sample["inner_ring_angle"] > 0.5
    turned = Rotation.from_rotvec([0.0, 0.0, sample["inner_ring_angle"]])
    tilt = Rotation.from_quat(pose["orientation"]) * turned.inv()
    assert tilt.as_rotvec() == pytest.approx([*sample["inner_ring_tilt"], 0.0], abs=1e-15)
    azimuths = sample["orbit_angle"]
    circle = np.stack([np.cos(azimuths), np.sin(azimuths), np.zeros(8)], axis=-1)
    reach = setting.inner.groove_radius + 0.5 * sample["approach"][:, 0]

    def distance(tilt):
        groove = pose["position"] + tilt.apply(setting.inner.locus_radius * circle)
        return np.abs(np.linalg.norm(sample["point"][:, 0] - groove, axis=-1) - reach).max()

    assert distance(tilt) < 1e-7
    assert distance(tilt.inv()) > 1e-6
    assert np.array_equal(positions["inner_ring"][-1], pose["position"])


def test_the_pose_of_an_ellipsoid_places_its_contact_point():
    """The point of contact, in the body's own axes, lies on its surface."""
    output, table, _ = outputs_of("ellipsoid_tumbling", count=400)
    pose, axes = table["pose"].fields(output)["pose"], np.array(output.parameters.body.semi_axes)
    point = table["contacts"].fields(output)["point"][:, 0]
    in_body = Rotation.from_quat(pose["orientation"]).inv().apply(point - pose["position"])
    assert np.sum((in_body / axes) ** 2, axis=1) == pytest.approx(1.0, abs=1e-3)
