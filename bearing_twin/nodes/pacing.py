"""When messages are due on the wall clock, and whether a stream keeps up; all times are integers of nanoseconds.

Nothing here reads a clock or waits: `now` comes from outside, so that every case is tested without waiting for it.
"""

import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from fractions import Fraction
from typing import NamedTuple

LAG_SHOWN = 100_000_000  # ns behind at which a stream is said not to keep up
SLOWEST = 1e-9  # times real time
FASTEST = "fastest"  # the word for as fast as possible: 0 times real time would be no motion at all
GREATEST_LAG = 1_000_000_000  # ns behind at which the rest is given up instead of being caught up in one burst


class Timed(NamedTuple):
    """One serialised message and the stream time at which it is due [ns]."""

    time_ns: int
    topic: str
    cdr: bytes


class StreamPace(NamedTuple):
    """How far a stream is: its time, how long it has been running, how late it is and what it gave up, all in ns."""

    stream_ns: int
    running_ns: int
    lag_ns: int
    slipped_ns: int

    @property
    def behind(self) -> bool:
        return self.lag_ns > LAG_SHOWN

    def real_time_factor(self, earlier: "StreamPace") -> float:
        """Stream time per wall time since `earlier`, pauses left out; 0 when nothing ran."""
        running = self.running_ns - earlier.running_ns
        return (self.stream_ns - earlier.stream_ns) / running if running > 0 else 0.0


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
            raise ValueError(f"the pace must be {FASTEST} or a finite number from {SLOWEST:g} on and is {factor}")
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
    """Delivers batches of timed messages when they are due; it can be paused.

    `next_batch()` gives messages in the order they go out, or None at the end; `deliver(message)` sends one.
    `tick(time_ns)` tells the time, before what goes out at that time: of several instants that are due at once the
    last, so that who keeps few ticks misses none that counts. It goes back by `restart` alone.
    Not thread-safe: everything is called by the one thread that calls `turn`.
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
        going, asked_ns = [], None  # the time of messages that go out: those of one instant are asked for once
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


POLL = 0.005  # s


class Worker:
    """Calls `prepare()` once and then `turn(now)` whenever it asks to be called, until `stop`.

    `turn` returns the wall time of its next call [ns, monotonic] or None to wait for a command. `ended(error)` is
    called once, from the thread, with the exception that ended it or None. Commands run between turns, those posted
    during `prepare` right after it. Another `clock`, such as simulation time, is read every POLL seconds.
    """

    def __init__(
        self,
        turn: Callable[[int], int | None],
        prepare: Callable[[], None] = lambda: None,
        ended: Callable[[Exception | None], None] = lambda error: None,
        clock: Callable[[], int] = time.monotonic_ns,
    ):
        self._clock, self._poll = clock, None if clock is time.monotonic_ns else POLL
        self._turn = turn
        self._prepare = prepare
        self._ended = ended
        self._commands: queue.SimpleQueue = queue.SimpleQueue()
        self._open, self._opening = False, threading.Lock()  # whether commands are taken
        self._wake = threading.Event()
        self._stop = threading.Event()
        # A daemon: a kernel that is being compiled must not keep the process from ending.
        self._thread = threading.Thread(target=self._run, name="worker", daemon=True)

    def start(self) -> None:
        self._open = True
        self._thread.start()

    def post(self, command: Callable, *arguments) -> Future:
        """Lets the thread call `command(now, *arguments)` between two turns; the future gets what it returns."""
        future: Future = Future()
        with self._opening:  # or the last look at them may come between
            self._commands.put((future, command, arguments))
            if not self._open:
                self._refuse_commands()
        self._wake.set()
        return future

    @property
    def stopping(self) -> bool:
        """Whether the thread is to end."""
        return self._stop.is_set()

    def wake(self) -> None:
        """Has `turn` called soon, whenever it asked for."""
        self._wake.set()

    def stop(self, timeout: float) -> bool:
        """Ends the thread after the turn it is in; False if that took longer than `timeout` seconds."""
        self._stop.set()
        self._wake.set()
        if self._thread.is_alive() and threading.current_thread() is not self._thread:
            self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(self) -> None:
        error = None
        try:
            self._prepare()
            while not self._stop.is_set():
                self._obey_commands()
                wake_at = self._turn(self._clock())
                left = None if wake_at is None else max(0, wake_at - self._clock()) * 1e-9
                self._wake.wait(left if left is None or self._poll is None else min(left, self._poll))
                self._wake.clear()  # before anything is looked at, so that no word is lost
        except Exception as problem:
            error = problem
        self._stop.set()
        with self._opening:
            self._open = False
            self._refuse_commands()
        self._ended(error)

    def _obey_commands(self) -> None:
        while (taken := self._next_command()) is not None:
            future, command, arguments = taken
            if not future.set_running_or_notify_cancel():
                continue
            try:
                future.set_result(command(self._clock(), *arguments))
            except Exception as problem:
                future.set_exception(problem)

    def _refuse_commands(self) -> None:
        while (taken := self._next_command()) is not None:
            if taken[0].set_running_or_notify_cancel():
                taken[0].set_exception(RuntimeError("the node has ended its work"))

    def _next_command(self):
        try:
            return self._commands.get_nowait()
        except queue.Empty:
            return None
