"""A companion of a bearing run: windows of it integrated again with a tighter tolerance, from the run's own states.

The difference is the error that the run makes within a window, once the window is several steps long (shorter ones
measure their own ends). Windows are few: they end where the steps' own error estimates (`pointing`) do most to a ball's
force or torque, or slip to friction, as far as that exceeds what was looked at before in the run; and one more
after 2, 4, 8 ... parts, where steps are longest. Balls on their own are taken one by one, many in one call; coupled
ones, which meet, a moving ring or a cage, all together. What its start has from before, no window sees. Where the
motion is still off at the end, or a ball is loose, the companion goes on beside the run until neither holds, or it has
taken its share of steps: a lower bound. Balls in flight are followed side by side, or looked at as they take off. Where
balls meet, a copy of the run that starts apart by what it is off shows what becomes of that; where a ring is thrown,
a motion that sets out before (`throws`). Where balls bump into a cage, all are integrated beside the run (`second`)
until bumps are seen to carry errors on (`diverged`).
"""

import numpy as np

from bearing_twin.kinds.bearing.companion.beside import TIGHTER, all_beside, some_beside
from bearing_twin.kinds.bearing.companion.departures import (
    Followed,
    affordable,
    all_start,
    bouncing,
    followed_as,
    loose,
    nowhere,
    taking_off,
    to_the_end,
    together,
)
from bearing_twin.kinds.bearing.companion.deviations import Found, Part, deviations, left_over, off_in_flight
from bearing_twin.kinds.bearing.companion.growth import BUMPED, FLOOR, MET
from bearing_twin.kinds.bearing.companion.looking import EARLY, LOOKING, Looking
from bearing_twin.kinds.bearing.companion.meetings import (
    COPYING,
    Drift,
    first_met,
    meetings,
    stretches_from,
    until_met,
)
from bearing_twin.kinds.bearing.companion.pointers import MOST, POINTERS
from bearing_twin.kinds.bearing.companion.second import Second
from bearing_twin.kinds.bearing.companion.throws import Throw, Throws
from bearing_twin.kinds.bearing.companion.windows import ALL, BUMPING, PLACE, WINDOW, Window, bumps, off_by, within
from bearing_twin.kinds.bearing.forces.layout import MOTION
from bearing_twin.kinds.bearing.parameters import LOADS, BearingScene
from bearing_twin.kinds.bearing.stepping.pointing import STEPS_IN

BEARABLE = 0.1  # of the wanted tolerance: what a motion may be off at the end of a window without being followed
AT_A_TIME = 2  # balls that are followed
FOLLOWING = 0.1  # of the run's steps: where more were spent, nothing more is followed ...
THREATENED = 0.33  # ... unless it is off by the tolerance, or loose, or `second`: then where so many were
BOUNCING = 0.45  # ... or would be, with a ball that bounces although nothing points to it: it may rule a short run
# Times the run's steps: what a companion takes, at a third of the tolerance by a method of fourth order; by all balls
# that a ring couples, where it rings on.
DEARER, TOGETHER = 1.35, 1.6
KEPT = {"greatest_load": float, "steps": int, "looked": int, "parts": int, "met": int, "diverged": bool}
KEPT |= {"grew": float, "reached": float}


