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
LEAST_DECIMATION, GREATEST_DECIMATION = 4, 1000  # samples before the filter for each of the sensor
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
    """The samples of the sensor; empty without one."""
    return (ACCELERATION._replace(rate=parameters.sensor.rate),) if has_sensor(parameters) else ()


class Accelerometer:
    """Samples of a scene's sensor, delayed by its filter: by two of their periods at low frequencies.

    `state` holds the number of the last filtered instant, the force at rest [N], and the states of the sections
    of the filter; it is () at the start. `housing` is that which moves with the outer ring, empty for a held ring.
    """

    def __init__(self, parameters, housing):
        from scipy.signal import cont2discrete, ellip

        sensor, fixed = parameters.sensor, parameters.housing
        self._sensor, self._housing = sensor, housing
        self._direction = np.array(sensor.unit_direction)
        decimation = math.ceil(CONVERTER_RATE / sensor.rate)
        self._decimation = min(max(decimation, LEAST_DECIMATION), GREATEST_DECIMATION)
        self._rate = self._decimation * sensor.rate
        system = [1.0, 0.0, 0.0], [fixed.mass, fixed.damping, fixed.stiffness]
        numerator, denominator, _ = cont2discrete(system, 1.0 / self._rate, "foh")  # exact for linear forces
        low_pass = ellip(ORDER, RIPPLE, ATTENUATION, EDGE, output="sos", fs=self._decimation)
        self._sections = low_pass if housing else np.vstack([np.append(numerator, denominator), low_pass])

    def restored(self, numbers, elapsed: float) -> tuple:
        """The state of a snapshot at `elapsed` [s]; () where that is of another filter."""
        count, *filter_state = map(float, numbers)
        fits = len(filter_state) == 1 + 2 * len(self._sections) and abs(count - elapsed * self._rate) <= 1.0
        return (int(count), *filter_state) if fits and np.isfinite(filter_state).all() else ()

    def times(self, state: tuple, begin: float, end: float) -> np.ndarray:
        """The next instants [s] of the converter up to `end`."""
        first = state[0] + 1 if state else max(0, math.ceil(begin * self._rate - 1e-6))
        return np.arange(first, math.floor(end * self._rate + 1e-6) + 1) / self._rate

    def samples(
        self, state: tuple, times: np.ndarray, forces: np.ndarray, motion: np.ndarray
    ) -> tuple[tuple, np.ndarray]:
        """The state after forces (n, 3) [N] on the outer ring at `times` [s], and the samples (m, 2).

        `motion` (n, 2) is position [m] and velocity [m/s] of a housing that moves with the ring.
        """
        from scipy.signal import sosfilt

        if not len(times):
            return state, np.zeros((0, 2))
        signal, housing = forces @ self._direction, self._housing
        if housing:
            signal = (signal + housing.load - motion @ (housing.stiffness, housing.damping)) / housing.mass
        at_start = 0, 0.0 if housing else signal[0], *np.zeros(2 * len(self._sections))
        _, force_at_rest, *filter_state = state or at_start
        filtered, filter_state = sosfilt(self._sections, signal - force_at_rest, zi=np.reshape(filter_state, (-1, 2)))
        instants = np.rint(times * self._rate).astype(int)
        state = int(instants[-1]), float(force_at_rest), *filter_state.ravel().tolist()
        is_sample = instants % self._decimation == 0
        filtered, instants = filtered[is_sample], instants[is_sample] // self._decimation
        if self._sensor.noise and len(filtered):
            filtered = filtered + self._sensor.noise * self._noise(instants)
        return state, np.stack([instants / self._sensor.rate, filtered.astype(np.float32)], axis=1)

    def _noise(self, numbers: np.ndarray) -> np.ndarray:
        """Standard normal numbers by the samples' numbers, independent of the chunks of a run."""
        blocks = range(numbers[0] // NOISE_BLOCK, numbers[-1] // NOISE_BLOCK + 1)
        noise = [np.random.default_rng((self._sensor.seed, block)).standard_normal(NOISE_BLOCK) for block in blocks]
        return np.concatenate(noise)[numbers - blocks[0] * NOISE_BLOCK]


class Listener:
    """Collects the last samples of a sensor, block by block, and computes their envelope spectrum."""

    def __init__(self, parameters):
        self._geometry, self._rate = parameters.geometry, parameters.sensor.rate
        self._greatest_count = round(WINDOW * self._rate)
        self._parts: list[tuple[np.ndarray, np.ndarray]] = []  # samples (n, 2); times [s] and speeds (m, 2)
        self._count = 0

    def add(self, block: Block) -> None:
        """Add a block."""
        rows = np.array(block.records.get(ACCELERATION.name, np.zeros((0, 2))))
        self._parts.append((rows, np.stack([1e-9 * block.time_ns, block.values["inner_ring_speed"]], axis=1)))
        self._count += len(rows)
        while self._count - len(self._parts[0][0]) >= self._greatest_count:
            self._count -= len(self._parts.pop(0)[0])

    def spectrum(self):
        """The `Spectrum` of the last WINDOW of samples; raises BearingTwinError where they are too few to be judged."""
        from bearing_twin.vibration.envelope import LEAST_SAMPLES, spectrum_of

        samples, speeds = map(np.concatenate, zip(*self._parts, strict=True))
        samples = samples[-self._greatest_count :]
        if len(samples) < LEAST_SAMPLES:
            raise BearingTwinError("there are too few samples of the sensor yet")
        speeds = speeds[min(np.searchsorted(speeds[:, 0], samples[0, 0]), len(speeds) - 1) :]
        speeds = speeds[:, 0] - samples[0, 0], speeds[:, 1]
        return spectrum_of(samples[:, 1].astype(np.float32), self._rate, self._geometry, speeds)

    def fields(self) -> dict:
        """diagnostic_msgs/DiagnosticArray: the verdict of the spectrum, a warning where it names damage."""
        from bearing_twin.vibration.envelope import DAMAGE

        try:
            spectrum = self.spectrum()
            message, level = DAMAGE.get(spectrum.verdict, spectrum.verdict), WARN if spectrum.verdict in DAMAGE else OK
            numbers = {"rms_m_s2": spectrum.rms, "kurtosis": spectrum.kurtosis}
            lines = (line for line in spectrum.lines if line.name in LINES)
            numbers |= {f"{line.name}_over_noise_db": line.over_noise_db for line in lines}
        except BearingTwinError as error:
            message, level, numbers = str(error), STALE, {}
        values = [{"key": key, "value": f"{value:.4g}"} for key, value in numbers.items()]
        status = {"level": level, "name": "bearing: acceleration", "message": message, "hardware_id": "bearing_twin"}
        return {"status": [{**status, "values": values}]}

    def figures(self) -> dict[str, float | None]:
        """RMS [m/s^2] and levels over the noise [dB] of the first line of each family; None where none can be had."""
        keys = "acceleration_rms_m_s2", *(f"{name}_over_noise_db" for name in LINES.values())
        try:
            spectrum = self.spectrum()
        except BearingTwinError:
            return dict.fromkeys(keys)
        level = {line.name: line.over_noise_db for line in spectrum.lines}
        return dict(zip(keys, (spectrum.rms, *(level[name] for name in LINES)), strict=True))
