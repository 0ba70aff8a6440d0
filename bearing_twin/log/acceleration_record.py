"""Records of acceleration from files: logs of ours, other MCAP logs and bags, tables (.csv) and arrays (.npz, .mat)."""

import csv
import io
import math
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import BearingTwinError, LogError, echo, legal_hint
from bearing_twin.log import cdr
from bearing_twin.log.bag import SQLITE, SUFFIX, LogReader
from bearing_twin.log.run_log import read_log
from bearing_twin.log.stream import checked_waveform

TIMES = {"time_ns": 1e-9, "time": 1.0, "t": 1.0, "time_s": 1.0, "seconds": 1.0}
TIME_UNIT = re.compile(r"[\[(]\s*(s|sec|ms|us|µs|ns)\s*[\])]\s*$")  # at the end of a column's name, in any language
SECONDS = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9}
COUNTERS = ("sequence",)
RATES = ("rate", "sampling_rate", "sample_rate", "fs")
RATE_ERROR = 0.01  # of a rate that is given besides times
LEAST_SAMPLES = 16
MOST_NAMED = 12
ACCELERATION = "acceleration"


class Record(NamedTuple):
    """Samples, samples a second [Hz]; where the file has them speed [rad/s] over time [s], `geometry` of a scene.

    `notes` name parts of a log that were not read.
    """

    samples: np.ndarray
    rate: float
    speed: float | tuple[np.ndarray, np.ndarray] | None = None
    geometry: object | None = None
    notes: tuple[str, ...] = ()


