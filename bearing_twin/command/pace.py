"""How fast messages come: rate and periods between them, by a clock that is handed in."""

import math
import time
from collections.abc import Callable

SAID_EVERY = 1.0  # s


class MessagePace:
    """Counts messages and the periods between them; sums only, so that it can run for days."""

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self._clock, self._first, self._last, self._said = clock, None, 0.0, 0.0
        self.count, self._squares = 0, 0.0
        self._least, self._greatest = math.inf, 0.0

    def message(self) -> bool:
        """Takes a message; says whether a second has passed since it last said so."""
        now = self._clock()
        self.count += 1
        if self._first is None:
            self._first = self._said = self._last = now
            return False
        period, self._last = now - self._last, now
        self._squares += period * period
        self._least, self._greatest = min(self._least, period), max(self._greatest, period)
        if now - self._said < SAID_EVERY:
            return False
        self._said = now
        return True

    def figures(self) -> dict:
        """Count, rate [Hz], least, greatest and standard deviation of the periods [s]; NaN without two messages."""
        periods = self.count - 1
        if periods < 1:
            return {"messages": self.count, "rate_hz": math.nan}
        span = self._last - self._first
        mean = span / periods
        return {
            "messages": self.count,
            "rate_hz": periods / span if span else math.inf,
            "least_period_s": self._least,
            "greatest_period_s": self._greatest,
            "std_of_period_s": math.sqrt(max(self._squares / periods - mean * mean, 0.0)),
        }
