"""A companion of a bearing run: windows of it integrated again with a tighter tolerance, from the run's own states.

The difference is the error that the run makes within a window, once the window is several steps long (shorter ones
measure their own ends). Windows are few: they end where the steps' own error estimates (`pointing`) do most to a ball's
force or torque, as far as those exceed what was looked at before in the run; and one more after 1, 2, 4, 8 ... parts,
where steps are longest. Balls on their own are taken one by one, many in one call; coupled ones, which touch or meet a
moving ring or a cage, all together. What error the start of a window has from before, no window sees. Where the motion
is still off at the end of a window, or a ball is loose, the companion goes on beside the run, with that ball or with
all, until neither holds, or it has taken its share of steps: what is found is then a lower bound.
"""

from typing import NamedTuple

import numpy as np

from bearing_twin.kinds.bearing.deviations import LEAST_LOAD, Found, Part, deviations, left_over
from bearing_twin.kinds.bearing.integrate import Chunk, integrated
from bearing_twin.kinds.bearing.layout import BORDER, CARRIED_COLUMNS, COLUMNS
from bearing_twin.kinds.bearing.outputs import empty_outputs, outputs_alone, write_outputs
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.pointing import OF_FORCE, OF_TORQUE, STEPS_IN
from bearing_twin.kinds.bearing.rosenbrock import ChunkTask, rosenbrock_chunk
from bearing_twin.kinds.bearing.steps import STEPS, Results
from bearing_twin.kinds.bearing.windows import LEAST_STEPS, WINDOW, Window, bend, overlap, window_at, within
from bearing_twin.numerics.statuses import OK
from bearing_twin.numerics.steppers import ROSENBROCK

METHOD = "rodas4"  # of the companion, whatever the run's
TIGHTER = 0.3  # of the run's tolerance: what the companion errs by itself is as great a share, and is added
MOST = 3  # windows looked at for force, and for torque, whatever the length of the run, unless later ones exceed them
RAISED, FAR_RAISED = 1.2, 3.0  # times the least of those: worth a look; times the greatest: whatever it costs
LOOKING = 0.2  # of the run's steps: where more were spent, only that is looked at which exceeds all before by far
INHERITED = 0.1  # of the wanted tolerance: what a motion may be off at the end of a window without being followed
AT_A_TIME = 2  # balls that are followed
FOLLOWING = 0.15  # of the run's steps: where more were spent, nothing more is followed ...
THREATENED = 0.6  # ... unless it is off by the tolerance, or loose: then where so many were


class Followed(NamedTuple):
    """A ball (-1: all) with which the companion goes on from part to part, since `begin` [s].

    Arrays as in `Found.last`; `left` is what its motion was off at the end, over what is allowed.
    """

    ball: int
    begin: float
    last: tuple[np.ndarray, ...]
    left: float


