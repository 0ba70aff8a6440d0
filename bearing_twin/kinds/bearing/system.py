"""The numbers of a bearing's equations of motion (paper 1, section 5), which the compiled core takes, from a scene.

Frames. `bearing_link` has its origin at the outer ring's centre and z along the axis. The motion of each ball is
written in the frame that turns with that ball about the axis, with unit vectors (radial, tangential, axial): there
steady rolling is an equilibrium, and only the orbit angle grows.
"""

import functools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial
from numpy.polynomial.chebyshev import chebinterpolate, chebpts1

from bearing_twin.coefficients import EXPLICIT, MOST_STAGES, ROSENBROCK
from bearing_twin.contact.elasticity import Elasticity, elasticity, fresh_coefficient, hertz_coefficient, semi_axes
from bearing_twin.contact.friction import FRICTIONS, POINT, patch_by
from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.kinds.bearing.geometry import operating_geometry
from bearing_twin.kinds.bearing.lubricant import film_lubricant, film_numbers, is_lubricated
from bearing_twin.kinds.bearing.parameters import BearingScene, has_sensor, viscous_terms
from bearing_twin.kinds.bearing.rings import (
    BALLS,
    EVEN,
    FREE_RING,
    INNER_LAND,
    OUTER_LAND,
    POCKETS,
    PRESCRIBED,
    QUASI_STATIC,
    TORQUE,
    cage_inertia,
    dimension_of,
    free_coordinates,
    land_radius,
    moving_centre,
    shaft_inertia,
    tilts,
)
from bearing_twin.shapes import ball_in_groove, groove_curvatures

# Velocity and angular velocity: radial, tangential, axial, in the frame that turns with the ball about the axis.
AXIS_DISTANCE, ORBIT_ANGLE, HEIGHT, RADIAL_VELOCITY, TANGENTIAL_VELOCITY, AXIAL_VELOCITY = np.arange(6)
RADIAL_SPIN, TANGENTIAL_SPIN, AXIAL_SPIN, DRIVE_WORK, DISSIPATED, GROSS_WORK = np.arange(6, 12)
VELOCITY, SPIN = RADIAL_VELOCITY, RADIAL_SPIN
MOTION = 9  # the columns before this one are the motion, the others integrals
COLUMNS = 12
CARRIED_COLUMNS = 8  # states of laws: P/Q and three more at each of a ball's contacts

# Inner ring and cage: positions (the ring's centre, its tilt about x and y, the cage's angle), their velocities, and
# integrals: work of the loads on the ring, dissipated energy, work of the drive through the cage's land.
POSITIONS = 6
CAGE_X, CAGE_Y, CAGE = 3, 4, 5  # instead of tilts: a ring does not tilt if the cage's centre moves
CAGE_SPEED = POSITIONS + CAGE
LAND_WORK, SHAFT_ANGLE, SHAFT_SPEED = 14, 15, 16  # then the work of a torque that turns the shaft
HOUSING_POSITION, HOUSING_SPEED = 18, 19  # of an outer ring with its housing, along a direction
BODY_COLUMNS = 20


# Across a groove the gap between it and a ball has one curvature, along it one that follows from the radial part n of
# the contact's normal alone (`shapes.groove_curvatures`): so do the coefficient of a law that follows curvatures,
# and the semi-axes of a contact over the root of its approach. They are interpolated at Chebyshev's points and kept as
# polynomials in |n| - 1, so that all laws cost the same and slopes are exact. The points reach to a right angle, or to
# where the groove's radius about the axis is FURTHEST times that at angle zero, or as small a part: at 0.52 of the
# ball, to 67 degrees where balls are half the pitch circle. Beyond, the coefficient stays. Relative errors are 6e-14 in
# a 6203 and 3e-11 where balls are 0.4 of the pitch circle or more (`tests/core/test_groove_polynomials.py`).
TERMS = 10
FURTHEST = 1.7
_POINTS, _SERIES = chebpts1(TERMS), chebinterpolate(lambda points: np.eye(len(points)), TERMS - 1)
_BASES = (Chebyshev.basis(order, domain=[-1.0, 0.0]).convert(kind=Polynomial).coef for order in range(TERMS))
_POWERS = np.array([np.pad(basis, (0, TERMS - len(basis))) for basis in _BASES]).T  # of the bases between -1 and 0


