"""The process: standard streams whose reader may leave, processors, garbage collection, signals as exceptions."""

import _thread
import atexit
import contextlib
import gc
import io
import os
import select
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import NoReturn

from bearing_twin.base.errors import BearingTwinError

STREAMS = {"stdin": "r", "stdout": "w", "stderr": "w"}  # in the order of their numbers
PRINTED = 1, 2  # standard output and standard error


class _Lossy(io.FileIO):
    """A file on a disk that may be full: what does not go into it is left out. A reader that left is reported."""

    def write(self, data):
        try:
            return super().write(data)
        except BrokenPipeError:
            raise
        except OSError:
            return len(data)


def prepare_streams() -> None:
    """Streams that whoever began this has closed lead nowhere, and words on standard error end nothing on a full disk.

    Without that a file opened later would get the number of the closed stream, and what is printed.
    """
    for number, (name, mode) in enumerate(STREAMS.items()):
        if getattr(sys, name) is None:
            nowhere = os.open(os.devnull, os.O_RDWR)  # often that number already
            os.dup2(nowhere, number)
            if nowhere > max(PRINTED):
                os.close(nowhere)
            setattr(sys, name, open(number, mode, closefd=False))  # noqa: SIM115 - for as long as the process lives
    raw = io.BufferedWriter(_Lossy(sys.stderr.fileno(), "w", closefd=False))
    sys.stderr = io.TextIOWrapper(raw, sys.stderr.encoding, "backslashreplace", line_buffering=True)


def run_while_read(program: Callable[[], int]) -> int:
    """Runs a program that prints; returns its exit code, or 0 where what it prints has no reader any more.

    All else that it raises passes through, SystemExit too, once everything is printed.
    """
    try:
        try:
            return program()
        finally:
            sys.stdout.flush()  # here, where a reader that went away is no error
    except BrokenPipeError:
        gone = [number for number in PRINTED if _without_reader(number)]
        if not gone:
            raise
        for number in gone:  # Python flushes once more at exit
            os.dup2(os.open(os.devnull, os.O_WRONLY), number)
        return 0


@contextlib.contextmanager
def name_standard_output() -> Iterator[None]:
    """Within it an OSError of no file, as of a full disk, is one of standard output; a reader that left is none."""
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        if not error.filename:
            error.filename = "standard output"
            os.dup2(os.open(os.devnull, os.O_WRONLY), PRINTED[0])  # what is still buffered finds no room either
        raise


AT_END: list[Callable[[int], None]] = []
"""What `exit_process` calls with the exit code: what must wait until all is printed, as it may never return."""


def exit_process(code: int) -> NoReturn:
    """Ends the process, which has printed everything: Python itself would take up to a second to forget."""
    with contextlib.suppress(KeyboardInterrupt):
        for end in AT_END:
            end(code)
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):
            stream.flush()
    os._exit(code)


def _without_reader(number: int) -> bool:
    poll = select.poll()
    poll.register(number, 0)
    return any(event & select.POLLERR for _, event in poll.poll(0))


def processor_count() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def limit_blas_threads() -> None:
    """Lets linear algebra use one thread, unless the environment says otherwise; call it before NumPy is imported.

    Matrices are small here: a second thread of BLAS waits actively and costs 0.2 s of processor time a command.
    """
    for library in ("OPENBLAS", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")


def relax_garbage_collection() -> None:
    """Lets Python look for circular garbage seldom: for an executable, whose process is its own.

    Libraries are many objects that stay; to look through them took a tenth of the time of a start.
    """
    gc.set_threshold(20_000, 20, 20)


AGAIN = 0.01  # s until a signal that was dropped, or came while a module was imported, is sent again
LONGEST_IMPORT = 0.25  # s for which it may be put off
RAISED: list[int] = []  # signals of which an exception was made; one that computes on has lost it
DEFERRED: list[int] = []  # signals that are sent again, unless one of them became an exception meanwhile


@contextlib.contextmanager
def signals_as_exceptions() -> Iterator[None]:
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
        DEFERRED.clear()
        RAISED.append(number)
        raise _ending(number)

    def again(number):
        def send():
            time.sleep(AGAIN)
            if previous and number in DEFERRED:
                signal.pthread_kill(main_thread, number)

        DEFERRED.append(number)
        _thread.start_new_thread(send, ())  # not `threading`: its locks may be held by what was interrupted

    def dropped(one):
        """Sends a signal again whose exception Python drops, as where its handler ran while garbage was collected."""
        number = signal_of(one.exc_value)
        again(number) if number in previous else hook(one)

    previous, main_thread, hook = {}, threading.main_thread().ident, sys.unraisablehook
    with contextlib.suppress(ValueError):  # not in the main thread: signals are handled elsewhere
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
        DEFERRED.clear()


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


class DeferredSignals:
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
