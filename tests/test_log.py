"""Logs: what goes in comes out, bit for bit, also through readers that are not ours."""

import dataclasses
import io
import json
import os
import struct
import threading
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
import zstandard
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Chunk, Message, MessageIndex
from mcap.stream_reader import StreamReader, breakup_chunk
from rosbags.highlevel import AnyReader
from runs import a_choice, bits, cut, made_up_block, made_up_run, made_up_scene

from bearing_twin.base.errors import IntegrationError, LogError
from bearing_twin.base.sample import join_blocks
from bearing_twin.command.cli import BAD_INPUT, DONE, main
from bearing_twin.log import cdr
from bearing_twin.log.bag import LogReader, raw_messages
from bearing_twin.log.export import export_log
from bearing_twin.log.raw_log import RawLogWriter, Safety
from bearing_twin.log.run_log import LogWriter, read_log, write_log
from bearing_twin.log.stream import MessageStream, topics
from bearing_twin.run.report import report_of
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate
from bearing_twin.run.verify import verify
from bearing_twin.view.run_page import log_document

SCENE = made_up_scene()
BLOCK = made_up_block(SCENE, 230)


def write(path, blocks=(BLOCK,), **options):
    return write_log(made_up_run(SCENE, list(blocks)), path, **options)


def stream(blocks=(BLOCK,)):
    messages = MessageStream(SCENE, choice=a_choice())
    yield from (message for block in blocks for message in messages.messages(block))
    yield from messages.flush()


@pytest.mark.parametrize("name", ["run.mcap", "bag"])
def test_samples_come_back_bit_for_bit(tmp_path, name):
    summary = write(tmp_path / name, cut(BLOCK, 3, 50, 51, 177))
    log = read_log(tmp_path / name)
    assert bits(log) == bits(BLOCK)
    assert bits(log) == bits(BLOCK)  # a second time
    assert log.channels == SCENE.channels
    assert log.scene == SCENE
    assert summary.samples == 230
    logged = [
        (message.topic.name, message.topic.ros_type, message.log_time, message.publish_time, message.data)
        for message in raw_messages(tmp_path / name)
    ]
    assert logged == [(t.full_name, t.ros_type, stamp, stamp, data) for t, stamp, data in stream()]
    assert summary.messages == len(logged)


def test_a_log_that_begins_late_or_has_gaps_is_verified_where_it_has_outputs(tmp_path, run_cli):
    scene = load_scene("bearing_6203", ["run.duration=0.12"])
    block = join_blocks(list(simulate(scene).blocks()))
    write_log(made_up_run(scene, [block.part(60, 90), block.part(100, 121)]), tmp_path / "run.mcap")
    with pytest.raises(LogError, match="10 outputs are missing"):
        verify(read_log(tmp_path / "run.mcap"))
    reached = []
    result = verify(read_log(tmp_path / "run.mcap", allow_gaps=True), reached.append)
    assert (result.samples, result.greatest, result.missing) == (51, 0.0, 10)
    assert reached[0] < 0.06 < reached[-1] == pytest.approx(0.12)
    captured = run_cli("verify", tmp_path / "run.mcap", "--json")
    assert json.loads(captured.out)["outputs_missing"] == 10
    assert "begins at 0.06 s: the run up to there is simulated first" in captured.err
    captured = run_cli("report", tmp_path / "run.mcap", "--json")
    assert json.loads(captured.out)["begins_s"] == pytest.approx(0.06)
    assert "begins at 0.06 s" in captured.err


@pytest.mark.parametrize("name", ["bearing_6203", "ellipsoid_rocking"])
def test_a_run_is_continued_from_its_log_as_one_long_run_to_the_bit(name, tmp_path, run_cli):
    first, second = tmp_path / "first.mcap", tmp_path / "second.mcap"
    assert main(["simulate", name, "--duration", "0.05", "--out", str(first), "--json"]) == DONE
    assert main(["simulate", str(first), "--continue", "0.02s", "--out", str(second), "--json"]) == DONE
    assert json.loads(run_cli("verify", second, "--json").out.splitlines()[-1])["greatest_deviation"] == 0.0
    log = read_log(second)
    *_, last = log
    assert 1e-9 * last.time_ns == pytest.approx(0.07, abs=1e-9 * log.scene.output_period_ns)
    with RawLogWriter(tmp_path / "copy.mcap") as copy:  # as of a recording
        topic = copy.add_topic("/bearing/samples", cdr.SAMPLE_BLOCK)
        for message in raw_messages(first):
            if message.topic.ros_type == cdr.SAMPLE_BLOCK and "/records/" not in message.topic.name:
                copy.write(topic, message.log_time, message.publish_time, message.data)
    for arguments in (["--continue", "0.01"], ["--continue", "0"], ["--continue", "1", "--duration", "2"]):
        assert main(["simulate", str(tmp_path / "copy.mcap"), *arguments]) == BAD_INPUT
    assert main(["simulate", str(first), "--continue", "0.01", "--set", "run.output_rate=17"]) == BAD_INPUT


