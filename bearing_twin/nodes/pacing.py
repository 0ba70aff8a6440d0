"""Pace of a stream of messages on the wall clock, and the thread that keeps it; all times are integers of nanoseconds.

`PacedStream` reads no clock and does not wait: `now` comes from outside.
"""

import math
import queue
import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from contextlib import suppress
from fractions import Fraction
from typing import NamedTuple

LAG_SHOWN = 0.1  # s of lag from which on a stream does not keep up
SLOWEST = 1e-9  # times real time
FASTEST = "fastest"  # as fast as possible
ENDED = "the node has ended its work"
GREATEST_LAG = 1_000_000_000  # ns of lag, beyond which it is given up instead of being caught up in one burst


class Timed(NamedTuple):
    """One serialised message and the stream time at which it is due [ns]."""

    time_ns: int
    topic: str
    cdr: bytes


class PacedStream(ABC):
    """Timed messages, each delivered when it is due on the wall clock; the stream can be paused.

    A subclass has `next_batch()`, which gives messages in the order in which they go out, or None at the end.
    Everything but `progress` is called by the one thread that calls `turn`. `tick`, a function, publishes the time [ns]
    before the messages of that time; of several instants that are due at once the last one only. It goes back only by
    `restart`.

    Parameters
    ----------
    deliver : function
        Sends one message.
    factor : float or str
        Pace, a multiple of real time, or FASTEST. Raises ValueError for what is no pace.
    """

    def __init__(self, deliver: Callable[[Timed], None], factor: float | str):
        self.deliver, self.tick = deliver, lambda time_ns: None
        self.factor = _fraction(factor)
        self.paused = False
        self.given_up_ns = self._running = self._passed = 0
        self._pending: deque[Timed] = deque()
        self._progress = 0, 0, 0  # running, passed and given up time at the last call
        self.restart()

    @abstractmethod
    def next_batch(self) -> Iterable[Timed] | None:
        """The messages to follow, or None at the end."""

    def restart(self) -> None:
        """Discards messages computed ahead; the next message starts the pace again, at any time."""
        self._pending.clear()
        self.finished = self._started = False
        self.position_ns = self.lag_ns = 0
        self._ticked: int | None = None

    def turn(self, now: int) -> int | None:
        """Delivers what is due at `now`; returns the wall time of the next turn, None if it needs a command."""
        if self.paused or self.finished:
            return None
        if not self._pending:
            batch = self.next_batch()
            if batch is None:
                self.finished = True
                return None
            self._pending.extend(batch)
            return now  # computing it took time, so read the clock again
        if not self._started:
            self._start(now)
        if self._send(lambda time_ns: self.due(time_ns) <= now):
            self._note(now)
        return self.due(self._pending[0].time_ns) if self._pending else now

    def due(self, time_ns: int) -> int:
        """The wall time at which `time_ns` is due; as fast as possible that is always now or earlier."""
        passed = max(time_ns, self.position_ns) - self._origin_ns
        return self._origin_wall + (passed * self.factor.denominator // self.factor.numerator if self.factor else 0)

    def pause(self, now: int, paused: bool) -> str:
        """Pauses the stream, or resumes it; pausing twice has no further effect."""
        resumed, self.paused = self.paused and not paused, paused
        if resumed:
            self.resume_at(now)
        return f"{'paused' if paused else 'running'} at {self.position_ns * 1e-9:.6f} s"

    def set_factor(self, now: int, factor: float | str) -> None:
        """Changes the pace from now on; a paused stream stays paused."""
        self.factor = _fraction(factor)
        self.resume_at(now)

    def resume_at(self, now: int) -> None:
        """Continues from the position of the stream at another wall time, unless it is paused."""
        # The time of the first message is not known before it has been read: a log may begin at any.
        if not self.paused and (self._started or self._pending or self.position_ns):
            self._start(now)

    def drain(self, until_ns: int | None = None) -> None:
        """Delivers messages that were computed ahead, due or not: all, or those stamped up to `until_ns`."""
        self._send(lambda time_ns: until_ns is None or time_ns <= until_ns)
        self.position_ns = max(self.position_ns, until_ns or 0)

    def progress(self) -> dict[str, float | str]:
        """Numbers for diagnostics, from any thread: pace since the last call, without pauses (0 if nothing ran), lag.

        Lag beyond GREATEST_LAG was given up, and counts as lag until the next call.
        """
        previous, self._progress = self._progress, (self._running, self._passed, self.given_up_ns)
        running, passed, given_up = (total - before for total, before in zip(self._progress, previous, strict=True))
        return {
            "real_time_factor": passed / running if running > 0 else 0.0,
            "wanted_real_time_factor": float(self.factor) or FASTEST,
            "lag_s": max(self.lag_ns, given_up) * 1e-9,
            "given_up_s": self.given_up_ns * 1e-9,
        }

    def _start(self, now: int) -> None:
        """From now on the position is due at `now`: at the beginning, after a pause, a jump or a change of pace."""
        self._started = True
        # A message may be stamped with the start of the time it covers: the stream never goes back.
        self.position_ns = max(self.position_ns, self._pending[0].time_ns if self._pending else 0)
        self._origin_wall = self._noted_at = now
        self._origin_ns = self._noted = self.position_ns
        self.lag_ns = 0

    def _note(self, now: int) -> None:
        """Notes progress up to the position; a lag beyond GREATEST_LAG is given up."""
        self._running += now - self._noted_at
        self._passed += self.position_ns - self._noted
        self._noted_at, self._noted = now, self.position_ns
        if self.factor:
            self.lag_ns = max(0, now - self.due(self.position_ns))
            if self.lag_ns > GREATEST_LAG:
                self.given_up_ns += self.lag_ns
                self._origin_wall, self._origin_ns = now, self.position_ns

    def _send(self, goes_out: Callable[[int], bool]) -> bool:
        """Delivers messages from the first on while their times go out; returns whether one did."""
        outgoing, asked_ns = [], None  # one decision for all messages of an instant
        while self._pending:
            time_ns = self._pending[0].time_ns
            if time_ns != asked_ns and not goes_out(time_ns):
                break
            asked_ns = time_ns
            outgoing.append(self._pending.popleft())
            self.position_ns = max(self.position_ns, time_ns)
        if outgoing and self.position_ns != self._ticked:
            self._ticked = self.position_ns
            self.tick(self.position_ns)
        for message in outgoing:
            self.deliver(message)
        return bool(outgoing)


def _fraction(factor: float | str) -> Fraction:
    """The pace as a fraction, 0 for FASTEST; raises ValueError."""
    if factor == FASTEST:
        return Fraction(0)
    if not (isinstance(factor, (int, float)) and SLOWEST <= factor < float("inf")):
        raise ValueError(f"the pace must be {FASTEST} or a finite number of at least {SLOWEST:g} and is {factor}")
    return Fraction(factor).limit_denominator(round(1e3 / SLOWEST))  # an impact wants 1e-5 and less


POLL = 0.005  # s between readings of a clock that is not that of the machine


class Worker:
    """A thread that calls `prepare()` once and then `turn(now)` at the times it returns, until `stop`.

    Times [ns] are those of the `clock`, monotonic or simulation time; `turn` returns that of its next call, or None to
    wait for a command. `ended(error)` is called once, from the thread, with the exception that ended it or None.
    Commands run between turns, those posted during `prepare` right after it.
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
        self._commands: queue.SimpleQueue = queue.SimpleQueue()
        self._posting, self._closed, self.stopping = threading.Lock(), False, False
        # A daemon: a computation that takes long must not keep the process from ending.
        self._thread = threading.Thread(target=self._run, name="worker", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def post(self, command: Callable, *arguments) -> Future:
        """Has the thread call `command(now, *arguments)` between two turns; the future gets its result."""
        future: Future = Future()
        with self._posting:
            if self._closed:
                future.set_exception(RuntimeError(ENDED))
            else:
                self._commands.put((future, command, arguments))
        return future

    def wake(self) -> None:
        """Has `turn` called soon, before the time it returned."""
        self.post(lambda now: None)

    def stop(self, timeout: float) -> bool:
        """Ends the thread after the turn it is in; False if that took longer than `timeout` seconds."""
        self.stopping = True
        self.wake()
        if self._thread.is_alive() and threading.current_thread() is not self._thread:
            self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(self) -> None:
        failure, wait_s = None, 0.0
        try:
            self._prepare()
            while not self.stopping:
                with suppress(queue.Empty):
                    self._execute(*self._commands.get(timeout=min(wait_s, self._longest)))
                    while not self.stopping:
                        self._execute(*self._commands.get_nowait())
                if self.stopping:
                    break
                wake_at = self._turn(self._clock())
                wait_s = math.inf if wake_at is None else max(0, wake_at - self._clock()) * 1e-9
        except Exception as error:
            failure = error
        with self._posting:
            self.stopping = self._closed = True
        with suppress(queue.Empty):
            while True:
                future, *_ = self._commands.get_nowait()
                if future.set_running_or_notify_cancel():
                    future.set_exception(RuntimeError(ENDED))
        self._ended(failure)

    def _execute(self, future: Future, command: Callable, arguments: tuple) -> None:
        if future.set_running_or_notify_cancel():
            try:
                future.set_result(command(self._clock(), *arguments))
            except Exception as error:
                future.set_exception(error)