def _fit_along(ball_radius, locus_radius, groove_radius, side, function) -> np.ndarray:
    """The polynomials (TERMS + 1, ...) of `function(small, large)` of the gap's curvatures along a groove.

    The last row is the least |n| - 1.
    """
    level = abs(side * locus_radius / groove_radius + 1.0)  # the radius about the axis there, over the groove's
    reach = min(1.0, level * (FURTHEST - 1.0 if side < 0.0 else 1.0 - 1.0 / FURTHEST))
    gap = groove_curvatures(ball_radius, locus_radius, groove_radius, side * (1.0 + 0.5 * reach * (_POINTS - 1.0)))
    terms = _POWERS @ (_SERIES @ np.transpose(function(*gap)))  # the product of both matrices loses five digits
    scaled = terms.T / reach ** np.arange(TERMS)
    return np.append(scaled.T, np.full((1, *scaled.shape[:-1]), -reach), axis=0)


def axes_along(ball_radius, locus_radius, groove_radius, side) -> np.ndarray:
    """The polynomials (2, TERMS + 1) of a contact's semi-axes, major and minor, over the root of the approach [m^0.5].

    See `terms_along`; they are those of `ellipse.semi_axes`.
    """
    return _fit_along(ball_radius, locus_radius, groove_radius, side, lambda *gap: semi_axes(*gap, 1.0)).T


def terms_along(law: Elasticity, ball_radius, locus_radius, groove_radius, side) -> np.ndarray:
    """The polynomial of a law on an inner (side = -1) or outer (side = +1) raceway, lengths in m.

    Its TERMS, then the least |n| - 1.
    """
    if not law.follows:
        return np.array([law.given, *(0.0,) * TERMS])
    return _fit_along(ball_radius, locus_radius, groove_radius, side, functools.partial(fresh_coefficient, law))


FILM_POINTS = np.array([0.0, -0.05, -0.1])  # |n| - 1 at contact angles of 0, 18 and 26 degrees


def films_along(lubricant: np.ndarray, raceway, ball_radius: float, side: float) -> np.ndarray:
    """The numbers of films on an inner (side = -1) or outer (side = +1) raceway, polynomials (FILM_NUMBERS, 3).

    They are logarithms, which hardly bend; `lubricant` as `lubricant.film_lubricant`.
    """
    groove = ball_radius, raceway.locus_radius, raceway.groove_radius
    small, large = np.broadcast_arrays(*groove_curvatures(*groove, side * (1.0 + FILM_POINTS)))
    numbers = film_numbers(lubricant, small, large, raceway.law.modulus, ball_radius)
    return np.linalg.solve(np.vander(FILM_POINTS, increasing=True), numbers).T


HELD, TILTED, LEVEL, TILTING = range(4)  # RingMotion of elements.hpp
NO_LAND = math.inf  # the clearance of a cage that balls alone guide


class Pockets(NamedTuple):
    """Pockets on a circle of `radius` [m]: half their clearance [m], stiffness [N/m], relaxation time [s], friction."""

    radius: float
    half_clearance: float
    stiffness: float
    relaxation_time: float
    friction: float


class Land(NamedTuple):
    """The land of the outer ring (`side` 1) or the inner (-1): radius and radial clearance [m], stiffness [N/m], ...

    Relaxation time [s], friction, and the slip [m/s] below which friction is smoothed.
    """

    side: float
    radius: float
    clearance: float
    stiffness: float
    relaxation_time: float
    friction: float
    smoothing: float


class Shaft(NamedTuple):
    """Moment of inertia [kg m^2] of all that turns with the inner ring, and viscous damping [N m s] of its speed."""

    inertia: float
    damping: float


class MovingHousing(NamedTuple):
    """Housing with the outer ring: mass [kg], stiffness [N/m], damping [N s/m], direction, and its constant load [N].

    The load balances that of the balls at the start, where the housing's place is 0.
    """

    mass: float
    stiffness: float
    damping: float
    direction: tuple[float, float, float]
    load: float = 0.0


