"""sim_node on the wire: topics, rates, losses, commands, diagnostics."""

import math
import re
import threading
import time
from array import array
from functools import cache

import pytest
from ros import (
    BearingState,
    Clock,
    Contacts,
    DiagnosticStatus,
    Float64,
    Parameter,
    SetBool,
    Step,
    Stiffness,
    Trigger,
    TwistStamped,
    WrenchStamped,
    call,
    deserialize_message,
    heard,
    padded,
    plain_node,
    rclpy,
    ros_executor,
    spin_for,
    spin_until,
    spin_until_heard,
    started,
    statuses,
    values_of,
)

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.topics import WRENCH
from bearing_twin.log.bag import raw_messages
from bearing_twin.log.run_log import read_log, write_log
from bearing_twin.log.stream import MessageStream, sample_range, topics
from bearing_twin.nodes.node_parameters import checked_values
from bearing_twin.nodes.sim_node import PARAMETERS, SimNode, scene_of
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation, simulate

pytestmark = pytest.mark.usefixtures("quick_diagnostics")

SCENE = load_scene("bearing_6203", ["solver.check=none"])  # nodes run without a second run
SHIFTED = ["model.dimension=quasi_static", "drive.change={time: 0.01, offset: [0, 0, 1e-6]}"]
NAMES = [(topic.full_name, topic.ros_type) for topic in topics(SCENE)]
PAUSE, RESET, STEP = "/bearing/sim_node/pause", "/bearing/sim_node/reset", "/bearing/sim_node/step"
STIFFNESS = "/bearing/sim_node/stiffness"


@cache
def expected(outputs):
    """The messages of the first outputs of the scene, by topic: as computed without ROS."""
    simulation, messages = Simulation(SCENE), {name: [] for name, _ in NAMES}
    stream = MessageStream(SCENE, choice=simulation.choice)
    for part in (stream.messages(simulation.advance(outputs)), stream.flush()):
        for topic, _, cdr in part:
            messages[topic.full_name].append(padded(cdr))
    return messages


@pytest.fixture(scope="module")
def paused():
    """An executor, a sim_node that waits at time 0, a node that hears all its topics, and what that heard."""
    with ros_executor() as executor:
        node = started(executor, SimNode, start_paused=True, duration=2000)
        watcher = plain_node(executor)
        lists = heard(watcher, NAMES)
        spin_until(executor, lambda: all(watcher.count_publishers(name) for name, _ in NAMES), "discovery")
        spin_until(executor, lambda: all(node.count_subscribers(name) for name, _ in NAMES), "discovery")
        spin_until(executor, lambda: node.loop, "preparation")
        yield executor, node, watcher, lists


def prepared_when(monkeypatch, event, method="__init__"):
    """Runs are not prepared, or nothing is computed by another `method`, before the event is set."""
    begin = getattr(Simulation, method)

    def waits(simulation, *arguments):
        event.wait(300.0)
        return begin(simulation, *arguments)

    monkeypatch.setattr(Simulation, method, waits)


def test_topics_types_and_quality_of_service(paused):
    _, node, watcher, _ = paused
    offered = dict(watcher.get_topic_names_and_types())
    for name, ros_type in [*NAMES, ("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")]:
        assert offered[name] == [ros_type]
        [publisher] = watcher.get_publishers_info_by_topic(name)
        assert publisher.qos_profile.reliability == rclpy.qos.ReliabilityPolicy.RELIABLE
        assert publisher.node_name == "sim_node"
    services = dict(node.get_service_names_and_types())
    assert services[PAUSE] == ["std_srvs/srv/SetBool"]
    assert services[RESET] == ["std_srvs/srv/Trigger"]
    assert services[STEP] == ["bearing_twin_msgs/srv/Step"]
    assert services[STIFFNESS] == ["bearing_twin_msgs/srv/Stiffness"]
    for command in KINDS["bearing"].commands():
        [listener] = watcher.get_subscriptions_info_by_topic(f"/bearing/{command.name}")
        assert listener.topic_type == command.ros_type


