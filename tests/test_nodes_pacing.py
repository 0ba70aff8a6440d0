"""When messages go out: pace, pauses, lag; and the thread that does it. No ROS, and no waiting for wall clocks."""

import threading
from itertools import pairwise

import pytest

from bearing_twin.nodes.pacing import GREATEST_LAG, SLOWEST, PacedStream, Pacer, StreamPace, Timed, Worker

MS = 1_000_000
START = 77_000_000_000  # wall time, anything but 0


def timed(ms):
    return Timed(ms * MS, "topic", b"")


def paced(batches, factor=1.0):
    """A stream over batches of times in ms, and the list of (time, wall) it delivers; `wall` is set by `drive`."""
    delivered, clock = [], [START]
    source = iter([[timed(ms) for ms in batch] for batch in batches])
    stream = PacedStream(
        lambda: next(source, None), lambda message: delivered.append((message.time_ns, clock[0])), Pacer(factor)
    )
    return stream, delivered, clock


def drive(stream, clock, until=None):
    """Calls `turn` at exactly the times it asks for, until it asks for none or `until`."""
    while True:
        wake_at = stream.turn(clock[0])
        if wake_at is None or (until is not None and wake_at > until):
            return
        clock[0] = max(clock[0], wake_at)


@pytest.mark.parametrize("factor", [0.5, 1.0, 3.0])
def test_every_message_goes_out_when_it_is_due(factor):
    stream, delivered, clock = paced([[0, 10, 10, 20], [], [30]], factor)
    drive(stream, clock)
    assert [(t, wall - START) for t, wall in delivered] == [
        (ms * MS, int(ms * MS / factor)) for ms in (0, 10, 10, 20, 30)
    ]
    assert stream.finished
    assert stream.pacer.pace().lag_ns == 0
    assert stream.pacer.pace().real_time_factor(StreamPace(0, 0, 0, 0)) == pytest.approx(factor)


def test_as_fast_as_possible_waits_for_nothing():
    stream, delivered, clock = paced([[0, 10], [20, 5000]], factor="fastest")
    drive(stream, clock)
    assert [wall for _, wall in delivered] == [START] * 4