class CoupledBodies(NamedTuple):
    """Bodies that couple all balls in a part of a chunk: numbers (POSITIONS,) of ring and cage, in SI.

    `ring` is True if the ring moves with its mass. `housing` is empty for a held outer ring, `land` (a `Land`) for a
    centred cage, `shaft` (a `Shaft`) for a prescribed speed. `free` is 1 for coordinates that follow their loads, else
    0. `load` grows by `load_rate` per second, that of the cage's angle being the torque on the shaft; `unbalance`
    [kg m] turns with the ring. `scales` (2 POSITIONS + 1,) are the errors that a step may make, the last one of the
    shaft's speed; `light` [m] is `integrate.light_approach`.
    """

    ring: bool
    active: bool
    even: bool
    land: tuple
    shaft: tuple
    free: np.ndarray
    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    rest: np.ndarray
    weight: np.ndarray
    load: np.ndarray
    load_rate: np.ndarray
    polar_inertia: float
    unbalance: float
    scales: np.ndarray
    light: float
    housing: tuple = ()


class Raceway(NamedTuple):
    """A toroidal groove and the elastic law of its contacts with the balls, with its `terms_along` the groove."""

    locus_radius: float
    groove_radius: float
    law: Elasticity
    terms: tuple[float, ...]


class Bearing(NamedTuple):
    """Everything the equations of motion need, as numbers (SI).

    `friction_coefficient` is that of balls among themselves, `raceway_friction` that of a raceway at the contact
    point, 0 with friction over the `patch`: coefficient, name of the model, inner and outer semi-axes (`axes_along`).
    `offset` is the displacement of the inner ring's centre, `tilt` that of its axis about x and y [rad], `ring` its
    motion (HELD, ...). `pockets` are those of a cage that balls hit (`Pockets`), `film` the numbers of a lubricant and
    those of its films on both raceways (`lubricant.film_lubricant`, `films_along`), `defects` those of
    `defects.defect_numbers`; each is empty without such parts.
    """

    balls: int
    ball_radius: float
    ball_mass: float
    ball_inertia: float
    inner: Raceway
    outer: Raceway
    offset: tuple[float, float, float]
    gravity: tuple[float, float, float]
    damping: float
    relaxation_time: float
    friction_coefficient: float
    friction_regularisation: float
    pair_coefficient: float
    raceway_friction: float
    patch: tuple
    ring: int
    tilt: tuple[float, float]
    pockets: tuple
    defects: tuple[float, ...] = ()
    film: tuple = ()


class RingDrive(NamedTuple):
    """Prescribed turning of the inner ring: at time t [s] it has speed + acceleration t."""

    angle: float
    speed: float
    acceleration: float

    def later(self, time: float) -> "RingDrive":
        """The same `time` [s] later."""
        angle = self.angle + time * (self.speed + 0.5 * self.acceleration * time)
        return RingDrive(angle, self.speed + self.acceleration * time, self.acceleration)


def raceway_of(geometry, conformity, side, law: Callable) -> Raceway:
    """The groove of the inner (side = -1) or outer (side = +1) ring, its centre circle placed by the clearance.

    With the rings centred, each raceway is a quarter of the diametral clearance away from a ball on the pitch circle.
    `law(small, large)` gives the `Elasticity` from the curvatures [1/m] of the gap there.
    """
    ball_radius = 0.5 * geometry.ball_diameter
    groove_radius = conformity * geometry.ball_diameter
    bottom = 0.5 * geometry.pitch_diameter + side * (ball_radius + 0.25 * geometry.radial_clearance)
    locus_radius = bottom - side * groove_radius
    nominal = ball_in_groove(0.5 * geometry.pitch_diameter, 0.0, ball_radius, locus_radius, groove_radius)
    elastic = law(nominal.curvature_small, nominal.curvature_large)
    terms = tuple(terms_along(elastic, ball_radius, locus_radius, groove_radius, side).tolist())
    return Raceway(locus_radius, groove_radius, elastic, terms)


NEVER = math.inf
SAME = 1e-12  # relative: nearer instants are equal


def distinct_times(*times) -> np.ndarray:
    """These times [s] in rising order, without repetitions."""
    instants = np.unique(np.concatenate(times))
    return instants[np.diff(instants, prepend=-NEVER) > SAME * instants] if len(instants) else instants


