"""What sim_node thinks: which bytes go out when, what commands do, and what is in its log. No ROS."""

import itertools
import math
from collections import defaultdict
from types import SimpleNamespace

import pytest
from made_up_run import a_choice, bits, cut, made_up_block, made_up_scene

from bearing_twin.base.errors import BearingTwinError, IntegrationError, LogError
from bearing_twin.kinds.contract import PUBLISH, Command
from bearing_twin.log.bag import raw_messages
from bearing_twin.log.run_log import LogWriter, read_log
from bearing_twin.log.sample_block import sample_range
from bearing_twin.log.stream import MessageStream, topics
from bearing_twin.nodes.pacing import FASTEST
from bearing_twin.nodes.simulation_loop import GREATEST_SPEED, LONGEST_STEP, SimulationLoop, log_path
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation

MS = 1_000_000
START = 55_000_000_000
SCENE = made_up_scene(balls=2)
BLOCK = made_up_block(SCENE, 400)


def made_up_simulation():
    """The outputs of BLOCK, one after the other, behind the interface of a Simulation; `speeds` are the commands."""
    at_start = {
        "sequence": -1,
        "time_ns": -MS,
        "speeds": [],
        "choice": a_choice(),
        "chosen": a_choice(),
        "switched": "",
    }
    it = SimpleNamespace(output_period_ns=MS, chunk_outputs=400, scene=SCENE, **at_start)

    def reset():
        it.sequence, it.time_ns = -1, -MS

    def advance(outputs):
        first = it.sequence + 1
        it.sequence += outputs
        it.time_ns += outputs * MS
        return cut(BLOCK, first, first + outputs)[1]

    it.reset, it.advance, it.looks = reset, advance, SimpleNamespace(since_ns=0)
    it.set_speed = lambda speed: it.speeds.append((it.time_ns, speed)) or ""
    said = {"status": "made up"}
    it.report = lambda: SimpleNamespace(**said, errors={}, as_dict=lambda: said, record=lambda: said)
    return it


def made_up_loop(**options):
    """A loop over a made-up simulation, what it delivers by topic, and a clock for `drive`."""
    delivered = defaultdict(list)
    loop = SimulationLoop(
        made_up_simulation(),
        lambda: MessageStream(SCENE, choice=a_choice()),
        lambda message: delivered[message.topic].append((message.time_ns, message.cdr)),
        **options,
    )
    return loop, delivered, [START]


def drive(loop, clock, until_ns):
    """Turns the loop for `until_ns` of wall time, or until it has nothing more to do."""
    end = clock[0] + until_ns
    while (wake_at := loop.turn(clock[0])) is not None and wake_at <= end:
        clock[0] = max(clock[0], wake_at)
    clock[0] = end


def expected(outputs):
    """The messages of the first `outputs` outputs, by topic."""
    stream, messages = MessageStream(SCENE, choice=a_choice()), defaultdict(list)
    for part in (stream.messages(cut(BLOCK, outputs)[0]), stream.flush()):
        for topic, stamp_ns, cdr in part:
            messages[topic.name].append((stamp_ns, cdr))
    return messages


def outputs_in(delivered):
    """Numbers of the outputs in the SampleBlocks delivered."""
    ranges = (sample_range(cdr) for _, cdr in delivered["samples"])
    return [number for first, count in ranges for number in range(first, first + count)]


@pytest.mark.parametrize("factor", ["fastest", 1.0, 7.0, 1e-7])
def test_every_message_of_a_run_is_delivered_whatever_the_pace(factor):
    loop, delivered, clock = made_up_loop(factor=factor, duration_ns=234 * MS)
    drive(loop, clock, round(1_000 * MS / min(1.0 if factor == "fastest" else factor, 1.0)))
    assert loop.paced.finished
    assert loop.over
    assert delivered == expected(235)
    assert loop.time_ns == 234 * MS


@pytest.mark.parametrize(("repeat_ms", "begins"), [(300, (0, 300, 600)), (40, (0, 100, 200, 300))])
def test_a_run_begins_again_at_the_pace_asked_for(repeat_ms, begins, tmp_path):
    """From begin to begin, or at once where the run took longer; a repeat sends the same bytes and is not logged."""
    opened = []

    def open_log(run):
        opened.append(run)
        return LogWriter(log_path(tmp_path / "run.mcap", run), SCENE)

    loop, _, clock = made_up_loop(duration_ns=100 * MS, repeat_ns=repeat_ms * MS, open_log=open_log)
    stamps, first = [], loop.paced.deliver
    loop.paced.deliver = lambda message: (stamps.append((clock[0] - START, message)), first(message))
    drive(loop, clock, begins[-1] * MS + 99 * MS)
    scenes = [wall for wall, message in stamps if message.topic == "scene"]
    assert scenes == [begin * MS for begin in begins]
    assert not loop.over
    assert loop.runs == len(begins) - 1
    runs, whole = [[one.cdr for _, one in stamps if one.topic == "state"]], [data for _, data in expected(101)["state"]]
    assert runs[0][:11] == runs[0][11:22] == whole
    assert opened == [0]
    assert bits(read_log(tmp_path / "run.mcap")) == bits(cut(BLOCK, 101)[0])  # complete while the node lives on