class Companion:
    """Looks at parts of a run and keeps rows of WINDOW; the same parts give the same rows.

    `unit` (MOTION,) are the errors of a ball's motion that a tolerance of 1 allows.
    """

    def __init__(self, parameters: BearingScene, unit: np.ndarray):
        self.parameters = parameters
        self.unit = unit
        self.reset()

    def reset(self) -> None:
        """Forgets the run."""
        self.best = np.zeros((2, MOST))
        self.greatest_load = 0.0
        self.steps = self.parts = 0
        self.followed: list[Followed] = []

    def memory(self) -> dict:
        """What it knows of the run, as plain data; see `remember`."""
        return {
            "best": self.best.tolist(),
            "greatest_load": self.greatest_load,
            "steps": self.steps,
            "parts": self.parts,
            "followed": [[one.ball, one.begin, [a.tolist() for a in one.last], one.left] for one in self.followed],
        }

    def remember(self, kept: dict) -> None:
        """Goes on from what `memory` gave; raises KeyError, TypeError or ValueError for anything else."""
        self.best = np.array(kept["best"], float).reshape(2, MOST)
        self.greatest_load = float(kept["greatest_load"])
        self.steps, self.parts = int(kept["steps"]), int(kept["parts"])
        self.followed = [
            Followed(int(ball), float(begin), tuple(np.array(array, float) for array in last), float(left))
            for ball, begin, last, left in kept["followed"]
        ]

    def windows(self, part: Part) -> list[Window]:
        """Where this part is worth a look: for force and for torque apart from each other in time."""
        found: list[Window] = []
        grids, steps = self._pointers(part)
        for place, grid in enumerate(grids):
            mine: list[Window] = []
            for flat in np.argsort(-grid, axis=None, kind="stable"):
                row, cell = (int(one) for one in np.unravel_index(flat, grid.shape))
                if len(mine) == MOST or not self._worth(place, grid[row, cell], part, mine):
                    break
                window = window_at(-1 if part.coupled else row, cell, steps[row])
                if not any(overlap(window, other) for other in mine):
                    self.best[place] = np.sort([*self.best[place], grid[row, cell]])[1:]
                    mine.append(window)
            found += [one for one in mine if not any(within(one, other) for other in found)]
        self.parts += 1
        if self.parts & (self.parts - 1) == 0 and not (part.coupled and found):
            calm = int(steps.sum(axis=1).argmin())
            window = window_at(-1 if part.coupled else calm, len(part.times) - 1, steps[calm])
            found += [] if any(within(window, other) for other in found) else [window]
        return found

    def _worth(self, place: int, points: float, part: Part, mine: list[Window]) -> bool:
        """Whether a window is worth its steps, those found in this part included: the first always is."""
        best = self.best[place]
        if self.steps > LOOKING * part.taken or (part.coupled and mine):
            return points > FAR_RAISED * best.max()
        return points > RAISED * best.min()

    def _pointers(self, part: Part) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray]:
        """What points to errors of force [N] and of torque over mu N R, and steps, each (balls or 1, cells)."""
        load = part.out["normal_load"].sum(axis=2).T
        self.greatest_load = max(self.greatest_load, float(part.out["normal_load"].max()))
        if len(part.pointer):
            force, torque, steps = (part.pointer[:, :, place] for place in (OF_FORCE, OF_TORQUE, STEPS_IN))
        else:
            force, torque = (bend(array) for array in (part.out["raceway_force"], part.out["raceway_torque"]))
            steps = np.full(force.shape, float(LEAST_STEPS))
        torque = torque / np.maximum(load, LEAST_LOAD * self.greatest_load)
        grids = force, torque
        if part.coupled:
            grids, steps = tuple(one.max(axis=0)[None] for one in grids), steps.max(axis=0)[None]
        return grids, steps

    def look(self, part: Part, windows: list[Window], scales: np.ndarray, tolerance: float) -> np.ndarray:
        """Rows of WINDOW for these windows of a run with these scales and this tolerance; infinite for what breaks off.

        Then the balls that are off at the end are followed to the end of the part.
        """
        rows, off = [], []
        for group in _together(part, windows):
            whole = group[0].ball < 0
            found = self._all_balls(part, group[0], scales) if whole else self._balls(part, group, scales)
            if found is None:
                rows += [_nowhere(part, window, tolerance) for window in group]
                continue
            self.steps += found.steps
            each = found.steps / (len(part.near) if whole else len(group))
            for place, window in enumerate(group):
                begin = part.elapsed + part.start(window.begin)
                rows.append(self._row(part, window, begin, each, tolerance, found, None if whole else place))
                left = left_over(part, window, found, place, self._allowed)
                if left > INHERITED or _loose(part, window):
                    off.append((left, window, begin))
        rows += self._follow(part, off, scales, tolerance)
        rows.sort(key=lambda row: row[:3])
        return np.array(rows).reshape(-1, len(WINDOW.columns))

    @property
    def _allowed(self) -> np.ndarray:
        return self.parameters.wanted.tolerance * self.unit

    def _row(self, part, window, begin, each, tolerance, found, place) -> list[float]:
        end = part.elapsed + part.start(window.begin + window.length)
        off = deviations(part, window, found, place, self.greatest_load)
        return [end, begin, window.ball, each, tolerance, *(one / (1.0 - TIGHTER) for one in off)]

    def _follow(self, part: Part, off: list, scales, tolerance: float) -> list[list[float]]:
        """Goes on with what was followed, and with what was found `off`, worst first, as far as steps allow."""
        rows, before, self.followed = [], self.followed, []
        whole = Window(-1, -1, len(part.times))
        those = [(one.left, whole._replace(ball=one.ball), one.begin, one.last) for one in before]
        new = sorted(off, key=lambda one: (-one[0], one[1]))
        those += [(left, at._replace(length=len(part.times) - 1 - at.begin), begin, None) for left, at, begin in new]
        for left, window, begin, last in those:
            taken = any(one.ball in (window.ball, -1) for one in self.followed) or len(self.followed) == AT_A_TIME
            share = THREATENED if left > 1.0 or _loose(part, window) else FOLLOWING
            spent = self.steps > share * part.taken
            if taken or spent or (part.coupled and window.ball >= 0):
                continue
            alone = window.ball >= 0
            found = (
                self._balls(part, [window], *(scales, last, part.duration))
                if alone
                else self._all_balls(part, window, scales, last, part.duration)
            )
            if found is None:
                continue
            self.steps += found.steps
            each = found.steps if alone else found.steps / len(part.near)
            rows.append(self._row(part, window, begin, each, tolerance, found, 0 if alone else None))
            left = left_over(part, window, found, 0, self._allowed)
            if left > INHERITED or _loose(part, window):
                self.followed.append(Followed(window.ball, begin, found.last, left))
        return rows

    def _balls(self, part: Part, group: list[Window], scales, last=None, until: float | None = None) -> Found | None:
        """Single balls side by side, from the run's states or from the `last` of the companion; None if one fails.

        `until` [s] in the part they go on, without it to the end of the windows.
        """
        first, count = group[0], len(group)
        start, length = part.start(first.begin), first.length
        times = part.times[first.begin + 1 : first.begin + 1 + length] - start
        begun, borders = _starts(part, group)
        moving = begun if last is None else tuple(array.copy() for array in last[:4])
        results = _room(length, count, moving[3], borders[0])
        drive, bearing = part.drive_from(start), part.bearing
        duration = float(times[-1]) if until is None else until - start
        task = ChunkTask(ROSENBROCK[METHOD], bearing, drive, times, duration, TIGHTER * scales)
        if rosenbrock_chunk(task, (), np.arange(count), *moving[:3], results) != OK:
            return None
        out = outputs_alone(bearing, drive, times, results.states, results.orientations, borders)
        return Found(out, results.states, (*moving, borders[0]), int(results.counts[STEPS]))

    def _all_balls(self, part: Part, window: Window, scales, last=None, until: float | None = None) -> Found | None:
        """As `_balls`, of all balls with ring and cage in one window."""
        start, length, balls = part.start(window.begin), window.length, len(part.near)
        times = part.times[window.begin + 1 : window.begin + 1 + length] - start
        moving, borders = _starts(part, [Window(ball, window.begin, length) for ball in range(balls)])
        moving = (*moving, borders[0].copy()) if last is None else tuple(array.copy() for array in last)
        moving[2][:] = moving[2].min()
        results, partners = _room(length, balls, moving[3], moving[4]), part.partners
        partners = partners._replace(load=partners.load + start * partners.load_rate, scales=TIGHTER * partners.scales)
        drive = part.drive_from(start)
        duration = float(times[-1]) if until is None else until - start
        chunk = Chunk(part.bearing, drive, partners, part.near, times, duration, 0.0, TIGHTER * scales)
        if integrated(METHOD, chunk, moving[:3], results) != OK:
            return None
        out = empty_outputs(self.parameters, length)
        filled = results.states, results.orientations, results.border
        write_outputs(self.parameters, part.bearing, partners, drive, times, *filled, out.numbers, 0)
        return Found(out, results.states, moving, int(results.counts[STEPS]))


