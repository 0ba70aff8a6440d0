"""What every node does alike, on the wire: requests that ROS itself cannot read, and what the node says of them."""

import time
from types import SimpleNamespace

from ros import (
    DiagnosticStatus,
    Float64,
    ParameterMessage,
    ParameterValue,
    Qos,
    SetParameters,
    plain_node,
    rclpy,
    ros_executor,
    spin_until,
    started,
    statuses,
    values_of,
)

from bearing_twin.nodes import base_node, outlet
from bearing_twin.nodes.pacing import Timed
from bearing_twin.nodes.recorder_node import RecorderNode
from bearing_twin.nodes.sim_node import SimNode


def test_a_parameter_of_no_known_type_ends_no_node(tmp_path, monkeypatch):
    monkeypatch.setattr(base_node, "POLL", 0.02)
    with ros_executor() as others:
        executor = base_node.Executor(others.context)
        node = started(executor, RecorderNode, log=str(tmp_path / "run.mcap"))
        talker = plain_node(others)
        seen = statuses(talker)
        client = talker.create_client(SetParameters, "/recorder_node/set_parameters")

        def turned(done):
            def look():
                executor.turn(node)
                return done()

            return look

        spin_until(others, turned(client.service_is_ready), "the service")
        client.call_async(
            SetParameters.Request(parameters=[ParameterMessage(name="log", value=ParameterValue(type=250))])
        )
        spin_until(others, turned(lambda: executor.faults == 1), "the fault")

        spin_until(others, turned(lambda: any(values_of(one).get("faults") == "1" for one in seen)), "a warning")
        assert {status.level for status in seen if status.name == "recorder_node: recording"} >= {DiagnosticStatus.WARN}
        assert not node.done.is_set()
        node.close()
        node.destroy_node()
        executor.shutdown()


def test_a_topic_on_which_publishing_takes_most_of_the_time_is_named_with_its_subscribers(monkeypatch):
    with ros_executor() as executor:
        talker, listener = plain_node(executor, "talker"), plain_node(executor, "sleeper")
        topics = [(name, "std_msgs/msg/Float64", Qos()) for name in ("quick", "held_up")]
        out = outlet.Outlet(talker, topics, publish_clock=False)
        listener.create_subscription(Float64, "held_up", print, 1)
        spin_until(executor, lambda: talker.count_subscribers("held_up"), "discovery")
        monkeypatch.setattr(rclpy.publisher.Publisher, "publish", lambda self, data: time.sleep(len(data)))
        out.deliver(Timed(0, "quick", b""))
        assert out.slow_topic() == ""
        out.deliver(Timed(0, "held_up", b"1"))
        said = out.slow_topic()
        assert "/held_up" in said
        assert "sleeper" in said
        assert "quick" not in said
        assert out.slow_topic() == ""


def test_two_nodes_of_one_name_are_told(tmp_path):
    """Those of a namespace are advised to take another one: a name alone would leave both on the same topics."""
    with ros_executor() as executor:
        seen = statuses(plain_node(executor))
        alone = started(executor, RecorderNode, log=str(tmp_path / "one.mcap"))
        spin_until(executor, lambda: seen, "diagnostics")
        assert "problem" not in values_of(seen[0])
        started(executor, RecorderNode, log=str(tmp_path / "two.mcap"))
        problems = lambda: [text for status in seen if (text := values_of(status).get("problem"))]  # noqa: E731
        spin_until(executor, problems, "a warning")
        assert "-r __node:=" in problems()[0]
        assert seen[-1].level >= DiagnosticStatus.WARN
        assert alone.failure is None
        for _ in range(2):
            started(executor, SimNode)
        spin_until(executor, lambda: any("-r __ns:=/" in text for text in problems()), "the advice of sim_node")


def test_a_node_says_which_subscribers_it_waits_for(monkeypatch):
    monkeypatch.setattr(outlet, "DISCOVERY_PATIENCE", 0.02)
    monkeypatch.setattr(outlet, "DISCOVERY_GRACE", 0.0)
    names = ["/a", "/b", "/c", "/d", "/e", "/f"]
    for heard in ((), ("/b",), ("/b", "/c", "/d", "/e", "/f"), names):
        said = []
        publishers = [
            SimpleNamespace(topic_name=line, get_subscription_count=lambda found=line in heard: found) for line in names
        ]
        logger = SimpleNamespace(info=lambda line, said=said, **_: said.append(line))
        node = SimpleNamespace(get_logger=lambda logger=logger: logger)
        outlet.Outlet.wait_for_subscribers(SimpleNamespace(publishers=publishers, _node=node), 0.1, lambda: False)
        said = [*dict.fromkeys(said)]
        unheard = [line for line in names if line not in heard]
        assert len(said) == 2 * bool(unheard)
        for line in said:
            assert f"{len(unheard)} of 6 topics have no subscriber: {', '.join(unheard[:3])}" in line
            assert (f"and {len(unheard) - 3} more" in line) is (len(unheard) > 3)


def test_a_log_says_when_the_disk_is_nearly_full_and_when_there_is_space_again(tmp_path, monkeypatch, capfd):
    disk = SimpleNamespace(free=20e9)
    monkeypatch.setattr("shutil.disk_usage", lambda path: disk)
    log = SimpleNamespace(problem="", dropped=0, bytes=5000)
    with ros_executor() as executor:
        node = base_node.BaseNode("testing", "test", context=executor.context)
        executor.add_node(node)
        status = lambda: node.log_status(log, tmp_path / "gone" / "too")  # noqa: E731
        numbers = {"bytes": 5000, "messages_dropped": 0, "disk_free_bytes": 20e9}
        assert status() == (DiagnosticStatus.OK, "", numbers)
        disk.free = 0.5e9
        assert status()[:2] == (DiagnosticStatus.WARN, "the disk of the log has 500.0 MB left: make room")
        log.problem = "no room"
        assert status()[:2] == (DiagnosticStatus.ERROR, "no room")
        log.problem, log.dropped, disk.free = "", 3, 20e9
        assert status()[:2] == (DiagnosticStatus.OK, "")
    assert "there is space again: the log continues, 3 messages were dropped" in capfd.readouterr().err


def test_a_log_says_how_much_an_hour_takes_and_how_long_the_disk_lasts(tmp_path, monkeypatch, capfd):
    monkeypatch.setattr("shutil.disk_usage", lambda path: SimpleNamespace(free=72e9))
    monkeypatch.setattr(base_node, "SETTLED", 0.0)
    monkeypatch.setattr(base_node.time, "monotonic", iter(range(1000)).__next__)
    with ros_executor() as executor:
        node = base_node.BaseNode("testing", "test", context=executor.context)
        for size, problem in ((5000, ""), (505_000, "no room"), (2_005_000, ""), (3_005_000, "")):  # 1 MB/s
            node.log_status(SimpleNamespace(problem=problem, dropped=0, bytes=size), tmp_path)
    assert capfd.readouterr().err.count("the log takes 3.6 GB an hour; the disk has room for 20 hours") == 1


def test_what_peers_send_in_floods_is_told_once_a_second(capfd):
    """Every sentence goes into a file of ROS, too: a peer could fill the disk."""
    with ros_executor() as others:

        @base_node.guarded
        def callback(node):
            raise ValueError("nobody can read this")

        node = plain_node(others)
        for _ in range(5):
            callback(node)
    assert capfd.readouterr().err.count("nobody can read this") == 1
