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
from bearing_twin.view.page import Frames, described_series, described_unit, packed, passed_on
from bearing_twin.view.study_page import document_of_study
from bearing_twin.view.tables import tables_of_page

STATUS_SORTS = {DONE: "good", DOUBTFUL: "doubt"}  # how a status is shown; any other is a failure


class Viewed(NamedTuple):
    """A run on its page: the document, the report in it, and how many outputs are missing."""

    document: dict[str, Any]
    report: Report
    missing: int


def run_view(stream) -> View:
    """The view of a run or a log by its kind; drawn from its channels where the kind or the scene is not known."""
    scene = stream.scene
    if scene is None or not {one.name for one in scene.channels} <= {one.name for one in stream.channels}:
        return plain_view(None, stream.channels)
    return KINDS[scene.kind].view(scene.parameters, stream.channels)


def document_of_run(stream, notes: Sequence[str] = ()) -> Viewed:
    """The page of a log, or of a run that is simulated for it; `notes` are shown on it.

    A run that breaks off is shown as far as it came. Raises LogError, or IntegrationError, for one without an output.
    """
    view = run_view(stream)
    frames = Frames(view)
    shown = passed_on(stream.blocks(), frames)
    if isinstance(stream, Run):
        try:
            for _ in shown:
                pass
        except IntegrationError:
            if stream.simulation.sequence < 0:
                raise
        report, missing, cut_short = stream.report, 0, None
    else:
        report, missing = report_of(stream, shown)
        cut_short = stream.cut_short
    failure = f"The run failed {report.failure['failure']}" if report.failure else ""
    said = [*notes, failure, frames.note(), f"{missing} outputs are missing from the log." if missing else ""]
    said += [f"{cut_short.sentence()}.".capitalize()] if cut_short else []
    document = {
        "kind": "run",
        "title": report.scene or "Recorded run",
        "subtitle": stream.scene.description if stream.scene else "a recording without its scene",
        "notes": [readable_sentence(one) for one in said if one],
        **_tables(stream.scene, report),
        "view": described_view(view),
        "packed": packed_outputs(frames.time, frames.values, view),
    }
    return Viewed(document, report, missing)


def _tables(scene, report: Report) -> dict[str, Any]:
    """Content of the tables of the page: figures, model with reason, warnings."""
    meanings = KINDS[scene.kind].meanings_of() if scene else {}
    took = report.compute_seconds
    facts = [
        ("elastic law", report.law or "-"),
        ("method", report.stepper or "-"),
        ("simulated", readable_sentence(f"{report.simulated_seconds:.6g} s")),
        ("outputs", f"{report.samples}"),
        ("computed in", readable_sentence(f"{took:.3g} s") if took > 0.0 else "-"),
        ("kind of scene", scene.kind if scene else "-"),
    ]
    return {
        "badges": badges(report.status, report.law, report.stepper, len(report.flags) + len(report.warnings)),
        "facts": facts,
        "reason": readable_sentence(report.choice_reason),
        "status": readable_sentence(report.status),
        "warnings": [readable_sentence(one) for one in report.warnings],
        "flags": [readable_sentence(one) for one in report.flags],
        **tables_of_page(report.figures, report.errors, meanings),
    }


def badges(status: str, law: str, stepper: str, warnings: int) -> list[dict[str, str]]:
    """Badges beside the title: the status, the model, the number of warnings."""
    found = [
        {"sort": STATUS_SORTS.get(status.partition(":")[0], "bad"), "name": "", "text": status},
        {"sort": "", "name": "law", "text": law or "-"},
        {"sort": "", "name": "method", "text": stepper or "-"},
    ]
    return found + (
        [{"sort": "doubt", "name": "", "text": f"{warnings} warning{'s' * (warnings != 1)}"}] if warnings else []
    )


