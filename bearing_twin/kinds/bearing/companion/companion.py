"""A companion of a bearing run: windows of it integrated again with a tighter tolerance, from the run's own states.

The difference is the error that the run makes within a window, once the window is several steps long (shorter ones
measure their own ends). Windows are few: they end where the steps' own error estimates (`pointing`) do most to a ball's
force or torque, or a contact slides most, as far as that exceeds what was looked at before in the run; and one more
after 2, 4, 8 ... parts, where steps are longest. Balls on their own are taken one by one, many in one call; coupled
ones, which meet, a moving ring or a cage, all together. What error the start of a window has from before, no window
sees. Where the motion is still off at the end of a window, or a ball is loose, the companion goes on beside the run
until neither holds, or it has taken its share of steps: what is found is then a lower bound. Where balls meet, a copy
of the run that starts apart by what it is off there shows what becomes of that. Where balls bump into a cage, a window
of all balls is followed now and then (`_probes`) until it is seen that bumps carry errors on (`diverged`).
"""

import numpy as np

from bearing_twin.kinds.bearing.companion.beside import TIGHTER, all_beside, some_beside
from bearing_twin.kinds.bearing.companion.departures import (
    UNKNOWN,
    Followed,
    affordable,
    bouncing,
    loose,
    nowhere,
    starts,
    to_the_end,
    together,
)
from bearing_twin.kinds.bearing.companion.deviations import LEAST_LOAD, Part, deviations, left_over, off_in_flight
from bearing_twin.kinds.bearing.companion.growth import FLOOR, MET
from bearing_twin.kinds.bearing.companion.meetings import (
    COPYING,
    Drift,
    as_met,
    copied_from,
    meetings,
    stretches_from,
    until_met,
)
from bearing_twin.kinds.bearing.companion.pointers import MOST, POINTERS, one_for_all, pointers, spare
from bearing_twin.kinds.bearing.companion.windows import (
    ALL,
    BUMPING,
    LEAST_STEPS,
    WINDOW,
    Window,
    bumps,
    off_by,
    overlap,
    steps_in,
    window_at,
    within,
)
from bearing_twin.kinds.bearing.parameters import BearingScene

LIKE, CHEAP, EARLY = 0.5, 0.005, 8  # times the least of those; of the run's steps: worth a look in so many parts then
CANDIDATES = 16  # outputs that point most, of which windows are made
RAISED, FAR_RAISED = 1.2, 2.0  # times the least of those: worth a look; times the greatest: whatever it costs
LOOKING = 0.1  # of the run's steps: where more were spent, only that is looked at which exceeds all before by far
BEARABLE = 0.1  # of the wanted tolerance: what a motion may be off at the end of a window without being followed
AT_A_TIME = 2  # balls that are followed
FOLLOWING = 0.1  # of the run's steps: where more were spent, nothing more is followed ...
THREATENED = 0.33  # ... unless it is off by the tolerance, loose, or bumps into a cage: then until so many were
BOUNCING = 0.45  # ... or would be, with a ball that bounces although nothing points to it: it may rule a short run
DEARER = 1.35  # times the run's steps: what a companion takes, at a third of the tolerance by a method of fourth order
KEPT = {"greatest_load": float, "steps": int, "looked": int, "parts": int, "met": int, "diverged": bool}
KEPT |= {"grew": float, "reached": float}


