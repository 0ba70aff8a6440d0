"""Action and reaction: the contacts of a body add up to its wrench, and all wrenches add up to zero."""

import math

import numpy as np
import pytest
from bearings import motion
from by_rosbags import serialise
from scipy.spatial.transform import Rotation

from bearing_twin.kinds import KINDS
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, HEIGHT, MOTION, ORBIT_ANGLE, VELOCITY
from bearing_twin.kinds.bearing.loads import contacts, origins, wrenches
from bearing_twin.kinds.bearing.quasi_static.statics import setting_of
from bearing_twin.kinds.contract import Output
from bearing_twin.kinds.topics import CONTACTS, TRANSFORMS, WRENCH
from bearing_twin.log import cdr
from bearing_twin.log.stream import MessageStream
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation
from bearing_twin.sample import Sample

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
    apart = 2.0 * np.arcsin((bearing.ball_radius - 1e-6) / state[0, AXIS_DISTANCE])
    state[:, HEIGHT] += axial * (-1.0) ** np.arange(13)
    state[:, ORBIT_ANGLE] = 0.3 + apart * np.arange(13)
    state[:, VELOCITY:MOTION] += random.normal(size=(13, 6)) * ([1e-3] * 3 + [50.0] * 3)
    return moving, Sample(0, 0, moving.first_outputs().rows(0))


def loads_of(rows, origin):
    """Force and torque of each body about its origin, summed from the rows of contacts; and sums of magnitudes."""
    force, torque = np.zeros((len(rows["bodies"]), 3)), np.zeros((len(rows["bodies"]), 3))
    size = np.zeros((2, len(rows["bodies"])))
    count = len(rows["body"])
    columns = {name: np.reshape(rows[name], (count, -1)) for name in ("normal", "friction_force", "point")}
    numbers = {name: np.reshape(rows[name], count) for name in ("normal_load", "drilling_torque")}
    for row in range(count):
        push = numbers["normal_load"][row] * columns["normal"][row] + columns["friction_force"][row]
        drill = numbers["drilling_torque"][row] * columns["normal"][row]
        for body, sign in ((rows["body"][row], 1.0), (rows["by"][row], -1.0)):
            arm = columns["point"][row] - origin[rows["bodies"][body]]
            force[body] += sign * push
            torque[body] += sign * (np.cross(arm, push) + drill)
            size[:, body] += np.linalg.norm(push), np.linalg.norm(arm) * np.linalg.norm(push)
    return force, torque, size


def test_contacts_of_each_body_add_up_to_its_wrench():
    moving, sample = touching_balls()
    rows, places = contacts(moving.parameters, sample), origins(moving.parameters, sample)
    assert np.count_nonzero(rows["normal_load"][26:]) == 12
    assert np.abs(rows["drilling_torque"][1:26:2]).min() > 0.0
    assert np.count_nonzero(rows["drilling_torque"][:26:2]) >= 5
    assert np.linalg.norm(rows["friction_force"][26:38], axis=1).min() > 0.0
    force, torque, size = loads_of(rows, places)
    for body, wrench in enumerate(wrenches(moving.parameters, sample)):
        assert wrench.body == rows["bodies"][body]
        assert np.abs(wrench.force - force[body]).max() < ROUNDING * size[0, body]
        assert np.abs(wrench.torque - torque[body]).max() < ROUNDING * size[1, body]


def test_all_wrenches_of_a_bearing_add_up_to_zero():
    moving, sample = touching_balls()
    places, found = origins(moving.parameters, sample), wrenches(moving.parameters, sample)
    assert sum(np.linalg.norm(wrench.torque) for wrench in found) > 1e-3
    assert np.abs(sum(wrench.force for wrench in found)).max() < ROUNDING * sum(
        np.linalg.norm(wrench.force) for wrench in found
    )
    turning = sum(wrench.torque + np.cross(places[wrench.body], wrench.force) for wrench in found)
    assert np.abs(turning).max() < ROUNDING * sum(
        np.linalg.norm(places[wrench.body]) * np.linalg.norm(wrench.force) for wrench in found
    )


def outputs_of(name, *overrides, count=300):
    """Outputs of the first `count` instants of a scene, as topics see them."""
    scene = load_scene(name, overrides)
    simulation = Simulation(scene)
    block = simulation.advance(count)
    return scene, [Output(scene.parameters, simulation.choice.law, sample) for sample in block]


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
    """Contacts add up to wrenches and those to zero, at every output with a load."""
    scene, outputs = outputs_of(name, *overrides, count=300)
    table = KINDS[scene.kind].topics(scene.parameters)
    wrench_rows = [row for row in table if row.ros_type == WRENCH]
    [contact_row] = [row for row in table if row.ros_type == CONTACTS]
    [frames] = [row for row in table if row.ros_type == TRANSFORMS]
    loaded = 0
    for output in outputs:
        rows = contact_row.fields(output)
        if not rows["normal_load"][0] > 0.0:
            continue
        loaded += 1
        placed = {
            one["child_frame_id"]: np.array(one["transform"]["translation"])
            for one in frames.fields(output)["transforms"]
        }
        force, torque, size = loads_of(rows, placed)
        for body, row in enumerate(wrench_rows):
            assert row.name == f"{rows['bodies'][body]}/wrench"
            wrench = row.fields(output)["wrench"]
            assert np.abs(wrench["force"] - force[body]).max() <= ROUNDING * size[0, body]
            assert np.abs(wrench["torque"] - torque[body]).max() <= ROUNDING * (size[1, body] + size[0, body])
    assert loaded > 5