def test_pause_step_and_reset_while_it_runs(paused):
    executor, node, watcher, lists = paused
    states, samples = lists["/bearing/state"], lists["/bearing/samples"]
    pause = lambda data: call(executor, watcher, SetBool, PAUSE, SetBool.Request(data=data))  # noqa: E731
    step = lambda seconds: call(executor, watcher, Step, STEP, Step.Request(duration=seconds))  # noqa: E731
    refused = step(math.nan)
    assert not refused.success
    assert "must be above 0" in refused.message
    stepped = step(0.101)
    assert (stepped.success, stepped.time_ns) == (True, 101_000_000)
    spin_until(executor, lambda: len(states) == 11, "eleven states")
    pause(False)
    refused = step(0.1)
    assert not refused.success
    assert "pause it" in refused.message
    spin_until(executor, lambda: len(states) > 30, "running")
    assert pause(True).success
    stamp = node.loop.position_ns
    count = stamp // 10_000_000 + 1
    spin_until(executor, lambda: len(states) >= count, "all states before the pause")
    spin_for(executor, 0.3)
    assert (len(states), node.loop.position_ns) == (count, stamp)
    answer = call(executor, watcher, Trigger, RESET, Trigger.Request())
    assert (answer.success, answer.message) == (True, "run 2 starts at 0 s")
    pause(False)
    spin_until(executor, lambda: len(states) > count + 20 and len(samples) > 5, "running again")
    pause(True)
    sequences = [deserialize_message(data, BearingState).sequence for data in states]
    again = sequences.index(0, 1)  # one instant that was computed ahead may come before it
    assert sequences[:again] == list(range(0, 10 * again, 10))
    assert sequences[again:] == list(range(0, 10 * (len(sequences) - again), 10))
    ranges = [sample_range(data) for data in samples]
    restart = next(k for k, (first, _) in enumerate(ranges) if k and first == 0)
    for part in (ranges[:restart], ranges[restart:]):
        assert [first for first, _ in part] == [sum(n for _, n in part[:k]) for k in range(len(part))]


def test_whole_numbers_are_taken_for_numbers_and_the_rest_is_read_only(paused):
    executor, node, *_ = paused
    assert node.get_parameter("duration").value == 2000.0
    described = node.describe_parameter("duration")
    assert described.read_only
    assert "[s]" in described.description
    assert "0 to 86400" in described.additional_constraints
    assert described.floating_point_range[0].to_value == 86400.0
    assert node.get_parameter("overrides").type_ == Parameter.Type.STRING_ARRAY
    values = ("duration", 1.0), *(("real_time_factor", value) for value in (math.nan, 0.0, "fastest", 3.0, 2))
    results = node.set_parameters([Parameter(name, value=value) for name, value in values])
    assert [result.successful for result in results] == [False, False, False, True, True, True]
    assert "or fastest" in results[2].reason
    [result] = node.set_parameters([Parameter("real_time_factor", Parameter.Type.DOUBLE_ARRAY, array("d"))])
    assert "must be a number, 1e-09 to 1000, or fastest" in result.reason
    assert node.get_parameter("real_time_factor").value == 2.0
    spin_until(executor, lambda: float(node.loop.factor) == 2.0, "the new pace")


