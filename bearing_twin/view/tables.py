"""Figures of a report as rows for people: words, number in the unit that engineers read, error, meaning."""

import math
from collections.abc import Mapping
from typing import Any

from bearing_twin.base.units import (
    greatest_error,
    known_digits,
    readable,
    sentence_for_people,
    sizes_for_units,
    two_digits,
)
from bearing_twin.run.report import promise_in_words, shown_errors

ERROR = "_error"
AXES = 3  # lists of so many numbers at most are vectors
DIGITS = 5
MOST_ROWS = 200


def figure_rows(
    figures: Mapping[str, Any], errors: Mapping[str, Any], meanings: Mapping[str, str]
) -> list[dict[str, str]]:
    """One row a figure of one number, one text or a short vector, with `<figure>_error` of `errors`."""
    rows, sizes = [], _sizes(figures, errors)
    for key, value in figures.items():
        if _of_balls(value) or _happenings(value) or isinstance(value, Mapping):
            continue
        most, error = shown_errors(errors, key)
        words, unit, factor = readable(key, sizes[key])
        rows.append(
            {
                "words": words,
                "value": _text(value, factor, most),
                "unit": unit,
                "error": _error(error, factor),
                "meaning": meanings.get(key, ""),
            }
        )
    return rows


def ball_tables(
    figures: Mapping[str, Any], errors: Mapping[str, Any], meanings: Mapping[str, str]
) -> list[dict[str, Any]]:
    """Figures that are lists of as many numbers, side by side: `header` (words, unit, meaning), `rows`, `errors`."""
    by_length: dict[int, dict[str, list]] = {}
    sizes = _sizes(figures, errors)
    for key, value in figures.items():
        if _of_balls(value):
            by_length.setdefault(len(value), {})[key] = value
    tables = []
    for columns in by_length.values():
        header, filled, greatest = [], [], []
        for key, values in columns.items():
            words, unit, factor = readable(key, sizes[key])
            most, error = shown_errors(errors, key)
            header.append((words, unit, meanings.get(key, "")))
            filled.append([_number(value, factor, most) for value in values])
            greatest.append(_error(error, factor))
        rows = [list(row) for row in zip(*filled, strict=True)]
        tables.append({"header": header, "rows": rows, "errors": greatest if any(greatest) else []})
    return tables


def happening_tables(figures: Mapping[str, Any], meanings: Mapping[str, str]) -> list[dict[str, Any]]:
    """Figures that are lists of what happened one after the other, as contacts: a table each, a row each."""
    tables = []
    for key, found in figures.items():
        if not _happenings(found):
            continue
        header, columns = [], []
        for column in found[0]:
            values = [one.get(column) for one in found[:MOST_ROWS]]
            words, unit, factor = readable(column, _size(values))
            header.append((words, unit, ""))
            columns.append([_number(value, factor) for value in values])
        title = meanings.get(key, "") + (f"; the first {MOST_ROWS} of {len(found)}" if len(found) > MOST_ROWS else "")
        rows = [list(row) for row in zip(*columns, strict=True)]
        tables.append({"title": title, "noun": key.replace("_", " "), "header": header, "rows": rows, "errors": []})
    return tables


def error_notes(errors: Mapping[str, Any]) -> list[str]:
    """Errors of the outputs requested to a tolerance, and those that are not known."""
    notes = [
        f"{output}: error {promise_in_words(one)}"
        for output, one in errors.get("wanted_errors", {}).items()
        if one["error"] is not None
    ]
    notes += [f"Not in these errors: {name}: {text}" for name, text in errors.get("errors_unknown", {}).items()]
    return [sentence_for_people(one) for one in notes]


def _error(error, factor: float) -> str:
    """An error, of several the greatest, in the unit of its figure."""
    return "" if error is None else two_digits(factor * greatest_error(error))


def _of_balls(value) -> bool:
    """True for a list of more numbers than a vector has."""
    several = isinstance(value, (list, tuple)) and len(value) > AXES
    return several and not isinstance(value[0], (list, tuple, str, Mapping))


def _happenings(value) -> bool:
    """True for a list of mappings, with the same keys."""
    return isinstance(value, (list, tuple)) and bool(value) and all(isinstance(one, Mapping) for one in value)


def _text(value, factor: float, error=None) -> str:
    if isinstance(value, (list, tuple)) and any(isinstance(one, (list, tuple, str, Mapping)) for one in value):
        return "; ".join(map(str, value)) or "none"
    several = list(value) if isinstance(value, (list, tuple)) else [value]
    return ", ".join(_number(one, factor, error) for one in several) or "none"


def _sizes(figures: Mapping[str, Any], errors: Mapping[str, Any]) -> dict[str, float]:
    """The size by which the unit of each figure is chosen: of a vector its error counts too."""
    sizes = {
        key: _size(value) if _of_balls(value) else _size(value, errors.get(f"{key}{ERROR}"))
        for key, value in figures.items()
    }
    return sizes_for_units(sizes)


def _size(*values) -> float:
    """The greatest size of some numbers and lists of numbers; 0 where there is none."""
    several = [one for value in values for one in (value if isinstance(value, (list, tuple)) else [value])]
    return max((abs(one) for one in several if isinstance(one, float) and math.isfinite(one)), default=0.0)


def _number(value, factor: float, error=None) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        worst = None if error is None else factor * greatest_error(error)
        return known_digits(value * factor, worst, DIGITS) if math.isfinite(value) else "-"
    return str(value)