@pytest.mark.parametrize(
    "name", ["two_spheres", "two_discs", "sphere_on_beam", "ellipsoid_on_plane", "soft_discs_mean", "bearing_6203"]
)
def test_every_topic_of_a_kind_is_a_message(name):
    scene = load_scene(name)
    stream, seen = MessageStream(scene), set()
    block = Simulation(scene).advance(2)
    for topic, _, data in (*stream.messages(block), *stream.flush()):
        assert serialise(topic.ros_type, cdr.deserialise(topic.ros_type, data)) == data
        seen.add(topic.row.name)
    for row in KINDS[scene.kind].topics(scene.parameters):
        assert row.name in seen
        assert row.frame or row.name == "robot_description"


@pytest.mark.parametrize(
    ("name", "overrides", "radii"),
    [
        ("two_spheres", ("second.radius=0.03", "second.mass=0.0"), {"first": 0.01905, "second": 0.03}),
        ("sphere_on_beam", ("blow.point=0.3",), {"sphere": 0.01}),
    ],
)
def test_the_point_of_contact_lies_half_an_approach_inside_round_bodies(name, overrides, radii):
    scene, outputs = outputs_of(name, *overrides)
    kind = KINDS[scene.kind].topics(scene.parameters)
    contact, frames = (next(row for row in kind if row.ros_type == one) for one in (CONTACTS, TRANSFORMS))
    output = max(outputs, key=lambda one: one.sample["normal_load"])
    fields, transforms = contact.fields(output), frames.fields(output)["transforms"]
    placed = {one["child_frame_id"]: one["transform"]["translation"] for one in transforms}
    assert fields["approach"][0] > 0.0
    for body, radius in radii.items():
        inside = radius - np.linalg.norm(fields["point"][0] - placed[body])
        assert inside == pytest.approx(0.5 * fields["approach"][0], rel=1e-6)


def test_the_pressure_on_the_line_of_contact_of_two_discs_carries_their_load():
    """p0 sqrt(1 - x^2/b^2) over the length of the discs; its half-width as in Johnson, Contact Mechanics."""
    scene, outputs = outputs_of("two_discs")
    [row] = [row for row in KINDS["two_discs"].topics(scene.parameters) if row.ros_type == CONTACTS]
    fields, disc = row.fields(max(outputs, key=lambda one: one.sample["normal_load"])), scene.parameters.disc
    load, half_length, half_width, pressure = (
        fields[name][0] for name in ("normal_load", "semi_major", "semi_minor", "peak_pressure")
    )
    assert load > 0.0
    assert 2.0 * half_length == pytest.approx(disc.thickness)
    assert 0.5 * math.pi * pressure * half_width * 2.0 * half_length == pytest.approx(load)
    compliance = 2.0 * (1.0 - disc.material.poisson_ratio**2) / disc.material.young_modulus  # 1/E*
    assert half_width == pytest.approx(math.sqrt(2.0 * load / disc.thickness * disc.radius * compliance / math.pi))


def test_the_pose_of_the_inner_ring_places_the_groove_that_its_balls_see():
    """A ring tilted by a moment: inner contacts lie a groove's radius from where the pose puts the groove's centre."""
    scene, outputs = outputs_of(
        "bearing_6203", "rings.inner.load=[20,-300,100]", "rings.inner.moment=[0.6,-0.3]", count=40
    )
    table = {row.name: row for row in KINDS[scene.kind].topics(scene.parameters)}
    sample, setting = outputs[-1].sample, setting_of(scene.parameters, "hertz", 0.0)
    assert np.linalg.norm(sample["inner_ring_tilt"]) > 1e-4
    assert sample["inner_ring_angle"] > 0.5
    pose = table["inner_ring/pose"].fields(outputs[-1])["pose"]
    turned = Rotation.from_rotvec([0.0, 0.0, sample["inner_ring_angle"]])
    tilt = Rotation.from_quat(pose["orientation"]) * turned.inv()
    assert tilt.as_rotvec() == pytest.approx([*sample["inner_ring_tilt"], 0.0], abs=1e-15)
    azimuths = sample["orbit_angle"]
    around = np.stack([np.cos(azimuths), np.sin(azimuths), np.zeros(8)], axis=-1)
    reach = setting.inner.groove_radius + 0.5 * sample["approach"][:, 0]

    def off(tilt):
        groove = pose["position"] + tilt.apply(setting.inner.locus_radius * around)
        return np.abs(np.linalg.norm(sample["point"][:, 0] - groove, axis=-1) - reach).max()

    assert off(tilt) < 1e-7
    assert off(tilt.inv()) > 1e-6
    (frame,) = (one for one in table["/tf"].fields(outputs[-1])["transforms"] if one["child_frame_id"] == "inner_ring")
    assert np.array_equal(frame["transform"]["translation"], pose["position"])


def test_the_pose_of_an_ellipsoid_places_its_contact_point():
    """The point of contact, in the body's own axes, lies on its surface."""
    scene, outputs = outputs_of("ellipsoid_tumbling", count=400)
    table = {row.name: row for row in KINDS[scene.kind].topics(scene.parameters)}
    axes = np.array(scene.parameters.body.semi_axes)
    for output in outputs[::50]:
        pose = table["pose"].fields(output)["pose"]
        point = table["contacts"].fields(output)["point"][0]
        own = Rotation.from_quat(pose["orientation"]).inv().apply(point - pose["position"])
        assert np.sum((own / axes) ** 2) == pytest.approx(1.0, abs=1e-3)
