"""Records of acceleration from files: logs of ours, other MCAP logs and bags, tables (.csv) and arrays (.npz, .mat)."""

import csv
import io
import math
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import BearingTwinError, LogError, echo, unknown
from bearing_twin.log import cdr
from bearing_twin.log.bag import SQLITE, SUFFIX, LogReader
from bearing_twin.log.run_log import read_log
from bearing_twin.run.dataset import tables_of

TIMES = {"time_ns": 1e-9, "time": 1.0, "t": 1.0, "time_s": 1.0, "seconds": 1.0}
TIME_UNIT = re.compile(r"[\[(]\s*(s|sec|ms|us|µs|ns)\s*[\])]\s*$")  # behind the name of a column, in any language
SECONDS = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9}
COUNTERS = ("sequence",)
RATES = ("rate", "sampling_rate", "sample_rate", "fs")
MOST_NAMED = 12
ACCELERATION = "acceleration"


class Record(NamedTuple):
    """Samples, samples a second [Hz]; where the file has them speed [rad/s] over time [s], `geometry` of a scene."""

    samples: np.ndarray
    rate: float
    speed: float | tuple[np.ndarray, np.ndarray] | None = None
    geometry: object | None = None


def read_record(
    path, key: str | None = None, rate: float | None = None, topic: str | None = None, run: int | None = None
) -> Record:
    """The record in a file; `key` names a column, variable, channel or field where there are several.

    Of the recording of a node that was reset `run` selects one run, 1 being the first; None is the last.

    Raises BearingTwinError where the file cannot be read, has gaps, or does not say what is wanted of it.
    """
    path = Path(path)
    if not path.exists():
        raise BearingTwinError(f"{path} does not exist; give a log (.mcap or a bag), .csv, .npz or .mat")
    suffix = path.suffix.lower()
    if path.is_dir() or suffix in (SUFFIX, SQLITE):
        return _logged(path, key, rate, topic, run)
    if suffix not in _TABLES:
        raise BearingTwinError(f"{path} is of no known kind; give a log (.mcap or a bag), .csv, .npz or .mat")
    if topic is not None or run is not None:
        option = "--run" if topic is None else "--topic"
        raise BearingTwinError(f"{option} is of logs; name a column or variable by --key")
    try:
        columns = _TABLES[suffix](path)
    except (OSError, ValueError, TypeError, KeyError, NotImplementedError, MemoryError, EOFError) as error:
        said = " ".join(str(error).split())[:120]
        raise BearingTwinError(f"{path} cannot be read as {suffix[1:]} ({said}); save it again") from error
    return _record_of(path, columns, key, rate)


def _csv_columns(path: Path) -> dict[str, np.ndarray]:
    """Columns by name, or by number from 1 where there is no header."""
    with open(path, encoding="utf-8", newline="") as file:
        first = file.readline(100_000)
    delimiter = max(",;\t", key=first.count)
    delimiter = delimiter if delimiter in first else None
    words = next(csv.reader([first], delimiter=delimiter)) if delimiter else first.split()
    words = [word.strip() for word in words]
    try:
        [float(word.replace(",", ".")) for word in words]
        header, names = 0, [str(number + 1) for number in range(len(words))]
    except ValueError:
        header, names = 1, words
    source = path
    if delimiter == ";":  # where a comma is the sign of decimals
        source = io.StringIO(path.read_text(encoding="utf-8").replace(",", "."))
    table = np.loadtxt(source, delimiter=delimiter, skiprows=header, ndmin=2, comments="#" if header == 0 else None)
    if table.shape[1] != len(names):
        raise ValueError(f"{len(names)} names for {table.shape[1]} columns")
    return dict(zip(names, table.T, strict=True))


def _npz_columns(path: Path) -> dict[str, np.ndarray]:
    with np.load(path, allow_pickle=False) as arrays:
        return {name: arrays[name] for name in arrays.files}


def _mat_columns(path: Path) -> dict[str, np.ndarray]:
    from scipy.io import loadmat

    return {name: value for name, value in loadmat(path).items() if isinstance(value, np.ndarray)}


