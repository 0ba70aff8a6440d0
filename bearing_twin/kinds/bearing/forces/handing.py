"""A bearing as Python hands it to kernels that are called for every chunk: its numbers in one array, and the rest.

Numba looks up the fields of each tuple with names, and takes out number by number: 3.6 microseconds for a bearing, 0.4
for this. `handed` and `taken` are each other's inverse.
"""

import numpy as np

from bearing_twin.compiled import inlined
from bearing_twin.contact.elasticity import Elasticity
from bearing_twin.kinds.bearing.forces.equations import Bearing, Raceway

KEPT = 4  # bearings that are known: those of a shaft take turns, chunk after chunk
_latest: tuple = ()  # of these: (bearing, what it was made into), the last one first


def _numbers(fields):
    for one in fields:
        if isinstance(one, tuple):
            yield from _numbers(one)
        else:
            yield one


def handed(bearing: Bearing, balls: int | None = None) -> tuple[np.ndarray, tuple]:
    """The numbers of a bearing but for its last three fields, in their order, and those three: spot, ring, pockets.

    With another number of `balls`, if that is given.
    """
    global _latest
    found = next((found for known, found in _latest if known is bearing), None)
    if found is None:
        found = np.array([*_numbers(bearing[:-3])], float), tuple(bearing[-3:])
        _latest = ((bearing, found), *_latest[: KEPT - 1])
    if balls is None or balls == bearing.balls:
        return found
    numbers, rest = found[0].copy(), found[1]
    numbers[0] = balls
    return numbers, rest


@inlined
def _raceway(numbers, at):
    law = Elasticity(int(numbers[at + 2]), numbers[at + 3], numbers[at + 4], numbers[at + 5])
    return Raceway(numbers[at], numbers[at + 1], law)


@inlined
def taken(given):
    """The bearing of what `handed` gave."""
    numbers, (spot, ring, pockets) = given
    return Bearing(
        balls=int(numbers[0]),
        ball_radius=numbers[1],
        ball_mass=numbers[2],
        ball_inertia=numbers[3],
        inner=_raceway(numbers, 4),
        outer=_raceway(numbers, 10),
        offset=(numbers[16], numbers[17], numbers[18]),
        gravity=(numbers[19], numbers[20], numbers[21]),
        damping=numbers[22],
        relaxation_time=numbers[23],
        friction_coefficient=numbers[24],
        friction_regularisation=numbers[25],
        pair_coefficient=numbers[26],
        raceway_friction=numbers[27],
        spot=spot,
        ring=ring,
        pockets=pockets,
    )
