"""What a run went through before a part: stretches that a more exact motion integrates again, to where the part begins.

Errors that a ring has at the beginning of a part were made before it, as far back as its contacts have not damped them.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.elastic import elastic
from bearing_twin.contact.elasticity import Elasticity
from bearing_twin.kinds.bearing.companion.beside import METHOD, TIGHTER
from bearing_twin.kinds.bearing.companion.departures import all_start, room
from bearing_twin.kinds.bearing.companion.deviations import Part
from bearing_twin.kinds.bearing.companion.second import WORKS
from bearing_twin.kinds.bearing.companion.windows import carries
from bearing_twin.kinds.bearing.forces.equations import Bearing, RingDrive
from bearing_twin.kinds.bearing.forces.layout import BORDER, CARRIED_COLUMNS, MOTION, PLACES
from bearing_twin.kinds.bearing.stepping.integrate import Chunk, integrated
from bearing_twin.numerics.lanes import COLUMNS
from bearing_twin.numerics.statuses import OK, STEPS

FURTHEST = 0.4  # s: no further back than this, where contacts hardly damp what a ring is off


@functools.lru_cache(maxsize=4)
def stiffest(law: Elasticity, greatest: float) -> float:
    """The stiffness [N/m] of a contact of this law that bears the `greatest` load [N], which seldom grows in a run."""
    if greatest <= 0.0:
        return 0.0
    return elastic(law.given, law.power, (greatest / law.given) ** (1.0 / law.power)).stiffness


def ringing_time(parameters, bearing: Bearing, greatest: float) -> float:
    """Time [s] in which a ring that rings on the ball that bears most, `greatest` [N], falls to a tenth; 0 without one.

    A mass m on two contacts of stiffness k in series, each with a viscous term k times the relaxation time.
    """
    if not carries(parameters) or greatest <= 0.0:
        return 0.0
    damping = 0.5 * stiffest(bearing.inner.law, greatest) * bearing.relaxation_time
    return math.log(10.0) * 2.0 * parameters.rings.inner.mass / damping if damping > 0.0 else math.inf


class Stretch(NamedTuple):
    """A stretch of a run since `begin` for `duration` [s]: how it began, and what acted in it.

    `moving` are state, orientation, steps, what laws carry, and border. `near` (N,) says which balls may meet the next,
    `offset` [m] is where the inner ring is held, `load` and `load_rate` (PLACES,) are those of `Partners`.
    """

    begin: float
    duration: float
    moving: tuple[np.ndarray, ...]
    near: np.ndarray
    drive: RingDrive
    offset: tuple[float, ...]
    load: np.ndarray
    load_rate: np.ndarray

    def chunk(self, part: Part, scales: np.ndarray) -> Chunk:
        """What is integrated through it, without outputs, TIGHTER than with the `scales` of the part behind it."""
        varying = part.partners.varying or bool(self.load_rate.any())
        partners = part.partners._replace(load=self.load, load_rate=self.load_rate, varying=varying)
        partners = partners._replace(scales=TIGHTER * partners.scales)
        return Chunk(part.bearing, self.drive, partners, self.near, np.zeros(0), self.duration, 0.0, TIGHTER * scales)


class Earlier:
    """Keeps stretches of a run, of so many `balls`, as plain data: few of them are ever integrated again."""

    def __init__(self, balls: int):
        self.balls = balls
        self._told: list[list] = []

    def passed(self, part: Part, seconds: float) -> None:
        """Takes in a part, in place of an earlier go at it; kept are the last `seconds` of it, and as many before it.

        From an output on: its state lies on an interpolant, which is off by no more than steps are.
        """
        seconds, outputs = min(seconds, FURTHEST), len(part.times)
        if seconds <= 0.0:
            return
        near_end = int(np.searchsorted(part.times, part.duration - seconds, side="right")) - 1
        begin = max(-1, min(near_end, outputs - 2))
        start, held = part.start(begin), part.partners
        moving, border = all_start(part, begin, outputs - 1 - begin)
        moving = [one.tolist() for one in (*moving, border)]
        acts = list(part.drive_from(start)), list(part.bearing.offset), held.load + start * held.load_rate
        last = [part.elapsed + start, part.duration - start, moving, part.near.tolist(), *acts[:2]]
        told = [one for one in self._told if one[0] < part.elapsed]
        while told and sum(one[1] for one in told[1:]) >= seconds:
            del told[0]
        self._told = [*told, [*last, acts[2].tolist(), held.load_rate.tolist()]]

    def beside(self, part: Part, scales: np.ndarray) -> tuple[tuple[np.ndarray, ...], int] | None:
        """Where a more exact motion gets to from the first stretch on until a part begins, and its steps.

        As `Found.last`; None where it breaks off. Where nothing is kept before the part, or the inner ring was shifted
        at once since then, it is where the run is.
        """
        moving, border = all_start(part, -1, len(part.times))
        begun, taken = (*moving, border), 0
        gone = [one for one in map(self._stretch, self._told) if one.begin < part.elapsed]
        if not gone or any(one.offset != part.bearing.offset for one in gone):
            return begun, 0
        last = gone[0].moving
        for one in gone:
            last[2][:] = min(last[2].min(), one.moving[2].min())  # where loads bend a step from before is too long
            results = room(0, len(part.near), last[3], last[4])
            if integrated(METHOD, one.chunk(part, scales), last[:3], results) != OK:
                return None
            taken += int(results.counts[STEPS])
        last[0][:, MOTION:], last[4][WORKS] = begun[0][:, MOTION:], begun[4][WORKS]  # what the part adds to is told
        last[2][:] = np.minimum(last[2], begun[2])
        return last, taken

    def memory(self) -> list:
        """As plain data; see `remember`."""
        return self._told

    def remember(self, kept: list) -> None:
        """Goes on from what `memory` gave; raises TypeError or ValueError for that of another bearing."""
        for one in kept:
            self._stretch(one)
        self._told = kept

    def _stretch(self, told: list) -> Stretch:
        begin, duration, moving, near, drive, offset, *loads = told
        arrays, balls = [np.array(one, float) for one in (*moving, *loads)], self.balls
        shapes = [(balls, COLUMNS), (balls, 4), (balls,), (balls, CARRIED_COLUMNS), (BORDER,), (PLACES,), (PLACES,)]
        near, offset = np.array(near, bool), tuple(map(float, offset))
        if [one.shape for one in arrays] != shapes or near.shape != (balls,) or len(offset) != 3:
            raise ValueError("earlier")
        what = near, RingDrive(*map(float, drive)), offset, *arrays[5:]
        return Stretch(float(begin), float(duration), tuple(arrays[:5]), *what)
