"""When messages go out: pace, pauses, lag; and the thread that does it. No ROS, and no waiting for wall clocks."""

import threading
from itertools import pairwise

import pytest
from loops import MS, START, Stream

from bearing_twin.nodes.pacing import GREATEST_LAG, LAG_SHOWN, SLOWEST, Worker


@pytest.mark.parametrize("factor", [0.5, 1.0, 2.0])
def test_every_message_goes_out_when_it_is_due(factor):
    stream = Stream([[0, 10, 10, 20], [], [30]], factor)
    stream.drive()
    assert stream.delivered() == [(ms, int(ms / factor)) for ms in (0, 10, 10, 20, 30)]
    assert stream.finished
    numbers = stream.progress()
    assert (numbers["real_time_factor"], numbers["lag_s"]) == (pytest.approx(factor), 0.0)
    assert stream.progress()["real_time_factor"] == 0.0  # nothing ran since


def test_as_fast_as_possible_waits_for_nothing_and_a_stamp_in_the_past_goes_out_at_once():
    fast = Stream([[0, 10], [20, 5000]], "fastest")
    fast.drive()
    assert [wall for _, wall in fast.delivered()] == [0] * 4
    stream = Stream([[0, 50, 1, 60]])
    stream.drive()
    assert stream.delivered() == [(0, 0), (50, 50), (1, 50), (60, 60)]
    assert stream.position_ns == 60 * MS  # time never goes back


@pytest.mark.parametrize(("factor", "walls"), [(None, (0, 10)), (2.0, (0, 5))])
def test_a_pause_stands_still_and_goes_on_where_it_was(factor, walls):
    """Also with another pace, set while it is held."""
    stream = Stream([[0, 10, 20, 30]])
    stream.drive(until_ms=15)
    stream.pause(stream.clock, True)
    assert stream.turn(stream.clock) is None
    if factor:
        stream.set_factor(stream.clock, factor)
    assert stream.position_ns == 10 * MS
    stream.clock += 5_000 * MS
    stream.pause(stream.clock, False)
    resumed = (stream.clock - START) // MS
    stream.drive()
    assert stream.delivered()[2:] == [(20, resumed + walls[0]), (30, resumed + walls[1])]
    assert 0.9 < stream.progress()["real_time_factor"] < 3.0  # a pause is no time that ran
    assert stream.lag_ns == 0


@pytest.mark.parametrize("command", ["pause", "set_factor"])
def test_a_command_before_the_first_message_leaves_the_start_to_it(command):
    """Also where times are those of a wall clock, as in the log of a recorder."""
    epoch = 1_790_000_000_000  # ms
    stream = Stream([[epoch, epoch + 10]])
    if command == "pause":
        stream.paused = True
        assert stream.turn(stream.clock) is None
        stream.clock += 100 * MS
        stream.pause(stream.clock, False)
    else:
        stream.set_factor(stream.clock, 1.0)
    resumed = (stream.clock - START) // MS
    stream.drive()
    assert [wall - resumed for _, wall in stream.delivered()] == [0, 10]
    assert stream.due((epoch + 86_400_000) * MS + 1) == START + (resumed + 86_400_000) * MS + 1  # to the nanosecond


def test_a_late_stream_reports_its_lag_catches_up_and_gives_up_what_is_hopeless():
    stream = Stream([[0, 10], [20, 30], [40], [50], [60]])
    stream.drive(until_ms=10)
    stream.clock = START + 320 * MS  # computing the second batch took long
    stream.turn(stream.clock)
    stream.turn(stream.clock)
    assert len(stream.delivered()) == 4
    assert stream.lag_ns == 290 * MS > LAG_SHOWN * 1e9
    assert stream.progress()["real_time_factor"] < 0.1
    for turn in (1, 2):  # what was given up adds up
        stream.clock += 2 * GREATEST_LAG
        stream.turn(stream.clock)
        stream.turn(stream.clock)
        assert stream.lag_ns > GREATEST_LAG
        assert stream.due(60 * MS) == stream.clock + (30 - 10 * turn) * MS
    assert 4 * GREATEST_LAG < stream.given_up_ns < 4 * GREATEST_LAG + 320 * MS
    stream.drive()  # the last message is in time again
    assert stream.lag_ns == 0
    assert stream.progress()["lag_s"] > 2e-9 * GREATEST_LAG
    assert stream.progress()["lag_s"] == 0.0