class Course:
    """Numbers (m,) over time: `steady`, plus `jump` from `jump_time` [s] on, plus those of a table.

    The table's rows are time and numbers, linear between rows. At `times` numbers or their rates jump.
    """

    def __init__(self, steady, table=(), jump=0.0, jump_time=0.0):
        self.steady, self.jump, self.jump_time = np.array(steady, float), np.asarray(jump), jump_time or NEVER
        self.knots = np.array(table, float).reshape(-1, 1 + len(self.steady))
        self.times = distinct_times(self.knots[:, 0], [jump_time] if jump_time else [])

    def until_next(self, elapsed: float) -> float:
        """Seconds from `elapsed` [s] until the next of `times`, NEVER after the last."""
        later = self.times[self.times > elapsed * (1.0 + SAME)] if len(self.times) else ()
        return float(later[0]) - elapsed if len(later) else NEVER

    def at(self, elapsed: float) -> tuple[np.ndarray, np.ndarray]:
        """The numbers at `elapsed` [s] and their rates, which hold until the next of `times`."""
        value, rate, knots = self.steady, np.zeros_like(self.steady), self.knots
        if elapsed >= self.jump_time * (1.0 - SAME):
            value = value + self.jump
        if not len(knots):
            return value, rate
        row = int(np.searchsorted(knots[:, 0], elapsed * (1.0 + SAME), side="right")) - 1
        if row < 0 or row + 1 == len(knots):
            return value + knots[max(row, 0), 1:], rate
        begin, *start = knots[row]
        rate = (knots[row + 1, 1:] - start) / (knots[row + 1, 0] - begin)
        return value + (start + rate * (elapsed - begin)), rate


class Loading(Course):
    """Loads (5,) [N, N m] over time on the body of a section with the keys `load`, `moment`, `change` and `table`."""

    def __init__(self, section):
        change, self.commanded = section.change, False
        super().__init__((*section.load, *section.moment), section.table, (*change.load, *change.moment), change.time)

    def set(self, force, moment) -> None:
        """Replace the loads by a constant force [N] (3,) and moment [N m] (2 or 3,)."""
        super().__init__((*force, *moment)[:5])
        self.commanded = True


def bearing_of(parameters: BearingScene, law: str) -> Bearing:
    """The numbers of the equations of motion for a scene with the elastic law `law`.

    Contacts of balls with each other follow Hertz's law.
    """
    geometry, materials, contact = operating_geometry(parameters), parameters.materials, parameters.contact
    radius = 0.5 * geometry.ball_diameter
    mass = materials.ball.density * 4.0 / 3.0 * math.pi * radius**3
    pair = effective_modulus(materials.ball, materials.ball)
    friction = FRICTIONS[contact.friction]
    damping, relaxation_time = viscous_terms(contact)

    def law_of(ring):
        modulus = effective_modulus(materials.ball, ring)

        def elastic(small, large):
            return elasticity(law, modulus, LAWS[law].number(contact, hertz_coefficient(small, large, modulus)))

        return elastic

    inner = raceway_of(geometry, geometry.inner_conformity, -1.0, law_of(materials.inner_ring))
    outer = raceway_of(geometry, geometry.outer_conformity, 1.0, law_of(materials.outer_ring))
    patch, coefficient, film = (), contact.friction_coefficient, ()
    if is_lubricated(parameters):
        oil, coefficient = film_lubricant(parameters), parameters.lubricant.boundary_friction
        film = oil, films_along(oil, inner, radius, -1.0), films_along(oil, outer, radius, 1.0)
    if friction.over_patch:
        for raceway, side in ((inner, -1.0), (outer, 1.0)):
            axes = axes_along(radius, raceway.locus_radius, raceway.groove_radius, side)
            patch += (tuple(map(tuple, axes.tolist())),)
        patch = coefficient, contact.friction, *patch
    dimension, cage, pockets = dimension_of(parameters), parameters.cage, ()
    ring = HELD
    if dimension == FREE_RING:
        ring = TILTING if tilts(parameters) or housing_of(parameters) else LEVEL
    elif dimension == PRESCRIBED and any(parameters.drive.tilt):
        ring = TILTED
    if cage.kind == POCKETS and dimension != QUASI_STATIC:
        walls = 0.5 * cage.pocket_clearance, cage.stiffness, cage.relaxation_time, cage.friction
        pockets = Pockets(0.5 * parameters.geometry.pitch_diameter, *walls)
    return Bearing(
        balls=geometry.balls,
        ball_radius=radius,
        ball_mass=mass,
        ball_inertia=0.4 * mass * radius**2,
        inner=inner,
        outer=outer,
        offset=tuple(parameters.drive.offset),
        gravity=tuple(parameters.gravity),
        damping=damping,
        relaxation_time=relaxation_time,
        friction_coefficient=contact.friction_coefficient,
        friction_regularisation=contact.friction_regularisation,
        pair_coefficient=hertz_coefficient(1.0 / radius, 1.0 / radius, pair),
        raceway_friction=0.0 if friction.over_patch else coefficient,
        patch=patch,
        ring=ring,
        tilt=tuple(map(float, parameters.drive.tilt)) if ring in (TILTED, TILTING) else (0.0, 0.0),
        pockets=pockets,
        film=film,
    )