_TABLES = {".csv": _csv_columns, ".txt": _csv_columns, ".npz": _npz_columns, ".mat": _mat_columns}


TIMES_OFF = 0.01  # of a rate that is given beside times


def _record_of(path: Path, columns: dict[str, np.ndarray], key: str | None, rate: float | None) -> Record:
    numbers = {name: np.ravel(one) for name, one in columns.items() if one.dtype.kind in "fiu"}
    rows = {name: one for name, one in numbers.items() if len(one) >= 16}
    times = {name: one for name, one in rows.items() if _time_factor(name)}
    name = _named(path, key, [one for one in rows if one not in times and one.lower() not in COUNTERS])
    samples = rows[name]
    if clock := next((one for one in times if len(times[one]) == len(samples)), None):
        seconds = times[clock] * _time_factor(clock)
        span = float(seconds[-1] - seconds[0])
        if rate is None:
            rate = _even_rate(seconds)
        elif span > 0.0 and abs(rate * span / (len(seconds) - 1) - 1.0) > TIMES_OFF:
            told = (len(seconds) - 1) / span
            raise BearingTwinError(f"the times in {path} are those of {told:.6g} Hz, not {rate:g} Hz; leave --rate out")
    if rate is None:
        said = (float(one[0]) for word, one in numbers.items() if word.lower() in RATES and len(one) == 1)
        rate = next(said, None)
    if rate is None:
        raise BearingTwinError(f"{path} does not say at which rate it was sampled; give it by --rate, as 12kHz")
    turns = (float(one[0]) for word, one in numbers.items() if word.lower().endswith("rpm") and len(one) == 1)
    speed = next(turns, None)
    return Record(samples, rate, None if speed is None else speed * math.pi / 30.0)


def _time_factor(name: str) -> float | None:
    """Factor into seconds of a column of times, as `time`, `Time [ms]`, `Zeit (s)`; None where it is none."""
    unit = TIME_UNIT.search(name.lower())
    return SECONDS[unit[1]] if unit else TIMES.get(name.lower())


def _named(path: Path, key: str | None, names: list[str]) -> str:
    """The row that `key` names, whole or by the end of its name; the only one, or that of the acceleration, without."""
    if not names:
        raise BearingTwinError(f"{path} holds no row of numbers that could be a record")
    if key is None:
        found = names if len(names) == 1 else [name for name in names if name.lower() == ACCELERATION]
    else:
        found = [name for name in names if name == key] or [name for name in names if name.endswith(key)]
    if len(found) == 1:
        return found[0]
    listed = ", ".join(map(echo, names[:MOST_NAMED])) + (" ..." if len(names) > MOST_NAMED else "")
    said = "holds several rows" if key is None else f"has {'no' if not found else 'several'} {echo(key)}"
    raise BearingTwinError(f"{path} {said}; give one of these by --key: {listed}")


def _even_rate(times: np.ndarray) -> float:
    """Rate [Hz] of even times [s]; raises BearingTwinError for a gap, or times that do not grow."""
    steps = np.diff(times)
    usual = float(np.median(steps)) if np.all(np.isfinite(steps)) else math.nan
    if not (usual > 0.0 and steps.min() > 0.0):
        raise BearingTwinError("the times of the record do not grow from sample to sample; sort or mend them")
    gap = int(np.argmax(steps))
    if steps[gap] > 1.5 * usual:
        raise BearingTwinError(f"the record has a gap of {steps[gap]:.4g} s at {times[gap]:.6g} s; give a part without")
    return (len(times) - 1) / float(times[-1] - times[0])


