"""What recorder_node and replay_node think: losses, definitions, and the way from a log back to messages. No ROS."""

import errno
import json
import math
import os

import pytest
from made_up_run import a_choice, made_up_block, made_up_run, made_up_scene
from mcap.writer import Writer
from runs import receive

from bearing_twin.base.errors import LogError
from bearing_twin.command.cli import DOUBTFUL, main
from bearing_twin.kinds import KINDS
from bearing_twin.log import cdr
from bearing_twin.log.bag import Qos, offered_qos, raw_messages
from bearing_twin.log.mcap_read import LARGEST_MESSAGE, McapReader, StoredTopic
from bearing_twin.log.raw_log import RECORDING_RECORD, RawLogWriter, Safety
from bearing_twin.log.recover import recover
from bearing_twin.log.run_log import read_log, write_log
from bearing_twin.log.sample_block import samples_message
from bearing_twin.log.stream import MessageStream, topics
from bearing_twin.nodes.recorder_node import (
    MIXED,
    Recording,
    Sequences,
    default_topics,
    warning_of,
)
from bearing_twin.nodes.replay_node import Renaming, ReplayLoop, logged_topics
from bearing_twin.run.scene import Scene

MS = 1_000_000
SCENE = made_up_scene(balls=2)
BLOCK = made_up_block(SCENE, 120)
SAMPLES = "/bearing/samples"


def sample_block(first, count):
    rows = slice(first, first + count)
    return samples_message(SCENE.channels, first, BLOCK.time_ns[rows], BLOCK.matrix()[rows])


def played(log, until=None, **options):
    """Wall times [ns from the start], topics and bytes of a replay that nothing holds up, of `until` messages."""
    out, clock = [], [10**12]
    loop = ReplayLoop(log, lambda m: out.append((clock[0] - 10**12, m.topic, m.cdr)), **{"rate": 1.0} | options)
    while (wake_at := loop.turn(clock[0])) is not None and (until is None or len(out) < until):
        clock[0] = max(clock[0], wake_at)
    return out


@pytest.fixture
def log(tmp_path):
    write_log(made_up_run(SCENE, [BLOCK]), tmp_path / "run.mcap")
    return tmp_path / "run.mcap"


def test_losses_and_restarts_are_counted():
    stream = Sequences()
    assert [stream.note(*block) for block in ((100, 50), (150, 50), (230, 50), (0, 50), (50, 10))] == [0, 0, 30, 0, 0]
    assert (stream.received, stream.lost, stream.restarts) == (210, 30, 1)
    for _ in range(MIXED + 1):  # one publisher that starts again and again mixes with nobody
        stream.note(0, 10)
    assert (stream.restarts, stream.mixed, stream.lost) == (2 + MIXED, 0, 30)


def test_outputs_of_several_publishers_are_mixed_and_none_of_them_counted_as_lost(tmp_path, capsys):
    """Two bearings in one namespace; one that is started again while its old end is still known steps back once."""
    for firsts, mixed in (((50, 0, 60, 10, 70), True), ((50, 0, 10, 30), False)):
        path = tmp_path / f"{mixed}.mcap"
        recording = Recording(path, ["*"])
        recording.add(SAMPLES, cdr.SAMPLE_BLOCK, cdr.type_hash(cdr.SAMPLE_BLOCK), (Qos(),))
        for number, first in enumerate(firsts, start=1):
            recording.publishers(SAMPLES, 2)
            assert receive(recording, SAMPLES, 1000, 900, sample_block(first, 10), number) == 0
        recording.publishers(SAMPLES, 1)
        receive(recording, SAMPLES, 1000, 900, sample_block(90, 5), 8)  # behind whichever came last
        assert receive(recording, SAMPLES, 1000, 900, sample_block(97, 3), 10) == 2
        status = recording.status()
        assert (status["samples_lost"], status["mixed"], status["uncounted"]) == (2, SAMPLES * mixed, SAMPLES)
        assert ("outputs are mixed" in warning_of(status)) is mixed
        recording.close()
        assert main(["report", str(path), "--json", "--strict"]) == DOUBTFUL
        assert ("several nodes sent samples at a time" in capsys.readouterr().err) is mixed