def test_every_byte_arrives_in_real_time_and_as_in_a_log_and_the_clock_is_that_of_the_simulation(tmp_path):
    """A node that waits for its subscribers loses no first message."""
    with ros_executor() as executor:
        watcher, ticks, began = plain_node(executor), [], time.monotonic()
        lists = heard(watcher, NAMES)
        best_effort = rclpy.qos.QoSProfile(depth=1000, reliability=rclpy.qos.ReliabilityPolicy.BEST_EFFORT)
        tick = lambda m: ticks.append(m.clock.sec * 10**9 + m.clock.nanosec)  # noqa: E731
        watcher.create_subscription(Clock, "/clock", tick, best_effort)  # as time sources
        options = {"log": str(tmp_path / "node.mcap"), "discovery": 20.0, "publish_clock": True}
        node = started(executor, SimNode, duration=1.0, **options)
        spin_until(executor, node.done.is_set, "end of the run")
        assert time.monotonic() - began > 0.9
        assert node.failure is None
        spin_until_heard(executor, lists, expected(1001))
    assert {name: [padded(data) for data in found] for name, found in lists.items()} == expected(1001)
    assert ticks == sorted(ticks)
    assert {*ticks} <= set(range(0, 10**9 + 1, 1_000_000))  # blocks of samples go out between two wrenches
    wrench = deserialize_message(lists["/bearing/ball_3/wrench"][50], WrenchStamped)
    assert (wrench.header.frame_id, wrench.header.stamp.nanosec) == ("ball_3", 500_000_000)
    contacts = deserialize_message(lists["/bearing/contacts"][50], Contacts)
    assert (contacts.sequence, len(contacts.normal_load)) == (500, 24)
    write_log(simulate(SCENE), tmp_path / "direct.mcap")
    node_log, direct = (
        [(one.topic.name, one.log_time, one.data) for one in raw_messages(tmp_path / f"{name}.mcap")]
        for name in ("node", "direct")
    )
    assert node_log == direct


def test_preparing_is_a_state_in_which_commands_are_taken(monkeypatch):
    prepared = threading.Event()
    monkeypatch.setattr("bearing_twin.nodes.sim_node.COMMAND_TIMEOUT", 0.1)
    prepared_when(monkeypatch, prepared)
    with ros_executor(threads=2) as executor:
        node, watcher = started(executor, SimNode, start_paused=True, duration=0.1), plain_node(executor)
        seen = statuses(watcher)
        spin_until(executor, lambda: len(seen) > 1, "diagnostics")
        assert {(status.level, status.message) for status in seen} == {(DiagnosticStatus.OK, "preparing")}
        seconds = [float(values_of(status)["elapsed_s"]) for status in seen]
        assert 0.0 < seconds[0] < seconds[-1]
        for data in (True, False):
            answer = call(executor, watcher, SetBool, PAUSE, SetBool.Request(data=data))
            assert answer.success
            assert answer.message == "accepted: carried out when the run is prepared"
        step = call(executor, watcher, Step, STEP, Step.Request(duration=0.01))
        assert (step.success, step.time_ns) == (False, 0)
        assert "still preparing" in step.message
        assert not node.loop
        prepared.set()
        spin_until(executor, node.done.is_set, "end of the run that was taken")
        assert node.failure is None
        assert node.loop.position_ns == 100_000_000


def test_a_pause_is_answered_while_outputs_are_computed(monkeypatch):
    """Of many callers at once none waits for the computation, however long a chunk takes."""
    computed = threading.Event()
    with ros_executor(threads=2) as executor:
        node, watcher = started(executor, SimNode, start_paused=True), plain_node(executor)
        spin_until(executor, lambda: node.loop, "preparation")
        prepared_when(monkeypatch, computed, "advance")
        pause = watcher.create_client(SetBool, PAUSE)
        spin_until(executor, pause.service_is_ready, "the service")
        answers = [pause.call_async(SetBool.Request(data=data)) for data in (False, False, True)]
        try:
            spin_until(executor, lambda: all(answer.done() for answer in answers), "the answers", patience=20.0)
        finally:
            computed.set()
        assert [answer.result().message.split()[0] for answer in answers] == ["running", "running", "paused"]
        assert node.loop.position_ns == 0


def test_a_duration_below_a_nanosecond_is_not_endless():
    with ros_executor() as executor:
        node = started(executor, SimNode, duration=1e-12)
        spin_until(executor, node.done.is_set, "end of the run", patience=60.0)
        assert node.loop.position_ns == 0


@pytest.mark.parametrize("method", ["__init__", "advance"])
def test_a_node_closed_before_its_first_output_ends_at_once_and_logs_nothing(method, monkeypatch, tmp_path):
    """An impact is solved as a whole with its first output, which takes minutes where the mesh is fine."""
    prepared = threading.Event()
    prepared_when(monkeypatch, prepared, method)
    with ros_executor() as executor:
        node = started(executor, SimNode, log=str(tmp_path / "run.mcap"))
        if method == "advance":
            spin_until(executor, lambda: node.loop, "preparation")
        node.close()
        assert not prepared.is_set()
        prepared.set()
        assert node.worker.stop(300.0)
    assert node.failure is None
    logs = list(tmp_path.iterdir())
    assert len(logs) == (method == "advance")
    assert not [message for log in logs for message in raw_messages(log)]  # which raises where one is not complete


