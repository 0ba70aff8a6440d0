"""Equilibria of balls and inner ring (Jones 1960; Harris, Rolling Bearing Analysis): five coordinates, held or free.

The equations are those of `core/bearing/equilibrium.hpp`, which solves them; here are their
numbers from a scene, the raceway control of the balls, why there is no equilibrium, and which loads are carried.
"""

import functools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.ctypeslib import ndpointer

from bearing_twin.base.errors import BearingTwinError, SceneError
from bearing_twin.base.report import summary_text
from bearing_twin.base.stopping import SIGNALLED
from bearing_twin.base.units import rounded_to_error
from bearing_twin.contact.elasticity import ellipse as ellipses_at
from bearing_twin.contact.elasticity import elliptic_e
from bearing_twin.contact.friction import AUTO, POINT
from bearing_twin.core import INTEGER, INTEGERS, INTEGERS_OUT, REALS, REALS_OUT, Function
from bearing_twin.kinds.bearing.defects import defect_numbers, heights_under
from bearing_twin.kinds.bearing.geometry import moduli
from bearing_twin.kinds.bearing.parameters import GREATEST_ANGLE, GREATEST_SQUEEZE, with_friction
from bearing_twin.kinds.bearing.ratings import command_warning
from bearing_twin.kinds.bearing.rings import (
    CONTROLS,
    COORDINATE_NAMES,
    FREE_RING,
    INNER_LAND,
    OUTER,
    PRESCRIBED,
    SHARED,
    SPEED,
    TORQUE,
    dimension_of,
    free_coordinates,
    idle_loads,
    moving_centre,
    torque_problem,
)
from bearing_twin.kinds.bearing.system import Raceway, bearing_of
from bearing_twin.kinds.contract import OperatingPoint

UNLOADED_SHARE = 1e-3  # of the greatest load: below it the angle of a contact has no limit
FOUND, NOTHING_CARRIES, TOO_MUCH, STOPPED = range(4)  # statuses of an equilibrium in the core
BOUNCE = 3.0  # times the centrifugal load: difference of loads of light balls in motion
COORDINATES = 5  # of a ring: x, y, z, theta_x, theta_y
OF_CONTACTS = 17  # numbers of the `Contacts` of a ball
SPEED_COLUMN = 32  # of the speed among a setting's numbers

STOP = ndpointer(np.uint8, shape=(1,))
_INPUTS = INTEGER, INTEGER, INTEGERS, REALS, REALS, REALS, INTEGERS, REALS, REALS, STOP
_equilibria = Function("core_equilibria", None, (*_INPUTS, *(REALS_OUT,) * 6, INTEGERS_OUT))


class Setting(NamedTuple):
    """The numbers of the balance (SI): grooves, ball, `arm` of a tilt, speed [rad/s], shares of the gyroscopic moment.

    `arm` [m] turns a tilt into axial displacement and an axial force into a moment; `lever` [m] is the arm of the
    friction that carries the gyroscopic moment, about the point at the end of `arm`.
    """

    inner: Raceway
    outer: Raceway
    ball_radius: float
    ball_mass: float
    pitch_diameter: float
    arm: float
    lever: float
    speed: float
    share_inner: float
    share_outer: float

    def numbers(self, gravity=(0.0, 0.0, 0.0), axial_position=0.0, facing=1.0, offset=0.0) -> np.ndarray:
        """The core's `Seat`, with `gravity` [m/s^2]; of a ring on a shaft: position [m], side and offset [m]."""
        inner, outer = ((*raceway[:2], *raceway.terms) for raceway in (self.inner, self.outer))
        seat = *gravity, axial_position, facing, offset
        return np.array([*inner, *outer, self.inner.law.power, *self[2:], *seat])


class Contacts(NamedTuple):
    """Arrays (..., N, 2), inner and outer; `friction` [N] is along t.

    A ball's row (..., N): `orbit` [rad/s], `roll` [rad/s] along the axis and `pitch` [rad/s] along the radius, both of
    the ball against its orbit; `centrifugal` [N]; `share` is the orbit's speed over the ring's. Angles count where
    there is no load too.
    """

    approach: np.ndarray
    load: np.ndarray
    angle: np.ndarray
    friction: np.ndarray
    curvature_small: np.ndarray
    curvature_large: np.ndarray
    orbit: np.ndarray
    roll: np.ndarray
    pitch: np.ndarray
    centrifugal: np.ndarray
    share: np.ndarray


