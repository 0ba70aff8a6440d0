"""Acceleration that a sensor on the housing measures; the housing is a mass on a spring and a damper.

The force of balls on the outer ring, along the sensor's direction, moves the housing, m a = F - c v - k x, and the
outer ring with it. Where that ring is held, the force moves the housing alone. As in the converter of a sensor, the
acceleration is sampled at several times the rate of the sensor and filtered against aliasing before it is decimated.
"""

import math

import numpy as np

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.base.sample import Block, Channel, Table
from bearing_twin.kinds.bearing.parameters import has_sensor

NOISE_BLOCK = 1024  # samples whose noise is drawn at once
CONVERTER_RATE = 2e5  # Hz, at least, of samples before the filter: balls ring on their raceways at some 50 kHz
LEAST_DECIMATED, MOST_DECIMATED = 4, 1000  # samples before the filter for each that is given out
# An elliptic low-pass: order, ripple [dB] of the pass band up to EDGE of the rate, attenuation [dB] from 0.56 of it on.
ORDER, RIPPLE, ATTENUATION, EDGE = 8, 0.1, 80.0, 0.4
INSTANTS = 500  # of which forces are computed at once
WINDOW = 10.0  # s, of samples at the end of a run, which figures and the health of a bearing are made of
OK, WARN, STALE = 0, 1, 3  # levels of diagnostic_msgs/DiagnosticStatus
LINES = {"BPFO": "bpfo", "BPFI": "bpfi", "2BSF": "bsf"}  # of damage: in spectra, in figures

ACCELERATION = Table(
    "acceleration",
    (Channel("time", "s", (), "of the sample"), Channel("acceleration", "m/s^2", (), "of the housing, as measured")),
    "samples of the sensor on the housing",
    needed=False,
)


def tables(parameters) -> tuple[Table, ...]:
    """The samples of the sensor, where there is one."""
    return (ACCELERATION._replace(rate=parameters.sensor.rate),) if has_sensor(parameters) else ()


