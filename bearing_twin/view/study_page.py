"""The page of a study: its picture, statistics of every quantity, inputs, errors and warnings."""

import base64
import io
from typing import Any

from bearing_twin.base.units import readable_sentence, rounded_to_error, two_digits
from bearing_twin.pictures import figure_of
from bearing_twin.uq.result import (
    StudyResult,
    SweepDescription,
    model_error_sentences,
    names_by_sentence,
    refusals,
    sweep_of,
)
from bearing_twin.view.study_picture import STATISTIC_NAMES, study_sheet, title_of, unit_of
from bearing_twin.view.tables import DIGITS, badge, error_notes, warning_badges

MOST_QUANTITIES = 12
STATISTICS = ("mean", "std", "skewness")


def study_document(result: StudyResult) -> dict[str, Any]:
    """The page of a study that has run."""
    study, summary = result.study, result.as_dict()
    names = study.quantities[:MOST_QUANTITIES]
    failed, sweep = sum(summary["failed"].values()), sweep_of(result)
    description = SweepDescription(sweep) if sweep else None
    inputs = ((key, text.removeprefix(f"{key}: ")) for key, text in summary["inputs"].items())  # which begin with it
    badges = [
        *([badge(description.in_scene, "at")] if description and description.in_scene else []),
        badge(str(summary["samples"]), "samples"),
        badge(summary["sampler"].replace("_", " "), "sampler"),
        *([badge(f"{failed} failed", sort="bad")] if failed else []),
        *warning_badges(len(result.doubts)),
    ]
    incomplete = [description.incomplete] if description and description.incomplete else []
    drawn = io.BytesIO()
    figure_of(study_sheet(result, names, study.histories), "").savefig(drawn, format="svg", metadata={"Date": None})
    return {
        "kind": "study",
        "title": study.name,
        "subtitle": study.description or f"study of {summary['scene']}",
        "badges": badges,
        "picture": f"data:image/svg+xml;base64,{base64.b64encode(drawn.getvalue()).decode('ascii')}",
        "statistics": [{"title": title_of(name), "rows": _statistics(summary["quantities"][name])} for name in names],
        "flags": [readable_sentence(sentence) for sentence in (*result.doubts, *_refused(names, summary), *incomplete)],
        "warnings": [],
        "reason": f"Sampling ended because {summary['stopped_because']}.",
        "facts": [("scene", summary["scene"]), ("seed", str(summary["seed"])), *inputs],
        "errors": [*model_error_sentences(summary), *error_notes(summary.get("companions", {}))],
        "notes": [],
    }


def _statistics(quantity) -> list[dict[str, str]]:
    rows, quantity_unit = [], unit_of(quantity)
    error = quantity.get("error")  # a log of an earlier version has none
    for key in STATISTICS:
        label = STATISTIC_NAMES.get(key, key)
        ends = tuple(quantity[f"{key}_interval"] or (None, None))
        unit = ("", 1.0) if key == "skewness" else quantity_unit
        rows.append(_row(label, quantity[key], ends, unit, error if key == "mean" else None))
    for p, quantile in quantity["quantiles"].items():
        label, ends = f"{100.0 * float(p):g} % quantile", (quantile["low"], quantile["high"])
        rows.append(_row(label, quantile["value"], ends, quantity_unit, error))
    return rows


def _row(label, value, ends, readable, error=None) -> dict[str, str]:
    unit, factor = readable
    uncertainty = max((abs(number - value) * factor for number in ends if None not in (number, value)), default=0.0)
    text = [
        "–" if number is None else rounded_to_error(number * factor, uncertainty, DIGITS) for number in (value, *ends)
    ]
    return {
        "words": label,
        "value": text[0],
        "unit": unit,
        "error": "" if error is None else two_digits(error * factor),
        "interval": "" if ends == (None, None) else f"{text[1]} to {text[2]}",
        "meaning": "",
    }


def _refused(names, summary) -> list[str]:
    return [
        f"{', '.join(map(title_of, quantities))}: {sentence}"
        for sentence, quantities in names_by_sentence(
            {name: refusals(summary["quantities"][name]) for name in names}
        ).items()
    ]