@pytest.mark.parametrize("numbers", [[3, 4, 5, 6], [3, 5, 6, 9], [3, 4, 1, 2], [7], []])
def test_many_numbers_are_counted_as_one_by_one(numbers):
    many, single = Sequences(), Sequences()
    for given in ([1, 2], numbers):
        many.note_all(given)
        for one in given:
            single.note(one, 1)
    assert vars(many) == vars(single)


def test_a_report_tells_what_a_recorder_lost(tmp_path, capsys):
    recording = Recording(tmp_path / "out.mcap", ["*"])
    recording.add(SAMPLES, cdr.SAMPLE_BLOCK, cdr.type_hash(cdr.SAMPLE_BLOCK), (Qos(),))
    recording.add("/other", cdr.STATE, cdr.type_hash(cdr.STATE), (Qos(),))
    receive(recording, SAMPLES, 1000, 900, sample_block(0, 50), 1)
    recording.add("/third", cdr.STATE, cdr.type_hash(cdr.STATE), (Qos(),))
    for number in (1, 4):
        receive(recording, "/other", 1000, 900, bytes(8), number)
    recording.publishers("/third", 2)
    recording.close()
    assert read_log(tmp_path / "out.mcap").losses == {
        "messages_lost": 2, "messages_dropped": 0, "messages_unreadable": 0, "uncounted": "/third",
    }  # fmt: skip
    assert main(["report", str(tmp_path / "out.mcap"), "--json", "--strict"]) == DOUBTFUL
    said = capsys.readouterr()
    assert json.loads(said.out)["messages_lost"] == 2
    assert "2 messages were lost on the way to the recorder" in said.err


def test_messages_of_one_publisher_are_counted_by_their_numbers(tmp_path):
    recording = Recording(tmp_path / "out.mcap", ["*"])
    for topic in ("/one", "/two", "/three", "/four"):
        recording.add(topic, cdr.STATE, cdr.type_hash(cdr.STATE), (Qos(),))
    for topic, numbers in {"/one": (4, 5, 9), "/two": (1, 2), "/three": (7, 1), "/four": (None, None)}.items():
        for number in numbers:
            receive(recording, topic, 1, 1, b"", number)
    status = recording.status()
    assert (status["messages"], status["messages_lost"], status["messages_before"]) == (9, 3, 3)
    assert (status["lost_on"], status["uncounted"]) == ("/one", "/four /three")
    recording.publishers("/one", 2)
    assert recording.status()["messages_lost"] == 0
    recording.close()
    with McapReader(tmp_path / "out.mcap") as reader:
        [reported] = [item.metadata for item in reader.content() if getattr(item, "name", "") == RECORDING_RECORD]
    assert reported["uncounted"] == "/four /one /three"


def test_a_message_that_no_reader_takes_is_counted_and_left_out(tmp_path):
    path, large = tmp_path / "out.mcap", bytes(LARGEST_MESSAGE)
    recording = Recording(path, ["*"])
    recording.add("/other", cdr.STRING, cdr.type_hash(cdr.STRING), (Qos(),))
    for number, data in enumerate((b"before", large, large + b"1", b"after"), start=1):
        receive(recording, "/other", number, number, data, number)
    assert [recording.status()[f"messages{what}"] for what in ("", "_unreadable", "_lost")] == [3, 1, 0]
    recording.close()
    assert [len(message.data) for message in raw_messages(path)] == [6, LARGEST_MESSAGE, 5]


def test_no_more_topics_are_recorded_than_are_read(tmp_path, monkeypatch):
    """Anybody can publish on as many as he likes; a log of one more would be refused whole."""
    for module in ("nodes.recorder_node", "log.mcap_read"):
        monkeypatch.setattr(f"bearing_twin.{module}.MOST_TOPICS", 5)
    recording = Recording(tmp_path / "out.mcap", ["*"])
    for k in range(7):
        topic, what = f"/{k}", (cdr.STRING, cdr.type_hash(cdr.STRING), (Qos(),))
        if k < 5:
            recording.add(topic, *what)
            receive(recording, topic, k, k, bytes(4), 1)
        else:
            with pytest.raises(LogError, match="there are 5 topics in the log"):
                recording.add(topic, *what)
    recording.close()
    assert len(list(raw_messages(tmp_path / "out.mcap"))) == 5