def test_a_run_that_waits_begins_again_on_request_alone():
    loop, delivered, clock = made_up_loop(duration_ns=100 * MS, repeat_ns=-1)
    drive(loop, clock, 5_000 * MS)
    assert (loop.paced.finished, loop.over, loop.runs) == (True, False, 0)
    assert loop.look()[:2] == (False, "waiting for the next start")
    assert len(delivered["state"]) == 11
    loop.reset(clock[0])
    drive(loop, clock, 200 * MS)
    assert len(delivered["state"]) == 22
    assert [t for t, _ in delivered["scene"]] == [0, 0]


def test_a_pause_holds_the_next_begin():
    loop, delivered, clock = made_up_loop(duration_ns=100 * MS, repeat_ns=200 * MS)
    drive(loop, clock, 150 * MS)
    loop.pause(clock[0], True)
    drive(loop, clock, 500 * MS)
    assert len(delivered["scene"]) == 1
    loop.pause(clock[0], False)
    drive(loop, clock, 50 * MS)
    assert len(delivered["scene"]) == 2


def test_in_real_time_nothing_goes_out_before_it_is_due():
    loop, delivered, clock = made_up_loop()
    drive(loop, clock, 105 * MS)
    assert [t for t, _ in delivered["state"]] == [10 * MS * k for k in range(11)]
    assert outputs_in(delivered) == list(range(100))


def test_the_first_chunk_is_computed_before_the_pace_begins():
    """What it takes delays the start, and nothing is late after it."""
    loop, delivered, clock = made_up_loop()
    advance, walls = loop.simulation.advance, []

    def slow(outputs):
        clock[0] += 80 * MS if loop.simulation.sequence < 0 else 0
        return advance(outputs)

    loop.simulation.advance, loop.paced.tick = slow, lambda time_ns: walls.append((clock[0], time_ns))
    drive(loop, clock, 200 * MS)
    (first, _), *_ = walls
    assert first - START == 80 * MS
    assert walls == [(first + time_ns, time_ns) for _, time_ns in walls]
    assert delivered["samples"]


def test_a_look_tells_of_the_time_since_the_last_one():
    """A tenth of a second in time, then outputs that take twice as long to compute as they last."""
    loop, _, clock = made_up_loop()
    drive(loop, clock, 100 * MS)
    slow, message, numbers = loop.look()
    assert (slow, message) == (False, "running")
    assert numbers["real_time_factor"] == pytest.approx(1.0, rel=0.05)
    advance = loop.simulation.advance

    def slowly(outputs):
        clock[0] += 2 * outputs * MS
        return advance(outputs)

    loop.simulation.advance = slowly
    drive(loop, clock, 300 * MS)
    slow, message, numbers = loop.look()
    assert slow
    assert "cannot keep up" in message
    assert numbers["real_time_factor"] == pytest.approx(0.5, rel=0.15)
    assert 0.1 < numbers["lag_s"] < 0.2


@pytest.mark.parametrize(
    ("status", "said"),
    [("done", ""), ("doubtful: loads", "the run is doubtful: loads"), ("failed: energy", "the run is failed: energy")],
)
def test_whoever_looks_after_a_run_is_told_that_it_is_worth_less_than_wanted(status, said):
    loop, _, clock = made_up_loop()
    assert loop.warning() == ""
    loop.simulation.report = lambda: SimpleNamespace(status=status, errors={})
    drive(loop, clock, 100 * MS)
    assert loop.look()[2]["status"] == status
    assert loop.warning() == said


def test_after_odd_steps_what_is_computed_last_is_published_again():
    loop, delivered, clock = made_up_loop()
    drive(loop, clock, 20 * MS)
    loop.pause(clock[0], True)
    loop.step(clock[0], 0.033)  # beyond what was computed ahead
    loop.pause(clock[0], False)
    drive(loop, clock, 100 * MS)
    loop.close()
    assert delivered["state"][-1][0] == loop.simulation.time_ns


def test_a_pause_holds_time_and_loses_nothing():
    loop, delivered, clock = made_up_loop(duration_ns=200 * MS)
    drive(loop, clock, 73 * MS)
    assert "paused at 0.070000 s" in loop.pause(clock[0], True)
    before = len(delivered["state"])
    drive(loop, clock, 500 * MS)
    assert len(delivered["state"]) == before
    loop.pause(clock[0], False)
    drive(loop, clock, 200 * MS)
    assert delivered == expected(201)


