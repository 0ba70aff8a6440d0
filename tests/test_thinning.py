"""Thinned logs (full: false): some outputs a second of what fills disks, all of what comes seldom."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from runs import a_choice, bits, made_up_block, made_up_scene

from bearing_twin.base.sample import join_blocks
from bearing_twin.command.cli import DOUBTFUL
from bearing_twin.log import cdr
from bearing_twin.log.bag import Qos, raw_messages
from bearing_twin.log.raw_log import KEPT_RATE, Safety, Thinning, recover
from bearing_twin.log.run_log import LogWriter, read_log
from bearing_twin.log.stream import MessageStream, choice_record, samples_message
from bearing_twin.nodes.recorder_node import Received, Recording
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate
from bearing_twin.run.verify import verify

SCENE = made_up_scene(balls=2)
BLOCK = made_up_block(SCENE, 1000)
EVERY = round(1000 / KEPT_RATE)


def thin_log(path, run, blocks):
    """The log of sim_node with full: false."""
    with LogWriter(path, run.scene, choice_record(run.choice), safety=Safety(kept_rate=KEPT_RATE)) as log:
        stream = MessageStream(run.scene, choice=run.choice)
        for block in blocks:
            log.write_messages(stream.messages(block))
        log.write_messages(stream.flush())
    return path


def test_what_is_kept_is_as_it_was(tmp_path):
    path = thin_log(tmp_path / "run.mcap", SimpleNamespace(scene=SCENE, choice=a_choice()), [BLOCK])
    stream, sent, logged = MessageStream(SCENE, choice=a_choice()), {}, {}
    for topic, stamp, data in (*stream.messages(BLOCK), *stream.flush()):
        sent.setdefault(topic.full_name, []).append((stamp, data))
    for message in raw_messages(path):
        logged.setdefault(message.topic.name, []).append((message.log_time, message.data))
    assert set(logged) == set(sent)
    for name in set(logged) - {"/bearing/samples"}:
        seldom = len(sent[name]) == 1
        period = 1 if seldom else round(1e9 / KEPT_RATE)
        assert logged[name] == [message for message in sent[name] if message[0] % period == 0], name
    recover(path, tmp_path / "saved.mcap")
    for log_file in (path, tmp_path / "saved.mcap"):
        log = read_log(log_file)
        assert bits(log) == bits(BLOCK[row] for row in range(0, 1000, EVERY))
        assert log.kept_rate == KEPT_RATE


def test_a_thinned_log_is_small_and_verified_where_it_has_outputs(tmp_path, run_cli):
    run = simulate(load_scene("bearing_6203", ["run.duration=2"]))
    block = join_blocks(list(run.blocks()))
    block.values["normal_load"][201, 0, 0] += 1e-9  # it is in none of the 5 a second
    path = thin_log(tmp_path / "run.mcap", run, [block])
    assert path.stat().st_size / 2.0 * 3600.0 < 0.5e9  # B an hour
    checked = verify(read_log(path))
    assert (checked.samples, checked.greatest) == (11, 0.0)
    captured = run_cli("report", path, "--json", "--strict", code=DOUBTFUL)
    report = json.loads(captured.out)
    assert (report["samples"], report["missing_outputs"], report["kept_outputs_hz"]) == (11, 0, KEPT_RATE)
    assert json.loads(run_cli("verify", path, "--json").out)["kept_outputs_hz"] == KEPT_RATE
    assert "holds 5 outputs a second" in run_cli("view", path, "--out", tmp_path / "page.html").err
    assert abs(report["energy_closure"]) < 1e-3  # sums need no output in between
    assert "5 outputs a second, not all" in captured.err
    block.values["normal_load"][200, 0, 0] += 0.5  # this one is
    assert verify(read_log(thin_log(tmp_path / "other.mcap", run, [block]))).greatest == pytest.approx(0.5)


@pytest.mark.parametrize(("period", "count", "kept"), [(1_000_000, 50, 1), (1_000, 5000, 5000), (10_000_000, 50, 1)])
def test_a_block_of_an_impact_is_kept_whole(period, count, kept):
    times = np.arange(count) * period
    data = samples_message(SCENE.channels, 0, times, np.zeros((count, BLOCK.matrix().shape[1])))
    message = cdr.deserialise(cdr.SAMPLE_BLOCK, Thinning(cdr.SAMPLE_BLOCK, KEPT_RATE).thin(0, data))
    assert message.count == kept


def test_a_block_whose_stamp_would_not_fit_is_kept_whole():
    """A peer may stamp as it likes: that ends no recorder."""
    thinning, row = Thinning(cdr.SAMPLE_BLOCK, KEPT_RATE), np.zeros((2, BLOCK.matrix().shape[1]))
    assert thinning.thin(0, samples_message(SCENE.channels, 0, np.array([0, 19 * 10**7]), row)) is not None
    latest = cdr.deserialise(cdr.SAMPLE_BLOCK, samples_message(SCENE.channels, 0, np.array([0, 4 * 10**18]), row))
    latest.header.stamp.sec = 2**31 - 1
    data = cdr.serialise(cdr.SAMPLE_BLOCK, latest)
    assert thinning.thin(0, data) == data


def test_topics_of_several_publishers_latched_ones_and_records_are_kept_whole(tmp_path):
    recording = Recording(tmp_path / "out.mcap", ["*"], safety=Safety(kept_rate=KEPT_RATE))
    for topic, qos in (("/tf", Qos()), ("/latched", Qos(durability="transient_local")), ("/x/records/touch", Qos())):
        recording.add(topic, cdr.STATE, cdr.type_hash(cdr.STATE), (qos,))
    for number in range(1, 31):
        recording.publishers("/tf", 2 if 10 < number <= 20 else 1)
        for topic in ("/tf", "/latched", "/x/records/touch"):
            recording.receive_all(topic, [Received(number * 10**7, 1, number, b"")])
    recording.close()
    names = [message.topic.name for message in raw_messages(tmp_path / "out.mcap")]
    assert {name: names.count(name) for name in names} == {"/tf": 1 + 10 + 1, "/latched": 30, "/x/records/touch": 30}
