"""When a shaft that a torque turns came to its speed, gathered block by block in memory that does not grow."""

import numpy as np

from bearing_twin.base.sample import Block
from bearing_twin.kinds.bearing.drive import TORQUE

DONE = 0.99  # of the change of speed over the run
APART = 1e-3  # relative: changes nearer than this to the one kept last are not kept


class RunUp:
    """The greatest changes of a speed so far, upwards and downwards, and when they were come to."""

    def __init__(self, parameters):
        self._turned = parameters.drive.kind == TORQUE
        self._kept: dict[int, list[tuple[float, float]]] = {1: [], -1: []}
        self._first: float | None = None

    def add(self, block: Block) -> None:
        """Takes in the speeds of a block where a torque makes them."""
        if not self._turned:
            return
        times, speeds = 1e-9 * block.time_ns, block.values["inner_ring_speed"]
        self._first = float(speeds[0]) if self._first is None else self._first
        for sign, kept in self._kept.items():
            change = np.maximum.accumulate(sign * (speeds - self._first))
            grown = np.flatnonzero(np.diff(change, prepend=0.0 if not kept else kept[-1][1]) > 0.0)
            for row in grown.tolist():
                if change[row] > (kept[-1][1] if kept else 0.0) * (1.0 + APART):
                    kept.append((float(times[row]), float(change[row])))

    def time_to(self, last: float) -> float:
        """Time [s] at which DONE of the change from first to `last` speed was first made; 0 without a change."""
        change = last - (last if self._first is None else self._first)
        before = (0.0, 0.0)
        for here in self._kept[1 if change > 0.0 else -1]:
            if here[1] >= DONE * abs(change):
                share = (DONE * abs(change) - before[1]) / (here[1] - before[1])
                return before[0] + share * (here[0] - before[0])
            before = here
        return before[0]
