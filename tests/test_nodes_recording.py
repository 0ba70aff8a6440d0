"""What recorder_node and replay_node compute: losses, definitions, and the way from a log back to messages. No ROS."""

import json
import math
import os

import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from runs import made_up_block, made_up_run, made_up_scene, no_room

from bearing_twin.base.errors import LogError
from bearing_twin.command.cli import DOUBTFUL
from bearing_twin.kinds import KINDS
from bearing_twin.log import cdr
from bearing_twin.log.bag import Qos, offered_qos, raw_messages
from bearing_twin.log.mcap_read import LARGEST_MESSAGE
from bearing_twin.log.mcap_write import StoredTopic
from bearing_twin.log.raw_log import RECORDING_RECORD, RawLogWriter, Safety, recover
from bearing_twin.log.run_log import read_log, write_log
from bearing_twin.log.stream import samples_message, topics
from bearing_twin.nodes.recorder_node import Received, Recording, default_topics, warning_of
from bearing_twin.nodes.replay_node import ReplayLoop, renamed_topics
from bearing_twin.run.scene import Scene

MS = 1_000_000
SCENE = made_up_scene(balls=2)
BLOCK = made_up_block(SCENE, 120)
SAMPLES = "/bearing/samples"


def sample_block(first, count):
    rows = slice(first, first + count)
    return samples_message(SCENE.channels, first, BLOCK.time_ns[rows], BLOCK.matrix()[rows])


def recording_of(path, *names, ros_type=cdr.STATE, **options):
    """A recording of everything with these topics, of which SAMPLES has sample blocks."""
    recording = Recording(path, ["*"], **options)
    for name in names:
        kind = cdr.SAMPLE_BLOCK if name == SAMPLES else ros_type
        recording.add(name, kind, cdr.type_hash(kind), (Qos(),))
    return recording


def receive(recording, topic, received_ns, sent_ns, data, number):
    """Hands one message to a recording."""
    recording.receive_all(topic, [Received(received_ns, sent_ns, number, data)])


def counted(path):
    """The counts that the recorder wrote into a log, one set after the other."""
    with path.open("rb") as file:
        return [item.metadata for item in make_reader(file).iter_metadata() if item.name == RECORDING_RECORD]


def clock_log(path, times):
    """A log of a clock whose messages arrived and were sent at these times [ms], each in a chunk of its own."""
    with RawLogWriter(path, run_record=False) as writer:
        number = writer.add_topic("/clock", cdr.CLOCK)
        for arrived, sent in times:
            writer.write(number, arrived * MS, sent * MS, bytes(12))
            writer.flush()
    return path


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


# The recorder


NUMBERS = (
    # numbers of messages that came, as the middleware gives them; lost, before, and whether that is all
    ([1, 2, 3], 0, 0, True),
    ([4, 5, 9, 10, 12], 4, 3, True),
    ([7, 1, 40], 0, 0, False),  # one publisher after the other
    ([4, 9, 3, 40], 4, 0, False),  # what was counted before stays
    ([None, None], 0, 0, False),
)


@pytest.mark.parametrize(("numbers", "lost", "before", "counted"), NUMBERS)
def test_messages_are_counted_by_their_numbers(numbers, lost, before, counted, tmp_path):
    recording = recording_of(tmp_path / "out.mcap", "/one")
    for number in numbers:
        receive(recording, "/one", 1, 1, b"", number)
    status = recording.status()
    assert (status["messages"], status["messages_lost"], status["messages_before"]) == (len(numbers), lost, before)
    assert (status["lost_on"], status["uncounted"]) == ("/one" * bool(lost), "/one" * (not counted))


def test_a_report_tells_what_was_lost(tmp_path, run_cli):
    """Of several publishers nobody can count."""
    path = tmp_path / "out.mcap"
    recording = recording_of(path, "/one", "/two", SAMPLES)
    for topic, number in (("/one", 4), ("/one", 8), ("/two", 1)):
        receive(recording, topic, 1, 1, b"", number)
    recording.publishers("/two", 2)
    receive(recording, "/two", 1, 1, b"", 40)
    receive(recording, SAMPLES, 1000, 900, sample_block(0, 50), 1)
    recording.close()
    assert read_log(path).losses == {
        "messages_lost": 3, "messages_dropped": 0, "messages_unreadable": 0, "uncounted": "/two",
    }  # fmt: skip
    captured = run_cli("report", path, "--json", "--strict", code=DOUBTFUL)
    assert json.loads(captured.out)["messages_lost"] == 3
    assert "3 messages were lost on the way to the recorder" in captured.err


