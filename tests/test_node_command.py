"""`bearing_twin node` against a node of the test: what ros2 would do, and one sentence for what is not there."""

import functools
import json
import os
import shlex
import subprocess
import sys
import threading
import time

import pytest

from bearing_twin.base.errors import BearingTwinError, MissingInterfacesError
from bearing_twin.command import cli
from bearing_twin.command.node_command import VERBS, node_arguments


def test_the_words_of_a_node_are_those_of_ros2_run():
    head = ["-m", "bearing_twin.nodes.entry", "sim_node"]
    assert node_arguments("sim_node", []) == head
    assert node_arguments("sim_node", ["-p", "scene:=bearing_6205"]) == [
        *head,
        "--ros-args",
        "-p",
        "scene:=bearing_6205",
    ]
    mixed = ["-p", "a:=1", "--ros-args", "-r", "__ns:=/a"]
    assert node_arguments("sim_node", mixed) == [*head, "--ros-args", *mixed]
    assert node_arguments("sim_node", ["--help"]) == [*head, "--help"]
    with pytest.raises(BearingTwinError, match="did you mean sim_node"):
        node_arguments("sim_nod", [])


@pytest.mark.parametrize("verb", VERBS, ids=lambda verb: verb.words)
def test_examples_of_the_help_are_legal(verb):
    arguments = ["node", *verb.words.split(), *shlex.split(verb.example)]
    assert parser().parse_args(arguments).run_verb is verb.run


@functools.cache
def parser():
    return cli.parsers("node")[0]


@pytest.fixture(scope="module")
def toy():
    """A node with a topic, a latched topic, a subscription, a service, parameters and an action, in a thread."""
    import ros

    from bearing_twin.nodes import graph
    from bearing_twin.nodes.base_node import declare
    from bearing_twin.nodes.node_parameters import NodeParameter

    heard, quiet = [], graph.QUIET
    graph.QUIET = 0.3  # what discovery adds later is asked for again

    def study(handle):
        handle.publish_feedback(ros.RunStudy.Feedback(done=3, total=4, quantity="x"))
        failed = handle.request.study == "bad" or "samples=0" in handle.request.overrides
        handle.abort() if failed else handle.succeed()
        summary = {"quantities": {}, "samples": 4, "failed": {}, "seconds": 1, "stopped_because": "x"}
        summary |= {"doubts": {}, "notes": []}
        text = "" if failed else json.dumps(summary)
        return ros.RunStudy.Result(success=not failed, message="why", summary=text)

    def take(message):
        heard.append(message.data)
        if message.data < 0.0:
            node.get_logger().warning("too slow\x1b[31m")

    def pause(request, response):
        response.success, response.message = request.data, "as you say"
        return response

    with ros.ros_executor() as executor:
        node = ros.plain_node(executor, "toy")
        latched = ros.qos_profile(ros.Qos(1, durability="transient_local"))
        wrenches = node.create_publisher(ros.WrenchStamped, "/toy/wrench", 10)
        node.create_publisher(ros.String, "/toy/scene", latched).publish(ros.String(data="one\x1b[31m"))
        node.create_subscription(ros.Float64, "/toy/speed", take, 10)
        node.create_service(ros.SetBool, "/toy/pause", pause)
        node.declare_parameter("pace", 1.0)
        declare(node, [NodeParameter("changes", [], "of the toy", read_only=False)])
        server = ros.ActionServer(node, ros.RunStudy, "/bearing/run_study", study)
        message = ros.WrenchStamped()
        message.wrench.force.x = 2.5
        node.create_timer(0.1, lambda: wrenches.publish(message))
        thread = threading.Thread(target=executor.spin, daemon=True)
        thread.start()
        before = os.environ.get("ROS_DOMAIN_ID")
        os.environ["ROS_DOMAIN_ID"] = str(executor.context.get_domain_id())
        yield heard
        os.environ["ROS_DOMAIN_ID"] = before or "0"
        graph.QUIET = quiet
        executor.shutdown()
        thread.join()
        server.destroy()


