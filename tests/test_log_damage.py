"""Damaged, hostile and foreign files, full disks, killed writers: an error that says what to do, and nothing lost."""

import io
import os
import signal
import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from runs import bits, made_up_block, made_up_run, made_up_scene, no_room

from bearing_twin.base.errors import LogError
from bearing_twin.base.sample import Channel
from bearing_twin.command.cli import main
from bearing_twin.log import cdr, run_log
from bearing_twin.log.bag import raw_messages
from bearing_twin.log.cdr import encode
from bearing_twin.log.raw_log import RawLogWriter, Safety, recover
from bearing_twin.log.run_log import read_log, write_log
from bearing_twin.log.stream import samples_message
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate

SCENE = made_up_scene(balls=1)
BLOCK = made_up_block(SCENE, 400)


@pytest.fixture
def log_path(tmp_path, monkeypatch):
    """A log of 400 samples in several chunks."""
    monkeypatch.setattr("bearing_twin.log.mcap_write.CHUNK_BYTES", 60_000)
    write_log(made_up_run(SCENE, [BLOCK]), tmp_path / "run.mcap", run_record=False)
    return tmp_path / "run.mcap"


def test_records_are_no_samples_that_can_be_recovered(tmp_path):
    run = simulate(load_scene("two_spheres"))
    write_log(run, tmp_path / "run.mcap")
    assert read_log(tmp_path / "run.mcap").has_records
    assert recover(tmp_path / "run.mcap", tmp_path / "saved.mcap").samples == run.scene.outputs


def logged(path, *messages):
    """A log of these messages, (topic, type, bytes) each."""
    numbers = {}
    with RawLogWriter(path) as log:
        for name, ros_type, data in messages:
            if name not in numbers:
                numbers[name] = log.add_topic(f"/bearing/{name}", ros_type)
            log.write(numbers[name], 0, 0, data)
    return path


def block(*widths, count=3, names="abc", topic="samples"):
    """A SampleBlock of channels of so many numbers each."""
    channels = tuple(Channel(name, "m", (width,), "") for name, width in zip(names, widths, strict=False))
    numbers = np.ones((count, sum(widths)))
    return topic, cdr.SAMPLE_BLOCK, samples_message(channels, 0, np.arange(max(count, 1)) * 10**6, numbers)


def wave(**changes):
    fields = {"first_sequence": 0, "rate": 1000.0, "unit": "m/s^2", "samples": np.ones(3)} | changes
    return "records/acceleration", cdr.WAVEFORM, encode(cdr.WAVEFORM, fields, 0, "")


EVENT = {"names": "x", "topic": "records/event"}
CONTRADICTIONS = {
    "two channels of one name": ([block(1, 1, names="aa")], "the SampleBlock at output 0 contradicts itself"),
    "a channel without numbers": ([block(1, 0)], "the SampleBlock at output 0 contradicts itself"),
    "no outputs": ([block(1), block(1, count=0)], "the SampleBlock at output 0 contradicts itself"),
    "records without numbers": ([block(1), block(0, **EVENT)], "the SampleBlock at output 0 contradicts itself"),
    "records of two widths": ([block(1), block(2, **EVENT), block(3, **EVENT)], "records on /bearing/records/event"),
    "no rate": ([block(1), wave(rate=0.0)], "the Waveform at sample"),
    "no number as rate": ([block(1), wave(rate=float("nan"))], "the Waveform at sample"),
    "a late wave": ([block(1), wave(first_sequence=1 << 60)], "the Waveform at sample"),
    "an empty wave": ([block(1), wave(samples=np.zeros(0))], "the Waveform at sample"),
}


@pytest.mark.parametrize("case", CONTRADICTIONS)
def test_messages_that_contradict_themselves_are_refused(case, tmp_path, refused):
    messages, sentence = CONTRADICTIONS[case]
    path = logged(tmp_path / "run.mcap", *messages)
    assert sentence in refused("report", path)
    if "Waveform" in sentence:
        assert sentence in refused("spectrum", path, "--topic", "/bearing/records/acceleration")


