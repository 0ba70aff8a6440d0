"""The topic table and the stream of messages made from it."""

from types import SimpleNamespace

import numpy as np
import pytest
from runs import a_choice, made_up_block, made_up_scene

from bearing_twin.base.sample import Columns
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.bearing.outputs import contact_details, origins, wrenches
from bearing_twin.kinds.contract import MARKERS, PUBLISH, Output
from bearing_twin.log import cdr
from bearing_twin.log.cdr import Encoder, encode
from bearing_twin.log.stream import MessageStream, block_of, topics
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation


def stream_of(scene, blocks, **options):
    stream = MessageStream(scene, choice=a_choice(), **options)
    messages = [message for block in blocks for message in stream.messages(block)]
    return [*messages, *stream.flush()]


def named(messages, name):
    return [(stamp, cdr.deserialise(topic.ros_type, data)) for topic, stamp, data in messages if topic.name == name]


def test_contacts_state_and_joints_are_the_sample():
    scene = made_up_scene(balls=2)
    block = made_up_block(scene, 11, seed=4)
    sample, details = block[10], contact_details(scene.parameters, block[10])
    messages = stream_of(scene, [block])
    _, contacts = named(messages, "contacts")[1]
    assert (contacts.sequence, contacts.law, contacts.balls) == (10, "hertz", 2)
    assert contacts.bodies == ["ball_0", "ball_1", "inner_ring", "outer_ring"]
    assert contacts.body.tolist() == [0, 0, 1, 1, 0, 1]
    assert contacts.by.tolist() == [2, 3, 2, 3, 1, 0]
    for values, names in (
        (sample, ("normal_load", "approach", "slip", "contact_angle")),
        (details, ("semi_major", "semi_minor", "peak_pressure", "in_contact")),
    ):
        for name in names:
            assert getattr(contacts, name)[: values[name].size].tobytes() == values[name].tobytes()
    assert contacts.normal_load[4:].tobytes() == sample["neighbour_load"].tobytes()
    assert contacts.friction_force[12:].tobytes() == sample["neighbour_friction"].tobytes()
    for name in ("spin_rate", "drilling_torque"):
        # `normal` looks from the raceway to the ball, the channels count about the line the other way.
        assert getattr(contacts, name)[:4].tolist() == (-sample[name]).ravel().tolist()
    _, state = named(messages, "state")[1]
    x, v = sample["position"], sample["velocity"]
    rates = (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]) / (x[:, 0] ** 2 + x[:, 1] ** 2)
    assert state.cage_speed == pytest.approx(rates.mean())
    assert (state.drive_torque, state.dissipated) == (sample["drive_torque"], sample["dissipated"])
    assert state.orientation.tobytes() == sample["orientation"].tobytes()
    _, joints = named(messages, "joint_states")[1]
    assert joints.name == ["inner_ring_joint", "ball_0_orbit_joint", "ball_1_orbit_joint"]
    assert joints.position.tolist() == [sample["inner_ring_angle"], *sample["orbit_angle"]]
    assert joints.velocity == pytest.approx([sample["inner_ring_speed"], *rates])


@pytest.mark.parametrize("prefix", ["", "left/"])
def test_frames_stand_where_the_wrenches_are_taken(prefix):
    """And wrenches are those of the sample."""
    scene = made_up_scene(balls=2)
    block = made_up_block(scene, 1)
    messages = stream_of(scene, [block], frame_prefix=prefix)
    [(_, tf)] = named(messages, "/tf")
    placed = {transform.child_frame_id: transform for transform in tf.transforms}
    assert list(placed) == [f"{prefix}{name}" for name in ("ball_0", "ball_1", "inner_ring", "outer_ring")]
    taken = {wrench.body: wrench for wrench in wrenches(scene.parameters, block[0])}
    for name, origin in origins(scene.parameters, block[0]).items():
        transform = placed[f"{prefix}{name}"].transform
        assert [transform.translation.x, transform.translation.y, transform.translation.z] == origin.tolist()
        assert (transform.rotation.x, transform.rotation.y, transform.rotation.z, transform.rotation.w) == (0, 0, 0, 1)
        [(_, message)] = named(messages, f"{name}/wrench")
        assert message.header.frame_id == f"{prefix}{name}"
        for part in ("force", "torque"):
            vector = getattr(message.wrench, part)
            assert [vector.x, vector.y, vector.z] == getattr(taken[name], part).tolist()
    assert {transform.header.frame_id for transform in tf.transforms} == {f"{prefix}bearing_link"}
    [(_, array)] = named(messages, "markers")
    assert {marker.header.frame_id for marker in array.markers} == {f"{prefix}bearing_link"}
    [(_, samples)] = named(messages, "samples")
    assert samples.header.frame_id == f"{prefix}bearing_link"


