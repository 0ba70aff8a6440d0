"""The document of a run or a log: outputs, panels, figures, model and warnings.

Of a damaged log the document holds what can be recovered.
"""

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import IntegrationError
from bearing_twin.base.report import Report
from bearing_twin.base.units import readable_sentence
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.views import View, plain_view
from bearing_twin.log.bag import LogReader, list_some
from bearing_twin.log.mcap_read import DamagedLog
from bearing_twin.log.raw_log import recover
from bearing_twin.log.run_log import read_log
from bearing_twin.log.stream import topics
from bearing_twin.log.study_log import STUDY_RECORD, read_study, reading_study
from bearing_twin.pictures import BALL_COLOURS
from bearing_twin.run.report import DONE, DOUBTFUL, report_of
from bearing_twin.run.simulation import Run
from bearing_twin.view.page import Frames, collect_frames, pack_series, series_data, unit_data
from bearing_twin.view.study_page import study_document
from bearing_twin.view.tables import badge, page_tables, warning_badges

STATUS_CLASSES = {DONE: "good", DOUBTFUL: "warning"}  # how a status is shown; any other is a failure


class RunDocument(NamedTuple):
    """A run on its page: the document, the report in it, and how many outputs are missing."""

    document: dict[str, Any]
    report: Report
    missing: int


def view_of(stream) -> View:
    """The view of a run or a log by its kind; drawn from its channels where the kind or the scene is not known."""
    scene = stream.scene
    if scene is None or not {channel.name for channel in scene.channels} <= {c.name for c in stream.channels}:
        return plain_view(None, stream.channels)
    return KINDS[scene.kind].view(scene.parameters, stream.channels)


def run_document(stream, notes: Sequence[str] = ()) -> RunDocument:
    """The page of a log, or of a run that is simulated for it; `notes` are shown on it.

    A run that breaks off is shown as far as it came. Raises LogError, or IntegrationError, for one without an output.
    """
    view = view_of(stream)
    frames = Frames(view)
    blocks = collect_frames(stream.blocks(), frames)
    if isinstance(stream, Run):
        try:
            for _ in blocks:
                pass
        except IntegrationError:
            if stream.simulation.sequence < 0:
                raise
        report, missing, cut_short = stream.report, 0, None
    else:
        report, missing = report_of(stream, blocks)
        cut_short = stream.cut_short
    failure = f"The run failed {report.failure['failure']}" if report.failure else ""
    sentences = [*notes, failure, frames.note(), f"{missing} outputs are missing from the log." if missing else ""]
    sentences += [f"{cut_short.sentence()}.".capitalize()] if cut_short else []
    document = {
        "kind": "run",
        "title": report.scene or "Recorded run",
        "subtitle": stream.scene.description if stream.scene else "a recording without its scene",
        "notes": [readable_sentence(sentence) for sentence in sentences if sentence],
        **_tables(stream.scene, report),
        "view": view_data(view),
        "packed": pack_outputs(frames.time, frames.values, view),
    }
    return RunDocument(document, report, missing)


def _tables(scene, report: Report) -> dict[str, Any]:
    """Content of the tables of the page: figures, model with reason, warnings."""
    meanings = KINDS[scene.kind].meanings_of() if scene else {}
    seconds = report.compute_seconds
    facts = [
        ("elastic law", report.law or "-"),
        ("method", report.stepper or "-"),
        ("simulated", readable_sentence(f"{report.simulated_seconds:.6g} s")),
        ("outputs", f"{report.samples}"),
        ("computed in", readable_sentence(f"{seconds:.3g} s") if seconds > 0.0 else "-"),
        ("kind of scene", scene.kind if scene else "-"),
    ]
    return {
        "badges": badges(report.status, report.law, report.stepper, len(report.flags) + len(report.warnings)),
        "facts": facts,
        "reason": readable_sentence(report.choice_reason),
        "status": readable_sentence(report.status),
        "warnings": [readable_sentence(sentence) for sentence in report.warnings],
        "flags": [readable_sentence(sentence) for sentence in report.flags],
        **page_tables(report.figures, report.errors, meanings),
    }