@pytest.fixture
def answer(toy, capsys):
    def run(*arguments, code=cli.DONE):
        patience = ["--wait", "300"] if code == cli.DONE and "--wait" not in arguments else []  # of a busy machine
        result = cli.main(["node", *arguments, *patience])
        assert result == code, capsys.readouterr().err
        output = capsys.readouterr()
        return json.loads(output.out) if "--json" in arguments else output.out if code == cli.DONE else output.err

    return run


@pytest.fixture
def at_once(toy, monkeypatch):
    """Commands of a test share one view of the graph, as each own one takes seconds to find a node."""
    from bearing_twin.nodes import graph

    shared = graph.Graph(300.0)
    with monkeypatch.context() as patched:
        patched.setattr(graph, "Graph", lambda wait: shared)
        patched.setattr(shared, "close", lambda code: None)
        yield
    shared.close(2)


def test_topics_are_read_timed_and_written(toy, answer, capsys):
    assert answer("topic", "echo", "/toy/wrench", "--once", "--json", "--field", "wrench.force") == {
        "x": 2.5,
        "y": 0,
        "z": 0,
    }
    assert answer("topic", "echo", "/toy/wrench", "--once", "--field", "wrench.force.x") == "2.5\n---\n"
    shown = answer("topic", "echo", "/toy/scene", "--once")
    assert "\\e[31m" in shown
    assert "\x1b" not in shown
    rate = answer("topic", "hz", "/toy/wrench", "--count", "5", "--json")
    assert rate["messages"] == 5
    assert rate["least_period_s"] < 1.0 / rate["rate_hz"] < rate["greatest_period_s"]
    assert answer("topic", "bw", "/toy/wrench", "--count", "5", "--json")["greatest_bytes"] >= 48
    answer("topic", "pub", "--once", "/toy/speed", "std_msgs/msg/Float64", "{data: 250}")
    until(lambda: toy)
    assert toy == [250.0]
    assert cli.main(["node", "topic", "pub", "--once", "/toy/speed", "std_msgs/msg/Float64", "{data: -1}"]) == cli.DONE
    assert "/toy warns: too slow\\x1b[31m" in capsys.readouterr().err
    other = answer("topic", "pub", "/toy/speed", "std_msgs/msg/String", "{data: a}", code=cli.BAD_INPUT)
    assert "/toy/speed takes std_msgs/msg/Float64, not std_msgs/msg/String" in other


def test_a_publisher_at_best_effort_is_received_where_another_subscription_was_known_before_it(monkeypatch):
    """As /clock, to which every node with use_sim_time subscribes."""
    import ros

    from bearing_twin.nodes.graph import Graph

    ended = threading.Event()

    def publish():
        publisher = talker.create_publisher(ros.Clock, "/clock", ros.qos_profile(ros.Qos(1, "best_effort")))
        while not ended.wait(0.05):
            publisher.publish(ros.Clock())

    with ros.ros_executor() as executor:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(executor.context.get_domain_id()))
        talker, later = ros.plain_node(executor, "talker"), threading.Timer(1.0, publish)
        talker.create_subscription(ros.Clock, "/clock", print, 10)
        listener = Graph(60.0)
        later.start()
        received = next(listener.messages("/clock", lambda: pytest.fail("nothing was received")))
        ended.set()
        later.join()
        listener.close(2)
    assert received == ros.Clock()


@pytest.mark.parametrize("received", [0, 1])
@pytest.mark.parametrize("verb", ["echo", "hz"])
def test_ctrl_c_ends_who_listens_and_interrupts_who_waits_for_the_first_message(verb, received, answer, monkeypatch):
    from bearing_twin.nodes.graph import Graph
    from bearing_twin.nodes.messages import interface

    def messages(*_, **__):
        message = interface("std_msgs/msg/Float64", "msg")(data=2.5)
        yield from [bytes(12) if verb == "hz" else message] * received
        raise KeyboardInterrupt

    monkeypatch.setattr(Graph, "messages", messages)
    captured = answer("topic", verb, "/toy/speed", code=cli.DONE if received else cli.INTERRUPTED)
    expected = ("2.5" if verb == "echo" else "messages  1") if received else "bearing_twin: interrupted"
    assert expected in captured