RING_SHARE = 0.3  # of a ball's errors: for a ring that vibrates (`tests/core/algorithms/test_error_scales.py`)


class RingLoading:
    """Loads on the inner ring from outside, and the torque on the shaft, the scene's or commanded ones."""

    def __init__(self, parameters: BearingScene):
        self._ring, drive = parameters.rings.inner, parameters.drive
        self.load, self.torque = Loading(self._ring), Course((drive.torque,), drive.torque_table)
        self.torque_commanded, self._steady = False, None

    def set(self, force, moment) -> None:
        """Set a constant force [N] (3,) and moment [N m] (2 or 3,), or the loads of the scene if both are None."""
        self.load, self._steady = Loading(self._ring), None
        if force is not None:
            self.load.set(force, moment)

    def set_torque(self, torque: float) -> None:
        """Set a constant `torque` [N m] on the shaft."""
        self.torque, self.torque_commanded, self._steady = Course((torque,)), True, None

    def until_next(self, elapsed: float) -> float:
        """Seconds until the next of the times of load and torque."""
        return min(self.load.until_next(elapsed), self.torque.until_next(elapsed))

    def at(self, elapsed: float) -> tuple[np.ndarray, np.ndarray]:
        """Loads [N], [N m] and the torque on a shaft (6,) at `elapsed` [s], and their rates, until the next jump."""
        if self._steady:
            return self._steady
        (load, load_rate), (torque, torque_rate) = self.load.at(elapsed), self.torque.at(elapsed)
        loads = np.concatenate([load, torque]), np.concatenate([load_rate, torque_rate])
        self._steady = None if len(self.load.times) or len(self.torque.times) else loads
        return loads


def body_scales(parameters: BearingScene, scales: np.ndarray) -> np.ndarray:
    """Errors (2 POSITIONS + 1,) that a step of ring, cage and shaft may make, from those of a ball."""
    pitch = 0.5 * parameters.geometry.pitch_diameter
    # Vibrations of a shaft are hardly damped, so that errors of its motion add up for longer than those of balls.
    position, speed = RING_SHARE * scales[AXIS_DISTANCE], RING_SHARE * scales[TANGENTIAL_VELOCITY]
    arm = 1.0 if moving_centre(parameters) else pitch
    lengths = np.array([1.0, 1.0, 1.0, arm, arm, pitch])
    errors = np.concatenate([position / lengths, speed / lengths, [speed / pitch]])
    if parameters.cage.kind == POCKETS:
        errors[[CAGE, CAGE_SPEED]] /= RING_SHARE
    return errors


def land_of(parameters: BearingScene) -> Land | tuple:
    """The land that guides the cage; empty if the cage stays centred."""
    cage = parameters.cage
    if not moving_centre(parameters):
        return ()
    side, radius = -1.0 if cage.guidance == INNER_LAND else 1.0, land_radius(parameters)
    clearance = NO_LAND if cage.guidance == BALLS else cage.land_clearance
    law = cage.stiffness, cage.relaxation_time, cage.friction, parameters.contact.friction_regularisation
    return Land(side, radius, clearance, *law)