def test_a_log_with_fewer_channels_is_verified_by_those_it_has():
    """As written before channels were added; a channel that is not known any more is refused, a change is found."""
    run = simulate(load_scene("two_spheres"))
    channels = tuple(channel for channel in run.channels if channel.name != "elastic_energy")
    blocks = [
        dataclasses.replace(
            block, channels=channels, values={channel.name: block.values[channel.name].copy() for channel in channels}
        )
        for block in run.blocks()
    ]
    log = SimpleNamespace(has_records=True, cut_short=None, kept_rate=0.0, scene=run.scene, channels=channels)
    log.blocks = lambda: iter(blocks)
    result = verify(log)
    assert result.greatest == 0.0
    assert set(result.deviations) == {channel.name for channel in channels} | {"contact"}
    assert not result.warnings()
    log.has_records = False  # nor were records written then: that they were not compared is said
    result = verify(log)
    assert set(result.deviations) == {channel.name for channel in channels}
    assert result.as_dict()["records_missing"] == ["contact"]
    assert result.warnings() == ["the log has no records, as of contact: outputs alone were compared"]
    log.has_records = True
    blocks[0].values["approach"][3] += 1e-9
    assert verify(log).deviations["approach"] == pytest.approx(1e-9)
    blocks[0].values["approach"][3] = np.nan
    assert verify(log).deviations["approach"] == np.inf
    log.channels = (*channels, run.channels[0]._replace(name="temperature"))
    with pytest.raises(LogError, match="its channels differ"):
        verify(log)


def test_a_recording_that_ends_between_records_and_their_outputs_is_verified_up_to_its_last_output():
    """A node hands over a chunk's records before its last outputs: a recorder may be ended in between."""
    run = simulate(load_scene("bearing_6203_loose", ["run.duration=0.05"]))
    block = join_blocks(list(run.blocks()))
    part = dataclasses.replace(block.part(0, 30), records=block.records)
    log = SimpleNamespace(has_records=True, cut_short=None, kept_rate=0.0, scene=run.scene, channels=run.channels)
    log.blocks = lambda: iter([part])
    assert len(block.records["second_run"]) > len(block.part(0, 30).records["second_run"])
    assert verify(log).greatest == 0.0
    early = block.records["second_run"][[0, 0]]  # at a time that is compared
    early[:, 0] = 0.01
    part = dataclasses.replace(part, records={**block.records, "second_run": early})
    assert verify(log).greatest == np.inf


@pytest.mark.parametrize("name", ["run.mcap", "bag"])
def test_rosbags_reads_the_same_values(tmp_path, name):
    write(tmp_path / name)
    expected = [(topic.full_name, stamp, data) for topic, stamp, data in stream()]
    with AnyReader([tmp_path / name]) as reader:
        messages = [(c.topic, stamp, bytes(data)) for c, stamp, data in reader.messages()]
        assert sorted(messages) == sorted(expected)
        assert [c.msgtype for c in reader.connections] == [topic.ros_type for topic in topics(SCENE)]
        [connection] = [c for c in reader.connections if c.topic == "/bearing/state"]
        [qos] = connection.ext.offered_qos_profiles
        depth = round(4.0 * SCENE.parameters.run.publish_rate)
        assert (qos.reliability.name, qos.durability.name, qos.depth) == ("RELIABLE", "VOLATILE", depth)
        states = [
            reader.deserialize(data, connection.msgtype) for _, _, data in reader.messages(connections=[connection])
        ]
        assert [state.sequence for state in states] == list(range(0, 230, 10))
        assert states[-1].position.tobytes() == BLOCK[220]["position"].tobytes()


