"""What a ring that is thrown across its clearance makes of errors: a copy of the run, more exact, that starts apart.

Each blow of such a ring against its balls makes an error grow, by as much as no window shows and nobody knows before.
So the copy sets out where the part begins, with the ring displaced by what it is off there, and goes on until all balls
bear load again. Its difference from the run is all that the run is off: by what it had from before, and by its steps.
"""

from typing import NamedTuple

import numpy as np

from bearing_twin.kinds.bearing.companion.beside import TIGHTER, all_beside
from bearing_twin.kinds.bearing.companion.departures import SETTLING, all_start
from bearing_twin.kinds.bearing.companion.deviations import Part, deviations
from bearing_twin.kinds.bearing.companion.windows import ALL, Window
from bearing_twin.kinds.bearing.forces.layout import RING_X, RING_Y

LEAST_LOAD = 1e-300  # N: next to nothing, so that a direction is finite


class Throw(NamedTuple):
    """Errors of load [N] and of friction, over mu N, that a copy showed, and the steps of all balls that it took."""

    load: float
    friction: float
    steps: int


def through_throw(parameters, part: Part, scales: np.ndarray, displaced: tuple[float, float], greatest: float) -> Throw | None:
    """A copy through a part in which a ring is thrown, `displaced` [m] along its load and across; None if it breaks off.

    `greatest` [N] is the greatest load so far.
    """
    flies = part.in_flight.any(axis=1)
    outputs = len(flies)
    window = Window(ALL, -1, min(outputs - int(np.argmax(flies[::-1])) + SETTLING, outputs))
    moving, border = all_start(part, -1, window.length)
    load = (part.partners.load + part.partners.weight)[:2]
    x, y = load / max(float(np.linalg.norm(load)), LEAST_LOAD)
    along, across = displaced
    border[[RING_X, RING_Y]] += along * x - across * y, along * y + across * x
    found = all_beside(parameters, part, window, scales, (*moving, border))
    if found is None:
        return None
    load, friction = (one / (1.0 - TIGHTER) for one in deviations(part, window, found, greatest)[:2])
    return Throw(load, friction, found.steps)
