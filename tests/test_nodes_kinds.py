"""Every kind of scene on the wire: played by sim_node, logged by recorder_node, played again by replay_node."""

import time

import pytest
from ros import (
    SetBool,
    call,
    deserialize_message,
    heard,
    interface,
    padded,
    plain_node,
    ros_executor,
    spin_for,
    spin_until,
    started,
)

from bearing_twin.kinds import KINDS, SHIPPED
from bearing_twin.log import cdr
from bearing_twin.log.bag import raw_messages
from bearing_twin.log.run_log import read_log, write_log
from bearing_twin.log.stream import topics
from bearing_twin.nodes.recorder_node import RecorderNode
from bearing_twin.nodes.replay_node import ReplayNode
from bearing_twin.nodes.sim_node import SimNode
from bearing_twin.run.report import report_of
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate
from bearing_twin.run.verify import verify

# A scene a kind, short, and a pace at which a wire can follow.
PLAYED = {
    "bearing": ("bearing_6203", ("run.duration=0.1",), 1.0),
    "shaft": ("shaft_two_6203", ("run.duration=0.05",), 1.0),
    "two_spheres": ("two_spheres", ("run.output_rate=5e6", "run.publish_rate=1e6"), 2e-4),
    "two_discs": ("two_discs", ("run.output_rate=40e3", "run.publish_rate=4e3"), 1e-2),
    "sphere_on_beam": ("sphere_on_beam", ("run.output_rate=500e3", "run.publish_rate=50e3"), 1e-2),
    "soft_discs": ("soft_discs_mean", ("mesh.divisions=8", "mesh.order=2", "run.publish_rate=500.0"), 0.1),
    "ellipsoid_on_plane": (
        "ellipsoid_rocking", ("run.duration=0.05", "run.publish_rate=1000.0", "start.height=1e-3"), 0.2,
    ),
    "two_bodies": ("two_bodies_groove", ("run.duration=0.02", "run.publish_rate=1000.0"), 0.1),
}  # fmt: skip


COMMANDS = {"command/speed", "command/speed_stamped", "command/torque", "command/load"}


def scene_of(kind):
    """The scene as a node runs it: without a second run."""
    name, overrides, _ = PLAYED[kind]
    return load_scene(name, [*overrides, "solver.check=none"])


def names_of(scene):
    return [(topic.full_name, topic.ros_type) for topic in topics(scene)]


def sim_node(executor, kind, **options):
    """A sim_node of that kind's scene, and the scene."""
    name, overrides, pace = PLAYED[kind]
    parameters = {"scene": name, "real_time_factor": pace, **options}
    if overrides:
        parameters["overrides"] = list(overrides)
    return started(executor, SimNode, **parameters), scene_of(kind)


def test_every_kind_is_played_here():
    assert set(PLAYED) == set(SHIPPED)


# Others differ by their topics alone, whose bytes tests/test_kinds.py compares.
SOON = "bearing", "two_spheres", "soft_discs"


@pytest.mark.parametrize(
    "kind", [pytest.param(key, marks=[] if key in SOON else [pytest.mark.environment]) for key in PLAYED]
)
def test_a_recording_of_a_node_reports_as_the_run_does(kind, tmp_path):
    """Also the scene, of which a late recorder learns: a recording verifies and reports to the bit; a replay is it."""
    path, node_log, brief = tmp_path / "recording.mcap", tmp_path / "own.mcap", KINDS[kind].brief
    with ros_executor() as executor:
        # What runs on is reported when to end; the others know.
        end = load_scene(*PLAYED[kind][:2]).parameters.run.duration
        options = {"log": str(node_log)} if brief else {"duration": end}
        node, scene = sim_node(executor, kind, start_paused=True, **options)
        recorder = started(executor, RecorderNode, log=str(path))
        services, began = plain_node(executor), time.time_ns()
        foreign = services.create_publisher(interface(cdr.STRING, "msg"), "/elsewhere", 10)
        spin_until(executor, lambda: node.loop or node.failure, "preparation")
        names = names_of(scene)
        spin_until(executor, lambda: all(node.count_subscribers(name) for name, _ in names), "discovery")
        assert {name for name, _ in names if not name.startswith(f"/{kind}/")} == {"/tf"}
        obeyed = {name for name in COMMANDS if node.count_subscribers(f"/{kind}/{name}")}
        assert obeyed == {"bearing": COMMANDS, "shaft": COMMANDS - {"command/torque"}}.get(kind, set())
        foreign.publish(interface(cdr.STRING, "msg")())
        call(executor, services, SetBool, f"/{kind}/sim_node/pause", SetBool.Request(data=False))
        spin_until(executor, node.done.is_set, "end of the run")
        counters = "messages", "messages_lost", "messages_before"
        received = lambda: sum(recorder.recording.status()[key] for key in counters)  # noqa: E731
        spin_until(executor, lambda: received() >= node._outlet.published or recorder.failure, "all messages")
        spin_for(executor, 0.2)
        assert node.failure is None
        assert recorder.failure is None
    log = read_log(path)
    assert log.scene.parameters == scene.parameters
    run = simulate(scene_of(kind))
    direct = tmp_path / "direct.mcap"
    write_log(run, direct)
    report, missing = report_of(log)
    assert missing == 0
    assert report.figures == run.report.figures
    assert (report.law, report.stepper, report.choice_reason) == (run.choice.law, run.choice.stepper, run.choice.reason)
    assert verify(log).greatest == 0.0
    for message in raw_messages(path):
        assert message.topic.metadata["topic_type_hash"] == cdr.type_hash(dict(names)[message.topic.name])
        assert began <= message.publish_time <= message.log_time <= time.time_ns()  # when it was sent, when it came
    recorded, written, logged = ({name: [] for name, _ in names} for _ in range(3))
    for source, messages in ((path, recorded), (direct, written), *(((node_log, logged),) if brief else ())):
        for message in raw_messages(source):
            messages[message.topic.name].append(padded(message.data))
    assert not brief or logged == written
    for name, ros_type in names:
        # A busy machine may lose what comes at the publish rate, ten deep, but no output.
        remaining = iter(written[name])
        if name != f"/{kind}/scene":  # where the duration of what runs on differs
            assert all(data in remaining for data in recorded[name]), name
        if ros_type == cdr.SAMPLE_BLOCK:
            assert recorded[name] == written[name], name
        assert recorded[name] or not written[name], name
    with ros_executor() as executor:
        lists = heard(plain_node(executor), names)
        player = started(executor, ReplayNode, log=str(path), discovery=20.0)
        spin_until(executor, player.done.is_set, "end of the replay")
        spin_until(
            executor, lambda: all(lists[name] or not recorded[name] for name in lists), "a message of each topic"
        )
        spin_for(executor, 0.2)
        assert player.failure is None
    for name, report in lists.items():
        remaining = iter(recorded[name])
        assert all(padded(data) in remaining for data in report), name
        assert report or not recorded[name], name