def test_file_and_folder_follow_rosbag2(tmp_path):
    """The description of a folder is there from the start; the file holds scene, model and versions, too."""
    described = tmp_path / "bag" / "metadata.yaml"
    with LogWriter(tmp_path / "bag", SCENE) as log:
        first = yaml.safe_load(described.read_text())["rosbag2_bagfile_information"]
        log.write_messages(stream())
    final = yaml.safe_load(described.read_text())["rosbag2_bagfile_information"]
    write(tmp_path / "run.mcap")
    with (tmp_path / "run.mcap").open("rb") as file:
        reader = make_reader(file)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
    inside = yaml.safe_load(metadata["rosbag2"]["serialized_metadata"])
    count = len(list(stream()))
    assert first["relative_file_paths"] == final["relative_file_paths"] == ["bag_0.mcap"]
    assert (first["message_count"], final["message_count"], inside["message_count"]) == (0, count, count)
    assert (final["version"], final["ros_distro"], final["duration"]["nanoseconds"]) == (9, "jazzy", 229_000_000)
    assert [topic["topic_metadata"]["type_description_hash"] for topic in final["topics_with_message_count"]] == [
        cdr.type_hash(topic.ros_type) for topic in topics(SCENE)
    ]
    assert {s.encoding for s in summary.schemas.values()} == {"ros2msg"}
    for channel in summary.channels.values():
        assert channel.message_encoding == "cdr"
        assert channel.metadata["topic_type_hash"] == cdr.type_hash(summary.schemas[channel.schema_id].name)
        [qos] = yaml.safe_load(channel.metadata["offered_qos_profiles"])
        assert (qos["history"], qos["reliability"], qos["lifespan"]["sec"]) == ("keep_last", "reliable", 9223372036)
    record = metadata["bearing_twin"]
    assert yaml.safe_load(record["scene"]) == SCENE.resolved()
    assert (record["law"], record["stepper"], record["numpy_version"]) == ("hertz", "rodas4", np.__version__)
    assert set(metadata["bearing_twin_run"]) == {"date", "host", "report"}
    assert read_log(tmp_path / "run.mcap").report == {"status": "made up", "samples": 230}


def test_same_run_same_bytes(tmp_path):
    write(tmp_path / "one.mcap", run_record=False)
    write(tmp_path / "two.mcap", cut(BLOCK, 1, 99), run_record=False)
    assert (tmp_path / "one.mcap").read_bytes() == (tmp_path / "two.mcap").read_bytes()


@pytest.mark.parametrize("name", ["run.mcap", "bag"])
def test_nothing_is_overwritten(tmp_path, name):
    path = tmp_path / name
    path.write_text("precious")
    run = SimpleNamespace(scene=SCENE, choice=a_choice(), blocks=pytest.fail)
    with pytest.raises(LogError, match=f"{name} exists and is not overwritten; give another name"):
        write_log(run, path)
    with pytest.raises(LogError, match=r"the folder .*nowhere for the log does not exist"):
        write_log(run, tmp_path / "nowhere" / name)
    with pytest.raises(LogError, match="export"):
        write_log(run, tmp_path / "table.csv")
    with pytest.raises(LogError, match="must be a folder"):
        LogWriter(tmp_path / "split.mcap", SCENE, safety=Safety(split_seconds=1.0))
    assert path.read_text() == "precious"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["run.mcap", "bag"])
@pytest.mark.parametrize("outputs", [0, 70])
def test_run_that_fails_leaves_what_it_had(outputs, name, tmp_path):
    def blocks():
        yield from cut(BLOCK, outputs)[:1] if outputs else ()
        raise IntegrationError("diverged")

    run = made_up_run(SCENE, [])
    run.blocks = blocks
    with pytest.raises(IntegrationError):
        write_log(run, tmp_path / name)
    assert bits(read_log(tmp_path / name)) == bits(BLOCK)[:70] if outputs else not list(tmp_path.iterdir())


def record(path, blocks=(BLOCK,), name="/bearing/samples", keep=lambda index: True):
    """A log as a recorder makes it: no scene, log times of another clock, some messages lost."""
    index = 0
    with RawLogWriter(path) as log:
        number = log.add_topic(name, cdr.SAMPLE_BLOCK)
        for topic, stamp, data in stream(blocks):
            if topic.name == "samples":
                if keep(index):
                    log.write(number, 1_700_000_000_000_000_000 + stamp, stamp, data)
                index += 1