@pytest.mark.parametrize(("firsts", "mixed"), [((50, 0, 60, 10, 70), True), ((50, 0, 10, 30), False)])
def test_outputs_of_several_publishers_are_mixed(firsts, mixed, tmp_path, run_cli):
    """Two bearings in one namespace; one that is started again while its old end is still known steps back once."""
    path = tmp_path / "out.mcap"
    recording = recording_of(path, SAMPLES)
    for count in (1, 2):  # one publisher that starts again and again mixes with nobody
        recording.publishers(SAMPLES, count)
        for number, first in enumerate(firsts, start=1):
            assert recording.status()["mixed"] == "" or count == 2
            receive(recording, SAMPLES, 1000, 900, sample_block(first, 10), number)
    status = recording.status()
    assert (status["mixed"], status["uncounted"]) == (SAMPLES * mixed, SAMPLES)
    assert ("outputs are mixed" in warning_of(status)) is mixed
    recording.close()
    stderr = run_cli("report", path, "--json", "--strict", code=DOUBTFUL).err
    assert ("several nodes sent samples at a time" in stderr) is mixed


def test_messages_that_no_reader_takes_are_counted_and_left_out(tmp_path, run_json):
    path, large = tmp_path / "out.mcap", bytes(LARGEST_MESSAGE)
    recording = recording_of(path, "/other", SAMPLES, ros_type=cdr.STRING)
    contents = {
        "/other": [b"before", large, large + b"1", b"after"],
        SAMPLES: [b"none", sample_block(0, 5), b"", b"neither"],
    }
    for topic, messages in contents.items():
        recording.receive_all(topic, [Received(1, 1, number, data) for number, data in enumerate(messages, start=1)])
    status = recording.status()
    assert [status[f"messages{suffix}"] for suffix in ("", "_unreadable", "_lost")] == [4, 4, 0]
    assert warning_of(status).startswith("4 messages are not logged")
    recording.close()
    assert [len(data) for topic, *_, data in raw_messages(path) if topic.name == "/other"] == [6, LARGEST_MESSAGE, 5]
    assert run_json("report", path, "--strict", code=DOUBTFUL)["messages_unreadable"] == 4


def test_no_more_topics_are_recorded_than_are_read(tmp_path, monkeypatch):
    """Anybody can publish on as many as he likes; a log of one more would be refused whole."""
    for module in ("nodes.recorder_node", "log.mcap_read"):
        monkeypatch.setattr(f"bearing_twin.{module}.MOST_TOPICS", 5)
    names = [f"/{k}" for k in range(5)]
    recording = recording_of(tmp_path / "out.mcap", *names)
    for topic in names:
        receive(recording, topic, 1, 1, bytes(4), 1)
    with pytest.raises(LogError, match="there are 5 topics in the log"):
        recording.add("/more", cdr.STATE, cdr.type_hash(cdr.STATE), (Qos(),))
    recording.close()
    assert len(list(raw_messages(tmp_path / "out.mcap"))) == 5


def test_a_crash_does_not_take_the_count_of_what_was_lost(tmp_path, monkeypatch):
    """Each loss is reported once; what was dropped while the disk was full is reported when there is room again."""
    monkeypatch.setattr("bearing_twin.log.mcap_write.HELD_BYTES", 5000)
    path = tmp_path / "out.mcap"

    def after_a_crash():
        truncated, recovered = path.with_name("cut.mcap"), path.with_name("whole.mcap")
        truncated.write_bytes(path.read_bytes())
        recovered.unlink(missing_ok=True)
        recover(truncated, recovered)
        return [(int(record["messages_lost"]), int(record["messages_dropped"])) for record in counted(recovered)]

    recording = recording_of(path, "/one", ros_type=cdr.CLOCK, safety=Safety(patient=True))
    for number in (1, 4, 5, 7):
        receive(recording, "/one", 1, 1, bytes(100), number)
        recording.note_losses()
    assert after_a_crash() == [(2, 0), (3, 0)]

    with monkeypatch.context() as patched:
        patched.setattr(os, "pwritev", no_room)
        for number in range(8, 108):
            receive(recording, "/one", 1, 1, bytes(100), number)
            recording.log.flush()  # as the log does by itself every `max_loss` seconds
        recording.note_losses()
    dropped = recording.status()["messages_dropped"]
    assert dropped > 10
    recording.log.flush()
    recording.note_losses()
    assert after_a_crash() == [(2, 0), (3, 0), (3, dropped)]
    recording.close()


