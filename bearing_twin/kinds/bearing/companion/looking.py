"""Where a part of a bearing run is worth a look, by what points to its errors and what was looked at before."""

import math

import numpy as np

from bearing_twin.kinds.bearing.companion.deviations import LEAST_LOAD, Part
from bearing_twin.kinds.bearing.companion.growth import Growth
from bearing_twin.kinds.bearing.companion.meetings import as_met, copied_from, meetings, until_met
from bearing_twin.kinds.bearing.companion.pointers import (
    MOST,
    POINTERS,
    SLIDING,
    foremost,
    one_for_all,
    pointers,
    spare,
)
from bearing_twin.kinds.bearing.companion.windows import (
    ALL,
    LEAST_STEPS,
    Window,
    overlap,
    since_begun,
    steps_before,
    steps_in,
    window_at,
    within,
)
from bearing_twin.kinds.bearing.parameters import LOADS, BearingScene

LIKE, CHEAP, EARLY = 0.5, 0.005, 8  # times the least of those; of the run's steps: worth a look in so many parts then
AT_FIRST = 0.02  # of the run's steps: what a look at a ball that slides at first may take
SLIDES = 0.01  # of mu N: a contact with less friction rolls
CANDIDATES = 16  # outputs that point most, of which windows are made
RAISED, FAR_RAISED = 1.2, 2.0  # times the least of those: worth a look; times the greatest: whatever it costs
LOOKING = 0.1  # of the run's steps: where more were spent, only that is looked at which exceeds all before by far ...
EVENTFUL = 0.3  # ... where balls roll in and out of the load: each time anew, and few of these times are looked at
LONG = 30.0  # times the least steps: where a window has more once its part is done again, its end is enough


def _nan_last(number: float) -> tuple[bool, float]:
    """By which numbers are sorted as NumPy does."""
    return number != number, number


