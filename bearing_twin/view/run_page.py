"""The document of a run or a log: its outputs as packed numbers, what to draw of them, figures, model and doubts."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from bearing_twin.base.errors import IntegrationError
from bearing_twin.base.report import Report
from bearing_twin.base.units import sentence_for_people
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import Facts
from bearing_twin.kinds.views import View, plain_view
from bearing_twin.pictures.style import BALL_COLOURS
from bearing_twin.run.report import DONE, DOUBTFUL, report_of
from bearing_twin.run.simulation import Run
from bearing_twin.view.frames import Frames, passed_on
from bearing_twin.view.packing import packed, prefixes
from bearing_twin.view.tables import ball_tables, error_notes, figure_rows, happening_tables

STATUS_SORTS = {DONE: "good", DOUBTFUL: "doubt"}  # how a status is shown; any other is a failure


class Viewed(NamedTuple):
    """A run on its page: the document, the report in it, and how many outputs are missing."""

    document: dict[str, Any]
    report: Report
    missing: int


def view_of(stream) -> View:
    """The view of a run or a log by its kind; drawn from its channels where the kind or the scene is not known."""
    scene, choice = stream.scene, stream.choice
    if scene is None or not {one.name for one in scene.channels} <= {one.name for one in stream.channels}:
        return plain_view(None, stream.channels)
    return KINDS[scene.kind].view(Facts(scene, choice.law, choice.stepper), stream.channels)


def document_of_run(stream, notes: Sequence[str] = ()) -> Viewed:
    """The page of a log, or of a run that is simulated for it; `notes` are shown on it.

    A run that breaks off is shown as far as it came. Raises LogError, or IntegrationError, for one without an output.
    """
    view = view_of(stream)
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
    said += [f"{cut_short.told()}.".capitalize()] if cut_short else []
    document = {
        "kind": "run",
        "title": report.scene or "Recorded run",
        "subtitle": stream.scene.description if stream.scene else "a recording without its scene",
        "notes": [sentence_for_people(one) for one in said if one],
        **_told(stream.scene, report),
        "view": described_view(view),
        "packed": packed(frames.time, frames.values, view.series),
    }
    return Viewed(document, report, missing)


def _told(scene, report: Report) -> dict[str, Any]:
    """What the tables of the page say: figures, model with reason, doubts."""
    meanings = KINDS[scene.kind].meanings_of() if scene else {}
    took = report.compute_seconds
    facts = [
        ("elastic law", report.law or "-"),
        ("method", report.stepper or "-"),
        ("simulated", sentence_for_people(f"{report.simulated_seconds:.6g} s")),
        ("outputs", f"{report.samples}"),
        ("computed in", sentence_for_people(f"{took:.3g} s") if took > 0.0 else "-"),
        ("kind of scene", scene.kind if scene else "-"),
    ]
    return {
        "badges": badges(report.status, report.law, report.stepper, len(report.flags) + len(report.warnings)),
        "facts": facts,
        "reason": sentence_for_people(report.choice_reason),
        "status": sentence_for_people(report.status),
        "warnings": [sentence_for_people(one) for one in report.warnings],
        "flags": [sentence_for_people(one) for one in report.flags],
        "figures": figure_rows(report.figures, report.errors, meanings),
        "tables": ball_tables(report.figures, report.errors, meanings) + happening_tables(report.figures, meanings),
        "errors": error_notes(report.errors),
    }


def badges(status: str, law: str, stepper: str, doubts: int) -> list[dict[str, str]]:
    """What stands beside the title: how it ended, the model, how many doubts there are."""
    found = [
        {"sort": STATUS_SORTS.get(status.partition(":")[0], "bad"), "name": "", "text": status},
        {"sort": "", "name": "law", "text": law or "-"},
        {"sort": "", "name": "method", "text": stepper or "-"},
    ]
    return found + ([{"sort": "doubt", "name": "", "text": f"{doubts} doubt{'s' * (doubts != 1)}"}] if doubts else [])


def described_view(view: View) -> dict[str, Any]:
    """A view as plain data."""
    return {
        "panels": [one._asdict() | {"prefixes": prefixes(one.unit), "lines": _plain(one.lines)} for one in view.panels],
        "solids": [_item(one) for one in view.solids],
        "marks": [
            _item(one) | ({"prefixes": prefixes(one.unit)} if hasattr(one, "unit") else {}) for one in view.marks
        ],
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


def _plain(rows: Iterable[NamedTuple]) -> list[Mapping[str, Any]]:
    return [row._asdict() for row in rows]