def test_what_is_wanted_is_new_matches_and_is_not_hidden(tmp_path):
    """By default everything of every kind, or of the recorder's own namespace."""
    tables = {
        ("/bearing/*", "/tf"): (
            ("/bearing/state", "/bearing/study_result", "/tf"),
            ("/tf_static", "/rosout", "/bearing/run_study/_action/feedback"),
        ),
        tuple(default_topics()): (
            [topic.full_name for kind in KINDS for topic in topics(Scene(kind, kind, "", KINDS[kind].parameters()))],
            ("/elsewhere/state",),
        ),
        tuple(default_topics("/left")): (
            ("/left/state", "/left/records/contact", "/tf", "/tf_static"),
            ("/bearing/state", "/leftover/state"),
        ),
    }
    for number, (patterns, (matching, excluded)) in enumerate(tables.items()):
        recording = Recording(tmp_path / f"{number}.mcap", patterns)
        assert all(map(recording.wants, matching))
        assert not any(map(recording.wants, excluded))
        recording.add(matching[0], cdr.STATE, cdr.type_hash(cdr.STATE), (Qos(),))
        assert not recording.wants(matching[0])
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
    receive(recording, "/pair", 1, 1, b"\0\1\0\0" + bytes(16), 1)
    recording.close()
    [message] = raw_messages(tmp_path / "out.mcap")
    assert message.topic.ros_type == "others/msg/Pair"
    assert message.topic.definition.startswith("# a pair")
    assert message.topic.definition.endswith("MSG: others/One\nfloat64 value # [1]\n")
    assert message.topic.metadata["topic_type_hash"] == "RIHS01_" + "0" * 64


# The replay


