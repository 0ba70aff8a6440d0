"""The numbers of a bearing's equations of motion (paper 1, section 5), which the compiled core takes, from a scene.

Frames. `bearing_link` has its origin at the outer ring's centre and z along the axis. The motion of each ball is
written in the frame that turns with that ball about the axis, with unit vectors (radial, tangential, axial): there
steady rolling is an equilibrium, and only the orbit angle grows.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial

from bearing_twin.contact.elasticity import Elasticity, elasticity, fresh_coefficient, hertz_coefficient, semi_axes
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.kinds.bearing.geometry import operating_geometry
from bearing_twin.kinds.bearing.lubricant import film_lubricant, film_numbers, lubricated
from bearing_twin.kinds.bearing.parameters import BearingScene, viscous_terms
from bearing_twin.kinds.bearing.rings import (
    BALLS,
    EVEN,
    FREE_RING,
    INNER_LAND,
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
from bearing_twin.shapes.closed_forms import ball_in_groove, groove_curvatures

# Velocity and angular velocity: radial, tangential, axial, in the frame that turns with the ball about the axis.
AXIS_DISTANCE, ORBIT_ANGLE, HEIGHT, RADIAL_VELOCITY, TANGENTIAL_VELOCITY, AXIAL_VELOCITY = np.arange(6)
RADIAL_SPIN, TANGENTIAL_SPIN, AXIAL_SPIN, DRIVE_WORK, DISSIPATED, GROSS_WORK = np.arange(6, 12)
VELOCITY, SPIN = RADIAL_VELOCITY, RADIAL_SPIN
MOTION = 9  # the columns before this one are the motion; the rest only listen
COLUMNS = 12
CARRIED_COLUMNS = 8  # what a law carries: P/Q and three states at each of a ball's contacts

# Inner ring and cage: places (the ring's centre, its tilt about x and y, the cage's angle), their velocities, and
# integrals that only listen: work of the loads on the ring, what is lost, work of the drive through the cage's land.
PLACES = 6
CAGE_X, CAGE_Y, CAGE = 3, 4, 5  # in the place of tilts: a ring does not tilt where the cage's centre moves
CAGE_SPEED = PLACES + CAGE
LAND_WORK, SHAFT_ANGLE, SHAFT_SPEED = 14, 15, 16  # then the work of a torque that turns the shaft
BORDER = 18


# Across a groove the gap between it and a ball has one curvature, along it one that follows from the radial part n of
# the contact's normal alone (`closed_forms.groove_curvatures`): so do the coefficient of a law that follows curvatures,
# and the semi-axes of a contact over the root of its approach. They are computed at Chebyshev's points and kept as
# polynomials in |n| - 1, so that all laws cost the same and slopes are exact. The points reach to a right angle, or to
# where the groove's radius about the axis is FURTHEST times that at angle zero, or as small a part: at 0.52 of the
# ball, to 67 degrees where balls are half the pitch circle. Beyond, the coefficient stays. Relative errors are 6e-14 in
# a 6203 and 3e-11 where balls are 0.4 of the pitch circle or more (`tests/core/test_groove_polynomials.py`).
TERMS = 10
FURTHEST = 1.7


def _points_and_fit() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Chebyshev's points (TERMS,) between -1 and 0, what makes a series of numbers there, and terms of the series.

    One after the other: the product of both matrices loses five digits.
    """
    places = np.cos(np.pi * (np.arange(TERMS) + 0.5) / TERMS)
    bases = (Chebyshev.basis(order)(places) for order in range(TERMS))
    series = np.array([basis * (2.0 - (order == 0)) / TERMS for order, basis in enumerate(bases)])
    powers = np.zeros((TERMS, TERMS))
    for order in range(TERMS):
        powers[: order + 1, order] = Chebyshev.basis(order).convert(kind=Polynomial)(Polynomial([1.0, 2.0])).coef
    return 0.5 * (places - 1.0), series, powers


_POINTS, _SERIES, _POWERS = _points_and_fit()


def _along(ball_radius, locus_radius, groove_radius, side, radials, what):
    """Values of `what(small, large)` at the gap's curvatures where the normal has these radial parts."""
    return what(*groove_curvatures(ball_radius, locus_radius, groove_radius, side * radials))