def test_a_recorder_that_joins_late_still_learns_the_scene(tmp_path):
    path = tmp_path / "late.mcap"
    with ros_executor() as executor:
        node, scene = sim_node(executor, "bearing")
        spin_until(executor, lambda: node.loop or node.failure, "preparation")
        spin_until(executor, lambda: node.loop.position_ns > 200_000_000, "0.2 s")
        recorder = started(executor, RecorderNode, log=str(path))
        spin_until(executor, lambda: recorder.recording.messages > 1000, "messages")
    log = read_log(path, allow_gaps=True)
    assert log.scene == scene
    report, _ = report_of(log)
    assert report.law == node.loop.simulation.choice.law
    assert report.status == "done"


def frames_in(messages):
    """(parent, child) of every transform in these messages."""
    return {
        (transform.header.frame_id, transform.child_frame_id)
        for data in messages
        for transform in deserialize_message(data, interface(cdr.TRANSFORMS, "msg")).transforms
    }


def test_a_namespace_of_the_user_wins_and_frames_take_a_prefix():
    """Two bearings side by side: nothing of one is taken for the other's."""
    with ros_executor() as executor:
        for side, arguments, options in (("left", "-r __ns:=/left", {}), ("right", "", {"namespace": "/right"})):
            arguments = f"--ros-args {arguments} -p scene:=two_spheres -p real_time_factor:=1e-4"
            arguments += f" -p frame_prefix:={side}/ -p start_paused:=true"
            node = SimNode(context=executor.context, cli_args=arguments.split(), **options)
            executor.add_node(node)
            assert node.get_namespace() == f"/{side}"
        watcher = plain_node(executor)
        names = {side: f"/{side}/first/wrench" for side in ("left", "right")}
        lists = heard(watcher, [*((name, cdr.WRENCH) for name in names.values()), ("/tf", cdr.TRANSFORMS)])
        spin_until(executor, lambda: watcher.count_publishers("/tf") == 2, "discovery")
        for side in names:
            call(executor, watcher, SetBool, f"/{side}/sim_node/pause", SetBool.Request(data=False))
        expected = {(f"{side}/two_spheres_link", f"{side}/{body}") for side in names for body in ("first", "second")}
        spin_until(executor, lambda: all(lists.values()) and frames_in(lists["/tf"]) == expected, "frames of both")
        for side, name in names.items():
            wrench = deserialize_message(lists[name][0], interface(cdr.WRENCH, "msg"))
            assert wrench.header.frame_id == f"{side}/first"


@pytest.mark.parametrize("address", ["/two_spheres/sim_node", "/**/sim_node", "/**"])
def test_a_parameter_file_may_name_the_node_as_it_will_be(address, tmp_path):
    """The namespace follows from the scene, and the scene from a file that may be addressed to that namespace."""
    path = tmp_path / "parameters.yaml"
    path.write_text(f"{address}:\n  ros__parameters:\n    scene: two_spheres\n    start_paused: true\n")
    with ros_executor() as executor:
        node = SimNode(context=executor.context, cli_args=["--ros-args", "--params-file", str(path)])
        executor.add_node(node)
        assert node.get_fully_qualified_name() == "/two_spheres/sim_node"
        assert node.get_parameter("start_paused").value is True