def test_a_recording_without_scene_has_the_samples_that_came(tmp_path, run_cli):
    """All of them, those from a late start on, and those around a gap, which is counted."""
    complete, later, gap = (tmp_path / f"{name}.mcap" for name in ("whole", "late", "gap"))
    record(complete, name="/other/samples")
    log = read_log(complete)
    assert (log.scene, log.report, bits(log)) == (None, None, bits(BLOCK))
    assert log.channels == SCENE.channels
    assert run_cli("report", complete).out.splitlines()[0] == "log without its scene: 229 ms"
    record(later, keep=lambda index: index > 0)
    assert bits(read_log(later)) == bits(BLOCK)[50:]
    record(gap, keep=lambda index: index != 1)
    with pytest.raises(LogError, match=r"50 outputs are missing .* from sequence 50 to 99"):
        list(read_log(gap))
    log = read_log(gap, allow_gaps=True)
    assert [sample.sequence for sample in log] == [*range(50), *range(100, 230)]
    assert log.missing == 50


def test_every_chunk_and_the_log_tell_their_times_and_counts(tmp_path, monkeypatch):
    """By another reader: begin and end of each chunk, of its index, and of the log; messages stand where it says."""
    monkeypatch.setattr("bearing_twin.log.mcap_write.CHUNK_BYTES", 400)
    times = [500, 900, 100, 300, 700, 650, 10, 20, 30, 40, 600, 50]
    with RawLogWriter(tmp_path / "out.mcap", run_record=False) as log:
        numbers = [log.add_topic(name, cdr.CLOCK) for name in ("/a", "/b")]
        for k, time in enumerate(times):
            log.write(numbers[k % 3 == 0], time, time + 7, bytes([k]) * 100)
    data = (tmp_path / "out.mcap").read_bytes()
    summary = make_reader(io.BytesIO(data)).get_summary()
    statistics = summary.statistics
    assert (statistics.message_start_time, statistics.message_end_time) == (10, 900)
    assert statistics.message_count == 12
    assert {summary.channels[n].topic: c for n, c in statistics.channel_message_counts.items()} == {"/a": 8, "/b": 4}
    records = list(StreamReader(io.BytesIO(data), emit_chunks=True).records)
    chunks = [record for record in records if isinstance(record, Chunk)]
    for record in records:  # players find messages by what stands behind each chunk
        if isinstance(record, Chunk):
            content = zstandard.ZstdDecompressor().decompress(record.data, max_output_size=record.uncompressed_size)
        elif isinstance(record, MessageIndex):
            for time, offset in record.records:
                fields = struct.unpack_from("<BQHIQ", content, offset)
                assert (fields[0], fields[2], fields[4]) == (Opcode.MESSAGE, record.channel_id, time)
    assert len(chunks) == len(summary.chunk_indexes) >= 4
    reported = []
    for index, chunk in zip(summary.chunk_indexes, chunks, strict=True):
        inside = [record for record in breakup_chunk(chunk) if isinstance(record, Message)]
        stamps = [record.log_time for record in inside]
        assert (chunk.message_start_time, chunk.message_end_time) == (min(stamps), max(stamps))
        assert (index.message_start_time, index.message_end_time) == (min(stamps), max(stamps))
        reported += [(message.log_time, message.publish_time, message.data[0]) for message in inside]
        for channel, offset in index.message_index_offsets.items():
            assert struct.unpack_from("<BQH", data, offset)[::2] == (Opcode.MESSAGE_INDEX, channel)
    assert reported == [(time, time + 7, k) for k, time in enumerate(times)]
    for from_ns in (0, 100, 500, 650, 899, 900):
        messages = LogReader(tmp_path / "out.mcap").messages(from_ns=from_ns)
        logged = [(log_time, data[0]) for _, log_time, _, data in messages]
        assert logged == sorted((time, k) for k, time in enumerate(times) if time >= from_ns)


def split_run(path, **limits):
    """A log of the made-up run that is split, with what it holds in one piece."""
    with LogWriter(path, SCENE, safety=Safety(**limits)) as log:
        log.write_messages(stream())
    return sorted(path.glob("*.mcap"), key=lambda file: int(file.stem.rpartition("_")[2]))


