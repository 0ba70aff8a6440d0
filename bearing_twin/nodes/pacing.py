"""Pace of a stream of messages on the wall clock, and the thread that keeps it; all times are integers of nanoseconds.

`Pacer` and `PacedStream` read no clock and do not wait: `now` comes from outside.
"""

import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from fractions import Fraction
from typing import NamedTuple

LAG_SHOWN = 100_000_000  # ns of lag from which on a stream does not keep up
SLOWEST = 1e-9  # times real time
FASTEST = "fastest"  # as fast as possible
ENDED = "the node has ended its work"
GREATEST_LAG = 1_000_000_000  # ns behind at which the rest is given up instead of being caught up in one burst


class Timed(NamedTuple):
    """One serialised message and the stream time at which it is due [ns]."""

    time_ns: int
    topic: str
    cdr: bytes


class StreamPace(NamedTuple):
    """Progress of a stream: its time, running time, lag, and the lag that was given up, all in ns."""

    stream_ns: int
    running_ns: int
    lag_ns: int
    slipped_ns: int

    @property
    def behind(self) -> bool:
        return self.lag_ns > LAG_SHOWN

    def real_time_factor(self, earlier: "StreamPace") -> float:
        """Stream time per wall time since `earlier`, without pauses; 0 when nothing ran."""
        running = self.running_ns - earlier.running_ns
        return (self.stream_ns - earlier.stream_ns) / running if running > 0 else 0.0

    def numbers(self, earlier: "StreamPace", requested: float) -> dict[str, float | str]:
        """Numbers for diagnostics of a `requested` pace, 0 for FASTEST."""
        return {
            "real_time_factor": self.real_time_factor(earlier),
            "wanted_real_time_factor": requested or FASTEST,
            "lag_s": self.lag_ns * 1e-9,
            "given_up_s": self.slipped_ns * 1e-9,
        }


class Pacer:
    """The line that stream time follows on the wall clock: `factor` times real time, or FASTEST, which has no line.

    `factor` is then 0.
    """

    def __init__(self, factor: float | str):
        self.set_factor(factor)
        self._wall = self._mark = 0
        self._stream = self._reached = 0
        self._running = self._passed = self._lag = self._slipped = 0

    def set_factor(self, factor: float | str) -> None:
        """Changes the pace; call `start` afterwards. Raises ValueError for what is no pace."""
        if factor != FASTEST and not (isinstance(factor, (int, float)) and SLOWEST <= factor < float("inf")):
            raise ValueError(f"the pace must be {FASTEST} or a finite number of at least {SLOWEST:g} and is {factor}")
        share = Fraction(0 if factor == FASTEST else factor)
        self.factor = share.limit_denominator(round(1e3 / SLOWEST))  # an impact wants 1e-5 and less

    def start(self, now: int, stream_ns: int) -> None:
        """From now on `stream_ns` is due at `now`: at the beginning, after a pause, a jump or a change of pace."""
        self._wall = self._mark = now
        self._stream = self._reached = stream_ns
        self._lag = 0

    def due(self, stream_ns: int) -> int:
        """The wall time at which `stream_ns` is due; without a pace that is always now or earlier."""
        if not self.factor:
            return self._wall
        return self._wall + (stream_ns - self._stream) * self.factor.denominator // self.factor.numerator

    def delivered(self, now: int, stream_ns: int) -> None:
        """Notes that the stream has reached `stream_ns`; one more than GREATEST_LAG late starts afresh from here."""
        self._running += now - self._mark
        self._passed += stream_ns - self._reached
        self._mark, self._reached = now, stream_ns
        if self.factor:
            self._lag = max(0, now - self.due(stream_ns))
            if self._lag > GREATEST_LAG:
                self._slipped += self._lag
                self._wall, self._stream = now, stream_ns

    def pace(self) -> StreamPace:
        """Totals since the beginning and the lag of the last delivery."""
        return StreamPace(self._passed, self._running, self._lag, self._slipped)