class Accelerometer:
    """Samples of a scene's sensor, delayed by its filter: by two of their periods at low frequencies.

    `state` holds the number of the last filtered instant, the force at rest [N], and the states of the sections
    of the filter; it is () at the start. `housing` is that which moves with the outer ring, empty for a held ring.
    """

    def __init__(self, parameters, housing):
        from scipy.signal import cont2discrete, ellip

        sensor, held = parameters.sensor, parameters.housing
        self._sensor, self._housing = sensor, housing
        self._along = np.array(sensor.unit_direction)
        self._every = min(max(math.ceil(CONVERTER_RATE / sensor.rate), LEAST_DECIMATED), MOST_DECIMATED)
        self._rate = self._every * sensor.rate
        system = [1.0, 0.0, 0.0], [held.mass, held.damping, held.stiffness]
        up, down, _ = cont2discrete(system, 1.0 / self._rate, "foh")  # forces straight between samples: exact
        low_pass = ellip(ORDER, RIPPLE, ATTENUATION, EDGE, output="sos", fs=self._every)
        self._sections = low_pass if housing else np.vstack([np.append(up, down), low_pass])

    def restored(self, numbers, elapsed: float) -> tuple:
        """The state of a snapshot at `elapsed` [s]; () where that is of another filter."""
        count, *kept = map(float, numbers)
        fits = len(kept) == 1 + 2 * len(self._sections) and abs(count - elapsed * self._rate) <= 1.0
        return (int(count), *kept) if fits and np.isfinite(kept).all() else ()

    def times(self, state: tuple, begin: float, end: float) -> np.ndarray:
        """The instants [s] up to `end` at which forces are taken and were not before."""
        first = state[0] + 1 if state else max(0, math.ceil(begin * self._rate - 1e-6))
        return np.arange(first, math.floor(end * self._rate + 1e-6) + 1) / self._rate

    def samples(
        self, state: tuple, times: np.ndarray, forces: np.ndarray, moved: np.ndarray
    ) -> tuple[tuple, np.ndarray]:
        """The state after forces (n, 3) [N] on the outer ring at `times` [s], and rows (m, 2) of the samples then.

        `moved` (n, 2) are place [m] and velocity [m/s] of a housing that moves with the ring.
        """
        from scipy.signal import sosfilt

        if not len(times):
            return state, np.zeros((0, 2))
        pushed, housing = forces @ self._along, self._housing
        if housing:
            pushed = (pushed + housing.load - moved @ (housing.stiffness, housing.damping)) / housing.mass
        _, rest, *kept = state or (0, 0.0 if housing else pushed[0], *np.zeros(2 * len(self._sections)))
        found, kept = sosfilt(self._sections, pushed - rest, zi=np.reshape(kept, (-1, 2)))
        numbers = np.rint(times * self._rate).astype(int)
        state = int(numbers[-1]), float(rest), *kept.ravel().tolist()
        given = numbers % self._every == 0
        found, numbers = found[given], numbers[given] // self._every
        if self._sensor.noise and len(found):
            found = found + self._sensor.noise * self._noise(numbers)
        return state, np.stack([numbers / self._sensor.rate, found.astype(np.float32)], axis=1)

    def _noise(self, numbers: np.ndarray) -> np.ndarray:
        """Standard normal numbers, the same for a sample however a run is cut."""
        blocks = range(numbers[0] // NOISE_BLOCK, numbers[-1] // NOISE_BLOCK + 1)
        drawn = [np.random.default_rng((self._sensor.seed, one)).standard_normal(NOISE_BLOCK) for one in blocks]
        return np.concatenate(drawn)[numbers - blocks[0] * NOISE_BLOCK]


class Listener:
    """Gathers the last samples of a sensor, block by block, and judges their envelope spectrum."""

    def __init__(self, parameters):
        self._geometry, self._rate = parameters.geometry, parameters.sensor.rate
        self._most = round(WINDOW * self._rate)
        self._parts: list[tuple[np.ndarray, np.ndarray]] = []  # samples (n, 2); times [s] and speeds (m, 2)
        self._count = 0

    def add(self, block: Block) -> None:
        """Takes a block in."""
        rows = np.array(block.records.get(ACCELERATION.name, np.zeros((0, 2))))
        self._parts.append((rows, np.stack([1e-9 * block.time_ns, block.values["inner_ring_speed"]], axis=1)))
        self._count += len(rows)
        while self._count - len(self._parts[0][0]) >= self._most:
            self._count -= len(self._parts.pop(0)[0])

    def spectrum(self):
        """The `Spectrum` of the last WINDOW of samples; raises BearingTwinError where they are too few to be judged."""
        from bearing_twin.vibration.envelope import LEAST_SAMPLES, spectrum_of

        samples, course = map(np.concatenate, zip(*self._parts, strict=True))
        samples = samples[-self._most :]
        if len(samples) < LEAST_SAMPLES:
            raise BearingTwinError("there are too few samples of the sensor yet")
        course = course[min(np.searchsorted(course[:, 0], samples[0, 0]), len(course) - 1) :]
        course = course[:, 0] - samples[0, 0], course[:, 1]
        return spectrum_of(samples[:, 1].astype(np.float32), self._rate, self._geometry, course)

    def fields(self) -> dict:
        """diagnostic_msgs/DiagnosticArray: the verdict of the spectrum, a warning where it names damage."""
        from bearing_twin.vibration.envelope import DAMAGE

        try:
            found = self.spectrum()
            said, level = DAMAGE.get(found.verdict, found.verdict), WARN if found.verdict in DAMAGE else OK
            numbers = {"rms_m_s2": found.rms, "kurtosis": found.kurtosis}
            numbers |= {f"{line.name}_over_noise_db": line.over_noise_db for line in found.lines if line.name in LINES}
        except BearingTwinError as error:
            said, level, numbers = str(error), STALE, {}
        values = [{"key": key, "value": f"{value:.4g}"} for key, value in numbers.items()]
        status = {"level": level, "name": "bearing: acceleration", "message": said, "hardware_id": "bearing_twin"}
        return {"status": [{**status, "values": values}]}

    def figures(self) -> dict[str, float | None]:
        """RMS [m/s^2] and levels over the noise [dB] of the first line of each family; None where none can be had."""
        keys = "acceleration_rms_m_s2", *(f"{name}_over_noise_db" for name in LINES.values())
        try:
            found = self.spectrum()
        except BearingTwinError:
            return dict.fromkeys(keys)
        level = {line.name: line.over_noise_db for line in found.lines}
        return dict(zip(keys, (found.rms, *(level[name] for name in LINES)), strict=True))