def until(holds):
    """Waits; what is requested for in `holds` is asked for again: discovery takes as long as the machine is busy."""
    end = time.monotonic() + 300.0
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [
        (("topic", "pub", "/toy/sped", "std_msgs/msg/Float64", "{data: 2}"), "/toy/speed"),
        (("service", "call", "/toy/paus"), "/toy/pause"),
        (("study", "a", "--action", "/bearing/run_studdy"), "/bearing/run_study"),
    ],
)
def test_a_name_that_nobody_has_is_answered_with_near_ones(arguments, meant, answer):
    until(lambda: f"did you mean {meant}?" in answer(*arguments, "--wait", "2", code=cli.BAD_INPUT))


def test_what_is_there_is_listed(answer):
    def complete(holds, *arguments):
        until(lambda: holds(answer(*arguments, "--json")))

    complete(lambda listed: listed == {"nodes": [{"name": "/toy"}]}, "list")
    wrench = {"name": "/toy/wrench", "type": "geometry_msgs/msg/WrenchStamped"}
    complete(lambda listed: wrench in listed["topics"], "topic", "list")
    end = {
        "end": "publisher",
        "node": "/toy",
        "type": wrench["type"],
        "reliability": "reliable",
        "durability": "volatile",
    }
    complete(lambda listed: listed["ends"] == [end], "topic", "info", "/toy/wrench")


@pytest.mark.parametrize(("command_line", "code"), [("node list", cli.DONE), ("node param get /nobody a --wait 0", 2)])
def test_a_command_that_cannot_leave_ros_has_printed_its_result_and_ends_with_its_own_code(command_line, code):
    """Destroying its node never returns and holds the interpreter, as Fast DDS does now and then."""
    program = f"""
import ctypes, sys
from bearing_twin.command import cli
from bearing_twin.nodes import base_node, graph

graph.QUIET, base_node.LONGEST_GOODBYE = 0.1, 0.1
base_node.Node.destroy_node = lambda self: [ctypes.PyDLL(None).pause() for _ in iter(int, 1)]
sys.argv[1:] = {command_line.split()}
cli.program()
"""
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=300)
    assert result.returncode == code
    assert result.stderr.startswith("bearing_twin: there is no node") if code else result.stdout.startswith("name")


def test_where_no_node_is_discovered_the_list_says_so(toy, monkeypatch, capsys):
    from bearing_twin.nodes.graph import Graph

    monkeypatch.setattr(Graph, "nodes", lambda graph: [])
    assert cli.main(["node", "list"]) == cli.DONE
    assert "no node was discovered: start one" in capsys.readouterr().err


def test_parameters_are_read_and_set(at_once, answer):
    assert answer("param", "set", "/toy", "pace", "2", "--json") == {"pace": 2.0}  # a whole number for a real one
    assert answer("param", "get", "/toy", "pace", "--json") == {"pace": 2.0}
    assert answer("param", "get", "/toy", "changes", "--json") == {"changes": []}
    for written, value in (("[a=1, b=2]", ["a=1", "b=2"]), ("a=1", ["a=1"]), ("[]", [])):
        assert answer("param", "set", "/toy", "changes", written, "--json") == {"changes": value}
    assert {"name": "pace", "value": 2.0} in answer("param", "list", "/toy", "--json")["parameters"]
    assert "/toy has no parameter 'pac'; did you mean pace?" in answer(
        "param", "get", "/toy", "pac", code=cli.BAD_INPUT
    )
    unknown = answer("param", "set", "/toy", "contact.normal", "x", code=cli.BAD_INPUT)
    assert "/toy has no parameter 'contact.normal'" in unknown
    assert "/toy refuses pace = 'x'" in answer("param", "set", "/toy", "pace", "x", code=cli.BAD_INPUT)


