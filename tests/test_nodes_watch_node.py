"""watch_node beside a sim_node: it costs nothing while nobody looks, shows what comes, and hands commands on."""

import contextlib
import http.client
import json
import socket
import threading
import time
from types import SimpleNamespace

import pytest
from ros import (
    PATIENCE,
    DiagnosticArray,
    DiagnosticStatus,
    KeyValue,
    WrenchStamped,
    plain_node,
    rclpy,
    ros_executor,
    spin_until,
    started,
)

from bearing_twin.base.errors import BearingTwinError, Stopped
from bearing_twin.log import cdr
from bearing_twin.nodes import watch_node
from bearing_twin.nodes.sim_node import SimNode
from bearing_twin.nodes.watch_node import WatchNode

SCENE = {"scene": "bearing_6203", "overrides": ["run.output_rate=200.0", "run.publish_rate=10.0"]}


def asked(executor, node, method="GET", path="/", command=None):
    """(status, text) of an answer, while the executor spins."""
    answers = []

    def ask():
        connection = http.client.HTTPConnection("localhost", node.server.server_port, timeout=PATIENCE)
        connection.request(method, path, command and json.dumps(command), {"X-Token": node.server.token})
        answer = connection.getresponse()
        answers.append((answer.status, answer.read().decode()))
        connection.close()

    threading.Thread(target=ask, daemon=True).start()
    spin_until(executor, lambda: answers, f"answer to {path} {command}")
    return answers[0]


