"""The shaft in equilibrium on both bearings: start of a run, stiffness, modes, and loads that are carried."""

import functools
import math
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import BearingTwinError, IntegrationError, SceneError
from bearing_twin.kinds.bearing.equilibrium import (
    COORDINATES,
    GREATEST_COORDINATE,
    OVERLOAD,
    SPEED_COLUMN,
    TRIAL_POSITIONS,
    UNLOADED_SHARE,
    Contacts,
    Equilibrium,
    EquilibriumSolver,
    Setting,
    Support,
    azimuths_of,
    commanded_loads,
    limit_ratios,
    load_weighted_mean,
    loose_directions,
    setting_of,
    trial_azimuth,
)
from bearing_twin.kinds.bearing.parameters import GREATEST_ANGLE, GREATEST_SQUEEZE
from bearing_twin.kinds.bearing.system import SAME, Loading, distinct_times
from bearing_twin.kinds.shaft.parameters import SIDES, ShaftScene, bearing_scene, middle_of


def about_centre(position: float, load) -> np.ndarray:
    """A load (5,) at a position [m] on the axis as one about the centre of mass."""
    x, y, z, about_x, about_y = load
    return np.array([x, y, z, about_x - position * y, about_y + position * x])


def constant_loads(parameters: ShaftScene) -> np.ndarray:
    """The loads (5,) of `shaft.loads` about the centre of mass, which no command replaces."""
    return sum((about_centre(position, load) for position, *load in parameters.shaft.loads), start=np.zeros(5))


def loads_of(parameters: ShaftScene, time: float) -> np.ndarray:
    """The scene's loads (5,) about the centre of mass at `time` [s], without weight and unbalances."""
    shaft = parameters.shaft
    return constant_loads(parameters) + about_centre(shaft.load_place, Loading(shaft).at(time)[0])


def unbalance_of(parameters: ShaftScene) -> np.ndarray:
    """The unbalances as one complex vector U (5,) [kg m, kg m^2]: their loads are Re((w^2 - i w') U exp(i angle))."""
    rows = [
        magnitude * np.exp(1j * azimuth) * np.array([1.0, -1j, 0.0, 1j * position, position])
        for position, magnitude, azimuth in parameters.shaft.unbalances
    ]
    return sum(rows, start=np.zeros(5, complex))