def packed_outputs(time: np.ndarray, values: Mapping[str, np.ndarray], view: View) -> dict[str, Any]:
    """Outputs at `time` [s] as a page reads them: the series of the view described, and their numbers packed."""
    described = [described_series(one) for one in view.series]
    return {"frames": len(time), "series": described, "data": packed(time, values, view.series)}


def described_view(view: View) -> dict[str, Any]:
    """A view as plain data."""
    return {
        "panels": [
            one._asdict() | described_unit(one.unit) | {"lines": [line._asdict() for line in one.lines]}
            for one in view.panels
        ],
        "solids": [_item(one) for one in view.solids],
        "marks": [_item(one) | (described_unit(one.unit) if hasattr(one, "unit") else {}) for one in view.marks],
        "look": view.look._asdict(),
        "enlarged": view.enlarged and view.enlarged._asdict(),
        "details": view.details and view.details._asdict(),
        "period": view.period,
        "words": view.words,
        "axes": view.axes,
        "palette": list(BALL_COLOURS),
    }


def _item(one: NamedTuple) -> dict[str, Any]:
    return {"item": type(one).__name__.lower(), **one._asdict()}


OF_ROS = ("/clock", "/diagnostics", "/parameter_events", "/rosout", "/tf", "/tf_static", "/robot_description")
"""Topics of any system, which hold nothing of a run that its samples do not."""


def document_of_log(path, topic: str | None = None, run: int | None = None) -> dict[str, Any]:
    """The page of a log (.mcap file or bag folder), of a run or a study.

    `topic` is that of the samples to show where there are several, `run` the number of the run in a recording (None:
    the last). Of a damaged log the page shows what `recover` can save, and says so. Raises LogError where there is
    nothing.
    """
    try:
        return _document(path, (), topic, run)
    except DamagedLog as error:
        return _of_damaged(path, error, topic, run)


def _of_damaged(path, damage: DamagedLog, *which) -> dict[str, Any]:
    with tempfile.TemporaryDirectory(prefix="bearing_twin_view_") as folder:
        saved = Path(folder) / "recovered.mcap"
        found = recover(path, saved)
        note = (
            f"The log is damaged at byte {damage.offset}: {damage.reason}. Shown are the {found.samples} outputs "
            f"that can be saved; `bearing_twin recover {Path(path).name} NEW_LOG` writes them to a new log."
        )
        return _document(saved, (note,), *which, Path(path))


def _document(
    path, notes: tuple[str, ...], topic: str | None, run: int | None, original: Path | None = None
) -> dict[str, Any]:
    stream = read_log(path, True, topic, last_run=True, run=run)
    if STUDY_RECORD in stream.metadata:
        with reading_study(path):
            return document_of_study(read_study(path))
    omitted = list_some(_omitted(path, stream))
    said = [f"Left out, because no kind of scene has such topics: {omitted}."] if omitted else []
    said += [f"{note[:1].upper()}{note[1:]}." for note in (*stream.notes, stream.run_note) if note]
    if stream.kept_rate:
        said.append(f"The log holds {stream.kept_rate:g} outputs a second, not all of them.")
    viewed = document_of_run(stream, [*notes, *said])
    name = original or Path(path)
    return viewed.document | {"title": viewed.report.scene or name.stem}


def _omitted(path, stream) -> list[str]:
    """Topics, with their types, that a node with the log's scene neither publishes nor subscribes to."""
    known = {"samples", "scene"}
    if stream.scene:
        commands = KINDS[stream.scene.kind].commands()
        names = [topic.full_name for topic in topics(stream.scene)] + [command.name for command in commands]
        known = {name.rpartition("/")[2] for name in names}
    found = {topic.name: topic.ros_type or "of unknown type" for topic in LogReader(path, unfinished=True).topics}
    return sorted(
        f"{name} ({ros_type})"
        for name, ros_type in found.items()
        if name not in OF_ROS and "/records/" not in name and name.rpartition("/")[2] not in known
    )