def contacts_in(numbers: np.ndarray) -> Contacts:
    """The contacts that the core wrote into an array (..., N, OF_CONTACTS), as views of it."""
    return Contacts(*(numbers[..., i : i + 2] for i in range(0, 12, 2)), *np.moveaxis(numbers[..., 12:], -1, 0))


class Solved(NamedTuple):
    """Equilibria (C, ...): coordinates, loads, stiffness, balls' `positions` (C, N, 2), `residual` [N], status.

    `contacts` (C, N, OF_CONTACTS) are read by `contacts_in`.
    """

    coordinates: np.ndarray
    loads: np.ndarray
    stiffness: np.ndarray
    positions: np.ndarray
    contacts: np.ndarray
    residual: np.ndarray
    status: np.ndarray


def solve_batch(seats, balls, azimuths, free, loads, held, heights=0.0) -> Solved:
    """Equilibria with the free coordinates under `loads` (C, 5) [N, N m], the others `held` (C, 5) [m, rad].

    `seats` (C, rings, SEAT) are `Setting.numbers`, `balls` (rings,) how many there are, at `azimuths` (C, N) [rad].
    `heights` ([C,] N, 2) [m] are those of the inner and the outer raceway under the balls.
    """
    cases, count = len(loads), azimuths.shape[-1]
    shapes = (5,), (5,), (5, 5), (count, 2), (count, OF_CONTACTS), ()
    solved = Solved(*(np.empty((cases, *shape)) for shape in shapes), np.empty(cases, np.int64))
    _equilibria(
        *(cases, len(balls), np.array(balls, np.int64), seats, azimuths, np.zeros((cases, count, 2)) + heights),
        *(np.array(free, np.int64), loads, held, SIGNALLED, *solved),
    )
    return solved


def load_weighted_mean(contacts: Contacts, values: np.ndarray) -> float:
    """Mean of `values` (N,), weighted by loads on the inner raceway: of orbit speeds, that of balls in one cage."""
    load = contacts.load[:, 0]
    weight = load.sum()
    return float(load @ values / weight if weight > 0.0 else values.mean())


def limit_ratios(ball_radius, load, approach, angle) -> tuple[np.ndarray, np.ndarray]:
    """Squeeze and greatest contact angle of each ball, each over its limit, from arrays (..., N, 2) of both raceways.

    `ball_radius` [m] broadcasts against (..., N).
    The angle of a contact that carries less than UNLOADED_SHARE of the greatest load does not count.
    """
    squeeze = np.where((load > 0.0).all(-1), approach.sum(-1), 0.0)
    greatest_angle = np.where(load > UNLOADED_SHARE * load.max(axis=(-2, -1), keepdims=True), np.abs(angle), 0.0).max(
        -1
    )
    return squeeze / (GREATEST_SQUEEZE * 2.0 * ball_radius), greatest_angle / GREATEST_ANGLE


LOOSE_STIFFNESS = 1e-9  # of the greatest stiffness: softer directions are loose
LOAD_ROUNDING = 1e-12  # of the greatest component: below it a component of a load is shown as 0
GREATEST_COORDINATE = 0.2  # of the ball diameter: bound of the ring's coordinates
FIRST_FACTOR, BISECTIONS, FAILURE_COST = (
    8.0,
    14,
    4,
)  # of the search of the greatest load: first factor, bisections, cost of one that fails
LEAST_SHARE, HEAVY_LOAD = 1e-6, 1e6  # share of a load, of HEAVY [N] at most, below which the greatest load is none


class Support(NamedTuple):
    """Support of the inner ring: which of x, y, z, theta_x, theta_y are `free`, their loads, and where others are held.

    `loads` [N, N m] (5,) act on the ring, `held` [m, rad] (5,) are coordinates; each counts where it applies.
    """

    free: tuple
    loads: tuple
    held: tuple


class Equilibrium(NamedTuple):
    """A bearing in balance: ring `coordinates` (5,), external `loads` (5,), `stiffness` (5, 5) of loads by coordinates.

    `azimuths` [rad] (N,) and `positions` (N, 2) of the balls, `contacts`, `residual` [N] of the ring's balance; it is
    an equilibrium if `status` is FOUND. `control` names the raceway control of the balls.
    """

    coordinates: np.ndarray
    loads: np.ndarray
    stiffness: np.ndarray
    azimuths: np.ndarray
    positions: np.ndarray
    contacts: Contacts
    residual: float
    status: int
    control: str = ""


