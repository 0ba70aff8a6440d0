"""What a recording and a log count where several things come together. No ROS."""

import errno
import os
from itertools import pairwise

import pytest
from made_up_run import made_up_block, made_up_scene

from bearing_twin.log import cdr
from bearing_twin.log.bag import Qos, raw_messages
from bearing_twin.log.mcap_read import McapReader
from bearing_twin.log.raw_log import RECORDING_RECORD, RawLogWriter, Safety
from bearing_twin.log.sample_block import samples_message
from bearing_twin.nodes.recorder_node import MIXED, Recording, Sequences

SCENE = made_up_scene(balls=2)
BLOCK = made_up_block(SCENE, 120)


def sample_block(first, count):
    rows = slice(first, first + count)
    return samples_message(SCENE.channels, first, BLOCK.time_ns[rows], BLOCK.matrix()[rows])


def counts_in(path):
    with McapReader(path) as reader:
        return [item.metadata for item in reader.content() if getattr(item, "name", "") == RECORDING_RECORD]


def test_one_publisher_that_starts_again_and_again_mixes_with_nobody():
    stream = Sequences()
    for _ in range(MIXED + 3):
        stream.saw(0, 50)
        stream.saw(50, 10)
    assert (stream.restarts, stream.mixed, stream.lost) == (MIXED + 2, 0, 0)


def test_every_one_of_many_that_no_reader_takes_is_counted(tmp_path):
    recording = Recording(tmp_path / "out.mcap", ["*"])
    recording.add("/samples", cdr.SAMPLE_BLOCK, cdr.type_hash(cdr.SAMPLE_BLOCK), (Qos(),))
    data = [b"none", sample_block(0, 5), b"", b"neither"]
    recording.receive_all("/samples", [1] * 4, [1] * 4, data, [1, 2, 3, 4])
    status = recording.status()
    recording.close()
    assert (status["messages"], status["messages_unreadable"], status["samples_received"]) == (1, 3, 5)


@pytest.mark.parametrize("together", [1, 3])
def test_messages_that_a_full_disk_takes_are_counted_one_by_one(tmp_path, monkeypatch, together):
    monkeypatch.setattr("bearing_twin.log.mcap_write.CHUNK_BYTES", 2000)
    monkeypatch.setattr("bearing_twin.log.mcap_write.HELD_BYTES", 5000)
    write, full = os.pwritev, [False]

    def sometimes(*arguments):
        if full[0]:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(*arguments)

    monkeypatch.setattr(os, "pwritev", sometimes)
    count = 120 // together
    with RawLogWriter(tmp_path / "run.mcap", safety=Safety(patient=True)) as log:
        number = log.add_topic("/clock", cdr.CLOCK, cdr.schema_text(cdr.CLOCK), "", (Qos(),))
        for k in range(count):
            full[0] = count // 4 <= k < count - 2
            log.write_all([(number, k, k, bytes(100))] * together)
            log.flush()
        dropped = log.dropped
    kept = [message.log_time for message in raw_messages(tmp_path / "run.mcap")]
    assert dropped > 0
    assert len(kept) + dropped == together * count
    assert all(one <= other for one, other in pairwise(kept))