def badges(status: str, law: str, stepper: str, warnings: int) -> list[dict[str, str]]:
    """Badges beside the title: the status, the model, the number of warnings."""
    return [
        badge(status, sort=STATUS_CLASSES.get(status.partition(":")[0], "bad")),
        badge(law or "-", "law"),
        badge(stepper or "-", "method"),
        *warning_badges(warnings),
    ]


def pack_outputs(time: np.ndarray, values: Mapping[str, np.ndarray], view: View) -> dict[str, Any]:
    """Outputs at `time` [s] as a page reads them: the series of the view described, and their numbers packed."""
    described = [series_data(channel) for channel in view.series]
    return {"frames": len(time), "series": described, "data": pack_series(time, values, view.series)}


def view_data(view: View) -> dict[str, Any]:
    """A view as plain data."""
    return {
        "panels": [
            item._asdict() | unit_data(item.unit) | {"lines": [line._asdict() for line in item.lines]}
            for item in view.panels
        ],
        "solids": [_item_data(item) for item in view.solids],
        "marks": [_item_data(item) | (unit_data(item.unit) if hasattr(item, "unit") else {}) for item in view.marks],
        "look": view.look._asdict(),
        "enlarged": view.enlarged and view.enlarged._asdict(),
        "details": view.details and view.details._asdict(),
        "period": view.period,
        "words": view.words,
        "axes": view.axes,
        "palette": list(BALL_COLOURS),
    }


def _item_data(item: NamedTuple) -> dict[str, Any]:
    return {"item": type(item).__name__.lower(), **item._asdict()}


SYSTEM_TOPICS = ("/clock", "/diagnostics", "/parameter_events", "/rosout", "/tf", "/tf_static", "/robot_description")
"""Topics of any system, which hold nothing of a run that its samples do not."""


def log_document(path, topic: str | None = None, run: int | None = None) -> dict[str, Any]:
    """The page of a log (.mcap file or bag folder), of a run or a study.

    `topic` is that of the samples to show where there are several, `run` the number of the run in a recording (None:
    the last). Of a damaged log the page shows what `recover` can save, and says so. Raises LogError where there is
    nothing.
    """
    try:
        return _document(path, (), topic, run)
    except DamagedLog as error:
        return _damaged_document(path, error, topic, run)


def _damaged_document(path, damage: DamagedLog, *selection) -> dict[str, Any]:
    with tempfile.TemporaryDirectory(prefix="bearing_twin_view_") as folder:
        saved = Path(folder) / "recovered.mcap"
        recovered = recover(path, saved)
        note = (
            f"The log is damaged at byte {damage.offset}: {damage.reason}. Shown are the {recovered.samples} outputs "
            f"that can be saved; `bearing_twin recover {Path(path).name} NEW_LOG` writes them to a new log."
        )
        return _document(saved, (note,), *selection, Path(path))


def _document(
    path, notes: tuple[str, ...], topic: str | None, run: int | None, original: Path | None = None
) -> dict[str, Any]:
    stream = read_log(path, True, topic, last_run=True, run=run)
    if STUDY_RECORD in stream.metadata:
        with reading_study(path):
            return study_document(read_study(path))
    omitted = list_some(_omitted(path, stream))
    sentences = [f"Left out, because no kind of scene has such topics: {omitted}."] if omitted else []
    sentences += [f"{note[:1].upper()}{note[1:]}." for note in (*stream.notes, stream.run_note) if note]
    if stream.kept_rate:
        sentences.append(f"The log holds {stream.kept_rate:g} outputs a second, not all of them.")
    viewed = run_document(stream, [*notes, *sentences])
    name = original or Path(path)
    return viewed.document | {"title": viewed.report.scene or name.stem}


def _omitted(path, stream) -> list[str]:
    """Topics, with their types, that a node with the log's scene neither publishes nor subscribes to."""
    known = {"samples", "scene"}
    if stream.scene:
        commands = KINDS[stream.scene.kind].commands()
        names = [topic.full_name for topic in topics(stream.scene)] + [command.name for command in commands]
        known = {name.rpartition("/")[2] for name in names}
    types = {topic.name: topic.ros_type or "of unknown type" for topic in LogReader(path, unfinished=True).topics}
    return sorted(
        f"{name} ({ros_type})"
        for name, ros_type in types.items()
        if name not in SYSTEM_TOPICS and "/records/" not in name and name.rpartition("/")[2] not in known
    )