def setting_of(parameters, law: str, speed: float, arm: str = "groove") -> Setting:
    """The numbers of the equilibrium for a scene; with the control `auto` both raceways carry gyroscopic moments.

    `arm` of a tilt: "groove", to the inner groove's centre, the true geometry; or "pitch", to the pitch circle, as
    commercial programs have it.
    """
    bearing = bearing_of(with_friction(parameters, POINT), law)  # equilibria hold no friction
    lever, reach = bearing.inner.groove_radius, bearing.inner.locus_radius
    if arm == "pitch":
        lever, reach = bearing.ball_radius, 0.5 * parameters.geometry.pitch_diameter
    pitch = parameters.geometry.pitch_diameter
    sizes = bearing.ball_radius, bearing.ball_mass, pitch, reach, lever, float(speed)
    return Setting(bearing.inner, bearing.outer, *sizes, *CONTROLS[parameters.model.control])


def support_of(parameters) -> Support:
    """The support of a scene's ring: its loads, and the coordinates that its drive holds."""
    ring, drive = parameters.rings.inner, parameters.drive
    return Support(free_coordinates(parameters), (*ring.load, *ring.moment), (*drive.offset, *drive.tilt))


def support_with_weight(parameters, loads=None) -> Support:
    """`support_of` plus the weights on the ring: its own and that of a cage that rests on its land.

    `loads` (5,) [N, N m] replace those of the scene.
    """
    support, ring, cage = support_of(parameters), parameters.rings.inner, parameters.cage
    applied, gravity = np.array(support.loads if loads is None else loads, float), np.array(parameters.gravity, float)
    applied[:3] += ring.mass * gravity
    if dimension_of(parameters) == FREE_RING and moving_centre(parameters) and cage.guidance == INNER_LAND:
        applied[:2] += cage.mass * gravity[:2]
    return support._replace(loads=tuple(np.where(support.free, applied, 0.0).tolist()))


def load_line(support: Support) -> float:
    """Azimuth [rad] of the radial load, else of the displacement, moment or tilt, else 0."""
    across = [0, 1, 3, 4]
    applied = support.loads if np.any(np.take(support.loads, across)) else support.held
    return float(azimuths_on(np.array([applied]))[0])


def azimuths_of(balls: int, first: float) -> np.ndarray:
    """Azimuths [rad] (N,) of balls evenly spaced from `first` on."""
    return first + 2.0 * math.pi * np.arange(balls) / balls


