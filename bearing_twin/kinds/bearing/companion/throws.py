"""A ring that is thrown across its clearance, and what that makes of errors: by a copy, more exact, that starts apart.

Each blow of such a ring against its balls makes an error grow, by as much as no window shows and nobody knows before.
So the copy sets out where the part begins, with the ring displaced by what it is off there, and goes on to the part's
end: once the last ball has landed, a ring may still knock to and fro. Its difference from the run is all that the run
is off: by what it had from before, and by its steps.
"""

import functools
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.elastic import elastic
from bearing_twin.contact.elasticity import Elasticity
from bearing_twin.kinds.bearing.companion.beside import TIGHTER, all_beside
from bearing_twin.kinds.bearing.companion.departures import all_start
from bearing_twin.kinds.bearing.companion.deviations import Part, deviations, lengths
from bearing_twin.kinds.bearing.companion.windows import ALL, Window, carries
from bearing_twin.kinds.bearing.forces.layout import RING_X, RING_Y

NO_LOAD = 1e-300  # N: next to nothing, so that no quotient is infinite


@functools.lru_cache(maxsize=4)
def stiffest(law: Elasticity, greatest: float) -> float:
    """The stiffness [N/m] of a contact of this law that bears the `greatest` load [N], which seldom grows in a run."""
    if greatest <= 0.0:
        return 0.0
    return elastic(law.given, law.power, (greatest / law.given) ** (1.0 / law.power)).stiffness


def thrown(part: Part) -> bool:
    """Whether a ring is thrown across its clearance: some ball then touches neither raceway at an output.

    A ball may also hop on the outer raceway while the ring lies still, or slides round. So at some output contacts must
    leave more than half of its load unheld: half way from lying still to falling.
    """
    if not part.flies:
        return False
    at, partners = np.asarray(part.times)[:, None], part.partners
    load = (partners.load + partners.weight + at * partners.load_rate)[:, :3]
    moves = lengths(load + part.out["inner_ring_force"])
    return bool((2.0 * moves > lengths(load)).any())


class Throw(NamedTuple):
    """Errors of load [N] and of friction, over mu N, that a copy showed, and the steps of all balls that it took."""

    load: float
    friction: float
    steps: int


def through_throw(parameters, part: Part, scales, off: float, wide: float, greatest: float) -> Throw | None:
    """What a copy shows of a part in which a ring is thrown; None of others, and if it breaks off.

    The ring makes loads `off` [N], and would make them off by what its place is off (`wide`) [N], as in `carried_on`:
    the first along its load, on two contacts in series, the second across. `greatest` [N] is the greatest load so far.
    """
    if not carries(parameters) or not thrown(part):
        return None
    window = Window(ALL, -1, len(part.times))
    moving, border = all_start(part, -1, window.length)
    load, stiffness = (part.partners.load + part.partners.weight)[:2], stiffest(part.bearing.inner.law, greatest)
    x, y = load / max(float(np.linalg.norm(load)), NO_LOAD)
    along, across = 2.0 * off / stiffness, wide / stiffness
    border[[RING_X, RING_Y]] += along * x - across * y, along * y + across * x
    found = all_beside(parameters, part, window, scales, (*moving, border))
    if found is None:
        return None
    load, friction = (one / (1.0 - TIGHTER) for one in deviations(part, window, found, greatest)[:2])
    return Throw(load, friction, found.steps)
