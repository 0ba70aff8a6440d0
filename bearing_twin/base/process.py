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
    """A file on a disk that may be full: what cannot be written is dropped. A closed pipe is reported."""

    def write(self, data):
        try:
            return super().write(data)
        except BrokenPipeError:
            raise
        except OSError:
            return len(data)


def prepare_streams() -> None:
    """Open closed standard streams on the null device, and drop messages on standard error where the disk is full.

    Otherwise a file opened later would get the number of a closed stream, and what is printed.
    """
    for number, (name, mode) in enumerate(STREAMS.items()):
        if getattr(sys, name) is None:
            null = os.open(os.devnull, os.O_RDWR)  # often that number already
            os.dup2(null, number)
            if null > max(PRINTED):
                os.close(null)
            setattr(sys, name, open(number, mode, closefd=False))  # noqa: SIM115 - for as long as the process lives
    raw = io.BufferedWriter(_Lossy(sys.stderr.fileno(), "w", closefd=False))
    sys.stderr = io.TextIOWrapper(raw, sys.stderr.encoding, "backslashreplace", line_buffering=True)


def run_while_read(program: Callable[[], int]) -> int:
    """Run a program that prints; return its exit code, or 0 where the reader of its output has closed the pipe.

    Other exceptions, SystemExit included, pass through once everything is printed.
    """
    try:
        try:
            return program()
        finally:
            sys.stdout.flush()  # here, where a closed pipe is no error
    except BrokenPipeError:
        closed = [number for number in PRINTED if _without_reader(number)]
        if not closed:
            raise
        for number in closed:  # Python flushes once more at exit
            os.dup2(os.open(os.devnull, os.O_WRONLY), number)
        return 0


@contextlib.contextmanager
def name_standard_output() -> Iterator[None]:
    """Within it an OSError without a file name, as of a full disk, names standard output; a closed pipe is none."""
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
"""Functions that `exit_process` calls with the exit code once all is printed, as they may never return."""


def exit_process(code: int) -> NoReturn:
    """End the process, which has printed everything, without the up to a second that Python's own clean-up takes."""
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
    """Limit linear algebra to one thread, unless the environment sets another number; called before NumPy's import.

    Matrices are small here: a second thread of BLAS waits actively and costs 0.2 s of processor time a command.
    """
    for library in ("OPENBLAS", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")


def relax_garbage_collection() -> None:
    """Run the collector of circular garbage seldom, for an executable.

    Imported libraries are many objects that stay; searching them took a tenth of the time of a start.
    """
    gc.set_threshold(20_000, 20, 20)


RESEND_DELAY = 0.01  # s until a signal that was dropped, or came while a module was imported, is sent again
LONGEST_IMPORT = 0.25  # s for which it may be put off
RAISED: list[int] = []  # signals of which an exception was made; one that computes on has lost it
DEFERRED: list[int] = []  # signals that are sent again, unless one of them became an exception meanwhile


@contextlib.contextmanager
def signals_as_exceptions() -> Iterator[None]:
    """Raise KeyboardInterrupt on Ctrl-C, SystemExit(128 + number) on SIGTERM and SIGHUP: open logs are closed.

    During an import libraries may catch an exception or raise another in its place: there a signal is deferred, and an
    exception that it has become all the same is reported as the signal.
    """
    received: list[float] = []

    def handle(number, frame):
        received.append(time.monotonic())
        if _is_importing(frame) and received[-1] - received[0] < LONGEST_IMPORT:
            send_again(number)
            return
        DEFERRED.clear()
        RAISED.append(number)
        raise _exception_of(number)

    def send_again(number):
        def send():
            time.sleep(RESEND_DELAY)
            if previous and number in DEFERRED:
                signal.pthread_kill(main_thread, number)

        DEFERRED.append(number)
        _thread.start_new_thread(send, ())  # not `threading`: its locks may be held by what was interrupted

    def report_dropped(unraisable):
        """Send a signal again whose exception Python drops, as in a handler that ran while garbage was collected."""
        number = signal_of(unraisable.exc_value)
        send_again(number) if number in previous else hook(unraisable)

    previous, main_thread, hook = {}, threading.main_thread().ident, sys.unraisablehook
    with contextlib.suppress(ValueError):  # not in the main thread: signals are handled elsewhere
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            handler = signal.getsignal(number)
            # Ignored under nohup, Ctrl-C in the background of a shell, too.
            if handler != signal.SIG_IGN and (number != signal.SIGINT or handler == signal.default_int_handler):
                previous[number] = signal.signal(number, handle)
    sys.unraisablehook = report_dropped
    try:
        yield
    except (BearingTwinError, OSError):
        raise
    except Exception as error:
        if not RAISED:
            raise
        raise _exception_of(RAISED[-1]) from error
    finally:
        sys.unraisablehook = hook
        while previous:
            signal.signal(*previous.popitem())
        RAISED.clear()
        DEFERRED.clear()


def _is_importing(frame) -> bool:
    """True where a module is being imported; a deferred handler has no frame."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def _exception_of(number: int) -> BaseException:
    return KeyboardInterrupt() if number == signal.SIGINT else SystemExit(128 + number)


def signal_of(error) -> int | None:
    """The signal that raised this exception; 0 or below for SystemExit by no signal, None for another exception."""
    if isinstance(error, SystemExit) and isinstance(error.code, int):
        return error.code - 128
    return signal.SIGINT if isinstance(error, KeyboardInterrupt) else None


class DeferredSignals:
    """Within it, in the main thread, handlers of signals are deferred to its end, so that none interrupts it.

    `watch` replaces the handlers, `release` restores them; other threads never run any.
    """

    SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

    def __init__(self):
        self._handlers: dict[int, Callable] = {}
        self._main, self._depth, self._deferred = threading.main_thread().ident, 0, []

    def watch(self) -> None:
        """Defer the handlers of this process from now on; those of the system end it at once."""
        if threading.get_ident() != self._main:
            return
        for number in self.SIGNALS:
            handler = signal.getsignal(number)
            if callable(handler) and handler != self._handle:
                self._handlers[number] = handler
                signal.signal(number, self._handle)

    def release(self) -> None:
        """Restore the handlers that were not replaced meanwhile."""
        if threading.get_ident() != self._main:
            return
        for number, handler in self._handlers.items():  # `_handle` reads them until all are given back
            if signal.getsignal(number) == self._handle:
                signal.signal(number, handler)
        self._handlers.clear()

    def __enter__(self):
        if threading.get_ident() == self._main:
            self._depth += 1

    def __exit__(self, *_):
        if threading.get_ident() == self._main:
            self._depth -= 1
            while self._deferred and not self._depth:
                self._handle(self._deferred.pop(0), None)

    def _handle(self, number, frame) -> None:
        if self._depth:
            self._deferred.append(number)
        elif number in self._handlers:
            self._handlers[number](number, frame)