class Companion:
    """Looks at parts of a run and keeps rows of WINDOW; the same parts give the same rows.

    `unit` (MOTION,) are the errors of a ball's motion that a tolerance of 1 allows.
    """

    def __init__(self, parameters: BearingScene, unit: np.ndarray):
        self.parameters = parameters
        self._allowed = parameters.wanted.tolerance * unit
        self.reset()

    def reset(self) -> None:
        """Forgets the run."""
        self.best = np.zeros((POINTERS, MOST))
        self.greatest_load = 0.0
        self.steps = self.looked = self.parts = self.met = 0
        self.followed: list[Followed] = []
        self.drift = Drift(self.parameters.geometry.balls)
        self.apart = 0.0  # how far [m] balls of the last part were off in flight
        self.probing = False  # whether it looks for that in this part
        self.diverged = False  # whether bumps of balls were seen to carry an error on and more
        self.grew, self.reached = 1.0, 0.0  # times that meetings made an error; what a copy was off after them
        self.adrift = False  # whether more came that none looked at
        self.spare = 1.0  # times the errors of the last part: still less than those that were looked at

    def memory(self) -> dict:
        """What it knows of the run, as plain data; see `remember`."""
        return {name: getattr(self, name) for name in KEPT} | {
            "best": self.best.tolist(),
            "followed": [[*one[:2], [array.tolist() for array in one.last], *one[3:]] for one in self.followed],
            "drift": self.drift.memory(),
        }

    def remember(self, kept: dict) -> None:
        """Goes on from what `memory` gave; raises KeyError, TypeError or ValueError for anything else."""
        vars(self).update((name, kind(kept[name])) for name, kind in KEPT.items())
        self.best = np.array(kept["best"], float).reshape(POINTERS, MOST)
        self.followed = [
            Followed(int(ball), float(begin), tuple(np.array(array, float) for array in last), *map(float, rest))
            for ball, begin, last, *rest in kept["followed"]
        ]
        self.drift.remember(kept["drift"])

    def inherited(self) -> tuple:
        """What it carries from part to part of the motion; see `inherit`."""
        return self.followed, self.drift.memory(), self.met, self.best.copy()

    def inherit(self, kept: tuple) -> None:
        """Back to what `inherited` gave, to look at a part once more."""
        self.followed, drift, self.met, best = kept
        self.best = best.copy()
        self.drift.remember(drift)

    def windows(self, part: Part) -> list[Window]:
        """Where this part is worth a look: for each pointer apart from each other in time."""
        found: list[Window] = []
        grids, steps = self._pointers(part)
        met, whole, planned = meetings(part), part.partners.active, 0.0
        fewest = min(LEAST_STEPS, steps.sum(axis=1).min())
        some_cheap = not whole and self.parts < EARLY and fewest <= CHEAP * part.taken
        for place, grid in enumerate(grids):
            mine: list[Window] = []
            worth = np.flatnonzero(grid > (LIKE if some_cheap else RAISED) * self.best[place].min())
            for flat in worth[np.argsort(-grid.flat[worth], kind="stable")][:CANDIDATES].tolist():
                row, cell = divmod(flat, grid.shape[1])
                good = self._worth(place, grid[row, cell], part, mine, planned)
                if len(mine) == MOST or not (good or some_cheap):
                    break
                window = as_met(window_at(ALL if whole else row, cell, steps[row]), met)
                good = good or steps_in(window, row, steps) <= CHEAP * part.taken
                if good and not any(overlap(window, other) for other in mine):
                    mine.append(window)
                    if not any(within(window, other) for other in found):
                        found.append(window)
                        planned += self._see(window, row, grids, steps)
        self.spare = spare(self.best, grids) if len(part.pointer) else 1.0
        self.parts += 1
        self.probing = self._probes(part)
        if self.probing:
            found = [window_at(ALL, 0, steps[0]), *found]
        elif (self.parts > 1 or not found) and self.parts.bit_count() == 1 and ALL not in {one.ball for one in found}:
            calm = int(steps.sum(axis=1).argmin())
            window = as_met(window_at(ALL if whole else calm, len(part.times) - 1, steps[calm]), met)
            found += [] if any(within(window, other) for other in found) else [window]
        return found if whole else one_for_all(found, grids, steps)

    def see_again(self, part: Part, windows: list[Window]) -> None:
        """Keeps what the pointers say in windows of a part that was done again."""
        grids, steps = self._pointers(part)
        for window in windows:
            self._see(window, window.ball, grids, steps)

    def _see(self, window: Window, row: int, grids: tuple[np.ndarray, ...], steps: np.ndarray) -> float:
        """Keeps what the pointers say in a window that is looked at; the steps that the run took in it."""
        inside = slice(window.begin + 1, window.begin + 1 + window.length)
        rows = slice(None) if window.ball == ALL else slice(row, row + 1)
        for place, grid in enumerate(grids):
            self.best[place] = np.sort([*self.best[place], grid[rows, inside].max()])[1:]
        return steps_in(window, row, steps)

    def _worth(self, place: int, points: float, part: Part, mine: list[Window], planned: float) -> bool:
        """Whether a window is worth its steps, those `planned` in this part included: the first always is."""
        best = self.best[place]
        if self.looked + planned > LOOKING * part.taken or any(one.ball == ALL for one in mine):
            return points > FAR_RAISED * best.max()
        return points > RAISED * best.min()

    def _pointers(self, part: Part) -> tuple[tuple[np.ndarray, ...], np.ndarray]:
        self.greatest_load = max(self.greatest_load, float(part.out["normal_load"].max()))
        return pointers(part, LEAST_LOAD * self.greatest_load)

    def look(self, part: Part, windows: list[Window], scales: np.ndarray, tolerance: float) -> np.ndarray:
        """Rows of WINDOW for these windows of a run with these scales and this tolerance; infinite for what breaks off.

        Then the balls that are off at the end are followed to the end of the part.
        """
        rows, off, self.apart = [], [], 0.0
        met = meetings(part)
        self.drift.begin(copied_from(met, self.met))
        for group in together(part, windows):
            whole = group[0].ball < 0
            found = all_beside(self.parameters, part, group[0], scales) if whole else some_beside(part, group, scales)
            if found is None:
                rows += [nowhere(part, window, tolerance) for window in group]
                continue
            self.steps += found.steps
            self.looked += found.steps
            each = found.steps / (len(part.near) if whole else len(group))
            for place, window in enumerate(group):
                begin = part.elapsed + part.start(window.begin)
                rows.append(self._row(part, window, begin, each, tolerance, found, None if whole else place))
                self.drift.see(part, window, found, 0 if whole else place, 1.0 / (1.0 - TIGHTER))
                left = left_over(part, window, found, place, self._allowed)
                if left > BEARABLE or loose(part, window) or self.probing:
                    off.append((left, window, begin, self._off(rows[-1])))
        rows += self._follow(part, off, scales, tolerance, met)
        rows += self._parted(part, scales, tolerance, met)
        self.drift.go_on(part, {one.ball for one in self.followed})
        rows.sort(key=lambda row: row[:3])
        return np.array(rows).reshape(-1, len(WINDOW.columns))

    def _probes(self, part: Part) -> bool:
        """Whether it is to be seen, until it is, what becomes of errors where balls bump.

        In the parts 1, 2, 4, 8 ... and where steps allow to follow half of a part.
        """
        if not bumps(self.parameters) or self.diverged:
            return False
        far = affordable(part, Window(ALL, -1, len(part.times)), THREATENED * part.taken - self.steps)
        return self.parts & (self.parts - 1) == 0 or 2 * far.length >= len(part.times)

    def _off(self, row: list[float]) -> float:
        return off_by(np.array(row), self.greatest_load or 1.0) / self.parameters.wanted.tolerance

    def _row(self, part, window, begin, each, tolerance, found, place) -> list[float]:
        end = part.elapsed + part.start(window.begin + window.length)
        off = deviations(part, window, found, place, self.greatest_load)
        flight = off_in_flight(part, window, found, place) * (1.0 if begin <= part.elapsed else BUMPING)
        self.apart = max(self.apart, flight / (1.0 - TIGHTER))
        return [end, begin, window.ball, each, tolerance, *(one / (1.0 - TIGHTER) for one in off)]

    def _follow(self, part: Part, off: list, scales, tolerance: float, met: np.ndarray) -> list[list[float]]:
        """Goes on with what was followed, and with what was found `off`, worst first, as far as steps allow.

        Where bumps are to be seen, those come first that most of a part is left for.
        """
        rows, before, self.followed = [], self.followed, []
        whole = Window(-1, -1, len(part.times))
        those = [(one.left, whole._replace(ball=one.ball), one.begin, one.first, one.last) for one in before]
        off.sort(key=lambda one: (one[2],) if self.probing else (-one[0], one[1]))
        those += [(left, at, begin, np.inf, None) for left, at, begin in bouncing(part)]
        those += [(left, *to_the_end(part, at, begin), first, None) for left, at, begin, first in off]
        for left, there, begin, first, last in those:
            window = until_met(there, met)
            taken = any(one.ball in (window.ball, -1) for one in self.followed) or len(self.followed) == AT_A_TIME
            threatened = left > 1.0 or left == UNKNOWN or loose(part, window) or (self.probing and window.ball == ALL)
            share = THREATENED if threatened else FOLLOWING
            room = (BOUNCING if left == UNKNOWN else THREATENED) * part.taken - self.steps
            spent = self.steps > share * part.taken or (self.diverged and window.ball == ALL)
            asked, window = window, affordable(part, window, room / DEARER)
            spent = spent or (left == UNKNOWN and window != asked)
            if taken or spent or (part.partners.active and window.ball != ALL) or not window.length:
                continue
            alone, ends = window.ball != ALL, window.begin + 1 + window.length == len(part.times)
            what = scales, last, (until := part.duration if ends else None)
            found = some_beside(part, [window], *what) if alone else all_beside(self.parameters, part, window, *what)
            if found is None:
                continue
            self.steps += found.steps
            each = found.steps if alone else found.steps / len(part.near)
            rows.append(self._row(part, window, begin, each, tolerance, found, 0 if alone else None))
            self.drift.see(part, window, found, 0, 1.0 / (1.0 - TIGHTER))
            left = left_over(part, window, found, 0, self._allowed)
            self.diverged |= bumps(self.parameters) and self._off(rows[-1]) > max(1.0, BUMPING * first)
            if until and (left > BEARABLE or loose(part, window)):
                self.followed.append(Followed(window.ball, begin, found.last, left, first))
        return rows

    def _parted(self, part: Part, scales, tolerance: float, met: np.ndarray) -> list[list[float]]:
        """Rows of a copy that starts apart by what balls are off, before they may first have met in a part and after.

        It goes on, twice as far each time, until it is off by more than is wanted, or has taken its share of steps.
        Looked at are the parts 1, 2, 4, 8 ... with meetings. Balls next to each other start off the other way.
        """
        copied = copied_from(met, self.met)
        self.met += int(met.any())
        # The next meetings do the same again to what is off after those that a copy went through.
        far = self.grew > MET or self.grew * self.reached > self.parameters.wanted.tolerance
        self.adrift = far and bool(met.any())
        if copied is None:
            return []
        rows, taken, stretches, first = [], 0, stretches_from(met), np.inf
        window = next(stretches)
        begin = part.elapsed + part.start(window.begin)
        moving, borders = starts(part, [window._replace(ball=ball) for ball in range(len(part.near))])
        self.drift.set_apart(moving[0], begin, tolerance)
        self.drift.begin(None)
        last = (*moving, borders[0])
        while window is not None and taken <= COPYING * part.taken:
            found = all_beside(self.parameters, part, window, scales / TIGHTER, last)
            if found is None:
                return [*rows, nowhere(part, window, tolerance)]
            last, taken = found.last, taken + found.steps
            rows.append(self._row(part, window, begin, found.steps / len(part.near), tolerance, found, None))
            self.drift.see(part, window, found, 0, 1.0)
            off = max(off_by(np.array(rows[-1]), self.greatest_load or 1.0), FLOOR)
            first = min(first, off)
            self.grew, self.reached = max(self.grew, off / first), max(self.reached, off)
            window = next(stretches, None) if off <= self.parameters.wanted.tolerance else None
        self.steps += taken
        self.adrift = self.grew > MET and window is not None and bool(met[window.begin + 1 :].any())
        return rows
