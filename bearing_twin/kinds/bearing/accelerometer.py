"""What an accelerometer on the housing hears: the housing as a mass on a spring and a damper, pushed by the outer ring.

The force of balls on the outer ring, along the sensor's direction, moves the housing, m a = F - c v - k x. That does
not act back on the balls: the housing moves by F/k, little against the approach of a contact.
"""

import math

import numpy as np

from bearing_twin.base.sample import Channel, Table
from bearing_twin.kinds.bearing.housing import NONE

NOISE_BLOCK = 1024  # samples whose noise is drawn at once
ROOM = 500  # instants of which outputs are made at once

ACCELERATION = Table(
    "acceleration",
    (Channel("time", "s", (), "of the sample"), Channel("acceleration", "m/s^2", (), "of the housing, as measured")),
    "samples of the sensor on the housing",
    needed=False,
)


def tables(parameters) -> tuple[Table, ...]:
    """The samples of the sensor, where there is one."""
    return (ACCELERATION,) if parameters.sensor.on != NONE else ()


class Accelerometer:
    """Samples of a scene's sensor; what it was before is `state`: samples so far, filter (2,), or () at the start."""

    def __init__(self, parameters):
        from scipy.signal import cont2discrete

        sensor, housing = parameters.sensor, parameters.housing
        self._sensor, self.rate = sensor, sensor.rate
        self._along = np.array(sensor.direction) / math.hypot(*sensor.direction)
        system = [1.0, 0.0, 0.0], [housing.mass, housing.damping, housing.stiffness]
        up, down, _ = cont2discrete(system, 1.0 / sensor.rate, "foh")  # forces straight between samples: exact
        self._up, self._down = np.ravel(up), down

    def times(self, state: tuple, begin: float, end: float) -> np.ndarray:
        """The times [s] of the samples up to `end` that were not taken before."""
        first = int(state[0]) + 1 if state else max(0, math.ceil(begin * self.rate - 1e-6))
        return np.arange(first, math.floor(end * self.rate + 1e-6) + 1) / self.rate

    def heard(self, state: tuple, times: np.ndarray, forces: np.ndarray) -> tuple[tuple, np.ndarray]:
        """The state after samples at `times` [s] of forces (n, 3) [N] on the outer ring, and their rows (n, 2)."""
        from scipy.signal import lfilter, lfilter_zi

        if not len(times):
            return state, np.zeros((0, 2))
        pushed = forces @ self._along
        kept = np.array(state[1:]) if state else lfilter_zi(self._up, self._down) * pushed[0]  # at rest under it
        found, kept = lfilter(self._up, self._down, pushed, zi=kept)
        numbers = np.rint(times * self.rate).astype(int)
        if self._sensor.noise:
            found = found + self._sensor.noise * self._noise(numbers)
        return (int(numbers[-1]), *kept.tolist()), np.stack([times, found], axis=1)

    def _noise(self, numbers: np.ndarray) -> np.ndarray:
        """Standard normal numbers, the same for a sample however a run is cut."""
        blocks = range(numbers[0] // NOISE_BLOCK, numbers[-1] // NOISE_BLOCK + 1)
        drawn = [np.random.default_rng((self._sensor.seed, one)).standard_normal(NOISE_BLOCK) for one in blocks]
        return np.concatenate(drawn)[numbers - blocks[0] * NOISE_BLOCK]