def test_samples_hold_every_output():
    scene = made_up_scene()
    block = made_up_block(scene, 120)
    blocks = [message for _, message in named(stream_of(scene, [block]), "samples")]
    assert [(b.first_sequence, b.count) for b in blocks] == [(0, 50), (50, 50), (100, 20)]
    assert np.concatenate([b.values for b in blocks]).tobytes() == block.matrix().tobytes()
    assert np.concatenate([b.time_ns for b in blocks]).tolist() == block.time_ns.tolist()
    assert [b.header.stamp.nanosec for b in blocks] == [0, 50_000_000, 100_000_000]


@pytest.mark.parametrize(
    ("output_rate", "publish_rate", "published", "slow", "block_outputs"),
    [
        (1000.0, 100.0, 10, 50, 50),
        (1000.0, 1000.0, 1, 50, 50),
        (1000.0, 250.0, 4, 50, 50),
        (10.0, 10.0, 1, 1, 1),
        (120.0, 20.0, 6, 6, 6),
    ],
)
def test_rates(output_rate, publish_rate, published, slow, block_outputs):
    scene = made_up_scene(output_rate=output_rate, publish_rate=publish_rate)
    messages = stream_of(scene, [made_up_block(scene, 101)])
    period = round(1e9 / output_rate)
    assert [stamp for stamp, _ in named(messages, "state")] == [k * period for k in range(0, 101, published)]
    assert [stamp for stamp, _ in named(messages, "markers")] == [k * period for k in range(0, 101, slow)]
    firsts = [message.first_sequence for _, message in named(messages, "samples")]
    assert firsts == list(range(0, 101, block_outputs))


def test_messages_come_in_order_of_time_and_table():
    scene = made_up_scene()
    messages = stream_of(scene, [made_up_block(scene, 101)])
    stamps = [stamp for _, stamp, _ in messages]
    assert stamps == sorted(stamps)
    order = [topic.name for topic in topics(scene)]
    assert [topic.name for topic, stamp, _ in messages if stamp == 50_000_000] == order[2:-2]


def test_start_time_moves_stamps_but_not_the_samples_own_times():
    scene = made_up_scene()
    block = made_up_block(scene, 51)
    moved, plain = stream_of(scene, [block], start_time_ns=5_000_000_123), stream_of(scene, [block])
    assert [stamp - 5_000_000_123 for _, stamp, _ in moved] == [stamp for _, stamp, _ in plain]
    _, message = named(moved, "samples")[0]
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (5, 123)
    assert message.time_ns.tolist() == block.time_ns[:50].tolist()


def test_reset_closes_the_block_in_progress():
    scene = made_up_scene()
    messages = stream_of(scene, [made_up_block(scene, 60), made_up_block(scene, 30, seed=2)])
    blocks = [(m.first_sequence, m.count) for _, m in named(messages, "samples")]
    assert blocks == [(0, 50), (50, 10), (0, 30)]


