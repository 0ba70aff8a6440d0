"""The door to the compiled core: numbers of a bearing and its bodies, steps of balls alone and coupled, outputs.

Arrays are handed over in the order in which core/bearing/held_ring.cpp, coupled.cpp and outputs.cpp read them.
"""

import functools

import numpy as np

from bearing_twin.contact.friction import POINT
from bearing_twin.contact.patch_friction import patch_by
from bearing_twin.core import FLAG, FLAGS, INTEGER, INTEGERS, INTEGERS_OUT, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.bearing.system import CAGE, CARRIED_COLUMNS, TERMS
from bearing_twin.numerics.methods import OK
from bearing_twin.numerics.steppers import MOST_STAGES, RODAS4, ROSENBROCK, Rosenbrock, RungeKutta

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
_ball_rates = Function("core_ball_rates", None, (REALS, REALS, REAL, REALS, REALS, REALS_OUT, REALS_OUT))


def _drive_numbers(drive) -> np.ndarray:
    return np.array([drive.speed, drive.acceleration, drive.angle], float)


_latest_bearing: tuple = (None, None)  # the last bearing and its numbers: it is the same, chunk after chunk


def numbers_of(bearing) -> tuple[np.ndarray, np.ndarray]:
    """The numbers of a bearing, and the points of its friction's quadrature."""
    global _latest_bearing
    if _latest_bearing[0] is bearing:
        return _latest_bearing[1]
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
    _latest_bearing = bearing, found
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


def place_balls(bearing, ring_speed: float, rolls: bool, state: np.ndarray) -> bool:
    """Fills the state (N, COLUMNS) of evenly spaced balls at rest between the raceways, rolling there if they are to.

    False where a ball finds no rest.
    """
    return bool(_place(*numbers_of(bearing), ring_speed, rolls, len(state), state))


def advance_free(bearing, drive, method: Rosenbrock, chunk, balls, moving, results) -> int:
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


def advance_common(bearing, drive, method: RungeKutta | None, chunk, moving, results) -> int:
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


