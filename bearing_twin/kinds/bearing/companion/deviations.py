"""How far a stretch of a bearing run is from what a companion found for it."""

import functools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.companion.windows import Window
from bearing_twin.kinds.bearing.forces.equations import Bearing, RingDrive
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    DISSIPATED,
    DRIVE_WORK,
    MOTION,
    ORBIT_ANGLE,
    TANGENTIAL_VELOCITY,
)
from bearing_twin.kinds.bearing.stepping.border import Partners
from bearing_twin.sample import Columns, Layout

LEAST_LOAD = 0.01  # of the greatest load: a contact that carries less has no friction limit worth a relative error


def drive_later(drive: RingDrive, start: float) -> RingDrive:
    """The drive `start` [s] later, while it accelerates evenly."""
    angle, speed, acceleration = drive
    return RingDrive(angle + start * (speed + 0.5 * acceleration * start), speed + acceleration * start, acceleration)


def lengths(vectors: np.ndarray) -> np.ndarray:
    """Lengths of vectors (..., 3), to the bit those of `np.linalg.norm`, in a third of its time."""
    squares = vectors * vectors
    return np.sqrt(squares[..., 0] + squares[..., 1] + squares[..., 2])


@kernel
def _lengths(vectors, found):
    """Fills `found` (outputs, balls, 2) with the lengths of vectors (outputs, balls, 2, 3)."""
    for output in range(len(vectors)):
        for ball in range(vectors.shape[1]):
            for side in range(2):
                vector = vectors[output, ball, side]
                found[output, ball, side] = math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)


@dataclass(eq=False)
class Part:
    """A stretch of a run that was integrated in one go, with what it began from and what it gave out.

    `begun` are the arrays that moved on, as they were: state, orientation, steps, carried, border. `filled` are states,
    orientations and borders at `times` [s] from `elapsed` [s] on, `out` the channels there. `taken` are the steps
    of all balls since the run began. What is asked of all outputs again and again is read out of `out` once: its rows
    are wide, and memory that was not read for a while is slow.
    """

    bearing: Bearing
    drive: RingDrive
    partners: Partners
    near: np.ndarray
    times: np.ndarray
    duration: float
    begun: list
    filled: tuple
    out: Columns
    pointer: np.ndarray
    elapsed: float
    taken: int

    def start(self, output: int) -> float:
        """Time [s] of an output from the beginning of the part, which is output -1."""
        return 0.0 if output < 0 else float(self.times[output])

    def drive_from(self, start: float) -> RingDrive:
        """The drive `start` [s] later."""
        return drive_later(self.drive, start)

    @functools.cached_property
    def load(self) -> np.ndarray:
        """Normal loads [N] (outputs, balls, 2) of the channel of that name."""
        return self.out["normal_load"].copy()

    @functools.cached_property
    def friction(self) -> np.ndarray:
        """Lengths [N] (outputs, balls, 2) of the friction forces."""
        found = np.empty(self.load.shape)
        _lengths(self.out["friction_force"].copy(), found)
        return found

    @functools.cached_property
    def all_bear(self) -> bool:
        """Whether every contact bears load at every output, as nearly always."""
        return float(self.load.min()) > 0.0

    @functools.cached_property
    def carried(self) -> np.ndarray:
        """Which balls (outputs, balls) both raceways bear."""
        return (self.load[..., 0] > 0.0) & (self.load[..., 1] > 0.0)

    @functools.cached_property
    def in_flight(self) -> np.ndarray:
        """Which balls (outputs, balls) touch neither raceway."""
        if self.all_bear:
            return np.zeros(self.load.shape[:2], bool)
        return (self.load[..., 0] == 0.0) & (self.load[..., 1] == 0.0)

    @functools.cached_property
    def flies(self) -> bool:
        """Whether any ball touches neither raceway at an output."""
        return not self.all_bear and bool(self.in_flight.any())


class Found(NamedTuple):
    """What a companion found: channels and states (instants, balls, ...), and the steps it took in all.

    A ball by itself has channels without an axis of balls, states with one of length 1. `last` are state, orientation,
    step sizes and what laws carry at the end, one row a ball, then ring and cage.
    """

    out: Columns
    states: np.ndarray
    last: tuple[np.ndarray, ...]
    steps: int


_READ = "normal_load", "friction_force", "raceway_torque", "contact_angle", "roll_rate"
LOADS, FRICTIONS, TORQUE, ANGLES, ROLL = 0, 2, 8, 11, 13  # of what stands at `_places`, the first number of each
GREATEST = 7  # errors that `_compare` finds: of load, friction, torque, contact angle, orbit angle and speed, roll rate


@functools.cache
def _places(layout: Layout) -> np.ndarray:
    """Where the numbers of the channels of `_READ` stand in a row, one ball after the other (balls, ROLL + 1)."""
    places = (layout.places[name] for name in _READ)
    numbers = [np.arange(at.start, at.stop) for at, _ in places]
    return np.column_stack([one.reshape(len(numbers[-1]), -1) for one in numbers])


@inlined
def _length(one, two, three):
    return math.sqrt(one * one + two * two + three * three)


@inlined
def _between(run, exact, here, there, first):
    """The length of a difference of vectors, of which three numbers begin at place number `first`."""
    one, two = run[here[first]] - exact[there[first]], run[here[first + 1]] - exact[there[first + 1]]
    return _length(one, two, run[here[first + 2]] - exact[there[first + 2]])