def _loose(part: Part, window: Window) -> bool:
    """Whether the ball of a window touches neither raceway at an output from there on: bounces make errors grow."""
    load = part.out["normal_load"][max(window.begin, 0) :, window.ball]
    return window.ball >= 0 and bool((load.max(axis=1) == 0.0).any())


def _nowhere(part: Part, window: Window, tolerance: float) -> list[float]:
    """The row of a window in which no motion goes on from the run's state: it can be off by anything."""
    begin, end = (part.elapsed + part.start(at) for at in (window.begin, window.begin + window.length))
    return [end, begin, window.ball, 0.0, tolerance] + [np.inf] * (len(WINDOW.columns) - 5)


def _together(part: Part, windows: list[Window]) -> list[list[Window]]:
    """Windows of single balls that one call can integrate: equally long, from one instant where the drive accelerates.

    Those that begin with the part may have a first output sooner.
    """
    groups: dict[tuple, list[Window]] = {}
    for number, window in enumerate(windows):
        alike = window.begin if part.drive.acceleration else window.begin < 0
        groups.setdefault((window.length, alike, number if window.ball < 0 else -1), []).append(window)
    return list(groups.values())


def _starts(part: Part, group: list[Window]):
    """Where windows begin: (state, orientation, step sizes, what laws carry), then ring and cage, one row a window.

    What a law carries is known at the beginning of a part alone; elsewhere it begins anew. The first step is half the
    run's there.
    """
    state, orientation, steps, carried, border = part.begun
    states, orientations, borders = part.filled
    rows = []
    for ball, begin, length in group:
        if begin < 0:
            rows.append((state[ball], orientation[ball], 0.5 * steps[ball], carried[ball], border))
            continue
        step, rest = steps[ball], slice(begin + 1, begin + 1 + length)
        if len(part.pointer):
            step = (part.times[rest][-1] - part.times[begin]) / max(part.pointer[ball, rest, STEPS_IN].sum(), 1.0)
        rows.append(
            (states[begin, ball], orientations[begin, ball], 0.5 * step, np.zeros(CARRIED_COLUMNS), borders[begin])
        )
    *moving, rings = (np.array(column) for column in zip(*rows, strict=True))
    return tuple(moving), rings


def _room(length: int, balls: int, carried: np.ndarray, border: np.ndarray) -> Results:
    """Empty results of so many instants and balls."""
    return Results(
        np.empty((length, balls, COLUMNS)),
        np.empty((length, balls, 4)),
        np.zeros(4, np.int64),
        np.zeros(2),
        np.zeros(1, np.uint8),
        carried,
        np.tile(border, (length, 1)).reshape(length, BORDER),
        border,
        np.zeros((0, 0, 0)),
    )