def _reach_of(locus_radius, groove_radius, side):
    """1 - |n| up to which the groove's radius about the axis is near that at angle zero."""
    level = abs(side * locus_radius / groove_radius + 1.0)  # the radius there, over that of the groove
    return min(1.0, level * (FURTHEST - 1.0 if side < 0.0 else 1.0 - 1.0 / FURTHEST))


def _terms(found, reach) -> tuple[float, ...]:
    """The terms of the polynomial through these numbers (TERMS,), and then how far |n| - 1 falls to."""
    return (*(_POWERS @ (_SERIES @ found) / reach ** np.arange(TERMS)).tolist(), -reach)


def axes_along(ball_radius, locus_radius, groove_radius, side) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The polynomials of a contact's semi-axes, major and minor, over the root of the approach [m^0.5].

    See `terms_along`; they are those of `ellipse.semi_axes`.
    """
    reach, groove = _reach_of(locus_radius, groove_radius, side), (ball_radius, locus_radius, groove_radius, side)
    major, minor = _along(*groove, 1.0 + reach * _POINTS, lambda small, large: semi_axes(small, large, 1.0))
    return _terms(major, reach), _terms(minor, reach)


def terms_along(law: Elasticity, ball_radius, locus_radius, groove_radius, side) -> tuple[float, ...]:
    """The polynomial of a law on an inner (side = -1) or outer (side = +1) raceway, lengths in m.

    Its TERMS, and then how far |n| - 1 falls to.
    """
    if not law.follows:
        return (law.given, *(0.0,) * TERMS)
    reach, groove = _reach_of(locus_radius, groove_radius, side), (ball_radius, locus_radius, groove_radius, side)
    found = _along(*groove, 1.0 + reach * _POINTS, lambda small, large: fresh_coefficient(law, small, large))
    return _terms(found, reach)


FILM_PLACES = np.array([0.0, -0.05, -0.1])  # |n| - 1 at contact angles of 0, 18 and 26 degrees


def films_along(lubricant: np.ndarray, raceway, ball_radius: float, side: float) -> np.ndarray:
    """The numbers of films on an inner (side = -1) or outer (side = +1) raceway, polynomials (FILM_NUMBERS, 3).

    They are logarithms, which hardly bend; `lubricant` as `lubricant.film_lubricant`.
    """
    groove = ball_radius, raceway.locus_radius, raceway.groove_radius
    small, large = np.broadcast_arrays(*groove_curvatures(*groove, side * (1.0 + FILM_PLACES)))
    found = film_numbers(lubricant, small, large, raceway.law.modulus, ball_radius)
    return np.linalg.solve(np.vander(FILM_PLACES, increasing=True), found).T


HELD, TILTED, LEVEL, TILTING = range(4)  # RingMotion of coupled_bodies.hpp: held, moving, tilted
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


class CoupledBodies(NamedTuple):
    """Bodies that couple all balls in a part of a chunk: numbers (PLACES,) of ring and cage, in SI.

    `ring` says whether the ring moves with its mass. `land` is empty where the cage stays centred, else what guides it
    (a `Land`). `shaft` is empty where the ring's speed is prescribed, else what a torque turns (a `Shaft`). `free` is 1
    where a place follows its loads, else 0. `load` grows by `load_rate` a second, in the cage's place the torque on the
    shaft; `unbalance` [kg m] turns with the ring. `scales` (2 PLACES + 1,) are the errors a step
    may make, the last of the shaft's speed; `light` [m] is as `step_control.light_approach` says.
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


def outside_loads(bodies: CoupledBodies, drive, time: float) -> np.ndarray:
    """Loads (5,) [N, N m] on the free coordinates of the ring `time` [s] into the part, weight not counted."""
    loads = bodies.load[:CAGE] + time * bodies.load_rate[:CAGE]
    speed = drive.speed + drive.acceleration * time
    angle = drive.angle + time * (drive.speed + 0.5 * drive.acceleration * time)
    loads[:2] += bodies.unbalance * speed**2 * np.array([math.cos(angle), math.sin(angle)])
    return np.where(bodies.free[:CAGE] > 0.0, loads, 0.0)


class Raceway(NamedTuple):
    """A toroidal groove and the elastic law of its contacts with the balls, with its `terms_along` the groove."""

    locus_radius: float
    groove_radius: float
    law: Elasticity
    terms: tuple[float, ...]