def read_record(
    path, key: str | None = None, rate: float | None = None, topic: str | None = None, run: int | None = None
) -> Record:
    """The record in a file; `key` names a column, variable, channel or field where there are several.

    Of the recording of a node that was reset `run` selects one run, 1 being the first; None is the last.

    Raises BearingTwinError where the file cannot be read, has gaps, or lacks the requested data.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if not path.exists() or not (path.is_dir() or suffix in (SUFFIX, SQLITE, *_TABLES)):
        wrong = "is of no known kind" if path.exists() else "does not exist"
        raise BearingTwinError(f"{path} {wrong}; give a log (.mcap or a bag), .csv, .npz or .mat")
    if suffix not in _TABLES or path.is_dir():
        return _record_of_topic(path, key, rate, topic, run)
    if topic is not None or run is not None:
        option = "--run" if topic is None else "--topic"
        raise BearingTwinError(f"{option} is of logs; name a column or variable by --key")
    try:
        columns = _TABLES[suffix](path)
    except Exception as error:  # of archives, compression and headers that NumPy and SciPy read
        reason = " ".join(str(error).split())[:120]
        raise BearingTwinError(f"{path} cannot be read as {suffix[1:]} ({reason}); save it again") from error
    return _record_of_columns(path, columns, key, rate)


def _csv_columns(path: Path) -> dict[str, np.ndarray]:
    """Columns by name, or by number from 1 where there is no header."""
    with open(path, encoding="utf-8") as file:
        first = file.readline(100_000)
    delimiter = next((character for character in ";\t," if character in first), None)
    cells = next(csv.reader([first], delimiter=delimiter)) if delimiter else first.split()
    source = path
    if delimiter == ";":  # where a comma is the sign of decimals
        source = io.StringIO(path.read_text(encoding="utf-8").replace(",", "."))
    headed = re.search(r"[a-df-zA-DF-Z]", first.lower().replace("nan", "")) is not None  # numbers contain e
    table = np.loadtxt(source, delimiter=delimiter, skiprows=int(headed), ndmin=2, comments=None if headed else "#")
    names = [cell.strip() for cell in cells] if headed else [str(number + 1) for number in range(table.shape[1])]
    return dict(zip(names, table.T, strict=True))


def _npz_columns(path: Path) -> dict[str, np.ndarray]:
    with np.load(path, allow_pickle=False) as arrays:
        return {name: arrays[name] for name in arrays.files}


def _mat_columns(path: Path) -> dict[str, np.ndarray]:
    from scipy.io import loadmat

    return {name: value for name, value in loadmat(path).items() if isinstance(value, np.ndarray)}


_TABLES = {".csv": _csv_columns, ".txt": _csv_columns, ".npz": _npz_columns, ".mat": _mat_columns}


def _record_of_columns(path: Path, columns: dict[str, np.ndarray], key: str | None, rate: float | None) -> Record:
    """The record among columns, with the rate of a column of times, or that of a single number."""
    numbers = {name: np.ravel(column) for name, column in columns.items() if column.dtype.kind in "fiu"}
    times = {name: column for name, column in numbers.items() if _time_factor(name)}
    names = [name for name, column in numbers.items() if len(column) >= LEAST_SAMPLES and name not in times]
    samples = numbers[_selected_name(path, key, [name for name in names if name.lower() not in COUNTERS])]
    singles = {name.lower(): float(column[0]) for name, column in numbers.items() if len(column) == 1}
    if clock := next((name for name in times if len(times[name]) == len(samples)), None):
        measured = _even_rate(times[clock] * _time_factor(clock))
        if rate is not None and abs(rate / measured - 1.0) > RATE_ERROR:
            raise BearingTwinError(f"the times in {path} say {measured:.6g} Hz, not {rate:g} Hz; leave out --rate")
        rate = rate or measured
    rate = rate or next((singles[name] for name in RATES if name in singles), None)
    rpm = next((value for name, value in singles.items() if name.endswith("rpm")), None)
    return Record(samples, _required_rate(rate, path), None if rpm is None else rpm * math.pi / 30.0)


def _required_rate(rate: float | None, source) -> float:
    if rate is None:
        raise BearingTwinError(f"{source} does not say at which rate it was sampled; give it by --rate, as 12kHz")
    return rate


def _time_factor(name: str) -> float | None:
    """Factor into seconds of a column of times, such as `time`, `Time [ms]`, `Zeit (s)`; None for other columns."""
    unit = TIME_UNIT.search(name.lower())
    return SECONDS[unit[1]] if unit else TIMES.get(name.lower())


def _selected_name(path: Path, key: str | None, names: list[str]) -> str:
    """The row with the name `key`, or whose name ends with it; without, the only row or that of the acceleration."""
    if not names:
        raise BearingTwinError(f"{path} holds no row of numbers that could be a record")
    if key is None:
        matches = names if len(names) == 1 else [name for name in names if name.lower() == ACCELERATION]
    else:
        matches = [name for name in names if name == key] or [name for name in names if name.endswith(key)]
    if len(matches) == 1:
        return matches[0]
    listed = ", ".join(map(echo, names[:MOST_NAMED])) + (" ..." if len(names) > MOST_NAMED else "")
    problem = "holds several rows" if key is None else f"has {'no' if not matches else 'several'} {echo(key)}"
    raise BearingTwinError(f"{path} {problem}; give one of these by --key: {listed}")


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


def _record_of_topic(path: Path, key: str | None, rate: float | None, topic: str | None, run: int | None) -> Record:
    """The record on a topic of any log; without a topic that of a log of ours."""
    reader = LogReader(path, unfinished=True)
    readable = [channel for channel in reader.topics if not channel.foreign and cdr.is_known(channel.ros_type)]
    types = {channel.name: channel.ros_type for channel in readable}
    if topic is None or types.get(topic) == cdr.SAMPLE_BLOCK:
        return _record_of_run(path, key, topic, run)
    if topic not in types:
        raise BearingTwinError(f"{path} has no topic {echo(topic)} of a known type; {legal_hint(topic, list(types))}")
    field = key or ("samples" if types[topic] == cdr.WAVEFORM else "data")
    parts, stamps = [], []
    for entry in reader.messages({topic}):
        ros_type = entry.topic.ros_type
        is_waveform = ros_type == cdr.WAVEFORM
        message = checked_waveform(path, entry.data) if is_waveform else cdr.deserialise(ros_type, entry.data)
        parts.append(np.ravel(_numbers_of_field(message, topic, field)).astype(np.float32))
        header = getattr(message, "header", None)
        stamps.append(1e-9 * entry.log_time if header is None else header.stamp.sec + 1e-9 * header.stamp.nanosec)
    lengths = {len(part) for part in parts[:-1]}
    if sum(map(len, parts)) < LEAST_SAMPLES:
        raise BearingTwinError(f"{topic} in {path} holds too few numbers for a record, {sum(map(len, parts))}")
    if len(lengths) == 1 and 0 not in lengths:
        rate = rate or _even_rate(np.array(stamps)) * lengths.pop()
    elif is_waveform:
        rate = rate or message.rate
    rate = _required_rate(rate, f"{topic} in {path}")
    return Record(np.concatenate(parts), rate, notes=tuple(reader.notes))


def _numbers_of_field(message, topic: str, path: str):
    """The numbers of a field of a message, given as a path such as linear_acceleration.z."""
    value = message
    for part in path.split("."):
        if part not in (names := list(getattr(value, "__dataclass_fields__", ()))):
            raise BearingTwinError(
                f"messages on {topic} have no field {echo(part)}; {legal_hint(part, names)}: give --key"
            )
        value = getattr(value, part)
    numbers = np.asarray(value)
    if numbers.dtype.kind not in "fiu":
        raise BearingTwinError(f"the field {path} of {topic} holds no numbers; give another by --key")
    return numbers


def _record_of_run(path: Path, key: str | None, topic: str | None, run: int | None) -> Record:
    """The samples of the sensor of a scene, with the course of the speed."""
    log = read_log(path, True, topic, last_run=True, run=run)
    if all(table.name != ACCELERATION for table in log.tables):
        raise LogError(
            f"{path} holds no {ACCELERATION}: its scene has no `sensor`; add one, or name a topic by --topic"
        )
    if key not in (None, ACCELERATION):
        raise LogError(f"{path} holds the {ACCELERATION} alone, not {echo(key)}; leave out --key")
    samples_of_blocks, moments, speeds = [], [], []
    for block in log.blocks():  # copies, as a view would keep its block
        samples_of_blocks.append(np.copy(block.records.get(ACCELERATION, np.zeros((0, 2)))))
        moments.append(1e-9 * block.time_ns), speeds.append(block.values["inner_ring_speed"].copy())
    times, samples = np.concatenate(samples_of_blocks).T
    if len(times) < LEAST_SAMPLES:
        raise BearingTwinError(f"{path} holds {len(times)} samples, which are no record")
    course = np.concatenate(moments) - times[0], np.concatenate(speeds)
    geometry = log.scene.parameters.geometry
    return Record(samples.astype(np.float32), _even_rate(times), course, geometry, tuple(log.notes))
