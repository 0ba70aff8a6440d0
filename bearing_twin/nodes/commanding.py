"""What becomes of commands to a running simulation: counted, reported, and how long a load holds."""

import math
from contextlib import contextmanager

from bearing_twin.errors import BearingTwinError
from bearing_twin.spelling import echo


class Commands:
    """Counts of commands, and the time at which a load becomes stale; `load_timeout_ns` 0 = never.

    A load holds until the next. One that is not followed by another within the timeout, in simulated time from the
    output it began after, is stale: the scene's own load acts again, and that is said until a new load comes.
    """

    def __init__(self, load_timeout_ns: int = 0, frame_prefix: str = ""):
        self.taken = self.refused = 0
        self._timeout, self._prefix = load_timeout_ns, frame_prefix
        self._last, self._told = "", 0
        self.forget_load()

    def forget_load(self) -> None:
        """The scene's own load acts, as at the start."""
        self._stale_at: int | None = None
        self._source = "the scene"
        self.load_is_stale = False

    @contextmanager
    def counted(self, name: str):
        """Counts what happens within as a command on the topic `name`, taken or, by BearingTwinError, refused."""
        try:
            yield
        except BearingTwinError as error:
            self.refused += 1
            self._last = f"{name} refused: {error}"
            raise BearingTwinError(self._last) from error
        self.taken += 1

    def check_frame(self, message, frame: str) -> None:
        """Raises BearingTwinError unless a message with a header is in `frame`, or names no frame at all."""
        given = message.header.frame_id if hasattr(message, "header") else ""
        if given and given != f"{self._prefix}{frame}":
            raise BearingTwinError(f"its frame is {echo(given)}, but it is taken in {self._prefix}{frame} alone")

    def note_load(self, time_ns: int) -> None:
        """A load acts from the output after `time_ns` on."""
        self.forget_load()
        self._source = "command/load"
        if self._timeout:
            self._stale_at = max(time_ns, 0) + self._timeout

    def fresh_outputs(self, time_ns: int, period_ns: int) -> float:
        """How many outputs after `time_ns` the load holds for; infinite where it does not grow stale."""
        return math.inf if self._stale_at is None else max(0, math.ceil((self._stale_at - time_ns) / period_ns))

    def let_go(self) -> None:
        """The load is stale."""
        self.forget_load()
        self.load_is_stale = True

    def doubt(self) -> str:
        """What to warn of: a stale load, and refusals since this was asked last; "" if nothing."""
        new, self._told = self.refused - self._told, self.refused
        words = [
            f"command/load is stale, {self._timeout * 1e-9:g} s without another: the scene's own load acts"
            if self.load_is_stale
            else "",
            f"{new} refused, the last: {self._last}" if new else "",
        ]
        return "; ".join(word for word in words if word)

    def numbers(self) -> dict[str, object]:
        """For diagnostics."""
        return {"commands_taken": self.taken, "commands_refused": self.refused, "last_refusal": self._last or "-"} | {
            "load_from": self._source
        }