class EquilibriumSolver:
    """Equilibria of one bearing with balls at these azimuths [rad] (N,), under `gravity` [m/s^2] (3,).

    `defect_scene` are the parameters of a scene with defects; contacts have the size of those on smooth raceways.
    """

    body = "the ring"
    defect_scene, heights = None, 0.0  # of the raceways under the balls [m]
    remedy = "load it, or hold it by a displacement or by less clearance"

    def __init__(self, setting: Setting, azimuths: np.ndarray, gravity=(0.0, 0.0, 0.0), defect_scene=None):
        self.setting, self.azimuths, self.gravity = setting, np.array(azimuths, float), gravity
        self.defect_scene, self.balls = defect_scene, (len(azimuths),)
        self.longest = GREATEST_COORDINATE * 2.0 * setting.ball_radius
        self.scales = np.array([1.0, 1.0, 1.0, setting.arm, setting.arm])

    @property
    def speed(self) -> float:
        """At which the inner ring turns [rad/s]."""
        return self.setting.speed

    def seats(self) -> np.ndarray:
        """The numbers of the rings (rings, SEAT) for the core."""
        return self.setting.numbers(self.gravity)[None]

    def _at_rest(self) -> "EquilibriumSolver":
        return EquilibriumSolver(self.setting._replace(speed=0.0), self.azimuths, self.gravity)

    def limit_ratios(self, contacts: Contacts) -> tuple[float, float]:
        """Greatest squeeze and greatest contact angle of these contacts, each over its limit."""
        squeeze, angle = limit_ratios(self.setting.ball_radius, contacts.load, contacts.approach, contacts.angle)
        return float(squeeze.max()), float(angle.max())

    def is_legal(self, equilibrium: Equilibrium) -> bool:
        """True for a balance within the limits of the model."""
        return equilibrium.status == FOUND and max(self.limit_ratios(equilibrium.contacts)) <= 1.0

    def balance(self, support: Support, share: float = 1.0) -> Equilibrium:
        """The balance with a `share` of loads and held coordinates, which may not exist (see `status`)."""
        free = np.array(support.free, np.bool_)
        loads, held = share * np.where(free, support.loads, 0.0), share * np.where(free, 0.0, support.held)
        ring = self.seats()[None], self.balls, self.azimuths[None]
        batch = solve_batch(*ring, free, loads[None], held[None], self.heights)
        q, load, stiffness, positions, contacts, residual, status = (array[0] for array in batch)
        return Equilibrium(
            *(q, load, stiffness, self.azimuths, positions), contacts_in(contacts), float(residual), int(status)
        )

    def checked_balance(self, support: Support) -> Equilibrium:
        """`balance`, within the limits of the model.

        Raises SceneError with the greatest load, or with the support that is missing.
        """
        equilibrium = self.balance(support)
        if equilibrium.status == NOTHING_CARRIES:
            free = ", ".join(name for name, is_free in zip(COORDINATE_NAMES, support.free, strict=True) if is_free)
            raise SceneError(
                f"no ball touches both rings, so that nothing holds {self.body} along {free}; {self.remedy}"
            )
        if not self.is_legal(equilibrium):
            raise SceneError(self._refusal(support, equilibrium))
        return equilibrium

    def solve(self, support: Support) -> Equilibrium:
        """The equilibrium, over defects if there are any; raises SceneError as `checked_balance` does."""
        equilibrium = self.checked_balance(support)
        if self.defect_scene:
            numbers = defect_numbers(self.defect_scene, float(equilibrium.contacts.load.max()))
            self.heights = heights_under(numbers, self.azimuths)
            equilibrium = self.checked_balance(support)
        return equilibrium._replace(control=control_named(self.setting))

    def _refusal(self, support: Support, equilibrium: Equilibrium) -> str:
        """Reason why there is no legal equilibrium, with the greatest share of loads and held coordinates.

        A load that is carried at rest is reported first: the greatest load at this speed costs more and explains less.
        """
        squeeze, angle = self.limit_ratios(equilibrium.contacts) if equilibrium.status == FOUND else (0.0, 0.0)
        greatest, at_rest = math.degrees(GREATEST_ANGLE), self._at_rest()
        if self.speed and at_rest.is_legal(at_rest.balance(support)):
            effect = " too far"
            if angle > max(1.0, squeeze):
                reached, limit = f"{angle * greatest:.3g} degrees", f"{greatest:.3g} degrees that are modelled"
                effect = f" and leans a contact to {reached}, beyond the {limit}"
            return (
                f"{_load_text(support)} is carried at rest; a speed of {self.speed:g} rad/s throws the balls outwards"
                f"{effect}; lower the speed, or load the bearing more along its axis"
            )
        share, (squeeze, angle) = self._greatest_share(support)
        if share == 0.0:
            return (
                f"{_load_text(support)} finds no contact that carries it; hold {self.body} in this direction, or turn "
                "the load"
            )
        how = (
            f"tilts the contacts out of the grooves, beyond {greatest:.3g} degrees"
            if angle > squeeze
            else f"pushes {self.body} through the balls: a contact is squeezed by at most 2 % of the ball's diameter"
        )
        return f"{_load_text(support)} {how}; the greatest in this direction is {_load_text(support, share)}"

    def _greatest_share(self, support: Support) -> tuple[float, tuple[float, float]]:
        """The greatest legal share of loads and held coordinates, 0 if there is none, and its ratios to the limits.

        The share is divided until it is legal, then found by bisection.
        """
        free = np.array(support.free, np.bool_)
        heaviest = np.abs(np.where(free, support.loads, 0.0) / self.scales).max()
        furthest = np.abs(np.where(free, 0.0, support.held) * self.scales).max()
        least = LEAST_SHARE / max(1.0, heaviest / HEAVY_LOAD, furthest / self.longest)
        low, high, ratios, trials = 0.0, 1.0, (0.0, 0.0), BISECTIONS
        while trials > 0 and high > least:
            share = 0.5 * (low + high) if low else high / FIRST_FACTOR
            equilibrium = self.balance(support, share)
            legal = self.is_legal(equilibrium)
            ratios = self.limit_ratios(equilibrium.contacts) if legal else ratios
            # too little to touch anything is no reason against a greater load
            low, high = (share, high) if legal or equilibrium.status == NOTHING_CARRIES else (low, share)
            trials -= (1 if equilibrium.status in (FOUND, NOTHING_CARRIES) else FAILURE_COST) if low else 0
        return low, ratios


