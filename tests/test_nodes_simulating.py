"""What sim_node computes: which bytes go out when, what commands do, and what is in its log. No ROS."""

import math
from collections import defaultdict
from types import SimpleNamespace

import pytest
from loops import BLOCK, MS, SCENE, START, Loop, made_up_simulation
from runs import a_choice, bits, cut, made_up_scene

from bearing_twin.base.errors import BearingTwinError, IntegrationError
from bearing_twin.kinds.contract import Command
from bearing_twin.log.bag import raw_messages
from bearing_twin.log.run_log import read_log
from bearing_twin.log.stream import MessageStream
from bearing_twin.nodes.pacing import FASTEST
from bearing_twin.nodes.simulation_loop import LONGEST_STEP
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation

SPEED = Command("command/speed", "std_msgs/msg/Float64", lambda value: ("set_speed", value), "")


def expected(outputs):
    """The messages of the first `outputs` outputs, by topic."""
    stream, messages = MessageStream(SCENE, choice=a_choice()), defaultdict(list)
    for part in (stream.messages(cut(BLOCK, outputs)[0]), stream.flush()):
        for topic, stamp_ns, cdr in part:
            messages[topic.name].append((stamp_ns, cdr))
    return messages


@pytest.mark.parametrize("factor", [FASTEST, 1.0, 7.0, 1e-7])
def test_every_message_of_a_run_is_delivered_whatever_the_pace(factor):
    loop = Loop(factor=factor, duration_ns=234 * MS)
    loop.drive(1_000 / min(1.0 if factor == FASTEST else factor, 1.0))
    assert loop.over
    assert loop.delivered == expected(235)
    assert loop.position_ns == 234 * MS


@pytest.mark.parametrize(("repeat_ms", "begins"), [(300, (0, 300, 600)), (40, (0, 100, 200, 300))])
def test_a_run_begins_again_at_the_pace_asked_for(repeat_ms, begins, tmp_path):
    """From begin to begin, or at once where the run took longer; a repeat sends the same bytes and is not logged."""
    loop = Loop(log=tmp_path / "run.mcap", duration_ns=100 * MS, repeat_ns=repeat_ms * MS)
    loop.drive(begins[-1] + 99)
    assert [wall for wall, topic in loop.walls if topic == "scene"] == [begin * MS for begin in begins]
    assert not loop.over
    assert loop.run == loop.status()[2]["runs"] == len(begins)
    runs, whole = [data for _, data in loop.delivered["state"]], [data for _, data in expected(101)["state"]]
    assert runs[:11] == runs[11:22] == whole
    assert [path.name for path in tmp_path.iterdir()] == ["run.mcap"]
    assert bits(read_log(tmp_path / "run.mcap")) == bits(cut(BLOCK, 101)[0])  # complete while the node lives on


def test_a_run_that_waits_begins_again_on_request_alone_and_a_pause_holds_the_next_begin():
    loop = Loop(duration_ns=100 * MS, repeat_ns=-1)
    loop.drive(5_000)
    assert (loop.finished, loop.over, loop.run) == (True, False, 1)
    assert loop.status()[:2] == (False, "waiting for the next start")
    assert len(loop.delivered["state"]) == 11
    assert loop.reset(loop.clock) == "run 2 starts at 0 s"
    loop.drive(200)
    assert len(loop.delivered["state"]) == 22
    repeated = Loop(duration_ns=100 * MS, repeat_ns=200 * MS)
    for paused, wall, scenes in ((False, 150, 1), (True, 500, 1), (False, 50, 2)):
        repeated.pause(repeated.clock, paused)
        repeated.drive(wall)
        assert len(repeated.delivered["scene"]) == scenes


def test_in_real_time_nothing_goes_out_before_it_is_due_and_a_pause_loses_nothing():
    loop = Loop(duration_ns=200 * MS)
    loop.drive(73)
    assert [t for t, _ in loop.delivered["state"]] == [10 * MS * k for k in range(8)]
    assert loop.outputs() == list(range(50))
    assert "paused at 0.070000 s" in loop.pause(loop.clock, True)
    loop.drive(500)
    assert len(loop.delivered["state"]) == 8
    loop.pause(loop.clock, False)
    loop.drive(200)
    assert loop.delivered == expected(201)