def test_what_was_computed_ahead_goes_out_up_to_and_with_the_time_asked_for():
    stream = Stream([[0, 10, 20, 20, 30]])
    stream.turn(stream.clock)
    for until, position, times in ((20, 20, [0, 10, 20, 20]), (25, 25, [0, 10, 20, 20]), (22, 25, [0, 10, 20, 20])):
        stream.drain(until * MS)
        assert stream.position_ns == position * MS
        assert [time for time, _ in stream.delivered()] == times
    stream.drain()
    assert stream.position_ns == 30 * MS


def test_a_change_of_pace_at_a_stamp_from_the_past_does_not_turn_time_back():
    stream = Stream([[0, 50], [20, 60]])
    stream.drive(until_ms=49)
    stream.clock = START + 50 * MS
    stream.turn(stream.clock)
    stream.turn(stream.clock)  # computes the second batch, and sends nothing yet
    assert len(stream.delivered()) == 2
    stream.set_factor(stream.clock, 2.0)
    assert stream.position_ns == 50 * MS
    stream.drive()
    assert stream.delivered() == [(0, 0), (50, 50), (20, 50), (60, 55)]


def test_each_instant_ticks_before_its_messages_and_of_late_ones_the_last_alone():
    stream = Stream([[0, 10, 10, 20]])
    stream.drive()
    assert stream.delivered("tick") == [(ms, ms) for ms in (0, 10, 20)]
    assert [kind for _, kind, _ in stream.seen] == ["tick", "topic", "tick", "topic", "topic", "tick", "topic"]
    delayed = Stream([[0, *range(1, 60), 7, 60]])
    delayed.turn(delayed.clock)
    delayed.turn(delayed.clock)
    delayed.clock += 50 * MS  # nobody looked
    delayed.drive()
    assert delayed.delivered("tick") == [(0, 0), (50, 50), *((ms, ms) for ms in range(51, 61))]
    assert [time for time, _ in delayed.delivered()] == [0, *range(1, 60), 7, 60]
    again = Stream([[0, 10], [0, 10]])
    again.drive(until_ms=9)
    again.restart()
    again.drive()
    assert [time for time, _ in again.delivered("tick")] == [0, 0, 10]


def test_the_slowest_pace_is_slow_and_an_impossible_one_is_refused():
    for factor in (1e-7, SLOWEST):
        stream = Stream([[0]], factor)
        stream.drive()
        assert stream.due(1000) - START == pytest.approx(1000 / factor, rel=1e-6)
    for factor in (0.0, -1.0, "slow", 1e-10, 5e-324, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="pace must be fastest or a finite number"):
            Stream([], factor)


def test_commands_run_between_turns_and_answer():
    turns = []
    worker = Worker(turns.append)
    worker.start()
    assert worker.post(lambda now, value: (value, threading.current_thread().name), 7).result(30.0) == (7, "worker")
    with pytest.raises(ZeroDivisionError):
        worker.post(lambda now: 1 / 0).result(30.0)
    assert worker.stop(300.0)
    assert len(turns) >= 2
    with pytest.raises(RuntimeError, match="ended its work"):
        worker.post(lambda now: None).result(30.0)


def test_the_error_that_ends_the_thread_is_told_once_and_a_command_meanwhile_is_refused():
    errors, futures, posted = [], [], threading.Event()

    def ended(error):
        errors.append(error)
        futures.append(worker.post(lambda now: None))
        posted.set()

    worker = Worker(lambda now: 1 / 0, ended=ended)
    worker.start()
    assert posted.wait(300.0)
    assert worker.stop(300.0)
    assert list(map(type, errors)) == [ZeroDivisionError]
    with pytest.raises(RuntimeError, match="ended its work"):
        futures[0].result(0.0)


def test_the_worker_keeps_to_the_clock():
    wall, enough = [], threading.Event()

    def turn(now):
        wall.append(now)
        if len(wall) == 4:
            enough.set()
        return now + 20 * MS

    worker = Worker(turn)
    worker.start()
    assert enough.wait(300.0)
    assert worker.stop(300.0)
    assert min((b - a) / MS for a, b in pairwise(wall)) >= 20.0
