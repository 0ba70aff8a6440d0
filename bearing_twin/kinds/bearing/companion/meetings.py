"""Where balls that nothing keeps apart may have met, and how far a run may be off its way round until then.

A window of one ball holds while that ball meets no other. Where two meet, what they are off on their way round, which
changes nothing while they roll, becomes an error of forces: `Drift` keeps it, from what a companion found, and a copy
of the run that starts apart by it (`companion`) shows what follows.
"""

import math
from collections.abc import Iterator

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.kinds.bearing.companion.deviations import Found, Part
from bearing_twin.kinds.bearing.companion.windows import ALL, APART, Window
from bearing_twin.kinds.bearing.error_scales import APPROACH_SCALE
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, HEIGHT, ORBIT_ANGLE, TANGENTIAL_VELOCITY

AHEAD = 2.0  # times the speed with which two balls come nearer: they may meet before the next output
COPYING = 0.3  # of the run's steps: where a copy that starts apart took more, it ends
LEAST_OUTPUTS = 3  # after a meeting that it goes on for in any case
LEAST_APART = 0.1  # of what steps of the run's tolerance may err: balls were 0.003 to 0.1 of it off when they met
AHEAD_OF = 2  # outputs before a meeting where a copy starts, so that one shows it before


def meetings(part: Part) -> np.ndarray:
    """Whether each ball may have met the next ahead between an output and the one before, (outputs, balls)."""
    balls = len(part.near)
    if part.partners.active or not part.near.any():
        return np.zeros((len(part.times), balls), bool)
    states = np.concatenate([part.begun[0][None], part.filled[0]])
    distance, angle, height = (states[..., column] for column in (AXIS_DISTANCE, ORBIT_ANGLE, HEIGHT))
    centre = np.stack([distance * np.cos(angle), distance * np.sin(angle), height], axis=-1)
    gap = np.linalg.norm(np.roll(centre, -1, axis=1) - centre, axis=-1) - 2.0 * part.bearing.ball_radius
    speed = states[..., TANGENTIAL_VELOCITY]
    nearer = np.diff(np.concatenate([[0.0], part.times]))[:, None] * np.abs(np.roll(speed, -1, axis=1) - speed)[:-1]
    return (np.minimum(gap[:-1], gap[1:]) < AHEAD * nearer) & part.near


def pairs_in(window: Window, met: np.ndarray) -> np.ndarray:
    """Whether each ball may have met the next ahead in a window, (balls,)."""
    return met[window.begin + 1 : window.begin + 1 + window.length].any(axis=0)


def as_met(window: Window, met: np.ndarray) -> Window:
    """The window, of all balls where its own may have met another in it."""
    pairs = pairs_in(window, met)
    return window._replace(ball=ALL) if window.ball >= 0 and (pairs[window.ball] or pairs[window.ball - 1]) else window


def until_met(window: Window, met: np.ndarray) -> Window:
    """The window up to where its ball may have met another; without length where that is at once."""
    if window.ball < 0:
        return window
    inside = met[window.begin + 1 : window.begin + 1 + window.length, [window.ball - 1, window.ball]].any(axis=1)
    return window._replace(length=int(inside.argmax())) if inside.any() else window


def stretches_from(met: np.ndarray) -> Iterator[Window]:
    """Windows of a copy one behind the other: before the first meeting, LEAST_OUTPUTS from there, then doubled."""
    first, outputs = int(met.any(axis=1).argmax()), len(met)
    begin, length = max(first - AHEAD_OF, -1), LEAST_OUTPUTS
    if first - 1 > begin:
        yield Window(APART, begin, first - 1 - begin)
    begin = max(first - 1, begin)
    while begin + 1 < outputs:
        window = Window(APART, begin, min(length, outputs - 1 - begin))
        yield window
        begin, length = begin + window.length, 2 * length


def first_met(part: Part, met: np.ndarray, output: int) -> float:
    """When [s] balls may first have met before this output of a part or a later one: that before it; else infinity."""
    found = met[output:].any(axis=1)
    return part.elapsed + part.start(output + int(found.argmax()) - 1) if found.any() else math.inf


def copied_from(met: np.ndarray, before: int) -> int | None:
    """The output at which a copy sets out in a part; None where there is none. `before`: earlier parts with meetings.

    Looked at are the parts 1, 2, 4, 8 ... with meetings.
    """
    if not met.any() or (before + 1) & before:
        return None
    return next(stretches_from(met)).begin


