"""Balls that share their steps with each other or with ring, cage and shaft, by the compiled core.

The arrays that are handed over stand in the order in which coupled.cpp reads them.
"""

import numpy as np

from bearing_twin.core import FLAG, INTEGER, INTEGERS, INTEGERS_OUT, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.bearing.compiled_balls import method_numbers, numbers_of
from bearing_twin.kinds.bearing.system import CAGE
from bearing_twin.numerics.steppers import RODAS4

COORDINATES, INTEGRALS = 9, 4  # ring x, y, z, its tilt about x and y, cage x, y, its angle, shaft
SHAFT = 8
BODY_NUMBERS = 2 * COORDINATES + INTEGRALS
NO_CAGE, EVEN, POCKETS = range(3)  # CageKind
# The coordinates of the six places of ring and cage: with tilt, or with a cage whose centre moves.
_COORDINATES_OF = {False: [0, 1, 2, 3, 4, 7], True: [0, 1, 2, 5, 6, 7]}

_coupled_balls = Function(
    "core_coupled_balls",
    INTEGER,
    (
        *(REALS, REALS, REALS, REALS, REALS, REALS, REALS, REALS, REAL, INTEGER, REALS, FLAG),
        *(INTEGER, INTEGERS, FLAG, INTEGER, *(REALS_OUT,) * 5),
        *(REALS_OUT, REALS_OUT, REALS_OUT, INTEGERS_OUT, REALS_OUT),
    ),
)
_rates = Function(
    "core_coupled_rates",
    None,
    (*(REALS,) * 7, INTEGER, FLAG, REALS_OUT, REALS, REALS_OUT, REALS_OUT),
)


def _spread(values, guided: bool, shaft: float = 0.0) -> np.ndarray:
    """Numbers of ring and cage (PLACES,) as those of all coordinates (COORDINATES,)."""
    found = np.zeros(COORDINATES)
    found[_COORDINATES_OF[guided]] = values
    found[SHAFT] = shaft
    return found


def _numbers_of_bodies(bearing, partners) -> np.ndarray:
    """The numbers of CoupledBodies, but for those that change from part to part."""
    guided, shaft = bool(partners.land), partners.shaft
    free = _spread(partners.free, guided, float(bool(shaft)))
    if not partners.ring:
        free[:5] = 0.0
    scales, size = partners.scales, len(partners.free)
    cage = NO_CAGE if not partners.free[CAGE] else EVEN if partners.even else POCKETS
    return np.array(
        [
            *(bearing.ring, cage, guided, *free),
            *_spread(partners.mass, guided, shaft.inertia if shaft else 1.0),
            *_spread(partners.stiffness, guided),
            *_spread(partners.damping, guided, shaft.damping if shaft else 0.0),
            *_spread(partners.rest, guided),
            *_spread(partners.weight, guided),
            *_spread(scales[:size], guided),
            *_spread(scales[size : 2 * size], guided, scales[2 * size]),
            *(partners.polar_inertia, partners.unbalance, partners.phase, partners.light),
            *(bearing.pockets or (0.0,) * 5),
            *(partners.land or (0.0,) * 7),
        ],
        float,
    )


_latest: tuple = (None,) * 4  # the last bearing, masses and scales of its partners, and their numbers


def numbers_of_bodies(bearing, partners) -> np.ndarray:
    """The numbers of CoupledBodies, but for those that change from part to part."""
    global _latest
    key = bearing, partners.mass, partners.scales
    if any(one is not other for one, other in zip(key, _latest, strict=False)):
        _latest = *key, _numbers_of_bodies(bearing, partners)
    return _latest[3]


def rates_and_jacobian(bearing, drive, partners, near, state, border) -> tuple[np.ndarray, np.ndarray]:
    """Rates of balls in a state (N, COLUMNS) with ring, cage and shaft (BORDER,), and their Jacobian, for tests.

    Rates are those of N COLUMNS numbers of balls and BODY_NUMBERS of the bodies, derivatives by N 9 of the balls'
    motion and by places and velocities of the bodies; velocities along the orbit are orbit rates.
    """
    numbers, points = numbers_of(bearing)
    balls = len(state)
    rows = state.size + BODY_NUMBERS
    rates, jacobian = np.empty(rows), np.empty((rows, 9 * balls + 2 * COORDINATES))
    _rates(
        *(numbers, points, method_numbers(RODAS4), numbers_of_bodies(bearing, partners)),
        *(partners.load, partners.load_rate, np.array(drive, float)),
        *(balls, near.view(np.uint8), state.copy(), border, rates, jacobian),
    )
    return rates, jacobian


def advance(bearing, drive, method, chunk, near, partners, balls, moving, results) -> int:
    """Moves the numbered `balls`, neighbours one after the other, through a chunk with ring, cage and shaft.

    `near` (N,) says which ball may touch the next ahead; `chunk` and `results` as `integrate.Chunk` and
    `steps.Results`; `moving` are the arrays state (N, COLUMNS), orientation (N, 4) and steps (N,), which are moved on
    in place. Returns a status.
    """
    numbers, points = numbers_of(bearing)
    balls = np.asarray(balls, np.int64)
    return _coupled_balls(
        *(numbers, points, method_numbers(method), numbers_of_bodies(bearing, partners)),
        *(partners.load, partners.load_rate, np.array(drive, float), chunk.scales, chunk.duration),
        *(len(chunk.times), chunk.times, results.stop, len(balls), balls, near.view(np.uint8), len(moving[0]), *moving),
        *(results.carried, results.last_border, results.states, results.orientations, results.border),
        *(results.counts, results.failure),
    )