def test_services_are_called(at_once, answer):
    assert answer("service", "call", "/toy/pause", "std_srvs/srv/SetBool", "{data: true}", "--json")["success"] is True
    assert answer("service", "call", "/toy/pause", "{data: true}", "--json")["success"] is True
    assert answer("service", "call", "/toy/pause", "--json", code=cli.BAD_INPUT) == {
        "success": False,
        "message": "as you say",
    }
    assert answer("service", "call", "/toy/pause", code=cli.BAD_INPUT).endswith(
        "bearing_twin: /toy/pause: as you say\n"
    )
    typed = ("service", "call", "/toy/pause")
    for arguments, sentence in [
        (("std_srvs/srv/SetBool", "{data: 1}"), "must be of type 'bool'"),
        (("std_srvs/Trigger",), "takes std_srvs/srv/SetBool, not std_srvs/srv/Trigger"),
        (("std_srvs/srv/SetBol",), "std_srvs has no srv 'SetBol'; did you mean SetBool"),
        (("std_srvs/srv/SetBool", "{data: 2024-13-45}"), "is no YAML"),
    ]:
        assert sentence in answer(*typed, *arguments, code=cli.BAD_INPUT)


def test_a_study_is_run_by_a_node(at_once, answer):
    assert "4 samples, 0 failed" in answer("study", "a")
    assert "the study was aborted: why" in answer("study", "bad", code=cli.BAD_INPUT)
    assert "the study was aborted: why" in answer("study", "a", "--samples", "0", code=cli.BAD_INPUT)  # not the default


def test_a_goal_whose_node_is_gone_is_not_waited_for(answer, monkeypatch):
    import ros

    monkeypatch.setattr("bearing_twin.nodes.graph.GONE", 0.3)
    served, gone = threading.Event(), threading.Event()

    def study(handle):
        served.set()
        gone.wait()
        return ros.RunStudy.Result()

    def spin():
        while not served.is_set():
            executor.spin_once(timeout_sec=0.05)
        server.destroy()  # here, as an executor must not see it vanish while it waits
        while not gone.is_set():
            executor.spin_once(timeout_sec=0.05)

    with ros.ros_executor(threads=2) as executor:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(executor.context.get_domain_id()))
        server = ros.ActionServer(ros.plain_node(executor, "served"), ros.RunStudy, "/bearing/run_study", study)
        thread = threading.Thread(target=spin, daemon=True)
        thread.start()
        try:
            assert "the node of /bearing/run_study is gone" in answer("study", "a", code=cli.BAD_INPUT)
        finally:
            served.set(), gone.set(), thread.join()
            executor.shutdown()


def test_messages_become_data_and_back(toy):
    import ros

    from bearing_twin.nodes.messages import MessageError, interface, message_from, plain_data

    data = {"wrench": {"force": {"x": 1, "y": "2e-3"}}, "header": {"frame_id": "a", "stamp": {"sec": 3}}}
    message = message_from(ros.WrenchStamped, data)
    assert plain_data(message)["wrench"]["force"] == {"x": 1.0, "y": 2e-3, "z": 0.0}
    assert plain_data(message_from(ros.Contacts, {"normal_load": [1, 2, 3]}), 2)["normal_load"] == [1.0, 2.0, "..."]
    for wrong, sentence in [
        ({"header": {"stamp": {"sec": 1e99}}}, "header.stamp: The 'sec' field must be of type 'int'"),
        ({"wrench": 3}, "wrench = 3 must be fields with values"),
        ([1], "must be fields with values, as {header: ..., wrench: ...}"),
        ({"weight": 3}, "WrenchStamped has no field 'weight'; legal: header, wrench"),
    ]:
        with pytest.raises(MessageError, match=sentence):
            message_from(ros.WrenchStamped, wrong)
    assert plain_data(message_from(ros.DiagnosticStatus, {"level": 255}))["level"] == 255
    with pytest.raises(MessageError, match="The 'level' field must be of type 'bytes'"):
        message_from(ros.DiagnosticStatus, {"level": 256})
    with pytest.raises(MissingInterfacesError, match="the type no_such/srv/Type cannot be imported"):
        interface("no_such/srv/Type", "srv")