@kernel
def _note_driven(times, now, load, until, driven, alone):
    """Notes which balls both raceways carry at an output later than `until` [s], and for how long [s] others are not.

    That is the time before such outputs, (balls,); `times` (outputs,) [s] are those in the part, `now` in the run.
    """
    for output in range(len(times)):
        before = times[output] - (times[output - 1] if output > 0 else 0.0)
        for ball in range(len(until)):
            if now[output] > until[ball]:
                carried = load[output, ball, 0] > 0.0 and load[output, ball, 1] > 0.0
                driven[ball] = driven[ball] or carried
                alone[ball] += 0.0 if carried else before


class Drift:
    """How far each ball is off its way round [rad], how fast that grows [rad/s], and until when [s] it is known so.

    A ball that both raceways carry is driven, and its speed is right again; a loose one that no companion follows may
    be off by anything, for which the greatest of all stands.
    """

    def __init__(self, balls: int):
        self.angle, self.speed, self.until = np.zeros((3, balls))
        self.lost = np.zeros(balls, bool)
        self.limit: int | None = None
        self.later: list[tuple] = []

    def begin(self, limit: int | None) -> None:
        """From now on what is seen counts as it is at output `limit` of a part, and is kept until this is lifted.

        A copy of the run sets out from there, without what balls are off later. None lifts it.
        """
        kept, self.later, self.limit = self.later, [], limit
        for sight in kept:
            self.see(*sight)

    def memory(self) -> list:
        """As plain data; see `remember`."""
        return [one.tolist() for one in (self.angle, self.speed, self.until, self.lost)]

    def remember(self, kept: list) -> None:
        """Goes on from what `memory` gave; raises ValueError for that of another bearing."""
        balls = len(self.lost)
        self.angle, self.speed, self.until = np.array(kept[:3], float).reshape(3, balls)
        self.lost = np.array(kept[3], bool).reshape(balls)
        self.later, self.limit = [], None

    def see(self, part: Part, window: Window, found: Found, scale: float) -> None:
        """Takes in how far the ball of a window, or all, were off at its end, times `scale`.

        No later than at the limit, see `begin`.
        """
        end = window.begin + window.length
        if self.limit is not None and end > self.limit:
            self.later.append((part, window, found, scale))
            end = self.limit
        if end <= window.begin:
            return
        balls, own = (window.ball, 0) if window.ball >= 0 else (slice(None), slice(None))
        mine, exact = part.filled[0][end, balls], found.states[end - window.begin - 1, own]
        speeds = [one[..., TANGENTIAL_VELOCITY] / one[..., AXIS_DISTANCE] for one in (mine, exact)]
        angle = scale * np.abs(mine[..., ORBIT_ANGLE] - exact[..., ORBIT_ANGLE])
        self.angle[balls] = np.maximum(self.angle[balls], angle)
        self.speed[balls] = np.maximum(self.speed[balls], scale * np.abs(speeds[0] - speeds[1]))
        self.until[balls] = np.maximum(self.until[balls], part.elapsed + part.start(end))

    def go_on(self, part: Part, followed: set[int]) -> None:
        """Goes on to the end of a part."""
        now = part.elapsed + part.times
        if part.all_bear:
            driven_late = now[-1] > self.until
        else:
            driven_late, alone = np.zeros(len(self.until), np.bool_), np.zeros(len(self.until))
            _note_driven(part.times, now, part.load, self.until, driven_late, alone)
            self.angle = self.angle + self.speed * alone
        self.speed = np.where(driven_late, 0.0, self.speed)
        self.until = np.full(len(self.until), part.elapsed + part.duration)
        if ALL not in followed and part.flies:
            unseen = part.in_flight.any(axis=0)
            unseen[list(followed)] = False
            self.lost = self.lost | unseen

    def set_apart(self, state: np.ndarray, at: float, tolerance: float) -> None:
        """Moves balls (N, COLUMNS) at `at` [s] apart by what they may be off, in turns ahead and behind.

        By no less than LEAST_APART of what steps of this tolerance may err.
        """
        angle = self.angle + self.speed * np.maximum(at - self.until, 0.0)
        distance, ahead = state[:, AXIS_DISTANCE], np.where(np.arange(len(state)) % 2, 1.0, -1.0)
        angle, speed = (np.where(self.lost, one.max(), one) for one in (angle, self.speed))
        state[:, ORBIT_ANGLE] += ahead * np.maximum(angle, LEAST_APART * tolerance * APPROACH_SCALE / distance)
        state[:, TANGENTIAL_VELOCITY] += ahead * distance * speed
