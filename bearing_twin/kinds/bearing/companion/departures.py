"""From where a companion of a bearing run sets out: the run's own states at the beginnings of windows, and room."""

from typing import NamedTuple

import numpy as np

from bearing_twin.kinds.bearing.companion.deviations import Part
from bearing_twin.kinds.bearing.companion.meetings import until_met
from bearing_twin.kinds.bearing.companion.windows import ALL, WINDOW, Window, steps_before, steps_in, window_at
from bearing_twin.kinds.bearing.forces.layout import BORDER, CARRIED_COLUMNS
from bearing_twin.kinds.bearing.stepping.pointing import STEPS_IN
from bearing_twin.kinds.bearing.stepping.steps import Results
from bearing_twin.numerics.lanes import COLUMNS

SETTLING = 3  # outputs for which a ball is still followed that has touched neither raceway


class Followed(NamedTuple):
    """A ball (-1: all) with which the companion goes on from part to part, since `begin` [s].

    Arrays as in `Found.last`; `left` is what its motion was off at the end, over what is allowed.
    """

    ball: int
    begin: float
    last: tuple[np.ndarray, ...]
    left: float


def followed_as(told: list, balls: int) -> Followed:
    """What plain data `told` of one of so many balls that is followed; raises TypeError or ValueError for another's."""
    ball, begin, last, left, *_ = told
    ball, last, rows = int(ball), tuple(np.array(array, float) for array in last), balls if ball == ALL else 1
    shapes = [(rows, COLUMNS), (rows, 4), (rows,), (rows, CARRIED_COLUMNS), (BORDER,)]
    if not ALL <= ball < balls or [array.shape for array in last] != shapes:
        raise ValueError("followed")
    return Followed(ball, float(begin), last, float(left))


def loose(part: Part, window: Window) -> bool:
    """Whether the ball of a window touches neither raceway at an output from there on: bounces make errors grow."""
    return window.ball >= 0 and part.flies and bool(part.in_flight[max(window.begin, 0) :, window.ball].any())


def bouncing(part: Part, met: np.ndarray, but: set[int], steps: float) -> list[Window]:
    """Windows, one for all, of balls that touch neither raceway at some outputs, `but` these; see `Companion._throws`.

    From the beginning of the part, where alone their states are known, until the last of them rests on a raceway. Balls
    that may have met another until then are left out; those that are longest in flight come first, as many as the run
    took so many `steps` with.
    """
    if part.partners.active or not part.flies or not len(part.pointer):
        return []
    free, outputs = part.in_flight, len(part.times)
    rest = np.minimum(outputs - np.argmax(free[::-1], axis=0) + SETTLING, outputs)
    taken: list[int] = []
    for ball in np.argsort(-free.sum(axis=0), kind="stable")[: int(free.any(axis=0).sum())].tolist():
        those = [*taken, ball]
        length = int(rest[those].max())
        apart = all(until_met(Window(one, -1, length), met).length == length for one in those)
        if ball not in but and apart and part.pointer[those, :length, STEPS_IN].sum() <= steps:
            taken = those
    return [Window(ball, -1, int(rest[taken].max())) for ball in taken]


def taking_off(part: Part, met: np.ndarray, but: set[int], steps: float) -> list[Window]:
    """Short windows of balls, `but` these, to where each touches neither raceway at an output for the first time.

    One that is off there may fly where it should roll: nothing drives it then, and it comes late to where it next bears
    load. The shortest, as many as the run took so many `steps` in; none of balls that may have met another.
    """
    if part.partners.active or not part.flies or not len(part.pointer):
        return []
    free = part.in_flight
    taken, balls = part.pointer[..., STEPS_IN], np.flatnonzero(free.any(axis=0)).tolist()
    ends = np.maximum(free.argmax(axis=0) - 1, 0).tolist()  # windows go on for an output behind their ends
    found = [window_at(ball, ends[ball], steps_before(taken[ball])) for ball in balls]
    found = [one for one in found if one.ball not in but and until_met(one, met) == one]
    found.sort(key=lambda one: steps_in(one, one.ball, taken))
    spent = np.cumsum([steps_in(one, one.ball, taken) for one in found])
    return found[: int(np.searchsorted(spent, steps, side="right"))]