def test_a_stamp_in_the_past_goes_out_at_once_and_time_never_goes_back():
    stream, delivered, clock = paced([[0, 50, 1, 60]])
    drive(stream, clock)
    assert [(t // MS, (wall - START) // MS) for t, wall in delivered] == [(0, 0), (50, 50), (1, 50), (60, 60)]
    assert stream.position_ns == 60 * MS


def test_a_pause_stands_still_and_goes_on_where_it_was():
    stream, delivered, clock = paced([[0, 10, 20, 30]])
    drive(stream, clock, until=START + 15 * MS)
    stream.pause(clock[0], True)
    assert stream.turn(clock[0]) is None
    clock[0] += 5_000 * MS
    stream.pause(clock[0], False)
    resumed = clock[0]
    drive(stream, clock)
    assert [t // MS for t, _ in delivered] == [0, 10, 20, 30]
    assert [(wall - resumed) // MS for _, wall in delivered[2:]] == [0, 10]
    assert stream.pacer.pace().running_ns < 100 * MS
    assert stream.pacer.pace().lag_ns == 0


def test_a_change_of_pace_while_it_is_held_moves_nothing():
    stream, delivered, clock = paced([[0, 10, 20, 30]])
    drive(stream, clock, until=START + 15 * MS)
    stream.pause(clock[0], True)
    stream.set_factor(clock[0], 2.0)
    assert stream.position_ns == 10 * MS
    clock[0] += 100 * MS
    stream.pause(clock[0], False)
    resumed = clock[0]
    drive(stream, clock)
    assert [(wall - resumed) // MS for _, wall in delivered[2:]] == [0, 5]


@pytest.mark.parametrize("command", ["pause", "set_factor"])
def test_a_command_before_the_first_message_leaves_the_start_to_it(command):
    """Also where times are those of a wall clock, as in the log of a recorder."""
    epoch = 1_790_000_000_000  # ms
    stream, delivered, clock = paced([[epoch, epoch + 10]])
    if command == "pause":
        stream.paused = True
        assert stream.turn(clock[0]) is None
        clock[0] += 100 * MS
        stream.pause(clock[0], False)
    else:
        stream.set_factor(clock[0], 1.0)
    resumed = clock[0]
    drive(stream, clock, until=resumed + 50 * MS)
    assert [(wall - resumed) // MS for _, wall in delivered] == [0, 10]


def test_a_late_stream_says_how_late_it_is_and_catches_up():
    stream, delivered, clock = paced([[0, 10], [20, 30]])
    drive(stream, clock, until=START + 10 * MS)
    clock[0] = START + 320 * MS  # computing the second batch took long
    stream.turn(clock[0])
    stream.turn(clock[0])
    pace = stream.pacer.pace()
    assert len(delivered) == 4
    assert pace.lag_ns == 290 * MS
    assert pace.behind
    assert pace.slipped_ns == 0
    assert pace.real_time_factor(StreamPace(0, 0, 0, 0)) < 0.1


def test_a_hopelessly_late_stream_gives_up_the_lag_and_counts_it():
    pacer = Pacer(1.0)
    pacer.start(START, 0)
    pacer.delivered(START + GREATEST_LAG + 20 * MS, 10 * MS)
    pace = pacer.pace()
    assert pace.slipped_ns == pace.lag_ns == GREATEST_LAG + 10 * MS
    assert pacer.due(20 * MS) == START + GREATEST_LAG + 30 * MS
    pacer.delivered(START + 3 * GREATEST_LAG, 40 * MS)  # late a second time: what was given up adds up
    again = pacer.pace()
    assert again.lag_ns == 2 * GREATEST_LAG - 50 * MS
    assert again.slipped_ns == pace.slipped_ns + again.lag_ns


def test_what_was_computed_ahead_goes_out_up_to_and_with_the_time_asked_for():
    stream, delivered, clock = paced([[0, 10, 20, 20, 30]])
    stream.turn(clock[0])
    stream.drain(20 * MS)
    assert [t // MS for t, _ in delivered] == [0, 10, 20, 20]
    assert stream.position_ns == 20 * MS
    stream.drain(25 * MS)
    assert stream.position_ns == 25 * MS
    stream.drain(22 * MS)  # a time that has passed already
    assert stream.position_ns == 25 * MS
    stream.drain()
    assert [t // MS for t, _ in delivered] == [0, 10, 20, 20, 30]
    assert stream.position_ns == 30 * MS


def test_a_change_of_pace_at_a_stamp_from_the_past_does_not_turn_time_back():
    stream, delivered, clock = paced([[0, 50], [20, 60]])
    stream.turn(clock[0])
    drive(stream, clock, until=START + 49 * MS)
    clock[0] = START + 50 * MS
    stream.turn(clock[0])
    stream.turn(clock[0])  # computes the second batch, and sends nothing yet
    assert len(delivered) == 2
    stream.set_factor(clock[0], 2.0)
    assert stream.position_ns == 50 * MS
    drive(stream, clock)
    assert [(t // MS, (wall - START) // MS) for t, wall in delivered] == [(0, 0), (50, 50), (20, 50), (60, 55)]


def test_epoch_times_are_paced_to_the_nanosecond():
    first = 1_795_232_904_321_441_855
    pacer = Pacer(1.0)
    pacer.start(START, first)
    assert pacer.due(first + 86_400 * 1_000 * MS + 1) == START + 86_400 * 1_000 * MS + 1


@pytest.mark.parametrize("factor", [1e-7, SLOWEST])
def test_the_slowest_pace_is_slow(factor):
    pacer = Pacer(factor)
    pacer.start(START, 0)
    assert pacer.due(1000) - START == pytest.approx(1000 / factor, rel=1e-6)


@pytest.mark.parametrize("factor", [0.0, -1.0, "slow", 1e-10, 5e-324, float("nan"), float("inf")])
def test_an_impossible_pace_is_refused(factor):
    with pytest.raises(ValueError, match="pace must be fastest or a finite number"):
        Pacer(factor)


def test_commands_run_between_turns_and_answer():
    turns = []

    def turn(now):
        turns.append(now)

    worker = Worker(turn)
    worker.start()
    assert worker.post(lambda now, value: (value, threading.current_thread().name), 7).result(5.0) == (7, "worker")
    with pytest.raises(ZeroDivisionError):
        worker.post(lambda now: 1 / 0).result(5.0)
    assert worker.stop(300.0)
    assert len(turns) >= 2
    with pytest.raises(RuntimeError, match="ended its work"):
        worker.post(lambda now: None).result(5.0)


def test_the_error_that_ends_the_thread_is_told_once():
    ended = []

    def turn(now):
        raise OSError("disk full")

    worker = Worker(turn, ended=ended.append)
    worker.start()
    worker.stop(300.0)
    assert [str(error) for error in ended] == ["disk full"]


def test_a_command_that_comes_while_the_thread_ends_is_refused_and_not_left():
    late, posted = [], threading.Event()

    def ended(error):
        late.append(worker.post(lambda now: None))
        posted.set()

    worker = Worker(lambda now: 1 / 0, ended=ended)
    worker.start()
    assert posted.wait(300.0)
    with pytest.raises(RuntimeError, match="ended its work"):
        late[0].result(0.0)


def test_the_worker_keeps_to_the_clock():
    wall, enough = [], threading.Event()

    def turn(now):
        wall.append(now)
        if len(wall) == 8:
            enough.set()
        return now + 20 * MS

    worker = Worker(turn)
    worker.start()
    assert enough.wait(300.0)
    assert worker.stop(300.0)
    assert min((b - a) / MS for a, b in pairwise(wall)) >= 20.0


def ticking(batches, factor=1.0):
    """As `paced`, with what it ticks and delivers in one list: wall [ms since the start], "tick" or topic, time."""
    stream, _, clock = paced(batches, factor)
    seen = []
    stream.tick = lambda time_ns: seen.append(((clock[0] - START) // MS, "tick", time_ns // MS))
    stream.deliver = lambda message: seen.append(((clock[0] - START) // MS, message.topic, message.time_ns // MS))
    return stream, seen, clock


def test_each_instant_ticks_before_its_messages():
    stream, seen, clock = ticking([[0, 10, 10, 20]])
    drive(stream, clock)
    assert [one for one in seen if one[1] == "tick"] == [(ms, "tick", ms) for ms in (0, 10, 20)]
    assert [one[1] for one in seen] == ["tick", "topic", "tick", "topic", "topic", "tick", "topic"]


def test_of_instants_that_are_late_the_last_ticks_alone_and_time_never_goes_back():
    stream, seen, clock = ticking([[0, *range(1, 60), 7, 60]])
    stream.turn(clock[0])
    stream.turn(clock[0])
    clock[0] += 50 * MS  # nobody looked
    drive(stream, clock)
    ticks = [(wall, time) for wall, word, time in seen if word == "tick"]
    assert ticks == [(0, 0), (50, 50), *((ms, ms) for ms in range(51, 61))]
    assert [time for _, word, time in seen if word == "topic"] == [0, *range(1, 60), 7, 60]
    assert seen[2] == (50, "tick", 50)


def test_a_stream_that_restarts_ticks_from_its_beginning():
    stream, seen, clock = ticking([[0, 10], [0, 10]])
    drive(stream, clock, until=START + 9 * MS)
    stream.restart()
    drive(stream, clock)
    assert [time for _, word, time in seen if word == "tick"] == [0, 0, 10]
