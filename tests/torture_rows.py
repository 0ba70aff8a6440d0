"""Results of a row of `make torture`, and functions of several rows."""

import mmap
import os
import resource
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import processes  # noqa: F401 - what forks do not collect


class Row(NamedTuple):
    """One torture: its name, what it does, and the function (share, folder) -> Found; `share` 1 is all of it."""

    name: str
    what: str
    run: Callable[[float, Path], "Found"]


class Found(NamedTuple):
    """Number of trials and survivals, what was lost against the promise, what went wrong unsaid, and figures."""

    tried: int
    survived: int
    lost: int
    silent: int
    figures: str


def part_of(number: int, share: float, least: int = 1) -> int:
    """So many of `number`."""
    return max(least, round(number * share))


def memory_of(process: int | str) -> float:
    """Resident memory of a process [B]."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * float(os.sysconf("SC_PAGE_SIZE"))


class Cost(NamedTuple):
    """Of work in a process of its own: processor seconds, memory it took at most [B], whether it ended well."""

    seconds: float
    memory: float
    well: bool


def in_a_process(work: Callable[[], None]) -> Cost:
    """Runs `work` in a fork, which is ended after 60 s of processor time; a traceback there counts as not well."""
    shared = memoryview(mmap.mmap(-1, 8)).cast("d")
    child = os.fork()
    if child == 0:
        shared[0] = memory_of("self")
        resource.setrlimit(resource.RLIMIT_CPU, (60, 60))
        try:
            work()
            os._exit(0)
        except BaseException:
            os._exit(1)
    _, status, used = os.wait4(child, 0)
    return Cost(used.ru_utime + used.ru_stime, used.ru_maxrss * 1024.0 - shared[0], status == 0)


def until(done: Callable[[], bool], seconds: float, period: float = 0.01) -> bool:
    """Waits for `done()`; False where it does not come in time."""
    end = time.monotonic() + seconds
    while not done():
        if time.monotonic() > end:
            return False
        time.sleep(period)
    return True
