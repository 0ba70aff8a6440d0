"""Whether somebody wants a computation to stop, told so that compiled loops see it.

While a compiled loop runs on the main thread no handler of a signal runs. So the system itself notes signals in a byte
of memory (`signal.set_wakeup_fd` with a file that lives in memory alone) at which the loops look: they end, and then
the handlers run as ever.
"""

import contextlib
import mmap
import os
import signal
import threading
from collections.abc import Callable, Iterator

import numpy as np


def _shared() -> tuple[int, np.ndarray]:
    """A file without a name and its first byte; no file where the system has none of the kind."""
    if not hasattr(os, "memfd_create"):
        return -1, np.zeros(1, np.uint8)
    file = os.memfd_create("bearing_twin_signals", os.MFD_CLOEXEC)
    os.ftruncate(file, mmap.PAGESIZE)
    os.set_blocking(file, False)
    return file, np.frombuffer(mmap.mmap(file, mmap.PAGESIZE), np.uint8)[:1]


_FILE, SIGNALLED = _shared()  # SIGNALLED (1,): not 0 once a signal with a handler has come, within `heeding_signals`


@contextlib.contextmanager
def heeding_signals() -> Iterator[None]:
    """Within it SIGNALLED tells of signals; nothing outside the main thread, where handlers do not run either."""
    if _FILE < 0 or threading.current_thread() is not threading.main_thread():
        yield
        return
    previous = signal.set_wakeup_fd(_FILE, warn_on_full_buffer=False)
    try:
        yield
    finally:
        signal.set_wakeup_fd(previous)
        os.lseek(_FILE, 0, os.SEEK_SET)
        SIGNALLED[:] = 0


class Unbroken:
    """Within it, in the main thread, handlers of signals wait for its end: an exception of theirs splits nothing.

    `watch` takes the handlers over, `release` gives them back; other threads never run any.
    """

    SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

    def __init__(self):
        self._handlers: dict[int, Callable] = {}
        self._main, self._depth, self._came = threading.main_thread().ident, 0, []

    def watch(self) -> None:
        """Handlers of this process wait from now on; those of the system, which end it at once, do not."""
        if threading.get_ident() != self._main:
            return
        for number in self.SIGNALS:
            handler = signal.getsignal(number)
            if callable(handler):
                self._handlers[number] = handler
                signal.signal(number, self._heard)

    def release(self) -> None:
        """Gives back the handlers that nobody has replaced meanwhile."""
        if threading.get_ident() != self._main:
            return
        while self._handlers:
            number, handler = self._handlers.popitem()
            if signal.getsignal(number) == self._heard:
                signal.signal(number, handler)

    def __enter__(self):
        if threading.get_ident() == self._main:
            self._depth += 1

    def __exit__(self, *_):
        if threading.get_ident() == self._main:
            self._depth -= 1
            while self._came and not self._depth:
                self._heard(self._came.pop(0), None)

    def _heard(self, number, frame) -> None:
        if self._depth:
            self._came.append(number)
        elif number in self._handlers:
            self._handlers[number](number, frame)