def housing_of(parameters: BearingScene) -> MovingHousing | tuple:
    """The housing that moves with the outer ring; empty without a sensor, and where that ring is held.

    It is held where the inner ring is, and where its land guides a cage.
    """
    free = dimension_of(parameters) == FREE_RING and parameters.cage.guidance != OUTER_LAND
    if not has_sensor(parameters) or not free:
        return ()
    housing = parameters.housing
    return MovingHousing(housing.mass, housing.stiffness, housing.damping, parameters.sensor.unit_direction)


def coupled_bodies_of(parameters: BearingScene) -> CoupledBodies:
    """Ring and cage without loads, and without scales: those are `body_scales`."""
    ring, cage, support = parameters.rings.inner, parameters.cage, parameters.rings.inner.support
    moving, caged = dimension_of(parameters) == FREE_RING, cage.kind != "none"
    free = np.array([*(free_coordinates(parameters) if moving else (False,) * 5), caged], float)
    centred = not moving_centre(parameters)
    if not centred:
        free[CAGE_X:CAGE] = 1.0
    tilting = (ring.inertia[0] or 1.0) if centred else cage.mass
    weight = np.asarray(parameters.gravity, float)
    turned = parameters.drive.kind == TORQUE
    inertia = cage_inertia(parameters) if caged else 1.0
    return CoupledBodies(
        ring=moving,
        active=moving or caged or turned,
        even=cage.kind == EVEN,
        land=land_of(parameters),
        shaft=Shaft(shaft_inertia(parameters), float(parameters.drive.damping)) if turned else (),
        free=free,
        mass=np.array([*(ring.mass or 1.0,) * 3, tilting, tilting, inertia]),
        stiffness=np.array([*support.stiffness, *(support.tilt_stiffness * centred,) * 2, 0.0]),
        damping=np.array([*support.damping, *(support.tilt_damping * centred,) * 2, 0.0]),
        rest=np.array([*parameters.drive.offset, *parameters.drive.tilt, 0.0]),
        weight=np.array([*(ring.mass * weight), *(cage.mass * weight[:2] * (not centred)), 0.0]),
        load=np.zeros(POSITIONS),
        load_rate=np.zeros(POSITIONS),
        polar_inertia=ring.inertia[1] * centred,
        unbalance=ring.unbalance if moving else 0.0,
        scales=np.zeros(2 * POSITIONS + 1),
        light=0.0,
        housing=housing_of(parameters),
    )


NO_AXES = ((0.0,) * (TERMS + 1),) * 2
NO_FILM = np.zeros(8)  # a Lubricant of friction.hpp
_latest_bearing: tuple = (None, None)  # the last bearing and its numbers, which all chunks of a run share


def numbers_of(bearing: Bearing) -> tuple[np.ndarray, np.ndarray]:
    """The numbers of a bearing as `bearing_of` of the core reads them, and the points of its friction's quadrature."""
    global _latest_bearing
    latest = _latest_bearing  # read once, since the thread of a second run may replace it
    if latest[0] is not bearing:
        coefficient, model, *axes = bearing.patch or (0.0, POINT, NO_AXES, NO_AXES)
        friction, points = patch_by(model, coefficient)
        raceways = [
            (*raceway[:2], raceway.law.given, raceway.law.modulus, *raceway.terms, *np.ravel(polynomials))
            for raceway, polynomials in zip((bearing.inner, bearing.outer), axes, strict=True)
        ]
        parts = (
            (bearing.ball_radius, bearing.ball_mass, bearing.ball_inertia),
            *(bearing.offset, bearing.tilt, bearing.gravity),
            (bearing.damping, bearing.relaxation_time, bearing.raceway_friction, bearing.friction_regularisation),
            (bearing.inner.law.power, bearing.pair_coefficient, bearing.friction_coefficient),
            *(*raceways, friction, (bearing.inner.law.carried,)),
            *(np.ravel(numbers) for numbers in bearing.film or (NO_FILM,)),
            bearing.defects or (0.0,),
        )
        latest = _latest_bearing = bearing, (np.concatenate(parts), points)
    return latest[1]