def _load_text(support: Support, share: float = 1.0) -> str:
    """The loads and held coordinates in words."""
    rows = []
    for name, unit, values, part, is_load in (
        ("a load", "N", support.loads, slice(0, 3), True),
        ("a moment", "N m", support.loads, slice(3, 5), True),
        ("a displacement", "m", support.held, slice(0, 3), False),
        ("a misalignment", "rad", support.held, slice(3, 5), False),
    ):
        if any(value and bool(free) is is_load for value, free in zip(values[part], support.free[part], strict=True)):
            least = LOAD_ROUNDING * max(map(abs, values[part]))
            shown = (rounded_to_error(share * value * (abs(value) > least), None, 4) for value in values[part])
            rows.append(f"{name} of ({', '.join(shown)}) {unit}")
    return " with ".join(rows) or "no load"


def solver_under_gravity(parameters, law: str, speed: float, azimuths: np.ndarray) -> EquilibriumSolver:
    """The solver of a scene at `speed` [rad/s] under its gravity, with the balls at these azimuths [rad] (N,)."""
    setting, defect_scene = setting_of(parameters, law, speed), parameters if parameters.defects else None
    return EquilibriumSolver(setting, azimuths, tuple(parameters.gravity), defect_scene)


def loose_directions(equilibrium: Equilibrium, support: Support, scales) -> list[str]:
    """The free coordinates that nothing holds at an equilibrium: their stiffness is rounding, or below 0."""
    scaled = equilibrium.stiffness / np.outer(scales, scales)
    greatest = np.abs(scaled).max()
    return [
        name
        for i, (name, is_free) in enumerate(zip(COORDINATE_NAMES, support.free, strict=True))
        if is_free and scaled[i, i] <= LOOSE_STIFFNESS * greatest
    ]


def solver_of(parameters, law, ball_angle=0.0, arm="groove") -> EquilibriumSolver:
    """The solver of a scene without gravity, ball 0 at `ball_angle` [rad]; see `setting_of`."""
    setting = setting_of(parameters, law, parameters.drive.speed, arm)
    azimuths = azimuths_of(parameters.geometry.balls, ball_angle)
    return EquilibriumSolver(setting, azimuths, defect_scene=parameters if parameters.defects else None)


