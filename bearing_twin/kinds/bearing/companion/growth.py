"""Whether what a run is off grows by itself, so that its motion cannot be known beyond: the horizon.

Three kinds of rows tell: of balls that a companion follows, of a copy of the run that starts apart by what it is off
just before balls meet, and is looked at just after, and of what goes beside a run whose balls bump into a cage. A ball
that rolls forgets what it is off; one that bounces, or hits another or a cage, carries it on and more.
"""

import numpy as np

from bearing_twin.kinds.bearing.companion.redoing import SAFE
from bearing_twin.kinds.bearing.companion.windows import ALL, APART, BESIDE, PLACE, UNKNOWN, off_by
from bearing_twin.kinds.doubt import CHAOTIC, horizon

EVER = 1e9  # s: longer than any run
FLOOR = 1e-9  # of friction: rounding, as approaches are small differences of positions
MET = 100.0  # times, of a copy: within a millisecond or so, and the next meeting does the same again
UNSEEN = (
    "balls met after {:.4g} s where nobody looked, and earlier meetings made errors grow: beyond that the motion "
    "depends on what nobody can give exactly, and only statistics of many runs hold"
)
BEYOND = (
    "balls met after {:.4g} s, where a copy that started apart by what the run is off was off by more than a third of "
    "what is wanted: beyond that the motion depends on what nobody can give exactly, and only statistics of many runs "
    "hold"
)
BUMPED = 10.0  # times what any window shows, of what goes beside a run whose balls bump
# How many times errors grow, and beyond what share of the tolerance, where the run ends to be as exact as wanted.
HOW = {APART: (MET, SAFE, "balls met"), BESIDE: (BUMPED, 1.0, "steps made them")}
KEPT = {"grown": float, "kept": float, "since": str, "shown": float, "unlooked": float, "beyond": float, "seen": float}
MOST = 32  # balls with their begin whose first error is kept


class Growth:
    """Takes rows of WINDOW; those of one ball with one begin are of a companion that went on beside the run."""

    def __init__(self, tolerance: float, loads_alone: bool = False):
        self.tolerance, self.loads_alone = tolerance, loads_alone
        self.first: dict[tuple[int, float], tuple[float, float]] = {}  # error at first, and kept until [s]
        self.grown, self.kept, self.since = 0.0, 0.0, ""
        self.shown = FLOOR  # the most that a window of all balls is off
        self.unlooked = EVER  # since when [s] balls met where nobody looked, which counts once meetings are bad
        self.seen = EVER  # as `kept`, by what somebody looked at
        self.beyond = EVER  # since when [s] a copy was off by too much, which counts once errors grow

    def add(self, row, greatest: float) -> None:
        """Takes a row in; `greatest` load [N] so far."""
        off = max(off_by(row, greatest or 1.0, self.loads_alone), FLOOR)
        ball, begin, end = int(row[PLACE["ball"]]), float(row[PLACE["begin"]]), float(row[0])
        if ball == UNKNOWN:
            self.unlooked = min(self.unlooked, begin)
            if off > FLOOR:
                self._ends(self.unlooked, 1.0, "")
            return
        self.shown = max(self.shown, off if ball == ALL else 0.0)
        key = ball, 0.0 if ball == BESIDE else begin
        first, kept = self.first.pop(key, (off, begin))
        most, beyond, since = HOW.get(ball, (CHAOTIC, 1.0, "a companion began to follow a ball"))
        grown = off / (self.shown if ball == BESIDE else first)
        # What one copy shows, or one motion beside the run, is within a factor of three: another may show as much more.
        if off <= (SAFE if ball in HOW else 1.0) * self.tolerance:
            kept = end
        elif off > beyond * self.tolerance and grown > most:
            self._ends(min(kept, self.unlooked) if ball == APART else kept, grown, since)
        if ball == APART and off > beyond * self.tolerance:
            self.beyond = min(self.beyond, kept)
        self.first[key] = first, kept
        if len(self.first) > MOST:
            del self.first[next(iter(self.first))]

    def memory(self) -> dict:
        """What it knows, as plain data; see `remember`."""
        first = [[*key, *one] for key, one in self.first.items()]
        return {name: getattr(self, name) for name in KEPT} | {"first": first}

    def remember(self, kept: dict) -> None:
        """Goes on from what `memory` gave; raises KeyError, TypeError or ValueError for anything else."""
        vars(self).update((name, kind(kept[name])) for name, kind in KEPT.items())
        rows = [(int(ball), *map(float, rest)) for ball, *rest in kept["first"]]
        self.first = {(ball, begin): (off, until) for ball, begin, off, until in rows}

    def _ends(self, kept: float, grown: float, since: str) -> None:
        """Takes in that errors had grown so many times since then when they were last as wanted, at `kept` [s]."""
        self.seen = min(self.seen, kept) if since else self.seen
        if not self.grown or kept < self.kept:
            self.grown, self.kept, self.since = grown, kept, since

    @property
    def horizon_seen(self) -> float:
        """The horizon [s] by what somebody looked at alone; EVER where there is none."""
        return min(self.seen, self.beyond) if self.grown else EVER

    @property
    def horizon(self) -> float | None:
        """Up to when [s] the run is as exact as wanted; None where errors were not seen to grow by themselves."""
        return min(self.kept, self.beyond) if self.grown else None

    @property
    def notes(self) -> dict[str, str]:
        """The note on the horizon, if there is one."""
        if self.grown and self.beyond < self.kept:
            return {"horizon": BEYOND.format(self.beyond)}
        if self.grown and not self.since:
            return {"horizon": UNSEEN.format(self.kept)}
        return {"horizon": horizon(self.grown, self.since, self.kept)} if self.grown else {}


def greatest_until(rows, before, time_ns, load, begins) -> list[float]:
    """Greatest of the loads (outputs, balls, 2) [N] up to the end of the stretch in which each row of WINDOW ends.

    `before` is the greatest of earlier outputs. So it does not depend on how many stretches, which begin at the outputs
    `begins`, come at once.
    """
    greatest = np.maximum.accumulate(np.maximum.reduceat(load.max(axis=(1, 2)), begins))
    outputs = np.searchsorted(time_ns, np.rint(1e9 * rows[:, 0]))  # the first one at or after a record's time
    stretches = np.minimum(np.searchsorted(begins, outputs, side="right"), len(begins)) - 1
    return np.maximum(greatest[stretches], before).tolist()
