"""When a stretch of a bearing run is done again by shorter steps, and by how much shorter.

Estimates are within a factor of three of the true errors, so what is estimated to be off by a third of the tolerance
keeps it. A part is done again for what its own steps add; what it carries on from before betters only when that is
done again, which ends its chunk early. Both end where they do not help, or where too much was spent. How tight, how
often and how long was chosen by `bearing_twin chart tolerance`, as the numbers of the other modules of this room.
"""

import math

import numpy as np

from bearing_twin.kinds.bearing.companion.windows import ALL, APART, BESIDE, BETWEEN, INHERITED, PLACE
from bearing_twin.kinds.bearing.companion.worst import MISSED, spread_of

SAFE, GOOD = 1.0 / 3.0, 0.5  # share of the tolerance that an estimate may be; once it was done again
CARRIED = 0.8  # ... of what is carried on: a chunk is dear, and may end up worse where balls meet
AIM = 0.25  # share of the tolerance that a tighter setting aims at
LEAST_CUT, MOST_CUT = 0.3, 0.01  # of the setting in one go
REDONE = 3  # times at most that a part is done again
RETAKEN = 2  # times at most that a chunk is: where balls carried an error on from earlier parts of it
MOST_SPENT = 6.0  # times the steps of the first go at a part: where more were spent, it is not done again
SPARED = 0.5  # of what was too rough: a setting gets no rougher again
HELPED = 0.8  # of what was found before: where more is left, as of balls that hit each other, tighter steps do not help
FUTILE = 0.1  # of the scene's setting: what did not help is not kept below
CALM, PATIENT = 0.1, 4  # share of the tolerance; parts whose windows are off by less make the setting rougher again ...
RELAXED, NOTABLE = 3.0, 1.2  # ... by so many times in one go, at most and at least
BEYOND = 3.0  # of the scene's setting beyond the run's horizon: statistics are the same (docs/doubt.md)
UNSEEN = 0.1  # of the setting, in a part without outputs, which no window sees: it is short, and may hold a jump


class CarriedOn(Exception):
    """A part that began `since` [s] is off too far by what it carries on from before it; `worst` over the tolerance."""

    def __init__(self, worst: float, since: float):
        super().__init__(worst, since)
        self.worst, self.since = worst, since


def setting_of(told) -> float:
    """The setting that a snapshot `told`; raises ValueError for what is none."""
    setting = float(told)
    if not 0.0 < setting < math.inf:
        raise ValueError("setting")
    return setting


def cut_by(worst: float) -> float:
    """The share of the setting that is tried next, where the error was `worst` times the tolerance."""
    return min(LEAST_CUT, max(MOST_CUT, AIM / worst))


def carried(rows: np.ndarray, begun: float) -> np.ndarray:
    """Those rows of WINDOW of a part that began at `begun` [s] which hold what it carries on from before."""
    balls = rows[:, PLACE["ball"]]
    return rows[(rows[:, PLACE["begin"]] < begun) | (balls == APART) | (balls == BESIDE)]


def weighed(rows: np.ndarray, eventful: bool, carries: bool) -> np.ndarray:
    """Rows of WINDOW of a part with errors as they count beside SAFE.

    Where contacts come and go (`eventful`), such that with what windows miss, and the spread of estimates, the
    tolerance is kept. What a ring `carries` on may be GOOD of it: 97 of 100 true errors are within twice what is told.
    """
    if not len(rows):
        return rows
    balls, spread = rows[:, PLACE["ball"]], spread_of(eventful, carries)
    windows, told = 1.0, 1.0
    if eventful:
        windows, told = SAFE * MISSED * np.where(balls == ALL, spread.together, spread.alone), SAFE * spread.told
    inherited = SAFE / GOOD if carries else told
    weights = np.where(balls >= ALL, windows, np.where(balls == INHERITED, inherited, told))
    return rows * np.where(balls == BETWEEN, 1.0, weights)[:, None]


def enough(worst: float, attempt: int, eventful: bool) -> bool:
    """Whether a part is exact enough at this attempt, by its `worst` error, `weighed` over the tolerance."""
    return attempt == REDONE or worst <= (GOOD if attempt and not eventful else SAFE)