class Companion(Looking):
    """Looks at parts of a run and keeps rows of WINDOW; the same parts give the same rows.

    `unit` (MOTION,) are the errors of a ball's motion that a tolerance of 1 allows.
    """

    def __init__(self, parameters: BearingScene, unit: np.ndarray):
        self.parameters = parameters
        self._allowed = parameters.wanted.tolerance * unit
        self.reset()

    def reset(self) -> None:
        """Forgets the run."""
        super().reset()
        self.steps = self.met = 0
        self.followed: list[Followed] = []
        self.drift = Drift(self.parameters.geometry.balls)
        self.second, self.throws = Second(self.parameters), Throws(self.parameters)
        self.apart, self.diverged = 0.0, False  # how far [m] balls were off in flight; whether bumps made an error grow
        self.grew, self.reached = 1.0, 0.0  # times that meetings made an error; what a copy was off after them
        self.unlooked, self.adrift = np.inf, False  # since when balls met where none looked; if that may be too much

    @property
    def unknown(self) -> tuple[float, float, bool]:
        """Since when [s] balls met unseen, the greatest load [N] so far, and whether it may err by as much by that."""
        return self.unlooked, self.greatest_load, self.adrift

    def memory(self) -> dict:
        """What it knows of the run, as plain data; see `remember`."""
        return {name: getattr(self, name) for name in KEPT} | {
            "best": self.best.tolist(),
            "followed": [[*one[:2], [array.tolist() for array in one.last], one.left] for one in self.followed],
            "drift": self.drift.memory(),
            "second": self.second.memory(),
            "earlier": self.throws.earlier.memory(),
            "growth": self.growth.memory(),
        }

    def remember(self, kept: dict) -> None:
        """Goes on from what `memory` gave; raises KeyError, TypeError or ValueError for anything else."""
        vars(self).update((name, kind(kept[name])) for name, kind in KEPT.items())
        self.best = np.array(kept["best"], float).reshape(POINTERS, MOST)
        self.followed = [followed_as(told, self.parameters.geometry.balls) for told in kept["followed"]]
        self.drift.remember(kept["drift"])
        self.second.remember(kept.get("second", []))
        self.throws.earlier.remember(kept.get("earlier", []))
        self.growth.remember(kept.get("growth", self.growth.memory()))

    def inherited(self) -> tuple:
        """What it carries from part to part of the motion; see `inherit`."""
        return self.followed, self.drift.memory(), self.met, self.best.copy()

    def inherit(self, kept: tuple) -> None:
        """Back to what `inherited` gave, to look at a part once more."""
        self.followed, drift, self.met, best = kept
        self.best = best.copy()
        self.drift.remember(drift)

    def look(self, part: Part, windows: list[Window], scales: np.ndarray, tolerance: float) -> np.ndarray:
        """Rows of WINDOW for these windows of a run with these scales and this tolerance; infinite for what breaks off.

        Then the balls that are off at the end are followed to the end of the part.
        """
        off, self.apart, met = [], 0.0, meetings(part)
        self.drift.begin(self._copied(part, met))
        before, self.followed = self.followed, []
        those = [(one.left, Window(one.ball, -1, len(part.times)), one.begin, one.last) for one in before]
        rows = self._follow(part, those, scales, tolerance, met)
        flown, found = self._throws(part, scales, tolerance, met)
        rows += found
        ridden = {one.ball for one in (*self.followed, *flown)}
        windows = [one for one in windows if not any(within(one, other) for other in flown)]
        for window in taking_off(part, met, ridden, LOOKING * part.taken):
            windows += [] if any(within(window, other) for other in windows) else [window]
        for group in together(part, windows):
            whole = group[0].ball < 0
            each = [all_beside(self.parameters, part, group[0], scales)] if whole else some_beside(part, group, scales)
            for window, found in zip(group, each, strict=True):
                if found is None:
                    rows.append(nowhere(part, window, tolerance))
                    continue
                self.steps += found.steps
                self.looked += found.steps
                begin = part.elapsed + part.start(window.begin)
                rows.append(self._row(part, window, begin, tolerance, found))
                self.drift.see(part, window, found, 1.0 / (1.0 - TIGHTER))
                left = left_over(part, window, found, self._allowed)
                if left > BEARABLE or loose(part, window):
                    off.append((left, window, begin))
        off.sort(key=lambda one: (-one[0], one[1]))
        those = [(left, *to_the_end(part, at, begin), None) for left, at, begin in off]
        rows += self._follow(part, those, scales, tolerance, met)
        rows += self._parted(part, scales, tolerance, met)
        self.drift.go_on(part, {one.ball for one in self.followed})
        rows.sort(key=lambda row: row[:3])
        return np.array(rows).reshape(-1, len(WINDOW.columns))

    def _goes_beside(self, part: Part) -> bool:
        """Whether all balls are followed through a part: they may bump, or some fly, and steps are left for it.

        What is off bounces carry on, and at an output where a ball lands its load is another. Balls that fly are always
        followed through the first part. Beyond a horizon nobody is.
        """
        if bumps(self.parameters):
            return self.parts <= EARLY or self.steps <= THREATENED * part.taken
        if not part.flies or self._beyond(part):
            return False
        takes = DEARER * (part.pointer[..., STEPS_IN].sum() if len(part.pointer) else part.taken)
        return self.parts == 1 or self.steps + takes <= THREATENED * part.taken

    def go_beside(self, part: Part, scales, tolerance: float, ended: tuple, rows: np.ndarray) -> np.ndarray:
        """The rows of WINDOW of a part that stands, in time, with those of what goes beside balls that bump or fly.

        `ended` are states and border of the run at its end; see `Second`. Once errors are seen to grow, nothing goes
        beside it.
        """
        if self.diverged or not self._goes_beside(part):
            self.second.apart = None
            return rows
        second, shown, found = self.second, rows[rows[:, PLACE["ball"]] == ALL], []
        for window, one in second.through(part, ended, scales):
            self.steps += one.steps
            found.append(self._row(part, window, part.elapsed + part.start(window.begin), tolerance, one))
            second.shown = max(second.shown, self.off(shown[shown[:, 0] <= found[-1][0]]))
            self.diverged = self.off(found[-1]) > max(1.0, BUMPED * second.shown)
            if self.diverged:
                break
        second.shown = max(second.shown, self.off(shown))
        rows = np.concatenate([rows, np.array(found).reshape(-1, len(WINDOW.columns))])
        return rows[np.argsort(rows[:, 0], kind="stable")]

    def throw(self, part: Part, scales, again: bool) -> Throw | None:
        """What a more exact motion shows of a part in which a ring is thrown, see `Throws`; None of others."""
        found, steps = self.throws.through(part, scales, again, self.greatest_load)
        self.steps += steps
        if found:
            self.drift.see(part, found.window, found.found, 1.0 / (1.0 - TIGHTER))
        return found

    def off(self, rows) -> float:
        """The greatest error in rows of WINDOW over the wanted tolerance."""
        wanted = self.parameters.wanted
        return off_by(np.array(rows), self.greatest_load or 1.0, wanted.outputs == LOADS) / wanted.tolerance

    def _row(self, part: Part, window: Window, begin: float, tolerance: float, found: Found) -> list[float]:
        end, each = part.elapsed + part.start(window.begin + window.length), found.steps / found.states.shape[1]
        off = deviations(part, window, found, self.greatest_load)
        flight = off_in_flight(part, window, found) * (1.0 if begin <= part.elapsed else BUMPING)
        self.apart = max(self.apart, flight / (1.0 - TIGHTER))
        return [end, begin, window.ball, each, tolerance, *(one / (1.0 - TIGHTER) for one in off)]

    def _throws(self, part: Part, scales, tolerance: float, met: np.ndarray) -> tuple[list[Window], list[list[float]]]:
        """Goes with all balls that are seen in flight, side by side, as far as steps allow; their windows, and rows.

        Nothing need point to them: they may rule a short run.
        """
        ridden = {one.ball for one in self.followed}
        group = [] if self._beyond(part) else bouncing(part, met, ridden, (BOUNCING * part.taken - self.steps) / DEARER)
        if not group or ALL in ridden:
            return [], []
        until = part.duration if group[0].length == len(part.times) else None
        rows = []
        for window, found in zip(group, some_beside(part, group, scales, None, until), strict=True):
            if found is None:
                rows.append(nowhere(part, window, tolerance))
                continue
            self.steps += found.steps
            rows.append(self._row(part, window, part.elapsed, tolerance, found))
            self._keep_on(part, window, part.elapsed, found, until)
        return group, rows

    def _keep_on(self, part: Part, window: Window, begin: float, found: Found, until) -> None:
        """Takes in where a ball that was followed got to; it is followed further `until` [s] it is right again."""
        self.drift.see(part, window, found, 1.0 / (1.0 - TIGHTER))
        left = left_over(part, window, found, self._allowed)
        if until and (left > BEARABLE or loose(part, window)):
            self.followed.append(Followed(window.ball, begin, found.last, left))

    def _follow(self, part: Part, those: list, scales, tolerance: float, met: np.ndarray) -> list[list[float]]:
        """Goes on with `those`, as far as steps allow: what they are off, window, begin, from where."""
        rows = []
        for left, there, begin, last in those:
            window = until_met(there, met)
            full = last is None and len(self.followed) >= AT_A_TIME
            taken = any(one.ball in (window.ball, -1) for one in self.followed) or full
            share = THREATENED if left > 1.0 or loose(part, window) else FOLLOWING
            spent = self.steps > share * part.taken or self._beyond(part) or bumps(self.parameters)  # see `go_beside`
            dearer = TOGETHER if window.ball == ALL else DEARER
            window = affordable(part, window, (THREATENED * part.taken - self.steps) / dearer)
            if taken or spent or (part.partners.active and window.ball != ALL) or not window.length:
                continue
            alone, ends = window.ball != ALL, window.begin + 1 + window.length == len(part.times)
            what = scales, last, (until := part.duration if ends else None)
            found = some_beside(part, [window], *what)[0] if alone else all_beside(self.parameters, part, window, *what)
            if found is None:
                continue
            self.steps += found.steps
            rows.append(self._row(part, window, begin, tolerance, found))
            self._keep_on(part, window, begin, found, until)
        return rows

    def _parted(self, part: Part, scales, tolerance: float, met: np.ndarray) -> list[list[float]]:
        """Rows of a copy that starts apart by what balls are off, before they may first have met in a part and after.

        It goes on, twice as far each time, until it is off by more than is wanted, or has taken its share of steps.
        Balls next to each other start off the other way; or all as far off as a second motion beside the run was.
        """
        copied = self._copied(part, met)
        self.met += int(met.any())
        # The next meetings do the same again to what is off after them.
        far = self.grew > MET or self.grew * self.reached > self.parameters.wanted.tolerance
        self.unlooked = first_met(part, met, 0)
        self.adrift = far and self.unlooked < np.inf
        if copied is None:
            return []
        rows, taken, stretches, first = [], 0, stretches_from(met), np.inf
        window = next(stretches)
        begin = part.elapsed + part.start(window.begin)
        moving, border = all_start(part, window.begin, window.length)
        if window.begin < 0 and self.second.apart is not None:  # all that balls are off, across the raceways, too
            moving[0][:, :MOTION] += self.second.apart[0][:, :MOTION]
        else:
            self.drift.set_apart(moving[0], begin, tolerance)
        self.drift.begin(None)
        last = (*moving, border)
        while window is not None and taken <= (COPYING if self.grew <= MET else THREATENED) * part.taken:
            found = all_beside(self.parameters, part, window, scales, last)
            if found is None:
                return [*rows, nowhere(part, window, tolerance)]
            last, taken = found.last, taken + found.steps
            rows.append(self._row(part, window, begin, tolerance, found))
            self.drift.see(part, window, found, 1.0)
            off = max(self.off(rows[-1]) * self.parameters.wanted.tolerance, FLOOR)
            first = min(first, off)
            self.grew, self.reached = max(self.grew, off / first), max(self.reached, off)
            window = next(stretches, None) if off <= self.parameters.wanted.tolerance else None
        self.steps += taken
        self.unlooked = np.inf if window is None else first_met(part, met, window.begin + 1)
        self.adrift = self.unlooked < np.inf and self.grew > MET
        return rows
