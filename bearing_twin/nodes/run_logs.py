"""Logs of the runs of one node: a reset begins another, and anybody can ask for it, so that there is a limit."""

from collections.abc import Callable
from pathlib import Path

MOST_LOGS = 1000  # of one node; each takes 0.1 MB at least


class RunLogs:
    """Opens the logs of runs 0, 1, 2 ... beside `path` (empty: none), and says how much room all take.

    `open_log(path)` gives a log with `problem`, `dropped` and `bytes`.
    """

    def __init__(self, path: str, open_log: Callable[[Path], object]):
        self._path, self._open = path, open_log
        self._newest: list = []  # the last two: a log is opened before the one before is completed
        self._bytes_before = self._dropped_before = 0
        self.count = 0
        self.doubt = ""  # why the run is not logged

    def begin(self, run: int):
        """The log of a run, None where there are too many already; raises LogError, and is then as it was."""
        if not self._path:
            return None
        if self.count >= MOST_LOGS:
            self.doubt = f"not logged: the node has begun {self.count} logs; start it again for more"
            return None
        log = self._open(log_path(self._path, run))
        for gone in self._newest[:-1]:
            self._bytes_before += gone.bytes
            self._dropped_before += gone.dropped
        self._newest = [*self._newest[-1:], log]
        self.count += 1
        return log

    @property
    def problem(self) -> str:
        """Why the last log cannot grow, empty while it can."""
        return self._newest[-1].problem if self._newest else ""

    @property
    def dropped(self) -> int:
        """Messages of all runs for which there was no room."""
        return self._dropped_before + sum(one.dropped for one in self._newest)

    @property
    def bytes(self) -> int:
        """Size of all logs."""
        return self._bytes_before + sum(one.bytes for one in self._newest)


def log_path(path: str | Path, run: int) -> Path:
    """Where run 0, 1, 2 ... is logged: run.mcap, run_1.mcap, run_2.mcap ..."""
    path = Path(path)
    return path if run == 0 else path.with_name(f"{path.stem}_{run}{path.suffix}")
