"""The shaft in balance on both bearings: where a run starts, how stiff it stands there, and how the balls then roll."""

import functools
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.quasi_static.ball_equilibrium import Contacts, contacts_at, limits_used, shared
from bearing_twin.kinds.bearing.quasi_static.equilibrium import (
    COORDINATES,
    LONGEST,
    ROUNDING,
    EquilibriumSolver,
    Support,
    coordinates_in_balance,
    loose_directions,
    setting_of,
)
from bearing_twin.kinds.shaft.course import loads_of
from bearing_twin.kinds.shaft.derived import bearing_scene, middle_of
from bearing_twin.kinds.shaft.parameters import SIDES, ShaftScene
from bearing_twin.kinds.shaft.rotor import Rotor, ShaftSeat, new_balls, shaft_loads

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
        seats.append(ShaftSeat(setting, *map(float, places), tuple(map(float, scene.gravity))))
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


@inlined
def _of_shaft(system, q, load, stiffness):
    rotor, speed, balls = system
    return shaft_loads(rotor, 0.0, speed, q, balls, load, stiffness)


@kernel
def shaft_in_balance(rotor, speed, balls, q, free, wanted, scales, rounding, longest, load, stiffness):
    """As `ring_in_balance`, of the shaft's coordinates."""
    system = (rotor, speed, balls)
    return coordinates_in_balance(_of_shaft, system, scales, rounding, free, wanted, longest, q, load, stiffness)


class ShaftSolver(EquilibriumSolver):
    """Equilibria of a shaft on two bearings with their balls where they start."""

    body = "the shaft"
    remedy = "load it, or give less clearance, or preload by offsets of the outer rings"

    def __init__(self, rotor: Rotor, balls: tuple[int, int], speed: float):
        self.rotor, self.counts, self._speed = rotor, balls, speed
        self.place = np.full((sum(balls), 8), np.nan)
        parts = self.place[: balls[0]], self.place[balls[0] :]
        self.balls = tuple(new_balls(len(part))._replace(place=part) for part in parts)
        lever, settings = lever_of(rotor), [seat.setting for seat in rotor.seats]
        self.scales = np.array([1.0, 1.0, 1.0, lever, lever])
        self.longest = longest_of(rotor)
        self.rounding = ROUNDING * max(one.inner.locus_radius - one.outer.locus_radius for one in settings)
        self.q, self.load, self.stiffness = np.zeros(5), np.zeros(5), np.zeros((5, 5))

    @property
    def speed(self) -> float:
        """At which the shaft turns [rad/s]."""
        return self._speed

    def _at_rest(self) -> "ShaftSolver":
        return ShaftSolver(self.rotor, self.counts, 0.0)

    def _begin(self, free, wanted) -> None:
        """At the middle, where preloaded bearings hold it; else it goes along its load until they do."""

    def _newton(self, free, wanted):
        limits = self.scales, self.rounding, self.longest
        status, left, _ = shaft_in_balance(
            self.rotor, self._speed, self.balls, self.q, free, wanted, *limits, self.load, self.stiffness
        )
        return status, left

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

    def contacts(self) -> list[Contacts]:
        """The contacts of both bearings where the shaft stands."""
        found = []
        for seat, own in zip(self.rotor.seats, self.balls, strict=True):
            # Orbits are shares of the ring's speed, that of 1 rad/s where it is at rest.
            setting = seat.setting._replace(speed=self._speed or 1.0)
            found.append(contacts_at(setting, own.directions, own.ring, own.place))
        return found

    def _legal(self) -> tuple[float, float]:
        used = [
            [float(one.max()) for one in limits_used(seat.setting, each.load, each.approach, each.angle)]
            for seat, each in zip(self.rotor.seats, self.contacts(), strict=True)
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
    contacts = solver.contacts()
    ratios = tuple(float(shared(one, one.orbit)) / (speed or 1.0) for one in contacts)
    rings = tuple(own.ring.copy() for own in solver.balls)
    return ShaftBalance(solver.q.copy(), solver.stiffness.copy(), rings, tuple(contacts), ratios)


def solver_of(parameters: ShaftScene, law: str, speed: float, first=None) -> ShaftSolver:
    """The solver for the shaft at `speed` [rad/s], balls where they start.

    Else `first(balls)` says at which azimuth [rad] the first of so many stands.
    """
    balls, rotor = tuple(getattr(parameters, side).geometry.balls for side in SIDES), rotor_of(parameters, law)
    if first is not None:
        seats = zip(rotor.seats, balls, strict=True)
        rotor = rotor._replace(seats=tuple(seat._replace(first=float(first(count))) for seat, count in seats))
    return ShaftSolver(rotor, balls, float(speed))


def weighed_support(parameters: ShaftScene, loads: np.ndarray) -> Support:
    """All coordinates free, under the shaft's weight and `loads` (5,) about its centre of mass."""
    weight = parameters.shaft.mass * np.array([*parameters.gravity, 0.0, 0.0])
    return Support((True,) * COORDINATES, tuple((weight + loads).tolist()), (0.0,) * COORDINATES)