def listen(answer, heard):
    """Puts every line of an answer into `heard` until it is closed."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        heard.extend(iter(answer.fp.readline, b""))


def test_a_page_lives_while_somebody_looks_and_commands_arrive(monkeypatch, capfd):
    monkeypatch.setattr(watch_node, "REQUESTED_FOR", 0.5)
    for patience in ("ANSWER", "COMING"):
        monkeypatch.setattr(watch_node, patience, PATIENCE)  # a busy machine answers late
    with ros_executor(threads=2) as executor:
        sim = started(executor, SimNode, **SCENE)
        spin_until(executor, lambda: sim.loop or sim.failure, "preparation")
        node = started(executor, WatchNode, port=0)
        assert node._watched == "/bearing/sim_node"
        printed = capfd.readouterr()  # standard error goes to a log file of ROS, too
        assert node.server.url in printed.out
        assert node.server.token not in printed.err
        samples = "/bearing/samples"
        spin_until(executor, lambda: sim.loop.position_ns > 200_000_000, "0.2 s")
        assert sim.count_subscribers(samples) == 0

        status, page = asked(executor, node)
        assert status == 200
        assert "bearing_6203" in page
        events = http.client.HTTPConnection("localhost", node.server.server_port, timeout=PATIENCE)
        events.connect()
        wire, heard = events.sock, []
        events.request("GET", "/events")
        answer = events.getresponse()
        threading.Thread(target=listen, args=(answer, heard), daemon=True).start()
        spin_until(executor, lambda: heard.count(b"event: frames\n") > 3, "frames")
        assert sim.count_subscribers(samples) == 1

        for command, done in (
            ({"do": "speed", "value": 50.0}, lambda: sim.loop.commands.counts["taken"] == 1),
            ({"do": "pace", "value": 0.5}, lambda: float(sim.loop.factor) == 0.5),
            ({"do": "pause", "on": True}, lambda: sim.loop.paused),
            ({"do": "pause", "on": False}, lambda: not sim.loop.paused),
            ({"do": "reset"}, lambda: sim.loop.run == 2),
        ):
            status, text = asked(executor, node, "POST", "/command", command)
            assert status == 200, text
            spin_until(executor, done, str(command))
        spin_until(executor, lambda: b"event: again\n" in heard, "word of the new run")

        for command, sentence in (
            ({"do": "jump"}, "'jump' is no command"),
            ({"do": ["speed"]}, "is no command"),
            ({"do": "speed", "value": "fast"}, "speed must be a number"),
            ({"do": "load", "force": [1.0]}, "force must be three numbers"),
            ({"do": "pause"}, "true or false"),
            ({"do": "pace", "value": 1e9}, "or fastest"),
            ({"do": "speed", "value": 1e308}, "must be finite and within"),
        ):
            status, text = asked(executor, node, "POST", "/command", command)
            assert status == 409
            assert sentence in text
            assert len(text.splitlines()) == 1

        loads, listener = [], plain_node(executor)
        listener.create_subscription(WrenchStamped, "/bearing/command/load", loads.append, 10)
        spin_until(executor, lambda: sim.count_subscribers("/bearing/command/load") == 2, "a second listener")
        order = {"do": "load", "force": [1.0, 2.0, 3.0], "torque": [4.0, 5.0, 6.0]}
        assert asked(executor, node, "POST", "/command", order) == (200, "load 1, 2, 3 N sent\n")
        spin_until(executor, lambda: loads, "the load")
        force, torque = loads[0].wrench.force, loads[0].wrench.torque
        assert [force.x, force.y, force.z, torque.x, torque.y, torque.z] == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
        spin_until(executor, lambda: b"event: refused\n" in heard, "word of the refusal: this scene holds its ring")
        assert any(b"command/load refused" in line for line in heard)

        wire.shutdown(socket.SHUT_RDWR)  # a close would wait for the thread that reads, and that for this one to spin
        answer.close()
        events.close()
        spin_until(executor, lambda: sim.count_subscribers(samples) == 0, "leaving the node alone")


def test_without_a_node_to_show_it_says_so():
    with ros_executor() as executor:
        with pytest.raises(BearingTwinError, match="no node publishes samples"):
            started(executor, WatchNode, patience=0.0)
        for side in ("left", "right"):
            other = plain_node(executor, f"{side}_node")
            other.create_publisher(watch_node.interface(cdr.SAMPLE_BLOCK, "msg"), "/samples", 10)
        with pytest.raises(BearingTwinError, match="/left_node, /right_node publish samples: name the one"):
            started(executor, WatchNode, patience=1.0)
        with pytest.raises(BearingTwinError, match="no node '/lift_node' publishes samples; did you mean /left_node"):
            started(executor, WatchNode, node="/lift_node", patience=1.0)
        node = started(executor, WatchNode, node="/left_node", patience=60.0, port=0)
        assert node._watched == "/left_node"


def test_a_signal_ends_the_search_for_a_node_to_show(monkeypatch):
    asked = threading.Event()
    asked.set()
    monkeypatch.setattr(watch_node, "interrupted", asked)
    with ros_executor() as executor, pytest.raises(Stopped):
        started(executor, WatchNode, patience=PATIENCE, port=0)


def test_a_node_is_the_only_one_when_discovery_is_at_rest(monkeypatch):
    """Of two bearings one is found first: to show it would be a guess."""
    topics, asked = WatchNode.get_topic_names_and_types, []

    def one_by_one(self):
        asked.append(time.monotonic())
        return [name for name in topics(self) if name[0] != "/right/samples" or len(asked) > 5]

    monkeypatch.setattr(WatchNode, "get_topic_names_and_types", one_by_one)
    with ros_executor() as executor:
        for side in ("left", "right"):
            name = rclpy.create_node("sim_node", namespace=f"/{side}", context=executor.context)
            executor.add_node(name)
            name.create_publisher(watch_node.interface(cdr.SAMPLE_BLOCK, "msg"), f"/{side}/samples", 10)
        with pytest.raises(BearingTwinError, match="/left/sim_node, /right/sim_node publish samples: name the"):
            started(executor, WatchNode, patience=PATIENCE)


def test_a_replay_is_shown_though_its_topics_stand_in_another_namespace(monkeypatch):
    with ros_executor() as executor:
        replay = plain_node(executor, "replay_node")
        replay.create_publisher(watch_node.interface(cdr.SAMPLE_BLOCK, "msg"), "/bearing/samples", 10)
        replay.create_publisher(watch_node.interface(cdr.SAMPLE_BLOCK, "msg"), "/bearing/records/choice", 10)
        original, infos = WatchNode.get_publishers_info_by_topic, []

        def nameless_at_first(self, topic):
            infos.append(topic)
            unknown = SimpleNamespace(node_namespace="_NODE_NAMESPACE_UNKNOWN_", node_name=watch_node.NAMELESS)
            return original(self, topic) if len(infos) > 2 else [unknown]

        monkeypatch.setattr(WatchNode, "get_publishers_info_by_topic", nameless_at_first)
        node = started(executor, WatchNode, port=0, patience=PATIENCE)
        assert (node._watched, node._namespace) == ("/replay_node", "/bearing")
        replay.declare_parameter("rate", 1.0)
        assert asked(executor, node, "POST", "/command", {"do": "pace", "value": 2.0}) == (200, "2 times real time\n")
        assert replay.get_parameter("rate").value == 2.0
        replay.create_publisher(watch_node.interface(cdr.SAMPLE_BLOCK, "msg"), "/shaft/samples", 10)
        spin_until(executor, lambda: node.count_publishers("/shaft/samples"), "discovery")
        with pytest.raises(BearingTwinError, match="publishes /bearing/samples, /shaft/samples: play a log of one"):
            started(executor, WatchNode, port=0, patience=PATIENCE)


def refusals_told(node, *counts):
    """What a page shows of refusals as a node's diagnostics give these counts, one after the other."""
    reported, send = [], node.feed.send
    node.feed.send = lambda event, text: reported.append(text) if event == "refused" else None
    for count in counts:
        values = [KeyValue(key="commands_refused", value=count), KeyValue(key="last_refusal", value=f"the {count}th")]
        status = DiagnosticStatus(name="mute_node: simulation", values=values)
        node._on_diagnostics(DiagnosticArray(status=[status]))
    node.feed.send = send
    return reported


def test_a_node_that_sends_nothing_is_answered_for_and_its_refusals_are_told_to_those_who_look(monkeypatch):
    monkeypatch.setattr(watch_node, "COMING", 0.2)
    with ros_executor() as executor:
        other = plain_node(executor, "mute_node")
        other.create_publisher(watch_node.interface(cdr.SAMPLE_BLOCK, "msg"), "/samples", 10)
        node = started(executor, WatchNode, port=0)
        status, text = asked(executor, node)
        assert status == 503
        assert "/mute_node has not published its scene yet" in text
        speed = {"do": "speed", "value": 1}
        for command, sentence in (({"do": "reset"}, "there is no service"), (speed, "does not subscribe")):
            status, text = asked(executor, node, "POST", "/command", command)
            assert status == 409
            assert sentence in text
        node._on_look()
        assert refusals_told(node, "2", "2", "3", "0", "1") == ["the 3th", "the 1th"]
        monkeypatch.setattr(watch_node, "REQUESTED_FOR", 0.0)  # nobody looks any more
        node._on_look()
        assert refusals_told(node, "4", "5") == ["the 5th"], "the 4th was while nobody looked"
