"""A second motion of all balls with ring and cage, more exact, beside a run whose balls bump into a cage, or bounce.

What such a run is off it carries on from one to the next, and more each time, which no window shows. In each part this
motion begins where it got to in the part before, not where the run is: its difference from the run is all that the run
is off, with what it inherits. Where both raceways carry all balls, none bumps, and nothing is integrated: how far the
run is off stays as it is.
"""

from collections.abc import Iterator

import numpy as np

from bearing_twin.kinds.bearing.companion.beside import all_beside
from bearing_twin.kinds.bearing.companion.departures import all_start
from bearing_twin.kinds.bearing.companion.deviations import Found, Part
from bearing_twin.kinds.bearing.companion.windows import BESIDE, Window
from bearing_twin.kinds.bearing.forces.layout import BORDER, COLUMNS, LAND_WORK, MOTION, SHAFT_WORK, WORK_DONE
from bearing_twin.kinds.bearing.parameters import BearingScene

STRETCHES = 4  # of a part: behind each it is seen how far the run is off
WORKS = [*range(WORK_DONE, LAND_WORK + 1), SHAFT_WORK]  # columns of a border that are integrals and move nothing


def stretches(outputs: int) -> Iterator[Window]:
    """Windows of all balls one behind the other through a part of so many outputs."""
    length = -(-outputs // STRETCHES)
    for begin in range(-1, outputs - 1, length):
        yield Window(BESIDE, begin, min(length, outputs - 1 - begin))


class Second:
    """Goes beside a run from part to part; `shown` is the most that a window of all balls was off by itself.

    `apart` is how far states (balls, COLUMNS) and border (BORDER,) were off the run's at the end of a part; None where
    nothing goes beside it.
    """

    def __init__(self, parameters: BearingScene):
        self.parameters = parameters
        self.shown = 0.0
        self.apart: tuple[np.ndarray, ...] | None = None

    def memory(self) -> list:
        """As plain data; see `remember`."""
        return [self.shown, *(one.tolist() for one in self.apart or ())]

    def remember(self, kept: list) -> None:
        """Goes on from what `memory` gave, from nothing where an older snapshot has none.

        Raises TypeError or ValueError for that of another bearing.
        """
        shown, *apart = kept or [0.0]
        apart = tuple(np.array(one, float) for one in apart)
        if [one.shape for one in apart] not in ([], [(self.parameters.geometry.balls, COLUMNS), (BORDER,)]):
            raise ValueError("second")
        self.shown, self.apart = float(shown), apart or None

    def through(self, part: Part, ended: tuple, scales: np.ndarray) -> Iterator[tuple[Window, Found]]:
        """Stretches of a part, each with what was found; fewer where it breaks off, or nobody asks for the next.

        `ended` are states and border of the run at the end of the part.
        """
        if part.all_bear:
            return
        moving, border = all_start(part, -1, len(part.times))
        if self.apart is not None:
            moving[0][:], border[:] = moving[0] + self.apart[0], border + self.apart[1]
        last, self.apart, end = (*moving, border), None, part.duration
        for window in stretches(len(part.times)):
            here = window.begin + window.length
            what = scales, last, (until := end if here + 1 == len(part.times) else None)
            if (found := all_beside(self.parameters, part, window, *what)) is None:
                return
            yield window, found
            last = found.last
            own = ended if until else (part.filled[0][here], part.filled[2][here])
            # Errors of integrals are told of each stretch by itself.
            last[0][:, MOTION:], last[4][WORKS] = own[0][:, MOTION:], own[1][WORKS]
        self.apart = last[0] - ended[0], last[4] - ended[1]