def test_steps_go_exactly_as_far_as_asked():
    loop, delivered, clock = made_up_loop(duration_ns=300 * MS)
    loop.paced.paused = True
    loop.step(clock[0], 0.0502)  # rounded up to whole outputs
    assert loop.simulation.time_ns == loop.time_ns == 51 * MS
    loop.step(clock[0], 1e-10)
    assert loop.time_ns == 52 * MS
    loop.pause(clock[0], False)
    drive(loop, clock, 13 * MS)  # to 60 ms, the last message that is due; 70 ms are computed
    loop.pause(clock[0], True)
    loop.step(clock[0], 0.004)
    assert loop.time_ns == 64 * MS
    assert len(delivered["state"]) == 7
    loop.step(clock[0], 5.0)
    assert loop.time_ns == 300 * MS  # the end of the run
    loop.pause(clock[0], False)
    drive(loop, clock, MS)
    assert delivered == expected(301)


@pytest.mark.parametrize("seconds", [0.0, -1.0, math.nan, math.inf, 2 * LONGEST_STEP])
def test_impossible_steps_are_refused(seconds):
    loop, _, clock = made_up_loop()
    loop.paced.paused = True
    with pytest.raises(BearingTwinError, match="must be above 0 and at most"):
        loop.step(clock[0], seconds)
    assert loop.simulation.sequence == -1


def test_a_speed_takes_effect_within_a_chunk():
    loop, _, clock = made_up_loop()
    drive(loop, clock, 50 * MS)
    loop.set_speed(clock[0], -100.0)
    [(time_ns, speed)] = loop.simulation.speeds
    assert speed == -100.0
    assert time_ns - loop.time_ns <= 10 * MS


@pytest.mark.parametrize("speed", [math.nan, math.inf, -math.inf, 1.01 * GREATEST_SPEED])
def test_impossible_speeds_are_refused(speed):
    loop, _, clock = made_up_loop()
    with pytest.raises(BearingTwinError, match="finite"):
        loop.set_speed(clock[0], speed)
    assert loop.simulation.speeds == []


def test_a_reset_starts_again_at_zero_with_a_new_log(tmp_path):
    def open_log(run):
        return LogWriter(log_path(tmp_path / "run.mcap", run), SCENE, {"law": "hertz"})

    loop, delivered, clock = made_up_loop(open_log=open_log, duration_ns=60 * MS)
    drive(loop, clock, 33 * MS)
    loop.reset(clock[0])
    assert loop.time_ns == 0
    drive(loop, clock, 100 * MS)
    assert loop.paced.finished
    loop.close()
    first, second = (read_log(tmp_path / name) for name in ("run.mcap", "run_1.mcap"))
    whole = bits(cut(BLOCK, 61)[0])
    logged = bits(first)
    assert 30 <= len(logged) <= 50
    assert logged == whole[: len(logged)]
    assert bits(second) == whole
    numbers = outputs_in(delivered)
    assert numbers == [*range(len(logged)), *range(61)]


def test_where_no_next_log_can_be_opened_a_reset_changes_nothing(tmp_path):
    def open_log(run):
        if run:
            raise LogError("the disk is full")
        return LogWriter(tmp_path / "run.mcap", SCENE, {"law": "hertz"})

    loop, _, clock = made_up_loop(open_log=open_log, duration_ns=60 * MS)
    drive(loop, clock, 33 * MS)
    with pytest.raises(LogError, match="the disk is full"):
        loop.reset(clock[0])
    assert loop.time_ns >= 30 * MS
    drive(loop, clock, 100 * MS)
    loop.close()
    assert bits(read_log(tmp_path / "run.mcap")) == bits(cut(BLOCK, 61)[0])


def test_the_log_holds_everything_when_the_node_ends_in_the_middle(tmp_path):
    loop, delivered, clock = made_up_loop(open_log=lambda run: LogWriter(tmp_path / "run.mcap", SCENE))
    drive(loop, clock, 87 * MS)
    loop.close()
    loop.close()
    log = read_log(tmp_path / "run.mcap")
    assert bits(log) == bits(cut(BLOCK, loop.simulation.sequence + 1)[0])
    assert log.report == {"status": "made up"}
    assert outputs_in(delivered) == list(range(loop.simulation.sequence + 1))


