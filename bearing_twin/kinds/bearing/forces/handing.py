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
    first = at + 6
    terms = (
        numbers[first], numbers[first + 1], numbers[first + 2], numbers[first + 3], numbers[first + 4],
        numbers[first + 5], numbers[first + 6], numbers[first + 7], numbers[first + 8], numbers[first + 9],
        numbers[first + 10],
    )  # fmt: skip
    return Raceway(numbers[at], numbers[at + 1], law, terms)


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
        outer=_raceway(numbers, 21),
        offset=(numbers[38], numbers[39], numbers[40]),
        gravity=(numbers[41], numbers[42], numbers[43]),
        damping=numbers[44],
        relaxation_time=numbers[45],
        friction_coefficient=numbers[46],
        friction_regularisation=numbers[47],
        pair_coefficient=numbers[48],
        raceway_friction=numbers[49],
        spot=spot,
        ring=ring,
        pockets=pockets,
    )