def test_what_a_channel_is_called_leads_out_of_no_folder(tmp_path, monkeypatch):
    (tmp_path / "deep").mkdir()
    monkeypatch.chdir(tmp_path / "deep")
    logged("run.mcap", block(1, 2, names=["time", "../../escaped"]))
    assert main(["export", "run.mcap", "--to", "csv", "--out", "tables"]) == 0
    names = sorted(file.name for file in Path("tables").iterdir())
    assert names == ["_.._escaped_0.csv", "channels.csv", "time_0.csv"]
    assert [file.name for file in tmp_path.iterdir()] == ["deep"]
    assert "escaped" in Path("tables", "channels.csv").read_text()


@pytest.mark.parametrize("number", [0, 1])
def test_damaged_chunk_is_left_out_and_the_rest_saved(number, log_path, tmp_path):
    """The first chunk describes the channels of all, as the index does, too."""
    samples = bits(read_log(log_path))
    with log_path.open("rb") as stream:
        chunk = make_reader(stream).get_summary().chunk_indexes[number]
    data = bytearray(log_path.read_bytes())
    data[chunk.chunk_start_offset + chunk.chunk_length // 2] ^= 1
    log_path.write_bytes(data)
    with pytest.raises(LogError, match=f"damaged at byte {chunk.chunk_start_offset}: .*bearing_twin recover"):
        list(read_log(log_path))
    recovered = recover(log_path, tmp_path / "saved.mcap")
    saved = bits(read_log(tmp_path / "saved.mcap", allow_gaps=True))
    assert 0 < len(saved) == recovered.samples < 400
    assert all(sample in samples for sample in saved)
    assert (saved[0] == samples[0]) == (number > 0)
    assert saved[-1] == samples[-1]
    assert "CRC" in recovered.problems[0] or "unpacked" in recovered.problems[0]


@pytest.mark.parametrize("cut", [False, True])
def test_a_hole_costs_the_chunk_that_has_it_also_where_the_index_is_missing(cut, log_path, tmp_path):
    """As a disk leaves it when the power fails: zeros where a chunk begins."""
    with log_path.open("rb") as stream:
        chunks = make_reader(stream).get_summary().chunk_indexes
    data, start = bytearray(log_path.read_bytes()), chunks[1].chunk_start_offset
    data[start : start + 500] = bytes(500)
    log_path.write_bytes(data[:-1000] if cut else data)
    recovered = recover(log_path, tmp_path / "saved.mcap")
    saved = bits(read_log(tmp_path / "saved.mcap", allow_gaps=True))
    assert 200 < len(saved) < 400
    assert saved[0] == bits(BLOCK)[0]
    assert saved[-1] == bits(BLOCK)[-1]
    assert f"at byte {start}: " in recovered.problems[0]


def test_what_packs_like_a_bomb_is_read_as_it_was_written(tmp_path):
    """Messages of zeros, as of an empty picture: by zstd 80 MB of them would be 3 kB."""
    zeros = bytes(20_000_000)
    with RawLogWriter(tmp_path / "run.mcap") as log:
        number = log.add_topic("/picture", cdr.STRING)
        for k in range(5):
            log.write(number, k, k, zeros)
        log.write(number, 5, 5, b"after")
    assert [len(message.data) for message in raw_messages(tmp_path / "run.mcap")] == [len(zeros)] * 5 + [5]
    reader = make_reader(io.BytesIO((tmp_path / "run.mcap").read_bytes()), validate_crcs=True)
    assert {chunk.compression for chunk in reader.get_summary().chunk_indexes} == {"lz4", "zstd"}
    assert sum(len(message.data) for _, _, message in reader.iter_messages()) == 5 * len(zeros) + 5


@pytest.mark.parametrize("kept_writes", [3, 6])
def test_full_disk_keeps_what_was_written_and_says_so(tmp_path, monkeypatch, kept_writes):
    monkeypatch.setattr("bearing_twin.log.mcap_write.CHUNK_BYTES", 60_000)
    write, calls = os.pwritev, []

    def full(file, parts, offset):
        calls.append(offset)
        if len(calls) == kept_writes + 1:
            data = b"".join(parts)
            write(file, [data[: len(data) // 2]], offset)
            no_room()
        return write(file, parts, offset)

    monkeypatch.setattr(os, "pwritev", full)
    with pytest.raises(
        LogError, match=r"cannot grow \(No space left on device\): \d+ messages .* are kept in it"
    ) as error:
        write_log(made_up_run(SCENE, [BLOCK]), tmp_path / "run.mcap")
    log = read_log(tmp_path / "run.mcap")
    assert 0 < len(list(log)) < 400
    assert bits(log) == bits(BLOCK)[: len(list(log))]
    assert f": {len(list(raw_messages(tmp_path / 'run.mcap')))} messages" in str(error.value)


def test_writing_on_after_a_full_disk_fails_again(tmp_path, monkeypatch):
    with monkeypatch.context() as patched:
        patched.setattr(os, "pwritev", no_room)
        with pytest.raises(LogError, match=r"cannot be written .*No space left on device"):
            RawLogWriter(tmp_path / "none.mcap")
    assert list(tmp_path.iterdir()) == []
    with RawLogWriter(tmp_path / "run.mcap") as log:
        number = log.add_topic("/clock", cdr.CLOCK)
        log.write(number, 0, 0, bytes(12))
        with monkeypatch.context() as patched:
            patched.setattr(os, "pwritev", no_room)
            with pytest.raises(LogError, match="no message is in it"):
                log.flush()
        for _ in range(2):
            with pytest.raises(LogError, match="make room and write to a new log"):
                log.write(number, 1, 1, bytes(12))
    assert list(raw_messages(tmp_path / "run.mcap")) == []


def test_a_log_whose_name_is_taken_touches_no_other(tmp_path):
    path = tmp_path / "run.mcap"
    log = RawLogWriter(path, safety=Safety(patient=True))
    number = log.add_topic("/clock", cdr.CLOCK)
    for k in range(20):
        log.write(number, k, k, bytes(100))
        log.flush()
        if k == 10:
            path.unlink()
            path.write_bytes(b"another")
    with pytest.raises(LogError, match="removed or cut by another program"):
        log.close()
    assert path.read_bytes() == b"another"


def test_a_split_that_finds_no_room_loses_nothing(tmp_path, monkeypatch):
    """Neither a flush nor the next file can be written when a new file is due: the old one goes on until both can."""
    opened = os.open

    def no_new_file(path, *arguments):
        return (no_room if str(path).endswith(".mcap") else opened)(path, *arguments)

    with RawLogWriter(tmp_path / "bag", safety=Safety(patient=True, split_seconds=1e-8)) as log:
        number = log.add_topic("/clock", cdr.CLOCK)
        for first, name, fails in ((0, "pwritev", os.pwritev), (20, "pwritev", no_room), (40, "open", no_new_file)):
            with monkeypatch.context() as patched:
                patched.setattr(os, name, fails)
                for k in range(first, first + 20):
                    log.write(number, k, k, bytes(12))
        log.flush()
        for k in range(60, 80):
            log.write(number, k, k, bytes(12))
        assert (log.problem, log.dropped) == ("", 0)
    assert [message.log_time for message in raw_messages(tmp_path / "bag")] == list(range(80))
    assert len(list((tmp_path / "bag").glob("*.mcap"))) > 2


def test_killed_writer_leaves_a_recoverable_log(tmp_path):
    program = """
import sys, time
from bearing_twin.log import cdr, raw_log, run_log
from bearing_twin.log.bag import Qos
from bearing_twin.log.raw_log import Safety
from bearing_twin.log.raw_log import RawLogWriter
log = RawLogWriter(sys.argv[1], safety=Safety(max_loss=0.05))
number = log.add_topic("/clock", cdr.CLOCK)
for k in range(1000):
    log.write(number, k, k, bytes(12))
while log.messages < 1000:
    time.sleep(0.01)
print("flushed", flush=True)
time.sleep(60)
"""
    path = tmp_path / "run.mcap"
    command = [sys.executable, "-c", program, str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, cwd=Path(__file__).parents[1]) as writer:
        assert writer.stdout.readline() == b"flushed\n"
        writer.send_signal(signal.SIGKILL)
    assert recover(path, tmp_path / "saved.mcap").messages == 1000
    assert sorted(file.name for file in tmp_path.iterdir()) == ["run.mcap", "saved.mcap"]


def test_a_chunk_with_an_absurd_size_or_compression_costs_no_other(tmp_path):
    """One flipped bit each: of the size before packing, of the compression, of kinds and lengths of records."""
    with RawLogWriter(tmp_path / "run.mcap") as log:
        number = log.add_topic("/clock", cdr.CLOCK)
        for k in range(40):
            log.write(number, k, k, bytes(12))
            if k % 10 == 9:
                log.flush()
    content = (tmp_path / "run.mcap").read_bytes()
    chunk = make_reader(io.BytesIO(content)).get_summary().chunk_indexes[1]
    start, index = chunk.chunk_start_offset, chunk.chunk_start_offset + chunk.chunk_length
    for position, bit, saved in (
        (start + 9 + 16 + 5, 5, 30), (start + 9 + 24 + 4 + 4, 1, 30), (start, 2, 30), (start + 2, 1, 30),
        (index + 2, 1, 40), (index, 1, 40),
    ):  # fmt: skip
        data = bytearray(content)
        data[position] ^= 1 << bit
        (tmp_path / "flipped.mcap").write_bytes(data)
        (tmp_path / "saved.mcap").unlink(missing_ok=True)
        assert recover(tmp_path / "flipped.mcap", tmp_path / "saved.mcap").messages == saved, position
        with pytest.raises(LogError):
            list(raw_messages(tmp_path / "flipped.mcap"))


ONE = np.ones((1, 1))


def waved(path, starts, size=1 << 16):
    """A log of a Waveform of so many samples from each of these numbers on, and of an output behind each."""
    with RawLogWriter(path) as log:
        waves, samples = (
            log.add_topic(f"/bearing/{name}", ros_type)
            for name, ros_type in (("records/acceleration", cdr.WAVEFORM), ("samples", cdr.SAMPLE_BLOCK))
        )
        for number, first in enumerate(starts):
            *_, data = wave(first_sequence=first, rate=float(size), samples=np.ones(size, np.float32))
            log.write(waves, number, number, data)
            output = samples_message((Channel("a", "m", (), ""),), number, np.array([(number + 1) * 10**9]), ONE)
            log.write(samples, number, number, output)
    return path


def test_a_long_record_is_read_piece_by_piece(tmp_path):
    path = waved(tmp_path / "run.mcap", [k << 16 for k in range(60)])  # 15 MB of samples
    tracemalloc.start()
    try:
        assert sum(len(block.records["acceleration"]) for block in read_log(path).blocks()) == 60 << 16
        assert tracemalloc.get_traced_memory()[1] < 10e6
    finally:
        tracemalloc.stop()


def test_records_between_two_outputs_are_not_without_end(tmp_path, monkeypatch):
    monkeypatch.setattr(run_log, "MOST_HELD", 1000)
    path = waved(tmp_path / "run.mcap", [k * 300 for k in range(4)], 300)
    assert len(list(read_log(path).blocks())) == 4
    monkeypatch.setattr(run_log, "MOST_HELD", 500)
    with pytest.raises(LogError, match="more numbers on /bearing/records/acceleration than are held at once"):
        list(read_log(path).blocks())


def test_a_record_that_goes_back_is_refused(tmp_path):
    path = waved(tmp_path / "run.mcap", [0, 600, 300], 300)
    with pytest.raises(LogError, match="is behind a later one"):
        list(read_log(path).blocks())
