"""Logs on their way to a page: of runs, of studies, damaged ones as far as they can be read, with what is left out."""

import tempfile
from pathlib import Path
from typing import Any

from bearing_twin.base.errors import LogError
from bearing_twin.log.bag import LogReader
from bearing_twin.log.mcap_read import DamagedLog
from bearing_twin.log.recover import recover
from bearing_twin.log.run_log import read_log
from bearing_twin.log.stream import topics
from bearing_twin.log.study_log import STUDY_RECORD, read_study
from bearing_twin.view.run_page import document_of_run
from bearing_twin.view.study_page import document_of_study

OF_ROS = ("/clock", "/diagnostics", "/parameter_events", "/rosout", "/tf", "/tf_static", "/robot_description")
"""Topics of any system, which hold nothing of a run that its samples do not."""


def document_of_log(path, topic: str | None = None) -> dict[str, Any]:
    """The page of a log (.mcap file or bag folder), of a run or a study.

    `topic` is that of the samples to show where there are several. Of a damaged log the page shows what `recover` can
    save, and says so. Raises LogError where there is nothing.
    """
    try:
        return _document(path, (), topic)
    except LogError as error:
        if not isinstance(error.__cause__, DamagedLog):
            raise
        return _of_damaged(path, error.__cause__, topic)


def _of_damaged(path, damage: DamagedLog, topic: str | None) -> dict[str, Any]:
    with tempfile.TemporaryDirectory(prefix="bearing_twin_view_") as folder:
        saved = Path(folder) / "recovered.mcap"
        found = recover(path, saved)
        note = (
            f"The log is damaged at byte {damage.offset}: {damage.what}. Shown are the {found.samples} outputs "
            f"that can be saved; `bearing_twin recover {Path(path).name} NEW_LOG` writes them to a new log."
        )
        return _document(saved, (note,), topic, Path(path))


def _document(path, notes: tuple[str, ...], topic: str | None, original: Path | None = None) -> dict[str, Any]:
    stream = read_log(path, allow_gaps=True, topic=topic, last_run=True)
    if STUDY_RECORD in stream.metadata:
        return document_of_study(read_study(path))
    left_out = _left_out(path, stream)
    notes = (
        *notes,
        *([f"Left out, because no kind of scene has such topics: {', '.join(left_out)}."] if left_out else []),
    )
    notes = (*notes, *(f"{note[:1].upper()}{note[1:]}." for note in stream.notes))
    if stream.restart:
        notes = (*notes, f"{stream.restart.told()}.".capitalize())
    if stream.kept_rate:
        notes = (*notes, f"The log holds {stream.kept_rate:g} outputs a second, not all of them.")
    viewed = document_of_run(stream, notes)
    name = original or Path(path)
    return viewed.document | {"title": viewed.report.scene or name.stem}


def _left_out(path, stream) -> list[str]:
    """Topics, with their types, that are not in the table of the log's scene."""
    known = (
        {topic.full_name.rpartition("/")[2] for topic in topics(stream.scene)} if stream.scene else {"samples", "scene"}
    )
    found = {topic.name: topic.ros_type or "of unknown type" for topic in LogReader(path, unfinished=True).topics}
    return sorted(
        f"{name} ({ros_type})"
        for name, ros_type in found.items()
        if name not in OF_ROS and "/records/" not in name and name.rpartition("/")[2] not in known
    )
