"""The shaft in equilibrium on both bearings: where a run starts, its stiffness there, and what loads it carries."""

import functools
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import BearingTwinError, IntegrationError, SceneError
from bearing_twin.kinds.bearing.equilibrium import (
    COORDINATES,
    IDLE,
    LONGEST,
    OVERLOAD,
    SPEED_COLUMN,
    TRIED_PLACES,
    Contacts,
    EquilibriumSolver,
    Setting,
    Support,
    azimuths_of,
    commanded_loads,
    contacts_at,
    limits_used,
    loose_directions,
    setting_of,
    shared,
    tried_at,
)
from bearing_twin.kinds.bearing.parameters import GREATEST_ANGLE, GREATEST_SQUEEZE
from bearing_twin.kinds.shaft.course import about_centre, constant_loads, loads_of, unbalance_of
from bearing_twin.kinds.shaft.derived import bearing_scene, middle_of
from bearing_twin.kinds.shaft.parameters import SIDES, ShaftScene

UNSEEN = 1e-12  # of the loads: what a ball's last step may leave, which spares a quarter of a step's time


class ShaftSeat(NamedTuple):
    """One bearing on the shaft: its balance, place [m], side it faces, `middle` [m] along its own axis.

    `first` [rad] is the azimuth of ball 0 at the start, `ratio` the orbit's speed over the shaft's, `gravity` (3,) in
    the bearing's own frame.
    """

    setting: Setting
    balls: int
    place: float
    facing: float
    middle: float
    first: float
    ratio: float
    gravity: tuple

    @property
    def turned(self) -> np.ndarray:
        """The change (5, 5) of the inner ring's coordinates in its own frame by those of the shaft."""
        matrix = np.diag([1.0, 1.0, self.facing, self.facing, self.facing])
        matrix[0, 4], matrix[1, 3] = self.place, -self.place
        return matrix

    def ring(self, q: np.ndarray) -> np.ndarray:
        """The inner ring's coordinates (5,) in its own frame, the shaft at `q` (5,)."""
        return self.turned @ q + np.array([0.0, 0.0, self.middle, 0.0, 0.0])


class Rotor(NamedTuple):
    """The numbers of the equations of motion (SI): `weight` (5,); `steady` (5,) are the loads when the run starts.

    Complex vectors (5,) turn with the shaft: see `unbalance_of`, and the `whirl` that the motion is counted from.
    """

    seats: tuple[ShaftSeat, ...]
    mass: float
    transverse: float
    polar: float
    relaxation_time: float
    weight: np.ndarray
    steady: np.ndarray
    whirl: np.ndarray
    unbalance: np.ndarray

    def numbers(self) -> np.ndarray:
        """The core's `Rotor`."""
        turning = [part for one in (self.whirl, self.unbalance) for part in (one.real, one.imag)]
        orbits = [seat.first for seat in self.seats] + [seat.ratio for seat in self.seats]
        limits = GREATEST_SQUEEZE, GREATEST_ANGLE, IDLE
        return np.concatenate([self[1:5], self.weight, self.steady, *turning, orbits, limits])

    def seat_numbers(self) -> np.ndarray:
        """The core's `Seat`s (2, SEAT)."""
        return np.array([one.setting.numbers(one.gravity, one.place, one.facing, one.middle) for one in self.seats])


class ShaftBalance(NamedTuple):
    """The shaft in balance: `coordinates` (5,), `stiffness` (5, 5), for each bearing `rings` (5,) and `contacts`.

    `ratios` are the orbits' speeds of balls that roll in one cage over the shaft's.
    """

    coordinates: np.ndarray
    stiffness: np.ndarray
    rings: tuple[np.ndarray, ...]
    contacts: tuple[Contacts, ...]
    ratios: tuple[float, ...]


def rotor_of(parameters: ShaftScene, law: str, ratios=(0.0, 0.0)) -> Rotor:
    """The numbers of the equations of motion for a scene with the elastic law `law`."""
    shaft, seats = parameters.shaft, []
    for side, ratio in zip(SIDES, ratios, strict=True):
        mounted, scene = getattr(parameters, side), bearing_scene(parameters, side)
        places = (mounted.place, mounted.facing, middle_of(mounted), mounted.ball_angle, ratio)
        setting = setting_of(scene, law, parameters.drive.speed)._replace(unseen=UNSEEN)
        balls, gravity = int(mounted.geometry.balls), tuple(map(float, scene.gravity))
        seats.append(ShaftSeat(setting, balls, *map(float, places), gravity))
    weight = shaft.mass * np.array([*parameters.gravity, 0.0, 0.0])
    return Rotor(
        tuple(seats),
        shaft.mass,
        *shaft.inertia,
        parameters.contact.relaxation_time,
        weight,
        loads_of(parameters, 0.0),
        np.zeros(COORDINATES, complex),
        unbalance_of(parameters),
    )


def lever_of(rotor: Rotor) -> float:
    """By which arm [m] a tilt of the shaft moves its bearings' grooves."""
    return max(abs(seat.place) + seat.setting.arm for seat in rotor.seats)


def longest_of(rotor: Rotor) -> float:
    """How far [m] no coordinate of the shaft goes from the middle, tilts by their arm."""
    balls = max(2.0 * seat.setting.ball_radius for seat in rotor.seats)
    return LONGEST * balls + max(abs(seat.middle) for seat in rotor.seats)


