"""Balls between rings that are held, by the compiled core (`core/bearing/held_ring.cpp`): motion and outputs.

The arrays that are handed over stand in the order in which held_ring.cpp reads them.
"""

import functools

import numpy as np

from bearing_twin.contact.friction import POINT
from bearing_twin.contact.patch_friction import patch_by
from bearing_twin.core import FLAG, FLAGS, INTEGER, INTEGERS, INTEGERS_OUT, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.bearing.system import CARRIED_COLUMNS, TERMS
from bearing_twin.numerics.statuses import OK
from bearing_twin.numerics.steppers import MOST_STAGES, ROSENBROCK, Rosenbrock, RungeKutta

NO_AXES = ((0.0,) * (TERMS + 1),) * 2
NO_FILM = np.zeros(8)  # a Lubricant of film.hpp

_free_balls = Function(
    "core_free_balls",
    INTEGER,
    (
        *(REALS, REALS, REALS, REALS, REALS, REAL, INTEGER, REALS, FLAG, INTEGER, INTEGERS, INTEGER),
        *(REALS_OUT, REALS_OUT, REALS_OUT, REALS_OUT, REALS_OUT, REALS_OUT, INTEGERS_OUT, REALS_OUT),
    ),
)
_common_balls = Function(
    "core_common_balls",
    INTEGER,
    (
        *(REALS, REALS, REALS, REALS, REALS, REAL, REAL, INTEGER, REALS, FLAG, INTEGER, FLAGS),
        *(REALS_OUT, REALS_OUT, REALS_OUT, REALS_OUT, REALS_OUT, INTEGERS_OUT, REALS_OUT, REALS_OUT),
    ),
)
_all_rates = Function("core_all_rates", None, (REALS, REALS, REAL, REAL, INTEGER, FLAGS, REALS, REALS_OUT))
_add_stored = Function("core_add_stored", None, (REALS, REALS, INTEGER, FLAGS, REAL, INTEGER, REALS_OUT))
_place = Function("core_place_balls", INTEGER, (REALS, REALS, REAL, INTEGER, INTEGER, REALS_OUT))
_rates = Function("core_ball_rates", None, (REALS, REALS, REAL, REALS, REALS, REALS_OUT, REALS_OUT))


def _drive_numbers(drive) -> np.ndarray:
    return np.array([drive.speed, drive.acceleration, drive.angle], float)


_latest: tuple = (None, None)  # the last bearing and its numbers: it is the same, chunk after chunk


def numbers_of(bearing) -> tuple[np.ndarray, np.ndarray]:
    """The numbers of a bearing, and the points of its friction's quadrature."""
    global _latest
    if _latest[0] is bearing:
        return _latest[1]
    raceways = []
    for raceway, axes in ((bearing.inner, 2), (bearing.outer, 3)):
        polynomials = (raceway.terms, *(bearing.patch[axes] if bearing.patch else NO_AXES))
        own = raceway.locus_radius, raceway.groove_radius, raceway.law.given, raceway.law.modulus
        raceways += [*own, *np.concatenate(polynomials)]
    coefficient, model = bearing.patch[:2] if bearing.patch else (0.0, POINT)
    friction, points = patch_by(model, coefficient)
    numbers = [
        *(
            bearing.ball_radius,
            bearing.ball_mass,
            bearing.ball_inertia,
            *bearing.offset,
            *bearing.tilt,
            *bearing.gravity,
        ),
        *(bearing.damping, bearing.relaxation_time, bearing.raceway_friction, bearing.friction_regularisation),
        *(bearing.inner.law.power, bearing.pair_coefficient, bearing.friction_coefficient),
        *raceways,
        *friction,
        bearing.inner.law.carried,
        *np.concatenate([np.ravel(one) for one in bearing.film or (NO_FILM,)]),
        *(bearing.defects or (0,)),
    ]
    found = np.array(numbers, float), points
    _latest = bearing, found
    return found


def _padded(values, *shape: int) -> np.ndarray:
    """The numbers of an array in one row, with zeros up to this shape."""
    room = np.zeros(shape)
    room[tuple(slice(0, size) for size in np.shape(values))] = values
    return room.ravel()


_SQUARE = MOST_STAGES, MOST_STAGES - 1


def method_numbers(method: Rosenbrock) -> np.ndarray:
    """The numbers of a method of ROSENBROCK as the core's RosenbrockMethod has them."""
    return _method_numbers(next(name for name, one in ROSENBROCK.items() if one is method))