class Bearing(NamedTuple):
    """Everything the equations of motion need, as numbers (SI).

    `friction_coefficient` is that of balls among themselves, `raceway_friction` that of a raceway at the contact
    point; it is 0 where `patch`, empty else, says how friction acts over the contact patch: coefficient, its model's
    name and inner and outer semi-axes (`axes_along`).
    `offset` is the place of the inner ring's centre, `tilt` that of its axis about x and y [rad]; `ring` says how it
    moves (HELD, ...).
    `pockets`, empty else, are those of a cage that balls bump into (`Pockets`). `film`, empty else, are
    the numbers of a lubricant and those of its films on both raceways (`lubricant.film_lubricant`, `films_along`);
    `defects` are those of `defects.defect_numbers`, empty for smooth surfaces.
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


def approaches(bearing: Bearing, motion: np.ndarray) -> tuple[float, float]:
    """Approaches [m] of a ball at the inner and at the outer raceway; `motion` starts with its position."""
    radius, angle, height = (float(motion[column]) for column in (AXIS_DISTANCE, ORBIT_ANGLE, HEIGHT))
    cosine, sine = math.cos(angle), math.sin(angle)
    x, y, z = bearing.offset
    across = radius - (cosine * x + sine * y), sine * x - cosine * y, height - z
    if any(bearing.tilt):  # in the axes of the tilted ring
        a, b = bearing.tilt
        a, b = cosine * a + sine * b, cosine * b - sine * a
        axes = np.array([[1.0 + a * a, a * b, -b], [a * b, 1.0 + b * b, a], [b, -a, 1.0]]) / (1.0 + a * a + b * b)
        across = axes @ across
    places = (bearing.inner, math.hypot(across[0], across[1]), across[2]), (bearing.outer, radius, height)
    return tuple(
        ball_in_groove(distance, rise, bearing.ball_radius, race.locus_radius, race.groove_radius).approach
        for race, distance, rise in places
    )


def raceway_of(geometry, conformity, side, law: Callable) -> Raceway:
    """The groove of the inner (side = -1) or outer (side = +1) ring, its centre circle placed by the clearance.

    With the rings centred, each raceway is a quarter of the diametral clearance away from a ball on the pitch circle.
    `law(small, large)` gives the `Elasticity` from the curvatures [1/m] of the gap there.
    """
    ball_radius = 0.5 * geometry.ball_diameter
    groove_radius = conformity * geometry.ball_diameter
    bottom = 0.5 * geometry.pitch_diameter + side * (ball_radius + 0.25 * geometry.radial_clearance)
    locus_radius = bottom - side * groove_radius
    still = ball_in_groove(0.5 * geometry.pitch_diameter, 0.0, ball_radius, locus_radius, groove_radius)
    found = law(still.curvature_small, still.curvature_large)
    terms = terms_along(found, ball_radius, locus_radius, groove_radius, side)
    return Raceway(locus_radius, groove_radius, found, terms)


NEVER = math.inf
SAME = 1e-12  # relative: instants nearer than this are one


class Loading:
    """Loads (5,) [N, N m] over time on the body of a section with the keys `load`, `moment`, `change` and `table`."""

    def __init__(self, section):
        self.load = np.array([*section.load, *section.moment])
        self.change = np.array([*section.change.load, *section.change.moment])
        self.change_time = section.change.time or NEVER
        self.knots, self.commanded = np.array(section.table).reshape(-1, 6), False
        self.times = apart(self.knots[:, 0], [section.change.time] if section.change.time else [])

    def __copy__(self) -> "Loading":
        """The same, to be commanded by itself: in a fifth of the time of Python's own copy, as every start does it."""
        found = object.__new__(type(self))
        vars(found).update(vars(self))
        return found

    def set(self, force, moment) -> None:
        """From now on force [N] (3,) and moment [N m] (2 or 3,) act in place of the scene's."""
        self.load = np.array([*force, *moment], float)[:5]
        self.change_time, self.knots, self.commanded = NEVER, np.empty((0, 6)), True
        self.times = np.empty(0)

    def until_next(self, elapsed: float) -> float:
        """Seconds until the load jumps, or grows otherwise."""
        return next_after(self.times, elapsed) - elapsed

    def at(self, elapsed: float) -> tuple[np.ndarray, np.ndarray]:
        """Load (5,) at `elapsed` [s] and its rate (5,), which hold until the next jump."""
        jumped = elapsed >= self.change_time * (1.0 - SAME)
        load = self.load + self.change if jumped else self.load
        more, rate = between(self.knots, elapsed)
        return load if more is None else load + more, rate


