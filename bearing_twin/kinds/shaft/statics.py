"""The shaft in balance on both bearings: where a run starts, how stiff it stands there, and how the balls then roll."""

import functools
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.kinds.bearing.quasi_static.ball_equilibrium import (
    COORDINATES,
    SPEED,
    Contacts,
    contacts_at,
    limits_used,
    shared,
)
from bearing_twin.kinds.bearing.quasi_static.equilibrium import (
    LONGEST,
    EquilibriumSolver,
    Support,
    loose_directions,
    setting_of,
)
from bearing_twin.kinds.shaft.course import loads_of
from bearing_twin.kinds.shaft.derived import bearing_scene, middle_of
from bearing_twin.kinds.shaft.parameters import SIDES, ShaftScene
from bearing_twin.kinds.shaft.rotor import Rotor, ShaftSeat, azimuths_at, ring_at, seats_of

UNSEEN = 1e-12  # of the loads: what a ball's last step may leave, which spares a quarter of a step's time


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
    unbalances = np.array(shaft.unbalances, float).reshape(-1, 3)
    return Rotor(
        tuple(seats),
        shaft.mass,
        *shaft.inertia,
        parameters.contact.relaxation_time,
        weight,
        unbalances,
        np.zeros((2, COORDINATES)),
        loads_of(parameters, 0.0),
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
        self.balls, self.azimuths = tuple(seat.balls for seat in rotor.seats), azimuths_at(rotor, 0.0)
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
        seats = seats_of(self.rotor)
        seats[:, SPEED] = speed
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


def ring_of(seat: ShaftSeat, q: np.ndarray) -> np.ndarray:
    """The inner ring of a bearing in its own frame (5,), the shaft at `q` (5,)."""
    ring = np.empty(COORDINATES)
    ring_at.py_func(seat, q, ring)
    return ring


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
    rings = tuple(ring_of(seat, solver.q) for seat in solver.rotor.seats)
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
