"""A kind of scene that nobody knew before passes sim_node, recorder_node and replay_node."""

import toy_kind
from ros import heard, padded, plain_node, ros_executor, spin_until, spin_until_heard, started

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

SCENE = "kind: toy\nstart: 0.02\n"


def by_topic(path):
    found = {}
    for message in raw_messages(path):
        found.setdefault(message.topic.name, []).append(padded(message.data))
    return found


def test_it_is_simulated_recorded_and_replayed(tmp_path):
    scene, own, recorded, direct = (
        tmp_path / name for name in ("swing.yaml", "own.mcap", "recorded.mcap", "direct.mcap")
    )
    scene.write_text(SCENE, encoding="utf-8")
    with ros_executor() as executor:
        recorder = started(executor, RecorderNode, log=str(recorded), topics=["/toy/*"], full=True)
        node = started(executor, SimNode, scene=str(scene), duration=0.3, discovery=30.0, log=str(own), full=True)
        spin_until(executor, node.done.is_set, "end of the simulation")
        write_log(simulate(load_scene(scene, ["run.duration=0.3"])), direct)
        total = sum(map(len, by_topic(direct).values()))
        spin_until(executor, lambda: recorder.recording.messages >= total or recorder.failure, "all messages")
        assert (node.failure, recorder.failure) == (None, None)
    sent = by_topic(own)
    assert set(sent) == {topic.full_name for topic in topics(load_scene(scene))}
    assert by_topic(recorded) == sent

    stream = read_log(recorded)
    assert stream.channels == toy_kind.CHANNELS
    assert verify(stream).greatest == 0.0
    report, missing = report_of(stream)
    assert (missing, report.samples) == (0, 301)
    assert set(report.figures) == set(toy_kind.KIND.meanings_of())

    with ros_executor() as executor:
        watcher = plain_node(executor)
        lists = heard(watcher, [(topic.full_name, topic.ros_type) for topic in topics(stream.scene)])
        replay = started(executor, ReplayNode, log=str(recorded), discovery=30.0)
        spin_until(executor, replay.done.is_set, "end of the replay")
        assert replay.failure is None
        spin_until_heard(executor, lists, sent)
    assert {name: [padded(data) for data in found] for name, found in lists.items()} == sent