def test_markers():
    """Balls stand where they are; arrows are as long as loads, their tips at contacts."""
    scene = made_up_scene(balls=2)
    block, diameter = made_up_block(scene, 7, seed=3), scene.parameters.geometry.ball_diameter
    [topic] = (row for row in topics(scene) if row.name == "markers")
    markers = topic.fields(Output(scene.parameters, "hertz", block.sample_rows(range(7))))["markers"]
    marker = {(entry["ns"], entry["id"]): entry for entry in markers}
    assert len(marker) == len(markers)
    assert marker["balls", 0]["points"] == pytest.approx(block.values["position"])
    assert marker["balls", 0]["scale"] == (diameter,) * 3
    loads = block.values["normal_load"]
    arrows = marker["loads", 0]["points"].reshape(*loads.shape, 6, 3)
    assert arrows[..., 1, :] == pytest.approx(block.values["point"])
    greatest = loads.max(axis=(1, 2))
    lengths = np.linalg.norm(arrows[..., 1, :] - arrows[..., 0, :], axis=-1)
    assert lengths * greatest[:, None, None] == pytest.approx(diameter * loads, abs=1e-9 * diameter)


def without_rows(values):
    """Fields of one message of those of many that are one."""
    if isinstance(values, dict):
        return {name: without_rows(value) for name, value in values.items()}
    if isinstance(values, list) and values and isinstance(values[0], dict):
        return [without_rows(value) for value in values]
    first = values[0] if isinstance(values, np.ndarray) else values
    return first.decode() if isinstance(first, bytes) else first


MANY = {  # scenes of all kinds, and of bearings that differ in their topics
    "bearing_6203_loose": ["geometry.balls=11"],
    "bearing_6203_guided_cage": [],
    "shaft_angular_pair": [],
    "two_spheres": [],
    "two_discs": [],
    "sphere_on_beam": [],
    "ellipsoid_rocking": ["start.height=1e-5"],
    "two_bodies_groove": [],
    "soft_discs_mean": ["mesh.divisions=4"],
    "soft_discs_unequal": ["mesh.divisions=4"],
}


@pytest.mark.parametrize("name", [*MANY, "neighbours"])
def test_many_messages_at_once_are_those_one_by_one(name):
    """One of the blocks is made up: balls touch in it."""
    scene = load_scene(name, MANY[name]) if name in MANY else made_up_scene(balls=3)
    block = Simulation(scene).advance(40) if name in MANY else made_up_block(scene, 40)
    rows = range(3, 40, 4)
    for topic in KINDS[scene.kind].topics(scene.parameters):
        if topic.rate not in (PUBLISH, MARKERS):
            continue
        several, encoder = (
            Output(scene.parameters, "hertz", block.sample_rows(rows)),
            Encoder(topic.ros_type, topic.frame),
        )
        outputs = (Output(scene.parameters, "hertz", block.sample_rows(range(row, row + 1))) for row in rows)
        stamps = 5 + several.sample.time_ns
        alone = [
            encode(topic.ros_type, without_rows(topic.fields(output)), int(stamp), topic.frame)
            for output, stamp in zip(outputs, stamps, strict=True)
        ]
        for _ in range(2):  # laid out, then by the layout kept
            assert encoder.encode(topic.fields(several), stamps) == alone


@pytest.mark.parametrize("dimension", ["prescribed", "quasi_static"])
def test_inner_contact_angles_of_old_logs_have_the_sign_of_todays(dimension):
    """They counted towards +z as seen from the ball; what is of today stays as it is, to the bit."""
    keys = [f"model.dimension={dimension}", "drive.offset=[0,-2e-6,3e-5]"]
    simulation = Simulation(load_scene("bearing_6203", keys))
    block = simulation.advance(3)
    angle = block.values["contact_angle"]
    assert angle.min() > 0.05  # pushed along +z, on both raceways
    old = block.values.numbers.copy()
    Columns(block.values.layout, old)["contact_angle"][..., 0] *= -1.0
    for numbers in (old, block.values.numbers):
        message = SimpleNamespace(values=numbers.ravel(), count=3, first_sequence=0, time_ns=block.time_ns)
        assert block_of(block.channels, message).values.numbers.tobytes() == block.values.numbers.tobytes()
    assert (Columns(block.values.layout, old)["contact_angle"][..., 0] < 0.0).all()
