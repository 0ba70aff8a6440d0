"""Recordings that other programs write from the wire, without our metadata.

`report` and `verify` take the scene from its topic.
"""

import json
from functools import partial

import pytest
from foreign_writers import by_mcap, by_rosbags
from rosbags.rosbag2 import StoragePlugin

from bearing_twin.log import cdr
from bearing_twin.log.cdr import encode
from bearing_twin.log.run_log import read_log
from bearing_twin.log.stream import MessageStream
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation, simulate

SCENE = load_scene("bearing_6203", ["run.duration=0.06"])
ARRIVAL = 1_790_000_000_000_000_000  # ns, when a recorder heard the first message


def wire(scene, namespaces):
    """(topic, type, time of arrival [ns], bytes) of everything that nodes in these namespaces publish of a run."""
    simulation = Simulation(scene)
    stream, block = MessageStream(scene, choice=simulation.choice), simulation.advance(scene.outputs)
    for topic, stamp_ns, data in (*stream.messages(block), *stream.flush()):
        for namespace in namespaces:
            name = topic.full_name.replace("/bearing/", f"{namespace}/", 1)
            yield name, topic.ros_type, ARRIVAL + stamp_ns, data


@pytest.mark.parametrize(
    ("write", "name"), [(partial(by_rosbags, storage=StoragePlugin.MCAP), "bag"), (by_mcap, "run.mcap")]
)
def test_a_recording_without_our_metadata_reports_and_verifies(write, name, tmp_path, run_json):
    write(tmp_path / name, wire(SCENE, ["/left/bearing"]))
    log = read_log(tmp_path / name)
    assert "bearing_twin" not in log.metadata
    assert log.scene.parameters == SCENE.parameters
    run = simulate(SCENE)
    samples = sum(len(block) for block in run.blocks())
    report = run_json("report", str(tmp_path / name))
    assert {key: report[key] for key in run.report.figures} == run.report.figures
    assert report["samples"] == samples
    assert report["law"] == run.choice.law
    assert log.choice[3:] == run.choice[3:] or log.choice.setting != log.choice.setting
    assert run_json("verify", str(tmp_path / name))["greatest_deviation"] == 0.0


def test_what_a_run_took_is_unknown_in_a_recording_and_not_0(tmp_path, run_json, run_cli):
    path = tmp_path / "run.mcap"
    by_mcap(path, wire(SCENE, ["/bearing"]))
    report = run_json("report", str(path))
    assert (report["compute_s"], report["real_time_factor"]) == (None, None)
    assert "real time" not in run_cli("report", path).out
    rows = [line.split() for line in run_cli("report", path, "--verbose").out.splitlines()]
    assert ["compute", "-"] in rows
    assert ["real", "time", "factor", "-"] in rows


@pytest.mark.parametrize(
    ("law", "sentence"), [(None, "does not name its law"), ("nonsense", "names the law 'nonsense'")]
)
def test_a_recording_whose_scene_names_no_law_is_judged_by_that_of_the_scene(law, sentence, tmp_path, run_json):
    def renamed(topic, ros_type, time_ns, data):
        if topic.endswith("/scene"):
            content = json.loads(cdr.deserialise(cdr.STRING, data).data)
            del content["law"]
            content |= {} if law is None else {"law": law}
            data = encode(cdr.STRING, {"data": json.dumps(content)}, 0, "")
        return topic, ros_type, time_ns, data

    path = tmp_path / "run.mcap"
    by_mcap(path, (renamed(*message) for message in wire(SCENE, ["/bearing"])))
    report = run_json("report", str(path))
    assert report["law"] == "hertz"
    assert sentence in report["warnings"][-1]
    assert run_json("verify", str(path))["greatest_deviation"] == 0.0


def test_samples_that_were_remapped_into_another_namespace_keep_their_scene(tmp_path, run_json):
    path = tmp_path / "run.mcap"
    by_mcap(path, ((name.replace("/bearing/samples", "/x/y"), *rest) for name, *rest in wire(SCENE, ["/bearing"])))
    assert read_log(path).scene.parameters == SCENE.parameters
    assert run_json("verify", str(path))["greatest_deviation"] == 0.0


def test_of_two_bearings_in_one_recording_one_is_chosen(tmp_path, refused, run_json):
    path = tmp_path / "both.mcap"
    by_mcap(path, wire(SCENE, ["/left", "/right"]))
    sentence = refused("verify", path)
    assert "/left/samples, /right/samples" in sentence
    assert "--topic" in sentence
    for topic in ("/left/samples", "/right/samples"):
        assert run_json("verify", str(path), "--topic", topic)["greatest_deviation"] == 0.0
        assert run_json("report", str(path), "--topic", topic)["samples"] == SCENE.outputs
        page = str(tmp_path / "page.html")
        assert run_json("view", str(path), "--topic", topic, "--out", page)["outputs_shown"] == SCENE.outputs
