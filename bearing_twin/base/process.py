"""The process: standard streams whose reader may leave, processors, garbage collection."""

import atexit
import contextlib
import gc
import io
import os
import select
import sys
from collections.abc import Callable, Iterator
from typing import NoReturn

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


def prepare() -> None:
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


def while_read(program: Callable[[], int]) -> int:
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
def to_standard_output() -> Iterator[None]:
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


def leave(code: int) -> NoReturn:
    """Ends the process, which has put everything away: Python itself would take up to a second to forget."""
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):
            stream.flush()
    os._exit(code)


def _without_reader(number: int) -> bool:
    poll = select.poll()
    poll.register(number, 0)
    return any(event & select.POLLERR for _, event in poll.poll(0))


def usable() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def one_processor() -> None:
    """Lets linear algebra use one thread, unless the environment says otherwise; call it before NumPy is imported.

    Matrices are small here: a second thread of BLAS waits actively and costs 0.2 s of processor time a command.
    """
    for library in ("OPENBLAS", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")


def seldom_collecting() -> None:
    """Lets Python look for circular garbage seldom: for an executable, whose process is its own.

    Libraries are many objects that stay; to look through them took a tenth of the time of a start.
    """
    gc.set_threshold(20_000, 20, 20)