def test_outputs_and_restarts_are_those_of_samples_alone(tmp_path):
    """A node that is reset begins its records anew, too; they hold rows of their own, which are no outputs."""
    recording = Recording(tmp_path / "out.mcap", ["*"])
    for topic in (SAMPLES, "/bearing/records/companion"):
        recording.add(topic, cdr.SAMPLE_BLOCK, cdr.type_hash(cdr.SAMPLE_BLOCK), (Qos(),))
        for number, first in enumerate((0, 50, 0), start=1):
            receive(recording, topic, 1000, 900, sample_block(first, 50), number)
    status = recording.status()
    recording.close()
    assert (status["samples_received"], status["samples_lost"], status["restarts"]) == (150, 0, 1)


def told_after_a_crash(path):
    """What the records of a recording that was never completed say was lost: (messages lost, messages dropped)."""
    cut, whole = path.with_name("cut.mcap"), path.with_name("whole.mcap")
    cut.write_bytes(path.read_bytes())
    recover(cut, whole)
    with McapReader(whole) as reader:
        reported = [item.metadata for item in reader.content() if getattr(item, "name", "") == RECORDING_RECORD]
    return [(int(one["messages_lost"]), int(one["messages_dropped"])) for one in reported]


def test_a_crash_does_not_take_the_count_of_what_was_lost(tmp_path, monkeypatch):
    """Each loss is reported once; what was dropped while the disk was full is reported when there is room again."""
    monkeypatch.setattr("bearing_twin.log.mcap_write.HELD_BYTES", 5000)
    recording = Recording(tmp_path / "out.mcap", ["*"], safety=Safety(patient=True))
    recording.add("/one", cdr.CLOCK, cdr.type_hash(cdr.CLOCK), (Qos(),))
    for number in (1, 4, 5, 7):
        receive(recording, "/one", 1, 1, bytes(100), number)
        recording.note_losses()
    assert told_after_a_crash(tmp_path / "out.mcap") == [(2, 0), (3, 0)]

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(os, "pwritev", full)
        for number in range(8, 108):
            receive(recording, "/one", 1, 1, bytes(100), number)
            recording.log.flush()  # as the log does by itself every `max_loss` seconds
        recording.note_losses()
    dropped = recording.status()["messages_dropped"]
    assert dropped > 10
    recording.log.flush()
    recording.note_losses()
    (tmp_path / "whole.mcap").unlink()
    assert told_after_a_crash(tmp_path / "out.mcap") == [(2, 0), (3, 0), (3, dropped)]
    recording.close()


def test_what_is_wanted_is_new_matches_and_is_not_hidden(tmp_path):
    recording = Recording(tmp_path / "out.mcap", ["/bearing/*", "/tf"])
    names = ["/bearing/state", "/bearing/study_result", "/tf", "/tf_static", "/bearing/run_study/_action/feedback"]
    assert [recording.wants(name) for name in names] == [True, True, True, False, False]
    recording.add("/bearing/state", cdr.STATE, cdr.type_hash(cdr.STATE), (Qos(),))
    assert not recording.wants("/bearing/state")
    recording.close()


