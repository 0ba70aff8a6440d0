"""How charts measure costs: CPU time of one thread, the median of several timings, and how far these lie apart."""

import math
import signal
import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

LONG_ENOUGH = 0.1  # CPU seconds of a timing, for the clocks of some machines tick every 10 ms
LEAST, FEWEST = 5, 3  # timings, where they are short; without so many a spread is not known
SURE, MOST = 0.02, 30.0  # of the median, where timings end early; what all of them may take, in lengths of one


class Timing(NamedTuple):
    """CPU seconds, and their spread: the range of the middle half of the timings over the median, NaN if unknown."""

    seconds: float
    spread: float


def timing_of(spans: Sequence[float]) -> Timing:
    """What several timings [s] of the same say."""
    low, middle, high = np.quantile(spans, (0.25, 0.5, 0.75)).tolist()
    return Timing(middle, (high - low) / middle if len(spans) >= FEWEST and middle > 0.0 else math.nan)


def timed(work: Callable[[], Any], enough: float = LONG_ENOUGH) -> tuple[Any, Timing]:
    """What `work` gives, and its CPU seconds of this thread, from timings of at least `enough` [s] each; 0 = one run.

    The first run of a short one is not counted: it may import and compile. A long one is run once, and one that is near
    its limit (`contest.limited`) is not run again.
    """
    found, first = _span(work)
    if not enough or FEWEST * first > min(MOST * enough, 0.5 * _left()):
        return found, Timing(first, math.nan)
    spans, runs = [], 1
    while len(spans) < LEAST or not _sure(spans):
        span = _span(work, runs)[1]
        if span < enough and not spans:
            runs = math.ceil(1.2 * runs * min(enough / max(span, 1e-9), 100.0))
            continue
        spans.append(span / runs)
        spent = runs * sum(spans)
        if spent + span > MOST * enough or (len(spans) >= FEWEST and 2.0 * span > _left()):
            break
    return found, timing_of(spans)


def _sure(spans) -> bool:
    return not timing_of(spans).spread > SURE * math.sqrt(len(spans))


def _span(work, runs=1) -> tuple[Any, float]:
    start = time.thread_time()
    for _ in range(runs):
        found = work()
    return found, time.thread_time() - start


def _left() -> float:
    """CPU seconds that this process may still take within a limit."""
    return (hasattr(signal, "getitimer") and signal.getitimer(signal.ITIMER_PROF)[0]) or math.inf
