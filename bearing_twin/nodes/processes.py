"""Nodes as processes of their own: started, listened to for signs of life, ended; without ROS.

A node is waited for as long as it lives and its heartbeat is heard, however slow the machine is.
"""

import contextlib
import json
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from bearing_twin.errors import BearingTwinError
from bearing_twin.spelling import ROS_ARGS

SILENCE = 300.0  # s without a heartbeat, of which a node sends one a second
LONGEST_LOOK = 1.0  # s: a longer gap between two looks means that this process did not run either, and counts no more
GRACE = 60.0  # s a node has to end after SIGINT, before it is killed
LAST_WORDS = 3  # lines of a node's output that an error repeats


class ProcessError(BearingTwinError):
    """A node ended too early, failed or fell silent; the sentence names its output and what to do."""


class NodeProcess:
    """A process with its output in the file `said`; `status` and `values` are those of its last heartbeat."""

    def __init__(self, name: str, command: Sequence[str], said: Path):
        self.name, self.said = name, said
        with said.open("wb") as output:
            self.process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT)
        self.status, self.values = "starting", {}
        self._silent_for, self._looked_at = 0.0, None

    @property
    def ended(self) -> bool:
        """Whether the process is no more."""
        return self.process.poll() is not None

    def heard(self, status: str, values: dict[str, str]) -> None:
        """Takes a heartbeat."""
        self.status, self.values, self._silent_for = status, values, 0.0

    def look(self, now: float, may_end: bool = False) -> None:
        """Raises ProcessError if the process ended though it may not, failed, or was silent; `now` is in s."""
        code = self.process.poll()
        if code is not None:
            if code != 0 or not may_end:
                raise ProcessError(self._sentence(_end_of(code)))
            return
        if self._looked_at is not None:
            self._silent_for += min(now - self._looked_at, LONGEST_LOOK)
        self._looked_at = now
        if self._silent_for > SILENCE:
            raise ProcessError(self._sentence(f"gave no sign of life for {SILENCE:.0f} s while {self.status}"))

    def interrupt(self) -> None:
        """Asks the node to end, as Ctrl-C does."""
        if not self.ended:
            self.process.send_signal(signal.SIGINT)

    def end(self) -> None:
        """Ends the process: asked first, killed when that did nothing."""
        self.interrupt()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(GRACE)
        if not self.ended:
            self.process.kill()
            self.process.wait()

    def _sentence(self, what: str) -> str:
        lines = self.said.read_text(encoding="utf-8", errors="replace").splitlines()[-LAST_WORDS:]
        words = "".join(f"\n  {line}" for line in lines) or " nothing"
        return (
            f"{self.name} {what}. Its last words:{words}\n"
            f"All it said is in {self.said}. Mend what it names, or try again: what was compiled so far is kept."
        )


@contextlib.contextmanager
def started(name: str, command: Sequence[str], folder: Path) -> Iterator[NodeProcess]:
    """A process with its output in `folder`; whatever happens in the body, it ends with the body."""
    node = NodeProcess(name, command, folder / f"{name}.txt")
    try:
        yield node
    finally:
        node.end()


def node_command(name: str, parameters: dict) -> list[str]:
    """The words that start a node of this package with these parameters."""
    words = [f"{key}:={json.dumps(value, default=str)}" for key, value in parameters.items()]
    command = [sys.executable, "-m", "bearing_twin.nodes.entry", name, ROS_ARGS]
    return [*command, *(part for word in words for part in ("-p", word))]


def _end_of(code: int) -> str:
    if code < 0:
        return f"was ended from outside by {signal.Signals(-code).name}"
    return f"ended early, with exit code {code}"
