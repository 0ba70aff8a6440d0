"""Newton's method for the motion of a ball whose axis of spin has settled (`settled`)."""

import functools
import math

import numpy as np

from bearing_twin.kinds.bearing.drive import cage_inertia
from bearing_twin.kinds.bearing.quasi_static.statics import azimuths_of
from bearing_twin.kinds.bearing.quasi_static.surroundings import UNKNOWNS, Surroundings
from bearing_twin.stopping import look

SMOOTHER = (16.0, 4.0, 1.0)  # times the slip that friction is smoothed over, on the way to it
LONGER = 16.0  # times the time before: over which the axis turns in the next step
LONG = 1e7  # turns: as good as for ever
STEPS = 25  # of Newton's method at most, under what is held
TRIES = 6  # at shorter times where one leads nowhere
NEAR, FOUND = 1e-4, 1e-8  # relative steps with which a stage ends, and the last
LEAST = 1e-3  # of a step
PASSING = 8  # waves of the orbit speed as one ball passes another's place, as far as the azimuths resolve them
SOLVED = 1e-9  # of the greatest load, and with arms of thousandths of its moment: rounding
GREW = 10.0  # times: what a step may leave more than there was where nothing else leads along
_NUDGES = np.array([1e-7, 1e-7, 1e-6, 1e-6, 1e-4, 1e-4, 1e-4])  # of the ball's radius, of the smoothing, of both


@functools.cache
def _by_azimuth(count: int) -> np.ndarray:
    """The matrix that differentiates sums of waves at so many even azimuths, an odd number."""
    apart = np.subtract.outer(np.arange(count), np.arange(count))
    turned = np.sin(np.pi * apart / count)
    signs = np.where(apart % 2 == 0, 0.5, -0.5)
    return np.divide(signs, turned, out=np.zeros_like(turned), where=apart != 0)


