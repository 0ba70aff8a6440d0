"""Balls that share their steps with each other or with ring, cage and shaft, by the core (`core/bearing/coupled.cpp`).

The arrays that are handed over stand in the order in which coupled.cpp reads them.
"""

import numpy as np

from bearing_twin.contact.elasticity import carries
from bearing_twin.core import FLAG, INTEGER, INTEGERS, INTEGERS_OUT, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.bearing.compiled_balls import method_numbers, numbers_of
from bearing_twin.kinds.bearing.forces.layout import BORDER, CAGE, PLACES, SHAFT_ANGLE, SHAFT_SPEED

COORDINATES, INTEGRALS = 9, 4  # ring x, y, z, its tilt about x and y, cage x, y, its angle, shaft
CAGE_ANGLE, SHAFT = 7, 8
BODY_NUMBERS = 2 * COORDINATES + INTEGRALS
HELD, TILTED, LEVEL, TILTING = range(4)  # RingMotion of coupled_bodies.hpp
NO_CAGE, EVEN, POCKETS = range(3)  # CageKind
# The number of the bodies' state that stands at each place of a border (BORDER,): a ring with tilt, and a cage whose
# centre moves beside a ring without.
_PLACES = {False: [0, 1, 2, 3, 4, 7], True: [0, 1, 2, 5, 6, 7]}
_IN_BORDER = {
    guided: np.array([*places, *(COORDINATES + place for place in places), 18, 19, 20, 8, 17, 21])
    for guided, places in _PLACES.items()
}

_coupled_balls = Function(
    "core_coupled_balls",
    INTEGER,
    (
        *(REALS, REALS, REALS, REALS, REALS, REALS, REAL, INTEGER, REALS, FLAG, INTEGER, INTEGERS, FLAG, INTEGER),
        *(REALS_OUT, REALS_OUT, REALS_OUT, REALS_OUT, REALS_OUT, REALS_OUT, REALS_OUT, INTEGERS_OUT, REALS_OUT),
    ),
)


def takes(bearing) -> bool:
    """Whether the core has this bearing: its law carries no states."""
    return not carries(bearing.inner.law)


def _spread(values, guided: bool, shaft: float = 0.0) -> np.ndarray:
    """Numbers of ring and cage (PLACES,) as those of all coordinates (COORDINATES,)."""
    found = np.zeros(COORDINATES)
    found[_PLACES[guided]] = values
    found[SHAFT] = shaft
    return found


def _walls(bearing, partners) -> list[float]:
    """Numbers of Pockets and Land of coupled_bodies.hpp, zeros where there are none."""
    pockets = (bearing.pockets[0] if len(bearing.pockets) == 1 else bearing.pockets) or (0.0,) * 5
    land = partners.land or (0.0,) * 7
    return [*pockets, *land]


def _ring_motion(bearing, partners) -> int:
    if not bearing.ring:
        return HELD
    if len(bearing.ring) == 1:
        return LEVEL
    return TILTING if partners.ring else TILTED


def _numbers_of_bodies(bearing, partners) -> np.ndarray:
    """The numbers of CoupledBodies, but for those that change from part to part."""
    guided, shaft = bool(partners.land), partners.shaft
    moving = len(partners.ring) > 0
    free = _spread(partners.free, guided, float(bool(shaft)))
    if not moving:
        free[:5] = 0.0
    scales, size = partners.scales, len(partners.free)
    cage = NO_CAGE if not partners.free[CAGE] else EVEN if partners.even else POCKETS
    return np.array(
        [
            *(_ring_motion(bearing, partners), cage, guided, *free),
            *_spread(partners.mass, guided, shaft.inertia if shaft else 1.0),
            *_spread(partners.stiffness, guided),
            *_spread(partners.damping, guided, shaft.damping if shaft else 0.0),
            *_spread(partners.rest, guided),
            *_spread(partners.weight, guided),
            *_spread(scales[:size], guided),
            *_spread(scales[size : 2 * size], guided, scales[2 * size]),
            *(partners.polar_inertia, partners.unbalance, partners.phase, partners.light),
            *_walls(bearing, partners),
        ],
        float,
    )


_latest: tuple = (None, None, None)  # the last bearing, masses of its partners, and their numbers


def numbers_of_bodies(bearing, partners) -> np.ndarray:
    """The numbers of CoupledBodies, but for those that change from part to part."""
    global _latest
    if _latest[0] is not bearing or _latest[1] is not partners.mass:
        _latest = bearing, partners.mass, _numbers_of_bodies(bearing, partners)
    return _latest[2]


def acting_on(partners, drive) -> np.ndarray:
    """Loads, their growth, and the shaft's prescribed angle, speed and acceleration."""
    guided, load, rate = bool(partners.land), partners.load, partners.load_rate
    ring_load, ring_rate = load.copy(), rate.copy()
    ring_load[CAGE] = ring_rate[CAGE] = 0.0
    return np.concatenate([_spread(ring_load, guided, load[CAGE]), _spread(ring_rate, guided, rate[CAGE]), drive])


def body_states(borders: np.ndarray, partners) -> np.ndarray:
    """States of ring, cage and shaft (..., BODY_NUMBERS) from borders (..., BORDER)."""
    found = np.zeros((*borders.shape[:-1], BODY_NUMBERS))
    found[..., _IN_BORDER[bool(partners.land)]] = borders
    return found


def advance(bearing, drive, method, chunk, near, partners, balls, moving, results) -> int:
    """Moves the numbered `balls`, neighbours one after the other, through a chunk with ring, cage and shaft.

    `near` (N,) says which ball may touch the next ahead; `chunk` and `results` as `integrate.Chunk` and
    `steps.Results`; `moving` are the arrays state (N, COLUMNS), orientation (N, 4) and steps (N,), which are moved
    on in place. Returns a status.
    """
    numbers, points = numbers_of(bearing)
    in_border = _IN_BORDER[bool(partners.land)]
    body, bodies = body_states(results.last_border, partners), np.empty((len(chunk.times), BODY_NUMBERS))
    if bearing.ring and not partners.ring:  # held, and tilted perhaps
        body[:3], body[3:5] = bearing.offset, bearing.ring.tilt if len(bearing.ring) > 1 else 0.0
    balls = np.asarray(balls, np.int64)
    status = _coupled_balls(
        *(numbers, points, method_numbers(method.order, method.lands)),
        *(numbers_of_bodies(bearing, partners), acting_on(partners, drive)),
        *(np.ascontiguousarray(chunk.scales), chunk.duration, len(chunk.times), np.ascontiguousarray(chunk.times)),
        *(results.stop, len(balls), balls, near.view(np.uint8), len(moving[0]), *moving, body),
        *(results.states, results.orientations, bodies, results.counts, results.failure),
    )
    places = np.arange(BORDER)
    if not partners.shaft:  # the shaft's own columns are of one that a torque turns
        places = np.delete(places, [SHAFT_ANGLE, SHAFT_SPEED])
    if status == 0:
        own = (places == CAGE) | (places == PLACES + CAGE) | (places >= 2 * PLACES)
        kept = places if len(partners.ring) else places[own]
        results.border[:, kept] = bodies[:, in_border[kept]]
        results.last_border[kept] = body[in_border[kept]]
    return status