def test_a_recording_holds_the_bytes_and_what_was_lost(tmp_path):
    recording = Recording(tmp_path / "out.mcap", ["/bearing/*", "/tf"])
    assert recording.wants(SAMPLES)
    assert recording.wants("/tf")
    assert not recording.wants("/rosout")
    recording.add(SAMPLES, cdr.SAMPLE_BLOCK, cdr.type_hash(cdr.SAMPLE_BLOCK), (Qos(),))
    assert not recording.wants(SAMPLES)
    blocks = [sample_block(0, 50), sample_block(50, 20), sample_block(90, 30)]
    lost = [receive(recording, SAMPLES, 1000 + k, 900 + k, data) for k, data in enumerate(blocks)]
    assert lost == [0, 0, 20]
    recording.close()
    recording.close()
    assert receive(recording, SAMPLES, 2000, 2000, blocks[0]) == 0  # too late, and harmless
    messages = list(raw_messages(tmp_path / "out.mcap"))
    assert [(m.log_time, m.publish_time, m.data) for m in messages] == [
        (1000 + k, 900 + k, data) for k, data in enumerate(blocks)
    ]
    stored = read_log(tmp_path / "out.mcap", allow_gaps=True)
    assert sum(len(block) for block in stored.blocks()) == 100
    assert stored.metadata[RECORDING_RECORD]["samples_lost"] == "20"
    assert stored.metadata[RECORDING_RECORD]["samples_received"] == "100"


def test_rows_of_records_that_are_lost_are_no_outputs(tmp_path):
    recording, topic = Recording(tmp_path / "out.mcap", ["/bearing/*"]), "/bearing/records/companion"
    recording.add(topic, cdr.SAMPLE_BLOCK, cdr.type_hash(cdr.SAMPLE_BLOCK), (Qos(),))
    assert [receive(recording, topic, 1, 1, sample_block(first, 2)) for first in (0, 2, 5)] == [0, 0, 1]
    status = recording.status()
    recording.close()
    assert (status["records_lost"], status["samples_lost"], status["samples_received"]) == (1, 0, 0)
    with McapReader(tmp_path / "out.mcap") as reader:
        [reported] = [item.metadata for item in reader.content() if getattr(item, "name", "") == RECORDING_RECORD]
    assert (reported["records_lost"], reported["samples_lost"]) == ("1", "0")


def test_outputs_that_nobody_sent_were_not_lost_on_the_way(tmp_path):
    recording = Recording(tmp_path / "out.mcap", ["/bearing/*"])
    recording.add(SAMPLES, cdr.SAMPLE_BLOCK, cdr.type_hash(cdr.SAMPLE_BLOCK), (Qos(),))
    blocks = [sample_block(0, 1), sample_block(20, 1), sample_block(60, 1)]  # a thinned log, played
    numbers = 7, 8, 10  # of messages: the last but one went astray
    reported = [receive(recording, SAMPLES, 1, 1, data, number) for data, number in zip(blocks, numbers, strict=True)]
    assert reported == [0, 0, 39]
    assert recording.status()["samples_lost"] == 19 + 39
    recording.close()


def test_definitions_of_other_packages_come_from_their_prefix(tmp_path):
    folder = tmp_path / "share" / "others" / "msg"
    folder.mkdir(parents=True)
    (folder / "Pair.msg").write_text("# a pair\nOne first\nOne second\n")
    (folder / "One.msg").write_text("float64 value # [1]\n")
    recording = Recording(tmp_path / "out.mcap", ["*"], [tmp_path])
    recording.add("/pair", "others/msg/Pair", "RIHS01_" + "0" * 64, (Qos(),))
    with pytest.raises(LogError, match="no definition of others/msg/Missing"):
        recording.add("/missing", "others/msg/Missing", "INVALID", (Qos(),))
    receive(recording, "/pair", 1, 1, b"\0\1\0\0" + bytes(16))
    recording.close()
    [message] = raw_messages(tmp_path / "out.mcap")
    assert message.topic.ros_type == "others/msg/Pair"
    assert message.topic.definition.startswith("# a pair")
    assert message.topic.definition.endswith("MSG: others/One\nfloat64 value # [1]\n")
    assert message.topic.metadata["topic_type_hash"] == "RIHS01_" + "0" * 64


