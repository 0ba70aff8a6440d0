"""Signals that end an executable: as exceptions that nothing swallows and that split nothing."""

import _thread
import contextlib
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator

from bearing_twin.base.errors import BearingTwinError

AGAIN = 0.01  # s until a signal that was dropped, or came while a module was imported, is sent again
LONGEST_IMPORT = 0.25  # s for which it may be put off
RAISED: list[int] = []  # signals of which an exception was made; one that computes on has lost it
PUT_OFF: list[int] = []  # signals that are sent again, unless one of them became an exception meanwhile


@contextlib.contextmanager
def ended_by_signals() -> Iterator[None]:
    """Ctrl-C is KeyboardInterrupt, SIGTERM and SIGHUP SystemExit with 128 + number: a log being written is closed.

    An exception within an import can become any other, which libraries catch or pass on as theirs: there a signal
    waits, and what it has become in spite of that is reported as the signal it was.
    """
    began: list[float] = []

    def leave(number, frame):
        began.append(time.monotonic())
        if _importing(frame) and began[-1] - began[0] < LONGEST_IMPORT:
            again(number)
            return
        PUT_OFF.clear()
        RAISED.append(number)
        raise _ending(number)

    def again(number):
        def send():
            time.sleep(AGAIN)
            if previous and number in PUT_OFF:
                signal.pthread_kill(main_thread, number)

        PUT_OFF.append(number)
        _thread.start_new_thread(send, ())  # not `threading`: its locks may be held by what was interrupted

    def dropped(one):
        """Sends a signal again whose exception Python drops, as where its handler ran while garbage was collected."""
        number = signal_of(one.exc_value)
        again(number) if number in previous else hook(one)

    previous, main_thread, hook = {}, threading.main_thread().ident, sys.unraisablehook
    with contextlib.suppress(ValueError):  # not in the main thread: signals are somebody else's business
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            handler = signal.getsignal(number)
            # Ignored under nohup, Ctrl-C in the background of a shell, too.
            if handler != signal.SIG_IGN and (number != signal.SIGINT or handler == signal.default_int_handler):
                previous[number] = signal.signal(number, leave)
    sys.unraisablehook = dropped
    try:
        yield
    except (BearingTwinError, OSError):
        raise
    except Exception as error:
        if not RAISED:
            raise
        raise _ending(RAISED[-1]) from error
    finally:
        sys.unraisablehook = hook
        while previous:
            signal.signal(*previous.popitem())
        RAISED.clear()
        PUT_OFF.clear()


def _importing(frame) -> bool:
    """True where a module is being imported; a handler that was put off knows no frame, and nothing is."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def _ending(number: int) -> BaseException:
    return KeyboardInterrupt() if number == signal.SIGINT else SystemExit(128 + number)


def signal_of(error) -> int | None:
    """The signal that became this exception; 0 or below where none did, None where it is another exception."""
    if isinstance(error, SystemExit) and isinstance(error.code, int):
        return error.code - 128
    return signal.SIGINT if isinstance(error, KeyboardInterrupt) else None


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
            if callable(handler) and handler != self._heard:
                self._handlers[number] = handler
                signal.signal(number, self._heard)

    def release(self) -> None:
        """Gives back the handlers that nobody has replaced meanwhile."""
        if threading.get_ident() != self._main:
            return
        for number, handler in self._handlers.items():  # which are known to `_heard` until none is left to it
            if signal.getsignal(number) == self._heard:
                signal.signal(number, handler)
        self._handlers.clear()

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