def ellipses_of(parameters, contacts: Contacts) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Semi-axes [m] across and along a groove, and peak pressure [Pa], each (N, 2)."""
    e_star = np.array(moduli(parameters.materials))
    return tuple(ellipses_at(contacts.curvature_small, contacts.curvature_large, e_star, contacts.load))


def outer_controls(moduli: np.ndarray, contacts: Contacts) -> np.ndarray:
    """Harris' criterion of outer raceway control, Q_o a_o E_o cos(a_i - a_o) > Q_i a_i E_i, for the ball loaded most.

    a is the semi-major axis, E the complete elliptic integral of the second kind of the contact ellipse (Harris,
    Rolling Bearing Analysis, chapter on ball speeds: on the raceway that resists spin more the ball does not spin).
    `moduli` ([...,] 2) are E* of the raceways [Pa], `contacts` (..., N, 2).
    """
    ball = contacts.load[..., 0].argmax(-1)[..., None, None]
    rows = contacts.curvature_small, contacts.curvature_large, contacts.load, contacts.angle
    small, large, load, angle = (np.take_along_axis(row, ball, axis=-2)[..., 0, :] for row in rows)
    ellipses = ellipses_at(small, large, moduli, load)
    ratio = np.divide(ellipses.semi_minor, ellipses.semi_major, out=np.ones_like(load), where=load > 0.0)
    resistance = load * ellipses.semi_major * elliptic_e(ratio)
    is_outer = resistance[..., 1] * np.cos(angle[..., 0] - angle[..., 1]) > resistance[..., 0]
    return is_outer & (load.min(-1) > 0.0)


def centrifugal_ratio(contacts: Contacts, least: float = 1e-3) -> float:
    """The greatest centrifugal load over the load on the inner raceway; 0 where no ball carries.

    Of the balls that carry more than `least` of the greatest load: one at the end of the load zone has any ratio.
    """
    load = contacts.load[:, 0]
    carry = load > least * load.max()
    return float((contacts.centrifugal[carry] / load[carry]).max()) if carry.any() and load.max() > 0.0 else 0.0


def equilibrium_error(contacts: Contacts) -> float:
    """Difference of loads between equilibria and balls that move, over the greatest load.

    A bound on what `bearing_twin chart dimensions` measures of a 6203 up to a `centrifugal_ratio` of 1.4. A ball with
    less load than that bounces between its raceways: loads of moving balls differed by at most 2.9 times the
    centrifugal load, up to a ratio of 9 (6203, 6205, 6308 under combined load, rings held and free).
    """
    ratio, greatest = centrifugal_ratio(contacts), float(contacts.load.max())
    if greatest <= 0.0:
        return 1e-4
    return max(1e-4, min(0.04 * ratio * ratio, BOUNCE * float(contacts.centrifugal.max()) / greatest, 1.0))


def control_named(setting: Setting) -> str:
    """The name of the raceway control with these shares of the gyroscopic moment; "none" where no raceway takes any."""
    shares = setting.share_inner, setting.share_outer
    return next((name for name, control in CONTROLS.items() if control == shares and name != AUTO), "none")


def controlled_equilibrium(parameters, solver: EquilibriumSolver, support: Support) -> Equilibrium:
    """The equilibrium with the raceway control that `model.control` names, `auto` by Harris' criterion.

    With `auto` it is solved as `shared` (Harris: both raceways carry the moment), then, if the criterion is met, with
    the control of the outer raceway. `solver` keeps the control. Raises SceneError.
    """
    equilibrium = solver.solve(support)
    auto = parameters.model.control == AUTO and solver.speed
    if auto and outer_controls(np.array(moduli(parameters.materials)), equilibrium.contacts):
        inner, outer = CONTROLS[OUTER]
        solver.setting = solver.setting._replace(share_inner=inner, share_outer=outer)
        equilibrium = solver.solve(support)
    return equilibrium


def control_reason(parameters, equilibrium: Equilibrium) -> str:
    """Reason of the raceway control of an equilibrium's balls."""
    if parameters.model.control != AUTO:
        return "as the scene asks"
    if equilibrium.control == SHARED:
        return "both raceways carry the gyroscopic moment, as the criterion of Harris for outer control is not met"
    return "by the criterion of Harris, as the outer raceway resists spin more"


@functools.lru_cache(4)
def scene_equilibrium(parameters, law: str) -> Equilibrium:
    """`controlled_equilibrium` of a scene without gravity; raises SceneError."""
    return controlled_equilibrium(parameters, solver_of(parameters, law), support_of(parameters))


TRIAL_POSITIONS = 3  # of the balls, from one on the load line to the line between two
OVERLOAD = "overload"  # reason of the error of a run whose load nothing carries


def commanded_loads(force, moment) -> tuple[float, ...]:
    """Force (3,) [N] and moment (2,) or (3,) [N m] as the loads of the five coordinates; raises BearingTwinError."""
    values = (*force, *moment)
    if not all(map(math.isfinite, values)):
        raise BearingTwinError(f"force {_vector_text(force)} N and torque {_vector_text(moment)} N m must be finite")
    if any(values[5:]):
        raise BearingTwinError(
            f"the torque of {values[5]:g} N m about z is the drive's, which has a command of its own"
        )
    return tuple(map(float, values[:5]))


def check_load(parameters, law: str, speed: float, force, moment) -> None:
    """Raises BearingTwinError for a load [N], [N m] on the inner ring that nothing follows or no ball carries.

    It is tried in balance, with the weights on a ring with mass, at `speed` [rad/s] and TRIAL_POSITIONS of the balls.
    None for force and moment: the load of the scene.
    """
    if dimension_of(parameters) == PRESCRIBED:
        if force is None:
            return
        raise BearingTwinError(
            "model.dimension = prescribed holds the inner ring, so that a load does not move it; run the scene with "
            "model.dimension: quasi_static or free, and rings.inner.free: displacement"
        )
    loads = None
    if force is not None:
        loads = commanded_loads(force, moment)
        for problem in idle_loads(parameters, loads[:3], loads[3:], "force", "torque"):
            raise BearingTwinError(problem)
    support = support_with_weight(parameters, loads)
    balls = parameters.geometry.balls
    for position in range(TRIAL_POSITIONS):
        azimuths = azimuths_of(balls, trial_azimuth(support, balls, position))
        solver_under_gravity(parameters, law, speed, azimuths).solve(support)