@inlined
def _torque(row, places):
    return _length(row[places[TORQUE]], row[places[TORQUE + 1]], row[places[TORQUE + 2]])


@inlined
def _keep(found, place, value):
    """Keeps the greatest; a NaN stays."""
    if value > found[place] or value != value:
        found[place] = value


@kernel
def _compare(run, exact, here, there, mine, theirs, ball, radius, coefficient, least, found, mean):
    """Fills `found` (GREATEST,) and `mean` (balls,), by how much the mean torque differs.

    Rows of channels of a `run` and of what is `exact`, numbers of balls `here` and `there` in them; states `mine`, from
    number `ball` on, and `theirs`.
    """
    for row in range(len(run)):
        one, two = run[row], exact[row]
        for k in range(len(there)):
            place, other = here[k], there[k]
            loads = two[other[LOADS]], two[other[LOADS + 1]]
            for side in range(2):
                _keep(found, 0, abs(one[place[LOADS + side]] - loads[side]))
                angle = abs(one[place[ANGLES + side]] - two[other[ANGLES + side]])
                _keep(found, 3, angle if loads[side] > 0.0 else 0.0)
                if least > 0.0 and coefficient > 0.0:
                    force = _between(one, two, place, other, FRICTIONS + 3 * side)
                    _keep(found, 1, force / max(loads[side], least) / coefficient)
            torque = _between(one, two, place, other, TORQUE)
            _keep(found, 2, torque)
            if least > 0.0 and coefficient > 0.0:
                _keep(found, 1, torque / radius / max(loads[0] + loads[1], least) / coefficient)
            _keep(found, 6, abs(one[place[ROLL]] - two[other[ROLL]]))
            mean[k] += (_torque(one, place) - _torque(two, other)) / len(run)
            own, true = mine[row, ball + k], theirs[row, k]
            speed = own[TANGENTIAL_VELOCITY] / own[AXIS_DISTANCE] - true[TANGENTIAL_VELOCITY] / true[AXIS_DISTANCE]
            _keep(found, 5, abs(speed))
    for k in range(len(there)):
        _keep(found, 4, abs(mine[len(run) - 1, ball + k, ORBIT_ANGLE] - theirs[len(run) - 1, k, ORBIT_ANGLE]))


def deviations(part: Part, window: Window, found: Found, greatest_load: float) -> list[float]:
    """The greatest errors of the run in a window: what stands behind `tolerance` in a row of WINDOW."""
    rows, alone, bearing = slice(window.begin + 1, window.begin + 1 + window.length), window.ball >= 0, part.bearing
    ball, here = (window.ball if alone else 0), _places(part.out.layout)
    here, there = here[ball : ball + 1] if alone else here, _places(found.out.layout)
    greatest, mean, mine = np.zeros(GREATEST), np.zeros(len(there)), part.filled[0][rows]
    numbers = float(bearing.ball_radius), float(bearing.friction_coefficient), LEAST_LOAD * greatest_load
    channels = part.out.numbers[rows], found.out.numbers, here, there
    _compare(*channels, mine, found.states, ball, *numbers, greatest, mean)
    load, friction, torque, contact_angle, orbit_angle, orbit_speed, roll = greatest.tolist()
    before = 0.0 if window.begin < 0 else part.times[window.begin]
    seconds = float(part.times[rows][-1] - before)
    last = mine[-1, ball : ball + len(there)] - found.states[-1]  # one row a ball
    integrals = np.abs(last[0] if alone else last.mean(axis=0))  # what one ball gets too much another gets too little
    speed = abs(part.drive.speed) + abs(part.drive.acceleration) * part.duration
    if part.partners.shaft:
        speed = float(np.abs(part.out["inner_ring_speed"][rows]).max())
    ring = [0.0, 0.0]
    if not alone:
        names = "inner_ring_offset", "inner_ring_force"
        ring = [float(np.abs(part.out[one][rows] - found.out[one]).max()) for one in names]
    return [
        load,
        friction,
        torque,
        contact_angle,
        orbit_angle,
        orbit_speed,
        roll,
        float(integrals[DRIVE_WORK]) / (speed * seconds) if speed > 0.0 else 0.0,
        float(integrals[DISSIPATED]) / seconds,
        *ring,
        max(mean.tolist(), key=abs),
    ]


def left_over(part: Part, window: Window, found: Found, allowed: np.ndarray) -> float:
    """The error of the motion at the end of a window, over what is `allowed` (MOTION,); the orbit angle does not count.

    How far a ball has gone round changes its loads little; all else may come back as an error of force.
    """
    those, own = (slice(None), slice(None)) if window.ball < 0 else (window.ball, 0)
    mine = part.filled[0][window.begin + window.length, those, :MOTION]
    error = np.abs(mine - found.states[-1, own, :MOTION]) / allowed
    error[..., ORBIT_ANGLE] = 0.0
    return float(error.max())


def off_in_flight(part: Part, window: Window, found: Found) -> float:
    """How far [m] the ball of a window was off along the radius at outputs where it touched neither raceway.

    0 of all balls at once.
    """
    if window.ball < 0:
        return 0.0
    rows = slice(window.begin + 1, window.begin + 1 + window.length)
    if not part.flies or not (free := part.in_flight[rows, window.ball]).any():
        return 0.0
    off = part.filled[0][rows, window.ball, AXIS_DISTANCE] - found.states[:, 0, AXIS_DISTANCE]
    return float(np.abs(off[free]).max(initial=0.0))