def test_a_run_that_breaks_off_delivers_and_logs_all_before(tmp_path):
    late = "rings.inner.change={time: 0.0105, load: [0, -7e5, 0]}"
    scene = load_scene("bearing_6203_rig_400N", [late, "cage.kind=none"])
    delivered, clock = defaultdict(list), [START]
    loop = SimulationLoop(
        Simulation(scene),
        lambda: MessageStream(scene),
        lambda message: delivered[message.topic].append((message.time_ns, message.cdr)),
        open_log=lambda run: LogWriter(tmp_path / "run.mcap", scene),
    )
    with pytest.raises(IntegrationError, match=r"^after 0.01 s: at 0.0105 s a load of"):
        drive(loop, clock, 200 * MS)
    loop.close()
    assert outputs_in(delivered) == list(range(11))
    log = read_log(tmp_path / "run.mcap")
    assert sum(map(len, log.blocks())) == 11
    assert (log.report["status"], log.report["failure_body"]) == ("failed: overload", "inner ring")


def test_a_log_takes_what_nobody_listens_to(tmp_path):
    loop, _, clock = made_up_loop(
        open_log=lambda run: LogWriter(tmp_path / "run.mcap", SCENE), subscribed=lambda: (), duration_ns=60 * MS
    )
    drive(loop, clock, 100 * MS)
    loop.close()
    logged = {message.topic.name.removeprefix("/bearing/") for message in raw_messages(tmp_path / "run.mcap")}
    assert logged == set(expected(61))


@pytest.mark.parametrize("tells_time", [False, True])
def test_where_nobody_listens_few_words_tell_how_far_it_is(tells_time):
    scene, words = made_up_scene(balls=2, publish_rate=1000.0), []
    loop = SimulationLoop(
        made_up_simulation(),
        lambda: MessageStream(scene, choice=a_choice()),
        lambda message: words.append((message.time_ns, message.cdr)),
        duration_ns=100 * MS,
        subscribed=tuple,
    )
    loop.tells_time = tells_time
    drive(loop, [START], 200 * MS)
    reported = sorted({time_ns for time_ns, cdr in words if not cdr})
    assert loop.over
    assert loop.time_ns == reported[-1] == 100 * MS
    if tells_time:
        assert reported == list(range(0, 101 * MS, MS))
    else:
        assert len(reported) < 15
        assert max(b - a for a, b in itertools.pairwise(reported)) <= 20 * MS


def test_what_is_published_more_often_is_kept_as_long_for_a_late_subscriber():
    def depths(rate):
        scene = made_up_scene(output_rate=max(rate, 1000.0), publish_rate=rate)
        return {topic.qos.depth for topic in topics(scene) if topic.rate == PUBLISH}

    assert [depths(rate) for rate in (20.0, 100.0, 1000.0, 5000.0)] == [{80}, {400}, {4000}, {10_000}]
    impact = load_scene("two_spheres")  # its seconds take hours: a tenth of one is no time
    assert {topic.qos.depth for topic in topics(impact) if topic.rate == PUBLISH} == {80}


@pytest.mark.parametrize(("factor", "slow"), [(1.0, True), (FASTEST, False)])
def test_outputs_that_take_long_are_told_of_while_they_are_computed(factor, slow):
    """Until they come nothing is delivered, so that no lag of what was delivered would tell of them."""
    loop, _, clock = made_up_loop(factor=factor)
    seen, advance = {}, loop.simulation.advance

    def long(outputs):
        for seconds in (0.3, 60):
            seen[seconds] = loop.look(clock[0] + round(seconds * 1e9))
        return advance(outputs)

    assert not loop.look(clock[0] + 10**12)[0]  # nothing was asked for yet
    loop.simulation.advance = long
    loop.turn(clock[0])
    assert "have taken" not in seen[0.3][1]
    assert seen[60][0] is slow
    assert seen[60][1].endswith(": the next outputs have taken 60.0 s so far")
    assert seen[60][2]["lag_s"] == pytest.approx(60.0 if slow else 0.0)
    assert "have taken" not in loop.look(clock[0] + 10**12)[1]


def test_a_flood_of_commands_is_carried_out_once_in_a_period():
    """Of each topic the last legal one; those before are superseded."""
    loop, _, _ = made_up_loop(command_ns=10 * MS)
    loop.paced.paused = True
    speed = Command("command/speed", "std_msgs/msg/Float64", lambda value: ("set_speed", value), "")
    for k in range(2000):  # in 20 ms
        loop.commands.offer(speed, math.nan if k % 50 == 0 else float(k))
        wake_at = loop.turn(START + 10_000 * k)
        assert wake_at in (None, loop.obeys_at)
    loop.turn(START + 30 * MS)
    assert [value for _, value in loop.simulation.speeds] == [999.0, 1999.0]
    assert loop.commands.counts == {"taken": 2, "refused": 2, "superseded": 1996}
    assert "NaN" in loop.commands.refusals[-1] or "nan" in loop.commands.refusals[-1]