def test_the_first_chunk_is_computed_before_the_pace_begins():
    """What it takes delays the start, and nothing is late after it."""
    loop, ticks = Loop(), []
    advance = loop.simulation.advance

    def slow(outputs):
        loop.clock += 80 * MS if loop.simulation.sequence < 0 else 0
        return advance(outputs)

    loop.simulation.advance, loop.tick = slow, lambda time_ns: ticks.append((loop.clock, time_ns))
    loop.drive(200)
    (first, _), *_ = ticks
    assert first - START == 80 * MS
    assert ticks == [(first + time_ns, time_ns) for _, time_ns in ticks]


def test_a_look_tells_of_the_time_since_the_last_one():
    """A tenth of a second in time, then outputs that take twice as long to compute as they last."""
    loop = Loop()
    loop.drive(100)
    slow, message, numbers = loop.status()
    assert (slow, message) == (False, "running")
    assert numbers["real_time_factor"] == pytest.approx(1.0, rel=0.05)
    advance = loop.simulation.advance

    def slowly(outputs):
        loop.clock += 2 * outputs * MS
        return advance(outputs)

    loop.simulation.advance = slowly
    loop.drive(300)
    slow, message, numbers = loop.status()
    assert slow
    assert "cannot keep up" in message
    assert numbers["real_time_factor"] == pytest.approx(0.5, rel=0.15)
    assert 0.1 < numbers["lag_s"] < 0.2


@pytest.mark.parametrize(("factor", "early"), [(1.0, 0.1), (0.001, 15.0), (FASTEST, 50.0)])
def test_outputs_that_take_long_are_told_of_while_they_are_computed(factor, early):
    """Until they come nothing is delivered, so that no lag of what was delivered would tell of them."""
    loop, seen = Loop(factor=factor), {}
    advance = loop.simulation.advance

    def long(outputs):
        for seconds in (early, 60):
            seen[seconds] = loop.status(loop.clock + round(seconds * 1e9))
        return advance(outputs)

    loop.simulation.advance = long
    loop.turn(loop.clock)
    assert seen[60][1] == "computing the first outputs"
    while len(loop._pending):
        loop.clock = loop.turn(loop.clock)
    loop.turn(loop.clock)
    assert not seen[early][0]
    assert seen[60][0] is (factor != FASTEST)
    assert seen[60][2]["lag_s"] == pytest.approx({1.0: 60.0, 0.001: 40.0}.get(factor, 0.0), abs=0.1)


@pytest.mark.parametrize(
    ("status", "said"),
    [("done", ""), ("doubtful: loads", "the run is doubtful: loads"), ("failed: energy", "the run is failed: energy")],
)
def test_a_run_below_its_specification_is_a_warning(status, said):
    loop = Loop()
    assert loop.warning() == ""
    loop.simulation.report = lambda: SimpleNamespace(status=status, errors={})
    loop.drive(100)
    assert loop.status()[2]["status"] == status
    assert loop.warning() == said


def test_steps_go_exactly_as_far_as_asked():
    loop = Loop(duration_ns=300 * MS)
    loop.paused = True
    for seconds in (0.0, -1.0, math.nan, math.inf, 2 * LONGEST_STEP):
        with pytest.raises(BearingTwinError, match="must be above 0 and at most"):
            loop.step(loop.clock, seconds)
    assert loop.simulation.sequence == -1
    loop.step(loop.clock, 0.0502)  # rounded up to whole outputs
    assert loop.simulation.time_ns == loop.position_ns == 51 * MS
    loop.step(loop.clock, 1e-10)
    assert loop.position_ns == 52 * MS
    loop.pause(loop.clock, False)
    loop.drive(13)  # to 60 ms, the last message that is due; 70 ms are computed
    loop.pause(loop.clock, True)
    loop.step(loop.clock, 0.004)
    assert loop.position_ns == 64 * MS
    assert len(loop.delivered["state"]) == 7
    loop.step(loop.clock, 5.0)
    assert loop.position_ns == 300 * MS  # the end of the run
    loop.pause(loop.clock, False)
    loop.drive(1)
    assert loop.delivered == expected(301)