def trial_azimuth(support: Support, balls: int, position: int) -> float:
    """Azimuth [rad] of the first of so many balls at one of the TRIAL_POSITIONS."""
    return load_line(support) + math.pi / balls * position / (TRIAL_POSITIONS - 1)


def check_goal(kind: str, key: str, value: float) -> None:
    """Raises BearingTwinError for a `key`, SPEED or TORQUE, that a drive of this kind does not take, or no number."""
    if key != kind:
        why = "the speed follows from the torque" if kind == TORQUE else "the torque follows from the speed"
        raise BearingTwinError(f"drive.kind = {kind}: {why}; command the {kind} instead")
    if not math.isfinite(value):
        raise BearingTwinError(f"a {key} of {value:g} is not finite")


class CommandedBearing:
    """Base of the motions of a bearing: checks of commands with the balls in balance."""

    def check_drive(self, key: str, value: float, load: tuple) -> str:
        """A warning of a `value` for the `key`, speed [rad/s] or torque [N m], or ""; see `CommandedMotion`."""
        check_goal(self.parameters.drive.kind, key, value)
        if key != SPEED:
            if problem := torque_problem(self.parameters, value):
                raise BearingTwinError(problem)
            return ""
        check_load(self.parameters, self.law, value, *load)
        return command_warning(self.parameters, value)

    def check_load(self, force, moment) -> None:
        """As the function `check_load`, at the goal of the speed."""
        check_load(self.parameters, self.law, self.goal_speed, force, moment)

    def operating_point(self, sample) -> OperatingPoint:
        """The ring of an output with its loads and stiffness, the balls in balance at their azimuths there.

        A ring that moves or balls that ring are off this balance by their inertia. Raises BearingTwinError.
        """
        coordinates = np.array([*sample["inner_ring_offset"], *sample["inner_ring_tilt"]])
        speed = float(sample["inner_ring_speed"])
        held = Support((False,) * 5, (0.0,) * 5, tuple(coordinates))
        try:
            solver = solver_under_gravity(self.parameters, self.law, speed, sample["orbit_angle"])
            equilibrium = controlled_equilibrium(self.parameters, solver, held)
        except SceneError as error:
            raise BearingTwinError(f"there is no stiffness where the ring stands now: {error}") from error
        return OperatingPoint(equilibrium.coordinates, equilibrium.loads, equilibrium.stiffness, speed)


def _vector_text(values) -> str:
    return "(" + ", ".join(f"{value:g}" for value in values) + ")"


BATCH = 1000  # cases solved at once: their arrays stay in the cache
SHARES = slice(33, 35)  # of the gyroscopic moment, among a setting's numbers
ADVICE = "`bearing_twin bearing` gives the greatest load in this direction"
REASONS = (  # by status of the core, then by the limit that an equilibrium exceeds
    "",
    "no ball touches both rings, so that nothing holds the ring; load it, or take less clearance",
    f"no balance is found: the load pushes the ring through the balls, or no contact carries it; {ADVICE}",
    "stopped",
    f"a contact is squeezed by more than 2 % of the ball's diameter; {ADVICE}",
    f"a contact angle is beyond what is modelled: load or speed moves contacts out of the grooves; {ADVICE}",
)
SQUEEZED, BEYOND_ANGLE = 4, 5


@dataclass(frozen=True, repr=False)
class Equilibria:
    """A ball bearing in equilibrium under loads of shape `...`; where it is not `converged`, numbers are NaN.

    Attributes
    ----------
    displacement : ndarray (..., 5)
        Of the inner ring: x, y, z [m], tilts about x and y [rad], in `bearing_link`: z along the axis.
    ball_azimuth : ndarray (..., N)
        Azimuths of the balls about the axis [rad], from +x towards +y.
    ball_load, contact_angle : ndarray (..., N, 2)
        Normal load [N] and contact angle [rad] on the inner and the outer raceway; an angle is > 0 where the inner ring
        is pushed along +z, and counts where there is a load.
    stiffness : ndarray (..., 5, 5)
        Derivatives of the loads [N, N m] by the coordinates [m, rad], balls at these azimuths.
    converged : ndarray (...) of bool
        Whether there is an equilibrium within the limits of the model.
    reason : ndarray (...) of str
        Why there is none; empty where there is one.
    """

    displacement: np.ndarray
    ball_azimuth: np.ndarray
    ball_load: np.ndarray
    contact_angle: np.ndarray
    stiffness: np.ndarray
    converged: np.ndarray
    reason: np.ndarray

    def __repr__(self) -> str:
        rows = {
            "displacement x, y, z [m]": self.displacement[..., :3],
            "tilts about x and y [rad]": self.displacement[..., 3:],
            "greatest ball load [N]": self.ball_load.max(axis=(-2, -1)),
            "stiffness along x, y, z [N/m]": np.diagonal(self.stiffness, axis1=-2, axis2=-1)[..., :3],
        }
        title = f"{int(self.converged.sum())} of {self.converged.size} equilibria found"
        return summary_text(title, {name: value.ravel().tolist() for name, value in rows.items()})