def passing_waves(azimuths: np.ndarray, balls: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """1, then cosine and sine of each of `count` waves that repeat themselves from ball to ball, and their slopes.

    At azimuths [rad] (K,); both are (K, 1 + 2 count).
    """
    order = balls * np.repeat(np.arange(1, 1 + count), 2)
    ahead = np.outer(azimuths, order) - np.tile([0.0, 0.5 * math.pi], count)
    one = np.ones((len(azimuths), 1))
    return np.concatenate([one, np.cos(ahead)], axis=1), np.concatenate([0.0 * one, -order * np.sin(ahead)], axis=1)


def parted(unknowns: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The motion (M, UNKNOWNS) at `count` azimuths, and the orbit speed: its mean, then its waves [rad/s]."""
    motion, speeds = np.split(unknowns, [count * UNKNOWNS])
    return motion.reshape(count, UNKNOWNS), speeds


class Search:
    """Newton's method for a turn at `count` azimuths of balls in one cage, each with its share of that.

    Unknowns are the motion, azimuth by azimuth, and the orbit speed: its mean, and the cosines and sines of its waves.
    """

    def __init__(
        self, parameters, setting, coordinates, count: int, load: float, gravity=(0.0, 0.0, 0.0), passing=PASSING
    ):
        self.setting, self.count, balls = setting, count, parameters.geometry.balls
        azimuths = azimuths_of(count, 0.0)
        self.waves, self.changes = passing_waves(azimuths, balls, min(passing, (count - 1) // (2 * balls)))
        self.share = cage_inertia(parameters) / balls if parameters.cage.kind != "none" else 0.0
        self.slope = _by_azimuth(count)
        self.curve = self.slope @ self.slope
        tiled = np.tile(azimuths, 1 + len(_NUDGES) + 1)
        self.one = Surroundings(parameters, setting, coordinates, tiled[:count], gravity)
        self.all = Surroundings(parameters, setting, coordinates, tiled, gravity)
        self.smooth, radius = self.one.smooth, setting.ball_radius
        self.nudges = _NUDGES * np.array([radius] * 2 + [self.smooth] * 2 + [self.smooth / radius] * 3)
        arm = 1e-3 * radius
        self.rows = np.append(
            np.tile(load * np.array([1.0, 1.0, arm, arm, arm]), count), [load * arm] * self.waves.shape[1]
        )
        turns = abs(setting.speed)
        self.columns = np.append(np.tile([1e-6, 1e-6, turns, turns, turns], count), [turns] * self.waves.shape[1])
        heavy = self.one.inertia
        round_axis = setting.ball_mass * (0.5 * setting.pitch_diameter) ** 2
        self.held = np.append(np.tile([0.0, 0.0, heavy, heavy, heavy], count), [round_axis] * self.waves.shape[1])

    def split(self, unknowns):
        """The motion (M, UNKNOWNS), the orbit speed (M,) [rad/s] and its derivative by the azimuth."""
        turning, speeds = parted(unknowns, self.count)
        return turning, self.waves @ speeds, self.changes @ speeds

    def motion(self, unknowns):
        """Motion (M, 7) with the rates of places, and the orbit speed (M,)."""
        turning, orbit, _ = self.split(unknowns)
        rates = orbit[:, None] * (self.slope @ turning[:, :2])
        return np.concatenate([turning[:, :2], rates, turning[:, 2:]], axis=1), orbit

    def left(self, unknowns) -> np.ndarray:
        """What is left of all equations."""
        turning, orbit, change = self.split(unknowns)
        balance, mass = self.one.balance(*self.motion(unknowns)), self.setting.ball_mass
        slope, left = self.slope @ turning, balance[:, :UNKNOWNS].copy()
        curved = orbit[:, None] * (self.curve @ turning[:, :2]) + change[:, None] * slope[:, :2]
        left[:, :2] -= mass * orbit[:, None] * curved
        left[:, 2:] -= self.one.inertia * orbit[:, None] * slope[:, 2:]
        distance = self.setting.outer.locus_radius + turning[:, 0]
        gained = (mass * distance * distance + self.share) * change + 2.0 * mass * distance * slope[:, 0] * orbit
        return np.append(left.ravel(), self.waves.T @ (balance[:, 5] - orbit * gained) / self.count)

    def derivatives(self, unknowns) -> np.ndarray:
        """Of `left` by the unknowns."""
        count, (motion, orbit) = self.count, self.motion(unknowns)
        (turning, _, change), further = self.split(unknowns), 1e-7 * orbit
        many = np.tile(motion, (2 + len(_NUDGES), 1)).reshape(-1, count, motion.shape[1])
        for i, nudge in enumerate(self.nudges):
            many[1 + i, :, i] += nudge
        orbits = np.tile(orbit, (len(many), 1))
        orbits[-1] += further
        found = self.all.balance(many.reshape(-1, motion.shape[1]), orbits.ravel()).reshape(-1, count, 6)
        by = (found[1:-1] - found[0]) / self.nudges[:, None, None]  # (7, M, 6)
        quicker = (found[-1] - found[0]) / further[:, None]
        size, slope, mass, waves = count * UNKNOWNS, self.slope @ turning, self.setting.ball_mass, self.waves
        matrix = np.zeros((len(unknowns),) * 2)
        blocks = matrix[:size, :size].reshape(count, UNKNOWNS, count, UNKNOWNS)
        along = np.zeros((count, count, UNKNOWNS))  # of the moment along the orbit less what the orbit gains
        here = np.arange(count)
        for column, source in enumerate((0, 1, 4, 5, 6)):
            blocks[here, :, here, column] += by[source, :, :UNKNOWNS]
            along[here, here, column] += by[source, :, 5]
        turned = orbit[:, None] * self.slope
        for column, source in enumerate((2, 3)):
            blocks[:, :, :, column] += by[source, :, :UNKNOWNS, None] * turned[:, None, :]
            along[:, :, column] += by[source, :, 5, None] * turned
        accelerated = mass * orbit[:, None] * (orbit[:, None] * self.curve + change[:, None] * self.slope)
        for row in range(UNKNOWNS):
            blocks[:, row, :, row] -= accelerated if row < 2 else self.one.inertia * turned
        distance = self.setting.outer.locus_radius + turning[:, 0]
        along[here, here, 0] -= 2.0 * mass * orbit * (distance * change + slope[:, 0] * orbit)
        along[:, :, 0] -= 2.0 * mass * (distance * orbit)[:, None] * turned
        matrix[size:, :size] = (waves.T @ along.reshape(count, size)) / count
        for source, column in ((2, 0), (3, 1)):
            quicker += by[source] * slope[:, column, None]
        curve = self.curve @ turning[:, :2]
        for wave in range(waves.shape[1]):
            one, more = waves[:, wave], self.changes[:, wave]
            changed = quicker * one[:, None]
            by_wave = (2.0 * one * orbit)[:, None] * curve + (one * change + orbit * more)[:, None] * slope[:, :2]
            changed[:, :2] -= mass * by_wave
            changed[:, 2:5] -= self.one.inertia * one[:, None] * slope[:, 2:]
            changed[:, 5] -= (mass * distance * distance + self.share) * (one * change + orbit * more)
            changed[:, 5] -= 4.0 * mass * distance * slope[:, 0] * orbit * one
            matrix[:size, size + wave] = changed[:, :UNKNOWNS].ravel()
            matrix[size:, size + wave] = waves.T @ changed[:, 5] / count
        return matrix

    def newton(self, begin, before, rate: float, enough: float, guarded: bool):
        """Unknowns with which the spins, and the orbit, have changed from `before` at this rate [1/s]; None if none.

        Raises Stopped.
        """
        at, held = begin, self.held * rate
        left = self.left(at) - held * (at - before)
        for _ in range(STEPS):
            look()
            matrix = (self.derivatives(at) - np.diag(held)) * self.columns / self.rows[:, None]
            size = np.abs(left / self.rows).max()
            try:
                step = np.linalg.solve(matrix, -left / self.rows) * self.columns
            except np.linalg.LinAlgError:
                return None
            part = 1.0
            while True:
                near = at + part * step
                left = self.left(near) - held * (near - before)
                now = np.abs(left / self.rows).max()
                if now <= max((1.0 - 0.25 * part) * size, SOLVED) or (not guarded and now < GREW * max(size, 0.1)):
                    break
                part *= 0.5
                if part < LEAST:
                    return None
            at = near
            if part == 1.0 and np.abs(step / self.columns).max() < enough:
                return at
        return None

    def found(self, begin):
        """The unknowns of a turn from `begin` on; None where the way leads nowhere."""
        at, rate = begin, self._rate(begin)
        for times in SMOOTHER:
            self.one.smooth = self.all.smooth = times * self.smooth
            some = self.newton(at, begin, rate, NEAR if times == 1.0 else 1e-2, True)
            if some is None:
                return None
            at = some
        return self._longer(at, rate)

    def _rate(self, unknowns) -> float:
        """1 / the time of a turn [1/s]."""
        return abs(unknowns[self.count * UNKNOWNS]) / (2.0 * math.pi)

    def _longer(self, at, rate: float):
        """The unknowns of a turn from those at this rate on, over ever longer times; None if it leads nowhere."""
        last, tries = self._rate(at) / LONG, 0
        while rate > 0.0:
            wanted = rate / LONGER if rate > last else 0.0
            some = self.newton(at, at, wanted, NEAR if wanted else FOUND, False)
            if some is not None:
                at, rate = some, wanted
                continue
            tries, rate = tries + 1, 0.5 * rate * LONGER
            if tries > TRIES:
                return None
        return at

    def again(self, begin):
        """The unknowns of a turn from one nearby; None where Newton's method leads nowhere."""
        return self.newton(begin, begin, 0.0, FOUND, False)

    def further(self, begin):
        """As `again`, where that led nowhere: over ever longer times."""
        rate = self._rate(begin)
        some = self.newton(begin, begin, rate, NEAR, True)
        return None if some is None else self._longer(some, rate)