def test_a_replay_goes_by_time_whatever_the_order_in_the_file(tmp_path):
    with RawLogWriter(tmp_path / "out.mcap", run_record=False) as writer:
        clock = cdr.schema_text(cdr.CLOCK)
        number = writer.add_topic("/clock", cdr.CLOCK, clock, cdr.type_hash(cdr.CLOCK), (Qos(),))
        for arrived in (9000, 9100, 2000, 2100, 2050):
            writer.write(number, arrived * MS, 0, bytes(12))
            writer.flush()
    out, wall = [], [10**12]
    loop = ReplayLoop(tmp_path / "out.mcap", lambda m: out.append((wall[0] - 10**12) // MS), 1.0)
    while (wake_at := loop.turn(wall[0])) is not None:
        wall[0] = max(wall[0], wake_at)
    assert out == [0, 50, 100, 7000, 7100]


@pytest.mark.parametrize("rate", [0.5, 1.0, 4.0])
def test_a_replay_keeps_bytes_order_and_pace(log, rate):
    messages = list(raw_messages(log))
    out = played(log, rate=rate)
    assert [(topic, data) for _, topic, data in out] == [(m.topic.name, m.data) for m in messages]
    assert [wall for wall, _, _ in out] == [int(m.log_time / rate) for m in messages]


def test_a_replay_can_start_later(log):
    messages = list(raw_messages(log))
    latched = [m for m in messages if m.topic.name.endswith(("/scene", "/robot_description"))]
    assert {m.log_time for m in latched} == {0}
    out = played(log, start_ns=50 * MS)
    assert [(t, d) for _, t, d in out] == [
        (m.topic.name, m.data) for m in [*latched, *(m for m in messages if m.log_time >= 50 * MS)]
    ]
    assert out[0][0] == out[len(latched)][0] == 0


def test_a_replay_from_the_middle_of_split_files_tells_what_was_latched_last(tmp_path):
    """Said anew while it was recorded, in another chunk and another file; what is said later is not reported before."""
    safety = Safety(split_seconds=4.0)
    with RawLogWriter(tmp_path / "bag", run_record=False, safety=safety) as writer:
        said, ticks = (
            writer.add_topic(name, cdr.STRING, qos=(qos,))
            for name, qos in (("/said", Qos(1, durability="transient_local")), ("/ticks", Qos()))
        )
        for second in range(10):
            writer.write(ticks, second * 1000 * MS, 0, bytes([second]))
            if second in (1, 3, 7):
                writer.write(said, (second * 1000 + 1) * MS, 0, bytes([100 + second]))
            writer.flush()
    for start, latched in ((0.5, []), (2.0, [101]), (3.5, [103]), (6.0, [103]), (7.5, [107]), (9.0, [107])):
        out = played(tmp_path / "bag", start_ns=round(start * 1000 * MS))
        first = next(data[0] for _, topic, data in out if topic == "/ticks")
        assert first == math.ceil(start)
        assert [data[0] for _, topic, data in out if topic == "/said"][: len(latched)] == latched
        assert [topic for _, topic, _ in out[: len(latched)]] == ["/said"] * len(latched)


def test_a_loop_starts_again_at_once(log):
    messages = [(m.topic.name, m.data) for m in raw_messages(log)]
    out = played(log, loop=True, until=2 * len(messages) + 5)
    assert [(t, d) for _, t, d in out] == [*messages, *messages, *messages][: len(out)]
    assert out[len(messages)][0] == out[len(messages) - 1][0]
    first, second = ([wall for wall, _, _ in out[start : start + len(messages)]] for start in (0, len(messages)))
    assert [wall - second[0] for wall in second] == first


def test_a_log_that_covers_no_time_is_played_once_and_not_in_a_loop(tmp_path):
    """Its rounds would follow each other as fast as the machine can."""
    path = tmp_path / "run.mcap"
    writer = RawLogWriter(path)
    number = writer.add_topic("/x", cdr.STRING)
    writer.write_all([(number, 10**9 + k, 10**9 + k, b"\0\1\0\0" + bytes(4)) for k in range(3)])
    writer.close()
    with pytest.raises(LogError, match="from 0 s on covers 2e-09 s, too little for `loop`"):
        played(path, loop=True, until=100)
    assert len(played(path)) == 3


def test_a_replay_goes_by_the_times_of_arrival_and_counts_its_rounds(tmp_path):
    """Messages that were sent later than they say, or long before: the log's own times pace them."""
    with RawLogWriter(tmp_path / "out.mcap", run_record=False) as writer:
        clock = cdr.schema_text(cdr.CLOCK)
        number = writer.add_topic("/clock", cdr.CLOCK, clock, cdr.type_hash(cdr.CLOCK), (Qos(),))
        for arrived, sent in ((100, 5), (140, 90), (170, 60)):
            writer.write(number, arrived * MS, sent * MS, bytes(12))
    out, wall = [], [10**12]
    loop = ReplayLoop(tmp_path / "out.mcap", lambda m: out.append((m.time_ns, wall[0])), 1.0)
    assert loop.rounds == 0
    while (wake_at := loop.turn(wall[0])) is not None:
        wall[0] = max(wall[0], wake_at)
    assert [(t // MS, (w - 10**12) // MS) for t, w in out] == [(100, 0), (140, 40), (170, 70)]
    assert loop.rounds == 1


def test_a_replay_from_beyond_the_end_says_so(log):
    with pytest.raises(LogError, match="from 9 s on holds no messages"):
        played(log, start_ns=9_000 * MS)


def test_a_topic_whose_type_has_changed_since_is_left_out_with_a_word(tmp_path):
    old = "RIHS01_" + "1" * 64
    path = tmp_path / "other.mcap"
    with RawLogWriter(path) as log:
        same = log.add_topic(SAMPLES, cdr.SAMPLE_BLOCK)
        other = log.add_topic("/bearing/contacts", cdr.CONTACTS, "uint8 balls\n", old, (Qos(),))
        log.write(same, 1, 1, sample_block(0, 50))
        log.write(other, 2, 2, bytes(8))
    loop = ReplayLoop(path, lambda message: None, 1.0)
    assert list(loop.topics) == [SAMPLES]
    [sentence] = loop.notes
    assert "/bearing/contacts is not played: bearing_twin_msgs/msg/Contacts has changed its fields" in sentence
    assert [topic for _, topic, _ in played(path)] == [SAMPLES]


def test_of_a_topic_with_messages_of_two_types_one_is_played(tmp_path):
    """Subscribers would read the bytes of the other as of the one."""
    path = tmp_path / "two.mcap"
    with path.open("wb") as file:
        log = Writer(file)
        log.start("ros2")
        for time_ns, ros_type in enumerate((cdr.STRING, cdr.STATE, cdr.STRING)):
            schema = log.register_schema(ros_type, "ros2msg", cdr.schema_text(ros_type).encode())
            log.add_message(log.register_channel("/one", "cdr", schema), time_ns, bytes([time_ns]), time_ns)
        log.finish()
    loop = ReplayLoop(path, lambda message: None, 1.0)
    assert loop.notes == [f"messages of type {cdr.STATE} on /one are not played, as others have type {cdr.STRING}"]
    assert [data for _, _, data in played(path)] == [b"\0", b"\2"]


def test_everything_of_every_kind_is_recorded_by_default(tmp_path):
    recording = Recording(tmp_path / "out.mcap", default_topics())
    for name in ("/bearing/state", "/two_spheres/first/wrench", "/sphere_on_beam/records/contact", "/tf"):
        assert recording.wants(name)
    assert not recording.wants("/elsewhere/state")
    left = Recording(tmp_path / "left.mcap", default_topics("/left"))
    names = "/left/state", "/left/records/contact", "/tf", "/tf_static", "/bearing/state", "/leftover/state"
    assert [left.wants(name) for name in names] == [True] * 4 + [False] * 2
    left.close()
    assert all(
        recording.wants(topic.full_name)
        for kind in KINDS
        for topic in topics(Scene(kind, kind, "", KINDS[kind].parameters()))
    )
    recording.close()


def test_a_damaged_log_is_refused_with_advice(log):
    data = bytearray(log.read_bytes())
    data[-100] ^= 1  # in the index
    log.write_bytes(data)
    with pytest.raises(LogError, match="recover"):
        logged_topics(log)


def test_a_log_that_is_being_written_is_played_to_its_last_whole_chunk_and_what_is_foreign_left_out(tmp_path):
    with RawLogWriter(tmp_path / "out.mcap", run_record=False) as writer:
        clock = cdr.schema_text(cdr.CLOCK)
        numbers = [writer.add_topic("/clock", cdr.CLOCK, clock, cdr.type_hash(cdr.CLOCK), (Qos(),))]
        numbers.append(writer.copy_topic(StoredTopic("/other", "", "", "json", {}, "")))
        for k in range(10):
            writer.write(numbers[k % 2], k * MS, 0, bytes(12))
            writer.flush()
        loop = ReplayLoop(tmp_path / "out.mcap", lambda m: None, 1.0)
        assert list(loop.topics) == ["/clock"]
        assert "has no end" in loop.notes[0]
        assert "/other" in loop.notes[1]


@pytest.mark.parametrize(
    ("text", "qos"),
    [
        ("", Qos()),
        ("- depth: [", Qos()),
        (
            "- {reliability: best_effort, durability: transient_local, depth: 3}",
            Qos(3, "best_effort", "transient_local"),
        ),
        ("- {reliability: 1, durability: 2, depth: 0}", Qos()),
        ("- depth: 3\n  reliability: 2\n  durability: 2\n- depth: 9\n", Qos(3, "best_effort")),
        ("- {reliability: 2, durability: 2, depth: 3, more: [" + "1, " * 5000 + "]}", Qos()),
    ],
)
def test_quality_of_service_is_read_in_words_and_numbers(text, qos):
    assert offered_qos(text) == qos


def reported(stream):
    """Topic, type and bytes of everything that a stream says of made up outputs."""
    parts = [*stream.messages(BLOCK), *stream.flush()]
    return [(topic.full_name, topic.ros_type, whole(data)) for topic, _, data in parts]


def whole(data):
    """Bytes filled up to words of four, as they are on the wire."""
    return data + bytes(-len(data) % 4)


def test_a_log_is_told_in_another_namespace_and_with_other_frames_as_a_node_would_say_it():
    plain, prefixed = (reported(MessageStream(SCENE, choice=a_choice(), frame_prefix=one)) for one in ("", "left/"))
    renaming = Renaming([name for name, _, _ in plain], "/left", "left/")
    found = [(renaming.topic(name), whole(renaming.data(name, kind, data))) for name, kind, data in plain]
    assert found == [(renaming.topic(name), data) for name, _, data in prefixed]
    names = {name for name, _ in found}
    assert {"/left/ball_0/wrench", "/left/samples", "/left/robot_description", "/tf"} <= names
    assert not any(name.startswith("/bearing") for name in names)
    assert [one.data("/bearing/state", cdr.STATE, b"x") for one in (Renaming([]), Renaming([], "a"))] == [b"x"] * 2
    with pytest.raises(LogError, match="cannot be decoded"):
        Renaming([], "", "left/").data("/bearing/state", cdr.STATE, b"x")
    both = Renaming(["/left/samples", "/right/samples", "/left/state"], "cell")
    assert both.topic("/left/state") == "/cell/left/state"


def test_every_one_of_many_that_no_reader_takes_is_counted(tmp_path, capsys):
    recording = Recording(tmp_path / "out.mcap", ["*"])
    recording.add(SAMPLES, cdr.SAMPLE_BLOCK, cdr.type_hash(cdr.SAMPLE_BLOCK), (Qos(),))
    data = [b"none", sample_block(0, 5), b"", b"neither"]
    recording.receive_all(SAMPLES, [1] * 4, [1] * 4, data, [1, 2, 3, 4])
    status = recording.status()
    recording.close()
    assert (status["messages"], status["messages_unreadable"], status["samples_received"]) == (1, 3, 5)
    assert warning_of(status).startswith("3 messages are not logged")
    assert main(["report", str(tmp_path / "out.mcap"), "--strict", "--json"]) == DOUBTFUL
    assert json.loads(capsys.readouterr().out)["messages_unreadable"] == 3