def azimuths_on(loads: np.ndarray) -> np.ndarray:
    """Azimuths [rad] (C,) of the loads (C, 5) across the axis: of the force, else of the moment, else 0."""
    force, moment = (np.arctan2(loads[:, i + 1], loads[:, i]) for i in (0, 3))
    return np.where(loads[:, :2].any(1), force, np.where(loads[:, 3:].any(1), moment, 0.0))


def solve_scenes(scenes, laws, which, loads, tilting: bool, first) -> Equilibria:
    """Equilibria (C, ...) of the parameters `scenes[which]` under `loads` (C, 5), ball 0 at the azimuths `first` (C,).

    Tilts are free where `tilting`, else as the drive of each scene holds them.
    """
    settings = [setting_of(scene, law, scene.drive.speed) for scene, law in zip(scenes, laws, strict=True)]
    seats = np.array([setting.numbers() for setting in settings])[:, None]
    held = np.array([(0.0, 0.0, 0.0, *scene.drive.tilt) for scene in scenes])
    e_star = np.array([moduli(scene.materials) for scene in scenes])
    auto = np.array([scene.model.control == AUTO and bool(scene.drive.speed) for scene in scenes])
    has_defects = np.array([bool(scene.defects) for scene in scenes])
    radii = np.array([setting.ball_radius for setting in settings])[:, None]
    free = np.array([True] * 3 + [tilting] * 2)
    azimuths = azimuths_of(scenes[0].geometry.balls, first[:, None])

    def solve_part(part: slice) -> tuple[np.ndarray, ...]:
        scene, azimuth = which[part], azimuths[part]
        applied, fixed = np.where(free, loads[part], 0.0), np.where(free, 0.0, held[scene])
        numbers, heights = seats[scene], np.zeros((*azimuth.shape, 2))

        def solve(cases: np.ndarray) -> Solved:
            balls = (azimuth.shape[1],)
            return solve_batch(
                numbers[cases], balls, azimuth[cases], free, applied[cases], fixed[cases], heights[cases]
            )

        def solve_again(cases: np.ndarray) -> None:
            if cases.any():
                for array, values in zip(solved, solve(cases), strict=True):
                    array[cases] = values

        def solve_over_defects(cases: np.ndarray) -> None:
            cases = cases & has_defects[scene] & (solved.status == FOUND)
            for case in np.flatnonzero(cases):
                greatest = float(contacts_in(solved.contacts[case]).load.max())
                heights[case] = heights_under(defect_numbers(scenes[scene[case]], greatest), azimuth[case])
            solve_again(cases)

        solved = solve(np.full(len(scene), True))
        solve_over_defects(np.full(len(scene), True))
        outer = auto[scene] & (solved.status == FOUND) & outer_controls(e_star[scene], contacts_in(solved.contacts))
        numbers[outer, :, SHARES] = CONTROLS[OUTER]
        solve_again(outer)
        solve_over_defects(outer)
        contacts = contacts_in(solved.contacts)
        ratios = limit_ratios(radii[scene], contacts.load, contacts.approach, contacts.angle)
        squeeze, angle = (ratio.max(-1) for ratio in ratios)
        status = solved.status.copy()
        status[(status == FOUND) & (np.maximum(squeeze, angle) > 1.0)] = SQUEEZED
        status[(status == SQUEEZED) & (angle > squeeze)] = BEYOND_ANGLE
        results = solved.coordinates, contacts.load.copy(), contacts.angle.copy(), solved.stiffness
        for array in results:
            array[status != FOUND] = np.nan
        return *results, status

    begins = range(0, max(len(loads), 1), BATCH)  # no case gives arrays without rows
    parts = [solve_part(slice(begin, begin + BATCH)) for begin in begins]
    displacement, load, angle, stiffness, status = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    reason = np.array(REASONS, object)[status]
    return Equilibria(displacement, azimuths, load, angle, stiffness, status == FOUND, reason)
