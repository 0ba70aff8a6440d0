"""Studies as MCAP logs: every realisation as a row of `samples`, and the summary as JSON; read back bit for bit.

`/bearing/study/samples` holds SampleBlocks whose rows are realisations, numbered from `first_sequence` on: their time
is that of their arrival, their channels the inputs, the quantities, `status` (0, or 1 + the number of the reason why
it failed), `doubtful` (a bit for each doubt) and the histories. `/bearing/study/realisations` has the same inputs and
quantities as a message each, for programs that plot. `/bearing/study/summary` is one std_msgs/String. The study itself
is in the metadata.
"""

import contextlib
import itertools
import json
import math
import time
from array import array
from collections.abc import Iterator
from os import PathLike
from pathlib import Path

import numpy as np

from bearing_twin.base.errors import LogError, echo, shorten
from bearing_twin.base.report import parse_json
from bearing_twin.base.sample import Channel
from bearing_twin.log import cdr
from bearing_twin.log.bag import LogReader, Qos
from bearing_twin.log.cdr import Encoder, encode
from bearing_twin.log.raw_log import RUN_RECORD, RawLogWriter, Safety
from bearing_twin.log.stream import LARGEST_BLOCK, checked_block, samples_message
from bearing_twin.run.scene import upgrade_scene
from bearing_twin.uq.inputs import numeric_keys
from bearing_twin.uq.result import StudyResult
from bearing_twin.uq.study import REMOVED_KEYS, Study, parse_study

NAMESPACE = "/bearing"
SAMPLES_TOPIC, SUMMARY_TOPIC = f"{NAMESPACE}/study/samples", f"{NAMESPACE}/study/summary"
REALISATIONS_TOPIC = f"{NAMESPACE}/study/realisations"
WORK = ("workers", "executor", "memory")  # keys of a study that do not change its numbers
STUDY_RECORD = "bearing_twin_study"
INPUT, QUANTITY, HISTORY, STATUS, DOUBTFUL = "input ", "quantity ", "history ", "status", "doubtful"