class PacedStream:
    """Batches of timed messages, delivered when they are due; the stream can be paused.

    Not thread-safe: everything is called by the one thread that calls `turn`.

    Parameters
    ----------
    next_batch : function
        Gives messages in the order in which they go out, or None at the end.
    deliver : function
        Sends one message.
    pacer : Pacer
    tick : function
        Publishes the time [ns] before the messages of that time; of several instants that are due at once the last
        one only. It goes back by `restart` alone.
    """

    def __init__(
        self,
        next_batch: Callable[[], Iterable[Timed] | None],
        deliver: Callable[[Timed], None],
        pacer: Pacer,
        tick: Callable[[int], None] = lambda time_ns: None,
    ):
        self.next_batch = next_batch
        self.deliver = deliver
        self.pacer = pacer
        self.tick = tick
        self.paused = False
        self.finished = False
        self.position_ns = 0
        self._pending: deque[Timed] = deque()
        self._started = False
        self._ticked: int | None = None

    def turn(self, now: int) -> int | None:
        """Does what is due at `now`; returns the wall time of the next turn, None when only a command can go on."""
        if self.paused or self.finished:
            return None
        if not self._pending:
            batch = self.next_batch()
            if batch is None:
                self.finished = True
                return None
            self._pending.extend(batch)
            return now  # computing it took time, so look at the clock again
        if not self._started:
            self._start(now)
        if self._send(lambda message: self._due(message) <= now):
            self.pacer.delivered(now, self.position_ns)
        return self._due(self._pending[0]) if self._pending else now

    def pause(self, now: int, paused: bool) -> None:
        """Holds the stream, or goes on where it was held."""
        if self.paused and not paused:
            self._go_on(now)
        self.paused = paused

    def set_factor(self, now: int, factor: float | str) -> None:
        """Changes the pace from here on; a stream that is held stays where it is."""
        self.pacer.set_factor(factor)
        if not self.paused:
            self._go_on(now)

    def resume_at(self, now: int) -> None:
        """Goes on from where the stream is, at another wall time."""
        if not self.paused:
            self._go_on(now)

    def put(self, batch: Iterable[Timed]) -> None:
        """Adds messages behind those computed ahead."""
        self._pending.extend(batch)

    def drain(self, until_ns: int | None = None) -> None:
        """Delivers what was computed ahead, due or not: all of it, or what is stamped up to `until_ns`."""
        self._send(lambda message: until_ns is None or message.time_ns <= until_ns)
        if until_ns is not None:
            self.position_ns = max(self.position_ns, until_ns)

    def restart(self) -> None:
        """Forgets what was computed ahead; the next message starts the pace again, at whatever time it carries."""
        self._pending.clear()
        self._started = False
        self.finished = False
        self.position_ns = 0
        self._ticked = None

    def _go_on(self, now: int) -> None:
        # Before the first message is known, its time is not: a log may begin at any.
        if self._started or self._pending or self.position_ns:
            self._start(now)

    def _start(self, now: int) -> None:
        self._started = True
        first = self._pending[0].time_ns if self._pending else self.position_ns
        # A message may be stamped with the start of the time it covers: the stream never goes back.
        self.position_ns = max(self.position_ns, first)
        self.pacer.start(now, self.position_ns)

    def _due(self, message: Timed) -> int:
        return self.pacer.due(max(message.time_ns, self.position_ns))

    def _send(self, goes_out: Callable[[Timed], bool]) -> bool:
        """Delivers messages from the first on while they go out; returns whether one did."""
        going, asked_ns = [], None  # one decision for all messages of an instant
        while self._pending:
            time_ns = self._pending[0].time_ns
            if time_ns != asked_ns and not goes_out(self._pending[0]):
                break
            asked_ns = time_ns
            going.append(self._pending.popleft())
            self.position_ns = max(self.position_ns, time_ns)
        if going and self.position_ns != self._ticked:
            self._ticked = self.position_ns
            self.tick(self.position_ns)
        for message in going:
            self.deliver(message)
        return bool(going)


POLL = 0.005  # s between looks at a clock that is not that of the machine


class Worker:
    """A thread that calls `prepare()` once and then `turn(now)` at the times it returns, until `stop`.

    `turn` returns the time of its next call [ns] by `clock` (monotonic by default, or simulation time), or None to wait
    for a command. `ended(error)` is called once, from the thread, with the exception that ended it or None. Commands
    run between turns, those posted during `prepare` right after it.
    """

    def __init__(
        self,
        turn: Callable[[int], int | None],
        prepare: Callable[[], None] = lambda: None,
        ended: Callable[[Exception | None], None] = lambda error: None,
        clock: Callable[[], int] = time.monotonic_ns,
    ):
        self._turn, self._prepare, self._ended, self._clock = turn, prepare, ended, clock
        self._longest = threading.TIMEOUT_MAX if clock is time.monotonic_ns else POLL
        self._changed = threading.Condition()
        self._commands: deque = deque()
        self._woken = self._closed = self.stopping = False
        # A daemon: a computation that takes long must not keep the process from ending.
        self._thread = threading.Thread(target=self._run, name="worker", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def post(self, command: Callable, *arguments) -> Future:
        """Has the thread call `command(now, *arguments)` between two turns; the future gets what it returns."""
        future: Future = Future()
        with self._changed:
            if self._closed:
                future.set_exception(RuntimeError(ENDED))
            else:
                self._commands.append((future, command, arguments))
        self.wake()
        return future

    def wake(self) -> None:
        """Has `turn` called soon, before the time it returned."""
        with self._changed:
            self._woken = True
            self._changed.notify()

    def stop(self, timeout: float) -> bool:
        """Ends the thread after the turn it is in; False if that took longer than `timeout` seconds."""
        self.stopping = True
        self.wake()
        if self._thread.is_alive() and threading.current_thread() is not self._thread:
            self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(self) -> None:
        failure = None
        try:
            self._prepare()
            while not self.stopping:
                while self._commands:
                    self._obey(*self._commands.popleft())
                wake_at = self._turn(self._clock())
                left = self._longest if wake_at is None else max(0, wake_at - self._clock()) * 1e-9
                with self._changed:
                    if not self._woken:
                        self._changed.wait(min(left, self._longest))
                    self._woken = False
        except Exception as error:
            failure = error
        with self._changed:
            self.stopping = self._closed = True
        for future, *_ in self._commands:
            if future.set_running_or_notify_cancel():
                future.set_exception(RuntimeError(ENDED))
        self._ended(failure)

    def _obey(self, future: Future, command: Callable, arguments: tuple) -> None:
        if future.set_running_or_notify_cancel():
            try:
                future.set_result(command(self._clock(), *arguments))
            except Exception as error:
                future.set_exception(error)
