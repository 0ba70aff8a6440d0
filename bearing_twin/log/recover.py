"""Recovery of damaged logs: files cut short by a crash or a full disk, and those with altered bytes."""

from collections import Counter
from collections.abc import Iterator
from os import PathLike
from pathlib import Path
from typing import NamedTuple

from mcap.records import Attachment, Metadata

from bearing_twin.base.errors import LogError, harmless
from bearing_twin.log import cdr
from bearing_twin.log.bag import log_files, reader_of
from bearing_twin.log.mcap_read import DamagedLog, LoggedMessage, UnreadableLog
from bearing_twin.log.raw_log import BAG_RECORD, RawLogWriter

RECOVERY_RECORD = "bearing_twin_recovered"


class Recovered(NamedTuple):
    """Recovered part of a log: messages, solver outputs among them, and the problems with the rest."""

    messages: int
    samples: int
    problems: tuple[str, ...]


def recover(path: str | PathLike, out: str | PathLike) -> Recovered:
    """Writes all that can be read of the log at `path` to a new log at `out`: messages of any encoding and metadata.

    Raises LogError if `out` exists or nothing can be saved. A damaged chunk is left out whole; what else is left out is
    among the problems.
    """
    problems: list[str] = []
    messages = samples = 0
    numbers: dict[tuple, int] = {}
    kept: set[tuple] = set()
    unknown: Counter[str] = Counter()
    with RawLogWriter(out, run_record=False) as log:
        for item in _salvage(log_files(path), problems):
            if isinstance(item, Attachment):
                log.add_attachment(item)
            elif isinstance(item, Metadata):
                record = (item.name, *sorted(item.metadata.items()))
                if item.name != BAG_RECORD and record not in kept:
                    kept.add(record)
                    log.add_metadata(item.name, item.metadata)
            elif not item.topic.described:
                unknown[item.topic.name] += 1
            else:
                messages += 1
                samples += _outputs(item)
                if (key := item.topic.identity) not in numbers:
                    numbers[key] = log.copy_topic(item.topic)
                log.write(numbers[key], item.log_time, item.publish_time, item.data)
        problems += [
            f"{count} messages of {name} are left out: no record describes it" for name, count in unknown.items()
        ]
        said = "; ".join(problems)
        if not messages:
            raise LogError(f"nothing in {path} can be recovered ({said or 'it holds no message'})")
        log.add_metadata(RECOVERY_RECORD, {"from": harmless(Path(path).name), "problems": harmless(said or "none")})
    return Recovered(messages, samples, tuple(problems))


def _salvage(files: list[Path], problems: list[str]) -> Iterator[LoggedMessage | Metadata | Attachment]:
    """All that can be read of the files; `problems` get a sentence for each part that cannot."""
    for file in files:
        damage: list[UnreadableLog] = []
        with reader_of(file) as reader:
            yield from reader.content(damage)
            try:
                reader.require_end()
            except DamagedLog as error:
                damage.append(error)
        problems += dict.fromkeys(f"{file.name} at byte {one.offset}: {one.what}" for one in damage)


def _outputs(message: LoggedMessage) -> int:
    if message.topic.ros_type != cdr.SAMPLE_BLOCK or "/records/" in message.topic.name:
        return 0
    try:
        return cdr.deserialise(cdr.SAMPLE_BLOCK, message.data).count
    except LogError:
        return 0