def test_a_model_outside_its_range_is_marked_where_the_node_allows_it():
    with ros_executor(threads=2) as executor:
        options = {"overrides": SHIFTED, "allow_invalid": True}
        node = started(executor, SimNode, scene="bearing_6203_rig_400N", **options)
        watcher, laws = plain_node(executor), []
        seen = statuses(watcher)
        watcher.create_subscription(Contacts, "/bearing/contacts", lambda message: laws.append(message.law), 10)

        def said():
            reported = "drive.change.offset" in values_of(seen[-1]).get("outside_range", "")
            return reported and seen[-1].level == b"\x01" and "a model runs outside its range" in seen[-1].message

        spin_until(executor, lambda: seen and said(), "the mark on /diagnostics")
        marked = f"{node.loop.simulation.choice.law} (outside_range)"
        spin_until(executor, lambda: laws and laws[-1] == marked, "the mark on contacts")


def test_a_load_moves_the_ring_and_what_cannot_be_is_counted_on_diagnostics():
    """Stepped, with a prefix and a load that grows stale: the force follows, a service gives the stiffness."""
    with ros_executor(threads=2) as executor:
        options = {"frame_prefix": "left/", "load_timeout": 1.0, "start_paused": True}
        options["overrides"] = ["model.dimension=quasi_static", "rings.inner.mass=0"]
        node = started(executor, SimNode, scene="bearing_6203_rig_400N", **options)
        watcher = plain_node(executor)
        seen, wrench = statuses(watcher), "/bearing/inner_ring/wrench"
        wrenches = heard(watcher, [(wrench, WRENCH)])[wrench]
        load = watcher.create_publisher(WrenchStamped, "/bearing/command/load", 10)
        turn = watcher.create_publisher(TwistStamped, "/bearing/command/speed_stamped", 10)
        speed = watcher.create_publisher(Float64, "/bearing/command/speed", 10)
        spin_until(executor, lambda: watcher.count_publishers(wrench), "discovery")
        spin_until(executor, lambda: all(one.get_subscription_count() for one in (load, turn, speed)), "discovery")
        spin_until(executor, lambda: node.loop, "preparation")

        def stepped(seconds):
            """Force on the ring along y at the end of a step."""
            outputs = len(wrenches) + round(100 * seconds)
            assert call(executor, watcher, Step, STEP, Step.Request(duration=seconds)).success
            spin_until(executor, lambda: len(wrenches) >= outputs, "the step's outputs")
            return deserialize_message(wrenches[-1], WrenchStamped).wrench.force.y

        assert stepped(0.1) == pytest.approx(400.0)
        message = TwistStamped()
        message.twist.angular.z = 120.0
        turn.publish(message)
        speed.publish(Float64(data=math.nan))
        for frame, down in (("left/bearing_link", -900.0), ("map", -1.0), ("", math.nan), ("", -1e6)):
            message = WrenchStamped()
            message.header.frame_id, message.wrench.force.y = frame, down
            load.publish(message)
        counts = node.loop.commands.counts
        spin_until(executor, lambda: (counts["taken"], counts["refused"]) == (2, 4), "the commands")
        assert stepped(0.5) == pytest.approx(900.0)
        answer = call(executor, watcher, Stiffness, STIFFNESS, Stiffness.Request())
        assert (answer.success, answer.header.frame_id) == (True, "left/bearing_link")
        assert (answer.sequence, answer.header.stamp.nanosec) == (600, 600_000_000)
        assert answer.load[1] == pytest.approx(-900.0, rel=1e-5)
        assert 0.8e8 < answer.stiffness[6] < 1.0e8
        assert answer.inner_ring_speed == 120.0

        def refused():
            """How many warnings reported: each counts those since the one before."""
            found = (re.search(r"(\d+) refused, the last: command/", status.message) for status in seen)
            return sum(int(one[1]) for one in found if one)

        spin_until(executor, lambda: refused() == 4, "the count of refusals")
        assert values_of(seen[-1])["load_from"] == "command/load"
        assert stepped(0.6) == pytest.approx(400.0)
        stale = "command/load is stale, 1 s without another"
        spin_until(executor, lambda: stale in seen[-1].message, "staleness")
        assert seen[-1].level == DiagnosticStatus.WARN