def test_after_odd_steps_what_is_computed_last_is_published_again():
    loop = Loop()
    loop.drive(20)
    loop.pause(loop.clock, True)
    loop.step(loop.clock, 0.033)  # beyond what was computed ahead
    loop.pause(loop.clock, False)
    loop.drive(100)
    loop.close()
    assert loop.delivered["state"][-1][0] == loop.simulation.time_ns


def test_a_flood_of_commands_is_carried_out_once_in_a_period():
    """Of each topic the last legal one; those before are superseded."""
    loop = Loop(command_ns=10 * MS)
    loop.paused = True
    for k in range(2000):  # in 20 ms
        loop.commands.offer(SPEED, math.nan if k % 50 == 0 else float(k))
        wake_at = loop.turn(START + 10_000 * k)
        assert wake_at in (None, loop.commands_at)
    loop.turn(START + 30 * MS)
    assert [value for _, value in loop.simulation.speeds] == [999.0, 1999.0]
    assert loop.commands.counts == {"taken": 2, "refused": 2, "superseded": 1996}
    assert "nan" in loop.commands.refusals[-1]
    with pytest.raises(BearingTwinError, match="finite and within"):
        loop.execute(SPEED, 1.01e4)


def test_a_reset_starts_again_at_zero_with_a_new_log(tmp_path):
    loop = Loop(log=tmp_path / "run.mcap", duration_ns=60 * MS)
    loop.drive(33)
    loop.reset(loop.clock)
    assert loop.position_ns == 0
    loop.drive(100)
    assert loop.finished
    loop.close()
    first, second = (read_log(tmp_path / name) for name in ("run.mcap", "run_2.mcap"))
    whole, logged = bits(cut(BLOCK, 61)[0]), bits(first)
    assert 30 <= len(logged) <= 50
    assert logged == whole[: len(logged)]
    assert bits(second) == whole
    assert loop.outputs() == [*range(len(logged)), *range(61)]


def test_the_log_holds_every_topic_when_the_node_ends_in_the_middle(tmp_path):
    """Also those that nobody subscribes to."""
    loop = Loop(log=tmp_path / "run.mcap", subscribed=lambda: ())
    loop.drive(87)
    loop.close()
    loop.close()
    log, outputs = read_log(tmp_path / "run.mcap"), loop.simulation.sequence + 1
    assert bits(log) == bits(cut(BLOCK, outputs)[0])
    assert log.report == {"status": "made up"}
    assert loop.outputs() == list(range(outputs))
    logged = {message.topic.name.removeprefix("/bearing/") for message in raw_messages(tmp_path / "run.mcap")}
    assert logged == set(expected(outputs))


OVERLOADED = load_scene(
    "bearing_6203_rig_400N", ["rings.inner.change={time: 0.0105, load: [0, -7e5, 0]}", "cage.kind=none"]
)


def test_a_run_that_fails_by_itself_delivers_and_logs_all_before(tmp_path):
    scene = OVERLOADED
    loop = Loop(Simulation(scene), tmp_path / "run.mcap")
    with pytest.raises(IntegrationError, match=r"^after 0.01 s: at 0.0105 s a load of"):
        loop.drive(200)
    loop.close()
    assert loop.outputs() == list(range(11))
    log = read_log(tmp_path / "run.mcap")
    assert sum(map(len, log.blocks())) == 11
    assert (log.report["status"], log.report["failure_body"]) == ("failed: overload", "inner ring")


def test_without_subscribers_the_end_of_each_chunk_says_how_far_it_is():
    loop = Loop(made_up_simulation(made_up_scene(balls=2, publish_rate=1000.0)), duration_ns=100 * MS, subscribed=tuple)
    loop.drive(200)
    reported = [time_ns for messages in loop.delivered.values() for time_ns, cdr in messages if not cdr]
    assert loop.over
    assert len(reported) < 10
    assert loop.position_ns == max(reported) == 100 * MS
