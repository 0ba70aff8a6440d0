"""Ending of computations from outside, seen by all loops; signals as exceptions are in `process`.

While a compiled loop runs on the main thread no handler of a signal runs. So the system itself notes signals in a byte
of memory (`signal.set_wakeup_fd` with a file that lives in memory alone) at which the loops look: they end, and then
the handlers run as ever. Loops of Python call `stop_if_requested`.
"""

import contextlib
import ctypes
import mmap
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextvars import ContextVar

import numpy as np

from bearing_twin.base.errors import Interrupted, Stopped
from bearing_twin.base.process import DEFERRED, RAISED

INTERRUPTED, ENDED = 255, 254  # no numbers of signals
MAP_FIXED = 0x10  # of Linux, where `_FILE` is; Python does not name it
_STOP_REQUESTED: ContextVar[Callable[[], bool]] = ContextVar("stop_requested", default=lambda: False)
CREDIT, SHARE = 1.0, 0.2  # s of computing that interruptions may cost before it is earned, and what it earns a second


def _shared_flag() -> tuple[int, np.ndarray]:
    """A file in memory and its first byte; -1 for the file where the system has no such files."""
    if not hasattr(os, "memfd_create"):
        return -1, np.zeros(1, np.uint8)
    file = _memory_file()
    return file, np.frombuffer(mmap.mmap(file, 1), np.uint8)


def _memory_file() -> int:
    file = os.memfd_create("bearing_twin_signals", os.MFD_CLOEXEC)
    os.ftruncate(file, 1)  # no more than it needs: it counts as a file where those may not grow
    os.set_blocking(file, False)
    return file


def _own_after_fork() -> None:
    """After a fork: a file and byte of this process alone, as its signals would stop its parent, too."""
    file = _memory_file()
    os.dup2(file, _FILE, inheritable=False)
    os.close(file)
    replace = ctypes.CDLL(None).mmap  # Python's own chooses the place
    replace.argtypes = [ctypes.c_void_p, ctypes.c_size_t, *3 * [ctypes.c_int], ctypes.c_long]
    replace(SIGNALLED.ctypes.data, 1, mmap.PROT_READ | mmap.PROT_WRITE, mmap.MAP_SHARED | MAP_FIXED, _FILE, 0)


_FILE, SIGNALLED = _shared_flag()  # SIGNALLED (1,): not 0 once a signal with a handler has come, within `signal_flag`
if _FILE >= 0:
    os.register_at_fork(after_in_child=_own_after_fork)


@contextlib.contextmanager
def signal_flag() -> Iterator[None]:
    """Within it signals set SIGNALLED; without effect outside the main thread, where no handlers run either."""
    if _FILE < 0 or threading.current_thread() is not threading.main_thread():
        yield
        return
    if RAISED:  # the exception was swallowed on its way
        signal.raise_signal(RAISED[-1])
    previous = signal.set_wakeup_fd(_FILE, warn_on_full_buffer=False)
    try:
        yield
    except Stopped:
        if DEFERRED:  # what computes has seen the signal before its handler would run again
            signal.raise_signal(DEFERRED[-1])
        raise
    finally:
        signal.set_wakeup_fd(previous)
        os.lseek(_FILE, 0, os.SEEK_SET)
        SIGNALLED[:] = 0


@contextlib.contextmanager
def stop_condition(requested: Callable[[], bool]) -> Iterator[None]:
    """Within it, in this thread, `stop_if_requested` raises Stopped once `requested()` is true."""
    token = _STOP_REQUESTED.set(requested)
    try:
        yield
    finally:
        _STOP_REQUESTED.reset(token)


def stop_if_requested() -> None:
    """Raises Stopped once the `stop_condition` is true; long work in Python calls it ten times a second."""
    if _STOP_REQUESTED.get()():
        raise Stopped("the computation was stopped")


class Halt:
    """Stops a computation from any thread: for good by `end`, or by `interrupt` for a command.

    `flag` (1,) is read by compiled loops. An interrupted chunk is computed again, so that a flood of commands would
    prevent all progress: they may cost a share of the time, and wait once they have cost it.
    """

    def __init__(self, flag: np.ndarray | None = None):
        self.flag = np.zeros(1, np.uint8) if flag is None else flag
        self._lock, self._credit = threading.Lock(), CREDIT
        self._inside = self._open = False  # whether anything computes that could be interrupted, and that may be

    def end(self) -> None:
        """Stop the computation soon, and every later one."""
        with self._lock:
            self.flag[:] = ENDED

    def interrupt(self, always: bool = False) -> None:
        """Stop the computation within `interruptible` soon, if there is one; `always`: whatever that costs."""
        with self._lock:
            self._open = self._open or (always and self._inside)
            if self._open and not self.flag[0]:
                self.flag[:] = INTERRUPTED

    @contextlib.contextmanager
    def interruptible(self, motion) -> Iterator[None]:
        """Within it Stopped by `interrupt` becomes Interrupted, after `motion.take_back()` to the beginning.

        A motion without that cannot be interrupted.
        """
        start = time.perf_counter()
        with self._lock:
            self._inside = hasattr(motion, "take_back")
            self._open = self._inside and self._credit > 0.0
        try:
            yield
        except Stopped as error:
            if not self._end_interruptible(start, -1.0):
                raise
            motion.take_back()
            raise Interrupted("interrupted, to be computed again") from error
        finally:
            self._end_interruptible(start, SHARE)

    def _end_interruptible(self, start: float, earned: float) -> bool:
        """True after an interruption; adds `earned` for each second to the credit."""
        with self._lock:
            interrupted, self._inside, self._open = self._open and self.flag[0] == INTERRUPTED, False, False
            if interrupted:
                self.flag[:] = 0
            if interrupted or earned > 0.0:
                self._credit = min(self._credit + earned * (time.perf_counter() - start), CREDIT)
        return bool(interrupted)
