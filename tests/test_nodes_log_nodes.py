"""recorder_node and replay_node on the wire: the bytes sent are in the log, and the bytes in the log are sent."""

import itertools
import signal
from fractions import Fraction

import pytest
from ros import (
    Clock,
    Float64,
    Parameter,
    QoSCompatibility,
    SetBool,
    call,
    deserialize_message,
    executable,
    interface,
    padded,
    plain_node,
    qos_check_compatible,
    qos_profile,
    ros_executor,
    spin_for,
    spin_until,
    started,
    statuses,
    values_of,
)
from runs import a_choice, bits, made_up_block, made_up_run, made_up_scene

from bearing_twin.base.errors import BearingTwinError, LogError
from bearing_twin.log import cdr
from bearing_twin.log.bag import Qos, raw_messages
from bearing_twin.log.raw_log import RECORDING_RECORD, RawLogWriter
from bearing_twin.log.run_log import read_log, write_log
from bearing_twin.log.stream import MessageStream, topics
from bearing_twin.nodes import recorder_node
from bearing_twin.nodes.messages import compatible_profile, qos_of, stamp
from bearing_twin.nodes.node_parameters import ParameterError
from bearing_twin.nodes.outlet import Outlet
from bearing_twin.nodes.pacing import Timed
from bearing_twin.nodes.recorder_node import REMEDY, RecorderNode
from bearing_twin.nodes.replay_node import ReplayNode

SCENE = made_up_scene(balls=2)
BLOCK = made_up_block(SCENE, 300)
NAMES = [(topic.full_name, topic.ros_type) for topic in topics(SCENE)]


def messages():
    """Topic and bytes of everything a run of BLOCK sends, in order."""
    stream = MessageStream(SCENE, choice=a_choice())
    for part in (stream.messages(BLOCK), stream.flush()):
        yield from ((topic, cdr_bytes) for topic, _, cdr_bytes in part)


def test_a_burst_as_of_an_impact_is_recorded_whole(tmp_path, capfd):
    """All messages of a run at once: what is global, as /tf, is kept as everything else, and none is lost."""
    with ros_executor() as executor:
        outlet = Outlet(plain_node(executor), [("/tf", cdr.STATE, Qos(80)), ("/impact/x", cdr.STATE, Qos(80))], False)
        recorder = started(executor, RecorderNode, log=str(tmp_path / "run.mcap"), topics=["/tf", "/impact/*"])
        spin_until(executor, lambda: len(outlet.subscribed_topics()) == 2, "discovery")
        spin_for(executor, 1.0)
        for number in range(2000):
            for topic in ("/tf", "/impact/x"):
                outlet.deliver(Timed(number, topic, padded(bytes(400))))
        spin_until(executor, lambda: recorder.recording.messages == 4000, "4000 messages", patience=60.0)
        assert recorder.recording.status()["messages_lost"] == 0
    assert "run.mcap: 4000 messages, " in capfd.readouterr().err


def test_a_recorder_on_simulation_time_logs_by_it_also_where_it_runs_backwards(tmp_path, capfd):
    with ros_executor() as executor:
        talker = plain_node(executor)
        clock, x = talker.create_publisher(Clock, "/clock", 10), talker.create_publisher(Float64, "/x", 10)
        recorder = started(executor, RecorderNode, log=str(tmp_path / "x.mcap"), topics=["/x"], use_sim_time=True)
        spin_until(executor, lambda: x.get_subscription_count() and clock.get_subscription_count(), "discovery")
        for count, second in enumerate((5, 7, 6), start=1):
            clock.publish(Clock(clock=stamp(second * 10**9)))
            spin_until(executor, lambda s=second: recorder.get_clock().now().nanoseconds == s * 10**9, "the time")
            x.publish(Float64())
            spin_until(executor, lambda n=count: recorder.recording.messages == n, "the message")
    assert [message.log_time for message in raw_messages(tmp_path / "x.mcap")] == [5 * 10**9, 6 * 10**9, 7 * 10**9]
    assert "ERROR" not in capfd.readouterr().err


def test_a_replay_on_simulation_time_follows_it(log):
    with ros_executor() as executor:
        with pytest.raises(BearingTwinError, match="cannot publish_clock"):
            started(executor, ReplayNode, log=str(log), use_sim_time=True, publish_clock=True)
        clock = plain_node(executor).create_publisher(Clock, "/clock", 10)
        node = started(executor, ReplayNode, log=str(log), discovery=0.0, use_sim_time=True)
        spin_until(executor, clock.get_subscription_count, "discovery")
        spin_for(executor, 0.5)
        assert node.loop.position_ns == 0  # time has not begun
        for time_ns, position in ((9 * 10**9, 0), (9_100_000_000, 100), (3 * 10**9, 100)):
            clock.publish(Clock(clock=stamp(time_ns)))
            spin_for(executor, 0.3)
            assert position <= node.loop.position_ns // 10**6 <= position + 10  # an output in 10 ms
        clock.publish(Clock(clock=stamp(3_300_000_000)))
        spin_until(executor, node.done.is_set, "the end")


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    path = tmp_path_factory.mktemp("logs") / "run.mcap"
    write_log(made_up_run(SCENE, [BLOCK]), path)
    return path