def apart(*times) -> np.ndarray:
    """All of these times [s] in rising order, once each where they are one."""
    found = np.unique(np.concatenate(times))
    return found[np.diff(found, prepend=-NEVER) > SAME * found] if len(found) else found


def next_after(times: np.ndarray, elapsed: float) -> float:
    """The first of rising `times` (n,) [s] that is later than `elapsed`, NEVER where none is."""
    row = int(np.searchsorted(times, elapsed * (1.0 + SAME), side="right"))
    return float(times[row]) if row < len(times) else NEVER


def between(knots: np.ndarray, elapsed: float) -> tuple[np.ndarray | None, np.ndarray]:
    """Values of a table (n, 1 + m), time first, at `elapsed` [s], None where it has no row, and its rate (m,)."""
    rate = np.zeros(knots.shape[1] - 1)
    if not len(knots):
        return None, rate
    row = int(np.searchsorted(knots[:, 0], elapsed * (1.0 + SAME), side="right")) - 1
    if row < 0 or row + 1 == len(knots):
        return knots[max(row, 0), 1:], rate
    rate = (knots[row + 1, 1:] - knots[row, 1:]) / (knots[row + 1, 0] - knots[row, 0])
    return knots[row, 1:] + rate * (elapsed - knots[row, 0]), rate


def bearing_of(parameters: BearingScene, law: str) -> Bearing:
    """The numbers of the equations of motion for a scene with the elastic law `law`.

    Balls meet each other by Hertz's law, whatever the raceways do.
    """
    geometry, materials, contact = operating_geometry(parameters), parameters.materials, parameters.contact
    radius = 0.5 * geometry.ball_diameter
    mass = materials.ball.density * 4.0 / 3.0 * math.pi * radius**3
    pair = effective_modulus(materials.ball, materials.ball)
    friction = FRICTIONS[contact.friction]
    damping, relaxation_time = viscous_terms(contact)

    def law_of(ring):
        modulus = effective_modulus(materials.ball, ring)

        def at(small, large):
            return elasticity(law, modulus, LAWS[law].number(contact, hertz_coefficient(small, large, modulus)))

        return at

    inner = raceway_of(geometry, geometry.inner_conformity, -1.0, law_of(materials.inner_ring))
    outer = raceway_of(geometry, geometry.outer_conformity, 1.0, law_of(materials.outer_ring))
    patch, coefficient, film = (), contact.friction_coefficient, ()
    if lubricated(parameters):
        oil, coefficient = film_lubricant(parameters), parameters.lubricant.boundary_friction
        film = oil, films_along(oil, inner, radius, -1.0), films_along(oil, outer, radius, 1.0)
    if friction.over_spot:
        axes = [
            axes_along(radius, one.locus_radius, one.groove_radius, side) for one, side in ((inner, -1.0), (outer, 1.0))
        ]
        patch = coefficient, contact.friction, *axes
    dimension, cage, pockets = dimension_of(parameters), parameters.cage, ()
    ring = HELD
    if dimension == FREE_RING:
        ring = TILTING if tilts(parameters) else LEVEL
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
        raceway_friction=0.0 if friction.over_spot else coefficient,
        patch=patch,
        ring=ring,
        tilt=tuple(map(float, parameters.drive.tilt)) if ring in (TILTED, TILTING) else (0.0, 0.0),
        pockets=pockets,
        film=film,
    )


RING_SHARE = 0.3  # of a ball's errors: a ring that rings bears no more (`tests/test_error_scales.py`)