class ShaftCourse:
    """Speed and loads over time, in parts with constant acceleration and linear loads, from `now` [s] on.

    The shaft then has turned by `angle` [rad], turns at `speed` [rad/s] and is commanded to `goal`, by default as at
    the start of a run; a later change of the drive is added to the goal. `loading` acts at `shaft.load_place`. A
    command makes another course, so that a motion can return to the previous one.
    """

    def __init__(self, parameters: ShaftScene, loading: Loading, now=0.0, angle=0.0, speed=None, goal=None):
        drive = parameters.drive
        self._parameters, self.loading, self.now = parameters, loading, now
        self._steady, self.goal = constant_loads(parameters), float(drive.speed if goal is None else goal)
        self._turning = [(now, angle, float(drive.speed if speed is None else speed), 0.0)]
        self._turn_to(self.goal, now)
        if drive.change.time > now and drive.change.speed:
            self._turn_to(self.goal + drive.change.speed, drive.change.time)
        self._times = distinct_times(np.array([row[0] for row in self._turning]), loading.times[loading.times > now])

    def _turn_to(self, goal: float, begin: float) -> None:
        """Approach a speed [rad/s] from `begin` [s] on, in place of later parts."""
        angle, speed, _ = self.turned(begin)
        change = goal - speed
        acceleration = math.copysign(self._parameters.drive.acceleration, change) if change else 0.0
        self._turning = [row for row in self._turning if row[0] < begin] + [(begin, angle, speed, acceleration)]
        if change:
            duration = change / acceleration
            self._turning.append((begin + duration, angle + (speed + 0.5 * change) * duration, goal, 0.0))

    @property
    def speeds(self) -> list[float]:
        """The speeds [rad/s] where the acceleration changes."""
        return [row[2] for row in self._turning]

    def goal_at(self, time: float) -> float:
        """The speed [rad/s] that the shaft approaches at `time` [s]."""
        change = self._parameters.drive.change
        return float(self.goal + (change.speed if self.now < change.time <= time else 0.0))

    def turned(self, time: float) -> tuple[float, float, float]:
        """Angle [rad], speed [rad/s] and acceleration at `time` [s], at the begin of a part those of the part."""
        since, angle, speed, acceleration = [row for row in self._turning if row[0] <= time * (1.0 + SAME)][-1]
        passed = time - since
        return angle + (speed + 0.5 * acceleration * passed) * passed, speed + acceleration * passed, acceleration

    def load_at(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Load (5,) about the centre of mass at `time` [s], and its rate, without weight and unbalances."""
        position = self._parameters.shaft.load_place
        load, rate = (about_centre(position, value) for value in self.loading.at(time))
        return self._steady + load, rate

    def rows(self, since: float, until: float) -> np.ndarray:
        """The parts (n, 14) from the one at `since` [s] to the first that begins after `until`.

        Each is begin [s], angle [rad], speed and acceleration of the shaft there, load (5,) and its rate (5,).
        """
        first = max(int(np.searchsorted(self._times, since, side="right")) - 1, 0)
        last = int(np.searchsorted(self._times, until, side="right"))
        return np.array(
            [np.concatenate([[time], self.turned(time), *self.load_at(time)]) for time in self._times[first : last + 1]]
        )

    def commanded(self, now: float, goal: float) -> "ShaftCourse":
        """Course of a shaft that is commanded at `now` [s] to a speed `goal` [rad/s]."""
        angle, speed, _ = self.turned(now)
        return ShaftCourse(self._parameters, self.loading, now, angle, speed, goal)

    def loaded(self, now: float, force, moment) -> "ShaftCourse":
        """Course of a shaft with other loads from `now` [s] on, or those of the scene if both are None."""
        loading = Loading(self._parameters.shaft)
        if force is not None:
            loading.set(force, moment)
        angle, speed, _ = self.turned(now)
        return ShaftCourse(self._parameters, loading, now, angle, speed, self.goal_at(now))


def speeds_of(parameters: ShaftScene) -> tuple[float, float]:
    """The speeds [rad/s] at the start and at the end of the run, between which the shaft turns."""
    course = ShaftCourse(parameters, Loading(parameters.shaft))
    return float(parameters.drive.speed), float(course.turned(parameters.run.duration)[1])


class ShaftSeat(NamedTuple):
    """One bearing on the shaft: its balance, position [m], side it faces, offset `middle` [m] along its own axis.

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
        turning = [part for vector in (self.whirl, self.unbalance) for part in (vector.real, vector.imag)]
        orbits = [seat.first for seat in self.seats] + [seat.ratio for seat in self.seats]
        limits = GREATEST_SQUEEZE, GREATEST_ANGLE, UNLOADED_SHARE
        return np.concatenate([self[1:5], self.weight, self.steady, *turning, orbits, limits])

    def seat_numbers(self) -> np.ndarray:
        """The core's `Seat`s (2, SEAT)."""
        return np.array(
            [seat.setting.numbers(seat.gravity, seat.place, seat.facing, seat.middle) for seat in self.seats]
        )


class ShaftBalance(NamedTuple):
    """The shaft in balance: `coordinates` (5,), `stiffness` (5, 5), and for each bearing `contacts`.

    `ratios` are the orbits' speeds of balls that roll in one cage over the shaft's.
    """

    coordinates: np.ndarray
    stiffness: np.ndarray
    contacts: tuple[Contacts, ...]
    ratios: tuple[float, ...]


def rotor_of(parameters: ShaftScene, law: str, ratios=(0.0, 0.0)) -> Rotor:
    """The numbers of the equations of motion for a scene with the elastic law `law`."""
    shaft, seats = parameters.shaft, []
    for side, ratio in zip(SIDES, ratios, strict=True):
        mounted, scene = getattr(parameters, side), bearing_scene(parameters, side)
        position_numbers = (mounted.place, mounted.facing, middle_of(mounted), mounted.ball_angle, ratio)
        setting = setting_of(scene, law, parameters.drive.speed)
        balls, gravity = int(mounted.geometry.balls), tuple(map(float, scene.gravity))
        seats.append(ShaftSeat(setting, balls, *map(float, position_numbers), gravity))
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
    """The arm [m] by which a tilt of the shaft moves its bearings' grooves."""
    return max(abs(seat.place) + seat.setting.arm for seat in rotor.seats)


def coordinate_bound(rotor: Rotor) -> float:
    """Bound [m] of all coordinates of the shaft from the middle, tilts by their arm."""
    balls = max(2.0 * seat.setting.ball_radius for seat in rotor.seats)
    return GREATEST_COORDINATE * balls + max(abs(seat.middle) for seat in rotor.seats)


class ShaftSolver(EquilibriumSolver):
    """Equilibria of a shaft on two bearings with their balls at their first azimuths."""

    body = "the shaft"
    remedy = "load it, or give less clearance, or preload by offsets of the outer rings"
    speed = 0.0  # rad/s, at which the shaft turns

    def __init__(self, rotor: Rotor, speed: float):
        self.rotor, self.speed = rotor, speed
        self.balls = tuple(seat.balls for seat in rotor.seats)
        self.azimuths = np.concatenate([azimuths_of(seat.balls, seat.first) for seat in rotor.seats])
        lever = lever_of(rotor)
        self.scales = np.array([1.0, 1.0, 1.0, lever, lever])
        self.longest = coordinate_bound(rotor)

    def seats(self) -> np.ndarray:
        """The numbers of both rings (2, SEAT) for the core."""
        seats = self.rotor.seat_numbers()
        seats[:, SPEED_COLUMN] = self.speed
        return seats

    def _at_rest(self) -> "ShaftSolver":
        return ShaftSolver(self.rotor, 0.0)

    def stable_balance(self, support: Support) -> Equilibrium:
        """As `checked_balance`, but also stable.

        Raises SceneError if at this speed nothing holds the shaft in a direction in which it is held at rest.
        """
        equilibrium, at_rest = self.checked_balance(support), self._at_rest()
        loose = loose_directions(equilibrium, support, self.scales)
        if loose and self.speed and not loose_directions(at_rest.checked_balance(support), support, self.scales):
            raise SceneError(
                f"at {self.speed:g} rad/s the balls are thrown outwards so far that nothing holds the shaft along "
                f"{', '.join(loose)}; lower the speed, or preload the bearings more"
            )
        return equilibrium

    def by_bearing(self, contacts: Contacts) -> list[Contacts]:
        """The contacts of each bearing."""
        first = self.balls[0]
        return [Contacts(*(values[:first] for values in contacts)), Contacts(*(values[first:] for values in contacts))]

    def limit_ratios(self, contacts: Contacts) -> tuple[float, float]:
        """Greatest squeeze and greatest contact angle of these contacts, each over its limit."""
        ratios = [
            [
                float(ratio.max())
                for ratio in limit_ratios(
                    seat.setting.ball_radius, of_bearing.load, of_bearing.approach, of_bearing.angle
                )
            ]
            for seat, of_bearing in zip(self.rotor.seats, self.by_bearing(contacts), strict=True)
        ]
        return tuple(map(max, zip(*ratios, strict=True)))


@functools.lru_cache(maxsize=8)
def balance_of(parameters: ShaftScene, law: str, speed: float, time: float = 0.0) -> ShaftBalance:
    """The shaft in balance under its weight and the scene's loads at `time` [s], turning at `speed` [rad/s].

    Raises SceneError for what no contact carries or what pushes the shaft through its balls.
    """
    solver, support = solver_of(parameters, law, speed), support_with_weight(parameters, loads_of(parameters, time))
    equilibrium = solver.stable_balance(support)
    contacts = solver.by_bearing(equilibrium.contacts)
    ratios = tuple(float(load_weighted_mean(of_bearing, of_bearing.share)) for of_bearing in contacts)
    return ShaftBalance(equilibrium.coordinates, equilibrium.stiffness, tuple(contacts), ratios)


def solver_of(parameters: ShaftScene, law: str, speed: float, first=None) -> ShaftSolver:
    """The solver for the shaft at `speed` [rad/s], balls at their first azimuths.

    Else `first(balls)` is the azimuth [rad] of the first of so many balls.
    """
    rotor = rotor_of(parameters, law)
    if first is not None:
        rotor = rotor._replace(seats=tuple(seat._replace(first=float(first(seat.balls))) for seat in rotor.seats))
    return ShaftSolver(rotor, float(speed))


def support_with_weight(parameters: ShaftScene, loads: np.ndarray) -> Support:
    """All coordinates free, under the shaft's weight and `loads` (5,) about its centre of mass."""
    weight = parameters.shaft.mass * np.array([*parameters.gravity, 0.0, 0.0])
    return Support((True,) * COORDINATES, tuple((weight + loads).tolist()), (0.0,) * COORDINATES)


def check_load(parameters: ShaftScene, law: str, speed: float, force, moment) -> None:
    """Raises BearingTwinError for a load [N], [N m] at `shaft.load_place` that the bearings do not carry.

    It is checked by `check_carried`, with the constant loads. None for force and moment: the scene's first loads.
    """
    loads = loads_of(parameters, 0.0)
    if force is not None:
        commanded = about_centre(parameters.shaft.load_place, commanded_loads(force, moment))
        loads = constant_loads(parameters) + commanded
    check_carried(parameters, law, speed, loads)


def check_carried(parameters: ShaftScene, law: str, speed: float, loads: np.ndarray) -> None:
    """Raises BearingTwinError for loads (5,) [N, N m] about the centre of mass that the bearings do not carry.

    They are tried in balance, with the shaft's weight, at `speed` [rad/s] and TRIAL_POSITIONS of the balls.
    """
    support = support_with_weight(parameters, loads)
    for position in range(TRIAL_POSITIONS):
        solver = solver_of(
            parameters, law, speed, lambda balls, position=position: trial_azimuth(support, balls, position)
        )
        solver.stable_balance(support)


def with_load_limit(error: IntegrationError, parameters: ShaftScene, law: str, speed: float, loads) -> IntegrationError:
    """The error, or one with time, loads (5,) on the shaft and limit, if nothing carries them."""
    try:
        check_carried(parameters, law, speed, loads)
    except BearingTwinError as limit:
        return IntegrationError(f"at {error.seconds:.9g} s {limit}", OVERLOAD, error.seconds, "shaft")
    return error


AXIAL = 1e-6  # of the motion's square: a mode with less of it across the axis does not whirl
REAL = 1e-6  # of a root, of the greatest: an imaginary part that is less is none


class Matrices(NamedTuple):
    """M (5,), G, K and damping (5, 5), and the arm [m] that converts tilts into displacements."""

    inertia: np.ndarray
    gyroscopic: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    lever: float


class WhirlModes(NamedTuple):
    """Natural frequencies [Hz], rising, and the share of each that whirls forward.

    It is 1 forward, 0 backward, 1/2 in a plane or along the axis.
    """

    frequencies: np.ndarray
    forward: np.ndarray


def matrices_of(rotor: Rotor, stiffness: np.ndarray) -> Matrices:
    """The matrices of a rotor with this stiffness of its bearings."""
    gyroscopic = np.zeros((5, 5))
    gyroscopic[3, 4], gyroscopic[4, 3] = rotor.polar, -rotor.polar
    inertia = np.array([rotor.mass] * 3 + [rotor.transverse] * 2)
    return Matrices(inertia, gyroscopic, stiffness, rotor.relaxation_time * stiffness, lever_of(rotor))


def stiffest_mode(matrices: Matrices) -> float:
    """The greatest natural angular frequency [rad/s] at rest."""
    root = np.sqrt(matrices.inertia)
    symmetric = 0.5 * (matrices.stiffness + matrices.stiffness.T) / np.outer(root, root)
    return math.sqrt(float(np.linalg.eigvalsh(symmetric).max()))


def _forward_share(shape: np.ndarray, lever: float) -> float | None:
    """The share of a motion u (5,) across the axis that whirls forward; None of a motion along it."""
    lateral = shape * np.array([1.0, 1.0, 0.0, lever, lever])
    forward = (abs(lateral[0] + 1j * lateral[1]) ** 2 + abs(lateral[3] + 1j * lateral[4]) ** 2) / 2.0
    total = float(np.sum(np.abs(lateral) ** 2))
    return float(forward) / total if total > AXIAL * (total + abs(shape[2]) ** 2) else None


def modes_at(matrices: Matrices, speed: float) -> WhirlModes:
    """The modes of small motion with the shaft turning at `speed` [rad/s], without overdamped ones."""
    inverse = 1.0 / matrices.inertia[:, None]
    damping = matrices.damping + speed * matrices.gyroscopic
    system = np.block([[np.zeros((5, 5)), np.eye(5)], [-inverse * matrices.stiffness, -inverse * damping]])
    roots, shapes = np.linalg.eig(system)
    swings = roots.imag > REAL * np.abs(roots).max()
    roots, shapes = roots[swings], shapes[:, swings]
    order = np.argsort(roots.imag)
    shares = [_forward_share(shapes[:5, k], matrices.lever) for k in order]
    forward = np.array([0.5 if share is None else share for share in shares])
    # exp(i v t) with v > 0; a shaft that turns backward is seen from its other side
    return WhirlModes(roots.imag[order] / (2.0 * math.pi), forward if speed >= 0.0 else 1.0 - forward)


def critical_speeds(matrices: Matrices) -> list[float]:
    """Speeds [rad/s], rising, at which a forward or planar mode whirls at the speed of the shaft.

    (K - w^2 (M - i G)) u = 0 without damping: a forward tilt has the inertia I_t - I_p and none above I_t = I_p.
    """
    symmetric = 0.5 * (matrices.stiffness + matrices.stiffness.T)
    inertia = np.diag(matrices.inertia).astype(complex) - 1j * matrices.gyroscopic
    # by 1 / w^2, which is 0 in directions without stiffness
    inverse, shapes = np.linalg.eig(np.linalg.pinv(symmetric, rcond=REAL**2, hermitian=True) @ inertia)
    speeds = []
    for k, value in enumerate(inverse):
        is_real = value.real > REAL**2 * np.abs(inverse).max() and abs(value.imag) <= REAL * abs(value)
        share = _forward_share(shapes[:, k], matrices.lever)
        if is_real and share is not None and share >= 0.5 - REAL:
            speeds.append(1.0 / math.sqrt(value.real))
    speeds.sort()
    return [speed for k, speed in enumerate(speeds) if k == 0 or speed > (1.0 + REAL) * speeds[k - 1]]


def unbalance_response(rotor: Rotor, matrices: Matrices, speed: float) -> np.ndarray:
    """The linear response u (5,) to the unbalances at an even speed: q = Re(u exp(i w t))."""
    damping = matrices.damping + speed * matrices.gyroscopic
    system = matrices.stiffness + 1j * speed * damping - speed**2 * np.diag(matrices.inertia)
    return np.linalg.solve(system, speed**2 * rotor.unbalance)


def last_matrices(parameters: ShaftScene, law: str) -> tuple[Matrices, float]:
    """The matrices of a scene in balance at the speed [rad/s], which follows, and the loads that its run ends with."""
    speed = float(speeds_of(parameters)[-1])
    stiffness = balance_of(parameters, law, speed, float(parameters.run.duration)).stiffness
    return matrices_of(rotor_of(parameters, law), stiffness), speed


@functools.lru_cache(maxsize=8)
def modes_of(parameters: ShaftScene, law: str) -> tuple[WhirlModes, list[float]]:
    """The modes and the critical speeds of a scene, in balance at the speed and the loads that its run ends with."""
    matrices, speed = last_matrices(parameters, law)
    return modes_at(matrices, speed), critical_speeds(matrices)
