"""What acts from outside over time on a body that moves: the scene's own loads, or what is commanded in their place."""

import math

import numpy as np

NEVER = math.inf
SAME = 1e-12  # relative: instants nearer than this are one


class Loading:
    """Loads (5,) [N, N m] over time on the body of a section with the keys `load`, `moment`, `change` and `table`."""

    def __init__(self, section):
        self.load = np.array([*section.load, *section.moment])
        self.change = np.array([*section.change.load, *section.change.moment])
        self.change_time = section.change.time or NEVER
        self.knots, self.commanded = np.array(section.table).reshape(-1, 6), False
        self.times = apart(self.knots[:, 0], [section.change.time] if section.change.time else [])

    def __copy__(self) -> "Loading":
        """The same, to be commanded by itself: in a fifth of the time of Python's own copy, as every start does it."""
        found = object.__new__(type(self))
        vars(found).update(vars(self))
        return found

    def set(self, force, moment) -> None:
        """From now on force [N] (3,) and moment [N m] (2 or 3,) act in place of the scene's."""
        self.load = np.array([*force, *moment], float)[:5]
        self.change_time, self.knots, self.commanded = NEVER, np.empty((0, 6)), True
        self.times = np.empty(0)

    def until_next(self, elapsed: float) -> float:
        """Seconds until the load jumps, or grows otherwise."""
        return next_after(self.times, elapsed) - elapsed

    def at(self, elapsed: float) -> tuple[np.ndarray, np.ndarray]:
        """Load (5,) at `elapsed` [s] and its rate (5,), which hold until the next jump."""
        jumped = elapsed >= self.change_time * (1.0 - SAME)
        load = self.load + self.change if jumped else self.load
        more, rate = between(self.knots, elapsed)
        return load if more is None else load + more, rate


def apart(*times) -> np.ndarray:
    """All of these times [s] in rising order, once each where they are one."""
    found = np.unique(np.concatenate(times))
    return found[np.diff(found, prepend=-NEVER) > SAME * found] if len(found) else found


def next_after(times: np.ndarray, elapsed: float) -> float:
    """The first of rising `times` (n,) [s] that is later than `elapsed`, NEVER where none is."""
    row = int(np.searchsorted(times, elapsed * (1.0 + SAME), side="right"))
    return float(times[row]) if row < len(times) else NEVER


def between(knots: np.ndarray, elapsed: float) -> tuple[np.ndarray | None, np.ndarray]:
    """What a table (n, 1 + m), time first, has at `elapsed` [s], None where it has no row, and its rate (m,)."""
    rate = np.zeros(knots.shape[1] - 1)
    if not len(knots):
        return None, rate
    row = int(np.searchsorted(knots[:, 0], elapsed * (1.0 + SAME), side="right")) - 1
    if row < 0 or row + 1 == len(knots):
        return knots[max(row, 0), 1:], rate
    rate = (knots[row + 1, 1:] - knots[row, 1:]) / (knots[row + 1, 0] - knots[row, 0])
    return knots[row, 1:] + rate * (elapsed - knots[row, 0]), rate