def test_a_subscription_is_suited_to_all_publishers_of_its_topic():
    """It asks for what is kept for late comers where all of them keep it."""
    offers = itertools.product(["reliable", "best_effort"], ["transient_local", "volatile"])
    for pair in itertools.product(offers, repeat=2):
        profiles = [qos_profile(Qos(10, *policies)) for policies in pair]
        requested = compatible_profile(profiles, 100)
        assert QoSCompatibility.ERROR not in [qos_check_compatible(profile, requested)[0] for profile in profiles]
        all_latched = {durability for _, durability in pair} == {"transient_local"}
        assert qos_of(requested).durability == ("transient_local" if all_latched else "volatile")


def test_a_publisher_that_offers_less_than_those_before_is_recorded_too(tmp_path):
    path = tmp_path / "out.mcap"
    with ros_executor() as executor:
        talker = plain_node(executor)
        first = talker.create_publisher(Float64, "/elsewhere", qos_profile(Qos(10, durability="transient_local")))
        recorder = started(executor, RecorderNode, log=str(path), topics=["/elsewhere"])
        spin_until(executor, first.get_subscription_count, "discovery")
        first.publish(Float64(data=1.0))
        spin_until(executor, lambda: recorder.recording.messages == 1, "the first message")
        second = talker.create_publisher(Float64, "/elsewhere", qos_profile(Qos(10, "best_effort")))
        publishers = (first, second)
        counts = lambda: [publisher.get_subscription_count() for publisher in publishers]  # noqa: E731
        spin_until(executor, lambda: counts() == [1, 1], "one subscription to each")
        for publisher in publishers:
            publisher.publish(Float64(data=2.0))
        spin_until(executor, lambda: recorder.recording.messages == 3, "messages of both")
        spin_for(executor, 0.2)
    assert [deserialize_message(message.data, Float64).data for message in raw_messages(path)] == [1.0, 2.0, 2.0]


def test_lost_messages_of_any_topic_are_counted_and_said(tmp_path, monkeypatch):
    """A recorder that is held up: its subscription keeps the last messages alone."""
    monkeypatch.setattr(recorder_node, "DEPTH", 5)
    path = tmp_path / "out.mcap"
    with ros_executor() as executor:
        talker = plain_node(executor)
        seen, publisher = statuses(talker), talker.create_publisher(Float64, "/elsewhere", 100)
        recorder = started(executor, RecorderNode, log=str(path), topics=["/elsewhere"])
        spin_until(executor, publisher.get_subscription_count, "discovery")
        publisher.publish(Float64())
        spin_until(executor, lambda: recorder.recording.messages == 1, "the first message")
        for _ in range(30):
            publisher.publish(Float64())
        spin_until(executor, lambda: any("messages were lost" in status.message for status in seen), "a warning")
        status = recorder.recording.status()
        received = status["messages"]
        assert 6 <= received < 31  # the first, five that waited, and those that the machine took in time
        assert (status["messages_lost"], status["lost_on"], status["uncounted"]) == (31 - received, "/elsewhere", "")
        assert any(REMEDY in status.message for status in seen)
        second = talker.create_publisher(Float64, "/elsewhere", 100)
        second.publish(Float64())
        spin_until(executor, lambda: recorder.recording.status()["uncounted"] == "/elsewhere", "a second publisher")


def test_names_that_somebody_made_up_run_nothing_and_are_refused(tmp_path, monkeypatch, capfd, ran_if_imported):
    """Anybody on the network can send names; to import the module of a type would run it."""
    cases = {
        "/x": (["probe/msg/Made"], "/x is not logged: the type probe/msg/Made cannot be imported"),
        "/xa": (["probe.inner/msg/Made"], "/xa is not logged: 'probe.inner/msg/Made' is not a type of this group"),
        "/xb": (["std_msgs/msg/String", "a/msg/\x1b[2J"], "publishers disagree on its type: std_msgs/msg/String, 'a/m"),
        "/x//y": (["std_msgs/msg/String"], ""),
        "/x\x1b[2J": (["std_msgs/msg/String"], ""),
    }
    like = type("Publisher", (), {"qos_profile": qos_profile(Qos(10)), "topic_type_hash": ""})
    monkeypatch.setattr(recorder_node, "LOG_PERIOD", 0.0)
    with ros_executor() as executor:
        recorder = started(executor, RecorderNode, log=str(tmp_path / "run.mcap"), topics=["/x*"])
        names = [(name, types) for name, (types, _) in cases.items()]
        monkeypatch.setattr(recorder, "get_topic_names_and_types", lambda: names)
        monkeypatch.setattr(recorder, "get_publishers_info_by_topic", lambda topic: [like])
        spin_for(executor, 3.5 * recorder_node.DISCOVERY_PERIOD)
        assert not recorder.recording.topics
        assert recorder.failure is None
    reported = capfd.readouterr().err
    assert reported.count("is not logged") == 3  # once each
    assert all(sentence in reported for _, sentence in cases.values())
    assert "\x1b[2J" not in reported
    assert not ran_if_imported.exists()