class Looking:
    """Chooses windows of the parts of a run, and keeps what pointed to those that were looked at."""

    parameters: BearingScene

    def reset(self) -> None:
        """Forgets the run."""
        self.best = np.zeros((POINTERS, MOST))
        self.greatest_load = 0.0
        self.looked = self.parts = self.met = 0
        wanted = self.parameters.wanted
        self.growth = Growth(wanted.tolerance, wanted.outputs == LOADS)  # by rows of parts that stand
        self.spare = 1.0  # times the errors of the last part: still less than those that were looked at

    def windows(self, part: Part) -> list[Window]:
        """Where this part is worth a look: for each pointer apart from each other in time."""
        grids, steps = self._pointers(part)
        met, whole, planned = meetings(part), part.partners.active, 0.0
        copied = self._copied(part, met) is not None
        points, flat = (one.tolist() for one in foremost(grids, CANDIDATES))
        found: list[Window] = []
        touched, before = bool(met.any()), {}
        much = self._much(part)
        # Balls that begin to roll at the start of a run may rule what their friction is off in all of it.
        first = not self.parts and self.parameters.wanted.outputs != LOADS
        some_cheap = not whole and self.parts < EARLY
        some_cheap = some_cheap and min(LEAST_STEPS, steps.sum(axis=1).min()) <= CHEAP * part.taken
        for place in range(POINTERS):
            mine: list[Window] = []
            least = (LIKE if some_cheap else RAISED) * self.best[place].min()
            for point, at in zip(points[place], flat[place], strict=True):
                if not point > least:
                    break
                row, cell = divmod(at, grids.shape[2])
                spent = self.looked + planned > much and not (first and place == SLIDING and not whole)
                good = self._worth(place, point, mine, spent)
                if len(mine) == MOST or not (good or some_cheap):
                    break
                if row not in before:
                    before[row] = steps_before(steps[row])
                window = window_at(ALL if whole else row, cell, before[row])
                if place == SLIDING and not whole:
                    window = since_begun(window, before[row])
                window = as_met(window, met) if touched else window
                if copied and window.ball == ALL:
                    continue  # a copy of the run shows what meetings do
                good = good or steps_in(window, row, steps) <= CHEAP * part.taken
                # Balls begin to roll at about the same instant, each at another one of a step.
                near = [one for one in mine if place != SLIDING or one.ball == window.ball]
                if good and not any(overlap(window, other) for other in near):
                    mine.append(window)
                    if not any(within(window, other) for other in found):
                        found.append(window)
                        planned += self._see(part, window, row, grids, steps)
        self.spare = spare(self.best, [one[0] for one in points]) if len(part.pointer) else 1.0
        self.parts += 1
        if (self.parts > 1 or not found) and self.parts.bit_count() == 1 and ALL not in {one.ball for one in found}:
            calm = int(steps.sum(axis=1).argmin())
            window = as_met(window_at(ALL if whole else calm, len(part.times) - 1, steps_before(steps[calm])), met)
            found += [] if any(within(window, other) for other in found) else [window]
        if whole:
            return found
        found, at_first = one_for_all(found, grids, steps), []
        if first:
            at_first = self._sliding_at_first(part, grids[SLIDING], steps, met)
        return found + [one for one in at_first if not any(within(one, other) for other in found)]

    def _sliding_at_first(self, part: Part, sliding: np.ndarray, steps: np.ndarray, met: np.ndarray) -> list[Window]:
        """A window from the start of the run, while it is cheap, of the ball whose friction feels errors of slip most.

        What such a ball is off grows until it rolls, and in a long part others point more later on. `sliding` and
        `steps` are of `pointers`, (balls, outputs).
        """
        cheap = np.cumsum(steps, axis=1) <= AT_FIRST * part.taken
        felt = np.where(cheap, sliding, 0.0).max(axis=1)
        ball = int(felt.argmax())
        window = until_met(Window(ball, -1, int(cheap[ball].sum())), met)
        slides = felt[ball] > SLIDES * self.parameters.contact.friction_coefficient
        return [window] if slides and steps_in(window, ball, steps) >= LEAST_STEPS else []

    @property
    def horizon(self) -> float:
        """The run's horizon [s] by what was seen in the parts so far; EVER where it has none.

        Where nobody looked somebody may, once a part is done again.
        """
        return self.growth.horizon_seen

    def stands(self, found: list[np.ndarray]) -> None:
        """Takes in the rows of WINDOW of a part that stands, in order of time, as whoever reads the records does."""
        rows = np.concatenate(found or [np.zeros((0, 1))])
        for row in rows[np.argsort(rows[:, 0], kind="stable")]:
            self.growth.add(row, self.greatest_load)

    def _beyond(self, part: Part) -> bool:
        """Whether a part begins beyond the run's horizon."""
        return part.elapsed >= self.horizon

    def _copied(self, part: Part, met: np.ndarray) -> int | None:
        """The output at which a copy sets out in a part with these meetings; None where there is none."""
        return None if self._beyond(part) else copied_from(met, self.met)

    def windows_again(self, part: Part, windows: list[Window]) -> list[Window]:
        """These windows of a part that was done again, where other balls may have met; what points to them is kept.

        One in which a ball takes many more steps now, as it rings, is cut to its end, but where it begins with its part
        as a ball slides.
        """
        grids, steps = self._pointers(part)
        met, again = meetings(part), []
        for window in windows:
            end = window.begin + window.length - 1
            if window.ball >= 0 <= window.begin and steps_in(window, window.ball, steps) > LONG * LEAST_STEPS:
                window = window_at(window.ball, end, steps_before(steps[window.ball]))
            again.append(as_met(window, met))
            self._see(part, again[-1], again[-1].ball, grids, steps)
        return again

    def _jumped(self, part: Part) -> bool:
        """Whether a part begins with a ring that is shifted at once."""
        change = self.parameters.drive.change
        return bool(change.time) and any(change.offset) and math.isclose(part.elapsed, change.time)

    def _see(self, part: Part, window: Window, row: int, grids: np.ndarray, steps: np.ndarray) -> float:
        """Keeps what the pointers say in a window that is looked at; the steps that the run took in it.

        What they say of a jump of all balls is a thousand times what they say of balls that roll on, which are off by
        more: it is not kept, so that these are looked at as well.
        """
        if window.ball == ALL and window.begin < 0 and self._jumped(part):
            return steps_in(window, row, steps)
        inside = slice(window.begin + 1, window.begin + 1 + window.length)
        rows = slice(None) if window.ball == ALL else slice(row, row + 1)
        for place, most in enumerate(grids[:, rows, inside].max(axis=(1, 2)).tolist()):
            self.best[place] = sorted([*self.best[place].tolist(), most], key=_nan_last)[1:]
        return steps_in(window, row, steps)

    def _worth(self, place: int, point: float, mine: list[Window], spent: bool) -> bool:
        """Whether a window is worth its steps: the first always is; where many were `spent`, what points far more."""
        best = self.best[place]
        if spent or any(one.ball == ALL for one in mine):
            return point > FAR_RAISED * best.max()
        return point > RAISED * best.min()

    def _much(self, part: Part) -> float:
        """Steps of windows in a part and before it, beyond which only that is worth a look which exceeds all by far."""
        eventful = not part.partners.active and not part.all_bear and (part.load > 0.0).any(axis=2).all()
        return (EVENTFUL if eventful else LOOKING) * part.taken

    def _pointers(self, part: Part) -> tuple[np.ndarray, np.ndarray]:
        self.greatest_load = max(self.greatest_load, float(part.load.max()))
        return pointers(part, LEAST_LOAD * self.greatest_load)