@pytest.mark.parametrize("limits", [{"split_seconds": 0.02}, {"split_bytes": 20_000}])
def test_a_log_in_several_files_is_one_log_and_each_can_be_read_alone(tmp_path, monkeypatch, limits):
    monkeypatch.setattr("bearing_twin.log.mcap_write.CHUNK_BYTES", 10_000)
    files = split_run(tmp_path / "bag", **limits)
    assert 3 < len(files) < 20  # a quarter of a second
    assert bits(read_log(tmp_path / "bag")) == bits(BLOCK)
    described = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert described["relative_file_paths"] == [file.name for file in files]
    count = len(list(raw_messages(tmp_path / "bag")))
    assert sum(entry["message_count"] for entry in described["files"]) == described["message_count"] == count
    ends = [(entry["starting_time"]["nanoseconds_since_epoch"], entry["duration"]) for entry in described["files"]]
    assert ends == sorted(ends, key=lambda entry: entry[0])
    with AnyReader([tmp_path / "bag"]) as reader:
        assert reader.message_count == count
    samples = []
    for file in files:
        part = read_log(file)
        assert part.scene == SCENE
        samples += bits(part)
        held = list(raw_messages(file))
        (latched,) = (message for message in held if message.topic.name == "/bearing/scene")
        assert latched.log_time == held[0].log_time
    assert samples == bits(BLOCK)


def test_the_newest_files_of_a_split_log_stay(tmp_path):
    files = split_run(tmp_path / "bag", split_seconds=0.02, keep=2)
    assert len(files) == 2
    samples = bits(read_log(tmp_path / "bag"))
    assert 0 < len(samples) < len(bits(BLOCK))
    assert samples == bits(BLOCK)[-len(samples) :]
    with AnyReader([tmp_path / "bag"]) as reader:
        assert sum(1 for _ in reader.messages()) == reader.message_count
    files[0].unlink()
    with pytest.raises(LogError, match=rf"lacks its file {files[0].name}; remove its metadata.yaml"):
        read_log(tmp_path / "bag")
    (tmp_path / "bag" / "metadata.yaml").unlink()
    assert bits(read_log(tmp_path / "bag")) == samples[-len(bits(read_log(files[1]))) :]


@pytest.mark.parametrize("fsync", [True, False])
def test_a_flush_goes_past_the_caches_of_the_machine_where_that_is_asked_for(tmp_path, monkeypatch, fsync):
    synced, sync = [], os.fsync
    monkeypatch.setattr(os, "fsync", lambda file: (synced.append(os.fstat(file).st_size), sync(file)))
    with RawLogWriter(tmp_path / "run.mcap", safety=Safety(fsync=fsync)) as log:
        number = log.add_topic("/clock", cdr.CLOCK)
        for k in range(2):
            log.write(number, k, k, bytes(12))
            log.flush()
            assert synced[-1:] == ([(tmp_path / "run.mcap").stat().st_size] if fsync else [])