class ShaftSolver(EquilibriumSolver):
    """Equilibria of a shaft on two bearings with their balls where they start."""

    body = "the shaft"
    remedy = "load it, or give less clearance, or preload by offsets of the outer rings"

    def __init__(self, rotor: Rotor, speed: float):
        self.rotor, self._speed = rotor, speed
        self.balls = tuple(seat.balls for seat in rotor.seats)
        self.azimuths = np.concatenate([azimuths_of(seat.balls, seat.first) for seat in rotor.seats])
        lever = lever_of(rotor)
        self.scales = np.array([1.0, 1.0, 1.0, lever, lever])
        self.longest = longest_of(rotor)

    @property
    def speed(self) -> float:
        """At which the shaft turns [rad/s]."""
        return self._speed

    def seats(self) -> np.ndarray:
        """The numbers of both rings (2, SEAT) for the core."""
        return self._seats_at(self._speed)

    def _seats_at(self, speed: float) -> np.ndarray:
        seats = self.rotor.seat_numbers()
        seats[:, SPEED_COLUMN] = speed
        return seats

    def _at_rest(self) -> "ShaftSolver":
        return ShaftSolver(self.rotor, 0.0)

    def refuse_thrown_out(self, support: Support) -> None:
        """Raises SceneError where at this speed nothing holds the shaft in a direction in which it is held at rest."""
        loose, still = loose_directions(self, support, self.scales), self._at_rest()
        if loose and self._speed:
            still.settle(support)
            if not loose_directions(still, support, self.scales):
                raise SceneError(
                    f"at {self._speed:g} rad/s the balls are thrown outwards so far that nothing holds the shaft along "
                    f"{', '.join(loose)}; lower the speed, or preload the bearings more"
                )

    def both_contacts(self) -> list[Contacts]:
        """The contacts of both bearings where the shaft stands."""
        # Orbits are shares of the ring's speed, that of 1 rad/s where it is at rest.
        seats = self._seats_at(self._speed or 1.0)
        found = contacts_at(seats, self.balls, self.azimuths, self.q, self.place[:, :2])
        first = self.balls[0]
        return [Contacts(*(one[:first] for one in found)), Contacts(*(one[first:] for one in found))]

    def legal(self) -> tuple[float, float]:
        """Greatest squeeze and greatest contact angle of what was found last, each over its limit."""
        used = [
            [float(one.max()) for one in limits_used(seat.setting.ball_radius, each.load, each.approach, each.angle)]
            for seat, each in zip(self.rotor.seats, self.both_contacts(), strict=True)
        ]
        return tuple(map(max, zip(*used, strict=True)))


@functools.lru_cache(maxsize=8)
def balance_of(parameters: ShaftScene, law: str, speed: float, time: float = 0.0) -> ShaftBalance:
    """The shaft in balance under its weight and the scene's loads at `time` [s], turning at `speed` [rad/s].

    Raises SceneError for what no contact carries or what pushes the shaft through its balls.
    """
    solver, support = solver_of(parameters, law, speed), weighed_support(parameters, loads_of(parameters, time))
    solver.settle(support)
    solver.refuse_thrown_out(support)
    contacts = solver.both_contacts()
    ratios = tuple(float(shared(one, one.orbit)) / (speed or 1.0) for one in contacts)
    rings = tuple(seat.ring(solver.q) for seat in solver.rotor.seats)
    return ShaftBalance(solver.q, solver.stiffness, rings, tuple(contacts), ratios)


def solver_of(parameters: ShaftScene, law: str, speed: float, first=None) -> ShaftSolver:
    """The solver for the shaft at `speed` [rad/s], balls where they start.

    Else `first(balls)` says at which azimuth [rad] the first of so many stands.
    """
    rotor = rotor_of(parameters, law)
    if first is not None:
        rotor = rotor._replace(seats=tuple(seat._replace(first=float(first(seat.balls))) for seat in rotor.seats))
    return ShaftSolver(rotor, float(speed))


def weighed_support(parameters: ShaftScene, loads: np.ndarray) -> Support:
    """All coordinates free, under the shaft's weight and `loads` (5,) about its centre of mass."""
    weight = parameters.shaft.mass * np.array([*parameters.gravity, 0.0, 0.0])
    return Support((True,) * COORDINATES, tuple((weight + loads).tolist()), (0.0,) * COORDINATES)


def check_load(parameters: ShaftScene, law: str, speed: float, force, moment) -> None:
    """Raises BearingTwinError for a load [N], [N m] at `shaft.load_place` that the bearings do not carry.

    It is tried as `refuse_uncarried` does, with the constant loads. None for force and moment: the scene's first loads.
    """
    loads = loads_of(parameters, 0.0)
    if force is not None:
        commanded = about_centre(parameters.shaft.load_place, commanded_loads(force, moment))
        loads = constant_loads(parameters) + commanded
    refuse_uncarried(parameters, law, speed, loads)


def refuse_uncarried(parameters: ShaftScene, law: str, speed: float, loads: np.ndarray) -> None:
    """Raises BearingTwinError for loads (5,) [N, N m] about the centre of mass that the bearings do not carry.

    They are tried in balance, with the shaft's weight, at `speed` [rad/s] and with the balls at TRIED_PLACES
    of their way to the next.
    """
    support = weighed_support(parameters, loads)
    for place in range(TRIED_PLACES):
        solver = solver_of(parameters, law, speed, lambda balls, place=place: tried_at(support, balls, place))
        solver.settle(support)
        solver.refuse_thrown_out(support)


def explained(error: IntegrationError, parameters: ShaftScene, law: str, speed: float, loads) -> IntegrationError:
    """`error`, or one that names the loads (5,) on the shaft then, with time and limit, where nothing carries them."""
    try:
        refuse_uncarried(parameters, law, speed, loads)
    except BearingTwinError as limit:
        return IntegrationError(f"at {error.seconds:.9g} s {limit}", OVERLOAD, error.seconds, "shaft")
    return error
