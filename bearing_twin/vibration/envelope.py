"""Envelope spectrum of an acceleration record, and the lines that damage to a bearing leaves in it.

The envelope of a band around a resonance repeats at the rate at which damage is rolled over (Randall and Antoni,
Rolling element bearing diagnostics, Mechanical Systems and Signal Processing 25, 2011). Frequencies are searched in
orders, multiples of the shaft's speed, around those of kinematics: the cage is slower (slip) or faster (contact angle).
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import fft, ndimage

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.vibration import rolling_frequencies

HARMONICS = (1, 2, 3)
OCTAVES = 4
TOP = 0.95  # of the Nyquist frequency, where the highest octave ends: above it converters filter
SLOWER = 0.02  # of the cage, against kinematics at the nominal contact angle  # tuned: slip
FASTER = 0.016  # tuned: contact angle, 0.6 % of BPFO in print, and pitch circles that differ from the catalogue's
SPEED_ERROR = 0.02  # of a given speed, within which the shaft's line is looked for  # tuned: slip of induction motors
LEAST_SAMPLES = 16
LEAST_TURNS = 20  # of the shaft in a record
LENGTH = 256  # turns in a stretch of which a spectrum is made  # tuned: fine lines against slip, which smears them
LEAST_VERDICT_LEVEL = 16.0  # dB, mean of three harmonics over the median around them  # tuned: noise alone reaches 9
LEAST_LEAD = 6.0  # dB, of the verdict's family over the next  # tuned: a family's harmonics come near another's
LEAST_LINE = 10.0  # dB, of a line that is there  # tuned: above the greatest of some fifty bins of noise
LEAST_NOISE = 1e-4  # of a record's RMS: lines of less are aliases that its filter lets through
LARGEST_CLIPPED = 2e-4  # share of samples at a limit of the converter


class Family(NamedTuple):
    """Lines of one sort of damage: the part, order of the first line, order of its sidebands, where it may lie."""

    name: str
    part: str
    order: float
    sideband: str
    sideband_order: float
    slower: float
    faster: float


class Line(NamedTuple):
    """A line of the envelope spectrum: expected and found frequency [Hz], relative offset, amplitude [m/s^2], level.

    `same_as` names the line of the verdict's family at the found frequency, where another family's was searched.
    """

    name: str
    expected_hz: float
    found_hz: float
    off: float
    amplitude: float
    over_noise_db: float
    same_as: str = ""


@dataclass(frozen=True)
class Spectrum:
    """Envelope spectrum of a record: `orders` (of the shaft), `amplitude` [m/s^2] and `level` [dB over the median].

    `verdict` is outer, inner, ball or NOTHING; `level_db` the mean level of the first three lines of each family, which
    the verdict rests on; `by_order` is True where the envelope was resampled by the shaft's angle.
    """

    verdict: str
    shaft_hz: float
    by_order: bool
    band_hz: tuple[float, float]
    lines: tuple[Line, ...]
    level_db: dict[str, float]
    rms: float
    kurtosis: float
    seconds: float
    warnings: tuple[str, ...]
    orders: np.ndarray
    amplitude: np.ndarray
    level: np.ndarray

    def as_dict(self) -> dict:
        """The result as plain data."""
        plain = ("verdict", "shaft_hz", "by_order", "band_hz", "level_db", "rms", "kurtosis", "seconds")
        data = {name: getattr(self, name) for name in plain}
        data["shaft_rpm"] = 60.0 * self.shaft_hz
        return data | {"lines": [line._asdict() for line in self.lines]}


NOTHING = "nothing stands out"
DAMAGE = {"outer": "damage on the outer raceway", "inner": "damage on the inner raceway", "ball": "damage on a ball"}


def families_of(geometry) -> tuple[Family, ...]:
    """The four families of a ball set, in orders of the inner ring, the outer being at rest."""
    turn = rolling_frequencies(geometry, 2.0 * math.pi)
    cage = turn["ftf"]
    inner = cage / (1.0 - cage)  # the inner ring passes the balls as much slower as the cage turns faster
    return (
        Family("BPFO", "outer", turn["bpfo"], "fs", 1.0, SLOWER, FASTER),
        Family("BPFI", "inner", turn["bpfi"], "fs", 1.0, FASTER * inner, SLOWER * inner),
        Family("2BSF", "ball", 2.0 * turn["ball_spin"], "FTF", cage, FASTER, 2.0 * FASTER),
        Family("FTF", "cage", cage, "", 0.0, SLOWER, FASTER),
    )


def checked(samples, rate: float) -> tuple[np.ndarray, tuple[str, ...]]:
    """The samples as float32 without their mean, and warnings; raises BearingTwinError for an unusable record."""
    samples = np.asarray(samples)
    if samples.ndim != 1 or samples.dtype.kind not in "fiu" or len(samples) < LEAST_SAMPLES:
        raise BearingTwinError(f"the record must be one row of at least {LEAST_SAMPLES} numbers; choose it by --key")
    if not 0.0 < rate < math.inf:
        raise BearingTwinError(f"the sampling rate {rate:g} Hz must be above zero; give it by --rate")
    mean = samples.mean(dtype=float)
    if not math.isfinite(mean):
        bad = np.flatnonzero(~np.isfinite(samples))
        raise BearingTwinError(
            f"{len(bad)} samples are not finite, the first at {bad[0] / rate:.6g} s; cut the record there"
        )
    least, greatest = samples.min(), samples.max()
    reach = float(greatest) - float(least)
    if not reach > 1e-9 * abs(mean):
        raise BearingTwinError("the record is constant: the sensor was not connected, or this is another channel")
    clipped = 0
    for limit, near in ((least, samples < least + 0.01 * reach), (greatest, samples > greatest - 0.01 * reach)):
        at_limit = np.count_nonzero(samples == limit)
        if at_limit >= 10 and at_limit > 2 * (np.count_nonzero(near) - at_limit):  # as many as nowhere else
            clipped += at_limit
    if clipped > LARGEST_CLIPPED * len(samples):
        raise BearingTwinError(
            f"the record is clipped: {clipped} samples stand at its limits of {float(least):.4g} and "
            f"{float(greatest):.4g}; measure again with a wider range"
        )
    warnings = (f"{clipped} samples are clipped",) if clipped else ()
    return np.subtract(samples, mean, dtype=np.float32, casting="unsafe"), warnings


class _Bands:
    """The Fourier transform of a record, and the envelopes of its bands."""

    def __init__(self, samples: np.ndarray, rate: float):
        self.length, self.rate = fft.next_fast_len(len(samples), real=True), rate
        self.transform, self.step = fft.rfft(samples, self.length), rate / self.length
        self.seconds = len(samples) / rate

    def envelope(self, low: float, high: float) -> tuple[np.ndarray, float]:
        """Envelope of the band from `low` to `high` [Hz], without the transform's zeros at the end, and its rate."""
        first, last = round(low / self.step), round(high / self.step)
        count = fft.next_fast_len(2 * (last - first))  # twice the band, so that the modulus is not folded
        inside = np.zeros(count, self.transform.dtype)
        inside[: last - first] = self.transform[first:last]
        rate = count * self.step
        signal = fft.ifft(inside, overwrite_x=True)[: int(self.seconds * rate)]
        return np.abs(signal) * np.float32(2.0 * count / self.length), rate

    def below(self, high: float) -> tuple[np.ndarray, float]:
        """The record itself below `high` [Hz], and the lower rate at which it is then sampled."""
        last = min(round(high / self.step), len(self.transform) - 1)
        count = fft.next_fast_len(2 * last, real=True)
        signal = fft.irfft(self.transform[:last], count)
        rate = count * self.step
        return signal[: int(self.seconds * rate)] * np.float32(count / self.length), rate


