"""What can be saved of a damaged log: a file cut short by a crash or a full disk, or one with altered bytes."""

from collections.abc import Container, Iterator, Sequence
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import NamedTuple

from mcap.records import Metadata

from bearing_twin.errors import LogError
from bearing_twin.kinds.ranges import OUTSIDE
from bearing_twin.log import cdr
from bearing_twin.log.bag import offered_qos
from bearing_twin.log.mcap_read import DamagedLog, LoggedMessage, McapReader, StoredTopic
from bearing_twin.log.parts import BAG_RECORD
from bearing_twin.log.raw_log import RawLogWriter, log_files
from bearing_twin.log.thinning import kept_rate
from bearing_twin.spelling import harmless

RECOVERY_RECORD = "bearing_twin_recovered"


class Recovered(NamedTuple):
    """What a damaged log still holds: messages, solver outputs among them, and what is wrong with the rest."""

    messages: int
    samples: int
    problems: tuple[str, ...]


def survey(path) -> Recovered:
    """Counts what `recover` would save, without writing; raises LogError if the file is no log at all."""
    problems: list[str] = []
    messages = samples = 0
    for item in _salvage(log_files(path), problems):
        if isinstance(item, LoggedMessage):
            messages += 1
            samples += _outputs(item)
    return Recovered(messages, samples, tuple(problems))


def recover(path: str | PathLike, out: str | PathLike) -> Recovered:
    """Writes everything that is whole in the log at `path` to a new log at `out`, with scene and metadata.

    Raises LogError if `out` exists or nothing can be saved. A damaged chunk is left out whole.
    """
    files = log_files(path)
    problems: list[str] = []
    messages = samples = 0
    numbers: dict[StoredTopic, int] = {}
    kept: set[tuple] = set()
    with RawLogWriter(out, run_record=False) as log:
        for item in _salvage(files, problems):
            if isinstance(item, Metadata):
                record = (item.name, *sorted(item.metadata.items()))
                if item.name != BAG_RECORD and record not in kept:
                    kept.add(record)
                    log.add_metadata(item.name, item.metadata)
                continue
            key = (item.topic.name, item.topic.ros_type, item.topic.definition)
            if key not in numbers:
                said = item.topic.metadata
                numbers[key] = log.add_topic(
                    item.topic.name, item.topic.ros_type, item.topic.definition,
                    said.get("topic_type_hash", ""), (offered_qos(said.get("offered_qos_profiles", "")),),
                    kept_rate(said), said.get(OUTSIDE, ""),
                )  # fmt: skip
            log.write(numbers[key], item.log_time, item.publish_time, item.data)
            messages += 1
            samples += _outputs(item)
        if not messages:
            raise LogError(f"nothing in {path} can be recovered ({'; '.join(problems) or 'it holds no message'})")
        told = {"from": Path(path).name, "problems": "; ".join(problems) or "none"}
        log.add_metadata(RECOVERY_RECORD, {key: harmless(one) for key, one in told.items()})
    return Recovered(messages, samples, tuple(problems))


def advice(path, error: DamagedLog) -> LogError:
    """The error a reader of a damaged log gets: what is wrong, how much can be saved, and how."""
    try:
        found = survey(path)
    except LogError:
        return error
    damage = f"{error.path} is damaged at byte {error.offset}: {error.what}"
    if not found.messages:
        return LogError(f"{damage}; nothing in it can be recovered, so run the scene again")
    return LogError(
        f"{damage}; {found.samples} samples ({found.messages} messages) can be recovered: run "
        f"`bearing_twin recover {path} NEW_LOG`, or recover(path, out) in Python"
    )


@contextmanager
def advised(path) -> Iterator[None]:
    """Within it damage to the log at `path` raises the LogError of `advice`."""
    try:
        yield
    except DamagedLog as error:
        raise advice(path, error) from error


def logged(path, topics: Container[str]) -> Iterator[tuple[str, bytes]]:
    """(topic, bytes) of every message on these topics, in the order of the log; `advised`."""
    with advised(path):
        for file in log_files(path):
            with McapReader(file) as reader:
                for item in reader.content():
                    if isinstance(item, LoggedMessage) and item.topic.name in topics:
                        yield item.topic.name, item.data


def records_in(path) -> dict[str, dict[str, str]]:
    """The last metadata record of each name in a log, by the index of its files; `advised`."""
    found = {}
    with advised(path):
        for file in log_files(path):
            with McapReader(file) as reader:
                found |= {record.name: record.metadata for record in reader.metadata(reader.summary())}
    return found


def _salvage(files: list[Path], problems: list[str]) -> Iterator[LoggedMessage | Metadata]:
    """All that can be read of the files; what cannot is told in `problems`."""
    for file in files:
        with McapReader(file) as reader:
            chunk_starts: Sequence[int] = ()
            try:
                summary = reader.summary()
                reader.learn(summary)
                chunk_starts = sorted(summary.chunks)
            except DamagedLog as error:
                problems.append(f"{file.name} at byte {error.offset}: {error.what}")
            begin: int | None = None
            while True:
                try:
                    yield from reader.content() if begin is None else reader.content(begin=begin)
                    break
                except DamagedLog as error:
                    problems.append(f"{file.name} at byte {error.offset}: {error.what}")
                    if error.hopeless:
                        break
                    later = [start for start in chunk_starts if start > max(error.offset, begin or 0)]
                    following = [reader.record_after(error.offset), *later[:1]]
                    begin = min((one for one in following if one and one > error.offset), default=None)
                    if begin is None:
                        break


def _outputs(message: LoggedMessage) -> int:
    if message.topic.ros_type != cdr.SAMPLE_BLOCK or "/records/" in message.topic.name:
        return 0
    try:
        return cdr.deserialise(cdr.SAMPLE_BLOCK, message.data).count
    except LogError:
        return 0