def _logged(path: Path, key: str | None, rate: float | None, topic: str | None, run: int | None) -> Record:
    reader = LogReader(path)
    stored = {one.name: one for one in reader.topics if not one.foreign and cdr.is_known(one.ros_type)}
    if topic is None or (topic in stored and stored[topic].ros_type == cdr.SAMPLE_BLOCK):
        return _own_log(path, key, topic, run)
    if topic not in stored:
        raise BearingTwinError(f"{path} has no topic {echo(topic)} of a known type; {unknown(topic, list(stored))}")
    parts, stamps, count = [], [], 0
    waveform = stored[topic].ros_type == cdr.WAVEFORM
    for message in reader.messages({topic}):
        said = cdr.deserialise(message.topic.ros_type, message.data)
        values = np.ravel(_field(said, topic, key or ("samples" if waveform else "data"))).astype(np.float32)
        rate = rate or (said.rate if waveform else None)
        header = getattr(said, "header", None)
        stamp = 1e-9 * message.log_time if header is None else header.stamp.sec + 1e-9 * header.stamp.nanosec
        parts.append(values), stamps.append(stamp)
        count += len(values)
    if count < 16:
        raise BearingTwinError(f"{topic} in {path} holds {count} numbers, which are no record")
    even = [len(part) for part in parts[:-1]]
    if even and min(even) == max(even) and min(even) > 0:
        found = _even_rate(np.array(stamps)) * even[0]
        rate = rate or found
    if rate is None:
        raise BearingTwinError(f"{path} does not say at which rate {topic} was sampled; give it by --rate, as 12kHz")
    return Record(np.concatenate(parts), rate)


def _field(message, topic: str, key: str):
    """The numbers of a message: those of a field given as a path, such as linear_acceleration.z."""
    value = message
    for word in key.split("."):
        if not hasattr(value, "__dataclass_fields__") or word not in value.__dataclass_fields__:
            names = list(getattr(value, "__dataclass_fields__", ()))
            raise BearingTwinError(
                f"messages on {topic} have no field {echo(word)}; {unknown(word, names)}: give --key"
            )
        value = getattr(value, word)
    found = np.asarray(value)
    if found.dtype.kind not in "fiu":
        raise BearingTwinError(f"the field {key} of {topic} holds no numbers; give another by --key")
    return found


def _sensor_record(log) -> Record:
    """The samples of the sensor of a bearing scene, with the course of its speed."""
    samples, sampled, times, speeds = [], [], [], []
    for block in log.blocks():  # copies, as a view would keep its block
        rows = block.records.get(ACCELERATION, np.zeros((0, 2)))
        samples.append(rows[:, 1].astype(np.float32)), sampled.append(rows[:, 0].copy())
        times.append(1e-9 * block.time_ns), speeds.append(block.values["inner_ring_speed"].copy())
    found, at = np.concatenate(samples), np.concatenate(sampled)
    if len(found) < 16:
        raise BearingTwinError(f"{log.path} holds {len(found)} samples of the sensor, which are no record")
    course = np.concatenate(times) - at[0], np.concatenate(speeds)
    return Record(found, _even_rate(at), course, log.scene.parameters.geometry)


def _own_log(path: Path, key: str | None, topic: str | None, run: int | None) -> Record:
    log = read_log(path, topic=topic, last_run=True, run=run)
    if log.kept_rate:
        raise LogError(f"{path} holds {log.kept_rate:g} outputs a second, not all; a node logs all with full:=true")
    if log.scene and key in (None, ACCELERATION) and any(one.name == ACCELERATION for one in tables_of(log.scene)):
        return _sensor_record(log)
    names, place = {}, 0
    for channel in log.channels:
        for number in range(channel.width):
            names[channel.name if channel.width == 1 else f"{channel.name}[{number}]"] = place + number
        place += channel.width
    name = _named(path, key, list(names))
    channel, _, index = name.rstrip("]").partition("[")
    parts, times, speeds = [], [], []
    for block in log.blocks():
        parts.append(np.reshape(block.values[channel], (len(block), -1))[:, int(index or 0)].astype(np.float32))
        times.append(block.time_ns)
        if "inner_ring_speed" in block.values:
            speeds.append(block.values["inner_ring_speed"])
    seconds = 1e-9 * np.concatenate(times)
    geometry = getattr(log.scene.parameters, "geometry", None) if log.scene else None
    speed = (seconds - seconds[0], np.concatenate(speeds)) if speeds else None
    return Record(np.concatenate(parts), _even_rate(seconds), speed, geometry)