def to_the_end(part: Part, window: Window, begin: float) -> tuple[Window, float]:
    """A window up to the end of its part, and since when [s]; of a loose ball from where the part begins.

    Only there the run's own state is known: outputs lie between its steps, and what they are off bounces make grow.
    """
    carried = part.all_bear or (part.load[max(window.begin, 0) :, window.ball] > 0.0).all()
    if window.ball >= 0 and not carried:
        return Window(window.ball, -1, len(part.times)), part.elapsed
    return window._replace(length=len(part.times) - 1 - window.begin), begin


def affordable(part: Part, window: Window, steps: float) -> Window:
    """The window, cut where the run took so many steps in it."""
    balls = slice(None) if window.ball < 0 else slice(window.ball, window.ball + 1)
    inside = slice(window.begin + 1, window.begin + 1 + window.length)
    taken = np.cumsum(part.pointer[balls, inside, STEPS_IN].sum(axis=0)) if len(part.pointer) else np.zeros(0)
    return window._replace(length=min(window.length, int(np.searchsorted(taken, steps))))


def nowhere(part: Part, window: Window, tolerance: float) -> list[float]:
    """The row of a window in which no motion goes on from the run's state: it can be off by anything."""
    begin, end = (part.elapsed + part.start(at) for at in (window.begin, window.begin + window.length))
    return [end, begin, window.ball, 0.0, tolerance] + [np.inf] * (len(WINDOW.columns) - 5)


def together(part: Part, windows: list[Window]) -> list[list[Window]]:
    """Windows of single balls that one call can integrate, all or, where the drive accelerates, from one instant."""
    groups: dict[tuple, list[Window]] = {}
    for number, window in enumerate(windows):
        alike = window.begin if part.drive.acceleration else 0
        groups.setdefault((number if window.ball < 0 else -1, alike), []).append(window)
    return list(groups.values())


def _beginning(part: Part, balls, begin: int, length: int):
    """(state, orientation, step sizes, what laws carry, ring and cage) where a window of `balls`, an index, begins.

    What a law carries is known at the beginning of a part alone; elsewhere it begins anew. The first step is half the
    run's there.
    """
    state, orientation, steps, carried, border = part.begun
    if begin < 0:
        return state[balls], orientation[balls], 0.5 * steps[balls], carried[balls], border
    states, orientations, borders = part.filled
    step, rest = steps[balls], slice(begin + 1, begin + 1 + length)
    if len(part.pointer):
        counted = part.pointer[balls, rest, STEPS_IN].sum(axis=-1)
        step = (part.times[rest][-1] - part.times[begin]) / np.maximum(counted, 1.0)
    return states[begin, balls], orientations[begin, balls], 0.5 * step, np.zeros_like(carried[balls]), borders[begin]


def starts(part: Part, group: list[Window]):
    """Where windows begin: (state, orientation, step sizes, what laws carry), then ring and cage, one row a window."""
    *moving, borders = (
        np.array(column) for column in zip(*(_beginning(part, *window) for window in group), strict=True)
    )
    return tuple(moving), borders


def all_start(part: Part, begin: int, length: int):
    """As `starts`, of a window of all balls; ring and cage have one row."""
    *moving, border = map(np.array, _beginning(part, slice(None), begin, length))
    return tuple(moving), border


def room(length: int, balls: int, carried: np.ndarray, border: np.ndarray) -> Results:
    """Empty results of so many instants and balls."""
    return Results(
        np.empty((length, balls, COLUMNS)),
        np.empty((length, balls, 4)),
        np.zeros(4, np.int64),
        np.zeros(2),
        np.zeros(1, np.uint8),
        carried,
        np.full((length, BORDER), border),
        border,
        np.zeros((0, 0, 0)),
    )
