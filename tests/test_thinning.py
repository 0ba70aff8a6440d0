"""Default logs of nodes: some outputs a second of what fills disks, all of what comes seldom, and said to be so."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from runs import a_choice, bits, made_up_block, made_up_scene, receive

from bearing_twin.base.sample import Block, joined
from bearing_twin.command.cli import DOUBTFUL
from bearing_twin.log import cdr
from bearing_twin.log.bag import Qos, raw_messages
from bearing_twin.log.raw_log import KEPT_RATE, RawLogWriter, Safety, Thinning, recover
from bearing_twin.log.run_log import LogWriter, read_log
from bearing_twin.log.stream import MessageStream, choice_record, samples_message, topics
from bearing_twin.nodes.recorder_node import Recording
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation, simulate
from bearing_twin.run.verify import verify

SCENE = made_up_scene(balls=2)
BLOCK = made_up_block(SCENE, 1000)
EVERY = round(1000 / KEPT_RATE)
SAMPLES = "/bearing/samples"


def thin_log(path, run, blocks, **safety):
    """The default log of sim_node."""
    with LogWriter(path, run.scene, choice_record(run.choice), safety=Safety(kept_rate=KEPT_RATE, **safety)) as log:
        stream = MessageStream(run.scene, choice=run.choice)
        for block in blocks:
            for message in stream.messages(block):
                log.write(*message)
        for message in stream.flush():
            log.write(*message)
    return path


@pytest.fixture(scope="module")
def made_up(tmp_path_factory):
    run = SimpleNamespace(scene=SCENE, choice=a_choice())
    return thin_log(tmp_path_factory.mktemp("thin") / "run.mcap", run, [BLOCK])


def test_what_is_kept_is_as_it_was(made_up):
    log = read_log(made_up)
    assert log.kept_rate == KEPT_RATE
    assert bits(log) == bits(BLOCK[row] for row in range(0, 1000, EVERY))
    whole = {name: [] for name in (topic.full_name for topic in topics(SCENE))}
    stream = MessageStream(SCENE, choice=a_choice())
    for topic, stamp, data in (*stream.messages(BLOCK), *stream.flush()):
        whole[topic.full_name].append((stamp, data))
    kept = {name: [] for name in whole}
    for message in raw_messages(made_up):
        kept[message.topic.name].append((message.log_time, message.data))
    for name, found in kept.items():
        if name != SAMPLES and "/records/" not in name:
            seldom = len(whole[name]) == 1
            assert found == [one for one in whole[name] if seldom or one[0] % round(1e9 / KEPT_RATE) == 0], name
            assert len(found) == (1 if seldom else 1 + 999 // EVERY), name


def test_recover_still_says_that_it_is_thinned(made_up, tmp_path):
    recover(made_up, tmp_path / "saved.mcap")
    log = read_log(tmp_path / "saved.mcap")
    assert log.kept_rate == KEPT_RATE
    assert len(list(log)) == 1000 // EVERY


def test_an_hour_of_the_default_log_is_half_a_gigabyte_and_verifies_where_it_has_outputs(tmp_path, asked, typed):
    run = simulate(load_scene("bearing_6203", ["run.duration=2", "solver.stepper=rodas4", "contact.normal=hertz"]))
    path = thin_log(tmp_path / "run.mcap", run, run.blocks())
    assert path.stat().st_size / 2.0 * 3600.0 < 0.5e9
    checked = verify(read_log(path))
    assert (checked.samples, checked.greatest) == (11, 0.0)
    assert asked("verify", path)["kept_outputs_hz"] == KEPT_RATE
    said = typed("report", path, "--json", "--strict", code=DOUBTFUL)
    found = json.loads(said.out)
    assert (found["samples"], found["missing_outputs"], found["kept_outputs_hz"]) == (11, 0, KEPT_RATE)
    assert abs(found["energy_closure"]) < 1e-3  # sums need no output in between
    assert "full:=false" in said.err


def test_an_altered_output_of_a_thinned_log_is_found(tmp_path):
    run = simulate(load_scene("bearing_6203", ["run.duration=0.5", "solver.stepper=rodas4", "contact.normal=hertz"]))
    block = joined(list(run.blocks()))
    block.values["normal_load"][201, 0, 0] += 1e-9  # it is in none of the 5 a second
    assert verify(read_log(thin_log(tmp_path / "same.mcap", run, [block]))).greatest == 0.0
    block.values["normal_load"][200, 0, 0] += 0.5  # this one is
    assert verify(read_log(thin_log(tmp_path / "other.mcap", run, [block]))).greatest == pytest.approx(0.5)


def test_a_recording_that_begins_later_than_its_node_is_verified():
    """Records of what happened before the first output were published before the recorder listened."""
    run = simulate(load_scene("bearing_6203", ["run.duration=2", "solver.stepper=rodas4", "contact.normal=hertz"]))
    whole = Simulation(run.scene)
    first, second = whole.advance(1001).last(1), whole.advance(800).last(1)
    windows = first.records["second_run"]
    assert len(windows) > 1

    def copied(block, records):
        return Block(block.channels, block.first_sequence, block.time_ns, block.values, records)

    def deviates(begin, **changed):
        blocks = [copied(begin, {"second_run": windows[-1:]}), copied(second, changed.get("records", second.records))]
        log = SimpleNamespace(
            kept_rate=KEPT_RATE, has_records=True, cut_short=None, scene=run.scene, channels=run.channels
        )
        log.blocks = lambda: iter(blocks)
        return verify(log).deviations["second_run"]

    assert deviates(first) == 0.0
    windows = windows[:0]
    assert deviates(first) == 0.0
    assert deviates(first, records={}) == (np.inf if len(second.records.get("second_run", ())) else 0.0)
    windows = first.records["second_run"][:1]  # not the last that came before the first output
    assert deviates(first) > 0.0


@pytest.mark.parametrize(("period", "count", "kept"), [(1_000_000, 50, 1), (1_000, 5000, 5000), (10_000_000, 50, 1)])
def test_a_block_of_an_impact_is_kept_whole(period, count, kept):
    times = np.arange(count) * period
    data = samples_message(SCENE.channels, 0, times, np.zeros((count, BLOCK.matrix().shape[1])))
    message = cdr.deserialise(cdr.SAMPLE_BLOCK, Thinning(cdr.SAMPLE_BLOCK, KEPT_RATE).kept(0, data))
    assert message.count == kept


def test_a_block_whose_stamp_would_not_fit_is_kept_whole():
    """A peer may stamp as it likes: that ends no recorder."""
    thinning, row = Thinning(cdr.SAMPLE_BLOCK, KEPT_RATE), np.zeros((2, BLOCK.matrix().shape[1]))
    assert thinning.kept(0, samples_message(SCENE.channels, 0, np.array([0, 19 * 10**7]), row)) is not None
    late = cdr.deserialise(cdr.SAMPLE_BLOCK, samples_message(SCENE.channels, 0, np.array([0, 4 * 10**18]), row))
    late.header.stamp.sec = 2**31 - 1
    data = cdr.serialised(cdr.SAMPLE_BLOCK, late)
    assert thinning.kept(0, data) == data


def test_a_second_publisher_is_not_lost_among_the_messages_of_the_first(tmp_path):
    recording = Recording(tmp_path / "out.mcap", ["*"], safety=Safety(kept_rate=KEPT_RATE))
    brief = "/two_discs/disc_0/wrench"  # the same rule for all topics
    for topic in ("/tf", brief):
        recording.add(topic, cdr.STATE, cdr.type_hash(cdr.STATE), (Qos(),))
    for number in range(1, 11):
        for topic in ("/tf", brief):
            receive(recording, topic, number * 10**7, 1, b"", number)
    assert recording.status()["messages_lost"] == 0
    recording.publishers("/tf", 2)
    for number in range(11, 21):
        receive(recording, "/tf", number * 10**7, 1, b"", number)
    recording.publishers("/tf", 1)
    for number in range(21, 31):
        receive(recording, "/tf", number * 10**7, 1, b"", number)
    recording.close()
    counts = {}
    for message in raw_messages(tmp_path / "out.mcap"):
        counts[message.topic.name] = counts.get(message.topic.name, 0) + 1
    assert counts == {"/tf": 1 + 10 + 1, brief: 1}


def test_what_is_latched_and_records_are_kept_whole(tmp_path):
    with RawLogWriter(tmp_path / "out.mcap", safety=Safety(kept_rate=KEPT_RATE)) as log:
        latched = Qos(durability="transient_local")
        for name, qos in (("/a", Qos()), ("/b", latched), ("/c", Qos()), ("/x/records/touch", Qos())):
            number = log.add_topic(name, cdr.STATE, "", "", (qos,))
            for k in range(5):
                log.write(number, k, k, b"")
    found = [message.topic.name for message in raw_messages(tmp_path / "out.mcap")]
    assert {name: found.count(name) for name in found} == {"/a": 1, "/b": 5, "/c": 1, "/x/records/touch": 5}


def test_an_output_from_the_middle_of_a_block_keeps_its_number_and_time():
    thinning, found = Thinning(cdr.SAMPLE_BLOCK, 7.0), []
    stream = MessageStream(SCENE, choice=a_choice(), start_time_ns=10**10)
    for topic, stamp, data in (*stream.messages(BLOCK), *stream.flush()):
        if topic.full_name == SAMPLES and (kept := thinning.kept(stamp, data)) is not None:
            found.append(cdr.deserialise(cdr.SAMPLE_BLOCK, kept))
    assert [int(one.first_sequence) for one in found] == [0, 143, 286, 429, 572, 715, 858]
    for one in found:
        assert int(one.time_ns[0]) == int(one.first_sequence) * 10**6
        assert one.header.stamp.sec * 10**9 + one.header.stamp.nanosec == 10**10 + int(one.time_ns[0])
