"""Newton's method for the motion of a ball whose axis of spin has settled (`settled`)."""

import functools
import math

import numpy as np

from bearing_twin.kinds.bearing.quasi_static.statics import azimuths_of
from bearing_twin.kinds.bearing.quasi_static.surroundings import UNKNOWNS, Surroundings

SMOOTHER = (16.0, 4.0, 1.0)  # times the slip that friction is smoothed over, on the way to it
LONGER = 16.0  # times the time before: over which the axis turns in the next step
LONG = 1e7  # turns: as good as for ever
STEPS = 25  # of Newton's method at most, under what is held
TRIES = 6  # at shorter times where one leads nowhere
NEAR, FOUND = 1e-4, 1e-8  # relative steps with which a stage ends, and the last
LEAST = 1e-3  # of a step
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


class Search:
    """Newton's method for a turn at `count` azimuths; unknowns are the motion, azimuth by azimuth, and the orbit."""

    def __init__(self, parameters, setting, coordinates, count: int, load: float, gravity=(0.0, 0.0, 0.0)):
        self.setting, self.count = setting, count
        self.slope = _by_azimuth(count)
        self.curve = self.slope @ self.slope
        tiled = np.tile(azimuths_of(count, 0.0), 1 + len(_NUDGES) + 1)
        self.one = Surroundings(parameters, setting, coordinates, tiled[:count], gravity)
        self.all = Surroundings(parameters, setting, coordinates, tiled, gravity)
        self.smooth, radius = self.one.smooth, setting.ball_radius
        self.nudges = _NUDGES * np.array([radius] * 2 + [self.smooth] * 2 + [self.smooth / radius] * 3)
        arm = 1e-3 * radius
        self.rows = np.append(np.tile(load * np.array([1.0, 1.0, arm, arm, arm]), count), load * arm)
        turns = abs(setting.speed)
        self.columns = np.append(np.tile([1e-6, 1e-6, turns, turns, turns], count), turns)
        heavy = self.one.inertia
        round_axis = setting.ball_mass * (0.5 * setting.pitch_diameter) ** 2
        self.held = np.append(np.tile([0.0, 0.0, heavy, heavy, heavy], count), round_axis)

    def motion(self, unknowns):
        """Motion (M, 7) with the rates of places, and the orbit speed."""
        turning, orbit = unknowns[:-1].reshape(self.count, UNKNOWNS), unknowns[-1]
        return np.concatenate([turning[:, :2], orbit * (self.slope @ turning[:, :2]), turning[:, 2:]], axis=1), orbit

    def _whole(self, balance, turning, orbit):
        left = balance[:, :UNKNOWNS].copy()
        left[:, :2] -= self.setting.ball_mass * orbit**2 * (self.curve @ turning[:, :2])
        left[:, 2:] -= self.one.inertia * orbit * (self.slope @ turning[:, 2:])
        return np.append(left.ravel(), balance[:, 5].mean())

    def left(self, unknowns) -> np.ndarray:
        """What is left of all equations."""
        motion, orbit = self.motion(unknowns)
        return self._whole(self.one.balance(motion, orbit), unknowns[:-1].reshape(self.count, UNKNOWNS), orbit)

    def derivatives(self, unknowns) -> np.ndarray:
        """Of `left` by the unknowns."""
        count, (motion, orbit) = self.count, self.motion(unknowns)
        turning, further = unknowns[:-1].reshape(count, UNKNOWNS), 1e-7 * orbit
        many = np.tile(motion, (2 + len(_NUDGES), 1)).reshape(-1, count, motion.shape[1])
        for i, nudge in enumerate(self.nudges):
            many[1 + i, :, i] += nudge
        orbits = np.full((len(many), count), orbit)
        orbits[-1] += further
        found = self.all.balance(many.reshape(-1, motion.shape[1]), orbits.ravel()).reshape(-1, count, 6)
        by = (found[1:-1] - found[0]) / self.nudges[:, None, None]  # (7, M, 6)
        matrix = np.zeros((UNKNOWNS * count + 1,) * 2)
        blocks, mean = matrix[:-1, :-1].reshape(count, UNKNOWNS, count, UNKNOWNS), np.zeros((count, UNKNOWNS))
        here = np.arange(count)
        for column, source in enumerate((0, 1, 4, 5, 6)):
            blocks[here, :, here, column] += by[source, :, :UNKNOWNS]
            mean[:, column] += by[source, :, 5]
        for column, source in enumerate((2, 3)):
            blocks[:, :, :, column] += orbit * by[source, :, :UNKNOWNS, None] * self.slope[:, None, :]
            mean[:, column] += orbit * (by[source, :, 5] @ self.slope)
        for row in range(UNKNOWNS):
            moved = self.setting.ball_mass * orbit * self.curve if row < 2 else self.one.inertia * self.slope
            blocks[:, row, :, row] -= orbit * moved
        matrix[-1, :-1] = mean.ravel() / count
        quicker = (found[-1] - found[0]) / further
        for source, column in ((2, 0), (3, 1)):
            quicker += by[source] * (self.slope @ turning[:, column])[:, None]
        matrix[:, -1] = self._whole(quicker, turning, 0.0)
        inertial = np.zeros((count, UNKNOWNS))
        inertial[:, :2] = 2.0 * self.setting.ball_mass * orbit * (self.curve @ turning[:, :2])
        inertial[:, 2:] = self.one.inertia * (self.slope @ turning[:, 2:])
        matrix[:-1, -1] -= inertial.ravel()
        return matrix

    def newton(self, begin, before, rate: float, enough: float, guarded: bool):
        """Unknowns with which the spins, and the orbit, have changed from `before` at this rate [1/s]; None if none."""
        at, held = begin, self.held * rate
        left = self.left(at) - held * (at - before)
        for _ in range(STEPS):
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
        at, rate = begin, abs(begin[-1]) / (2.0 * math.pi)
        last = rate / LONG
        for times in SMOOTHER:
            self.one.smooth = self.all.smooth = times * self.smooth
            some = self.newton(at, begin, rate, NEAR if times == 1.0 else 1e-2, True)
            if some is None:
                return None
            at = some
        tries = 0
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
