"""The page of a study: its picture, statistics of every quantity, inputs, errors and warnings."""

import base64
import io
from typing import Any

from bearing_twin.base.units import readable_sentence, rounded_to_error, two_digits
from bearing_twin.charts.panels import figure_of
from bearing_twin.uq.result import (
    StudyResult,
    SweepDescription,
    model_error_sentences,
    names_by_sentence,
    refusals,
    sweep_of,
)
from bearing_twin.view.study_picture import IN_WORDS, sheet_of, title_of, unit_of
from bearing_twin.view.tables import DIGITS, error_notes

MOST_QUANTITIES = 12
STATISTICS = ("mean", "std", "skewness")


def document_of_study(result: StudyResult) -> dict[str, Any]:
    """The page of a study that has run."""
    study, summary = result.study, result.as_dict()
    names = study.quantities[:MOST_QUANTITIES]
    failed, sweep = sum(summary["failed"].values()), sweep_of(result)
    words = SweepDescription(sweep) if sweep else None
    inputs = ((key, text.removeprefix(f"{key}: ")) for key, text in summary["inputs"].items())  # which begin with it
    badges = [
        *([{"sort": "", "name": "at", "text": words.in_scene}] if words and words.in_scene else []),
        {"sort": "", "name": "samples", "text": str(summary["samples"])},
        {"sort": "", "name": "sampler", "text": summary["sampler"].replace("_", " ")},
        *([{"sort": "bad", "name": "", "text": f"{failed} failed"}] if failed else []),
        *(
            [{"sort": "doubt", "name": "", "text": f"{len(result.doubts)} warning{'s' * (len(result.doubts) > 1)}"}]
            if result.doubts
            else []
        ),
    ]
    ended = [words.incomplete] if words and words.incomplete else []
    drawn = io.BytesIO()
    figure_of(sheet_of(result, names, study.histories)).savefig(drawn, format="svg", metadata={"Date": None})
    return {
        "kind": "study",
        "title": study.name,
        "subtitle": study.description or f"study of {summary['scene']}",
        "badges": badges,
        "picture": f"data:image/svg+xml;base64,{base64.b64encode(drawn.getvalue()).decode('ascii')}",
        "statistics": [{"title": title_of(name), "rows": _statistics(summary["quantities"][name])} for name in names],
        "flags": [readable_sentence(one) for one in (*result.doubts, *_refused(names, summary), *ended)],
        "warnings": [],
        "reason": f"Sampling ended because {summary['stopped_because']}.",
        "facts": [("scene", summary["scene"]), ("seed", str(summary["seed"])), *inputs],
        "errors": [*model_error_sentences(summary), *error_notes(summary.get("companions", {}))],
        "notes": [],
    }


def _statistics(found) -> list[dict[str, str]]:
    rows, own = [], unit_of(found)
    error = found.get("error")  # a log of an earlier version has none
    for key in STATISTICS:
        words = IN_WORDS.get(key, key)
        ends = tuple(found[f"{key}_interval"] or (None, None))
        unit = ("", 1.0) if key == "skewness" else own
        rows.append(_row(words, found[key], ends, unit, error if key == "mean" else None))
    for p, one in found["quantiles"].items():
        rows.append(_row(f"{100.0 * float(p):g} % quantile", one["value"], (one["low"], one["high"]), own, error))
    return rows


def _row(words, value, ends, shown, error=None) -> dict[str, str]:
    unit, factor = shown
    known = max((abs(one - value) * factor for one in ends if None not in (one, value)), default=0.0)
    text = ["–" if one is None else rounded_to_error(one * factor, known, DIGITS) for one in (value, *ends)]
    return {
        "words": words,
        "value": text[0],
        "unit": unit,
        "error": "" if error is None else two_digits(error * factor),
        "interval": "" if ends == (None, None) else f"{text[1]} to {text[2]}",
        "meaning": "",
    }


def _refused(names, summary) -> list[str]:
    return [
        f"{', '.join(map(title_of, sharing))}: {sentence}"
        for sentence, sharing in names_by_sentence(
            {name: refusals(summary["quantities"][name]) for name in names}
        ).items()
    ]
