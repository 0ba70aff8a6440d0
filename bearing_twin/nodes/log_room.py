"""How much room there is for a log, and clocks that are put right while it is written; without ROS."""

import math
import shutil
import time
from collections.abc import Callable
from pathlib import Path

SOON = 3600.0  # s: a disk that will be full before is told of
JUMP_NS = 100_000_000  # between two looks, beyond what a clock that is set gently does
TOGETHER_NS, TRIES = 1_000_000, 100  # in which two clocks are to be read, and how often that is tried: see `SteadyTime`


class Room:
    """Watches the room on the disk of `folder`, and how fast a log in it grows."""

    def __init__(self, folder: Path):
        self._folder = folder
        self._looked = 0, 0.0  # size of the log, and when [s]

    def forecast(self, size: int, now: float) -> dict[str, float]:
        """Room on the disk [B], growth of the log since the last call [B/s], and when the disk is full [s], may be inf.

        `size` [B] is that of the log, `now` monotonic [s]. A log whose oldest files are removed grows no more, but for
        its first round.
        """
        earlier, since = self._looked
        self._looked = size, now
        there = next(one for one in (self._folder, *self._folder.absolute().parents) if one.exists())
        free = float(shutil.disk_usage(there).free)
        rate = max(0.0, (size - earlier) / (now - since)) if now > since else 0.0
        return {"disk_free_bytes": free, "log_bytes_per_s": rate, "disk_full_in_s": free / rate if rate else math.inf}


def in_an_hour(forecast: dict[str, float]) -> str:
    """The sentence about the size of an hour of a log that grows, and the time for which its disk lasts."""
    rate, left = forecast["log_bytes_per_s"], forecast["disk_full_in_s"]
    lasts = f"{left / 3600.0:.3g} h" if left < 48 * 3600.0 else f"{left / 86400.0:.3g} days"
    return f"at this rate an hour of the log takes {in_bytes(3600.0 * rate)}, and the disk lasts {lasts}"


def in_bytes(size: float) -> str:
    """A size with its unit, such as 3.2 MB."""
    power = min(max(int(math.log10(size) // 3) if size >= 1.0 else 0, 0), 4)
    return f"{size / 1000.0**power:.3g} {('B', 'kB', 'MB', 'GB', 'TB')[power]}"


def warning(forecast: dict[str, float]) -> str:
    """The sentence about a disk that will be full soon; empty where that is far off."""
    left = forecast["disk_full_in_s"]
    return f"the disk will be full in {left / 60.0:.0f} min at this rate" if left < SOON else ""


class SteadyTime:
    """Times of arrival by a clock of the system that may be put right: they go on as if it had not been.

    `jumped_ns` is by how much it was put forward in all, negative for back; clocks that are set gently are followed.
    On a busy machine 0.3 s can lie between one clock and the other, which is no jump: they are read again then.
    """

    def __init__(self, wall: Callable[[], int] = time.time_ns, steady: Callable[[], int] = time.monotonic_ns):
        self._wall, self._steady = wall, steady
        self._ahead = self._both()[1]
        self.jumped_ns = 0
        self._fresh = 0  # wall time from which on times of arrival were told by the clock as it is now

    def look(self) -> int:
        """By how much the clock has been put since the last look [ns], 0 = not; call it between arrival and `at`."""
        wall, ahead = self._both()
        jump, self._ahead = ahead - self._ahead, ahead
        if abs(jump) < JUMP_NS:
            return 0
        self.jumped_ns += jump
        self._fresh = wall
        return jump

    def _both(self) -> tuple[int, int]:
        """The clock of the system, and by how much it is ahead of the steady one."""
        for _ in range(TRIES):
            before, wall, after = self._steady(), self._wall(), self._steady()
            if after - before < TOGETHER_NS:
                break
        return wall, wall - after

    def at(self, arrived_ns: int) -> int:
        """The time to log of a message that arrived at `arrived_ns` by the clock, 0 = now."""
        if arrived_ns > 0 and not self.jumped_ns:  # nearly always, and without a look at the clock
            return arrived_ns
        now = self._wall()
        known = self.jumped_ns and self._fresh <= arrived_ns <= now
        return (arrived_ns if known else now) - self.jumped_ns
