"""What is printed may go to a reader that leaves before the end, such as `head`: no error, and nothing more to say."""

import atexit
import contextlib
import os
import select
import sys
from collections.abc import Callable
from typing import NoReturn

PRINTED = 1, 2  # standard output and standard error


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