@pytest.mark.parametrize("name", ["run.mcap", "bag"])
def test_ctrl_c_while_a_log_is_begun_leaves_nothing(name, tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("bearing_twin.log.cdr.schema_text", interrupted)
    with pytest.raises(KeyboardInterrupt):
        LogWriter(tmp_path / name, SCENE)
    assert list(tmp_path.iterdir()) == []


def test_a_log_without_a_message_leaves_neither_a_file_nor_a_thread(tmp_path):
    with pytest.raises(KeyError), RawLogWriter(tmp_path / "run.mcap", safety=Safety(max_loss=0.01)):
        raise KeyError
    for thread in threading.enumerate():
        if thread.name == "log flush":
            thread.join(30.0)
            assert not thread.is_alive()
    assert list(tmp_path.iterdir()) == []


def test_a_clock_that_is_put_back_does_not_keep_a_log_from_being_split(tmp_path):
    with RawLogWriter(tmp_path / "bag", safety=Safety(split_seconds=10.0)) as log:
        number = log.add_topic("/clock", cdr.CLOCK)
        for second in (1000, 1005, 3, 8, 14, 20):
            log.write(number, second * 10**9, 0, bytes(12))
    assert [len(list(raw_messages(file))) for file in sorted((tmp_path / "bag").glob("*.mcap"))] == [4, 2]


def test_records_that_come_out_of_order_are_put_in_theirs(tmp_path):
    """As of a recorder that got them so: an output still has what happened before it."""
    straight, turned = tmp_path / "straight.mcap", tmp_path / "turned.mcap"
    write_log(simulate(load_scene("ellipsoid_tumbling", ["run.duration=0.3"])), straight)
    messages = list(raw_messages(straight))
    records = [message for message in messages if "/records/" in message.topic.name]
    assert len(records) > 1
    with RawLogWriter(turned) as log:
        stored = {topic.name: topic for topic, *_ in messages}
        numbers = {name: log.copy_topic(topic) for name, topic in stored.items()}
        for topic, *message in [*records[::-1], *(message for message in messages if message not in records)]:
            log.write(numbers[topic.name], *message)
    (expected, reordered) = ([block.records for block in read_log(path).blocks()] for path in (straight, turned))
    assert len(reordered) == len(expected)
    for mine, theirs in zip(reordered, expected, strict=True):
        assert mine.keys() == theirs.keys()
        assert all(np.array_equal(mine[name], theirs[name], equal_nan=True) for name in theirs)


def test_of_a_recording_of_several_runs_each_can_be_read(tmp_path, refused, run_cli):
    """As of a node whose law and load were changed while it ran: each run with its own scene, the last by default."""
    path = tmp_path / "reset.mcap"
    scenes = [
        load_scene("bearing_6203_rig_1000N", ["run.duration=0.04"]),
        load_scene("bearing_6203_rig_400N", ["run.duration=0.02", "contact.normal=hertz_exact"]),
        load_scene("bearing_6203_rig_400N", ["run.duration=0.03"]),
    ]
    runs, numbers = [simulate(scene) for scene in scenes], {}
    with RawLogWriter(path) as log:
        for run_ in runs:
            messages = MessageStream(run_.scene, choice=run_.choice)
            made = [message for block in run_.blocks() for message in messages.messages(block)]
            for topic, stamp, data in (*made, *messages.flush()):
                if topic.full_name not in numbers:
                    numbers[topic.full_name] = log.add_topic(topic.full_name, topic.ros_type)
                log.write(numbers[topic.full_name], stamp, stamp, data)
        log.add_topic("/bearing/command/load", cdr.WRENCH)
    for number, (scene, run) in enumerate(zip(scenes, runs, strict=True), start=1):
        stream = read_log(path, run=number)
        report, missing = report_of(stream)
        outputs = int(1000 * scene.parameters.run.duration) + 1
        assert (report.samples, missing, stream.run, stream.runs) == (outputs, 0, number, 3)
        assert (stream.seconds, stream.scene.parameters) == (pytest.approx(0.001 * outputs), scene.parameters)
        assert (report.law, report.figures) == (run.choice.law, run.report.figures)
        assert report.errors["errors_by_source"] == run.report.errors["errors_by_source"]
        assert bits(stream) == bits(join_blocks(list(simulate(scene).blocks())))
        for command in ("report", "verify"):
            reported = run_cli(command, path, "--json", "--run", number)
            assert json.loads(reported.out)["samples"] == outputs
            assert "holds 3 runs" not in reported.err  # it is the run that was asked for
        assert json.loads(reported.out)["greatest_deviation"] == 0.0
        assert log_document(path, run=number)["facts"][3] == ("outputs", str(outputs))
    assert "run 3 of 3" in run_cli("report", path, "--json").err
    assert read_log(path, last_run=True).run == 3
    (note,) = log_document(path)["notes"]  # a command has a topic that the kind knows
    assert "run 3 of 3" in note
    with pytest.raises(LogError, match=r"holds 3 runs.* output 0 follows 40.*run=1 to 3.*last_run=True"):
        list(read_log(path))
    assert sum(map(len, read_log(path, allow_gaps=True).blocks())) == 41 + 21 + 31
    for wrong in ("0", "4", "-2"):
        assert "give one from 1 to 3" in refused("report", path, "--run", wrong)
    export_log(read_log(path, run=2), "csv", tmp_path / "second")
    assert len((tmp_path / "second" / "outputs.csv").read_text().splitlines()) == 1 + 21
    assert "holds 3 runs" in run_cli("export", path, "--to", "csv", "--out", tmp_path / "tables").err
