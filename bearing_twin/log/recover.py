"""Recovery of damaged logs: files cut short by a crash or a full disk, and those with altered bytes."""

from collections import Counter
from collections.abc import Container, Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import NamedTuple

from mcap.records import Attachment, Metadata

from bearing_twin.base.errors import LogError, harmless
from bearing_twin.log import cdr
from bearing_twin.log.bag import LogReader, log_files, reader_of
from bearing_twin.log.mcap_read import DamagedLog, LoggedMessage, McapReader, UnreadableLog
from bearing_twin.log.mcap_write import MAGIC
from bearing_twin.log.raw_log import BAG_RECORD, RawLogWriter

RECOVERY_RECORD = "bearing_twin_recovered"


class Recovered(NamedTuple):
    """Readable content of a damaged log: messages, solver outputs among them, and the problems with the rest."""

    messages: int
    samples: int
    problems: tuple[str, ...]


def survey(path) -> Recovered:
    """Counts what `recover` would save, without writing; raises LogError if the file is no log at all."""
    return _saved(path, None)


def recover(path: str | PathLike, out: str | PathLike) -> Recovered:
    """Writes all that can be read of the log at `path` to a new log at `out`: messages of any encoding and metadata.

    Raises LogError if `out` exists or nothing can be saved. A damaged chunk is left out whole; what else is left out is
    among the problems.
    """
    with RawLogWriter(out, run_record=False) as log:
        found = _saved(path, log)
        problems = "; ".join(found.problems)
        if not found.messages:
            raise LogError(f"nothing in {path} can be recovered ({problems or 'it holds no message'})")
        record = {"from": harmless(Path(path).name), "problems": harmless(problems or "none")}
        log.add_metadata(RECOVERY_RECORD, record)
    return found


def _saved(path, log: RawLogWriter | None) -> Recovered:
    """Counts all that can be read of a log, and copies it into `log` where there is one."""
    problems: list[str] = []
    messages = samples = 0
    numbers: dict[tuple, int] = {}
    kept: set[tuple] = set()
    unknown: Counter[str] = Counter()
    last = number = None
    for item in _salvage(log_files(path), problems):
        if isinstance(item, LoggedMessage):
            if not item.topic.described:
                unknown[item.topic.name] += 1
                continue
            messages += 1
            samples += _outputs(item)
            if log is None:
                continue
            if item.topic is not last:
                last = item.topic
                number = numbers.get(last.identity)
                if number is None:
                    number = numbers[last.identity] = log.copy_topic(last)
            log.write(number, item.log_time, item.publish_time, item.data)
        elif log is None:
            continue
        elif isinstance(item, Attachment):
            log.add_attachment(item)
        elif item.name != BAG_RECORD and (record := (item.name, *sorted(item.metadata.items()))) not in kept:
            kept.add(record)
            log.add_metadata(item.name, item.metadata)
    problems += [f"{count} messages of {name} are left out: no record describes it" for name, count in unknown.items()]
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


def logged(path, topics: Container[str], unfinished: bool = False) -> Iterator[tuple[str, bytes]]:
    """(topic, bytes) of every message on these topics by log time, as LogReader reads them; `advised`."""
    with advised(path):
        for message in LogReader(path, unfinished).messages(topics):
            yield message.topic.name, message.data


def records_in(path, unfinished: bool = False) -> dict[str, dict[str, str]]:
    """The last metadata record of each name in a log; `advised`."""
    with advised(path):
        return LogReader(path, unfinished).metadata


def _salvage(files: list[Path], problems: list[str]) -> Iterator[LoggedMessage | Metadata | Attachment]:
    """All that can be read of the files; `problems` get a sentence for each part that cannot."""

    def note(error: UnreadableLog, file: Path) -> None:
        if (said := f"{file.name} at byte {error.offset}: {error.what}") not in problems:
            problems.append(said)

    for file in files:
        with reader_of(file) as reader:
            if isinstance(reader, McapReader) and reader.ended:
                try:
                    reader.contents()  # where the chunks begin
                except UnreadableLog as error:
                    note(error, file)
            begin: int | None = len(MAGIC)
            while begin is not None:
                try:
                    yield from reader.content(None, begin, True)
                    break
                except UnreadableLog as error:
                    note(error, file)
                    begin = reader.record_after(max(error.offset, begin))
            try:
                reader.require_end()
            except DamagedLog as error:
                note(error, file)


def _outputs(message: LoggedMessage) -> int:
    if message.topic.ros_type != cdr.SAMPLE_BLOCK or "/records/" in message.topic.name:
        return 0
    try:
        return cdr.deserialise(cdr.SAMPLE_BLOCK, message.data).count
    except LogError:
        return 0