@functools.cache
def _method_numbers(name: str) -> np.ndarray:
    method = ROSENBROCK[name]
    return np.concatenate(
        [
            [len(method.alpha), method.order, method.lands, method.gamma],
            *(_padded(method.a, *_SQUARE), _padded(method.c, *_SQUARE)),
            *(_padded(method.alpha, MOST_STAGES), _padded(method.d, MOST_STAGES)),
            _padded(method.dense, 2, MOST_STAGES - 1),
        ]
    )


def _runge_kutta_numbers(method: RungeKutta | None) -> np.ndarray:
    if method is None:
        return np.zeros(1)
    return np.concatenate(
        [
            [len(method.nodes), method.order],
            *(_padded(method.a, *_SQUARE), _padded(method.nodes, MOST_STAGES)),
            *(_padded(method.weights, MOST_STAGES), _padded(method.error, MOST_STAGES + 1)),
        ]
    )


def place(bearing, ring_speed: float, rolls: bool, state: np.ndarray) -> bool:
    """Fills the state (N, COLUMNS) of evenly spaced balls at rest between the raceways, rolling there if they are to.

    False where a ball finds no rest.
    """
    return bool(_place(*numbers_of(bearing), ring_speed, rolls, len(state), state))


def advance(bearing, drive, method: Rosenbrock, chunk, balls, moving, results) -> int:
    """Moves the numbered `balls` that touch no other through a chunk, each with steps of its own.

    `chunk` and `results` as `integrate.Chunk` and `steps.Results`; `moving` are the arrays state (N, COLUMNS),
    orientation (N, 4) and steps (N,), which are moved on in place. Returns a status.
    """
    numbers, points = numbers_of(bearing)
    balls = np.asarray(balls, np.int64)
    return _free_balls(
        *(numbers, points, method_numbers(method), _drive_numbers(drive)),
        *(np.ascontiguousarray(chunk.scales), chunk.duration, len(chunk.times), np.ascontiguousarray(chunk.times)),
        *(results.stop, len(balls), balls, len(moving[0]), *moving, results.carried),
        *(results.states, results.orientations, results.counts, results.failure),
    )


def advance_together(bearing, drive, method: RungeKutta | None, chunk, moving, results) -> int:
    """Moves all balls through a chunk by an explicit method, or for None by the implicit-explicit one, in common steps.

    As `advance`; steps of methods without an error estimate are `chunk.step` [s] at most.
    """
    numbers, points = numbers_of(bearing)
    state, orientation, steps = moving
    adaptive, following = method is not None and bool(method.error.any()), np.empty(1)
    status = _common_balls(
        *(numbers, points, _runge_kutta_numbers(method), _drive_numbers(drive)),
        *(np.ascontiguousarray(chunk.scales), float(steps[0]) if adaptive else chunk.step, chunk.duration),
        *(
            len(chunk.times),
            np.ascontiguousarray(chunk.times),
            results.stop,
            len(state),
            chunk.near,
            state,
            orientation,
            results.carried,
        ),
        *(results.states, results.orientations, results.counts, results.failure, following),
    )
    if status == OK:
        steps[:] = following
    return status


def rates(bearing, ring_speed: float, near: np.ndarray, state: np.ndarray, ring_angle: float = 0.0) -> np.ndarray:
    """Rates (N, COLUMNS) of all balls in a state (N, COLUMNS); near[k] says whether ball k may touch the next ahead.

    Losses take in what contacts of balls store.
    """
    found = np.empty_like(state)
    _all_rates(*numbers_of(bearing), float(ring_speed), float(ring_angle), len(state), near, state, found)
    return found


def add_stored(bearing, near: np.ndarray, share: float, states: np.ndarray) -> None:
    """Adds a share of what contacts of neighbours store [J] to losses in states (..., N, COLUMNS), in place."""
    balls = len(near)
    _add_stored(*numbers_of(bearing), balls, near, share, states.size // (balls * states.shape[-1]), states)


def rates_and_jacobian(bearing, ring_speed: float, state: np.ndarray, carried=None) -> tuple[np.ndarray, np.ndarray]:
    """Rates (COLUMNS,) of one ball in a state (COLUMNS,), and their derivatives (9, 9) by its motion.

    `carried` (CARRIED_COLUMNS,) is what a law with states carries at the ball's contacts; None: nothing yet.
    """
    found, jacobian = np.empty(len(state)), np.empty((9, 9))
    carried = np.zeros(CARRIED_COLUMNS) if carried is None else carried
    _rates(*numbers_of(bearing), float(ring_speed), np.ascontiguousarray(state, float), carried, found, jacobian)
    return found, jacobian