class RingLoading(Loading):
    """Loads on the inner ring from outside, and the torque on the shaft, the scene's or commanded ones."""

    def __init__(self, parameters: BearingScene):
        super().__init__(parameters.rings.inner)
        drive = parameters.drive
        self.torque, self.torque_knots = drive.torque, np.array(drive.torque_table).reshape(-1, 2)
        self.torque_commanded = False
        self._steady = None

    def set(self, force, moment) -> None:
        """From now on force [N] (3,) and moment [N m] (2 or 3,) act in place of the scene's."""
        super().set(force, moment)
        self._steady = None

    def loaded(self, parameters: BearingScene, force, moment) -> "RingLoading":
        """The same with other loads, or the scene's own where both are None; a commanded torque stays."""
        found = RingLoading(parameters)
        if force is not None:
            found.set(force, moment)
        if self.torque_commanded:
            found.set_torque(self.torque)
        return found

    def set_torque(self, torque: float) -> None:
        """From now on `torque` [N m] turns the shaft in place of the scene's."""
        self.torque, self.torque_knots, self.torque_commanded = float(torque), np.empty((0, 2)), True
        self._steady = None

    def until_next(self, elapsed: float) -> float:
        """Seconds until the load or the torque jumps, or grows otherwise."""
        return min(super().until_next(elapsed), next_after(self.torque_knots[:, 0], elapsed) - elapsed)

    def with_torque(self, elapsed: float) -> tuple[np.ndarray, np.ndarray]:
        """Loads [N], [N m], with the torque on a shaft (6,), at `elapsed` [s], and their rates, until the next jump.

        The same arrays each time where they never jump.
        """
        if self._steady is not None:
            return self._steady
        more, torque_rate = between(self.torque_knots, elapsed)
        torque = self.torque if more is None else self.torque + float(more[0])
        load, rate = self.at(elapsed)
        found = np.append(load, torque), np.append(rate, torque_rate)
        if not len(self.times) and not len(self.torque_knots):
            self._steady = found
        return found


def border_scales(parameters: BearingScene, scales: np.ndarray) -> np.ndarray:
    """Errors (2 PLACES + 1,) that a step of ring, cage and shaft may make, from those of a ball (MOTION,)."""
    pitch = 0.5 * parameters.geometry.pitch_diameter
    # Little stops a shaft that rings, so that errors of its motion add up for longer than those of balls and cage.
    place, speed = RING_SHARE * scales[AXIS_DISTANCE], RING_SHARE * scales[TANGENTIAL_VELOCITY]
    about = 1.0 if moving_centre(parameters) else pitch
    found = np.array(
        [
            *(place,) * 3,
            *(place / about,) * 2,
            place / pitch,
            *(speed,) * 3,
            *(speed / about,) * 2,
            *(speed / pitch,) * 2,
        ]
    )
    if parameters.cage.kind == POCKETS:
        found[[CAGE, CAGE_SPEED]] /= RING_SHARE
    return found


def land_of(parameters: BearingScene) -> Land | tuple:
    """The land that guides the cage, empty where it stays centred."""
    cage = parameters.cage
    if not moving_centre(parameters):
        return ()
    side, radius = -1.0 if cage.guidance == INNER_LAND else 1.0, land_radius(parameters)
    clearance = NO_LAND if cage.guidance == BALLS else cage.land_clearance
    law = cage.stiffness, cage.relaxation_time, cage.friction, parameters.contact.friction_regularisation
    return Land(side, radius, clearance, *law)


def coupled_bodies_of(parameters: BearingScene) -> CoupledBodies:
    """Ring and cage without loads, and without scales: those are `border_scales`."""
    ring, cage, support = parameters.rings.inner, parameters.cage, parameters.rings.inner.support
    moving, caged = dimension_of(parameters) == FREE_RING, cage.kind != "none"
    free = np.array([*(free_coordinates(parameters) if moving else (False,) * 5), caged], float)
    centred = not moving_centre(parameters)
    if not centred:
        free[CAGE_X:CAGE] = 1.0
    about = (ring.inertia[0] or 1.0) if centred else cage.mass
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
        mass=np.array([*(ring.mass or 1.0,) * 3, about, about, inertia]),
        stiffness=np.array([*support.stiffness, *(support.tilt_stiffness * centred,) * 2, 0.0]),
        damping=np.array([*support.damping, *(support.tilt_damping * centred,) * 2, 0.0]),
        rest=np.array([*parameters.drive.offset, *parameters.drive.tilt, 0.0]),
        weight=np.array([*(ring.mass * weight), *(cage.mass * weight[:2] * (not centred)), 0.0]),
        load=np.zeros(PLACES),
        load_rate=np.zeros(PLACES),
        polar_inertia=ring.inertia[1] * centred,
        unbalance=ring.unbalance if moving else 0.0,
        scales=np.zeros(2 * PLACES + 1),
        light=0.0,
    )