@pytest.mark.parametrize(
    ("times", "walls"),
    [
        (((9000, 0), (9100, 0), (2000, 0), (2100, 0), (2050, 0)), [0, 50, 100, 7000, 7100]),
        (((100, 5), (140, 90), (170, 60)), [0, 40, 70]),
    ],
)
def test_a_replay_goes_by_time_of_arrival_whatever_the_order_in_the_file_or_of_sending(times, walls, tmp_path):
    assert [wall // MS for wall, _, _ in played(clock_log(tmp_path / "out.mcap", times))] == walls


@pytest.mark.parametrize(("rate", "start_ms"), [(0.5, 0), (4.0, 0), (1.0, 50)])
def test_a_replay_keeps_bytes_order_and_pace_and_can_start_later(rate, start_ms, log):
    """What is latched comes first then, as late subscribers have it."""
    messages = list(raw_messages(log))
    latched = [m for m in messages if m.topic.name.endswith(("/scene", "/robot_description"))]
    later = [m for m in messages if m.log_time >= start_ms * MS]
    assert {m.log_time for m in latched} == {0}
    out = played(log, rate=rate, start_ns=start_ms * MS)
    assert [(t, d) for _, t, d in out] == [(m.topic.name, m.data) for m in [*(latched if start_ms else []), *later]]
    assert [wall for wall, _, _ in out][-len(later) :] == [int((m.log_time - start_ms * MS) / rate) for m in later]


def test_a_replay_from_the_middle_of_split_files_tells_what_was_latched_last(tmp_path):
    """Said anew while it was recorded, in another chunk and another file; what is said later is not reported before."""
    safety = Safety(split_seconds=4.0)
    with RawLogWriter(tmp_path / "bag", run_record=False, safety=safety) as writer:
        latched_topic, ticks = (
            writer.add_topic(name, cdr.STRING, qos=(qos,))
            for name, qos in (("/said", Qos(1, durability="transient_local")), ("/ticks", Qos()))
        )
        for second in range(10):
            writer.write(ticks, second * 1000 * MS, 0, bytes([second]))
            if second in (1, 3, 7):
                writer.write(latched_topic, (second * 1000 + 1) * MS, 0, bytes([100 + second]))
            writer.flush()
    for start, latched in ((0.5, []), (2.0, [101]), (3.5, [103]), (6.0, [103]), (7.5, [107]), (9.0, [107])):
        out = played(tmp_path / "bag", start_ns=round(start * 1000 * MS))
        first = next(data[0] for _, topic, data in out if topic == "/ticks")
        assert first == math.ceil(start)
        assert [data[0] for _, topic, data in out if topic == "/said"][: len(latched)] == latched
        assert [topic for _, topic, _ in out[: len(latched)]] == ["/said"] * len(latched)


def test_a_loop_starts_again_at_once_and_what_covers_no_time_is_played_once(log, tmp_path):
    """Rounds of nothing would follow each other as fast as the machine can."""
    messages = [(m.topic.name, m.data) for m in raw_messages(log)]
    out = played(log, loop=True, until=2 * len(messages) + 5)
    assert [(t, d) for _, t, d in out] == [*messages, *messages, *messages][: len(out)]
    assert out[len(messages)][0] == out[len(messages) - 1][0]
    first, second = ([wall for wall, _, _ in out[start : start + len(messages)]] for start in (0, len(messages)))
    assert [wall - second[0] for wall in second] == first
    short = clock_log(tmp_path / "short.mcap", [(1000, 0)] * 3)
    assert len(played(short)) == 3
    with pytest.raises(LogError, match="from 0 s on covers 0 s, too little for `loop`"):
        played(short, loop=True, until=100)
    with pytest.raises(LogError, match="from 9 s on holds no messages"):
        played(log, start_ns=9_000 * MS)


def test_of_types_that_changed_or_are_two_what_can_be_read_is_played(tmp_path):
    """Subscribers would read the bytes of the other as of the one."""
    path = tmp_path / "changed.mcap"
    with RawLogWriter(path) as log:
        same = log.add_topic(SAMPLES, cdr.SAMPLE_BLOCK)
        other = log.add_topic("/bearing/contacts", cdr.CONTACTS, "uint8 balls\n", "RIHS01_" + "1" * 64)
        log.write(same, 1, 1, sample_block(0, 50))
        log.write(other, 2, 2, bytes(8))
    loop = ReplayLoop(path, lambda message: None, 1.0)
    assert list(loop.topics) == [SAMPLES]
    assert "/bearing/contacts is not played: bearing_twin_msgs/msg/Contacts has changed its fields" in loop.notes[0]
    assert [topic for _, topic, _ in played(path)] == [SAMPLES]
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


def test_a_log_that_is_being_written_is_played_to_its_last_whole_chunk_and_what_is_foreign_left_out(tmp_path):
    with RawLogWriter(tmp_path / "out.mcap", run_record=False) as writer:
        numbers = [writer.add_topic("/clock", cdr.CLOCK)]
        numbers.append(writer.copy_topic(StoredTopic("/other", "", "", "json", {}, "")))
        for k in range(10):
            writer.write(numbers[k % 2], k * MS, 0, bytes(12))
            writer.flush()
        loop = ReplayLoop(tmp_path / "out.mcap", lambda m: None, 1.0)
        assert list(loop.topics) == ["/clock"]
        assert "has no end" in loop.notes[0]
        assert "/other" in loop.notes[1]


def test_quality_of_service_is_read_in_words_and_numbers():
    for text, qos in {
        "": Qos(),
        "- depth: [": Qos(),
        "- {reliability: best_effort, durability: transient_local, depth: 3}": Qos(3, "best_effort", "transient_local"),
        "- {reliability: 1, durability: 2, depth: 0}": Qos(),
        "- {reliability: 2, durability: 2, depth: .inf}": Qos(),
        "- depth: 3\n  reliability: 2\n  durability: 2\n- depth: 9\n": Qos(3, "best_effort"),
        "- {reliability: 2, durability: 2, depth: 3, more: [" + "1, " * 5000 + "]}": Qos(),
    }.items():
        assert offered_qos(text) == qos


def test_a_log_is_told_in_another_namespace_as_a_node_would_say_it(log):
    """As `__ns` does: what all scenes share keeps its name."""
    names = [message.topic.name for message in raw_messages(log)]
    renamed = [f"/left{name.removeprefix('/bearing')}" if name.startswith("/bearing/") else name for name in names]
    assert {"/left/ball_0/wrench", "/left/samples", "/left/robot_description", "/tf"} <= {*renamed}
    out = played(log, namespace="/left")
    assert [topic for _, topic, _ in out] == renamed
    several = renamed_topics(["/left/samples", "/right/samples", "/left/state"], "cell")
    assert several["/left/state"] == "/cell/left/state"
    assert renamed_topics(names) == {name: name for name in names}