@pytest.fixture
def ran_if_imported(tmp_path, monkeypatch):
    """A file that is there once the module `probe`, which is no package of messages, was imported."""
    (tmp_path / "probe" / "inner" / "msg").mkdir(parents=True)
    for folder in ("probe", "probe/msg", "probe/inner", "probe/inner/msg"):
        (tmp_path / folder).mkdir(exist_ok=True)
        text = f"import pathlib; pathlib.Path({str(tmp_path / 'ran')!r}).touch()\nclass Made:\n    SLOT_TYPES = ()\n"
        (tmp_path / folder / "__init__.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path / "ran"


def test_a_replay_runs_nothing_that_a_log_names(tmp_path, ran_if_imported):
    path = tmp_path / "made.mcap"
    writer = RawLogWriter(path)
    writer.write(writer.add_topic("/x", "probe/msg/Made", "float64 x", ""), 1, 1, bytes(12))
    writer.close()
    with ros_executor() as executor, pytest.raises(BearingTwinError, match="probe/msg/Made cannot be imported"):
        started(executor, ReplayNode, log=str(path))
    assert not ran_if_imported.exists()


def test_a_topic_that_ros_does_not_know_is_left_out_of_a_replay_and_told(tmp_path, capfd):
    """Logs of other programs may call topics what they like, and name types that are none."""
    illegal = {"/two words": cdr.STRING, "/1st": cdr.STRING, "/type": "std_msgs/msg/_string"}
    # The node's own; whether it has /rosout is decided by what the process has logged before.
    illegal |= dict.fromkeys(("/diagnostics", "/parameter_events", "/clock"), cdr.STRING)
    many = {f"/{k}": cdr.STRING for k in range(50)}
    for name, played in (("mixed", {"/good": cdr.STRING} | illegal | many), ("none", {"/a\x1b[2Jb": cdr.STRING})):
        with RawLogWriter(tmp_path / f"{name}.mcap") as log:
            for topic, ros_type in played.items():
                log.write(log.add_topic(topic, ros_type, "string data", ""), 1, 1, padded(b"\0\1\0\0\1\0\0\0\0"))
    with ros_executor() as executor:
        node = started(executor, ReplayNode, log=str(tmp_path / "mixed.mcap"), discovery=0.0, publish_clock=True)
        spin_until(executor, node.done.is_set, "end of the replay")
        assert (node.failure, node._outlet.published, sorted(node._outlet._publishers)) == (None, 1, ["/good"])
        with pytest.raises(BearingTwinError, match=r"'/a\\x1b\[2Jb' is not published: it is not a legal name"):
            started(executor, ReplayNode, log=str(tmp_path / "none.mcap"))
    stderr = capfd.readouterr().err
    names = ["/type", *(repr(name) for name in illegal if name != "/type")]
    assert all(f"{name} is not published" in stderr for name in names)
    assert "; and 46 more" in stderr


def test_a_time_that_ros_cannot_tell_ends_a_replay_in_a_sentence(tmp_path):
    with RawLogWriter(tmp_path / "late.mcap") as log:
        log.write(log.add_topic("/late", cdr.STRING), 1 << 63, 1 << 63, bytes(12))
    with ros_executor() as executor:
        node = started(executor, ReplayNode, log=str(tmp_path / "late.mcap"), discovery=0.0, publish_clock=True)
        spin_until(executor, node.done.is_set, "end of the replay")
    assert str(node.failure) == "9.22337e+09 s is not a time of ROS, whose seconds end at 2147483647"


def test_a_paused_replay_tells_its_time_and_takes_another_pace(log):
    with ros_executor() as executor:
        watcher, times = plain_node(executor), []

        def pause(paused):
            return call(executor, watcher, SetBool, "/replay_node/pause", SetBool.Request(data=paused))

        options = {"loop": True, "discovery": 0.0, "start_paused": True, "publish_clock": True}
        node = started(executor, ReplayNode, log=str(log), **options)
        spin_for(executor, 0.2)
        assert node.loop.position_ns == 0
        assert pause(False).success
        spin_until(executor, lambda: node.loop.rounds, "another round")
        results = [node.set_parameters([Parameter("rate", value=value)])[0].successful for value in (0.0, 0.001)]
        assert results == [False, True]
        spin_until(executor, lambda: node.loop.factor == Fraction(1, 1000) and node.loop.position_ns, "the new pace")
        pause(True)
        position_ns, quality = node.loop.position_ns, qos_profile(Qos(10, "best_effort"))
        watcher.create_subscription(Clock, "/clock", lambda message: times.append(message.clock.nanosec), quality)
        spin_until(executor, lambda: len(times) > 2, "time that stands still")
        assert {*times} == {node.loop.position_ns} == {position_ns}
        assert not node.done.is_set()


def test_a_replay_that_waits_for_subscribers_ends_when_it_is_told_to(log):
    with ros_executor() as executor:
        node = started(executor, ReplayNode, log=str(log), discovery=600.0)
        node.close()
        assert node.worker.stop(0.0)
        assert node.failure is None


def test_what_cannot_be_logged_or_played_is_refused():
    with ros_executor() as executor:
        for node_class, parameters, error, sentence in (
            (ReplayNode, {}, BearingTwinError, "parameter log is empty"),
            (ReplayNode, {"log": "missing.mcap"}, LogError, "missing.mcap"),
            (ReplayNode, {"log": __file__}, LogError, "is not an MCAP file"),
            (ReplayNode, {"log": "x.mcap", "rate": 0.0}, ParameterError, "rate = 0.0 must be a number, 0.001 to 1000"),
            (ReplayNode, {"log": "x.mcap", "frame_prefix": "b/"}, ParameterError, "remap its /tf"),
            (RecorderNode, {"log": __file__}, LogError, "exists and is not overwritten"),
            (RecorderNode, {"log": "no/such/folder/x.mcap"}, LogError, "does not exist"),
            (RecorderNode, {"topic": "/tf"}, ParameterError, "did you mean topics?"),
        ):
            with pytest.raises(error, match=sentence.replace("?", r"\?")):
                started(executor, node_class, **parameters)


def test_a_recorder_that_logs_frames_alone_warns(tmp_path):
    """Nodes in other namespaces than those of kinds of scenes publish theirs beside what is not recorded by default."""
    with ros_executor() as executor:
        peer = plain_node(executor)
        seen = statuses(peer)
        peer.create_publisher(interface(cdr.TRANSFORMS, "msg"), "/tf", 10)
        started(executor, RecorderNode, log=str(tmp_path / "log.mcap"))
        spin_until(executor, lambda: any("there is /tf so far" in status.message for status in seen), "warning")


def test_to_have_recorded_nothing_is_told_and_fails(tmp_path):
    with ros_executor() as executor:
        seen = statuses(plain_node(executor))
        arguments = ("-p", f"log:={tmp_path / 'log.mcap'}", "-p", "topics:=['']")
        with executable(executor, "recorder_node", *arguments) as recorder:
            spin_until(executor, lambda: seen, "diagnostics")
            recorder.send_signal(signal.SIGINT)
            _, stderr = recorder.communicate(timeout=300)
    assert "there is none so far" in seen[0].message
    assert recorder.returncode == 2
    assert "nothing was recorded" in stderr.splitlines()[-1]


@pytest.mark.parametrize(
    "number",
    [signal.SIGINT, *(pytest.param(one, marks=pytest.mark.environment) for one in (signal.SIGTERM, signal.SIGHUP))],
)
def test_the_log_is_complete_whatever_signal_ends_the_recorder(tmp_path, number):
    path = tmp_path / "recording.mcap"
    arguments = ("-p", f"log:={path}")
    with ros_executor() as executor, executable(executor, "recorder_node", *arguments) as recorder:
        talker = plain_node(executor)
        seen = statuses(talker)
        samples = talker.create_publisher(interface(cdr.SAMPLE_BLOCK, "msg"), "/bearing/samples", 10)
        spin_until(executor, samples.get_subscription_count, "discovery")
        blocks = [data for topic, data in messages() if topic.name == "samples"]
        for data in blocks:
            samples.publish(data)
        all_received = lambda: seen and values_of(seen[-1])["messages"] == str(len(blocks))  # noqa: E731
        spin_until(executor, all_received, "all")
        recorder.send_signal(number)
        _, stderr = recorder.communicate(timeout=300)
    assert recorder.returncode == 0, stderr
    stored = read_log(path)  # raises for a log without its index
    assert bits(stored) == bits(BLOCK)
    assert stored.metadata[RECORDING_RECORD]["messages"] == str(len(blocks))