def ball_rates_and_jacobian(
    bearing, ring_speed: float, state: np.ndarray, carried=None
) -> tuple[np.ndarray, np.ndarray]:
    """Rates (COLUMNS,) of one ball in a state (COLUMNS,), and their derivatives (9, 9) by its motion.

    `carried` (CARRIED_COLUMNS,) is what a law with states carries at the ball's contacts; None: nothing yet.
    """
    found, jacobian = np.empty(len(state)), np.empty((9, 9))
    carried = np.zeros(CARRIED_COLUMNS) if carried is None else carried
    _ball_rates(*numbers_of(bearing), float(ring_speed), np.ascontiguousarray(state, float), carried, found, jacobian)
    return found, jacobian


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
_system_rates = Function(
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


def _numbers_of_bodies(bearing, bodies) -> np.ndarray:
    """The numbers of CoupledBodies, but for those that change from part to part."""
    guided, shaft = bool(bodies.land), bodies.shaft
    free = _spread(bodies.free, guided, float(bool(shaft)))
    if not bodies.ring:
        free[:5] = 0.0
    scales, size = bodies.scales, len(bodies.free)
    cage = NO_CAGE if not bodies.free[CAGE] else EVEN if bodies.even else POCKETS
    return np.array(
        [
            *(bearing.ring, cage, guided, *free),
            *_spread(bodies.mass, guided, shaft.inertia if shaft else 1.0),
            *_spread(bodies.stiffness, guided),
            *_spread(bodies.damping, guided, shaft.damping if shaft else 0.0),
            *_spread(bodies.rest, guided),
            *_spread(bodies.weight, guided),
            *_spread(scales[:size], guided),
            *_spread(scales[size : 2 * size], guided, scales[2 * size]),
            *(bodies.polar_inertia, bodies.unbalance, 0.0, bodies.light),
            *(bearing.pockets or (0.0,) * 5),
            *(bodies.land or (0.0,) * 7),
        ],
        float,
    )


_latest_bodies: tuple = (None,) * 4  # the last bearing, masses and scales of its bodies, and their numbers


def numbers_of_bodies(bearing, bodies) -> np.ndarray:
    """The numbers of CoupledBodies, but for those that change from part to part."""
    global _latest_bodies
    key = bearing, bodies.mass, bodies.scales
    if any(one is not other for one, other in zip(key, _latest_bodies, strict=False)):
        _latest_bodies = *key, _numbers_of_bodies(bearing, bodies)
    return _latest_bodies[3]


def system_rates_and_jacobian(bearing, drive, bodies, near, state, border) -> tuple[np.ndarray, np.ndarray]:
    """Rates of balls in a state (N, COLUMNS) with ring, cage and shaft (BORDER,), and their Jacobian, for tests.

    Rates are those of N COLUMNS numbers of balls and BODY_NUMBERS of the bodies, derivatives by N 9 of the balls'
    motion and by places and velocities of the bodies; velocities along the orbit are orbit rates.
    """
    numbers, points = numbers_of(bearing)
    balls = len(state)
    rows = state.size + BODY_NUMBERS
    rates, jacobian = np.empty(rows), np.empty((rows, 9 * balls + 2 * COORDINATES))
    _system_rates(
        *(numbers, points, method_numbers(RODAS4), numbers_of_bodies(bearing, bodies)),
        *(bodies.load, bodies.load_rate, np.array(drive, float)),
        *(balls, near.view(np.uint8), state.copy(), border, rates, jacobian),
    )
    return rates, jacobian


def advance_coupled(bearing, drive, method, chunk, near, bodies, balls, moving, results) -> int:
    """Moves the numbered `balls`, neighbours one after the other, through a chunk with ring, cage and shaft.

    `near` (N,) says which ball may touch the next ahead; `chunk` and `results` as `integrate.Chunk` and
    `steps.Results`; `moving` are the arrays state (N, COLUMNS), orientation (N, 4) and steps (N,), which are moved on
    in place. Returns a status.
    """
    numbers, points = numbers_of(bearing)
    balls = np.asarray(balls, np.int64)
    return _coupled_balls(
        *(numbers, points, method_numbers(method), numbers_of_bodies(bearing, bodies)),
        *(bodies.load, bodies.load_rate, np.array(drive, float), chunk.scales, chunk.duration),
        *(len(chunk.times), chunk.times, results.stop, len(balls), balls, near.view(np.uint8), len(moving[0]), *moving),
        *(results.carried, results.last_border, results.states, results.orientations, results.border),
        *(results.counts, results.failure),
    )


NO_BODIES = np.zeros(0)
_outputs = Function(
    "core_outputs",
    None,
    (
        *(REALS, REALS, REALS, INTEGER, INTEGER, REALS, REALS, REALS),
        *(INTEGER, REALS, REALS, REALS, REALS, REAL, INTEGERS, REALS_OUT),
    ),
)


def write_rows(bearing, bodies, drive, rolling, times, states, orientations, borders, places, out) -> None:
    """Fills rows of all channels with the motion at `times` (count,) [s], which count from the drive's instant.

    `states` (count, N, COLUMNS) and orientations (count, N, 4) are the balls', `borders` (count, BORDER) those of ring,
    cage and shaft, the `bodies`; `rolling` is the speed of balls that roll, over the ring's. `places` are the numbers
    of RowPlaces, `out` is (count, columns).
    """
    coupled = bool(bodies.active or bearing.ring)
    numbers = numbers_of_bodies(bearing, bodies) if coupled else NO_BODIES
    _outputs(
        *(*numbers_of(bearing), np.array(drive, float), *states.shape[:2], times, states, orientations),
        *(coupled, numbers, bodies.load, bodies.load_rate, borders, rolling, places, out),
    )