COORDINATES, HOUSING, SHAFT = 10, 8, 9  # ring x, y, z, its tilt about x and y, cage x, y, its angle, housing, shaft
CAGE_KINDS = "none", EVEN, POCKETS  # CageKind of the core
_latest_bodies: tuple = (None, None)  # the last bearing, masses and scales of its bodies, and their numbers


def numbers_of_bodies(bearing: Bearing, bodies: CoupledBodies) -> np.ndarray:
    """The numbers of CoupledBodies as the core reads them, but for those that change from part to part."""
    global _latest_bodies
    latest, key = _latest_bodies, (id(bearing), id(bodies.mass), id(bodies.scales))
    if latest[0] != key:
        latest = key, _numbers_of_bodies(bearing, bodies), (bearing, bodies)  # which keeps their ids
        _latest_bodies = latest
    return latest[1]


def _numbers_of_bodies(bearing: Bearing, bodies: CoupledBodies) -> np.ndarray:
    guided, shaft = bool(bodies.land), bodies.shaft or Shaft(1.0, 0.0)
    housing = bodies.housing or MovingHousing(1.0, 0.0, 0.0, (0.0, 0.0, 0.0))
    columns = [0, 1, 2, *((5, 6) if guided else (3, 4)), 7]  # tilts, or the centre of a cage

    def spread(values, of_housing=0.0, of_shaft=0.0) -> np.ndarray:
        coordinates = np.zeros(COORDINATES)
        coordinates[columns], coordinates[HOUSING], coordinates[SHAFT] = values, of_housing, of_shaft
        return coordinates

    free = spread(bodies.free, bool(bodies.housing), bool(bodies.shaft))
    free[:CAGE] *= bodies.ring
    cage = "none" if not bodies.free[CAGE] else EVEN if bodies.even else POCKETS
    position_scales, speed_scales = np.split(bodies.scales[: 2 * POSITIONS], 2)
    return np.concatenate(
        [
            *((bearing.ring, CAGE_KINDS.index(cage), guided), free),
            *(spread(bodies.mass, housing.mass, shaft.inertia), spread(bodies.stiffness, housing.stiffness)),
            *(spread(bodies.damping, housing.damping, shaft.damping), spread(bodies.rest)),
            *(spread(bodies.weight, housing.load), spread(position_scales, position_scales[0])),
            *(spread(speed_scales, speed_scales[0], bodies.scales[2 * POSITIONS]),),
            (bodies.polar_inertia, bodies.unbalance, 0.0, bodies.light),
            *(bearing.pockets or (0.0,) * 5, bodies.land or (0.0,) * 7, housing.direction),
        ],
        dtype=float,
    )


def _zero_padded(values, *shape: int) -> np.ndarray:
    """The numbers of an array in one row, padded with zeros to this shape."""
    return np.pad(values, [(0, wide - size) for wide, size in zip(shape, np.shape(values), strict=True)]).ravel()


_SQUARE = MOST_STAGES, MOST_STAGES - 1


@functools.cache
def method_numbers(name: str) -> np.ndarray:
    """The numbers of a method of ROSENBROCK as the core's RosenbrockMethod has them."""
    method = ROSENBROCK[name]
    return np.concatenate(
        [
            [len(method.alpha), method.order, method.lands, method.gamma],
            *(_zero_padded(method.a, *_SQUARE), _zero_padded(method.c, *_SQUARE)),
            *(_zero_padded(method.alpha, MOST_STAGES), _zero_padded(method.d, MOST_STAGES)),
            _zero_padded(method.dense, 2, MOST_STAGES - 1),
        ]
    )


@functools.cache
def runge_kutta_numbers(name: str) -> np.ndarray:
    """The numbers of a method of EXPLICIT as the core's RungeKuttaMethod has them."""
    method = EXPLICIT[name]
    return np.concatenate(
        [
            [len(method.nodes), method.order],
            *(_zero_padded(method.a, *_SQUARE), _zero_padded(method.nodes, MOST_STAGES)),
            *(_zero_padded(method.weights, MOST_STAGES), _zero_padded(method.error, MOST_STAGES + 1)),
        ]
    )
