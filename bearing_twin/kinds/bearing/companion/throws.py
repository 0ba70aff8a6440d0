"""A ring that is thrown across its clearance, and what that makes of errors: by a copy, more exact, that starts apart.

Each blow of such a ring against its balls makes an error grow, by as much as no window shows and nobody knows before.
So the copy sets out where the part begins, and goes on until the ring lies, the last ball has landed, and what it is
off fades: a ring may still knock to and fro then, and before it balls that hop make errors grow as well, which need not
be known where the run is off too far already. Its ring is off as the run's may be: a ring that swings on its balls is
off in its place and, a quarter of a swing later, in its speed. In flight its place stays off by as much, its speed
takes it ever further; so the copy's ring sets out with the speed. Its difference from the run is all that the run is
off: by what it had from before, and by its steps. No window of all balls says more. By chance it may be a third of what
the run is off, or less; where that decides whether the run is as exact as wanted, a second copy sets out, displaced.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.elastic import elastic
from bearing_twin.contact.elasticity import Elasticity
from bearing_twin.kinds.bearing.companion.beside import TIGHTER, all_beside
from bearing_twin.kinds.bearing.companion.departures import all_start
from bearing_twin.kinds.bearing.companion.deviations import Found, Part, deviations, lengths
from bearing_twin.kinds.bearing.companion.redoing import CARRIED, SAFE
from bearing_twin.kinds.bearing.companion.windows import ALL, Window, carries
from bearing_twin.kinds.bearing.forces.layout import PLACES, RING_X, RING_Y
from bearing_twin.kinds.bearing.parameters import LOADS
from bearing_twin.sample import Columns

PLACE, SPEED = [RING_X, RING_Y], [PLACES + RING_X, PLACES + RING_Y]  # of the ring, in a border
NO_LOAD = 1e-300  # N: next to nothing, so that no quotient is infinite
FAR = 4  # times as long as a ring falls and knocks a copy goes on, and as long again where ...
FADED = 1.0 / 3.0  # ... in the last third of that it is off by more than this share of the most


@functools.lru_cache(maxsize=4)
def stiffest(law: Elasticity, greatest: float) -> float:
    """The stiffness [N/m] of a contact of this law that bears the `greatest` load [N], which seldom grows in a run."""
    if greatest <= 0.0:
        return 0.0
    return elastic(law.given, law.power, (greatest / law.given) ** (1.0 / law.power)).stiffness


def unheld(part: Part) -> np.ndarray:
    """Whether contacts leave more than half of a ring's load unheld (outputs,): half way from resting to falling."""
    at, partners = np.asarray(part.times)[:, None], part.partners
    load = (partners.load + partners.weight + at * partners.load_rate)[:, :3]
    return 2.0 * lengths(load + part.out["inner_ring_force"]) > lengths(load)


def thrown(part: Part) -> bool:
    """Whether a ring is thrown across its clearance: some ball then touches neither raceway at an output.

    A ball may also hop on the outer raceway while the ring lies still, or slides round. So at some output the ring's
    load must be `unheld`, too.
    """
    return part.flies and bool(unheld(part).any())


class Throw(NamedTuple):
    """What a copy showed: errors, as behind `tolerance` in a row of WINDOW, in which window, what it found there."""

    errors: np.ndarray
    window: Window
    found: Found

    @property
    def load(self) -> float:
        """The error of load [N]."""
        return float(self.errors[0])

    @property
    def friction(self) -> float:
        """The error of friction, over mu N."""
        return float(self.errors[1])

    def over(self, parameters, greatest: float) -> float:
        """The greatest error of what is wanted, over the tolerance; `greatest` load [N] so far."""
        friction = 0.0 if parameters.wanted.outputs == LOADS else self.friction
        return max(self.load / greatest, friction) / parameters.wanted.tolerance


def through_throw(parameters, part: Part, scales, off: float, wide: float, greatest: float) -> Throw | None:
    """What a copy shows of a part in which a ring is thrown; None of others, and if it breaks off.

    The ring makes loads `off` [N], and would make them off by what its place is off (`wide`) [N], as in `carried_on`:
    the first along its load, on two contacts in series, the second across. `greatest` [N] is the greatest load so far.
    Where that leaves open whether the run is as exact as wanted, a second copy goes, and the greater errors are told.
    """
    if not carries(parameters) or not thrown(part):
        return None
    stiffness = stiffest(part.bearing.inner.law, greatest)
    apart, swings = _apart(part, off, wide, stiffness), math.sqrt(0.5 * stiffness / parameters.rings.inner.mass)
    first = _copied(parameters, part, scales, greatest, (SPEED, swings * apart))
    if first is None or not SAFE < first.over(parameters, greatest) <= CARRIED:
        return first
    second = _copied(parameters, part, scales, greatest, (PLACE, apart))
    if second is None:
        return first
    longer = max(first, second, key=lambda one: one.window.length)
    found = longer.found._replace(steps=first.found.steps + second.found.steps)
    return Throw(np.maximum(first.errors, second.errors), longer.window, found)


def _apart(part: Part, off: float, wide: float, stiffness: float) -> np.ndarray:
    """How far [m], along x and y, the ring of a run may swing from where it should: see `through_throw`."""
    load = (part.partners.load + part.partners.weight)[:2]
    x, y = load / max(float(np.linalg.norm(load)), NO_LOAD)
    along, across = 2.0 * off / stiffness, wide / stiffness
    return np.array([along * x - across * y, along * y + across * x])


def _copied(parameters, part: Part, scales, greatest: float, differs: tuple) -> Throw | None:
    """What one copy shows whose ring `differs`: in which numbers of a border, and by how much."""
    moving, border = all_start(part, -1, len(part.times))
    border[differs[0]] += differs[1]
    last, seen, end = (*moving, border), [], len(part.times)
    begin, length = -1, min(FAR * (1 + int(np.flatnonzero(unheld(part))[-1])), end)
    while True:
        found = all_beside(parameters, part, Window(ALL, begin, length), scales, last)
        if found is None:
            return None
        seen.append(found)
        whole, last, begin = Window(ALL, -1, begin + 1 + length), found.last, begin + length
        found = _joined(seen)
        errors = np.abs(deviations(part, whole, found, greatest))
        told = Throw(errors / (1.0 - TIGHTER), whole, found)
        enough = told.over(parameters, greatest) > CARRIED or not part.in_flight[begin + 1 :].any()
        if begin + 1 == end or (enough and _faded(part, whole, found, length // 3, greatest, errors)):
            return told
        length = min(begin + 1, end - 1 - begin)


def _joined(seen: list[Found]) -> Found:
    """What was found in stretches one behind the other, as of one."""
    out, states = (np.concatenate(those) for those in ([one.out.numbers for one in seen], [one.states for one in seen]))
    return Found(Columns(seen[-1].out.layout, out), states, seen[-1].last, sum(one.steps for one in seen))


def _faded(part: Part, window: Window, found: Found, last: int, greatest: float, errors: np.ndarray) -> bool:
    """Whether at so many `last` outputs of a window the run is off by much less than by these `errors`."""
    if not last:
        return False
    found = found._replace(out=found.out.rows(slice(-last, None)), states=found.states[-last:])
    window = window._replace(begin=window.begin + window.length - last, length=last)
    return bool((np.array(deviations(part, window, found, greatest)[:2]) <= FADED * errors[:2]).all())