def kurtosis_of(values: np.ndarray) -> float:
    """Fourth central moment over the square of the second: 3 of Gaussian noise."""
    square = np.square(values - values.mean())
    return float(np.mean(np.square(square), dtype=float) / np.mean(square, dtype=float) ** 2)


def _default_bands(bands: _Bands, least: float) -> list[tuple[float, float]]:
    """Bands to examine: of four octaves below the Nyquist frequency that of the greatest kurtosis, then the upper two.

    Octaves less than `least` [Hz] wide do not count.
    """
    high, candidates = TOP * 0.5 * bands.rate, []
    for octave in range(OCTAVES):
        ends = high / 2 ** (octave + 1), high / 2**octave
        if ends[1] - ends[0] >= least:
            square = np.square(bands.envelope(*ends)[0])
            candidates.append(
                (float(np.mean(np.square(square), dtype=float) / np.mean(square, dtype=float) ** 2), ends)
            )
    if not candidates:
        raise BearingTwinError(
            f"the sampling rate of {bands.rate:g} Hz is too low for this bearing at this speed; sample with at least "
            f"{math.ceil(4.0 * least / TOP):d} Hz"
        )
    return [max(candidates)[1], (0.25 * high, high)]


class _Lines:
    """Amplitude spectrum over orders of `values`, with `rate` values a turn of the shaft, and its level over noise.

    The noise has an amplitude of at least `noise`.
    """

    def __init__(self, values: np.ndarray, rate: float, highest: float, noise: float, turns: int = LENGTH):
        length = min(len(values), round(turns * rate))
        window = np.hanning(length + 1)[:-1].astype(np.float32)
        padded, starts = fft.next_fast_len(2 * length, real=True), range(0, len(values) - length + 1, length // 2)
        self.step = rate / padded
        self.count = min(int(highest / self.step), padded // 2) + 1
        power = np.zeros(self.count)
        for start in starts:
            part = values[start : start + length]
            power += np.abs(fft.rfft((part - part.mean()) * window, padded)[: self.count]) ** 2
        self.amplitude = np.sqrt(power / len(starts)) * 2.0 / window.sum()
        self.orders = self.step * np.arange(self.count)
        around = ndimage.median_filter(self.amplitude, max(3, round(1.0 / self.step) | 1), mode="reflect")
        self.level = 20.0 * np.log10(np.maximum(self.amplitude, 1e-300) / np.maximum(around, noise))
        self.width = 2.0 * rate / length  # to the first zero of a line
        self.without_shaft = self.level.copy()  # without the shaft's own lines
        self.without_shaft[np.abs(self.orders - np.rint(self.orders)) < self.width] = 0.0
        around = ndimage.maximum_filter1d(self.level, 2 * round(0.5 * self.width / self.step) + 1)
        self.tops = np.where(
            self.level == around, self.level, 0.0
        )  # no flanks, on which a line is at a wrong frequency

    def comb(self, orders: np.ndarray, harmonics=HARMONICS, exclude_shaft: bool = True) -> np.ndarray:
        """Levels [dB] (harmonic, order) of the harmonics of these orders."""
        level = ndimage.maximum_filter1d(self.without_shaft if exclude_shaft else self.tops, 3)
        bins = np.rint(np.outer(harmonics, orders) / self.step).astype(int)
        return level[np.minimum(bins, self.count - 1)]

    def peak(self, order: float) -> tuple[float, float, float]:
        """Order, amplitude and level of the top next to `order`, between bins by a parabola."""
        middle = round(order / self.step)
        first = min(max(middle - 2, 1), self.count - 2)
        top = first + int(np.argmax(self.amplitude[first : max(first + 1, min(middle + 3, self.count - 1))]))
        a, b, c = np.log(np.maximum(self.amplitude[top - 1 : top + 2], 1e-300))
        bend = a - 2.0 * b + c
        shift = float(np.clip(0.5 * (a - c) / bend, -0.5, 0.5)) if bend < 0.0 else 0.0
        return (top + shift) * self.step, float(self.amplitude[top]), float(self.level[top])


def _strongest_order(
    lines: _Lines, order: float, slower: float, faster: float, harmonics=HARMONICS, exclude_shaft: bool = True
):
    """The order near `order` whose harmonics stand out most, with their levels [dB]."""
    reach = order * (slower + faster)
    candidates = np.linspace(
        order * (1.0 - slower), order * (1.0 + faster), 2 + int(4 * max(harmonics) * reach / lines.step)
    )
    levels = lines.comb(candidates, harmonics, exclude_shaft)
    mean = np.mean(np.maximum(levels, 0.0), axis=0)
    flat = np.flatnonzero(mean > mean.max() - 1e-9)
    best = flat[len(flat) // 2]
    return float(candidates[best]), levels[:, best], float(mean[best])


SHAFT_HARMONICS = (1, 2, 3, 4)


def _shaft_order(lines: _Lines, reach: float):
    """The order of the shaft, at most `reach` from 1, with the levels [dB] of its harmonics and their mean."""
    return _strongest_order(lines, 1.0, reach, reach, SHAFT_HARMONICS, exclude_shaft=False)


def _are_of_shaft(levels) -> bool:
    """True if lines at these levels [dB] are the shaft's: the first and another; near 3 and 4 orders are raceways'."""
    return bool(levels[0] > LEAST_LINE and np.sum(levels > LEAST_LINE) >= 2)


def _refined(signals, shaft: float, noise: float) -> float:
    """Speed of the shaft [Hz] by its lines in the record or in its envelope; as given where there are none."""
    estimates = []
    for values, rate in signals:
        lines = _Lines(values, rate / shaft, 4.5, noise, turns=4 * LENGTH)
        order, levels, mean = _shaft_order(lines, SPEED_ERROR)
        if _are_of_shaft(levels) and mean > LEAST_LINE:
            orders = np.array([lines.peak(k * order)[0] / k for k in SHAFT_HARMONICS if levels[k - 1] > LEAST_LINE])
            estimates.append((mean, float(orders[np.abs(orders - orders[0]) < 0.7 * lines.step][-1])))
    return shaft * max(estimates, default=(0.0, 1.0))[1]


WINDOW, GREATEST_CHANGE = 24, 0.1  # turns of a window in which speed is measured; change of speed that is followed


def _tracked(signals, shaft: float, seconds: float, noise: float) -> tuple[np.ndarray, np.ndarray] | None:
    """Times [s] and speeds [Hz] of a shaft whose lines are followed from window to window; None where they are lost."""
    length = WINDOW / shaft
    times = np.arange(0.5 * length, seconds - 0.5 * length, 0.25 * length)
    speeds = []
    for time in times:
        best = (0.0, math.nan)
        for values, rate in signals:
            part = values[int((time - 0.5 * length) * rate) : int((time + 0.5 * length) * rate)]
            lines = _Lines(np.pad(part - part.mean(), (0, 3 * len(part))), rate / shaft, 4.5, noise, turns=4 * WINDOW)
            order, _, mean = _shaft_order(lines, GREATEST_CHANGE)
            best = max(best, (mean, order))
        speeds.append(best[1] * shaft)
    if len(times) < 5 or not np.all(np.isfinite(speeds)):
        return None
    smooth = ndimage.median_filter(np.array(speeds), 5, mode="nearest")
    deviation = np.abs(np.array(speeds) / smooth - 1.0)
    if np.mean(deviation < 0.01) < 0.8:
        return None
    return times, ndimage.gaussian_filter1d(smooth, 1.0, mode="nearest")


def _resampled_by_angle(values: np.ndarray, rate: float, times, speeds) -> tuple[np.ndarray, float]:
    """Values at equal angles of the shaft, and how many there are a turn; speeds [Hz] are linear between `times`."""
    instants = np.arange(len(values)) / rate
    turns = np.cumsum(np.interp(instants, times, speeds)) / rate
    turns -= turns[0]
    per_turn = math.ceil(rate / np.min(speeds))
    even = np.arange(int(turns[-1] * per_turn)) / per_turn
    return np.interp(even, turns, values).astype(np.float32), float(per_turn)


def spectrum_of(samples, rate: float, geometry, speed, band: tuple[float, float] | None = None) -> Spectrum:
    """Envelope spectrum of an acceleration record, the lines of damage in it and a verdict.

    Parameters
    ----------
    samples : array (N,)
        Acceleration [m/s^2], or in any unit, which the amplitudes then have.
    rate : float
        Samples a second [Hz].
    geometry
        `geometry` of a bearing scene: ball set and contact angle.
    speed : float or (times, speeds)
        Of the shaft [rad/s]; a number is refined on the shaft's line, a course over time [s] is taken as it is.
    band : (float, float), optional
        Band [Hz] whose envelope is taken; default: of four octaves that of the greatest kurtosis, and the upper two
        where nothing stands out in that.

    Raises
    ------
    BearingTwinError
        For an unusable record or band, with a sentence that says what to do.
    """
    samples, warnings = checked(samples, rate)
    course = None
    if not np.isscalar(speed):
        times, speeds = np.asarray(speed[0], float), np.abs(np.asarray(speed[1], float)) / (2.0 * math.pi)
        shaft = float(np.mean(speeds))
        course = (times, speeds) if np.ptp(speeds) > 1e-4 * shaft else None
    else:
        shaft = abs(float(speed)) / (2.0 * math.pi)
    seconds = len(samples) / rate
    if not 0.0 < shaft < math.inf:
        raise BearingTwinError("the speed of the shaft must be above zero; give it by --speed, as 1750rpm")
    if seconds * shaft < LEAST_TURNS:
        raise BearingTwinError(
            f"the record of {seconds:.4g} s has {seconds * shaft:.1f} turns of the shaft; give at least {LEAST_TURNS}"
        )
    families = families_of(geometry)
    highest = 1.05 * max(HARMONICS) * max(family.order for family in families) + 1.0
    bands = _Bands(samples, rate)
    rms = float(np.sqrt(np.mean(np.square(samples), dtype=float)))
    noise = LEAST_NOISE * rms
    fastest = shaft if course is None else float(np.max(course[1]))
    if band is None:
        candidates = _default_bands(bands, highest * fastest)
    elif not (0.0 <= band[0] < band[1] <= 0.5 * rate and band[1] - band[0] >= highest * fastest):
        raise BearingTwinError(
            f"the band from {band[0]:g} to {band[1]:g} Hz must lie below {0.5 * rate:g} Hz and be at least "
            f"{highest * fastest:.0f} Hz wide for this bearing at this speed"
        )
    else:
        candidates = [band]
    chosen = None
    for band in candidates:
        envelope, envelope_rate = bands.envelope(*band)
        if np.isscalar(speed) and chosen is None:
            shaft, course = _speed(bands, (envelope, envelope_rate), shaft, noise)
        values, per_turn = envelope, envelope_rate / shaft
        if course is not None:
            values, per_turn = _resampled_by_angle(envelope, envelope_rate, *course)
        lines = _Lines(values, per_turn, highest, noise)
        judged = _verdict(lines, families, shaft)
        if chosen is None or judged[0] != NOTHING:
            chosen = band, lines, *judged
        if judged[0] != NOTHING:
            break
    band, lines, verdict, scores, shown = chosen
    return Spectrum(
        verdict=verdict,
        shaft_hz=shaft,
        by_order=course is not None,
        band_hz=(float(band[0]), float(band[1])),
        lines=shown,
        level_db=scores,
        rms=rms,
        kurtosis=kurtosis_of(samples),
        seconds=seconds,
        warnings=warnings,
        orders=lines.orders,
        amplitude=lines.amplitude,
        level=lines.level,
    )


def _speed(bands: _Bands, envelope, shaft: float, noise: float):
    """Mean speed [Hz] of the shaft by its line, and its course where that makes the line stand out more."""
    signals = (bands.below(12.0 * shaft), envelope)
    refined = _refined(signals, shaft, noise)
    course = _tracked(signals, refined, bands.seconds, noise)
    if course is None or np.ptp(course[1]) < 2e-3 * refined:
        return refined, None

    def sharpest(resampled):
        lines = (_Lines(values, rate, 4.5, noise) for values, rate in resampled)
        return max((_shaft_order(row, SPEED_ERROR) for row in lines), key=lambda strongest: strongest[2])

    steady = sharpest((values, rate / refined) for values, rate in signals)
    followed = sharpest(_resampled_by_angle(values, rate, *course) for values, rate in signals)
    if not _are_of_shaft(followed[1]) or followed[2] < steady[2] + 3.0:
        return refined, None
    instants = np.linspace(0.0, bands.seconds, 1000)
    return float(np.mean(np.interp(instants, *course))), course


def _line_name(family: Family, multiple: int, side: int) -> str:
    name = (f"{multiple}x" if multiple > 1 else "") + family.name
    return name + (f"{'-+'[side > 0]}{family.sideband}" if side else "")


def _line_at(order: float, family: Family, first: float, width: float) -> str:
    """Name of the line of a family with its `first` at this order that is within `width` of `order`; "" for none."""
    for side in (0, -1, 1):
        shift = side * family.sideband_order
        multiple = round((order - shift) / first)
        if multiple > 0 and abs(multiple * first + shift - order) < width:
            return _line_name(family, multiple, side)
    return ""


def _verdict(lines: _Lines, families, shaft: float) -> tuple[str, dict[str, float], tuple[Line, ...]]:
    """Verdict, the mean level [dB] of each family's harmonics, and all lines."""
    lines_found, scores, has_lines, orders = [], {}, {}, {}
    for family in families:
        order, levels, scores[family.name] = _strongest_order(lines, family.order, family.slower, family.faster)
        has_lines[family.name], orders[family.name] = np.sum(levels > LEAST_LINE) >= 2, order
        sides = []
        for harmonic in HARMONICS:
            multiples = [(harmonic, 0)]
            multiples += [(harmonic, side) for side in (-1, 1)] if family.sideband else []
            for multiple, side in multiples:
                name = _line_name(family, multiple, side)
                expected = multiple * family.order + side * family.sideband_order
                found_order, amplitude, level = lines.peak(multiple * order + side * family.sideband_order)
                lines_found.append(
                    Line(name, expected * shaft, found_order * shaft, found_order / expected - 1.0, amplitude, level)
                )
                sides += [level] if side and multiple == 1 else []
        if family.part == "ball":  # its lines come with those of the cage, which carries it through the load
            has_lines[family.name] &= bool(np.mean(sides) > LEAST_LINE)
    parts = {family.name: family.part for family in families}
    first = max((name for name in parts if parts[name] != "cage"), key=scores.get)
    rivals = [name for name in parts if name != first and not (parts[first] == "ball" and parts[name] == "cage")]
    stands_out = (
        scores[first] >= max(LEAST_VERDICT_LEVEL, *(scores[name] + LEAST_LEAD for name in rivals)) and has_lines[first]
    )
    if not stands_out:
        return NOTHING, scores, tuple(lines_found)
    damaged = next(family for family in families if family.name == first)
    for i, line in enumerate(lines_found):
        if first not in line.name:
            same = _line_at(line.found_hz / shaft, damaged, orders[first], 0.5 * lines.width)
            lines_found[i] = line._replace(same_as=same)
    return parts[first], scores, tuple(lines_found)


def draw_spectrum(spectrum: Spectrum, name: str, path):
    """Draws amplitude and level over frequency, the harmonics of each family dashed where they were found."""
    from bearing_twin.pictures import BALL_COLOURS, STYLE, Axis, Line, Panel, Sheet, figure_of, save

    colours = {"BPFO": BALL_COLOURS[5], "BPFI": BALL_COLOURS[0], "2BSF": BALL_COLOURS[2], "FTF": BALL_COLOURS[3]}
    lines = {line.name: line for line in spectrum.lines}
    shown = spectrum.orders > 0.3
    hertz = spectrum.shaft_hz * spectrum.orders[shown]
    rows = []
    for values, title, label, unit in (
        (spectrum.amplitude[shown], "Amplitude of the envelope", "amplitude", "m/s²"),
        (spectrum.level[shown], "Level over the median around each frequency", "level", "dB"),
    ):
        top, parts = 1.05 * float(np.max(values)), []
        for family, colour in colours.items():
            style = {"color": colour, "linestyle": "--", "linewidth": 1.4, "alpha": 0.8}
            for harmonic in HARMONICS:
                found = lines[f"{harmonic}x{family}" if harmonic > 1 else family].found_hz
                parts.append(Line(family, [found] * 2, [0.0, top], style, harmonic == 1))
        parts.append(Line("", hertz, values, {"color": STYLE["ink"], "linewidth": 0.8}, False))
        across, up = Axis("frequency", "Hz", limits=(0.0, hertz[-1])), Axis(label, unit, limits=(0.0, top))
        rows.append([Panel(title, across, up, parts)])
    low, high = (round(edge) for edge in spectrum.band_hz)
    footer = f"shaft {spectrum.shaft_hz:.4g} Hz; band {low} to {high} Hz; {spectrum.seconds:.4g} s"
    verdict = DAMAGE.get(spectrum.verdict, spectrum.verdict)
    return save(figure_of(Sheet(f"{name}: {verdict}", rows, footer, [], shared_legend=True)), path)
