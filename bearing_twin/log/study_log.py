"""Studies as MCAP logs: every realisation as a row of `samples`, and the summary as JSON; read back bit for bit.

`/bearing/study/samples` holds SampleBlocks whose rows are realisations: their time is the number of the realisation
in ns, their channels the inputs, the quantities, `status` (0, or 1 + the number of the reason why it failed),
`doubtful` (a bit for each doubt) and the histories. `/bearing/study/summary` is one std_msgs/String. The study itself
is in the metadata.
"""

import itertools
import json
import math
from pathlib import Path

import numpy as np

from bearing_twin.errors import LogError
from bearing_twin.log import cdr
from bearing_twin.log.bag import Qos
from bearing_twin.log.encoding import encoded
from bearing_twin.log.mcap_read import DamagedLog, LoggedMessage, McapReader
from bearing_twin.log.raw_log import RUN_RECORD, RawLogWriter, log_files
from bearing_twin.log.recover import advice
from bearing_twin.log.stream import LARGEST_BLOCK, samples_message
from bearing_twin.sample import Channel
from bearing_twin.uq.result import StudyResult
from bearing_twin.uq.study_file import parse_study

NAMESPACE = "/bearing"
SAMPLES_TOPIC, SUMMARY_TOPIC = f"{NAMESPACE}/study/samples", f"{NAMESPACE}/study/summary"
STRING = "std_msgs/msg/String"
WORK = ("workers", "executor", "memory")  # of a study: what its numbers do not depend on
STUDY_RECORD = "bearing_twin_study"
INPUT, QUANTITY, HISTORY, STATUS, DOUBTFUL = "input ", "quantity ", "history ", "status", "doubtful"


def write_study(result: StudyResult, path, run_record: bool = True) -> Path:
    """Write a result with all its samples to a new log; raises LogError if `path` exists.

    `run_record` False leaves out date, host, seconds and who did the work: equal studies then give equal bytes.
    """
    summary, study = result.as_dict(), result.study.resolved()
    work = {"seconds": summary.pop("seconds"), **{key: study.pop(key) for key in WORK}}
    with RawLogWriter(path, run_record) as log:
        record = {
            "study": json.dumps(study),
            "reasons": json.dumps(list(result.reasons)),
            "doubts": json.dumps(list(result.doubts_met)),
            "samples": len(result.status),
        }
        log.add_metadata(STUDY_RECORD, record)
        latched = Qos(depth=1, durability="transient_local")
        topics = {}
        for name, ros_type, qos in ((SAMPLES_TOPIC, cdr.SAMPLE_BLOCK, Qos()), (SUMMARY_TOPIC, STRING, latched)):
            topics[name] = log.add_topic(name, ros_type, cdr.schema_text(ros_type), cdr.type_hash(ros_type), (qos,))
        last = 0
        for last, message in _blocks(result):
            log.write(topics[SAMPLES_TOPIC], last, last, message)
        text = encoded(STRING, {"data": json.dumps(summary)}, 0, "")
        log.write(topics[SUMMARY_TOPIC], last, last, text)
        log.note_run(work=json.dumps(work))
    return Path(path)


def read_study(path) -> StudyResult:
    """The result in a log of a study, as it was written; raises LogError where there is none, or not all of it."""
    records, summary, rows, names = {}, None, [], []
    try:
        for file in log_files(path):
            with McapReader(file) as reader:
                records |= {record.name: record.metadata for record in reader.metadata(reader.summary())}
                for item in reader.content():
                    if isinstance(item, LoggedMessage) and item.topic.name == SUMMARY_TOPIC:
                        summary = json.loads(cdr.deserialise(STRING, item.data).data)
                    elif isinstance(item, LoggedMessage) and item.topic.name == SAMPLES_TOPIC:
                        message = cdr.deserialise(cdr.SAMPLE_BLOCK, item.data)
                        names = _edges(message)
                        rows.append(message.values.reshape(message.count, -1))
    except DamagedLog as error:
        raise advice(path, error) from error
    if STUDY_RECORD not in records:
        raise LogError(f"{path} holds no study; give a log written by `bearing_twin study --out`")
    record = records[STUDY_RECORD]
    if summary is None or sum(map(len, rows)) != int(record["samples"]):
        raise LogError(f"{path} lacks a part of its study; run the study again with another name for the log")
    work = json.loads(records.get(RUN_RECORD, {}).get("work", "{}"))
    given = {key: work[key] for key in WORK if key in work}
    study = parse_study({**json.loads(record["study"]), **given}, "the study of the log")
    table = np.concatenate(rows) if rows else np.empty((0, 0))
    return StudyResult(
        study,
        _columns(table, names, [INPUT + one.key for one in study.inputs]),
        _columns(table, names, [QUANTITY + name for name in study.quantities]),
        _columns(table, names, [HISTORY + name for name in study.histories]).reshape(
            len(table), len(study.histories), -1 if rows and study.histories else 0
        ),
        _columns(table, names, [STATUS])[:, 0].astype(np.int32),
        tuple(json.loads(record["reasons"])),
        _columns(table, names, [DOUBTFUL])[:, 0].astype(np.int64),
        tuple(json.loads(record["doubts"])),
        {**summary, "seconds": work.get("seconds", math.nan)},
    )


def _edges(message):
    """{channel: (first, last + 1) of its columns} of a SampleBlock."""
    edges = np.concatenate([[0], np.cumsum(message.channel_width.astype(np.int64))])
    return dict(zip(message.channel_name, itertools.pairwise(edges), strict=True))


def _columns(table, edges, names):
    parts = [table[:, slice(*edges[name])] for name in names if name in edges]
    return np.concatenate(parts, axis=1) if parts else np.empty((len(table), len(names)))


def _blocks(result):
    """(first realisation, SampleBlock) for all of them, in pieces of at most LARGEST_BLOCK bytes."""
    study = result.study
    channels = (
        *(Channel(INPUT + key, unit, (), "") for key, unit in result.input_units.items()),
        *(Channel(QUANTITY + name, unit, (), "") for name, unit in result.quantity_units.items()),
        Channel(STATUS, "1", (), ""),
        Channel(DOUBTFUL, "1", (), ""),
        *(Channel(HISTORY + name, "", (study.settings.history_points,), "") for name in study.histories),
    )
    count = len(result.status)
    rows = max(1, LARGEST_BLOCK // (8 * sum(channel.width for channel in channels)))
    for first in range(0, count, rows):
        part = slice(first, min(first + rows, count))
        flat = result.histories[part].reshape(part.stop - first, -1)
        values = np.hstack(
            (result.values[part], result.quantities[part], result.status[part, None], result.doubtful[part, None], flat)
        )
        yield part.stop, samples_message(channels, first, np.arange(part.start, part.stop), values)