class StudyLog:
    """A new log of a study, filled while it runs; use as a context manager. Raises LogError if `path` exists.

    Realisations are on disk at most `max_loss` [s] after they were added; 0 = as chunks become full. While the disk is
    full it keeps what fits into memory, and raises LogError at its end where it is still full. A log without its end is
    read with `unfinished`, after `recover` where its file is damaged. `run_record` False omits date, host, seconds and
    workers, and the n-th realisation arrives at n ms: equal studies then give equal bytes.
    """

    def __init__(self, study: Study, path, run_record: bool = True, max_loss: float = 1.0):
        self._study, self._written, self._described = study, 0, {}
        self._encoder, self._arrived = Encoder(cdr.REALISATION, ""), time.time_ns()
        self._plain = study.resolved()
        self._work = {key: self._plain.pop(key) for key in WORK}
        self._channels = _channels(study)
        self._dated = run_record
        self._log = RawLogWriter(path, run_record, Safety(max_loss, patient=max_loss > 0.0))
        latched = Qos(depth=1, durability="transient_local")
        self._topics = {}
        for name, ros_type, qos in (
            (SAMPLES_TOPIC, cdr.SAMPLE_BLOCK, Qos()),
            (REALISATIONS_TOPIC, cdr.REALISATION, Qos()),
            (SUMMARY_TOPIC, cdr.STRING, latched),
        ):
            self._topics[name] = self._log.add_topic(name, ros_type, qos=(qos,))

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self._log.__exit__(*exception)

    @property
    def written(self) -> int:
        """Number of realisations in it."""
        return self._written

    def add(self, values, quantities, histories, status, doubtful, reasons, warnings) -> None:
        """The next realisations, as columns of a `StudyResult`, and the sentences known so far."""
        self._describe(reasons, warnings)
        if not len(status):
            return
        flat = histories.reshape(len(status), -1)
        table = np.hstack((values, quantities, status[:, None], doubtful[:, None], flat))
        rows = max(1, LARGEST_BLOCK // (8 * sum(channel.width for channel in self._channels)))
        for low in range(0, len(table), rows):
            part = table[low : low + rows]
            first = self._written
            self._written += len(part)
            arrival = self._arrivals(len(part))
            self._add_realisations(first, arrival, part)
            message = samples_message(self._channels, first, arrival, part)
            self._log.write(self._topics[SAMPLES_TOPIC], int(arrival[-1]), int(arrival[-1]), message)

    def _add_realisations(self, first: int, arrival: np.ndarray, part: np.ndarray) -> None:
        """The inputs and quantities of these realisations, a message each."""
        shown = [channel for channel in self._channels if channel.name.startswith((INPUT, QUANTITY))]
        status, doubtful = part[:, len(shown)], part[:, len(shown) + 1]
        fields = {
            "number": np.arange(first, first + len(part)),
            "failed": status > 0.0,
            "doubtful": doubtful > 0.0,
            "name": [channel.name for channel in shown],
            "unit": [channel.unit for channel in shown],
            "value": np.ascontiguousarray(part[:, : len(shown)]),
        }
        for moment, message in zip(arrival.tolist(), self._encoder.encode(fields, arrival), strict=True):
            self._log.write(self._topics[REALISATIONS_TOPIC], moment, moment, message)

    def finish(self, result: StudyResult) -> None:
        """Adds the realisations of the result that are missing, and its summary."""
        added = slice(self._written, None)
        columns = result.values, result.quantities, result.histories, result.status, result.doubtful
        self.add(*(column[added] for column in columns), result.reasons, result.doubts_met)
        self._describe(result.reasons, result.doubts_met, samples=len(result.status))
        summary = result.as_dict()
        work = {"seconds": summary.pop("seconds"), **self._work}
        text = encode(cdr.STRING, {"data": json.dumps(summary)}, 0, "")
        now = self._now()
        self._log.write(self._topics[SUMMARY_TOPIC], now, now, text)
        self._log.note_run(work=json.dumps(work))

    def _now(self) -> int:
        """The time of arrival [ns] of the next realisations."""
        return max(self._arrived, time.time_ns()) if self._dated else 1_000_000 * self._written

    def _arrivals(self, count: int) -> np.ndarray:
        """Times of arrival [ns] (count,) of the realisations just written.

        As many arrive at once, they are spread over the time since the previous ones, so that each has its own time.
        """
        before = self._arrived if self._dated else 1_000_000 * (self._written - count)
        self._arrived = now = max(self._now(), before + count)
        return before + (now - before) * np.arange(1, count + 1) // count

    def _describe(self, reasons, warnings, **counts) -> None:
        """Writes the study, its reasons and warnings if they have changed; the last record counts."""
        record = {
            "study": json.dumps(self._plain),
            "reasons": json.dumps(list(reasons)),
            "doubts": json.dumps(list(warnings)),
            **counts,
        }
        if record != self._described:
            self._described = record
            self._log.add_metadata(STUDY_RECORD, record)


def write_study(result: StudyResult, path: str | PathLike, run_record: bool = True) -> Path:
    """Writes a result with all its samples to a new log.

    Parameters
    ----------
    result : StudyResult
        What `run_study` gave.
    path : str or path
        The log, an .mcap file that must not exist.
    run_record : bool
        False leaves out what differs from run to run: date, host, cost.

    Returns
    -------
    Path
        The log.

    Raises
    ------
    LogError
        If `path` exists or cannot be written.
    """
    if not isinstance(result, StudyResult):
        raise LogError(
            f"the log of a study is written of its result, and {echo(result)} is none; hand over run_study(study)"
        )
    with StudyLog(result.study, path, run_record, max_loss=0.0) as log:
        log.finish(result)
    return Path(path)


def read_study(path: str | PathLike, unfinished: bool = False) -> StudyResult:
    """The result in a log of a study, as it was written.

    Parameters
    ----------
    path : str or path
        The log.
    unfinished : bool
        True takes a study that was broken off, too, as far as it came, to go on from as the `start` of `run_study`; its
        summary is empty.

    Returns
    -------
    StudyResult
        As `run_study` gave it.

    Raises
    ------
    LogError
        Where there is no study, or not all of it.
    """
    with reading_study(path):
        return _study_in(path, unfinished)


@contextlib.contextmanager
def reading_study(path) -> Iterator[None]:
    """Turns errors of the body, which reads or shows a study's log that anybody may have written, into LogError."""
    try:
        yield
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        reason = shorten(f"{type(error).__name__}: {error}")
        raise LogError(f"{path} does not hold what a study writes ({reason}); run the study again") from error


def _study_in(path, unfinished: bool) -> StudyResult:
    reader, summary = LogReader(path), None
    records = reader.metadata
    if STUDY_RECORD not in records:
        raise LogError(f"{path} holds no study; give a log written by `bearing_twin study --out`")
    record = records[STUDY_RECORD]
    work = parse_json(records.get(RUN_RECORD, {}).get("work", "{}"))
    work_keys = {key: work[key] for key in WORK if key in work}
    keys = {key: value for key, value in parse_json(record["study"]).items() if key not in REMOVED_KEYS}
    keys["scene"] = upgrade_scene(keys["scene"], "the scene of the study in the log")
    study = parse_study({**keys, **work_keys}, "the study of the log")
    layout, numbers = {}, array("d")
    for message in reader.messages((SUMMARY_TOPIC, SAMPLES_TOPIC)):
        if message.topic.name == SUMMARY_TOPIC:
            summary = parse_json(cdr.deserialise(cdr.STRING, message.data).data)
            continue
        block = checked_block(path, message.data)
        widths = dict(zip(block.channel_name, block.channel_width.tolist(), strict=True))
        layout = layout or widths
        if list(layout.items()) != list(widths.items()):
            raise ValueError("its channels change")
        numbers.frombytes(memoryview(block.values).cast("B"))
    edges = np.cumsum([0, *layout.values()]).tolist()
    table = np.frombuffer(numbers).reshape(-1, edges[-1]) if numbers else np.zeros((0, 0))
    count = len(table)
    columns_of = {name: range(*ends) for name, ends in zip(layout, itertools.pairwise(edges), strict=True)}

    def columns(*names: str) -> np.ndarray:
        """The columns of these channels, 0 where an earlier version wrote none; a view where they are adjacent."""
        indices = [column for name in names for column in columns_of.get(name, ())]
        if not indices:
            return np.zeros((count, len(names)))
        low, high = indices[0], indices[-1] + 1
        return table[:, low:high] if indices == list(range(low, high)) else table[:, indices]

    inputs = columns(*(INPUT + variable.key for variable in study.inputs))
    quantities, histories = (
        columns(*(sort + name for name in names))
        for sort, names in ((QUANTITY, study.quantities), (HISTORY, study.histories))
    )
    if "samples" not in record and unfinished and count:
        summary = None
    elif summary is None or count != int(record.get("samples", -1)):
        raise LogError(
            f"{path} lacks a part of its study; go on with `bearing_twin study ... --resume {path}` and another name "
            "for the log, or run the study again"
        )
    status, reasons = columns(STATUS)[:, 0].astype(np.int32), tuple(parse_json(record["reasons"]))
    if len(status) and not 0 <= status.min() <= status.max() <= len(reasons):
        raise ValueError("a realisation that failed has no reason")
    if summary is not None and (summary["samples"], {*summary["quantities"]}) != (count, {*study.quantities}):
        raise ValueError("its summary is that of another study")
    return StudyResult(
        study,
        inputs,
        quantities,
        histories.reshape(count, len(study.histories), -1 if count and study.histories else 0),
        status,
        reasons,
        columns(DOUBTFUL)[:, 0].astype(np.int64),
        tuple(parse_json(record["doubts"])),
        {**(summary or {}), "seconds": float(work.get("seconds", math.nan))},
    )


def _channels(study: Study) -> tuple[Channel, ...]:
    known = numeric_keys(study.kind)
    return (
        *(Channel(INPUT + variable.key, known[variable.key].unit, (), "") for variable in study.inputs),
        *(Channel(QUANTITY + name, unit, (), "") for name, unit in study.quantity_units.items()),
        Channel(STATUS, "1", (), ""),
        Channel(DOUBTFUL, "1", (), ""),
        *(Channel(HISTORY + name, "", (study.settings.history_points,), "") for name in study.histories),
    )
