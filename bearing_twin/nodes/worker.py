"""A thread of its own for heavy work, so that the callbacks of a node only wire."""

import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future

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