REFUSED = (
    ({"real_time_factor": 0}, "real_time_factor = 0 must be a number, 1e-09 to 1000, or fastest"),
    ({"repeat": -2.0}, "repeat = -2.0 must be a number in s, -1 to 86400"),
    ({"overrides": ["contact.normal=hurtz"]}, "did you mean hertz?"),
    ({"overrides": ["solver.allow_invalid=on"]}, "the node's parameter allow_invalid = false forbids"),
    ({"overrides": SHIFTED}, "drive.change.offset is 1e-06 m, and it holds up to 0 m"),
)


@pytest.mark.parametrize(("parameters", "words"), REFUSED)
def test_what_cannot_be_run_is_refused(parameters, words):
    with pytest.raises(BearingTwinError) as refused:
        scene_of(checked_values(PARAMETERS, parameters))
    assert words in str(refused.value)


def test_a_run_that_a_command_has_ruined_ends_no_node(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # where the file of the failure is written
    late = "rings.inner.change={time: 0.0105, load: [0, -7e5, 0]}"
    with ros_executor() as executor:
        node = started(executor, SimNode, scene="bearing_6203_rig_400N", overrides=[late], start_paused=True)
        watcher = plain_node(executor)
        seen, speed = statuses(watcher), watcher.create_publisher(Float64, "/bearing/command/speed", 10)
        spin_until(executor, speed.get_subscription_count, "discovery")
        speed.publish(Float64(data=200.0))
        spin_until(executor, lambda: node.loop and node.loop.commands.counts["taken"], "the command")
        call(executor, watcher, SetBool, PAUSE, SetBool.Request(data=False))
        spin_until(executor, lambda: seen and seen[-1].level == DiagnosticStatus.ERROR, "the failure")
        assert "~/reset" in seen[-1].message
        assert not node.done.is_set()
        answer = call(executor, watcher, Trigger, RESET, Trigger.Request())
        assert (answer.success, answer.message) == (True, "run 2 starts at 0 s")
        assert list(tmp_path.glob("failure_*.json"))


def test_a_law_is_switched_by_a_parameter_of_the_running_node(tmp_path, monkeypatch):
    """A refused one leaves parameter and run as they are, also where it is the log that cannot be opened."""
    monkeypatch.setattr("bearing_twin.nodes.sim_node.MOST_LOGS", 2)
    with ros_executor(threads=2) as executor:
        node = started(executor, SimNode, log=str(tmp_path / "run.mcap"))
        watcher, laws = plain_node(executor), []
        contacts = lambda message: laws.append(message.law)  # noqa: E731
        watcher.create_subscription(Contacts, "/bearing/contacts", contacts, 10)
        spin_until(executor, lambda: len(laws) > 3, "contacts")
        for overrides, reason in ((["contact.normal=hertzz"], "did you mean hertz"), (["geometry.balls=7"], "topics")):
            [result] = node.set_parameters([Parameter("overrides", value=overrides)])
            assert not result.successful
            assert reason in result.reason
        [result] = node.set_parameters([Parameter("overrides", value=["contact.normal=volumetric"])])
        assert result.successful
        spin_until(executor, lambda: laws[-1] == "volumetric", "the other law")
        [result] = node.set_parameters([Parameter("overrides", value=["contact.normal=hertz"])])
        assert "the node has written 2 logs" in result.reason
        assert node.get_parameter("overrides").value == ["contact.normal=volumetric"]
        assert (node.failure, node.loop.run) == (None, 2)
        node.close()
    assert [read_log(tmp_path / name).choice.law for name in ("run.mcap", "run_2.mcap")] == [laws[0], "volumetric"]
